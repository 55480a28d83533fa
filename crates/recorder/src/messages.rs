//! The messages of an MCAP file, undecoded, up to its end or to the first place that is not MCAP.
//!
//! What a file declares (schemas, channels, its start configuration) is kept, and bounded; messages come one by one.
//! How the bytes become records is [`records`](crate::records)' business. Whatever the bytes are, reading ends.

use std::collections::BTreeSet;
use std::io::Read;
use std::sync::{Arc, OnceLock};

use mcap::Channel;
use mcap::records::{Record, op};
use messages::{Text, text};

use crate::cycle::CycleMessage;
use crate::files::CellFileCollector;
use crate::records::{self, Records, damaged, in_words};
use crate::setup::{METADATA_NAME, Setup, SetupError, file_paths};
use crate::topics::Topic;

/// A schema or a channel of a recording has some kilobytes.
const MAX_DECLARATION: usize = 1 << 20;
/// All of them together.
const MAX_DECLARED: usize = 16 << 20;
/// What one of them costs beside its bytes.
const DECLARATION_COST: usize = 1 << 10;
/// The start configuration holds the text of a cell file and of a URDF.
const MAX_METADATA: usize = 16 << 20;

/// How a recording ends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FileEnd {
    /// Properly, with its index.
    Complete,
    /// In the middle: the writer was killed, or is still writing.
    Truncated,
    /// The file goes on with bytes that are not MCAP.
    Damaged(Text),
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

/// The messages of a file in the order in which they were written; see
/// [`Recording::messages`](crate::Recording::messages).
pub struct Messages {
    records: Records,
    channels: mcap::read::ChannelAccumulator<'static>,
    /// Numbers of the schemas so far.
    schemas: BTreeSet<u16>,
    /// Bytes of schemas and channels so far.
    declared: usize,
    setup: Option<Result<(Setup, BTreeSet<String>), SetupError>>,
    /// Files of the cell so far, where they are wanted.
    files: Option<CellFileCollector>,
    /// Topics seen so far.
    topics: BTreeSet<String>,
    /// Fields of this version's `elite.CycleMessage` that the file's does not have; known once its channel was read.
    missing_fields: Option<Vec<&'static str>>,
    seen_anything: bool,
    ending: Option<FileEnd>,
    /// Place where a reader leaves word of an abnormal end.
    abnormal_end: Arc<OnceLock<FileEnd>>,
}

/// What a recording says before its first cycle.
#[derive(Debug, Default)]
pub(crate) struct FileBeginning {
    /// How the controller was started, where the file says so.
    pub setup: Option<Setup>,
    /// Fields of `/cycle` that the version that recorded did not know.
    pub missing_fields: Vec<&'static str>,
    /// Files of the cell that should be there.
    pub missing_files: Vec<String>,
}

impl Messages {
    pub(crate) fn new(source: Box<dyn Read>, trouble: Arc<OnceLock<FileEnd>>) -> Self {
        Self::start(source, trouble, None)
    }

    /// Keeps the files of the cell, too, for [`into_beginning`](Self::into_beginning).
    pub(crate) fn with_files(source: Box<dyn Read>, trouble: Arc<OnceLock<FileEnd>>) -> Self {
        Self::start(source, trouble, Some(CellFileCollector::default()))
    }

    fn start(
        source: Box<dyn Read>,
        trouble: Arc<OnceLock<FileEnd>>,
        files: Option<CellFileCollector>,
    ) -> Self {
        Self {
            records: Records::new(source, files.is_some()),
            channels: mcap::read::ChannelAccumulator::default(),
            schemas: BTreeSet::new(),
            declared: 0,
            setup: None,
            files,
            topics: BTreeSet::new(),
            missing_fields: None,
            seen_anything: false,
            ending: None,
            abnormal_end: trouble,
        }
    }

    /// How the recording ends; known once the iterator has ended.
    pub fn ending(&self) -> Option<&FileEnd> {
        self.ending.as_ref()
    }

    pub(crate) fn has_cycles(&self) -> bool {
        self.missing_fields.is_some()
    }

    /// What stands before the first cycle, once [`has_cycles`](Self::has_cycles).
    ///
    /// # Errors
    /// The start configuration cannot be used.
    pub(crate) fn into_beginning(self) -> Result<FileBeginning, SetupError> {
        let mut beginning = FileBeginning {
            missing_fields: self.missing_fields.unwrap_or_default(),
            ..FileBeginning::default()
        };
        if let Some((mut setup, paths)) = self.setup.transpose()? {
            (setup.files, beginning.missing_files) =
                self.files.unwrap_or_default().into_files(paths);
            beginning.setup = Some(setup);
        }
        Ok(beginning)
    }

    pub(crate) fn into_topics(self) -> BTreeSet<String> {
        self.topics
    }

    /// Whether not one record was read.
    pub(crate) fn is_empty(&self) -> bool {
        !self.seen_anything
    }

    /// One record; `Some(None)` when it was not a message, `None` at the end.
    pub(crate) fn read_record(&mut self) -> Option<Option<RawMessage>> {
        if self.ending.is_some() {
            return None;
        }
        match self.try_step() {
            Ok(Some(step)) => Some(step),
            Ok(None) => {
                self.ending = Some(FileEnd::Complete);
                None
            }
            Err(ending) => {
                // The first one stands; they are the same unless the file changes.
                let _ = self.abnormal_end.set(ending.clone());
                self.ending = Some(ending);
                None
            }
        }
    }

    fn try_step(&mut self) -> Result<Option<Option<RawMessage>>, FileEnd> {
        let Some((opcode, data)) = self.records.next()? else {
            return Ok(None);
        };
        self.seen_anything = true;
        match opcode {
            op::SCHEMA | op::CHANNEL if data.len() > MAX_DECLARATION => {
                return Err(damaged(text!(
                    "a schema or a channel has {} bytes; at most {MAX_DECLARATION} are read",
                    "结构定义或通道有 {} 字节；最多读取 {MAX_DECLARATION} 字节",
                    data.len()
                )));
            }
            op::METADATA if data.len() > MAX_METADATA => {
                return Err(damaged(text!(
                    "a metadata record has {} bytes; at most {MAX_METADATA} are read",
                    "元数据项有 {} 字节；最多读取 {MAX_METADATA} 字节",
                    data.len()
                )));
            }
            op::SCHEMA | op::CHANNEL | op::MESSAGE => {}
            op::METADATA if self.setup.is_none() => {}
            op::ATTACHMENT => {
                if let Some(files) = &mut self.files {
                    files.take(data);
                }
                return Ok(Some(None));
            }
            _ => return Ok(Some(None)),
        }
        let cost = data.len() + DECLARATION_COST;
        match records::parse(opcode, data)? {
            Record::Schema { header, data } => {
                if self.schemas.insert(header.id) {
                    count_declaration(&mut self.declared, cost)?;
                }
                self.channels
                    .add_schema_from_slice(header, &data)
                    .map_err(in_words)?;
            }
            Record::Channel(channel) => {
                let (id, topic) = (channel.id, channel.topic.clone());
                if self.channels.get(id).is_none() {
                    count_declaration(&mut self.declared, cost)?;
                }
                self.channels.add_channel(channel).map_err(in_words)?;
                if topic == Topic::Cycle.name() && self.missing_fields.is_none() {
                    let schema = self.channels.get(id).and_then(|c| c.schema.clone());
                    let data = schema.as_ref().map_or(&[][..], |schema| &schema.data);
                    self.missing_fields = Some(CycleMessage::fields_missing_in(data));
                }
                self.topics.insert(topic);
            }
            Record::Metadata(metadata) if metadata.name == METADATA_NAME => {
                let map = &metadata.metadata;
                let setup = Setup::from_map(map);
                self.setup = Some(setup.and_then(|setup| Ok((setup, file_paths(map)?))));
            }
            Record::Message { header, data } => {
                let channel = self.channels.get(header.channel_id);
                let channel = channel.ok_or_else(|| {
                    let id = header.channel_id;
                    damaged(text!(
                        "a message is of channel {id}, which is not declared",
                        "消息属于未声明的通道 {id}"
                    ))
                })?;
                return Ok(Some(Some(RawMessage {
                    channel,
                    log_time_ns: header.log_time,
                    data: data.into_owned(),
                })));
            }
            _ => {}
        }
        Ok(Some(None))
    }
}

/// Takes note of one more schema or channel.
fn count_declaration(declared: &mut usize, cost: usize) -> Result<(), FileEnd> {
    *declared += cost;
    match *declared <= MAX_DECLARED {
        true => Ok(()),
        false => Err(damaged(text!(
            "its schemas and channels have more than {MAX_DECLARED} bytes together",
            "其结构定义和通道共超过 {MAX_DECLARED} 字节"
        ))),
    }
}

impl Iterator for Messages {
    type Item = RawMessage;

    fn next(&mut self) -> Option<RawMessage> {
        loop {
            if let Some(message) = self.read_record()? {
                return Some(message);
            }
        }
    }
}
