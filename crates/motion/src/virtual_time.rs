//! The virtual clock: simulated time passes when somebody asks for it, one cycle at a time.
//!
//! Owns the cycle behind a mutex. A task that drives the timeline ticks it on its own thread; while nobody does, an
//! [`IdlePacer`] lets time pass at wall pace. Loses no record: a tick waits for the recorder to make room, for a turn
//! at a time, so that whoever ticks can look at other things. When there is nobody any more to wait for is the
//! recorder's to say.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, Thread};
use std::time::{Duration, Instant};

use messages::text;
use motion_api::Timeline;
use supervision::{Fault, ThreadHandle, ThreadRole, ThreadSupervisor, catch, injection};

use crate::config::ConfigError;
use crate::constants::RECORDS_PER_CYCLE;
use crate::cycle::{ControlLoop, CycleTiming};

/// How long a tick waits before it looks again whether the recorder has made room.
const ROOM_POLL: Duration = Duration::from_micros(50);

/// How long a tick waits for room before it leaves it to another one.
const ROOM_TURN: Duration = Duration::from_millis(20);

/// What moves after every cycle, on the same thread: the world around the arm.
pub type CycleFollower = Box<dyn FnMut() + Send>;

/// What a tick moves.
struct Ticked {
    cycle: ControlLoop,
    follower: Option<CycleFollower>,
}

/// A cycle that is ticked on demand.
pub struct VirtualTimeline {
    ticked: Mutex<Ticked>,
    drivers: Mutex<DriverCount>,
    drivers_changed: Condvar,
    wake: Vec<Thread>,
    /// A fault has ended the clock.
    has_ended: AtomicBool,
    faults: ThreadSupervisor,
}

struct DriverCount {
    count: usize,
    is_closed: bool,
}

impl VirtualTimeline {
    /// Puts `cycle` on the virtual clock. The threads in `wake` are unparked after every tick.
    ///
    /// # Errors
    /// [`ConfigError::RingTooSmall`] when the record ring cannot hold what one cycle may put into it.
    pub fn new(cycle: ControlLoop, wake: Vec<Thread>) -> Result<Self, ConfigError> {
        let needed = RECORDS_PER_CYCLE;
        if let Some(given) = cycle.record_capacity()
            && given < needed
        {
            return Err(ConfigError::RingTooSmall {
                ring: text!("record", "记录"),
                given,
                needed,
            });
        }
        Ok(Self {
            ticked: Mutex::new(Ticked {
                cycle,
                follower: None,
            }),
            drivers: Mutex::new(DriverCount {
                count: 0,
                is_closed: false,
            }),
            drivers_changed: Condvar::new(),
            wake,
            has_ended: AtomicBool::new(false),
            faults: ThreadSupervisor::default(),
        })
    }

    /// Reports faults of a cycle to `faults`, on whichever thread the cycle ran.
    pub fn with_supervisor(self, faults: ThreadSupervisor) -> Self {
        Self { faults, ..self }
    }

    /// Calls `follower` after every cycle.
    pub fn with_follower(self, follower: CycleFollower) -> Self {
        self.lock().follower = Some(follower);
        self
    }

    fn lock(&self) -> MutexGuard<'_, Ticked> {
        // A tick that panics ends the clock, so nobody uses what it left half written.
        self.ticked.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// One cycle; none, and false, while the recorder makes no room, and once a fault has ended the clock.
    fn tick(&self) -> bool {
        let mut ticked = self.lock();
        let mut since = None;
        while !ticked.cycle.has_record_room(RECORDS_PER_CYCLE) {
            if since.get_or_insert_with(Instant::now).elapsed() > ROOM_TURN {
                return false;
            }
            thread::sleep(ROOM_POLL);
        }
        if self.has_ended() {
            return false;
        }
        let Ticked { cycle, follower } = &mut *ticked;
        let outcome = catch(|| {
            injection::point("motion");
            cycle.tick(CycleTiming::default());
            if let Some(follow) = follower {
                follow();
            }
        });
        let fault = outcome.err().map(|panicked| {
            // What a fault has left may hold another; the first one is told.
            let _ = catch(|| cycle.hold_after_fault());
            Fault::new(ThreadRole::Motion, "the virtual clock", panicked)
        });
        drop(ticked);
        if let Some(fault) = &fault {
            self.has_ended.store(true, Ordering::Release);
            self.faults.tell(fault);
        }
        self.wake.iter().for_each(Thread::unpark);
        fault.is_none()
    }

    fn drivers(&self) -> MutexGuard<'_, DriverCount> {
        self.drivers.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn step_time(&self) -> Duration {
        Duration::from_secs_f64(self.lock().cycle.step_time())
    }
}

impl Timeline for VirtualTimeline {
    fn is_virtual(&self) -> bool {
        true
    }

    fn advance(&self) -> bool {
        self.tick()
    }

    fn has_ended(&self) -> bool {
        self.has_ended.load(Ordering::Acquire)
    }

    fn set_driven(&self, on: bool) {
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
    thread: Option<ThreadHandle<()>>,
}

impl IdlePacer {
    /// Starts pacing.
    ///
    /// # Errors
    /// The operating system gave no thread.
    pub fn start(timeline: Arc<VirtualTimeline>) -> std::io::Result<Self> {
        let paced = timeline.clone();
        let faults = timeline.faults.clone();
        let thread = faults.start_service("idle-pace", move || pace(&paced))?;
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
            // The thread is started again after a fault, so it ends by itself.
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
        injection::point("idle-pace");
        if !timeline.tick() && timeline.has_ended() {
            return;
        }
        // After a pause of the whole process, go on from now instead of catching up.
        deadline = (deadline + step).max(Instant::now());
        drivers = timeline.drivers();
    }
}
