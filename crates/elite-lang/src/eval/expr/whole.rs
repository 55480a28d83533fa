//! A big part of a big expression.

use crate::eval::{BoxExpr, Evaluator, ExprNode, Frame};
use crate::limits::deferred_drop::NodeList;
use crate::value::{R, Value};

/// An expression of very many nodes, as a list of one: so it is dropped apart from what it stands in.
pub struct IsolatedExpr(pub NodeList<BoxExpr>);

impl ExprNode for IsolatedExpr {
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
