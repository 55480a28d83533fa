//! Reasons why a recording cannot be read.

use std::io;

use thiserror::Error;

use crate::setup::SetupError;

/// A reason why a recording cannot be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file cannot be opened or read.
    #[error("cannot read {path}: {source}")]
    Io {
        /// The file.
        path: String,
        /// Error of the operating system.
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
    /// An MCAP file that is damaged before its first cycle.
    #[error("{path} is damaged: {reason}")]
    Damaged {
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
    /// A file of the cell is lost or damaged.
    #[error("{path}: the recording lacks the file {file:?} of its cell")]
    CellFile {
        /// The recording.
        path: String,
        /// The file, as the cell file names it.
        file: String,
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
        /// The topics of the file.
        known: String,
    },
    /// A topic's schema cannot be used.
    #[error("the schema of {topic} cannot be used: {reason}")]
    Schema {
        /// The topic.
        topic: String,
        /// What is wrong with the schema.
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
