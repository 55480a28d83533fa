//! Integers of any size: arithmetic that starts in 64 bits and goes on in big integers when it must.

use std::borrow::Cow;
use std::rc::Rc;

use num_bigint::{BigInt, Sign};

use super::Value;

/// An integer operand, small or big.
#[derive(Clone)]
pub enum Int {
    /// Fits 64 bits.
    Small(i64),
    /// Does not.
    Big(Rc<BigInt>),
}

impl Int {
    /// The integer a value is (booleans count), not converting anything else.
    #[inline]
    pub fn of(value: &Value) -> Option<Int> {
        match value {
            Value::Int(small) => Some(Int::Small(*small)),
            Value::Bool(flag) => Some(Int::Small(i64::from(*flag))),
            Value::BigInt(big) => Some(Int::Big(big.clone())),
            _ => None,
        }
    }

    /// A copy of the number as a big integer.
    pub fn to_big(&self) -> BigInt {
        match self {
            Int::Small(small) => BigInt::from(*small),
            Int::Big(big) => (**big).clone(),
        }
    }

    /// The number as a big integer, without a copy if it is one already.
    pub fn as_big(&self) -> Cow<'_, BigInt> {
        match self {
            Int::Small(small) => Cow::Owned(BigInt::from(*small)),
            Int::Big(big) => Cow::Borrowed(big),
        }
    }

    /// Bits of the magnitude.
    pub fn bits(&self) -> u64 {
        match self {
            Int::Small(small) => u64::from(64 - small.unsigned_abs().leading_zeros()),
            Int::Big(big) => big.bits(),
        }
    }

    /// Whether the number is below zero.
    pub fn is_negative(&self) -> bool {
        match self {
            Int::Small(small) => *small < 0,
            Int::Big(big) => big.sign() == Sign::Minus,
        }
    }

    /// Whether the number is zero.
    pub fn is_zero(&self) -> bool {
        matches!(self, Int::Small(0))
    }

    /// The nearest float; infinite if out of range.
    pub fn to_f64(&self) -> f64 {
        match self {
            Int::Small(small) => *small as f64,
            Int::Big(big) => big_to_f64(big),
        }
    }

    /// The number as a script value.
    pub fn into_value(self) -> Value {
        match self {
            Int::Small(small) => Value::Int(small),
            Int::Big(big) => Value::BigInt(big),
        }
    }
}

/// The float nearest to a big integer, ties to even, infinite beyond the range.
pub fn big_to_f64(big: &BigInt) -> f64 {
    let bits = big.bits();
    if bits > 1024 {
        return if big.sign() == Sign::Minus {
            f64::NEG_INFINITY
        } else {
            f64::INFINITY
        };
    }
    // Keep 64 significant bits; whatever is cut off only matters as "not exactly a tie".
    let shift = bits.saturating_sub(64);
    let magnitude = big.magnitude();
    let top = magnitude >> shift;
    let mut digits = top.iter_u64_digits().next().unwrap_or(0);
    if shift > 0 && (&top << shift) != *magnitude {
        digits |= 1;
    }
    let value = digits as f64 * 2f64.powi(shift as i32);
    if big.sign() == Sign::Minus {
        -value
    } else {
        value
    }
}

/// Floor division and modulo of 64-bit integers, Python's signs. The divisor is not 0.
#[inline]
pub fn floor_divmod(a: i64, b: i64) -> Option<(i64, i64)> {
    let quotient = a.checked_div(b)?;
    let remainder = a.wrapping_rem(b);
    let adjust = remainder != 0 && (remainder < 0) != (b < 0);
    Some(if adjust {
        (quotient - 1, remainder + b)
    } else {
        (quotient, remainder)
    })
}

/// Floor division and modulo of big integers. The divisor is not 0.
pub fn big_floor_divmod(a: &BigInt, b: &BigInt) -> (BigInt, BigInt) {
    let (quotient, remainder) = (a / b, a % b);
    let adjust = remainder.sign() != Sign::NoSign && remainder.sign() != b.sign();
    if adjust {
        (quotient - 1, remainder + b)
    } else {
        (quotient, remainder)
    }
}

/// The integer part of a finite float.
pub fn from_f64(value: f64) -> Value {
    let whole = value.trunc();
    if whole.abs() < 9.0e18 {
        return Value::Int(whole as i64);
    }
    let bits = whole.to_bits();
    let exponent = ((bits >> 52) & 0x7ff) as i32 - 1075;
    let mantissa = BigInt::from((bits & ((1 << 52) - 1)) | (1 << 52)) << exponent;
    Value::bigint(if whole < 0.0 { -mantissa } else { mantissa })
}
