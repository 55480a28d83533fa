//! The corner between two legs: where a blend leaves the first and meets the second, the curves that lead over it, and what
//! they bear.
//!
//! Two lines of the TCP join over a [`Turn`]; whatever else meets joins over a curve in joint space (see [`JointQuintic`]),
//! so that any two kinds of legs join alike, without inverse kinematics on the way.

use kinematics::{JointPositions, JointSpeeds, Pose, RobotModel};

use super::able::Bounds;
use super::leg::{End, Leg};
use super::{Arm, Warnings, Wish};
use crate::config::MotionLimits;
use crate::constants::{
    ACCELERATION_RISE, BLEND_CELLS, BLEND_TCP_SHARE, HARDER_IN_BLENDS, LATEST_ENTRY, PASSED_ENTRY,
    POINT_SPEED_MARGIN,
};
use crate::path::{JointQuintic, Path, PathPoint, QuinticPoint, TcpWay, Turn};
use crate::scalar::CellLimits;
use crate::setpoint::elbow_speed;

/// Places on a leg that are stepped through from its end to a place in its zone, so that the branch of solutions stays: few,
/// and more where that does not do.
const STEPS_TO_ENTRY: [usize; 2] = [4, 16];

/// Where the curve may begin and end.
pub(super) struct Corner<'a> {
    first: &'a Leg,
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
}

/// What is equally long per s on both legs next to a curve in joint space: they are joined with a common s.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scale {
    /// The distance from the waypoint.
    Tcp,
    /// The way of the joints, where the TCP goes much farther on one leg than on the other for the same turning.
    Joints,
    /// Between these two.
    Between,
    /// What is done in the same time at the speeds that are asked for.
    Speeds,
}

/// Two ways meet without a corner where no joint's speed has a larger step than this, rad/s, nor its acceleration, rad/s²: less
/// than a twentieth of what the jerk allows in the shortest cycle.
const STRAIGHT: (f64, f64) = (2e-5, 0.02);

/// What one of the first leg's s is on the second where that goes straight on, so that there is no corner.
pub(super) fn goes_straight_on(first: &Leg, next: &Leg, arm: &Arm) -> Option<f64> {
    if next.path.length() <= 0.0 {
        return None;
    }
    let corner = first.path.end().q;
    let left = first.path.point(arm.model, first.path.length(), &corner)?;
    let right = next.path.point(arm.model, 0.0, &corner)?;
    let rate = norm(&left.first) / norm(&right.first);
    let speed = first.wish.speed.max(next.wish.speed / rate);
    let is_straight = (0..6).all(|joint| {
        let kink = (left.first[joint] - rate * right.first[joint]).abs() * speed;
        let bend = (left.second[joint] - rate * rate * right.second[joint]).abs();
        kink <= STRAIGHT.0 && bend * speed * speed <= STRAIGHT.1
    });
    (rate.is_finite() && rate > 0.0 && is_straight).then_some(rate)
}

/// A curve, and what it bears cell by cell.
#[derive(Clone, Copy, Debug)]
pub struct Curve {
    /// The curve; its s is the first leg's.
    pub path: Path,
    /// The first leg's s where it begins.
    pub entry: f64,
    /// The second leg's s where it ends.
    pub exit: f64,
    /// The second leg's s per s of the curve.
    pub rate: f64,
    cells: [(f64, CellLimits); BLEND_CELLS],
}

impl Curve {
    /// Where each cell ends, and what it bears.
    pub fn cells(&self) -> impl Iterator<Item = (f64, &CellLimits)> {
        self.cells.iter().map(|(until, limits)| (*until, limits))
    }

    /// Time it takes where nothing before and behind it slows it down, s.
    pub(super) fn time(&self) -> f64 {
        let mut from = 0.0;
        self.cells().fold(0.0, |time, (until, limits)| {
            let way = until - from;
            from = until;
            time + way / limits.speed
        })
    }
}

impl<'a> Corner<'a> {
    /// With the curve beginning at a share of the first leg's zone, but behind `committed`. `None` when that is passed.
    pub(super) fn new(
        first: &'a Leg,
        committed: f64,
        next: &Leg,
        share: f64,
        arm: &Arm,
    ) -> Option<Self> {
        let length = first.path.length();
        let wanted = (length - first.zone) * share;
        let before = wanted.min((length - committed) * LATEST_ENTRY);
        if before <= 0.0 || before < wanted * PASSED_ENTRY || next.path.length() <= 0.0 {
            return None;
        }
        let entry = length - before;
        let radius = first.distance(arm.model, entry, End::Last, first.measure);
        let (mut next, mut warnings) = (*next, Warnings::default());
        let (place, measure) = next.place(arm.model, radius, End::First);
        let mut exit = place.unwrap_or(next.path.length() / 2.0);
        if exit > next.zone * (1.0 + 1e-9) {
            let length = next.path.length();
            exit = length * exit / (exit + length - next.zone);
            next.shorten(exit, arm, &mut warnings);
        }
        let after = next.distance(arm.model, exit, End::First, measure);
        Some(Self {
            first,
            entry,
            exit,
            next,
            warnings,
            before,
            tcp_rate: (exit / after) / (before / radius),
        })
    }

    /// The curve that is walked in the shortest time; `None` where there is none.
    pub(super) fn best(&self, arm: &Arm) -> Option<Curve> {
        let mut best = self.turn(arm);
        if best.is_some() && self.first.touch > 0.0 {
            return best;
        }
        let start = point_from_end(&self.first.path, arm.model, self.entry)?;
        let end = point_at(
            &self.next.path,
            arm.model,
            &self.first.path.end().q,
            self.exit,
        )?;
        for scale in [Scale::Tcp, Scale::Joints, Scale::Speeds, Scale::Between] {
            let rate = self.rate(scale, &start, &end);
            let curve = self.quintic(rate, &start, &end, arm);
            // The arc, or the one along the TCP's way, is kept unless another is clearly better.
            if let Some(curve) = curve
                && best
                    .as_ref()
                    .is_none_or(|best| curve.time() < 0.9 * best.time())
            {
                best = Some(curve);
            }
        }
        best
    }

    fn rate(&self, scale: Scale, start: &PathPoint, end: &PathPoint) -> f64 {
        let joints = norm(&start.first) / norm(&end.first);
        match scale {
            Scale::Tcp => self.tcp_rate,
            Scale::Joints => joints,
            Scale::Between => (self.tcp_rate * joints).sqrt(),
            Scale::Speeds => self.next.wish.speed / self.first.wish.speed,
        }
    }

    /// The curve between two lines of the TCP.
    fn turn(&self, arm: &Arm) -> Option<Curve> {
        let (Path::Cartesian(first), Path::Cartesian(second)) = (&self.first.path, &self.next.path)
        else {
            return None;
        };
        if self.first.flange_from_tcp != self.next.flange_from_tcp {
            // Lines of different TCPs have no corner in common.
            return None;
        }
        let room = self.before.min(self.exit);
        if self.first.touch <= 0.0 && room < PASSED_ENTRY * self.before {
            // Beside a short line the arc would use little of the radius.
            return None;
        }
        let touch = if self.first.touch > 0.0 {
            self.first.touch
        } else {
            f64::INFINITY
        };
        let ramp = self.wish().speed * ACCELERATION_RISE;
        let turn = Turn::between(first, second, (touch, room), ramp)?;
        let [knee, fall] = turn.knees();
        let (length, third) = (turn.length(), BLEND_CELLS / 3);
        let entry = first.length() - turn.reach();
        let mut left = point_from_end(&self.first.path, arm.model, entry)?;
        left.s = 0.0;
        let wish = self.wish();
        let mut cells = [(0.0, CellLimits::NONE); BLEND_CELLS];
        for (k, cell) in cells.iter_mut().enumerate() {
            let (from, to) = match k / third {
                0 => (0.0, knee),
                1 => (knee, fall),
                _ => (fall, length),
            };
            let s = from + (to - from) * ((k % third + 1) as f64 / third as f64);
            let q = turn.positions(arm.model, s, &left.q)?;
            let right = turn.point(arm.model, s, q)?;
            let is_near = (0..6).all(|joint| (q[joint] - left.q[joint]).abs() < JUMP)
                && right.branch == left.branch;
            if !is_near || !is_in_range(&q.0, arm) {
                return None;
            }
            let mut bounds = Bounds::NONE;
            let elbow = elbow_at(&left, arm).max(elbow_at(&right, arm));
            bounds.cover(&left, &right, elbow, arm);
            bounds.tcp = 1.0;
            *cell = (s, bounds.limits(&wish, arm.limits));
            if !cell.1.are_usable() {
                return None;
            }
            left = right;
        }
        Some(Curve {
            path: Path::Turn(turn.ending_at(left.q)),
            entry,
            exit: turn.reach(),
            rate: 1.0,
            cells,
        })
    }

    /// The speed and acceleration that the curve is wanted with: those of the faster leg.
    fn wish(&self) -> Wish {
        let (first, next) = (&self.first.wish, &self.next.wish);
        Wish {
            speed: first.speed.max(next.speed),
            acceleration: first.acceleration.max(next.acceleration),
            duration: if first.duration > 0.0 && next.duration > 0.0 {
                first.duration
            } else {
                0.0
            },
            radius: 0.0,
            is_process: false,
        }
    }

    /// A curve in joint space where one of its s is `rate` of the second leg's; `None` when it leaves the radius or a
    /// joint's range.
    fn quintic(&self, rate: f64, start: &PathPoint, end: &PathPoint, arm: &Arm) -> Option<Curve> {
        if !(rate.is_finite() && rate > 0.0) {
            return None;
        }
        let end = PathPoint {
            first: end.first.map(|d| d * rate),
            second: end.second.map(|d| d * rate * rate),
            ..*end
        };
        let length = self.before + self.exit / rate;
        let curve = JointQuintic::between(start, &end, length);
        let both_joint = matches!(
            (&self.first.path, &self.next.path),
            (Path::Joint(_), Path::Joint(_))
        );
        let asked = self.wish();
        // Two legs of joints never accelerate their joints more than twice what was asked for.
        let most = if both_joint && asked.duration <= 0.0 {
            HARDER_IN_BLENDS * asked.acceleration
        } else {
            f64::INFINITY
        };
        let limits = MotionLimits {
            acceleration: arm.limits.acceleration.map(|a| a.min(most)),
            ..*arm.limits
        };
        let tool = &self.first.flange_from_tcp;
        let corner = arm.model.tcp_pose(&self.first.path.end().q, tool);
        let rates = |point: &QuinticPoint| rates(point, tool, &corner, arm);
        let step = length / BLEND_CELLS as f64;
        let mut left = curve.point(0.0);
        let mut left_rates = rates(&left);
        let ended = rates(&curve.point(length)).tcp;
        let caps = self.caps(both_joint, left_rates.tcp, ended / rate);
        let mut cells = [(0.0, CellLimits::NONE); BLEND_CELLS];
        for (k, cell) in cells.iter_mut().enumerate() {
            let s = step * (k + 1) as f64;
            let right = curve.point(s);
            let right_rates = rates(&right);
            let middle = rates(&curve.point(s - 0.5 * step));
            let is_inside = right_rates.from_corner <= self.first.radius * (1.0 + 1e-9);
            if !is_in_range(&right.q, arm) || !(is_inside || k + 1 == BLEND_CELLS) {
                return None;
            }
            let (mut bounds, turning) = between(&left, &right, step);
            let q = JointPositions(right.q);
            bounds.torque.cover(&q, &right.first, &right.second, arm);
            let tcp = peak(left_rates.tcp, middle.tcp, right_rates.tcp);
            bounds.tcp = tcp / POINT_SPEED_MARGIN;
            bounds.elbow = peak(left_rates.elbow, middle.elbow, right_rates.elbow);
            let wish = Wish {
                speed: (self.first.wish.speed.max(self.next.wish.speed / rate))
                    .min(BLEND_TCP_SHARE * caps.tcp / tcp)
                    .min(caps.turning / turning),
                acceleration: asked.acceleration.max(self.next.wish.acceleration / rate),
                ..asked
            };
            *cell = (s, bounds.limits(&wish, &limits));
            // Stops are made of what the joints can do, not of what the program asks for.
            cell.1.hardest = bounds.hardest(cell.1.speed, arm.limits);
            if !cell.1.are_usable() {
                return None;
            }
            (left, left_rates) = (right, right_rates);
        }
        Some(Curve {
            path: Path::Blend(curve),
            entry: self.entry,
            exit: self.exit,
            rate,
            cells,
        })
    }

    /// On the curve neither leg's speed is exceeded: not the faster one's TCP speed where a leg is one of the TCP, not the
    /// faster one's leading joint between two joint legs. The TCP goes so far per s of the first leg and of the second where
    /// the curve begins and ends.
    fn caps(&self, both_joint: bool, begun: f64, ended: f64) -> Caps {
        let (first, next) = (&self.first.wish, &self.next.wish);
        let none = Caps {
            tcp: f64::INFINITY,
            turning: f64::INFINITY,
        };
        if first.duration > 0.0 && next.duration > 0.0 {
            none
        } else if both_joint {
            Caps {
                turning: first.speed.max(next.speed),
                ..none
            }
        } else if begun.max(ended) < 1e-6 {
            // A tool that only turns has no TCP speed to keep to.
            none
        } else {
            Caps {
                tcp: (first.speed * begun).max(next.speed * ended),
                ..none
            }
        }
    }
}

/// Distances per s at a place of a curve, m, and how far the TCP is from the corner there, m.
#[derive(Clone, Copy)]
struct Rates {
    tcp: f64,
    elbow: f64,
    from_corner: f64,
}

/// What TCP and elbow do per s at a place of a curve in joint space.
fn rates(point: &QuinticPoint, tool: &Pose, corner: &Pose, arm: &Arm) -> Rates {
    let frames = arm.model.forward(&JointPositions(point.q));
    let at = (frames.base_from_flange * *tool).translation;
    let rates = JointSpeeds(point.first);
    Rates {
        tcp: frames.twist(&rates, at).linear.norm(),
        elbow: elbow_speed(&frames, &rates),
        from_corner: (at - corner.translation).norm(),
    }
}

/// The fastest that the TCP may go on a curve, m/s, and a joint turn, rad/s.
#[derive(Clone, Copy)]
struct Caps {
    tcp: f64,
    turning: f64,
}

/// A parabola through three places rises over its ends by an eighth of their second difference.
fn peak(a: f64, b: f64, c: f64) -> f64 {
    a.max(b).max(c) + (a - 2.0 * b + c).abs() / 8.0
}

/// The largest derivatives between two places of a curve, and the largest first one of any joint.
fn between(left: &QuinticPoint, right: &QuinticPoint, step: f64) -> (Bounds, f64) {
    let mut bounds = Bounds::NONE;
    // Between two places a value exceeds both by no more than a parabola's height.
    let rise = step * step / 8.0;
    let mut turning = 0.0_f64;
    for joint in 0..6 {
        for point in [left, right] {
            let fourth = point.fourth[joint].abs();
            let first = point.first[joint].abs() + rise * point.third[joint].abs();
            turning = turning.max(first);
            bounds.first[joint] = bounds.first[joint].max(first);
            let second = point.second[joint].abs() + rise * fourth;
            bounds.second[joint] = bounds.second[joint].max(second);
            let third = point.third[joint].abs() + 0.5 * step * fourth;
            bounds.third[joint] = bounds.third[joint].max(third);
        }
    }
    (bounds, turning)
}

/// A turn between two neighbouring places, rad, beyond which it is another branch of solutions.
const JUMP: f64 = 0.5;

fn elbow_at(point: &PathPoint, arm: &Arm) -> f64 {
    elbow_speed(&arm.model.forward(&point.q), &JointSpeeds(point.first))
}

fn is_in_range(q: &[f64; 6], arm: &Arm) -> bool {
    (0..6).all(|joint| {
        let range = arm.limits.position_min[joint]..=arm.limits.position_max[joint];
        range.contains(&q[joint])
    })
}

/// The path's point at a place near its end.
fn point_from_end(path: &Path, model: &RobotModel, s: f64) -> Option<PathPoint> {
    stepped(path, model, path.length(), &path.end().q, s)
}

/// The path's point at `s`, found by stepping from its beginning at `q`.
fn point_at(path: &Path, model: &RobotModel, q: &JointPositions, s: f64) -> Option<PathPoint> {
    stepped(path, model, 0.0, q, s)
}

/// `None` also where even small steps go over into another branch of solutions.
fn stepped(
    path: &Path,
    model: &RobotModel,
    from: f64,
    q: &JointPositions,
    s: f64,
) -> Option<PathPoint> {
    let begin = path.point(model, from, q)?;
    STEPS_TO_ENTRY.into_iter().find_map(|steps| {
        (1..=steps).try_fold(begin, |point, step| {
            let place = from + (s - from) * step as f64 / steps as f64;
            let found = path.point(model, place, &point.q)?;
            (found.branch == point.branch).then_some(found)
        })
    })
}

fn norm(rates: &[f64; 6]) -> f64 {
    rates.iter().map(|x| x * x).sum::<f64>().sqrt()
}
