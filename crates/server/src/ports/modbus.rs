//! The port of the controller's own Modbus server: accepts clients, `io-bus` talks with them.

use std::sync::Arc;

use io_bus::{PortImage, modbus_server};
use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;

use crate::ports::listen::{PortMeter, serve_port};

/// Serves the port until `shutdown`; returns when every client is closed.
pub async fn serve(
    listener: TcpListener,
    image: Arc<PortImage>,
    meter: PortMeter,
    shutdown: CancellationToken,
) {
    serve_port(listener, meter, shutdown, |stream, client, shutdown| {
        let image = Arc::clone(&image);
        async move {
            let conversation = modbus_server::serve(stream, &image);
            if let Some(Err(ended)) = shutdown.run_until_cancelled(conversation).await {
                tracing::debug!(%client, "modbus: {ended}");
            }
        }
    })
    .await;
}
