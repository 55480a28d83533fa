//! A way in parts that each have one set of bounds.
//!
//! There is a fixed number of equal parts, divided again where what the way asks for changes much, so that a short hard
//! piece does not slow down its surroundings.

use super::able::{Able, PartBounds};
use crate::config::MotionLimits;
use crate::constants::{LINE_PARTS, LINE_PARTS_MAX, PART_RANGE};

/// A piece of the way with one set of bounds.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// Where it ends, s.
    pub until: f64,
    /// What it asks of the joints.
    pub bounds: PartBounds,
    /// Speeds of s that its intervals bear, slowest and fastest.
    speeds: (f64, f64),
}

impl Part {
    const NONE: Self = Self {
        until: 0.0,
        bounds: PartBounds::NONE,
        speeds: (f64::INFINITY, 0.0),
    };

    /// Whether an interval that bears `speed` belongs to it.
    fn is_like(&self, speed: f64) -> bool {
        let (slowest, fastest) = self.speeds;
        fastest.max(speed) <= PART_RANGE * slowest.min(speed)
    }
}

/// The parts in order, while the way is being looked at.
#[derive(Clone, Copy, Debug)]
pub struct Parts {
    list: [Part; LINE_PARTS_MAX],
    count: usize,
    /// Speed of s that nobody wants to exceed.
    fastest: f64,
}

impl Parts {
    /// None yet; nobody wants to go faster than `fastest`, unit of s.
    pub const fn new(fastest: f64) -> Self {
        Self {
            list: [Part::NONE; LINE_PARTS_MAX],
            count: 0,
            fastest,
        }
    }

    /// The parts so far.
    pub fn as_slice(&self) -> &[Part] {
        self.list.get(..self.count).unwrap_or(&[])
    }

    /// Adds the interval up to `until`, which lies in the equal part `number` and is the first of it if it `begins` it.
    pub fn add(
        &mut self,
        until: f64,
        bounds: &PartBounds,
        (number, begins): (usize, bool),
        limits: &MotionLimits,
    ) {
        let speed = Able::of(bounds, limits).speed().min(self.fastest);
        // Further parts only while all equal ones to come have their places.
        let to_come = LINE_PARTS.saturating_sub(number + 1);
        let is_free = self.count + to_come < LINE_PARTS_MAX;
        let last = self.count.checked_sub(1);
        let last = last.and_then(|k| self.list.get_mut(k));
        match last {
            Some(part) if !begins && (part.is_like(speed) || !is_free) => {
                part.until = until;
                part.bounds.join(bounds);
                part.speeds = (part.speeds.0.min(speed), part.speeds.1.max(speed));
            }
            _ => {
                if let Some(part) = self.list.get_mut(self.count) {
                    *part = Part {
                        until,
                        bounds: *bounds,
                        speeds: (speed, speed),
                    };
                    self.count += 1;
                }
            }
        }
    }
}
