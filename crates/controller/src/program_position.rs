//! What a program does while cycles pass, for conditions that name `program`, `line` or `command`.
//!
//! Follows one program at a time, told by the observer that has it; judges nothing.

use std::sync::{Arc, OnceLock, Weak};

use elite_runtime::Robot;
use motion_api::{CommandId, RobotState, ThreadNumber};
use parking_lot::Mutex;

/// What a script was doing in a cycle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProgramPosition {
    /// Name of the program, empty without one.
    pub program: String,
    /// Line of its main thread, 0 without one.
    pub line: u32,
    /// Name of the running command, empty without one.
    pub command: String,
}

/// Follows what a program does.
#[derive(Default)]
pub struct PositionTracker {
    followed: Mutex<(ProgramPosition, CommandId)>,
    /// Knows commands by their numbers.
    robot: OnceLock<Weak<Robot>>,
}

impl PositionTracker {
    /// Says whose commands they are, once.
    pub fn connect(&self, robot: &Arc<Robot>) {
        let _ = self.robot.set(Arc::downgrade(robot));
    }

    /// A program begins.
    pub fn program_started(&self, name: &str) {
        let doing = &mut self.followed.lock().0;
        name.clone_into(&mut doing.program);
        doing.line = 0;
    }

    /// The program is over.
    pub fn program_ended(&self) {
        self.program_started("");
    }

    /// A thread has come to a line.
    pub fn line_changed(&self, thread: ThreadNumber, line: u32) {
        if thread == ThreadNumber(0) {
            self.followed.lock().0.line = line;
        }
    }

    /// A cycle has passed.
    pub fn cycle_ended(&self, state: &RobotState) {
        let mut followed = self.followed.lock();
        let (doing, last) = &mut *followed;
        if *last == state.command_id {
            return;
        }
        *last = state.command_id;
        let robot = self.robot.get().and_then(Weak::upgrade);
        let name = robot.and_then(|robot| robot.command_name(state.command_id));
        name.unwrap_or_default().clone_into(&mut doing.command);
    }

    /// What it does now.
    pub fn position(&self) -> ProgramPosition {
        self.followed.lock().0.clone()
    }

    /// Has `f` look at what it does now.
    pub fn with_position<T>(&self, f: impl FnOnce(&ProgramPosition) -> T) -> T {
        f(&self.followed.lock().0)
    }
}
