//! The `eliteserver` binary: [`server::program`] with the command line of the process.

// No thread starts but through `supervision`; nothing waits for, or panics at, whoever reads our output.
#![cfg_attr(
    not(test),
    warn(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(server::program::run_program(std::env::args_os()))
}
