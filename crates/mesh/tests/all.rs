//! Meshes of all formats, solids and convex pieces.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "tests fail by panicking"
)]

mod formats;
mod hostile;
mod pieces;
mod shapes;
mod solids;
