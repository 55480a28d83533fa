//! Moving along a track, cycle by cycle: as fast as it allows, smoothed in time, slower or held on demand.
//!
//! A first motion accelerates and brakes with the full acceleration from one step to the next; the motion that is made
//! is its mean over a window of time. So the acceleration changes no faster than its bound over the window, which is an
//! S-curve of seven phases wherever the limits are the same: for those, with the window chosen by [`smoothing_window`],
//! the fastest there is (Biagiotti and Melchiorri, *Trajectory Planning for Automatic Machines and Robots*, 2008, 3.4
//! and 4.6: trajectories by chains of moving averages).
//!
//! A speed fraction slows its clock, so that the motion is the same, stretched. It is taken over where the motion
//! stands; one that comes on the way, a pause and a stop change what the first motion aims for, so their accelerations
//! are smoothed too.

mod hardest;

use super::extreme::{Extremum, Knot, WindowExtremum};
use super::{ScalarLimits, ScalarState, VelocityLimitCurve};
use crate::constants::WINDOW_RANGE;
use kinematics::bounds::within;
use kinematics::elementary::cbrt;

/// Steps in a window.
const STEPS: usize = 32;
/// Room for rounding where speeds are compared.
const SLACK: f64 = 1e-12;
/// From rest no way is left where it is less than this, of the place and by itself: steps of it would be lost in
/// rounding.
const MIN_DISTANCE: f64 = 1e-13;
/// By this part a motion is faster than the track only if that was lowered.
const OVERSPEED_TOLERANCE: f64 = 1e-6;
/// Steps of a foreseen motion before it counts as endless.
const MAX_PREDICTION_STEPS: usize = 200_000;

/// What is wanted of the motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProgressGoal {
    /// Go on at this fraction of the pace, in (0, 1].
    Run(f64),
    /// Brake on the path and stand.
    Stop,
    /// Brake on the path as hard as the arm can, and stand.
    StopHard,
    /// Come to rest with this acceleration, whatever the path bears: for an arm whose joints brake beside it, so that
    /// the place on the path stays near the arm. Unit of the way over s².
    HaltBeside(f64),
}

/// The window over which a motion under these limits over `length` is fastest; infinite lengths are allowed.
pub fn smoothing_window(limits: &ScalarLimits, length: f64) -> f64 {
    let reached = limits.acceleration / limits.jerk;
    let by_speed = (limits.speed / limits.jerk).sqrt();
    let by_length = cbrt(length / (2.0 * limits.jerk));
    let window = reached.min(by_speed).min(by_length);
    within(window, WINDOW_RANGE.0, WINDOW_RANGE.1)
}

/// A motion under way along a track.
#[derive(Clone, Copy, Debug)]
pub struct PathProgress {
    /// The first motion at the ends of the steps of a window, the oldest first, and one step ahead.
    knots: [Knot; STEPS + 2],
    /// What is known of the knots: the hardest speeding up and slowing down, and how many but the oldest stand still.
    max_speed_change: WindowExtremum,
    min_speed_change: WindowExtremum,
    knots_at_rest: usize,
    step: f64,
    /// Time since the last but one knot.
    phase: f64,
    /// Time of the motion's own clock since the start, s.
    time: f64,
    /// Seconds of the motion's own clock a second.
    time_scale: f64,
    wanted: ProgressGoal,
    fraction: f64,
    /// Share of its speed that what is laid over the motion leaves it; at rest as well it is no other clock, so that a
    /// motion that hardly moves is at full speed as soon as it may be.
    pace: f64,
    /// Where it is faster than the track allows it brakes as hard as the arm can.
    is_hard_braking: bool,
    /// The state after the last advance, on a track that ended there.
    cached_state: Option<(f64, ScalarState)>,
}

impl PathProgress {
    /// At rest at the beginning of `track`; the first [`advance`](Self::advance) moves.
    pub fn new(track: &VelocityLimitCurve) -> Self {
        Self {
            knots: [Knot::default(); STEPS + 2],
            max_speed_change: WindowExtremum::none(STEPS + 2),
            min_speed_change: WindowExtremum::none(STEPS + 2),
            knots_at_rest: STEPS + 1,
            step: track.window().max(WINDOW_RANGE.0) / STEPS as f64,
            phase: 0.0,
            time: 0.0,
            time_scale: 1.0,
            wanted: ProgressGoal::Stop,
            fraction: 0.0,
            pace: 1.0,
            is_hard_braking: false,
            cached_state: None,
        }
    }

    /// Changes what is wanted; takes effect in the next [`advance`](Self::advance).
    pub fn set_goal(&mut self, drive: ProgressGoal) {
        self.wanted = drive;
    }

    /// Whether it brakes as hard as the arm can where it is faster than the track allows.
    pub fn set_hard_braking(&mut self, is_hard: bool) {
        self.is_hard_braking = is_hard;
    }

    /// From now on it goes at this share of the speed that it would have otherwise, more than 0.
    pub fn slow_to(&mut self, pace: f64) {
        self.pace = pace;
    }

    /// Whether the motion is to go on.
    pub fn is_going(&self) -> bool {
        matches!(self.wanted, ProgressGoal::Run(_))
    }

    /// Time of the motion's own clock since the start, s: real time at full speed.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// The speed fraction that the motion follows now, 0 when it is halted.
    pub fn fraction(&self) -> f64 {
        self.fraction
    }

    /// The track up to here cannot be changed any more: the first motion has been there.
    pub fn committed(&self) -> f64 {
        self.knots[STEPS + 1].s
    }

    /// The oldest place that the motion still depends on.
    pub fn oldest(&self) -> f64 {
        self.knots[0].s
    }

    /// The speed of the first motion there.
    pub fn committed_speed(&self) -> f64 {
        self.knots[STEPS + 1].speed * self.time_scale
    }

    /// Whether the motion can go on over a track that has been changed: it is not too fast, and one that speeds up has
    /// time to end that first.
    pub fn can_continue_on(&self, track: &VelocityLimitCurve) -> bool {
        self.fits_as_before(track, 0.0)
    }

    /// Whether the motion can go on over a track that has been changed, or has at least as much leeway as on another
    /// track.
    pub fn fits_as_before(&self, track: &VelocityLimitCurve, before: f64) -> bool {
        let speed = self.committed_speed();
        self.leeway(track) >= before.min(0.0) - 1e-9 * speed * speed
    }

    /// By how much the square of its speed is less than what the track bears where that cannot be changed any more.
    pub fn leeway(&self, track: &VelocityLimitCurve) -> f64 {
        let (place, speed) = (self.committed(), self.committed_speed());
        let least = if self.speeding_up() > 0.0 {
            track.min_squared_limit(
                (track.index(place), place),
                place + speed * track.window() / self.time_scale,
            )
        } else {
            track.squared_limit(place)
        };
        least - speed * speed
    }

    /// True when the end of the track is reached.
    pub fn is_finished(&self, track: &VelocityLimitCurve) -> bool {
        self.knots[0].s >= track.end()
    }

    /// True when nothing moves: at the end, or halted.
    pub fn is_standing(&self, track: &VelocityLimitCurve) -> bool {
        self.is_finished(track) || !self.is_going() && self.is_at_rest()
    }

    /// Nothing of the first motion within the window moves.
    fn is_at_rest(&self) -> bool {
        self.knots.iter().all(|knot| knot.speed == 0.0)
            && self.knots[0].s == self.knots[STEPS + 1].s
    }

    /// The state `dt` seconds later; from the end of the track on exactly its end, at rest.
    pub fn advance(&mut self, dt: f64, track: &VelocityLimitCurve) -> ScalarState {
        self.fraction = match self.wanted {
            ProgressGoal::Run(fraction) => fraction,
            ProgressGoal::Stop | ProgressGoal::StopHard | ProgressGoal::HaltBeside(_) => 0.0,
        };
        if self.is_at_rest() {
            if !self.is_going() {
                return self.state(track);
            }
            self.start_from_rest(self.fraction, track);
        }
        if self.time_scale < 1.0 && (!self.is_going() || self.fraction > self.time_scale) {
            self.resync_to_real_time(track);
        }
        self.cached_state = None;
        let passed = dt * self.time_scale;
        self.time += passed;
        self.phase += passed;
        while self.phase >= self.step {
            self.phase -= self.step;
            self.advance_knot(track);
        }
        let state = self.state(track);
        self.cached_state = Some((track.end(), state));
        state
    }

    /// Takes its clock to the pace of real time: one that is slow takes its time to come to rest, too, and the mean
    /// over a window that is stretched would be faster than the track allows where that changes within it. What has
    /// been becomes the even acceleration that has the same place, speed and acceleration now, so that nothing jumps.
    fn resync_to_real_time(&mut self, track: &VelocityLimitCurve) {
        let now = self.state(track);
        let half = 0.5 * self.step * STEPS as f64;
        let (v, a) = (now.speed, now.acceleration);
        // Shortly before rest what comes would have to go backwards.
        if v <= -a * (half + self.step) {
            return;
        }
        let middle = now.position - a * half * half / 6.0;
        let at = |knot: usize| {
            let t = self.step * knot as f64 - half;
            Knot {
                s: middle + t * (v + 0.5 * a * t),
                speed: v + a * t,
            }
        };
        let hastened = Self {
            time_scale: 1.0,
            phase: 0.0,
            cached_state: None,
            ..*self
        }
        .with_knots(core::array::from_fn(at));
        if hastened.committed() <= self.committed() && hastened.can_continue_on(track) {
            *self = hastened;
        }
    }

    /// From rest at a fraction of the pace.
    fn start_from_rest(&mut self, fraction: f64, track: &VelocityLimitCurve) {
        self.time_scale = fraction;
        self.phase = 0.0;
        self.cached_state = None;
        self.set_last_knot(self.next_knot(track));
    }

    /// The state now.
    pub fn state(&self, track: &VelocityLimitCurve) -> ScalarState {
        if let Some((end, state)) = self.cached_state
            && end == track.end()
        {
            return state;
        }
        if self.is_finished(track) {
            return ScalarState::at_rest(track.end());
        }
        let own = self.smoothed();
        ScalarState {
            position: own.position,
            speed: own.speed * self.time_scale,
            acceleration: own.acceleration * self.time_scale * self.time_scale,
        }
    }

    /// Time of its own clock until the end of the track and until the mean has passed `s`, s.
    pub fn predict_times(&self, track: &VelocityLimitCurve, place: f64) -> (f64, f64) {
        let mut travel = *self;
        travel.wanted = ProgressGoal::Run(travel.time_scale);
        travel.pace = 1.0;
        if travel.is_at_rest() && travel.knots[0].s < track.end() {
            travel.start_from_rest(1.0, track);
            travel.wanted = ProgressGoal::Run(1.0);
        }
        let mut time = -travel.phase;
        let mut passed = None;
        for _ in 0..MAX_PREDICTION_STEPS {
            if travel.knots[0].s >= track.end() {
                break;
            }
            if passed.is_none() && travel.middle() >= place {
                passed = Some(time);
            }
            let until = if passed.is_none() {
                place
            } else {
                f64::INFINITY
            };
            time += travel.skip_evenly(track, until);
            travel.advance_knot(track);
            time += travel.step;
        }
        (time, passed.unwrap_or(time))
    }

    fn middle(&self) -> f64 {
        self.knots[STEPS / 2].s
    }

    /// The mean of the first motion over the window, on its own clock.
    fn smoothed(&self) -> ScalarState {
        let window = self.step * STEPS as f64;
        let knots = &self.knots;
        let (old_left, new_left) = (knots[0], knots[STEPS]);
        let old = self.between(&knots[0], &knots[1]);
        let new = self.between(&knots[STEPS], &knots[STEPS + 1]);
        let rest_of_first = self.integral(&old_left, &knots[1], self.step)
            - self.integral(&old_left, &knots[1], self.phase);
        let mut sum = rest_of_first + self.integral(&new_left, &knots[STEPS + 1], self.phase);
        if self.knots_at_rest == 0 && knots[0].speed > 0.0 {
            // Nowhere at rest: every step lasts to its end, and all of them are worked out side by side.
            let mut whole = [0.0; STEPS - 1];
            for (k, whole) in whole.iter_mut().enumerate() {
                let (from, to) = (knots[k + 1], knots[k + 2]);
                let change = (to.speed - from.speed) / self.step;
                let place = from.s - old_left.s;
                *whole =
                    self.step * (place + self.step * (from.speed / 2.0 + self.step * change / 6.0));
            }
            whole.iter().for_each(|whole| sum += whole);
        } else {
            for pair in knots.windows(2).take(STEPS).skip(1) {
                sum += self.integral(&pair[0], &pair[1], self.step);
            }
        }
        ScalarState {
            position: old_left.s + sum / window,
            speed: (new.s - old.s) / window,
            acceleration: (new.speed - old.speed) / window,
        }
    }

    /// The first motion at the present phase between two knots.
    fn between(&self, from: &Knot, to: &Knot) -> Knot {
        let (change, ends) = self.change(from, to);
        if self.phase >= ends {
            return *to;
        }
        let t = self.phase;
        Knot {
            s: from.s + t * (from.speed + 0.5 * change * t),
            speed: from.speed + change * t,
        }
    }

    /// The acceleration from one knot to the next, and how long it lasts: where the motion comes to rest it may do so
    /// within the step.
    fn change(&self, from: &Knot, to: &Knot) -> (f64, f64) {
        if to.speed > 0.0 || from.speed <= 0.0 {
            return ((to.speed - from.speed) / self.step, self.step);
        }
        let ends = (2.0 * (to.s - from.s) / from.speed).min(self.step);
        (-from.speed / ends.max(1e-12), ends)
    }

    /// Integral of the place, counted from the oldest knot's, over the first `t` seconds after `from`.
    fn integral(&self, from: &Knot, to: &Knot, t: f64) -> f64 {
        let (change, ends) = self.change(from, to);
        let place = from.s - self.knots[0].s;
        let moving = t.min(ends);
        let rest = (t - moving) * (to.s - self.knots[0].s);
        moving * (place + moving * (from.speed / 2.0 + moving * change / 6.0)) + rest
    }

    /// One step of the first motion.
    fn next_knot(&self, track: &VelocityLimitCurve) -> Knot {
        let now = self.knots[STEPS + 1];
        if now.s >= track.end() {
            return Knot {
                s: track.end(),
                speed: 0.0,
            };
        }
        let gear = match self.wanted {
            // A slow clock goes no faster than it is before it is hastened.
            ProgressGoal::Run(fraction) => (fraction / self.time_scale).min(1.0) * self.pace,
            ProgressGoal::Stop | ProgressGoal::StopHard | ProgressGoal::HaltBeside(_) => 0.0,
        };
        let here = track.index(now.s);
        let allowed = track.squared_limit_in(here, now.s).sqrt();
        if gear > 0.0 && now.speed <= gear * allowed * (1.0 + 1e-9) {
            // Slower by a factor is the same in steps that are shorter by it.
            let slowed = Knot {
                speed: now.speed / gear,
                ..now
            };
            let next = self.accelerate_step(slowed, gear, (track, here));
            let next = Knot {
                speed: next.speed * gear,
                ..next
            };
            // One whose pace was lowered on the way may have to slow down while the mean still speeds up: that comes
            // first. It is faster than the pace for a moment then, not than the track.
            if next.speed >= now.speed || self.speeding_up() <= 0.0 {
                return next;
            }
            return self.brake_step(now, next.speed, track);
        }
        self.brake_step(now, gear * allowed, track)
    }

    /// The largest acceleration of the first motion within the window; 0 at least.
    fn speeding_up(&self) -> f64 {
        self.max_speed_change.change / self.step
    }

    /// The smallest acceleration of the first motion within the window; 0 at most.
    fn slowing_down(&self) -> f64 {
        let slower = self.min_speed_change.change / self.step;
        if self.knots_at_rest == 0 {
            return slower;
        }
        self.knots.windows(2).fold(slower, |least, pair| {
            if pair[1].speed <= 0.0 && pair[0].speed > 0.0 {
                // Within the step.
                least.min(self.change(&pair[0], &pair[1]).0)
            } else {
                least
            }
        })
    }

    /// Forgets the oldest knot and adds the next one.
    fn advance_knot(&mut self, track: &VelocityLimitCurve) {
        self.knots_at_rest -= usize::from(self.knots[1].speed <= 0.0);
        self.knots.copy_within(1.., 0);
        self.knots_at_rest += usize::from(self.knots[STEPS + 1].speed <= 0.0);
        self.max_speed_change = self
            .max_speed_change
            .after_shift(&self.knots, Extremum::Max);
        self.min_speed_change = self
            .min_speed_change
            .after_shift(&self.knots, Extremum::Min);
        self.set_last_knot(self.next_knot(track));
    }

    /// Puts a knot in the place of the last one, which is the same as the one before.
    fn set_last_knot(&mut self, knot: Knot) {
        let last = self.knots[STEPS + 1];
        self.knots_at_rest -= usize::from(last.speed <= 0.0);
        self.knots_at_rest += usize::from(knot.speed <= 0.0);
        self.knots[STEPS + 1] = knot;
        let newest = knot.speed - last.speed;
        self.max_speed_change = self
            .max_speed_change
            .including(newest, &self.knots, Extremum::Max);
        self.min_speed_change = self
            .min_speed_change
            .including(newest, &self.knots, Extremum::Min);
    }

    /// The motion with other knots.
    fn with_knots(self, knots: [Knot; STEPS + 2]) -> Self {
        let halts = knots[1..].iter().filter(|knot| knot.speed <= 0.0);
        Self {
            max_speed_change: WindowExtremum::of(&knots, Extremum::Max),
            min_speed_change: WindowExtremum::of(&knots, Extremum::Min),
            knots_at_rest: halts.count(),
            knots,
            ..self
        }
    }

    /// One step towards a lower speed than the present one.
    fn brake_step(&self, now: Knot, goal: f64, track: &VelocityLimitCurve) -> Knot {
        let (h, rate) = (self.step, self.time_scale);
        let (asked, hardest, jerk) = track.braking_at(now.s, now.speed * rate);
        // How hard, and how much the acceleration may change within the window.
        let (hard, change) = match self.wanted {
            ProgressGoal::HaltBeside(deceleration) => (deceleration, f64::INFINITY),
            ProgressGoal::StopHard => (hardest, (jerk * track.window() * rate).max(hardest)),
            _ if self.is_hard_braking => (hardest, (jerk * track.window() * rate).max(hardest)),
            ProgressGoal::Stop | ProgressGoal::Run(_) => (asked, asked),
        };
        let largest = self.speeding_up();
        let square = rate * rate;
        let a = (-hard / square).max(largest - change / square).min(0.0);
        let next = (now.speed + a * h).max(goal).max(0.0).min(now.speed);
        let there = now.s + 0.5 * (now.speed + next) * h;
        let ahead = track.squared_limit(there).sqrt() / rate;
        // A motion that is faster than the track allows, because that was lowered, comes down as it can.
        let is_over =
            now.speed * rate > track.squared_limit(now.s).sqrt() * (1.0 + OVERSPEED_TOLERANCE);
        if next > ahead && !is_over {
            let (place, speed) = track.follow_limit(now.s, now.speed * rate, h / rate);
            return Knot {
                s: place,
                speed: (speed / rate).min(now.speed),
            };
        }
        // A motion above a lowered limit still slows down no later than was planned.
        if is_over && next > track.uncapped_squared_limit_at(there).sqrt() / rate {
            let (place, speed) = track.follow_uncapped_limit(now.s, now.speed * rate, h / rate);
            return Knot {
                s: place,
                speed: (speed / rate).min(now.speed),
            };
        }
        // The motion may come to rest within the step.
        let lasts = if next > 0.0 || a == 0.0 {
            h
        } else {
            (-now.speed / a).min(h)
        };
        let place = now.s + 0.5 * (now.speed + next) * lasts;
        Knot {
            s: place.min(track.end()),
            speed: if place < track.end() { next } else { 0.0 },
        }
    }

    /// One step as fast as the track allows; the step and the window are longer by the gear.
    fn accelerate_step(
        &self,
        now: Knot,
        gear: f64,
        (track, here): (&VelocityLimitCurve, usize),
    ) -> Knot {
        let (place, speed) = (now.s, now.speed);
        if speed <= 0.0 && track.end() - place <= MIN_DISTANCE * (1.0 + place) {
            return Knot {
                s: track.end(),
                speed: 0.0,
            };
        }
        let (h, window) = (self.step * gear, track.window() * gear);
        let asked = track.acceleration_at(here, speed);
        // What slowed down within the window must have gone from the mean before it may speed up fully.
        let least = self.slowing_down() / (gear * gear);
        let up = speed + (asked + least).max(0.0) * h;
        // After speeding up there has to be time for the mean to do so too before it slows down.
        let room = |next: f64| {
            let ahead = place + next * (h + window);
            track.min_squared_limit((here, place), ahead) - next * next
        };
        // The cell at the end of the step is this one or close behind it.
        let there =
            track.squared_limit_in(track.index_from(here, place + speed * h), place + speed * h);
        let top = there.sqrt();
        let up = up.min(top);
        if up >= speed && up > 0.0 && room(up) >= -SLACK * up * up {
            return knot_at_speed(now, up, h, track);
        }
        if up > speed && room(speed) > 0.0 {
            let (mut low, mut high) = (speed, up);
            for _ in 0..if speed > 0.0 { 12 } else { 50 } {
                let middle = 0.5 * (low + high);
                if room(middle) >= 0.0 {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            if low > 0.0 {
                return knot_at_speed(now, low, h, track);
            }
        }
        if there >= speed * speed * (1.0 - SLACK) && speed > 0.0 {
            return knot_at_speed(now, speed, h, track);
        }
        if speed <= 0.0 && up <= 0.0 && least < 0.0 {
            // The motion has just come to rest, and may go on in a moment.
            return now;
        }
        if speed <= 0.0 {
            // Too short a way to speed up on.
            return Knot {
                s: track.end(),
                speed: 0.0,
            };
        }
        let (place, next) = track.follow_limit(place, speed, h);
        Knot {
            s: place,
            speed: next.min(speed),
        }
    }
}

fn knot_at_speed(now: Knot, speed: f64, h: f64, track: &VelocityLimitCurve) -> Knot {
    let place = now.s + 0.5 * (now.speed + speed) * h;
    if place >= track.end() {
        return Knot {
            s: track.end(),
            speed: 0.0,
        };
    }
    Knot { s: place, speed }
}
