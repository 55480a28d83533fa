//! The real clock: a thread that ticks the cycle on absolute deadlines.
//!
//! Owns the thread, its priority, and the measurement of how well the deadlines are met. What the operating system
//! refuses (priority, locked memory) is returned as warnings; the loop itself logs nothing.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc;
use std::thread::Thread;
use std::time::Duration;

use messages::{Localized, Text};
use motion_api::Timeline;
use platform::clock::{now, sleep_until};
use platform::priority;
use supervision::{ThreadHandle, ThreadRole, ThreadSupervisor, catch, injection};
use thiserror::Error;

use crate::cycle::{ControlLoop, CycleTiming};
use crate::histogram::{Histogram, HistogramSnapshot};

/// When the thread is behind by more than this (the machine slept), it goes on from now instead of catching up.
const CATCH_UP_MAX: Duration = Duration::from_millis(100);

/// At the end the arm gets this long to come to rest.
const STOP_TIME_MAX: f64 = 5.0;

/// How the motion thread is set up.
#[derive(Clone, Debug)]
pub struct RealtimeOptions {
    /// FIFO priority, 1 to 99; `None` leaves the scheduling as it is.
    pub fifo_priority: Option<u8>,
    /// Cycles begin this long after a multiple of the step on the monotonic clock; `None`: when the thread starts.
    /// Several controllers on one machine with phases of their own do not all wake at once.
    pub phase: Option<Duration>,
    /// Lock the memory that is in use when the thread starts.
    pub lock_memory: bool,
    /// Threads to unpark after every cycle, and when there will be no more.
    pub threads_to_wake: Vec<Thread>,
    /// The supervisor that hears of a fault.
    pub faults: ThreadSupervisor,
}

impl Default for RealtimeOptions {
    fn default() -> Self {
        Self {
            fifo_priority: Some(80),
            phase: None,
            lock_memory: true,
            threads_to_wake: Vec::new(),
            faults: ThreadSupervisor::default(),
        }
    }
}

/// Something the operating system refused. The thread runs all the same, with less certain timing.
#[derive(Clone, Debug, PartialEq, Eq, Error, Localized)]
#[non_exhaustive]
pub enum SetupWarning {
    /// No FIFO priority.
    #[error(
        "the motion thread gets no FIFO priority {priority} ({reason}); cycles may be late under load"
    )]
    #[zh("运动线程得不到 FIFO 优先级 {priority}（{reason}）；有负载时周期可能延迟")]
    Priority {
        /// Wanted.
        priority: u8,
        /// What the system said.
        reason: Text,
    },
    /// Memory is not locked.
    #[error("memory cannot be locked ({reason}); cycles may be late when memory is short")]
    #[zh("无法锁定内存（{reason}）；内存不足时周期可能延迟")]
    Memory {
        /// What the system said.
        reason: Text,
    },
}

#[derive(Default)]
struct ClockState {
    is_stopping: AtomicBool,
    has_ended: AtomicBool,
    overruns: AtomicU64,
    missed: AtomicU64,
    durations: Histogram,
    latencies: Histogram,
}

/// How well the deadlines are met, for whoever shows it.
#[derive(Clone, Default)]
pub struct ClockMetrics(Arc<ClockState>);

impl ClockMetrics {
    /// Cycles that ended later than the next one was due, because they took long or because they began late.
    pub fn overruns(&self) -> u64 {
        self.0.overruns.load(Ordering::Relaxed)
    }

    /// Cycles that were left out because the machine stood still for too long.
    pub fn missed(&self) -> u64 {
        self.0.missed.load(Ordering::Relaxed)
    }

    /// How long cycles took.
    pub fn durations(&self) -> HistogramSnapshot {
        self.0.durations.snapshot()
    }

    /// How late cycles began.
    pub fn latencies(&self) -> HistogramSnapshot {
        self.0.latencies.snapshot()
    }
}

/// The running motion thread. Dropping it stops it.
pub struct MotionThread {
    thread: Option<ThreadHandle<Option<ControlLoop>>>,
    shared: Arc<ClockState>,
    warnings: Vec<SetupWarning>,
}

impl MotionThread {
    /// Starts ticking `cycle` at its step time.
    ///
    /// # Errors
    /// The operating system gave no thread.
    pub fn start(cycle: ControlLoop, options: RealtimeOptions) -> std::io::Result<Self> {
        let shared = Arc::new(ClockState::default());
        let (report, warnings) = mpsc::channel();
        let in_thread = shared.clone();
        let faults = options.faults.clone();
        let thread = faults.start(ThreadRole::Motion, "motion", move || {
            // The receiver waits right below; should it be gone, nobody reads the warnings.
            let _ = report.send(set_up(&options));
            let phase = options.phase;
            let mut running = CycleGuard {
                cycle: Some(cycle),
                wake: options.threads_to_wake,
                shared: in_thread,
            };
            if let Some(cycle) = &mut running.cycle {
                run(cycle, phase, &running.wake, &running.shared);
            }
            running.cycle.take()
        })?;
        Ok(Self {
            thread: Some(thread),
            shared,
            warnings: warnings.recv().unwrap_or_default(),
        })
    }

    /// What the operating system refused.
    pub fn warnings(&self) -> &[SetupWarning] {
        &self.warnings
    }

    /// How well the deadlines are met.
    pub fn meter(&self) -> ClockMetrics {
        ClockMetrics(self.shared.clone())
    }

    /// The clock as scripts see it.
    pub fn timeline(&self) -> RealTimeline {
        RealTimeline(self.shared.clone())
    }

    /// Brings the arm to rest, publishes the last snapshot, ends the thread and gives the cycle back; `None` when the
    /// thread has died.
    pub fn stop(mut self) -> Option<ControlLoop> {
        self.join()
    }

    fn join(&mut self) -> Option<ControlLoop> {
        self.shared.is_stopping.store(true, Ordering::Relaxed);
        self.thread.take()?.join().ok().flatten()
    }
}

/// What the thread holds. However it ends, the arm is held, and whoever waits for cycles hears that no more will come.
struct CycleGuard {
    /// Still there when this is dropped: a panic has ended the thread.
    cycle: Option<ControlLoop>,
    wake: Vec<Thread>,
    shared: Arc<ClockState>,
}

impl Drop for CycleGuard {
    fn drop(&mut self) {
        if let Some(mut cycle) = self.cycle.take() {
            // What a fault has left may hold another; the first one is told.
            let _ = catch(move || cycle.hold_after_fault());
        }
        self.shared.has_ended.store(true, Ordering::Release);
        self.wake.iter().for_each(Thread::unpark);
    }
}

impl Drop for MotionThread {
    fn drop(&mut self) {
        self.join();
    }
}

/// The real clock as scripts see it: it runs by itself.
#[derive(Clone)]
pub struct RealTimeline(Arc<ClockState>);

impl Timeline for RealTimeline {
    fn is_virtual(&self) -> bool {
        false
    }

    fn advance(&self) -> bool {
        false
    }

    fn set_driven(&self, _on: bool) {}

    fn has_ended(&self) -> bool {
        self.0.has_ended.load(Ordering::Acquire)
    }
}

pub(crate) fn set_up(options: &RealtimeOptions) -> Vec<SetupWarning> {
    let mut warnings = Vec::new();
    if let Some(priority) = options.fifo_priority
        && let Err(reason) = priority::set_fifo_priority(priority)
    {
        let reason = Text::of(&reason);
        warnings.push(SetupWarning::Priority { priority, reason });
    }
    if options.lock_memory
        && let Err(reason) = priority::lock_memory()
    {
        let reason = Text::of(&reason);
        warnings.push(SetupWarning::Memory { reason });
    }
    warnings
}

fn run(cycle: &mut ControlLoop, phase: Option<Duration>, wake: &[Thread], shared: &ClockState) {
    let step = Duration::from_secs_f64(cycle.step_time());
    let mut stop_cycles = (STOP_TIME_MAX / cycle.step_time()) as u64;
    let mut deadline = first_deadline(now(), step, phase);
    let mut step_duration_us = 0.0;
    loop {
        sleep_until(deadline);
        let begin = now();
        let late = begin.saturating_sub(deadline);
        injection::point("motion");
        cycle.tick(CycleTiming {
            step_duration_us,
            wakeup_latency_us: late.as_secs_f64() * 1e6,
        });
        let end = now();
        let duration = end.saturating_sub(begin);
        step_duration_us = duration.as_secs_f64() * 1e6;
        shared.durations.record(duration);
        shared.latencies.record(late);
        wake.iter().for_each(Thread::unpark);

        deadline += step;
        if end > deadline {
            shared.overruns.fetch_add(1, Ordering::Relaxed);
        }
        let behind = end.saturating_sub(deadline);
        if behind > CATCH_UP_MAX {
            let left_out = (behind.as_secs_f64() / step.as_secs_f64()) as u64;
            shared.missed.fetch_add(left_out, Ordering::Relaxed);
            deadline = end + step;
        }
        if shared.is_stopping.load(Ordering::Relaxed) {
            if cycle.is_standing() || stop_cycles == 0 {
                return;
            }
            cycle.stop_moving();
            stop_cycles -= 1;
        }
    }
}

/// When the first cycle begins: a step from now, or at the first place of its phase after that.
fn first_deadline(now: Duration, step: Duration, phase: Option<Duration>) -> Duration {
    let soon = now + step;
    let Some(phase) = phase else {
        return soon;
    };
    let step_ns = step.as_nanos().max(1);
    let wanted = phase.as_nanos() % step_ns;
    let found = soon.as_nanos() % step_ns;
    let wait = (wanted + step_ns - found) % step_ns;
    // Less than a step.
    soon + Duration::from_nanos(u64::try_from(wait).unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cycles_begin_at_their_phase_of_the_step() {
        let (ms, us) = (Duration::from_millis, Duration::from_micros);
        assert_eq!(first_deadline(ms(10), ms(4), None), ms(14));
        for (now, phase, begins) in [
            (ms(10), ms(0), ms(16)),
            (ms(12), ms(0), ms(16)),
            (ms(10), ms(1), ms(17)),
            (ms(10), ms(3), ms(15)),
            (us(10_001), us(500), us(16_500)),
            (ms(10), ms(7), ms(15)),
        ] {
            assert_eq!(
                first_deadline(now, ms(4), Some(phase)),
                begins,
                "{now:?} {phase:?}"
            );
        }
    }
}
