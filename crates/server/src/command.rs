//! What every command of the command line gives back: a status, or a sentence that says why it was not done.

use core::fmt;
use std::error::Error;

use messages::{Language, Localized, Text};

/// Exit status of the process. The meaning is the same for every command.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum CommandStatus {
    /// Done; a check found nothing.
    #[default]
    Success = 0,
    /// Done, with a negative answer: findings, failed tests, a difference, a program that failed, nobody who answers.
    Negative = 1,
    /// Not done: wrong input, no connection, an unreadable file.
    NotDone = 2,
    /// A bug of the controller ended it.
    Fault = 3,
}

impl CommandStatus {
    /// Success, or a negative answer.
    pub const fn of_answer(is_positive: bool) -> Self {
        match is_positive {
            true => Self::Success,
            false => Self::Negative,
        }
    }

    /// The exit status as a number.
    pub const fn code(self) -> u8 {
        self as u8
    }
}

/// The reason for which a command was not done, displayed as one sentence. Any error that can be told in every language
/// can be turned into one.
#[derive(Debug)]
pub struct CommandError {
    status: CommandStatus,
    reason: Text,
}

/// What a command gives back.
pub type CommandResult = Result<CommandStatus, CommandError>;

impl CommandError {
    /// A sentence for people.
    pub fn sentence(text: Text) -> Self {
        Self::from(text)
    }

    /// With another status than [`CommandStatus::NotDone`].
    pub const fn with_status(mut self, status: CommandStatus) -> Self {
        self.status = status;
        self
    }

    /// The exit status.
    pub const fn status(&self) -> CommandStatus {
        self.status
    }
}

impl<E: Error + Localized> From<E> for CommandError {
    fn from(error: E) -> Self {
        Self {
            status: CommandStatus::NotDone,
            reason: Text::of(&error),
        }
    }
}

impl fmt::Display for CommandError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.reason, f)
    }
}

impl Localized for CommandError {
    fn fmt_in(&self, language: Language, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.reason.fmt_in(language, f)
    }
}

#[cfg(test)]
mod tests {
    use messages::text;

    use super::*;

    #[test]
    fn an_error_is_its_sentence_and_means_that_nothing_was_done() {
        let error = CommandError::from(std::io::Error::other("the disk is full"));
        assert_eq!(error.to_string(), "the disk is full");
        assert_eq!(error.status().code(), 2);
        let late = CommandError::sentence(text!("nobody answers", "没有应答"))
            .with_status(CommandStatus::Negative);
        assert_eq!(
            (late.to_string().as_str(), late.status().code()),
            ("nobody answers", 1)
        );
        assert_eq!(late.in_language(Language::Chinese).to_string(), "没有应答");
        assert_eq!(
            CommandStatus::of_answer(false)
                .max(CommandStatus::Success)
                .code(),
            1
        );
    }
}
