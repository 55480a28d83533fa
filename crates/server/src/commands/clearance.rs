//! `eliteserver clearance`: how near every motion of a program comes to anything.

use std::io::Write;

use controller::clearance::{ClearanceRun, MeasureOptions, MeasuredEnd, MotionClearance, measure};
use messages::{Language, Text, text};
use serde_json::{Value as Json, json};

use crate::cli::{ClearanceArgs, FindingFormat, RunArgs};
use crate::command::{CommandError, CommandResult, CommandStatus};
use crate::commands::check::read_script;
use crate::config::RunConfig;
use crate::language;
use crate::logging;
use crate::ports::escape::{EscapedText, escaped};
use crate::shutdown::Shutdown;

/// Above the rows for people.
const HEAD: Text = text!(
    "line  motion      distance  between                       at       joint range  singular value",
    "行    运动            间隙  之间                              时刻     关节余量      奇异值"
);

/// Exit status: 0 every distance is at least the margin, 1 one is not, or the program failed, 2 it cannot be run.
///
/// # Errors
/// What kept the program from being run.
pub fn clearance(args: &ClearanceArgs, config: &RunConfig) -> CommandResult {
    refuse_ignored(&args.run, "clearance")?;
    let shutdown = Shutdown::start(CommandStatus::NotDone)?;
    let program = read_script(&config.file).map_err(CommandError::sentence)?;
    if config.robot.cell.is_none() {
        language::complain(&text!(
            "there is no --cell: only the links and the tool are measured, against each other",
            "没有 --cell：只测量连杆和工具之间的距离"
        ));
    }
    let mut keep_going = || !shutdown.token().is_cancelled();
    let options = MeasureOptions {
        presets: config.presets.clone(),
        limit: args.timeout,
        has_history: args.plot.is_some(),
    };
    let run = measure(&config.robot, program, &options, &mut keep_going)?;
    let mut out = std::io::stdout().lock();
    let text = match args.format {
        FindingFormat::Human => table(&run, args.margin, language::chosen()),
        FindingFormat::Json => lines(&run, args.margin),
    };
    // Whoever reads may have seen enough; the status still tells.
    let _ = out.write_all(text.as_bytes());
    if let Some(path) = &args.plot {
        crate::plot::clearance::draw(path, &run, args.margin)?;
    }
    if let Some(report) = &run.result.report {
        logging::say(report.in_language(language::chosen()).trim_end());
    }
    match &run.end {
        MeasuredEnd::Finished => {}
        end => language::complain(&text!(
            "{}: {}",
            "{}：{}",
            EscapedText(&config.file.display().to_string()),
            escaped(end)
        )),
    }
    Ok(status(&run, args.margin))
}

/// What the run says of the program.
fn status(run: &ClearanceRun, margin: f64) -> CommandStatus {
    match run.end {
        MeasuredEnd::Finished => CommandStatus::of_answer(run.distance() >= margin),
        MeasuredEnd::Failed { .. } => CommandStatus::Negative,
        _ => CommandStatus::NotDone,
    }
}

/// Options of a robot that make no sense where the arm is ideal and time simulated.
///
/// # Errors
/// A sentence that names the option.
pub(crate) fn refuse_ignored(args: &RunArgs, command: &str) -> Result<(), CommandError> {
    use controller::options::{ClockChoice, PlantChoice};
    let given = &args.shared.options;
    let wrong = match () {
        () if given.plant.is_some_and(|plant| plant != PlantChoice::Ideal) => Some(text!(
            "--plant: the arm is always ideal here, so that the path is measured",
            "--plant：这里机械臂总是理想的，以便测量路径"
        )),
        () if given.clock == Some(ClockChoice::Realtime) => Some(text!(
            "--clock: time is always simulated here",
            "--clock：这里时间总是仿真的"
        )),
        () if given.record.is_some() => Some(text!(
            "--record: nothing is recorded; run --record does",
            "--record：这里不作记录；请用 run --record"
        )),
        () if args.shared.log_dir.is_some() => Some(text!(
            "--log-dir: no log files are written",
            "--log-dir：这里不写日志文件"
        )),
        () => None,
    };
    match wrong {
        Some(text) => Err(CommandError::sentence(text!(
            "{command} does not take {text}",
            "{command} 不接受 {text}"
        ))),
        None => Ok(()),
    }
}

/// A motion for machines.
pub(crate) fn row(motion: &MotionClearance) -> Json {
    let least = motion.least.as_ref();
    json!({
        "line": motion.line,
        "node": motion.node,
        "kind": motion.kind,
        "distance": least.map(|least| least.distance),
        "a": least.map(|least| &least.a),
        "b": least.map(|least| &least.b),
        "time": least.map(|least| least.time),
        "tcp": least.map(|least| least.tcp),
        "joint_margin": motion.joint_margin,
        "singularity": motion.singularity,
    })
}

/// What holds of the whole program, for machines.
pub(crate) fn summary(run: &ClearanceRun, margin: f64) -> Json {
    let nearest = run.nearest();
    let least = nearest.and_then(|row| row.least.as_ref());
    let mut summary = json!({
        "summary": true,
        "ok": status(run, margin) == CommandStatus::Success,
        "distance": least.map(|least| least.distance),
        "a": least.map(|least| &least.a),
        "b": least.map(|least| &least.b),
        "line": nearest.map(|row| row.line),
        "motions": run.rows.len(),
    });
    if run.end != MeasuredEnd::Finished {
        summary["error"] = run.end.to_string().into();
    }
    summary
}

fn lines(run: &ClearanceRun, margin: f64) -> String {
    let rows = run.rows.iter().map(row);
    let lines = rows.chain([summary(run, margin)]);
    lines.map(|line| format!("{line}\n")).collect()
}

/// For people: a line a motion, and one for all.
pub(crate) fn table(run: &ClearanceRun, margin: f64, language: Language) -> String {
    let mut text = String::new();
    if !run.rows.is_empty() {
        text.push_str(HEAD.in_language(language));
        text.push('\n');
    }
    for row in &run.rows {
        let (distance, between, time) = match &row.least {
            Some(least) => (
                format!("{:.1} mm", least.distance * 1e3),
                text!("{} and {}", "{}与{}", escaped(&least.a), escaped(&least.b)),
                format!("{:.3} s", least.time),
            ),
            None => ("–".to_owned(), Text::verbatim(""), String::new()),
        };
        let mark = match row.distance() {
            distance if distance < 0.0 => text!("  touches", "  相碰"),
            distance if distance < margin => text!("  too near", "  过近"),
            _ => Text::verbatim(""),
        };
        let node = row
            .node
            .as_deref()
            .map(|node| format!("  {}", EscapedText(node)));
        text.push_str(&format!(
            "{:>4}  {:<8} {:>11}  {} {:>9} {:>9.2} rad {:>10.3}{}{}\n",
            row.line,
            row.kind,
            distance,
            language::padded(between.in_language(language), 28),
            time,
            row.joint_margin,
            row.singularity,
            mark.in_language(language),
            node.unwrap_or_default()
        ));
    }
    let motions = match run.rows.len() {
        1 => text!("1 motion", "1 个运动"),
        count => text!("{count} motions", "{count} 个运动"),
    };
    let said = match run
        .nearest()
        .and_then(|row| Some((row, row.least.as_ref()?)))
    {
        None => text!(
            "{motions}, nothing that could be touched",
            "{motions}，没有可能碰到的物体"
        ),
        Some((row, least)) => {
            let (a, b) = (escaped(&least.a), escaped(&least.b));
            let (line, time) = (row.line, least.time);
            match least.distance < 0.0 {
                true => text!(
                    "{motions}: {a} and {b} run {:.1} mm into each other in line {line} at {time:.3} s",
                    "{motions}：{a}与{b}重叠 {:.1} mm，第 {line} 行，{time:.3} s 时",
                    -least.distance * 1e3
                ),
                false => text!(
                    "{motions}, least distance {:.1} mm: {a} and {b} in line {line} at {time:.3} s",
                    "{motions}，最小间隙 {:.1} mm：{a}与{b}，第 {line} 行，{time:.3} s 时",
                    least.distance * 1e3
                ),
            }
        }
    };
    text.push_str(said.in_language(language));
    text.push('\n');
    text
}
