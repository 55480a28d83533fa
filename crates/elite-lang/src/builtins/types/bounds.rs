//! The optional bounds of a search in a text or in bytes.

use crate::eval::Evaluator;
use crate::value::{R, Value};

/// The bounds as they are given.
pub struct SearchBounds {
    start: i64,
    end: i64,
}

impl SearchBounds {
    /// Reads both, once. Their `__index__` may change what is searched, so this comes before its length is known.
    pub fn read(ev: &Evaluator<'_>, start: &Value, end: &Value) -> R<Self> {
        let bound = |value: &Value, missing: i64| match value.if_given() {
            Some(value) if !value.is_none() => ev.slice_index(value),
            _ => Ok(missing),
        };
        Ok(SearchBounds {
            start: bound(start, 0)?,
            end: bound(end, i64::MAX)?,
        })
    }

    /// The places they mean in something of this length; None if they cross.
    pub fn resolve(&self, length: usize) -> Option<(usize, usize)> {
        let place = |bound: i64| {
            let from_end = if bound < 0 { length as i64 } else { 0 };
            usize::try_from(bound.saturating_add(from_end)).unwrap_or(0)
        };
        let (from, to) = (place(self.start), place(self.end).min(length));
        (from <= to).then_some((from, to))
    }
}
