//! Messages as lines, one JSON object each: from standard input, to standard output.
//!
//! In place of the SDK's own lines, because a client hears of what it did wrong: a line that is no message, and one
//! that is too long, are answered with an error, with the number of the request where it can be read; the SDK drops
//! them, and whoever has sent such a request waits for ever. A thread of its own reads, so that nothing at the end
//! waits for a client that has nothing to say.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::sync::Arc;

use parking_lot::Mutex;
use rmcp::RoleServer;
use rmcp::model::{ClientJsonRpcMessage, ErrorData, RequestId, ServerJsonRpcMessage};
use rmcp::transport::Transport;
use serde_json::Value as Json;
use supervision::{ThreadRole, ThreadSupervisor};
use tokio::sync::mpsc::{Receiver, channel};

/// Longest message, bytes: a program of the longest kind, every character of it written as an escape.
const LINE_BYTES_MAX: usize = 64 << 20;

/// Messages that are read ahead.
const AHEAD_MAX: usize = 16;

/// What a line says.
#[derive(Debug)]
pub enum IncomingLine {
    /// A message.
    Message(Box<ClientJsonRpcMessage>),
    /// The line is no message; this is the answer to it.
    Wrong(Box<ServerJsonRpcMessage>),
    /// The line needs no answer: it is empty, or a notification that cannot be read.
    Nothing,
}

/// Reads one line, with or without its end.
pub fn read(line: &[u8]) -> IncomingLine {
    let line = line.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(line);
    if line.iter().all(u8::is_ascii_whitespace) {
        return IncomingLine::Nothing;
    }
    let value: Json = match serde_json::from_slice(line) {
        Ok(value) => value,
        Err(error) => {
            let text = format!("this line is no JSON: {error}");
            return wrong(ErrorData::parse_error(text, None), None);
        }
    };
    if value.is_array() {
        let text = "several messages in one line are not taken; send each in a line of its own";
        return wrong(ErrorData::invalid_request(text, None), None);
    }
    let id = value
        .get("id")
        .and_then(|id| serde_json::from_value::<RequestId>(id.clone()).ok());
    let is_notification = value.get("method").is_some() && value.get("id").is_none();
    match serde_json::from_value(value) {
        Ok(message) => IncomingLine::Message(Box::new(message)),
        // Nobody waits for an answer to a notification, not even for this one.
        Err(error) if is_notification => {
            tracing::warn!("a notification that is none: {error}");
            IncomingLine::Nothing
        }
        Err(_) => {
            let text = "this is no message of JSON-RPC 2.0: jsonrpc must be \"2.0\", id a whole number or a text, \
                        method a text and params an object that fits the method";
            wrong(ErrorData::invalid_request(text, None), id)
        }
    }
}

fn wrong(error: ErrorData, id: Option<RequestId>) -> IncomingLine {
    IncomingLine::Wrong(Box::new(ServerJsonRpcMessage::error(error, id)))
}

/// The next line of at most `most` bytes; of a longer one the length. `None` at the end.
fn next_line(input: &mut impl BufRead, most: usize) -> io::Result<Option<Result<Vec<u8>, usize>>> {
    let mut line = Vec::new();
    input.take(most as u64 + 1).read_until(b'\n', &mut line)?;
    if line.is_empty() {
        return Ok(None);
    }
    if line.last() == Some(&b'\n') || line.len() <= most {
        return Ok(Some(Ok(line)));
    }
    let mut length = line.len();
    drop(line);
    loop {
        let (used, is_over) = {
            let part = input.fill_buf()?;
            match part.iter().position(|byte| *byte == b'\n') {
                Some(end) => (end + 1, true),
                None => (part.len(), part.is_empty()),
            }
        };
        input.consume(used);
        length += used;
        if is_over {
            return Ok(Some(Err(length)));
        }
    }
}

/// Both streams.
pub(super) struct Lines<W> {
    read: Receiver<IncomingLine>,
    output: Arc<Mutex<W>>,
    /// A request has come: before it there is nothing that a notification could be about.
    is_begun: bool,
}

impl Lines<io::Stdout> {
    /// The lines of the standard streams of this process.
    pub(super) fn of_standard_streams() -> io::Result<Self> {
        Self::new(io::stdin(), io::stdout())
    }
}

impl<W: Write + Send + 'static> Lines<W> {
    fn new(input: impl Read + Send + 'static, output: W) -> io::Result<Self> {
        let (sender, receiver) = channel(AHEAD_MAX);
        ThreadSupervisor::default().start(ThreadRole::Service, "mcp-input", move || {
            let mut input = BufReader::new(input);
            // An error of the stream is its end.
            while let Ok(Some(line)) = next_line(&mut input, LINE_BYTES_MAX) {
                let said = match line {
                    Ok(line) => read(&line),
                    Err(length) => {
                        let text = format!(
                            "a message had {length} bytes, at most {LINE_BYTES_MAX} are taken"
                        );
                        wrong(ErrorData::invalid_request(text, None), None)
                    }
                };
                if sender.blocking_send(said).is_err() {
                    return;
                }
            }
        })?;
        Ok(Self {
            read: receiver,
            output: Arc::new(Mutex::new(output)),
            is_begun: false,
        })
    }

    /// Writes a line.
    fn write(output: &Mutex<W>, message: &ServerJsonRpcMessage) -> io::Result<()> {
        let mut line = serde_json::to_vec(message)?;
        line.push(b'\n');
        let mut output = output.lock();
        output.write_all(&line)?;
        output.flush()
    }
}

impl<W: Write + Send + 'static> Transport<RoleServer> for Lines<W> {
    type Error = io::Error;

    fn send(
        &mut self,
        message: ServerJsonRpcMessage,
    ) -> impl Future<Output = io::Result<()>> + Send + 'static {
        let output = self.output.clone();
        // A client that takes nothing holds up the answers, and the reading behind them, and nothing else.
        async move { Self::write(&output, &message) }
    }

    async fn receive(&mut self) -> Option<ClientJsonRpcMessage> {
        loop {
            match self.read.recv().await? {
                IncomingLine::Nothing => {}
                IncomingLine::Wrong(answer) => {
                    if Self::write(&self.output, &answer).is_err() {
                        return None;
                    }
                }
                IncomingLine::Message(message) => match *message {
                    message @ ClientJsonRpcMessage::Request(_) => {
                        self.is_begun = true;
                        return Some(message);
                    }
                    message if self.is_begun => return Some(message),
                    // The SDK would end the session.
                    _ => {}
                },
            }
        }
    }

    async fn close(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(line: &[u8]) -> Json {
        match read(line) {
            IncomingLine::Wrong(answer) => serde_json::to_value(&*answer).unwrap(),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn what_is_no_message_is_answered_with_the_number_of_the_request_if_it_has_one() {
        assert!(matches!(read(b" \r\n"), IncomingLine::Nothing));
        let message = read(b"{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"tools/list\"}\n");
        assert!(matches!(message, IncomingLine::Message(_)));
        assert_eq!(answer(b"{\"jsonrpc\":")["error"]["code"], -32700);
        assert_eq!(answer(b"\xff\xfe{}")["error"]["code"], -32700);
        let deep = "[".repeat(100_000);
        assert_eq!(answer(deep.as_bytes())["error"]["code"], -32700);
        assert_eq!(answer(b"[]")["error"]["code"], -32600);
        assert_eq!(answer(b"7")["error"]["code"], -32600);
        let wrong = answer(b"{\"jsonrpc\":\"1.0\",\"id\":\"a\",\"method\":\"ping\"}");
        assert_eq!(
            (&wrong["id"], &wrong["error"]["code"]),
            (&"a".into(), &(-32600).into())
        );
        let wrong = answer(b"{\"jsonrpc\":\"2.0\",\"id\":5,\"method\":7}");
        assert_eq!(wrong["id"], 5);
        let noted = b"{\"jsonrpc\":\"2.0\",\"method\":\"notifications/cancelled\",\"params\":3}";
        assert!(!matches!(read(noted), IncomingLine::Wrong(_)));
    }

    #[test]
    fn lines_are_bounded_and_what_follows_a_long_one_is_read() {
        let text = format!("short\n{}\nafter\nlast", "x".repeat(1000));
        let mut input = BufReader::with_capacity(64, text.as_bytes());
        let mut next = || next_line(&mut input, 100).unwrap();
        assert_eq!(next(), Some(Ok(b"short\n".to_vec())));
        assert_eq!(next(), Some(Err(1001)));
        assert_eq!(next(), Some(Ok(b"after\n".to_vec())));
        assert_eq!(next(), Some(Ok(b"last".to_vec())));
        assert_eq!(next(), None);
    }
}
