//! The virtual clock: simulated time passes when somebody asks for it, one cycle at a time.
//!
//! Owns the cycle behind a mutex. A task that drives the timeline ticks it on its own thread; while nobody does, an
//! [`IdlePacer`] lets time pass at wall pace. Loses no record: a tick waits until the recorder has made room.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle, Thread};
use std::time::{Duration, Instant};

use motion_api::Timeline;

use crate::config::ConfigError;
use crate::constants::RECORDS_PER_CYCLE;
use crate::cycle::{Cycle, Timing};

/// How long a tick waits before it looks again whether the recorder has made room.
const ROOM_POLL: Duration = Duration::from_micros(50);

/// A cycle that is ticked on demand.
pub struct VirtualTimeline {
    cycle: Mutex<Cycle>,
    drivers: Mutex<Drivers>,
    drivers_changed: Condvar,
    wake: Vec<Thread>,
}

struct Drivers {
    count: usize,
    is_closed: bool,
}

impl VirtualTimeline {
    /// Puts `cycle` on the virtual clock. The threads in `wake` are unparked after every tick.
    ///
    /// # Errors
    /// [`ConfigError::RingTooSmall`] when the record ring cannot hold what one cycle may put into it.
    pub fn new(cycle: Cycle, wake: Vec<Thread>) -> Result<Self, ConfigError> {
        let needed = RECORDS_PER_CYCLE;
        if let Some(given) = cycle.record_capacity()
            && given < needed
        {
            return Err(ConfigError::RingTooSmall {
                ring: "record",
                given,
                needed,
            });
        }
        Ok(Self {
            cycle: Mutex::new(cycle),
            drivers: Mutex::new(Drivers {
                count: 0,
                is_closed: false,
            }),
            drivers_changed: Condvar::new(),
            wake,
        })
    }

    fn tick(&self) {
        // A panic in a tick cannot leave the cycle half written in a way that matters: the process is about to end.
        let mut cycle = self.cycle.lock().unwrap_or_else(PoisonError::into_inner);
        while cycle
            .record_room()
            .is_some_and(|room| room < RECORDS_PER_CYCLE)
        {
            thread::sleep(ROOM_POLL);
        }
        cycle.tick(Timing::default());
        drop(cycle);
        self.wake.iter().for_each(Thread::unpark);
    }

    fn drivers(&self) -> MutexGuard<'_, Drivers> {
        self.drivers.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn step_time(&self) -> Duration {
        let cycle = self.cycle.lock().unwrap_or_else(PoisonError::into_inner);
        Duration::from_secs_f64(cycle.step_time())
    }
}

impl Timeline for VirtualTimeline {
    fn is_virtual(&self) -> bool {
        true
    }

    fn advance(&self) -> bool {
        self.tick();
        true
    }

    fn drive(&self, on: bool) {
        let mut drivers = self.drivers();
        drivers.count = if on {
            drivers.count + 1
        } else {
            drivers.count.saturating_sub(1)
        };
        self.drivers_changed.notify_all();
    }
}

/// A thread that ticks a virtual timeline at wall pace while nobody drives it. Ends when it is dropped.
pub struct IdlePacer {
    timeline: Arc<VirtualTimeline>,
    thread: Option<JoinHandle<()>>,
}

impl IdlePacer {
    /// Starts pacing.
    ///
    /// # Errors
    /// The operating system gave no thread.
    pub fn start(timeline: Arc<VirtualTimeline>) -> std::io::Result<Self> {
        let paced = timeline.clone();
        let thread = thread::Builder::new()
            .name("idle-pace".into())
            .spawn(move || pace(&paced))?;
        Ok(Self {
            timeline,
            thread: Some(thread),
        })
    }
}

impl Drop for IdlePacer {
    fn drop(&mut self) {
        self.timeline.drivers().is_closed = true;
        self.timeline.drivers_changed.notify_all();
        if let Some(thread) = self.thread.take() {
            // A panic of that thread has been reported by the panic hook already.
            let _ = thread.join();
        }
    }
}

fn pace(timeline: &VirtualTimeline) {
    let step = timeline.step_time();
    let mut deadline = Instant::now() + step;
    let mut drivers = timeline.drivers();
    while !drivers.is_closed {
        if drivers.count > 0 {
            drivers = timeline
                .drivers_changed
                .wait(drivers)
                .unwrap_or_else(PoisonError::into_inner);
            deadline = Instant::now() + step;
            continue;
        }
        let left = deadline.saturating_duration_since(Instant::now());
        if !left.is_zero() {
            drivers = timeline
                .drivers_changed
                .wait_timeout(drivers, left)
                .unwrap_or_else(PoisonError::into_inner)
                .0;
            continue;
        }
        drop(drivers);
        timeline.tick();
        // After a pause of the whole process, go on from now instead of catching up.
        deadline = (deadline + step).max(Instant::now());
        drivers = timeline.drivers();
    }
}
