//! The topic `/external` of a recording: what came to programs from outside, as JSON, and back.
//!
//! Numbers come back bit for bit. Messages are numbered, so that a reader sees where some were lost.

use std::sync::atomic::{AtomicU64, Ordering};

use elite_runtime::external::{
    CallOutcome, ExternalInput, ExternalInputKind, RecordedCall, TaskOrder,
};
use io_bus::xmlrpc::RpcValue;
use messages::{Text, text};
use motion_api::ProgramId;
use recorder::lengths::EXTRA_BYTES;
use recorder::{CustomTopic, CustomTopicId, RecorderHandle};
use serde::{Deserialize, Serialize};
use serde_json::{Value as Json, json};

/// Name of the topic.
pub const TOPIC: &str = "/external";
/// The first extra topic of a recording of ours.
const NUMBER: CustomTopicId = CustomTopicId(0);
/// Deepest nesting of answers that are read.
const DEPTH_MAX: usize = 70;

/// The topic, for a recording that is begun.
pub(crate) fn topic() -> CustomTopic {
    let integer = json!({"type": "integer", "minimum": 0});
    CustomTopic {
        name: TOPIC.to_owned(),
        schema_name: "elite.External".to_owned(),
        schema: json!({
            "type": "object",
            "properties": {
                "number": integer,
                "program": integer,
                "turn": integer,
                "cycle": integer,
                "kind": {"enum": ["begins", "ends", "sees", "order", "call", "woken", "clock", "lost"]},
                "order": {"type": "string"},
                "name": {"type": "string"},
                "text": {"type": "string"},
                "presets": {"type": "array", "items": {"type": "string"}},
                "call": integer,
                "waits": {"type": "array", "items": integer},
                "value": {},
                "raised": {"type": "string"},
                "thread": integer,
                "time": {"type": "number"},
            },
            "required": ["number", "program", "turn", "cycle", "kind"],
        })
        .to_string(),
    }
}

/// One message.
#[derive(Debug, Serialize, Deserialize)]
struct ExternalMessage {
    /// Number of the message in the recording, from 1.
    number: u64,
    program: u32,
    turn: u64,
    cycle: u64,
    #[serde(flatten)]
    input: InputMessage,
}

/// What came. Fields that are empty are left out.
#[derive(Debug, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum InputMessage {
    Begins {
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        presets: Vec<String>,
    },
    Ends,
    Sees,
    Order(OrderMessage),
    Call(CallMessage),
    Woken {
        #[serde(default, skip_serializing_if = "is_zero")]
        thread: u64,
    },
    Clock {
        time: f64,
    },
    Lost {
        #[serde(default, skip_serializing_if = "String::is_empty")]
        text: String,
        /// The Chinese form of the text, where it differs from the English one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        chinese: Option<String>,
    },
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(tag = "order", rename_all = "snake_case")]
enum OrderMessage {
    Stop,
    Pause,
    Resume,
    Replace {
        #[serde(default, skip_serializing_if = "String::is_empty")]
        name: String,
    },
    Secondary {
        #[serde(default, skip_serializing_if = "String::is_empty")]
        name: String,
        #[serde(default, skip_serializing_if = "String::is_empty")]
        text: String,
    },
}

/// A call and how it ended: with a value, with an exception of the type `raised`, or with neither.
#[derive(Debug, Serialize, Deserialize)]
struct CallMessage {
    #[serde(default, skip_serializing_if = "String::is_empty")]
    name: String,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    text: String,
    #[serde(default, skip_serializing_if = "is_zero")]
    call: u64,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    waits: Vec<u64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    value: Option<Json>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    raised: Option<String>,
}

fn is_zero(number: &u64) -> bool {
    *number == 0
}

/// Numbers messages and gives them to the recording.
#[derive(Default)]
pub(crate) struct ExternalWriter(AtomicU64);

impl ExternalWriter {
    pub(crate) fn write(&self, recording: &RecorderHandle, time: f64, external: &ExternalInput) {
        let number = self.0.fetch_add(1, Ordering::Relaxed) + 1;
        let mut bytes = encode(number, external);
        if bytes.is_empty() || bytes.len() > EXTRA_BYTES {
            let kind = kind_of(&external.what);
            let text = text!(
                "{kind} has more than {EXTRA_BYTES} bytes",
                "{kind} 超过 {EXTRA_BYTES} 字节"
            );
            let short = ExternalInput {
                what: ExternalInputKind::Unrecorded(text),
                ..external.clone()
            };
            bytes = encode(number, &short);
        }
        recording.extra(time, NUMBER, bytes);
    }
}

/// The word for what came, as messages have it.
const fn kind_of(what: &ExternalInputKind) -> &'static str {
    match what {
        ExternalInputKind::Started { .. } => "begins",
        ExternalInputKind::Ends => "ends",
        ExternalInputKind::CycleObserved => "sees",
        ExternalInputKind::Order(_) => "order",
        ExternalInputKind::Call(_) => "call",
        ExternalInputKind::Woken { .. } => "woken",
        ExternalInputKind::TimeOfDay(_) => "clock",
        ExternalInputKind::Unrecorded(_) => "lost",
    }
}

fn encode(number: u64, external: &ExternalInput) -> Vec<u8> {
    let message = ExternalMessage {
        number,
        program: external.program.0,
        turn: external.turn,
        cycle: external.cycle,
        input: InputMessage::from(&external.what),
    };
    serde_json::to_vec(&message).unwrap_or_default()
}

/// Reads a message; gives its number beside it.
///
/// # Errors
/// A sentence.
pub(crate) fn read(data: &[u8]) -> Result<(u64, ExternalInput), Text> {
    if data.len() > EXTRA_BYTES {
        let (given, most) = (data.len(), EXTRA_BYTES);
        return Err(text!(
            "it has {given} bytes, at most {most} are read",
            "有 {given} 字节，最多读取 {most} 字节"
        ));
    }
    let message: ExternalMessage =
        serde_json::from_slice(data).map_err(|error| Text::of_library(&error))?;
    let external = ExternalInput {
        program: ProgramId(message.program),
        turn: message.turn,
        cycle: message.cycle,
        what: message.input.try_into()?,
    };
    Ok((message.number, external))
}

impl From<&ExternalInputKind> for InputMessage {
    fn from(what: &ExternalInputKind) -> Self {
        match what {
            ExternalInputKind::Started { presets } => Self::Begins {
                presets: presets.clone(),
            },
            ExternalInputKind::Ends => Self::Ends,
            ExternalInputKind::CycleObserved => Self::Sees,
            ExternalInputKind::Woken { thread } => Self::Woken { thread: *thread },
            ExternalInputKind::TimeOfDay(time) => Self::Clock { time: *time },
            ExternalInputKind::Unrecorded(text) => Self::Lost {
                text: text.english().to_owned(),
                chinese: text.other_chinese().map(str::to_owned),
            },
            ExternalInputKind::Order(order) => Self::Order(order.into()),
            ExternalInputKind::Call(call) => Self::Call(call.into()),
        }
    }
}

impl TryFrom<InputMessage> for ExternalInputKind {
    type Error = Text;

    fn try_from(message: InputMessage) -> Result<Self, Text> {
        Ok(match message {
            InputMessage::Begins { presets } => Self::Started { presets },
            InputMessage::Ends => Self::Ends,
            InputMessage::Sees => Self::CycleObserved,
            InputMessage::Woken { thread } => Self::Woken { thread },
            InputMessage::Clock { time } => Self::TimeOfDay(time),
            InputMessage::Lost { text, chinese } => Self::Unrecorded(Text::recorded(text, chinese)),
            InputMessage::Order(order) => Self::Order(order.into()),
            InputMessage::Call(call) => Self::Call(call.try_into()?),
        })
    }
}

impl From<&TaskOrder> for OrderMessage {
    fn from(order: &TaskOrder) -> Self {
        match order {
            TaskOrder::Stop => Self::Stop,
            TaskOrder::Pause => Self::Pause,
            TaskOrder::Resume => Self::Resume,
            TaskOrder::Replace(name) => Self::Replace { name: name.clone() },
            TaskOrder::Secondary { name, text } => Self::Secondary {
                name: name.clone(),
                text: text.clone(),
            },
        }
    }
}

impl From<OrderMessage> for TaskOrder {
    fn from(message: OrderMessage) -> Self {
        match message {
            OrderMessage::Stop => Self::Stop,
            OrderMessage::Pause => Self::Pause,
            OrderMessage::Resume => Self::Resume,
            OrderMessage::Replace { name } => Self::Replace(name),
            OrderMessage::Secondary { name, text } => Self::Secondary { name, text },
        }
    }
}

impl From<&RecordedCall> for CallMessage {
    fn from(call: &RecordedCall) -> Self {
        let (value, raised, text) = match &call.answer {
            CallOutcome::Value(value) => (Some(json_of(value)), None, String::new()),
            CallOutcome::Raised { kind, text } => (None, Some(kind.clone()), text.clone()),
            CallOutcome::Stopped => (None, None, String::new()),
        };
        Self {
            name: call.function.clone(),
            text,
            call: call.number,
            waits: call.waits.clone(),
            value,
            raised,
        }
    }
}

impl TryFrom<CallMessage> for RecordedCall {
    type Error = Text;

    fn try_from(message: CallMessage) -> Result<Self, Text> {
        Ok(Self {
            number: message.call,
            function: message.name,
            waits: message.waits,
            answer: match (message.value, message.raised) {
                (Some(value), _) => CallOutcome::Value(value_of(&value, 0)?),
                (None, Some(kind)) => CallOutcome::Raised {
                    kind,
                    text: message.text,
                },
                (None, None) => CallOutcome::Stopped,
            },
        })
    }
}

/// Plain where JSON has it; else an object with one word that says what it is.
fn json_of(value: &RpcValue) -> Json {
    match value {
        RpcValue::Nil => json!({"none": true}),
        RpcValue::Bool(level) => json!(level),
        RpcValue::Int(number) => json!(number),
        RpcValue::Double(number) if number.is_finite() => json!(number),
        RpcValue::Double(number) => json!({"bits": format!("{:016x}", number.to_bits())}),
        RpcValue::Text(text) => json!(text),
        RpcValue::Bytes(bytes) => {
            let hex: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
            json!({ "bytes": hex })
        }
        RpcValue::Array(items) => items.iter().map(json_of).collect(),
        RpcValue::Struct(members) => {
            let members: Vec<Json> = members
                .iter()
                .map(|(name, value)| json!([name, json_of(value)]))
                .collect();
            json!({ "struct": members })
        }
    }
}

fn value_of(json: &Json, depth: usize) -> Result<RpcValue, Text> {
    if depth > DEPTH_MAX {
        return Err(text!(
            "a value is nested deeper than {DEPTH_MAX}",
            "值的嵌套超过 {DEPTH_MAX} 层"
        ));
    }
    let wrong = || text!("{json} is no value", "{json} 不是值");
    Ok(match json {
        Json::Null => RpcValue::Nil,
        Json::Bool(level) => RpcValue::Bool(*level),
        Json::Number(number) => match number.as_i64() {
            Some(number) => RpcValue::Int(number),
            None => RpcValue::Double(number.as_f64().ok_or_else(wrong)?),
        },
        Json::String(text) => RpcValue::Text(text.clone()),
        Json::Array(items) => {
            let items = items.iter().map(|item| value_of(item, depth + 1));
            RpcValue::Array(items.collect::<Result<_, _>>()?)
        }
        Json::Object(fields) => {
            let (word, inner) = fields.iter().next().ok_or_else(wrong)?;
            match (word.as_str(), inner) {
                ("none", _) => RpcValue::Nil,
                ("bits", Json::String(text)) => {
                    let bits = u64::from_str_radix(text, 16).map_err(|_| wrong())?;
                    RpcValue::Double(f64::from_bits(bits))
                }
                ("bytes", Json::String(text)) => {
                    let pairs = text.as_bytes().chunks(2);
                    let byte = |pair: &[u8]| {
                        let text = std::str::from_utf8(pair).ok()?;
                        u8::from_str_radix(text, 16).ok()
                    };
                    let bytes: Option<Vec<u8>> = pairs.map(byte).collect();
                    RpcValue::Bytes(bytes.ok_or_else(wrong)?)
                }
                ("struct", Json::Array(members)) => {
                    let member = |member: &Json| match member.as_array().map(Vec::as_slice) {
                        Some([Json::String(name), value]) => {
                            Ok((name.clone(), value_of(value, depth + 1)?))
                        }
                        _ => Err(wrong()),
                    };
                    RpcValue::Struct(members.iter().map(member).collect::<Result<_, _>>()?)
                }
                _ => return Err(wrong()),
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn there_and_back(what: ExternalInputKind) {
        let external = ExternalInput {
            program: ProgramId(3),
            turn: 1 << 40,
            cycle: 17,
            what,
        };
        let bytes = encode(1, &external);
        let text = String::from_utf8(bytes.clone()).unwrap();
        let kind = kind_of(&external.what);
        assert!(text.contains(&format!("\"kind\":\"{kind}\"")), "{text}");
        let read = read(&bytes).unwrap().1;
        assert_eq!(format!("{read:?}"), format!("{external:?}"));
    }

    fn call(answer: CallOutcome) -> ExternalInputKind {
        ExternalInputKind::Call(RecordedCall {
            number: 9,
            function: "socket_read_string".to_owned(),
            waits: vec![4, 1 << 50],
            answer,
        })
    }

    #[test]
    fn whatever_is_noted_comes_back_bit_for_bit() {
        let presets = vec!["speed = 0.25".to_owned()];
        for what in [
            ExternalInputKind::Started { presets },
            ExternalInputKind::Ends,
            ExternalInputKind::CycleObserved,
            ExternalInputKind::Woken { thread: 4 },
            ExternalInputKind::TimeOfDay(1_767_225_600.123_456_7),
            ExternalInputKind::Unrecorded(Text::verbatim("why")),
            ExternalInputKind::Unrecorded(text!("files", "文件")),
            ExternalInputKind::Order(TaskOrder::Stop),
            ExternalInputKind::Order(TaskOrder::Pause),
            ExternalInputKind::Order(TaskOrder::Resume),
            ExternalInputKind::Order(TaskOrder::Replace("x".to_owned())),
            ExternalInputKind::Order(TaskOrder::Secondary {
                name: "s".to_owned(),
                text: "sec s():\n".to_owned(),
            }),
            call(CallOutcome::Stopped),
            call(CallOutcome::Raised {
                kind: "ValueError".to_owned(),
                text: "ü".to_owned(),
            }),
            call(CallOutcome::Value(RpcValue::Nil)),
            call(CallOutcome::Value(RpcValue::Array(vec![
                RpcValue::Int(i64::MIN),
                RpcValue::Double(0.1 + 0.2),
                RpcValue::Double(5.0),
                RpcValue::Double(-0.0),
                RpcValue::Double(f64::NAN),
                RpcValue::Double(f64::NEG_INFINITY),
                RpcValue::Bool(true),
                RpcValue::Text("\u{0}\"ß".to_owned()),
                RpcValue::Bytes(vec![0, 255]),
                RpcValue::Struct(vec![
                    ("b".to_owned(), RpcValue::Nil),
                    ("a".to_owned(), RpcValue::Array(Vec::new())),
                ]),
            ]))),
        ] {
            there_and_back(what);
        }
    }

    #[test]
    fn what_is_none_is_refused_with_a_sentence() {
        for wrong in [
            "",
            "{}",
            "[]",
            r#"{"number":1,"program":1,"turn":1,"cycle":1,"kind":"x"}"#,
            r#"{"number":1,"program":1,"turn":1,"cycle":1,"kind":"clock"}"#,
            r#"{"number":1,"program":1,"turn":1,"cycle":1,"kind":"order","order":"dance"}"#,
            r#"{"number":1,"program":1,"turn":1,"cycle":1,"kind":"call","value":{"x":1}}"#,
            r#"{"number":-1,"program":1,"turn":1,"cycle":1,"kind":"sees"}"#,
        ] {
            assert!(read(wrong.as_bytes()).is_err(), "{wrong}");
        }
        let deep = format!("{}{}", "[".repeat(100), "]".repeat(100));
        let text = format!(
            r#"{{"number":1,"program":1,"turn":1,"cycle":1,"kind":"call","value":{deep}}}"#
        );
        assert!(read(text.as_bytes()).is_err());
    }
}
