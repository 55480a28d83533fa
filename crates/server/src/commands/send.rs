//! `eliteserver send`: a program to a controller's port 30001, followed to its end.
//!
//! Owns the conversation and what a person sees of it. How a file becomes what is sent, and where places of the one are
//! in the other, is `program`'s business; what the stream means is `robot-client`'s.

mod program;
mod screen;
mod watched;

use std::io::IsTerminal;
use std::sync::Arc;
use std::time::Duration;

use elite_lang::{Severity, SourceFile, check, compile};
use elite_runtime::{Preset, PresetError};
use robot_client::{Follower, News, Outcome, Primary, PrimaryError, RobotAddress, dashboard};
use thiserror::Error;
use tokio::sync::watch;
use tokio::time::{Instant, MissedTickBehavior, interval};
use wire::primary::{Exception, Message, Numbered, RobotException, Source};

use crate::cli::SendArgs;
use crate::commands::check::read_script;
use crate::commands::robot;
use crate::language;
use crate::logging;
use crate::ports::shown::{Escaped, Lines};
use crate::shutdown::Shutdown;
use program::{Outgoing, SendError};
use screen::Screen;
use watched::{Nodes, Told, listen};

/// Exit status of a program that failed or was stopped.
const FAILED: u8 = 1;
/// Exit status when nothing was sent, or what came of it is not known.
const NOT_SENT: u8 = 2;
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
    #[error(transparent)]
    Refused(#[from] robot::Refusal),
    #[error(transparent)]
    Setting(#[from] PresetError),
    #[error("cannot start: {0}")]
    Start(#[from] std::io::Error),
}

/// Exit status: 0 ended, 1 failed or stopped, 2 not sent.
pub fn send(args: &SendArgs) -> u8 {
    let status = Shutdown::start_within(FAILED, robot::END_PATIENCE)
        .map_err(Refusal::from)
        .and_then(|shutdown| {
            let runtime = tokio::runtime::Builder::new_current_thread()
                .enable_all()
                .build()?;
            runtime.block_on(conversation(args, &shutdown))
        });
    status.unwrap_or_else(|refusal| {
        logging::say(&format!("eliteserver: {refusal}"));
        NOT_SENT
    })
}

async fn conversation(args: &SendArgs, shutdown: &Shutdown) -> Result<u8, Refusal> {
    let settings = Preset::parse_all(&args.set)?;
    let (file, mut outgoing) = prepared(args, &settings)?;
    let address = RobotAddress::new(&args.robot.robot, args.robot.primary_port);
    let what = format!("Send {} to", Escaped(file.name()));
    robot::allowed(&args.robot, &address, &what).await?;
    if dashboard::is_simulated(&address.with_port(args.robot.dashboard_port)).await {
        outgoing.name_the_file(file.name(), &settings);
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
    let is_terminal = std::io::stderr().is_terminal();
    let mut followed = Followed {
        nodes: Nodes::of(&file),
        file,
        outgoing,
        screen: Screen::new(is_terminal),
    };
    let (sender, told) = watch::channel(Told::default());
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
            followed
                .screen
                .line(&format!("eliteserver: {error}; the program may go on"));
            Ok(NOT_SENT)
        }
    }
}

/// Reads and checks the file, and makes of it what is sent.
fn prepared(args: &SendArgs, settings: &[Preset]) -> Result<(Arc<SourceFile>, Outgoing), Refusal> {
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
        for line in elite_lang::render_human(&language::finding(&finding), &file, false)
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

/// A program that was sent.
struct Followed {
    nodes: Nodes,
    file: Arc<SourceFile>,
    outgoing: Outgoing,
    screen: Screen,
}

impl Followed {
    async fn follow(
        &mut self,
        robot: &mut Primary,
        told: &watch::Receiver<Told>,
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
                let told = *told.borrow();
                let place = self.doing(told.line);
                self.screen.state(state, told, &place, sent.elapsed());
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

    /// Where the program is, of the line that the controller tells: `, line 7, node 3 Approach`.
    fn doing(&self, line: Option<u32>) -> String {
        let line = line.and_then(|line| i32::try_from(line).ok());
        let Some((line, _)) = line.and_then(|line| self.outgoing.place(line, 1)) else {
            return String::new();
        };
        let node = self.nodes.at(line);
        let node = node.map_or_else(String::new, |node| format!(", {}", Escaped(node)));
        format!(", line {line}{node}")
    }

    /// Ctrl-C: the robot is stopped first.
    async fn stop(&mut self, robot: &mut Primary) -> Result<u8, PrimaryError> {
        self.screen.line("stopping the program on the robot");
        let sentence = robot::stop(robot).await?;
        self.screen.line(sentence);
        self.screen.end();
        Ok(FAILED)
    }

    fn tell(&mut self, told: &RobotException) {
        match &told.exception {
            Exception::Script { line, column, text } => {
                let place = self.outgoing.place_of_error(*line, *column, text);
                let name = Escaped(self.file.name());
                let text = self.outgoing.in_file(text, self.file.name());
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
                let (source, level) = (Source::name(told.source), level.name());
                let (code, sub_code) = (*code, *sub_code);
                let numbered = Numbered {
                    code,
                    sub_code,
                    data,
                };
                let numbered = numbered.to_string();
                self.screen
                    .line(&format!("{source}: {level} {}", Escaped(&numbered)));
            }
        }
    }
}
