//! From tables of the cell to what the control cycle acts on: safety planes, obstacles and tool, belts, loads,
//! what is true of the arm.
//!
//! Values were checked when the file was read; what the arm's own types refuse beyond that comes back as a sentence.

use core::f64::consts::TAU;

use kinematics::safety::{self, SafetyPlane, SafetySettingError, SafetyTool};
use kinematics::{JointTorques, Payload, Pose, RpyPose, SafetyBounds, Wrench};
use motion::contact::{Environment, Obstacle, PlacedShape};
use motion::external::{TimedWrench, WrenchFrame};
use motion::modes::encoder::Belt;
use motion::{Drivetrain, PlantParameters};
use world::description::BodyShape;

use super::Cell;
use super::meshes::Meshes;
use super::schema::{
    self, Conveyor, ExternalWrench, LoadFrame as TableFrame, PlaneMode, SixNumbers, Tables,
};
use super::shape::{ShapeKeys, contact_pieces};

/// `[[safety_plane]]` and `[tool]`.
pub(super) fn safety_bounds(
    tables: &Tables,
    meshes: &Meshes,
) -> Result<SafetyBounds, SafetySettingError> {
    let mut bounds = SafetyBounds::default();
    for plane in &tables.safety_plane {
        let mode = match plane.mode {
            PlaneMode::Normal => safety::PlaneMode::Normal,
            PlaneMode::Reduced => safety::PlaneMode::Reduced,
            PlaneMode::Both => safety::PlaneMode::Both,
            PlaneMode::Off => safety::PlaneMode::Off,
        };
        let plane = SafetyPlane::new(plane.point, plane.normal, mode, plane.ci_pair)?;
        bounds = bounds.with_plane(plane)?;
    }
    let Some(table) = &tables.tool else {
        return Ok(bounds);
    };
    let pose = Pose::from_rpy(&RpyPose::from_array(table.pose));
    let tool = match table.shape_keys().solid(meshes) {
        Some(BodyShape::Box { size }) => Some(SafetyTool::cuboid(pose, size)?),
        Some(BodyShape::Cylinder { radius, length }) => {
            Some(SafetyTool::cylinder(pose, radius, length)?)
        }
        Some(BodyShape::Sphere { radius }) => Some(SafetyTool::ball(pose, radius)?),
        Some(BodyShape::Mesh(mesh)) => Some(SafetyTool::hull(pose, mesh.hull_corners())?),
        // Refused when the file was read.
        Some(BodyShape::Plane) | None => None,
    };
    Ok(bounds.with_tool(tool))
}

/// `[payload]` and `[arm]`.
pub(super) fn truth(tables: &Tables) -> PlantParameters {
    let arm = &tables.arm;
    PlantParameters {
        // What a gripper holds adds to what is true, so nothing is taken from what the controller was told.
        payload: match &tables.payload {
            Some(table) => Some(Payload {
                mass: table.mass,
                cog: table.cog.into(),
                inertia: table.inertia,
            }),
            None => (!tables.gripper.is_empty()).then_some(Payload::NONE),
        },
        drivetrain: Drivetrain {
            coulomb: JointTorques(arm.coulomb),
            viscous: arm.viscous,
            rotor_inertia: arm.rotor_inertia,
        },
    }
}

/// What the arm touches: obstacles that stand still, floor and conveyors of a world; the tool; what grippers may hold.
pub(super) fn surroundings(cell: &Cell) -> Environment {
    let tables = cell.tables();
    let still = tables.obstacle.iter().enumerate();
    let still = still.filter(|(_, table)| !cell.is_moved(&table.name));
    let still = still.flat_map(|(number, table)| obstacles(cell, number, table));
    let part_shapes = match tables.gripper.is_empty() {
        true => Vec::new(),
        false => {
            let parts = tables.part.iter();
            parts
                .map(|table| pieces(cell, &table.shape_keys(), Pose::IDENTITY))
                .collect()
        }
    };
    let tool = tables.tool.as_ref();
    let tool = tool.map(|tool| pieces(cell, &tool.shape_keys(), pose_of(&tool.pose)));
    Environment {
        obstacles: still.chain(cell.world_obstacles()).collect(),
        tool: tool.unwrap_or_default(),
        part_shapes,
    }
}

/// An obstacle of the file as the arm meets it: one for each convex piece.
fn obstacles(cell: &Cell, number: usize, table: &schema::Obstacle) -> Vec<Obstacle> {
    let pieces = pieces(cell, &table.shape_keys(), pose_of(&table.pose));
    let body = (pieces.len() > 1).then_some(number);
    let obstacle = |solid| Obstacle {
        name: table.name.clone(),
        solid,
        body,
        stiffness: table.stiffness,
        damping: table.damping.unwrap_or(0.0),
        friction: table.friction.unwrap_or(0.0),
    };
    pieces.into_iter().map(obstacle).collect()
}

/// The convex pieces of a shape; none for a mesh that is not there, which the reading of the file refused.
fn pieces(cell: &Cell, keys: &ShapeKeys<'_>, pose: Pose) -> Vec<PlacedShape> {
    let solid = keys.solid(&cell.meshes);
    solid.map_or_else(Vec::new, |solid| contact_pieces(&solid, pose))
}

pub(super) fn pose_of(numbers: &SixNumbers) -> Pose {
    Pose::from_rpy(&RpyPose::from_array(*numbers))
}

/// Ticks of an encoder for a metre of a belt, or for a radian of a turntable.
pub(super) fn ticks_per_unit(conveyor: &Conveyor) -> Option<f64> {
    let turn = conveyor.ticks_per_revolution.map(|ticks| ticks / TAU);
    conveyor.ticks_per_meter.or(turn)
}

/// `[[conveyor]]`, by encoder.
pub(super) fn belts(conveyors: &[Conveyor]) -> [Option<Belt>; 2] {
    core::array::from_fn(|encoder| {
        let conveyor = conveyors
            .iter()
            .find(|c| c.encoder.map(usize::from) == Some(encoder))?;
        let per_unit = ticks_per_unit(conveyor)?;
        Some(Belt {
            encoder,
            ticks_per_second: conveyor.speed * per_unit,
            start_at: conveyor.start_at,
        })
    })
}

/// `[[wrench]]`.
pub(super) fn loads(wrenches: &[ExternalWrench]) -> Vec<TimedWrench> {
    let load = |table: &ExternalWrench| TimedWrench {
        at: table.at,
        duration: table.duration,
        wrench: Wrench::from_array(table.wrench),
        frame: match table.frame {
            TableFrame::Base => WrenchFrame::Base,
            TableFrame::Tool => WrenchFrame::Tool,
        },
    };
    wrenches.iter().map(load).collect()
}
