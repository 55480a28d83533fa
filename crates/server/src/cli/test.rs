//! `eliteserver test`.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};
use motion_api::Seconds;

use super::LogArgs;

/// How results are told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum TestFormat {
    /// For people.
    #[default]
    Human,
    /// One JSON object a test and line.
    Json,
    /// For people, with annotations for GitHub's pages.
    Github,
}

/// Options of `test`.
#[derive(Args, Clone, Debug)]
pub struct TestArgs {
    /// Files and folders with tests. The settings of a test are in test.toml beside it, or in a folder above up to the
    /// one named here; its keys are the options of run, timeout and
    /// wall-timeout
    #[arg(value_name = "PATH", default_value = ".")]
    pub paths: Vec<PathBuf>,
    /// Only tests whose path::name holds this text; one whose name it is exactly runs alone
    #[arg(short = 'k', value_name = "TEXT")]
    pub select: Option<String>,
    /// How many tests run at once [default: one a core]
    #[arg(long, value_name = "N")]
    pub jobs: Option<NonZeroUsize>,
    /// Longest simulated time of a test; over that of test.toml [default: 60]
    #[arg(long, value_name = "S", value_parser = simulated, allow_negative_numbers = true)]
    pub timeout: Option<Seconds>,
    /// Longest time of the machine in which no simulated time passes; over that of test.toml [default: 30]
    #[arg(long, value_name = "S", value_parser = wall, allow_negative_numbers = true)]
    pub wall_timeout: Option<Duration>,
    /// Seed of the order and of every controller; over that of test.toml [default: 0]
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// How results are told
    #[arg(
        long,
        value_name = "human|json|github",
        default_value = "human",
        hide_possible_values = true
    )]
    pub format: TestFormat,
    /// Write the results as JUnit XML
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
    /// Count the executed lines of the programs under test and write them as an lcov trace file
    #[arg(long, value_name = "FILE")]
    pub coverage: Option<PathBuf>,
    /// Keep the recordings of failed tests in this folder
    #[arg(long, value_name = "DIR")]
    pub record_failed: Option<PathBuf>,
    /// Keep what is driven now as what path_near() compares with
    #[arg(long)]
    pub update: bool,
    /// Only list the tests
    #[arg(long)]
    pub list: bool,
    /// Logging.
    #[command(flatten)]
    pub log: LogArgs,
}

/// Longest time that can be asked for, s.
const TIME_MAX: f64 = 1e9;

pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    let time: Option<f64> = text.parse().ok();
    let time = time.filter(|time| *time > 0.0 && *time <= TIME_MAX);
    time.ok_or_else(|| format!("allowed are seconds above 0, up to {TIME_MAX}"))
}

fn simulated(text: &str) -> Result<Seconds, String> {
    // Above 0 and bounded it is a time.
    Ok(Seconds::new(seconds(text)?).unwrap_or_default())
}

pub(super) fn wall(text: &str) -> Result<Duration, String> {
    seconds(text).map(Duration::from_secs_f64)
}
