//! A program that is debugged: who holds it, and what a program that stands still can be asked and told.
//!
//! The debugger lives on the thread of the task and hears of every statement and of every cycle before it passes; while it
//! takes its time, nothing moves and no time passes under the virtual clock. Owns the border only: what is held, and why,
//! is decided by whoever attaches.

use std::rc::Rc;

use elite_lang::debug::{Aside, Halt, Watcher};
use motion_api::{RobotState, ThreadNumber};

use crate::task::{TaskContext, TaskEnd};

/// The number under which an evaluation runs that waits for something.
pub const CONSOLE_THREAD: ThreadNumber = ThreadNumber(u32::MAX);

/// Attaches a debugger to a task.
pub trait DebugLink: Send + Sync {
    /// On the thread of the task, before its program begins.
    fn attach(&self, task: Debuggee) -> Rc<dyn Attached>;
}

/// A debugger on the thread of a task.
pub trait Attached: Watcher {
    /// A cycle is about to pass: every script thread waits.
    fn before_cycle(&self, halt: &Halt<'_>);

    /// The program is over, and nothing of it has been taken apart yet.
    fn before_end(&self, halt: &Halt<'_>, end: &TaskEnd);

    /// A script thread has ended.
    fn thread_ended(&self, number: ThreadNumber);

    /// The program is to end without running any more of it.
    fn is_over(&self) -> bool;
}

/// The task of a program that is debugged.
#[derive(Clone)]
pub struct Debuggee(pub(crate) Rc<TaskContext>);

impl Debuggee {
    /// The robot after the latest cycle.
    pub fn state(&self) -> RobotState {
        self.0.robot().state()
    }

    /// The number of the latest cycle.
    pub fn cycle(&self) -> u64 {
        self.0.robot().moment().cycle
    }

    /// The number of the script thread that runs.
    pub fn thread(&self) -> ThreadNumber {
        self.0.running_thread()
    }

    /// Runs `look`, in which builtins that move the arm or wait are refused as in a secondary program.
    pub fn without_motion<T>(&self, look: impl FnOnce() -> T) -> T {
        self.0.as_secondary(look)
    }

    /// Drives an evaluation that waits, beside the program, until it ends.
    pub fn adopt(&self, aside: Aside) {
        self.0.adopt(aside);
    }
}
