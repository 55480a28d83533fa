//! `value[index]` and slices.

use std::rc::Rc;

use super::names::Peek;
use super::operand::Operand;
use crate::eval::{Evaluator, Expr, Expression, Frame, Located};
use crate::ops::item::place_of;
use crate::source::Span;
use crate::value::{R, Slice, Value};

/// `value[index]`
pub struct Item {
    /// The container.
    pub value: Operand,
    /// The index.
    pub index: Operand,
    /// Evaluating the index leaves local variables as they are.
    pub keeps: bool,
    /// Where it is written.
    pub span: Span,
}

impl Expression for Item {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let found = match self.index.peek(f) {
            Some(index) => self.value.look(f, |value| ev.item_at_once(value, index)),
            None => self.index.look(f, |index| {
                let value = |value: &Value| ev.item_at_once(value, index);
                self.value.look(f, value).flatten()
            }),
        };
        match found {
            Some(Some(item)) => Ok(item),
            _ => self.find(ev, f),
        }
    }
}

impl Item {
    /// Shows `each` the item, if container and index can be looked at and it lies in a list or tuple.
    #[inline(never)]
    pub fn show(&self, f: &Frame<'_>, each: &mut dyn FnMut(&Value)) {
        let Some(Some(at)) = self.index.look(f, |index| match index {
            Value::Int(at) => Some(*at),
            _ => None,
        }) else {
            return;
        };
        self.value.look(f, |value| match value {
            Value::List(list) => {
                let items = list.borrow();
                if let Some(item) = place_of(at, items.len()).and_then(|place| items.get(place)) {
                    each(item);
                }
            }
            Value::Tuple(tuple) => {
                let items = tuple.items();
                if let Some(item) = place_of(at, items.len()).and_then(|place| items.get(place)) {
                    each(item);
                }
            }
            _ => {}
        });
    }

    /// The item, wherever container and index come from.
    #[inline(never)]
    fn find(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let span = self.span;
        if let (Operand::Local(local), true) = (&self.value, self.keeps) {
            local.check(ev, f)?;
            let index = self.index.eval(ev, f)?;
            return ev.item(local.peek(f), &index).at(ev, f, span);
        }
        let value = self.value.eval(ev, f)?;
        if let Some(index) = self.index.bound(f) {
            return ev.item(&value, index).at(ev, f, span);
        }
        let index = self.index.eval(ev, f)?;
        ev.item(&value, &index).at(ev, f, span)
    }
}

/// `lower:upper:step`, as an index.
#[allow(missing_docs)]
pub struct SliceExpr {
    pub lower: Option<Expr>,
    pub upper: Option<Expr>,
    pub step: Option<Expr>,
}

impl Expression for SliceExpr {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let mut bound = |expr: &Option<Expr>| match expr {
            Some(expr) => expr.eval(ev, f),
            None => Ok(Value::None),
        };
        let (start, stop, step) = (bound(&self.lower)?, bound(&self.upper)?, bound(&self.step)?);
        Ok(Value::Slice(Rc::new(Slice { start, stop, step })))
    }
}
