//! The lock-free rings across the border, and their ends.
//!
//! Commands: many senders share the script side's end behind a mutex (that side may lock), the motion thread has the
//! other end to itself. Events, frames and records: the motion thread writes, one reader each.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use messages::Localized;
use rtrb::chunks::ReadChunk;
use rtrb::{Consumer, Producer, RingBuffer};
use thiserror::Error;

use crate::{
    Command, CommandId, CommandKind, Event, MotionCommand, OnlineCommand, Origin, PointList,
    RegisterImages, Registers, RobotState, SnapshotCell,
};

/// One entry of the recording, in the order in which it happened.
#[derive(Clone, Debug, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "fixed-size ring slots; nearly every record is a cycle"
)]
pub enum Record {
    /// The state at the end of a cycle.
    Cycle(RobotState),
    /// A command left the ring at the beginning of this cycle.
    Command {
        /// The cycle that took the command.
        cycle: u64,
        /// What was taken.
        command: Command,
    },
    /// What was handed over with the moveml that leaves the ring next.
    Points {
        /// The cycle that took the points.
        cycle: u64,
        /// The command that moves along the points.
        id: CommandId,
        /// The points.
        points: Arc<PointList>,
    },
    /// What the registers held when this cycle began; only where that differs from the cycle before, as far as the
    /// recording took it.
    Registers {
        /// The cycle that began.
        cycle: u64,
        /// The registers that the cycle reads.
        images: RegisterImages,
    },
}

/// One cycle as those see it who show every one of them (cyclic data on the ports): a consistent moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CycleFrame {
    /// The state at the end of the cycle.
    pub state: RobotState,
    /// The registers at the end of the cycle.
    pub registers: RegisterImages,
}

/// The points of a moveml on their way over the border.
#[derive(Clone, Debug)]
pub struct PointListHandoff {
    /// The command that the points belong to.
    pub id: CommandId,
    /// The points in their order.
    pub points: Arc<PointList>,
}

/// Lists that wait for the motion thread.
const POINT_LIST_SLOTS: usize = 8;

/// The ring is full: the motion thread has not taken a command for a while.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error, Localized)]
#[error("{capacity} commands wait already; the motion thread does not keep up")]
#[zh("已有 {capacity} 条命令等待；运动线程来不及处理")]
pub struct RingFull {
    /// How many commands the ring holds.
    pub capacity: usize,
}

/// How many entries the rings hold.
#[derive(Clone, Copy, Debug)]
pub struct RingCapacities {
    /// Commands that wait for the next cycle.
    pub commands: usize,
    /// Further places for commands that stop the arm and their like ([`CommandKind::uses_reserved_slot`]).
    pub reserved_commands: usize,
    /// Events that wait for their reader.
    pub events: usize,
    /// Records that wait for the recorder; `None`: nothing is recorded.
    pub records: Option<usize>,
    /// Frames that wait for their reader; one more is left out. 0 where nobody wants every cycle.
    pub frames: usize,
}

impl Default for RingCapacities {
    fn default() -> Self {
        Self {
            // Two cycles take them all where they set something, eight where they are motions: a stop behind them is
            // there within 35 ms.
            commands: 512,
            reserved_commands: 64,
            events: 4096,
            records: Some(4096),
            // A second of the usual cycle: whoever is held up longer has other trouble.
            frames: 256,
        }
    }
}

/// Makes the border: the motion thread's end and everybody else's.
pub fn motion_channel(
    sizes: RingCapacities,
    first: &RobotState,
) -> (MotionEndpoint, ScriptEndpoint) {
    let (command_in, command_out) = RingBuffer::new(sizes.commands + sizes.reserved_commands);
    let (lists_in, lists_out) = RingBuffer::new(POINT_LIST_SLOTS);
    let (event_in, event_out) = RingBuffer::new(sizes.events);
    let (record_in, record_out) = match sizes.records {
        Some(n) => {
            let (a, b) = RingBuffer::new(n);
            (Some(a), Some(b))
        }
        None => (None, None),
    };
    let (frame_in, frame_out) = RingBuffer::new(sizes.frames);
    let record_flow = Arc::new(RecordBackpressure::default());
    let snapshot = Arc::new(SnapshotCell::new(first));
    let registers = Arc::new(Registers::default());
    let motion = MotionEndpoint {
        commands: command_out,
        points: lists_out,
        events: event_in,
        records: record_in,
        record_flow: record_flow.clone(),
        frames: frame_in,
        snapshot: snapshot.clone(),
        registers: registers.clone(),
    };
    let commands = CommandSender {
        shared: Arc::new(Mutex::new(CommandRing {
            ring: command_in,
            lists: lists_in,
            lists_in_flight: Vec::new(),
            last: 0,
            capacity: sizes.commands,
            kept: sizes.reserved_commands,
        })),
    };
    let script = ScriptEndpoint {
        commands,
        events: EventReader { ring: event_out },
        records: record_out.map(|ring| RecordReader {
            ring,
            flow: record_flow,
        }),
        frames: FrameReader { ring: frame_out },
        snapshot,
        registers,
    };
    (motion, script)
}

/// What the motion thread holds.
pub struct MotionEndpoint {
    /// Commands to drain at the beginning of a cycle.
    pub commands: Consumer<Command>,
    /// The points of those that are a moveml, in the same order.
    pub points: Consumer<PointListHandoff>,
    /// Events for the script side. Room for them is checked before commands are drained, so none is ever dropped.
    pub events: Producer<Event>,
    /// Records for the recording, when there is one.
    pub records: Option<Producer<Record>>,
    /// How the records are getting on.
    pub record_flow: Arc<RecordBackpressure>,
    /// Every cycle for whoever shows them; what does not fit is left out.
    pub frames: Producer<CycleFrame>,
    /// Where the latest state goes.
    pub snapshot: Arc<SnapshotCell>,
    /// The registers that both sides read and write.
    pub registers: Arc<Registers>,
}

/// What the script side holds.
pub struct ScriptEndpoint {
    /// Where commands go in.
    pub commands: CommandSender,
    /// What happened.
    pub events: EventReader,
    /// The recorder's end, when there is a recording.
    pub records: Option<RecordReader>,
    /// Every cycle.
    pub frames: FrameReader,
    /// The latest state.
    pub snapshot: Arc<SnapshotCell>,
    /// The registers that both sides read and write.
    pub registers: Arc<Registers>,
}

struct CommandRing {
    ring: Producer<Command>,
    lists: Producer<PointListHandoff>,
    /// Lists that the motion thread or the recorder may still hold: they are freed here.
    lists_in_flight: Vec<Arc<PointList>>,
    last: u64,
    capacity: usize,
    kept: usize,
}

impl CommandRing {
    /// How many commands of this kind still fit.
    fn room_for(&self, kind: &CommandKind) -> usize {
        let kept = if kind.uses_reserved_slot() {
            0
        } else {
            self.kept
        };
        self.ring.slots().saturating_sub(kept)
    }

    fn push(&mut self, origin: Origin, kind: CommandKind) -> Result<CommandId, RingFull> {
        let id = CommandId(self.last + 1);
        let capacity = self.capacity;
        self.ring
            .push(Command { id, origin, kind })
            .map_err(|_| RingFull { capacity })?;
        self.last = id.0;
        Ok(id)
    }
}

/// The door for commands; clones share one ring.
#[derive(Clone)]
pub struct CommandSender {
    shared: Arc<Mutex<CommandRing>>,
}

impl CommandSender {
    /// Numbers the command and puts it into the ring.
    ///
    /// # Errors
    /// [`RingFull`] when the motion thread has not drained the ring.
    pub fn send(
        &self,
        origin: Origin,
        kind: impl Into<CommandKind>,
    ) -> Result<CommandId, RingFull> {
        self.send_with(origin, kind.into(), |_| ())
    }

    /// How many commands wait for the motion thread.
    pub fn waiting(&self) -> usize {
        let sender = self.shared.lock().unwrap_or_else(PoisonError::into_inner);
        (sender.capacity + sender.kept).saturating_sub(sender.ring.slots())
    }

    /// True when nobody takes commands any more: the other end is gone.
    pub fn is_abandoned(&self) -> bool {
        let sender = self.shared.lock().unwrap_or_else(PoisonError::into_inner);
        sender.ring.is_abandoned()
    }

    /// Puts all of `kinds` into the ring, one behind the other, or none; `before` learns each number as with
    /// [`send_with`](Self::send_with).
    ///
    /// # Errors
    /// [`RingFull`] when there is no room for all of them.
    pub fn send_all(
        &self,
        origin: Origin,
        kinds: &[CommandKind],
        mut before: impl FnMut(CommandId, CommandKind),
    ) -> Result<(), RingFull> {
        let mut sender = self.shared.lock().unwrap_or_else(PoisonError::into_inner);
        let room = kinds.iter().map(|kind| sender.room_for(kind)).min();
        if room.is_some_and(|room| room < kinds.len()) {
            let capacity = sender.capacity;
            return Err(RingFull { capacity });
        }
        for kind in kinds {
            before(CommandId(sender.last + 1), *kind);
            sender.push(origin, *kind)?;
        }
        Ok(())
    }

    /// Sends a moveml through points, which are handed over with it; `before` learns its number and itself as with
    /// [`send_with`](Self::send_with). Lists that nobody needs any more are freed here, by the thread that calls.
    ///
    /// # Errors
    /// [`RingFull`] when the motion thread has not drained the ring; nothing was handed over then.
    pub fn send_points(
        &self,
        origin: Origin,
        points: &Arc<PointList>,
        interval: f64,
        before: impl FnOnce(CommandId, CommandKind),
    ) -> Result<CommandId, RingFull> {
        let count = points.count();
        self.hand_over(
            origin,
            points,
            CommandKind::Motion(MotionCommand::MoveMl { count, interval }),
            before,
        )
    }

    /// Sends joint positions that the arm follows in time; otherwise as [`send_points`](Self::send_points).
    ///
    /// # Errors
    /// [`RingFull`] when the motion thread has not drained the ring; nothing was handed over then.
    pub fn send_trajectory(
        &self,
        origin: Origin,
        points: &Arc<PointList>,
        interval: f64,
        before: impl FnOnce(CommandId, CommandKind),
    ) -> Result<CommandId, RingFull> {
        let count = points.count();
        self.hand_over(
            origin,
            points,
            CommandKind::Online(OnlineCommand::FollowPoints { count, interval }),
            before,
        )
    }

    fn hand_over(
        &self,
        origin: Origin,
        points: &Arc<PointList>,
        kind: CommandKind,
        before: impl FnOnce(CommandId, CommandKind),
    ) -> Result<CommandId, RingFull> {
        let mut sender = self.shared.lock().unwrap_or_else(PoisonError::into_inner);
        // Whoever holds the only handle is the only one who can make another.
        sender
            .lists_in_flight
            .retain(|list| Arc::strong_count(list) > 1);
        if sender.room_for(&kind) == 0 || sender.lists.is_full() {
            let capacity = sender.capacity;
            return Err(RingFull { capacity });
        }
        let id = CommandId(sender.last + 1);
        before(id, kind);
        sender.lists_in_flight.push(Arc::clone(points));
        let points = Arc::clone(points);
        // There is room, and only this side fills the ring.
        let _ = sender.lists.push(PointListHandoff { id, points });
        sender.push(origin, kind)
    }

    /// Sends a command; `before` learns its number before the motion thread can see the command, so that a completion
    /// can never arrive unexpected.
    ///
    /// # Errors
    /// [`RingFull`] when the motion thread has not drained the ring; `before` is not called then.
    pub fn send_with(
        &self,
        origin: Origin,
        kind: CommandKind,
        before: impl FnOnce(CommandId),
    ) -> Result<CommandId, RingFull> {
        // A panic while the lock was held cannot have left the ring half written: rtrb writes whole slots.
        let mut sender = self.shared.lock().unwrap_or_else(PoisonError::into_inner);
        if sender.room_for(&kind) == 0 {
            return Err(RingFull {
                capacity: sender.capacity,
            });
        }
        before(CommandId(sender.last + 1));
        sender.push(origin, kind)
    }
}

/// The script side's end of the events.
pub struct EventReader {
    ring: Consumer<Event>,
}

impl EventReader {
    /// The next event, if one waits.
    pub fn next_event(&mut self) -> Option<Event> {
        self.ring.pop().ok()
    }
}

/// The reader's end of the frames.
pub struct FrameReader {
    ring: Consumer<CycleFrame>,
}

impl FrameReader {
    /// How many frames wait.
    pub fn waiting(&self) -> usize {
        self.ring.slots()
    }

    /// Shows the next `count` cycles, as far as they wait, in order, where they lie; and how many of them are still to
    /// come.
    pub fn visit_frames(&mut self, count: usize, mut see: impl FnMut(&CycleFrame, usize)) {
        for left in (0..count).rev() {
            let Ok(one) = self.ring.read_chunk(1) else {
                return;
            };
            let seen = PopOnDrop(Some(one));
            let frames = seen.0.iter().flat_map(|one| one.as_slices().0);
            frames.for_each(|frame| see(frame, left));
        }
    }
}

/// A cycle that is gone from the ring afterwards, even if whoever sees it panics.
struct PopOnDrop<'a>(Option<ReadChunk<'a, CycleFrame>>);

impl Drop for PopOnDrop<'_> {
    fn drop(&mut self) {
        if let Some(one) = self.0.take() {
            one.commit_all();
        }
    }
}

/// What the two ends of the records tell each other, beside the records; never waits.
#[derive(Debug, Default)]
pub struct RecordBackpressure {
    is_full: AtomicBool,
    is_given_up: AtomicBool,
}

impl RecordBackpressure {
    /// The writer has found no room (true), or room again.
    pub fn set_full(&self, is_full: bool) {
        self.is_full.store(is_full, Ordering::Relaxed);
    }

    /// True while the writer finds no room: it loses records, or waits for room.
    pub fn is_full(&self) -> bool {
        self.is_full.load(Ordering::Relaxed)
    }

    /// The reader does not come back: nobody records from now on, and nobody may wait for it.
    pub fn abandon(&self) {
        self.is_given_up.store(true, Ordering::Release);
    }

    /// True when nobody records any more.
    pub fn is_given_up(&self) -> bool {
        self.is_given_up.load(Ordering::Acquire)
    }
}

/// The recorder's end of the records.
pub struct RecordReader {
    ring: Consumer<Record>,
    flow: Arc<RecordBackpressure>,
}

impl RecordReader {
    /// The next record, if one waits.
    pub fn next_record(&mut self) -> Option<Record> {
        self.ring.pop().ok()
    }

    /// How the records are getting on, for whoever watches this end.
    pub fn flow(&self) -> &Arc<RecordBackpressure> {
        &self.flow
    }

    /// How many records wait.
    pub fn waiting(&self) -> usize {
        self.ring.slots()
    }

    /// True when the writer is gone and nothing is left.
    pub fn is_finished(&self) -> bool {
        self.ring.is_abandoned() && self.ring.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MachineCommand;
    use kinematics::JointPositions;

    fn small() -> (MotionEndpoint, ScriptEndpoint) {
        let sizes = RingCapacities {
            commands: 2,
            reserved_commands: 1,
            events: 2,
            records: None,
            frames: 0,
        };
        motion_channel(sizes, &RobotState::at_start(JointPositions::ZERO, 0.004))
    }

    #[test]
    fn commands_are_numbered_in_the_order_in_which_they_leave_the_ring() {
        let (mut motion, script) = small();
        for _ in 0..2 {
            script
                .commands
                .send(
                    Origin::default(),
                    CommandKind::Machine(MachineCommand::PowerOn),
                )
                .unwrap();
        }
        let ids: Vec<u64> = std::iter::from_fn(|| motion.commands.pop().ok())
            .map(|c| c.id.0)
            .collect();
        assert_eq!(ids, [1, 2]);
    }

    #[test]
    fn a_full_ring_refuses_and_uses_up_no_number() {
        let (mut motion, script) = small();
        let send = || {
            script.commands.send(
                Origin::default(),
                CommandKind::Machine(MachineCommand::PowerOn),
            )
        };
        send().unwrap();
        send().unwrap();
        assert_eq!(send(), Err(RingFull { capacity: 2 }));
        motion.commands.pop().unwrap();
        assert_eq!(send(), Ok(CommandId(3)));
    }

    #[test]
    fn a_stop_finds_room_where_nothing_else_does() {
        let (mut motion, script) = small();
        let send = |kind| script.commands.send(Origin::default(), kind);
        let stop = CommandKind::Machine(MachineCommand::Stop {
            only: CommandId::NONE,
        });
        send(CommandKind::Machine(MachineCommand::PowerOn)).unwrap();
        send(CommandKind::Machine(MachineCommand::PowerOn)).unwrap();
        assert!(send(CommandKind::Machine(MachineCommand::PowerOn)).is_err());
        assert_eq!(send(stop), Ok(CommandId(3)));
        assert_eq!(script.commands.waiting(), 3);
        assert!(send(stop).is_err(), "the kept places are bounded, too");
        motion.commands.pop().unwrap();
        assert!(
            send(CommandKind::Machine(MachineCommand::PowerOn)).is_err(),
            "the kept place comes first"
        );
        assert!(send(stop).is_ok());
    }

    #[test]
    fn commands_that_belong_together_go_in_together_or_not_at_all() {
        let (mut motion, script) = small();
        let two = [
            CommandKind::Machine(MachineCommand::PowerOn),
            CommandKind::Machine(MachineCommand::ReleaseBrakes),
        ];
        let send = |kinds: &[CommandKind]| {
            let mut announced = Vec::new();
            let origin = Origin::default();
            let sent = script
                .commands
                .send_all(origin, kinds, |id, _| announced.push(id.0));
            (sent.is_ok(), announced)
        };
        assert_eq!(send(&two[..1]), (true, vec![1]));
        assert_eq!(send(&two), (false, vec![]));
        assert_eq!(send(&[]), (true, vec![]));
        motion.commands.pop().unwrap();
        assert_eq!(send(&two), (true, vec![2, 3]));
        assert_eq!(motion.commands.pop().unwrap().kind, two[0]);
        assert!(!script.commands.is_abandoned());
        drop(motion);
        assert!(script.commands.is_abandoned());
    }

    #[test]
    fn lists_are_handed_over_with_their_command_and_freed_by_the_sender() {
        let (mut motion, script) = small();
        let list =
            || Arc::new(PointList::from_joint_positions(&[JointPositions::ZERO; 2]).unwrap());
        let send = |list: &Arc<PointList>| {
            let port = &script.commands;
            port.send_points(Origin::default(), list, 0.01, |_, _| ())
        };
        let first = list();
        let watched = Arc::downgrade(&first);
        assert_eq!(send(&first), Ok(CommandId(1)));
        drop(first);
        let handed = motion.points.pop().unwrap();
        assert_eq!(handed.id, motion.commands.pop().unwrap().id);
        assert_eq!(handed.points.samples().len(), 2);
        drop(handed);
        assert!(
            watched.upgrade().is_some(),
            "the motion thread frees nothing"
        );
        let second = list();
        assert_eq!(send(&second), Ok(CommandId(2)));
        assert!(watched.upgrade().is_none());
        assert_eq!(send(&second), Ok(CommandId(3)));
        assert!(send(&second).is_err(), "two commands fit");
        assert_eq!(motion.points.slots(), 2);
    }

    #[test]
    fn a_full_ring_does_not_announce_a_command() {
        let (_motion, script) = small();
        for _ in 0..2 {
            script
                .commands
                .send(
                    Origin::default(),
                    CommandKind::Machine(MachineCommand::PowerOn),
                )
                .unwrap();
        }
        let refused = script.commands.send_with(
            Origin::default(),
            CommandKind::Machine(MachineCommand::PowerOn),
            |_| panic!("announced"),
        );
        assert!(refused.is_err());
    }
}
