//! One task: a main program, its script threads and the secondary programs beside it, on one OS thread.
//!
//! - `context`: what builtins see of their task (robot, waits, threads to start or stop).
//! - `scheduler`: resumes script threads in a fixed order; `threads`: how they wait, wake, start and end.
//! - `time`: which waits are over, and what makes time pass; `report`: what people are told.
//! - `outside`: futures that builtins wait for.
//! - `host`: what the language asks of its surroundings (print, clock, random numbers).
//! - `network`: TCP sockets of programs; `files` and `processes`: what `--allow fs` and `--allow process` grant them.

mod context;
mod files;
mod host;
mod network;
mod outside;
mod processes;
mod report;
mod scheduler;
mod threads;
mod time;
mod wait;

pub(crate) use context::{TaskContext, TaskRequest, ThreadLookup};
pub use host::Permissions;
pub(crate) use scheduler::Task;
pub use scheduler::{Compiled, Control, ProgramText, TaskEnd, TaskSettings};
pub(crate) use wait::Wait;
