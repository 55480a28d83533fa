//! Slices: their bounds within a sequence, and the parts they pick.

use std::rc::Rc;

use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::limits::chunked::{BULK_CHUNK, CHUNK, WORK_PER_BYTE};
use crate::limits::yielding::WORK_PER_VALUE;
use crate::value::{ByteArray, Bytes, LongRange, R, Range, Slice, Str, Value};

/// A slice with the length of its sequence worked in (Python's `slice.indices`).
#[derive(Clone, Copy, Debug)]
pub struct SliceBounds {
    /// First index.
    pub start: i64,
    /// End, exclusive in the direction of `step`.
    pub stop: i64,
    /// Never 0.
    pub step: i64,
}

impl SliceBounds {
    /// Number of indices.
    pub fn len(&self) -> usize {
        Range {
            start: self.start,
            stop: self.stop,
            step: self.step,
        }
        .len() as usize
    }

    /// The places that are still there in a sequence of `length` items, for a step of 1.
    pub fn clamp_to(self, length: usize) -> SliceBounds {
        let start = self.start.min(length as i64);
        SliceBounds {
            start,
            stop: self.stop.clamp(start, length as i64),
            step: 1,
        }
    }

    /// The index of place number `number`.
    fn at(self, number: usize) -> usize {
        self.place(number as i64) as usize
    }

    /// Place number `number`, which is one of them or next to one. A step may be as big as there are numbers: what is
    /// only next to a place may be beyond them.
    fn place(self, number: i64) -> i64 {
        self.start.saturating_add(number.saturating_mul(self.step))
    }

    /// The index of the last place; before the first one if there is none.
    pub fn last_index(self) -> i64 {
        self.place(self.len() as i64 - 1)
    }

    /// Divides the places, in order, into parts: few enough places, and near enough to each other, for one safepoint
    /// after each part.
    fn parts(self, size: usize) -> impl Iterator<Item = SliceBounds> {
        let step = usize::try_from(self.step.unsigned_abs()).unwrap_or(usize::MAX);
        let size = (size / step).max(1);
        let length = self.len();
        (0..length).step_by(size).map(move |first| SliceBounds {
            start: self.place(first as i64),
            stop: if first + size < length {
                self.place((first + size) as i64)
            } else {
                self.stop
            },
            step: self.step,
        })
    }

    /// The indices.
    pub fn indices(self) -> impl Iterator<Item = usize> {
        (0..self.len()).map(move |number| self.at(number))
    }
}

/// A slice whose parts are integers: what its objects answered before the length of any sequence was looked at.
#[derive(Clone, Copy, Debug)]
pub struct SliceArgs {
    start: Option<i64>,
    stop: Option<i64>,
    /// Never 0.
    step: i64,
}

/// Longest part that is taken at once.
const PART_MAX: usize = 64;

impl SliceArgs {
    /// The bounds within a sequence of `length` items.
    pub fn resolve(self, length: usize) -> SliceBounds {
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
        SliceBounds {
            start: bound(self.start, first),
            stop: bound(self.stop, last),
            step,
        }
    }
}

impl Evaluator<'_> {
    /// The bounds of a slice of a sequence of `length` items, which is read when the slice's objects have answered.
    pub fn bounds(&self, slice: &Slice, length: impl FnOnce() -> usize) -> R<SliceBounds> {
        Ok(self.slice_indices(slice)?.resolve(length()))
    }

    /// What the parts of a slice are as integers. May run script code, so it comes before any length is read.
    pub fn slice_indices(&self, slice: &Slice) -> R<SliceArgs> {
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
        Ok(SliceArgs {
            step: step.max(-i64::MAX),
            start: bound(&slice.start)?,
            stop: bound(&slice.stop)?,
        })
    }

    /// A bound of a slice or a search, cut to 64 bits.
    pub fn slice_index(&self, value: &Value) -> R<i64> {
        self.clamped_index(value).map_err(|raised| {
            if self.is_kind(&raised, ExceptionKind::TypeError) && !self.has_index(value) {
                return self.type_error(
                    "slice indices must be integers or None or have an __index__ method",
                );
            }
            raised
        })
    }

    /// `value[start:stop]` of a list, a tuple or a text where that runs no script code and the part is short; None
    /// otherwise.
    pub fn part_at_once(&self, value: &Value, start: &Value, stop: &Value) -> Option<Value> {
        let bound = |value: &Value| match value {
            Value::None => Some(None),
            Value::Int(bound) => Some(Some(*bound)),
            _ => None,
        };
        let indices = SliceArgs {
            start: bound(start)?,
            stop: bound(stop)?,
            step: 1,
        };
        let places = |length: usize| {
            let bounds = indices.resolve(length);
            let (start, stop) = (
                bounds.start as usize,
                bounds.stop.max(bounds.start) as usize,
            );
            (stop - start <= PART_MAX).then_some(start..stop)
        };
        match value {
            Value::List(list) => {
                let items = list.borrow();
                let part = items.get(places(items.len())?)?;
                Some(Value::list(part.to_vec()))
            }
            Value::Tuple(tuple) => {
                let items = tuple.items();
                match items.get(places(items.len())?)? {
                    part if part.len() == items.len() => Some(value.clone()),
                    part => Some(Value::tuple(part.to_vec())),
                }
            }
            Value::Str(text) if text.is_ascii() => {
                let places = places(text.len())?;
                match text.as_str().get(places)? {
                    "" => Some(self.core.empty_str.clone()),
                    part if part.len() == text.len() => Some(value.clone()),
                    part => match part.as_bytes() {
                        [byte] => self.core.ascii.get(usize::from(*byte)).cloned(),
                        _ => Some(Value::Str(Rc::new(Str::with_char_count(part, part.len())))),
                    },
                }
            }
            _ => None,
        }
    }

    pub(super) fn slice_of(&self, value: &Value, slice: &Slice) -> R {
        Ok(match value {
            Value::List(list) => {
                let indices = self.slice_indices(slice)?;
                let bounds = indices.resolve(list.len());
                Value::list(self.pick(bounds, |places, out| {
                    let items = list.borrow();
                    out.extend(places.filter_map(|place| items.get(place).cloned()));
                })?)
            }
            Value::Tuple(tuple) => {
                let bounds = self.bounds(slice, || tuple.items().len())?;
                if bounds.step == 1 && bounds.len() == tuple.items().len() {
                    return Ok(value.clone());
                }
                let items = tuple.items();
                Value::tuple(self.pick(bounds, |places, out| {
                    out.extend(places.map(|place| items[place].clone()));
                })?)
            }
            Value::Str(text) => {
                let bounds = self.bounds(slice, || text.len())?;
                self.check_allocation(bounds.len())?;
                self.index_chars(text)?;
                self.slice_text(text, bounds)?
            }
            Value::Bytes(_) | Value::ByteArray(_) => {
                let indices = self.slice_indices(slice)?;
                let data = self.bytes_like(value).unwrap_or_default();
                let bounds = indices.resolve(data.len());
                let part = match bounds.step {
                    1 => {
                        let end = bounds.stop.max(bounds.start) as usize;
                        self.copy_bytes(&data[bounds.start as usize..end])?
                    }
                    _ => self.pick(bounds, |places, out| {
                        out.extend(places.map(|place| data[place]));
                    })?,
                };
                match value {
                    Value::Bytes(_) => Value::Bytes(Rc::new(Bytes::new(part))),
                    _ => Value::ByteArray(Rc::new(ByteArray::new(part))),
                }
            }
            // The least step of all is cut like those beyond 64 bits.
            Value::Range(range)
                if !matches!(slice.step, Value::BigInt(_) | Value::Int(i64::MIN)) =>
            {
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

    fn slice_text(&self, text: &Rc<Str>, bounds: SliceBounds) -> R {
        let length = bounds.len();
        if length == 0 {
            return Ok(self.core.empty_str.clone());
        }
        if bounds.step == 1 {
            if length == text.len() {
                return Ok(Value::Str(text.clone()));
            }
            let part = text.slice(bounds.start as usize, bounds.stop as usize);
            if part.len() > BULK_CHUNK {
                let mut copy = String::new();
                self.push_text(&mut copy, part)?;
                return Ok(Value::Str(Rc::new(Str::with_char_count(copy, length))));
            }
            return Ok(Value::Str(Rc::new(Str::with_char_count(part, length))));
        }
        let mut picked = String::new();
        self.grow(&mut picked, length)?;
        let bytes = text.as_str().as_bytes();
        for places in bounds.parts(CHUNK) {
            self.grow(&mut picked, places.len())?;
            if text.is_ascii() {
                picked.extend(places.indices().map(|place| char::from(bytes[place])));
            } else {
                // The characters from the first place to the last, so that each is found from the one before.
                let (first, last) = (places.at(0), places.at(places.len() - 1));
                let whole = text.slice(first.min(last), first.max(last) + 1);
                let stride = bounds.step.unsigned_abs() as usize;
                match bounds.step > 0 {
                    true => picked.extend(whole.chars().step_by(stride)),
                    false => picked.extend(whole.chars().rev().step_by(stride)),
                }
                self.charge(whole.len() * WORK_PER_BYTE)?;
            }
            self.charge(places.len() * WORK_PER_BYTE)?;
        }
        Ok(Value::Str(Rc::new(Str::with_char_count(picked, length))))
    }

    /// What is at the places of a slice, which `take` appends for some of them at a time.
    fn pick<T>(
        &self,
        bounds: SliceBounds,
        mut take: impl FnMut(Box<dyn Iterator<Item = usize>>, &mut Vec<T>),
    ) -> R<Vec<T>> {
        let mut out = self.try_with_capacity(bounds.len())?;
        for places in bounds.parts(CHUNK) {
            match places.step {
                1 => take(
                    Box::new(places.start as usize..places.stop as usize),
                    &mut out,
                ),
                _ => take(Box::new(places.indices()), &mut out),
            }
            self.charge(places.len() * WORK_PER_VALUE)?;
        }
        Ok(out)
    }
}
