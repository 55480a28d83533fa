//! String literals: prefixes, escapes, implicit concatenation.

use messages::{Text, text};

use super::fstring::FStringBuilder;
use super::{ParseResult, Parser};
use crate::ast::{Constant, Expr, ExprKind};
use crate::diagnostic::Diagnostic;
use crate::lexer::{Token, TokenKind as T};
use crate::source::Span;
use crate::surrogate::char_of;

/// Work for an escape.
const ESCAPE: usize = 64;

/// A string token taken apart.
pub(super) struct StringLiteral {
    pub(super) raw: bool,
    bytes: bool,
    formatted: bool,
    /// The text between the quotes.
    pub(super) body: Span,
}

/// What a literal is, and the byte of the file its text begins at.
#[derive(Clone, Copy)]
enum LiteralOrigin {
    Text(usize),
    Bytes(usize),
}

impl LiteralOrigin {
    fn start(self) -> usize {
        match self {
            LiteralOrigin::Text(start) | LiteralOrigin::Bytes(start) => start,
        }
    }
}

impl Parser<'_> {
    /// One or more string literals side by side.
    pub(super) fn strings(&mut self) -> ParseResult<Expr> {
        let start = self.token().span;
        let mut parts = FStringBuilder::default();
        let mut bytes: Vec<u8> = Vec::new();
        let (mut any_bytes, mut any_text, mut any_format) = (false, false, false);
        while let Some(token) = self.eat(T::Str) {
            let literal = self.literal(token);
            any_bytes |= literal.bytes;
            any_text |= !literal.bytes;
            any_format |= literal.formatted;
            if literal.bytes {
                bytes.extend(self.byte_body(&literal));
            } else if literal.formatted {
                if let Err(failed) = self.fstring_parts(&literal, literal.body, 0, &mut parts) {
                    self.aside.push(parts.into_vec().into());
                    return Err(failed);
                }
            } else {
                parts.text(&self.text_body(&literal, literal.body));
            }
        }
        let span = self.span_from(start);
        if any_bytes && any_text {
            return self.fail(
                span,
                text!(
                    "cannot join a bytes literal and a string literal",
                    "bytes 与字符串不能拼接"
                ),
            );
        }
        let kind = if any_bytes {
            ExprKind::Constant(Constant::Bytes(bytes.into()))
        } else if any_format {
            ExprKind::FString(parts.into_vec())
        } else {
            ExprKind::Constant(Constant::Str(parts.into_text().into()))
        };
        Ok(Expr::new(kind, span))
    }

    fn literal(&self, token: Token) -> StringLiteral {
        let text = self.text(token);
        let prefix_length = text.find(['"', '\'']).unwrap_or(0);
        let prefix = text[..prefix_length].to_ascii_lowercase();
        let quoted = &text[prefix_length..];
        let triple = quoted.starts_with("\"\"\"") || quoted.starts_with("'''");
        let quotes = if triple { 3 } else { 1 };
        let start = token.span.start as usize + prefix_length + quotes;
        // An unclosed literal has been reported by the lexer; it lacks the closing quotes.
        let closed = quoted.len() >= 2 * quotes && quoted.ends_with(&quoted[..quotes]);
        let end = token.span.end as usize - if closed { quotes } else { 0 };
        StringLiteral {
            raw: prefix.contains('r'),
            bytes: prefix.contains('b'),
            formatted: prefix.contains('f'),
            body: Span::new(start, end.max(start)),
        }
    }

    /// The text of (a part of) a literal, escapes resolved.
    pub(super) fn text_body(&mut self, literal: &StringLiteral, span: Span) -> String {
        let text = self.file.slice(span);
        if literal.raw || !text.contains('\\') {
            return normalize_newlines(text).into_owned();
        }
        let mut out = String::with_capacity(text.len());
        let mut rest = text;
        while let Some(backslash) = rest.find('\\') {
            self.budget.charge(ESCAPE + backslash);
            out.push_str(&normalize_newlines(&rest[..backslash]));
            let at = span.end as usize - (rest.len() - backslash);
            rest = self.escape(
                &rest[backslash + 1..],
                at,
                LiteralOrigin::Text(span.start as usize),
                &mut out,
            );
        }
        out.push_str(&normalize_newlines(rest));
        out
    }

    /// One escape after its backslash (which is at byte `at` of a text from byte `base` on) into `out`; returns what
    /// follows it. `\e` and `\oNN` are additions of the manual (1.2.1); an unknown escape keeps its backslash, as in
    /// Python.
    fn escape<'t>(
        &mut self,
        rest: &'t str,
        at: usize,
        base: LiteralOrigin,
        out: &mut String,
    ) -> &'t str {
        let Some(c) = rest.chars().next() else {
            return rest;
        };
        let after = &rest[c.len_utf8()..];
        let simple = match c {
            '\n' => return after,
            '\r' => return after.strip_prefix('\n').unwrap_or(after),
            '\\' | '\'' | '"' => c,
            'a' => '\x07',
            'b' => '\x08',
            'f' => '\x0c',
            'n' => '\n',
            'r' => '\r',
            't' => '\t',
            'v' => '\x0b',
            'e' => '\x1b',
            'N' => return self.named_escape(after, at, base, out),
            'x' => return self.hex_escape(after, 'x', 2, at, base, out),
            'u' => return self.hex_escape(after, 'u', 4, at, base, out),
            'U' => return self.hex_escape(after, 'U', 8, at, base, out),
            'o' if after.starts_with(|d: char| d.is_digit(8)) => {
                let length = after.chars().take(2).take_while(|d| d.is_digit(8)).count();
                return self.octal(after, length, out);
            }
            '0'..='7' => {
                let length = rest.chars().take(3).take_while(|d| d.is_digit(8)).count();
                return self.octal(rest, length, out);
            }
            _ => {
                out.push('\\');
                c
            }
        };
        out.push(simple);
        after
    }

    /// A character by its name in braces, after `\N`.
    fn named_escape<'t>(
        &mut self,
        after: &'t str,
        at: usize,
        base: LiteralOrigin,
        out: &mut String,
    ) -> &'t str {
        let (length, reason) = match after.strip_prefix('{') {
            None => (2, "malformed \\N character escape"),
            Some(name) => match name.find('}') {
                None => (2 + after.len(), "malformed \\N character escape"),
                Some(0) => (3, "malformed \\N character escape"),
                Some(end) => match unicode_names2::character(&name[..end]) {
                    Some(c) => {
                        out.push(c);
                        return &name[end + 1..];
                    }
                    None => (end + 4, "unknown Unicode character name"),
                },
            },
        };
        self.undecodable(at, length, base, reason);
        &after[length - 2..]
    }

    /// A character given by `length` hexadecimal digits of its code.
    fn hex_escape<'t>(
        &mut self,
        digits: &'t str,
        kind: char,
        length: usize,
        at: usize,
        base: LiteralOrigin,
        out: &mut String,
    ) -> &'t str {
        let valid = digits.bytes().take(length);
        let valid = valid.take_while(u8::is_ascii_hexdigit).count();
        if valid < length {
            if let LiteralOrigin::Bytes(start) = base {
                let place = at - start;
                let message = Text::verbatim(format!(
                    "(value error) invalid \\x escape at position {place}"
                ));
                let span = Span::new(at, at + 2 + valid);
                self.report(Diagnostic::error("syntax", span, message));
            } else {
                let reason = format!("truncated \\{kind}{} escape", "X".repeat(length));
                self.undecodable(at, 2 + valid, base, &reason);
            }
            return &digits[valid..];
        }
        let code = u32::from_str_radix(&digits[..length], 16).unwrap_or(u32::MAX);
        match char_of(code) {
            Some(c) => out.push(c),
            None => self.undecodable(at, 2 + length, base, "illegal Unicode character"),
        }
        &digits[length..]
    }

    /// A character given by `length` octal digits of its code.
    fn octal<'t>(&mut self, digits: &'t str, length: usize, out: &mut String) -> &'t str {
        let code = u32::from_str_radix(&digits[..length], 8).ok();
        // Three octal digits stay far below the surrogates.
        out.extend(code.and_then(char::from_u32));
        &digits[length..]
    }

    /// An escape of `length` bytes at `at` that stands for no character, in CPython's words: it counts places in the
    /// text as its codec sees it, where a character beyond ASCII is an escape of ten.
    fn undecodable(&mut self, at: usize, length: usize, base: LiteralOrigin, reason: &str) {
        if self.diagnostics.is_full() {
            // Counting the places reads the literal from its beginning.
            return;
        }
        let span = Span::new(at, at + length);
        let width = |span: Span| -> usize {
            let text = normalize_newlines(self.file.slice(span));
            text.chars()
                .map(|c| if c.is_ascii() { 1 } else { 10 })
                .sum()
        };
        let first = width(Span::new(base.start(), at));
        let last = first + width(span) - 1;
        let message = Text::verbatim(format!(
            "(unicode error) 'unicodeescape' codec can't decode bytes in position {first}-{last}: {reason}"
        ));
        self.report(Diagnostic::error("syntax", span, message));
    }

    fn byte_body(&mut self, literal: &StringLiteral) -> Vec<u8> {
        let text = self.file.slice(literal.body);
        if !text.is_ascii() {
            let message = text!(
                "a bytes literal can hold ASCII characters and escapes only",
                "bytes 中只能有 ASCII 字符和转义"
            );
            self.report(Diagnostic::error("syntax", literal.body, message));
        }
        let mut out = Vec::with_capacity(text.len());
        let mut rest = text;
        while let Some(backslash) = rest.find('\\') {
            self.budget.charge(ESCAPE + backslash);
            out.extend_from_slice(normalize_newlines(&rest[..backslash]).as_bytes());
            let escape = &rest[backslash + 1..];
            let is_unicode = escape.starts_with(['u', 'U', 'N']);
            if literal.raw || is_unicode {
                out.push(b'\\');
                rest = escape;
                continue;
            }
            let at = literal.body.end as usize - (rest.len() - backslash);
            let mut decoded = String::new();
            let base = LiteralOrigin::Bytes(literal.body.start as usize);
            rest = self.escape(escape, at, base, &mut decoded);
            // Escapes in bytes give codes up to 255; `\777` wraps, as in Python.
            out.extend(decoded.chars().map(|c| c as u32 as u8));
        }
        out.extend_from_slice(normalize_newlines(rest).as_bytes());
        out
    }
}

/// Line ends of any kind become newlines.
fn normalize_newlines(text: &str) -> std::borrow::Cow<'_, str> {
    if text.contains('\r') {
        text.replace("\r\n", "\n").replace('\r', "\n").into()
    } else {
        text.into()
    }
}
