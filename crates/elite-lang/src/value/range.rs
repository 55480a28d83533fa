//! `range` and `slice`.

use super::Value;

/// A range of integers. Bounds beyond 64 bits are refused when it is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub struct Range {
    pub start: i64,
    pub stop: i64,
    /// Never 0.
    pub step: i64,
}

impl Range {
    /// Number of integers in the range.
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

    /// Whether it is empty.
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
        for part in [&mut self.start, &mut self.stop, &mut self.step] {
            super::trash::dismantle_one(part);
        }
    }
}
