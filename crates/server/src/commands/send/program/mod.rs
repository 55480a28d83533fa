//! A file as a controller takes it: one `def` block, and where each of its lines stands in the file.
//!
//! Port 30001 takes every line outside a block as a program of its own, so a file of plain statements goes into a
//! function. Its variables are declared global there, so that its functions see them as they did.

use std::sync::Arc;

use elite_runtime::{Preset, PresetError};
use elite_syntax::{Diagnostic, Program, ProgramKind, SourceFile, compile};
use messages::{Localized, Text, text};
use thiserror::Error;

use crate::ports::script_text::{StringTracker, is_end_line};
use crate::sent_file::{Extent, SentFile};

/// What the function around a file of plain statements is called where its name gives no better one.
const WRAPPER: &str = "eliteserver_program";
/// Longest name of that function, bytes.
const FUNCTION_BYTES_MAX: usize = 60;
/// Longest line of declared names; more begin another line.
const NAMES_BYTES_MAX: usize = 400;

/// A program on its way to a controller.
#[derive(Clone, Debug)]
pub(super) struct OutgoingProgram {
    /// What is sent, its last line end included.
    pub text: String,
    /// For every line of it: the line of the file that it is, and how many columns it was moved right.
    lines: Vec<Option<(u32, u32)>>,
    /// Another program's helper, which runs beside the main one.
    pub is_secondary: bool,
    /// The function that the file was put into, if it was.
    function: Option<String>,
    /// The controller knows the file: whatever it says is of that.
    is_named: bool,
}

/// A reason why a file cannot be sent, told in a sentence.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub(super) enum WrapError {
    /// A setting is none.
    #[error(transparent)]
    Setting(#[from] PresetError),
    /// Settings go before a main program.
    #[error("--set: the file is a secondary program, which has no globals of its own")]
    #[zh("--set：该文件是次级程序，没有自己的全局变量")]
    SecondarySet,
    /// What became of it does not compile: a fault of ours or a construct that only a file's own level takes.
    #[error("the program cannot be put into a function, as controllers take it: {0}")]
    #[zh("程序无法放入控制器要求的函数中：{0}")]
    NotWrapped(Text),
}

impl OutgoingProgram {
    /// The file as a program for port 30001. `program` is the file compiled.
    pub(super) fn new(program: &Program, settings: &[Preset]) -> Result<Self, WrapError> {
        let text = program.file().text();
        if program.kind() == ProgramKind::Secondary {
            return match settings {
                [] => Ok(Self::as_it_is(text, true)),
                _ => Err(WrapError::SecondarySet),
            };
        }
        if settings.is_empty() && is_one_block(text) {
            return Ok(Self::as_it_is(text, false));
        }
        let outgoing = Self::wrapped(program, settings);
        let file = SourceFile::new(program.file().name(), outgoing.text.clone());
        match compile(file.clone(), &elite_runtime::builtins::known_names()) {
            Ok(_) => Ok(outgoing),
            Err(findings) => Err(WrapError::NotWrapped(outgoing.told(&findings, &file))),
        }
    }

    fn as_it_is(text: &str, is_secondary: bool) -> Self {
        let mut text = text.replace("\r\n", "\n");
        if !text.ends_with('\n') {
            text.push('\n');
        }
        let count = u32::try_from(text.lines().count()).unwrap_or(u32::MAX);
        Self {
            text,
            lines: (1..=count).map(|line| Some((line, 0))).collect(),
            is_secondary,
            function: None,
            is_named: false,
        }
    }

    fn wrapped(program: &Program, settings: &[Preset]) -> Self {
        let mut names: Vec<&str> = program.global_names().collect();
        names.extend(settings.iter().map(Preset::name));
        names.sort_unstable();
        names.dedup();
        let function = Some(function_of(program.file().name()))
            .filter(|function| names.binary_search(&function.as_str()).is_err())
            .unwrap_or_else(|| WRAPPER.to_owned());
        let mut out = Self {
            text: String::new(),
            lines: Vec::new(),
            is_secondary: false,
            function: None,
            is_named: false,
        };
        out.own(&format!("def {function}():"));
        out.function = Some(function);
        let mut declared = String::new();
        for name in names {
            if declared.len() + name.len() > NAMES_BYTES_MAX {
                out.own(&format!("\tglobal {declared}"));
                declared.clear();
            }
            if !declared.is_empty() {
                declared.push_str(", ");
            }
            declared.push_str(name);
        }
        if !declared.is_empty() {
            out.own(&format!("\tglobal {declared}"));
        }
        for setting in settings {
            out.own(&format!("\t{}", setting.statement()));
        }
        out.own("\tpass");
        let mut strings = StringTracker::default();
        for (line, number) in program.file().text().lines().zip(1..) {
            // A text over several lines keeps what it says.
            let shift = u32::from(!strings.in_string());
            if shift == 1 {
                out.text.push('\t');
            }
            out.text.push_str(line);
            out.text.push('\n');
            out.lines.push(Some((number, shift)));
            line.bytes()
                .chain([b'\n'])
                .for_each(|byte| strings.feed(byte));
        }
        // A file that is one function calls it, as a controller would.
        if is_one_block(program.file().text()) {
            out.own(&format!("\t{}()", program.name()));
        }
        out.own("end");
        out
    }

    fn own(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
        self.lines.push(None);
    }

    /// The file whatever is in it, for a controller that knows more than we do.
    pub(super) fn unchecked(file: &SourceFile, settings: &[Preset]) -> Result<Self, WrapError> {
        match settings {
            [] => Ok(Self::as_it_is(file.text(), file.text().starts_with("sec "))),
            [first, ..] => Err(WrapError::Setting(PresetError {
                given: first.name().to_owned(),
                why: text!(
                    "a text that is not checked is sent as it is; leave --no-check out",
                    "不检查的文本按原样发送；请去掉 --no-check"
                ),
            })),
        }
    }

    /// Tells a controller that understands it which file this is: that speaks of the file from then on, not of what is
    /// sent.
    pub(super) fn name_the_file(&mut self, name: &str, settings: &[Preset]) {
        if self.is_secondary {
            return;
        }
        let first = |is_of_file: bool| self.lines.iter().position(|l| l.is_some() == is_of_file);
        let number = |index: usize| u32::try_from(index + 1).ok();
        let at = match &self.function {
            Some(_) => first(true).and_then(number).map(|from| Extent::Body {
                from,
                set: settings.iter().map(Preset::given).collect(),
            }),
            None => {
                let head = self.text.lines().position(|l| l.starts_with("def "));
                head.and_then(number).map(Extent::Block)
            }
        };
        let marked = at.and_then(|at| SentFile::new(name, at).mark(&self.text));
        if let Some(text) = marked {
            self.text = text;
            self.is_named = true;
        }
    }

    /// The place in the file of a place in what was sent, both from 1; `None` for lines of ours. A controller that
    /// tells lines only has 0 or less as column.
    pub(super) fn place(&self, line: i32, column: i32) -> Option<(u32, u32)> {
        if self.is_named {
            let line = u32::try_from(line).ok().filter(|line| *line > 0)?;
            return Some((line, u32::try_from(column).unwrap_or(1).max(1)));
        }
        let index = usize::try_from(line.checked_sub(1)?).ok()?;
        let (line, shift) = (*self.lines.get(index)?)?;
        let column = u32::try_from(column).unwrap_or(0);
        Some((line, column.saturating_sub(shift).max(1)))
    }

    /// The place in the file of an error. A controller may tell the line in its text only: `…, line 5`.
    pub(super) fn place_of_error(&self, line: i32, column: i32, text: &str) -> Option<(u32, u32)> {
        if line > 0 {
            return self.place(line, column);
        }
        // The innermost call stands last.
        let (_, behind) = text.rsplit_once("line ")?;
        let digits = behind.find(|c: char| !c.is_ascii_digit());
        let line = behind[..digits.unwrap_or(behind.len())].parse().ok()?;
        self.place(line, 1)
    }

    /// A report of the controller with the places of its calls as the file has them:
    /// `  task, line 10, column 2, in task` of a text that was put into a function becomes
    /// `  pick.script, line 7, column 1, in <module>`. Lines that are no such place stay.
    pub(super) fn in_file(&self, report: &str, file: &str) -> String {
        if self.is_named {
            return report.to_owned();
        }
        let wrapper = self.function.as_deref();
        let lines = report.split('\n').map(|line| {
            let place = || {
                let (before, rest) = line.split_once(", line ")?;
                let (number, rest) = rest.split_once(", column ")?;
                let (column, function) = rest.split_once(", in ")?;
                let (line, column) = self.place(number.parse().ok()?, column.parse().ok()?)?;
                let indent = &before[..before.len() - before.trim_start().len()];
                let inner = wrapper
                    .and_then(|wrapper| function.strip_prefix(wrapper))
                    .map(|inner| inner.strip_prefix(".<locals>.").unwrap_or("<module>"));
                let function = inner.unwrap_or(function);
                Some(format!(
                    "{indent}{file}, line {line}, column {column}, in {function}"
                ))
            };
            place().unwrap_or_else(|| line.to_owned())
        });
        lines.collect::<Vec<_>>().join("\n")
    }

    fn told(&self, findings: &[Diagnostic], file: &Arc<SourceFile>) -> Text {
        let Some(finding) = findings.first() else {
            return Text::verbatim("");
        };
        let fields = finding.fields(file);
        let column = i32::try_from(fields.column).unwrap_or(1);
        let line = i32::try_from(fields.line).unwrap_or(0);
        match self.place(line, column) {
            Some((line, _)) => text!("line {line}: {}", "第 {line} 行：{}", finding.message),
            None => finding.message.clone(),
        }
    }
}

/// A name for the function around a file that a person recognises: `pick_program` of `pick.script`.
fn function_of(file: &str) -> String {
    let name = file.rsplit(['/', '\\']).next().unwrap_or(file);
    let stem = name.split('.').next().unwrap_or(name);
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut stem = stem.replace(|c| !is_plain(c), "_");
    stem.truncate(FUNCTION_BYTES_MAX);
    match stem.chars().next() {
        Some(first) if stem.chars().any(|c| c != '_') => {
            let lead = if first.is_ascii_digit() { "_" } else { "" };
            format!("{lead}{stem}_program")
        }
        _ => WRAPPER.to_owned(),
    }
}

/// Whether the text is one `def` or `sec` block with its `end`, as controllers take it without more.
fn is_one_block(text: &str) -> bool {
    let mut strings = StringTracker::default();
    let (mut has_begun, mut has_ended) = (false, false);
    for line in text.lines() {
        let in_string = strings.in_string();
        line.bytes()
            .chain([b'\n'])
            .for_each(|byte| strings.feed(byte));
        let bare = line.trim();
        if in_string || bare.is_empty() || bare.starts_with('#') {
            continue;
        }
        if has_ended {
            return false;
        }
        if !has_begun {
            has_begun = line.starts_with("def ");
            if !has_begun {
                return false;
            }
        } else if is_end_line(line.as_bytes()) {
            has_ended = true;
        } else if !line.starts_with([' ', '\t']) {
            // Another statement of the file's own level.
            return false;
        }
    }
    has_ended
}

#[cfg(test)]
mod tests;
