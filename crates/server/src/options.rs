//! The values that options of ports and the log take: one text form each, the same on the command line and in the
//! configuration file. Those of the robot are the crate `controller`'s.
//!
//! Every type parses itself and says in one sentence what was wrong and what is allowed. Nothing here opens a file or
//! a socket, and nothing knows which option a value belongs to.

use core::fmt;
use core::str::FromStr;

use controller::options::{OptionSlot, RefusedValue};
use io_bus::ControlMode;
use messages::{Text, text};
use serde_json::Value as Json;

use crate::cli::{RosMiddleware, TextLanguage};

controller::option_values!(
    ControlChoice,
    LogFormat,
    PortSetting,
    RosFactor,
    RosMiddleware,
    RosName,
    RosPrefix,
    RosRate,
    TextLanguage,
    TrustedHost
);

/// Sets an option from JSON: `[0, -1.57, …]` is as good as `"0,-1.57,…"`, and `null` is an option that is not given.
///
/// # Errors
/// [`RefusedValue`]
pub fn fill_from_json(slot: &mut dyn OptionSlot, value: &Json) -> Result<(), RefusedValue> {
    let texts: Vec<String> = match value {
        Json::Null => return Ok(()),
        Json::Array(items) if slot.is_list() => items.iter().map(plain_text).collect(),
        Json::Array(items) => vec![items.iter().map(plain_text).collect::<Vec<_>>().join(",")],
        single => vec![plain_text(single)],
    };
    slot.fill(&texts)
}

/// A value of JSON as it would be typed.
pub fn plain_text(value: &Json) -> String {
    match value {
        Json::String(text) => text.clone(),
        // Without the ".0" that JSON gives whole numbers.
        Json::Number(number) if number.is_f64() => {
            number.as_f64().map_or_else(String::new, |x| x.to_string())
        }
        other => other.to_string(),
    }
}

/// The port that a service listens on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PortSetting {
    /// The service is not started.
    Off,
    /// Any free port.
    Any,
    /// This port.
    Number(u16),
    /// The first where this user may open it, else the second: a default that needs a privilege.
    Either(u16, u16),
}

impl FromStr for PortSetting {
    type Err = Text;

    fn from_str(text: &str) -> Result<Self, Text> {
        match (text, text.parse()) {
            ("off", _) => Ok(Self::Off),
            (_, Ok(0)) => Ok(Self::Any),
            (_, Ok(number)) => Ok(Self::Number(number)),
            _ => Err(text!(
                "allowed are a port from 1 to 65535, 0 for any free port, and off",
                "允许 1 到 65535 的端口、0（任一空闲端口）和 off"
            )),
        }
    }
}

impl fmt::Display for PortSetting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Off => f.write_str("off"),
            Self::Any => f.write_str("0"),
            Self::Number(number) | Self::Either(number, _) => write!(f, "{number}"),
        }
    }
}

/// Who controls the robot when the server starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ControlChoice(pub ControlMode);

impl FromStr for ControlChoice {
    type Err = Text;

    fn from_str(text: &str) -> Result<Self, Text> {
        let modes = [ControlMode::Remote, ControlMode::Local, ControlMode::Mixed];
        let named = modes.into_iter().find(|mode| mode.name() == text);
        named.map(Self).ok_or_else(|| {
            text!(
                "allowed are remote, local and mixed",
                "允许 remote、local 和 mixed"
            )
        })
    }
}

/// A namespace of ROS 2, with its slash.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RosName(pub String);

impl Default for RosName {
    fn default() -> Self {
        Self("/".to_owned())
    }
}

impl FromStr for RosName {
    type Err = Text;

    fn from_str(text: &str) -> Result<Self, Text> {
        ros2::names::namespace(text)
            .map(Self)
            .map_err(|error| Text::of(&error))
    }
}

/// What joints and frames of ROS 2 begin with.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RosPrefix(pub String);

impl FromStr for RosPrefix {
    type Err = Text;

    fn from_str(text: &str) -> Result<Self, Text> {
        ros2::names::prefix(text)
            .map(Self)
            .map_err(|error| Text::of(&error))
    }
}

/// Messages a second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RosRate(pub f64);

impl FromStr for RosRate {
    type Err = Text;

    fn from_str(text: &str) -> Result<Self, Text> {
        match text.parse() {
            Ok(rate) if (0.1..=1000.0).contains(&rate) => Ok(Self(rate)),
            _ => Err(text!(
                "allowed are 0.1 to 1000 messages a second",
                "允许每秒 0.1 到 1000 条消息"
            )),
        }
    }
}

/// Simulated seconds a second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RosFactor(pub f64);

impl FromStr for RosFactor {
    type Err = Text;

    fn from_str(text: &str) -> Result<Self, Text> {
        match text.parse() {
            Ok(factor) if (0.001..=1000.0).contains(&factor) => Ok(Self(factor)),
            _ => Err(text!(
                "allowed are factors from 0.001 to 1000",
                "允许 0.001 到 1000 的系数"
            )),
        }
    }
}

/// A name, or an address, by which this machine is called beside its own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TrustedHost(pub String);

impl FromStr for TrustedHost {
    type Err = Text;

    fn from_str(text: &str) -> Result<Self, Text> {
        let is_name = |text: &str| {
            text.bytes()
                .all(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'-'))
        };
        let is_one = text.parse::<std::net::IpAddr>().is_ok() || is_name(text);
        if text.is_empty() || !is_one {
            return Err(text!(
                "allowed are a host name or an IP address, without a port",
                "允许主机名或 IP 地址，不带端口"
            ));
        }
        Ok(Self(text.to_owned()))
    }
}

/// How log lines look.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LogFormat {
    /// Plain text for people.
    #[default]
    Text,
    /// One JSON object a line.
    Json,
}

impl FromStr for LogFormat {
    type Err = Text;

    fn from_str(text: &str) -> Result<Self, Text> {
        match text {
            "text" => Ok(Self::Text),
            "json" => Ok(Self::Json),
            _ => Err(text!("allowed are text and json", "允许 text 和 json")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ports_are_numbers_any_or_off() {
        assert_eq!("off".parse(), Ok(PortSetting::Off));
        assert_eq!("0".parse(), Ok(PortSetting::Any));
        assert_eq!("30001".parse(), Ok(PortSetting::Number(30001)));
        for wrong in ["65536", "-1", "on", ""] {
            assert!(wrong.parse::<PortSetting>().is_err(), "{wrong}");
        }
    }
}
