//! How the program of a controller that serves is held: its task goes on and hears orders, the arm halts on its path as
//! for any pause, and the thread that is held is asked again each cycle whether it goes on.

use std::sync::atomic::Ordering;

use elite_lang::ThreadId;
use elite_lang::debug::{DebugAction, PausedProgram};
use motion_api::ThreadNumber;

use super::probe::Probe;
use super::run_channel::{RunCommand, RunEvent, SuspendReason};

/// Threads with numbers from here on are secondary programs, which are short and never held.
const FIRST_SECONDARY: u32 = 1 << 31;

impl Probe {
    /// The program is held from now on.
    pub(super) fn begin_suspension(&self, thread: Option<ThreadId>) -> DebugAction {
        self.holding.set(Some(thread));
        match thread {
            Some(_) => DebugAction::Yield,
            None => DebugAction::Continue,
        }
    }

    /// A thread is asked again, or another one comes while the program is held. None: nothing is held.
    pub(super) fn poll_suspended_thread(
        &self,
        halt: &PausedProgram<'_>,
        number: ThreadNumber,
        thread: ThreadId,
    ) -> Option<DebugAction> {
        if !self.link.is_attached {
            return None;
        }
        if number.0 >= FIRST_SECONDARY {
            return Some(DebugAction::Continue);
        }
        let held = self.holding.get()?;
        if held != Some(thread) {
            return Some(DebugAction::Yield);
        }
        Some(match self.poll_resume(halt, held) {
            true => DebugAction::Continue,
            false => DebugAction::Yield,
        })
    }

    /// Between two turns of the task: what holds the program while all its threads wait.
    pub(super) fn poll_between_turns(&self, halt: &PausedProgram<'_>) {
        if !self.link.is_attached || self.state.borrow().threads.is_empty() {
            return;
        }
        let has_left = self.is_abandoned() || !self.link.is_driven.load(Ordering::Acquire);
        match self.holding.get() {
            // A thread that is held finds it out itself.
            Some(Some(_)) => {}
            Some(None) => {
                let _ = self.poll_resume(halt, None);
            }
            None if has_left => {}
            None => {
                self.refresh();
                let met = self.data_breakpoints();
                let pause = self.link.pause.load(Ordering::Acquire);
                let why = met.or_else(|| pause.then(|| SuspendReason::only("pause")));
                let state = self.task.state();
                self.state.borrow_mut().way.passes(&state);
                if let Some(why) = why {
                    self.is_within.set(true);
                    self.suspend_program(halt, None, why);
                }
            }
        }
    }

    /// Takes what the clients say to a held program; true when it goes on.
    fn poll_resume(&self, halt: &PausedProgram<'_>, thread: Option<ThreadId>) -> bool {
        if self.is_abandoned() || !self.link.is_driven.load(Ordering::Acquire) {
            self.holding.set(None);
            self.table.borrow_mut().clear();
            // What was ordered before belongs to nobody.
            while self
                .orders
                .as_ref()
                .is_some_and(|orders| orders.try_recv().is_ok())
            {}
            return true;
        }
        self.refresh();
        while let Some(order) = self
            .orders
            .as_ref()
            .and_then(|orders| orders.try_recv().ok())
        {
            match order {
                RunCommand::Ask {
                    request,
                    command,
                    arguments,
                    language,
                } => {
                    if let Some(result) =
                        self.answer(halt, thread, &request, &command, &arguments, language)
                    {
                        self.link.tell(RunEvent::Answer { request, result });
                    }
                }
                RunCommand::Go(go) => {
                    self.resume(halt, go);
                    self.holding.set(None);
                    return true;
                }
                // Programs that others have started are stopped at the server's ports.
                RunCommand::Stop => {}
            }
        }
        false
    }
}
