//! What a client wants a run to be held for: places in the text, functions, exceptions, conditions of the arm.

use std::collections::HashMap;
use std::fmt;
use std::path::{Path, PathBuf};

use elite_lang::debug::Place;
use serde::Deserialize;

/// Most breakpoints of each kind; what is beyond is refused.
pub const BREAKPOINTS_MAX: usize = 1000;

/// When a breakpoint that is met counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HitCondition {
    /// The n-th time.
    Exactly(u64),
    /// From then on.
    From(u64),
    /// After it.
    After(u64),
    /// Before it.
    Before(u64),
    /// Up to it.
    UpTo(u64),
    /// Every n-th time.
    Every(u64),
}

impl fmt::Display for HitCondition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exactly(n) => write!(f, "{n}"),
            Self::From(n) => write!(f, ">= {n}"),
            Self::After(n) => write!(f, "> {n}"),
            Self::Before(n) => write!(f, "< {n}"),
            Self::UpTo(n) => write!(f, "<= {n}"),
            Self::Every(n) => write!(f, "% {n}"),
        }
    }
}

impl HitCondition {
    /// Reads `3`, `== 3`, `>= 4`, `> 4`, `< 4`, `<= 4`, `% 2`.
    ///
    /// # Errors
    /// A sentence.
    pub fn parse(text: &str) -> Result<Option<Self>, String> {
        let text = text.trim();
        if text.is_empty() {
            return Ok(None);
        }
        type Make = fn(u64) -> HitCondition;
        let makes: [(&str, Make); 7] = [
            (">=", Self::From),
            ("<=", Self::UpTo),
            ("==", Self::Exactly),
            (">", Self::After),
            ("<", Self::Before),
            ("%", Self::Every),
            ("", Self::Exactly),
        ];
        let parsed = makes.iter().find_map(|(sign, make)| {
            let number: u64 = text.strip_prefix(sign)?.trim().parse().ok()?;
            Some((number, make(number)))
        });
        match parsed {
            Some((0, Self::Every(_))) | None => Err(format!(
                "the hit condition {text:?} cannot be read; allowed are a number, as in 3, and a comparison, as in >= 4, < 4 or % 2"
            )),
            Some((_, condition)) => Ok(Some(condition)),
        }
    }

    /// Whether the `hits`-th time counts.
    pub fn holds(self, hits: u64) -> bool {
        match self {
            Self::Exactly(n) => hits == n,
            Self::From(n) => hits >= n,
            Self::After(n) => hits > n,
            Self::Before(n) => hits < n,
            Self::UpTo(n) => hits <= n,
            Self::Every(n) => hits.is_multiple_of(n.max(1)),
        }
    }
}

/// A place in the text at which the program is held, or a message is written.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceBreakpoint {
    /// Its number.
    pub id: u64,
    /// Holds only where this expression is true.
    pub condition: Option<String>,
    /// Holds only these times.
    pub hits: Option<HitCondition>,
    /// A message instead of a stop; `{…}` are expressions.
    pub message: Option<String>,
}

/// A function at whose first statement the program is held.
#[derive(Clone, Debug, PartialEq)]
pub struct FunctionBreakpoint {
    /// Its name, with or without that of its class.
    pub name: String,
    /// What else must be true.
    pub at: SourceBreakpoint,
}

/// A condition of the arm, as `replay --find` has it.
#[derive(Clone, Debug, PartialEq)]
pub struct DataBreakpoint {
    /// Its number.
    pub id: u64,
    /// The condition; the run is held when it becomes true.
    pub condition: String,
    /// Holds only these times.
    pub hits: Option<HitCondition>,
}

/// All that a client has asked for.
#[derive(Clone, Debug, Default)]
pub struct Breakpoints {
    /// By line and column of the statement.
    pub places: HashMap<(u32, u32), Vec<SourceBreakpoint>>,
    /// By name.
    pub functions: Vec<FunctionBreakpoint>,
    /// Of the arm.
    pub data: Vec<DataBreakpoint>,
    /// Held at every exception.
    pub caught: bool,
    /// Held at those that end the program.
    pub uncaught: bool,
}

/// A breakpoint as a client sends it.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Wanted {
    /// Line, from 1.
    pub line: u32,
    /// Column, from 1.
    pub column: Option<u32>,
    /// Name of a function.
    pub name: String,
    /// What a data breakpoint is on.
    pub data_id: String,
    /// An expression.
    pub condition: Option<String>,
    /// See [`HitCondition`].
    pub hit_condition: Option<String>,
    /// See [`SourceBreakpoint::message`].
    pub log_message: Option<String>,
}

impl Wanted {
    /// The breakpoint, wherever it is.
    ///
    /// # Errors
    /// A sentence about its hit condition.
    pub fn breakpoint(&self, id: u64) -> Result<SourceBreakpoint, String> {
        let filled = |text: &Option<String>| text.clone().filter(|text| !text.trim().is_empty());
        Ok(SourceBreakpoint {
            id,
            condition: filled(&self.condition),
            hits: self.hits()?,
            message: filled(&self.log_message),
        })
    }

    /// When it counts.
    ///
    /// # Errors
    /// A sentence.
    pub fn hits(&self) -> Result<Option<HitCondition>, String> {
        HitCondition::parse(self.hit_condition.as_deref().unwrap_or(""))
    }
}

/// The statement that a breakpoint binds to: with a column the last one that begins there or before in the line, otherwise
/// the first one of the line or of the next line that has any.
pub fn bind(places: &[Place], line: u32, column: Option<u32>) -> Option<Place> {
    let of_line = |line: u32| places.iter().filter(move |place| place.line == line);
    if let Some(column) = column {
        let before = of_line(line).rfind(|place| place.column <= column);
        if let Some(place) = before {
            return Some(*place);
        }
    }
    places.iter().find(|place| place.line >= line).copied()
}

/// A path as files are compared: as it is on the disk, or as it was given where it is not there.
pub fn same_path(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hit_conditions_are_read_and_count() {
        let counted = |text: &str| {
            let condition = HitCondition::parse(text).unwrap().unwrap();
            (1..=6).filter(|n| condition.holds(*n)).collect::<Vec<_>>()
        };
        assert_eq!(counted("3"), [3]);
        assert_eq!(counted(" >= 4"), [4, 5, 6]);
        assert_eq!(counted("> 4"), [5, 6]);
        assert_eq!(counted("<3"), [1, 2]);
        assert_eq!(counted("<= 3"), [1, 2, 3]);
        assert_eq!(counted("% 2"), [2, 4, 6]);
        assert_eq!(HitCondition::parse("  "), Ok(None));
        for wrong in ["x", "% 0", "-1", ">= ", "3 4", "99999999999999999999999"] {
            assert!(HitCondition::parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn breakpoints_bind_to_statements_also_within_a_line() {
        let place = |line, column| Place { line, column };
        let places = [place(1, 1), place(1, 8), place(3, 1)];
        assert_eq!(bind(&places, 1, None), Some(place(1, 1)));
        assert_eq!(bind(&places, 1, Some(9)), Some(place(1, 8)));
        assert_eq!(bind(&places, 2, None), Some(place(3, 1)));
        assert_eq!(bind(&places, 4, None), None);
    }
}
