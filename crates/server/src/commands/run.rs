//! `eliteserver run`: one script to its end, no ports. `print` goes to stdout, everything else to stderr.

use std::time::Instant;

use elite_runtime::TaskEnd;

use editor::dap::DebugHub;

use crate::commands::check::read_script;
use crate::config::RunConfig;
use crate::controller_host::{ControllerHost, HostError};
use crate::event_broadcast::PrintTarget;
use crate::logging;
use crate::shutdown::{FAULT_EXIT, Shutdown};

/// Largest script.
pub const SCRIPT_BYTES_MAX: usize = 8 << 20;

/// Who sends the program, for messages about it.
pub(crate) const SENDER: &str = "the command line";

/// Exit status: 0 ended, 1 failed, 2 does not compile or cannot be read, 3 the control cycle met a fault of ours.
///
/// # Errors
/// What kept the controller from starting.
pub fn run(config: &RunConfig) -> Result<u8, HostError> {
    // A program that a signal cuts off has not ended well.
    let shutdown = Shutdown::start(1)?;
    let program = match read_script(&config.file) {
        Ok(program) => program,
        Err(sentence) => {
            logging::say(&format!("eliteserver: {sentence}"));
            return Ok(2);
        }
    };
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
        shutdown.begin(FAULT_EXIT);
    }
    // A recording that was cut short has been reported; the status is the script's.
    host.shut_down();
    if fault.is_some() {
        return Ok(FAULT_EXIT);
    }
    Ok(match end {
        Some(TaskEnd::Finished) => 0,
        Some(TaskEnd::NotCompiled) => 2,
        _ => 1,
    })
}
