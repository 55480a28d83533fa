//! Arms that the closed form does not fit: how surely, how exactly and how fast iteration finds solutions.

#![allow(clippy::unwrap_used, reason = "a test that cannot make its arm fails")]

use kinematics::ik::unwrap_towards;
use kinematics::{IkMethod, JointPositions, Pose, RobotModel};
use std::fmt::Write;
use std::time::Instant;

/// A joint: origin, axis, limits in degrees.
type Joint = ([f64; 3], [f64; 3], [f64; 2]);

/// A URDF with these joints and a flange 80 mm along x.
fn urdf(joints: &[Joint; 6]) -> String {
    let mut text = String::from("<robot name='other'><link name='link0'/>");
    for (i, (origin, axis, [min, max])) in joints.iter().enumerate() {
        let [x, y, z] = origin;
        let [ax, ay, az] = axis;
        let (min, max) = (min.to_radians(), max.to_radians());
        write!(
            text,
            "<link name='link{n}'><inertial><mass value='1'/><inertia ixx='0.01' iyy='0.01' izz='0.01' ixy='0' ixz='0' \
             iyz='0'/></inertial></link>
             <joint name='joint{n}' type='revolute'><origin xyz='{x} {y} {z}'/><parent link='link{i}'/><child \
             link='link{n}'/>
             <axis xyz='{ax} {ay} {az}'/><limit lower='{min}' upper='{max}' effort='100' velocity='3'/></joint>",
            n = i + 1
        )
        .unwrap();
    }
    text + "<link name='flange'/><joint name='end' type='fixed'><origin xyz='0.08 0 0'/><parent link='link6'/><child \
            link='flange'/></joint></robot>"
}

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];

/// An industrial arm: offset shoulder, elbow, wrist axes through one point, narrow ranges.
fn spherical_wrist() -> RobotModel {
    let joints = [
        ([0.0, 0.0, 0.3], Z, [-170.0, 170.0]),
        ([0.1, 0.0, 0.1], Y, [-65.0, 145.0]),
        ([0.0, 0.0, 0.45], Y, [-200.0, 70.0]),
        ([0.2, 0.0, 0.03], X, [-190.0, 190.0]),
        ([0.25, 0.0, 0.0], Y, [-120.0, 120.0]),
        ([0.05, 0.0, 0.0], X, [-350.0, 350.0]),
    ];
    RobotModel::from_urdf(&urdf(&joints)).unwrap()
}

/// No two axes parallel or crossing: up to sixteen solutions.
fn general() -> RobotModel {
    let joints = [
        ([0.0, 0.0, 0.2], Z, [-180.0, 180.0]),
        ([0.05, 0.1, 0.1], [0.2, 0.9, 0.3], [-180.0, 180.0]),
        ([0.0, -0.05, 0.4], [0.1, 1.0, 0.0], [-150.0, 150.0]),
        ([0.3, 0.04, 0.05], [0.9, 0.1, 0.3], [-180.0, 180.0]),
        ([0.1, 0.0, 0.05], [0.0, 0.8, 0.6], [-180.0, 180.0]),
        ([0.1, 0.03, 0.0], [0.8, 0.0, 0.6], [-180.0, 180.0]),
    ];
    RobotModel::from_urdf(&urdf(&joints)).unwrap()
}

/// The cs66 with its last axis turned out of the right angle.
fn turned_last_axis() -> RobotModel {
    let text = include_str!("../../../robots/cs66/cs66.urdf").replace(
        "<child link=\"wrist_3_link\"/>\n    <axis xyz=\"0 0 1\"/>",
        "<child link=\"wrist_3_link\"/>\n    <axis xyz=\"0.6 0 0.8\"/>",
    );
    RobotModel::from_urdf(&text).unwrap()
}

/// Positions inside the limits from a Kronecker sequence: even, and the same on every run.
fn positions(arm: &RobotModel, index: usize) -> JointPositions {
    let limits = arm.limits();
    JointPositions(std::array::from_fn(|j| {
        let share = (index as f64 * [0.414, 0.732, 0.236, 0.645, 0.316, 0.605][j]
            + index as f64 * 0.001_618 * (j + 1) as f64)
            .fract();
        let (min, max) = (limits.position_min[j], limits.position_max[j]);
        min + (max - min) * (0.01 + 0.98 * share)
    }))
}

struct Measured {
    found: usize,
    found_from_afar: usize,
    /// How often a solution further away than a known one was returned.
    not_nearest: usize,
    worst_m: f64,
    slowest_us: f64,
    mean_us: f64,
}

fn measure(arm: &RobotModel, count: usize) -> Measured {
    assert_eq!(*arm.ik_method(), IkMethod::Iterative);
    let mut measured = Measured {
        found: 0,
        found_from_afar: 0,
        not_nearest: 0,
        worst_m: 0.0,
        slowest_us: 0.0,
        mean_us: 0.0,
    };
    for index in 1..=count {
        let at = positions(arm, index);
        let pose = arm.flange_pose(&at);
        let beside = JointPositions(std::array::from_fn(|j| {
            (at[j] + 0.1).min(arm.limits().position_max[j])
        }));
        let far = positions(arm, index + 7919);
        for (near, found) in [
            (beside, &mut measured.found),
            (far, &mut measured.found_from_afar),
        ] {
            let started = Instant::now();
            let solution = arm.inverse_nearest(&pose, &Pose::IDENTITY, &near);
            let took = started.elapsed().as_secs_f64() * 1e6;
            measured.slowest_us = measured.slowest_us.max(took);
            measured.mean_us += took / (2 * count) as f64;
            if let Some(q) = solution {
                *found += 1;
                assert!(arm.limits().contains(&q));
                let known = unwrap_towards(&at, &near, arm.limits()).unwrap();
                let closer = known.distance_squared(&near) < q.distance_squared(&near) - 1e-6;
                measured.not_nearest += usize::from(closer);
                let off = (arm.flange_pose(&q).translation - pose.translation).norm();
                measured.worst_m = measured.worst_m.max(off);
            }
        }
    }
    measured
}

#[test]
fn solutions_inside_the_limits_are_found_from_near_and_from_afar() {
    for (name, arm) in [
        ("spherical wrist", spherical_wrist()),
        ("general", general()),
        ("turned last axis", turned_last_axis()),
    ] {
        let m = measure(&arm, 300);
        println!(
            "{name}: {} of 300 from beside, {} from afar, {} not nearest, within {:.1e} m, {:.0} us, at most {:.0} us",
            m.found, m.found_from_afar, m.not_nearest, m.worst_m, m.mean_us, m.slowest_us
        );
        assert_eq!(
            (m.found, m.found_from_afar, m.not_nearest),
            (300, 300, 0),
            "{name}"
        );
        assert!(m.worst_m < 1e-10, "{name}: {}", m.worst_m);
    }
}

#[test]
fn a_pose_out_of_reach_is_given_up_in_bounded_time() {
    let arm = general();
    let near = JointPositions::ZERO;
    let seek = |pose: &Pose| arm.inverse_nearest(pose, &Pose::IDENTITY, &near);
    // Beyond the length of the arm, and inside it where only some directions can be reached.
    assert_eq!(seek(&Pose::from_translation(9.0, 0.0, 0.0)), None);
    let stretched = Pose::from_translation(1.13, 0.0, 0.25);
    let started = Instant::now();
    assert_eq!(seek(&stretched), None);
    // 65 starting points of 40 steps at most: 3 ms; a wide margin for a busy machine.
    assert!(started.elapsed().as_millis() < 500);
}

#[test]
fn following_a_line_stays_on_it_without_a_search() {
    for arm in [spherical_wrist(), general(), turned_last_axis()] {
        let start = JointPositions([0.3, -0.4, -0.5, 0.4, 0.8, 0.2]);
        // Towards the base, so that the arm never has to stretch.
        let (mut q, mut pose) = (start, arm.flange_pose(&start));
        for _ in 0..50 {
            pose.translation *= 0.998;
            let next = arm.inverse_continuous(&pose, &Pose::IDENTITY, &q).unwrap();
            assert!(next.distance_squared(&q) < 0.01, "{next:?} after {q:?}");
            assert!((arm.flange_pose(&next).translation - pose.translation).norm() < 1e-10);
            q = next;
        }
        let outside = Pose::from_translation(0.0, 0.0, 2.0);
        assert_eq!(arm.inverse_continuous(&outside, &Pose::IDENTITY, &q), None);
    }
}

#[test]
fn the_same_question_has_the_same_answer() {
    let arm = spherical_wrist();
    let pose = arm.flange_pose(&positions(&arm, 42));
    let far = positions(&arm, 77);
    let first = arm.inverse_nearest(&pose, &Pose::IDENTITY, &far);
    assert!(first.is_some());
    for _ in 0..5 {
        assert_eq!(arm.inverse_nearest(&pose, &Pose::IDENTITY, &far), first);
    }
}
