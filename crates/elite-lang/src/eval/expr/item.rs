//! `value[index]` and slices.

use std::rc::Rc;

use elite_syntax::Span;

use super::attribute::Attribute;
use super::names::Readable;
use super::operand::Operand;
use crate::eval::words::PairOf;
use crate::eval::{BoxExpr, Evaluator, ExprNode, Frame, TraceExt};
use crate::ops::item::place_of;
use crate::value::{R, Slice, Value};

/// `value[index]`
pub struct Item {
    /// The container.
    pub value: Operand,
    /// The index.
    pub index: Operand,
    /// The place in the text.
    pub span: Span,
}

impl ExprNode for Item {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        if let Operand::Local(local) = &self.value
            && let Some(index) = self.index.peek(f)
        {
            return match load_fast(local.peek(f), index, ev) {
                Some(item) => Ok(item),
                None => self.evaluate(ev, f).whole(),
            };
        }
        match &self.value {
            Operand::Attribute(attribute) => self.find_in_attribute(attribute, ev, f).whole(),
            _ => self.find(ev, f).whole(),
        }
    }
}

/// The item, if it is found without running script code.
#[inline(always)]
fn load_fast(value: &Value, index: &Value, ev: &Evaluator<'_>) -> Option<Value> {
    match index {
        Value::Int(at) => match value {
            Value::List(list) => list.at(*at),
            Value::Tuple(tuple) => tuple.at(*at),
            _ => ev.item_at_once(value, index).whole(),
        },
        _ => ev.item_at_once(value, index).whole(),
    }
}

impl Item {
    /// Where the item lies, if container and index are found without evaluating anything and it lies in a list or
    /// tuple.
    ///
    /// # Safety
    /// The caller promises what `ScriptCell::get_unguarded` asks.
    #[inline(never)]
    #[allow(unsafe_code)]
    pub unsafe fn reach<'v>(&'v self, f: &'v Frame<'_>) -> Option<&'v Value> {
        // SAFETY: the caller's promise.
        unsafe {
            let Value::Int(at) = self.index.value_ref(f)? else {
                return None;
            };
            let items = match self.value.value_ref(f)? {
                Value::List(list) => list.glimpse(),
                Value::Tuple(tuple) => tuple.items(),
                _ => return None,
            };
            items.get(place_of(*at, items.len())?)
        }
    }

    /// Shows `each` the item, if container and index can be looked at and it lies in a list or tuple.
    #[inline(never)]
    pub fn show(&self, f: &Frame<'_>, each: &mut dyn FnMut(&Value)) {
        let Some(Some(at)) = self.index.with_value(f, |index| match index {
            Value::Int(at) => Some(*at),
            _ => None,
        }) else {
            return;
        };
        self.value.with_value(f, |value| match value {
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

    /// The item, if the container is an attribute: of a list or tuple without a call.
    #[inline(never)]
    fn find_in_attribute(
        &self,
        attribute: &Attribute,
        ev: &Evaluator<'_>,
        f: &mut Frame<'_>,
    ) -> PairOf<R> {
        if let Some(Value::Int(at)) = self.index.peek(f) {
            // SAFETY: the item is copied, and nothing else happens before.
            #[allow(unsafe_code)]
            let items = match unsafe { attribute.reach(f) } {
                Some(Value::List(list)) => unsafe { list.glimpse() },
                Some(Value::Tuple(tuple)) => tuple.items(),
                _ => &[],
            };
            if let Some(item) = place_of(*at, items.len()).and_then(|place| items.get(place)) {
                return PairOf::pack(Ok(item.clone()));
            }
        }
        self.find(ev, f)
    }

    /// The item, wherever container and index come from.
    #[inline(never)]
    fn find(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> PairOf<R> {
        // SAFETY: what is found is copied; to find it in a dictionary or a text changes nothing and runs no script
        // code.
        #[allow(unsafe_code)]
        let item = unsafe {
            match (self.value.value_ref(f), self.index.value_ref(f)) {
                (Some(value), Some(index)) => load_fast(value, index, ev),
                _ => None,
            }
        };
        match item {
            Some(item) => PairOf::pack(Ok(item)),
            None => self.evaluate(ev, f),
        }
    }

    /// The item, with container and index evaluated one after the other.
    #[inline(never)]
    fn evaluate(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> PairOf<R> {
        PairOf::pack(self.eval_general(ev, f))
    }

    #[inline(always)]
    fn eval_general(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let value = self.value.eval(ev, f)?;
        let own;
        let index = match self.index.bound_ref(f) {
            Some(index) => index,
            None => {
                own = self.index.eval(ev, f)?;
                &own
            }
        };
        let item = match load_fast(&value, index, ev) {
            Some(item) => item,
            None => ev.item(&value, index).trace_at(ev, f, self.span)?,
        };
        value.drop_inline();
        Ok(item)
    }
}

/// `lower:upper:step`, as an index.
#[allow(missing_docs)]
pub struct SliceExpr {
    pub lower: Option<BoxExpr>,
    pub upper: Option<BoxExpr>,
    pub step: Option<BoxExpr>,
}

impl ExprNode for SliceExpr {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let mut bound = |expr: &Option<BoxExpr>| match expr {
            Some(expr) => expr.eval(ev, f),
            None => Ok(Value::None),
        };
        let (start, stop, step) = (bound(&self.lower)?, bound(&self.upper)?, bound(&self.step)?);
        Ok(Value::Slice(Rc::new(Slice { start, stop, step })))
    }
}

/// `value[lower:upper]`
pub struct SliceAccess {
    /// What a part is taken of.
    pub value: Operand,
    /// The bounds, nothing for the beginning and the end.
    #[allow(missing_docs)]
    pub lower: Operand,
    #[allow(missing_docs)]
    pub upper: Operand,
    /// The place in the text.
    pub span: Span,
}

impl ExprNode for SliceAccess {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let value = self.value.eval(ev, f)?;
        let start = self.lower.eval(ev, f)?;
        let stop = self.upper.eval(ev, f)?;
        if let Some(part) = ev.part_at_once(&value, &start, &stop) {
            value.drop_inline();
            return Ok(part);
        }
        let step = Value::None;
        let slice = Value::Slice(Rc::new(Slice { start, stop, step }));
        ev.item(&value, &slice).trace_at(ev, f, self.span)
    }
}
