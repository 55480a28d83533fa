//! What a task tells people while it runs: findings, errors, lines, global variables, and watchdogs that bite.

use std::sync::Arc;

use elite_lang::{ScriptError, TraceFrame, Value};
use elite_syntax::{Diagnostic, SourceFile, TaskNode};
use messages::{Language, Text, text};
use motion_api::{Origin, ProgramId, Seconds, ThreadNumber};

use super::controls::Control;
use super::scheduler::{Task, TaskEnd};
use super::threads::BlockReason;
use crate::interpreter;
use crate::message::{Message, Severity};
use crate::panel::{VARIABLE_PERIOD, VariableValue, WatchdogAction};
use crate::value_text::repr_text;

/// Longest value of the variable monitor, characters.
const VALUE_CHARS_MAX: usize = 1000;

/// Most nodes of the pendant's task that are told of one thread and cycle; more than a task has in a row without
/// waiting.
const NODES_OF_CYCLE: u32 = 64;

/// What the observer knows of where a thread stands.
#[derive(Default)]
pub(super) struct ReportedPosition {
    /// The cycle in which the line was told.
    cycle: Option<u64>,
    line: u32,
    node: Option<TaskNode>,
    /// Turns of loops that the thread had finished then.
    turns: u64,
    /// Nodes that were told in the cycle `nodes_in`.
    nodes: u32,
    nodes_in: u64,
    /// Nothing more is told.
    is_last: bool,
}

impl ReportedPosition {
    /// Takes note of a place; true if it is another one. A thread that has not begun is nowhere.
    fn update(&mut self, line: u32, node: Option<TaskNode>) -> bool {
        let is_news = line > 0 && (line != self.line || node != self.node);
        if is_news {
            (self.line, self.node) = (line, node);
        }
        is_news
    }

    /// Takes note of the turns of loops that the thread has finished; true if there are more.
    fn update_turns(&mut self, turns: u64) -> bool {
        std::mem::replace(&mut self.turns, turns) != turns
    }
}

/// The variables that the monitor shows, and when it shows them next.
#[derive(Default)]
pub(super) struct VariableMonitor {
    /// Names declared `global`, in the order in which they were met.
    pub global_names: Vec<String>,
    /// Names that the top level of a program binds: in a program without `def` around it they are its variables.
    pub top_level_names: Vec<String>,
    /// The cycle of the next report.
    pub due_cycle: u64,
}

/// The script threads whose lines are reported after a cycle.
#[derive(Default)]
pub(super) struct PositionReports {
    /// Threads that may have come to other lines in the cycle.
    pub pending: Vec<ThreadNumber>,
    /// The cycle in which they were noted.
    pub cycle: u64,
}

impl Task {
    pub(super) fn report_finding(&self, finding: &Diagnostic, file: &SourceFile, secondary: bool) {
        if secondary {
            let origin = Origin {
                program: self.context.program(),
                line: finding.fields(file).line,
                ..Origin::default()
            };
            let summary = text!("SyntaxError: {}", "SyntaxError: {}", finding.message);
            return self.warn_of_secondary(origin, &summary);
        }
        let message = message_of(finding, file, self.context.program());
        self.settings.observer.message(&message);
    }

    /// Tells that another main program takes the place of this one.
    pub(super) fn report_replacement(&self, successor: &str) {
        let origin = Origin {
            program: self.context.program(),
            ..Origin::default()
        };
        let text = text!(
            "the program was stopped: {successor} takes its place",
            "程序已停止：由 {successor} 取代"
        );
        let message = Message::log(Severity::Warning, origin, text);
        self.settings.observer.message(&message);
    }

    /// Tells where a protective stop found the main program; the robot tells why.
    pub(super) fn report_protective_stop(&self) {
        let Some(main) = self.threads.entries.get(&ThreadNumber(0)) else {
            return;
        };
        let origin = Origin {
            program: self.context.program(),
            thread: ThreadNumber(0),
            line: main.script.current_line(),
        };
        let text = text!(
            "the protective stop ends the program in line {}",
            "保护性停止使程序在第 {} 行结束",
            origin.line
        );
        let text = match main.script.current_node() {
            Some(node) => text!("{text}, {node}", "{text}，{node}"),
            None => text,
        };
        let message = Message::log(Severity::Info, origin, text);
        self.settings.observer.message(&message);
    }

    pub(super) fn report_script_error(&self, error: &ScriptError) {
        // What the program said before its error is no less true because the arm stops on the way there.
        self.context.show_effects_if(|_| true);
        let place = place_in_text(error);
        self.settings.observer.message(&Message::ScriptError {
            program: self.context.program(),
            line: place.map_or(1, |frame| frame.line),
            column: place.map_or(1, |frame| frame.column),
            summary: error.headline(),
            report: elite_lang::render_script_error(error),
        });
    }

    pub(super) fn report_secondary_error(&self, number: ThreadNumber, error: &ScriptError) {
        let origin = Origin {
            program: self.context.program(),
            thread: number,
            line: place_in_text(error).map_or(1, |frame| frame.line),
        };
        self.warn_of_secondary(origin, &error.headline());
    }

    pub(super) fn warn_of_secondary(&self, origin: Origin, summary: &Text) {
        let message = Message::secondary_exception(origin, summary);
        self.settings.observer.message(&message);
    }

    /// After a slice of a thread: its nodes are told as it came to them, its line when the cycle is over.
    pub(super) fn report_nodes(&mut self, number: ThreadNumber) {
        let cycle = self.settings.robot.moment().cycle;
        let Some(entry) = self.threads.entries.get_mut(&number) else {
            return;
        };
        let passages = entry.script.take_node_changes();
        if entry.reported.nodes_in != cycle {
            (entry.reported.nodes_in, entry.reported.nodes) = (cycle, 0);
        }
        for passage in passages {
            if entry.reported.nodes < NODES_OF_CYCLE {
                entry.reported.nodes += 1;
                entry.reported.line = passage.line;
                entry.reported.node = Some(passage.node);
                let node = entry.reported.node.as_ref();
                let observer = &self.settings.observer;
                observer.line_changed(self.context.program(), number, passage.line, node);
            }
        }
        if !self.positions.pending.contains(&number) {
            self.positions.pending.push(number);
        }
        // Under the real clock time passes while scripts compute; under the virtual one only when they all wait.
        if cycle != self.positions.cycle && !self.settings.robot.timeline().is_virtual() {
            self.report_lines();
            self.positions.cycle = cycle;
        }
    }

    /// Before a cycle passes: where the threads stand that ran in it, once a cycle and thread.
    pub(super) fn report_lines(&mut self) {
        let cycle = self.settings.robot.moment().cycle;
        let mut later = Vec::new();
        for number in std::mem::take(&mut self.positions.pending) {
            let Some(entry) = self.threads.entries.get_mut(&number) else {
                continue;
            };
            if entry.reported.cycle == Some(cycle) {
                later.push(number);
                continue;
            }
            let line = entry.script.current_line();
            let is_elsewhere = entry.reported.update(line, entry.script.current_node());
            let is_next_turn = entry.reported.update_turns(entry.script.finished_turns());
            if line > 0 && (is_elsewhere || is_next_turn) {
                entry.reported.cycle = Some(cycle);
                let node = entry.reported.node.as_ref();
                let observer = &self.settings.observer;
                observer.line_changed(self.context.program(), number, line, node);
            }
        }
        self.positions.pending = later;
    }

    /// Where a thread ended: in `line`, or where it stands.
    pub(super) fn report_last_line(&mut self, number: ThreadNumber, line: Option<u32>) {
        let Some(entry) = self.threads.entries.get_mut(&number) else {
            return;
        };
        let line = line.unwrap_or_else(|| entry.script.current_line());
        if !entry.reported.is_last && entry.reported.update(line, entry.script.current_node()) {
            let node = entry.reported.node.as_ref();
            let observer = &self.settings.observer;
            observer.line_changed(self.context.program(), number, line, node);
        }
        entry.reported.is_last = true;
    }

    /// Publishes the global variables that have changed; looks at them ten times a second of simulated time, and once
    /// more at the end of the task.
    pub(super) fn publish_variables(&mut self, at_the_end: bool) {
        let state = self.settings.robot.moment();
        let is_empty =
            self.monitor.global_names.is_empty() && self.monitor.top_level_names.is_empty();
        if is_empty || (state.cycle < self.monitor.due_cycle && !at_the_end) {
            return;
        }
        let step = Seconds::new(state.step_time).unwrap_or_default();
        let period = Seconds::new(VARIABLE_PERIOD).unwrap_or_default();
        self.monitor.due_cycle = state.cycle + period.cycles(step);
        let declared = self.monitor.global_names.iter().map(|name| (name, true));
        let top_level = self
            .monitor
            .top_level_names
            .iter()
            .map(|name| (name, false));
        for (name, is_declared) in declared.chain(top_level) {
            let Some(value) = self.interpreter.global(name) else {
                continue; // declared, not bound yet
            };
            // Functions, classes and modules of the top level are no news to whoever reads the program.
            if !is_declared && !is_data(&value) {
                continue;
            }
            let value = VariableValue {
                type_name: value.type_name().to_string(),
                value: repr_text(&value, VALUE_CHARS_MAX),
            };
            let is_news = task_memory::uncounted(|| {
                self.settings.panel.with_variables(|variables| {
                    (at_the_end || variables.is_due(name, state.time))
                        && variables.publish(name, &value, state.time)
                })
            });
            if is_news {
                let program = self.context.program();
                let observer = &self.settings.observer;
                observer.variable_changed(program, name, &value);
            }
        }
    }

    /// Inputs that are set too rarely (manual 9.5.6). A task that is held is not watched.
    pub(super) fn check_watchdogs(&mut self) {
        // What watchdogs did is in the recording as an order.
        if self.suspension.is_active || self.context.repeat().is_some() {
            return;
        }
        let state = self.context.robot().moment();
        let panel = &self.settings.panel;
        let bites = panel.with_watchdogs(|dogs| match dogs.is_empty() {
            true => Vec::new(),
            false => dogs.expired(state.time, state.step_time),
        });
        for (variable, action) in bites {
            let (severity, what) = match action {
                WatchdogAction::Ignore => (Severity::Warning, text!("nothing is done", "不做处理")),
                WatchdogAction::Pause => (
                    Severity::Warning,
                    text!("the program is paused", "程序暂停"),
                ),
                WatchdogAction::Stop => {
                    (Severity::Error, text!("the program is stopped", "程序停止"))
                }
            };
            let origin = Origin {
                program: self.context.program(),
                ..Origin::default()
            };
            let text = text!(
                "RTSI watchdog: {variable} is not set often enough, {what}",
                "RTSI 看门狗：{variable} 设置得不够频繁，{what}"
            );
            self.settings
                .observer
                .message(&Message::log(severity, origin, text));
            match action {
                WatchdogAction::Ignore => {}
                WatchdogAction::Pause => {
                    self.note_order(&Control::Pause);
                    self.pause();
                }
                WatchdogAction::Stop => {
                    self.note_order(&Control::Stop);
                    self.progress.end = Some(TaskEnd::Stopped);
                }
            }
        }
    }

    /// Ends secondary programs that wait too long for a lock.
    pub(super) fn end_late_secondaries(&mut self) {
        let now = self.context.robot().moment().time;
        let late: Vec<ThreadNumber> = self
            .threads
            .entries
            .iter()
            .filter(|(_, e)| matches!(e.waiting, Some(BlockReason::Parked { .. })))
            .filter(|(_, e)| e.secondary.is_some_and(|bounds| now > bounds.until))
            .map(|(number, _)| *number)
            .collect();
        for number in late {
            let text = text!(
                "TimeoutError: a secondary program has to be short, this one was ended after waiting \
                        for a second",
                "TimeoutError: 次要程序必须简短，这个程序等待一秒后被结束"
            );
            self.end_secondary(number, &text);
        }
    }
}

/// Where in the program the error was raised, or what led to it there; other texts have lines of their own. The call
/// stack of a thread may begin in the library.
pub(super) fn place_in_program(error: &ScriptError) -> Option<&TraceFrame> {
    let mut frames = error.traceback.iter();
    let outermost = frames.find(|frame| !frame.is_in_library())?;
    innermost_of(error, &outermost.file)
}

/// Where in the text that people sent the error was raised: in a statement of interpreter mode, or else in the program.
fn place_in_text(error: &ScriptError) -> Option<&TraceFrame> {
    let mut frames = error.traceback.iter();
    match frames.rfind(|frame| interpreter::is_statement(&frame.file)) {
        Some(statement) => innermost_of(error, &statement.file),
        None => place_in_program(error),
    }
}

/// The innermost level of the call stack that is in a text.
fn innermost_of<'e>(error: &'e ScriptError, text: &Arc<SourceFile>) -> Option<&'e TraceFrame> {
    let mut frames = error.traceback.iter();
    frames.rfind(|frame| Arc::ptr_eq(&frame.file, text))
}

/// What is told of a main program that does not compile; 0 is the number of one that was never started.
pub(crate) fn message_of(finding: &Diagnostic, file: &SourceFile, program: ProgramId) -> Message {
    let place = finding.fields(file);
    let summary = text!("SyntaxError: {}", "SyntaxError: {}", finding.message);
    let picture = elite_syntax::picture(finding, file);
    let [english, chinese] = [Language::English, Language::Chinese].map(|language| {
        let picture = picture.in_language(language).trim_end();
        format!("{picture}\n{}", summary.in_language(language))
    });
    Message::ScriptError {
        program,
        line: place.line,
        column: place.column,
        report: Text::new(english, chinese),
        summary,
    }
}

/// Whether a value is one that people look at: no function, class or module.
const fn is_data(value: &Value) -> bool {
    !matches!(
        value,
        Value::Function(_) | Value::Builtin(_) | Value::Class(_) | Value::Module(_)
    )
}
