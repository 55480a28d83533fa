//! Port 30001, the primary interface: scripts in; robot state, script errors and robot errors out.
//!
//! Owns the wire format, the cutting of text into programs and the clients. What a program does, and whether it may run
//! now, is decided behind [`PrimaryBackend`].

pub mod framing;
pub mod hub;
pub mod session;
pub mod state_message;

use std::fmt;
use std::net::SocketAddr;
use std::sync::Arc;

use tokio::net::TcpListener;
use tokio::sync::watch;
use tokio_util::sync::CancellationToken;

use crate::ports::ClientId;
use crate::ports::description::{RobotDescription, ToolSerial};
use crate::ports::listen::{PortMeter, serve_port};
use crate::ports::peer::PortProtocol;
use crate::ports::sample::Sample;
use framing::{ControlPhrase, ReceivedProgram};
pub use hub::StateHub;

/// A client of this port, and where it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sender {
    /// The client that sent the text.
    pub client: ClientId,
    /// Address of the client; `None` for a stream without one.
    pub address: Option<SocketAddr>,
}

impl From<ClientId> for Sender {
    fn from(client: ClientId) -> Self {
        let address = None;
        Self { client, address }
    }
}

impl fmt::Display for Sender {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.address {
            Some(address) => write!(f, "{address} on the primary port"),
            None => write!(f, "client {} of the primary port", self.client),
        }
    }
}

/// A program with its sender.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Submission {
    /// The client that sent the program.
    pub sender: Sender,
    /// The program.
    pub program: ReceivedProgram,
}

/// What this port asks of the controller. Errors of programs come back through the [`StateHub`]: there is no reply to a
/// script on this port.
pub trait PrimaryBackend: Send + Sync + 'static {
    /// One cycle in a tenth of a second, to be shown to every client.
    fn beats(&self) -> watch::Receiver<Option<Arc<Sample>>>;
    /// The controller as it is now.
    fn sample(&self) -> Sample;
    /// The arm; the same values every time.
    fn description(&self) -> &RobotDescription;
    /// The serial port of the tool, if it is configured. The cycle knows nothing of it.
    fn tool_serial(&self) -> Option<ToolSerial>;
    /// Returns when, and as soon as, no client may be connected: in local control mode.
    fn closed_to_clients(&self) -> impl Future<Output = ()> + Send;
    /// The controller's time for messages, ms since 1970.
    fn unix_millis(&self) -> u64;
    /// True when the text parses as it stands. Asked only when a client fell silent in the middle of a block.
    fn is_whole_program(&self, text: String) -> impl Future<Output = bool> + Send;
    /// Compiles and starts a program or announces why not. Returns when the program has been taken over, not when it
    /// has run; until then the sender's next program waits.
    fn submit(&self, submission: Submission) -> impl Future<Output = ()> + Send;
    /// Carries out an order, or announces why not.
    fn control(&self, client: ClientId, phrase: ControlPhrase) -> impl Future<Output = ()> + Send;
    /// An order that makes things stand still has come in behind others of the same client: what runs may end or be
    /// held already. Must not wait. The order itself follows in its turn.
    fn preempt(&self, phrase: ControlPhrase);
}

/// Serves the port until `shutdown`; returns when every client is closed. States are published by whoever has the hub.
pub async fn serve<B: PrimaryBackend>(
    listener: TcpListener,
    backend: Arc<B>,
    hub: StateHub,
    meter: PortMeter,
    shutdown: CancellationToken,
) {
    serve_port(
        listener,
        PortProtocol::Native,
        meter,
        shutdown,
        |stream, client, shutdown| {
            let (backend, hub) = (Arc::clone(&backend), hub.clone());
            async move {
                let address = stream.address();
                let sender = Sender { client, address };
                session::serve(stream, sender, &*backend, &hub, shutdown).await;
            }
        },
    )
    .await;
}
