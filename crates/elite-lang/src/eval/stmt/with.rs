//! `with`.

use elite_syntax::Span;

use super::target::Target;
use crate::errors::ExceptionKind;
use crate::eval::code::Block;
use crate::eval::coroutine::StopState;
use crate::eval::{BoxExpr, Evaluator, Flow, Frame, StmtNode, TraceExt, attempt};
use crate::value::symbol::known;
use crate::value::{R, Symbol, Unwind, Value};

/// `with context as target: …` with one item; more are nested.
pub struct With {
    /// The context manager.
    pub context: BoxExpr,
    /// What its `__enter__` result is bound to.
    pub target: Option<Box<dyn Target>>,
    /// What runs.
    pub body: Block,
    /// Where the context is written.
    pub span: Span,
}

impl StmtNode for With {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let manager = attempt!(self.context.eval(ev, f));
        let enter = attempt!(method(ev, &manager, known::ENTER).trace_at(ev, f, self.span));
        let exit = attempt!(method(ev, &manager, known::EXIT).trace_at(ev, f, self.span));
        let entered = attempt!(
            ev.call_method_value(&enter, &manager, &mut [])
                .trace_at(ev, f, self.span)
        );
        let flow = match &self.target {
            Some(target) => match target.assign(ev, f, entered) {
                Ok(()) => self.body.exec(ev, f),
                Err(raised) => Flow::Raise(raised),
            },
            None => self.body.exec(ev, f),
        };
        self.leave(flow, &manager, &exit, ev, f)
    }
}

impl With {
    fn leave(
        &self,
        flow: Flow,
        manager: &Value,
        exit: &Value,
        ev: &Evaluator<'_>,
        f: &mut Frame<'_>,
    ) -> Flow {
        let mut none = [Value::None, Value::None, Value::None];
        match &flow {
            Flow::Raise(Unwind::Stop) => {
                if ev.core.stopping.get() != StopState::Abandoned {
                    // The stop goes on whatever the exit says.
                    let ignored = ev.call_method_value(exit, manager, &mut none);
                    drop(ignored);
                }
                flow
            }
            Flow::Raise(Unwind::Exception(exception)) => {
                let outer = ev.set_handled_exception(Some(exception.clone()));
                let class = Value::Class(exception.class.clone());
                let traceback = exception
                    .exception()
                    .map_or(Value::None, |state| ev.traceback_object(state));
                let mut args = [class, Value::Instance(exception.clone()), traceback];
                let result = ev
                    .call_method_value(exit, manager, &mut args)
                    .trace_at(ev, f, self.span);
                ev.set_handled_exception(outer);
                match result.and_then(|verdict| ev.truth(&verdict)) {
                    Ok(true) => Flow::Next,
                    Ok(false) => flow,
                    Err(raised) => {
                        ev.chain(&raised, exception);
                        Flow::Raise(raised)
                    }
                }
            }
            _ => {
                let line = ev.core.line.get();
                match ev
                    .call_method_value(exit, manager, &mut none)
                    .trace_at(ev, f, self.span)
                {
                    Ok(_) => {
                        ev.core.line.set(line);
                        flow
                    }
                    Err(raised) => Flow::Raise(raised),
                }
            }
        }
    }
}

/// `__enter__` or `__exit__` of a context manager.
fn method(ev: &Evaluator<'_>, manager: &Value, name: Symbol) -> R {
    let class = ev.core.types.of(manager);
    class.lookup(name).ok_or_else(|| {
        let (class, missed) = (ev.core.types.name_of(manager), name == known::EXIT);
        let detail = if missed {
            " (missed __exit__ method)"
        } else {
            ""
        };
        let text =
            format!("'{class}' object does not support the context manager protocol{detail}");
        ev.raise(ExceptionKind::TypeError, text)
    })
}
