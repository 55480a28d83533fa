//! Parts of nodes that are most often a local variable or a constant: those are read in place, without a further node.

use super::names::{Const, Local};
use crate::eval::{Evaluator, Expr, Expression, Frame};
use crate::value::{R, Value};

/// A part of a node, as `lower` found it.
pub enum Operand {
    /// A local variable.
    Local(Local),
    /// A constant.
    Const(Value),
    /// Anything else.
    Expr(Expr),
}

impl Operand {
    /// As an expression.
    pub fn into_expr(self) -> Expr {
        match self {
            Operand::Local(local) => Box::new(local),
            Operand::Const(value) => Box::new(Const(value)),
            Operand::Expr(expr) => expr,
        }
    }

    /// Its value.
    #[inline(always)]
    pub fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        match self {
            Operand::Local(local) => local.eval(ev, f),
            Operand::Const(value) => Ok(value.clone()),
            Operand::Expr(expr) => expr.eval(ev, f),
        }
    }
}
