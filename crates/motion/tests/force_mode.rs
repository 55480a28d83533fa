//! Force mode: presses plates, follows motions and hands, and is left without a jump.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::needless_range_loop,
    reason = "a test that cannot go on should say where; joints and axes are counted"
)]
#![allow(
    clippy::approx_constant,
    reason = "joint angles and speeds as people type them"
)]

use crate::common;

use common::force::*;
use common::{Bench, ideal, movej, movel, unwatched};
use kinematics::{JointPositions, JointSpeeds, Pose, RpyPose};
use motion::contact::{Obstacle, PlacedShape, Shape};
use motion::{ControlLoop, CycleConfig, PlantKind, SensorNoise};
use motion_api::{
    CommandId, CommandKind, FreedriveFrame, MachineCommand, MotionCommand, MotionMode,
    OnlineCommand, Outcome, OverlayCommand, Refusal, RobotMode, SafetyMode, SensingCommand,
};

#[test]
fn the_arm_presses_plates_of_any_stiffness_with_one_setting() {
    for (name, config) in [("ideal", ideal("cs66")), ("rigid", rigid("cs66"))] {
        for stiffness in [1e3, 1e4, 1e5] {
            for target in [5.0, 20.0, 80.0] {
                let mut bench = Bench::new(over_plate(config.clone(), 1e-4, stiffness, 0.0));
                let start = bench.now().actual_tcp_pose;
                bench.send(down(target, 0.25));
                let forces: Vec<f64> = (0..400).map(|_| press(&mut bench)).collect();
                assert!(bench.stops.is_empty(), "{:?}", bench.stops);
                let state = bench.now();
                assert!(state.force_mode);
                assert_eq!(state.motion_mode, MotionMode::ForceMode);
                let peak = forces.iter().fold(0.0_f64, |m, f| m.max(*f)) / target;
                let touch = forces.iter().position(|f| *f > 0.0).unwrap();
                let settled = forces
                    .iter()
                    .rposition(|f| (f / target - 1.0).abs() > 0.05)
                    .map_or(0, |k| k + 1 - touch);
                let steady = (forces.last().unwrap() / target - 1.0).abs();
                println!(
                    "{name} {stiffness} N/m {target} N: peak {peak:.3} settled {:.3} s steady {steady:.5}",
                    settled as f64 * 0.004
                );
                assert!(peak <= 1.15 && steady <= 0.01 && settled <= 125);
                let (way, angle) = off(&state.target_tcp_pose, &start);
                assert!(way < 2e-5 && angle < 2e-5, "{way} {angle}");
                bench.check_limits();
            }
        }
    }
}

#[test]
fn an_approach_at_ten_millimetres_a_second_peaks_below_one_and_a_half_targets() {
    for (name, config) in [("ideal", ideal("cs66")), ("rigid", rigid("cs66"))] {
        for stiffness in [1e3, 1e4, 1e5] {
            for target in [5.0, 20.0] {
                let mut bench = Bench::new(over_plate(config.clone(), 3e-3, stiffness, 0.0));
                bench.send(down(target, 0.01));
                let forces: Vec<f64> = (0..700).map(|_| press(&mut bench)).collect();
                let peak = forces.iter().fold(0.0_f64, |m, f| m.max(*f)) / target;
                let fastest = bench
                    .states
                    .iter()
                    .fold(0.0_f64, |m, s| m.max(s.target_tcp_speed[2].abs()));
                println!("{name} {stiffness} N/m {target} N: peak {peak:.3} fastest {fastest:.5}");
                assert!(peak <= 1.5 && fastest <= 0.01 + 1e-6);
                assert!((forces.last().unwrap() / target - 1.0).abs() < 0.01);
                let touch = forces.iter().position(|f| *f > 0.0).unwrap();
                assert!(forces[touch + 250..].iter().all(|f| *f > 0.0));
                bench.check_limits();
            }
        }
    }
}

#[test]
fn a_noisy_sensor_changes_neither_the_mean_nor_the_rest_of_the_arm() {
    for stiffness in [1e3, 1e4, 1e5] {
        let mut config = over_plate(rigid("cs66"), 1e-3, stiffness, 0.0);
        config.sensor_noise = SensorNoise {
            force: 0.3,
            torque: 0.03,
            seed: 5,
        };
        let mut bench = Bench::new(config);
        bench.send(down(20.0, 0.05));
        // What acts on the plate is the depth, whatever the sensor says of it.
        let surface = bench.now().actual_tcp_pose.xyz[2] - 1e-3;
        let mut forces = Vec::new();
        for _ in 0..1000 {
            bench.tick();
            forces.push((surface - bench.now().actual_tcp_pose.xyz[2]) * stiffness);
        }
        assert!(bench.stops.is_empty(), "{:?}", bench.stops);
        let late = &forces[500..];
        let mean = late.iter().sum::<f64>() / late.len() as f64;
        let spread = late.iter().map(|f| (f - mean).powi(2)).sum::<f64>() / late.len() as f64;
        println!(
            "{stiffness} N/m with noise: mean {mean:.3} N, spread {:.3} N",
            spread.sqrt()
        );
        assert!((mean / 20.0 - 1.0).abs() < 0.01 && spread.sqrt() < 0.3);
        bench.check_limits();
    }
}

#[test]
fn a_new_target_and_new_axes_are_taken_without_a_jump() {
    let mut bench = Bench::new(over_plate(ideal("cs66"), 1e-3, 1e4, 0.0));
    bench.send(down(20.0, 0.1));
    for _ in 0..200 {
        press(&mut bench);
    }
    bench.send(down(50.0, 0.1));
    let mut last = 0.0;
    for _ in 0..200 {
        last = press(&mut bench);
    }
    assert!((last / 50.0 - 1.0).abs() < 0.01, "{last}");
    let there = bench.now().target_tcp_pose;
    // Now x is given way, z holds its place.
    bench.send(force_mode(
        [1, 0, 0, 0, 0, 0],
        [3.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.05, 0.0, 0.0, 0.0, 0.0, 0.0],
    ));
    for _ in 0..200 {
        press(&mut bench);
    }
    let state = bench.now();
    assert!((state.target_tcp_pose.xyz[2] - there.xyz[2]).abs() < 1e-5);
    assert!(state.target_tcp_pose.xyz[0] > there.xyz[0] + 1e-3);
    bench.check_limits();
}

#[test]
fn an_axis_never_exceeds_its_speed_limit_and_a_limit_of_0_holds_it() {
    for limit in [0.0, 0.004, 0.06] {
        let mut bench = with_hand(ideal("cs66"));
        bench.do_it(push([0.0, 0.0, 400.0, 0.0, 0.0, 0.0]));
        let start = bench.now().target_tcp_pose;
        bench.do_it(down(-100.0, limit));
        bench.run(200);
        let fastest = bench
            .states
            .iter()
            .fold(0.0_f64, |m, s| m.max(s.target_tcp_speed[2].abs()));
        assert!(bench.stops.is_empty(), "{:?}", bench.stops);
        assert!(fastest <= limit + 2e-6, "{limit}: {fastest}");
        assert!(fastest >= 0.99 * limit);
        if limit == 0.0 {
            let moved = bench.now().target_tcp_pose.xyz[2] - start.xyz[2];
            assert!(moved.abs() < 1e-5, "{moved}");
        }
        bench.check_limits();
    }
}

/// Presses, does `what`, and says how the arm came to rest.
fn left_by(what: CommandKind) -> Bench {
    let mut bench = Bench::new(over_plate(rigid("cs66"), 1e-3, 1e4, 0.0));
    bench.send(down(40.0, 0.1));
    for _ in 0..60 {
        press(&mut bench);
    }
    let before = bench.now().target_tcp_pose.xyz[2];
    let id = bench.send(what);
    for _ in 0..250 {
        press(&mut bench);
    }
    assert_eq!(bench.outcome(id), Some(Outcome::Done), "{what:?}");
    assert_eq!(bench.now().target_qd, JointSpeeds::ZERO, "{what:?}");
    let moved = bench.now().target_tcp_pose.xyz[2] - before;
    assert!(moved.abs() < 2e-3, "{what:?}: {moved}");
    assert!(bench.stops.is_empty(), "{:?}", bench.stops);
    // Without power the target is where the arm stands, which a plate has pushed a little off.
    let end = bench.now();
    bench
        .states
        .retain(|state| state.robot_mode == RobotMode::Running);
    bench.check_limits();
    bench.states.push(end);
    bench
}

#[test]
fn every_way_out_brings_the_arm_to_rest_without_a_jump() {
    let all = CommandKind::Machine(MachineCommand::Stop {
        only: CommandId::NONE,
    });
    for what in [
        CommandKind::Overlay(OverlayCommand::EndForceMode),
        all,
        CommandKind::Machine(MachineCommand::PowerOff),
    ] {
        let bench = left_by(what);
        assert!(!bench.now().force_mode, "{what:?}");
    }
    assert_eq!(
        left_by(CommandKind::Machine(MachineCommand::PowerOff))
            .now()
            .robot_mode,
        RobotMode::PowerOff
    );
}

#[test]
fn a_pause_holds_the_arm_and_resume_presses_on() {
    let mut bench = left_by(CommandKind::Machine(MachineCommand::Pause));
    assert!(bench.now().force_mode);
    let there = bench.now().target_q;
    bench.run(50);
    assert_eq!(bench.now().target_q, there);
    bench.send(MachineCommand::Resume);
    let mut force = 0.0;
    for _ in 0..250 {
        force = press(&mut bench);
    }
    assert!((force / 40.0 - 1.0).abs() < 0.01, "{force}");
    bench.check_limits();
}

#[test]
fn a_stop_on_a_line_ends_force_mode_with_it() {
    let mut bench = Bench::new(over_plate(rigid("cs66"), 1e-3, 1e4, 0.0));
    let start = bench.now().target_tcp_pose;
    bench.send(down(20.0, 0.1));
    for _ in 0..150 {
        press(&mut bench);
    }
    let goal = RpyPose {
        xyz: [start.xyz[0], start.xyz[1] + 0.2, start.xyz[2]],
        ..start
    };
    let line = bench.send(movel(goal));
    for _ in 0..100 {
        press(&mut bench);
    }
    let stop = bench.send(MachineCommand::Stop {
        only: CommandId::NONE,
    });
    for _ in 0..200 {
        press(&mut bench);
    }
    assert_eq!(bench.outcome(line), Some(Outcome::Aborted));
    assert_eq!(bench.outcome(stop), Some(Outcome::Done));
    assert!(!bench.now().force_mode);
    assert_eq!(bench.now().target_qd, JointSpeeds::ZERO);
    bench.check_limits();
}

#[test]
fn ended_under_a_motion_the_tool_goes_back_to_its_line() {
    let mut bench = Bench::new(ideal("cs66"));
    let start = bench.now().target_tcp_pose;
    bench.do_it(down(20.0, 0.02));
    let goal = RpyPose {
        xyz: [start.xyz[0], start.xyz[1] + 0.2, start.xyz[2]],
        ..start
    };
    let line = bench.send(MotionCommand::MoveL {
        target: goal,
        acceleration: 0.5,
        speed: 0.05,
        duration: 0.0,
        radius: 0.0,
    });
    bench.run(200);
    assert!(bench.now().target_tcp_pose.xyz[2] < start.xyz[2] - 5e-3);
    assert_eq!(bench.do_it(OverlayCommand::EndForceMode), Outcome::Done);
    assert_eq!(bench.finish(line), Outcome::Done);
    bench.run(100);
    let end = bench.now().target_tcp_pose;
    for k in 0..3 {
        assert!((end.xyz[k] - goal.xyz[k]).abs() < 2e-6, "{end:?} {goal:?}");
    }
    assert_eq!(bench.now().target_qd, JointSpeeds::ZERO);
    bench.check_limits();
}

#[test]
fn a_protective_stop_ends_force_mode() {
    let mut bench = Bench::new(rigid("cs66"));
    bench.do_it(down(20.0, 0.02));
    bench.run(20);
    bench.do_it(MachineCommand::EmergencyStop { pressed: true });
    bench.run(300);
    assert!(!bench.now().force_mode);
    assert_eq!(bench.now().target_qd, JointSpeeds::ZERO);
    assert_ne!(bench.now().safety_mode, SafetyMode::Normal);
}

#[test]
fn the_tool_turns_until_no_moment_is_left() {
    // A wide tool on a tilted plate: the moment about the TCP grows with the angle between them.
    let mut bench = with_hand(ideal("cs66"));
    let tilt = 0.1;
    bench.do_it(force_mode(
        [0, 0, 0, 1, 1, 0],
        [0.0; 6],
        [0.0, 0.0, 0.0, 0.5, 0.5, 0.0],
    ));
    let start = Pose::from_rpy(&bench.now().actual_tcp_pose);
    let wanted = nalgebra::Rotation3::from_euler_angles(tilt, -tilt, 0.0) * start.rotation;
    for _ in 0..500 {
        let now = Pose::from_rpy(&bench.now().actual_tcp_pose);
        let angle = (wanted * now.rotation.inverse()).scaled_axis() * 50.0;
        bench.send(push([0.0, 0.0, 0.0, angle.x, angle.y, 0.0]));
        bench.tick();
    }
    let end = Pose::from_rpy(&bench.now().actual_tcp_pose);
    let left = (wanted * end.rotation.inverse()).scaled_axis();
    assert!(left.x.abs() < 2e-3 && left.y.abs() < 2e-3, "{left}");
    assert!((end.translation - start.translation).norm() < 1e-5);
    bench.check_limits();
}

#[test]
fn in_tcp_mode_the_wrench_is_along_the_tool() {
    let mut bench = Bench::new(ideal("cs66"));
    bench.do_it(movej(JointPositions([0.3, -1.3, 1.4, -1.0, -1.2, 0.5])));
    let start = Pose::from_rpy(&bench.now().target_tcp_pose);
    bench.do_it(OverlayCommand::ForceMode {
        frame: RpyPose::default(),
        selection: [false, false, true, false, false, false],
        wrench: [0.0, 0.0, 10.0, 0.0, 0.0, 0.0],
        mode: 3,
        speed_limits: [0.0, 0.0, 0.02, 0.0, 0.0, 0.0],
    });
    bench.run(300);
    let way = Pose::from_rpy(&bench.now().target_tcp_pose).translation - start.translation;
    let own = start.rotate_back(way);
    assert!(
        own.z > 0.005 && own.x.abs() < 1e-5 && own.y.abs() < 1e-5,
        "{own}"
    );
}

#[test]
fn bad_values_and_wrong_moments_are_refused_with_their_reason() {
    let mut bench = Bench::new(ideal("cs66"));
    let good = down(10.0, 0.1);
    let CommandKind::Overlay(OverlayCommand::ForceMode {
        frame,
        selection,
        wrench,
        speed_limits,
        ..
    }) = good
    else {
        unreachable!()
    };
    let with = |frame, wrench, mode, speed_limits| {
        CommandKind::Overlay(OverlayCommand::ForceMode {
            frame,
            selection,
            wrench,
            mode,
            speed_limits,
        })
    };
    let nan = RpyPose::from_array([f64::NAN, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let slow = [0.0, 0.0, -0.1, 0.0, 0.0, 0.0];
    for (kind, text) in [
        (with(nan, wrench, 0, speed_limits), "reference_frame"),
        (with(frame, [f64::NAN; 6], 0, speed_limits), "target_wrench"),
        (with(frame, wrench, 4, speed_limits), "mode is 4"),
        (with(frame, wrench, 0, slow), "speed_limits is -0.1"),
        (
            CommandKind::Sensing(SensingCommand::SetForceGain(2.1)),
            "scaling is 2.1",
        ),
        (
            CommandKind::Sensing(SensingCommand::SetForceGain(f64::NAN)),
            "scaling",
        ),
        (
            CommandKind::Sensing(SensingCommand::SetForceDamping(-0.1)),
            "damping is -0.1",
        ),
    ] {
        let Outcome::Refused(refusal) = bench.do_it(kind) else {
            panic!("{kind:?}");
        };
        assert!(refusal.to_string().contains(text), "{refusal}");
        assert!(!bench.now().force_mode);
    }
    let freedrive = CommandKind::Online(OnlineCommand::Freedrive {
        free_axes: [true; 6],
        frame: FreedriveFrame::Base,
    });
    assert_eq!(bench.do_it(good), Outcome::Done);
    let refused = Outcome::Refused(Refusal::InForceMode);
    assert_eq!(bench.do_it(freedrive), refused);
    assert_eq!(bench.do_it(OverlayCommand::EndForceMode), Outcome::Done);
    assert_eq!(bench.do_it(freedrive), Outcome::Done);
    assert!(matches!(
        bench.do_it(good),
        Outcome::Refused(Refusal::Busy { .. })
    ));
    assert_eq!(bench.do_it(OnlineCommand::EndFreedrive), Outcome::Done);
    assert_eq!(bench.do_it(MachineCommand::PowerOff), Outcome::Done);
    assert!(matches!(
        bench.do_it(good),
        Outcome::Refused(Refusal::NotReady { .. })
    ));
    assert_eq!(bench.do_it(OverlayCommand::EndForceMode), Outcome::Done);
}

#[test]
fn a_hand_of_any_strength_cannot_lead_the_arm_over_its_limits() {
    let mut bench = with_hand(unwatched("cs66"));
    // So much at once is a collision as well.
    bench.do_it(SensingCommand::SetCollisionDetection(false));
    bench.do_it(force_mode([1; 6], [0.0; 6], [1.0, 1.0, 1.0, 2.0, 2.0, 2.0]));
    for wrench in [
        [500.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, -900.0, 900.0, 50.0, 0.0, -80.0],
        [0.0, 0.0, -900.0, 0.0, 90.0, 0.0],
    ] {
        bench.do_it(push(wrench));
        bench.run(400);
    }
    assert!(bench.stops.is_empty(), "{:?}", bench.stops);
    bench.check_limits();
}

/// The controller can be handed to the motion thread.
#[test]
fn a_controller_may_change_threads() {
    const fn is_send<T: Send>() {}
    is_send::<ControlLoop>();
}

#[test]
fn a_thin_soft_sheet_holds_the_tool_that_is_pressed_deep_into_it() {
    // Past half of its thickness the far face is the nearer one: 5 N/mm and 40 N are 8 mm of 10.
    for plant in [PlantKind::Rigid, PlantKind::Ideal] {
        for name in ["cs63", "cs66", "cs620"] {
            let mut config = CycleConfig {
                plant,
                ..rigid(name)
            };
            config.tcp = RpyPose::from_array([0.0, 0.0, 0.2, 0.0, 0.0, 0.0]);
            let [x, y, z] = config.first_state().actual_tcp_pose.xyz;
            let top = z - 0.004;
            config.surroundings.obstacles.push(Obstacle {
                name: "sheet".to_owned(),
                solid: PlacedShape {
                    pose: Pose::from_translation(x, y, top - 0.005),
                    shape: Shape::Box {
                        half: [0.25, 0.25, 0.005],
                    },
                },
                body: None,
                stiffness: Some(5000.0),
                damping: 0.0,
                friction: 0.0,
            });
            let mut bench = Bench::new(config);
            bench.do_it(down(40.0, 0.02));
            bench.run(1000);
            let mut highest: f64 = 0.0;
            let mut least = f64::INFINITY;
            for _ in 0..250 {
                let force = press(&mut bench);
                (highest, least) = (highest.max(force), least.min(force));
            }
            let depth = top - bench.now().actual_tcp_pose.xyz[2];
            let place = format!("{name} {plant:?}: {least} to {highest} N, {depth} m");
            assert!(bench.stops.is_empty(), "{place} {:?}", bench.stops);
            assert!(least > 39.0 && highest < 41.0, "{place}");
            assert!((depth - 0.008).abs() < 0.0005, "{place}");
        }
    }
}
