//! The serial line at the tool as a TCP port: bytes both ways, for software of grippers that expects a forwarded line.
//!
//! The line has the settings that a program has given it; without any, and while a program speaks Modbus RTU on it, a
//! client is turned away with a line in the log. One client at a time: bytes of two would mix.

use std::io;
use std::sync::Arc;

use io_bus::Fieldbus;
use tokio::io::{copy_bidirectional, duplex};
use tokio::net::TcpListener;
use tokio::sync::Mutex;
use tokio_util::sync::CancellationToken;

use crate::ports::ClientId;
use crate::ports::listen::{PortMeter, serve_sessions};
use crate::ports::peer::Peer;

/// Bytes on their way between the port and the line, in each direction.
const BYTES_UNDER_WAY: usize = 16 * 1024;

/// Serves the port until `shutdown`; returns when every client is closed.
pub async fn serve(
    listener: TcpListener,
    fieldbus: Arc<Fieldbus>,
    meter: PortMeter,
    shutdown: CancellationToken,
) {
    let share = (fieldbus, Arc::new(Mutex::new(())));
    serve_sessions(listener, meter, shutdown, share, forward).await;
}

/// Carries bytes between one client and the line.
async fn forward(
    mut stream: Peer,
    _: ClientId,
    (fieldbus, in_use): (Arc<Fieldbus>, Arc<Mutex<()>>),
) -> io::Result<()> {
    let Ok(_in_use) = in_use.try_lock() else {
        tracing::warn!("refused: another client uses the serial line");
        return Ok(());
    };
    let (mut here, there) = duplex(BYTES_UNDER_WAY);
    tokio::select! {
        // The client is gone, or has closed its half: the line is not its own any more.
        ended = copy_bidirectional(&mut stream, &mut here) => ended.map(|_bytes| ()),
        ended = fieldbus.tool_serial.forward(there) => {
            if let Err(error) = ended {
                tracing::warn!("closed: {error}");
            }
            Ok(())
        }
    }
}
