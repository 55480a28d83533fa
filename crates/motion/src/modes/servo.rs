//! servoj: joint positions from a stream of points (manual 3.1.6).
//!
//! The points are joined by straight lines, each as long as its `t`; a mean over the look-ahead window smooths them. It
//! is the mean of a mean, one over most of the window and one over the rest, so that its speed and acceleration are
//! those of points already known: what moves evenly or swings slowly comes out as it went in, half the window late,
//! whatever the gain. A tracking law whose bandwidth follows the gain makes the setpoints, pieces of constant jerk and
//! so a cubic spline.
//!
//! Nothing is amplified. The arm is never faster than what lets it stop within the band of the points in the window,
//! and where they have led steadily one way, as far beyond as braking from that speed takes. Of points that go to and
//! fro within the window only the mean is followed, not its speed.
//!
//! When the stream stops the reference stands at its last point and the arm comes to rest there. Nothing here needs the
//! points to come evenly: a late one is a reference that stood still for a while.

use kinematics::JointPositions;
use kinematics::elementary::square;

use super::OnlineContext;
use super::axis::AxisLimits;
use super::follower::TrackingLaw;
use crate::constants::{PAUSE_OF_STREAMS, SERVO_SETTLED, STEP_RANGE};
use crate::scalar::ScalarState;

/// Range of the look-ahead, s (manual 3.1.6).
pub const LOOKAHEAD_RANGE: (f64, f64) = (0.03, 0.2);
/// Range of the gain (manual 3.1.6).
pub const GAIN_RANGE: (f64, f64) = (100.0, 2000.0);

/// Places of the longest window at the shortest step, and two before it.
const WINDOW_MAX: usize = (LOOKAHEAD_RANGE.1 / STEP_RANGE.0) as usize + 3;

/// The second mean is over one of so many parts of the window: less shows every late point as an acceleration.
const WINDOW_ENDS: usize = 8;

/// The points lead one way when they do so in each of so many parts of the window.
const STEADY_PARTS: usize = 4;

/// Points whose way within the window is longer than this times their band go to and fro: a swing of which there is no
/// more than one turn in the window does not. Their speed says nothing then, and only their mean is followed.
const TO_AND_FRO: f64 = 2.0;

/// Share of what a joint can do that it stops with at the ends of the band: what it can do changes on the way.
const STOPPING_SHARE: f64 = 0.97;

/// Bandwidth of the tracking law, rad/s, for a gain: a spring of stiffness proportional to the gain. 300 gives 35.
fn bandwidth(gain: f64) -> f64 {
    2.0 * gain.sqrt()
}

/// Where the points in the window are.
#[derive(Clone, Copy, Debug)]
struct ReferenceBand {
    /// The lowest point in the window.
    low: f64,
    /// The highest point in the window, not below `low`.
    high: f64,
    /// Speed with which all points lead downwards, 0 or less.
    downward_speed: f64,
    /// Speed with which all points lead upwards, 0 or more.
    upward_speed: f64,
    /// Share of the points' speeds that can be followed: 1 unless they go to and fro, less the more they do.
    feedforward_weight: f64,
}

/// A stream of points under way.
#[derive(Clone, Copy, Debug)]
pub struct ServoMode {
    /// The reference over the last cycles, the newest at `newest`.
    window: [[f64; 6]; WINDOW_MAX],
    newest: usize,
    /// Cycles of the window.
    length: usize,
    goal: JointPositions,
    /// Time until the reference reaches the goal, s.
    time_to_goal: f64,
    law: TrackingLaw,
}

impl ServoMode {
    /// A reference that stands where the arm is.
    pub fn new(q: &JointPositions, step: f64) -> Self {
        Self {
            window: [q.0; WINDOW_MAX],
            newest: 0,
            length: 1,
            goal: *q,
            time_to_goal: 0.0,
            law: TrackingLaw::new(bandwidth(GAIN_RANGE.0), step),
        }
    }

    /// The next point: the reference reaches it in `duration` seconds.
    pub fn set_next_point(
        &mut self,
        goal: &JointPositions,
        duration: f64,
        lookahead: f64,
        gain: f64,
        step: f64,
    ) {
        self.goal = *goal;
        self.time_to_goal = duration;
        let cycles = (lookahead / step).round().max(1.0) as usize;
        self.length = cycles.min(WINDOW_MAX - 2);
        self.law = TrackingLaw::new(bandwidth(gain), step);
    }

    /// The reference stands at `q` now and goes on to the last point from there.
    pub fn resume_from(&mut self, q: &JointPositions) {
        self.window = [q.0; WINDOW_MAX];
    }

    /// The window as it is seen from other axes.
    pub(crate) fn seen_from(&mut self, axes: impl Fn(&[f64; 6]) -> [f64; 6]) {
        for place in &mut self.window {
            *place = axes(place);
        }
        self.goal = JointPositions(axes(&self.goal.0));
    }

    /// Where the last point is.
    pub fn goal(&self) -> &JointPositions {
        &self.goal
    }

    /// The reference `time` seconds later (the step, less when slowed down), as one more place of the window.
    fn move_reference(&mut self, time: f64) {
        let now = self.window[self.newest];
        let next = if time >= self.time_to_goal {
            self.goal.0
        } else {
            let share = time / self.time_to_goal;
            core::array::from_fn(|joint| now[joint] + (self.goal[joint] - now[joint]) * share)
        };
        self.time_to_goal = (self.time_to_goal - time).max(0.0);
        self.newest = (self.newest + 1) % WINDOW_MAX;
        self.window[self.newest] = next;
    }

    /// The reference so many cycles ago.
    fn reference_at(&self, cycles: usize) -> &[f64; 6] {
        &self.window[(self.newest + WINDOW_MAX - cycles) % WINDOW_MAX]
    }

    /// The mean over the window with its speed and acceleration now.
    fn smoothed(&self, step: f64) -> [ScalarState; 6] {
        let length = self.length;
        let short = (length / WINDOW_ENDS).max(2).min(length);
        let long = length + 1 - short;
        let mut mean = [0.0; 6];
        let mut ends = [[0.0; 6]; 2];
        for cycle in 0..=length {
            let place = self.reference_at(cycle);
            let weight = (cycle + 1).min(short).min(long).min(length - cycle) as f64;
            for joint in 0..6 {
                mean[joint] += place[joint] * weight / (short * long) as f64;
                if cycle < short {
                    ends[0][joint] += place[joint] / short as f64;
                }
                if cycle >= long {
                    ends[1][joint] += place[joint] / short as f64;
                }
            }
        }
        let (young, old) = (self.reference_at(short), self.reference_at(long));
        let (newest, oldest) = (self.reference_at(0), self.reference_at(length + 1));
        core::array::from_fn(|joint| {
            let change = (newest[joint] - young[joint]) - (old[joint] - oldest[joint]);
            let acceleration = change / (short * long) as f64 / square(step);
            // The difference of two cycles is the speed in the middle between them.
            let speed = (ends[0][joint] - ends[1][joint]) / (long as f64 * step);
            ScalarState {
                position: mean[joint],
                speed: speed + 0.5 * step * acceleration,
                acceleration,
            }
        })
    }

    /// Where the points in the window are, and how fast they lead one way all the time.
    fn band(&self, joint: usize, step: f64) -> ReferenceBand {
        let part = (self.length / STEADY_PARTS).max(1);
        let mut band = ReferenceBand {
            low: f64::INFINITY,
            high: f64::NEG_INFINITY,
            downward_speed: f64::NEG_INFINITY,
            upward_speed: f64::INFINITY,
            feedforward_weight: 1.0,
        };
        let mut way = 0.0;
        for cycle in 0..=self.length {
            let place = self.reference_at(cycle)[joint];
            if cycle < self.length {
                way += (place - self.reference_at(cycle + 1)[joint]).abs();
            }
            band.low = band.low.min(place);
            band.high = band.high.max(place);
            if cycle % part == 0 && cycle + part <= self.length {
                let speed = (place - self.reference_at(cycle + part)[joint]) / (part as f64 * step);
                band.downward_speed = band.downward_speed.max(speed);
                band.upward_speed = band.upward_speed.min(speed);
            }
        }
        (band.downward_speed, band.upward_speed) =
            (band.downward_speed.min(0.0), band.upward_speed.max(0.0));
        let once = TO_AND_FRO * (band.high - band.low);
        if way > once {
            band.feedforward_weight = square(square(once / way));
        }
        band
    }

    /// The states one step later; the reference moves by `time` seconds.
    pub(crate) fn next(
        &mut self,
        now: &[ScalarState; 6],
        arm: &OnlineContext,
        time: f64,
    ) -> [ScalarState; 6] {
        self.next_within(now, [&arm.available_axes, &arm.axes], arm.step, time)
    }

    /// The states one step later while nothing that is asked for counts: the joints brake, and the reference waits
    /// where they are.
    pub(crate) fn next_held(
        &mut self,
        now: &[ScalarState; 6],
        arm: &OnlineContext,
    ) -> [ScalarState; 6] {
        let next = core::array::from_fn(|joint| {
            let (now, axis) = (&now[joint], &arm.axes[joint]);
            let gentle = AxisLimits {
                acceleration: PAUSE_OF_STREAMS * axis.acceleration,
                ..*axis
            };
            // Harder where the gentle way would lead out of the range.
            let braking = if gentle.brakes_inside(now) {
                &gentle
            } else {
                axis
            };
            axis.clamp_to_safe(now, &braking.brake_step(now, arm.step), arm.step)
                .0
        });
        self.resume_from(&JointPositions(
            next.map(|state: ScalarState| state.position),
        ));
        next
    }

    /// One step of the tracking law for any six numbers, within what they can do and what they may do.
    pub(crate) fn next_within(
        &mut self,
        now: &[ScalarState; 6],
        [able, axes]: [&[AxisLimits; 6]; 2],
        step: f64,
        time: f64,
    ) -> [ScalarState; 6] {
        // The law leads to where the reference is now, so that both ends of the step belong together.
        let smoothed = self.smoothed(step);
        let (newest, oldest) = (self.reference_at(0), self.reference_at(self.length));
        let next = core::array::from_fn(|joint| {
            let (now, wanted, able) = (&now[joint], &smoothed[joint], &able[joint]);
            if newest[joint] == oldest[joint]
                && (wanted.position - now.position).abs() < SERVO_SETTLED
                && (newest[joint] - wanted.position).abs() < SERVO_SETTLED
                && now.speed.abs() * step < SERVO_SETTLED
                && now.acceleration.abs() * step * step < SERVO_SETTLED
            {
                return ScalarState::at_rest(newest[joint]);
            }
            let band = self.band(joint, step);
            let wanted = ScalarState {
                speed: band.feedforward_weight * wanted.speed,
                acceleration: band.feedforward_weight * wanted.acceleration,
                ..*wanted
            };
            let wanted = self.law.acceleration_with(now, &wanted, able);
            let kept = stopping_limits(&band, able, now).nearest_safe(now, wanted, step);
            axes[joint].clamp_to_safe(now, &kept, step).0
        });
        self.move_reference(time);
        next
    }

    /// Whether the reference has come to its goal, and the arm at `q` with it.
    pub fn has_arrived(&self, q: &JointPositions) -> bool {
        self.time_to_goal == 0.0 && self.goal == *q
    }
}

/// The joint with a range in which the arm may come to rest: the band, and where that leads steadily one way as far
/// beyond as braking from its speed, or from the joint's where that is less, takes.
fn stopping_limits(band: &ReferenceBand, able: &AxisLimits, now: &ScalarState) -> AxisLimits {
    let axis = AxisLimits {
        // A joint that is heavier to move than a moment ago may keep the acceleration that it has.
        acceleration: (STOPPING_SHARE * able.acceleration).max(now.acceleration.abs()),
        speed: able.speed.max(now.speed.abs()),
        ..*able
    };
    let beyond = |speed: f64| axis.braking_distance(speed);
    let low = band.low - beyond(band.downward_speed.abs().min((-now.speed).max(0.0)));
    let high = band.high + beyond(band.upward_speed.min(now.speed.max(0.0)));
    AxisLimits {
        // From outside it may come back.
        min: low.min(now.position),
        max: high.max(now.position),
        ..axis
    }
}
