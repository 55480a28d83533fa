//! A big part of a big expression.

use crate::eval::{Evaluator, Expr, Expression, Frame};
use crate::value::trash::Nodes;
use crate::value::{R, Value};

/// An expression of very many nodes, as a list of one: so it is dropped apart from what it stands in.
pub struct Whole(pub Nodes<Expr>);

impl Expression for Whole {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        match self.0.first() {
            Some(expr) => expr.eval(ev, f),
            None => Ok(Value::None),
        }
    }

    #[inline(always)]
    fn truth(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<bool> {
        match self.0.first() {
            Some(expr) => expr.truth(ev, f),
            None => Ok(false),
        }
    }
}
