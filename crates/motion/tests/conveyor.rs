//! Conveyor tracking: the tool goes along with the belt, standing or moving, and safety planes hold it back.
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

use common::draw::Draw;
use common::{Bench, MODELS, ideal, movej, movel};
use core::f64::consts::TAU;
use kinematics::safety::{PlaneMode, SafetyPlane};
use kinematics::{Pose, RobotModel, RpyPose, SafetyBounds};
use motion::modes::encoder::Belt;
use motion::{CycleConfig, PlantKind};
use motion_api::{
    CommandId, CommandKind, EncoderRange, MachineCommand, MotionCommand, MotionMode, OnlineCommand,
    Outcome, OverlayCommand, PulseDecoding, Refusal, RobotState, SettingCommand, StopReason,
};
use nalgebra::Vector3;

const TICKS: f64 = 1000.0;
/// Largest error that counts as tracking, m.
const CLOSE: f64 = 0.05e-3;

fn with_belt(plant: PlantKind, ticks_per_second: f64) -> CycleConfig {
    let belt = Belt {
        encoder: 0,
        ticks_per_second,
        start_at: 0.2,
    };
    CycleConfig {
        plant,
        belts: [Some(belt), None],
        ..CycleConfig::new(RobotModel::built_in("cs66").unwrap())
    }
}

fn linear(direction: [f64; 3]) -> CommandKind {
    CommandKind::Overlay(OverlayCommand::TrackConveyorLinear {
        direction,
        ticks_per_meter: TICKS,
        encoder: 0,
    })
}

#[test]
fn the_tool_follows_a_belt_at_half_a_metre_a_second_within_a_twentieth_of_a_millimetre() {
    for plant in [PlantKind::Ideal, PlantKind::Rigid] {
        let mut bench = Bench::new(with_belt(plant, 0.5 * TICKS));
        let start = Pose::from_rpy(&bench.now().target_tcp_pose);
        assert_eq!(bench.do_it(linear([0.0, 2.0, 0.0])), Outcome::Done);
        let mut worst = 0.0_f64;
        for _ in 0..300 {
            let state = bench.tick();
            if state.time > 0.9 {
                let belt = 0.5 * (state.time - 0.2);
                let wanted = start.translation + Vector3::new(0.0, belt, 0.0);
                let actual = Vector3::from(state.actual_tcp_pose.xyz);
                worst = worst.max((actual - wanted).norm());
            }
        }
        println!("{plant:?}: largest error {worst:.2e} m");
        assert!(worst < CLOSE, "{plant:?} {worst}");
        assert_eq!(bench.now().motion_mode, MotionMode::Conveyor);
        assert_eq!(
            bench.do_it(OverlayCommand::StopConveyorTracking),
            Outcome::Done,
            "{:?}",
            bench.stops
        );
        assert_eq!(bench.now().motion_mode, MotionMode::Idle);
        assert!(bench.stops.is_empty());
        bench.check_limits();
        // And the arm obeys as before.
        let home = bench.states[0].target_q;
        assert_eq!(bench.do_it(movej(home)), Outcome::Done);
        bench.check_limits();
    }
}

#[test]
fn a_line_during_tracking_is_drawn_on_the_belt() {
    let mut bench = Bench::new(with_belt(PlantKind::Ideal, 0.2 * TICKS));
    let start = Pose::from_rpy(&bench.now().target_tcp_pose);
    bench.do_it(linear([0.0, 1.0, 0.0]));
    bench.run(250);
    let mut goal = bench.states[0].target_tcp_pose;
    goal.xyz[2] -= 0.1;
    goal.xyz[0] += 0.05;
    assert_eq!(bench.do_it(movel(goal)), Outcome::Done);
    let state = bench.now();
    let belt = 0.2 * (state.time - 0.2);
    let wanted = start.translation + Vector3::new(0.05, belt, -0.1);
    let off = Vector3::from(state.target_tcp_pose.xyz) - wanted;
    assert!(off.norm() < CLOSE, "{off:?}");
    bench.check_limits();
    bench.do_it(OverlayCommand::StopConveyorTracking);
}

#[test]
fn a_turntable_carries_the_tool_and_turns_it_only_when_asked() {
    for rotate_tool in [false, true] {
        let mut config = with_belt(PlantKind::Ideal, 4096.0 * 0.3 / TAU);
        config.belts[1] = config.belts[0]
            .take()
            .map(|belt| Belt { encoder: 1, ..belt });
        let mut bench = Bench::new(config);
        let start = Pose::from_rpy(&bench.now().target_tcp_pose);
        let center = RpyPose::from_array([-0.6, 0.3, 0.0, 0.0, 0.0, 0.4]);
        let kind = CommandKind::Overlay(OverlayCommand::TrackConveyorCircular {
            center,
            ticks_per_revolution: 4096.0,
            rotate_tool,
            encoder: 1,
        });
        assert_eq!(bench.do_it(kind), Outcome::Done);
        bench.run(400);
        let state = bench.now();
        let angle = 0.3 * (state.time - 0.2);
        let turn = nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), angle);
        let middle = Vector3::from(center.xyz);
        let wanted = middle + turn * (start.translation - middle);
        let off = Vector3::from(state.target_tcp_pose.xyz) - wanted;
        assert!(off.norm() < CLOSE, "{off:?} {:?}", bench.stops);
        let rotation = Pose::from_rpy(&state.target_tcp_pose).rotation;
        let upright = if rotate_tool {
            turn * start.rotation
        } else {
            start.rotation
        };
        assert!(rotation.angle_to(&upright) < 1e-4);
        bench.check_limits();
        bench.do_it(OverlayCommand::StopConveyorTracking);
    }
}

#[test]
fn counts_of_the_program_move_the_tool_past_the_end_of_the_counter() {
    let mut bench = Bench::new(ideal("cs66"));
    bench.do_it(SettingCommand::EncoderEnableSetTickCount {
        encoder: 0,
        range: EncoderRange::Unsigned8,
    });
    bench.do_it(SettingCommand::EncoderSetTickCount {
        encoder: 0,
        count: 250.0,
    });
    let start = bench.now().target_tcp_pose.xyz;
    bench.do_it(linear([0.0, 1.0, 0.0]));
    for k in 1..=60 {
        let count = f64::from((250 + k) % 256);
        bench.do_it(SettingCommand::EncoderSetTickCount { encoder: 0, count });
    }
    assert_eq!(bench.now().encoder_counts[0], 54.0);
    bench.run(300);
    let way = bench.now().target_tcp_pose.xyz[1] - start[1];
    assert!((way - 0.06).abs() < 1e-6, "{way}");
    bench.check_limits();
    let outcome = bench.do_it(SettingCommand::EncoderSetTickCount {
        encoder: 0,
        count: 256.0,
    });
    assert!(matches!(
        outcome,
        Outcome::Refused(Refusal::BadValue { .. })
    ));
    let outcome = bench.do_it(SettingCommand::EncoderSetTickCount {
        encoder: 1,
        count: 1.0,
    });
    assert!(matches!(
        outcome,
        Outcome::Refused(Refusal::BadValue { .. })
    ));
}

#[test]
fn pulses_on_the_fast_inputs_are_counted() {
    let mut bench = Bench::new(ideal("cs66"));
    bench.do_it(SettingCommand::EncoderEnablePulseDecode {
        encoder: 1,
        decoding: PulseDecoding::Quadrature,
        channel_a: 16,
        channel_b: 17,
    });
    for _ in 0..3 {
        for (index, level) in [(16, true), (17, true), (16, false), (17, false)] {
            bench.do_it(SettingCommand::SetDigitalInput { index, level });
        }
    }
    assert_eq!(bench.now().encoder_counts, [0.0, 12.0]);
    let same = CommandKind::Setting(SettingCommand::EncoderEnablePulseDecode {
        encoder: 1,
        decoding: PulseDecoding::Quadrature,
        channel_a: 16,
        channel_b: 16,
    });
    assert!(matches!(
        bench.do_it(same),
        Outcome::Refused(Refusal::BadValue { .. })
    ));
}

#[test]
fn a_second_track_is_refused_and_a_stop_of_everything_ends_the_first() {
    let mut bench = Bench::new(with_belt(PlantKind::Ideal, 0.3 * TICKS));
    bench.do_it(linear([0.0, 1.0, 0.0]));
    bench.run(200);
    assert_eq!(
        bench.do_it(linear([1.0, 0.0, 0.0])),
        Outcome::Refused(Refusal::ConveyorTracking)
    );
    assert_eq!(
        bench.do_it(MachineCommand::Stop {
            only: CommandId::NONE
        }),
        Outcome::Done
    );
    assert_eq!(bench.now().motion_mode, MotionMode::Idle);
    bench.check_limits();
    for direction in [[0.0; 3], [f64::NAN, 0.0, 0.0]] {
        assert!(matches!(
            bench.do_it(linear(direction)),
            Outcome::Refused(_)
        ));
    }
}

#[test]
fn a_belt_that_leaves_the_reach_ends_in_a_protective_stop() {
    let mut bench = Bench::new(with_belt(PlantKind::Ideal, 0.5 * TICKS));
    bench.do_it(linear([-1.0, 0.0, 0.0]));
    bench.run(1500);
    assert_eq!(bench.stops.len(), 1);
    assert!(bench.now().target_qd.max_abs() == 0.0);
}

fn wall(config: CycleConfig, y: f64, ci_pair: Option<u8>) -> CycleConfig {
    let plane = SafetyPlane::new([0.0, y, 0.0], [0.0, -1.0, 0.0], PlaneMode::Normal, ci_pair);
    CycleConfig {
        safety: SafetyBounds::default().with_plane(plane.unwrap()).unwrap(),
        ..config
    }
}

#[test]
fn the_tcp_never_crosses_a_safety_plane() {
    let y = ideal("cs66").first_state().target_tcp_pose.xyz[1];
    let mut bench = Bench::new(wall(ideal("cs66"), y + 0.2, None));
    // A target behind it is refused, the arm stays.
    let mut goal = bench.now().target_tcp_pose;
    goal.xyz[1] += 0.25;
    let outcome = bench.do_it(movel(goal));
    assert!(
        matches!(
            outcome,
            Outcome::Refused(Refusal::SafetyPlane { plane: 0, .. })
        ),
        "{outcome:?}"
    );
    // Going there anyway stops the arm before the plane.
    bench.do_it(OnlineCommand::SpeedL {
        speed: [0.0, 0.8, 0.0, 0.0, 0.0, 0.0],
        acceleration: 2.0,
        rotation_acceleration: 2.0,
        duration: Some(2.0),
    });
    assert!(
        matches!(bench.stops[..], [StopReason::SafetyPlane { plane: 0, .. }]),
        "{:?}",
        bench.stops
    );
    bench.run(200);
    for state in &bench.states {
        assert!(
            state.target_tcp_pose.xyz[1] < y + 0.2,
            "{}",
            state.target_tcp_pose.xyz[1]
        );
    }
    assert!(bench.now().target_tcp_pose.xyz[1] > y + 0.1);
}

#[test]
fn a_plane_bound_to_inputs_counts_while_both_are_high() {
    let y = ideal("cs66").first_state().target_tcp_pose.xyz[1];
    let mut bench = Bench::new(wall(ideal("cs66"), y + 0.05, Some(1)));
    let home = bench.now().target_tcp_pose;
    let mut goal = home;
    goal.xyz[1] += 0.1;
    assert_eq!(bench.do_it(movel(goal)), Outcome::Done);
    assert_eq!(bench.do_it(movel(home)), Outcome::Done);
    for index in [18, 19] {
        bench.do_it(SettingCommand::SetDigitalInput { index, level: true });
    }
    let outcome = bench.do_it(movel(goal));
    assert!(matches!(
        outcome,
        Outcome::Refused(Refusal::SafetyPlane { .. })
    ));
}

#[test]
fn fast_moves_on_a_belt_keep_the_joint_limits() {
    let mut bench = Bench::new(with_belt(PlantKind::Ideal, 0.2 * TICKS));
    let home = bench.now().target_q;
    bench.do_it(linear([0.0, 1.0, 0.0]));
    bench.run(150);
    let mut there = home;
    there[0] -= 0.6;
    there[1] -= 0.3;
    there[3] += 0.5;
    for target in [there, home, there] {
        let kind = CommandKind::Motion(MotionCommand::MoveJ {
            target,
            acceleration: 100.0,
            speed: 10.0,
            duration: 0.0,
            radius: 0.0,
        });
        assert_eq!(bench.do_it(kind), Outcome::Done, "{:?}", bench.stops);
    }
    bench.do_it(OverlayCommand::StopConveyorTracking);
    assert!(bench.stops.is_empty());
    bench.check_limits();
}

/// A belt and a motion on it under limits of TCP and elbow: never over them, in a protective stop neither.
#[test]
fn on_a_belt_the_speed_limits_of_tcp_and_elbow_are_kept() {
    let (mut done, mut stopped, mut too_fast, mut slow) = (0, 0, 0, 0);
    for seed in 0..60 {
        let mut draw = Draw::new(seed);
        let model = *draw.pick(&MODELS);
        let mut config = CycleConfig {
            step_time: *draw.pick(&[0.002, 0.004, 0.008]),
            ..ideal(model)
        };
        let belt_speed = draw.spread(0.02, 0.4);
        config.belts[0] = Some(Belt {
            encoder: 0,
            ticks_per_second: belt_speed * TICKS,
            start_at: 0.2,
        });
        let (tcp, elbow) = (draw.spread(0.05, 1.0), draw.spread(0.05, 1.0));
        config.limits.tcp_speed = Some(tcp);
        config.limits.elbow_speed = draw.chance(0.5).then_some(elbow);
        let elbow = config.limits.elbow_speed.unwrap_or(f64::INFINITY);
        let mut bench = Bench::new(config);
        let track = if draw.chance(0.5) {
            linear([0.0, 1.0, 0.0])
        } else {
            CommandKind::Overlay(OverlayCommand::TrackConveyorCircular {
                center: RpyPose::from_array([-0.6, 0.3, 0.0, 0.0, 0.0, 0.0]),
                ticks_per_revolution: TICKS * TAU,
                rotate_tool: draw.chance(0.5),
                encoder: 0,
            })
        };
        bench.do_it(track);
        bench.run((1.0 / bench.cycle.step_time()) as usize);
        for _ in 0..2 {
            let mut goal = bench.states[0].target_tcp_pose;
            (0..3).for_each(|k| goal.xyz[k] += draw.between(-0.1, 0.1));
            let id = bench.send(MotionCommand::MoveL {
                target: goal,
                acceleration: draw.spread(0.5, 10.0),
                speed: draw.spread(0.05, 1.5),
                duration: 0.0,
                radius: 0.0,
            });
            let late = bench.now().time + 5.0;
            while bench.outcome(id).is_none() && bench.now().time < late {
                bench.tick();
            }
            done += usize::from(bench.outcome(id) == Some(Outcome::Done));
        }
        bench.do_it(OverlayCommand::StopConveyorTracking);
        bench.run(300);
        bench.check_limits();
        stopped += bench.stops.len();
        let at = format!(
            "{seed} {model} belt {belt_speed} tcp {tcp} elbow {elbow} {:?}",
            bench.stops
        );
        if matches!(
            track,
            CommandKind::Overlay(OverlayCommand::TrackConveyorLinear { .. })
        ) && belt_speed > tcp
        {
            // It cannot be followed, and nobody is left to believe that it is.
            assert_eq!(bench.stops.len(), 1, "{at}");
            too_fast += 1;
        } else if belt_speed < 0.2 * tcp.min(elbow) {
            assert!(bench.stops.is_empty(), "{at}");
            slow += 1;
        }
        for pair in bench.states.windows(2) {
            let step = bench.cycle.step_time();
            let way = |xyz: fn(&RobotState) -> [f64; 3]| {
                (Vector3::from(xyz(&pair[1])) - Vector3::from(xyz(&pair[0]))).norm() / step
            };
            let (v, e) = (way(|s| s.target_tcp_pose.xyz), way(|s| s.elbow_position));
            assert!(
                v <= tcp * (1.0 + 1e-6),
                "{at}: TCP at {v} in cycle {}",
                pair[1].cycle
            );
            assert!(
                e <= elbow * (1.0 + 1e-6),
                "{at}: elbow at {e} in cycle {}",
                pair[1].cycle
            );
        }
    }
    println!("{done} motions done, {stopped} stopped, {too_fast} belts too fast, {slow} slow");
    assert!(done > 40 && too_fast > 3 && slow > 5);
}
