//! Messages into the chunks of an MCAP file. Knows topics and bytes, not what they mean.
//!
//! A chunk is closed before it grows past [`CHUNK_BYTES`] and when it spans [`CHUNK_SECS`], so that a kill loses
//! little; with the same messages in the same order the file is the same, byte for byte.

use std::collections::BTreeMap;
use std::io::Write;

use mcap::McapError;
use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use serde::Serialize;

use crate::extra::{CustomTopic, CustomTopicId};
use crate::files;
use crate::setup::{METADATA_NAME, Setup};
use crate::topics::Topic;

/// Uncompressed size that a chunk of small messages does not exceed. A larger message has a chunk of its own.
pub const CHUNK_BYTES: usize = 128 * 1024;
/// Simulated time that a chunk does not exceed, s.
pub const CHUNK_SECS: f64 = 0.25;
/// Bytes that MCAP adds to a message: opcode, length, header.
const MESSAGE_OVERHEAD: usize = 1 + 8 + 22;

/// A file that is being written.
pub(crate) struct ChunkedFile<W: Write> {
    mcap: mcap::Writer<NoSeek<W>>,
    /// Our topics, then the others.
    channels: Vec<OpenChannel>,
    epoch_ns: u64,
    chunk: Option<OpenChunk>,
    /// Chunks begun so far, in all parts of the recording.
    chunks: u64,
    /// Encoded message, reused.
    buffer: Vec<u8>,
}

/// A channel of the file and the number of its next message.
struct OpenChannel {
    id: u16,
    sequence: u32,
}

struct OpenChunk {
    number: u64,
    bytes: usize,
    /// Time of its first message, s.
    since: f64,
}

impl<W: Write> ChunkedFile<W> {
    /// Writes the beginning: set-up, files of the cell and schemas. `chunks` is how many chunks earlier parts had.
    pub(crate) fn begin(
        out: W,
        setup: &Setup,
        extra: &[CustomTopic],
        chunks: u64,
    ) -> Result<Self, McapError> {
        let mut mcap = mcap::WriteOptions::new()
            .library(concat!("eliteserver ", env!("CARGO_PKG_VERSION")))
            .compression(Some(mcap::Compression::Zstd))
            .compression_level(1)
            // The recorder has its own thread; more of them would take time from the motion thread.
            .compression_threads(0)
            // Chunks are closed here, by size and time.
            .chunk_size(None)
            // Whole chunks are built in memory and appended: works on any output, and a kill leaves no half header.
            .disable_seeking(true)
            .create(NoSeek::new(out))?;
        mcap.write_metadata(&Metadata {
            name: METADATA_NAME.to_owned(),
            metadata: setup.to_map(),
        })?;
        files::write(&mut mcap, &setup.files, setup.epoch_ns)?;
        let none = BTreeMap::new();
        let mut channels = Vec::with_capacity(Topic::ALL.len() + extra.len());
        // In the order of their indices.
        for topic in Topic::ALL {
            let schema = topic.schema();
            let schema = mcap.add_schema(&schema.name, schema.encoding, &schema.data)?;
            let id = mcap.add_channel(schema, topic.name(), topic.message_encoding(), &none)?;
            channels.push(OpenChannel { id, sequence: 0 });
        }
        for topic in extra {
            let schema = topic.schema.as_bytes();
            let schema = mcap.add_schema(&topic.schema_name, "jsonschema", schema)?;
            let id = mcap.add_channel(schema, &topic.name, "json", &none)?;
            channels.push(OpenChannel { id, sequence: 0 });
        }
        Ok(Self {
            mcap,
            channels,
            epoch_ns: setup.epoch_ns,
            chunk: None,
            chunks,
            buffer: Vec::new(),
        })
    }

    /// Chunks begun so far, in all parts.
    pub(crate) fn chunks(&self) -> u64 {
        self.chunks
    }

    /// The number of the chunk that a kill would lose now, if there is one.
    pub(crate) fn open_chunk(&self) -> Option<u64> {
        self.chunk.as_ref().map(|chunk| chunk.number)
    }

    /// Hands everything to the output.
    pub(crate) fn close_chunk(&mut self) -> Result<(), McapError> {
        self.chunk = None;
        self.mcap.flush()
    }

    /// Writes the index and the end of the file, and gives the output back.
    pub(crate) fn finish(mut self) -> Result<W, McapError> {
        self.mcap.finish()?;
        let mut out = self.mcap.into_inner().into_inner();
        out.flush()?;
        Ok(out)
    }

    /// Writes a protobuf message at a simulated time, s.
    pub(crate) fn protobuf(
        &mut self,
        topic: Topic,
        time: f64,
        message: &impl prost::Message,
    ) -> Result<(), McapError> {
        let mut buffer = std::mem::take(&mut self.buffer);
        buffer.clear();
        message.encode_raw(&mut buffer);
        let result = self.put(topic, time, &buffer);
        self.buffer = buffer;
        result
    }

    /// Writes a JSON message at a simulated time, s.
    pub(crate) fn json(
        &mut self,
        topic: Topic,
        time: f64,
        message: &impl Serialize,
    ) -> Result<(), McapError> {
        let mut buffer = std::mem::take(&mut self.buffer);
        buffer.clear();
        serde_json::to_writer(&mut buffer, message).map_err(std::io::Error::from)?;
        let result = self.put(topic, time, &buffer);
        // After the text of a large program it is not kept at that size.
        buffer.clear();
        buffer.shrink_to(CHUNK_BYTES);
        self.buffer = buffer;
        result
    }

    /// Writes an encoded message at a simulated time, s.
    pub(crate) fn put(&mut self, topic: Topic, time: f64, data: &[u8]) -> Result<(), McapError> {
        self.write(topic.index(), time, data)
    }

    /// Writes a message of a custom topic at a simulated time, s. A topic that the file does not have is left out.
    pub(crate) fn put_extra(
        &mut self,
        topic: CustomTopicId,
        time: f64,
        data: &[u8],
    ) -> Result<(), McapError> {
        self.write(Topic::ALL.len().saturating_add(topic.0), time, data)
    }

    fn write(&mut self, channel: usize, time: f64, data: &[u8]) -> Result<(), McapError> {
        let Some(OpenChannel { id, sequence }) = self.channels.get_mut(channel) else {
            return Ok(());
        };
        let (channel_id, number) = (*id, *sequence);
        *sequence = number.wrapping_add(1);
        let size = data.len() + MESSAGE_OVERHEAD;
        if self.chunk.as_ref().is_some_and(|chunk| {
            chunk.bytes + size > CHUNK_BYTES || time - chunk.since >= CHUNK_SECS
        }) {
            self.close_chunk()?;
        }
        let chunks = &mut self.chunks;
        let chunk = self.chunk.get_or_insert_with(|| {
            *chunks += 1;
            OpenChunk {
                number: *chunks,
                bytes: 0,
                since: time,
            }
        });
        chunk.bytes += size;
        // NaN and negative times count as the start; `as` saturates.
        let log_time = self.epoch_ns.saturating_add((time * 1e9).round() as u64);
        let header = MessageHeader {
            channel_id,
            sequence: number,
            log_time,
            publish_time: log_time,
        };
        self.mcap.write_to_known_channel(&header, data)
    }
}
