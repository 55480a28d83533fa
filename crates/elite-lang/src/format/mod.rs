//! Formatting of numbers and text: the format specification of `format`, f-strings and `str.format`, and `%`.

mod fields;
pub mod float;
mod percent;

use std::fmt::Write as _;

use num_bigint::BigInt;

use crate::eval::Evaluator;
use crate::value::int::Int;
use crate::value::{R, Value};

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
    pub fn parse(text: &str, type_name: &str) -> Result<Self, String> {
        let numeric = type_name != "str";
        let invalid =
            || format!("Invalid format specifier '{text}' for object of type '{type_name}'");
        let chars: Vec<char> = text.chars().collect();
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
        let is_align = |c: &char| matches!(c, '<' | '>' | '=' | '^');
        let mut at = 0;
        let mut filled = false;
        if chars.get(1).is_some_and(is_align) {
            (spec.fill, spec.align, at) = (chars[0], Some(chars[1]), 2);
            filled = true;
        } else if chars.first().is_some_and(is_align) {
            (spec.align, at) = (Some(chars[0]), 1);
        }
        if let Some(sign @ ('+' | '-' | ' ')) = chars.get(at) {
            spec.sign = *sign;
            at += 1;
        }
        let flag = |c: char, at: &mut usize| {
            let found = chars.get(*at) == Some(&c);
            *at += usize::from(found);
            found
        };
        spec.no_negative_zero = flag('z', &mut at);
        spec.alternate = flag('#', &mut at);
        if !filled && flag('0', &mut at) {
            spec.fill = '0';
            if numeric {
                spec.align.get_or_insert('=');
            }
        }
        let number = |at: &mut usize| -> Result<Option<usize>, String> {
            let start = *at;
            let mut value = 0usize;
            while let Some(digit) = chars.get(*at).and_then(|c| c.to_digit(10)) {
                value = value.saturating_mul(10).saturating_add(digit as usize);
                *at += 1;
            }
            if value > SIZE_MAX {
                return Err("Too many decimal digits in format string".to_owned());
            }
            Ok((*at > start).then_some(value))
        };
        spec.width = number(&mut at)?.unwrap_or(0);
        if let Some(grouping @ (',' | '_')) = chars.get(at) {
            spec.grouping = Some(*grouping);
            at += 1;
            if let Some(',' | '_') = chars.get(at) {
                return Err("Cannot specify both ',' and '_'.".to_owned());
            }
        }
        if chars.get(at) == Some(&'.') {
            at += 1;
            spec.precision = number(&mut at)?;
            if spec.precision.is_none() {
                return Err("Format specifier missing precision".to_owned());
            }
        }
        if let Some(kind) = chars.get(at) {
            spec.kind = Some(*kind);
            at += 1;
        }
        if let (Some(grouping), Some(kind)) = (spec.grouping, spec.kind)
            && at == chars.len()
            && !"deEfFgG%".contains(kind)
            && !(grouping == '_' && "boxX".contains(kind))
        {
            return Err(format!("Cannot specify '{grouping}' with '{kind}'."));
        }
        if at != chars.len() {
            Err(invalid())
        } else {
            Ok(spec)
        }
    }
}

/// Appends a number or text formatted by a specification.
pub fn value(value: &Value, spec: &Spec, ev: &Evaluator<'_>, out: &mut String) -> R<()> {
    match value {
        Value::Str(text) => self::text(text.as_str(), spec, ev, out),
        Value::Float(float) => real(*float, spec, "float", ev, out),
        Value::Complex(complex) => self::complex(complex.0, complex.1, spec, ev, out),
        other => match Int::of(other) {
            Some(int) => {
                let type_name = if matches!(other, Value::Bool(_)) {
                    "bool"
                } else {
                    "int"
                };
                integer(&int, spec, type_name, ev, out)
            }
            None => Err(ev.type_error("cannot format this value with a number's specification")),
        },
    }
}

fn unknown_kind(ev: &Evaluator<'_>, kind: char, type_name: &str) -> crate::value::Raised {
    ev.value_error(format!(
        "Unknown format code '{kind}' for object of type '{type_name}'"
    ))
}

fn text(text: &str, spec: &Spec, ev: &Evaluator<'_>, out: &mut String) -> R<()> {
    match spec.kind {
        None | Some('s') => {}
        Some(kind) => return Err(unknown_kind(ev, kind, "str")),
    }
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
    let cut: String;
    let shown = match spec.precision {
        Some(precision) if precision < text.chars().count() => {
            cut = text.chars().take(precision).collect();
            &cut
        }
        _ => text,
    };
    let align = match spec.align {
        Some('=') | None => '<',
        Some(align) => align,
    };
    pad("", shown, align, spec, out);
    Ok(())
}

fn integer(int: &Int, spec: &Spec, type_name: &str, ev: &Evaluator<'_>, out: &mut String) -> R<()> {
    let kind = spec.kind.unwrap_or('d');
    if "eEfFgG%".contains(kind) {
        return real(ev.int_to_f64(int)?, spec, "int", ev, out);
    }
    if spec.precision.is_some() {
        return Err(ev.value_error("Precision not allowed in integer format specifier"));
    }
    let (prefix, digits) = match kind {
        'd' | 'n' => ("", decimal_digits(int, ev)?),
        'b' => ("0b", radix_digits(int, 2)),
        'o' => ("0o", radix_digits(int, 8)),
        'x' => ("0x", radix_digits(int, 16)),
        'X' => ("0X", radix_digits(int, 16).to_uppercase()),
        'c' => return character(int, spec, ev, out),
        other => return Err(unknown_kind(ev, other, type_name)),
    };
    if spec.grouping == Some(',') && kind != 'd' {
        return Err(ev.value_error(format!("Cannot specify ',' with '{kind}'.")));
    }
    let every = if kind == 'd' { 3 } else { 4 };
    let sign = sign_of(int.is_negative(), spec);
    let prefix = if spec.alternate { prefix } else { "" };
    number(&format!("{sign}{prefix}"), &digits, "", every, spec, out);
    Ok(())
}

fn character(int: &Int, spec: &Spec, ev: &Evaluator<'_>, out: &mut String) -> R<()> {
    if spec.sign != '-' {
        return Err(ev.value_error("Sign not allowed with integer format specifier 'c'"));
    }
    if spec.alternate {
        let text = "Alternate form (#) not allowed with integer format specifier 'c'";
        return Err(ev.value_error(text));
    }
    if let Some(grouping) = spec.grouping {
        return Err(ev.value_error(format!("Cannot specify '{grouping}' with 'c'.")));
    }
    let code = match int {
        Int::Small(code) => u32::try_from(*code).ok().and_then(char::from_u32),
        Int::Big(_) => None,
    };
    let Some(c) = code else {
        return Err(ev.raise(
            crate::errors::ExceptionKind::OverflowError,
            "%c arg not in range(0x110000)",
        ));
    };
    pad("", &c.to_string(), spec.align.unwrap_or('>'), spec, out);
    Ok(())
}

/// The digits of the magnitude in decimal.
fn decimal_digits(int: &Int, ev: &Evaluator<'_>) -> R<String> {
    Ok(match int {
        Int::Small(small) => small.unsigned_abs().to_string(),
        Int::Big(big) => ev.big_to_text(big)?.trim_start_matches('-').to_owned(),
    })
}

fn radix_digits(int: &Int, radix: u32) -> String {
    match int {
        Int::Small(small) => match radix {
            2 => format!("{:b}", small.unsigned_abs()),
            8 => format!("{:o}", small.unsigned_abs()),
            _ => format!("{:x}", small.unsigned_abs()),
        },
        Int::Big(big) => BigInt::from(big.magnitude().clone()).to_str_radix(radix),
    }
}

/// An integer in a radix with sign and prefix, for `bin`, `oct`, `hex`.
pub fn prefixed(int: &Int, radix: u32, prefix: &str) -> String {
    format!(
        "{}{prefix}{}",
        if int.is_negative() { "-" } else { "" },
        radix_digits(int, radix)
    )
}

fn sign_of(negative: bool, spec: &Spec) -> &'static str {
    match (negative, spec.sign) {
        (true, _) => "-",
        (false, '+') => "+",
        (false, ' ') => " ",
        _ => "",
    }
}

fn real(value: f64, spec: &Spec, type_name: &str, ev: &Evaluator<'_>, out: &mut String) -> R<()> {
    let (body, tail) = real_body(value.abs(), spec, type_name, ev)?;
    let mut negative = value.is_sign_negative() && !value.is_nan();
    if spec.no_negative_zero && !body.contains(|c: char| ('1'..='9').contains(&c)) {
        negative = false;
    }
    let split = body.find(['.', 'e', 'E', '%']).unwrap_or(body.len());
    let (digits, fraction) = body.split_at(split);
    let finite = value.is_finite();
    let spec_without_grouping = Spec {
        grouping: None,
        ..spec.clone()
    };
    let spec = if finite { spec } else { &spec_without_grouping };
    number(
        sign_of(negative, spec),
        digits,
        &format!("{fraction}{tail}"),
        3,
        spec,
        out,
    );
    Ok(())
}

/// The digits of a non-negative float as the specification wants them, and what follows them.
fn real_body(
    value: f64,
    spec: &Spec,
    type_name: &str,
    ev: &Evaluator<'_>,
) -> R<(String, &'static str)> {
    let precision = spec.precision.unwrap_or(6);
    Ok(match spec.kind {
        None => match spec.precision {
            None => (float::repr(value), ""),
            Some(precision) => (
                float::general(value, precision.max(1), spec.alternate, true),
                "",
            ),
        },
        Some('f') => (float::fixed(value, precision, spec.alternate), ""),
        Some('F') => (
            float::fixed(value, precision, spec.alternate).to_uppercase(),
            "",
        ),
        Some('e') => (float::exponent(value, precision, spec.alternate), ""),
        Some('E') => (
            float::exponent(value, precision, spec.alternate).to_uppercase(),
            "",
        ),
        Some('g' | 'n') => (
            float::general(value, precision.max(1), spec.alternate, false),
            "",
        ),
        Some('G') => (
            float::general(value, precision.max(1), spec.alternate, false).to_uppercase(),
            "",
        ),
        Some('%') => (float::fixed(value * 100.0, precision, spec.alternate), "%"),
        Some(kind) => return Err(unknown_kind(ev, kind, type_name)),
    })
}

fn complex(re: f64, im: f64, spec: &Spec, ev: &Evaluator<'_>, out: &mut String) -> R<()> {
    if spec.align == Some('=') && spec.fill != '0' {
        let text = "'=' alignment flag is not allowed in complex format specifier";
        return Err(ev.value_error(text));
    }
    if spec.align == Some('=') || spec.fill == '0' {
        return Err(ev.value_error("Zero padding is not allowed in complex format specifier"));
    }
    let part = |value: f64, sign: char| -> R<String> {
        let mut text = String::new();
        let spec = Spec {
            width: 0,
            align: None,
            fill: ' ',
            sign,
            ..spec.clone()
        };
        real(value, &spec, "complex", ev, &mut text)?;
        // Without a type, whole parts are written without a point.
        if spec.kind.is_none() && text.ends_with(".0") {
            text.truncate(text.len() - 2);
        }
        Ok(text)
    };
    let text = if spec.kind.is_none() && spec.precision.is_none() {
        float::complex_repr(re, im)
    } else if spec.kind.is_none() {
        let imaginary = part(im, '+')?;
        if re == 0.0 && re.is_sign_positive() {
            format!("{}j", imaginary.trim_start_matches('+'))
        } else {
            format!("({}{imaginary}j)", part(re, spec.sign)?)
        }
    } else {
        format!("{}{}j", part(re, spec.sign)?, part(im, '+')?)
    };
    pad("", &text, spec.align.unwrap_or('>'), spec, out);
    Ok(())
}

/// Appends sign, digits (grouped) and the rest, padded to the width.
fn number(sign: &str, digits: &str, rest: &str, every: usize, spec: &Spec, out: &mut String) {
    let align = spec.align.unwrap_or('>');
    let Some(separator) = spec.grouping else {
        let mut body = String::with_capacity(digits.len() + rest.len());
        body.push_str(digits);
        body.push_str(rest);
        return pad(sign, &body, align, spec, out);
    };
    let mut digits = digits.to_owned();
    if align == '=' && spec.fill == '0' {
        // Zeros that fill the width are grouped, too.
        let wanted = spec.width.saturating_sub(sign.len() + rest.len());
        while grouped_length(digits.len(), every) < wanted {
            digits.insert(0, '0');
        }
    }
    let body = format!("{}{rest}", grouped(&digits, separator, every));
    pad(sign, &body, align, spec, out);
}

fn grouped_length(digits: usize, every: usize) -> usize {
    digits + digits.saturating_sub(1) / every
}

fn grouped(digits: &str, separator: char, every: usize) -> String {
    let mut out = String::with_capacity(digits.len() * 4 / 3);
    for (index, c) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(every) {
            out.push(separator);
        }
        out.push(c);
    }
    out
}

/// Appends `sign` and `body`, filled up to the width.
fn pad(sign: &str, body: &str, align: char, spec: &Spec, out: &mut String) {
    let missing = match spec.width {
        0 => 0,
        width => width.saturating_sub(sign.chars().count() + body.chars().count()),
    };
    let fill = |count: usize, out: &mut String| out.extend(std::iter::repeat_n(spec.fill, count));
    let (before, inside, after) = match align {
        '<' => (0, 0, missing),
        '=' => (0, missing, 0),
        '^' => (missing / 2, 0, missing - missing / 2),
        _ => (missing, 0, 0),
    };
    fill(before, out);
    let _ = out.write_str(sign);
    fill(inside, out);
    out.push_str(body);
    fill(after, out);
}
