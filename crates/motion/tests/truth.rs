//! A plant with a truth of its own: another payload than the controller was told, friction, rotors, hands.
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

use common::{Bench, MODELS, movej};
use kinematics::{JointPositions, JointTorques, Payload, Pose, RobotModel, RpyPose, Wrench};
use motion::external::{TimedWrench, WrenchFrame};
use motion::{ConfigError, CycleConfig, Drivetrain, PlantKind, PlantParameters};
use motion_api::{
    CommandKind, FreedriveFrame, OnlineCommand, Outcome, RobotState, SensingCommand,
    SettingCommand, StopReason,
};
use nalgebra::Vector3;

const PLANTS: [PlantKind; 3] = [PlantKind::Rigid, PlantKind::Rapier, PlantKind::Ideal];

fn with(model: &str, plant: PlantKind) -> CycleConfig {
    CycleConfig {
        plant,
        ..CycleConfig::new(RobotModel::built_in(model).unwrap())
    }
}

fn payload(mass: f64) -> Payload {
    Payload::new(mass, [0.03, -0.02, 0.08], [0.0; 6]).unwrap()
}

fn off(state: &RobotState) -> f64 {
    (0..6).fold(0.0, |most, j| {
        (state.actual_q[j] - state.target_q[j]).abs().max(most)
    })
}

/// The force on the tool in base axes.
fn force(state: &RobotState) -> Vector3<f64> {
    let w = state.tcp_force;
    Pose::from_rpy(&state.actual_tcp_pose).rotate(Vector3::new(w[0], w[1], w[2]))
}

fn losses(model: &str) -> Drivetrain {
    let effort = RobotModel::built_in(model).unwrap().limits().effort;
    Drivetrain {
        coulomb: effort.map(|nominal| 0.06 * nominal),
        viscous: effort.0.map(|nominal| 0.04 * nominal),
        rotor_inertia: effort.0.map(|nominal| 0.004 * nominal),
    }
}

#[test]
fn a_payload_that_was_not_told_is_read_as_its_weight_and_carried_by_the_joints() {
    for plant in PLANTS {
        let mut config = with("cs66", plant);
        config.truth.payload = Some(payload(1.5));
        let mut bench = Bench::new(config.clone());
        bench.run(200);
        let state = bench.now();
        assert!(bench.stops.is_empty(), "{plant:?} {:?}", bench.stops);
        let weight = Vector3::new(0.0, 0.0, -1.5 * 9.81);
        assert!(
            (force(&state) - weight).norm() < 1e-3,
            "{plant:?} {}",
            force(&state)
        );
        let truth = config.model.dynamics(&payload(1.5), config.gravity);
        let carried = truth.gravity_torques(&state.actual_q);
        for joint in 0..6 {
            assert!(
                (state.actual_torque[joint] - carried[joint]).abs() < 1e-3,
                "{plant:?}"
            );
            // The controller's own figure stays its own.
            let told = config.model.dynamics(&Payload::NONE, config.gravity);
            let thought = told.gravity_torques(&state.target_q);
            assert!((state.target_torque[joint] - thought[joint]).abs() < 1e-9);
        }
        assert!(off(&state) < 2e-3, "{plant:?} {}", off(&state));
        // Told, it is gone from the reading; the raw one keeps the weight.
        assert_eq!(
            bench.do_it(SettingCommand::SetPayload(payload(1.5))),
            Outcome::Done
        );
        bench.run(200);
        assert!(force(&bench.now()).norm() < 1e-3, "{plant:?}");
        let raw = bench.now().raw_wrench;
        assert!((Vector3::new(raw[0], raw[1], raw[2]).norm() - 1.5 * 9.81).abs() < 1e-3);
    }
}

#[test]
fn a_wrong_payload_makes_freedrive_drift_the_way_of_the_weight() {
    for plant in PLANTS {
        for (real, told, sign) in [(2.0, 0.0, -1.0), (0.0, 2.0, 1.0), (2.0, 2.0, 0.0)] {
            let mut config = with("cs66", plant);
            config.truth.payload = Some(payload(real));
            config.payload = payload(told);
            let mut bench = Bench::new(config);
            bench.run(50);
            let start = bench.now().actual_tcp_pose.xyz[2];
            let kind = CommandKind::Online(OnlineCommand::Freedrive {
                free_axes: [true, true, true, false, false, false],
                frame: FreedriveFrame::Base,
            });
            assert_eq!(bench.do_it(kind), Outcome::Done);
            bench.run(250);
            let drift = bench.now().actual_tcp_pose.xyz[2] - start;
            let place = format!("{plant:?} {real} told {told}: {drift}");
            if sign == 0.0 {
                assert!(drift.abs() < 1e-4, "{place}");
            } else {
                assert!(drift * sign > 0.01, "{place}");
            }
        }
    }
}

#[test]
fn a_payload_far_from_what_was_told_is_taken_for_a_collision() {
    for plant in PLANTS {
        let mut config = with("cs66", plant);
        config.truth.payload = Some(payload(6.0));
        config.payload = payload(6.0);
        let mut bench = Bench::new(config);
        bench.do_it(SensingCommand::SetCollisionSensitivity(100));
        bench.run(100);
        assert!(bench.stops.is_empty(), "{plant:?} {:?}", bench.stops);
        bench.do_it(SettingCommand::SetPayload(Payload::NONE));
        bench.run(100);
        assert!(
            matches!(bench.stops[..], [StopReason::Collision { .. }]),
            "{plant:?} {:?}",
            bench.stops
        );
    }
}

/// Moves every joint by an angle and back; how far the arm ever was off its targets, rad.
fn there_and_back(bench: &mut Bench, home: JointPositions, by: f64) -> f64 {
    for way in [by, 0.0] {
        let target = JointPositions(home.0.map(|q| q + way));
        let outcome = bench.do_it(movej(target));
        assert_eq!(outcome, Outcome::Done, "{:?}", bench.stops);
    }
    bench.states.iter().map(off).fold(0.0, f64::max)
}

#[test]
fn wrong_payloads_leave_the_arm_close_to_its_targets_on_every_model() {
    for model in MODELS {
        let rated = RobotModel::built_in(model)
            .unwrap()
            .rated_payload_kg()
            .unwrap();
        for (real, told) in [(rated, 0.0), (0.0, rated)] {
            let mut config = with(model, PlantKind::Rigid);
            config.truth.payload = Some(payload(real));
            config.payload = payload(told);
            let home = config.home;
            let mut bench = Bench::new(config);
            bench.do_it(SensingCommand::SetCollisionDetection(false));
            let most = there_and_back(&mut bench, home, 0.7);
            println!("{model} carries {real} kg, told {told}: {most:.1e} rad off");
            assert!(most < 0.01, "{model} {most}");
        }
    }
}

#[test]
fn friction_and_rotors_show_in_the_torques_and_the_arm_follows_all_the_same() {
    for model in MODELS {
        for plant in [PlantKind::Rigid, PlantKind::Ideal] {
            let whole = losses(model);
            let effort = RobotModel::built_in(model).unwrap().limits().effort;
            let none = Drivetrain::default();
            for drivetrain in [
                whole,
                Drivetrain {
                    coulomb: whole.coulomb,
                    ..none
                },
                Drivetrain {
                    viscous: whole.viscous,
                    ..none
                },
                Drivetrain {
                    rotor_inertia: whole.rotor_inertia,
                    ..none
                },
            ] {
                let mut config = with(model, plant);
                config.truth.drivetrain = drivetrain;
                let home = config.home;
                let mut bench = Bench::new(config);
                bench.do_it(SensingCommand::SetCollisionDetection(false));
                let most = there_and_back(&mut bench, home, 0.9);
                println!("{model} {plant:?}: {most:.1e} rad off");
                assert!(most < 0.02, "{model} {plant:?} {drivetrain:?} {most}");
                // Where the joints turn evenly, what the drives give beyond the model is what they have to overcome.
                let mut seen = 0;
                for state in &bench.states {
                    for joint in 0..6 {
                        let qd = state.target_qd[joint];
                        if state.target_qdd.max_abs() > 1e-6 || qd.abs() < 0.5 {
                            continue;
                        }
                        let beyond = state.actual_torque[joint] - state.target_torque[joint];
                        let wanted =
                            drivetrain.coulomb[joint].copysign(qd) + drivetrain.viscous[joint] * qd;
                        let nominal = effort[joint];
                        assert!(
                            (beyond - wanted).abs() < 0.002 * nominal + 0.05 * wanted.abs(),
                            "{model} {plant:?} joint {joint}: {beyond} {wanted}"
                        );
                        seen += 1;
                    }
                }
                assert!(seen > 100, "{seen}");
            }
        }
    }
}

#[test]
fn dry_friction_holds_a_standing_arm_without_a_tremble() {
    let mut config = with("cs66", PlantKind::Rigid);
    config.truth.drivetrain = losses("cs66");
    let home = config.home;
    let mut bench = Bench::new(config);
    bench.do_it(movej(JointPositions(home.0.map(|q| q + 0.3))));
    bench.run(250);
    let tail = &bench.states[bench.states.len() - 200..];
    let fastest = tail
        .iter()
        .map(|s| s.actual_qd.max_abs())
        .fold(0.0, f64::max);
    assert!(fastest < 1e-3, "{fastest}");
    assert!(off(&bench.now()) < 5e-3, "{}", off(&bench.now()));
    assert!(bench.stops.is_empty());
}

#[test]
fn friction_takes_part_in_a_contact_that_comes_to_rest() {
    use motion::contact::{Obstacle, PlacedShape, Shape};
    let mut config = with("cs66", PlantKind::Rigid);
    config.tcp = RpyPose::from_array([0.0, 0.0, 0.1, 0.0, 0.0, 0.0]);
    config.truth.drivetrain = losses("cs66");
    let [_, _, z] = config.first_state().actual_tcp_pose.xyz;
    config.surroundings.obstacles = vec![Obstacle {
        name: "plate".to_owned(),
        solid: PlacedShape {
            pose: Pose::from_translation(0.0, 0.0, z - 0.01),
            shape: Shape::Plane,
        },
        body: None,
        stiffness: Some(2e4),
        damping: 0.0,
        friction: 0.2,
    }];
    let mut bench = Bench::new(config);
    let mut target = bench.now().target_tcp_pose;
    target.xyz[2] -= 0.0115;
    assert_eq!(bench.do_it(common::movel(target)), Outcome::Done);
    bench.run(250);
    assert!(bench.stops.is_empty(), "{:?}", bench.stops);
    let state = bench.now();
    let depth = (z - 0.01) - state.actual_tcp_pose.xyz[2];
    assert!(
        (force(&state).z / (2e4 * depth) - 1.0).abs() < 0.01,
        "{} {depth}",
        force(&state)
    );
    assert!(state.actual_qd.max_abs() < 1e-3);
}

#[test]
fn a_push_in_the_first_cycle_is_felt_as_an_error_and_stops_nothing() {
    for plant in [PlantKind::Rigid, PlantKind::Rapier] {
        for model in MODELS {
            for frame in [WrenchFrame::Base, WrenchFrame::Tool] {
                for axis in 0..3 {
                    let mut config = with(model, plant);
                    config.tcp = RpyPose::from_array([0.02, 0.03, 0.12, 0.0, 0.0, 0.0]);
                    let mut wrench = [0.0; 6];
                    wrench[axis] = 20.0;
                    config.loads = vec![TimedWrench {
                        at: 0.0,
                        duration: 1.0,
                        wrench: Wrench::from_array(wrench),
                        frame,
                    }];
                    let mut bench = Bench::new(config);
                    bench.run(200);
                    let place = format!("{plant:?} {model} {frame:?} {axis}");
                    assert!(bench.stops.is_empty(), "{place}: {:?}", bench.stops);
                    let most = bench.states.iter().map(off).fold(0.0, f64::max);
                    println!("{place}: {most:.1e}, then {:.1e}", off(&bench.now()));
                    assert!(most > 1e-6 && most < 0.02, "{place}: {most}");
                    // A part of it stays as long as the push does, and goes with it.
                    assert!(off(&bench.now()) > 2e-7, "{place}");
                    bench.run(250);
                    assert!(off(&bench.now()) < 1e-6, "{place}: {}", off(&bench.now()));
                }
            }
        }
    }
}

#[test]
fn the_engine_of_others_agrees_with_our_own_equations() {
    use motion::contact::{Obstacle, PlacedShape, Shape};
    let run = |plant| {
        let mut config = with("cs612", plant);
        config.truth.payload = Some(payload(5.0));
        config.payload = payload(4.0);
        let [_, _, z] = config.first_state().actual_tcp_pose.xyz;
        config.surroundings.obstacles = vec![Obstacle {
            name: "plate".to_owned(),
            solid: PlacedShape {
                pose: Pose::from_translation(0.0, 0.0, z - 0.05),
                shape: Shape::Plane,
            },
            body: None,
            stiffness: Some(1e4),
            damping: 20.0,
            friction: 0.3,
        }];
        config.loads = vec![TimedWrench {
            at: 0.3,
            duration: 0.4,
            wrench: Wrench::from_array([10.0, -15.0, 5.0, 1.0, 0.0, 0.5]),
            frame: WrenchFrame::Base,
        }];
        let home = config.home;
        let mut bench = Bench::new(config);
        bench.do_it(SensingCommand::SetCollisionDetection(false));
        let mut low = bench.now().target_tcp_pose;
        low.xyz[2] -= 0.053;
        bench.do_it(common::movel(low));
        bench.do_it(movej(home));
        let mut aside = home;
        aside[0] += 0.8;
        aside[5] -= 0.6;
        bench.do_it(movej(aside));
        bench.states
    };
    let (own, judge) = (run(PlantKind::Rigid), run(PlantKind::Rapier));
    assert_eq!(own.len(), judge.len());
    let mut apart = 0.0_f64;
    for (a, b) in own.iter().zip(&judge) {
        for joint in 0..6 {
            apart = apart.max((a.actual_q[joint] - b.actual_q[joint]).abs());
        }
    }
    println!("the plants differ by {apart:.1e} rad at most");
    assert!(apart < 2e-6, "{apart}");
}

#[test]
fn without_a_truth_of_its_own_nothing_differs() {
    // The same payload as truth and as belief: told twice, the arm is the same but for rounding.
    let run = |truth: Option<Payload>| {
        let mut config = with("cs66", PlantKind::Rigid);
        config.payload = payload(2.0);
        config.truth = PlantParameters {
            payload: truth,
            ..PlantParameters::default()
        };
        let home = config.home;
        let mut bench = Bench::new(config);
        bench.do_it(movej(JointPositions(home.0.map(|q| q + 0.6))));
        bench.states
    };
    for (a, b) in run(None).iter().zip(&run(Some(payload(2.0)))) {
        for joint in 0..6 {
            assert!((a.actual_q[joint] - b.actual_q[joint]).abs() < 1e-10);
            assert!((a.actual_torque[joint] - b.actual_torque[joint]).abs() < 1e-6);
        }
    }
}

#[test]
fn rapier_refuses_what_it_does_not_know() {
    let mut config = with("cs66", PlantKind::Rapier);
    config.truth.drivetrain.coulomb = JointTorques([1.0; 6]);
    let (motion, _script) =
        motion_api::motion_channel(motion_api::RingCapacities::default(), &config.first_state());
    let error = motion::ControlLoop::new(config, motion)
        .map(|_| ())
        .unwrap_err();
    assert!(matches!(error, ConfigError::Plant { .. }));
    assert!(error.to_string().contains("rapier") && error.to_string().contains("[arm]"));
}
