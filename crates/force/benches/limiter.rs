//! What one solve of the joint-speed limiter costs: `cargo bench -p force`.
#![allow(
    clippy::expect_used,
    reason = "a bench that cannot go on should say where"
)]

use divan::Bencher;
use force::{TwistLimiter, TwistProblem};
use kinematics::{JointPositions, JointSpeeds, Pose, RobotModel};

fn main() {
    divan::main();
}

/// Free: no bound is touched. Tight: the bounds of most joints and of one component are.
#[divan::bench(args = [0.001, 0.5])]
fn solve(bencher: Bencher, speed: f64) {
    let arm = RobotModel::built_in("cs66").expect("a built-in arm");
    let mut limiter = TwistLimiter::new().expect("a limiter");
    let q = JointPositions([0.3, -1.2, 1.4, -1.6, -1.2, 0.5]);
    let (_, jacobian) = arm.tcp_pose_and_jacobian(&q, &Pose::IDENTITY);
    let mut limits = [f64::INFINITY; 6];
    limits[2] = 0.01;
    let problem = TwistProblem {
        jacobian,
        desired_twist: [speed, -speed, speed, 0.0, 0.0, 0.0],
        weights: [1.0; 6],
        lower: JointSpeeds([-0.04; 6]),
        upper: JointSpeeds([0.04; 6]),
        limits,
        current_speeds: JointSpeeds::ZERO,
    };
    bencher.bench_local(|| limiter.solve(divan::black_box(&problem)));
}
