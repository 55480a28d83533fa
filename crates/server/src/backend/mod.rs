//! The controller as the ports see it: implements their border traits, and carries messages to port 30001.
//!
//! Here are interpreter mode, questions and metrics; the other ports have files of their own.

mod dashboard;
mod lifetime;
mod page;
mod programs;
mod ros2;
mod rtsi;
mod shipped_tasks;
mod variables;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use controller::cell_world::CellWorld;
use controller::{ControllerConfig, LogLines};
use elite_runtime::interpreter::{DiscardReason, SubmitResult, SubmittedStatement};
use elite_runtime::message::{Message, RECORDING_ALARM_CODE, REPLACED, Severity};
use elite_runtime::panel::{FLAGS, PopupStyle};
use elite_runtime::{NoAnswer, Robot, Supervisor};
use elite_syntax::{KnownNames, SourceFile};
use io_bus::{ControlMode, Fieldbus};
use messages::text;
use motion::realtime::ClockMetrics;
use motion_api::{
    CommandId, CommandKind, MachineCommand, MotionMode, Origin, ProgramId, RegisterImages,
    RobotState, SettingCommand,
};
use parking_lot::Mutex;
use pendant::{PageScene, WorldWatch};
use recorder::RecorderMetrics;
use serde_json::{Value, json};
use supervision::ThreadSupervisor;
use tokio::sync::{broadcast, watch};
use tokio_util::sync::CancellationToken;

use crate::config::ServeConfig;
use crate::controller_host::ControllerHost;
use crate::event_broadcast::EventBroadcaster;
use crate::log_dir::InterpreterLog;
use crate::logging;
use crate::ports::description::{RobotDescription, TaskStatus};
use crate::ports::escape::EscapedLine;
use crate::ports::http::metrics::{Figures, RecordingFigures};
use crate::ports::http::{self, SetInputsError};
use crate::ports::interpreter::codec::{Discard, InterpreterCommand, executed};
use crate::ports::interpreter::{self, StatementReply};
use crate::ports::primary::{self, StateHub};
use crate::ports::query::{self, codec::Failure};
use crate::sample_feed::SampleFeed;
use dashboard::{Configuration, LoadedFiles, LogRateLimit};
use elite_runtime::task_folder::TaskFolder;
pub use lifetime::Lifetime;
use variables::ConfigurationVariables;
use wire::primary::{ErrorData, Exception, ExceptionLevel, ExceptionSource};

/// A command waits so long for room among the others.
const ROOM_WITHIN: Duration = Duration::from_millis(300);
/// Time between two looks whether there is room.
const LOOK_AGAIN: Duration = Duration::from_millis(1);

/// What ports ask the controller, answered.
pub struct PortBackend {
    robot: Arc<Robot>,
    fieldbus: Arc<Fieldbus>,
    supervisor: Supervisor,
    description: RobotDescription,
    hub: StateHub,
    debuggers: Arc<editor::dap::DebugHub>,
    feed: Arc<SampleFeed>,
    announcer: Arc<EventBroadcaster>,
    /// Who controls the robot.
    control: watch::Sender<ControlMode>,
    task_folder: TaskFolder,
    task_dir: PathBuf,
    /// What the page draws.
    scene: PageScene,
    /// The parts of the cell and what handles them, and how the page saw them last.
    world: Option<(CellWorld, Mutex<WorldWatch>)>,
    /// Positions of the joints at the start, rad.
    home: [f64; 6],
    /// Settings of the robot, for others like it.
    settings: ControllerConfig,
    log_lines: LogLines,
    start_configuration: Configuration,
    loaded: Mutex<LoadedFiles>,
    variables: Mutex<ConfigurationVariables>,
    /// What `play` has started last: its number and its name in the folder.
    last_played: Mutex<Option<(ProgramId, String)>>,
    /// Who has sent the newest programs, the newest first.
    sent: Mutex<Vec<(ProgramId, primary::Sender)>>,
    log_pace: Mutex<LogRateLimit>,
    lifetime: Lifetime,
    clock: ClockMetrics,
    recording: Option<RecorderMetrics>,
    recording_path: Option<PathBuf>,
    known: Arc<KnownNames>,
    log: InterpreterLog,
    faults: ThreadSupervisor,
}

impl PortBackend {
    /// The ports' view of `controller_host`, set up as `config` says. Clients can end the `lifetime`.
    pub fn new(
        host: &ControllerHost,
        config: &ServeConfig,
        hub: StateHub,
        lifetime: Lifetime,
    ) -> Self {
        let (robot, controller) = (&config.robot, host.controller());
        let cog = robot.payload.cog;
        Self {
            feed: host.feed().clone(),
            announcer: host.announcer().clone(),
            task_folder: TaskFolder::new(&robot.task_dir),
            task_dir: robot.task_dir.clone(),
            scene: pendant::scene::describe(controller.robot().model(), controller.cell()),
            world: controller
                .world()
                .map(|world| (world.clone(), Mutex::new(WorldWatch::new(world)))),
            home: robot.home.0,
            settings: robot.clone(),
            log_lines: controller.log_lines(),
            start_configuration: Configuration {
                tcp: Some(robot.tcp.to_array()),
                payload: Some([robot.payload.mass, cog[0], cog[1], cog[2]]),
                speed: Some(1.0),
            },
            loaded: Mutex::default(),
            variables: Mutex::default(),
            last_played: Mutex::default(),
            sent: Mutex::default(),
            log_pace: Mutex::default(),
            lifetime,
            robot: controller.robot().clone(),
            fieldbus: controller.fieldbus().clone(),
            supervisor: controller.supervisor().clone(),
            description: host.description().clone(),
            hub,
            debuggers: host.debuggers().clone(),
            control: {
                controller.fieldbus().port_image.set_control(config.control);
                watch::Sender::new(config.control)
            },
            clock: controller.clock_meter(),
            recording: controller.recorder_meter(),
            recording_path: controller.recording_path().map(Path::to_owned),
            known: Arc::new(KnownNames::new(elite_runtime::builtins::names())),
            log: host.interpreter_log().clone(),
            faults: controller.faults().clone(),
        }
    }

    /// Programs come from the network, if in mixed mode not by all ways.
    fn takes_programs(&self) -> bool {
        *self.control.borrow() != ControlMode::Local
    }

    /// Gives control to somebody.
    fn set_control(&self, mode: ControlMode) {
        self.fieldbus.port_image.set_control(mode);
        self.control.send_replace(mode);
    }

    /// Gives the robot a command; while others flood it, a moment later. What finds no room is told to everybody.
    async fn send_when_room(&self, command: impl Into<CommandKind>) {
        let command = command.into();
        let patience = tokio::time::Instant::now() + ROOM_WITHIN;
        while self.robot.send(Origin::default(), command).is_err() {
            if tokio::time::Instant::now() >= patience {
                return self.supervisor.command(command);
            }
            tokio::time::sleep(LOOK_AGAIN).await;
        }
    }

    /// Tells every client of port 30001 that something it sent was not done.
    fn refuse(&self, text: String) {
        tracing::warn!("{text}");
        let exception = Exception::Script {
            line: 1,
            column: 1,
            text,
        };
        self.hub
            .announce(unix_millis(), ExceptionSource::Controller, &exception);
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
                    ExceptionSource::Controller,
                    Exception::Script {
                        line,
                        column,
                        text: report.english().to_owned(),
                    },
                )
            }
            Message::Robot {
                code,
                sub_code,
                severity,
                text,
                ..
            } => {
                let level = match severity {
                    Severity::Info => ExceptionLevel::Info,
                    Severity::Warning => ExceptionLevel::Warning,
                    Severity::Error => ExceptionLevel::Error,
                };
                let data = ErrorData::Text(text.english().to_owned());
                let source = match *code {
                    RECORDING_ALARM_CODE => ExceptionSource::Controller,
                    _ => ExceptionSource::Safety,
                };
                (
                    source,
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
            } if text.english().starts_with("[SEC] ") => {
                let exception = Exception::Script {
                    line: clamp(origin.line),
                    column: 1,
                    text: text.english().to_owned(),
                };
                (ExceptionSource::Controller, exception)
            }
            Message::Log { origin, text, .. } if text.english().starts_with(REPLACED) => {
                return self.announce_replacement(origin.program, text.english());
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
    backend: Arc<PortBackend>,
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

impl PortBackend {
    /// Whether a text is a program; finding out is left to the threads for that.
    async fn compiles(&self, text: String) -> bool {
        let known = self.known.clone();
        let pool = self.supervisor.compile_pool();
        let compiling = pool.run(text.len(), move || {
            elite_syntax::compile(SourceFile::new("block", text), &known).is_ok()
        });
        compiling.await.unwrap_or_else(|trouble| {
            tracing::warn!(%trouble, "a block that its sender left open is not run");
            false
        })
    }
}

impl query::Answering for PortBackend {
    async fn evaluate(&self, statement: &str) -> Result<String, Failure> {
        self.supervisor.ask(statement).await.map_err(|no_answer| {
            tracing::warn!("port 40011: {}: {}", EscapedLine(statement), no_answer);
            match no_answer {
                NoAnswer::Parse(_) => Failure::Parse,
                NoAnswer::Execute(_) => Failure::Execute,
            }
        })
    }
}

impl interpreter::InterpreterBackend for PortBackend {
    async fn submit(&self, statement: interpreter::Statement) -> StatementReply {
        let shown = statement.text.clone();
        let client = statement.client;
        self.log.received(client, &shown);
        let log = self.log.clone();
        let thrown_away = Box::new(move |reason| {
            let discard = match reason {
                DiscardReason::OnEntry => Discard::CleanedUp,
                DiscardReason::OnEnd => Discard::CleanedUpAfterEnd,
                DiscardReason::Cleared => Discard::Cleared,
                DiscardReason::TaskEnded => Discard::InvalidState,
            };
            log.discarded(client, &discard.to_string(), &statement.text);
            statement.discard(&discard);
        });
        let text = executed(&shown).into_owned();
        let submitted = self.supervisor.interpreter().submit(SubmittedStatement {
            text,
            on_discard: thrown_away,
        });
        let discard = match submitted.await {
            SubmitResult::Accepted(id) => return StatementReply::Ack(id.0),
            SubmitResult::NotCompiled(reason) => Discard::Compile(reason),
            SubmitResult::NoTask => Discard::InvalidState,
            SubmitResult::Full => Discard::TooMany,
        };
        self.log.discarded(client, &discard.to_string(), &shown);
        StatementReply::Discard(discard)
    }

    async fn command(&self, command: InterpreterCommand) -> u64 {
        let interpreter = self.supervisor.interpreter();
        match command {
            InterpreterCommand::SkipBuffer => interpreter.skip(),
            InterpreterCommand::Abort if is_planned_motion(self.robot.state().motion_mode) => {
                let only = CommandId::NONE;
                self.send_when_room(MachineCommand::Stop { only }).await;
            }
            _ => {}
        }
        let counters = interpreter.counters();
        match command {
            InterpreterCommand::SkipBuffer
            | InterpreterCommand::StateLastExecuted
            | InterpreterCommand::Abort => counters.last_executed.0,
            InterpreterCommand::StateLastInterpreted => counters.last_accepted.0,
            InterpreterCommand::StateLastCleared => counters.last_cleared.0,
            InterpreterCommand::StateUnexecuted => counters.unexecuted as u64,
        }
    }
}

/// The motions that `abort` ends (manual 2.6).
const fn is_planned_motion(mode: MotionMode) -> bool {
    matches!(mode, MotionMode::MoveJ | MotionMode::MoveL)
}

impl http::HttpBackend for PortBackend {
    fn state(&self) -> RobotState {
        self.robot.state()
    }

    fn task_status(&self) -> TaskStatus {
        self.feed.task_status()
    }

    fn panel(&self) -> Value {
        let panel = self.supervisor.panel();
        let popups = panel.popups();
        let popups = popups.iter().map(|(id, popup)| {
            json!({
                "id": id.0,
                "title": popup.title,
                "text": popup.text,
                "style": match popup.style {
                    PopupStyle::Message => "message",
                    PopupStyle::Warning => "warning",
                    PopupStyle::Error => "error",
                },
                "blocking": popup.blocking,
            })
        });
        let variables = panel.variables();
        let variables = variables.iter().map(|(name, variable)| {
            json!({"name": name, "type": variable.type_name, "value": variable.value})
        });
        let interpreter = self.supervisor.interpreter();
        let (line, node) = self.feed.place();
        json!({
            "task": http::HttpBackend::task_status(self).name(),
            "program": self.supervisor.status().program.0,
            "line": line,
            "node": node.as_ref().map(|node| node.number),
            "label": node.as_ref().map(|node| &*node.label),
            "interpreter": if interpreter.is_active() { "active" } else { "idle" },
            "flags": (0..FLAGS).filter(|n| panel.flag(*n)).collect::<Vec<u8>>(),
            "popups": popups.collect::<Vec<Value>>(),
            "variables": variables.collect::<Vec<Value>>(),
        })
    }

    fn figures(&self) -> Figures {
        Figures {
            overruns: self.clock.overruns(),
            missed_cycles: self.clock.missed(),
            cycle_durations: self.clock.durations(),
            wakeup_latencies: self.clock.latencies(),
            commands_waiting: self.robot.commands_waiting(),
            statements_waiting: self.supervisor.interpreter().counters().unexecuted,
            recording: self.recording.as_ref().map(RecordingFigures::of),
            errors: self.announcer.errors(),
            faults: self.faults.counts().map(|(_, count)| count),
            log_lines_lost: logging::lost(),
        }
    }

    fn fault(&self) -> Option<String> {
        self.faults.fatal().map(ToString::to_string)
    }

    fn registers(&self) -> RegisterImages {
        self.robot.registers().images()
    }

    fn set_inputs(&self, changes: &http::io::IoChanges) -> Result<(), SetInputsError> {
        if self.robot.is_abandoned() {
            let text = text!(
                "the control cycle has ended; nothing was set",
                "控制周期已结束；没有设置任何内容"
            );
            return Err(SetInputsError::Unavailable(text));
        }
        let points = changes.points.iter();
        let points: Vec<CommandKind> = points
            .map(|change| CommandKind::Setting(SettingCommand::SetIo(*change)))
            .collect();
        // First what may be refused: it is all or nothing.
        let sent = self.robot.send_all(Origin::default(), &points);
        sent.map_err(|full| {
            SetInputsError::Unavailable(text!(
                "nothing was set: {full}",
                "没有设置任何内容：{full}"
            ))
        })?;
        for (direction, value) in &changes.registers {
            value.write(*direction, self.robot.registers());
        }
        Ok(())
    }
}
