//! What the motion thread would be refused, and how well it would keep time, tried without an arm.
//!
//! For whoever asks before anything moves (`eliteserver doctor`): the same priority, the same lock, the same sleep.

use std::io;
use std::time::Duration;

use platform::clock::{now, sleep_until};
use supervision::{ThreadRole, ThreadSupervisor};

use crate::realtime::{RealtimeOptions, SetupWarning, set_up};

/// What came of a rehearsal.
#[derive(Clone, Debug, Default)]
pub struct LatencyTest {
    /// What the operating system refused.
    pub warnings: Vec<SetupWarning>,
    /// How late each cycle began, from the least to the most.
    pub latencies: Vec<Duration>,
}

impl LatencyTest {
    /// The latency that so many of a thousand cycles stay within; zero without cycles.
    pub fn latency_permille(&self, of_thousand: usize) -> Duration {
        let index =
            (self.latencies.len() * of_thousand / 1000).min(self.latencies.len().max(1) - 1);
        self.latencies.get(index).copied().unwrap_or_default()
    }

    /// The greatest latency; zero without cycles.
    pub fn max_latency(&self) -> Duration {
        self.latencies.last().copied().unwrap_or_default()
    }
}

/// Sets a thread up as the motion thread is and has it wait for `cycles` deadlines that are `step` apart.
///
/// # Errors
/// The operating system gives no thread.
pub fn run_latency_test(
    options: RealtimeOptions,
    step: Duration,
    cycles: usize,
) -> io::Result<LatencyTest> {
    let faults = ThreadSupervisor::default();
    let thread = faults.start(ThreadRole::Service, "rehearsal", move || {
        let warnings = set_up(&options);
        let mut latencies = Vec::with_capacity(cycles);
        let mut deadline = now() + step;
        while latencies.len() < cycles {
            sleep_until(deadline);
            latencies.push(now().saturating_sub(deadline));
            deadline = (deadline + step).max(now());
        }
        latencies.sort_unstable();
        LatencyTest {
            warnings,
            latencies,
        }
    })?;
    let ended = thread.join();
    ended.map_err(|fault| io::Error::other(fault.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_deadline_is_waited_for_and_none_is_early() {
        let options = RealtimeOptions {
            fifo_priority: None,
            lock_memory: false,
            ..RealtimeOptions::default()
        };
        let began = now();
        let rehearsal = run_latency_test(options, Duration::from_millis(1), 50).unwrap();
        assert!(now().saturating_sub(began) >= Duration::from_millis(50));
        assert_eq!(rehearsal.latencies.len(), 50);
        assert!(rehearsal.warnings.is_empty());
        assert!(rehearsal.latency_permille(500) <= rehearsal.latency_permille(990));
        assert!(rehearsal.latency_permille(990) <= rehearsal.max_latency());
        assert_eq!(LatencyTest::default().latency_permille(990), Duration::ZERO);
    }
}
