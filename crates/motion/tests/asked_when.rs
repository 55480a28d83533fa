//! Commands while the arm does something that does not go with them: refused with a reason, or right, never a jump.
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

use common::{Bench, ideal, moved, movej, movel, tcp_speed};
use core::f64::consts::TAU;
use kinematics::{JointPositions, Pose, RpyPose};
use motion::CycleConfig;
use motion::modes::encoder::Belt;
use motion_api::{
    CommandId, CommandKind, EncoderRange, InputAction, IoChange, MachineCommand, MotionCommand,
    OnlineCommand, Outcome, OverlayCommand, PulseDecoding, Refusal, SensingCommand, SettingCommand,
};

fn speedl(speed: [f64; 3]) -> CommandKind {
    CommandKind::Online(OnlineCommand::SpeedL {
        speed: [speed[0], speed[1], speed[2], 0.0, 0.0, 0.0],
        acceleration: 0.5,
        rotation_acceleration: 0.5,
        duration: None,
    })
}

fn track(ticks_per_meter: f64) -> CommandKind {
    CommandKind::Overlay(OverlayCommand::TrackConveyorLinear {
        direction: [0.0, 1.0, 0.0],
        ticks_per_meter,
        encoder: 0,
    })
}

fn count(count: f64) -> CommandKind {
    CommandKind::Setting(SettingCommand::EncoderSetTickCount { encoder: 0, count })
}

const BY_PROGRAM: CommandKind = CommandKind::Setting(SettingCommand::EncoderEnableSetTickCount {
    encoder: 0,
    range: EncoderRange::Unsigned32,
});

fn tool(z: f64) -> CommandKind {
    CommandKind::Setting(SettingCommand::SetTcp(RpyPose::from_array([
        0.0, 0.0, z, 0.0, 0.0, 0.0,
    ])))
}

#[test]
fn no_motion_begins_while_an_input_holds_freedrive_and_the_sender_hears_why() {
    let mut bench = Bench::new(ideal("cs66"));
    let action = InputAction::Freedrive;
    bench.do_it(SettingCommand::SetIo(IoChange::DigitalInAction {
        bit: 0,
        action,
    }));
    let input = |level| CommandKind::Setting(SettingCommand::SetDigitalInput { index: 0, level });
    bench.do_it(input(true));
    bench.push([0.0, 30.0, 0.0, 0.0, 0.0, 0.0]);
    bench.run(50);
    let home = bench.states[0].target_q;
    let by_hand = Outcome::Refused(Refusal::HandGuided);
    let at = bench.now().target_tcp_pose;
    let refused = [
        movej(home),
        movel(at),
        speedl([0.0, 0.1, 0.0]),
        track(1000.0),
        CommandKind::Overlay(OverlayCommand::PathOffsetEnable),
    ];
    for kind in refused {
        assert_eq!(bench.do_it(kind), by_hand, "{kind:?}");
    }
    bench.do_it(SensingCommand::SetExternalWrench([0.0; 6]));
    // Sent while the hand's motion ends, it waits for that.
    bench.do_it(input(false));
    assert_eq!(bench.do_it(movej(home)), Outcome::Done);
    assert_eq!(bench.now().target_q, home);
    bench.check_limits();
    assert!(bench.stops.is_empty(), "{:?}", bench.stops);
}

#[test]
fn a_speedl_goes_on_with_a_new_tcp() {
    for speed in [[0.0, 0.05, 0.0], [0.03, 0.04, -0.02]] {
        let mut bench = Bench::new(ideal("cs66"));
        assert_eq!(bench.do_it(speedl(speed)), Outcome::Done);
        let wanted = tcp_speed(&bench.now());
        for z in [0.1, -0.05, 0.3] {
            assert_eq!(bench.do_it(tool(z)), Outcome::Done);
            bench.run(75);
            assert!((tcp_speed(&bench.now()) - wanted).abs() < 1e-6);
        }
        assert_eq!(
            bench.do_it(OnlineCommand::StopL { acceleration: 1.0 }),
            Outcome::Done
        );
        bench.check_limits();
        assert!(bench.stops.is_empty());
    }
}

#[test]
fn a_new_tcp_in_a_blend_is_no_jump_and_the_next_line_ends_with_it() {
    for radius in [0.02, 0.06] {
        for process in [false, true] {
            let mut bench = Bench::new(ideal("cs66"));
            bench.tick();
            let at = bench.now().target_tcp_pose;
            let line = |target, radius| {
                if process {
                    CommandKind::Motion(MotionCommand::MoveP {
                        target,
                        acceleration: 1.2,
                        speed: 0.2,
                        radius,
                    })
                } else {
                    CommandKind::Motion(MotionCommand::MoveL {
                        target,
                        acceleration: 1.2,
                        speed: 0.2,
                        duration: 0.0,
                        radius,
                    })
                }
            };
            let first = bench.send(line(moved(&at, [0.0, 0.15, 0.0]), radius));
            while !bench.queued.contains(&first) && bench.outcome(first).is_none() {
                bench.tick();
            }
            assert_eq!(bench.do_it(tool(0.15)), Outcome::Done);
            let [x, y, z] = at.xyz;
            let target = RpyPose {
                xyz: [x + 0.1, y + 0.15, z - 0.2],
                ..at
            };
            assert_eq!(bench.do_it(line(target, 0.0)), Outcome::Done);
            let ended = bench.now().target_tcp_pose;
            let off = Pose::from_rpy(&ended).translation - Pose::from_rpy(&target).translation;
            assert!(off.norm() < 1e-9, "{ended:?}");
            bench.check_limits();
            assert!(bench.stops.is_empty(), "{:?}", bench.stops);
        }
    }
}

#[test]
fn the_tcp_stays_what_it_is_on_a_table_that_does_not_turn_it_and_under_offsets() {
    for rotate_tool in [false, true] {
        let belt = Belt {
            encoder: 0,
            ticks_per_second: 200.0,
            start_at: 0.0,
        };
        let mut bench = Bench::new(CycleConfig {
            belts: [Some(belt), None],
            ..ideal("cs66")
        });
        bench.do_it(OverlayCommand::TrackConveyorCircular {
            center: RpyPose::from_array([-0.6, 0.2, 0.0, 0.0, 0.0, 0.0]),
            ticks_per_revolution: 1000.0 * TAU,
            rotate_tool,
            encoder: 0,
        });
        bench.run(250);
        let expected = if rotate_tool {
            Outcome::Done
        } else {
            Outcome::Refused(Refusal::NonRotatingTurntable)
        };
        assert_eq!(bench.do_it(tool(0.2)), expected);
        bench.run(100);
        bench.check_limits();
        assert!(bench.stops.is_empty(), "{:?}", bench.stops);
    }
    let mut bench = Bench::new(ideal("cs66"));
    bench.do_it(OverlayCommand::PathOffsetEnable);
    let refused = Outcome::Refused(Refusal::PathOffset);
    assert_eq!(bench.do_it(tool(0.2)), refused);
}

#[test]
fn counters_that_are_set_anew_do_not_move_an_arm_that_follows_them() {
    let mut bench = Bench::new(ideal("cs66"));
    let way =
        |bench: &Bench| bench.now().target_tcp_pose.xyz[1] - bench.states[0].target_tcp_pose.xyz[1];
    assert_eq!(bench.do_it(BY_PROGRAM), Outcome::Done);
    assert_eq!(bench.do_it(track(1000.0)), Outcome::Done);
    // The first count of an absolute encoder.
    assert_eq!(bench.do_it(count(50_000.0)), Outcome::Done);
    bench.run(125);
    assert!(way(&bench).abs() < 1e-9);
    assert_eq!(bench.do_it(count(50_010.0)), Outcome::Done);
    bench.run(250);
    assert!((way(&bench) - 0.01).abs() < 1e-6, "{}", way(&bench));
    // Another counter, and the same once more.
    let pulses = CommandKind::Setting(SettingCommand::EncoderEnablePulseDecode {
        encoder: 0,
        decoding: PulseDecoding::Quadrature,
        channel_a: 16,
        channel_b: 17,
    });
    for kind in [pulses, BY_PROGRAM, count(7.0), BY_PROGRAM, count(4e9)] {
        assert_eq!(bench.do_it(kind), Outcome::Done);
        bench.run(125);
        assert!((way(&bench) - 0.01).abs() < 1e-6, "{kind:?}");
    }
    assert_eq!(bench.do_it(count(4e9 - 20.0)), Outcome::Done);
    bench.run(250);
    assert!((way(&bench) + 0.01).abs() < 1e-6, "{}", way(&bench));
    bench.check_limits();
    assert!(bench.stops.is_empty(), "{:?}", bench.stops);
}

#[test]
fn a_motion_sent_while_a_belt_is_left_begins_where_the_arm_stands() {
    let belt = Belt {
        encoder: 0,
        ticks_per_second: 300.0,
        start_at: 0.0,
    };
    for with_motion in [false, true] {
        let mut bench = Bench::new(CycleConfig {
            belts: [Some(belt), None],
            ..ideal("cs66")
        });
        let home = bench.states[0].target_q;
        bench.do_it(track(1000.0));
        bench.run(200);
        if with_motion {
            let mut far = home;
            far[0] += 0.4;
            bench.send(movej(far));
            bench.run(60);
        }
        let stop = bench.send(OverlayCommand::StopConveyorTracking);
        bench.run(2);
        assert_eq!(bench.do_it(movej(home)), Outcome::Done);
        assert_eq!(bench.outcome(stop), Some(Outcome::Done));
        assert_eq!(bench.now().target_q, home);
        bench.check_limits();
        assert!(bench.stops.is_empty(), "{:?}", bench.stops);
    }
}

#[test]
fn an_online_mode_on_a_belt_is_slowed_down_where_the_tcp_may_not_be_faster() {
    let speedj = CommandKind::Online(OnlineCommand::SpeedJ {
        speeds: kinematics::JointSpeeds([-0.5, 0.0, 0.0, 0.0, 0.0, 0.0]),
        acceleration: 2.0,
        duration: None,
    });
    for kind in [speedl([0.0, 0.25, 0.0]), speedl([0.0, 0.1, 0.0]), speedj] {
        let belt = Belt {
            encoder: 0,
            ticks_per_second: 150.0,
            start_at: 0.0,
        };
        let mut bench = Bench::new(CycleConfig {
            belts: [Some(belt), None],
            limits: motion::LimitOverrides {
                tcp_speed: Some(0.3),
                ..Default::default()
            },
            ..ideal("cs66")
        });
        bench.do_it(track(1000.0));
        bench.run(150);
        bench.send(kind);
        bench.run(150);
        assert!(bench.stops.is_empty(), "{kind:?} {:?}", bench.stops);
        let fastest = bench.states.iter().map(tcp_speed).fold(0.0, f64::max);
        assert!(fastest <= 0.3 + 1e-6 && tcp_speed(&bench.now()) > 0.2);
        bench.check_limits();
    }
}

#[test]
fn an_arm_that_is_about_to_lose_its_power_takes_no_motion() {
    let mut bench = Bench::new(ideal("cs66"));
    let far = JointPositions([1.4, -1.2, 1.9, -1.6, -1.2, 0.8]);
    bench.send(movej(far));
    bench.run(120);
    let off = bench.send(MachineCommand::PowerOff);
    bench.tick();
    let refused = Outcome::Refused(Refusal::StillMoving);
    assert_eq!(bench.do_it(movej(far)), refused);
    assert_eq!(bench.do_it(speedl([0.0, 0.1, 0.0])), refused);
    assert_eq!(bench.finish(off), Outcome::Done);
    let only = CommandId::NONE;
    assert_eq!(bench.do_it(MachineCommand::Stop { only }), Outcome::Done);
}

#[test]
fn a_force_mode_that_ends_under_a_motion_is_no_jump() {
    for (step_time, model) in [(0.001, "cs625"), (0.004, "cs66")] {
        let mut bench = Bench::new(CycleConfig {
            step_time,
            ..ideal(model)
        });
        bench.tick();
        let at = bench.now().target_tcp_pose;
        bench.do_it(OverlayCommand::ForceMode {
            frame: RpyPose::default(),
            selection: [false, false, true, true, false, false],
            wrench: [0.0, 0.0, 15.0, 0.2, 0.0, 0.0],
            mode: 0,
            speed_limits: [0.1; 6],
        });
        let line = bench.send(movel(moved(&at, [0.05, 0.15, 0.0])));
        bench.run((0.4 / step_time) as usize);
        assert_eq!(bench.do_it(OverlayCommand::EndForceMode), Outcome::Done);
        assert_eq!(bench.finish(line), Outcome::Done);
        bench.run((1.0 / step_time) as usize);
        bench.check_limits();
        assert!(bench.stops.is_empty(), "{:?}", bench.stops);
    }
}
