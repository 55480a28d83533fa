//! A sequence lock over atomic words: one writer, any number of readers, nobody waits for the writer but who meets it.
//!
//! The writer never waits. A reader that meets a write in progress reads again. Safe code only: the value travels as
//! 64-bit atomics (Boehm, "Can seqlocks get along with programming language memory models?", 2012, for the fences). The
//! atomics are those of `crate::atomics`: the model in `tests/interleavings.rs` takes in this file with loom's in their
//! place.

use core::marker::PhantomData;

use crate::atomics::{AtomicU64, Ordering, fence, spin_loop};
use crate::words::{FixedWords, WordSink, WordSource};

/// The mechanism, for any value made of words.
pub(crate) struct SequenceLock<T> {
    /// Even: stable. Odd: a write is in progress.
    sequence: AtomicU64,
    words: Box<[AtomicU64]>,
    value: PhantomData<fn() -> T>,
}

struct AtomicWordSink<'a>(&'a [AtomicU64]);
struct AtomicWordSource<'a>(std::slice::Iter<'a, AtomicU64>);

impl WordSink for AtomicWordSink<'_> {
    #[inline]
    fn put(&mut self, word: u64) {
        if let Some((cell, rest)) = self.0.split_first() {
            cell.store(word, Ordering::Relaxed);
            self.0 = rest;
        }
    }

    #[inline]
    fn put_numbers(&mut self, numbers: &[f64]) {
        // Cut off as one: numbers that are known to be so many are then stored without looking again at each.
        let Some((cells, rest)) = self.0.split_at_checked(numbers.len()) else {
            numbers.iter().for_each(|number| self.put(number.to_bits()));
            return;
        };
        for (cell, number) in cells.iter().zip(numbers) {
            cell.store(number.to_bits(), Ordering::Relaxed);
        }
        self.0 = rest;
    }
}

impl WordSource for AtomicWordSource<'_> {
    fn take(&mut self) -> u64 {
        self.0.next().map_or(0, |cell| cell.load(Ordering::Relaxed))
    }
}

impl<T: FixedWords> SequenceLock<T> {
    /// A lock that holds `first`.
    pub(crate) fn new(first: &T) -> Self {
        let cell = Self {
            sequence: AtomicU64::new(0),
            words: (0..T::COUNT).map(|_| AtomicU64::new(0)).collect(),
            value: PhantomData,
        };
        cell.publish(first);
        cell
    }

    /// Replaces the value. Only one thread may call this; it never waits.
    pub(crate) fn publish(&self, state: &T) {
        let sequence = self.sequence.load(Ordering::Relaxed);
        self.sequence
            .store(sequence.wrapping_add(1), Ordering::Relaxed);
        fence(Ordering::Release);
        state.put(&mut AtomicWordSink(&self.words));
        self.sequence
            .store(sequence.wrapping_add(2), Ordering::Release);
    }

    /// The latest complete value.
    pub(crate) fn read(&self) -> T {
        self.read_first()
    }

    /// What the first words of the value are.
    pub(crate) fn read_first<U: FixedWords>(&self) -> U {
        loop {
            let before = self.sequence.load(Ordering::Acquire);
            if before.is_multiple_of(2) {
                let state = U::take(&mut AtomicWordSource(self.words.iter()));
                fence(Ordering::Acquire);
                if self.sequence.load(Ordering::Relaxed) == before {
                    return state;
                }
            }
            // A write takes well under a microsecond; let the writer finish.
            spin_loop();
        }
    }
}
