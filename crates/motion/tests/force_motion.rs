//! Force mode under a motion: lines, slopes, facets and arches are followed while the tool presses; frames that follow
//! a point or the motion.
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
use common::{Bench, ideal, movel};
use kinematics::{JointSpeeds, Pose, RpyPose};
use motion::CycleConfig;
use motion::contact::Shape;
use motion_api::{MotionCommand, Outcome, OverlayCommand};
use nalgebra::Vector3;

#[test]
fn a_line_is_followed_while_the_tool_presses() {
    let mut bench = Bench::new(over_plate(rigid("cs66"), 1e-3, 2e4, 10.0_f64.to_radians()));
    let start = bench.now().actual_tcp_pose;
    bench.send(down(20.0, 0.1));
    for _ in 0..200 {
        press(&mut bench);
    }
    let goal = RpyPose {
        xyz: [start.xyz[0] + 0.05, start.xyz[1] + 0.1, start.xyz[2] + 0.3],
        ..start
    };
    let line = bench.send(MotionCommand::MoveL {
        target: goal,
        acceleration: 0.3,
        speed: 0.05,
        duration: 0.0,
        radius: 0.0,
    });
    let mut squares = (0.0, 0);
    let direction = Vector3::new(0.05, 0.1, 0.0).normalize();
    while bench.outcome(line).is_none() {
        let force = press(&mut bench);
        // The z component is what is controlled.
        squares.0 += (force / 20.0 - 1.0).powi(2);
        squares.1 += 1;
        let state = bench.now();
        assert!(bench.stops.is_empty(), "{:?}", bench.stops);
        let way = Vector3::from(state.target_tcp_pose.xyz) - Vector3::from(start.xyz);
        let flat = Vector3::new(way.x, way.y, 0.0);
        let beside = (flat - direction * flat.dot(&direction)).norm();
        assert!(beside < 1e-4, "{beside}");
    }
    let rms = (squares.0 / f64::from(squares.1)).sqrt();
    println!("rms {rms:.4} of the target over {} cycles", squares.1);
    assert_eq!(bench.outcome(line), Some(Outcome::Done));
    assert!(rms < 0.1);
    let end = bench.now().target_tcp_pose;
    assert!((end.xyz[0] - goal.xyz[0]).abs() < 1e-5 && (end.xyz[1] - goal.xyz[1]).abs() < 1e-5);
    assert!((end.xyz[2] - goal.xyz[2]).abs() > 0.1);
    bench.check_limits();
    // The next motion begins where the arm is.
    for _ in 0..50 {
        press(&mut bench);
    }
    assert_eq!(bench.do_it(OverlayCommand::EndForceMode), Outcome::Done);
    assert!(!bench.now().force_mode);
    assert_eq!(bench.now().target_qd, JointSpeeds::ZERO);
    assert_eq!(bench.do_it(movel(start)), Outcome::Done);
    bench.check_limits();
}

/// Presses 20 N and slides along y there and back at 50 mm/s; rms of the deviation over the target.
fn rms_there_and_back(config: CycleConfig) -> f64 {
    let mut bench = Bench::new(config);
    bench.send(down(20.0, 0.1));
    for _ in 0..300 {
        press(&mut bench);
    }
    let start = bench.now().actual_tcp_pose;
    let mut squares = (0.0, 0);
    for way in [0.1, -0.1, 0.0] {
        let line = bench.send(MotionCommand::MoveL {
            target: RpyPose {
                xyz: [start.xyz[0], start.xyz[1] + way, start.xyz[2]],
                ..start
            },
            acceleration: 0.5,
            speed: 0.05,
            duration: 0.0,
            radius: 0.0,
        });
        while bench.outcome(line).is_none() {
            squares.0 += (press(&mut bench) / 20.0 - 1.0).powi(2);
            squares.1 += 1;
        }
        assert_eq!(
            bench.outcome(line),
            Some(Outcome::Done),
            "{:?}",
            bench.stops
        );
    }
    bench.check_limits();
    (squares.0 / f64::from(squares.1)).sqrt()
}

#[test]
fn tilted_and_faceted_surfaces_are_followed_there_and_back() {
    for stiffness in [1e4, 5e4] {
        let mut tilted = over_plate(rigid("cs66"), 3e-3, stiffness, 0.0);
        let level = tilted.surroundings.obstacles[0].clone();
        let pose = level.solid.pose;
        let turned = |angle: f64, way: f64| {
            let mut obstacle = level.clone();
            obstacle.solid.pose = pose
                * Pose::from_translation(0.0, way, 0.0)
                * Pose::from_rpy(&RpyPose::from_array([0.0, 0.0, 0.0, angle, 0.0, 0.0]));
            obstacle
        };
        tilted.surroundings.obstacles = vec![turned(10.0_f64.to_radians(), 0.0)];
        let on_ramp = rms_there_and_back(tilted.clone());
        // A valley of planes that touch a circle of 0.4 m every 0.1 rad.
        let mut faceted = tilted;
        faceted.surroundings.obstacles = (-4_i32..=4)
            .map(|k| {
                let angle = 0.1 * f64::from(k);
                let mut facet = turned(angle, 0.4 * angle.sin());
                facet.solid.pose.translation.z += 0.4 * (1.0 - angle.cos());
                facet
            })
            .collect();
        let on_facets = rms_there_and_back(faceted);
        println!("{stiffness} N/m: rms {on_ramp:.4} on the ramp, {on_facets:.4} on facets");
        assert!(on_ramp < 0.1 && on_facets < 0.1, "{on_ramp} {on_facets}");
    }
}

#[test]
fn an_arch_of_boxes_carries_the_tool_across_its_joints() {
    for stiffness in [1e3, 1e4, 5e4] {
        let mut config = over_plate(rigid("cs66"), 3e-3, stiffness, 0.0);
        let level = config.surroundings.obstacles[0].clone();
        // Faces of 30 mm on a circle of 0.5 m, whose bodies overlap below their joints.
        let (radius, half) = (0.5_f64, [0.15, 0.015, 0.02]);
        let per_face = 2.0 * f64::asin(half[1] / radius);
        config.surroundings.obstacles = (-5_i32..=5)
            .map(|k| {
                let angle = per_face * f64::from(k);
                let (sin, cos) = angle.sin_cos();
                let middle = radius * (per_face / 2.0).cos() - half[2];
                let mut face = level.clone();
                face.solid.shape = Shape::Box { half };
                face.solid.pose = level.solid.pose
                    * Pose::from_translation(0.0, middle * sin, middle * cos - radius)
                    * Pose::from_rpy(&RpyPose::from_array([0.0, 0.0, 0.0, -angle, 0.0, 0.0]));
                face
            })
            .collect();
        let rms = rms_there_and_back(config);
        println!("{stiffness} N/m: rms {rms:.4} on an arch of boxes");
        assert!(rms < 0.1, "{stiffness}: {rms}");
    }
}

/// Where the TCP has gone to after some cycles of force mode without touch, base frame.
fn gone(bench: &mut Bench, frame: [f64; 6], selection: [u8; 6], mode: u8) -> Vector3<f64> {
    let start = bench.now().target_tcp_pose;
    bench.send(OverlayCommand::ForceMode {
        frame: RpyPose::from_array(frame),
        selection: selection.map(|x| x == 1),
        wrench: [0.0, 10.0, 0.0, 0.0, 0.0, 0.0],
        mode,
        speed_limits: [0.05; 6],
    });
    for _ in 0..150 {
        press(bench);
    }
    Vector3::from(bench.now().target_tcp_pose.xyz) - Vector3::from(start.xyz)
}

#[test]
fn in_point_mode_the_force_leads_to_the_point() {
    let mut bench = Bench::new(ideal("cs66"));
    let [x, y, z] = bench.now().target_tcp_pose.xyz;
    let point = Vector3::new(0.3, 0.4, -0.1);
    let frame = [x + point.x, y + point.y, z + point.z, 0.0, 0.0, 0.0];
    let way = gone(&mut bench, frame, [0, 1, 0, 0, 0, 0], 1);
    assert!(way.norm() > 1e-3, "{way}");
    assert!(way.angle(&point) < 1e-3, "{way}");
    bench.check_limits();
}

#[test]
fn in_motion_mode_the_force_stands_across_the_motion() {
    let mut bench = Bench::new(ideal("cs66"));
    let start = bench.now().target_tcp_pose;
    let mut goal = start;
    goal.xyz[1] += 0.1;
    bench.send(MotionCommand::MoveL {
        target: goal,
        acceleration: 0.5,
        speed: 0.05,
        duration: 0.0,
        radius: 0.0,
    });
    for _ in 0..50 {
        press(&mut bench);
    }
    // X points along the motion, the base's y; so Y points against the base's x.
    let way = gone(&mut bench, [0.0; 6], [0, 1, 0, 0, 0, 0], 2);
    assert!(way.x < -1e-3, "{way}");
    assert!(way.z.abs() < 1e-4, "{way}");
    assert!(way.y > 0.02, "the motion goes on: {way}");
    bench.check_limits();
}
