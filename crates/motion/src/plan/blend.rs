//! From one leg into the next without a stop: a curve inside the blend radius, and one course over what is left of the
//! first leg, the curve and the second leg.
//!
//! The next leg is known at the earliest when the arm enters the zone. The curve begins a little further on, at a share of
//! the way that is left, and ends at the same distance behind the waypoint. It is made in joint space (see
//! [`JointQuintic`]), so that any two kinds of legs join alike, without inverse kinematics on the way.
//!
//! The curve's s is that of the first leg; the second leg's is scaled so that equal distances from the waypoint are
//! equally long. On the curve neither leg's speed is exceeded: not the faster one's TCP speed where a leg is one of the
//! TCP, not the faster one's leading joint between two joint legs.

use kinematics::{JointPositions, RobotModel};

use super::able::Shares;
use super::curve::{CurveParts, CurveWish};
use super::leg::{End, Leg};
use super::{Arm, Warnings};
use crate::constants::{
    BLEND_ENTRIES, BLEND_ENTRIES_PER_CYCLE, BLEND_PARTS, LATEST_ENTRY, ZONE_STOPPING_SHARE,
};
use crate::path::{Chain, Geometry, JointQuintic, Path, PathPoint, Piece};
use crate::scalar::{Course, Drive, ScalarLimits, ScalarState, Stretch, Stretches, Travel};

/// Places on a leg that are stepped through from its end to a place in its zone, so that the branch of solutions stays.
const STEPS_TO_ENTRY: usize = 4;

/// How the curve may be walked, in the order of liking: so many of its first parts for slowing down, the rest with one set
/// of limits that leaves such shares to bends. The more a bend takes the less is there for a change of speed.
const SHAPES: [(usize, Shares); 5] = [
    (0, Shares::EVEN),
    (0, Shares::PACED),
    (2, Shares::PACED),
    (3, Shares::PACED),
    (4, Shares::PACED),
];

/// An entry that lies behind the arm by more than this share is past.
const PASSED_ENTRY: f64 = 0.75;

/// The attempts to join one leg to another, one a cycle.
#[derive(Clone, Copy, Debug, Default)]
pub struct Junction {
    tried: usize,
}

/// A motion under way that may be joined to another.
#[derive(Clone, Copy, Debug)]
pub struct UnderWay<'a> {
    /// Its last leg.
    pub leg: &'a Leg,
    /// The leg's place in the chain.
    pub piece: &'a Piece,
    /// The course over the chain.
    pub course: &'a Course,
    /// State along the chain.
    pub now: ScalarState,
    /// Where the joints are now.
    pub q: JointPositions,
    /// What is wanted of the motion.
    pub drive: Drive,
}

/// Two legs joined.
#[derive(Clone, Copy, Debug)]
pub struct Joined {
    /// Where.
    pub chain: Chain,
    /// How fast, from the present state on.
    pub travel: Travel,
    /// The next leg; its zone may have been shortened.
    pub leg: Leg,
    /// Its zone in the chain's s.
    pub zone: f64,
}

impl Junction {
    /// True when there is nothing left to try: the motion stops at the waypoint.
    pub fn is_given_up(&self) -> bool {
        self.tried >= BLEND_ENTRIES.len()
    }

    /// The attempts of one cycle. `None` when none of the curves that are tried can be done from the present state.
    pub fn attempt(
        &mut self,
        first: &UnderWay,
        next: &Leg,
        arm: &Arm,
        warnings: &mut Warnings,
    ) -> Option<Joined> {
        for _ in 0..BLEND_ENTRIES_PER_CYCLE {
            let share = *BLEND_ENTRIES.get(self.tried)?;
            self.tried += 1;
            for scale in [Scale::Tcp, Scale::Joints, Scale::Speeds] {
                let mut own = Warnings::default();
                let corner = Corner::new(first, next, (share, scale), arm, &mut own);
                if let Some(joined) = corner.and_then(|corner| corner.join(first, arm)) {
                    own.iter().for_each(|warning| warnings.add(warning));
                    return Some(joined);
                }
            }
        }
        None
    }
}

/// What is equally long per s on both legs next to the curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scale {
    /// The distance from the waypoint.
    Tcp,
    /// The way of the joints, where the TCP goes much farther on one leg than on the other for the same turning.
    Joints,
    /// What is done in the same time: the next leg at its own speed, the first at the speed that the arm has.
    Speeds,
}

/// The curve and where it lies on both legs.
struct Corner {
    /// State along the first leg, in its own s.
    now: ScalarState,
    /// The first leg's s where the curve begins.
    entry: f64,
    /// The second leg's s where it ends.
    exit: f64,
    /// The second leg's s per s of the curve.
    rate: f64,
    curve: JointQuintic,
    next: Leg,
}

impl Corner {
    fn new(
        first: &UnderWay,
        next: &Leg,
        (share, scale): (f64, Scale),
        arm: &Arm,
        warnings: &mut Warnings,
    ) -> Option<Self> {
        let (piece, leg) = (first.piece, first.leg);
        let now = ScalarState {
            position: piece.from + (first.now.position - piece.begin) * piece.rate,
            speed: first.now.speed * piece.rate,
            acceleration: first.now.acceleration * piece.rate,
        };
        let zone = leg.path.length() - leg.zone;
        let left = leg.path.length() - now.position;
        // Not at once: the present state must lead there.
        let before = (zone * share).min(left * LATEST_ENTRY);
        if before <= 0.0 || before < zone * share * PASSED_ENTRY || next.path.length() <= 0.0 {
            return None;
        }
        let entry = leg.path.length() - before;
        let radius = leg.distance(arm.model, entry, End::Last, leg.measure);
        let mut next = *next;
        let (place, measure) = next.place(arm.model, radius, End::First);
        let mut exit = place.unwrap_or(next.path.length() / 2.0);
        if exit > next.zone {
            let length = next.path.length();
            exit = length * exit / (exit + length - next.zone);
            next.shorten(exit, arm, warnings);
        }
        let after = next.distance(arm.model, exit, End::First, measure);
        let start = point_at(&leg.path, arm.model, (now.position, &first.q), entry)?;
        let corner_q = leg.path.end().q;
        let end = point_at(&next.path, arm.model, (0.0, &corner_q), exit)?;
        let rate = match scale {
            Scale::Tcp => (exit / after) / (before / radius),
            Scale::Joints => norm(&start.first) / norm(&end.first),
            Scale::Speeds => limits_at(&next.course, exit)?.speed / now.speed,
        };
        if !(rate.is_finite() && rate > 0.0) {
            return None;
        }
        let end = PathPoint {
            first: end.first.map(|d| d * rate),
            second: end.second.map(|d| d * rate * rate),
            ..end
        };
        let curve = JointQuintic::between(&start, &end, before + exit / rate);
        Some(Self {
            now,
            entry,
            exit,
            rate,
            curve,
            next,
        })
    }

    fn join(self, first: &UnderWay, arm: &Arm) -> Option<Joined> {
        let parts = CurveParts::look(&self.curve, first.leg, arm)?;
        let left = last_limits(&first.leg.course)?;
        let right = slowed_by_rate(limits_at(&self.next.course, self.exit)?, self.rate);
        let wish = self.wish(&parts, (&left, &right), first.leg);
        SHAPES
            .iter()
            .find_map(|shape| self.join_as(*shape, &parts, &wish, (first, &right), arm))
    }

    /// With a curve in one or two stretches.
    fn join_as(
        &self,
        (slowing, shares): (usize, Shares),
        parts: &CurveParts,
        wish: &CurveWish,
        (first, right): (&UnderWay, &ScalarLimits),
        arm: &Arm,
    ) -> Option<Joined> {
        let (piece, leg, next) = (first.piece, first.leg, &self.next);
        let mut list = Stretches::NONE;
        let entry_in_chain = piece.begin + (self.entry - piece.from) / piece.rate;
        list.push_part(
            first.course,
            (first.now.position, entry_in_chain),
            1.0 / piece.rate,
        );
        let length = |parts: usize| self.curve.length() * parts as f64 / BLEND_PARTS as f64;
        if slowing > 0 {
            let limits = parts.limits(0..slowing, wish, Shares::EVEN, arm)?;
            list.push(Stretch::new(length(slowing), limits));
        }
        let limits = parts.limits(slowing..BLEND_PARTS, wish, shares, arm)?;
        let limits = alike(limits, right);
        list.push(Stretch::new(length(BLEND_PARTS - slowing), limits));
        list.push_part(&next.course, (self.exit, next.path.length()), self.rate);
        let lead = self.entry - self.now.position;
        let begin = lead + self.curve.length();
        let zone = begin + (next.zone - self.exit) / self.rate;
        if next.radius > 0.0 {
            list = list.with_zone(zone, ZONE_STOPPING_SHARE, next.zone_speed / self.rate);
        }
        let travel = Travel::joining(Course::moving(&list)?, self.now, first.drive)?;
        let chain = Chain::of_three([
            Piece {
                path: leg.path,
                from: self.now.position,
                rate: 1.0,
                begin: 0.0,
            },
            Piece {
                path: Path::new(Geometry::Blend(self.curve)),
                from: 0.0,
                rate: 1.0,
                begin: lead,
            },
            Piece {
                path: next.path,
                from: self.exit,
                rate: self.rate,
                begin,
            },
        ]);
        Some(Joined {
            chain,
            travel,
            leg: *next,
            zone,
        })
    }

    /// How fast the curve is wanted between legs with the limits `left` and `right`.
    fn wish(
        &self,
        parts: &CurveParts,
        (left, right): (&ScalarLimits, &ScalarLimits),
        leg: &Leg,
    ) -> CurveWish {
        let (before, after) = parts.tcp_at_ends();
        let (mut tcp, mut turn) = (f64::INFINITY, f64::INFINITY);
        if self.is_between_joint_legs(leg) {
            // The leading joint turns one radian per s of the first leg, and `rate` of them on the second.
            turn = left.speed.max(right.speed * self.rate);
        } else if before.max(after) >= 1e-6 {
            // A tool that only turns has no TCP speed to keep to.
            tcp = (before * left.speed).max(after * right.speed);
        }
        CurveWish {
            speed: left.speed.max(right.speed),
            tcp,
            turn,
            // Where the slower leg accelerates gently the arm must still get down to its speed within the radius.
            acceleration: left.acceleration.max(right.acceleration),
        }
    }

    fn is_between_joint_legs(&self, leg: &Leg) -> bool {
        matches!(
            (leg.path.geometry(), self.next.path.geometry()),
            (Geometry::Joint(_), Geometry::Joint(_))
        )
    }
}

/// The path's point at `s`, found by stepping from a known place.
fn point_at(
    path: &Path,
    model: &RobotModel,
    (from, q): (f64, &JointPositions),
    s: f64,
) -> Option<PathPoint> {
    let mut point = PathPoint {
        s: from,
        q: *q,
        first: [0.0; 6],
        second: [0.0; 6],
    };
    for step in 1..=STEPS_TO_ENTRY {
        let place = from + (s - from) * step as f64 / STEPS_TO_ENTRY as f64;
        point = path.point(model, place, &point.q)?;
    }
    Some(point)
}

fn norm(rates: &[f64; 6]) -> f64 {
    rates.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn last_limits(course: &Course) -> Option<ScalarLimits> {
    course.stretches().last().map(Stretch::paced)
}

fn limits_at(course: &Course, s: f64) -> Option<ScalarLimits> {
    let mut end = 0.0;
    course
        .stretches()
        .iter()
        .find(|stretch| {
            end += stretch.length;
            end > s
        })
        .or(course.stretches().last())
        .map(Stretch::paced)
}

/// The limits of the neighbour where those are as fast: one stretch needs no end of acceleration between them.
fn alike(limits: ScalarLimits, neighbour: &ScalarLimits) -> ScalarLimits {
    let bears = |own: f64, other: f64| own >= other * (1.0 - 1e-9);
    let is_as_fast = bears(limits.speed, neighbour.speed)
        && bears(neighbour.speed, limits.speed)
        && bears(limits.acceleration, neighbour.acceleration)
        && bears(limits.jerk, neighbour.jerk);
    if is_as_fast { *neighbour } else { limits }
}

/// Limits of an s of which `rate` go to one of another, in that other.
fn slowed_by_rate(limits: ScalarLimits, rate: f64) -> ScalarLimits {
    ScalarLimits {
        speed: limits.speed / rate,
        acceleration: limits.acceleration / rate,
        jerk: limits.jerk / rate,
    }
}
