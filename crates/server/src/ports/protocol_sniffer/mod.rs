//! How a connection begins, and whether that is a browser. Pure.
//!
//! A page anywhere can make a browser connect to a port of this machine and send text of its choice behind the head of
//! a request. So on a port that speaks a protocol of its own a connection that begins with a request line, or with the
//! greeting of TLS, is turned away before anything that it sent is looked at. What may still become one is held back.
//!
//! No legal client is taken for a browser: a program does not begin with a method in capitals and a blank, an RTSI
//! packet begins with a small length, and in a Modbus header the third byte is 0.

use core::fmt;

/// Methods that a browser sends by itself or for a page. In capitals and followed by a blank they are decisive.
const METHODS: [&str; 10] = [
    "GET", "HEAD", "POST", "PUT", "DELETE", "CONNECT", "OPTIONS", "TRACE", "PATCH", "PRI",
];

/// Further methods. These, and all of them in small letters, are also names in programs: they count in a whole request
/// line.
const RARE_METHODS: [&str; 13] = [
    "PROPFIND",
    "PROPPATCH",
    "MKCOL",
    "COPY",
    "MOVE",
    "LOCK",
    "UNLOCK",
    "SEARCH",
    "REPORT",
    "QUERY",
    "BIND",
    "REBIND",
    "LINK",
];

/// Longest beginning that is held back, bytes. What is longer and still not clear is no request of a browser.
const HELD_BYTES_MAX: usize = 256;

/// A reason why a connection is turned away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ForeignProtocol {
    /// The first line begins with a method.
    Http,
    /// The first bytes are a greeting of TLS.
    Tls,
}

impl fmt::Display for ForeignProtocol {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Http => "the client speaks HTTP",
            Self::Tls => "the client speaks TLS",
        })
    }
}

/// What a beginning is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SniffResult {
    /// The bytes so far may become either.
    Undecided,
    /// No browser has sent the bytes; nothing is looked at from here on.
    Ours,
    /// The bytes are of a protocol that is not for this port.
    Intruder(ForeignProtocol),
}

/// The beginning of one connection.
#[derive(Debug, Default)]
pub struct ProtocolSniffer {
    held: Vec<u8>,
}

impl ProtocolSniffer {
    /// Takes what was received; what is certain not to be a browser's goes on to `ours`.
    pub fn take(&mut self, received: &[u8], ours: &mut Vec<u8>) -> SniffResult {
        for (at, byte) in received.iter().enumerate() {
            // Blank lines before a request are allowed, and mean nothing on any port.
            if self.held.is_empty() && byte.is_ascii_whitespace() {
                ours.push(*byte);
                continue;
            }
            self.held.push(*byte);
            match judge(&self.held) {
                SniffResult::Undecided if self.held.len() < HELD_BYTES_MAX => {}
                SniffResult::Undecided | SniffResult::Ours => {
                    self.give_back(ours);
                    ours.extend_from_slice(&received[at + 1..]);
                    return SniffResult::Ours;
                }
                intruder => return intruder,
            }
        }
        SniffResult::Undecided
    }

    /// The client sends no more: what is held back goes on to `ours`.
    pub fn give_back(&mut self, ours: &mut Vec<u8>) {
        ours.append(&mut self.held);
    }
}

/// What a beginning without leading blanks is.
fn judge(start: &[u8]) -> SniffResult {
    if start.first() == Some(&TLS_HANDSHAKE) {
        return judge_tls(start);
    }
    let is_method_byte = |byte: &u8| byte.is_ascii_alphabetic() || *byte == b'-';
    let length = start.iter().position(|byte| !is_method_byte(byte));
    let (word, rest) = start.split_at(length.unwrap_or(start.len()));
    let mut methods = METHODS.iter().chain(&RARE_METHODS).map(|m| m.as_bytes());
    let Some((separator, rest)) = rest.split_first() else {
        let may_become_one = methods.any(|method| {
            method.len() >= word.len() && method[..word.len()].eq_ignore_ascii_case(word)
        });
        return if may_become_one {
            SniffResult::Undecided
        } else {
            SniffResult::Ours
        };
    };
    if !is_blank(*separator) || !methods.any(|method| method.eq_ignore_ascii_case(word)) {
        return SniffResult::Ours;
    }
    if METHODS.iter().any(|method| method.as_bytes() == word) {
        return SniffResult::Intruder(ForeignProtocol::Http);
    }
    judge_target(rest)
}

/// Judges what follows a first word that may be a method or a name in a program: `get / HTTP/1.1`, `head /= 2`. The
/// version behind the target decides.
fn judge_target(rest: &[u8]) -> SniffResult {
    let rest = trim_blanks(rest);
    let Some(end) = rest.iter().position(|byte| byte.is_ascii_whitespace()) else {
        return SniffResult::Undecided;
    };
    if rest[end] == b'\n' {
        return SniffResult::Ours;
    }
    const VERSION: &[u8] = b"HTTP/";
    let version = trim_blanks(&rest[end..]);
    let known = version.len().min(VERSION.len());
    match version[..known].eq_ignore_ascii_case(&VERSION[..known]) {
        false => SniffResult::Ours,
        true if known < VERSION.len() => SniffResult::Undecided,
        true => SniffResult::Intruder(ForeignProtocol::Http),
    }
}

/// Type of the first record of a TLS connection (RFC 8446, 5.1).
const TLS_HANDSHAKE: u8 = 0x16;

/// A record's type and its version, 3.1 to 3.4. (A Modbus header that begins 0x16 0x03 has a 0 next.)
fn judge_tls(start: &[u8]) -> SniffResult {
    match start {
        [_] | [_, 3] => SniffResult::Undecided,
        [_, 3, 1..=4, ..] => SniffResult::Intruder(ForeignProtocol::Tls),
        _ => SniffResult::Ours,
    }
}

const fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t')
}

fn trim_blanks(bytes: &[u8]) -> &[u8] {
    let start = bytes.iter().position(|byte| !is_blank(*byte));
    &bytes[start.unwrap_or(bytes.len())..]
}

#[cfg(test)]
pub(crate) mod tests;
