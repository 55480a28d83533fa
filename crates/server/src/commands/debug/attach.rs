//! `attach`: a connection to the debugger's channel of a server, `/api/v1/debug`.
//!
//! Owns the connection, on a thread of its own; the session passes messages on.

use std::sync::mpsc::sync_channel;
use std::time::Duration;

use editor::dap::{RemoteSender, RemoteSink};
use futures_util::{SinkExt as _, StreamExt as _};
use serde_json::{Value as Json, json};
use supervision::{ThreadRole, ThreadSupervisor};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;
use tokio::sync::mpsc;
use tokio_tungstenite::tungstenite::Message;

/// Keys of `attach`.
const KEYS: [&str; 4] = ["address", "http-port", "token", "drive"];
/// A server that does not answer within this is none.
const PATIENCE: Duration = Duration::from_secs(5);
/// Longest answer to the question for the token, bytes.
const SESSION_BYTES_MAX: u64 = 64 * 1024;
/// Messages that may wait for the server.
const WAITING_MAX: usize = 1024;

/// Address of a server, and the token that is shown to it.
struct ServerAddress {
    address: String,
    port: u16,
    token: Option<String>,
}

/// Connects to the server that the arguments of `attach` name.
///
/// # Errors
/// A sentence.
pub(super) fn attach(arguments: &Json, inbox: RemoteSender) -> Result<RemoteSink, String> {
    let server = server(arguments)?;
    let (sender, waiting) = mpsc::channel::<String>(WAITING_MAX);
    let (tell, connected) = sync_channel(1);
    let body = move || {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build();
        match runtime {
            Ok(runtime) => runtime.block_on(serve(server, inbox, waiting, &tell)),
            Err(error) => drop(tell.send(Err(error.to_string()))),
        }
    };
    ThreadSupervisor::default()
        .start(ThreadRole::Service, "attach", body)
        .map_err(|error| format!("the operating system gives no thread: {error}"))?;
    let lost = |_| "the connection broke".to_owned();
    connected.recv().map_err(lost)??;
    Ok(Box::new(move |message| {
        sender.try_send(message.to_string()).is_ok()
    }))
}

fn server(arguments: &Json) -> Result<ServerAddress, String> {
    let fields = arguments.as_object();
    let is_known = |key: &str| KEYS.contains(&key) || super::launch::is_of_client(key);
    let mut keys = fields.into_iter().flat_map(|fields| fields.keys());
    if let Some(key) = keys.find(|key| !is_known(key)) {
        let known = KEYS.join(", ");
        return Err(format!("attach knows no key {key:?}; there are {known}"));
    }
    let text = |key: &str| match arguments.get(key) {
        None | Some(Json::Null) => Ok(None),
        Some(Json::String(text)) => Ok(Some(text.clone())),
        Some(other) => Err(format!("{key} is {other}; a text is needed")),
    };
    let port = match arguments.get("http-port") {
        None | Some(Json::Null) => 8080,
        Some(given) => given
            .as_u64()
            .and_then(|port| u16::try_from(port).ok())
            .filter(|port| *port > 0)
            .ok_or_else(|| format!("http-port is {given}; a number from 1 to 65535 is needed"))?,
    };
    Ok(ServerAddress {
        address: text("address")?.unwrap_or_else(|| "127.0.0.1".to_owned()),
        port,
        token: text("token")?,
    })
}

impl ServerAddress {
    fn place(&self) -> String {
        format!("{}:{}", self.address, self.port)
    }

    async fn connect(&self) -> Result<TcpStream, String> {
        let place = self.place();
        let connecting = TcpStream::connect((self.address.as_str(), self.port));
        match tokio::time::timeout(PATIENCE, connecting).await {
            Ok(Ok(stream)) => Ok(stream),
            Ok(Err(error)) => Err(format!("cannot connect to the server at {place}: {error}")),
            Err(_) => Err(format!("the server at {place} does not answer")),
        }
    }

    /// The token that the server gives to whoever asks on its own machine.
    async fn ask_token(&self) -> Result<Option<String>, String> {
        let place = self.place();
        let wrong = |why: String| format!("the server at {place} is none of ours: {why}");
        let asking = async {
            let mut stream = self.connect().await?;
            let request = format!(
                "GET /api/v1/session HTTP/1.1\r\nHost: {place}\r\nConnection: close\r\n\r\n"
            );
            let sent = stream.write_all(request.as_bytes()).await;
            sent.map_err(|error| wrong(error.to_string()))?;
            let mut answer = String::new();
            let reading = stream
                .take(SESSION_BYTES_MAX)
                .read_to_string(&mut answer)
                .await;
            reading.map_err(|error| wrong(error.to_string()))?;
            let (head, body) = answer
                .split_once("\r\n\r\n")
                .ok_or_else(|| wrong("it does not speak HTTP".to_owned()))?;
            if !head.starts_with("HTTP/1.1 200") {
                let line = head.lines().next().unwrap_or_default().to_owned();
                return Err(wrong(format!("it says {line:?}")));
            }
            let session: Json = serde_json::from_str(body.trim())
                .map_err(|_| wrong("it has no /api/v1/session".to_owned()))?;
            Ok(session
                .get("token")
                .and_then(Json::as_str)
                .map(str::to_owned))
        };
        let late = |_| format!("the server at {place} does not answer");
        tokio::time::timeout(PATIENCE, asking).await.map_err(late)?
    }
}

/// Passes messages on until one end is gone.
async fn serve(
    server: ServerAddress,
    inbox: RemoteSender,
    mut waiting: mpsc::Receiver<String>,
    tell: &std::sync::mpsc::SyncSender<Result<(), String>>,
) {
    let connecting = async {
        let token = match &server.token {
            Some(token) => Some(token.clone()),
            None => server.ask_token().await?,
        };
        let stream = server.connect().await?;
        let place = server.place();
        let url = format!("ws://{place}/api/v1/debug");
        let shaking = tokio_tungstenite::client_async(url, stream);
        let shaken = tokio::time::timeout(PATIENCE, shaking).await;
        let (mut socket, _) = shaken
            .map_err(|_| format!("the server at {place} does not answer"))?
            .map_err(|error| format!("the server at {place} has no debugger's channel: {error}"))?;
        if let Some(token) = token {
            let first = json!({ "token": token }).to_string();
            let sent = socket.send(Message::text(first)).await;
            sent.map_err(|error| format!("the connection to {place} broke: {error}"))?;
        }
        Ok(socket)
    };
    let socket = match connecting.await {
        Ok(socket) => socket,
        Err(error) => return drop(tell.send(Err(error))),
    };
    if tell.send(Ok(())).is_err() {
        return;
    }
    let (mut sink, mut source) = socket.split();
    let reason = loop {
        tokio::select! {
            text = waiting.recv() => match text {
                Some(text) => if let Err(error) = sink.send(Message::text(text)).await {
                    break Some(error.to_string());
                },
                None => break None,
            },
            said = source.next() => match said {
                Some(Ok(Message::Text(text))) => {
                    if let Ok(message) = serde_json::from_str(&text)
                        && !inbox.message(message)
                    {
                        break None;
                    }
                }
                Some(Ok(Message::Close(_))) | None => break Some("the server has closed the connection".to_owned()),
                Some(Ok(_)) => {}
                Some(Err(error)) => break Some(error.to_string()),
            },
        }
    };
    inbox.gone(reason);
    // The server may be gone already.
    let _ = sink.close().await;
}
