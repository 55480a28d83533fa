//! Comparison nodes. Their truth is computed directly: no value is made for `if a < b`.

use std::marker::PhantomData;

use elite_syntax::Span;
use elite_syntax::ast::CompareOp;

use super::names::{Const, Readable};
use super::operand::{Operand, two_operands};
use crate::builtins::quick::contains;
use crate::eval::{BoxExpr, Evaluator, ExprNode, Frame, TraceExt};
use crate::limits::deferred_drop::NodeList;
use crate::ops::compare::fast;
use crate::value::{R, Value};

/// An ordering operator as a type.
pub trait Ordering: 'static {
    /// The operator that the type stands for.
    const OP: CompareOp;
}

macro_rules! declare {
    ($($name:ident),*) => {
        /// The ordering operators as types.
        #[allow(missing_docs)]
        pub mod op {
            $(pub struct $name;
            impl super::Ordering for $name {
                const OP: super::CompareOp = super::CompareOp::$name;
            })*
        }
    };
}
declare!(Eq, Ne, Lt, Le, Gt, Ge);

two_operands!(
    PeekPeek<O, A, B> { left: A, right: B }
);

impl<O: Ordering, A: Readable, B: Readable> PeekPeek<O, A, B> {
    fn slow(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        self.left.check(ev, f)?;
        self.right.check(ev, f)?;
        ev.compare(O::OP, self.left.peek(f), self.right.peek(f))
            .trace_at(ev, f, self.span)
    }
}

impl<O: Ordering, A: Readable, B: Readable> ExprNode for PeekPeek<O, A, B> {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        match fast(O::OP, self.left.peek(f), self.right.peek(f)) {
            Some(flag) => Ok(Value::Bool(flag)),
            None => self.slow(ev, f),
        }
    }

    #[inline(always)]
    fn truth(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<bool> {
        match fast(O::OP, self.left.peek(f), self.right.peek(f)) {
            Some(flag) => Ok(flag),
            None => truth_of(self.slow(ev, f)?, ev, f, self.span),
        }
    }
}

#[inline]
fn truth_of(value: Value, ev: &Evaluator<'_>, f: &Frame<'_>, span: Span) -> R<bool> {
    match value {
        Value::Bool(flag) => Ok(flag),
        other => ev.truth(&other).trace_at(ev, f, span),
    }
}

two_operands!(
    ExprPeek<O, B> { left: BoxExpr, right: B }
);

impl<O: Ordering, B: Readable> ExprPeek<O, B> {
    fn slow(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>, a: &Value) -> R {
        self.right.check(ev, f)?;
        ev.compare(O::OP, a, self.right.peek(f))
            .trace_at(ev, f, self.span)
    }
}

impl<O: Ordering, B: Readable> ExprNode for ExprPeek<O, B> {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let a = self.left.eval(ev, f)?;
        match fast(O::OP, &a, self.right.peek(f)) {
            Some(flag) => Ok(Value::Bool(flag)),
            None => self.slow(ev, f, &a),
        }
    }

    #[inline(always)]
    fn truth(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<bool> {
        let a = self.left.eval(ev, f)?;
        match fast(O::OP, &a, self.right.peek(f)) {
            Some(flag) => Ok(flag),
            None => truth_of(self.slow(ev, f, &a)?, ev, f, self.span),
        }
    }
}

two_operands!(
    ExprExpr<O> { left: BoxExpr, right: BoxExpr }
);

impl<O: Ordering> ExprNode for ExprExpr<O> {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let a = self.left.eval(ev, f)?;
        let b = self.right.eval(ev, f)?;
        match fast(O::OP, &a, &b) {
            Some(flag) => Ok(Value::Bool(flag)),
            None => ev.compare(O::OP, &a, &b).trace_at(ev, f, self.span),
        }
    }

    #[inline(always)]
    fn truth(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<bool> {
        let a = self.left.eval(ev, f)?;
        let b = self.right.eval(ev, f)?;
        match fast(O::OP, &a, &b) {
            Some(flag) => Ok(flag),
            None => truth_of(
                ev.compare(O::OP, &a, &b).trace_at(ev, f, self.span)?,
                ev,
                f,
                self.span,
            ),
        }
    }
}

/// `is`, `in` and their opposites.
struct Membership {
    op: CompareOp,
    left: Operand,
    right: Operand,
    span: Span,
}

impl ExprNode for Membership {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        self.truth(ev, f).map(Value::Bool)
    }

    #[inline(always)]
    fn truth(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<bool> {
        let looked = self
            .left
            .with_value(f, |a| self.right.with_value(f, |b| self.at_once(a, b)));
        if let Some(Some(Some(holds))) = looked {
            return Ok(holds);
        }
        let a = self.left.eval(ev, f)?;
        if let Operand::Local(right) = &self.right {
            right.check(ev, f)?;
            return self.holds(&a, right.peek(f), ev, f);
        }
        let b = self.right.eval(ev, f)?;
        self.holds(&a, &b, ev, f)
    }
}

impl Membership {
    /// Whether the item is in the container, if that is soon said.
    #[inline(always)]
    fn at_once(&self, a: &Value, b: &Value) -> Option<bool> {
        if a.is_unbound() || b.is_unbound() {
            return None;
        }
        match self.op {
            CompareOp::Is => Some(a.is(b)),
            CompareOp::IsNot => Some(!a.is(b)),
            CompareOp::In => contains(b, a),
            _ => contains(b, a).map(|found| !found),
        }
    }

    #[inline]
    fn holds(&self, a: &Value, b: &Value, ev: &Evaluator<'_>, f: &Frame<'_>) -> R<bool> {
        match self.op {
            CompareOp::Is => Ok(a.is(b)),
            CompareOp::IsNot => Ok(!a.is(b)),
            CompareOp::In => ev.contains(b, a).trace_at(ev, f, self.span),
            _ => ev
                .contains(b, a)
                .trace_at(ev, f, self.span)
                .map(|found| !found),
        }
    }
}

/// `a < b < c`: every operand is evaluated once, and none after a comparison that fails.
pub struct ComparisonChain {
    /// The first operand.
    pub first: BoxExpr,
    /// The comparisons after it.
    pub rest: NodeList<(CompareOp, BoxExpr)>,
    /// The place in the text.
    pub span: Span,
}

impl ExprNode for ComparisonChain {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let mut left = self.first.eval(ev, f)?;
        let mut result = Value::Bool(true);
        for (index, (op, right)) in self.rest.iter().enumerate() {
            let right = right.eval(ev, f)?;
            result = match fast_ordering(*op, &left, &right) {
                Some(flag) => Value::Bool(flag),
                None => ev.compare(*op, &left, &right).trace_at(ev, f, self.span)?,
            };
            if index + 1 < self.rest.len() && !ev.truth(&result).trace_at(ev, f, self.span)? {
                break;
            }
            left = right;
        }
        Ok(result)
    }
}

#[inline]
fn fast_ordering(op: CompareOp, a: &Value, b: &Value) -> Option<bool> {
    match op {
        CompareOp::Is | CompareOp::IsNot | CompareOp::In | CompareOp::NotIn => None,
        _ => fast(op, a, b),
    }
}

/// The node for `left op right`.
pub fn compare(op: CompareOp, left: Operand, right: Operand, span: Span) -> BoxExpr {
    match op {
        CompareOp::Eq => specialize::<op::Eq>(left, right, span),
        CompareOp::Ne => specialize::<op::Ne>(left, right, span),
        CompareOp::Lt => specialize::<op::Lt>(left, right, span),
        CompareOp::Le => specialize::<op::Le>(left, right, span),
        CompareOp::Gt => specialize::<op::Gt>(left, right, span),
        CompareOp::Ge => specialize::<op::Ge>(left, right, span),
        _ => Box::new(Membership {
            op,
            left,
            right,
            span,
        }),
    }
}

fn specialize<O: Ordering>(left: Operand, right: Operand, span: Span) -> BoxExpr {
    use Operand::{Const as C, Expr as E, Local as L};
    match (left.without_cells(), right.without_cells()) {
        (L(left), L(right)) => PeekPeek::<O, _, _>::boxed(left, right, span),
        (L(left), C(right)) => PeekPeek::<O, _, _>::boxed(left, Const(right), span),
        (E(left), L(right)) => ExprPeek::<O, _>::boxed(left, right, span),
        (E(left), C(right)) => ExprPeek::<O, _>::boxed(left, Const(right), span),
        (left, right) => ExprExpr::<O>::boxed(left.into_expr(), right.into_expr(), span),
    }
}
