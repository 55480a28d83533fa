//! The conversation of a shell with its robot: statements to port 30020, what comes of them on 30001.
//!
//! Runs on a thread of its own, so that the robot is heard while somebody types. Owns the program that holds
//! interpreter mode: begins it, notices when it is over, ends it.

use std::collections::VecDeque;
use std::sync::mpsc::SyncSender;
use std::time::Duration;

use messages::{Localized, Text, text};
use robot_client::interpreter::{self, END_INTERPRETER_STATEMENT};
use robot_client::{
    InterpreterClient, InterpreterError, InterpreterRequest, PrimaryClient, PrimaryError, Reply,
    RobotAddress, dashboard,
};
use thiserror::Error;
use tokio::sync::mpsc;
use tokio::time::{Instant, sleep_until, timeout_at};
use tokio_util::sync::CancellationToken;
use wire::primary::{
    Exception, ExceptionLevel, ExceptionSource, Message, RobotErrorDisplay, RobotException, State,
};

use super::output::{described, show, show_text};
use super::shown_value;
use crate::commands::line_input::Notifier;
use crate::commands::program_output::ProgramOutput;
use crate::commands::robot_consent;
use crate::language;
use crate::logging;
use crate::ports::escape::{EscapedLines, EscapedText};

/// What the program that holds interpreter mode is called.
pub(super) const NAME: &str = "eliteserver_shell";
/// A robot that has not begun a program after so long does not.
const BEGIN_PATIENCE: Duration = Duration::from_secs(3);
/// A statement without a reply for so long: is anybody there?
const REPLY_PATIENCE: Duration = Duration::from_secs(4);
/// Words are answered at once.
const WORD_PATIENCE: Duration = Duration::from_secs(3);
/// After the end of a program its error may still be on the way.
const LAST_WORDS: Duration = Duration::from_millis(250);
/// Reports that are kept for `:log`.
const REPORTS_MAX: usize = 1000;

/// What the shell asks for.
#[derive(Debug)]
pub(super) enum SessionCommand {
    /// Send a statement.
    Statement(String),
    /// Send a word.
    Word(InterpreterRequest),
    /// Show how the robot is.
    State,
    /// Show variables.
    Variables(Vec<String>),
    /// Show the last reports.
    Log(usize),
    /// End interpreter mode once what was sent is done.
    Leave,
}

/// What came of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SessionReply {
    /// The command was carried out.
    Done,
    /// The robot discarded it.
    Discarded,
    /// The session is over: nothing of it failed, or something did.
    Left { has_failed: bool },
}

/// An order with the way back.
pub(super) type SessionRequest = (SessionCommand, SyncSender<SessionReply>);

/// A reason why there is no session, or none any more, told in a sentence.
#[derive(Debug, Error, Localized)]
pub(super) enum SessionError {
    #[error(transparent)]
    Primary(#[from] PrimaryError),
    #[error(transparent)]
    Interpreter(#[from] InterpreterError),
    #[error("a program runs on the robot at {0}; the shell would take its place. Stop it first")]
    #[zh("机器人 {0} 上正在运行程序，交互会话会取代它。请先停止该程序")]
    Busy(RobotAddress),
    #[error("the robot at {0} has not begun the program that enters interpreter mode")]
    #[zh("机器人 {0} 没有启动进入解释器模式的程序")]
    NotBegun(RobotAddress),
    #[error("the robot at {0} has not answered the statement, and none waits there")]
    #[zh("机器人 {0} 没有回应该语句，那里也没有等待的语句")]
    Unanswered(RobotAddress),
    #[error("the program that enters interpreter mode failed: {0}")]
    #[zh("进入解释器模式的程序失败：{0}")]
    Failed(String),
    #[error("{error}; {what}")]
    GivenUp {
        error: Box<SessionError>,
        what: Text,
    },
    /// Ctrl-C; the robot was stopped.
    #[error("{0}")]
    Stopped(Text),
}

/// A session.
pub(super) struct ShellSession {
    primary: PrimaryClient,
    interpreter: InterpreterClient,
    dashboard: RobotAddress,
    /// Lines before the mode is entered.
    body: String,
    /// What statements print.
    printed: ProgramOutput,
    /// Something happens beside the line that is typed.
    voice: Option<Notifier>,
    stop: CancellationToken,
    state: Option<State>,
    /// When no program was seen to run any more, after its own did. One state may be late or come twice.
    over_since: Option<Instant>,
    is_entered: bool,
    /// The last reply to a statement: one that comes twice counts once.
    last: Option<Reply>,
    reports: VecDeque<String>,
    begun: Instant,
    has_failed: bool,
}

impl ShellSession {
    /// Connects and enters interpreter mode.
    pub(super) async fn open(
        address: &RobotAddress,
        interpreter: &RobotAddress,
        dashboard: RobotAddress,
        body: String,
        printed: ProgramOutput,
        stop: CancellationToken,
    ) -> Result<Self, SessionError> {
        let mut session = Self {
            primary: PrimaryClient::connect(address).await?,
            interpreter: InterpreterClient::connect(interpreter).await?,
            dashboard,
            body,
            printed,
            voice: None,
            stop,
            state: None,
            over_since: None,
            is_entered: false,
            last: None,
            reports: VecDeque::new(),
            begun: Instant::now(),
            has_failed: false,
        };
        session.enter().await?;
        // Whoever answers there is one who knows interpreter mode.
        let mut beside = Vec::new();
        let interpreter = &mut session.interpreter;
        let asked = interpreter.ask(InterpreterRequest::Unexecuted, WORD_PATIENCE, &mut beside);
        match asked.await {
            Ok(_) => Ok(session),
            Err(error) => {
                let error = error.into();
                Err(session.given_up(error).await)
            }
        }
    }

    /// The session ends with an error. What nobody can talk to any more is stopped where that can be said.
    async fn given_up(&mut self, error: SessionError) -> SessionError {
        let what = match &error {
            SessionError::Interpreter(_) | SessionError::Unanswered(_) => {
                let stopped = robot_consent::stop(&mut self.primary).await;
                stopped.unwrap_or(text!("its program may go on", "其程序可能仍在运行"))
            }
            SessionError::Primary(_) => text!("its program may go on", "其程序可能仍在运行"),
            _ => return error,
        };
        let error = Box::new(error);
        SessionError::GivenUp { error, what }
    }

    /// Whether what statements print is shown here.
    pub(super) const fn shows_output(&self) -> bool {
        self.printed.is_connected()
    }

    /// Sets how something is said while a line is being typed.
    pub(super) fn set_notifier(&mut self, voice: Option<Notifier>) {
        self.voice = voice;
    }

    /// Does what is asked until it is told to leave, or the robot is gone. True if something failed.
    pub(super) async fn serve(
        &mut self,
        orders: &mut mpsc::Receiver<SessionRequest>,
    ) -> Result<bool, SessionError> {
        match self.served(orders).await {
            Ok(has_failed) => Ok(has_failed),
            Err(error) => Err(self.given_up(error).await),
        }
    }

    async fn served(
        &mut self,
        orders: &mut mpsc::Receiver<SessionRequest>,
    ) -> Result<bool, SessionError> {
        let stop = self.stop.clone();
        loop {
            tokio::select! {
                asked = orders.recv() => {
                    let Some((order, answer)) = asked else {
                        return self.leave().await;
                    };
                    let done = self.execute(order).await?;
                    // Who asked waits for it.
                    let _ = answer.send(done);
                    if let SessionReply::Left { has_failed } = done {
                        return Ok(has_failed);
                    }
                }
                message = self.primary.next() => self.take(&message?),
                reply = self.interpreter.next() => self.late(reply?),
                line = self.printed.next() => self.print(&line),
                () = stop.cancelled() => return Err(self.stopped().await?),
            }
        }
    }

    async fn execute(&mut self, order: SessionCommand) -> Result<SessionReply, SessionError> {
        match order {
            SessionCommand::Statement(text) => return self.statement(&text).await,
            SessionCommand::Word(word) => {
                let number = self.ask(word).await?;
                match self.voice.is_some() {
                    true => show(&format!("  {}: {number}", word.text())),
                    false => show(&format!("state: {number}: {}", word.text())),
                }
            }
            SessionCommand::State => self.show_state().await?,
            SessionCommand::Variables(names) => {
                let values = dashboard::variables(&self.dashboard, &names).await;
                for (name, value) in names.iter().zip(values) {
                    match value {
                        Some(value) => show(&format!("  {name} = {}", EscapedText(&value))),
                        None => show_text(&text!(
                            "  {name}: not told; robots tell globals only, and --set NAME=VALUE makes one",
                            "  {name}：未知；机器人只报告全局变量，用 --set NAME=VALUE 可以创建"
                        )),
                    }
                }
            }
            SessionCommand::Log(count) => {
                let first = self.reports.len().saturating_sub(count);
                self.reports.iter().skip(first).for_each(|line| show(line));
            }
            SessionCommand::Leave => {
                let has_failed = self.leave().await?;
                return Ok(SessionReply::Left { has_failed });
            }
        }
        Ok(SessionReply::Done)
    }

    /// Begins the program that holds interpreter mode, unless another program runs.
    async fn enter(&mut self) -> Result<(), SessionError> {
        let running = self.fresh_state().await?;
        if running {
            return Err(SessionError::Busy(self.primary.address().clone()));
        }
        let before = self.reports.len();
        let program = interpreter::interpreter_program(NAME, &self.body);
        self.primary.send(&program).await?;
        let deadline = Instant::now() + BEGIN_PATIENCE;
        loop {
            if let Some(report) = self.reports.get(before) {
                return Err(SessionError::Failed(report.clone()));
            }
            if self.is_running() {
                (self.is_entered, self.over_since) = (true, None);
                return Ok(());
            }
            let Ok(message) = timeout_at(deadline, self.primary.next()).await else {
                let address = self.primary.address().clone();
                return Err(SessionError::NotBegun(address));
            };
            self.take(&message?);
        }
    }

    /// Waits for a state; whether a program runs.
    async fn fresh_state(&mut self) -> Result<bool, SessionError> {
        loop {
            let message = self.primary.next().await?;
            self.take(&message);
            if matches!(message, Message::State(_)) {
                return Ok(self.is_running());
            }
        }
    }

    fn is_running(&self) -> bool {
        let mode = self.state.as_ref().and_then(|state| state.mode.as_ref());
        mode.is_some_and(|mode| mode.is_task_running)
    }

    /// Whether the session's program has ended, and its last error has come.
    fn is_over(&self) -> bool {
        self.over_since
            .is_some_and(|since| since.elapsed() >= LAST_WORDS)
    }

    async fn statement(&mut self, text: &str) -> Result<SessionReply, SessionError> {
        // In a pipe what follows an error is not for a program that knows nothing of what was before it.
        if self.is_over() && self.voice.is_some() {
            show_text(&text!(
                "  the program on the robot has ended; a new one begins, with none of its variables",
                "  机器人上的程序已结束；将启动新程序，原有变量不再存在"
            ));
            self.enter().await?;
        }
        while let Some(reply) = self.interpreter.try_next().await? {
            self.late(reply);
        }
        let sent = match self.printed.is_connected() {
            true => shown_value::with_value(text),
            false => None,
        };
        self.interpreter
            .send(sent.as_deref().unwrap_or(text))
            .await?;
        let stop = self.stop.clone();
        let mut patience = Instant::now() + REPLY_PATIENCE;
        loop {
            tokio::select! {
                reply = self.interpreter.next() => {
                    if let Some(answer) = self.answered(reply?, text) {
                        return Ok(answer);
                    }
                }
                message = self.primary.next() => self.take(&message?),
                line = self.printed.next() => self.print(&line),
                () = sleep_until(patience) => {
                    // The statement may wait until a clear_interpreter() before it is executed (manual 2.5); the robot
                    // answers a state request all the same.
                    let mut beside = Vec::new();
                    let asked = self.interpreter.ask(InterpreterRequest::Unexecuted, WORD_PATIENCE, &mut beside);
                    let waiting = asked.await?;
                    for reply in beside {
                        if let Some(answer) = self.answered(reply, text) {
                            return Ok(answer);
                        }
                    }
                    if waiting == 0 {
                        let address = self.interpreter.address().clone();
                        return Err(SessionError::Unanswered(address));
                    }
                    patience = Instant::now() + REPLY_PATIENCE;
                }
                () = stop.cancelled() => return Err(self.stopped().await?),
            }
        }
    }

    /// What a reply says of the statement that waits for one; nothing if it is not its.
    fn answered(&mut self, reply: Reply, text: &str) -> Option<SessionReply> {
        let answer = match &reply {
            Reply::Ack { .. } if self.last.as_ref() == Some(&reply) => return None,
            Reply::Ack { .. } => Some(SessionReply::Done),
            Reply::Discard { .. } => Some(SessionReply::Discarded),
            Reply::State { .. } | Reply::Other(_) => None,
        };
        self.has_failed |= answer == Some(SessionReply::Discarded);
        self.tell(&reply, text);
        if answer.is_some() {
            self.last = Some(reply);
        }
        answer
    }

    /// Shows a reply: as the port gives it in a pipe, in short beside the line at a terminal.
    fn tell(&self, reply: &Reply, text: &str) {
        let is_terminal = self.voice.is_some();
        match reply {
            Reply::Ack { id, .. } if is_terminal => show(&format!("  ack {id}")),
            Reply::Ack { id, statement } => {
                let statement = shown_value::typed(statement).unwrap_or(statement);
                show(&format!("ack: {id}: {}", EscapedText(statement)));
            }
            Reply::Discard { about } if is_terminal => {
                let about = shown_value::in_reply(about, text);
                let reason = about.strip_suffix(text.trim()).unwrap_or(&about);
                let reason = reason.trim_end().trim_end_matches(':').trim_end();
                show_text(&text!(
                    "  discarded: {}",
                    "  已丢弃：{}",
                    EscapedText(reason)
                ));
            }
            Reply::Discard { about } => {
                let about = shown_value::in_reply(about, text);
                show(&format!("discard: {}", EscapedText(&about)));
            }
            Reply::State { number, word } => {
                show(&format!("state: {number}: {}", EscapedText(word)));
            }
            Reply::Other(line) => show(&format!("{}", EscapedText(line))),
        }
    }

    /// A reply that nobody waits for: an accepted statement is thrown away after all, or a reply comes twice.
    fn late(&mut self, reply: Reply) {
        if self.last.as_ref() == Some(&reply) {
            return;
        }
        if let Reply::Discard { about } = &reply {
            self.has_failed = true;
            let line = text!("discarded: {}", "已丢弃：{}", EscapedText(about));
            self.say(line.in_language(language::chosen()));
        }
    }

    async fn ask(&mut self, word: InterpreterRequest) -> Result<u64, SessionError> {
        let mut beside = Vec::new();
        let asked = self.interpreter.ask(word, WORD_PATIENCE, &mut beside);
        let number = asked.await?;
        for reply in beside {
            self.late(reply);
        }
        Ok(number)
    }

    async fn show_state(&mut self) -> Result<(), SessionError> {
        self.fresh_state().await?;
        let numbers = [
            InterpreterRequest::LastExecuted,
            InterpreterRequest::LastInterpreted,
            InterpreterRequest::Unexecuted,
        ];
        let mut counts = [0; 3];
        for (count, word) in counts.iter_mut().zip(numbers) {
            *count = self.ask(word).await?;
        }
        let Some(state) = &self.state else {
            return Ok(());
        };
        described(state).iter().for_each(show_text);
        let [executed, accepted, waiting] = counts;
        show_text(&text!(
            "  statements: {executed} was carried out last, {accepted} accepted last, {waiting} wait",
            "  语句：最后执行 {executed}，最后接收 {accepted}，等待 {waiting} 条"
        ));
        Ok(())
    }

    /// What port 30001 says.
    fn take(&mut self, message: &Message) {
        match message {
            Message::State(state) => {
                self.state = Some((**state).clone());
                if self.is_running() {
                    self.over_since = None;
                } else if self.is_entered {
                    self.over_since.get_or_insert_with(Instant::now);
                }
            }
            Message::Exception(exception) => self.report(exception),
            Message::Unknown(_) => {}
        }
    }

    fn report(&mut self, told: &RobotException) {
        let since = self.begun.elapsed().as_secs_f64();
        let (is_failure, text) = match &told.exception {
            Exception::Script { text, .. } => {
                let told = shown_value::in_report(text.trim(), NAME);
                (!text.starts_with("[SEC]"), told)
            }
            Exception::Robot {
                code,
                sub_code,
                level,
                data,
            } => {
                let (code, sub_code) = (*code, *sub_code);
                let numbered = RobotErrorDisplay {
                    code,
                    sub_code,
                    data,
                };
                let source = ExceptionSource::name(told.source);
                let text = format!("{source}: {} {numbered}", level.name());
                (
                    matches!(level, ExceptionLevel::Error | ExceptionLevel::Fatal),
                    text,
                )
            }
        };
        self.has_failed |= is_failure;
        let text = EscapedLines(&text).to_string();
        if self.reports.len() == REPORTS_MAX {
            self.reports.pop_front();
        }
        self.reports.push_back(format!("{since:9.3} s  {text}"));
        self.say(&text);
    }

    /// A line that a statement printed.
    fn print(&mut self, line: &str) {
        let line = EscapedLines(line).to_string();
        match &mut self.voice {
            Some(voice) => voice(format!("{line}\n")),
            None => show(&line),
        }
    }

    /// Something that nobody asked for.
    fn say(&mut self, text: &str) {
        match &mut self.voice {
            Some(voice) => voice(format!("{text}\n")),
            None => logging::say(text),
        }
    }

    /// Leaves interpreter mode once everything before is done. True if something failed.
    async fn leave(&mut self) -> Result<bool, SessionError> {
        let stop = self.stop.clone();
        self.fresh_state().await?;
        if self.over_since.is_none() {
            self.interpreter.send(END_INTERPRETER_STATEMENT).await?;
        }
        while !self.is_over() {
            tokio::select! {
                message = self.primary.next() => self.take(&message?),
                line = self.printed.next() => self.print(&line),
                reply = self.interpreter.next() => self.late_but_the_last(reply?),
                () = stop.cancelled() => return Err(self.stopped().await?),
            }
        }
        Ok(self.has_failed)
    }

    /// The program may have ended before it was told to.
    fn late_but_the_last(&mut self, reply: Reply) {
        let is_of_it = matches!(&reply, Reply::Discard { about } if about.ends_with(END_INTERPRETER_STATEMENT));
        if !is_of_it {
            self.late(reply);
        }
    }

    /// Ctrl-C: the robot is stopped first.
    async fn stopped(&mut self) -> Result<SessionError, SessionError> {
        if self.is_over() {
            return Ok(SessionError::Stopped(text!(
                "the shell was ended",
                "交互会话已结束"
            )));
        }
        language::say(&text!(
            "stopping the program on the robot",
            "正在停止机器人上的程序"
        ));
        Ok(SessionError::Stopped(
            robot_consent::stop(&mut self.primary).await?,
        ))
    }
}
