//! The queue as one path: chains of moves whose sender sends each as soon as it is told that it may.
//!
//! Collinear pieces and gentle curves run like one motion, process moves keep their speed, every limit is kept by
//! differences of the commanded positions, and blends of joints accelerate no more than twice what was asked for.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]

use crate::common;

use common::{Bench, MODELS, ideal, moved, movej, tcp_speed};
use kinematics::{JointPositions, RpyPose};
use motion_api::{CommandId, CommandKind, MachineCommand, MotionCommand, Outcome, SettingCommand};
use nalgebra::Vector3;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn line(target: RpyPose, acceleration: f64, speed: f64, radius: f64) -> CommandKind {
    CommandKind::Motion(MotionCommand::MoveL {
        target,
        acceleration,
        speed,
        duration: 0.0,
        radius,
    })
}

fn process(target: RpyPose, acceleration: f64, speed: f64, radius: f64) -> CommandKind {
    CommandKind::Motion(MotionCommand::MoveP {
        target,
        acceleration,
        speed,
        radius,
    })
}

/// Sends each command once the one before has ended or may be followed; how long all of them take, s.
fn stream(bench: &mut Bench, kinds: &[CommandKind]) -> f64 {
    let begun = bench.now().time;
    let mut last = None;
    for kind in kinds {
        let id = bench.send(*kind);
        while bench.outcome(id).is_none() && !bench.queued.contains(&id) {
            bench.tick();
        }
        assert!(
            !matches!(bench.outcome(id), Some(Outcome::Refused(_))),
            "{kind:?}"
        );
        last = Some(id);
    }
    let last: CommandId = last.unwrap();
    assert_eq!(bench.finish(last), Outcome::Done);
    while !bench.cycle.is_standing() {
        bench.tick();
    }
    bench.now().time - begun
}

/// From rest to rest over a distance with the jerk that an acceleration in 30 ms has.
fn ideal_time(length: f64, acceleration: f64, speed: f64) -> f64 {
    length / speed + speed / acceleration + 0.03
}

#[test]
fn collinear_pieces_run_like_one_line() {
    for (count, piece, radius, speed) in [
        (32, 0.015, 0.005, 0.25),
        (100, 0.004, 0.0015, 0.1),
        (20, 0.02, 0.0001, 0.25),
        (6, 0.07, 0.03, 0.5),
    ] {
        let mut bench = Bench::new(ideal("cs66"));
        let start = moved(&bench.now().target_tcp_pose, [0.0, -0.2, 0.0]);
        bench.do_it(line(start, 1.2, 0.25, 0.0));
        let kinds: Vec<_> = (1..=count)
            .map(|k| {
                let radius = if k == count { 0.0 } else { radius };
                line(
                    moved(&start, [0.0, piece * f64::from(k), 0.0]),
                    1.2,
                    speed,
                    radius,
                )
            })
            .collect();
        let took = stream(&mut bench, &kinds);
        let ideal = ideal_time(piece * f64::from(count), 1.2, speed);
        assert!(
            took < 1.03 * ideal + 0.02,
            "{count} x {piece}: {took}, one line takes {ideal}"
        );
        assert!(bench.warnings.is_empty(), "{:?}", bench.warnings);
        bench.check_limits();
    }
}

/// Points on a gentle curve, `step` apart: a circle.
fn curve(start: &RpyPose, radius: f64, count: i32, step: f64) -> Vec<RpyPose> {
    (1..=count)
        .map(|k| {
            let angle = f64::from(k) * step / radius;
            moved(
                start,
                [radius * (1.0 - angle.cos()), radius * angle.sin(), 0.0],
            )
        })
        .collect()
}

#[test]
fn a_gentle_curve_of_short_moves_keeps_the_speed() {
    for model in MODELS {
        let mut bench = Bench::new(ideal(model));
        let start = bench.now().target_tcp_pose;
        let points = curve(&start, 0.12, 60, 0.008);
        let kinds: Vec<_> = points
            .iter()
            .enumerate()
            .map(|(k, pose)| line(*pose, 1.2, 0.1, if k == 59 { 0.0 } else { 0.003 }))
            .collect();
        let took = stream(&mut bench, &kinds);
        let ideal = ideal_time(0.48, 1.2, 0.1);
        assert!(took < 1.05 * ideal, "{model}: {took} of {ideal}");
        bench.check_limits();
    }
}

#[test]
fn process_moves_of_a_millimetre_and_a_half_keep_their_speed() {
    for model in ["cs66", "cs612", "cs616", "cs620", "cs625"] {
        // Tighter than that the jerk of the joints does not allow the pieces' corners at full speed.
        for (speed, radius) in [(0.02, 0.12), (0.1, 0.2), (0.2, 0.4)] {
            let mut bench = Bench::new(ideal(model));
            let start = moved(&bench.now().target_tcp_pose, [0.0, -0.2, 0.0]);
            bench.do_it(line(start, 1.2, 0.25, 0.0));
            let points = curve(&start, radius, 300, 0.0015);
            let kinds: Vec<_> = (1..)
                .zip(&points)
                .map(|(k, pose)| {
                    let touch = if k == 300 { 0.0 } else { 0.0005 };
                    process(*pose, 20.0 * speed, speed, touch)
                })
                .collect();
            let from = bench.states.len();
            stream(&mut bench, &kinds);
            bench.check_limits();
            let speeds: Vec<f64> = bench.states[from..].iter().map(tcp_speed).collect();
            let up = speeds.iter().position(|v| *v > 0.98 * speed).unwrap();
            let down = speeds.iter().rposition(|v| *v > 0.98 * speed).unwrap();
            let slow = speeds[up..down]
                .iter()
                .filter(|v| (*v - speed).abs() > 0.02 * speed)
                .count();
            println!("{model} {speed}: {slow} of {} cycles", down - up);
            assert!(slow == 0, "{model} {speed}: {slow} of {}", down - up);
            assert!((down - up) as f64 * 0.004 > 0.7 * 0.45 / speed);
            // On the polygon: within the height of its corners.
            let centre = Vector3::from(start.xyz) + Vector3::new(radius, 0.0, 0.0);
            for state in &bench.states[from..] {
                let off = (Vector3::from(state.target_tcp_pose.xyz) - centre).norm() - radius;
                assert!(off.abs() < 5e-6, "{off}");
            }
        }
    }
}

#[test]
fn blends_of_joints_accelerate_no_more_than_twice_what_was_asked_for() {
    for model in MODELS {
        let mut bench = Bench::new(ideal(model));
        let home = bench.now().target_q;
        let at = |by: [f64; 6]| JointPositions(std::array::from_fn(|j| home[j] + by[j]));
        let joint = |target, acceleration, radius| {
            CommandKind::Motion(MotionCommand::MoveJ {
                target,
                acceleration,
                speed: 0.8,
                duration: 0.0,
                radius,
            })
        };
        let kinds = [
            joint(at([0.8, 0.0, 0.0, 0.0, 0.0, 0.0]), 1.0, 0.03),
            joint(at([0.8, 0.3, -0.3, 0.0, 0.0, 0.5]), 1.0, 0.03),
            joint(at([0.2, 0.3, 0.1, 0.4, 0.0, 0.5]), 0.7, 0.02),
            joint(home, 1.0, 0.0),
        ];
        stream(&mut bench, &kinds);
        let most = bench
            .states
            .iter()
            .map(|s| s.target_qdd.max_abs())
            .fold(0.0, f64::max);
        assert!(most <= 2.0 + 1e-6, "{model}: {most}");
        assert!(bench.warnings.is_empty(), "{:?}", bench.warnings);
        bench.check_limits();
    }
}

#[test]
fn a_stop_and_a_pause_act_on_the_whole_queue() {
    let mut bench = Bench::new(ideal("cs66"));
    let start = bench.now().target_tcp_pose;
    let mut ids = Vec::new();
    for k in 1..=40 {
        let id = bench.send(line(
            moved(&start, [0.0, 0.004 * f64::from(k), 0.0]),
            1.2,
            0.25,
            0.001,
        ));
        while bench.outcome(id).is_none() && !bench.queued.contains(&id) {
            bench.tick();
        }
        ids.push(id);
        if k == 20 {
            assert_eq!(bench.do_it(MachineCommand::Pause), Outcome::Done);
            assert_eq!(bench.now().target_qd.max_abs(), 0.0);
            assert_eq!(bench.do_it(MachineCommand::Resume), Outcome::Done);
        }
    }
    let open = ids
        .iter()
        .filter(|id| bench.outcome(**id).is_none())
        .count();
    assert!(open > 2, "{open} motions are ahead");
    let stop = CommandKind::Machine(MachineCommand::Stop {
        only: CommandId::NONE,
    });
    assert_eq!(bench.do_it(stop), Outcome::Done);
    assert_eq!(bench.now().target_qd.max_abs(), 0.0);
    for id in &ids {
        assert!(matches!(
            bench.outcome(*id),
            Some(Outcome::Done | Outcome::Aborted)
        ));
    }
    assert_eq!(bench.do_it(movej(bench.states[0].target_q)), Outcome::Done);
    bench.check_limits();
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, rng_seed: RngSeed::Fixed(3),
        ..ProptestConfig::default() })]

    /// Random chains of short moves of every kind, sent ahead, with the slider moving: limits are kept, the end is
    /// exact.
    #[test]
    fn any_chain_that_is_sent_ahead_keeps_the_limits_and_arrives(
        legs in prop::collection::vec((0..4usize, prop::array::uniform3(-0.02..0.02f64), 0.02..0.6f64,
            0.0005..0.01f64), 4..24),
        fractions in prop::collection::vec((0usize..60, 0.05..1.0f64), 0..4),
        model in 0..6usize,
    ) {
        let mut bench = Bench::new(ideal(MODELS[model]));
        bench.do_it(movej(JointPositions([0.3, -1.4, 1.7, -1.8, -1.5, 0.2])));
        let mut at = bench.now().target_tcp_pose;
        let centre = at;
        for (k, (kind, by, speed, radius)) in legs.iter().enumerate() {
            at = moved(&at, *by);
            let command = match kind {
                0 | 1 => line(at, 1.5, *speed, *radius),
                2 => process(at, 20.0 * speed, *speed, *radius),
                _ => CommandKind::Motion(MotionCommand::MoveC {
                    via: moved(&at, [by[1] / 2.0 - by[0] / 2.0, -by[1] / 2.0, by[0] / 2.0 - by[2] / 2.0]),
                    target: at,
                    acceleration: 1.5,
                    speed: *speed,
                    radius: *radius,
                    fixed: false,
                }),
            };
            let id = bench.send(command);
            while bench.outcome(id).is_none() && !bench.queued.contains(&id) {
                bench.tick();
            }
            if matches!(bench.outcome(id), Some(Outcome::Refused(_))) {
                at = moved(&at, by.map(|x| -x));
            }
            if let Some((_, fraction)) = fractions.iter().find(|(n, _)| *n == k) {
                bench.send(SettingCommand::SetSpeedFraction(*fraction));
            }
        }
        let end = line(centre, 1.2, 0.25, 0.0);
        prop_assert_eq!(bench.do_it(end), Outcome::Done);
        let off = Vector3::from(bench.now().target_tcp_pose.xyz) - Vector3::from(centre.xyz);
        prop_assert!(off.norm() < 1e-9, "{off}");
        prop_assert!(bench.stops.is_empty(), "{:?}", bench.stops);
        bench.check_limits();
    }
}
