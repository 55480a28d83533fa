//! The arm among obstacles: forces, rest, friction, links, determinism.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]

mod common;

use common::{Bench, ideal, movel};
use kinematics::{JointPositions, Pose, RobotModel, RpyPose};
use motion::contact::{HARD, Obstacle, Shape, Solid, Surroundings};
use motion::{CycleConfig, PlantKind};
use motion_api::{CommandKind, Outcome, StopReason};
use nalgebra::Vector3;

const HOME: JointPositions = JointPositions([0.0, -1.571, 1.571, -1.571, -1.571, 0.0]);

fn rigid() -> CycleConfig {
    CycleConfig {
        home: HOME,
        tcp: RpyPose::from_array([0.0, 0.0, 0.1, 0.0, 0.0, 0.0]),
        ..CycleConfig::new(RobotModel::built_in("cs66").unwrap())
    }
}

/// Where the TCP stands at home.
fn tcp_at_home(config: &CycleConfig) -> RpyPose {
    config.first_state().actual_tcp_pose
}

fn obstacle(shape: Shape, pose: Pose, stiffness: Option<f64>) -> Obstacle {
    Obstacle {
        name: "plate".to_owned(),
        solid: Solid { pose, shape },
        stiffness,
        damping: 0.0,
        friction: 0.0,
    }
}

/// A plate under the TCP at home, its surface `gap` below.
fn plate(config: &CycleConfig, gap: f64, stiffness: Option<f64>) -> Obstacle {
    let z = tcp_at_home(config).xyz[2] - gap;
    obstacle(Shape::Plane, Pose::from_translation(0.0, 0.0, z), stiffness)
}

fn among(mut config: CycleConfig, obstacles: Vec<Obstacle>) -> CycleConfig {
    config.surroundings.obstacles = obstacles;
    config
}

/// Goes down by `way` from where the TCP is.
fn down(bench: &mut Bench, way: f64, speed: f64) -> Outcome {
    let mut target = bench.now().target_tcp_pose;
    target.xyz[2] -= way;
    bench.do_it(CommandKind::MoveL {
        target,
        acceleration: 1.2,
        speed,
        duration: 0.0,
        radius: 0.0,
    })
}

/// Depth of the TCP in a plate whose surface is at `surface`, m.
fn depth(bench: &Bench, surface: f64) -> f64 {
    surface - bench.now().actual_tcp_pose.xyz[2]
}

/// The force on the tool in base axes.
fn force(bench: &Bench) -> Vector3<f64> {
    let state = bench.now();
    let w = state.tcp_force;
    Pose::from_rpy(&state.actual_tcp_pose).rotate(Vector3::new(w[0], w[1], w[2]))
}

#[test]
fn a_plate_pushes_back_with_its_stiffness_times_the_depth() {
    for plant in [PlantKind::Rigid, PlantKind::Ideal] {
        for step_time in [0.001, 0.004] {
            for stiffness in [1e3, 1e4, 1e5, 1e6] {
                let config = CycleConfig {
                    plant,
                    step_time,
                    ..rigid()
                };
                let surface = tcp_at_home(&config).xyz[2] - 0.01;
                let plate = plate(&config, 0.01, Some(stiffness));
                let mut bench = Bench::new(among(config, vec![plate]));
                // 20 N at the end.
                let press = 20.0 / stiffness;
                assert_eq!(down(&mut bench, 0.01 + press, 0.05), Outcome::Done);
                bench.run((0.5 / step_time) as usize);
                assert!(bench.stops.is_empty(), "{:?}", bench.stops);
                let (f, d) = (force(&bench), depth(&bench, surface));
                let place = format!("{plant:?} {step_time} {stiffness}: {f:?} at {d}");
                assert!((f.z / (stiffness * d) - 1.0).abs() < 1e-6, "{place}");
                assert!((f.z - 20.0).abs() < 0.2, "{place}");
                assert!(f.x.abs() < 1e-6 && f.y.abs() < 1e-6, "{place}");
            }
        }
    }
}
