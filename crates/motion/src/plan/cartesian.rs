//! movel and movec: a line or an arc of the TCP, as fast as it is asked to go and the joints are able to at each place.
//!
//! The way is surveyed first, over several cycles if need be; then each part of it gets limits of its own (see `able`).

use kinematics::{JointPositions, Pose, RpyPose};
use motion_api::{Refusal, Warning};

use super::able::Able;
use super::leg::{Leg, NO_COURSE, with_duration};
use super::survey::Survey;
use super::{Arm, Warnings, Wish};
use crate::constants::{LINE_PARTS, LINE_PLACES_PER_CYCLE};
use crate::path::{ArcOrientation, CartesianPath, Path};
use crate::scalar::{Course, ScalarLimits, Stretch};

/// A part whose limits are within this factor of what is wanted counts as unlimited.
const SAME: f64 = 1.0 - 1e-9;

/// A movel or movec that is being planned.
#[derive(Clone, Copy, Debug)]
pub struct CartesianPlanner {
    survey: Option<Survey>,
    path: CartesianPath,
    wish: Wish,
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
        let survey = if path.length() > 0.0 {
            Some(Survey::new(path, *start, arm.model)?)
        } else {
            None
        };
        Ok(Self {
            survey,
            path,
            wish: *wish,
        })
    }

    /// Works on the plan for one cycle; `None` while there is more to look at.
    ///
    /// # Errors
    /// Where and why the line cannot be followed.
    pub fn work(&mut self, arm: &Arm) -> Result<Option<(Leg, Warnings)>, Refusal> {
        let mut warnings = Warnings::default();
        let (line, course) = match &mut self.survey {
            None => {
                let any = ScalarLimits {
                    speed: 1.0,
                    acceleration: 1.0,
                    jerk: 1.0,
                };
                (self.path, Course::of_one(0.0, any))
            }
            Some(survey) => {
                if !survey.walk(LINE_PLACES_PER_CYCLE, arm)? {
                    return Ok(None);
                }
                let line = survey.line();
                let tcp_per_s = line.tcp_distance_per_s();
                let parts = survey
                    .parts()
                    .map(|part| Able::of(&part, tcp_per_s, arm.limits));
                let course = course(&line, &parts, &self.wish);
                warn(&parts, &line, &self.wish, &mut warnings);
                (line, course)
            }
        };
        let course = course.ok_or(Refusal::Planner { code: NO_COURSE })?;
        let course = with_duration(course, self.wish.duration, &mut warnings);
        let path = Path::Cartesian(line);
        let leg = Leg::new(path, course, &self.wish, arm, &mut warnings);
        Ok(Some((leg, warnings)))
    }
}

/// The course along the line: the same limits all the way, or, if that is faster, limits of their own for each part.
fn course(line: &CartesianPath, parts: &[Able; LINE_PARTS], wish: &Wish) -> Option<Course> {
    let limits = parts.map(|part| part.at(wish));
    let least = limits
        .iter()
        .skip(1)
        .fold(*limits.first()?, |m, l| ScalarLimits {
            speed: m.speed.min(l.speed),
            acceleration: m.acceleration.min(l.acceleration),
            jerk: m.jerk.min(l.jerk),
        });
    let even = Course::of_one(line.length(), least)?;
    if wish.duration > 0.0 && even.duration() <= wish.duration {
        return Some(even);
    }
    let length = line.length() / LINE_PARTS as f64;
    let mut stretches = [Stretch::new(0.0, least); LINE_PARTS];
    let mut count = 0usize;
    for part in limits {
        // Neighbours with the same limits are one stretch: at the joints of stretches the acceleration is zero.
        if let Some(last) = count.checked_sub(1).and_then(|k| stretches.get_mut(k))
            && last.limits == part
        {
            last.length += length;
        } else if let Some(next) = stretches.get_mut(count) {
            *next = Stretch::new(length, part);
            count += 1;
        }
    }
    let uneven = Course::new(stretches.get(..count)?)?;
    Some(if uneven.duration() < even.duration() {
        uneven
    } else {
        even
    })
}

/// Warns when the line is slower than asked for.
fn warn(parts: &[Able; LINE_PARTS], line: &CartesianPath, wish: &Wish, warnings: &mut Warnings) {
    if wish.duration > 0.0 {
        return;
    }
    let limits = parts.map(|part| part.at(wish));
    let unlimited = wish.within(&ScalarLimits {
        speed: f64::INFINITY,
        acceleration: f64::INFINITY,
        jerk: f64::INFINITY,
    });
    // A line too short to reach the speed misses nothing.
    let reached = (line.length() * unlimited.acceleration).sqrt();
    let speed = limits.iter().fold(f64::INFINITY, |m, l| m.min(l.speed));
    if speed < wish.speed.min(reached) * SAME {
        warnings.add(Warning::SpeedLimited {
            wanted: wish.speed,
            planned: speed,
        });
    }
    let acceleration = limits
        .iter()
        .fold(f64::INFINITY, |m, l| m.min(l.acceleration));
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
