//! Clients of the vendor's ports: they talk to a controller, real or ours.
//!
//! Owns connections to a robot, what is made of its answers, and the sentences about what goes wrong between. Knows no
//! simulated arm and no command line. Whatever a peer sends is bounded and checked (crate `wire`); a peer that is gone,
//! slow or something else is an error with its address, never a hang.

// No thread starts but through `supervision`; nothing waits for, or panics at, whoever reads our output.
#![cfg_attr(
    not(test),
    warn(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

pub mod address;
pub mod calibrate;
pub mod compare;
pub mod dashboard;
pub mod follow;
pub mod interpreter;
pub mod observed;
pub mod primary;
pub mod rtsi;

pub use address::{ConnectError, RobotAddress};
pub use follow::{MonitorOutcome, ProgramEvent, ProgramMonitor};
pub use interpreter::{InterpreterClient, InterpreterError, InterpreterRequest, Reply};
pub use primary::{PrimaryClient, PrimaryError};
pub use rtsi::{RtsiClient, RtsiError, RtsiMessage};
