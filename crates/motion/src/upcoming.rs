//! The motion that follows those under way: planned while they are still moving, joined to them if it can be.
//!
//! A command may come once the one before it has entered its blend zone, or earlier: its sender is told when the arm
//! comes so near that it would have to slow down. When the junction cannot be made, because the command came too late
//! or the turn is too sharp, the arm stops exactly at the waypoint and the next motion begins from rest, with a
//! warning.

use motion_api::{CommandId, MotionMode, Origin, Outcome, Refusal, Warning};

use crate::constants::BLEND_ENTRIES_PER_CYCLE;
use crate::cycle::{ControlLoop, Generator};
use crate::path::Path;
use crate::plan::{
    BlendSearch, CartesianPlanner, MicroLinePlanner, MotionSegment, SegmentLimits, Warnings,
};

/// A motion command that waits for its turn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PendingMotion {
    pub(crate) id: CommandId,
    pub(crate) mode: MotionMode,
    pub(crate) origin: Origin,
    pub(crate) plan: PlanState,
    pub(crate) blend_search: BlendSearch,
}

/// How far the plan is. The cells of the leg are in [`ControlLoop::pending_limits`].
#[allow(
    clippy::large_enum_variant,
    reason = "lives in place inside the cycle, which must not allocate"
)]
#[derive(Clone, Copy, Debug)]
pub(crate) enum PlanState {
    /// More of a Cartesian line or arc is to be looked at.
    Cartesian(CartesianPlanner),
    /// More of a way through many points is to be looked at.
    MicroLine(MicroLinePlanner),
    /// The leg from the waypoint on.
    Ready(MotionSegment, Warnings),
}

impl ControlLoop {
    /// Takes a motion command: begins it when the arm stands, otherwise keeps it until the motion under way is joined.
    pub(crate) fn enqueue_motion(
        &mut self,
        (id, origin): (CommandId, Origin),
        mode: MotionMode,
        plan: PlanState,
    ) {
        self.pending_motion = Some(PendingMotion {
            id,
            mode,
            origin,
            plan,
            blend_search: BlendSearch::default(),
        });
    }

    /// Goes on with the plan of the next motion, joins it to the one under way, or starts it when the arm stands.
    pub(crate) fn continue_planning(&mut self) {
        let Some(mut upcoming) = self.pending_motion.take() else {
            return;
        };
        let mut cells = core::mem::take(&mut self.pending_limits);
        let is_kept = match self.advance_pending_motion(&mut upcoming, &mut cells) {
            Ok(is_kept) => is_kept,
            Err(refusal) => {
                self.out.report_end(upcoming.id, Outcome::Refused(refusal));
                false
            }
        };
        self.pending_limits = cells;
        if is_kept {
            self.pending_motion = Some(upcoming);
        }
    }

    /// True while the motion has to wait.
    fn advance_pending_motion(
        &mut self,
        upcoming: &mut PendingMotion,
        cells: &mut SegmentLimits,
    ) -> Result<bool, Refusal> {
        let arm = self.arm();
        let planned = match &mut upcoming.plan {
            PlanState::Cartesian(planner) => planner.advance(&arm, cells)?,
            PlanState::MicroLine(planner) => {
                planner.advance(self.micro_points.points(), &arm, cells)?
            }
            PlanState::Ready(leg, warnings) => Some((*leg, *warnings)),
        };
        let Some((leg, warnings)) = planned else {
            return Ok(true);
        };
        // Where the way ends is known only now: another solution than the nearest may be behind a plane with its elbow.
        if !self.has_no_target_bounds() && leg.beyond.is_none() {
            self.check_target(&leg.path.end_setpoint().q)?;
        }
        upcoming.plan = PlanState::Ready(leg, warnings);
        let too_short = match self.generator {
            Generator::Path(_) => match self.join(upcoming, &leg, cells) {
                Some(too_short) => too_short,
                None => return Ok(true),
            },
            Generator::Hold => {
                let who = (upcoming.id, upcoming.mode, upcoming.origin);
                let begun = self.queue.start_from_rest(who, &leg, cells);
                let (motion, too_short) = begun.ok_or(Refusal::Planner {
                    code: PLANNER_EMPTY_SEGMENT,
                })?;
                self.generator = Generator::Path(motion);
                too_short
            }
            // Comes to rest first.
            Generator::Online(_) => return Ok(true),
            // A protective stop has ended the command.
            Generator::Stop(_) => return Ok(false),
        };
        for warning in warnings.iter() {
            if let Some(warning) = self.as_it_is(warning) {
                self.out.report_warning(upcoming.id, warning);
            }
        }
        if let Some((wanted, planned)) = too_short {
            let warning = Warning::DurationStretched { wanted, planned };
            self.out.report_warning(upcoming.id, warning);
        }
        Ok(false)
    }

    /// A warning about accelerations with the one that the motion does. Where the arm can do less only in places in
    /// which it is not asked for, there is nothing to say; nor where the way is too short for it.
    fn as_it_is(&self, warning: Warning) -> Option<Warning> {
        let (
            Warning::AccelerationLimited {
                wanted,
                planned,
                unit,
            },
            Generator::Path(motion),
        ) = (warning, &self.generator)
        else {
            return Some(warning);
        };
        let done = self.queue.hardest(motion);
        let is_so = done < REACHED * wanted && done > TOO_SHORT * planned;
        is_so.then_some(Warning::AccelerationLimited {
            wanted,
            planned: if (REACHED..=1.0 / REACHED).contains(&(done / planned)) {
                planned
            } else {
                done
            },
            unit,
        })
    }

    /// Joins the next leg to the way of the queue; `None` when that is not possible, or not yet.
    fn join(
        &mut self,
        upcoming: &mut PendingMotion,
        leg: &MotionSegment,
        cells: &SegmentLimits,
    ) -> Option<crate::queue::DurationShortfall> {
        let Generator::Path(motion) = self.generator else {
            return None;
        };
        // Into a motion that goes nowhere there is nothing to blend: it begins, and ends, at the waypoint. One through
        // many points begins at the first of them, from rest.
        let is_many = matches!(leg.path, Path::MicroLine(_));
        if upcoming.blend_search.is_exhausted() || leg.path.length() <= 0.0 || is_many {
            return None;
        }
        self.queue.discard_passed(&motion);
        for _ in 0..BLEND_ENTRIES_PER_CYCLE {
            let (first, committed) = self.queue.appendable_end(&motion)?;
            if first.radius <= 0.0 || first.path.length() <= 0.0 {
                return None;
            }
            let joint = upcoming
                .blend_search
                .try_next_entry(first, committed, leg, &self.arm());
            let who = (upcoming.id, upcoming.mode, upcoming.origin);
            if let Some(joint) = joint
                && let Some(too_short) = self.queue.append_blended(&motion, who, &joint, cells)
            {
                for warning in joint.warnings.iter() {
                    self.out.report_warning(upcoming.id, warning);
                }
                return Some(too_short);
            }
            if upcoming.blend_search.is_exhausted() {
                self.out.report_warning(upcoming.id, Warning::NotBlended);
                return None;
            }
        }
        None
    }
}

/// An acceleration counts as reached from this share on.
const REACHED: f64 = 0.99;
/// Who does not even reach this share of the least acceleration that is possible has too short a way.
const TOO_SHORT: f64 = 0.95;
/// Planner error: a leg that was planned bears no motion when it begins.
const PLANNER_EMPTY_SEGMENT: u32 = 2;
