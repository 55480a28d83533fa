//! Floats and complex numbers in text, of any length.
//!
//! The standard library reads a numeral at once, so long ones are made short first, piece by piece: digits beyond those
//! that can decide how a float is rounded only count by whether one of them is not zero.

use super::number::to_ascii_digit;
use crate::eval::Evaluator;
use crate::limits::chunked::{CHUNK, WORK_PER_BYTE, pieces};
use crate::value::R;

/// Significant digits that are kept: no float lies nearer to the middle between two others than 768 digits can tell
/// (the longest such middle has 767), and one more says whether anything follows.
const DIGITS_MAX: usize = 800;
/// Exponents beyond this are zero or infinite with any digits that are kept.
const EXPONENT_MAX: i64 = 100_000;

/// The float that a text without blanks around it stands for.
pub(super) fn float(ev: &Evaluator<'_>, text: &str) -> R<Option<f64>> {
    if text.len() <= CHUNK {
        return Ok(parse_float(text));
    }
    let (short, read) = shorten_numeral(ev, text)?;
    Ok((read == text.len())
        .then(|| short.and_then(|short| parse_float(&short)))
        .flatten())
}

/// The complex number that a text without blanks around it stands for.
pub(super) fn complex(ev: &Evaluator<'_>, text: &str) -> R<Option<(f64, f64)>> {
    if text.len() <= CHUNK {
        return Ok(parse_complex(text));
    }
    let mut short = String::new();
    let mut rest = text;
    // A bracket and blanks, two numerals, what follows.
    for _ in 0..2 {
        let begins = |c: char| c.is_whitespace() || c == '(';
        let before = ev.prefix_len(rest, begins)?;
        short.extend(rest[..before].chars().filter(|c| !c.is_whitespace()));
        rest = &rest[before..];
        let (numeral, read) = shorten_numeral(ev, rest)?;
        match numeral {
            Some(numeral) => short.push_str(&numeral),
            None if read > 0 && read == rest.len() => return Ok(None),
            None => break,
        }
        rest = &rest[read..];
    }
    let after = ev.prefix_len(rest, |c| c == 'j' || c == 'J')?;
    let blanks = after + ev.prefix_len(&rest[after..], char::is_whitespace)?;
    if after > 1 || rest.len() - blanks > CHUNK || short.len() > 4 * DIGITS_MAX {
        return Ok(None);
    }
    short.push_str(&rest[..after]);
    short.push_str(&rest[blanks..]);
    Ok(parse_complex(&short))
}

/// Where a numeral is being read.
#[derive(Clone, Copy, PartialEq)]
enum NumeralState {
    Sign,
    Whole,
    Fraction,
    ExponentSign,
    Exponent,
}

/// The numeral at the beginning of a text with no more digits than matter, None if it is none, and its bytes.
fn shorten_numeral(ev: &Evaluator<'_>, text: &str) -> R<(Option<String>, usize)> {
    let (mut at, mut before, mut read) = (NumeralState::Sign, ' ', 0);
    let (mut sign, mut digits, mut follows) = ("", String::new(), false);
    let (mut is_number, mut scale, mut exponent, mut down) = (false, 0_i64, 0_i64, false);
    'text: for piece in pieces(text) {
        for c in piece.chars() {
            let c_bytes = c.len_utf8();
            let digit = to_ascii_digit(c);
            match (at, digit) {
                (NumeralState::Sign, '+' | '-') => {
                    sign = if digit == '-' { "-" } else { "" };
                    at = NumeralState::Whole;
                }
                (NumeralState::Sign | NumeralState::Whole | NumeralState::Fraction, '0'..='9') => {
                    is_number = true;
                    let in_fraction = at == NumeralState::Fraction;
                    if at == NumeralState::Sign {
                        at = NumeralState::Whole;
                    }
                    match (digits.len(), digit) {
                        (0, '0') => scale -= i64::from(in_fraction),
                        (0..DIGITS_MAX, _) => {
                            digits.push(digit);
                            scale -= i64::from(in_fraction);
                        }
                        _ => {
                            follows |= digit != '0';
                            scale += i64::from(!in_fraction);
                        }
                    }
                }
                (NumeralState::Sign | NumeralState::Whole, '.') if before != '_' => {
                    at = NumeralState::Fraction
                }
                (NumeralState::Whole | NumeralState::Fraction, 'e' | 'E')
                    if is_number && before != '_' =>
                {
                    at = NumeralState::ExponentSign;
                }
                (NumeralState::ExponentSign, '+' | '-') if matches!(before, 'e' | 'E') => {
                    down = digit == '-';
                }
                (NumeralState::ExponentSign | NumeralState::Exponent, '0'..='9') => {
                    at = NumeralState::Exponent;
                    let value = i64::from(digit.to_digit(10).unwrap_or(0));
                    exponent = exponent.saturating_mul(10).saturating_add(value);
                }
                // Between digits only.
                (NumeralState::Whole | NumeralState::Fraction | NumeralState::Exponent, '_')
                    if before.is_ascii_digit() => {}
                _ => break 'text,
            }
            if before == '_' && !digit.is_ascii_digit() {
                return Ok((None, read));
            }
            before = digit;
            read += c_bytes;
        }
        ev.charge(piece.len() * WORK_PER_BYTE)?;
    }
    let is_whole = is_number && before != '_' && at != NumeralState::ExponentSign;
    if !is_whole {
        return Ok((None, read));
    }
    if follows {
        digits.push('1');
        scale -= 1;
    }
    let exponent = if down { -exponent } else { exponent };
    let exponent = scale
        .saturating_add(exponent)
        .clamp(-EXPONENT_MAX, EXPONENT_MAX);
    let digits = if digits.is_empty() { "0" } else { &digits };
    Ok((Some(format!("{sign}{digits}e{exponent}")), read))
}

/// A float in text, as `float` reads it.
fn parse_float(text: &str) -> Option<f64> {
    let trimmed = text.trim();
    // The commonest; what else the standard library reads are words.
    let is_plain = |byte: u8| byte.is_ascii_digit() || b"+-.eE".contains(&byte);
    if trimmed.bytes().all(is_plain) {
        return trimmed.parse().ok();
    }
    let unsigned = trimmed.trim_start_matches(['+', '-']);
    if trimmed.len() - unsigned.len() > 1 {
        return None;
    }
    let lower = unsigned.to_ascii_lowercase();
    if matches!(&*lower, "inf" | "infinity" | "nan") {
        return trimmed.parse().ok();
    }
    let digits: String = trimmed.chars().map(to_ascii_digit).collect();
    let numeric = digits
        .bytes()
        .all(|b| b.is_ascii_digit() || b"+-.eE_".contains(&b));
    if !numeric {
        return None;
    }
    if digits.contains('_') {
        let bytes = digits.as_bytes();
        let is_digit = |at: Option<usize>| {
            at.and_then(|at| bytes.get(at))
                .is_some_and(u8::is_ascii_digit)
        };
        let between = bytes.iter().enumerate().filter(|(_, byte)| **byte == b'_');
        if !{ between }.all(|(at, _)| is_digit(at.checked_sub(1)) && is_digit(Some(at + 1))) {
            return None;
        }
        return digits.replace('_', "").parse().ok();
    }
    digits.parse().ok()
}

/// `re+imj`, with either part missing and optional parentheses.
fn parse_complex(text: &str) -> Option<(f64, f64)> {
    let text = text.trim();
    let text = text
        .strip_prefix('(')
        .and_then(|text| text.strip_suffix(')'))
        .unwrap_or(text)
        .trim();
    let Some(body) = text.strip_suffix(['j', 'J']) else {
        return parse_float(text).map(|re| (re, 0.0));
    };
    let bytes = body.as_bytes();
    let sign = (1..bytes.len())
        .rev()
        .find(|at| b"+-".contains(&bytes[*at]) && !b"eE".contains(&bytes[at - 1]));
    let (re, im) = body.split_at(sign.unwrap_or(0));
    let im = match im {
        "" | "+" => 1.0,
        "-" => -1.0,
        digits => parse_float(digits)?,
    };
    let re = if re.is_empty() { 0.0 } else { parse_float(re)? };
    Some((re, im))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_numerals_are_rounded_as_short_ones() {
        let half = "9007199254740993".to_owned();
        let zeros = "0".repeat(CHUNK);
        let cases = [
            (format!("{half}.{zeros}"), 9007199254740992.0),
            (format!("{half}.{zeros}1"), 9007199254740994.0),
            (format!("-{half}{zeros}e-{CHUNK}"), -9007199254740992.0),
            (format!("0.{zeros}5e{}", CHUNK + 1), 5.0),
            (format!("{zeros}1_0.2_5"), 10.25),
            (format!("1{zeros}"), f64::INFINITY),
            (format!("1e-{zeros}400"), 0.0),
            (format!("1e{zeros}2"), 100.0),
            (format!(".{zeros}"), 0.0),
        ];
        crate::trials::evaluate(move |ev| {
            for (text, expected) in &cases {
                let read = float(ev, text)?;
                assert_eq!(read, Some(*expected), "{}…", &text[..20]);
            }
            for wrong in [
                "1__{}", "_1{}", "1{}_", "1{}_.5", "1{}e", "1{}e+", "1{}x", "+-{}",
            ] {
                let text = wrong.replace("{}", &"0".repeat(CHUNK));
                assert_eq!(float(ev, &text)?, None, "{wrong}");
            }
            let one = format!("1.{}", "0".repeat(CHUNK));
            assert_eq!(complex(ev, &format!("({one}-{one}j)"))?, Some((1.0, -1.0)));
            assert_eq!(complex(ev, &format!("{one}j"))?, Some((0.0, 1.0)));
            assert_eq!(complex(ev, &format!("{one}+{one}"))?, None);
            Ok(())
        });
    }
}
