//! A way through many points at even times (manual 3.1.40), in a list that is too long to be copied.
//!
//! s is the time of the list in seconds. A point has joint positions, or a position of the TCP and a quaternion.
//! Between two points each of these numbers follows the polynomial of degree five that has, at both, the speed and
//! acceleration that the neighbours of the point give by central differences; so the way goes through every point, goes
//! on smoothly with two derivatives, and a change of one point changes four intervals only. Of a quaternion only the
//! direction counts, so the tool turns as smoothly.

use kinematics::{JointPositions, Pose, RobotModel};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::cartesian::{PathTwist, derivatives, setpoint_at};
use super::quintic::{Quintic, QuinticEnd};
use super::{JointQuintic, PathPoint, TcpPath};
use crate::constants::MIN_DISTANCE;
use crate::scalar::ScalarState;
use crate::setpoint::Setpoint;

pub use motion_api::points::PointValues;

/// Places in an interval of a way of the TCP at which it is looked at before it is followed.
const LOOKS_PER_INTERVAL: usize = 4;

/// The point before an end, `q`, of which the next two are known: the way goes on bent as it is there.
fn extrapolated_neighbor(
    q: &PointValues,
    next: &PointValues,
    third: Option<&PointValues>,
) -> PointValues {
    core::array::from_fn(|k| match third {
        Some(third) => 3.0 * (q[k] - next[k]) + third[k],
        None => 2.0 * q[k] - next[k],
    })
}

/// A way through the first points of a list that its owner keeps.
#[derive(Clone, Copy, Debug)]
pub struct MicroLine {
    start: JointPositions,
    end: JointPositions,
    /// The point where the way begins, in place of the first point of the list.
    first: PointValues,
    /// Number of points, at least 2.
    count: usize,
    /// Time from point to point, s.
    interval: f64,
    /// The TCP that the points are poses of; `None`: they are joint positions.
    flange_from_tcp: Option<Pose>,
}

impl MicroLine {
    /// The way of the joints through all of `points`; `None` when there are fewer than two.
    pub fn through_joint_positions(points: &[PointValues], interval: f64) -> Option<Self> {
        let joints = |[a, b, c, d, e, f, _]: PointValues| JointPositions([a, b, c, d, e, f]);
        let (start, end) = (joints(*points.first()?), joints(*points.last()?));
        Self::new(points, interval, (start, end), None)
    }

    /// The way of the TCP through all of `points`, from where the joints are at `start`; `None` when there are fewer
    /// than two. Where the joints end is known once it has been followed: see [`ending_at`](Self::ending_at).
    pub fn through_tcp_poses(
        points: &[PointValues],
        interval: f64,
        start: JointPositions,
        flange_from_tcp: Pose,
    ) -> Option<Self> {
        Self::new(points, interval, (start, start), Some(flange_from_tcp))
    }

    fn new(
        points: &[PointValues],
        interval: f64,
        (start, end): (JointPositions, JointPositions),
        flange_from_tcp: Option<Pose>,
    ) -> Option<Self> {
        let first = *points.first()?;
        let is_way = points.len() >= 2 && interval > MIN_DISTANCE && interval.is_finite();
        is_way.then_some(Self {
            start,
            end,
            first,
            count: points.len(),
            interval,
            flange_from_tcp,
        })
    }

    /// The way with the joint positions at its end.
    #[must_use]
    pub fn ending_at(self, end: JointPositions) -> Self {
        Self { end, ..self }
    }

    /// The way with another first point, at which the joints are at `start`.
    #[must_use]
    pub fn beginning_at(self, first: PointValues, start: JointPositions) -> Self {
        Self {
            first,
            start,
            ..self
        }
    }

    /// The point where the way begins.
    pub fn first(&self) -> PointValues {
        self.first
    }

    /// Number of intervals between points.
    pub fn intervals(&self) -> usize {
        self.count - 1
    }

    /// Time from point to point, s.
    pub fn interval(&self) -> f64 {
        self.interval
    }

    /// Time of the list, s.
    pub fn length(&self) -> f64 {
        self.intervals() as f64 * self.interval
    }

    /// The joints where the way begins, rad.
    pub fn start(&self) -> JointPositions {
        self.start
    }

    /// The joints where the way ends, rad.
    pub fn end(&self) -> JointPositions {
        self.end
    }

    /// The way of the TCP, where the points are poses of it.
    pub fn tcp_path<'a>(&'a self, points: &'a [PointValues]) -> Option<MicroLineTcpPath<'a>> {
        let flange_from_tcp = self.flange_from_tcp.as_ref()?;
        let is_all = points.len() >= self.count;
        is_all.then_some(MicroLineTcpPath {
            line: self,
            points,
            flange_from_tcp,
        })
    }

    /// The curve of the joints from point `k` to the next; `None` when `points` are not those it was made for.
    pub fn curve(&self, points: &[PointValues], k: usize) -> Option<JointQuintic> {
        let joints = |end: QuinticEnd<7>| {
            let six = |[a, b, c, d, e, f, _]: PointValues| [a, b, c, d, e, f];
            QuinticEnd {
                q: six(end.q),
                first: six(end.first),
                second: six(end.second),
            }
        };
        let (from, to) = (self.point(points, k)?, self.point(points, k + 1)?);
        Some(JointQuintic::new(&joints(from), &joints(to), self.interval))
    }

    /// The setpoint at a state of s, in the branch of solutions that `near` belongs to.
    pub fn at(
        &self,
        model: &RobotModel,
        points: &[PointValues],
        s: &ScalarState,
        near: &JointPositions,
    ) -> Option<Setpoint> {
        if self.flange_from_tcp.is_some() {
            let way = self.tcp_path(points)?;
            let q = way.positions(model, s.position, near)?;
            return setpoint_at(&way.point(model, s.position, q)?, s);
        }
        let (k, position) = self.place(s.position);
        let inside = ScalarState { position, ..*s };
        Some(self.curve(points, k)?.at(&inside))
    }

    /// The interval in which s lies, and where.
    fn place(&self, s: f64) -> (usize, f64) {
        let k = ((s / self.interval).max(0.0) as usize).min(self.intervals() - 1);
        (k, s - k as f64 * self.interval)
    }

    /// A point with its derivatives.
    fn point(&self, points: &[PointValues], k: usize) -> Option<QuinticEnd<7>> {
        let h = self.interval;
        let points = points.get(..self.count)?;
        let sample = |k: usize| match k {
            0 => Some(&self.first),
            _ => points.get(k),
        };
        let q = *sample(k)?;
        let before = match k.checked_sub(1) {
            Some(k) => *sample(k)?,
            None => extrapolated_neighbor(&q, sample(1)?, sample(2)),
        };
        let after = match sample(k + 1) {
            Some(after) => *after,
            None => extrapolated_neighbor(&q, &before, k.checked_sub(2).and_then(sample)),
        };
        Some(QuinticEnd {
            q,
            first: core::array::from_fn(|k| (after[k] - before[k]) / (2.0 * h)),
            second: core::array::from_fn(|k| (after[k] - 2.0 * q[k] + before[k]) / (h * h)),
        })
    }
}

/// The way of the TCP through many points.
#[derive(Clone, Copy)]
pub struct MicroLineTcpPath<'a> {
    line: &'a MicroLine,
    points: &'a [PointValues],
    flange_from_tcp: &'a Pose,
}

/// The way's numbers at one place, apart.
struct PoseDerivatives {
    position: [Vector3<f64>; 3],
    turn: [Quaternion<f64>; 3],
}

impl MicroLineTcpPath<'_> {
    /// Position and quaternion with their first two derivatives.
    fn pose_derivatives(&self, s: f64) -> Option<PoseDerivatives> {
        let (k, inside) = self.line.place(s);
        let from = self.line.point(self.points, k)?;
        let to = self.line.point(self.points, k + 1)?;
        let point = Quintic::new(&from, &to, self.line.interval).point(inside);
        let both = [point.q, point.dq_ds, point.d2q_ds2];
        Some(PoseDerivatives {
            position: both.map(|[x, y, z, ..]| Vector3::new(x, y, z)),
            turn: both.map(|[.., w, i, j, k]| Quaternion::new(w, i, j, k)),
        })
    }
}

impl TcpPath for MicroLineTcpPath<'_> {
    fn length(&self) -> f64 {
        self.line.length()
    }

    fn intervals(&self) -> usize {
        LOOKS_PER_INTERVAL * self.line.intervals()
    }

    fn flange_from_tcp(&self) -> &Pose {
        self.flange_from_tcp
    }

    fn pose(&self, s: f64) -> Pose {
        let Some(apart) = self.pose_derivatives(s) else {
            return Pose::IDENTITY;
        };
        let turn = UnitQuaternion::new_normalize(apart.turn[0]);
        Pose::new(turn.to_rotation_matrix(), apart.position[0])
    }

    fn point(&self, model: &RobotModel, s: f64, q: JointPositions) -> Option<PathPoint> {
        let PoseDerivatives { position, turn } = self.pose_derivatives(s)?;
        // With u = t / |t|: angular velocity 2 Im(u' u*), and Im(t' t*) is |t|² of that because t' t* differs by a real
        // number.
        let squared = turn[0].norm_squared();
        let first = turn[1] * turn[0].conjugate() / squared;
        let second = turn[2] * turn[0].conjugate() / squared;
        let angular = 2.0 * first.imag();
        let bent = PathTwist {
            linear: position[1],
            linear_rate: position[2],
            angular,
            angular_rate: 2.0 * second.imag() - 2.0 * first.scalar() * angular,
        };
        derivatives(model, self.flange_from_tcp, s, q, |_| bent)
    }

    fn tcp_speed_factor(&self, s: f64) -> f64 {
        self.pose_derivatives(s)
            .map_or(0.0, |apart| apart.position[1].norm())
    }
}
