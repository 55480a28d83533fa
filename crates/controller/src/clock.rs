//! The thread or timeline that moves time, and the pump that carries events from there to whoever waits for them.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::thread::{self, Thread};
use std::time::Duration;

use elite_runtime::Robot;
use motion::ControlLoop;
use motion::realtime::{MotionThread, RealtimeOptions};
use motion::virtual_time::{IdlePacer, VirtualTimeline};
use motion_api::Timeline;
use supervision::{ThreadHandle, ThreadSupervisor, injection};

use crate::options::ClockChoice;
use crate::start::StartError;

/// How often the pump looks for events when no motion thread wakes it (virtual clock, nothing running).
const IDLE_PUMP: Duration = Duration::from_millis(2);
/// How often the pump looks for events where time passes only for somebody who pumps: rarely, because many idle
/// controllers must cost nothing.
const RARE_PUMP: Duration = Duration::from_millis(100);

/// What moves time.
pub(crate) enum ClockDriver {
    Real(MotionThread),
    Virtual(Option<IdlePacer>),
}

/// Starts the clock; under the real one the `pump` is woken after each cycle.
pub(crate) fn start_clock(
    (choice, phase): (ClockChoice, Option<Duration>),
    passes_alone: bool,
    cycle: ControlLoop,
    pump: Thread,
    faults: &ThreadSupervisor,
) -> Result<(ClockDriver, Arc<dyn Timeline>), StartError> {
    match choice {
        ClockChoice::Realtime => {
            let options = RealtimeOptions {
                phase,
                threads_to_wake: vec![pump],
                faults: faults.clone(),
                ..RealtimeOptions::default()
            };
            let thread = MotionThread::start(cycle, options)?;
            for warning in thread.warnings() {
                tracing::warn!("{warning}");
            }
            let timeline = Arc::new(thread.timeline());
            Ok((ClockDriver::Real(thread), timeline))
        }
        ClockChoice::Virtual => {
            let timeline = VirtualTimeline::new(cycle, Vec::new())?;
            let timeline = Arc::new(timeline.with_supervisor(faults.clone()));
            let pacer = match passes_alone {
                true => Some(IdlePacer::start(timeline.clone())?),
                false => None,
            };
            Ok((ClockDriver::Virtual(pacer), timeline))
        }
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
