//! What the arm feels, and whether it follows: the hand, force and collision sensing, encoders and temperatures at the end
//! of each cycle.
//!
//! Owns the order in which the sensors are read and what is too much; the sensors themselves are in `sensor`, `collision`,
//! `modes::encoder` and `thermal`, and the stop that follows in `stopping`.

use kinematics::{JointTorques, Wrench};
use motion_api::{RobotMode, StopReason};
use nalgebra::Matrix6;

use crate::collision::torques_of;
use crate::constants::{TRACKING_LIMIT, fault};
use crate::cycle::{Cycle, Generator};
use crate::modes::Kind;
use crate::plant::{ArmState, Push};
use crate::setpoint::Expected;

impl Cycle {
    /// Does the arm follow?
    pub(crate) fn check_arm(&mut self) {
        if !self.actual.is_finite() {
            self.plant.reset(&self.commanded.q);
            self.sensor.restart();
            let actual = self.plant.stand(&self.dynamics, &mut self.contacts);
            self.arm_is(actual);
            self.brake(StopReason::Internal {
                code: fault::PLANT_DIVERGED,
            });
        }
        if self.machine.stop_reason().is_some() {
            return;
        }
        for (joint, number) in (0u8..6).enumerate() {
            let error = (self.actual.q[joint] - self.commanded.q[joint]).abs();
            if error > TRACKING_LIMIT {
                self.brake(StopReason::TrackingError {
                    joint: number,
                    error,
                    limit: TRACKING_LIMIT,
                });
                return;
            }
        }
        let limit = self.limits.tcp_force;
        if let Some(force) = self.sensor.exceeds(limit)
            && self.is_under_servo()
            && !self.is_led()
        {
            self.brake(StopReason::TcpForce { force, limit });
            return;
        }
        if let Some(reason) = self.collision_found() {
            self.brake(reason);
        }
    }

    /// Somebody leads the arm by hand.
    fn is_led(&self) -> bool {
        matches!(
            &self.generator,
            Generator::Online(online) if matches!(online.kind, Kind::Freedrive(_))
        )
    }

    /// A collision, unless the hand that leads the arm is what is felt.
    fn collision_found(&self) -> Option<StopReason> {
        if self.is_led() || !self.is_under_servo() {
            return None;
        }
        let effort = &self.model.limits().effort;
        let is_pressing = self.force.is_at_work();
        let arm = (&self.actual_frames, &self.flange_from_tcp);
        self.collision.collision(effort, is_pressing, arm)
    }

    /// The wrench on the tool in this cycle, and the plant's share of it.
    pub(crate) fn feel_hand(&mut self) {
        let base_from_flange = &self.actual_frames.base_from_flange;
        let time = self.out.cycle as f64 * self.step;
        self.hand = self
            .external
            .at(time, base_from_flange, &self.flange_from_tcp, &self.gravity);
        self.plant.push(&Push {
            wrench: self.hand,
            flange_from_tcp: self.flange_from_tcp,
        });
    }

    /// What the force sensor said at the end of the last cycle, compensated: what the environment applies to the tool, base
    /// axes, about the TCP.
    /// Freedrive and force mode follow this reading.
    pub(crate) const fn felt(&self) -> Wrench {
        self.sensor.felt
    }

    /// What sensors say at the end of the cycle: force, encoders, collision observer, temperatures.
    pub(crate) fn measure(&mut self) {
        self.measure_force();
        let time = self.out.cycle as f64 * self.step;
        for encoder in &mut self.encoders {
            encoder.sample(time, self.io.image.digital_in.into());
        }
        if self.is_under_servo() && self.actual.is_finite() {
            let frames = &self.actual_frames;
            let tcp = frames.base_from_flange * self.flange_from_tcp;
            let at_tool = torques_of(&self.sensor.from_outside, frames, &tcp);
            let model = self.mass_and_bias();
            self.collision
                .observe(&self.actual, &at_tool, model, self.step);
            if self.force.is_at_work() {
                self.collision.press_on_purpose();
            }
        } else {
            self.collision.stand();
            self.sensor.stand();
        }
        let is_powered = self.machine.robot_mode() != RobotMode::PowerOff;
        let torque = if self.is_under_servo() {
            self.actual.torque
        } else {
            JointTorques::ZERO
        };
        let effort = &self.model.limits().effort;
        self.thermal.pass(&torque, effort, is_powered, self.step);
    }

    /// Mass matrix and bias torques where the arm is, by the controller's model.
    fn mass_and_bias(&mut self) -> (Matrix6<f64>, JointTorques) {
        let ArmState { q, qd, .. } = &self.actual;
        let posture = &self.placed.at(&self.model, q).posture;
        let mass = self.dynamics.mass_matrix_at(posture);
        // An arm that is just where it should be has been looked at.
        let bias = match &self.expected {
            Expected {
                of,
                bias: Some(bias),
                ..
            } if of.q.has_bits_of(q) && of.qd.has_bits_of(qd) => *bias,
            _ => self.dynamics.bias_torques_at(posture, qd),
        };
        (mass, bias)
    }

    /// What hand, loads and obstacles did to the tool: base axes, about the TCP.
    fn environment(&self) -> Wrench {
        let contact = &self.actual.contact;
        Wrench {
            force: self.hand.force + contact.force,
            moment: self.hand.moment + contact.moment,
        }
    }

    pub(crate) fn measure_force(&mut self) {
        if !self.actual.is_finite() {
            return;
        }
        let environment = self.environment();
        self.sensor.measure(
            &environment,
            &self.payload,
            (&self.actual_frames, &self.actual.qd),
            &self.flange_from_tcp,
            &self.gravity,
            self.step,
        );
    }
}
