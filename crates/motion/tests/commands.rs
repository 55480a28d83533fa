//! What commands do to a controller: ends, stops, pauses, the speed slider, power, protective stops, the border.
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
use kinematics::{JointPositions, JointSpeeds, Payload, RpyPose};
use motion::CycleConfig;
use motion_api::{
    CommandId, CommandKind, MachineCommand, MotionMode, Outcome, Refusal, RobotMode, SafetyMode,
    SettingCommand, StopReason,
};

fn far() -> JointPositions {
    let mut q = ideal("cs66").home;
    q[0] += 2.0;
    q[4] -= 1.0;
    q
}

fn moving(cycles: usize) -> (Bench, CommandId) {
    let mut bench = Bench::new(ideal("cs66"));
    let id = bench.send(movej(far()));
    bench.run(cycles);
    (bench, id)
}

#[test]
fn a_second_motion_is_refused_while_one_runs() {
    let (mut bench, running) = moving(10);
    let outcome = bench.do_it(movej(far()));
    assert_eq!(outcome, Outcome::Refused(Refusal::Busy { running }));
    assert_eq!(bench.finish(running), Outcome::Done);
}

#[test]
fn a_stop_brakes_on_the_path_and_aborts_the_motion() {
    let (mut bench, id) = moving(150);
    let stop = bench.send(MachineCommand::Stop {
        only: CommandId::NONE,
    });
    bench.tick();
    assert_eq!(bench.now().motion_mode, MotionMode::Stopping);
    assert_eq!(bench.finish(stop), Outcome::Done);
    assert_eq!(bench.outcome(id), Some(Outcome::Aborted));
    let (start, end) = (bench.states[0].target_q, bench.now());
    assert_eq!(end.target_qd, JointSpeeds::ZERO);
    let s = (end.target_q[0] - start[0]) / 2.0;
    assert!(s > 0.1 && s < 0.9);
    assert!((end.target_q[4] - (start[4] - s)).abs() < 1e-12);
    bench.check_limits();
    assert_eq!(bench.do_it(movej(far())), Outcome::Done);
}

#[test]
fn a_stop_for_another_motion_changes_nothing() {
    let (mut bench, id) = moving(50);
    let stop = CommandKind::Machine(MachineCommand::Stop {
        only: CommandId(id.0 + 100),
    });
    assert_eq!(bench.do_it(stop), Outcome::Done);
    assert_eq!(bench.now().motion_mode, MotionMode::MoveJ);
    assert_eq!(bench.finish(id), Outcome::Done);
}

#[test]
fn a_stop_at_rest_is_done_at_once() {
    let mut bench = Bench::new(ideal("cs66"));
    bench.do_it(MachineCommand::Stop {
        only: CommandId::NONE,
    });
    assert_eq!(bench.now().cycle, 1);
}

#[test]
fn a_pause_holds_on_the_path_and_a_resume_goes_on_to_the_end() {
    let (mut bench, id) = moving(150);
    let pause = bench.send(MachineCommand::Pause);
    assert_eq!(bench.finish(pause), Outcome::Done);
    assert_eq!(bench.now().motion_mode, MotionMode::Paused);
    assert_eq!(bench.now().speed_scaling, 0.0);
    let held = bench.now().target_q;
    bench.run(100);
    assert_eq!(bench.now().target_q, held);
    assert_eq!(bench.outcome(id), None);
    assert_eq!(bench.do_it(MachineCommand::Resume), Outcome::Done);
    assert_eq!(bench.finish(id), Outcome::Done);
    assert_eq!(bench.now().target_q, far());
    bench.check_limits();
}

#[test]
fn a_resume_ends_a_pause_that_has_not_come_to_rest() {
    let (mut bench, id) = moving(150);
    let pause = bench.send(MachineCommand::Pause);
    bench.run(3);
    bench.do_it(MachineCommand::Resume);
    assert_eq!(bench.outcome(pause), Some(Outcome::Done));
    assert_eq!(bench.finish(id), Outcome::Done);
    bench.check_limits();
}

#[test]
fn a_stop_ends_a_paused_motion() {
    let (mut bench, id) = moving(150);
    bench.do_it(MachineCommand::Pause);
    assert_eq!(
        bench.do_it(MachineCommand::Stop { only: id }),
        Outcome::Done
    );
    assert_eq!(bench.outcome(id), Some(Outcome::Aborted));
    assert_eq!(bench.now().motion_mode, MotionMode::Idle);
}

#[test]
fn a_motion_sent_while_paused_waits_for_the_resume() {
    let mut bench = Bench::new(ideal("cs66"));
    bench.do_it(MachineCommand::Pause);
    let id = bench.send(movej(far()));
    bench.run(20);
    assert_eq!(bench.now().target_q, bench.states[0].target_q);
    bench.send(MachineCommand::Resume);
    assert_eq!(bench.finish(id), Outcome::Done);
}

#[test]
fn half_the_speed_takes_twice_the_time_on_the_same_path() {
    let cycles = |fraction| {
        let mut bench = Bench::new(ideal("cs66"));
        bench.do_it(SettingCommand::SetSpeedFraction(fraction));
        bench.do_it(movej(far()));
        assert_eq!(bench.now().target_q, far());
        bench.now().cycle as f64
    };
    assert!((cycles(0.5) - 2.0 * cycles(1.0)).abs() <= 2.0);
}

#[test]
fn the_speed_slider_works_during_a_motion_and_zero_holds_it() {
    let (mut bench, id) = moving(100);
    for fraction in [0.3, 1.0, 0.0, 0.1, 0.7] {
        bench.do_it(SettingCommand::SetSpeedFraction(fraction));
        bench.run(210);
        assert_eq!(bench.now().speed_scaling, fraction);
        assert_eq!(bench.now().target_speed_fraction, fraction);
        let speed = bench.now().target_qd[0];
        assert!(speed <= 1.047197 * fraction + 1e-9, "{speed} at {fraction}");
    }
    assert_eq!(bench.finish(id), Outcome::Done);
    bench.check_limits();
}

#[test]
fn power_off_brings_the_arm_to_rest_first() {
    let (mut bench, id) = moving(150);
    assert_eq!(bench.do_it(MachineCommand::PowerOff), Outcome::Done);
    assert_eq!(bench.outcome(id), Some(Outcome::Aborted));
    assert_eq!(bench.now().robot_mode, RobotMode::PowerOff);
    assert_eq!(bench.now().motion_mode, MotionMode::PoweredOff);
    bench.check_limits();
    let refused = bench.do_it(movej(far()));
    assert!(matches!(
        refused,
        Outcome::Refused(Refusal::NotReady {
            robot_mode: RobotMode::PowerOff,
            ..
        })
    ));
}

#[test]
fn a_powered_off_controller_runs_after_power_on_and_brake_release() {
    let mut bench = Bench::new(CycleConfig {
        powered_off: true,
        ..ideal("cs66")
    });
    let refused = bench.do_it(MachineCommand::ReleaseBrakes);
    assert!(matches!(
        refused,
        Outcome::Refused(Refusal::WrongMode { .. })
    ));
    bench.do_it(MachineCommand::PowerOn);
    assert_eq!(bench.now().robot_mode, RobotMode::PowerOn);
    bench.run(100);
    assert_eq!(bench.now().robot_mode, RobotMode::Idle);
    bench.do_it(MachineCommand::ReleaseBrakes);
    bench.run(75);
    assert_eq!(bench.now().robot_mode, RobotMode::Running);
    assert_eq!(bench.do_it(movej(far())), Outcome::Done);
}

#[test]
fn an_emergency_stop_brakes_the_arm_takes_its_power_and_ends_when_it_is_released() {
    let mut bench = Bench::new(ideal("cs66"));
    let motion = bench.send(movej(far()));
    bench.run(60);
    assert!(bench.now().target_qd.max_abs() > 0.1);
    bench.send(MachineCommand::EmergencyStop { pressed: true });
    bench.tick();
    assert_eq!(bench.now().safety_mode, SafetyMode::RobotEmergencyStop);
    assert_eq!(
        bench.now().robot_mode,
        RobotMode::Running,
        "the servos brake"
    );
    bench.run(300);
    bench.check_limits();
    assert_eq!(bench.stops, [StopReason::EmergencyStop]);
    let outcome = bench.ended.iter().find(|(id, ..)| *id == motion).unwrap().1;
    assert_eq!(outcome, Outcome::ProtectiveStop(StopReason::EmergencyStop));
    assert_eq!(bench.now().robot_mode, RobotMode::PowerOff);
    assert_eq!(bench.now().target_qd.max_abs(), 0.0);

    let refused = bench.do_it(MachineCommand::PowerOn);
    assert!(matches!(
        refused,
        Outcome::Refused(Refusal::NotReady { .. })
    ));
    bench.do_it(MachineCommand::EmergencyStop { pressed: false });
    assert_eq!(bench.now().safety_mode, SafetyMode::Normal);
    assert_eq!(bench.now().robot_mode, RobotMode::PowerOff);
    bench.do_it(MachineCommand::PowerOn);
    bench.do_it(MachineCommand::ReleaseBrakes);
    bench.run(200);
    assert_eq!(bench.now().robot_mode, RobotMode::Running);
    assert_eq!(bench.do_it(movej(far())), Outcome::Done);
}

#[test]
fn tool_payload_and_outputs_show_in_the_state() {
    let mut bench = Bench::new(ideal("cs66"));
    let before = bench.tick();
    let tcp = RpyPose::from_array([0.0, 0.0, 0.1, 0.0, 0.0, 0.0]);
    bench.do_it(SettingCommand::SetTcp(tcp));
    let payload = Payload::new(2.0, [0.0, 0.0, 0.05], [0.0; 6]).unwrap();
    bench.do_it(SettingCommand::SetPayload(payload));
    bench.do_it(SettingCommand::SetStandardDigitalOut {
        index: 3,
        level: true,
    });
    let state = bench.tick();
    assert_eq!(state.tcp_offset, tcp);
    assert_eq!(state.payload, payload);
    assert_eq!(state.digital_out, 1 << 3);
    let moved: f64 = (0..3)
        .map(|i| (state.target_tcp_pose.xyz[i] - before.target_tcp_pose.xyz[i]).powi(2))
        .sum();
    assert!((moved.sqrt() - 0.1).abs() < 1e-12);
    assert!((state.target_torque[1] - before.target_torque[1]).abs() > 1.0);
    bench.do_it(SettingCommand::SetStandardDigitalOut {
        index: 3,
        level: false,
    });
    assert_eq!(bench.now().digital_out, 0);
}

#[test]
fn impossible_settings_are_refused_and_change_nothing() {
    let mut bench = Bench::new(ideal("cs66"));
    let nan = RpyPose::from_array([f64::NAN, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let heavy = Payload {
        mass: -1.0,
        ..Payload::NONE
    };
    let flat = Payload {
        inertia: [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        ..Payload::NONE
    };
    for kind in [
        CommandKind::Setting(SettingCommand::SetTcp(nan)),
        CommandKind::Setting(SettingCommand::SetPayload(heavy)),
        CommandKind::Setting(SettingCommand::SetPayload(flat)),
        CommandKind::Setting(SettingCommand::SetStandardDigitalOut {
            index: 16,
            level: true,
        }),
        CommandKind::Setting(SettingCommand::SetSpeedFraction(1.01)),
        CommandKind::Setting(SettingCommand::SetSpeedFraction(f64::NAN)),
    ] {
        let outcome = bench.do_it(kind);
        assert!(
            matches!(outcome, Outcome::Refused(Refusal::BadValue { .. })),
            "{outcome:?}"
        );
    }
    let state = bench.tick();
    assert_eq!(state.payload, Payload::NONE);
    assert_eq!(state.tcp_offset, RpyPose::default());
    assert_eq!(state.digital_out, 0);
}
