//! `eliteserver run`: one script to its end, no ports. `print` goes to stdout, everything else to stderr.

mod bag;
mod patience;

use std::time::{Duration, Instant};

use elite_runtime::{ProgramText, TaskEnd};
use elite_syntax::{Severity, SourceFile};
use messages::{Text, text};

use editor::dap::DebugHub;

use crate::command::{CommandError, CommandResult, CommandStatus};
use crate::commands::check::{known_names_of_arm, model_of, read_script, render_text};
use crate::config::RunConfig;
use crate::controller_host::ControllerHost;
use crate::event_broadcast::PrintTarget;
use crate::language;
use crate::logging;
use crate::shutdown::Shutdown;
use bag::BagBesideRecording;
use controller::options::ClockChoice;
use patience::Patience;

/// Largest script.
pub const SCRIPT_BYTES_MAX: usize = 8 << 20;

/// Who sends the program, for messages about it.
pub(crate) const SENDER: &str = "the command line";

/// Findings of `check` that end a program which comes to them, or that no program means.
const FATAL_FINDINGS: &[&str] = &[
    "argument-count",
    "argument-twice",
    "busy-loop",
    "degrees",
    "far-beyond",
    "joints-for-pose",
    "millimetres",
    "missing-argument",
    "missing-module",
    "out-of-range",
    "out-of-reach",
    "pose-for-joints",
    "self-collision",
    "subscripted-function",
    "undefined-name",
    "unknown-argument",
    "unknown-attribute",
];

/// Runs the program of `config`, for `timeout` at most; `is_checked`: says before what is found in it.
///
/// Exit status: 0 ended, 1 failed, 2 does not compile or cannot be read, 3 the control cycle met a fault of ours.
///
/// # Errors
/// What kept the controller from starting.
pub fn run(config: &RunConfig, timeout: Option<Duration>, is_checked: bool) -> CommandResult {
    // A program that a signal cuts off has not ended well.
    let shutdown = Shutdown::start(CommandStatus::Negative)?;
    let program = read_script(&config.file).map_err(CommandError::sentence)?;
    if is_checked {
        warn_of_findings(config, &program)?;
    }
    let bag = BagBesideRecording::prepare(config)?;
    let host = ControllerHost::start(
        &config.robot,
        config.log.dir.as_ref(),
        PrintTarget::Stdout,
        false,
        DebugHub::default(),
    )?;
    let controller = host.controller();
    shutdown.set_recording_closer(controller.closer());
    controller.supervisor().set_presets(&config.presets);
    let started = Instant::now();
    let is_virtual = config.robot.clock == ClockChoice::Virtual;
    let patience = Patience::new(&host, &program, timeout, is_virtual);
    let stop = async {
        tokio::select! {
            () = shutdown.token().cancelled() => {}
            () = patience.run_out() => {}
        }
    };
    let end = controller.run_to_end(program, SENDER, stop)?;
    let simulated = controller.robot().state().time;
    let wall = started.elapsed().as_secs_f64();
    // Not after an error: the last line on stderr is then the exception.
    if end == Some(TaskEnd::Finished) {
        language::say(&summary(simulated, wall));
    }
    let fault = controller.faults().fatal().cloned();
    if let Some(fault) = &fault {
        controller.announce_fault(fault);
        shutdown.begin(CommandStatus::Fault);
    }
    // A recording that was cut short has been reported; the status is the script's.
    host.shut_down();
    let bag_written = bag.as_ref().map_or(Ok(()), BagBesideRecording::write);
    if fault.is_some() {
        return Ok(CommandStatus::Fault);
    }
    bag_written?;
    Ok(match end {
        Some(TaskEnd::Finished) => CommandStatus::Success,
        Some(TaskEnd::NotCompiled) => CommandStatus::NotDone,
        _ => CommandStatus::Negative,
    })
}

/// What a run took, for people.
fn summary(simulated: f64, wall: f64) -> Text {
    text!(
        "ended: {simulated:.3} s of the robot's time, in {wall:.2} s",
        "结束：机器人时间 {simulated:.3} s，本机用时 {wall:.2} s"
    )
}

/// Says before the program starts what would end it or cannot be meant. Texts that do not compile are told of when they
/// are compiled.
fn warn_of_findings(config: &RunConfig, program: &ProgramText) -> Result<(), CommandError> {
    let file = SourceFile::new(program.name.clone(), program.text.clone());
    let model = model_of(&config.robot.model)?;
    let known = known_names_of_arm(&model, &config.robot.tcp, &file);
    let is_preset = |name: &str| config.presets.iter().any(|preset| preset.name() == name);
    let found = elite_syntax::check(file.clone(), &known);
    if found
        .iter()
        .any(|finding| finding.severity == Severity::Error)
    {
        return Ok(());
    }
    for finding in found {
        let is_set = finding.code == "undefined-name" && is_preset(file.slice(finding.span));
        if FATAL_FINDINGS.contains(&finding.code) && !is_set {
            logging::say(&render_text(&finding, &file, language::chosen()));
        }
    }
    Ok(())
}
