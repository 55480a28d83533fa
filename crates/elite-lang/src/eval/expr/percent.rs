//! `"…" % (a, b)`: a constant format with a tuple written out, which is not made.

use std::rc::Rc;

use elite_syntax::Span;

use super::operand::Operand;
use crate::eval::run::with_slots;
use crate::eval::{Evaluator, ExprNode, Frame, TraceExt};
use crate::limits::deferred_drop::NodeList;
use crate::value::{R, Str};

/// `format % (a, b)`
pub struct PercentFormat {
    /// The format.
    pub format: Rc<Str>,
    /// The items of the tuple.
    pub items: NodeList<Operand>,
    /// The place in the text.
    pub span: Span,
}

impl ExprNode for PercentFormat {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        with_slots(self.items.len(), |slots| {
            for (slot, item) in slots.iter_mut().zip(&self.items) {
                slot.put(item.eval(ev, f)?);
            }
            let text = ev.percent_format_items(self.format.as_str(), slots);
            text.and_then(|text| ev.new_str(text))
                .trace_at(ev, f, self.span)
        })
    }
}
