//! What a translation says about what it changed.

use core::fmt;

use messages::{Language, Localized, Text, text};

/// A remark about one line of the original.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// Line of the original, from 1.
    pub line: u32,
    /// What kind of change.
    pub kind: MessageKind,
    /// The function or variable it is about.
    pub name: String,
    /// A sentence.
    pub text: Text,
}

/// Kinds of remarks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum MessageKind {
    /// EliteScript has another name for the function.
    Renamed,
    /// Arguments, defaults or effects differ.
    Changed,
    /// A conversion or a function was added.
    Helper,
    /// Nothing here does it: the translated line raises `NotImplementedError`.
    Missing,
}

impl MessageKind {
    /// Word for the kind in JSON.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Renamed => "renamed",
            Self::Changed => "changed",
            Self::Helper => "helper",
            Self::Missing => "missing",
        }
    }

    /// The word for the kind as people are told it.
    const fn title(self) -> Text {
        match self {
            Self::Renamed => text!("renamed", "改名"),
            Self::Changed => text!("changed", "改动"),
            Self::Helper => text!("helper", "添加"),
            Self::Missing => text!("missing", "缺失"),
        }
    }
}

impl fmt::Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.fmt_in(Language::English, f)
    }
}

impl Localized for Message {
    fn fmt_in(&self, language: Language, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            line, name, text, ..
        } = self;
        let said = text!(
            "line {line}: {}: {name}: {text}",
            "第 {line} 行：{}：{name}：{text}",
            self.kind.title()
        );
        f.write_str(said.in_language(language))
    }
}
