//! The joint servo: computed torque from the controller's model, and drives that feel what the model does not know.
//!
//! tau = M(q) u + C(q, qd) qd + g(q) with u = qdd* + Kd (qd* - qd) + Kp (q* - q) (Siciliano et al., *Robotics:
//! Modelling, Planning and Control*, 2009, 8.5.2). The starred values are differences of the sampled target, so that
//! the sequence of targets is itself a motion of an arm that is integrated with the same step; then only what the model
//! does not know (contact, hands, friction, another payload, saturation) leaves an error.
//!
//! The drives are tuned to the arm they sit in: where its masses are not those of the model, the terms in Kd and Kp
//! have the arm's own inertia, so that the bandwidth is the same. Against a share of what the force sensor reads of
//! hands they hold at once; what else pushes they see from what the arm makes of a torque, and hold against a share of
//! that (a disturbance observer: Ohnishi, Shibata, Murakami, IEEE/ASME Trans. Mechatronics 1996). The rest is felt as
//! an error.

use kinematics::{DOF, Dynamics, JointAccelerations, JointPositions, JointSpeeds, JointTorques};

use super::real_arm::{PlantDynamics, StepPosture};
use crate::constants::{
    DISTURBANCE_COMPENSATION, DISTURBANCE_DEAD_BAND, DISTURBANCE_TIME_CONSTANT, PEAK_TORQUE_FACTOR,
    SERVO_BANDWIDTH,
};
use crate::setpoint::Setpoint;
use kinematics::bounds::within;

/// Positions between two setpoints.
#[derive(Clone, Copy, Debug)]
pub(super) struct CubicInterpolation {
    from: Setpoint,
    to: Setpoint,
    duration: f64,
}

impl CubicInterpolation {
    pub(super) const fn new(from: Setpoint, to: Setpoint, duration: f64) -> Self {
        Self { from, to, duration }
    }

    /// Positions at `time` seconds after the first setpoint: the cubic that has its positions and speeds at both ends.
    pub(super) fn positions(&self, time: f64) -> JointPositions {
        let h = self.duration;
        let x = time / h;
        JointPositions(core::array::from_fn(|joint| {
            let (q0, v0) = (self.from.q[joint], self.from.qd[joint] * h);
            let (q1, v1) = (self.to.q[joint], self.to.qd[joint] * h);
            let way = q1 - q0;
            q0 + x * (v0 + x * ((3.0 * way - 2.0 * v0 - v1) + x * (v0 + v1 - 2.0 * way)))
        }))
    }
}

/// What the servo remembers between two of its steps.
#[derive(Clone, Copy, Debug)]
pub(super) struct JointServo {
    limit: JointTorques,
    /// Target positions now and one servo step ago.
    target: JointPositions,
    previous_target: JointPositions,
    /// What the last torques were to give, rad/s², and what of them the drives could not, Nm.
    requested_acceleration: JointAccelerations,
    saturation_torque: JointTorques,
    /// What pushes the arm on besides the drives and the hand, as far as it is held against, Nm.
    disturbance: JointTorques,
}

impl JointServo {
    /// At rest at `q`; torques are limited to a multiple of the nominal `effort`.
    pub(super) fn new(effort: &JointTorques, q: &JointPositions) -> Self {
        Self {
            limit: effort.map(|nominal| nominal * PEAK_TORQUE_FACTOR),
            target: *q,
            previous_target: *q,
            requested_acceleration: JointAccelerations::ZERO,
            saturation_torque: JointTorques::ZERO,
            disturbance: JointTorques::ZERO,
        }
    }

    /// Forgets the past: the target stands at `q`.
    pub(super) fn reset(&mut self, q: &JointPositions) {
        self.target = *q;
        self.previous_target = *q;
    }

    /// What pushes on a resting arm is `torque`, Nm.
    pub(super) fn set_disturbance(&mut self, torque: JointTorques) {
        self.disturbance = torque.map(|torque| DISTURBANCE_COMPENSATION * torque);
    }

    /// The torques for the next `step` seconds, at the end of which the target is `next`, for an arm that is at `q`,
    /// the posture `at`, and moves with `qd`. `hand` is what the sensor at the flange reads of hands, as joint torques,
    /// Nm.
    pub(super) fn torques(
        &mut self,
        believed: &Dynamics,
        (arm, at): (&PlantDynamics, &StepPosture),
        (q, qd): (&JointPositions, &JointSpeeds),
        next: JointPositions,
        hand: &JointTorques,
        step: f64,
    ) -> JointTorques {
        let (kp, kd) = (SERVO_BANDWIDTH * SERVO_BANDWIDTH, 2.0 * SERVO_BANDWIDTH);
        let mut planned = JointAccelerations::ZERO;
        for joint in 0..DOF {
            let speed = (self.target[joint] - self.previous_target[joint]) / step;
            let next_speed = (next[joint] - self.target[joint]) / step;
            planned[joint] = (next_speed - speed) / step;
            self.requested_acceleration[joint] =
                planned[joint] + kd * (speed - qd[joint]) + kp * (self.target[joint] - q[joint]);
        }
        self.previous_target = self.target;
        self.target = next;
        let free = if arm.matches_controller_model() {
            believed.inverse_dynamics_at(&at.posture, qd, &self.requested_acceleration)
        } else {
            let correction = self.requested_acceleration.to_vector() - planned.to_vector();
            let planned = believed.inverse_dynamics_at(&at.posture, qd, &planned);
            JointTorques((planned.to_vector() + arm.mass_matrix(at) * correction).into())
        };
        JointTorques(core::array::from_fn(|joint| {
            let known = DISTURBANCE_COMPENSATION * hand[joint] + self.disturbance[joint];
            let (wanted, most) = (free[joint] - known, self.limit[joint]);
            let torque = within(wanted, -most, most);
            self.saturation_torque[joint] = wanted - torque;
            torque
        }))
    }

    /// What the arm made of the last torques: its speeds before and after the step that began in the posture `at`.
    pub(super) fn update_disturbance(
        &mut self,
        arm: &PlantDynamics,
        at: &StepPosture,
        (before, after): (&JointSpeeds, &JointSpeeds),
        step: f64,
    ) {
        let off = (after.to_vector() - before.to_vector()) / step
            - self.requested_acceleration.to_vector();
        let is_as_asked = off.amax() < DISTURBANCE_DEAD_BAND;
        if is_as_asked
            && self.disturbance == JointTorques::ZERO
            && self.saturation_torque == JointTorques::ZERO
        {
            return;
        }
        let missing = arm.mass_matrix(at) * off;
        let share = step / (DISTURBANCE_TIME_CONSTANT + step);
        for joint in 0..DOF {
            let pushing = self.disturbance[joint] + self.saturation_torque[joint] + missing[joint];
            self.disturbance[joint] +=
                share * (DISTURBANCE_COMPENSATION * pushing - self.disturbance[joint]);
        }
    }
}
