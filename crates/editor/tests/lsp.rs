//! The analysis of programs and the language server, without a process around them.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "tests fail by panicking"
)]

mod answers;
mod behaviour;
mod client;
mod edits;
mod messages;
mod names;
mod programs;
mod reading;
mod recovery;
