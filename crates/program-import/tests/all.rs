//! Tests of the crate, in one binary.

#![allow(clippy::unwrap_used, reason = "a test helper fails by panicking")]

mod toolpaths;
mod translation;
