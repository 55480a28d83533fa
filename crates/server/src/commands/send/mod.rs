//! `eliteserver send`: a program to a controller's port 30001, followed to its end.
//!
//! Owns the conversation and what a person sees of it. How a file becomes what is sent, and where places of the one are
//! in the other, is `program`'s business; what the stream means is `robot-client`'s.

mod program;
mod rtsi_progress;
mod screen;

use std::io::IsTerminal;
use std::sync::Arc;
use std::time::Duration;

use elite_runtime::{Preset, PresetError};
use elite_syntax::{Severity, SourceFile, check, compile};
use messages::{Localized, Text, text};
use robot_client::{
    MonitorOutcome, PrimaryClient, PrimaryError, ProgramEvent, ProgramMonitor, RobotAddress,
    dashboard,
};
use thiserror::Error;
use tokio::sync::watch;
use tokio::time::{Instant, MissedTickBehavior, interval, timeout};
use wire::primary::{Exception, ExceptionSource, Message, RobotErrorDisplay, RobotException};

use crate::cli::SendArgs;
use crate::command::{CommandResult, CommandStatus};
use crate::commands::check::read_script;
use crate::commands::program_output::{self, ProgramOutput};
use crate::commands::robot_consent;
use crate::language;
use crate::logging;
use crate::ports::escape::{EscapedLines, EscapedText};
use crate::shutdown::Shutdown;
use program::{OutgoingProgram, WrapError};
use rtsi_progress::{NodeTracker, RtsiProgress, listen};
use screen::ProgressLine;

/// Exit status of a program that failed or was stopped.
const FAILED: CommandStatus = CommandStatus::Negative;
/// Exit status when nothing was sent, or what came of it is not known.
const NOT_SENT: CommandStatus = CommandStatus::NotDone;
/// The moments between messages are looked at so often.
const TICK: Duration = Duration::from_millis(50);

/// What the program has printed last may be on its way for so long after its end.
const LAST_LINES: Duration = Duration::from_millis(120);

/// A reason why nothing was sent, told in a sentence.
#[derive(Debug, Error, Localized)]
enum SendError {
    #[error("{0}")]
    Sentence(Text),
    #[error(transparent)]
    Program(#[from] WrapError),
    #[error(transparent)]
    Primary(#[from] PrimaryError),
    #[error(transparent)]
    Refused(#[from] robot_consent::ConsentError),
    #[error(transparent)]
    Setting(#[from] PresetError),
    #[error("cannot start: {0}")]
    #[zh("无法启动：{0}")]
    Start(#[from] std::io::Error),
}

/// Exit status: 0 ended, 1 failed or stopped, 2 not sent.
pub fn send(args: &SendArgs) -> CommandResult {
    let status = Shutdown::start_within(FAILED, robot_consent::END_PATIENCE)
        .map_err(SendError::from)
        .and_then(|shutdown| {
            let runtime = tokio::runtime::Builder::new_current_thread()
                .enable_all()
                .build()?;
            runtime.block_on(conversation(args, &shutdown))
        });
    Ok(status?)
}

async fn conversation(args: &SendArgs, shutdown: &Shutdown) -> Result<CommandStatus, SendError> {
    let settings = Preset::parse_all(&args.set)?;
    let (file, mut outgoing) = prepared(args, &settings)?;
    let address = RobotAddress::new(&args.robot.robot, args.robot.primary_port);
    let what = text!("Send {} to", "把 {} 发送到", EscapedText(file.name()));
    robot_consent::ask_consent(&args.robot, &address, &what).await?;
    let is_ours = dashboard::is_simulated(&address.with_port(args.robot.dashboard_port)).await;
    if is_ours {
        outgoing.name_the_file(file.name(), &settings);
    }
    let http = args.output.port(&args.robot).filter(|_| is_ours);
    let http = http.map(|port| address.with_port(port));
    let printed = ProgramOutput::connect(http.as_ref(), file.name()).await;
    let mut robot = PrimaryClient::connect(&address).await?;
    // Until its stream is seen it may be anything that listens.
    robot.next().await?;
    robot.send(&outgoing.text).await?;
    language::say(&text!(
        "sent {} to the robot at {address}",
        "已把 {} 发送到机器人 {address}",
        EscapedText(file.name())
    ));
    if args.no_wait || outgoing.is_secondary {
        return Ok(CommandStatus::Success);
    }
    if !printed.is_connected() && program_output::prints(file.text()) {
        logging::say(program_output::elsewhere());
    }
    let is_terminal = std::io::stderr().is_terminal();
    let mut followed = FollowedProgram {
        nodes: NodeTracker::of(&file),
        file,
        outgoing,
        screen: ProgressLine::new(is_terminal),
        printed,
    };
    let (sender, told) = watch::channel(RtsiProgress::default());
    let beside = async {
        match is_terminal {
            true => listen(address.with_port(args.robot.rtsi_port), sender).await,
            false => std::future::pending().await,
        }
    };
    let ended = tokio::select! {
        ended = followed.follow(&mut robot, &told, shutdown) => ended,
        () = beside => Ok(NOT_SENT),
    };
    match ended {
        Ok(status) => Ok(status),
        Err(error) => {
            followed.screen.text(&text!(
                "eliteserver: {error}; the program may go on",
                "eliteserver: {error}；程序可能仍在运行"
            ));
            Ok(NOT_SENT)
        }
    }
}

/// Reads and checks the file, and makes of it what is sent.
fn prepared(
    args: &SendArgs,
    settings: &[Preset],
) -> Result<(Arc<SourceFile>, OutgoingProgram), SendError> {
    let script = read_script(&args.file).map_err(SendError::Sentence)?;
    let known = elite_runtime::builtins::known_names();
    let file = SourceFile::new(script.name, script.text);
    if args.no_check {
        return Ok((file.clone(), OutgoingProgram::unchecked(&file, settings)?));
    }
    let set = |name: &str| settings.iter().any(|setting| setting.name() == name);
    for finding in check(file.clone(), &known) {
        let is_error = finding.severity == Severity::Error;
        let is_set = finding.code == "undefined-name" && set(file.slice(finding.span));
        if !is_error && is_set {
            continue;
        }
        for line in elite_syntax::render_human(&finding, &file, language::chosen(), false)
            .trim_end()
            .lines()
        {
            logging::say(&EscapedLines(line).to_string());
        }
    }
    let program = compile(file.clone(), &known).map_err(|_| {
        SendError::Sentence(text!(
            "{} does not compile; nothing was sent",
            "{} 无法编译；没有发送任何内容",
            EscapedText(file.name())
        ))
    })?;
    let outgoing = OutgoingProgram::new(&program, settings)?;
    Ok((file, outgoing))
}

/// A program that was sent.
struct FollowedProgram {
    nodes: NodeTracker,
    file: Arc<SourceFile>,
    outgoing: OutgoingProgram,
    screen: ProgressLine,
    printed: ProgramOutput,
}

impl FollowedProgram {
    async fn follow(
        &mut self,
        robot: &mut PrimaryClient,
        told: &watch::Receiver<RtsiProgress>,
        shutdown: &Shutdown,
    ) -> Result<CommandStatus, PrimaryError> {
        let sent = Instant::now();
        let mut follower = ProgramMonitor::new();
        let mut ticks = interval(TICK);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
        loop {
            let message = tokio::select! {
                message = robot.next() => message?,
                () = shutdown.token().cancelled() => return self.stop(robot).await,
                line = self.printed.next() => {
                    self.screen.output(&line);
                    continue;
                }
                _ = ticks.tick() => Message::Unknown(0),
            };
            if let Message::State(state) = &message {
                let told = *told.borrow();
                let place = self.doing(told.line);
                self.screen.state(state, told, &place, sent.elapsed());
            }
            for news in follower.handle_message(&message, sent.elapsed()) {
                match news {
                    ProgramEvent::Began => {}
                    ProgramEvent::Paused => self
                        .screen
                        .text(&text!("the program is paused", "程序暂停")),
                    ProgramEvent::Resumed => self
                        .screen
                        .text(&text!("the program goes on", "程序继续运行")),
                    ProgramEvent::Exception(exception) => self.tell(&exception),
                    ProgramEvent::Finished(outcome) => {
                        while let Ok(line) = timeout(LAST_LINES, self.printed.next()).await {
                            self.screen.output(&line);
                        }
                        self.screen.end();
                        return Ok(match outcome {
                            MonitorOutcome::Completed => CommandStatus::Success,
                            MonitorOutcome::Failed => FAILED,
                        });
                    }
                }
            }
        }
    }

    /// Where the program is, of the line that the controller tells: `, line 7, node 3 Approach`.
    fn doing(&self, line: Option<u32>) -> Text {
        let line = line.and_then(|line| i32::try_from(line).ok());
        let Some((line, _)) = line.and_then(|line| self.outgoing.place(line, 1)) else {
            return Text::verbatim("");
        };
        match self.nodes.at(line) {
            Some(node) => text!(
                ", line {line}, node {} {}",
                "，第 {line} 行，节点 {} {}",
                EscapedText(&node.number),
                EscapedText(&node.label)
            ),
            None => text!(", line {line}", "，第 {line} 行"),
        }
    }

    /// Ctrl-C: the robot is stopped first.
    async fn stop(&mut self, robot: &mut PrimaryClient) -> Result<CommandStatus, PrimaryError> {
        self.screen.text(&text!(
            "stopping the program on the robot",
            "正在停止机器人上的程序"
        ));
        let sentence = robot_consent::stop(robot).await?;
        self.screen.text(&sentence);
        self.screen.end();
        Ok(FAILED)
    }

    fn tell(&mut self, told: &RobotException) {
        match &told.exception {
            Exception::Script { line, column, text } => {
                let place = self.outgoing.place_of_error(*line, *column, text);
                let name = EscapedText(self.file.name());
                let text = self.outgoing.in_file(text, self.file.name());
                for part in text.lines().filter(|part| !part.trim().is_empty()) {
                    self.screen.line(&EscapedLines(part).to_string());
                }
                let Some((line, column)) = place else { return };
                // A controller's text may say nothing of the place, or of lines that the file does not have.
                self.screen.text(&text!(
                    "  at {name}:{line}:{column}",
                    "  位于 {name}:{line}:{column}"
                ));
                if line <= self.file.line_count() {
                    let text = self.file.line_text(line);
                    self.screen
                        .line(&format!("  | {}", EscapedLines(text.trim_end())));
                }
            }
            Exception::Robot {
                code,
                sub_code,
                level,
                data,
            } => {
                let (source, level) = (ExceptionSource::name(told.source), level.name());
                let (code, sub_code) = (*code, *sub_code);
                let numbered = RobotErrorDisplay {
                    code,
                    sub_code,
                    data,
                };
                let numbered = numbered.to_string();
                self.screen
                    .line(&format!("{source}: {level} {}", EscapedText(&numbered)));
            }
        }
    }
}
