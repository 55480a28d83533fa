//! `while` and `for`: one loop for both, which passes a safepoint every turn. Within generators, which stop in the
//! midst of a turn, the same parts are steps (`steps`).

use elite_syntax::Span;

use super::target::{Target, Unpack};
use crate::eval::code::Block;
use crate::eval::walk::{LoopCursor, LoopItem};
use crate::eval::words::PairOf;
use crate::eval::{BoxExpr, Evaluator, Flow, Frame, StmtNode, attempt};
use crate::value::{R, Value};

/// What all loops have: what is done each turn, and at the end.
pub struct LoopBody {
    /// The line of the loop.
    pub line: u32,
    /// What is repeated.
    pub body: Block,
    /// What runs when there is no other turn.
    pub orelse: Block,
}

impl LoopBody {
    /// Runs the loop; `next` prepares the next turn and says whether there is one.
    #[inline(always)]
    fn run(
        &self,
        ev: &Evaluator<'_>,
        f: &mut Frame<'_>,
        mut next: impl FnMut(&mut Frame<'_>) -> R<bool>,
    ) -> Flow {
        while attempt!(next(f)) {
            match self.body.exec(ev, f) {
                Flow::Next | Flow::Continue => {}
                Flow::Break => return Flow::Next,
                other => return other,
            }
            ev.core.finish_turn(self.line);
            attempt!(ev.safepoint());
        }
        self.orelse.exec(ev, f)
    }
}

/// `while test: … else: …`
pub struct While {
    /// The condition.
    pub test: BoxExpr,
    /// What is done each turn, and at the end.
    pub turns: LoopBody,
}

impl StmtNode for While {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        self.turns.run(ev, f, |f| self.test.truth(ev, f))
    }
}

/// What a loop binds each turn.
pub enum LoopTarget {
    /// A local variable.
    Slot(u32),
    /// `a, b`: exactly two targets.
    Pair(Unpack),
    /// Anything else.
    Other(Box<dyn Target>),
}

impl LoopTarget {
    /// Binds the next item; false at the end.
    #[inline(always)]
    pub fn bind_next(
        &self,
        walk: &mut LoopCursor,
        ev: &Evaluator<'_>,
        f: &mut Frame<'_>,
        span: Span,
    ) -> R<bool> {
        if let LoopTarget::Pair(unpack) = self {
            return self.bind_next_pair(unpack, walk, ev, f, span);
        }
        match walk.next(ev, f, span)? {
            Some(item) => self.assign(ev, f, item).map(|()| true),
            None => Ok(false),
        }
    }

    #[inline(never)]
    fn bind_next_pair(
        &self,
        unpack: &Unpack,
        walk: &mut LoopCursor,
        ev: &Evaluator<'_>,
        f: &mut Frame<'_>,
        span: Span,
    ) -> R<bool> {
        match (walk.next_pair(ev, f, span)?, &*unpack.targets) {
            (None, _) => return Ok(false),
            (Some(LoopItem::Two(first, second)), [a, b]) => {
                a.assign(ev, f, first)?;
                b.assign(ev, f, second)?;
            }
            (Some(LoopItem::Two(first, second)), _) => {
                unpack.assign(ev, f, Value::pair(first, second))?;
            }
            (Some(LoopItem::One(item)), _) => unpack.assign(ev, f, item)?,
        }
        Ok(true)
    }

    #[inline(always)]
    fn assign(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>, item: Value) -> R<()> {
        if let LoopTarget::Slot(slot) = self {
            f.slots[*slot as usize].put(item);
            return Ok(());
        }
        self.assign_other(ev, f, PairOf::pack(item))
    }

    #[inline(never)]
    fn assign_other(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>, item: PairOf<Value>) -> R<()> {
        let item = item.whole();
        match self {
            LoopTarget::Pair(unpack) => unpack.assign(ev, f, item),
            LoopTarget::Slot(slot) => {
                f.slots[*slot as usize].put(item);
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
    pub iterable: BoxExpr,
    /// The place of the iterable in the text.
    pub span: Span,
    /// What is done each turn, and at the end.
    pub turns: LoopBody,
}

impl StmtNode for For {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let iterable = attempt!(self.iterable.eval(ev, f));
        let mut walk = attempt!(LoopCursor::over(iterable, ev, f, self.span));
        let next = |f: &mut Frame<'_>| self.target.bind_next(&mut walk, ev, f, self.span);
        self.turns.run(ev, f, next)
    }
}
