//! `range` and `slice`.

use std::rc::Rc;

use num_bigint::{BigInt, Sign};

use super::Value;
use super::int::{Int, big_floor_divmod};

/// A range whose bounds, step and length fit `i64`; what does not is a `LongRange`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub struct Range {
    pub start: i64,
    pub stop: i64,
    /// Never 0.
    pub step: i64,
}

impl Range {
    /// The range, unless its length does not fit; `step` is not 0.
    pub fn new(start: i64, stop: i64, step: i64) -> Option<Range> {
        let range = Range { start, stop, step };
        i64::try_from(range.len()).is_ok().then_some(range)
    }

    /// Number of integers in the range; fits `i64` (`Range::new` sees to it).
    pub fn len(&self) -> u64 {
        let (start, stop, step) = (
            i128::from(self.start),
            i128::from(self.stop),
            i128::from(self.step),
        );
        let span = if step > 0 { stop - start } else { start - stop };
        let step = step.abs();
        if span <= 0 {
            0
        } else {
            ((span + step - 1) / step) as u64
        }
    }

    /// Whether the range is empty.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Integer number `index`, which must be less than `len`.
    pub fn at(&self, index: u64) -> i64 {
        (i128::from(self.start) + i128::from(index) * i128::from(self.step)) as i64
    }

    /// Position of `value`, if it is in the range.
    pub fn position(&self, value: i64) -> Option<u64> {
        let offset = i128::from(value) - i128::from(self.start);
        let step = i128::from(self.step);
        let index = offset / step;
        let inside = offset % step == 0 && index >= 0 && index < i128::from(self.len());
        inside.then_some(index as u64)
    }
}

/// A range that does not fit a `Range`: a bound, the step or the length is beyond 64 bits.
#[derive(Clone, Debug)]
#[allow(missing_docs)]
pub struct LongRange {
    pub start: BigInt,
    pub stop: BigInt,
    /// Never 0.
    pub step: BigInt,
    len: BigInt,
}

impl LongRange {
    fn new(start: BigInt, stop: BigInt, step: BigInt) -> Self {
        let (span, pace) = match step.sign() {
            Sign::Minus => (&start - &stop, -&step),
            _ => (&stop - &start, step.clone()),
        };
        let len = match span.sign() {
            Sign::Plus => (span - 1) / pace + 1,
            _ => BigInt::ZERO,
        };
        LongRange {
            start,
            stop,
            step,
            len,
        }
    }

    /// A range of any size as a long one, for what both kinds have in common.
    pub fn of(value: &Value) -> Option<LongRange> {
        match value {
            Value::Range(range) => Some(LongRange::new(
                range.start.into(),
                range.stop.into(),
                range.step.into(),
            )),
            Value::LongRange(range) => Some((**range).clone()),
            _ => None,
        }
    }

    /// Number of integers in the range.
    pub fn len(&self) -> &BigInt {
        &self.len
    }

    /// Whether the range is empty.
    pub fn is_empty(&self) -> bool {
        self.len.sign() == Sign::NoSign
    }

    /// Integer number `index`, counted from the end if it is negative; None beyond either end.
    pub fn at(&self, index: &BigInt) -> Option<BigInt> {
        let index = match index.sign() {
            Sign::Minus => index + &self.len,
            _ => index.clone(),
        };
        let inside = index.sign() != Sign::Minus && index < self.len;
        inside.then(|| &self.start + index * &self.step)
    }

    /// Position of `value`, if it is in the range.
    pub fn position(&self, value: &BigInt) -> Option<BigInt> {
        let (index, rest) = big_floor_divmod(&(value - &self.start), &self.step);
        let inside = rest.sign() == Sign::NoSign && index.sign() != Sign::Minus && index < self.len;
        inside.then_some(index)
    }

    /// The integers in the opposite order.
    pub fn to_reversed(&self) -> LongRange {
        let last = &self.start + (&self.len - 1) * &self.step;
        LongRange {
            start: last,
            stop: &self.start - &self.step,
            step: -&self.step,
            len: self.len.clone(),
        }
    }

    /// The part a slice with these bounds takes; `step` is not 0.
    pub fn slice(&self, start: Option<BigInt>, stop: Option<BigInt>, step: BigInt) -> Value {
        let backwards = step.sign() == Sign::Minus;
        let (lowest, highest) = if backwards {
            (BigInt::from(-1), &self.len - 1)
        } else {
            (BigInt::ZERO, self.len.clone())
        };
        let (first, last) = if backwards {
            (highest.clone(), lowest.clone())
        } else {
            (lowest.clone(), highest.clone())
        };
        let place = |index: BigInt| {
            let index = match index.sign() {
                Sign::Minus => index + &self.len,
                _ => index,
            };
            index.clamp(lowest.clone(), highest.clone())
        };
        let start = start.map_or(first, &place);
        let stop = stop.map_or(last, &place);
        Value::range(
            &self.start + start * &self.step,
            &self.start + stop * &self.step,
            &self.step * step,
        )
    }
}

/// Ranges are equal if they hold the same integers in the same order.
impl PartialEq for LongRange {
    fn eq(&self, other: &Self) -> bool {
        let one = BigInt::from(1);
        self.len == other.len
            && (self.is_empty()
                || self.start == other.start && (self.len == one || self.step == other.step))
    }
}

impl Value {
    /// `range(start, stop, step)`; the step is not 0.
    pub fn range(start: BigInt, stop: BigInt, step: BigInt) -> Value {
        if let (Ok(start), Ok(stop), Ok(step)) = (
            i64::try_from(&start),
            i64::try_from(&stop),
            i64::try_from(&step),
        ) && let Some(range) = Range::new(start, stop, step)
        {
            return Value::Range(Rc::new(range));
        }
        Value::LongRange(Rc::new(LongRange::new(start, stop, step)))
    }

    /// The integer a value is as a big one (booleans count).
    pub fn as_big(&self) -> Option<BigInt> {
        Int::of(self).map(|int| int.to_big())
    }
}

/// `start:stop:step`, each any value or None.
#[derive(Clone)]
#[allow(missing_docs)]
pub struct Slice {
    pub start: Value,
    pub stop: Value,
    pub step: Value,
}

impl Drop for Slice {
    fn drop(&mut self) {
        crate::limits::deferred_drop::drop_each([&mut self.start, &mut self.stop, &mut self.step]);
    }
}
