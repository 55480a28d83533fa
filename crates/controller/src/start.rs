//! From settings to a running controller: model, cell, recording, clock, the machinery for programs.
//!
//! In two steps, because who is told of everything wants to know the arm before the first cycle.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock, Weak};
use std::time::Duration;

use elite_runtime::external::{InputMode, Rerun};
use elite_runtime::message::{Message, Observer, RECORDING_ALARM_CODE, Severity};
use elite_runtime::panel::Operator;
use elite_runtime::task_folder::TaskFolder;
use elite_runtime::{
    FileAccess, Instrumentation, NetworkAccess, Panel, Permissions, Robot, SandboxError,
    SandboxRoots, SandboxedPath, Supervisor, TaskSettings,
};
use io_bus::serial::SerialLine;
use io_bus::{Fieldbus, SimulatedPeers};
use kinematics::{CalibrationError, ModelError, Pose, RobotModel};
use messages::{Localized, text};
use motion::{ControlLoop, CycleConfig};
use motion_api::{
    CommandSender, Origin, Registers, RingCapacities, ScriptEndpoint, SnapshotCell, Timeline,
    motion_channel,
};
use path_planning::CollisionScene;
use platform::sockets::LocalStream;
use recorder::{
    CustomTopic, RecordError, Recorder, RecorderConfig, RecorderHandle, Setup, ViewerMessages,
};
use supervision::ThreadSupervisor;
use thiserror::Error;

use crate::cell::{Cell, CellError};
use crate::cell_world::gripper_bus::{self, GripperPeers, GripperTimeline};
use crate::cell_world::{self, WorldInputs, WorldRunner, WorldStart, surround};
use crate::clock::{EventPump, start_clock};
use crate::config::ControllerConfig;
use crate::external_topic;
use crate::loaded_model::{LoadedModel, setup};
use crate::options::{ClockChoice, Permission};
use crate::recorded_run::{RecordedModelError, cell_of, model_of};
use crate::recording_files;
use crate::recording_observer::RecordingObserver;
use crate::running::Controller;
use crate::start_configuration::{SetupError, cycle_config};

/// What kept the controller from starting; each is a sentence for the person who typed the command.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum StartError {
    /// A folder of `--allow fs=DIR` is not there.
    #[error(transparent)]
    Folder(#[from] SandboxError),
    /// The arm's description is not usable.
    #[error("cannot use the model {model}: {source}")]
    #[zh("无法使用型号 {model}：{source}")]
    Model {
        /// Name of the model as it was given.
        model: String,
        /// What is wrong with the model.
        source: ModelError,
    },
    /// The URDF file cannot be read.
    #[error("cannot read the model {}: {source}", path.display())]
    #[zh("无法读取型号 {}：{source}", path.display())]
    ModelFile {
        /// The file as it was given.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The calibration does not fit the arm.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// The cell file is not usable.
    #[error(transparent)]
    Cell(#[from] CellError),
    /// The world of the cell cannot be.
    #[error("the cell file: {0}")]
    #[zh("单元文件：{0}")]
    World(#[from] Box<world::WorldError>),
    /// A setting does not fit the arm.
    #[error(transparent)]
    Settings(#[from] motion::ConfigError),
    /// A setting that no arm or not this one can start with.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The file of the recording cannot be made.
    #[error("cannot write the recording {}: {source}", path.display())]
    #[zh("无法写入记录 {}：{source}", path.display())]
    RecordingFile {
        /// The file as it was given.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The arm of a recording cannot be made.
    #[error(transparent)]
    Arm(#[from] RecordedModelError),
    /// No recording.
    #[error(transparent)]
    Recording(#[from] RecordError),
    /// The operating system gave no thread.
    #[error("cannot start a thread: {0}")]
    #[zh("无法启动线程：{0}")]
    Thread(#[from] io::Error),
}

/// How a controller is looked after while it runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StartOptions {
    /// Whether somebody is there whom a program can ask.
    pub operator: Operator,
    /// Whether the arm starts without power.
    pub powered_off: bool,
    /// Whether the time of the virtual clock passes while no program runs.
    pub advances_when_idle: bool,
    /// A disk that takes nothing while the robot waits for it is given up after this.
    pub disk_timeout: Duration,
    /// Whether contact stops the arm, with obstacles and with itself.
    pub contact_stops: bool,
}

impl StartOptions {
    /// Others talk to it, now and then: nobody waits long for a disk.
    pub const fn for_server(powered_off: bool) -> Self {
        Self {
            operator: Operator::Present,
            powered_off,
            advances_when_idle: true,
            disk_timeout: Duration::from_secs(2),
            contact_stops: true,
        }
    }

    /// One program after the other, and nobody there but who started it: before and after a program nothing needs time
    /// to pass, and the whole recording counts more than its time.
    pub const fn for_single_run() -> Self {
        Self {
            operator: Operator::Absent,
            powered_off: false,
            advances_when_idle: false,
            disk_timeout: Duration::from_secs(60),
            contact_stops: true,
        }
    }

    /// One program, to measure how far it is from collisions: it runs through them.
    pub const fn for_measuring() -> Self {
        Self {
            contact_stops: false,
            ..Self::for_single_run()
        }
    }
}

/// A controller that is set up and recorded, and whose time does not pass yet.
pub struct PreparedController {
    clock: (ClockChoice, Option<Duration>),
    manner: StartOptions,
    permissions: Permissions,
    task_folder: TaskFolder,
    seed: u64,
    cell: Option<Cell>,
    cycle_config: CycleConfig,
    cycle: ControlLoop,
    world: Option<WorldRunner>,
    script_end: ScriptEndpoint,
    model: Arc<RobotModel>,
    viewer: ViewerMessages,
    recorder: Option<Recorder>,
    handle: RecorderHandle,
    recording_path: Option<PathBuf>,
    /// The recording, where it must be beneath certain folders.
    recording_place: Option<SandboxedPath>,
    alarm: RecordingAlarm,
    faults: ThreadSupervisor,
    /// A recorded run that is repeated.
    repeat: Option<Arc<Rerun>>,
}

impl PreparedController {
    /// Reads model and cell, checks that everything fits, and begins the recording.
    ///
    /// # Errors
    /// [`StartError`], in a sentence.
    pub fn new(config: &ControllerConfig, manner: StartOptions) -> Result<Self, StartError> {
        let permissions = permissions(config)?;
        let loaded = LoadedModel::open(config)?;
        let cell = config.read_cell()?;
        // Whoever runs one program after the other sees the results, and asks `eliteserver cell` for the rest.
        for mesh in cell.iter().flat_map(Cell::mesh_facts) {
            match manner.operator {
                Operator::Present => tracing::info!("cell: {}", mesh.text()),
                Operator::Absent => tracing::debug!("cell: {}", mesh.text()),
            }
        }
        let setup = setup(config, &loaded, cell.as_ref(), manner.powered_off);
        let mut cycle_config = cycle_config(&setup, loaded.model.clone(), cell.as_ref())?;
        if manner.contact_stops {
            warn_of_overlaps(&cycle_config);
        } else {
            cycle_config.contact_stops = false;
            cycle_config.limits.self_collision = Some(false);
        }
        let first = cycle_config.first_state();
        let path = recording_files::path(&config.record);
        let sizes = RingCapacities {
            records: path.as_ref().and(RingCapacities::default().records),
            ..RingCapacities::default()
        };
        let (motion_end, mut script_end) = motion_channel(sizes, &first);
        let model = Arc::new(cycle_config.limited_model()?);
        let cycle = ControlLoop::new(cycle_config.clone(), motion_end)?;
        let (cycle, mut world) = surround(
            cycle,
            cell.as_ref(),
            &world_start(&cycle_config, setup.seed),
        )?;

        let obstacles = cell.as_ref().map(Cell::scene_obstacles).unwrap_or_default();
        let viewer = ViewerMessages::new(loaded.model.clone(), obstacles.clone(), setup.epoch_ns);
        let faults = ThreadSupervisor::default();
        let alarm = RecordingAlarm::new(faults.clone());
        // Where it leads is settled here, and held until everything is written.
        let recording_place = match (&config.sandbox, &path) {
            (Some(folders), Some(path)) => {
                let made = folders.make_file(path);
                Some(made.map_err(|source| StartError::RecordingFile {
                    path: path.clone(),
                    source,
                })?)
            }
            _ => None,
        };
        let written_to = match &recording_place {
            Some(place) => Some(place.as_ref().to_owned()),
            None => path.clone(),
        };
        let (recorder, handle) = match (written_to, script_end.records.take()) {
            (Some(path), Some(records)) => {
                let recorder_config = RecorderConfig {
                    path,
                    setup,
                    model: loaded.model.clone(),
                    obstacles,
                    extra: topics(world.is_some()),
                    rotation: recording_files::rotation(config),
                    notes_wait: config.clock == ClockChoice::Virtual,
                    patience: manner.disk_timeout,
                    on_failure: alarm.clone().into_callback(),
                };
                match Recorder::start(recorder_config, records) {
                    Ok((recorder, handle)) => (Some(recorder), handle),
                    // A full disk is no reason to stand still, now as little as later.
                    Err(error @ RecordError::Write { .. }) => {
                        tracing::error!("recording stopped, the robot goes on: {error}");
                        (None, RecorderHandle::disabled())
                    }
                    Err(error) => return Err(error.into()),
                }
            }
            _ => (None, RecorderHandle::disabled()),
        };
        // Without a recorder nobody finds out what moves, and writes it down for nobody.
        if let (Some(world), Some(_)) = (&mut world, &recorder) {
            world.record_to(handle.clone());
        }
        Ok(Self {
            world,
            clock: (config.clock, config.cycle_phase),
            manner,
            permissions,
            task_folder: TaskFolder::new(absolute(&config.task_dir))
                .with_sandbox(config.sandbox.clone()),
            seed: config.seed,
            cell,
            cycle_config,
            cycle,
            script_end,
            model,
            viewer,
            recorder,
            handle,
            recording_path: path,
            recording_place,
            alarm,
            faults,
            repeat: None,
        })
    }

    /// The arm and the cell of a recording, for a run that is repeated.
    pub(crate) fn of_recording(
        setup: &Setup,
        repeat: Arc<Rerun>,
        world_inputs: WorldInputs,
    ) -> Result<Self, StartError> {
        let loaded = model_of(setup)?;
        let cell = cell_of(setup).map_err(RecordedModelError::from)?;
        let cycle_config = cycle_config(setup, loaded.clone(), cell.as_ref())?;
        let sizes = RingCapacities {
            records: None,
            ..RingCapacities::default()
        };
        let (motion_end, script_end) = motion_channel(sizes, &cycle_config.first_state());
        let model = Arc::new(cycle_config.limited_model()?);
        let cycle = ControlLoop::new(cycle_config.clone(), motion_end)?;
        let (cycle, mut world) = surround(
            cycle,
            cell.as_ref(),
            &world_start(&cycle_config, setup.seed),
        )?;
        if let Some(world) = &mut world {
            world.repeat(world_inputs);
        }
        let obstacles = cell.as_ref().map(Cell::scene_obstacles).unwrap_or_default();
        let faults = ThreadSupervisor::default();
        Ok(Self {
            world,
            clock: (ClockChoice::Virtual, None),
            manner: StartOptions {
                powered_off: setup.powered_off,
                ..StartOptions::for_single_run()
            },
            // Nobody outside is reached: the recording answers.
            permissions: Permissions::default(),
            task_folder: TaskFolder::new(absolute(Path::new("."))),
            seed: setup.seed,
            cell: None,
            cycle_config,
            cycle,
            script_end,
            model,
            viewer: ViewerMessages::new(loaded, obstacles, setup.epoch_ns),
            recorder: None,
            handle: RecorderHandle::disabled(),
            recording_path: None,
            recording_place: None,
            alarm: RecordingAlarm::new(faults.clone()),
            faults,
            repeat: Some(repeat),
        })
    }

    /// The sender that takes commands, and the registers.
    pub(crate) fn command_inputs(&self) -> (CommandSender, Arc<Registers>) {
        let end = &self.script_end;
        (end.commands.clone(), end.registers.clone())
    }

    /// The arm with the limits in force.
    pub const fn model(&self) -> &Arc<RobotModel> {
        &self.model
    }

    /// The arm with the limits in force among what the cell file describes.
    pub fn collision_scene(&self) -> CollisionScene {
        let model = self.model.as_ref().clone();
        let tcp = Pose::from_rpy(&self.cycle_config.tcp);
        match &self.cell {
            Some(cell) => cell.collision_scene(model, tcp),
            None => CollisionScene::new(model, None, tcp),
        }
    }

    /// The latest state, once time passes.
    pub const fn snapshot(&self) -> &Arc<SnapshotCell> {
        &self.script_end.snapshot
    }

    /// The supervisor that hears of faults of the controller's threads.
    pub const fn faults(&self) -> &ThreadSupervisor {
        &self.faults
    }

    /// Lets time begin. `observer` is told of everything that happens, after the recording.
    ///
    /// # Errors
    /// [`StartError`], in a sentence.
    pub fn start(self, observer: Arc<dyn Observer>) -> Result<Controller, StartError> {
        self.start_with_timeline(observer, Instrumentation::default(), |timeline| timeline)
    }

    /// Starts the controller with a timeline of the caller's between the clock and whoever asks for cycles, and with
    /// the instrumentation of tests of programs.
    ///
    /// # Errors
    /// [`StartError`], in a sentence.
    pub fn start_with_timeline(
        self,
        observer: Arc<dyn Observer>,
        mut extras: Instrumentation,
        door: impl FnOnce(Arc<dyn Timeline>) -> Arc<dyn Timeline>,
    ) -> Result<Controller, StartError> {
        let Self {
            clock,
            manner,
            permissions,
            task_folder,
            seed,
            cell,
            cycle_config,
            cycle,
            world: runner,
            script_end,
            model,
            viewer,
            recorder,
            handle,
            recording_path,
            recording_place,
            alarm,
            faults,
            repeat,
        } = self;
        let world = runner.as_ref().map(|runner| runner.world().clone());
        let has_stand_ins = extras.stand_ins.is_some();
        let grippers = match (&cell, &world) {
            (Some(cell), Some(world)) => gripper_bus::tcp_slaves(cell, world),
            _ => BTreeMap::new(),
        };
        let mut peers = None;
        if clock.0 == ClockChoice::Virtual && !grippers.is_empty() {
            let grippers = GripperPeers::new(grippers.clone(), extras.stand_ins.take());
            let grippers = Arc::new(grippers);
            extras.stand_ins = Some(grippers.clone());
            peers = Some(grippers);
        }
        if permissions.network == NetworkAccess::SimulatedOnly {
            if let Some(cell) = &cell {
                cell.check_without_devices(extras.stand_ins.is_some())?;
            }
            extras.stand_ins = Some(Arc::new(SimulatedPeersOnly(extras.stand_ins.take())));
        }
        let safety = cycle_config.target_safety_bounds()?;
        let snapshot = script_end.snapshot.clone();
        let chronicle = Arc::new(RecordingObserver::new(handle, snapshot, observer));
        alarm.connect(&chronicle);
        let (pump, robot_for_pump) = EventPump::start(&faults, manner.advances_when_idle)?;
        let thread = pump.thread();
        let (clock, timeline) = start_clock(
            clock,
            manner.advances_when_idle,
            (cycle, runner),
            thread,
            &faults,
        )?;
        let on_bus = peers.map(|peers| Arc::new(GripperTimeline::new(timeline.clone(), peers)));
        let timeline = door(on_bus.clone().map_or(timeline, |on_bus| on_bus));
        let robot = Robot::new(model, script_end.into(), timeline, chronicle.clone());
        let planes = cell.as_ref().map(Cell::planes).unwrap_or_default();
        let names = planes.into_iter().map(|(name, ..)| name).collect();
        let robot = robot.with_safety_bounds(safety).with_plane_names(names);
        let robot = Arc::new(robot);
        // The pump waits for exactly this; it cannot have ended before.
        let _ = robot_for_pump.send(Arc::clone(&robot));
        let fieldbus = match &cell {
            Some(cell) => cell.fieldbus(&faults, extras.stand_ins.clone(), world.as_ref())?,
            None => {
                let line = SerialLine::default;
                Fieldbus::new(line(), line(), &faults, extras.stand_ins.clone())
            }
        };
        let fieldbus = Arc::new(fieldbus);
        if let Some(on_bus) = &on_bus {
            on_bus.attach(&robot, &fieldbus);
        }
        let settings = TaskSettings {
            robot: robot.clone(),
            observer: chronicle.clone(),
            seed,
            fieldbus: fieldbus.clone(),
            panel: Arc::new(Panel::new(manner.operator)),
            permissions,
            task_folder,
            faults: faults.clone(),
            extras,
            course: match repeat {
                Some(repeat) => InputMode::Repeated(repeat),
                // Beside tests programs share their time with others, which no recording tells.
                None if recorder.is_some() && !has_stand_ins => {
                    InputMode::Recorded(chronicle.clone())
                }
                None => InputMode::Live,
            },
        };
        Ok(Controller {
            robot,
            fieldbus,
            supervisor: Supervisor::new(settings),
            chronicle,
            clock,
            pump,
            recorder,
            recording_path,
            _recording_place: recording_place,
            viewer,
            settings: cycle_config,
            faults,
            cell,
            world,
            grippers,
        })
    }
}

/// What the world of the cell starts with.
fn world_start(config: &CycleConfig, seed: u64) -> WorldStart<'_> {
    WorldStart {
        model: &config.model,
        step_time: config.step_time,
        gravity: config.gravity,
        seed,
    }
}

/// The topics of a recording beside those of every recording.
fn topics(has_world: bool) -> Vec<CustomTopic> {
    let mut topics = vec![external_topic::topic()];
    if has_world {
        topics.push(cell_world::topic::topic());
    }
    topics
}

/// No machine but those that are played, whoever asks: programs, the cell's signals.
struct SimulatedPeersOnly(Option<Arc<dyn SimulatedPeers>>);

impl SimulatedPeers for SimulatedPeersOnly {
    fn simulates(&self, _host: &str, _port: u16) -> bool {
        true
    }

    fn answers(&self, host: &str, port: u16) -> bool {
        self.0
            .as_ref()
            .is_some_and(|inner| inner.answers(host, port))
    }

    fn connect(&self, host: &str, port: u16) -> Option<io::Result<LocalStream>> {
        let played = self.0.as_ref().and_then(|inner| inner.connect(host, port));
        Some(played.unwrap_or_else(|| {
            let text = text!(
                "nobody plays {host}:{port}, and --allow net=played reaches no other machine",
                "没有测试扮演 {host}:{port}，而 --allow net=played 不连接其他机器"
            );
            Err(io::Error::new(io::ErrorKind::PermissionDenied, text))
        }))
    }

    fn serve(&self) {
        if let Some(inner) = &self.0 {
            inner.serve();
        }
    }
}

/// Links that stand in an obstacle at the start never touch it: better said than wondered about.
fn warn_of_overlaps(config: &CycleConfig) {
    let around = &config.surroundings;
    for (link, obstacle) in around.links_inside_obstacles(&config.model, &config.home) {
        let name = &around.obstacles[obstacle].name;
        tracing::warn!(
            "link {link} of the arm stands in obstacle {name:?} at the start; the two never touch"
        );
    }
}

/// Says once, to everybody, that the recording has stopped.
#[derive(Clone)]
struct RecordingAlarm(Arc<OnceLock<Weak<RecordingObserver>>>, ThreadSupervisor);

impl RecordingAlarm {
    fn new(faults: ThreadSupervisor) -> Self {
        Self(Arc::default(), faults)
    }

    fn connect(&self, chronicle: &Arc<RecordingObserver>) {
        // Connected once, right after the chronicle exists.
        let _ = self.0.set(Arc::downgrade(chronicle));
    }

    fn into_callback(self) -> Box<dyn FnOnce(&RecordError) + Send> {
        Box::new(move |error| {
            if let RecordError::Fault(fault) = error {
                self.1.tell(fault);
            }
            let text = text!(
                "recording stopped, the robot goes on: {error}",
                "记录已停止，机器人继续运行：{error}"
            );
            match self.0.get().and_then(Weak::upgrade) {
                Some(chronicle) => {
                    chronicle.message(&Message::Robot {
                        origin: Origin::default(),
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
fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

/// What `--allow` lets programs reach.
fn permissions(config: &ControllerConfig) -> Result<Permissions, SandboxError> {
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
            false => FileAccess::Sandboxed(SandboxRoots::open(&folders)?),
        },
        processes: allows(Permission::Process),
        environment: allows(Permission::Env),
        network: match (allows(Permission::Net), allows(Permission::NetPlayed)) {
            (true, _) => NetworkAccess::Everything,
            (false, true) => NetworkAccess::SimulatedOnly,
            (false, false) => NetworkAccess::Nothing,
        },
    })
}
