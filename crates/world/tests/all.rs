//! Tests of the world as its users see it, in one binary: a file each.

mod cells;
mod faults;
mod fingers;
mod free_bodies;
mod hand;
mod machines;
mod properties;
mod refusals;
mod vacuum;
