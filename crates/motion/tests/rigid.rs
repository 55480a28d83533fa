//! The rigid arm: it follows closely, carries what the model says, and is the same every time.
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

use common::{Bench, MODELS, movej};
use kinematics::{JointPositions, Payload, RobotModel};
use motion::CycleConfig;
use motion::constants::{PEAK_TORQUE_FACTOR, PLANNED_TORQUE_SHARE};
use motion_api::{MotionCommand, Outcome, SettingCommand};

fn rigid(model: &str) -> CycleConfig {
    CycleConfig::new(RobotModel::built_in(model).unwrap())
}

fn loaded(model: &str) -> CycleConfig {
    let mut config = rigid(model);
    let rated = config.model.rated_payload_kg().unwrap();
    config.payload = Payload::new(rated, [0.0, 0.0, 0.05], [0.0; 6]).unwrap();
    config
}

const TOUR: [[f64; 6]; 4] = [
    [1.2, -1.0, 1.2, -1.8, -1.2, 0.5],
    [-0.8, -2.0, 2.0, -1.0, -2.0, -1.0],
    [0.3, -0.6, 0.9, -0.4, 1.0, 2.0],
    [0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0],
];

#[test]
fn the_arm_follows_default_motions_with_its_rated_payload_within_half_a_milliradian() {
    for model in MODELS {
        let mut bench = Bench::new(loaded(model));
        for q in TOUR {
            let outcome = bench.do_it(movej(JointPositions(q)));
            assert_eq!(outcome, Outcome::Done, "{model} {:?}", bench.stops);
            let end = bench.now();
            for joint in 0..6 {
                assert!((end.actual_q[joint] - end.target_q[joint]).abs() < 1e-3);
            }
        }
        let mut errors: Vec<f64> = bench
            .states
            .iter()
            .map(|s| (0..6).fold(0.0_f64, |m, j| m.max((s.actual_q[j] - s.target_q[j]).abs())))
            .collect();
        errors.sort_by(f64::total_cmp);
        let p99 = errors[errors.len() * 99 / 100];
        println!(
            "{model}: tracking error p50 {:.2e} p99 {p99:.2e} max {:.2e}",
            errors[errors.len() / 2],
            errors.last().unwrap()
        );
        assert!(p99 < 0.5e-3, "{model}: {p99}");
    }
}

#[test]
fn a_standing_arm_carries_its_gravity_torques() {
    for model in MODELS {
        let mut bench = Bench::new(loaded(model));
        bench.run(50);
        let state = bench.now();
        for joint in 0..6 {
            let off = state.actual_torque[joint] - state.target_torque[joint];
            assert!(
                off.abs() < 1e-6 * (1.0 + state.target_torque[joint].abs()),
                "{model} {joint} {off}"
            );
            assert!((state.actual_q[joint] - state.target_q[joint]).abs() < 1e-9);
        }
    }
}

#[test]
fn the_masses_of_the_engine_are_those_of_the_model() {
    // A payload that the servo does not know of makes the arm sag by M^-1 (what is missing) / Kp: if engine and model
    // disagreed about any mass, a standing arm would show it as well.
    let mut bench = Bench::new(rigid("cs66"));
    bench.run(10);
    let before = bench.now();
    let payload = Payload::new(5.0, [0.02, 0.0, 0.1], [0.01, 0.01, 0.01, 0.0, 0.0, 0.0]).unwrap();
    assert_eq!(
        bench.do_it(SettingCommand::SetPayload(payload)),
        Outcome::Done
    );
    bench.run(50);
    let after = bench.now();
    assert!((after.actual_torque[1] - before.actual_torque[1]).abs() > 5.0);
    for joint in 0..6 {
        assert!((after.actual_q[joint] - after.target_q[joint]).abs() < 1e-7);
        assert!((after.actual_torque[joint] - after.target_torque[joint]).abs() < 1e-3);
    }
}

#[test]
fn the_same_commands_give_the_same_records_bit_for_bit() {
    let run = || {
        let mut bench = Bench::new(loaded("cs612"));
        for q in &TOUR[..2] {
            bench.do_it(movej(JointPositions(*q)));
        }
        bench.states
    };
    let (first, second) = (run(), run());
    assert_eq!(first.len(), second.len());
    for (a, b) in first.iter().zip(&second) {
        assert_eq!(format!("{a:?}"), format!("{b:?}"));
        for joint in 0..6 {
            assert_eq!(a.actual_q[joint].to_bits(), b.actual_q[joint].to_bits());
            assert_eq!(
                a.actual_torque[joint].to_bits(),
                b.actual_torque[joint].to_bits()
            );
        }
    }
}

#[test]
fn moving_joints_carry_what_the_model_says() {
    for model in MODELS {
        let mut bench = Bench::new(loaded(model));
        bench.do_it(movej(JointPositions(TOUR[0])));
        bench.do_it(movej(JointPositions(TOUR[1])));
        let effort = RobotModel::built_in(model).unwrap().limits().effort;
        for state in &bench.states[1..] {
            for joint in 0..6 {
                let off = (state.actual_torque[joint] - state.target_torque[joint]).abs();
                assert!(
                    off < 0.02 * effort[joint],
                    "{model} joint {joint} {off} of {}",
                    effort[joint]
                );
            }
        }
    }
}

#[test]
fn the_hardest_motions_asked_for_are_slowed_to_what_the_drives_can_do() {
    for model in MODELS {
        let mut bench = Bench::new(loaded(model));
        // From stretched out to the other side and back up, as fast as anybody can ask.
        for q in [
            [0.0, -0.2, 0.1, -1.5708, -1.5708, 0.0],
            [2.5, -0.2, 0.1, -1.5708, -1.5708, 0.0],
            [2.5, -1.5708, 0.0, -1.5708, 0.0, 2.0],
            [0.0, -2.9, 0.0, 0.0, 1.0, 0.0],
            [0.5, -2.9, 0.0, -1.0, 1.0, 1.0],
            [0.5, -0.2, 0.0, -1.0, 1.0, 1.0],
            [0.5, -0.6, 0.4, -1.5, 1.0, 1.0],
        ] {
            let outcome = bench.do_it(MotionCommand::MoveJ {
                target: JointPositions(q),
                acceleration: 1000.0,
                speed: 1000.0,
                duration: 0.0,
                radius: 0.0,
            });
            assert_eq!(outcome, Outcome::Done, "{model} {:?}", bench.stops);
        }
        let effort = RobotModel::built_in(model).unwrap().limits().effort;
        let (mut off, mut most) = (0.0_f64, 0.0_f64);
        for state in &bench.states {
            for joint in 0..6 {
                off = off.max((state.actual_q[joint] - state.target_q[joint]).abs());
                most = most.max(state.target_torque[joint].abs() / effort[joint]);
            }
        }
        println!("{model}: {most:.2} of the nominal torque, {off:.1e} rad off");
        assert!(off < 1e-4, "{model} {off}");
        assert!(
            most <= 1.02 * PEAK_TORQUE_FACTOR * PLANNED_TORQUE_SHARE,
            "{model} {most}"
        );
        bench.check_limits();
    }
}
