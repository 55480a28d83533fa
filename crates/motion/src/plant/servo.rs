//! The joint servo: computed torque from the controller's model, and drives that feel what the model does not know.
//!
//! tau = M(q) u + C(q, qd) qd + g(q) with u = qdd* + Kd (qd* - qd) + Kp (q* - q) (Siciliano et al., *Robotics: Modelling,
//! Planning and Control*, 2009, 8.5.2). The starred values are differences of the sampled target, so that the sequence of
//! targets is itself a motion of an arm that is integrated with the same step; then only what the model does not know
//! (contact, hands, friction, another payload, saturation) leaves an error.
//!
//! The drives are tuned to the arm they sit in: where its masses are not those of the model, the terms in Kd and Kp have
//! the arm's own inertia, so that the bandwidth is the same. Against a share of what the force sensor reads of hands they hold
//! at once; what else pushes they see from what the arm makes of a torque, and hold against a share of that (a disturbance
//! observer: Ohnishi, Shibata, Murakami, IEEE/ASME Trans. Mechatronics 1996). The rest is felt as an error.

use kinematics::{DOF, Dynamics, JointAccelerations, JointPositions, JointSpeeds, JointTorques};

use super::real_arm::RealArm;
use crate::constants::{FELT_FILTER, FELT_SHARE, NOT_FELT, PEAK_TORQUE_FACTOR, SERVO_BANDWIDTH};
use crate::setpoint::Setpoint;
use kinematics::bounds::within;

/// Positions between two setpoints.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interpolation {
    from: Setpoint,
    to: Setpoint,
    duration: f64,
}

impl Interpolation {
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
pub(super) struct Servo {
    limit: JointTorques,
    /// Target positions now and one servo step ago.
    now: JointPositions,
    before: JointPositions,
    /// What the last torques were to give, rad/s², and what of them the drives could not, Nm.
    asked: JointAccelerations,
    cut_off: JointTorques,
    /// What pushes the arm on besides the drives and the hand, as far as it is held against, Nm.
    felt: JointTorques,
}

impl Servo {
    /// At rest at `q`; torques are limited to a multiple of the nominal `effort`.
    pub(super) fn new(effort: &JointTorques, q: &JointPositions) -> Self {
        Self {
            limit: effort.map(|nominal| nominal * PEAK_TORQUE_FACTOR),
            now: *q,
            before: *q,
            asked: JointAccelerations::ZERO,
            cut_off: JointTorques::ZERO,
            felt: JointTorques::ZERO,
        }
    }

    /// Forgets the past: the target stands at `q`.
    pub(super) fn rest_at(&mut self, q: &JointPositions) {
        self.now = *q;
        self.before = *q;
    }

    /// What pushes on a resting arm is `torque`, Nm.
    pub(super) fn hold_against(&mut self, torque: JointTorques) {
        self.felt = torque.map(|torque| FELT_SHARE * torque);
    }

    /// The torques for the next `step` seconds, at the end of which the target is `next`, for an arm that is at `q` and moves
    /// with `qd`. `hand` is what the sensor at the flange reads of hands, as joint torques, Nm.
    pub(super) fn torques(
        &mut self,
        believed: &Dynamics,
        arm: &RealArm,
        (q, qd): (&JointPositions, &JointSpeeds),
        next: JointPositions,
        hand: &JointTorques,
        step: f64,
    ) -> JointTorques {
        let (kp, kd) = (SERVO_BANDWIDTH * SERVO_BANDWIDTH, 2.0 * SERVO_BANDWIDTH);
        let mut planned = JointAccelerations::ZERO;
        for joint in 0..DOF {
            let speed = (self.now[joint] - self.before[joint]) / step;
            let next_speed = (next[joint] - self.now[joint]) / step;
            planned[joint] = (next_speed - speed) / step;
            self.asked[joint] =
                planned[joint] + kd * (speed - qd[joint]) + kp * (self.now[joint] - q[joint]);
        }
        self.before = self.now;
        self.now = next;
        let free = if arm.is_as_believed() {
            believed.inverse_dynamics(q, qd, &self.asked)
        } else {
            let correction = self.asked.to_vector() - planned.to_vector();
            let planned = believed.inverse_dynamics(q, qd, &planned).to_vector();
            JointTorques((planned + arm.mass_matrix(q) * correction).into())
        };
        JointTorques(core::array::from_fn(|joint| {
            let known = FELT_SHARE * hand[joint] + self.felt[joint];
            let (wanted, most) = (free[joint] - known, self.limit[joint]);
            let torque = within(wanted, -most, most);
            self.cut_off[joint] = wanted - torque;
            torque
        }))
    }

    /// What the arm made of the last torques: its speeds before and after the step that began at `q`.
    pub(super) fn feel(
        &mut self,
        arm: &RealArm,
        q: &JointPositions,
        (before, after): (&JointSpeeds, &JointSpeeds),
        step: f64,
    ) {
        let off = (after.to_vector() - before.to_vector()) / step - self.asked.to_vector();
        let is_as_asked = off.amax() < NOT_FELT;
        if is_as_asked && self.felt == JointTorques::ZERO && self.cut_off == JointTorques::ZERO {
            return;
        }
        let missing = arm.mass_matrix(q) * off;
        let share = step / (FELT_FILTER + step);
        for joint in 0..DOF {
            let pushing = self.felt[joint] + self.cut_off[joint] + missing[joint];
            self.felt[joint] += share * (FELT_SHARE * pushing - self.felt[joint]);
        }
    }
}
