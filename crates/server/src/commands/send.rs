//! `eliteserver send`: a program to a controller's port 30001, followed to its end.
//!
//! Owns the conversation and what a person sees of it. How a file becomes what is sent, and where places of the one are
//! in the other, is `program`'s business; what the stream means is `robot-client`'s.

mod program;
mod screen;

use std::io::IsTerminal;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

use elite_lang::{Severity, SourceFile, check, compile};
use robot_client::dashboard;
use robot_client::{Follower, News, Outcome, Primary, PrimaryError, RobotAddress};
use thiserror::Error;
use tokio::time::{Instant, MissedTickBehavior, interval, timeout};
use wire::primary::{ErrorData, Exception, Message, RobotException, Source};

use crate::cli::{RobotArgs, SendArgs};
use crate::commands::check::read_script;
use crate::logging;
use crate::ports::shown::{Escaped, Lines};
use crate::shutdown::Shutdown;
use program::{Outgoing, SendError, Setting};
use screen::Screen;

/// Exit status of a program that failed or was stopped.
const FAILED: u8 = 1;
/// Exit status when nothing was sent, or what came of it is not known.
const NOT_SENT: u8 = 2;
/// After Ctrl-C the robot has this long to stop its program.
const STOP_PATIENCE: Duration = Duration::from_secs(3);
/// The moments between messages are looked at so often.
const TICK: Duration = Duration::from_millis(50);

/// Why nothing was sent; each is a sentence.
#[derive(Debug, Error)]
enum Refusal {
    #[error("{0}")]
    Sentence(String),
    #[error(transparent)]
    Program(#[from] SendError),
    #[error(transparent)]
    Primary(#[from] PrimaryError),
    #[error(
        "{0} is in local mode: it takes no programs from outside. Switch it to remote control first"
    )]
    Local(RobotAddress),
    #[error("nothing was sent")]
    Declined,
    #[error("cannot start: {0}")]
    Start(#[from] std::io::Error),
}

/// Exit status: 0 ended, 1 failed or stopped, 2 not sent.
pub fn send(args: &SendArgs) -> ExitCode {
    let status = Shutdown::start(FAILED)
        .map_err(Refusal::from)
        .and_then(|shutdown| {
            let runtime = tokio::runtime::Builder::new_current_thread()
                .enable_all()
                .build()?;
            runtime.block_on(conversation(args, &shutdown))
        });
    ExitCode::from(status.unwrap_or_else(|refusal| {
        logging::say(&format!("eliteserver: {refusal}"));
        NOT_SENT
    }))
}

async fn conversation(args: &SendArgs, shutdown: &Shutdown) -> Result<u8, Refusal> {
    let settings: Result<Vec<Setting>, _> =
        args.set.iter().map(|given| Setting::parse(given)).collect();
    let (file, outgoing) = prepared(args, &settings?)?;
    let address = RobotAddress::new(&args.robot.robot, args.robot.primary_port);
    agreed(
        &args.robot,
        &address,
        &format!("Send {} to", Escaped(file.name())),
    )
    .await?;
    if dashboard::is_remote(&address.with_port(args.robot.dashboard_port)).await == Some(false) {
        return Err(Refusal::Local(address));
    }
    let mut robot = Primary::connect(&address).await?;
    // Until its stream is seen it may be anything that listens.
    robot.next().await?;
    robot.send(&outgoing.text).await?;
    logging::say(&format!(
        "sent {} to the robot at {address}",
        Escaped(file.name())
    ));
    if args.no_wait || outgoing.is_secondary {
        return Ok(0);
    }
    let mut followed = Followed {
        file,
        outgoing,
        screen: Screen::new(std::io::stderr().is_terminal()),
    };
    match followed.follow(&mut robot, shutdown).await {
        Ok(status) => Ok(status),
        Err(error) => {
            followed
                .screen
                .line(&format!("eliteserver: {error}; the program may go on"));
            Ok(NOT_SENT)
        }
    }
}

/// Reads and checks the file, and makes of it what is sent.
fn prepared(args: &SendArgs, settings: &[Setting]) -> Result<(Arc<SourceFile>, Outgoing), Refusal> {
    let script = read_script(&args.file).map_err(Refusal::Sentence)?;
    let known = elite_runtime::builtins::known_names();
    let file = SourceFile::new(script.name, script.text);
    if args.no_check {
        return Ok((file.clone(), Outgoing::unchecked(&file, settings)?));
    }
    let set = |name: &str| settings.iter().any(|setting| setting.name() == name);
    for finding in check(file.clone(), &known) {
        let is_error = finding.severity == Severity::Error;
        let is_set = finding.code == "undefined-name" && set(file.slice(finding.span));
        if !is_error && is_set {
            continue;
        }
        for line in elite_lang::render_human(&finding, &file, false)
            .trim_end()
            .lines()
        {
            logging::say(&Lines(line).to_string());
        }
    }
    let program = compile(file.clone(), &known).map_err(|_| {
        Refusal::Sentence(format!(
            "{} does not compile; nothing was sent",
            Escaped(file.name())
        ))
    })?;
    let outgoing = Outgoing::new(&program, settings)?;
    Ok((file, outgoing))
}

/// Whoever sits at a terminal is asked before a robot that is not this machine moves.
async fn agreed(args: &RobotArgs, address: &RobotAddress, what: &str) -> Result<(), Refusal> {
    if args.yes || address.is_this_machine().await || !std::io::stdin().is_terminal() {
        return Ok(());
    }
    logging::say(&format!(
        "{what} the robot at {address}? It may move. [y/N]"
    ));
    let mut answer = String::new();
    std::io::stdin().read_line(&mut answer)?;
    match answer.trim() {
        "y" | "Y" | "yes" => Ok(()),
        _ => Err(Refusal::Declined),
    }
}

/// A program that was sent.
struct Followed {
    file: Arc<SourceFile>,
    outgoing: Outgoing,
    screen: Screen,
}

impl Followed {
    async fn follow(
        &mut self,
        robot: &mut Primary,
        shutdown: &Shutdown,
    ) -> Result<u8, PrimaryError> {
        let sent = Instant::now();
        let mut follower = Follower::new();
        let mut ticks = interval(TICK);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
        loop {
            let message = tokio::select! {
                message = robot.next() => message?,
                () = shutdown.token().cancelled() => return self.stop(robot).await,
                _ = ticks.tick() => Message::Unknown(0),
            };
            if let Message::State(state) = &message {
                self.screen.state(state, sent.elapsed());
            }
            for news in follower.take(&message, sent.elapsed()) {
                match news {
                    News::Began => {}
                    News::Paused => self.screen.line("the program is paused"),
                    News::Resumed => self.screen.line("the program goes on"),
                    News::Exception(exception) => self.tell(&exception),
                    News::Over(outcome) => {
                        self.screen.end();
                        return Ok(match outcome {
                            Outcome::Ended => 0,
                            Outcome::Failed => FAILED,
                        });
                    }
                }
            }
        }
    }

    /// Ctrl-C: the robot is stopped first.
    async fn stop(&mut self, robot: &mut Primary) -> Result<u8, PrimaryError> {
        self.screen.line("stopping the program on the robot");
        robot.send("stop task\n").await?;
        let standing = async {
            loop {
                if let Message::State(state) = robot.next().await?
                    && state.mode.is_some_and(|mode| !mode.is_task_running)
                {
                    return Ok::<(), PrimaryError>(());
                }
            }
        };
        match timeout(STOP_PATIENCE, standing).await {
            Ok(stood) => {
                stood?;
                self.screen.line("the program was stopped");
            }
            Err(_) => self.screen.line(&format!(
                "the robot still runs its program {} s after it was told to stop",
                STOP_PATIENCE.as_secs()
            )),
        }
        self.screen.end();
        Ok(FAILED)
    }

    fn tell(&mut self, told: &RobotException) {
        match &told.exception {
            Exception::Script { line, column, text } => {
                let place = self.outgoing.place(*line, *column);
                let name = Escaped(self.file.name());
                for part in text.lines().filter(|part| !part.trim().is_empty()) {
                    self.screen.line(&Lines(part).to_string());
                }
                let Some((line, column)) = place else { return };
                // A controller's text may say nothing of the place, or of lines that the file does not have.
                self.screen.line(&format!("  at {name}:{line}:{column}"));
                if line <= self.file.line_count() {
                    let text = self.file.line_text(line);
                    self.screen.line(&format!("  | {}", Lines(text.trim_end())));
                }
            }
            Exception::Robot {
                code,
                sub_code,
                level,
                data,
            } => {
                let source = Source::name(told.source);
                let level = format!("{level:?}").to_lowercase();
                let about = match data {
                    ErrorData::None => String::new(),
                    ErrorData::Unsigned(value) => format!(": {value}"),
                    ErrorData::Signed(value) => format!(": {value}"),
                    ErrorData::Float(value) => format!(": {value}"),
                    ErrorData::Hex(value) => format!(": {value:#x}"),
                    ErrorData::Text(text) => format!(": {}", Escaped(text)),
                    ErrorData::Joint(joint) => format!(": joint {}", joint.saturating_add(1)),
                };
                self.screen
                    .line(&format!("{source}: {level} {code}.{sub_code}{about}"));
            }
        }
    }
}
