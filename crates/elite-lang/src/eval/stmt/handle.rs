//! `try`: what its clauses do. The statements they protect stand in the block around it (`code`).

use std::ops::Range;
use std::rc::Rc;

use elite_syntax::Span;

use super::target::Target;
use crate::errors::ExceptionKind;
use crate::eval::code::Block;
use crate::eval::coroutine::StopState;
use crate::eval::{BoxExpr, Evaluator, Flow, Frame, StmtNode, TraceExt};
use crate::limits::deferred_drop::NodeList;
use crate::limits::yielding::WORK_PER_VALUE;
use crate::value::{Instance, R, Unwind, Value};

/// An `except` clause.
pub struct ExceptClause {
    /// The type or types it takes; none for all.
    pub exception: Option<BoxExpr>,
    /// The name the exception is bound to, and unbound from at the end.
    pub name: Option<Box<dyn Target>>,
    /// What runs.
    pub body: Block,
    /// Where the types are written.
    pub span: Span,
}

/// Statements of a block that `except` clauses protect.
pub struct ProtectedRange {
    /// The numbers of the protected statements in the block.
    pub body: Range<usize>,
    /// The statement that follows a clause: the first one behind the `else` clause.
    pub after: usize,
    /// The clauses in order.
    pub handlers: NodeList<ExceptClause>,
}

impl ProtectedRange {
    /// Runs the clause that takes an exception; without one it goes on.
    pub fn handle(&self, exception: Rc<Instance>, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let outer = ev.set_handled_exception(Some(exception.clone()));
        if let Some(outer) = &outer {
            ev.chain(&Unwind::Exception(exception.clone()), outer);
        }
        let flow = self.handle_inside(&exception, ev, f);
        ev.set_handled_exception(outer);
        if let Flow::Raise(raised) = &flow {
            ev.chain(raised, &exception);
        }
        flow
    }

    fn handle_inside(
        &self,
        exception: &Rc<Instance>,
        ev: &Evaluator<'_>,
        f: &mut Frame<'_>,
    ) -> Flow {
        for handler in &self.handlers {
            let takes = match &handler.exception {
                None => Ok(true),
                Some(types) => types.eval(ev, f).and_then(|types| {
                    ev.exception_matches(exception, &types)
                        .trace_at(ev, f, handler.span)
                }),
            };
            match takes {
                Ok(false) => {}
                Ok(true) => return handler.run(exception, ev, f),
                Err(raised) => return Flow::Raise(raised),
            }
        }
        Flow::Raise(Unwind::Exception(exception.clone()))
    }
}

impl ExceptClause {
    /// Runs the clause for an exception it takes.
    pub fn run(&self, exception: &Rc<Instance>, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let Some(name) = &self.name else {
            return self.body.exec(ev, f);
        };
        if let Err(raised) = name.assign(ev, f, Value::Instance(exception.clone())) {
            return Flow::Raise(raised);
        }
        let flow = self.body.exec(ev, f);
        // Unbound in any case, also if the script has deleted or rebound it.
        let unbound = name.assign(ev, f, Value::Unbound);
        debug_assert!(unbound.is_ok());
        flow
    }
}

impl Evaluator<'_> {
    /// Whether an `except` clause with these types takes an exception.
    pub fn exception_matches(&self, exception: &Rc<Instance>, types: &Value) -> R<bool> {
        match types {
            Value::Class(class) if class.base == crate::value::class::BuiltinBase::Exception => {
                Ok(exception.class.is_subclass_of(class))
            }
            Value::Tuple(tuple) => self.with_native_depth(|| {
                // All classes of the tuple are looked at: a wrong one is an error also behind one that takes the
                // exception.
                let mut takes = false;
                for item in tuple.items() {
                    self.charge(WORK_PER_VALUE)?;
                    takes |= self.exception_matches(exception, item)?;
                }
                Ok(takes)
            }),
            _ => {
                let text = "catching classes that do not inherit from BaseException is not allowed";
                Err(self.raise(ExceptionKind::TypeError, text))
            }
        }
    }
}

/// `try: … finally: …`
pub struct Finally {
    /// What runs first.
    pub body: Block,
    /// What runs in any case.
    pub finally: Block,
}

impl StmtNode for Finally {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let flow = self.body.exec(ev, f);
        let raised = match &flow {
            Flow::Raise(Unwind::Exception(exception)) => Some(exception.clone()),
            Flow::Raise(Unwind::Stop) if ev.core.stopping.get() == StopState::Abandoned => {
                return flow;
            }
            _ => None,
        };
        let line = ev.core.line.get();
        let outer = raised
            .clone()
            .map(|exception| ev.set_handled_exception(Some(exception)));
        let last = self.finally.exec(ev, f);
        if let Some(outer) = outer {
            ev.set_handled_exception(outer);
        }
        match last {
            Flow::Next => {
                ev.core.line.set(line);
                flow
            }
            // A stop cannot be swallowed by `return`, `break` or an exception in a `finally` block.
            _ if matches!(flow, Flow::Raise(Unwind::Stop)) => flow,
            Flow::Raise(other) => {
                if let Some(exception) = raised {
                    ev.chain(&other, &exception);
                }
                Flow::Raise(other)
            }
            leaves => leaves,
        }
    }
}
