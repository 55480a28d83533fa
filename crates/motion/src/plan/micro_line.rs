//! moveml: through the points of a list at its own times, slower where the joints cannot keep up.
//!
//! Interval by interval the curve's derivatives are bounded, a fixed number of intervals a cycle; then the way is walked
//! evenly in its own time or, where that is too fast somewhere, at a pace (see `pace`).

use kinematics::{JointPositions, JointSpeeds};
use motion_api::{PathFault, Refusal, Warning};

use super::able::{Able, PartBounds};
use super::leg::{Leg, NO_COURSE};
use super::pace::PacePlanner;
use super::parts::Parts;
use super::{Arm, Warnings, Wish};
use crate::constants::{
    LINE_PARTS, MICRO_INTERVALS_PER_CYCLE, MICRO_PLACES_PER_INTERVAL, PACE_ATTEMPTS_PER_CYCLE,
};
use crate::path::{Geometry, JointQuintic, MicroLine, Path};
use crate::scalar::{Course, ScalarLimits};
use crate::setpoint::elbow_speed;

/// A second of the list in a second; no other acceleration than what the joints can do.
const WISH: Wish = Wish {
    speed: 1.0,
    acceleration: f64::MAX,
    duration: 0.0,
    radius: 0.0,
};
/// A duration that is longer by this factor is worth a warning; starting and stopping take their time.
const LONGER: f64 = 1.05;
/// See [`LONGER`], s.
const START_AND_STOP: f64 = 1.0;

/// A moveml that is being planned.
#[derive(Clone, Copy, Debug)]
pub struct MicroLinePlanner {
    line: MicroLine,
    parts: Parts,
    /// Intervals looked at.
    done: usize,
    pacing: Option<(PacePlanner, Course)>,
}

impl MicroLinePlanner {
    /// Begins to plan the way through points whose first is where the arm stands.
    pub fn new(line: MicroLine) -> Self {
        Self {
            line,
            parts: Parts::new(WISH.speed),
            done: 0,
            pacing: None,
        }
    }

    /// Works on the plan for one cycle; `None` while there is more to look at.
    ///
    /// # Errors
    /// A point, or the way between two, outside of a joint's range.
    pub fn work(
        &mut self,
        points: &[JointPositions],
        arm: &Arm,
    ) -> Result<Option<(Leg, Warnings)>, Refusal> {
        if let Some((planner, even)) = &mut self.pacing {
            let even = *even;
            let parts = self.parts.as_slice();
            let attempt = |_| planner.work(parts, &WISH, arm);
            let Some(made) = (0..PACE_ATTEMPTS_PER_CYCLE).find_map(attempt) else {
                return Ok(None);
            };
            let path = Path::new(Geometry::Micro(self.line));
            return Ok(Some(match made {
                Some((pace, course)) if course.duration() < even.duration() => {
                    self.leg(path.paced(pace), course, arm)
                }
                _ => self.leg(path, even, arm),
            }));
        }
        for _ in 0..MICRO_INTERVALS_PER_CYCLE {
            if self.done < self.line.intervals() {
                self.look(points, arm)?;
            }
        }
        if self.done < self.line.intervals() {
            return Ok(None);
        }
        let mut least = ScalarLimits {
            speed: f64::INFINITY,
            acceleration: f64::INFINITY,
            jerk: f64::INFINITY,
        };
        for part in self.parts.as_slice() {
            let limits = Able::of(&part.bounds, arm.limits).at(&WISH);
            least = ScalarLimits {
                speed: least.speed.min(limits.speed),
                acceleration: least.acceleration.min(limits.acceleration),
                jerk: least.jerk.min(limits.jerk),
            };
        }
        // Where no joint turns anything is possible.
        let least = ScalarLimits {
            acceleration: least.acceleration.min(FASTEST),
            jerk: least.jerk.min(FASTEST),
            ..least
        };
        let even = Course::of_one(self.line.length(), least);
        let even = even.ok_or(Refusal::Planner { code: NO_COURSE })?;
        if least.speed >= WISH.speed {
            let path = Path::new(Geometry::Micro(self.line));
            return Ok(Some(self.leg(path, even, arm)));
        }
        let planner = PacePlanner::new(self.parts.as_slice(), WISH.speed, &WISH, arm);
        self.pacing = Some((planner, even));
        Ok(None)
    }

    /// Bounds one interval.
    fn look(&mut self, points: &[JointPositions], arm: &Arm) -> Result<(), Refusal> {
        let number = self.done;
        let curve = self.line.curve(points, number);
        let curve = curve.ok_or(Refusal::Planner { code: NO_COURSE })?;
        let bounds = bounds_of(&curve, arm).map_err(|fault| Refusal::Path {
            fraction: number as f64 / self.line.intervals() as f64,
            fault,
        })?;
        self.done += 1;
        let equal = |k: usize| k * LINE_PARTS / self.line.intervals();
        let begins = number == 0 || equal(number) != equal(number - 1);
        let until = self.done as f64 * self.line.interval();
        self.parts
            .add(until, &bounds, (equal(number), begins), arm.limits);
        Ok(())
    }

    fn leg(&self, path: Path, course: Course, arm: &Arm) -> (Leg, Warnings) {
        let mut warnings = Warnings::default();
        let (wanted, planned) = (self.line.length(), course.duration());
        if planned > LONGER * wanted + START_AND_STOP {
            warnings.add(Warning::DurationStretched { wanted, planned });
        }
        let leg = Leg::new(path, course, &WISH, arm, &mut warnings);
        (leg, warnings)
    }
}

/// Limits of s on a way on which nothing limits them, 1/s² and 1/s³.
const FASTEST: f64 = 1e3;

/// The largest derivatives on a curve.
fn bounds_of(curve: &JointQuintic, arm: &Arm) -> Result<PartBounds, PathFault> {
    let mut bounds = PartBounds::NONE;
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
            let fourth = point.fourth[joint].abs();
            let first = point.first[joint].abs() + rise * point.third[joint].abs();
            bounds.first[joint] = bounds.first[joint].max(first);
            bounds.second[joint] =
                bounds.second[joint].max(point.second[joint].abs() + rise * fourth);
            bounds.third[joint] =
                bounds.third[joint].max(point.third[joint].abs() + 0.5 * step * fourth);
        }
        let q = JointPositions(point.q);
        let frames = arm.model.forward(&q);
        let rates = JointSpeeds(point.first);
        let tcp = (frames.base_from_flange * *arm.flange_from_tcp).translation;
        bounds.tcp = bounds
            .tcp
            .max(frames.twist(&rates, tcp).linear.norm() / crate::constants::POINT_SPEED_MARGIN);
        bounds.elbow = bounds.elbow.max(elbow_speed(&frames, &rates));
        bounds.torque.cover(&q, &point.first, &point.second, arm);
    }
    Ok(bounds)
}
