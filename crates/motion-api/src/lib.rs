//! The contract between two worlds: scripts and ports on one side, the motion thread on the other.
//!
//! Everything that crosses the border is defined here and has a fixed size: commands in, events and records out, and
//! the latest state for whoever wants to look; the points of a moveml cross it as a handle ([`PointList`]). Owns no
//! planner, no physics, no script value, no socket.
//!
//! - [`Command`]s go in through a lock-free ring ([`motion_channel`] makes both ends).
//! - [`Event`]s (completions, refusals, warnings, stops) and [`Record`]s (every cycle, every command taken) come out.
//! - [`SnapshotCell`] holds the latest [`RobotState`]; readers never hold up the writer.

pub mod command;
pub mod event;
pub mod form;
pub mod io;
pub mod mode;
pub mod online;
pub mod points;
pub mod registers;
pub mod ring;
mod sequence_lock;
pub mod snapshot;
pub mod state;
pub mod timeline;
mod words;
pub mod world;

/// What the sequence lock is made of; its model (`tests/interleavings.rs`) has loom's in this place.
mod atomics {
    pub(crate) use std::hint::spin_loop;
    pub(crate) use std::sync::atomic::{AtomicU64, Ordering, fence};
}

pub use command::{
    Command, CommandId, CommandKind, MachineCommand, MotionCommand, OnlineCommand, Origin,
    OverlayCommand, ProgramId, SensingCommand, SettingCommand, ThreadNumber,
};
pub use event::{Event, Outcome, PathFault, Refusal, StopReason, Warning, WayUnit};
pub use io::{
    AnalogDomain, DigitalBank, InputAction, IoChange, IoConfig, IoImage, IoPoint, RunStateChoice,
    ToolPin,
};
pub use mode::{MotionMode, RobotMode, SafetyMode};
pub use online::{EncoderRange, FreedriveFrame, OffsetAxes, PulseDecoding};
pub use points::PointList;
pub use registers::{RegisterBank, RegisterCache, RegisterImage, RegisterImages, Registers};
pub use ring::{
    CommandSender, CycleFrame, EventReader, FrameReader, MotionEndpoint, PointListHandoff, Record,
    RecordBackpressure, RecordReader, RingCapacities, RingFull, ScriptEndpoint, motion_channel,
};
pub use snapshot::SnapshotCell;
pub use state::{CycleTime, RobotState};
pub use timeline::{Seconds, Timeline};
pub use world::{
    HeldPart, LateCycles, MAX_GRIPPERS, PointLevels, PointSet, WorldEndpoint, WorldInput,
    WorldOutput, WorldPort, world_channel,
};
