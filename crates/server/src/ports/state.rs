//! Port 30011: what port 30001 sends, and nothing in. It serves in every control mode.
//!
//! What a client sends is read and dropped, so that it cannot fill anything; one that has closed its half goes on listening.

use std::sync::Arc;

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite};
use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;

use super::primary::{Backend, Hub, session};
use crate::ports::ClientId;
use crate::ports::listen::{PortMeter, serve_port};
use crate::ports::peer::Speaks;

/// What is read, and dropped, at once.
const READ_BYTES: usize = 4096;

/// Serves the port until `shutdown`; returns when every client is closed.
pub async fn serve<B: Backend>(
    listener: TcpListener,
    backend: Arc<B>,
    hub: Hub,
    meter: PortMeter,
    shutdown: CancellationToken,
) {
    serve_port(
        listener,
        Speaks::Its,
        meter,
        shutdown,
        |stream, client, shutdown| {
            let (backend, hub) = (Arc::clone(&backend), hub.clone());
            async move {
                let session = listen(stream, client, &*backend, &hub);
                shutdown.run_until_cancelled(session).await;
            }
        },
    )
    .await;
}

/// Sends states and messages until the connection breaks.
async fn listen(
    stream: impl AsyncRead + AsyncWrite,
    client: ClientId,
    backend: &impl Backend,
    hub: &Hub,
) {
    let (mut reader, mut writer) = tokio::io::split(stream);
    let dropping = async {
        let mut dropped = [0; READ_BYTES];
        while matches!(reader.read(&mut dropped).await, Ok(1..)) {}
        std::future::pending::<()>().await;
    };
    tokio::select! {
        () = dropping => {}
        error = session::write_messages(&mut writer, None, hub.subscribe(backend)) => {
            tracing::debug!(%client, %error, "state: the client is gone");
        }
    }
}
