//! One arm with its task, its recording and its clock, without ports: what `run`, `serve` and whoever else runs
//! programs start. Many fit into one process; each is deterministic under the virtual clock, whatever the others do.
//!
//! Owns the settings of a robot, the cell file, how the parts are wired together, the threads (clock, pump, recorder)
//! and the order in which they end. What a program says goes to the recording here; who else is told is the business of
//! whoever starts a controller, through one [`Observer`](elite_runtime::message::Observer). Knows no port and no
//! command line.

// No thread starts but through `supervision`; nothing waits for, or panics at, whoever reads our output.
#![cfg_attr(
    not(test),
    warn(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

pub mod cell;
pub mod cell_world;
pub mod clearance;
mod clock;
pub mod command_replay;
pub mod condition;
mod config;
pub mod cycle_gate;
pub mod external_topic;
mod gate_observer;
pub mod io_values;
mod loaded_model;
pub mod optimizer;
pub mod options;
pub mod outcome;
pub mod peaks;
pub mod planned_path;
pub mod program_position;
pub mod recorded_run;
mod recording_files;
pub mod recording_observer;
pub mod register_write;
pub mod rerun;
mod running;
pub mod search;
mod start;
pub mod start_configuration;
pub mod stepped;

pub use cell_world::CellWorld;
pub use config::{ControllerConfig, read_text_within};
pub use outcome::{NullObserver, ProgramOutcome, ProgramResult, ResultCollector};
pub use peaks::Peaks;
pub use recording_observer::{LogLine, LogLines};
pub use running::Controller;
pub use start::{PreparedController, StartError, StartOptions};
pub use stepped::{SteppedController, SteppedError, WallTimeout};
