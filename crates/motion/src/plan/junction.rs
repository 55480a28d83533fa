//! Attempts to join one leg to another, a few in each cycle.
//!
//! Where the second leg goes straight on, it follows without a curve, whenever it comes. Otherwise the curve begins at the beginning
//! of the zone or, where the arm has been there already or goes too fast for it, a little further on.

use super::corner::{Corner, Curve, goes_straight_on};
use super::leg::Leg;
use super::{Arm, Warnings};
use crate::constants::BLEND_ENTRIES;

/// What has been tried.
#[derive(Clone, Copy, Debug, Default)]
pub struct Junction {
    tried: usize,
}

/// How a leg goes over into the next.
#[derive(Clone, Copy, Debug)]
pub struct Joint {
    /// The curve from one into the other, or what one of the first leg's s is on the second where that goes straight on.
    pub over: Over,
    /// The next leg; its zone may have been shortened.
    pub next: Leg,
    /// What there is to say about that.
    pub warnings: Warnings,
}

/// What lies between two legs.
#[allow(
    clippy::large_enum_variant,
    reason = "lives on the stack of the cycle, which must not allocate"
)]
#[derive(Clone, Copy, Debug)]
pub enum Over {
    /// Nothing: the second goes on where the first ends, with so much of its s per s of the first.
    Straight(f64),
    /// A curve.
    Curve(Curve),
}

impl Junction {
    /// True when there is nothing left to try: the motion stops at the waypoint.
    pub fn is_given_up(&self) -> bool {
        self.tried >= BLEND_ENTRIES.len()
    }

    /// The next attempt: a curve that begins behind `committed`, the first leg's s. `None` where there is none.
    pub fn attempt(&mut self, first: &Leg, committed: f64, next: &Leg, arm: &Arm) -> Option<Joint> {
        let share = *BLEND_ENTRIES.get(self.tried)?;
        self.tried += 1;
        if let Some(rate) = goes_straight_on(first, next, arm) {
            // Nothing else would be better.
            self.tried = BLEND_ENTRIES.len();
            return Some(Joint {
                over: Over::Straight(rate),
                next: *next,
                warnings: Warnings::default(),
            });
        }
        let corner = Corner::new(first, committed, next, share, arm)?;
        let curve = corner.best(arm)?;
        if self.is_given_up() {
            // The arm slows down for its end: in the next cycle the last curve may do, until its beginning is passed.
            self.tried -= 1;
        }
        Some(Joint {
            over: Over::Curve(curve),
            next: corner.next,
            warnings: corner.warnings,
        })
    }
}
