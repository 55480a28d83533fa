//! Options of `replay`, and of the ports of `replay --serve`.

use std::net::IpAddr;
use std::path::PathBuf;

use clap::Args;
use messages::{LocalizedHelp, Text, text};

use super::LogArgs;
use super::paths::recorded_time;
use crate::options::{PortSetting, TrustedHost};

/// Options of `replay`; without any of them a summary is printed.
#[derive(Args, Clone, Debug, LocalizedHelp)]
pub struct ReplayArgs {
    /// The recording
    #[zh("记录")]
    #[arg(value_name = "FILE.mcap")]
    pub file: PathBuf,
    /// Print the state at this time, s
    #[zh("打印此时刻的状态，s")]
    #[arg(long, value_name = "T", group = "what", value_parser = recorded_time, allow_negative_numbers = true)]
    pub at: Option<f64>,
    /// Print a topic as a table with one header line
    #[zh("把一个主题打印成带一行表头的表格")]
    #[arg(long, value_name = "TOPIC", group = "what")]
    pub csv: Option<String>,
    /// Draw joint positions, speeds, torques and force over time
    #[zh("画出关节位置、速度、力矩和力随时间的变化")]
    #[arg(long, value_name = "OUT.png", group = "what")]
    pub plot: Option<PathBuf>,
    /// Begin of what --plot draws, s [default: the whole recording]
    #[zh("--plot 所画的开始时刻，s [默认：整个记录]")]
    #[arg(
        long,
        value_name = "T",
        requires = "plot",
        value_parser = recorded_time,
        allow_negative_numbers = true
    )]
    pub from: Option<f64>,
    /// End of what --plot draws, s
    #[zh("--plot 所画的结束时刻，s")]
    #[arg(
        long,
        value_name = "T",
        requires = "plot",
        value_parser = recorded_time,
        allow_negative_numbers = true
    )]
    pub to: Option<f64>,
    /// Write it as a bag of ROS 2 (MCAP, CDR) into this new folder
    #[zh("写成 ROS 2 的 bag（MCAP、CDR），放入这个新文件夹")]
    #[arg(long, value_name = "FOLDER", group = "what")]
    pub rosbag2: Option<PathBuf>,
    /// Print when a condition held, the line and the position then: "safety_mode != normal"
    #[zh("打印条件何时成立，以及当时的行和位置：\"safety_mode != normal\"")]
    #[arg(long, value_name = "CONDITION", group = "what")]
    pub find: Option<String>,
    /// Print the programs, with when each line ran, how often and how long
    #[zh("打印程序，以及每行何时运行、次数和时长")]
    #[arg(long, group = "what")]
    pub script: bool,
    /// Compare with another recording, cycle by cycle. Exit status 1 if they differ
    #[zh("与另一个记录逐周期比较。不同时退出状态为 1")]
    #[arg(long, value_name = "OTHER.mcap", group = "what")]
    pub diff: Option<PathBuf>,
    /// Send the recording through the ports, as if live
    #[zh("像实时一样通过端口发送记录")]
    #[arg(long, group = "what")]
    pub serve: bool,
    /// Run the recorded commands on a fresh controller and compare. Exit status 1 if a cycle differs
    #[zh("在新的控制器上运行所记录的命令并比较。有周期不同时退出状态为 1")]
    #[arg(long, group = "what")]
    pub rerun: bool,
    /// Speed of --serve, 1 is as recorded
    #[zh("--serve 的速度，1 为记录时的速度")]
    #[arg(long, value_name = "X", requires = "serve", default_value_t = 1.0, value_parser = rate)]
    pub rate: f64,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub ports: ReplayPortArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
}

/// Where `replay --serve` listens. The same services as those of `serve`, but for the ones that only take orders.
#[derive(Args, Clone, Debug, Default, LocalizedHelp)]
#[group(requires = "serve")]
#[command(next_help_heading = "Ports of --serve")]
pub struct ReplayPortArgs {
    /// Address that every port listens on [default: 127.0.0.1]
    #[zh("所有端口监听的地址 [默认：127.0.0.1]")]
    #[arg(long, value_name = "ADDR")]
    pub bind: Option<IpAddr>,
    /// Robot state out; scripts are refused [default: 30001]
    #[zh("发送机器人状态；拒绝脚本 [默认：30001]")]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub primary_port: Option<PortSetting>,
    /// Cyclic data out; inputs are refused [default: 30004]
    #[zh("发送周期数据；拒绝输入 [默认：30004]")]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub rtsi_port: Option<PortSetting>,
    /// Health and metrics [default: 8080]
    #[zh("健康状况和指标 [默认：8080]")]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub http_port: Option<PortSetting>,
    /// Live data for the Foxglove app [default: off]
    #[zh("供 Foxglove 应用使用的实时数据 [默认：off]")]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub foxglove_port: Option<PortSetting>,
    /// Robot state as on the primary port, nothing in, in every control mode
    /// [default: 30011; any free port where the primary port is not 30001]
    #[zh(
        "与主端口相同的机器人状态，不接收任何内容，适用于所有控制模式 [默认：30011；主端口不是 30001 时为任一空闲端口]"
    )]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub state_port: Option<PortSetting>,
    /// Another name of this machine, or of a machine whose pages may ask, on the http and Foxglove ports; repeat it for
    /// more [default: this machine's own names]
    #[zh(
        "本机的另一个名称，或其页面可以在 http 和 Foxglove 端口上提问的机器的名称；可重复给出 [默认：本机自己的名称]"
    )]
    #[arg(long, value_name = "NAME")]
    pub trust_host: Option<Vec<TrustedHost>>,
    /// Where to write process id and ports as JSON once every port listens
    #[zh("所有端口开始监听后，把进程号和端口以 JSON 写到哪里")]
    #[arg(long, value_name = "PATH")]
    pub ready_file: Option<PathBuf>,
}

/// A speed of `--serve`.
fn rate(text: &str) -> Result<f64, Text> {
    match text.parse() {
        Ok(rate) if (0.01..=100.0).contains(&rate) => Ok(rate),
        _ => Err(text!(
            "allowed are numbers from 0.01 to 100; 1 is as recorded",
            "允许 0.01 到 100 的数；1 为记录时的速度"
        )
        .to_owned()),
    }
}
