//! What users type: commands, options and their help texts.
//!
//! Owns the shape of the command line only. Options keep "not given" apart from "given", so that [`crate::config`] can
//! put a flag over the configuration file over the default; the defaults are written there, the texts here name them.

mod chinese;
mod debug;
mod examples;
mod identify;
mod import;
mod paths;
mod replay;
mod robot;
mod ros2;
mod slots;
mod test;

use std::net::IpAddr;
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

use controller::options::{ControllerOptions, HomeJoints, ModelChoice, Tcp};
use elite_runtime::Preset;

use crate::config::PRIMARY_PORT;
use crate::options::{ControlChoice, LogFormat, PortSetting, TrustedHost};

pub use self::chinese::parse;
pub use self::ros2::{Ros2Args, RosMiddleware};
pub use debug::{DebugArgs, DebugRobotArgs};
pub use identify::{ExciteArgs, ExciteTarget, IdentifyArgs, IdentifyTarget};
pub use import::{ImportArgs, TranslateArgs};
pub use paths::{ClearanceArgs, OptimizeArgs, PlaceArgs, PlanArgs};
pub use replay::{ReplayArgs, ReplayPortArgs};
pub use robot::{
    CalibrateArgs, CompareArgs, CompareFormat, RecordArgs, RemoteRobotArgs, SendArgs, ShellArgs,
};
pub(crate) use test::seconds as seconds_of_test;
pub use test::{TestArgs, TestFormat};

/// An open controller for Elite Robots CS arms, with a simulated arm.
///
/// Without a command it starts the controller, as `serve` does.
#[derive(Debug, Parser)]
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
#[derive(Debug, Subcommand)]
pub enum CliCommand {
    /// Start the controller: every service, one simulated arm. Ends with SIGINT or SIGTERM
    #[command(after_help = examples::SERVE)]
    Serve(Box<ServeArgs>),
    /// Run one script to its end without opening ports. Exit status: 0 ended, 1 failed, 2 does not compile
    #[command(after_help = examples::RUN)]
    Run(Box<RunCommandArgs>),
    /// Parse and check scripts without running them. Exit status: 0 clean, 1 findings, 2 unreadable
    #[command(after_help = examples::CHECK)]
    Check(CheckArgs),
    /// Read a cell file: what it describes, which point is connected to what, and what is doubtful.
    /// Exit status: 0 clean, 1 findings, 2 unreadable
    Cell(CellArgs),
    /// Tell how near every motion of a program comes to anything in its cell: the program is run on an ideal arm that
    /// contacts do not stop. Exit status: 0 it keeps the margin, 1 it does not or fails, 2 it cannot be run
    Clearance(Box<ClearanceArgs>),
    /// Find a way around what is in the way and write it as a program; what comes out was driven on a simulated arm.
    /// Exit status: 0 a path was found, 1 there is none, 2 wrong arguments
    Plan(Box<PlanArgs>),
    /// Make a program faster that does the same: speeds, blends, waypoints; every step is proven by running it. Prints
    /// what changed. Exit status: 0 done, also if nothing can be gained, 1 the program fails or touches something as it
    /// is, 2 it cannot be run
    Optimize(Box<OptimizeArgs>),
    /// Find where the base should stand so that the arm reaches all points, far from the ends of its joints' ranges.
    /// Exit status: 0 found, 1 no place fits, 2 wrong arguments
    Place(Box<PlaceArgs>),
    /// Run the tests of programs: every test_ function of test_*.script and *_test.script files.
    /// Exit status: 0 all passed, 1 some failed, 2 nothing to run
    #[command(after_help = examples::TEST)]
    Test(TestArgs),
    /// Debug a program forwards and backwards: at the terminal, or from an editor (Debug Adapter Protocol)
    #[command(after_help = examples::DEBUG)]
    Debug(Box<DebugArgs>),
    /// Read a recording: a summary, a state, a table, or run it again
    #[command(after_help = examples::REPLAY)]
    Replay(ReplayArgs),
    /// List the builtin functions of the script language, search them, or show one. Exit status: 0 shown, 1 none found
    #[command(after_help = examples::BUILTINS)]
    Builtins(BuiltinsArgs),
    /// Send a program to a robot, real or simulated, and follow it. Exit status: 0 ended, 1 failed or stopped, 2 not
    /// sent
    #[command(after_help = examples::SEND)]
    Send(SendArgs),
    /// Type statements that a robot carries out at once. Exit status: 0, 1 a line of a pipe was discarded or failed, 2
    /// no connection
    #[command(after_help = examples::SHELL)]
    Shell(ShellArgs),
    /// Read the arm's own kinematics from a robot into a calibration file. Exit status: 0 written, 2 not
    #[command(after_help = examples::CALIBRATE)]
    #[command(mut_arg("yes", |arg| arg.hide(true)))]
    #[command(mut_arg("interpreter_port", |arg| arg.hide(true)))]
    #[command(mut_arg("rtsi_port", |arg| arg.hide(true)))]
    #[command(mut_arg("dashboard_port", |arg| arg.hide(true)))]
    Calibrate(CalibrateArgs),
    /// Record what a robot, real or simulated, does. Exit status: 0 recorded, 2 no connection or no recording
    #[command(after_help = examples::RECORD)]
    #[command(mut_arg("yes", |arg| arg.hide(true)))]
    #[command(mut_arg("interpreter_port", |arg| arg.hide(true)))]
    #[command(mut_arg("dashboard_port", |arg| arg.hide(true)))]
    Record(RecordArgs),
    /// Lay two recordings over each other and tell how far they are apart. Exit status: 0 within the bound, 1 beyond, 2
    /// unreadable
    #[command(after_help = examples::COMPARE)]
    Compare(CompareArgs),
    /// Find payload, friction, tool, frame or the bias of the force sensor in recordings. Exit status: 0 found, 1 the
    /// data cannot tell, 2 unreadable
    #[command(after_help = examples::IDENTIFY)]
    Identify(IdentifyArgs),
    /// Write a program whose motion lets `identify` tell. Exit status: 0 written, 2 there is no room for the motion
    #[command(after_help = examples::EXCITE)]
    Excite(Box<ExciteArgs>),
    /// Turn a toolpath (G-code, DXF, CSV) into a program. Exit status: 0 done, 1 the path is impossible or, with
    /// --strict, not wholly understood, 2 unreadable
    #[command(after_help = examples::IMPORT)]
    Import(Box<ImportArgs>),
    /// Turn a program of Universal Robots (URScript) into one of this controller. Exit status: 0 complete, 1 something
    /// has no counterpart, 2 unreadable
    #[command(after_help = examples::TRANSLATE)]
    Translate(TranslateArgs),
    /// The language server for editors, on standard input and output. Exit status: 0 after 'shutdown', 1 the client
    /// vanished
    Lsp(LspArgs),
    /// Tools for assistants that write robot programs (Model Context Protocol), on standard input and output: check,
    /// run and test programs on a simulated arm, look functions and recordings up. Files are those beneath the folder
    /// it is started in. Exit status: 0 the client has left, 1 it left before it began, 2 it broke the protocol
    Mcp(McpArgs),
    /// Look whether this machine can run the controller as it is set up, and say what to do.
    /// Exit status: 0 it can, 1 something keeps it from running
    #[command(after_help = examples::DOCTOR)]
    Doctor(Box<DoctorArgs>),
    /// Print the completion script of a shell
    #[command(after_help = examples::COMPLETIONS)]
    Completions(CompletionsArgs),
    /// Write the manual pages into a folder
    Man(ManArgs),
    /// Start many controllers on this machine, a process and an address each, and look after them. SIGHUP restarts one
    /// after the other with the file as it is then. Exit status: 0 after a signal, 2 they cannot be started
    #[command(after_help = examples::FLEET)]
    Fleet(FleetArgs),
    /// The process of the ROS 2 node, which serve --ros2 starts; nobody else can
    #[command(hide = true)]
    Ros2,
    /// Wait until a server answers. Exit status: 0 it does, 1 it did not in time
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

/// Options of logging.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Messages")]
pub struct LogArgs {
    /// Log lines on stderr for people (text) or machines (json) [default: text]. RUST_LOG filters them
    #[arg(long, value_name = "text|json")]
    pub log_format: Option<LogFormat>,
    /// The language of findings, errors, stops and, for editors, of hover texts: en or zh
    /// [default: that of LANG; for editors that of the client's locale]
    #[arg(long, value_name = "en|zh", hide_possible_values = true)]
    pub language: Option<TextLanguage>,
}

/// Options of `lsp`.
#[derive(Args, Clone, Debug, Default)]
pub struct LspArgs {
    /// Standard input and output; the only way there is, some editors say so
    #[arg(long)]
    pub stdio: bool,
    /// Process of the editor; the server ends with it, as with the one that 'initialize' names
    #[arg(long = "clientProcessId", value_name = "PID", hide = true)]
    pub client: Option<u32>,
    /// Logging.
    #[command(flatten)]
    pub log: LogArgs,
}

/// Options of `fleet`.
#[derive(Args, Clone, Debug)]
pub struct FleetArgs {
    /// Which robots: `[[robot]]` tables with `name`, `bind` and options of `serve`, `[defaults]`
    #[arg(value_name = "FILE.toml")]
    pub file: PathBuf,
    /// Look whether the file can be started, and start nothing
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

/// A language of texts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TextLanguage {
    /// English.
    En,
    /// Chinese.
    Zh,
}

impl std::str::FromStr for TextLanguage {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        ValueEnum::from_str(text, false).map_err(|_| "allowed are en and zh".to_owned())
    }
}

/// Options of `serve` and `run`.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = ROBOT)]
pub struct ControllerArgs {
    /// A TOML file whose keys are the names of these options; options given here come first
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub options: ControllerOptions,
    /// Folder for the log files that the vendor's controller writes [default: not written]
    #[arg(long, value_name = "PATH")]
    pub log_dir: Option<PathBuf>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
}

/// Options of `serve`.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Ports and server")]
pub struct ServeArgs {
    /// Address that every port listens on [default: 127.0.0.1]
    #[arg(long, value_name = "ADDR")]
    pub bind: Option<IpAddr>,
    /// Scripts in, robot state out; 0: any free port, off: not started [default: 30001]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub primary_port: Option<PortSetting>,
    /// Statements for interpreter mode [default: 30020]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub interpreter_port: Option<PortSetting>,
    /// Cyclic data in both directions [default: 30004]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub rtsi_port: Option<PortSetting>,
    /// One-line commands of the dashboard [default: 29999]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub dashboard_port: Option<PortSetting>,
    /// The controller's own Modbus server [default: 502 where this user may open it, else 5020]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub modbus_port: Option<PortSetting>,
    /// Health and metrics [default: 8080]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub http_port: Option<PortSetting>,
    /// Live data for the Foxglove app, read-only [default: off]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub foxglove_port: Option<PortSetting>,
    /// Robot state as on the primary port, nothing in, in every control mode
    /// [default: 30011; any free port where the primary port is not 30001]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub state_port: Option<PortSetting>,
    /// Single lines of script in, their values out [default: 40011; any free port where the primary port is not 30001]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub query_port: Option<PortSetting>,
    /// The serial line at the tool, bytes both ways, with the settings that a program gives it [default: off]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub tool_serial_port: Option<PortSetting>,
    /// Another name of this machine, or of a machine whose pages may ask, on the http and Foxglove ports; repeat it for
    /// more [default: this machine's own names]
    #[arg(long, value_name = "NAME")]
    pub trust_host: Option<Vec<TrustedHost>>,
    /// Where to write process id and ports as JSON once every port listens
    #[arg(long, value_name = "PATH")]
    pub ready_file: Option<PathBuf>,
    /// Begin cycles this long after a multiple of the step on the machine's clock, µs, so that several controllers on
    /// one machine do not all wake at once [default: when it starts]
    #[arg(long, value_name = "US")]
    pub cycle_phase_us: Option<u32>,
    /// End in an orderly way when standard input is closed: for whoever starts the server and may vanish
    #[arg(long)]
    pub until_stdin_closes: bool,
    /// Start with the power off and the brakes engaged, as a real controller does
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "true|false")]
    pub powered_off: Option<bool>,
    /// Watch every program from its start, so that a debugger may attach to one that has begun; programs compute slower
    /// then
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "true|false")]
    pub attachable: Option<bool>,
    /// Who controls the robot at start: the network (remote), the pendant alone (local), or the pendant with remote
    /// control switched off in the settings, as it leaves the factory (mixed) [default: remote]
    #[arg(long, value_name = "remote|local|mixed")]
    pub control: Option<ControlChoice>,
    /// Short for --control local: scripts are refused, and clients of the primary port are closed
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

/// Options of `doctor`: those of `serve`, whose set-up is looked at.
#[derive(Args, Clone, Debug, Default)]
pub struct DoctorArgs {
    /// The report for people, or as one JSON object
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
#[derive(Args, Clone, Debug)]
pub struct CompletionsArgs {
    /// The shell
    pub shell: clap_complete::Shell,
}

/// Options of `man`.
#[derive(Args, Clone, Debug)]
pub struct ManArgs {
    /// The folder; it is made where it is not there
    #[arg(value_name = "FOLDER")]
    pub folder: PathBuf,
}

/// Options of `run`.
#[derive(Args, Clone, Debug, Default)]
pub struct RunCommandArgs {
    /// Stop the program after this long: simulated seconds, or seconds of the machine in which no simulated time passes
    /// [default: never]
    #[arg(long, value_name = "S", value_parser = test::wall, allow_negative_numbers = true)]
    pub timeout: Option<std::time::Duration>,
    /// Run the text without a word of what check finds in it
    #[arg(long)]
    pub no_check: bool,
    /// Beside the recording x.mcap write the bag of ROS 2 x: a folder that ros2 bag, rosbags and Foxglove read
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "true|false")]
    pub ros2_profile: Option<bool>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub run: RunArgs,
}

/// A program, and the robot that it runs on.
#[derive(Args, Clone, Debug, Default)]
pub struct RunArgs {
    /// The script; - reads it from stdin
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// A global variable that is set before the program; repeat it for more: --set speed=0.25 --set 'name="left"'
    #[arg(long, value_name = "NAME=VALUE", value_parser = preset)]
    pub set: Vec<Preset>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub shared: ControllerArgs,
}

/// A global of `--set`.
fn preset(text: &str) -> Result<Preset, &'static str> {
    Preset::parse(text).map_err(|error| error.why)
}

/// How findings are printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum FindingFormat {
    /// With the source line and a caret.
    #[default]
    Human,
    /// One JSON object a line.
    Json,
}

/// Options of `check`.
#[derive(Args, Clone, Debug)]
pub struct CheckArgs {
    /// Scripts, and folders whose scripts are looked at; - reads stdin
    #[arg(value_name = "FILE", required = true)]
    pub files: Vec<PathBuf>,
    /// The arm that the scripts are for: what it cannot reach is found as well [default: any arm]
    #[arg(long, value_name = "MODEL")]
    pub model: Option<ModelChoice>,
    /// With the source line and a caret for people, or one JSON object a finding and line
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
    #[arg(long, value_name = "FILE")]
    pub cell: Option<PathBuf>,
    /// With --cell: also tell the motions that come nearer to something than this, m
    #[arg(long, value_name = "M", requires = "cell", value_parser = paths::margin, allow_negative_numbers = true)]
    pub margin: Option<f64>,
    /// With --cell: tool centre point from the flange, m and rad
    #[arg(
        long,
        value_name = "x,y,z,rx,ry,rz",
        requires = "cell",
        allow_hyphen_values = true
    )]
    pub tcp: Option<Tcp>,
    /// With --cell: joint positions at start, rad
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
#[derive(Args, Clone, Debug)]
pub struct CellArgs {
    /// The cell file (TOML)
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Draw the cell from two sides
    #[arg(long, value_name = "OUT.png")]
    pub picture: Option<PathBuf>,
    /// For people, or one JSON object
    #[arg(long, value_enum, default_value_t)]
    pub format: FindingFormat,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
}

/// How lists are printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ListFormat {
    /// Columns.
    #[default]
    Table,
    /// One JSON array.
    Json,
}

/// Options of `builtins`.
#[derive(Args, Clone, Debug)]
pub struct BuiltinsArgs {
    /// A function, for everything about it; or words, for the functions that have all of them in name or description
    #[arg(value_name = "NAME|TEXT")]
    pub words: Vec<String>,
    /// Columns for people, or a JSON array
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

/// Options about the robot, together in help texts.
pub(super) const ROBOT: &str = "Robot";

/// Options of `wait`.
#[derive(Args, Clone, Debug)]
pub struct WaitArgs {
    /// The primary port of the server
    #[arg(long, default_value_t = PRIMARY_PORT)]
    pub port: u16,
    /// How long to wait, s
    #[arg(long, value_name = "S", default_value = "10", value_parser = seconds, allow_negative_numbers = true)]
    pub timeout: std::time::Duration,
    /// Where the server runs
    #[arg(long, value_name = "ADDR", default_value = "127.0.0.1")]
    pub host: IpAddr,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
}

/// A time in seconds, not negative and at most a day.
fn seconds(text: &str) -> Result<std::time::Duration, String> {
    match text.parse() {
        Ok(secs) if (0.0..=86_400.0).contains(&secs) => {
            Ok(std::time::Duration::from_secs_f64(secs))
        }
        _ => Err("allowed are seconds from 0 to 86400".to_owned()),
    }
}

#[cfg(test)]
mod tests;
