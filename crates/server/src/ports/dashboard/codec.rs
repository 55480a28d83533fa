//! Commands and replies of the dashboard. Pure.
//!
//! Replies are what the official SDK compares or matches (source/Dashboard/DashboardClient.cpp); where it accepts any
//! line the wording is ours. Every reply is one write of at most [`REPLY_BYTES_MAX`]: the SDK reads the rest of a
//! longer one as the reply to its next command.

use motion_api::{RobotMode, SafetyMode};

use io_bus::ControlMode;

use crate::ports::description::{CONTROLLER_VERSION, TaskStatus};

/// The longest line, bytes.
pub const LINE_BYTES_MAX: usize = 64 * 1024;

/// The longest reply, bytes.
pub const REPLY_BYTES_MAX: usize = 512;

/// Sent on accept, in one write: the vendor's SDK takes what one read brings before it asks anything. The first line is
/// the vendor's, the others say what theirs say.
pub fn greeting() -> String {
    let version = CONTROLLER_VERSION.map(|part| part.to_string()).join(".");
    format!(
        "EliRobot dashboard shell, version {version}\r\nType 'help' to see the list of commands.\r\n\
         Type 'help name' to find out what the command 'name' does.\r\n\
         Type 'usage name' to find out how the command 'name' is used."
    )
}

/// Range of the speed slider in commands, percent.
pub const SPEED_PERCENT: core::ops::RangeInclusive<u32> = 2..=100;

/// What a client asks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DashboardCommand {
    /// `echo`
    Echo,
    /// `robotControl -on` or `-off`
    Power(bool),
    /// `brakeRelease`
    BrakeRelease,
    /// `closeSafetyDialog`
    CloseSafetyDialog,
    /// `unlockProtectiveStop`
    UnlockProtectiveStop,
    /// `safety -r`
    RestartSafetyBoard,
    /// `safety -m`
    SafetyMode,
    /// `safety -s`
    SafetyStatus,
    /// `robotMode`
    RobotMode,
    /// `status`
    Status,
    /// `speed`
    Speed,
    /// `speed -v 50`
    SetSpeed(u32),
    /// `version`
    Version,
    /// `robot -t`
    RobotType,
    /// `robot -s`
    SerialNumber,
    /// `robot -id`
    RobotId,
    /// `log -a text`
    Log(String),
    /// `popup -s text`
    ShowPopup(String),
    /// `popup -c`
    ClosePopup,
    /// `task`
    TaskPath,
    /// `task -p path`
    LoadTask(String),
    /// `task -s`
    TaskStatus,
    /// `task -r`
    TaskIsRunning,
    /// `task -ss`
    TaskIsSaved,
    /// `play`
    Play,
    /// `pause`
    Pause,
    /// `stop`
    Stop,
    /// `configuration`
    ConfigurationPath,
    /// `configuration -p path`
    LoadConfiguration(String),
    /// `configuration -s`
    ConfigurationIsModified,
    /// `remoteControl -on` or `-off`
    SetRemoteControl(bool),
    /// `remoteControl -s`
    RemoteControl,
    /// `variable -get name`
    GetVariable(String),
    /// `variable -set name value`
    SetVariable(String, String),
    /// `clear -a`
    ClearAlarms,
    /// `help`, `help name …`; also `usage`
    Help(Vec<String>),
    /// `quit`
    Quit,
    /// `reboot`
    Reboot,
    /// `shutdown`
    Shutdown,
}

/// A reason why a line is no command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CommandError {
    /// No such command.
    Unknown,
    /// The command exists, its argument is wrong; with how it is used.
    Usage(&'static str),
}

/// Every command with how it is used.
const USAGES: [(&str, &str); 26] = [
    ("brakeRelease", "brakeRelease"),
    ("clear", "clear -a"),
    ("closeSafetyDialog", "closeSafetyDialog"),
    ("configuration", "configuration [-p path | -s]"),
    ("echo", "echo"),
    ("help", "help [command ...]"),
    ("log", "log -a text"),
    ("pause", "pause"),
    ("play", "play"),
    ("popup", "popup -s text | -c"),
    ("quit", "quit"),
    ("reboot", "reboot"),
    ("remoteControl", "remoteControl -on | -off | -s"),
    ("robot", "robot -t | -s | -id"),
    ("robotControl", "robotControl -on | -off"),
    ("robotMode", "robotMode"),
    ("safety", "safety -m | -s | -r"),
    ("shutdown", "shutdown"),
    ("speed", "speed [-v percent, 2 to 100]"),
    ("status", "status"),
    ("stop", "stop"),
    ("task", "task [-p path | -s | -r | -ss]"),
    ("unlockProtectiveStop", "unlockProtectiveStop"),
    ("usage", "usage [command ...]"),
    ("variable", "variable -get name | -set name value"),
    ("version", "version"),
];

fn usage_of(name: &str) -> Option<&'static str> {
    USAGES
        .iter()
        .find(|(known, _)| *known == name)
        .map(|(_, usage)| *usage)
}

/// Reads a line.
///
/// # Errors
/// [`CommandError`] for what is no command.
pub fn parse(line: &str) -> Result<DashboardCommand, CommandError> {
    let line = line.trim();
    let (name, rest) = match line.split_once(char::is_whitespace) {
        Some((name, rest)) => (name, rest.trim()),
        None => (line, ""),
    };
    let usage = usage_of(name).ok_or(CommandError::Unknown)?;
    command(name, rest).ok_or(CommandError::Usage(usage))
}

fn command(name: &str, rest: &str) -> Option<DashboardCommand> {
    let (flag, argument) = match rest.split_once(char::is_whitespace) {
        Some((flag, argument)) => (flag, argument.trim()),
        None => (rest, ""),
    };
    let text = || (!argument.is_empty()).then(|| argument.to_owned());
    Some(match (name, flag) {
        ("help" | "usage", _) => {
            DashboardCommand::Help(rest.split_whitespace().map(str::to_owned).collect())
        }
        // The SDK writes the text right after `-s`; people leave a blank, which is no part of it.
        ("popup", _) if rest.starts_with("-s") => {
            let text = &rest[2..];
            DashboardCommand::ShowPopup(text.strip_prefix(' ').unwrap_or(text).to_owned())
        }
        ("log", "-a") => DashboardCommand::Log(argument.replace("\\n", "\n")),
        ("task", "-p") => DashboardCommand::LoadTask(text()?),
        ("configuration", "-p") => DashboardCommand::LoadConfiguration(text()?),
        ("variable", "-get") => DashboardCommand::GetVariable(text()?),
        ("variable", "-set") => {
            let (name, value) = argument.split_once(char::is_whitespace)?;
            DashboardCommand::SetVariable(name.to_owned(), value.trim().to_owned())
        }
        ("speed", "-v") => {
            let percent = argument.trim_end_matches('%').trim_end().parse().ok()?;
            SPEED_PERCENT
                .contains(&percent)
                .then_some(DashboardCommand::SetSpeed(percent))?
        }
        // Everything below takes no argument.
        _ if !argument.is_empty() => return None,
        ("echo", "") => DashboardCommand::Echo,
        ("popup", "-c") => DashboardCommand::ClosePopup,
        ("robotControl", "-on") => DashboardCommand::Power(true),
        ("robotControl", "-off") => DashboardCommand::Power(false),
        ("brakeRelease", "") => DashboardCommand::BrakeRelease,
        ("closeSafetyDialog", "") => DashboardCommand::CloseSafetyDialog,
        ("unlockProtectiveStop", "") => DashboardCommand::UnlockProtectiveStop,
        ("safety", "-r") => DashboardCommand::RestartSafetyBoard,
        ("safety", "-m") => DashboardCommand::SafetyMode,
        ("safety", "-s") => DashboardCommand::SafetyStatus,
        ("robotMode", "") => DashboardCommand::RobotMode,
        ("status", "") => DashboardCommand::Status,
        ("speed", "") => DashboardCommand::Speed,
        ("version", "") => DashboardCommand::Version,
        ("robot", "-t") => DashboardCommand::RobotType,
        ("robot", "-s") => DashboardCommand::SerialNumber,
        ("robot", "-id") => DashboardCommand::RobotId,
        ("task", "") => DashboardCommand::TaskPath,
        ("task", "-s") => DashboardCommand::TaskStatus,
        ("task", "-r") => DashboardCommand::TaskIsRunning,
        ("task", "-ss") => DashboardCommand::TaskIsSaved,
        ("play", "") => DashboardCommand::Play,
        ("pause", "") => DashboardCommand::Pause,
        ("stop", "") => DashboardCommand::Stop,
        ("configuration", "") => DashboardCommand::ConfigurationPath,
        ("configuration", "-s") => DashboardCommand::ConfigurationIsModified,
        ("remoteControl", "-on") => DashboardCommand::SetRemoteControl(true),
        ("remoteControl", "-off") => DashboardCommand::SetRemoteControl(false),
        ("remoteControl", "-s" | "-status") => DashboardCommand::RemoteControl,
        ("clear", "-a") => DashboardCommand::ClearAlarms,
        ("quit", "") => DashboardCommand::Quit,
        ("reboot", "") => DashboardCommand::Reboot,
        ("shutdown", "") => DashboardCommand::Shutdown,
        _ => return None,
    })
}

impl DashboardCommand {
    /// Whether the answer depends on what commands of the same kind before this one have made of the task.
    pub const fn concerns_the_task(&self) -> bool {
        matches!(
            self,
            Self::LoadTask(_)
                | Self::LoadConfiguration(_)
                | Self::Play
                | Self::Pause
                | Self::TaskPath
                | Self::ConfigurationPath
                | Self::GetVariable(_)
                | Self::SetVariable(..)
        )
    }

    /// The commands that a real controller was seen to refuse while remote control is off, and their like.
    pub const fn word_needing_remote_control(&self) -> Option<&'static str> {
        match self {
            Self::Play => Some("play"),
            Self::Pause => Some("pause"),
            Self::Stop => Some("stop"),
            Self::LoadTask(_) => Some("task"),
            Self::LoadConfiguration(_) => Some("configuration"),
            // A program changes it.
            Self::SetVariable(..) => Some("variable"),
            _ => None,
        }
    }
}

/// The reply to a line that is no command.
pub fn mistake(line: &str, mistake: &CommandError) -> String {
    match mistake {
        CommandError::Unknown => {
            let word = line.split_whitespace().next().unwrap_or_default();
            let word: String = word.chars().take(60).collect();
            format!("Command [{word}] is not found. Please use \"help\".")
        }
        CommandError::Usage(usage) => format!("Usage: {usage}"),
    }
}

/// The reply to `help`.
pub fn help(names: &[String]) -> String {
    if names.is_empty() {
        let names = USAGES.iter().map(|(name, _)| *name);
        return format!("Commands: {}", names.collect::<Vec<_>>().join(" "));
    }
    let lines: Vec<String> = names
        .iter()
        .map(|name| match usage_of(name) {
            Some(usage) => format!("Usage: {usage}"),
            None => mistake(name, &CommandError::Unknown),
        })
        .collect();
    lines.join("\r\n")
}

/// The reply to a command that is refused where remote control is off. Only the sentence of local mode is the vendor's.
pub fn needs_remote_control(word: &str, mode: ControlMode) -> String {
    match mode {
        ControlMode::Mixed => format!(
            "Command [{word}] is not supported while remote control is disabled in the settings. Please enable \
             remote control first."
        ),
        ControlMode::Local | ControlMode::Remote => format!(
            "Command [{word}] is not supported in local control mode. Please close local control mode first."
        ),
    }
}

/// The reply to `status`, as the vendor prints a session of it.
pub fn status(
    robot: RobotMode,
    safety: SafetyMode,
    task: TaskStatus,
    speed_fraction: f64,
) -> String {
    format!(
        "Target Speed Fraction: {}\r\nRobotMode: {}\r\nSafetyMode: {}\r\nRunningStatus: {}",
        percent(speed_fraction),
        robot_mode_word(robot),
        safety.name(),
        match task {
            TaskStatus::Stopped => "STOP",
            TaskStatus::Running => "RUNNING",
            TaskStatus::Paused => "PAUSE",
        },
    )
}

/// A fraction as whole percent.
pub fn percent(fraction: f64) -> u32 {
    (fraction * 100.0).round() as u32
}

/// The words of this port, two of which differ from those elsewhere: anything else is UNKNOWN for the SDK.
pub const fn robot_mode_word(mode: RobotMode) -> &'static str {
    match mode {
        RobotMode::Backdrive => "BACK_DRIVE",
        RobotMode::UpdatingFirmware => "UPDATING",
        other => other.name(),
    }
}

/// The bytes of a reply: lines end with `\r\n`, the whole is cut to fit, at a character. What clients and programs put
/// into a reply cannot end its line: other control characters become blanks.
pub fn encode(reply: &str) -> Vec<u8> {
    let room = REPLY_BYTES_MAX - 2;
    let reply = &reply[..reply.floor_char_boundary(room)];
    let lines: Vec<String> = reply
        .split("\r\n")
        .map(|line| line.replace(char::is_control, " "))
        .collect();
    // A control character of two bytes becomes one: nothing gets longer.
    let mut bytes = lines.join("\r\n").into_bytes();
    bytes.extend(b"\r\n");
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_the_sdk_sends_is_understood() {
        let text = |text: &str| text.to_owned();
        for (line, command) in [
            ("echo", DashboardCommand::Echo),
            ("robotControl -on", DashboardCommand::Power(true)),
            ("robotControl  -off ", DashboardCommand::Power(false)),
            ("brakeRelease", DashboardCommand::BrakeRelease),
            ("closeSafetyDialog", DashboardCommand::CloseSafetyDialog),
            (
                "unlockProtectiveStop",
                DashboardCommand::UnlockProtectiveStop,
            ),
            ("safety -r", DashboardCommand::RestartSafetyBoard),
            ("safety -m", DashboardCommand::SafetyMode),
            ("safety -s", DashboardCommand::SafetyStatus),
            ("robotMode", DashboardCommand::RobotMode),
            ("status", DashboardCommand::Status),
            ("speed -v 50", DashboardCommand::SetSpeed(50)),
            ("speed", DashboardCommand::Speed),
            ("version", DashboardCommand::Version),
            ("robot -t", DashboardCommand::RobotType),
            ("robot -s", DashboardCommand::SerialNumber),
            ("robot -id", DashboardCommand::RobotId),
            (
                r"log -a two\nlines",
                DashboardCommand::Log(text("two\nlines")),
            ),
            (
                "popup -shello there",
                DashboardCommand::ShowPopup(text("hello there")),
            ),
            ("popup -s hello", DashboardCommand::ShowPopup(text("hello"))),
            ("popup -s", DashboardCommand::ShowPopup(text(""))),
            ("popup -c", DashboardCommand::ClosePopup),
            (
                "task -p my tasks/a.task",
                DashboardCommand::LoadTask(text("my tasks/a.task")),
            ),
            ("task", DashboardCommand::TaskPath),
            ("task -s", DashboardCommand::TaskStatus),
            ("task -r", DashboardCommand::TaskIsRunning),
            ("task -ss", DashboardCommand::TaskIsSaved),
            ("play", DashboardCommand::Play),
            ("pause", DashboardCommand::Pause),
            ("stop", DashboardCommand::Stop),
            (
                "configuration -p a.configuration",
                DashboardCommand::LoadConfiguration(text("a.configuration")),
            ),
            ("configuration", DashboardCommand::ConfigurationPath),
            (
                "configuration -s",
                DashboardCommand::ConfigurationIsModified,
            ),
            (
                "help a b",
                DashboardCommand::Help(vec![text("a"), text("b")]),
            ),
            ("usage", DashboardCommand::Help(vec![])),
            ("quit", DashboardCommand::Quit),
            ("reboot", DashboardCommand::Reboot),
            ("shutdown", DashboardCommand::Shutdown),
            ("remoteControl -status", DashboardCommand::RemoteControl),
            ("variable -get a", DashboardCommand::GetVariable(text("a"))),
            (
                "variable -set a [1, 2]",
                DashboardCommand::SetVariable(text("a"), text("[1, 2]")),
            ),
            ("clear -a", DashboardCommand::ClearAlarms),
        ] {
            assert_eq!(parse(line), Ok(command), "{line}");
        }
    }

    #[test]
    fn what_is_no_command_is_told_so() {
        for (line, reply) in [
            ("xyz -a", "Command [xyz] is not found. Please use \"help\"."),
            ("Play", "Command [Play] is not found. Please use \"help\"."),
            ("robotControl", "Usage: robotControl -on | -off"),
            ("speed -v 1", "Usage: speed [-v percent, 2 to 100]"),
            ("speed -v 101", "Usage: speed [-v percent, 2 to 100]"),
            ("play now", "Usage: play"),
            ("popup -c now", "Usage: popup -s text | -c"),
            ("task -p", "Usage: task [-p path | -s | -r | -ss]"),
            (
                "variable -set a",
                "Usage: variable -get name | -set name value",
            ),
        ] {
            let found = parse(line).unwrap_err();
            assert_eq!(mistake(line, &found), reply, "{line}");
        }
    }

    #[test]
    fn replies_fit_one_read_of_the_sdk() {
        let names: Vec<String> = vec!["status".to_owned(); 100];
        for reply in [
            greeting(),
            help(&[]),
            help(&names),
            mistake(&"x".repeat(9999), &CommandError::Unknown),
        ] {
            assert!(encode(&reply).len() <= REPLY_BYTES_MAX, "{reply}");
        }
        assert!(help(&[]).len() <= REPLY_BYTES_MAX - 2, "the list is whole");
        assert_eq!(encode("a\rb\nc\r\nd\0\u{85}e"), b"a b c\r\nd  e\r\n");
        let cut = encode(&"é".repeat(400));
        assert_eq!(cut.len(), REPLY_BYTES_MAX);
        assert!(core::str::from_utf8(&cut).is_ok());
        assert_eq!(
            help(&["task".to_owned(), "x".to_owned()]),
            "Usage: task [-p path | -s | -r | -ss]\r\nCommand [x] is not found. Please use \"help\"."
        );
    }

    #[test]
    fn status_has_the_labels_that_clients_look_for() {
        assert_eq!(
            status(
                RobotMode::Backdrive,
                SafetyMode::Normal,
                TaskStatus::Paused,
                0.29
            ),
            "Target Speed Fraction: 29\r\nRobotMode: BACK_DRIVE\r\nSafetyMode: NORMAL\r\nRunningStatus: PAUSE"
        );
    }

    #[test]
    fn robot_modes_have_the_words_that_the_sdk_knows() {
        let known = [
            "NO_CONTROLLER",
            "DISCONNECTED",
            "CONFIRM_SAFETY",
            "BOOTING",
            "POWER_OFF",
            "POWER_ON",
            "IDLE",
            "BACK_DRIVE",
            "RUNNING",
            "UPDATING",
            "WAITING_CALIBRATION",
        ];
        let words: Vec<_> = (-1..=9)
            .map(|n| robot_mode_word(RobotMode::from_number(n)))
            .collect();
        assert_eq!(words, known);
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]
        #[test]
        fn any_line_gets_a_reply(line in "[a-zA-Z]{0,8} ?-?[a-z]{0,3} ?.{0,40}") {
            if let Err(found) = parse(&line) {
                prop_assert!(!mistake(&line, &found).is_empty());
            }
        }
    }
}
