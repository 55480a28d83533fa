//! A program that is debugged: who holds it, and what a program that stands still can be asked and told.
//!
//! The debugger lives on the thread of the task and hears of every statement and of every cycle before it passes; while
//! it takes its time, nothing moves and no time passes under the virtual clock. Owns the border only: what is held, and
//! why, is decided by whoever attaches.

use std::rc::Rc;

use elite_lang::debug::{DebugHook, PausedProgram, PendingEval};
use messages::text;
use motion_api::{ProgramId, RobotState, ThreadNumber};

use crate::external::ExternalInputKind;
use crate::task::{TaskContext, TaskEnd};

/// The number under which an evaluation runs that waits for something.
pub const CONSOLE_THREAD: ThreadNumber = ThreadNumber(u32::MAX);

/// Attaches a debugger to a task.
pub trait DebuggerHost: Send + Sync {
    /// A program is about to start.
    fn begins(&self, _program: ProgramId, _name: &str, _text: &str) {}

    /// A program has ended.
    fn ended(&self, _program: ProgramId) {}

    /// On the thread of the task, before its program begins; `None`: nobody watches this one.
    fn attach(&self, task: DebuggedTask) -> Option<Rc<dyn TaskDebugger>>;
}

/// A debugger on the thread of a task.
pub trait TaskDebugger: DebugHook {
    /// A cycle is about to pass: every script thread waits.
    fn before_cycle(&self, halt: &PausedProgram<'_>);

    /// The program is over, and nothing of it has been taken apart yet.
    fn before_end(&self, halt: &PausedProgram<'_>, end: &TaskEnd);

    /// The task has looked round, and no script thread runs. Only where time passes by itself, or the task is held.
    fn between_turns(&self, _halt: &PausedProgram<'_>) {}

    /// Whether a program is held without the task standing still: orders of ports are heard, the arm halts on its path
    /// as for any pause, and only the thread that is held has its turns, in which it is asked again.
    fn suspend_state(&self) -> SuspendState {
        SuspendState::Nothing
    }

    /// A script thread has ended.
    fn thread_ended(&self, number: ThreadNumber);

    /// The program is to end without running any more of it.
    fn is_over(&self) -> bool;
}

/// What a debugger holds, see [`TaskDebugger::suspend_state`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SuspendState {
    /// Nothing.
    Nothing,
    /// The program, within whatever its threads wait for.
    Program,
    /// The program, before a statement of this thread.
    At(ThreadNumber),
}

/// The task of a program that is debugged.
#[derive(Clone)]
pub struct DebuggedTask(pub(crate) Rc<TaskContext>);

impl DebuggedTask {
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
        self.0.unrecorded(|| self.0.with_inspection_bounds(look))
    }

    /// The number of the program that is debugged.
    pub fn program(&self) -> ProgramId {
        self.0.program()
    }

    /// The run is repeated from a recording.
    pub fn is_rerun(&self) -> bool {
        self.0.repeat().is_some()
    }

    /// Says that a debugger has changed something: from here on the run cannot be repeated from its recording.
    pub fn mark_modified(&self) {
        self.0.note(ExternalInputKind::Unrecorded(text!(
            "a debugger has changed something",
            "调试器更改了内容"
        )));
    }

    /// Drives an evaluation that waits, beside the program, until it ends.
    pub fn adopt(&self, aside: PendingEval) {
        self.0.adopt(aside);
    }
}
