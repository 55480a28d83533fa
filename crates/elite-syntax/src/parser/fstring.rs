//! f-strings: the text between replacement fields, and the fields.

use messages::{Text, text};

use super::strings::StringLiteral;
use super::{ParseResult, Parser};
use crate::ast::{Conversion, Expr, FStringPart};
use crate::lexer::lex_expression;
use crate::source::Span;

/// Fields within format specifications within fields: Python 3.11 allows two levels.
const FIELD_NESTING_MAX: u32 = 2;
/// Work for what is special in a text, and for a field beside its tokens.
const WORK_PER_SEGMENT: usize = 128;
const FIELD: usize = 512;

/// The parts of an f-string while it is read. Texts side by side become one at once: a doubled brace ends one, and
/// there may be half a million of them.
#[derive(Default)]
pub(super) struct FStringBuilder {
    complete: Vec<FStringPart>,
    text: String,
}

impl FStringBuilder {
    pub(super) fn text(&mut self, text: &str) {
        self.text.push_str(text);
    }

    fn value(&mut self, value: FStringPart) {
        self.text_ends();
        self.complete.push(value);
    }

    fn text_ends(&mut self) {
        if !self.text.is_empty() {
            let text = std::mem::take(&mut self.text);
            self.complete.push(FStringPart::Text(text.into()));
        }
    }

    pub(super) fn into_vec(mut self) -> Vec<FStringPart> {
        self.text_ends();
        self.complete
    }

    /// The text of literals without fields, which have no other part.
    pub(super) fn into_text(self) -> String {
        self.text
    }
}

impl Parser<'_> {
    /// The f-string text at `span` into `parts`. `level` counts the replacement fields around it.
    pub(super) fn fstring_parts(
        &mut self,
        literal: &StringLiteral,
        span: Span,
        level: u32,
        parts: &mut FStringBuilder,
    ) -> ParseResult<()> {
        if level > FIELD_NESTING_MAX {
            return self.fail(
                span,
                text!(
                    "the replacement fields of this f-string nest too deeply",
                    "这个 f-string 的替换字段嵌套过深"
                ),
            );
        }
        let text = self.file.slice(span);
        let offset = span.start as usize;
        let mut literal_start = 0;
        let mut at = 0;
        while let Some(found) = text[at..].find(['{', '}', '\\']) {
            let brace = at + found;
            self.budget.charge(WORK_PER_SEGMENT + found);
            let here = &text[brace..];
            let doubled = level == 0 && (here.starts_with("{{") || here.starts_with("}}"));
            if let Some(escaped) = here.strip_prefix('\\') {
                // The escapes are resolved with the text. A brace after a backslash is one nevertheless, except that
                // of `\N{…}`.
                let hidden = match escaped.chars().next() {
                    Some('N') if !literal.raw && escaped.starts_with("N{") => {
                        escaped.find('}').map_or(escaped.len(), |end| end + 1)
                    }
                    Some('{' | '}') | None => 0,
                    Some('\\') if literal.raw => 0,
                    Some(c) => c.len_utf8(),
                };
                at = brace + 1 + hidden;
            } else if doubled {
                self.fstring_text(literal, offset + literal_start, offset + brace + 1, parts);
                at = brace + 2;
                literal_start = at;
            } else if here.starts_with('{') {
                self.fstring_text(literal, offset + literal_start, offset + brace, parts);
                at = self.field(literal, offset + brace, span, level, parts)? - offset;
                literal_start = at;
            } else {
                let span = Span::new(offset + brace, offset + brace + 1);
                return self.fail(
                    span,
                    text!(
                        "a single '}}' is not allowed in an f-string; write '}}}}'",
                        "f-string 中不能有单独的 '}}'；请写作 '}}}}'"
                    ),
                );
            }
        }
        self.fstring_text(literal, offset + literal_start, span.end as usize, parts);
        Ok(())
    }

    /// A format specification: an f-string text within a field.
    fn format_parts(
        &mut self,
        literal: &StringLiteral,
        span: Span,
        level: u32,
    ) -> ParseResult<Vec<FStringPart>> {
        let mut parts = FStringBuilder::default();
        let parsed = self.fstring_parts(literal, span, level, &mut parts);
        Ok(self.keep_or_abandon(parts.into_vec(), parsed)?.0)
    }

    fn fstring_text(
        &mut self,
        literal: &StringLiteral,
        start: usize,
        end: usize,
        parts: &mut FStringBuilder,
    ) {
        if start < end {
            let text = self.text_body(literal, Span::new(start, end));
            parts.text(&text);
        }
    }

    /// The replacement field whose `{` is at byte `open`; returns the byte after its `}`.
    fn field(
        &mut self,
        literal: &StringLiteral,
        open: usize,
        within: Span,
        level: u32,
        parts: &mut FStringBuilder,
    ) -> ParseResult<usize> {
        let text = self.file.text();
        let end = within.end as usize;
        let start = open + 1;
        let stop = expression_end(&text[start..end]) + start;
        let brace = Span::new(open, open + 1);
        if text[start..stop].trim().is_empty() {
            return self.fail(
                brace,
                text!(
                    "an f-string field needs an expression",
                    "f-string 的字段需要一个表达式"
                ),
            );
        }
        if let Some(backslash) = text[start..stop].find('\\') {
            let span = Span::new(start + backslash, start + backslash + 1);
            return self.fail(
                span,
                text!(
                    "the expression of an f-string field cannot contain a backslash",
                    "f-string 字段的表达式中不能有反斜杠"
                ),
            );
        }
        if let Some(hash) = comment_start(&text[start..stop]) {
            let span = Span::new(start + hash, start + hash + 1);
            return self.fail(
                span,
                text!(
                    "the expression of an f-string field cannot contain '#'",
                    "f-string 字段的表达式中不能有 '#'"
                ),
            );
        }
        let mut at = stop;
        let echoes = text[at..end].starts_with('=');
        if echoes {
            at += 1;
            at += text[at..end].len() - text[at..end].trim_start().len();
            parts.text(&text[start..at]);
        }
        self.budget.charge(FIELD);
        let value = self.field_expression(
            Span::new(start, stop),
            text!("the end of the expression", "表达式的结尾"),
        )?;
        let conversion = self.conversion(&mut at, end)?;
        let mut format = None;
        if text[at..end].starts_with(':') {
            let spec_end = at + 1 + format_end(&text[at + 1..end]);
            format = Some(self.format_parts(literal, Span::new(at + 1, spec_end), level + 1)?);
            at = spec_end;
        }
        if !text[at..end].starts_with('}') {
            return self.fail(
                brace,
                text!(
                    "this f-string field is never closed: expected '}}'",
                    "这个 f-string 字段没有结束：缺少 '}}'"
                ),
            );
        }
        let by_repr = echoes && format.is_none() && conversion == Conversion::None;
        let conversion = if by_repr {
            Conversion::Repr
        } else {
            conversion
        };
        parts.value(FStringPart::Value {
            value,
            conversion,
            format,
        });
        Ok(at + 1)
    }

    fn conversion(&mut self, at: &mut usize, end: usize) -> ParseResult<Conversion> {
        let rest = &self.file.text()[*at..end];
        if !rest.starts_with('!') {
            return Ok(Conversion::None);
        }
        let conversion = match rest[1..].chars().next() {
            Some('s') => Conversion::Str,
            Some('r') => Conversion::Repr,
            Some('a') => Conversion::Ascii,
            _ => {
                return self.fail(
                    Span::new(*at, *at + 1),
                    text!("expected '!s', '!r' or '!a'", "应为 '!s'、'!r' 或 '!a'"),
                );
            }
        };
        *at += 2;
        Ok(conversion)
    }

    /// Parses the expression at `span` with the state of this parser; messages call its end `end`.
    pub(super) fn field_expression(&mut self, span: Span, end: Text) -> ParseResult<Expr> {
        let lexed = lex_expression(self.file, span, self.budget);
        for finding in lexed.diagnostics.into_vec() {
            self.lexer_diagnostics.push(finding);
        }
        let outer = (
            std::mem::replace(&mut self.tokens, lexed.tokens),
            std::mem::replace(&mut self.at, 0),
            std::mem::replace(&mut self.end, end),
        );
        let result = self.nested(Self::whole_expression);
        (self.tokens, self.at, self.end) = outer;
        result
    }
}

/// Length of the expression at the start of `text`: up to `}`, `!x`, `:` or a lone `=` outside brackets and strings.
fn expression_end(text: &str) -> usize {
    let bytes = text.as_bytes();
    let mut depth = 0u32;
    let mut at = 0;
    while let Some(byte) = bytes.get(at) {
        let next = bytes.get(at + 1).copied().unwrap_or(0);
        let before = at.checked_sub(1).map_or(0, |i| bytes[i]);
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b'}' | b':' if depth == 0 => return at,
            b')' | b']' | b'}' => depth = depth.saturating_sub(1),
            b'!' if depth == 0 && next != b'=' => return at,
            b'=' if depth == 0 && next != b'=' && !b"=!<>".contains(&before) => return at,
            b'"' | b'\'' => at = string_end(bytes, at),
            _ => {}
        }
        at += 1;
    }
    text.len()
}

/// Index of a `#` outside strings.
fn comment_start(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let mut at = 0;
    while let Some(byte) = bytes.get(at) {
        match byte {
            b'#' => return Some(at),
            b'"' | b'\'' => at = string_end(bytes, at),
            _ => {}
        }
        at += 1;
    }
    None
}

/// Index of the quote that closes the string at `start`, or the last byte.
fn string_end(bytes: &[u8], start: usize) -> usize {
    let length = bytes[start + 1..]
        .iter()
        .position(|byte| *byte == bytes[start]);
    length.map_or(bytes.len() - 1, |length| start + 1 + length)
}

/// Length of the format specification at the start of `text`: up to the `}` that closes its field.
fn format_end(text: &str) -> usize {
    let bytes = text.as_bytes();
    let mut depth = 0u32;
    let mut at = 0;
    while let Some(byte) = bytes.get(at) {
        match byte {
            b'{' => depth += 1,
            b'}' if depth == 0 => return at,
            b'}' => depth -= 1,
            // Strings within fields hide braces.
            b'"' | b'\'' if depth > 0 => at = string_end(bytes, at),
            _ => {}
        }
        at += 1;
    }
    text.len()
}
