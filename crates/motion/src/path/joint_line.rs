//! A straight line in joint space. s is the angle of the leading joint, the one that turns farthest.

use kinematics::{JointAccelerations, JointPositions, JointSpeeds};

use crate::config::MotionLimits;
use crate::constants::MIN_DISTANCE;
use crate::scalar::{ScalarLimits, ScalarState};
use crate::setpoint::Setpoint;

/// From one set of joint positions to another; all joints start and end together.
#[derive(Clone, Copy, Debug)]
pub struct JointLine {
    start: JointPositions,
    end: JointPositions,
    /// dq/ds: 1 or -1 for the leading joint, less for the others.
    direction: [f64; 6],
    length: f64,
}

impl JointLine {
    /// The line from `start` to `end`; of length 0 when they are the same.
    pub fn new(start: JointPositions, end: JointPositions) -> Self {
        let way: [f64; 6] = core::array::from_fn(|joint| end[joint] - start[joint]);
        let length = way.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let (length, direction) = if length > MIN_DISTANCE {
            (length, way.map(|x| x / length))
        } else {
            (0.0, [0.0; 6])
        };
        Self {
            start,
            end,
            direction,
            length,
        }
    }

    /// How far the leading joint turns, rad.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The joints where the line ends, rad.
    pub fn end(&self) -> JointPositions {
        self.end
    }

    /// The joints at s.
    pub fn positions(&self, s: f64) -> JointPositions {
        JointPositions(core::array::from_fn(|joint| {
            self.start[joint] + self.direction[joint] * s
        }))
    }

    /// dq/ds.
    pub fn direction(&self) -> JointSpeeds {
        JointSpeeds(self.direction)
    }

    /// The setpoint at a state of s.
    pub fn at(&self, s: &ScalarState) -> Setpoint {
        Setpoint {
            q: self.positions(s.position),
            qd: JointSpeeds(self.direction.map(|d| d * s.speed)),
            qdd: JointAccelerations(self.direction.map(|d| d * s.acceleration)),
        }
    }

    /// The limits of s that keep every joint within its own. Infinite on a line of length 0.
    pub fn limits(&self, limits: &MotionLimits) -> ScalarLimits {
        let least = |values: &[f64; 6]| {
            values
                .iter()
                .zip(&self.direction)
                .filter(|(_, d)| **d != 0.0)
                .fold(f64::INFINITY, |m, (value, d)| m.min(value / d.abs()))
        };
        ScalarLimits {
            speed: least(&limits.speed.0),
            acceleration: least(&limits.acceleration.0),
            jerk: least(&limits.jerk.0),
        }
    }
}
