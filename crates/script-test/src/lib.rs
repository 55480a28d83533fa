//! Tests of robot programs: finds them, runs each on a fresh controller under the virtual clock, several at once and in
//! any order, and tells what became of them.
//!
//! A test is a function of a script file; beside the builtins it has the object `test`, with which it starts programs,
//! lets time pass, sets inputs, plays machines on the network and looks at what happened (docs/testing.md).
//!
//! - `discover`: which tests there are; `files`: what they may consist of; `pool`: which runs when; `runner`: one of
//!   them.
//! - `lockstep`: how a test and the program beside it share one clock; `test_context`: what both work on; `trace`: what
//!   the arm did.
//! - `test_object`, `expect`: the functions of `test`; `near`, `golden_path`: what they compare; `simulated_peers`,
//!   `simulated_servers`: machines it plays.
//! - `report`: for people, for machines, for servers that build.
//!
//! Knows no command line and no configuration file: whoever calls says which settings belong to which test.

// No thread starts but through `supervision`; nothing waits for, or panics at, whoever reads our output.
#![cfg_attr(
    not(test),
    warn(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

mod discover;
mod expect;
mod files;
mod golden_path;
mod lockstep;
mod near;
mod pool;
pub mod report;
mod runner;
mod simulated_peers;
mod simulated_servers;
mod test_context;
mod test_object;
mod trace;
mod world_functions;

/// What a test calls the object that makes it one.
pub const OBJECT: &str = "test";

pub use discover::{
    DiscoverError, TestCase, TestFile, discover, discover_in, is_test_file, scripts_below,
};
pub use files::FileScope;
pub use golden_path::GoldenMode;
pub use pool::TestSettings;
pub use pool::{TestRunOptions, run};
pub use runner::{Status, TestResult, WALL_TIMEOUT, usual_timeout};
pub use test_object::{function_names, function_parameters};
