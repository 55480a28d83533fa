//! The one place where long-lived threads and tasks start: each gets a name, its panic is caught and told to whoever
//! watches, and whoever waits for it hears of its end, however it ended.
//!
//! Owns starting ([`ThreadSupervisor::start`], [`ThreadSupervisor::start_service`], with the feature `tokio` also
//! `spawn`), containing ([`catch`], [`CatchPanic`]) and telling ([`ThreadSupervisor`]). What follows from a fault is
//! decided by the owner of the thread, by the rule of its [`ThreadRole`]. Knows no robot. A panic in here would be one
//! that nobody catches, so nothing here can.

// No thread starts but through `supervision`; nothing waits for, or panics at, whoever reads our output.
#![cfg_attr(
    not(test),
    warn(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

mod contained;
mod ended;
mod faults;
pub mod injection;
#[cfg(feature = "tokio")]
mod tasks;
mod thread;

pub use contained::{CatchPanic, CaughtPanic, catch, install_panic_hook};
pub use ended::EndSignal;
pub use faults::{Fault, ThreadRole, ThreadSupervisor};
pub use thread::ThreadHandle;
