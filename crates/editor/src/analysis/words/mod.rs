//! The words around what editors show, in English and Chinese. The texts of the functions are in `words/chinese`, those
//! of Python's own names in `words/python`.

mod chinese;
mod python;

use std::borrow::Cow;

use elite_runtime::builtins::declare::Builtin;
use elite_syntax::Diagnostic;

/// A language that people read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Language {
    /// English.
    #[default]
    English,
    /// Chinese.
    Chinese,
}

impl Language {
    /// The language of a locale such as `zh-CN` or `en`.
    pub fn of_locale(locale: &str) -> Self {
        match locale
            .get(..2)
            .is_some_and(|two| two.eq_ignore_ascii_case("zh"))
        {
            true => Language::Chinese,
            false => Language::English,
        }
    }

    /// One of two texts.
    pub fn pick<'t>(self, english: &'t str, chinese: &'t str) -> &'t str {
        match self {
            Language::English => english,
            Language::Chinese => chinese,
        }
    }

    /// What a function of the robot does, in one sentence.
    pub fn summary(self, builtin: &Builtin) -> &'static str {
        match self {
            Language::English => builtin.summary,
            Language::Chinese => chinese::summary(builtin.name).unwrap_or(builtin.summary),
        }
    }

    /// What a function, type or exception of Python's own is, in one sentence.
    pub fn python(self, name: &str) -> Option<&'static str> {
        let (english, chinese) = python::sentence(name)?;
        Some(match self {
            Language::English => english,
            Language::Chinese => chinese,
        })
    }

    /// A phrase of a declaration: what a parameter means, what comes back.
    pub fn phrase(self, english: &'static str) -> &'static str {
        match self {
            Language::English => english,
            Language::Chinese => chinese::phrase(english).unwrap_or(english),
        }
    }

    /// A finding of `check`.
    pub fn finding(self, finding: &Diagnostic) -> Cow<'_, Diagnostic> {
        match self {
            Language::English => Cow::Borrowed(finding),
            Language::Chinese => Cow::Owned(elite_runtime::chinese::finding(finding)),
        }
    }

    /// A unit as people write it.
    pub fn unit(self, unit: &str) -> String {
        unit.replace("^2", "²").replace("^3", "³")
    }
}
