//! The script threads of a task: their numbers, which of them run, and which are to start or stop.

use std::collections::BTreeSet;

use elite_lang::{NodeCursor, Value};
use messages::Localized;
use motion_api::ThreadNumber;
use thiserror::Error;

use super::TaskContext;

/// Most script threads of one task, the main thread not counted.
pub(crate) const THREADS_MAX: usize = 20;

/// Threads of a task.
#[derive(Default)]
pub(super) struct ThreadTable {
    last: u32,
    alive: BTreeSet<ThreadNumber>,
    to_start: Vec<ThreadStart>,
    to_stop: Vec<ThreadNumber>,
}

/// A thread that is to be started.
pub(crate) struct ThreadStart {
    pub number: ThreadNumber,
    pub function: Value,
    pub args: Vec<Value>,
    /// Where in the pendant's task the thread begins.
    pub node: NodeCursor,
}

/// What is known about a handle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ThreadLookup {
    /// The thread runs or is about to.
    Running,
    /// There was such a thread.
    Ended,
    /// There never was.
    Unknown,
}

/// More script threads than [`THREADS_MAX`] were to run at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error, Localized)]
#[error("Thread over the max size: {}", THREADS_MAX)]
#[zh("线程数超过上限：{}", THREADS_MAX)]
pub(crate) struct ThreadCountError;

impl TaskContext {
    /// Takes a number for a new thread; it starts after the current slice.
    pub fn start_thread(
        &self,
        function: Value,
        args: Vec<Value>,
        node: NodeCursor,
    ) -> Result<ThreadNumber, ThreadCountError> {
        let number = self.take_number()?;
        self.threads.borrow_mut().to_start.push(ThreadStart {
            number,
            function,
            args,
            node,
        });
        Ok(number)
    }

    /// A number for a new thread, which counts as alive from now on.
    pub fn take_number(&self) -> Result<ThreadNumber, ThreadCountError> {
        let mut threads = self.threads.borrow_mut();
        if threads.alive.len() >= THREADS_MAX {
            return Err(ThreadCountError);
        }
        threads.last += 1;
        let number = ThreadNumber(threads.last);
        threads.alive.insert(number);
        Ok(number)
    }

    /// The thread is stopped after the current slice.
    pub fn request_thread_stop(&self, number: ThreadNumber) {
        self.threads.borrow_mut().to_stop.push(number);
    }

    pub fn find_thread(&self, number: ThreadNumber) -> ThreadLookup {
        let threads = self.threads.borrow();
        if threads.alive.contains(&number) {
            ThreadLookup::Running
        } else if number.0 >= 1 && number.0 <= threads.last {
            ThreadLookup::Ended
        } else {
            ThreadLookup::Unknown
        }
    }

    /// Whether another script thread runs, or is about to.
    pub fn has_other_threads(&self) -> bool {
        let running = self.running_thread();
        self.threads
            .borrow()
            .alive
            .iter()
            .any(|thread| *thread != running)
    }

    /// What the slice asked for: threads to start.
    pub fn take_starts(&self) -> Vec<ThreadStart> {
        std::mem::take(&mut self.threads.borrow_mut().to_start)
    }

    /// What the slice asked for: threads to stop.
    pub fn take_stops(&self) -> Vec<ThreadNumber> {
        std::mem::take(&mut self.threads.borrow_mut().to_stop)
    }

    /// A thread has ended.
    pub fn thread_ended(&self, number: ThreadNumber) {
        self.threads.borrow_mut().alive.remove(&number);
    }
}
