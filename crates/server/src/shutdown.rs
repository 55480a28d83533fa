//! The end of the process: SIGINT or SIGTERM, or a fault after which nothing can go on.
//!
//! Owns two threads that ask nobody. One hears signals; the other counts the time from the first of them, and when the
//! orderly way takes too long it has the recording closed and ends the process, whatever the rest of it is doing.

use std::io;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use parking_lot::{Condvar, Mutex, MutexGuard};
use platform::signals::{self, exit_immediately};
use recorder::CloseHandle;
use supervision::{ThreadRole, ThreadSupervisor};
use tokio_util::sync::CancellationToken;

use crate::command::CommandStatus;
use crate::logging;

/// Exit status of a second signal, by which a person says that the end takes too long: 128 + SIGINT.
const IMPATIENT_EXIT: i32 = 130;

/// The orderly way has this long; then the recording is closed without it.
const ORDERLY_TIMEOUT: Duration = Duration::from_millis(1100);
/// The recording has this long to be closed, standard error this long to be read.
const CLOSING: Duration = Duration::from_millis(500);
const STDERR_FLUSH_TIMEOUT: Duration = Duration::from_millis(100);

/// How the process ends. Clones share it.
#[derive(Clone)]
pub struct Shutdown {
    shared: Arc<ShutdownSequence>,
}

struct ShutdownSequence {
    token: CancellationToken,
    begun: ShutdownLatch,
    closer: Mutex<Option<CloseHandle>>,
}

/// The first call counts; the deadline's thread waits for it.
#[derive(Default)]
struct ShutdownLatch {
    status: OnceLock<CommandStatus>,
    told: Mutex<bool>,
    changed: Condvar,
}

impl Shutdown {
    /// Listens for signals from now on; before, they end the process at once. `status` is that of a process that a
    /// signal ended with everything flushed.
    ///
    /// # Errors
    /// The operating system gives no threads or no signals.
    pub fn start(status: CommandStatus) -> io::Result<Self> {
        Self::start_within(status, ORDERLY_TIMEOUT)
    }

    /// Listens for signals from now on, with `orderly` for the time that an orderly end may take: a process that stops
    /// a robot first needs longer than others. `status` is that of a process that a signal ended with everything
    /// flushed.
    ///
    /// # Errors
    /// The operating system gives no threads or no signals.
    pub fn start_within(status: CommandStatus, orderly: Duration) -> io::Result<Self> {
        let shutdown = Self {
            shared: Arc::new(ShutdownSequence {
                token: CancellationToken::new(),
                begun: ShutdownLatch::default(),
                closer: Mutex::default(),
            }),
        };
        // Whoever writes into a file that may not grow hears of it as an error of the write.
        signals::suppress_sigxfsz()?;
        let mut ends = signals::TerminationSignals::listen()?;
        let faults = ThreadSupervisor::default();
        let on_signal = shutdown.clone();
        faults.start(ThreadRole::Service, "signals", move || {
            if let Some(name) = ends.wait() {
                on_signal.begin(status);
                tracing::info!("{name}: the end begins");
            }
            if ends.wait().is_some() {
                // No word about it: words could wait.
                exit_immediately(IMPATIENT_EXIT);
            }
        })?;
        let at_deadline = shutdown.clone();
        faults.start(ThreadRole::Service, "deadline", move || {
            at_deadline.run_deadline(orderly)
        })?;
        Ok(shutdown)
    }

    /// Cancelled when the end begins.
    pub fn token(&self) -> &CancellationToken {
        &self.shared.token
    }

    /// Begins the end, which is sure to come from now on. The first call counts.
    pub fn begin(&self, status: CommandStatus) {
        let begun = &self.shared.begun;
        if begun.status.set(status).is_err() {
            return;
        }
        *begun.told.lock() = true;
        begun.changed.notify_all();
        self.shared.token.cancel();
    }

    /// The recording that is to be closed even when nothing else can be.
    pub fn set_recording_closer(&self, closer: Option<CloseHandle>) {
        *self.closer() = closer;
    }

    fn closer(&self) -> MutexGuard<'_, Option<CloseHandle>> {
        self.shared.closer.lock()
    }

    fn run_deadline(&self, orderly: Duration) {
        let status = self.shared.begun.wait();
        std::thread::sleep(orderly);
        let closer = self.closer().clone();
        let is_closed = closer.is_none_or(|closer| {
            closer.request_close();
            let is_closed = closer.wait_closed(CLOSING);
            if !is_closed {
                tracing::error!("the recording is cut short: {}", closer.describe_missing());
            }
            is_closed
        });
        tracing::warn!("the orderly way took too long; what still runs is cut off");
        logging::flush_within(STDERR_FLUSH_TIMEOUT);
        let flushed = match is_closed {
            true => status,
            false => status.max(CommandStatus::Negative),
        };
        exit_immediately(flushed.code().into());
    }
}

impl ShutdownLatch {
    fn wait(&self) -> CommandStatus {
        let mut told = self.told.lock();
        while !*told {
            self.changed.wait(&mut told);
        }
        // Set before it is told.
        self.status.get().copied().unwrap_or_default()
    }
}
