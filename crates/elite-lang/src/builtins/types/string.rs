//! `str`: its constructor, and how its methods get at the text.

use std::rc::Rc;

use super::{constructor, wrong_receiver};
use crate::eval::{Core, Evaluator};
use crate::value::{R, Str, Value};

pub(super) fn install(core: &Rc<Core>) {
    constructor(
        core,
        &core.types.str,
        "object? encoding? errors?",
        |ev, args| {
            let Some(value) = args[0].given() else {
                return Ok(ev.core.empty_str.clone());
            };
            if args[1].given().is_none() && args[2].given().is_none() {
                return ev.str_value(value);
            }
            match ev.bytes_like(value) {
                Some(data) => ev.decode(&data, &args[1], &args[2]),
                None => {
                    let name = ev.core.types.name_of(value);
                    Err(ev.type_error(format!(
                        "decoding to str: need a bytes-like object, {name} found"
                    )))
                }
            }
        },
    );
}

/// The string behind a receiver or argument.
pub(super) fn receiver(ev: &Evaluator<'_>, value: &Value) -> R<Rc<Str>> {
    match value {
        Value::Str(text) => Ok(text.clone()),
        other => match ev.plain(other) {
            Value::Str(text) => Ok(text),
            other => Err(wrong_receiver(ev, "str", &other)),
        },
    }
}

/// A string argument of a method.
pub(super) fn text_argument(ev: &Evaluator<'_>, value: &Value) -> R<Rc<Str>> {
    match ev.plain(value) {
        Value::Str(text) => Ok(text),
        other => {
            let name = ev.core.types.name_of(&other);
            Err(ev.type_error(format!("must be str, not {name}")))
        }
    }
}

impl Evaluator<'_> {
    /// Text of bytes in an encoding: UTF-8, ASCII or Latin-1, with `strict`, `ignore` or `replace` for what does not fit.
    pub fn decode(&self, data: &[u8], encoding: &Value, errors: &Value) -> R {
        let (encoding, errors) = (
            codec(self, encoding, "utf-8")?,
            codec(self, errors, "strict")?,
        );
        let error = |name: &str, at: usize, reason: &str| {
            let text = format!(
                "'{name}' codec can't decode byte {:#04x} in position {at}: {reason}",
                data[at]
            );
            self.raise(crate::errors::ExceptionKind::UnicodeDecodeError, text)
        };
        let text = match &*encoding {
            "utf8" | "u8" => match std::str::from_utf8(data) {
                Ok(text) => text.to_owned(),
                Err(_) if errors == "replace" => String::from_utf8_lossy(data).into_owned(),
                Err(_) if errors == "ignore" => {
                    data.utf8_chunks().map(|chunk| chunk.valid()).collect()
                }
                Err(wrong) => {
                    let at = wrong.valid_up_to();
                    let reason = match (wrong.error_len(), data[at]) {
                        (None, _) => "unexpected end of data",
                        (_, 0x80..=0xc1 | 0xf5..) => "invalid start byte",
                        _ => "invalid continuation byte",
                    };
                    return Err(error("utf-8", at, reason));
                }
            },
            "ascii" | "usascii" => match data.iter().position(|byte| !byte.is_ascii()) {
                None => data.iter().map(|byte| char::from(*byte)).collect(),
                Some(_) if errors == "ignore" => data
                    .iter()
                    .filter(|byte| byte.is_ascii())
                    .map(|byte| char::from(*byte))
                    .collect(),
                Some(_) if errors == "replace" => data
                    .iter()
                    .map(|byte| {
                        if byte.is_ascii() {
                            char::from(*byte)
                        } else {
                            '\u{fffd}'
                        }
                    })
                    .collect(),
                Some(at) => return Err(error("ascii", at, "ordinal not in range(128)")),
            },
            "latin1" | "iso88591" | "l1" => data.iter().map(|byte| char::from(*byte)).collect(),
            other => return Err(unknown_encoding(self, other)),
        };
        Ok(Value::str(text))
    }

    /// Bytes of text in an encoding.
    pub fn encode(&self, text: &Str, encoding: &Value, errors: &Value) -> R<Vec<u8>> {
        let (encoding, errors) = (
            codec(self, encoding, "utf-8")?,
            codec(self, errors, "strict")?,
        );
        let (name, limit) = match &*encoding {
            "utf8" | "u8" => return Ok(text.as_str().as_bytes().to_vec()),
            "ascii" | "usascii" => ("ascii", 128),
            "latin1" | "iso88591" | "l1" => ("latin-1", 256),
            other => return Err(unknown_encoding(self, other)),
        };
        let mut out = Vec::with_capacity(text.len());
        for (at, c) in text.as_str().chars().enumerate() {
            match u32::from(c) {
                code if code < limit => out.push(code as u8),
                _ if errors == "ignore" => {}
                _ if errors == "replace" => out.push(b'?'),
                code => {
                    let shown = match code {
                        0..0x100 => format!("\\x{code:02x}"),
                        0x100..0x1_0000 => format!("\\u{code:04x}"),
                        _ => format!("\\U{code:08x}"),
                    };
                    let range = format!("ordinal not in range({limit})");
                    let text = format!(
                        "'{name}' codec can't encode character '{shown}' in position {at}: {range}"
                    );
                    return Err(self.raise(crate::errors::ExceptionKind::UnicodeEncodeError, text));
                }
            }
        }
        Ok(out)
    }
}

/// The name of a codec or error handler without case and separators.
fn codec(ev: &Evaluator<'_>, value: &Value, default: &str) -> R<String> {
    let text = match value.given() {
        None => default.to_owned(),
        Some(value) => text_argument(ev, value)?.as_str().to_owned(),
    };
    Ok(text.to_lowercase().replace(['-', '_', ' '], ""))
}

fn unknown_encoding(ev: &Evaluator<'_>, name: &str) -> crate::value::Raised {
    ev.raise(
        crate::errors::ExceptionKind::LookupError,
        format!("unknown encoding: {name}"),
    )
}
