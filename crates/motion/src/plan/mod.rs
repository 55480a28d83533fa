//! From a motion command to a path and a course along it: what is asked, cut down to what the arm can do.
//!
//! Planning runs inside the cycle that takes the command, and the next ones if it is much: bounded work, no allocation.

mod able;
mod cartesian;
mod cells;
mod corner;
mod direction;
mod junction;
mod leg;
mod micro_line;
mod movej;
mod survey;
mod torque;

pub use able::DerivativeBounds;
pub use cartesian::CartesianPlanner;
pub use cells::SegmentLimits;
pub use junction::{BlendKind, BlendSearch, PlannedBlend};
pub use leg::{DistanceMeasure, MotionSegment, SegmentEnd};
pub use micro_line::MicroLinePlanner;
pub use movej::plan_movej;

use kinematics::safety::{PlaneSwitches, SafetyBounds};
use kinematics::{Dynamics, Pose, RobotModel};
use motion_api::{Refusal, Warning, phrase};

use crate::config::MotionLimits;
use crate::constants::{MAX_DURATION, MIN_REQUESTED_RATE};

/// Most warnings of one plan.
const MAX_WARNINGS: usize = 4;

/// The warnings of one plan.
#[derive(Clone, Copy, Debug, Default)]
pub struct Warnings {
    list: [Option<Warning>; MAX_WARNINGS],
}

impl Warnings {
    /// Adds a warning while there is room.
    pub fn add(&mut self, warning: Warning) {
        if let Some(free) = self.list.iter_mut().find(|w| w.is_none()) {
            *free = Some(warning);
        }
    }

    /// The warnings in the order in which they were found.
    pub fn iter(&self) -> impl Iterator<Item = Warning> + '_ {
        self.list.iter().flatten().copied()
    }
}

/// The arm that a motion is planned for.
#[derive(Clone, Copy)]
pub struct PlanningContext<'a> {
    /// Geometry.
    pub model: &'a RobotModel,
    /// The active TCP.
    pub flange_from_tcp: &'a Pose,
    /// What the joints may do.
    pub limits: &'a MotionLimits,
    /// The arm's masses with its payload.
    pub dynamics: &'a Dynamics,
    /// The safety planes, and which of them count.
    pub planes: Option<(&'a SafetyBounds, PlaneSwitches)>,
}

/// How fast a motion is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionRequest {
    /// Speed along s.
    pub speed: f64,
    /// Acceleration along s.
    pub acceleration: f64,
    /// Duration, s; 0 when speed and acceleration count.
    pub duration: f64,
    /// Blend radius, m; 0 stops at the end.
    pub radius: f64,
    /// The blend is an arc that touches at the radius.
    pub is_process_move: bool,
}

impl MotionRequest {
    /// Checks that the numbers that count can be used.
    ///
    /// # Errors
    /// [`Refusal::BadValue`] names the first that cannot.
    pub fn check(&self) -> Result<(), Refusal> {
        let bad = |name, value, needed| {
            Err(Refusal::BadValue {
                name,
                value,
                needed,
            })
        };
        if !(0.0..=MAX_DURATION).contains(&self.duration) {
            return bad(
                phrase!("t"),
                self.duration,
                phrase!(
                    "0 or a number of seconds up to 1000000",
                    "0 或不超过 1000000 的秒数"
                ),
            );
        }
        if !(self.radius >= 0.0 && self.radius.is_finite()) {
            return bad(
                phrase!("r"),
                self.radius,
                phrase!("a number of at least 0", "不小于 0 的数"),
            );
        }
        if self.duration > 0.0 {
            return Ok(());
        }
        if !(self.acceleration >= MIN_REQUESTED_RATE && self.acceleration.is_finite()) {
            return bad(
                phrase!("a"),
                self.acceleration,
                phrase!("a number of at least 0.000001", "不小于 0.000001 的数"),
            );
        }
        if !(self.speed >= MIN_REQUESTED_RATE && self.speed.is_finite()) {
            return bad(
                phrase!("v"),
                self.speed,
                phrase!("a number of at least 0.000001", "不小于 0.000001 的数"),
            );
        }
        Ok(())
    }
}
