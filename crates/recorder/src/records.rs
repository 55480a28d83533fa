//! The records of an MCAP file, one after the other, whatever the bytes are.
//!
//! Memory grows with the largest chunk, which is bounded, not with the file and not with what it says of itself: room
//! is made for bytes that are there. A chunk is all there or not there at all. Owns the frame of the format (lengths,
//! chunks, compression); what records mean is [`messages`](crate::messages)' business.

use std::io::{self, Read};

use mcap::McapError;
use mcap::records::{ChunkHeader, Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use messages::{Text, text};

use crate::files::MAX_RECORD_BYTES;
use crate::layout;
use crate::reader::FileEnd;

/// No record and no chunk of a recording is larger, packed or unpacked, but for the few bytes around a file: the text
/// of a program of 8 MiB is the largest thing, and JSON can make six bytes of one.
const MAX_BYTES: usize = 64 << 20;
/// Asked of the file at once.
const READ_BYTES: usize = 256 << 10;
/// What buffers keep between chunks.
const KEPT_BYTES: usize = 1 << 20;
/// Opcode and length of a record.
const HEAD_BYTES: usize = 1 + 8;

/// A file that is read from its start.
pub(crate) struct Records {
    source: Box<dyn Read>,
    reader: LinearReader,
    zstd: Option<zstd::bulk::Decompressor<'static>>,
    /// The unpacked chunk, or one record that stands outside of chunks, and how much of it was read.
    data: Vec<u8>,
    at: usize,
    in_chunk: bool,
    /// Whether attachments are among what says something.
    with_attachments: bool,
}

impl Records {
    pub fn new(source: Box<dyn Read>, with_attachments: bool) -> Self {
        let options = LinearReaderOptions::default()
            .with_emit_chunks(true)
            .with_record_length_limit(MAX_RECORD_BYTES);
        Self {
            source,
            reader: LinearReader::new_with_options(options),
            zstd: None,
            data: Vec::new(),
            at: 0,
            in_chunk: false,
            with_attachments,
        }
    }

    /// The next record that says something: its opcode and content. `None` at the end of a complete file; the error is
    /// any other end.
    pub fn next(&mut self) -> Result<Option<(u8, &[u8])>, FileEnd> {
        while self.at >= self.data.len() {
            if !self.load()? {
                return Ok(None);
            }
        }
        let (opcode, length) = head(&self.data[self.at..])?;
        let begin = self.at + HEAD_BYTES;
        let rest = self.data.len() - begin;
        let length = usize::try_from(length).ok().filter(|n| *n <= rest);
        let Some(length) = length else {
            return Err(damaged(text!(
                "a record is longer than the chunk it is in",
                "记录项比所在的块长"
            )));
        };
        if self.in_chunk && matches!(opcode, 0..=2 | op::CHUNK..=op::DATA_END) {
            return Err(damaged(text!(
                "a chunk holds a record of kind {opcode}, which has no place in a chunk",
                "块中有类型 {opcode} 的记录项，它不应在块中"
            )));
        }
        self.at = begin + length;
        Ok(Some((opcode, &self.data[begin..self.at])))
    }

    /// Reads until there is a chunk or another record of interest in `data`; false at the end of the file.
    fn load(&mut self) -> Result<bool, FileEnd> {
        self.at = 0;
        self.data.clear();
        self.data.shrink_to(KEPT_BYTES);
        loop {
            let Some(event) = self.reader.next_event() else {
                return Ok(false);
            };
            let (opcode, data) = match event.map_err(in_words)? {
                LinearReadEvent::ReadRequest(need) => {
                    // What a length promises is believed as far as bytes come.
                    let room = self.reader.insert(need.clamp(1, READ_BYTES));
                    let read = read_some(&mut self.source, room)
                        .map_err(|error| FileEnd::Damaged(Text::of(&error)))?;
                    self.reader.notify_read(read);
                    continue;
                }
                LinearReadEvent::Record { opcode, data } => (opcode, data),
            };
            match opcode {
                0 => {
                    return Err(damaged(text!(
                        "there is a record of kind 0",
                        "有类型为 0 的记录项"
                    )));
                }
                other if other != op::ATTACHMENT && data.len() > MAX_BYTES => {
                    return Err(too_large(text!("record", "记录项"), data.len() as u64));
                }
                op::ATTACHMENT if !self.with_attachments => {}
                op::CHUNK => {
                    self.in_chunk = true;
                    unpack(data, &mut self.zstd, &mut self.data)?;
                    return Ok(true);
                }
                op::HEADER
                | op::SCHEMA
                | op::CHANNEL
                | op::MESSAGE
                | op::METADATA
                | op::ATTACHMENT => {
                    self.in_chunk = false;
                    self.data.push(opcode);
                    self.data.extend((data.len() as u64).to_le_bytes());
                    self.data.extend(data);
                    return Ok(true);
                }
                // Indexes are for readers that seek; what later versions know is none of ours.
                _ => {}
            }
        }
    }
}

fn head(data: &[u8]) -> Result<(u8, u64), FileEnd> {
    let parts = data
        .split_first()
        .and_then(|(opcode, rest)| Some((*opcode, u64::from_le_bytes(*rest.first_chunk()?))));
    parts.ok_or_else(|| damaged(text!("a chunk ends within a record", "块在记录项中间结束")))
}

/// Unpacks a chunk and checks that it is what its header says.
fn unpack(
    record: &[u8],
    zstd: &mut Option<zstd::bulk::Decompressor<'static>>,
    out: &mut Vec<u8>,
) -> Result<(), FileEnd> {
    let Record::Chunk { header, data } = parse(op::CHUNK, record)? else {
        return Err(damaged(text!("a chunk has no header", "块没有头部")));
    };
    let ChunkHeader {
        uncompressed_size,
        uncompressed_crc,
        compression,
        ..
    } = header;
    let size = usize::try_from(uncompressed_size).unwrap_or(usize::MAX);
    if size > MAX_BYTES {
        return Err(too_large(text!("chunk", "块"), uncompressed_size));
    }
    let unpacked = match compression.as_str() {
        "" => {
            out.extend(&*data);
            Ok(())
        }
        "zstd" => {
            // Into room of the right size, so that no window as large as a frame likes is needed.
            out.reserve_exact(size);
            let zstd = match zstd {
                Some(zstd) => Ok(zstd),
                none => zstd::bulk::Decompressor::new().map(|new| none.insert(new)),
            };
            zstd.and_then(|zstd| zstd.decompress_to_buffer(&data, out))
                .map(drop)
        }
        "lz4" => lz4::Decoder::new(&*data).and_then(|frames| {
            let most = uncompressed_size.saturating_add(1);
            frames.take(most).read_to_end(out).map(drop)
        }),
        other => {
            let name: String = other.chars().take(16).collect();
            return Err(damaged(text!(
                "the compression {name:?} of a chunk is not known; zstd and lz4 are",
                "块的压缩方式 {name:?} 未知；可用 zstd 和 lz4"
            )));
        }
    };
    unpacked.map_err(|error| {
        damaged(text!(
            "a chunk cannot be unpacked: {error}",
            "无法解压块：{error}"
        ))
    })?;
    if out.len() != size {
        return Err(damaged(text!(
            "a chunk says that it has {size} bytes and has {}",
            "块声明有 {size} 字节，实际有 {}",
            if out.len() > size {
                text!("more", "更多")
            } else {
                Text::verbatim(out.len().to_string())
            }
        )));
    }
    if uncompressed_crc != 0 && crc32fast::hash(out) != uncompressed_crc {
        return Err(damaged(text!(
            "the checksum of a chunk is not that of its content",
            "块的校验和与内容不符"
        )));
    }
    Ok(())
}

/// What a record says. Lengths in it are looked at before they are believed.
pub(crate) fn parse(opcode: u8, record: &[u8]) -> Result<Record<'_>, FileEnd> {
    match layout::is_within_bounds(opcode, record) {
        true => mcap::parse_record(opcode, record).map_err(in_words),
        false => Err(damaged(text!(
            "a record of kind {opcode} ends within one of its texts",
            "类型 {opcode} 的记录项在文本中间结束"
        ))),
    }
}

pub(crate) fn damaged(reason: Text) -> FileEnd {
    FileEnd::Damaged(reason)
}

fn too_large(what: Text, bytes: u64) -> FileEnd {
    damaged(text!(
        "a {what} has {bytes} bytes; at most {MAX_BYTES} are read at once",
        "{what} 有 {bytes} 字节；一次最多读取 {MAX_BYTES} 字节"
    ))
}

/// The end that an error of the library means, in a sentence of one line.
pub(crate) fn in_words(error: McapError) -> FileEnd {
    match error {
        McapError::UnexpectedEof => FileEnd::Truncated,
        McapError::BadMagic => damaged(text!(
            "the eight bytes that begin and end an MCAP file are not there",
            "缺少 MCAP 文件首尾的八个字节"
        )),
        McapError::RecordTooLarge { len, .. } | McapError::ChunkTooLarge(len) => {
            too_large(text!("record", "记录项"), len)
        }
        McapError::Parse(_) => damaged(text!(
            "a record is not what its kind says",
            "记录项与其类型不符"
        )),
        other => {
            // Names from the file may be in it.
            let text: String = other.to_string().chars().take(200).collect();
            damaged(Text::verbatim(text.escape_debug().to_string()))
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
