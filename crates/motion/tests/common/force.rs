//! A bench over a plate, in force mode.

use kinematics::{Pose, RobotModel, RpyPose};
use motion::CycleConfig;
use motion::contact::{Obstacle, PlacedShape, Shape};
use motion_api::{CommandKind, Outcome, OverlayCommand, SensingCommand};
use nalgebra::Vector3;

use super::Bench;

pub fn rigid(model: &str) -> CycleConfig {
    CycleConfig::new(RobotModel::built_in(model).unwrap())
}

/// A level plate `gap` m below the TCP, or one tilted by `tilt` about y; the sensor sees it push back with `stiffness`
/// N/m.
pub fn over_plate(config: CycleConfig, gap: f64, stiffness: f64, tilt: f64) -> CycleConfig {
    let mut config = config;
    // The plate is touched by the tool, not by the wrist.
    config.tcp = RpyPose::from_array([0.0, 0.0, 0.2, 0.0, 0.0, 0.0]);
    let [x, y, z] = config.first_state().actual_tcp_pose.xyz;
    let pose = Pose::from_rpy(&RpyPose::from_array([x, y, z - gap, 0.0, -tilt, 0.0]));
    config.surroundings.obstacles.push(Obstacle {
        name: "plate".to_owned(),
        solid: PlacedShape {
            pose,
            shape: Shape::Plane,
        },
        body: None,
        stiffness: Some(stiffness),
        damping: 0.0,
        friction: 0.0,
    });
    config
}

/// One cycle; what the tool applies downwards, N.
pub fn press(bench: &mut Bench) -> f64 {
    let state = bench.tick();
    let w = state.tcp_force;
    let force = Pose::from_rpy(&state.actual_tcp_pose).rotate(Vector3::new(w[0], w[1], w[2]));
    force.z
}

/// A bench on which wrenches from the port count.
pub fn with_hand(config: CycleConfig) -> Bench {
    let mut bench = Bench::new(config);
    let input = CommandKind::Sensing(SensingCommand::FtRtsiInput {
        enabled: true,
        mass: 0.0,
        measuring_offset: [0.0; 3],
        cog: [0.0; 3],
    });
    assert_eq!(bench.do_it(input), Outcome::Done);
    bench
}

pub fn force_mode(selection: [u8; 6], wrench: [f64; 6], speed_limits: [f64; 6]) -> CommandKind {
    CommandKind::Overlay(OverlayCommand::ForceMode {
        frame: RpyPose::default(),
        selection: selection.map(|x| x == 1),
        wrench,
        mode: 0,
        speed_limits,
    })
}

/// Downwards along the base's z axis.
pub fn down(force: f64, speed: f64) -> CommandKind {
    force_mode(
        [0, 0, 1, 0, 0, 0],
        [0.0, 0.0, -force, 0.0, 0.0, 0.0],
        [0.0, 0.0, speed, 0.0, 0.0, 0.0],
    )
}

pub fn push(wrench: [f64; 6]) -> CommandKind {
    CommandKind::Sensing(SensingCommand::SetExternalWrench(wrench))
}

/// Largest distance in the plane and largest angle from a pose.
pub fn off(state: &RpyPose, from: &RpyPose) -> (f64, f64) {
    let (a, b) = (Pose::from_rpy(state), Pose::from_rpy(from));
    let way = a.translation - b.translation;
    (way.x.hypot(way.y), a.rotation.angle_to(&b.rotation))
}
