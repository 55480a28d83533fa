//! Tasks, script threads and the builtins that bind scripts to the robot.
//!
//! Owns the life of programs and what their calls do. Talks to the robot only through `motion-api`: commands go into a
//! ring, events and snapshots come back. Knows no port, no recording format and not the planner.

// No thread starts but through `supervision`; nothing waits for, or panics at, whoever reads our output.
#![cfg_attr(
    not(test),
    warn(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

pub mod builtins;
mod command_table;
mod compile_pool;
pub mod configuration_variables;
pub mod debug;
pub mod external;
pub mod interpreter;
pub mod interpreter_queue;
pub mod message;
pub mod micro_line;
pub mod panel;
pub mod port_map;
mod predicted_state;
pub mod preset;
pub mod robot;
pub mod supervisor;
mod task;
pub mod task_folder;
pub mod test_task;
mod value_text;

pub use compile_pool::{CompilePool, CompilePoolError};
pub use message::{Message, Observer, Severity};
pub use panel::Panel;
pub use preset::{Preset, PresetError};
pub use robot::Robot;
pub use supervisor::{NoAnswer, SubmitError, Supervisor, TaskState, TaskStatus};
pub use task::{
    FileAccess, Instrumentation, LineCountsByText, NetworkAccess, OwnChild, Permissions,
    ProgramText, SandboxError, SandboxRoots, SandboxedPath, TaskEnd, TaskSettings,
    claim_all_children,
};
pub use test_task::{TestTaskConfig, TestTaskHandle};
