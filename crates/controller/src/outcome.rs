//! How a program ended, in the words that tests, Python and sweeps share, and who notes it down.
//!
//! Owns the words, the result of a program and the [`ResultCollector`] that gathers what it said. Starts and stops
//! nothing: that is [`stepped`](crate::stepped)'s.

use core::fmt;
use std::sync::Arc;

use elite_runtime::TaskEnd;
use elite_runtime::message::{
    EMERGENCY_STOP_CODE, Message, Observer, PROTECTIVE_STOP_CODE, SCRIPT_ALARM_CODE, Severity,
};
use elite_syntax::TaskNode;
use messages::{Language, Text};
use motion_api::{CycleFrame, ProgramId, StopReason, ThreadNumber};
use parking_lot::Mutex;

use crate::peaks::Peaks;
use crate::program_position::PositionTracker;

/// Most that is kept of what one program prints, bytes; the rest is counted.
const PRINTS_BYTES_MAX: usize = 16 << 20;
/// Most that is kept of what one program writes to its log, bytes; a message counts as at least so many.
const MESSAGES_BYTES_MAX: usize = 4 << 20;
const MESSAGE_BYTES_MIN: usize = 32;
/// How the warning begins that tells the error of a secondary program.
const SECONDARY_EXCEPTION: &str = "[SEC] Exception: ";
/// Most that is kept of the reports of one program's errors, bytes.
const REPORT_BYTES_MAX: usize = 1 << 20;

/// How a program ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ProgramOutcome {
    /// The program ran to its end.
    Ended,
    /// The program does not compile, met an exception that it did not catch, or an alarm.
    Failed,
    /// Somebody stopped the program.
    Stopped,
    /// The arm went into a protective stop.
    ProtectiveStop,
    /// The arm went into an emergency stop.
    EmergencyStop,
    /// The program had not ended in the time it was given.
    Timeout,
}

impl ProgramOutcome {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Ended,
        Self::Failed,
        Self::Stopped,
        Self::ProtectiveStop,
        Self::EmergencyStop,
        Self::Timeout,
    ];

    /// The word for it.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Ended => "ended",
            Self::Failed => "failed",
            Self::Stopped => "stopped",
            Self::ProtectiveStop => "protective_stop",
            Self::EmergencyStop => "emergency_stop",
            Self::Timeout => "timeout",
        }
    }
}

impl fmt::Display for ProgramOutcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl From<&TaskEnd> for ProgramOutcome {
    fn from(end: &TaskEnd) -> Self {
        match end {
            TaskEnd::Finished => Self::Ended,
            TaskEnd::NotCompiled | TaskEnd::Failed => Self::Failed,
            TaskEnd::Stopped | TaskEnd::Replaced => Self::Stopped,
            TaskEnd::ProtectiveStop(StopReason::EmergencyStop) => Self::EmergencyStop,
            TaskEnd::ProtectiveStop(_) => Self::ProtectiveStop,
        }
    }
}

/// What became of a program.
#[derive(Clone, Debug, PartialEq)]
pub struct ProgramResult {
    /// How it ended.
    pub outcome: ProgramOutcome,
    /// `Type: message` of an exception, or the sentence of a stop, an alarm or a time-out.
    pub error: Option<Text>,
    /// The line of the error, from 1; of a stop or a time-out the line in which the main program stood.
    pub line: Option<u32>,
    /// Simulated time from its start until it had ended and the arm stood, s.
    pub time: f64,
    /// What it printed, a line each.
    pub prints: Vec<String>,
    /// The whole report of its errors: places, source lines, call stacks.
    pub report: Option<Text>,
}

/// Notes what the newest program says, and the peaks of every cycle since then; passes everything on.
pub struct ResultCollector {
    noted: Mutex<CollectedOutput>,
    follower: Arc<PositionTracker>,
    next: Arc<dyn Observer>,
}

#[derive(Default)]
struct CollectedOutput {
    prints: String,
    prints_lost: usize,
    messages: Vec<String>,
    messages_bytes: usize,
    messages_lost: usize,
    is_compiled: bool,
    error: Option<(Text, u32)>,
    report: Option<Text>,
    stop: Option<Text>,
    alarm: Option<Text>,
    line: u32,
    peaks: Peaks,
}

impl ResultCollector {
    /// Nothing noted yet; `next` is told everything as well.
    pub fn new(next: Arc<dyn Observer>) -> Self {
        Self {
            noted: Mutex::default(),
            follower: Arc::default(),
            next,
        }
    }

    /// Forgets what it noted: a program is about to start.
    pub fn begin(&self) {
        *self.noted.lock() = CollectedOutput::default();
    }

    /// What the program does, for conditions.
    pub const fn follower(&self) -> &Arc<PositionTracker> {
        &self.follower
    }

    /// Lines that were printed so far. A last line without its end is one, too.
    pub fn prints(&self) -> Vec<String> {
        let noted = self.noted.lock();
        let mut lines: Vec<String> = noted.prints.lines().map(str::to_owned).collect();
        if noted.prints_lost > 0 {
            lines.push(format!("[cut, {} bytes more]", noted.prints_lost));
        }
        lines
    }

    /// What the program has written to its log so far, as `textmsg` does: a text for each call.
    pub fn messages(&self) -> Vec<String> {
        let noted = self.noted.lock();
        let mut messages = noted.messages.clone();
        if noted.messages_lost > 0 {
            messages.push(format!("[cut, {} messages more]", noted.messages_lost));
        }
        messages
    }

    /// The first finding in the text of a program that did not compile, and its line; `None` once it has compiled.
    pub fn compile_error(&self) -> Option<(Text, u32)> {
        let noted = self.noted.lock();
        noted.error.clone().filter(|_| !noted.is_compiled)
    }

    /// The largest values since the program began.
    pub fn peaks(&self) -> Peaks {
        self.noted.lock().peaks
    }

    /// The line in which the main program was seen last, 0 before the first.
    pub fn line(&self) -> u32 {
        self.noted.lock().line
    }

    /// The result of a program with this outcome that took `time` simulated seconds; `given_up` says why it was ended,
    /// if it was because of a time-out.
    pub fn result(
        &self,
        outcome: ProgramOutcome,
        time: f64,
        given_up: Option<Text>,
    ) -> ProgramResult {
        let prints = self.prints();
        let noted = self.noted.lock();
        let stands_in = (noted.line > 0).then_some(noted.line);
        let raised = noted.error.clone();
        let (error, line) = match outcome {
            ProgramOutcome::Ended | ProgramOutcome::Stopped => (None, None),
            ProgramOutcome::Timeout => (given_up, stands_in),
            ProgramOutcome::ProtectiveStop | ProgramOutcome::EmergencyStop => {
                (noted.stop.clone(), stands_in)
            }
            ProgramOutcome::Failed => match raised {
                Some((error, line)) => (Some(error), Some(line)),
                None => (noted.alarm.clone(), stands_in),
            },
        };
        ProgramResult {
            outcome,
            error,
            line,
            time,
            prints,
            report: noted.report.clone(),
        }
    }
}

impl CollectedOutput {
    fn message(&mut self, message: &Message) {
        match message {
            Message::Print { text, .. } => {
                if self.prints_lost == 0 && self.prints.len() + text.len() <= PRINTS_BYTES_MAX {
                    self.prints.push_str(text);
                } else {
                    self.prints_lost += text.len();
                }
            }
            Message::ScriptError {
                line,
                summary,
                report,
                ..
            } => {
                self.error.get_or_insert_with(|| (summary.clone(), *line));
                self.report = match self.report.take() {
                    None => Some(report.clone()),
                    Some(known) if bytes(&known) + bytes(report) < REPORT_BYTES_MAX => {
                        Some(Text::joined([&known, report], "\n", "\n"))
                    }
                    known => known,
                };
            }
            Message::Robot {
                severity: Severity::Error,
                code,
                text,
                ..
            } => {
                let told = match *code {
                    PROTECTIVE_STOP_CODE | EMERGENCY_STOP_CODE => &mut self.stop,
                    SCRIPT_ALARM_CODE => &mut self.alarm,
                    _ => return,
                };
                told.get_or_insert_with(|| text.clone());
            }
            // A secondary program tells its errors as warnings.
            Message::Log {
                severity: Severity::Warning,
                origin,
                text,
            } if !self.is_compiled => {
                // The mark is that of the manual, in each language.
                let summary =
                    |language| text.in_language(language).strip_prefix(SECONDARY_EXCEPTION);
                if let (Some(english), Some(chinese)) =
                    (summary(Language::English), summary(Language::Chinese))
                {
                    let error = || {
                        (
                            Text::new(english.to_owned(), chinese.to_owned()),
                            origin.line,
                        )
                    };
                    self.error.get_or_insert_with(error);
                }
            }
            Message::Log {
                severity: Severity::Info,
                origin,
                text,
            } if origin.program != ProgramId::default() => {
                let bytes = bytes(text).max(MESSAGE_BYTES_MIN);
                if self.messages_lost == 0 && self.messages_bytes + bytes <= MESSAGES_BYTES_MAX {
                    self.messages_bytes += bytes;
                    self.messages.push(text.english().to_owned());
                } else {
                    self.messages_lost += 1;
                }
            }
            Message::Robot { .. } | Message::Log { .. } => {}
        }
    }
}

fn bytes(text: &Text) -> usize {
    text.english().len()
}

impl Observer for ResultCollector {
    fn next(&self) -> Option<&dyn Observer> {
        Some(&*self.next)
    }

    fn message(&self, message: &Message) {
        self.noted.lock().message(message);
        self.next.message(message);
    }

    fn program_started(&self, program: ProgramId, name: &str, text: &str) {
        self.follower.program_started(name);
        self.next.program_started(program, name, text);
    }

    fn program_compiled(&self, program: ProgramId, text: &str) {
        self.noted.lock().is_compiled = true;
        self.next.program_compiled(program, text);
    }

    fn line_changed(
        &self,
        program: ProgramId,
        thread: ThreadNumber,
        line: u32,
        node: Option<&TaskNode>,
    ) {
        if thread == ThreadNumber(0) {
            self.noted.lock().line = line;
        }
        self.follower.line_changed(thread, line);
        self.next.line_changed(program, thread, line, node);
    }

    fn program_ended(&self, program: ProgramId) {
        self.follower.program_ended();
        self.next.program_ended(program);
    }

    fn cycle_ended(&self, frame: &CycleFrame) {
        self.noted.lock().peaks.update(&frame.state);
        self.follower.cycle_ended(&frame.state);
        self.next.cycle_ended(frame);
    }
}

/// An observer that is told everything and keeps nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct NullObserver;

impl Observer for NullObserver {}
