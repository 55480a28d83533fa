//! Formatting: indentation and blanks, nothing else. The result has the same tree, or nothing is changed.
//!
//! Blocks are indented by the same step; commas, assignments and comparisons get their blanks; other operators keep
//! what the author chose, one blank at most. Lines with several statements keep their inner blanks, which may mean
//! blocks there.

use elite_syntax::lexer::{Token, TokenKind as T};
use elite_syntax::{SourceFile, Span};
use messages::{Localized, Text};

use super::Analysis;
use super::fixes::Edit;

/// How blocks are indented.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Indent {
    /// Blanks of a step.
    pub blanks: u32,
    /// Tabs instead; one is eight blanks wide to the language.
    pub tabs: bool,
}

impl Default for Indent {
    fn default() -> Self {
        Indent {
            blanks: 4,
            tabs: false,
        }
    }
}

/// A reason why a text is not formatted.
#[derive(Debug, PartialEq, Eq, thiserror::Error, Localized)]
pub enum FormatError {
    /// The text has errors.
    #[error("a text with errors is not formatted: line {line}: {message}")]
    #[zh("有错误的文本不作排版：第 {line} 行：{message}")]
    TextHasErrors {
        /// Line of the first error, from 1.
        line: u32,
        /// What it is.
        message: Text,
    },
    /// Our own slip, found before anything was changed.
    #[error("the formatted text would mean something else; nothing was changed")]
    #[zh("排版后的文本含义会不同；没有改动")]
    WouldChange,
}

/// Blank lines in a row that stay.
const BLANK_LINES_MAX: usize = 2;
/// Steps are between one blank and this many.
const STEP_MAX: u32 = 16;

/// The changes that format a text.
///
/// # Errors
/// Why it is not formatted.
pub fn format(analysis: &Analysis, indent: Indent) -> Result<Vec<Edit>, FormatError> {
    let errors =
        |finding: &&elite_syntax::Diagnostic| finding.severity == elite_syntax::Severity::Error;
    if let Some(error) = analysis.findings().iter().find(errors) {
        return Err(FormatError::TextHasErrors {
            line: analysis.file.line_of(error.span.start),
            message: error.message.clone(),
        });
    }
    let edits = Formatter::new(analysis, indent).edits();
    let formatted = applied(analysis.text(), &edits);
    let formatted = SourceFile::new(analysis.file.name(), formatted);
    match elite_syntax::same_tree(&analysis.file, &formatted) {
        Some(true) => Ok(edits),
        _ => Err(FormatError::WouldChange),
    }
}

/// A text with changes that are in its order and do not overlap.
pub fn applied(text: &str, edits: &[Edit]) -> String {
    let mut changed = String::with_capacity(text.len());
    let mut at = 0;
    for edit in edits {
        changed.push_str(text.get(at..edit.span.start as usize).unwrap_or(""));
        changed.push_str(&edit.text);
        at = edit.span.end as usize;
    }
    changed.push_str(text.get(at..).unwrap_or(""));
    changed
}

struct Formatter<'a> {
    text: &'a str,
    tokens: Vec<Token>,
    indent: Indent,
    /// Columns of the open blocks.
    columns: Vec<u32>,
    edits: Vec<Edit>,
}

/// What surrounds a token within its logical line.
#[derive(Clone, Copy)]
struct BracketContext {
    bracket: T,
    /// There was a `:` since the last comma: an annotation or a key.
    colon: bool,
}

impl<'a> Formatter<'a> {
    fn new(analysis: &'a Analysis, indent: Indent) -> Self {
        let tokens = analysis.tokens().iter();
        let tokens = tokens.filter(|token| !matches!(token.kind, T::Indent | T::Dedent));
        Formatter {
            text: analysis.text(),
            tokens: tokens.copied().collect(),
            indent,
            columns: vec![0],
            edits: Vec::new(),
        }
    }

    fn edits(mut self) -> Vec<Edit> {
        let mut end = 0;
        let mut at = 0;
        let tokens = std::mem::take(&mut self.tokens);
        while at < tokens.len() {
            let line = tokens[at..]
                .iter()
                .position(|token| matches!(token.kind, T::Newline | T::EndOfFile))
                .map_or(tokens.len(), |length| at + length);
            if line > at {
                let first = tokens[at].span.start as usize;
                // Parts of a line with `;` come as lines of their own.
                let shares_line = !self.text[end..first].contains(['\n', '\r']) && end > 0;
                if shares_line {
                    end = tokens[line - 1].span.end as usize;
                } else {
                    let goes_on = self.has_parts(&tokens[at..], line - at);
                    end = self.line(end, &tokens[at..line], goes_on);
                }
            }
            at = line + 1;
        }
        self.gap_at_end(end);
        self.edits
            .retain(|edit| self.text.get(edit.span.range()) != Some(&*edit.text));
        self.edits
    }

    /// Whether the physical line goes on behind the logical one that has `length` tokens.
    fn has_parts(&self, tokens: &[Token], length: usize) -> bool {
        let end = tokens[length - 1].span.end as usize;
        let rest = self.text[end..].trim_start_matches([' ', '\t', '\u{c}']);
        rest.starts_with(';')
            || tokens[..length]
                .iter()
                .any(|token| token.kind == T::Semicolon)
    }

    fn column(blanks: &str) -> u32 {
        blanks.chars().fold(0, |column, c| match c {
            '\t' => (column / 8 + 1) * 8,
            '\u{c}' => 0,
            _ => column + 1,
        })
    }

    fn indentation(&self, depth: usize) -> String {
        match self.indent.tabs {
            true => "\t".repeat(depth),
            false => " ".repeat(depth * self.indent.blanks.clamp(1, STEP_MAX) as usize),
        }
    }

    fn replace(&mut self, start: usize, end: usize, text: impl Into<String>) {
        self.edits.push(Edit {
            span: Span::new(start, end),
            text: text.into(),
        });
    }

    /// One logical line; `from` is where the one before it ended. Gives back its own end.
    fn line(&mut self, from: usize, tokens: &[Token], keeps_blanks: bool) -> usize {
        let first = tokens[0].span.start as usize;
        let line_start = self.text[..first]
            .rfind(['\n', '\r'])
            .map_or(0, |at| at + 1);
        let blanks = &self.text[line_start.max(from)..first];
        // Behind a backslash, or the mark of the byte order, the line is what it is.
        let is_plain = blanks.chars().all(|c| matches!(c, ' ' | '\t'));
        let before_depth = self.columns.len();
        let column = Self::column(blanks);
        if is_plain {
            while self.columns.last().is_some_and(|top| column < *top) && self.columns.len() > 1 {
                self.columns.pop();
            }
            if self.columns.last().is_some_and(|top| column > *top) {
                self.columns.push(column);
            }
        }
        self.gap(from, line_start.max(from), before_depth);
        let new_column = match is_plain {
            true => {
                let indentation = self.indentation(self.columns.len() - 1);
                let width = Self::column(&indentation);
                self.replace(line_start.max(from), first, indentation);
                width
            }
            false => column,
        };
        let shift = i64::from(new_column) - i64::from(column);
        self.inside(tokens, keeps_blanks, shift);
        tokens[tokens.len() - 1].span.end as usize
    }

    /// What lies between two logical lines: the rest of the line before, blank lines, comments and directives.
    fn gap(&mut self, from: usize, to: usize, depth_before: usize) {
        let mut at = from;
        let mut is_rest = from > 0;
        let mut blank_lines = 0;
        let gap = &self.text[from..to];
        for line in gap.split_inclusive('\n') {
            let content = line.trim_end_matches(['\n', '\r']);
            let (start, end) = (at, at + content.len());
            at += line.len();
            let bare = content.trim_matches([' ', '\t']);
            if content.contains(['\r', '\u{c}', '\\']) && !bare.starts_with('#') {
                is_rest = false;
                continue;
            }
            if is_rest {
                self.rest_of_line(start, content);
                is_rest = false;
                continue;
            }
            let is_last_piece = !line.ends_with('\n');
            if bare.is_empty() {
                blank_lines += 1;
                if blank_lines > BLANK_LINES_MAX && !is_last_piece {
                    self.replace(start, at, "");
                } else if !is_last_piece {
                    self.replace(start, end, "");
                }
                continue;
            }
            blank_lines = 0;
            self.remark(start, content, depth_before);
        }
    }

    /// What is left of a line behind its statements: a comment, a semicolon, blanks.
    fn rest_of_line(&mut self, start: usize, content: &str) {
        let mark = content.find('#');
        let code_end = mark.unwrap_or(content.len());
        let code = &content[..code_end];
        if !code.trim().is_empty() {
            // A semicolon at the end: only blanks at the very end go.
            let kept = content.trim_end();
            return self.replace(start + kept.len(), start + content.len(), "");
        }
        match mark {
            Some(mark) => {
                let comment = content[mark..].trim_end();
                if code.len() < 2 || code.contains('\t') {
                    self.replace(start, start + mark, "  ");
                }
                self.replace(start + mark + comment.len(), start + content.len(), "");
            }
            None => self.replace(start, start + content.len(), ""),
        }
    }

    /// A comment or a directive that has a line of its own. To the language a directive is as deep as the blocks that
    /// are open at its column, before what follows it closes or opens one.
    fn remark(&mut self, start: usize, content: &str, depth_before: usize) {
        let trimmed = content.trim_start_matches([' ', '\t']);
        let blanks = content.len() - trimmed.len();
        let column = Self::column(&content[..blanks]);
        let open = &self.columns;
        let mut depth = open
            .partition_point(|known| *known <= column)
            .saturating_sub(1);
        if trimmed.starts_with('$') {
            depth = depth.min(depth_before.saturating_sub(1));
        }
        let indentation = self.indentation(depth);
        self.replace(start, start + blanks, indentation);
        let kept = content.trim_end_matches([' ', '\t']);
        self.replace(start + kept.len(), start + content.len(), "");
    }

    fn gap_at_end(&mut self, from: usize) {
        let rest = &self.text[from..];
        if rest.trim().is_empty() {
            let end = if rest.contains("\r\n") { "\r\n" } else { "\n" };
            let end = if self.text.trim().is_empty() { "" } else { end };
            return self.replace(from, self.text.len(), end);
        }
        let depth = self.columns.len();
        self.gap(from, self.text.len(), depth);
    }

    /// The blanks between the tokens of a logical line.
    fn inside(&mut self, tokens: &[Token], keeps_blanks: bool, shift: i64) {
        let mut open: Vec<BracketContext> = Vec::new();
        let mut lambdas = 0u32;
        for (index, token) in tokens.iter().enumerate() {
            if let Some(before) = index.checked_sub(1).map(|at| tokens[at]) {
                let (start, end) = (before.span.end as usize, token.span.start as usize);
                let gap = &self.text[start..end];
                if gap.contains(['\n', '\r']) {
                    self.continuation(start, gap, shift);
                } else if !keeps_blanks && !gap.contains('\\') {
                    let earlier = index.checked_sub(2).map(|at| tokens[at]);
                    let wanted = self.blank(earlier, before, *token, open.last(), lambdas > 0, gap);
                    self.replace(start, end, wanted);
                }
            }
            match token.kind {
                T::LeftParen | T::LeftBracket | T::LeftBrace => open.push(BracketContext {
                    bracket: token.kind,
                    colon: false,
                }),
                T::RightParen | T::RightBracket | T::RightBrace => {
                    open.pop();
                }
                T::Comma => {
                    if let Some(inner) = open.last_mut() {
                        inner.colon = false;
                    }
                }
                T::Lambda => lambdas += 1,
                T::Colon if lambdas > 0 => lambdas -= 1,
                T::Colon => {
                    if let Some(inner) = open.last_mut() {
                        inner.colon = true;
                    }
                }
                _ => {}
            }
        }
    }

    /// Lines within brackets move with the line they belong to.
    fn continuation(&mut self, start: usize, gap: &str, shift: i64) {
        let mut at = start;
        for (index, line) in gap.split_inclusive('\n').enumerate() {
            let content = line.trim_end_matches(['\n', '\r']);
            let is_last = !line.ends_with('\n');
            let bare = content.trim_matches([' ', '\t']);
            if index > 0 && content.chars().all(|c| matches!(c, ' ' | '\t')) && is_last
                || index > 0 && bare.starts_with(['#', '$'])
            {
                let blanks = content.len() - content.trim_start_matches([' ', '\t']).len();
                let column = i64::from(Self::column(&content[..blanks])) + shift;
                self.replace(at, at + blanks, " ".repeat(column.max(0) as usize));
            }
            if !is_last && !bare.ends_with('\\') {
                let kept = content.trim_end_matches([' ', '\t']);
                let blank_start = if index == 0 || bare.starts_with(['#', '$']) {
                    at + kept.len()
                } else {
                    at
                };
                if kept.is_empty() || !bare.is_empty() {
                    self.replace(blank_start.max(at + kept.len()), at + content.len(), "");
                }
            }
            at += line.len();
        }
    }

    /// The blanks that belong between two tokens of a line.
    fn blank(
        &self,
        earlier: Option<Token>,
        before: Token,
        token: Token,
        open: Option<&BracketContext>,
        in_lambda: bool,
        gap: &str,
    ) -> &'static str {
        let as_written = if gap.is_empty() { "" } else { " " };
        let bracket = open.map(|open| open.bracket);
        let is_key = |of: T| {
            of == T::Equal
                && (in_lambda || bracket.is_some() && !open.is_some_and(|open| open.colon))
        };
        match (before.kind, token.kind) {
            (T::LeftParen | T::LeftBracket | T::LeftBrace, _) => "",
            (T::Comma, T::RightParen | T::RightBracket | T::RightBrace) => "",
            (_, T::RightParen | T::RightBracket | T::RightBrace | T::Comma) => "",
            (T::Comma, _) => " ",
            (T::Int | T::Float | T::Imaginary, T::Dot) => as_written,
            (T::From | T::Import, T::Dot) | (T::Dot, T::Import) => as_written,
            (_, T::Dot) | (T::Dot, _) => "",
            (before, token) if is_key(before) || is_key(token) => "",
            (before, token) if is_spaced(before) || is_spaced(token) => " ",
            (_, T::Colon) if bracket == Some(T::LeftBracket) && !in_lambda => as_written,
            (_, T::Colon) => "",
            (T::Colon, _) if bracket == Some(T::LeftBracket) => as_written,
            (T::Colon, _) => " ",
            (T::Name, T::LeftParen | T::LeftBracket) => {
                // `print (x)` and `print [x]` are statements where `print` is a word of its own.
                let is_print = self.text.get(before.span.range()) == Some("print");
                if is_print { as_written } else { "" }
            }
            (T::RightParen | T::RightBracket, T::LeftParen | T::LeftBracket) => "",
            // A sign belongs to what follows it.
            (T::Minus | T::Plus | T::Tilde, _) if !ends_operand(earlier) => "",
            (T::Star | T::DoubleStar, _) if !ends_operand(earlier) => "",
            _ => as_written,
        }
    }
}

/// Operators with a blank on each side wherever they stand.
fn is_spaced(kind: T) -> bool {
    matches!(
        kind,
        T::Equal
            | T::ColonEqual
            | T::Arrow
            | T::PlusEqual
            | T::MinusEqual
            | T::StarEqual
            | T::DoubleStarEqual
            | T::SlashEqual
            | T::DoubleSlashEqual
            | T::PercentEqual
            | T::AtEqual
            | T::AmpersandEqual
            | T::BarEqual
            | T::CaretEqual
            | T::LeftShiftEqual
            | T::RightShiftEqual
            | T::EqualEqual
            | T::NotEqual
            | T::Less
            | T::LessEqual
            | T::Greater
            | T::GreaterEqual
    )
}

/// Whether an operator behind this token stands between two operands.
fn ends_operand(token: Option<Token>) -> bool {
    token.is_some_and(|token| {
        matches!(
            token.kind,
            T::Name
                | T::Int
                | T::Float
                | T::Imaginary
                | T::Str
                | T::RightParen
                | T::RightBracket
                | T::RightBrace
                | T::Ellipsis
                | T::True
                | T::False
                | T::None
        )
    })
}
