//! `--set NAME=VALUE`: globals that a program finds set.

use elite_lang::{Severity, SourceFile};
use thiserror::Error;

use crate::ports::text::statements_of_line;

/// A global that is set before the program: `NAME=VALUE`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Setting {
    name: String,
    value: String,
}

/// A setting that is none.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("--set {given}: {why}")]
pub(super) struct SettingError {
    /// As given.
    pub given: String,
    /// What is allowed.
    pub why: &'static str,
}

impl Setting {
    /// Reads `NAME=VALUE`; the value is an expression of EliteScript.
    pub(super) fn parse(given: &str) -> Result<Self, SettingError> {
        let wrong = |why| SettingError {
            given: given.to_owned(),
            why,
        };
        let Some((name, value)) = given.split_once('=') else {
            return Err(wrong("NAME=VALUE is needed, as speed=0.25"));
        };
        let (name, value) = (name.trim(), value.trim());
        let is_name = name
            .chars()
            .next()
            .is_some_and(|c| c.is_alphabetic() || c == '_')
            && name.chars().all(|c| c.is_alphanumeric() || c == '_');
        let known = elite_runtime::builtins::known_names();
        let found = |text: String| elite_lang::check(SourceFile::new("--set", text), &known);
        if !is_name
            || found(format!("{name} = 1\n"))
                .iter()
                .any(|found| found.severity == Severity::Error)
        {
            return Err(wrong("what stands before = is no name of a variable"));
        }
        let is_value =
            "a value is an expression such as 0.25, [1, 2] or \"text\", the quotes included";
        let findings = found(format!("{name} = ({value})\n"));
        // In brackets it is one expression, unless it closes them itself.
        let is_one = statements_of_line(value).len() == 1 && !value.contains(['\n', '#']);
        if !is_one || value.is_empty() || !findings.is_empty() {
            return Err(wrong(is_value));
        }
        Ok(Self {
            name: name.to_owned(),
            value: value.to_owned(),
        })
    }

    /// All of them.
    pub(super) fn parse_all(given: &[String]) -> Result<Vec<Self>, SettingError> {
        given.iter().map(|given| Self::parse(given)).collect()
    }

    /// Of which variable.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// The statement that sets it.
    pub(super) fn statement(&self) -> String {
        format!("{} = {}", self.name, self.value)
    }
}
