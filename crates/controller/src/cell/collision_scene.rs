//! The cell as distances are measured in it.

use kinematics::dynamics::GRAVITY_UPRIGHT;
use kinematics::{Pose, RobotModel};
use path_planning::{CollisionScene, ObstaclePlace, TouchRule};
use world::World;
use world::description::BodyShape;

use super::Cell;
use super::convert::pose_of;
use super::shape::{ShapeKeys, distance_pieces};
use super::world::WorldSettings;

impl Cell {
    /// The arm among `[[obstacle]]`, with `[tool]` and the pairs of `[[touch]]`.
    pub fn collision_scene(&self, model: RobotModel, flange_from_tcp: Pose) -> CollisionScene {
        let tables = self.tables();
        let pieces = |keys: &ShapeKeys<'_>, pose: Pose| {
            let solid = keys.solid(self.meshes());
            solid.map_or_else(Vec::new, |solid| distance_pieces(&solid, pose))
        };
        let tool = tables.tool.as_ref();
        let tool = tool.map(|tool| pieces(&tool.shape_keys(), pose_of(&tool.pose)));
        let mut scene = CollisionScene::new(model, tool.unwrap_or_default(), flange_from_tcp);
        for obstacle in &tables.obstacle {
            let place = ObstaclePlace::Standing(pose_of(&obstacle.pose));
            let pieces = pieces(&obstacle.shape_keys(), Pose::IDENTITY);
            scene.add_obstacle(obstacle.name.clone(), pieces, place);
        }
        for (name, solid, pose) in self.world_solids() {
            let pieces = distance_pieces(&solid, Pose::IDENTITY);
            scene.add_obstacle(name, pieces, ObstaclePlace::Standing(pose));
        }
        for (name, solid, pose) in self.parts_at_start(scene.model()) {
            let pieces = distance_pieces(&solid, Pose::IDENTITY);
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
    fn parts_at_start(&self, model: &RobotModel) -> Vec<(String, BodyShape, Pose)> {
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
                Some((part.name.to_string(), template.shape.clone(), part.pose))
            })
            .collect()
    }
}
