//! The controller as the ports see it: implements their border traits, and carries messages to port 30001.

use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

use elite_lang::{KnownNames, SourceFile};
use elite_runtime::interpreter::{Statement, Submitted};
use elite_runtime::message::{Message, Severity};
use elite_runtime::{ProgramText, Robot, Supervisor, TaskState};
use kinematics::RobotModel;
use motion::realtime::ClockMeter;
use motion_api::{CommandId, CommandKind, MotionMode, RobotState};
use tokio::sync::broadcast;
use tokio_util::sync::CancellationToken;

use crate::controller::Controller;
use crate::ports::ClientId;
use crate::ports::description::{Peripherals, RobotDescription, TaskStatus};
use crate::ports::http;
use crate::ports::interpreter::codec::{Command, Discard};
use crate::ports::interpreter::{self, Verdict};
use crate::ports::primary::codec::{ErrorData, Exception, Level, Source};
use crate::ports::primary::framing::{ControlPhrase, Program, ProgramKind};
use crate::ports::primary::{self, Hub, Submission};

/// Name of programs that are one line outside a block.
const LINE_NAME: &str = "line";

/// What ports ask the controller, answered.
pub struct Backend {
    robot: Arc<Robot>,
    supervisor: Supervisor,
    description: RobotDescription,
    hub: Hub,
    remote: bool,
    clock: ClockMeter,
    known: KnownNames,
}

impl Backend {
    /// `remote`: programs from the network are run; otherwise they are refused with a message.
    pub fn new(controller: &Controller, hub: Hub, remote: bool) -> Self {
        Self {
            robot: controller.robot().clone(),
            supervisor: controller.supervisor().clone(),
            description: describe(controller.robot().model()),
            hub,
            remote,
            clock: controller.clock_meter(),
            known: KnownNames::new(elite_runtime::builtins::all().map(|b| b.name)),
        }
    }

    /// Tells every client of port 30001 what a person should know.
    fn announce(&self, message: &Message) {
        let (source, exception) = match message {
            Message::ScriptError {
                line,
                column,
                report,
                ..
            } => {
                let (line, column) = (clamp(*line), clamp(*column));
                (
                    Source::Controller,
                    Exception::Script {
                        line,
                        column,
                        text: report.clone(),
                    },
                )
            }
            Message::Robot {
                code,
                sub_code,
                severity,
                text,
            } => {
                let level = match severity {
                    Severity::Info => Level::Info,
                    Severity::Warning => Level::Warning,
                    Severity::Error => Level::Error,
                };
                let data = ErrorData::Text(text.clone());
                (
                    Source::Safety,
                    Exception::Robot {
                        code: *code,
                        sub_code: *sub_code,
                        level,
                        data,
                    },
                )
            }
            // A problem of a secondary program goes out as a script exception with its prefix (manual 1.2.6).
            Message::Log {
                severity: Severity::Warning,
                origin,
                text,
            } if text.starts_with("[SEC] ") => {
                let exception = Exception::Script {
                    line: clamp(origin.line),
                    column: 1,
                    text: text.clone(),
                };
                (Source::Controller, exception)
            }
            Message::Print { .. } | Message::Log { .. } => return,
        };
        self.hub.announce(unix_millis(), source, &exception);
    }
}

fn clamp(number: u32) -> i32 {
    i32::try_from(number).unwrap_or(i32::MAX)
}

fn unix_millis() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.map_or(0, |d| u64::try_from(d.as_millis()).unwrap_or(u64::MAX))
}

/// Carries messages to the clients of port 30001 until `shutdown`.
pub async fn forward_messages(
    mut messages: broadcast::Receiver<Message>,
    backend: Arc<Backend>,
    shutdown: CancellationToken,
) {
    while let Some(received) = shutdown.run_until_cancelled(messages.recv()).await {
        match received {
            Ok(message) => backend.announce(&message),
            Err(broadcast::error::RecvError::Lagged(missed)) => {
                tracing::warn!("port 30001 fell behind, {missed} messages were not passed on");
            }
            Err(broadcast::error::RecvError::Closed) => return,
        }
    }
}

impl primary::Backend for Backend {
    fn state(&self) -> RobotState {
        self.robot.state()
    }

    fn task_status(&self) -> TaskStatus {
        match self.supervisor.status().state {
            TaskState::Stopped => TaskStatus::Stopped,
            TaskState::Running => TaskStatus::Running,
            TaskState::Paused => TaskStatus::Paused,
        }
    }

    fn description(&self) -> &RobotDescription {
        &self.description
    }

    fn peripherals(&self) -> Peripherals {
        Peripherals::default()
    }

    fn unix_millis(&self) -> u64 {
        unix_millis()
    }

    fn is_whole_program(&self, text: &str) -> bool {
        elite_lang::compile(SourceFile::new("block", text), &self.known).is_ok()
    }

    async fn submit(&self, submission: Submission) {
        let program = ProgramText {
            name: name_of(&submission.program),
            text: submission.program.text,
        };
        if !self.remote {
            let text = format!(
                "RuntimeError: program \"{}\" was refused: remote control is off (the server runs with --local)",
                program.name
            );
            tracing::warn!(client = %submission.client, "{text}");
            self.hub.announce(
                unix_millis(),
                Source::Controller,
                &Exception::Script {
                    line: 1,
                    column: 1,
                    text,
                },
            );
            return;
        }
        // A refusal has been told to everybody by the supervisor.
        let _ = self.supervisor.submit(program).await;
    }

    async fn control(&self, client: ClientId, phrase: ControlPhrase) {
        tracing::info!(%client, ?phrase, "control phrase");
        match phrase {
            ControlPhrase::StopTask => self.supervisor.stop(),
            ControlPhrase::PauseTask => self.supervisor.pause(),
            ControlPhrase::ResumeTask => self.supervisor.resume(),
            ControlPhrase::PowerOn => self.supervisor.command(CommandKind::PowerOn),
            ControlPhrase::PowerOff => self.supervisor.command(CommandKind::PowerOff),
            ControlPhrase::ReleaseBrakes => self.supervisor.command(CommandKind::ReleaseBrakes),
            ControlPhrase::UnlockProtectiveStop => {
                self.supervisor.command(CommandKind::UnlockProtectiveStop)
            }
            ControlPhrase::RestartSafetyBoard => {
                self.supervisor.command(CommandKind::RestartSafetyBoard)
            }
            ControlPhrase::SetSpeed(fraction) => {
                self.supervisor
                    .command(CommandKind::SetSpeedFraction(fraction));
            }
        }
    }
}

impl interpreter::Interpreter for Backend {
    async fn submit(&self, statement: interpreter::Statement) -> Verdict {
        let text = statement.text.to_string();
        let thrown_away = Box::new(move || statement.discard(&Discard::CleanedUp));
        match self
            .supervisor
            .interpreter()
            .submit(Statement { text, thrown_away })
        {
            Submitted::Accepted(id) => Verdict::Ack(id.0),
            Submitted::NotCompiled(reason) => Verdict::Discard(Discard::Compile(reason)),
            Submitted::NoTask => Verdict::Discard(Discard::InvalidState),
            Submitted::Full => Verdict::Discard(Discard::TooMany),
        }
    }

    async fn command(&self, command: Command) -> u64 {
        let interpreter = self.supervisor.interpreter();
        if command == Command::Abort
            && matches!(
                self.robot.state().motion_mode,
                MotionMode::MoveJ | MotionMode::MoveL | MotionMode::MoveC | MotionMode::MoveMl
            )
        {
            self.supervisor.command(CommandKind::Stop {
                only: CommandId::NONE,
            });
        }
        interpreter.with_queue(|queue| match command {
            Command::SkipBuffer => {
                queue.skip();
                queue.last_executed().0
            }
            Command::StateLastExecuted | Command::Abort => queue.last_executed().0,
            Command::StateLastInterpreted => queue.last_accepted().0,
            Command::StateLastCleared => queue.last_cleared().0,
            Command::StateUnexecuted => queue.unexecuted() as u64,
        })
    }
}

impl http::Source for Backend {
    fn state(&self) -> RobotState {
        self.robot.state()
    }

    fn task_status(&self) -> TaskStatus {
        primary::Backend::task_status(self)
    }

    fn overruns(&self) -> u64 {
        self.clock.overruns()
    }

    fn missed_cycles(&self) -> u64 {
        self.clock.missed()
    }
}

/// `first_light` of `def first_light():`.
fn name_of(program: &Program) -> String {
    let head = program.text.trim_start();
    let rest = match program.kind {
        ProgramKind::Main => head.strip_prefix("def"),
        ProgramKind::Secondary => head.strip_prefix("sec"),
        ProgramKind::Line => None,
    };
    rest.and_then(|rest| rest.split('(').next())
        .map(str::trim)
        .filter(|name| !name.is_empty() && name.len() <= 100)
        .unwrap_or(LINE_NAME)
        .to_owned()
}

/// Figures of the arm for the ports.
fn describe(model: &RobotModel) -> RobotDescription {
    let limits = model.limits();
    let dh = model.dh().map(|table| table.modified());
    RobotDescription {
        name: model.name().to_uppercase(),
        robot_type: model.type_number().unwrap_or(0),
        position_limits: std::array::from_fn(|j| (limits.position_min[j], limits.position_max[j])),
        speed_limits: limits.speed.0,
        acceleration_limits: limits.acceleration.0,
        dh_a: dh.map_or([0.0; 6], |t| t.a),
        dh_d: dh.map_or([0.0; 6], |t| t.d),
        dh_alpha: dh.map_or([0.0; 6], |t| t.alpha),
        ..RobotDescription::cs66()
    }
}
