//! Protective stops: who is told what, how the arm brakes, and how one gets out again.
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

use common::{Bench, ideal, movej};
use kinematics::{JointPositions, JointSpeeds, Payload, RobotModel};
use motion::{CycleConfig, LimitOverrides};
use motion_api::{
    EncoderRange, MachineCommand, MotionMode, Outcome, OverlayCommand, Refusal, SafetyMode,
    SettingCommand, StopReason,
};

/// A moving arm on a belt that becomes too fast for the limit of the TCP's speed.
fn stopped_by_tcp_speed() -> (Bench, motion_api::CommandId) {
    let limits = LimitOverrides {
        tcp_speed: Some(0.3),
        ..Default::default()
    };
    let mut bench = Bench::new(CycleConfig {
        limits,
        ..ideal("cs66")
    });
    bench.do_it(SettingCommand::EncoderEnableSetTickCount {
        encoder: 0,
        range: EncoderRange::Signed32,
    });
    bench.do_it(OverlayCommand::TrackConveyorLinear {
        direction: [0.0, 1.0, 0.0],
        ticks_per_meter: 1000.0,
        encoder: 0,
    });
    let id = bench.send(movej(JointPositions([
        1.5, -1.5708, 1.5708, -1.5708, -1.5708, 0.0,
    ])));
    bench.run(120);
    let mut count = 0.0;
    while bench.stops.is_empty() && count < 30.0 {
        count += 2.0;
        bench.send(SettingCommand::EncoderSetTickCount { encoder: 0, count });
        bench.tick();
    }
    (bench, id)
}

#[test]
fn a_violated_limit_stops_the_arm_within_the_joint_limits_and_tells_everybody_once() {
    let (mut bench, id) = stopped_by_tcp_speed();
    let [StopReason::TcpSpeed { value, limit }] = bench.stops[..] else {
        panic!("{:?}", bench.stops);
    };
    assert!(value > limit);
    assert_eq!(
        bench.outcome(id),
        Some(Outcome::ProtectiveStop(bench.stops[0]))
    );
    let state = bench.now();
    assert_eq!(state.safety_mode, SafetyMode::ProtectiveStop);
    assert_eq!(state.motion_mode, MotionMode::ProtectiveStop);
    assert_eq!(state.stop_code, 4);
    bench.run(100);
    assert_eq!(bench.now().target_qd, JointSpeeds::ZERO);
    assert_eq!(bench.stops.len(), 1);
    bench.check_limits();
}

#[test]
fn a_stopped_arm_refuses_motions_until_it_is_unlocked_at_rest() {
    let (mut bench, _) = stopped_by_tcp_speed();
    assert_eq!(
        bench.do_it(MachineCommand::UnlockProtectiveStop),
        Outcome::Refused(Refusal::StillMoving)
    );
    bench.run(100);
    let to = JointPositions([0.5, -1.5708, 1.5708, -1.5708, -1.5708, 0.0]);
    let refused = bench.do_it(movej(to));
    assert!(matches!(
        refused,
        Outcome::Refused(Refusal::NotReady {
            safety_mode: SafetyMode::ProtectiveStop,
            ..
        })
    ));
    assert_eq!(
        bench.do_it(MachineCommand::UnlockProtectiveStop),
        Outcome::Done
    );
    assert_eq!(bench.now().safety_mode, SafetyMode::Normal);
    assert_eq!(bench.now().stop_code, 0);
    assert_eq!(bench.do_it(movej(to)), Outcome::Done);
}

#[test]
fn an_overloaded_arm_does_not_follow_stops_and_stands_where_it_fell() {
    let config = CycleConfig::new(RobotModel::built_in("cs63").unwrap());
    let mut bench = Bench::new(config);
    bench.do_it(movej(JointPositions([
        0.0, -0.3, 0.3, -1.5708, -1.5708, 0.0,
    ])));
    let load = Payload::new(60.0, [0.0, 0.0, 0.1], [0.0; 6]).unwrap();
    bench.do_it(SettingCommand::SetPayload(load));
    for _ in 0..200 {
        if !bench.stops.is_empty() {
            break;
        }
        bench.tick();
    }
    assert!(
        matches!(bench.stops[..], [StopReason::TrackingError { .. }]),
        "{:?}",
        bench.stops
    );
    bench.run(20);
    let state = bench.now();
    assert_eq!(state.safety_mode, SafetyMode::ProtectiveStop);
    assert!(state.actual_q.is_finite() && state.actual_torque.is_finite());
    // The brakes do not slip in the servo's place: power off holds the arm where it is.
    bench.do_it(MachineCommand::PowerOff);
    bench.tick();
    let held = bench.now().actual_q;
    bench.run(50);
    assert_eq!(bench.now().actual_q, held);
    assert_eq!(bench.now().actual_qd, JointSpeeds::ZERO);
}

#[test]
fn a_rigid_arm_comes_back_after_power_off_without_a_jump() {
    let mut bench = Bench::new(CycleConfig::new(RobotModel::built_in("cs66").unwrap()));
    let id = bench.send(movej(JointPositions([
        1.5, -1.0, 1.0, -1.5708, -1.5708, 0.0,
    ])));
    bench.run(100);
    bench.do_it(MachineCommand::PowerOff);
    assert_eq!(bench.outcome(id), Some(Outcome::Aborted));
    bench.run(20);
    bench.do_it(MachineCommand::PowerOn);
    bench.do_it(MachineCommand::ReleaseBrakes);
    bench.run(200);
    bench.run(20);
    let to = JointPositions([0.0, -1.5, 1.5, -1.5, -1.5, 0.0]);
    assert_eq!(bench.do_it(movej(to)), Outcome::Done);
    assert!(bench.stops.is_empty(), "{:?}", bench.stops);
    for pair in bench.states.windows(2) {
        for joint in 0..6 {
            assert!((pair[1].actual_q[joint] - pair[0].actual_q[joint]).abs() < 0.01);
            assert!((pair[1].actual_q[joint] - pair[1].target_q[joint]).abs() < 1e-4);
        }
    }
}
