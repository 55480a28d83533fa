//! What the joints lag behind what modes want of them, made good within limits.
//!
//! Owns six differences and how they vanish. They arise where the arm was stopped beside its way, and where force mode
//! ends a hair beside the motion underneath.

use kinematics::{JointAccelerations, JointPositions, JointSpeeds};

use super::axis::AxisLimits;
use super::follower::TrackingLaw;
use super::states;
use crate::constants::ACCELERATION_RISE;
use crate::scalar::ScalarState;
use crate::setpoint::Setpoint;

/// Share of the joints' limits that making good may use; what is underneath stands or is slow meanwhile, a belt uses
/// the rest.
const SHARE: f64 = 0.4;
/// Bandwidth of the law that ends a lag, rad/s.
const BANDWIDTH: f64 = 40.0;
/// Distance, speed and acceleration below which there is no lag: rad, rad/s, rad/s².
const NEGLIGIBLE: [f64; 3] = [1e-10, 1e-8, 1e-5];

/// What lies between the joints and where they are wanted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointLag {
    joints: [ScalarState; 6],
    law: TrackingLaw,
    blocks_motion: bool,
}

impl JointLag {
    /// From where joints are wanted to where they are; `None` when that is the same. One that `blocks_motion` is made
    /// good before the motion underneath goes on.
    pub(crate) fn between(
        are: &Setpoint,
        wanted: &Setpoint,
        step: f64,
        comes_first: bool,
    ) -> Option<Self> {
        let (are, wanted) = (states(are), states(wanted));
        let lag = Self {
            joints: core::array::from_fn(|joint| ScalarState {
                position: are[joint].position - wanted[joint].position,
                speed: are[joint].speed - wanted[joint].speed,
                acceleration: are[joint].acceleration - wanted[joint].acceleration,
            }),
            law: TrackingLaw::new(BANDWIDTH, step),
            blocks_motion: comes_first,
        };
        (!lag.is_over()).then_some(lag)
    }

    pub(crate) const fn comes_first(&self) -> bool {
        self.blocks_motion
    }

    /// The largest of the joints' lags, rad.
    pub(crate) fn largest(&self) -> f64 {
        let positions = self.joints.iter().map(|lag| lag.position.abs());
        positions.fold(0.0, f64::max)
    }

    /// Nothing is left of the lag.
    pub(crate) fn is_over(&self) -> bool {
        self.joints.iter().all(is_none)
    }

    /// One step nearer.
    pub(crate) fn advance(&mut self, limits: &[AxisLimits; 6], step: f64) {
        for (lag, limits) in self.joints.iter_mut().zip(limits) {
            if is_none(lag) {
                *lag = ScalarState::default();
                continue;
            }
            let acceleration = SHARE * limits.acceleration;
            let axis = AxisLimits {
                min: f64::NEG_INFINITY,
                max: f64::INFINITY,
                // Not below what it has already: it slows down by itself.
                speed: (SHARE * limits.speed).max(lag.speed.abs()),
                acceleration: acceleration.max(lag.acceleration.abs()),
                jerk: (acceleration / ACCELERATION_RISE).min(SHARE * limits.jerk),
            };
            let wanted = self.law.acceleration(lag, 0.0, 0.0, &axis);
            *lag = axis.nearest_safe(lag, wanted, step);
        }
    }

    /// `wanted` with the lag laid over it.
    pub(crate) fn added_to(&self, wanted: &Setpoint) -> Setpoint {
        let joints = &self.joints;
        Setpoint {
            q: JointPositions(core::array::from_fn(|k| wanted.q[k] + joints[k].position)),
            qd: JointSpeeds(core::array::from_fn(|k| wanted.qd[k] + joints[k].speed)),
            qdd: JointAccelerations(core::array::from_fn(|k| {
                wanted.qdd[k] + joints[k].acceleration
            })),
        }
    }
}

fn is_none(lag: &ScalarState) -> bool {
    let parts = [lag.position, lag.speed, lag.acceleration];
    parts
        .iter()
        .zip(NEGLIGIBLE)
        .all(|(x, none)| x.abs() <= none)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lag_vanishes_within_its_share_of_the_limits_and_without_overshoot() {
        let axis = AxisLimits {
            min: -3.0,
            max: 3.0,
            speed: 3.0,
            acceleration: 10.0,
            jerk: 500.0,
        };
        for (begin, step) in [(0.4, 0.004), (-0.02, 0.001), (1e-6, 0.008)] {
            let q = |x| Setpoint::standing(JointPositions([x; 6]));
            let mut lag = JointLag::between(&q(begin), &q(0.0), step, true).unwrap();
            let mut before = lag.joints[0];
            let mut cycles = 0;
            while !lag.is_over() {
                lag.advance(&[axis; 6], step);
                let now = lag.joints[0];
                let slack = 1.0 + 1e-9;
                assert!(now.speed.abs() <= SHARE * axis.speed * slack);
                assert!(now.acceleration.abs() <= SHARE * axis.acceleration * slack);
                let jerk = (now.acceleration - before.acceleration) / step;
                assert!(jerk.abs() <= SHARE * axis.jerk * slack, "{jerk}");
                assert!(now.position * begin >= -1e-6 * begin.abs(), "{now:?}");
                before = now;
                cycles += 1;
                assert!(f64::from(cycles) * step < 2.5, "{lag:?}");
            }
        }
    }
}
