//! `eliteserver identify`: payload, friction, tool, frame and sensor of an arm, from recordings.
//!
//! Owns what is read of recordings and what is said; least squares and regressors are `kinematics`'s.

mod answer;
mod geometry;
mod load;
mod samples;

use std::io::Write;

use controller::recorded_run::RecordedModelError;
use kinematics::identification::FitError;
use messages::{Localized, Text, text};
use recorder::ReadError;

use crate::cli::{FindingFormat, IdentifyArgs, IdentifyTarget};
use crate::command::{CommandError, CommandResult, CommandStatus};
use crate::commands::translate::write;

pub use answer::Answer;
pub use samples::Samples;

/// Why there is no answer.
#[derive(Debug, thiserror::Error, Localized)]
pub enum IdentifyError {
    /// A recording cannot be read.
    #[error(transparent)]
    Read(ReadError),
    /// The arm of a recording is not known.
    #[error(transparent)]
    Model(#[from] RecordedModelError),
    /// A recording does not say which arm it is of.
    #[error("{0}: it does not say which arm it is of")]
    #[zh("{0}：没有说明是哪种机械臂")]
    NoSetup(String),
    /// The data do not tell.
    #[error("{0}")]
    CannotTell(Text),
}

impl IdentifyError {
    fn of_fit(error: &FitError, names: &[Text]) -> Self {
        Self::CannotTell(match error {
            FitError::TooFew { count, needed, .. } => {
                text!(
                    "the recordings hold {count} measurements: {needed} or more are needed",
                    "记录中有 {count} 个测量值：需要 {needed} 个或更多"
                )
            }
            FitError::Unobservable { unknowns } => {
                let named = unknowns.iter().filter_map(|i| names.get(*i));
                text!(
                    "the motion does not tell {}",
                    "此运动无法判断{}",
                    Text::joined(named, ", ", "、")
                )
            }
        })
    }
}

/// Exit status: 0 found, 1 the data cannot tell, 2 unreadable.
pub fn identify(args: &IdentifyArgs) -> CommandResult {
    refuse_unused(args)?;
    let answer = match answer_of(args) {
        Ok(answer) => answer,
        Err(IdentifyError::CannotTell(text)) => {
            return Err(CommandError::sentence(text).with_status(CommandStatus::Negative));
        }
        Err(error) => return Err(error.into()),
    };
    if let Some(path) = &args.output {
        write(path, &answer.toml())?;
    }
    let text = match args.format {
        FindingFormat::Human => answer.human(),
        FindingFormat::Json => format!("{}\n", answer.json()),
    };
    let _ = std::io::stdout().write_all(text.as_bytes());
    Ok(CommandStatus::Success)
}

/// Options that say nothing about what is looked for, and a time that holds nothing.
fn refuse_unused(args: &IdentifyArgs) -> Result<(), CommandError> {
    use IdentifyTarget::{Frame, Payload, Sensor, Tool};
    let options = [
        ("--from-torques", args.from_torques, &[Payload][..]),
        ("--orientation", args.orientation, &[Tool]),
        ("--at", !args.at.is_empty(), &[Tool, Frame, Sensor]),
    ];
    for (option, is_given, targets) in options {
        if is_given && !targets.contains(&args.what) {
            let names: Vec<&str> = targets.iter().map(|target| target.name()).collect();
            return Err(CommandError::sentence(text!(
                "{option} says nothing about identify {}; it is for identify {}",
                "{option} 与 identify {} 无关；它用于 identify {}",
                args.what.name(),
                names.join(", ")
            )));
        }
    }
    match (args.from, args.to) {
        (Some(from), Some(to)) if from > to => Err(CommandError::sentence(text!(
            "--from {from} s is later than --to {to} s: nothing lies between",
            "--from {from} s 晚于 --to {to} s：其间没有内容"
        ))),
        _ => Ok(()),
    }
}

fn answer_of(args: &IdentifyArgs) -> Result<Answer, IdentifyError> {
    let samples = Samples::read(&args.files, args.from, args.to)?;
    let question = IdentifyQuestion {
        what: args.what,
        from_torques: args.from_torques,
        at: &args.at,
        orientation: args.orientation,
    };
    question.answer(&samples)
}

/// What is asked of samples; the command line and Python ask alike.
#[derive(Clone, Copy, Debug)]
pub struct IdentifyQuestion<'a> {
    /// What is looked for.
    pub what: IdentifyTarget,
    /// Payload: from the torques of the joints.
    pub from_torques: bool,
    /// Tool, frame, sensor: times of the rests, s; every rest if there are none.
    pub at: &'a [f64],
    /// Tool: its axes as well.
    pub orientation: bool,
}

impl IdentifyQuestion<'_> {
    /// The answer of the samples.
    ///
    /// # Errors
    /// The sentence that names what they cannot tell.
    pub fn answer(&self, samples: &Samples) -> Result<Answer, IdentifyError> {
        match self.what {
            IdentifyTarget::Payload if self.from_torques => load::payload_from_torques(samples),
            IdentifyTarget::Payload => load::payload_from_forces(samples),
            IdentifyTarget::Friction => load::friction(samples),
            IdentifyTarget::Sensor => load::sensor(samples, self.at),
            IdentifyTarget::Tool => geometry::tool(samples, self.at, self.orientation),
            IdentifyTarget::Frame => geometry::frame(samples, self.at),
        }
    }
}
