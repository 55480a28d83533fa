//! Carries what happens to everybody who wants to know: the log on stderr, standard output, the ports. The recording
//! has it from the controller itself.
//!
//! Called on the task's thread and on the pump thread; nothing here waits. A port that is too slow misses messages.

use std::collections::BTreeMap;
use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use elite_runtime::message::{
    EMERGENCY_STOP_CODE, InterpreterEvent, Message, Observer, PROTECTIVE_STOP_CODE,
    RECORDING_ALARM_CODE, REPLACED, Severity,
};
use elite_runtime::panel::VariableValue;
use elite_syntax::TaskNode;
use messages::{Text, text};
use motion_api::{CycleFrame, Origin, ProgramId, ThreadNumber};
use parking_lot::Mutex;
use recorder::lengths::truncate_marked;
use tokio::sync::broadcast;
use tracing::Span;

use crate::language;
use crate::log_dir::InterpreterLog;
use crate::logging;
use crate::ports::http::page::ShownProgram;
use crate::sample_feed::SampleFeed;
use wire::primary::exception::TEXT_BYTES_MAX;

/// How many messages a port may be behind before it misses some.
const BACKLOG: usize = 1024;

/// Longest text of such a message, bytes, so that all that wait have a bound; what is longer is cut with a mark.
const PORT_TEXT_BYTES: usize = TEXT_BYTES_MAX;

/// Kinds of errors that are counted.
pub const ERROR_KINDS: [&str; 5] = ["script", "stop", "alarm", "recording", "other"];

/// Target of what programs `print`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PrintTarget {
    /// To standard output, and script errors bare to standard error: `run`.
    Stdout,
    /// To the log, and script errors bare to standard error: a run of which something else is the answer.
    Stderr,
    /// To the log: `serve`.
    Log,
}

/// A program that was started.
struct ProgramSpan {
    name: String,
    span: Span,
    has_run: bool,
}

/// Tells everybody.
pub struct EventBroadcaster {
    ports: broadcast::Sender<Message>,
    /// Stops, alarms and errors as they were issued: each page shows them in its own language.
    pages: broadcast::Sender<Message>,
    console: PrintTarget,
    feed: Arc<SampleFeed>,
    programs: Mutex<BTreeMap<ProgramId, ProgramSpan>>,
    /// Global variables of the newest programs, with their last values.
    values: Mutex<BTreeMap<ProgramId, BTreeMap<String, String>>>,
    errors: [AtomicU64; ERROR_KINDS.len()],
    interpreter_log: InterpreterLog,
}

/// Values are kept of so many programs: of the one that runs, and of those that it and its like have replaced.
const PROGRAMS_WITH_VALUES: usize = 4;

impl EventBroadcaster {
    /// Nobody follows yet.
    pub fn new(
        console: PrintTarget,
        interpreter_log: InterpreterLog,
        feed: Arc<SampleFeed>,
    ) -> Self {
        Self {
            ports: broadcast::channel(BACKLOG).0,
            pages: broadcast::channel(BACKLOG).0,
            console,
            feed,
            programs: Mutex::default(),
            values: Mutex::default(),
            errors: Default::default(),
            interpreter_log,
        }
    }

    /// Follows the messages from now on.
    pub fn subscribe(&self) -> broadcast::Receiver<Message> {
        self.ports.subscribe()
    }

    /// Follows stops, alarms and errors from now on, whole and in each language.
    pub fn subscribe_alarms(&self) -> broadcast::Receiver<Message> {
        self.pages.subscribe()
    }

    /// The global variables of a program with their last values, as long as it is one of the newest.
    pub fn values_of(&self, program: ProgramId) -> BTreeMap<String, String> {
        let values = self.values.lock();
        values.get(&program).cloned().unwrap_or_default()
    }

    /// Number of errors of each kind.
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

    /// The name of a program that was started.
    fn name_of(&self, program: ProgramId) -> Option<String> {
        let programs = self.programs.lock();
        programs.get(&program).map(|known| known.name.clone())
    }

    /// A message of a program that one person runs: what it is about, without time and threads.
    fn line_for_people(&self, severity: Severity, origin: Origin, text: &Text) -> String {
        let word = match severity {
            Severity::Info => Text::fixed("", ""),
            Severity::Warning => text!("warning: ", "警告："),
            Severity::Error => text!("error: ", "错误："),
        };
        let (word, text) = (language::shown(&word), language::shown(text));
        match self.name_of(origin.program).filter(|_| origin.line > 0) {
            Some(name) => format!("{name}:{}: {word}{text}", origin.line),
            None => format!("{word}{text}"),
        }
    }

    /// What the log says of where a message comes from; nothing of the controller's own.
    fn span_of(&self, origin: Origin) -> Span {
        let programs = self.programs.lock();
        let Some(known) = programs.get(&origin.program) else {
            return Span::none();
        };
        if origin.line == 0 {
            return known.span.clone();
        }
        tracing::error_span!(
            target: "script",
            parent: &known.span,
            "thread",
            number = origin.thread.0,
            line = origin.line
        )
    }

    fn log(&self, severity: Severity, origin: Origin, text: &Text) {
        if self.console == PrintTarget::Stdout && !logging::is_json() {
            return logging::say(&self.line_for_people(severity, origin, text));
        }
        self.span_of(origin).in_scope(|| match severity {
            Severity::Info => tracing::info!(target: "script", "{text}"),
            Severity::Warning => tracing::warn!(target: "script", "{text}"),
            Severity::Error => tracing::error!(target: "script", "{text}"),
        });
    }
}

impl Observer for EventBroadcaster {
    fn message(&self, message: &Message) {
        self.count(message);
        if let Message::ScriptError { .. } | Message::Robot { .. } = message {
            // Nobody listening is fine.
            let _ = self.pages.send(message.clone());
        }
        match message {
            Message::Print { text, .. } if self.console == PrintTarget::Stdout => {
                // Nothing sensible is left to do when standard output is gone.
                let _ = std::io::stdout().write_all(text.as_bytes());
            }
            Message::Print { origin, text } => {
                let text = Text::verbatim(text.trim_end_matches('\n').to_owned());
                self.log(Severity::Info, *origin, &text);
            }
            Message::Log {
                severity,
                origin,
                text,
            } => self.log(*severity, *origin, text),
            Message::ScriptError {
                program, report, ..
            } => {
                // The report has lines of its own; a log prefix would push the caret out of place.
                if self.console != PrintTarget::Log {
                    logging::say(without_repetition(report.in_language(language::chosen())));
                } else {
                    let origin = Origin {
                        program: *program,
                        ..Origin::default()
                    };
                    self.span_of(origin).in_scope(
                        || tracing::error!(target: "script", "\n{}", report.english().trim_end()),
                    );
                }
            }
            Message::Robot {
                origin,
                severity,
                text,
                ..
            } => self.log(*severity, *origin, text),
        }
        if let Some(message) = primary_message(message, |program| self.name_of(program)) {
            // Nobody listening is fine.
            let _ = self.ports.send(message);
        }
    }

    fn program_started(&self, program: ProgramId, name: &str, _: &str) {
        let mut programs = self.programs.lock();
        // Only the newest programs can still say something.
        while programs.len() >= 64 {
            programs.pop_first();
        }
        // Of the highest level: who it is about is told with every message that is shown.
        let span = tracing::error_span!(target: "script", parent: None, "program", called = name, id = program.0);
        let known = ProgramSpan {
            name: truncate_marked(name, PORT_TEXT_BYTES).unwrap_or_else(|| name.to_owned()),
            span,
            has_run: false,
        };
        programs.insert(program, known);
    }

    fn program_compiled(&self, program: ProgramId, text: &str) {
        let name = self.programs.lock().get_mut(&program).map(|known| {
            known.has_run = true;
            known.name.clone()
        });
        // Secondary programs run beside the one that people look at.
        if !text.trim_start().starts_with("sec ") {
            self.feed.program_runs(ShownProgram {
                number: program.0,
                name: name.unwrap_or_default(),
                text: text.into(),
            });
        }
    }

    fn line_changed(&self, _: ProgramId, thread: ThreadNumber, line: u32, node: Option<&TaskNode>) {
        self.feed.line_changed(thread, line, node);
    }

    /// Clients ask for values, and tasks go on with them; nobody is told.
    fn variable_changed(&self, program: ProgramId, name: &str, value: &VariableValue) {
        let mut values = self.values.lock();
        let of_program = values.entry(program).or_default();
        of_program.insert(name.to_owned(), value.value.clone());
        while values.len() > PROGRAMS_WITH_VALUES {
            values.pop_first();
        }
    }

    fn interpreter(&self, event: &InterpreterEvent<'_>) {
        self.interpreter_log.executing(event);
    }

    fn program_ended(&self, program: ProgramId) {
        // One that never ran has no line, and another may be running.
        let has_run = self
            .programs
            .lock()
            .get(&program)
            .is_none_or(|known| known.has_run);
        if has_run {
            self.feed.program_ended();
        }
        let origin = Origin {
            program,
            ..Origin::default()
        };
        self.span_of(origin)
            .in_scope(|| tracing::debug!(target: "script", "ended"));
        let _ = std::io::stdout().flush();
    }

    fn cycle_ended(&self, frame: &CycleFrame) {
        self.feed.cycle_ended(frame);
    }
}

/// What clients of port 30001 are told, in English; the rest is for the log alone.
fn primary_message(
    message: &Message,
    name_of: impl Fn(ProgramId) -> Option<String>,
) -> Option<Message> {
    let short = |text: &Text| short(text.english(), PORT_TEXT_BYTES);
    Some(match message {
        Message::Print { .. } => return None,
        // A problem of a secondary program (manual 1.2.6), and that another took the place of one.
        Message::Log { severity, text, .. }
            if *severity != Severity::Warning
                || !(text.english().starts_with("[SEC] ")
                    || text.english().starts_with(REPLACED)) =>
        {
            return None;
        }
        Message::Log {
            severity,
            origin,
            text,
        } => Message::log(*severity, *origin, Text::verbatim(short(text))),
        Message::ScriptError {
            program,
            line,
            column,
            summary,
            report,
        } => Message::ScriptError {
            program: *program,
            line: *line,
            column: *column,
            summary: Text::verbatim(short(summary)),
            report: Text::verbatim(short_report(report.english(), summary.english())),
        },
        Message::Robot {
            origin,
            code,
            sub_code,
            severity,
            text,
        } => Message::Robot {
            origin: *origin,
            code: *code,
            sub_code: *sub_code,
            severity: *severity,
            text: Text::verbatim(match name_of(origin.program) {
                Some(name) if origin.line > 0 => {
                    format!("{} ({name}:{})", short(text), origin.line)
                }
                _ => short(text),
            }),
        },
    })
}

/// A report for people. That of a text that does not compile ends with its title once more, for clients that look at
/// last lines.
fn without_repetition(report: &str) -> &str {
    match report.rsplit_once('\n') {
        Some((picture, last)) if report.starts_with("error[") && last.contains("Error: ") => {
            picture
        }
        _ => report,
    }
}

fn short(text: &str, most: usize) -> String {
    truncate_marked(text, most).unwrap_or_else(|| text.to_owned())
}

/// A long report keeps its last line, which is what went wrong.
fn short_report(report: &str, summary: &str) -> String {
    match truncate_marked(report, PORT_TEXT_BYTES / 2) {
        None => report.to_owned(),
        Some(beginning) => format!("{beginning}\n{}", short(summary, PORT_TEXT_BYTES / 2)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_waits_for_a_port_has_a_bound_and_says_what_went_wrong() {
        let told = |message: &Message| primary_message(message, |_| Some("pick.script".to_owned()));
        let error = |length: usize| Message::ScriptError {
            program: ProgramId(1),
            line: 3,
            column: 1,
            summary: Text::verbatim(format!("ValueError: {}", "y".repeat(length))),
            report: Text::verbatim(format!(
                "line 3\n{}\nValueError: {}",
                "x".repeat(length),
                "y".repeat(length)
            )),
        };
        assert_eq!(told(&error(100)), Some(error(100)));
        let Some(Message::ScriptError { report, .. }) = told(&error(1 << 20)) else {
            panic!("it is told");
        };
        let report = report.english();
        assert!(report.len() <= PORT_TEXT_BYTES + 1, "{}", report.len());
        let last = report.lines().next_back().unwrap();
        assert!(last.starts_with("ValueError: yyy") && last.contains("[cut, "));
        let log = |severity, text: &'static str| {
            Message::log(severity, Origin::default(), Text::verbatim(text))
        };
        let secondary = log(Severity::Warning, "[SEC] Exception: x");
        assert_eq!(told(&secondary), Some(secondary.clone()));
        assert_eq!(told(&log(Severity::Warning, "x")), None);
        assert_eq!(told(&log(Severity::Info, "[SEC] x")), None);
    }
    #[test]
    fn clients_hear_in_which_line_of_which_program_an_alarm_came() {
        let stop = |line| {
            let origin = Origin {
                program: ProgramId(1),
                line,
                ..Origin::default()
            };
            let reason = motion_api::StopReason::EmergencyStop;
            Message::protective_stop(reason, &Text::of(&reason), origin)
        };
        let text = |line, name: Option<&str>| {
            let name = name.map(str::to_owned);
            match primary_message(&stop(line), |_| name.clone()) {
                Some(Message::Robot { text, .. }) => text.to_string(),
                other => panic!("{other:?}"),
            }
        };
        let bare = text(0, Some("pick.script"));
        assert_eq!(
            text(19, Some("pick.script")),
            format!("{bare} (pick.script:19)")
        );
        assert_eq!(text(19, None), bare);
    }
}
