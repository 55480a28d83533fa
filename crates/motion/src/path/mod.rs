//! Geometric paths of the whole arm, without time: where the joints are at each place s of the way.
//!
//! A [`Path`] is one leg or one blend; a [`Chain`] is what a motion follows: one path, or the rest of one, a blend and the
//! next.

mod cartesian;
mod chain;
mod joint_line;
mod quintic;

pub use cartesian::{ArcOrientation, CartesianPath, NoArc};
pub use chain::{Chain, Piece};
pub use joint_line::JointLine;
pub use quintic::{JointQuintic, QuinticPoint};

use kinematics::{JointPositions, RobotModel};

use crate::scalar::ScalarState;
use crate::setpoint::Setpoint;

/// The joints at one place of a path, and their derivatives with respect to s.
#[derive(Clone, Copy, Debug)]
pub struct PathPoint {
    /// Place, unit of s.
    pub s: f64,
    /// Positions, rad.
    pub q: JointPositions,
    /// dq/ds.
    pub first: [f64; 6],
    /// d²q/ds².
    pub second: [f64; 6],
}

/// A way from one place to another.
#[allow(
    clippy::large_enum_variant,
    reason = "lives in place inside the cycle, which must not allocate"
)]
#[derive(Clone, Copy, Debug)]
pub enum Path {
    /// A straight line in joint space; s in rad of the leading joint.
    Joint(JointLine),
    /// A line or an arc of the TCP; s in m.
    Cartesian(CartesianPath),
    /// A blend between two paths; s in the unit of the chain it belongs to.
    Blend(JointQuintic),
}

impl Path {
    /// The setpoint at a state of s, in the branch of solutions that `near` belongs to. `None` when the inverse
    /// kinematics has no solution there.
    pub fn at(
        &self,
        model: &RobotModel,
        s: &ScalarState,
        near: &JointPositions,
    ) -> Option<Setpoint> {
        match self {
            Self::Joint(line) => Some(line.at(s)),
            Self::Cartesian(line) => line.at(model, s, near),
            Self::Blend(blend) => Some(blend.at(s)),
        }
    }

    /// Joints and derivatives at s, in the branch of solutions that `near` belongs to.
    pub fn point(&self, model: &RobotModel, s: f64, near: &JointPositions) -> Option<PathPoint> {
        match self {
            Self::Joint(line) => Some(PathPoint {
                s,
                q: line.positions(s),
                first: line.direction().0,
                second: [0.0; 6],
            }),
            Self::Cartesian(path) => {
                let q = path.positions(model, s, near)?;
                path.point(model, s, q)
            }
            Self::Blend(blend) => {
                let point = blend.point(s);
                Some(PathPoint {
                    s,
                    q: JointPositions(point.q),
                    first: point.first,
                    second: point.second,
                })
            }
        }
    }

    /// How long it is, unit of s.
    pub fn length(&self) -> f64 {
        match self {
            Self::Joint(line) => line.length(),
            Self::Cartesian(path) => path.length(),
            Self::Blend(blend) => blend.length(),
        }
    }

    /// Where it ends: exactly the target, at rest.
    pub fn end(&self) -> Setpoint {
        Setpoint::standing(match self {
            Self::Joint(line) => line.end(),
            Self::Cartesian(line) => line.end(),
            Self::Blend(blend) => JointPositions(blend.point(blend.length()).q),
        })
    }
}
