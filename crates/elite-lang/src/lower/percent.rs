//! `"…" % (a, b)`: a constant format with a tuple written out. Where it asks for texts only (`%s`, `%r`, `%a`) it is an
//! f-string, as in CPython: each item is formatted before the next one is evaluated, and by its `__format__`.

use elite_syntax::Span;
use elite_syntax::ast::{self, BinaryOp, Constant, Conversion, ExprKind};

use super::Lower;
use crate::eval::BoxExpr;
use crate::eval::expr::fstring::{FString, FStringSegment};
use crate::eval::expr::percent::PercentFormat;
use crate::value::Value;

/// Digits of a width or a precision; CPython leaves more to `%` itself.
const DIGITS_MAX: usize = 3;

impl Lower<'_> {
    /// A constant text with a tuple after `%`.
    pub(super) fn percent_format(
        &mut self,
        op: BinaryOp,
        left: &ast::Expr,
        right: &ast::Expr,
        span: Span,
    ) -> Option<BoxExpr> {
        let (BinaryOp::Mod, ExprKind::Tuple(items)) = (op, &right.kind) else {
            return None;
        };
        let ExprKind::Constant(text @ Constant::Str(_)) = &left.kind else {
            return None;
        };
        let is_starred = |item: &ast::Expr| matches!(item.kind, ExprKind::Starred(_));
        let Value::Str(format) = self.constant(text) else {
            return None;
        };
        if items.iter().any(is_starred) {
            return None;
        }
        if let Some(pieces) = pieces(format.as_str(), items.len()) {
            let mut items = items.iter();
            let part = |piece| {
                Some(match piece {
                    FormatSegment::Text(text) => FStringSegment::Text(text.into()),
                    FormatSegment::Field(conversion, spec) => FStringSegment::Field {
                        value: self.expr(items.next()?),
                        conversion,
                        spec: spec.into(),
                        nested: None,
                        span,
                    },
                })
            };
            return Some(Box::new(FString(
                pieces.into_iter().filter_map(part).collect(),
            )));
        }
        let items = items.iter().map(|item| self.operand(item)).collect();
        Some(Box::new(PercentFormat {
            format,
            items,
            span,
        }))
    }
}

/// A piece of a format, in the words of f-strings.
#[derive(Debug, PartialEq)]
enum FormatSegment {
    Text(String),
    Field(Conversion, String),
}

/// A format in pieces, if it has fields of texts only, one for each of `count` items.
fn pieces(format: &str, count: usize) -> Option<Vec<FormatSegment>> {
    let (mut pieces, mut text, mut fields) = (Vec::new(), String::new(), 0);
    let mut rest = format;
    while let Some(at) = rest.find('%') {
        text.push_str(&rest[..at]);
        rest = &rest[at + 1..];
        if let Some(behind) = rest.strip_prefix('%') {
            text.push('%');
            rest = behind;
            continue;
        }
        let (field, behind) = field(rest)?;
        if !text.is_empty() {
            pieces.push(FormatSegment::Text(std::mem::take(&mut text)));
        }
        pieces.push(field);
        fields += 1;
        rest = behind;
    }
    text.push_str(rest);
    if !text.is_empty() {
        pieces.push(FormatSegment::Text(text));
    }
    (fields == count).then_some(pieces)
}

/// A field at the start of a text behind its `%`, and the text behind it.
fn field(text: &str) -> Option<(FormatSegment, &str)> {
    let behind = text.trim_start_matches(['-', '+', ' ', '#', '0']);
    let is_left = text[..text.len() - behind.len()].contains('-');
    let (width, behind) = digits(behind)?;
    let (precision, behind) = match behind.strip_prefix('.') {
        Some(behind) => {
            let (digits, behind) = digits(behind)?;
            (Some(digits.unwrap_or(0)), behind)
        }
        None => (None, behind),
    };
    let conversion = match behind.bytes().next()? {
        b's' => Conversion::Str,
        b'r' => Conversion::Repr,
        b'a' => Conversion::Ascii,
        _ => return None,
    };
    let mut spec = String::new();
    if let Some(width) = width {
        if !is_left && width > 0 {
            spec.push('>');
        }
        spec.push_str(&width.to_string());
    }
    if let Some(precision) = precision {
        spec.push_str(&format!(".{precision}"));
    }
    Some((FormatSegment::Field(conversion, spec), &behind[1..]))
}

/// The number at the start of a text, if there is one, and the text behind it; None if it has too many digits.
fn digits(text: &str) -> Option<(Option<u32>, &str)> {
    let behind = text.trim_start_matches(|c: char| c.is_ascii_digit());
    let digits = &text[..text.len() - behind.len()];
    match digits.len() {
        0 => Some((None, behind)),
        1..=DIGITS_MAX => Some((digits.parse().ok(), behind)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_formats_of_texts_are_fields() {
        let field = |conversion, spec: &str| FormatSegment::Field(conversion, spec.to_owned());
        let found = pieces("50%% %s|%-5r%a", 3);
        let wanted = vec![
            FormatSegment::Text("50% ".to_owned()),
            field(Conversion::Str, ""),
            FormatSegment::Text("|".to_owned()),
            field(Conversion::Repr, "5"),
            field(Conversion::Ascii, ""),
        ];
        assert_eq!(found, Some(wanted));
        let found = pieces("%+08.s", 1);
        assert_eq!(found, Some(vec![field(Conversion::Str, ">8.0")]));
        for (format, count) in [
            ("%s", 2),
            ("%s %d", 2),
            ("%(a)s", 1),
            ("%*s", 2),
            ("%1000s", 1),
            ("%", 0),
        ] {
            assert_eq!(pieces(format, count), None, "{format}");
        }
    }
}
