//! Convex shapes as a cell describes them, and where they are.

use std::sync::Arc;

use kinematics::Pose;
use kinematics::elementary::hypot;
use nalgebra::Vector3;

/// A convex shape, centred on its own frame. Metres.
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
    /// The half space below z = 0. Nothing that moves with the arm can be one.
    Plane,
    /// The smallest convex body around these points; at least one.
    Hull(Arc<[Vector3<f64>]>),
}

impl Shape {
    /// Radius of the ball around the shape's frame that holds it, m; infinite for a plane.
    pub fn bounding_radius(&self) -> f64 {
        match self {
            Self::Box { half } => Vector3::from(*half).norm(),
            Self::Cylinder {
                radius,
                half_length,
            } => hypot(*radius, *half_length),
            Self::Sphere { radius } => *radius,
            Self::Plane => f64::INFINITY,
            Self::Hull(points) => points.iter().map(Vector3::norm).fold(0.0, f64::max),
        }
    }
}

/// A shape somewhere.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedShape {
    /// Where the shape is: in the frame of whatever it is part of.
    pub pose: Pose,
    /// The shape.
    pub shape: Shape,
}

impl PlacedShape {
    /// A shape at the origin of its owner's frame.
    pub const fn centred(shape: Shape) -> Self {
        Self {
            pose: Pose::IDENTITY,
            shape,
        }
    }
}
