//! Tests of controllers without ports, in one binary: a file each.

mod cell_world;
mod common;
mod gripper_bus;

mod clearance;
mod many;
mod meshes;
mod stepped;
mod stopped_threads;
mod zone_changes;
