//! What the probe hears of the program, and whether it is held there.

use std::sync::atomic::Ordering;

use elite_lang::debug::{DebugAction, DebugHook, PausedProgram, StatementEvent};
use elite_lang::{ThreadId, Value};
use elite_runtime::TaskEnd;
use elite_runtime::debug::{CONSOLE_THREAD, SuspendState, TaskDebugger};
use messages::{Text, text};
use motion_api::ThreadNumber;

use super::probe::{Probe, StepState};
use super::run_channel::{Purpose, RunEvent, SuspendReason};
use super::run_position::SeekTarget;

impl DebugHook for Probe {
    fn on_statement(&self, halt: &PausedProgram<'_>, at: &StatementEvent<'_>) -> DebugAction {
        let number = self.task.thread();
        self.note_thread(number, at.thread);
        if let Some(onward) = self.poll_suspended_thread(halt, number, at.thread) {
            return onward;
        }
        self.is_within.set(false);
        if let Some(onward) = self.advance_moment(halt, Some(at.thread)) {
            return onward;
        }
        if !self.link.is_muted.load(Ordering::Relaxed) || !self.state.borrow().watches.is_empty() {
            self.link.line.store(at.site.line, Ordering::Relaxed);
            self.link.column.store(at.site.column, Ordering::Relaxed);
        }
        if let Some(onward) = self.scan_step(halt, || self.breakpoints_at(halt, at, true)) {
            return onward;
        }
        let is_seeking = self.is_seeking();
        let why = self.breakpoints_at(halt, at, is_seeking);
        self.record_hit(halt, why.as_ref());
        if let Some(why) = self.seek_reached(halt, false) {
            return self.suspend_program(halt, Some(at.thread), why);
        }
        if is_seeking {
            return DebugAction::Continue;
        }
        let entry = self.state.borrow().stop_on_entry;
        let why = why.or_else(|| {
            if entry {
                return Some(SuspendReason::only("entry"));
            }
            if self.link.pause.load(Ordering::Acquire) {
                return Some(SuspendReason::only("pause"));
            }
            self.step_is_complete(halt, number.0, at.depth)
                .then(|| SuspendReason::only("step"))
        });
        match why {
            Some(why) => self.suspend_program(halt, Some(at.thread), why),
            None => DebugAction::Continue,
        }
    }

    fn on_exception(
        &self,
        halt: &PausedProgram<'_>,
        at: &StatementEvent<'_>,
        exception: &Value,
    ) -> DebugAction {
        if let Some(onward) = self.poll_suspended_thread(halt, self.task.thread(), at.thread) {
            return onward;
        }
        self.is_within.set(true);
        if let Some(onward) = self.advance_moment(halt, Some(at.thread)) {
            return onward;
        }
        let text = self
            .task
            .without_motion(|| halt.whole_text(exception, 2000));
        let why = SuspendReason {
            reason: "exception",
            description: Some(Text::verbatim(exception.type_name().to_string())),
            text: Some(exception.text_of(text)),
            ids: Vec::new(),
        };
        let moment = self.state.borrow().moment;
        self.state.borrow_mut().raised = Some((moment, why.clone()));
        let caught = self.state.borrow().breakpoints.caught;
        if let Some(onward) = self.scan_step(halt, || caught.then(|| why.clone())) {
            return onward;
        }
        self.record_hit(halt, caught.then_some(&why));
        if let Some(why) = self.seek_reached(halt, false) {
            return self.suspend_program(halt, Some(at.thread), why);
        }
        match caught && !self.is_seeking() {
            true => self.suspend_program(halt, Some(at.thread), why),
            false => DebugAction::Continue,
        }
    }
}

impl TaskDebugger for Probe {
    fn between_turns(&self, halt: &PausedProgram<'_>) {
        self.poll_between_turns(halt);
    }

    fn suspend_state(&self) -> SuspendState {
        match self.holding.get() {
            None => SuspendState::Nothing,
            Some(None) => SuspendState::Program,
            Some(Some(_)) => SuspendState::At(ThreadNumber(self.held.get())),
        }
    }

    fn before_cycle(&self, halt: &PausedProgram<'_>) {
        if self.link.is_attached || self.state.borrow().threads.is_empty() {
            return;
        }
        self.is_within.set(true);
        let state = self.task.state();
        self.state.borrow_mut().way.passes(&state);
        let onward = self.advance_moment(halt, None).or_else(|| {
            let met = self.data_breakpoints();
            if let Some(onward) = self.scan_step(halt, || met.clone()) {
                return Some(onward);
            }
            self.record_hit(halt, met.as_ref());
            if let Some(why) = self.seek_reached(halt, true) {
                return Some(self.suspend_program(halt, None, why));
            }
            let pause = self.link.pause.load(Ordering::Acquire);
            let why = met.or_else(|| pause.then(|| SuspendReason::only("pause")));
            let why = why.filter(|_| !self.is_seeking())?;
            Some(self.suspend_program(halt, None, why))
        });
        if onward == Some(DebugAction::End) {
            self.link.is_over.store(true, Ordering::Release);
        }
    }

    fn before_end(&self, halt: &PausedProgram<'_>, end: &TaskEnd) {
        if self.is_abandoned() || self.is_stopping() || self.link.is_attached {
            return;
        }
        self.state.borrow_mut().moment += 1;
        self.refresh();
        let (is_scanning, is_seeking) = match &self.state.borrow().mode {
            StepState::Scan { .. } => (true, false),
            StepState::Seek(target, _) => (false, *target != SeekTarget::End),
            _ => (false, false),
        };
        if is_scanning {
            self.state.borrow_mut().moment = u64::MAX;
            self.scan_step(halt, || None);
            return;
        }
        let uncaught = self.state.borrow().breakpoints.uncaught;
        let raised = self.exception_moment();
        let lost = text!(
            "the run was not repeated the same way: it ended before it came there",
            "运行没有以同样方式重复：在到达该处之前就已结束"
        );
        match (end, raised) {
            _ if is_seeking => {
                let lost = match &self.state.borrow().mode {
                    StepState::Seek(SeekTarget::Cycle(_), _) => {
                        text!("the program ends before that cycle", "程序在该周期之前结束")
                    }
                    _ => lost,
                };
                let why = SuspendReason {
                    description: Some(lost),
                    ..SuspendReason::only("pause")
                };
                self.suspend_program(halt, None, why);
            }
            (TaskEnd::Failed, Some((moment, why))) if uncaught && !self.was_shown(moment) => {
                self.link.tell(RunEvent::Raised { moment, why });
            }
            (TaskEnd::ProtectiveStop(reason), _) => {
                let why = SuspendReason {
                    reason: "exception",
                    description: Some(text!("protective stop", "保护性停止")),
                    text: Some(Text::of(reason)),
                    ids: Vec::new(),
                };
                self.suspend_program(halt, None, why);
            }
            _ if self.link.stop_at_end => {
                let why = SuspendReason {
                    description: Some(text!("the end of the program", "程序的结尾")),
                    ..SuspendReason::only("pause")
                };
                self.suspend_program(halt, None, why);
            }
            _ => {}
        }
    }

    fn thread_ended(&self, number: ThreadNumber) {
        let was_there = self.state.borrow_mut().threads.remove(&number.0);
        if number != CONSOLE_THREAD
            && was_there.is_some()
            && !self.link.is_muted.load(Ordering::Acquire)
        {
            let (number, is_there) = (number.0, false);
            self.link.tell(RunEvent::Thread { number, is_there });
        }
    }

    fn is_over(&self) -> bool {
        (self.is_abandoned() || self.is_stopping()) && !self.link.is_attached
    }
}

impl Probe {
    fn note_thread(&self, number: ThreadNumber, id: ThreadId) {
        let is_new = self.state.borrow_mut().threads.insert(number.0, id) != Some(id);
        if is_new && number != CONSOLE_THREAD && !self.link.is_muted.load(Ordering::Acquire) {
            let (number, is_there) = (number.0, true);
            self.link.tell(RunEvent::Thread { number, is_there });
        }
    }

    /// The run was repeated up to this exception to show it.
    fn was_shown(&self, moment: u64) -> bool {
        matches!(&self.link.purpose, Purpose::Seek(SeekTarget::Moment(shown), _) if *shown == moment)
    }

    fn exception_moment(&self) -> Option<(u64, SuspendReason)> {
        self.state.borrow().raised.clone()
    }
}
