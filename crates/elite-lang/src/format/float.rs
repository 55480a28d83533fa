//! Floats as text, digit for digit as CPython writes them.

/// Python's `repr(float)`: the shortest digits that read back as the same float.
pub fn repr(value: f64) -> String {
    let mut text = String::with_capacity(24);
    push_repr(value, &mut text);
    text
}

/// Appends Python's `repr(float)`.
pub fn push_repr(value: f64, out: &mut String) {
    use std::fmt::Write as _;
    if let Some(text) = not_finite(value) {
        return out.push_str(text);
    }
    // Rust finds the same shortest digits; only the layout differs, and the last one where two are as near. The bounds
    // are floats themselves, so the digits of what lies between them have exponents from -4 to 15. Writing to a string
    // cannot fail.
    let start = out.len();
    if value == 0.0 || (1e-4..1e16).contains(&value.abs()) {
        let _ = write!(out, "{value}");
        match out[start..].find('.') {
            None => out.push_str(".0"),
            Some(at) => {
                let decimals = out.len() - start - at - 1;
                nearest_even(value, start, out, |out| write!(out, "{value:.decimals$}"));
            }
        }
        return;
    }
    let _ = write!(out, "{value:e}");
    if let Some(at) = out[start..].find('e') {
        let decimals = at.saturating_sub(1 + out[start..].find('.').unwrap_or(at));
        nearest_even(value, start, out, |out| write!(out, "{value:.decimals$e}"));
    }
    let Some(at) = out[start..].find('e') else {
        return;
    };
    let exponent: i32 = out[start + at + 1..].parse().unwrap_or(0);
    out.truncate(start + at);
    let sign = if exponent < 0 { '-' } else { '+' };
    let _ = write!(out, "e{sign}{:02}", exponent.abs());
}

/// Fewer digits than this are those of no two floats.
const DIGITS_OF_ONE: usize = 15;

/// Of the texts with as many digits as the one from `start` on takes the one nearest to the value, the even one of two
/// that are as near, if it reads back as the same float.
fn nearest_even(
    value: f64,
    start: usize,
    out: &mut String,
    write: impl FnOnce(&mut String) -> std::fmt::Result,
) {
    let end = out.len();
    if end - start <= DIGITS_OF_ONE {
        return;
    }
    if write(out).is_ok() && out[end..].parse() == Ok(value) {
        out.replace_range(start..end, "");
    } else {
        out.truncate(end);
    }
}

fn not_finite(value: f64) -> Option<&'static str> {
    if value.is_nan() {
        return Some("nan");
    }
    value
        .is_infinite()
        .then_some(if value > 0.0 { "inf" } else { "-inf" })
}

/// Python's `repr(complex)`.
pub fn complex_repr(re: f64, im: f64) -> String {
    let short = |value: f64| {
        let text = repr(value);
        text.strip_suffix(".0").map(str::to_owned).unwrap_or(text)
    };
    let imaginary = short(im);
    if re == 0.0 && re.is_sign_positive() {
        return format!("{imaginary}j");
    }
    let plus = if imaginary.starts_with('-') { "" } else { "+" };
    format!("({}{plus}{imaginary}j)", short(re))
}

/// A number in a format: what a double has of digits, then so many zeros, then what follows them.
#[derive(Debug, Default, PartialEq)]
pub struct FloatText {
    /// Up to the last exact digit.
    pub head: String,
    /// Further decimals, which are zero; there may be any number of them.
    pub zeros: usize,
    /// The exponent.
    pub tail: String,
}

impl FloatText {
    fn plain(head: impl Into<String>) -> Self {
        FloatText {
            head: head.into(),
            ..FloatText::default()
        }
    }

    /// The text with capital letters.
    pub fn to_uppercase(&self) -> Self {
        FloatText {
            head: self.head.to_uppercase(),
            zeros: self.zeros,
            tail: self.tail.to_uppercase(),
        }
    }
}

/// `f` format of a non-negative number.
pub fn format_fixed(value: f64, precision: usize, alternate: bool) -> FloatText {
    let mut head = String::new();
    let zeros = push_fixed(value, precision, alternate, &mut head);
    FloatText {
        head,
        zeros,
        tail: String::new(),
    }
}

/// Appends the `f` format of a non-negative number; the zeros that are still to follow.
#[must_use]
pub fn push_fixed(value: f64, precision: usize, alternate: bool, out: &mut String) -> usize {
    use std::fmt::Write as _;
    if let Some(text) = not_finite(value) {
        out.push_str(text);
        return 0;
    }
    let mut zeros = 0;
    if !push_fixed_by_integers(value, precision, out) {
        // Writing to a string cannot fail.
        let _ = write!(out, "{value:.*}", precision.min(EXACT));
        zeros = zeros_beyond(precision);
    }
    if alternate && precision == 0 {
        out.push('.');
    }
    zeros
}

/// A double has no more decimals than this that are not zero, in either layout; the formatting of Rust takes few more.
const EXACT: usize = 1100;

/// How many decimals of a `precision` are behind the exact ones.
fn zeros_beyond(precision: usize) -> usize {
    precision.saturating_sub(EXACT)
}

/// Most decimals that `push_fixed_by_integers` gives: with them a mantissa times their power of ten fits 128 bits.
const DECIMALS_MAX: usize = 18;

/// Appends the decimals of a non-negative number below 2^53, exact, halves to even; false for others. A double is
/// m·2^-s, so it is m·10^p, shifted: faster than the general algorithm, which is at its slowest where decimals come
/// out even.
fn push_fixed_by_integers(value: f64, precision: usize, out: &mut String) -> bool {
    let bits = value.to_bits();
    let (exponent, fraction) = (bits >> 52, bits & ((1 << 52) - 1));
    let Some(shift) = 1075_u64.checked_sub(exponent) else {
        return false;
    };
    if precision > DECIMALS_MAX || exponent == 0 || !(1..=120).contains(&shift) {
        return false;
    }
    let unit = 10_u64.pow(precision as u32);
    let scaled = u128::from(fraction | 1 << 52) * u128::from(unit);
    let (whole, rest) = (scaled >> shift, scaled & ((1 << shift) - 1));
    let half = 1_u128 << (shift - 1);
    let up = rest > half || rest == half && whole & 1 == 1;
    let digits = whole + u128::from(up);
    // The whole part is below 2^53, and the decimals are below the unit.
    let (whole, decimals) = match u64::try_from(digits) {
        Ok(digits) => (digits / unit, digits % unit),
        Err(_) => {
            let unit = u128::from(unit);
            ((digits / unit) as u64, (digits % unit) as u64)
        }
    };
    super::push_digits(whole, 1, out);
    if precision > 0 {
        out.push('.');
        super::push_digits(decimals, precision, out);
    }
    true
}

/// `e` format of a non-negative number.
pub fn exponent(value: f64, precision: usize, alternate: bool) -> FloatText {
    if let Some(text) = not_finite(value) {
        return FloatText::plain(text);
    }
    let text = format!("{value:.*e}", precision.min(EXACT));
    let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let point = if alternate && precision == 0 { "." } else { "" };
    let sign = if exponent < 0 { '-' } else { '+' };
    FloatText {
        head: format!("{digits}{point}"),
        zeros: zeros_beyond(precision),
        tail: format!("e{sign}{:02}", exponent.abs()),
    }
}

/// `g` format of a non-negative number with `precision` significant digits. With `with_point` (no type given) the
/// result always looks like a float.
pub fn general(value: f64, precision: usize, alternate: bool, with_point: bool) -> FloatText {
    if let Some(text) = not_finite(value) {
        return FloatText::plain(text);
    }
    // The exponent after rounding to the precision decides between the layouts.
    let rounded = format!("{value:.*e}", (precision - 1).min(EXACT));
    let (_, exponent_text) = rounded.split_once('e').unwrap_or((&rounded, "0"));
    let size: i32 = exponent_text.parse().unwrap_or(0);
    let precision = precision.min(if alternate { usize::MAX } else { EXACT });
    let limit = precision as i64 - i64::from(with_point);
    if size < -4 || i64::from(size) >= limit {
        let digits = exponent(value, precision - 1, alternate);
        if alternate {
            return digits;
        }
        // Without the alternate form there are no more digits than exact ones.
        return FloatText {
            head: trim_zeros(&digits.head).to_owned(),
            ..digits
        };
    }
    let digits = format_fixed(
        value,
        (precision as i64 - 1 - i64::from(size)).max(0) as usize,
        alternate,
    );
    if alternate {
        return digits;
    }
    let text = trim_zeros(&digits.head).to_owned();
    FloatText::plain(if with_point && !text.contains('.') {
        text + ".0"
    } else {
        text
    })
}

fn trim_zeros(digits: &str) -> &str {
    if digits.contains('.') {
        digits.trim_end_matches('0').trim_end_matches('.')
    } else {
        digits
    }
}

/// Rounds to `digits` decimal places (negative: tens, hundreds, …), halves to even by the exact value, as Python's
/// `round(float, digits)`.
pub fn round(value: f64, digits: i64) -> f64 {
    if !value.is_finite() || digits > 330 {
        return value;
    }
    if digits < -310 {
        return 0f64.copysign(value);
    }
    if digits >= 0 {
        // Formatting rounds the exact binary value correctly.
        return format!("{value:.*}", digits as usize)
            .parse()
            .unwrap_or(value);
    }
    let text = format!("{:.0}", value.abs().trunc());
    let drop = (-digits) as usize;
    let fraction = value.abs().fract();
    if drop > text.len() {
        return 0f64.copysign(value);
    }
    let (kept, cut) = text.split_at(text.len() - drop);
    let half = format!("5{}", "0".repeat(drop - 1));
    let odd = kept.ends_with(['1', '3', '5', '7', '9']);
    let up = match cut.cmp(&half) {
        std::cmp::Ordering::Greater => true,
        std::cmp::Ordering::Equal => fraction > 0.0 || odd,
        std::cmp::Ordering::Less => false,
    };
    let mut digits = kept.as_bytes().to_vec();
    if up {
        // One more, from the last digit that is no nine on.
        let nines = { digits.iter().rev() }
            .take_while(|digit| **digit == b'9')
            .count();
        let place = digits.len() - nines;
        digits[place..].fill(b'0');
        match place.checked_sub(1) {
            Some(last) => digits[last] += 1,
            None => digits.insert(0, b'1'),
        }
    }
    let rounded = format!("0{}e{drop}", String::from_utf8_lossy(&digits))
        .parse()
        .unwrap_or(value);
    f64::copysign(rounded, value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floats_read_as_python_writes_them() {
        for (value, text) in [
            (0.0, "0.0"),
            (-0.0, "-0.0"),
            (1.0, "1.0"),
            (0.1, "0.1"),
            (1e15, "1000000000000000.0"),
            (1e16, "1e+16"),
            (1.5e-5, "1.5e-05"),
            (0.0001, "0.0001"),
            (1e22, "1e+22"),
            (1.7976931348623157e308, "1.7976931348623157e+308"),
            (5e-324, "5e-324"),
            (123_456_789.125, "123456789.125"),
        ] {
            assert_eq!(repr(value), text);
        }
    }

    #[test]
    fn fixed_decimals_are_those_of_the_general_algorithm() {
        let mut state = 1_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            state ^ (state >> 29)
        };
        let plain = [
            0.5,
            1.5,
            2.5,
            0.125,
            0.375,
            1e-5,
            5e-324,
            0.999_999_9,
            9.995,
            2.675,
            1e15,
            4e15,
            1e16,
            0.0,
        ];
        let wild = (0..1000).map(|_| f64::from_bits(random() & !(1 << 63)));
        let tame: Vec<f64> = wild.filter(|x| x.is_finite()).collect();
        let near = (0..1500_u32).map(|i| f64::from(i) / 64.0 + f64::from(i % 7) * 1e-9);
        for value in plain.into_iter().chain(tame).chain(near) {
            for precision in [0, 1, 2, 3, 6, 12, 18, 19] {
                let general = format!("{value:.precision$}");
                assert_eq!(
                    format_fixed(value, precision, false),
                    FloatText::plain(general),
                    "{value:e} {precision}"
                );
            }
        }
    }

    #[test]
    fn halves_round_by_their_exact_value() {
        assert_eq!(round(2.675, 2), 2.67);
        assert_eq!(round(0.5, 0), 0.0);
        assert_eq!(round(1.5, 0), 2.0);
        assert_eq!(round(25.0, -1), 20.0);
        assert_eq!(round(35.0, -1), 40.0);
        assert_eq!(round(-1234.5, -2), -1200.0);
    }
}
