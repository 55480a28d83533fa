//! A panic inside the control cycle: under both clocks the arm is held, whoever waits hears that no cycle will come,
//! and the fault is fatal.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "tests fail by panicking"
)]

use std::thread;
use std::time::{Duration, Instant};

use kinematics::RobotModel;
use motion::realtime::{MotionThread, RealtimeOptions};
use motion::virtual_time::VirtualTimeline;
use motion::{ControlLoop, CycleConfig};
use motion_api::{RingCapacities, SafetyMode, ScriptEndpoint, Timeline, motion_channel};
use supervision::{ThreadSupervisor, injection};

fn controller() -> (ControlLoop, ScriptEndpoint) {
    let config = CycleConfig::new(RobotModel::built_in("cs66").unwrap());
    let (motion, script) = motion_channel(RingCapacities::default(), &config.first_state());
    (ControlLoop::new(config, motion).unwrap(), script)
}

fn is_held_for_good(timeline: &dyn Timeline, script: &ScriptEndpoint, faults: &ThreadSupervisor) {
    let begin = Instant::now();
    while !timeline.has_ended() {
        assert!(begin.elapsed() < Duration::from_secs(10));
        thread::sleep(Duration::from_millis(1));
    }
    let state = script.snapshot.read();
    assert_eq!(state.safety_mode, SafetyMode::Fault);
    assert_eq!(state.target_qd.max_abs(), 0.0);
    assert!(!timeline.advance(), "no cycle runs any more");
    assert_eq!(script.snapshot.read().cycle, state.cycle);
    while faults.fatal().is_none() {
        assert!(begin.elapsed() < Duration::from_secs(10));
        thread::sleep(Duration::from_millis(1));
    }
    let fault = faults.fatal().unwrap().to_string();
    assert!(fault.contains("on demand in motion"), "{fault}");
}

#[test]
fn a_panic_in_the_cycle_ends_either_clock_and_holds_the_arm() {
    let faults = ThreadSupervisor::default();
    let (cycle, script) = controller();
    let timeline = VirtualTimeline::new(cycle, Vec::new()).unwrap();
    let timeline = timeline.with_supervisor(faults.clone());
    assert!(timeline.advance());
    injection::order("motion panic");
    assert!(!timeline.advance());
    is_held_for_good(&timeline, &script, &faults);

    let faults = ThreadSupervisor::default();
    let (cycle, script) = controller();
    let options = RealtimeOptions {
        fifo_priority: None,
        lock_memory: false,
        threads_to_wake: vec![thread::current()],
        faults: faults.clone(),
        ..RealtimeOptions::default()
    };
    let clock = MotionThread::start(cycle, options).unwrap();
    let timeline = clock.timeline();
    assert!(!timeline.has_ended());
    injection::order("motion panic");
    is_held_for_good(&timeline, &script, &faults);
    assert!(clock.stop().is_none(), "there is no cycle to give back");
}
