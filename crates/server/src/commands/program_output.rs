//! What a program on a controller of ours prints: lines of its log, from the live view of `/api/v1`. Other controllers
//! show it on their pendant.

use std::time::Duration;

use futures_util::StreamExt as _;
use robot_client::RobotAddress;
use serde_json::Value as Json;
use tokio::net::TcpStream;
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::Message;

use crate::language;

/// A server that does not answer within this shows nothing.
const PATIENCE: Duration = Duration::from_secs(2);
/// Errors come on port 30001, with their report; lines below this level are the program's own.
const ERROR_LEVEL: u64 = 4;

/// Lines of a controller's log.
pub(crate) struct ProgramOutput {
    socket: Option<Box<WebSocketStream<TcpStream>>>,
    /// What the lines of the program name as their source.
    source: String,
}

impl ProgramOutput {
    /// Follows the program of this name on the controller at `address`, the http port included; what comes of it is
    /// silence where no controller of ours is.
    pub(crate) async fn connect(address: Option<&RobotAddress>, source: &str) -> Self {
        let socket = match address {
            Some(address) => tokio::time::timeout(PATIENCE, live(address))
                .await
                .ok()
                .flatten(),
            None => None,
        };
        Self {
            socket,
            source: source.to_owned(),
        }
    }

    /// Whether there is a controller that tells.
    pub(crate) const fn is_connected(&self) -> bool {
        self.socket.is_some()
    }

    /// The next line of the program; never comes where nobody tells.
    pub(crate) async fn next(&mut self) -> String {
        loop {
            let Some(socket) = &mut self.socket else {
                return std::future::pending().await;
            };
            match socket.next().await {
                Some(Ok(Message::Text(text))) => {
                    if let Some(line) = self.line(&text) {
                        return line;
                    }
                }
                // Frames of the arm.
                Some(Ok(_)) => {}
                Some(Err(_)) | None => self.socket = None,
            }
        }
    }

    fn line(&self, text: &str) -> Option<String> {
        let event: Json = serde_json::from_str(text).ok()?;
        let of = |key: &str| event.get(key).and_then(Json::as_str);
        let is_line = of("event") == Some("log") && of("source") == Some(self.source.as_str());
        let level = event.get("level").and_then(Json::as_u64)?;
        let line = of("text").filter(|_| is_line && level < ERROR_LEVEL)?;
        (line != controller::recording_observer::PROGRAM_ENDED).then(|| line.to_owned())
    }
}

async fn live(address: &RobotAddress) -> Option<Box<WebSocketStream<TcpStream>>> {
    let stream = address.connect().await.ok()?;
    let url = format!("ws://{address}/api/v1/live");
    let (socket, _) = tokio_tungstenite::client_async(url, stream).await.ok()?;
    Some(Box::new(socket))
}

/// Where to look for what a program prints on a controller that does not tell.
pub(crate) fn elsewhere() -> &'static str {
    language::pick(
        "what the program prints is in the log of the robot's pendant; eliteserver shows it here with --http-port",
        "程序打印的内容在机器人示教器的日志中；eliteserver 用 --http-port 在这里显示",
    )
}

/// Whether the text of a program prints at all.
pub(crate) fn prints(text: &str) -> bool {
    text.contains("print") || text.contains("textmsg")
}
