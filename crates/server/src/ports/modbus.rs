//! The port of the controller's own Modbus server: accepts clients, `io-bus` talks with them.

use std::sync::Arc;

use elite_runtime::Robot;
use io_bus::modbus_server::state_map::Controller;
use io_bus::{PortImage, modbus_server};
use motion_api::{CommandKind, IoChange, Origin, Registers, RobotState};
use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;

use crate::ports::listen::{PortMeter, serve_port};
use crate::ports::peer::Speaks;

/// Serves the port until `shutdown`; returns when every client is closed.
pub async fn serve(
    listener: TcpListener,
    image: Arc<PortImage>,
    robot: Arc<Robot>,
    meter: PortMeter,
    shutdown: CancellationToken,
) {
    serve_port(
        listener,
        Speaks::Its,
        meter,
        shutdown,
        |stream, client, shutdown| {
            let image = Arc::clone(&image);
            let robot = RobotMap(Arc::clone(&robot));
            async move {
                let conversation = modbus_server::serve(stream, &image, Some(&robot));
                if let Some(Err(ended)) = shutdown.run_until_cancelled(conversation).await {
                    tracing::debug!(%client, "modbus: {ended}");
                }
            }
        },
    )
    .await;
}

/// The robot as the map from address 1000 on shows it.
struct RobotMap(Arc<Robot>);

impl Controller for RobotMap {
    fn state(&self) -> RobotState {
        self.0.state()
    }

    fn registers(&self) -> &Registers {
        self.0.registers()
    }

    fn change(&self, change: IoChange) -> bool {
        let kind = CommandKind::SetIo(change);
        self.0.send(Origin::default(), kind).is_ok()
    }
}
