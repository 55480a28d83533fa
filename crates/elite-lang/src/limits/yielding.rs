//! How natives let others have their turn: script threads, a stop, the look at the memory in use.
//!
//! A loop over the values of an iterator takes them with [`Evaluator::next_at_safepoint`]; a loop over data counts what
//! it does with [`Evaluator::charge`]. Both may run other script threads, so nothing is borrowed across them. Work is
//! counted, never measured: the same program gives way at the same places every time.

use crate::eval::Evaluator;
use crate::eval::coroutine::StopState;
use crate::value::{List, R, Value, ValueVec};

/// Work after which a native gives way, in units of about a nanosecond of optimised code on data that is at hand. On
/// data that is not (tables of many megabytes, pages that are touched for the first time) the same takes up to ten
/// times as long, which is within the 5 ms that others wait at most. Without optimisation all of it is some sixteen
/// times slower.
pub const YIELD_BUDGET: usize = if cfg!(debug_assertions) {
    1 << 16
} else {
    1 << 18
};
/// What a native does for one value of a container, in units of work: a copy that is counted, a comparison.
pub const WORK_PER_VALUE: usize = 8;
/// What the host does with a text for people, and for each byte of it.
const WORK_PER_OUTPUT: usize = 4096;
const WORK_PER_OUTPUT_BYTE: usize = 16;
/// Values that are copied at once.
const COPY_CHUNK: usize = YIELD_BUDGET / WORK_PER_VALUE / 4;

impl Evaluator<'_> {
    /// The next value of an iterator, in a loop of a native.
    #[inline]
    pub fn next_at_safepoint(&self, iterator: &Value) -> R<Option<Value>> {
        self.safepoint()?;
        self.next(iterator)
    }

    /// Counts work of a native. Nothing may be borrowed.
    #[inline]
    pub fn charge(&self, units: usize) -> R<()> {
        let done = self.core.work_since_yield.get().saturating_add(units);
        if done < YIELD_BUDGET {
            self.core.work_since_yield.set(done);
            return Ok(());
        }
        self.yield_after_budget()
    }

    /// Counts the host's work with a text for people of so many bytes. Nothing may be borrowed.
    pub fn charge_output(&self, bytes: usize) -> R<()> {
        self.charge(
            bytes
                .saturating_mul(WORK_PER_OUTPUT_BYTE)
                .saturating_add(WORK_PER_OUTPUT),
        )
    }

    #[cold]
    #[inline(never)]
    fn yield_after_budget(&self) -> R<()> {
        self.core.work_since_yield.set(0);
        if self.core.stopping.get() != StopState::No {
            // What is left of a stopped thread's fuel is all it gets.
            self.core.deduct_fuel_slice();
            return self.safepoint();
        }
        // Who gives way has new fuel when it goes on, so that this may be the only place where anybody looks.
        self.run_safepoint_duties()?;
        self.yield_now()
    }

    /// Appends the items of a list, some at a time.
    pub fn copy_list(&self, list: &List, out: &mut ValueVec) -> R<()> {
        let mut at: usize = 0;
        loop {
            let end = {
                let items = list.borrow();
                let end = items.len().min(at.saturating_add(COPY_CHUNK));
                out.extend_from_slice(items.get(at..end).unwrap_or_default());
                end
            };
            if end <= at {
                return Ok(());
            }
            self.charge((end - at) * WORK_PER_VALUE)?;
            at = end;
        }
    }

    /// Appends values, some at a time.
    pub fn copy_values(&self, items: &[Value], out: &mut ValueVec) -> R<()> {
        for some in items.chunks(COPY_CHUNK) {
            out.extend_from_slice(some);
            self.charge(some.len() * WORK_PER_VALUE)?;
        }
        Ok(())
    }

    /// The values of a slice, which is left without them.
    pub fn take_all(&self, items: &mut [Value]) -> R<Vec<Value>> {
        if items.len() <= COPY_CHUNK {
            return Ok(items.iter_mut().map(std::mem::take).collect());
        }
        let mut out = ValueVec::from(self.try_with_capacity(items.len())?);
        self.take_values(items, &mut out)?;
        Ok(out.into())
    }

    /// Appends the values of another vector.
    pub fn append_values(&self, more: ValueVec, out: &mut Vec<Value>) -> R<()> {
        self.grow(out, more.len())?;
        for value in more {
            out.push(value);
            self.charge(WORK_PER_VALUE)?;
        }
        Ok(())
    }

    /// Appends values that are taken out of their places, some at a time.
    pub fn take_values(&self, values: &mut [Value], out: &mut ValueVec) -> R<()> {
        for some in values.chunks_mut(COPY_CHUNK) {
            out.extend(some.iter_mut().map(std::mem::take));
            self.charge(some.len() * WORK_PER_VALUE)?;
        }
        Ok(())
    }

    /// Turns values around that nobody else sees.
    pub fn reverse(&self, values: &mut [Value]) -> R<()> {
        let length = values.len();
        let (mut front, middle) = (0, length / 2);
        while front < middle {
            let count = COPY_CHUNK.min(middle - front);
            let (first, last) = values.split_at_mut(middle);
            let back = last.len() - front;
            for (a, b) in first[front..front + count]
                .iter_mut()
                .zip(last[..back].iter_mut().rev())
            {
                std::mem::swap(a, b);
            }
            self.charge(2 * count * WORK_PER_VALUE)?;
            front += count;
        }
        Ok(())
    }

    /// The values of a sequence, `count` times over.
    pub fn repeat_values(&self, items: ValueVec, count: usize) -> R<ValueVec> {
        if count == 0 || items.is_empty() {
            return Ok(ValueVec::default());
        }
        let whole = items.len().saturating_mul(count);
        let mut out = ValueVec::from(Vec::with_capacity(whole));
        self.copy_values(&items, &mut out)?;
        while out.len() < whole {
            // The values from here on stand at the same place of the first round, and some rounds more may follow it.
            let from = out.len() % items.len();
            let more = COPY_CHUNK.min(out.len() - from).min(whole - out.len());
            out.extend_from_within(from..from + more);
            self.charge(more * WORK_PER_VALUE)?;
        }
        Ok(out)
    }
}
