//! Lines of interpreter mode: statements, command words and replies. Pure.
//!
//! A statement is one line, or a block whose header line ends with `:` (and holds no `;`) and which a line with `end`
//! closes: the manual knows single lines only, a vendor sample streams `def … end` blocks (manual 2; protocol:
//! neighbouring ports). Memory is bounded by [`LINE_BYTES_MAX`] and [`BLOCK_BYTES_MAX`].

use core::fmt;

use crate::ports::text::{StringTracker, begins_with_http_verb, is_end_line, statements_of_line};

/// The longest line, bytes.
pub const LINE_BYTES_MAX: usize = 64 * 1024;

/// The longest block, bytes.
pub const BLOCK_BYTES_MAX: usize = 1024 * 1024;

/// Of a statement that is not run, so much is repeated in the reply.
const REPEATED_CHARS: usize = 80;

/// A word that is carried out at once and never queued (manual 2.3 to 2.6).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Skip everything received and not yet executed.
    SkipBuffer,
    /// Which statement was executed last, or is being executed.
    StateLastExecuted,
    /// Which statement was accepted last.
    StateLastInterpreted,
    /// Which statement was cleared last.
    StateLastCleared,
    /// How many statements wait.
    StateUnexecuted,
    /// Stop the running movej or movel.
    Abort,
}

impl Command {
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

/// Why a statement is not executed (manual 2.2).
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Discard {
    /// It does not compile; with the reason.
    Compile(String),
    /// No task runs.
    InvalidState,
    /// The queue is full.
    TooMany,
    /// It was thrown away when interpreter mode was entered.
    CleanedUp,
}

impl fmt::Display for Discard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // The blank at the end and the missing one after the colon are the manual's.
            Self::Compile(reason) => write!(f, "Compile error:{} ", one_line(reason)),
            Self::InvalidState => f.write_str("Task is in an invalid state"),
            Self::TooMany => f.write_str("Too many interpreted messages"),
            Self::CleanedUp => f.write_str("Cleaned up before interpretation"),
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

/// Why something a client sent is not even compiled.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Rejection {
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
    /// Not UTF-8.
    NotUtf8 {
        /// The text with replacement characters.
        start: String,
    },
}

impl Rejection {
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
pub enum Frame {
    /// To be compiled and queued; without the newline at its end.
    Statement(String),
    /// To be carried out at once.
    Command(Command),
    /// To be reported.
    Rejected(Rejection),
    /// The connection speaks HTTP: close it.
    Http,
}

/// Cuts the bytes of one connection.
#[derive(Debug)]
pub struct Framer {
    state: State,
    /// The statement so far, the unfinished line included.
    text: Vec<u8>,
    /// Where the unfinished line begins in `text`.
    line_start: usize,
    /// Strings of the block up to the beginning of the unfinished line.
    strings: StringTracker,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// Nothing but blank lines so far: the connection may turn out to be HTTP.
    First,
    /// Between statements.
    Between,
    /// In a block whose header stands at this column, counted in bytes.
    Block { indent: usize },
    /// In a block that is too long.
    SkippingBlock { indent: usize },
    /// In a line that is too long, reported already; then back to the state before.
    SkippingLine,
    /// HTTP; nothing more is read.
    Closed,
}

impl Default for Framer {
    fn default() -> Self {
        Self {
            state: State::First,
            text: Vec::new(),
            line_start: 0,
            strings: StringTracker::default(),
        }
    }
}

impl Framer {
    /// Takes what was received and adds what is complete now to `frames`.
    pub fn push(&mut self, bytes: &[u8], frames: &mut Vec<Frame>) {
        for piece in bytes.split_inclusive(|byte| *byte == b'\n') {
            self.append(piece, frames);
            if piece.ends_with(b"\n") {
                self.end_line(frames);
            }
        }
    }

    /// The client sends no more: what is unfinished is taken as it stands, and whoever compiles it decides.
    pub fn finish(&mut self, frames: &mut Vec<Frame>) {
        if self.text.len() > self.line_start {
            self.push(b"\n", frames);
        }
        if let State::Block { .. } = self.state {
            self.emit(frames);
        }
    }

    fn append(&mut self, piece: &[u8], frames: &mut Vec<Frame>) {
        if matches!(self.state, State::Closed | State::SkippingLine) {
            return;
        }
        self.text.extend(piece);
        if self.state == State::First && begins_with_http_verb(&self.text) {
            self.text = Vec::new();
            self.state = State::Closed;
            frames.push(Frame::Http);
        } else if self.text.len() - self.line_start > LINE_BYTES_MAX {
            self.skip_line(frames);
        }
    }

    /// The unfinished line is too long. In a block that ends the block as well: half of it is of no use.
    fn skip_line(&mut self, frames: &mut Vec<Frame>) {
        let start = beginning(&self.text);
        match self.state {
            State::Block { indent } => {
                frames.push(Frame::Rejected(Rejection::BlockTooLong { start }));
                self.skip_block(indent);
            }
            // Whatever the line is, an `end` it is not; a string that it opens is lost sight of.
            State::SkippingBlock { .. } => self.text.clear(),
            _ => {
                frames.push(Frame::Rejected(Rejection::LineTooLong { start }));
                self.text = Vec::new();
                self.state = State::SkippingLine;
            }
        }
    }

    fn skip_block(&mut self, indent: usize) {
        self.text = self.text.split_off(self.line_start);
        self.text.truncate(LINE_BYTES_MAX);
        self.line_start = 0;
        self.state = State::SkippingBlock { indent };
    }

    fn end_line(&mut self, frames: &mut Vec<Frame>) {
        match self.state {
            State::Closed => {}
            State::SkippingLine => self.state = State::Between,
            State::First | State::Between => self.end_line_between(frames),
            State::Block { indent } => {
                let ended = self.is_end_of_block(indent);
                self.follow_strings();
                self.line_start = self.text.len();
                if ended {
                    self.emit(frames);
                } else if self.text.len() > BLOCK_BYTES_MAX {
                    let start = beginning(&self.text);
                    frames.push(Frame::Rejected(Rejection::BlockTooLong { start }));
                    self.skip_block(indent);
                }
            }
            State::SkippingBlock { indent } => {
                let ended = self.is_end_of_block(indent);
                self.follow_strings();
                self.text.clear();
                if ended {
                    self.reset();
                }
            }
        }
    }

    fn end_line_between(&mut self, frames: &mut Vec<Frame>) {
        if self.text.trim_ascii().is_empty() {
            self.text.clear();
            return;
        }
        self.state = State::Between;
        let line = String::from_utf8_lossy(&self.text);
        if let Some(command) = Command::parse(&line) {
            frames.push(Frame::Command(command));
            self.reset();
        } else if opens_block(&line) {
            let indent = line.len() - line.trim_start().len();
            self.follow_strings();
            self.line_start = self.text.len();
            self.state = State::Block { indent };
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

    fn emit(&mut self, frames: &mut Vec<Frame>) {
        let bytes = core::mem::take(&mut self.text);
        self.reset();
        frames.push(match String::from_utf8(bytes) {
            Ok(text) => Frame::Statement(text.trim_end().replace("\r\n", "\n")),
            Err(error) => Frame::Rejected(Rejection::NotUtf8 {
                start: beginning(error.as_bytes()),
            }),
        });
    }

    fn reset(&mut self) {
        *self = Self {
            state: State::Between,
            ..Self::default()
        };
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
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn frames_of(chunks: &[&[u8]]) -> Vec<Frame> {
        let mut framer = Framer::default();
        let mut frames = Vec::new();
        for chunk in chunks {
            framer.push(chunk, &mut frames);
        }
        framer.finish(&mut frames);
        frames
    }

    fn frames(text: &str) -> Vec<Frame> {
        frames_of(&[text.as_bytes()])
    }

    fn statement(text: &str) -> Frame {
        Frame::Statement(text.to_owned())
    }

    #[test]
    fn replies_are_those_of_the_manual() {
        assert_eq!(ack(3, "popup(\"a\")"), "ack: 3: popup(\"a\")\n");
        assert_eq!(
            discard(&Discard::InvalidState, "a()"),
            "discard: Task is in an invalid state: a()\n"
        );
        assert_eq!(
            discard(&Discard::TooMany, "a()"),
            "discard: Too many interpreted messages: a()\n"
        );
        assert_eq!(
            discard(&Discard::CleanedUp, "a()"),
            "discard: Cleaned up before interpretation: a()\n"
        );
        assert_eq!(
            discard(&Discard::Compile("line 1:\n  a(\n".to_owned()), "a("),
            "discard: Compile error:line 1:   a( : a(\n"
        );
        assert_eq!(ack(1, "def a():\n b()\nend"), "ack: 1: def a():  b() end\n");
    }

    #[test]
    fn every_command_is_answered_with_its_own_word() {
        for command in Command::ALL {
            let line = format!(" {}\r\n", command.word());
            assert_eq!(frames(&line), [Frame::Command(command)]);
            assert_eq!(command.reply(7), format!("state: 7: {}\n", command.word()));
        }
        assert_eq!(frames("abort()\n"), [statement("abort()")]);
    }

    #[test]
    fn a_line_is_a_statement_and_blank_lines_are_none() {
        assert_eq!(
            frames("\r\n \na()\r\n# said\n  b = 1; c()\nd()"),
            [
                statement("a()"),
                statement("# said"),
                statement("  b = 1; c()"),
                statement("d()")
            ]
        );
    }

    #[test]
    fn the_one_line_form_with_semicolons_is_one_statement() {
        let line = "def test_func():; textmsg(\"a\"); popup(\"b\");end;";
        assert_eq!(frames(&format!("{line}\n")), [statement(line)]);
        assert_eq!(
            frames("def f(): return 1\n"),
            [statement("def f(): return 1")]
        );
        assert_eq!(
            frames("d = {1: 2}\nx[1:]\n"),
            [statement("d = {1: 2}"), statement("x[1:]")]
        );
    }

    #[test]
    fn a_block_goes_to_its_end() {
        let sample = "def a():\n servoj([0], t=0.008)\nend";
        assert_eq!(
            frames(&format!("{sample}\na()\n")),
            [statement(sample), statement("a()")]
        );
        let nested = "def a(): # it's\n  if x:\n    b()\n  end\nend # a";
        assert_eq!(frames(&format!("{nested}\n")), [statement(nested)]);
        let strings = "while x:\n  s = '''\nend\n'''\nend";
        assert_eq!(frames(&format!("{strings}\n")), [statement(strings)]);
        let inside = "  if x:\n    a()\n  end";
        assert_eq!(
            frames(&format!("{inside}\nb()\n")),
            [statement(inside), statement("b()")]
        );
        assert_eq!(
            frames("if x:\r\n a()\r\nelse:\r\n b()\r\nend\r\n"),
            [statement("if x:\n a()\nelse:\n b()\nend")]
        );
        assert_eq!(frames("def a():\n b()"), [statement("def a():\n b()")]);
    }

    #[test]
    fn a_long_line_is_reported_once_and_skipped_to_its_end() {
        let long = "x".repeat(3 * LINE_BYTES_MAX);
        let found = frames(&format!("{long}\na()\n"));
        assert_eq!(found[1..], [statement("a()")]);
        let Frame::Rejected(rejection) = &found[0] else {
            panic!("{found:?}")
        };
        assert_eq!(
            rejection.reply(),
            format!(
                "discard: Compile error:the line is longer than 64 KiB : {}…\n",
                "x".repeat(80)
            )
        );
        let most = "x".repeat(LINE_BYTES_MAX - 1);
        assert_eq!(frames(&format!("{most}\n")), [statement(&most)]);
    }

    #[test]
    fn a_long_block_is_reported_once_and_skipped_to_its_end() {
        let body = " b('''\nend\n''')\n".repeat(BLOCK_BYTES_MAX / 8);
        let long_line = format!("# {}\n", "x".repeat(2 * LINE_BYTES_MAX));
        for block in [
            format!("def a():\n{body}end\n"),
            format!("def a():\n{long_line} c()\n end\n{long_line}end\n"),
        ] {
            let found = frames(&format!("{block}c()\n"));
            assert_eq!(found[1..], [statement("c()")]);
            let Frame::Rejected(rejection) = &found[0] else {
                panic!("{:?}", found[0])
            };
            assert!(rejection.reply().starts_with(
                "discard: Compile error:the block is longer than 1024 KiB : def a(): "
            ));
        }
    }

    #[test]
    fn what_is_no_text_is_reported() {
        let found = frames_of(&[b"a('\xff')\nb()\n"]);
        let start = "a('\u{FFFD}')".to_owned();
        assert_eq!(
            found,
            [
                Frame::Rejected(Rejection::NotUtf8 { start }),
                statement("b()")
            ]
        );
    }

    #[test]
    fn a_browser_is_recognised() {
        assert_eq!(frames_of(&[b"\nPO", b"ST", b" /\r\na()\n"]), [Frame::Http]);
        assert_eq!(
            frames("a()\nGET /\n"),
            [statement("a()"), statement("GET /")]
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 100, ..ProptestConfig::default() })]
        #[test]
        fn where_tcp_cuts_the_stream_does_not_matter(
            pieces in proptest::collection::vec(prop_oneof![
                Just("def a():\n"), Just("end\n"), Just(" end\r\n"), Just("'''"), Just("abort\n"), Just("x;"),
                Just("\n"), Just("\\"), Just("é"), Just(":\n"),
            ], 0..30),
            cut in 1usize..9,
        ) {
            let text = pieces.concat();
            let chunks: Vec<&[u8]> = text.as_bytes().chunks(cut).collect();
            prop_assert_eq!(frames_of(&chunks), frames(&text));
        }
    }
}
