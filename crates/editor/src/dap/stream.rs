//! The frames of the protocol: a header with the length, then that many bytes of JSON. Whatever comes in is bounded.

use std::io::{self, BufRead, Write};

use serde_json::Value as Json;
use thiserror::Error;

/// Longest message that is taken, bytes.
const MESSAGE_MAX: usize = 16 << 20;
/// Longest line of a header, bytes, and most lines of one.
const HEADER_LINE_MAX: u64 = 1024;
const HEADER_LINES_MAX: usize = 32;

/// A reason why there is no next message.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StreamError {
    /// Reading failed.
    #[error("cannot read from the client: {0}")]
    Read(#[from] io::Error),
    /// The header is none.
    #[error("the client sent {0:?} where the header of a message should be")]
    Header(String),
    /// There is no length, or it is no number.
    #[error("the client sent a message without a Content-Length")]
    NoLength,
    /// The message is longer than is taken.
    #[error("the client sent a message of {0} bytes, {MESSAGE_MAX} are allowed")]
    TooLong(usize),
    /// The stream ended within a message.
    #[error("the client left in the midst of a message")]
    Cut,
}

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
/// [`StreamError`]; nothing can be read after it.
pub fn read(input: &mut dyn BufRead) -> Result<Option<DapInput>, StreamError> {
    let Some(length) = read_header(input)? else {
        return Ok(None);
    };
    if length > MESSAGE_MAX {
        return Err(StreamError::TooLong(length));
    }
    let mut body = Vec::new();
    // What was promised is not reserved before it comes.
    let read = io::Read::read_to_end(&mut io::Read::take(&mut *input, length as u64), &mut body)?;
    if read < length {
        return Err(StreamError::Cut);
    }
    Ok(Some(match serde_json::from_slice(&body) {
        Ok(message) => DapInput::Message(message),
        Err(error) => DapInput::Garbage(error.to_string()),
    }))
}

fn read_header(input: &mut dyn BufRead) -> Result<Option<usize>, StreamError> {
    let mut length = None;
    for index in 0..HEADER_LINES_MAX {
        let mut line = Vec::new();
        let mut limited = io::Read::take(&mut *input, HEADER_LINE_MAX);
        limited.read_until(b'\n', &mut line)?;
        if line.is_empty() && index == 0 {
            return Ok(None);
        }
        let text = String::from_utf8_lossy(&line).into_owned();
        if line.is_empty() {
            return Err(StreamError::Cut);
        }
        if !line.ends_with(b"\n") {
            return Err(StreamError::Header(text.chars().take(80).collect()));
        }
        let text = text.trim();
        if text.is_empty() {
            return length.map(Some).ok_or(StreamError::NoLength);
        }
        let Some((name, value)) = text.split_once(':') else {
            return Err(StreamError::Header(text.chars().take(80).collect()));
        };
        // A page in a browser on this machine can have a request sent here, with headers and a body of its choice:
        // whatever has another header is no client.
        match name.trim().to_ascii_lowercase().as_str() {
            "content-length" => {
                length = Some(value.trim().parse().map_err(|_| StreamError::NoLength)?);
            }
            "content-type" => {}
            _ => return Err(StreamError::Header(text.chars().take(80).collect())),
        }
    }
    Err(StreamError::Header("too many lines".to_owned()))
}

/// Sink for messages to a client.
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

/// Writes a message.
///
/// # Errors
/// Nobody reads any more.
pub fn write(output: &mut dyn Write, message: &Json) -> io::Result<()> {
    let body = message.to_string();
    write!(output, "Content-Length: {}\r\n\r\n{body}", body.len())?;
    output.flush()
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
