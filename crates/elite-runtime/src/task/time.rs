//! How a task waits: which waits are over, what makes time pass, and the end of everything that still moves.
//!
//! Under the virtual clock the task itself makes cycles pass, as fast as it can; while a thread waits for the outside
//! world, or the task is held, one each step of wall time. Under the real clock it waits for what comes first.

use std::time::Duration;

use motion_api::{
    CommandId, CommandKind, MachineCommand, MotionMode, Origin, RobotMode, RobotState, ThreadNumber,
};
use tokio::time::{Instant, sleep_until};

use super::controls::Control;
use super::handover::HandoverStop;
use super::scheduler::{Task, TaskEnd};
use super::threads::BlockReason;
use super::wait::Wait;
use crate::test_task::TestTaskConfig;

/// Longest time to wait for the arm to stand after the end of a program, in simulated seconds.
const SETTLE_TIME_MAX: f64 = 5.0;

/// A virtual clock that the recording holds up for so long, wall time, is not waited for: nothing moves meanwhile, and
/// what is to come to rest does when time goes on.
const RECORDER_STALL_MAX: Duration = Duration::from_millis(25);

/// Below this joint speed (rad/s) the arm counts as standing.
const STANDSTILL_SPEED: f64 = 1e-3;

/// A virtual clock that fell behind wall time by more than this does not catch up.
const LAG_MAX: Duration = Duration::from_millis(100);

/// The pace of a virtual clock that keeps to wall time while it idles.
#[derive(Default)]
pub(super) struct WallPacing {
    /// The moment at which the next cycle is due.
    pub next_tick: Option<Instant>,
    /// An order that came while the task waited.
    pub early_control: Option<Control>,
}

impl Task {
    /// Readies every thread whose wait is over, in the order of their numbers.
    pub(super) fn end_waits(&mut self) {
        self.end_waits_that(|_| true);
    }

    /// Readies threads whose waits people and other programs end, for which no cycle has to pass. True when there was
    /// one.
    pub(super) fn end_outside_waits(&mut self) -> bool {
        self.end_waits_that(Wait::is_external)
    }

    fn end_waits_that(&mut self, concerned: impl Fn(Wait) -> bool) -> bool {
        let over: Vec<ThreadNumber> = self
            .threads
            .entries
            .iter()
            .filter(|(_, entry)| entry.waiting.is_some_and(|w| self.is_over(w, &concerned)))
            .map(|(number, _)| *number)
            .collect();
        for number in &over {
            self.context.note_wait_over(*number);
            self.end_wait(*number);
            self.threads.ready.push_back(*number);
        }
        !over.is_empty()
    }

    fn is_over(&self, waiting: BlockReason, concerned: impl Fn(Wait) -> bool) -> bool {
        let robot = self.context.robot();
        let wait = match waiting {
            BlockReason::Token(token) => self.context.wait_of(token),
            BlockReason::Parked { until } => {
                let over = until.is_some_and(|time| robot.moment().time >= time);
                return over && concerned(Wait::Never);
            }
        };
        concerned(wait)
            && match wait {
                Wait::Command(id) => robot.has_ended(id),
                Wait::Motion(id) => robot.may_be_followed(id),
                Wait::Due(id) => robot.is_next_due(id),
                Wait::Cycle(wanted) => robot.moment().cycle >= wanted,
                Wait::CycleOrProgramEnd(wanted) => {
                    let attendant = self.settings.extras.attendant.as_ref();
                    robot.moment().cycle >= wanted
                        || attendant.is_none_or(TestTaskConfig::program_is_inactive)
                }
                Wait::Thread(other) => !self.threads.entries.contains_key(&other),
                Wait::Turn => true,
                Wait::Job(job) => self.context.outside().is_done(job),
                Wait::Popup(id) => !self.settings.panel.is_popup_open(id),
                Wait::Statement => self.context.interpreter().has_next(),
                Wait::Recorded(turn) => self.context.turn() >= turn,
                Wait::Never => false,
            }
    }

    /// Forgets what a thread waits for; gives back the wait's entry in the table.
    pub(super) fn end_wait(&mut self, number: ThreadNumber) -> Option<Wait> {
        let waiting = self.threads.entries.get_mut(&number)?.waiting.take()?;
        let BlockReason::Token(token) = waiting else {
            return None;
        };
        let wait = self.context.wait_of(token);
        self.context.end_wait(token);
        Some(wait)
    }

    fn waits_for_the_outside(&self) -> bool {
        // Rates and watchdogs of Modbus signals count the same seconds as the program, unless a test plays the device.
        self.host.sockets().outside().is_awaited()
            || self.context.outside().is_open()
            || self.has_waits_outside()
            || self.settings.fieldbus.modbus.has_real_devices()
    }

    /// One virtual cycle, or whatever comes first: a cycle, a control, news from outside.
    pub(super) async fn let_time_pass(&mut self) {
        if self.context.repeat().is_some() {
            // The recording says how long: see `turns`.
        } else if !self.settings.robot.timeline().is_virtual() || self.waits_for_the_outside() {
            self.wait_at_wall_pace().await;
        } else {
            self.pacing.next_tick = None;
            self.tick();
        }
    }

    /// While the task is held: the arm decelerates as time passes, then time keeps wall pace, so that what ports ask of
    /// the robot is still done.
    pub(super) async fn wait_while_paused(&mut self) {
        if self.context.repeat().is_some() {
            return;
        }
        let stands = self.settings.robot.state().target_qd.max_abs() == 0.0;
        if stands {
            self.wait_at_wall_pace().await;
        } else {
            self.let_time_pass().await;
        }
    }

    /// The first cycle in which a thread may go on; the next one where that is not known.
    fn first_due(&self) -> u64 {
        let next = self.settings.robot.moment().cycle + 1;
        let due = self
            .threads
            .entries
            .values()
            .map(|entry| match entry.waiting {
                Some(BlockReason::Token(token)) => match self.context.wait_of(token) {
                    Wait::Cycle(cycle) | Wait::CycleOrProgramEnd(cycle) => cycle,
                    _ => next,
                },
                _ => next,
            });
        due.min().unwrap_or(next)
    }

    pub(super) fn tick(&self) {
        let robot = &self.settings.robot;
        if self.settings.extras.attendant.is_some() {
            robot.timeline().idle_until(self.first_due());
        }
        if let Some(attached) = &self.debugger {
            self.interpreter.halted(|halt| attached.before_cycle(halt));
            if attached.is_over() {
                return;
            }
        }
        // The arm's memory is not the task's, even while the task's thread moves it.
        task_memory::uncounted(|| {
            if robot.timeline().advance() {
                robot.pump();
            }
        });
    }

    async fn wait_at_wall_pace(&mut self) {
        let robot = self.settings.robot.clone();
        let news = self.settings.panel.news().clone();
        let (host, context) = (self.host.clone(), self.context.clone());
        let is_virtual = robot.timeline().is_virtual();
        if is_virtual {
            // Whatever the last cycle has brought is taken up before the next one passes, however late it is: otherwise
            // simulated time would depend on how busy the machine is.
            tokio::task::yield_now().await;
        }
        let (now, step) = (
            Instant::now(),
            Duration::from_secs_f64(robot.moment().step_time),
        );
        let due = match self.pacing.next_tick {
            Some(due) if now < due + LAG_MAX => due,
            _ => now + step,
        };
        self.pacing.next_tick = Some(due);
        tokio::select! {
            biased;
            control = self.controls.next() => match control {
                Some(control) => self.pacing.early_control = Some(control),
                // The supervisor is gone: nobody could stop this task any more.
                None => self.progress.end = Some(TaskEnd::Stopped),
            },
            () = news.notified() => {}
            () = host.sockets().outside().woken() => {}
            () = context.outside().news() => {}
            () = sleep_until(due), if is_virtual => {
                self.pacing.next_tick = Some(due + step);
                self.tick();
            }
            () = robot.progress(), if !is_virtual => {}
        }
    }

    /// Ends what still moves, within a bound, until the arm stands. A motion that has returned in its blend zone goes
    /// on to its waypoint if the program ran to its end, however long that takes, unless somebody stops it; it is
    /// stopped like any other if it was cut off. A task whose place another takes does not wait: the arm is handed
    /// over. One that was told to stop before is let come to rest: whoever stops a program and starts the next one may
    /// count on that.
    pub(super) async fn settle(&mut self, end: &TaskEnd) -> Option<HandoverStop> {
        let is_stopped = *end == TaskEnd::Stopped;
        // A run that is only given up has nobody who sees the arm come to rest.
        if self
            .debugger
            .as_ref()
            .is_some_and(|attached| attached.is_over())
        {
            return None;
        }
        if let Some(repeat) = self.context.repeat() {
            // How the arm comes to rest is in the recording; the next program may wait for it.
            let is_succeeded =
                self.progress.successor.is_some() && !is_stopped && !repeat.is_finished();
            return match is_succeeded {
                true => self.hand_over().await,
                false => None,
            };
        }
        let robot = self.settings.robot.clone();
        // Whoever stops a program wants the arm to rest; otherwise a client's trajectory is none of its business.
        let is_arm_of_client = !is_stopped && robot.follows_trajectory();
        if self.progress.successor.is_some() && !is_stopped && !is_arm_of_client {
            return self.hand_over().await;
        }
        let started = robot.state();
        if self.settings.extras.attendant.is_some() || is_arm_of_client {
            // The arm is not its own; what it sent last is still taken.
            if is_arm_of_client && self.suspension.is_active {
                self.queue_command(MachineCommand::Resume);
            }
            self.flush_commands();
            if !robot.timeline().has_ended() {
                self.pass_a_cycle().await;
            }
            return None;
        }
        let is_cut_off = *end != TaskEnd::Finished && started.target_qd.max_abs() > 0.0;
        // The last motions of a program that ran to its end may still be on their way.
        let is_ahead =
            *end == TaskEnd::Finished && self.context.is_queued_motion(started.command_id);
        if started.command_id != CommandId::NONE && !is_ahead
            || started.motion_mode == MotionMode::Conveyor
            || started.force_mode
            || is_cut_off
        {
            self.queue_command(MachineCommand::Stop {
                only: CommandId::NONE,
            });
        }
        if self.suspension.is_active {
            self.queue_command(MachineCommand::Resume);
        }
        let mut deadline = started.time + SETTLE_TIME_MAX;
        let mut goes_on = *end == TaskEnd::Finished;
        // One cycle at least, so that commands the program sent last are taken and recorded.
        let first = started.cycle + 1;
        let mut held_up = None;
        loop {
            let state = robot.state();
            let stands = is_at_rest(&state);
            let powered = state.robot_mode == RobotMode::Running;
            let is_on_its_way = goes_on && is_planned(state.motion_mode);
            let is_over = state.time > deadline && !is_on_its_way;
            let rests = state.cycle > first && (!powered || stands);
            self.context
                .show_effects_if(|motion| robot.has_ended(motion));
            if rests || is_over || robot.timeline().has_ended() {
                return None;
            }
            self.flush_commands();
            // No program is left to pause or to join; the arm can still be stopped, and taken over.
            while let Some(control) = self.controls.try_next() {
                match control {
                    Control::Stop if goes_on => {
                        goes_on = false;
                        deadline = state.time + SETTLE_TIME_MAX;
                        self.queue_command(MachineCommand::Stop {
                            only: CommandId::NONE,
                        });
                    }
                    Control::Replace(successor) if !is_stopped => {
                        if is_on_its_way && !stands {
                            self.report_replacement(&successor);
                        }
                        return self.hand_over().await;
                    }
                    _ => {}
                }
            }
            if self.pass_a_cycle().await {
                held_up = None;
            } else if !goes_on
                && held_up.get_or_insert_with(Instant::now).elapsed() > RECORDER_STALL_MAX
            {
                return None;
            }
        }
    }

    /// Leaves an arm that is being stopped to the next program, with the stop that ends when it stands.
    async fn hand_over(&mut self) -> Option<HandoverStop> {
        let robot = self.settings.robot.clone();
        let origin = Origin {
            program: self.context.program(),
            ..Origin::default()
        };
        let stop = CommandKind::Machine(MachineCommand::Stop {
            only: CommandId::NONE,
        });
        // Held or not, from here on it brakes. Places in the ring are kept for both, so there is room in a cycle or
        // two.
        if self.suspension.is_active {
            self.queue_command(MachineCommand::Resume);
        }
        loop {
            self.flush_commands();
            if self.pending_commands.is_empty()
                && let Ok(id) = robot.request(origin, stop)
            {
                return Some(HandoverStop::new(robot, id));
            }
            if robot.timeline().has_ended() {
                return None;
            }
            self.pass_a_cycle().await;
        }
    }

    /// One cycle: of the virtual clock, or the next one of the real clock. False when the recording holds the virtual
    /// one up.
    async fn pass_a_cycle(&self) -> bool {
        let robot = &self.settings.robot;
        let advanced = task_memory::uncounted(|| {
            let advanced = robot.timeline().advance();
            if advanced {
                robot.pump();
            }
            advanced
        });
        if advanced || robot.timeline().is_virtual() {
            return advanced;
        }
        robot.progress().await;
        true
    }
}

/// The arm is at rest, as far as a person could see.
fn is_at_rest(state: &RobotState) -> bool {
    state.target_qd.max_abs() == 0.0 && state.actual_qd.max_abs() < STANDSTILL_SPEED
}

/// A motion along a planned path.
fn is_planned(mode: MotionMode) -> bool {
    matches!(
        mode,
        MotionMode::MoveJ | MotionMode::MoveL | MotionMode::MoveC | MotionMode::MoveP
    )
}
