//! What leaves the cycle: events, records and the snapshot, and the arithmetic that no end of a command is ever lost.
//!
//! Owns the motion side of the border except the commands. The rule: before a command is taken there is room for all it
//! may cause and for the ends of all commands that are still under way (see `constants`).

use kinematics::{JointAccelerations, JointSpeeds};
use messages::text;
use motion_api::{
    Command, CommandId, CycleFrame, Event, MotionEndpoint, MotionMode, Outcome, PointListHandoff,
    Record, RecordBackpressure, RegisterImages, RobotState, SafetyMode, SnapshotCell, StopReason,
    Warning,
};
use rtrb::{Consumer, Producer};
use std::slice;
use std::sync::Arc;

use crate::config::ConfigError;
use crate::constants::{EVENT_RESERVE, EVENT_RING_MIN, EVENTS_PER_COMMAND};
use crate::io::IoSystem;

/// The ways in: commands, and the points of some.
pub(crate) type CommandInput = (Consumer<Command>, Consumer<PointListHandoff>);

/// The ways out.
pub(crate) struct Outbox {
    events: Producer<Event>,
    records: Option<Producer<Record>>,
    record_flow: Arc<RecordBackpressure>,
    frames: Producer<CycleFrame>,
    /// The latest one.
    frame: CycleFrame,
    snapshot: Arc<SnapshotCell>,
    /// Events of this cycle, kept back until the snapshot is published: who hears that a motion has ended must find the
    /// arm at its end. Allocated once; never grows.
    pending: Vec<Event>,
    records_lost: u64,
    /// The registers as the recording knows them.
    recorded_registers: RegisterImages,
    /// The cycle that is running.
    pub(crate) cycle: u64,
}

impl Outbox {
    /// Takes the border apart: what comes in, and everything else.
    pub(crate) fn new(end: MotionEndpoint) -> Result<(CommandInput, Self), ConfigError> {
        let given = end.events.buffer().capacity();
        if given < EVENT_RING_MIN {
            return Err(ConfigError::RingTooSmall {
                ring: text!("event", "事件"),
                given,
                needed: EVENT_RING_MIN,
            });
        }
        let outbox = Self {
            events: end.events,
            records: end.records,
            record_flow: end.record_flow,
            frames: end.frames,
            frame: CycleFrame {
                state: end.snapshot.read(),
                registers: RegisterImages::default(),
            },
            snapshot: end.snapshot,
            pending: Vec::with_capacity(given),
            records_lost: 0,
            recorded_registers: RegisterImages::default(),
            cycle: 0,
        };
        Ok(((end.commands, end.points), outbox))
    }

    /// True when one more command may be taken while `under_way` others have not ended yet.
    pub(crate) fn has_room(&self, under_way: usize) -> bool {
        self.events.slots() >= self.pending.len() + EVENTS_PER_COMMAND + under_way + EVENT_RESERVE
    }

    /// How a command ended.
    pub(crate) fn report_end(&mut self, id: CommandId, outcome: Outcome) {
        let cycle = self.cycle;
        self.event(Event::Ended { id, outcome, cycle });
    }

    /// The sender of a motion may send the next.
    pub(crate) fn report_ready_for_next(&mut self, id: CommandId) {
        let cycle = self.cycle;
        self.event(Event::ReadyForNext { id, cycle });
    }

    /// The motion behind this one is due.
    pub(crate) fn due(&mut self, id: CommandId) {
        let cycle = self.cycle;
        self.event(Event::Due { id, cycle });
    }

    /// Something to read about a command.
    pub(crate) fn report_warning(&mut self, id: CommandId, warning: Warning) {
        let cycle = self.cycle;
        self.event(Event::Warned { id, warning, cycle });
    }

    /// The arm entered a protective stop.
    pub(crate) fn report_stop(&mut self, reason: StopReason) {
        let cycle = self.cycle;
        self.event(Event::Stopped { reason, cycle });
    }

    fn event(&mut self, event: Event) {
        // `has_room` kept a place in the ring, and the buffer is as large as the ring.
        if self.pending.len() < self.pending.capacity() {
            self.pending.push(event);
        }
    }

    /// A command was taken from the ring.
    pub(crate) fn record_command(&mut self, command: &Command) {
        let cycle = self.cycle;
        self.record(|| Record::Command {
            cycle,
            command: *command,
        });
    }

    /// The points of the command that is taken next.
    pub(crate) fn record_points(&mut self, handed: &PointListHandoff) {
        let (cycle, id) = (self.cycle, handed.id);
        self.record(|| {
            let points = Arc::clone(&handed.points);
            Record::Points { cycle, id, points }
        });
    }

    /// What the registers hold at the beginning of this cycle, for the recording.
    pub(crate) fn record_registers(&mut self, images: &RegisterImages) {
        if self.records.is_none() || *images == self.recorded_registers {
            return;
        }
        let cycle = self.cycle;
        let images = *images;
        if self.record(|| Record::Registers { cycle, images }) {
            self.recorded_registers = images;
        }
    }

    /// After a fault of ours: the arm is held where it was, the ports see it once more.
    pub(crate) fn publish_fault(&mut self) {
        let last = self.snapshot.read();
        let state = RobotState {
            target_q: last.actual_q,
            target_qd: JointSpeeds::ZERO,
            target_qdd: JointAccelerations::ZERO,
            actual_qd: JointSpeeds::ZERO,
            target_tcp_speed: [0.0; 6],
            actual_tcp_speed: [0.0; 6],
            motion_mode: MotionMode::ProtectiveStop,
            safety_mode: SafetyMode::Fault,
            command_id: CommandId::NONE,
            speed_scaling: 0.0,
            ..last
        };
        self.snapshot.publish(&state);
        let registers = RegisterImages::default();
        // A full ring is one that nobody empties.
        let _ = self.frames.push(CycleFrame { state, registers });
    }

    /// The state before the first cycle: to the snapshot alone, no cycle has run.
    pub(crate) fn publish_first(&mut self, state: &RobotState) {
        self.snapshot.publish(state);
    }

    /// The end of the cycle: the state to the snapshot and to the recording, the events, then the frame.
    pub(crate) fn publish(&mut self, state: &RobotState, io: &mut IoSystem) {
        self.snapshot.publish(state);
        self.record(|| Record::Cycle(*state));
        let room = self.events.slots();
        for event in self.pending.drain(..room.min(self.pending.len())) {
            // There is room, and only this side fills the ring.
            let _ = self.events.push(event);
        }
        // Last: whoever finds the frame finds the events of its cycle, too.
        if !self.frames.is_full() {
            self.frame.state = *state;
            io.copy_registers_into(&mut self.frame.registers);
            // Only this side fills the ring. Copied from where it lies: it is large.
            let _ = self.frames.push_entire_slice(slice::from_ref(&self.frame));
        }
    }

    /// True when the recording took it; one that nobody wants is not even made.
    fn record(&mut self, record: impl FnOnce() -> Record) -> bool {
        let Some(records) = &mut self.records else {
            return false;
        };
        // Whoever recorded is gone, which has been told: what nobody wants is not lost.
        if records.is_abandoned() || self.record_flow.is_given_up() {
            return false;
        }
        let is_taken = records.push(record()).is_ok();
        self.record_flow.set_full(!is_taken);
        self.records_lost += u64::from(!is_taken);
        is_taken
    }

    /// Records that found no room so far.
    pub(crate) fn records_lost(&self) -> u64 {
        self.records_lost
    }

    /// Whether the record ring has places for so many; true when nobody takes records (no recording, or its reader is
    /// gone or given up).
    pub(crate) fn has_record_room(&self, needed: usize) -> bool {
        let Some(ring) = &self.records else {
            return true;
        };
        if ring.is_abandoned() || self.record_flow.is_given_up() {
            return true;
        }
        let has_room = ring.slots() >= needed;
        self.record_flow.set_full(!has_room);
        has_room
    }

    /// Size of the record ring, if there is one.
    pub(crate) fn record_capacity(&self) -> Option<usize> {
        self.records.as_ref().map(|ring| ring.buffer().capacity())
    }
}
