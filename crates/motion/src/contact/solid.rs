//! Simple convex bodies and the signed distance of a point from their surface.
//!
//! The distances are exact, and along a straight line convex; where two bodies touch is found with them, in `nearest`.

use std::sync::Arc;

use kinematics::Pose;
use kinematics::elementary::hypot;
use kinematics::polytope::{Face, Polytope};
use nalgebra::Vector3;

/// Faces of a polytope whose normals have a product above this are one rounded surface: 16 facets around are, a chamfer
/// of 30 degrees is not.
const ROUNDED_COSINE: f64 = 0.9;
/// Faces whose normals have a product below this look away from each other.
const OPPOSITE_COSINE: f64 = -0.5;
/// And below this product they are of different kinds, as the sides of a box are.
const DIFFERENT_COSINE: f64 = 0.5;

/// A shape. All but a polytope are centred on their own frame. Metres.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Edges along the axes.
    Box {
        /// Half of each edge.
        half: [f64; 3],
    },
    /// A cylinder whose axis is z.
    Cylinder {
        /// Radius.
        radius: f64,
        /// Half of the cylinder's length.
        half_length: f64,
    },
    /// A ball.
    Sphere {
        /// Radius.
        radius: f64,
    },
    /// The half space below z = 0.
    Plane,
    /// A convex body with flat faces, of a mesh for instance.
    Polytope(Arc<Polytope>),
}

/// A way out of a solid.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceExit {
    /// Of the surface, m, negative inside.
    pub distance: f64,
    /// Unit vector out.
    pub normal: Vector3<f64>,
    /// How far it is from this face to the one opposite, m.
    pub width: f64,
}

/// A shape somewhere.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedShape {
    /// Where the solid is: in the base frame for obstacles, in the flange frame for tools.
    pub pose: Pose,
    /// The shape of the solid.
    pub shape: Shape,
}

impl PlacedShape {
    /// The solid as seen from frame a instead of frame b.
    pub(super) fn expressed_in(&self, a_from_b: &Pose) -> Self {
        Self {
            pose: *a_from_b * self.pose,
            shape: self.shape.clone(),
        }
    }

    /// Distance of `point` from the surface, m, negative inside, and the unit vector that leads out the shortest way.
    pub fn distance(&self, point: Vector3<f64>) -> (f64, Vector3<f64>) {
        let p = self.pose.rotate_back(point - self.pose.translation);
        let (distance, out) = match self.shape {
            Shape::Box { half } => from_box(p, half.into()),
            Shape::Cylinder {
                radius,
                half_length,
            } => from_cylinder(p, radius, half_length),
            Shape::Sphere { radius } => {
                let norm = p.norm();
                let out = if norm > 0.0 { p / norm } else { Vector3::z() };
                (norm - radius, out)
            }
            Shape::Plane => (p.z, Vector3::z()),
            Shape::Polytope(ref body) => body.distance(&p),
        };
        (distance, self.pose.rotate(out))
    }

    /// [`distance`](Self::distance) to the last bit without the way out, which takes as long again.
    #[inline]
    pub(super) fn distance_alone(&self, point: Vector3<f64>) -> f64 {
        match self.shape {
            Shape::Box { half } => {
                let p = self.pose.rotate_back(point - self.pose.translation);
                let over = p.abs() - Vector3::from(half);
                let distance = over.map(|x| x.max(0.0)).norm();
                if distance > 0.0 {
                    distance
                } else {
                    over[over.imax()]
                }
            }
            _ => self.distance(point).0,
        }
    }

    /// Whether a point can be nearer to the surface than `margin`, m, or inside: by the ball around the solid, so that
    /// the many pieces of meshes that are elsewhere cost next to nothing.
    pub(super) fn may_be_near(&self, point: Vector3<f64>, margin: f64) -> bool {
        let reach = self.bounding_radius() + margin;
        (point - self.pose.translation).norm_squared() <= reach * reach
    }

    /// The ways out of the solid from `point`, each as [`distance`](Self::distance) gives it: through the nearest face
    /// of every kind from inside, the one way to the surface from outside.
    pub(super) fn exits(&self, point: Vector3<f64>) -> [Option<(f64, Vector3<f64>)>; 3] {
        let nearest = self.distance(point);
        if nearest.0 >= 0.0 {
            return [Some(nearest), None, None];
        }
        let p = self.pose.rotate_back(point - self.pose.translation);
        match self.shape {
            Shape::Box { half } => core::array::from_fn(|axis| {
                let mut out = Vector3::zeros();
                out[axis] = 1.0_f64.copysign(p[axis]);
                Some((p[axis].abs() - half[axis], self.pose.rotate(out)))
            }),
            Shape::Cylinder { half_length, .. } => {
                let end = Vector3::z() * 1.0_f64.copysign(p.z);
                let through_end = (p.z.abs() - half_length, self.pose.rotate(end));
                [Some(nearest), Some(through_end), None]
            }
            Shape::Sphere { .. } | Shape::Plane => [Some(nearest), None, None],
            Shape::Polytope(ref body) => {
                let first = body.nearest_plane(&p);
                let second = nearest_face(body, &p, |face| is_different(face, first.0));
                let third = second.and_then(|second| {
                    let is_third =
                        |face: &Face| is_different(face, first.0) && is_different(face, second.0);
                    nearest_face(body, &p, is_third)
                });
                [Some(first), second, third].map(|exit| {
                    exit.map(|(face, distance)| (distance, self.pose.rotate(face.normal)))
                })
            }
        }
    }

    /// The way out of the solid from a `point` through the face that `towards` (in the solid's frame) belongs to,
    /// however far that is, as [`distance`](Self::distance) gives it; `None` for a point that is not beneath that face.
    /// A rounded face is followed around while the point is nearer to it than to the middle; deeper it is left along
    /// `towards`.
    pub(super) fn exit_towards(
        &self,
        point: Vector3<f64>,
        towards: Vector3<f64>,
    ) -> Option<(f64, Vector3<f64>)> {
        let p = self.pose.rotate_back(point - self.pose.translation);
        let through_face = |axis: usize, half: f64| {
            let mut out = Vector3::zeros();
            out[axis] = 1.0_f64.copysign(towards[axis]);
            (p[axis] * out[axis] - half, out)
        };
        let (distance, out) = match self.shape {
            Shape::Box { half } => {
                let axis = towards.iamax();
                let is_beside = (0..3).any(|k| k != axis && p[k].abs() > half[k]);
                (!is_beside).then(|| through_face(axis, half[axis]))?
            }
            Shape::Cylinder {
                radius,
                half_length,
            } => {
                let aside = Vector3::new(towards.x, towards.y, 0.0);
                if towards.z.abs() >= aside.norm() {
                    let is_beside = hypot(p.x, p.y) > radius;
                    (!is_beside).then(|| through_face(2, half_length))?
                } else if p.z.abs() > half_length {
                    return None;
                } else {
                    exit_from_ball(Vector3::new(p.x, p.y, 0.0), radius, aside.normalize())?
                }
            }
            Shape::Sphere { radius } => exit_from_ball(p, radius, towards)?,
            Shape::Plane => (p.z, Vector3::z()),
            Shape::Polytope(ref body) => {
                let (face, distance) = face_towards(body, &p, &towards)?;
                let is_beside = body.faces().iter().any(|other| {
                    other.normal.dot(&face.normal) > OPPOSITE_COSINE && other.distance(p) > 0.0
                });
                (!is_beside).then_some((distance, face.normal))?
            }
        };
        (distance < 0.0).then(|| (distance, self.pose.rotate(out)))
    }

    /// The ways out of the solid from a `point` beneath the face that `towards` (in the solid's frame) belongs to,
    /// through the nearest faces that meet that one in an edge.
    pub(super) fn exits_beside(
        &self,
        point: Vector3<f64>,
        towards: Vector3<f64>,
    ) -> [Option<SurfaceExit>; 2] {
        let p = self.pose.rotate_back(point - self.pose.translation);
        let through = |axis: usize, half: f64| {
            let mut out = Vector3::zeros();
            out[axis] = 1.0_f64.copysign(p[axis]);
            SurfaceExit {
                distance: p[axis].abs() - half,
                normal: self.pose.rotate(out),
                width: 2.0 * half,
            }
        };
        match self.shape {
            Shape::Box { half } => {
                let axis = towards.iamax();
                [1, 2].map(|more| {
                    let beside = (axis + more) % 3;
                    Some(through(beside, half[beside]))
                })
            }
            Shape::Cylinder {
                radius,
                half_length,
            } => {
                if towards.z.abs() < hypot(towards.x, towards.y) {
                    return [Some(through(2, half_length)), None];
                }
                let rho = hypot(p.x, p.y);
                let side = (rho > 0.0).then(|| SurfaceExit {
                    distance: rho - radius,
                    normal: self.pose.rotate(Vector3::new(p.x / rho, p.y / rho, 0.0)),
                    width: 2.0 * radius,
                });
                [side, None]
            }
            Shape::Sphere { .. } | Shape::Plane => [None, None],
            Shape::Polytope(ref body) => {
                let Some((face, _)) = face_towards(body, &p, &towards) else {
                    return [None, None];
                };
                let meets = |other: &Face| {
                    let along = other.normal.dot(&face.normal);
                    along < ROUNDED_COSINE && along > -ROUNDED_COSINE
                };
                let first = nearest_face(body, &p, meets);
                let second = first.and_then(|first| {
                    nearest_face(body, &p, |face| meets(face) && is_different(face, first.0))
                });
                [first, second].map(|exit| {
                    exit.map(|(face, distance)| SurfaceExit {
                        distance,
                        normal: self.pose.rotate(face.normal),
                        width: body.reach(&face.normal) + body.reach(&-face.normal),
                    })
                })
            }
        }
    }

    /// True when the nearest place of the surface, seen from a point outside, is on an edge, a corner or a rim.
    pub(super) fn is_nearest_at_an_edge(&self, point: Vector3<f64>) -> bool {
        let p = self.pose.rotate_back(point - self.pose.translation);
        match self.shape {
            Shape::Box { half } => (0..3).filter(|&axis| p[axis].abs() > half[axis]).count() > 1,
            Shape::Cylinder {
                radius,
                half_length,
            } => hypot(p.x, p.y) > radius && p.z.abs() > half_length,
            Shape::Sphere { .. } | Shape::Plane => false,
            Shape::Polytope(ref body) => {
                let (distance, _) = body.distance(&p);
                body.nearest_plane(&p).1 < distance
            }
        }
    }

    /// A lower bound of the distance to another solid, m: by the planes along the faces of both, and by the balls
    /// around them. Negative or too small where only an edge parts them.
    pub(super) fn least_gap(&self, other: &Self) -> f64 {
        let by_balls = other.distance(self.pose.translation).0 - self.bounding_radius();
        by_balls
            .max(self.gap_along_faces(other))
            .max(other.gap_along_faces(self))
    }

    /// The widest gap between the plane of a face and another solid, m.
    fn gap_along_faces(&self, other: &Self) -> f64 {
        let way = other.pose.translation - self.pose.translation;
        let along =
            |normal: Vector3<f64>| way.dot(&normal) - self.reach(&normal) - other.reach(&-normal);
        let both_ways = |axis: Vector3<f64>| along(axis).max(along(-axis));
        let axes = self.pose.rotation.matrix();
        match &self.shape {
            Shape::Box { .. } => axes
                .column_iter()
                .map(|axis| both_ways(axis.into_owned()))
                .fold(f64::NEG_INFINITY, f64::max),
            Shape::Cylinder { .. } => both_ways(axes.column(2).into_owned()),
            Shape::Plane => {
                let normal = axes.column(2).into_owned();
                way.dot(&normal) - other.reach(&-normal)
            }
            Shape::Sphere { .. } => f64::NEG_INFINITY,
            Shape::Polytope(body) => {
                let (way_here, radius) = (self.pose.rotate_back(way), other.bounding_radius());
                body.faces().iter().fold(f64::NEG_INFINITY, |widest, face| {
                    let middle = way_here.dot(&face.normal) - face.offset;
                    // However the other body lies, it ends no farther from its middle than its radius.
                    if middle + radius <= widest {
                        return widest;
                    }
                    widest.max(middle - other.reach(&-self.pose.rotate(face.normal)))
                })
            }
        }
    }

    /// How far it reaches from the origin of its frame along a unit vector, m; infinite for a plane.
    fn reach(&self, direction: &Vector3<f64>) -> f64 {
        let n = self.pose.rotate_back(*direction);
        match self.shape {
            Shape::Box { half } => (0..3).map(|k| half[k] * n[k].abs()).sum(),
            Shape::Cylinder {
                radius,
                half_length,
            } => half_length * n.z.abs() + radius * hypot(n.x, n.y),
            Shape::Sphere { radius } => radius,
            Shape::Plane => f64::INFINITY,
            Shape::Polytope(ref body) => body.reach(&n),
        }
    }

    /// How far its farthest point is from the origin of the frame that it is placed in, at most, m; infinite for a
    /// plane.
    pub(super) fn extent(&self) -> f64 {
        self.pose.translation.norm() + self.bounding_radius()
    }

    /// Radius of the ball around the origin of its frame that holds it, m; infinite for a plane.
    pub(super) fn bounding_radius(&self) -> f64 {
        match self.shape {
            Shape::Box { half } => Vector3::from(half).norm(),
            Shape::Cylinder {
                radius,
                half_length,
            } => hypot(radius, half_length),
            Shape::Sphere { radius } => radius,
            Shape::Plane => f64::INFINITY,
            Shape::Polytope(ref body) => body.bounding_radius(),
        }
    }
}

/// The face that is nearest to a point, among those that count, and the distance from its plane, m.
fn nearest_face<'a>(
    body: &'a Polytope,
    point: &Vector3<f64>,
    counts: impl Fn(&Face) -> bool,
) -> Option<(&'a Face, f64)> {
    let faces = body.faces().iter().filter(|face| counts(face));
    faces
        .map(|face| (face, face.distance(*point)))
        .max_by(|a, b| a.1.total_cmp(&b.1))
}

/// The face that a direction belongs to: of a rounded surface the one that is nearest to the point.
fn face_towards<'a>(
    body: &'a Polytope,
    point: &Vector3<f64>,
    towards: &Vector3<f64>,
) -> Option<(&'a Face, f64)> {
    nearest_face(body, point, |face| {
        face.normal.dot(towards) > ROUNDED_COSINE
    })
    .or_else(|| {
        let faces = body.faces().iter();
        let best = faces.max_by(|a, b| a.normal.dot(towards).total_cmp(&b.normal.dot(towards)))?;
        Some((best, best.distance(*point)))
    })
}

/// Whether two faces have as little in common as the sides of a box.
fn is_different(a: &Face, b: &Face) -> bool {
    a.normal.dot(&b.normal) < DIFFERENT_COSINE
}

/// The way out of a ball, or of a circle, around the origin from `p`; `towards` is the one before. `None` beside it.
fn exit_from_ball(
    p: Vector3<f64>,
    radius: f64,
    towards: Vector3<f64>,
) -> Option<(f64, Vector3<f64>)> {
    let from_middle = p.norm();
    let along = p.dot(&towards);
    if from_middle > radius / 2.0 && along > 0.0 {
        return Some((from_middle - radius, p / from_middle));
    }
    let rest = radius * radius - from_middle * from_middle + along * along;
    (rest > 0.0).then(|| (along - rest.sqrt(), towards))
}

/// Distance from a box and the way out, in its frame.
fn from_box(p: Vector3<f64>, half: Vector3<f64>) -> (f64, Vector3<f64>) {
    let over = p.abs() - half;
    let outside = over.map(|x| x.max(0.0));
    let distance = outside.norm();
    if distance > 0.0 {
        let out = outside.zip_map(&p, |x, side| x.copysign(side) / distance);
        return (distance, out);
    }
    let axis = over.imax();
    let mut out = Vector3::zeros();
    out[axis] = 1.0_f64.copysign(p[axis]);
    (over[axis], out)
}

/// Distance from a cylinder and the way out, in its frame.
fn from_cylinder(p: Vector3<f64>, radius: f64, half_length: f64) -> (f64, Vector3<f64>) {
    let rho = hypot(p.x, p.y);
    let aside = if rho > 0.0 {
        Vector3::new(p.x / rho, p.y / rho, 0.0)
    } else {
        Vector3::x()
    };
    let along = Vector3::z() * 1.0_f64.copysign(p.z);
    let (side, end) = (rho - radius, p.z.abs() - half_length);
    if side <= 0.0 && end <= 0.0 {
        return if side > end {
            (side, aside)
        } else {
            (end, along)
        };
    }
    let (side, end) = (side.max(0.0), end.max(0.0));
    let distance = hypot(side, end);
    (distance, (aside * side + along * end) / distance)
}
