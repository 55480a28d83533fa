//! The ideal arm: it is where it should be, and its joints carry what the model says.

use kinematics::{Dynamics, JointPositions, JointSpeeds};

use super::ArmState;
use crate::setpoint::LimitedSetpoint;

/// An arm whose actual position is the target.
#[derive(Clone, Copy, Debug)]
pub struct IdealPlant {
    q: JointPositions,
}

impl IdealPlant {
    /// Standing at `q`.
    pub const fn new(q: JointPositions) -> Self {
        Self { q }
    }

    pub(super) fn follow(&mut self, target: &LimitedSetpoint, dynamics: &Dynamics) -> ArmState {
        let target = target.get();
        self.q = target.q;
        ArmState {
            q: target.q,
            qd: target.qd,
            torque: dynamics.inverse_dynamics(&target.q, &target.qd, &target.qdd),
        }
    }

    pub(super) fn stand(&self, dynamics: &Dynamics) -> ArmState {
        ArmState {
            q: self.q,
            qd: JointSpeeds::ZERO,
            torque: dynamics.gravity_torques(&self.q),
        }
    }
}
