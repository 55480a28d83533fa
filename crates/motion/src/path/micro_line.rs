//! A way through many points at even times (manual 3.1.40): joint positions in a list that is too long to be copied.
//!
//! s is the time of the list in seconds. Between two points each joint follows the polynomial of degree five that has, at
//! both, the speed and acceleration that the neighbours of the point give by central differences; so the way goes through
//! every point, goes on smoothly with two derivatives, and a change of one point changes four intervals only.

use kinematics::JointPositions;

use super::{JointQuintic, PathPoint};
use crate::constants::NO_MOTION;
use crate::scalar::ScalarState;
use crate::setpoint::Setpoint;

/// The point before an end, `q`, of which the next two are known: the way goes on bent as it is there.
fn beyond(
    q: &JointPositions,
    next: &JointPositions,
    third: Option<&JointPositions>,
) -> JointPositions {
    JointPositions(core::array::from_fn(|joint| match third {
        Some(third) => 3.0 * (q[joint] - next[joint]) + third[joint],
        None => 2.0 * q[joint] - next[joint],
    }))
}

/// A way through the first points of a list that its owner keeps.
#[derive(Clone, Copy, Debug)]
pub struct MicroLine {
    start: JointPositions,
    end: JointPositions,
    /// Number of points, at least 2.
    count: usize,
    /// Time from point to point, s.
    interval: f64,
}

impl MicroLine {
    /// The way through all of `points`; `None` when there are fewer than two.
    pub fn new(points: &[JointPositions], interval: f64) -> Option<Self> {
        let is_way = points.len() >= 2 && interval > NO_MOTION && interval.is_finite();
        is_way.then_some(())?;
        Some(Self {
            start: *points.first()?,
            end: *points.last()?,
            count: points.len(),
            interval,
        })
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

    /// Where it begins.
    pub fn start(&self) -> JointPositions {
        self.start
    }

    /// Where it ends.
    pub fn end(&self) -> JointPositions {
        self.end
    }

    /// The curve from point `k` to the next; `None` when `points` are not those it was made for.
    pub fn curve(&self, points: &[JointPositions], k: usize) -> Option<JointQuintic> {
        let (from, to) = (self.point(points, k)?, self.point(points, k + 1)?);
        Some(JointQuintic::between(&from, &to, self.interval))
    }

    /// The setpoint at a state of s.
    pub fn at(&self, points: &[JointPositions], s: &ScalarState) -> Option<Setpoint> {
        let place = (s.position / self.interval).max(0.0);
        let k = (place as usize).min(self.intervals() - 1);
        let inside = ScalarState {
            position: s.position - k as f64 * self.interval,
            ..*s
        };
        Some(self.curve(points, k)?.at(&inside))
    }

    /// A point with its derivatives.
    fn point(&self, points: &[JointPositions], k: usize) -> Option<PathPoint> {
        let h = self.interval;
        let points = points.get(..self.count)?;
        let q = *points.get(k)?;
        let before = match k.checked_sub(1) {
            Some(k) => *points.get(k)?,
            None => beyond(&q, points.get(1)?, points.get(2)),
        };
        let after = match points.get(k + 1) {
            Some(after) => *after,
            None => beyond(&q, &before, k.checked_sub(2).and_then(|k| points.get(k))),
        };
        Some(PathPoint {
            s: k as f64 * h,
            q,
            first: core::array::from_fn(|joint| (after[joint] - before[joint]) / (2.0 * h)),
            second: core::array::from_fn(|joint| {
                (after[joint] - 2.0 * q[joint] + before[joint]) / (h * h)
            }),
        })
    }
}
