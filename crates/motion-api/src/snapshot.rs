//! The latest state, for any number of readers on any thread, without a lock: a sequence lock over atomic words.
//!
//! The writer (one thread: the motion thread) never waits. A reader that meets a write in progress reads again. Safe
//! code only: the value travels as 64-bit atomics (Boehm, "Can seqlocks get along with programming language memory
//! models?", 2012, for the fences).

#[cfg(elite_loom)]
use loom::sync::atomic::{AtomicU64, Ordering, fence};
#[cfg(not(elite_loom))]
use std::sync::atomic::{AtomicU64, Ordering, fence};

use crate::state::RobotState;
use crate::words::{Sink, Source, Words};

/// Holds the latest [`RobotState`]. One writer, any number of readers.
pub struct SnapshotCell {
    /// Even: stable. Odd: a write is in progress.
    sequence: AtomicU64,
    words: Box<[AtomicU64]>,
}

struct Storing<'a>(std::slice::Iter<'a, AtomicU64>);
struct Loading<'a>(std::slice::Iter<'a, AtomicU64>);

impl Sink for Storing<'_> {
    fn put(&mut self, word: u64) {
        if let Some(cell) = self.0.next() {
            cell.store(word, Ordering::Relaxed);
        }
    }
}

impl Source for Loading<'_> {
    fn take(&mut self) -> u64 {
        self.0.next().map_or(0, |cell| cell.load(Ordering::Relaxed))
    }
}

impl SnapshotCell {
    /// A cell that holds `first`.
    pub fn new(first: &RobotState) -> Self {
        let cell = Self {
            sequence: AtomicU64::new(0),
            words: (0..RobotState::COUNT).map(|_| AtomicU64::new(0)).collect(),
        };
        cell.publish(first);
        cell
    }

    /// Replaces the value. Only one thread may call this; it never waits.
    pub fn publish(&self, state: &RobotState) {
        let sequence = self.sequence.load(Ordering::Relaxed);
        self.sequence
            .store(sequence.wrapping_add(1), Ordering::Relaxed);
        fence(Ordering::Release);
        state.put(&mut Storing(self.words.iter()));
        self.sequence
            .store(sequence.wrapping_add(2), Ordering::Release);
    }

    /// The latest complete value.
    pub fn read(&self) -> RobotState {
        loop {
            let before = self.sequence.load(Ordering::Acquire);
            if before.is_multiple_of(2) {
                let state = RobotState::take(&mut Loading(self.words.iter()));
                fence(Ordering::Acquire);
                if self.sequence.load(Ordering::Relaxed) == before {
                    return state;
                }
            }
            // A write takes well under a microsecond; let the writer finish.
            #[cfg(elite_loom)]
            loom::thread::yield_now();
            #[cfg(not(elite_loom))]
            std::hint::spin_loop();
        }
    }
}
