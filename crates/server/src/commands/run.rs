//! `eliteserver run`: one script to its end, no ports. `print` goes to stdout, everything else to stderr.

use std::time::Instant;

use elite_runtime::{ProgramText, TaskEnd};

use crate::commands::check::{display_name, read_script};
use crate::config::RunConfig;
use crate::announce::Console;
use crate::controller::{Controller, StartError};

/// Largest script.
pub const SCRIPT_BYTES_MAX: usize = 8 << 20;

/// Exit status: 0 ended, 1 failed, 2 does not compile or cannot be read.
///
/// # Errors
/// What kept the controller from starting.
pub fn run(config: &RunConfig) -> Result<u8, StartError> {
    let text = match read_script(&config.file) {
        Ok(text) => text,
        Err(sentence) => {
            eprintln!("eliteserver: {sentence}");
            return Ok(2);
        }
    };
    let controller = Controller::start(&config.robot, Console::Stdout, false)?;
    let program = ProgramText { name: display_name(&config.file), text };
    let started = Instant::now();
    let end = controller.run_to_end(program)?;
    let simulated = controller.robot().state().time;
    let wall = started.elapsed().as_secs_f64();
    tracing::info!(
        "{simulated:.3} s simulated in {wall:.3} s, {:.1} simulated seconds a second",
        simulated / wall.max(1e-9)
    );
    let flushed = controller.shut_down();
    Ok(match end {
        Some(TaskEnd::Finished) if flushed => 0,
        Some(TaskEnd::NotCompiled) => 2,
        _ => 1,
    })
}
