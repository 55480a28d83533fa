//! The debugger on the thread of the program: hears of every statement, exception and cycle, decides whether the
//! program is held there, and serves the session while it is.
//!
//! Owns what the decisions go by, and the time for which the program is held. `hears` decides, `judge` looks at
//! conditions; what a held program is asked is answered in `inspect`.

use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::Receiver;

use controller::condition::Condition;
use elite_lang::debug::{DebugAction, EvalHandle, EvalOutcome, PausedProgram};
use elite_lang::{ThreadId, Value};
use elite_runtime::debug::{CONSOLE_THREAD, DebuggedTask, DebuggerHost, TaskDebugger};
use elite_syntax::TaskNode;

use super::breakpoints::{Breakpoints, HitCondition};
use super::inspect::ReferenceTable;
use super::robot_scope::MotionProgress;
use super::run_channel::{
    Purpose, RequestId, ResumeMode, RunChannel, RunCommand, RunEvent, SuspendReason,
};
use super::run_position::{Intervention, Position, SeekTarget};
use messages::{Text, text};

/// Slices of work that a condition or a message may take.
pub(super) const CONDITION_SLICES: u32 = 50;

/// Makes a probe on the thread of the task.
pub(crate) struct ProbeFactory(pub(crate) Arc<RunChannel>);

impl DebuggerHost for ProbeFactory {
    fn attach(&self, task: DebuggedTask) -> Option<Rc<dyn TaskDebugger>> {
        let is_meant = self
            .0
            .program
            .is_none_or(|program| program == task.program());
        is_meant.then(|| Rc::new(Probe::new(self.0.clone(), task)) as Rc<dyn TaskDebugger>)
    }
}

/// How the program goes on.
pub(super) enum StepState {
    Free,
    StepIn(u32),
    Next(u32, u32),
    Out(u32, u32),
    Node(u32, Option<TaskNode>),
    Seek(SeekTarget, SuspendReason),
    Scan {
        before: u64,
        found: Option<(Position, SuspendReason)>,
    },
}

/// An evaluation that waits while the program beside it is held.
pub(super) struct PendingEvaluation {
    pending: EvalHandle,
    /// Who asked; None where it is done again.
    request: Option<RequestId>,
    /// The thread that is held in a statement; None between two cycles.
    holder: Option<ThreadId>,
}

/// A condition of the arm that is looked at every cycle.
pub(super) struct DataWatch {
    pub(super) id: u64,
    pub(super) hits: Option<HitCondition>,
    /// None after it has failed once.
    pub(super) condition: Option<Condition>,
    pub(super) text: String,
    pub(super) held_before: bool,
}

/// What the decisions go by.
pub(super) struct ProbeState {
    pub(super) mode: StepState,
    pub(super) breakpoints: Arc<Breakpoints>,
    pub(super) changes: u64,
    pub(super) watches: Vec<DataWatch>,
    pub(super) hits: HashMap<u64, u64>,
    pub(super) failed: Vec<u64>,
    pub(super) threads: BTreeMap<u32, ThreadId>,
    pub(super) moment: u64,
    /// The moment of the latest exception, and what is said of it.
    pub(super) raised: Option<(u64, SuspendReason)>,
    pub(super) stop_on_entry: bool,
    pub(super) console: Option<PendingEvaluation>,
    /// The two latest places at which a breakpoint held.
    pub(super) met: [Option<(Position, SuspendReason)>; 2],
    /// Breakpoints were changed since the run began.
    pub(super) has_changed: bool,
    /// Number of interventions that have been done again.
    pub(super) redone: usize,
    pub(super) way: MotionProgress,
}

/// The debugger of one run.
pub(crate) struct Probe {
    pub(super) link: Arc<RunChannel>,
    pub(super) task: DebuggedTask,
    pub(super) orders: Option<Receiver<RunCommand>>,
    pub(super) state: RefCell<ProbeState>,
    /// What the client was shown of the held program.
    pub(super) table: RefCell<ReferenceTable>,
    /// The thread that is held; 0 if none is.
    pub(super) held: Cell<u32>,
    /// The thread is held within a statement, not before one.
    pub(super) is_within: Cell<bool>,
    /// The program is held although its task goes on: before a statement of this thread, or within what all wait for.
    pub(super) holding: Cell<Option<Option<ThreadId>>>,
}

impl Probe {
    pub(crate) fn new(link: Arc<RunChannel>, task: DebuggedTask) -> Self {
        let (mode, stop_on_entry) = match &link.purpose {
            Purpose::Run { stop_on_entry } => (StepState::Free, *stop_on_entry),
            Purpose::Seek(target, why) => (StepState::Seek(*target, why.clone()), false),
            Purpose::Scan { before } => {
                let (before, found) = (*before, None);
                (StepState::Scan { before, found }, false)
            }
        };
        let is_muted = !matches!(mode, StepState::Free);
        link.is_muted.store(is_muted, Ordering::Release);
        let orders = link.orders.lock().take();
        let state = ProbeState {
            mode,
            breakpoints: Arc::default(),
            changes: u64::MAX,
            watches: Vec::new(),
            hits: HashMap::new(),
            failed: Vec::new(),
            threads: BTreeMap::new(),
            moment: 0,
            raised: None,
            stop_on_entry,
            console: None,
            met: [None, None],
            has_changed: false,
            redone: 0,
            way: MotionProgress::default(),
        };
        Self {
            link,
            task,
            orders,
            state: RefCell::new(state),
            table: RefCell::default(),
            held: Cell::new(0),
            is_within: Cell::new(false),
            holding: Cell::new(None),
        }
    }

    /// Position of the run.
    pub(super) fn position(&self, halt: &PausedProgram<'_>) -> Position {
        Position {
            moment: self.state.borrow().moment,
            tick: halt.statement_count(),
            cycle: self.task.cycle(),
        }
    }

    /// The threads that have executed something and are still there.
    pub(super) fn threads(&self) -> Vec<(u32, ThreadId)> {
        let state = self.state.borrow();
        state.threads.iter().map(|(n, id)| (*n, *id)).collect()
    }

    /// The language's number of a thread.
    pub(super) fn thread(&self, number: u32) -> Option<ThreadId> {
        self.state.borrow().threads.get(&number).copied()
    }

    /// What is said of the latest exception.
    pub(super) fn exception(&self) -> Option<SuspendReason> {
        let state = self.state.borrow();
        state.raised.as_ref().map(|(_, why)| why.clone())
    }

    /// Progress of the motion under way: where it began.
    pub(super) fn way(&self) -> MotionProgress {
        self.state.borrow().way
    }

    pub(super) fn is_stopping(&self) -> bool {
        self.link.is_stopping.load(Ordering::Acquire)
    }

    pub(super) fn is_abandoned(&self) -> bool {
        self.link.is_over.load(Ordering::Acquire)
    }

    /// Takes over what the client has changed.
    pub(super) fn refresh(&self) {
        let changes = self.link.changes.load(Ordering::Acquire);
        let mut state = self.state.borrow_mut();
        if state.changes == changes {
            return;
        }
        state.has_changed = changes > 0;
        state.changes = changes;
        state.breakpoints = self.link.breakpoints();
        let wanted = state.breakpoints.data.clone();
        let mut watches = Vec::new();
        for data in &wanted {
            let known = state
                .watches
                .iter()
                .position(|watch| watch.id == data.id && watch.text == data.condition);
            watches.push(match known {
                Some(index) => state.watches.swap_remove(index),
                None => DataWatch {
                    id: data.id,
                    hits: data.hits,
                    // Looked at when it was set; here it is made for this thread.
                    condition: task_memory::uncounted(|| {
                        Condition::new("the data breakpoint", &data.condition).ok()
                    }),
                    text: data.condition.clone(),
                    held_before: false,
                },
            });
        }
        let old = std::mem::replace(&mut state.watches, watches);
        task_memory::uncounted(|| drop(old));
    }

    /// A moment passes: counts it, does again what was done here, and says what the caller has to do instead of
    /// deciding.
    pub(super) fn advance_moment(
        &self,
        halt: &PausedProgram<'_>,
        thread: Option<ThreadId>,
    ) -> Option<DebugAction> {
        if self.is_stopping() && !self.link.is_attached {
            return Some(DebugAction::Stop);
        }
        if self.is_abandoned() {
            return Some(match self.link.is_attached {
                true => DebugAction::Continue,
                false => DebugAction::End,
            });
        }
        if let Some(onward) = self.follow_console(halt, thread) {
            return Some(onward);
        }
        self.state.borrow_mut().moment += 1;
        self.refresh();
        self.reapply_interventions(halt, thread)
    }

    /// While an evaluation waits, the program beside it is held. None: there is none.
    pub(super) fn follow_console(
        &self,
        halt: &PausedProgram<'_>,
        thread: Option<ThreadId>,
    ) -> Option<DebugAction> {
        let (ended, is_holder) = {
            let state = self.state.borrow();
            let console = state.console.as_ref()?;
            if state.threads.get(&CONSOLE_THREAD.0) == thread.as_ref() && thread.is_some() {
                return Some(DebugAction::Continue);
            }
            (console.pending.take(), console.holder == thread)
        };
        let Some(ended) = ended else {
            return Some(DebugAction::Yield);
        };
        let console = self.state.borrow_mut().console.take()?;
        if !is_holder {
            // The holder answers when its turn comes.
            self.state.borrow_mut().console = Some(PendingEvaluation {
                pending: EvalHandle::ready(ended),
                ..console
            });
            return Some(DebugAction::Yield);
        }
        match console.request {
            Some(request) => {
                let result = self.shown(halt, ended);
                self.link.tell(RunEvent::Answer { request, result });
                Some(self.serve_while_suspended(halt, thread))
            }
            None => Some(self.reapply_interventions(halt, thread).unwrap_or_else(|| {
                // The moment was counted before; the decision is still to be made.
                self.decide_again(halt, thread)
            })),
        }
    }

    /// After interventions that took time: a run that seeks this very moment is held now.
    pub(super) fn decide_again(
        &self,
        halt: &PausedProgram<'_>,
        thread: Option<ThreadId>,
    ) -> DebugAction {
        match self.seek_reached(halt, false) {
            Some(why) => self.suspend_program(halt, thread, why),
            None => DebugAction::Continue,
        }
    }

    /// Does again what the client did at this moment.
    pub(super) fn reapply_interventions(
        &self,
        halt: &PausedProgram<'_>,
        thread: Option<ThreadId>,
    ) -> Option<DebugAction> {
        loop {
            let next = {
                let mut state = self.state.borrow_mut();
                let next = self.link.interventions.get(state.redone)?;
                if next.moment != state.moment {
                    return None;
                }
                state.redone += 1;
                next.clone()
            };
            if let Err(console) = self.intervene(halt, thread, &next, None) {
                self.state.borrow_mut().console = Some(console);
                return Some(DebugAction::Yield);
            }
        }
    }

    /// Executes a text in a held program. An evaluation that waits is handed over to the task.
    pub(super) fn intervene(
        &self,
        halt: &PausedProgram<'_>,
        holder: Option<ThreadId>,
        what: &Intervention,
        request: Option<RequestId>,
    ) -> Result<Result<Option<Value>, Text>, PendingEvaluation> {
        let thread = self.thread(what.thread).unwrap_or(ThreadId(0));
        let evaluate = || halt.evaluate(thread, what.call, &what.text, 10 * CONDITION_SLICES);
        let evaluated = match what.may_move {
            true => evaluate(),
            false => self.task.without_motion(evaluate),
        };
        Ok(match evaluated {
            EvalOutcome::Done(value) => Ok(value),
            EvalOutcome::Failed(report) => Err(report),
            EvalOutcome::TooLong => Err(text!(
                "it takes too long and was given up",
                "耗时过长，已放弃"
            )),
            EvalOutcome::Waits(_) if !what.may_move => Err(text!(
                "it waits, which only the debug console may do",
                "它要等待，只有调试控制台可以等待"
            )),
            EvalOutcome::Waits(aside) => {
                let pending = aside.outcome();
                let mut state = self.state.borrow_mut();
                state.threads.insert(CONSOLE_THREAD.0, aside.thread.id());
                drop(state);
                self.task.adopt(aside);
                return Err(PendingEvaluation {
                    pending,
                    request,
                    holder,
                });
            }
        })
    }

    /// Executes a text for the client; None: it waits, the answer comes later.
    pub(super) fn execute(
        &self,
        halt: &PausedProgram<'_>,
        holder: Option<ThreadId>,
        what: &Intervention,
        request: &RequestId,
    ) -> Option<Result<Option<Value>, Text>> {
        self.task.mark_modified();
        match self.intervene(halt, holder, what, Some(request.clone())) {
            Ok(result) => {
                self.link.tell(RunEvent::Changed(what.clone()));
                Some(result)
            }
            Err(console) => {
                self.link.tell(RunEvent::Changed(what.clone()));
                self.state.borrow_mut().console = Some(console);
                None
            }
        }
    }

    /// Whether a run that seeks a place has come to it. `is_cycle`: between two cycles.
    pub(super) fn seek_reached(
        &self,
        halt: &PausedProgram<'_>,
        is_cycle: bool,
    ) -> Option<SuspendReason> {
        let mut state = self.state.borrow_mut();
        let (moment, cycle) = (state.moment, self.task.cycle());
        let StepState::Seek(target, why) = &state.mode else {
            return None;
        };
        let is_there = match *target {
            SeekTarget::Tick(tick) => !is_cycle && halt.statement_count() == tick,
            SeekTarget::Moment(wanted) => wanted == moment,
            SeekTarget::Cycle(wanted) => is_cycle && cycle >= wanted,
            SeekTarget::End => false,
        };
        let why = is_there.then(|| why.clone())?;
        state.mode = StepState::Free;
        Some(why)
    }

    /// Holds the program and serves the session until it goes on.
    pub(super) fn suspend_program(
        &self,
        halt: &PausedProgram<'_>,
        thread: Option<ThreadId>,
        why: SuspendReason,
    ) -> DebugAction {
        if !self.link.is_driven.load(Ordering::Acquire) {
            // Nobody could let it go on.
            return DebugAction::Continue;
        }
        self.link.is_muted.store(false, Ordering::Release);
        self.link.pause.store(false, Ordering::Release);
        let number = {
            let mut state = self.state.borrow_mut();
            state.mode = StepState::Free;
            state.stop_on_entry = false;
            let mut threads = state.threads.iter();
            let number = match thread {
                Some(thread) => threads.find(|(_, id)| **id == thread),
                None => threads.next(),
            };
            number.map_or(0, |(number, _)| *number)
        };
        self.held.set(number);
        self.table.borrow_mut().clear();
        let position = self.position(halt);
        let last = self.last_hit(position);
        let threads = self.threads().into_iter().map(|(n, _)| n).collect();
        self.link.tell(RunEvent::Stopped {
            thread: number,
            threads,
            why,
            position,
            last,
        });
        match self.link.is_attached {
            true => self.begin_suspension(thread),
            false => self.serve_while_suspended(halt, thread),
        }
    }

    /// A breakpoint holds here.
    pub(super) fn record_hit(&self, halt: &PausedProgram<'_>, why: Option<&SuspendReason>) {
        if let Some(why) = why {
            let position = self.position(halt);
            let mut state = self.state.borrow_mut();
            state.met[0] = state.met[1].take();
            state.met[1] = Some((position, why.clone()));
        }
    }

    /// Where a breakpoint held last before this place; None: that is not known.
    pub(super) fn last_hit(&self, before: Position) -> Option<Option<(Position, SuspendReason)>> {
        let state = self.state.borrow();
        if state.has_changed || self.link.changes.load(Ordering::Acquire) > 0 {
            return None;
        }
        let mut met = state.met.iter().rev().flatten();
        Some(met.find(|(at, _)| at.moment < before.moment).cloned())
    }

    pub(super) fn serve_while_suspended(
        &self,
        halt: &PausedProgram<'_>,
        thread: Option<ThreadId>,
    ) -> DebugAction {
        loop {
            let order = match &self.orders {
                Some(orders) if !self.is_abandoned() => orders.recv().ok(),
                _ => None,
            };
            match order {
                None => {
                    self.link.is_over.store(true, Ordering::Release);
                    return DebugAction::End;
                }
                Some(RunCommand::Ask {
                    request,
                    command,
                    arguments,
                    language,
                }) => {
                    let result =
                        self.answer(halt, thread, &request, &command, &arguments, language);
                    if let Some(result) = result {
                        self.link.tell(RunEvent::Answer { request, result });
                    }
                    if self.state.borrow().console.is_some() {
                        return DebugAction::Yield;
                    }
                }
                Some(RunCommand::Go(go)) => {
                    self.resume(halt, go);
                    return DebugAction::Continue;
                }
                Some(RunCommand::Stop) => return DebugAction::Stop,
            }
        }
    }

    pub(super) fn resume(&self, halt: &PausedProgram<'_>, go: ResumeMode) {
        self.table.borrow_mut().clear();
        let depth = |number: u32| {
            let calls = self.thread(number).map(|thread| halt.calls(thread));
            calls.and_then(|calls| calls.first().map(|call| call.depth))
        };
        let mode = match go {
            ResumeMode::Free => StepState::Free,
            ResumeMode::StepIn(thread) => StepState::StepIn(thread),
            ResumeMode::Next(thread) => StepState::Next(thread, depth(thread).unwrap_or(0)),
            ResumeMode::Out(thread) => StepState::Out(thread, depth(thread).unwrap_or(0)),
            ResumeMode::Node(thread) => StepState::Node(thread, halt.node()),
            ResumeMode::ToCycle(cycle) => {
                StepState::Seek(SeekTarget::Cycle(cycle), SuspendReason::only("goto"))
            }
        };
        self.state.borrow_mut().mode = mode;
    }

    /// Whether a step has come to its end.
    pub(super) fn step_is_complete(
        &self,
        halt: &PausedProgram<'_>,
        number: u32,
        depth: u32,
    ) -> bool {
        match &self.state.borrow().mode {
            StepState::StepIn(thread) => *thread == number,
            StepState::Next(thread, most) => *thread == number && depth <= *most,
            StepState::Out(thread, below) => *thread == number && depth < *below,
            StepState::Node(thread, before) => *thread == number && halt.node() != *before,
            _ => false,
        }
    }

    /// Only counts breakpoints, so that their hit conditions hold after a run was repeated up to here.
    pub(super) fn is_seeking(&self) -> bool {
        matches!(self.state.borrow().mode, StepState::Seek(..))
    }

    /// A scan has met something, or come to its end.
    pub(super) fn scan_step(
        &self,
        halt: &PausedProgram<'_>,
        met: impl FnOnce() -> Option<SuspendReason>,
    ) -> Option<DebugAction> {
        let before = match &self.state.borrow().mode {
            StepState::Scan { before, .. } => *before,
            _ => return None,
        };
        let position = self.position(halt);
        if position.moment >= before {
            let found = match &mut self.state.borrow_mut().mode {
                StepState::Scan { found, .. } => found.take(),
                _ => None,
            };
            self.link.tell(RunEvent::Scanned(found));
            self.link.is_over.store(true, Ordering::Release);
            return Some(DebugAction::End);
        }
        let why = met();
        if let (Some(why), StepState::Scan { found, .. }) = (why, &mut self.state.borrow_mut().mode)
        {
            *found = Some((position, why));
        }
        Some(DebugAction::Continue)
    }
}
