//! Handlers of errors of encodings: Python's own, and those that scripts register (`codecs.register_error`).

use elite_syntax::surrogate::{char_of, code_of, is_surrogate};

use super::Codec;
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::value::{R, Str, Unwind, Value};

/// What is done about what does not fit.
pub(super) enum ErrorHandler {
    Strict,
    Ignore,
    Replace,
    BackslashReplace,
    XmlCharRefReplace,
    NameReplace,
    SurrogateEscape,
    SurrogatePass,
    /// Any other name; whether there is such a handler is asked when it is needed.
    Other(String),
}

/// What does not fit, from one place to another: characters of a text, or bytes.
pub(super) struct CodecError {
    pub codec: &'static str,
    pub start: usize,
    pub end: usize,
    pub reason: &'static str,
}

/// How decoding goes on.
pub(super) struct Replacement {
    /// What stands for the bytes.
    pub text: String,
    /// The byte at which decoding goes on.
    pub next: usize,
    /// The bytes, if the handler has changed them.
    pub data: Option<Vec<u8>>,
}

impl Evaluator<'_> {
    pub(super) fn handler(&self, name: &Value, method: &str) -> R<ErrorHandler> {
        let Some(text) = self.codec_argument(method, "errors", name)? else {
            return Ok(ErrorHandler::Strict);
        };
        Ok(match text.as_str() {
            "strict" => ErrorHandler::Strict,
            "ignore" => ErrorHandler::Ignore,
            "replace" => ErrorHandler::Replace,
            "backslashreplace" => ErrorHandler::BackslashReplace,
            "xmlcharrefreplace" => ErrorHandler::XmlCharRefReplace,
            "namereplace" => ErrorHandler::NameReplace,
            "surrogateescape" => ErrorHandler::SurrogateEscape,
            "surrogatepass" => ErrorHandler::SurrogatePass,
            other => ErrorHandler::Other(other.to_owned()),
        })
    }

    /// The handler that a script has registered under a name.
    fn registered_handler(&self, name: &str) -> R {
        let modules = self.core.modules.borrow();
        let codecs = modules.iter().find(|module| &*module.name == "_codecs");
        let table =
            codecs.and_then(|module| module.namespace.get(self.core.symbols.intern("handlers")));
        drop(modules);
        let found = match table {
            Some(Value::Dict(table)) => table.get_str(name),
            _ => None,
        };
        found.ok_or_else(|| {
            let message = format!("unknown error handler name '{name}'");
            self.raise(ExceptionKind::LookupError, message)
        })
    }

    /// What stands for characters that do not fit goes into `out`; where encoding goes on, in characters.
    pub(super) fn handle_encode_error(
        &self,
        codec: Codec,
        errors: &ErrorHandler,
        text: &Str,
        trouble: CodecError,
        out: &mut Vec<u8>,
    ) -> R<usize> {
        let (start, end) = (trouble.start, trouble.end);
        let bad = &text.as_str()[text.byte_offset(start)..text.byte_offset(end)];
        let strict = |trouble: CodecError| {
            let object = Value::str(text.as_str());
            Err(self.codec_error(&trouble, object, true))
        };
        let mut shown = String::new();
        match errors {
            ErrorHandler::Strict => return strict(trouble),
            ErrorHandler::Ignore => {}
            ErrorHandler::Replace => shown.extend(bad.chars().map(|_| '?')),
            ErrorHandler::BackslashReplace => bad.chars().for_each(|c| push_escape(c, &mut shown)),
            ErrorHandler::XmlCharRefReplace => {
                bad.chars()
                    .for_each(|c| shown.push_str(&format!("&#{};", code_of(c))));
            }
            ErrorHandler::NameReplace => bad.chars().for_each(|c| match unicode_names2::name(c) {
                Some(name) if !is_surrogate(c) => shown.push_str(&format!("\\N{{{name}}}")),
                _ => push_escape(c, &mut shown),
            }),
            // A byte is no whole unit of these.
            ErrorHandler::SurrogateEscape if matches!(codec, Codec::Wide { .. }) => {
                return strict(trouble);
            }
            ErrorHandler::SurrogateEscape => {
                for (place, c) in bad.chars().enumerate() {
                    match code_of(c) {
                        code @ 0xdc80..0xdd00 => out.push((code - 0xdc00) as u8),
                        _ => {
                            return strict(CodecError {
                                start: start + place,
                                ..trouble
                            });
                        }
                    }
                }
            }
            ErrorHandler::SurrogatePass => {
                if !bad.chars().all(is_surrogate) {
                    return strict(trouble);
                }
                for c in bad.chars() {
                    match codec {
                        Codec::Utf8 { .. } => out.extend_from_slice(&utf8_of(code_of(c))),
                        Codec::Wide {
                            unit, big_endian, ..
                        } => super::wide(c, unit, big_endian, out),
                        _ => return strict(trouble),
                    }
                }
            }
            ErrorHandler::Other(name) => {
                return self.ask_for_bytes(codec, name, text, trouble, out);
            }
        }
        for c in shown.chars() {
            if !codec.encode_char(c, out) {
                return strict(trouble);
            }
        }
        Ok(end)
    }

    fn ask_for_bytes(
        &self,
        codec: Codec,
        name: &str,
        text: &Str,
        trouble: CodecError,
        out: &mut Vec<u8>,
    ) -> R<usize> {
        let handler = self.registered_handler(name)?;
        let error = self.codec_error(&trouble, Value::str(text.as_str()), true);
        let (made, next) = self.ask_handler(&handler, &error, text.len(), "encoding")?;
        let made = self.unwrap_builtin(&made);
        match (&made, self.bytes_like(&made)) {
            (Value::Str(made), _) => {
                for c in made.as_str().chars() {
                    if !codec.encode_char(c, out) {
                        return Err(error);
                    }
                }
            }
            (Value::Bytes(_), Some(data)) => out.extend_from_slice(&data),
            _ => return Err(self.handler_error("encoding", "(str/bytes, int)")),
        }
        Ok(next)
    }

    /// What stands for bytes that do not decode. `unit` says how long a unit of the encoding is and whether its high
    /// byte comes first, for encodings that have surrogates.
    pub(super) fn handle_decode_error(
        &self,
        errors: &ErrorHandler,
        data: &[u8],
        unit: Option<(usize, bool)>,
        trouble: CodecError,
    ) -> R<Replacement> {
        let (start, end) = (trouble.start, trouble.end);
        let bad = &data[start..end];
        let mut text = String::new();
        let mut next = end;
        let strict = || -> R<Replacement> {
            let object = Value::bytes(self.copy_bytes(data)?);
            Err(self.codec_error(&trouble, object, false))
        };
        match errors {
            ErrorHandler::Strict => return strict(),
            ErrorHandler::Ignore => {}
            ErrorHandler::Replace => text.push(char::REPLACEMENT_CHARACTER),
            ErrorHandler::BackslashReplace => {
                bad.iter()
                    .for_each(|byte| text.push_str(&format!("\\x{byte:02x}")));
            }
            ErrorHandler::SurrogateEscape => {
                let high = bad.iter().take(4).take_while(|byte| !byte.is_ascii());
                text.extend(high.filter_map(|byte| char_of(0xdc00 + u32::from(*byte))));
                if text.is_empty() {
                    return strict();
                }
                next = start + text.chars().count();
            }
            ErrorHandler::SurrogatePass => {
                let Some((c, length)) = unit.and_then(|unit| surrogate_at(&data[start..], unit))
                else {
                    return strict();
                };
                text.push(c);
                next = start + length;
            }
            ErrorHandler::XmlCharRefReplace | ErrorHandler::NameReplace => {
                return Err(self
                    .type_error("don't know how to handle UnicodeDecodeError in error callback"));
            }
            ErrorHandler::Other(name) => {
                let handler = self.registered_handler(name)?;
                let object = Value::bytes(self.copy_bytes(data)?);
                let error = self.codec_error(&trouble, object, false);
                let (made, next) = self.ask_handler(&handler, &error, data.len(), "decoding")?;
                let Value::Str(made) = self.unwrap_builtin(&made) else {
                    return Err(self.handler_error("decoding", "(str, int)"));
                };
                return Ok(Replacement {
                    text: self.copy_text(made.as_str())?,
                    next,
                    data: None,
                });
            }
        }
        Ok(Replacement {
            text,
            next,
            data: None,
        })
    }

    /// Calls the handler of a script: what it puts in the place, and where to go on.
    fn ask_handler(
        &self,
        handler: &Value,
        error: &Unwind,
        length: usize,
        verb: &str,
    ) -> R<(Value, usize)> {
        let wanted = if verb == "encoding" {
            "(str/bytes, int)"
        } else {
            "(str, int)"
        };
        let Unwind::Exception(exception) = error else {
            return Err(error.clone());
        };
        let answer = self.call1(handler, Value::Instance(exception.clone()))?;
        let Value::Tuple(pair) = self.unwrap_builtin(&answer) else {
            return Err(self.handler_error(verb, wanted));
        };
        let [made, place] = pair.items() else {
            return Err(self.handler_error(verb, wanted));
        };
        let place = self.index(place)?;
        let from_start = if place < 0 {
            place + length as i64
        } else {
            place
        };
        match usize::try_from(from_start) {
            Ok(next) if next <= length => Ok((made.clone(), next)),
            _ => {
                let message = format!("position {place} from error handler out of bounds");
                Err(self.raise(ExceptionKind::IndexError, message))
            }
        }
    }

    fn handler_error(&self, verb: &str, wanted: &str) -> Unwind {
        self.type_error(format!("{verb} error handler must return {wanted} tuple"))
    }

    #[cold]
    fn codec_error(&self, trouble: &CodecError, object: Value, encoding: bool) -> Unwind {
        let kind = if encoding {
            ExceptionKind::UnicodeEncodeError
        } else {
            ExceptionKind::UnicodeDecodeError
        };
        let args = vec![
            Value::str(trouble.codec),
            object,
            Value::Int(trouble.start as i64),
            Value::Int(trouble.end as i64),
            Value::str(trouble.reason),
        ];
        let class = Value::Class(self.core.types.exception(kind).clone());
        match self.call(&class, &mut { args }, &[]) {
            Ok(Value::Instance(exception)) => Unwind::Exception(exception),
            Ok(_) => self.value_error(trouble.reason),
            Err(raised) => raised,
        }
    }
}

fn push_escape(c: char, out: &mut String) {
    out.push_str(&match code_of(c) {
        code @ 0..0x100 => format!("\\x{code:02x}"),
        code @ 0x100..0x1_0000 => format!("\\u{code:04x}"),
        code => format!("\\U{code:08x}"),
    });
}

/// The three bytes that UTF-8 would have for a surrogate.
fn utf8_of(code: u32) -> [u8; 3] {
    [
        0xe0 | (code >> 12) as u8,
        0x80 | (code >> 6 & 0x3f) as u8,
        0x80 | (code & 0x3f) as u8,
    ]
}

/// The surrogate that bytes begin with, and how many it takes.
fn surrogate_at(bytes: &[u8], (unit, big_endian): (usize, bool)) -> Option<(char, usize)> {
    let (code, length) = if unit == 1 {
        let [
            first @ 0xe0..=0xef,
            second @ 0x80..=0xbf,
            third @ 0x80..=0xbf,
        ] = *bytes.get(..3)?
        else {
            return None;
        };
        let part = |byte: u8| u32::from(byte & 0x3f);
        (
            u32::from(first & 0x0f) << 12 | part(second) << 6 | part(third),
            3,
        )
    } else {
        let mut units = bytes.get(..unit)?.to_vec();
        if !big_endian {
            units.reverse();
        }
        (
            units
                .iter()
                .fold(0, |code, byte| code << 8 | u32::from(*byte)),
            unit,
        )
    };
    (0xd800..0xe000)
        .contains(&code)
        .then(|| char_of(code))
        .flatten()
        .map(|c| (c, length))
}
