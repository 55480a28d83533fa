//! What the arm did in the course of a test: every cycle for conditions and paths, peaks for everything else.

use std::sync::Arc;

use controller::Peaks;
use controller::cell_world::topic::WorldMessage;
use controller::program_position::{PositionTracker, ProgramPosition};
use elite_runtime::message::Observer;
use elite_syntax::TaskNode;
use motion_api::{CycleFrame, ProgramId, RobotState, ThreadNumber};
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

/// Keeps the cycles of a test.
#[derive(Default)]
pub(crate) struct CycleTrace(Mutex<TraceData>);

#[derive(Default)]
struct TraceData {
    states: Vec<RobotState>,
    /// What the program did, from which of the states on.
    doings: Vec<(usize, ProgramPosition)>,
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

    /// What the program did in the cycle with this number.
    pub(crate) fn position_at(&self, cycle: usize) -> ProgramPosition {
        let kept = self.0.lock();
        let after = kept.doings.partition_point(|(from, _)| *from <= cycle);
        let before = after
            .checked_sub(1)
            .and_then(|place| kept.doings.get(place));
        before.map(|(_, doing)| doing.clone()).unwrap_or_default()
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

    fn take(&self, state: &RobotState, doing: &ProgramPosition) {
        let mut kept = self.0.lock();
        kept.peaks.update(state);
        let from = kept.states.len();
        if from < CYCLES_MAX && kept.doings.last().is_none_or(|(_, last)| last != doing) {
            kept.doings.push((from, doing.clone()));
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
        self.follower
            .with_position(|doing| self.trace.take(&frame.state, doing));
    }
}
