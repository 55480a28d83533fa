//! What commands do to a controller: ends, stops, pauses, the speed slider, power, protective stops, the border.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]
#![allow(
    clippy::approx_constant,
    reason = "joint angles and speeds as people type them"
)]

mod common;

use common::{Bench, ideal, movej};
use kinematics::{JointPositions, JointSpeeds, Payload, RpyPose};
use motion::{ConfigError, Cycle, CycleConfig, Timing};
use motion_api::{
    BorderSizes, CommandId, CommandKind, Event, MotionMode, Origin, Outcome, Record, Refusal,
    RobotMode, SafetyMode, StopReason, border,
};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn far() -> JointPositions {
    let mut q = ideal("cs66").home;
    q[0] += 2.0;
    q[4] -= 1.0;
    q
}

fn moving(cycles: usize) -> (Bench, CommandId) {
    let mut bench = Bench::new(ideal("cs66"));
    let id = bench.send(movej(far()));
    bench.run(cycles);
    (bench, id)
}

#[test]
fn a_second_motion_is_refused_while_one_runs() {
    let (mut bench, running) = moving(10);
    let outcome = bench.do_it(movej(far()));
    assert_eq!(outcome, Outcome::Refused(Refusal::Busy { running }));
    assert_eq!(bench.finish(running), Outcome::Done);
}

#[test]
fn a_stop_brakes_on_the_path_and_aborts_the_motion() {
    let (mut bench, id) = moving(150);
    let stop = bench.send(CommandKind::Stop {
        only: CommandId::NONE,
    });
    bench.tick();
    assert_eq!(bench.now().motion_mode, MotionMode::Stopping);
    assert_eq!(bench.finish(stop), Outcome::Done);
    assert_eq!(bench.outcome(id), Some(Outcome::Aborted));
    let (start, end) = (bench.states[0].target_q, bench.now());
    assert_eq!(end.target_qd, JointSpeeds::ZERO);
    let s = (end.target_q[0] - start[0]) / 2.0;
    assert!(s > 0.1 && s < 0.9);
    assert!((end.target_q[4] - (start[4] - s)).abs() < 1e-12);
    bench.check_limits();
    assert_eq!(bench.do_it(movej(far())), Outcome::Done);
}

#[test]
fn a_stop_for_another_motion_changes_nothing() {
    let (mut bench, id) = moving(50);
    let stop = CommandKind::Stop {
        only: CommandId(id.0 + 100),
    };
    assert_eq!(bench.do_it(stop), Outcome::Done);
    assert_eq!(bench.now().motion_mode, MotionMode::MoveJ);
    assert_eq!(bench.finish(id), Outcome::Done);
}

#[test]
fn a_stop_at_rest_is_done_at_once() {
    let mut bench = Bench::new(ideal("cs66"));
    bench.do_it(CommandKind::Stop {
        only: CommandId::NONE,
    });
    assert_eq!(bench.now().cycle, 1);
}

#[test]
fn a_pause_holds_on_the_path_and_a_resume_goes_on_to_the_end() {
    let (mut bench, id) = moving(150);
    let pause = bench.send(CommandKind::Pause);
    assert_eq!(bench.finish(pause), Outcome::Done);
    assert_eq!(bench.now().motion_mode, MotionMode::Paused);
    assert_eq!(bench.now().speed_scaling, 0.0);
    let held = bench.now().target_q;
    bench.run(100);
    assert_eq!(bench.now().target_q, held);
    assert_eq!(bench.outcome(id), None);
    assert_eq!(bench.do_it(CommandKind::Resume), Outcome::Done);
    assert_eq!(bench.finish(id), Outcome::Done);
    assert_eq!(bench.now().target_q, far());
    bench.check_limits();
}

#[test]
fn a_resume_ends_a_pause_that_has_not_come_to_rest() {
    let (mut bench, id) = moving(150);
    let pause = bench.send(CommandKind::Pause);
    bench.run(3);
    bench.do_it(CommandKind::Resume);
    assert_eq!(bench.outcome(pause), Some(Outcome::Done));
    assert_eq!(bench.finish(id), Outcome::Done);
    bench.check_limits();
}

#[test]
fn a_stop_ends_a_paused_motion() {
    let (mut bench, id) = moving(150);
    bench.do_it(CommandKind::Pause);
    assert_eq!(bench.do_it(CommandKind::Stop { only: id }), Outcome::Done);
    assert_eq!(bench.outcome(id), Some(Outcome::Aborted));
    assert_eq!(bench.now().motion_mode, MotionMode::Idle);
}

#[test]
fn a_motion_sent_while_paused_waits_for_the_resume() {
    let mut bench = Bench::new(ideal("cs66"));
    bench.do_it(CommandKind::Pause);
    let id = bench.send(movej(far()));
    bench.run(20);
    assert_eq!(bench.now().target_q, bench.states[0].target_q);
    bench.send(CommandKind::Resume);
    assert_eq!(bench.finish(id), Outcome::Done);
}

#[test]
fn half_the_speed_takes_twice_the_time_on_the_same_path() {
    let cycles = |fraction| {
        let mut bench = Bench::new(ideal("cs66"));
        bench.do_it(CommandKind::SetSpeedFraction(fraction));
        bench.do_it(movej(far()));
        assert_eq!(bench.now().target_q, far());
        bench.now().cycle as f64
    };
    assert!((cycles(0.5) - 2.0 * cycles(1.0)).abs() <= 2.0);
}

#[test]
fn the_speed_slider_works_during_a_motion_and_zero_holds_it() {
    let (mut bench, id) = moving(100);
    for fraction in [0.3, 1.0, 0.0, 0.1, 0.7] {
        bench.do_it(CommandKind::SetSpeedFraction(fraction));
        bench.run(210);
        assert_eq!(bench.now().speed_scaling, fraction);
        assert_eq!(bench.now().target_speed_fraction, fraction);
        let speed = bench.now().target_qd[0];
        assert!(speed <= 1.047197 * fraction + 1e-9, "{speed} at {fraction}");
    }
    assert_eq!(bench.finish(id), Outcome::Done);
    bench.check_limits();
}

#[test]
fn power_off_brings_the_arm_to_rest_first() {
    let (mut bench, id) = moving(150);
    assert_eq!(bench.do_it(CommandKind::PowerOff), Outcome::Done);
    assert_eq!(bench.outcome(id), Some(Outcome::Aborted));
    assert_eq!(bench.now().robot_mode, RobotMode::PowerOff);
    assert_eq!(bench.now().motion_mode, MotionMode::PoweredOff);
    bench.check_limits();
    let refused = bench.do_it(movej(far()));
    assert!(matches!(
        refused,
        Outcome::Refused(Refusal::NotReady {
            robot_mode: RobotMode::PowerOff,
            ..
        })
    ));
}

#[test]
fn a_powered_off_controller_runs_after_power_on_and_brake_release() {
    let mut bench = Bench::new(CycleConfig {
        powered_off: true,
        ..ideal("cs66")
    });
    let refused = bench.do_it(CommandKind::ReleaseBrakes);
    assert!(matches!(
        refused,
        Outcome::Refused(Refusal::WrongMode { .. })
    ));
    bench.do_it(CommandKind::PowerOn);
    assert_eq!(bench.now().robot_mode, RobotMode::PowerOn);
    bench.run(100);
    assert_eq!(bench.now().robot_mode, RobotMode::Idle);
    bench.do_it(CommandKind::ReleaseBrakes);
    bench.run(75);
    assert_eq!(bench.now().robot_mode, RobotMode::Running);
    assert_eq!(bench.do_it(movej(far())), Outcome::Done);
}

#[test]
fn an_emergency_stop_brakes_the_arm_takes_its_power_and_ends_when_it_is_released() {
    let mut bench = Bench::new(ideal("cs66"));
    let motion = bench.send(movej(far()));
    bench.run(60);
    assert!(bench.now().target_qd.max_abs() > 0.1);
    bench.send(CommandKind::EmergencyStop { pressed: true });
    bench.tick();
    assert_eq!(bench.now().safety_mode, SafetyMode::RobotEmergencyStop);
    assert_eq!(
        bench.now().robot_mode,
        RobotMode::Running,
        "the servos brake"
    );
    bench.run(300);
    bench.check_limits();
    assert_eq!(bench.stops, [StopReason::EmergencyStop]);
    let outcome = bench.ended.iter().find(|(id, ..)| *id == motion).unwrap().1;
    assert_eq!(outcome, Outcome::ProtectiveStop(StopReason::EmergencyStop));
    assert_eq!(bench.now().robot_mode, RobotMode::PowerOff);
    assert_eq!(bench.now().target_qd.max_abs(), 0.0);

    let refused = bench.do_it(CommandKind::PowerOn);
    assert!(matches!(
        refused,
        Outcome::Refused(Refusal::NotReady { .. })
    ));
    bench.do_it(CommandKind::EmergencyStop { pressed: false });
    assert_eq!(bench.now().safety_mode, SafetyMode::Normal);
    assert_eq!(bench.now().robot_mode, RobotMode::PowerOff);
    bench.do_it(CommandKind::PowerOn);
    bench.do_it(CommandKind::ReleaseBrakes);
    bench.run(200);
    assert_eq!(bench.now().robot_mode, RobotMode::Running);
    assert_eq!(bench.do_it(movej(far())), Outcome::Done);
}

#[test]
fn tool_payload_and_outputs_show_in_the_state() {
    let mut bench = Bench::new(ideal("cs66"));
    let before = bench.tick();
    let tcp = RpyPose::from_array([0.0, 0.0, 0.1, 0.0, 0.0, 0.0]);
    bench.do_it(CommandKind::SetTcp(tcp));
    let payload = Payload::new(2.0, [0.0, 0.0, 0.05], [0.0; 6]).unwrap();
    bench.do_it(CommandKind::SetPayload(payload));
    bench.do_it(CommandKind::SetStandardDigitalOut {
        index: 3,
        level: true,
    });
    let state = bench.tick();
    assert_eq!(state.tcp_offset, tcp);
    assert_eq!(state.payload, payload);
    assert_eq!(state.digital_out, 1 << 3);
    let moved: f64 = (0..3)
        .map(|i| (state.target_tcp_pose.xyz[i] - before.target_tcp_pose.xyz[i]).powi(2))
        .sum();
    assert!((moved.sqrt() - 0.1).abs() < 1e-12);
    assert!((state.target_torque[1] - before.target_torque[1]).abs() > 1.0);
    bench.do_it(CommandKind::SetStandardDigitalOut {
        index: 3,
        level: false,
    });
    assert_eq!(bench.now().digital_out, 0);
}

#[test]
fn impossible_settings_are_refused_and_change_nothing() {
    let mut bench = Bench::new(ideal("cs66"));
    let nan = RpyPose::from_array([f64::NAN, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let heavy = Payload {
        mass: -1.0,
        ..Payload::NONE
    };
    let flat = Payload {
        inertia: [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        ..Payload::NONE
    };
    for kind in [
        CommandKind::SetTcp(nan),
        CommandKind::SetPayload(heavy),
        CommandKind::SetPayload(flat),
        CommandKind::SetStandardDigitalOut {
            index: 16,
            level: true,
        },
        CommandKind::SetSpeedFraction(1.01),
        CommandKind::SetSpeedFraction(f64::NAN),
    ] {
        let outcome = bench.do_it(kind);
        assert!(
            matches!(outcome, Outcome::Refused(Refusal::BadValue { .. })),
            "{outcome:?}"
        );
    }
    let state = bench.tick();
    assert_eq!(state.payload, Payload::NONE);
    assert_eq!(state.tcp_offset, RpyPose::default());
    assert_eq!(state.digital_out, 0);
}

#[test]
fn the_snapshot_already_shows_the_end_when_the_event_arrives() {
    let config = ideal("cs66");
    let (motion, mut script) = border(BorderSizes::default(), &config.first_state());
    let mut cycle = Cycle::new(config, motion).unwrap();
    script
        .commands
        .send(Origin::default(), movej(far()))
        .unwrap();
    for _ in 0..10_000 {
        cycle.tick(Timing::default());
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
    let (motion, mut script) = border(BorderSizes::default(), &config.first_state());
    let mut cycle = Cycle::new(config, motion).unwrap();
    for _ in 0..100 {
        script
            .commands
            .send(Origin::default(), CommandKind::Resume)
            .unwrap();
    }
    let mut commands = 0;
    for tick in 1..=3 {
        cycle.tick(Timing::default());
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
                Record::Registers { .. } => panic!("no register was written"),
            }
        }
        assert_eq!(cycles, 1);
    }
    assert_eq!(commands, 100);
}

#[test]
fn commands_wait_until_their_ends_have_room_and_none_is_lost() {
    let sizes = BorderSizes {
        commands: 1024,
        events: 40,
        records: None,
        frames: 0,
    };
    let config = ideal("cs66");
    let (motion, mut script) = border(sizes, &config.first_state());
    let mut cycle = Cycle::new(config, motion).unwrap();
    for _ in 0..1000 {
        script
            .commands
            .send(
                Origin::default(),
                CommandKind::Stop {
                    only: CommandId::NONE,
                },
            )
            .unwrap();
    }
    let mut ended = Vec::new();
    for tick in 0..2000 {
        cycle.tick(Timing::default());
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
    let sizes = BorderSizes {
        records: Some(10),
        ..BorderSizes::default()
    };
    let config = ideal("cs66");
    let (motion, script) = border(sizes, &config.first_state());
    let mut cycle = Cycle::new(config, motion).unwrap();
    for _ in 0..15 {
        cycle.tick(Timing::default());
    }
    assert_eq!(script.snapshot.read().records_lost, 4);
}

#[test]
fn a_border_too_small_for_its_promises_is_an_error() {
    let config = ideal("cs66");
    let sizes = BorderSizes {
        events: 4,
        ..BorderSizes::default()
    };
    let (motion, _script) = border(sizes, &config.first_state());
    let error = Cycle::new(config, motion).err().unwrap();
    assert!(matches!(
        error,
        ConfigError::RingTooSmall {
            ring: "event",
            given: 4,
            ..
        }
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

fn any_command() -> impl Strategy<Value = CommandKind> {
    prop_oneof![
        4 => prop::array::uniform6(-2.0..2.0f64).prop_map(|q| movej(JointPositions(q))),
        1 => Just(CommandKind::Stop { only: CommandId::NONE }),
        1 => Just(CommandKind::Pause),
        2 => Just(CommandKind::Resume),
        2 => (0.0..1.0f64).prop_map(CommandKind::SetSpeedFraction),
        1 => Just(CommandKind::PowerOff),
        2 => Just(CommandKind::PowerOn),
        2 => Just(CommandKind::ReleaseBrakes),
        1 => Just(CommandKind::UnlockProtectiveStop),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, rng_seed: RngSeed::Fixed(1), ..Default::default() })]

    #[test]
    fn any_sequence_of_commands_keeps_the_limits_and_every_command_ends_once(
        orders in prop::collection::vec((any_command(), 0usize..200), 1..40),
    ) {
        let mut bench = Bench::new(ideal("cs66"));
        let mut ids = Vec::new();
        for (kind, cycles) in orders {
            ids.push(bench.send(kind));
            bench.run(cycles);
        }
        bench.send(CommandKind::Resume);
        bench.send(CommandKind::SetSpeedFraction(1.0));
        for id in ids {
            bench.finish(id);
        }
        prop_assert!(bench.stops.is_empty(), "{:?}", bench.stops);
        prop_assert_eq!(bench.now().safety_mode, SafetyMode::Normal);
        bench.check_limits();
    }
}

/// Numbers as a broken or hostile sender makes them.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        2 => any::<f64>(),
        3 => -4.0..4.0f64,
        1 => prop::sample::select(vec![0.0, -0.0, 1e-300, 5e-324, 1e300, f64::MAX, f64::NAN, f64::INFINITY, 1e-6, 1e6]),
    ]
}

fn any_six() -> impl Strategy<Value = [f64; 6]> {
    prop_oneof![
        prop::array::uniform6(any_number()),
        prop::array::uniform6(-2.0..2.0f64),
    ]
}

fn wild_command() -> impl Strategy<Value = CommandKind> {
    prop_oneof![
        (any_six(), any_number(), any_number(), any_number()).prop_map(
            |(q, acceleration, speed, duration)| {
                CommandKind::MoveJ {
                    target: JointPositions(q),
                    acceleration,
                    speed,
                    duration,
                    radius: 0.0,
                }
            }
        ),
        (any_six(), any_number(), any_number(), any_number()).prop_map(
            |(p, acceleration, speed, duration)| {
                CommandKind::MoveL {
                    target: RpyPose::from_array(p),
                    acceleration,
                    speed,
                    duration,
                    radius: 0.0,
                }
            }
        ),
        any_six().prop_map(|p| CommandKind::SetTcp(RpyPose::from_array(p))),
        (any_number(), any_six(), any_six()).prop_map(|(mass, c, inertia)| {
            CommandKind::SetPayload(Payload {
                mass,
                cog: [c[0], c[1], c[2]].into(),
                inertia,
            })
        }),
        any_number().prop_map(CommandKind::SetSpeedFraction),
        (any::<u8>(), any::<bool>())
            .prop_map(|(index, level)| CommandKind::SetStandardDigitalOut { index, level }),
        any::<u64>().prop_map(|id| CommandKind::Stop {
            only: CommandId(id % 20)
        }),
        any_command(),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, rng_seed: RngSeed::Fixed(1), ..Default::default() })]

    #[test]
    fn no_numbers_whatever_break_the_controller(
        orders in prop::collection::vec((wild_command(), 0usize..40), 1..40),
        rigid in any::<bool>(),
    ) {
        let plant = if rigid { motion::PlantKind::Rigid } else { motion::PlantKind::Ideal };
        let mut bench = Bench::new(CycleConfig { plant, ..ideal("cs66") });
        let mut ids = Vec::new();
        for (kind, cycles) in orders {
            ids.push(bench.send(kind));
            bench.run(cycles);
        }
        ids.push(bench.send(CommandKind::Stop { only: CommandId::NONE }));
        for id in ids {
            bench.finish(id);
        }
        for state in &bench.states {
            prop_assert!(state.target_q.is_finite() && state.actual_q.is_finite());
            prop_assert!(state.target_torque.is_finite() && state.actual_torque.is_finite());
            prop_assert!(state.target_tcp_pose.is_finite() && state.actual_tcp_pose.is_finite());
        }
        prop_assert!(
            !bench.stops.iter().any(|s| matches!(s, motion_api::StopReason::Internal { .. })),
            "{:?}", bench.stops
        );
    }
}
