//! Answers at once (`quick`) about short texts: the methods of `str` that most calls are of, on ASCII.
//!
//! Longer texts and other letters go the usual way, which lets others have their turn meanwhile and knows all of
//! Unicode.

use std::rc::Rc;

use compact_str::{CompactString, ToCompactString as _};

use crate::eval::Evaluator;
use crate::value::{Str, Value};

/// Longest text, in bytes, that is answered about here.
const FAST_TEXT_MAX: usize = 64;
/// Most texts that are joined here.
const JOIN_ITEMS_MAX: usize = 16;

/// A short text of ASCII.
#[inline]
fn short(value: &Value) -> Option<&str> {
    match value {
        Value::Str(text) if text.is_ascii() && text.len() <= FAST_TEXT_MAX => Some(text.as_str()),
        _ => None,
    }
}

fn is_blank(c: char) -> bool {
    matches!(c, ' ' | '\t'..='\r' | '\x1c'..='\x1f')
}

/// A text as a value; of one character, or none, there is one already.
fn str_value(ev: &Evaluator<'_>, text: &str) -> Value {
    match text.as_bytes() {
        [] => ev.core.empty_str.clone(),
        [byte] => match ev.core.ascii.get(usize::from(*byte)) {
            Some(value) => value.clone(),
            None => Value::str(text),
        },
        _ => Value::Str(Rc::new(Str::with_char_count(text, text.len()))),
    }
}

/// A text of ASCII as a value, without a copy; of one character, or none, there is a value already.
fn made_whole(ev: &Evaluator<'_>, text: CompactString) -> Value {
    match text.len() {
        0 | 1 => str_value(ev, &text),
        length => Value::Str(Rc::new(Str::with_char_count(text, length))),
    }
}

/// A text made of that of the receiver; the receiver itself where nothing has changed.
fn replace_receiver_text(
    ev: &Evaluator<'_>,
    args: &[&Value],
    change: impl FnOnce(&str) -> &str,
) -> Option<Value> {
    let [value] = args else { return None };
    let text = short(value)?;
    let result = change(text);
    Some(match result.len() == text.len() {
        true => (*value).clone(),
        false => str_value(ev, result),
    })
}

pub(super) fn strip(ev: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    replace_receiver_text(ev, args, |text| text.trim_matches(is_blank))
}

pub(super) fn lstrip(ev: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    replace_receiver_text(ev, args, |text| text.trim_start_matches(is_blank))
}

pub(super) fn rstrip(ev: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    replace_receiver_text(ev, args, |text| text.trim_end_matches(is_blank))
}

pub(super) fn lower(ev: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    match args {
        [value] => Some(str_value(ev, &short(value)?.to_ascii_lowercase())),
        _ => None,
    }
}

pub(super) fn upper(ev: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    match args {
        [value] => Some(str_value(ev, &short(value)?.to_ascii_uppercase())),
        _ => None,
    }
}

/// Whether a text is not empty and all its letters are of a kind.
pub(super) fn all(args: &[&Value], is: fn(char) -> bool) -> Option<Value> {
    let [value] = args else { return None };
    let text = short(value)?;
    Some(Value::Bool(!text.is_empty() && text.chars().all(is)))
}

pub(super) fn is_space(_: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    all(args, is_blank)
}

/// Whether a text of any length begins with a short one.
pub(super) fn startswith(_: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    match args {
        [Value::Str(text), part] => Some(Value::Bool(text.as_str().starts_with(short(part)?))),
        _ => None,
    }
}

/// Whether a text of any length ends with a short one.
pub(super) fn endswith(_: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    match args {
        [Value::Str(text), part] => Some(Value::Bool(text.as_str().ends_with(short(part)?))),
        _ => None,
    }
}

pub(super) fn find(_: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    let [text, part] = args else { return None };
    let place = short(text)?.find(short(part)?);
    Some(Value::Int(place.map_or(-1, |place| place as i64)))
}

pub(super) fn replace(ev: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    let [value, old, new] = args else { return None };
    let (text, old, new) = (short(value)?, short(old)?, short(new)?);
    if old.is_empty() {
        return None;
    }
    let Some(first) = find_short(text, old) else {
        return Some((*value).clone());
    };
    let (mut result, mut rest, mut at) = (CompactString::default(), text, Some(first));
    while let Some(place) = at {
        result.push_str(&rest[..place]);
        result.push_str(new);
        rest = &rest[place + old.len()..];
        at = find_short(rest, old);
    }
    result.push_str(rest);
    Some(made_whole(ev, result))
}

/// Where a short text has another one, looked for place by place.
#[inline]
fn find_short(text: &str, part: &str) -> Option<usize> {
    let (text, part) = (text.as_bytes(), part.as_bytes());
    let (first, others) = part.split_first()?;
    let last = text.len().checked_sub(part.len())?;
    (0..=last).find(|at| text[*at] == *first && text[at + 1..at + part.len()] == *others)
}

pub(super) fn split(ev: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    let value = |part: &str| str_value(ev, part);
    let parts: Vec<Value> = match args {
        [text] => {
            let parts = short(text)?.split(is_blank);
            parts.filter(|part| !part.is_empty()).map(value).collect()
        }
        [text, separator] => {
            let separator = short(separator).filter(|separator| !separator.is_empty())?;
            short(text)?.split(separator).map(value).collect()
        }
        _ => return None,
    };
    Some(Value::list(parts))
}

pub(super) fn join(ev: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    let joined = |separator: &str, parts: &[Value]| {
        if parts.len() > JOIN_ITEMS_MAX {
            return None;
        }
        // The only text there is is that itself.
        if parts.len() == 1 {
            return None;
        }
        let mut length = separator.len() * parts.len().saturating_sub(1);
        for part in parts {
            length += short(part)?.len();
        }
        let mut text = CompactString::with_capacity(length);
        for (index, part) in parts.iter().enumerate() {
            if index > 0 {
                text.push_str(separator);
            }
            text.push_str(short(part)?);
        }
        Some(made_whole(ev, text))
    };
    match args {
        [separator, Value::List(parts)] => joined(short(separator)?, &parts.borrow()),
        [separator, Value::Tuple(parts)] => joined(short(separator)?, parts.items()),
        _ => None,
    }
}

/// Longest text of a number that is read at once.
const NUMERAL_MAX: usize = 18;

/// `str(value)` of integers and of what is a text already.
pub fn str(_: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    match args {
        [Value::Int(int)] => {
            let text = int.to_compact_string();
            let length = text.len();
            Some(Value::Str(Rc::new(Str::with_char_count(text, length))))
        }
        [text @ Value::Str(_)] => Some((*text).clone()),
        _ => None,
    }
}

/// The integer that a text of a sign and a few digits stands for.
pub fn int(text: &Str) -> Option<i64> {
    let bytes = text.as_str().as_bytes();
    let digits = bytes.strip_prefix(b"-").unwrap_or(bytes);
    if digits.is_empty() || digits.len() > NUMERAL_MAX {
        return None;
    }
    let mut number = 0;
    for digit in digits {
        if !digit.is_ascii_digit() {
            return None;
        }
        number = number * 10 + i64::from(digit - b'0');
    }
    Some(if digits.len() < bytes.len() {
        -number
    } else {
        number
    })
}

/// The float that a short text of digits, sign, point and exponent stands for.
pub fn float(text: &Str) -> Option<f64> {
    let text = text.as_str();
    let plain = |byte: &u8| matches!(byte, b'0'..=b'9' | b'.' | b'-' | b'+' | b'e' | b'E');
    let is_plain = text.len() <= NUMERAL_MAX && text.as_bytes().iter().all(plain);
    is_plain.then(|| text.parse().ok())?
}
