//! The topics of a recording: names, schemas, and the JSON messages of `/script`, `/command` and `/io`.
//!
//! Owns what is written and in which form; when it is written is the writer's business.

use std::borrow::Cow;

use foxglove::Encode;
use messages::Text;
use motion_api::points::PointValues;
use motion_api::{Command, CommandId, Origin, PointList, ProgramId, ThreadNumber};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use crate::arguments::{self, ArgumentError};
use crate::cycle::CycleMessage;

/// A topic of the recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Topic {
    /// Every control cycle, `elite.CycleMessage`.
    Cycle,
    /// Joint positions, speeds and torques of the arm, for viewers.
    JointStates,
    /// Link frames of the arm and the TCP, for viewers.
    Tf,
    /// TCP pose of the arm, for viewers.
    Tcp,
    /// The arm drawn from its collision capsules, for viewers.
    Scene,
    /// Messages for people.
    Log,
    /// Programs and the lines they are in, [`ScriptMessage`].
    Script,
    /// Every command that entered the ring, [`CommandMessage`].
    Command,
    /// Every change of an input, an output or a register, [`IoMessage`].
    Io,
    /// Changes of the global variables of programs, [`VariableMessage`].
    Variables,
}

/// Schema of a topic as the file carries it.
pub struct TopicSchema {
    /// Full name of the message type.
    pub name: String,
    /// `protobuf` or `jsonschema`.
    pub encoding: &'static str,
    /// Serialized `FileDescriptorSet`, or JSON Schema text.
    pub data: Cow<'static, [u8]>,
}

impl Topic {
    /// All topics, in the order in which they stand in the file.
    pub const ALL: [Self; 10] = [
        Self::Cycle,
        Self::JointStates,
        Self::Tf,
        Self::Tcp,
        Self::Scene,
        Self::Log,
        Self::Script,
        Self::Command,
        Self::Io,
        Self::Variables,
    ];

    /// The topic's name, with its slash.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Cycle => "/cycle",
            Self::JointStates => "/joint_states",
            Self::Tf => "/tf",
            Self::Tcp => "/tcp",
            Self::Scene => "/scene",
            Self::Log => "/log",
            Self::Script => "/script",
            Self::Command => "/command",
            Self::Io => "/io",
            Self::Variables => "/variables",
        }
    }

    /// The topic of that name, with or without the slash.
    pub fn from_name(name: &str) -> Option<Self> {
        let bare = name.trim_start_matches('/');
        Self::ALL.into_iter().find(|t| &t.name()[1..] == bare)
    }

    /// How messages are encoded: `protobuf` or `json`.
    pub const fn message_encoding(self) -> &'static str {
        match self {
            Self::Script | Self::Command | Self::Io | Self::Variables => "json",
            _ => "protobuf",
        }
    }

    /// The schema.
    pub fn schema(self) -> TopicSchema {
        match self {
            Self::Cycle => TopicSchema {
                name: "elite.Cycle".to_owned(),
                encoding: "protobuf",
                data: Cow::Owned(CycleMessage::descriptor_set()),
            },
            Self::JointStates => published::<foxglove::messages::JointStates>(),
            Self::Tf => published::<foxglove::messages::FrameTransforms>(),
            Self::Tcp => published::<foxglove::messages::PoseInFrame>(),
            Self::Scene => published::<foxglove::messages::SceneUpdate>(),
            Self::Log => published::<foxglove::messages::Log>(),
            Self::Script => json_schema("elite.Script", script_schema()),
            Self::Command => json_schema("elite.Command", command_schema()),
            Self::Io => json_schema("elite.Io", io_schema()),
            Self::Variables => json_schema("elite.Variable", variable_schema()),
        }
    }

    pub(crate) const fn index(self) -> usize {
        self as usize
    }
}

/// A schema that the viewers' maker publishes. A message type without one would give an empty schema, which the tests
/// that decode every topic do not let pass.
fn published<T: Encode>() -> TopicSchema {
    let schema = T::get_schema();
    let (name, data) = schema.map_or_else(Default::default, |s| (s.name, s.data));
    TopicSchema {
        name,
        encoding: "protobuf",
        data,
    }
}

fn json_schema(name: &str, schema: Value) -> TopicSchema {
    TopicSchema {
        name: name.to_owned(),
        encoding: "jsonschema",
        data: Cow::Owned(schema.to_string().into_bytes()),
    }
}

/// `/script`: a program begins (`text` is there), or one of its threads is in another line or node (`thread` and `line`
/// are).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ScriptMessage {
    /// Name of the program.
    pub program: String,
    /// Number of the program, in the order in which programs were started, from 1.
    #[serde(default)]
    pub program_id: u32,
    /// The program's text, when it starts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub text: Option<String>,
    /// The script thread, 0 is the main thread.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thread: Option<u32>,
    /// The line it is in, from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub line: Option<u32>,
    /// How often it came round a loop to this line, where it was told to be before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rounds: Option<u32>,
    /// The node of the pendant's task that it is in (`$ LINE`), from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub node: Option<u32>,
    /// The label of that node.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
}

fn script_schema() -> Value {
    json!({
        "title": "elite.Script",
        "description": "A program starts (text), or one of its threads is in another line (thread, line) \
            or node (node, label).",
        "type": "object",
        "properties": {
            "program": {"type": "string", "description": "name of the program"},
            "program_id": {"type": "integer", "description": "number of the program, from 1"},
            "text": {"type": "string", "description": "the program's text, when it starts"},
            "thread": {"type": "integer", "description": "script thread, 0 is the main thread"},
            "line": {"type": "integer", "description": "line, from 1"},
            "rounds": {"type": "integer", "description": "how often it came round a loop to this line again"},
            "node": {"type": "integer", "description": "node of the pendant's task, from 1"},
            "label": {"type": "string", "description": "label of that node, long ones are cut"}
        },
        "required": ["program", "program_id"]
    })
}

/// `/variables`: a global variable of a program has this value now; at most ten times a second and name.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct VariableMessage {
    /// Name of the program.
    pub program: String,
    /// Number of that program.
    pub program_id: u32,
    /// The variable.
    pub name: String,
    /// Type of the variable, the text of `type(x).__name__`.
    #[serde(rename = "type")]
    pub type_name: String,
    /// Value of the variable, the text of `repr(x)`; long ones are cut.
    pub value: String,
}

fn variable_schema() -> Value {
    json!({
        "title": "elite.Variable",
        "description": "A global variable of a program has this value now.",
        "type": "object",
        "properties": {
            "program": {"type": "string", "description": "name of the program"},
            "program_id": {"type": "integer", "description": "number of the program, from 1"},
            "name": {"type": "string", "description": "name of the variable"},
            "type": {"type": "string", "description": "its type"},
            "value": {"type": "string", "description": "its value as repr(), long ones are cut"}
        },
        "required": ["program", "program_id", "name", "type", "value"]
    })
}

/// Name of messages that hold points of a moveml.
const POINTS: &str = "micro_points";
/// Number of points in a message.
const POINTS_A_MESSAGE: usize = 256;

/// `/command`: a command left the ring at the beginning of a cycle, or points of one that does next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CommandMessage {
    /// Number of the command, from 1.
    pub id: u64,
    /// The cycle that took it.
    pub cycle: u64,
    /// What was asked: the script function's name where there is one.
    pub name: String,
    /// Arguments by name.
    pub arguments: Map<String, Value>,
    /// Name of the program that asked; empty when a port did.
    pub program: String,
    /// Number of that program; 0 when a port asked.
    #[serde(default)]
    pub program_id: u32,
    /// The script thread that asked.
    #[serde(default)]
    pub thread: u32,
    /// Line of the call, from 1; 0 when there is none.
    pub line: u32,
}

impl CommandMessage {
    pub(crate) fn new(cycle: u64, command: &Command, program: &str) -> Self {
        let Command { id, origin, kind } = command;
        Self {
            id: id.0,
            cycle,
            name: kind.name().to_owned(),
            arguments: arguments::to_json(kind),
            program: program.to_owned(),
            program_id: origin.program.0,
            thread: origin.thread.0,
            line: origin.line,
        }
    }

    /// The points that were handed over with a moveml, some a message, before the message of that command.
    pub(crate) fn points(
        cycle: u64,
        id: CommandId,
        list: &PointList,
    ) -> impl Iterator<Item = Self> {
        let are_poses = list.are_poses();
        list.samples().chunks(POINTS_A_MESSAGE).map(move |points| {
            let arguments = [
                ("are_poses", Value::from(are_poses)),
                ("points", json!(points)),
            ];
            let arguments = arguments.map(|(name, value)| (name.to_owned(), value));
            Self {
                id: id.0,
                cycle,
                name: POINTS.to_owned(),
                arguments: arguments.into_iter().collect(),
                program: String::new(),
                program_id: 0,
                thread: 0,
                line: 0,
            }
        })
    }

    /// Points of the moveml with this number, and whether they are poses, where the message holds such.
    ///
    /// # Errors
    /// [`ArgumentError`] when it should, and what it holds are none.
    pub fn to_points(&self) -> Result<Option<(bool, Vec<PointValues>)>, ArgumentError> {
        if self.name != POINTS {
            return Ok(None);
        }
        let wrong = |argument| ArgumentError::Argument {
            command: POINTS,
            argument,
            found: "not what this version writes".to_owned(),
        };
        let argument = |name| self.arguments.get(name).cloned().unwrap_or_default();
        let are_poses = argument("are_poses").as_bool();
        let points = serde_json::from_value(argument("points"));
        Ok(Some((
            are_poses.ok_or_else(|| wrong("are_poses"))?,
            points.map_err(|_| wrong("points"))?,
        )))
    }

    /// The command as it entered the ring.
    ///
    /// # Errors
    /// [`ArgumentError`] when the name or the arguments are not those of a command of this version.
    pub fn to_command(&self) -> Result<Command, ArgumentError> {
        Ok(Command {
            id: CommandId(self.id),
            origin: Origin {
                program: ProgramId(self.program_id),
                thread: ThreadNumber(self.thread),
                line: self.line,
            },
            kind: arguments::from_json(&self.name, &self.arguments)?,
        })
    }
}

fn command_schema() -> Value {
    json!({
        "title": "elite.Command",
        "description": "A command left the ring at the beginning of a cycle.",
        "type": "object",
        "properties": {
            "id": {"type": "integer", "description": "number of the command, from 1"},
            "cycle": {"type": "integer", "description": "the cycle that took it"},
            "name": {"type": "string", "description": "what was asked; \
                micro_points: points of the moveml with that number"},
            "arguments": {"type": "object", "description": "arguments by name, SI units"},
            "program": {"type": "string", "description": "the program that asked, empty for a port"},
            "program_id": {"type": "integer", "description": "number of that program, 0 for a port"},
            "thread": {"type": "integer", "description": "script thread, 0 is the main thread"},
            "line": {"type": "integer", "description": "line of the call, from 1; 0 when there is none"}
        },
        "required": ["id", "cycle", "name", "arguments", "program", "line"]
    })
}

/// `/io`: an input, an output or a register has another value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct IoMessage {
    /// The latest cycle when it changed.
    pub cycle: u64,
    /// Name of the point as in a cell file, `standard_digital_out[3]` for instance.
    pub name: String,
    /// The new value.
    pub value: IoValue,
}

/// Value of an input, an output or a register.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum IoValue {
    /// Level of a digital point or a boolean register.
    Level(bool),
    /// Value of an integer register.
    Integer(i64),
    /// Of an analog point (A or V by domain) or a float register. JSON has no NaN and no infinities: they are written
    /// as null and read as NaN.
    Number(#[serde(deserialize_with = "null_is_nan")] f64),
}

fn null_is_nan<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

fn io_schema() -> Value {
    json!({
        "title": "elite.Io",
        "description": "An input, an output or a register has another value.",
        "type": "object",
        "properties": {
            "cycle": {"type": "integer", "description": "the cycle in which it changed; \
                of a register, the first that saw the change"},
            "name": {"type": "string", "description": "name of the point, standard_digital_out[3] for instance"},
            "value": {
                "type": ["boolean", "number", "null"],
                "description": "the new value; analog points in A or V by domain; null is not a number"
            }
        },
        "required": ["cycle", "name", "value"]
    })
}

/// Importance of a message of `/log`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum LogLevel {
    /// Details for developers.
    Debug,
    /// Something happened that was expected.
    Info,
    /// Worth reading.
    Warning,
    /// Something failed: a script, a service.
    Error,
    /// The controller cannot go on.
    Fatal,
}

impl LogLevel {
    /// The number of the published schema: 1 debug, 2 information, 3 warning, 4 error, 5 fatal.
    pub fn number(self) -> i32 {
        use foxglove::messages::log::Level;
        match self {
            Self::Debug => Level::Debug,
            Self::Info => Level::Info,
            Self::Warning => Level::Warning,
            Self::Error => Level::Error,
            Self::Fatal => Level::Fatal,
        }
        .into()
    }

    /// Unknown numbers count as information: they are shown, and are no error.
    pub(crate) fn from_number(number: i32) -> Self {
        let all = [Self::Debug, Self::Warning, Self::Error, Self::Fatal];
        all.into_iter()
            .find(|level| level.number() == number)
            .unwrap_or(Self::Info)
    }
}

/// What a message of `/log` has besides the fields of `foxglove.Log`.
#[derive(Clone, PartialEq, prost::Message)]
pub(crate) struct LogTranslation {
    /// The sentence in Chinese, where that is something else.
    #[prost(string, optional, tag = "1000")]
    pub chinese: Option<String>,
}

/// One message of `/log`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogMessage {
    /// Importance of the message.
    pub level: LogLevel,
    /// Part of the controller, or program, that writes the message.
    pub source: String,
    /// The sentence.
    pub message: Text,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_points_come_back_as_what_they_were() {
        for (value, text) in [
            (IoValue::Level(true), "true"),
            (IoValue::Integer(-7), "-7"),
            (IoValue::Number(1.0), "1.0"),
            (IoValue::Number(-0.1), "-0.1"),
            (IoValue::Number(f64::NAN), "null"),
        ] {
            assert_eq!(serde_json::to_string(&value).unwrap(), text);
            let back: IoValue = serde_json::from_str(text).unwrap();
            // NaN is not equal to itself, its text is.
            assert_eq!(format!("{back:?}"), format!("{value:?}"));
        }
    }

    #[test]
    fn topics_are_found_with_and_without_the_slash() {
        for topic in Topic::ALL {
            assert_eq!(Topic::from_name(topic.name()), Some(topic));
            assert_eq!(Topic::from_name(&topic.name()[1..]), Some(topic));
        }
        assert_eq!(Topic::from_name("/cycles"), None);
    }
}
