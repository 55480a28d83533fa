//! movel: a straight line of the TCP, as fast as it is asked to go and the joints are able to at each place.
//!
//! The line is surveyed first, over several cycles if need be; then each part of it gets the limits of s under which no
//! joint exceeds its own, and no drive its torque (see `torque`): with q' q'' q''' the derivatives of a joint with respect to s and V, A, J the limits of s
//!     |q'| V <= speed,  |q''| V² + |q'| A <= acceleration,  |q'''| V³ + 3 |q''| V A + |q'| J <= jerk.

use kinematics::{JointPositions, Pose, RpyPose};
use motion_api::{Refusal, Warning};

use super::movej::{NO_COURSE, with_duration};
use super::survey::{PartBounds, Survey};
use super::{Arm, Warnings, Wish};
use crate::config::MotionLimits;
use crate::constants::{
    LINE_PARTS, LINE_PLACES_PER_CYCLE, POINT_SPEED_MARGIN, TORQUE_SHARE_OF_SPEED,
};
use crate::motion::Plan;
use crate::path::{CartesianLine, Path};
use crate::scalar::{Course, ScalarLimits, Stretch};

/// Parts of the joints' limits kept for each term of the sums above, so that none uses up the others' share.
const ACCELERATION_SHARE_OF_SPEED: f64 = 0.5;
const JERK_SHARE_OF_SPEED: f64 = 0.25;
const JERK_SHARE_OF_ACCELERATION: f64 = 0.4;

/// A part whose limits are within this factor of what is wanted counts as unlimited.
const SAME: f64 = 1.0 - 1e-9;

/// A movel that is being planned.
#[derive(Clone, Copy, Debug)]
pub struct LinePlanner {
    survey: Option<Survey>,
    line: CartesianLine,
    wish: Wish,
}

impl LinePlanner {
    /// Begins to plan a movel (manual 3.1.3) from rest at `start` to the TCP pose `target`.
    ///
    /// Speed and acceleration of `wish` are the TCP's, m/s and m/s²; where the rotation is the larger part of the motion
    /// they are those of s, see [`CartesianLine`].
    ///
    /// # Errors
    /// A number that cannot be used, or an arm in a singular position.
    pub fn new(
        start: &JointPositions,
        target: &RpyPose,
        wish: &Wish,
        arm: &Arm,
    ) -> Result<Self, Refusal> {
        wish.check()?;
        if let Some(value) = target.to_array().into_iter().find(|x| !x.is_finite()) {
            return Err(Refusal::BadValue {
                name: "a component of the pose",
                value,
                needed: "a finite number",
            });
        }
        let flange_from_tcp = *arm.flange_from_tcp;
        let base_from_tcp = arm.model.tcp_pose(start, &flange_from_tcp);
        let end = Pose::from_rpy(target);
        let line = CartesianLine::new(base_from_tcp, end, flange_from_tcp, *start);
        let survey = if line.length() > 0.0 {
            Some(Survey::new(line, *start, arm.model)?)
        } else {
            None
        };
        Ok(Self {
            survey,
            line,
            wish: *wish,
        })
    }

    /// Works on the plan for one cycle; `None` while there is more to look at.
    ///
    /// # Errors
    /// Where and why the line cannot be followed.
    pub fn work(&mut self, arm: &Arm) -> Result<Option<(Plan, Warnings)>, Refusal> {
        let mut warnings = Warnings::default();
        let (line, course) = match &mut self.survey {
            None => {
                let any = ScalarLimits {
                    speed: 1.0,
                    acceleration: 1.0,
                    jerk: 1.0,
                };
                (self.line, Course::of_one(0.0, any))
            }
            Some(survey) => {
                if !survey.walk(LINE_PLACES_PER_CYCLE, arm)? {
                    return Ok(None);
                }
                let line = survey.line();
                let parts = survey.parts().map(|part| able(&part, &line, arm.limits));
                let course = course(&line, &parts, &self.wish);
                warn(&parts, &line, &self.wish, &mut warnings);
                (line, course)
            }
        };
        let course = course.ok_or(Refusal::Planner { code: NO_COURSE })?;
        let course = with_duration(course, self.wish.duration, &mut warnings);
        let path = Path::Cartesian(line);
        Ok(Some((Plan { path, course }, warnings)))
    }
}

/// What a part of the line bears at most, per wanted speed: see [`Able::at`].
#[derive(Clone, Copy, Debug)]
struct Able {
    bounds: PartBounds,
    limits: MotionLimits,
    /// Largest speed of s.
    speed: f64,
}

fn able(part: &PartBounds, line: &CartesianLine, limits: &MotionLimits) -> Able {
    let mut speed = (limits.tcp_speed / line.tcp_distance_per_s())
        .min(POINT_SPEED_MARGIN * limits.elbow_speed / part.elbow)
        .min(part.torque.speed_limit(TORQUE_SHARE_OF_SPEED));
    for joint in 0..6 {
        let (d1, d2, d3) = (part.first[joint], part.second[joint], part.third[joint]);
        speed = speed
            .min(limits.speed[joint] / d1)
            .min((ACCELERATION_SHARE_OF_SPEED * limits.acceleration[joint] / d2).sqrt())
            .min((JERK_SHARE_OF_SPEED * limits.jerk[joint] / d3).cbrt());
    }
    Able {
        bounds: *part,
        limits: *limits,
        speed,
    }
}

impl Able {
    /// The limits of s for a wish.
    fn at(&self, wish: &Wish) -> ScalarLimits {
        let speed = if wish.duration > 0.0 {
            self.speed
        } else {
            self.speed.min(wish.speed)
        };
        let mut acceleration = self.bounds.torque.acceleration_limit(speed);
        for joint in 0..6 {
            let (d1, d2) = (self.bounds.first[joint], self.bounds.second[joint]);
            let left = self.limits.acceleration[joint] - d2 * speed * speed;
            acceleration = acceleration
                .min(left / d1)
                .min(JERK_SHARE_OF_ACCELERATION * self.limits.jerk[joint] / (3.0 * d2 * speed));
        }
        let wanted = wish.within(&ScalarLimits {
            speed,
            acceleration,
            jerk: f64::INFINITY,
        });
        let mut jerk = wanted.jerk;
        for joint in 0..6 {
            let (d1, d2, d3) = (
                self.bounds.first[joint],
                self.bounds.second[joint],
                self.bounds.third[joint],
            );
            let left = self.limits.jerk[joint]
                - d3 * speed * speed * speed
                - 3.0 * d2 * speed * wanted.acceleration;
            jerk = jerk.min(left / d1);
        }
        ScalarLimits { jerk, ..wanted }
    }
}

/// The course along the line: the same limits all the way, or, if that is faster, limits of their own for each part.
fn course(line: &CartesianLine, parts: &[Able; LINE_PARTS], wish: &Wish) -> Option<Course> {
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
fn warn(parts: &[Able; LINE_PARTS], line: &CartesianLine, wish: &Wish, warnings: &mut Warnings) {
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
