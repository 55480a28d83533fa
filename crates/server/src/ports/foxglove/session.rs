//! One client of the Foxglove port: the handshake, then what it follows, as it happens.
//!
//! Messages go to all clients through one channel of the port; a client that is behind loses the oldest and holds up
//! nobody. So a connection holds no more than what it is sent at the moment.

use futures_util::{SinkExt as _, StreamExt as _};
use hyper::upgrade::Upgraded;
use hyper_util::rt::TokioIo;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::sync::broadcast::error::RecvError;
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::protocol::{Role, WebSocketConfig};
use tokio_tungstenite::tungstenite::{Error, Message};
use tokio_util::sync::CancellationToken;

use super::protocol::{
    MESSAGE_BYTES_MAX, SUBPROTOCOLS, Subscriptions, answer_to, message_data, time,
};
use super::{FoxgloveBroadcast, Packet, TOPICS};
use crate::ports::allowed_hosts::AllowedHosts;
use crate::ports::http::connection;
use crate::ports::peer::Peer;
use crate::ports::websocket::Upgrade;

/// Serves one client until it leaves or the server ends.
pub(super) async fn serve<S>(
    peer: Peer<S>,
    callers: &AllowedHosts,
    stage: &FoxgloveBroadcast,
    shutdown: &CancellationToken,
) where
    S: AsyncRead + AsyncWrite + Unpin + Send + 'static,
{
    let upgrade = Upgrade::default();
    connection::serve(peer, callers, shutdown, |request| {
        let response = upgrade.shake_hands(request, &SUBPROTOCOLS);
        async { response }
    })
    .await;
    let Some(upgrade) = upgrade.take() else {
        return;
    };
    let ended = match upgrade.await {
        Ok(stream) => talk(stream, stage, shutdown).await,
        Err(error) => {
            tracing::debug!(%error, "foxglove: the connection broke in the handshake");
            return;
        }
    };
    if let Err(error) = ended {
        tracing::debug!(%error, "foxglove: the connection broke");
    }
}

type FoxgloveStream = WebSocketStream<TokioIo<Upgraded>>;

/// Shows what the client follows, and does what it says.
async fn talk(
    stream: Upgraded,
    stage: &FoxgloveBroadcast,
    shutdown: &CancellationToken,
) -> Result<(), Error> {
    let config = WebSocketConfig::default()
        .max_message_size(Some(MESSAGE_BYTES_MAX))
        .max_frame_size(Some(MESSAGE_BYTES_MAX))
        .read_buffer_size(16 * 1024)
        .write_buffer_size(0);
    let mut socket: FoxgloveStream =
        WebSocketStream::from_raw_socket(TokioIo::new(stream), Role::Server, Some(config)).await;
    let mut packets = stage.subscribe();
    for text in stage.greeting() {
        socket.send(Message::text(text.as_ref())).await?;
    }
    let mut following = ClientSubscriptions::new(stage);
    loop {
        tokio::select! {
            () = shutdown.cancelled() => return close(socket).await,
            said = socket.next() => match said {
                None => return Ok(()),
                Some(said) => match said? {
                    Message::Text(text) => {
                        if let Err(mistake) = following.take(&text) {
                            socket.send(Message::text(answer_to(&mistake))).await?;
                        }
                    }
                    // Publishing, services and parameters are not offered.
                    Message::Binary(_) => {
                        let answer = answer_to("nothing can be published here");
                        socket.send(Message::text(answer)).await?;
                    }
                    // Answered by the library: flushed, so that they leave before the next message of ours.
                    Message::Ping(_) | Message::Close(_) => socket.flush().await?,
                    Message::Pong(_) | Message::Frame(_) => {}
                },
            },
            packet = packets.recv() => match packet {
                Ok(packet) => following.show(&mut socket, &packet).await?,
                Err(RecvError::Lagged(missed)) => {
                    tracing::debug!(missed, "foxglove: the client reads too slowly and missed messages");
                }
                Err(RecvError::Closed) => return close(socket).await,
            },
        }
    }
}

async fn close(mut socket: FoxgloveStream) -> Result<(), Error> {
    socket.close(None).await
}

/// What a client follows; counted for the stage while it does.
struct ClientSubscriptions<'s> {
    stage: &'s FoxgloveBroadcast,
    subscriptions: Subscriptions,
}

impl<'s> ClientSubscriptions<'s> {
    fn new(stage: &'s FoxgloveBroadcast) -> Self {
        Self {
            stage,
            subscriptions: Subscriptions::default(),
        }
    }

    fn take(&mut self, text: &str) -> Result<(), String> {
        let was_empty = self.subscriptions.is_empty();
        let done = self.subscriptions.take(text, TOPICS.len());
        self.count(was_empty);
        if !self.subscriptions.is_empty() {
            self.stage.somebody_came();
        }
        done
    }

    fn count(&self, was_empty: bool) {
        match (was_empty, self.subscriptions.is_empty()) {
            (true, false) => self.stage.begin_following(),
            (false, true) => self.stage.end_following(),
            _ => {}
        }
    }

    async fn show(&self, socket: &mut FoxgloveStream, packet: &Packet) -> Result<(), Error> {
        match packet {
            Packet::Time(at) => socket.send(Message::binary(time(*at))).await,
            Packet::Message { place, at, payload } => {
                for subscription in self.subscriptions.to(*place) {
                    let bytes = message_data(subscription, *at, payload);
                    socket.send(Message::binary(bytes)).await?;
                }
                Ok(())
            }
        }
    }
}

impl Drop for ClientSubscriptions<'_> {
    fn drop(&mut self) {
        if !self.subscriptions.is_empty() {
            self.stage.end_following();
        }
    }
}
