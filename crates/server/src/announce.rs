//! Carries what happens to everybody who wants to know: the log on stderr, standard output, the ports, the recording.
//!
//! Called on the task's thread and on the pump thread; nothing here waits. A port that is too slow misses messages.

use std::collections::BTreeMap;
use std::io::Write;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use elite_runtime::message::{
    EMERGENCY_STOP_CODE, InterpreterEvent, Message, Observer, PROTECTIVE_STOP_CODE,
    RECORDING_ALARM_CODE, Severity,
};
use elite_runtime::panel::VariableValue;
use motion_api::{Frame, ProgramId, SnapshotCell, ThreadNumber};
use recorder::{LogLevel, RecorderHandle};
use tokio::sync::broadcast;

use crate::feed::Feed;
use crate::log_dir::InterpreterLog;
use crate::ports::foxglove::LogLine;
use crate::replay::script;

/// How many messages a port may be behind before it misses some.
const BACKLOG: usize = 1024;

/// Kinds of errors that are counted.
pub const ERROR_KINDS: [&str; 5] = ["script", "stop", "alarm", "recording", "other"];

/// Where the `print` of programs goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Console {
    /// To standard output, and script errors bare to standard error: `run`.
    Stdout,
    /// To the log: `serve`.
    Log,
}

/// Tells everybody.
pub struct Announcer {
    ports: broadcast::Sender<Message>,
    log_lines: broadcast::Sender<LogLine>,
    recording: RecorderHandle,
    snapshot: Arc<SnapshotCell>,
    console: Console,
    feed: Arc<Feed>,
    names: Mutex<BTreeMap<ProgramId, String>>,
    errors: [AtomicU64; ERROR_KINDS.len()],
    interpreter_log: InterpreterLog,
}

impl Announcer {
    /// Messages get the simulated time of `snapshot`.
    pub fn new(
        recording: RecorderHandle,
        snapshot: Arc<SnapshotCell>,
        console: Console,
        interpreter_log: InterpreterLog,
        feed: Arc<Feed>,
    ) -> Self {
        Self {
            ports: broadcast::channel(BACKLOG).0,
            log_lines: broadcast::channel(BACKLOG).0,
            recording,
            snapshot,
            console,
            feed,
            names: Mutex::default(),
            errors: Default::default(),
            interpreter_log,
        }
    }

    /// Follows the messages from now on.
    pub fn subscribe(&self) -> broadcast::Receiver<Message> {
        self.ports.subscribe()
    }

    /// How many errors of each kind there were.
    pub fn errors(&self) -> [(&'static str, u64); ERROR_KINDS.len()] {
        core::array::from_fn(|i| (ERROR_KINDS[i], self.errors[i].load(Ordering::Relaxed)))
    }

    fn count(&self, message: &Message) {
        let kind = match message {
            Message::ScriptError { .. } => 0,
            Message::Robot { severity, code, .. } if *severity == Severity::Error => match *code {
                PROTECTIVE_STOP_CODE | EMERGENCY_STOP_CODE => 1,
                RECORDING_ALARM_CODE => 3,
                _ => 2,
            },
            Message::Log {
                severity: Severity::Error,
                ..
            } => 4,
            _ => return,
        };
        self.errors[kind].fetch_add(1, Ordering::Relaxed);
    }

    /// Follows what `/log` of the recording gets, from now on.
    pub fn subscribe_log(&self) -> broadcast::Receiver<LogLine> {
        self.log_lines.subscribe()
    }

    fn time(&self) -> f64 {
        self.snapshot.read().time
    }

    fn name_of(&self, program: ProgramId) -> String {
        let names = self.names.lock().unwrap_or_else(PoisonError::into_inner);
        names
            .get(&program)
            .cloned()
            .unwrap_or_else(|| "controller".to_owned())
    }

    fn record(&self, severity: Severity, source: &str, text: &str) {
        let level = match severity {
            Severity::Info => LogLevel::Info,
            Severity::Warning => LogLevel::Warning,
            Severity::Error => LogLevel::Error,
        };
        let time = self.time();
        self.recording.log(time, level, source, text);
        if self.log_lines.receiver_count() > 0 {
            // That the last listener has gone in between is fine.
            let _ = self.log_lines.send(LogLine {
                time,
                level,
                source: source.to_owned(),
                text: text.to_owned(),
            });
        }
    }

    fn log(&self, severity: Severity, program: ProgramId, text: &str) {
        let source = self.name_of(program);
        match severity {
            Severity::Info => tracing::info!(target: "script", program = %source, "{text}"),
            Severity::Warning => tracing::warn!(target: "script", program = %source, "{text}"),
            Severity::Error => tracing::error!(target: "script", program = %source, "{text}"),
        }
        self.record(severity, &source, text);
    }
}

impl Observer for Announcer {
    fn message(&self, message: &Message) {
        self.count(message);
        match message {
            Message::Print { origin, text } if self.console == Console::Stdout => {
                // Nothing sensible is left to do when standard output is gone.
                let _ = std::io::stdout().write_all(text.as_bytes());
                self.record(
                    Severity::Info,
                    &self.name_of(origin.program),
                    text.trim_end_matches('\n'),
                );
            }
            Message::Print { origin, text } => {
                self.log(Severity::Info, origin.program, text.trim_end_matches('\n'));
            }
            Message::Log {
                severity,
                origin,
                text,
            } => self.log(*severity, origin.program, text),
            Message::ScriptError {
                program, report, ..
            } => {
                // The report has lines of its own; a log prefix would push the caret out of place.
                if self.console == Console::Stdout {
                    eprintln!("{}", report.trim_end());
                } else {
                    tracing::error!(target: "script", program = %self.name_of(*program), "\n{}", report.trim_end());
                }
                self.record(Severity::Error, &self.name_of(*program), report);
            }
            Message::Robot { severity, text, .. } => {
                self.log(*severity, ProgramId::default(), text)
            }
        }
        // Nobody listening is fine.
        let _ = self.ports.send(message.clone());
    }

    fn program_started(&self, program: ProgramId, name: &str, text: &str) {
        let mut names = self.names.lock().unwrap_or_else(PoisonError::into_inner);
        // Only the newest programs can still say something.
        while names.len() >= 64 {
            names.pop_first();
        }
        names.insert(program, name.to_owned());
        drop(names);
        self.recording
            .program_started(self.time(), program, name, text);
    }

    fn line_changed(&self, program: ProgramId, thread: ThreadNumber, line: u32) {
        self.recording
            .script_line(self.time(), program, thread, line);
        self.feed.line_changed(thread, line);
    }

    fn variable_changed(&self, program: ProgramId, name: &str, value: &VariableValue) {
        let VariableValue { type_name, value } = value;
        self.recording
            .variable(self.time(), program, name, type_name, value);
    }

    fn interpreter(&self, event: &InterpreterEvent<'_>) {
        self.interpreter_log.executing(event);
    }

    fn program_ended(&self, program: ProgramId) {
        let name = self.name_of(program);
        tracing::debug!(target: "script", program = %name, "ended");
        self.record(Severity::Info, &name, script::ENDED);
        self.feed.program_ended();
        let _ = std::io::stdout().flush();
    }

    fn cycle_ended(&self, frame: &Frame) {
        self.feed.cycle_ended(frame);
    }
}
