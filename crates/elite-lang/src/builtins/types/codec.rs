//! Encodings: text to bytes and back, with Python's error handlers.

use super::string::text_argument;
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::eval::bulk::{EACH, STRIDE, pieces};
use crate::value::{R, Raised, Str, Value};

/// An encoding, with the name messages use.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Codec {
    Utf8,
    Ascii,
    Latin1,
    /// Bytes per unit, whether the high byte comes first, whether a byte order mark is written and read.
    Wide {
        unit: usize,
        big_endian: bool,
        mark: bool,
    },
}

impl Codec {
    fn name(self) -> &'static str {
        match self {
            Codec::Utf8 => "utf-8",
            Codec::Ascii => "ascii",
            Codec::Latin1 => "latin-1",
            Codec::Wide { unit: 2, .. } => "utf-16",
            Codec::Wide { .. } => "utf-32",
        }
    }

    fn find(name: &str) -> Option<Self> {
        let wide = |unit, big_endian, mark| Codec::Wide {
            unit,
            big_endian,
            mark,
        };
        let plain = name.to_lowercase().replace(['-', '_', ' '], "");
        Some(match &*plain {
            "utf8" | "u8" => Codec::Utf8,
            "ascii" | "usascii" | "646" => Codec::Ascii,
            "latin1" | "iso88591" | "l1" | "latin" | "8859" => Codec::Latin1,
            "utf16" | "u16" => wide(2, false, true),
            "utf16le" => wide(2, false, false),
            "utf16be" => wide(2, true, false),
            "utf32" | "u32" => wide(4, false, true),
            "utf32le" => wide(4, false, false),
            "utf32be" => wide(4, true, false),
            _ => return None,
        })
    }
}

impl Evaluator<'_> {
    /// Text of bytes in an encoding. `errors` is `strict`, `ignore`, `replace` or `backslashreplace`.
    pub fn decode(&self, data: &[u8], encoding: &Value, errors: &Value) -> R {
        let (codec, errors) = (self.codec(encoding, "decode")?, self.handler(errors)?);
        // What does not fit becomes up to four characters a byte.
        self.check_allocation(data.len().saturating_mul(4))?;
        let mut out = String::new();
        self.grow(&mut out, data.len())?;
        let mut at = 0;
        let mut codec = codec;
        if let Codec::Wide {
            unit, mark: true, ..
        } = codec
        {
            let (little, big): (&[u8], &[u8]) = if unit == 2 {
                (&[0xff, 0xfe], &[0xfe, 0xff])
            } else {
                (&[0xff, 0xfe, 0, 0], &[0, 0, 0xfe, 0xff])
            };
            let big_endian = data.starts_with(big);
            if big_endian || data.starts_with(little) {
                at = unit;
            }
            codec = Codec::Wide {
                unit,
                big_endian,
                mark: true,
            };
        }
        while at < data.len() {
            match step(codec, data, at) {
                Ok((text, length)) => {
                    match text {
                        Step::Text(text) => self.push_text(&mut out, text)?,
                        Step::Char(c) => {
                            self.grow(&mut out, 4)?;
                            out.push(c);
                        }
                    }
                    self.worked(EACH)?;
                    at += length;
                }
                Err((length, reason)) => {
                    self.worked(4 * EACH)?;
                    let end = (at + length).min(data.len());
                    match &*errors {
                        "ignore" => {}
                        "replace" => out.push('\u{fffd}'),
                        "backslashreplace" => {
                            for byte in &data[at..end] {
                                out.push_str(&format!("\\x{byte:02x}"));
                            }
                        }
                        "strict" => {
                            let copy = self.copied_bytes(data)?;
                            let object = Value::bytes(copy);
                            return Err(self.codec_error(codec, object, (at, end), reason, false));
                        }
                        other => return Err(self.unknown_handler(other)),
                    }
                    at = end;
                }
            }
        }
        self.string(out)
    }

    /// Bytes of text in an encoding. `errors` is as for `decode`, or `xmlcharrefreplace`.
    pub fn encode(&self, text: &Str, encoding: &Value, errors: &Value) -> R<Vec<u8>> {
        let (codec, errors) = (self.codec(encoding, "encode")?, self.handler(errors)?);
        // Up to ten bytes stand for a character that does not fit.
        self.check_allocation(text.len().saturating_mul(match (codec, &*errors) {
            (Codec::Ascii | Codec::Latin1, "strict") => 1,
            (Codec::Ascii | Codec::Latin1, _) => 10,
            _ => 4,
        }))?;
        let limit = match codec {
            Codec::Utf8 => return self.copied_bytes(text.as_str().as_bytes()),
            Codec::Wide {
                unit,
                big_endian,
                mark,
            } => {
                let mut out = Vec::new();
                self.grow(&mut out, text.len().saturating_mul(unit))?;
                if mark {
                    wide("\u{feff}", unit, big_endian, &mut out);
                }
                for piece in pieces(text.as_str()) {
                    self.grow(&mut out, piece.len().saturating_mul(unit))?;
                    wide(piece, unit, big_endian, &mut out);
                    self.worked(piece.len() * EACH)?;
                }
                return Ok(out);
            }
            Codec::Ascii => 128,
            Codec::Latin1 => 256,
        };
        let mut out = Vec::with_capacity(text.len());
        let fits = |c: char| (c as u32) < limit;
        for (at, c) in text.as_str().chars().enumerate() {
            self.worked(EACH)?;
            match &*errors {
                _ if fits(c) => out.push(c as u32 as u8),
                "ignore" => {}
                "replace" => out.push(b'?'),
                "xmlcharrefreplace" => {
                    out.extend_from_slice(format!("&#{};", c as u32).as_bytes());
                }
                "backslashreplace" => {
                    let shown = match c as u32 {
                        code @ 0..0x100 => format!("\\x{code:02x}"),
                        code @ 0x100..0x1_0000 => format!("\\u{code:04x}"),
                        code => format!("\\U{code:08x}"),
                    };
                    out.extend_from_slice(shown.as_bytes());
                }
                "strict" => {
                    let rest = text.as_str().chars().skip(at);
                    let end = at + rest.take_while(|c| !fits(*c)).count();
                    let reason = format!("ordinal not in range({limit})");
                    let object = Value::str(text.as_str());
                    return Err(self.codec_error(codec, object, (at, end), &reason, true));
                }
                other => return Err(self.unknown_handler(other)),
            }
        }
        Ok(out)
    }

    fn codec(&self, name: &Value, method: &str) -> R<Codec> {
        let Some(value) = name.given() else {
            return Ok(Codec::Utf8);
        };
        let text = text_argument(self, value).map_err(|_| {
            let name = self.core.types.name_of(value);
            self.type_error(format!(
                "{method}() argument 'encoding' must be str, not {name}"
            ))
        })?;
        Codec::find(text.as_str()).ok_or_else(|| {
            let message = format!("unknown encoding: {}", text.as_str());
            self.raise(ExceptionKind::LookupError, message)
        })
    }

    fn handler(&self, name: &Value) -> R<String> {
        match name.given() {
            None => Ok("strict".to_owned()),
            Some(value) => Ok(text_argument(self, value)?.as_str().to_owned()),
        }
    }

    fn unknown_handler(&self, name: &str) -> Raised {
        let message = format!("unknown error handler name '{name}'");
        self.raise(ExceptionKind::LookupError, message)
    }

    #[cold]
    fn codec_error(
        &self,
        codec: Codec,
        object: Value,
        (start, end): (usize, usize),
        reason: &str,
        encoding: bool,
    ) -> Raised {
        let kind = if encoding {
            ExceptionKind::UnicodeEncodeError
        } else {
            ExceptionKind::UnicodeDecodeError
        };
        let args = vec![
            Value::str(codec.name()),
            object,
            Value::Int(start as i64),
            Value::Int(end as i64),
            Value::str(reason),
        ];
        let class = Value::Class(self.core.types.exception(kind).clone());
        match self.call(&class, &mut { args }, &[]) {
            Ok(Value::Instance(exception)) => Raised::Exception(exception),
            Ok(_) => self.value_error(reason),
            Err(raised) => raised,
        }
    }
}

/// What a step of decoding found.
enum Step<'d> {
    Text(&'d str),
    Char(char),
}

/// Decodes at `at`: text and its length in bytes, or how many bytes are wrong and why.
fn step(codec: Codec, data: &[u8], at: usize) -> Result<(Step<'_>, usize), (usize, &'static str)> {
    let rest = &data[at..];
    match codec {
        Codec::Utf8 => match std::str::from_utf8(&rest[..rest.len().min(STRIDE)]) {
            Ok(text) => Ok((Step::Text(text), text.len())),
            Err(wrong) if wrong.valid_up_to() > 0 => {
                let valid = wrong.valid_up_to();
                let text = std::str::from_utf8(&rest[..valid]).unwrap_or("");
                Ok((Step::Text(text), valid))
            }
            // A character that is cut by the end of the piece is not at its beginning.
            Err(wrong) => Err(match (wrong.error_len(), rest[0]) {
                (None, _) => (rest.len(), "unexpected end of data"),
                (Some(length), 0x80..=0xc1 | 0xf5..) => (length, "invalid start byte"),
                (Some(length), _) => (length, "invalid continuation byte"),
            }),
        },
        Codec::Ascii if !rest[0].is_ascii() => Err((1, "ordinal not in range(128)")),
        Codec::Ascii | Codec::Latin1 => Ok((Step::Char(char::from(rest[0])), 1)),
        Codec::Wide {
            unit, big_endian, ..
        } => wide_step(rest, unit, big_endian),
    }
}

fn wide_step(
    rest: &[u8],
    unit: usize,
    big_endian: bool,
) -> Result<(Step<'static>, usize), (usize, &'static str)> {
    let number = |bytes: &[u8]| -> u32 {
        let shift = |value: u32, byte: &u8| value << 8 | u32::from(*byte);
        if big_endian {
            bytes.iter().fold(0, shift)
        } else {
            bytes.iter().rev().fold(0, shift)
        }
    };
    let Some(first) = rest.get(..unit).map(number) else {
        return Err((rest.len(), "truncated data"));
    };
    if unit == 2 && (0xd800..0xdc00).contains(&first) {
        let Some(second) = rest.get(2..4).map(number) else {
            return Err((rest.len(), "unexpected end of data"));
        };
        if !(0xdc00..0xe000).contains(&second) {
            return Err((2, "illegal UTF-16 surrogate"));
        }
        let code = 0x1_0000 + ((first - 0xd800) << 10) + (second - 0xdc00);
        return Ok((Step::Char(char::from_u32(code).unwrap_or('\u{fffd}')), 4));
    }
    match char::from_u32(first) {
        Some(c) => Ok((Step::Char(c), unit)),
        None if unit == 2 => Err((2, "illegal encoding")),
        None => Err((4, "code point not in range(0x110000)")),
    }
}

fn wide(text: &str, unit: usize, big_endian: bool, out: &mut Vec<u8>) {
    let mut push = |code: u32| {
        let bytes = code.to_be_bytes();
        let low = &bytes[4 - unit..];
        if big_endian {
            out.extend_from_slice(low);
        } else {
            out.extend(low.iter().rev());
        }
    };
    for c in text.chars() {
        if unit == 4 {
            push(c as u32);
        } else {
            c.encode_utf16(&mut [0; 2])
                .iter()
                .for_each(|unit| push(u32::from(*unit)));
        }
    }
}
