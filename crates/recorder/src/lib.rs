//! MCAP recordings: the writer and its thread, the reader, schemas, comparison of two recordings.
//!
//! A [`Recorder`] empties the ring of records of the motion thread into a file that public viewers show without
//! set-up: every control cycle, every command, the programs and the lines they are in, messages, changes of inputs and
//! outputs, and the arm in motion. A [`Recording`] reads such a file again, also one whose writer was killed.
//!
//! Owns the file's format. Knows no planner and no plant: running a recording again is wired up by the server.
//!
//! Times are simulated seconds since start; time stamps in the file are [`Setup::epoch_ns`] plus that time.

// No thread starts but through `supervision`; nothing waits for, or panics at, whoever reads our output.
#![cfg_attr(
    not(test),
    warn(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

pub mod arguments;
mod chunks;
pub mod compare;
pub mod cycle;
mod extra;
pub mod files;
mod handle;
mod io_changes;
mod json_values;
mod layout;
pub mod lengths;
mod losses;
mod messages;
mod notes;
mod read_error;
pub mod reader;
pub mod recorder;
mod records;
pub mod rotation;
pub mod setup;
pub mod summary;
pub mod table;
pub mod topics;
pub mod viewer;
mod watcher;
mod worker;
mod writer;

pub use arguments::ArgumentError;
pub use chunks::{CHUNK_BYTES, CHUNK_SECS};
pub use compare::{Difference, FieldDifference, difference, difference_ignoring};
pub use cycle::{CycleError, CycleMessage, FieldValue};
pub use extra::{CustomTopic, CustomTopicId};
pub use files::{CellFileError, CellFiles};
pub use handle::{RecorderHandle, RecorderMetrics};
pub use reader::{FileEnd, ReadError, Recording, RecordingEntry, messages_of_file};
pub use recorder::{CloseHandle, RecordError, Recorder, RecorderConfig};
pub use rotation::{Rotation, RotationTrigger};
pub use setup::{Setup, SetupError};
pub use summary::Summary;
pub use table::TopicTable;
pub use topics::{
    CommandMessage, IoMessage, IoValue, LogLevel, LogMessage, ScriptMessage, Topic, VariableMessage,
};
pub use viewer::{ObstacleShape, SceneBody, SceneFrame, SceneObstacle, ViewerMessages};
pub use writer::Totals;
