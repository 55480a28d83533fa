//! Packets of RTSI and the values in them. Pure; big-endian throughout.
//!
//! A packet is a length (itself included), a letter and a payload (SDK source/Rtsi; the vendor's Python client). A
//! packet without payload must never be sent: the SDK takes it for a failed read.
use messages::Localized;

/// Bytes before the payload.
pub const HEADER_BYTES: usize = 3;

/// The only protocol version there is.
pub const PROTOCOL_VERSION: u16 = 1;

/// The letter of a packet.
pub mod packet_type {
    /// Request a protocol version.
    pub const PROTOCOL: u8 = b'V';
    /// Ask for the controller's version.
    pub const VERSION: u8 = b'v';
    /// Set up outputs.
    pub const OUTPUTS: u8 = b'O';
    /// Set up inputs.
    pub const INPUTS: u8 = b'I';
    /// Start sending.
    pub const START: u8 = b'S';
    /// Stop sending.
    pub const PAUSE: u8 = b'P';
    /// A data package.
    pub const DATA: u8 = b'U';
    /// A text message.
    pub const TEXT: u8 = b'M';
}

/// Severity of a text message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum TextLevel {
    /// Something failed and ended what was going on.
    Exception = 0,
    /// Something failed.
    Error = 1,
    /// Something was ignored.
    Warning = 2,
    /// Something worth knowing.
    Info = 3,
}

impl TextLevel {
    /// The level with this number; beyond the last it is information.
    pub const fn from_number(number: u8) -> Self {
        match number {
            0 => Self::Exception,
            1 => Self::Error,
            2 => Self::Warning,
            _ => Self::Info,
        }
    }
}

/// A text message as clients send it; those of the controller look different ([`append_text`]).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TextMessage {
    /// The text of the message.
    pub text: String,
    /// Name of the sender.
    pub source: String,
    /// Severity of the message.
    pub level: TextLevel,
}

/// Reads a client's text message: text and source, a length before each, then the level. Bytes that are no UTF-8 are
/// replaced. `None` when lengths and bytes do not fit together.
pub fn decode_text_message(payload: &[u8]) -> Option<TextMessage> {
    let (text, rest) = read_length_prefixed(payload)?;
    let (source, rest) = read_length_prefixed(rest)?;
    let [level] = *rest else { return None };
    Some(TextMessage {
        text,
        source,
        level: TextLevel::from_number(level),
    })
}

fn read_length_prefixed(bytes: &[u8]) -> Option<(String, &[u8])> {
    let (count, rest) = bytes.split_first()?;
    let (text, rest) = rest.split_at_checked(usize::from(*count))?;
    Some((String::from_utf8_lossy(text).into_owned(), rest))
}

/// The type of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RtsiType {
    /// 1 byte.
    Bool,
    /// 1 byte.
    U8,
    /// 2 bytes.
    U16,
    /// 4 bytes.
    U32,
    /// 4 bytes.
    I32,
    /// 8 bytes.
    F64,
    /// 3 doubles.
    Vector3,
    /// 6 doubles.
    Vector6,
    /// 6 signed words.
    Vector6I32,
}

impl RtsiType {
    /// The name on the wire.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bool => "BOOL",
            Self::U8 => "UINT8",
            Self::U16 => "UINT16",
            Self::U32 => "UINT32",
            Self::I32 => "INT32",
            Self::F64 => "DOUBLE",
            Self::Vector3 => "VECTOR3D",
            Self::Vector6 => "VECTOR6D",
            Self::Vector6I32 => "VECTOR6INT32",
        }
    }

    /// Every type.
    pub const ALL: [Self; 9] = [
        Self::Bool,
        Self::U8,
        Self::U16,
        Self::U32,
        Self::I32,
        Self::F64,
        Self::Vector3,
        Self::Vector6,
        Self::Vector6I32,
    ];

    /// The type of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// Number of bytes that a value takes.
    pub const fn bytes(self) -> usize {
        match self {
            Self::Bool | Self::U8 => 1,
            Self::U16 => 2,
            Self::U32 | Self::I32 => 4,
            Self::F64 => 8,
            Self::Vector3 | Self::Vector6I32 => 24,
            Self::Vector6 => 48,
        }
    }
}

/// A value of a variable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RtsiValue {
    /// BOOL
    Bool(bool),
    /// UINT8
    U8(u8),
    /// UINT16
    U16(u16),
    /// UINT32
    U32(u32),
    /// INT32
    I32(i32),
    /// DOUBLE
    F64(f64),
    /// VECTOR3D
    Vector3([f64; 3]),
    /// VECTOR6D
    Vector6([f64; 6]),
    /// VECTOR6INT32
    Vector6I32([i32; 6]),
}

impl RtsiValue {
    /// Type of the value.
    pub const fn kind(&self) -> RtsiType {
        match self {
            Self::Bool(_) => RtsiType::Bool,
            Self::U8(_) => RtsiType::U8,
            Self::U16(_) => RtsiType::U16,
            Self::U32(_) => RtsiType::U32,
            Self::I32(_) => RtsiType::I32,
            Self::F64(_) => RtsiType::F64,
            Self::Vector3(_) => RtsiType::Vector3,
            Self::Vector6(_) => RtsiType::Vector6,
            Self::Vector6I32(_) => RtsiType::Vector6I32,
        }
    }

    /// Appends its bytes.
    pub fn write(&self, out: &mut Vec<u8>) {
        match self {
            Self::Bool(x) => out.push(u8::from(*x)),
            Self::U8(x) => out.push(*x),
            Self::U16(x) => out.extend(x.to_be_bytes()),
            Self::U32(x) => out.extend(x.to_be_bytes()),
            Self::I32(x) => out.extend(x.to_be_bytes()),
            Self::F64(x) => out.extend(x.to_be_bytes()),
            Self::Vector3(v) => out.extend(v.iter().flat_map(|x| x.to_be_bytes())),
            Self::Vector6(v) => out.extend(v.iter().flat_map(|x| x.to_be_bytes())),
            Self::Vector6I32(v) => out.extend(v.iter().flat_map(|x| x.to_be_bytes())),
        }
    }

    /// Takes a value of this type from the front of `bytes`; `None` when they are too few.
    pub fn read(kind: RtsiType, bytes: &mut &[u8]) -> Option<Self> {
        let (field, rest) = bytes.split_at_checked(kind.bytes())?;
        *bytes = rest;
        let f64s = |index: usize| {
            let (words, _) = field.as_chunks::<8>();
            f64::from_be_bytes(words[index])
        };
        Some(match kind {
            RtsiType::Bool => Self::Bool(field[0] != 0),
            RtsiType::U8 => Self::U8(field[0]),
            RtsiType::U16 => Self::U16(u16::from_be_bytes(*field.first_chunk()?)),
            RtsiType::U32 => Self::U32(u32::from_be_bytes(*field.first_chunk()?)),
            RtsiType::I32 => Self::I32(i32::from_be_bytes(*field.first_chunk()?)),
            RtsiType::F64 => Self::F64(f64s(0)),
            RtsiType::Vector3 => Self::Vector3(core::array::from_fn(f64s)),
            RtsiType::Vector6 => Self::Vector6(core::array::from_fn(f64s)),
            RtsiType::Vector6I32 => {
                let (words, _) = field.as_chunks::<4>();
                Self::Vector6I32(core::array::from_fn(|index| {
                    i32::from_be_bytes(words[index])
                }))
            }
        })
    }
}

/// The stream cannot be RTSI: a packet says that it is shorter than its own head.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error, Localized)]
#[error("a packet of {0} bytes; the shortest has {HEADER_BYTES}")]
#[zh("{0} 字节的数据包；最短为 {HEADER_BYTES} 字节")]
pub struct InvalidPacketLength(pub u16);

/// A packet in the bytes received.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Packet<'a> {
    /// What it is.
    pub letter: u8,
    /// What is in it.
    pub payload: &'a [u8],
    /// Number of bytes that the packet takes, head included.
    pub bytes: usize,
}

/// The first whole packet of `received`; `None` until it is complete.
///
/// # Errors
/// [`InvalidPacketLength`]
pub fn split_packet(received: &[u8]) -> Result<Option<Packet<'_>>, InvalidPacketLength> {
    let Some(&[high, low, letter]) = received.first_chunk::<HEADER_BYTES>() else {
        return Ok(None);
    };
    let length = u16::from_be_bytes([high, low]);
    let bytes = usize::from(length);
    if bytes < HEADER_BYTES {
        return Err(InvalidPacketLength(length));
    }
    Ok(received.get(HEADER_BYTES..bytes).map(|payload| Packet {
        letter,
        payload,
        bytes,
    }))
}

/// Appends a packet whose payload `fill` writes. Callers keep payloads below 64 KiB; a longer one would be a fault of
/// ours, and is left out rather than sent with a wrong length.
pub fn append_packet(out: &mut Vec<u8>, letter: u8, fill: impl FnOnce(&mut Vec<u8>)) {
    let start = out.len();
    out.extend([0, 0, letter]);
    fill(out);
    match u16::try_from(out.len() - start) {
        Ok(length) => out[start..start + 2].copy_from_slice(&length.to_be_bytes()),
        Err(_) => out.truncate(start),
    }
}

/// Appends a text message in the form that protocol version 1 clients read.
pub fn append_text(out: &mut Vec<u8>, level: TextLevel, text: &str) {
    let text = &text[..text.floor_char_boundary(1024)];
    append_packet(out, packet_type::TEXT, |out| {
        out.push(level as u8);
        out.extend(text.as_bytes());
    });
}

/// The names of a recipe: separated by commas; one client ends its list with a comma.
pub fn recipe_names(list: &[u8]) -> impl Iterator<Item = &str> {
    list.split(|byte| *byte == b',')
        .map(|name| core::str::from_utf8(name).unwrap_or("?").trim())
        .filter(|name| !name.is_empty())
}

/// What a controller answers to a recipe: one type name for each variable.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecipeReply {
    /// Number of the recipe, which its data packages begin with.
    pub id: u8,
    /// Types in the order of the names; what is no type, as `NOT_FOUND`, is the error.
    pub kinds: Vec<Result<RtsiType, String>>,
}

/// Reads the answer to a recipe; `None` when there is no number in it.
pub fn decode_recipe_reply(payload: &[u8]) -> Option<RecipeReply> {
    let (id, list) = payload.split_first()?;
    let kinds =
        recipe_names(list).map(|name| RtsiType::from_name(name).ok_or_else(|| name.to_owned()));
    Some(RecipeReply {
        id: *id,
        kinds: kinds.collect(),
    })
}

/// Appends a request for outputs at a frequency, Hz.
pub fn append_outputs_request(out: &mut Vec<u8>, frequency: f64, names: &[&str]) {
    append_packet(out, packet_type::OUTPUTS, |out| {
        out.extend(frequency.to_be_bytes());
        out.extend(names.join(",").as_bytes());
    });
}

/// Reads the controller's version: major, minor, bug fix, build.
pub fn decode_version(payload: &[u8]) -> Option<[u32; 4]> {
    let (words, rest) = payload.as_chunks::<4>();
    let words: [[u8; 4]; 4] = words.try_into().ok()?;
    rest.is_empty().then(|| words.map(u32::from_be_bytes))
}

/// Reads a text message of the controller: level, then text.
pub fn decode_controller_text(payload: &[u8]) -> Option<(TextLevel, String)> {
    let (level, text) = payload.split_first()?;
    let text = String::from_utf8_lossy(text).into_owned();
    Some((TextLevel::from_number(*level), text))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn packets_have_the_bytes_of_the_page() {
        let mut out = Vec::new();
        append_packet(&mut out, packet_type::PROTOCOL, |out| out.push(1));
        assert_eq!(out, [0, 4, b'V', 1]);
        out.clear();
        append_text(&mut out, TextLevel::Warning, "no");
        assert_eq!(out, [0, 6, b'M', 2, b'n', b'o']);
        append_packet(&mut out, b'x', |out| out.extend([0; 70_000]));
        assert_eq!(out.len(), 6);
    }

    #[test]
    fn packets_are_cut_from_the_stream() {
        let whole = |letter, payload, bytes| {
            Ok(Some(Packet {
                letter,
                payload,
                bytes,
            }))
        };
        assert_eq!(split_packet(&[0, 5]), Ok(None));
        assert_eq!(split_packet(&[0, 5, b'V', 0]), Ok(None));
        assert_eq!(
            split_packet(&[0, 5, b'V', 0, 1, 9]),
            whole(b'V', &[0, 1], 5)
        );
        assert_eq!(split_packet(&[0, 3, b'S']), whole(b'S', &[], 3));
        assert_eq!(split_packet(&[0, 2, b'S']), Err(InvalidPacketLength(2)));
    }

    #[test]
    fn text_messages_of_clients_have_the_bytes_of_the_page() {
        let message = |text: &str, source: &str, level| {
            Some(TextMessage {
                text: text.to_owned(),
                source: source.to_owned(),
                level,
            })
        };
        for (payload, wanted) in [
            (
                &b"\x02hi\x03app\x03"[..],
                message("hi", "app", TextLevel::Info),
            ),
            (b"\0\0\0", message("", "", TextLevel::Exception)),
            (
                b"\x02h\xff\x01a\x01",
                message("h\u{FFFD}", "a", TextLevel::Error),
            ),
            (b"\x01x\x01y\x02", message("x", "y", TextLevel::Warning)),
            (b"\x02hi\x03app", None),
            (b"\x02hi\x03app\x03\x03", None),
            (b"\xffhi", None),
            (b"", None),
        ] {
            assert_eq!(decode_text_message(payload), wanted, "{payload:?}");
        }
    }

    #[test]
    fn requests_and_answers_of_recipes_have_the_bytes_of_the_page() {
        let mut out = Vec::new();
        append_outputs_request(&mut out, 250.0, &["timestamp", "robot_mode"]);
        let head = [0, 0x1f, b'O', 0x40, 0x6f, 0x40, 0, 0, 0, 0, 0];
        assert_eq!(out[..11], head);
        assert_eq!(out[11..], *b"timestamp,robot_mode");
        let reply = decode_recipe_reply(b"\x02DOUBLE,INT32,NOT_FOUND").expect("an answer");
        let kinds = vec![
            Ok(RtsiType::F64),
            Ok(RtsiType::I32),
            Err("NOT_FOUND".to_owned()),
        ];
        assert_eq!(reply, RecipeReply { id: 2, kinds });
        assert_eq!(decode_recipe_reply(b""), None);
        let bytes = [0, 0, 0, 2, 0, 0, 0, 15, 0, 0, 0, 0, 0, 0, 0, 1];
        assert_eq!(decode_version(&bytes), Some([2, 15, 0, 1]));
        assert_eq!(decode_version(&bytes[1..]), None);
        let text = decode_controller_text(b"\x02late");
        assert_eq!(text, Some((TextLevel::Warning, "late".to_owned())));
        assert_eq!(decode_controller_text(b""), None);
    }

    #[test]
    fn the_last_name_may_be_empty() {
        assert_eq!(recipe_names(b"a,b,a,").collect::<Vec<_>>(), ["a", "b", "a"]);
        assert_eq!(recipe_names(b"").count(), 0);
        assert_eq!(recipe_names(b"a,\xff").collect::<Vec<_>>(), ["a", "?"]);
    }

    fn value() -> impl Strategy<Value = RtsiValue> {
        prop_oneof![
            any::<bool>().prop_map(RtsiValue::Bool),
            any::<u8>().prop_map(RtsiValue::U8),
            any::<u16>().prop_map(RtsiValue::U16),
            any::<u32>().prop_map(RtsiValue::U32),
            any::<i32>().prop_map(RtsiValue::I32),
            any::<f64>().prop_map(RtsiValue::F64),
            any::<[f64; 3]>().prop_map(RtsiValue::Vector3),
            any::<[f64; 6]>().prop_map(RtsiValue::Vector6),
            any::<[i32; 6]>().prop_map(RtsiValue::Vector6I32),
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 100, ..ProptestConfig::default() })]
        #[test]
        fn values_are_read_back(value in value()) {
            let mut bytes = Vec::new();
            value.write(&mut bytes);
            prop_assert_eq!(bytes.len(), value.kind().bytes());
            let mut rest = bytes.as_slice();
            prop_assert_eq!(RtsiValue::read(value.kind(), &mut rest), Some(value));
            prop_assert!(rest.is_empty());
            prop_assert_eq!(RtsiValue::read(value.kind(), &mut &bytes[1..]), None);
        }
    }
}
