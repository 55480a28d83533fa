//! The tools `clearance` and `plan_path`: how near a program comes to anything, and a way around what is in the way.

use std::collections::BTreeMap;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use controller::clearance::{MeasureOptions, MeasuredEnd, measure};
use controller::planned_path::{PathTarget, PlanError, PlanOptions};
use editor::analysis::words::Language;
use kinematics::{JointPositions, RpyPose};
use rmcp::schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Value as Json, json};

use super::programs::{RunArguments, program, settings};
use super::server::shortened;
use super::tools::{ToolOutput, within};
use super::workspace::{CancelFlag, Workspace};
use crate::commands::clearance::{row, summary, table};
use crate::commands::plan::{answer, sentence};

/// Longest simulated time of a program, s: unless it is said, and at most.
const TIME: f64 = 60.0;
const TIME_MAX: f64 = 3600.0;
/// Time of the machine for a run, s.
const WALL_TIME: f64 = 120.0;
/// Margin, m: unless it is said, and at most.
const MARGIN: f64 = 0.01;
const LENGTH_MAX: f64 = 10.0;
/// Longest search, s: unless it is said, and at most.
const SEARCH: f64 = 5.0;
const SEARCH_MAX: f64 = 60.0;
/// Motions that are told one by one.
const ROWS_MAX: usize = 500;
/// What is told of a table, bytes.
const TABLE_BYTES_MAX: usize = 60_000;

/// Arguments of `clearance`.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(crate = "rmcp::schemars")]
#[serde(deny_unknown_fields)]
pub(super) struct ClearanceArguments {
    /// The text of the program; instead of file
    #[serde(default)]
    program: Option<String>,
    /// The path of the program; instead of program
    #[serde(default)]
    file: Option<String>,
    /// The path of a cell file (TOML): obstacles, the tool, pairs that may touch
    #[serde(default)]
    cell: Option<String>,
    /// The distance that every motion has to keep, m (default 0)
    #[serde(default)]
    margin: Option<f64>,
    /// Simulated time after which the program is ended, s: up to 3600 (default 60)
    #[serde(default)]
    time: Option<f64>,
    /// The arm: cs63, cs66 (default), cs612, cs616, cs620, cs625, or the path of a URDF file
    #[serde(default)]
    model: Option<String>,
    /// Joint positions at the start, six angles, rad (default 0, -1.5708, 1.5708, -1.5708, -1.5708, 0)
    #[serde(default)]
    home: Option<[f64; 6]>,
    /// Tool centre point from the flange: x, y, z, Rx, Ry, Rz, m and rad (default zeros)
    #[serde(default)]
    tcp: Option<[f64; 6]>,
    /// Globals that the program finds set: {"speed": 0.25, "name": "left"}
    #[serde(default)]
    set: BTreeMap<String, Json>,
}

/// Arguments of `plan_path`.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(crate = "rmcp::schemars")]
#[serde(deny_unknown_fields)]
pub(super) struct PlanArguments {
    /// Joint positions at the end, six angles, rad; instead of to_pose
    #[serde(default)]
    to: Option<[f64; 6]>,
    /// Pose of the TCP at the end: x, y, z, Rx, Ry, Rz, m and rad; instead of to. Every inverse solution is a goal
    #[serde(default)]
    to_pose: Option<[f64; 6]>,
    /// Joint positions at the start, six angles, rad (default 0, -1.5708, 1.5708, -1.5708, -1.5708, 0)
    #[serde(default, rename = "from")]
    start: Option<[f64; 6]>,
    /// Joint positions that the path passes, in this order
    #[serde(default)]
    via: Vec<[f64; 6]>,
    /// The path of a cell file (TOML): obstacles, the tool, pairs that may touch
    #[serde(default)]
    cell: Option<String>,
    /// The distance that is kept, m (default 0.01)
    #[serde(default)]
    margin: Option<f64>,
    /// Longest search, s of the machine's time: up to 60 (default 5)
    #[serde(default)]
    time: Option<f64>,
    /// Seed of the search (default 0)
    #[serde(default)]
    seed: Option<u64>,
    /// Name of something in the cell that hangs on the flange, as it lies when the arm is at the start
    #[serde(default)]
    held: Option<String>,
    /// Length of the last piece, a line along the z axis of the tool, m (default 0)
    #[serde(default)]
    approach: Option<f64>,
    /// Joint speed of the program, rad/s (default 1.05)
    #[serde(default)]
    speed: Option<f64>,
    /// Joint acceleration of the program, rad/s² (default 1.4)
    #[serde(default)]
    acceleration: Option<f64>,
    /// The arm: cs63, cs66 (default), cs612, cs616, cs620, cs625, or the path of a URDF file
    #[serde(default)]
    model: Option<String>,
    /// Tool centre point from the flange: x, y, z, Rx, Ry, Rz, m and rad (default zeros)
    #[serde(default)]
    tcp: Option<[f64; 6]>,
}

pub(super) fn clearance(
    workspace: &Workspace,
    mut arguments: ClearanceArguments,
    stop: &CancelFlag,
) -> Result<ToolOutput, String> {
    let margin = within("margin", arguments.margin, 0.0, 0.0, LENGTH_MAX)?;
    let limit = within("time", arguments.time, TIME, 0.001, TIME_MAX)?;
    let text = program(
        workspace,
        arguments.program.take(),
        arguments.file.as_deref(),
    )?;
    let robot = RunArguments {
        cell: arguments.cell,
        model: arguments.model,
        home: arguments.home,
        tcp: arguments.tcp,
        set: arguments.set,
        ..RunArguments::default()
    };
    let config = settings(workspace, robot)?;
    let options = MeasureOptions {
        presets: config.presets.clone(),
        limit,
        has_history: false,
    };
    let began = Instant::now();
    let mut goes_on = || !stop.load(Ordering::Relaxed) && began.elapsed().as_secs_f64() < WALL_TIME;
    let run = measure(&config.robot, text, &options, &mut goes_on);
    let run = run.map_err(|error| error.to_string())?;
    let mut text = shortened(table(&run, margin, Language::English), TABLE_BYTES_MAX);
    if run.end != MeasuredEnd::Finished {
        text.push_str(&format!("\n{}\n", run.end));
    }
    let rows: Vec<Json> = run.rows.iter().take(ROWS_MAX).map(row).collect();
    Ok(ToolOutput {
        text,
        structured: Some(json!({
            "summary": summary(&run, margin),
            "motions": rows,
        })),
        png: None,
    })
}

pub(super) fn plan_path(
    workspace: &Workspace,
    arguments: PlanArguments,
    stop: &CancelFlag,
) -> Result<ToolOutput, String> {
    let target = match (arguments.to, arguments.to_pose) {
        (Some(q), None) => PathTarget::Joints(JointPositions(q)),
        (None, Some(pose)) => PathTarget::Pose(RpyPose::from_array(pose)),
        _ => return Err("give either to, joint positions, or to_pose, a pose".to_owned()),
    };
    let defaults = PlanOptions::to(target);
    let time = within("time", arguments.time, SEARCH, 0.001, SEARCH_MAX)?;
    let options = PlanOptions {
        via: arguments.via.into_iter().map(JointPositions).collect(),
        margin: within("margin", arguments.margin, MARGIN, 0.0, LENGTH_MAX)?,
        time: Duration::from_secs_f64(time),
        held: arguments.held,
        approach: within("approach", arguments.approach, 0.0, 0.0, LENGTH_MAX)?,
        speed: within("speed", arguments.speed, defaults.speed, 0.001, 100.0)?,
        acceleration: within(
            "acceleration",
            arguments.acceleration,
            defaults.acceleration,
            0.001,
            100.0,
        )?,
        ..defaults
    };
    let robot = RunArguments {
        cell: arguments.cell,
        model: arguments.model,
        home: arguments.start,
        tcp: arguments.tcp,
        seed: arguments.seed,
        ..RunArguments::default()
    };
    let config = settings(workspace, robot)?;
    let mut goes_on = || !stop.load(Ordering::Relaxed);
    let planned = controller::planned_path::plan_path(&config.robot, &options, &mut goes_on);
    match planned {
        Ok(planned) => {
            let warnings = planned.warnings.iter();
            let warnings: String = warnings.map(|text| format!("warning: {text}\n")).collect();
            Ok(ToolOutput {
                text: format!("{}\n{}\n{warnings}", planned.program, sentence(&planned)),
                structured: Some(answer(&planned)),
                png: None,
            })
        }
        Err(PlanError::NoPath { reason, detail }) => Ok(ToolOutput {
            text: format!("{}: {detail}", reason.as_str()),
            structured: Some(json!({"ok": false, "reason": reason.as_str(), "detail": detail})),
            png: None,
        }),
        Err(error) => Err(error.to_string()),
    }
}
