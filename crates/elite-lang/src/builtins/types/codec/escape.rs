//! `unicode_escape` and `raw_unicode_escape`: text as the escapes of string literals.

use std::fmt::Write as _;

use elite_syntax::surrogate::{char_of, code_of};

/// What one step of decoding gave: a character or none, and how many bytes it took; or how many bytes are wrong and
/// why.
pub type EscapeResult = Result<(Option<char>, usize), (usize, &'static str)>;

/// Appends a character as an escape where it needs one.
pub fn encode(c: char, is_raw: bool, out: &mut Vec<u8>) {
    let code = code_of(c);
    let mut text = String::new();
    // Writing to a text never fails.
    let _ = match code {
        0..0x100 if is_raw => return out.push(code as u8),
        _ if is_raw && code < 0x1_0000 => write!(text, "\\u{code:04x}"),
        0x09 => write!(text, "\\t"),
        0x0a => write!(text, "\\n"),
        0x0d => write!(text, "\\r"),
        0x5c => write!(text, "\\\\"),
        0x20..0x7f => return out.push(code as u8),
        0..0x100 => write!(text, "\\x{code:02x}"),
        0x100..0x1_0000 => write!(text, "\\u{code:04x}"),
        _ => write!(text, "\\U{code:08x}"),
    };
    out.extend_from_slice(text.as_bytes());
}

/// The first step of bytes.
pub fn decode(bytes: &[u8], is_raw: bool) -> EscapeResult {
    let one = |c: char, length: usize| Ok((Some(c), length));
    let Some(kind) = bytes.get(1).copied().filter(|_| bytes[0] == b'\\') else {
        return match bytes[0] {
            b'\\' if !is_raw => Err((1, "\\ at end of string")),
            byte => one(char::from(byte), 1),
        };
    };
    let simple = match kind {
        b'u' => return number(bytes, 4, "truncated \\uXXXX escape"),
        b'U' => return number(bytes, 8, "truncated \\UXXXXXXXX escape"),
        // The caller goes on behind the backslash.
        _ if is_raw => return one('\\', 1),
        b'\n' => return Ok((None, 2)),
        b'\\' | b'\'' | b'"' => char::from(kind),
        b'a' => '\x07',
        b'b' => '\x08',
        b'f' => '\x0c',
        b'n' => '\n',
        b'r' => '\r',
        b't' => '\t',
        b'v' => '\x0b',
        b'x' => return number(bytes, 2, "truncated \\xXX escape"),
        b'N' => return named(bytes),
        b'0'..=b'7' => {
            let digits = bytes[1..].iter().take(3);
            let digits: Vec<u8> = digits
                .copied()
                .take_while(|d| (b'0'..=b'7').contains(d))
                .collect();
            let code = digits
                .iter()
                .fold(0, |code, digit| code * 8 + u32::from(digit - b'0'));
            return one(char_of(code).unwrap_or('\0'), 1 + digits.len());
        }
        _ => return one('\\', 1),
    };
    one(simple, 2)
}

fn number(bytes: &[u8], length: usize, reason: &'static str) -> EscapeResult {
    let digits = bytes[2..].iter().take(length);
    let valid = digits.take_while(|byte| byte.is_ascii_hexdigit()).count();
    if valid < length {
        return Err((2 + valid, reason));
    }
    let text = std::str::from_utf8(&bytes[2..2 + length]).unwrap_or_default();
    let code = u32::from_str_radix(text, 16).unwrap_or(u32::MAX);
    match char_of(code) {
        Some(c) => Ok((Some(c), 2 + length)),
        None => Err((2 + length, "illegal Unicode character")),
    }
}

fn named(bytes: &[u8]) -> EscapeResult {
    const MALFORMED: &str = "malformed \\N character escape";
    if bytes.get(2) != Some(&b'{') {
        return Err((2, MALFORMED));
    }
    let Some(end) = bytes.iter().position(|byte| *byte == b'}') else {
        return Err((bytes.len(), MALFORMED));
    };
    if end == 3 {
        return Err((end, MALFORMED));
    }
    let name = std::str::from_utf8(&bytes[3..end]).ok();
    match name.and_then(unicode_names2::character) {
        Some(c) => Ok((Some(c), end + 1)),
        None => Err((end + 1, "unknown Unicode character name")),
    }
}
