//! A process that dies with the controller, also when that is killed and cannot end anybody.
//!
//! The one place of this crate with unsafe code: the system wants to be asked by the new process itself, between `fork`
//! and `exec`.
#![allow(
    unsafe_code,
    reason = "what happens between fork and exec is unsafe in std"
)]

use nix::sys::prctl::set_pdeathsig;
use nix::sys::signal::Signal;
use tokio::process::Command;

/// The process is killed when the thread that starts it, which is that of the task, ends in whatever way. What it has
/// started itself is not: that is found at the end of the task, and outlives a `kill -9` of the controller.
pub(super) fn with_the_controller(command: &mut Command) {
    // SAFETY: the closure runs in the child of a `fork`, where only async-signal-safe functions may be called. It makes
    // one system call (prctl) and turns its error number into an `io::Error`, which does not allocate.
    unsafe {
        command.pre_exec(|| Ok(set_pdeathsig(Signal::SIGKILL)?));
    }
}
