//! One task: a main program, its script threads and the secondary programs beside it, on one OS thread.
//!
//! - `context`: what builtins see of their task (robot, waits, threads to start or stop).
//! - `instrumentation`: what only tests of programs ask for.
//! - `control_channel`: what others ask of it.
//! - `scheduler`: resumes script threads in a fixed order; `threads`: how they wait, wake, start and end; `startup`:
//!   how the program gets there; `pause`: what holds the task and lets it go on.
//! - `deferred`: messages and flags of a program that is ahead of the arm.
//! - `robot_view`: the robot as the task sees it in one turn; `inputs`: when it looks round, and what it finds then.
//! - `time`: which waits are over, and what makes time pass; `report`: what people are told.
//! - `jobs`: futures that builtins wait for.
//! - `handover`: the stop with which a program hands the arm over to the next one.
//! - `host`: what the language asks of its surroundings (print, clock, random numbers).
//! - `network`: TCP sockets of programs; `files` and `processes`: what `--allow fs` and `--allow process` grant them.
//! - `sandbox`: files of some folders only (`--allow fs=DIR`).
//! - `process_tree` and `death_signal`: processes end with the task that started them.

mod context;
mod controls;
mod deferred;
mod files;
mod handover;
mod host;
mod inputs;
mod instrumentation;
mod jobs;
mod network;
mod pause;
mod process_tree;
mod processes;
mod report;
mod robot_view;
mod sandbox;
mod scheduler;
mod startup;
mod threads;
mod time;
mod wait;

pub(crate) use context::{CallRestriction, TaskContext, TaskRequest, ThreadLookup};
pub(crate) use controls::{ControlReceiver, ControlSender, control_channel};
pub(crate) use deferred::Effect;
pub(crate) use handover::HandoverStop;
pub use host::{FileAccess, NetworkAccess, Permissions};
pub use instrumentation::{Instrumentation, LineCountsByText};
pub(crate) use jobs::JobId;
pub use process_tree::{OwnChild, claim_all_children};
pub(crate) use report::message_of;
pub(crate) use robot_view::RobotView;
pub use sandbox::{SandboxError, SandboxRoots, SandboxedPath};
pub(crate) use scheduler::{FinishedTask, ProgramSource, Task};
pub use scheduler::{ProgramText, TaskEnd, TaskSettings};
pub(crate) use wait::Wait;
