//! The corner between two legs: where a blend leaves the first and meets the second, the curves that lead over it, and
//! what they bear.
//!
//! Two lines of the TCP join over a [`ClothoidBlend`]; whatever else meets joins over a curve in joint space (see
//! [`JointQuintic`]), so that any two kinds of legs join alike, without inverse kinematics on the way.

use kinematics::{JointPositions, JointSpeeds, Pose, RobotModel};

use super::able::DerivativeBounds;
use super::leg::{MotionSegment, SegmentEnd};
use super::{MotionRequest, PlanningContext, Warnings};
use crate::config::MotionLimits;
use crate::constants::{
    ACCELERATION_RISE, BLEND_ACCELERATION_FACTOR, BLEND_CELLS, BLEND_TCP_SHARE, MAX_ENTRY_SHARE,
    MIN_ENTRY_SHARE, POINT_SPEED_MARGIN,
};
use crate::path::{ClothoidBlend, JointQuintic, Path, PathPoint, QuinticPoint, TcpPath};
use crate::scalar::IntervalLimits;
use crate::setpoint::elbow_speed;

/// Places on a leg that are stepped through from its end to a place in its zone, so that the branch of solutions stays:
/// few, and more where that does not do.
const STEPS_TO_ENTRY: [usize; 2] = [4, 16];

/// Where the curve may begin and end.
pub(super) struct BlendGeometry<'a> {
    first: &'a MotionSegment,
    /// The first leg's s where the curve begins.
    pub(super) entry: f64,
    /// The second leg's s where the curve ends.
    pub(super) exit: f64,
    /// The second leg; its zone may have been shortened.
    pub(super) next: MotionSegment,
    /// What there is to say about that.
    pub(super) warnings: Warnings,
    entry_distance: f64,
    /// The second leg's s per s of the first at equal distances from the waypoint.
    tcp_rate: f64,
}

/// What is equally long per s on both legs next to a curve in joint space: they are joined with a common s.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ParameterMatching {
    /// The distance from the waypoint.
    Tcp,
    /// The way of the joints, where the TCP goes much farther on one leg than on the other for the same turning.
    Joints,
    /// Something between the distance of the TCP and the way of the joints.
    Between,
    /// What is done in the same time at the speeds that are asked for.
    Speeds,
}

/// Two ways meet without a corner where no joint's speed has a larger step than this, rad/s, nor its acceleration,
/// rad/s²: less than a twentieth of what the jerk allows in the shortest cycle.
const STRAIGHT: (f64, f64) = (2e-5, 0.02);

/// What one of the first leg's s is on the second where that goes straight on, so that there is no corner.
pub(super) fn goes_straight_on(
    first: &MotionSegment,
    next: &MotionSegment,
    arm: &PlanningContext,
) -> Option<f64> {
    if next.path.length() <= 0.0 {
        return None;
    }
    let corner = first.path.end_setpoint().q;
    let left = first.path.point(arm.model, first.path.length(), &corner)?;
    let right = next.path.point(arm.model, 0.0, &corner)?;
    let rate = norm(&left.dq_ds) / norm(&right.dq_ds);
    let speed = first.request.speed.max(next.request.speed / rate);
    let is_straight = (0..6).all(|joint| {
        let kink = (left.dq_ds[joint] - rate * right.dq_ds[joint]).abs() * speed;
        let bend = (left.d2q_ds2[joint] - rate * rate * right.d2q_ds2[joint]).abs();
        kink <= STRAIGHT.0 && bend * speed * speed <= STRAIGHT.1
    });
    (rate.is_finite() && rate > 0.0 && is_straight).then_some(rate)
}

/// A curve, and what it bears cell by cell.
#[derive(Clone, Copy, Debug)]
pub struct Blend {
    /// The curve; its s is the first leg's.
    pub path: Path,
    /// The first leg's s where the curve begins.
    pub entry: f64,
    /// The second leg's s where the curve ends.
    pub exit: f64,
    /// The second leg's s per s of the curve.
    pub rate: f64,
    cells: [(f64, IntervalLimits); BLEND_CELLS],
}

impl Blend {
    /// Where each cell ends, and what it bears.
    pub fn cells(&self) -> impl Iterator<Item = (f64, &IntervalLimits)> {
        self.cells.iter().map(|(until, limits)| (*until, limits))
    }

    /// Time it takes where nothing before and behind it slows it down, s.
    pub(super) fn min_duration(&self) -> f64 {
        let mut from = 0.0;
        self.cells().fold(0.0, |time, (until, limits)| {
            let way = until - from;
            from = until;
            time + way / limits.speed
        })
    }
}

impl<'a> BlendGeometry<'a> {
    /// With the curve beginning at a share of the first leg's zone, but behind `committed`. `None` when that is passed.
    pub(super) fn new(
        first: &'a MotionSegment,
        committed: f64,
        next: &MotionSegment,
        share: f64,
        arm: &PlanningContext,
    ) -> Option<Self> {
        let length = first.path.length();
        let wanted = (length - first.blend_start) * share;
        let before = wanted.min((length - committed) * MAX_ENTRY_SHARE);
        if before <= 0.0 || before < wanted * MIN_ENTRY_SHARE || next.path.length() <= 0.0 {
            return None;
        }
        let entry = length - before;
        let radius = first.distance(arm.model, entry, SegmentEnd::Target, first.measure);
        let (mut next, mut warnings) = (*next, Warnings::default());
        let (place, measure) = next.parameter_at_distance(arm.model, radius, SegmentEnd::Start);
        let mut exit = place.unwrap_or(next.path.length() / 2.0);
        if exit > next.blend_start * (1.0 + 1e-9) {
            let length = next.path.length();
            exit = length * exit / (exit + length - next.blend_start);
            next.shorten_blend_zone(exit, arm, &mut warnings);
        }
        let after = next.distance(arm.model, exit, SegmentEnd::Start, measure);
        Some(Self {
            first,
            entry,
            exit,
            next,
            warnings,
            entry_distance: before,
            tcp_rate: (exit / after) / (before / radius),
        })
    }

    /// The curve that is walked in the shortest time; `None` where there is none.
    pub(super) fn fastest_blend(&self, arm: &PlanningContext) -> Option<Blend> {
        let mut best = self.clothoid_blend(arm);
        if best.is_some() && self.first.arc_tangent_distance > 0.0 {
            return best;
        }
        let start = point_from_end(&self.first.path, arm.model, self.entry)?;
        let end = point_at(
            &self.next.path,
            arm.model,
            &self.first.path.end_setpoint().q,
            self.exit,
        )?;
        for scale in [
            ParameterMatching::Tcp,
            ParameterMatching::Joints,
            ParameterMatching::Speeds,
            ParameterMatching::Between,
        ] {
            let rate = self.rate(scale, &start, &end);
            let curve = self.joint_blend(rate, &start, &end, arm);
            // The arc, or the one along the TCP's way, is kept unless another is clearly better.
            if let Some(curve) = curve
                && best
                    .as_ref()
                    .is_none_or(|best| curve.min_duration() < 0.9 * best.min_duration())
            {
                best = Some(curve);
            }
        }
        best
    }

    fn rate(&self, scale: ParameterMatching, start: &PathPoint, end: &PathPoint) -> f64 {
        let joints = norm(&start.dq_ds) / norm(&end.dq_ds);
        match scale {
            ParameterMatching::Tcp => self.tcp_rate,
            ParameterMatching::Joints => joints,
            ParameterMatching::Between => (self.tcp_rate * joints).sqrt(),
            ParameterMatching::Speeds => self.next.request.speed / self.first.request.speed,
        }
    }

    /// The curve between two lines of the TCP.
    fn clothoid_blend(&self, arm: &PlanningContext) -> Option<Blend> {
        let (Path::Cartesian(first), Path::Cartesian(second)) = (&self.first.path, &self.next.path)
        else {
            return None;
        };
        if self.first.flange_from_tcp != self.next.flange_from_tcp {
            // Lines of different TCPs have no corner in common.
            return None;
        }
        let room = self.entry_distance.min(self.exit);
        if self.first.arc_tangent_distance <= 0.0 && room < MIN_ENTRY_SHARE * self.entry_distance {
            // Beside a short line the arc would use little of the radius.
            return None;
        }
        let touch = if self.first.arc_tangent_distance > 0.0 {
            self.first.arc_tangent_distance
        } else {
            f64::INFINITY
        };
        let ramp = self.wish().speed * ACCELERATION_RISE;
        let turn = ClothoidBlend::between(first, second, (touch, room), ramp)?;
        let [knee, fall] = turn.arc_bounds();
        let (length, third) = (turn.length(), BLEND_CELLS / 3);
        let entry = first.length() - turn.reach();
        let mut left = point_from_end(&self.first.path, arm.model, entry)?;
        left.s = 0.0;
        let wish = self.wish();
        let mut cells = [(0.0, IntervalLimits::NONE); BLEND_CELLS];
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
            let mut bounds = DerivativeBounds::NONE;
            let elbow = elbow_at(&left, arm).max(elbow_at(&right, arm));
            bounds.include_interval(&left, &right, elbow, arm);
            bounds.tcp = 1.0;
            *cell = (s, bounds.interval_limits(&wish, arm.limits));
            if !cell.1.are_usable() {
                return None;
            }
            left = right;
        }
        Some(Blend {
            path: Path::ClothoidBlend(turn.ending_at(left.q)),
            entry,
            exit: turn.reach(),
            rate: 1.0,
            cells,
        })
    }

    /// The speed and acceleration that the curve is wanted with: those of the faster leg.
    fn wish(&self) -> MotionRequest {
        let (first, next) = (&self.first.request, &self.next.request);
        MotionRequest {
            speed: first.speed.max(next.speed),
            acceleration: first.acceleration.max(next.acceleration),
            duration: if first.duration > 0.0 && next.duration > 0.0 {
                first.duration
            } else {
                0.0
            },
            radius: 0.0,
            is_process_move: false,
        }
    }

    /// A curve in joint space where one of its s is `rate` of the second leg's; `None` when it leaves the radius or a
    /// joint's range.
    fn joint_blend(
        &self,
        rate: f64,
        start: &PathPoint,
        end: &PathPoint,
        arm: &PlanningContext,
    ) -> Option<Blend> {
        if !(rate.is_finite() && rate > 0.0) {
            return None;
        }
        let end = PathPoint {
            dq_ds: end.dq_ds.map(|d| d * rate),
            d2q_ds2: end.d2q_ds2.map(|d| d * rate * rate),
            ..*end
        };
        let length = self.entry_distance + self.exit / rate;
        let curve = JointQuintic::between(start, &end, length);
        let both_joint = matches!(
            (&self.first.path, &self.next.path),
            (Path::Joint(_), Path::Joint(_))
        );
        let asked = self.wish();
        // Two legs of joints never accelerate their joints more than twice what was asked for.
        let most = if both_joint && asked.duration <= 0.0 {
            BLEND_ACCELERATION_FACTOR * asked.acceleration
        } else {
            f64::INFINITY
        };
        let limits = MotionLimits {
            acceleration: arm.limits.acceleration.map(|a| a.min(most)),
            ..*arm.limits
        };
        let tool = &self.first.flange_from_tcp;
        let corner = arm.model.tcp_pose(&self.first.path.end_setpoint().q, tool);
        let rates = |point: &QuinticPoint| rates(point, tool, &corner, arm);
        let step = length / BLEND_CELLS as f64;
        let mut left = curve.point(0.0);
        let mut left_rates = rates(&left);
        let ended = rates(&curve.point(length)).tcp;
        let caps = self.caps(both_joint, left_rates.tcp, ended / rate);
        let mut cells = [(0.0, IntervalLimits::NONE); BLEND_CELLS];
        for (k, cell) in cells.iter_mut().enumerate() {
            let s = step * (k + 1) as f64;
            let right = curve.point(s);
            let right_rates = rates(&right);
            let middle = rates(&curve.point(s - 0.5 * step));
            let is_inside = right_rates.from_corner <= self.first.radius * (1.0 + 1e-9);
            if !is_in_range(&right.q, arm) || !(is_inside || k + 1 == BLEND_CELLS) {
                return None;
            }
            let (mut bounds, turning) = bounds_between(&left, &right, step);
            let q = JointPositions(right.q);
            bounds.torque.cover(&q, &right.dq_ds, &right.d2q_ds2, arm);
            let tcp = peak(left_rates.tcp, middle.tcp, right_rates.tcp);
            bounds.tcp = tcp / POINT_SPEED_MARGIN;
            bounds.elbow = peak(left_rates.elbow, middle.elbow, right_rates.elbow);
            let wish = MotionRequest {
                speed: (self.first.request.speed.max(self.next.request.speed / rate))
                    .min(BLEND_TCP_SHARE * caps.tcp / tcp)
                    .min(caps.turning / turning),
                acceleration: asked
                    .acceleration
                    .max(self.next.request.acceleration / rate),
                ..asked
            };
            *cell = (s, bounds.interval_limits(&wish, &limits));
            // Stops are made of what the joints can do, not of what the program asks for.
            cell.1.max_braking = bounds.hardest(cell.1.speed, arm.limits);
            if !cell.1.are_usable() {
                return None;
            }
            (left, left_rates) = (right, right_rates);
        }
        Some(Blend {
            path: Path::JointBlend(curve),
            entry: self.entry,
            exit: self.exit,
            rate,
            cells,
        })
    }

    /// On the curve neither leg's speed is exceeded: not the faster one's TCP speed where a leg is one of the TCP, not
    /// the faster one's leading joint between two joint legs. The TCP goes so far per s of the first leg and of the
    /// second where the curve begins and ends.
    fn caps(&self, both_joint: bool, begun: f64, ended: f64) -> SpeedCaps {
        let (first, next) = (&self.first.request, &self.next.request);
        let none = SpeedCaps {
            tcp: f64::INFINITY,
            turning: f64::INFINITY,
        };
        if first.duration > 0.0 && next.duration > 0.0 {
            none
        } else if both_joint {
            SpeedCaps {
                turning: first.speed.max(next.speed),
                ..none
            }
        } else if begun.max(ended) < 1e-6 {
            // A tool that only turns has no TCP speed to keep to.
            none
        } else {
            SpeedCaps {
                tcp: (first.speed * begun).max(next.speed * ended),
                ..none
            }
        }
    }
}

/// Distances per s at a place of a curve, m, and how far the TCP is from the corner there, m.
#[derive(Clone, Copy)]
struct PointRates {
    tcp: f64,
    elbow: f64,
    from_corner: f64,
}

/// What TCP and elbow do per s at a place of a curve in joint space.
fn rates(point: &QuinticPoint, tool: &Pose, corner: &Pose, arm: &PlanningContext) -> PointRates {
    let frames = arm.model.forward(&JointPositions(point.q));
    let at = (frames.base_from_flange * *tool).translation;
    let rates = JointSpeeds(point.dq_ds);
    PointRates {
        tcp: frames.twist(&rates, at).linear.norm(),
        elbow: elbow_speed(&frames, &rates),
        from_corner: (at - corner.translation).norm(),
    }
}

/// The fastest that the TCP may go on a curve, m/s, and a joint turn, rad/s.
#[derive(Clone, Copy)]
struct SpeedCaps {
    tcp: f64,
    turning: f64,
}

/// A parabola through three places rises over its ends by an eighth of their second difference.
fn peak(a: f64, b: f64, c: f64) -> f64 {
    a.max(b).max(c) + (a - 2.0 * b + c).abs() / 8.0
}

/// The largest derivatives between two places of a curve, and the largest first one of any joint.
fn bounds_between(left: &QuinticPoint, right: &QuinticPoint, step: f64) -> (DerivativeBounds, f64) {
    let mut bounds = DerivativeBounds::NONE;
    // Between two places a value exceeds both by no more than a parabola's height.
    let rise = step * step / 8.0;
    let mut turning = 0.0_f64;
    for joint in 0..6 {
        for point in [left, right] {
            let fourth = point.d4q_ds4[joint].abs();
            let first = point.dq_ds[joint].abs() + rise * point.d3q_ds3[joint].abs();
            turning = turning.max(first);
            bounds.dq_ds[joint] = bounds.dq_ds[joint].max(first);
            let second = point.d2q_ds2[joint].abs() + rise * fourth;
            bounds.d2q_ds2[joint] = bounds.d2q_ds2[joint].max(second);
            let third = point.d3q_ds3[joint].abs() + 0.5 * step * fourth;
            bounds.d3q_ds3[joint] = bounds.d3q_ds3[joint].max(third);
        }
    }
    (bounds, turning)
}

/// A turn between two neighbouring places, rad, beyond which it is another branch of solutions.
const JUMP: f64 = 0.5;

fn elbow_at(point: &PathPoint, arm: &PlanningContext) -> f64 {
    elbow_speed(&arm.model.forward(&point.q), &JointSpeeds(point.dq_ds))
}

fn is_in_range(q: &[f64; 6], arm: &PlanningContext) -> bool {
    (0..6).all(|joint| {
        let range = arm.limits.position_min[joint]..=arm.limits.position_max[joint];
        range.contains(&q[joint])
    })
}

/// The path's point at a place near its end.
fn point_from_end(path: &Path, model: &RobotModel, s: f64) -> Option<PathPoint> {
    step_to(path, model, path.length(), &path.end_setpoint().q, s)
}

/// The path's point at `s`, found by stepping from its beginning at `q`.
fn point_at(path: &Path, model: &RobotModel, q: &JointPositions, s: f64) -> Option<PathPoint> {
    step_to(path, model, 0.0, q, s)
}

/// `None` also where even small steps go over into another branch of solutions.
fn step_to(
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
