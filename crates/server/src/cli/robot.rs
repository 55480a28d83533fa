//! Options of the commands at the other end of the wire: `send`, `shell`, `calibrate`, `record`, `compare`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use messages::{LocalizedHelp, Text, text};

use super::LogArgs;
use crate::config::{DASHBOARD_PORT, HTTP_PORT, INTERPRETER_PORT, PRIMARY_PORT, RTSI_PORT};
use crate::options::PortSetting;

/// Options of commands that speak to a robot. Each takes all of them, so that one robot is named in one way, and uses
/// the ports that it needs.
#[derive(Args, Clone, Debug, LocalizedHelp)]
#[command(next_help_heading = "Robot")]
pub struct RemoteRobotArgs {
    /// The robot: a name or an address of a controller, real or ours
    #[zh("机器人：真实或本软件控制器的名称或地址")]
    #[arg(long, value_name = "HOST", default_value = "127.0.0.1")]
    pub robot: String,
    /// Its port for scripts and states
    #[zh("它的脚本和状态端口")]
    #[arg(long, value_name = "PORT", default_value_t = PRIMARY_PORT)]
    pub primary_port: u16,
    /// Its port for statements in interpreter mode
    #[zh("它的解释器模式语句端口")]
    #[arg(long, value_name = "PORT", default_value_t = INTERPRETER_PORT)]
    pub interpreter_port: u16,
    /// Its port for cyclic data
    #[zh("它的周期数据端口")]
    #[arg(long, value_name = "PORT", default_value_t = RTSI_PORT)]
    pub rtsi_port: u16,
    /// Its dashboard, which is asked whether the robot takes programs from outside
    #[zh("它的 dashboard，用来询问机器人是否接受外部程序")]
    #[arg(long, value_name = "PORT", default_value_t = DASHBOARD_PORT)]
    pub dashboard_port: u16,
    /// Do not ask before something may move a robot that is not this machine
    #[zh("在可能使本机以外的机器人运动之前不再询问")]
    #[arg(long)]
    pub yes: bool,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
}

/// Where a controller of ours tells what programs print.
#[derive(Args, Clone, Copy, Debug, Default, LocalizedHelp)]
#[command(next_help_heading = "Robot")]
pub struct OutputArgs {
    /// The http port of a controller of ours, which tells what programs print
    /// [default: 8080; off where the primary port is not 30001]
    #[zh(
        "本软件控制器的 http 端口，用来显示程序打印的内容 [默认：8080；主端口不是 30001 时为 off]"
    )]
    #[arg(long, value_name = "PORT|off")]
    pub http_port: Option<PortSetting>,
}

impl OutputArgs {
    /// The port, if there is one to ask.
    pub fn port(self, robot: &RemoteRobotArgs) -> Option<u16> {
        match self.http_port {
            Some(PortSetting::Number(port)) => Some(port),
            Some(PortSetting::Any | PortSetting::Either(..) | PortSetting::Off) => None,
            None => (robot.primary_port == PRIMARY_PORT).then_some(HTTP_PORT),
        }
    }
}

/// Options of `send`.
#[derive(Args, Clone, Debug, LocalizedHelp)]
pub struct SendArgs {
    /// The script; - reads it from stdin
    #[zh("脚本；- 表示从标准输入读取")]
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// A global variable that is set before the program; repeat it for more: --set speed=0.25 --set 'name="left"'
    #[zh("程序开始前设置的全局变量；可重复给出：--set speed=0.25 --set 'name=\"left\"'")]
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<String>,
    /// Send the text whatever is found in it
    #[zh("不论文本中有什么发现都发送")]
    #[arg(long)]
    pub no_check: bool,
    /// Do not follow the program: end once it is sent
    #[zh("不跟踪程序：发送后即结束")]
    #[arg(long)]
    pub no_wait: bool,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub robot: RemoteRobotArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub output: OutputArgs,
}

/// Options of `shell`.
#[derive(Args, Clone, Debug, LocalizedHelp)]
pub struct ShellArgs {
    /// A global variable of the session; repeat it for more: --set speed=0.25 --set 'name="left"'
    #[zh("会话的全局变量；可重复给出：--set speed=0.25 --set 'name=\"left\"'")]
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<String>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub robot: RemoteRobotArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub output: OutputArgs,
}

/// Options of `calibrate`.
#[derive(Args, Clone, Debug, LocalizedHelp)]
pub struct CalibrateArgs {
    /// The calibration file to write
    #[zh("要写的标定文件")]
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub robot: RemoteRobotArgs,
}

/// Options of `record`.
#[derive(Args, Clone, Debug, LocalizedHelp)]
pub struct RecordArgs {
    /// The recording; an existing file is replaced
    #[zh("记录；已有的文件会被取代")]
    #[arg(long, value_name = "FILE.mcap")]
    pub out: PathBuf,
    /// How often, at most what the controller does
    #[zh("频率，最高为控制器的频率")]
    #[arg(long, value_name = "HZ", default_value_t = robot_client::rtsi::FREQUENCY_MAX, value_parser = record_rate)]
    pub rate: f64,
    /// How long; otherwise until Ctrl-C
    #[zh("时长；不给出时直到 Ctrl-C")]
    #[arg(long, value_name = "S", value_parser = duration)]
    pub duration: Option<f64>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub robot: RemoteRobotArgs,
}

fn record_rate(text: &str) -> Result<f64, Text> {
    let most = robot_client::rtsi::FREQUENCY_MAX;
    let allowed = text!("1 to {most} Hz are allowed", "允许 1 到 {most} Hz");
    let value: f64 = text.parse().map_err(|_| allowed.clone())?;
    match (1.0..=most).contains(&value) {
        true => Ok(value),
        false => Err(allowed),
    }
}

fn duration(text: &str) -> Result<f64, Text> {
    let allowed = text!(
        "a number of seconds above 0 is needed, at most 1e9",
        "需要大于 0、不超过 1e9 的秒数"
    )
    .to_owned();
    let value: f64 = text.parse().map_err(|_| allowed.clone())?;
    match value > 0.0 && value <= 1e9 {
        true => Ok(value),
        false => Err(allowed),
    }
}

/// How a comparison is printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, LocalizedHelp)]
pub enum CompareFormat {
    /// A table.
    #[zh("表格")]
    #[default]
    Human,
    /// One JSON object.
    #[zh("一个 JSON 对象")]
    Json,
}

/// Options of `compare`.
#[derive(Args, Clone, Debug, LocalizedHelp)]
pub struct CompareArgs {
    /// A recording, or a bag of ROS 2: its folder or an MCAP file
    #[zh("一个记录，或一个 ROS 2 bag：其文件夹或 MCAP 文件")]
    #[arg(value_name = "A.mcap")]
    pub first: PathBuf,
    /// Another one
    #[zh("另一个记录")]
    #[arg(
        value_name = "B.mcap",
        required_unless_present = "run",
        conflicts_with = "run"
    )]
    pub second: Option<PathBuf>,
    /// In its place, run this script here with the recording's arm, tool, payload and start position
    #[zh("代替它：在本机以记录的机械臂、工具、负载和起始位置运行此脚本")]
    #[arg(long, value_name = "FILE")]
    pub run: Option<PathBuf>,
    /// Keep the recording of that run
    #[zh("保留那次运行的记录")]
    #[arg(long, value_name = "OUT.mcap", requires = "run")]
    pub keep: Option<PathBuf>,
    /// For people, or one JSON object
    #[zh("给人看的文本，或一个 JSON 对象")]
    #[arg(long, value_enum, default_value_t)]
    pub format: CompareFormat,
    /// A picture of both and of what is between them
    #[zh("画出两者及其差别")]
    #[arg(long, value_name = "OUT.png")]
    pub plot: Option<PathBuf>,
    /// How far any joint may be apart
    #[zh("任一关节最多可相差多少")]
    #[arg(long, value_name = "RAD", value_parser = bound)]
    pub within: Option<f64>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
}

fn bound(text: &str) -> Result<f64, Text> {
    let value = text
        .parse()
        .map_err(|_| text!("a number of rad is needed", "需要以 rad 为单位的数").to_owned())?;
    match (0.0..f64::INFINITY).contains(&value) {
        true => Ok(value),
        false => Err(text!("a number >= 0 is needed", "需要不小于 0 的数").to_owned()),
    }
}
