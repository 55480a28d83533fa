//! Calibrated arms: whether every inverse solution is found, whether each is one, and whether any comes twice.
//!
//! Random calibrations of every built-in arm at random configurations, half of them close to a singularity. The long
//! run:
//!
//!     CONFIGURATIONS=100000 cargo test --release -p kinematics --test all calibrated:: -- --nocapture

#![allow(
    clippy::unwrap_used,
    reason = "the built-in arms exist, and a test that finds nothing fails"
)]

use crate::common;

use common::random::Random;
use kinematics::rotation::{rotvec_from_rotation, wrap_angle};
use kinematics::{Calibration, DhTable, IkMethod, JointPositions, Pose, RobotModel};
use std::f64::consts::PI;
use std::path::Path;

/// How far a random arm is from its model: m and rad alike.
const SPREADS: [f64; 4] = [1e-5, 3e-4, 2e-3, 8e-3];

/// An arm whose every number is up to `spread` from the model's.
fn calibrated(nominal: &RobotModel, spread: f64, random: &mut Random) -> RobotModel {
    let own = nominal.modified_dh().unwrap();
    let mut off = |x: f64| x + random.between(-spread, spread);
    let table = DhTable {
        a: own.a.map(&mut off),
        d: own.d.map(&mut off),
        alpha: own.alpha.map(&mut off),
    };
    let theta = [0.0; 6].map(&mut off);
    let calibration = Calibration::new(nominal.name(), table, theta, Path::new("random")).unwrap();
    nominal.clone().calibrated(&calibration).unwrap()
}

/// Position and rotation between two poses, the larger of m and rad.
fn apart(a: &Pose, b: &Pose) -> f64 {
    let turned = rotvec_from_rotation(&(a.rotation * b.rotation.inverse())).norm();
    turned.max((a.translation - b.translation).norm())
}

fn joints_apart(a: &JointPositions, b: &JointPositions) -> f64 {
    (0..6).fold(0.0, |most, j| most.max(wrap_angle(a[j] - b[j]).abs()))
}

/// Whether two solutions are the same, or everything between them is one as well but for what is allowed.
fn is_indistinct(
    arm: &RobotModel,
    tcp: &Pose,
    pose: &Pose,
    a: &JointPositions,
    b: &JointPositions,
) -> bool {
    let midway = |j: usize| a[j] + 0.5 * wrap_angle(b[j] - a[j]);
    let midway = JointPositions(std::array::from_fn(midway));
    joints_apart(a, b) < 1e-5
        || joints_apart(a, b) < 0.1 && apart(&arm.tcp_pose(&midway, tcp), pose) < 1e-10
}

/// Anywhere, or close to a straight or folded elbow, to parallel wrist axes, or to both; true when it is.
fn configuration(random: &mut Random) -> (JointPositions, bool) {
    let mut q = JointPositions(std::array::from_fn(|_| random.between(-PI, PI)));
    let half_turn = random.between(0.0, 2.0).floor() * PI;
    let kind = random.between(0.0, 6.0) as u32;
    match kind {
        0 => q[2] = half_turn + random.near(),
        1 => q[4] = half_turn + random.near(),
        2 => (q[2], q[4]) = (random.near(), half_turn + random.near()),
        _ => {}
    }
    (q, kind < 3)
}

fn configurations(default: usize) -> usize {
    std::env::var("CONFIGURATIONS").map_or(default, |n| n.parse().unwrap())
}

fn models() -> Vec<RobotModel> {
    let open = |name| RobotModel::built_in(name).unwrap();
    RobotModel::names().map(open).collect()
}

#[test]
fn the_way_back_from_every_pose_is_among_the_solutions() {
    let count = configurations(3000);
    let models = models();
    let mut random = Random(1);
    let (mut worst, mut most) = (0.0_f64, 0);
    let (mut lost, mut lost_near) = (0, 0);
    for index in 0..count {
        let nominal = &models[index % 6];
        let arm = calibrated(nominal, SPREADS[index / 6 % 4], &mut random);
        assert!(matches!(arm.ik_method(), IkMethod::RefinedClosedForm(_)));
        let (q, is_near) = configuration(&mut random);
        let tcp = Pose::from_translation(0.01, -0.02, 0.1);
        let pose = arm.tcp_pose(&q, &tcp);
        let found = arm.inverse_all(&pose, &tcp);
        most = most.max(found.len());
        for (i, solution) in found.iter().enumerate() {
            worst = worst.max(apart(&arm.tcp_pose(solution, &tcp), &pose));
            let is_wrapped = solution.iter().all(|x| (-PI..PI).contains(x));
            assert!(is_wrapped, "{solution:?}");
            for other in &found[..i] {
                let name = nominal.name();
                assert!(
                    joints_apart(solution, other) > 1e-7,
                    "{name}: {solution:?} twice"
                );
            }
        }
        // Where two solutions meet, joints are known only to the root of what poses are known to.
        if !found
            .iter()
            .any(|s| is_indistinct(&arm, &tcp, &pose, s, &q))
        {
            *if is_near { &mut lost_near } else { &mut lost } += 1;
            println!("{index}: {}, {q:?}: {} found", arm.name(), found.len());
        }
    }
    println!(
        "{count} configurations: residual {worst:.1e}, lost {lost} and {lost_near} near singularities, \
         at most {most} found"
    );
    assert!(worst < 1e-10, "{worst}");
    // An arm off by 8 mm in every length is as good as near a singularity in many places.
    assert!(lost * 10_000 <= count, "{lost}");
    assert!(lost_near * 1000 <= count, "{lost_near}");
}

#[test]
fn away_from_singularities_there_are_as_many_solutions_as_of_the_model() {
    let count = configurations(3000);
    let models = models();
    let mut random = Random(2);
    let mut compared = 0;
    for index in 0..count {
        let nominal = &models[index % 6];
        let arm = calibrated(nominal, SPREADS[index / 6 % 2], &mut random);
        let (q, _) = configuration(&mut random);
        let pose = nominal.flange_pose(&q);
        let of_model = nominal.inverse_all(&pose, &Pose::IDENTITY);
        // Eight solutions, none of them nearly in a singularity: the calibrated arm has one beside each, and no other.
        let is_clear = |s: &JointPositions| s[2].sin().abs() > 0.3 && s[4].sin().abs() > 0.3;
        if of_model.len() < 8
            || !of_model.iter().all(is_clear)
            || wrap_angle(of_model[0][0] - of_model[4][0]).abs() < 0.4
        {
            continue;
        }
        let found = arm.inverse_all(&pose, &Pose::IDENTITY);
        compared += 1;
        assert_eq!(found.len(), 8, "{}: {q:?}", nominal.name());
        for (one, other) in found.iter().zip(&of_model) {
            assert!(joints_apart(one, other) < 0.5, "{one:?} and {other:?}");
        }
    }
    assert!(compared > count / 20, "{compared}");
}

#[test]
fn where_axes_4_and_6_stay_parallel_joint_6_is_free() {
    let nominal = RobotModel::built_in("cs66").unwrap();
    let mut table = nominal.modified_dh().unwrap();
    table.a[1] = 0.002;
    let calibration = Calibration::new("cs66", table, [0.0; 6], Path::new("shifted")).unwrap();
    let arm = nominal.calibrated(&calibration).unwrap();
    assert!(matches!(arm.ik_method(), IkMethod::RefinedClosedForm(_)));
    let q = JointPositions([0.3, -1.2, 1.1, -0.4, 0.0, 0.7]);
    let pose = arm.flange_pose(&q);
    let found = arm.inverse_all(&pose, &Pose::IDENTITY);
    let singular: Vec<_> = found.iter().filter(|s| s[4].abs() < 1e-6).collect();
    assert_eq!(singular.len(), 2, "one of each elbow: {found:?}");
    for solution in singular {
        assert!(wrap_angle(solution[5]).abs() < 1e-6, "{solution:?}");
        assert!(apart(&arm.flange_pose(solution), &pose) < 1e-10);
    }
    // From where the arm is, joint 6 stays.
    let near = arm.inverse_nearest(&pose, &Pose::IDENTITY, &q).unwrap();
    assert!(joints_apart(&near, &q) < 1e-9);
}
