//! The latest state, for any number of readers on any thread, without a lock.

use crate::sequence_lock::SequenceLock;
use crate::state::{CycleTime, RobotState};

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
    pub fn cycle_time(&self) -> CycleTime {
        self.0.read_first()
    }
}

#[cfg(test)]
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
        let moment = cell.cycle_time();
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
