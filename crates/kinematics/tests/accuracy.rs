//! How exact the inverse kinematics is, over many random configurations of every built-in arm.
//!
//! Half of them are anywhere inside the joint ranges, half close to a singularity (straight or folded elbow, parallel
//! wrist axes, wrist over the shoulder) at a distance of 1e-6 to 1e-2, rad or m. The long run, with its figures:
//!
//!     CONFIGURATIONS=1000000 cargo test --release -p kinematics --test all accuracy:: -- --nocapture

#![allow(
    clippy::unwrap_used,
    reason = "the built-in arms exist, and a test that finds nothing fails"
)]

use crate::common;

use common::random::Random;
use kinematics::rotation::wrap_angle;
use kinematics::{IkMethod, JointPositions, Pose, RobotModel};
use std::f64::consts::{PI, TAU};

/// In-plane distance of the wrist from the base axis, m; zero in the shoulder singularity.
fn shoulder_distance(arm: &RobotModel, q: &JointPositions) -> f64 {
    let IkMethod::ClosedForm(form) = arm.ik_method() else {
        panic!("a built-in arm has a closed form")
    };
    form.a2 * q[1].cos() + form.a3 * (q[1] + q[2]).cos() + form.d5 * (q[1] + q[2] + q[3]).sin()
}

/// Random positions inside the joint ranges, at least 1e-6 from every singularity.
fn configuration(arm: &RobotModel, random: &mut Random) -> JointPositions {
    let limits = arm.limits();
    loop {
        let mut q = JointPositions(std::array::from_fn(|j| {
            random.between(limits.position_min[j], limits.position_max[j])
        }));
        let turn = |random: &mut Random| random.between(-1.99, 1.99).round() * PI;
        match (random.unit() * 6.0) as u32 {
            0 => q[2] = ((random.unit() * 3.0).floor() - 1.0) * PI + random.near(),
            1 => q[4] = turn(random) + random.near(),
            2 => {
                // Newton on joint 2 until the distance is the wanted one.
                let wanted = random.near();
                for _ in 0..20 {
                    let mut ahead = q;
                    ahead[1] += 1e-7;
                    let is = shoulder_distance(arm, &q);
                    let slope = (shoulder_distance(arm, &ahead) - is) / 1e-7;
                    q[1] += ((wanted - is) / slope).clamp(-0.3, 0.3);
                }
            }
            _ => {}
        }
        let clear = q[2].sin().abs() >= 1e-6
            && q[4].sin().abs() >= 1e-6
            && shoulder_distance(arm, &q).abs() >= 1e-6;
        if clear && limits.contains(&q) {
            return q;
        }
    }
}

/// The largest errors seen.
#[derive(Debug, Default)]
struct Worst {
    joint_rad: f64,
    position_m: f64,
    rotation_rad: f64,
    nearest_rad: f64,
    lost: Vec<JointPositions>,
}

fn apart(a: &JointPositions, b: &JointPositions) -> f64 {
    a.iter()
        .zip(b.iter())
        .map(|(a, b)| wrap_angle(a - b).abs())
        .fold(0.0, f64::max)
}

fn examine(arm: &RobotModel, count: usize, seed: u64) -> Worst {
    /// A solution further than this (rad) from the original is another one.
    const SAME: f64 = 1e-4;
    let mut random = Random(seed);
    let mut worst = Worst::default();
    for _ in 0..count {
        let q = configuration(arm, &mut random);
        let pose = arm.flange_pose(&q);
        let all = arm.inverse_all(&pose, &Pose::IDENTITY);
        let mut least = f64::INFINITY;
        for solution in &all {
            let again = arm.flange_pose(solution);
            let position = (again.translation - pose.translation).norm();
            // For small angles the difference of the matrices has √2 times the angle as its length.
            let rotation = (again.rotation.matrix() - pose.rotation.matrix()).norm() / 2_f64.sqrt();
            worst.position_m = worst.position_m.max(position);
            worst.rotation_rad = worst.rotation_rad.max(rotation);
            least = least.min(apart(solution, &q));
        }
        let nearest = arm.inverse_nearest(&pose, &Pose::IDENTITY, &q);
        let off = nearest.map_or(f64::INFINITY, |n| n.distance_squared(&q).sqrt());
        if least > SAME || off > SAME {
            worst.lost.push(q);
        } else {
            worst.joint_rad = worst.joint_rad.max(least);
            worst.nearest_rad = worst.nearest_rad.max(off);
        }
        if let Some(near) = nearest {
            assert!(arm.limits().contains(&near), "{near:?} for {q:?}");
            assert!(
                near.iter().zip(q.iter()).all(|(a, b)| (a - b).abs() < TAU),
                "{near:?} for {q:?}"
            );
        }
    }
    worst
}

fn examine_all(count: usize) {
    for name in RobotModel::names() {
        let arm = RobotModel::built_in(name).unwrap();
        let worst = examine(&arm, count, 5);
        println!(
            "{name:6} {count} configurations: original joints within {:.1e} rad (nearest {:.1e}), \
             poses within {:.1e} m and {:.1e} rad, {} lost",
            worst.joint_rad,
            worst.nearest_rad,
            worst.position_m,
            worst.rotation_rad,
            worst.lost.len()
        );
        assert!(
            worst.lost.is_empty(),
            "{name}: {:?}",
            &worst.lost[..worst.lost.len().min(5)]
        );
        assert!(
            worst.position_m <= 1e-9 && worst.rotation_rad <= 1e-9,
            "{name}: {worst:?}"
        );
    }
}

#[test]
fn no_solution_is_lost_and_every_solution_reaches_its_pose() {
    let count = std::env::var("CONFIGURATIONS").map_or(20_000, |count| count.parse().unwrap());
    examine_all(count);
}
