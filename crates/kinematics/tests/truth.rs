//! The arms against reference values computed by an independent rigid-body library (tests/vectors/truth.json).
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot read its input fails"
)]

use crate::common;

use common::{arms, assert_close, cases, get, q, vectors};
use kinematics::rotation::wrap_angle;
use kinematics::{
    GRAVITY_UPRIGHT, JointAccelerations, JointPositions, JointSpeeds, Payload, Pose, RobotModel,
    RpyPose,
};
use nalgebra::{Matrix6, Quaternion, UnitQuaternion, Vector3};
use serde_json::Value;

/// Torques agree to 1e-8 of the largest one in the case (the values carry 12 digits).
#[track_caller]
fn assert_torques(what: &str, is: &[f64], should: &[f64]) {
    let scale = should.iter().fold(1e-3_f64, |m, x| m.max(x.abs()));
    assert_close(what, is, should, 1e-8 * scale);
}

fn pose(case: &Value) -> Pose {
    Pose::from_rpy(&RpyPose {
        xyz: get(case, "position"),
        rpy: get(case, "rpy"),
    })
}

fn matrix(rows: [[f64; 6]; 6]) -> Matrix6<f64> {
    Matrix6::from_fn(|i, j| rows[i][j])
}

#[test]
fn forward_kinematics_agrees() {
    for (arm, truth) in arms() {
        for case in cases(&truth, "fk") {
            let flange = arm.flange_pose(&q(case));
            let position: [f64; 3] = get(case, "position");
            assert_close(arm.name(), flange.translation.as_slice(), &position, 1e-9);
            let [x, y, z, w]: [f64; 4] = get(case, "quaternion_xyzw");
            let wanted = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
            let off = wanted.to_rotation_matrix().matrix() - flange.rotation.matrix();
            assert!(off.amax() < 1e-9, "{}: {off}", arm.name());
            let rpy: [f64; 3] = get(case, "rpy");
            assert_close(arm.name(), &flange.to_rpy().rpy, &rpy, 1e-9);
        }
    }
}

#[test]
fn jacobians_agree() {
    for (arm, truth) in arms() {
        for case in cases(&truth, "jacobian") {
            let (_, jacobian) = arm.tcp_pose_and_jacobian(&q(case), &Pose::IDENTITY);
            let off = jacobian - matrix(get(case, "J"));
            assert!(off.amax() < 1e-9, "{}: {off}", arm.name());
        }
    }
}

#[test]
fn gravity_torques_agree() {
    for (arm, truth) in arms() {
        let dynamics = arm.dynamics(&Payload::NONE, GRAVITY_UPRIGHT);
        for case in cases(&truth, "gravity") {
            let tau: [f64; 6] = get(case, "tau");
            assert_torques(arm.name(), &dynamics.gravity_torques(&q(case)).0, &tau);
        }
        for case in cases(&truth, "tilted_gravity") {
            let tilted: [f64; 3] = get(case, "gravity");
            let dynamics = arm.dynamics(&Payload::NONE, Vector3::from(tilted));
            let tau: [f64; 6] = get(case, "tau");
            assert_torques(arm.name(), &dynamics.gravity_torques(&q(case)).0, &tau);
        }
    }
}

#[test]
fn inverse_dynamics_agrees() {
    for (arm, truth) in arms() {
        let dynamics = arm.dynamics(&Payload::NONE, GRAVITY_UPRIGHT);
        for case in cases(&truth, "inverse_dynamics") {
            let (qd, qdd) = (
                JointSpeeds(get(case, "qd")),
                JointAccelerations(get(case, "qdd")),
            );
            let tau: [f64; 6] = get(case, "tau_com");
            let is = dynamics.inverse_dynamics(&q(case), &qd, &qdd);
            assert_torques(arm.name(), &is.0, &tau);
            // And back: the torques cause exactly these accelerations.
            let back = dynamics.forward_dynamics(&q(case), &qd, &is);
            assert_close(arm.name(), &back.0, &qdd.0, 1e-9);
        }
    }
}

#[test]
fn mass_matrices_agree() {
    for (arm, truth) in arms() {
        let dynamics = arm.dynamics(&Payload::NONE, GRAVITY_UPRIGHT);
        for case in cases(&truth, "mass_matrix") {
            let wanted = matrix(get(case, "M_com"));
            let off = dynamics.mass_matrix(&q(case)) - wanted;
            assert!(off.amax() < 1e-8 * wanted.amax(), "{}: {off}", arm.name());
        }
    }
}

#[test]
fn payload_dynamics_agrees() {
    let given = &vectors("truth.json")["meta"]["payload_dynamics"];
    let [ixx, iyy, izz]: [f64; 3] = get(given, "inertia_com");
    let payload = Payload::new(
        get(given, "mass"),
        get(given, "cog"),
        [ixx, iyy, izz, 0.0, 0.0, 0.0],
    )
    .unwrap();
    for (arm, truth) in arms() {
        let dynamics = arm.dynamics(&payload, GRAVITY_UPRIGHT);
        for case in cases(&truth, "payload_dynamics") {
            let (qd, qdd) = (
                JointSpeeds(get(case, "qd")),
                JointAccelerations(get(case, "qdd")),
            );
            let tau: [f64; 6] = get(case, "tau");
            let gravity: [f64; 6] = get(case, "tau_gravity");
            assert_torques(
                arm.name(),
                &dynamics.inverse_dynamics(&q(case), &qd, &qdd).0,
                &tau,
            );
            assert_torques(arm.name(), &dynamics.gravity_torques(&q(case)).0, &gravity);
        }
    }
}

#[test]
fn inverse_kinematics_lists_the_same_solutions_in_the_same_order() {
    for (arm, truth) in arms() {
        for case in cases(&truth, "ik") {
            let wanted = cases(case, "solutions");
            let found = arm.inverse_all(&pose(case), &Pose::IDENTITY);
            assert_eq!(found.len(), wanted.len(), "{}: {case}", arm.name());
            for (is, should) in found.iter().zip(wanted) {
                for (a, b) in is.iter().zip(&get::<Vec<f64>>(should, "q")) {
                    // The poses carry 12 digits, and near branch borders their rounding grows.
                    assert!(
                        wrap_angle(a - b).abs() < 1e-7,
                        "{}: {is:?} instead of {should}",
                        arm.name()
                    );
                }
                let reached = arm.flange_pose(is);
                assert!((reached.translation - pose(case).translation).amax() < 1e-9);
                assert!((reached.rotation.matrix() - pose(case).rotation.matrix()).amax() < 1e-9);
            }
        }
    }
}

#[test]
fn inverse_kinematics_finds_as_many_solutions() {
    for (arm, truth) in arms() {
        for case in cases(&truth, "ik_solution_count") {
            let count: usize = get(case, "count");
            assert_eq!(
                arm.inverse_all(&pose(case), &Pose::IDENTITY).len(),
                count,
                "{}: {case}",
                arm.name()
            );
        }
    }
}

#[test]
fn the_manuals_eight_solutions_come_out_to_the_printed_digits() {
    let example = &vectors("truth.json")["manual_example"];
    let arm = RobotModel::built_in(example["model"].as_str().unwrap()).unwrap();
    let pose = Pose::from_rpy(&RpyPose::from_array(get(example, "pose_rpy")));
    let found = arm.inverse_all(&pose, &Pose::IDENTITY);
    let printed: Vec<[f64; 6]> = get(example, "solutions");
    assert_eq!(found.len(), 8);
    for (is, should) in found.iter().zip(&printed) {
        // Six digits are printed.
        assert_close("solution", &is.0, should, 5.01e-7);
        let reached = arm.flange_pose(&JointPositions(*should));
        assert!((reached.translation - pose.translation).norm() < 4e-7);
    }
}
