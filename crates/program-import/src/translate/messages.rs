//! What a translation says about what it changed.

use core::fmt;

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
    pub text: String,
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
}

impl fmt::Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (word, name) = (self.kind.word(), &self.name);
        write!(f, "line {}: {word}: {name}: {}", self.line, self.text)
    }
}
