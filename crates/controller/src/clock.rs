//! The thread or timeline that moves time, and the pump that carries events from there to whoever waits for them.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::thread::{self, Thread};
use std::time::{Duration, Instant};

use elite_runtime::Robot;
use motion::ControlLoop;
use motion::realtime::{MotionThread, RealtimeOptions};
use motion::virtual_time::{IdlePacer, VirtualTimeline};
use motion_api::Timeline;
use supervision::{ThreadHandle, ThreadSupervisor, injection};

use crate::cell_world::{CellWorld, WorldRunner};
use crate::options::ClockChoice;
use crate::start::StartError;

/// How often the pump looks for events when no motion thread wakes it (virtual clock, nothing running).
const IDLE_PUMP: Duration = Duration::from_millis(2);
/// How often the pump looks for events where time passes only for somebody who pumps: rarely, because many idle
/// controllers must cost nothing.
const RARE_PUMP: Duration = Duration::from_millis(100);

/// What moves time.
pub(crate) enum ClockDriver {
    Real(MotionThread, Option<WorldThread>),
    Virtual(Option<IdlePacer>),
}

/// Starts the clock; under the real one the `pump` is woken after each cycle, and the world moves on a thread of its
/// own.
pub(crate) fn start_clock(
    (choice, phase): (ClockChoice, Option<Duration>),
    passes_alone: bool,
    (cycle, world): (ControlLoop, Option<WorldRunner>),
    pump: Thread,
    faults: &ThreadSupervisor,
) -> Result<(ClockDriver, Arc<dyn Timeline>), StartError> {
    match choice {
        ClockChoice::Realtime => {
            let world = world
                .map(|runner| WorldThread::start(runner, faults))
                .transpose()?;
            let mut threads_to_wake = vec![pump];
            threads_to_wake.extend(world.as_ref().map(WorldThread::thread));
            let options = RealtimeOptions {
                phase,
                threads_to_wake,
                faults: faults.clone(),
                ..RealtimeOptions::default()
            };
            let thread = MotionThread::start(cycle, options)?;
            for warning in thread.warnings() {
                tracing::warn!("{warning}");
            }
            let timeline = Arc::new(thread.timeline());
            Ok((ClockDriver::Real(thread, world), timeline))
        }
        ClockChoice::Virtual => {
            let timeline = VirtualTimeline::new(cycle, Vec::new())?;
            let timeline = match world {
                Some(mut runner) => timeline.with_follower(Box::new(move || runner.run_waiting())),
                None => timeline,
            };
            let timeline = Arc::new(timeline.with_supervisor(faults.clone()));
            let pacer = match passes_alone {
                true => Some(IdlePacer::start(timeline.clone())?),
                false => None,
            };
            Ok((ClockDriver::Virtual(pacer), timeline))
        }
    }
}

/// The thread that moves the world after each cycle of the motion thread, which never waits for it.
pub(crate) struct WorldThread {
    thread: ThreadHandle<()>,
    ending: Arc<AtomicBool>,
}

impl WorldThread {
    fn start(mut runner: WorldRunner, faults: &ThreadSupervisor) -> io::Result<Self> {
        let ending = Arc::new(AtomicBool::new(false));
        let is_ending = ending.clone();
        let world = runner.world().clone();
        let mut late = LateWarnings::default();
        let thread = faults.start_service("world", move || {
            while !is_ending.load(Ordering::Acquire) {
                runner.run_waiting();
                late.look(&world);
                thread::park();
                injection::point("world");
            }
            runner.finish();
        })?;
        Ok(Self { thread, ending })
    }

    fn thread(&self) -> Thread {
        self.thread.thread().clone()
    }

    /// Ends the thread; the motion thread must have ended.
    pub(crate) fn stop(self) {
        self.ending.store(true, Ordering::Release);
        self.thread.thread().unpark();
        let _ = self.thread.join();
    }
}

/// Warns of a world that comes late, at most every ten seconds.
#[derive(Default)]
struct LateWarnings {
    told: u64,
    last: Option<Instant>,
}

impl LateWarnings {
    const EVERY: Duration = Duration::from_secs(10);

    fn look(&mut self, world: &CellWorld) {
        let late = world.late_cycles();
        if late == self.told || self.last.is_some_and(|last| last.elapsed() < Self::EVERY) {
            return;
        }
        tracing::warn!(
            "the world of parts came late for {} control cycles: this machine is too slow for it, or busy",
            late - self.told
        );
        (self.told, self.last) = (late, Some(Instant::now()));
    }
}

/// The thread that carries events from the motion thread to whoever waits for them.
pub(crate) struct EventPump {
    thread: ThreadHandle<()>,
    ending: Arc<AtomicBool>,
}

impl EventPump {
    /// Starts the thread; it begins once it is given the robot.
    pub(crate) fn start(
        faults: &ThreadSupervisor,
        passes_alone: bool,
    ) -> io::Result<(Self, mpsc::Sender<Arc<Robot>>)> {
        let idle = if passes_alone { IDLE_PUMP } else { RARE_PUMP };
        let ending = Arc::new(AtomicBool::new(false));
        let (sender, receiver) = mpsc::channel::<Arc<Robot>>();
        let told = ending.clone();
        let mut given = None;
        let thread = faults.start_service("pump", move || {
            // Begun again after a fault it has the robot already.
            if given.is_none() {
                given = receiver.recv().ok();
            }
            let Some(robot) = &given else { return };
            while !told.load(Ordering::Acquire) {
                injection::point("pump");
                robot.pump();
                if robot.timeline().is_virtual() {
                    thread::park_timeout(idle);
                } else {
                    thread::park();
                }
            }
        })?;
        Ok((Self { thread, ending }, sender))
    }

    pub(crate) fn thread(&self) -> Thread {
        self.thread.thread().clone()
    }

    pub(crate) fn stop(self) {
        self.ending.store(true, Ordering::Release);
        self.thread.thread().unpark();
        // The thread is begun again after a fault, therefore it always ends by itself.
        let _ = self.thread.join();
    }
}
