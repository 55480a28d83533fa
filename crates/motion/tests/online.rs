//! servoj, speedj, speedl and their stops: they get where they are asked, inside every limit in every cycle, whatever
//! the stream does.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::needless_range_loop,
    reason = "a test that cannot go on should say where; joints are counted"
)]
#![allow(
    clippy::approx_constant,
    reason = "joint angles and speeds as people type them"
)]

use crate::common;

use common::{Bench, MODELS, ideal, movej, unwatched};
use kinematics::{JointPositions, JointSpeeds, Payload, Pose, RobotModel};
use motion::CycleConfig;
use motion_api::{
    CommandKind, MachineCommand, MotionMode, OnlineCommand, Origin, Outcome, Refusal,
    SettingCommand, ThreadNumber, Warning,
};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn servoj(target: JointPositions, duration: f64) -> CommandKind {
    CommandKind::Online(OnlineCommand::ServoJ {
        target,
        duration,
        lookahead: 0.1,
        gain: 300.0,
    })
}

fn speedj(speeds: [f64; 6], acceleration: f64, duration: Option<f64>) -> CommandKind {
    CommandKind::Online(OnlineCommand::SpeedJ {
        speeds: JointSpeeds(speeds),
        acceleration,
        duration,
    })
}

fn speedl(speed: [f64; 6], acceleration: f64, duration: Option<f64>) -> CommandKind {
    CommandKind::Online(OnlineCommand::SpeedL {
        speed,
        acceleration,
        rotation_acceleration: acceleration,
        duration,
    })
}

fn standing(bench: &mut Bench, most: usize) {
    for _ in 0..most {
        if bench.now().motion_mode == MotionMode::Idle {
            return;
        }
        bench.tick();
    }
    panic!("still {:?} {:?}", bench.now().motion_mode, bench.stops);
}

#[test]
fn a_servoj_lasts_its_time_and_the_arm_comes_to_rest_at_the_last_point() {
    let mut bench = Bench::new(ideal("cs66"));
    let mut goal = bench.now().target_q;
    for _ in 0..250 {
        goal[0] += 0.002;
        let begun = bench.now().cycle;
        assert_eq!(bench.do_it(servoj(goal, 0.004)), Outcome::Done);
        assert_eq!(bench.now().cycle, begun + 1);
    }
    assert_eq!(bench.now().motion_mode, MotionMode::ServoJ);
    assert!((bench.now().target_qd[0] - 0.5).abs() < 1e-6);
    let begun = bench.now().cycle;
    bench.do_it(servoj(goal, 0.020));
    assert_eq!(bench.now().cycle, begun + 5);
    standing(&mut bench, 500);
    assert_eq!(bench.now().target_q, goal);
    bench.check_limits();
}

#[test]
fn a_servoj_far_away_goes_there_inside_the_limits_and_does_not_overshoot() {
    for gain in [100.0, 300.0, 1000.0, 2000.0] {
        for lookahead in [0.03, 0.1, 0.2] {
            let mut bench = Bench::new(ideal("cs66"));
            let mut goal = bench.now().target_q;
            goal[0] += 2.0;
            goal[3] -= 1.0;
            bench.do_it(OnlineCommand::ServoJ {
                target: goal,
                duration: 0.004,
                lookahead,
                gain,
            });
            standing(&mut bench, 2000);
            assert_eq!(bench.now().target_q, goal);
            let over = bench.states.iter().map(|s| s.target_q[0] - goal[0]);
            let over = over.fold(f64::MIN, f64::max);
            assert!(over < 2e-3, "{gain} {lookahead}: {over}");
            bench.check_limits();
        }
    }
}

#[test]
fn another_thread_cannot_take_over_a_servo_stream_but_the_same_can() {
    let mut bench = Bench::new(ideal("cs66"));
    let goal = bench.now().target_q;
    let running = bench.send(servoj(goal, 1.0));
    bench.tick();
    let other = Origin {
        thread: ThreadNumber(1),
        ..Origin::default()
    };
    let id = bench
        .script
        .commands
        .send(other, servoj(goal, 0.1))
        .unwrap();
    assert_eq!(
        bench.finish(id),
        Outcome::Refused(Refusal::Busy { running })
    );
    assert_eq!(bench.do_it(servoj(goal, 0.1)), Outcome::Done);
    assert_eq!(bench.outcome(running), Some(Outcome::Aborted));
}

#[test]
fn speedj_reaches_its_speeds_in_the_expected_time_and_holds_them() {
    let mut bench = Bench::new(ideal("cs66"));
    let speeds = [0.5, -0.25, 0.1, 0.0, 0.0, -0.5];
    let id = bench.send(speedj(speeds, 1.0, None));
    assert_eq!(bench.finish(id), Outcome::Done);
    let took = bench.now().time;
    assert!((took - 0.53).abs() < 0.01, "{took}");
    bench.run(50);
    assert_eq!(bench.now().motion_mode, MotionMode::SpeedJ);
    for joint in 0..6 {
        assert!((bench.now().target_qd[joint] - speeds[joint]).abs() < 1e-9);
    }
    // On the way the joints kept their proportions.
    for state in &bench.states {
        assert!((state.target_qd[1] + 0.5 * state.target_qd[0]).abs() < 1e-9);
    }
    assert_eq!(
        bench.do_it(OnlineCommand::StopJ { acceleration: 2.0 }),
        Outcome::Done
    );
    assert_eq!(bench.now().target_qd, JointSpeeds::ZERO);
    assert_eq!(bench.now().motion_mode, MotionMode::Idle);
    bench.check_limits();
}

#[test]
fn speedj_with_a_time_returns_then_and_successors_join_without_a_jerk() {
    let mut bench = Bench::new(ideal("cs66"));
    for k in 0..200 {
        let begun = bench.now().cycle;
        let speed = 0.3 * (f64::from(k) * 0.05).sin();
        bench.do_it(speedj(
            [speed, 0.0, 0.0, 0.0, speed, 0.0],
            40.0,
            Some(0.004),
        ));
        assert_eq!(bench.now().cycle, begun + 1);
    }
    bench.do_it(OnlineCommand::StopJ { acceleration: 8.0 });
    bench.check_limits();
}

#[test]
fn half_the_speed_fraction_halves_the_speeds_of_speedj_and_speedl() {
    let mut bench = Bench::new(ideal("cs66"));
    bench.do_it(SettingCommand::SetSpeedFraction(0.5));
    bench.do_it(speedj([0.4, 0.0, 0.0, 0.0, 0.0, 0.0], 2.0, Some(1.0)));
    assert!((bench.now().target_qd[0] - 0.2).abs() < 1e-9);
    bench.do_it(OnlineCommand::StopJ { acceleration: 4.0 });
    bench.do_it(speedl([0.0, 0.1, 0.0, 0.0, 0.0, 0.0], 1.0, Some(0.5)));
    assert!((bench.now().target_tcp_speed[1] - 0.05).abs() < 1e-9);
    bench.check_limits();
}

#[test]
fn a_paused_speedj_stands_and_goes_on() {
    let mut bench = Bench::new(ideal("cs66"));
    let id = bench.send(speedj([0.4, 0.0, 0.0, 0.0, 0.0, 0.0], 2.0, Some(1.0)));
    bench.run(100);
    assert_eq!(bench.do_it(MachineCommand::Pause), Outcome::Done);
    assert_eq!(bench.now().target_qd, JointSpeeds::ZERO);
    bench.run(500);
    assert_eq!(bench.outcome(id), None);
    bench.do_it(MachineCommand::Resume);
    assert_eq!(bench.finish(id), Outcome::Done);
    assert!((bench.now().target_qd[0] - 0.4).abs() < 1e-9);
    bench.check_limits();
}

#[test]
fn speedl_stays_on_its_line_and_stopl_ends_on_it() {
    for model in MODELS {
        let mut bench = Bench::new(ideal(model));
        let mut home = bench.now().target_q;
        home[1] += 0.2;
        home[4] -= 0.2;
        bench.do_it(movej(home));
        let start = Pose::from_rpy(&bench.now().target_tcp_pose);
        let first = bench.states.len();
        bench.do_it(speedl([0.06, -0.08, 0.0, 0.0, 0.0, 0.0], 0.5, Some(0.6)));
        let speed = bench.now().target_tcp_speed;
        assert!(
            (speed[0] - 0.06).abs() < 1e-9 && (speed[1] + 0.08).abs() < 1e-9,
            "{model} {speed:?}"
        );
        assert_eq!(
            bench.do_it(OnlineCommand::StopL { acceleration: 1.0 }),
            Outcome::Done
        );
        for state in &bench.states[first..] {
            let now = Pose::from_rpy(&state.target_tcp_pose);
            let way = now.translation - start.translation;
            let along = way.x * 0.6 - way.y * 0.8;
            let off = way - nalgebra::Vector3::new(0.6, -0.8, 0.0) * along;
            assert!(off.norm() < 1e-9, "{model} {off:?}");
            assert!(now.rotation.angle_to(&start.rotation) < 1e-7);
        }
        assert_eq!(bench.now().target_qd, JointSpeeds::ZERO);
        bench.check_limits();
    }
}

#[test]
fn speedl_towards_the_end_of_the_reach_slows_down_on_its_line_and_says_so() {
    let mut bench = Bench::new(ideal("cs66"));
    let start = bench.now().target_tcp_pose;
    let id = bench.send(speedl([-0.5, 0.0, 0.0, 0.0, 0.0, 0.0], 1.0, Some(4.0)));
    assert_eq!(bench.finish(id), Outcome::Done, "{:?}", bench.stops);
    assert!(
        bench
            .warnings
            .iter()
            .any(|(i, w)| *i == id && matches!(w, Warning::LimitedByJoint { .. }))
    );
    assert_eq!(bench.warnings.len(), 1);
    let end = bench.now();
    assert!(end.target_qd.max_abs() < 1e-2, "{:?}", end.target_qd);
    assert!((end.target_tcp_pose.xyz[0] - start.xyz[0]).abs() > 0.1);
    assert!(
        (end.target_tcp_pose.xyz[2] - start.xyz[2]).abs() < 1e-3,
        "{:?}",
        end.target_tcp_pose
    );
    bench.check_limits();
}

#[test]
fn speedj_into_the_end_of_a_range_stops_there_and_says_so() {
    let mut bench = Bench::new(unwatched("cs66"));
    let id = bench.send(speedj([0.0, 0.0, 3.0, 0.0, 0.0, 0.0], 5.0, Some(3.0)));
    assert_eq!(bench.finish(id), Outcome::Done, "{:?}", bench.stops);
    assert_eq!(
        bench.warnings,
        vec![(id, Warning::LimitedByJoint { joint: 2 })]
    );
    let q = bench.now().target_q[2];
    assert!((q - bench.limits.position_max[2]).abs() < 1e-3, "{q}");
    bench.check_limits();
    // And back out of it.
    assert_eq!(
        bench.do_it(speedj([0.0, 0.0, -1.0, 0.0, 0.0, 0.0], 5.0, None)),
        Outcome::Done
    );
    bench.check_limits();
}

#[test]
fn a_planned_motion_after_a_speed_command_waits_for_the_arm_to_come_to_rest() {
    let mut bench = Bench::new(ideal("cs66"));
    let goal = bench.now().target_q;
    bench.do_it(speedj([0.5, 0.0, 0.0, 0.0, 0.0, 0.0], 2.0, None));
    assert_eq!(bench.do_it(movej(goal)), Outcome::Done);
    assert_eq!(bench.now().target_q, goal);
    bench.check_limits();
}

#[test]
fn a_stop_ends_a_deferred_motion_too() {
    let mut bench = Bench::new(ideal("cs66"));
    let goal = bench.now().target_q;
    bench.do_it(speedj([0.5, 0.0, 0.0, 0.0, 0.0, 0.0], 2.0, None));
    let id = bench.send(movej(goal));
    bench.tick();
    assert_eq!(
        bench.do_it(MachineCommand::Stop { only: id }),
        Outcome::Done
    );
    assert_eq!(bench.outcome(id), Some(Outcome::Aborted));
    standing(&mut bench, 200);
    bench.check_limits();
}

#[test]
fn stops_at_rest_and_without_power_are_done_at_once() {
    let mut bench = Bench::new(CycleConfig {
        powered_off: true,
        ..ideal("cs66")
    });
    for kind in [
        CommandKind::Online(OnlineCommand::StopJ { acceleration: 1.0 }),
        CommandKind::Online(OnlineCommand::StopL { acceleration: 1.0 }),
    ] {
        let begun = bench.now().cycle;
        assert_eq!(bench.do_it(kind), Outcome::Done);
        assert_eq!(bench.now().cycle, begun + 1);
    }
}

#[test]
fn numbers_that_make_no_sense_are_refused_and_nothing_moves() {
    let mut bench = Bench::new(ideal("cs66"));
    let q = bench.now().target_q;
    let mut nan = q;
    nan[2] = f64::NAN;
    let mut far = q;
    far[2] = 4.0;
    for kind in [
        servoj(nan, 0.004),
        servoj(far, 0.004),
        servoj(q, 0.0),
        servoj(q, f64::NAN),
        speedj([f64::NAN; 6], 1.0, None),
        speedj([0.1; 6], 0.0, None),
        speedj([0.1; 6], 1.0, Some(-1.0)),
        speedl([f64::INFINITY; 6], 1.0, None),
        speedl([0.1; 6], f64::NAN, None),
        CommandKind::Online(OnlineCommand::StopJ { acceleration: -1.0 }),
        CommandKind::Online(OnlineCommand::StopL { acceleration: 0.0 }),
    ] {
        let outcome = bench.do_it(kind);
        assert!(
            matches!(outcome, Outcome::Refused(_)),
            "{kind:?} {outcome:?}"
        );
    }
    assert_eq!(bench.now().target_q, q);
}

#[test]
fn the_arm_follows_servoj_with_its_rated_payload_within_half_a_milliradian() {
    for model in MODELS {
        let mut config = CycleConfig::new(RobotModel::built_in(model).unwrap());
        let rated = config.model.rated_payload_kg().unwrap();
        config.payload = Payload::new(rated, [0.0, 0.0, 0.05], [0.0; 6]).unwrap();
        let home = config.home;
        let mut bench = Bench::new(config);
        for k in 0..1000 {
            let t = f64::from(k) * 0.004;
            let mut goal = home;
            for joint in 0..6 {
                goal[joint] += 0.4 * (1.0 - (t * (1.0 + 0.3 * joint as f64)).cos());
            }
            assert_eq!(
                bench.do_it(servoj(goal, 0.004)),
                Outcome::Done,
                "{model} {:?}",
                bench.stops
            );
        }
        let mut errors: Vec<f64> = bench
            .states
            .iter()
            .map(|s| (0..6).fold(0.0_f64, |m, j| m.max((s.actual_q[j] - s.target_q[j]).abs())))
            .collect();
        errors.sort_by(f64::total_cmp);
        let p99 = errors[errors.len() * 99 / 100];
        assert!(p99 < 0.5e-3, "{model}: {p99}");
        bench.check_limits();
    }
}

#[derive(Clone, Debug)]
enum Wish {
    Servo([f64; 6], f64, usize),
    Joints([f64; 6], f64, usize),
    Tcp([f64; 6], f64, usize),
    Stop(bool, f64),
    Fraction(f64),
    Pause(usize),
}

fn wish() -> impl Strategy<Value = Wish> {
    let six = |most: f64| prop::array::uniform6(-most..most);
    prop_oneof![
        3 => (six(1.5), 0.002..0.05_f64, 1..30_usize).prop_map(|(q, t, n)| Wish::Servo(q, t, n)),
        3 => (six(6.0), 0.1..40.0_f64, 1..100_usize).prop_map(|(v, a, n)| Wish::Joints(v, a, n)),
        3 => (six(1.0), 0.1..40.0_f64, 1..100_usize).prop_map(|(v, a, n)| Wish::Tcp(v, a, n)),
        1 => (any::<bool>(), 0.1..40.0_f64).prop_map(|(j, a)| Wish::Stop(j, a)),
        1 => (0.0..1.0_f64).prop_map(Wish::Fraction),
        1 => (1..60_usize).prop_map(Wish::Pause),
    ]
}

/// Runs the wishes without waiting for calls to end, as streams from outside do.
fn live(model: &'static str, step: f64, wishes: &[Wish]) -> Bench {
    live_under(model, step, wishes, (None, None))
}

/// The same with limits of the speeds of TCP and elbow.
fn live_under(
    model: &'static str,
    step: f64,
    wishes: &[Wish],
    (tcp_speed, elbow_speed): (Option<f64>, Option<f64>),
) -> Bench {
    let mut config = CycleConfig {
        step_time: step,
        ..unwatched(model)
    };
    config.limits.tcp_speed = tcp_speed;
    config.limits.elbow_speed = elbow_speed;
    let mut bench = Bench::new(config);
    for wish in wishes {
        match wish {
            Wish::Servo(way, t, cycles) => {
                let mut goal = bench.now().target_q;
                for joint in 0..6 {
                    let (min, max) = (
                        bench.limits.position_min[joint],
                        bench.limits.position_max[joint],
                    );
                    goal[joint] = (goal[joint] + way[joint]).clamp(min, max);
                }
                bench.send(servoj(goal, *t));
                bench.run(*cycles);
            }
            Wish::Joints(v, a, cycles) => {
                bench.send(speedj(*v, *a, Some(0.1)));
                bench.run(*cycles);
            }
            Wish::Tcp(v, a, cycles) => {
                bench.send(speedl(*v, *a, Some(0.1)));
                bench.run(*cycles);
            }
            Wish::Stop(joints, acceleration) => {
                let acceleration = *acceleration;
                bench.do_it(if *joints {
                    CommandKind::Online(OnlineCommand::StopJ { acceleration })
                } else {
                    CommandKind::Online(OnlineCommand::StopL { acceleration })
                });
            }
            Wish::Fraction(fraction) => {
                bench.send(SettingCommand::SetSpeedFraction(*fraction));
            }
            Wish::Pause(cycles) => {
                bench.send(MachineCommand::Pause);
                bench.run(*cycles);
                bench.send(MachineCommand::Resume);
            }
        }
    }
    bench.do_it(OnlineCommand::StopJ { acceleration: 5.0 });
    bench
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, max_shrink_iters: 0, rng_seed: RngSeed::Fixed(6),
        failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn any_mixture_of_online_modes_keeps_every_limit_in_every_cycle(
        model in prop::sample::select(MODELS.to_vec()),
        step in prop::sample::select(vec![0.002, 0.004, 0.008]),
        wishes in prop::collection::vec(wish(), 1..25),
    ) {
        let bench = live(model, step, &wishes);
        prop_assert!(bench.stops.is_empty(), "{:?}", bench.stops);
        prop_assert_eq!(bench.now().target_qd, JointSpeeds::ZERO);
        bench.check_limits();
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(40), max_shrink_iters: 0, rng_seed: RngSeed::Fixed(7),
        failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn any_mixture_of_online_modes_keeps_the_speed_limits_of_tcp_and_elbow(
        model in prop::sample::select(MODELS.to_vec()),
        step in prop::sample::select(vec![0.002, 0.004, 0.008]),
        tcp in prop::option::weighted(0.8, 0.05..1.0_f64),
        elbow in prop::option::weighted(0.5, 0.05..1.0_f64),
        wishes in prop::collection::vec(wish(), 1..25),
    ) {
        let bench = live_under(model, step, &wishes, (tcp, elbow));
        // The limiter sees every setpoint: what it lets pass is within the limits.
        prop_assert!(bench.stops.is_empty(), "{:?}", bench.stops);
        prop_assert_eq!(bench.now().target_qd, JointSpeeds::ZERO);
        bench.check_limits();
    }
}

/// How many cases; `ELITE_CASES` asks for more.
fn cases(few: u32) -> u32 {
    let asked = std::env::var("ELITE_CASES");
    asked.ok().and_then(|n| n.parse().ok()).unwrap_or(few)
}

#[test]
fn a_stopj_has_not_ended_while_a_joint_creeps() {
    let speeds = [
        -0.7209853317025935,
        -1.7078224034573617,
        -1.5937345988193052,
        -1.1908740319031652,
        4.132370854204332,
        -4.936159345263053,
    ];
    let wishes = [
        Wish::Joints(speeds, 30.522382367716357, 2),
        Wish::Fraction(0.8368910821231831),
        Wish::Fraction(0.21285175971067624),
    ];
    let bench = live_under("cs63", 0.008, &wishes, (None, Some(0.673485065262957)));
    assert_eq!(bench.now().target_qd, JointSpeeds::ZERO);
}

#[test]
fn the_same_stream_gives_the_same_states() {
    let wishes = [
        Wish::Servo([0.3, -0.2, 0.1, 0.4, 0.2, -0.1], 0.01, 20),
        Wish::Tcp([0.2, 0.1, -0.1, 0.3, 0.0, 0.2], 2.0, 60),
        Wish::Joints([0.5, 0.2, -0.3, 0.1, 1.0, -1.0], 3.0, 60),
    ];
    let (one, two) = (live("cs66", 0.004, &wishes), live("cs66", 0.004, &wishes));
    assert_eq!(one.states, two.states);
}

#[test]
fn a_limited_tcp_is_not_too_fast_in_any_online_mode() {
    let mut config = ideal("cs66");
    config.limits.tcp_speed = Some(0.3);
    config.limits.elbow_speed = Some(0.25);
    let mut bench = Bench::new(config);
    let home = bench.now().target_q;
    let mut goal = home;
    goal[0] += 1.5;
    goal[1] += 0.5;
    for _ in 0..800 {
        bench.do_it(servoj(goal, 0.004));
    }
    standing(&mut bench, 2000);
    assert_eq!(bench.now().target_q, goal);
    bench.do_it(speedj([-2.0, -1.0, 1.0, 0.0, 0.0, 0.0], 5.0, Some(1.0)));
    bench.do_it(speedj([1.0, -1.0, -1.0, 2.0, 0.0, 0.0], 8.0, Some(1.0)));
    bench.do_it(speedl([0.0, 1.0, 0.0, 0.0, 0.0, 0.0], 2.0, Some(1.0)));
    bench.do_it(OnlineCommand::StopL { acceleration: 5.0 });
    assert!(bench.stops.is_empty(), "{:?}", bench.stops);
    bench.check_limits();
    let fastest = bench.states.iter().fold(0.0_f64, |most, s| {
        let v = s.target_tcp_speed;
        most.max((v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt())
    });
    assert!(fastest > 0.25 && fastest <= 0.3 + 1e-6, "{fastest}");
}
