//! The script side's view of the robot: one handle to send commands, learn how they ended and look at the state.
//!
//! Owns the table of commands (`command_table`). Knows neither planner nor physics (those are behind the ring) and no
//! script value. Shared by the task's thread, the ports and the pump.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use kinematics::{RobotModel, SafetyBounds};
use messages::{Language, Localized, Text, text};
use motion_api::{
    Command, CommandId, CommandKind, CommandSender, CycleTime, Event, EventReader, FrameReader,
    IoImage, MotionCommand, Origin, Outcome, PointList, ProgramId, Registers, RingFull, RobotState,
    ScriptEndpoint, SnapshotCell, StopReason, Timeline,
};
use tokio::sync::Notify;

use crate::command_table::{CommandTable, EndedCommand};
use crate::external::Rerun;
use crate::message::{Message, Observer, Severity};
use crate::predicted_state::PredictedState;

/// A robot to give commands to. Cheap to share behind an `Arc`.
pub struct Robot {
    model: Arc<RobotModel>,
    safety_bounds: SafetyBounds,
    /// The names of the safety planes, by their numbers from 0.
    plane_names: Vec<String>,
    commands: CommandSender,
    snapshot: Arc<SnapshotCell>,
    registers: Arc<Registers>,
    timeline: Arc<dyn Timeline>,
    awaited: Mutex<CommandTable>,
    inbox: Mutex<MotionReceivers>,
    progress: Notify,
    observer: Arc<dyn Observer>,
    /// The latest cycle whose events have all been taken; only under the real clock.
    published_state: Mutex<Option<Box<RobotState>>>,
    /// The number of the cycle in `published_state`, which threads compare before they take the lock.
    published_cycle: AtomicU64,
    /// Where a recorded run is repeated: programs give no commands then, they are compared with what was recorded.
    repeat: OnceLock<Arc<Rerun>>,
}

/// Stops that are remembered with their cycle.
const STOPS_REMEMBERED: usize = 8;

/// What comes from the motion thread.
struct MotionReceivers {
    events: EventReader,
    frames: FrameReader,
}

impl Robot {
    /// Joins the script side's end of the border with the clock that runs the other side.
    pub fn new(
        model: Arc<RobotModel>,
        end: ScriptChannels,
        timeline: Arc<dyn Timeline>,
        observer: Arc<dyn Observer>,
    ) -> Self {
        Self {
            model,
            safety_bounds: SafetyBounds::default(),
            plane_names: Vec::new(),
            commands: end.commands,
            snapshot: end.snapshot,
            registers: end.registers,
            timeline,
            awaited: Mutex::default(),
            inbox: Mutex::new(MotionReceivers {
                events: end.events,
                frames: end.frames,
            }),
            progress: Notify::new(),
            observer,
            published_state: Mutex::default(),
            published_cycle: AtomicU64::new(0),
            repeat: OnceLock::new(),
        }
    }

    /// From now on programs repeat a recorded run: their commands are not given, the recording's are.
    pub fn set_rerun(&self, repeat: Arc<Rerun>) {
        // Said once, before the first program.
        let _ = self.repeat.set(repeat);
    }

    /// The number of the latest cycle whose events have all been taken, under the real clock.
    pub(crate) fn told_cycle(&self) -> u64 {
        self.published_cycle.load(Ordering::Acquire)
    }

    /// The state of that cycle.
    pub(crate) fn published_state(&self) -> RobotState {
        let told = self
            .published_state
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        told.as_ref()
            .map_or_else(|| self.snapshot.read(), |state| **state)
    }

    /// The arm's model.
    pub fn model(&self) -> &RobotModel {
        &self.model
    }

    /// Sets the safety planes, tool and joint bounds; the control cycle must have been given the same ones.
    pub fn with_safety_bounds(self, safety_bounds: SafetyBounds) -> Self {
        Self {
            safety_bounds,
            ..self
        }
    }

    /// Sets the names of the safety planes, by their numbers from 0.
    pub fn with_plane_names(self, plane_names: Vec<String>) -> Self {
        Self {
            plane_names,
            ..self
        }
    }

    /// A sentence about the arm in which safety planes have their names: the motion thread knows numbers alone.
    pub fn sentence(&self, about: &(impl Localized + ?Sized)) -> Text {
        // The highest number first: that of another plane may begin it.
        let names = self.plane_names.iter().enumerate().rev();
        let in_language = |language: Language| {
            names.clone().fold(
                about.in_language(language).to_string(),
                |text, (index, name)| {
                    let number = index + 1;
                    let named = text!(
                        "safety plane {name:?} of the cell",
                        "单元的安全平面 {name:?}"
                    );
                    let numbered = text!(
                        "safety plane {number} of the cell",
                        "单元的安全平面 {number}"
                    );
                    let [numbered, named] =
                        [&numbered, &named].map(|text| text.in_language(language));
                    text.replace(numbered, named)
                },
            )
        };
        Text::new(
            in_language(Language::English),
            in_language(Language::Chinese),
        )
    }

    /// The safety planes, and the tool they hold back.
    pub fn safety_bounds(&self) -> &SafetyBounds {
        &self.safety_bounds
    }

    /// The state after the latest cycle.
    pub fn state(&self) -> RobotState {
        self.snapshot.read()
    }

    /// When that state was made, for whoever needs no more of it.
    pub fn moment(&self) -> CycleTime {
        self.snapshot.cycle_time()
    }

    /// The clock.
    pub fn timeline(&self) -> &dyn Timeline {
        &*self.timeline
    }

    /// Sends a command nobody waits for.
    ///
    /// # Errors
    /// [`RingFull`] when the motion thread does not keep up.
    pub fn send(
        &self,
        origin: Origin,
        kind: impl Into<CommandKind>,
    ) -> Result<CommandId, RingFull> {
        self.enter(origin, kind.into(), false)
    }

    /// Sends a command whose outcome will be asked for with [`take_outcome`](Self::take_outcome).
    ///
    /// # Errors
    /// [`RingFull`] when the motion thread does not keep up.
    pub fn request(
        &self,
        origin: Origin,
        kind: impl Into<CommandKind>,
    ) -> Result<CommandId, RingFull> {
        self.enter(origin, kind.into(), true)
    }

    /// Sends a moveml through points, whose outcome will be asked for with [`take_outcome`](Self::take_outcome).
    ///
    /// # Errors
    /// [`RingFull`] when the motion thread does not keep up.
    pub fn request_points(
        &self,
        origin: Origin,
        points: &Arc<PointList>,
        interval: f64,
    ) -> Result<CommandId, RingFull> {
        if let Some(repeat) = self.repeat.get() {
            let count = points.count();
            return Ok(self.match_recorded_command(
                repeat,
                origin,
                CommandKind::Motion(MotionCommand::MoveMl { count, interval }),
                true,
            ));
        }
        // Lists are freed by whoever hands over the next.
        task_memory::uncounted(|| {
            self.commands
                .send_points(origin, points, interval, |id, kind| {
                    let command = Command { id, origin, kind };
                    self.awaited().register(command, true);
                })
        })
    }

    /// Sends joint positions that the arm follows in time; the outcome will be asked for with
    /// [`take_outcome`](Self::take_outcome).
    ///
    /// # Errors
    /// [`RingFull`] when the motion thread does not keep up.
    pub fn request_trajectory(
        &self,
        origin: Origin,
        points: &Arc<PointList>,
        interval: f64,
    ) -> Result<CommandId, RingFull> {
        task_memory::uncounted(|| {
            self.commands
                .send_trajectory(origin, points, interval, |id, kind| {
                    let command = Command { id, origin, kind };
                    self.awaited().register(command, true);
                })
        })
    }

    /// Whether the arm follows a trajectory of a client: no program has asked for that motion.
    pub fn follows_trajectory(&self) -> bool {
        self.awaited().follows_trajectory()
    }

    /// Sends commands nobody waits for, all of them or none.
    ///
    /// # Errors
    /// [`RingFull`] when the motion thread does not keep up.
    pub fn send_all(&self, origin: Origin, kinds: &[CommandKind]) -> Result<(), RingFull> {
        self.commands.send_all(origin, kinds, |id, kind| {
            let command = Command { id, origin, kind };
            self.awaited().register(command, false);
        })
    }

    /// True when nobody takes commands any more: the control cycle has ended.
    pub fn is_abandoned(&self) -> bool {
        self.commands.is_abandoned()
    }

    fn enter(
        &self,
        origin: Origin,
        kind: CommandKind,
        keep_outcome: bool,
    ) -> Result<CommandId, RingFull> {
        if let Some(repeat) = self.repeat.get().filter(|_| origin.program != ProgramId(0)) {
            return Ok(self.match_recorded_command(repeat, origin, kind, keep_outcome));
        }
        // The table is of all threads: what one enters, another takes out.
        task_memory::uncounted(|| {
            self.commands.send_with(origin, kind, |id| {
                let command = Command { id, origin, kind };
                self.awaited().register(command, keep_outcome);
            })
        })
    }

    /// The number that a command of a repeated program has in the recording, whose own is carried out.
    fn match_recorded_command(
        &self,
        repeat: &Rerun,
        origin: Origin,
        kind: CommandKind,
        keep_outcome: bool,
    ) -> CommandId {
        task_memory::uncounted(|| {
            let id = repeat.expect(origin, &kind, self.moment().cycle);
            let command = Command { id, origin, kind };
            self.awaited().register(command, keep_outcome);
            id
        })
    }

    /// Inputs and outputs as the next read must see them: the image of the latest cycle with every change that still
    /// waits for its cycle applied, in order.
    pub fn io(&self) -> IoImage {
        let awaited = self.awaited();
        awaited.io_after(&self.state(), u64::MAX)
    }

    /// Inputs and outputs as a program must see them that knows the robot by the state of an earlier cycle.
    pub(crate) fn io_after(&self, state: &RobotState) -> IoImage {
        self.awaited().io_after(state, state.cycle)
    }

    /// The state as the next cycle will have it, as far as commands that wait set something: what a program is shown,
    /// whose settings take no time.
    pub(crate) fn foreseen(&self) -> PredictedState {
        let mut awaited = self.awaited();
        // Under the lock: what is no longer open was published before.
        awaited.foreseen(&self.state(), u64::MAX)
    }

    /// The state that follows an earlier cycle's, as far as commands that waited then set something.
    pub(crate) fn foreseen_after(&self, state: &RobotState) -> PredictedState {
        self.awaited().foreseen(state, state.cycle)
    }

    /// The general purpose registers.
    pub fn registers(&self) -> &Registers {
        &self.registers
    }

    /// How many protective stops there were so far, and the reason of the last one.
    pub fn protective_stops(&self) -> (u64, Option<StopReason>) {
        let awaited = self.awaited();
        (awaited.stops, awaited.last_stop)
    }

    /// The number of protective stops up to an earlier cycle, and the reason of the last of them.
    pub(crate) fn protective_stops_by(&self, cycle: u64) -> (u64, Option<StopReason>) {
        let awaited = self.awaited();
        let recent = &awaited.recent_stops;
        let later = recent.iter().filter(|(at, _)| *at > cycle).count();
        let last = recent.iter().rev().find(|(at, _)| *at <= cycle);
        (
            awaited.stops - later as u64,
            last.map(|(_, reason)| *reason),
        )
    }

    /// The outcome of a requested command once it has ended; a second call gives `None`.
    pub fn take_outcome(&self, id: CommandId) -> Option<Outcome> {
        let mut awaited = self.awaited();
        let outcome = awaited.open.get(&id)?.outcome?;
        awaited.drop_waiter(id);
        Some(outcome)
    }

    /// What a command is called that has not been forgotten yet.
    pub fn command_name(&self, id: CommandId) -> Option<&'static str> {
        let awaited = self.awaited();
        awaited.open.get(&id).map(|entry| entry.command.kind.name())
    }

    /// A command that has not been forgotten yet, with where it was asked for.
    pub fn command(&self, id: CommandId) -> Option<Command> {
        self.awaited().open.get(&id).map(|entry| entry.command)
    }

    /// Hands `each` the motions that were carried out to their end in this cycle and whose senders have not been told
    /// yet, in their order.
    pub fn for_motions_done_in(&self, cycle: u64, mut each: impl FnMut(&Command)) {
        for entry in self.awaited().open.values() {
            let is_done = entry.ended_in == cycle && entry.outcome == Some(Outcome::Done);
            if is_done && entry.command.kind.is_motion() {
                each(&entry.command);
            }
        }
    }

    /// True once a requested command has ended.
    pub fn has_ended(&self, id: CommandId) -> bool {
        self.has_ended_by(id, u64::MAX)
    }

    /// True when a requested command had ended by this cycle.
    pub(crate) fn has_ended_by(&self, id: CommandId, cycle: u64) -> bool {
        let awaited = self.awaited();
        match awaited.open.get(&id) {
            Some(entry) => entry.has_ended(cycle),
            None => !awaited
                .ended_since(cycle)
                .any(|ended| ended.command.id == id),
        }
    }

    /// True once a requested motion has ended, or the next one may follow it.
    pub fn accepts_next_motion(&self, id: CommandId) -> bool {
        self.accepted_next_motion_by(id, u64::MAX - 1)
    }

    /// True when a requested motion had ended by this cycle, or the next one could follow it then.
    pub(crate) fn accepted_next_motion_by(&self, id: CommandId, cycle: u64) -> bool {
        let awaited = self.awaited();
        match awaited.open.get(&id) {
            Some(entry) => entry.has_ended(cycle) || entry.queued_in <= cycle,
            None => {
                let mut since = awaited.ended_since(cycle);
                let since = since.find(|ended| ended.command.id == id);
                since.is_none_or(|ended| ended.queued_in <= cycle)
            }
        }
    }

    /// True once a requested motion has ended, or the next one is due.
    pub fn is_next_due(&self, id: CommandId) -> bool {
        self.is_next_due_by(id, u64::MAX - 1)
    }

    /// True when a requested motion had ended by this cycle, or the next one was due then.
    pub(crate) fn is_next_due_by(&self, id: CommandId, cycle: u64) -> bool {
        let awaited = self.awaited();
        let entry = awaited.open.get(&id);
        // Motions whose outcome nobody has asked for are open until then.
        entry.is_none_or(|entry| entry.has_ended(cycle) || entry.due_in <= cycle)
    }

    /// Gives up waiting for a command; its outcome is dropped when it comes.
    pub fn forget(&self, id: CommandId) {
        let mut awaited = self.awaited();
        if let Some(entry) = awaited.open.get_mut(&id) {
            entry.keep_outcome = false;
            if entry.outcome.is_some() {
                awaited.drop_waiter(id);
            }
        }
    }

    /// Waits until a cycle has passed or a command has ended since the last call.
    pub async fn progress(&self) {
        self.progress.notified().await;
    }

    /// How many commands wait for the motion thread.
    pub fn commands_waiting(&self) -> usize {
        self.commands.waiting()
    }

    /// Takes all waiting events: completions go into the table, warnings and stops to the observer, which is also shown
    /// every cycle since the last call. Called by the pump thread after each cycle of the real clock, and by whoever
    /// advances the virtual one.
    pub fn pump(&self) {
        let mut inbox = self.inbox.lock().unwrap_or_else(PoisonError::into_inner);
        let is_virtual = self.timeline.is_virtual();
        // The events of a cycle come before its frame: with the frames that are there now all their events are.
        let frames = inbox.frames.waiting();
        while let Some(event) = inbox.events.next_event() {
            self.dispatch(event, is_virtual);
        }
        // Under the lock, so that cycles are seen in order.
        inbox.frames.visit_frames(frames, |frame, left| {
            self.observer.cycle_ended(frame);
            if left == 0 && !is_virtual {
                self.publish_state(&frame.state);
            }
        });
        drop(inbox);
        self.progress.notify_one();
    }

    /// Programs may see this cycle from now on.
    fn publish_state(&self, state: &RobotState) {
        let cycle = state.cycle;
        {
            let mut told = self
                .published_state
                .lock()
                .unwrap_or_else(PoisonError::into_inner);
            match told.as_mut() {
                Some(told) => **told = *state,
                None => *told = Some(Box::new(*state)),
            }
        }
        self.published_cycle.store(cycle, Ordering::Release);
        self.awaited().forget_ended(cycle);
    }

    fn dispatch(&self, event: Event, is_virtual: bool) {
        match event {
            Event::Ended { id, outcome, cycle } => {
                let mut awaited = self.awaited();
                let Some(entry) = awaited.open.get_mut(&id) else {
                    return;
                };
                let (command, keeps) = (entry.command, entry.keep_outcome);
                entry.ended_in = cycle;
                awaited.lasting.record_end(&command.kind, &outcome);
                awaited.note_end(&command);
                let Some(entry) = awaited.open.get_mut(&id) else {
                    return;
                };
                if keeps {
                    entry.outcome = Some(outcome);
                    awaited.changes += 1;
                    return;
                }
                let queued_in = entry.queued_in;
                awaited.drop_waiter(id);
                if !is_virtual && command.origin.program != ProgramId(0) {
                    awaited.ended.push_back(EndedCommand {
                        command,
                        ended_in: cycle,
                        queued_in,
                    });
                }
                if let Outcome::Refused(refusal) = outcome {
                    drop(awaited);
                    // Nobody waits for this one, so nobody else would say that it was refused.
                    let refusal = self.sentence(&refusal);
                    let text = text!("{}: {refusal}", "{}：{refusal}", command.kind.name());
                    let warning = Message::log(Severity::Warning, command.origin, text);
                    self.observer.message(&warning);
                }
            }
            Event::ReadyForNext { id, cycle } => {
                if let Some(entry) = self.awaited().open.get_mut(&id) {
                    entry.queued_in = cycle;
                }
            }
            Event::Due { id, cycle } => {
                if let Some(entry) = self.awaited().open.get_mut(&id) {
                    entry.due_in = cycle;
                }
            }
            Event::Warned { id, warning, .. } => {
                let command = self.awaited().open.get(&id).map(|entry| entry.command);
                let (origin, name) =
                    command.map_or((Origin::default(), ""), |c| (c.origin, c.kind.name()));
                let text = text!("{name}: {warning}", "{name}：{warning}");
                self.observer
                    .message(&Message::log(Severity::Warning, origin, text));
            }
            Event::Stopped { reason, cycle } => {
                let mut awaited = self.awaited();
                awaited.stops += 1;
                awaited.recent_stops.push_back((cycle, reason));
                if awaited.recent_stops.len() > STOPS_REMEMBERED {
                    awaited.recent_stops.pop_front();
                }
                awaited.lasting.record_stop();
                awaited.last_stop = Some(reason);
                let origin = awaited.mover(cycle);
                drop(awaited);
                let message = Message::protective_stop(reason, &self.sentence(&reason), origin);
                self.observer.message(&message);
            }
        }
    }

    fn awaited(&self) -> MutexGuard<'_, CommandTable> {
        self.awaited.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The script side's end of the border, without the records (those go to the recorder).
pub struct ScriptChannels {
    /// Where commands go in.
    pub commands: CommandSender,
    /// What happened.
    pub events: EventReader,
    /// Every cycle.
    pub frames: FrameReader,
    /// The latest state.
    pub snapshot: Arc<SnapshotCell>,
    /// The general purpose registers.
    pub registers: Arc<Registers>,
}

impl From<ScriptEndpoint> for ScriptChannels {
    fn from(end: ScriptEndpoint) -> Self {
        Self {
            commands: end.commands,
            events: end.events,
            frames: end.frames,
            snapshot: end.snapshot,
            registers: end.registers,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kinematics::JointPositions;
    use kinematics::RpyPose;
    use motion_api::{CycleFrame, MotionEndpoint, RingCapacities, motion_channel};
    use motion_api::{
        MachineCommand, OnlineCommand, OverlayCommand, SensingCommand, SettingCommand,
    };
    use proptest::prelude::*;

    /// Notes which cycles it was shown.
    #[derive(Default)]
    struct Watcher(Mutex<Vec<u64>>);

    impl Observer for Watcher {
        fn cycle_ended(&self, frame: &CycleFrame) {
            self.0.lock().unwrap().push(frame.state.cycle);
        }
    }

    struct NoTime;

    impl Timeline for NoTime {
        fn is_virtual(&self) -> bool {
            false
        }
        fn advance(&self) -> bool {
            false
        }
        fn set_driven(&self, _: bool) {}
    }

    fn robot(frames: usize) -> (Robot, MotionEndpoint, Arc<Watcher>) {
        let sizes = RingCapacities {
            frames,
            ..RingCapacities::default()
        };
        let first = RobotState::at_start(JointPositions::ZERO, 0.004);
        let (motion, script) = motion_channel(sizes, &first);
        let model = Arc::new(RobotModel::built_in("cs66").unwrap());
        let watcher = Arc::new(Watcher::default());
        let robot = Robot::new(model, script.into(), Arc::new(NoTime), watcher.clone());
        (robot, motion, watcher)
    }

    #[test]
    fn safety_planes_have_their_names_in_each_language() {
        let (robot, _motion, _watcher) = robot(4);
        let names = (1..=12).map(|number| format!("p{number}"));
        let robot = robot.with_plane_names(names.collect());
        for plane in [0, 11] {
            let told = robot.sentence(&StopReason::SafetyPlane {
                plane,
                depth: 0.0012,
            });
            let number = plane + 1;
            let named = text!(
                "the tool was about to cross safety plane \"p{number}\" of the cell: it would come to rest 0.0012 m \
                 behind it",
                "工具即将越过单元的安全平面 \"p{number}\"：将停在其后 0.0012 m 处"
            );
            assert_eq!(told, named);
        }
    }

    fn end_of_cycle(motion: &mut MotionEndpoint, cycle: u64) {
        let state = RobotState {
            cycle,
            ..RobotState::at_start(JointPositions::ZERO, 0.004)
        };
        motion.snapshot.publish(&state);
        let registers = motion.registers.images();
        let _ = motion.frames.push(CycleFrame { state, registers });
    }

    #[test]
    fn a_pump_that_was_held_up_shows_every_cycle_in_order() {
        let (robot, mut motion, watcher) = robot(RingCapacities::default().frames);
        for cycle in 1..=3 {
            end_of_cycle(&mut motion, cycle);
            robot.pump();
        }
        for cycle in 4..=50 {
            end_of_cycle(&mut motion, cycle);
        }
        robot.pump();
        robot.pump();
        let all: Vec<u64> = (1..=50).collect();
        assert_eq!(*watcher.0.lock().unwrap(), all);
    }

    #[test]
    fn a_pump_that_is_held_up_for_too_long_never_stops_the_cycle() {
        let (robot, mut motion, watcher) = robot(4);
        for cycle in 1..=10 {
            end_of_cycle(&mut motion, cycle);
        }
        robot.pump();
        end_of_cycle(&mut motion, 11);
        robot.pump();
        assert_eq!(*watcher.0.lock().unwrap(), [1, 2, 3, 4, 11]);
        assert_eq!(robot.state().cycle, 11);
    }

    proptest! {
        #[test]
        fn what_is_foreseen_does_not_depend_on_what_was_asked_before(
            steps in prop::collection::vec((0..8_u8, 0..4_u8), 1..60)
        ) {
            let mut awaited = CommandTable::default();
            let mut state = RobotState::at_start(JointPositions::ZERO, 0.004);
            for (id, (what, which)) in (1..).zip(steps) {
                let number = f64::from(which);
                let kind = match what {
                    0 => CommandKind::Setting(SettingCommand::SetTcp(RpyPose::from_array([0.1 * number, 0.0, 0.1, 0.2,
                        0.0, number]))),
                    1 => CommandKind::Setting(SettingCommand::SetSpeedFraction(0.25 * number)),
                    2 => CommandKind::Overlay(OverlayCommand::EndForceMode),
                    3 => CommandKind::Online(OnlineCommand::EndFreedrive),
                    4 => CommandKind::Sensing(SensingCommand::SetCollisionDetection(which > 1)),
                    5 => CommandKind::Machine(MachineCommand::Stop { only: CommandId::NONE }),
                    6 => {
                        // Ends the one of that place.
                        if let Some(id) = awaited.open.keys().nth(which.into()).copied() {
                            awaited.drop_waiter(id);
                        }
                        continue;
                    }
                    _ => {
                        state.cycle += 1;
                        continue;
                    }
                };
                let id = CommandId(if which == 3 { 1_000 - id } else { id });
                let origin = Origin::default();
                awaited.register(Command { id, origin, kind }, true);
                let at_once = awaited.foreseen(&state, u64::MAX);
                let kept = std::mem::take(&mut awaited.foresight);
                let afresh = awaited.foreseen(&state, u64::MAX);
                awaited.foresight = kept;
                prop_assert_eq!(format!("{at_once:?}"), format!("{afresh:?}"));
            }
        }
    }
}
