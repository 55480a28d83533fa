//! Port 30011: what port 30001 sends, and nothing in. It serves in every control mode.
//!
//! What a client sends is read and dropped, so that it cannot fill anything; one that has closed its half goes on
//! listening.

use std::io;
use std::sync::Arc;

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite};
use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;

use super::primary::{PrimaryBackend, StateHub, session};
use crate::ports::listen::{PortMeter, serve_sessions};

/// What is read, and dropped, at once.
const READ_BYTES: usize = 4096;

/// Serves the port until `shutdown`; returns when every client is closed.
pub async fn serve<B: PrimaryBackend>(
    listener: TcpListener,
    backend: Arc<B>,
    hub: StateHub,
    meter: PortMeter,
    shutdown: CancellationToken,
) {
    let session = |stream, _, (backend, hub): (Arc<B>, StateHub)| async move {
        listen(stream, &*backend, &hub).await
    };
    serve_sessions(listener, meter, shutdown, (backend, hub), session).await;
}

/// Sends states and messages until the connection breaks.
async fn listen(
    stream: impl AsyncRead + AsyncWrite,
    backend: &impl PrimaryBackend,
    hub: &StateHub,
) -> io::Result<()> {
    let (mut reader, mut writer) = tokio::io::split(stream);
    let dropping = async {
        let mut dropped = [0; READ_BYTES];
        while matches!(reader.read(&mut dropped).await, Ok(1..)) {}
        std::future::pending().await
    };
    tokio::select! {
        ended = dropping => ended,
        error = session::write_messages(&mut writer, None, hub.subscribe(backend)) => Err(error),
    }
}
