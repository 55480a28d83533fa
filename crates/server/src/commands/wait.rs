//! `eliteserver wait`: returns once a running server answers with a state message.

use std::net::SocketAddr;
use std::time::Duration;

use messages::{Localized, Text, text};
use thiserror::Error;
use tokio::io::AsyncReadExt;
use tokio::net::TcpStream;
use tokio::time::{sleep, timeout};

use crate::cli::WaitArgs;
use crate::command::{CommandError, CommandResult, CommandStatus};
use wire::primary::ROBOT_STATE;

/// Between two attempts.
const RETRY: Duration = Duration::from_millis(20);

/// One attempt takes at most this long: whatever listens there sends its state within 100 ms.
const ATTEMPT: Duration = Duration::from_secs(1);

/// No server answered.
#[derive(Debug, Error, Localized)]
#[error("no server answered on {address} within {} s: {reason}", waited.as_secs_f64())]
#[zh("{address} 上没有服务器在 {} s 内应答：{reason}", waited.as_secs_f64())]
pub struct NoAnswer {
    address: SocketAddr,
    waited: Duration,
    reason: Text,
}

/// The command: exit status 0 once a server answers, 1 with a sentence on stderr when none did in time.
pub fn run(args: &WaitArgs) -> CommandResult {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build();
    let answered = match runtime {
        Ok(runtime) => runtime
            .block_on(wait(SocketAddr::new(args.host, args.port), args.timeout))
            .map_err(CommandError::from),
        Err(error) => Err(CommandError::sentence(text!(
            "cannot wait: {error}",
            "无法等待：{error}"
        ))),
    };
    match answered {
        Ok(()) => Ok(CommandStatus::Success),
        Err(error) => Err(error.with_status(CommandStatus::Negative)),
    }
}

/// Waits until the primary port at `address` sends a state message, at most `patience`.
pub async fn wait(address: SocketAddr, patience: Duration) -> Result<(), NoAnswer> {
    let mut reason = text!("there was no time to try", "没有时间尝试");
    let attempts = async {
        loop {
            match timeout(ATTEMPT, first_message(address)).await {
                Ok(Ok(ROBOT_STATE)) => return,
                Ok(Ok(kind)) => {
                    reason = text!(
                        "something else listens there (message type {kind})",
                        "那里监听的是其他程序（消息类型 {kind}）"
                    );
                }
                Ok(Err(error)) => reason = Text::of(&error),
                Err(_elapsed) => {
                    reason = text!(
                        "something listens there but sends no robot state",
                        "那里有程序监听，但不发送机器人状态"
                    );
                }
            }
            sleep(RETRY).await;
        }
    };
    timeout(patience, attempts).await.map_err(|_| NoAnswer {
        address,
        waited: patience,
        reason,
    })
}

/// The type of the first message that the port sends.
async fn first_message(address: SocketAddr) -> std::io::Result<u8> {
    let mut stream = TcpStream::connect(address).await?;
    let mut head = [0; 5];
    stream.read_exact(&mut head).await?;
    Ok(head[4])
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::io::AsyncWriteExt;
    use tokio::net::TcpListener;

    async fn listener() -> (TcpListener, SocketAddr) {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        (listener, address)
    }

    #[tokio::test]
    async fn it_returns_once_a_state_message_begins() {
        let (held, address) = listener().await;
        drop(held); // nobody listens yet
        let waiting = tokio::spawn(wait(address, Duration::from_secs(20)));
        sleep(Duration::from_millis(30)).await;
        let listener = TcpListener::bind(address).await.unwrap();
        let (mut stream, _) = listener.accept().await.unwrap();
        stream.write_all(&[0, 0, 4, 0x85, 16]).await.unwrap();
        waiting.await.unwrap().unwrap();
    }

    #[tokio::test]
    async fn the_reason_is_named_when_nobody_answers() {
        let (held, address) = listener().await;
        drop(held);
        let error = wait(address, Duration::from_millis(50)).await.unwrap_err();
        let text = error.to_string();
        assert!(
            text.starts_with(&format!("no server answered on {address} within 0.05 s: ")),
            "{text}"
        );
        assert!(text.contains("refused"), "{text}");
    }

    #[tokio::test]
    async fn another_program_on_the_port_is_no_server() {
        let (listener, address) = listener().await;
        let other = tokio::spawn(async move {
            while let Ok((mut stream, _)) = listener.accept().await {
                let _ = stream.write_all(b"HTTP/1.1 400 Bad Request\r\n\r\n").await;
            }
        });
        let error = wait(address, Duration::from_millis(80)).await.unwrap_err();
        assert!(
            error.to_string().contains("something else listens there"),
            "{error}"
        );
        other.abort();
    }
}
