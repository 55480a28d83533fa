//! Any mixture of commands, and any numbers in them: every command ends once, every limit is kept, nothing panics.
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

use common::{Bench, ideal, movej};
use kinematics::{JointPositions, Payload, RpyPose};
use motion::CycleConfig;
use motion_api::{
    CommandId, CommandKind, MachineCommand, MotionCommand, SafetyMode, SettingCommand,
};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn any_command() -> impl Strategy<Value = CommandKind> {
    prop_oneof![
        4 => prop::array::uniform6(-2.0..2.0f64).prop_map(|q| movej(JointPositions(q))),
        1 => Just(CommandKind::Machine(MachineCommand::Stop { only: CommandId::NONE })),
        1 => Just(CommandKind::Machine(MachineCommand::Pause)),
        2 => Just(CommandKind::Machine(MachineCommand::Resume)),
        2 => (0.0..1.0f64).prop_map(|fraction| SettingCommand::SetSpeedFraction(fraction).into()),
        1 => Just(CommandKind::Machine(MachineCommand::PowerOff)),
        2 => Just(CommandKind::Machine(MachineCommand::PowerOn)),
        2 => Just(CommandKind::Machine(MachineCommand::ReleaseBrakes)),
        1 => Just(CommandKind::Machine(MachineCommand::UnlockProtectiveStop)),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, rng_seed: RngSeed::Fixed(1),
        ..Default::default() })]

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
        bench.send(MachineCommand::Resume);
        bench.send(SettingCommand::SetSpeedFraction(1.0));
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
                CommandKind::Motion(MotionCommand::MoveJ {
                    target: JointPositions(q),
                    acceleration,
                    speed,
                    duration,
                    radius: 0.0,
                })
            }
        ),
        (any_six(), any_number(), any_number(), any_number()).prop_map(
            |(p, acceleration, speed, duration)| {
                CommandKind::Motion(MotionCommand::MoveL {
                    target: RpyPose::from_array(p),
                    acceleration,
                    speed,
                    duration,
                    radius: 0.0,
                })
            }
        ),
        any_six()
            .prop_map(|p| CommandKind::Setting(SettingCommand::SetTcp(RpyPose::from_array(p)))),
        (any_number(), any_six(), any_six()).prop_map(|(mass, c, inertia)| {
            CommandKind::Setting(SettingCommand::SetPayload(Payload {
                mass,
                cog: [c[0], c[1], c[2]].into(),
                inertia,
            }))
        }),
        any_number().prop_map(|fraction| SettingCommand::SetSpeedFraction(fraction).into()),
        (any::<u8>(), any::<bool>()).prop_map(|(index, level)| CommandKind::Setting(
            SettingCommand::SetStandardDigitalOut { index, level }
        )),
        any::<u64>().prop_map(|id| CommandKind::Machine(MachineCommand::Stop {
            only: CommandId(id % 20)
        })),
        any_command(),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, rng_seed: RngSeed::Fixed(1),
        ..Default::default() })]

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
        ids.push(bench.send(MachineCommand::Stop { only: CommandId::NONE }));
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
