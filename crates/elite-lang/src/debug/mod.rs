//! Programs that somebody watches statement by statement: where they are, what their variables hold, and a place at
//! which the embedder can hold them.
//!
//! Costs nothing where nobody watches: what stands before a statement is a node of its own ([`crate::eval::watch`]),
//! made only for programs that are spawned after [`Interpreter::debug`](crate::Interpreter::debug). Owns the calls that
//! are under way in each script thread and the count of statements. Decides nothing: whether to hold is the
//! [`DebugHook`]'s business.
//!
//! The count of statements is the same in every run of a program whose surroundings are the same, so that it names a
//! place in a run.

mod evaluate;
mod halt;
mod show;

use std::cell::{Cell, RefCell};
use std::rc::{Rc, Weak};

pub use evaluate::{EvalHandle, EvalOutcome, PendingEval};
use halt::TopFrame;
pub use halt::{PausedProgram, SetVariableError, StackFrame};
pub use show::{ChildFilter, ChildValue, ValuePreview};

use elite_syntax::{SourceFile, Span};

use crate::eval::coroutine::{StopState, SuspendRequest};
use crate::eval::{Evaluator, Frame};
use crate::host::ThreadId;
use crate::value::{Function, Instance, R, ScriptCell, Unwind, Value};

/// Calls within calls of which variables are kept; those between the outermost and the innermost ones have none.
const LEVELS_MAX: usize = 4096;

/// Hears of every statement before it is executed, on the thread that runs the interpreter. It may take its time.
pub trait DebugHook {
    /// A thread is about to execute a statement.
    fn on_statement(&self, halt: &PausedProgram<'_>, at: &StatementEvent<'_>) -> DebugAction;

    /// A statement raises an exception that has not been seen before; the thread stands in it.
    fn on_exception(
        &self,
        halt: &PausedProgram<'_>,
        at: &StatementEvent<'_>,
        exception: &Value,
    ) -> DebugAction;
}

/// What becomes of a thread that was held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DebugAction {
    /// The thread goes on.
    Continue,
    /// The thread gives way until the next moment of simulated time, and the watcher is asked again.
    Yield,
    /// Nothing of the program runs any more.
    End,
    /// Stop, as a stop from outside would: `finally` and `with` blocks run.
    Stop,
}

/// The place of a statement in its text.
#[derive(Debug)]
pub struct StatementSite {
    /// The text.
    pub file: std::sync::Arc<SourceFile>,
    /// Where in the text.
    pub span: Span,
    /// Line, from 1.
    pub line: u32,
    /// Column, from 1.
    pub column: u32,
    /// The first statement of a function, a class body or a program.
    pub is_first: bool,
}

/// What the watcher learns of a statement without asking.
pub struct StatementEvent<'r> {
    /// The statement.
    pub site: &'r Rc<StatementSite>,
    /// The thread.
    pub thread: ThreadId,
    /// Calls within calls.
    pub depth: u32,
    /// Statements so far, this one included.
    pub tick: u64,
    /// The function that the statement is in.
    function: &'r Rc<Function>,
}

impl StatementEvent<'_> {
    /// The name of the function it is in.
    pub fn name(&self) -> &str {
        &self.function.code.name
    }

    /// The name of the function it is in, with the classes and functions around that.
    pub fn qualname(&self) -> Rc<str> {
        self.function.qualname()
    }
}

/// A call under way.
struct CallRecord {
    function: Rc<Function>,
    depth: u32,
    site: Rc<StatementSite>,
    tick: u64,
    /// The count of the call's first statement, as far as that is known.
    first: u64,
    /// The statement of the same call before this one, 0 if there was none.
    before: u64,
    /// The variables when the statement began; empty where it calls nothing.
    values: Vec<Value>,
}

/// The calls of one thread, outermost first.
struct ThreadCalls {
    thread: u64,
    levels: Vec<CallRecord>,
    /// Calls within calls, as of when the thread was suspended.
    depth: u32,
}

/// The state of watching in one interpreter.
pub(crate) struct Debugger {
    watcher: Rc<dyn DebugHook>,
    traces: RefCell<Vec<ThreadCalls>>,
    statement_count: Cell<u64>,
    /// Something is evaluated for the watcher.
    is_silent: Cell<bool>,
    is_over: Cell<bool>,
    last_raised: ScriptCell<Weak<Instance>>,
}

impl Debugger {
    pub(crate) fn new(watcher: Rc<dyn DebugHook>) -> Self {
        Debugger {
            watcher,
            traces: RefCell::default(),
            statement_count: Cell::new(0),
            is_silent: Cell::new(false),
            is_over: Cell::new(false),
            last_raised: ScriptCell::default(),
        }
    }

    /// Takes apart what refers to code.
    pub(crate) fn dismantle(&self) {
        drop(self.traces.take());
    }

    /// The running thread is about to execute a statement; `keeps` says that its call may be looked at from within.
    pub(crate) fn enter_statement(
        &self,
        ev: &Evaluator<'_>,
        f: &mut Frame<'_>,
        site: &Rc<StatementSite>,
        keeps: bool,
    ) -> R<()> {
        let core = &ev.core;
        if self.is_over.get() {
            core.stopping.set(StopState::Abandoned);
            return Err(Unwind::Stop);
        }
        if self.is_silent.get() || core.stopping.get() != StopState::No {
            return Ok(());
        }
        let tick = self.statement_count.get() + 1;
        self.statement_count.set(tick);
        let depth = core.depth.get();
        // Dropped after nothing is borrowed any more: values may run script code when they go.
        drop(self.record_statement(core.thread.get(), depth, f, site, tick, keeps));
        self.pause(ev, f, site, tick, |watcher, halt, at| {
            watcher.on_statement(halt, at)
        })
    }

    /// The statement raises an exception.
    #[cold]
    pub(crate) fn report_exception(
        &self,
        ev: &Evaluator<'_>,
        f: &mut Frame<'_>,
        site: &Rc<StatementSite>,
        exception: &Rc<Instance>,
    ) -> R<()> {
        let is_known = self.last_raised.borrow().as_ptr() == Rc::as_ptr(exception);
        if is_known || self.is_silent.get() || self.is_over.get() {
            return Ok(());
        }
        self.last_raised.put(Rc::downgrade(exception));
        let value = Value::Instance(exception.clone());
        self.pause(
            ev,
            f,
            site,
            self.statement_count.get(),
            |watcher, halt, at| watcher.on_exception(halt, at, &value),
        )
    }

    /// A statement that is no block is over: its variables are no longer kept twice.
    pub(crate) fn end_statement(&self, ev: &Evaluator<'_>) {
        let thread = ev.core.thread.get();
        let depth = ev.core.depth.get();
        let values = {
            let mut traces = self.traces.borrow_mut();
            let trace = traces.iter_mut().find(|trace| trace.thread == thread);
            let level = trace.and_then(|trace| {
                let mut levels = trace.levels.iter_mut().rev();
                levels.find(|level| level.depth == depth)
            });
            level.map(|level| std::mem::take(&mut level.values))
        };
        drop(values);
    }

    fn pause(
        &self,
        ev: &Evaluator<'_>,
        f: &mut Frame<'_>,
        site: &Rc<StatementSite>,
        tick: u64,
        ask: impl Fn(&dyn DebugHook, &PausedProgram<'_>, &StatementEvent<'_>) -> DebugAction,
    ) -> R<()> {
        let core = &ev.core;
        loop {
            let at = StatementEvent {
                site,
                thread: ThreadId(core.thread.get()),
                depth: core.depth.get(),
                tick,
                function: f.function,
            };
            let halt = PausedProgram {
                core,
                debugger: self,
                top: Some(TopFrame {
                    thread: at.thread,
                    depth: at.depth,
                    slots: ScriptCell::new(&mut *f.slots),
                }),
            };
            match ask(&*self.watcher, &halt, &at) {
                DebugAction::Continue => return Ok(()),
                DebugAction::Yield => {
                    let now = core.host.monotonic();
                    ev.suspend(SuspendRequest::Park { until: Some(now) })?;
                }
                DebugAction::Stop => {
                    core.begin_stop();
                    return Err(Unwind::Stop);
                }
                DebugAction::End => {
                    self.is_over.set(true);
                    core.stopping.set(StopState::Abandoned);
                    return Err(Unwind::Stop);
                }
            }
        }
    }

    /// Notes where a thread is; gives back what is dropped.
    fn record_statement(
        &self,
        thread: u64,
        depth: u32,
        f: &Frame<'_>,
        site: &Rc<StatementSite>,
        tick: u64,
        keeps: bool,
    ) -> (Vec<CallRecord>, Vec<Value>) {
        let mut traces = self.traces.borrow_mut();
        let index = match traces.iter().position(|trace| trace.thread == thread) {
            Some(index) => index,
            None => {
                traces.push(ThreadCalls {
                    thread,
                    levels: Vec::new(),
                    depth,
                });
                traces.len() - 1
            }
        };
        let levels = &mut traces[index].levels;
        let kept = levels
            .iter()
            .rposition(|level| {
                let is_same = level.depth == depth
                    && !site.is_first
                    && Rc::ptr_eq(&level.function, f.function);
                level.depth < depth || is_same
            })
            .map_or(0, |last| last + 1);
        let left: Vec<CallRecord> = match kept < levels.len() {
            true => levels.drain(kept..).collect(),
            false => Vec::new(),
        };
        let keeps = keeps && levels.len() < LEVELS_MAX;
        let values = match keeps {
            true => f.slots.to_vec(),
            false => Vec::new(),
        };
        match levels.last_mut().filter(|level| level.depth == depth) {
            Some(level) => {
                level.before = level.tick;
                level.tick = tick;
                if !Rc::ptr_eq(&level.site, site) {
                    level.site = site.clone();
                }
                (left, std::mem::replace(&mut level.values, values))
            }
            None => {
                levels.push(CallRecord {
                    function: f.function.clone(),
                    depth,
                    site: site.clone(),
                    tick,
                    first: tick,
                    before: 0,
                    values,
                });
                (left, Vec::new())
            }
        }
    }

    /// Whether the innermost call of the running thread stands where this statement began.
    pub(crate) fn is_at(&self, ev: &Evaluator<'_>, site: &Rc<StatementSite>) -> bool {
        let thread = ev.core.thread.get();
        let traces = self.traces.borrow();
        let trace = traces.iter().find(|trace| trace.thread == thread);
        let depth = ev.core.depth.get();
        trace.is_some_and(|trace| {
            let mut levels = trace.levels.iter().rev();
            let own = levels.find(|level| level.depth == depth);
            own.is_some_and(|level| Rc::ptr_eq(&level.site, site))
        })
    }

    /// A thread is suspended with so many calls within calls.
    pub(crate) fn on_suspend(&self, thread: u64, depth: u32) {
        let mut traces = self.traces.borrow_mut();
        if let Some(trace) = traces.iter_mut().find(|trace| trace.thread == thread) {
            trace.depth = depth;
        }
    }

    /// A thread has ended.
    pub(crate) fn on_thread_end(&self, thread: u64) {
        let left = {
            let mut traces = self.traces.borrow_mut();
            let index = traces.iter().position(|trace| trace.thread == thread);
            index.map(|index| traces.remove(index))
        };
        drop(left);
    }
}
