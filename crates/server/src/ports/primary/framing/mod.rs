//! Bytes of a script client cut into programs and control phrases. Pure: knows no socket and no clock.
//!
//! There is no length and no terminator on this port; framing is by lines. Outside a block every line is a program of
//! its own. A line at column 0 that begins with `def ` or `sec ` opens a block, which a line that holds only `end`, not
//! indented, closes: inner `end`s are indented, and optional, so counting them cannot find the end of a program
//! (protocol: primary interface, framing; SDK `sendScript`; ROS driver). Memory is bounded by [`PROGRAM_BYTES_MAX`].

use core::fmt;

use crate::ports::script_text::{StringTracker, is_end_line, statements_of_line};

/// The longest program, bytes.
pub const PROGRAM_BYTES_MAX: usize = 8 * 1024 * 1024;

/// Of a line that is being skipped, this much is kept, to see whether it is an `end`.
const SKIPPED_LINE_BYTES: usize = 256;

/// What kind of program the text is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProgramKind {
    /// A `def` block.
    Main,
    /// A `sec` block.
    Secondary,
    /// One line outside a block.
    Line,
}

/// How the end of a program was recognised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProgramEnd {
    /// The last line of the program ends it.
    ItsText,
    /// The client sends no more.
    PeerClosed,
    /// Nothing came for a while, and the text is a whole program as it stands.
    Silence,
}

/// A program as received: lines end with `\n`, line 1 is its first line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReceivedProgram {
    /// The text.
    pub text: String,
    /// What it is.
    pub kind: ProgramKind,
    /// How its end was found.
    pub ended_by: ProgramEnd,
}

/// A plain line that is an order to the controller, not a statement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ControlPhrase {
    /// `stop task`; also `halt()` as a line of its own
    StopTask,
    /// `pause task`
    PauseTask,
    /// `resume task`: not seen in any client; the obvious counterpart of the two above.
    ResumeTask,
    /// `close popup`: our own; answers the newest popup where no pendant is at hand.
    ClosePopup,
    /// `power on`
    PowerOn,
    /// `power off`
    PowerOff,
    /// `set robotmode run`
    ReleaseBrakes,
    /// `set unlock protective stop`
    UnlockProtectiveStop,
    /// `restart safetyboard`
    RestartSafetyBoard,
    /// `set speed 0.50`: the speed slider, 0 to 1.
    SetSpeed(f64),
}

impl ControlPhrase {
    /// True for an order after which no program runs.
    pub const fn ends_programs(self) -> bool {
        matches!(self, Self::StopTask | Self::PowerOff)
    }

    /// True for an order that does not wait for what its client sent before it: it makes things stand still.
    pub const fn is_urgent(self) -> bool {
        self.ends_programs() || matches!(self, Self::PauseTask)
    }
}

/// A reason why something that a client sent is not run: one sentence for the client and the log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ScriptRejection {
    /// Longer than [`PROGRAM_BYTES_MAX`]; it is skipped to its end.
    TooLong,
    /// The waiting texts of this client leave no room for more.
    TooMuchWaits,
    /// A stop came behind programs that had not begun.
    Stopped {
        /// Number of programs that were not run.
        programs: usize,
    },
    /// The client sends no more, and its last block is open though it has blocks that are closed.
    CutOff {
        /// Number of lines that came.
        lines: usize,
    },
    /// The text is not UTF-8.
    NotUtf8 {
        /// Line of the program, from 1.
        line: usize,
        /// Column in bytes, from 1.
        column: usize,
    },
    /// `set speed` with something that is not 0 to 1.
    Speed {
        /// What was given.
        given: String,
    },
}

impl fmt::Display for ScriptRejection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLong => write!(
                f,
                "the program is longer than {} MiB; it is skipped to its end",
                PROGRAM_BYTES_MAX / (1024 * 1024)
            ),
            Self::TooMuchWaits => f.write_str(
                "RuntimeError: too many programs and orders of this client wait already, so some were refused",
            ),
            Self::Stopped { programs: 1 } => f.write_str(
                "RuntimeError: a program that waited for its turn was not run: a stop came behind it",
            ),
            Self::Stopped { programs } => write!(
                f,
                "RuntimeError: {programs} programs that waited for their turn were not run: a stop came behind them"
            ),
            Self::CutOff { lines } => write!(
                f,
                "RuntimeError: the connection ended inside a block: the text was cut off after line {lines}, so \
                 none of it runs"
            ),
            Self::NotUtf8 { .. } => f.write_str("the program is not UTF-8 text"),
            Self::Speed { given } => {
                write!(f, "`set speed` takes a number from 0 to 1, not `{given}`")
            }
        }
    }
}

/// One thing a client sent.
#[derive(Clone, Debug, PartialEq)]
pub enum ScriptFrame {
    /// A program to compile and run.
    Program(ReceivedProgram),
    /// An order to carry out at once.
    Control(ControlPhrase),
    /// A rejection to report.
    Rejected(ScriptRejection),
}

/// Cuts the bytes of one connection.
#[derive(Debug)]
pub struct ScriptFramer {
    state: ProgramFramerState,
    /// The program so far, the unfinished line included. When skipping: the beginning of the unfinished line.
    text: Vec<u8>,
    /// Index in `text` where the unfinished line begins.
    line_start: usize,
    /// Strings of the block up to the last byte received.
    strings: StringTracker,
    /// The unfinished line began inside a string of the block.
    line_in_string: bool,
    limit: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ProgramFramerState {
    /// Between programs.
    Between,
    /// Within a block.
    Block(ProgramKind),
    /// Within a block or a line that is too long.
    Skipping { block: bool },
}

impl Default for ScriptFramer {
    fn default() -> Self {
        Self::with_limit(PROGRAM_BYTES_MAX)
    }
}

impl ScriptFramer {
    /// A framer for programs of at most `limit` bytes.
    pub fn with_limit(limit: usize) -> Self {
        Self {
            state: ProgramFramerState::Between,
            text: Vec::new(),
            line_start: 0,
            strings: StringTracker::default(),
            line_in_string: false,
            limit,
        }
    }

    /// Takes what was received and adds what is complete now to `frames`. Holds at most the limit and one such piece.
    pub fn push(&mut self, bytes: &[u8], frames: &mut Vec<ScriptFrame>) {
        for piece in bytes.split_inclusive(|byte| *byte == b'\n') {
            self.append(piece, frames);
            if piece.ends_with(b"\n") {
                self.end_line(ProgramEnd::ItsText, frames);
            }
        }
    }

    /// What the unfinished program takes, bytes.
    pub const fn bytes(&self) -> usize {
        self.text.capacity()
    }

    /// True while something is unfinished: a block, or a line without its end.
    pub fn is_open(&self) -> bool {
        match self.state {
            ProgramFramerState::Block(_) => true,
            ProgramFramerState::Between => !is_nothing(&self.text),
            ProgramFramerState::Skipping { .. } => false,
        }
    }

    /// The unfinished program, if it is text.
    pub fn open_text(&self) -> Option<&str> {
        core::str::from_utf8(&self.text)
            .ok()
            .filter(|_| self.is_open())
    }

    /// Gives the unfinished program up for lack of room: it is reported and skipped to its end. What is still short
    /// stays: it may be an order.
    pub fn give_up(&mut self, frames: &mut Vec<ScriptFrame>) {
        if self.is_open() && self.text.len() > SKIPPED_LINE_BYTES {
            frames.push(ScriptFrame::Rejected(ScriptRejection::TooMuchWaits));
            self.skip_the_rest(&[]);
        }
    }

    /// Ends what is unfinished, if anything is.
    pub fn finish(&mut self, ended_by: ProgramEnd, frames: &mut Vec<ScriptFrame>) {
        if self.is_open() && !self.text.ends_with(b"\n") {
            self.append(b"\n", frames);
            self.end_line(ended_by, frames);
        }
        if let ProgramFramerState::Block(kind) = self.state {
            if ended_by == ProgramEnd::PeerClosed && closes_blocks(&self.text) {
                let lines = self.text.iter().filter(|byte| **byte == b'\n').count();
                frames.push(ScriptFrame::Rejected(ScriptRejection::CutOff { lines }));
                self.reset();
            } else {
                self.emit(kind, ended_by, frames);
            }
        }
    }

    /// Adds a piece of the unfinished line.
    fn append(&mut self, piece: &[u8], frames: &mut Vec<ScriptFrame>) {
        match self.state {
            ProgramFramerState::Skipping { block } => {
                let room = SKIPPED_LINE_BYTES.saturating_sub(self.text.len());
                self.text.extend(piece.iter().take(room));
                if block {
                    self.follow_strings(piece);
                }
                return;
            }
            ProgramFramerState::Block(_) => self.follow_strings(piece),
            ProgramFramerState::Between => {}
        }
        let too_much = self.hold(piece);
        if self.text.len() > self.limit {
            frames.push(ScriptFrame::Rejected(ScriptRejection::TooLong));
            self.skip_the_rest(too_much);
        }
    }

    /// Adds to the text, of what is too long only so much that it is seen to be and how its last line begins. Room
    /// grows as that of any vector, but not beyond what can be used.
    /// Gives back what is too much.
    fn hold<'p>(&mut self, piece: &'p [u8]) -> &'p [u8] {
        let most = self.limit + 1 + SKIPPED_LINE_BYTES;
        let fits = most.saturating_sub(self.text.len()).min(piece.len());
        let (piece, too_much) = piece.split_at(fits);
        let (length, room) = (self.text.len(), self.text.capacity());
        if room - length < piece.len() {
            let wanted = (2 * room).max(length + piece.len()).min(most);
            self.text.reserve_exact(wanted - length);
        }
        self.text.extend_from_slice(piece);
        too_much
    }

    /// Begins to skip; `too_much` is what was received beyond the text.
    fn skip_the_rest(&mut self, too_much: &[u8]) {
        let block = match self.state {
            ProgramFramerState::Block(_) => true,
            // A header alone longer than the limit: its block is as unwanted as it is.
            _ => {
                let header = block_opened_by(&self.text).is_some();
                if header {
                    let line = core::mem::take(&mut self.text);
                    self.follow_strings(&line);
                    self.follow_strings(too_much);
                    self.text = line;
                }
                header
            }
        };
        let line = &self.text[self.line_start..];
        self.text = line[..line.len().min(SKIPPED_LINE_BYTES)].to_vec();
        self.line_start = 0;
        self.state = ProgramFramerState::Skipping { block };
    }

    fn end_line(&mut self, ended_by: ProgramEnd, frames: &mut Vec<ScriptFrame>) {
        match self.state {
            ProgramFramerState::Skipping { block } => {
                let ended = !block || (is_end_line(trim_line(&self.text)) && !self.line_in_string);
                self.text.clear();
                self.line_in_string = self.strings.in_string();
                if ended {
                    self.reset();
                }
            }
            ProgramFramerState::Block(kind) => {
                drop_carriage_return(&mut self.text);
                let line = trim_line(&self.text[self.line_start..]);
                if is_end_line(line) && !self.line_in_string {
                    self.emit(kind, ended_by, frames);
                } else {
                    self.line_start = self.text.len();
                    self.line_in_string = self.strings.in_string();
                }
            }
            ProgramFramerState::Between => self.end_line_between(ended_by, frames),
        }
    }

    /// A whole line outside a block: nothing, an order, a header or a program of its own.
    fn end_line_between(&mut self, ended_by: ProgramEnd, frames: &mut Vec<ScriptFrame>) {
        drop_carriage_return(&mut self.text);
        if let Some(without_mark) = self.text.strip_prefix(b"\xEF\xBB\xBF") {
            self.text = without_mark.to_vec();
        }
        if is_nothing(&self.text) {
            self.text.clear();
            return;
        }
        if let Some(frame) = control_phrase(&self.text) {
            frames.push(frame);
            self.reset();
        } else if let Some(kind) = block_opened_by(&self.text) {
            let line = core::mem::take(&mut self.text);
            self.follow_strings(&line);
            self.text = line;
            if ends_on_its_own_line(&self.text) {
                self.emit(kind, ended_by, frames);
            } else {
                self.state = ProgramFramerState::Block(kind);
                self.line_start = self.text.len();
                self.line_in_string = self.strings.in_string();
            }
        } else {
            // Blanks before a line on its own open nothing.
            let blanks = self.text.len() - self.text.trim_ascii_start().len();
            self.text.drain(..blanks);
            self.emit(ProgramKind::Line, ended_by, frames);
        }
    }

    fn follow_strings(&mut self, piece: &[u8]) {
        // A carriage return before the newline is not part of the line: a backslash there escapes the newline.
        for byte in piece.iter().filter(|byte| **byte != b'\r') {
            self.strings.feed(*byte);
        }
    }

    fn emit(&mut self, kind: ProgramKind, ended_by: ProgramEnd, frames: &mut Vec<ScriptFrame>) {
        let bytes = core::mem::take(&mut self.text);
        self.reset();
        frames.push(match String::from_utf8(bytes) {
            Ok(text) => ScriptFrame::Program(ReceivedProgram {
                text,
                kind,
                ended_by,
            }),
            Err(error) => {
                let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
                let line_start = valid
                    .iter()
                    .rposition(|b| *b == b'\n')
                    .map_or(0, |at| at + 1);
                ScriptFrame::Rejected(ScriptRejection::NotUtf8 {
                    line: 1 + valid.iter().filter(|b| **b == b'\n').count(),
                    column: 1 + valid.len() - line_start,
                })
            }
        });
    }

    fn reset(&mut self) {
        *self = Self::with_limit(self.limit);
    }
}

/// Some block in the text has its `end`: whoever writes one writes them all. An `end` in a text of several lines may be
/// taken for one; a program with such a text that has no `end` of its own is rare.
fn closes_blocks(text: &[u8]) -> bool {
    let mut lines = text.split(|byte| *byte == b'\n');
    lines.any(|line| is_end_line(line.trim_ascii_start()))
}

/// Blank, a comment alone, or a directive of the pendant, which says nothing without a program around it.
fn is_nothing(line: &[u8]) -> bool {
    let line = line.trim_ascii_start();
    match line.first() {
        None | Some(b'#') => true,
        Some(b'$') => line[1..].trim_ascii_start().starts_with(b"LINE"),
        Some(_) => false,
    }
}

/// Without the newline at the end.
fn trim_line(line: &[u8]) -> &[u8] {
    line.strip_suffix(b"\n").unwrap_or(line)
}

/// Turns `\r\n` at the end into `\n`.
fn drop_carriage_return(text: &mut Vec<u8>) {
    if text.ends_with(b"\r\n") {
        text.truncate(text.len() - 2);
        text.push(b'\n');
    }
}

/// What a line at column 0 opens, if it opens a block. `sec` is an ordinary name unless a function header follows it;
/// `def` is a word of the language.
fn block_opened_by(line: &[u8]) -> Option<ProgramKind> {
    let after = |word: &[u8]| {
        line.strip_prefix(word)
            .filter(|rest| rest.first().is_some_and(|b| matches!(b, b' ' | b'\t')))
            .map(<[u8]>::trim_ascii_start)
    };
    if after(b"def").is_some() {
        return Some(ProgramKind::Main);
    }
    let header = after(b"sec")?;
    let name = header
        .iter()
        .take_while(|b| b.is_ascii_alphanumeric() || **b == b'_' || **b >= 0x80)
        .count();
    let parameters = header[name..].trim_ascii_start().first() == Some(&b'(');
    (name > 0 && parameters).then_some(ProgramKind::Secondary)
}

/// A block on one line, `def f():; a(); end;` (manual 2.1.1): some part ends with `:`, the last one is `end`.
fn ends_on_its_own_line(line: &[u8]) -> bool {
    let line = String::from_utf8_lossy(trim_line(line));
    let parts = statements_of_line(&line);
    let mut filled = parts
        .iter()
        .map(|part| part.trim())
        .filter(|part| !part.is_empty());
    filled.next_back() == Some("end") && filled.any(|part| part.ends_with(':'))
}

/// The order that a line is, if it is one.
fn control_phrase(line: &[u8]) -> Option<ScriptFrame> {
    let line = core::str::from_utf8(line).ok()?;
    let words: Vec<&str> = line.split_whitespace().collect();
    let phrase = match words.as_slice() {
        // These lines are orders, because they would take the place of the program they are to end if they ran as a
        // program of their own.
        ["stop", "task"] | ["halt()"] => ControlPhrase::StopTask,
        ["close", "popup"] => ControlPhrase::ClosePopup,
        ["pause", "task"] => ControlPhrase::PauseTask,
        ["resume", "task"] => ControlPhrase::ResumeTask,
        ["power", "on"] => ControlPhrase::PowerOn,
        ["power", "off"] => ControlPhrase::PowerOff,
        ["set", "robotmode", "run"] => ControlPhrase::ReleaseBrakes,
        ["set", "unlock", "protective", "stop"] => ControlPhrase::UnlockProtectiveStop,
        ["restart", "safetyboard"] => ControlPhrase::RestartSafetyBoard,
        ["set", "speed", given] => match given.parse() {
            Ok(fraction) if (0.0..=1.0).contains(&fraction) => ControlPhrase::SetSpeed(fraction),
            _ => {
                let given = given.chars().take(40).collect();
                return Some(ScriptFrame::Rejected(ScriptRejection::Speed { given }));
            }
        },
        _ => return None,
    };
    Some(ScriptFrame::Control(phrase))
}

#[cfg(test)]
mod tests;
