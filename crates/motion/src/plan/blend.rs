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

use super::able::{Able, PartBounds};
use super::leg::{End, Leg};
use super::{Arm, Warnings, Wish};
use crate::constants::{
    BLEND_ENTRIES, BLEND_INTERVALS_PER_PART, BLEND_PARTS, POINT_SPEED_MARGIN, ZONE_STOPPING_SHARE,
};
use crate::path::{Chain, Geometry, JointQuintic, Path, PathPoint, Piece};
use crate::scalar::{Course, Drive, ScalarLimits, ScalarState, Stretch, Stretches, Travel};
use crate::setpoint::elbow_speed;

/// Places on a leg that are stepped through from its end to a place in its zone, so that the branch of solutions stays.
const STEPS_TO_ENTRY: usize = 4;

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

    /// One attempt. `None` when the curve that is tried cannot be done from the present state.
    pub fn attempt(
        &mut self,
        first: &UnderWay,
        next: &Leg,
        arm: &Arm,
        warnings: &mut Warnings,
    ) -> Option<Joined> {
        let share = *BLEND_ENTRIES.get(self.tried)?;
        self.tried += 1;
        let corner = Corner::new(first, next, share, arm, warnings)?;
        corner.join(first, arm)
    }
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
        share: f64,
        arm: &Arm,
        warnings: &mut Warnings,
    ) -> Option<Self> {
        let (piece, leg) = (first.piece, first.leg);
        let now = ScalarState {
            position: piece.from + (first.now.position - piece.begin) * piece.rate,
            speed: first.now.speed * piece.rate,
            acceleration: first.now.acceleration * piece.rate,
        };
        let before = (leg.path.length() - now.position) * share;
        if before <= 0.0 || next.path.length() <= 0.0 {
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
        let rate = (exit / after) / (before / radius);
        let start = point_at(&leg.path, arm.model, (now.position, &first.q), entry)?;
        let corner_q = leg.path.end().q;
        let end = point_at(&next.path, arm.model, (0.0, &corner_q), exit)?;
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
        let (piece, leg, next) = (first.piece, first.leg, &self.next);
        let mut list = Stretches::NONE;
        let entry_in_chain = piece.begin + (self.entry - piece.from) / piece.rate;
        list.push_part(
            first.course,
            (first.now.position, entry_in_chain),
            1.0 / piece.rate,
        );
        let left = last_limits(&leg.course)?;
        let right = slowed_by_rate(limits_at(&next.course, self.exit)?, self.rate);
        let length = self.curve.length() / BLEND_PARTS as f64;
        for part in 0..BLEND_PARTS {
            let limits = self.part(part, (&left, &right), leg, arm)?;
            list.push(Stretch::new(length, limits));
        }
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

    /// The limits of one part of the curve; `None` when it leaves the radius or a joint's range.
    fn part(
        &self,
        part: usize,
        (left, right): (&ScalarLimits, &ScalarLimits),
        leg: &Leg,
        arm: &Arm,
    ) -> Option<ScalarLimits> {
        let places = BLEND_PARTS * BLEND_INTERVALS_PER_PART;
        let step = self.curve.length() / places as f64;
        let tcp = &leg.flange_from_tcp;
        let corner = arm.model.tcp_pose(&leg.path.end().q, tcp).translation;
        let mut bounds = PartBounds::NONE;
        let (mut tcp_per_s, mut turn_per_s) = (0.0_f64, 0.0_f64);
        for place in 0..=BLEND_INTERVALS_PER_PART {
            let s = step * (part * BLEND_INTERVALS_PER_PART + place) as f64;
            let point = self.curve.point(s);
            let q = JointPositions(point.q);
            for joint in 0..6 {
                let range = arm.limits.position_min[joint]..=arm.limits.position_max[joint];
                if !range.contains(&q[joint]) {
                    return None;
                }
                // Between two places a value exceeds both by no more than a parabola's height.
                let rise = step * step / 8.0;
                let (d1, d2, d3, d4) = (
                    point.first[joint].abs(),
                    point.second[joint].abs(),
                    point.third[joint].abs(),
                    point.fourth[joint].abs(),
                );
                bounds.first[joint] = bounds.first[joint].max(d1 + rise * d3);
                bounds.second[joint] = bounds.second[joint].max(d2 + rise * d4);
                bounds.third[joint] = bounds.third[joint].max(d3 + 0.5 * step * d4);
                turn_per_s = turn_per_s.max(d1);
            }
            let frames = arm.model.forward(&q);
            let position = (frames.base_from_flange * *tcp).translation;
            if (position - corner).norm() > leg.radius {
                return None;
            }
            let rates = kinematics::JointSpeeds(point.first);
            tcp_per_s = tcp_per_s.max(frames.twist(&rates, position).linear.norm());
            bounds.elbow = bounds.elbow.max(elbow_speed(&frames, &rates));
            bounds.torque.cover(&q, &point.first, &point.second, arm);
        }
        bounds.tcp = tcp_per_s / POINT_SPEED_MARGIN;
        let fastest = left.speed.max(right.speed);
        let speed = if self.is_between_joint_legs(leg) {
            // The leading joint turns one radian per s of the first leg, and `rate` of them on the second.
            left.speed.max(right.speed * self.rate) / turn_per_s
        } else {
            let at = |s: f64| {
                let point = self.curve.point(s);
                let frames = arm.model.forward(&JointPositions(point.q));
                let position = (frames.base_from_flange * *tcp).translation;
                let rates = kinematics::JointSpeeds(point.first);
                frames.twist(&rates, position).linear.norm()
            };
            let (before, after) = (at(0.0), at(self.curve.length()));
            // A tool that only turns has no TCP speed to keep to.
            if before.max(after) < 1e-6 {
                fastest
            } else {
                (before * left.speed).max(after * right.speed) / tcp_per_s
            }
        };
        let wish = Wish {
            speed: speed.min(fastest),
            // Where the slower leg accelerates gently the arm must still get down to its speed within the radius.
            acceleration: left.acceleration.max(right.acceleration),
            duration: 0.0,
            radius: 0.0,
        };
        let limits = Able::of(&bounds, arm.limits).at(&wish);
        limits.are_usable().then_some(limits)
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

/// Limits of an s of which `rate` go to one of another, in that other.
fn slowed_by_rate(limits: ScalarLimits, rate: f64) -> ScalarLimits {
    ScalarLimits {
        speed: limits.speed / rate,
        acceleration: limits.acceleration / rate,
        jerk: limits.jerk / rate,
    }
}
