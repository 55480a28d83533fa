//! The ideal arm: it is where it should be, and its joints carry what that takes.
//!
//! Obstacles cannot hold it back: it goes into them, and they push with their stiffness times the depth.

use kinematics::{JointPositions, JointSpeeds, JointTorques};

use super::real_arm::PlantDynamics;
use super::{ArmState, ToolWrench};
use crate::contact::ContactModel;
use crate::setpoint::LimitedSetpoint;

/// An arm whose actual position is the target.
#[derive(Clone, Copy, Debug)]
pub struct IdealPlant {
    pub(super) arm: PlantDynamics,
    q: JointPositions,
    /// What the joints carried a cycle ago, Nm.
    torque: Option<JointTorques>,
    pub(super) push: ToolWrench,
}

impl IdealPlant {
    /// Standing at `q`.
    pub(super) fn new(arm: PlantDynamics, q: JointPositions) -> Self {
        Self {
            arm,
            q,
            torque: None,
            push: ToolWrench::default(),
        }
    }

    /// Puts the arm at rest at `q`.
    pub(super) fn reset(&mut self, q: &JointPositions) {
        self.q = *q;
        self.torque = None;
    }

    pub(super) fn step_to_target(
        &mut self,
        target: &LimitedSetpoint,
        believed: &JointTorques,
        contacts: &mut ContactModel,
    ) -> ArmState {
        let target = target.as_setpoint();
        self.q = target.q;
        let free = self
            .arm
            .drive_torques(&target.q, &target.qd, &target.qdd, believed);
        let pressing = contacts.forces_at(&target.q, &target.qd, &self.push.flange_from_tcp);
        contacts.add_held_forces(&pressing, 1.0);
        let mut torque = JointTorques(core::array::from_fn(|j| free[j] - pressing.torque[j]));
        if !self.push.is_nothing() {
            let (_, pushed) = self.push.at(&contacts.forward(&target.q));
            torque = JointTorques(core::array::from_fn(|j| {
                free[j] - pushed[j] - pressing.torque[j]
            }));
        }
        let before = self.torque.replace(torque).unwrap_or(torque);
        ArmState {
            q: target.q,
            qd: target.qd,
            torque,
            mean_torque: JointTorques(core::array::from_fn(|joint| {
                (before[joint] + torque[joint]) / 2.0
            })),
            contact: pressing.tool,
        }
    }

    pub(super) fn step_with_brakes(&mut self, contacts: &mut ContactModel) -> ArmState {
        let torque = self.arm.dynamics().gravity_torques(&self.q);
        let pressing = contacts.forces_at(&self.q, &JointSpeeds::ZERO, &self.push.flange_from_tcp);
        contacts.add_held_forces(&pressing, 1.0);
        self.torque = None;
        ArmState {
            q: self.q,
            qd: JointSpeeds::ZERO,
            torque,
            mean_torque: torque,
            contact: pressing.tool,
        }
    }
}
