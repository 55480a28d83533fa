//! The motions that the arm has taken: their legs and blends as one way, and how fast each place of it bears.
//!
//! A leg is added while the arm moves on the way before it, as long as the arm has not come too near to where the blend
//! begins. Owns the way; moving along it is `scalar::PathProgress`, what commands hear of it is said in `upcoming` and
//! `cycle`.

mod due;
mod kept;
mod time;

use kinematics::JointPositions;
use motion_api::{CommandId, MotionMode, Origin, Outcome};

use crate::constants::{
    CELLS_ABOUT_ZONE, MADE_GOOD, MAX_QUEUED_INTERVALS, MAX_QUEUED_SEGMENTS, START_OF_MOTION,
};
use crate::path::{CompositePath, Path, PathContext, PathPiece};
use crate::plan::{BlendKind, MotionSegment, PlannedBlend, SegmentLimits};
use crate::scalar::{PathProgress, ProgressGoal, ScalarState, VelocityLimitCurve};
use crate::setpoint::Setpoint;
use due::Corner;
use kept::{NO_SPEED_CAPS, SpeedCapProgress};

/// Steps on the way to rest that are looked at, and how many s each is.
const MAX_STOPPING_STEPS: usize = 2000;

/// How much harder than asked for the arm may slow down for what follows, tried one after the other; the last as hard
/// as it can, but not between two legs of joints, see [`HARDER_IN_BLENDS`](crate::constants::HARDER_IN_BLENDS).
const BRAKING_SCALES: [f64; 3] = [1.0, 2.0, f64::INFINITY];

/// A list of points that takes longer than its own time by this factor is worth a warning.
const DURATION_WARNING_RATIO: f64 = 1.05;
/// Time that starting and stopping may add to a list of points before it is worth a warning, s.
const START_AND_STOP: f64 = 1.0;

/// A leg under way or to come, and the command it belongs to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct QueuedSegment {
    pub(crate) id: CommandId,
    pub(crate) mode: MotionMode,
    pub(crate) origin: Origin,
    leg: MotionSegment,
    /// The route's s where the leg's blend zone begins, and where the leg ends.
    blend_start: f64,
    end: f64,
    /// When the leg has to be at its end, on the clock of the travel, s; 0 where no duration is wanted.
    deadline: f64,
    /// The speed of the route's s that keeps this time; infinite where no duration is wanted.
    speed: f64,
    /// The place by which the motion behind the leg has to be known.
    corner: Corner,
    /// The sender has been told that the next may follow.
    pub(crate) is_ready_for_next_sent: bool,
    /// The sender has been told that the next is due.
    pub(crate) is_urged: bool,
    /// The command has ended.
    pub(crate) has_ended: bool,
}

/// The way of the queue.
pub(crate) struct MotionQueue {
    route: CompositePath,
    track: VelocityLimitCurve,
    legs: Vec<QueuedSegment>,
    /// Up to where the way is kept within other limits than it was planned with.
    speed_caps: SpeedCapProgress,
    /// By how much the motion before has exceeded its duration, s.
    overrun: f64,
}

/// A motion under way along the queue's way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathMotion {
    progress: PathProgress,
    /// A stop was asked for; the motion ends where it comes to rest.
    pub(crate) is_stopping: bool,
    /// How the present stop as hard as the arm can is made; `None` while there is none.
    pub(crate) hard_stop: Option<HardStop>,
}

/// How a planned motion makes a stop that shall be as short as it can be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HardStop {
    /// On its path.
    OnPath,
    /// The joints brake one by one, because the path would take longer.
    JointByJoint,
}

/// A duration that cannot be met: asked for and what it takes, s.
pub(crate) type DurationShortfall = Option<(f64, f64)>;

impl MotionQueue {
    pub(crate) fn new() -> Self {
        Self {
            route: CompositePath::new(2 * MAX_QUEUED_SEGMENTS + 2),
            track: VelocityLimitCurve::new(MAX_QUEUED_INTERVALS),
            legs: Vec::with_capacity(MAX_QUEUED_SEGMENTS + 1),
            speed_caps: NO_SPEED_CAPS,
            overrun: 0.0,
        }
    }

    /// From rest along one leg. `None` when its cells cannot be used, which planning has ruled out.
    pub(crate) fn start_from_rest(
        &mut self,
        (id, mode, origin): (CommandId, MotionMode, Origin),
        leg: &MotionSegment,
        cells: &SegmentLimits,
    ) -> Option<(PathMotion, DurationShortfall)> {
        let whole = if leg.radius > 0.0 {
            f64::INFINITY
        } else {
            leg.path.length()
        };
        self.speed_caps = NO_SPEED_CAPS;
        self.route.restart(leg.path);
        self.track.restart(cells.smoothing_window(whole));
        self.append_intervals(leg, cells, (0.0, 0.0), 1.0)?;
        let mut queued = QueuedSegment {
            id,
            mode,
            origin,
            leg: *leg,
            blend_start: leg.blend_start,
            end: leg.path.length(),
            deadline: 0.0,
            speed: f64::INFINITY,
            corner: Corner::default(),
            is_ready_for_next_sent: false,
            is_urged: false,
            has_ended: false,
        };
        self.open_zone(&mut queued, 1.0);
        self.track.recompute();
        self.legs.clear();
        self.legs.push(queued);
        let mut too_short = self.keep_time(None, (0.0, 0.0));
        if let Path::MicroLine(line) = &leg.path {
            let wanted = line.length();
            let (planned, _) = PathProgress::new(&self.track).predict_times(&self.track, wanted);
            let is_longer = planned > DURATION_WARNING_RATIO * wanted + START_AND_STOP;
            too_short = is_longer.then_some((wanted, planned));
        }
        let motion = PathMotion {
            progress: PathProgress::new(&self.track),
            is_stopping: false,
            hard_stop: None,
        };
        Some((motion, too_short))
    }

    /// Adds a leg over a curve; `None` when the arm is too fast for that already, or there is no room.
    pub(crate) fn append_blended(
        &mut self,
        motion: &PathMotion,
        (id, mode, origin): (CommandId, MotionMode, Origin),
        joint: &PlannedBlend,
        cells: &SegmentLimits,
    ) -> Option<DurationShortfall> {
        let first = *self.route.last()?;
        let next = &joint.next;
        let (entry, exit, from, rate, count) = match &joint.over {
            BlendKind::Straight(rate) => {
                let end = self.track.end();
                (end, end, 0.0, first.rate * rate, 0)
            }
            BlendKind::Curve(curve) => {
                let entry = first.to_composite_parameter(curve.entry);
                let exit = entry + curve.path.length() / first.rate;
                let rate = first.rate * curve.rate;
                (entry, exit, curve.exit, rate, curve.cells().count())
            }
        };
        let new = cells.iter().filter(|(until, _)| *until > from).count();
        if self.route.remaining_capacity() < 2
            || self.track.room() < new + CELLS_ABOUT_ZONE + count + 1
        {
            return None;
        }
        let span = PathPiece {
            path: next.path,
            path_start: from,
            rate,
            start: exit,
        };
        let mut queued = QueuedSegment {
            id,
            mode,
            origin,
            leg: *next,
            blend_start: span.to_composite_parameter(next.blend_start),
            end: span.to_composite_parameter(next.path.length()),
            deadline: 0.0,
            speed: f64::INFINITY,
            corner: Corner::default(),
            is_ready_for_next_sent: false,
            is_urged: false,
            has_ended: false,
        };
        let are_joints = matches!((&first.path, &next.path), (Path::Joint(_), Path::Joint(_)));
        let hardness = BRAKING_SCALES.into_iter();
        let hardness = hardness.filter(|times| times.is_finite() || !are_joints);
        let place = motion.progress.committed();
        // Going straight on bears at least what the end bore.
        let before = match &joint.over {
            BlendKind::Straight(_) => motion.progress.leeway(&self.track),
            BlendKind::Curve(_) => 0.0,
        };
        let speed = motion.progress.committed_speed();
        let reach = 0.5 * self.track.window() * speed;
        let mut is_slow_enough = hardness.map(|times| {
            self.track.truncate(place, entry);
            let added = self.append_blend_intervals(joint, cells, (entry, first.rate), &span);
            if times > 1.0 {
                // What lies behind the curve is felt half a window before.
                self.track.scale_braking(place, exit + reach, times);
            }
            self.keep_pace_about(exit, &queued, speed);
            self.open_zone(&mut queued, rate);
            self.track.recompute();
            if added.is_some() && motion.progress.fits_as_before(&self.track, before) {
                return true;
            }
            self.track.undo_truncate();
            self.track.recompute();
            false
        });
        if !is_slow_enough.any(|is_it| is_it) {
            return None;
        }
        if self.speed_caps.place > entry {
            self.speed_caps.place = entry;
            self.speed_caps.cap = f64::INFINITY;
        }
        if let BlendKind::Curve(curve) = &joint.over {
            self.route.push(PathPiece {
                path: curve.path,
                path_start: 0.0,
                rate: first.rate,
                start: entry,
            });
        }
        self.route.push(span);
        self.legs.push(queued);
        Some(self.keep_time(Some(&motion.progress), (entry, exit)))
    }

    fn append_blend_intervals(
        &mut self,
        joint: &PlannedBlend,
        cells: &SegmentLimits,
        (entry, first): (f64, f64),
        span: &PathPiece,
    ) -> Option<()> {
        if let BlendKind::Curve(curve) = &joint.over {
            for (until, limits) in curve.cells() {
                self.track
                    .push(entry + until / first, limits.reparametrized(first))?;
            }
        }
        self.append_intervals(&joint.next, cells, (span.path_start, span.start), span.rate)
    }

    /// The cells of a leg from a place on it, which is a place on the route, on.
    fn append_intervals(
        &mut self,
        leg: &MotionSegment,
        cells: &SegmentLimits,
        (from, begin): (f64, f64),
        rate: f64,
    ) -> Option<()> {
        let on_route = |place: f64| begin + (place - from) / rate;
        let mut done = from;
        let mut spare = CELLS_ABOUT_ZONE;
        for (until, limits) in cells.iter().filter(|(until, _)| *until > from) {
            let own = limits.reparametrized(rate);
            while spare > 0
                && let Some(border) = border_about_zone(leg, done, until)
            {
                self.track.push(on_route(border), own)?;
                done = border;
                spare -= 1;
            }
            self.track.push(on_route(until), own)?;
            done = until;
        }
        Some(())
    }

    /// The last leg and the place on its path up to which nothing can be changed any more; `None` while the motion is
    /// held or stopped, and once it is too late.
    pub(crate) fn appendable_end(&self, motion: &PathMotion) -> Option<(&MotionSegment, f64)> {
        let last = self.legs.last()?;
        let span = self.route.last()?;
        if motion.is_stopping || motion.progress.is_finished(&self.track) {
            return None;
        }
        let committed = span.to_piece_parameter(motion.progress.committed().max(span.start));
        Some((&last.leg, committed))
    }

    /// Forgets what lies behind the arm.
    pub(crate) fn discard_passed(&mut self, motion: &PathMotion) {
        let behind = motion.progress.oldest();
        self.route.discard_before(behind);
        self.track.forget_before(behind);
        let gone = self
            .legs
            .iter()
            .take_while(|leg| leg.has_ended && leg.end < behind);
        let gone = gone.count().min(self.legs.len().saturating_sub(1));
        self.legs.drain(..gone);
    }

    /// Room for another leg.
    pub(crate) fn has_room(&self) -> bool {
        self.legs.len() < MAX_QUEUED_SEGMENTS && self.route.remaining_capacity() >= 2
    }

    /// The legs whose commands have not ended.
    pub(crate) fn unfinished_segments(&mut self) -> impl Iterator<Item = &mut QueuedSegment> {
        self.legs.iter_mut().filter(|leg| !leg.has_ended)
    }

    /// Whether the command of a leg has not ended.
    pub(crate) fn is_open(&self, id: CommandId) -> bool {
        self.legs.iter().any(|leg| leg.id == id && !leg.has_ended)
    }

    /// The leg that is under way: the first whose command has not ended, or the last.
    pub(crate) fn current(&self) -> Option<&QueuedSegment> {
        let mut legs = self.legs.iter();
        legs.find(|leg| !leg.has_ended).or(self.legs.last())
    }

    /// The last leg.
    pub(crate) fn last(&self) -> Option<&QueuedSegment> {
        self.legs.last()
    }

    /// How many commands have not ended.
    pub(crate) fn unfinished_count(&self) -> usize {
        self.legs.iter().filter(|leg| !leg.has_ended).count()
    }

    /// The next leg whose zone the arm has entered, or that it has come to the end of; its command ends.
    pub(crate) fn newly_reached_segment(
        &mut self,
        motion: &PathMotion,
    ) -> Option<&mut QueuedSegment> {
        let place = motion.progress.state(&self.track).position;
        let is_over = self.is_over(motion);
        let last = self.legs.len().saturating_sub(1);
        let (k, leg) = self
            .legs
            .iter_mut()
            .enumerate()
            .find(|(_, leg)| !leg.has_ended)?;
        let is_in_zone = leg.leg.radius > 0.0 && place >= leg.blend_start;
        (is_in_zone && !motion.is_stopping || k == last && is_over).then_some(leg)
    }

    /// True when the end is reached, in the time that was wanted.
    pub(crate) fn is_over(&self, motion: &PathMotion) -> bool {
        let due = self.legs.last().map_or(0.0, |leg| leg.deadline);
        motion.progress.is_finished(&self.track) && motion.progress.time() >= due - START_OF_MOTION
    }

    /// Notes by how much a motion with a duration of its own has exceeded that when it ends: cycles are whole. The next
    /// one with a duration makes it good, if it begins at once.
    pub(crate) fn note_overrun(&mut self, motion: &PathMotion) {
        let timed = self
            .legs
            .last()
            .filter(|leg| leg.leg.request.duration > 0.0);
        self.overrun = timed.map_or(0.0, |leg| (motion.progress.time() - leg.deadline).max(0.0));
    }

    /// A cycle has passed without a motion.
    pub(crate) fn pass(&mut self, step: f64) {
        if self.overrun > 0.0 {
            self.overrun += step;
        }
        if self.overrun > MADE_GOOD {
            self.overrun = 0.0;
        }
    }

    /// True when nothing moves: at the end, or halted on the way.
    pub(crate) fn is_standing(&self, motion: &PathMotion) -> bool {
        self.is_over(motion)
            || motion.progress.is_standing(&self.track) && !motion.progress.is_going()
    }

    /// The setpoint one cycle later, as `set_goal` says. `None` when the path is lost.
    pub(crate) fn next_setpoint(
        &self,
        motion: &mut PathMotion,
        step: f64,
        drive: ProgressGoal,
        ground: &PathContext,
        near: &JointPositions,
    ) -> Option<Setpoint> {
        motion.progress.set_goal(match drive {
            ProgressGoal::Run(_) | ProgressGoal::Stop if motion.is_stopping => {
                ProgressGoal::StopHard
            }
            drive => drive,
        });
        let s = motion.progress.advance(step, &self.track);
        if motion.progress.is_finished(&self.track) {
            return self.route.end();
        }
        self.route.at(ground, &s, near)
    }

    /// Whether the motion comes to rest within `time` seconds when it brakes on its path as hard as the arm can.
    pub(crate) fn halts_within_time(&self, motion: &PathMotion, step: f64, time: f64) -> bool {
        let mut travel = motion.progress;
        travel.set_goal(ProgressGoal::StopHard);
        let steps = ((time / step).ceil() as usize).min(MAX_STOPPING_STEPS);
        (0..steps).any(|_| {
            travel.advance(step, &self.track);
            travel.is_standing(&self.track)
        })
    }

    /// Whether every place up to where the motion would come to rest if it halted now is `allowed`; `near` is where the
    /// joints are.
    pub(crate) fn stopping_path_satisfies(
        &self,
        motion: &PathMotion,
        step: f64,
        ground: &PathContext,
        near: &JointPositions,
        allowed: impl Fn(&JointPositions) -> bool,
    ) -> bool {
        let mut travel = motion.progress;
        travel.set_goal(ProgressGoal::Stop);
        let mut q = *near;
        for _ in 0..MAX_STOPPING_STEPS {
            if travel.is_standing(&self.track) {
                return true;
            }
            let place = travel.advance(step, &self.track).position;
            let there = self.route.at(ground, &ScalarState::at_rest(place), &q);
            let Some(there) = there else {
                return false;
            };
            q = there.q;
            if !allowed(&q) {
                return false;
            }
        }
        false
    }

    /// The largest acceleration of the motion on the last leg, in the unit of its way.
    pub(crate) fn hardest(&self, motion: &PathMotion) -> f64 {
        let Some(span) = self.route.last() else {
            return 0.0;
        };
        motion.progress.hardest(&self.track, span.start) * span.rate
    }

    /// Where the joints will be at the end.
    pub(crate) fn end(&self) -> Option<JointPositions> {
        self.route.end().map(|end| end.q)
    }
}

impl QueuedSegment {
    /// How the command of the leg ends where the leg does.
    pub(crate) fn outcome(&self) -> Outcome {
        self.leg.beyond.map_or(Outcome::Done, Outcome::Refused)
    }

    /// Where the joints are at the end of the leg.
    pub(crate) fn end_q(&self) -> JointPositions {
        self.leg.path.end_setpoint().q
    }
}

impl PathMotion {
    /// Whether it brakes as hard as the arm can where it is faster than its way allows.
    pub(crate) fn set_hard_braking(&mut self, is_hard: bool) {
        self.progress.set_hard_braking(is_hard);
    }

    /// The share of its speed that what is laid over it leaves it.
    pub(crate) fn slow_to(&mut self, pace: f64) {
        self.progress.slow_to(pace);
    }

    /// The speed fraction in effect.
    pub(crate) fn fraction(&self) -> f64 {
        self.progress.fraction()
    }

    /// The speed along the way that the next steps begin with, 1/s of its unit.
    pub(crate) fn committed_speed(&self) -> f64 {
        self.progress.committed_speed()
    }
}

/// Where a cell from `done` to `until` is divided because a blend zone is near. How fast the arm may be is known by
/// cells: the shorter they are, the later it has to be known what follows.
fn border_about_zone(leg: &MotionSegment, done: f64, until: f64) -> Option<f64> {
    if leg.radius <= 0.0 {
        return None;
    }
    let end = leg.path.length();
    let length = (end - leg.blend_start).max((end - done) / 2.0) / 4.0;
    // A rest that is shorter than half a piece stays with the piece before.
    let next = done + length;
    let border = match (done < leg.blend_start, next >= leg.blend_start) {
        (true, true) => leg.blend_start,
        _ => next,
    };
    let is_zone = border == leg.blend_start;
    (length > 0.0 && border < until && (is_zone || until - border > 0.5 * length)).then_some(border)
}
