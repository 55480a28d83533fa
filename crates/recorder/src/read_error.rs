//! Reasons why a recording cannot be read.

use std::io;

use messages::{Localized, Text};
use thiserror::Error;

use crate::setup::SetupError;

/// A reason why a recording cannot be read.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum ReadError {
    /// The file cannot be opened or read.
    #[error("cannot read {path}: {source}")]
    #[zh("无法读取 {path}：{source}")]
    Io {
        /// The file.
        path: String,
        /// Error of the operating system.
        source: io::Error,
    },
    /// Not an MCAP file.
    #[error("{path} is not an MCAP file: {reason}")]
    #[zh("{path} 不是 MCAP 文件：{reason}")]
    NotMcap {
        /// The file.
        path: String,
        /// What is wrong.
        reason: Text,
    },
    /// An MCAP file that is damaged before its first cycle.
    #[error("{path} is damaged: {reason}")]
    #[zh("{path} 已损坏：{reason}")]
    Damaged {
        /// The file.
        path: String,
        /// What is wrong.
        reason: Text,
    },
    /// An MCAP file without the topic of the cycles.
    #[error("{path} is not a recording of eliteserver: it has no topic /cycle")]
    #[zh("{path} 不是 eliteserver 的记录：没有主题 /cycle")]
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
    /// A file of the cell is lost or damaged.
    #[error("{path}: the recording lacks the file {file:?} of its cell")]
    #[zh("{path}：记录中缺少其单元的文件 {file:?}")]
    CellFile {
        /// The recording.
        path: String,
        /// The file, as the cell file names it.
        file: String,
    },
    /// A message is not what its topic says.
    #[error("message {number} of {topic} cannot be decoded: {reason}")]
    #[zh("无法解码 {topic} 的第 {number} 条消息：{reason}")]
    Message {
        /// The topic.
        topic: String,
        /// Number of the message in its topic, from 1.
        number: u64,
        /// What is wrong.
        reason: Text,
    },
    /// There is no such topic in the file.
    #[error("there is no topic {topic} in the recording; it has {known}")]
    #[zh("记录中没有主题 {topic}；有 {known}")]
    NoTopic {
        /// The topic asked for.
        topic: String,
        /// The topics of the file.
        known: Text,
    },
    /// A topic's schema cannot be used.
    #[error("the schema of {topic} cannot be used: {reason}")]
    #[zh("无法使用 {topic} 的结构定义：{reason}")]
    Schema {
        /// The topic.
        topic: String,
        /// What is wrong with the schema.
        reason: Text,
    },
    /// A message has more values than a table may have columns.
    #[error("{topic} has more than {limit} columns")]
    #[zh("{topic} 超过 {limit} 列")]
    TooWide {
        /// The topic.
        topic: String,
        /// The largest number of columns.
        limit: usize,
    },
}
