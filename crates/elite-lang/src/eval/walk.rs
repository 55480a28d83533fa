//! Walking through an iterable in a loop: the common builtin types are stepped in place, without an iterator object.

use std::rc::Rc;

use elite_syntax::Span;

use super::{Evaluator, Frame, TraceExt};
use crate::value::{List, R, Str, Tuple, Value};

/// What a loop with two targets gets each turn.
pub enum LoopItem {
    /// Both values: no tuple has been made.
    Two(Value, Value),
    /// Something to unpack.
    One(Value),
}

/// A loop's place in what it walks through.
pub enum LoopCursor {
    /// A range: the next integer, the step, how many are left.
    Range(i64, i64, u64),
    /// A list, which may change meanwhile, and the next index.
    List(Rc<List>, usize),
    /// A tuple and the next index.
    Tuple(Rc<Tuple>, usize),
    /// A text of ASCII and the next index.
    Text(Rc<Str>, usize),
    /// An iterator.
    Iterator(Value),
}

impl LoopCursor {
    /// Runs `each` on what it refers to.
    pub fn visit(&self, each: &mut dyn FnMut(&Value)) {
        match self {
            LoopCursor::Range(..) | LoopCursor::Text(..) => {}
            LoopCursor::List(list, _) => each(&Value::List(list.clone())),
            LoopCursor::Tuple(tuple, _) => each(&Value::Tuple(tuple.clone())),
            LoopCursor::Iterator(iterator) => each(iterator),
        }
    }

    /// Begins to walk through `iterable`, which is written at `span`.
    #[inline]
    pub fn over(iterable: Value, ev: &Evaluator<'_>, f: &Frame<'_>, span: Span) -> R<LoopCursor> {
        Ok(match iterable {
            Value::Range(range) => LoopCursor::Range(range.start, range.step, range.len()),
            Value::List(list) => LoopCursor::List(list, 0),
            Value::Tuple(tuple) => LoopCursor::Tuple(tuple, 0),
            Value::Str(text) if text.is_ascii() => LoopCursor::Text(text, 0),
            iterator @ (Value::Iter(_) | Value::Generator(_)) => LoopCursor::Iterator(iterator),
            other => LoopCursor::Iterator(ev.iter(&other).trace_at(ev, f, span)?),
        })
    }

    /// The next item; None at the end.
    #[inline(always)]
    pub fn next(&mut self, ev: &Evaluator<'_>, f: &Frame<'_>, span: Span) -> R<Option<Value>> {
        match self {
            LoopCursor::Range(next, step, left) => {
                if *left == 0 {
                    return Ok(None);
                }
                *left -= 1;
                let value = *next;
                *next = value.wrapping_add(*step);
                Ok(Some(Value::Int(value)))
            }
            LoopCursor::List(list, index) => {
                *index += 1;
                Ok(list.get(*index - 1))
            }
            LoopCursor::Tuple(tuple, index) => {
                *index += 1;
                Ok(tuple.items().get(*index - 1).cloned())
            }
            LoopCursor::Text(text, index) => {
                let byte = text.as_str().as_bytes().get(*index);
                *index += 1;
                Ok(byte.and_then(|byte| ev.core.ascii.get(usize::from(*byte)).cloned()))
            }
            LoopCursor::Iterator(iterator) => ev.next(iterator).trace_at(ev, f, span),
        }
    }

    /// The next item for a loop with two targets; None at the end.
    #[inline]
    pub fn next_pair(
        &mut self,
        ev: &Evaluator<'_>,
        f: &Frame<'_>,
        span: Span,
    ) -> R<Option<LoopItem>> {
        if let LoopCursor::Iterator(Value::Iter(iter)) = self
            && let Some(pair) = ev.next_pair(iter).trace_at(ev, f, span)?
        {
            return Ok(pair.map(|(first, second)| LoopItem::Two(first, second)));
        }
        Ok(self.next(ev, f, span)?.map(LoopItem::One))
    }
}
