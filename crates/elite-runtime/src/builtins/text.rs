//! Manual 9.4: string functions.
//!
//! Positions count characters, from 0; only `str_len` counts bytes (UTF-8), as its section says. For ASCII text, all
//! the manual shows, both are the same.

use elite_lang::{ExceptionKind, Letters, Unwind, Value};
use messages::text;

use super::call::Call;
use super::declare::{
    Builtin, Category, Parameter, ParameterDefault, ParameterType, Phrase, phrase,
};
use crate::value_text::compact_text;

/// Longest text that `str_cat` and `to_str` return, characters (manual 9.4.2, 9.4.8).
const CHARS_MAX: usize = 1023;

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    function(
        "str_at",
        "9.4.1",
        phrase("The character at a position.", "某一位置的字符。"),
        &[
            SRC,
            required(
                "index",
                ParameterType::Integer(i64::MIN, i64::MAX),
                phrase("position, from 0", "位置，从 0 开始"),
            ),
        ],
        phrase("str", "str"),
        str_at,
    ),
    function(
        "str_cat",
        "9.4.2",
        phrase(
            "Both values as text, joined; floats with six decimals, zeros at the end removed.",
            "把两个值作为文本连接；浮点数保留六位小数并去掉末尾的零。",
        ),
        &[
            required(
                "object1",
                ParameterType::Printable,
                phrase("first value", "第一个值"),
            ),
            required(
                "object2",
                ParameterType::Printable,
                phrase("second value", "第二个值"),
            ),
        ],
        phrase("str, at most 1023 characters", "str，最多 1023 个字符"),
        str_cat,
    ),
    function(
        "str_empty",
        "9.4.3",
        phrase("Whether a text is empty.", "文本是否为空。"),
        &[required(
            "str",
            ParameterType::Text,
            phrase("the text", "文本"),
        )],
        phrase("bool", "bool"),
        str_empty,
    ),
    function(
        "str_find",
        "9.4.4",
        phrase(
            "Where a text begins in another one.",
            "一段文本在另一段中的起始位置。",
        ),
        &[
            SRC,
            required(
                "target",
                ParameterType::Text,
                phrase("what to look for", "要查找的内容"),
            ),
            Parameter {
                default: ParameterDefault::Number(0.0),
                ..required(
                    "start_from",
                    ParameterType::Integer(0, i64::MAX),
                    phrase("first position to look at", "开始查找的位置"),
                )
            },
        ],
        phrase("int, -1 when it is not there", "int，没有则为 -1"),
        str_find,
    ),
    function(
        "str_len",
        "9.4.5",
        phrase("Length of a text in bytes.", "文本的字节长度。"),
        &[required(
            "str",
            ParameterType::Text,
            phrase("the text", "文本"),
        )],
        phrase("int", "int"),
        str_len,
    ),
    function(
        "str_sub",
        "9.4.6",
        phrase("A part of a text.", "文本的一部分。"),
        &[
            SRC,
            required(
                "index",
                ParameterType::Integer(i64::MIN, i64::MAX),
                phrase("first position, 0 to the length", "起始位置，0 到长度"),
            ),
            Parameter {
                default: ParameterDefault::None,
                ..required(
                    "len",
                    ParameterType::Integer(0, i64::MAX),
                    phrase(
                        "how many characters; all that follow when omitted",
                        "字符数；省略时取其后全部",
                    ),
                )
            },
        ],
        phrase("str", "str"),
        str_sub,
    ),
    function(
        "to_num",
        "9.4.7",
        phrase("The number that a text stands for.", "文本表示的数。"),
        &[required(
            "str",
            ParameterType::Text,
            phrase(
                "decimal, hexadecimal (0x), exponent form, inf, nan",
                "十进制、十六进制（0x）、指数形式、inf、nan",
            ),
        )],
        phrase(
            "int, or float with a point or an exponent",
            "int；带小数点或指数时为 float",
        ),
        to_num,
    ),
    function(
        "to_str",
        "9.4.8",
        phrase(
            "A value as text; floats with six decimals, zeros at the end removed.",
            "值的文本形式；浮点数保留六位小数并去掉末尾的零。",
        ),
        &[required(
            "val",
            ParameterType::Printable,
            phrase("the value", "值"),
        )],
        phrase("str, at most 1023 characters", "str，最多 1023 个字符"),
        to_str,
    ),
];

const SRC: Parameter = required("src", ParameterType::Text, phrase("the text", "文本"));

const fn required(name: &'static str, kind: ParameterType, meaning: Phrase) -> Parameter {
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
    summary: Phrase,
    params: &'static [Parameter],
    returns: Phrase,
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
        None if count == 0 => Err(call.error(
            ExceptionKind::ValueError,
            text!("str_at(): source string empty", "str_at()：源字符串为空"),
        )),
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
        None => Err(call.error(
            ExceptionKind::TypeError,
            text!("a string is expected", "需要字符串"),
        )),
    }
}

fn out_of_range(call: &mut Call<'_, '_>, index: i64, last: usize) -> Unwind {
    let text = text!(
        "{}(): index out of range: must be 0 to {last}, got {index}",
        "{}()：下标超出范围：必须为 0 到 {last}，给出的是 {index}",
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
        let message = text!(
            "{name}(): the result is longer than {CHARS_MAX} characters: it would have {chars}",
            "{name}()：结果超过 {CHARS_MAX} 个字符：将有 {chars} 个"
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
            let message = text!(
                "to_num(): illegal string {shown:?}: not a number",
                "to_num()：字符串 {shown:?} 不合法：不是数"
            );
            Err(call.error(ExceptionKind::ValueError, message))
        }
        Err(NumberError::TooLarge) => {
            let shown: String = text.trim().chars().take(60).collect();
            let message = text!(
                "to_num(): number too large: {shown}",
                "to_num()：数过大：{shown}"
            );
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
