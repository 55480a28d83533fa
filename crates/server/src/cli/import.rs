//! Options of the commands that read programs and toolpaths from elsewhere.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use controller::options::{ModelChoice, Tcp};
use messages::{LocalizedHelp, Text, text};

use super::{FindingFormat, LogArgs};

/// Options of `translate`.
#[derive(Args, Clone, Debug, LocalizedHelp)]
pub struct TranslateArgs {
    /// The program in URScript; - reads it from stdin
    #[zh("URScript 程序；- 表示从标准输入读取")]
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Where to write the translated program [default: standard output]
    #[zh("翻译后的程序写到哪里 [默认：标准输出]")]
    #[arg(short, long, value_name = "FILE.script")]
    pub output: Option<PathBuf>,
    /// Write a page about what was changed and what is missing
    #[zh("写一页报告：改了什么、缺什么")]
    #[arg(long, value_name = "FILE.md")]
    pub report: Option<PathBuf>,
    /// Remarks for people, or one JSON object a remark: line, kind, name, text
    #[zh("给人看的说明，或每条一个 JSON 对象：line、kind、name、text")]
    #[arg(long, value_enum, default_value_t)]
    pub format: FindingFormat,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
}

/// Options of `import`.
#[derive(Args, Clone, Debug, LocalizedHelp)]
pub struct ImportArgs {
    /// The toolpath: .gcode, .nc, .ngc, .dxf or .csv
    #[zh("刀具路径：.gcode、.nc、.ngc、.dxf 或 .csv")]
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Where to write the program [default: standard output]
    #[zh("程序写到哪里 [默认：标准输出]")]
    #[arg(short, long, value_name = "FILE.script")]
    pub output: Option<PathBuf>,
    /// The frame of the file in the base frame, m and rad [default: 0,0,0,0,0,0]
    #[zh("文件的坐标系在基座坐标系中的位姿，m 和 rad [默认：0,0,0,0,0,0]")]
    #[arg(long, value_name = "x,y,z,rx,ry,rz", allow_hyphen_values = true)]
    pub frame: Option<Tcp>,
    /// Where the tool points, in that frame
    #[zh("工具在该坐标系中的指向")]
    #[arg(long, value_name = "x,y,z", default_value = "0,0,-1", allow_hyphen_values = true, value_parser = axis)]
    pub tool_axis: ToolAxis,
    /// Speed at work, m/s [default: that of the file, else 0.05]
    #[zh("加工速度，m/s [默认：文件中的速度，否则 0.05]")]
    #[arg(long, value_name = "V", value_parser = speed, allow_negative_numbers = true)]
    pub speed: Option<f64>,
    /// Factor of the speeds of the file
    #[zh("文件中速度的系数")]
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = factor, allow_negative_numbers = true)]
    pub feed_scale: f64,
    /// How far the path may be from that of the file, m
    #[zh("路径与文件中的路径最多可相差多少，m")]
    #[arg(long, value_name = "D", default_value_t = 0.000_05, value_parser = length, allow_negative_numbers = true)]
    pub tolerance: f64,
    /// A layer of a drawing; repeat it for more [default: all]
    #[zh("图纸的图层；可重复给出 [默认：全部]")]
    #[arg(long, value_name = "NAME")]
    pub layer: Vec<String>,
    /// The line of the program that switches the tool on (M3, M7, M8; begin of a contour)
    #[zh("打开工具的程序行（M3、M7、M8；轮廓开始）")]
    #[arg(long, value_name = "LINE")]
    pub on: Option<String>,
    /// The line that switches it off (M5, M9; end of a contour)
    #[zh("关闭工具的程序行（M5、M9；轮廓结束）")]
    #[arg(long, value_name = "LINE")]
    pub off: Option<String>,
    /// Length of a straight approach against the tool axis, m; in drawings at every contour [default: none]
    #[zh("逆着工具轴线直线进刀的长度，m；图纸中用于每个轮廓 [默认：无]")]
    #[arg(long, value_name = "D", value_parser = length, allow_negative_numbers = true)]
    pub lead_in: Option<f64>,
    /// Unit of the lengths in a table [default: mm]
    #[zh("表格中长度的单位 [默认：mm]")]
    #[arg(long, value_enum)]
    pub units: Option<LengthUnit>,
    /// Check the program, and that the arm reaches every point; status 1 where not
    #[zh("检查程序，并检查机械臂能否到达每个点；不能时状态为 1")]
    #[arg(long)]
    pub check: bool,
    /// Status 1 where something of the file is not understood
    #[zh("文件中有不理解的内容时状态为 1")]
    #[arg(long)]
    pub strict: bool,
    /// The arm that --check asks, and whose rapid moves may go through joint space [default: cs66]
    #[zh("--check 所用的机械臂，快速移动也可按它在关节空间中进行 [默认：cs66]")]
    #[arg(long)]
    pub model: Option<ModelChoice>,
    /// Its tool centre point from the flange, m and rad [default: 0,0,0,0,0,0]
    #[zh("它从法兰到工具中心点的位姿，m 和 rad [默认：0,0,0,0,0,0]")]
    #[arg(long, value_name = "x,y,z,rx,ry,rz", allow_hyphen_values = true)]
    pub tcp: Option<Tcp>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
}

/// A direction of the tool.
#[derive(Clone, Copy, Debug)]
pub struct ToolAxis(pub [f64; 3]);

/// Units of tables.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, LocalizedHelp)]
pub enum LengthUnit {
    /// Millimetres.
    #[zh("毫米")]
    #[default]
    Mm,
    /// Metres.
    #[zh("米")]
    M,
    /// Inches.
    #[zh("英寸")]
    Inch,
}

impl LengthUnit {
    /// In metres.
    pub const fn metres(self) -> f64 {
        match self {
            Self::Mm => 0.001,
            Self::M => 1.0,
            Self::Inch => 0.0254,
        }
    }
}

fn axis(text: &str) -> Result<ToolAxis, Text> {
    let numbers: Vec<f64> = text
        .split(',')
        .filter_map(|number| number.trim().parse().ok())
        .filter(|number: &f64| number.abs() < 1e6)
        .collect();
    match numbers[..] {
        [x, y, z] if x * x + y * y + z * z > 1e-12 => Ok(ToolAxis([x, y, z])),
        _ => Err(text!(
            "three numbers that are not all 0 are needed, as in 0,0,-1",
            "需要三个不全为 0 的数，如 0,0,-1"
        )
        .to_owned()),
    }
}

fn positive(text: &str, unit: &str) -> Result<f64, Text> {
    match text.parse() {
        Ok(number) if number > 0.0 && number <= 1000.0 => Ok(number),
        _ => Err(text!(
            "allowed are numbers above 0, up to 1000{unit}",
            "允许大于 0、不超过 1000{unit} 的数"
        )),
    }
}

fn speed(text: &str) -> Result<f64, Text> {
    positive(text, " m/s")
}

fn factor(text: &str) -> Result<f64, Text> {
    positive(text, "")
}

fn length(text: &str) -> Result<f64, Text> {
    positive(text, " m")
}
