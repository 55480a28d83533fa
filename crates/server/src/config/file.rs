//! The configuration file: TOML whose keys are the long names of the options of `serve`.

use std::collections::BTreeSet;
use std::path::Path;

use controller::cell::line_of;
use controller::options::{OptionSlot, OptionValue, keys_of};
use controller::read_text_within;
use elite_runtime::SandboxRoots;
use messages::{Text, text};

use super::{ConfigError, ros2};
use crate::cli::ServeArgs;

/// A time of a `test.toml` above 0, s.
#[derive(Clone, Copy)]
pub(super) struct TestSeconds(pub(super) f64);

impl OptionValue for TestSeconds {
    fn from_option(text: &str) -> Result<Self, Text> {
        crate::cli::seconds_of_test(text).map(Self)
    }
}

/// Times of a `test.toml`.
#[derive(Default)]
pub(super) struct TestTimes {
    pub(super) timeout: Option<TestSeconds>,
    pub(super) wall_timeout: Option<TestSeconds>,
}

/// Keys that only a `test.toml` has.
const TEST_KEYS: [&str; 2] = ["timeout", "wall-timeout"];

impl TestTimes {
    fn slot(&mut self, key: &str) -> Option<&mut dyn OptionSlot> {
        Some(match key {
            "timeout" => &mut self.timeout,
            "wall-timeout" => &mut self.wall_timeout,
            _ => return None,
        })
    }
}

/// Fills what was not typed from the configuration file, if one is named.
pub(super) fn with_file(
    args: ServeArgs,
    within: Option<&SandboxRoots>,
) -> Result<ServeArgs, ConfigError> {
    with_file_and(args, within, None)
}

pub(super) fn with_file_and(
    mut args: ServeArgs,
    within: Option<&SandboxRoots>,
    times: Option<&mut TestTimes>,
) -> Result<ServeArgs, ConfigError> {
    let Some(path) = args.shared.config.take() else {
        return Ok(args);
    };
    let text = match read_text_within(within, &path) {
        Ok(text) => text,
        Err(source) => return Err(ConfigError::Unreadable { path, source }),
    };
    merge_file(&mut args, &path, &text, times)?;
    Ok(args)
}

/// `times`: the file is a `test.toml`.
pub(super) fn merge_file(
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
            message: Text::of_library(&e.message().replace('\n', ", ")),
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
        if key == "ros2" {
            ros2::merge_ros2(&mut args.ros2, path, &entry)?;
        } else if let Some(slot) = args.slot(&key) {
            entry.fill(slot)?;
        } else if let Some(time) = times.as_mut().and_then(|times| times.slot(&key)) {
            entry.fill(time)?;
        } else {
            let of_tests = times.iter().flat_map(|_| TEST_KEYS).map(str::to_owned);
            return Err(ConfigError::UnknownKey {
                path: path.to_owned(),
                key: written.clone(),
                allowed: keys().into_iter().chain(of_tests).collect(),
            });
        }
    }
    Ok(())
}

/// Every key of the file, in alphabetical order: the long names of the options of `serve`, and one of `run`.
pub(super) fn keys() -> Vec<String> {
    let mut keys = keys_of::<ServeArgs>();
    // The file itself, what only a starting process wants, and the node's, which have a table.
    let is_key = |key: &String| {
        !["config", "until-stdin-closes"].contains(&key.as_str()) && !key.starts_with("ros-")
    };
    keys.retain(is_key);
    keys.push("ros2-profile".to_owned());
    keys.sort_unstable();
    keys
}

/// One `key = value` of the file.
pub(super) struct FileEntry<'a> {
    pub(super) path: &'a Path,
    pub(super) key: &'a str,
    pub(super) value: &'a toml::Value,
}

impl FileEntry<'_> {
    /// Reads the value even where an option was typed: a mistake in the file is reported either way.
    pub(super) fn fill(&self, slot: &mut dyn OptionSlot) -> Result<(), ConfigError> {
        let items = match self.value {
            // An empty list is a list: nothing is allowed then.
            toml::Value::Array(items) if slot.is_list() => items.iter().collect(),
            single => vec![single],
        };
        let mut texts = Vec::with_capacity(items.len());
        for item in &items {
            let text = text_of(item);
            texts.push(text.ok_or_else(|| {
                self.refusal(
                    item,
                    text!(
                        "a text, a number or a list of them is needed",
                        "需要文本、数或它们的列表"
                    ),
                )
            })?);
        }
        slot.fill(&texts).map_err(|refused| {
            let at = texts.iter().position(|text| *text == refused.given);
            let item = at.and_then(|at| items.get(at)).unwrap_or(&self.value);
            self.refusal(item, refused.allowed)
        })
    }

    fn refusal(&self, value: &toml::Value, allowed: Text) -> ConfigError {
        ConfigError::BadValue {
            path: self.path.to_owned(),
            key: self.key.to_owned(),
            given: value.to_string().replace('\n', " "),
            allowed,
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
