//! Whether what a client wants the program to be held for holds here: conditions, counts, messages.

use std::sync::atomic::Ordering;

use controller::CellWorld;
use controller::condition::ProgramPosition;
use elite_lang::debug::{EvalOutcome, PausedProgram, StatementEvent};
use elite_lang::{ThreadId, Value};
use messages::{Text, text};
use motion_api::RobotState;
use recorder::CycleMessage;

use super::breakpoints::{HitCondition, SourceBreakpoint};
use super::inspect::last_line;
use super::probe::{CONDITION_SLICES, Probe};
use super::run_channel::{RunEvent, SuspendReason};

impl Probe {
    /// Whether a breakpoint that is met here counts, and how it is answered: `None` not at all, a message, or a stop.
    pub(super) fn breakpoint_hits(
        &self,
        halt: &PausedProgram<'_>,
        at: &StatementEvent<'_>,
        breakpoint: &SourceBreakpoint,
        is_quiet: bool,
    ) -> bool {
        if let Some(condition) = &breakpoint.condition {
            let text = format!("bool((\n{condition}\n))");
            match self.evaluate(halt, at.thread, 0, &text) {
                Ok(value) if value.as_ref().and_then(Value::as_bool) == Some(true) => {}
                Ok(_) => return false,
                Err(report) => {
                    let is_new = {
                        let mut state = self.state.borrow_mut();
                        let is_new = !state.failed.contains(&breakpoint.id);
                        state.failed.push(breakpoint.id);
                        is_new
                    };
                    if is_new && !is_quiet {
                        let last = last_line(report);
                        let text = text!(
                            "the condition {condition:?} fails: {last}\n",
                            "条件 {condition:?} 出错：{last}\n"
                        );
                        self.say("stderr", text, at.site.line);
                    }
                }
            }
        }
        let hits = self.count(breakpoint.id);
        if !breakpoint
            .hits
            .is_none_or(|condition| condition.holds(hits))
        {
            return false;
        }
        match &breakpoint.message {
            None => true,
            Some(_) if is_quiet => false,
            Some(message) => {
                let text = self.format_log_message(halt, at.thread, message);
                self.say("console", Text::verbatim(text + "\n"), at.site.line);
                false
            }
        }
    }

    pub(super) fn count(&self, id: u64) -> u64 {
        let mut state = self.state.borrow_mut();
        let hits = state.hits.entry(id).or_insert(0);
        *hits += 1;
        *hits
    }

    /// The text of a message with its expressions evaluated.
    pub(super) fn format_log_message(
        &self,
        halt: &PausedProgram<'_>,
        thread: ThreadId,
        message: &str,
    ) -> String {
        let mut text = String::new();
        let mut rest = message;
        while let Some((before, after)) = rest.split_once('{') {
            text.push_str(before);
            let Some((inner, after)) = after.split_once('}') else {
                text.push('{');
                rest = after;
                continue;
            };
            let shown = match self.evaluate(halt, thread, 0, &format!("str(({inner}))")) {
                Ok(value) => {
                    let value = value.unwrap_or_default();
                    value.as_str().map(str::to_owned).unwrap_or_default()
                }
                Err(report) => format!("<{}>", last_line(report)),
            };
            text.push_str(&shown);
            rest = after;
        }
        text + rest
    }

    pub(super) fn say(&self, category: &'static str, text: Text, line: u32) {
        self.link.tell(RunEvent::Output {
            category,
            text,
            line,
        });
    }

    /// Evaluates something that neither moves the arm nor waits.
    pub(super) fn evaluate(
        &self,
        halt: &PausedProgram<'_>,
        thread: ThreadId,
        call: usize,
        text: &str,
    ) -> Result<Option<Value>, Text> {
        let evaluated = self
            .task
            .without_motion(|| halt.evaluate(thread, call, text, CONDITION_SLICES));
        match evaluated {
            EvalOutcome::Done(value) => Ok(value),
            EvalOutcome::Failed(report) => Err(report),
            EvalOutcome::TooLong => Err(text!(
                "it takes too long and was given up",
                "耗时过长，已放弃"
            )),
            EvalOutcome::Waits(_) => Err(text!(
                "it waits, which only the debug console may do",
                "它要等待，只有调试控制台可以等待"
            )),
        }
    }

    /// The breakpoints of a statement that count now.
    pub(super) fn breakpoints_at(
        &self,
        halt: &PausedProgram<'_>,
        at: &StatementEvent<'_>,
        is_quiet: bool,
    ) -> Option<SuspendReason> {
        let breakpoints = self.state.borrow().breakpoints.clone();
        let mut why: Option<SuspendReason> = None;
        let mut add = |reason: &'static str, id: u64| {
            why.get_or_insert_with(|| SuspendReason::only(reason))
                .ids
                .push(id);
        };
        let places = breakpoints.places.get(&(at.site.line, at.site.column));
        for breakpoint in places.into_iter().flatten() {
            if self.breakpoint_hits(halt, at, breakpoint, is_quiet) {
                add("breakpoint", breakpoint.id);
            }
        }
        if at.site.is_first && !breakpoints.functions.is_empty() {
            let (name, qualname) = (at.name(), at.qualname());
            for function in &breakpoints.functions {
                let is_it = function.name == name || *function.name == *qualname;
                if is_it && self.breakpoint_hits(halt, at, &function.at, is_quiet) {
                    add("function breakpoint", function.at.id);
                }
            }
        }
        why
    }

    /// The conditions of the arm that have become true with the latest cycle.
    pub(super) fn data_breakpoints(&self) -> Option<SuspendReason> {
        if self.state.borrow().watches.is_empty() {
            return None;
        }
        let robot: RobotState = self.task.state();
        let mut watches = std::mem::take(&mut self.state.borrow_mut().watches);
        let mut met: Vec<(u64, String, Option<HitCondition>)> = Vec::new();
        let mut failed = Vec::new();
        task_memory::uncounted(|| {
            let cycle = CycleMessage::from(&robot);
            let doing = ProgramPosition {
                line: self.link.line.load(Ordering::Relaxed),
                ..ProgramPosition::default()
            };
            for watch in &mut watches {
                let Some(condition) = &watch.condition else {
                    continue;
                };
                if condition.uses_world() {
                    condition.set_world(self.link.world.get().map(CellWorld::facts));
                }
                match condition.holds(&cycle, &doing) {
                    Ok(holds) => {
                        if holds && !watch.held_before {
                            met.push((watch.id, watch.text.clone(), watch.hits));
                        }
                        watch.held_before = holds;
                    }
                    Err(error) => {
                        failed.push(Text::of(&error));
                        watch.condition = None;
                    }
                }
            }
        });
        self.state.borrow_mut().watches = watches;
        for text in failed {
            self.say("stderr", text!("{text}\n", "{text}\n"), 0);
        }
        let mut why: Option<SuspendReason> = None;
        for (id, text, hits) in met {
            let count = self.count(id);
            if hits.is_none_or(|condition| condition.holds(count)) {
                let why = why.get_or_insert_with(|| SuspendReason::only("data breakpoint"));
                why.ids.push(id);
                why.description =
                    Some(text!("{text} at {:.3} s", "{text}，{:.3} s 处", robot.time));
            }
        }
        why
    }
}
