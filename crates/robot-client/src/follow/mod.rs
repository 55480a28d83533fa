//! What a controller's stream says of the program that was sent to it: pure, messages and moments in, news out.
//!
//! Nothing acknowledges a program on port 30001. That it runs is seen in the states, ten times a second; that it does
//! not compile, or failed, in an exception. A program that is over within a tenth of a second is never seen running.

use std::time::Duration;

use wire::primary::{Exception, ExceptionLevel, Message, RobotException, State};

/// A program that nobody has seen running for so long, and nobody complained about, has ended.
pub const SHORT_PROGRAM: Duration = Duration::from_millis(700);
/// After the end of a program its error may still be on the way.
const ERROR_GRACE_TIME: Duration = Duration::from_millis(250);

/// What came of the program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MonitorOutcome {
    /// The program ran to its end.
    Completed,
    /// The program did not compile, or failed; an event before this one told why.
    Failed,
}

/// Something to tell.
#[derive(Clone, Debug, PartialEq)]
pub enum ProgramEvent {
    /// The program runs.
    Began,
    /// The program is paused.
    Paused,
    /// The program goes on.
    Resumed,
    /// An exception of the program or the robot.
    Exception(RobotException),
    /// The program is over.
    Finished(MonitorOutcome),
}

/// Follows one program from its sending to its end.
#[derive(Clone, Debug, Default)]
pub struct ProgramMonitor {
    was_running: bool,
    was_paused: bool,
    has_failed: bool,
    /// Another program runs in its place: what the states say is of that one.
    is_replaced: bool,
    /// Time when the program was seen to be over.
    over_since: Option<Duration>,
    is_over: bool,
}

impl ProgramMonitor {
    /// The program has just been sent. Moments count from here.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes a message that came so long after the sending.
    pub fn handle_message(&mut self, message: &Message, moment: Duration) -> Vec<ProgramEvent> {
        let mut news = Vec::new();
        match message {
            Message::State(_) if self.is_replaced => {}
            Message::State(state) => self.take_state(state, moment, &mut news),
            Message::Exception(exception) => {
                self.has_failed |= ends_programs(exception);
                if is_replacement(exception) {
                    self.is_replaced = true;
                    self.over_since.get_or_insert(moment);
                }
                news.push(ProgramEvent::Exception(exception.clone()));
            }
            Message::Unknown(_) => {}
        }
        self.check_finished(moment, &mut news);
        news
    }

    /// True once the end has been told.
    pub const fn is_over(&self) -> bool {
        self.is_over
    }

    fn take_state(&mut self, state: &State, moment: Duration, news: &mut Vec<ProgramEvent>) {
        let Some(mode) = &state.mode else { return };
        if mode.is_task_running {
            self.over_since = None;
            if !self.was_running {
                self.was_running = true;
                news.push(ProgramEvent::Began);
            }
            if mode.is_task_paused != self.was_paused {
                self.was_paused = mode.is_task_paused;
                news.push(match mode.is_task_paused {
                    true => ProgramEvent::Paused,
                    false => ProgramEvent::Resumed,
                });
            }
        } else if self.was_running || self.has_failed || moment >= SHORT_PROGRAM {
            self.over_since.get_or_insert(moment);
        }
    }

    fn check_finished(&mut self, moment: Duration, news: &mut Vec<ProgramEvent>) {
        let is_over = self
            .over_since
            .is_some_and(|since| moment.saturating_sub(since) >= ERROR_GRACE_TIME);
        if is_over && !self.is_over {
            self.is_over = true;
            news.push(ProgramEvent::Finished(match self.has_failed {
                true => MonitorOutcome::Failed,
                false => MonitorOutcome::Completed,
            }));
        }
    }
}

/// A controller of ours says so to the sender of the program.
fn is_replacement(exception: &RobotException) -> bool {
    let begins = "RuntimeError: the program was stopped: ";
    matches!(&exception.exception, Exception::Script { text, .. } if text.starts_with(begins))
}

/// Errors of a script end it, but for those of secondary programs, which only warn (manual 1.2.6); so do errors of the
/// robot.
fn ends_programs(exception: &RobotException) -> bool {
    match &exception.exception {
        Exception::Script { text, .. } => !text.starts_with("[SEC]"),
        Exception::Robot { level, .. } => {
            matches!(level, ExceptionLevel::Error | ExceptionLevel::Fatal)
        }
    }
}

#[cfg(test)]
mod tests;
