//! Exceptions, byte for byte: script errors and robot errors. Layout as the official SDK reads it (include/Primary).

use core::fmt;

use messages::{Language, Localized};

use super::fields::{FieldCodec, FieldReader, FieldWriter, append_length_prefixed};
use super::{DecodeError, ROBOT_EXCEPTION};

/// Longest text of an exception, bytes; more is cut at a character.
pub const TEXT_BYTES_MAX: usize = 16 * 1024;

const KIND_ROBOT_ERROR: u8 = 6;
const KIND_SCRIPT_ERROR: u8 = 10;

/// Part of the robot that reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum ExceptionSource {
    /// The safety system.
    Safety = 99,
    /// The pendant's program.
    Gui = 103,
    /// The controller.
    Controller = 104,
    /// The RTSI port.
    Rtsi = 105,
    /// A joint.
    Joint = 120,
    /// The tool.
    Tool = 121,
    /// The teach pendant.
    TeachPendant = 122,
}

/// Severity of an exception.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum ExceptionLevel {
    /// Something worth knowing.
    Info = 0,
    /// Something to look at.
    Warning = 1,
    /// Something failed.
    Error = 2,
    /// The robot stops.
    Fatal = 3,
}

/// What comes with a robot error.
#[derive(Clone, Debug, PartialEq)]
pub enum ErrorData {
    /// No data.
    None,
    /// A number.
    Unsigned(u32),
    /// A number with a sign.
    Signed(i32),
    /// A number with a fraction.
    Float(f32),
    /// A number that people read as hexadecimal.
    Hex(u32),
    /// A sentence.
    Text(String),
    /// A joint, from 0.
    Joint(i32),
}

impl Localized for ErrorData {
    /// Writes the data the way people read it; [`Self::None`] writes nothing. A text comes from the peer unchanged:
    /// whoever shows it has to make it harmless.
    fn fmt_in(&self, language: Language, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => Ok(()),
            Self::Unsigned(value) => fmt::Display::fmt(value, f),
            Self::Signed(value) => fmt::Display::fmt(value, f),
            Self::Float(value) => fmt::Display::fmt(value, f),
            Self::Hex(value) => write!(f, "{value:#x}"),
            Self::Text(text) => f.write_str(text),
            Self::Joint(joint) => {
                let word = language.pick("joint", "关节");
                write!(f, "{word} {}", joint.saturating_add(1))
            }
        }
    }
}

impl fmt::Display for ErrorData {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.fmt_in(Language::English, f)
    }
}

/// A robot error on one line: `100.12: protective stop`.
#[derive(Clone, Copy, Debug)]
pub struct RobotErrorDisplay<'a> {
    /// Number of the error.
    pub code: i32,
    /// Number of the reason.
    pub sub_code: i32,
    /// What comes with it.
    pub data: &'a ErrorData,
}

impl Localized for RobotErrorDisplay<'_> {
    fn fmt_in(&self, language: Language, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.code, self.sub_code)?;
        match self.data {
            ErrorData::None => Ok(()),
            data => {
                f.write_str(language.pick(": ", "："))?;
                data.fmt_in(language, f)
            }
        }
    }
}

impl fmt::Display for RobotErrorDisplay<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.fmt_in(Language::English, f)
    }
}

/// Something that every client should hear about.
#[derive(Clone, Debug, PartialEq)]
pub enum Exception {
    /// A script does not compile or failed.
    Script {
        /// Line of the script as received, from 1.
        line: i32,
        /// Column, from 1.
        column: i32,
        /// What happened.
        text: String,
    },
    /// The robot stopped or warns.
    Robot {
        /// Number of the error.
        code: i32,
        /// Number of the reason.
        sub_code: i32,
        /// Severity of the exception.
        level: ExceptionLevel,
        /// What comes with it.
        data: ErrorData,
    },
}

/// An exception as it arrives.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotException {
    /// When: the SDK's header says milliseconds, its manual microseconds.
    pub timestamp: u64,
    /// Number of the part of the robot that reports; see [`ExceptionSource`].
    pub source: u8,
    /// What happened.
    pub exception: Exception,
}

/// The whole message. `unix_millis` is the time of the event: the SDK's header says milliseconds, its manual
/// microseconds; the header is what its programs are compiled with. Texts end with a NUL, which the vendor's clients
/// cut off.
pub fn encode_exception(
    unix_millis: u64,
    source: ExceptionSource,
    exception: &Exception,
) -> Vec<u8> {
    let mut out = Vec::with_capacity(64);
    append_length_prefixed(&mut out, ROBOT_EXCEPTION, |out| {
        out.extend(unix_millis.to_be_bytes());
        out.push(source as u8);
        match exception {
            Exception::Script { line, column, text } => {
                out.push(KIND_SCRIPT_ERROR);
                out.extend(line.to_be_bytes());
                out.extend(column.to_be_bytes());
                append_text(out, text);
            }
            Exception::Robot {
                code,
                sub_code,
                level,
                data,
            } => {
                out.push(KIND_ROBOT_ERROR);
                out.extend(code.to_be_bytes());
                out.extend(sub_code.to_be_bytes());
                out.extend((*level as i32).to_be_bytes());
                let (data_type, bits) = match data {
                    // The SDK reads a number even where there is none.
                    ErrorData::None => (0, 0),
                    ErrorData::Unsigned(value) => (1, *value),
                    ErrorData::Signed(value) => (2, value.cast_unsigned()),
                    ErrorData::Float(value) => (3, value.to_bits()),
                    ErrorData::Hex(value) => (4, *value),
                    ErrorData::Joint(value) => (6, value.cast_unsigned()),
                    ErrorData::Text(text) => {
                        out.extend(5_u32.to_be_bytes());
                        return append_text(out, text);
                    }
                };
                // Writing cannot fail.
                let _ = FieldWriter(out).u32(&mut { data_type });
                let _ = FieldWriter(out).u32(&mut { bits });
            }
        }
    });
    out
}

fn append_text(out: &mut Vec<u8>, text: &str) {
    let end = text.floor_char_boundary(TEXT_BYTES_MAX);
    // A NUL inside would end the text for clients that stop at one.
    out.extend(text[..end].bytes().map(|b| if b == 0 { b' ' } else { b }));
    out.push(0);
}

/// Reads the body of an exception; `None` for a kind that is not known here.
pub(super) fn decode(body: &mut FieldReader<'_>) -> Result<Option<RobotException>, DecodeError> {
    let (mut timestamp, mut source, mut kind) = (0, 0, 0);
    body.u64(&mut timestamp)?;
    body.u8(&mut source)?;
    body.u8(&mut kind)?;
    let exception = match kind {
        KIND_SCRIPT_ERROR => {
            let (mut line, mut column) = (0, 0);
            body.i32(&mut line)?;
            body.i32(&mut column)?;
            let text = text(body.rest());
            Exception::Script { line, column, text }
        }
        KIND_ROBOT_ERROR => robot_error(body)?,
        _ => return Ok(None),
    };
    Ok(Some(RobotException {
        timestamp,
        source,
        exception,
    }))
}

fn robot_error(body: &mut FieldReader<'_>) -> Result<Exception, DecodeError> {
    let (mut code, mut sub_code, mut level, mut data_type, mut bits) = (0, 0, 0, 0, 0);
    body.i32(&mut code)?;
    body.i32(&mut sub_code)?;
    body.i32(&mut level)?;
    body.u32(&mut data_type)?;
    let data = if data_type == 5 {
        ErrorData::Text(text(body.rest()))
    } else {
        // Some leave out the number of an error without one.
        if data_type != 0 || !body.rest().is_empty() {
            body.u32(&mut bits)?;
        }
        match data_type {
            1 => ErrorData::Unsigned(bits),
            2 => ErrorData::Signed(bits.cast_signed()),
            3 => ErrorData::Float(f32::from_bits(bits)),
            4 => ErrorData::Hex(bits),
            6 => ErrorData::Joint(bits.cast_signed()),
            _ => ErrorData::None,
        }
    };
    Ok(Exception::Robot {
        code,
        sub_code,
        level: ExceptionLevel::from_number(level),
        data,
    })
}

/// A text to the end of the message, without what ends it.
fn text(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    text.trim_end_matches(['\0', '\n', '\r']).to_owned()
}

impl ExceptionLevel {
    /// The level with this number; beyond the last it is fatal, below the first to know.
    pub const fn from_number(number: i32) -> Self {
        match number {
            ..=0 => Self::Info,
            1 => Self::Warning,
            2 => Self::Error,
            _ => Self::Fatal,
        }
    }

    /// The name of the level, in one word.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Info => "info",
            Self::Warning => "warning",
            Self::Error => "error",
            Self::Fatal => "fatal",
        }
    }
}

impl ExceptionSource {
    /// What the number of a source means.
    pub const fn name(number: u8) -> &'static str {
        match number {
            99 => "safety",
            103 => "pendant program",
            104 => "controller",
            105 => "RTSI",
            120 => "joint",
            121 => "tool",
            122 => "teach pendant",
            200 => "joint electronics",
            201 => "tool electronics",
            _ => "robot",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hex(bytes: &[u8]) -> String {
        bytes
            .iter()
            .map(|b| format!("{b:02x}"))
            .collect::<Vec<_>>()
            .join(" ")
    }

    fn script(text: &str) -> Exception {
        Exception::Script {
            line: 2,
            column: 1,
            text: text.to_owned(),
        }
    }

    #[test]
    fn a_script_error_is_the_example_of_the_protocol_with_a_nul() {
        let bytes = encode_exception(
            1_700_000_000_000,
            ExceptionSource::Controller,
            &script("invalid syntax"),
        );
        assert_eq!(
            hex(&bytes),
            "00 00 00 26 14 00 00 01 8b cf e5 68 00 68 0a 00 00 00 02 00 00 00 01 \
             69 6e 76 61 6c 69 64 20 73 79 6e 74 61 78 00"
        );
    }

    #[test]
    fn a_robot_error_carries_its_numbers() {
        let error = |data| {
            let exception = Exception::Robot {
                code: 7,
                sub_code: -2,
                level: ExceptionLevel::Error,
                data,
            };
            encode_exception(1, ExceptionSource::Safety, &exception)
        };
        let head = "14 00 00 00 00 00 00 00 01 63 06 00 00 00 07 ff ff ff fe 00 00 00 02";
        for (data, tail) in [
            (ErrorData::None, "00 00 00 00 00 00 00 00"),
            (ErrorData::Unsigned(9), "00 00 00 01 00 00 00 09"),
            (ErrorData::Signed(-1), "00 00 00 02 ff ff ff ff"),
            (ErrorData::Float(1.5), "00 00 00 03 3f c0 00 00"),
            (ErrorData::Hex(0xce110), "00 00 00 04 00 0c e1 10"),
            (ErrorData::Joint(5), "00 00 00 06 00 00 00 05"),
        ] {
            assert_eq!(hex(&error(data)), format!("00 00 00 23 {head} {tail}"));
        }
        let text = error(ErrorData::Text("hé".to_owned()));
        assert_eq!(
            hex(&text),
            format!("00 00 00 23 {head} 00 00 00 05 68 c3 a9 00")
        );
    }

    #[test]
    fn a_robot_error_reads_as_a_line_whatever_comes_with_it() {
        for (data, line) in [
            (ErrorData::None, "7.-2"),
            (ErrorData::Unsigned(9), "7.-2: 9"),
            (ErrorData::Signed(-1), "7.-2: -1"),
            (ErrorData::Float(1.5), "7.-2: 1.5"),
            (ErrorData::Hex(0xce110), "7.-2: 0xce110"),
            (ErrorData::Text("tool lost".to_owned()), "7.-2: tool lost"),
            (ErrorData::Joint(5), "7.-2: joint 6"),
            (ErrorData::Joint(i32::MAX), "7.-2: joint 2147483647"),
        ] {
            let numbered = RobotErrorDisplay {
                code: 7,
                sub_code: -2,
                data: &data,
            };
            assert_eq!(numbered.to_string(), line);
        }
    }

    #[test]
    fn a_long_text_is_cut_at_a_character_and_holds_no_nul() {
        let bytes = encode_exception(
            0,
            ExceptionSource::Gui,
            &script(&"é".repeat(TEXT_BYTES_MAX)),
        );
        assert_eq!(bytes.len(), 23 + TEXT_BYTES_MAX + 1);
        assert!(core::str::from_utf8(&bytes[23..]).is_ok());
        let bytes = encode_exception(0, ExceptionSource::Gui, &script("a\0b"));
        assert_eq!(&bytes[23..], b"a b\0");
    }
}
