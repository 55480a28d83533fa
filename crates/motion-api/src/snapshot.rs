//! The latest state, for any number of readers on any thread, without a lock: a sequence lock over atomic words.
//!
//! The writer (one thread: the motion thread) never waits. A reader that meets a write in progress reads again. Safe
//! code only: the value travels as 64-bit atomics (Boehm, "Can seqlocks get along with programming language memory
//! models?", 2012, for the fences).

use core::marker::PhantomData;

#[cfg(elite_loom)]
use loom::sync::atomic::{AtomicU64, Ordering, fence};
#[cfg(not(elite_loom))]
use std::sync::atomic::{AtomicU64, Ordering, fence};

use crate::state::{Moment, RobotState};
use crate::words::{Sink, Source, Words};

/// Holds the latest [`RobotState`]. One writer, any number of readers.
pub struct SnapshotCell(SequenceLock<RobotState>);

impl SnapshotCell {
    /// A cell that holds `first`.
    pub fn new(first: &RobotState) -> Self {
        Self(SequenceLock::new(first))
    }

    /// Replaces the value. Only one thread may call this; it never waits.
    pub fn publish(&self, state: &RobotState) {
        self.0.publish(state);
    }

    /// The latest complete value.
    pub fn read(&self) -> RobotState {
        self.0.read()
    }

    /// When the latest value was made, without reading all of it.
    pub fn moment(&self) -> Moment {
        self.0.read_first()
    }
}

/// The mechanism, for any value made of words.
struct SequenceLock<T> {
    /// Even: stable. Odd: a write is in progress.
    sequence: AtomicU64,
    words: Box<[AtomicU64]>,
    value: PhantomData<fn() -> T>,
}

struct Storing<'a>(&'a [AtomicU64]);
struct Loading<'a>(std::slice::Iter<'a, AtomicU64>);

impl Sink for Storing<'_> {
    #[inline]
    fn put(&mut self, word: u64) {
        if let Some((cell, rest)) = self.0.split_first() {
            cell.store(word, Ordering::Relaxed);
            self.0 = rest;
        }
    }

    #[inline]
    fn put_numbers(&mut self, numbers: &[f64]) {
        let mut cells = self.0;
        for number in numbers {
            let Some((cell, rest)) = cells.split_first() else {
                break;
            };
            cell.store(number.to_bits(), Ordering::Relaxed);
            cells = rest;
        }
        self.0 = cells;
    }
}

impl Source for Loading<'_> {
    fn take(&mut self) -> u64 {
        self.0.next().map_or(0, |cell| cell.load(Ordering::Relaxed))
    }
}

impl<T: Words> SequenceLock<T> {
    fn new(first: &T) -> Self {
        let cell = Self {
            sequence: AtomicU64::new(0),
            words: (0..T::COUNT).map(|_| AtomicU64::new(0)).collect(),
            value: PhantomData,
        };
        cell.publish(first);
        cell
    }

    fn publish(&self, state: &T) {
        let sequence = self.sequence.load(Ordering::Relaxed);
        self.sequence
            .store(sequence.wrapping_add(1), Ordering::Relaxed);
        fence(Ordering::Release);
        state.put(&mut Storing(&self.words));
        self.sequence
            .store(sequence.wrapping_add(2), Ordering::Release);
    }

    fn read(&self) -> T {
        self.read_first()
    }

    /// What the first words of the value are.
    fn read_first<U: Words>(&self) -> U {
        loop {
            let before = self.sequence.load(Ordering::Acquire);
            if before.is_multiple_of(2) {
                let state = U::take(&mut Loading(self.words.iter()));
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

#[cfg(all(test, elite_loom))]
mod model {
    use super::SequenceLock;
    use loom::sync::Arc;

    /// Every interleaving of one writer and one reader that loom finds: a reader never sees half of a write.
    #[test]
    fn a_reader_never_sees_half_a_write() {
        loom::model(|| {
            let cell = Arc::new(SequenceLock::new(&[0_u64; 2]));
            let writer = {
                let cell = cell.clone();
                loom::thread::spawn(move || cell.publish(&[1, 1]))
            };
            let [a, b] = cell.read();
            assert_eq!(a, b);
            writer.join().unwrap();
            assert_eq!(cell.read(), [1, 1]);
        });
    }
}

#[cfg(all(test, not(elite_loom)))]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};

    use super::*;
    use kinematics::{JointPositions, RpyPose};

    fn state(n: u64) -> RobotState {
        let x = n as f64;
        RobotState {
            cycle: n,
            time: x * 0.004,
            target_q: JointPositions([x; 6]),
            actual_tcp_pose: RpyPose::from_array([x; 6]),
            wakeup_latency_us: x,
            ..RobotState::at_start(JointPositions::ZERO, 0.004)
        }
    }

    #[test]
    fn what_was_published_is_read() {
        let cell = SnapshotCell::new(&state(0));
        assert_eq!(cell.read(), state(0));
        cell.publish(&state(7));
        assert_eq!(cell.read(), state(7));
        let moment = cell.moment();
        let RobotState {
            cycle,
            time,
            step_time,
            ..
        } = state(7);
        assert_eq!(
            (moment.cycle, moment.time, moment.step_time),
            (cycle, time, step_time)
        );
    }

    #[test]
    fn readers_on_other_threads_never_see_a_mixture() {
        let cell = Arc::new(SnapshotCell::new(&state(0)));
        let done = Arc::new(AtomicBool::new(false));
        let readers: Vec<_> = (0..2)
            .map(|_| {
                let (cell, done) = (cell.clone(), done.clone());
                std::thread::spawn(move || {
                    let mut last = 0;
                    while !done.load(Ordering::Relaxed) {
                        let read = cell.read();
                        assert_eq!(read, state(read.cycle));
                        assert!(read.cycle >= last);
                        last = read.cycle;
                    }
                })
            })
            .collect();
        for n in 1..=20_000 {
            cell.publish(&state(n));
        }
        done.store(true, Ordering::Relaxed);
        readers.into_iter().for_each(|r| r.join().unwrap());
        assert_eq!(cell.read(), state(20_000));
    }
}
