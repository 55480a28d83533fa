//! From tables of the cell to what the control cycle acts on: safety planes, obstacles and tool, belts, loads,
//! what is true of the arm.
//!
//! Values were checked when the file was read; what the arm's own types refuse beyond that comes back as a sentence.

use core::f64::consts::TAU;

use kinematics::safety::{self, SafetyPlane, SafetySettingError, SafetyTool};
use kinematics::{JointTorques, Payload, Pose, RpyPose, SafetyBounds, Wrench};
use motion::contact::{self, Environment, Obstacle, PlacedShape};
use motion::external::{TimedWrench, WrenchFrame};
use motion::modes::encoder::Belt;
use motion::{Drivetrain, PlantParameters};

use super::Cell;
use super::schema::{
    Conveyor, ExternalWrench, LoadFrame as TableFrame, PlaneMode, ShapeName, SixNumbers, Size,
    Tables,
};

/// `[[safety_plane]]` and `[tool]`.
pub(super) fn safety_bounds(tables: &Tables) -> Result<SafetyBounds, SafetySettingError> {
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
    let Some(tool) = &tables.tool else {
        return Ok(bounds);
    };
    let pose = Pose::from_rpy(&RpyPose::from_array(tool.pose));
    let size = tool.size.numbers();
    let number = |k: usize| size.get(k).copied().unwrap_or(f64::NAN);
    let tool = match tool.shape {
        ShapeName::Box => Some(SafetyTool::cuboid(pose, [number(0), number(1), number(2)])?),
        ShapeName::Cylinder => Some(SafetyTool::cylinder(pose, number(0), number(1))?),
        ShapeName::Sphere => Some(SafetyTool::ball(pose, number(0))?),
        // Refused when the file was read.
        ShapeName::Plane => None,
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
    let obstacle = |table: &super::schema::Obstacle| Obstacle {
        name: table.name.clone(),
        solid: solid(table.shape, &table.size, table.pose),
        stiffness: table.stiffness,
        damping: table.damping.unwrap_or(0.0),
        friction: table.friction.unwrap_or(0.0),
    };
    let still = tables
        .obstacle
        .iter()
        .filter(|table| !cell.is_moved(&table.name));
    let part_shapes = match tables.gripper.is_empty() {
        true => Vec::new(),
        false => super::world::description(tables)
            .map(|world| {
                world
                    .parts
                    .iter()
                    .map(|part| super::world::contact_shape(&part.shape))
                    .collect()
            })
            .unwrap_or_default(),
    };
    let tool = tables.tool.as_ref();
    Environment {
        obstacles: still.map(obstacle).chain(cell.world_obstacles()).collect(),
        tool: tool.map(|tool| solid(tool.shape, &tool.size, tool.pose)),
        part_shapes,
    }
}

/// A shape whose size was checked when the file was read.
fn solid(shape: ShapeName, size: &Size, pose: SixNumbers) -> PlacedShape {
    let size = size.numbers();
    let number = |k: usize| size.get(k).copied().unwrap_or(f64::NAN);
    PlacedShape {
        pose: Pose::from_rpy(&RpyPose::from_array(pose)),
        shape: match shape {
            ShapeName::Box => contact::Shape::Box {
                half: [0, 1, 2].map(|k| number(k) / 2.0),
            },
            ShapeName::Cylinder => contact::Shape::Cylinder {
                radius: number(0),
                half_length: number(1) / 2.0,
            },
            ShapeName::Sphere => contact::Shape::Sphere { radius: number(0) },
            ShapeName::Plane => contact::Shape::Plane,
        },
    }
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
