//! Messages of the debugger's client. What is no message ends the session; a body that is no JSON is answered.

use std::io::{self, BufRead, Write};

use serde_json::Value as Json;

use crate::framing;
pub use crate::framing::{FramingError, write};

/// Longest message that is taken, bytes.
const MESSAGE_MAX: u64 = 16 << 20;

/// A message, or what was sent instead.
#[derive(Clone, Debug)]
pub enum DapInput {
    /// JSON.
    Message(Json),
    /// A frame whose contents are no JSON; the next one may be right.
    Garbage(String),
}

/// Reads the next message; None at the end of the stream.
///
/// # Errors
/// [`FramingError`]; nothing can be read after it.
pub fn read(input: &mut dyn BufRead) -> Result<Option<DapInput>, FramingError> {
    let body = framing::read(input, MESSAGE_MAX)?;
    Ok(body.map(|body| match serde_json::from_slice(&body) {
        Ok(message) => DapInput::Message(message),
        Err(error) => DapInput::Garbage(error.to_string()),
    }))
}

/// Where messages to a client go.
pub trait MessageSink {
    /// Sends one.
    ///
    /// # Errors
    /// Nobody reads any more.
    fn message(&mut self, message: &Json) -> io::Result<()>;
}

/// Messages in frames.
pub struct FramedWriter<'o>(pub &'o mut dyn Write);

impl MessageSink for FramedWriter<'_> {
    fn message(&mut self, message: &Json) -> io::Result<()> {
        write(self.0, message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(bytes: &[u8]) -> (Vec<String>, Option<String>) {
        let mut input = bytes;
        let mut seen = Vec::new();
        loop {
            match read(&mut input) {
                Ok(Some(DapInput::Message(json))) => seen.push(json.to_string()),
                Ok(Some(DapInput::Garbage(_))) => seen.push("garbage".to_owned()),
                Ok(None) => return (seen, None),
                Err(error) => return (seen, Some(error.to_string())),
            }
        }
    }

    #[test]
    fn frames_are_read_and_broken_ones_end_the_stream_with_a_sentence() {
        let mut out = Vec::new();
        write(&mut out, &serde_json::json!({"seq": 1})).unwrap();
        write(&mut out, &serde_json::json!("ü")).unwrap();
        out.extend(b"content-length: 3\r\nContent-Type: x\r\n\r\n{]}");
        assert_eq!(
            all(&out).0,
            ["{\"seq\":1}", "\"ü\"", "garbage"].map(str::to_owned)
        );
        for (bytes, said) in [
            (&b"hello\r\n\r\n"[..], "header"),
            (
                b"POST /a:b HTTP/1.1\r\nContent-Length: 2\r\n\r\n{}",
                "header",
            ),
            (b"Content-Length: 99999999999\r\n\r\n", "allowed"),
            (b"Content-Length: x\r\n\r\n", "Content-Length"),
            (b"Content-Length: 10\r\n\r\n{}", "midst"),
            (b"Content-Length: 10\r\n", "midst"),
            (b"\r\n", "Content-Length"),
            (&[b'x'; 5000], "header"),
        ] {
            let error = all(bytes).1.unwrap();
            assert!(error.contains(said), "{error}");
        }
    }
}
