//! Bytes as hexadecimal digits, and bytes from them.

use super::bytes::receiver;
use crate::eval::Evaluator;
use crate::limits::chunked::{CHUNK, WORK_PER_BYTE};
use crate::value::{R, Value};

/// Appends bytes as hexadecimal digits.
fn push_hex(ev: &Evaluator<'_>, data: &[u8], out: &mut String) -> R<()> {
    const DIGITS: &[u8; 16] = b"0123456789abcdef";
    for piece in data.chunks(CHUNK) {
        ev.grow(out, piece.len() * 2)?;
        for byte in piece {
            out.push(char::from(DIGITS[usize::from(byte >> 4)]));
            out.push(char::from(DIGITS[usize::from(byte & 15)]));
        }
        ev.charge(piece.len() * WORK_PER_BYTE)?;
    }
    Ok(())
}

/// `hex`.
pub(super) fn hex(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let group = args[2].if_given().map_or(Ok(1), |value| ev.c_int(value))?;
    let data = receiver(ev, &args[0])?;
    let mut out = String::new();
    let Some(separator) = args[1].if_given() else {
        ev.grow(&mut out, data.len() * 2)?;
        push_hex(ev, &data, &mut out)?;
        return ev.new_str(out);
    };
    // CPython asks the separator for its length before it looks at its type.
    if ev.len(separator)? != 1 {
        return Err(ev.value_error("sep must be length 1."));
    }
    let separator = match ev.unwrap_builtin(separator) {
        Value::Str(text) => text.as_str().to_owned(),
        Value::Bytes(data) => ev.decode_latin1(data.data())?,
        _ => return Err(ev.type_error("sep must be str or bytes.")),
    };
    if !separator.is_ascii() {
        return Err(ev.value_error("sep must be ASCII."));
    }
    if group == 0 {
        ev.grow(&mut out, data.len() * 2)?;
        push_hex(ev, &data, &mut out)?;
        return ev.new_str(out);
    }
    let size = usize::try_from(group.unsigned_abs()).unwrap_or(usize::MAX);
    // Groups count from the right, or from the left if the size is negative.
    let first = if group > 0 { data.len() % size } else { 0 };
    let (head, tail) = data.split_at(first);
    ev.grow(&mut out, (data.len() * 2).saturating_add(data.len() / size))?;
    push_hex(ev, head, &mut out)?;
    for group in tail.chunks(size) {
        if !out.is_empty() {
            ev.grow(&mut out, 1)?;
            out.push_str(&separator);
        }
        push_hex(ev, group, &mut out)?;
        ev.charge(WORK_PER_BYTE)?;
    }
    ev.new_str(out)
}

/// The bytes that a text of hexadecimal digits stands for.
pub(super) fn from_hex(ev: &Evaluator<'_>, text: &Value) -> R<Vec<u8>> {
    let Value::Str(text) = ev.unwrap_builtin(text) else {
        let name = ev.core.types.name_of_argument(text);
        return Err(ev.type_error(format!("fromhex() argument must be str, not {name}")));
    };
    let mut out = Vec::new();
    let mut chars = text.as_str().chars().enumerate();
    let error = |at: usize| {
        ev.value_error(format!(
            "non-hexadecimal number found in fromhex() arg at position {at}"
        ))
    };
    // CPython looks for letters beyond ASCII before it begins.
    if !text.as_str().is_ascii() {
        let beyond = text.as_str().chars().position(|c| !c.is_ascii());
        return Err(error(beyond.unwrap_or(0)));
    }
    while let Some((at, high)) = chars.next() {
        ev.charge(2 * WORK_PER_BYTE)?;
        // Between bytes there may be blanks, within one there may not.
        if matches!(high, ' ' | '\t'..='\r') {
            continue;
        }
        ev.grow(&mut out, 1)?;
        let high = high.to_digit(16).ok_or_else(|| error(at))?;
        let (at, low) = chars.next().ok_or_else(|| error(at + 1))?;
        let low = low.to_digit(16).ok_or_else(|| error(at))?;
        out.push((high * 16 + low) as u8);
    }
    Ok(out)
}
