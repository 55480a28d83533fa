//! Numbers by a specification: they are written where they go and filled up to the width there.

use super::float::FloatText;
use super::{Spec, float, pad, unknown_kind};
use crate::eval::Evaluator;
use crate::limits::chunked::WORK_PER_BYTE;
use crate::value::R;
use crate::value::int::Int;

pub(super) fn integer(
    int: &Int,
    spec: &Spec,
    type_name: &str,
    ev: &Evaluator<'_>,
    out: &mut String,
) -> R<()> {
    let kind = spec.kind.unwrap_or('d');
    if let (Int::Small(small), 'd', None, None) = (int, kind, spec.grouping, spec.precision) {
        let start = out.len();
        let sign = sign_of(*small < 0, spec);
        out.push_str(sign);
        push_digits(small.unsigned_abs(), 1, out);
        return fill_up(start, sign.len(), spec, ev, out);
    }
    if "eEfFgG%".contains(kind) {
        return real(ev.int_to_f64(int)?, spec, type_name, ev, out);
    }
    if !"bcdnoxX".contains(kind) {
        return Err(unknown_kind(ev, kind, type_name));
    }
    if spec.precision.is_some() {
        return Err(ev.value_error("Precision not allowed in integer format specifier"));
    }
    let (prefix, digits) = match kind {
        'd' | 'n' => ("", decimal_digits(int, ev)?),
        'b' => ("0b", radix_digits(int, 'b', ev)?),
        'o' => ("0o", radix_digits(int, 'o', ev)?),
        'x' => ("0x", radix_digits(int, 'x', ev)?),
        'X' => ("0X", radix_digits(int, 'X', ev)?),
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
    grouped_number(
        &sign,
        (&digits, &FloatText::default()),
        every,
        spec,
        ev,
        out,
    )
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
        Int::Small(code) => u32::try_from(*code)
            .ok()
            .and_then(elite_syntax::surrogate::char_of),
        Int::Big(_) => {
            return Err(ev.raise(
                crate::errors::ExceptionKind::OverflowError,
                "Python int too large to convert to C long",
            ));
        }
    };
    let Some(c) = code else {
        return Err(ev.raise(
            crate::errors::ExceptionKind::OverflowError,
            "%c arg not in range(0x110000)",
        ));
    };
    pad("", &c.to_string(), spec.align.unwrap_or('>'), spec, ev, out)
}

/// The digits of the magnitude in decimal.
fn decimal_digits(int: &Int, ev: &Evaluator<'_>) -> R<String> {
    Ok(match int {
        Int::Small(small) => small.unsigned_abs().to_string(),
        Int::Big(big) => ev.big_to_text(big)?.trim_start_matches('-').to_owned(),
    })
}

/// The digits of the magnitude in the radix of `b`, `o`, `x` or `X`.
fn radix_digits(int: &Int, kind: char, ev: &Evaluator<'_>) -> R<String> {
    let big = match (int, kind) {
        (Int::Small(small), 'b') => return Ok(format!("{:b}", small.unsigned_abs())),
        (Int::Small(small), 'o') => return Ok(format!("{:o}", small.unsigned_abs())),
        (Int::Small(small), 'x') => return Ok(format!("{:x}", small.unsigned_abs())),
        (Int::Small(small), _) => return Ok(format!("{:X}", small.unsigned_abs())),
        (Int::Big(big), _) => big,
    };
    let (bits, digits) = match kind {
        'b' => (1, b"01".as_slice()),
        'o' => (3, b"01234567".as_slice()),
        'x' => (4, b"0123456789abcdef".as_slice()),
        _ => (4, b"0123456789ABCDEF".as_slice()),
    };
    let words = big.magnitude().to_u64_digits();
    let count = big.magnitude().bits().div_ceil(bits);
    let mut out = String::new();
    ev.grow(&mut out, count as usize)?;
    for index in (0..count).rev() {
        let (word, shift) = ((index * bits / 64) as usize, index * bits % 64);
        let low = words.get(word).map_or(0, |word| word >> shift);
        // A digit of three bits may lie in two words.
        let high = match shift + bits > 64 {
            true => words.get(word + 1).map_or(0, |word| word << (64 - shift)),
            false => 0,
        };
        let digit = (low | high) & ((1 << bits) - 1);
        out.push(char::from(digits[digit as usize]));
        ev.charge(WORK_PER_BYTE)?;
    }
    Ok(out)
}

/// An integer in the radix of `b`, `o` or `x` with sign and prefix, for `bin`, `oct`, `hex`.
pub fn prefixed(int: &Int, kind: char, prefix: &str, ev: &Evaluator<'_>) -> R<String> {
    let sign = if int.is_negative() { "-" } else { "" };
    let mut out = format!("{sign}{prefix}");
    ev.push_text(&mut out, &radix_digits(int, kind, ev)?)?;
    Ok(out)
}

pub(super) fn sign_of(negative: bool, spec: &Spec) -> &'static str {
    match (negative, spec.sign) {
        (true, _) => "-",
        (false, '+') => "+",
        (false, ' ') => " ",
        _ => "",
    }
}

pub(super) fn real(
    value: f64,
    spec: &Spec,
    type_name: &str,
    ev: &Evaluator<'_>,
    out: &mut String,
) -> R<()> {
    if spec.grouping.is_none() && !spec.no_negative_zero {
        let start = out.len();
        let sign = sign_of(value.is_sign_negative() && !value.is_nan(), spec);
        out.push_str(sign);
        match (spec.kind, spec.precision) {
            (Some('f'), precision) => {
                let precision = precision.unwrap_or(6);
                let zeros = float::push_fixed(value.abs(), precision, spec.alternate, out);
                ev.push_repeated(out, "0", zeros)?;
            }
            (None, None) => float::push_repr(value.abs(), out),
            _ => {
                push_digits_of(&real_body(value.abs(), spec, type_name, ev)?, ev, out)?;
            }
        }
        return fill_up(start, sign.len(), spec, ev, out);
    }
    let body = real_body(value.abs(), spec, type_name, ev)?;
    let mut negative = value.is_sign_negative() && !value.is_nan();
    if spec.no_negative_zero
        && value.is_finite()
        && !body.head.contains(|c: char| ('1'..='9').contains(&c))
    {
        negative = false;
    }
    let head = &body.head;
    let (digits, fraction) = head.split_at(head.find(['.', 'e', 'E']).unwrap_or(head.len()));
    let finite = value.is_finite();
    let spec_without_grouping = Spec {
        grouping: None,
        ..spec.clone()
    };
    let spec = if finite { spec } else { &spec_without_grouping };
    grouped_number(
        sign_of(negative, spec),
        (
            digits,
            &FloatText {
                head: fraction.to_owned(),
                zeros: body.zeros,
                tail: body.tail.clone(),
            },
        ),
        3,
        spec,
        ev,
        out,
    )
}

fn push_digits_of(digits: &FloatText, ev: &Evaluator<'_>, out: &mut String) -> R<()> {
    out.push_str(&digits.head);
    ev.push_repeated(out, "0", digits.zeros)?;
    out.push_str(&digits.tail);
    Ok(())
}

/// The digits of a non-negative float as the specification wants them.
fn real_body(value: f64, spec: &Spec, type_name: &str, ev: &Evaluator<'_>) -> R<FloatText> {
    let precision = spec.precision.unwrap_or(6);
    let alternate = spec.alternate;
    Ok(match spec.kind {
        None => match spec.precision {
            None => FloatText {
                head: float::repr(value),
                ..FloatText::default()
            },
            Some(precision) => float::general(value, precision.max(1), alternate, true),
        },
        Some('f') => float::format_fixed(value, precision, alternate),
        Some('F') => float::format_fixed(value, precision, alternate).to_uppercase(),
        Some('e') => float::exponent(value, precision, alternate),
        Some('E') => float::exponent(value, precision, alternate).to_uppercase(),
        Some('g' | 'n') => float::general(value, precision.max(1), alternate, false),
        Some('G') => float::general(value, precision.max(1), alternate, false).to_uppercase(),
        Some('%') => FloatText {
            tail: "%".to_owned(),
            ..float::format_fixed(value * 100.0, precision, alternate)
        },
        Some(kind) => return Err(unknown_kind(ev, kind, type_name)),
    })
}

pub(super) fn complex(
    (re, im): (f64, f64),
    spec: &Spec,
    type_name: &str,
    ev: &Evaluator<'_>,
    out: &mut String,
) -> R<()> {
    if spec.align == Some('=') && spec.fill != '0' {
        let text = "'=' alignment flag is not allowed in complex format specifier";
        return Err(ev.value_error(text));
    }
    if let Some(kind) = spec.kind.filter(|kind| !"eEfFgGn".contains(*kind)) {
        return Err(unknown_kind(ev, kind, type_name));
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
        real(value, &spec, type_name, ev, &mut text)?;
        // Without a type, whole parts are written without a point.
        if spec.kind.is_none() && text.ends_with(".0") {
            text.truncate(text.len() - 2);
        }
        Ok(text)
    };
    let only_imaginary = spec.kind.is_none() && re == 0.0 && re.is_sign_positive();
    let in_parentheses = spec.kind.is_none() && !only_imaginary;
    let mut text = String::from(if in_parentheses { "(" } else { "" });
    if only_imaginary {
        ev.push_text(&mut text, &part(im, spec.sign)?)?;
    } else {
        ev.push_text(&mut text, &part(re, spec.sign)?)?;
        ev.push_text(&mut text, &part(im, '+')?)?;
    }
    text.push_str(if in_parentheses { "j)" } else { "j" });
    pad("", &text, spec.align.unwrap_or('>'), spec, ev, out)
}

/// Appends sign, digits (grouped) and the rest, padded to the width.
fn grouped_number(
    sign: &str,
    (digits, rest): (&str, &FloatText),
    every: usize,
    spec: &Spec,
    ev: &Evaluator<'_>,
    out: &mut String,
) -> R<()> {
    let start = out.len();
    out.push_str(sign);
    match spec.grouping {
        None => ev.push_text(out, digits)?,
        Some(separator) => {
            let mut count = digits.len();
            if spec.align.unwrap_or('>') == '=' && spec.fill == '0' {
                // Zeros that fill the width are grouped, too.
                let behind = rest.head.len() + rest.zeros + rest.tail.len();
                let wanted = spec.width.saturating_sub(sign.len() + behind);
                count = count.max(wanted / (every + 1) * every);
                while grouped_length(count, every) < wanted {
                    count += 1;
                }
            }
            let mut zeros = String::new();
            ev.push_repeated(&mut zeros, "0", count - digits.len())?;
            let all = zeros.chars().chain(digits.chars());
            push_grouped(all, count, (separator, every), ev, out)?;
        }
    }
    push_digits_of(rest, ev, out)?;
    fill_up(start, sign.len(), spec, ev, out)
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
fn fill_up(start: usize, sign: usize, spec: &Spec, ev: &Evaluator<'_>, out: &mut String) -> R<()> {
    if spec.width == 0 {
        return Ok(());
    }
    let missing = spec.width.saturating_sub(ev.count_chars(&out[start..])?);
    if missing == 0 {
        return Ok(());
    }
    let mut buffer = [0; 4];
    let fill = &*spec.fill.encode_utf8(&mut buffer);
    let (at, before, after) = match spec.align.unwrap_or('>') {
        '<' => (out.len(), 0, missing),
        '=' => (start + sign, missing, 0),
        '^' => (start, missing / 2, missing - missing / 2),
        _ => (start, missing, 0),
    };
    let mut number = String::new();
    ev.push_text(&mut number, &out[at..])?;
    out.truncate(at);
    ev.push_repeated(out, fill, before)?;
    ev.push_text(out, &number)?;
    ev.push_repeated(out, fill, after)
}

fn grouped_length(digits: usize, every: usize) -> usize {
    digits + digits.saturating_sub(1) / every
}

/// Appends so many digits with a separator between groups of so many.
fn push_grouped(
    digits: impl Iterator<Item = char>,
    count: usize,
    (separator, every): (char, usize),
    ev: &Evaluator<'_>,
    out: &mut String,
) -> R<()> {
    ev.grow(out, grouped_length(count, every))?;
    for (index, c) in digits.enumerate() {
        if index > 0 && (count - index).is_multiple_of(every) {
            out.push(separator);
        }
        out.push(c);
        ev.charge(WORK_PER_BYTE)?;
    }
    Ok(())
}
