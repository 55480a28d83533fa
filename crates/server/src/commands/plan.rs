//! `eliteserver plan`: a path around what is in the way, as a program.

use std::io::Write;

use controller::planned_path::{PlanError, PlanOptions, PlannedPath, plan_path};
use serde_json::{Value as Json, json};

use crate::cli::{FindingFormat, PlanArgs, RunArgs};
use crate::command::{CommandError, CommandResult, CommandStatus};
use crate::commands::clearance::refuse_ignored;
use crate::config::RunConfig;
use crate::language::told;
use crate::logging;
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
        logging::say(&told(
            "eliteserver: there is no --cell: the path only keeps the arm from itself",
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
                FindingFormat::Human => logging::say(&told(&format!(
                    "eliteserver: {}: {detail}",
                    reason.as_str()
                ))),
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
        logging::say(&told(&format!("eliteserver: warning: {warning}")));
    }
    if let Some(path) = &args.output {
        std::fs::write(path, &planned.program).map_err(|error| {
            CommandError::sentence(format!("cannot write {}: {error}", path.display()))
        })?;
    }
    match args.format {
        FindingFormat::Json => print(&format!("{}\n", answer(&planned))),
        FindingFormat::Human => {
            if args.output.is_none() {
                print(&planned.program);
            }
            logging::say(&told(&sentence(&planned)));
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
pub(crate) fn sentence(planned: &PlannedPath) -> String {
    let motions = match planned.waypoints.len().saturating_sub(1) {
        1 => "1 motion".to_owned(),
        count => format!("{count} motions"),
    };
    let distance = match planned.distance {
        Some(distance) => format!("at least {:.1} mm from everything", distance * 1e3),
        None => "nothing to keep a distance from".to_owned(),
    };
    format!(
        "{motions}, {:.3} rad in {:.3} s, {distance}; planned in {:.2} s",
        planned.length, planned.time, planned.planning_time
    )
}

/// Whoever reads may have seen enough; the status still tells.
fn print(text: &str) {
    let _ = std::io::stdout().lock().write_all(text.as_bytes());
}
