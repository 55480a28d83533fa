//! What surrounds the arm: parts that fall and stack, grippers, conveyors, detectors, actuators.

#![allow(
    dead_code,
    reason = "grippers, conveyors and the rest of the cell come next"
)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod actuator;
mod arm;
mod check;
mod conveyor;
mod cup_sharing;
pub mod description;
mod detector;
mod edges;
mod engine;
mod error;
mod fault;
mod fingers;
mod gripper;
mod hold;
mod input;
mod levels;
mod machine_fault;
mod materials;
mod orders;
mod overlap;
mod part_faults;
mod parts;
mod scatter;
mod source;
mod state;
mod vacuum;
mod world;

pub use check::{FLOOR, MAX_ENTRIES, MAX_PARTS};
pub use description::WorldDescription;
pub use error::{OrderError, WorldError};
pub use fingers::FingerOrder;
pub use input::{HeldPart, Input, MAX_GRIPPERS, Output};
pub use levels::{Levels, PointSet};
pub use state::*;
pub use world::World;
