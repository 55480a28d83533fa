//! Floats in hexadecimal: `float.hex`, `float.fromhex`.

use num_bigint::BigInt;

use crate::eval::Evaluator;
use crate::limits::chunked::WORK_PER_BYTE;
use crate::value::R;

/// Python's `float.hex()`.
pub(super) fn written(value: f64) -> String {
    if !value.is_finite() {
        return crate::format::float::repr(value);
    }
    let sign = if value.is_sign_negative() { "-" } else { "" };
    let bits = value.to_bits();
    let mantissa = bits & ((1 << 52) - 1);
    let exponent = ((bits >> 52) & 0x7ff) as i32;
    match (exponent, mantissa) {
        (0, 0) => format!("{sign}0x0.0p+0"),
        (0, _) => format!("{sign}0x0.{mantissa:013x}p-1022"),
        _ => format!("{sign}0x1.{mantissa:013x}p{:+}", exponent - 1023),
    }
}

/// `mantissa` times two to `exponent`, rounded to the nearest float, halves to even.
fn rounded(mantissa: &BigInt, exponent: i64) -> f64 {
    let bits = mantissa.bits() as i64;
    // Bits that do not fit a float at this size; below the normal range there are fewer.
    let excess = (bits - 53).max(-1074 - exponent);
    if excess <= 0 {
        let small = u64::try_from(mantissa).unwrap_or(u64::MAX) as f64;
        // Both factors are exact: the exponent is at least -1074 here.
        return small
            * 2f64.powi((exponent / 2) as i32)
            * 2f64.powi((exponent - exponent / 2) as i32);
    }
    let kept = mantissa >> excess;
    let rest: BigInt = mantissa - (&kept << excess);
    let half = BigInt::from(1) << (excess - 1);
    let up = rest > half || (rest == half && kept.bit(0));
    let kept = u64::try_from(&kept).unwrap_or(u64::MAX) + u64::from(up);
    let exponent = exponent + excess;
    kept as f64 * 2f64.powi((exponent / 2) as i32) * 2f64.powi((exponent - exponent / 2) as i32)
}

/// A float in hexadecimal: `[sign][0x]digits[.digits][p[sign]exponent]`, rounded once.
pub(super) fn read(ev: &Evaluator<'_>, text: &str) -> R<Option<f64>> {
    // Byte by byte, because a text may be as long as the memory of its task, and a stop has to reach this.
    let is_blank = |byte: &u8| matches!(byte, b' ' | b'\t'..=b'\r');
    let mut body = text.as_bytes();
    while let Some((_, rest)) = body.split_first().filter(|(first, _)| is_blank(first)) {
        ev.charge(WORK_PER_BYTE)?;
        body = rest;
    }
    while let Some((_, rest)) = body.split_last().filter(|(last, _)| is_blank(last)) {
        ev.charge(WORK_PER_BYTE)?;
        body = rest;
    }
    let is_negative = body.first() == Some(&b'-');
    let body = match body {
        [b'-' | b'+', rest @ ..] => rest,
        _ => body,
    };
    let signed = |value: f64| Ok(Some(if is_negative { -value } else { value }));
    if body.eq_ignore_ascii_case(b"inf") || body.eq_ignore_ascii_case(b"infinity") {
        return signed(f64::INFINITY);
    }
    if body.eq_ignore_ascii_case(b"nan") {
        return Ok(Some(f64::NAN));
    }
    let body = match body {
        [b'0', b'x' | b'X', rest @ ..] => rest,
        _ => body,
    };
    let (mut mantissa, mut exponent) = (0_u128, 0_i64);
    let (mut has_digits, mut has_point, mut is_more) = (false, false, false);
    let mut bytes = body.iter();
    let mut has_power = false;
    for byte in bytes.by_ref() {
        ev.charge(WORK_PER_BYTE)?;
        match byte {
            b'.' if !has_point => has_point = true,
            b'p' | b'P' => {
                has_power = true;
                break;
            }
            _ => {
                let Some(digit) = char::from(*byte).to_digit(16) else {
                    return Ok(None);
                };
                has_digits = true;
                // A hundred bits are more than a float has; of what is behind them only matters whether it is zero.
                if mantissa >> 100 == 0 {
                    mantissa = mantissa << 4 | u128::from(digit);
                    exponent -= if has_point { 4 } else { 0 };
                } else {
                    is_more |= digit != 0;
                    exponent += if has_point { 0 } else { 4 };
                }
            }
        }
    }
    if has_power {
        let digits = match bytes.as_slice() {
            [b'-' | b'+', rest @ ..] => rest,
            all => all,
        };
        let mut power = 0_i64;
        for byte in digits {
            ev.charge(WORK_PER_BYTE)?;
            if !byte.is_ascii_digit() {
                return Ok(None);
            }
            // Far beyond every float and every length of a text.
            power = (power * 10 + i64::from(byte - b'0')).min(1 << 50);
        }
        if digits.is_empty() {
            return Ok(None);
        }
        exponent += if bytes.as_slice().first() == Some(&b'-') {
            -power
        } else {
            power
        };
    }
    if !has_digits {
        return Ok(None);
    }
    if mantissa == 0 {
        return signed(0.0);
    }
    let mantissa = BigInt::from(mantissa | u128::from(is_more));
    let size = mantissa.bits() as i64 + exponent;
    if size > 1100 {
        return signed(f64::INFINITY);
    }
    if size < -1100 {
        return signed(0.0);
    }
    signed(rounded(&mantissa, exponent))
}
