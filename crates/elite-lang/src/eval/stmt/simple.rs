//! Expression statements, `print x`, `del`, `raise`.

use std::rc::Rc;

use elite_syntax::Span;
use elite_syntax::surrogate::may_have_surrogates;

use super::target::Target;
use crate::errors::ExceptionKind;
use crate::eval::{BoxExpr, Evaluator, Flow, Frame, StmtNode, TraceExt, attempt};
use crate::limits::deferred_drop::NodeList;
use crate::value::{Instance, R, Unwind, Value};

/// An expression whose value is not used.
pub struct ExprStatement(pub BoxExpr);

impl StmtNode for ExprStatement {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        match self.0.eval(ev, f) {
            Ok(value) => {
                value.drop_inline();
                Flow::Next
            }
            Err(raised) => Flow::Raise(raised),
        }
    }
}

/// `print x, y`
pub struct Print {
    /// What is printed.
    pub values: NodeList<BoxExpr>,
    /// After the last value: a line end, or a blank if the statement ends with a comma.
    pub end: &'static str,
    /// The place in the text.
    pub span: Span,
}

impl StmtNode for Print {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let mut text = String::new();
        for (index, value) in self.values.iter().enumerate() {
            let value = attempt!(value.eval(ev, f));
            text.push_str(if index > 0 { " " } else { "" });
            let part = attempt!(ev.str(&value).trace_at(ev, f, self.span));
            attempt!(ev.push_text(&mut text, &part).trace_at(ev, f, self.span));
        }
        text.push_str(self.end);
        attempt!(ev.print(&text).trace_at(ev, f, self.span));
        Flow::Next
    }
}

/// `del a, b[0]`
pub struct Delete(pub NodeList<Box<dyn Target>>);

impl StmtNode for Delete {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        for target in &self.0 {
            attempt!(target.delete(ev, f));
        }
        Flow::Next
    }
}

/// `raise exception from cause`
pub struct Raise {
    /// What is raised; nothing for the exception being handled.
    pub exception: Option<BoxExpr>,
    /// The exception behind `from`.
    pub cause: Option<BoxExpr>,
    /// The place in the text.
    pub span: Span,
}

impl StmtNode for Raise {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let Some(exception) = &self.exception else {
            return Flow::Raise(match ev.handled_exception() {
                Some(exception) => Unwind::Exception(exception),
                None => {
                    let error = ev.raise(
                        ExceptionKind::RuntimeError,
                        "No active exception to reraise",
                    );
                    ev.trace(f, self.span, error)
                }
            });
        };
        let value = attempt!(exception.eval(ev, f));
        let exception = attempt!(ev.to_exception(&value).trace_at(ev, f, self.span));
        if let Some(cause) = &self.cause {
            let cause = attempt!(cause.eval(ev, f));
            attempt!(set_cause(ev, &exception, &cause).trace_at(ev, f, self.span));
        }
        if let Some(handled) = ev.handled_exception()
            && let Some(state) = exception.exception()
        {
            ev.core.gc_track(&Value::Instance(exception.clone()));
            state.replace_context(&exception, &handled);
        }
        Flow::Raise(ev.trace(f, self.span, Unwind::Exception(exception)))
    }
}

fn set_cause(ev: &Evaluator<'_>, exception: &Rc<Instance>, cause: &Value) -> R<()> {
    let Some(state) = exception.exception() else {
        return Ok(());
    };
    state.suppress_context.set(true);
    if cause.is_none() {
        state.cause.put(Value::Unbound);
        return Ok(());
    }
    let cause = ev.to_exception(cause).map_err(|raised| {
        if ev.is_kind(&raised, ExceptionKind::TypeError) {
            return ev.type_error("exception causes must derive from BaseException");
        }
        raised
    })?;
    ev.core.gc_track(&Value::Instance(exception.clone()));
    state.cause.put(Value::Instance(cause));
    Ok(())
}

impl Evaluator<'_> {
    /// What `raise value` raises: an exception, or a new instance of an exception class.
    pub fn to_exception(&self, value: &Value) -> R<Rc<Instance>> {
        match value {
            Value::Instance(instance) if instance.exception().is_some() => Ok(instance.clone()),
            Value::Class(class) if class.base == crate::value::class::BuiltinBase::Exception => {
                match self.call(value, &mut [], &[])? {
                    Value::Instance(instance) if instance.exception().is_some() => Ok(instance),
                    other => {
                        let (class, name) = (class.name(), self.core.types.name_of(&other));
                        let text = "should have returned an instance of BaseException";
                        Err(self.type_error(format!("calling {class} {text}, not {name}")))
                    }
                }
            }
            _ => Err(self.type_error("exceptions must derive from BaseException")),
        }
    }

    /// Hands text to the host, which has work with it: it is logged, shown and recorded. Nothing may be borrowed.
    pub fn print(&self, text: &str) -> R<()> {
        if may_have_surrogates(text) {
            // There are none in what leaves the program.
            let text = crate::value::Str::new(text);
            self.encode(&text, &Value::Unbound, &Value::Unbound)?;
        }
        let thread = crate::host::ThreadId(self.core.thread.get());
        // What the host keeps of it is the host's.
        task_memory::uncounted(|| self.core.host.print(thread, text));
        self.charge_output(text.len())
    }
}
