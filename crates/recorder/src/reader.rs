//! Recordings of this and of earlier versions, also those of a writer that was killed: decoded messages.
//!
//! The file is read from its start in one pass by [`Messages`]. What an earlier version did not record is as at the
//! start of a controller; [`Recording::missing_fields`] names it. A newer format is refused with a sentence.

use std::collections::BTreeSet;
use std::fmt;
use std::fs::File;
use std::io::{self, Cursor, Read};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use messages::{Text, text};
use prost::Message as _;

use crate::cycle::CycleMessage;
pub use crate::messages::{FileEnd, Messages, RawMessage};
pub use crate::read_error::ReadError;
use crate::setup::Setup;
use crate::topics::{
    CommandMessage, IoMessage, LogLevel, LogMessage, LogTranslation, ScriptMessage, Topic,
    VariableMessage,
};

/// A recording that can be read, any number of times.
#[derive(Clone, Debug)]
pub struct Recording {
    source: RecordingSource,
    name: String,
    setup: Option<Setup>,
    missing_fields: Vec<&'static str>,
    missing_files: Vec<String>,
    /// An end that is none, once somebody came there.
    trouble: Arc<OnceLock<FileEnd>>,
}

/// Begins the bytes of a recording anew.
type Opener = dyn Fn() -> io::Result<Box<dyn Read>> + Send + Sync;

#[derive(Clone)]
enum RecordingSource {
    File(PathBuf),
    Bytes(Arc<[u8]>),
    Opened(Arc<Opener>),
}

impl fmt::Debug for RecordingSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(path) => f.debug_tuple("File").field(path).finish(),
            Self::Bytes(bytes) => f.debug_tuple("Bytes").field(&bytes.len()).finish(),
            Self::Opened(_) => f.write_str("Opened"),
        }
    }
}

/// One message, decoded. Viewers' topics and topics that are not ours are not among them.
#[derive(Clone, Debug, PartialEq)]
pub enum RecordingEntry {
    /// `/cycle`
    Cycle(Box<CycleMessage>),
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
        Self::new(
            RecordingSource::File(path.to_owned()),
            path.display().to_string(),
        )
    }

    /// Reads a recording from memory; `name` is for messages.
    ///
    /// # Errors
    /// [`ReadError`] when the bytes are not a recording.
    pub fn from_bytes(bytes: impl Into<Arc<[u8]>>, name: &str) -> Result<Self, ReadError> {
        Self::new(RecordingSource::Bytes(bytes.into()), name.to_owned())
    }

    /// Reads a recording that `open` begins anew each time it is read, from wherever; `name` is for messages. An error
    /// of the reader ends the recording as damage does.
    ///
    /// # Errors
    /// The errors of [`open`](Self::open).
    pub fn from_opener(
        open: impl Fn() -> io::Result<Box<dyn Read>> + Send + Sync + 'static,
        name: &str,
    ) -> Result<Self, ReadError> {
        Self::new(RecordingSource::Opened(Arc::new(open)), name.to_owned())
    }

    /// Reads up to the channels, which stand at the beginning.
    fn new(source: RecordingSource, name: String) -> Result<Self, ReadError> {
        let mut recording = Self {
            source,
            name,
            setup: None,
            missing_fields: Vec::new(),
            missing_files: Vec::new(),
            trouble: Arc::default(),
        };
        let trouble = Arc::clone(&recording.trouble);
        let mut messages = Messages::with_files(recording.bytes()?, trouble);
        while !messages.has_cycles() {
            if messages.read_record().is_none() {
                break;
            }
        }
        let path = recording.name.clone();
        if !messages.has_cycles() {
            return Err(match messages.ending() {
                Some(FileEnd::Damaged(reason)) if messages.is_empty() => {
                    let reason = reason.clone();
                    ReadError::NotMcap { path, reason }
                }
                Some(FileEnd::Damaged(reason)) => {
                    let reason = reason.clone();
                    ReadError::Damaged { path, reason }
                }
                Some(FileEnd::Truncated) if messages.is_empty() => ReadError::NotMcap {
                    path,
                    reason: text!("it is empty or ends at once", "文件为空或刚开始就结束"),
                },
                _ => ReadError::NotARecording { path },
            });
        }
        let beginning = messages
            .into_beginning()
            .map_err(|source| ReadError::Setup { path, source })?;
        recording.setup = beginning.setup;
        recording.missing_fields = beginning.missing_fields;
        recording.missing_files = beginning.missing_files;
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

    /// Fields of `/cycle` that the version that recorded did not know.
    pub fn missing_fields(&self) -> &[&'static str] {
        &self.missing_fields
    }

    /// Whether all files of the cell are in [`Setup::files`]. Cycles, commands and messages are read without them; what
    /// runs the recording again or looks at its cell asks first.
    ///
    /// # Errors
    /// [`ReadError::CellFile`] with the first file that is lost or damaged.
    pub fn check_files(&self) -> Result<(), ReadError> {
        match self.missing_files.first() {
            None => Ok(()),
            Some(file) => Err(ReadError::CellFile {
                path: self.name.clone(),
                file: file.clone(),
            }),
        }
    }

    /// Simulated time of a time stamp, s.
    pub fn time_of(&self, log_time_ns: u64) -> f64 {
        let epoch = self.setup.as_ref().map_or(0, |setup| setup.epoch_ns);
        log_time_ns.saturating_sub(epoch) as f64 * 1e-9
    }

    /// Names of all topics in the file, sorted.
    ///
    /// # Errors
    /// [`ReadError::IoSystem`] when the file cannot be opened.
    pub fn topics(&self) -> Result<BTreeSet<String>, ReadError> {
        let mut messages = self.messages()?;
        messages.by_ref().for_each(drop);
        Ok(messages.into_topics())
    }

    /// How the file ends, if somebody has read it to there and it is not properly.
    pub fn abnormal_end(&self) -> Option<&FileEnd> {
        self.trouble.get()
    }

    /// All messages from the beginning, undecoded.
    ///
    /// # Errors
    /// [`ReadError::IoSystem`] when the file cannot be opened.
    pub fn messages(&self) -> Result<Messages, ReadError> {
        Ok(Messages::new(self.bytes()?, Arc::clone(&self.trouble)))
    }

    /// The bytes from the beginning.
    fn bytes(&self) -> Result<Box<dyn Read>, ReadError> {
        let failed = |source| ReadError::Io {
            path: self.name.clone(),
            source,
        };
        Ok(match &self.source {
            RecordingSource::Bytes(bytes) => Box::new(Cursor::new(Arc::clone(bytes))),
            RecordingSource::File(path) => Box::new(open(path).map_err(failed)?),
            RecordingSource::Opened(open) => open().map_err(failed)?,
        })
    }

    /// Messages of the given topics from the beginning, decoded, with their time in s.
    ///
    /// # Errors
    /// [`ReadError::IoSystem`] when the file cannot be opened; an item is [`ReadError::Message`] when a message is not
    /// what its topic says.
    pub fn entries(&self, topics: &[Topic]) -> Result<RecordingEntries<'_>, ReadError> {
        Ok(RecordingEntries {
            recording: self,
            messages: self.messages()?,
            topics: topics.to_vec(),
            numbers: [0; Topic::ALL.len()],
        })
    }

    /// All cycles from the beginning.
    ///
    /// # Errors
    /// The errors of [`entries`](Self::entries).
    pub fn cycles(
        &self,
    ) -> Result<impl Iterator<Item = Result<CycleMessage, ReadError>> + use<'_>, ReadError> {
        let entries = self.entries(&[Topic::Cycle])?;
        Ok(entries.filter_map(|entry| match entry {
            Ok((_, RecordingEntry::Cycle(cycle))) => Some(Ok(*cycle)),
            Ok(_) => None,
            Err(error) => Some(Err(error)),
        }))
    }

    /// All commands from the beginning.
    ///
    /// # Errors
    /// The errors of [`entries`](Self::entries).
    pub fn commands(
        &self,
    ) -> Result<impl Iterator<Item = Result<CommandMessage, ReadError>> + use<'_>, ReadError> {
        let entries = self.entries(&[Topic::Command])?;
        Ok(entries.filter_map(|entry| match entry {
            Ok((_, RecordingEntry::Command(command))) => Some(Ok(command)),
            Ok(_) => None,
            Err(error) => Some(Err(error)),
        }))
    }
}

/// Decoded messages; see [`Recording::entries`].
pub struct RecordingEntries<'a> {
    recording: &'a Recording,
    messages: Messages,
    topics: Vec<Topic>,
    numbers: [u64; Topic::ALL.len()],
}

impl RecordingEntries<'_> {
    /// How the recording ends; known once the iterator has ended.
    pub fn ending(&self) -> Option<&FileEnd> {
        self.messages.ending()
    }
}

impl Iterator for RecordingEntries<'_> {
    type Item = Result<(f64, RecordingEntry), ReadError>;

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

/// The messages of any MCAP file, a recording or not, undecoded. Their reading is bounded as that of a recording is.
///
/// # Errors
/// [`ReadError::Io`] when the file cannot be opened.
pub fn messages_of_file(path: impl AsRef<Path>) -> Result<Messages, ReadError> {
    let path = path.as_ref();
    let file = open(path).map_err(|source| ReadError::Io {
        path: path.display().to_string(),
        source,
    })?;
    Ok(Messages::new(Box::new(file), Arc::default()))
}

/// Opens a file. What is none is turned down: it might keep the reader waiting, and is read more than once.
fn open(path: &Path) -> io::Result<File> {
    if path.metadata()?.is_file() {
        return File::open(path);
    }
    let text = text!(
        "it is a folder, a pipe or a device; recordings are files",
        "它是文件夹、管道或设备；记录是文件"
    );
    Err(io::Error::new(io::ErrorKind::Unsupported, text))
}

/// Bytes that a message of a topic may have. Decoded, some of them are many times as large.
const fn max_message_bytes(topic: Topic) -> usize {
    match topic {
        Topic::Cycle | Topic::Command | Topic::Io | Topic::Variables => 64 << 10,
        Topic::Log => 16 << 20,
        // What a chunk holds.
        Topic::Script | Topic::JointStates | Topic::Tf | Topic::Tcp | Topic::Scene => usize::MAX,
    }
}

fn decode(topic: Topic, data: &[u8]) -> Result<Option<RecordingEntry>, Text> {
    if data.len() > max_message_bytes(topic) {
        return Err(text!(
            "it has {} bytes, at most {} are read",
            "有 {} 字节，最多读取 {} 字节",
            data.len(),
            max_message_bytes(topic)
        ));
    }
    fn json<T: serde::de::DeserializeOwned>(data: &[u8]) -> Result<T, Text> {
        serde_json::from_slice(data).map_err(|error| Text::of_library(&error))
    }
    Ok(Some(match topic {
        Topic::Cycle => {
            let cycle = CycleMessage::decode(data).map_err(|error| Text::of_library(&error))?;
            RecordingEntry::Cycle(Box::new(cycle))
        }
        Topic::Log => {
            let wrong = |error: prost::DecodeError| Text::of_library(&error);
            let log = foxglove::messages::Log::decode(data).map_err(wrong)?;
            let translation = LogTranslation::decode(data).map_err(wrong)?;
            RecordingEntry::Log(LogMessage {
                level: LogLevel::from_number(log.level),
                source: log.name,
                message: Text::recorded(log.message, translation.chinese),
            })
        }
        Topic::Command => RecordingEntry::Command(json(data)?),
        Topic::Script => RecordingEntry::Script(json(data)?),
        Topic::Io => RecordingEntry::Io(json(data)?),
        Topic::Variables => RecordingEntry::Variable(json(data)?),
        Topic::JointStates | Topic::Tf | Topic::Tcp | Topic::Scene => return Ok(None),
    }))
}
