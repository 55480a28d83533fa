//! How script threads of a task wait, wake, start and end.

use std::collections::{BTreeMap, VecDeque};

use elite_lang::{Resume, ResumeOutcome, ScriptError, ScriptThread, WaitToken};
use messages::text;
use motion_api::{MachineCommand, ThreadNumber};
use tokio::sync::oneshot;

use super::report::{ReportedPosition, place_in_program};
use super::scheduler::{Task, TaskEnd};

use super::wait::Wait;
use crate::debug::CONSOLE_THREAD;
use crate::panel::Answer;

/// Safepoints for the `finally` and `with` blocks of a thread that is being stopped.
const FUEL_FOR_UNWINDING: u32 = 200_000;
/// How often a thread is told to stop before it is dropped as it is.
const STOPS_MAX: u32 = 3;

/// The script threads of a task by number, and which of them are ready.
#[derive(Default)]
pub(super) struct ThreadTable {
    pub entries: BTreeMap<ThreadNumber, ThreadEntry>,
    pub ready: VecDeque<ThreadNumber>,
    /// Secondary programs that have been started.
    secondaries: u32,
}

impl ThreadTable {
    /// The number of the next secondary program.
    pub fn next_secondary(&mut self) -> ThreadNumber {
        let number = ThreadNumber(FIRST_SECONDARY + self.secondaries);
        self.secondaries = (self.secondaries + 1) % FIRST_SECONDARY;
        number
    }
}

pub(super) struct ThreadEntry {
    pub script: ScriptThread,
    pub waiting: Option<BlockReason>,
    /// Only secondary programs have bounds.
    pub secondary: Option<SecondaryBudget>,
    /// The asker who waits for the value of the program.
    pub answer: Option<oneshot::Sender<Answer>>,
    pub reported: ReportedPosition,
}

/// What a secondary program may still use.
#[derive(Clone, Copy)]
pub(super) struct SecondaryBudget {
    pub slices: u32,
    /// Simulated time, s.
    pub until: f64,
}

/// The reason for which a thread is not ready.
#[derive(Clone, Copy)]
pub(super) enum BlockReason {
    /// A builtin waits for something in the wait table.
    Token(WaitToken),
    /// The language waits (a lock, a queue) until it is woken or this simulated time, s, has come.
    Parked { until: Option<f64> },
}

/// Secondary programs have numbers from here on, so that they never meet those of `start_thread`.
const FIRST_SECONDARY: u32 = 1 << 31;

impl Task {
    pub(super) fn suspend(&mut self, number: ThreadNumber, waiting: BlockReason) {
        if let BlockReason::Token(token) = waiting
            && self.context.wait_of(token) == Wait::Turn
        {
            self.context.end_wait(token);
            self.threads.ready.push_back(number);
            return;
        }
        let Some(entry) = self.threads.entries.get_mut(&number) else {
            return;
        };
        entry.waiting = Some(waiting);
        // A lock may be waited for, within bounds; time may not.
        if entry.secondary.is_some() && matches!(waiting, BlockReason::Parked { until: Some(_) }) {
            let text = text!(
                "RuntimeError: waiting is not allowed in a secondary program (sec)",
                "RuntimeError: 次要程序（sec）中不允许等待"
            );
            self.end_secondary(number, &text);
        }
    }

    /// Threads that the slice woke by what it did in the language (released a lock, put into a queue).
    pub(super) fn ready_woken_threads(&mut self) {
        for id in self.host.take_woken() {
            self.ready_woken(id);
        }
    }

    pub(super) fn start_requested_threads(&mut self) {
        for (number, script) in self.host.take_started() {
            self.add_thread(number, script, None);
        }
        for start in self.context.take_starts() {
            let number = start.number;
            match self.interpreter.spawn_call(start.function, start.args) {
                Ok(mut script) => {
                    script.start_at_node(start.node);
                    self.add_thread(number, script, None);
                }
                Err(error) => {
                    self.context.thread_ended(number);
                    self.report_script_error(&error);
                    self.progress.end = Some(TaskEnd::Failed);
                }
            }
        }
    }

    /// Takes over what a debugger evaluates beside the program; the end of the task, if it wants that.
    pub(super) fn follow_debugger(&mut self) -> Option<TaskEnd> {
        let attached = self.debugger.as_ref()?;
        if attached.is_over() {
            return Some(TaskEnd::Stopped);
        }
        for aside in self.context.take_adopted() {
            let waiting = match aside.token {
                Some(token) => BlockReason::Token(token),
                None => BlockReason::Parked { until: aside.until },
            };
            self.add_thread(CONSOLE_THREAD, aside.thread, None);
            self.threads
                .ready
                .retain(|number| *number != CONSOLE_THREAD);
            self.suspend(CONSOLE_THREAD, waiting);
        }
        None
    }

    pub(super) fn thread_ended(&mut self, number: ThreadNumber) {
        // A speed or a stream of the thread would move the arm on; the end of the main program stops everything by
        // itself.
        if let Some(id) = self.context.take_steering(number)
            && number != ThreadNumber(0)
        {
            self.queue_command(MachineCommand::Stop { only: id });
        }
        self.context.leave_ahead(number);
        if let Some(attached) = &self.debugger {
            attached.thread_ended(number);
        }
        self.report_last_line(number, None);
        self.positions.pending.retain(|moved| *moved != number);
        self.threads.entries.remove(&number);
        self.context.thread_ended(number);
        if number == ThreadNumber(0) {
            self.progress.end.get_or_insert(TaskEnd::Finished);
        }
    }

    /// Tells whoever waits for it what a secondary program is worth; false where nobody does.
    pub(super) fn answer(&mut self, number: ThreadNumber, answer: impl FnOnce() -> Answer) -> bool {
        let entry = self.threads.entries.get_mut(&number);
        let Some(sender) = entry.and_then(|entry| entry.answer.take()) else {
            return false;
        };
        // Whoever asked may have lost interest. The text goes to another thread.
        task_memory::uncounted(|| drop(sender.send(answer())));
        true
    }

    pub(super) fn thread_failed(&mut self, number: ThreadNumber, error: &ScriptError) {
        self.report_last_line(number, place_in_program(error).map(|frame| frame.line));
        let entry = self.threads.entries.get(&number);
        if entry.is_some_and(|entry| entry.secondary.is_some()) {
            if !self.answer(number, || Err(error.to_string())) {
                self.report_secondary_error(number, error);
            }
        } else {
            self.report_script_error(error);
            self.progress.end = Some(TaskEnd::Failed);
        }
        self.thread_ended(number);
    }

    /// Stops a thread and what it was waiting for. Its `finally` and `with` blocks run first, within the language's
    /// bound.
    pub(super) fn stop_thread(&mut self, number: ThreadNumber) {
        match self.end_wait(number) {
            Some(Wait::Command(id) | Wait::Motion(id)) => {
                self.settings.robot.forget(id);
                self.queue_command(MachineCommand::Stop { only: id });
            }
            Some(Wait::Popup(id)) => drop(self.settings.panel.close_popup(id)),
            Some(Wait::Job(job)) => self.context.outside().cancel(job),
            _ => {}
        }
        for id in self.context.take_ahead(number) {
            self.settings.robot.forget(id);
            self.queue_command(MachineCommand::Stop { only: id });
        }
        self.context.drop_effects(number);
        // What it does while it unwinds is not told.
        self.report_last_line(number, None);
        let Some(entry) = self.threads.entries.get_mut(&number) else {
            return;
        };
        self.context
            .set_current_thread(number, entry.secondary.is_some());
        self.context.thread_unwinds();
        self.host.sockets().outside().forget(entry.script.id());
        for _ in 0..STOPS_MAX {
            // Out of fuel in its clean-up: the next stop unwinds without running more of it.
            match entry.script.resume(Resume::Stop, FUEL_FOR_UNWINDING) {
                ResumeOutcome::OutOfFuel
                | ResumeOutcome::Waiting(_)
                | ResumeOutcome::Parked { .. } => {}
                ResumeOutcome::Done(_) | ResumeOutcome::Failed(_) | ResumeOutcome::Stopped => break,
            }
        }
        drop(entry.script.take_node_changes());
        self.threads.ready.retain(|n| *n != number);
        self.thread_ended(number);
    }

    pub(super) fn stop_all_threads(&mut self) {
        self.context.begin_unwinding();
        while let Some(number) = self.threads.entries.keys().next_back().copied() {
            self.stop_thread(number);
        }
        // Started while the others unwound: they never run.
        drop(self.host.take_started());
        self.host.close();
    }
}
