//! The serial line at the tool as a TCP port: bytes both ways, for software of grippers that expects a forwarded line.
//!
//! The line has the settings that a program has given it; without any, and while a program speaks Modbus RTU on it, a client is
//! turned away with a line in the log. One client at a time: bytes of two would mix.

use std::sync::Arc;

use io_bus::Fieldbus;
use tokio::io::{copy_bidirectional, duplex};
use tokio::net::TcpListener;
use tokio::sync::Mutex;
use tokio_util::sync::CancellationToken;

use crate::ports::listen::{PortMeter, serve_port};
use crate::ports::peer::Speaks;

/// Bytes on their way between the port and the line, in each direction.
const BYTES_UNDER_WAY: usize = 16 * 1024;

/// Serves the port until `shutdown`; returns when every client is closed.
pub async fn serve(
    listener: TcpListener,
    fieldbus: Arc<Fieldbus>,
    meter: PortMeter,
    shutdown: CancellationToken,
) {
    let in_use = Arc::new(Mutex::new(()));
    serve_port(
        listener,
        Speaks::Its,
        meter,
        shutdown,
        |mut stream, _client, shutdown| {
            let (fieldbus, in_use) = (Arc::clone(&fieldbus), Arc::clone(&in_use));
            async move {
                let Ok(_in_use) = in_use.try_lock() else {
                    tracing::warn!("refused: another client uses the serial line");
                    return;
                };
                let (mut here, there) = duplex(BYTES_UNDER_WAY);
                let forwarding = async {
                    tokio::select! {
                        // The client is gone, or has closed its half: the line is not its own any more.
                        _ = copy_bidirectional(&mut stream, &mut here) => {}
                        ended = fieldbus.tool_serial.forward(there) => {
                            if let Err(error) = ended {
                                tracing::warn!("closed: {error}");
                            }
                        }
                    }
                };
                shutdown.run_until_cancelled(forwarding).await;
            }
        },
    )
    .await;
}
