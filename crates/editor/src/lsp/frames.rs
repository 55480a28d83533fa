//! Messages of the language server's client. A client that sends something else hears of it, and the session goes on.

use std::io::{self, BufRead};

use lsp_server::Message;

use crate::framing::{self, FramingError};

/// Longest message that is read, in bytes; longer ones are skipped.
const MESSAGE_MAX: u64 = 64 << 20;

/// What came in.
pub enum LspInput {
    /// A message.
    Message(Message),
    /// Something that is none; the sentence says why.
    Broken(String),
}

/// The next message; None at the end of the stream.
///
/// # Errors
/// The stream's.
pub fn read(input: &mut impl BufRead) -> io::Result<Option<LspInput>> {
    let broken = loop {
        match framing::read(input, MESSAGE_MAX) {
            Ok(Some(body)) => {
                return Ok(Some(match serde_json::from_slice(&body) {
                    Ok(message) => LspInput::Message(message),
                    Err(error) => LspInput::Broken(format!("the message is no JSON-RPC: {error}")),
                }));
            }
            Ok(None) | Err(FramingError::Cut) => return Ok(None),
            Err(FramingError::Read(error)) => return Err(error),
            // Blank lines between messages mean nothing.
            Err(FramingError::NoLength) => {}
            Err(FramingError::TooLong { length, most }) => {
                if !framing::skip(input, length)? {
                    return Ok(None);
                }
                let most = most >> 20;
                break format!("the message has {length} bytes, at most {most} MiB are read");
            }
            Err(FramingError::BadLength(value)) => {
                break format!("'{value}' is no length of a message");
            }
            Err(FramingError::Header(line)) => {
                let name = line.split(':').next().unwrap_or_default().trim();
                let name: String = name.chars().take(40).collect();
                break format!("'{name}' is no header of a message");
            }
        }
    };
    Ok(Some(LspInput::Broken(broken)))
}
