//! Encodings: text to bytes and back. What does not fit goes to the handler of errors (`handler`).

mod chinese;
mod escape;
mod handler;
mod pages;

use self::chinese::{GbDecodeError, GbEncoding};
use self::handler::{CodecError, ErrorHandler};
use self::pages::CodePage;
use elite_syntax::surrogate::{code_of, is_surrogate, may_have_surrogates};
use std::rc::Rc;

use super::string::text_argument;
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::limits::chunked::{BULK_CHUNK, WORK_PER_BYTE, pieces};
use crate::value::{R, Str, Value};

/// An encoding.
#[derive(Clone, Copy)]
enum Codec {
    Utf8 {
        /// A byte order mark is written, and left out when it is read.
        mark: bool,
    },
    Ascii,
    Latin1,
    /// Bytes per unit, whether the high byte comes first, whether a byte order mark is written and read.
    Wide {
        unit: usize,
        big_endian: bool,
        mark: bool,
    },
    Page(&'static CodePage),
    Chinese(GbEncoding),
    Escapes {
        raw: bool,
    },
}

/// Encodings of CPython that are none of text.
const NOT_OF_TEXT: &[&str] = &[
    "base64",
    "base64_codec",
    "bz2",
    "bz2_codec",
    "hex",
    "hex_codec",
    "quopri",
    "quopri_codec",
    "rot13",
    "rot_13",
    "uu",
    "uu_codec",
    "zip",
    "zlib",
    "zlib_codec",
];

impl Codec {
    /// The name that messages about an encoding have.
    fn name(self) -> &'static str {
        match self {
            Codec::Utf8 { .. } => "utf-8",
            Codec::Ascii => "ascii",
            Codec::Latin1 => "latin-1",
            Codec::Wide {
                unit: 2,
                mark: true,
                ..
            } => "utf-16",
            Codec::Wide {
                unit: 2,
                big_endian: true,
                ..
            } => "utf-16-be",
            Codec::Wide { unit: 2, .. } => "utf-16-le",
            Codec::Wide { mark: true, .. } => "utf-32",
            Codec::Wide {
                big_endian: true, ..
            } => "utf-32-be",
            Codec::Wide { .. } => "utf-32-le",
            Codec::Page(_) => "charmap",
            Codec::Chinese(chinese) => chinese.name(),
            Codec::Escapes { raw: false } => "unicodeescape",
            Codec::Escapes { raw: true } => "rawunicodeescape",
        }
    }

    /// The name that `codecs.lookup` has.
    fn full_name(self) -> &'static str {
        match self {
            Codec::Utf8 { mark: true } => "utf-8-sig",
            Codec::Latin1 => "iso8859-1",
            Codec::Page(page) => page.name,
            Codec::Escapes { raw: false } => "unicode-escape",
            Codec::Escapes { raw: true } => "raw-unicode-escape",
            other => other.name(),
        }
    }

    fn find(name: &str) -> Option<Self> {
        let wide = |unit, big_endian, mark| Codec::Wide {
            unit,
            big_endian,
            mark,
        };
        let plain = normal(name);
        Some(match &*plain {
            "utf8" | "utf_8" | "u8" | "utf" | "cp65001" | "utf8_ucs2" | "utf8_ucs4" => {
                Codec::Utf8 { mark: false }
            }
            "utf_8_sig" => Codec::Utf8 { mark: true },
            "ascii" | "us_ascii" | "646" | "us" | "ansi_x3.4_1968" | "ibm367" | "cp367"
            | "iso646_us" => Codec::Ascii,
            "latin1" | "latin_1" | "iso8859_1" | "iso_8859_1" | "8859" | "l1" | "latin"
            | "iso8859" | "cp819" | "ibm819" => Codec::Latin1,
            "utf16" | "utf_16" | "u16" => wide(2, false, true),
            "utf_16_le" | "utf_16le" | "utf16_le" | "utf16le" | "unicodelittleunmarked" => {
                wide(2, false, false)
            }
            "utf_16_be" | "utf_16be" | "utf16_be" | "utf16be" | "unicodebigunmarked" => {
                wide(2, true, false)
            }
            "utf32" | "utf_32" | "u32" => wide(4, false, true),
            "utf_32_le" | "utf_32le" | "utf32_le" | "utf32le" => wide(4, false, false),
            "utf_32_be" | "utf_32be" | "utf32_be" | "utf32be" => wide(4, true, false),
            "gb2312" | "chinese" | "csiso58gb231280" | "euc_cn" | "euccn" | "eucgb2312_cn"
            | "gb2312_1980" | "gb2312_80" | "iso_ir_58" => Codec::Chinese(GbEncoding::Gb2312),
            "gbk" | "936" | "cp936" | "ms936" => Codec::Chinese(GbEncoding::Gbk),
            "gb18030" | "gb18030_2000" => Codec::Chinese(GbEncoding::Gb18030),
            "unicode_escape" | "unicodeescape" => Codec::Escapes { raw: false },
            "raw_unicode_escape" | "rawunicodeescape" => Codec::Escapes { raw: true },
            other => Codec::Page(CodePage::find(other)?),
        })
    }

    /// Appends the bytes of a character; false if it has none.
    #[inline]
    fn encode_char(self, c: char, out: &mut Vec<u8>) -> bool {
        match self {
            Codec::Utf8 { .. } if is_surrogate(c) => return false,
            Codec::Utf8 { .. } => out.extend_from_slice(c.encode_utf8(&mut [0; 4]).as_bytes()),
            Codec::Ascii if c.is_ascii() => out.push(c as u8),
            Codec::Latin1 if (c as u32) < 256 => out.push(c as u32 as u8),
            Codec::Ascii | Codec::Latin1 => return false,
            Codec::Wide { .. } if is_surrogate(c) => return false,
            Codec::Wide {
                unit, big_endian, ..
            } => wide(c, unit, big_endian, out),
            Codec::Page(page) => match page.encode(c) {
                Some(byte) => out.push(byte),
                None => return false,
            },
            Codec::Chinese(_) if c.is_ascii() => out.push(c as u8),
            Codec::Chinese(_) if is_surrogate(c) => return false,
            Codec::Chinese(chinese) => return chinese.encode(c, out),
            Codec::Escapes { raw } => escape::encode(c, raw, out),
        }
        true
    }

    fn reason(self) -> &'static str {
        match self {
            Codec::Ascii => "ordinal not in range(128)",
            Codec::Latin1 => "ordinal not in range(256)",
            Codec::Page(_) => "character maps to <undefined>",
            Codec::Chinese(_) => "illegal multibyte sequence",
            Codec::Utf8 { .. } | Codec::Wide { .. } | Codec::Escapes { .. } => {
                "surrogates not allowed"
            }
        }
    }

    /// Whether an error of encoding takes in all characters that follow and do not fit either.
    fn takes_runs(self) -> bool {
        !matches!(self, Codec::Chinese(_) | Codec::Wide { .. })
    }
}

/// The name of an encoding as they are compared: parts in small letters, `_` between them.
fn normal(name: &str) -> String {
    let parts = name.split(|c: char| !c.is_ascii_alphanumeric() && c != '.');
    let parts: Vec<String> = parts
        .filter(|part| !part.is_empty())
        .map(str::to_ascii_lowercase)
        .collect();
    parts.join("_")
}

/// How much of bytes has been decoded, and what is left for when more of them are there.
pub struct DecodeResult {
    /// The text.
    pub text: String,
    /// How many bytes it took.
    pub length: usize,
}

impl Evaluator<'_> {
    /// Text of bytes in an encoding.
    pub fn decode(&self, data: &[u8], encoding: &Value, errors: &Value) -> R {
        self.check_codec_arguments("decode", encoding, errors)?;
        if data.is_empty() {
            // CPython looks up no codec for nothing.
            return Ok(Value::str(""));
        }
        let codec = self.codec(encoding, "decode")?;
        let decoded = self.decode_some(data, codec, errors, true)?;
        self.new_str(decoded.text)
    }

    /// The name of an encoding as `codecs.lookup` has it; an error if there is none.
    pub fn codec_name(&self, encoding: &Value) -> R<&'static str> {
        self.codec(encoding, "lookup").map(Codec::full_name)
    }

    /// Text of bytes of which more may come: what is cut at their end is left.
    pub fn decode_begun(
        &self,
        data: &[u8],
        encoding: &Value,
        errors: &Value,
        is_end: bool,
    ) -> R<DecodeResult> {
        let codec = self.codec(encoding, "decode")?;
        self.decode_some(data, codec, errors, is_end)
    }

    fn decode_some(
        &self,
        data: &[u8],
        codec: Codec,
        errors: &Value,
        is_end: bool,
    ) -> R<DecodeResult> {
        let errors = self.handler(errors, "decode")?;
        // What does not fit becomes up to four characters a byte.
        self.check_allocation(data.len().saturating_mul(4))?;
        let mut out = String::new();
        self.grow(&mut out, data.len())?;
        let (mut codec, mut at) = after_mark(codec, data);
        let mut data = std::borrow::Cow::Borrowed(data);
        while at < data.len() {
            match step(codec, &data, at) {
                Ok((text, length)) => {
                    match text {
                        DecodeStep::Text(text) => match may_have_surrogates(text) {
                            // Some characters of the text stand for surrogates, which UTF-8 does not have.
                            true => {
                                let others = text.replace(is_surrogate, "\u{fffd}");
                                self.push_text(&mut out, &others)?;
                            }
                            false => self.push_text(&mut out, text)?,
                        },
                        DecodeStep::Char(c) => {
                            self.grow(&mut out, 4)?;
                            out.push(c);
                        }
                        DecodeStep::Nothing => {}
                    }
                    self.charge(WORK_PER_BYTE)?;
                    at += length;
                }
                Err(DecodeFault {
                    length,
                    reason,
                    is_cut,
                }) => {
                    self.charge(4 * WORK_PER_BYTE)?;
                    let end = (at + length).min(data.len());
                    if is_cut && !is_end {
                        break;
                    }
                    let trouble = CodecError {
                        codec: codec.name(),
                        start: at,
                        end,
                        reason,
                    };
                    let unit = match codec {
                        Codec::Wide {
                            unit, big_endian, ..
                        } => Some((unit, big_endian)),
                        Codec::Utf8 { .. } => Some((1, false)),
                        _ => None,
                    };
                    let mended = self.handle_decode_error(&errors, &data, unit, trouble)?;
                    self.push_text(&mut out, &mended.text)?;
                    if let Some(other) = mended.data {
                        data = std::borrow::Cow::Owned(other);
                    }
                    at = mended.next;
                    if let Codec::Utf8 { mark: true } = codec {
                        codec = Codec::Utf8 { mark: false };
                    }
                }
            }
        }
        Ok(DecodeResult {
            text: out,
            length: at.min(data.len()),
        })
    }

    /// Bytes of text in an encoding.
    pub fn encode(&self, text: &Str, encoding: &Value, errors: &Value) -> R<Vec<u8>> {
        self.check_codec_arguments("encode", encoding, errors)?;
        let codec = self.codec(encoding, "encode")?;
        let errors = self.handler(errors, "encode")?;
        // Up to ten bytes stand for a character that does not fit.
        self.check_allocation(text.len().saturating_mul(match (codec, &errors) {
            (Codec::Ascii | Codec::Latin1 | Codec::Page(_), ErrorHandler::Strict) => 1,
            (Codec::Utf8 { .. }, _) => 4,
            _ => 10,
        }))?;
        let mut out = Vec::new();
        match codec {
            Codec::Utf8 { mark } if !may_have_surrogates(text.as_str()) => {
                if mark {
                    out.extend_from_slice(MARK_OF_UTF8);
                    out.extend(self.copy_bytes(text.as_str().as_bytes())?);
                    return Ok(out);
                }
                return self.copy_bytes(text.as_str().as_bytes());
            }
            Codec::Utf8 { mark: true } => out.extend_from_slice(MARK_OF_UTF8),
            Codec::Wide {
                unit,
                big_endian,
                mark: true,
            } => wide('\u{feff}', unit, big_endian, &mut out),
            _ => {}
        }
        // Bytes are only added, so what has been done stays when a handler goes back.
        let mut at = 0;
        let mut rest = text.as_str();
        while !rest.is_empty() {
            let mut stopped = false;
            for piece in pieces(rest) {
                self.grow(&mut out, piece.len())?;
                let mut done = 0;
                for c in piece.chars() {
                    if !codec.encode_char(c, &mut out) {
                        stopped = true;
                        break;
                    }
                    done += c.len_utf8();
                    at += 1;
                }
                self.charge(done.max(1) * WORK_PER_BYTE)?;
                rest = &rest[done..];
                if stopped {
                    break;
                }
            }
            if stopped {
                // Where characters are is asked from here on.
                self.index_chars(text)?;
                let mut scratch = Vec::new();
                let run = rest
                    .chars()
                    .take_while(|c| !codec.encode_char(*c, &mut scratch));
                let count = if codec.takes_runs() { run.count() } else { 1 };
                let trouble = CodecError {
                    codec: codec.name(),
                    start: at,
                    end: at + count,
                    reason: codec.reason(),
                };
                let next = self.handle_encode_error(codec, &errors, text, trouble, &mut out)?;
                at = next;
                rest = &text.as_str()[text.byte_offset(next)..];
                self.charge(count * WORK_PER_BYTE)?;
            }
        }
        Ok(out)
    }

    /// Refuses an encoding and a handler of errors that are no names, before either is looked up.
    pub fn check_codec_arguments(&self, function: &str, encoding: &Value, errors: &Value) -> R<()> {
        self.codec_argument(function, "encoding", encoding)?;
        self.codec_argument(function, "errors", errors)?;
        Ok(())
    }

    pub(super) fn codec_argument(
        &self,
        function: &str,
        argument: &str,
        value: &Value,
    ) -> R<Option<Rc<Str>>> {
        let Some(value) = value.if_given() else {
            return Ok(None);
        };
        let text = text_argument(self, value).map_err(|_| {
            let name = self.core.types.name_of_argument(value);
            self.type_error(format!(
                "{function}() argument '{argument}' must be str, not {name}"
            ))
        })?;
        if may_have_surrogates(text.as_str()) {
            // C takes the name as UTF-8, which has no surrogates.
            self.encode(&text, &Value::Unbound, &Value::Unbound)?;
        }
        if text.as_str().contains('\0') {
            return Err(self.value_error("embedded null character"));
        }
        Ok(Some(text))
    }

    fn codec(&self, name: &Value, method: &str) -> R<Codec> {
        let Some(text) = self.codec_argument(method, "encoding", name)? else {
            return Ok(Codec::Utf8 { mark: false });
        };
        Codec::find(text.as_str()).ok_or_else(|| {
            let name = text.as_str();
            let message = match NOT_OF_TEXT.contains(&&*normal(name)) {
                true => format!(
                    "'{name}' is not a text encoding; use codecs.{method}() to handle arbitrary codecs"
                ),
                false => format!("unknown encoding: {name}"),
            };
            self.raise(ExceptionKind::LookupError, message)
        })
    }
}

const MARK_OF_UTF8: &[u8] = b"\xef\xbb\xbf";

/// Where decoding begins, and by which order of bytes it goes on.
fn after_mark(codec: Codec, data: &[u8]) -> (Codec, usize) {
    match codec {
        Codec::Utf8 { mark: true } if data.starts_with(MARK_OF_UTF8) => (codec, MARK_OF_UTF8.len()),
        Codec::Wide {
            unit, mark: true, ..
        } => {
            let (little, big): (&[u8], &[u8]) = match unit {
                2 => (&[0xff, 0xfe], &[0xfe, 0xff]),
                _ => (&[0xff, 0xfe, 0, 0], &[0, 0, 0xfe, 0xff]),
            };
            let big_endian = data.starts_with(big);
            let at = if big_endian || data.starts_with(little) {
                unit
            } else {
                0
            };
            let codec = Codec::Wide {
                unit,
                big_endian,
                mark: false,
            };
            (codec, at)
        }
        other => (other, 0),
    }
}

/// What a step of decoding found.
enum DecodeStep<'d> {
    Text(&'d str),
    Char(char),
    /// Bytes that stand for nothing.
    Nothing,
}

/// Bytes that do not decode: how many, why, and whether they are right as far as they go.
struct DecodeFault {
    length: usize,
    reason: &'static str,
    is_cut: bool,
}

fn fault(length: usize, reason: &'static str) -> DecodeFault {
    DecodeFault {
        length,
        reason,
        is_cut: false,
    }
}

fn incomplete(length: usize, reason: &'static str) -> DecodeFault {
    DecodeFault {
        length,
        reason,
        is_cut: true,
    }
}

/// Decodes at `at`: text and its length in bytes.
fn step(codec: Codec, data: &[u8], at: usize) -> Result<(DecodeStep<'_>, usize), DecodeFault> {
    let rest = &data[at..];
    match codec {
        Codec::Utf8 { .. } => match std::str::from_utf8(&rest[..rest.len().min(BULK_CHUNK)]) {
            Ok(text) => Ok((DecodeStep::Text(text), text.len())),
            Err(wrong) if wrong.valid_up_to() > 0 => {
                let valid = wrong.valid_up_to();
                let text = std::str::from_utf8(&rest[..valid]).unwrap_or("");
                Ok((DecodeStep::Text(text), valid))
            }
            // A character that is cut by the end of the piece is not at its beginning.
            Err(wrong) => Err(match (wrong.error_len(), rest[0]) {
                (None, _) => incomplete(rest.len(), "unexpected end of data"),
                (Some(length), 0x80..=0xc1 | 0xf5..) => fault(length, "invalid start byte"),
                (Some(length), _) => fault(length, "invalid continuation byte"),
            }),
        },
        Codec::Ascii if !rest[0].is_ascii() => Err(fault(1, "ordinal not in range(128)")),
        Codec::Ascii | Codec::Latin1 => Ok((DecodeStep::Char(char::from(rest[0])), 1)),
        Codec::Wide {
            unit, big_endian, ..
        } => wide_step(rest, unit, big_endian),
        Codec::Page(page) => match page.decode(rest[0]) {
            Some(c) => Ok((DecodeStep::Char(c), 1)),
            None => Err(fault(1, "character maps to <undefined>")),
        },
        Codec::Chinese(_) if rest[0].is_ascii() => Ok((DecodeStep::Char(char::from(rest[0])), 1)),
        Codec::Chinese(chinese) => match chinese.decode(rest) {
            Ok((c, length)) => Ok((DecodeStep::Char(c), length)),
            Err(GbDecodeError::Incomplete) => {
                Err(incomplete(rest.len(), "incomplete multibyte sequence"))
            }
            Err(GbDecodeError::Illegal) => Err(fault(1, "illegal multibyte sequence")),
        },
        Codec::Escapes { raw } => match escape::decode(rest, raw) {
            Ok((Some('\\'), 1)) if raw && rest.len() > 1 && rest[0] == b'\\' => {
                // A pair of them is no escape's beginning.
                let length = if rest[1] == b'\\' { 2 } else { 1 };
                Ok((DecodeStep::Text(&"\\\\"[..length]), length))
            }
            Ok((Some(c), length)) => Ok((DecodeStep::Char(c), length)),
            Ok((None, length)) => Ok((DecodeStep::Nothing, length)),
            Err((length, reason)) if length >= rest.len() => Err(incomplete(length, reason)),
            Err((length, reason)) => Err(fault(length, reason)),
        },
    }
}

fn wide_step(
    rest: &[u8],
    unit: usize,
    big_endian: bool,
) -> Result<(DecodeStep<'static>, usize), DecodeFault> {
    let number = |bytes: &[u8]| -> u32 {
        let shift = |value: u32, byte: &u8| value << 8 | u32::from(*byte);
        if big_endian {
            bytes.iter().fold(0, shift)
        } else {
            bytes.iter().rev().fold(0, shift)
        }
    };
    let Some(first) = rest.get(..unit).map(number) else {
        return Err(incomplete(rest.len(), "truncated data"));
    };
    if unit == 2 && (0xd800..0xdc00).contains(&first) {
        let Some(second) = rest.get(2..4).map(number) else {
            return Err(incomplete(rest.len(), "unexpected end of data"));
        };
        if !(0xdc00..0xe000).contains(&second) {
            return Err(fault(2, "illegal UTF-16 surrogate"));
        }
        let code = 0x1_0000 + ((first - 0xd800) << 10) + (second - 0xdc00);
        return Ok((DecodeStep::Char(char_of_scalar(code)), 4));
    }
    match char::from_u32(first) {
        Some(_) => Ok((DecodeStep::Char(char_of_scalar(first)), unit)),
        None if unit == 2 => Err(fault(2, "illegal encoding")),
        None if first < 0x11_0000 => Err(fault(
            4,
            "code point in surrogate code point range(0xd800, 0xe000)",
        )),
        None => Err(fault(4, "code point not in range(0x110000)")),
    }
}

/// The character of a code point that is no surrogate.
fn char_of_scalar(code: u32) -> char {
    elite_syntax::surrogate::char_of(code).unwrap_or(char::REPLACEMENT_CHARACTER)
}

/// Appends the units of a character; of a surrogate the one it is.
fn wide(c: char, unit: usize, big_endian: bool, out: &mut Vec<u8>) {
    let mut push = |code: u32| {
        let bytes = code.to_be_bytes();
        let low = &bytes[4 - unit..];
        if big_endian {
            out.extend_from_slice(low);
        } else {
            out.extend(low.iter().rev());
        }
    };
    if unit == 4 || is_surrogate(c) {
        push(code_of(c));
    } else {
        c.encode_utf16(&mut [0; 2])
            .iter()
            .for_each(|unit| push(u32::from(*unit)));
    }
}
