//! From tables of the cell to what the control cycle acts on: safety planes and tool, belts, loads.
//!
//! Values were checked when the file was read; what the arm's own types refuse beyond that comes back as a sentence.

use core::f64::consts::TAU;

use kinematics::safety::{self, SafetyPlane, SafetySettingError, SafetyTool};
use kinematics::{Pose, RpyPose, SafetyBounds, Wrench};
use motion::external::{Load, LoadFrame};
use motion::modes::encoder::Belt;

use super::schema::{Conveyor, ExternalWrench, LoadFrame as TableFrame, PlaneMode, Shape, Tables};

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
        Shape::Box => Some(SafetyTool::cuboid(pose, [number(0), number(1), number(2)])?),
        Shape::Cylinder => Some(SafetyTool::cylinder(pose, number(0), number(1))?),
        Shape::Sphere => Some(SafetyTool::ball(pose, number(0))?),
        // Refused when the file was read.
        Shape::Plane => None,
    };
    Ok(bounds.with_tool(tool))
}

/// `[[conveyor]]`, by encoder.
pub(super) fn belts(conveyors: &[Conveyor]) -> [Option<Belt>; 2] {
    core::array::from_fn(|encoder| {
        let conveyor = conveyors
            .iter()
            .find(|c| usize::from(c.encoder) == encoder)?;
        let turn = conveyor.ticks_per_revolution.map(|ticks| ticks / TAU);
        let per_unit = conveyor.ticks_per_meter.or(turn)?;
        Some(Belt {
            encoder,
            ticks_per_second: conveyor.speed * per_unit,
            start_at: conveyor.start_at,
        })
    })
}

/// `[[wrench]]`.
pub(super) fn loads(wrenches: &[ExternalWrench]) -> Vec<Load> {
    let load = |table: &ExternalWrench| Load {
        at: table.at,
        duration: table.duration,
        wrench: Wrench::from_array(table.wrench),
        frame: match table.frame {
            TableFrame::Base => LoadFrame::Base,
            TableFrame::Tool => LoadFrame::Tool,
        },
    };
    wrenches.iter().map(load).collect()
}
