//! A program beside the one that the arm runs: a test of that program. It has the builtins of every program, and one
//! object more whose methods its starter provides.
//!
//! It does not count as the program of the robot: outputs that follow the run state ignore it, and a protective stop,
//! which ends the other one, is something for it to look at. Owns no methods and no turns: whose turn it is in a cycle
//! is decided by the timeline.

use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use elite_lang::{NativeCall, NativeFunction, Unwind};

use crate::task::{TaskContext, Wait};

/// Makes the methods of the object, on the thread of the task.
pub type MethodFactory = dyn Fn(&TestTaskHandle) -> Vec<NativeFunction> + Send + Sync;

/// Does what others wait for while the program itself waits; false where nobody ever waits for it.
pub type WaitHook = dyn Fn(&mut NativeCall<'_>) -> Result<bool, Unwind>;

/// What such a program gets.
#[derive(Clone)]
pub struct TestTaskConfig {
    /// The name by which the program calls the object; `None` where there is none.
    pub object: Option<&'static str>,
    /// The methods of the object.
    pub methods: Arc<MethodFactory>,
    /// True while the program beside this one has something to do.
    pub has_company: Arc<AtomicBool>,
}

/// The task of such a program, for the methods of its object.
#[derive(Clone)]
pub struct TestTaskHandle(pub(crate) Rc<TaskContext>);

impl TestTaskHandle {
    /// Lets `answering` be called in every cycle in which a builtin of the program waits for time or for somebody else:
    /// that may be somebody whom the program plays itself.
    pub fn set_wait_hook(&self, answering: Rc<WaitHook>) {
        self.0.set_answering(answering);
    }

    /// Suspends the calling thread until the cycle with this number has begun.
    ///
    /// # Errors
    /// The thread is to stop: pass it on.
    pub fn wait_until_cycle(&self, call: &NativeCall<'_>, cycle: u64) -> Result<(), Unwind> {
        call.wait(self.0.register_wait(Wait::Cycle(cycle)))
    }

    /// Suspends the calling thread until the cycle with this number has begun, or the program beside this one has
    /// ended.
    ///
    /// # Errors
    /// The thread is to stop: pass it on.
    pub fn wait_until_cycle_or_program_end(
        &self,
        call: &NativeCall<'_>,
        cycle: u64,
    ) -> Result<(), Unwind> {
        call.wait(self.0.register_wait(Wait::CycleOrProgramEnd(cycle)))
    }
}

impl TestTaskConfig {
    pub(crate) fn program_is_inactive(&self) -> bool {
        !self.has_company.load(Ordering::Acquire)
    }
}
