//! What a path asks of the drives: torques as a function of speed and acceleration along it.
//!
//! On a path q(s) the inverse dynamics is tau = m(s) s" + c(s) s'² + g(s) with m = M q', c = M q'' + C(q, q') q', g
//! gravity (Biagiotti and Melchiorri 2008, 9.4; dashes at q: derivatives with respect to s, at s: to time). Three
//! evaluations of the inverse dynamics give all three.

use kinematics::{JointAccelerations, JointPositions, JointSpeeds};

use super::PlanningContext;
use crate::constants::{LEAST_TORQUE_SHARE, PEAK_TORQUE_FACTOR, PLANNED_TORQUE_SHARE};

/// The largest demands over some places of a path, and the smallest room left by gravity.
#[derive(Clone, Copy, Debug)]
pub struct TorqueBounds {
    /// |m|, Nm per unit of s".
    inertia: [f64; 6],
    /// |c|, Nm per unit of s'².
    speed: [f64; 6],
    /// What gravity leaves of the planned torque, Nm.
    room: [f64; 6],
}

impl TorqueBounds {
    /// No place looked at yet.
    pub const NONE: Self = Self {
        inertia: [0.0; 6],
        speed: [0.0; 6],
        room: [f64::INFINITY; 6],
    };

    /// Takes in the place where the joints are at `q` with derivatives `first` and `second`.
    pub fn cover(
        &mut self,
        q: &JointPositions,
        first: &[f64; 6],
        second: &[f64; 6],
        arm: &PlanningContext,
    ) {
        let dynamics = arm.dynamics;
        let (first, second) = (*first, *second);
        let still = JointSpeeds::ZERO;
        let posture = arm.model.chain().posture(q);
        // Without speed, what there is without acceleration is gravity.
        let [pushed, gravity] =
            dynamics.inverse_dynamics_and_bias(&posture, &still, &JointAccelerations(first));
        let (speeds, bent) = (JointSpeeds(first), JointAccelerations(second));
        let moving = dynamics.inverse_dynamics_at(&posture, &speeds, &bent);
        let effort = &arm.model.limits().effort;
        for joint in 0..6 {
            let planned = effort[joint] * PEAK_TORQUE_FACTOR * PLANNED_TORQUE_SHARE;
            let room = (planned - gravity[joint].abs()).max(effort[joint] * LEAST_TORQUE_SHARE);
            self.room[joint] = self.room[joint].min(room);
            let inertia = (pushed[joint] - gravity[joint]).abs();
            self.inertia[joint] = self.inertia[joint].max(inertia);
            let speed = (moving[joint] - gravity[joint]).abs();
            self.speed[joint] = self.speed[joint].max(speed);
        }
    }

    /// Takes in other places.
    pub fn join(&mut self, other: &Self) {
        for joint in 0..6 {
            self.inertia[joint] = self.inertia[joint].max(other.inertia[joint]);
            self.speed[joint] = self.speed[joint].max(other.speed[joint]);
            self.room[joint] = self.room[joint].min(other.room[joint]);
        }
    }

    /// The speed of s at which moving evenly takes up `share` of the room.
    pub fn speed_limit(&self, share: f64) -> f64 {
        (0..6).fold(f64::INFINITY, |least, joint| {
            least.min((share * self.room[joint] / self.speed[joint]).sqrt())
        })
    }

    /// The acceleration of s that is left at a speed of s.
    pub fn acceleration_limit(&self, speed: f64) -> f64 {
        (0..6).fold(f64::INFINITY, |least, joint| {
            let left = self.room[joint] - self.speed[joint] * speed * speed;
            least.min(left / self.inertia[joint])
        })
    }
}
