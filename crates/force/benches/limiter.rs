//! What one solve of the joint-speed limiter costs: `cargo bench -p force`.
#![allow(
    clippy::expect_used,
    reason = "a bench that cannot go on should say where"
)]

use divan::Bencher;
use force::{SpeedLimits, TwistLimiter};
use kinematics::{JointPositions, JointSpeeds, Pose, RobotModel, Twist};
use nalgebra::Vector3;

fn main() {
    divan::main();
}

/// Free: no bound is touched. Tight: the acceleration bounds of most joints are.
#[divan::bench(args = [0.001, 0.5])]
fn solve(bencher: Bencher, speed: f64) {
    let arm = RobotModel::built_in("cs66").expect("a built-in arm");
    let own = arm.limits();
    let limits = SpeedLimits {
        position_min: own.position_min,
        position_max: own.position_max,
        speed: own.speed,
        acceleration: own.acceleration,
    };
    let mut limiter = TwistLimiter::new(limits, 0.004).expect("good limits");
    let q = JointPositions([0.3, -1.2, 1.4, -1.6, -1.2, 0.5]);
    let (_, jacobian) = arm.tcp_pose_and_jacobian(&q, &Pose::IDENTITY);
    let wanted = Twist {
        linear: Vector3::new(speed, -speed, speed),
        angular: Vector3::zeros(),
    };
    bencher.bench_local(|| {
        limiter.solve(
            &jacobian,
            divan::black_box(&wanted),
            &[1.0; 6],
            &q,
            &JointSpeeds::ZERO,
        )
    });
}
