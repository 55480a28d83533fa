//! `replay --rerun`, second half: the recorded programs once more, with what came to them from outside.
//!
//! The arm is moved by the recorded commands, so that every program finds what it found; the commands that it gives are
//! compared with the recorded ones. A difference is a bug in one of the two runs, or they are of different versions.

use std::sync::Arc;

use controller::recorded_run::{RecordedRun, RecordedRunError};
use controller::rerun::RerunController;
use controller::{NullObserver, StartError};
use elite_runtime::Instrumentation;
use elite_runtime::external::Divergence;
use messages::{Localized, Text, text};
use recorder::Recording;
use thiserror::Error;

/// A reason why programs were not run again.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum ProgramsError {
    /// The recording does not tell enough.
    #[error(transparent)]
    Recording(#[from] RecordedRunError),
    /// Something that came to a program is not in the recording.
    #[error("{0}")]
    Lost(Text),
    /// The arm cannot be started.
    #[error(transparent)]
    Start(#[from] StartError),
    /// A recorded command cannot be given again.
    #[error("{0}")]
    Command(Text),
    /// The system gives no thread.
    #[error("the operating system refused what a run needs: {0}")]
    #[zh("操作系统拒绝了运行所需的资源：{0}")]
    System(#[from] std::io::Error),
}

/// What running the programs again showed.
#[derive(Clone, Debug, PartialEq, Eq, Error, Localized)]
pub enum ProgramsComparison {
    /// Every command came out the same.
    #[error("identical: {programs} programs, {commands} commands")]
    #[zh("相同：{programs} 个程序，{commands} 个命令")]
    Identical {
        /// Number of programs.
        programs: usize,
        /// Number of commands.
        commands: u64,
    },
    /// The first difference.
    #[error("first difference of the programs: {0}")]
    #[zh("程序的首个差异：{0}")]
    Different(Divergence),
}

impl ProgramsComparison {
    /// True when every command came out the same.
    pub fn is_identical(&self) -> bool {
        matches!(self, Self::Identical { .. })
    }

    /// The cycle of the first difference.
    pub fn cycle(&self) -> Option<u64> {
        match self {
            Self::Identical { .. } => None,
            Self::Different(departure) => Some(departure.cycle),
        }
    }
}

/// Runs the programs of a recording again.
///
/// # Errors
/// [`ProgramsError`] says why they cannot be.
pub fn rerun_programs(recording: &Recording) -> Result<ProgramsComparison, ProgramsError> {
    let run = RecordedRun::read(recording)?;
    if let Some(lost) = run.unrecorded_input() {
        return Err(ProgramsError::Lost(lost));
    }
    let programs = run.programs().count();
    let every_cycle = Box::new(|_: &_| true);
    let repeating = RerunController::start(
        &run,
        Arc::new(NullObserver),
        Instrumentation::default(),
        every_cycle,
    )?;
    repeating.run(&run, None)?;
    let (trouble, repeat) = (repeating.trouble(), repeating.repeat().clone());
    repeating.shut_down();
    if let Some(trouble) = trouble {
        return Err(ProgramsError::Command(text!("{trouble}", "{trouble}")));
    }
    Ok(match repeat.departure() {
        Some(departure) => ProgramsComparison::Different(departure),
        None => ProgramsComparison::Identical {
            programs,
            commands: repeat.commands_given(),
        },
    })
}
