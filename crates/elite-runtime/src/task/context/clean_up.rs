//! What `finally` and `with` blocks of a program that is being stopped may still do.

use std::cell::Cell;

use super::TaskContext;
use crate::external::ExternalInputKind;
use messages::text;

/// Calls of builtins in the `finally` and `with` blocks of a task that is being stopped. The language bounds what its
/// own work costs there; a call may cost far more than one step of that.
const CALLS_OF_UNWINDING: u32 = 20 * CALLS_PER_SAMPLE - 1;
/// What `finally` and `with` blocks of a stopped program may compute, in seconds of the real clock.
const CLEAN_UP: f64 = 0.5;
/// Length of a clean-up where no time passes: looks, each after 4096 steps, which take about 0.3 ms.
const LOOKS_OF_CLEAN_UP: u32 = 1500;
/// Calls of builtins during a clean-up that see the robot of one cycle, as all calls within a turn of a thread do.
const CALLS_PER_SAMPLE: u32 = 256;

/// What is left of the calls and of the time of a clean-up.
pub(super) struct CleanUp {
    /// Calls of builtins that threads may still make while they unwind; `None` while nothing was told to stop.
    calls_left: Cell<Option<u32>>,
    /// Looks at the clock that are left, for a clean-up during which no time passes.
    looks_left: Cell<u32>,
    /// Time of the robot at which the clean-up ends, s; `None` where no time is measured.
    until: Cell<Option<f64>>,
}

impl Default for CleanUp {
    fn default() -> Self {
        Self {
            calls_left: Cell::default(),
            looks_left: Cell::new(LOOKS_OF_CLEAN_UP),
            until: Cell::default(),
        }
    }
}

impl TaskContext {
    /// Said by the scheduler when all threads of the task are about to unwind.
    pub fn begin_unwinding(&self) {
        self.clean_up.calls_left.set(Some(CALLS_OF_UNWINDING));
        self.clean_up_begins();
    }

    /// Said when a single thread unwinds: what it may compute counts from here, unless the whole task does.
    pub fn thread_unwinds(&self) {
        if self.clean_up.calls_left.get().is_none() {
            self.clean_up_begins();
        }
    }

    fn clean_up_begins(&self) {
        self.clean_up.looks_left.set(LOOKS_OF_CLEAN_UP);
        // Simulated time does not pass meanwhile, and a run that is repeated ends where it did.
        let is_measured = self.repeat().is_none() && !self.robot.timeline().is_virtual();
        let until = || self.robot.latest().time + CLEAN_UP;
        self.clean_up.until.set(is_measured.then(until));
    }

    /// Whether a task that unwinds may call no more builtins.
    pub fn has_called_enough(&self) -> bool {
        self.clean_up.calls_left.get() == Some(0)
    }

    /// Whether `finally` and `with` blocks of a stopped program may compute on; asked every few thousand steps of
    /// theirs.
    pub fn may_clean_up(&self) -> bool {
        let left = self.clean_up.looks_left.get();
        self.clean_up.looks_left.set(left.saturating_sub(1));
        let is_late = |until| self.robot.latest().time >= until;
        left > 0 && !self.clean_up.until.get().is_some_and(is_late)
    }

    /// Counts a call of a builtin; false when a task that unwinds may make no more.
    pub fn count_call(&self) -> bool {
        match self.clean_up.calls_left.get() {
            None => true,
            Some(left) => {
                let left_then = left.saturating_sub(1);
                self.clean_up.calls_left.set(Some(left_then));
                if left_then > 0 && left_then.is_multiple_of(CALLS_PER_SAMPLE) {
                    self.robot.look();
                    let text = text!(
                        "clean-up behind a stop called very many functions",
                        "停止后的清理调用的函数过多"
                    );
                    self.note(ExternalInputKind::Unrecorded(text));
                }
                left > 0
            }
        }
    }
}
