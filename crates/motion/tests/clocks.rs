//! The two clocks: the same tick, no record lost under the virtual one, deadlines and a clean end under the real one.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]
#![allow(
    clippy::approx_constant,
    reason = "joint angles and speeds as people type them"
)]

use crate::common;

use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use common::{ideal, movej};
use kinematics::JointPositions;
use motion::realtime::{MotionThread, RealtimeOptions};
use motion::virtual_time::{IdlePacer, VirtualTimeline};
use motion::{ConfigError, ControlLoop};
use motion_api::{
    Event, MachineCommand, MotionMode, Origin, Outcome, Record, RingCapacities, ScriptEndpoint,
    Timeline, motion_channel,
};

/// Hardly more records than the fullest cycle makes.
const RECORDS: usize = 520;

fn controller(sizes: RingCapacities) -> (ControlLoop, ScriptEndpoint) {
    let config = ideal("cs66");
    let (motion, script) = motion_channel(sizes, &config.first_state());
    (ControlLoop::new(config, motion).unwrap(), script)
}

fn plain() -> RealtimeOptions {
    // Tests share the machine with others: no priority, no locked memory.
    RealtimeOptions {
        fifo_priority: None,
        lock_memory: false,
        threads_to_wake: vec![thread::current()],
        ..RealtimeOptions::default()
    }
}

#[test]
fn virtual_time_waits_for_the_recorder_and_loses_nothing() {
    let sizes = RingCapacities {
        records: Some(RECORDS),
        ..RingCapacities::default()
    };
    let (cycle, mut script) = controller(sizes);
    let timeline = VirtualTimeline::new(cycle, Vec::new()).unwrap();
    let mut records = script.records.take().unwrap();
    let reader = thread::spawn(move || {
        let mut cycles = Vec::new();
        while !records.is_finished() {
            match records.next_record() {
                Some(Record::Cycle(state)) => cycles.push(state.cycle),
                Some(Record::Command { .. } | Record::Points { .. } | Record::Registers { .. }) => {
                }
                None => thread::sleep(Duration::from_micros(200)),
            }
        }
        cycles
    });
    timeline.set_driven(true);
    for _ in 0..2000 {
        // A turn without room for the records is no cycle.
        while !timeline.advance() {}
    }
    timeline.set_driven(false);
    drop(timeline);
    assert_eq!(reader.join().unwrap(), (1..=2000).collect::<Vec<_>>());
    assert_eq!(script.snapshot.read().records_lost, 0);
}

#[test]
fn virtual_time_that_the_recorder_holds_up_gives_turns_back_and_goes_on_when_it_is_given_up() {
    let sizes = RingCapacities {
        records: Some(RECORDS),
        ..RingCapacities::default()
    };
    let (cycle, mut script) = controller(sizes);
    let timeline = VirtualTimeline::new(cycle, Vec::new()).unwrap();
    let records = script.records.take().unwrap();
    let flow = records.flow().clone();
    assert!(timeline.advance() && !flow.is_full());
    while timeline.advance() {}
    let held = script.snapshot.read();
    assert!(flow.is_full() && held.cycle < RECORDS as u64 && !timeline.has_ended());
    flow.abandon();
    for _ in 0..100 {
        assert!(timeline.advance());
    }
    let state = script.snapshot.read();
    assert_eq!((state.cycle, state.records_lost), (held.cycle + 100, 0));
}

#[test]
fn virtual_time_goes_on_when_the_recorder_is_gone() {
    let sizes = RingCapacities {
        records: Some(RECORDS),
        ..RingCapacities::default()
    };
    let (cycle, mut script) = controller(sizes);
    let timeline = VirtualTimeline::new(cycle, Vec::new()).unwrap();
    script.records = None;
    for _ in 0..200 {
        timeline.advance();
    }
    assert_eq!(script.snapshot.read().cycle, 200);
}

#[test]
fn a_record_ring_that_cannot_hold_one_cycle_is_an_error() {
    let (cycle, _script) = controller(RingCapacities {
        records: Some(8),
        ..RingCapacities::default()
    });
    let error = VirtualTimeline::new(cycle, Vec::new()).err().unwrap();
    assert!(matches!(
        error,
        ConfigError::RingTooSmall {
            ref ring,
            given: 8,
            ..
        } if *ring == "record"
    ));
}

#[test]
fn an_idle_virtual_clock_keeps_wall_pace_until_somebody_drives_it() {
    let (cycle, script) = controller(RingCapacities {
        records: None,
        ..RingCapacities::default()
    });
    let timeline = Arc::new(VirtualTimeline::new(cycle, Vec::new()).unwrap());
    let pacer = IdlePacer::start(timeline.clone()).unwrap();
    let begin = Instant::now();
    while script.snapshot.read().cycle < 50 {
        assert!(begin.elapsed() < Duration::from_secs(5));
        thread::sleep(Duration::from_millis(1));
    }
    assert!(
        begin.elapsed() > Duration::from_millis(190),
        "{:?}",
        begin.elapsed()
    );
    timeline.set_driven(true);
    thread::sleep(Duration::from_millis(20));
    let driven = script.snapshot.read().cycle;
    thread::sleep(Duration::from_millis(50));
    assert_eq!(script.snapshot.read().cycle, driven);
    timeline.advance();
    assert_eq!(script.snapshot.read().cycle, driven + 1);
    timeline.set_driven(false);
    thread::sleep(Duration::from_millis(100));
    assert!(script.snapshot.read().cycle > driven + 3);
    drop(pacer);
    let end = script.snapshot.read().cycle;
    thread::sleep(Duration::from_millis(20));
    assert_eq!(script.snapshot.read().cycle, end);
}

#[test]
fn the_motion_thread_keeps_wall_time_and_wakes_its_listeners() {
    let (cycle, mut script) = controller(RingCapacities {
        records: None,
        ..RingCapacities::default()
    });
    let thread = MotionThread::start(cycle, plain()).unwrap();
    assert!(thread.warnings().is_empty());
    let mut q = ideal("cs66").home;
    q[0] += 0.1;
    let id = script.commands.send(Origin::default(), movej(q)).unwrap();
    let begin = Instant::now();
    let ended = loop {
        thread::park_timeout(Duration::from_secs(5));
        assert!(begin.elapsed() < Duration::from_secs(10));
        if let Some(event) = script.events.next_event() {
            break event;
        }
    };
    let Event::Ended {
        id: done,
        outcome: Outcome::Done,
        cycle,
    } = ended
    else {
        panic!("{ended:?}");
    };
    assert_eq!(done, id);
    assert!(begin.elapsed().as_secs_f64() > 0.8 * cycle as f64 * 0.004);
    let state = script.snapshot.read();
    assert!(state.step_duration_us > 0.0);
    assert!(thread.stop().is_some());
}

#[test]
fn the_motion_thread_comes_to_rest_before_it_ends() {
    let (cycle, mut script) = controller(RingCapacities {
        records: None,
        ..RingCapacities::default()
    });
    let thread = MotionThread::start(cycle, plain()).unwrap();
    let far = JointPositions([2.0, -1.5, 1.5, -1.5, -1.5, 0.0]);
    script.commands.send(Origin::default(), movej(far)).unwrap();
    let begin = Instant::now();
    while script.snapshot.read().target_qd[0] < 0.2 {
        assert!(begin.elapsed() < Duration::from_secs(5));
        thread::sleep(Duration::from_millis(5));
    }
    let cycle = thread.stop().unwrap();
    let end = script.snapshot.read();
    assert!(cycle.is_standing());
    assert_eq!(end.motion_mode, MotionMode::Idle);
    assert_eq!(end.target_qd.max_abs(), 0.0);
    assert!(end.target_q[0] > 0.0 && end.target_q[0] < 1.0);
    assert!(matches!(
        script.events.next_event(),
        Some(Event::Ended {
            outcome: Outcome::Aborted,
            ..
        })
    ));
}

#[test]
fn what_the_system_refuses_is_a_warning_and_the_thread_runs() {
    let (cycle, script) = controller(RingCapacities {
        records: None,
        ..RingCapacities::default()
    });
    let options = RealtimeOptions {
        lock_memory: false,
        ..RealtimeOptions::default()
    };
    let thread = MotionThread::start(cycle, options).unwrap();
    for warning in thread.warnings() {
        assert!(warning.to_string().contains("priority 80"), "{warning}");
    }
    script
        .commands
        .send(Origin::default(), MachineCommand::Pause)
        .unwrap();
    let begin = Instant::now();
    while script.snapshot.read().cycle < 3 {
        assert!(begin.elapsed() < Duration::from_secs(5));
        thread::sleep(Duration::from_millis(1));
    }
}
