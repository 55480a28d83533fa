//! Where a blend leaves the first leg and where it meets the second, and the curves that lead from one to the other.
//!
//! Geometry alone: whether a curve can be walked at the speed that the arm has is for `blend` to find.

use kinematics::{JointPositions, RobotModel};

use super::blend::UnderWay;
use super::leg::{End, Leg};
use super::{Arm, Warnings};
use crate::constants::{LATEST_ENTRY, PASSED_ENTRY};
use crate::path::{JointQuintic, Path, PathPoint};
use crate::scalar::{Course, ScalarLimits, ScalarState, Stretch};

/// Places on a leg that are stepped through from its end to a place in its zone, so that the branch of solutions stays.
const STEPS_TO_ENTRY: usize = 4;

/// Where the curve begins and ends.
pub(super) struct Corner {
    /// State along the first leg, in its own s.
    pub(super) now: ScalarState,
    /// The first leg's s where the curve begins.
    pub(super) entry: f64,
    /// The second leg's s where it ends.
    pub(super) exit: f64,
    /// The second leg; its zone may have been shortened.
    pub(super) next: Leg,
    /// What there is to say about that.
    pub(super) warnings: Warnings,
    before: f64,
    /// The second leg's s per s of the first at equal distances from the waypoint.
    tcp_rate: f64,
    start: PathPoint,
    end: PathPoint,
}

/// What is equally long per s on both legs next to the curve: they are joined with a common s.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scale {
    /// The distance from the waypoint.
    Tcp,
    /// The way of the joints, where the TCP goes much farther on one leg than on the other for the same turning.
    Joints,
    /// Between these two.
    Between,
    /// What is done in the same time: the next leg at its own speed, the first at the speed that the arm has.
    Speeds,
}

/// The scales in the order of liking.
pub(super) const SCALES: [Scale; 4] = [Scale::Tcp, Scale::Joints, Scale::Speeds, Scale::Between];

/// A curve, and the second leg's s per s of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Curve {
    pub(super) quintic: JointQuintic,
    pub(super) rate: f64,
}

impl Corner {
    /// With the curve beginning at a share of the first leg's zone, but ahead of the arm. `None` when that is passed.
    pub(super) fn new(first: &UnderWay, next: &Leg, share: f64, arm: &Arm) -> Option<Self> {
        let (piece, leg) = (first.piece, first.leg);
        let now = ScalarState {
            position: piece.from + (first.now.position - piece.begin) * piece.rate,
            speed: first.now.speed * piece.rate,
            acceleration: first.now.acceleration * piece.rate,
        };
        let wanted = (leg.path.length() - leg.zone) * share;
        let before = wanted.min((leg.path.length() - now.position) * LATEST_ENTRY);
        if before <= 0.0 || before < wanted * PASSED_ENTRY || next.path.length() <= 0.0 {
            return None;
        }
        let entry = leg.path.length() - before;
        let radius = leg.distance(arm.model, entry, End::Last, leg.measure);
        let (mut next, mut warnings) = (*next, Warnings::default());
        let (place, measure) = next.place(arm.model, radius, End::First);
        let mut exit = place.unwrap_or(next.path.length() / 2.0);
        if exit > next.zone {
            let length = next.path.length();
            exit = length * exit / (exit + length - next.zone);
            next.shorten(exit, arm, &mut warnings);
        }
        let after = next.distance(arm.model, exit, End::First, measure);
        let start = point_at(&leg.path, arm.model, (now.position, &first.q), entry)?;
        let corner_q = leg.path.end().q;
        let end = point_at(&next.path, arm.model, (0.0, &corner_q), exit)?;
        Some(Self {
            now,
            entry,
            exit,
            next,
            warnings,
            before,
            tcp_rate: (exit / after) / (before / radius),
            start,
            end,
        })
    }

    /// The curve on a scale; `None` where there is none.
    pub(super) fn curve(&self, scale: Scale) -> Option<Curve> {
        let joint_rate = norm(&self.start.first) / norm(&self.end.first);
        let rate = match scale {
            Scale::Tcp => self.tcp_rate,
            Scale::Joints => joint_rate,
            Scale::Between => (self.tcp_rate * joint_rate).sqrt(),
            Scale::Speeds => limits_at(&self.next.course, self.exit)?.speed / self.now.speed,
        };
        if !(rate.is_finite() && rate > 0.0) {
            return None;
        }
        let end = PathPoint {
            first: self.end.first.map(|d| d * rate),
            second: self.end.second.map(|d| d * rate * rate),
            ..self.end
        };
        let length = self.before + self.exit / rate;
        Some(Curve {
            quintic: JointQuintic::between(&self.start, &end, length),
            rate,
        })
    }

    /// How far the arm has to go to where the curve begins, in s of the first leg.
    pub(super) fn lead(&self) -> f64 {
        self.entry - self.now.position
    }
}

/// The limits that a course has at a place.
pub(super) fn limits_at(course: &Course, s: f64) -> Option<ScalarLimits> {
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

/// The path's point at `s`, found by stepping from a known place.
pub(super) fn point_at(
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
