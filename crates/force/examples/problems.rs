//! Random questions to the joint-speed limiter with its answers, one JSON object a line, for `tests/peers/qp_gap.py`.
#![allow(
    clippy::print_stdout,
    clippy::expect_used,
    reason = "the lines are what the program is for; an example that cannot go on should say where"
)]

use force::{TwistLimiter, TwistProblem};
use kinematics::{JointPositions, JointSpeeds, Pose, RobotModel};

fn main() {
    let arm = RobotModel::built_in("cs66").expect("a built-in arm");
    let mut limiter = TwistLimiter::new().expect("a limiter");
    let mut seed = 1_u64;
    let mut random = |most: f64| {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0) * most
    };
    for round in 0..500 {
        let q = JointPositions(core::array::from_fn(|_| random(3.0)));
        let before = JointSpeeds(core::array::from_fn(|_| random(0.3)));
        let (_, jacobian) = arm.tcp_pose_and_jacobian(&q, &Pose::IDENTITY);
        let width = [0.04, 0.004, 0.2][round % 3];
        let problem = TwistProblem {
            jacobian,
            desired_twist: core::array::from_fn(|_| random(0.5)),
            weights: [1.0; 6],
            lower: before.map(|x| x - width),
            upper: before.map(|x| x + width),
            limits: core::array::from_fn(|k| if k % 2 == 0 { random(0.1).abs() } else { 1e3 }),
            current_speeds: before,
        };
        let found = limiter.solve(&problem).expect("good input");
        let row = |row: usize| (0..6).map(|k| jacobian[(row, k)]).collect::<Vec<f64>>();
        println!(
            "{{\"jacobian\": {:?}, \"wanted\": {:?}, \"lower\": {:?}, \"upper\": {:?}, \"limits\": {:?}, \"before\": \
             {:?}, \"qd\": {:?}, \"method\": \"{:?}\"}}",
            (0..6).map(row).collect::<Vec<_>>(),
            problem.desired_twist,
            problem.lower.0,
            problem.upper.0,
            problem.limits,
            before.0,
            found.qd.0,
            found.method,
        );
    }
}
