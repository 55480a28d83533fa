//! Port 40011: a question in one line, its answer in one line. There is no greeting, and nothing comes unasked.
//!
//! Owns the lines and their order; what a statement is worth is found out behind [`Answering`].

pub mod codec;

use std::io;
use std::sync::Arc;

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;

use crate::ports::lines::{Line, LineFramer};
use crate::ports::listen::{PortMeter, serve_sessions};
use codec::{Failure, LINE_BYTES_MAX, answer, parse};

/// What is read at once.
const READ_BYTES: usize = 16 * 1024;

/// What this port asks of the controller.
pub trait Answering: Send + Sync + 'static {
    /// What a line of script is worth, in Python's notation, floats with six decimals.
    fn evaluate(&self, statement: &str) -> impl Future<Output = Result<String, Failure>> + Send;
}

/// Serves the port until `shutdown`; returns when every client is closed.
pub async fn serve<A: Answering>(
    listener: TcpListener,
    controller: Arc<A>,
    meter: PortMeter,
    shutdown: CancellationToken,
) {
    let answering =
        |stream, _, controller: Arc<A>| async move { session(stream, &*controller).await };
    serve_sessions(listener, meter, shutdown, controller, answering).await;
}

/// Answers one client, in the order of its questions, until it sends no more. What it sends ahead waits in its socket.
///
/// # Errors
/// The connection broke.
pub async fn session(
    mut stream: impl AsyncRead + AsyncWrite + Unpin,
    controller: &impl Answering,
) -> io::Result<()> {
    let mut framer = LineFramer::new(LINE_BYTES_MAX);
    let mut buffer = vec![0; READ_BYTES];
    loop {
        let count = stream.read(&mut buffer).await?;
        if count == 0 {
            return Ok(());
        }
        let mut lines = Vec::new();
        framer.push(&buffer[..count], &mut lines);
        for line in lines {
            let request = match &line {
                Line::Text(text) => parse(text),
                Line::TooLong => None,
            };
            let value = match &request {
                Some(request) => controller.evaluate(&request.statement).await,
                None => Err(Failure::Parse),
            };
            let answer = answer(request.map(|request| request.id), &value);
            // One write: clients take what the first read brings.
            stream.write_all(answer.as_bytes()).await?;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::io::duplex;

    struct Echo;

    impl Answering for Echo {
        async fn evaluate(&self, statement: &str) -> Result<String, Failure> {
            match statement {
                "bad(" => Err(Failure::Parse),
                "1/0" => Err(Failure::Execute),
                other => Ok(other.to_owned()),
            }
        }
    }

    #[tokio::test]
    async fn every_line_is_answered_in_its_order() {
        let (mut client, server) = duplex(1 << 20);
        let text = "req 1 a\nreq 2 bad(\r\nreq 3 1/0\nhello\n\nreq 4 [1, 2]\nreq 5 half";
        client.write_all(text.as_bytes()).await.unwrap();
        let long = format!("{}\nreq 6 b\n", "x".repeat(LINE_BYTES_MAX));
        client.write_all(long.as_bytes()).await.unwrap();
        client.shutdown().await.unwrap();
        session(server, &Echo).await.unwrap();
        let mut answers = String::new();
        client.read_to_string(&mut answers).await.unwrap();
        assert_eq!(
            answers,
            "[1] [success] : [a]\n[2] [failure] : [parse failed]\n[3] [failure] : [execute failed]\n\
             [-1] [failure] : [parse failed]\n[4] [success] : [[1, 2]]\n[-1] [failure] : [parse failed]\n\
             [6] [success] : [b]\n"
        );
    }
}
