//! Running programs: the evaluator, its coroutines, and the nodes it walks.
//!
//! A program is a tree of nodes (`expr`, `stmt`) that evaluate themselves; which node stands for what is decided once,
//! by `lower`. Every script thread and every generator is a coroutine with its own `Evaluator`, so that anything that
//! waits can suspend the whole thread from any depth of native calls.

mod as_c;
pub mod code;
pub mod core;
pub mod coroutine;
pub mod count;
pub mod expr;
pub mod generator;
pub mod node;
pub mod run;
pub mod steps;
pub mod stmt;
pub mod types;
pub mod walk;
pub mod watch;
pub mod words;

use std::cell::Cell;
use std::rc::Rc;

pub use self::core::InterpreterState;
use self::coroutine::RequestSink;
use self::words::{PairOf, Truth};
use crate::value::{Function, Instance, R, ScriptCell, Unwind, Value};

/// The variables of a running function.
pub struct Frame<'f> {
    /// Locals by slot.
    pub slots: &'f mut [Value],
    /// What is running.
    pub function: &'f Rc<Function>,
}

impl Frame<'_> {
    /// Lends the frame for a shorter time.
    pub fn reborrow(&mut self) -> Frame<'_> {
        Frame {
            slots: &mut *self.slots,
            function: self.function,
        }
    }
}

/// An expression that can be evaluated.
pub trait ExprNode: Sized {
    /// The value of the expression.
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R;

    /// The truth of the expression, without making a value of it where possible.
    #[inline(always)]
    fn truth(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<bool> {
        let value = self.eval_words(ev, f).whole()?;
        ev.truth(&value)
    }

    /// Whether `try_load` is worth asking.
    const HAS_TRY_LOAD: bool = false;

    /// A copy of its value, if that only has to be looked at where it lies.
    #[inline(always)]
    fn try_load(&self, _: &Frame<'_>) -> Option<Value> {
        None
    }
}

/// An expression as a part of another node, with results in registers.
pub trait DynExpr {
    /// Evaluates the expression like `ExprNode::eval`, with the result in registers.
    fn eval_words(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> PairOf<R>;
    /// Asks for its truth like `ExprNode::truth`, with the result in registers.
    fn truth_words(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Truth;
}

impl<E: ExprNode> DynExpr for E {
    fn eval_words(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> PairOf<R> {
        PairOf::pack(self.eval(ev, f))
    }

    fn truth_words(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Truth {
        self.truth(ev, f).into()
    }
}

impl dyn DynExpr {
    /// The value of the expression.
    #[inline(always)]
    pub fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        self.eval_words(ev, f).whole()
    }

    /// The truth of the expression.
    #[inline(always)]
    pub fn truth(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<bool> {
        self.truth_words(ev, f).into()
    }
}

/// Whatever stands there.
impl ExprNode for BoxExpr {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        (**self).eval(ev, f)
    }

    #[inline(always)]
    fn truth(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<bool> {
        (**self).truth(ev, f)
    }
}

/// A statement that can be executed.
pub trait StmtNode {
    /// Executes it.
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow;
}

/// A statement as a part of a block, with how it ended in registers.
pub trait DynStmt {
    /// Runs the statement like `StmtNode::exec`, with the result in registers.
    fn exec_words(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> PairOf<Flow>;
}

impl<S: StmtNode> DynStmt for S {
    fn exec_words(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> PairOf<Flow> {
        PairOf::pack(self.exec(ev, f))
    }
}

impl dyn DynStmt {
    /// Executes it.
    #[inline(always)]
    pub fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        self.exec_words(ev, f).whole()
    }
}

/// A boxed expression.
pub type BoxExpr = Box<dyn DynExpr>;

/// How a statement ended.
pub enum Flow {
    /// Go on with the next one.
    Next,
    /// Leave the innermost loop.
    Break,
    /// Go on with the innermost loop.
    Continue,
    /// Leave the function with this value.
    Return(Value),
    /// An exception, or the stop of the thread.
    Raise(Unwind),
}

const _: () = assert!(size_of::<Flow>() == 16);

impl From<R<()>> for Flow {
    fn from(result: R<()>) -> Self {
        match result {
            Ok(()) => Flow::Next,
            Err(raised) => Flow::Raise(raised),
        }
    }
}

/// Unwraps a result inside `StmtNode::exec`.
macro_rules! attempt {
    ($result:expr) => {
        match $result {
            Ok(value) => value,
            Err(raised) => return $crate::eval::Flow::Raise(raised),
        }
    };
}
pub(crate) use attempt;

/// What runs script code: one per coroutine.
pub struct Evaluator<'y> {
    /// What all coroutines of the interpreter share.
    pub core: Rc<InterpreterState>,
    outlet: RequestSink<'y>,
    /// Lowest address of the native stack that calls may reach.
    stack_limit: Cell<usize>,
    /// The exception whose handler is running, for a bare `raise`.
    handled: ScriptCell<Option<Rc<Instance>>>,
}

impl<'y> Evaluator<'y> {
    /// An evaluator for a coroutine that hands its requests to `outlet` and must not use the stack below `stack_limit`.
    pub fn new(core: Rc<InterpreterState>, outlet: RequestSink<'y>, stack_limit: usize) -> Self {
        Evaluator {
            core,
            outlet,
            stack_limit: Cell::new(stack_limit),
            handled: ScriptCell::new(None),
        }
    }

    /// Passed at every loop back-edge and call: counts fuel, and lets the driver in when it is used up.
    #[inline]
    pub fn safepoint(&self) -> R<()> {
        if task_memory::consume_fuel() {
            return Ok(());
        }
        self.out_of_fuel()
    }

    /// The exception whose handler is running.
    pub fn handled_exception(&self) -> Option<Rc<Instance>> {
        match (self.handled.get(), &self.outlet) {
            (None, RequestSink::Generator(_)) => self.core.outer_handled_exception.get(),
            (handled, _) => handled,
        }
    }

    /// Sets the exception whose handler is running; returns the one before.
    pub fn set_handled_exception(&self, exception: Option<Rc<Instance>>) -> Option<Rc<Instance>> {
        self.handled.replace(exception)
    }

    /// Notes on its way out that an exception passed through `span` of the running function.
    #[cold]
    #[inline(never)]
    pub fn trace(&self, f: &Frame<'_>, span: elite_syntax::Span, raised: Unwind) -> Unwind {
        if let Unwind::Exception(exception) = &raised
            && let Some(state) = exception.exception()
        {
            state.trace(f.function.code.clone(), span);
        }
        raised
    }
}

/// Adds the place of an operation to whatever it raises.
pub(crate) trait TraceExt<T> {
    /// Adds the place of `span` to the traceback of an exception, as `Evaluator::trace` does.
    fn trace_at(self, ev: &Evaluator<'_>, f: &Frame<'_>, span: elite_syntax::Span) -> R<T>;
}

impl<T> TraceExt<T> for R<T> {
    #[inline]
    fn trace_at(self, ev: &Evaluator<'_>, f: &Frame<'_>, span: elite_syntax::Span) -> R<T> {
        match self {
            Ok(value) => Ok(value),
            Err(raised) => Err(ev.trace(f, span, raised)),
        }
    }
}
