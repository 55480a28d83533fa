//! One task: a main program, its script threads and the secondary programs beside it, on one OS thread.
//!
//! - `context`: what builtins see of their task (robot, waits, threads to start or stop).
//! - `scheduler`: resumes script threads in a fixed order, and lets time pass when all of them wait.
//! - `outside`: futures that script threads wait for.
//! - `host`: what the language asks of its surroundings (print, clock, random numbers).

mod context;
mod host;
mod outside;
mod scheduler;
mod wait;

pub(crate) use context::{TaskContext, ThreadLookup};
pub(crate) use scheduler::Task;
pub use scheduler::{Control, ProgramText, TaskEnd, TaskSettings};
pub(crate) use wait::Wait;
