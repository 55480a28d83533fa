//! One motion under way: a path, the travel along it, and the command it belongs to.

use kinematics::{JointPositions, RobotModel};
use motion_api::{CommandId, MotionMode};

use crate::path::Path;
use crate::scalar::{Course, Drive, Travel};
use crate::setpoint::Setpoint;

/// A planned motion, ready to be started.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// Where.
    pub path: Path,
    /// How fast.
    pub course: Course,
}

/// A motion under way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion {
    pub(crate) id: CommandId,
    pub(crate) mode: MotionMode,
    path: Path,
    travel: Travel,
    /// A stop was asked for; the motion ends where it comes to rest.
    pub(crate) is_stopping: bool,
}

impl Motion {
    pub(crate) fn new(id: CommandId, mode: MotionMode, plan: &Plan) -> Self {
        Self {
            id,
            mode,
            path: plan.path,
            travel: Travel::new(plan.course, Drive::Halt),
            is_stopping: false,
        }
    }

    /// The setpoint one cycle later, at a fraction of the planned speed; 0 brakes. `None` when the path is lost.
    pub(crate) fn next(
        &mut self,
        step: f64,
        fraction: f64,
        model: &RobotModel,
        near: &JointPositions,
    ) -> Option<Setpoint> {
        self.travel.drive(if fraction > 0.0 && !self.is_stopping {
            Drive::Go(fraction)
        } else {
            Drive::Halt
        });
        let s = self.travel.advance(step);
        if self.travel.is_finished() {
            return Some(self.path.end());
        }
        self.path.at(model, &s, near)
    }

    /// Where the path ends.
    pub(crate) fn end(&self) -> JointPositions {
        self.path.end().q
    }

    /// True when the end of the path is reached.
    pub(crate) fn is_finished(&self) -> bool {
        self.travel.is_finished()
    }

    /// True when nothing moves: at the end, or halted on the way.
    pub(crate) fn is_standing(&self) -> bool {
        self.travel.is_standing()
    }

    /// The speed fraction in effect.
    pub(crate) fn fraction(&self) -> f64 {
        self.travel.fraction()
    }
}
