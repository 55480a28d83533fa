//! Lines past singular positions: slowed smoothly, within every limit, on the line, and hardly slower than the joints
//! make them.
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

use common::{Bench, MODELS, ideal, movej, tcp_speed, turning_points};
use kinematics::{JointPositions, Pose, RpyPose};
use motion_api::{MotionCommand, Outcome};
use nalgebra::Vector3;

/// A line sideways through a place where the wrist is `beside` rad from straight and gets no nearer to it; the arm
/// stands at its beginning.
fn line_past_the_wrist(bench: &mut Bench, beside: f64, half: f64) -> RpyPose {
    let model = bench_model(bench);
    let straight = JointPositions([0.3, -1.3, 1.7, -1.9, 0.0, 0.2]);
    let singular = model.tcp_pose(&straight, &Pose::IDENTITY);
    let radial = Vector3::new(0.3_f64.cos(), 0.3_f64.sin(), 0.0);
    let tilt = nalgebra::Rotation3::new(radial * beside);
    let middle = Pose::new(tilt * singular.rotation, singular.translation);
    let near = JointPositions([0.3, -1.3, 1.7, -1.9, beside, 0.2]);
    let q = model
        .inverse_nearest(&middle, &Pose::IDENTITY, &near)
        .expect("the middle is in reach");
    let along = Vector3::z().cross(&radial);
    let at = |way: f64| Pose::new(middle.rotation, middle.translation + along * way);
    let mut start = q;
    for step in 1..=200 {
        let pose = at(-half * f64::from(step) / 200.0);
        start = model
            .inverse_continuous(&pose, &Pose::IDENTITY, &start)
            .expect("the beginning is in reach");
    }
    assert_eq!(bench.do_it(movej(start)), Outcome::Done);
    at(half).to_rpy()
}

fn bench_model(bench: &Bench) -> kinematics::RobotModel {
    kinematics::RobotModel::built_in(bench.model).unwrap()
}

#[test]
fn past_a_singular_position_the_arm_slows_down_smoothly_and_no_longer_than_it_must() {
    const HALF: f64 = 0.12;
    for name in MODELS {
        for beside in [0.1, 0.03] {
            let mut bench = Bench {
                model: name,
                ..Bench::new(ideal(name))
            };
            let end = line_past_the_wrist(&mut bench, beside, HALF);
            let from = bench.states.len();
            let outcome = bench.do_it(MotionCommand::MoveL {
                target: end,
                acceleration: 1.2,
                speed: 0.5,
                duration: 0.0,
                radius: 0.0,
            });
            assert_eq!(outcome, Outcome::Done, "{name} {beside}");
            bench.check_limits();
            let speeds: Vec<f64> = bench.states[from..].iter().map(tcp_speed).collect();
            // Down once and up once, with a ripple or two where joints take turns at their limits; not in steps.
            let fastest = speeds.iter().fold(0.0_f64, |m, x| m.max(*x));
            let turns = turning_points(&speeds, 0.01 * fastest);
            assert!(turns <= 8, "{name} {beside}: {turns} turns");
            if beside < 0.05 {
                let middle = &speeds[speeds.len() / 4..3 * speeds.len() / 4];
                let lowest = middle.iter().fold(f64::INFINITY, |m, x| m.min(*x));
                let even = 2.0 * HALF / lowest;
                let took = speeds.len() as f64 * 0.004;
                assert!(took < even, "{name}: {took} s, {even} s evenly");
            }
        }
    }
}
