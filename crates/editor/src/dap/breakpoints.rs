//! What a client wants a run to be held for: places in the text, functions, exceptions, conditions of the arm.

use std::collections::HashMap;
use std::fmt;
use std::path::{Path, PathBuf};

use controller::condition::{Condition, ConditionError, ProgramPosition};
use elite_syntax::BreakpointLocation;
use elite_syntax::ParsedDocument;
use elite_syntax::ast::StmtKind;
use elite_syntax::{KnownNames, Severity, SourceFile};
use kinematics::JointPositions;
use messages::{Text, text};
use motion_api::RobotState;
use recorder::CycleMessage;
use serde::Deserialize;

/// Most breakpoints of each kind; what is beyond is refused.
pub const BREAKPOINTS_MAX: usize = 1000;

/// Times at which a breakpoint that is met counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HitCondition {
    /// The n-th time only.
    Exactly(u64),
    /// The n-th time and every later one.
    From(u64),
    /// Every time after the n-th.
    After(u64),
    /// Every time before the n-th.
    Before(u64),
    /// Every time up to the n-th.
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
    pub fn parse(text: &str) -> Result<Option<Self>, Text> {
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
            Some((0, Self::Every(_))) | None => Err(text!(
                "the hit condition {text:?} cannot be read; \
                 allowed are a number, as in 3, and a comparison, as in >= 4, < 4 or % 2",
                "无法读取命中条件 {text:?}；应为数（如 3）或比较（如 >= 4、< 4 或 % 2）"
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
    /// Number of the breakpoint.
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
    /// Name of the function, with or without that of its class.
    pub name: String,
    /// What else must be true.
    pub at: SourceBreakpoint,
}

/// A condition of the arm, as `replay --find` has it.
#[derive(Clone, Debug, PartialEq)]
pub struct DataBreakpoint {
    /// Number of the breakpoint.
    pub id: u64,
    /// The condition; the run is held when it becomes true.
    pub condition: String,
    /// Holds only these times.
    pub hits: Option<HitCondition>,
}

/// All that a client has asked for.
#[derive(Clone, Debug, Default)]
pub struct Breakpoints {
    /// Breakpoints by line and column of the statement.
    pub places: HashMap<(u32, u32), Vec<SourceBreakpoint>>,
    /// Breakpoints at the beginning of functions.
    pub functions: Vec<FunctionBreakpoint>,
    /// Breakpoints at conditions of the arm.
    pub data: Vec<DataBreakpoint>,
    /// Held at every exception.
    pub caught: bool,
    /// Held at those that end the program.
    pub uncaught: bool,
}

/// A breakpoint as a client sends it.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct BreakpointRequest {
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
    /// Text of a [`HitCondition`].
    pub hit_condition: Option<String>,
    /// Text of a [`SourceBreakpoint::message`].
    pub log_message: Option<String>,
}

impl BreakpointRequest {
    /// The breakpoint, wherever it is.
    ///
    /// # Errors
    /// A sentence about its condition, its hit condition or its message.
    pub fn breakpoint(&self, id: u64) -> Result<SourceBreakpoint, Text> {
        let filled = |text: &Option<String>| text.clone().filter(|text| !text.trim().is_empty());
        let (condition, message) = (filled(&self.condition), filled(&self.log_message));
        if let Some(condition) = &condition {
            expression(&text!("the condition", "条件"), condition)?;
        }
        for inner in message.iter().flat_map(|message| parts(message)) {
            expression(
                &text!(
                    "what the message shows in {{…}}",
                    "消息在 {{…}} 中显示的内容"
                ),
                inner,
            )?;
        }
        Ok(SourceBreakpoint {
            id,
            condition,
            hits: self.hits()?,
            message,
        })
    }

    /// When it counts.
    ///
    /// # Errors
    /// A sentence.
    pub fn hits(&self) -> Result<Option<HitCondition>, Text> {
        HitCondition::parse(self.hit_condition.as_deref().unwrap_or(""))
    }
}

/// The expressions in a message.
fn parts(message: &str) -> impl Iterator<Item = &str> {
    let opened = message.split('{').skip(1);
    opened.filter_map(|after| Some(after.split_once('}')?.0))
}

/// Whether a text is one expression of a program; `what` is what it was given as.
///
/// # Errors
/// A sentence.
pub fn expression(what: &Text, text: &str) -> Result<(), Text> {
    let Some(why) = unreadable(text.trim()) else {
        return Ok(());
    };
    let shown: String = text.chars().take(SHOWN_MAX).collect();
    Err(text!(
        "{what} is {shown:?}, which {why}; allowed is one expression of the program, as in n > 3",
        "{what}为 {shown:?}，{why}；应为程序的一个表达式，如 n > 3"
    ))
}

/// Most characters of a text that a sentence shows.
const SHOWN_MAX: usize = 200;

fn unreadable(text: &str) -> Option<Text> {
    if text.is_empty() {
        return Some(text!("says nothing", "是空的"));
    }
    let read = |text: String| {
        let none = KnownNames::new(std::iter::empty::<String>());
        let reading = ParsedDocument::of(SourceFile::new("text", text), &none);
        let mut findings = reading.findings().iter();
        if let Some(error) = findings.find(|finding| finding.severity == Severity::Error) {
            return Some(text!("cannot be read: {}", "无法读取：{}", error.message));
        }
        match &reading.module().body[..] {
            [one] if matches!(one.kind, StmtKind::Expr(_)) => None,
            _ => Some(text!("is a statement", "是语句")),
        }
    };
    let why = read(format!("{text}\n"))?;
    // Where it is evaluated it stands in brackets, so that it may have several lines.
    match text.contains('\n') {
        true => read(format!("(\n{text}\n)\n")).map(|_| why),
        false => Some(why),
    }
}

/// Whether a text is a condition of the arm that can be looked at: it is read, and has an answer for an arm at rest.
///
/// # Errors
/// A sentence.
pub fn condition_of_arm(text: &str) -> Result<(), Text> {
    let refused = |why: &Text| {
        let shown: String = text.chars().take(SHOWN_MAX).collect();
        text!(
            "the data breakpoint is {shown:?}: {why}",
            "数据断点 {shown:?}：{why}"
        )
    };
    let condition =
        Condition::new("the data breakpoint", text).map_err(|error| refused(&Text::of(&error)))?;
    let at_rest = RobotState::at_start(JointPositions::ZERO, 0.002);
    match condition.holds(&CycleMessage::from(&at_rest), &ProgramPosition::default()) {
        Err(ConditionError::Raised { report, .. }) => {
            // Other exceptions, as of a division, may be of this one cycle only.
            let always = ["TypeError", "AttributeError", "IndexError", "NameError"];
            let is_so = |line: &&str| always.iter().any(|kind| line.starts_with(kind));
            match report.english().lines().find(is_so) {
                Some(line) => Err(refused(&text!(
                    "it has no answer in any cycle: {line}; \
                     allowed is an expression that is true or false, as in actual_q[0] > 0.5",
                    "它在任何周期都没有答案：{line}；应为真或假的表达式，如 actual_q[0] > 0.5"
                ))),
                None => Ok(()),
            }
        }
        Err(error) => Err(refused(&Text::of(&error))),
        Ok(_) => Ok(()),
    }
}

/// The statement that a breakpoint binds to: with a column the last one that begins there or before in the line,
/// otherwise the first one of the line or of the next line that has any.
pub fn bind(
    places: &[BreakpointLocation],
    line: u32,
    column: Option<u32>,
) -> Option<BreakpointLocation> {
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
    fn texts_that_cannot_be_understood_are_refused_with_what_is_allowed() {
        for right in [
            "x",
            " n > 3 ",
            "f(1)[2]",
            "x if y else z",
            "(1,\n 2)",
            "x >\n3",
            "n # more",
        ] {
            assert_eq!(
                expression(&text!("the condition", "条件"), right),
                Ok(()),
                "{right}"
            );
        }
        for wrong in [
            "x >", "(", "x = 3", "del x", "1\n2", "", "  ", "x)", "return 3", "é é",
        ] {
            let error = expression(&text!("the condition", "条件"), wrong)
                .unwrap_err()
                .to_string();
            assert!(
                error.starts_with(&format!("the condition is {wrong:?}, which ")),
                "{error}"
            );
            assert!(error.contains("allowed is one expression"), "{error}");
        }
        let wanted = |condition: &str, message: &str| BreakpointRequest {
            condition: Some(condition.to_owned()),
            log_message: Some(message.to_owned()),
            ..BreakpointRequest::default()
        };
        assert!(wanted("x", "at {x} and {y[0]}, {").breakpoint(1).is_ok());
        let error = wanted("", "at {x >}")
            .breakpoint(1)
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("the message") && error.contains("\"x >\""),
            "{error}"
        );
        for right in [
            "time > 1",
            "norm(tcp_force[0:3]) > 20",
            "1 / (time - time) > 1",
        ] {
            assert_eq!(condition_of_arm(right), Ok(()), "{right}");
        }
        for (wrong, said) in [
            ("", "empty"),
            ("nothing[0] > 1", "names are"),
            ("actual_q >", "cannot be read"),
            ("actual_q > 3", "TypeError"),
            ("actual_q[9] > 3", "IndexError"),
            ("sum([n for n in range(10 ** 9)])", "too long"),
        ] {
            let error = condition_of_arm(wrong).unwrap_err().to_string();
            assert!(
                error.starts_with(&format!("the data breakpoint is {wrong:?}: ")),
                "{error}"
            );
            assert!(error.contains(said), "{error}");
        }
    }

    #[test]
    fn breakpoints_bind_to_statements_also_within_a_line() {
        let place = |line, column| BreakpointLocation { line, column };
        let places = [place(1, 1), place(1, 8), place(3, 1)];
        assert_eq!(bind(&places, 1, None), Some(place(1, 1)));
        assert_eq!(bind(&places, 1, Some(9)), Some(place(1, 8)));
        assert_eq!(bind(&places, 2, None), Some(place(3, 1)));
        assert_eq!(bind(&places, 4, None), None);
    }
}
