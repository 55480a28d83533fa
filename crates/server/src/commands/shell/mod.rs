//! `eliteserver shell`: statements that a robot carries out as they are typed, through interpreter mode.
//!
//! Owns the prompt, the shell's own orders and the exit status. What lines become is `statement_reader`'s business,
//! where they come from `line_input`'s, the conversation `session`'s.

mod output;
mod session;
mod shown_value;
mod statement_reader;

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::io::{IsTerminal, stdin, stdout};
use std::rc::Rc;
use std::time::Duration;

use elite_runtime::{Preset, PresetError};
use elite_syntax::{SourceFile, compile};
use messages::{Localized, Text, text};
use robot_client::{InterpreterRequest, RobotAddress, dashboard};
use supervision::{ThreadHandle, ThreadRole, ThreadSupervisor};
use thiserror::Error;
use tokio::runtime::Runtime;
use tokio::sync::mpsc;

use crate::cli::ShellArgs;
use crate::command::{CommandResult, CommandStatus};
use crate::commands::line_input::{CompletionNames, InputLine, LineCommands, LineSource};
use crate::commands::program_output::{self, ProgramOutput};
use crate::commands::robot_consent;
use crate::language::{self, shown};
use crate::logging;
use crate::shutdown::Shutdown;

use output::{show, show_text};
use session::{SessionCommand, SessionError, SessionReply, SessionRequest, ShellSession};
use statement_reader::StatementReader;

/// Exit status of a pipe of which something was discarded or failed, and of a session that was stopped.
const FAILED: CommandStatus = CommandStatus::Negative;
/// Exit status without a connection.
const NO_CONNECTION: CommandStatus = CommandStatus::NotDone;
/// What was said is shown within this.
const SAID: Duration = Duration::from_millis(100);
/// Reports that `:log` shows.
const LOG_LINES: usize = 20;

/// The shell's own orders.
const ORDERS: [(&str, Text); 7] = [
    (
        "abort",
        Text::fixed(
            "stop the movej or movel that the arm does",
            "停止机械臂正在执行的 movej 或 movel",
        ),
    ),
    ("help", Text::fixed("this list", "本列表")),
    (
        "log",
        Text::fixed(
            "the last reports of the robot: errors, alarms; :log 100 for more",
            "机器人最近的报告：错误、报警；:log 100 显示更多",
        ),
    ),
    (
        "quit",
        Text::fixed(
            "end, once everything before is done (Ctrl-D as well)",
            "前面的语句都完成后退出（也可按 Ctrl-D）",
        ),
    ),
    (
        "skip",
        Text::fixed("drop the statements that wait", "丢弃等待中的语句"),
    ),
    (
        "state",
        Text::fixed(
            "how the robot is, and which statement it is at",
            "机器人的状态，以及执行到哪条语句",
        ),
    ),
    (
        "vars",
        Text::fixed(
            "variables of this session, or :vars NAME NAME",
            "本次会话的变量，或 :vars NAME NAME",
        ),
    ),
];

/// A reason why there is no shell, told in a sentence.
#[derive(Debug, Error, Localized)]
enum ShellError {
    #[error("cannot start: {0}")]
    #[zh("无法启动：{0}")]
    Start(#[from] std::io::Error),
    #[error(transparent)]
    Setting(#[from] PresetError),
    #[error(transparent)]
    Refused(#[from] robot_consent::ConsentError),
    #[error(transparent)]
    Session(#[from] SessionError),
}

/// Exit status: 0 ended, 1 a line of a pipe was discarded or failed, 2 no connection.
pub fn shell(args: &ShellArgs) -> CommandResult {
    Ok(open_shell(args)?)
}

fn open_shell(args: &ShellArgs) -> Result<CommandStatus, ShellError> {
    let settings = Preset::parse_all(&args.set)?;
    let shutdown = Shutdown::start_within(FAILED, robot_consent::END_PATIENCE)?;
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()?;
    let opened = opened(args, &settings, &shutdown);
    let mut session = runtime.block_on(opened)?;

    let mut names: BTreeSet<String> = elite_syntax::python_names::builtin_names()
        .map(str::to_owned)
        .collect();
    names.extend(elite_runtime::builtins::all().map(|builtin| builtin.name.to_owned()));
    let names: CompletionNames = Rc::new(RefCell::new(names));
    let is_terminal = stdin().is_terminal() && stdout().is_terminal();
    let own = LineCommands {
        history: "shell_history",
        orders: ORDERS.map(|(order, _)| format!(":{order}")).into(),
    };
    let mut lines = LineSource::open(is_terminal, &names, own);
    session.set_notifier(lines.voice());
    if lines.is_terminal() {
        // Before the first prompt.
        logging::flush_within(SAID);
        show_text(&text!(
            "Statements are carried out at once. :help lists the shell's own orders, :quit ends.",
            "语句立即执行。:help 列出本程序的命令，:quit 退出。"
        ));
    }
    let mut shell = Shell {
        link: SessionThread::start(session, runtime, shutdown, lines.is_terminal())?,
        typed: StatementReader::default(),
        names,
        own: settings.iter().map(|one| one.name().to_owned()).collect(),
        is_terminal: lines.is_terminal(),
        has_failed: false,
    };
    Ok(shell.run(&mut lines))
}

async fn opened(
    args: &ShellArgs,
    settings: &[Preset],
    shutdown: &Shutdown,
) -> Result<ShellSession, ShellError> {
    let robot = &args.robot;
    let address = RobotAddress::new(&robot.robot, robot.primary_port);
    robot_consent::ask_consent(
        robot,
        &address,
        &text!("Open a shell on", "打开交互会话，连接"),
    )
    .await?;
    let mut body = String::new();
    for setting in settings {
        body.push_str(&format!("\tglobal {}\n", setting.name()));
    }
    for setting in settings {
        body.push_str(&format!("\t{}\n", setting.statement()));
    }
    let statements = address.with_port(robot.interpreter_port);
    let dashboard = address.with_port(robot.dashboard_port);
    let is_ours = dashboard::is_simulated(&dashboard).await;
    let http = args.output.port(robot).filter(|_| is_ours);
    let http = http.map(|port| address.with_port(port));
    let printed = ProgramOutput::connect(http.as_ref(), session::NAME).await;
    if printed.is_connected() {
        body.push_str(shown_value::DEFINITION);
    }
    let stop = shutdown.token().clone();
    let session = ShellSession::open(&address, &statements, dashboard, body, printed, stop).await?;
    language::say(&text!(
        "interpreter mode of the robot at {address}",
        "机器人 {address} 的解释器模式"
    ));
    if !session.shows_output() {
        logging::say(program_output::elsewhere());
    }
    Ok(session)
}

/// The session's thread.
struct SessionThread {
    orders: mpsc::Sender<SessionRequest>,
    /// Ends with the exit status when the session is over before it is left.
    thread: Option<ThreadHandle<CommandStatus>>,
}

impl SessionThread {
    fn start(
        mut session: ShellSession,
        runtime: Runtime,
        shutdown: Shutdown,
        is_terminal: bool,
    ) -> std::io::Result<Self> {
        let (orders, mut asked) = mpsc::channel(1);
        let thread =
            ThreadSupervisor::default().start(ThreadRole::Service, "session", move || {
                let (status, error) = match runtime.block_on(session.serve(&mut asked)) {
                    Ok(has_failed) => return CommandStatus::of_answer(!has_failed),
                    Err(error @ SessionError::Stopped(_)) => (FAILED, error),
                    Err(error) => (NO_CONNECTION, error),
                };
                language::say(&text!("eliteserver: {error}", "eliteserver: {error}"));
                // Whoever waits for a line of a pipe is not told in any other way; a terminal is to be left in order.
                match is_terminal {
                    true => language::say(&text!("press Enter", "请按回车键")),
                    false => shutdown.begin(status),
                }
                status
            })?;
        let thread = Some(thread);
        Ok(Self { orders, thread })
    }

    /// Has something done; the exit status if the session is over.
    fn ask(&mut self, order: SessionCommand) -> Result<SessionReply, CommandStatus> {
        let (sender, answer) = std::sync::mpsc::sync_channel(1);
        let is_taken = self.orders.blocking_send((order, sender)).is_ok();
        let answer = is_taken.then(|| answer.recv().ok()).flatten();
        answer.ok_or_else(|| {
            let status = self.thread.take().map(ThreadHandle::join);
            // A fault of ours in that thread has been told.
            status.and_then(Result::ok).unwrap_or(NO_CONNECTION)
        })
    }
}

/// The prompt.
struct Shell {
    link: SessionThread,
    typed: StatementReader,
    names: CompletionNames,
    /// Variables of this session.
    own: BTreeSet<String>,
    is_terminal: bool,
    has_failed: bool,
}

impl Shell {
    fn run(&mut self, lines: &mut LineSource) -> CommandStatus {
        loop {
            let prompt = if self.typed.is_open() { "... " } else { "> " };
            let done = match lines.next(prompt) {
                InputLine::Text(text) => self.line(&text),
                InputLine::Interrupt if self.typed.is_open() => {
                    self.typed.forget();
                    Ok(None)
                }
                // What somebody who presses it wants most.
                InputLine::Interrupt => self
                    .link
                    .ask(SessionCommand::Word(InterpreterRequest::Abort))
                    .map(Some),
                InputLine::TooLong => {
                    self.complain(&text!(
                        "a line of more than 64 KiB is no statement",
                        "超过 64 KiB 的一行不是语句"
                    ));
                    Ok(None)
                }
                InputLine::Broken(error) => {
                    self.complain(&text!(
                        "no more lines can be read: {error}",
                        "无法继续读取输入：{error}"
                    ));
                    self.quit().map(Some)
                }
                InputLine::End => self.quit().map(Some),
            };
            match done {
                Err(status) => return status,
                Ok(Some(SessionReply::Left { has_failed })) => {
                    let has_failed = has_failed || self.has_failed;
                    return CommandStatus::of_answer(self.is_terminal || !has_failed);
                }
                Ok(_) => {}
            }
        }
    }

    fn line(&mut self, text: &str) -> Result<Option<SessionReply>, CommandStatus> {
        if let Some(order) = text.trim().strip_prefix(':')
            && !self.typed.is_open()
        {
            return self.order(order);
        }
        let Some(statement) = self.typed.line(text) else {
            return Ok(None);
        };
        self.statement(statement).map(Some)
    }

    fn statement(
        &mut self,
        typed: Result<String, statement_reader::StatementError>,
    ) -> Result<SessionReply, CommandStatus> {
        match typed {
            Ok(text) => {
                // A word is answered at once and waits for nothing.
                if let Some(word) = InterpreterRequest::parse(&text) {
                    return self.link.ask(SessionCommand::Word(word));
                }
                let answer = self.link.ask(SessionCommand::Statement(text.clone()))?;
                if answer == SessionReply::Done {
                    self.remember(&text);
                }
                Ok(answer)
            }
            Err(error) => {
                self.complain(&error);
                Ok(SessionReply::Discarded)
            }
        }
    }

    /// Names that the statement makes are completed from now on.
    fn remember(&mut self, text: &str) {
        let known = elite_runtime::builtins::known_names();
        let file = SourceFile::new("shell", format!("{text}\n"));
        // The robot has accepted it; it may know more than we do.
        let Ok(program) = compile(file, &known) else {
            return;
        };
        for name in program.global_names() {
            self.own.insert(name.to_owned());
            self.names.borrow_mut().insert(name.to_owned());
        }
    }

    fn order(&mut self, order: &str) -> Result<Option<SessionReply>, CommandStatus> {
        let mut words = order.split_whitespace();
        let name = words.next().unwrap_or_default();
        let rest: Vec<String> = words.map(str::to_owned).collect();
        let takes_more = matches!(name, "vars" | "log");
        if !takes_more && !rest.is_empty() {
            self.complain(&text!(
                ":{name} takes nothing behind it",
                ":{name} 后面不能有内容"
            ));
            return Ok(None);
        }
        let order = match name {
            "abort" => SessionCommand::Word(InterpreterRequest::Abort),
            "skip" => SessionCommand::Word(InterpreterRequest::Skip),
            "state" => SessionCommand::State,
            "vars" if rest.is_empty() => {
                SessionCommand::Variables(self.own.iter().cloned().collect())
            }
            "vars" => SessionCommand::Variables(rest),
            "log" => match rest.first().map_or(Ok(LOG_LINES), |count| count.parse()) {
                Ok(count) if rest.len() < 2 => SessionCommand::Log(count),
                _ => {
                    self.complain(&text!(
                        ":log takes how many lines, as :log 100",
                        ":log 后面是行数，如 :log 100"
                    ));
                    return Ok(None);
                }
            },
            "quit" => return self.quit().map(Some),
            "help" => {
                for (order, what) in ORDERS {
                    show(&format!("  :{order:6} {}", shown(&what)));
                }
                return Ok(None);
            }
            other => {
                let orders = ORDERS.map(|(order, _)| format!(":{order}")).join(", ");
                self.complain(&text!(
                    "there is no :{other}; there are {orders}",
                    "没有 :{other}；可用的有 {orders}"
                ));
                return Ok(None);
            }
        };
        self.link.ask(order).map(Some)
    }

    /// What is wrong with a line that is not sent.
    fn complain(&mut self, sentence: &impl Localized) {
        self.has_failed = true;
        match self.is_terminal {
            true => show(&format!("  {}", shown(sentence))),
            false => language::say(&text!("eliteserver: {sentence}", "eliteserver: {sentence}")),
        }
    }

    fn quit(&mut self) -> Result<SessionReply, CommandStatus> {
        if let Some(last) = self.typed.finish() {
            self.statement(last)?;
        }
        self.link.ask(SessionCommand::Leave)
    }
}
