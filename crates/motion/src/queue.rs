//! The motions that the arm has taken: their legs and blends as one way, and how fast each place of it bears.
//!
//! A leg is added while the arm moves on the way before it, as long as the arm has not come too near to where the blend
//! begins. Owns the way; moving along it is `scalar::Travel`, what commands hear of it is said in `upcoming` and `cycle`.

mod kept;

use kinematics::JointPositions;
use kinematics::bounds::within;
use motion_api::{CommandId, MotionMode, Origin, Outcome};

use crate::constants::{
    AHEAD_TIME, CELLS_OF_ROUTE, DUE_ATTEMPTS, LEGS_AHEAD, LONGEST, START_OF_MOTION,
};
use crate::path::{Ground, Path, Route, Span};
use crate::plan::{Cells, Joint, Leg};
use crate::scalar::{Drive, ScalarState, Track, Travel};
use crate::setpoint::Setpoint;
use kept::{Kept, NONE_KEPT};

/// Steps on the way to rest that are looked at, and how many s each is.
const HALT_STEPS: usize = 2000;

/// How much harder than asked for the arm may slow down for a curve, tried one after the other.
const HARDNESS: [f64; 2] = [1.0, 2.0];

/// The arm goes through no more than this share of a zone in the time that it takes until a command that is sent when the zone is
/// entered is planned, s.
const LATE_SHARE: f64 = 0.25;
/// See [`LATE_SHARE`].
const LATE_TIME: f64 = 0.02;

/// A list of points that takes longer than its own time by this factor is worth a warning; starting and stopping take theirs.
const LONGER: f64 = 1.05;
/// See [`LONGER`], s.
const START_AND_STOP: f64 = 1.0;

/// A leg under way or to come, and the command it belongs to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Queued {
    pub(crate) id: CommandId,
    pub(crate) mode: MotionMode,
    pub(crate) origin: Origin,
    leg: Leg,
    /// The route's s where its zone begins, and where it ends.
    zone: f64,
    end: f64,
    /// When it has to be at its end, on the clock of the travel, s; 0 where no duration is wanted.
    due: f64,
    /// The sender has been told that the next may follow.
    pub(crate) is_told: bool,
    /// The command has ended.
    pub(crate) has_ended: bool,
}

/// The way of the queue.
pub(crate) struct Queue {
    route: Route,
    track: Track,
    legs: Vec<Queued>,
    /// Up to where the way is kept within other limits than it was planned with.
    kept: Kept,
}

/// A motion under way along the queue's way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion {
    travel: Travel,
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
pub(crate) type TooShort = Option<(f64, f64)>;

impl Queue {
    pub(crate) fn new() -> Self {
        Self {
            route: Route::new(2 * LEGS_AHEAD + 2),
            track: Track::new(CELLS_OF_ROUTE),
            legs: Vec::with_capacity(LEGS_AHEAD + 1),
            kept: NONE_KEPT,
        }
    }

    /// From rest along one leg. `None` when its cells cannot be used, which planning has ruled out.
    pub(crate) fn begin(
        &mut self,
        (id, mode, origin): (CommandId, MotionMode, Origin),
        leg: &Leg,
        cells: &Cells,
    ) -> Option<(Motion, TooShort)> {
        let whole = if leg.radius > 0.0 {
            f64::INFINITY
        } else {
            leg.path.length()
        };
        self.kept = NONE_KEPT;
        self.route.restart(leg.path);
        self.track.restart(cells.window(whole));
        self.add_leg(leg, cells, (0.0, 0.0), 1.0)?;
        self.track.settle();
        self.legs.clear();
        self.legs.push(Queued {
            id,
            mode,
            origin,
            leg: *leg,
            zone: leg.zone,
            end: leg.path.length(),
            due: 0.0,
            is_told: false,
            has_ended: false,
        });
        let mut too_short = self.pace(None, 0.0, 0.0);
        if let Path::Micro(line) = &leg.path {
            let wanted = line.length();
            let (planned, _) = Travel::new(&self.track).foresee(&self.track, wanted);
            let is_longer = planned > LONGER * wanted + START_AND_STOP;
            too_short = is_longer.then_some((wanted, planned));
        }
        let motion = Motion {
            travel: Travel::new(&self.track),
            is_stopping: false,
            hard_stop: None,
        };
        Some((motion, too_short))
    }

    /// Adds a leg over a curve; `None` when the arm is too fast for that already, or there is no room.
    pub(crate) fn join(
        &mut self,
        motion: &Motion,
        (id, mode, origin): (CommandId, MotionMode, Origin),
        joint: &Joint,
        cells: &Cells,
    ) -> Option<TooShort> {
        let first = *self.route.last()?;
        let before = self.legs.last().copied()?;
        let (curve, next) = (&joint.curve, &joint.next);
        let entry = first.on_route(curve.entry);
        let exit = entry + curve.path.length() / first.rate;
        let rate = first.rate * curve.rate;
        let new = cells
            .iter()
            .filter(|(until, _)| *until > curve.exit)
            .count();
        if self.route.room() < 2 || self.track.room() < new + 1 + curve.cells().count() + 1 {
            return None;
        }
        let place = motion.travel.committed();
        let is_slow_enough = HARDNESS.into_iter().any(|hardness| {
            self.track.cut(place, entry);
            let added = self.add_cells(joint, cells, (entry, first.rate), (exit, rate));
            if hardness > 1.0 {
                self.track.harden(place, exit, hardness);
            }
            self.track.settle();
            if added.is_some() && motion.travel.fits(&self.track) {
                return true;
            }
            self.track.restore();
            self.track.settle();
            false
        });
        if !is_slow_enough {
            return None;
        }
        if self.kept.place > entry {
            self.kept.place = entry;
            self.kept.cap = f64::INFINITY;
        }
        self.route.push(Span {
            path: curve.path,
            from: 0.0,
            rate: first.rate,
            begin: entry,
        });
        let span = Span {
            path: next.path,
            from: curve.exit,
            rate,
            begin: exit,
        };
        self.route.push(span);
        self.legs.push(Queued {
            id,
            mode,
            origin,
            leg: *next,
            zone: span.on_route(next.zone),
            end: span.on_route(next.path.length()),
            due: 0.0,
            is_told: false,
            has_ended: false,
        });
        // The time of a leg counts from the waypoint before: from when that leg is due, otherwise from the middle of the curve.
        let begins = if before.due > 0.0 {
            before.due
        } else {
            let middle = 0.5 * (entry + exit);
            motion.travel.time() + motion.travel.foresee(&self.track, middle).1
        };
        Some(self.pace(Some(&motion.travel), exit, begins))
    }

    fn add_cells(
        &mut self,
        joint: &Joint,
        cells: &Cells,
        (entry, first): (f64, f64),
        (exit, second): (f64, f64),
    ) -> Option<()> {
        let curve = &joint.curve;
        for (until, limits) in curve.cells() {
            self.track
                .push(entry + until / first, limits.counted(first), 1.0)?;
        }
        self.add_leg(&joint.next, cells, (curve.exit, exit), second)
    }

    /// The cells of a leg from a place on it, which is a place on the route, on. In its zone it is slower until the next is
    /// known.
    fn add_leg(
        &mut self,
        leg: &Leg,
        cells: &Cells,
        (from, begin): (f64, f64),
        rate: f64,
    ) -> Option<()> {
        let on_route = |place: f64| begin + (place - from) / rate;
        let mut done = from;
        for (until, limits) in cells.iter().filter(|(until, _)| *until > from) {
            let own = limits.counted(rate);
            if (done..until).contains(&leg.zone) {
                self.track.push(on_route(leg.zone), own, 1.0)?;
            }
            self.track.push(on_route(until), own, 1.0)?;
            done = until;
        }
        if leg.radius > 0.0 {
            let room = leg.path.length() - leg.zone;
            let in_time = LATE_SHARE * room / (0.5 * self.track.window() + LATE_TIME);
            let speed = leg.zone_speed.min(in_time);
            self.track.set_zone(on_route(leg.zone), speed / rate);
        }
        Some(())
    }

    /// Slows the last leg, which begins at `from`, so that it ends in the time that is wanted of it from `begins` on. Without
    /// a travel the motion begins from rest.
    fn pace(&mut self, travel: Option<&Travel>, from: f64, begins: f64) -> TooShort {
        let leg = self.legs.last_mut()?;
        let wanted = leg.leg.wish.duration;
        if wanted <= 0.0 {
            return None;
        }
        let due = begins + wanted;
        leg.due = due;
        let now = travel.map_or(0.0, Travel::time);
        let left = due - now;
        if self.track.end() <= from {
            return None;
        }
        let mut time_at = |pace: f64| {
            self.track.set_pace(from, pace);
            self.track.settle();
            let travel = travel.copied().unwrap_or_else(|| Travel::new(&self.track));
            travel.foresee(&self.track, f64::INFINITY).0
        };
        let mut fastest = (1.0, time_at(1.0));
        if fastest.1 > left {
            leg.due = now + fastest.1;
            let late = fastest.1 - left;
            return (late > START_OF_MOTION * left).then_some((wanted, wanted + late));
        }
        // The time grows nearly evenly with the inverse of the pace.
        let mut slowest: Option<(f64, f64)> = None;
        let mut inverse = within(left / fastest.1, 1.0, LONGEST);
        for _ in 0..DUE_ATTEMPTS {
            let time = time_at(1.0 / inverse);
            if time <= left {
                fastest = (inverse, time);
                if left - time < 1e-4 {
                    break;
                }
            } else {
                slowest = Some((inverse, time));
            }
            inverse = match slowest {
                Some((slow, late)) => {
                    let share = (left - fastest.1) / (late - fastest.1);
                    fastest.0 + (slow - fastest.0) * within(share, 0.02, 0.98)
                }
                None => inverse * (left / time).max(1.0 + 1e-6),
            };
        }
        time_at(1.0 / fastest.0);
        None
    }

    /// The last leg and the place on its path up to which nothing can be changed any more; `None` while the motion is held or
    /// stopped, and once it is too late.
    pub(crate) fn open_end(&self, motion: &Motion) -> Option<(&Leg, f64)> {
        let last = self.legs.last()?;
        let span = self.route.last()?;
        if motion.is_stopping || motion.travel.is_finished(&self.track) {
            return None;
        }
        let committed = span.on_path(motion.travel.committed().max(span.begin));
        Some((&last.leg, committed))
    }

    /// Forgets what lies behind the arm.
    pub(crate) fn forget(&mut self, motion: &Motion) {
        let behind = motion.travel.oldest();
        self.route.forget_before(behind);
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
        self.legs.len() < LEGS_AHEAD && self.route.room() >= 2
    }

    /// The legs whose commands have not ended.
    pub(crate) fn open(&mut self) -> impl Iterator<Item = &mut Queued> {
        self.legs.iter_mut().filter(|leg| !leg.has_ended)
    }

    /// The leg that is under way: the first whose command has not ended, or the last.
    pub(crate) fn current(&self) -> Option<&Queued> {
        let mut legs = self.legs.iter();
        legs.find(|leg| !leg.has_ended).or(self.legs.last())
    }

    /// The last leg.
    pub(crate) fn last(&self) -> Option<&Queued> {
        self.legs.last()
    }

    /// How many commands have not ended.
    pub(crate) fn open_count(&self) -> usize {
        self.legs.iter().filter(|leg| !leg.has_ended).count()
    }

    /// The next leg whose zone the arm has entered, or that it has come to the end of; its command ends.
    pub(crate) fn reached(&mut self, motion: &Motion) -> Option<&mut Queued> {
        let place = motion.travel.state(&self.track).position;
        let is_over = self.is_over(motion);
        let last = self.legs.len().saturating_sub(1);
        let (k, leg) = self
            .legs
            .iter_mut()
            .enumerate()
            .find(|(_, leg)| !leg.has_ended)?;
        let is_in_zone = leg.leg.radius > 0.0 && place >= leg.zone;
        (is_in_zone && !motion.is_stopping || k == last && is_over).then_some(leg)
    }

    /// The last leg, when the arm is so near to its end that the next had better be there, and its sender does not know yet.
    pub(crate) fn awaits_next(&mut self, motion: &Motion) -> Option<&mut Queued> {
        let window = self.track.window();
        let place = motion.travel.state(&self.track).position;
        let rate = self.route.last()?.rate;
        let has_room = self.has_room();
        let leg = self.legs.last_mut()?;
        let wish = &leg.leg.wish;
        let speed = wish.speed / rate;
        let braking = speed * speed * rate / (2.0 * wish.acceleration);
        let ahead = braking + speed * (2.0 * window + AHEAD_TIME);
        let is_due = leg.leg.radius > 0.0 && wish.duration <= 0.0 && leg.zone - place < ahead;
        (is_due && has_room && !leg.is_told && !leg.has_ended && !motion.is_stopping).then_some(leg)
    }

    /// True when the end is reached, in the time that was wanted.
    pub(crate) fn is_over(&self, motion: &Motion) -> bool {
        let due = self.legs.last().map_or(0.0, |leg| leg.due);
        motion.travel.is_finished(&self.track) && motion.travel.time() >= due - START_OF_MOTION
    }

    /// True when nothing moves: at the end, or halted on the way.
    pub(crate) fn is_standing(&self, motion: &Motion) -> bool {
        self.is_over(motion) || motion.travel.is_standing(&self.track) && !motion.travel.is_going()
    }

    /// The setpoint one cycle later, as `drive` says. `None` when the path is lost.
    pub(crate) fn next(
        &self,
        motion: &mut Motion,
        step: f64,
        drive: Drive,
        ground: &Ground,
        near: &JointPositions,
    ) -> Option<Setpoint> {
        motion.travel.drive(match drive {
            Drive::Go(_) | Drive::Halt if motion.is_stopping => Drive::HaltHard,
            drive => drive,
        });
        let s = motion.travel.advance(step, &self.track);
        if motion.travel.is_finished(&self.track) {
            return self.route.end();
        }
        self.route.at(ground, &s, near)
    }

    /// Whether the motion comes to rest within `time` seconds when it brakes on its path as hard as the arm can.
    pub(crate) fn halts_within_time(&self, motion: &Motion, step: f64, time: f64) -> bool {
        let mut travel = motion.travel;
        travel.drive(Drive::HaltHard);
        let steps = ((time / step).ceil() as usize).min(HALT_STEPS);
        (0..steps).any(|_| {
            travel.advance(step, &self.track);
            travel.is_standing(&self.track)
        })
    }

    /// Whether every place up to where the motion would come to rest if it halted now is `allowed`; `near` is where the joints
    /// are.
    pub(crate) fn halts_within(
        &self,
        motion: &Motion,
        step: f64,
        ground: &Ground,
        near: &JointPositions,
        allowed: impl Fn(&JointPositions) -> bool,
    ) -> bool {
        let mut travel = motion.travel;
        travel.drive(Drive::Halt);
        let mut q = *near;
        for _ in 0..HALT_STEPS {
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
    pub(crate) fn hardest(&self, motion: &Motion) -> f64 {
        let Some(span) = self.route.last() else {
            return 0.0;
        };
        motion.travel.hardest(&self.track, span.begin) * span.rate
    }

    /// Where the joints will be at the end.
    pub(crate) fn end(&self) -> Option<JointPositions> {
        self.route.end().map(|end| end.q)
    }
}

impl Queued {
    /// How its command ends where the leg does.
    pub(crate) fn outcome(&self) -> Outcome {
        self.leg.beyond.map_or(Outcome::Done, Outcome::Refused)
    }

    /// Where the joints are at the end of the leg.
    pub(crate) fn end_q(&self) -> JointPositions {
        self.leg.path.end().q
    }
}

impl Motion {
    /// Whether it brakes as hard as the arm can where it is faster than its way allows.
    pub(crate) fn brake_hard(&mut self, is_hard: bool) {
        self.travel.brake_hard(is_hard);
    }

    /// The share of its speed that what is laid over it leaves it.
    pub(crate) fn slow_to(&mut self, pace: f64) {
        self.travel.slow_to(pace);
    }

    /// The speed fraction in effect.
    pub(crate) fn fraction(&self) -> f64 {
        self.travel.fraction()
    }

    /// The speed along the way that the next steps begin with, 1/s of its unit.
    pub(crate) fn committed_speed(&self) -> f64 {
        self.travel.committed_speed()
    }
}
