//! Port 30004, RTSI: cyclic data in both directions.
//!
//! Owns packets, recipes, who writes which input, and clients. Values come in as one [`Sample`] a cycle; what clients
//! write goes out as [`Change`]s.

pub mod inputs;
pub mod outputs;
pub mod owners;
pub mod session;

use std::sync::Arc;

use motion_api::RingFull;
use tokio::net::TcpListener;
use tokio::sync::broadcast;
use tokio_util::sync::CancellationToken;

use crate::ports::ClientId;
use crate::ports::description::RobotDescription;
use crate::ports::listen::{PortMeter, serve_sessions};
use crate::ports::sample::Sample;
use inputs::{Change, InputVariable};
use owners::Owners;

/// What this port asks of the controller.
pub trait RtsiBackend: Send + Sync + 'static {
    /// The arm; the same values every time.
    fn description(&self) -> &RobotDescription;
    /// Every cycle's sample from now on, in order. A receiver that falls behind loses the oldest.
    fn samples(&self) -> broadcast::Receiver<Arc<Sample>>;
    /// The controller as it is now: repeated when no cycle comes.
    fn sample(&self) -> Sample;
    /// Reason why no client may write, where that is so; whoever sets up inputs is told.
    fn read_only(&self) -> Option<&'static str> {
        None
    }
    /// Makes changes in the next cycle, all of them or none. `written` are the variables that the package set, changed
    /// or not: watchdogs count them. Must not wait. Returns the first cycle that certainly has all of them.
    ///
    /// # Errors
    /// [`RingFull`]: nothing was changed, the controller has more to do than it can.
    fn apply(
        &self,
        client: ClientId,
        changes: &[Change],
        written: &[InputVariable],
    ) -> Result<u64, RingFull>;
}

/// Serves the port until `shutdown`; returns when every client is closed.
pub async fn serve<C: RtsiBackend>(
    listener: TcpListener,
    controller: Arc<C>,
    meter: PortMeter,
    shutdown: CancellationToken,
) {
    let session = |stream, client, (controller, owners): (Arc<C>, Owners)| async move {
        session::serve(stream, client, &*controller, &owners).await
    };
    let share = (controller, Owners::default());
    serve_sessions(listener, meter, shutdown, share, session).await;
}
