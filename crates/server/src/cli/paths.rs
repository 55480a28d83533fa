//! Commands about clear paths: `clearance`, `plan`, `optimize`, `place`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use controller::options::HomeJoints;
use controller::planned_path::{DEFAULT_ACCELERATION, DEFAULT_SPEED, PathTarget};
use messages::{LocalizedHelp, Text, text};

use super::{ControllerArgs, FindingFormat, RunArgs};

/// Options of `clearance`.
#[derive(Args, Clone, Debug, LocalizedHelp)]
pub struct ClearanceArgs {
    /// The distance that every motion has to keep, m
    #[zh("每个运动必须保持的间隙，m")]
    #[arg(long, value_name = "M", default_value = "0", value_parser = margin, allow_negative_numbers = true)]
    pub margin: f64,
    /// For people, or one JSON object a motion and one for all
    #[zh("给人看的文本，或每个运动一个、总计一个 JSON 对象")]
    #[arg(long, value_enum, default_value_t)]
    pub format: FindingFormat,
    /// Draw the least distance over time
    #[zh("画出最小间隙随时间的变化")]
    #[arg(long, value_name = "FILE.png")]
    pub plot: Option<PathBuf>,
    /// Longest simulated time of the program, s
    #[zh("程序的最长仿真时间，s")]
    #[arg(long, value_name = "S", default_value = "600", value_parser = seconds, allow_negative_numbers = true)]
    pub timeout: f64,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub run: RunArgs,
}

/// Options of `plan`.
#[derive(Args, Clone, Debug, LocalizedHelp)]
pub struct PlanArgs {
    /// Where the path ends: six joint positions in rad, or a pose of the TCP in m and rad, 'p[x,y,z,Rx,Ry,Rz]'
    #[zh("路径的终点：六个关节位置（rad），或 TCP 的位姿（m 和 rad），'p[x,y,z,Rx,Ry,Rz]'")]
    #[arg(long, value_name = "q1,…,q6|p[…]", allow_hyphen_values = true)]
    pub to: PathTarget,
    /// Where the path begins, rad [default: --home]
    #[zh("路径的起点，rad [默认：--home]")]
    #[arg(long, value_name = "q1,…,q6", allow_hyphen_values = true)]
    pub from: Option<HomeJoints>,
    /// Joint positions that the path passes; repeat it for more, in this order
    #[zh("路径经过的关节位置；可重复给出，按此顺序")]
    #[arg(long, value_name = "q1,…,q6", allow_hyphen_values = true)]
    pub via: Vec<HomeJoints>,
    /// The distance that is kept, m
    #[zh("保持的间隙，m")]
    #[arg(long, value_name = "M", default_value = "0.01", value_parser = margin, allow_negative_numbers = true)]
    pub margin: f64,
    /// Longest search, s of this machine's time
    #[zh("最长搜索时间，本机的秒数")]
    #[arg(long, value_name = "S", default_value = "5", value_parser = search_time, allow_negative_numbers = true)]
    pub time: Duration,
    /// Something of the cell that hangs on the flange, as it lies when the arm is at the start
    #[zh("单元中装在法兰上的物体，其位置以机械臂在起点时为准")]
    #[arg(long, value_name = "NAME")]
    pub held: Option<String>,
    /// The last piece is a line along the z axis of the tool of this length, m
    #[zh("最后一段是沿工具 z 轴的直线，长度为此值，m")]
    #[arg(long, value_name = "D", default_value = "0", value_parser = approach, allow_negative_numbers = true)]
    pub approach: f64,
    /// Joint speed of the program, rad/s
    #[zh("程序的关节速度，rad/s")]
    #[arg(long, value_name = "V", default_value_t = DEFAULT_SPEED, value_parser = joint_speed,
        allow_negative_numbers = true)]
    pub speed: f64,
    /// Joint acceleration of the program, rad/s²
    #[zh("程序的关节加速度，rad/s²")]
    #[arg(long, value_name = "A", default_value_t = DEFAULT_ACCELERATION, value_parser = joint_acceleration,
        allow_negative_numbers = true)]
    pub acceleration: f64,
    /// For people, or one JSON object
    #[zh("给人看的文本，或一个 JSON 对象")]
    #[arg(long, value_enum, default_value_t)]
    pub format: FindingFormat,
    /// Write the program there; without it the program is printed
    #[zh("把程序写到此文件；不给出时打印程序")]
    #[arg(short, value_name = "FILE.script")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub shared: ControllerArgs,
}

/// Options of `optimize`.
#[derive(Args, Clone, Debug, LocalizedHelp)]
pub struct OptimizeArgs {
    /// The distance that is kept, m; motions that are nearer already come no nearer
    #[zh("保持的间隙，m；原来更近的运动不会变得更近")]
    #[arg(long, value_name = "M", default_value = "0.005", value_parser = margin, allow_negative_numbers = true)]
    pub margin: f64,
    /// Lines that stay as they are: 12-30, or 12; repeat it for more
    #[zh("保持不变的行：12-30 或 12；可重复给出")]
    #[arg(long, value_name = "FIRST-LAST", value_parser = lines)]
    pub keep: Vec<(u32, u32)>,
    /// Longest simulated time of the program, s
    #[zh("程序的最长仿真时间，s")]
    #[arg(long, value_name = "S", default_value = "600", value_parser = seconds, allow_negative_numbers = true)]
    pub timeout: f64,
    /// Write the program there
    #[zh("把程序写到此文件")]
    #[arg(short, value_name = "FILE.script")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub run: RunArgs,
}

/// Options of `place`.
#[derive(Args, Clone, Debug, LocalizedHelp)]
pub struct PlaceArgs {
    /// TCP poses in the frame of the cell, one a line: x y z Rx Ry Rz, m and rad; # begins a comment
    #[zh("单元坐标系中的 TCP 位姿，每行一个：x y z Rx Ry Rz，m 和 rad；# 之后是注释")]
    #[arg(long, value_name = "FILE")]
    pub points: PathBuf,
    /// The distance that is kept at every point, m
    #[zh("在每个点保持的间隙，m")]
    #[arg(long, value_name = "M", default_value = "0.01", value_parser = margin, allow_negative_numbers = true)]
    pub margin: f64,
    /// Where the base may stand, m [default: as far from the points as the arm reaches]
    #[zh("基座可以放置的区域，m [默认：离各点不超过机械臂的到达距离]")]
    #[arg(long, value_name = "xmin,xmax,ymin,ymax", value_parser = area, allow_hyphen_values = true)]
    pub area: Option<[f64; 4]>,
    /// The base may be turned about its vertical as well
    #[zh("基座也可以绕竖直轴转动")]
    #[arg(long)]
    pub yaw: bool,
    /// For people, or one JSON object
    #[zh("给人看的文本，或一个 JSON 对象")]
    #[arg(long, value_enum, default_value_t)]
    pub format: FindingFormat,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub shared: ControllerArgs,
}

/// Largest margin and approach, m: beyond it nothing can be planned for an arm.
const LENGTH_MAX: f64 = 10.0;
/// Longest simulated time, s.
const SIMULATED_MAX: f64 = 86_400.0;
/// Latest time of a recording that is asked for, s: some thirty years.
const RECORDED_MAX: f64 = 1e9;
/// Longest search, s.
const SEARCH_MAX: f64 = 3600.0;

fn number(text: &str, allowed: core::ops::RangeInclusive<f64>, unit: &str) -> Result<f64, Text> {
    match text.parse() {
        Ok(number) if allowed.contains(&number) => Ok(number),
        _ => Err(text!(
            "allowed are numbers from {} to {} {unit}",
            "允许 {} 到 {} {unit} 的数",
            allowed.start(),
            allowed.end()
        )),
    }
}

/// A time of a recording.
pub(super) fn recorded_time(text: &str) -> Result<f64, Text> {
    number(text, 0.0..=RECORDED_MAX, "s")
}

pub(super) fn margin(text: &str) -> Result<f64, Text> {
    number(text, 0.0..=LENGTH_MAX, "m")
}

fn approach(text: &str) -> Result<f64, Text> {
    number(text, 0.0..=LENGTH_MAX, "m")
}

fn seconds(text: &str) -> Result<f64, Text> {
    number(text, 0.001..=SIMULATED_MAX, "s")
}

fn search_time(text: &str) -> Result<Duration, Text> {
    number(text, 0.001..=SEARCH_MAX, "s").map(Duration::from_secs_f64)
}

fn joint_speed(text: &str) -> Result<f64, Text> {
    number(text, 0.001..=100.0, "rad/s")
}

fn joint_acceleration(text: &str) -> Result<f64, Text> {
    number(text, 0.001..=100.0, "rad/s²")
}

fn lines(text: &str) -> Result<(u32, u32), Text> {
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    match (first.trim().parse(), last.trim().parse()) {
        (Ok(first), Ok(last)) if 1 <= first && first <= last => Ok((first, last)),
        _ => Err(text!(
            "allowed are a line from 1, or the first and the last one, as in 12-30",
            "允许从 1 数起的行号，或首行和末行，如 12-30"
        )
        .to_owned()),
    }
}

fn area(text: &str) -> Result<[f64; 4], Text> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    match numbers.ok().and_then(|numbers| <[f64; 4]>::try_from(numbers).ok()) {
        Some([x_min, x_max, y_min, y_max])
            if x_min <= x_max
                && y_min <= y_max
                && [x_min, x_max, y_min, y_max].iter().all(|x| x.abs() <= 100.0) =>
        {
            Ok([x_min, x_max, y_min, y_max])
        }
        _ => Err(
            text!("four numbers in m are needed, least and largest x, least and largest y, as in -1,1,-0.5,0.5",
                "需要四个以 m 为单位的数：最小和最大 x、最小和最大 y，如 -1,1,-0.5,0.5")
                .to_owned(),
        ),
    }
}
