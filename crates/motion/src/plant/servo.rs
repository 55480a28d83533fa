//! The joint servo: computed torque from the arm's own inverse dynamics.
//!
//! tau = M(q) u + C(q, qd) qd + g(q) with u = qdd* + Kd (qd* - qd) + Kp (q* - q) (Siciliano et al., *Robotics: Modelling,
//! Planning and Control*, 2009, 8.5.2). The starred values are differences of the sampled target, so that the sequence of
//! targets is itself a motion of an arm that is integrated with the same step; then only what the model does not know
//! (contact, saturation) leaves an error.

use kinematics::{Dynamics, JointAccelerations, JointPositions, JointSpeeds, JointTorques};

use crate::constants::{PEAK_TORQUE_FACTOR, SERVO_BANDWIDTH};
use crate::setpoint::Setpoint;

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
}

impl Servo {
    /// At rest at `q`; torques are limited to a multiple of the nominal `effort`.
    pub(super) fn new(effort: &JointTorques, q: &JointPositions) -> Self {
        Self {
            limit: effort.map(|nominal| nominal * PEAK_TORQUE_FACTOR),
            now: *q,
            before: *q,
        }
    }

    /// Forgets the past: the target stands at `q`.
    pub(super) fn rest_at(&mut self, q: &JointPositions) {
        self.now = *q;
        self.before = *q;
    }

    /// The torques for the next `step` seconds, at the end of which the target is `next`. `push` is what the sensor at
    /// the flange feels, as joint torques: the drives hold against it.
    pub(super) fn torques(
        &mut self,
        dynamics: &Dynamics,
        q: &JointPositions,
        qd: &JointSpeeds,
        next: JointPositions,
        push: &JointTorques,
        step: f64,
    ) -> JointTorques {
        let (kp, kd) = (SERVO_BANDWIDTH * SERVO_BANDWIDTH, 2.0 * SERVO_BANDWIDTH);
        let wanted = JointAccelerations(core::array::from_fn(|joint| {
            let speed = (self.now[joint] - self.before[joint]) / step;
            let next_speed = (next[joint] - self.now[joint]) / step;
            (next_speed - speed) / step
                + kd * (speed - qd[joint])
                + kp * (self.now[joint] - q[joint])
        }));
        self.before = self.now;
        self.now = next;
        let free = dynamics.inverse_dynamics(q, qd, &wanted);
        JointTorques(core::array::from_fn(|joint| {
            (free[joint] - push[joint]).clamp(-self.limit[joint], self.limit[joint])
        }))
    }
}
