//! Lines of interpreter mode: statements, command words and replies. Pure.
//!
//! A statement is one line, or a block whose header line ends with `:` (and holds no `;`) and which a line with `end`
//! closes: the manual knows single lines only, a vendor sample streams `def … end` blocks (manual 2; protocol:
//! neighbouring ports). Memory is bounded by [`LINE_BYTES_MAX`] and [`BLOCK_BYTES_MAX`].

use core::fmt;
use std::borrow::Cow;

use crate::ports::script_text::{StringTracker, is_end_line, statements_of_line};

/// The longest line, bytes.
pub const LINE_BYTES_MAX: usize = 64 * 1024;

/// The longest block, bytes.
pub const BLOCK_BYTES_MAX: usize = 1024 * 1024;

/// Of a statement that is not run, so much is repeated in the reply.
const REPEATED_CHARS: usize = 80;

/// A word that is carried out at once and never queued (manual 2.3 to 2.6).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InterpreterCommand {
    /// Skip everything received and not yet executed.
    SkipBuffer,
    /// Ask for the number of the statement that was executed last, or is being executed.
    StateLastExecuted,
    /// Ask for the number of the statement that was accepted last.
    StateLastInterpreted,
    /// Ask for the number of the statement that was cleared last.
    StateLastCleared,
    /// Ask how many statements wait.
    StateUnexecuted,
    /// Stop the running movej or movel.
    Abort,
}

impl InterpreterCommand {
    const ALL: [Self; 6] = [
        Self::SkipBuffer,
        Self::StateLastExecuted,
        Self::StateLastInterpreted,
        Self::StateLastCleared,
        Self::StateUnexecuted,
        Self::Abort,
    ];

    /// The word on the wire.
    pub const fn word(self) -> &'static str {
        match self {
            Self::SkipBuffer => "skipbuffer",
            Self::StateLastExecuted => "statelastexecuted",
            Self::StateLastInterpreted => "statelastinterpreted",
            Self::StateLastCleared => "statelastcleared",
            Self::StateUnexecuted => "stateunexecuted",
            Self::Abort => "abort",
        }
    }

    /// The command that a line is, if it is one.
    fn parse(line: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|c| c.word() == line.trim())
    }

    /// The reply. The manual prints a wrong word for `statelastcleared` (a copy of its neighbour's) and no reply for
    /// `skipbuffer` and `abort`; known clients read one line with a number after every command.
    pub fn reply(self, number: u64) -> String {
        format!("state: {number}: {}\n", self.word())
    }
}

/// A reason why a statement is not executed (manual 2.2).
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Discard {
    /// The statement does not compile, for this reason.
    Compile(String),
    /// No task runs.
    InvalidState,
    /// The queue is full.
    TooMany,
    /// The statement was thrown away when interpreter mode was entered.
    CleanedUp,
    /// The statement was thrown away when interpreter mode ended.
    CleanedUpAfterEnd,
    /// The statement was thrown away by `clear_interpreter()`.
    Cleared,
}

impl fmt::Display for Discard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // The blank at the end and the missing one after the colon are the manual's.
            Self::Compile(reason) => write!(f, "Compile error:{} ", one_line(reason)),
            Self::InvalidState => f.write_str("Task is in an invalid state"),
            Self::TooMany => f.write_str("Too many interpreted messages"),
            Self::CleanedUp => f.write_str("Cleaned up before interpretation"),
            Self::CleanedUpAfterEnd => f.write_str("Cleaned up after end"),
            Self::Cleared => f.write_str("Cleaned up"),
        }
    }
}

/// The reply to a statement that is queued under `id`.
pub fn ack(id: u64, statement: &str) -> String {
    format!("ack: {id}: {}\n", one_line(statement))
}

/// The reply to a statement that is not executed.
pub fn discard(reason: &Discard, statement: &str) -> String {
    format!("discard: {reason}: {}\n", one_line(statement))
}

/// A reply is one line: line breaks become blanks.
fn one_line(text: &str) -> String {
    text.trim().replace("\r\n", " ").replace(['\n', '\r'], " ")
}

/// A reason why something that a client sent is not even compiled.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StatementRejection {
    /// A line longer than [`LINE_BYTES_MAX`]; it is skipped to its end.
    LineTooLong {
        /// How it begins.
        start: String,
    },
    /// A block longer than [`BLOCK_BYTES_MAX`]; it is skipped to its end.
    BlockTooLong {
        /// How it begins.
        start: String,
    },
    /// The text is not UTF-8.
    NotUtf8 {
        /// The text with replacement characters.
        start: String,
    },
}

impl StatementRejection {
    /// The reply to the client.
    pub fn reply(&self) -> String {
        let (reason, start) = match self {
            Self::LineTooLong { start } => (
                format!("the line is longer than {} KiB", LINE_BYTES_MAX / 1024),
                start,
            ),
            Self::BlockTooLong { start } => (
                format!("the block is longer than {} KiB", BLOCK_BYTES_MAX / 1024),
                start,
            ),
            Self::NotUtf8 { start } => ("the text is not UTF-8".to_owned(), start),
        };
        discard(&Discard::Compile(reason), start)
    }
}

/// One thing a client sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StatementFrame {
    /// To be compiled and queued; without the newline at its end.
    Statement(String),
    /// A command to carry out at once.
    Command(InterpreterCommand),
    /// A rejection to report.
    Rejected(StatementRejection),
}

/// Cuts the bytes of one connection.
#[derive(Debug)]
pub struct StatementFramer {
    state: StatementFramerState,
    /// The statement so far, the unfinished line included.
    text: Vec<u8>,
    /// Index in `text` where the unfinished line begins.
    line_start: usize,
    /// Strings of the block up to the beginning of the unfinished line.
    strings: StringTracker,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum StatementFramerState {
    /// Between statements.
    Between,
    /// In a block whose header stands at this column, counted in bytes.
    Block { indent: usize },
    /// Within a block that is too long.
    SkippingBlock { indent: usize },
    /// In a line that is too long, reported already; then back to the state before.
    SkippingLine,
}

impl Default for StatementFramer {
    fn default() -> Self {
        Self {
            state: StatementFramerState::Between,
            text: Vec::new(),
            line_start: 0,
            strings: StringTracker::default(),
        }
    }
}

impl StatementFramer {
    /// Takes what was received and adds what is complete now to `frames`.
    pub fn push(&mut self, bytes: &[u8], frames: &mut Vec<StatementFrame>) {
        for piece in bytes.split_inclusive(|byte| *byte == b'\n') {
            self.append(piece, frames);
            if piece.ends_with(b"\n") {
                self.end_line(frames);
            }
        }
    }

    /// The client sends no more: what is unfinished is taken as it stands, and whoever compiles it decides.
    pub fn finish(&mut self, frames: &mut Vec<StatementFrame>) {
        if self.text.len() > self.line_start {
            self.push(b"\n", frames);
        }
        if let StatementFramerState::Block { .. } = self.state {
            self.emit(frames);
        }
    }

    /// True when nothing is unfinished.
    pub fn is_between(&self) -> bool {
        self.state == StatementFramerState::Between && self.text.is_empty()
    }

    fn append(&mut self, piece: &[u8], frames: &mut Vec<StatementFrame>) {
        if self.state == StatementFramerState::SkippingLine {
            return;
        }
        self.text.extend(piece);
        if self.text.len() - self.line_start > LINE_BYTES_MAX {
            self.skip_line(frames);
        }
    }

    /// The unfinished line is too long. In a block that ends the block as well: half of it is of no use.
    fn skip_line(&mut self, frames: &mut Vec<StatementFrame>) {
        let start = beginning(&self.text);
        match self.state {
            StatementFramerState::Block { indent } => {
                frames.push(StatementFrame::Rejected(StatementRejection::BlockTooLong {
                    start,
                }));
                self.skip_block(indent);
            }
            // Whatever the line is, an `end` it is not; a string that it opens is lost sight of.
            StatementFramerState::SkippingBlock { .. } => self.text.clear(),
            _ => {
                frames.push(StatementFrame::Rejected(StatementRejection::LineTooLong {
                    start,
                }));
                self.text = Vec::new();
                self.state = StatementFramerState::SkippingLine;
            }
        }
    }

    fn skip_block(&mut self, indent: usize) {
        self.text = self.text.split_off(self.line_start);
        self.text.truncate(LINE_BYTES_MAX);
        self.line_start = 0;
        self.state = StatementFramerState::SkippingBlock { indent };
    }

    fn end_line(&mut self, frames: &mut Vec<StatementFrame>) {
        match self.state {
            StatementFramerState::SkippingLine => self.state = StatementFramerState::Between,
            StatementFramerState::Between => self.end_line_between(frames),
            StatementFramerState::Block { indent } => {
                let ended = self.is_end_of_block(indent);
                self.follow_strings();
                self.line_start = self.text.len();
                if ended {
                    self.emit(frames);
                } else if self.text.len() > BLOCK_BYTES_MAX {
                    let start = beginning(&self.text);
                    frames.push(StatementFrame::Rejected(StatementRejection::BlockTooLong {
                        start,
                    }));
                    self.skip_block(indent);
                }
            }
            StatementFramerState::SkippingBlock { indent } => {
                let ended = self.is_end_of_block(indent);
                self.follow_strings();
                self.text.clear();
                if ended {
                    self.reset();
                }
            }
        }
    }

    fn end_line_between(&mut self, frames: &mut Vec<StatementFrame>) {
        if self.text.trim_ascii().is_empty() {
            self.text.clear();
            return;
        }
        let line = String::from_utf8_lossy(&self.text);
        if let Some(command) = InterpreterCommand::parse(&line) {
            frames.push(StatementFrame::Command(command));
            self.reset();
        } else if opens_block(&line) {
            let indent = line.len() - line.trim_start().len();
            self.follow_strings();
            self.line_start = self.text.len();
            self.state = StatementFramerState::Block { indent };
        } else {
            self.emit(frames);
        }
    }

    /// The finished line holds only `end`, not further right than the header, and not inside a string.
    fn is_end_of_block(&self, indent: usize) -> bool {
        let line = self.text[self.line_start..].trim_ascii_end();
        let code = line.trim_ascii_start();
        !self.strings.in_string() && line.len() - code.len() <= indent && is_end_line(code)
    }

    fn follow_strings(&mut self) {
        // A carriage return before the newline is not part of the line: a backslash there escapes the newline.
        for byte in self.text[self.line_start..].iter().filter(|b| **b != b'\r') {
            self.strings.feed(*byte);
        }
    }

    fn emit(&mut self, frames: &mut Vec<StatementFrame>) {
        let bytes = core::mem::take(&mut self.text);
        self.reset();
        frames.push(match String::from_utf8(bytes) {
            Ok(text) => StatementFrame::Statement(text.trim_end().replace("\r\n", "\n")),
            Err(error) => StatementFrame::Rejected(StatementRejection::NotUtf8 {
                start: beginning(error.as_bytes()),
            }),
        });
    }

    fn reset(&mut self) {
        *self = Self::default();
    }
}

/// What is executed for a statement: the statement, and for a `def` without parameters that came as a block of lines a
/// call of it. The manual (2.1) knows functions in one line only, which are defined and called later; the vendor's
/// sample streams `def a():`, a motion, `end` and relies on the motion, as such a block is a program on port 30001.
pub fn executed(statement: &str) -> Cow<'_, str> {
    let called = || {
        let (header, body) = statement.split_once('\n')?;
        let [header] = statements_of_line(header)[..] else {
            return None;
        };
        let (name, rest) = header.strip_prefix("def ")?.split_once('(')?;
        let rest = rest.trim_start().strip_prefix(')')?.trim_start();
        (!body.is_empty() && rest.strip_prefix(':')?.trim().is_empty()).then_some(name.trim())
    };
    match called() {
        Some(name) => Cow::Owned(format!("{statement}\n{name}()")),
        None => Cow::Borrowed(statement),
    }
}

/// A header whose body stands in the lines after it.
fn opens_block(line: &str) -> bool {
    match statements_of_line(line).as_slice() {
        [header] => header.trim_end().ends_with(':'),
        _ => false,
    }
}

fn beginning(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(4 * REPEATED_CHARS)]);
    let mut start: String = text.trim().chars().take(REPEATED_CHARS).collect();
    if bytes.len() > start.len() + 2 {
        start.push('…');
    }
    start
}

#[cfg(test)]
mod tests;
