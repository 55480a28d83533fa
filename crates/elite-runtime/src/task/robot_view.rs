//! The robot as a task sees it. Under the real clock that is the robot of one cycle for a whole turn: what happens
//! while a slice of a thread runs is seen in the next one, so that when something was seen is known exactly. Under the
//! virtual clock nothing happens in between.

use std::cell::RefCell;
use std::ops::Deref;
use std::sync::Arc;

use motion_api::{CommandId, CycleTime, IoImage, RobotState, StopReason};

use crate::predicted_state::PredictedState;
use crate::robot::Robot;

/// The robot as one task sees it: under the real clock, as it was in one cycle, for a whole turn.
pub(crate) struct RobotView {
    robot: Arc<Robot>,
    /// The state of the cycle that this turn sees; `None` under the virtual clock, where nothing changes within a turn.
    seen: RefCell<Option<Box<RobotState>>>,
}

impl Deref for RobotView {
    type Target = Arc<Robot>;

    fn deref(&self) -> &Arc<Robot> {
        &self.robot
    }
}

impl RobotView {
    pub fn new(robot: Arc<Robot>) -> Self {
        let seen = (!robot.timeline().is_virtual()).then(|| Box::new(robot.published_state()));
        Self {
            robot,
            seen: RefCell::new(seen),
        }
    }

    /// A new turn: what has happened meanwhile is seen.
    pub fn look(&self) {
        if let Some(seen) = &mut *self.seen.borrow_mut()
            && self.robot.told_cycle() != seen.cycle
        {
            **seen = self.robot.published_state();
        }
    }

    /// The state that is seen.
    pub fn state(&self) -> RobotState {
        let seen = self.seen.borrow();
        seen.as_ref()
            .map_or_else(|| self.robot.state(), |state| **state)
    }

    /// The latest cycle of the robot, which may be later than the one that programs see.
    pub fn latest(&self) -> CycleTime {
        self.robot.moment()
    }

    /// The time of the cycle that this turn sees.
    pub fn moment(&self) -> CycleTime {
        let seen = self.seen.borrow();
        let of = |state: &RobotState| CycleTime::of(state);
        seen.as_ref()
            .map_or_else(|| self.robot.moment(), |state| of(state))
    }

    /// Inputs and outputs in this turn, with the task's own changes ([`Robot::io`]).
    pub fn io(&self) -> IoImage {
        match &*self.seen.borrow() {
            Some(state) => self.robot.io_after(state),
            None => self.robot.io(),
        }
    }

    /// The state with the settings of commands that still wait ([`Robot::foreseen`]).
    pub fn foreseen(&self) -> PredictedState {
        match &*self.seen.borrow() {
            Some(state) => self.robot.foreseen_after(state),
            None => self.robot.foreseen(),
        }
    }

    /// True when a requested command has ended ([`Robot::has_ended`]).
    pub fn has_ended(&self, id: CommandId) -> bool {
        match &*self.seen.borrow() {
            Some(state) => self.robot.has_ended_by(id, state.cycle),
            None => self.robot.has_ended(id),
        }
    }

    /// True when the next motion may follow this one ([`Robot::accepts_next_motion`]).
    pub fn may_be_followed(&self, id: CommandId) -> bool {
        match &*self.seen.borrow() {
            Some(state) => self.robot.accepted_next_motion_by(id, state.cycle),
            None => self.robot.accepts_next_motion(id),
        }
    }

    /// True when the motion after this one is due ([`Robot::is_next_due`]).
    pub fn is_next_due(&self, id: CommandId) -> bool {
        match &*self.seen.borrow() {
            Some(state) => self.robot.is_next_due_by(id, state.cycle),
            None => self.robot.is_next_due(id),
        }
    }

    /// The number of protective stops, and the reason of the last one ([`Robot::protective_stops`]).
    pub fn protective_stops(&self) -> (u64, Option<StopReason>) {
        match &*self.seen.borrow() {
            Some(state) => self.robot.protective_stops_by(state.cycle),
            None => self.robot.protective_stops(),
        }
    }
}
