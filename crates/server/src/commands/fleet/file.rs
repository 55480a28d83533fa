//! The file of a fleet: which robots, and what each is started with.
//!
//! Owns the keys that `serve` does not have and what is settled between robots: addresses, folders, phases of their
//! cycles. What a robot's own options may be is `config`'s business; every robot's are tried here, before one is
//! started.

use std::collections::BTreeSet;
use std::net::{IpAddr, Ipv4Addr};
use std::path::{Path, PathBuf};

use controller::options::{ByteSize, ModelChoice, Permission, RecordTarget};
use messages::{Localized, Text, text};
use thiserror::Error;
use toml::{Table, Value};

use crate::config::{ConfigError, ServeConfig};
use crate::options::{PortSetting, TrustedHost};

/// Most robots of a fleet.
const ROBOTS_MAX: usize = 200;
/// The address of the first robot that names none; the others follow.
const FIRST_ADDRESS: [u8; 4] = [127, 0, 0, 11];
/// The port of the page.
const HTTP_PORT: u16 = 8090;
/// Longest name.
const NAME_CHARS_MAX: usize = 40;
/// Largest file, bytes.
const FILE_BYTES_MAX: usize = 1 << 20;

/// Keys beside `robot` and `defaults`.
const KEYS: [&str; 4] = ["bind", "folder", "http-port", "trust-host"];

/// A reason why a fleet cannot be started, told in a sentence.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum FleetFileError {
    /// The file cannot be read.
    #[error("cannot read the fleet {}: {source}", path.display())]
    #[zh("无法读取机器人组文件 {}：{source}", path.display())]
    Unreadable {
        /// The file as it was given.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The file is not TOML, or has something that is not allowed.
    #[error("{}: {what}", path.display())]
    Wrong {
        /// The file as it was given.
        path: PathBuf,
        /// What is wrong.
        what: Text,
    },
    /// The options of a robot.
    #[error("robot {name}: {source}")]
    #[zh("机器人 {name}：{source}")]
    Robot {
        /// Name of the robot.
        name: String,
        /// What is wrong.
        source: Box<ConfigError>,
    },
}

/// A fleet.
#[derive(Clone, Debug)]
pub struct FleetConfig {
    /// Address of the page.
    pub bind: IpAddr,
    /// Port of the page.
    pub http_port: PortSetting,
    /// Names beside this machine's own that requests to the page may use.
    pub trusted_hosts: Vec<String>,
    /// The robots, in the order of the file.
    pub robots: Vec<RobotPlan>,
}

/// What a robot is started with.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotPlan {
    /// Name of the robot.
    pub name: String,
    /// Address that the robot's ports listen on.
    pub bind: IpAddr,
    /// The robot's own folder: recordings, tasks, logs.
    pub folder: PathBuf,
    /// Memory above which the robot's process is started again, bytes.
    pub memory: Option<u64>,
    /// Text of the robot's configuration file.
    pub config: String,
}

impl FleetConfig {
    /// Reads and checks a file.
    ///
    /// # Errors
    /// [`FleetFileError`]
    pub fn load(path: &Path) -> Result<Self, FleetFileError> {
        let text = kinematics::text_file::read_text_file(path).map_err(|source| {
            FleetFileError::Unreadable {
                path: path.to_owned(),
                source,
            }
        })?;
        Self::of_text(path, &text)
    }

    /// Checks a text; `path` is what errors call it.
    ///
    /// # Errors
    /// [`FleetFileError`]
    pub fn of_text(path: &Path, text: &str) -> Result<Self, FleetFileError> {
        let wrong = |what: Text| FleetFileError::Wrong {
            path: path.to_owned(),
            what,
        };
        if text.len() > FILE_BYTES_MAX {
            return Err(wrong(text!(
                "it has {} bytes, at most {FILE_BYTES_MAX} are read",
                "有 {} 字节，最多读取 {FILE_BYTES_MAX} 字节",
                text.len()
            )));
        }
        let table: Table = text.parse().map_err(|error: toml::de::Error| {
            wrong(Text::of_library(&error.message().replace('\n', ", ")))
        })?;
        let mut top = with_dashes(table).map_err(wrong)?;
        let defaults = match top.remove("defaults") {
            None => Table::new(),
            Some(Value::Table(table)) => with_dashes(table).map_err(wrong)?,
            Some(_) => {
                return Err(wrong(text!(
                    "defaults must be a table, [defaults]",
                    "defaults 应为表 [defaults]"
                )));
            }
        };
        for key in ["name", "bind", "cycle-phase-us", "ready-file"] {
            if defaults.contains_key(key) {
                return Err(wrong(text!(
                    "`{key}` belongs to a robot, not to [defaults]",
                    "`{key}` 属于单个机器人，不属于 [defaults]"
                )));
            }
        }
        if defaults
            .get("record")
            .is_some_and(|value| value.as_str() != Some("off"))
        {
            return Err(wrong(text!(
                "`record` in [defaults] can only be \"off\": without it every robot records into a folder of its \
                 own",
                "[defaults] 中的 `record` 只能是 \"off\"：不写时每个机器人记录到自己的文件夹"
            )));
        }
        let tables = match top.remove("robot") {
            Some(Value::Array(tables)) if !tables.is_empty() => tables,
            _ => {
                return Err(wrong(text!(
                    "there is no robot; each is a table [[robot]]",
                    "没有机器人；每个机器人是一个表 [[robot]]"
                )));
            }
        };
        if tables.len() > ROBOTS_MAX {
            let count = tables.len();
            return Err(wrong(text!(
                "it has {count} robots, at most {ROBOTS_MAX} are started",
                "其中有 {count} 个机器人，最多启动 {ROBOTS_MAX} 个"
            )));
        }
        let (bind, http_port, trusted_hosts, folder) = page_of(&mut top).map_err(wrong)?;
        if let Some(key) = top.keys().next() {
            let keys = KEYS.join(", ");
            return Err(wrong(text!(
                "unknown key `{key}`; beside [defaults] and [[robot]] there are {keys}",
                "未知的键 `{key}`；[defaults] 和 [[robot]] 之外有 {keys}"
            )));
        }
        let folder = std::path::absolute(&folder).unwrap_or(folder);
        let count = tables.len();
        let mut robots = Vec::new();
        let (mut names, mut addresses) = (BTreeSet::new(), BTreeSet::new());
        for (index, table) in tables.into_iter().enumerate() {
            let Value::Table(table) = table else {
                return Err(wrong(text!(
                    "every robot is a table, [[robot]]",
                    "每个机器人应为表 [[robot]]"
                )));
            };
            let table = with_dashes(table).map_err(wrong)?;
            let plan = plan(path, table, &defaults, &folder, (index, count))?;
            if !names.insert(plan.name.clone()) {
                return Err(wrong(text!(
                    "two robots are called {}",
                    "两个机器人都名为 {}",
                    plan.name
                )));
            }
            if !addresses.insert(plan.bind) {
                return Err(wrong(text!(
                    "two robots have the address {}; each needs one of its own",
                    "两个机器人的地址都是 {}；每个需要自己的地址",
                    plan.bind
                )));
            }
            robots.push(plan);
        }
        Ok(Self {
            bind,
            http_port,
            trusted_hosts,
            robots,
        })
    }
}

/// `step_ms` is as good as `step-ms`.
fn with_dashes(table: Table) -> Result<Table, Text> {
    let mut dashed = Table::new();
    for (key, value) in table {
        let key = key.replace('_', "-");
        if dashed.contains_key(&key) {
            return Err(text!("`{key}` is given twice", "`{key}` 给出了两次"));
        }
        dashed.insert(key, value);
    }
    Ok(dashed)
}

/// Address, port, names and folder of the fleet itself.
fn page_of(top: &mut Table) -> Result<(IpAddr, PortSetting, Vec<String>, PathBuf), Text> {
    let text = |value: Value| match value {
        Value::String(text) => text,
        other => other.to_string(),
    };
    let mut taken = |key: &str| top.remove(key).map(text);
    let bind = match taken("bind") {
        None => IpAddr::V4(Ipv4Addr::LOCALHOST),
        Some(text) => text.parse().map_err(|_| {
            text!(
                "`bind` is {text:?}; an IP address is needed",
                "`bind` 为 {text:?}；需要 IP 地址"
            )
        })?,
    };
    let port = match taken("http-port") {
        None => PortSetting::Number(HTTP_PORT),
        Some(text) => text.parse().map_err(|allowed: Text| {
            text!(
                "`http-port` is {text:?}; {allowed}",
                "`http-port` 为 {text:?}；{allowed}"
            )
        })?,
    };
    let folder = taken("folder").map_or_else(|| PathBuf::from("fleet"), PathBuf::from);
    let mut trusted = Vec::new();
    match top.remove("trust-host") {
        None => {}
        Some(Value::Array(names)) => {
            for name in names {
                let name = text(name);
                let host: TrustedHost = name.parse().map_err(|allowed: Text| {
                    text!(
                        "`trust-host` has {name:?}; {allowed}",
                        "`trust-host` 中有 {name:?}；{allowed}"
                    )
                })?;
                trusted.push(host.0);
            }
        }
        Some(other) => {
            return Err(text!(
                "`trust-host` is {other}; a list of names is needed",
                "`trust-host` 为 {other}；需要名称列表"
            ));
        }
    }
    Ok((bind, port, trusted, folder))
}

/// One robot of `count`.
fn plan(
    path: &Path,
    mut table: Table,
    defaults: &Table,
    folder: &Path,
    (index, count): (usize, usize),
) -> Result<RobotPlan, FleetFileError> {
    let wrong = |what: Text| FleetFileError::Wrong {
        path: path.to_owned(),
        what,
    };
    let number = index + 1;
    let name = match table.remove("name") {
        Some(Value::String(name)) if is_name(&name) => name,
        Some(given) => {
            return Err(wrong(text!(
                "robot {number}: `name` is {given}; 1 to {NAME_CHARS_MAX} letters, digits, `-` and `_` are allowed",
                "第 {number} 个机器人：`name` 为 {given}；允许 1 到 {NAME_CHARS_MAX} 个字母、数字、`-` 和 `_`"
            )));
        }
        None => {
            return Err(wrong(text!(
                "robot {number} has no `name`",
                "第 {number} 个机器人没有 `name`"
            )));
        }
    };
    for key in ["ready-file", "cycle-phase-us"] {
        if table.contains_key(key) {
            return Err(wrong(text!(
                "robot {name}: `{key}` is the fleet's to say",
                "机器人 {name}：`{key}` 由机器人组决定"
            )));
        }
    }
    for (key, value) in defaults {
        if !table.contains_key(key) {
            table.insert(key.clone(), value.clone());
        }
    }
    let memory = match table.remove("memory") {
        None => None,
        Some(given) => {
            let text = given
                .as_str()
                .map_or_else(|| given.to_string(), str::to_owned);
            let size: ByteSize = text.parse().map_err(|allowed: Text| {
                wrong(text!(
                    "robot {name}: `memory` is {text:?}; {allowed}",
                    "机器人 {name}：`memory` 为 {text:?}；{allowed}"
                ))
            })?;
            Some(size.0)
        }
    };
    if !table.contains_key("bind") {
        let [a, b, c, first] = FIRST_ADDRESS;
        let last = usize::from(first) + index;
        // 200 robots end at 127.0.0.210.
        let address = Ipv4Addr::new(a, b, c, u8::try_from(last).unwrap_or(u8::MAX));
        table.insert("bind".to_owned(), Value::String(address.to_string()));
    }
    let robot = |source: ConfigError| FleetFileError::Robot {
        name: name.clone(),
        source: Box::new(source),
    };
    let config = ServeConfig::of_text(path, &table.to_string()).map_err(robot)?;
    let micros = config.robot.step.as_secs() * 1e6;
    let phase = micros * index as f64 / count as f64;
    table.insert("cycle-phase-us".to_owned(), Value::Integer(phase as i64));
    make_absolute(&mut table, &config);
    Ok(RobotPlan {
        folder: folder.join(&name),
        bind: config.bind,
        memory,
        config: table.to_string(),
        name,
    })
}

fn is_name(name: &str) -> bool {
    let fits = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
    !name.is_empty() && name.len() <= NAME_CHARS_MAX && name.chars().all(fits)
}

/// Paths count from the current folder, as those of `serve` do; robots run in folders of their own.
fn make_absolute(table: &mut Table, config: &ServeConfig) {
    let whole = |path: &Path| {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        path.display().to_string()
    };
    let robot = &config.robot;
    let mut set = |key: &str, value: String| table.insert(key.to_owned(), Value::String(value));
    if let Some(cell) = &robot.cell {
        set("cell", whole(cell));
    }
    if let Some(calibration) = &robot.calibration {
        set("calibration", whole(calibration.path()));
    }
    if let RecordTarget::File(path) = &robot.record {
        set("record", whole(path));
    }
    if let Some(folder) = &config.log.dir {
        set("log-dir", whole(folder));
    }
    if let (ModelChoice::Urdf(path), None) = (&robot.model, &robot.calibration) {
        let path = whole(path);
        set("model", path);
    }
    if table.contains_key("task-dir") {
        let folder = whole(&robot.task_dir);
        table.insert("task-dir".to_owned(), Value::String(folder));
    }
    if table.contains_key("allow") {
        let words = robot.allow.iter().map(|permission| match permission {
            Permission::Fs => "fs".to_owned(),
            Permission::FsIn(folder) => format!("fs={}", whole(folder)),
            Permission::Process => "process".to_owned(),
            Permission::Env => "env".to_owned(),
            Permission::Net => "net".to_owned(),
            Permission::NetPlayed => "net=played".to_owned(),
        });
        let words = words.map(Value::String).collect();
        table.insert("allow".to_owned(), Value::Array(words));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fleet(text: &str) -> Result<FleetConfig, String> {
        FleetConfig::of_text(Path::new("cell.toml"), text).map_err(|error| error.to_string())
    }

    #[test]
    fn robots_have_addresses_folders_and_phases_of_their_own() {
        let fleet = fleet(
            "folder = \"/srv/fleet\"\n[defaults]\nmodel = \"cs66\"\nmemory = \"1GB\"\nrecord = \"off\"\n\
             [[robot]]\nname = \"left\"\n[[robot]]\nname = \"right\"\nmodel = \"cs612\"\nstep_ms = 2\n\
             cell = \"cells/right.toml\"\n[[robot]]\nname = \"spare\"\nbind = \"127.0.1.1\"\nmemory = \"2GB\"\n",
        )
        .unwrap();
        assert_eq!(fleet.http_port, PortSetting::Number(8090));
        let addresses: Vec<String> = fleet.robots.iter().map(|r| r.bind.to_string()).collect();
        assert_eq!(addresses, ["127.0.0.11", "127.0.0.12", "127.0.1.1"]);
        let configs: Vec<ServeConfig> = fleet
            .robots
            .iter()
            .map(|robot| ServeConfig::of_text(Path::new("robot.toml"), &robot.config).unwrap())
            .collect();
        let phases: Vec<u128> = configs
            .iter()
            .map(|config| config.robot.cycle_phase.unwrap().as_micros())
            .collect();
        assert_eq!(phases, [0, 666, 2666]);
        assert_eq!(configs[1].robot.model.to_string(), "cs612");
        assert!(configs[1].robot.cell.as_ref().unwrap().is_absolute());
        assert_eq!(fleet.robots[0].folder, Path::new("/srv/fleet/left"));
        let memory: Vec<Option<u64>> = fleet.robots.iter().map(|robot| robot.memory).collect();
        assert_eq!(
            memory,
            [
                Some(1_000_000_000),
                Some(1_000_000_000),
                Some(2_000_000_000)
            ]
        );
    }

    #[test]
    fn each_mistake_is_one_sentence_with_the_robot_and_the_key() {
        let robot = "[[robot]]\nname = \"a\"\n";
        for (text, said) in [
            ("", "there is no robot"),
            ("robot = 1\n", "there is no robot"),
            ("x = \n", "cell.toml: "),
            ("[[robot]]\nmodel = \"cs66\"\n", "robot 1 has no `name`"),
            (
                "[[robot]]\nname = \"../x\"\n",
                "robot 1: `name` is \"../x\"",
            ),
            (&format!("{robot}{robot}"), "two robots are called a"),
            (
                &format!("{robot}bind = \"127.0.0.12\"\n[[robot]]\nname = \"b\"\n"),
                "the address 127.0.0.12",
            ),
            (
                &format!("{robot}modle = \"cs66\"\n"),
                "robot a: cell.toml has an unknown key `modle`",
            ),
            (
                &format!("{robot}step-ms = 9\n"),
                "robot a: cell.toml: `step-ms` is 9",
            ),
            (
                &format!("{robot}memory = 5\n"),
                "robot a: `memory` is \"5\"",
            ),
            (
                &format!("{robot}ready-file = \"x\"\n"),
                "robot a: `ready-file` is the fleet's",
            ),
            (&format!("speed = 1\n{robot}"), "unknown key `speed`"),
            (
                &format!("http-port = \"x\"\n{robot}"),
                "`http-port` is \"x\"",
            ),
            (&format!("bind = \"here\"\n{robot}"), "`bind` is \"here\""),
            (&format!("trust-host = \"a\"\n{robot}"), "`trust-host` is"),
            (
                &format!("[defaults]\nname = \"x\"\n{robot}"),
                "`name` belongs to a robot",
            ),
            (
                &format!("[defaults]\nrecord = \"x.mcap\"\n{robot}"),
                "`record` in [defaults]",
            ),
            (
                &format!("step_ms = 1\nstep-ms = 2\n{robot}"),
                "`step-ms` is given twice",
            ),
        ] {
            let error = fleet(text).unwrap_err();
            assert!(error.contains(said), "{text:?}: {error}");
        }
    }
}
