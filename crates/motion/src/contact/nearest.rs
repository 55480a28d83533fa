//! Where two simple convex bodies are nearest or deepest in each other.
//!
//! Signed distances are convex along a straight line, so the nearest place of an edge is found by golden section, or by
//! tangents where the other body has flat faces. Owns
//! geometry only; forces are in `law`, the distances in `solid`.

use core::f64::consts::TAU;
use kinematics::bounds::within;
use kinematics::elementary::{cos, sin};

use kinematics::polytope::Polytope;
use kinematics::{Capsule, Pose};
use nalgebra::Vector3;

use super::solid::{PlacedShape, Shape};

/// A place where two bodies touch or nearly touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ContactPoint {
    /// On the surface of the body that touches, base frame, m.
    pub point: Vector3<f64>,
    /// Unit vector out of the obstacle.
    pub normal: Vector3<f64>,
    /// How deep, m; negative when there is a gap.
    pub depth: f64,
}

/// Whose corner, edge or rim it is that touches the surface of the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Feature {
    /// Of the part of the arm; the radius, m, of one that is a ball, 0 of any other.
    OfBody {
        radius: f64,
    },
    OfObstacle,
}

/// Most places at which two bodies are looked at for one contact: two boxes with their corners and edges have 40. Of
/// polytopes the first ones count.
pub(super) const MAX_FEATURES: usize = 64;

/// Distances of bodies are known this well, m.
const ROUNDING: f64 = 1e-9;
/// Steps of the golden section: an edge is narrowed down to 1e-9 of its length.
const SECTIONS: usize = 44;
/// A minimum is known when no value can be lower by more than this, m.
const TANGENT_GAP: f64 = 1e-10;
/// A line that comes out of a body more steeply than this, in metres a metre, goes through a face and not along it.
const STEEP: f64 = 0.1;
/// Faces are told apart this far from where they meet, m.
const BESIDE: f64 = 1e-8;
/// Samples around a rim, and steps of the golden section between two of them.
const RIM_SAMPLES: u8 = 16;
const RIM_SECTIONS: usize = 30;
/// An inner place of an edge counts beside its ends when it is deeper by this, m.
const DEEPER: f64 = 1e-9;

/// Where a ball touches `obstacle`.
pub(super) fn ball(
    center: Vector3<f64>,
    radius: f64,
    obstacle: &PlacedShape,
    margin: f64,
    found: &mut impl FnMut(ContactPoint),
) {
    let (distance, normal) = obstacle.distance(center);
    let depth = radius - distance;
    if depth > -margin {
        found(ContactPoint {
            point: center - normal * radius,
            normal,
            depth,
        });
    }
}

/// How far a capsule is from `obstacle` at least, m.
pub(super) fn capsule_gap(capsule: &Capsule, obstacle: &PlacedShape) -> f64 {
    let (p0, p1) = (capsule.p0, capsule.p1);
    let length = (p1 - p0).norm();
    obstacle.distance((p0 + p1) / 2.0).0 - length / 2.0 - capsule.radius
}

/// Where a capsule touches `obstacle`: its ends, and the nearest place between them.
pub(super) fn capsule(
    capsule: &Capsule,
    obstacle: &PlacedShape,
    margin: f64,
    found: &mut impl FnMut(ContactPoint),
) {
    let (p0, p1, radius) = (capsule.p0, capsule.p1, capsule.radius);
    let length = (p1 - p0).norm();
    if capsule_gap(capsule, obstacle) > margin {
        return;
    }
    ball(p0, radius, obstacle, margin, found);
    if length < DEEPER {
        return;
    }
    ball(p1, radius, obstacle, margin, found);
    if let Some(p) = inner_minimum(obstacle, p0, p1, margin + radius) {
        ball(p, radius, obstacle, margin, found);
    }
}

/// Where a box, cylinder, ball or polytope touches `obstacle`. Gives how wide the gap between them is at least, m.
pub(super) fn solid(
    body: &PlacedShape,
    obstacle: &PlacedShape,
    margin: f64,
    found: &mut impl FnMut(ContactPoint, Feature),
) -> f64 {
    let gap = body.least_gap(obstacle);
    if gap <= margin + ROUNDING {
        touch(body, obstacle, margin, found);
    }
    gap
}

/// Where two bodies touch that no plane and no ball keeps apart.
fn touch(
    body: &PlacedShape,
    obstacle: &PlacedShape,
    margin: f64,
    found: &mut impl FnMut(ContactPoint, Feature),
) {
    let center = body.pose.translation;
    if let Shape::Sphere { radius } = body.shape {
        let mut of_body = |place| found(place, Feature::OfBody { radius });
        return ball(center, radius, obstacle, margin, &mut of_body);
    }
    if let Shape::Sphere { radius } = obstacle.shape {
        // Seen from the body, and turned round.
        let (distance, out) = body.distance(obstacle.pose.translation);
        if distance - radius < margin {
            let place = ContactPoint {
                point: obstacle.pose.translation - out * distance,
                normal: -out,
                depth: radius - distance,
            };
            found(place, Feature::OfBody { radius: 0.0 });
        }
        return;
    }
    features(body, obstacle, margin, &mut |point, distance, out| {
        let place = ContactPoint {
            point,
            normal: out,
            depth: -distance,
        };
        found(place, Feature::OfBody { radius: 0.0 });
    });
    if obstacle.shape != Shape::Plane {
        features(obstacle, body, margin, &mut |point, distance, out| {
            let place = ContactPoint {
                point,
                normal: -out,
                depth: -distance,
            };
            found(place, Feature::OfObstacle);
        });
    }
}

/// The corners, edges and rims of `body` that come nearest to `other`, within `margin`.
fn features(
    body: &PlacedShape,
    other: &PlacedShape,
    margin: f64,
    found: &mut impl FnMut(Vector3<f64>, f64, Vector3<f64>),
) {
    let mut look = |point| {
        let (distance, out) = other.distance(point);
        if distance < margin {
            found(point, distance, out);
        }
    };
    match body.shape {
        Shape::Box { half } => {
            let corner = |signs: [bool; 3]| {
                let side = |k: usize| if signs[k] { half[k] } else { -half[k] };
                body.pose
                    .transform_point(Vector3::new(side(0), side(1), side(2)))
            };
            let corners: [_; 8] = core::array::from_fn(|number| {
                let point = corner([number & 1 > 0, number & 2 > 0, number & 4 > 0]);
                let (distance, out) = other.distance(point);
                if distance < margin {
                    found(point, distance, out);
                }
                (point, (distance, out))
            });
            for axis in 0..3_usize {
                for number in 0..4_usize {
                    let low = (number & 1) << ((axis + 1) % 3) | (number >> 1) << ((axis + 2) % 3);
                    let (first, at_first) = corners[low];
                    let (last, at_last) = corners[low | 1 << axis];
                    let ends = (at_first, at_last);
                    let inner = inner_minimum_between(other, (first, last), ends, margin);
                    if let Some(point) = inner {
                        let (distance, out) = other.distance(point);
                        if distance < margin {
                            found(point, distance, out);
                        }
                    }
                }
            }
        }
        Shape::Cylinder {
            radius,
            half_length,
        } => {
            let axis = body.pose.rotate(Vector3::z());
            let ends = [1.0, -1.0].map(|side| body.pose.translation + axis * (side * half_length));
            for end in ends {
                let (first, second) = rim(body, end, axis, other);
                look(end + first * radius);
                // Two more places make a flat end stand on three feet.
                let (c, s) = (-0.5, 3.0_f64.sqrt() / 2.0);
                look(end + (first * c + second * s) * radius);
                look(end + (first * c - second * s) * radius);
            }
            let middle = inner_minimum(other, ends[0], ends[1], margin + radius);
            if let Some(middle) = middle {
                let (first, _) = rim(body, middle, axis, other);
                look(middle + first * radius);
            }
        }
        Shape::Polytope(ref polytope) => {
            features_of_polytope(polytope, &body.pose, other, margin, found)
        }
        // Balls and planes have none; they are looked at from the other side.
        Shape::Sphere { .. } | Shape::Plane => {}
    }
}

/// The corners and edges of a polytope that come nearest to `other`, within `margin`.
fn features_of_polytope(
    polytope: &Polytope,
    base_from_polytope: &Pose,
    other: &PlacedShape,
    margin: f64,
    found: &mut impl FnMut(Vector3<f64>, f64, Vector3<f64>),
) {
    let corner = |number: usize| base_from_polytope.transform_point(polytope.points()[number]);
    let mut known = [None::<(f64, Vector3<f64>)>; Polytope::MAX_POINTS];
    let count = polytope.points().len();
    for (number, known) in known.iter_mut().enumerate().take(count) {
        let point = corner(number);
        if !other.may_be_near(point, margin) {
            continue;
        }
        let (distance, out) = other.distance(point);
        *known = Some((distance, out));
        if distance < margin {
            found(point, distance, out);
        }
    }
    for edge in polytope.edges() {
        let [first, last] = edge.ends;
        let ends = (corner(first), corner(last));
        if !other.may_be_near(nearest_of_line(ends, other.pose.translation), margin) {
            continue;
        }
        let at_first = known[first].unwrap_or_else(|| other.distance(ends.0));
        let at_last = known[last].unwrap_or_else(|| other.distance(ends.1));
        if let Some(point) = inner_minimum_between(other, ends, (at_first, at_last), margin) {
            let (distance, out) = other.distance(point);
            if distance < margin {
                found(point, distance, out);
            }
        }
    }
}

/// The place of a line between two points that is nearest to a third one.
fn nearest_of_line((p0, p1): (Vector3<f64>, Vector3<f64>), point: Vector3<f64>) -> Vector3<f64> {
    let along = p1 - p0;
    let share = (point - p0).dot(&along) / along.norm_squared();
    p0 + along * within(share, 0.0, 1.0)
}

/// The direction from `center` across `axis` to the place of the circle that is nearest to `other`, and the one at
/// right angles to it. A circle has no convex distance: it is sampled, then narrowed down around the best sample.
fn rim(
    body: &PlacedShape,
    center: Vector3<f64>,
    axis: Vector3<f64>,
    other: &PlacedShape,
) -> (Vector3<f64>, Vector3<f64>) {
    let radius = match body.shape {
        Shape::Cylinder { radius, .. } => radius,
        _ => 0.0,
    };
    let x = body.pose.rotate(Vector3::x());
    let y = axis.cross(&x);
    let towards = |angle: f64| x * cos(angle) + y * sin(angle);
    let at = |angle: f64| other.distance_alone(center + towards(angle) * radius);
    let (mut best, mut least, mut most) = (0.0, f64::INFINITY, f64::NEG_INFINITY);
    for k in 0..RIM_SAMPLES {
        let angle = TAU * f64::from(k) / f64::from(RIM_SAMPLES);
        let distance = at(angle);
        most = most.max(distance);
        if distance < least {
            (best, least) = (angle, distance);
        }
    }
    // A rim that lies flat touches everywhere alike.
    if most - least > DEEPER {
        let around = TAU / f64::from(RIM_SAMPLES);
        best = golden_section_minimum(best - around, best + around, RIM_SECTIONS, at).0;
    }
    let direction = towards(best);
    (direction, axis.cross(&direction))
}

/// The place strictly between `p0` and `p1` that is nearest to `other`, if it is nearer than both ends and within
/// `margin`.
fn inner_minimum(
    other: &PlacedShape,
    p0: Vector3<f64>,
    p1: Vector3<f64>,
    margin: f64,
) -> Option<Vector3<f64>> {
    let ends = (other.distance(p0), other.distance(p1));
    inner_minimum_between(other, (p0, p1), ends, margin)
}

/// The inner minimum of a line, for ends whose distances and ways out are known. The way out is a slope of the
/// distance, which is convex: a line that goes away from `other` at an end has its minimum there, and the tangents at
/// both ends meet below the minimum.
fn inner_minimum_between(
    other: &PlacedShape,
    (p0, p1): (Vector3<f64>, Vector3<f64>),
    ((first, out0), (last, out1)): ((f64, Vector3<f64>), (f64, Vector3<f64>)),
    margin: f64,
) -> Option<Vector3<f64>> {
    let along = p1 - p0;
    let (leaving, coming) = (out0.dot(&along), out1.dot(&along));
    if other.shape == Shape::Plane || leaving >= 0.0 || coming <= 0.0 {
        return None;
    }
    let meeting = (last - first - coming) / (leaving - coming);
    let bound = first + leaving * meeting;
    // A minimum that is hardly lower than an end would not count either; of an edge that lies flat none is.
    if bound > margin || bound > first.min(last) - DEEPER / 2.0 {
        return None;
    }
    let at = |t: f64| {
        let (distance, out) = other.distance(p0 + along * t);
        (distance, out.dot(&along))
    };
    let (t, least) = match other.shape {
        Shape::Polytope(_) => minimum_of_tangents((first, leaving), (last, coming), at),
        _ => golden_section_minimum(0.0, 1.0, SECTIONS, |t| other.distance_alone(p0 + along * t)),
    };
    (least < first.min(last) - DEEPER && least < margin)
        .then(|| p0 + along * flatter_side(t, along.norm(), at))
}

/// The minimum, or a place beside it where two faces of the other body meet there: on the side of the face that the
/// line goes along, for that is the one which it touches. `at` gives distance and slope.
fn flatter_side(t: f64, length: f64, at: impl Fn(f64) -> (f64, f64)) -> f64 {
    let slope = at(t).1;
    if slope.abs() < STEEP * length {
        return t;
    }
    let beside = t - BESIDE.copysign(slope) / length;
    if at(beside).1.abs() < slope.abs() {
        beside
    } else {
        t
    }
}

/// Where between 0 and 1 a convex function has its minimum, and the minimum. The function tells a slope with every
/// value; those at 0 and 1 are known. Where the tangents at the ends of the bracket meet is looked at next: of a
/// function with flat pieces, which distances from polytopes are, that is soon the minimum itself.
fn minimum_of_tangents(
    mut low: (f64, f64),
    mut high: (f64, f64),
    at: impl Fn(f64) -> (f64, f64),
) -> (f64, f64) {
    let (mut t_low, mut t_high) = (0.0, 1.0);
    let mut best = if low.0 <= high.0 {
        (t_low, low.0)
    } else {
        (t_high, high.0)
    };
    for round in 0..SECTIONS {
        let width = t_high - t_low;
        let meeting = (high.0 - low.0 - high.1 * width) / (low.1 - high.1);
        let bound = low.0 + low.1 * meeting;
        if !(best.1 - bound > TANGENT_GAP && width > f64::EPSILON) {
            break;
        }
        // Every third time the middle: it halves the bracket whatever the function is.
        let t = match round % 3 {
            2 => t_low + width / 2.0,
            _ => t_low + meeting,
        };
        let (value, slope) = at(t);
        if value < best.1 {
            best = (t, value);
        }
        if slope < 0.0 {
            (t_low, low) = (t, (value, slope));
        } else {
            (t_high, high) = (t, (value, slope));
        }
        if slope == 0.0 {
            break;
        }
    }
    best
}

/// Where between `low` and `high` a function with one minimum has it, and the minimum: golden section.
fn golden_section_minimum(
    mut low: f64,
    mut high: f64,
    sections: usize,
    at: impl Fn(f64) -> f64,
) -> (f64, f64) {
    let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
    let width = high - low;
    let (mut a, mut b) = (high - golden * width, low + golden * width);
    let (mut at_a, mut at_b) = (at(a), at(b));
    for _ in 0..sections {
        if at_a <= at_b {
            high = b;
            (b, at_b) = (a, at_a);
            a = high - golden * (high - low);
            at_a = at(a);
        } else {
            low = a;
            (a, at_a) = (b, at_b);
            b = low + golden * (high - low);
            at_b = at(b);
        }
    }
    if at_a <= at_b { (a, at_a) } else { (b, at_b) }
}

#[cfg(test)]
mod tests {
    use super::super::test_bodies;
    use super::*;
    use kinematics::RpyPose;
    use proptest::prelude::*;

    fn shape() -> impl Strategy<Value = Shape> {
        let length = 0.02..0.5_f64;
        prop_oneof![
            [length.clone(), length.clone(), length.clone()].prop_map(|half| Shape::Box { half }),
            (length.clone(), length.clone()).prop_map(|(radius, half_length)| Shape::Cylinder {
                radius,
                half_length
            }),
            length.clone().prop_map(|radius| Shape::Sphere { radius }),
            Just(Shape::Plane),
            [length.clone(), length.clone(), length.clone()].prop_map(test_bodies::block),
            (length.clone(), length)
                .prop_map(|(radius, half)| test_bodies::faceted_cylinder(radius, half)),
        ]
    }

    fn placed(shape: impl Strategy<Value = Shape>) -> impl Strategy<Value = PlacedShape> {
        let pose = (
            prop::array::uniform3(-1.0..1.0_f64),
            prop::array::uniform3(-3.0..3.0_f64),
        );
        (shape, pose).prop_map(|(shape, (xyz, rpy))| PlacedShape {
            pose: Pose::from_rpy(&RpyPose { xyz, rpy }),
            shape,
        })
    }

    fn deepest(body: &PlacedShape, obstacle: &PlacedShape, margin: f64) -> Option<ContactPoint> {
        let mut most: Option<ContactPoint> = None;
        solid(body, obstacle, margin, &mut |place, _| {
            if most.is_none_or(|m| m.depth < place.depth) {
                most = Some(place);
            }
        });
        most
    }

    /// A point on or in a body, by three numbers from -1 to 1.
    fn surface_point(shape: &Shape, u: f64, v: f64, c: f64) -> Vector3<f64> {
        match *shape {
            Shape::Polytope(ref body) => {
                // Between two corners and the middle.
                let corners = body.points();
                let corner = |t: f64| {
                    corners[((t + 1.0) / 2.0 * (corners.len() - 1) as f64).round() as usize]
                };
                (corner(u) + (corner(v) - corner(u)) * c.abs()) * c.abs().sqrt()
            }
            Shape::Box { half } => Vector3::new(u * half[0], v * half[1], c * half[2]),
            Shape::Cylinder {
                radius,
                half_length,
            } => {
                let angle = 3.2 * u;
                Vector3::new(
                    v * radius * angle.cos(),
                    v * radius * angle.sin(),
                    c * half_length,
                )
            }
            Shape::Sphere { radius } => {
                let p = Vector3::new(u, v, c);
                if p.norm() > 0.0 {
                    p * (radius / p.norm())
                } else {
                    p
                }
            }
            Shape::Plane => Vector3::zeros(),
        }
    }

    #[test]
    fn bodies_beside_each_other_are_apart_by_the_gap_between_their_faces() {
        let at = |x: f64, shape: Shape| PlacedShape {
            pose: Pose::from_translation(x, 0.0, 0.0),
            shape,
        };
        let cube = Shape::Box { half: [0.1; 3] };
        let long = Shape::Cylinder {
            radius: 0.05,
            half_length: 1.0,
        };
        for (body, other, gap) in [
            (at(0.0, cube.clone()), at(0.3, cube.clone()), 0.1),
            (at(0.0, cube.clone()), at(0.3, long.clone()), 0.15),
            (at(0.3, long.clone()), at(0.0, cube.clone()), 0.15),
        ] {
            assert!((body.least_gap(&other) - gap).abs() < 1e-12, "{body:?}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        #[test]
        fn the_way_out_leads_to_the_surface(
            body in placed(shape()),
            point in prop::array::uniform3(-1.5..1.5_f64),
        ) {
            let point = Vector3::from(point);
            let (distance, out) = body.distance(point);
            prop_assert!((out.norm() - 1.0).abs() < 1e-12);
            let (left, _) = body.distance(point - out * distance);
            prop_assert!(left.abs() < 1e-9, "{left}");
            // Nowhere is the surface nearer.
            for direction in [Vector3::x(), Vector3::y(), Vector3::z(), -out] {
                let (there, _) = body.distance(point + direction * (0.5 * distance.abs()));
                prop_assert!(there * distance >= -1e-12);
            }
        }

        #[test]
        fn the_distance_alone_is_the_same_to_the_last_bit(
            body in placed(shape()),
            point in prop::array::uniform3(-1.5..1.5_f64),
        ) {
            let point = Vector3::from(point);
            let alone = body.distance_alone(point);
            prop_assert_eq!(alone.to_bits(), body.distance(point).0.to_bits());
        }

        #[test]
        fn an_edge_has_an_inner_minimum_just_where_the_whole_search_finds_one(
            body in placed(shape()),
            (first, last) in (prop::array::uniform3(-1.0..1.0_f64), prop::array::uniform3(-1.0..1.0_f64)),
            is_flat in any::<bool>(),
        ) {
            let p0 = Vector3::from(first);
            let mut p1 = Vector3::from(last);
            if is_flat {
                // Along the face that is nearest to its beginning.
                let (_, out) = body.distance(p0);
                p1 -= out * (p1 - p0).dot(&out);
            }
            let at = |t: f64| body.distance(p0 + (p1 - p0) * t).0;
            let (_, least) = golden_section_minimum(0.0, 1.0, SECTIONS, at);
            let lower = at(0.0).min(at(1.0)) - least;
            let inner = inner_minimum(&body, p0, p1, f64::INFINITY);
            // What is within the last digits of the threshold may be either.
            if (lower - DEEPER).abs() > DEEPER / 10.0 {
                prop_assert_eq!(inner.is_some(), lower > DEEPER, "{} lower", lower);
            }
        }

        #[test]
        fn a_tool_that_is_moved_out_by_the_depth_just_touches(
            tool in placed(shape().prop_filter("tools have a size", |s| *s != Shape::Plane)),
            obstacle in placed(Just(Shape::Plane)),
        ) {
            // Against a plane everything is exact.
            let (height, normal) = obstacle.distance(tool.pose.translation);
            let near = PlacedShape {
                pose: Pose::new(tool.pose.rotation, tool.pose.translation - normal * height),
                shape: tool.shape,
            };
            let place = deepest(&near, &obstacle, 1e-9).expect("its middle is in the plane");
            prop_assert!(place.depth > 0.0);
            let shifted = PlacedShape {
                pose: Pose::new(near.pose.rotation, near.pose.translation + normal * place.depth),
                shape: near.shape,
            };
            let touching = deepest(&shifted, &obstacle, 1e-6).expect("it touches");
            prop_assert!(touching.depth.abs() < 1e-9, "{}", touching.depth);
        }

        /// Nothing of one body is nearer to the other than the least gap says.
        #[test]
        fn the_least_gap_is_never_too_wide(
            body in placed(shape().prop_filter("tools have a size", |s| *s != Shape::Plane)),
            obstacle in placed(shape()),
            apart in 0.0..1.5_f64,
        ) {
            let (_, out) = obstacle.distance(body.pose.translation);
            let mut body = body;
            body.pose.translation += out * apart;
            let gap = body.least_gap(&obstacle);
            let mut nearest = f64::INFINITY;
            for a in -12..=12_i32 {
                for b in -12..=12_i32 {
                    for c in [-1.0, -0.5, 0.0, 0.5, 1.0] {
                        let local = surface_point(&body.shape, f64::from(a) / 12.0, f64::from(b) / 12.0, c);
                        nearest = nearest.min(obstacle.distance(body.pose.transform_point(local)).0);
                    }
                }
            }
            prop_assert!(gap <= nearest + 1e-9, "{gap} {nearest}");
            // What lies within the gap is found as it is without it.
            if let Some(place) = deepest(&body, &obstacle, 0.1) {
                prop_assert!(gap <= -place.depth + 1e-9, "{gap} {}", place.depth);
            }
        }

        /// Points of the surface of one body inside the other are never deeper than what is found, but for the
        /// sampling.
        #[test]
        fn no_point_of_a_tool_lies_deeper_than_what_is_found(
            tool in placed(shape().prop_filter("tools have a size", |s| *s != Shape::Plane)),
            obstacle in placed(shape()),
            towards in 0.3..1.0_f64,
        ) {
            // Brought together until they overlap a little.
            let (distance, out) = obstacle.distance(tool.pose.translation);
            prop_assume!(distance > 0.0);
            let mut tool = tool;
            tool.pose.translation += out * 1.5;
            let mut place = None;
            for _ in 0..600 {
                place = deepest(&tool, &obstacle, 1e-9);
                if place.is_some_and(|p| p.depth > 0.0) {
                    break;
                }
                tool.pose.translation -= out * 0.005 * towards;
            }
            prop_assume!(place.is_some());
            let found = place.map_or(0.0, |p| p.depth);
            for a in -10..=10_i32 {
                for b in -10..=10_i32 {
                    for c in [-1.0, -0.5, 0.0, 0.5, 1.0] {
                        let local = surface_point(&tool.shape, f64::from(a) / 10.0, f64::from(b) / 10.0, c);
                        let (distance, _) = obstacle.distance(tool.pose.transform_point(local));
                        // A step of the approach is 5 mm: that deep at most, and rims of cylinders within a tenth of
                        // it.
                        prop_assert!(-distance <= found + 5e-4, "{distance} {found}");
                    }
                }
            }
        }
    }

    #[test]
    fn crossed_edges_meet_between_their_ends() {
        let half = [0.5, 0.02, 0.02];
        let beam = |z: f64, turn: f64| PlacedShape {
            pose: Pose::from_rpy(&RpyPose::from_array([
                0.0,
                0.0,
                z,
                core::f64::consts::FRAC_PI_4,
                0.0,
                turn,
            ])),
            shape: Shape::Box { half },
        };
        let (lower, upper) = (beam(0.0, 0.0), beam(0.056, 1.5));
        let place = deepest(&upper, &lower, 0.01).unwrap();
        let height = 0.02 * 2.0_f64.sqrt();
        assert!(
            (place.depth - (2.0 * height - 0.056) * core::f64::consts::FRAC_1_SQRT_2).abs() < 1e-6,
            "{place:?}"
        );
        assert!(place.point.xy().norm() < 1e-3, "{place:?}");
    }

    #[test]
    fn a_capsule_across_a_beam_touches_in_its_middle() {
        let beam = PlacedShape {
            pose: Pose::IDENTITY,
            shape: Shape::Box {
                half: [0.5, 0.02, 0.02],
            },
        };
        let bar = Capsule {
            p0: Vector3::new(0.1, -0.4, 0.05),
            p1: Vector3::new(0.1, 0.5, 0.041),
            radius: 0.03,
        };
        let mut places = Vec::new();
        capsule(&bar, &beam, 1e-3, &mut |place| places.push(place));
        let [place] = places[..] else {
            panic!("{places:?}");
        };
        assert!(
            (place.point.y - 0.02).abs() < 2e-3 && (place.normal.z - 1.0).abs() < 1e-3,
            "{place:?}"
        );
        assert!(place.depth > 0.004 && place.depth < 0.006, "{place:?}");
    }
}
