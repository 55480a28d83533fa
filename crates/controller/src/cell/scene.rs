//! What viewers draw of the cell.

use kinematics::{RobotModel, RpyPose};
use nalgebra::Vector3;
use recorder::SceneObstacle;

use super::Cell;
use super::point::{IoDirection, IoGroup, IoPointName};
use super::shape::drawn_shape;
use super::world::WorldSettings;

impl Cell {
    /// Shapes and places of parts and of what handles them; period, gravity and seed are those of no run.
    pub fn drawn_world(&self, model: &RobotModel) -> Option<::world::WorldDescription> {
        self.world(&WorldSettings {
            model,
            step_time: 0.004,
            gravity: Vector3::zeros(),
            seed: 0,
        })
    }

    /// Colours of the tables of parts, `#rrggbb`, where they have one.
    pub fn part_colors(&self) -> Vec<Option<String>> {
        let parts = self.tables().part.iter();
        parts.map(|part| part.color.clone()).collect()
    }

    /// `[[obstacle]]` as a recording and the live view show it.
    pub fn scene_obstacles(&self) -> Vec<SceneObstacle> {
        let obstacles = self.tables().obstacle.iter();
        obstacles
            .filter_map(|obstacle| {
                let solid = obstacle.shape_keys().solid(self.meshes())?;
                Some(SceneObstacle {
                    name: obstacle.name.clone(),
                    shape: drawn_shape(&solid),
                    pose: RpyPose::from_array(obstacle.pose),
                })
            })
            .collect()
    }

    /// `[names]`: what people call inputs and outputs.
    pub fn point_names(&self) -> impl Iterator<Item = (IoPointName, &str)> {
        let names = self.tables().names.iter();
        names.map(|(point, name)| (*point, name.as_str()))
    }

    /// `[[wire]]`: from which output to which input.
    pub fn wires(&self) -> impl Iterator<Item = (IoPointName, IoPointName)> {
        self.tables().wire.iter().map(|wire| (wire.from, wire.to))
    }

    /// `[[safety_input]]`: the two configurable inputs of each function, and its word in the file.
    pub fn safety_input_pairs(&self) -> impl Iterator<Item = ([IoPointName; 2], &'static str)> {
        self.tables().safety_input.iter().map(|input| {
            let point = |n| IoPointName {
                group: IoGroup::ConfigurableDigital,
                direction: IoDirection::In,
                index: 2 * input.pair + n,
            };
            ([point(0), point(1)], input.function.name())
        })
    }

    /// Every obstacle with its stiffness, N/m, where it has one.
    pub fn stiffness(&self) -> Vec<(String, Option<f64>)> {
        let obstacles = self.tables().obstacle.iter();
        obstacles
            .map(|obstacle| (obstacle.name.clone(), obstacle.stiffness))
            .collect()
    }

    /// `[[safety_plane]]`: name, point, normal, and when it counts.
    pub fn planes(&self) -> Vec<(String, [f64; 3], [f64; 3], &'static str)> {
        let planes = self.tables().safety_plane.iter();
        planes
            .map(|plane| {
                (
                    plane.name.clone(),
                    plane.point,
                    plane.normal,
                    plane.mode.word(),
                )
            })
            .collect()
    }
}
