//! Bodies of generators as lists of steps, which stop at a `yield` and go on from there.
//!
//! A body whose `yield`s stand where a statement can stop (`yield x`, `a = yield x`, `yield from x` in blocks of `if`,
//! `while` and `for`) needs no native stack of its own: its place is a number, its loops are a list. All others, with
//! `yield` inside an expression or within `try` or `with`, are coroutines (`generator`). `lower` decides.

use std::rc::Rc;

use elite_syntax::Span;

use super::expr::operand::Operand;
use super::generator::{GeneratorInput, StepResult};
use super::stmt::loops::LoopTarget;
use super::stmt::target::Target;
use super::walk::LoopCursor;
use super::{BoxExpr, DynStmt, Evaluator, Flow, Frame, TraceExt};
use crate::errors::ExceptionKind;
use crate::limits::deferred_drop;
use crate::value::{Function, R, Unwind, Value};

/// Index of a step.
pub type StepIndex = u32;

/// One step of a body.
pub enum GeneratorStep {
    /// A statement without `yield`, and where `break` and `continue` in it lead.
    Run {
        line: u32,
        statement: Box<dyn DynStmt>,
        on_break: StepIndex,
        on_continue: StepIndex,
    },
    /// Goes on elsewhere.
    Jump(StepIndex),
    /// Goes on elsewhere unless the test holds.
    JumpUnless {
        line: u32,
        test: BoxExpr,
        otherwise: StepIndex,
    },
    /// The end of a turn of a loop: a safepoint, then its next turn.
    LoopBack { line: u32, head: StepIndex },
    /// Begins a `for` loop.
    BeginFor {
        line: u32,
        iterable: BoxExpr,
        span: Span,
    },
    /// Binds the next item of the innermost `for` loop; at its end goes on elsewhere.
    Next {
        target: LoopTarget,
        span: Span,
        end: StepIndex,
    },
    /// Leaves the innermost `for` loop before its end.
    EndFor,
    /// `sent = yield value`
    Yield {
        line: u32,
        value: Operand,
        sent: Option<Box<dyn Target>>,
        span: Span,
    },
    /// `sent = yield from iterable`
    Delegate {
        line: u32,
        iterable: BoxExpr,
        sent: Option<Box<dyn Target>>,
        span: Span,
    },
    /// `return value`
    Return { line: u32, value: Operand },
}

/// Where a generator stands.
pub struct GeneratorFrame {
    slots: Vec<Value>,
    /// The `for` loops and `yield from`s that the generator is in, innermost last.
    walks: Vec<LoopCursor>,
    index: usize,
    /// The generator stands at the `yield` of this step, which has handed its value out.
    is_at_yield: bool,
}

impl GeneratorFrame {
    /// At the beginning, parameters bound.
    pub fn new(slots: Vec<Value>) -> Self {
        GeneratorFrame {
            slots,
            walks: Vec::new(),
            index: 0,
            is_at_yield: false,
        }
    }

    /// Runs `each` on what it refers to.
    pub fn visit(&self, each: &mut dyn FnMut(&Value)) {
        self.slots.iter().for_each(&mut *each);
        for walk in &self.walks {
            walk.visit(each);
        }
    }

    /// Whether the generator stands at a `yield`.
    pub fn is_at_yield(&self) -> bool {
        self.is_at_yield
    }

    /// The variables.
    pub fn slots(&self) -> &[Value] {
        &self.slots
    }

    /// What it delegates to, if it stands at a `yield from`.
    pub fn delegate(&self, steps: &[GeneratorStep]) -> Option<Value> {
        let at = steps.get(self.index).filter(|_| self.is_at_yield);
        match (at, self.walks.last()) {
            (Some(GeneratorStep::Delegate { .. }), Some(LoopCursor::Iterator(iterator))) => {
                Some(iterator.clone())
            }
            _ => None,
        }
    }

    /// The line of the `yield` it stands at; 0 at the beginning.
    pub fn line(&self, steps: &[GeneratorStep]) -> u32 {
        match steps.get(self.index).filter(|_| self.is_at_yield) {
            Some(GeneratorStep::Yield { line, .. } | GeneratorStep::Delegate { line, .. }) => *line,
            _ => 0,
        }
    }
}

impl Drop for GeneratorFrame {
    fn drop(&mut self) {
        let mut values = std::mem::take(&mut self.slots);
        // A generator may stand in the loop of a generator in the loop of a generator …
        values.extend(self.walks.drain(..).filter_map(|walk| match walk {
            LoopCursor::Iterator(iterator) => Some(iterator),
            _ => None,
        }));
        deferred_drop::drop_values(&mut values);
    }
}

impl Evaluator<'_> {
    /// Goes on to the next `yield` or the end.
    pub(super) fn resume_steps(
        &self,
        steps: &[GeneratorStep],
        standing: &mut GeneratorFrame,
        function: &Rc<Function>,
        input: GeneratorInput,
    ) -> R<StepResult> {
        let GeneratorFrame {
            slots,
            walks,
            index: at,
            is_at_yield: waits,
        } = standing;
        let f = &mut Frame { slots, function };
        let line = &self.core.line;
        if std::mem::take(waits) {
            match (&steps[*at], input) {
                (
                    GeneratorStep::Yield {
                        line: number, sent, ..
                    },
                    GeneratorInput::Send(value),
                ) => {
                    line.set(*number);
                    if let Some(sent) = sent {
                        sent.assign(self, f, value)?;
                    }
                }
                (
                    GeneratorStep::Delegate {
                        line: number,
                        sent,
                        span,
                        ..
                    },
                    input,
                ) => {
                    line.set(*number);
                    let Some(LoopCursor::Iterator(iterator)) = walks.last() else {
                        return Err(Unwind::Stop);
                    };
                    match self
                        .forward_input(iterator, input)
                        .trace_at(self, f, *span)?
                    {
                        StepResult::Yielded(value) => {
                            *waits = true;
                            return Ok(StepResult::Yielded(value));
                        }
                        StepResult::Returned(value) => {
                            walks.pop();
                            if let Some(sent) = sent {
                                sent.assign(self, f, value)?;
                            }
                        }
                    }
                }
                (
                    GeneratorStep::Yield {
                        line: number, span, ..
                    },
                    GeneratorInput::Throw(raised),
                ) => {
                    line.set(*number);
                    return Err(self.trace(f, *span, raised));
                }
                // A generator waits at no other step, and makes no requests of its own.
                _ => return Err(Unwind::Stop),
            }
            *at += 1;
        }
        while let Some(step) = steps.get(*at) {
            match step {
                GeneratorStep::Run {
                    line: number,
                    statement,
                    on_break,
                    on_continue,
                } => {
                    line.set(*number);
                    match statement.exec(self, f) {
                        Flow::Next => {}
                        Flow::Break => {
                            *at = *on_break as usize;
                            continue;
                        }
                        Flow::Continue => {
                            *at = *on_continue as usize;
                            continue;
                        }
                        Flow::Return(value) => return Ok(StepResult::Returned(value)),
                        Flow::Raise(raised) => return Err(raised),
                    }
                }
                GeneratorStep::Jump(place) => {
                    *at = *place as usize;
                    continue;
                }
                GeneratorStep::JumpUnless {
                    line: number,
                    test,
                    otherwise,
                } => {
                    line.set(*number);
                    if !test.truth(self, f)? {
                        *at = *otherwise as usize;
                        continue;
                    }
                }
                GeneratorStep::LoopBack { line: number, head } => {
                    self.core.finish_turn(*number);
                    self.safepoint()?;
                    *at = *head as usize;
                    continue;
                }
                GeneratorStep::BeginFor {
                    line: number,
                    iterable,
                    span,
                } => {
                    line.set(*number);
                    let iterable = iterable.eval(self, f)?;
                    walks.push(LoopCursor::over(iterable, self, f, *span)?);
                }
                GeneratorStep::Next { target, span, end } => {
                    let bound = match walks.last_mut() {
                        Some(walk) => target.bind_next(walk, self, f, *span)?,
                        None => false,
                    };
                    if !bound {
                        walks.pop();
                        *at = *end as usize;
                        continue;
                    }
                }
                GeneratorStep::EndFor => drop(walks.pop()),
                GeneratorStep::Yield {
                    line: number,
                    value,
                    ..
                } => {
                    line.set(*number);
                    let value = value.eval(self, f)?;
                    *waits = true;
                    return Ok(StepResult::Yielded(value));
                }
                GeneratorStep::Delegate {
                    line: number,
                    iterable,
                    sent,
                    span,
                } => {
                    line.set(*number);
                    let iterable = iterable.eval(self, f)?;
                    let iterator = self.iter(&iterable).trace_at(self, f, *span)?;
                    match self
                        .step_with(&iterator, Value::None)
                        .trace_at(self, f, *span)?
                    {
                        StepResult::Yielded(value) => {
                            walks.push(LoopCursor::Iterator(iterator));
                            *waits = true;
                            return Ok(StepResult::Yielded(value));
                        }
                        StepResult::Returned(value) => {
                            if let Some(sent) = sent {
                                sent.assign(self, f, value)?;
                            }
                        }
                    }
                }
                GeneratorStep::Return {
                    line: number,
                    value,
                } => {
                    line.set(*number);
                    return Ok(StepResult::Returned(value.eval(self, f)?));
                }
            }
            *at += 1;
        }
        Ok(StepResult::Returned(Value::None))
    }

    /// Hands what a generator was resumed with to the iterator it delegates to.
    pub fn forward_input(&self, iterator: &Value, input: GeneratorInput) -> R<StepResult> {
        match input {
            GeneratorInput::Send(sent) => self.step_with(iterator, sent),
            GeneratorInput::Throw(Unwind::Stop) | GeneratorInput::Resumed(_) => Err(Unwind::Stop),
            GeneratorInput::Throw(raised)
                if self.is_kind(&raised, ExceptionKind::GeneratorExit) =>
            {
                self.close_iterator(iterator)?;
                Err(raised)
            }
            GeneratorInput::Throw(raised) => self.throw_into(iterator, raised),
        }
    }
}
