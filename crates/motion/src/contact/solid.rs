//! Simple convex bodies and the signed distance of a point from their surface.
//!
//! The distances are exact, and along a straight line convex; where two bodies touch is found with them, in `nearest`.

use kinematics::Pose;
use kinematics::elementary::hypot;
use nalgebra::Vector3;

/// A shape, centred on its own frame. Metres.
#[derive(Clone, Copy, Debug, PartialEq)]
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
#[derive(Clone, Copy, Debug, PartialEq)]
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
            shape: self.shape,
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
        };
        (distance, self.pose.rotate(out))
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
        }
    }

    /// A lower bound of the distance to another solid, m: by the planes along the faces of both, and by the balls
    /// around them. Negative or too small where only an edge parts them.
    pub(super) fn least_gap(&self, other: &Self) -> f64 {
        let way = other.pose.translation - self.pose.translation;
        let along = |normal: Vector3<f64>| {
            way.dot(&normal).abs() - self.half_width(&normal) - other.half_width(&normal)
        };
        let by_balls = other.distance(self.pose.translation).0 - self.bounding_radius();
        [self, other].into_iter().fold(by_balls, |gap, solid| {
            let axes = solid.pose.rotation.matrix();
            match solid.shape {
                Shape::Box { .. } => axes
                    .column_iter()
                    .fold(gap, |gap, axis| gap.max(along(axis.into_owned()))),
                Shape::Cylinder { .. } => gap.max(along(axes.column(2).into_owned())),
                Shape::Plane if core::ptr::eq(solid, other) => {
                    let normal = axes.column(2).into_owned();
                    gap.max(-way.dot(&normal) - self.half_width(&normal))
                }
                Shape::Sphere { .. } | Shape::Plane => gap,
            }
        })
    }

    /// How far it reaches from its middle along a unit vector, m; infinite for a plane.
    fn half_width(&self, normal: &Vector3<f64>) -> f64 {
        let n = self.pose.rotate_back(*normal);
        match self.shape {
            Shape::Box { half } => (0..3).map(|k| half[k] * n[k].abs()).sum(),
            Shape::Cylinder {
                radius,
                half_length,
            } => half_length * n.z.abs() + radius * hypot(n.x, n.y),
            Shape::Sphere { radius } => radius,
            Shape::Plane => f64::INFINITY,
        }
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
        }
    }
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
