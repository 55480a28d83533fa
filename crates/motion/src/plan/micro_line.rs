//! moveml: through the points of a list at its own times, slower where the joints cannot keep up.
//!
//! Interval by interval the curve's derivatives are bounded, a fixed number of intervals a cycle. Where the points are
//! poses the way of the TCP is surveyed as a line is.

use kinematics::{JointPositions, JointSpeeds};
use motion_api::{PathFault, Refusal};

use super::able::DerivativeBounds;
use super::survey::PathScan;
use super::{MotionRequest, MotionSegment, PlanningContext, SegmentLimits, Warnings};
use crate::constants::{
    MAX_INTERVALS_PER_SEGMENT, MICRO_INTERVALS_PER_CYCLE, MICRO_PLACES_PER_INTERVAL,
    PATH_SAMPLES_PER_CYCLE,
};
use crate::path::{JointQuintic, MicroLine, Path, PointValues};
use crate::self_collision::SelfCollisionMonitor;
use crate::setpoint::elbow_speed;

/// A second of the list in a second; no other acceleration than what the joints can do.
const WISH: MotionRequest = MotionRequest {
    speed: 1.0,
    acceleration: f64::MAX,
    duration: 0.0,
    radius: 0.0,
    is_process_move: false,
};

/// Planner error: the points are not those of the line.
const PLANNER_POINTS_MISMATCH: u32 = 1;

/// A moveml that is being planned.
#[derive(Clone, Copy, Debug)]
pub struct MicroLinePlanner {
    line: MicroLine,
    /// Intervals looked at.
    done: usize,
    /// What the intervals since the last cell ask for.
    bounds: DerivativeBounds,
    /// The survey of a way of the TCP; joints need none.
    survey: Option<PathScan>,
    watch: Option<SelfCollisionMonitor>,
}

impl MicroLinePlanner {
    /// Begins to plan the way through points whose first is where the arm stands.
    ///
    /// # Errors
    /// A way of the TCP that begins in a singular position.
    pub fn new(
        line: MicroLine,
        points: &[PointValues],
        arm: &PlanningContext,
    ) -> Result<Self, Refusal> {
        let survey = match line.tcp_path(points) {
            Some(way) => Some(PathScan::new(&way, line.start(), arm)?),
            None => None,
        };
        Ok(Self {
            line,
            done: 0,
            bounds: DerivativeBounds::NONE,
            survey,
            watch: None,
        })
    }

    /// Works on the plan for one cycle; `None` while there is more to look at.
    ///
    /// # Errors
    /// A point, or the way between two, outside of a joint's range or where the arm runs into itself; where and why a
    /// way of the TCP cannot be followed.
    pub fn advance(
        &mut self,
        points: &[PointValues],
        arm: &PlanningContext,
        cells: &mut SegmentLimits,
    ) -> Result<Option<(MotionSegment, Warnings)>, Refusal> {
        let mut warnings = Warnings::default();
        if let Some(survey) = &mut self.survey {
            let way = self.line.tcp_path(points);
            let way = way.ok_or(Refusal::Planner {
                code: PLANNER_POINTS_MISMATCH,
            })?;
            if !survey.advance(&way, PATH_SAMPLES_PER_CYCLE, &WISH, arm, cells)? {
                return Ok(None);
            }
            let path = Path::MicroLine(self.line.ending_at(survey.last_joint_positions()));
            return Ok(Some((
                MotionSegment::new(path, &WISH, arm, &mut warnings),
                warnings,
            )));
        }
        if self.done == 0 {
            cells.clear();
        }
        for _ in 0..MICRO_INTERVALS_PER_CYCLE {
            if self.done < self.line.intervals() {
                self.bound_interval(points, arm, cells)?;
            }
        }
        if self.done < self.line.intervals() {
            return Ok(None);
        }
        let leg = MotionSegment::new(Path::MicroLine(self.line), &WISH, arm, &mut warnings);
        Ok(Some((leg, warnings)))
    }

    /// Bounds one interval.
    fn bound_interval(
        &mut self,
        points: &[PointValues],
        arm: &PlanningContext,
        cells: &mut SegmentLimits,
    ) -> Result<(), Refusal> {
        let number = self.done;
        let curve = self.line.curve(points, number);
        let curve = curve.ok_or(Refusal::Planner {
            code: PLANNER_POINTS_MISMATCH,
        })?;
        let begin = JointPositions(curve.point(0.0).q);
        let allowed = arm.limits.link_overlap;
        let watch = self
            .watch
            .get_or_insert_with(|| SelfCollisionMonitor::starting_at(arm.model, allowed, &begin));
        let bounds = bounds_of(&curve, arm, watch).map_err(|fault| Refusal::Path {
            fraction: number as f64 / self.line.intervals() as f64,
            fault,
        })?;
        self.done += 1;
        self.bounds.merge(&bounds);
        let group = self.line.intervals().div_ceil(MAX_INTERVALS_PER_SEGMENT);
        if self.done.is_multiple_of(group) || self.done == self.line.intervals() {
            let until = self.done as f64 * self.line.interval();
            cells.push(until, self.bounds.interval_limits(&WISH, arm.limits));
            self.bounds = DerivativeBounds::NONE;
        }
        Ok(())
    }
}

/// The largest derivatives on a curve.
fn bounds_of(
    curve: &JointQuintic,
    arm: &PlanningContext,
    watch: &mut SelfCollisionMonitor,
) -> Result<DerivativeBounds, PathFault> {
    let mut bounds = DerivativeBounds::NONE;
    let step = curve.length() / MICRO_PLACES_PER_INTERVAL as f64;
    let rise = step * step / 8.0;
    for place in 0..=MICRO_PLACES_PER_INTERVAL {
        let point = curve.point(step * place as f64);
        for (joint, number) in (0u8..6).enumerate() {
            let (min, max) = (
                arm.limits.position_min[joint],
                arm.limits.position_max[joint],
            );
            let value = point.q[joint];
            if !(min..=max).contains(&value) {
                return Err(PathFault::JointLimit {
                    joint: number,
                    value,
                    min,
                    max,
                });
            }
            // Between two places a value exceeds both by no more than a parabola's height.
            let fourth = point.d4q_ds4[joint].abs();
            let first = point.dq_ds[joint].abs() + rise * point.d3q_ds3[joint].abs();
            bounds.dq_ds[joint] = bounds.dq_ds[joint].max(first);
            bounds.d2q_ds2[joint] =
                bounds.d2q_ds2[joint].max(point.d2q_ds2[joint].abs() + rise * fourth);
            bounds.d3q_ds3[joint] =
                bounds.d3q_ds3[joint].max(point.d3q_ds3[joint].abs() + 0.5 * step * fourth);
        }
        let q = JointPositions(point.q);
        if let Some(found) = watch.check(&q, arm.model) {
            return Err(found.into());
        }
        let frames = arm.model.forward(&q);
        let rates = JointSpeeds(point.dq_ds);
        let tcp = (frames.base_from_flange * *arm.flange_from_tcp).translation;
        bounds.tcp = bounds
            .tcp
            .max(frames.twist(&rates, tcp).linear.norm() / crate::constants::POINT_SPEED_MARGIN);
        bounds.elbow = bounds.elbow.max(elbow_speed(&frames, &rates));
        bounds.torque.cover(&q, &point.dq_ds, &point.d2q_ds2, arm);
    }
    Ok(bounds)
}
