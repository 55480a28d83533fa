//! Tests of robot programs: finds them, runs each on a fresh controller under the virtual clock, several at once and in any
//! order, and tells what became of them.
//!
//! A test is a function of a script file; beside the builtins it has the object `test`, with which it starts programs, lets
//! time pass, sets inputs, plays machines on the network and looks at what happened (docs/testing.md).
//!
//! - `discover`: which tests there are; `files`: what they may consist of; `pool`: which runs when; `single`: one of them.
//! - `turns`: how a test and the program beside it share one clock; `bench`: what both work on; `trace`: what the arm did.
//! - `object`, `expect`: the functions of `test`; `near`, `golden`: what they compare; `peers`, `serve`: machines it plays.
//! - `report`: for people, for machines, for servers that build.
//!
//! Knows no command line and no configuration file: whoever calls says which settings belong to which test.

// No thread starts but through `supervision`; nothing waits for, or panics at, whoever reads our output.
#![cfg_attr(
    not(test),
    warn(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

mod bench;
mod discover;
mod expect;
mod files;
mod golden;
mod near;
mod object;
mod peers;
mod pool;
pub mod report;
mod serve;
mod single;
mod trace;
mod turns;

/// What a test calls the object that makes it one.
pub const OBJECT: &str = "test";

pub use discover::{DiscoverError, TestCase, TestFile, discover, discover_in, is_test_file};
pub use files::Files;
pub use golden::Goldens;
pub use object::{function_names, function_parameters};
pub use pool::{Options, run};
pub use single::{Status, TestResult};
