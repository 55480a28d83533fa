//! Calibrated arms against pinocchio (tests/vectors/calibrated.py): transforms, Jacobians, torques, inverse solutions.
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot read its input fails"
)]

use crate::common;

use common::{assert_close, cases, get, q, vectors};
use kinematics::rotation::wrap_angle;
use kinematics::{
    Calibration, DhTable, GRAVITY_UPRIGHT, IkMethod, JointAccelerations, JointPositions,
    JointSpeeds, Payload, Pose, RobotModel,
};
use nalgebra::{Matrix3, Rotation3, Vector3};
use serde_json::Value;
use std::path::Path;

fn arms() -> Vec<(RobotModel, Value)> {
    let truth = vectors("calibrated.json");
    let arms: Vec<_> = cases(&truth, "arms")
        .iter()
        .map(|values| {
            let given = &values["calibration"];
            let table = &given["modified_dh"];
            let theta = match &table["theta"] {
                Value::Null => [0.0; 6],
                _ => get(table, "theta"),
            };
            let numbers = DhTable {
                a: get(table, "a"),
                d: get(table, "d"),
                alpha: get(table, "alpha"),
            };
            let model = given["model"].as_str().unwrap();
            let calibration = Calibration::new(model, numbers, theta, Path::new("truth")).unwrap();
            (calibration.open().unwrap(), values.clone())
        })
        .collect();
    assert_eq!(arms.len(), 4);
    arms
}

fn pose(case: &Value) -> Pose {
    let rows: [[f64; 3]; 3] = get(case, "rotation");
    let rotation = Matrix3::from_fn(|i, j| rows[i][j]);
    Pose::new(
        Rotation3::from_matrix_unchecked(rotation),
        Vector3::from(get::<[f64; 3]>(case, "position")),
    )
}

fn assert_pose(is: &Pose, should: &Pose) {
    assert!(
        (is.translation - should.translation).amax() < 1e-12,
        "{is:?} {should:?}"
    );
    let turned = is.rotation.matrix() - should.rotation.matrix();
    assert!(turned.amax() < 1e-12, "{is:?} {should:?}");
}

#[test]
fn flange_and_jacobian_agree() {
    for (arm, truth) in arms() {
        for case in cases(&truth, "fk") {
            let (flange, jacobian) = arm.tcp_pose_and_jacobian(&q(case), &Pose::IDENTITY);
            assert_pose(&flange, &pose(case));
            let rows: [[f64; 6]; 6] = get(case, "jacobian");
            for (i, row) in rows.iter().enumerate() {
                let is: Vec<f64> = jacobian.row(i).iter().copied().collect();
                assert_close("jacobian", &is, row, 1e-12);
            }
        }
    }
}

#[test]
fn torques_agree() {
    let mut compared = 0;
    for (arm, truth) in arms() {
        let dynamics = arm.dynamics(&Payload::NONE, GRAVITY_UPRIGHT);
        for case in cases(&truth, "fk")
            .iter()
            .filter(|case| case["tau"].is_array())
        {
            let (qd, qdd) = (
                JointSpeeds(get(case, "qd")),
                JointAccelerations(get(case, "qdd")),
            );
            let tau: [f64; 6] = get(case, "tau");
            let scale = tau.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
            let is = dynamics.inverse_dynamics(&q(case), &qd, &qdd);
            assert_close("tau", &is.0, &tau, 1e-11 * scale);
            compared += 1;
        }
    }
    assert_eq!(compared, 36);
}

#[test]
fn every_inverse_solution_is_listed_and_no_other() {
    for (arm, truth) in arms() {
        for case in cases(&truth, "ik") {
            let wanted: Vec<[f64; 6]> = get(case, "solutions");
            let found = arm.inverse_all(&pose(case), &Pose::IDENTITY);
            assert_eq!(found.len(), wanted.len(), "{}: {case}", arm.name());
            for should in &wanted {
                let is_listed = found
                    .iter()
                    .any(|is| (0..6).all(|j| wrap_angle(is[j] - should[j]).abs() < 1e-8));
                assert!(is_listed, "{should:?} is not in {found:?}");
            }
            for solution in &found {
                let reached = arm.flange_pose(solution);
                assert!((reached.translation - pose(case).translation).norm() < 1e-10);
                assert!((reached.rotation.matrix() - pose(case).rotation.matrix()).amax() < 1e-10);
            }
        }
    }
}

#[test]
fn lengths_alone_leave_the_closed_form() {
    let file = |name: &str| {
        let path = format!(
            "{}/../../robots/calibrations/{name}.toml",
            env!("CARGO_MANIFEST_DIR")
        );
        Calibration::load(Path::new(&path)).unwrap()
    };
    let arm = file("cs66-controller-2.15.0.477").open().unwrap();
    assert!(matches!(arm.ik_method(), IkMethod::ClosedForm(form) if form.d6 == 0.095));
    let nominal = RobotModel::built_in("cs66").unwrap();
    let q = JointPositions([0.3, -1.2, 1.9, -0.7, 1.5, 0.2]);
    let longer = nominal.tcp_pose(&q, &Pose::from_translation(0.0, 0.0, 0.003));
    assert!((arm.flange_pose(&q).translation - longer.translation).norm() < 1e-15);
    let measured = file("cs66-measured").open().unwrap();
    assert!(matches!(
        measured.ik_method(),
        IkMethod::RefinedClosedForm(_)
    ));
    // What a controller would send, to the last bit.
    assert_eq!(measured.modified_dh().unwrap().d[5], 0.112116);
    assert_eq!(measured.modified_dh().unwrap().d[0], 0.160861);
}

#[test]
fn an_offset_shared_by_the_parallel_axes_moves_no_link() {
    let nominal = RobotModel::built_in("cs66").unwrap();
    let mut table = nominal.modified_dh().unwrap();
    table.d[1] = 4.0;
    table.d[2] = -3.5;
    table.d[3] -= 0.5;
    let calibration = Calibration::new("cs66", table, [0.0; 6], Path::new("shared")).unwrap();
    let arm = nominal.clone().calibrated(&calibration).unwrap();
    let q = JointPositions([0.3, -1.2, 1.9, -0.7, 1.5, 0.2]);
    let (is, should) = (arm.forward(&q), nominal.forward(&q));
    for (is, should) in is.base_from_joint.iter().zip(&should.base_from_joint) {
        assert!((is.translation - should.translation).norm() < 1e-14);
    }
}
