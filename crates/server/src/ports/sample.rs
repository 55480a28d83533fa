//! One cycle as ports show it: the snapshot with what is known beside it, and the slow beat in which port 30001 shows
//! it.
//!
//! Ports never look at two places for one message: what they send is one sample, of one cycle.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use motion_api::{RegisterImages, RobotState};
use tokio::sync::watch;

use crate::ports::description::{Peripherals, TaskStatus};

/// Everything that clients can read, as it was at the end of one cycle.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// The snapshot.
    pub state: RobotState,
    /// What the main task is doing.
    pub task: TaskStatus,
    /// The line that the main task executes, 0 when none does.
    pub script_line: u32,
    /// Velocity of the elbow in the base frame, m/s.
    pub elbow_velocity: [f64; 3],
    /// The registers.
    pub registers: RegisterImages,
    /// Settings beside the state.
    pub peripherals: Peripherals,
}

/// Beats a second (SDK user guide: states of port 30001 come at 10 Hz).
const BEATS_PER_SECOND: f64 = 10.0;

/// The first cycle of each tenth of a second of simulated time. Who follows sees the latest one and may miss others.
#[derive(Debug)]
pub struct SampleDecimator {
    latest: watch::Sender<Option<Arc<Sample>>>,
    /// Number of the last beat.
    last: AtomicU64,
}

impl Default for SampleDecimator {
    fn default() -> Self {
        Self {
            latest: watch::Sender::new(None),
            last: AtomicU64::new(u64::MAX),
        }
    }
}

impl SampleDecimator {
    /// The latest beat and those that come.
    pub fn subscribe(&self) -> watch::Receiver<Option<Arc<Sample>>> {
        self.latest.subscribe()
    }

    /// Whether the cycle that ended at `time`, s, is a beat. Asked once for every cycle, in order.
    pub fn is_due(&self, time: f64) -> bool {
        // A millionth of slack: ten times a sum of steps is rarely a whole number.
        let beat = (time * BEATS_PER_SECOND + 1e-6) as u64;
        self.last.swap(beat, Ordering::Relaxed) != beat
    }

    /// Shows the sample of a beat.
    pub fn publish(&self, sample: Arc<Sample>) {
        self.latest.send_replace(Some(sample));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ten_cycles_a_second_are_beats_whatever_the_step_time() {
        for step in [0.001, 0.002, 0.004, 0.005, 0.008] {
            let beats = SampleDecimator::default();
            let times = (1..).map(|cycle| f64::from(cycle) * step);
            let found: Vec<f64> = times
                .take_while(|time| *time < 20.0 - step / 2.0)
                .filter(|time| beats.is_due(*time))
                .collect();
            assert_eq!(found.len(), 200, "{step}");
            // Right after the start, then never late by more than a cycle.
            for (number, time) in (0..).zip(&found) {
                let late = time - f64::from(number) / 10.0;
                assert!((-1e-6..=step + 1e-6).contains(&late), "{step}: {late}");
            }
        }
    }
}
