//! `yield` and `yield from`.

use elite_syntax::Span;

use crate::errors::ExceptionKind;
use crate::eval::generator::{GeneratorInput, StepResult};
use crate::eval::{BoxExpr, Evaluator, ExprNode, Frame, TraceExt};
use crate::value::symbol::known;
use crate::value::{R, Unwind, Value};

/// `yield value`
pub struct Yield {
    /// What is handed out.
    pub value: Option<BoxExpr>,
    /// The place in the text.
    pub span: Span,
}

impl ExprNode for Yield {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let value = match &self.value {
            Some(value) => value.eval(ev, f)?,
            None => Value::None,
        };
        let line = ev.core.line.get();
        let sent = ev
            .yield_value(f.slots, value, None)
            .trace_at(ev, f, self.span);
        ev.core.line.set(line);
        sent
    }
}

/// `yield from iterable`
pub struct YieldFrom {
    /// What values come from.
    pub value: BoxExpr,
    /// The place in the text.
    pub span: Span,
}

impl ExprNode for YieldFrom {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let iterable = self.value.eval(ev, f)?;
        delegate(&iterable, ev, f).trace_at(ev, f, self.span)
    }
}

fn delegate(iterable: &Value, ev: &Evaluator<'_>, f: &Frame<'_>) -> R {
    let iterator = ev.iter(iterable)?;
    let mut step = ev.step_with(&iterator, Value::None)?;
    loop {
        let value = match step {
            StepResult::Yielded(value) => value,
            StepResult::Returned(value) => return Ok(value),
        };
        let input = match ev.yield_value(f.slots, value, Some(&iterator)) {
            Ok(sent) => GeneratorInput::Send(sent),
            Err(raised) => GeneratorInput::Throw(raised),
        };
        step = ev.forward_input(&iterator, input)?;
    }
}

impl Evaluator<'_> {
    /// The next step of any iterator, sending it a value if it takes one.
    pub fn step_with(&self, iterator: &Value, sent: Value) -> R<StepResult> {
        if let Value::Generator(generator) = iterator {
            let step = self.step_generator(generator, GeneratorInput::Send(sent));
            return step.map_err(|raised| self.generator_error(raised));
        }
        if sent.is_none() {
            if let Value::Iter(_) = iterator {
                return match self.next_with_end(iterator) {
                    Ok(Some(value)) => Ok(StepResult::Yielded(value)),
                    Ok(None) => Ok(StepResult::Returned(Value::None)),
                    Err(raised) => self.stop_iteration_value(raised).map(StepResult::Returned),
                };
            }
            let next = self.attribute(iterator, known::NEXT)?;
            return self.step_result(self.call(&next, &mut [], &[]));
        }
        let send = self.attribute(iterator, known::SEND)?;
        self.step_result(self.call1(&send, sent))
    }

    /// A `StopIteration` as the end of an iterator with its value.
    fn step_result(&self, result: R) -> R<StepResult> {
        match result {
            Ok(value) => Ok(StepResult::Yielded(value)),
            Err(raised) => self.stop_iteration_value(raised).map(StepResult::Returned),
        }
    }

    /// The value a `StopIteration` carries; any other exception goes on.
    pub fn stop_iteration_value(&self, raised: Unwind) -> R {
        match &raised {
            Unwind::Exception(exception) if self.is_kind(&raised, ExceptionKind::StopIteration) => {
                self.attribute(&Value::Instance(exception.clone()), known::VALUE)
            }
            _ => Err(raised),
        }
    }

    /// Raises an exception where an iterator stands.
    pub fn throw_into(&self, iterator: &Value, raised: Unwind) -> R<StepResult> {
        if let Value::Generator(generator) = iterator {
            let step = self.step_generator(generator, GeneratorInput::Throw(raised));
            return step.map_err(|raised| self.generator_error(raised));
        }
        match (self.attribute_or_none(iterator, known::THROW)?, &raised) {
            (Some(throw), Unwind::Exception(exception)) => {
                self.step_result(self.call1(&throw, Value::Instance(exception.clone())))
            }
            _ => Err(raised),
        }
    }

    /// Closes an iterator that can be closed.
    pub fn close_iterator(&self, iterator: &Value) -> R<()> {
        if let Value::Generator(generator) = iterator {
            return self.close_generator(generator);
        }
        if matches!(iterator, Value::Iter(_)) {
            return Ok(());
        }
        match self.attribute_or_none(iterator, known::CLOSE)? {
            Some(close) => self.call(&close, &mut [], &[]).map(|_| ()),
            None => Ok(()),
        }
    }

    /// Python's `generator.close()`.
    pub fn close_generator(&self, generator: &crate::eval::generator::Generator) -> R<()> {
        if generator.is_finished() {
            return Ok(());
        }
        let exit = self.raise(ExceptionKind::GeneratorExit, "");
        match self.step_generator(generator, GeneratorInput::Throw(exit)) {
            Ok(StepResult::Returned(_)) => Ok(()),
            Ok(StepResult::Yielded(_)) => Err(self.raise(
                ExceptionKind::RuntimeError,
                "generator ignored GeneratorExit",
            )),
            Err(raised) => {
                let ends = self.is_kind(&raised, ExceptionKind::GeneratorExit)
                    || self.is_kind(&raised, ExceptionKind::StopIteration);
                if ends { Ok(()) } else { Err(raised) }
            }
        }
    }
}
