//! Commands that look at programs, cells and builtins without running anything: `check`, `cell`, `builtins`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use controller::options::{HomeJoints, ModelChoice, Tcp};
use messages::LocalizedHelp;

use super::{LogArgs, paths};

/// How findings are printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, LocalizedHelp)]
pub enum FindingFormat {
    /// With the source line and a caret.
    #[zh("带源代码行和插入符")]
    #[default]
    Human,
    /// One JSON object a line.
    #[zh("每行一个 JSON 对象")]
    Json,
}

/// Options of `check`.
#[derive(Args, Clone, Debug, LocalizedHelp)]
pub struct CheckArgs {
    /// Scripts, and folders whose scripts are looked at; - reads stdin
    #[zh("脚本，以及在其中查找脚本的文件夹；- 表示标准输入")]
    #[arg(value_name = "FILE", required = true)]
    pub files: Vec<PathBuf>,
    /// The arm that the scripts are for: what it cannot reach is found as well [default: any arm]
    #[zh("脚本所用的机械臂：它够不到的目标也会被发现 [默认：任意机械臂]")]
    #[arg(long, value_name = "MODEL")]
    pub model: Option<ModelChoice>,
    /// With the source line and a caret for people, or one JSON object a finding and line
    #[zh("给人看的源代码行和插入符，或每个发现一行 JSON 对象")]
    #[arg(
        long,
        value_enum,
        default_value_t,
        value_name = "human|json",
        hide_possible_values = true
    )]
    pub format: FindingFormat,
    /// Run the programs in this cell on an ideal arm as well, as far as they go without help from outside, and tell
    /// the motions that run into something
    #[zh("还在此单元中的理想机械臂上运行程序，直到需要外部帮助为止，并报告与物体相碰的运动")]
    #[arg(long, value_name = "FILE")]
    pub cell: Option<PathBuf>,
    /// With --cell: also tell the motions that come nearer to something than this, m
    #[zh("与 --cell 一起：还报告离物体比这更近的运动，m")]
    #[arg(long, value_name = "M", requires = "cell", value_parser = paths::margin, allow_negative_numbers = true)]
    pub margin: Option<f64>,
    /// With --cell: tool centre point from the flange, m and rad
    #[zh("与 --cell 一起：从法兰到工具中心点，m 和 rad")]
    #[arg(
        long,
        value_name = "x,y,z,rx,ry,rz",
        requires = "cell",
        allow_hyphen_values = true
    )]
    pub tcp: Option<Tcp>,
    /// With --cell: joint positions at start, rad
    #[zh("与 --cell 一起：开始时的关节位置，rad")]
    #[arg(
        long,
        value_name = "q1,…,q6",
        requires = "cell",
        allow_hyphen_values = true
    )]
    pub home: Option<HomeJoints>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
}

/// Options of `cell`.
#[derive(Args, Clone, Debug, LocalizedHelp)]
pub struct CellArgs {
    /// The cell file (TOML)
    #[zh("单元文件（TOML）")]
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Draw the cell from two sides
    #[zh("从两个方向画出单元")]
    #[arg(long, value_name = "OUT.png")]
    pub picture: Option<PathBuf>,
    /// For people, or one JSON object
    #[zh("给人看的文本，或一个 JSON 对象")]
    #[arg(long, value_enum, default_value_t)]
    pub format: FindingFormat,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
}

/// How lists are printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, LocalizedHelp)]
pub enum ListFormat {
    /// Columns.
    #[zh("分列")]
    #[default]
    Table,
    /// One JSON array.
    #[zh("一个 JSON 数组")]
    Json,
}

/// Options of `builtins`.
#[derive(Args, Clone, Debug, LocalizedHelp)]
pub struct BuiltinsArgs {
    /// A function, for everything about it; or words, for the functions that have all of them in name or description
    #[zh("函数名，显示它的全部说明；或若干词，列出名称或说明中含有全部这些词的函数")]
    #[arg(value_name = "NAME|TEXT")]
    pub words: Vec<String>,
    /// Columns for people, or a JSON array
    #[zh("给人看的分列文本，或一个 JSON 数组")]
    #[arg(
        long,
        value_enum,
        default_value_t,
        value_name = "table|json",
        hide_possible_values = true
    )]
    pub format: ListFormat,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
}
