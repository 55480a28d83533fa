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
        spec.sign = flag(&mut rest, |c| matches!(c, '+' | '-' | ' ')).unwrap_or('-');
        spec.no_negative_zero = flag(&mut rest, |c| c == 'z').is_some();
        spec.alternate = flag(&mut rest, |c| c == '#').is_some();
        if !filled && flag(&mut rest, |c| c == '0').is_some() {
            spec.fill = '0';
            if numeric {
                spec.align.get_or_insert('=');
            }
        }
        spec.width = number(&mut rest)?.unwrap_or(0);
        spec.grouping = flag(&mut rest, |c| matches!(c, ',' | '_'));
        if spec.grouping.is_some() && rest.starts_with([',', '_']) {
            return Err("Cannot specify both ',' and '_'.".to_owned());
        }
        if flag(&mut rest, |c| c == '.').is_some() {
            spec.precision = number(&mut rest)?;
            if spec.precision.is_none() {
                return Err("Format specifier missing precision".to_owned());
            }
        }
        spec.kind = flag(&mut rest, |_| true);
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
fn flag(rest: &mut &str, is: impl Fn(char) -> bool) -> Option<char> {
    let c = rest.chars().next().filter(|c| is(*c))?;
    *rest = &rest[c.len_utf8()..];
    Some(c)
}

/// Takes a number of a specification, if there is one.
fn number(rest: &mut &str) -> Result<Option<usize>, String> {
    let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
    let (number, after) = rest.split_at(digits);
    *rest = after;
    if number.is_empty() {
        return Ok(None);
    }
    // Too long for the type is too big as well.
    match number.parse::<usize>() {
        Ok(value) if value <= SIZE_MAX => Ok(Some(value)),
        _ => Err("Too many decimal digits in format string".to_owned()),
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
    if spec.width == 0 && spec.precision.is_none() {
        out.push_str(text);
        return Ok(());
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
    if let (Int::Small(small), 'd', None, None) = (int, kind, spec.grouping, spec.precision) {
        let start = out.len();
        let sign = sign_of(*small < 0, spec);
        out.push_str(sign);
        push_digits(small.unsigned_abs(), 1, out);
        fill_up(start, sign.len(), spec, out);
        return Ok(());
    }
    if "eEfFgG%".contains(kind) {
        return real(ev.int_to_f64(int)?, spec, "int", ev, out);
    }
    if !"bcdnoxX".contains(kind) {
        return Err(unknown_kind(ev, kind, type_name));
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
    let sign = format!("{sign}{prefix}");
    grouped_number(&sign, &digits, "", every, spec, out);
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
    if spec.grouping.is_none() && !spec.no_negative_zero {
        let start = out.len();
        let sign = sign_of(value.is_sign_negative() && !value.is_nan(), spec);
        out.push_str(sign);
        match (spec.kind, spec.precision) {
            (Some('f'), precision) => {
                float::push_fixed(value.abs(), precision.unwrap_or(6), spec.alternate, out);
            }
            (None, None) => float::push_repr(value.abs(), out),
            _ => {
                let (body, tail) = real_body(value.abs(), spec, type_name, ev)?;
                out.push_str(&body);
                out.push_str(tail);
            }
        }
        fill_up(start, sign.len(), spec, out);
        return Ok(());
    }
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
    grouped_number(
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
    if let Some(kind) = spec.kind.filter(|kind| !"eEfFgGn".contains(*kind)) {
        return Err(unknown_kind(ev, kind, "complex"));
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
    let text = if spec.kind.is_none() {
        if re == 0.0 && re.is_sign_positive() {
            format!("{}j", part(im, spec.sign)?)
        } else {
            format!("({}{}j)", part(re, spec.sign)?, part(im, '+')?)
        }
    } else {
        format!("{}{}j", part(re, spec.sign)?, part(im, '+')?)
    };
    pad("", &text, spec.align.unwrap_or('>'), spec, out);
    Ok(())
}

/// Appends sign, digits (grouped) and the rest, padded to the width.
fn grouped_number(
    sign: &str,
    digits: &str,
    rest: &str,
    every: usize,
    spec: &Spec,
    out: &mut String,
) {
    let start = out.len();
    out.push_str(sign);
    match spec.grouping {
        None => out.push_str(digits),
        Some(separator) => {
            let mut digits = digits.to_owned();
            if spec.align.unwrap_or('>') == '=' && spec.fill == '0' {
                // Zeros that fill the width are grouped, too.
                let wanted = spec.width.saturating_sub(sign.len() + rest.len());
                while grouped_length(digits.len(), every) < wanted {
                    digits.insert(0, '0');
                }
            }
            out.push_str(&grouped(&digits, separator, every));
        }
    }
    out.push_str(rest);
    fill_up(start, sign.len(), spec, out);
}

/// Appends a number in decimal, with at least so many digits.
pub fn push_digits(number: u64, least: usize, out: &mut String) {
    let mut digits = [b'0'; 20];
    let mut at = digits.len();
    let mut rest = number;
    while rest > 0 {
        at -= 1;
        digits[at] = b'0' + (rest % 10) as u8;
        rest /= 10;
    }
    let at = at.min(digits.len() - least.min(digits.len()));
    out.push_str(std::str::from_utf8(&digits[at..]).unwrap_or_default());
}

/// Fills a number that was appended at byte `start`, with a sign of `sign` bytes, up to the width.
fn fill_up(start: usize, sign: usize, spec: &Spec, out: &mut String) {
    if spec.width == 0 {
        return;
    }
    let missing = spec.width.saturating_sub(out[start..].chars().count());
    if missing == 0 {
        return;
    }
    let mut fill = |at: usize, count: usize| {
        if at > out.len() {
            out.extend(std::iter::repeat_n(spec.fill, count));
        } else {
            out.insert_str(
                at,
                &std::iter::repeat_n(spec.fill, count).collect::<String>(),
            );
        }
    };
    match spec.align.unwrap_or('>') {
        '<' => fill(usize::MAX, missing),
        '=' => fill(start + sign, missing),
        '^' => {
            fill(start, missing / 2);
            fill(usize::MAX, missing - missing / 2);
        }
        _ => fill(start, missing),
    }
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
