//! The cell as distances are measured in it.

use kinematics::dynamics::GRAVITY_UPRIGHT;
use kinematics::{Pose, RobotModel, RpyPose};
use motion::contact;
use path_planning::{CollisionScene, ObstaclePlace, PlacedShape, Shape, TouchRule};
use world::World;
use world::description::BodyShape;

use super::Cell;
use super::schema::{ShapeName, SixNumbers, Size};
use super::world::WorldSettings;

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
        for obstacle in self.world_obstacles() {
            let pieces = vec![PlacedShape::centred(shape_in_contact(obstacle.solid.shape))];
            let place = ObstaclePlace::Standing(obstacle.solid.pose);
            scene.add_obstacle(obstacle.name, pieces, place);
        }
        for (name, shape, pose) in self.parts_at_start(scene.model()) {
            let pieces = vec![PlacedShape::centred(shape)];
            scene.add_obstacle(name, pieces, ObstaclePlace::Standing(pose));
        }
        scene.allow_touches(tables.touch.iter().map(|touch| TouchRule {
            a: touch.a.clone(),
            b: touch.b.clone(),
        }));
        scene
    }
}

impl Cell {
    /// The parts that are there before the first cycle.
    fn parts_at_start(&self, model: &RobotModel) -> Vec<(String, Shape, Pose)> {
        let settings = WorldSettings {
            model,
            step_time: 0.004,
            gravity: GRAVITY_UPRIGHT,
            seed: 0,
        };
        // A world that cannot be is told by the start of the controller.
        let Some((description, world)) = self
            .world(&settings)
            .and_then(|description| Some((World::new(&description).ok()?, description)))
            .map(|(world, description)| (description, world))
        else {
            return Vec::new();
        };
        let parts = world.state().parts.iter();
        parts
            .filter_map(|part| {
                let template = description.parts.get(part.template)?;
                Some((
                    part.name.to_string(),
                    shape_of_body(&template.shape),
                    part.pose,
                ))
            })
            .collect()
    }
}

/// The shape of a body of the world.
pub(crate) const fn shape_of_body(body: &BodyShape) -> Shape {
    match *body {
        BodyShape::Box { size: [x, y, z] } => Shape::Box {
            half: [x / 2.0, y / 2.0, z / 2.0],
        },
        BodyShape::Cylinder { radius, length } => Shape::Cylinder {
            radius,
            half_length: length / 2.0,
        },
        BodyShape::Sphere { radius } => Shape::Sphere { radius },
        BodyShape::Plane => Shape::Plane,
    }
}

const fn shape_in_contact(shape: contact::Shape) -> Shape {
    match shape {
        contact::Shape::Box { half } => Shape::Box { half },
        contact::Shape::Cylinder {
            radius,
            half_length,
        } => Shape::Cylinder {
            radius,
            half_length,
        },
        contact::Shape::Sphere { radius } => Shape::Sphere { radius },
        contact::Shape::Plane => Shape::Plane,
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
