//! What programs and the robot tell people: log lines, script errors, robot events; and who is told.
//!
//! Three kinds of trouble stay apart: a script error ends a task, a robot event changes the robot's state and is seen
//! by all, a service error (not here) ends one connection.

use std::sync::Arc;

use elite_syntax::TaskNode;
use messages::{Text, text};
use motion_api::{CycleFrame, Origin, ProgramId, StopReason, ThreadNumber};

use crate::panel::VariableValue;

/// How much a message matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// For information.
    Info,
    /// Something was changed or ignored.
    Warning,
    /// Something ended that should not have.
    Error,
}

/// One message.
#[derive(Clone, Debug, PartialEq)]
pub enum Message {
    /// Standard output of a program, as written (with its line end).
    Print {
        /// The program, thread and line that printed the text.
        origin: Origin,
        /// The text.
        text: String,
    },
    /// A log line: `textmsg` and warnings.
    Log {
        /// How much the line matters.
        severity: Severity,
        /// Where the line came from; program 0: not from a program.
        origin: Origin,
        /// The text.
        text: Text,
    },
    /// A program did not compile or ended with an uncaught exception.
    ScriptError {
        /// The program that failed.
        program: ProgramId,
        /// Line, from 1.
        line: u32,
        /// Column, from 1.
        column: u32,
        /// `Type: message`.
        summary: Text,
        /// The whole report: place, source line with caret, stack, last line `Type: message`.
        report: Text,
    },
    /// The robot changed its state on its own.
    Robot {
        /// Where the program stood that moved the arm, or asked for what went wrong; program 0: none did.
        origin: Origin,
        /// Error code.
        code: i32,
        /// Sub code.
        sub_code: i32,
        /// How bad.
        severity: Severity,
        /// The sentence.
        text: Text,
    },
}

/// Error code of every protective stop; the sub code tells the reason ([`StopReason::code`]). Our numbering.
pub const PROTECTIVE_STOP_CODE: i32 = 100;

/// Error code of every emergency stop. Our numbering.
pub const EMERGENCY_STOP_CODE: i32 = 101;

/// Error code of alarms that end a program, such as a wrong I/O type (manual 5.16). Our numbering.
pub const SCRIPT_ALARM_CODE: i32 = 110;

/// How the message begins that another program takes the place of one.
pub const REPLACED: &str = "the program was stopped: ";

/// Error code of the alarm that the recording has stopped. Our numbering.
pub const RECORDING_ALARM_CODE: i32 = 120;

/// Error code of the alarm that the control cycle has ended by a fault of ours. Our numbering.
pub const CONTROLLER_FAULT_CODE: i32 = 130;

/// What ends the clean-up of a stopped program.
#[derive(Clone, Copy, Debug)]
pub(crate) enum CutShort {
    /// The time for it.
    Time,
    /// A wait.
    Wait,
    /// The number of its calls.
    Calls,
}

impl Message {
    /// A program ended by a fault of the controller.
    pub fn internal_error(program: ProgramId, line: u32, what: &Text) -> Self {
        let summary = text!(
            "InternalError: {what}; this is a fault of the controller, not of the program: please report it",
            "InternalError: {what}；这是控制器的缺陷，不是程序的：请报告"
        );
        Self::ScriptError {
            program,
            line,
            column: 1,
            report: text!("line {line}\n{summary}", "第 {line} 行\n{summary}"),
            summary,
        }
    }

    /// The message with texts that it shares with no other: copies of a text share its words, and those of a task are
    /// in the account of its memory until the last copy is gone.
    fn with_own_texts(&self) -> Self {
        let mut own = self.clone();
        match &mut own {
            Self::Print { .. } => {}
            Self::Log { text, .. } | Self::Robot { text, .. } => *text = Text::of(text),
            Self::ScriptError {
                summary, report, ..
            } => (*summary, *report) = (Text::of(summary), Text::of(report)),
        }
        own
    }

    /// A log line.
    pub fn log(severity: Severity, origin: Origin, text: Text) -> Self {
        Self::Log {
            severity,
            origin,
            text,
        }
    }

    /// What a stopped program cleans up in its `finally` and `with` blocks is ended before its end.
    pub(crate) fn clean_up_is_cut(origin: Origin, cut: CutShort) -> Self {
        let why = match cut {
            CutShort::Time => text!("it has computed for 0.5 s", "已计算 0.5 秒"),
            CutShort::Wait => text!("a stopped program cannot wait", "已停止的程序不能等待"),
            CutShort::Calls => text!("it has called very many functions", "调用的函数过多"),
        };
        let line = origin.line;
        let text = text!(
            "clean-up behind a stop is ended at line {line}: {why}",
            "停止后的清理在第 {line} 行结束：{why}"
        );
        Self::log(Severity::Warning, origin, text)
    }

    /// A problem of a secondary program: a warning that begins as manual 1.2.6 says.
    pub fn secondary_exception(origin: Origin, summary: &Text) -> Self {
        Self::log(
            Severity::Warning,
            origin,
            text!("[SEC] Exception: {summary}", "[SEC] Exception: {summary}"),
        )
    }

    /// The message of a protective or an emergency stop; `told` is what is said of the reason.
    pub fn protective_stop(reason: StopReason, told: &Text, origin: Origin) -> Self {
        Self::Robot {
            origin,
            code: match reason {
                StopReason::EmergencyStop => EMERGENCY_STOP_CODE,
                _ => PROTECTIVE_STOP_CODE,
            },
            sub_code: i32::try_from(reason.code()).unwrap_or(i32::MAX),
            severity: Severity::Error,
            text: match reason {
                StopReason::EmergencyStop => {
                    text!("emergency stop: {told}", "紧急停止：{told}")
                }
                _ => text!("protective stop: {told}", "保护性停止：{told}"),
            },
        }
    }
}

/// Is told what happens, on the thread where it happens; must not wait. What an observer does not look at goes to the
/// one behind it, if there is one: nothing is lost in a chain because a link forgot it.
pub trait Observer: Send + Sync {
    /// The observer behind this one. Whoever has one and looks at an event passes the event on as well.
    fn next(&self) -> Option<&dyn Observer> {
        None
    }

    /// A message was issued.
    fn message(&self, message: &Message) {
        if let Some(next) = self.next() {
            next.message(message);
        }
    }

    /// A program is about to start; whether it compiles is not known yet.
    fn program_started(&self, program: ProgramId, name: &str, text: &str) {
        if let Some(next) = self.next() {
            next.program_started(program, name, text);
        }
    }

    /// The program compiles and is about to run. None of its commands and lines come before this.
    fn program_compiled(&self, program: ProgramId, text: &str) {
        if let Some(next) = self.next() {
            next.program_compiled(program, text);
        }
    }

    /// A script thread stands at another line, has come round a loop to the same one, or is in another node of the
    /// pendant's task. Lines come at most once a cycle and thread and when it ends; nodes as they are passed, of very
    /// many in a cycle the first and the last.
    fn line_changed(
        &self,
        program: ProgramId,
        thread: ThreadNumber,
        line: u32,
        node: Option<&TaskNode>,
    ) {
        if let Some(next) = self.next() {
            next.line_changed(program, thread, line, node);
        }
    }

    /// A program has ended.
    fn program_ended(&self, program: ProgramId) {
        if let Some(next) = self.next() {
            next.program_ended(program);
        }
    }

    /// A name that a program declares `global` has this value now; at most ten times a second of simulated time.
    fn variable_changed(&self, program: ProgramId, name: &str, value: &VariableValue) {
        if let Some(next) = self.next() {
            next.variable_changed(program, name, value);
        }
    }

    /// Interpreter mode has done something worth a line in its log (manual 2.7).
    fn interpreter(&self, event: &InterpreterEvent<'_>) {
        if let Some(next) = self.next() {
            next.interpreter(event);
        }
    }

    /// A cycle has ended. Every cycle comes, in order; only when nobody took any for a second, some are left out.
    fn cycle_ended(&self, frame: &CycleFrame) {
        if let Some(next) = self.next() {
            next.cycle_ended(frame);
        }
    }

    /// Somebody wants the program to end or to be held at once: what holds it up for the observer's sake lets it go.
    fn release_backpressure(&self) {
        if let Some(next) = self.next() {
            next.release_backpressure();
        }
    }
}

/// What interpreter mode does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InterpreterEvent<'a> {
    /// A program entered the mode.
    Entered,
    /// A statement is about to be executed.
    Executing {
        /// The number of the statement.
        id: u64,
        /// The text of the statement.
        text: &'a str,
    },
    /// The injected functions were removed.
    Cleared {
        /// The last statement that the removed functions can come from.
        id: u64,
    },
    /// The mode was left.
    Left,
}

/// Tells an observer on behalf of a task: what the observer keeps for other threads is not counted as the task's
/// memory.
pub(crate) struct UnmeteredObserver(pub Arc<dyn Observer>);

impl Observer for UnmeteredObserver {
    fn message(&self, message: &Message) {
        task_memory::uncounted(|| self.0.message(&message.with_own_texts()));
    }

    fn program_started(&self, program: ProgramId, name: &str, text: &str) {
        task_memory::uncounted(|| self.0.program_started(program, name, text));
    }

    fn program_compiled(&self, program: ProgramId, text: &str) {
        task_memory::uncounted(|| self.0.program_compiled(program, text));
    }

    fn line_changed(
        &self,
        program: ProgramId,
        thread: ThreadNumber,
        line: u32,
        node: Option<&TaskNode>,
    ) {
        task_memory::uncounted(|| self.0.line_changed(program, thread, line, node));
    }

    fn program_ended(&self, program: ProgramId) {
        task_memory::uncounted(|| self.0.program_ended(program));
    }

    fn variable_changed(&self, program: ProgramId, name: &str, value: &VariableValue) {
        task_memory::uncounted(|| self.0.variable_changed(program, name, value));
    }

    fn interpreter(&self, event: &InterpreterEvent<'_>) {
        task_memory::uncounted(|| self.0.interpreter(event));
    }

    fn cycle_ended(&self, frame: &CycleFrame) {
        task_memory::uncounted(|| self.0.cycle_ended(frame));
    }

    fn release_backpressure(&self) {
        task_memory::uncounted(|| self.0.release_backpressure());
    }
}
