//! What went wrong in which thread, and who is told.

use std::fmt;
use std::io;
use std::pin::Pin;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::task::{Context, Poll};
use std::time::Duration;

use messages::Localized;
use thiserror::Error;

use crate::EndSignal;
use crate::contained::{CaughtPanic, catch};
use crate::thread::{ThreadHandle, start};

/// What a thread is for; with it the rule of what a fault in it may take down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThreadRole {
    /// A program of a user. It ends with `InternalError: …`, the arm stops on its path, the next program runs.
    Task,
    /// One connection of a port. It ends; the port and its other connections live on.
    Port,
    /// Something that serves others (a field bus, the pump, a log file). It is started again, or its users are told
    /// that it is gone; nobody waits for it.
    Service,
    /// The recording. It ends with an alarm, the robot goes on.
    Recorder,
    /// The control cycle. The arm is stopped, everybody is told, the process ends with a status of its own.
    Motion,
}

impl ThreadRole {
    /// Every kind, in the order of [`ThreadSupervisor::counts`].
    pub const ALL: [Self; 5] = [
        Self::Task,
        Self::Port,
        Self::Service,
        Self::Recorder,
        Self::Motion,
    ];

    /// One word.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Task => "task",
            Self::Port => "port",
            Self::Service => "service",
            Self::Recorder => "recorder",
            Self::Motion => "motion",
        }
    }
}

impl fmt::Display for ThreadRole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A panic that was caught: a bug of ours.
#[derive(Clone, Debug, PartialEq, Eq, Error, Localized)]
#[error("a fault of ours in {name} ({kind}): {}; please report it", self.describe())]
#[zh("{name} 中的软件缺陷（{kind}）：{}；请报告", self.describe())]
pub struct Fault {
    /// What the thread was for.
    pub kind: ThreadRole,
    /// Name of the thread.
    pub name: String,
    /// What the panic said.
    pub message: String,
    /// Place of the panic, as `file:line`, when the hook is installed.
    pub location: Option<String>,
}

impl Fault {
    /// A fault in the thread or task `name`.
    pub fn new(kind: ThreadRole, name: impl Into<String>, panicked: CaughtPanic) -> Self {
        Self {
            kind,
            name: name.into(),
            message: panicked.message,
            location: panicked.place,
        }
    }

    /// What the panic said, and where.
    pub fn describe(&self) -> String {
        match &self.location {
            Some(place) => format!("{} ({place})", self.message),
            None => self.message.clone(),
        }
    }
}

/// Where faults are told. Clones share everything; each controller has one.
#[derive(Clone, Default)]
pub struct ThreadSupervisor {
    shared: Arc<SupervisorState>,
}

#[derive(Default)]
struct SupervisorState {
    counts: [AtomicU64; ThreadRole::ALL.len()],
    /// The first fault of the control cycle: nothing can go on after it.
    fatal: OnceLock<Fault>,
    is_fatal: EndSignal,
}

/// First and longest pause before a service is started again.
const MIN_RESTART_DELAY: Duration = Duration::from_millis(50);
const MAX_RESTART_DELAY: Duration = Duration::from_secs(5);

impl ThreadSupervisor {
    /// Counts and logs a fault. One of [`ThreadRole::Motion`] is fatal.
    pub fn tell(&self, fault: &Fault) {
        let place = ThreadRole::ALL.iter().position(|kind| *kind == fault.kind);
        if let Some(count) = place.map(|place| &self.shared.counts[place]) {
            count.fetch_add(1, Ordering::Relaxed);
        }
        if fault.kind == ThreadRole::Motion {
            // Only the first counts; what follows from it would hide it.
            let _ = self.shared.fatal.set(fault.clone());
        }
        tracing::error!("{fault}");
        if fault.kind == ThreadRole::Motion {
            self.shared.is_fatal.set();
        }
    }

    /// Number of faults of each kind.
    pub fn counts(&self) -> [(ThreadRole, u64); ThreadRole::ALL.len()] {
        core::array::from_fn(|i| {
            (
                ThreadRole::ALL[i],
                self.shared.counts[i].load(Ordering::Relaxed),
            )
        })
    }

    /// The fault after which the process must end, once there is one.
    pub fn fatal(&self) -> Option<&Fault> {
        self.shared.fatal.get()
    }

    /// Returns once there is a fault after which the process must end.
    pub fn wait_fatal(&self) -> impl Future<Output = ()> + Send + use<> {
        self.shared.is_fatal.wait_async()
    }

    /// Starts a thread.
    ///
    /// # Errors
    /// The operating system gives none.
    pub fn start<T: Send + 'static>(
        &self,
        kind: ThreadRole,
        name: impl Into<String>,
        body: impl FnOnce() -> T + Send + 'static,
    ) -> io::Result<ThreadHandle<T>> {
        start(self.clone(), kind, name.into(), body)
    }

    /// Starts a thread of [`ThreadRole::Service`] whose body is run again, after a growing pause, when it panics. It
    /// ends when the body returns.
    ///
    /// # Errors
    /// The operating system gives no thread.
    pub fn start_service(
        &self,
        name: &'static str,
        mut body: impl FnMut() + Send + 'static,
    ) -> io::Result<ThreadHandle<()>> {
        let faults = self.clone();
        self.start(ThreadRole::Service, name, move || {
            let mut pause = MIN_RESTART_DELAY;
            while let Err(panicked) = catch(&mut body) {
                faults.tell(&Fault::new(ThreadRole::Service, name, panicked));
                std::thread::sleep(pause);
                pause = next_restart_delay(pause);
            }
        })
    }
}

/// The pause after the next fault.
pub(crate) fn next_restart_delay(pause: Duration) -> Duration {
    (2 * pause).min(MAX_RESTART_DELAY)
}

#[cfg(feature = "tokio")]
pub(crate) const FIRST_PAUSE: Duration = MIN_RESTART_DELAY;

impl fmt::Debug for ThreadSupervisor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_map().entries(self.counts()).finish()
    }
}

/// The wait of [`ThreadSupervisor::wait_fatal`] and [`EndSignal::wait_async`].
pub(crate) struct EndSignalFuture(pub(crate) EndSignal);

impl Future for EndSignalFuture {
    type Output = ();

    fn poll(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<()> {
        self.0.poll_ended(context)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicU32;

    #[test]
    fn a_service_that_panics_is_started_again_until_it_returns() {
        let faults = ThreadSupervisor::default();
        let runs = Arc::new(AtomicU32::new(0));
        let counted = runs.clone();
        let service = faults.start_service("pump", move || {
            assert!(counted.fetch_add(1, Ordering::Relaxed) >= 2, "not yet");
        });
        service.unwrap().join().unwrap();
        assert_eq!(runs.load(Ordering::Relaxed), 3);
        assert_eq!(faults.counts()[2], (ThreadRole::Service, 2));
        assert!(faults.fatal().is_none());
    }

    #[test]
    fn only_the_control_cycle_is_fatal_and_the_first_fault_is_the_reason() {
        let faults = ThreadSupervisor::default();
        for kind in ThreadRole::ALL {
            let is_motion = kind == ThreadRole::Motion;
            let thread = faults.start(kind, format!("a-{kind}"), || panic!("here"));
            thread.unwrap().join().unwrap_err();
            assert_eq!(faults.fatal().is_some(), is_motion, "{kind}");
        }
        let again = faults.start(ThreadRole::Motion, "other", || panic!("there"));
        again.unwrap().join().unwrap_err();
        assert_eq!(faults.fatal().unwrap().message, "here");
    }
}
