//! The tools `check` and `run`: one program, looked at or run on a simulated arm.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use controller::options::{ControllerOptions, Permission, RecordTarget};
use controller::outcome::ProgramResult;
use controller::{NullObserver, SteppedController, WallTimeout};
use elite_runtime::{Preset, ProgramText};
use elite_syntax::SourceFile;
use messages::Language;
use motion_api::{RobotState, Seconds};
use rmcp::schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Value as Json, json};

use super::server::shortened;
use super::tools::{ToolOutput, within};
use super::workspace::{CancelFlag, Workspace};
use crate::cli::{ControllerArgs, RunArgs};
use crate::commands::check::{diagnostics_of, render_text, row};
use crate::commands::debug::literal;
use crate::config::RunConfig;
use crate::options::fill_from_json;

/// Simulated time of a run, s: unless it is said, and at most.
const TIME: f64 = 60.0;
const TIME_MAX: f64 = 3600.0;
/// Time of the machine for a run, s: unless it is said, and at most.
const WALL_TIME: f64 = 30.0;
const WALL_TIME_MAX: f64 = 300.0;
/// Time of the machine in which a program must let simulated time pass.
const STUCK: Duration = Duration::from_secs(10);
/// What is told of what a program printed, and of a report, bytes.
const OUTPUT_BYTES_MAX: usize = 60_000;
const REPORT_BYTES_MAX: usize = 20_000;
/// Findings that are told.
const FINDINGS_MAX: usize = 100;
/// Longest text of a program, bytes.
const PROGRAM_BYTES_MAX: usize = super::super::run::SCRIPT_BYTES_MAX;

/// Arguments of `check`.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(crate = "rmcp::schemars")]
#[serde(deny_unknown_fields)]
pub(super) struct CheckArguments {
    /// The text of the program; instead of file
    #[serde(default)]
    program: Option<String>,
    /// The path of the program; instead of program
    #[serde(default)]
    file: Option<String>,
    /// Whether the text is that of a test, which knows the object `test`. A file says so by its name
    #[serde(default)]
    is_test: bool,
}

/// Arguments of `run`.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[schemars(crate = "rmcp::schemars")]
#[serde(deny_unknown_fields)]
pub(super) struct RunArguments {
    /// The text of the program; instead of file
    #[serde(default)]
    pub(super) program: Option<String>,
    /// The path of the program; instead of program
    #[serde(default)]
    pub(super) file: Option<String>,
    /// Simulated time after which the program is ended, s: up to 3600 (default 60)
    #[serde(default)]
    pub(super) time: Option<f64>,
    /// Time of the machine after which it is ended, s: up to 300 (default 30)
    #[serde(default)]
    pub(super) wall_time: Option<f64>,
    /// Where to write a recording: arm.mcap. It is written anew
    #[serde(default)]
    pub(super) record: Option<String>,
    /// The arm: cs63, cs66 (default), cs612, cs616, cs620, cs625, or the path of a URDF file
    #[serde(default)]
    pub(super) model: Option<String>,
    /// Joint positions at the start, six angles, rad (default 0, -1.5708, 1.5708, -1.5708, -1.5708, 0)
    #[serde(default)]
    pub(super) home: Option<[f64; 6]>,
    /// Tool centre point from the flange: x, y, z, Rx, Ry, Rz, m and rad (default zeros)
    #[serde(default)]
    pub(super) tcp: Option<[f64; 6]>,
    /// Payload: mass, kg, or mass and centre of gravity x, y, z, m (default 0)
    #[serde(default)]
    pub(super) payload: Option<Vec<f64>>,
    /// The path of a cell file (TOML): obstacles, wires between inputs and outputs, safety planes, conveyors
    #[serde(default)]
    pub(super) cell: Option<String>,
    /// How the arm is simulated: rigid (default), rapier, or ideal (always where it should be)
    #[serde(default)]
    pub(super) plant: Option<String>,
    /// Length of a control cycle, whole ms from 1 to 8 (default 4)
    #[serde(default)]
    pub(super) step_ms: Option<u8>,
    /// Seed of random() and of simulated noise (default 0)
    #[serde(default)]
    pub(super) seed: Option<u64>,
    /// Globals that the program finds set: {"speed": 0.25, "name": "left"}
    #[serde(default)]
    pub(super) set: BTreeMap<String, Json>,
    /// Whether the program may read and write files beneath the folder of the server (default false)
    #[serde(default)]
    pub(super) files: bool,
}

/// The program of a call: a text, or a file.
pub(super) fn program(
    workspace: &Workspace,
    text: Option<String>,
    file: Option<&str>,
) -> Result<ProgramText, String> {
    match (text, file) {
        (Some(text), None) if text.len() > PROGRAM_BYTES_MAX => Err(format!(
            "program has {} bytes, at most {PROGRAM_BYTES_MAX} are taken",
            text.len()
        )),
        (Some(text), None) => Ok(ProgramText {
            name: "program".to_owned(),
            text,
        }),
        (None, Some(file)) => workspace.program("file", file),
        _ => Err("give either program, a text, or file, a path".to_owned()),
    }
}

pub(super) fn check(
    workspace: &Workspace,
    arguments: CheckArguments,
    _: &CancelFlag,
) -> Result<ToolOutput, String> {
    let file = arguments.file.as_deref();
    let is_test =
        arguments.is_test || file.is_some_and(|file| script_test::is_test_file(Path::new(file)));
    let ProgramText { name, text } = program(workspace, arguments.program, file)?;
    let source = SourceFile::new(name, text);
    let findings = diagnostics_of(&source, is_test);
    let mut text = match findings.len() {
        0 => "no findings".to_owned(),
        1 => "1 finding\n".to_owned(),
        count => format!("{count} findings\n"),
    };
    for finding in findings.iter().take(FINDINGS_MAX) {
        text.push('\n');
        text.push_str(&render_text(finding, &source, Language::English));
    }
    if findings.len() > FINDINGS_MAX {
        text.push_str(&format!("\nand {} more\n", findings.len() - FINDINGS_MAX));
    }
    let rows = findings
        .iter()
        .take(FINDINGS_MAX)
        .map(|finding| row(finding, &source));
    Ok(ToolOutput {
        text,
        structured: Some(json!({
            "count": findings.len(),
            "findings": rows.collect::<Vec<Json>>(),
        })),
        png: None,
    })
}

pub(super) fn run(
    workspace: &Workspace,
    mut arguments: RunArguments,
    stop: &CancelFlag,
) -> Result<ToolOutput, String> {
    let time = within("time", arguments.time, TIME, 0.001, TIME_MAX)?;
    let wall = within(
        "wall_time",
        arguments.wall_time,
        WALL_TIME,
        0.1,
        WALL_TIME_MAX,
    )?;
    let text = program(
        workspace,
        arguments.program.take(),
        arguments.file.as_deref(),
    )?;
    let record = arguments.record.clone();
    let config = settings(workspace, arguments)?;
    let controller = SteppedController::open(&config.robot, Arc::new(NullObserver));
    let controller = controller.map_err(|error| error.to_string())?;
    controller
        .controller()
        .supervisor()
        .set_presets(&config.presets);
    let began = Instant::now();
    let mut goes_on = || !stop.load(Ordering::Relaxed) && began.elapsed().as_secs_f64() < wall;
    let mut patience = WallTimeout {
        wall: STUCK,
        keep_going: &mut goes_on,
    };
    // A time of at most an hour is one.
    let ran = controller.run_program(text, Seconds::new(time).unwrap_or_default(), &mut patience);
    let took = began.elapsed().as_secs_f64();
    let (state, peaks) = (controller.state(), controller.collector().peaks());
    let whole = controller.shut_down().map_err(|error| error.to_string())?;
    let mut result = ran.map_err(|error| error.to_string())?;
    let prints = shortened(result.prints.join("\n"), OUTPUT_BYTES_MAX);
    let report = result.report.take();
    let report = report.map(|report| shortened(report.to_string(), REPORT_BYTES_MAX));
    let gave_up = (took >= wall)
        .then(|| format!("it was ended after {wall} s of the machine's time (wall_time)"));
    let error = result
        .error
        .take()
        .map(|error| error.to_string())
        .or(gave_up);
    let text = told(
        &result,
        error.as_deref(),
        &prints,
        report.as_deref(),
        &state,
        took,
    );
    let peaks = json!({
        "tcp_speed": peaks.tcp_speed,
        "tcp_force": peaks.tcp_force,
        "tcp_torque": peaks.tcp_torque,
        "joint_speed": peaks.joint_speed,
        "joint_torque": peaks.joint_torque,
    });
    let recording = record.filter(|_| whole);
    let text = match &recording {
        Some(path) => format!("{text}recording: {path}\n"),
        None => text,
    };
    Ok(ToolOutput {
        text,
        structured: Some(json!({
            "outcome": result.outcome.as_str(),
            "error": error,
            "line": result.line,
            "time": result.time,
            "prints": prints,
            "report": report,
            "joint_positions": state.actual_q.0,
            "tcp_pose": state.actual_tcp_pose.to_array(),
            "peaks": peaks,
            "recording": recording,
        })),
        png: None,
    })
}

/// What became of the program, for whoever reads.
fn told(
    result: &ProgramResult,
    error: Option<&str>,
    prints: &str,
    report: Option<&str>,
    state: &RobotState,
    took: f64,
) -> String {
    let mut text = format!(
        "{} after {:.3} s of simulated time ({took:.2} s here)\n",
        result.outcome, result.time
    );
    if let Some(error) = error {
        let line = result
            .line
            .map_or_else(String::new, |line| format!("line {line}: "));
        text.push_str(&format!("{line}{error}\n"));
    }
    if !prints.is_empty() {
        text.push_str(&format!("printed:\n{prints}\n"));
    }
    if let Some(report) = report {
        text.push_str(&format!("report:\n{}\n", report.trim_end()));
    }
    let row = |values: &[f64]| {
        let values: Vec<String> = values.iter().map(|x| format!("{x:.4}")).collect();
        values.join(", ")
    };
    text.push_str(&format!(
        "joints [{}] rad, TCP [{}] m, rad\n",
        row(&state.actual_q.0),
        row(&state.actual_tcp_pose.to_array())
    ));
    text
}

/// The settings of a run. Whatever files they name are beneath the folder, and nothing outside the process is reached.
pub(super) fn settings(
    workspace: &Workspace,
    arguments: RunArguments,
) -> Result<RunConfig, String> {
    let mut options = ControllerOptions::default();
    // Each in the form in which it is given here.
    let given = [
        ("model", arguments.model.map(Json::from)),
        ("home", arguments.home.map(|q| json!(q))),
        ("tcp", arguments.tcp.map(|pose| json!(pose))),
        ("payload", arguments.payload.map(Json::from)),
        ("plant", arguments.plant.map(Json::from)),
        ("step_ms", arguments.step_ms.map(Json::from)),
        ("seed", arguments.seed.map(Json::from)),
    ];
    for (name, value) in given {
        if let (Some(value), Some(slot)) = (value, options.slot(&name.replace('_', "-"))) {
            fill_from_json(slot, &value)
                .map_err(|refused| format!("{name} is {:?}; {}", refused.given, refused.allowed))?;
        }
    }
    let path = |name: &str, given: Option<String>| {
        given.map(|given| workspace.path(name, &given)).transpose()
    };
    let mut presets = Vec::new();
    for (name, value) in &arguments.set {
        let preset = Preset::new(name, &literal(value));
        presets.push(preset.map_err(|error| format!("set: {name}: {}", error.why))?);
    }
    let mut allow = vec![Permission::NetPlayed];
    if arguments.files {
        allow.push(Permission::FsIn(workspace.root().to_owned()));
    }
    let record = match path("record", arguments.record)? {
        Some(path) => RecordTarget::File(path),
        None => RecordTarget::Off,
    };
    options.cell = path("cell", arguments.cell)?;
    options.record = Some(record);
    options.allow = Some(allow);
    let shared = ControllerArgs {
        options,
        ..ControllerArgs::default()
    };
    let args = RunArgs {
        file: Path::new("-").to_owned(),
        set: presets,
        shared,
    };
    RunConfig::load_within(args, Some(workspace.folders())).map_err(|error| error.to_string())
}
