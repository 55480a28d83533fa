//! The port of the controller's own Modbus server: accepts clients, `io-bus` talks with them.

use std::sync::Arc;

use elite_runtime::Robot;
use elite_runtime::port_map::ClientMap;
use io_bus::Fieldbus;
use io_bus::modbus_server::{self, map::Map};
use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;

use crate::ports::listen::{PortMeter, serve_sessions};

/// Serves the port until `shutdown`; returns when every client is closed.
pub async fn serve(
    listener: TcpListener,
    fieldbus: Arc<Fieldbus>,
    robot: Arc<Robot>,
    meter: PortMeter,
    shutdown: CancellationToken,
) {
    let session = |stream, _, (fieldbus, robot): (Arc<Fieldbus>, Arc<Robot>)| async move {
        let map = Map(ClientMap {
            robot: &robot,
            image: &fieldbus.port_image,
        });
        modbus_server::serve(stream, &map).await
    };
    serve_sessions(listener, meter, shutdown, (fieldbus, robot), session).await;
}
