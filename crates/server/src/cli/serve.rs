//! `serve`, and the options that it shares with other commands.

use std::net::IpAddr;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use controller::options::ControllerOptions;
use messages::{LocalizedHelp, Text, text};

use super::{ROBOT, Ros2Args};
use crate::options::{ControlChoice, LogFormat, PortSetting, TrustedHost};

/// Options of logging.
#[derive(Args, Clone, Debug, Default, LocalizedHelp)]
#[command(next_help_heading = "Messages")]
pub struct LogArgs {
    /// Log lines on stderr for people (text) or machines (json) [default: text]. RUST_LOG filters them
    #[zh("标准错误上的日志行，给人看（text）或给机器看（json）[默认：text]。由 RUST_LOG 过滤")]
    #[arg(long, value_name = "text|json")]
    pub log_format: Option<LogFormat>,
    /// The language of findings, errors, stops and, for editors, of hover texts: en or zh
    /// [default: that of LANG; for editors that of the client's locale]
    #[zh(
        "发现、错误、停止以及编辑器悬停文本的语言：en 或 zh [默认：LANG 的语言；编辑器用客户端的语言]"
    )]
    #[arg(long, value_name = "en|zh", hide_possible_values = true)]
    pub language: Option<TextLanguage>,
}

/// A language of texts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, LocalizedHelp)]
pub enum TextLanguage {
    /// English.
    #[zh("英文")]
    En,
    /// Chinese.
    #[zh("中文")]
    Zh,
}

impl std::str::FromStr for TextLanguage {
    type Err = Text;

    fn from_str(text: &str) -> Result<Self, Text> {
        ValueEnum::from_str(text, false)
            .map_err(|_| text!("allowed are en and zh", "允许 en 和 zh").to_owned())
    }
}

/// Options of `serve` and `run`.
#[derive(Args, Clone, Debug, Default, LocalizedHelp)]
#[command(next_help_heading = ROBOT)]
pub struct ControllerArgs {
    /// A TOML file whose keys are the names of these options; options given here come first
    #[zh("TOML 文件，其键就是这些选项的名称；这里给出的选项优先")]
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub options: ControllerOptions,
    /// Folder for the log files that the vendor's controller writes [default: not written]
    #[zh("放置厂家控制器所写日志文件的文件夹 [默认：不写]")]
    #[arg(long, value_name = "PATH")]
    pub log_dir: Option<PathBuf>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
}

/// Options of `serve`.
#[derive(Args, Clone, Debug, Default, LocalizedHelp)]
#[command(next_help_heading = "Ports and server")]
pub struct ServeArgs {
    /// Address that every port listens on [default: 127.0.0.1]
    #[zh("所有端口监听的地址 [默认：127.0.0.1]")]
    #[arg(long, value_name = "ADDR")]
    pub bind: Option<IpAddr>,
    /// Scripts in, robot state out; 0: any free port, off: not started [default: 30001]
    #[zh("接收脚本，发送机器人状态；0：任一空闲端口，off：不启动 [默认：30001]")]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub primary_port: Option<PortSetting>,
    /// Statements for interpreter mode [default: 30020]
    #[zh("解释器模式的语句 [默认：30020]")]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub interpreter_port: Option<PortSetting>,
    /// Cyclic data in both directions [default: 30004]
    #[zh("双向周期数据 [默认：30004]")]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub rtsi_port: Option<PortSetting>,
    /// One-line commands of the dashboard [default: 29999]
    #[zh("dashboard 的单行命令 [默认：29999]")]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub dashboard_port: Option<PortSetting>,
    /// The controller's own Modbus server [default: 502 where this user may open it, else 5020]
    #[zh("控制器自身的 Modbus 服务器 [默认：此用户可以打开时为 502，否则 5020]")]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub modbus_port: Option<PortSetting>,
    /// Health and metrics [default: 8080]
    #[zh("健康状况和指标 [默认：8080]")]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub http_port: Option<PortSetting>,
    /// Live data for the Foxglove app, read-only [default: off]
    #[zh("供 Foxglove 应用使用的实时数据，只读 [默认：off]")]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub foxglove_port: Option<PortSetting>,
    /// Robot state as on the primary port, nothing in, in every control mode
    /// [default: 30011; any free port where the primary port is not 30001]
    #[zh(
        "与主端口相同的机器人状态，不接收任何内容，适用于所有控制模式 [默认：30011；主端口不是 30001 时为任一空闲端口]"
    )]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub state_port: Option<PortSetting>,
    /// Single lines of script in, their values out [default: 40011; any free port where the primary port is not 30001]
    #[zh("接收单行脚本，返回其值 [默认：40011；主端口不是 30001 时为任一空闲端口]")]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub query_port: Option<PortSetting>,
    /// The serial line at the tool, bytes both ways, with the settings that a program gives it [default: off]
    #[zh("工具端的串口，双向字节，采用程序给出的设置 [默认：off]")]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub tool_serial_port: Option<PortSetting>,
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
    /// Begin cycles this long after a multiple of the step on the machine's clock, µs, so that several controllers on
    /// one machine do not all wake at once [default: when it starts]
    #[zh(
        "每个周期在本机时钟的步长倍数之后这么久开始，µs，使同一台机器上的多个控制器不会同时醒来 [默认：启动的时刻]"
    )]
    #[arg(long, value_name = "US")]
    pub cycle_phase_us: Option<u32>,
    /// End in an orderly way when standard input is closed: for whoever starts the server and may vanish
    #[zh("标准输入关闭时有序结束：供启动服务器后可能消失的程序使用")]
    #[arg(long)]
    pub until_stdin_closes: bool,
    /// Start with the power off and the brakes engaged, as a real controller does
    #[zh("启动时断电并抱闸，与真实控制器相同")]
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "true|false")]
    pub powered_off: Option<bool>,
    /// Watch every program from its start, so that a debugger may attach to one that has begun; programs compute slower
    /// then
    #[zh("从一开始就监视每个程序，使调试器可以附加到已开始的程序；程序的计算因此变慢")]
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "true|false")]
    pub attachable: Option<bool>,
    /// Who controls the robot at start: the network (remote), the pendant alone (local), or the pendant with remote
    /// control switched off in the settings, as it leaves the factory (mixed) [default: remote]
    #[zh(
        "启动时由谁控制机器人：网络（remote）、仅示教器（local），或设置中关闭了远程控制的示教器，即出厂状态（mixed）[默认：remote]"
    )]
    #[arg(long, value_name = "remote|local|mixed")]
    pub control: Option<ControlChoice>,
    /// Short for --control local: scripts are refused, and clients of the primary port are closed
    #[zh("--control local 的简写：拒绝脚本，并关闭主端口的客户端")]
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "true|false")]
    pub local: Option<bool>,
    // Options after flattened ones would stand under the heading of these.
    #[command(flatten)]
    #[allow(missing_docs)]
    pub ros2: Ros2Args,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub shared: ControllerArgs,
    /// The key `ros2-profile` of the configuration file, which is for `run`.
    #[arg(skip)]
    pub ros2_profile: Option<bool>,
}
