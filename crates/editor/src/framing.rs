//! Messages on a stream of bytes, as the language server and the debugger have them: a header with `Content-Length`, a
//! blank line, then that many bytes of JSON. Whatever comes in is bounded.
//!
//! Owns the framing alone. What a body means, how long one may be, and whether a session outlives an error is decided
//! by each protocol.

use std::io::{self, BufRead, Read, Write};

use messages::Localized;
use serde_json::Value as Json;
use thiserror::Error;

/// Longest line of a header, bytes, and most lines of one.
const HEADER_LINE_MAX: u64 = 1024;
const HEADER_LINES_MAX: usize = 32;
/// Characters of a wrong line that are shown.
const SHOWN_CHARS_MAX: usize = 80;
/// Bytes of a long message that are skipped at once.
const SKIP_BYTES: u64 = 64 << 10;

/// The reason for which there is no next message.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum FramingError {
    /// Reading failed.
    #[error("cannot read from the client: {0}")]
    #[zh("无法从客户端读取：{0}")]
    Read(#[from] io::Error),
    /// A line that belongs to no header. The next line may begin one.
    #[error("the client sent {0:?} where the header of a message should be")]
    #[zh("应为消息头之处客户端发送了 {0:?}")]
    Header(String),
    /// A header without a length.
    #[error("the client sent a message without a Content-Length")]
    #[zh("客户端发送的消息没有 Content-Length")]
    NoLength,
    /// A length that is no number.
    #[error("the client sent a message with the Content-Length {0:?}, which is no number of bytes")]
    #[zh("客户端发送的消息的 Content-Length 为 {0:?}，不是字节数")]
    BadLength(String),
    /// More than is taken. [`skip`] leads to the next message.
    #[error("the client sent a message of {length} bytes, {most} are allowed")]
    #[zh("客户端发送的消息有 {length} 字节，允许 {most} 字节")]
    TooLong {
        /// Length of the message, bytes.
        length: u64,
        /// Most that is taken, bytes.
        most: u64,
    },
    /// The stream ended within a message.
    #[error("the client left in the midst of a message")]
    #[zh("客户端在消息中途断开")]
    Cut,
}

/// The body of the next message; None at the end of the stream.
///
/// # Errors
/// [`FramingError`]
pub fn read(input: &mut dyn BufRead, most: u64) -> Result<Option<Vec<u8>>, FramingError> {
    let Some(length) = read_header(input)? else {
        return Ok(None);
    };
    if length > most {
        return Err(FramingError::TooLong { length, most });
    }
    // Grows with what comes, not with what was announced.
    let mut body = Vec::new();
    let read = Read::take(&mut *input, length).read_to_end(&mut body)?;
    match (read as u64) < length {
        true => Err(FramingError::Cut),
        false => Ok(Some(body)),
    }
}

/// Passes over the body of a message that is too long; false at the end of the stream.
///
/// # Errors
/// The stream's.
pub fn skip(input: &mut dyn BufRead, length: u64) -> io::Result<bool> {
    let mut left = length;
    while left > 0 {
        let mut part = Read::take(&mut *input, left.min(SKIP_BYTES));
        match io::copy(&mut part, &mut io::sink())? {
            0 => return Ok(false),
            skipped => left -= skipped,
        }
    }
    Ok(true)
}

/// Reads up to the blank line; the length that was announced.
fn read_header(input: &mut dyn BufRead) -> Result<Option<u64>, FramingError> {
    let mut length = None;
    for index in 0..HEADER_LINES_MAX {
        let mut line = Vec::new();
        Read::take(&mut *input, HEADER_LINE_MAX).read_until(b'\n', &mut line)?;
        if line.is_empty() {
            return match index {
                0 => Ok(None),
                _ => Err(FramingError::Cut),
            };
        }
        let text = String::from_utf8_lossy(&line);
        let wrong = || FramingError::Header(text.chars().take(SHOWN_CHARS_MAX).collect());
        if !line.ends_with(b"\n") {
            return Err(wrong());
        }
        let text = text.trim();
        if text.is_empty() {
            return length.map(Some).ok_or(FramingError::NoLength);
        }
        let (name, value) = text.split_once(':').ok_or_else(wrong)?;
        // A page in a browser on this machine can have a request sent here, with headers and a body of its choice:
        // whatever has another header is no client.
        match name.trim().to_ascii_lowercase().as_str() {
            "content-length" => {
                let value = value.trim();
                let shown = || FramingError::BadLength(value.chars().take(40).collect());
                length = Some(value.parse().map_err(|_| shown())?);
            }
            "content-type" => {}
            _ => return Err(wrong()),
        }
    }
    Err(FramingError::Header("too many lines".to_owned()))
}

/// Writes a message.
///
/// # Errors
/// Nobody reads any more.
pub fn write(output: &mut (impl Write + ?Sized), message: &Json) -> io::Result<()> {
    let body = message.to_string();
    write!(output, "Content-Length: {}\r\n\r\n{body}", body.len())?;
    output.flush()
}
