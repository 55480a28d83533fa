//! `eliteserver test`.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};
use messages::{LocalizedHelp, Text, text};
use motion_api::Seconds;

use super::LogArgs;

/// How results are told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, LocalizedHelp)]
pub enum TestFormat {
    /// For people.
    #[zh("给人看")]
    #[default]
    Human,
    /// One JSON object a test and line.
    #[zh("每个测试一行 JSON 对象")]
    Json,
    /// For people, with annotations for GitHub's pages.
    #[zh("给人看，并带 GitHub 页面的注释")]
    Github,
}

/// Options of `test`.
#[derive(Args, Clone, Debug, LocalizedHelp)]
pub struct TestArgs {
    /// Files and folders with tests. The settings of a test are in test.toml beside it, or in a folder above up to the
    /// one named here; its keys are the options of run, timeout and
    /// wall-timeout
    #[zh(
        "含有测试的文件和文件夹。测试的设置在其旁边的 test.toml 中，或在上级文件夹中，直到这里给出的文件夹；其键为 run 的选项、timeout 和 wall-timeout"
    )]
    #[arg(value_name = "PATH", default_value = ".")]
    pub paths: Vec<PathBuf>,
    /// Only tests whose path::name holds this text; one whose name it is exactly runs alone
    #[zh("只运行 path::name 中含有此文本的测试；名称与它完全相同的测试单独运行")]
    #[arg(short = 'k', value_name = "TEXT")]
    pub select: Option<String>,
    /// How many tests run at once [default: one a core]
    #[zh("同时运行多少个测试 [默认：每个核心一个]")]
    #[arg(long, value_name = "N")]
    pub jobs: Option<NonZeroUsize>,
    /// Longest simulated time of a test; over that of test.toml [default: 60]
    #[zh("每个测试的最长仿真时间；优先于 test.toml [默认：60]")]
    #[arg(long, value_name = "S", value_parser = simulated, allow_negative_numbers = true)]
    pub timeout: Option<Seconds>,
    /// Longest time of the machine in which no simulated time passes; over that of test.toml [default: 30]
    #[zh("没有仿真时间经过的最长本机时间；优先于 test.toml [默认：30]")]
    #[arg(long, value_name = "S", value_parser = wall, allow_negative_numbers = true)]
    pub wall_timeout: Option<Duration>,
    /// Seed of the order and of every controller; over that of test.toml [default: 0]
    #[zh("测试顺序和每个控制器的种子；优先于 test.toml [默认：0]")]
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// How results are told
    #[zh("如何报告结果")]
    #[arg(
        long,
        value_name = "human|json|github",
        default_value = "human",
        hide_possible_values = true
    )]
    pub format: TestFormat,
    /// Write the results as JUnit XML
    #[zh("把结果写成 JUnit XML")]
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
    /// Count the executed lines of the programs under test and write them as an lcov trace file
    #[zh("统计被测程序执行过的行，写成 lcov 跟踪文件")]
    #[arg(long, value_name = "FILE")]
    pub coverage: Option<PathBuf>,
    /// Keep the recordings of failed tests in this folder
    #[zh("把失败测试的记录保留在此文件夹")]
    #[arg(long, value_name = "DIR")]
    pub record_failed: Option<PathBuf>,
    /// Keep what is driven now as what path_near() compares with
    #[zh("把现在的运动保存为 path_near() 的比较基准")]
    #[arg(long)]
    pub update: bool,
    /// Only list the tests
    #[zh("只列出测试")]
    #[arg(long)]
    pub list: bool,
    /// Logging.
    #[command(flatten)]
    pub log: LogArgs,
}

/// Longest time that can be asked for, s.
const TIME_MAX: f64 = 1e9;

pub(crate) fn seconds(text: &str) -> Result<f64, Text> {
    let time: Option<f64> = text.parse().ok();
    let time = time.filter(|time| *time > 0.0 && *time <= TIME_MAX);
    time.ok_or_else(|| {
        text!(
            "allowed are seconds above 0, up to {TIME_MAX}",
            "允许大于 0、不超过 {TIME_MAX} 秒"
        )
    })
}

fn simulated(text: &str) -> Result<Seconds, Text> {
    // Above 0 and bounded it is a time.
    Ok(Seconds::new(seconds(text)?).unwrap_or_default())
}

pub(super) fn wall(text: &str) -> Result<Duration, Text> {
    seconds(text).map(Duration::from_secs_f64)
}
