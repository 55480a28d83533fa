//! Exceptions on the primary port, byte for byte; the state message has a file of its own beside this one.
//!
//! Pure: numbers in, bytes out. Big-endian throughout. Layout as the official SDK reads it (include/Primary).

/// Type byte of a state message.
pub const ROBOT_STATE: u8 = 16;
/// Type byte of an exception.
pub const ROBOT_EXCEPTION: u8 = 20;

/// Longest text of an exception, bytes; more is cut at a character.
pub const TEXT_BYTES_MAX: usize = 16 * 1024;

const KIND_ROBOT_ERROR: u8 = 6;
const KIND_SCRIPT_ERROR: u8 = 10;

/// Which part of the robot reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Source {
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

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum Level {
    /// To know.
    Info = 0,
    /// To look at.
    Warning = 1,
    /// Something failed.
    Error = 2,
    /// The robot stops.
    Fatal = 3,
}

/// What comes with a robot error.
#[derive(Clone, Debug, PartialEq)]
pub enum ErrorData {
    /// Nothing.
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
        /// How bad it is.
        level: Level,
        /// What comes with it.
        data: ErrorData,
    },
}

/// The whole message. `unix_millis` is the time of the event: the SDK's header says milliseconds, its manual
/// microseconds; the header is what its programs are compiled with. Texts end with a NUL, which the vendor's clients
/// cut off.
pub fn encode_exception(unix_millis: u64, source: Source, exception: &Exception) -> Vec<u8> {
    let mut out = Writer::message(ROBOT_EXCEPTION);
    out.u64(unix_millis);
    out.u8(source as u8);
    match exception {
        Exception::Script { line, column, text } => {
            out.u8(KIND_SCRIPT_ERROR);
            out.i32(*line);
            out.i32(*column);
            out.text(text);
        }
        Exception::Robot {
            code,
            sub_code,
            level,
            data,
        } => {
            out.u8(KIND_ROBOT_ERROR);
            out.i32(*code);
            out.i32(*sub_code);
            out.i32(*level as i32);
            match data {
                // The SDK reads a number even where there is none.
                ErrorData::None => out.tagged(0, 0),
                ErrorData::Unsigned(value) => out.tagged(1, *value),
                ErrorData::Signed(value) => out.tagged(2, value.cast_unsigned()),
                ErrorData::Float(value) => out.tagged(3, value.to_bits()),
                ErrorData::Hex(value) => out.tagged(4, *value),
                ErrorData::Joint(value) => out.tagged(6, value.cast_unsigned()),
                ErrorData::Text(text) => {
                    out.u32(5);
                    out.text(text);
                }
            }
        }
    }
    out.finish()
}

/// Bytes of one message, whose length field is filled in at the end.
pub(super) struct Writer(Vec<u8>);

impl Writer {
    /// Begins a message of this type.
    pub(super) fn message(kind: u8) -> Self {
        let mut out = Self(Vec::with_capacity(64));
        out.u32(0);
        out.u8(kind);
        out
    }

    /// The message with its length, head included.
    pub(super) fn finish(mut self) -> Vec<u8> {
        self.set_length(0);
        self.0
    }

    /// A part inside the message: its own length and type, then what `fill` writes.
    pub(super) fn part(&mut self, kind: u8, fill: impl FnOnce(&mut Self)) {
        let start = self.0.len();
        self.u32(0);
        self.u8(kind);
        fill(self);
        self.set_length(start);
    }

    /// Texts and parts are bounded, so a length always fits.
    fn set_length(&mut self, start: usize) {
        let length = u32::try_from(self.0.len() - start).unwrap_or(u32::MAX);
        self.0[start..start + 4].copy_from_slice(&length.to_be_bytes());
    }

    pub(super) fn u8(&mut self, value: u8) {
        self.0.push(value);
    }

    pub(super) fn flag(&mut self, value: bool) {
        self.0.push(u8::from(value));
    }

    pub(super) fn u32(&mut self, value: u32) {
        self.0.extend(value.to_be_bytes());
    }

    pub(super) fn i32(&mut self, value: i32) {
        self.0.extend(value.to_be_bytes());
    }

    pub(super) fn u64(&mut self, value: u64) {
        self.0.extend(value.to_be_bytes());
    }

    pub(super) fn f32(&mut self, value: f64) {
        self.0.extend((value as f32).to_be_bytes());
    }

    pub(super) fn f64(&mut self, value: f64) {
        self.0.extend(value.to_be_bytes());
    }

    pub(super) fn f64s(&mut self, values: &[f64]) {
        for value in values {
            self.f64(*value);
        }
    }

    fn tagged(&mut self, data_type: u32, value: u32) {
        self.u32(data_type);
        self.u32(value);
    }

    fn text(&mut self, text: &str) {
        let end = text.floor_char_boundary(TEXT_BYTES_MAX);
        // A NUL inside would end the text for clients that stop at one.
        self.0
            .extend(text[..end].bytes().map(|b| if b == 0 { b' ' } else { b }));
        self.0.push(0);
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
            Source::Controller,
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
                level: Level::Error,
                data,
            };
            encode_exception(1, Source::Safety, &exception)
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
    fn a_long_text_is_cut_at_a_character_and_holds_no_nul() {
        let bytes = encode_exception(0, Source::Gui, &script(&"é".repeat(TEXT_BYTES_MAX)));
        assert_eq!(bytes.len(), 23 + TEXT_BYTES_MAX + 1);
        assert!(core::str::from_utf8(&bytes[23..]).is_ok());
        let bytes = encode_exception(0, Source::Gui, &script("a\0b"));
        assert_eq!(&bytes[23..], b"a b\0");
    }
}
