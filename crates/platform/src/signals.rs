//! Signals by which people and services tell a process to end or to look at its settings again.

use std::io;
use std::sync::Arc;

use signal_hook::consts::{SIGINT, SIGTERM};

/// Words to the process that it should end: SIGINT, SIGTERM. From the moment this is made on they end nothing by
/// themselves.
pub struct TerminationSignals(imp::Ends);

impl TerminationSignals {
    /// Listens.
    ///
    /// # Errors
    /// The system gives no signals.
    pub fn listen() -> io::Result<Self> {
        imp::Ends::listen().map(Self)
    }

    /// Waits for the next one and tells its name; `None` if there can be no more.
    pub fn wait(&mut self) -> Option<&'static str> {
        self.0.wait().map(|signal| match signal {
            SIGINT => "SIGINT",
            _ => "SIGTERM",
        })
    }
}

/// Has writes into a file that may not grow fail, instead of a signal end the process.
///
/// # Errors
/// The system gives no signals.
pub fn suppress_sigxfsz() -> io::Result<()> {
    #[cfg(unix)]
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default())?;
    Ok(())
}

/// Ends the process at once and asks nobody in it.
pub fn exit_immediately(status: i32) -> ! {
    signal_hook::low_level::exit(status)
}

#[cfg(unix)]
mod imp {
    use super::{SIGINT, SIGTERM, io};
    use signal_hook::iterator::Signals;

    pub(super) struct Ends(Signals);

    impl Ends {
        pub(super) fn listen() -> io::Result<Self> {
            Signals::new([SIGINT, SIGTERM]).map(Self)
        }

        pub(super) fn wait(&mut self) -> Option<i32> {
            self.0.forever().next()
        }
    }
}

#[cfg(not(unix))]
mod imp {
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::time::Duration;

    use super::{Arc, SIGINT, SIGTERM, io};

    /// Time between two looks whether a signal has come.
    const LOOK: Duration = Duration::from_millis(20);

    pub(super) struct Ends(Arc<AtomicUsize>);

    impl Ends {
        pub(super) fn listen() -> io::Result<Self> {
            let latest = Arc::new(AtomicUsize::new(0));
            for signal in [SIGINT, SIGTERM] {
                let number = usize::try_from(signal).unwrap_or(0);
                signal_hook::flag::register_usize(signal, latest.clone(), number)?;
            }
            Ok(Self(latest))
        }

        pub(super) fn wait(&mut self) -> Option<i32> {
            loop {
                match self.0.swap(0, Ordering::AcqRel) {
                    0 => std::thread::sleep(LOOK),
                    number => return i32::try_from(number).ok(),
                }
            }
        }
    }
}

/// Words to a service that its settings have changed: SIGHUP, where there is such a signal.
#[cfg(feature = "net")]
pub struct Hangups(#[cfg(unix)] tokio::signal::unix::Signal);

#[cfg(feature = "net")]
impl Hangups {
    /// Listens. Needs a tokio runtime.
    ///
    /// # Errors
    /// The system gives no signals.
    pub fn listen() -> io::Result<Self> {
        #[cfg(unix)]
        {
            use tokio::signal::unix::{SignalKind, signal};
            signal(SignalKind::hangup()).map(Self)
        }
        #[cfg(not(unix))]
        Ok(Self())
    }

    /// Waits for the next one.
    pub async fn wait(&mut self) -> Option<()> {
        #[cfg(unix)]
        {
            self.0.recv().await
        }
        #[cfg(not(unix))]
        std::future::pending().await
    }
}
