//! Geometric paths of the whole arm, without time: where the joints are at each place s of the way.

mod cartesian_line;
mod joint_line;

pub use cartesian_line::{CartesianLine, LinePoint};
pub use joint_line::JointLine;

use kinematics::{JointPositions, RobotModel};

use crate::scalar::ScalarState;
use crate::setpoint::Setpoint;

/// A way from rest to rest.
#[allow(
    clippy::large_enum_variant,
    reason = "lives in place inside the cycle, which must not allocate"
)]
#[derive(Clone, Copy, Debug)]
pub enum Path {
    /// A straight line in joint space.
    Joint(JointLine),
    /// A straight line of the TCP.
    Cartesian(CartesianLine),
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
        }
    }

    /// Where it ends: exactly the target, at rest.
    pub fn end(&self) -> Setpoint {
        Setpoint::standing(match self {
            Self::Joint(line) => line.end(),
            Self::Cartesian(line) => line.end(),
        })
    }
}
