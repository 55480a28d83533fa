//! What holds a task and lets it go on, and what the robot is told of it.
//!
//! Others hold it by orders, a debugger besides; it goes on when both have let go.

use io_bus::ProgramState;
use motion_api::{CommandKind, IoChange, MachineCommand, Origin, SettingCommand};

use super::scheduler::Task;
use crate::debug::SuspendState;
use crate::supervisor::TaskState;

/// Whether a task is suspended, and by whom.
#[derive(Default)]
pub(super) struct Suspension {
    /// No script thread runs.
    pub is_active: bool,
    /// An order suspends the task; a debugger may suspend it besides.
    pub is_ordered: bool,
}

impl Task {
    /// Lets the task go on where it was held.
    pub(super) fn go_on(&mut self) {
        if self.suspension.is_active {
            self.suspension.is_active = false;
            self.queue_command(MachineCommand::Resume);
            self.program_is(ProgramState::Running);
            let now = self.context.robot().moment().time;
            self.settings.panel.with_watchdogs(|dogs| dogs.restart(now));
            self.show(TaskState::Running);
        }
    }

    /// What a debugger holds while orders are heard.
    pub(super) fn holds(&self) -> SuspendState {
        let attached = self.debugger.as_ref();
        attached.map_or(SuspendState::Nothing, |attached| attached.suspend_state())
    }

    /// Holds the task, or lets it go on, as a debugger wants; an order to hold it counts besides.
    pub(super) fn apply_suspend_state(&mut self) {
        match self.holds() {
            SuspendState::Nothing if self.suspension.is_ordered => {}
            SuspendState::Nothing => self.go_on(),
            SuspendState::Program | SuspendState::At(_) => self.halt(),
        }
    }

    pub(super) fn pause(&mut self) {
        self.suspension.is_ordered = true;
        self.halt();
    }

    fn halt(&mut self) {
        if !self.suspension.is_active {
            self.suspension.is_active = true;
            self.queue_command(MachineCommand::Pause);
            self.program_is(ProgramState::Paused);
            self.show(TaskState::Paused);
        }
    }

    pub(super) fn show(&self, state: TaskState) {
        self.status.send_modify(|status| status.state = state);
    }

    /// Gives the robot a command. Where there is no room for it just now it is given in one of the next cycles: a stop
    /// is late at worst, never lost.
    pub(super) fn queue_command(&mut self, kind: impl Into<CommandKind>) {
        self.pending_commands.push_back(kind.into());
        self.flush_commands();
    }

    pub(super) fn flush_commands(&mut self) {
        let origin = Origin {
            program: self.context.program(),
            ..Origin::default()
        };
        while let Some(kind) = self.pending_commands.front()
            && self.settings.robot.send(origin, *kind).is_ok()
        {
            self.pending_commands.pop_front();
        }
    }

    /// For outputs that follow the run state (manual 5.20 to 5.25). A held program does not run.
    pub(super) fn program_is(&mut self, state: ProgramState) {
        if self.settings.extras.attendant.is_some() {
            return;
        }
        let runs = state == ProgramState::Running;
        self.queue_command(SettingCommand::SetIo(IoChange::ProgramRunning(runs)));
        self.settings.fieldbus.set_program(state);
    }
}
