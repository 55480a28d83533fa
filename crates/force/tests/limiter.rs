//! The joint-speed limiter: optimal by the conditions of optimality, never outside its bounds, never past a range.
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot go on should say where"
)]

use force::{LimiterError, SpeedLimits, TwistLimiter};
use kinematics::{JointPositions, JointSpeeds, Pose, RobotModel, Twist};
use nalgebra::{Matrix6, Vector3, Vector6};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::sync::OnceLock;

const STEP: f64 = 0.004;
const EVEN: [f64; 6] = [1.0; 6];

fn arm() -> &'static RobotModel {
    static ARM: OnceLock<RobotModel> = OnceLock::new();
    ARM.get_or_init(|| RobotModel::built_in("cs66").unwrap())
}

fn limits() -> SpeedLimits {
    let own = *arm().limits();
    SpeedLimits {
        position_min: own.position_min,
        position_max: own.position_max,
        speed: own.speed,
        acceleration: own.acceleration,
    }
}

fn twist(v: [f64; 6]) -> Twist {
    Twist {
        linear: Vector3::new(v[0], v[1], v[2]),
        angular: Vector3::new(v[3], v[4], v[5]),
    }
}

fn jacobian(q: &JointPositions) -> Matrix6<f64> {
    arm().tcp_pose_and_jacobian(q, &Pose::IDENTITY).1
}

const MIDDLE: JointPositions = JointPositions([0.3, -1.2, 1.4, -1.6, -1.2, 0.5]);

#[test]
fn a_twist_the_joints_can_do_is_done() {
    let mut limiter = TwistLimiter::new(limits(), STEP).unwrap();
    let j = jacobian(&MIDDLE);
    let wanted = twist([0.002, -0.001, 0.003, 0.004, 0.0, 0.002]);
    let found = limiter
        .solve(&j, &wanted, &EVEN, &MIDDLE, &JointSpeeds::ZERO)
        .unwrap();
    assert!(!found.is_at_bound);
    let off =
        (found.twist.linear - wanted.linear).norm() + (found.twist.angular - wanted.angular).norm();
    assert!(off < 1e-5, "{off}");
}

#[test]
fn an_arm_told_to_run_into_the_end_of_a_joint_stops_before_it() {
    let mut limiter = TwistLimiter::new(limits(), STEP).unwrap();
    let mut q = MIDDLE;
    let mut qd = JointSpeeds::ZERO;
    let l = limits();
    // Turning on and on about the vertical: wrist 3 and base go to the ends of their ranges.
    for _ in 0..3000 {
        let wanted = twist([0.0, 0.0, 0.0, 0.0, 0.0, 5.0]);
        let found = limiter
            .solve(&jacobian(&q), &wanted, &EVEN, &q, &qd)
            .unwrap();
        for joint in 0..6 {
            assert!(
                (found.qd[joint] - qd[joint]).abs() <= l.acceleration[joint] * STEP * (1.0 + 1e-9)
            );
            assert!(found.qd[joint].abs() <= l.speed[joint]);
        }
        qd = found.qd;
        for joint in 0..6 {
            q[joint] += qd[joint] * STEP;
            assert!(
                q[joint] <= l.position_max[joint] + 1e-9
                    && q[joint] >= l.position_min[joint] - 1e-9
            );
        }
    }
    let reached = (0..6).any(|joint| l.position_max[joint] - q[joint].abs() < 0.01);
    assert!(reached, "{q:?}");
}

#[test]
fn a_singular_arm_gets_finite_speeds() {
    let mut limiter = TwistLimiter::new(limits(), STEP).unwrap();
    let q = JointPositions([0.0, -1.5, 0.0, -1.5, 0.0, 0.0]);
    let wanted = twist([0.5, 0.5, 0.5, 1.0, 1.0, 1.0]);
    let found = limiter
        .solve(&jacobian(&q), &wanted, &EVEN, &q, &JointSpeeds::ZERO)
        .unwrap();
    assert!(found.qd.is_finite());
}

#[test]
fn a_weight_of_zero_gives_a_component_up() {
    let mut limiter = TwistLimiter::new(limits(), STEP).unwrap();
    let j = jacobian(&MIDDLE);
    let mut weights = EVEN;
    weights[2] = 0.0;
    let wanted = twist([0.001, 0.0, 99.0, 0.0, 0.0, 0.0]);
    let found = limiter
        .solve(&j, &wanted, &weights, &MIDDLE, &JointSpeeds::ZERO)
        .unwrap();
    assert!(
        (found.twist.linear.x - 0.001).abs() < 1e-4,
        "{:?}",
        found.twist
    );
    assert!(found.twist.linear.z.abs() < 0.1);
}

#[test]
fn unusable_input_is_an_error_that_names_it() {
    let mut broken = limits();
    broken.speed[3] = 0.0;
    let error = TwistLimiter::new(broken, STEP).err().unwrap();
    assert_eq!(
        error,
        LimiterError::BadLimit {
            name: "speed",
            joint: 3,
            value: 0.0
        }
    );
    assert!(matches!(
        TwistLimiter::new(limits(), -1.0).err(),
        Some(LimiterError::BadStep { .. })
    ));
    let mut limiter = TwistLimiter::new(limits(), STEP).unwrap();
    let wanted = twist([f64::NAN, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let error = limiter.solve(
        &jacobian(&MIDDLE),
        &wanted,
        &EVEN,
        &MIDDLE,
        &JointSpeeds::ZERO,
    );
    assert_eq!(
        error,
        Err(LimiterError::NotFinite {
            name: "wanted twist"
        })
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, rng_seed: RngSeed::Fixed(1), ..Default::default() })]

    #[test]
    fn the_answer_is_optimal_and_within_its_bounds(
        q in prop::array::uniform6(-3.0..3.0f64),
        before in prop::array::uniform6(-3.0..3.0f64),
        wanted in prop::array::uniform6(-2.0..2.0f64),
    ) {
        let (q, before) = (JointPositions(q), JointSpeeds(before));
        let mut limiter = TwistLimiter::new(limits(), STEP).unwrap();
        let j = jacobian(&q);
        let found = limiter.solve(&j, &twist(wanted), &EVEN, &q, &before).unwrap();
        let (lower, upper) = limiter.bounds(&q, &before);
        // Karush-Kuhn-Tucker: the gradient vanishes where a joint is free and points outwards where it is at a bound.
        let x = Vector6::from(found.qd.0);
        let gradient = j.transpose() * (j * x - Vector6::from(wanted)) + x * 1e-6;
        for joint in 0..6 {
            prop_assert!(x[joint] >= lower[joint] && x[joint] <= upper[joint]);
            // The interior point method stops at a relative gap of 1e-8.
            let tolerance = 1e-4;
            if x[joint] > lower[joint] + 1e-4 {
                prop_assert!(gradient[joint] <= tolerance, "joint {} gradient {}", joint, gradient[joint]);
            }
            if x[joint] < upper[joint] - 1e-4 {
                prop_assert!(gradient[joint] >= -tolerance, "joint {} gradient {}", joint, gradient[joint]);
            }
        }
    }
}
