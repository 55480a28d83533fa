//! The pendant page: its files, bundled when the crate is built, and the interface behind it under `/api/v1`.
//!
//! Owns what the page sees and orders, and how both look on the wire. Knows no sockets: the server mounts it on its
//! http port.

// No thread starts but through `supervision`; nothing waits for, or panics at, whoever reads our output.
#![cfg_attr(
    not(test),
    warn(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

pub mod assets;
pub mod bounded_series;
pub mod control;
pub mod editor_queries;
pub mod frame;
pub mod history;
pub mod jog;
pub mod living_cell;
pub mod meshes;
pub mod orders;
pub mod planned_path;
pub mod programs;
pub mod scene;

pub use control::{ControlError, ControlLock, PageId, Token};
pub use frame::{FRAME_BYTES, FRAME_VERSION, FrameContext};
pub use history::History;
pub use jog::HoldToRunState;
pub use living_cell::WorldWatch;
pub use meshes::SceneMeshes;
pub use orders::{OrderError, PageOrder, PageRequest};
pub use scene::PageScene;
