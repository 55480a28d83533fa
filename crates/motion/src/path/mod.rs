//! Geometric paths of the whole arm, without time: where the joints are at each place s of the way.

mod joint_line;

pub use joint_line::JointLine;

use kinematics::JointPositions;

use crate::scalar::ScalarState;
use crate::setpoint::Setpoint;

/// A way from rest to rest.
#[derive(Clone, Copy, Debug)]
pub enum Path {
    /// A straight line in joint space.
    Joint(JointLine),
}

impl Path {
    /// The setpoint at a state of s, in the branch of solutions that `near` belongs to. `None` when the inverse
    /// kinematics has no solution there.
    pub fn at(&self, s: &ScalarState, near: &JointPositions) -> Option<Setpoint> {
        let _ = near;
        match self {
            Self::Joint(line) => Some(line.at(s)),
        }
    }

    /// Where it ends: exactly the target, at rest.
    pub fn end(&self) -> Setpoint {
        match self {
            Self::Joint(line) => Setpoint::standing(line.end()),
        }
    }
}
