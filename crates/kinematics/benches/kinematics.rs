//! Time of the calls a control cycle makes: `cargo bench -p kinematics`.
#![allow(clippy::unwrap_used, reason = "the built-in arms exist")]

use divan::{Bencher, black_box};
use kinematics::{
    Calibration, GRAVITY_UPRIGHT, JointAccelerations, JointPositions, JointSpeeds, Payload, Pose,
    RobotModel,
};
use std::path::Path;

const Q: JointPositions = JointPositions([0.3, -1.2, 1.9, -0.7, 1.5, 0.2]);
const QD: JointSpeeds = JointSpeeds([0.5, -0.3, 0.8, 1.0, -0.6, 0.2]);
const QDD: JointAccelerations = JointAccelerations([1.0, 2.0, -1.5, 0.3, 0.9, -2.0]);

fn main() {
    divan::main();
}

fn arm() -> RobotModel {
    RobotModel::built_in("cs66").unwrap()
}

#[divan::bench(sample_size = 1000)]
fn forward_flange(bencher: Bencher) {
    let arm = arm();
    bencher.bench_local(|| arm.flange_pose(black_box(&Q)));
}

#[divan::bench(sample_size = 1000)]
fn forward_all_frames(bencher: Bencher) {
    let arm = arm();
    bencher.bench_local(|| arm.forward(black_box(&Q)));
}

#[divan::bench(sample_size = 1000)]
fn pose_and_jacobian(bencher: Bencher) {
    let arm = arm();
    bencher.bench_local(|| arm.tcp_pose_and_jacobian(black_box(&Q), &Pose::IDENTITY));
}

#[divan::bench(sample_size = 1000)]
fn inverse_all(bencher: Bencher) {
    let arm = arm();
    let pose = arm.flange_pose(&Q);
    bencher.bench_local(|| arm.inverse_all(black_box(&pose), &Pose::IDENTITY));
}

#[divan::bench(sample_size = 1000)]
fn inverse_nearest(bencher: Bencher) {
    let arm = arm();
    let pose = arm.flange_pose(&Q);
    bencher.bench_local(|| arm.inverse_nearest(black_box(&pose), &Pose::IDENTITY, &Q));
}

/// The CS66 that was measured, without a closed form.
fn measured() -> RobotModel {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../robots/calibrations/cs66-measured.toml"
    );
    Calibration::load(Path::new(path)).unwrap().open().unwrap()
}

#[divan::bench(sample_size = 1000)]
fn inverse_all_calibrated(bencher: Bencher) {
    let arm = measured();
    let pose = arm.flange_pose(&Q);
    bencher.bench_local(|| arm.inverse_all(black_box(&pose), &Pose::IDENTITY));
}

/// A thousand poses of random joint positions, singular ones among them: divide by that.
#[divan::bench]
fn inverse_all_calibrated_of_1000(bencher: Bencher) {
    let arm = measured();
    let generator = [0.8567, 0.7339, 0.6287, 0.5386, 0.4614, 0.3953];
    let poses: Vec<Pose> = (1..=1000)
        .map(|i| {
            let turn = |g: f64| (f64::from(i) * g).fract() * std::f64::consts::TAU;
            arm.flange_pose(&JointPositions(generator.map(turn)))
        })
        .collect();
    bencher.bench_local(|| {
        for pose in &poses {
            black_box(arm.inverse_all(black_box(pose), &Pose::IDENTITY));
        }
    });
}

/// Straight elbow and parallel wrist axes at once: everything is tried.
#[divan::bench]
fn inverse_all_calibrated_at_worst(bencher: Bencher) {
    let arm = measured();
    let pose = arm.flange_pose(&JointPositions([0.3, -1.2, 1e-5, -0.7, 1e-5, 0.2]));
    bencher.bench_local(|| arm.inverse_all(black_box(&pose), &Pose::IDENTITY));
}

/// Parallel wrist axes alone.
#[divan::bench]
fn inverse_all_calibrated_at_a_singular_wrist(bencher: Bencher) {
    let arm = measured();
    let pose = arm.flange_pose(&JointPositions([0.3, -1.2, 1.1, -0.7, 1e-5, 0.2]));
    bencher.bench_local(|| arm.inverse_all(black_box(&pose), &Pose::IDENTITY));
}

#[divan::bench(sample_size = 1000)]
fn inverse_following_calibrated(bencher: Bencher) {
    let arm = measured();
    let pose = arm.flange_pose(&Q);
    let near = Q.map(|x| x + 0.005);
    bencher.bench_local(|| arm.inverse_continuous(black_box(&pose), &Pose::IDENTITY, &near));
}

#[divan::bench(sample_size = 1000)]
fn inverse_dynamics(bencher: Bencher) {
    let dynamics = arm().dynamics(&Payload::NONE, GRAVITY_UPRIGHT);
    bencher.bench_local(|| dynamics.inverse_dynamics(black_box(&Q), &QD, &QDD));
}

#[divan::bench(sample_size = 1000)]
fn mass_matrix(bencher: Bencher) {
    let dynamics = arm().dynamics(&Payload::NONE, GRAVITY_UPRIGHT);
    bencher.bench_local(|| dynamics.mass_matrix(black_box(&Q)));
}

#[divan::bench(sample_size = 1000)]
fn forward_dynamics(bencher: Bencher) {
    let dynamics = arm().dynamics(&Payload::NONE, GRAVITY_UPRIGHT);
    let tau = dynamics.gravity_torques(&Q);
    bencher.bench_local(|| dynamics.forward_dynamics(black_box(&Q), &QD, &tau));
}

#[divan::bench(sample_size = 1000)]
fn self_distance(bencher: Bencher) {
    let arm = arm();
    let frames = arm.forward(&Q);
    bencher.bench_local(|| arm.collision().self_distance(black_box(&frames)));
}

/// Ten thousand poses: divide by that.
#[divan::bench]
fn pose_trans_of_10_000(bencher: Bencher) {
    use kinematics::batch::{Operand, pose_trans};
    let rows: Vec<[f64; 6]> = (0..10_000)
        .map(|i| std::array::from_fn(|k| 0.3 * (f64::from(i) * 0.7 + k as f64).sin()))
        .collect();
    let mut out = vec![[0.0; 6]; rows.len()];
    bencher.bench_local(|| {
        pose_trans(
            Operand::PerRow(black_box(&rows)),
            Operand::PerRow(&rows),
            &mut out,
        )
    });
}

#[divan::bench(sample_size = 1000)]
fn pose_trans_of_one(bencher: Bencher) {
    let a = kinematics::RpyPose::from_array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]);
    bencher.bench_local(|| kinematics::script_math::pose_trans(black_box(&a), &a));
}
