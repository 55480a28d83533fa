//! speedj and stopj: joint speeds under acceleration and jerk limits (manual 3.1.25, 3.1.26).
//!
//! The joint whose speed changes most accelerates as asked, the others in proportion, so that all arrive together.

use kinematics::JointSpeeds;
use kinematics::bounds::within;

use super::OnlineArm;
use super::axis::Axis;
use crate::constants::ACCELERATION_RISE;
use crate::scalar::ScalarState;

/// Joint speeds to be reached and held.
#[derive(Clone, Copy, Debug)]
pub struct JointSpeed {
    goal: JointSpeeds,
    acceleration: [f64; 6],
}

impl JointSpeed {
    /// From the speeds of `now` to `goal` with `acceleration`, rad/s², of the joint that changes most.
    pub fn new(now: &[ScalarState; 6], goal: &JointSpeeds, acceleration: f64) -> Self {
        let change: [f64; 6] = core::array::from_fn(|joint| (goal[joint] - now[joint].speed).abs());
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
        }
    }

    /// The speeds at full speed fraction.
    pub fn goal(&self) -> &JointSpeeds {
        &self.goal
    }

    /// The states one step later at a fraction of the goal, and the first joint that a limit holds back.
    pub(crate) fn next(
        &self,
        now: &[ScalarState; 6],
        arm: &OnlineArm,
        fraction: f64,
    ) -> ([ScalarState; 6], Option<u8>) {
        let (axes, able, step) = (&arm.axes, &arm.able, arm.step);
        let mut held = None;
        let mut next = *now;
        // Where TCP or elbow would be too fast all joints are slowed alike, and hard if they are too fast already.
        let slowed = fraction * arm.point_factor(&self.goal.map(|v| v * fraction)).min(1.0);
        let is_too_fast = arm.point_factor(&JointSpeeds(now.map(|s| s.speed))) < 1.0;
        // One common factor keeps the joints in proportion where one of them can do less.
        let scale = (0..6).fold(1.0_f64, |least, joint| {
            least.min(able[joint].acceleration / self.acceleration[joint])
        });
        for (joint, number) in (0u8..6).enumerate() {
            let axis = &axes[joint];
            let wanted = within(self.goal[joint] * slowed, -axis.speed, axis.speed);
            let goal = axis.slowed_before_ends(now[joint].position, wanted);
            let is_ending = goal != wanted;
            let asked = |acceleration: f64| Axis {
                acceleration,
                jerk: axis.jerk.min(acceleration / ACCELERATION_RISE),
                ..*axis
            };
            let gentle = asked(self.acceleration[joint] * scale);
            // Harder where the gentle way would lead out of the range, or where a harder one is under way already.
            let is_enough = !is_ending
                && !is_too_fast
                && now[joint].acceleration.abs() <= gentle.acceleration * (1.0 + 1e-9)
                && gentle.brakes_inside(&now[joint]);
            let asked = if is_enough {
                gentle
            } else {
                asked(able[joint].acceleration)
            };
            let wanted = asked.towards_speed(&now[joint], goal, step);
            let (state, touched) = axis.restrain(&now[joint], &wanted, step);
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
