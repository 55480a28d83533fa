//! A recorded run that passes again: the arm is moved by the recorded commands, the programs are run beside and
//! compared.
//!
//! Owns the clock of such a run and the order in which its programs begin. What comes to a program in which turn is in
//! `elite_runtime::external`.

use std::collections::VecDeque;
use std::io;
use std::sync::Arc;

use elite_runtime::external::Rerun;
use elite_runtime::message::Observer;
use elite_runtime::{Instrumentation, TaskEnd};
use messages::text;
use motion_api::{CommandSender, ProgramId, Registers, RobotState, SnapshotCell, Timeline};
use parking_lot::Mutex;
use recorder::CommandMessage;

use crate::command_replay::CommandReplayer;
use crate::recorded_run::RecordedRun;
use crate::register_write::RegisterWrite;
use crate::running::Controller;
use crate::start::{PreparedController, StartError};

/// Looks at every cycle; false ends the repetition.
pub type CycleCallback = Box<dyn FnMut(&RobotState) -> bool + Send>;

/// A clock that gives what was recorded before each cycle.
struct RerunTimeline {
    inner: Arc<dyn Timeline>,
    port: CommandSender,
    registers: Arc<Registers>,
    snapshot: Arc<SnapshotCell>,
    repeat: Arc<Rerun>,
    left: Mutex<RemainingCommands>,
}

/// What is left to give.
struct RemainingCommands {
    commands: VecDeque<CommandMessage>,
    writes: VecDeque<RegisterWrite>,
    feed: CommandReplayer,
    look: CycleCallback,
    trouble: Option<String>,
}

impl Timeline for RerunTimeline {
    fn is_virtual(&self) -> bool {
        true
    }

    fn advance(&self) -> bool {
        let mut left = self.left.lock();
        let latest = self.snapshot.cycle_time().cycle;
        if !self.repeat.allow_cycle_after(latest) {
            return false;
        }
        let next = latest + 1;
        let left = &mut *left;
        while let Some(message) = left.commands.pop_front_if(|message| message.cycle <= next) {
            match left.feed.give(&self.port, &message) {
                Ok(Some(command)) => self.repeat.is_due(&command, next),
                Ok(None) => {}
                Err(error) => {
                    left.trouble = Some(error.to_string());
                    self.repeat.finish();
                    return false;
                }
            }
        }
        while let Some(write) = left.writes.pop_front_if(|write| write.cycle <= next) {
            write.apply(&self.registers);
        }
        if !self.inner.advance() {
            return false;
        }
        if !(left.look)(&self.snapshot.read()) {
            self.repeat.finish();
        }
        true
    }

    fn set_driven(&self, on: bool) {
        self.inner.set_driven(on);
    }

    fn has_ended(&self) -> bool {
        self.inner.has_ended()
    }
}

/// A controller that repeats a recorded run.
pub struct RerunController {
    controller: Controller,
    again: Arc<RerunTimeline>,
    repeat: Arc<Rerun>,
}

impl RerunController {
    /// Prepares the arm of the recording; `look` sees every cycle.
    ///
    /// # Errors
    /// [`StartError`], in a sentence.
    pub fn start(
        run: &RecordedRun,
        observer: Arc<dyn Observer>,
        extras: Instrumentation,
        look: CycleCallback,
    ) -> Result<Self, StartError> {
        let repeat = run.repeat();
        let prepared = PreparedController::of_recording(
            run.setup(),
            repeat.clone(),
            run.world_inputs.clone(),
        )?;
        let (port, registers) = prepared.command_inputs();
        let snapshot = prepared.snapshot().clone();
        let left = RemainingCommands {
            commands: run.commands.clone(),
            writes: run.writes.clone(),
            feed: CommandReplayer::default(),
            look,
            trouble: None,
        };
        let mut clock = None;
        let shared = repeat.clone();
        let controller = prepared.start_with_timeline(observer, extras, |inner| {
            let again = Arc::new(RerunTimeline {
                inner,
                port,
                registers,
                snapshot,
                repeat: shared,
                left: Mutex::new(left),
            });
            clock = Some(again.clone());
            again
        })?;
        controller.robot().set_rerun(repeat.clone());
        // The door is gone through once, above.
        let again = clock
            .ok_or_else(|| io::Error::other(text!("the clock was not made", "没有建立时钟")))?;
        Ok(Self {
            controller,
            again,
            repeat,
        })
    }

    /// The controller.
    pub const fn controller(&self) -> &Controller {
        &self.controller
    }

    /// What is compared.
    pub const fn repeat(&self) -> &Arc<Rerun> {
        &self.repeat
    }

    /// What kept a recorded command from being given.
    pub fn trouble(&self) -> Option<String> {
        self.again.left.lock().trouble.clone()
    }

    /// Runs the programs in their order, up to and with `last`, or all of them and then the cycles that are left. Gives
    /// the end of the last one that began.
    ///
    /// # Errors
    /// The operating system gave no runtime.
    pub fn run(&self, run: &RecordedRun, last: Option<ProgramId>) -> io::Result<Option<TaskEnd>> {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()?;
        let supervisor = self.controller.supervisor();
        let mut end = None;
        for (id, begins) in self.repeat.programs() {
            self.advance_to(begins);
            let Some(program) = run.program(id) else {
                continue;
            };
            if self.repeat.departure().is_some() {
                break;
            }
            let presets = RecordedRun::presets(&self.repeat, id);
            if supervisor
                .rerun_program(id, program.clone(), &presets)
                .is_err()
            {
                break;
            }
            end = runtime.block_on(supervisor.ended());
            if last == Some(id) {
                return Ok(end);
            }
        }
        if last.is_none() {
            self.advance_to(u64::MAX);
        }
        Ok(end)
    }

    /// Lets cycles pass that no program sees.
    fn advance_to(&self, cycle: u64) {
        let robot = self.controller.robot();
        while robot.moment().cycle < cycle && self.again.advance() {
            robot.pump();
        }
    }

    /// Ends the controller.
    pub fn shut_down(self) {
        self.controller.shut_down();
    }
}
