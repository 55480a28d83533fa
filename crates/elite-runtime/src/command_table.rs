//! The commands that have been given: who waits for them, how they ended, and what they will have changed.
//!
//! Commands travel through a ring, so the state of the robot shows their effect a cycle or more later. A program sees
//! its own commands at once: what the open ones set is laid over the state.

use std::collections::{BTreeMap, VecDeque};
use std::ops::Bound;

use motion_api::{
    Command, CommandId, CommandKind, DigitalBank, IoChange, IoImage, MachineCommand, OnlineCommand,
    Origin, Outcome, RobotState, SettingCommand, StopReason,
};

use crate::predicted_state::{CommandedModes, PredictedState, PredictionCache, PredictionKey};

/// Commands of a program are remembered for so many cycles after their end, for programs that see the robot as it was a
/// little before; and at most so many of them.
const REMEMBERED_CYCLES: u64 = 250;
const REMEMBERED_MAX: usize = 4096;
/// Commands whose end somebody waits for, and the origin of every command that has not ended.
#[derive(Default)]
pub(crate) struct CommandTable {
    pub(crate) open: BTreeMap<CommandId, PendingCommand>,
    pub(crate) stops: u64,
    pub(crate) last_stop: Option<StopReason>,
    /// The latest ones, with their cycles.
    pub(crate) recent_stops: VecDeque<(u64, StopReason)>,
    pub(crate) lasting: CommandedModes,
    /// Where a motion was asked for that goes on after its command has ended, as the speed of `speedl` does.
    pub(crate) held_motion: Origin,
    pub(crate) foresight: PredictionCache,
    /// How often a prediction that is cached became wrong ([`PredictionKey::changes`]).
    pub(crate) changes: u64,
    /// Commands that have ended and whose outcome nobody asks for, in the order of their ends: programs may still see a
    /// cycle before. Few of them are looked at, those behind that cycle.
    pub(crate) ended: VecDeque<EndedCommand>,
}

/// A command that has ended.
pub(crate) struct EndedCommand {
    pub(crate) command: Command,
    pub(crate) ended_in: u64,
    pub(crate) queued_in: u64,
}

impl CommandTable {
    /// A command is about to enter the ring.
    pub(crate) fn register(&mut self, command: Command, keep_outcome: bool) {
        self.lasting.note(&command);
        if command.id < self.foresight.newest() {
            // A repeated program's, whose numbers are the recording's.
            self.changes += 1;
        }
        let entry = PendingCommand {
            command,
            keep_outcome,
            outcome: None,
            ended_in: u64::MAX,
            queued_in: u64::MAX,
            due_in: u64::MAX,
        };
        self.open.insert(command.id, entry);
    }

    /// Nobody will ask for the end of this command.
    pub(crate) fn drop_waiter(&mut self, id: CommandId) {
        task_memory::uncounted(|| self.open.remove(&id));
        self.changes += 1;
    }

    /// Forgets commands that ended long ago.
    pub(crate) fn forget_ended(&mut self, cycle: u64) {
        while let Some(ended) = self.ended.front()
            && (ended.ended_in.saturating_add(REMEMBERED_CYCLES) < cycle
                || self.ended.len() > REMEMBERED_MAX)
        {
            self.ended.pop_front();
        }
    }

    /// Commands that had not ended by this cycle, though they have since, in the order of their ends.
    pub(crate) fn ended_since(&self, cycle: u64) -> impl DoubleEndedIterator<Item = &EndedCommand> {
        let from = self.ended.partition_point(|ended| ended.ended_in <= cycle);
        self.ended.range(from..)
    }

    /// The commands behind `after` that had not ended by this cycle, in the order in which they were given.
    pub(crate) fn open_commands_after(
        &self,
        cycle: u64,
        after: CommandId,
    ) -> impl Iterator<Item = &Command> {
        let since = self.ended_since(cycle).map(|ended| &ended.command);
        let mut since: Vec<&Command> = since.filter(|command| command.id > after).collect();
        since.sort_by_key(|command| command.id);
        let open = self.open.range((Bound::Excluded(after), Bound::Unbounded));
        let open = open.filter(move |(_, entry)| !entry.has_ended(cycle));
        let mut open = open.map(|(_, entry)| &entry.command).peekable();
        let mut since = since.into_iter().peekable();
        std::iter::from_fn(move || match (since.peek(), open.peek()) {
            (Some(earlier), Some(later)) if earlier.id < later.id => since.next(),
            (Some(_), None) => since.next(),
            _ => open.next(),
        })
    }

    /// Where the motion was asked for that was carried out before this cycle.
    pub(crate) fn mover(&self, cycle: u64) -> Origin {
        let mut under_way = self.open_commands_after(cycle.saturating_sub(1), CommandId::NONE);
        let motion = under_way.find(|command| command.kind.starts_motion());
        motion.map_or(self.held_motion, |command| command.origin)
    }

    /// Whether a trajectory of a client has not ended.
    pub(crate) fn follows_trajectory(&self) -> bool {
        self.open.values().any(|pending| {
            let kind = &pending.command.kind;
            pending.outcome.is_none()
                && matches!(
                    kind,
                    CommandKind::Online(OnlineCommand::FollowPoints { .. })
                )
        })
    }

    /// A command has ended: what moves the arm from now on, until another command does.
    pub(crate) fn note_end(&mut self, command: &Command) {
        let kind = &command.kind;
        let is_stop = matches!(
            kind,
            CommandKind::Machine(MachineCommand::Stop { .. })
                | CommandKind::Online(OnlineCommand::StopJ { .. } | OnlineCommand::StopL { .. })
        );
        if kind.is_motion() || is_stop {
            self.held_motion = Origin::default();
        } else if kind.starts_motion() {
            self.held_motion = command.origin;
        }
    }

    /// The state with what the commands that had not ended by `cycle` set.
    pub(crate) fn foreseen(&mut self, state: &RobotState, cycle: u64) -> PredictedState {
        let mut foresight = std::mem::take(&mut self.foresight);
        let basis = PredictionKey {
            cycle: state.cycle,
            ended_by: cycle,
            changes: self.changes,
        };
        let under_way = |after| self.open_commands_after(cycle, after);
        // What is kept belongs to no task.
        let foreseen =
            task_memory::uncounted(|| foresight.of(basis, state, self.lasting, under_way));
        self.foresight = foresight;
        foreseen
    }

    /// The inputs and outputs of the state with what the commands that had not ended by `cycle` set.
    pub(crate) fn io_after(&self, state: &RobotState, cycle: u64) -> IoImage {
        let mut image = state.io();
        for command in self.open_commands_after(cycle, CommandId::NONE) {
            match command.kind {
                CommandKind::Setting(SettingCommand::SetStandardDigitalOut { index, level })
                    if index < 16 =>
                {
                    image.apply(&IoChange::digital_out(DigitalBank::Standard, index, level));
                }
                CommandKind::Setting(
                    SettingCommand::SetIo(change) | SettingCommand::SetIoAtZone { change, .. },
                ) => {
                    image.apply(&change);
                }
                _ => {}
            }
        }
        image
    }
}

/// A command that has not ended, or whose outcome nobody has asked for yet.
pub(crate) struct PendingCommand {
    pub(crate) command: Command,
    pub(crate) keep_outcome: bool,
    pub(crate) outcome: Option<Outcome>,
    /// The cycle in which the command ended.
    pub(crate) ended_in: u64,
    /// The cycle since which the next motion may follow the command, and since which that is due.
    pub(crate) queued_in: u64,
    pub(crate) due_in: u64,
}

impl PendingCommand {
    /// Whether the command had ended by this cycle.
    pub(crate) fn has_ended(&self, by: u64) -> bool {
        self.outcome.is_some() && self.ended_in <= by
    }
}
