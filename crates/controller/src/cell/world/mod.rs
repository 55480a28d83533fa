//! From the tables about parts and what handles them to the description of a world, which knows no file and no names of
//! points.
//!
//! What a kind of an entry needs, and which keys it does not have, is settled here; ranges and names are checked by the
//! world itself.

mod faults;
mod grippers;
mod keys;
mod machines;
mod parts;

use kinematics::{Capsule, Pose, RobotModel};
use motion::contact::Obstacle;
use nalgebra::Vector3;
use world::description::{ArmShape, BodyShape, ObstacleDescription, PairFriction, Sink};
use world::{FLOOR, WorldDescription};

use super::Cell;
use super::check::InvalidValue;
use super::convert::pose_of;
use super::meshes::Meshes;
use super::schema::{self, Tables};
use super::shape::contact_pieces;
use faults::fault;
pub use faults::fault_of;
use grippers::{check_buses, gripper};
use machines::{actuator, conveyor, detector, source};
use parts::part;

/// Friction of an obstacle towards parts where the file gives none.
const OBSTACLE_FRICTION: f64 = 0.5;

/// What decides about a world besides the cell file.
#[derive(Clone, Copy, Debug)]
pub struct WorldSettings<'a> {
    /// The arm.
    pub model: &'a RobotModel,
    /// Length of a control cycle, s.
    pub step_time: f64,
    /// Free-fall acceleration at the arm, base frame, m/s².
    pub gravity: Vector3<f64>,
    /// Seed of all scatter.
    pub seed: u64,
}

impl Cell {
    /// Whether the file has tables about parts or what handles them.
    pub fn has_world(&self) -> bool {
        has_world(self.tables())
    }

    /// The world that the file describes; `None` without such tables.
    pub fn world(&self, settings: &WorldSettings<'_>) -> Option<WorldDescription> {
        if !self.has_world() {
            return None;
        }
        // The tables were converted when the file was read, so they can be again.
        let mut description = description(self.tables(), self.meshes()).ok()?;
        description.arm = self.arm_shape(settings.model);
        description.settings.period = settings.step_time;
        description.settings.seed = settings.seed;
        let own = self.tables().world.unwrap_or_default();
        description.settings.gravity = own.gravity.unwrap_or(settings.gravity.into());
        description.settings.substep = own.substep.unwrap_or(0.001).min(settings.step_time);
        Some(description)
    }

    /// What the arm touches in the world besides the obstacles: floor and conveyors.
    pub(super) fn world_obstacles(&self) -> Vec<Obstacle> {
        let solids = self.world_solids().into_iter();
        let obstacles = solids.flat_map(|(name, solid, pose)| {
            let pieces = contact_pieces(&solid, pose).into_iter();
            pieces.map(move |solid| Obstacle {
                name: name.clone(),
                solid,
                body: None,
                stiffness: None,
                damping: 0.0,
                friction: 0.0,
            })
        });
        obstacles.collect()
    }

    /// What stands still in the cell, floor and conveyors included: name, solid, pose in the base frame.
    pub fn standing_solids(&self) -> Vec<(String, BodyShape, Pose)> {
        let tables = self.tables().obstacle.iter();
        let still = tables.filter(|table| !self.is_moved(&table.name));
        let obstacles = still.filter_map(|table| {
            let solid = table.shape_keys().solid(self.meshes())?;
            Some((table.name.clone(), solid, pose_of(&table.pose)))
        });
        obstacles.chain(self.world_solids()).collect()
    }

    /// `[tool]`: its solid, and the pose in the flange frame.
    pub fn tool_solid(&self) -> Option<(BodyShape, Pose)> {
        let tool = self.tables().tool.as_ref()?;
        let solid = tool.shape_keys().solid(self.meshes())?;
        Some((solid, pose_of(&tool.pose)))
    }

    /// Floor and conveyors: name, solid, pose in the base frame.
    pub(super) fn world_solids(&self) -> Vec<(String, BodyShape, Pose)> {
        let floor = self.tables().world.and_then(|world| world.floor);
        let floor = floor.map(|height| {
            let pose = Pose::from_translation(0.0, 0.0, height);
            (FLOOR.to_owned(), BodyShape::Plane, pose)
        });
        let belts = self.tables().conveyor.iter().filter_map(|belt| {
            let (pose, size) = (belt.pose?, belt.size?);
            Some((belt.name.clone()?, BodyShape::Box { size }, pose_of(&pose)))
        });
        floor.into_iter().chain(belts).collect()
    }

    /// The outside of the arm, with the tool.
    fn arm_shape(&self, model: &RobotModel) -> ArmShape {
        ArmShape {
            links: link_capsules(model),
            tool: self.tool_solid(),
        }
    }

    /// Names of obstacles that actuators move: the arm meets them in the world.
    pub(super) fn is_moved(&self, obstacle: &str) -> bool {
        let mut actuators = self.tables().actuator.iter();
        actuators.any(|actuator| actuator.moves.iter().any(|name| name == obstacle))
    }

    /// Ticks for a metre or a radian of the conveyors with a surface that turn encoders 0 and 1.
    pub(crate) fn world_encoders(&self) -> [Option<f64>; 2] {
        core::array::from_fn(|encoder| {
            let mut belts = self
                .tables()
                .conveyor
                .iter()
                .filter(|belt| belt.has_surface());
            let belt = belts.find(|belt| belt.encoder.map(usize::from) == Some(encoder))?;
            super::convert::ticks_per_unit(belt)
        })
    }
}

/// Whether there are tables about parts or what handles them.
pub(super) fn has_world(tables: &Tables) -> bool {
    let Tables {
        world,
        part,
        gripper,
        source,
        sink,
        detector,
        actuator,
        fault,
        ..
    } = tables;
    world.is_some()
        || !(part.is_empty()
            && gripper.is_empty()
            && source.is_empty()
            && sink.is_empty()
            && detector.is_empty()
            && actuator.is_empty()
            && fault.is_empty())
        || tables.conveyor.iter().any(schema::Conveyor::has_surface)
}

/// Everything but the arm, and what the start decides.
///
/// # Errors
/// The first table whose keys do not go together.
pub(super) fn description(
    tables: &Tables,
    meshes: &Meshes,
) -> Result<WorldDescription, InvalidValue> {
    let mut world = WorldDescription::default();
    world.settings.floor = tables.world.and_then(|world| world.floor);
    let obstacles = tables.obstacle.iter();
    world.obstacles = obstacles
        .filter_map(|table| obstacle(table, meshes))
        .collect();
    let parts = tables.part.iter();
    world.parts = parts
        .map(|table| part(table, meshes))
        .collect::<Result<_, _>>()?;
    check_buses(tables)?;
    world.frictions = tables
        .friction
        .iter()
        .map(|pair| PairFriction {
            a: pair.a.clone(),
            b: pair.b.clone(),
            value: pair.value,
        })
        .collect();
    world.grippers = tables
        .gripper
        .iter()
        .map(|table| gripper(table, meshes))
        .collect::<Result<_, _>>()?;
    let belts = tables.conveyor.iter().enumerate();
    world.conveyors = belts
        .filter(|(_, belt)| belt.has_surface())
        .map(|(number, belt)| conveyor(number, belt))
        .collect::<Result<_, _>>()?;
    world.sources = tables.source.iter().map(source).collect::<Result<_, _>>()?;
    world.sinks = tables
        .sink
        .iter()
        .map(|sink| Sink {
            name: sink.name.clone(),
            pose: pose_of(&sink.pose),
            size: sink.size,
        })
        .collect();
    world.detectors = tables
        .detector
        .iter()
        .map(detector)
        .collect::<Result<_, _>>()?;
    world.actuators = tables
        .actuator
        .iter()
        .map(actuator)
        .collect::<Result<_, _>>()?;
    let faults = tables.fault.iter().enumerate();
    world.faults = faults
        .map(|(number, entry)| fault(number, entry))
        .collect::<Result<_, _>>()?;
    Ok(world)
}

fn obstacle(table: &schema::Obstacle, meshes: &Meshes) -> Option<ObstacleDescription> {
    Some(ObstacleDescription {
        name: table.name.clone(),
        shape: table.shape_keys().solid(meshes)?,
        pose: pose_of(&table.pose),
        friction: table.friction.unwrap_or(OBSTACLE_FRICTION),
    })
}

/// Capsules of the links in the frames of their joints. The last link ends at the flange, whose capsule is rounder than
/// that.
fn link_capsules(model: &RobotModel) -> Vec<(usize, Capsule)> {
    let frames = model.forward(&kinematics::JointPositions::ZERO);
    let flange_from_wrist =
        frames.base_from_flange.inverse() * frames.base_from_joint[kinematics::DOF - 1];
    let mut links = Vec::new();
    for joint in 0..kinematics::DOF {
        for capsule in model.collision().capsules(joint + 1) {
            let mut capsule = *capsule;
            if joint + 1 == kinematics::DOF {
                let back = flange_from_wrist.inverse();
                for end in [&mut capsule.p0, &mut capsule.p1] {
                    let mut at = flange_from_wrist.transform_point(*end);
                    at.z = at.z.min(-capsule.radius);
                    *end = back.transform_point(at);
                }
            }
            links.push((joint, capsule));
        }
    }
    links
}
