//! Everything of the `eliteserver` binary, as a library so that its parts can be tested and fuzzed one by one.
//!
//! Wires the other crates together and owns what users meet: command line, configuration, ports. No other crate
//! imports this one but `dev`, which tries the decoders, and `pybind`, whose wheel has the same program as a command.

// No thread starts but through `supervision`; nothing waits for, or panics at, whoever reads our output.
#![cfg_attr(
    not(test),
    warn(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

pub mod backend;
pub mod cli;
pub mod command;
pub mod commands;
pub mod config;
pub mod controller_host;
pub mod describe;
pub mod event_broadcast;
mod language;
pub mod log_dir;
mod log_rate_limit;
pub mod logging;
pub mod options;
pub mod plot;
pub mod ports;
pub mod program;
pub mod ready_file;
pub mod sample_feed;
pub mod sent_file;
mod shutdown;
