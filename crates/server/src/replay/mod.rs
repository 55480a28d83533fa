//! `eliteserver replay`: what a recording tells.
//!
//! Owns the questions of the command line and their answers on stdout. Reading the file is the recorder's business,
//! running it again that of [`motion`]; here they are put together.

mod condition;
mod csv;
mod diff;
mod find;
mod plot;
mod register_write;
mod rerun;
pub(crate) mod script;
mod serve;
mod state;
mod summary;

use std::io::{self, Write};

use kinematics::{ModelError, RobotModel};
use recorder::{ReadError, Recording, Setup, Summary};
use thiserror::Error;

use crate::cli::ReplayArgs;
use crate::logging;

pub use condition::ConditionError;
pub use plot::PictureError;
pub use rerun::{Comparison, RerunError};
pub use serve::ServeRecordingError;

/// Exit status: 0 answered, 1 a cycle differs (`--rerun`), 2 the recording cannot be read or the question not answered.
pub fn run(args: &ReplayArgs) -> u8 {
    let stdout = io::stdout();
    let mut out = io::BufWriter::new(stdout.lock());
    let answered = answer(args, &mut out).and_then(|status| {
        out.flush()?;
        Ok(status)
    });
    match answered {
        Ok(status) => status,
        // Whoever reads the answer has seen enough: `replay --csv /cycle | head`.
        Err(ReplayError::Output(error)) if error.kind() == io::ErrorKind::BrokenPipe => 0,
        Err(error) => {
            logging::say(&format!("eliteserver: {error}"));
            2
        }
    }
}

/// Why a question about a recording has no answer.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// The recording cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// There is no state at that time.
    #[error("there is no state at {asked} s: {}", covered(*.range))]
    NoSuchTime {
        /// The time asked for, s.
        asked: f64,
        /// First and last time of the recording, s; `None` when it has no cycles.
        range: Option<(f64, f64)>,
    },
    /// The picture cannot be made.
    #[error(transparent)]
    Plot(#[from] PictureError),
    /// The condition of `--find` cannot be answered.
    #[error(transparent)]
    Condition(#[from] ConditionError),
    /// The recording cannot be run again.
    #[error(transparent)]
    Rerun(#[from] RerunError),
    /// The recording cannot be served.
    #[error(transparent)]
    Serve(#[from] ServeRecordingError),
    /// The answer cannot be written.
    #[error("cannot write the answer: {0}")]
    Output(#[from] io::Error),
}

fn covered(range: Option<(f64, f64)>) -> String {
    match range {
        Some((first, last)) => format!("the recording covers {first:.3} s to {last:.3} s"),
        None => "the recording has no cycles".to_owned(),
    }
}

/// Answers the question of the command line; returns the exit status.
///
/// # Errors
/// [`ReplayError`], a sentence for people.
pub fn answer(args: &ReplayArgs, out: &mut impl Write) -> Result<u8, ReplayError> {
    let recording = Recording::open(&args.file)?;
    if let Some(time) = args.at {
        state::print(&recording, time, out)?;
    } else if let Some(topic) = &args.csv {
        csv::print(&recording, topic, out)?;
    } else if let Some(path) = &args.plot {
        plot::plot(&recording, path)?;
    } else if let Some(condition) = &args.find {
        find::print(&recording, condition, out)?;
    } else if args.script {
        script::print(&recording, out)?;
    } else if let Some(other) = &args.diff {
        // `--diff A B` and `A --diff B` mean the same; A is the one that was given first.
        let report = diff::compare(&recording, &Recording::open(other)?)?;
        writeln!(out, "{report}")?;
        return Ok(u8::from(!report.is_identical()));
    } else if args.serve {
        serve::serve(&recording, args.rate, &args.ports)?;
    } else if args.rerun {
        let comparison = rerun::rerun(&recording)?;
        writeln!(out, "{comparison}")?;
        return Ok(u8::from(!comparison.is_identical()));
    } else {
        let limits = recording
            .setup()
            .and_then(|setup| model_of(setup).ok())
            .map(|model| *model.limits());
        let summary = Summary::of(&recording, limits.as_ref())?;
        summary::print(&recording, &summary, out)?;
    }
    Ok(0)
}

/// The arm of a recording: the URDF it carries, or the built-in model it names.
fn model_of(setup: &Setup) -> Result<RobotModel, ModelError> {
    match &setup.urdf {
        Some(urdf) => RobotModel::from_urdf(urdf),
        None => RobotModel::built_in(&setup.model),
    }
}
