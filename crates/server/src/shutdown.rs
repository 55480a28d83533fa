//! The end of the server: SIGINT or SIGTERM cancels one token, which every port, session and thread watches.

use std::io;

use tokio::signal::unix::{SignalKind, signal};
use tokio_util::sync::CancellationToken;

/// Exit status of a second signal, by which a person says that the end takes too long: 128 + SIGINT.
const IMPATIENT_EXIT: i32 = 130;

/// Cancels `shutdown` at the first SIGINT or SIGTERM; a second one ends the process at once. Call it once, inside the
/// runtime, before the ports open: a signal before that would kill the process without flushing.
pub fn on_signals(shutdown: CancellationToken) -> io::Result<()> {
    let mut interrupt = signal(SignalKind::interrupt())?;
    let mut terminate = signal(SignalKind::terminate())?;
    tokio::spawn(async move {
        let name = tokio::select! {
            _ = interrupt.recv() => "SIGINT",
            _ = terminate.recv() => "SIGTERM",
        };
        tracing::info!("{name}: the server ends");
        shutdown.cancel();
        tokio::select! {
            _ = interrupt.recv() => {}
            _ = terminate.recv() => {}
        }
        tracing::warn!("a second signal: ended without flushing");
        std::process::exit(IMPATIENT_EXIT);
    });
    Ok(())
}
