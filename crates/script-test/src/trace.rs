//! What the arm did in the course of a test: every cycle for conditions and paths, peaks for everything else.

use std::sync::{Arc, OnceLock, Weak};

use controller::Peaks;
use controller::cell_world::topic::WorldMessage;
use controller::program_position::{PositionTracker, ProgramPosition};
use elite_runtime::Robot;
use elite_runtime::message::Observer;
use elite_syntax::TaskNode;
use motion_api::{CommandId, CycleFrame, ProgramId, RobotState, ThreadNumber};
use parking_lot::Mutex;

/// Cycles that are kept; what comes after them is counted only. At 4 ms it is the first 400 s of a test.
const CYCLES_MAX: usize = 100_000;

/// Rows of parts that are kept; some 400 MB.
const WORLD_ROWS_MAX: usize = 2_000_000;

/// A place on the way of the TCP.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PathSample {
    /// Simulated time, s.
    pub time: f64,
    /// Pose of the TCP in the base frame: m and rad (roll, pitch, yaw).
    pub pose: [f64; 6],
}

/// What moves the arm in a cycle.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Mover {
    /// What the program beside the test does.
    pub program: ProgramPosition,
    /// Line of the test that asked for the running command; 0 where the test did not.
    pub test_line: u32,
}

/// Keeps the cycles of a test.
#[derive(Default)]
pub(crate) struct CycleTrace(Mutex<TraceData>);

#[derive(Default)]
struct TraceData {
    states: Vec<RobotState>,
    /// What moved the arm, from which of the states on.
    movers: Vec<(usize, Mover)>,
    missed: usize,
    peaks: Peaks,
    /// What was new among the parts of the cell, in the order of cycles.
    world: Vec<WorldMessage>,
    world_rows: usize,
}

impl CycleTrace {
    /// The peaks of the test so far.
    pub(crate) fn peaks(&self) -> Peaks {
        self.0.lock().peaks
    }

    /// The cycles from number `from` on of those that are kept, and how many were not.
    pub(crate) fn since(&self, from: usize, most: usize) -> (Vec<RobotState>, usize) {
        let kept = self.0.lock();
        let states = kept.states.iter().skip(from).take(most);
        (states.copied().collect(), kept.missed)
    }

    /// What moved the arm in the cycle with this number.
    pub(crate) fn mover_at(&self, cycle: usize) -> Mover {
        let kept = self.0.lock();
        let after = kept.movers.partition_point(|(from, _)| *from <= cycle);
        let before = after
            .checked_sub(1)
            .and_then(|place| kept.movers.get(place));
        before.map(|(_, mover)| mover.clone()).unwrap_or_default()
    }

    /// Keeps what is new among the parts of the cell, as long as cycles are kept.
    pub(crate) fn take_world(&self, message: &WorldMessage) {
        let mut kept = self.0.lock();
        if kept.states.len() < CYCLES_MAX && kept.world_rows < WORLD_ROWS_MAX {
            kept.world_rows += 1 + message.parts.len();
            kept.world.push(message.clone());
        }
    }

    /// Shows the messages from number `from` on up to a cycle; the number of the next one.
    pub(crate) fn each_world_message(
        &self,
        from: usize,
        cycle: u64,
        mut see: impl FnMut(&WorldMessage),
    ) -> usize {
        let kept = self.0.lock();
        let new = kept
            .world
            .iter()
            .skip(from)
            .take_while(|message| message.cycle <= cycle);
        from + new.inspect(|message| see(message)).count()
    }

    /// The path of the TCP so far.
    pub(crate) fn tcp_path(&self) -> Vec<PathSample> {
        let kept = self.0.lock();
        let place = |state: &RobotState| PathSample {
            time: state.time,
            pose: state.actual_tcp_pose.to_array(),
        };
        kept.states.iter().map(place).collect()
    }

    fn take(&self, state: &RobotState, program: &ProgramPosition, test_line: u32) {
        let mut kept = self.0.lock();
        kept.peaks.update(state);
        let from = kept.states.len();
        let is_new = |last: &Mover| last.test_line != test_line || last.program != *program;
        if from < CYCLES_MAX && kept.movers.last().is_none_or(|(_, last)| is_new(last)) {
            let program = program.clone();
            kept.movers.push((from, Mover { program, test_line }));
        }
        match kept.states.len() < CYCLES_MAX {
            true => kept.states.push(*state),
            false => kept.missed += 1,
        }
    }
}

/// Shows every cycle to a trace, with what the program beside the test does in it.
#[derive(Default)]
pub(crate) struct TraceObserver {
    pub trace: Arc<CycleTrace>,
    pub follower: Arc<PositionTracker>,
    pub commands: Arc<TestCommands>,
}

/// Knows which commands the test itself has given.
#[derive(Default)]
pub(crate) struct TestCommands {
    robot: OnceLock<Weak<Robot>>,
    /// The test, once it is started.
    test: OnceLock<ProgramId>,
}

impl TestCommands {
    /// Says whose commands they are, once.
    pub(crate) fn connect(&self, robot: &Arc<Robot>) {
        let _ = self.robot.set(Arc::downgrade(robot));
    }

    /// Says which program is the test, once.
    pub(crate) fn set_test(&self, test: ProgramId) {
        let _ = self.test.set(test);
    }

    /// The line of the test that asked for this command; 0 for a command of others.
    fn line_of(&self, command: CommandId) -> u32 {
        let robot = self.robot.get().and_then(Weak::upgrade);
        let origin = robot.and_then(|robot| Some(robot.command(command)?.origin));
        let of_test = origin.filter(|origin| self.test.get() == Some(&origin.program));
        of_test.map_or(0, |origin| origin.line)
    }
}

impl Observer for TraceObserver {
    fn program_started(&self, _: ProgramId, name: &str, _: &str) {
        self.follower.program_started(name);
    }

    fn line_changed(&self, _: ProgramId, thread: ThreadNumber, line: u32, _: Option<&TaskNode>) {
        self.follower.line_changed(thread, line);
    }
    fn program_ended(&self, _: ProgramId) {
        self.follower.program_ended();
    }

    fn cycle_ended(&self, frame: &CycleFrame) {
        self.follower.cycle_ended(&frame.state);
        let test_line = self.commands.line_of(frame.state.command_id);
        self.follower
            .with_position(|program| self.trace.take(&frame.state, program, test_line));
    }
}
