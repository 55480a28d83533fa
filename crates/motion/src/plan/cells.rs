//! A planned leg cell by cell: how far along its path each reaches and what it bears.

use crate::constants::{ACCELERATION_RISE, MAX_INTERVALS_PER_SEGMENT};
use crate::scalar::{IntervalLimits, ScalarLimits, smoothing_window};

/// The cells of one leg, in its own s.
#[derive(Clone, Debug, Default)]
pub struct SegmentLimits {
    list: Vec<(f64, IntervalLimits)>,
}

impl SegmentLimits {
    /// An empty list with room for the cells of any leg.
    pub fn new() -> Self {
        Self {
            list: Vec::with_capacity(MAX_INTERVALS_PER_SEGMENT),
        }
    }

    /// Forgets all cells.
    pub fn clear(&mut self) {
        self.list.clear();
    }

    /// Adds one; the last one grows where there is no more room.
    pub fn push(&mut self, until: f64, limits: IntervalLimits) {
        if self.list.len() < self.list.capacity() {
            self.list.push((until, limits));
        } else if let Some((end, last)) = self.list.last_mut() {
            *end = until;
            last.restrict_to(&limits);
        }
    }

    /// Where each ends, and what it bears.
    pub fn iter(&self) -> impl Iterator<Item = (f64, &IntervalLimits)> {
        self.list.iter().map(|(until, limits)| (*until, limits))
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.list.len()
    }

    /// Leaves out the last cells as far as they bear less than `speed`; where the way ends then. The first one stays.
    pub fn end_before_slow(&mut self, speed: f64) -> Option<f64> {
        while self.list.len() > 1 && self.list.last()?.1.speed < speed {
            self.list.pop();
        }
        self.list.last().map(|(until, _)| *until)
    }

    /// The least speed, and the least acceleration at speed.
    pub fn min_speed_and_acceleration(&self) -> (f64, f64) {
        self.list
            .iter()
            .fold((f64::INFINITY, f64::INFINITY), |(speed, a), (_, limits)| {
                let own = limits.asked[1].min(limits.braking[1]);
                (speed.min(limits.speed), a.min(own))
            })
    }

    /// The window of time over which a motion over them is smoothed; `length` is infinite where more may follow.
    pub fn smoothing_window(&self, length: f64) -> f64 {
        let mut longest = 0.0_f64;
        let mut fastest = ScalarLimits {
            speed: 0.0,
            acceleration: 0.0,
            jerk: f64::INFINITY,
        };
        for (_, limits) in &self.list {
            let both = limits.asked.into_iter().chain(limits.braking);
            let acceleration = both.fold(0.0, f64::max);
            let jerk = limits.jerk.min(acceleration / ACCELERATION_RISE);
            longest = longest.max(acceleration / jerk);
            fastest.speed = fastest.speed.max(limits.speed);
            fastest.acceleration = fastest.acceleration.max(acceleration);
            fastest.jerk = fastest.jerk.min(jerk);
        }
        let first = self.list.first().map(|(_, limits)| limits);
        if self.list.iter().all(|(_, limits)| Some(limits) == first) {
            return smoothing_window(&fastest, length);
        }
        let any = ScalarLimits {
            speed: f64::INFINITY,
            acceleration: longest,
            jerk: 1.0,
        };
        // A short motion never comes to these accelerations.
        let short = ScalarLimits {
            speed: f64::INFINITY,
            acceleration: f64::INFINITY,
            jerk: fastest.jerk,
        };
        smoothing_window(&any, f64::INFINITY).min(smoothing_window(&short, length))
    }
}
