//! `while` and `for`. Every turn passes a safepoint.

use super::target::Target;
use crate::eval::code::Block;
use crate::eval::{Evaluator, Expr, Flow, Frame, Located, Statement, attempt};
use crate::source::Span;
use crate::value::{R, Value};

/// `while test: … else: …`
pub struct While {
    /// The condition.
    pub test: Expr,
    /// Its line.
    pub line: u32,
    /// What is repeated.
    pub body: Block,
    /// What runs when the condition fails.
    pub orelse: Block,
}

impl Statement for While {
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        while attempt!(self.test.truth(ev, f)) {
            match self.body.exec(ev, f) {
                Flow::Next | Flow::Continue => {}
                Flow::Break => return Flow::Next,
                other => return other,
            }
            ev.core.line.set(self.line);
            attempt!(ev.safepoint());
        }
        self.orelse.exec(ev, f)
    }
}

/// `for target in iterable: … else: …`
pub struct For {
    /// What is bound each turn.
    pub target: Box<dyn Target>,
    /// What is walked through.
    pub iterable: Expr,
    /// Where that is written.
    pub span: Span,
    /// Its line.
    pub line: u32,
    /// What is repeated.
    pub body: Block,
    /// What runs at the end.
    pub orelse: Block,
}

/// What a turn of a loop leads to.
enum Turn {
    Next,
    End(Flow),
}

impl For {
    #[inline]
    fn turn(&self, item: Value, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Turn {
        if let Err(raised) = self.target.assign(ev, f, item) {
            return Turn::End(Flow::Raise(raised));
        }
        match self.body.exec(ev, f) {
            Flow::Next | Flow::Continue => {}
            Flow::Break => return Turn::End(Flow::Next),
            other => return Turn::End(other),
        }
        ev.core.line.set(self.line);
        match ev.safepoint() {
            Ok(()) => Turn::Next,
            Err(raised) => Turn::End(Flow::Raise(raised)),
        }
    }

    #[inline]
    fn items(
        &self,
        ev: &Evaluator<'_>,
        f: &mut Frame<'_>,
        mut next: impl FnMut(&Evaluator<'_>, &Frame<'_>) -> R<Option<Value>>,
    ) -> Flow {
        while let Some(item) = attempt!(next(ev, f)) {
            match self.turn(item, ev, f) {
                Turn::Next => {}
                Turn::End(flow) => return flow,
            }
        }
        self.orelse.exec(ev, f)
    }
}

impl Statement for For {
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let iterable = attempt!(self.iterable.eval(ev, f));
        match &iterable {
            Value::Range(range) => {
                let (mut value, step, mut left) = (range.start, range.step, range.len());
                self.items(ev, f, |_, _| {
                    if left == 0 {
                        return Ok(None);
                    }
                    left -= 1;
                    let now = value;
                    value = value.wrapping_add(step);
                    Ok(Some(Value::Int(now)))
                })
            }
            Value::List(list) => {
                let mut index = 0;
                self.items(ev, f, |_, _| {
                    index += 1;
                    Ok(list.get(index - 1))
                })
            }
            Value::Tuple(tuple) => {
                let mut items = tuple.items().iter();
                self.items(ev, f, |_, _| Ok(items.next().cloned()))
            }
            _ => {
                let iterator = attempt!(ev.iter(&iterable).at(ev, f, self.span));
                self.items(ev, f, |ev, f| ev.next(&iterator).at(ev, f, self.span))
            }
        }
    }
}
