//! One task: a main program, its script threads and the secondary programs beside it, on one OS thread.
//!
//! - `context`: what builtins see of their task (robot, waits, threads to start or stop).
//! - `scheduler`: resumes script threads in a fixed order, and lets time pass when all of them wait.
//! - `host`: what the language asks of its surroundings (print, clock, random numbers).
//! - `network`: TCP sockets of programs.

mod context;
mod host;
mod network;
mod scheduler;
mod wait;

pub(crate) use context::{TaskContext, ThreadLookup};
pub use host::Permissions;
pub(crate) use scheduler::Task;
pub use scheduler::{Control, ProgramText, TaskEnd, TaskSettings};
pub(crate) use wait::Wait;
