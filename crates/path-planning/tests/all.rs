//! The scene, the tracker and the planner as their users see them.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "test helpers fail by panicking"
)]

mod placement;
mod planner;
mod scene;
mod scenes;
mod tracker;
