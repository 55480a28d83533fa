//! A controller under the virtual clock whose time passes only when its owner says so: programs are run to their end or
//! stepped, cycle by cycle, and every run is the same.
//!
//! Between two calls a program stands still: its thread waits at the [`CycleGate`]. So what the owner reads and sets
//! between them belongs to a certain cycle, whatever the machine is doing. Owns the meeting of owner and program, and
//! the two bounds that a program has: simulated time, and time of the machine in which no simulated time passes.

use std::io;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use elite_runtime::message::Observer;
use elite_runtime::{Instrumentation, ProgramText, SubmitError, TaskState};
use messages::{Localized, Text, text};
use motion_api::{RobotState, Seconds};
use parking_lot::Mutex;
use path_planning::CollisionScene;
use thiserror::Error;
use tokio::runtime::Runtime;

use crate::config::ControllerConfig;
use crate::cycle_gate::CycleGate;
use crate::gate_observer::GateObserver;
use crate::options::ClockChoice;
use crate::outcome::{ProgramOutcome, ProgramResult, ResultCollector};
use crate::running::Controller;
use crate::start::{PreparedController, StartError, StartOptions};

/// Time between two questions to the owner whether to go on.
const ASK_EVERY: Duration = Duration::from_millis(20);
/// A program that was stopped has so long to unwind and to bring the arm to rest.
const END_MAX: Duration = Duration::from_secs(10);
/// A program that has said that it ended is gone after so long.
const LEAVING_POLL: Duration = Duration::from_micros(20);

/// Who the sender of its programs is, for messages.
const SENDER: &str = "the owner of the controller";

/// A reason why a call could not do what it was asked for.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum SteppedError {
    /// A program runs.
    #[error("a program is running; stop it first, or let it run to its end")]
    #[zh("程序正在运行；请先停止它，或让它运行到结束")]
    Running,
    /// No program was started.
    #[error("no program was started")]
    #[zh("没有启动程序")]
    NoProgram,
    /// The program could not be started.
    #[error(transparent)]
    Submit(#[from] SubmitError),
    /// A program computes without end.
    #[error(
        "no simulated time passed for {} s: the program computes without waiting; it was stopped{}",
        .wall.as_secs_f64(),
        in_line(*.line)
    )]
    #[zh("{} s 内没有仿真时间经过：程序只计算不等待；已停止{}", .wall.as_secs_f64(), in_line(*.line))]
    Stuck {
        /// Longest time without progress.
        wall: Duration,
        /// Line where the program stood, 0 unknown.
        line: u32,
    },
    /// The program was told to stop and does not.
    #[error("the program was stopped and has not ended within {} s", END_MAX.as_secs())]
    #[zh("程序被停止，但在 {} s 内没有结束", END_MAX.as_secs())]
    DoesNotEnd,
    /// The control cycle met a fault of ours.
    #[error("{0}")]
    Fault(Text),
}

/// Longest time that a call may take.
pub struct WallTimeout<'a> {
    /// Longest time of the machine without simulated time passing.
    pub wall: Duration,
    /// Is asked now and then whether to go on.
    pub keep_going: &'a mut dyn FnMut() -> bool,
}

/// What a call met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum WaitResult {
    /// The program used what it was allowed and waits for more.
    Waits,
    /// The program has ended.
    Ended,
    /// The program computes without end.
    Stuck,
    /// The owner does not want to go on.
    Interrupted,
}

/// A controller that passes time for its owner only. Its calls may come from any thread, one at a time but for
/// [`request_stop`](Self::request_stop) and those that only read.
pub struct SteppedController {
    controller: Controller,
    gate: Arc<CycleGate>,
    collector: Arc<ResultCollector>,
    runtime: Runtime,
    program: Mutex<SteppedProgram>,
    scene: CollisionScene,
}

/// The newest program.
#[derive(Default)]
struct SteppedProgram {
    /// Simulated time when the program began, s.
    began: f64,
    is_open: bool,
    result: Option<ProgramResult>,
}

impl SteppedController {
    /// Starts a controller; `observer` is told of everything. The clock of the settings is taken as virtual.
    ///
    /// # Errors
    /// [`StartError`], in a sentence.
    pub fn open(
        config: &ControllerConfig,
        observer: Arc<dyn Observer>,
    ) -> Result<Self, StartError> {
        Self::open_with(config, StartOptions::for_single_run(), observer)
    }

    /// [`open`](Self::open) with other options of the start.
    ///
    /// # Errors
    /// [`StartError`], in a sentence.
    pub fn open_with(
        config: &ControllerConfig,
        options: StartOptions,
        observer: Arc<dyn Observer>,
    ) -> Result<Self, StartError> {
        let config = ControllerConfig {
            clock: ClockChoice::Virtual,
            ..config.clone()
        };
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()?;
        let prepared = PreparedController::new(&config, options)?;
        let scene = prepared.collision_scene();
        let collector = Arc::new(ResultCollector::new(observer));
        let herald = Arc::new(GateObserver::new(collector.clone()));
        let mut gate = None;
        let controller = prepared.start_with_timeline(
            herald.clone(),
            Instrumentation::default(),
            |timeline| gate.insert(Arc::new(CycleGate::new(timeline))).clone(),
        )?;
        // The closure is called once, or the start has failed.
        let gate = gate
            .ok_or_else(|| io::Error::other(text!("the clock was not started", "时钟没有启动")))?;
        herald.connect(&gate);
        collector.follower().connect(controller.robot());
        Ok(Self {
            controller,
            gate,
            collector,
            runtime,
            program: Mutex::default(),
            scene,
        })
    }

    /// The arm among what its cell file describes, for whoever measures distances.
    pub fn collision_scene(&self) -> CollisionScene {
        self.scene.clone()
    }

    /// The controller behind it.
    pub const fn controller(&self) -> &Controller {
        &self.controller
    }

    /// What the newest program said, and the peaks since it began.
    pub const fn collector(&self) -> &Arc<ResultCollector> {
        &self.collector
    }

    /// The state after the latest cycle.
    pub fn state(&self) -> RobotState {
        self.controller.robot().state()
    }

    /// True while a program runs.
    pub fn is_running(&self) -> bool {
        self.controller.supervisor().status().state != TaskState::Stopped
    }

    /// How the newest program ended, once it has.
    pub fn result(&self) -> Option<ProgramResult> {
        if self.program.lock().is_open && !self.is_running() {
            return Some(self.close_program(None));
        }
        self.program.lock().result.clone()
    }

    /// Starts a program and lets it come to where it first waits; no time passes.
    ///
    /// # Errors
    /// [`SteppedError::Running`], [`SteppedError::Submit`], [`SteppedError::Stuck`].
    pub fn start(
        &self,
        text: ProgramText,
        patience: &mut WallTimeout<'_>,
    ) -> Result<(), SteppedError> {
        if self.is_running() {
            return Err(SteppedError::Running);
        }
        let robot = self.controller.robot();
        robot.pump();
        self.collector.begin();
        *self.program.lock() = SteppedProgram {
            began: robot.state().time,
            is_open: true,
            result: None,
        };
        self.gate.task_begins();
        let submitting = self.controller.supervisor().submit(text, SENDER);
        if let Err(error) = self.runtime.block_on(submitting) {
            self.program.lock().is_open = false;
            return Err(error.into());
        }
        match self.wait_for_program(patience) {
            WaitResult::Waits | WaitResult::Interrupted => Ok(()),
            WaitResult::Ended => {
                self.close_program(None);
                Ok(())
            }
            WaitResult::Stuck => self.abort_stuck_program(patience),
        }
    }

    /// Lets the running program go on to its end, for at most `simulated` seconds. Interrupted, it is stopped.
    ///
    /// # Errors
    /// [`SteppedError::NoProgram`], [`SteppedError::DoesNotEnd`], [`SteppedError::Fault`].
    pub fn run_to_end(
        &self,
        simulated: Seconds,
        patience: &mut WallTimeout<'_>,
    ) -> Result<ProgramResult, SteppedError> {
        if !self.is_running() {
            return self.result().ok_or(SteppedError::NoProgram);
        }
        let step = Seconds::new(self.state().step_time).unwrap_or_default();
        self.gate.allow(simulated.cycles(step));
        match self.wait_for_program(patience) {
            WaitResult::Ended => Ok(self.close_program(None)),
            WaitResult::Interrupted => self.end_program(None),
            WaitResult::Waits => {
                let text = text!(
                    "TimeoutError: the program had not ended after {} s",
                    "TimeoutError: 程序在 {} s 后没有结束",
                    simulated.get()
                );
                self.end_program(Some(text))
            }
            WaitResult::Stuck => self.end_program(Some(without_time(patience.wall))),
        }
    }

    /// Runs a program to its end, for at most `simulated` seconds. A program that computes without waiting for longer
    /// than the patience has timed out as well. Interrupted, it is stopped.
    ///
    /// # Errors
    /// The errors of [`start`](Self::start) and of [`run_to_end`](Self::run_to_end), without [`SteppedError::Stuck`].
    pub fn run_program(
        &self,
        text: ProgramText,
        simulated: Seconds,
        patience: &mut WallTimeout<'_>,
    ) -> Result<ProgramResult, SteppedError> {
        match self.start(text, patience) {
            Ok(()) => self.run_to_end(simulated, patience),
            Err(SteppedError::Stuck { .. }) => self.result().ok_or(SteppedError::NoProgram),
            Err(error) => Err(error),
        }
    }

    /// Lets `cycles` pass, with the program for as long as it runs. False when the owner did not want to go on.
    ///
    /// # Errors
    /// [`SteppedError::Stuck`], [`SteppedError::Fault`].
    pub fn advance(
        &self,
        cycles: u64,
        patience: &mut WallTimeout<'_>,
    ) -> Result<bool, SteppedError> {
        let mut left = cycles;
        // One that ended without a cycle, because of a fault, is closed here.
        drop(self.result());
        if self.is_running() && left > 0 {
            self.gate.allow(left);
            match self.wait_for_program(patience) {
                WaitResult::Waits => return Ok(true),
                WaitResult::Ended => {
                    self.close_program(None);
                    left = self.gate.revoke();
                }
                WaitResult::Interrupted => {
                    self.gate.revoke();
                    return Ok(false);
                }
                WaitResult::Stuck => return self.abort_stuck_program(patience).map(|()| false),
            }
        }
        self.advance_idle(left, patience)
    }

    /// Lets cycles pass until `holds` says so, which is asked before the first and after every one; false when
    /// `simulated` seconds have passed, or the owner did not want to go on.
    ///
    /// # Errors
    /// The errors of [`advance`](Self::advance), and those of `holds`.
    pub fn advance_until<E: From<SteppedError>>(
        &self,
        mut holds: impl FnMut(&RobotState) -> Result<bool, E>,
        simulated: Seconds,
        patience: &mut WallTimeout<'_>,
    ) -> Result<bool, E> {
        let state = self.state();
        if holds(&state)? {
            return Ok(true);
        }
        let step = Seconds::new(state.step_time).unwrap_or_default();
        let mut asked = Instant::now();
        for _ in 0..simulated.cycles(step) {
            if !self.advance(1, patience)? {
                return Ok(false);
            }
            // A single cycle is too short for `advance` to ask.
            if asked.elapsed() >= ASK_EVERY {
                asked = Instant::now();
                if !(patience.keep_going)() {
                    return Ok(false);
                }
            }
            if holds(&self.state())? {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Ends the running program; the arm stands when this returns. The result of the newest program, if there was one.
    ///
    /// # Errors
    /// [`SteppedError::DoesNotEnd`].
    pub fn stop(&self) -> Result<Option<ProgramResult>, SteppedError> {
        if self.is_running() {
            return self.end_program(None).map(Some);
        }
        Ok(self.result())
    }

    /// Tells the running program to stop, while another call lets it run; that call sees its end.
    pub fn request_stop(&self) {
        self.controller.supervisor().stop();
    }

    /// Ends everything, in order. True when the recording was written to its end.
    ///
    /// # Errors
    /// [`SteppedError::DoesNotEnd`]: threads of the controller are left behind.
    pub fn shut_down(self) -> Result<bool, SteppedError> {
        if let Err(error) = self.stop() {
            // The program still uses everything.
            std::mem::forget(self);
            return Err(error);
        }
        self.gate.open();
        Ok(self.controller.shut_down())
    }

    /// Waits for what the program does with the cycles it is allowed.
    fn wait_for_program(&self, patience: &mut WallTimeout<'_>) -> WaitResult {
        let (mut used, mut since) = (None, Instant::now());
        loop {
            let seen = self.gate.wait_for_task(ASK_EVERY);
            if seen.over {
                while self.is_running() {
                    thread::sleep(LEAVING_POLL);
                }
                return WaitResult::Ended;
            }
            if seen.waits {
                return WaitResult::Waits;
            }
            if used != Some(seen.used) {
                (used, since) = (Some(seen.used), Instant::now());
            } else if since.elapsed() >= patience.wall {
                return WaitResult::Stuck;
            }
            if !(patience.keep_going)() {
                return WaitResult::Interrupted;
            }
        }
    }

    /// Cycles without a program.
    fn advance_idle(
        &self,
        cycles: u64,
        patience: &mut WallTimeout<'_>,
    ) -> Result<bool, SteppedError> {
        let (robot, mut since) = (self.controller.robot(), Instant::now());
        let mut asked = since;
        let mut left = cycles;
        while left > 0 {
            if self.gate.advance_ungated() {
                robot.pump();
                left -= 1;
                since = Instant::now();
            } else if robot.timeline().has_ended() || since.elapsed() >= patience.wall {
                return Err(self.fault());
            }
            if asked.elapsed() >= ASK_EVERY {
                asked = Instant::now();
                if !(patience.keep_going)() {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }

    fn fault(&self) -> SteppedError {
        let fault = self.controller.faults().fatal().map(Text::of);
        SteppedError::Fault(fault.unwrap_or_else(|| {
            text!(
                "the recording takes nothing, no time can pass",
                "记录不再接收数据，时间无法前进"
            )
        }))
    }

    /// Ends a program that computes without end, and says so.
    fn abort_stuck_program(&self, patience: &WallTimeout<'_>) -> Result<(), SteppedError> {
        let wall = patience.wall;
        self.end_program(Some(without_time(wall)))?;
        let line = self.collector.line();
        Err(SteppedError::Stuck { wall, line })
    }

    /// Ends the running program by force; `given_up` says why, if it was because of a time-out.
    fn end_program(&self, given_up: Option<Text>) -> Result<ProgramResult, SteppedError> {
        // Whoever stopped it before the time was over has ended it.
        let was_ending = self.controller.supervisor().status().ending;
        self.controller.supervisor().stop();
        self.gate.open();
        let since = Instant::now();
        while !self.gate.wait_for_task(ASK_EVERY).over {
            if since.elapsed() >= END_MAX {
                return Err(SteppedError::DoesNotEnd);
            }
        }
        while self.is_running() {
            thread::sleep(LEAVING_POLL);
        }
        Ok(self.close_program(given_up.filter(|_| !was_ending)))
    }

    /// Makes the result of a program that has ended.
    fn close_program(&self, given_up: Option<Text>) -> ProgramResult {
        let robot = self.controller.robot();
        robot.pump();
        let mut program = self.program.lock();
        if let (false, Some(result)) = (program.is_open, &program.result) {
            return result.clone();
        }
        let end = self.controller.supervisor().status().end;
        let outcome = match (&given_up, &end) {
            (Some(_), _) => ProgramOutcome::Timeout,
            (None, Some(end)) => end.into(),
            (None, None) => ProgramOutcome::Failed,
        };
        let time = robot.state().time - program.began;
        let result = self.collector.result(outcome, time, given_up);
        program.is_open = false;
        program.result = Some(result.clone());
        result
    }
}

fn without_time(wall: Duration) -> Text {
    text!(
        "TimeoutError: no simulated time passed for {} s: the program computes without waiting",
        "TimeoutError: {} s 内没有仿真时间经过：程序只计算不等待",
        wall.as_secs_f64()
    )
}

fn in_line(line: u32) -> Text {
    match line {
        0 => Text::verbatim(""),
        line => text!(" in line {line}", "（第 {line} 行）"),
    }
}
