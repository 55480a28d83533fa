//! `and`, `or`, `not`, and the conditional expression.

use super::operand::Operand;
use crate::eval::{Evaluator, ExprNode, Frame};
use crate::limits::deferred_drop::NodeList;
use crate::value::{R, Value};

/// `a and b and c`
pub struct And(pub NodeList<Operand>);

impl ExprNode for And {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let Some((last, before)) = self.0.split_last() else {
            return Ok(Value::Bool(true));
        };
        for operand in before {
            let value = operand.eval(ev, f)?;
            if !ev.truth(&value)? {
                return Ok(value);
            }
        }
        last.eval(ev, f)
    }

    #[inline(always)]
    fn truth(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<bool> {
        for operand in &self.0 {
            if !operand.truth(ev, f)? {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

/// `a or b or c`
pub struct Or(pub NodeList<Operand>);

impl ExprNode for Or {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let Some((last, before)) = self.0.split_last() else {
            return Ok(Value::Bool(false));
        };
        for operand in before {
            let value = operand.eval(ev, f)?;
            if ev.truth(&value)? {
                return Ok(value);
            }
        }
        last.eval(ev, f)
    }

    #[inline(always)]
    fn truth(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<bool> {
        for operand in &self.0 {
            if operand.truth(ev, f)? {
                return Ok(true);
            }
        }
        Ok(false)
    }
}

/// `not a`
pub struct Not(pub Operand);

impl ExprNode for Not {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        self.truth(ev, f).map(Value::Bool)
    }

    #[inline(always)]
    fn truth(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<bool> {
        self.0.truth(ev, f).map(|flag| !flag)
    }
}

/// `body if test else orelse`
#[allow(missing_docs)]
pub struct IfElse {
    pub test: Operand,
    pub body: Operand,
    pub orelse: Operand,
}

impl ExprNode for IfElse {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        if self.test.truth(ev, f)? {
            self.body.eval(ev, f)
        } else {
            self.orelse.eval(ev, f)
        }
    }

    #[inline(always)]
    fn truth(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<bool> {
        if self.test.truth(ev, f)? {
            self.body.truth(ev, f)
        } else {
            self.orelse.truth(ev, f)
        }
    }
}
