//! The settings of a run: options over the configuration file over the defaults.
//!
//! Owns the defaults, the TOML keys and the sentences about what is wrong. Reads the configuration file and the
//! calibration file; opens nothing else. Relative paths, in the file as on the command line, count from the current
//! directory.

mod ros2;

use std::collections::{BTreeMap, BTreeSet};
use std::net::{IpAddr, Ipv4Addr};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Duration;

use elite_runtime::{Preset, SandboxRoots};
use kinematics::{Calibration, CalibrationError};
use motion_api::Seconds;
use script_test::TestSettings;
use thiserror::Error;

use controller::ControllerConfig;
use controller::cell::line_of;
use controller::options::{
    ClockChoice, ModelChoice, Permission, PlantChoice, RecordTarget, StepMillis,
};

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
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ConfigError {
    /// The file cannot be read.
    #[error("cannot read the configuration file {}: {source}", path.display())]
    Unreadable {
        /// The file as it was given.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The file is not TOML.
    #[error("{} line {line} is not TOML: {message}", path.display())]
    Syntax {
        /// The configuration file.
        path: PathBuf,
        /// Line from 1.
        line: usize,
        /// What the parser says.
        message: String,
    },
    /// Two options that contradict each other.
    #[error("--local and --control {mode} contradict each other: leave one of them out")]
    TwoControls {
        /// The mode that was named.
        mode: &'static str,
    },
    /// A key that does not exist.
    #[error("{} has an unknown key `{key}`; the keys are {}", path.display(), allowed.join(", "))]
    UnknownKey {
        /// The configuration file.
        path: PathBuf,
        /// The key.
        key: String,
        /// Every key there is.
        allowed: Vec<&'static str>,
    },
    /// A key that is given twice, as `step-ms` and `step_ms`.
    #[error("{} gives `{key}` twice", path.display())]
    Twice {
        /// The configuration file.
        path: PathBuf,
        /// The key.
        key: String,
    },
    /// A value that a key does not take.
    #[error("{}: `{key}` is {given}; {allowed}", path.display())]
    BadValue {
        /// The configuration file.
        path: PathBuf,
        /// The key.
        key: String,
        /// The value as written.
        given: String,
        /// What is allowed.
        allowed: String,
    },
    /// The calibration file is not usable, or for another model.
    #[error(transparent)]
    Calibration(Box<CalibrationError>),
    /// A detail of a node that is not asked for.
    #[error("{option} says something of the ROS 2 node, which is off: give --ros2 as well")]
    Ros2Missing {
        /// The option.
        option: &'static str,
    },
    /// No machine, or more than are spoken with.
    #[error("--ros-peers names {count} machines, allowed are 1 to {allowed}")]
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
    BadDomain {
        /// The domain as given.
        given: String,
    },
    /// Two services on one port.
    #[error("{first} and {second} are both {port}; every service needs a port of its own")]
    SamePort {
        /// Option that has the port first.
        first: &'static str,
        /// Option that has the same port.
        second: &'static str,
        /// The port.
        port: u16,
    },
}

impl From<CalibrationError> for ConfigError {
    fn from(error: CalibrationError) -> Self {
        Self::Calibration(Box::new(error))
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
        // Next to a primary port elsewhere, another controller may have these.
        let beside = |setting: Option<PortSetting>, number| match primary {
            PortSetting::Number(PRIMARY_PORT) => fixed(setting, number),
            _ => setting.unwrap_or(PortSetting::Any),
        };
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
        let recordings = RecordTarget::NewFileIn("recordings".into());
        Ok(Self {
            robot: ControllerConfig {
                cycle_phase: args
                    .cycle_phase_us
                    .map(|us| Duration::from_micros(us.into())),
                ..robot_config(args.shared, ClockChoice::Realtime, recordings, None)?
            },
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
            robot: robot_config(shared, ClockChoice::Virtual, RecordTarget::Off, within)?,
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
    let mut shared = with_file_and(only_the_file, within, Some(&mut times))?.shared;
    let folder = file.and_then(Path::parent).unwrap_or(Path::new(""));
    let paths = [
        &mut shared.cell,
        &mut shared.calibration,
        &mut shared.task_dir,
    ];
    for path in paths.into_iter().flatten() {
        *path = folder.join(&*path);
    }
    if let Some(ModelChoice::Urdf(path)) = &mut shared.model {
        *path = folder.join(&*path);
    }
    shared.seed = seed.or(shared.seed);
    Ok(TestSettings {
        robot: robot_config(shared, ClockChoice::Virtual, RecordTarget::Off, within)?,
        timeout: times.timeout.and_then(Seconds::new),
        wall_timeout: times.wall_timeout.map(Duration::from_secs_f64),
    })
}

/// Times of a `test.toml`, s.
#[derive(Default)]
struct TestTimes {
    timeout: Option<f64>,
    wall_timeout: Option<f64>,
}

/// Keys that only a `test.toml` has.
const TEST_KEYS: [&str; 2] = ["timeout", "wall-timeout"];

fn robot_config(
    args: ControllerArgs,
    clock: ClockChoice,
    record: RecordTarget,
    within: Option<&SandboxRoots>,
) -> Result<ControllerConfig, ConfigError> {
    let calibration = args.calibration.as_deref().map(|path| {
        let Some(folders) = within else {
            return Calibration::load(path);
        };
        let text = folders
            .read_text(path)
            .map_err(|source| CalibrationError::Unreadable {
                path: path.to_owned(),
                source,
            })?;
        Calibration::from_text(&text, path)
    });
    let calibration = calibration.transpose()?;
    let model = match (&calibration, args.model) {
        (Some(calibration), asked) => model_of(calibration, asked.as_ref())?,
        (None, asked) => asked.unwrap_or(ModelChoice::BuiltIn("cs66")),
    };
    Ok(ControllerConfig {
        model,
        calibration,
        cell: args.cell,
        clock: args.clock.unwrap_or(clock),
        step: args.step_ms.unwrap_or(StepMillis::DEFAULT),
        plant: args.plant.unwrap_or(PlantChoice::Rigid),
        task_dir: args.task_dir.unwrap_or_else(|| "tasks".into()),
        record: args.record.unwrap_or(record),
        record_rotate: args.record_rotate,
        record_budget: args.record_budget,
        tcp: args.tcp.unwrap_or_default().0,
        payload: args.payload.unwrap_or_default().0,
        home: args.home.unwrap_or_default().0,
        seed: args.seed.unwrap_or(0),
        allow: args
            .allow
            .map_or(BTreeSet::from([Permission::Net]), BTreeSet::from_iter),
        sandbox: within.cloned(),
        cycle_phase: None,
    })
}

/// The model of a calibration, which must be the one that was asked for.
fn model_of(
    calibration: &Calibration,
    asked: Option<&ModelChoice>,
) -> Result<ModelChoice, ConfigError> {
    let asked = asked.map(ToString::to_string);
    let name = calibration.model_for(asked.as_deref())?;
    name.parse().map_err(|allowed| ConfigError::BadValue {
        path: calibration.path().to_owned(),
        key: "model".to_owned(),
        given: format!("{name:?}"),
        allowed,
    })
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

/// Every key of the file: the long names of the options of `serve`, `config` apart, and `ros2-profile` of `run`.
const KEYS: [&str; 38] = [
    "allow",
    "attachable",
    "bind",
    "calibration",
    "cell",
    "clock",
    "control",
    "cycle-phase-us",
    "dashboard-port",
    "foxglove-port",
    "home",
    "http-port",
    "interpreter-port",
    "language",
    "local",
    "log-dir",
    "log-format",
    "modbus-port",
    "model",
    "payload",
    "plant",
    "powered-off",
    "primary-port",
    "query-port",
    "ready-file",
    "record",
    "record-budget",
    "record-rotate",
    "ros2",
    "ros2-profile",
    "rtsi-port",
    "seed",
    "state-port",
    "step-ms",
    "task-dir",
    "tcp",
    "tool-serial-port",
    "trust-host",
];

/// Fills what was not typed from the configuration file, if one is named.
fn with_file(args: ServeArgs, within: Option<&SandboxRoots>) -> Result<ServeArgs, ConfigError> {
    with_file_and(args, within, None)
}

fn with_file_and(
    mut args: ServeArgs,
    within: Option<&SandboxRoots>,
    times: Option<&mut TestTimes>,
) -> Result<ServeArgs, ConfigError> {
    let Some(path) = args.shared.config.take() else {
        return Ok(args);
    };
    let read = match within {
        Some(folders) => folders.read_text(&path),
        None => kinematics::text_file::read_text_file(&path),
    };
    let text = match read {
        Ok(text) => text,
        Err(source) => return Err(ConfigError::Unreadable { path, source }),
    };
    merge_file(&mut args, &path, &text, times)?;
    Ok(args)
}

/// `times`: the file is a `test.toml`.
fn merge_file(
    args: &mut ServeArgs,
    path: &Path,
    text: &str,
    mut times: Option<&mut TestTimes>,
) -> Result<(), ConfigError> {
    let table: toml::Table = text
        .parse()
        .map_err(|e: toml::de::Error| ConfigError::Syntax {
            path: path.to_owned(),
            line: e.span().map_or(1, |span| line_of(text, span.start)),
            message: e.message().replace('\n', ", "),
        })?;
    let mut seen = BTreeSet::new();
    for (written, value) in &table {
        // `step_ms` is as good as `step-ms`: both spellings are common in TOML.
        let key = written.replace('_', "-");
        if !seen.insert(key.clone()) {
            return Err(ConfigError::Twice {
                path: path.to_owned(),
                key,
            });
        }
        let entry = FileEntry {
            path,
            key: written,
            value,
        };
        let shared = &mut args.shared;
        match key.as_str() {
            "allow" => entry.list(&mut shared.allow),
            "attachable" => entry.named(&mut args.attachable, "allowed are true and false"),
            "bind" => entry.named(&mut args.bind, "allowed is an IP address"),
            "calibration" => entry.one(&mut shared.calibration),
            "cell" => entry.one(&mut shared.cell),
            "clock" => entry.one(&mut shared.clock),
            "control" => entry.one(&mut args.control),
            "cycle-phase-us" => entry.named(
                &mut args.cycle_phase_us,
                "allowed are whole microseconds from 0",
            ),
            "dashboard-port" => entry.one(&mut args.dashboard_port),
            "foxglove-port" => entry.one(&mut args.foxglove_port),
            "home" => entry.one(&mut shared.home),
            "http-port" => entry.one(&mut args.http_port),
            "interpreter-port" => entry.one(&mut args.interpreter_port),
            "language" => entry.named(&mut shared.log.language, "allowed are \"en\" and \"zh\""),
            "local" => entry.named(&mut args.local, "allowed are true and false"),
            "log-dir" => entry.one(&mut shared.log_dir),
            "log-format" => entry.one(&mut shared.log.log_format),
            "modbus-port" => entry.one(&mut args.modbus_port),
            "model" => entry.one(&mut shared.model),
            "payload" => entry.one(&mut shared.payload),
            "plant" => entry.one(&mut shared.plant),
            "powered-off" => entry.named(&mut args.powered_off, "allowed are true and false"),
            "primary-port" => entry.one(&mut args.primary_port),
            "query-port" => entry.one(&mut args.query_port),
            "ready-file" => entry.one(&mut args.ready_file),
            "record" => entry.one(&mut shared.record),
            "record-budget" => entry.one(&mut shared.record_budget),
            "record-rotate" => entry.one(&mut shared.record_rotate),
            "ros2" => ros2::merge_ros2(&mut args.ros2, path, &entry),
            "ros2-profile" => entry.named(&mut args.ros2_profile, "allowed are true and false"),
            "rtsi-port" => entry.one(&mut args.rtsi_port),
            "seed" => entry.named(&mut shared.seed, "allowed are whole numbers from 0"),
            "state-port" => entry.one(&mut args.state_port),
            "step-ms" => entry.one(&mut shared.step_ms),
            "task-dir" => entry.one(&mut shared.task_dir),
            "tcp" => entry.one(&mut shared.tcp),
            "tool-serial-port" => entry.one(&mut args.tool_serial_port),
            "trust-host" => entry.list(&mut args.trust_host),
            "timeout" if let Some(times) = &mut times => entry.seconds(&mut times.timeout),
            "wall-timeout" if let Some(times) = &mut times => {
                entry.seconds(&mut times.wall_timeout)
            }
            _ => Err(ConfigError::UnknownKey {
                path: path.to_owned(),
                key: written.clone(),
                allowed: match times {
                    Some(_) => KEYS.into_iter().chain(TEST_KEYS).collect(),
                    None => KEYS.to_vec(),
                },
            }),
        }?;
    }
    Ok(())
}

/// One `key = value` of the file.
struct FileEntry<'a> {
    path: &'a Path,
    key: &'a str,
    value: &'a toml::Value,
}

impl FileEntry<'_> {
    /// Reads the value even where an option was typed: a mistake in the file is reported either way.
    fn one<T: FromStr<Err: ToString>>(&self, slot: &mut Option<T>) -> Result<(), ConfigError> {
        let value = self.parse(self.value)?;
        slot.get_or_insert(value);
        Ok(())
    }

    /// Reads a value of a type whose own error does not say what is allowed; `allowed` does.
    fn named<T: FromStr>(&self, slot: &mut Option<T>, allowed: &str) -> Result<(), ConfigError> {
        let text = text_of(self.value).ok_or_else(|| self.bad(self.value, allowed))?;
        let value = text.parse().map_err(|_| self.bad(self.value, allowed))?;
        slot.get_or_insert(value);
        Ok(())
    }

    /// A time above 0, s.
    fn seconds(&self, slot: &mut Option<f64>) -> Result<(), ConfigError> {
        let text = text_of(self.value).unwrap_or_default();
        let time = crate::cli::seconds_of_test(&text);
        slot.get_or_insert(time.map_err(|allowed| self.bad(self.value, &allowed))?);
        Ok(())
    }

    /// A list, or one value without brackets. An empty list is a list: nothing is allowed then.
    fn list<T: FromStr<Err: ToString>>(
        &self,
        slot: &mut Option<Vec<T>>,
    ) -> Result<(), ConfigError> {
        let values = match self.value {
            toml::Value::Array(items) => items.iter().map(|item| self.parse(item)).collect(),
            single => self.parse(single).map(|value| vec![value]),
        }?;
        slot.get_or_insert(values);
        Ok(())
    }

    fn parse<T: FromStr<Err: ToString>>(&self, value: &toml::Value) -> Result<T, ConfigError> {
        let text = text_of(value)
            .ok_or_else(|| self.bad(value, "a text, a number or a list of them is needed"))?;
        text.parse()
            .map_err(|e: T::Err| self.bad(value, &e.to_string()))
    }

    fn bad(&self, value: &toml::Value, allowed: &str) -> ConfigError {
        ConfigError::BadValue {
            path: self.path.to_owned(),
            key: self.key.to_owned(),
            given: value.to_string().replace('\n', " "),
            allowed: allowed.to_owned(),
        }
    }
}

/// A value as it would be typed: lists are joined by commas.
fn text_of(value: &toml::Value) -> Option<String> {
    match value {
        toml::Value::String(text) => Some(text.clone()),
        toml::Value::Integer(number) => Some(number.to_string()),
        toml::Value::Float(number) => Some(number.to_string()),
        toml::Value::Boolean(flag) => Some(flag.to_string()),
        toml::Value::Array(items) if !items.is_empty() => {
            let parts: Option<Vec<_>> = items.iter().map(text_of).collect();
            parts.map(|parts| parts.join(","))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests;
