//! The ports of grippers on Modbus TCP, as the cell file names them: loopback only.

use std::sync::Arc;

use io_bus::modbus_server::{self, tables::Slaves};
use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;

use crate::ports::listen::{PortMeter, serve_sessions};

/// Serves the grippers behind one port until `shutdown`; returns when every client is closed.
pub async fn serve(
    listener: TcpListener,
    slaves: Arc<Slaves>,
    meter: PortMeter,
    shutdown: CancellationToken,
) {
    let session = |stream, _, slaves: Arc<Slaves>| async move {
        modbus_server::serve_slaves(stream, &slaves).await
    };
    serve_sessions(listener, meter, shutdown, slaves, session).await;
}
