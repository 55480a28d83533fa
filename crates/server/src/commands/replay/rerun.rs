//! `replay --rerun`: the recorded commands on a fresh controller, cycle by cycle.
//!
//! The controller knows no wall time and no other input than its commands and the registers, so every cycle must come
//! out the same, bit for bit. A difference is a bug in one of the two runs, or they are of different versions.

use std::sync::Arc;

use controller::cell_world::topic::{self, WorldMessage};
use controller::cell_world::{WorldError, WorldInputs, WorldRunner, WorldStart, surround};
use controller::command_replay::{CommandReplayError, CommandReplayer};
use controller::recorded_run::{
    InitialSetupError, RecordedModelError, cell_of, initial_setup, model_of,
};
use controller::register_write::RegisterWrite;
use controller::start_configuration::cycle_config;
use messages::Localized;
use motion::{ConfigError, ControlLoop, CycleTiming};
use motion_api::{RingCapacities, ScriptEndpoint, motion_channel};
use parking_lot::Mutex;
use recorder::{
    CommandMessage, Difference, FieldDifference, ReadError, Recording, RecordingEntry, Setup,
    Topic, difference_ignoring,
};
use thiserror::Error;

/// Most missing cycles that are run; more are not worth waiting for.
const MAX_MISSING: u64 = 200_000;
/// Commands, and changes of registers, that one cycle may have taken; the rings hold fewer.
const MAX_WAITING: usize = 10_000;

/// A reason why a recording cannot be run again.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum RerunError {
    /// The recording cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The controller cannot be started as it was.
    #[error(transparent)]
    Beginning(#[from] InitialSetupError),
    /// The arm cannot be made.
    #[error(transparent)]
    Arm(#[from] RecordedModelError),
    /// The controller cannot be made.
    #[error("the controller of the recording cannot be made: {0}")]
    #[zh("无法建立记录中的控制器：{0}")]
    Config(#[from] ConfigError),
    /// The world of the cell cannot be made.
    #[error("the cell of the recording: {0}")]
    #[zh("记录中的单元：{0}")]
    World(#[from] Box<WorldError>),
    /// A recorded command cannot be given again.
    #[error(transparent)]
    Feed(#[from] CommandReplayError),
    /// The commands of a cycle do not fit into the ring.
    #[error("more commands than the ring holds were taken in cycle {cycle}")]
    #[zh("周期 {cycle} 取走的命令多于环形缓冲区的容量")]
    TooManyCommands {
        /// The cycle.
        cycle: u64,
    },
    /// More cycles are missing than can be run in a bearable time.
    #[error(
        "the recording jumps from cycle {from} to cycle {to}; at most {MAX_MISSING} missing cycles are run"
    )]
    #[zh("记录从周期 {from} 跳到周期 {to}；缺少的周期最多补运行 {MAX_MISSING} 个")]
    Gap {
        /// The cycle before.
        from: u64,
        /// The cycle after.
        to: u64,
    },
}

/// What running a recording again showed.
#[derive(Clone, Debug, PartialEq, Error, Localized)]
pub enum Comparison {
    /// Every recorded cycle came out the same.
    #[error("identical: {cycles} cycles")]
    #[zh("相同：{cycles} 个周期")]
    Identical {
        /// Number of cycles.
        cycles: u64,
    },
    /// The first cycle that did not.
    #[error("first difference at cycle {cycle}: {0} (recorded and rerun)", cycle = .0.cycle)]
    #[zh("首个差异在周期 {cycle}：{0}（记录与重新运行）", cycle = .0.cycle)]
    Different(Difference),
}

impl Comparison {
    /// The first cycle that did not come out the same.
    pub fn cycle(&self) -> Option<u64> {
        match self {
            Self::Identical { .. } => None,
            Self::Different(difference) => Some(difference.cycle),
        }
    }

    /// True when every cycle came out the same.
    pub fn is_identical(&self) -> bool {
        matches!(self, Self::Identical { .. })
    }
}

/// Runs the commands of a recording on a controller that was started the same way.
///
/// # Errors
/// [`RerunError`] when the recording does not tell enough to do so.
pub fn rerun(recording: &Recording) -> Result<Comparison, RerunError> {
    let mut controller = RerunCycle::new(initial_setup(recording)?)?;
    let mut recorded_world = topic::messages(recording)?;
    if let Some(world) = &mut controller.world {
        world.repeat(WorldInputs::read(recording)?);
    }
    let mut commands = Vec::new();
    let mut writes = Vec::new();
    let mut compared = 0;
    for entry in recording.entries(&[Topic::Cycle, Topic::Command, Topic::Io])? {
        match entry?.1 {
            RecordingEntry::Command(_) | RecordingEntry::Io(_)
                if commands.len() + writes.len() > MAX_WAITING =>
            {
                let cycle = controller.latest.saturating_add(1);
                return Err(RerunError::TooManyCommands { cycle });
            }
            RecordingEntry::Command(command) => commands.push(command),
            RecordingEntry::Io(change) => writes.extend(RegisterWrite::from_message(&change)),
            RecordingEntry::Cycle(recorded) => {
                controller.run_to(recorded.cycle, &mut commands, &mut writes)?;
                let fresh = recorder::CycleMessage::from(&controller.script.snapshot.read());
                let missing = recording.missing_fields();
                if let Some(difference) = difference_ignoring(&recorded, &fresh, missing) {
                    return Ok(Comparison::Different(difference));
                }
                if let Some(difference) = controller.world_difference(&mut recorded_world)? {
                    return Ok(Comparison::Different(difference));
                }
                compared += 1;
            }
            RecordingEntry::Script(_) | RecordingEntry::Log(_) | RecordingEntry::Variable(_) => {}
        }
    }
    Ok(Comparison::Identical { cycles: compared })
}

/// A controller without threads.
struct RerunCycle {
    cycle: ControlLoop,
    world: Option<WorldRunner>,
    /// What was new in the world and has not been compared.
    fresh: Arc<Mutex<Vec<WorldMessage>>>,
    script: ScriptEndpoint,
    /// The latest cycle that ran.
    latest: u64,
    /// Cycles that ran and are not recorded.
    missing: u64,
    feed: CommandReplayer,
}

impl RerunCycle {
    fn new(setup: &Setup) -> Result<Self, RerunError> {
        let cell = cell_of(setup).map_err(RecordedModelError::from)?;
        let config = cycle_config(setup, model_of(setup)?, cell.as_ref());
        let config = config.map_err(InitialSetupError::from)?;
        let sizes = RingCapacities {
            records: None,
            frames: 0,
            ..RingCapacities::default()
        };
        let (motion, script) = motion_channel(sizes, &config.first_state());
        let cycle = ControlLoop::new(config.clone(), motion)?;
        let start = WorldStart {
            model: &config.model,
            step_time: config.step_time,
            gravity: config.gravity,
            seed: setup.seed,
        };
        let (cycle, world) = surround(cycle, cell.as_ref(), &start)?;
        let fresh = Arc::<Mutex<Vec<WorldMessage>>>::default();
        if let Some(world) = &world {
            let kept = fresh.clone();
            let keep = move |message: &WorldMessage| {
                if !message.is_empty() {
                    kept.lock().push(message.clone());
                }
            };
            world.world().follow(Box::new(keep));
        }
        Ok(Self {
            cycle,
            world,
            fresh,
            script,
            latest: 0,
            missing: 0,
            feed: CommandReplayer::default(),
        })
    }

    /// What the world did otherwise than recorded, in the cycles since the last look.
    fn world_difference(
        &mut self,
        recorded: &mut impl Iterator<Item = Result<WorldMessage, ReadError>>,
    ) -> Result<Option<Difference>, RerunError> {
        for fresh in core::mem::take(&mut *self.fresh.lock()) {
            let expected = loop {
                match recorded.next().transpose()? {
                    // An order, or a world that came late: of the recorded run only.
                    Some(message) if message.is_empty() => {}
                    other => break other,
                }
            };
            let text = |message: Option<&WorldMessage>| match message {
                Some(WorldMessage { cycle, parts, .. }) => {
                    format!("cycle {cycle}, {} parts moved", parts.len())
                }
                None => "nothing".to_owned(),
            };
            let is_same = expected.as_ref().is_some_and(|expected| {
                let cycle = (
                    expected.cycle,
                    &expected.parts,
                    &expected.removed,
                    &expected.counts,
                );
                cycle == (fresh.cycle, &fresh.parts, &fresh.removed, &fresh.counts)
            });
            if !is_same {
                return Ok(Some(Difference {
                    cycle: fresh.cycle,
                    fields: vec![FieldDifference {
                        name: "world",
                        element: None,
                        first: text(expected.as_ref()),
                        second: text(Some(&fresh)),
                        magnitude: None,
                    }],
                }));
            }
        }
        Ok(None)
    }

    /// Runs up to and with cycle `last`; every command goes in before the cycle that took it, every change of a
    /// register before the cycle that saw it.
    fn run_to(
        &mut self,
        last: u64,
        commands: &mut Vec<CommandMessage>,
        writes: &mut Vec<RegisterWrite>,
    ) -> Result<(), RerunError> {
        let missing = last.saturating_sub(self.latest).saturating_sub(1);
        self.missing = self.missing.saturating_add(missing);
        if self.missing > MAX_MISSING {
            return Err(RerunError::Gap {
                from: self.latest,
                to: last,
            });
        }
        while self.latest < last {
            let next = self.latest + 1;
            let due = commands.iter().take_while(|c| c.cycle <= next).count();
            for command in commands.drain(..due) {
                self.feed.give(&self.script.commands, &command)?;
            }
            let seen = writes.iter().take_while(|w| w.cycle <= next).count();
            for write in writes.drain(..seen) {
                write.apply(&self.script.registers);
            }
            self.cycle.tick(CycleTiming::default());
            if let Some(world) = &mut self.world {
                world.run_waiting();
            }
            self.latest = next;
            while self.script.events.next_event().is_some() {}
        }
        Ok(())
    }
}
