//! What a robot reports, as messages of the recording's log.

use messages::Text;
use recorder::{LogLevel, RecorderHandle};
use wire::primary::{
    Exception, ExceptionLevel, ExceptionSource, RobotErrorDisplay, RobotException,
};
use wire::rtsi::TextLevel;

/// Writes down what the robot reports, as our own controller's messages are.
pub(super) fn tell(handle: &RecorderHandle, time: f64, told: &RobotException) {
    let (level, text) = match &told.exception {
        Exception::Script { line, column, text } => {
            // What happened stands in the last line of a report; whoever reads one line reads that.
            let what = text.lines().rfind(|line| !line.trim().is_empty());
            let report = match text.lines().count() {
                0 | 1 => String::new(),
                _ => format!("\n{text}"),
            };
            let what = what.unwrap_or_default();
            let text = format!("line {line}, column {column}: {what}{report}");
            (LogLevel::Error, text)
        }
        Exception::Robot {
            code,
            sub_code,
            level,
            data,
        } => {
            let level = match level {
                ExceptionLevel::Info => LogLevel::Info,
                ExceptionLevel::Warning => LogLevel::Warning,
                ExceptionLevel::Error | ExceptionLevel::Fatal => LogLevel::Error,
            };
            let (code, sub_code) = (*code, *sub_code);
            let numbered = RobotErrorDisplay {
                code,
                sub_code,
                data,
            };
            (level, numbered.to_string())
        }
    };
    handle.log(
        time,
        level,
        ExceptionSource::name(told.source),
        &Text::verbatim(text),
    );
}

/// The level of a text of RTSI.
pub(super) fn level_of(level: TextLevel) -> LogLevel {
    match level {
        TextLevel::Exception | TextLevel::Error => LogLevel::Error,
        TextLevel::Warning => LogLevel::Warning,
        TextLevel::Info => LogLevel::Info,
    }
}
