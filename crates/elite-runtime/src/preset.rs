//! Globals that a program finds set: `NAME=VALUE` as a person types it.
//!
//! Owns what is allowed as name and as value. Who sets them, and where, is the business of a task or of whoever sends a
//! program elsewhere.

use elite_syntax::{Severity, SourceFile, check};
use messages::{Localized, Text, text};
use thiserror::Error;

use crate::builtins::known_names;

/// Most presets of one program.
pub const PRESETS_MAX: usize = 1000;

/// A global that is set before the program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Preset {
    name: String,
    value: String,
}

/// An argument of `--set` that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, Error, Localized)]
#[error("--set {given}: {why}")]
#[zh("--set {given}：{why}")]
pub struct PresetError {
    /// The argument as the user gave it.
    pub given: String,
    /// What is allowed.
    pub why: Text,
}

impl Preset {
    /// Reads `NAME=VALUE`; the value is an expression of EliteScript.
    ///
    /// # Errors
    /// [`PresetError`] says what is allowed.
    pub fn parse(given: &str) -> Result<Self, PresetError> {
        let Some((name, value)) = given.split_once('=') else {
            return Err(PresetError {
                given: given.to_owned(),
                why: text!(
                    "NAME=VALUE is needed, as speed=0.25",
                    "需要 NAME=VALUE，如 speed=0.25"
                ),
            });
        };
        Self::new(name, value)
    }

    /// Makes a preset of a name and the text of its value.
    ///
    /// # Errors
    /// [`PresetError`] says what is allowed.
    pub fn new(name: &str, value: &str) -> Result<Self, PresetError> {
        let (name, value) = (name.trim(), value.trim());
        let wrong = |why| PresetError {
            given: format!("{name}={value}"),
            why,
        };
        let is_name = name
            .chars()
            .next()
            .is_some_and(|c| c.is_alphabetic() || c == '_')
            && name.chars().all(|c| c.is_alphanumeric() || c == '_');
        let known = known_names();
        let found = |text: String| check(SourceFile::new("--set", text), &known);
        if !is_name
            || found(format!("{name} = 1\n"))
                .iter()
                .any(|found| found.severity == Severity::Error)
        {
            return Err(wrong(text!(
                "what stands before = is no name of a variable",
                "= 之前的不是变量名"
            )));
        }
        // In brackets it is one expression, unless it closes them itself; then it is none by itself.
        let in_brackets = found(format!("{name} = ({value})\n"));
        let by_itself = found(format!("{name} = {value}\n"));
        let is_one = !value.is_empty() && !value.contains(['\n', '\r', '#', ';']) || is_text(value);
        if !is_one || !in_brackets.is_empty() || !by_itself.is_empty() {
            return Err(wrong(text!(
                "a value is an expression such as 0.25, [1, 2] or \"text\", the quotes included",
                "值是表达式，如 0.25、[1, 2] 或 \"text\"（包括引号）"
            )));
        }
        Ok(Self {
            name: name.to_owned(),
            value: value.to_owned(),
        })
    }

    /// `NAME=VALUE`, from which [`parse`](Self::parse) makes the same preset.
    pub fn given(&self) -> String {
        format!("{}={}", self.name, self.value)
    }

    /// All of them.
    ///
    /// # Errors
    /// The first [`PresetError`].
    pub fn parse_all(given: &[String]) -> Result<Vec<Self>, PresetError> {
        given.iter().map(|given| Self::parse(given)).collect()
    }

    /// The name of the variable.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The statement that sets the variable.
    pub fn statement(&self) -> String {
        format!("{} = {}", self.name, self.value)
    }
}

/// One text in quotes, in which any character may stand but its end.
fn is_text(value: &str) -> bool {
    let inner = ['"', '\'']
        .iter()
        .find_map(|quote| value.strip_prefix(*quote)?.strip_suffix(*quote));
    inner.is_some_and(|inner| !inner.contains(['"', '\'', '\\', '\n', '\r']))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_expression_with_a_name_is_a_preset() {
        for (given, statement) in [
            ("speed=0.25", "speed = 0.25"),
            (" a_1 = [1, (2, 'x')] ", "a_1 = [1, (2, 'x')]"),
            ("name=\"left; #1\"", "name = \"left; #1\""),
            ("n=-3", "n = -3"),
            ("on=True", "on = True"),
        ] {
            assert_eq!(Preset::parse(given).unwrap().statement(), statement);
        }
        for (given, why) in [
            ("speed", "NAME=VALUE"),
            ("=1", "no name"),
            ("for=1", "no name"),
            ("a.b=1", "no name"),
            ("a=", "expression"),
            ("a=1; b = 2", "expression"),
            ("a=1\nb = 2", "expression"),
            ("a=1)\nb = (2", "expression"),
            ("a=1); b = (2", "expression"),
            ("a=unknown_thing", "expression"),
            ("a=b = 2", "expression"),
            ("a=1 # no", "expression"),
        ] {
            let error = Preset::parse(given).unwrap_err().to_string();
            assert!(error.contains(why), "{given}: {error}");
        }
    }
}
