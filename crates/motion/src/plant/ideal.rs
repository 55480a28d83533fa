//! The ideal arm: it is where it should be, and its joints carry what the model says.
//!
//! Obstacles cannot hold it back: it goes into them, and they push with their stiffness times the depth.

use kinematics::{Dynamics, JointPositions, JointSpeeds, JointTorques, Pose, Wrench};
use nalgebra::Vector3;

use super::{ArmState, Push};
use crate::contact::Contacts;
use crate::setpoint::LimitedSetpoint;

/// An arm whose actual position is the target.
#[derive(Clone, Copy, Debug)]
pub struct IdealPlant {
    q: JointPositions,
    /// What the joints carried a cycle ago, Nm.
    torque: Option<JointTorques>,
    push: Push,
}

impl IdealPlant {
    /// Standing at `q`.
    pub const fn new(q: JointPositions) -> Self {
        Self {
            q,
            torque: None,
            push: Push {
                wrench: Wrench {
                    force: Vector3::new(0.0, 0.0, 0.0),
                    moment: Vector3::new(0.0, 0.0, 0.0),
                },
                flange_from_tcp: Pose::IDENTITY,
            },
        }
    }

    pub(super) fn push(&mut self, push: &Push) {
        self.push = *push;
    }

    pub(super) fn follow(
        &mut self,
        target: &LimitedSetpoint,
        dynamics: &Dynamics,
        contacts: &Contacts,
    ) -> ArmState {
        let target = target.get();
        self.q = target.q;
        let free = dynamics.inverse_dynamics(&target.q, &target.qd, &target.qdd);
        let pressing = contacts.pressed(&target.q, &target.qd, &self.push.flange_from_tcp);
        let (_, pushed) = self.push.at(&contacts.forward(&target.q));
        let torque = JointTorques(core::array::from_fn(|joint| {
            free[joint] - pushed[joint] - pressing.torque[joint]
        }));
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

    pub(super) fn stand(&mut self, dynamics: &Dynamics, contacts: &Contacts) -> ArmState {
        let torque = dynamics.gravity_torques(&self.q);
        let pressing = contacts.pressed(&self.q, &JointSpeeds::ZERO, &self.push.flange_from_tcp);
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
