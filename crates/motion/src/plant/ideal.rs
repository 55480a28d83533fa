//! The ideal arm: it is where it should be, and its joints carry what the model says.

use kinematics::{Dynamics, JointPositions, JointSpeeds, JointTorques};

use super::{ArmState, Push};
use crate::setpoint::LimitedSetpoint;

/// An arm whose actual position is the target.
#[derive(Clone, Copy, Debug)]
pub struct IdealPlant {
    q: JointPositions,
    /// What the joints carried a cycle ago, Nm.
    torque: Option<JointTorques>,
    /// What the push from outside takes off the joints, Nm.
    pushed: JointTorques,
}

impl IdealPlant {
    /// Standing at `q`.
    pub const fn new(q: JointPositions) -> Self {
        Self {
            q,
            torque: None,
            pushed: JointTorques::ZERO,
        }
    }

    pub(super) fn push(&mut self, push: &Push) {
        self.pushed = push.torque;
    }

    pub(super) fn follow(&mut self, target: &LimitedSetpoint, dynamics: &Dynamics) -> ArmState {
        let target = target.get();
        self.q = target.q;
        let free = dynamics.inverse_dynamics(&target.q, &target.qd, &target.qdd);
        let torque = JointTorques(core::array::from_fn(|joint| {
            free[joint] - self.pushed[joint]
        }));
        let before = self.torque.replace(torque).unwrap_or(torque);
        ArmState {
            q: target.q,
            qd: target.qd,
            torque,
            mean_torque: JointTorques(core::array::from_fn(|joint| {
                (before[joint] + torque[joint]) / 2.0
            })),
        }
    }

    pub(super) fn stand(&mut self, dynamics: &Dynamics) -> ArmState {
        let torque = dynamics.gravity_torques(&self.q);
        self.torque = None;
        ArmState {
            q: self.q,
            qd: JointSpeeds::ZERO,
            torque,
            mean_torque: torque,
        }
    }
}
