//! The whole controller without its ports: arm, clock, recording, tasks, wired together and taken apart in order.
//!
//! Owns the threads (motion, pump, recorder) and the order in which they end. What `serve` adds are the ports.

mod clock;
mod loaded_model;

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock, Weak};
use std::time::Duration;

use elite_runtime::message::{
    CONTROLLER_FAULT_CODE, Message, Observer, RECORDING_ALARM_CODE, Severity,
};
use elite_runtime::panel::Operator;
use elite_runtime::{
    FileAccess, FolderAccessError, Folders, Panel, Permissions, ProgramText, Robot, Supervisor,
    TaskEnd, TaskSettings,
};
use io_bus::Fieldbus;
use io_bus::serial::SerialLine;
use kinematics::{CalibrationError, ModelError};
use motion::realtime::ClockMeter;
use motion::{Cycle, CycleConfig};
use motion_api::{BorderSizes, SnapshotCell, border};
use recorder::{
    Closer, RecordError, Recorder, RecorderConfig, RecorderHandle, RecorderMeter, Viewer,
};
use supervision::{Fault, Faults};
use thiserror::Error;

use crate::announce::{Announcer, Console};
use crate::cell::{Cell, CellError};
use crate::config::RobotConfig;
use crate::describe::describe;
use crate::feed::Feed;
use crate::log_dir::InterpreterLog;
use crate::options::{ClockChoice, Permission};
use crate::ports::description::RobotDescription;
use crate::recording_files;
use crate::shutdown::Shutdown;
use crate::start_configuration::{SetupError, cycle_config};
use clock::{Clock, Pump, start_clock};
use loaded_model::{LoadedModel, setup};

/// What kept the controller from starting; each is a sentence for the person who typed the command.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StartError {
    /// A folder of `--allow fs=DIR` is not there.
    #[error(transparent)]
    Folder(#[from] FolderAccessError),
    /// The arm's description is not usable.
    #[error("cannot use the model {model}: {source}")]
    Model {
        /// As given.
        model: String,
        /// Why.
        source: ModelError,
    },
    /// The URDF file cannot be read.
    #[error("cannot read the model {}: {source}", path.display())]
    ModelFile {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The calibration does not fit the arm.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// The cell file is not usable.
    #[error(transparent)]
    Cell(#[from] CellError),
    /// A setting does not fit the arm.
    #[error(transparent)]
    Settings(#[from] motion::ConfigError),
    /// A setting that no arm or not this one can start with.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// No recording.
    #[error(transparent)]
    Recording(#[from] RecordError),
    /// No log files.
    #[error("--log-dir: cannot write into {}: {source}", path.display())]
    LogDir {
        /// Which folder.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The operating system gave no thread.
    #[error("cannot start a thread: {0}")]
    Thread(#[from] io::Error),
}

/// A disk that takes nothing while the robot waits for it is given up after this: others talk to a server, and nobody to a
/// `run`, where the whole recording counts more.
const SERVING_PATIENCE: Duration = Duration::from_secs(2);
/// See [`SERVING_PATIENCE`].
const RUNNING_PATIENCE: Duration = Duration::from_secs(60);

/// A running controller.
pub struct Controller {
    robot: Arc<Robot>,
    fieldbus: Arc<Fieldbus>,
    supervisor: Supervisor,
    feed: Arc<Feed>,
    announcer: Arc<Announcer>,
    interpreter_log: InterpreterLog,
    clock: Clock,
    pump: Pump,
    recorder: Option<Recorder>,
    recording_path: Option<PathBuf>,
    viewer: Viewer,
    description: RobotDescription,
    faults: Faults,
}

impl Controller {
    /// Starts arm, clock, recording and the machinery for programs.
    ///
    /// # Errors
    /// [`StartError`], in a sentence.
    pub fn start(
        config: &RobotConfig,
        console: Console,
        powered_off: bool,
    ) -> Result<Self, StartError> {
        let permissions = permissions(config)?;
        let loaded = LoadedModel::open(&config.model, config.calibration.as_ref())?;
        let cell = config.cell.as_deref().map(Cell::load).transpose()?;
        let setup = setup(config, &loaded, cell.as_ref(), powered_off);
        let cycle_config = cycle_config(&setup, loaded.model.clone(), cell.as_ref())?;
        warn_of_overlaps(&cycle_config);
        let first = cycle_config.first_state();
        let path = recording_files::path(&config.record);
        let sizes = BorderSizes {
            records: path.as_ref().and(BorderSizes::default().records),
            ..BorderSizes::default()
        };
        let (motion_end, mut script_end) = border(sizes, &first);
        let safety = cycle_config.safety_of_targets()?;
        let description = describe(&cycle_config)?;
        let model = Arc::new(cycle_config.limited_model()?);
        let cycle = Cycle::new(cycle_config, motion_end)?;

        let obstacles = cell.as_ref().map(Cell::drawn).unwrap_or_default();
        let viewer = Viewer::new(loaded.model.clone(), obstacles.clone(), setup.epoch_ns);
        let faults = Faults::default();
        let alarm = RecordingAlarm::new(faults.clone());
        let (recorder, handle) = match (&path, script_end.records.take()) {
            (Some(path), Some(records)) => {
                let recorder_config = RecorderConfig {
                    path: path.clone(),
                    setup,
                    model: loaded.model.clone(),
                    obstacles,
                    rotation: recording_files::rotation(config),
                    notes_wait: config.clock == ClockChoice::Virtual,
                    patience: match console {
                        Console::Log => SERVING_PATIENCE,
                        Console::Stdout | Console::Stderr => RUNNING_PATIENCE,
                    },
                    on_failure: alarm.clone().into_callback(),
                };
                match Recorder::start(recorder_config, records) {
                    Ok((recorder, handle)) => (Some(recorder), handle),
                    // A full disk is no reason to stand still, now as little as later.
                    Err(error @ RecordError::Write { .. }) => {
                        tracing::error!("recording stopped, the robot goes on: {error}");
                        (None, RecorderHandle::off())
                    }
                    Err(error) => return Err(error.into()),
                }
            }
            _ => (None, RecorderHandle::off()),
        };
        let snapshot: Arc<SnapshotCell> = script_end.snapshot.clone();
        let interpreter_log = match &config.log_dir {
            Some(folder) => {
                InterpreterLog::open(folder, snapshot.clone(), &faults).map_err(|source| {
                    let path = folder.clone();
                    StartError::LogDir { path, source }
                })?
            }
            None => InterpreterLog::default(),
        };
        let feed = Arc::new(Feed::new(model.clone()));
        let log = interpreter_log.clone();
        let announcer = Arc::new(Announcer::new(handle, snapshot, console, log, feed.clone()));
        alarm.connect(&announcer);

        let (pump, robot_for_pump) = Pump::start(&faults)?;
        let (clock, timeline) = start_clock(config.clock, console, cycle, pump.thread(), &faults)?;
        let robot = Robot::new(model, script_end.into(), timeline, announcer.clone());
        let robot = Arc::new(robot.with_safety_bounds(safety));
        // The pump waits for exactly this; it cannot have ended before.
        let _ = robot_for_pump.send(Arc::clone(&robot));
        let fieldbus = match &cell {
            Some(cell) => cell.fieldbus(&faults)?,
            None => Fieldbus::new(SerialLine::default(), SerialLine::default(), &faults),
        };
        let fieldbus = Arc::new(fieldbus);
        let settings = TaskSettings {
            robot: robot.clone(),
            observer: announcer.clone(),
            seed: config.seed,
            fieldbus: fieldbus.clone(),
            panel: Arc::new(Panel::new(match console {
                Console::Stdout | Console::Stderr => Operator::Absent,
                Console::Log => Operator::Present,
            })),
            permissions,
            task_folder: absolute(&config.task_dir),
            faults: faults.clone(),
        };
        let supervisor = Supervisor::new(settings);
        feed.follow(supervisor.watch());
        Ok(Self {
            robot,
            fieldbus,
            supervisor,
            feed,
            announcer,
            interpreter_log,
            clock,
            pump,
            recorder,
            recording_path: path,
            viewer,
            description,
            faults,
        })
    }

    /// Where faults of its threads are told.
    pub const fn faults(&self) -> &Faults {
        &self.faults
    }

    /// Closes the recording, if there is one, without the controller's help.
    pub fn closer(&self) -> Option<Closer> {
        self.recorder.as_ref().and_then(Recorder::closer)
    }

    /// Tells everybody of the fault after which the process must end.
    pub fn announce_fault(&self, fault: &Fault) {
        self.announcer.message(&Message::Robot {
            code: CONTROLLER_FAULT_CODE,
            sub_code: 0,
            severity: Severity::Error,
            text: format!("the controller ends, the arm is held: {fault}"),
        });
    }

    /// The robot.
    pub fn robot(&self) -> &Arc<Robot> {
        &self.robot
    }

    /// Modbus devices, serial ports and the values of the controller's own Modbus server.
    pub fn fieldbus(&self) -> &Arc<Fieldbus> {
        &self.fieldbus
    }

    /// Starts and stops programs.
    pub fn supervisor(&self) -> &Supervisor {
        &self.supervisor
    }

    /// What every cycle is shown to.
    pub fn feed(&self) -> &Arc<Feed> {
        &self.feed
    }

    /// Who tells everybody.
    pub fn announcer(&self) -> &Arc<Announcer> {
        &self.announcer
    }

    /// The log files of interpreter mode.
    pub fn interpreter_log(&self) -> &InterpreterLog {
        &self.interpreter_log
    }

    /// The file that is being recorded.
    pub fn recording_path(&self) -> Option<&Path> {
        self.recording_path.as_deref()
    }

    /// What ports tell of the arm.
    pub const fn description(&self) -> &RobotDescription {
        &self.description
    }

    /// Makes what viewers show of the arm and its cell.
    pub fn viewer(&self) -> Viewer {
        self.viewer.clone()
    }

    /// How well the motion thread meets its deadlines; all zeros under the virtual clock.
    pub fn clock_meter(&self) -> ClockMeter {
        match &self.clock {
            Clock::Real(thread) => thread.meter(),
            Clock::Virtual(_) => ClockMeter::default(),
        }
    }

    /// Figures of the recording, if there is one.
    pub fn recorder_meter(&self) -> Option<RecorderMeter> {
        self.recorder.as_ref().map(Recorder::meter)
    }

    /// Runs a program and waits for its end; SIGINT and SIGTERM stop it. `None`: it was refused.
    ///
    /// # Errors
    /// The operating system gave no runtime.
    pub fn run_to_end(
        &self,
        program: ProgramText,
        shutdown: &Shutdown,
    ) -> io::Result<Option<TaskEnd>> {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()?;
        runtime.block_on(async {
            // A refusal was reported to the observer.
            let Ok(_) = self.supervisor.submit(program, "the command line").await else {
                return Ok(None);
            };
            tokio::select! {
                end = self.supervisor.ended() => Ok(end),
                () = shutdown.token().cancelled() => {
                    self.supervisor.stop();
                    Ok(self.supervisor.ended().await)
                }
            }
        })
    }

    /// Ends what runs, in order: motion, pump, recording. Programs must have ended. True when the recording was written
    /// to its end.
    pub fn shut_down(self) -> bool {
        match self.clock {
            Clock::Real(thread) => drop(thread.stop()),
            Clock::Virtual(pacer) => drop(pacer),
        }
        self.robot.pump();
        self.pump.stop();
        let Some(recorder) = self.recorder else {
            return true;
        };
        match recorder.finish() {
            Ok(totals) => {
                tracing::debug!(?totals, "recording finished");
                true
            }
            // Said when it happened; the recording is cut short, the program's result stands.
            Err(_) => false,
        }
    }
}

/// Links that stand in an obstacle at the start never touch it: better said than wondered about.
fn warn_of_overlaps(config: &CycleConfig) {
    let around = &config.surroundings;
    for (link, obstacle) in around.standing_in(&config.model, &config.home) {
        let name = &around.obstacles[obstacle].name;
        tracing::warn!(
            "link {link} of the arm stands in obstacle {name:?} at the start; the two never touch"
        );
    }
}

/// Says once, through the announcer, that the recording has stopped.
#[derive(Clone)]
struct RecordingAlarm(Arc<OnceLock<Weak<Announcer>>>, Faults);

impl RecordingAlarm {
    fn new(faults: Faults) -> Self {
        Self(Arc::default(), faults)
    }

    fn connect(&self, announcer: &Arc<Announcer>) {
        // Connected once, right after the announcer exists.
        let _ = self.0.set(Arc::downgrade(announcer));
    }

    fn into_callback(self) -> Box<dyn FnOnce(&RecordError) + Send> {
        Box::new(move |error| {
            if let RecordError::Fault(fault) = error {
                self.1.tell(fault);
            }
            let text = format!("recording stopped, the robot goes on: {error}");
            match self.0.get().and_then(Weak::upgrade) {
                Some(announcer) => {
                    announcer.message(&Message::Robot {
                        code: RECORDING_ALARM_CODE,
                        sub_code: 0,
                        severity: Severity::Error,
                        text,
                    });
                }
                None => tracing::error!("{text}"),
            }
        })
    }
}

/// Programs are told a path that means the same wherever it is used. A current folder that is gone leaves it as given.
fn absolute(path: &Path) -> Arc<Path> {
    std::path::absolute(path)
        .unwrap_or_else(|_| path.to_owned())
        .into()
}

/// What `--allow` lets programs reach.
fn permissions(config: &RobotConfig) -> Result<Permissions, FolderAccessError> {
    let allows = |permission| config.allow.contains(&permission);
    let folders: Vec<PathBuf> = config
        .allow
        .iter()
        .filter_map(|permission| match permission {
            Permission::FsIn(folder) => Some(folder.clone()),
            _ => None,
        })
        .collect();
    Ok(Permissions {
        files: match folders.is_empty() {
            _ if allows(Permission::Fs) => FileAccess::Everything,
            true => FileAccess::Nothing,
            false => FileAccess::Beneath(Folders::open(&folders)?),
        },
        processes: allows(Permission::Process),
        environment: allows(Permission::Env),
        network: allows(Permission::Net),
    })
}
