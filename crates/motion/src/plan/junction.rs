//! Attempts to join one leg to another, a few in each cycle.
//!
//! Where the second leg goes straight on, it follows without a curve, whenever it comes. Otherwise the curve begins at
//! the beginning of the zone or, where the arm has been there already or goes too fast for it, a little further on.

use super::corner::{Blend, BlendGeometry, goes_straight_on};
use super::leg::MotionSegment;
use super::{PlanningContext, Warnings};
use crate::constants::BLEND_ENTRY_SHARES;

/// What has been tried.
#[derive(Clone, Copy, Debug, Default)]
pub struct BlendSearch {
    attempts: usize,
}

/// How a leg goes over into the next.
#[derive(Clone, Copy, Debug)]
pub struct PlannedBlend {
    /// The curve from one into the other, or what one of the first leg's s is on the second where that goes straight
    /// on.
    pub over: BlendKind,
    /// The next leg; its zone may have been shortened.
    pub next: MotionSegment,
    /// What there is to say about that.
    pub warnings: Warnings,
}

/// What lies between two legs.
#[allow(
    clippy::large_enum_variant,
    reason = "lives on the stack of the cycle, which must not allocate"
)]
#[derive(Clone, Copy, Debug)]
pub enum BlendKind {
    /// Nothing: the second goes on where the first ends, with so much of its s per s of the first.
    Straight(f64),
    /// A curve.
    Curve(Blend),
}

impl BlendSearch {
    /// True when there is nothing left to try: the motion stops at the waypoint.
    pub fn is_exhausted(&self) -> bool {
        self.attempts >= BLEND_ENTRY_SHARES.len()
    }

    /// The next attempt: a curve that begins behind `committed`, the first leg's s. `None` where there is none.
    pub fn try_next_entry(
        &mut self,
        first: &MotionSegment,
        committed: f64,
        next: &MotionSegment,
        arm: &PlanningContext,
    ) -> Option<PlannedBlend> {
        let share = *BLEND_ENTRY_SHARES.get(self.attempts)?;
        self.attempts += 1;
        if let Some(rate) = goes_straight_on(first, next, arm) {
            // Nothing else would be better.
            self.attempts = BLEND_ENTRY_SHARES.len();
            return Some(PlannedBlend {
                over: BlendKind::Straight(rate),
                next: *next,
                warnings: Warnings::default(),
            });
        }
        let corner = BlendGeometry::new(first, committed, next, share, arm)?;
        let curve = corner.fastest_blend(arm)?;
        if self.is_exhausted() {
            // The arm slows down for its end: in the next cycle the last curve may do, until its beginning is passed.
            self.attempts -= 1;
        }
        Some(PlannedBlend {
            over: BlendKind::Curve(curve),
            next: corner.next,
            warnings: corner.warnings,
        })
    }
}
