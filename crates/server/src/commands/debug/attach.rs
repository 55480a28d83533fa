//! `attach`: a connection to the debugger's channel of a server, `/api/v1/debug`.
//!
//! Owns the connection, on a thread of its own; the session passes messages on.

use std::sync::mpsc::sync_channel;
use std::time::Duration;

use editor::dap::{RemoteSender, RemoteSink};
use futures_util::{SinkExt as _, StreamExt as _};
use messages::{Text, text};
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
pub(super) fn attach(arguments: &Json, inbox: RemoteSender) -> Result<RemoteSink, Text> {
    let server = server(arguments)?;
    let (sender, waiting) = mpsc::channel::<String>(WAITING_MAX);
    let (tell, connected) = sync_channel(1);
    let body = move || {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build();
        match runtime {
            Ok(runtime) => runtime.block_on(serve(server, inbox, waiting, &tell)),
            Err(error) => drop(tell.send(Err(Text::of(&error)))),
        }
    };
    ThreadSupervisor::default()
        .start(ThreadRole::Service, "attach", body)
        .map_err(|error| {
            text!(
                "the operating system gives no thread: {error}",
                "操作系统没有提供线程：{error}"
            )
        })?;
    let lost = |_| text!("the connection broke", "连接已断开");
    connected.recv().map_err(lost)??;
    Ok(Box::new(move |message| {
        sender.try_send(message.to_string()).is_ok()
    }))
}

fn server(arguments: &Json) -> Result<ServerAddress, Text> {
    let fields = arguments.as_object();
    let is_known = |key: &str| KEYS.contains(&key) || super::launch::is_of_client(key);
    let mut keys = fields.into_iter().flat_map(|fields| fields.keys());
    if let Some(key) = keys.find(|key| !is_known(key)) {
        let known = KEYS.join(", ");
        return Err(text!(
            "attach knows no key {key:?}; there are {known}",
            "attach 没有键 {key:?}；有 {known}"
        ));
    }
    let text = |key: &str| match arguments.get(key) {
        None | Some(Json::Null) => Ok(None),
        Some(Json::String(text)) => Ok(Some(text.clone())),
        Some(other) => Err(text!(
            "{key} is {other}; a text is needed",
            "{key} 为 {other}；需要文本"
        )),
    };
    let port = match arguments.get("http-port") {
        None | Some(Json::Null) => 8080,
        Some(given) => given
            .as_u64()
            .and_then(|port| u16::try_from(port).ok())
            .filter(|port| *port > 0)
            .ok_or_else(|| {
                text!(
                    "http-port is {given}; a number from 1 to 65535 is needed",
                    "http-port 为 {given}；需要 1 到 65535 的数"
                )
            })?,
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

    async fn connect(&self) -> Result<TcpStream, Text> {
        let place = self.place();
        let connecting = TcpStream::connect((self.address.as_str(), self.port));
        match tokio::time::timeout(PATIENCE, connecting).await {
            Ok(Ok(stream)) => Ok(stream),
            Ok(Err(error)) => Err(text!(
                "cannot connect to the server at {place}: {error}",
                "无法连接到 {place} 的服务器：{error}"
            )),
            Err(_) => Err(text!(
                "the server at {place} does not answer",
                "{place} 的服务器没有应答"
            )),
        }
    }

    /// The token that the server gives to whoever asks on its own machine.
    async fn ask_token(&self) -> Result<Option<String>, Text> {
        let place = self.place();
        let wrong = |why: Text| {
            text!(
                "the server at {place} is none of ours: {why}",
                "{place} 的服务器不是我们的：{why}"
            )
        };
        let asking = async {
            let mut stream = self.connect().await?;
            let request = format!(
                "GET /api/v1/session HTTP/1.1\r\nHost: {place}\r\nConnection: close\r\n\r\n"
            );
            let sent = stream.write_all(request.as_bytes()).await;
            sent.map_err(|error| wrong(Text::of(&error)))?;
            let mut answer = String::new();
            let reading = stream
                .take(SESSION_BYTES_MAX)
                .read_to_string(&mut answer)
                .await;
            reading.map_err(|error| wrong(Text::of(&error)))?;
            let (head, body) = answer
                .split_once("\r\n\r\n")
                .ok_or_else(|| wrong(text!("it does not speak HTTP", "它不使用 HTTP")))?;
            if !head.starts_with("HTTP/1.1 200") {
                let line = head.lines().next().unwrap_or_default().to_owned();
                return Err(wrong(text!("it says {line:?}", "它回答 {line:?}")));
            }
            let session: Json = serde_json::from_str(body.trim())
                .map_err(|_| wrong(text!("it has no /api/v1/session", "它没有 /api/v1/session")))?;
            Ok(session
                .get("token")
                .and_then(Json::as_str)
                .map(str::to_owned))
        };
        let late = |_| {
            text!(
                "the server at {place} does not answer",
                "{place} 的服务器没有应答"
            )
        };
        tokio::time::timeout(PATIENCE, asking).await.map_err(late)?
    }
}

/// Passes messages on until one end is gone.
async fn serve(
    server: ServerAddress,
    inbox: RemoteSender,
    mut waiting: mpsc::Receiver<String>,
    tell: &std::sync::mpsc::SyncSender<Result<(), Text>>,
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
            .map_err(|_| {
                text!(
                    "the server at {place} does not answer",
                    "{place} 的服务器没有应答"
                )
            })?
            .map_err(|error| {
                text!(
                    "the server at {place} has no debugger's channel: {error}",
                    "{place} 的服务器没有调试通道：{error}"
                )
            })?;
        if let Some(token) = token {
            let first = json!({ "token": token }).to_string();
            let sent = socket.send(Message::text(first)).await;
            sent.map_err(|error| {
                text!(
                    "the connection to {place} broke: {error}",
                    "与 {place} 的连接断开：{error}"
                )
            })?;
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
