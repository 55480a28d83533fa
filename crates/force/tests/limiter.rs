//! The joint-speed limiter: optimal by the conditions of optimality, never outside its bounds, whatever it is asked.
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot go on should say where"
)]

use force::{LimiterError, SolveMethod, TwistLimiter, TwistProblem};
use kinematics::{JointPositions, JointSpeeds, Pose, RobotModel};
use nalgebra::{Matrix6, Vector6};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::sync::OnceLock;

fn arm() -> &'static RobotModel {
    static ARM: OnceLock<RobotModel> = OnceLock::new();
    ARM.get_or_init(|| RobotModel::built_in("cs66").unwrap())
}

fn jacobian(q: &JointPositions) -> Matrix6<f64> {
    arm().tcp_pose_and_jacobian(q, &Pose::IDENTITY).1
}

const MIDDLE: JointPositions = JointPositions([0.3, -1.2, 1.4, -1.6, -1.2, 0.5]);

/// From rest, each joint within ±0.04 rad/s, no limit on the twist.
fn problem(q: &JointPositions, wanted: [f64; 6]) -> TwistProblem {
    TwistProblem {
        jacobian: jacobian(q),
        desired_twist: wanted,
        weights: [1.0; 6],
        lower: JointSpeeds([-0.04; 6]),
        upper: JointSpeeds([0.04; 6]),
        limits: [f64::INFINITY; 6],
        current_speeds: JointSpeeds::ZERO,
    }
}

fn twist_of(problem: &TwistProblem, qd: &JointSpeeds) -> Vector6<f64> {
    problem.jacobian * Vector6::from(qd.0)
}

#[test]
fn a_twist_the_joints_can_do_is_done() {
    let mut limiter = TwistLimiter::new().unwrap();
    let wanted = [0.002, -0.001, 0.003, 0.004, 0.0, 0.002];
    let asked = problem(&MIDDLE, wanted);
    let found = limiter.solve(&asked).unwrap();
    assert_eq!(found.method, SolveMethod::Unconstrained);
    let off = (twist_of(&asked, &found.qd) - Vector6::from(wanted)).norm();
    assert!(off < 1e-6, "{off}");
}

#[test]
fn no_component_of_the_twist_exceeds_its_limit() {
    let mut limiter = TwistLimiter::new().unwrap();
    let mut asked = problem(&MIDDLE, [0.02, 0.0, -0.03, 0.0, 0.0, 0.0]);
    asked.limits[2] = 0.004;
    let found = limiter.solve(&asked).unwrap();
    assert_eq!(found.method, SolveMethod::QuadraticProgram);
    let twist = twist_of(&asked, &found.qd);
    assert!((twist[2] + 0.004).abs() < 1e-6, "{twist}");
}

#[test]
fn a_twist_that_is_too_fast_already_does_not_become_faster() {
    let mut limiter = TwistLimiter::new().unwrap();
    let mut asked = problem(&MIDDLE, [0.0, 0.0, 0.5, 0.0, 0.0, 0.0]);
    asked.current_speeds = JointSpeeds([0.02, -0.02, 0.01, 0.0, 0.02, 0.0]);
    asked.limits = [1e-4; 6];
    let before = twist_of(&asked, &asked.current_speeds);
    let found = limiter.solve(&asked).unwrap();
    let twist = twist_of(&asked, &found.qd);
    for k in 0..6 {
        assert!(twist[k].abs() <= before[k].abs().max(1e-4) + 2e-9);
    }
}

#[test]
fn a_component_that_is_too_fast_slows_down_as_fast_as_the_joints_can() {
    let mut limiter = TwistLimiter::new().unwrap();
    let mut asked = problem(&MIDDLE, [0.0; 6]);
    asked.current_speeds = JointSpeeds([0.02, -0.02, 0.01, 0.0, 0.02, 0.0]);
    asked.lower = asked.current_speeds.map(|x| x - 0.004);
    asked.upper = asked.current_speeds.map(|x| x + 0.004);
    asked.limits = [1e-4; 6];
    let before = twist_of(&asked, &asked.current_speeds);
    let found = limiter.solve(&asked).unwrap();
    assert_eq!(found.method, SolveMethod::QuadraticProgram);
    let twist = twist_of(&asked, &found.qd);
    assert!(twist.norm() < 0.9 * before.norm(), "{twist} {before}");
}

#[test]
fn a_singular_arm_gets_finite_speeds() {
    let mut limiter = TwistLimiter::new().unwrap();
    let q = JointPositions([0.0, -1.5, 0.0, -1.5, 0.0, 0.0]);
    let asked = problem(&q, [0.5, 0.5, 0.5, 1.0, 1.0, 1.0]);
    assert!(limiter.solve(&asked).unwrap().qd.is_finite());
}

#[test]
fn a_weight_of_zero_gives_a_component_up() {
    let mut limiter = TwistLimiter::new().unwrap();
    let mut asked = problem(&MIDDLE, [0.001, 0.0, 99.0, 0.0, 0.0, 0.0]);
    asked.weights[2] = 0.0;
    let found = limiter.solve(&asked).unwrap();
    let twist = twist_of(&asked, &found.qd);
    assert!((twist[0] - 0.001).abs() < 1e-4, "{twist}");
    assert!(twist[2].abs() < 0.1);
}

#[test]
fn unusable_input_is_an_error_that_names_it() {
    let mut limiter = TwistLimiter::new().unwrap();
    let mut asked = problem(&MIDDLE, [f64::NAN, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let error = limiter.solve(&asked);
    assert_eq!(
        error,
        Err(LimiterError::NotFinite {
            name: "wanted twist"
        })
    );
    asked.desired_twist = [0.0; 6];
    asked.limits[1] = f64::NAN;
    assert!(matches!(
        limiter.solve(&asked),
        Err(LimiterError::NotFinite {
            name: "twist limits"
        })
    ));
    asked.limits[1] = 0.0;
    asked.lower[4] = 0.05;
    let error = limiter.solve(&asked).unwrap_err().to_string();
    assert!(error.starts_with("joint 5 may be no slower"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, rng_seed: RngSeed::Fixed(1),
        ..Default::default() })]

    #[test]
    fn the_answer_is_optimal_and_within_its_bounds(
        q in prop::array::uniform6(-3.0..3.0f64),
        before in prop::array::uniform6(-3.0..3.0f64),
        width in 1e-4..0.1f64,
        wanted in prop::array::uniform6(-2.0..2.0f64),
    ) {
        let mut asked = problem(&JointPositions(q), wanted);
        asked.current_speeds = JointSpeeds(before);
        asked.lower = JointSpeeds(before.map(|x| x - width));
        asked.upper = JointSpeeds(before.map(|x| x + width));
        let found = TwistLimiter::new().unwrap().solve(&asked).unwrap();
        // Karush-Kuhn-Tucker: the gradient vanishes where a joint is free and points outwards where it is at a bound.
        let x = Vector6::from(found.qd.0);
        let j = asked.jacobian;
        let gradient = j.transpose() * (j * x - Vector6::from(wanted)) + x * 1e-6;
        for joint in 0..6 {
            prop_assert!(x[joint] >= asked.lower[joint] && x[joint] <= asked.upper[joint]);
            let (tolerance, near) = (1e-7, 1e-5 * width);
            if x[joint] > asked.lower[joint] + near {
                prop_assert!(gradient[joint] <= tolerance, "joint {} gradient {}", joint, gradient[joint]);
            }
            if x[joint] < asked.upper[joint] - near {
                prop_assert!(gradient[joint] >= -tolerance, "joint {} gradient {}", joint, gradient[joint]);
            }
        }
    }

    #[test]
    fn the_fallback_keeps_every_bound_too(
        q in prop::array::uniform6(-3.0..3.0f64),
        before in prop::array::uniform6(-0.5..0.5f64),
        wanted in prop::array::uniform6(-2.0..2.0f64),
        limits in prop::array::uniform6(0.0..0.3f64),
    ) {
        let mut asked = problem(&JointPositions(q), wanted);
        asked.current_speeds = JointSpeeds(before);
        asked.lower = JointSpeeds(before.map(|x| x - 0.04));
        asked.upper = JointSpeeds(before.map(|x| x + 0.04));
        asked.limits = limits;
        let start = twist_of(&asked, &asked.current_speeds);
        for iterations in [1, 40] {
            let mut limiter = TwistLimiter::with_iterations(iterations).unwrap();
            let found = limiter.solve(&asked).unwrap();
            if iterations == 1 {
                prop_assert!(found.method != SolveMethod::QuadraticProgram);
            }
            let twist = twist_of(&asked, &found.qd);
            for k in 0..6 {
                prop_assert!(found.qd[k] >= asked.lower[k] - 1e-15 && found.qd[k] <= asked.upper[k] + 1e-15);
                prop_assert!(twist[k].abs() <= limits[k].max(start[k].abs()) + 2e-9);
            }
        }
    }
}
