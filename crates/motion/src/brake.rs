//! Braking joint by joint: what a protective stop does, whatever the arm was on.
//!
//! Each joint comes to rest as fast as its own acceleration and jerk limits allow; the path is left.

use kinematics::{JointAccelerations, JointPositions, JointSpeeds};

use crate::config::MotionLimits;
use crate::constants::SETTLING_TIME;
use crate::scalar::{Profile, ScalarState};
use crate::setpoint::Setpoint;

/// Six joints on their way to rest.
#[derive(Clone, Copy, Debug)]
pub struct JointBrake {
    profiles: [Profile; 6],
    time: f64,
}

impl JointBrake {
    /// From the motion at `from`.
    pub fn new(from: &Setpoint, limits: &MotionLimits) -> Self {
        let profiles = core::array::from_fn(|joint| {
            let start = ScalarState {
                position: from.q[joint],
                speed: from.qd[joint],
                acceleration: from.qdd[joint],
            };
            Profile::to_speed(start, 0.0, limits.acceleration[joint], limits.jerk[joint])
        });
        Self {
            profiles,
            time: 0.0,
        }
    }

    /// The setpoint `step` seconds later.
    pub fn next(&mut self, step: f64) -> Setpoint {
        self.time += step;
        let states = self.profiles.map(|profile| profile.at(self.time));
        Setpoint {
            q: JointPositions(states.map(|s| s.position)),
            qd: JointSpeeds(states.map(|s| s.speed)),
            qdd: JointAccelerations(states.map(|s| s.acceleration)),
        }
    }

    /// Where the joints come to rest, rad.
    pub fn end(&self) -> JointPositions {
        JointPositions(self.profiles.map(|profile| profile.end().position))
    }

    /// True when every joint's target stands and the arm has come to rest as well, or has had its time to.
    pub fn has_settled(&self, arm_rests: bool) -> bool {
        let longest = self.profiles.iter().map(Profile::duration);
        let longest = longest.fold(0.0, f64::max);
        self.time >= longest + if arm_rests { 0.0 } else { SETTLING_TIME }
    }
}
