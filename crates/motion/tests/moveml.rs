//! moveml: through every point in order, at the times of the list where the joints can keep up, within every limit.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]

use crate::common;

use common::{Bench, MODELS, ideal};
use kinematics::rotation::{rotation_from_rotvec, rotvec_from_rotation};
use kinematics::{JointPositions, Pose, RobotModel};
use motion_api::{
    CommandId, MachineCommand, MotionCommand, MotionMode, OnlineCommand, Outcome, PathFault,
    PointList, Refusal, SettingCommand, Warning,
};
use nalgebra::{UnitQuaternion, Vector3};

fn moveml(bench: &mut Bench, points: &[JointPositions], interval: f64) -> CommandId {
    bench.moveml(points, interval)
}

/// A wave of some joints that begins at `home`.
fn wave(home: &JointPositions, count: usize, size: f64, turns: f64) -> Vec<JointPositions> {
    (0..count)
        .map(|k| {
            let share = k as f64 / (count - 1) as f64;
            let angle = share * turns * std::f64::consts::TAU;
            let mut q = *home;
            q[0] += size * (1.0 - angle.cos());
            q[3] += size * angle.sin() * share;
            q[5] -= size * share;
            q
        })
        .collect()
}

/// The points of `points` that no state comes within 1e-3 rad of, in order.
fn missed(bench: &Bench, from: usize, points: &[JointPositions]) -> usize {
    let away = |a: &JointPositions, b: &JointPositions| {
        (0..6).fold(0.0_f64, |m, k| m.max((a[k] - b[k]).abs()))
    };
    let mut at = from;
    let mut missed = 0;
    for point in points {
        // Between two cycles the arm passes the point: the segment between the states comes near to it.
        let near = (at..bench.states.len() - 1).find(|k| {
            let (a, b) = (&bench.states[*k].target_q, &bench.states[*k + 1].target_q);
            let way: f64 = (0..6).map(|j| (b[j] - a[j]).powi(2)).sum();
            let along: f64 = (0..6).map(|j| (point[j] - a[j]) * (b[j] - a[j])).sum();
            let share = if way > 0.0 {
                (along / way).clamp(0.0, 1.0)
            } else {
                0.0
            };
            let there = JointPositions(core::array::from_fn(|j| a[j] + share * (b[j] - a[j])));
            away(&there, point) < 1e-3
        });
        match near {
            Some(k) => at = k,
            None => missed += 1,
        }
    }
    missed
}

#[test]
fn the_arm_goes_through_every_point_in_the_time_of_the_list() {
    for name in MODELS {
        let mut bench = Bench::new(ideal(name));
        let points = wave(&bench.now().target_q, 400, 0.3, 2.0);
        let id = moveml(&mut bench, &points, 0.010);
        let from = bench.states.len();
        assert_eq!(bench.finish(id), Outcome::Done);
        assert!(bench.warnings.is_empty(), "{:?}", bench.warnings);
        bench.check_limits();
        assert_eq!(bench.now().target_q, points[399]);
        assert_eq!(missed(&bench, from, &points), 0);
        let moving = bench
            .states
            .iter()
            .filter(|s| s.motion_mode == MotionMode::MoveMl);
        let seconds = moving.count() as f64 * 0.004;
        // The list does not begin and end at rest: starting and stopping take their time, and planning a few cycles.
        assert!((3.99..5.0).contains(&seconds), "{name}: {seconds}");
    }
}

#[test]
fn a_list_that_is_too_fast_is_slowed_within_every_limit_with_a_warning() {
    for name in MODELS {
        let mut bench = Bench::new(ideal(name));
        let points = wave(&bench.now().target_q, 300, 0.5, 3.0);
        let id = moveml(&mut bench, &points, 0.002);
        let from = bench.states.len();
        assert_eq!(bench.finish(id), Outcome::Done);
        bench.check_limits();
        assert_eq!(missed(&bench, from, &points), 0);
        let is_told = bench.warnings.iter().any(|(warned, warning)| {
            *warned == id && matches!(warning, Warning::DurationStretched { .. })
        });
        assert!(is_told, "{name} {:?}", bench.warnings);
    }
}

#[test]
fn corners_and_repeated_points_are_passed_within_the_limits() {
    let mut bench = Bench::new(ideal("cs66"));
    let home = bench.now().target_q;
    let mut points = vec![home];
    for (joint, by) in [(0, 0.2), (1, 0.1), (0, -0.3), (4, 0.2)] {
        for _ in 0..20 {
            let mut next = *points.last().unwrap();
            next[joint] += by / 20.0;
            points.push(next);
        }
        for _ in 0..5 {
            points.push(*points.last().unwrap());
        }
    }
    let id = moveml(&mut bench, &points, 0.02);
    let from = bench.states.len();
    assert_eq!(bench.finish(id), Outcome::Done);
    bench.check_limits();
    assert_eq!(missed(&bench, from, &points), 0);
}

#[test]
fn slider_pause_and_stop_stay_on_the_way() {
    let mut bench = Bench::new(ideal("cs66"));
    let points = wave(&bench.now().target_q, 200, 0.3, 1.0);
    let id = moveml(&mut bench, &points, 0.010);
    let from = bench.states.len();
    bench.run(60);
    bench.send(SettingCommand::SetSpeedFraction(0.4));
    bench.run(60);
    bench.do_it(MachineCommand::Pause);
    bench.run(20);
    assert_eq!(bench.now().target_qd.max_abs(), 0.0);
    bench.do_it(MachineCommand::Resume);
    bench.run(100);
    bench.send(SettingCommand::SetSpeedFraction(1.0));
    assert_eq!(bench.finish(id), Outcome::Done);
    assert_eq!(missed(&bench, from, &points), 0);
    bench.check_limits();

    let back: Vec<JointPositions> = points.iter().rev().copied().collect();
    let id = moveml(&mut bench, &back, 0.010);
    bench.run(150);
    bench.do_it(OnlineCommand::StopJ { acceleration: 2.0 });
    assert_eq!(bench.outcome(id), Some(Outcome::Aborted));
    bench.check_limits();
}

#[test]
fn what_cannot_be_run_is_refused_by_name_and_the_arm_stays() {
    let mut bench = Bench::new(ideal("cs66"));
    let home = bench.now().target_q;
    let points = wave(&home, 20, 0.1, 1.0);
    let refused = |bench: &mut Bench, id| match bench.finish(id) {
        Outcome::Refused(refusal) => refusal.to_string(),
        other => panic!("{other:?}"),
    };
    // No points, and not all of them.
    let id = bench.send(MotionCommand::MoveMl {
        count: 20,
        interval: 0.01,
    });
    assert!(refused(&mut bench, id).contains("number of points"));
    // From somewhere else.
    let id = moveml(&mut bench, &points[10..], 0.01);
    assert!(refused(&mut bench, id).contains("first point"));
    for interval in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let id = moveml(&mut bench, &points, interval);
        assert!(refused(&mut bench, id).contains("time between points"));
    }
    let mut far = points.clone();
    far[12][0] = 7.0;
    let id = moveml(&mut bench, &far, 0.01);
    let outcome = bench.finish(id);
    assert!(
        matches!(
            outcome,
            Outcome::Refused(Refusal::Path {
                fault: PathFault::JointLimit { joint: 0, .. },
                ..
            })
        ),
        "{outcome:?}"
    );
    assert_eq!(bench.now().target_q, home);
    assert!(bench.states.iter().all(|s| s.target_q == home));
}

#[test]
fn points_do_not_change_under_a_motion() {
    let mut bench = Bench::new(ideal("cs66"));
    let points = wave(&bench.now().target_q, 100, 0.2, 1.0);
    let id = moveml(&mut bench, &points, 0.010);
    bench.run(50);
    let other = moveml(&mut bench, &points[..4], 0.010);
    bench.run(2);
    assert!(matches!(
        bench.outcome(other),
        Some(Outcome::Refused(Refusal::Busy { .. }))
    ));
    assert_eq!(bench.finish(id), Outcome::Done);
    assert_eq!(bench.now().target_q, points[99]);
}

fn moveml_of_poses(bench: &mut Bench, poses: &[Pose], interval: f64) -> CommandId {
    let sample = |pose: &Pose| {
        let turn = UnitQuaternion::from_rotation_matrix(&pose.rotation);
        // Any sign and length stand for the same rotation, as long as they go on.
        let size = 1.1 * turn.i.signum();
        let at = pose.translation;
        let [w, i, j, k] = [turn.w, turn.i, turn.j, turn.k].map(|x| x * size);
        [at.x, at.y, at.z, w, i, j, k]
    };
    let samples = poses.iter().map(sample).collect();
    bench.send_points(PointList::new(samples, true).unwrap(), interval)
}

/// Poses on a circle of the TCP beside `start`, which turns the tool to and fro by `turn` rad.
fn circle(start: &Pose, count: usize, radius: f64, turn: f64) -> Vec<Pose> {
    (0..count)
        .map(|k| {
            let angle = k as f64 / (count - 1) as f64 * std::f64::consts::TAU;
            let by = Vector3::new(radius * (angle.cos() - 1.0), radius * angle.sin(), 0.0);
            let turned = rotation_from_rotvec(Vector3::new(0.3, 1.0, 0.2) * (turn * angle.sin()));
            Pose::new(turned * start.rotation, start.translation + by)
        })
        .collect()
}

#[test]
fn between_poses_the_tcp_keeps_to_a_smooth_way_and_turns_with_it() {
    for name in MODELS {
        // Few points, far apart: the joints alone would leave the circle by millimetres.
        for (count, interval) in [(17, 0.25), (201, 0.02)] {
            let mut bench = Bench::new(ideal(name));
            let arm = RobotModel::built_in(name).unwrap();
            let start = arm.tcp_pose(&bench.now().target_q, &Pose::IDENTITY);
            let poses = circle(&start, count, 0.05, 0.4);
            let id = moveml_of_poses(&mut bench, &poses, interval);
            assert_eq!(bench.finish(id), Outcome::Done, "{name}");
            bench.check_limits();
            let end = arm.tcp_pose(&bench.now().target_q, &Pose::IDENTITY);
            assert!((end.translation - poses[count - 1].translation).norm() < 1e-9);
            let mut off = 0.0_f64;
            let mut off_turn = 0.0_f64;
            let mut nearest = vec![f64::INFINITY; count];
            for state in &bench.states {
                let pose = arm.tcp_pose(&state.target_q, &Pose::IDENTITY);
                let by = pose.translation - start.translation + Vector3::new(0.05, 0.0, 0.0);
                off = off.max((by.norm() - 0.05).abs());
                let angle = by.y.atan2(by.x);
                let turned = rotvec_from_rotation(&(pose.rotation * start.rotation.inverse()));
                let wanted = Vector3::new(0.3, 1.0, 0.2) * (0.4 * angle.sin());
                off_turn = off_turn.max((turned - wanted).norm());
                for (near, point) in nearest.iter_mut().zip(&poses) {
                    *near = near.min((point.translation - pose.translation).norm());
                }
            }
            let (most, most_turn) = if count < 50 {
                (4e-4, 5e-3)
            } else {
                (1e-6, 1e-5)
            };
            assert!(off < most, "{name} {count}: {off} m");
            assert!(off_turn < most_turn, "{name} {count}: {off_turn} rad");
            // Between two cycles the arm is at most half a cycle's way from a point.
            assert!(
                nearest.iter().all(|near| *near < 6e-4),
                "{name} {nearest:?}"
            );
        }
    }
}

#[test]
fn poses_that_cannot_be_followed_are_refused_and_the_arm_stays() {
    let mut bench = Bench::new(ideal("cs66"));
    let home = bench.now().target_q;
    let arm = RobotModel::built_in("cs66").unwrap();
    let start = arm.tcp_pose(&home, &Pose::IDENTITY);
    let mut poses = circle(&start, 40, 0.05, 0.1);
    for pose in &mut poses[20..] {
        pose.translation.x += 2.0;
    }
    let run = |bench: &mut Bench, poses: &[Pose]| {
        let id = moveml_of_poses(bench, poses, 0.1);
        bench.finish(id)
    };
    let outcome = run(&mut bench, &poses);
    assert!(
        matches!(
            outcome,
            Outcome::Refused(Refusal::Path {
                fault: PathFault::OutOfReach,
                ..
            })
        ),
        "{outcome:?}"
    );
    // From somewhere else.
    let outcome = run(&mut bench, &circle(&start, 40, 0.05, 0.1)[5..]);
    assert!(
        matches!(outcome, Outcome::Refused(Refusal::BadValue { .. })),
        "{outcome:?}"
    );
    assert!(bench.states.iter().all(|state| state.target_q == home));
}
