//! Options of the commands that find numbers of an arm in recordings.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use messages::{LocalizedHelp, Text, text};

use super::paths::recorded_time;
use super::{ControllerArgs, FindingFormat, LogArgs};

/// Options of `identify`.
#[derive(Args, Clone, Debug, LocalizedHelp)]
pub struct IdentifyArgs {
    /// What is looked for
    #[zh("要辨识什么")]
    #[arg(value_enum)]
    pub what: IdentifyTarget,
    /// Recordings of `run`, `serve` or `record`
    #[zh("`run`、`serve` 或 `record` 的记录")]
    #[arg(value_name = "FILE.mcap", required = true)]
    pub files: Vec<PathBuf>,
    /// Use what was recorded from this time on, s
    #[zh("只用此时刻之后的记录，s")]
    #[arg(long, value_name = "S", value_parser = recorded_time, allow_negative_numbers = true)]
    pub from: Option<f64>,
    /// Use what was recorded up to this time, s
    #[zh("只用此时刻之前的记录，s")]
    #[arg(long, value_name = "S", value_parser = recorded_time, allow_negative_numbers = true)]
    pub to: Option<f64>,
    /// Payload: from the torques of the joints instead of the force reading
    #[zh("负载：用关节力矩代替力读数")]
    #[arg(long)]
    pub from_torques: bool,
    /// Tool, frame, sensor: the rests at these times, s, instead of every rest
    #[zh("工具、坐标系、传感器：只用这些时刻的静止段，s，而不是所有静止段")]
    #[arg(long, value_name = "T1,T2,…", value_delimiter = ',', value_parser = recorded_time,
        allow_negative_numbers = true)]
    pub at: Vec<f64>,
    /// Tool: the last three rests are the point, the tip moved along tool +x, the tip moved into +y of its xy plane
    #[zh("工具：最后三个静止段依次为该点、尖端沿工具 +x 移动后、尖端移到工具 xy 平面 +y 一侧后")]
    #[arg(long)]
    pub orientation: bool,
    /// For people, or one JSON object
    #[zh("给人看的文本，或一个 JSON 对象")]
    #[arg(long, value_enum, default_value_t)]
    pub format: FindingFormat,
    /// Write the answer as tables of a cell file
    #[zh("把结果写成单元文件的表")]
    #[arg(short, value_name = "FILE.toml")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
}

/// What `identify` finds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, LocalizedHelp)]
pub enum IdentifyTarget {
    /// Mass, centre of gravity and inertia of what hangs on the flange.
    #[zh("法兰上所装物体的质量、重心和惯量")]
    Payload,
    /// Dry and viscous friction of each joint.
    #[zh("各关节的干摩擦和粘性摩擦")]
    Friction,
    /// The TCP, from rests of its tip at one point.
    #[zh("TCP：由尖端停在同一点的各静止段求出")]
    Tool,
    /// A frame, from rests at its origin, on its x axis, in its xy plane.
    #[zh("坐标系：由在原点、x 轴上、xy 平面内的静止段求出")]
    Frame,
    /// Bias of the force sensor, and what hangs below it, from rests.
    #[zh("力传感器的零偏及其下所挂物体：由静止段求出")]
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
#[derive(Args, Clone, Debug, LocalizedHelp)]
pub struct ExciteArgs {
    /// What the motion shall tell
    #[zh("运动要用来辨识什么")]
    #[arg(value_enum)]
    pub what: ExciteTarget,
    /// Factor of the speeds, 0.05 to 1
    #[zh("速度的系数，0.05 到 1")]
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = speed_factor)]
    pub speed: f64,
    /// Where to write the program [default: standard output]
    #[zh("程序写到哪里 [默认：标准输出]")]
    #[arg(short, value_name = "FILE.script")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub shared: ControllerArgs,
}

/// What a motion of `excite` tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, LocalizedHelp)]
pub enum ExciteTarget {
    /// Mass, centre of gravity and inertia of what hangs on the flange.
    #[zh("法兰上所装物体的质量、重心和惯量")]
    Payload,
    /// Dry and viscous friction of each joint.
    #[zh("各关节的干摩擦和粘性摩擦")]
    Friction,
    /// The TCP: the tip stays at one point while the tool turns.
    #[zh("TCP：尖端停在一点，工具绕它转动")]
    Tool,
}

fn speed_factor(text: &str) -> Result<f64, Text> {
    match text.parse() {
        Ok(factor) if (0.05..=1.0).contains(&factor) => Ok(factor),
        _ => Err(text!("allowed are numbers from 0.05 to 1", "允许 0.05 到 1 的数").to_owned()),
    }
}
