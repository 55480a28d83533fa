//! servoj: joint positions from a stream of points (manual 3.1.6).
//!
//! The points are joined by straight lines, each as long as its `t`; the mean over the look-ahead window smooths them;
//! a tracking law whose bandwidth follows the gain makes the setpoints, pieces of constant jerk and so a cubic spline.
//! It knows the mean's speed and acceleration, so that what moves evenly or swings slowly comes out as it went in, late.
//! The arm is never faster than what lets it stop at the newest point, which the mean has not reached yet.
//! When the stream stops the reference stands at its last point and the arm comes to rest there. Nothing here needs the
//! points to come evenly: a late one is a reference that stood still for a while.

use kinematics::JointPositions;
use kinematics::elementary::square;

use super::OnlineArm;
use super::follower::Follower;
use crate::constants::{SERVO_SETTLED, STEP_RANGE};
use crate::scalar::ScalarState;

/// Range of the look-ahead, s (manual 3.1.6).
pub const LOOKAHEAD_RANGE: (f64, f64) = (0.03, 0.2);
/// Range of the gain (manual 3.1.6).
pub const GAIN_RANGE: (f64, f64) = (100.0, 2000.0);

/// Places of the longest window at the shortest step.
const WINDOW_MAX: usize = (LOOKAHEAD_RANGE.1 / STEP_RANGE.0) as usize + 1;

/// Cycles over which the speed of the newest points is taken.
const RECENT: usize = 2;

/// The speed with which the reference enters and leaves the window is taken over one of so many parts of it: less shows
/// every late point as an acceleration, more knows the acceleration too late.
const WINDOW_ENDS: usize = 8;

/// Bandwidth of the tracking law, rad/s, for a gain: a spring of stiffness proportional to the gain. 300 gives 35.
fn bandwidth(gain: f64) -> f64 {
    2.0 * gain.sqrt()
}

/// A stream of points under way.
#[derive(Clone, Copy, Debug)]
pub struct Servo {
    /// The reference over the last cycles, the newest at `newest`.
    window: [[f64; 6]; WINDOW_MAX],
    newest: usize,
    /// Cycles of the mean filter.
    length: usize,
    goal: JointPositions,
    /// Time until the reference reaches the goal, s.
    left: f64,
    law: Follower,
}

impl Servo {
    /// A reference that stands where the arm is.
    pub fn new(q: &JointPositions, step: f64) -> Self {
        Self {
            window: [q.0; WINDOW_MAX],
            newest: 0,
            length: 1,
            goal: *q,
            left: 0.0,
            law: Follower::new(bandwidth(GAIN_RANGE.0), step),
        }
    }

    /// The next point: the reference reaches it in `duration` seconds.
    pub fn lead(
        &mut self,
        goal: &JointPositions,
        duration: f64,
        lookahead: f64,
        gain: f64,
        step: f64,
    ) {
        self.goal = *goal;
        self.left = duration;
        let cycles = (lookahead / step).round().max(1.0) as usize;
        self.length = cycles.min(WINDOW_MAX - 1);
        self.law = Follower::new(bandwidth(gain), step);
    }

    /// Where the last point is.
    pub fn goal(&self) -> &JointPositions {
        &self.goal
    }

    /// Goes no further: the goal becomes the reference of now.
    pub fn stop(&mut self) {
        self.goal = JointPositions(self.window[self.newest]);
        self.left = 0.0;
    }

    /// The reference `time` seconds later (the step, less when slowed down), as one more place of the window.
    fn move_reference(&mut self, time: f64) {
        let now = self.window[self.newest];
        let next = if time >= self.left {
            self.goal.0
        } else {
            let share = time / self.left;
            core::array::from_fn(|joint| now[joint] + (self.goal[joint] - now[joint]) * share)
        };
        self.left = (self.left - time).max(0.0);
        self.newest = (self.newest + 1) % WINDOW_MAX;
        self.window[self.newest] = next;
    }

    /// The states one step later; the reference moves by `time` seconds.
    pub(crate) fn next(
        &mut self,
        now: &[ScalarState; 6],
        arm: &OnlineArm,
        time: f64,
    ) -> [ScalarState; 6] {
        let step = arm.step;
        // The law leads to where the reference is now, so that both ends of the step belong together.
        let back = |cycles: usize| (self.newest + WINDOW_MAX - cycles) % WINDOW_MAX;
        let (newest, oldest) = (self.window[self.newest], self.window[back(self.length)]);
        let recent = self.window[back(RECENT)];
        let end = (self.length / WINDOW_ENDS).max(1);
        let (young, old) = (self.window[back(end)], self.window[back(self.length - end)]);
        let mut mean = [0.0; 6];
        for cycle in 0..self.length {
            for (sum, value) in mean.iter_mut().zip(self.window[back(cycle)]) {
                *sum += value / self.length as f64;
            }
        }
        let next = core::array::from_fn(|joint| {
            let speed = (newest[joint] - oldest[joint]) / (self.length as f64 * step);
            let error = mean[joint] - now[joint].position;
            let (v, a) = (now[joint].speed, now[joint].acceleration);
            if newest[joint] == oldest[joint]
                && error.abs() < SERVO_SETTLED
                && (newest[joint] - mean[joint]).abs() < SERVO_SETTLED
                && v.abs() * step < SERVO_SETTLED
                && a.abs() * step * step < SERVO_SETTLED
            {
                return ScalarState::at_rest(newest[joint]);
            }
            let newest_speed = (newest[joint] - recent[joint]) / (RECENT as f64 * step);
            // The mean's speed changes by what enters the window and what leaves it.
            let change = (newest[joint] - young[joint]) - (old[joint] - oldest[joint]);
            let acceleration = change / (end * self.length) as f64 / square(step);
            let wanted = self.law.acceleration_before(
                &now[joint],
                (mean[joint], speed, acceleration),
                (newest[joint], newest_speed),
                &arm.able[joint],
            );
            arm.axes[joint].nearest_safe(&now[joint], wanted, step)
        });
        self.move_reference(time);
        next
    }

    /// Whether the reference has come to its goal, and the arm at `q` with it.
    pub fn has_arrived(&self, q: &JointPositions) -> bool {
        self.left == 0.0 && self.goal == *q
    }
}
