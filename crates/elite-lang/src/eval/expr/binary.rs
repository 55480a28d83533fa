//! Arithmetic nodes, by operator and by what their operands are.

use std::marker::PhantomData;

use elite_syntax::Span;
use elite_syntax::ast::{BinaryOp, UnaryOp};

use super::names::{Const, Readable};
use super::operand::{Operand, two_operands};
use crate::eval::{BoxExpr, Evaluator, ExprNode, Frame, TraceExt};
use crate::ops::arith::fast;
use crate::value::R;

/// An operator as a type.
pub trait Operator: 'static {
    /// The operator that the type stands for.
    const OP: BinaryOp;
}

macro_rules! declare {
    ($($name:ident),*) => {
        /// The operators as types.
        #[allow(missing_docs)]
        pub mod op {
            $(pub struct $name;
            impl super::Operator for $name {
                const OP: super::BinaryOp = super::BinaryOp::$name;
            })*
        }
    };
}
declare!(
    Add, Sub, Mul, Div, FloorDiv, Mod, Pow, MatMul, BitAnd, BitOr, BitXor, Shl, Shr
);

two_operands!(
    /// Both operands can be looked at.
    PeekPeek<O, A, B> { left: A, right: B }
);

impl<O: Operator, A: Readable, B: Readable> ExprNode for PeekPeek<O, A, B> {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let (a, b) = (self.left.peek(f), self.right.peek(f));
        if let Some(value) = fast(O::OP, a, b) {
            return Ok(value);
        }
        self.left.check(ev, f)?;
        self.right.check(ev, f)?;
        ev.binary(O::OP, a, b).trace_at(ev, f, self.span)
    }
}

two_operands!(
    /// The right operand can be looked at.
    ExprPeek<O, B> { left: BoxExpr, right: B }
);

impl<O: Operator, B: Readable> ExprNode for ExprPeek<O, B> {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let a = self.left.eval(ev, f)?;
        let b = self.right.peek(f);
        if let Some(value) = fast(O::OP, &a, b) {
            return Ok(value);
        }
        self.right.check(ev, f)?;
        ev.binary(O::OP, &a, b).trace_at(ev, f, self.span)
    }
}

two_operands!(
    /// The left operand can be looked at; its value is taken before the right one is evaluated.
    PeekExpr<O, A> { left: A, right: BoxExpr }
);

impl<O: Operator, A: Readable> ExprNode for PeekExpr<O, A> {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        self.left.check(ev, f)?;
        let a = self.left.peek(f).clone();
        let b = self.right.eval(ev, f)?;
        if let Some(value) = fast(O::OP, &a, &b) {
            return Ok(value);
        }
        ev.binary(O::OP, &a, &b).trace_at(ev, f, self.span)
    }
}

two_operands!(
    /// Both operands are expressions.
    ExprExpr<O> { left: BoxExpr, right: BoxExpr }
);

impl<O: Operator> ExprNode for ExprExpr<O> {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let a = self.left.eval(ev, f)?;
        let b = self.right.eval(ev, f)?;
        if let Some(value) = fast(O::OP, &a, &b) {
            return Ok(value);
        }
        ev.binary(O::OP, &a, &b).trace_at(ev, f, self.span)
    }
}

/// The node for `left op right`.
pub fn binary(op: BinaryOp, left: Operand, right: Operand, span: Span) -> BoxExpr {
    match op {
        BinaryOp::Add => specialize::<op::Add>(left, right, span),
        BinaryOp::Sub => specialize::<op::Sub>(left, right, span),
        BinaryOp::Mul => specialize::<op::Mul>(left, right, span),
        BinaryOp::Div => specialize::<op::Div>(left, right, span),
        BinaryOp::FloorDiv => specialize::<op::FloorDiv>(left, right, span),
        BinaryOp::Mod => specialize::<op::Mod>(left, right, span),
        BinaryOp::BitAnd => specialize::<op::BitAnd>(left, right, span),
        BinaryOp::BitOr => specialize::<op::BitOr>(left, right, span),
        BinaryOp::BitXor => specialize::<op::BitXor>(left, right, span),
        BinaryOp::Shl => specialize::<op::Shl>(left, right, span),
        BinaryOp::Shr => specialize::<op::Shr>(left, right, span),
        BinaryOp::Pow => general::<op::Pow>(left, right, span),
        BinaryOp::MatMul => general::<op::MatMul>(left, right, span),
    }
}

fn general<O: Operator>(left: Operand, right: Operand, span: Span) -> BoxExpr {
    ExprExpr::<O>::boxed(left.into_expr(), right.into_expr(), span)
}

fn specialize<O: Operator>(left: Operand, right: Operand, span: Span) -> BoxExpr {
    use Operand::{Const as C, Expr as E, Local as L};
    match (left.without_cells(), right.without_cells()) {
        (L(left), L(right)) => PeekPeek::<O, _, _>::boxed(left, right, span),
        (L(left), C(right)) => PeekPeek::<O, _, _>::boxed(left, Const(right), span),
        (C(left), L(right)) => PeekPeek::<O, _, _>::boxed(Const(left), right, span),
        (E(left), L(right)) => ExprPeek::<O, _>::boxed(left, right, span),
        (E(left), C(right)) => ExprPeek::<O, _>::boxed(left, Const(right), span),
        (L(left), E(right)) => PeekExpr::<O, _>::boxed(left, right, span),
        (C(left), E(right)) => PeekExpr::<O, _>::boxed(Const(left), right, span),
        (left, right) => general::<O>(left, right, span),
    }
}

/// `-x`, `+x`, `~x`
pub struct Unary {
    /// The operator.
    pub op: UnaryOp,
    /// The operand.
    pub operand: BoxExpr,
    /// The place in the text.
    pub span: Span,
}

impl ExprNode for Unary {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let value = self.operand.eval(ev, f)?;
        ev.unary(self.op, &value).trace_at(ev, f, self.span)
    }
}
