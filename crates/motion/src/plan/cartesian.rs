//! movel, movec and movep: a line or an arc of the TCP, as fast as it is asked to go and the joints are able to at each
//! place.
//!
//! The way is surveyed first, over several cycles if need be.

use kinematics::{JointPositions, Pose, RpyPose};
use motion_api::{PathFault, Refusal, Warning, WayUnit, phrase};

use super::direction::Direction;
use super::survey::PathScan;
use super::{MotionRequest, MotionSegment, PlanningContext, SegmentLimits, Warnings};
use crate::constants::PATH_SAMPLES_PER_CYCLE;
use crate::path::{ArcOrientation, CartesianPath, Path, TcpPath};

/// Limits within this factor of one another, or of what is wanted, count as the same.
const SAME: f64 = 1.0 - 1e-9;

/// A line or an arc that is being planned.
#[derive(Clone, Copy, Debug)]
pub struct CartesianPlanner {
    survey: Option<PathScan>,
    path: CartesianPath,
    wish: MotionRequest,
    /// The target only says where to go.
    direction: Option<Direction>,
}

impl CartesianPlanner {
    /// Begins to plan a line (manual 3.1.3) from `start` to the TCP pose `target`.
    ///
    /// Speed and acceleration of `wish` are the TCP's, m/s and m/s²; where the rotation is the larger part of the
    /// motion they are those of s, see [`CartesianPath`].
    ///
    /// # Errors
    /// A number that cannot be used, or an arm in a singular position.
    pub fn line(
        start: &JointPositions,
        target: &RpyPose,
        wish: &MotionRequest,
        arm: &PlanningContext,
    ) -> Result<Self, Refusal> {
        wish.check()?;
        check_finite(target)?;
        let flange_from_tcp = *arm.flange_from_tcp;
        let base_from_tcp = arm.model.tcp_pose(start, &flange_from_tcp);
        let end = Pose::from_rpy(target);
        let mut wish = *wish;
        let direction = Direction::of(&base_from_tcp, &end, start, &mut wish, arm)?;
        let (direction, end) = direction.map_or((None, end), |(to, end)| (Some(to), end));
        let line = CartesianPath::line(base_from_tcp, end, flange_from_tcp, *start);
        let mut planner = Self::new(line, start, &wish, arm)?;
        if let (Some(survey), Some(to)) = (&mut planner.survey, direction) {
            *survey = survey.towards(to);
        }
        Ok(Self {
            direction,
            ..planner
        })
    }

    /// Begins to plan a movec (manual 3.1.2) from `start` through the position of `via` to the TCP pose `target`.
    ///
    /// # Errors
    /// The errors of [`line`](Self::line), and [`Refusal::NoArc`] when the three positions do not make an arc.
    pub fn arc(
        start: &JointPositions,
        (via, target): (&RpyPose, &RpyPose),
        orientation: ArcOrientation,
        wish: &MotionRequest,
        arm: &PlanningContext,
    ) -> Result<Self, Refusal> {
        wish.check()?;
        check_finite(via)?;
        check_finite(target)?;
        let flange_from_tcp = *arm.flange_from_tcp;
        let base_from_tcp = arm.model.tcp_pose(start, &flange_from_tcp);
        let arc = CartesianPath::arc(
            base_from_tcp,
            Pose::from_rpy(via).translation,
            Pose::from_rpy(target),
            orientation,
            flange_from_tcp,
            *start,
        );
        Self::new(arc.map_err(|_| Refusal::NoArc)?, start, wish, arm)
    }

    fn new(
        path: CartesianPath,
        start: &JointPositions,
        wish: &MotionRequest,
        arm: &PlanningContext,
    ) -> Result<Self, Refusal> {
        let survey = if path.length() > 0.0 {
            Some(PathScan::new(&path, *start, arm)?)
        } else {
            None
        };
        Ok(Self {
            survey,
            path,
            wish: *wish,
            direction: None,
        })
    }

    /// Works on the plan for one cycle; `None` while there is more to look at. The leg's cells are in `cells` then.
    ///
    /// # Errors
    /// Where and why the line cannot be followed.
    pub fn advance(
        &mut self,
        arm: &PlanningContext,
        cells: &mut SegmentLimits,
    ) -> Result<Option<(MotionSegment, Warnings)>, Refusal> {
        let mut warnings = Warnings::default();
        let Some(survey) = &mut self.survey else {
            cells.clear();
            let path = Path::Cartesian(self.path);
            let leg = MotionSegment::new(path, &self.wish, arm, &mut warnings);
            return Ok(Some((leg, warnings)));
        };
        let mut path = self.path;
        let walked = survey.advance(&path, PATH_SAMPLES_PER_CYCLE, &self.wish, arm, cells);
        let beyond = match (walked, self.direction) {
            (Ok(false), _) => return Ok(None),
            (Ok(true), None) => None,
            (Err(refusal), None) => return Err(refusal),
            (walked, Some(direction)) => {
                direction.warn(&mut warnings);
                let reached = survey.end_here(&self.wish, arm, cells);
                let slow = direction.slowest(&self.wish);
                let end = cells.end_before_slow(slow).unwrap_or(reached);
                let q = path.positions(arm.model, end, &survey.last_joint_positions());
                path = path.until(end, q.unwrap_or(survey.last_joint_positions()));
                let fault = PathFault::OutOfReach;
                let fraction = 1.0;
                let refusal = walked.err().unwrap_or(Refusal::Path { fraction, fault });
                Some(direction.end(end, refusal)?)
            }
        };
        if beyond.is_none() {
            path = path.ending_at(survey.last_joint_positions());
            warn(cells, path.length(), &self.wish, &mut warnings);
        }
        let leg = MotionSegment::new(Path::Cartesian(path), &self.wish, arm, &mut warnings);
        Ok(Some((MotionSegment { beyond, ..leg }, warnings)))
    }
}

/// Warns when the line is slower than asked for.
fn warn(cells: &SegmentLimits, length: f64, wish: &MotionRequest, warnings: &mut Warnings) {
    if wish.duration > 0.0 {
        return;
    }
    let (speed, acceleration) = cells.min_speed_and_acceleration();
    // A line too short to reach the speed misses nothing.
    let reached = (length * wish.acceleration).sqrt();
    if speed < wish.speed.min(reached) * SAME {
        warnings.add(Warning::SpeedLimited {
            wanted: wish.speed,
            planned: speed,
            unit: WayUnit::Metre,
        });
    }
    if acceleration < wish.acceleration * SAME {
        warnings.add(Warning::AccelerationLimited {
            wanted: wish.acceleration,
            planned: acceleration,
            unit: WayUnit::Metre,
        });
    }
}

fn check_finite(pose: &RpyPose) -> Result<(), Refusal> {
    match pose.to_array().into_iter().find(|x| !x.is_finite()) {
        None => Ok(()),
        Some(value) => Err(Refusal::BadValue {
            name: phrase!("a component of the pose", "位姿的分量"),
            value,
            needed: phrase!("a finite number", "有限的数"),
        }),
    }
}
