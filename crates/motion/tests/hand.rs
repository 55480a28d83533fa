//! What acts on the arm from outside: freedrive follows it, collision detection stops for it, the sensor reads it.
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
use kinematics::{JointPositions, JointSpeeds, Payload, Pose, RobotModel, RpyPose, Wrench};
use motion::CycleConfig;
use motion::external::{TimedWrench, WrenchFrame};
use motion_api::{
    CommandKind, FreedriveFrame, MachineCommand, MotionCommand, MotionMode, OnlineCommand, Outcome,
    Refusal, SafetyMode, SensingCommand, SettingCommand, StopReason,
};

fn rigid(model: &str) -> CycleConfig {
    CycleConfig::new(RobotModel::built_in(model).unwrap())
}

fn freedrive(free: [u8; 6], frame: FreedriveFrame) -> CommandKind {
    CommandKind::Online(OnlineCommand::Freedrive {
        free_axes: free.map(|x| x == 1),
        frame,
    })
}

#[test]
fn the_hand_leads_a_free_arm_and_it_stops_when_the_hand_lets_go() {
    for config in [ideal("cs66"), rigid("cs66")] {
        let mut bench = Bench::new(config);
        let start = bench.now().actual_tcp_pose.xyz;
        assert_eq!(
            bench.do_it(freedrive([1; 6], FreedriveFrame::Base)),
            Outcome::Done
        );
        bench.push([0.0, 20.0, 0.0, 0.0, 0.0, 0.0]);
        bench.run(250);
        assert_eq!(
            bench.now().motion_mode,
            MotionMode::Freedrive,
            "{:?}",
            bench.stops
        );
        let led = bench.now().actual_tcp_pose.xyz;
        assert!(led[1] - start[1] > 0.05, "{start:?} {led:?}");
        bench.push([0.0; 6]);
        bench.run(250);
        assert!(
            bench.now().target_qd.max_abs() < 1e-6,
            "{:?}",
            bench.now().target_qd
        );
        assert_eq!(bench.do_it(OnlineCommand::EndFreedrive), Outcome::Done);
        assert_eq!(bench.do_it(OnlineCommand::EndFreedrive), Outcome::Done);
        assert_eq!(bench.now().motion_mode, MotionMode::Idle);
        assert!(bench.stops.is_empty());
        bench.check_limits();
    }
}

#[test]
fn locked_axes_do_not_move_in_base_tool_and_pose_frames() {
    let turned = RpyPose::from_array([0.1, 0.2, 0.3, 0.3, -0.4, 0.7]);
    for frame in [
        FreedriveFrame::Base,
        FreedriveFrame::Tool,
        FreedriveFrame::Pose(turned),
    ] {
        for free in [[0, 1, 0, 0, 0, 0], [1, 0, 1, 0, 0, 0], [0, 0, 0, 0, 0, 1]] {
            let mut bench = Bench::new(ideal("cs66"));
            let start = Pose::from_rpy(&bench.now().target_tcp_pose);
            let axes = match frame {
                FreedriveFrame::Base => Pose::IDENTITY.rotation,
                FreedriveFrame::Tool => start.rotation,
                FreedriveFrame::Pose(pose) => Pose::from_rpy(&pose).rotation,
            };
            bench.do_it(freedrive(free, frame));
            bench.push([10.0, 25.0, -12.0, 1.0, -1.5, 2.0]);
            bench.run(200);
            let now = Pose::from_rpy(&bench.now().target_tcp_pose);
            let way = axes.inverse() * (now.translation - start.translation);
            let turn = axes.inverse() * (now.rotation * start.rotation.inverse()).scaled_axis();
            let moved = [way.x, way.y, way.z, turn.x, turn.y, turn.z];
            for k in 0..6 {
                if free[k] == 0 {
                    assert!(moved[k].abs() < 1e-8, "{frame:?} {free:?} {moved:?}");
                } else {
                    assert!(moved[k].abs() > 1e-3, "{frame:?} {free:?} {moved:?}");
                }
            }
            bench.check_limits();
        }
    }
}

#[test]
fn speeds_belong_to_positions_where_the_axes_turn_with_the_tool() {
    let mut bench = Bench::new(ideal("cs66"));
    bench.do_it(freedrive([1, 1, 0, 0, 0, 1], FreedriveFrame::Tool));
    bench.push([25.0, -15.0, 0.0, 0.0, 0.0, -4.0]);
    bench.run(250);
    let step = bench.cycle.step_time();
    let led = &bench.states[bench.states.len() - 100..];
    let turning = led[99].target_tcp_speed[5].abs();
    assert!(turning > 0.3, "{turning}");
    for around in led.windows(3) {
        let [before, now, after] = around else {
            panic!()
        };
        for k in 0..3 {
            let moved = after.target_tcp_pose.xyz[k] - before.target_tcp_pose.xyz[k];
            let off = moved / (2.0 * step) - now.target_tcp_speed[k];
            assert!(off.abs() < 5e-5, "{off} in cycle {}", now.cycle);
        }
    }
    bench.check_limits();
}

#[test]
fn freedrive_excludes_motion_and_a_stop_ends_it() {
    let mut bench = Bench::new(ideal("cs66"));
    let home = bench.now().target_q;
    let running = bench.send(freedrive([1; 6], FreedriveFrame::Base));
    bench.tick();
    let busy = Outcome::Refused(Refusal::Busy { running });
    assert_eq!(bench.do_it(movej(home)), busy);
    bench.push([0.0, 30.0, 0.0, 0.0, 0.0, 0.0]);
    bench.run(50);
    let stop = CommandKind::Machine(MachineCommand::Stop {
        only: motion_api::CommandId::NONE,
    });
    assert_eq!(bench.do_it(stop), Outcome::Done);
    assert_eq!(bench.now().motion_mode, MotionMode::Idle);
    assert_eq!(bench.now().target_qd, JointSpeeds::ZERO);
    bench.push([0.0; 6]);
    assert_eq!(bench.do_it(movej(home)), Outcome::Done);
}

#[test]
fn a_hard_hand_cannot_lead_the_arm_over_its_limits() {
    let mut bench = Bench::new(unwatched("cs66"));
    bench.do_it(freedrive([1; 6], FreedriveFrame::Base));
    for wrench in [
        [500.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, -900.0, 900.0, 50.0, 0.0, -80.0],
        [0.0, 0.0, -900.0, 0.0, 90.0, 0.0],
    ] {
        bench.push(wrench);
        bench.run(400);
    }
    assert!(bench.stops.is_empty(), "{:?}", bench.stops);
    bench.check_limits();
}

#[test]
fn loads_of_the_cell_act_in_their_time_and_frame() {
    let mut config = ideal("cs66");
    config.loads = vec![
        TimedWrench {
            at: 0.1,
            duration: 0.2,
            wrench: Wrench::from_array([0.0, 0.0, -20.0, 0.0, 0.0, 0.0]),
            frame: WrenchFrame::Base,
        },
        TimedWrench {
            at: 0.2,
            duration: 0.2,
            wrench: Wrench::from_array([3.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
            frame: WrenchFrame::Tool,
        },
    ];
    let mut bench = Bench::new(config);
    bench.run(120);
    for state in &bench.states[1..] {
        let base_from_tcp = Pose::from_rpy(&state.actual_tcp_pose);
        let down = base_from_tcp.rotate_back(nalgebra::Vector3::new(0.0, 0.0, -20.0));
        let (first, second) = (
            (0.1..0.1 + 0.2).contains(&state.time),
            (0.2..0.2 + 0.2).contains(&state.time),
        );
        let mut wanted = [0.0; 6];
        if first {
            (0..3).for_each(|k| wanted[k] += down[k]);
        }
        if second {
            wanted[0] += 3.0;
            wanted[4] += 1.0;
        }
        for k in 0..6 {
            assert!(
                (state.tcp_force[k] - wanted[k]).abs() < 1e-9,
                "{} {:?}",
                state.time,
                state.tcp_force
            );
        }
    }
}

#[test]
fn external_torques_are_what_the_hand_makes_on_both_plants() {
    for config in [ideal("cs66"), rigid("cs66")] {
        let mut bench = Bench::new(config);
        bench.push([0.0, 10.0, -15.0, 0.5, 0.0, 0.2]);
        bench.run(150);
        assert!(bench.stops.is_empty(), "{:?}", bench.stops);
        let state = bench.now();
        let model = RobotModel::built_in("cs66").unwrap();
        let (_, jacobian) = model.tcp_pose_and_jacobian(&state.actual_q, &Pose::IDENTITY);
        let wrench = nalgebra::Vector6::new(0.0, 10.0, -15.0, 0.5, 0.0, 0.2);
        let wanted = jacobian.transpose() * wrench;
        for joint in 0..6 {
            let found = state.external_torque[joint];
            assert!(
                (found - wanted[joint]).abs() < 0.02,
                "{joint}: {found} {}",
                wanted[joint]
            );
        }
        assert!(bench.stops.is_empty());
    }
}

#[test]
fn a_collision_stops_the_arm_and_names_the_joint_and_the_force() {
    let mut bench = Bench::new(rigid("cs66"));
    bench.push([0.0, 0.0, -160.0, 0.0, 0.0, 0.0]);
    bench.run(20);
    let [
        StopReason::Collision {
            joint,
            torque,
            limit,
            force,
        },
    ] = bench.stops[..]
    else {
        panic!("{:?}", bench.stops);
    };
    assert!(
        torque.abs() > limit && force > 60.0 && force < 200.0,
        "{joint} {torque} {limit} {force}"
    );
    assert_eq!(bench.now().safety_mode, SafetyMode::ProtectiveStop);
    let text = bench.stops[0].to_string();
    assert!(
        text.starts_with(&format!("collision at joint {}", joint + 1)),
        "{text}"
    );
}

#[test]
fn sensitivity_decides_and_without_detection_nothing_stops() {
    let hit = |prepare: &[CommandKind]| {
        let mut bench = Bench::new(rigid("cs66"));
        prepare
            .iter()
            .for_each(|kind| assert_eq!(bench.do_it(*kind), Outcome::Done));
        bench.push([0.0, 0.0, -60.0, 0.0, 0.0, 0.0]);
        bench.run(100);
        !bench.stops.is_empty()
    };
    assert!(hit(&[CommandKind::Sensing(
        SensingCommand::SetCollisionSensitivity(100)
    )]));
    assert!(!hit(&[CommandKind::Sensing(
        SensingCommand::SetCollisionSensitivity(10)
    )]));
    assert!(!hit(&[
        CommandKind::Sensing(SensingCommand::SetCollisionSensitivity(100)),
        CommandKind::Sensing(SensingCommand::SetCollisionDetection(false)),
    ]));
    let mut bench = Bench::new(ideal("cs66"));
    for ratio in [0, 9, 101] {
        let outcome = bench.do_it(SensingCommand::SetCollisionSensitivity(ratio));
        assert!(matches!(
            outcome,
            Outcome::Refused(Refusal::BadValue { .. })
        ));
    }
}

#[test]
fn motion_with_the_rated_payload_is_no_collision_at_the_highest_sensitivity() {
    for model in MODELS {
        let mut config = rigid(model);
        let rated = config.model.rated_payload_kg().unwrap();
        config.payload = Payload::new(rated, [0.0, 0.0, 0.05], [0.0; 6]).unwrap();
        let home = config.home;
        let mut bench = Bench::new(config);
        bench.do_it(SensingCommand::SetCollisionSensitivity(100));
        let mut seed = 7_u64;
        let mut random = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) as f64 / f64::from(1_u32 << 31) * 2.0 - 1.0
        };
        for _ in 0..6 {
            let goal = JointPositions(core::array::from_fn(|joint| home[joint] + 0.8 * random()));
            let kind = CommandKind::Motion(MotionCommand::MoveJ {
                target: goal,
                acceleration: 10.0,
                speed: 3.0,
                duration: 0.0,
                radius: 0.0,
            });
            assert_eq!(
                bench.do_it(kind),
                Outcome::Done,
                "{model} {:?}",
                bench.stops
            );
        }
        let effort = RobotModel::built_in(model).unwrap().limits().effort;
        let most = bench.states.iter().fold(0.0_f64, |most, s| {
            (0..6).fold(most, |m, j| m.max((s.external_torque[j] / effort[j]).abs()))
        });
        println!(
            "{model}: largest residual {:.4} of the nominal torque",
            most
        );
        assert!(most < 0.05, "{model}: {most}");
    }
}

#[test]
fn gravity_from_another_side_is_carried() {
    let mut bench = Bench::new(rigid("cs66"));
    assert_eq!(
        bench.do_it(SettingCommand::SetGravity([0.0, -9.81, 0.0])),
        Outcome::Done
    );
    bench.run(100);
    let state = bench.now();
    assert_eq!(state.gravity, [0.0, -9.81, 0.0]);
    for joint in 0..6 {
        assert!((state.actual_torque[joint] - state.target_torque[joint]).abs() < 1e-4);
        assert!(state.external_torque[joint].abs() < 1e-2);
        assert!((state.actual_q[joint] - state.target_q[joint]).abs() < 1e-6);
    }
    let outcome = bench.do_it(SettingCommand::SetGravity([f64::NAN, 0.0, 0.0]));
    assert!(matches!(
        outcome,
        Outcome::Refused(Refusal::BadValue { .. })
    ));
}

#[test]
fn loaded_joints_get_warm() {
    let mut bench = Bench::new(rigid("cs66"));
    bench.run(1000);
    let (first, last) = (bench.states[1], bench.now());
    assert!(last.joint_temperatures[1] > first.joint_temperatures[1]);
    assert!(last.joint_temperatures[1] > last.joint_temperatures[5]);
    assert!((20.0..80.0).contains(&last.controller_temperature));
}
