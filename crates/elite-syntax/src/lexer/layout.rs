//! Lines and blocks: indentation, `end`, line ends. A part of the lexer.

use messages::text;

use super::oneline::{LinePartKind, OneLineForm};
use super::{Lexer, TokenKind};
use crate::diagnostic::Diagnostic;
use crate::source::Span;

/// Brackets that are given up in one text; each costs reading a part of it again.
const CUTS_MAX: usize = 20;

/// Work for the beginning of a line.
const LINE: usize = 64;

/// Where the lexer stands with respect to lines and blocks.
#[derive(Default)]
pub(super) struct IndentState {
    /// Columns of the open blocks; the outermost, column 0, is not stored.
    columns: Vec<u32>,
    /// False only before the first token of a logical line.
    inside_line: bool,
    one_line: Option<OneLineForm>,
    warned_about_tabs: bool,
}

impl IndentState {
    pub(super) fn at_line_start(&self) -> bool {
        !self.inside_line
    }

    pub(super) fn inside_expression(&mut self) {
        self.inside_line = true;
    }

    pub(super) fn in_one_line_form(&self) -> bool {
        self.one_line.is_some()
    }

    fn column(&self) -> u32 {
        self.columns.last().copied().unwrap_or(0)
    }

    /// How many blocks are open.
    pub(super) fn depth(&self) -> u32 {
        self.columns.len() as u32
    }

    /// How many of them a line at `column` could be in.
    fn depth_at(&self, column: u32) -> u32 {
        self.columns.partition_point(|open| *open <= column) as u32
    }
}

impl Lexer<'_> {
    /// The indentation of a physical line that starts a logical one; blank lines and comment lines are skipped.
    pub(super) fn start_of_line(&mut self) {
        let start = self.at;
        self.at += self.leading(self.rest(), |c| matches!(c, ' ' | '\t' | '\u{c}'));
        self.budget.charge(LINE);
        self.is_full |= self.budget.is_aborted();
        match self.peek() {
            None => return,
            Some('#') => self.skip_comment(),
            Some('$') => {
                let column = self.column_after(&self.text[start..self.at], start);
                self.directive(self.layout.depth_at(column));
            }
            _ => {}
        }
        if let Some(line_end) = self.line_end_length() {
            self.at += line_end;
            return;
        }
        if self.at == self.end {
            return;
        }
        self.settle_directives();
        let mut column = self.column_after(&self.text[start..self.at], start);
        self.layout.one_line =
            OneLineForm::scan(self.text, (self.at, self.end), column, self.budget);
        if column == 0 {
            column = self.column_behind_backslashes();
        }
        self.indent_to(column);
        self.layout.inside_line = true;
        self.terminator();
    }

    /// The column of what a line at column 0 that holds only a backslash goes on with, which is taken for its
    /// indentation (as in Python).
    fn column_behind_backslashes(&mut self) -> u32 {
        let rest = self.rest();
        let after = rest
            .strip_prefix("\\\r\n")
            .or_else(|| rest.strip_prefix("\\\n"));
        let Some(after) = after else {
            return 0;
        };
        let blanks = self.leading(after, |c| matches!(c, ' ' | '\t' | '\u{c}'));
        if matches!(
            after[blanks..].chars().next(),
            None | Some('\n' | '\r' | '#' | '\\')
        ) {
            return 0;
        }
        self.at = self.end - after.len();
        let start = self.at;
        self.at += blanks;
        self.column_after(&self.text[start..self.at], start)
    }

    fn line_end_length(&self) -> Option<usize> {
        let rest = self.rest();
        if rest.starts_with("\r\n") {
            return Some(2);
        }
        rest.starts_with(['\n', '\r']).then_some(1)
    }

    /// Column reached after `blanks`: tabs go to the next multiple of 8, a form feed starts over (as in Python).
    fn column_after(&mut self, blanks: &str, start: usize) -> u32 {
        let mut column = 0;
        for c in blanks.chars() {
            column = match c {
                '\t' => (column / 8 + 1) * 8,
                '\u{c}' => 0,
                _ => column + 1,
            };
        }
        let mixed = blanks.contains(" \t");
        if mixed && !self.layout.warned_about_tabs {
            self.layout.warned_about_tabs = true;
            let message = text!(
                "blanks before a tab in the indentation; a tab goes to the next multiple of 8",
                "缩进中制表符之前有空格；制表符对齐到 8 的倍数"
            );
            let span = Span::new(start, start + blanks.len());
            self.diagnostics
                .push(Diagnostic::warning("mixed-indentation", span, message));
        }
        column
    }

    /// Opens or closes blocks so that the innermost one is at `column`.
    fn indent_to(&mut self, column: u32) {
        if column > self.layout.column() {
            self.layout.columns.push(column);
            return self.push(TokenKind::Indent, self.at, self.at);
        }
        while column < self.layout.column() {
            self.layout.columns.pop();
            self.push(TokenKind::Dedent, self.at, self.at);
        }
        if column > self.layout.column() {
            let message = text!(
                "this line's indentation matches no open block",
                "这一行的缩进与任何打开的块都不一致"
            );
            let first = self.rest().chars().next().map_or(0, char::len_utf8);
            self.error("indentation", self.at, self.at + first, message);
        }
    }

    /// If this logical line holds only `end` (and `;`, blanks, a comment), it is a terminator, not a name.
    fn terminator(&mut self) {
        let Some(after) = self.rest().strip_prefix("end") else {
            return;
        };
        if after.starts_with(super::names::continues_name) {
            return;
        }
        let tail = after.trim_start_matches([' ', '\t', '\u{c}']);
        let one_line = self.layout.in_one_line_form();
        let tail = match tail.strip_prefix(';') {
            Some(more) if !one_line => more.trim_start_matches([' ', '\t', '\u{c}', ';']),
            _ => tail,
        };
        let alone = tail.is_empty()
            || tail.starts_with(['\n', '\r', '#'])
            || (one_line && tail.starts_with(';'));
        if alone {
            self.push(TokenKind::End, self.at, self.at + 3);
            self.at = self.end - tail.len();
        }
    }

    /// A line end: ends the logical line, unless brackets are open.
    pub(super) fn line_end(&mut self) {
        let start = self.at;
        self.at += self.line_end_length().unwrap_or(1);
        if !self.brackets.is_empty() {
            if self.statement_follows() {
                self.cut_at_open_bracket();
            }
            return;
        }
        self.push(TokenKind::Newline, start, start);
        self.close_one_line_form();
        self.layout.inside_line = false;
    }

    /// Reports the outermost open bracket, and goes back to the end of its line to read on from there as if the
    /// bracket did not reach further: one typo must not swallow the rest of the program.
    pub(super) fn cut_at_open_bracket(&mut self) -> bool {
        let Some((kind, span)) = self.brackets.drain(..).next() else {
            return false;
        };
        let message = text!("{} is never closed", "{}没有关闭", kind.describe());
        self.diagnostics
            .push(Diagnostic::error("syntax", span, message));
        let rest = &self.text[span.end as usize..self.end];
        let cut = span.end as usize + rest.find(['\n', '\r']).unwrap_or(rest.len());
        if self.cuts.len() == CUTS_MAX {
            return false;
        }
        self.tokens
            .retain(|token| (token.span.start as usize) < cut);
        self.diagnostics
            .retain(|diagnostic| (diagnostic.span.start as usize) < cut);
        self.directives
            .retain(|directive| (directive.span.start as usize) < cut);
        self.settled = self.directives.len();
        self.cuts.push(cut as u32);
        self.at = cut;
        self.at += self.line_end_length().unwrap_or(0);
        self.push(TokenKind::Newline, cut, cut);
        self.close_one_line_form();
        self.layout.inside_line = false;
        true
    }

    /// Inside brackets: whether the next line can only be a new statement, so that a bracket must have been
    /// forgotten. Keeps one typo from swallowing the rest of the program.
    fn statement_follows(&self) -> bool {
        if self.end != self.text.len() || self.layout.at_line_start() {
            return false;
        }
        let line = self.rest().trim_start_matches([' ', '\t', '\u{c}']);
        let length = line
            .find(|c| !super::names::continues_name(c))
            .unwrap_or(line.len());
        let starts_statement = matches!(
            &line[..length],
            "def"
                | "class"
                | "while"
                | "with"
                | "try"
                | "except"
                | "finally"
                | "return"
                | "raise"
                | "del"
                | "pass"
                | "break"
                | "continue"
                | "import"
                | "global"
                | "nonlocal"
                | "assert"
                | "elif"
        );
        let argument = line[length..]
            .trim_start_matches([' ', '\t'])
            .starts_with(['=', ',', ')', ']', '}', ':']);
        starts_statement && !argument
    }

    /// A `;` that stands for a line end (language.md 4.2): ends a part and starts the next one.
    pub(super) fn part_end(&mut self) {
        let start = self.at;
        let rest = self.rest();
        let after = rest.trim_start_matches([' ', '\t', ';']);
        self.at = self.end - after.len();
        if after.is_empty() || after.starts_with(['\n', '\r', '#']) {
            return;
        }
        self.push(TokenKind::Newline, start, start);
        self.open_part();
        self.terminator();
    }

    /// Blocks around the part that starts here, by its column or by the words that head and end blocks.
    fn open_part(&mut self) {
        let at = self.at;
        let Some(one_line) = &mut self.layout.one_line else {
            return;
        };
        let Some(part) = one_line.part_at(at) else {
            return;
        };
        if !one_line.by_terminators {
            return self.indent_to(part.column);
        }
        let opens = std::mem::take(&mut one_line.header_open);
        one_line.header_open = part.is_header;
        if opens {
            one_line.synthetic += 1;
            self.push(TokenKind::Indent, at, at);
        }
        let closes = matches!(
            part.kind,
            LinePartKind::Continuation | LinePartKind::Terminator
        );
        if let Some(one_line) = &mut self.layout.one_line
            && closes
            && one_line.synthetic > 0
        {
            one_line.synthetic -= 1;
            self.push(TokenKind::Dedent, at, at);
        }
    }

    fn close_one_line_form(&mut self) {
        let Some(one_line) = self.layout.one_line.take() else {
            return;
        };
        for _ in 0..one_line.synthetic {
            self.push(TokenKind::Dedent, self.at, self.at);
        }
    }

    pub(super) fn end_of_text(&mut self) {
        let end = self.end;
        if self.layout.inside_line {
            self.push(TokenKind::Newline, end, end);
            self.close_one_line_form();
        }
        while self.layout.columns.pop().is_some() {
            self.push(TokenKind::Dedent, end, end);
        }
        self.push(TokenKind::EndOfFile, end, end);
    }
}
