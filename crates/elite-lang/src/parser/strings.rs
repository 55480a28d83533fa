//! String literals: prefixes, escapes, implicit concatenation.

use super::{Parse, Parser};
use crate::ast::{Constant, Expr, ExprKind, FStringPart};
use crate::diagnostic::Diagnostic;
use crate::lexer::{Token, TokenKind as T};
use crate::source::Span;

/// A string token taken apart.
pub(super) struct Literal {
    pub(super) raw: bool,
    bytes: bool,
    formatted: bool,
    /// The text between the quotes.
    pub(super) body: Span,
}

impl Parser<'_> {
    /// One or more string literals side by side.
    pub(super) fn strings(&mut self) -> Parse<Expr> {
        let start = self.token().span;
        let mut parts: Vec<FStringPart> = Vec::new();
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
                parts.extend(self.fstring_parts(&literal, literal.body, 0)?);
            } else {
                parts.push(FStringPart::Text(
                    self.text_body(&literal, literal.body).into(),
                ));
            }
        }
        let span = self.span_from(start);
        if any_bytes && any_text {
            return self.fail(span, "cannot join a bytes literal and a string literal");
        }
        let kind = if any_bytes {
            ExprKind::Constant(Constant::Bytes(bytes.into()))
        } else if any_format {
            ExprKind::FString(joined(parts))
        } else {
            let text: String = parts
                .iter()
                .map(|part| {
                    if let FStringPart::Text(text) = part {
                        text
                    } else {
                        ""
                    }
                })
                .collect();
            ExprKind::Constant(Constant::Str(text.into()))
        };
        Ok(Expr::new(kind, span))
    }

    fn literal(&self, token: Token) -> Literal {
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
        Literal {
            raw: prefix.contains('r'),
            bytes: prefix.contains('b'),
            formatted: prefix.contains('f'),
            body: Span::new(start, end.max(start)),
        }
    }

    /// The text of (a part of) a literal, escapes resolved.
    pub(super) fn text_body(&mut self, literal: &Literal, span: Span) -> String {
        let text = self.file.slice(span);
        if literal.raw || !text.contains('\\') {
            return normalized(text).into_owned();
        }
        let mut out = String::with_capacity(text.len());
        let mut rest = text;
        while let Some(backslash) = rest.find('\\') {
            out.push_str(&normalized(&rest[..backslash]));
            let at = span.end as usize - (rest.len() - backslash);
            rest = self.escape(&rest[backslash + 1..], at, &mut out);
        }
        out.push_str(&normalized(rest));
        out
    }

    /// One escape after its backslash (which is at byte `at`) into `out`; returns what follows it.
    /// `\e` and `\oNN` are additions of the manual (1.2.1); an unknown escape keeps its backslash, as in Python.
    fn escape<'t>(&mut self, rest: &'t str, at: usize, out: &mut String) -> &'t str {
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
            'N' => {
                let end = match after.strip_prefix('{') {
                    Some(name) => name.find('}').map_or(after.len(), |end| end + 2),
                    None => 0,
                };
                let span = Span::new(at, at + 2 + end);
                let message = "characters by name are not supported";
                let help = "write the number of the character: '\\u00b0'";
                self.report(Diagnostic::error("not-supported", span, message).with_help(help));
                return &after[end..];
            }
            'x' => return self.coded(after, 2, 16, at, out),
            'u' => return self.coded(after, 4, 16, at, out),
            'U' => return self.coded(after, 8, 16, at, out),
            'o' if after.starts_with(|d: char| d.is_digit(8)) => {
                let length = after.chars().take(2).take_while(|d| d.is_digit(8)).count();
                return self.coded(after, length, 8, at, out);
            }
            '0'..='7' => {
                let length = rest.chars().take(3).take_while(|d| d.is_digit(8)).count();
                return self.coded(rest, length, 8, at, out);
            }
            _ => {
                out.push('\\');
                c
            }
        };
        out.push(simple);
        after
    }

    /// A character given by `length` digits of its code.
    fn coded<'t>(
        &mut self,
        digits: &'t str,
        length: usize,
        radix: u32,
        at: usize,
        out: &mut String,
    ) -> &'t str {
        let code = digits
            .get(..length)
            .filter(|d| d.chars().all(|c| c.is_digit(radix)));
        let code = code.and_then(|d| u32::from_str_radix(d, radix).ok());
        let span = Span::new(at, at + 2);
        let Some(code) = code else {
            self.report(Diagnostic::error(
                "syntax",
                span,
                format!("this escape needs {length} digits"),
            ));
            return digits;
        };
        match char::from_u32(code) {
            Some(c) => out.push(c),
            None => {
                let message = format!(
                    "U+{code:04X} is no character; surrogates cannot stand alone in a string"
                );
                self.report(Diagnostic::error("syntax", span, message));
            }
        }
        &digits[length..]
    }

    fn byte_body(&mut self, literal: &Literal) -> Vec<u8> {
        let text = self.file.slice(literal.body);
        if !text.is_ascii() {
            let message = "a bytes literal can hold ASCII characters and escapes only";
            self.report(Diagnostic::error("syntax", literal.body, message));
        }
        let mut out = Vec::with_capacity(text.len());
        let mut rest = text;
        while let Some(backslash) = rest.find('\\') {
            out.extend_from_slice(normalized(&rest[..backslash]).as_bytes());
            let escape = &rest[backslash + 1..];
            let is_unicode = escape.starts_with(['u', 'U', 'N']);
            if literal.raw || is_unicode {
                out.push(b'\\');
                rest = escape;
                continue;
            }
            let at = literal.body.end as usize - (rest.len() - backslash);
            let mut decoded = String::new();
            rest = self.escape(escape, at, &mut decoded);
            // Escapes in bytes give codes up to 255; `\777` wraps, as in Python.
            out.extend(decoded.chars().map(|c| c as u32 as u8));
        }
        out.extend_from_slice(normalized(rest).as_bytes());
        out
    }
}

/// Line ends of any kind become newlines.
fn normalized(text: &str) -> std::borrow::Cow<'_, str> {
    if text.contains('\r') {
        text.replace("\r\n", "\n").replace('\r', "\n").into()
    } else {
        text.into()
    }
}

/// Neighbouring texts of an f-string become one.
fn joined(parts: Vec<FStringPart>) -> Vec<FStringPart> {
    let mut out: Vec<FStringPart> = Vec::new();
    for part in parts {
        match (out.last_mut(), part) {
            (Some(FStringPart::Text(before)), FStringPart::Text(text)) => {
                *before = format!("{before}{text}").into();
            }
            (_, FStringPart::Text(text)) if text.is_empty() => {}
            (_, part) => out.push(part),
        }
    }
    out
}
