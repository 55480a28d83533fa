//! The messages of an MCAP file, undecoded, up to its end or to the first place that is not MCAP.
//!
//! Memory grows with the largest chunk, not with the file. A chunk is all there or not there at all. Whatever the bytes
//! are, reading ends.

use std::io::{self, Read};
use std::sync::Arc;

use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{Channel, McapError};

use crate::cycle::Cycle;
use crate::setup::{METADATA_NAME, Setup, SetupError};
use crate::topics::Topic;

/// No record and no chunk of a recording is larger; a length beyond it is damage, not a reason to allocate.
const MAX_RECORD: usize = 64 << 20;

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

/// The messages of a file in the order in which they were written; see [`Recording::messages`](crate::Recording::messages).
pub struct Messages {
    source: Box<dyn Read>,
    reader: LinearReader,
    channels: mcap::read::ChannelAccumulator<'static>,
    setup: Option<Result<Setup, SetupError>>,
    /// Topics seen so far.
    topics: Vec<String>,
    /// Fields of this version's `elite.Cycle` that the file's does not have; known once its channel was read.
    missing_fields: Option<Vec<&'static str>>,
    seen_anything: bool,
    ending: Option<Ending>,
}

impl Messages {
    pub(crate) fn new(source: Box<dyn Read>) -> Self {
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
            missing_fields: None,
            seen_anything: false,
            ending: None,
        }
    }

    /// How the recording ends; known once the iterator has ended.
    pub fn ending(&self) -> Option<&Ending> {
        self.ending.as_ref()
    }

    pub(crate) fn has_cycles(&self) -> bool {
        self.missing_fields.is_some()
    }

    /// Set-up and missing fields of the cycle, once [`has_cycles`](Self::has_cycles).
    pub(crate) fn into_beginning(self) -> (Option<Result<Setup, SetupError>>, Vec<&'static str>) {
        (self.setup, self.missing_fields.unwrap_or_default())
    }

    pub(crate) fn into_topics(self) -> Vec<String> {
        self.topics
    }

    /// Not one record was read.
    pub(crate) fn is_empty(&self) -> bool {
        !self.seen_anything
    }

    /// One record; `Some(None)` when it was not a message, `None` at the end.
    pub(crate) fn step(&mut self) -> Option<Option<RawMessage>> {
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
                    let (id, is_cycle) = (channel.id, channel.topic == Topic::Cycle.name());
                    if !self.topics.contains(&channel.topic) {
                        self.topics.push(channel.topic.clone());
                    }
                    self.channels.add_channel(channel)?;
                    if is_cycle {
                        let schema = self.channels.get(id).and_then(|c| c.schema.clone());
                        let data = schema.as_ref().map_or(&[][..], |schema| &schema.data);
                        self.missing_fields = Some(Cycle::fields_missing_in(data));
                    }
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

fn read_some(source: &mut dyn Read, buffer: &mut [u8]) -> io::Result<usize> {
    loop {
        match source.read(buffer) {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            result => return result,
        }
    }
}
