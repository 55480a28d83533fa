//! When a task looks round, and what it finds then: a cycle, orders, threads that sockets have woken.
//!
//! Between two turns a task learns nothing new of the world, so a recording that says what was seen in which turn is
//! all that a repetition needs (`crate::external`). Turns are counted the same way whether or not anybody notes them.

use elite_lang::ThreadId;
use elite_syntax::SourceFile;
use motion_api::ThreadNumber;

use super::controls::Control;
use super::scheduler::{Task, TaskEnd};
use super::threads::BlockReason;
use crate::external::{ExternalInputKind, TaskOrder};

/// What should have happened since the turn before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TurnCause {
    /// Nothing that takes time.
    Work,
    /// A wait, usually for the next cycle.
    Wait,
}

/// Where a task is among its turns: a run is repeated by cycle and slice, never by wall time.
pub(super) struct TurnPosition {
    /// The cycle that was seen in the latest turn.
    pub cycle: u64,
    /// Turns since a cycle has passed.
    pub slices: u32,
    /// The cycle in which watchdogs and variables were checked last.
    pub checked_cycle: u64,
}

impl Default for TurnPosition {
    fn default() -> Self {
        Self {
            cycle: 0,
            slices: 0,
            checked_cycle: u64::MAX,
        }
    }
}

impl Task {
    /// Looks round. What is seen from now on is that of the latest cycle.
    pub(super) fn look(&mut self, since: TurnCause) {
        let turn = self.context.next_turn();
        let program = self.context.program();
        let expected = match since {
            TurnCause::Work => self.turn.cycle,
            TurnCause::Wait => self.turn.cycle + 1,
        };
        self.turn.slices = match since {
            TurnCause::Work => self.turn.slices.saturating_add(1),
            TurnCause::Wait => 0,
        };
        let woken = if let Some(repeat) = self.context.repeat().cloned() {
            repeat.watch(
                self.context.origin(0),
                turn,
                self.turn.slices,
                self.turn.cycle,
            );
            let cycle = repeat.observed_cycle(program, turn).unwrap_or(expected);
            while self.context.robot().moment().cycle < cycle
                && !repeat.is_finished()
                && !self.settings.robot.timeline().has_ended()
                && !self
                    .debugger
                    .as_ref()
                    .is_some_and(|attached| attached.is_over())
            {
                self.tick();
            }
            repeat
                .woken(program, turn)
                .iter()
                .map(|id| ThreadId(*id))
                .collect()
        } else {
            self.context.robot().look();
            self.host.take_woken_outside()
        };
        self.turn.cycle = self.context.robot().moment().cycle;
        if self.turn.cycle != expected {
            self.turn.slices = 0;
            self.context.note(ExternalInputKind::CycleObserved);
        }
        for thread in woken {
            self.context
                .note(ExternalInputKind::Woken { thread: thread.0 });
            self.ready_woken(thread);
        }
        if let Some(attached) = self.debugger.clone()
            && since == TurnCause::Wait
        {
            self.interpreter.halted(|halt| attached.between_turns(halt));
        }
    }

    /// Whether somebody waits for the outside world.
    pub(super) fn has_waits_outside(&self) -> bool {
        let mut waiting = self
            .threads
            .entries
            .values()
            .filter_map(|entry| entry.waiting);
        waiting.any(|waiting| match waiting {
            BlockReason::Token(token) => self.context.wait_of(token).is_external(),
            BlockReason::Parked { .. } => false,
        })
    }

    /// Carries out what was ordered up to this turn.
    pub(super) fn take_orders(&mut self) {
        while let Some(control) = self
            .pacing
            .early_control
            .take()
            .or_else(|| self.controls.try_next())
        {
            self.note_order(&control);
            self.apply_control(control);
        }
        let Some(repeat) = self.context.repeat().cloned() else {
            return;
        };
        for order in repeat.orders(self.context.program(), self.context.turn()) {
            match order {
                TaskOrder::Stop => self.apply_control(Control::Stop),
                TaskOrder::Replace(successor) => {
                    self.apply_control(Control::Replace(successor.into()))
                }
                TaskOrder::Pause => self.apply_control(Control::Pause),
                TaskOrder::Resume => self.apply_control(Control::Resume),
                TaskOrder::Secondary { name, text } => self.repeat_secondary(name, text),
            }
        }
    }

    pub(super) fn note_order(&self, control: &Control) {
        if self.context.witness().is_none() {
            return;
        }
        let order = match control {
            Control::Stop => TaskOrder::Stop,
            Control::Replace(successor) => TaskOrder::Replace(successor.to_string()),
            Control::Pause => TaskOrder::Pause,
            Control::Resume => TaskOrder::Resume,
            Control::Secondary(program, _) => TaskOrder::Secondary {
                name: program.file().name().to_owned(),
                text: program.file().text().to_owned(),
            },
        };
        self.context.note(ExternalInputKind::Order(order));
    }

    fn repeat_secondary(&mut self, name: String, text: String) {
        if self.progress.end.is_some() {
            return;
        }
        let known = &self.known;
        let compiled =
            task_memory::uncounted(|| elite_syntax::compile(SourceFile::new(name, text), known));
        // A text that compiled when it was recorded may not in another version; the run then departs from the
        // recording.
        if let Ok(program) = compiled {
            self.start_secondary(&program);
            task_memory::uncounted(|| drop(program));
        }
    }

    /// The end of a task whose recorded run is at its end, or was left.
    pub(super) fn end_of_recording(&self) -> Option<TaskEnd> {
        let repeat = self.context.repeat()?;
        repeat.is_finished().then_some(TaskEnd::Stopped)
    }

    /// A thread goes on that was parked.
    pub(super) fn ready_woken(&mut self, id: ThreadId) {
        let woken = self
            .threads
            .entries
            .iter_mut()
            .find(|(_, entry)| entry.script.id() == id);
        if let Some((number, entry)) = woken
            && matches!(entry.waiting, Some(BlockReason::Parked { .. }))
        {
            entry.waiting = None;
            let number: ThreadNumber = *number;
            self.threads.ready.push_back(number);
        }
    }
}
