//! Attempts to join one leg to another, a few in each cycle.
//!
//! The curve begins at the beginning of the zone or, where the arm has been there already or goes too fast for it, a little
//! further on.

use super::corner::{Corner, Curve};
use super::leg::Leg;
use super::{Arm, Warnings};
use crate::constants::BLEND_ENTRIES;

/// What has been tried.
#[derive(Clone, Copy, Debug, Default)]
pub struct Junction {
    tried: usize,
}

/// A curve from a leg into the next.
#[derive(Clone, Copy, Debug)]
pub struct Joint {
    /// The curve.
    pub curve: Curve,
    /// The next leg; its zone may have been shortened.
    pub next: Leg,
    /// What there is to say about that.
    pub warnings: Warnings,
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
        let corner = Corner::new(first, committed, next, share, arm)?;
        let curve = corner.best(arm)?;
        Some(Joint {
            curve,
            next: corner.next,
            warnings: corner.warnings,
        })
    }
}
