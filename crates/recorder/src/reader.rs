//! Reads recordings, also those of a writer that was killed: everything up to the last complete chunk.
//!
//! The file is read from its start in one pass; memory grows with the largest chunk, not with the file. Whatever the
//! bytes are, reading ends: with the end of the file, or with the first place that is not MCAP, which
//! [`Messages::ending`] tells.

use std::fs::File;
use std::io::{self, BufReader, Cursor, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{Channel, McapError};
use prost::Message as _;
use thiserror::Error;

use crate::cycle::Cycle;
use crate::setup::{METADATA_NAME, Setup, SetupError};
use crate::topics::{
    CommandMessage, IoMessage, LogLevel, LogMessage, ScriptMessage, Topic, VariableMessage,
};

/// No record and no chunk of a recording is larger; a length beyond it is damage, not a reason to allocate.
const MAX_RECORD: usize = 64 << 20;
/// Read from the file at once.
const BUFFER: usize = 256 * 1024;

/// Why a recording cannot be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file cannot be opened or read.
    #[error("cannot read {path}: {source}")]
    Io {
        /// The file.
        path: String,
        /// Why.
        source: io::Error,
    },
    /// Not an MCAP file.
    #[error("{path} is not an MCAP file: {reason}")]
    NotMcap {
        /// The file.
        path: String,
        /// What is wrong.
        reason: String,
    },
    /// An MCAP file without the topic of the cycles.
    #[error("{path} is not a recording of eliteserver: it has no topic /cycle")]
    NotARecording {
        /// The file.
        path: String,
    },
    /// The start configuration cannot be used.
    #[error("{path}: {source}")]
    Setup {
        /// The file.
        path: String,
        /// What is wrong with it.
        source: SetupError,
    },
    /// A message is not what its topic says.
    #[error("message {number} of {topic} cannot be decoded: {reason}")]
    Message {
        /// The topic.
        topic: String,
        /// Number of the message in its topic, from 1.
        number: u64,
        /// What is wrong.
        reason: String,
    },
    /// There is no such topic in the file.
    #[error("there is no topic {topic} in the recording; it has {known}")]
    NoTopic {
        /// The topic asked for.
        topic: String,
        /// Those there are.
        known: String,
    },
    /// A topic's schema cannot be used.
    #[error("the schema of {topic} cannot be used: {reason}")]
    Schema {
        /// The topic.
        topic: String,
        /// Why.
        reason: String,
    },
    /// A message has more values than a table may have columns.
    #[error("{topic} has more than {limit} columns")]
    TooWide {
        /// The topic.
        topic: String,
        /// The largest number of columns.
        limit: usize,
    },
}

/// How a recording ends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ending {
    /// Properly, with its index.
    Complete,
    /// In the middle: the writer was killed, or is still writing.
    Cut,
    /// At a place that is not MCAP.
    Damaged(String),
}

/// A recording that can be read, any number of times.
#[derive(Clone, Debug)]
pub struct Recording {
    source: Source,
    name: String,
    setup: Option<Setup>,
}

#[derive(Clone, Debug)]
enum Source {
    File(PathBuf),
    Bytes(Arc<[u8]>),
}

/// One message as it stands in the file.
#[derive(Clone, Debug)]
pub struct RawMessage {
    /// Topic, encoding and schema.
    pub channel: Arc<Channel<'static>>,
    /// Time stamp, ns: the epoch of the setup plus simulated time.
    pub log_time_ns: u64,
    /// The encoded message.
    pub data: Vec<u8>,
}

/// One message, decoded. Viewers' topics and topics that are not ours are not among them.
#[derive(Clone, Debug, PartialEq)]
pub enum Entry {
    /// `/cycle`
    Cycle(Box<Cycle>),
    /// `/command`
    Command(CommandMessage),
    /// `/script`
    Script(ScriptMessage),
    /// `/log`
    Log(LogMessage),
    /// `/io`
    Io(IoMessage),
    /// A global variable has another value.
    Variable(VariableMessage),
}

impl Recording {
    /// Opens a file.
    ///
    /// # Errors
    /// [`ReadError`] when the file cannot be read or is not a recording.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, ReadError> {
        let path = path.as_ref();
        Self::new(Source::File(path.to_owned()), path.display().to_string())
    }

    /// Reads a recording from memory; `name` is for messages.
    ///
    /// # Errors
    /// [`ReadError`] when the bytes are not a recording.
    pub fn from_bytes(bytes: impl Into<Arc<[u8]>>, name: &str) -> Result<Self, ReadError> {
        Self::new(Source::Bytes(bytes.into()), name.to_owned())
    }

    /// Reads up to the channels, which stand at the beginning.
    fn new(source: Source, name: String) -> Result<Self, ReadError> {
        let mut recording = Self {
            source,
            name,
            setup: None,
        };
        let mut messages = recording.messages()?;
        while !messages.has_cycles() {
            if messages.step().is_none() {
                break;
            }
        }
        let path = recording.name.clone();
        if !messages.has_cycles() {
            return Err(match messages.ending {
                Some(Ending::Damaged(reason)) if messages.is_empty() => {
                    ReadError::NotMcap { path, reason }
                }
                Some(Ending::Cut) if messages.is_empty() => ReadError::NotMcap {
                    path,
                    reason: "it is empty or ends at once".to_owned(),
                },
                _ => ReadError::NotARecording { path },
            });
        }
        recording.setup = messages
            .setup
            .transpose()
            .map_err(|source| ReadError::Setup { path, source })?;
        Ok(recording)
    }

    /// The file, for messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How the controller was started; `None` when the file does not say.
    pub fn setup(&self) -> Option<&Setup> {
        self.setup.as_ref()
    }

    /// Simulated time of a time stamp, s.
    pub fn time_of(&self, log_time_ns: u64) -> f64 {
        let epoch = self.setup.as_ref().map_or(0, |setup| setup.epoch_ns);
        log_time_ns.saturating_sub(epoch) as f64 * 1e-9
    }

    /// Names of all topics in the file.
    ///
    /// # Errors
    /// [`ReadError::Io`] when the file cannot be opened.
    pub fn topics(&self) -> Result<Vec<String>, ReadError> {
        let mut messages = self.messages()?;
        messages.by_ref().for_each(drop);
        Ok(messages.topics)
    }

    /// All messages from the beginning, undecoded.
    ///
    /// # Errors
    /// [`ReadError::Io`] when the file cannot be opened.
    pub fn messages(&self) -> Result<Messages, ReadError> {
        let source: Box<dyn Read> = match &self.source {
            Source::Bytes(bytes) => Box::new(Cursor::new(Arc::clone(bytes))),
            Source::File(path) => {
                let file = File::open(path).map_err(|source| ReadError::Io {
                    path: self.name.clone(),
                    source,
                })?;
                Box::new(BufReader::with_capacity(BUFFER, file))
            }
        };
        Ok(Messages::new(source))
    }

    /// Messages of the given topics from the beginning, decoded, with their time in s.
    ///
    /// # Errors
    /// [`ReadError::Io`] when the file cannot be opened; an item is [`ReadError::Message`] when a message is not what
    /// its topic says.
    pub fn entries(&self, topics: &[Topic]) -> Result<Entries<'_>, ReadError> {
        Ok(Entries {
            recording: self,
            messages: self.messages()?,
            topics: topics.to_vec(),
            numbers: [0; Topic::ALL.len()],
        })
    }

    /// All cycles from the beginning.
    ///
    /// # Errors
    /// As [`entries`](Self::entries).
    pub fn cycles(
        &self,
    ) -> Result<impl Iterator<Item = Result<Cycle, ReadError>> + use<'_>, ReadError> {
        let entries = self.entries(&[Topic::Cycle])?;
        Ok(entries.filter_map(|entry| match entry {
            Ok((_, Entry::Cycle(cycle))) => Some(Ok(*cycle)),
            Ok(_) => None,
            Err(error) => Some(Err(error)),
        }))
    }

    /// All commands from the beginning.
    ///
    /// # Errors
    /// As [`entries`](Self::entries).
    pub fn commands(
        &self,
    ) -> Result<impl Iterator<Item = Result<CommandMessage, ReadError>> + use<'_>, ReadError> {
        let entries = self.entries(&[Topic::Command])?;
        Ok(entries.filter_map(|entry| match entry {
            Ok((_, Entry::Command(command))) => Some(Ok(command)),
            Ok(_) => None,
            Err(error) => Some(Err(error)),
        }))
    }
}

/// The messages of a file in the order in which they were written; see [`Recording::messages`].
pub struct Messages {
    source: Box<dyn Read>,
    reader: LinearReader,
    channels: mcap::read::ChannelAccumulator<'static>,
    setup: Option<Result<Setup, SetupError>>,
    /// Topics seen so far.
    topics: Vec<String>,
    seen_cycles: bool,
    seen_anything: bool,
    ending: Option<Ending>,
}

impl Messages {
    fn new(source: Box<dyn Read>) -> Self {
        let options = LinearReaderOptions::default()
            // A chunk is all there or not there at all.
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(MAX_RECORD);
        Self {
            source,
            reader: LinearReader::new_with_options(options),
            channels: mcap::read::ChannelAccumulator::default(),
            setup: None,
            topics: Vec::new(),
            seen_cycles: false,
            seen_anything: false,
            ending: None,
        }
    }

    /// How the recording ends; known once the iterator has ended.
    pub fn ending(&self) -> Option<&Ending> {
        self.ending.as_ref()
    }

    fn has_cycles(&self) -> bool {
        self.seen_cycles
    }

    fn is_empty(&self) -> bool {
        !self.seen_anything
    }

    /// One record; `Some(None)` when it was not a message, `None` at the end.
    fn step(&mut self) -> Option<Option<RawMessage>> {
        if self.ending.is_some() {
            return None;
        }
        match self.try_step() {
            Ok(Some(step)) => Some(step),
            Ok(None) => {
                self.ending = Some(Ending::Complete);
                None
            }
            Err(error) => {
                self.ending = Some(match error {
                    McapError::UnexpectedEof => Ending::Cut,
                    McapError::Io(error) => Ending::Damaged(error.to_string()),
                    other => Ending::Damaged(other.to_string()),
                });
                None
            }
        }
    }

    fn try_step(&mut self) -> Result<Option<Option<RawMessage>>, McapError> {
        loop {
            let Some(event) = self.reader.next_event() else {
                return Ok(None);
            };
            let (opcode, data) = match event? {
                LinearReadEvent::ReadRequest(need) => {
                    let read = read_some(&mut self.source, self.reader.insert(need))?;
                    self.reader.notify_read(read);
                    continue;
                }
                LinearReadEvent::Record { opcode, data } => (opcode, data),
            };
            self.seen_anything = true;
            // Indexes are for readers that seek.
            if matches!(
                opcode,
                op::MESSAGE_INDEX | op::CHUNK_INDEX | op::STATISTICS | op::SUMMARY_OFFSET
            ) {
                return Ok(Some(None));
            }
            return match mcap::parse_record(opcode, data)? {
                Record::Schema { header, data } => {
                    self.channels.add_schema_from_slice(header, &data)?;
                    Ok(Some(None))
                }
                Record::Channel(channel) => {
                    self.seen_cycles |= channel.topic == Topic::Cycle.name();
                    if !self.topics.contains(&channel.topic) {
                        self.topics.push(channel.topic.clone());
                    }
                    self.channels.add_channel(channel)?;
                    Ok(Some(None))
                }
                Record::Metadata(metadata) => {
                    if metadata.name == METADATA_NAME && self.setup.is_none() {
                        self.setup = Some(Setup::from_map(&metadata.metadata));
                    }
                    Ok(Some(None))
                }
                Record::Message { header, data } => {
                    let channel =
                        self.channels
                            .get(header.channel_id)
                            .ok_or(McapError::UnknownChannel(
                                header.sequence,
                                header.channel_id,
                            ))?;
                    Ok(Some(Some(RawMessage {
                        channel,
                        log_time_ns: header.log_time,
                        data: data.into_owned(),
                    })))
                }
                _ => Ok(Some(None)),
            };
        }
    }
}

impl Iterator for Messages {
    type Item = RawMessage;

    fn next(&mut self) -> Option<RawMessage> {
        loop {
            if let Some(message) = self.step()? {
                return Some(message);
            }
        }
    }
}

/// Decoded messages; see [`Recording::entries`].
pub struct Entries<'a> {
    recording: &'a Recording,
    messages: Messages,
    topics: Vec<Topic>,
    numbers: [u64; Topic::ALL.len()],
}

impl Entries<'_> {
    /// How the recording ends; known once the iterator has ended.
    pub fn ending(&self) -> Option<&Ending> {
        self.messages.ending()
    }
}

impl Iterator for Entries<'_> {
    type Item = Result<(f64, Entry), ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let message = self.messages.next()?;
            let found = Topic::ALL
                .into_iter()
                .find(|topic| topic.name() == message.channel.topic);
            let Some(topic) = found.filter(|topic| self.topics.contains(topic)) else {
                continue;
            };
            let number = &mut self.numbers[topic.index()];
            *number += 1;
            let time = self.recording.time_of(message.log_time_ns);
            match decode(topic, &message.data) {
                Ok(Some(entry)) => return Some(Ok((time, entry))),
                Ok(None) => {}
                Err(reason) => {
                    return Some(Err(ReadError::Message {
                        topic: topic.name().to_owned(),
                        number: *number,
                        reason,
                    }));
                }
            }
        }
    }
}

fn decode(topic: Topic, data: &[u8]) -> Result<Option<Entry>, String> {
    fn json<T: serde::de::DeserializeOwned>(data: &[u8]) -> Result<T, String> {
        serde_json::from_slice(data).map_err(|error| error.to_string())
    }
    Ok(Some(match topic {
        Topic::Cycle => {
            let cycle = Cycle::decode(data).map_err(|error| error.to_string())?;
            Entry::Cycle(Box::new(cycle))
        }
        Topic::Log => {
            let log = foxglove::messages::Log::decode(data).map_err(|error| error.to_string())?;
            Entry::Log(LogMessage {
                level: LogLevel::from_number(log.level),
                source: log.name,
                message: log.message,
            })
        }
        Topic::Command => Entry::Command(json(data)?),
        Topic::Script => Entry::Script(json(data)?),
        Topic::Io => Entry::Io(json(data)?),
        Topic::Variables => Entry::Variable(json(data)?),
        Topic::JointStates | Topic::Tf | Topic::Tcp | Topic::Scene => return Ok(None),
    }))
}

fn read_some(source: &mut dyn Read, buffer: &mut [u8]) -> io::Result<usize> {
    loop {
        match source.read(buffer) {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            result => return result,
        }
    }
}
