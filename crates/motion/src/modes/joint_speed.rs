//! speedj and stopj: joint speeds under acceleration and jerk limits (manual 3.1.25, 3.1.26).
//!
//! The joint whose speed changes most accelerates as asked, the others in proportion, so that all arrive together.

use kinematics::JointSpeeds;
use kinematics::bounds::within;

use super::OnlineContext;
use super::axis::AxisLimits;
use crate::constants::{ACCELERATION_RISE, PAUSE_SHARE};
use crate::scalar::ScalarState;

/// How much more speed there has to be than it takes to end an acceleration.
const SURELY: f64 = 1.2;

/// Joint speeds to be reached and held.
#[derive(Clone, Copy, Debug)]
pub struct JointSpeedMode {
    goal: JointSpeeds,
    acceleration: [f64; 6],
    /// What each joint accelerated at in the beginning, rad/s².
    begun: [f64; 6],
}

impl JointSpeedMode {
    /// From the speeds of `now` to `goal` with `acceleration`, rad/s², of the joint that changes most.
    pub fn new(now: &[ScalarState; 6], goal: &JointSpeeds, acceleration: f64) -> Self {
        // With the speed that an acceleration still adds while it goes.
        let change: [f64; 6] = core::array::from_fn(|joint| {
            let added = 0.5 * ACCELERATION_RISE * now[joint].acceleration;
            (goal[joint] - now[joint].speed - added).abs()
        });
        let most = change.iter().fold(0.0_f64, |m, x| m.max(*x));
        // A joint that hardly changes still needs to get rid of an acceleration it may have.
        let share = |x: f64| {
            if most > 0.0 {
                (x / most).max(0.05)
            } else {
                1.0
            }
        };
        Self {
            goal: *goal,
            acceleration: change.map(|x| acceleration * share(x)),
            begun: now.map(|state| state.acceleration.abs()),
        }
    }

    /// Keeps the goal from the motion `now` on, where something else moved the joints before.
    pub(crate) fn go_on_from(&mut self, now: &[ScalarState; 6]) {
        self.begun = now.map(|state| state.acceleration.abs());
    }

    /// The speeds at full speed fraction.
    pub fn goal(&self) -> &JointSpeeds {
        &self.goal
    }

    /// The states one step later at a fraction of the goal, and the first joint that a limit holds back.
    pub(crate) fn next(
        &self,
        now: &[ScalarState; 6],
        arm: &OnlineContext,
        fraction: f64,
    ) -> ([ScalarState; 6], Option<u8>) {
        let (axes, able, step) = (&arm.axes, &arm.available_axes, arm.step);
        let mut held = None;
        let mut next = *now;
        // Where TCP or elbow would be too fast all joints are slowed alike, and hard if they are too fast already.
        let slowed = fraction * arm.point_factor(&self.goal.map(|v| v * fraction)).min(1.0);
        let is_too_fast = arm.point_factor(&JointSpeeds(now.map(|s| s.speed))) < 1.0;
        // One common factor keeps the joints in proportion where one of them can do less.
        let scale = (0..6).fold(1.0_f64, |least, joint| {
            least.min(able[joint].acceleration / self.acceleration[joint])
        });
        let fastest = now.iter().fold(0.0_f64, |most, s| most.max(s.speed.abs()));
        for (joint, number) in (0u8..6).enumerate() {
            let axis = &axes[joint];
            let wanted = within(self.goal[joint] * slowed, -axis.speed, axis.speed);
            let goal = axis.slowed_before_ends(now[joint].position, wanted);
            let is_ending = goal != wanted;
            let begun = self.begun[joint].max(now[joint].acceleration.abs());
            // An acceleration from before goes as fast as it would have come.
            let asked = |acceleration: f64| AxisLimits {
                acceleration,
                jerk: axis.jerk.min(acceleration.max(begun) / ACCELERATION_RISE),
                ..*axis
            };
            // A pause and the slider slow down with a share of what the joints can do at least, whatever was asked for.
            let slows = (fraction < 1.0 || arm.is_paused) && goal.abs() < now[joint].speed.abs();
            let least = if slows {
                PAUSE_SHARE * able[joint].acceleration * now[joint].speed.abs() / fastest
            } else {
                0.0
            };
            let gentle = asked((self.acceleration[joint] * scale).max(least));
            // A harder slowing down from before goes on where the speed that is left is too little to end it.
            let (acceleration, left) = (now[joint].acceleration, goal - now[joint].speed);
            let to_end_it = acceleration * acceleration / (2.0 * gentle.jerk);
            let gentle = if acceleration * left > 0.0 && left.abs() <= SURELY * to_end_it {
                asked(gentle.acceleration.max(acceleration.abs()))
            } else {
                gentle
            };
            // Harder where the gentle way would lead out of the range.
            let is_enough = !is_ending && !is_too_fast && gentle.brakes_inside(&now[joint]);
            let asked = if is_enough {
                gentle
            } else {
                asked(able[joint].acceleration)
            };
            let wanted = asked.step_towards_speed(&now[joint], goal, step);
            let (state, touched) = axis.clamp_to_safe(&now[joint], &wanted, step);
            next[joint] = state;
            let missing = (goal - self.goal[joint] * fraction).abs();
            if touched || is_ending || missing > 0.01 * axis.speed {
                held = held.or(Some(number));
            }
        }
        (next, held)
    }

    /// Whether every joint has its speed, at a fraction of the goal; one that is to stand stands, to the last digit.
    pub fn is_reached(&self, now: &[ScalarState; 6], fraction: f64) -> bool {
        (0..6).all(|joint| {
            let goal = self.goal[joint] * fraction;
            let has_speed = if goal == 0.0 {
                now[joint].speed == 0.0
            } else {
                (now[joint].speed - goal).abs() < 1e-9
            };
            has_speed && now[joint].acceleration == 0.0
        })
    }
}
