//! What a test works on: the arm with the program beside it, what is to happen when, what was found.
//!
//! Shared by the thread of the test, which asks, the thread of the program, which passes cycles, and the thread that
//! runs the test and does what neither of them may: start programs and judge conditions. Owns no functions of the
//! script: those are `object`'s.

use std::ops::Deref;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Arc, OnceLock};
use std::thread;
use std::time::Duration;

use controller::clearance::ClearanceObserver;
use controller::io_values::PointChange;
use controller::outcome::ResultCollector;
use controller::{CellWorld, ProgramOutcome, ProgramResult};
use elite_runtime::{ProgramText, Robot, Supervisor, TaskState};
use io_bus::{Fieldbus, SimulatedPeers};
use messages::{Localized, Text, text};
use motion_api::{CommandKind, Origin, Seconds, SettingCommand};
use parking_lot::Mutex;
use tokio::sync::mpsc::UnboundedSender;

use crate::files::FileScope;
use crate::golden_path::GoldenMode;
use crate::lockstep::LockstepTimeline;
use crate::simulated_peers::PeerRegistry;
use crate::trace::CycleTrace;

/// Acts that may wait for their time.
const ACTS_MAX: usize = 10_000;
/// A program that has left its last turn is gone after so long; longer is a fault of ours.
const LEAVING_MAX: Duration = Duration::from_secs(10);
const LEAVING_POLL: Duration = Duration::from_micros(20);

/// What only the thread that runs the test can do.
pub(crate) enum RunnerRequest {
    /// Start a program; the answer comes when it waits for the first time.
    Start(ProgramText, SyncSender<Result<(), Text>>),
    /// Look whether a condition has held so far, and from now on.
    Watch(Invariant, SyncSender<InvariantCheck>),
    /// The test has ended.
    Ended,
}

/// A condition over the whole test.
#[derive(Clone, Debug)]
pub(crate) struct Invariant {
    /// The condition.
    pub text: String,
    /// The condition must always hold; when false, it must never hold.
    pub always: bool,
    /// The line of the test that says so.
    pub line: u32,
}

/// What a condition came to so far.
pub(crate) enum InvariantCheck {
    /// The condition is met so far.
    Kept,
    /// The condition is broken; the sentence says how.
    Broken(Text),
    /// The text is no condition; the sentence says why.
    NoCondition(Text),
}

/// A reason why a program does not run.
#[derive(Debug, thiserror::Error, Localized)]
pub(crate) enum StartError {
    /// The text of the program does not compile.
    #[error("{program} does not compile: line {line}: {reason}")]
    #[zh("{program} 不能编译：第 {line} 行：{reason}")]
    NotCompiled {
        /// Name of the program.
        program: String,
        /// The line of the first finding.
        line: u32,
        /// The finding.
        reason: Text,
    },
    /// One runs already, or none can be started.
    #[error("{0}")]
    Refused(Text),
}

/// Something that happens at the beginning of a cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) enum TestAction {
    /// An input gets a value.
    Set(PointChange),
    /// The robot gets a command.
    Command(CommandKind),
}

/// Everything a test can reach: its parts, and what happens to them.
pub(crate) struct TestContext {
    parts: ContextParts,
    acts: Mutex<ActionQueue>,
    program: Mutex<TestedProgram>,
    /// After this cycle the time of the test is over.
    last_cycle: u64,
    /// Starts and stops the test itself.
    tests: OnceLock<Supervisor>,
    /// Reason why the test was given up, if it was.
    given_up: OnceLock<Text>,
    /// Reason why the robot did not take something, if it refused.
    refused: OnceLock<Text>,
}

#[derive(Default)]
struct ActionQueue {
    /// By cycle; those of one cycle in the order in which they were asked for.
    waiting: Vec<(u64, TestAction)>,
}

/// The program beside the test.
#[derive(Default)]
struct TestedProgram {
    began: f64,
    is_open: bool,
    result: Option<ProgramResult>,
}

impl Deref for TestContext {
    type Target = ContextParts;

    fn deref(&self) -> &ContextParts {
        &self.parts
    }
}

/// The parts of a bench that are made elsewhere.
pub(crate) struct ContextParts {
    pub robot: Arc<Robot>,
    /// The parts of the cell, where it has any.
    pub world: Option<CellWorld>,
    pub fieldbus: Arc<Fieldbus>,
    pub programs: Supervisor,
    pub said: Arc<ResultCollector>,
    pub turns: Arc<LockstepTimeline>,
    pub trace: Arc<CycleTrace>,
    /// Measures distances, where the test asks for them.
    pub clearance: Option<Arc<ClearanceObserver>>,
    pub peers: Arc<PeerRegistry>,
    pub folder: PathBuf,
    pub files: FileScope,
    pub goldens: GoldenMode,
    pub requests: UnboundedSender<RunnerRequest>,
    /// Simulated time of the test, s.
    pub timeout: Seconds,
}

impl TestContext {
    pub(crate) fn new(parts: ContextParts) -> Self {
        let step = Seconds::new(parts.robot.state().step_time).unwrap_or_default();
        let last_cycle = parts.timeout.cycles(step);
        Self {
            parts,
            acts: Mutex::default(),
            program: Mutex::default(),
            last_cycle,
            tests: OnceLock::new(),
            given_up: OnceLock::new(),
            refused: OnceLock::new(),
        }
    }

    /// Says who starts and stops the test, once.
    pub(crate) fn set_supervisor(&self, tests: Supervisor) {
        let _ = self.tests.set(tests);
    }

    /// Ends the test and the program beside it; only the first reason counts.
    pub(crate) fn abort(&self, reason: Text) {
        if self.given_up.set(reason).is_ok() {
            self.programs.stop();
            if let Some(tests) = self.tests.get() {
                tests.stop();
            }
        }
    }

    /// Reason why the test was given up, if it was.
    pub(crate) fn abort_reason(&self) -> Option<&Text> {
        self.given_up.get()
    }

    /// Whether the program beside the test runs.
    pub(crate) fn program_is_running(&self) -> bool {
        self.turns.program_flag().load(Ordering::Acquire)
    }

    /// The cycle that begins after so long; 0 is the next one.
    pub(crate) fn cycle_after(&self, time: Seconds) -> u64 {
        let step = Seconds::new(self.robot.state().step_time).unwrap_or_default();
        self.turns.cycles() + time.cycles(step)
    }

    /// Starts a program; it has come to its first wait when this returns, and no time has passed.
    ///
    /// # Errors
    /// [`StartError`]
    pub(crate) fn start(&self, program: ProgramText) -> Result<(), StartError> {
        if self.program_is_running() {
            let text = text!(
                "a program runs already; wait for its end or stop it first",
                "已有程序在运行；请先等待其结束或将其停止"
            );
            return Err(StartError::Refused(text));
        }
        let name = program.name.clone();
        self.said.begin();
        *self.program.lock() = TestedProgram {
            began: self.robot.state().time,
            is_open: true,
            result: None,
        };
        let (reply, answer) = sync_channel(1);
        let gone = || text!("the test is over", "测试已结束");
        let request = RunnerRequest::Start(program, reply);
        let sent = self.requests.send(request);
        sent.map_err(|_| StartError::Refused(gone()))?;
        let started = answer.recv().unwrap_or_else(|_| Err(gone()));
        if let Err(refused) = started {
            self.program.lock().is_open = false;
            return Err(StartError::Refused(refused));
        }
        match self.said.compile_error() {
            Some((error, line)) => Err(StartError::NotCompiled {
                program: name,
                line,
                reason: crate::runner::in_each_language(&error, |error| {
                    error.trim_start_matches("SyntaxError: ").to_owned()
                }),
            }),
            None => Ok(()),
        }
    }

    /// Asks about a condition.
    pub(crate) fn watch(&self, watched: Invariant) -> InvariantCheck {
        let (reply, answer) = sync_channel(1);
        let gone = || InvariantCheck::NoCondition(text!("the test is over", "测试已结束"));
        match self.requests.send(RunnerRequest::Watch(watched, reply)) {
            Ok(()) => answer.recv().unwrap_or_else(|_| gone()),
            Err(_) => gone(),
        }
    }

    /// The result of the newest program, which has left its last turn; `None` if there was none. `given_up` is the
    /// reason why it was ended, if it was.
    pub(crate) fn close(&self, given_up: Option<Text>) -> Option<ProgramResult> {
        let mut waited = Duration::ZERO;
        while self.programs.status().state != TaskState::Stopped && waited < LEAVING_MAX {
            thread::sleep(LEAVING_POLL);
            waited += LEAVING_POLL;
        }
        let mut program = self.program.lock();
        if program.is_open {
            let end = self.programs.status().end;
            let outcome = match (&given_up, &end) {
                (Some(_), _) => ProgramOutcome::Timeout,
                (None, Some(end)) => end.into(),
                (None, None) => ProgramOutcome::Failed,
            };
            let time = self.robot.state().time - program.began;
            program.result = Some(self.said.result(outcome, time, given_up));
            program.is_open = false;
        }
        program.result.clone()
    }

    /// Has something happen at the beginning of the first cycle that is not before `cycle`.
    ///
    /// # Errors
    /// Too much is waiting.
    pub(crate) fn schedule(&self, cycle: u64, act: TestAction) -> Result<(), Text> {
        let mut acts = self.acts.lock();
        if acts.waiting.len() >= ACTS_MAX {
            return Err(text!(
                "{ACTS_MAX} things wait for their time already",
                "已有 {ACTS_MAX} 件事在等待"
            ));
        }
        let place = acts.waiting.partition_point(|(other, _)| *other <= cycle);
        acts.waiting.insert(place, (cycle, act));
        Ok(())
    }

    /// Does what is due before the cycle with this number.
    pub(crate) fn before_cycle(&self, cycle: u64) {
        self.peers.serve();
        let step = self.robot.state().step_time;
        self.fieldbus
            .modbus
            .poll_simulated_devices(Duration::from_secs_f64(cycle as f64 * step));
        if cycle > self.last_cycle && self.abort_reason().is_none() {
            let time = self.last_cycle as f64 * step;
            self.abort(text!(
                "the test had not ended after {time:.3} s of simulated time (--timeout)",
                "仿真时间 {time:.3} s 后测试仍未结束（--timeout）"
            ));
        }
        loop {
            let act = {
                let mut acts = self.acts.lock();
                match acts.waiting.first() {
                    Some((due, _)) if *due <= cycle => acts.waiting.remove(0).1,
                    _ => return,
                }
            };
            if let Err(refused) = self.act(act) {
                let _ = self.refused.set(refused);
            }
        }
    }

    /// Does something now: it counts from the next cycle on, registers at once.
    ///
    /// # Errors
    /// The motion thread takes nothing.
    pub(crate) fn act(&self, act: TestAction) -> Result<(), Text> {
        let command = match act {
            TestAction::Set(PointChange::Register(direction, value)) => {
                value.write(direction, self.robot.registers());
                return Ok(());
            }
            TestAction::Set(PointChange::Io(change)) => {
                CommandKind::Setting(SettingCommand::SetIo(change))
            }
            TestAction::Command(command) => command,
        };
        let sent = self.robot.send(Origin::default(), command);
        sent.map(drop).map_err(|full| Text::of(&full))
    }

    /// What the robot did not take, if anything.
    pub(crate) fn refused(&self) -> Option<&Text> {
        self.refused.get()
    }
}
