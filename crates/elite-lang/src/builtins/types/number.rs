//! `int`, `bool`, `float`, `complex`.

use std::rc::Rc;

use num_bigint::BigInt;

use super::{class_method, constructor, float_hex, float_text, methods};
use crate::errors::ExceptionKind;
use crate::eval::{Evaluator, InterpreterState};
use crate::limits::chunked::{CHUNK, WORK_PER_BYTE, pieces};
use crate::value::int::{Int, from_f64};
use crate::value::symbol::known;
use crate::value::{Bytes, R, Symbol, Unwind, Value};

/// Most characters that an error message shows of a text that is no integer.
const SHOWN: usize = 200;

pub(super) fn install(core: &Rc<InterpreterState>) {
    let types = &core.types;
    constructor(core, &types.int, "x? / base?", int);
    constructor(core, &types.bool, "x? /", |ev, args| {
        match args[0].if_given() {
            None => Ok(Value::Bool(false)),
            Some(value) => ev.truth(value).map(Value::Bool),
        }
    });
    constructor(core, &types.float, "x? /", float);
    constructor(core, &types.complex, "real? imag?", complex);
    methods(
        core,
        &types.int,
        &[
            ("bit_length", "", |ev, args| {
                Ok(Value::Int(ev.to_int(&args[0])?.bits() as i64))
            }),
            ("bit_count", "", |ev, args| {
                let ones: u64 = ev
                    .to_int(&args[0])?
                    .to_big()
                    .iter_u64_digits()
                    .map(|d| u64::from(d.count_ones()))
                    .sum();
                Ok(Value::Int(ones as i64))
            }),
            ("conjugate", "", |ev, args| {
                ev.to_int(&args[0]).map(Int::into_value)
            }),
            ("__floor__", "", |ev, args| {
                ev.to_int(&args[0]).map(Int::into_value)
            }),
            ("__ceil__", "", |ev, args| {
                ev.to_int(&args[0]).map(Int::into_value)
            }),
            ("as_integer_ratio", "", |ev, args| {
                Ok(Value::tuple(vec![
                    ev.to_int(&args[0])?.into_value(),
                    Value::Int(1),
                ]))
            }),
            ("to_bytes", "length? byteorder? * signed?", to_bytes),
        ],
    );
    class_method(
        core,
        &types.int,
        "from_bytes",
        "bytes byteorder? * signed?",
        from_bytes,
    );
    methods(
        core,
        &types.float,
        &[
            ("is_integer", "", |ev, args| {
                let float = ev.to_f64(&args[0])?;
                Ok(Value::Bool(float.is_finite() && float.fract() == 0.0))
            }),
            ("conjugate", "", |ev, args| {
                ev.to_f64(&args[0]).map(Value::Float)
            }),
            ("hex", "", |ev, args| {
                Ok(Value::str(float_hex::written(ev.to_f64(&args[0])?)))
            }),
            ("as_integer_ratio", "", float_ratio),
            ("__floor__", "", |ev, args| {
                ev.int_of(&Value::Float(ev.to_f64(&args[0])?.floor()))
            }),
            ("__ceil__", "", |ev, args| {
                ev.int_of(&Value::Float(ev.to_f64(&args[0])?.ceil()))
            }),
        ],
    );
    class_method(core, &types.float, "fromhex", "string /", |ev, args| {
        let Value::Str(text) = ev.unwrap_builtin(&args[1]) else {
            return Err(ev.type_error("bad argument type for built-in operation"));
        };
        match float_hex::read(ev, text.as_str())? {
            Some(float) if float.is_infinite() && !text.as_str().contains(['i', 'I']) => {
                let text = "hexadecimal value too large to represent as a float";
                Err(ev.raise(ExceptionKind::OverflowError, text))
            }
            Some(float) => ev.of_class(&args[0], Value::Float(float)),
            None => Err(ev.value_error("invalid hexadecimal floating-point string")),
        }
    });
    methods(
        core,
        &types.complex,
        &[("conjugate", "", |ev, args| {
            match ev.unwrap_builtin(&args[0]) {
                Value::Complex(complex) => Ok(Value::complex(complex.0, -complex.1)),
                other => Ok(other),
            }
        })],
    );
}

impl Evaluator<'_> {
    /// Python's `int(value)` for anything but text.
    pub fn int_of(&self, value: &Value) -> R {
        match value {
            Value::Int(_) | Value::BigInt(_) => Ok(value.clone()),
            Value::Bool(flag) => Ok(Value::Int(i64::from(*flag))),
            Value::Float(float) => {
                if float.is_nan() {
                    return Err(self.value_error("cannot convert float NaN to integer"));
                }
                if float.is_infinite() {
                    let kind = ExceptionKind::OverflowError;
                    return Err(self.raise(kind, "cannot convert float infinity to integer"));
                }
                Ok(from_f64(*float))
            }
            Value::Instance(instance) => {
                for method in [known::INT, known::INDEX, known::TRUNC] {
                    if instance.class.lookup(method).is_none() {
                        continue;
                    }
                    let result = self.special(value, method, &mut [])?.unwrap_or_default();
                    return match Int::of(&self.unwrap_builtin(&result)) {
                        Some(int) => Ok(int.into_value()),
                        None if method == known::TRUNC && self.has_index(&result) => {
                            self.to_int(&result).map(Int::into_value)
                        }
                        None if method == known::TRUNC => {
                            let name = self.core.types.name_of(&result);
                            let text = format!("__trunc__ returned non-Integral (type {name})");
                            Err(self.type_error(text))
                        }
                        None => {
                            let (method, name) = (
                                self.core.symbols.name(method),
                                self.core.types.name_of(&result),
                            );
                            Err(self.type_error(format!("{method} returned non-int (type {name})")))
                        }
                    };
                }
                Err(self.not_a_number(
                    "int()",
                    "a string, a bytes-like object or a real number",
                    value,
                ))
            }
            _ => Err(self.not_a_number(
                "int()",
                "a string, a bytes-like object or a real number",
                value,
            )),
        }
    }

    fn not_a_number(&self, function: &str, wanted: &str, value: &Value) -> crate::value::Unwind {
        let name = self.core.types.name_of(value);
        self.type_error(format!(
            "{function} argument must be {wanted}, not '{name}'"
        ))
    }
}

/// `int(value)`
pub fn int_from(ev: &Evaluator<'_>, value: &Value) -> R {
    int(ev, &mut [value.clone(), Value::Unbound])
}

fn int(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let base = args[1].if_given();
    let Some(value) = args[0].if_given() else {
        return match base {
            None => Ok(Value::Int(0)),
            Some(_) => Err(ev.type_error("int() missing string argument")),
        };
    };
    let base = match base {
        Some(given) => {
            let number = ev.clamped_index(given)?;
            if number != 0 && !(2..=36).contains(&number) {
                return Err(ev.value_error("int() base must be >= 2 and <= 36, or 0"));
            }
            Some(number)
        }
        None => None,
    };
    let text = match value {
        Value::Str(text) => numeral(ev, text.as_str())?,
        value if base.is_none() && has_own(value, &[known::INT, known::INDEX, known::TRUNC]) => {
            return ev.int_of(value);
        }
        other => match ev.unwrap_builtin(other) {
            Value::Str(text) => numeral(ev, text.as_str())?,
            plain => match ev.bytes_like(&plain) {
                Some(data) => numeral(ev, &ev.decode_latin1(&data)?)?,
                None if base.is_some() => {
                    return Err(ev.type_error("int() can't convert non-string with explicit base"));
                }
                None => return ev.int_of(value),
            },
        },
    };
    let base = base.unwrap_or(10);
    match parse_int(ev, &text, base as u32)? {
        Some(int) => Ok(int),
        None => {
            let mut shown = match ev.bytes_like(value) {
                Some(data) => ev.repr(&Value::bytes(data[..data.len().min(SHOWN)].to_vec()))?,
                None => ev.repr(value)?,
            };
            if let Some((end, _)) = shown.char_indices().nth(SHOWN) {
                shown.truncate(end);
            }
            Err(ev.value_error(format!(
                "invalid literal for int() with base {base}: {shown}"
            )))
        }
    }
}

/// Whether the class of a value has one of these methods from a script: that comes before the text or number that it
/// extends.
fn has_own(value: &Value, names: &[Symbol]) -> bool {
    let Value::Instance(instance) = value else {
        return false;
    };
    let own = |name: Symbol| matches!(instance.class.lookup(name), Some(Value::Function(_)));
    names.iter().any(|name| own(*name))
}

/// A text without the blanks around it.
fn numeral(ev: &Evaluator<'_>, text: &str) -> R<String> {
    let text = &text[ev.prefix_len(text, char::is_whitespace)?..];
    let text = &text[..text.len() - ev.suffix_len(text, char::is_whitespace)?];
    let mut copy = String::new();
    ev.push_text(&mut copy, text)?;
    Ok(copy)
}

/// Refuses what has more digits than any integer may have, before anything looks at all of them at once.
fn check_digits(ev: &Evaluator<'_>, text: &str, base: u32) -> R<bool> {
    let mut digits = 0;
    for piece in pieces(text) {
        if !piece
            .chars()
            .all(|c| c.is_alphanumeric() || "+-_".contains(c))
        {
            return Ok(false);
        }
        digits += piece.chars().filter(|c| c.is_alphanumeric()).count();
        ev.charge(piece.len() * WORK_PER_BYTE)?;
    }
    match base {
        0 | 2 | 4 | 8 | 16 | 32 => ev.check_bits(digits as u64).map(|()| true),
        _ => check_decimal(ev, digits).map(|()| true),
    }
}

fn check_decimal(ev: &Evaluator<'_>, digits: usize) -> R<()> {
    let limit = ev.core.limits.int_digits;
    if digits <= limit {
        return Ok(());
    }
    Err(ev.value_error(format!(
        "Exceeds the limit ({limit} digits) for integer string conversion: value has {digits} digits; \
         use sys.set_int_max_str_digits() to increase the limit"
    )))
}

/// An integer in text; None if it is none.
fn parse_int(ev: &Evaluator<'_>, text: &str, base: u32) -> R<Option<Value>> {
    let trimmed = text.trim();
    // The commonest: few digits, which always fit.
    if base == 10 && trimmed.len() <= 18 && trimmed.bytes().all(|byte| byte.is_ascii_digit()) {
        return Ok(trimmed.parse().ok().map(Value::Int));
    }
    if trimmed.len() > CHUNK && !check_digits(ev, trimmed, base)? {
        return Ok(None);
    }
    let (negative, digits) = match trimmed.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, trimmed.strip_prefix('+').unwrap_or(trimmed)),
    };
    let prefix = digits.get(..2).unwrap_or("").to_ascii_lowercase();
    let prefix_base = match &*prefix {
        "0x" => 16,
        "0o" => 8,
        "0b" => 2,
        _ => 0,
    };
    let automatic = base == 0;
    let has_prefix = prefix_base != 0 && (base == prefix_base || base == 0);
    let (base, digits) = match (base, has_prefix) {
        (_, true) => (
            prefix_base,
            digits[2..].strip_prefix('_').unwrap_or(&digits[2..]),
        ),
        (0, false) => (10, digits),
        (base, false) => (base, digits),
    };
    let grouped = digits.starts_with('_') || digits.ends_with('_') || digits.contains("__");
    if digits.is_empty() || grouped {
        return Ok(None);
    }
    let digits: String = digits
        .chars()
        .filter(|c| *c != '_')
        .map(to_ascii_digit)
        .collect();
    if !digits.chars().all(|c| c.is_digit(base)) {
        return Ok(None);
    }
    // With base 0 the text must be a literal: no leading zeros.
    let zero_padded =
        digits.len() > 1 && digits.starts_with('0') && digits.bytes().any(|byte| byte != b'0');
    if automatic && zero_padded && !has_prefix {
        return Ok(None);
    }
    if let Ok(small) = i64::from_str_radix(&digits, base) {
        return Ok(Some(Value::Int(if negative { -small } else { small })));
    }
    if !base.is_power_of_two() {
        check_decimal(ev, digits.len())?;
    }
    ev.check_bits(digits.len() as u64 * 6)?;
    let big = BigInt::parse_bytes(digits.as_bytes(), base);
    Ok(big.map(|big| Value::bigint(if negative { -big } else { big })))
}

/// Decimal digits of other scripts count as digits, as in Python.
pub(super) fn to_ascii_digit(c: char) -> char {
    crate::ops::unicode::decimal(c)
        .and_then(|digit| char::from_digit(digit, 10))
        .unwrap_or(c)
}

/// Whether an object has a method that is asked for a float, whose refusal is its own.
fn gives_number(value: &Value) -> bool {
    matches!(value, Value::Instance(instance)
        if instance.class.lookup(known::FLOAT).is_some()
            || instance.class.lookup(known::INDEX).is_some())
}

fn float(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let Some(value) = args[0].if_given() else {
        return Ok(Value::Float(0.0));
    };
    if has_own(value, &[known::FLOAT, known::INDEX]) {
        return ev.converted_f64(value).map(Value::Float);
    }
    let text = match ev.unwrap_builtin(value) {
        Value::Str(text) => numeral(ev, text.as_str())?,
        plain => match ev.bytes_like(&plain) {
            Some(data) => numeral(ev, &ev.decode_latin1(&data)?)?,
            None => {
                return ev.to_f64(value).map(Value::Float).map_err(|raised| {
                    if ev.is_kind(&raised, ExceptionKind::TypeError) && !gives_number(value) {
                        return ev.not_a_number("float()", "a string or a real number", value);
                    }
                    raised
                });
            }
        },
    };
    match float_text::float(ev, &text)? {
        Some(float) => Ok(Value::Float(float)),
        None => Err(ev.value_error(format!(
            "could not convert string to float: {}",
            ev.repr(value)?
        ))),
    }
}

/// Whether there is a `_` in a numeral that is not between two digits.
fn has_loose_underscore(ev: &Evaluator<'_>, text: &str) -> R<bool> {
    let mut before = b' ';
    let found = ev.position(text.as_bytes(), |byte| {
        let is_loose =
            byte == b'_' && !before.is_ascii_digit() || before == b'_' && !byte.is_ascii_digit();
        before = byte;
        is_loose
    })?;
    Ok(found.is_some() || before == b'_')
}

fn complex(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let text_of = |value: &Value| match ev.unwrap_builtin(value) {
        Value::Str(text) => Some(text),
        _ => None,
    };
    if let Some(text) = args[0].if_given().and_then(text_of) {
        if args[1].if_given().is_some() {
            return Err(ev.type_error("complex() can't take second arg if first is a string"));
        }
        let written = numeral(ev, text.as_str())?;
        if let Some((re, im)) = float_text::complex(ev, &written)? {
            return Ok(Value::complex(re, im));
        }
        if has_loose_underscore(ev, &written)? {
            let shown = ev.repr(&args[0])?;
            let text = format!("could not convert string to complex: {shown}");
            return Err(ev.value_error(text));
        }
        return Err(ev.value_error("complex() arg is a malformed string"));
    }
    if args[1].if_given().and_then(text_of).is_some() {
        return Err(ev.type_error("complex() second arg can't be a string"));
    }
    let part = |value: &Value, wanted: &str| -> R<(f64, Option<f64>)> {
        let is_second = wanted.starts_with("second");
        match value {
            Value::Unbound => Ok((0.0, None)),
            Value::Complex(complex) => Ok((complex.0, Some(complex.1))),
            // Only the first one is asked to become a complex number.
            Value::Instance(instance)
                if is_second && let Some(Value::Complex(complex)) = instance.builtin_value() =>
            {
                Ok((complex.0, Some(complex.1)))
            }
            Value::Instance(instance)
                if !is_second && instance.class.lookup(known::COMPLEX).is_some() =>
            {
                let made = ev
                    .special(value, known::COMPLEX, &mut [])?
                    .unwrap_or_default();
                match ev.unwrap_builtin(&made) {
                    Value::Complex(complex) => Ok((complex.0, Some(complex.1))),
                    _ => {
                        let name = ev.core.types.name_of(&made);
                        Err(ev
                            .type_error(format!("__complex__ returned non-complex (type {name})")))
                    }
                }
            }
            other => ev
                .converted_f64(other)
                .map(|re| (re, None))
                .map_err(|raised| {
                    if ev.is_kind(&raised, ExceptionKind::TypeError) && !gives_number(other) {
                        let name = ev.core.types.name_of(other);
                        return ev.type_error(format!("complex() {wanted}, not '{name}'"));
                    }
                    raised
                }),
        }
    };
    let a = part(&args[0], "first argument must be a string or a number")?;
    let b = part(&args[1], "second argument must be a number")?;
    // Parts that are no complex numbers are taken as they are: adding a zero would lose the sign of another.
    let real = b.1.map_or(a.0, |imaginary| a.0 - imaginary);
    let imaginary = a.1.map_or(b.0, |imaginary| imaginary + b.0);
    Ok(Value::complex(real, imaginary))
}

/// The argument `byteorder` of a method, which must be a text: whether the high byte comes first, None if it says
/// neither.
fn byte_order(ev: &Evaluator<'_>, value: &Value, method: &str) -> R<Option<bool>> {
    if value.is_unbound() {
        return Ok(Some(true));
    }
    match ev.unwrap_builtin(value) {
        Value::Str(text) => Ok(match text.as_str() {
            "big" => Some(true),
            "little" => Some(false),
            _ => None,
        }),
        _ => {
            let name = ev.core.types.name_of_argument(value);
            Err(ev.type_error(format!(
                "{method}() argument 'byteorder' must be str, not {name}"
            )))
        }
    }
}

#[cold]
fn no_byte_order(ev: &Evaluator<'_>) -> Unwind {
    ev.value_error("byteorder must be either 'little' or 'big'")
}

fn to_bytes(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let int = ev.to_int(&args[0])?;
    let length = match args[1].if_given() {
        Some(length) => ev.index(length)?,
        None => 1,
    };
    let big_endian = byte_order(ev, &args[2], "to_bytes")?;
    let signed = args[3]
        .if_given()
        .map_or(Ok(false), |value| ev.truth(value))?;
    let big_endian = big_endian.ok_or_else(|| no_byte_order(ev))?;
    let length = usize::try_from(length)
        .map_err(|_| ev.value_error("length argument must be non-negative"))?;
    ev.check_allocation(length)?;
    if int.is_negative() && !signed {
        return Err(ev.raise(
            ExceptionKind::OverflowError,
            "can't convert negative int to unsigned",
        ));
    }
    let big = int.to_big();
    let mut data = if signed {
        big.to_signed_bytes_le()
    } else {
        big.magnitude().to_bytes_le()
    };
    let filler = if int.is_negative() { 0xff } else { 0 };
    while data.len() > length
        && data.last() == Some(&filler)
        && (!signed || fits_without(&data, filler))
    {
        data.pop();
    }
    if data.len() > length {
        return Err(ev.raise(ExceptionKind::OverflowError, "int too big to convert"));
    }
    data.resize(length, filler);
    if big_endian {
        data.reverse();
    }
    Ok(Value::Bytes(Rc::new(Bytes::new(data))))
}

/// Whether the last byte of a signed number can go: the sign stays in the byte before it.
fn fits_without(data: &[u8], filler: u8) -> bool {
    data.len() < 2 || (data[data.len() - 2] & 0x80 != 0) == (filler == 0xff)
}

fn from_bytes(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let big_endian = byte_order(ev, &args[2], "from_bytes")?;
    let signed = args[3]
        .if_given()
        .map_or(Ok(false), |value| ev.truth(value))?;
    let big_endian = big_endian.ok_or_else(|| no_byte_order(ev))?;
    let mut data = super::bytes::of_object(ev, &args[1], "bytes")?;
    if !big_endian {
        data.reverse();
    }
    let mut zeros = 0;
    for piece in data.chunks(CHUNK) {
        let some = piece.iter().take_while(|byte| **byte == 0).count();
        zeros += some;
        if some < piece.len() {
            break;
        }
        ev.charge(piece.len() * WORK_PER_BYTE)?;
    }
    // The sign is in the first byte of all.
    let data = &data[zeros.saturating_sub(1)..];
    ev.check_bits(data.len() as u64 * 8)?;
    let big = if signed {
        BigInt::from_signed_bytes_be(data)
    } else {
        BigInt::from_bytes_be(num_bigint::Sign::Plus, data)
    };
    ev.of_class(&args[0], Value::bigint(big))
}

fn float_ratio(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let float = ev.to_f64(&args[0])?;
    if !float.is_finite() {
        let what = if float.is_nan() { "NaN" } else { "Infinity" };
        let text = format!("cannot convert {what} to integer ratio");
        return Err(if float.is_nan() {
            ev.value_error(text)
        } else {
            ev.raise(ExceptionKind::OverflowError, text)
        });
    }
    let (mut mantissa, mut exponent) = crate::ops::hash::frexp(float);
    for _ in 0..300 {
        if mantissa.fract() == 0.0 {
            break;
        }
        mantissa *= 2.0;
        exponent -= 1;
    }
    let numerator = BigInt::from(mantissa as i64);
    let power = BigInt::from(1) << exponent.unsigned_abs();
    let (numerator, denominator) = if exponent > 0 {
        (numerator * power, BigInt::from(1))
    } else {
        (numerator, power)
    };
    Ok(Value::tuple(vec![
        Value::bigint(numerator),
        Value::bigint(denominator),
    ]))
}
