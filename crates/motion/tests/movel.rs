//! movel on the ideal arm: straight, exact, within the joints' limits everywhere, refused where it cannot be done.
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

use common::{Bench, MODELS, ideal, movej, movel};
use kinematics::{JointPositions, JointSpeeds, Pose, RpyPose};
use motion::{CycleConfig, LimitOverrides};
use motion_api::{
    CommandId, CommandKind, MachineCommand, MotionCommand, MotionMode, Outcome, PathFault, Refusal,
    SettingCommand, Warning,
};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// A pose relative to the one where the arm stands: moved by `by` in the base frame, turned by `turn` about it.
fn relative(bench: &Bench, by: [f64; 3], turn: [f64; 3]) -> RpyPose {
    let now = Pose::from_rpy(&bench.now().target_tcp_pose);
    let mut next = now;
    next.translation += nalgebra::Vector3::from(by);
    next.rotation = kinematics::rotation::rotation_from_rotvec(turn.into()) * now.rotation;
    next.to_rpy()
}

/// Largest distance of the commanded TCP from the line between the poses of two states, by forward kinematics, and
/// largest angle between its orientation and the one that belongs to that place.
fn deviation(bench: &Bench, from: usize, tcp: &Pose) -> (f64, f64) {
    let model = bench_model(bench);
    let pose = |k: usize| model.tcp_pose(&bench.states[k].target_q, tcp);
    let (start, end) = (pose(from), pose(bench.states.len() - 1));
    let way = end.translation - start.translation;
    let turn =
        kinematics::rotation::rotvec_from_rotation(&(end.rotation * start.rotation.inverse()));
    let (mut off, mut twisted) = (0.0_f64, 0.0_f64);
    for k in from..bench.states.len() {
        let here = pose(k);
        let moved = here.translation - start.translation;
        let turned = here.rotation * start.rotation.inverse();
        let share = if way.norm() > 1e-9 {
            moved.dot(&way) / way.norm_squared()
        } else {
            angle(&turned) / turn.norm()
        };
        off = off.max((moved - way * share).norm());
        let expected = kinematics::rotation::rotation_from_rotvec(turn * share);
        twisted = twisted.max(angle(&(turned * expected.inverse())));
    }
    (off, twisted)
}

/// By the rotation vector: the arc cosine of the trace knows small angles to 1e-8 only.
fn angle(rotation: &nalgebra::Rotation3<f64>) -> f64 {
    kinematics::rotation::rotvec_from_rotation(rotation).norm()
}

fn bench_model(bench: &Bench) -> kinematics::RobotModel {
    kinematics::RobotModel::built_in(bench.model).unwrap()
}

fn distance(a: &RpyPose, b: &RpyPose) -> (f64, f64) {
    let (a, b) = (Pose::from_rpy(a), Pose::from_rpy(b));
    (
        (a.translation - b.translation).norm(),
        angle(&(a.rotation.inverse() * b.rotation)),
    )
}

#[test]
fn movel_stays_on_the_line_and_reaches_its_pose() {
    let mut bench = Bench::new(ideal("cs66"));
    let to = relative(&bench, [0.1, 0.2, -0.15], [0.3, -0.2, 0.4]);
    assert_eq!(bench.do_it(movel(to)), Outcome::Done);
    let (off, twisted) = deviation(&bench, 0, &Pose::IDENTITY);
    assert!(off < 1e-9 && twisted < 1e-9, "{off:e} {twisted:e}");
    let (away, turned) = distance(&bench.now().target_tcp_pose, &to);
    assert!(away < 1e-12 && turned < 1e-9, "{away:e} {turned:e}");
    assert_eq!(bench.now().target_qd, JointSpeeds::ZERO);
    assert!(bench.warnings.is_empty(), "{:?}", bench.warnings);
    bench.check_limits();
}

#[test]
fn the_tcp_reaches_the_asked_speed_and_takes_the_time_of_the_profile() {
    let mut bench = Bench::new(ideal("cs66"));
    let to = relative(&bench, [0.0, 0.3, 0.0], [0.0; 3]);
    bench.do_it(movel(to));
    let speed = |s: &motion_api::RobotState| {
        s.target_tcp_speed[..3]
            .iter()
            .map(|x| x * x)
            .sum::<f64>()
            .sqrt()
    };
    let fastest = bench.states.iter().map(speed).fold(0.0, f64::max);
    assert!((fastest - 0.25).abs() < 1e-9, "{fastest}");
    // d/v + v/a + a/j with the acceleration reached in 30 ms; one cycle to the end.
    let expected = 0.3 / 0.25 + 0.25 / 1.2 + 0.030;
    let taken = bench.now().time;
    assert!(
        taken >= expected && taken <= expected + 0.004,
        "{taken} {expected}"
    );
}

#[test]
fn movel_moves_the_active_tcp_and_keeps_it_when_the_tool_changes_on_the_way() {
    let mut bench = Bench::new(ideal("cs66"));
    let tcp = RpyPose::from_array([0.02, -0.01, 0.15, 0.3, 0.0, 0.2]);
    bench.do_it(SettingCommand::SetTcp(tcp));
    let from = bench.states.len() - 1;
    let to = relative(&bench, [0.1, 0.1, 0.1], [0.0, 0.5, 0.0]);
    let id = bench.send(movel(to));
    bench.run(50);
    bench.send(SettingCommand::SetTcp(RpyPose::default()));
    assert_eq!(bench.finish(id), Outcome::Done);
    let (off, twisted) = deviation(&bench, from, &Pose::from_rpy(&tcp));
    assert!(off < 1e-9 && twisted < 1e-9, "{off:e} {twisted:e}");
    let reached = bench_model(&bench).tcp_pose(&bench.now().target_q, &Pose::from_rpy(&tcp));
    assert!((reached.translation - Pose::from_rpy(&to).translation).norm() < 1e-12);
}

#[test]
fn a_rotation_on_the_spot_turns_about_one_axis_at_a_radian_a_second() {
    let mut bench = Bench::new(ideal("cs66"));
    let to = relative(&bench, [0.0; 3], [0.0, 0.0, 1.2]);
    assert_eq!(bench.do_it(movel(to)), Outcome::Done);
    let (off, twisted) = deviation(&bench, 0, &Pose::IDENTITY);
    assert!(off < 1e-9 && twisted < 1e-9, "{off:e} {twisted:e}");
    let fastest = bench
        .states
        .iter()
        .map(|s| s.target_tcp_speed[5])
        .fold(0.0, f64::max);
    assert!((fastest - 1.0).abs() < 1e-9, "{fastest}");
    bench.check_limits();
}

#[test]
fn a_line_of_no_length_is_done_at_once() {
    let mut bench = Bench::new(ideal("cs66"));
    let here = bench.now().target_tcp_pose;
    assert_eq!(bench.do_it(movel(here)), Outcome::Done);
    assert!(bench.now().cycle <= 2);
}

#[test]
fn durations_of_lines_are_met_or_stretched() {
    let mut bench = Bench::new(ideal("cs66"));
    let line = |bench: &Bench, by: f64, duration| {
        CommandKind::Motion(MotionCommand::MoveL {
            target: relative(bench, [0.0, by, 0.0], [0.0; 3]),
            acceleration: 1.2,
            speed: 0.25,
            duration,
            radius: 0.0,
        })
    };
    let kind = line(&bench, 0.2, 2.0);
    bench.do_it(kind);
    assert_eq!(bench.now().cycle, 500);
    assert!(bench.warnings.is_empty());
    let kind = line(&bench, -0.2, 0.01);
    bench.do_it(kind);
    assert!(matches!(
        bench.warnings[..],
        [(_, Warning::DurationStretched { .. })]
    ));
    bench.check_limits();
}

#[test]
fn a_pose_out_of_reach_is_refused_with_the_place() {
    let mut bench = Bench::new(ideal("cs66"));
    let to = relative(&bench, [-2.0, 0.0, 0.0], [0.0; 3]);
    let outcome = bench.do_it(movel(to));
    let Outcome::Refused(Refusal::Path {
        fraction,
        fault: PathFault::OutOfReach,
    }) = outcome
    else {
        panic!("{outcome:?}");
    };
    assert_eq!(bench.now().target_q, bench.states[0].target_q);
    assert!(fraction > 0.05 && fraction < 0.9, "{fraction}");
    // Up to there, nearly, it is possible.
    let reachable = relative(&bench, [-2.0 * (fraction - 1e-3), 0.0, 0.0], [0.0; 3]);
    assert!(!matches!(
        bench.do_it(movel(reachable)),
        Outcome::Refused(Refusal::Path {
            fault: PathFault::OutOfReach,
            ..
        })
    ));
}

#[test]
fn a_line_into_a_joint_limit_is_refused_with_joint_and_place() {
    let mut config = ideal("cs66");
    config.limits.joint_position_max = Some(JointPositions([0.5, 6.28, 3.14, 6.28, 6.28, 6.28]));
    let mut bench = Bench::new(config);
    // A quarter circle about the base axis cannot be a line, but a chord of it turns the base by more than 0.5 rad.
    let here = bench.now().target_tcp_pose.xyz;
    let angle: f64 = 0.9;
    let to = [
        here[0] * angle.cos() - here[1] * angle.sin() - here[0],
        here[0] * angle.sin() + here[1] * angle.cos() - here[1],
        0.0,
    ];
    let to = relative(&bench, to, [0.0; 3]);
    let outcome = bench.do_it(movel(to));
    assert!(
        matches!(
            outcome,
            Outcome::Refused(Refusal::Path { fault: PathFault::JointLimit { joint: 0, max, .. }, .. }) if max == 0.5
        ),
        "{outcome:?}"
    );
}

#[test]
fn a_line_through_a_wrist_singularity_is_refused_with_the_place() {
    let mut bench = Bench::new(ideal("cs66"));
    // Wrist 2 must pass zero: turn the tool about the axis of joint 4 ... by the direction in which joint 5 alone acts.
    bench.do_it(movej(JointPositions([0.0, -1.2, 1.4, -1.0, 0.3, 0.4])));
    let before = bench.states.len() - 1;
    let model = bench_model(&bench);
    let beyond = model.tcp_pose(
        &JointPositions([0.0, -1.2, 1.4, -1.0, -0.3, 0.4]),
        &Pose::IDENTITY,
    );
    let mut off_axis = beyond;
    off_axis.translation.y += 0.05;
    let outcome = bench.do_it(movel(off_axis.to_rpy()));
    match outcome {
        Outcome::Refused(Refusal::Path {
            fraction,
            fault: PathFault::Singular { jump, .. },
        }) => {
            assert!(
                fraction > 0.1 && fraction < 0.9 && jump > 0.5,
                "{fraction} {jump}"
            );
            assert_eq!(bench.now().target_q, bench.states[before].target_q);
        }
        // Passing beside the singularity is possible too: then every limit must hold.
        Outcome::Done => bench.check_limits(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn an_arm_that_stands_singular_refuses_a_line_and_says_so() {
    let mut bench = Bench::new(ideal("cs66"));
    bench.do_it(movej(JointPositions([
        0.0,
        -1.5707963267948966,
        0.0,
        -1.5707963267948966,
        0.0,
        0.0,
    ])));
    let to = relative(&bench, [0.05, 0.03, -0.2], [0.1, 0.2, 0.0]);
    let outcome = bench.do_it(movel(to));
    assert!(
        matches!(
            outcome,
            Outcome::Refused(Refusal::Path { fraction: 0.0, .. })
        ),
        "{outcome:?}"
    );
}

#[test]
fn near_a_singularity_the_line_slows_down_and_is_kept() {
    let mut bench = Bench::new(ideal("cs66"));
    // Past the axis of the base, closer than the arm's sideways offset allows with ease: the base must turn fast there.
    let down = Pose::from_rpy(&RpyPose::from_array([
        0.16,
        0.35,
        0.3,
        std::f64::consts::PI,
        0.0,
        0.0,
    ]));
    let near = JointPositions([1.0, -1.9, 2.2, -1.87, -1.5708, 0.0]);
    let q = bench_model(&bench)
        .inverse_nearest(&down, &Pose::IDENTITY, &near)
        .unwrap();
    bench.do_it(movej(q));
    let from = bench.states.len() - 1;
    let to = relative(&bench, [0.0, -0.7, 0.0], [0.0; 3]);
    let id = bench.send(MotionCommand::MoveL {
        target: to,
        acceleration: 1.2,
        speed: 1.0,
        duration: 0.0,
        radius: 0.0,
    });
    let outcome = bench.finish(id);
    assert_eq!(outcome, Outcome::Done, "{outcome:?} {:?}", bench.stops);
    assert!(
        bench
            .warnings
            .iter()
            .any(|(_, w)| matches!(w, Warning::SpeedLimited { .. })),
        "{:?}",
        bench.warnings
    );
    let (off, twisted) = deviation(&bench, from, &Pose::IDENTITY);
    assert!(off < 1e-9 && twisted < 1e-9, "{off:e} {twisted:e}");
    bench.check_limits();
}

#[test]
fn stop_pause_and_slider_stay_on_the_line() {
    let mut bench = Bench::new(ideal("cs66"));
    let to = relative(&bench, [0.1, 0.25, -0.1], [0.2, 0.0, 0.3]);
    let id = bench.send(movel(to));
    bench.run(60);
    bench.do_it(MachineCommand::Pause);
    assert_eq!(bench.now().motion_mode, MotionMode::Paused);
    bench.do_it(MachineCommand::Resume);
    bench.run(60);
    bench.do_it(SettingCommand::SetSpeedFraction(0.4));
    bench.run(60);
    bench.do_it(SettingCommand::SetSpeedFraction(1.0));
    bench.run(20);
    bench.do_it(MachineCommand::Stop { only: id });
    assert_eq!(bench.outcome(id), Some(Outcome::Aborted));
    assert_eq!(bench.do_it(movel(to)), Outcome::Done);
    let (off, twisted) = deviation(&bench, 0, &Pose::IDENTITY);
    assert!(off < 1e-9 && twisted < 1e-9, "{off:e} {twisted:e}");
    bench.check_limits();
}

#[test]
fn a_stop_in_the_cycle_of_the_command_leaves_the_arm_where_it_is() {
    let mut bench = Bench::new(ideal("cs66"));
    let to = relative(&bench, [0.1, 0.0, 0.0], [0.0; 3]);
    let id = bench.send(movel(to));
    bench.do_it(MachineCommand::Stop {
        only: CommandId::NONE,
    });
    assert_eq!(bench.outcome(id), Some(Outcome::Aborted));
    assert_eq!(bench.now().target_q, bench.states[0].target_q);
}

#[test]
fn numbers_that_are_not_finite_are_refused_by_name() {
    let mut bench = Bench::new(ideal("cs66"));
    let nan = RpyPose::from_array([0.3, f64::NAN, 0.3, 0.0, 0.0, 0.0]);
    let outcome = bench.do_it(movel(nan));
    assert!(
        matches!(outcome, Outcome::Refused(Refusal::BadValue { .. })),
        "{outcome:?}"
    );
}

#[test]
fn a_tcp_speed_limit_caps_the_line() {
    let limits = LimitOverrides {
        tcp_speed: Some(0.1),
        ..Default::default()
    };
    let mut bench = Bench::new(CycleConfig {
        limits,
        ..ideal("cs66")
    });
    let to = relative(&bench, [0.0, 0.2, 0.0], [0.0; 3]);
    assert_eq!(bench.do_it(movel(to)), Outcome::Done);
    let speed = |s: &motion_api::RobotState| {
        s.target_tcp_speed[..3]
            .iter()
            .map(|x| x * x)
            .sum::<f64>()
            .sqrt()
    };
    let fastest = bench.states.iter().map(speed).fold(0.0, f64::max);
    assert!((fastest - 0.1).abs() < 1e-9, "{fastest}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, rng_seed: RngSeed::Fixed(1),
        ..Default::default() })]

    #[test]
    fn random_lines_on_every_model_are_straight_and_keep_every_joint_limit(
        model in 0usize..6,
        start in prop::array::uniform6(-2.0..2.0f64),
        offset in prop::array::uniform3(-0.4..0.4f64),
        turn in prop::array::uniform3(-0.8..0.8f64),
        v in 0.05..1.5f64,
        a in 0.2..6.0f64,
        timed in any::<bool>(),
        step_ms in 1usize..=8,
    ) {
        let mut config = ideal(MODELS[model]);
        config.home = JointPositions(start);
        config.step_time = step_ms as f64 * 1e-3;
        let mut bench = Bench::new(config);
        bench.model = MODELS[model];
        let to = relative(&bench, offset, turn);
        let kind = CommandKind::Motion(MotionCommand::MoveL { target: to, acceleration: a, speed: v,
            duration: if timed { 0.5 } else { 0.0 }, radius: 0.0 });
        match bench.do_it(kind) {
            Outcome::Done => {
                let (off, twisted) = deviation(&bench, 0, &Pose::IDENTITY);
                prop_assert!(off < 1e-9 && twisted < 1e-8, "{:e} {:e}", off, twisted);
                let (away, turned) = distance(&bench.now().target_tcp_pose, &to);
                prop_assert!(away < 1e-9 && turned < 1e-8, "{:e} {:e}", away, turned);
                bench.check_limits();
            }
            Outcome::Refused(Refusal::Path { .. }) => {
                prop_assert_eq!(bench.now().target_q, bench.states[0].target_q);
            }
            other => prop_assert!(false, "{:?} {:?}", other, bench.stops),
        }
    }
}
