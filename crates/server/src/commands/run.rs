//! `eliteserver run`: one script to its end, no ports. `print` goes to stdout, everything else to stderr.

use std::time::Instant;

use elite_runtime::TaskEnd;

use editor::dap::DebugHub;

use crate::command::{CommandError, CommandResult, CommandStatus};
use crate::commands::check::read_script;
use crate::config::RunConfig;
use crate::controller_host::ControllerHost;
use crate::event_broadcast::PrintTarget;
use crate::shutdown::Shutdown;

/// Largest script.
pub const SCRIPT_BYTES_MAX: usize = 8 << 20;

/// Who sends the program, for messages about it.
pub(crate) const SENDER: &str = "the command line";

/// Exit status: 0 ended, 1 failed, 2 does not compile or cannot be read, 3 the control cycle met a fault of ours.
///
/// # Errors
/// What kept the controller from starting.
pub fn run(config: &RunConfig) -> CommandResult {
    // A program that a signal cuts off has not ended well.
    let shutdown = Shutdown::start(CommandStatus::Negative)?;
    let program = read_script(&config.file).map_err(CommandError::sentence)?;
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
    let end = controller.run_to_end(program, SENDER, shutdown.token().cancelled())?;
    let simulated = controller.robot().state().time;
    let wall = started.elapsed().as_secs_f64();
    // Not after an error: the last line on stderr is then the exception.
    if end == Some(TaskEnd::Finished) {
        tracing::info!(
            "{simulated:.3} s simulated in {wall:.3} s, {:.1} simulated seconds a second",
            simulated / wall.max(1e-9)
        );
    }
    let fault = controller.faults().fatal().cloned();
    if let Some(fault) = &fault {
        controller.announce_fault(fault);
        shutdown.begin(CommandStatus::Fault);
    }
    // A recording that was cut short has been reported; the status is the script's.
    host.shut_down();
    if fault.is_some() {
        return Ok(CommandStatus::Fault);
    }
    Ok(match end {
        Some(TaskEnd::Finished) => CommandStatus::Success,
        Some(TaskEnd::NotCompiled) => CommandStatus::NotDone,
        _ => CommandStatus::Negative,
    })
}
