//! What must hold for any joint positions: forward and inverse kinematics, Jacobians, dynamics, distances agree.
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot read its input fails"
)]

use crate::common;

use common::assert_close;
use kinematics::rotation::wrap_angle;
use kinematics::{
    Capsule, GRAVITY_UPRIGHT, JointAccelerations, JointPositions, JointSpeeds, Payload, Pose,
    RobotModel, RpyPose,
};
use nalgebra::{Matrix6, Vector3};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::LazyLock;

static ARMS: LazyLock<Vec<RobotModel>> = LazyLock::new(|| {
    RobotModel::names()
        .map(|name| RobotModel::built_in(name).unwrap())
        .collect()
});

fn arm() -> impl Strategy<Value = &'static RobotModel> {
    (0..ARMS.len()).prop_map(|i| &ARMS[i])
}

fn six(range: f64) -> impl Strategy<Value = [f64; 6]> {
    prop::array::uniform6(-range..range)
}

/// Inside the limits of every arm: two turns, one for the elbow.
fn positions() -> impl Strategy<Value = JointPositions> {
    six(2.0 * PI).prop_map(|mut q| {
        q[2] /= 2.0;
        JointPositions(q)
    })
}

fn tcp() -> impl Strategy<Value = Pose> {
    (
        prop::array::uniform3(-0.3..0.3),
        prop::array::uniform3(-3.0..3.0),
    )
        .prop_map(|(xyz, rpy)| Pose::from_rpy(&RpyPose { xyz, rpy }))
}

fn apart(a: &Pose, b: &Pose) -> f64 {
    let rotation = (a.rotation.matrix() - b.rotation.matrix()).amax();
    rotation.max((a.translation - b.translation).amax())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn inverse_kinematics_gives_back_the_joints(arm in arm(), q in positions(), tcp in tcp()) {
        let pose = arm.tcp_pose(&q, &tcp);
        let all = arm.inverse_all(&pose, &tcp);
        for solution in &all {
            prop_assert!(apart(&arm.tcp_pose(solution, &tcp), &pose) < 1e-9);
            prop_assert!(solution.iter().all(|x| (-PI..PI).contains(x)));
        }
        let original = all.iter().any(|s| s.iter().zip(q.iter()).all(|(a, b)| wrap_angle(a - b).abs() < 1e-5));
        prop_assert!(original, "{q:?} is not in {:?}", &all[..]);

        let nearest = arm.inverse_nearest(&pose, &tcp, &q).unwrap();
        prop_assert!(nearest.distance_squared(&q) < 1e-9, "{nearest:?} for {q:?}");
    }

    #[test]
    fn the_nearest_solution_is_inside_the_limits_and_none_is_nearer(
        arm in arm(), q in positions(), near in positions(),
    ) {
        let pose = arm.flange_pose(&q);
        let nearest = arm.inverse_nearest(&pose, &Pose::IDENTITY, &near).unwrap();
        prop_assert!(arm.limits().contains(&nearest));
        prop_assert!(apart(&arm.flange_pose(&nearest), &pose) < 1e-9);
        // Every solution with every whole turn, the long way round.
        let mut least = f64::INFINITY;
        for solution in &arm.inverse_all(&pose, &Pose::IDENTITY) {
            for code in 0..3_usize.pow(6) {
                let turned = JointPositions(std::array::from_fn(|j| {
                    solution[j] + (code / 3_usize.pow(j as u32) % 3) as f64 * 2.0 * PI - 2.0 * PI
                }));
                if arm.limits().contains(&turned) {
                    least = least.min(turned.distance_squared(&near));
                }
            }
        }
        prop_assert!((nearest.distance_squared(&near) - least).abs() < 1e-6);
    }

    #[test]
    fn jacobian_is_the_derivative_of_the_pose(arm in arm(), q in positions(), qd in six(1.0), tcp in tcp()) {
        let h = 1e-6;
        let (pose, jacobian) = arm.tcp_pose_and_jacobian(&q, &tcp);
        let qd = JointSpeeds(qd);
        let moved = |h: f64| arm.tcp_pose(&JointPositions::from(q.to_vector() + qd.to_vector() * h), &tcp);
        let (ahead, behind) = (moved(h), moved(-h));
        let linear = (ahead.translation - behind.translation) / (2.0 * h);
        let change = (ahead.rotation.matrix() - behind.rotation.matrix()) / (2.0 * h);
        let spin = change * pose.rotation.matrix().transpose();
        let numeric = [linear.x, linear.y, linear.z, spin[(2, 1)], spin[(0, 2)], spin[(1, 0)]];
        let exact = jacobian * qd.to_vector();
        assert_close("twist", exact.as_slice(), &numeric, 1e-7);
        let twist = arm.forward(&q).twist(&qd, pose.translation);
        assert_close("twist", exact.as_slice(), &twist.to_array(), 1e-12);
    }

    #[test]
    fn jacobian_rate_is_the_derivative_of_the_jacobian(arm in arm(), q in positions(), qd in six(1.0), tcp in tcp()) {
        let h = 1e-6;
        let qd = JointSpeeds(qd);
        let twist = |h: f64| {
            let ahead = JointPositions::from(q.to_vector() + qd.to_vector() * h);
            let (_, jacobian) = arm.tcp_pose_and_jacobian(&ahead, &tcp);
            jacobian * qd.to_vector()
        };
        let numeric = (twist(h) - twist(-h)) / (2.0 * h);
        let point = arm.tcp_pose(&q, &tcp).translation;
        let exact = arm.forward(&q).jacobian_rate_times_speeds(&qd, point);
        assert_close("rate", &exact.to_array(), numeric.as_slice(), 1e-7);
    }

    #[test]
    fn forward_dynamics_undoes_inverse_dynamics(
        arm in arm(), q in positions(), qd in six(3.0), qdd in six(10.0), cog in prop::array::uniform3(-0.1..0.1),
    ) {
        let payload = Payload::new(1.5, cog, [0.01, 0.012, 0.008, 0.001, -0.002, 0.0005]).unwrap();
        let dynamics = arm.dynamics(&payload, Vector3::new(1.0, -4.0, -8.0));
        let (qd, qdd) = (JointSpeeds(qd), JointAccelerations(qdd));
        let tau = dynamics.inverse_dynamics(&q, &qd, &qdd);
        assert_close("qdd", &dynamics.forward_dynamics(&q, &qd, &tau).0, &qdd.0, 1e-8);
        let by_matrix = dynamics.mass_matrix(&q) * qdd.to_vector() + dynamics.bias_torques(&q, &qd).to_vector();
        assert_close("tau", by_matrix.as_slice(), &tau.0, 1e-9 * (1.0 + tau.max_abs()));
    }

    #[test]
    fn mass_matrices_are_symmetric_and_positive(arm in arm(), q in positions()) {
        let m = arm.dynamics(&Payload::NONE, GRAVITY_UPRIGHT).mass_matrix(&q);
        prop_assert_eq!(m, m.transpose());
        prop_assert!(m.cholesky().is_some());
    }

    #[test]
    fn gravity_torques_are_the_slope_of_the_potential(arm in arm(), q in positions()) {
        let dynamics = arm.dynamics(&Payload::new(2.0, [0.0, 0.01, 0.05], [0.0; 6]).unwrap(), GRAVITY_UPRIGHT);
        let potential = |q: &JointPositions| -> f64 {
            let frames = arm.forward(q);
            dynamics.bodies().iter().zip(&frames.base_from_joint)
                .map(|(body, frame)| -body.mass * GRAVITY_UPRIGHT.dot(&frame.transform_point(body.com)))
                .sum()
        };
        let tau = dynamics.gravity_torques(&q);
        for joint in 0..6 {
            let h = 1e-5;
            let (mut ahead, mut behind) = (q, q);
            ahead[joint] += h;
            behind[joint] -= h;
            let slope = (potential(&ahead) - potential(&behind)) / (2.0 * h);
            prop_assert!((slope - tau[joint]).abs() < 1e-5, "joint {joint}: {slope} {}", tau[joint]);
        }
    }

    #[test]
    fn wrenches_and_twists_have_the_same_power_through_a_transform(
        pose in tcp(), w in six(10.0), t in six(1.0),
    ) {
        let wrench = kinematics::Wrench::from_array(w);
        // A body with twist t of frame b's origin in b axes; the same motion at a's origin in a axes.
        let in_b = kinematics::Twist::from_array(t);
        let angular = pose.rotation * in_b.angular;
        let linear = pose.rotation * in_b.linear - angular.cross(&pose.translation);
        let there = wrench.transformed_by(&pose);
        let power = there.force.dot(&linear) + there.moment.dot(&angular);
        prop_assert!((power - wrench.to_vector().dot(&in_b.to_vector())).abs() < 1e-9);
    }

    #[test]
    fn segment_distance_is_the_least_over_both_segments(
        a in prop::array::uniform6(-1.0..1.0_f64), b in prop::array::uniform6(-1.0..1.0_f64), flat in any::<bool>(),
    ) {
        let v = |x: &[f64]| Vector3::new(x[0], x[1], x[2]);
        let (a0, a1, b0) = (v(&a[..3]), v(&a[3..]), v(&b[..3]));
        // Also parallel ones, where the lines have no single nearest pair.
        let b1 = if flat { b0 + (a1 - a0) * 0.7 } else { v(&b[3..]) };
        let exact = kinematics::collision::segment_distance(a0, a1, b0, b1);
        let mut least = f64::INFINITY;
        let steps = 60;
        for i in 0..=steps {
            for j in 0..=steps {
                let (s, t) = (f64::from(i) / f64::from(steps), f64::from(j) / f64::from(steps));
                least = least.min((a0 + (a1 - a0) * s - b0 - (b1 - b0) * t).norm());
            }
        }
        prop_assert!(exact <= least + 1e-12);
        prop_assert!(least - exact < 0.06, "{least} {exact}");
    }
}

#[test]
fn a_singular_wrist_keeps_joint_six_of_the_near_position() {
    for arm in &*ARMS {
        for q5 in [0.0, PI] {
            let q = JointPositions([0.4, -1.1, 1.3, 0.2, q5, 0.9]);
            let pose = arm.flange_pose(&q);
            for q6 in [0.9, -0.3, 5.0] {
                let mut near = q;
                near[5] = q6;
                let found = arm.inverse_nearest(&pose, &Pose::IDENTITY, &near).unwrap();
                assert!((found[5] - q6).abs() < 1e-12, "{found:?}");
                assert!(apart(&arm.flange_pose(&found), &pose) < 1e-9);
            }
            for solution in &arm.inverse_all(&pose, &Pose::IDENTITY) {
                assert!(apart(&arm.flange_pose(solution), &pose) < 1e-9);
                assert!(
                    solution[4].sin().abs() > 1e-9 || solution[5] == 0.0,
                    "{solution:?}"
                );
            }
        }
    }
}

#[test]
fn at_branch_borders_solutions_are_listed_once() {
    for arm in &*ARMS {
        // Straight arm and wrist: elbow and wrist branches coincide.
        let zero = arm.inverse_all(&arm.flange_pose(&JointPositions::ZERO), &Pose::IDENTITY);
        assert!(zero.iter().any(|q| q.max_abs() < 1e-6), "{:?}", &zero[..]);
        for (i, a) in zero.iter().enumerate() {
            for b in &zero[..i] {
                assert!(a.distance_squared(b) > 1e-20, "{:?}", &zero[..]);
            }
        }
    }
}

#[test]
fn poses_out_of_reach_and_not_finite_have_no_solution() {
    for arm in &*ARMS {
        for (x, y, z) in [
            (9.0, 0.0, 0.0),
            (0.0, 0.0, 3.0),
            (f64::NAN, 0.0, 0.0),
            (f64::INFINITY, 0.0, 0.0),
            (0.0, 0.0, 0.4),
        ] {
            let pose = Pose::from_translation(x, y, z);
            assert!(
                arm.inverse_all(&pose, &Pose::IDENTITY).is_empty(),
                "{x} {y} {z}"
            );
            assert!(
                arm.inverse_nearest(&pose, &Pose::IDENTITY, &JointPositions::ZERO)
                    .is_none()
            );
        }
    }
}

#[test]
fn determinant_vanishes_exactly_at_the_three_singularities() {
    for arm in &*ARMS {
        let dh = arm.dh().unwrap();
        for q in [
            [0.3, -1.2, 1.9, -0.7, 1.5, 0.2],
            [1.0, 0.4, -2.0, 2.5, -0.8, 3.0],
        ] {
            let (_, j): (_, Matrix6<f64>) =
                arm.tcp_pose_and_jacobian(&JointPositions(q), &Pose::IDENTITY);
            let (a2, a3, d5) = (dh.a[1], dh.a[2], dh.d[4]);
            let bracket =
                a2 * q[1].cos() + a3 * (q[1] + q[2]).cos() + d5 * (q[1] + q[2] + q[3]).sin();
            let wanted = a2 * a3 * q[2].sin() * q[4].sin() * bracket;
            assert!((j.determinant() - wanted).abs() < 1e-12);
        }
    }
}

#[test]
fn the_home_position_is_clear_and_a_folded_arm_is_not() {
    let home = JointPositions([0.0, -FRAC_PI_2, FRAC_PI_2, -FRAC_PI_2, -FRAC_PI_2, 0.0]);
    for arm in &*ARMS {
        let clear = arm.collision().self_distance(&arm.forward(&home)).unwrap();
        assert!(clear.distance > 0.0, "{}: {clear:?}", arm.name());
        // The forearm turned back onto the upper arm brings the wrist to the shoulder.
        let folded = JointPositions([0.0, -FRAC_PI_2, 3.1, 0.0, 0.0, 0.0]);
        let met = arm
            .collision()
            .self_distance(&arm.forward(&folded))
            .unwrap();
        assert!(met.distance < 0.0, "{}: {met:?}", arm.name());
    }
}

#[test]
fn obstacle_distance_is_that_of_the_nearest_link() {
    let arm = RobotModel::built_in("cs66").unwrap();
    let frames = arm.forward(&JointPositions([
        0.0, -FRAC_PI_2, FRAC_PI_2, -FRAC_PI_2, -FRAC_PI_2, 0.0,
    ]));
    // A ball in front of the flange, 0.1 m from its face to its surface.
    let ahead = frames.base_from_flange * Pose::from_translation(0.0, 0.0, 0.2);
    let ball = Capsule {
        p0: ahead.translation,
        p1: ahead.translation,
        radius: 0.1,
    };
    let (distance, link) = arm.collision().obstacle_distance(&frames, &ball).unwrap();
    assert_eq!(link, 6);
    assert!((0.07..=0.1).contains(&distance), "{distance}");
    let normal = -frames.base_from_flange.rotation.matrix().column(2);
    let plane = arm
        .collision()
        .capsules_in_base(6, &frames)
        .map(|c| c.distance_to_plane(ahead.translation, normal))
        .fold(f64::MAX, f64::min);
    assert!((plane - distance - 0.1).abs() < 0.01, "{plane}");
}
