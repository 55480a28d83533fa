//! The words around what editors show, in English and Chinese. The texts of the functions are in `words/chinese`, those
//! of Python's own names in `words/python`.

mod chinese;
mod python;

use std::borrow::Cow;

use elite_runtime::builtins::declare::Builtin;
use elite_syntax::Diagnostic;
pub use messages::Language;

/// The texts around what editors show, in the language of the person who reads them.
pub trait LanguageWords {
    /// What a function of the robot does, in one sentence.
    fn summary(self, builtin: &Builtin) -> &'static str;

    /// What a function, type or exception of Python's own is, in one sentence.
    fn python(self, name: &str) -> Option<&'static str>;

    /// A phrase of a declaration: what a parameter means, what comes back.
    fn phrase(self, english: &'static str) -> &'static str;

    /// A finding of `check`.
    fn finding(self, finding: &Diagnostic) -> Cow<'_, Diagnostic>;

    /// A unit as people write it.
    fn unit(self, unit: &str) -> String;
}

impl LanguageWords for Language {
    fn summary(self, builtin: &Builtin) -> &'static str {
        match self {
            Language::English => builtin.summary,
            Language::Chinese => chinese::summary(builtin.name).unwrap_or(builtin.summary),
        }
    }

    fn python(self, name: &str) -> Option<&'static str> {
        let (english, chinese) = python::sentence(name)?;
        Some(match self {
            Language::English => english,
            Language::Chinese => chinese,
        })
    }

    fn phrase(self, english: &'static str) -> &'static str {
        match self {
            Language::English => english,
            Language::Chinese => chinese::phrase(english).unwrap_or(english),
        }
    }

    fn finding(self, finding: &Diagnostic) -> Cow<'_, Diagnostic> {
        match self {
            Language::English => Cow::Borrowed(finding),
            Language::Chinese => Cow::Owned(elite_runtime::chinese::finding(finding)),
        }
    }

    fn unit(self, unit: &str) -> String {
        unit.replace("^2", "²").replace("^3", "³")
    }
}
