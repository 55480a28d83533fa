//! The settings of a run: options over the configuration file over the defaults.
//!
//! Owns what differs from the defaults of a controller, and the sentences about what is wrong. Reads the configuration
//! file and the calibration file; opens nothing else. Relative paths, in the file as on the command line, count from
//! the current directory.

mod file;
mod ros2;

use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv4Addr};
use std::path::{Path, PathBuf};
use std::time::Duration;

use elite_runtime::{Preset, SandboxRoots};
use messages::{Localized, Text};
use motion_api::Seconds;
use script_test::TestSettings;
use thiserror::Error;

use controller::ControllerConfig;
use controller::options::{
    ClockChoice, ControllerOptions, ModelChoice, OptionsError, RecordTarget,
};

use self::file::{TestTimes, merge_file, with_file, with_file_and};
pub use self::ros2::{Ros2Config, RosNetwork};
use crate::cli::{ControllerArgs, RunArgs, ServeArgs, TextLanguage};
use crate::options::{ControlChoice, LogFormat, PortSetting, TrustedHost};
use io_bus::ControlMode;

/// The default of `--primary-port`.
pub const PRIMARY_PORT: u16 = 30001;
/// Port that takes statements in interpreter mode.
pub const INTERPRETER_PORT: u16 = 30020;
/// Port that cyclic data comes from.
pub const RTSI_PORT: u16 = 30004;
/// Port of the pendant page and of the interface behind it.
pub const HTTP_PORT: u16 = 8080;
/// Port of a controller's dashboard.
pub const DASHBOARD_PORT: u16 = 29999;
/// Where the state comes from that nothing can be sent to.
pub const STATE_PORT: u16 = 30011;
/// Port that answers single questions.
pub const QUERY_PORT: u16 = 40011;
/// Where the controller's own Modbus server is: the vendor's port, and ours where this user may not open that one.
pub const MODBUS_PORTS: (u16, u16) = (502, 5020);

/// A reason why there are no settings: one sentence, which ends the program with exit status 2.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum ConfigError {
    /// The file cannot be read.
    #[error("cannot read the configuration file {}: {source}", path.display())]
    #[zh("无法读取配置文件 {}：{source}", path.display())]
    Unreadable {
        /// The file as it was given.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The file is not TOML.
    #[error("{} line {line} is not TOML: {message}", path.display())]
    #[zh("{} 第 {line} 行不是 TOML：{message}", path.display())]
    Syntax {
        /// The configuration file.
        path: PathBuf,
        /// Line from 1.
        line: usize,
        /// What the parser says.
        message: Text,
    },
    /// Two options that contradict each other.
    #[error("--local and --control {mode} contradict each other: leave one of them out")]
    #[zh("--local 与 --control {mode} 相矛盾：请去掉其中一个")]
    TwoControls {
        /// The mode that was named.
        mode: &'static str,
    },
    /// A key that does not exist.
    #[error("{} has an unknown key `{key}`; the keys are {}", path.display(), allowed.join(", "))]
    #[zh("{} 中有未知的键 `{key}`；可用的键为 {}", path.display(), allowed.join(", "))]
    UnknownKey {
        /// The configuration file.
        path: PathBuf,
        /// The key.
        key: String,
        /// Every key there is.
        allowed: Vec<String>,
    },
    /// A key that is given twice, as `step-ms` and `step_ms`.
    #[error("{} gives `{key}` twice", path.display())]
    #[zh("{} 两次给出 `{key}`", path.display())]
    Twice {
        /// The configuration file.
        path: PathBuf,
        /// The key.
        key: String,
    },
    /// A value that a key does not take.
    #[error("{}: `{key}` is {given}; {allowed}", path.display())]
    #[zh("{}：`{key}` 为 {given}；{allowed}", path.display())]
    BadValue {
        /// The configuration file.
        path: PathBuf,
        /// The key.
        key: String,
        /// The value as written.
        given: String,
        /// What is allowed.
        allowed: Text,
    },
    /// The options make no robot: the calibration file is not usable, or for another model.
    #[error(transparent)]
    Robot(Box<OptionsError>),
    /// A detail of a node that is not asked for.
    #[error("{option} says something of the ROS 2 node, which is off: give --ros2 as well")]
    #[zh("{option} 用于 ROS 2 节点，而节点没有启用：请同时给出 --ros2")]
    Ros2Missing {
        /// The option.
        option: &'static str,
    },
    /// No machine, or more than are spoken with.
    #[error("--ros-peers names {count} machines, allowed are 1 to {allowed}")]
    #[zh("--ros-peers 给出了 {count} 台机器，允许 1 到 {allowed} 台")]
    TooManyPeers {
        /// Number of machines.
        count: usize,
        /// Most that are allowed.
        allowed: usize,
    },
    /// A DDS domain that there is not.
    #[error(
        "the ROS 2 domain is {given:?}, allowed are 0 to 232 (--ros-domain, else ROS_DOMAIN_ID)"
    )]
    #[zh("ROS 2 域为 {given:?}，允许 0 到 232（--ros-domain，否则 ROS_DOMAIN_ID）")]
    BadDomain {
        /// The domain as given.
        given: String,
    },
    /// Two services on one port.
    #[error("{first} and {second} are both {port}; every service needs a port of its own")]
    #[zh("{first} 和 {second} 都是 {port}；每个服务需要各自的端口")]
    SamePort {
        /// Option that has the port first.
        first: &'static str,
        /// Option that has the same port.
        second: &'static str,
        /// The port.
        port: u16,
    },
}

impl From<OptionsError> for ConfigError {
    fn from(error: OptionsError) -> Self {
        Self::Robot(Box::new(error))
    }
}

/// One setting a service, in the order in which ports are opened and listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PortSettings {
    /// Scripts in, state out.
    pub primary: PortSetting,
    /// Interpreter mode.
    pub interpreter: PortSetting,
    /// Cyclic data.
    pub rtsi: PortSetting,
    /// Dashboard commands.
    pub dashboard: PortSetting,
    /// The controller's own Modbus server.
    pub modbus: PortSetting,
    /// Health and metrics.
    pub http: PortSetting,
    /// Live data for the Foxglove app.
    pub foxglove: PortSetting,
    /// The state, read-only.
    pub state: PortSetting,
    /// Questions in one line.
    pub query: PortSetting,
    /// The tool's serial line.
    pub tool_serial: PortSetting,
}

impl PortSettings {
    /// Name in the ready file, option and setting of every service.
    pub const fn list(&self) -> [(&'static str, &'static str, PortSetting); 10] {
        [
            ("primary", "--primary-port", self.primary),
            ("interpreter", "--interpreter-port", self.interpreter),
            ("rtsi", "--rtsi-port", self.rtsi),
            ("dashboard", "--dashboard-port", self.dashboard),
            ("modbus", "--modbus-port", self.modbus),
            ("http", "--http-port", self.http),
            ("foxglove", "--foxglove-port", self.foxglove),
            ("state", "--state-port", self.state),
            ("query", "--query-port", self.query),
            ("tool-serial", "--tool-serial-port", self.tool_serial),
        ]
    }
}

impl PortSettings {
    /// Changes the setting of the service of this name; a name that [`list`](Self::list) does not have changes nothing.
    pub fn set(&mut self, name: &str, setting: PortSetting) {
        match name {
            "primary" => self.primary = setting,
            "interpreter" => self.interpreter = setting,
            "rtsi" => self.rtsi = setting,
            "dashboard" => self.dashboard = setting,
            "modbus" => self.modbus = setting,
            "http" => self.http = setting,
            "foxglove" => self.foxglove = setting,
            "state" => self.state = setting,
            "query" => self.query = setting,
            "tool-serial" => self.tool_serial = setting,
            _ => {}
        }
    }
}

/// Settings of what is logged.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LogConfig {
    /// Folder of the vendor's log files.
    pub dir: Option<PathBuf>,
    /// How log lines look.
    pub format: LogFormat,
    /// The language of texts for people; without it that of the environment.
    pub language: Option<TextLanguage>,
}

impl LogConfig {
    fn from_args(args: &mut ControllerArgs) -> Self {
        Self {
            dir: args.log_dir.take(),
            format: args.log.log_format.take().unwrap_or_default(),
            language: args.log.language.take(),
        }
    }
}

/// Settings of `serve`.
#[derive(Clone, Debug, PartialEq)]
pub struct ServeConfig {
    /// The robot.
    pub robot: ControllerConfig,
    /// Settings of the log.
    pub log: LogConfig,
    /// Address that every port listens on.
    pub bind: IpAddr,
    /// Port of each service, or that it is off.
    pub ports: PortSettings,
    /// Names beside this machine's own that requests of the http and Foxglove ports may be for and from.
    pub trusted_hosts: Vec<String>,
    /// File that process id and ports are written to.
    pub ready_file: Option<PathBuf>,
    /// End when standard input is closed.
    pub until_stdin_closes: bool,
    /// Start with the power off.
    pub powered_off: bool,
    /// Watch programs from their start, for debuggers that attach later.
    pub attachable: bool,
    /// Who controls the robot at start.
    pub control: ControlMode,
    /// The ROS 2 node, if there is to be one.
    pub ros2: Option<Ros2Config>,
}

/// Settings of `run`.
#[derive(Clone, Debug, PartialEq)]
pub struct RunConfig {
    /// The robot.
    pub robot: ControllerConfig,
    /// Settings of the log.
    pub log: LogConfig,
    /// The script, `-` for stdin.
    pub file: PathBuf,
    /// Globals that it finds set.
    pub presets: Vec<Preset>,
    /// Write a bag of ROS 2 beside the recording.
    pub ros2_profile: bool,
}

/// A port with a number that another controller may have as well where the primary port is elsewhere: any free one
/// then.
pub(crate) fn port_beside(
    primary: PortSetting,
    setting: Option<PortSetting>,
    number: u16,
) -> PortSetting {
    setting.unwrap_or(match primary {
        PortSetting::Number(PRIMARY_PORT) => PortSetting::Number(number),
        _ => PortSetting::Any,
    })
}

impl ServeConfig {
    /// From what was typed and, if named there, the configuration file.
    pub fn load(args: ServeArgs) -> Result<Self, ConfigError> {
        Self::of(with_file(args, None)?)
    }

    /// From the text of a configuration file; `path` is what errors call it.
    ///
    /// # Errors
    /// [`ConfigError`]
    pub fn of_text(path: &Path, text: &str) -> Result<Self, ConfigError> {
        let mut args = ServeArgs::default();
        merge_file(&mut args, path, text, None)?;
        Self::of(args)
    }

    fn of(mut args: ServeArgs) -> Result<Self, ConfigError> {
        let log = LogConfig::from_args(&mut args.shared);
        let fixed =
            |setting: Option<PortSetting>, number| setting.unwrap_or(PortSetting::Number(number));
        let (modbus, without_privilege) = MODBUS_PORTS;
        let primary = fixed(args.primary_port, PRIMARY_PORT);
        let beside = |setting, number| port_beside(primary, setting, number);
        let ports = PortSettings {
            primary,
            interpreter: fixed(args.interpreter_port, INTERPRETER_PORT),
            rtsi: fixed(args.rtsi_port, RTSI_PORT),
            dashboard: fixed(args.dashboard_port, DASHBOARD_PORT),
            modbus: args
                .modbus_port
                .unwrap_or(PortSetting::Either(modbus, without_privilege)),
            http: fixed(args.http_port, 8080),
            foxglove: args.foxglove_port.unwrap_or(PortSetting::Off),
            state: beside(args.state_port, STATE_PORT),
            query: beside(args.query_port, QUERY_PORT),
            tool_serial: args.tool_serial_port.unwrap_or(PortSetting::Off),
        };
        check_distinct_ports(&ports)?;
        let defaults = ControllerConfig {
            clock: ClockChoice::Realtime,
            record: RecordTarget::NewFileIn("recordings".into()),
            cycle_phase: args
                .cycle_phase_us
                .map(|us| Duration::from_micros(us.into())),
            ..ControllerConfig::default()
        };
        Ok(Self {
            robot: args.shared.options.resolve(defaults, None)?,
            until_stdin_closes: args.until_stdin_closes,
            log,
            bind: args.bind.unwrap_or(IpAddr::V4(Ipv4Addr::LOCALHOST)),
            ports,
            trusted_hosts: trusted_hosts(args.trust_host),
            ready_file: args.ready_file,
            powered_off: args.powered_off.unwrap_or(false),
            attachable: args.attachable.unwrap_or(false),
            control: control(args.control, args.local)?,
            ros2: Ros2Config::of(args.ros2)?,
        })
    }
}

impl RunConfig {
    /// From what was typed and, if named there, the configuration file. Keys of `serve` may stand in the file: one file
    /// can serve both; `run` opens no port and ignores them.
    pub fn load(args: RunArgs) -> Result<Self, ConfigError> {
        Self::load_within(args, None)
    }

    /// The configuration from what was typed and from the file, like [`Self::load`]; every file that is named must be
    /// beneath these folders, links followed.
    ///
    /// # Errors
    /// [`ConfigError`]
    pub fn load_within(args: RunArgs, within: Option<&SandboxRoots>) -> Result<Self, ConfigError> {
        let args_of_serve = ServeArgs {
            shared: args.shared,
            ..ServeArgs::default()
        };
        let args_of_serve = with_file(args_of_serve, within)?;
        let ros2_profile = args_of_serve.ros2_profile.unwrap_or(false);
        let mut shared = args_of_serve.shared;
        Ok(Self {
            log: LogConfig::from_args(&mut shared),
            robot: robot_of(shared.options, within)?,
            file: args.file,
            presets: args.set,
            ros2_profile,
        })
    }
}

/// The robot that tests run on, from their `test.toml` if there is one. Relative paths in it count from its folder;
/// with `sandbox` every file must be beneath those folders.
///
/// # Errors
/// [`ConfigError`]
pub fn robot_for_tests(
    file: Option<&Path>,
    seed: Option<u64>,
    within: Option<&SandboxRoots>,
) -> Result<TestSettings, ConfigError> {
    let only_the_file = ServeArgs {
        shared: ControllerArgs {
            config: file.map(Path::to_owned),
            ..ControllerArgs::default()
        },
        ..ServeArgs::default()
    };
    let mut times = TestTimes::default();
    let read = with_file_and(only_the_file, within, Some(&mut times))?;
    let mut options = read.shared.options;
    let folder = file.and_then(Path::parent).unwrap_or(Path::new(""));
    let paths = [
        &mut options.cell,
        &mut options.calibration,
        &mut options.task_dir,
    ];
    for path in paths.into_iter().flatten() {
        *path = folder.join(&*path);
    }
    if let Some(ModelChoice::Urdf(path)) = &mut options.model {
        *path = folder.join(&*path);
    }
    options.seed = seed.or(options.seed);
    Ok(TestSettings {
        robot: robot_of(options, within)?,
        timeout: times.timeout.and_then(|time| Seconds::new(time.0)),
        wall_timeout: times
            .wall_timeout
            .map(|time| Duration::from_secs_f64(time.0)),
    })
}

/// The robot of `run` and of tests: under the virtual clock, and nothing is recorded unless asked for.
fn robot_of(
    options: ControllerOptions,
    within: Option<&SandboxRoots>,
) -> Result<ControllerConfig, ConfigError> {
    Ok(options.resolve(ControllerConfig::default(), within)?)
}

/// Who controls at start: `--local` is short for one of the modes.
fn control(named: Option<ControlChoice>, local: Option<bool>) -> Result<ControlMode, ConfigError> {
    match (named, local) {
        (Some(ControlChoice(mode)), Some(true)) if mode != ControlMode::Local => {
            Err(ConfigError::TwoControls { mode: mode.name() })
        }
        (Some(ControlChoice(mode)), _) => Ok(mode),
        (None, Some(true)) => Ok(ControlMode::Local),
        (None, _) => Ok(ControlMode::Remote),
    }
}

/// The names as texts.
pub(crate) fn trusted_hosts(given: Option<Vec<TrustedHost>>) -> Vec<String> {
    let given = given.unwrap_or_default();
    given.into_iter().map(|TrustedHost(name)| name).collect()
}

pub(crate) fn check_distinct_ports(ports: &PortSettings) -> Result<(), ConfigError> {
    let mut taken = BTreeMap::new();
    for (_, option, setting) in ports.list() {
        if let PortSetting::Number(port) = setting
            && let Some(first) = taken.insert(port, option)
        {
            return Err(ConfigError::SamePort {
                first,
                second: option,
                port,
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
