//! Every cycle, as clients of cyclic data want it: the snapshot with what is known beside it, broadcast once.
//!
//! Called on whichever thread takes the events of a cycle (the pump under the real clock, the task's under the virtual
//! one), for every cycle in order, also when that thread was held up; waits for nobody. Who listens too slowly loses
//! the oldest cycles.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, OnceLock};

use elite_runtime::{TaskState, TaskStatus as SupervisorStatus};
use elite_syntax::TaskNode;
use kinematics::{JointSpeeds, RobotModel};
use motion_api::{CycleFrame, RobotState, ThreadNumber};
use parking_lot::Mutex;
use tokio::sync::{broadcast, watch};

use crate::ports::description::{Peripherals, TaskStatus};
use crate::ports::http::page::ShownProgram;
use crate::ports::sample::{Sample, SampleDecimator};

/// How many cycles a listener may be behind before it loses some: a quarter of a second.
const CYCLES_WAITING_MAX: usize = 64;

/// The broadcast, and what its samples are made of beside the snapshot.
pub struct SampleFeed {
    model: Arc<RobotModel>,
    samples: broadcast::Sender<Arc<Sample>>,
    beats: SampleDecimator,
    task: OnceLock<watch::Receiver<SupervisorStatus>>,
    script_line: AtomicU32,
    /// Only read for people, never in a cycle.
    script_node: Mutex<Option<TaskNode>>,
    /// The newest main programs, for people.
    programs: Mutex<VecDeque<ShownProgram>>,
    /// Somebody waits for the next line.
    has_step: AtomicBool,
    step: Mutex<Option<LineStep>>,
}

/// What is done at the first line that is another one.
struct LineStep {
    from: u32,
    then: Box<dyn FnOnce() + Send>,
}

/// Programs whose text is kept for people.
const PROGRAMS_MAX: usize = 8;
/// Bytes of all their texts.
const PROGRAM_BYTES_MAX: usize = 8 << 20;

impl SampleFeed {
    /// A feed without listeners.
    pub fn new(model: Arc<RobotModel>) -> Self {
        Self {
            model,
            samples: broadcast::channel(CYCLES_WAITING_MAX).0,
            beats: SampleDecimator::default(),
            task: OnceLock::new(),
            script_line: AtomicU32::new(0),
            script_node: Mutex::default(),
            programs: Mutex::default(),
            has_step: AtomicBool::new(false),
            step: Mutex::default(),
        }
    }

    /// A main program is about to run.
    pub fn program_runs(&self, program: ShownProgram) {
        let mut programs = self.programs.lock();
        programs.push_back(program);
        let bytes = |programs: &VecDeque<ShownProgram>| -> usize {
            programs.iter().map(|program| program.text.len()).sum()
        };
        while programs.len() > PROGRAMS_MAX
            || (programs.len() > 1 && bytes(&programs) > PROGRAM_BYTES_MAX)
        {
            programs.pop_front();
        }
    }

    /// A program that has run lately.
    pub fn program(&self, number: u32) -> Option<ShownProgram> {
        let programs = self.programs.lock();
        let mut programs = programs.iter();
        programs.find(|program| program.number == number).cloned()
    }

    /// The line of the main thread that was told last; 0 where none was.
    pub fn line(&self) -> u32 {
        self.script_line.load(Ordering::Relaxed)
    }

    /// At the first line of the main thread that is not the one of now, `then` is called, once, on the program's
    /// thread.
    pub fn at_next_line(&self, then: Box<dyn FnOnce() + Send>) {
        let from = self.script_line.load(Ordering::Relaxed);
        *self.step.lock() = Some(LineStep { from, then });
        self.has_step.store(true, Ordering::Release);
    }

    fn step_at(&self, line: u32) {
        if !self.has_step.load(Ordering::Acquire) {
            return;
        }
        let due = self.step.lock().take_if(|step| step.from != line);
        if let Some(step) = due {
            self.has_step.store(false, Ordering::Release);
            (step.then)();
        }
    }

    /// Samples tell the status of the task from now on. Only the first call counts.
    pub fn follow(&self, task: watch::Receiver<SupervisorStatus>) {
        // There is one supervisor; another would tell the same.
        let _ = self.task.set(task);
    }

    /// Every cycle from now on.
    pub fn subscribe(&self) -> broadcast::Receiver<Arc<Sample>> {
        self.samples.subscribe()
    }

    /// One cycle in a tenth of a second.
    pub const fn beats(&self) -> &SampleDecimator {
        &self.beats
    }

    /// What the main task is doing.
    pub fn task_status(&self) -> TaskStatus {
        let state = self.task.get().map(|task| task.borrow().state);
        state.map_or(TaskStatus::Stopped, task_status)
    }

    /// A script thread stands at another line or node; the main thread's are those that clients see.
    pub fn line_changed(&self, thread: ThreadNumber, line: u32, node: Option<&TaskNode>) {
        if thread == ThreadNumber(0) {
            self.script_line.store(line, Ordering::Relaxed);
            *self.script_node.lock() = node.cloned();
            self.step_at(line);
        }
    }

    /// The line and the node of the pendant's task in which the main thread is; 0 while no program runs.
    pub fn place(&self) -> (u32, Option<TaskNode>) {
        let line = self.script_line.load(Ordering::Relaxed);
        (line, self.script_node.lock().clone())
    }

    /// No line is executed any more.
    pub fn program_ended(&self) {
        self.script_line.store(0, Ordering::Relaxed);
        *self.script_node.lock() = None;
        self.has_step.store(false, Ordering::Release);
        *self.step.lock() = None;
    }

    /// Shows a cycle to whoever listens.
    pub fn cycle_ended(&self, frame: &CycleFrame) {
        let is_beat = self.beats.is_due(frame.state.time);
        let is_followed = self.samples.receiver_count() > 0;
        if !is_beat && !is_followed {
            return;
        }
        let sample = Arc::new(self.sample(frame));
        if is_beat {
            self.beats.publish(sample.clone());
        }
        if is_followed {
            // That the last listener has gone in between is fine.
            let _ = self.samples.send(sample);
        }
    }

    /// What listeners are shown of a cycle.
    pub fn sample(&self, frame: &CycleFrame) -> Sample {
        let state = &frame.state;
        Sample {
            state: *state,
            task: self.task_status(),
            script_line: self.script_line.load(Ordering::Relaxed),
            elbow_velocity: elbow_velocity(&self.model, state),
            registers: frame.registers,
            peripherals: Peripherals::of(state),
        }
    }
}

/// The task's state in the words of the ports.
pub const fn task_status(state: TaskState) -> TaskStatus {
    match state {
        TaskState::Stopped => TaskStatus::Stopped,
        TaskState::Running => TaskStatus::Running,
        TaskState::Paused => TaskStatus::Paused,
    }
}

/// Velocity of the elbow, m/s in the base frame. It lies on the second link: only the first two joints move it.
pub(crate) fn elbow_velocity(model: &RobotModel, state: &RobotState) -> [f64; 3] {
    let frames = model.forward(&state.actual_q);
    let moving = JointSpeeds([state.actual_qd[0], state.actual_qd[1], 0.0, 0.0, 0.0, 0.0]);
    frames.twist(&moving, frames.elbow()).linear.into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use kinematics::JointPositions;
    use motion_api::RegisterImages;

    fn feed() -> SampleFeed {
        SampleFeed::new(Arc::new(RobotModel::built_in("cs66").unwrap()))
    }

    fn frame(state: RobotState) -> CycleFrame {
        let registers = RegisterImages::default();
        CycleFrame { state, registers }
    }

    #[test]
    fn the_velocity_of_the_elbow_is_the_derivative_of_its_position() {
        let feed = feed();
        let mut listener = feed.subscribe();
        let q = JointPositions([0.3, -1.2, 0.9, 0.1, -0.4, 0.7]);
        let mut state = RobotState::at_start(q, 0.004);
        state.actual_qd = JointSpeeds([0.8, -0.5, 1.1, 0.3, 0.2, 0.1]);
        feed.cycle_ended(&frame(state));
        let velocity = listener.try_recv().unwrap().elbow_velocity;
        let dt = 1e-6;
        let later = JointPositions(std::array::from_fn(|j| q[j] + state.actual_qd[j] * dt));
        let model = RobotModel::built_in("cs66").unwrap();
        let difference = model.forward(&later).elbow() - model.forward(&q).elbow();
        for axis in 0..3 {
            assert!((velocity[axis] - difference[axis] / dt).abs() < 1e-5);
        }
    }

    #[test]
    fn the_line_is_that_of_the_main_thread_and_ends_with_the_program() {
        let feed = feed();
        let state = frame(RobotState::at_start(JointPositions::ZERO, 0.004));
        let node = TaskNode {
            number: 4,
            label: "接近点".into(),
        };
        feed.line_changed(ThreadNumber(0), 7, Some(&node));
        feed.line_changed(ThreadNumber(3), 9, None);
        assert_eq!(feed.sample(&state).script_line, 7);
        assert_eq!(feed.place(), (7, Some(node)));
        feed.program_ended();
        assert_eq!(feed.place(), (0, None));
        assert_eq!(feed.sample(&state).script_line, 0);
    }
}
