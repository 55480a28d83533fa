//! Slices: their bounds within a sequence, and the parts they pick.

use std::rc::Rc;

use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::value::{Bytes, LongRange, R, Range, Slice, Str, Value};

/// A slice with the length of its sequence worked in (Python's `slice.indices`).
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// First index.
    pub start: i64,
    /// End, exclusive in the direction of `step`.
    pub stop: i64,
    /// Never 0.
    pub step: i64,
}

impl Bounds {
    /// Number of indices.
    pub fn len(&self) -> usize {
        Range {
            start: self.start,
            stop: self.stop,
            step: self.step,
        }
        .len() as usize
    }

    /// The same places as far as there are still `length` of them, for a step of 1.
    pub fn clamped(self, length: usize) -> Bounds {
        let start = self.start.min(length as i64);
        Bounds {
            start,
            stop: self.stop.clamp(start, length as i64),
            step: 1,
        }
    }

    /// The indices.
    pub fn indices(self) -> impl Iterator<Item = usize> {
        (0..self.len() as i64).map(move |i| (self.start + i * self.step) as usize)
    }
}

/// A slice whose parts are integers: what its objects answered before the length of any sequence was looked at.
#[derive(Clone, Copy, Debug)]
pub struct Indices {
    start: Option<i64>,
    stop: Option<i64>,
    /// Never 0.
    step: i64,
}

impl Indices {
    /// The bounds within a sequence of `length` items.
    pub fn within(self, length: usize) -> Bounds {
        let length = length as i64;
        let step = self.step;
        let (lowest, highest) = if step > 0 {
            (0, length)
        } else {
            (-1, length - 1)
        };
        let bound = |index: Option<i64>, default: i64| match index {
            None => default,
            Some(index) if index < 0 => index.saturating_add(length).clamp(lowest, highest),
            Some(index) => index.clamp(lowest, highest),
        };
        let (first, last) = if step > 0 {
            (lowest, highest)
        } else {
            (highest, lowest)
        };
        Bounds {
            start: bound(self.start, first),
            stop: bound(self.stop, last),
            step,
        }
    }
}

impl Evaluator<'_> {
    /// The bounds of a slice of a sequence of `length` items, which is read when the slice's objects have answered.
    pub fn bounds(&self, slice: &Slice, length: impl FnOnce() -> usize) -> R<Bounds> {
        Ok(self.slice_indices(slice)?.within(length()))
    }

    /// What the parts of a slice are as integers. May run script code, so it comes before any length is read.
    pub fn slice_indices(&self, slice: &Slice) -> R<Indices> {
        let step = if slice.step.is_none() {
            1
        } else {
            self.slice_index(&slice.step)?
        };
        if step == 0 {
            return Err(self.value_error("slice step cannot be zero"));
        }
        let bound = |value: &Value| match value {
            Value::None => Ok(None),
            value => self.slice_index(value).map(Some),
        };
        Ok(Indices {
            step: step.max(-i64::MAX),
            start: bound(&slice.start)?,
            stop: bound(&slice.stop)?,
        })
    }

    /// Refuses what is no bound of a slice; a bound may be omitted.
    pub fn check_slice_index(&self, value: &Value) -> R<()> {
        if value.is_unbound() || value.is_none() {
            return Ok(());
        }
        self.slice_index(value).map(|_| ())
    }

    pub(super) fn slice_index(&self, value: &Value) -> R<i64> {
        self.clamped_index(value).map_err(|raised| {
            if self.is_kind(&raised, ExceptionKind::TypeError)
                && !matches!(value, Value::Instance(_))
            {
                return self.type_error(
                    "slice indices must be integers or None or have an __index__ method",
                );
            }
            raised
        })
    }

    pub(super) fn slice_of(&self, value: &Value, slice: &Slice) -> R {
        Ok(match value {
            Value::List(list) => {
                let indices = self.slice_indices(slice)?;
                let room = indices.within(list.len()).len() * size_of::<Value>();
                self.check_allocation(room)?;
                let items = list.borrow();
                let bounds = indices.within(items.len());
                Value::list(pick(&items, bounds))
            }
            Value::Tuple(tuple) => {
                let bounds = self.bounds(slice, || tuple.items().len())?;
                if bounds.step == 1 && bounds.len() == tuple.items().len() {
                    return Ok(value.clone());
                }
                self.check_allocation(bounds.len() * size_of::<Value>())?;
                Value::tuple(pick(tuple.items(), bounds))
            }
            Value::Str(text) => {
                let bounds = self.bounds(slice, || text.len())?;
                self.check_allocation(bounds.len())?;
                self.slice_text(text, bounds)
            }
            Value::Bytes(bytes) => {
                let bounds = self.bounds(slice, || bytes.data().len())?;
                self.check_allocation(bounds.len())?;
                Value::Bytes(Rc::new(Bytes::new(pick(bytes.data(), bounds))))
            }
            Value::ByteArray(bytes) => {
                let indices = self.slice_indices(slice)?;
                let data = bytes.data.borrow();
                let bounds = indices.within(data.len());
                Value::ByteArray(Rc::new(crate::value::ByteArray::new(pick(&data, bounds))))
            }
            Value::Range(range) if !matches!(slice.step, Value::BigInt(_)) => {
                let bounds = self.bounds(slice, || range.len() as usize)?;
                let at = |index: i64| {
                    i128::from(range.start) + i128::from(index) * i128::from(range.step)
                };
                let step = i128::from(range.step) * i128::from(bounds.step);
                Value::range(at(bounds.start).into(), at(bounds.stop).into(), step.into())
            }
            Value::Range(_) | Value::LongRange(_) => {
                let Some(range) = LongRange::of(value) else {
                    return Err(self.not_subscriptable(value));
                };
                let bound = |value: &Value| -> R<Option<num_bigint::BigInt>> {
                    if value.is_none() {
                        return Ok(None);
                    }
                    // For what is no index, the message slices have.
                    self.slice_index(value)?;
                    Ok(Some(self.to_int(value)?.to_big()))
                };
                let step = bound(&slice.step)?.unwrap_or(1.into());
                if step == num_bigint::BigInt::ZERO {
                    return Err(self.value_error("slice step cannot be zero"));
                }
                range.slice(bound(&slice.start)?, bound(&slice.stop)?, step)
            }
            _ => return Err(self.not_subscriptable(value)),
        })
    }

    fn slice_text(&self, text: &Rc<Str>, bounds: Bounds) -> Value {
        let length = bounds.len();
        if length == 0 {
            return self.core.empty_str.clone();
        }
        if bounds.step == 1 {
            if length == text.len() {
                return Value::Str(text.clone());
            }
            let part = text.slice(bounds.start as usize, bounds.stop as usize);
            return Value::Str(Rc::new(Str::counted(part, length)));
        }
        let picked: String = if text.is_ascii() {
            bounds
                .indices()
                .map(|index| char::from(text.as_str().as_bytes()[index]))
                .collect()
        } else {
            let first = bounds.indices().min().unwrap_or(0);
            let last = bounds.indices().max().unwrap_or(0);
            let chars: Vec<char> = text.slice(first, last + 1).chars().collect();
            bounds.indices().map(|index| chars[index - first]).collect()
        };
        Value::Str(Rc::new(Str::counted(picked, length)))
    }
}

fn pick<T: Clone>(items: &[T], bounds: Bounds) -> Vec<T> {
    if bounds.step == 1 {
        let end = bounds.stop.max(bounds.start) as usize;
        return items[bounds.start as usize..end].to_vec();
    }
    bounds.indices().map(|index| items[index].clone()).collect()
}
