//! `eliteserver plan`: a path around what is in the way, as a program.

use std::io::Write;

use controller::planned_path::{PlanError, PlanOptions, PlannedPath, plan_path};
use messages::{Text, text};
use serde_json::{Value as Json, json};

use crate::cli::{FindingFormat, PlanArgs, RunArgs};
use crate::command::{CommandError, CommandResult, CommandStatus};
use crate::commands::clearance::refuse_ignored;
use crate::config::RunConfig;
use crate::language;
use crate::shutdown::Shutdown;

/// Exit status: 0 there is a path, 1 there is none, 2 what was asked for makes no sense.
///
/// # Errors
/// What kept it from being planned.
pub fn plan(args: &PlanArgs, config: &RunConfig) -> CommandResult {
    let run = RunArgs {
        shared: args.shared.clone(),
        ..RunArgs::default()
    };
    refuse_ignored(&run, "plan")?;
    let shutdown = Shutdown::start(CommandStatus::NotDone)?;
    let mut robot = config.robot.clone();
    if let Some(from) = args.from {
        robot.home = from.0;
    }
    if robot.cell.is_none() {
        language::complain(&text!(
            "there is no --cell: the path only keeps the arm from itself",
            "没有 --cell：路径只避免机械臂碰到自身"
        ));
    }
    let options = PlanOptions {
        target: args.to,
        via: args.via.iter().map(|via| via.0).collect(),
        margin: args.margin,
        time: args.time,
        held: args.held.clone(),
        approach: args.approach,
        speed: args.speed,
        acceleration: args.acceleration,
    };
    let mut keep_going = || !shutdown.token().is_cancelled();
    let planned = match plan_path(&robot, &options, &mut keep_going) {
        Ok(planned) => planned,
        Err(PlanError::NoPath { reason, detail }) => {
            match args.format {
                FindingFormat::Human => {
                    language::complain(&text!("{reason}: {detail}", "{reason}：{detail}"));
                }
                FindingFormat::Json => print(&format!(
                    "{}\n",
                    json!({"ok": false, "reason": reason.as_str(), "detail": detail})
                )),
            }
            return Ok(CommandStatus::Negative);
        }
        Err(error) => return Err(error.into()),
    };
    for warning in &planned.warnings {
        language::complain(&text!("warning: {warning}", "警告：{warning}"));
    }
    if let Some(path) = &args.output {
        std::fs::write(path, &planned.program).map_err(|error| {
            CommandError::sentence(text!(
                "cannot write {}: {error}",
                "无法写入 {}：{error}",
                path.display()
            ))
        })?;
    }
    match args.format {
        FindingFormat::Json => print(&format!("{}\n", answer(&planned))),
        FindingFormat::Human => {
            if args.output.is_none() {
                print(&planned.program);
            }
            language::say(&sentence(&planned));
        }
    }
    Ok(CommandStatus::Success)
}

/// A path for machines.
pub(crate) fn answer(planned: &PlannedPath) -> Json {
    let waypoints: Vec<[f64; 6]> = planned.waypoints.iter().map(|q| q.0).collect();
    json!({
        "ok": true,
        "waypoints": waypoints,
        "program": planned.program,
        "distance": planned.distance,
        "length": planned.length,
        "time": planned.time,
        "planning_time": planned.planning_time,
        "warnings": planned.warnings,
    })
}

/// A path for people.
pub(crate) fn sentence(planned: &PlannedPath) -> Text {
    let motions = match planned.waypoints.len().saturating_sub(1) {
        1 => text!("1 motion", "1 个运动"),
        count => text!("{count} motions", "{count} 个运动"),
    };
    let distance = match planned.distance {
        Some(distance) => text!(
            "at least {:.1} mm from everything",
            "与所有物体至少相距 {:.1} mm",
            distance * 1e3
        ),
        None => text!("nothing to keep a distance from", "没有需要保持间隙的物体"),
    };
    text!(
        "{motions}, {:.3} rad in {:.3} s, {distance}; planned in {:.2} s",
        "{motions}，{1:.3} s 内转动 {0:.3} rad，{distance}；规划用时 {2:.2} s",
        planned.length,
        planned.time,
        planned.planning_time
    )
}

/// Whoever reads may have seen enough; the status still tells.
fn print(text: &str) {
    let _ = std::io::stdout().lock().write_all(text.as_bytes());
}
