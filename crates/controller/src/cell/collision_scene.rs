//! The cell as distances are measured in it.

use kinematics::{Pose, RobotModel, RpyPose};
use path_planning::{CollisionScene, ObstaclePlace, PlacedShape, Shape, TouchRule};

use super::Cell;
use super::schema::{ShapeName, SixNumbers, Size};

impl Cell {
    /// The arm among `[[obstacle]]`, with `[tool]` and the pairs of `[[touch]]`.
    pub fn collision_scene(&self, model: RobotModel, flange_from_tcp: Pose) -> CollisionScene {
        let tables = self.tables();
        let tool = tables.tool.as_ref().and_then(|tool| {
            Some(PlacedShape {
                pose: pose(tool.pose),
                shape: shape(tool.shape, &tool.size)?,
            })
        });
        let mut scene = CollisionScene::new(model, tool, flange_from_tcp);
        for obstacle in &tables.obstacle {
            let Some(shape) = shape(obstacle.shape, &obstacle.size) else {
                continue;
            };
            let pieces = vec![PlacedShape::centred(shape)];
            let place = ObstaclePlace::Standing(pose(obstacle.pose));
            scene.add_obstacle(obstacle.name.clone(), pieces, place);
        }
        scene.allow_touches(tables.touch.iter().map(|touch| TouchRule {
            a: touch.a.clone(),
            b: touch.b.clone(),
        }));
        scene
    }
}

fn pose(numbers: SixNumbers) -> Pose {
    Pose::from_rpy(&RpyPose::from_array(numbers))
}

/// The file was checked: the size has as many numbers as the shape needs.
fn shape(name: ShapeName, size: &Size) -> Option<Shape> {
    match (name, size.numbers()) {
        (ShapeName::Box, &[x, y, z]) => Some(Shape::Box {
            half: [x / 2.0, y / 2.0, z / 2.0],
        }),
        (ShapeName::Cylinder, &[radius, length]) => Some(Shape::Cylinder {
            radius,
            half_length: length / 2.0,
        }),
        (ShapeName::Sphere, &[radius]) => Some(Shape::Sphere { radius }),
        (ShapeName::Plane, _) => Some(Shape::Plane),
        _ => None,
    }
}
