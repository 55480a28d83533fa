//! What surrounds the arm: parts that fall and stack, grippers, conveyors, detectors, actuators.

#![allow(
    dead_code,
    reason = "grippers, conveyors and the rest of the cell come next"
)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod arm;
mod check;
pub mod description;
mod engine;
mod error;
mod input;
mod levels;
mod materials;
mod parts;
mod state;
mod world;

pub use check::{FLOOR, MAX_ENTRIES, MAX_PARTS};
pub use description::WorldDescription;
pub use error::{OrderError, WorldError};
pub use input::{HeldPart, Input, MAX_GRIPPERS, Output};
pub use levels::{Levels, PointSet};
pub use state::*;
pub use world::World;
