//! Any topic as a table of text: one row a message, one column a value.
//!
//! Messages are decoded with the schema that the file carries, so that topics of other programs work too. Elements of
//! vectors are `name_0`, `name_1` ...; fields of messages in messages are `outer.inner`. The first column, `log_time`,
//! is the time stamp in seconds.

use std::collections::HashMap;
use std::fmt::{self, Write as _};

use mcap::Channel;
use messages::{Text, text};
use prost::Message as _;
use prost_reflect::{DescriptorPool, DynamicMessage, MessageDescriptor, ReflectMessage, Value};
use prost_types::FileDescriptorSet;

use crate::json_values;
use crate::lengths::truncate_marked;
use crate::reader::{RawMessage, ReadError, Recording};

/// More columns than a person or a spreadsheet can use.
const MAX_COLUMNS: usize = 10_000;
/// Bytes of a column's name.
const MAX_NAME: usize = 1024;
/// Bytes of a message in protobuf: decoded without knowing it, two bytes can become a hundred.
const MAX_PROTOBUF: usize = 1 << 20;
/// Topics that are named when one is asked for that is not there.
const MAX_TOPICS_NAMED: usize = 20;
const TIME_COLUMN: &str = "log_time";

/// A topic as a table.
pub struct TopicTable<'a> {
    recording: &'a Recording,
    topic: String,
    columns: Columns,
}

impl<'a> TopicTable<'a> {
    /// Reads the topic once to find its columns, in the order in which they first occur.
    ///
    /// # Errors
    /// [`ReadError`] when there is no such topic, or a message is not what the topic's schema says.
    pub fn new(recording: &'a Recording, topic: &str) -> Result<Self, ReadError> {
        let mut table = Self {
            recording,
            topic: format!("/{}", topic.trim_start_matches('/')),
            columns: Columns::default(),
        };
        let mut messages = TopicMessages::new(recording, &table.topic)?;
        loop {
            let mut hint = 0;
            let columns = &mut table.columns;
            let found = messages.next(&mut |name, _| {
                hint = 1 + columns.place_or_new(name, hint);
                Ok(())
            })?;
            if table.columns.names.len() > MAX_COLUMNS {
                return Err(ReadError::TooWide {
                    topic: table.topic,
                    limit: MAX_COLUMNS,
                });
            }
            if !found {
                break;
            }
        }
        if messages.number == 0 {
            table.columns.place_or_new(TIME_COLUMN, 0);
            table.topic_exists()?;
        }
        Ok(table)
    }

    /// Names of the columns.
    pub fn columns(&self) -> &[String] {
        &self.columns.names
    }

    /// The rows; a cell is `None` where the message has no such value.
    ///
    /// # Errors
    /// The errors of [`new`](Self::new).
    pub fn rows(
        &self,
    ) -> Result<impl Iterator<Item = Result<Vec<Option<String>>, ReadError>> + use<'_>, ReadError>
    {
        let mut messages = TopicMessages::new(self.recording, &self.topic)?;
        Ok(std::iter::from_fn(move || {
            let mut row = vec![None; self.columns.names.len()];
            let mut hint = 0;
            let found = messages.next(&mut |name, cell| {
                // A file that grew since its columns were found may have new ones.
                if let Some(place) = self.columns.place(name, hint) {
                    row[place] = Some(cell.to_string());
                    hint = place + 1;
                }
                Ok(())
            });
            match found {
                Ok(true) => Some(Ok(row)),
                Ok(false) => None,
                Err(error) => Some(Err(error)),
            }
        }))
    }

    /// An empty topic of ours is no error, an unknown one is.
    fn topic_exists(&self) -> Result<(), ReadError> {
        let all = self.recording.topics()?;
        if all.contains(&self.topic) {
            return Ok(());
        }
        let named = all.iter().take(MAX_TOPICS_NAMED);
        let mut known: Vec<Text> = named
            .map(|name| Text::verbatim(truncate_marked(name, 80).unwrap_or_else(|| name.clone())))
            .collect();
        if all.len() > MAX_TOPICS_NAMED {
            known.push(text!(
                "and {} more",
                "还有 {} 项",
                all.len() - MAX_TOPICS_NAMED
            ));
        }
        Err(ReadError::NoTopic {
            topic: self.topic.clone(),
            known: Text::joined(known, ", ", "、"),
        })
    }
}

/// Names of columns and their places. Messages have their values in the same order nearly always, so the place after
/// the one before is tried first.
#[derive(Default)]
struct Columns {
    names: Vec<String>,
    places: HashMap<String, usize>,
}

impl Columns {
    fn place(&self, name: &str, hint: usize) -> Option<usize> {
        if self.names.get(hint).is_some_and(|at_hint| at_hint == name) {
            return Some(hint);
        }
        self.places.get(name).copied()
    }

    fn place_or_new(&mut self, name: &str, hint: usize) -> usize {
        self.place(name, hint).unwrap_or_else(|| {
            let place = self.names.len();
            self.names.push(name.to_owned());
            self.places.insert(name.to_owned(), place);
            place
        })
    }
}

/// Told the name and the value of every cell.
type CellSink<'a> = dyn FnMut(&str, CellValue) -> Result<(), Text> + 'a;

/// The messages of one topic, cell by cell.
struct TopicMessages<'a> {
    recording: &'a Recording,
    messages: crate::reader::Messages,
    topic: String,
    decoder: Option<Decoder>,
    /// Messages so far.
    number: u64,
}

impl<'a> TopicMessages<'a> {
    fn new(recording: &'a Recording, topic: &str) -> Result<Self, ReadError> {
        Ok(Self {
            recording,
            messages: recording.messages()?,
            topic: topic.to_owned(),
            decoder: None,
            number: 0,
        })
    }

    /// Emits the cells of the next message; false when there is none.
    fn next(&mut self, emit: &mut CellSink) -> Result<bool, ReadError> {
        let topic = &self.topic;
        let Some(message) = self.messages.find(|m| m.channel.topic == *topic) else {
            return Ok(false);
        };
        self.number += 1;
        let time = CellValue::Nanos(self.since_start(&message));
        let decoder = match &mut self.decoder {
            Some(decoder) => decoder,
            none => none.insert(Decoder::new(&message.channel)?),
        };
        emit(TIME_COLUMN, time)
            .and_then(|()| decoder.decode(&message.data, emit))
            .map_err(|reason| ReadError::Message {
                topic: self.topic.clone(),
                number: self.number,
                reason,
            })?;
        Ok(true)
    }

    fn since_start(&self, message: &RawMessage) -> i128 {
        let epoch = self.recording.setup().map_or(0, |setup| setup.epoch_ns);
        i128::from(message.log_time_ns) - i128::from(epoch)
    }
}

enum Decoder {
    Json,
    Protobuf(MessageDescriptor),
}

impl Decoder {
    fn new(channel: &Channel) -> Result<Self, ReadError> {
        let fail = |reason: Text| ReadError::Schema {
            topic: channel.topic.clone(),
            reason,
        };
        match channel.message_encoding.as_str() {
            "json" => Ok(Self::Json),
            "protobuf" => {
                let schema = channel
                    .schema
                    .as_ref()
                    .ok_or_else(|| fail(text!("there is none", "没有")))?;
                let files = FileDescriptorSet::decode(schema.data.as_ref())
                    .map_err(|error| fail(Text::of_library(&error)))?;
                // prost-reflect indexes beyond its files when it words its error about another syntax.
                if let Some(other) = files
                    .file
                    .iter()
                    .map(|file| file.syntax())
                    .find(|syntax| !matches!(*syntax, "" | "proto2" | "proto3"))
                {
                    let other: String = other.chars().take(40).collect();
                    return Err(fail(text!(
                        "its syntax is {other:?}, not proto2 or proto3",
                        "语法为 {other:?}，不是 proto2 或 proto3"
                    )));
                }
                let pool = DescriptorPool::from_file_descriptor_set(files)
                    .map_err(|error| fail(Text::of_library(&error)))?;
                let message = pool.get_message_by_name(&schema.name).ok_or_else(|| {
                    fail(text!("it does not define {}", "没有定义 {}", schema.name))
                })?;
                Ok(Self::Protobuf(message))
            }
            other => Err(fail(text!(
                "the encoding {other:?} is not supported",
                "不支持编码 {other:?}"
            ))),
        }
    }

    fn decode(&self, data: &[u8], emit: &mut CellSink) -> Result<(), Text> {
        let mut walk = CellVisitor {
            name: String::new(),
            count: 0,
            emit,
        };
        match self {
            Self::Json => {
                json_values::check_value_count(MAX_COLUMNS, data)?;
                let value: serde_json::Value =
                    serde_json::from_slice(data).map_err(|error| Text::of_library(&error))?;
                walk.json(&value)
            }
            Self::Protobuf(_) if data.len() > MAX_PROTOBUF => Err(text!(
                "it has {} bytes, a table takes at most {MAX_PROTOBUF}",
                "有 {} 字节，表格最多 {MAX_PROTOBUF} 字节",
                data.len()
            )),
            Self::Protobuf(descriptor) => {
                let message = DynamicMessage::decode(descriptor.clone(), data)
                    .map_err(|error| Text::of_library(&error))?;
                walk.message(&message)
            }
        }
    }
}

/// Goes through a message and builds the names on the way. Nesting is bounded by the decoders, which refuse messages
/// that are nested more than about a hundred times.
struct CellVisitor<'a, 'b> {
    name: String,
    count: usize,
    emit: &'a mut CellSink<'b>,
}

type VisitResult = Result<(), Text>;

impl CellVisitor<'_, '_> {
    fn cell(&mut self, cell: CellValue) -> VisitResult {
        self.count += 1;
        if self.count > MAX_COLUMNS {
            return Err(text!(
                "it has more than {MAX_COLUMNS} values",
                "值超过 {MAX_COLUMNS} 个"
            ));
        }
        if self.name.len() > MAX_NAME {
            return Err(text!(
                "the name of a value is longer than {MAX_NAME} bytes",
                "某个值的名称超过 {MAX_NAME} 字节"
            ));
        }
        (self.emit)(&self.name, cell)
    }

    fn field(&mut self, name: &str, go_on: impl FnOnce(&mut Self) -> VisitResult) -> VisitResult {
        let outer = self.name.len();
        if outer > 0 {
            self.name.push('.');
        }
        self.name.push_str(name);
        go_on(self)?;
        self.name.truncate(outer);
        Ok(())
    }

    fn element(
        &mut self,
        index: usize,
        go_on: impl FnOnce(&mut Self) -> VisitResult,
    ) -> VisitResult {
        let outer = self.name.len();
        // Writing to a String cannot fail.
        let _ = write!(self.name, "_{index}");
        go_on(self)?;
        self.name.truncate(outer);
        Ok(())
    }

    fn json(&mut self, value: &serde_json::Value) -> VisitResult {
        use serde_json::Value;
        match value {
            Value::Object(fields) => fields
                .iter()
                .try_for_each(|(name, value)| self.field(name, |walk| walk.json(value))),
            Value::Array(items) => items
                .iter()
                .enumerate()
                .try_for_each(|(i, value)| self.element(i, |walk| walk.json(value))),
            Value::Null => Ok(()),
            Value::String(text) => self.cell(CellValue::Text(text)),
            Value::Bool(_) | Value::Number(_) => self.cell(CellValue::Shown(value)),
        }
    }

    fn message(&mut self, message: &DynamicMessage) -> VisitResult {
        for field in message.descriptor().fields() {
            // A field that can be absent and is has no cell; others have their default.
            if !field.supports_presence() || message.has_field(&field) {
                let value = message.get_field(&field);
                self.field(field.name(), |walk| walk.value(&value))?;
            }
        }
        Ok(())
    }

    fn value(&mut self, value: &Value) -> VisitResult {
        match value {
            Value::Message(message) => match instant(message) {
                Some(ns) => self.cell(CellValue::Nanos(ns)),
                None => self.message(message),
            },
            Value::List(items) => items
                .iter()
                .enumerate()
                .try_for_each(|(i, value)| self.element(i, |walk| walk.value(value))),
            Value::Map(items) => {
                let mut sorted: Vec<_> = items.iter().collect();
                sorted.sort_by(|a, b| a.0.cmp(b.0));
                sorted.into_iter().try_for_each(|(key, value)| {
                    self.field(&format!("{key:?}"), |walk| walk.value(value))
                })
            }
            Value::Bool(x) => self.cell(CellValue::Shown(x)),
            Value::I32(x) | Value::EnumNumber(x) => self.cell(CellValue::Shown(x)),
            Value::I64(x) => self.cell(CellValue::Shown(x)),
            Value::U32(x) => self.cell(CellValue::Shown(x)),
            Value::U64(x) => self.cell(CellValue::Shown(x)),
            Value::F32(x) => self.cell(CellValue::Shown(x)),
            Value::F64(x) => self.cell(CellValue::Shown(x)),
            Value::String(x) => self.cell(CellValue::Text(x)),
            Value::Bytes(x) => self.cell(CellValue::Bytes(x)),
        }
    }
}

/// Value of a cell, not yet text.
enum CellValue<'a> {
    Text(&'a str),
    /// Numbers as the shortest text that reads back the same.
    Shown(&'a dyn fmt::Display),
    /// A time, shown in seconds.
    Nanos(i128),
    Bytes(&'a [u8]),
}

impl fmt::Display for CellValue<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text),
            Self::Shown(value) => value.fmt(f),
            Self::Nanos(ns) => {
                let sign = if *ns < 0 { "-" } else { "" };
                let ns = ns.unsigned_abs();
                let (secs, rest) = (ns / 1_000_000_000, ns % 1_000_000_000);
                write!(f, "{sign}{secs}.{rest:09}")
            }
            Self::Bytes(bytes) => bytes.iter().try_for_each(|byte| write!(f, "{byte:02x}")),
        }
    }
}

/// Nanoseconds of a `google.protobuf.Timestamp` or `Duration`, `None` for other messages.
fn instant(message: &DynamicMessage) -> Option<i128> {
    let descriptor = message.descriptor();
    if !matches!(
        descriptor.full_name(),
        "google.protobuf.Timestamp" | "google.protobuf.Duration"
    ) {
        return None;
    }
    let seconds = message.get_field_by_name("seconds")?.as_i64()?;
    let nanos = message.get_field_by_name("nanos")?.as_i32()?;
    Some(i128::from(seconds) * 1_000_000_000 + i128::from(nanos))
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;
    use std::collections::BTreeMap;
    use std::sync::Arc;

    use prost_types::FileDescriptorProto;

    use super::*;

    #[test]
    fn a_schema_of_another_syntax_is_refused_with_a_sentence() {
        let file = FileDescriptorProto {
            name: Some("a.proto".to_owned()),
            syntax: Some("proto9".to_owned()),
            ..FileDescriptorProto::default()
        };
        let schema = mcap::Schema {
            id: 1,
            name: "a".to_owned(),
            encoding: "protobuf".to_owned(),
            data: Cow::Owned(FileDescriptorSet { file: vec![file] }.encode_to_vec()),
        };
        let channel = Channel {
            id: 1,
            topic: "/a".to_owned(),
            schema: Some(Arc::new(schema)),
            message_encoding: "protobuf".to_owned(),
            metadata: BTreeMap::new(),
        };
        let Err(error) = Decoder::new(&channel) else {
            panic!("there is no such syntax");
        };
        assert!(
            Text::of_library(&error)
                .english()
                .contains("its syntax is \"proto9\""),
            "{error}"
        );
    }
}
