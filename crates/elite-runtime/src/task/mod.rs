//! One task: a main program, its script threads and the secondary programs beside it, on one OS thread.
//!
//! - `context`: what builtins see of their task (robot, waits, threads to start or stop).
//! - `extras`: what only tests of programs ask for.
//! - `controls`: what others ask of it.
//! - `scheduler`: resumes script threads in a fixed order; `threads`: how they wait, wake, start and end; `beginning`: how the
//!   program gets there; `holding`: what holds the task and lets it go on.
//! - `view`: the robot as the task sees it in one turn; `turns`: when it looks round, and what it finds then.
//! - `time`: which waits are over, and what makes time pass; `report`: what people are told.
//! - `outside`: futures that builtins wait for.
//! - `braking`: the stop with which a program hands the arm over to the next one.
//! - `host`: what the language asks of its surroundings (print, clock, random numbers).
//! - `network`: TCP sockets of programs; `files` and `processes`: what `--allow fs` and `--allow process` grant them.
//! - `beneath`: files of some folders only (`--allow fs=DIR`).
//! - `family` and `death_signal`: processes end with the task that started them.

mod beginning;
mod beneath;
mod braking;
mod context;
mod controls;
mod extras;
mod family;
mod files;
mod holding;
mod host;
mod network;
mod outside;
mod processes;
mod report;
mod scheduler;
mod threads;
mod time;
mod turns;
mod view;
mod wait;

pub use beneath::{FolderAccessError, Folders, Place};
pub(crate) use braking::Braking;
pub(crate) use context::{Bounds, TaskContext, TaskRequest, ThreadLookup};
pub(crate) use controls::{Controller, Controls, controls};
pub use extras::{Extras, LineCountsOfTexts};
pub use family::all_children_are_tasks;
pub use host::{FileAccess, NetworkAccess, Permissions};
pub(crate) use outside::JobId;
pub(crate) use report::message_of;
pub(crate) use scheduler::{Ended, Source, Task};
pub use scheduler::{ProgramText, TaskEnd, TaskSettings};
pub(crate) use view::View;
pub(crate) use wait::Wait;
