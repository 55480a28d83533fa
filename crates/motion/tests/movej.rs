//! movej on the ideal arm: straight in joint space, exact at the end, within every limit, as fast as asked.
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

use common::{Bench, MODELS, ideal, movej, movej_in, unwatched};
use kinematics::{JointAccelerations, JointJerks, JointPositions, JointSpeeds};
use motion::LimitOverrides;
use motion_api::{CommandKind, MotionCommand, MotionMode, Outcome, Refusal, Warning, WayUnit};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn target(offset: [f64; 6]) -> JointPositions {
    let home = ideal("cs66").home;
    JointPositions(std::array::from_fn(|i| home[i] + offset[i]))
}

#[test]
fn movej_reaches_its_target_exactly_and_stands() {
    let mut bench = Bench::new(ideal("cs66"));
    let to = target([1.0, -0.3, 0.2, 0.5, -0.9, 0.1]);
    assert_eq!(bench.do_it(movej(to)), Outcome::Done);
    let end = bench.now();
    assert_eq!(end.target_q, to);
    assert_eq!(end.target_qd, JointSpeeds::ZERO);
    assert_eq!(end.target_qdd, JointAccelerations::ZERO);
    assert_eq!(end.motion_mode, MotionMode::Idle);
    bench.run(5);
    assert_eq!(bench.now().target_q, to);
    bench.check_limits();
}

#[test]
fn movej_is_a_straight_line_on_which_all_joints_start_and_end_together() {
    let mut bench = Bench::new(ideal("cs66"));
    let offset = [1.0, -0.3, 0.2, 0.5, -0.9, 0.01];
    bench.do_it(movej(target(offset)));
    let start = bench.states[0].target_q;
    for state in &bench.states {
        let s = (state.target_q[0] - start[0]) / offset[0];
        for joint in 1..6 {
            let along = start[joint] + s * offset[joint];
            assert!((state.target_q[joint] - along).abs() < 1e-12);
        }
    }
}

#[test]
fn the_default_acceleration_is_reached_in_20_to_40_ms() {
    let mut bench = Bench::new(ideal("cs66"));
    bench.do_it(movej(target([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])));
    let full = |s: &&motion_api::RobotState| s.target_qdd[0] > 1.396263 - 1e-9;
    let reached = bench.states.iter().find(full).unwrap();
    assert!((0.020..=0.040).contains(&reached.time), "{}", reached.time);
}

#[test]
fn a_duration_is_met_to_the_cycle_and_a_short_one_is_stretched_with_a_warning() {
    let mut bench = Bench::new(ideal("cs66"));
    assert_eq!(bench.do_it(movej_in(target([0.5; 6]), 3.0)), Outcome::Done);
    assert_eq!(bench.now().cycle, 750);
    assert!(bench.warnings.is_empty());
    let id = bench.send(movej_in(target([0.0; 6]), 0.01));
    bench.finish(id);
    let [(warned, Warning::DurationStretched { wanted, planned })] = bench.warnings[..] else {
        panic!("{:?}", bench.warnings);
    };
    assert_eq!((warned, wanted), (id, 0.01));
    let taken = (bench.now().cycle - 750) as f64 * 0.004;
    assert!((taken - planned).abs() <= 0.004);
    bench.check_limits();
}

#[test]
fn a_motion_to_where_the_arm_stands_is_done_at_once_or_after_its_duration() {
    let mut bench = Bench::new(ideal("cs66"));
    assert_eq!(bench.do_it(movej(target([0.0; 6]))), Outcome::Done);
    assert_eq!(bench.now().cycle, 1);
    assert_eq!(bench.do_it(movej_in(target([0.0; 6]), 0.4)), Outcome::Done);
    assert!(
        (bench.now().cycle as i64 - 101).abs() <= 1,
        "{}",
        bench.now().cycle
    );
    assert!(bench.warnings.is_empty(), "{:?}", bench.warnings);
}

#[test]
fn more_than_the_joints_can_do_is_limited_with_warnings() {
    let mut bench = Bench::new(ideal("cs66"));
    let id = bench.send(MotionCommand::MoveJ {
        target: target([3.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        acceleration: 100.0,
        speed: 100.0,
        duration: 0.0,
        radius: 0.0,
    });
    assert_eq!(bench.finish(id), Outcome::Done);
    let limits = bench.limits;
    assert_eq!(
        bench.warnings,
        [
            (
                id,
                Warning::SpeedLimited {
                    wanted: 100.0,
                    planned: limits.speed[0],
                    unit: WayUnit::Radian,
                }
            ),
            (
                id,
                Warning::AccelerationLimited {
                    wanted: 100.0,
                    planned: limits.acceleration[0],
                    unit: WayUnit::Radian,
                }
            ),
        ]
    );
    let fastest = bench
        .states
        .iter()
        .fold(0.0_f64, |m, s| m.max(s.target_qd[0]));
    assert!((fastest - limits.speed[0]).abs() < 1e-9);
    bench.check_limits();
}

#[test]
fn a_target_outside_a_joint_range_is_refused_and_nothing_moves() {
    let mut bench = Bench::new(ideal("cs66"));
    let mut to = target([0.0; 6]);
    to[2] = 3.2;
    let outcome = bench.do_it(movej(to));
    assert!(
        matches!(outcome, Outcome::Refused(Refusal::JointLimit { joint: 2, value, .. }) if value == 3.2),
        "{outcome:?}"
    );
    assert_eq!(bench.now().target_q, bench.states[0].target_q);
}

#[test]
fn numbers_that_cannot_be_used_are_refused_by_name() {
    let mut bench = Bench::new(ideal("cs66"));
    for (a, v, t, expected) in [
        (0.0, 1.0, 0.0, "a"),
        (f64::NAN, 1.0, 0.0, "a"),
        (1.0, -1.0, 0.0, "v"),
        (1.0, f64::INFINITY, 0.0, "v"),
        (1.0, 1.0, -1.0, "t"),
        (1.0, 1.0, f64::NAN, "t"),
    ] {
        let outcome = bench.do_it(MotionCommand::MoveJ {
            target: target([0.1; 6]),
            acceleration: a,
            speed: v,
            duration: t,
            radius: 0.0,
        });
        assert!(
            matches!(outcome, Outcome::Refused(Refusal::BadValue { name, .. }) if *name == expected),
            "{outcome:?}"
        );
    }
    let outcome = bench.do_it(movej(JointPositions([f64::NAN; 6])));
    assert!(matches!(
        outcome,
        Outcome::Refused(Refusal::JointLimit { joint: 0, .. })
    ));
}

#[test]
fn configured_tcp_and_elbow_speeds_are_kept() {
    let limits = LimitOverrides {
        tcp_speed: Some(0.3),
        elbow_speed: Some(0.1),
        ..Default::default()
    };
    let mut bench = Bench::new(motion::CycleConfig {
        limits,
        ..ideal("cs66")
    });
    assert_eq!(
        bench.do_it(movej(target([1.0, 0.0, 0.0, 0.0, 0.0, 0.0]))),
        Outcome::Done
    );
    assert_eq!(
        bench.do_it(movej(target([1.0, 0.8, 0.0, 0.0, 0.0, 0.0]))),
        Outcome::Done
    );
    let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let tcp = bench
        .states
        .iter()
        .fold(0.0_f64, |m, s| m.max(norm(&s.target_tcp_speed[..3])));
    assert!(tcp <= 0.3 && tcp > 0.25, "{tcp}");
    for pair in bench.states.windows(2) {
        let moved: Vec<f64> = (0..3)
            .map(|i| pair[1].elbow_position[i] - pair[0].elbow_position[i])
            .collect();
        assert!(norm(&moved) / 0.004 <= 0.1 + 1e-6);
    }
}

/// The shortest time from rest to rest over a distance: two ramps and what is left between them at the peak speed.
fn shortest(distance: f64, limits: &motion::scalar::ScalarLimits) -> f64 {
    let ramp =
        |peak: f64| motion::scalar::ramp::ramp(0.0, 0.0, peak, limits.acceleration, limits.jerk);
    let (mut low, mut high) = (0.0, limits.speed);
    if 2.0 * ramp(high).distance > distance {
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if 2.0 * ramp(middle).distance <= distance {
                low = middle;
            } else {
                high = middle;
            }
        }
    } else {
        low = high;
    }
    let ends = ramp(low);
    2.0 * ends.duration + (distance - 2.0 * ends.distance) / low
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, rng_seed: RngSeed::Fixed(1),
        ..Default::default() })]

    #[test]
    fn random_motions_keep_every_limit_and_take_no_longer_than_necessary(
        model in 0usize..6,
        step_ms in 1usize..=8,
        targets in prop::collection::vec(prop::array::uniform6(-3.0..3.0f64), 1..4),
        a in 0.1..20.0f64,
        v in 0.1..8.0f64,
        jerk_share in 0.1..1.0f64,
    ) {
        let mut config = unwatched(MODELS[model]);
        config.step_time = step_ms as f64 * 1e-3;
        let own = config.resolve().unwrap();
        config.limits.joint_jerk = Some(JointJerks(own.jerk.0.map(|j| j * jerk_share)));
        let mut bench = Bench::new(config);
        for q in targets {
            let to = JointPositions(q);
            let from = bench.now();
            let kind = CommandKind::Motion(MotionCommand::MoveJ { target: to, acceleration: a, speed: v, duration: 0.0,
                radius: 0.0 });
            prop_assert_eq!(bench.do_it(kind), Outcome::Done);
            prop_assert_eq!(bench.now().target_q, to);

            // The time-optimal scalar problem, written down independently of the planner.
            let way: Vec<f64> = (0..6).map(|i| to[i] - from.target_q[i]).collect();
            let lead = way.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            let cap = |limit: &[f64; 6]| (0..6).fold(f64::INFINITY, |m, i| m.min(limit[i] * lead / way[i].abs()));
            let speed = v.min(cap(&bench.limits.speed.0));
            let acceleration = a.min(cap(&bench.limits.acceleration.0));
            let jerk = (acceleration / 0.030).min(cap(&bench.limits.jerk.0));
            let limits = motion::scalar::ScalarLimits { speed, acceleration, jerk };
            let optimal = shortest(lead, &limits);
            let taken = (bench.now().cycle - from.cycle) as f64 * bench.cycle.step_time();
            prop_assert!(taken <= 1.001 * optimal + bench.cycle.step_time(), "{} {}", taken, optimal);
        }
        bench.check_limits();
    }
}
