//! Messages on a stream of bytes: `Content-Length`, a blank line, JSON. Reads whatever comes, within bounds.

use std::io::{self, BufRead, Read, Write};

use lsp_server::Message;

/// Longest message that is read, in bytes; longer ones are skipped.
const MESSAGE_MAX: u64 = 64 << 20;
/// Longest line of a header.
const HEADER_MAX: u64 = 8 << 10;
/// Bytes of a long message that are skipped at once.
const SKIP: u64 = 64 << 10;

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
    let Some(length) = header(input)? else {
        return Ok(None);
    };
    let length = match length {
        Ok(length) => length,
        Err(broken) => return Ok(Some(LspInput::Broken(broken))),
    };
    if length > MESSAGE_MAX {
        let mut left = length;
        while left > 0 {
            let skipped = io::copy(&mut input.take(left.min(SKIP)), &mut io::sink())?;
            if skipped == 0 {
                return Ok(None);
            }
            left -= skipped;
        }
        let most = MESSAGE_MAX >> 20;
        let broken = format!("the message has {length} bytes, at most {most} MiB are read");
        return Ok(Some(LspInput::Broken(broken)));
    }
    // Grows with what comes, not with what was announced.
    let mut body = Vec::new();
    input.take(length).read_to_end(&mut body)?;
    if (body.len() as u64) < length {
        return Ok(None);
    }
    Ok(Some(match serde_json::from_slice(&body) {
        Ok(message) => LspInput::Message(message),
        Err(error) => LspInput::Broken(format!("the message is no JSON-RPC: {error}")),
    }))
}

/// Reads up to the blank line; the length that was announced, or what is wrong with the header.
fn header(input: &mut impl BufRead) -> io::Result<Option<Result<u64, String>>> {
    let mut length = None;
    loop {
        let mut line = Vec::new();
        if input.take(HEADER_MAX).read_until(b'\n', &mut line)? == 0 {
            return Ok(None);
        }
        let text = String::from_utf8_lossy(&line);
        let text = text.trim_end_matches(['\r', '\n']);
        if text.is_empty() {
            match length {
                Some(length) => return Ok(Some(Ok(length))),
                // Blank lines between messages mean nothing.
                None => continue,
            }
        }
        let (name, value) = text.split_once(':').unwrap_or((text, ""));
        if name.trim().eq_ignore_ascii_case("content-length") {
            match value.trim().parse() {
                Ok(count) => length = Some(count),
                Err(_) => {
                    let value: String = value.chars().take(40).collect();
                    return Ok(Some(Err(format!(
                        "'{}' is no length of a message",
                        value.trim()
                    ))));
                }
            }
        } else if !name.trim().eq_ignore_ascii_case("content-type") {
            let name: String = name.chars().take(40).collect();
            return Ok(Some(Err(format!("'{name}' is no header of a message"))));
        }
    }
}

/// Writes a message.
///
/// # Errors
/// The stream's.
pub fn write(output: &mut impl Write, message: &serde_json::Value) -> io::Result<()> {
    let body = serde_json::to_vec(message)?;
    write!(output, "Content-Length: {}\r\n\r\n", body.len())?;
    output.write_all(&body)?;
    output.flush()
}
