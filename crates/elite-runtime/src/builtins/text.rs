//! Manual 9.4: string functions.
//!
//! Positions count characters, from 0; only `str_len` counts bytes (UTF-8), as its section says. For ASCII text, all
//! the manual shows, both are the same.

use elite_lang::{ExceptionKind, Letters, Unwind, Value};

use super::call::Call;
use super::declare::{Builtin, Category, Parameter, ParameterDefault, ParameterType};
use crate::value_text::compact_text;

/// Longest text that `str_cat` and `to_str` return, characters (manual 9.4.2, 9.4.8).
const CHARS_MAX: usize = 1023;

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    function(
        "str_at",
        "9.4.1",
        "The character at a position.",
        &[
            SRC,
            required(
                "index",
                ParameterType::Integer(i64::MIN, i64::MAX),
                "position, from 0",
            ),
        ],
        "str",
        str_at,
    ),
    function(
        "str_cat",
        "9.4.2",
        "Both values as text, joined; floats with six decimals, zeros at the end removed.",
        &[
            required("object1", ParameterType::Printable, "first value"),
            required("object2", ParameterType::Printable, "second value"),
        ],
        "str, at most 1023 characters",
        str_cat,
    ),
    function(
        "str_empty",
        "9.4.3",
        "Whether a text is empty.",
        &[required("str", ParameterType::Text, "the text")],
        "bool",
        str_empty,
    ),
    function(
        "str_find",
        "9.4.4",
        "Where a text begins in another one.",
        &[
            SRC,
            required("target", ParameterType::Text, "what to look for"),
            Parameter {
                default: ParameterDefault::Number(0.0),
                ..required(
                    "start_from",
                    ParameterType::Integer(0, i64::MAX),
                    "first position to look at",
                )
            },
        ],
        "int, -1 when it is not there",
        str_find,
    ),
    function(
        "str_len",
        "9.4.5",
        "Length of a text in bytes.",
        &[required("str", ParameterType::Text, "the text")],
        "int",
        str_len,
    ),
    function(
        "str_sub",
        "9.4.6",
        "A part of a text.",
        &[
            SRC,
            required(
                "index",
                ParameterType::Integer(i64::MIN, i64::MAX),
                "first position, 0 to the length",
            ),
            Parameter {
                default: ParameterDefault::None,
                ..required(
                    "len",
                    ParameterType::Integer(0, i64::MAX),
                    "how many characters; all that follow when omitted",
                )
            },
        ],
        "str",
        str_sub,
    ),
    function(
        "to_num",
        "9.4.7",
        "The number that a text stands for.",
        &[required(
            "str",
            ParameterType::Text,
            "decimal, hexadecimal (0x), exponent form, inf, nan",
        )],
        "int, or float with a point or an exponent",
        to_num,
    ),
    function(
        "to_str",
        "9.4.8",
        "A value as text; floats with six decimals, zeros at the end removed.",
        &[required("val", ParameterType::Printable, "the value")],
        "str, at most 1023 characters",
        to_str,
    ),
];

const SRC: Parameter = required("src", ParameterType::Text, "the text");

const fn required(name: &'static str, kind: ParameterType, meaning: &'static str) -> Parameter {
    Parameter {
        name,
        aliases: &[],
        kind,
        default: ParameterDefault::Required,
        unit: "",
        meaning,
    }
}

const fn function(
    name: &'static str,
    section: &'static str,
    summary: &'static str,
    params: &'static [Parameter],
    returns: &'static str,
    run: fn(&mut Call<'_, '_>) -> Result<Value, Unwind>,
) -> Builtin {
    Builtin {
        name,
        section,
        category: Category::Text,
        summary,
        params,
        returns,
        waits: false,
        run: Some(run),
    }
}

fn str_at(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (text, index) = (source(call)?, call.integer(1)?);
    let (count, part) = within(call, &text, |letters| {
        let at = usize::try_from(index).ok();
        let at = at.filter(|at| *at < letters.count());
        let part = at.map(|at| letters.part(at, at + 1)).transpose()?;
        Ok((letters.count(), part))
    })?;
    match part {
        Some(letter) => Ok(letter),
        None if count == 0 => {
            Err(call.error(ExceptionKind::ValueError, "str_at(): source string empty"))
        }
        None => Err(out_of_range(call, index, count - 1)),
    }
}

/// The first argument, which is a text; it is not copied.
fn source(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    match call.required(0) {
        value @ Value::Str(_) => Ok(value),
        _ => Ok(Value::str(call.text(0)?)),
    }
}

fn within<T>(
    call: &mut Call<'_, '_>,
    text: &Value,
    look: impl FnOnce(&Letters<'_>) -> Result<T, Unwind>,
) -> Result<T, Unwind> {
    match call.native().letters(text)? {
        Some(letters) => look(&letters),
        // `source` gives texts only.
        None => Err(call.error(ExceptionKind::TypeError, "a string is expected")),
    }
}

fn out_of_range(call: &mut Call<'_, '_>, index: i64, last: usize) -> Unwind {
    let text = format!(
        "{}(): index out of range: must be 0 to {last}, got {index}",
        call.name()
    );
    call.error(ExceptionKind::IndexError, text)
}

fn str_cat(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let joined = compact(call, 0)? + &compact(call, 1)?;
    bounded(call, joined)
}

fn to_str(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let text = compact(call, 0)?;
    bounded(call, text)
}

/// The argument in the form of this section; Python's own for types the manual does not name.
fn compact(call: &mut Call<'_, '_>, index: usize) -> Result<String, Unwind> {
    let value = call.required(index);
    match compact_text(&value, CHARS_MAX) {
        Some(text) => Ok(text),
        None => call.native().str(&value),
    }
}

fn bounded(call: &mut Call<'_, '_>, text: String) -> Result<Value, Unwind> {
    let chars = text.chars().count();
    if chars > CHARS_MAX {
        let name = call.name();
        let message = format!(
            "{name}(): the result is longer than {CHARS_MAX} characters: it would have {chars}"
        );
        return Err(call.error(ExceptionKind::ValueError, message));
    }
    Ok(Value::str(text))
}

fn str_empty(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    Ok(Value::Bool(call.text(0)?.is_empty()))
}

fn str_len(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    // A text in memory is shorter than i64::MAX bytes.
    Ok(Value::Int(source(call)?.as_str().map_or(0, str::len) as i64))
}

fn str_find(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (text, target) = (source(call)?, call.text(1)?);
    let start = match call.given(2) {
        None => 0,
        Some(_) => usize::try_from(call.integer(2)?).unwrap_or(usize::MAX),
    };
    within(call, &text, |letters| {
        if start > letters.count() {
            return Ok(Value::Int(-1));
        }
        let from = letters.byte_of(start);
        let found = letters.as_str()[from..].find(&target);
        Ok(Value::Int(
            found.map_or(-1, |at| letters.letter_at(from + at) as i64),
        ))
    })
}

fn str_sub(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (text, index) = (source(call)?, call.integer(1)?);
    let length = within(call, &text, |letters| Ok(letters.count()))?;
    let Some(first) = usize::try_from(index).ok().filter(|n| *n <= length) else {
        return Err(out_of_range(call, index, length));
    };
    let count = match call.given(2) {
        None | Some(Value::None) => usize::MAX,
        Some(_) => usize::try_from(call.integer(2)?).unwrap_or(usize::MAX),
    };
    within(call, &text, |letters| {
        letters.part(first, first.saturating_add(count))
    })
}

fn to_num(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let text = call.text(0)?;
    match parse_number(&text) {
        Ok(value) => Ok(value),
        Err(NumberError::Illegal) => {
            let shown: String = text.chars().take(60).collect();
            let message = format!("to_num(): illegal string {shown:?}: not a number");
            Err(call.error(ExceptionKind::ValueError, message))
        }
        Err(NumberError::TooLarge) => {
            let shown: String = text.trim().chars().take(60).collect();
            let message = format!("to_num(): number too large: {shown}");
            Err(call.error(ExceptionKind::OverflowError, message))
        }
    }
}

#[derive(Debug, PartialEq, Eq)]
enum NumberError {
    Illegal,
    /// Beyond a 64-bit integer or float (our limit; the manual's example is that of an 80-bit float).
    TooLarge,
}

/// A number as section 9.4.7 describes it: blanks around, a sign, then digits, a point or exponent, 0x, inf or nan.
fn parse_number(text: &str) -> Result<Value, NumberError> {
    let text = text
        .trim_matches([' ', '\t', '\r', '\n'])
        .to_ascii_lowercase();
    let (negative, body) = match text.as_bytes().first() {
        Some(b'-') => (true, &text[1..]),
        Some(b'+') => (false, &text[1..]),
        _ => (false, &text[..]),
    };
    let signed = |x: f64| Value::Float(if negative { -x } else { x });
    match body {
        "inf" | "infinity" => return Ok(signed(f64::INFINITY)),
        "nan" => return Ok(Value::Float(f64::NAN)),
        _ => {}
    }
    let (digits, radix) = body.strip_prefix("0x").map_or((body, 10), |hex| (hex, 16));
    if !digits.is_empty() && digits.chars().all(|c| c.is_digit(radix)) {
        let with_sign = format!("{}{digits}", if negative { "-" } else { "" });
        return i64::from_str_radix(&with_sign, radix)
            .map(Value::Int)
            .map_err(|_| NumberError::TooLarge);
    }
    let is_decimal = radix == 10
        && body.starts_with(|c: char| c.is_ascii_digit() || c == '.')
        && body
            .chars()
            .all(|c| c.is_ascii_digit() || matches!(c, '.' | 'e' | '+' | '-'));
    // Rust reads exactly digits, point and exponent; what else it would read was sorted out above.
    match body.parse::<f64>() {
        Ok(x) if is_decimal && x.is_finite() => Ok(signed(x)),
        Ok(_) if is_decimal => Err(NumberError::TooLarge),
        _ => Err(NumberError::Illegal),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn shown(text: &str) -> String {
        match parse_number(text) {
            Ok(value) => format!("{value:?}"),
            Err(error) => format!("{error:?}"),
        }
    }

    #[test]
    fn numbers_are_read_as_the_manual_says() {
        for (text, number) in [
            ("10", "10"),
            ("0xce110", "844048"),
            ("0XABC", "2748"),
            ("-0x10", "-16"),
            ("3.14", "3.14"),
            ("-2.", "-2.0"),
            (".3", "0.3"),
            ("10E1", "100.0"),
            ("1.5E4", "15000.0"),
            ("NAN", "NaN"),
            ("-Infinity", "-inf"),
            ("+INF", "inf"),
            (" \t\r\n7\n ", "7"),
            ("9223372036854775807", "9223372036854775807"),
            ("-9223372036854775808", "-9223372036854775808"),
            ("9223372036854775808", "TooLarge"),
            ("1.18973e+4932", "TooLarge"),
            ("123abc", "Illegal"),
            ("", "Illegal"),
            ("0x", "Illegal"),
            ("1e", "Illegal"),
            ("--1", "Illegal"),
            ("1 2", "Illegal"),
            ("infinit", "Illegal"),
            (".", "Illegal"),
            ("0x1.8", "Illegal"),
        ] {
            assert_eq!(shown(text), number, "{text:?}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 256, ..ProptestConfig::default() })]
        #[test]
        fn whole_numbers_come_back(n in any::<i64>()) {
            prop_assert_eq!(shown(&n.to_string()), n.to_string());
        }

        #[test]
        fn no_text_is_a_panic(text in "\\PC{0,12}") {
            let _ = parse_number(&text);
        }
    }
}
