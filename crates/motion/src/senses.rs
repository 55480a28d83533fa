//! What the arm feels, and whether it follows: the hand, force and collision sensing, encoders and temperatures at the
//! end of each cycle.
//!
//! Owns the order in which the sensors are read and what is too much; the sensors themselves are in `sensor`,
//! `detected_stop`, `modes::encoder` and `thermal`, and the stop that follows in `stopping`.

use kinematics::{JointTorques, Wrench};
use motion_api::{RobotMode, StopReason};
use nalgebra::Matrix6;

use crate::collision::wrench_to_torques;
use crate::constants::{TRACKING_LIMIT, fault};
use crate::cycle::{ControlLoop, Generator};
use crate::modes::OnlineMode;
use crate::plant::{ArmState, ToolWrench};
use crate::setpoint::SetpointDynamics;

impl ControlLoop {
    /// Does the arm follow?
    pub(crate) fn check_tracking(&mut self) {
        if !self.actual.state().is_finite() {
            let links = (&self.model, &mut self.kinematics_cache);
            self.actual
                .restart_at(&self.commanded.setpoint().q, self.load.dynamics(), links);
            self.sensor.restart();
            self.enter_protective_stop(StopReason::Internal {
                code: fault::PLANT_DIVERGED,
            });
        }
        if self.machine.stop_reason().is_some() {
            return;
        }
        for (joint, number) in (0u8..6).enumerate() {
            let error = (self.actual.state().q[joint] - self.commanded.setpoint().q[joint]).abs();
            if error > TRACKING_LIMIT {
                self.enter_protective_stop(StopReason::TrackingError {
                    joint: number,
                    error,
                    limit: TRACKING_LIMIT,
                });
                return;
            }
        }
        if !self.contact_stops {
            return;
        }
        let limit = self.limits.in_force().tcp_force;
        if let Some(force) = self.sensor.exceeds(limit)
            && self.is_under_servo()
            && !self.is_hand_guided()
        {
            self.enter_protective_stop(StopReason::TcpForce { force, limit });
            return;
        }
        if let Some(reason) = self.detect_collision() {
            self.enter_protective_stop(reason);
        }
    }

    /// Somebody leads the arm by hand.
    fn is_hand_guided(&self) -> bool {
        matches!(
            &self.generator,
            Generator::Online(online) if matches!(online.kind, OnlineMode::Freedrive(_))
        )
    }

    /// A collision, unless the hand that leads the arm is what is felt.
    fn detect_collision(&self) -> Option<StopReason> {
        if self.is_hand_guided() || !self.is_under_servo() {
            return None;
        }
        let effort = &self.model.limits().effort;
        let is_pressing = self.force.is_active();
        let arm = (self.actual.frames(), self.tool.flange_from_tcp());
        self.collision.detected_stop(effort, is_pressing, arm)
    }

    /// The wrench on the tool in this cycle, and the plant's share of it.
    pub(crate) fn update_external_wrench(&mut self) {
        let base_from_flange = &self.actual.frames().base_from_flange;
        let time = self.out.cycle as f64 * self.step;
        self.external_wrench = self.external.at(
            time,
            base_from_flange,
            self.tool.flange_from_tcp(),
            self.load.gravity(),
        );
        let mut link_torques = JointTorques::ZERO;
        if let Some(world) = &self.surroundings {
            self.external_wrench.force += world.tool_wrench().force;
            self.external_wrench.moment += world.tool_wrench().moment;
            link_torques = *world.link_torques();
        }
        self.actual.plant.set_tool_wrench(&ToolWrench {
            wrench: self.external_wrench,
            flange_from_tcp: *self.tool.flange_from_tcp(),
            link_torques,
        });
    }

    /// What the force sensor said at the end of the last cycle, compensated: what the environment applies to the tool,
    /// base axes, about the TCP.
    /// Freedrive and force mode follow this reading.
    pub(crate) const fn sensed_wrench(&self) -> Wrench {
        self.sensor.compensated_in_base
    }

    /// What sensors say at the end of the cycle: force, encoders, collision observer, temperatures.
    pub(crate) fn update_sensors(&mut self) {
        self.measure_force();
        let time = self.out.cycle as f64 * self.step;
        for (number, encoder) in self.encoders.iter_mut().enumerate() {
            let ticks = self
                .surroundings
                .as_ref()
                .and_then(|world| world.encoder_ticks[number]);
            encoder.sample(time, self.io.image.digital_in.into(), ticks);
        }
        if self.is_under_servo() && self.actual.state().is_finite() {
            let frames = self.actual.frames();
            let tcp = self.tool.base_from_tcp(frames);
            let at_tool = wrench_to_torques(&self.sensor.external_wrench, frames, &tcp);
            let model = self.mass_and_bias();
            self.collision
                .observe(self.actual.state(), &at_tool, model, self.step);
            if self.force.is_active() {
                self.collision.accept_sensed_contact();
            }
        } else {
            self.collision.reset_for_takeover();
            self.sensor.rebaseline();
        }
        let is_powered = self.machine.robot_mode() != RobotMode::PowerOff;
        let torque = if self.is_under_servo() {
            self.actual.state().torque
        } else {
            JointTorques::ZERO
        };
        let effort = &self.model.limits().effort;
        self.thermal.advance(&torque, effort, is_powered, self.step);
    }

    /// Mass matrix and bias torques where the arm is, by the controller's model.
    fn mass_and_bias(&mut self) -> (Matrix6<f64>, JointTorques) {
        let ArmState { q, qd, .. } = self.actual.state();
        let posture = &self.kinematics_cache.at(&self.model, q).posture;
        let mass = self.load.dynamics().mass_matrix_at(posture);
        // An arm that is just where it should be has been looked at.
        let bias = match &self.setpoint_dynamics {
            SetpointDynamics {
                of,
                bias: Some(bias),
                ..
            } if of.q.has_bits_of(q) && of.qd.has_bits_of(qd) => *bias,
            _ => self.load.dynamics().bias_torques_at(posture, qd),
        };
        (mass, bias)
    }

    /// What hand, loads and obstacles did to the tool: base axes, about the TCP.
    fn environment(&self) -> Wrench {
        let contact = &self.actual.state().contact;
        Wrench {
            force: self.external_wrench.force + contact.force,
            moment: self.external_wrench.moment + contact.moment,
        }
    }

    pub(crate) fn measure_force(&mut self) {
        if !self.actual.state().is_finite() {
            return;
        }
        let environment = self.environment();
        self.sensor.measure(
            &environment,
            self.load.payload(),
            (self.actual.frames(), &self.actual.state().qd),
            self.tool.flange_from_tcp(),
            self.load.gravity(),
            self.step,
        );
    }
}
