//! Blends and arcs on the ideal arm: inside the radius, without a stop, within every limit, exact at the end.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]
#![allow(
    clippy::approx_constant,
    reason = "joint angles and speeds as people type them"
)]

use crate::common;

use common::{Bench, MODELS, ideal, moved, movej, tcp_speed};
use kinematics::{JointPositions, Pose, RobotModel, RpyPose};
use motion_api::{
    CommandId, CommandKind, FreedriveFrame, MachineCommand, MotionCommand, OnlineCommand, Outcome,
    Refusal, RobotState, SettingCommand, Warning,
};
use nalgebra::Vector3;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn tcp(state: &RobotState) -> Vector3<f64> {
    Vector3::from(state.target_tcp_pose.xyz)
}

fn line(target: RpyPose, speed: f64, radius: f64) -> CommandKind {
    CommandKind::Motion(MotionCommand::MoveL {
        target,
        acceleration: 1.2,
        speed,
        duration: 0.0,
        radius,
    })
}

fn joint(target: JointPositions, radius: f64) -> CommandKind {
    CommandKind::Motion(MotionCommand::MoveJ {
        target,
        acceleration: 1.4,
        speed: 1.0,
        duration: 0.0,
        radius,
    })
}

fn arc(via: RpyPose, target: RpyPose, radius: f64) -> CommandKind {
    CommandKind::Motion(MotionCommand::MoveC {
        via,
        target,
        acceleration: 1.2,
        speed: 0.25,
        radius,
        fixed: false,
    })
}

/// Sends each command when it is due; until the last one has ended.
fn chain(bench: &mut Bench, kinds: &[CommandKind]) -> Vec<CommandId> {
    let mut ids = Vec::new();
    for kind in kinds {
        let id = bench.send(*kind);
        bench.until_due(id);
        ids.push(id);
    }
    for (id, kind) in ids.iter().zip(kinds) {
        let outcome = bench.finish(*id);
        assert_eq!(outcome, Outcome::Done, "{kind:?} {:?}", bench.stops);
    }
    ids
}

/// Slowest TCP speed from the first blend zone on, until the last command brakes.
fn slowest_between(bench: &Bench, ids: &[CommandId]) -> f64 {
    let at = |id: CommandId| bench.ended.iter().find(|e| e.0 == id).unwrap().2;
    let (from, to) = (at(ids[0]), at(ids[ids.len() - 1]) - 80);
    bench
        .states
        .iter()
        .filter(|s| s.cycle >= from && s.cycle <= to)
        .map(tcp_speed)
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn two_lines_blend_inside_the_radius_without_a_stop() {
    let mut bench = Bench::new(ideal("cs66"));
    let start = bench.now().target_tcp_pose;
    let corner = moved(&start, [0.0, 0.2, 0.0]);
    let end = moved(&corner, [-0.2, 0.0, 0.0]);
    let ids = chain(
        &mut bench,
        &[line(corner, 0.25, 0.05), line(end, 0.25, 0.0)],
    );
    assert!(bench.warnings.is_empty(), "{:?}", bench.warnings);
    bench.check_limits();
    let slowest = slowest_between(&bench, &ids);
    assert!(slowest > 0.15, "{slowest}");
    let (a, b, c) = (
        Vector3::from(start.xyz),
        Vector3::from(corner.xyz),
        Vector3::from(end.xyz),
    );
    let off = |p: Vector3<f64>, from: Vector3<f64>, to: Vector3<f64>| {
        let way = (to - from).normalize();
        ((p - from) - way * (p - from).dot(&way)).norm()
    };
    let mut inside = 0;
    for state in &bench.states {
        let p = tcp(state);
        let away = off(p, a, b).min(off(p, b, c));
        if (p - b).norm() > 0.05 {
            assert!(away < 1e-9, "{away:e} outside of the radius");
        } else if away > 1e-3 {
            inside += 1;
        }
        assert!(tcp_speed(state) < 0.25 + 1e-6);
    }
    assert!(inside > 5, "the corner is not cut");
    assert!((tcp(&bench.now()) - c).norm() < 1e-9);
    // The first command ended where the zone begins.
    let entered = bench.ended.iter().find(|e| e.0 == ids[0]).unwrap().2;
    let at = |cycle: u64| {
        bench
            .states
            .iter()
            .find(|s| s.cycle == cycle)
            .map(|s| (tcp(s) - b).norm())
            .unwrap()
    };
    assert!(at(entered) <= 0.05 && at(entered - 1) > 0.05);
}

#[test]
fn any_two_kinds_of_motion_blend() {
    for model in MODELS {
        let reach = RobotModel::built_in(model).unwrap();
        for first in 0..3 {
            for second in 0..3 {
                let mut bench = Bench::new(ideal(model));
                bench.do_it(movej(JointPositions([0.3, -1.4, 1.7, -1.8, -1.5, 0.2])));
                let q = bench.now().target_q;
                let start = bench.now().target_tcp_pose;
                let before = bench.ended.len();
                let leg = |from: &RpyPose, q: &JointPositions, kind: usize, sign: f64, radius| {
                    let mut turned = *q;
                    turned[0] += 0.3 * sign;
                    turned[1] += 0.2;
                    match kind {
                        0 => {
                            let target = reach.tcp_pose(&turned, &Pose::IDENTITY).to_rpy();
                            (joint(turned, radius), turned, target)
                        }
                        1 => {
                            let target = moved(from, [0.0, 0.12 * sign, 0.08]);
                            let near = reach
                                .inverse_nearest(&Pose::from_rpy(&target), &Pose::IDENTITY, q)
                                .unwrap();
                            (line(target, 0.25, radius), near, target)
                        }
                        _ => {
                            let target = moved(from, [0.0, 0.1 * sign, 0.06]);
                            let via = moved(from, [0.03, 0.06 * sign, 0.01]);
                            let near = reach
                                .inverse_nearest(&Pose::from_rpy(&target), &Pose::IDENTITY, q)
                                .unwrap();
                            (arc(via, target, radius), near, target)
                        }
                    }
                };
                let (one, q1, corner) = leg(&start, &q, first, 1.0, 0.03);
                let (two, q2, _) = leg(&corner, &q1, second, -1.0, 0.0);
                let ids = chain(&mut bench, &[one, two]);
                let at = format!("{model} {first} {second}");
                // What a leg cannot have by itself is said; the blend adds nothing to it.
                let mut alone = Bench::new(ideal(model));
                alone.do_it(movej(q));
                let (one, ..) = leg(&start, &q, first, 1.0, 0.0);
                chain(&mut alone, &[one, two]);
                assert_eq!(bench.warnings, alone.warnings, "{at}");
                bench.check_limits();
                let slowest = slowest_between(&bench, &ids);
                assert!(slowest > 0.01, "{at}: {slowest}");
                let error = (0..6)
                    .map(|k| (bench.now().target_q[k] - q2[k]).abs())
                    .fold(0.0, f64::max);
                assert!(error < 1e-9, "{at}: {error:e}");
                assert_eq!(bench.ended.len(), before + 2);
            }
        }
    }
}

#[test]
fn a_chain_of_a_hundred_segments_streams_without_a_stop() {
    let mut bench = Bench::new(ideal("cs66"));
    let centre = bench.now().target_tcp_pose;
    let kinds: Vec<CommandKind> = (0..100)
        .map(|k| {
            let side = if k % 2 == 0 { 0.02 } else { -0.02 };
            let target = moved(&centre, [side, -0.2 + 0.004 * f64::from(k), 0.0]);
            line(target, 0.25, if k == 99 { 0.0 } else { 0.01 })
        })
        .collect();
    let ids = chain(&mut bench, &kinds);
    assert!(bench.warnings.is_empty(), "{:?}", bench.warnings);
    bench.check_limits();
    // The legs turn by 169 degrees: at each tip only the way forward is left, a tenth of the speed on the curve.
    let slowest = slowest_between(&bench, &ids);
    assert!(slowest > 0.005, "{slowest}");
}

#[test]
fn a_polygon_walked_many_times_keeps_its_speed() {
    let mut bench = Bench::new(ideal("cs66"));
    let centre = moved(&bench.now().target_tcp_pose, [-0.1, 0.0, 0.0]);
    let kinds: Vec<CommandKind> = (1..=60)
        .map(|k| {
            let angle = f64::from(k) * core::f64::consts::TAU / 12.0;
            let target = moved(&centre, [0.1 * angle.cos(), 0.1 * angle.sin(), 0.0]);
            line(target, 0.25, if k == 60 { 0.0 } else { 0.02 })
        })
        .collect();
    let ids = chain(&mut bench, &kinds);
    assert!(bench.warnings.is_empty(), "{:?}", bench.warnings);
    bench.check_limits();
    let slowest = slowest_between(&bench, &ids);
    assert!(slowest > 0.1, "{slowest}");
}

#[test]
fn without_a_successor_the_arm_stops_at_the_waypoint() {
    let mut bench = Bench::new(ideal("cs66"));
    let corner = moved(&bench.now().target_tcp_pose, [0.0, 0.2, 0.0]);
    let id = bench.send(line(corner, 0.25, 0.05));
    bench.finish(id);
    assert!(!bench.cycle.is_standing());
    bench.run(300);
    assert!(bench.cycle.is_standing());
    assert!((tcp(&bench.now()) - Vector3::from(corner.xyz)).norm() < 1e-9);
    assert_eq!(bench.ended.len(), 1);
    bench.check_limits();
}

#[test]
fn a_successor_that_comes_late_begins_from_rest_at_the_waypoint() {
    let mut bench = Bench::new(ideal("cs66"));
    let start = bench.now().target_tcp_pose;
    let corner = moved(&start, [0.0, 0.2, 0.0]);
    let end = moved(&corner, [-0.1, 0.0, 0.0]);
    for wait in [5, 15, 30, 45, 60, 75, 90, 120] {
        bench.do_it(line(start, 0.25, 0.0));
        bench.do_it(line(corner, 0.25, 0.05));
        bench.run(wait);
        assert_eq!(bench.do_it(line(end, 0.25, 0.0)), Outcome::Done);
        assert!((tcp(&bench.now()) - Vector3::from(end.xyz)).norm() < 1e-9);
    }
    bench.check_limits();
}

#[test]
fn overlapping_radii_are_shortened_with_a_warning() {
    let mut bench = Bench::new(ideal("cs66"));
    let a = bench.now().target_tcp_pose;
    let b = moved(&a, [0.0, 0.15, 0.0]);
    let c = moved(&b, [-0.08, 0.0, 0.0]);
    let d = moved(&c, [0.0, 0.15, 0.0]);
    chain(
        &mut bench,
        &[line(b, 0.25, 0.06), line(c, 0.25, 0.06), line(d, 0.25, 0.0)],
    );
    assert!(
        bench.warnings.iter().any(
            |(_, w)| matches!(w, Warning::RadiusShortened { wanted, planned }
                if *wanted == 0.06 && *planned < 0.05)
        ),
        "{:?}",
        bench.warnings
    );
    bench.check_limits();
    assert!((tcp(&bench.now()) - Vector3::from(d.xyz)).norm() < 1e-9);
}

#[test]
fn a_blend_at_any_speed_takes_the_same_way_and_can_be_paused() {
    for fraction in [1.0, 0.3] {
        let mut bench = Bench::new(ideal("cs66"));
        bench.do_it(SettingCommand::SetSpeedFraction(fraction));
        let a = bench.now().target_tcp_pose;
        let b = moved(&a, [0.0, 0.2, 0.0]);
        let c = moved(&b, [-0.2, 0.0, 0.1]);
        bench.do_it(line(b, 0.25, 0.05));
        let id = bench.send(line(c, 0.25, 0.0));
        bench.run(10);
        bench.do_it(MachineCommand::Pause);
        bench.run(50);
        let held = bench.now();
        assert!(held.target_qd.max_abs() == 0.0);
        bench.do_it(MachineCommand::Resume);
        assert_eq!(bench.finish(id), Outcome::Done);
        assert!((tcp(&bench.now()) - Vector3::from(c.xyz)).norm() < 1e-9);
        bench.check_limits();
    }
}

#[test]
fn a_stop_in_the_blend_ends_the_next_motion_where_it_rests() {
    let mut bench = Bench::new(ideal("cs66"));
    let a = bench.now().target_tcp_pose;
    let b = moved(&a, [0.0, 0.2, 0.0]);
    bench.do_it(line(b, 0.25, 0.05));
    let id = bench.send(line(moved(&b, [-0.2, 0.0, 0.0]), 0.25, 0.0));
    bench.run(20);
    bench.do_it(MachineCommand::Stop {
        only: CommandId::NONE,
    });
    assert_eq!(bench.outcome(id), Some(Outcome::Aborted));
    assert!(bench.cycle.is_standing());
    bench.check_limits();
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, rng_seed: RngSeed::Fixed(6), ..ProptestConfig::default() })]

    /// Whatever follows whatever, at any speed and radius and with any delay: every limit is kept in every cycle,
    /// nothing stops the arm, and the end is exact.
    #[test]
    fn any_chain_keeps_the_limits_and_arrives(
        legs in prop::collection::vec(
            (0..3usize, prop::array::uniform3(-0.08..0.08f64), 0.02..0.8f64, 0.0..0.06f64, 0..12usize),
            2..8,
        ),
        model in 0..MODELS.len(),
    ) {
        let mut bench = Bench::new(ideal(MODELS[model]));
        bench.do_it(movej(JointPositions([0.3, -1.4, 1.7, -1.8, -1.5, 0.2])));
        let centre = bench.now().target_tcp_pose;
        let q = bench.now().target_q;
        for (kind, by, speed, radius, wait) in legs {
            let target = moved(&centre, by);
            let kind = match kind {
                0 => {
                    let turned = JointPositions(std::array::from_fn(|k| q[k] + 3.0 * by[k % 3]));
                    joint(turned, radius)
                }
                1 => line(target, speed, radius),
                _ => arc(moved(&centre, [by[1], by[2], by[0]]), target, radius),
            };
            // Some cannot be reached or make no arc: refused, and the arm stops where it was going.
            bench.do_it(kind);
            bench.run(wait);
        }
        prop_assert_eq!(bench.do_it(line(centre, 0.25, 0.0)), Outcome::Done);
        prop_assert!((tcp(&bench.now()) - Vector3::from(centre.xyz)).norm() < 1e-9);
        prop_assert!(bench.stops.is_empty(), "{:?}", bench.stops);
        bench.check_limits();
    }
}

const STOPJ: CommandKind = CommandKind::Online(OnlineCommand::StopJ { acceleration: 4.0 });
const STOPL: CommandKind = CommandKind::Online(OnlineCommand::StopL { acceleration: 4.0 });
const STOP: CommandKind = CommandKind::Machine(MachineCommand::Stop {
    only: CommandId::NONE,
});

fn servoj(target: JointPositions) -> CommandKind {
    CommandKind::Online(OnlineCommand::ServoJ {
        target,
        duration: 0.1,
        lookahead: 0.1,
        gain: 300.0,
    })
}

#[test]
fn any_stop_ends_a_motion_that_has_not_begun() {
    for stop in [STOPJ, STOPL, STOP] {
        let mut bench = Bench::new(ideal("cs66"));
        let start = bench.now().target_q;
        let corner = moved(&bench.now().target_tcp_pose, [0.0, 0.2, 0.0]);
        // Both are taken in one cycle: the plan is made later.
        let id = bench.send(line(corner, 0.25, 0.0));
        assert_eq!(bench.do_it(stop), Outcome::Done);
        assert_eq!(bench.outcome(id), Some(Outcome::Aborted), "{stop:?}");
        bench.run(50);
        assert_eq!(bench.now().target_q, start, "{stop:?}");
        assert!(bench.cycle.is_standing());
    }
}

#[test]
fn any_stop_in_the_zone_ends_the_motion_that_is_to_follow() {
    for stop in [STOPJ, STOPL, STOP] {
        let mut bench = Bench::new(ideal("cs66"));
        let corner = moved(&bench.now().target_tcp_pose, [0.0, 0.2, 0.0]);
        bench.do_it(line(corner, 0.25, 0.05));
        let id = bench.send(line(moved(&corner, [-0.2, 0.0, 0.0]), 0.25, 0.0));
        assert_eq!(bench.do_it(stop), Outcome::Done);
        assert_eq!(bench.outcome(id), Some(Outcome::Aborted), "{stop:?}");
        assert!(bench.cycle.is_standing());
        let away = (tcp(&bench.now()) - Vector3::from(corner.xyz)).norm();
        assert!(away > 1e-3 && away < 0.05, "{away}");
        bench.check_limits();
    }
}

#[test]
fn online_modes_are_refused_while_a_motion_is_to_follow() {
    let freedrive = CommandKind::Online(OnlineCommand::Freedrive {
        free_axes: [true; 6],
        frame: FreedriveFrame::Base,
    });
    for radius in [0.0, 0.05] {
        let mut bench = Bench::new(ideal("cs66"));
        let corner = moved(&bench.now().target_tcp_pose, [0.0, 0.2, 0.0]);
        if radius > 0.0 {
            bench.do_it(line(corner, 0.25, radius));
        }
        let id = bench.send(line(moved(&corner, [-0.1, 0.0, 0.0]), 0.25, 0.0));
        for kind in [servoj(bench.now().target_q), freedrive] {
            let busy = Outcome::Refused(Refusal::Busy { running: id });
            assert_eq!(bench.do_it(kind), busy, "{kind:?} {radius}");
        }
        assert_eq!(bench.finish(id), Outcome::Done);
    }
}

#[test]
fn an_online_mode_after_a_blend_radius_begins_at_the_waypoint() {
    let mut bench = Bench::new(ideal("cs66"));
    let corner = moved(&bench.now().target_tcp_pose, [0.0, 0.2, 0.0]);
    bench.do_it(line(corner, 0.25, 0.05));
    let id = bench.send(servoj(bench.now().target_q));
    let late = bench.send(line(corner, 0.25, 0.0));
    let busy = Outcome::Refused(Refusal::Busy { running: id });
    assert_eq!(bench.finish(late), busy);
    assert_eq!(bench.finish(id), Outcome::Done);
    let nearest = bench
        .states
        .iter()
        .map(|s| (tcp(s) - Vector3::from(corner.xyz)).norm())
        .fold(f64::INFINITY, f64::min);
    assert!(nearest < 1e-9, "{nearest:e}");
    bench.run(300);
    assert!(bench.cycle.is_standing());
    bench.check_limits();
}

#[test]
fn an_arc_keeps_its_radius_and_passes_its_via_point() {
    for fixed in [false, true] {
        for model in MODELS {
            let mut bench = Bench::new(ideal(model));
            let start = bench.now().target_tcp_pose;
            let r = 0.08;
            let centre = Vector3::from(start.xyz) + Vector3::new(-r, 0.0, 0.0);
            let at = |angle: f64| {
                let mut pose = start;
                pose.xyz = (centre + Vector3::new(angle.cos(), angle.sin(), 0.0) * r).into();
                pose
            };
            let (via, end) = (at(2.0), at(4.5));
            let outcome = bench.do_it(MotionCommand::MoveC {
                via,
                target: end,
                acceleration: 1.2,
                speed: 0.25,
                radius: 0.0,
                fixed,
            });
            assert_eq!(outcome, Outcome::Done, "{model}");
            let nearest = bench
                .states
                .iter()
                .map(|s| (tcp(s) - Vector3::from(via.xyz)).norm())
                .fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-3, "{model} {nearest}");
            for state in &bench.states {
                let off = (tcp(state) - centre).norm() - r;
                assert!(off.abs() < 1e-9, "{model} {off:e}");
            }
            let (last, first) = (bench.now().target_tcp_pose, start);
            assert!((tcp(&bench.now()) - Vector3::from(end.xyz)).norm() < 1e-9);
            let turned = Pose::from_rpy(&last).rotation * Pose::from_rpy(&first).rotation.inverse();
            let expected = if fixed {
                Vector3::new(0.0, 0.0, 4.5 - std::f64::consts::TAU)
            } else {
                Vector3::zeros()
            };
            let turned = kinematics::rotation::rotvec_from_rotation(&turned);
            assert!((turned - expected).norm() < 1e-9, "{model} {turned}");
            bench.check_limits();
        }
    }
}

#[test]
fn points_on_a_line_make_no_arc() {
    let mut bench = Bench::new(ideal("cs66"));
    let a = bench.now().target_tcp_pose;
    let via = moved(&a, [0.0, 0.1, 0.0]);
    for end in [moved(&a, [0.0, 0.2, 0.0]), a, via] {
        let outcome = bench.do_it(arc(via, end, 0.0));
        assert_eq!(outcome, Outcome::Refused(Refusal::NoArc));
    }
    assert_eq!(bench.now().target_tcp_pose, a);
}
