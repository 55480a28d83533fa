//! How near the motions of a program come to anything: the program is run, and every cycle of it is measured.
//!
//! The arm is ideal, time is simulated, and contacts stop nobody, so that what is measured is the path and not what
//! became of it. Owns the observer that measures and the run. What a motion comes near to is `path-planning`'s matter.

mod motion_row;
mod observer;
mod tcp_path;

use std::sync::Arc;
use std::time::{Duration, Instant};

use elite_runtime::message::Observer;
use elite_runtime::{Preset, ProgramText};
use kinematics::{Pose, RobotModel};
use messages::{Localized, Text, text};
use motion_api::Seconds;
use path_planning::CollisionScene;
use recorder::Setup;
use thiserror::Error;

use crate::cell::Cell;
use crate::config::ControllerConfig;
use crate::loaded_model::{LoadedModel, setup};
use crate::options::{PlantChoice, RecordTarget};
use crate::outcome::{NullObserver, ProgramOutcome, ProgramResult};
use crate::recorded_run::{RecordedModelError, cell_of, model_of};
use crate::start::{StartError, StartOptions};
use crate::start_configuration::cycle_config;
use crate::stepped::{SteppedController, SteppedError, WallTimeout};

pub use motion_row::{
    GripChange, LeastDistance, MotionClearance, joint_margin, least_singular_value,
};
pub use observer::ClearanceObserver;
pub use tcp_path::TcpPath;

/// Surfaces so near to each other touch, m: a part that lies on something sinks in by some micrometres.
pub const TOUCHING: f64 = 5e-5;

/// A program whose arm stands for so long waits for something that nobody here gives, s of simulated time.
const STANDS_MAX: f64 = 300.0;
/// A program whose arm stands for so long of real time waits, too: while it waits for a socket or a process, simulated
/// time passes no faster than real time.
const STANDS_WALL_MAX: Duration = Duration::from_secs(10);
/// Longest computing without simulated time passing.
const STUCK: Duration = Duration::from_secs(30);

/// A program, measured.
#[derive(Clone, Debug)]
pub struct ClearanceRun {
    /// Motions of the program in the order in which they began.
    pub rows: Vec<MotionClearance>,
    /// How the program ended.
    pub end: MeasuredEnd,
    /// What the program printed, and how long it took.
    pub result: ProgramResult,
    /// Where asked for: the least distance, m, at the end of every cycle, by its simulated time, s.
    pub history: Vec<(f64, f64)>,
    /// What grippers took and let go, in this order.
    pub grips: Vec<GripChange>,
}

/// A program, measured, with the way of its TCP.
#[derive(Clone, Debug)]
pub struct PathRun {
    /// What was measured.
    pub run: ClearanceRun,
    /// The way of the TCP while the program ran.
    pub path: TcpPath,
    /// Whether there is anything to touch but the arm itself.
    pub has_obstacles: bool,
}

/// How a program is measured.
#[derive(Clone, Debug)]
pub struct MeasureOptions {
    /// Globals that it finds set.
    pub presets: Vec<Preset>,
    /// Longest simulated time, s.
    pub limit: f64,
    /// Whether the distance of every cycle is kept, too.
    pub has_history: bool,
}

impl Default for MeasureOptions {
    fn default() -> Self {
        Self {
            presets: Vec::new(),
            limit: 600.0,
            has_history: false,
        }
    }
}

/// How a measured program ended.
#[derive(Clone, Debug, PartialEq, Error, Localized)]
#[non_exhaustive]
pub enum MeasuredEnd {
    /// The program ran to its end.
    #[error("the program ended")]
    #[zh("程序已结束")]
    Finished,
    /// The program does not compile.
    #[error("the program does not compile{}: {error}", in_line(*.line))]
    #[zh("程序不能编译{}：{error}", in_line(*.line))]
    NotCompiled {
        /// What is wrong.
        error: Text,
        /// Where, from 1; 0 unknown.
        line: u32,
    },
    /// An exception, an alarm or a stop ended the program.
    #[error("the program failed{}: {error}", in_line(*.line))]
    #[zh("程序失败{}：{error}", in_line(*.line))]
    Failed {
        /// What happened.
        error: Text,
        /// Where, from 1; 0 unknown.
        line: u32,
    },
    /// The program waits for an input, a socket or a process that nobody serves.
    #[error(
        "the program waits{} for something from outside that does not come; set inputs at their times in the cell file \
         ([[input]]), or give it values with --set",
        in_line(*.line)
    )]
    #[zh("程序{}在等待不会到来的外部信号；请在单元文件中按时间设置输入（[[input]]），或用 --set 给出值", in_line(*.line))]
    Waits {
        /// Where, from 1; 0 unknown.
        line: u32,
    },
    /// The program goes on for ever, or for longer than the limit of simulated time.
    #[error(
        "the program had not ended after {seconds} s of simulated time{}; --timeout gives it longer, and one that \
         repeats itself for ever needs a bound on its repetitions",
        in_line(*.line)
    )]
    #[zh("仿真时间 {seconds} s 后程序仍未结束{}；--timeout 可给更长时间，而无限重复的程序需要限定重复次数", in_line(*.line))]
    TimedOut {
        /// What it was given, s.
        seconds: f64,
        /// Where it was then, from 1; 0 unknown.
        line: u32,
    },
    /// Whoever asked for it does not want to wait any longer.
    #[error("the program was stopped{}", in_line(*.line))]
    #[zh("程序被停止{}", in_line(*.line))]
    Interrupted {
        /// Where it was then, from 1; 0 unknown.
        line: u32,
    },
}

fn in_line(line: u32) -> Text {
    match line {
        0 => Text::verbatim(""),
        line => text!(" in line {line}", "（第 {line} 行）"),
    }
}

/// A reason why a program could not be measured.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum ClearanceError {
    /// No controller.
    #[error(transparent)]
    Start(#[from] StartError),
    /// The run met a fault.
    #[error(transparent)]
    Run(#[from] SteppedError),
}

impl ClearanceRun {
    /// The motion that comes nearest to something.
    pub fn nearest(&self) -> Option<&MotionClearance> {
        let rows = self.rows.iter().filter(|row| row.least.is_some());
        rows.min_by(|a, b| a.distance().total_cmp(&b.distance()))
    }

    /// The least distance of the whole program, m; infinite where nothing can touch.
    pub fn distance(&self) -> f64 {
        self.nearest()
            .map_or(f64::INFINITY, MotionClearance::distance)
    }
}

/// The arm of these settings among what their cell file describes, with the limits in force.
///
/// # Errors
/// [`StartError`], in a sentence.
pub fn collision_scene(config: &ControllerConfig) -> Result<CollisionScene, StartError> {
    let loaded = LoadedModel::open(config)?;
    let cell = config.read_cell()?;
    let setup = setup(config, &loaded, cell.as_ref(), false);
    scene(&setup, loaded.model, cell.as_ref())
}

/// The arm of a recording among what its cell file described, with the limits in force.
///
/// # Errors
/// [`StartError`], in a sentence.
pub fn collision_scene_of(setup: &Setup) -> Result<CollisionScene, StartError> {
    let cell = cell_of(setup).map_err(RecordedModelError::from)?;
    scene(setup, model_of(setup)?, cell.as_ref())
}

fn scene(
    setup: &Setup,
    model: RobotModel,
    cell: Option<&Cell>,
) -> Result<CollisionScene, StartError> {
    let model = cycle_config(setup, model, cell)?.limited_model()?;
    let tcp = Pose::from_rpy(&setup.tcp);
    Ok(match cell {
        Some(cell) => cell.collision_scene(model, tcp),
        None => CollisionScene::new(model, None, tcp),
    })
}

/// Runs a program and measures its motions. `keep_going` is asked now and then.
///
/// # Errors
/// [`ClearanceError`]; what the program itself does wrong is in the result.
pub fn measure(
    config: &ControllerConfig,
    program: ProgramText,
    options: &MeasureOptions,
    keep_going: &mut dyn FnMut() -> bool,
) -> Result<ClearanceRun, ClearanceError> {
    let scene = collision_scene(config)?;
    measure_in(scene, config, program, options, keep_going)
}

/// [`measure`] in a scene of the caller's, which is the one of these settings but for what the caller changed in it.
///
/// # Errors
/// The errors of [`measure`].
pub fn measure_in(
    scene: CollisionScene,
    config: &ControllerConfig,
    program: ProgramText,
    options: &MeasureOptions,
    keep_going: &mut dyn FnMut() -> bool,
) -> Result<ClearanceRun, ClearanceError> {
    let next = Arc::new(NullObserver);
    measure_and_tell(scene, next, config, program, options, keep_going)
}

/// [`measure`] that follows the TCP as well.
///
/// # Errors
/// The errors of [`measure`].
pub fn measure_with_path(
    config: &ControllerConfig,
    program: ProgramText,
    options: &MeasureOptions,
    keep_going: &mut dyn FnMut() -> bool,
) -> Result<PathRun, ClearanceError> {
    let scene = collision_scene(config)?;
    let has_obstacles = scene.obstacle_names().next().is_some();
    let followed = Arc::new(tcp_path::TcpPathObserver::default());
    let next = Arc::clone(&followed);
    let run = measure_and_tell(scene, next, config, program, options, keep_going)?;
    Ok(PathRun {
        run,
        path: followed.path(),
        has_obstacles,
    })
}

/// [`measure_in`] that tells an observer of everything as well.
pub(crate) fn measure_and_tell(
    scene: CollisionScene,
    next: Arc<dyn Observer>,
    config: &ControllerConfig,
    program: ProgramText,
    options: &MeasureOptions,
    keep_going: &mut dyn FnMut() -> bool,
) -> Result<ClearanceRun, ClearanceError> {
    let config = ControllerConfig {
        plant: PlantChoice::Ideal,
        record: RecordTarget::Off,
        ..config.clone()
    };
    let observer = ClearanceObserver::new(scene, next);
    let observer = Arc::new(match options.has_history {
        true => observer.with_history(),
        false => observer,
    });
    let start = StartOptions::for_measuring();
    let controller = SteppedController::open_with(&config, start, observer.clone())?;
    observer.connect(controller.controller().robot());
    if let Some(world) = controller.controller().world() {
        observer.follow_world(world);
    }
    controller
        .controller()
        .supervisor()
        .set_presets(&options.presets);
    let step = config.step.as_secs();
    let (mut moved, mut moved_at) = (0, Instant::now());
    let (mut waits, mut is_interrupted) = (false, false);
    let mut goes_on = || {
        let still = observer.still_cycles();
        if still < moved || still == 0 {
            moved_at = Instant::now();
        }
        moved = still;
        waits = still as f64 * step > STANDS_MAX || moved_at.elapsed() > STANDS_WALL_MAX;
        is_interrupted = !keep_going();
        !waits && !is_interrupted
    };
    let mut patience = WallTimeout {
        wall: STUCK,
        keep_going: &mut goes_on,
    };
    let seconds = Seconds::new(options.limit).unwrap_or_default();
    let ran = controller.run_program(program, seconds, &mut patience);
    let line = controller.collector().line();
    // What is measured is written nowhere: how the end goes does not matter to it.
    let _ = controller.shut_down();
    let result = ran?;
    let (error, at) = (
        result.error.clone().unwrap_or(Text::fixed("", "")),
        result.line.unwrap_or(line),
    );
    let end = match result.outcome {
        _ if waits => MeasuredEnd::Waits { line },
        _ if is_interrupted => MeasuredEnd::Interrupted { line },
        ProgramOutcome::Ended => MeasuredEnd::Finished,
        ProgramOutcome::Failed if !observer.has_begun() => {
            MeasuredEnd::NotCompiled { error, line: at }
        }
        ProgramOutcome::Timeout => MeasuredEnd::TimedOut {
            seconds: options.limit,
            line,
        },
        ProgramOutcome::Failed
        | ProgramOutcome::Stopped
        | ProgramOutcome::ProtectiveStop
        | ProgramOutcome::EmergencyStop => MeasuredEnd::Failed { error, line: at },
    };
    Ok(ClearanceRun {
        rows: observer.rows(),
        history: observer.history(),
        grips: observer.grips(),
        end,
        result,
    })
}
