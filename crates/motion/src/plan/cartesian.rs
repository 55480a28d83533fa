//! movel and movec: a line or an arc of the TCP, as fast as it is asked to go and the joints are able to at each place.
//!
//! The way is surveyed first, over several cycles if need be. Where all of it bears the wanted speed, one set of limits
//! holds from end to end; otherwise it is walked at a pace (see `pace`), unless even limits are as fast.

use kinematics::{JointPositions, Pose, RpyPose};
use motion_api::{Refusal, Warning};

use super::able::Able;
use super::leg::{Leg, NO_COURSE, with_duration};
use super::pace::PacePlanner;
use super::parts::Part;
use super::survey::Survey;
use super::{Arm, Warnings, Wish};
use crate::constants::{LINE_PLACES_PER_CYCLE, PACE_ATTEMPTS_PER_CYCLE};
use crate::path::{ArcOrientation, CartesianPath, Geometry, Path};
use crate::scalar::{Course, ScalarLimits};

/// Limits within this factor of one another, or of what is wanted, count as the same.
const SAME: f64 = 1.0 - 1e-9;

/// A movel or movec that is being planned.
#[derive(Clone, Copy, Debug)]
pub struct CartesianPlanner {
    survey: Option<Survey>,
    pacing: Option<Pacing>,
    path: CartesianPath,
    wish: Wish,
}

/// A surveyed line whose pace is being made.
#[derive(Clone, Copy, Debug)]
struct Pacing {
    planner: PacePlanner,
    /// The course with the same limits from end to end.
    even: Course,
}

impl CartesianPlanner {
    /// Begins to plan a movel (manual 3.1.3) from rest at `start` to the TCP pose `target`.
    ///
    /// Speed and acceleration of `wish` are the TCP's, m/s and m/s²; where the rotation is the larger part of the motion
    /// they are those of s, see [`CartesianPath`].
    ///
    /// # Errors
    /// A number that cannot be used, or an arm in a singular position.
    pub fn line(
        start: &JointPositions,
        target: &RpyPose,
        wish: &Wish,
        arm: &Arm,
    ) -> Result<Self, Refusal> {
        wish.check()?;
        check_finite(target)?;
        let flange_from_tcp = *arm.flange_from_tcp;
        let base_from_tcp = arm.model.tcp_pose(start, &flange_from_tcp);
        let end = Pose::from_rpy(target);
        let line = CartesianPath::line(base_from_tcp, end, flange_from_tcp, *start);
        Self::new(line, start, wish, arm)
    }

    /// Begins to plan a movec (manual 3.1.2) from rest at `start` through the position of `via` to the TCP pose `target`.
    ///
    /// # Errors
    /// As [`line`](Self::line), and [`Refusal::NoArc`] when the three positions do not make an arc.
    pub fn arc(
        start: &JointPositions,
        (via, target): (&RpyPose, &RpyPose),
        orientation: ArcOrientation,
        wish: &Wish,
        arm: &Arm,
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
        wish: &Wish,
        arm: &Arm,
    ) -> Result<Self, Refusal> {
        let fastest = if wish.duration > 0.0 {
            f64::INFINITY
        } else {
            wish.speed
        };
        let survey = if path.length() > 0.0 {
            Some(Survey::new(path, *start, fastest, arm.model)?)
        } else {
            None
        };
        Ok(Self {
            survey,
            pacing: None,
            path,
            wish: *wish,
        })
    }

    /// Works on the plan for one cycle; `None` while there is more to look at.
    ///
    /// # Errors
    /// Where and why the line cannot be followed.
    pub fn work(&mut self, arm: &Arm) -> Result<Option<(Leg, Warnings)>, Refusal> {
        let Some(survey) = &mut self.survey else {
            let any = ScalarLimits {
                speed: 1.0,
                acceleration: 1.0,
                jerk: 1.0,
            };
            let course = Course::of_one(0.0, any);
            return self.leg(Path::new(Geometry::Cartesian(self.path)), course, arm);
        };
        if let Some(pacing) = &mut self.pacing {
            let parts = survey.parts();
            let attempt = |_| pacing.planner.work(parts, &self.wish, arm);
            let Some(made) = (0..PACE_ATTEMPTS_PER_CYCLE).find_map(attempt) else {
                return Ok(None);
            };
            let even = pacing.even;
            let path = Path::new(Geometry::Cartesian(survey.line()));
            return match made {
                Some((pace, course)) if course.duration() < even.duration() => {
                    self.leg(path.paced(pace), Some(course), arm)
                }
                _ => self.leg(path, Some(even), arm),
            };
        }
        if !survey.walk(LINE_PLACES_PER_CYCLE, arm)? {
            return Ok(None);
        }
        let able = survey
            .parts()
            .iter()
            .map(|part| Able::of(&part.bounds, arm.limits));
        let (mut slowest, mut fastest) = (f64::INFINITY, 0.0_f64);
        let mut least = ScalarLimits {
            speed: f64::INFINITY,
            acceleration: f64::INFINITY,
            jerk: f64::INFINITY,
        };
        for able in able {
            let limits = able.at(&self.wish);
            slowest = slowest.min(limits.speed);
            fastest = fastest.max(limits.speed);
            least = ScalarLimits {
                speed: least.speed.min(limits.speed),
                acceleration: least.acceleration.min(limits.acceleration),
                jerk: least.jerk.min(limits.jerk),
            };
        }
        let path = Path::new(Geometry::Cartesian(survey.line()));
        let Some(even) = Course::of_one(self.path.length(), least) else {
            return Err(Refusal::Planner { code: NO_COURSE });
        };
        let is_in_time = self.wish.duration > 0.0 && even.duration() <= self.wish.duration;
        if is_in_time || slowest >= fastest * SAME {
            return self.leg(path, Some(even), arm);
        }
        let planner = PacePlanner::new(survey.parts(), fastest, &self.wish, arm);
        self.pacing = Some(Pacing { planner, even });
        Ok(None)
    }

    fn leg(
        &self,
        path: Path,
        course: Option<Course>,
        arm: &Arm,
    ) -> Result<Option<(Leg, Warnings)>, Refusal> {
        let mut warnings = Warnings::default();
        if let Some(survey) = &self.survey {
            warn(survey.parts(), &self.path, &self.wish, arm, &mut warnings);
        }
        let course = course.ok_or(Refusal::Planner { code: NO_COURSE })?;
        let course = with_duration(course, self.wish.duration, &mut warnings);
        let leg = Leg::new(path, course, &self.wish, arm, &mut warnings);
        Ok(Some((leg, warnings)))
    }
}

/// Warns when the line is slower than asked for.
fn warn(parts: &[Part], line: &CartesianPath, wish: &Wish, arm: &Arm, warnings: &mut Warnings) {
    if wish.duration > 0.0 {
        return;
    }
    let limits = parts
        .iter()
        .map(|part| Able::of(&part.bounds, arm.limits).at(wish));
    let unlimited = wish.within(&ScalarLimits {
        speed: f64::INFINITY,
        acceleration: f64::INFINITY,
        jerk: f64::INFINITY,
    });
    // A line too short to reach the speed misses nothing.
    let reached = (line.length() * unlimited.acceleration).sqrt();
    let speed = limits.clone().fold(f64::INFINITY, |m, l| m.min(l.speed));
    if speed < wish.speed.min(reached) * SAME {
        warnings.add(Warning::SpeedLimited {
            wanted: wish.speed,
            planned: speed,
        });
    }
    let acceleration = limits.fold(f64::INFINITY, |m, l| m.min(l.acceleration));
    if acceleration < wish.acceleration * SAME {
        warnings.add(Warning::AccelerationLimited {
            wanted: wish.acceleration,
            planned: acceleration,
        });
    }
}

fn check_finite(pose: &RpyPose) -> Result<(), Refusal> {
    match pose.to_array().into_iter().find(|x| !x.is_finite()) {
        None => Ok(()),
        Some(value) => Err(Refusal::BadValue {
            name: "a component of the pose",
            value,
            needed: "a finite number",
        }),
    }
}
