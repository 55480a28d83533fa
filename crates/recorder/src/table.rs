//! Any topic as a table of text: one row a message, one column a value.
//!
//! Messages are decoded with the schema that the file carries, so that topics of other programs work too. Elements of
//! vectors are `name_0`, `name_1` ...; fields of messages in messages are `outer.inner`. The first column, `log_time`,
//! is the time stamp in seconds.

use std::collections::HashMap;

use mcap::Channel;
use prost_reflect::{DescriptorPool, DynamicMessage, MessageDescriptor, ReflectMessage, Value};

use crate::reader::{RawMessage, ReadError, Recording};

/// More columns than a person or a spreadsheet can use.
const MAX_COLUMNS: usize = 10_000;

/// A topic as a table.
pub struct Table<'a> {
    recording: &'a Recording,
    topic: String,
    columns: Vec<String>,
}

impl<'a> Table<'a> {
    /// Reads the topic once to find its columns, in the order in which they first occur.
    ///
    /// # Errors
    /// [`ReadError`] when there is no such topic, or a message is not what the topic's schema says.
    pub fn new(recording: &'a Recording, topic: &str) -> Result<Self, ReadError> {
        let topic = format!("/{}", topic.trim_start_matches('/'));
        let mut table = Self {
            recording,
            topic,
            columns: Vec::new(),
        };
        let mut known = HashMap::new();
        let mut found = false;
        for cells in table.messages()? {
            found = true;
            for (name, _) in cells? {
                if !known.contains_key(&name) {
                    known.insert(name.clone(), ());
                    table.columns.push(name);
                }
            }
            if table.columns.len() > MAX_COLUMNS {
                return Err(ReadError::TooWide {
                    topic: table.topic,
                    limit: MAX_COLUMNS,
                });
            }
        }
        if !found {
            table.columns.push(TIME_COLUMN.to_owned());
            table.topic_exists()?;
        }
        Ok(table)
    }

    /// Names of the columns.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// The rows; a cell is `None` where the message has no such value.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn rows(
        &self,
    ) -> Result<impl Iterator<Item = Result<Vec<Option<String>>, ReadError>> + use<'_>, ReadError>
    {
        let places: HashMap<&str, usize> =
            self.columns.iter().map(String::as_str).zip(0..).collect();
        let messages = self.messages()?;
        Ok(messages.map(move |cells| {
            let mut row = vec![None; places.len()];
            for (name, value) in cells? {
                // A file that grew since its columns were found may have new ones.
                if let Some(&place) = places.get(name.as_str()) {
                    row[place] = Some(value);
                }
            }
            Ok(row)
        }))
    }

    /// The messages of the topic as lists of named cells.
    fn messages(
        &self,
    ) -> Result<impl Iterator<Item = Result<Vec<(String, String)>, ReadError>> + use<'a>, ReadError>
    {
        let topic = self.topic.clone();
        let mut decoder: Option<Decoder> = None;
        let mut number = 0;
        let recording = self.recording;
        let messages = recording.messages()?;
        let of_topic = messages.filter(move |message| message.channel.topic == topic);
        Ok(of_topic.map(move |message| {
            number += 1;
            let decoder = match &mut decoder {
                Some(decoder) => decoder,
                none => none.insert(Decoder::new(&message.channel)?),
            };
            let mut cells = vec![(TIME_COLUMN.to_owned(), seconds(recording, &message))];
            decoder
                .decode(&message.data, &mut cells)
                .map_err(|reason| ReadError::Message {
                    topic: message.channel.topic.clone(),
                    number,
                    reason,
                })?;
            Ok(cells)
        }))
    }

    /// An empty topic of ours is no error, an unknown one is.
    fn topic_exists(&self) -> Result<(), ReadError> {
        let mut known = self.recording.topics()?;
        if known.contains(&self.topic) {
            return Ok(());
        }
        known.sort();
        Err(ReadError::NoTopic {
            topic: self.topic.clone(),
            known: known.join(", "),
        })
    }
}

const TIME_COLUMN: &str = "log_time";

fn seconds(recording: &Recording, message: &RawMessage) -> String {
    let epoch = recording.setup().map_or(0, |setup| setup.epoch_ns);
    decimal_seconds(message.log_time_ns.saturating_sub(epoch))
}

fn decimal_seconds(ns: u64) -> String {
    format!("{}.{:09}", ns / 1_000_000_000, ns % 1_000_000_000)
}

enum Decoder {
    Json,
    Protobuf(MessageDescriptor),
}

impl Decoder {
    fn new(channel: &Channel) -> Result<Self, ReadError> {
        let fail = |reason: String| ReadError::Schema {
            topic: channel.topic.clone(),
            reason,
        };
        match channel.message_encoding.as_str() {
            "json" => Ok(Self::Json),
            "protobuf" => {
                let schema = channel
                    .schema
                    .as_ref()
                    .ok_or_else(|| fail("there is none".to_owned()))?;
                let pool = DescriptorPool::decode(schema.data.as_ref())
                    .map_err(|error| fail(error.to_string()))?;
                let message = pool.get_message_by_name(&schema.name).ok_or_else(|| {
                    fail(format!("it does not define the message {}", schema.name))
                })?;
                Ok(Self::Protobuf(message))
            }
            other => Err(fail(format!("the encoding {other:?} is not supported"))),
        }
    }

    fn decode(&self, data: &[u8], cells: &mut Vec<(String, String)>) -> Result<(), String> {
        match self {
            Self::Json => {
                let value: serde_json::Value =
                    serde_json::from_slice(data).map_err(|error| error.to_string())?;
                flatten_json("", &value, cells)
            }
            Self::Protobuf(descriptor) => {
                let message = DynamicMessage::decode(descriptor.clone(), data)
                    .map_err(|error| error.to_string())?;
                flatten_message("", &message, cells)
            }
        }
    }
}

type Cells = Vec<(String, String)>;

fn push(name: &str, value: String, cells: &mut Cells) -> Result<(), String> {
    if cells.len() > MAX_COLUMNS {
        return Err(format!("it has more than {MAX_COLUMNS} values"));
    }
    cells.push((name.to_owned(), value));
    Ok(())
}

fn inner(outer: &str, name: &str) -> String {
    if outer.is_empty() {
        name.to_owned()
    } else {
        format!("{outer}.{name}")
    }
}

fn flatten_json(name: &str, value: &serde_json::Value, cells: &mut Cells) -> Result<(), String> {
    use serde_json::Value;
    match value {
        Value::Object(fields) => fields
            .iter()
            .try_for_each(|(key, value)| flatten_json(&inner(name, key), value, cells)),
        Value::Array(items) => items
            .iter()
            .enumerate()
            .try_for_each(|(i, value)| flatten_json(&format!("{name}_{i}"), value, cells)),
        Value::Null => Ok(()),
        Value::String(text) => push(name, text.clone(), cells),
        Value::Bool(_) | Value::Number(_) => push(name, value.to_string(), cells),
    }
}

fn flatten_message(name: &str, message: &DynamicMessage, cells: &mut Cells) -> Result<(), String> {
    for field in message.descriptor().fields() {
        // A field that can be absent and is has no cell; others have their default.
        if field.supports_presence() && !message.has_field(&field) {
            continue;
        }
        let value = message.get_field(&field);
        flatten_value(&inner(name, field.name()), &value, cells)?;
    }
    Ok(())
}

fn flatten_value(name: &str, value: &Value, cells: &mut Cells) -> Result<(), String> {
    let text = match value {
        Value::Message(message) => {
            return match instant(message) {
                Some(text) => push(name, text, cells),
                None => flatten_message(name, message, cells),
            };
        }
        Value::List(items) => {
            return items
                .iter()
                .enumerate()
                .try_for_each(|(i, value)| flatten_value(&format!("{name}_{i}"), value, cells));
        }
        Value::Map(items) => {
            let mut sorted: Vec<_> = items.iter().collect();
            sorted.sort_by(|a, b| a.0.cmp(b.0));
            return sorted.into_iter().try_for_each(|(key, value)| {
                flatten_value(&inner(name, &format!("{key:?}")), value, cells)
            });
        }
        Value::Bool(x) => x.to_string(),
        Value::I32(x) | Value::EnumNumber(x) => x.to_string(),
        Value::I64(x) => x.to_string(),
        Value::U32(x) => x.to_string(),
        Value::U64(x) => x.to_string(),
        Value::F32(x) => x.to_string(),
        Value::F64(x) => x.to_string(),
        Value::String(x) => x.clone(),
        Value::Bytes(x) => x.iter().map(|byte| format!("{byte:02x}")).collect(),
    };
    push(name, text, cells)
}

/// Seconds of a `google.protobuf.Timestamp` or `Duration`, `None` for other messages.
fn instant(message: &DynamicMessage) -> Option<String> {
    let descriptor = message.descriptor();
    if !matches!(
        descriptor.full_name(),
        "google.protobuf.Timestamp" | "google.protobuf.Duration"
    ) {
        return None;
    }
    let seconds = message.get_field_by_name("seconds")?.as_i64()?;
    let nanos = message.get_field_by_name("nanos")?.as_i32()?;
    let total = i128::from(seconds) * 1_000_000_000 + i128::from(nanos);
    let sign = if total < 0 { "-" } else { "" };
    let ns = u64::try_from(total.unsigned_abs()).ok()?;
    Some(format!("{sign}{}", decimal_seconds(ns)))
}
