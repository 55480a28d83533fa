//! Cells for tests, made from random numbers.

use kinematics::{JointPositions, Pose, RobotModel, RpyPose};
use path_planning::{CollisionScene, ObstaclePlace, PlacedShape, Shape};
use proptest::prelude::*;

/// Joint positions anywhere in half a turn.
pub fn joints() -> impl Strategy<Value = JointPositions> {
    prop::array::uniform6(-3.1..3.1_f64).prop_map(JointPositions)
}

/// A pose around the arm.
pub fn pose() -> impl Strategy<Value = Pose> {
    let xyz = prop::array::uniform3(-0.8..0.8_f64);
    (xyz, prop::array::uniform3(-3.0..3.0_f64))
        .prop_map(|(xyz, rpy)| Pose::from_rpy(&RpyPose { xyz, rpy }))
}

fn shape() -> impl Strategy<Value = Shape> {
    prop_oneof![
        prop::array::uniform3(0.02..0.2_f64).prop_map(|half| Shape::Box { half }),
        (0.02..0.15_f64, 0.02..0.4_f64).prop_map(|(radius, half_length)| Shape::Cylinder {
            radius,
            half_length
        }),
        (0.02..0.2_f64).prop_map(|radius| Shape::Sphere { radius }),
    ]
}

/// An arm with a tool, and some obstacles around it.
pub fn scene() -> impl Strategy<Value = CollisionScene> {
    let obstacles = prop::collection::vec((shape(), pose()), 1..6);
    (obstacles, prop::option::of(shape()), prop::bool::ANY).prop_map(
        |(obstacles, tool, has_table)| {
            let arm = RobotModel::built_in("cs66").unwrap();
            let tool = tool.map(|shape| PlacedShape {
                pose: Pose::from_translation(0.0, 0.0, 0.05),
                shape,
            });
            let tcp = Pose::from_translation(0.0, 0.0, 0.1);
            let mut scene = CollisionScene::new(arm, tool, tcp);
            for (number, (shape, pose)) in obstacles.into_iter().enumerate() {
                let pieces = vec![PlacedShape::centred(shape)];
                let place = ObstaclePlace::Standing(pose);
                scene.add_obstacle(format!("block {number}"), pieces, place);
            }
            if has_table {
                let table = vec![PlacedShape::centred(Shape::Plane)];
                let below = Pose::from_translation(0.0, 0.0, -0.1);
                scene.add_obstacle("table", table, ObstaclePlace::Standing(below));
            }
            scene
        },
    )
}
