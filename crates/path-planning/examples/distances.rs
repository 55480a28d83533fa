//! Distances for comparison with other programs: cells and joint positions in, the nearest pair of each out.
//!
//! Standard input has one line a case: obstacles separated by `;`, each `name shape size… x y z Rx Ry Rz`, then `|` and
//! six joint positions. Every answer is `distance a b`. The tool is a cylinder of 35 mm by 120 mm on the flange.

#![allow(
    clippy::expect_used,
    reason = "an example ends with what is wrong with its input"
)]

use std::io::BufRead;

use kinematics::{JointPositions, Pose, RobotModel, RpyPose};
use nalgebra::Vector3;
use path_planning::{CollisionScene, ObstaclePlace, PlacedShape, Shape};

fn main() {
    let arm = RobotModel::built_in("cs66").expect("a built-in arm");
    let mut known = (String::new(), None);
    for line in std::io::stdin().lock().lines() {
        let line = line.expect("text");
        let (cell, joints) = line.split_once('|').expect("a cell and joints");
        if known.0 != cell || known.1.is_none() {
            known = (cell.to_owned(), Some(scene(&arm, cell)));
        }
        let scene = known.1.as_ref().expect("made above");
        let numbers = joints.split_whitespace();
        let q: Vec<f64> = numbers.map(|x| x.parse().expect("a number")).collect();
        let q = JointPositions(q.try_into().expect("six joints"));
        let nearest = scene.nearest(&q).expect("there are pairs");
        let (a, b) = scene.names(nearest.pair);
        println!("{} {a} {}", nearest.distance, b.replace(' ', "_"));
    }
}

fn scene(arm: &RobotModel, text: &str) -> CollisionScene {
    let tool = PlacedShape {
        pose: Pose::from_translation(0.0, 0.0, 0.06),
        shape: Shape::Cylinder {
            radius: 0.035,
            half_length: 0.06,
        },
    };
    let mut scene = CollisionScene::new(arm.clone(), Some(tool), Pose::IDENTITY);
    for obstacle in text.split(';').filter(|text| !text.trim().is_empty()) {
        let mut words = obstacle.split_whitespace();
        let name = words.next().expect("a name");
        let kind = words.next().expect("a shape");
        let numbers: Vec<f64> = words.map(|x| x.parse().expect("a number")).collect();
        let (size, pose) = numbers.split_at(numbers.len() - 6);
        let shape = match (kind, size) {
            ("box", &[x, y, z]) => Shape::Box {
                half: [x / 2.0, y / 2.0, z / 2.0],
            },
            ("cylinder", &[radius, length]) => Shape::Cylinder {
                radius,
                half_length: length / 2.0,
            },
            ("sphere", &[radius]) => Shape::Sphere { radius },
            // Corners of a convex piece of a mesh, in its frame.
            ("hull", corners) => {
                let corners = corners.chunks_exact(3);
                let corners = corners.map(|p| Vector3::new(p[0], p[1], p[2]));
                Shape::Hull(corners.collect())
            }
            other => panic!("no such shape: {other:?}"),
        };
        let pose: [f64; 6] = pose.try_into().expect("a pose");
        let pose = Pose::from_rpy(&RpyPose::from_array(pose));
        let pieces = vec![PlacedShape::centred(shape)];
        let place = ObstaclePlace::Standing(pose);
        scene.add_obstacle(name.replace('_', " "), pieces, place);
    }
    scene
}
