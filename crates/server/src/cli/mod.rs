//! What users type: commands, options and their help texts.
//!
//! Owns the shape of the command line only. Options keep "not given" apart from "given", so that [`crate::config`] can
//! put a flag over the configuration file over the default; the defaults are written there, the texts here name them.

mod check;
mod chinese;
mod debug;
mod examples;
mod identify;
mod import;
mod paths;
mod refusal;
mod replay;
mod robot;
mod ros2;
mod serve;
mod slots;
mod test;

use std::net::IpAddr;
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use messages::{LocalizedHelp, Text, text};

use elite_runtime::Preset;

use crate::config::PRIMARY_PORT;

pub use self::chinese::parse;
pub use self::ros2::{Ros2Args, RosMiddleware};
pub use check::{BuiltinsArgs, CellArgs, CheckArgs, FindingFormat, ListFormat};
pub use debug::{DebugArgs, DebugRobotArgs};
pub use identify::{ExciteArgs, ExciteTarget, IdentifyArgs, IdentifyTarget};
pub use import::{ImportArgs, TranslateArgs};
pub use paths::{ClearanceArgs, OptimizeArgs, PlaceArgs, PlanArgs};
pub use replay::{ReplayArgs, ReplayPortArgs};
pub use robot::{
    CalibrateArgs, CompareArgs, CompareFormat, RecordArgs, RemoteRobotArgs, SendArgs, ShellArgs,
};
pub use serve::{ControllerArgs, LogArgs, ServeArgs, TextLanguage};
pub(crate) use test::seconds as seconds_of_test;
pub use test::{TestArgs, TestFormat};

/// An open controller for Elite Robots CS arms, with a simulated arm.
///
/// Without a command it starts the controller, as `serve` does.
#[derive(Debug, Parser, LocalizedHelp)]
#[zh(
    "Elite Robots CS 系列机械臂的开放控制器，带仿真机械臂",
    long = "Elite Robots CS 系列机械臂的开放控制器，带仿真机械臂。\n\n不给出命令时启动控制器，与 `serve` 相同。"
)]
#[command(name = "eliteserver", version, args_conflicts_with_subcommands = true)]
pub struct Cli {
    #[command(subcommand)]
    command: Option<CliCommand>,
    #[command(flatten)]
    serve: ServeArgs,
}

impl Cli {
    /// The command; no command means `serve`.
    pub fn into_command(self) -> CliCommand {
        self.command
            .unwrap_or_else(|| CliCommand::Serve(Box::new(self.serve)))
    }
}

/// The commands.
#[derive(Debug, Subcommand, LocalizedHelp)]
pub enum CliCommand {
    /// Start the controller: every service, one simulated arm. Ends with SIGINT or SIGTERM
    #[zh("启动控制器：所有服务和一台仿真机械臂。收到 SIGINT 或 SIGTERM 时结束")]
    #[command(after_help = examples::SERVE)]
    Serve(Box<ServeArgs>),
    /// Run one script to its end without opening ports. Exit status: 0 ended, 1 failed, 2 does not compile
    #[zh("不打开端口，把一个脚本运行到结束。退出状态：0 已结束，1 失败，2 不能编译")]
    #[command(after_help = examples::RUN)]
    Run(Box<RunCommandArgs>),
    /// Parse and check scripts without running them. Exit status: 0 clean, 1 findings, 2 unreadable
    #[zh("只解析和检查脚本，不运行。退出状态：0 没有问题，1 有发现，2 无法读取")]
    #[command(after_help = examples::CHECK)]
    Check(CheckArgs),
    /// Read a cell file: what it describes, which point is connected to what, and what is doubtful.
    /// Exit status: 0 clean, 1 findings, 2 unreadable
    #[zh(
        "读取单元文件：它描述了什么，哪个点与什么相连，有什么可疑之处。退出状态：0 没有问题，1 有发现，2 无法读取"
    )]
    Cell(CellArgs),
    /// Tell how near every motion of a program comes to anything in its cell: the program is run on an ideal arm that
    /// contacts do not stop. Exit status: 0 it keeps the margin, 1 it does not or fails, 2 it cannot be run
    #[zh(
        "报告程序的每个运动离单元中的物体有多近：程序在不因接触而停止的理想机械臂上运行。退出状态：0 间隙足够，1 间隙不足或程序失败，2 无法运行"
    )]
    Clearance(Box<ClearanceArgs>),
    /// Find a way around what is in the way and write it as a program; what comes out was driven on a simulated arm.
    /// Exit status: 0 a path was found, 1 there is none, 2 wrong arguments
    #[zh(
        "求一条绕过障碍的路径并写成程序；结果已在仿真机械臂上运行过。退出状态：0 找到路径，1 没有路径，2 参数错误"
    )]
    Plan(Box<PlanArgs>),
    /// Make a program faster that does the same: speeds, blends, waypoints; every step is proven by running it. Prints
    /// what changed. Exit status: 0 done, also if nothing can be gained, 1 the program fails or touches something as it
    /// is, 2 it cannot be run
    #[zh(
        "把程序改得更快而效果不变：速度、交融、路点；每一步都经运行验证，并打印所作的改动。退出状态：0 完成（没有可加快之处也是 0），1 程序本身失败或碰到物体，2 无法运行"
    )]
    Optimize(Box<OptimizeArgs>),
    /// Find where the base should stand so that the arm reaches all points, far from the ends of its joints' ranges.
    /// Exit status: 0 found, 1 no place fits, 2 wrong arguments
    #[zh(
        "求基座应放在哪里，使机械臂能到达所有点且远离关节范围的边界。退出状态：0 找到，1 没有合适的位置，2 参数错误"
    )]
    Place(Box<PlaceArgs>),
    /// Run the tests of programs: every test_ function of test_*.script and *_test.script files.
    /// Exit status: 0 all passed, 1 some failed, 2 nothing to run
    #[zh(
        "运行程序的测试：test_*.script 和 *_test.script 文件中的每个 test_ 函数。退出状态：0 全部通过，1 有失败，2 没有可运行的测试"
    )]
    #[command(after_help = examples::TEST)]
    Test(TestArgs),
    /// Debug a program forwards and backwards: at the terminal, or from an editor (Debug Adapter Protocol)
    #[zh("正向和反向调试程序：在终端上，或由编辑器（Debug Adapter Protocol）进行")]
    #[command(after_help = examples::DEBUG)]
    Debug(Box<DebugArgs>),
    /// Read a recording: a summary, a state, a table, or run it again
    #[zh("读取记录：摘要、某时刻的状态、表格，或重新运行")]
    #[command(after_help = examples::REPLAY)]
    Replay(ReplayArgs),
    /// List the builtin functions of the script language, search them, or show one. Exit status: 0 shown, 1 none found
    #[zh("列出、查找或显示脚本语言的内置函数。退出状态：0 已显示，1 没有找到")]
    #[command(after_help = examples::BUILTINS)]
    Builtins(BuiltinsArgs),
    /// Send a program to a robot, real or simulated, and follow it. Exit status: 0 ended, 1 failed or stopped, 2 not
    /// sent
    #[zh("把程序发送到真实或仿真的机器人并跟踪它。退出状态：0 已结束，1 失败或被停止，2 没有发送")]
    #[command(after_help = examples::SEND)]
    Send(SendArgs),
    /// Type statements that a robot carries out at once. Exit status: 0, 1 a line of a pipe was discarded or failed, 2
    /// no connection
    #[zh("输入语句，由机器人立即执行。退出状态：0，1 管道中有一行被丢弃或失败，2 没有连接")]
    #[command(after_help = examples::SHELL)]
    Shell(ShellArgs),
    /// Read the arm's own kinematics from a robot into a calibration file. Exit status: 0 written, 2 not
    #[zh("从机器人读取机械臂自身的运动学参数，写入标定文件。退出状态：0 已写入，2 没有写入")]
    #[command(after_help = examples::CALIBRATE)]
    #[command(mut_arg("yes", |arg| arg.hide(true)))]
    #[command(mut_arg("interpreter_port", |arg| arg.hide(true)))]
    #[command(mut_arg("rtsi_port", |arg| arg.hide(true)))]
    #[command(mut_arg("dashboard_port", |arg| arg.hide(true)))]
    Calibrate(CalibrateArgs),
    /// Record what a robot, real or simulated, does. Exit status: 0 recorded, 2 no connection or no recording
    #[zh("记录真实或仿真机器人的动作。退出状态：0 已记录，2 没有连接或没有记录")]
    #[command(after_help = examples::RECORD)]
    #[command(mut_arg("yes", |arg| arg.hide(true)))]
    #[command(mut_arg("interpreter_port", |arg| arg.hide(true)))]
    #[command(mut_arg("dashboard_port", |arg| arg.hide(true)))]
    Record(RecordArgs),
    /// Lay two recordings over each other and tell how far they are apart. Exit status: 0 within the bound, 1 beyond, 2
    /// unreadable
    #[zh("把两个记录叠在一起，报告相差多少。退出状态：0 在界限内，1 超出，2 无法读取")]
    #[command(after_help = examples::COMPARE)]
    Compare(CompareArgs),
    /// Find payload, friction, tool, frame or the bias of the force sensor in recordings. Exit status: 0 found, 1 the
    /// data cannot tell, 2 unreadable
    #[zh(
        "由记录辨识负载、摩擦、工具、坐标系或力传感器的零偏。退出状态：0 找到，1 数据不足以判断，2 无法读取"
    )]
    #[command(after_help = examples::IDENTIFY)]
    Identify(IdentifyArgs),
    /// Write a program whose motion lets `identify` tell. Exit status: 0 written, 2 there is no room for the motion
    #[zh("写一个程序，其运动可供 `identify` 辨识。退出状态：0 已写入，2 没有运动的空间")]
    #[command(after_help = examples::EXCITE)]
    Excite(Box<ExciteArgs>),
    /// Turn a toolpath (G-code, DXF, CSV) into a program. Exit status: 0 done, 1 the path is impossible or, with
    /// --strict, not wholly understood, 2 unreadable
    #[zh(
        "把刀具路径（G 代码、DXF、CSV）变成程序。退出状态：0 完成，1 路径不可行，或用 --strict 时有不理解的内容，2 无法读取"
    )]
    #[command(after_help = examples::IMPORT)]
    Import(Box<ImportArgs>),
    /// Turn a program of Universal Robots (URScript) into one of this controller. Exit status: 0 complete, 1 something
    /// has no counterpart, 2 unreadable
    #[zh(
        "把 Universal Robots 的程序（URScript）变成本控制器的程序。退出状态：0 完整，1 有内容没有对应，2 无法读取"
    )]
    #[command(after_help = examples::TRANSLATE)]
    Translate(TranslateArgs),
    /// The language server for editors, on standard input and output. Exit status: 0 after 'shutdown', 1 the client
    /// vanished
    #[zh(
        "供编辑器使用的语言服务器，通过标准输入输出通信。退出状态：0 收到 'shutdown' 之后，1 客户端消失"
    )]
    Lsp(LspArgs),
    /// Tools for assistants that write robot programs (Model Context Protocol), on standard input and output: check,
    /// run and test programs on a simulated arm, look functions and recordings up. Files are those beneath the folder
    /// it is started in. Exit status: 0 the client has left, 1 it left before it began, 2 it broke the protocol
    #[zh(
        "供编写机器人程序的助手使用的工具（Model Context Protocol），通过标准输入输出通信：在仿真机械臂上检查、运行和测试程序，查询函数和记录。文件限于启动时所在的文件夹之内。\
         退出状态：0 客户端已离开，1 客户端在开始前离开，2 客户端违反协议"
    )]
    Mcp(McpArgs),
    /// Look whether this machine can run the controller as it is set up, and say what to do.
    /// Exit status: 0 it can, 1 something keeps it from running
    #[zh("检查本机能否按设置运行控制器，并说明该怎么做。退出状态：0 能，1 有妨碍运行的问题")]
    #[command(after_help = examples::DOCTOR)]
    Doctor(Box<DoctorArgs>),
    /// Print the completion script of a shell
    #[zh("打印 shell 的补全脚本")]
    #[command(after_help = examples::COMPLETIONS)]
    Completions(CompletionsArgs),
    /// Write the manual pages into a folder
    #[zh("把手册页写入文件夹")]
    Man(ManArgs),
    /// Start many controllers on this machine, a process and an address each, and look after them. SIGHUP restarts one
    /// after the other with the file as it is then. Exit status: 0 after a signal, 2 they cannot be started
    #[zh(
        "在本机启动多个控制器并照看它们，每个各有一个进程和地址。收到 SIGHUP 时按当时的文件逐个重启。退出状态：0 收到信号后，2 无法启动"
    )]
    #[command(after_help = examples::FLEET)]
    Fleet(FleetArgs),
    /// The process of the ROS 2 node, which serve --ros2 starts; nobody else can
    #[zh("ROS 2 节点的进程，由 serve --ros2 启动；其他方式都不能启动")]
    #[command(hide = true)]
    Ros2,
    /// Wait until a server answers. Exit status: 0 it does, 1 it did not in time
    #[zh("等待服务器应答。退出状态：0 已应答，1 未及时应答")]
    #[command(after_help = examples::WAIT)]
    Wait(WaitArgs),
}

impl CliCommand {
    /// The options of logging, of commands that have no configuration file and do log.
    pub const fn log_args(&self) -> Option<&LogArgs> {
        match self {
            Self::Check(args) => Some(&args.log),
            Self::Cell(args) => Some(&args.log),
            Self::Test(args) => Some(&args.log),
            Self::Debug(args) => Some(&args.log),
            Self::Replay(args) => Some(&args.log),
            Self::Builtins(args) => Some(&args.log),
            Self::Send(args) => Some(&args.robot.log),
            Self::Shell(args) => Some(&args.robot.log),
            Self::Calibrate(args) => Some(&args.robot.log),
            Self::Record(args) => Some(&args.robot.log),
            Self::Compare(args) => Some(&args.log),
            Self::Identify(args) => Some(&args.log),
            Self::Import(args) => Some(&args.log),
            Self::Translate(args) => Some(&args.log),
            Self::Lsp(args) => Some(&args.log),
            Self::Mcp(args) => Some(&args.log),
            Self::Fleet(args) => Some(&args.log),
            Self::Wait(args) => Some(&args.log),
            Self::Serve(_)
            | Self::Run(_)
            | Self::Clearance(_)
            | Self::Excite(_)
            | Self::Plan(_)
            | Self::Optimize(_)
            | Self::Place(_)
            | Self::Doctor(_)
            | Self::Completions(_)
            | Self::Ros2
            | Self::Man(_) => None,
        }
    }
}

/// Options of `lsp`.
#[derive(Args, Clone, Debug, Default, LocalizedHelp)]
pub struct LspArgs {
    /// Standard input and output; the only way there is, some editors say so
    #[zh("标准输入输出；这是唯一的方式，有些编辑器会这样给出")]
    #[arg(long)]
    pub stdio: bool,
    /// Process of the editor; the server ends with it, as with the one that 'initialize' names
    #[zh("编辑器的进程；它结束时服务器也结束，与 'initialize' 中给出的进程相同")]
    #[arg(long = "clientProcessId", value_name = "PID", hide = true)]
    pub client: Option<u32>,
    /// Logging.
    #[command(flatten)]
    pub log: LogArgs,
}

/// Options of `fleet`.
#[derive(Args, Clone, Debug, LocalizedHelp)]
pub struct FleetArgs {
    /// Which robots: `[[robot]]` tables with `name`, `bind` and options of `serve`, `[defaults]`
    #[zh("哪些机器人：带 `name`、`bind` 和 `serve` 选项的 `[[robot]]` 表，以及 `[defaults]`")]
    #[arg(value_name = "FILE.toml")]
    pub file: PathBuf,
    /// Look whether the file can be started, and start nothing
    #[zh("只检查文件能否启动，不启动任何控制器")]
    #[arg(long)]
    pub check: bool,
    /// Logging.
    #[command(flatten)]
    pub log: LogArgs,
}

/// Options of `mcp`.
#[derive(Args, Clone, Debug, Default)]
pub struct McpArgs {
    /// Logging.
    #[command(flatten)]
    pub log: LogArgs,
}

/// Options of `doctor`: those of `serve`, whose set-up is looked at.
#[derive(Args, Clone, Debug, Default, LocalizedHelp)]
pub struct DoctorArgs {
    /// The report for people, or as one JSON object
    #[zh("给人看的报告，或一个 JSON 对象")]
    #[arg(
        long,
        value_enum,
        default_value_t,
        value_name = "human|json",
        hide_possible_values = true
    )]
    pub format: FindingFormat,
    /// What would be served.
    #[command(flatten)]
    pub serve: ServeArgs,
}

/// Options of `completions`.
#[derive(Args, Clone, Debug, LocalizedHelp)]
pub struct CompletionsArgs {
    /// The shell
    #[zh("shell 的名称")]
    pub shell: clap_complete::Shell,
}

/// Options of `man`.
#[derive(Args, Clone, Debug, LocalizedHelp)]
pub struct ManArgs {
    /// The folder; it is made where it is not there
    #[zh("文件夹；不存在时新建")]
    #[arg(value_name = "FOLDER")]
    pub folder: PathBuf,
}

/// Options of `run`.
#[derive(Args, Clone, Debug, Default, LocalizedHelp)]
pub struct RunCommandArgs {
    /// Stop the program after this long: simulated seconds, or seconds of the machine in which no simulated time passes
    /// [default: never]
    #[zh("经过这么久后停止程序：仿真时间的秒数，或没有仿真时间经过的本机秒数 [默认：不停止]")]
    #[arg(long, value_name = "S", value_parser = test::wall, allow_negative_numbers = true)]
    pub timeout: Option<std::time::Duration>,
    /// Run the text without a word of what check finds in it
    #[zh("运行时不提示 check 的发现")]
    #[arg(long)]
    pub no_check: bool,
    /// Beside the recording x.mcap write the bag of ROS 2 x: a folder that ros2 bag, rosbags and Foxglove read
    #[zh("在记录 x.mcap 旁写入 ROS 2 bag x：ros2 bag、rosbags 和 Foxglove 可读的文件夹")]
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "true|false")]
    pub ros2_profile: Option<bool>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub run: RunArgs,
}

/// A program, and the robot that it runs on.
#[derive(Args, Clone, Debug, Default, LocalizedHelp)]
pub struct RunArgs {
    /// The script; - reads it from stdin
    #[zh("脚本；- 表示从标准输入读取")]
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// A global variable that is set before the program; repeat it for more: --set speed=0.25 --set 'name="left"'
    #[zh("程序开始前设置的全局变量；可重复给出：--set speed=0.25 --set 'name=\"left\"'")]
    #[arg(long, value_name = "NAME=VALUE", value_parser = preset)]
    pub set: Vec<Preset>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub shared: ControllerArgs,
}

/// A global of `--set`.
fn preset(text: &str) -> Result<Preset, Text> {
    Preset::parse(text).map_err(|error| error.why)
}

/// Options about the robot, together in help texts.
pub(super) const ROBOT: &str = "Robot";

/// Options of `wait`.
#[derive(Args, Clone, Debug, LocalizedHelp)]
pub struct WaitArgs {
    /// The primary port of the server
    #[zh("服务器的主端口")]
    #[arg(long, default_value_t = PRIMARY_PORT)]
    pub port: u16,
    /// How long to wait, s
    #[zh("等待多久，s")]
    #[arg(long, value_name = "S", default_value = "10", value_parser = seconds, allow_negative_numbers = true)]
    pub timeout: std::time::Duration,
    /// Where the server runs
    #[zh("服务器在哪里运行")]
    #[arg(long, value_name = "ADDR", default_value = "127.0.0.1")]
    pub host: IpAddr,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
}

/// A time in seconds, not negative and at most a day.
fn seconds(text: &str) -> Result<std::time::Duration, Text> {
    match text.parse() {
        Ok(secs) if (0.0..=86_400.0).contains(&secs) => {
            Ok(std::time::Duration::from_secs_f64(secs))
        }
        _ => Err(text!("allowed are seconds from 0 to 86400", "允许 0 到 86400 秒").to_owned()),
    }
}

#[cfg(test)]
mod tests;
