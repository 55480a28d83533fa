//! Durations of motions with a blend radius: the time of each counts from waypoint to waypoint.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]

use crate::common;

use common::{Bench, MODELS, ideal, moved, movej};
use kinematics::{JointPositions, RpyPose};
use motion_api::{CommandId, CommandKind, MotionCommand, Outcome, SettingCommand, Warning};
use nalgebra::Vector3;

/// Cycles from sending a command to the first of its motion, and to see that an arm stands.
const PLANNING: f64 = 4.0 * STEP;
const STEP: f64 = 0.004;

fn line(target: RpyPose, duration: f64, radius: f64) -> CommandKind {
    CommandKind::Motion(MotionCommand::MoveL {
        target,
        acceleration: 1.2,
        speed: 0.25,
        duration,
        radius,
    })
}

fn joint(target: JointPositions, duration: f64, radius: f64) -> CommandKind {
    CommandKind::Motion(MotionCommand::MoveJ {
        target,
        acceleration: 1.4,
        speed: 1.0,
        duration,
        radius,
    })
}

/// Sends each when it is due; then until the arm stands. How long that took, s, and the commands.
fn chain(bench: &mut Bench, kinds: &[CommandKind]) -> (f64, Vec<CommandId>) {
    let begun = bench.now().time;
    let ids: Vec<CommandId> = kinds
        .iter()
        .map(|kind| {
            let id = bench.send(*kind);
            bench.until_due(id);
            id
        })
        .collect::<Vec<_>>();
    for id in &ids {
        assert_eq!(bench.finish(*id), Outcome::Done, "{:?}", bench.stops);
    }
    while !bench.cycle.is_standing() {
        bench.tick();
    }
    bench.check_limits();
    (bench.now().time - begun, ids)
}

fn corner(model: &str) -> (Bench, RpyPose) {
    let mut bench = Bench::new(ideal(model));
    bench.do_it(movej(JointPositions([0.3, -1.4, 1.7, -1.8, -1.5, 0.2])));
    let start = bench.now().target_tcp_pose;
    (bench, start)
}

#[test]
fn timed_motions_with_blends_take_the_sum_of_their_times() {
    for model in MODELS {
        for (times, radius) in [
            ([1.5, 2.0, 1.2], 0.03),
            ([1.0, 3.0, 1.0], 0.02),
            ([3.0, 1.0, 4.0], 0.05),
            ([1.2, 1.2, 1.2], 0.001),
        ] {
            let (mut bench, start) = corner(model);
            let mut home = bench.now().target_q;
            home[0] += 0.2;
            let kinds = [
                line(moved(&start, [0.0, 0.12, 0.05]), times[0], radius),
                line(moved(&start, [-0.1, 0.12, 0.05]), times[1], radius),
                joint(home, times[2], 0.0),
            ];
            let (took, _) = chain(&mut bench, &kinds);
            let asked: f64 = times.iter().sum();
            assert!(
                bench.warnings.is_empty(),
                "{model} {times:?} {radius} {:?}",
                bench.warnings
            );
            assert!(
                (asked - STEP..=asked + PLANNING).contains(&took),
                "{model} {times:?} {radius}: {took}, asked was {asked}"
            );
        }
    }
}

#[test]
fn a_single_timed_motion_with_a_radius_ends_at_its_waypoint_in_its_time() {
    let (mut bench, start) = corner("cs66");
    let target = moved(&start, [0.0, 0.12, 0.05]);
    let (took, _) = chain(&mut bench, &[line(target, 2.0, 0.03)]);
    assert!((2.0 - STEP..=2.0 + PLANNING).contains(&took), "{took}");
    let off = Vector3::from(bench.now().target_tcp_pose.xyz) - Vector3::from(target.xyz);
    assert!(off.norm() < 1e-9, "{off:?}");
}

#[test]
fn the_time_of_a_motion_after_an_untimed_one_counts_from_the_middle_of_the_blend() {
    let (mut bench, start) = corner("cs66");
    let waypoint = moved(&start, [0.0, 0.12, 0.0]);
    let end = moved(&waypoint, [-0.12, 0.0, 0.0]);
    let (_, ids) = chain(
        &mut bench,
        &[line(waypoint, 0.0, 0.04), line(end, 2.0, 0.0)],
    );
    let stood = bench.ended.iter().find(|e| e.0 == ids[1]).unwrap().2;
    let nearest = bench
        .states
        .iter()
        .min_by(|a, b| {
            let away = |xyz: [f64; 3]| (Vector3::from(xyz) - Vector3::from(waypoint.xyz)).norm();
            away(a.target_tcp_pose.xyz).total_cmp(&away(b.target_tcp_pose.xyz))
        })
        .unwrap();
    let took = (stood - nearest.cycle) as f64 * STEP;
    assert!((took - 2.0).abs() < 3.0 * STEP, "{took}");
}

#[test]
fn a_time_too_short_after_a_blend_is_told_with_the_time_that_it_takes() {
    let (mut bench, start) = corner("cs66");
    let waypoint = moved(&start, [0.0, 0.12, 0.0]);
    let end = moved(&waypoint, [-0.2, 0.0, 0.0]);
    let kinds = [line(waypoint, 1.0, 0.04), line(end, 0.1, 0.0)];
    let (took, ids) = chain(&mut bench, &kinds);
    let [(id, Warning::DurationStretched { wanted, planned })] = bench.warnings[..] else {
        panic!("{:?}", bench.warnings);
    };
    assert_eq!((id, wanted), (ids[1], 0.1));
    let asked = 1.0 + planned;
    assert!(
        planned > 0.1 && (asked - STEP..=asked + PLANNING).contains(&took),
        "{took} {planned}"
    );
}

#[test]
fn at_half_the_speed_timed_motions_take_twice_their_times() {
    let (mut bench, start) = corner("cs66");
    bench.do_it(SettingCommand::SetSpeedFraction(0.5));
    let waypoint = moved(&start, [0.0, 0.12, 0.0]);
    let kinds = [
        line(waypoint, 1.0, 0.04),
        line(moved(&waypoint, [-0.12, 0.0, 0.0]), 1.5, 0.0),
    ];
    let (took, _) = chain(&mut bench, &kinds);
    assert!(
        (5.0 - 2.0 * STEP..=5.0 + PLANNING).contains(&took),
        "{took}"
    );
}
