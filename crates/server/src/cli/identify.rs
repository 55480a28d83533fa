//! Options of the commands that find numbers of an arm in recordings.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::paths::recorded_time;
use super::{ControllerArgs, FindingFormat, LogArgs};

/// Options of `identify`.
#[derive(Args, Clone, Debug)]
pub struct IdentifyArgs {
    /// What is looked for
    #[arg(value_enum)]
    pub what: IdentifyTarget,
    /// Recordings of `run`, `serve` or `record`
    #[arg(value_name = "FILE.mcap", required = true)]
    pub files: Vec<PathBuf>,
    /// Use what was recorded from this time on, s
    #[arg(long, value_name = "S", value_parser = recorded_time, allow_negative_numbers = true)]
    pub from: Option<f64>,
    /// Use what was recorded up to this time, s
    #[arg(long, value_name = "S", value_parser = recorded_time, allow_negative_numbers = true)]
    pub to: Option<f64>,
    /// Payload: from the torques of the joints instead of the force reading
    #[arg(long)]
    pub from_torques: bool,
    /// Tool, frame, sensor: the rests at these times, s, instead of every rest
    #[arg(long, value_name = "T1,T2,…", value_delimiter = ',', value_parser = recorded_time, allow_negative_numbers = true)]
    pub at: Vec<f64>,
    /// Tool: the last three rests are the point, the tip moved along tool +x, the tip moved into +y of its xy plane
    #[arg(long)]
    pub orientation: bool,
    /// For people, or one JSON object
    #[arg(long, value_enum, default_value_t)]
    pub format: FindingFormat,
    /// Write the answer as tables of a cell file
    #[arg(short, value_name = "FILE.toml")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
}

/// What `identify` finds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum IdentifyTarget {
    /// Mass, centre of gravity and inertia of what hangs on the flange.
    Payload,
    /// Dry and viscous friction of each joint.
    Friction,
    /// The TCP, from rests of its tip at one point.
    Tool,
    /// A frame, from rests at its origin, on its x axis, in its xy plane.
    Frame,
    /// Bias of the force sensor, and what hangs below it, from rests.
    Sensor,
}

impl IdentifyTarget {
    /// The word that stands for the target on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Payload => "payload",
            Self::Friction => "friction",
            Self::Tool => "tool",
            Self::Frame => "frame",
            Self::Sensor => "sensor",
        }
    }
}

/// Options of `excite`.
#[derive(Args, Clone, Debug)]
pub struct ExciteArgs {
    /// What the motion shall tell
    #[arg(value_enum)]
    pub what: ExciteTarget,
    /// Factor of the speeds, 0.05 to 1
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = speed_factor)]
    pub speed: f64,
    /// Where to write the program [default: standard output]
    #[arg(short, value_name = "FILE.script")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub shared: ControllerArgs,
}

/// What a motion of `excite` tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ExciteTarget {
    /// Mass, centre of gravity and inertia of what hangs on the flange.
    Payload,
    /// Dry and viscous friction of each joint.
    Friction,
    /// The TCP: the tip stays at one point while the tool turns.
    Tool,
}

fn speed_factor(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(factor) if (0.05..=1.0).contains(&factor) => Ok(factor),
        _ => Err("allowed are numbers from 0.05 to 1".to_owned()),
    }
}
