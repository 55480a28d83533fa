//! `while` and `for`. Every turn passes a safepoint.

use super::target::Target;
use crate::eval::code::Block;
use crate::eval::walk::Walk;
use crate::eval::{Evaluator, Expr, Flow, Frame, Statement, attempt};
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

/// What a loop binds each turn.
pub enum LoopTarget {
    /// A local variable.
    Slot(u32),
    /// Anything else.
    Other(Box<dyn Target>),
}

impl LoopTarget {
    /// Binds it.
    #[inline]
    pub fn assign(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>, item: Value) -> R<()> {
        match self {
            LoopTarget::Slot(slot) => {
                f.slots[*slot as usize] = item;
                Ok(())
            }
            LoopTarget::Other(target) => target.assign(ev, f, item),
        }
    }
}

/// `for target in iterable: … else: …`
pub struct For {
    /// What is bound each turn.
    pub target: LoopTarget,
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

impl Statement for For {
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let iterable = attempt!(self.iterable.eval(ev, f));
        let mut walk = attempt!(Walk::over(iterable, ev, f, self.span));
        while let Some(item) = attempt!(walk.next(ev, f, self.span)) {
            attempt!(self.target.assign(ev, f, item));
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
