//! What happens, in the recording: programs, lines, variables, messages. Then it is passed on to who is told besides.
//!
//! Called on the task's thread and on the pump thread. Under the virtual clock a program waits here for a recording
//! that does not keep up; nothing else waits.

use std::collections::BTreeMap;
use std::sync::Arc;

use elite_runtime::external::{ExternalInput, ExternalInputSink};
use elite_runtime::message::{Message, Observer, Severity};
use elite_runtime::panel::VariableValue;
use elite_syntax::TaskNode;
use messages::{Text, text};
use motion_api::{ProgramId, SnapshotCell, ThreadNumber};
use parking_lot::Mutex;
use recorder::lengths::{NAME_BYTES, SHORT_TEXT_BYTES, truncate_marked};
use recorder::{LogLevel, RecorderHandle};
use tokio::sync::broadcast;

use crate::external_topic;

/// What the log says when a program has ended.
pub const PROGRAM_ENDED: &str = "program ended";
/// Who says what no program says.
const CONTROLLER: &str = "controller";
/// How many lines of the log who follows it may be behind before some are missed.
const LINES_WAITING_MAX: usize = 1024;
/// Bytes of the text of such a line, so that all that wait have a bound; a longer one is cut with a mark.
pub const LOG_BYTES_MAX: usize = 16 * 1024;
/// Programs that can still say something.
const PROGRAMS_MAX: usize = 64;

/// One line of the log.
#[derive(Clone, Debug, PartialEq)]
pub struct LogLine {
    /// Simulated time, s.
    pub time: f64,
    /// Severity of the line.
    pub level: LogLevel,
    /// Program or part of the controller that writes the line.
    pub source: String,
    /// Text of the line.
    pub text: String,
}

/// The log of a controller, which can be followed at any time.
#[derive(Clone, Debug)]
pub struct LogLines(broadcast::Sender<LogLine>);

impl LogLines {
    /// Every line from now on. Who is too slow misses the oldest.
    pub fn subscribe(&self) -> broadcast::Receiver<LogLine> {
        self.0.subscribe()
    }
}

/// A program that was started.
struct KnownProgram {
    name: String,
    /// The beginning of its text, until it is known whether it runs: the recording has the whole text of those that do.
    beginning: Option<String>,
}

/// Records, and tells an observer.
pub(crate) struct RecordingObserver {
    recording: RecorderHandle,
    snapshot: Arc<SnapshotCell>,
    programs: Mutex<BTreeMap<ProgramId, KnownProgram>>,
    log_lines: broadcast::Sender<LogLine>,
    external: external_topic::ExternalWriter,
    observer: Arc<dyn Observer>,
}

impl RecordingObserver {
    /// What is recorded gets the simulated time of `snapshot`.
    pub(crate) fn new(
        recording: RecorderHandle,
        snapshot: Arc<SnapshotCell>,
        observer: Arc<dyn Observer>,
    ) -> Self {
        Self {
            recording,
            snapshot,
            programs: Mutex::default(),
            log_lines: broadcast::channel(LINES_WAITING_MAX).0,
            external: external_topic::ExternalWriter::default(),
            observer,
        }
    }

    /// The log, for whoever wants to follow it.
    pub(crate) fn log_lines(&self) -> LogLines {
        LogLines(self.log_lines.clone())
    }

    fn time(&self) -> f64 {
        self.snapshot.read().time
    }

    fn name_of(&self, program: ProgramId) -> String {
        let programs = self.programs.lock();
        let known = programs.get(&program);
        known.map_or_else(|| CONTROLLER.to_owned(), |known| known.name.clone())
    }

    fn log(&self, severity: Severity, program: ProgramId, text: &Text) {
        let level = match severity {
            Severity::Info => LogLevel::Info,
            Severity::Warning => LogLevel::Warning,
            Severity::Error => LogLevel::Error,
        };
        let (time, source) = (self.time(), self.name_of(program));
        self.recording.log(time, level, &source, text);
        if self.log_lines.receiver_count() > 0 {
            // That the last listener has gone in between is fine.
            let _ = self.log_lines.send(LogLine {
                time,
                level,
                source: short(&source, NAME_BYTES),
                text: short(text.english(), LOG_BYTES_MAX),
            });
        }
    }
}

impl ExternalInputSink for RecordingObserver {
    fn record(&self, external: &ExternalInput) {
        self.external.write(&self.recording, self.time(), external);
    }
}

fn short(text: &str, most: usize) -> String {
    truncate_marked(text, most).unwrap_or_else(|| text.to_owned())
}

impl Observer for RecordingObserver {
    fn next(&self) -> Option<&dyn Observer> {
        Some(&*self.observer)
    }

    fn message(&self, message: &Message) {
        // The observer's log comes first: whoever waits for the recording is told meanwhile.
        self.observer.message(message);
        match message {
            Message::Print { origin, text } => {
                let text = Text::verbatim(text.trim_end_matches('\n').to_owned());
                self.log(Severity::Info, origin.program, &text);
            }
            Message::Log {
                severity,
                origin,
                text,
            } => self.log(*severity, origin.program, text),
            Message::ScriptError {
                program, report, ..
            } => self.log(Severity::Error, *program, report),
            Message::Robot {
                origin,
                severity,
                text,
                ..
            } => {
                let text = match origin.line {
                    0 => text.clone(),
                    line => text!("{text} (line {line})", "{text}（第 {line} 行）"),
                };
                self.log(*severity, origin.program, &text);
            }
        }
    }

    fn program_started(&self, program: ProgramId, name: &str, text: &str) {
        {
            let mut programs = self.programs.lock();
            while programs.len() >= PROGRAMS_MAX {
                programs.pop_first();
            }
            let known = KnownProgram {
                name: name.to_owned(),
                beginning: Some(short(text, SHORT_TEXT_BYTES)),
            };
            programs.insert(program, known);
        }
        self.observer.program_started(program, name, text);
    }

    fn program_compiled(&self, program: ProgramId, text: &str) {
        if let Some(known) = self.programs.lock().get_mut(&program) {
            known.beginning = None;
        }
        self.recording
            .program_started(self.time(), program, &self.name_of(program), text);
        self.observer.program_compiled(program, text);
    }

    fn line_changed(
        &self,
        program: ProgramId,
        thread: ThreadNumber,
        line: u32,
        node: Option<&TaskNode>,
    ) {
        let named = node.map(|node| (node.number, &*node.label));
        self.recording
            .script_position(self.time(), (program, thread), line, named);
        self.observer.line_changed(program, thread, line, node);
    }

    fn variable_changed(&self, program: ProgramId, name: &str, value: &VariableValue) {
        let VariableValue {
            type_name,
            value: text,
        } = value;
        self.recording
            .variable(self.time(), program, name, type_name, text);
        self.observer.variable_changed(program, name, value);
    }

    fn program_ended(&self, program: ProgramId) {
        let beginning = {
            let mut programs = self.programs.lock();
            let known = programs.get_mut(&program);
            known.and_then(|known| known.beginning.take())
        };
        // The program did not compile: the log has the reason, and whoever sent the program has the whole text.
        if let Some(beginning) = beginning {
            let name = self.name_of(program);
            self.recording
                .program_started(self.time(), program, &name, &beginning);
        }
        self.log(
            Severity::Info,
            program,
            &Text::fixed(PROGRAM_ENDED, "程序结束"),
        );
        self.observer.program_ended(program);
    }

    fn release_backpressure(&self) {
        self.recording.suspend_backpressure();
        self.observer.release_backpressure();
    }
}
