//! Durations that are wanted of legs: how fast each goes so that the waypoints of a chain are passed in time.
//!
//! A motion by itself is stretched. One of a chain goes evenly, at the speed that takes it from waypoint to waypoint in
//! the time that is left: what one is late or early is made good by those behind it.

use kinematics::bounds::within;

use super::{DurationShortfall, MotionQueue, QueuedSegment};
use crate::constants::{
    CATCH_UP, DURATION_SEARCH_STEPS, EARLY, EASE, MAX_DURATION, RAMPS, START_OF_MOTION,
};
use crate::scalar::{Pace, PathProgress};

/// Times that differ by less are the same, s.
const SAME_TIME: f64 = 1e-4;
/// A chain that ends so much later than wanted is in time, s.
const NOT_FELT: f64 = 2e-3;
/// Most later beginnings that are tried for a slower leg while the arm is too fast for it.
const ATTEMPTS_TO_FIT: u32 = 6;

/// What the pace of the last leg is chosen for.
struct Timing {
    /// Who goes there; at rest at the beginning of the way without one.
    travel: Option<PathProgress>,
    /// Where the curve before the leg begins and ends, and the speed before it.
    entry: f64,
    exit: f64,
    speed_before: f64,
    /// What the motion has to spare at full pace.
    leeway: f64,
    /// What is wanted, and until the leg is due, s.
    wanted: f64,
    left: f64,
}

impl MotionQueue {
    /// Slows the last leg down, which follows a curve from one place to another, so that it takes the time that is
    /// wanted of it. That counts from the waypoint before: from when that leg is due, otherwise from the middle of the
    /// curve. Without a travel the motion begins from rest.
    pub(super) fn keep_time(
        &mut self,
        travel: Option<&PathProgress>,
        (entry, exit): (f64, f64),
    ) -> DurationShortfall {
        let last = *self.legs.last()?;
        let wanted = last.leg.request.duration;
        if wanted <= 0.0 {
            return None;
        }
        let mut others = self.legs.iter().rev().skip(1);
        let before = others.next().copied().filter(|_| travel.is_some());
        let now = travel.map_or(0.0, PathProgress::time);
        let middle = 0.5 * (entry + exit);
        let passed = now + travel.map_or(0.0, |travel| travel.predict_times(&self.track, middle).1);
        let begins = before.map_or(0.0, |before| before.deadline);
        let begins = if begins > 0.0 { begins } else { passed };
        let overrun = match travel {
            Some(_) => 0.0,
            None => core::mem::take(&mut self.overrun),
        };
        let due = (begins + wanted - overrun).max(0.0);
        self.set_due(due);
        if self.track.end() <= exit {
            return None;
        }
        let timing = Timing {
            travel: travel.copied(),
            entry,
            exit,
            speed_before: before.map_or(f64::INFINITY, |before| before.speed),
            leeway: travel.map_or(0.0, |travel| travel.leeway(&self.track)),
            wanted,
            left: due - now,
        };
        let nominal = (self.track.end() - middle) / wanted;
        let late = if last.leg.radius > 0.0 {
            self.keep_pace(&timing, nominal, due - passed);
            self.track.least_time(middle) - wanted
        } else if travel.is_none() {
            let stretched = |inverse: f64| Pace::stretched(1.0 / inverse);
            let guess = timing.left / self.time_at(&timing, Pace::FULL);
            self.slow_down(&timing, (1.0, guess), stretched)
        } else {
            self.end_in_time(&timing, nominal)
        };
        if late > 0.0 {
            self.set_due(due + late);
        }
        let in_chain = if travel.is_some() { NOT_FELT } else { 0.0 };
        let tolerated = START_OF_MOTION * wanted + in_chain + overrun;
        (late > tolerated).then_some((wanted, wanted + late))
    }

    /// Slows a timed leg that begins at `exit` down to what it will not have to exceed, while its pace is not known;
    /// not below the speed that the motion has.
    pub(super) fn keep_pace_about(&mut self, exit: f64, leg: &QueuedSegment, speed: f64) {
        let wanted = leg.leg.request.duration;
        if wanted > 0.0 {
            let nominal = (leg.end - exit) / wanted;
            let pace = Pace {
                speed: speed.max(EARLY * CATCH_UP * nominal),
                ..Pace::FULL
            };
            self.track.set_pace(exit, pace);
        }
    }

    fn set_due(&mut self, due: f64) {
        if let Some(last) = self.legs.last_mut() {
            last.deadline = due;
        }
    }

    /// Slows the last leg down so that the arm stands at its end when it is due; by how much it is late, s.
    fn end_in_time(&mut self, timing: &Timing, nominal: f64) -> f64 {
        let gentle = ramps(nominal, timing);
        // No cell is faster.
        let quick = 1.0 / self.track.fastest(timing.exit);
        let at = |acceleration| {
            move |inverse: f64| Pace {
                share: 1.0,
                speed: 1.0 / inverse,
                acceleration,
            }
        };
        let guess = 1.0 / nominal;
        let late = self.slow_down(timing, (quick, guess), at(gentle));
        if late <= 0.0 {
            return late;
        }
        self.slow_down(timing, (quick, guess), at(f64::INFINITY))
    }

    /// Has the last leg pass its waypoint in the time that is left from the one before on; a little earlier where it
    /// comes to rest there in time, then, if nothing follows.
    fn keep_pace(&mut self, timing: &Timing, nominal: f64, left: f64) {
        let acceleration = ramps(nominal, timing);
        let way = nominal * timing.wanted;
        let most = CATCH_UP * nominal;
        let speed = if timing.travel.is_some() {
            if left > 0.0 { way / left } else { most }
        } else {
            // From rest speeding up takes its time, and the mean over the window lags behind.
            let left = left - 0.5 * self.track.window();
            let under = left * left - 2.0 * way / acceleration;
            if left > 0.0 && under > 0.0 {
                acceleration * (left - under.sqrt())
            } else {
                most
            }
        };
        let speed = speed.min(most);
        let slowest = match timing.travel {
            Some(_) => EASE * nominal,
            None => 0.0,
        };
        let at = |inverse: f64| Pace {
            share: 1.0,
            speed: slowest.max(1.0 / inverse),
            acceleration,
        };
        let quick = 1.0 / (EARLY * speed.max(nominal));
        self.slow_down(timing, (quick, 1.0 / speed), at);
    }

    /// Slows the last leg down until the arm stands at the end when it is due, or as near to that as it can; by how
    /// much it is late, s. `quick` is the fastest pace, `guess` one that may do.
    fn slow_down(
        &mut self,
        timing: &Timing,
        (quick, guess): (f64, f64),
        pace: impl Fn(f64) -> Pace,
    ) -> f64 {
        let mut fastest = (quick, self.time_at(timing, pace(quick)));
        if fastest.1 >= timing.left {
            return fastest.1 - timing.left;
        }
        let mut slowest: Option<(f64, f64)> = None;
        let mut inverse = within(guess, quick, MAX_DURATION.max(quick));
        for _ in 0..DURATION_SEARCH_STEPS {
            let time = self.time_at(timing, pace(inverse));
            if time <= timing.left {
                fastest = (inverse, time);
                if timing.left - time < SAME_TIME {
                    break;
                }
            } else {
                slowest = Some((inverse, time));
            }
            inverse = match slowest {
                Some((slow, late)) => {
                    let share = (timing.left - fastest.1) / (late - fastest.1);
                    fastest.0 + (slow - fastest.0) * within(share, 0.02, 0.98)
                }
                None => inverse * (timing.left / time).max(1.0 + 1e-6),
            };
        }
        self.time_at(timing, pace(fastest.0));
        0.0
    }

    /// How long the arm takes until it stands at the end when the last leg has this pace, s.
    fn time_at(&mut self, timing: &Timing, pace: Pace) -> f64 {
        let Some(last) = self.legs.last_mut() else {
            return 0.0;
        };
        last.speed = pace.speed;
        let mut last = *last;
        let rate = self.route.last().map_or(1.0, |span| span.rate);
        let Some(travel) = timing.travel else {
            self.track.set_pace(timing.exit, pace);
            self.open_zone(&mut last, rate);
            self.track.recompute();
            return PathProgress::new(&self.track)
                .predict_times(&self.track, f64::INFINITY)
                .0;
        };
        let now = travel.committed_speed();
        let reach = 0.5 * self.track.window() * now;
        // The curve between two timed legs is no faster than both.
        let mut before = Pace {
            speed: pace.speed.max(timing.speed_before),
            ..pace
        };
        for attempt in 0..=ATTEMPTS_TO_FIT {
            // Where the arm is too fast already it keeps its speed a little longer.
            let from = match attempt {
                0 => timing.exit,
                ATTEMPTS_TO_FIT => f64::INFINITY,
                _ => timing.exit + reach * f64::from(attempt),
            };
            self.track.set_pace(timing.entry, before);
            self.track.set_pace(from, pace);
            self.open_zone(&mut last, rate);
            self.track.recompute();
            if travel.fits_as_before(&self.track, timing.leeway) {
                break;
            }
            before.speed = before.speed.max(now);
        }
        self.set_last(last);
        travel.predict_times(&self.track, f64::INFINITY).0
    }

    fn set_last(&mut self, leg: QueuedSegment) {
        if let Some(last) = self.legs.last_mut() {
            *last = leg;
        }
    }
}

/// Acceleration with which a timed leg of a chain goes over to its speed: in a part of its time.
fn ramps(nominal: f64, timing: &Timing) -> f64 {
    let before = timing.speed_before;
    let speed = if before.is_finite() {
        nominal.max(before)
    } else {
        nominal
    };
    RAMPS * speed / timing.wanted
}
