//! The border seen from outside: what a tick puts out, rings that are full or too small, configurations that do not
//! fit.
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

use common::{ideal, movej};
use kinematics::{JointPositions, JointSpeeds};
use motion::constants::EVENT_RING_MIN;
use motion::{ConfigError, ControlLoop, CycleConfig, CycleTiming};
use motion_api::{
    CommandId, Event, MachineCommand, Origin, Record, RingCapacities, motion_channel,
};

fn far() -> JointPositions {
    let mut q = ideal("cs66").home;
    q[0] += 2.0;
    q[4] -= 1.0;
    q
}

#[test]
fn the_snapshot_already_shows_the_end_when_the_event_arrives() {
    let config = ideal("cs66");
    let (motion, mut script) = motion_channel(RingCapacities::default(), &config.first_state());
    let mut cycle = ControlLoop::new(config, motion).unwrap();
    script
        .commands
        .send(Origin::default(), movej(far()))
        .unwrap();
    for _ in 0..10_000 {
        cycle.tick(CycleTiming::default());
        if let Some(Event::Ended { cycle, .. }) = script.events.next_event() {
            let state = script.snapshot.read();
            assert_eq!(state.cycle, cycle);
            assert_eq!(state.target_q, far());
            return;
        }
    }
    panic!("no end");
}

#[test]
fn one_tick_makes_one_cycle_record_and_one_for_each_command() {
    let config = ideal("cs66");
    let (motion, mut script) = motion_channel(RingCapacities::default(), &config.first_state());
    let mut cycle = ControlLoop::new(config, motion).unwrap();
    for _ in 0..100 {
        script
            .commands
            .send(Origin::default(), MachineCommand::Resume)
            .unwrap();
    }
    let mut commands = 0;
    for tick in 1..=3 {
        cycle.tick(CycleTiming::default());
        let mut cycles = 0;
        while let Some(record) = script.records.as_mut().unwrap().next_record() {
            match record {
                Record::Cycle(state) => {
                    cycles += 1;
                    assert_eq!(state.cycle, tick);
                }
                Record::Command { cycle, command } => {
                    commands += 1;
                    assert_eq!((cycle, command.id.0), (tick, commands));
                }
                Record::Points { .. } => panic!("no moveml was sent"),
                Record::Registers { .. } => panic!("no register was written"),
            }
        }
        assert_eq!(cycles, 1);
    }
    assert_eq!(commands, 100);
}

#[test]
fn commands_wait_until_their_ends_have_room_and_none_is_lost() {
    let sizes = RingCapacities {
        commands: 1024,
        events: EVENT_RING_MIN + 8,
        records: None,
        frames: 0,
        ..RingCapacities::default()
    };
    let config = ideal("cs66");
    let (motion, mut script) = motion_channel(sizes, &config.first_state());
    let mut cycle = ControlLoop::new(config, motion).unwrap();
    for _ in 0..1000 {
        script
            .commands
            .send(
                Origin::default(),
                MachineCommand::Stop {
                    only: CommandId::NONE,
                },
            )
            .unwrap();
    }
    let mut ended = Vec::new();
    for tick in 0..2000 {
        cycle.tick(CycleTiming::default());
        // A slow reader: nothing at all for a while, then one event a cycle.
        if tick > 100
            && let Some(Event::Ended { id, .. }) = script.events.next_event()
        {
            ended.push(id.0);
        }
    }
    assert_eq!(ended, (1..=1000).collect::<Vec<_>>());
}

#[test]
fn a_full_record_ring_counts_losses_and_does_not_wait() {
    let sizes = RingCapacities {
        records: Some(10),
        ..RingCapacities::default()
    };
    let config = ideal("cs66");
    let (motion, script) = motion_channel(sizes, &config.first_state());
    let mut cycle = ControlLoop::new(config, motion).unwrap();
    for _ in 0..15 {
        cycle.tick(CycleTiming::default());
    }
    assert_eq!(script.snapshot.read().records_lost, 4);
}

#[test]
fn a_border_too_small_for_its_promises_is_an_error() {
    let config = ideal("cs66");
    let sizes = RingCapacities {
        events: 4,
        ..RingCapacities::default()
    };
    let (motion, _script) = motion_channel(sizes, &config.first_state());
    let error = ControlLoop::new(config, motion).err().unwrap();
    assert!(matches!(
        error,
        ConfigError::RingTooSmall {
            ref ring,
            given: 4,
            ..
        } if *ring == "event"
    ));
}

#[test]
fn configurations_that_do_not_fit_are_errors_that_name_the_setting() {
    type Change = fn(&mut CycleConfig);
    let broken: [(Change, &str); 5] = [
        (|c| c.step_time = 0.01, "0.01 s"),
        (|c| c.home[2] = 4.0, "joint 3"),
        (
            |c| c.limits.joint_speed = Some(JointSpeeds([99.0; 6])),
            "joint_speed",
        ),
        (|c| c.limits.tcp_speed = Some(0.0), "tcp_speed"),
        (
            |c| c.limits.joint_position_min = Some(JointPositions([0.0; 6])),
            "home puts joint 2",
        ),
    ];
    for (change, expected) in broken {
        let mut config = ideal("cs66");
        change(&mut config);
        let message = config.resolve().unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
}
