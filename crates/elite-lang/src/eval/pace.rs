//! How natives let others have their turn: script threads, a stop, the look at the memory in use.
//!
//! A loop over the values of an iterator takes them with [`Evaluator::step`]; a loop over data counts what it does with
//! [`Evaluator::worked`]. Both may run other script threads, so nothing is borrowed across them. Work is counted, never
//! measured: the same program gives way at the same places every time.

use super::Evaluator;
use super::coroutine::Stopping;
use crate::value::{R, Value};

/// Work after which a native gives way, in units of about a nanosecond of optimised code.
pub const WORK_MAX: usize = 1 << 20;
/// What a native does for one value of a container, in units of work: a copy that is counted, a comparison.
pub const VALUE: usize = 8;

impl Evaluator<'_> {
    /// The next value of an iterator, in a loop of a native.
    #[inline]
    pub fn step(&self, iterator: &Value) -> R<Option<Value>> {
        self.safepoint()?;
        self.next(iterator)
    }

    /// Counts work of a native. Nothing may be borrowed.
    #[inline]
    pub fn worked(&self, units: usize) -> R<()> {
        let done = self.core.work.get().saturating_add(units);
        if done < WORK_MAX {
            self.core.work.set(done);
            return Ok(());
        }
        self.give_way_after_work()
    }

    #[cold]
    #[inline(never)]
    fn give_way_after_work(&self) -> R<()> {
        self.core.work.set(0);
        if self.core.stopping.get() != Stopping::No {
            // What is left of a stopped thread's fuel is all it gets.
            self.core.spend_fuel();
            return self.safepoint();
        }
        self.check_memory()?;
        self.give_way()
    }
}
