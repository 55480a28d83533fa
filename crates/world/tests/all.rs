//! Tests of the world as its users see it, in one binary: a file each.

mod cells;
mod free_bodies;
