//! The debugger's channel: the Debug Adapter Protocol over a WebSocket, a message a text, and what pages are shown of
//! it.
//!
//! Owns the connection; sessions and who drives are in `editor::dap`. A session has a thread of its own, which waits
//! for nothing but its client.

use std::io;
use std::time::Duration;

use editor::dap::stream::MessageSink;
use editor::dap::{AttachedSession, SessionSender};
use futures_util::{SinkExt as _, StreamExt as _};
use hyper::upgrade::OnUpgrade;
use hyper_util::rt::TokioIo;
use messages::Text;
use serde_json::{Value, json};
use supervision::{ThreadRole, ThreadSupervisor};
use tokio::sync::mpsc;
use tokio::time::{MissedTickBehavior, interval};
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::tungstenite::protocol::{Role, WebSocketConfig};
use tokio_util::sync::CancellationToken;

use super::{Page, PageBackend};

/// Path of the channel.
pub const DEBUG_PATH: &str = "/api/v1/debug";

/// Longest message of a client, bytes.
const MESSAGE_BYTES_MAX: usize = 4 << 20;
/// Messages that wait for a client; its session waits with them.
const WAITING_MAX: usize = 256;
/// Pages are told this often at most.
const SHOWN_EVERY: Duration = Duration::from_millis(100);

/// Serves one client until it leaves or the server ends.
pub async fn attend<C: PageBackend>(
    page: &Page<C>,
    upgrade: OnUpgrade,
    shutdown: &CancellationToken,
) {
    let Some(hub) = page.cockpit.debuggers().cloned() else {
        return;
    };
    let stream = match upgrade.await {
        Ok(stream) => stream,
        Err(error) => {
            tracing::debug!(%error, "debugger: the connection broke in the handshake");
            return;
        }
    };
    let config = WebSocketConfig::default()
        .max_message_size(Some(MESSAGE_BYTES_MAX))
        .max_frame_size(Some(MESSAGE_BYTES_MAX));
    let socket =
        WebSocketStream::from_raw_socket(TokioIo::new(stream), Role::Server, Some(config)).await;
    let (mut sink, mut source) = socket.split();
    // Who it is comes first.
    let first = tokio::select! {
        () = shutdown.cancelled() => return,
        first = source.next() => first,
    };
    let Some(Ok(Message::Text(first))) = first else {
        return;
    };
    let given = token_of(&first);
    if given.as_ref().is_some_and(|given| !page.token().is(given)) {
        let event = json!({"type": "event", "event": "output", "seq": 1, "body": {
            "category": "important", "output": "the token is wrong; this connection ends\n",
        }});
        // An error changes nothing: the connection is closed in any case.
        let _ = sink.send(Message::text(event.to_string())).await;
        let _ = sink.close().await;
        return;
    }
    let (session, inlet) = AttachedSession::new(hub, given.is_some());
    let (sender, mut out) = mpsc::channel(WAITING_MAX);
    let body = move || session.serve(&mut Texts(sender));
    let serving = ThreadSupervisor::default().start(ThreadRole::Service, "attached debugger", body);
    if let Err(error) = serving {
        tracing::warn!("debugger: the operating system gives no thread: {error}");
        return;
    }
    if given.is_none() && !inlet.message(&first) {
        return;
    }
    let (mut lines, _) = page.cockpit.subscribe_messages();
    loop {
        tokio::select! {
            () = shutdown.cancelled() => break,
            text = out.recv() => match text {
                Some(text) => if sink.send(Message::text(text)).await.is_err() { break },
                None => break,
            },
            line = lines.recv() => {
                if let Ok(line) = line {
                    inlet.output("console", Text::verbatim(format!("{}: {}\n", line.source, line.text)));
                }
            },
            said = source.next() => if !pass_on(said, &inlet) { break },
        }
    }
    // The session's thread ends with the next event that it hears or tells.
    drop(out);
    inlet.gone();
    // A client that is gone already needs no farewell.
    let _ = sink.close().await;
}

/// False when the client has left, or says more than is taken.
fn pass_on(
    said: Option<Result<Message, tokio_tungstenite::tungstenite::Error>>,
    inlet: &SessionSender,
) -> bool {
    match said {
        Some(Ok(Message::Text(text))) => inlet.message(&text),
        Some(Ok(Message::Ping(_) | Message::Pong(_) | Message::Frame(_))) => true,
        Some(Ok(Message::Binary(_) | Message::Close(_)) | Err(_)) | None => false,
    }
}

/// The token that a first message shows, if it is one.
fn token_of(text: &str) -> Option<String> {
    let message: Value = serde_json::from_str(text).ok()?;
    let token = message.get("token")?.as_str()?;
    message.get("type").is_none().then(|| token.to_owned())
}

/// Messages as texts, to the task that writes them.
struct Texts(mpsc::Sender<String>);

impl MessageSink for Texts {
    fn message(&mut self, message: &Value) -> io::Result<()> {
        let sent = self.0.blocking_send(message.to_string());
        sent.map_err(|_| io::ErrorKind::BrokenPipe.into())
    }
}

/// Tells pages who debugs, where the program is held, and the breakpoints, as they change.
pub async fn tell<C: PageBackend>(page: &Page<C>, shutdown: &CancellationToken) {
    let Some(hub) = page.cockpit.debuggers() else {
        return;
    };
    let mut ticks = interval(SHOWN_EVERY);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    let mut told = hub.changes();
    loop {
        tokio::select! {
            () = shutdown.cancelled() => return,
            _ = ticks.tick() => {}
        }
        let changes = hub.changes();
        if changes != told {
            told = changes;
            let event = json!({"event": "debug", "debug": hub.shown()});
            page.stage.tell(event.to_string().into());
        }
    }
}
