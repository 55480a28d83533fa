//! Formatting of numbers and text: the format specification of `format`, f-strings and `str.format`, and `%`.

mod fields;

pub mod float;
mod number;
mod percent;

use crate::eval::Evaluator;
use crate::ops::unicode::decimal;
use crate::value::int::Int;
use crate::value::{R, Value};

use number::{complex, integer, real, sign_of};
pub use number::{prefixed, push_digits};

/// A parsed format specification: `[[fill]align][sign][z][#][0][width][grouping][.precision][type]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Spec {
    /// Character that fills up to the width.
    pub fill: char,
    /// `<`, `>`, `=` or `^`; None is the type's default.
    pub align: Option<char>,
    /// `+`, `-` or a blank.
    pub sign: char,
    /// `z`: no negative zero.
    pub no_negative_zero: bool,
    /// `#`
    pub alternate: bool,
    /// Least width in characters.
    pub width: usize,
    /// `,` or `_`
    pub grouping: Option<char>,
    /// Digits after the point, or most characters of text.
    pub precision: Option<usize>,
    /// The presentation type.
    pub kind: Option<char>,
}

/// Widths and precisions beyond this are refused.
const SIZE_MAX: usize = i32::MAX as usize;

impl Spec {
    /// Parses a specification for a value of type `type_name`; the error is the message of a `ValueError`.
    pub fn parse(text: &str, type_name: &str, is_text: bool) -> Result<Self, String> {
        let numeric = !is_text;
        let mut spec = Spec {
            fill: ' ',
            align: None,
            sign: '-',
            no_negative_zero: false,
            alternate: false,
            width: 0,
            grouping: None,
            precision: None,
            kind: None,
        };
        let is_align = |c: char| matches!(c, '<' | '>' | '=' | '^');
        let mut rest = text;
        let mut chars = text.chars();
        let (first, second) = (chars.next(), chars.next());
        let filled = second.is_some_and(is_align);
        if let (Some(fill), true) = (first, filled) {
            (spec.fill, spec.align, rest) = (fill, second, chars.as_str());
        } else if first.is_some_and(is_align) {
            (spec.align, rest) = (first, &text[1..]);
        }
        spec.sign = match take_flag(&mut rest, |c| matches!(c, '+' | '-' | ' ')) {
            // A sign that is given counts for texts, which take none, even if it is the usual one.
            Some('-') if !numeric => '+',
            given => given.unwrap_or('-'),
        };
        spec.no_negative_zero = take_flag(&mut rest, |c| c == 'z').is_some();
        spec.alternate = take_flag(&mut rest, |c| c == '#').is_some();
        if !filled && take_flag(&mut rest, |c| c == '0').is_some() {
            spec.fill = '0';
            if numeric {
                spec.align.get_or_insert('=');
            }
        }
        spec.width = number(&mut rest)?.unwrap_or(0);
        spec.grouping = take_flag(&mut rest, |c| matches!(c, ',' | '_'));
        if spec.grouping.is_some() && rest.starts_with([',', '_']) {
            return Err("Cannot specify both ',' and '_'.".to_owned());
        }
        if take_flag(&mut rest, |c| c == '.').is_some() {
            spec.precision = number(&mut rest)?;
            if spec.precision.is_none() {
                return Err("Format specifier missing precision".to_owned());
            }
        }
        spec.kind = take_flag(&mut rest, |_| true);
        if !rest.is_empty() {
            return Err(format!(
                "Invalid format specifier '{text}' for object of type '{type_name}'"
            ));
        }
        if let (Some(grouping), Some(kind)) = (spec.grouping, spec.kind)
            && !"deEfFgG%".contains(kind)
            && !(grouping == '_' && "boxX".contains(kind))
        {
            return Err(format!("Cannot specify '{grouping}' with '{kind}'."));
        }
        Ok(spec)
    }
}

/// Takes the next character of a specification, if it is one that `is` means.
fn take_flag(rest: &mut &str, is: impl Fn(char) -> bool) -> Option<char> {
    let c = rest.chars().next().filter(|c| is(*c))?;
    *rest = &rest[c.len_utf8()..];
    Some(c)
}

/// Takes a number of a specification, if there is one.
fn number(rest: &mut &str) -> Result<Option<usize>, String> {
    let length = rest.find(|c| decimal(c).is_none()).unwrap_or(rest.len());
    let (digits, after) = rest.split_at(length);
    *rest = after;
    if digits.is_empty() {
        return Ok(None);
    }
    // Too long for the type is too big as well.
    match index_of(digits) {
        Some(value) if value <= SIZE_MAX => Ok(Some(value)),
        _ => Err("Too many decimal digits in format string".to_owned()),
    }
}

/// The number that digits of any script stand for; None if it is too big, or if they are none.
fn index_of(digits: &str) -> Option<usize> {
    let more = |number: usize, c| number.checked_mul(10)?.checked_add(decimal(c)? as usize);
    let mut digits = digits.chars();
    let first = decimal(digits.next()?)? as usize;
    digits.try_fold(first, more)
}

/// Appends a number or text formatted by a specification.
pub fn value(
    value: &Value,
    spec: &Spec,
    type_name: &str,
    ev: &Evaluator<'_>,
    out: &mut String,
) -> R<()> {
    match value {
        Value::Str(text) => match spec.kind {
            None | Some('s') => self::text(text.as_str(), spec, ev, out),
            Some(kind) => Err(unknown_kind(ev, kind, type_name)),
        },
        Value::Float(float) => real(*float, spec, type_name, ev, out),
        Value::Complex(complex) => self::complex((complex.0, complex.1), spec, type_name, ev, out),
        other => match Int::of(other) {
            Some(int) => integer(&int, spec, type_name, ev, out),
            None => Err(ev.type_error("cannot format this value with a number's specification")),
        },
    }
}

fn unknown_kind(ev: &Evaluator<'_>, kind: char, type_name: &str) -> crate::value::Unwind {
    let kind = match kind {
        ' '..='~' => kind.to_string(),
        other => format!("\\x{:x}", elite_syntax::surrogate::code_of(other)),
    };
    ev.value_error(format!(
        "Unknown format code '{kind}' for object of type '{type_name}'"
    ))
}

fn text(text: &str, spec: &Spec, ev: &Evaluator<'_>, out: &mut String) -> R<()> {
    let refused = if spec.no_negative_zero {
        Some("Negative zero coercion (z) not allowed in string format specifier")
    } else if spec.sign == ' ' {
        Some("Space not allowed in string format specifier")
    } else if spec.sign != '-' {
        Some("Sign not allowed in string format specifier")
    } else if spec.alternate {
        Some("Alternate form (#) not allowed in string format specifier")
    } else if spec.align == Some('=') && spec.fill != '0' {
        Some("'=' alignment not allowed in string format specifier")
    } else if spec.grouping.is_some() {
        return Err(ev.value_error(format!(
            "Cannot specify '{}' with 's'.",
            spec.grouping.unwrap_or(',')
        )));
    } else {
        None
    };
    if let Some(message) = refused {
        return Err(ev.value_error(message));
    }
    if spec.width == 0 && spec.precision.is_none() {
        return ev.push_text(out, text);
    }
    let shown = match spec.precision {
        Some(precision) => ev.char_prefix(text, precision)?,
        None => text,
    };
    let align = match spec.align {
        Some('=') | None => '<',
        Some(align) => align,
    };
    pad("", shown, align, spec, ev, out)
}

/// Appends `sign` and `body`, filled up to the width.
fn pad(
    sign: &str,
    body: &str,
    align: char,
    spec: &Spec,
    ev: &Evaluator<'_>,
    out: &mut String,
) -> R<()> {
    let missing = match spec.width {
        0 => 0,
        width => width.saturating_sub(sign.chars().count() + ev.count_chars(body)?),
    };
    let mut buffer = [0; 4];
    let filling = &*spec.fill.encode_utf8(&mut buffer);
    let fill = |count: usize, out: &mut String| ev.push_repeated(out, filling, count);
    let (before, inside, after) = match align {
        '<' => (0, 0, missing),
        '=' => (0, missing, 0),
        '^' => (missing / 2, 0, missing - missing / 2),
        _ => (missing, 0, 0),
    };
    fill(before, out)?;
    out.push_str(sign);
    fill(inside, out)?;
    ev.push_text(out, body)?;
    fill(after, out)
}
