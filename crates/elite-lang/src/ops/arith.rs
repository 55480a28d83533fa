//! Arithmetic of numbers: integers of any size, floats, complex numbers. Semantics and messages are CPython 3.11's.

use elite_syntax::ast::BinaryOp;
use num_bigint::BigInt;

use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::value::int::{Int, floor_divmod};
use crate::value::{R, Unwind, Value};

/// A number, brought to the wider of two types.
enum NumericPair {
    Int(Int, Int),
    Float(f64, f64),
    Complex((f64, f64), (f64, f64)),
}

/// The result of the commonest cases; None if they need more care.
#[inline(always)]
pub fn fast(op: BinaryOp, a: &Value, b: &Value) -> Option<Value> {
    match (a, b) {
        (Value::Int(a), Value::Int(b)) => fast_int(op, *a, *b),
        (Value::Float(a), Value::Float(b)) => fast_float(op, *a, *b),
        (Value::Int(a), Value::Float(b)) => fast_float(op, *a as f64, *b),
        (Value::Float(a), Value::Int(b)) => fast_float(op, *a, *b as f64),
        _ => None,
    }
}

#[inline(always)]
fn fast_int(op: BinaryOp, a: i64, b: i64) -> Option<Value> {
    match op {
        BinaryOp::Add => a.checked_add(b).map(Value::Int),
        BinaryOp::Sub => a.checked_sub(b).map(Value::Int),
        BinaryOp::Mul => a.checked_mul(b).map(Value::Int),
        BinaryOp::Div => {
            // Exact as long as both are exact as floats.
            let exact = a.unsigned_abs() < 1 << 53 && b.unsigned_abs() < 1 << 53 && b != 0;
            exact.then(|| Value::Float(a as f64 / b as f64))
        }
        BinaryOp::FloorDiv if b != 0 => {
            floor_divmod(a, b).map(|(quotient, _)| Value::Int(quotient))
        }
        BinaryOp::Mod if b != 0 => {
            let remainder = a.wrapping_rem(b);
            let adjust = remainder != 0 && (remainder < 0) != (b < 0);
            Some(Value::Int(if adjust { remainder + b } else { remainder }))
        }
        BinaryOp::BitAnd => Some(Value::Int(a & b)),
        BinaryOp::BitOr => Some(Value::Int(a | b)),
        BinaryOp::BitXor => Some(Value::Int(a ^ b)),
        BinaryOp::Shl
            if (0..62).contains(&b) && a.unsigned_abs().leading_zeros() as i64 > b + 1 =>
        {
            Some(Value::Int(a << b))
        }
        BinaryOp::Shr if b >= 0 => Some(Value::Int(a >> b.min(63))),
        _ => None,
    }
}

#[inline(always)]
fn fast_float(op: BinaryOp, a: f64, b: f64) -> Option<Value> {
    match op {
        BinaryOp::Add => Some(Value::Float(a + b)),
        BinaryOp::Sub => Some(Value::Float(a - b)),
        BinaryOp::Mul => Some(Value::Float(a * b)),
        BinaryOp::Div if b != 0.0 => Some(Value::Float(a / b)),
        _ => None,
    }
}

fn pair(a: &Value, b: &Value) -> Option<Result<NumericPair, ()>> {
    Some(match (a, b) {
        (Value::Complex(a), Value::Complex(b)) => Ok(NumericPair::Complex(**a, **b)),
        (Value::Complex(a), b) => real(b)?.map(|b| NumericPair::Complex(**a, (b, 0.0))),
        (a, Value::Complex(b)) => real(a)?.map(|a| NumericPair::Complex((a, 0.0), **b)),
        (Value::Float(a), b) => real(b)?.map(|b| NumericPair::Float(*a, b)),
        (a, Value::Float(b)) => real(a)?.map(|a| NumericPair::Float(a, *b)),
        _ => Ok(NumericPair::Int(Int::of(a)?, Int::of(b)?)),
    })
}

/// A real number as a float; an error if it is an integer out of range.
fn real(value: &Value) -> Option<Result<f64, ()>> {
    if let Value::Float(float) = value {
        return Some(Ok(*float));
    }
    let float = Int::of(value)?.to_f64();
    Some(if float.is_finite() {
        Ok(float)
    } else {
        Err(())
    })
}

impl Evaluator<'_> {
    /// The operation on two numbers; None if one of them is no number or the type has no such operation.
    pub fn number_binary(&self, op: BinaryOp, a: &Value, b: &Value) -> R<Option<Value>> {
        if let (Value::BigInt(a), Value::BigInt(b)) = (a, b) {
            match op {
                BinaryOp::Add => return Ok(Some(Value::bigint(&**a + &**b))),
                BinaryOp::Sub => return Ok(Some(Value::bigint(&**a - &**b))),
                _ => {}
            }
        }
        if let Some(value) = fast(op, a, b) {
            let both_bool_operands = matches!((a, b), (Value::Bool(_), _) | (_, Value::Bool(_)));
            debug_assert!(!both_bool_operands);
            return Ok(Some(value));
        }
        match pair(a, b) {
            None => Ok(None),
            Some(Err(())) if op == BinaryOp::MatMul || is_bitwise(op) => Ok(None),
            Some(Err(())) => Err(self.raise(
                ExceptionKind::OverflowError,
                "int too large to convert to float",
            )),
            Some(Ok(NumericPair::Int(x, y))) => {
                if let (Value::Bool(x), Value::Bool(y)) = (a, b) {
                    let flag = match op {
                        BinaryOp::BitAnd => Some(*x & *y),
                        BinaryOp::BitOr => Some(*x | *y),
                        BinaryOp::BitXor => Some(*x ^ *y),
                        _ => None,
                    };
                    if let Some(flag) = flag {
                        return Ok(Some(Value::Bool(flag)));
                    }
                }
                self.int_binary(op, x, y)
            }
            Some(Ok(NumericPair::Float(x, y))) => self.float_binary(op, x, y),
            Some(Ok(NumericPair::Complex(x, y))) => self.complex_binary(op, x, y),
        }
    }

    #[cold]
    fn zero_division(&self, message: &str) -> Unwind {
        self.raise(ExceptionKind::ZeroDivisionError, message)
    }

    fn int_binary(&self, op: BinaryOp, a: Int, b: Int) -> R<Option<Value>> {
        if let (Int::Small(a), Int::Small(b)) = (&a, &b)
            && let Some(value) = fast_int(op, *a, *b)
        {
            return Ok(Some(value));
        }
        let big = |op: fn(&BigInt, &BigInt) -> BigInt| Value::bigint(op(&a.as_big(), &b.as_big()));
        let value = match op {
            BinaryOp::Add => big(|a, b| a + b),
            BinaryOp::Sub => big(|a, b| a - b),
            BinaryOp::Mul => {
                self.check_bits(a.bits() + b.bits())?;
                Value::bigint(self.big_product(&a.as_big(), &b.as_big())?)
            }
            BinaryOp::Div => return self.int_true_division(&a, &b).map(Some),
            BinaryOp::FloorDiv if b.is_zero() => {
                return Err(self.zero_division("integer division or modulo by zero"));
            }
            BinaryOp::Mod if b.is_zero() => {
                return Err(self.zero_division("integer modulo by zero"));
            }
            BinaryOp::FloorDiv => Value::bigint(self.big_divmod(&a.as_big(), &b.as_big())?.0),
            BinaryOp::Mod => Value::bigint(self.big_remainder(&a.as_big(), &b.as_big())?),
            BinaryOp::Pow => return self.int_pow(&a, &b).map(Some),
            BinaryOp::BitAnd => big(|a, b| a & b),
            BinaryOp::BitOr => big(|a, b| a | b),
            BinaryOp::BitXor => big(|a, b| a ^ b),
            BinaryOp::Shl | BinaryOp::Shr => return self.int_shift(op, &a, &b).map(Some),
            BinaryOp::MatMul => return Ok(None),
        };
        Ok(Some(value))
    }

    /// Refuses results of more bits than allowed, before they are computed.
    pub fn check_bits(&self, bits: u64) -> R<()> {
        let limit = self.core.limits.int_bits;
        if bits <= limit {
            return self.check_allocation((bits / 8) as usize);
        }
        Err(self.raise(
            ExceptionKind::OverflowError,
            format!("the integer would have {bits} bits, {limit} are allowed"),
        ))
    }

    fn int_shift(&self, op: BinaryOp, a: &Int, b: &Int) -> R {
        if b.is_negative() {
            return Err(self.value_error("negative shift count"));
        }
        let count = match b {
            Int::Small(count) => *count as u64,
            Int::Big(_) => u64::MAX,
        };
        if op == BinaryOp::Shr {
            if count > a.bits() {
                return Ok(Value::Int(if a.is_negative() { -1 } else { 0 }));
            }
            return Ok(Value::bigint(a.to_big() >> count));
        }
        if a.is_zero() {
            return Ok(Value::Int(0));
        }
        self.check_bits(a.bits().saturating_add(count))?;
        Ok(Value::bigint(a.to_big() << count))
    }

    /// True division of integers, correctly rounded.
    fn int_true_division(&self, a: &Int, b: &Int) -> R {
        if b.is_zero() {
            return Err(self.zero_division("division by zero"));
        }
        let (a, b) = (a.to_big(), b.to_big());
        let negative =
            (a.sign() == num_bigint::Sign::Minus) != (b.sign() == num_bigint::Sign::Minus);
        let (a, b) = (
            BigInt::from(a.magnitude().clone()),
            BigInt::from(b.magnitude().clone()),
        );
        // Scale so that the quotient has 66 bits or more, then let the conversion round once.
        let shift = 66 - (a.bits() as i64 - b.bits() as i64);
        let (top, bottom) = if shift > 0 {
            (a << shift, b)
        } else {
            (a, b << -shift)
        };
        let mut quotient = &top / &bottom;
        if &quotient * &bottom != top {
            quotient = (quotient << 1) + 1;
        } else {
            quotient <<= 1;
        }
        let scale = -(shift + 1);
        let digits = crate::value::int::big_to_f64(&quotient);
        let value = scale_exactly(digits, scale, &quotient);
        if !value.is_finite() {
            let message = "integer division result too large for a float";
            return Err(self.raise(ExceptionKind::OverflowError, message));
        }
        Ok(Value::Float(if negative { -value } else { value }))
    }

    fn int_pow(&self, base: &Int, exponent: &Int) -> R {
        if exponent.is_negative() {
            let (base, exponent) = (base.to_f64(), exponent.to_f64());
            return self.float_pow(base, exponent);
        }
        let exponent = match (base, exponent) {
            (Int::Small(1), _) | (_, Int::Small(0)) => return Ok(Value::Int(1)),
            (Int::Small(0), _) => return Ok(Value::Int(0)),
            (Int::Small(-1), _) => {
                let odd = match exponent {
                    Int::Small(small) => small & 1 == 1,
                    Int::Big(big) => big.bit(0),
                };
                return Ok(Value::Int(if odd { -1 } else { 1 }));
            }
            (_, Int::Small(exponent)) => *exponent as u64,
            (_, Int::Big(_)) => u64::MAX,
        };
        self.check_bits(base.bits().saturating_mul(exponent))?;
        if let Int::Small(base) = base
            && let Ok(exponent) = u32::try_from(exponent)
            && let Some(value) = base.checked_pow(exponent)
        {
            return Ok(Value::Int(value));
        }
        Ok(Value::bigint(self.big_power(&base.to_big(), exponent)?))
    }

    fn float_binary(&self, op: BinaryOp, a: f64, b: f64) -> R<Option<Value>> {
        let value = match op {
            BinaryOp::Add => a + b,
            BinaryOp::Sub => a - b,
            BinaryOp::Mul => a * b,
            BinaryOp::Div if b == 0.0 => return Err(self.zero_division("float division by zero")),
            BinaryOp::Div => a / b,
            BinaryOp::FloorDiv if b == 0.0 => {
                return Err(self.zero_division("float floor division by zero"));
            }
            BinaryOp::FloorDiv => float_divmod(a, b).0,
            BinaryOp::Mod if b == 0.0 => return Err(self.zero_division("float modulo")),
            BinaryOp::Mod => float_divmod(a, b).1,
            BinaryOp::Pow => return self.float_pow(a, b).map(Some),
            _ => return Ok(None),
        };
        Ok(Some(Value::Float(value)))
    }

    /// `base ** exponent` of floats; a negative base with a fractional exponent gives a complex number.
    pub fn float_pow(&self, base: f64, exponent: f64) -> R {
        if base == 0.0 && exponent < 0.0 && exponent.is_finite() {
            return Err(self.zero_division("0.0 cannot be raised to a negative power"));
        }
        if base < 0.0 && base.is_finite() && exponent.is_finite() && exponent.fract() != 0.0 {
            return self.complex_pow((base, 0.0), (exponent, 0.0));
        }
        let value = base.powf(exponent);
        if value.is_infinite() && base.is_finite() && exponent.is_finite() {
            let args = vec![Value::Int(34), Value::str("Numerical result out of range")];
            return Err(self.raise_args(ExceptionKind::OverflowError, args));
        }
        Ok(Value::Float(value))
    }

    fn complex_binary(&self, op: BinaryOp, a: (f64, f64), b: (f64, f64)) -> R<Option<Value>> {
        let (re, im) = match op {
            BinaryOp::Add => (a.0 + b.0, a.1 + b.1),
            BinaryOp::Sub => (a.0 - b.0, a.1 - b.1),
            BinaryOp::Mul => (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0),
            BinaryOp::Div if b == (0.0, 0.0) => {
                return Err(self.zero_division("complex division by zero"));
            }
            BinaryOp::Div => complex_div(a, b),
            BinaryOp::Pow => return self.complex_pow(a, b).map(Some),
            _ => return Ok(None),
        };
        Ok(Some(Value::complex(re, im)))
    }

    /// The result of a complex power, unless it is beyond all floats.
    fn complex_power(&self, power: (f64, f64)) -> R {
        if power.0.is_infinite() || power.1.is_infinite() {
            return Err(self.raise(ExceptionKind::OverflowError, "complex exponentiation"));
        }
        Ok(Value::complex(power.0, power.1))
    }

    fn complex_pow(&self, a: (f64, f64), b: (f64, f64)) -> R {
        if b == (0.0, 0.0) {
            return Ok(Value::complex(1.0, 0.0));
        }
        if a == (0.0, 0.0) {
            if b.1 != 0.0 || b.0 < 0.0 {
                return Err(self.zero_division("0.0 to a negative or complex power"));
            }
            return Ok(Value::complex(0.0, 0.0));
        }
        // Small integer powers by multiplication, as CPython does, for exact results.
        if b.1 == 0.0 && b.0.fract() == 0.0 && b.0.abs() <= 100.0 {
            let mut power = (1.0, 0.0);
            let mut factor = a;
            let mut rest = b.0.abs() as u32;
            while rest > 0 {
                if rest & 1 == 1 {
                    power = complex_mul(power, factor);
                }
                factor = complex_mul(factor, factor);
                rest >>= 1;
            }
            let power = if b.0 < 0.0 {
                complex_div((1.0, 0.0), power)
            } else {
                power
            };
            return self.complex_power(power);
        }
        let magnitude = a.0.hypot(a.1);
        let angle = a.1.atan2(a.0);
        let mut length = magnitude.powf(b.0);
        let mut phase = angle * b.0;
        if b.1 != 0.0 {
            length /= (angle * b.1).exp();
            phase += b.1 * magnitude.ln();
        }
        // In C an infinite angle is out of the domain of its cosine, and CPython has these words for that.
        if phase.is_infinite() {
            return Err(self.zero_division("0.0 to a negative or complex power"));
        }
        self.complex_power((length * phase.cos(), length * phase.sin()))
    }

    /// `divmod` of numbers; None if one is no number.
    pub fn number_divmod(&self, a: &Value, b: &Value) -> R<Option<(Value, Value)>> {
        match pair(a, b) {
            Some(Ok(NumericPair::Int(_, y))) if y.is_zero() => {
                Err(self.zero_division("integer division or modulo by zero"))
            }
            Some(Ok(NumericPair::Int(Int::Small(x), Int::Small(y)))) if x != i64::MIN => {
                let parts = floor_divmod(x, y).map(|(q, r)| (Value::Int(q), Value::Int(r)));
                Ok(parts)
            }
            Some(Ok(NumericPair::Int(x, y))) => {
                let (quotient, remainder) = self.big_divmod(&x.to_big(), &y.to_big())?;
                Ok(Some((Value::bigint(quotient), Value::bigint(remainder))))
            }
            Some(Ok(NumericPair::Float(_, 0.0))) => Err(self.zero_division("float divmod()")),
            Some(Ok(NumericPair::Float(x, y))) => {
                let (quotient, remainder) = float_divmod(x, y);
                Ok(Some((Value::Float(quotient), Value::Float(remainder))))
            }
            Some(Err(())) => Err(self.raise(
                ExceptionKind::OverflowError,
                "int too large to convert to float",
            )),
            Some(Ok(NumericPair::Complex(..))) | None => Ok(None),
        }
    }

    /// `-value`; None if it is no number.
    pub fn number_negate(&self, value: &Value) -> Option<Value> {
        Some(match value {
            Value::Int(int) => int
                .checked_neg()
                .map_or_else(|| Value::bigint(-BigInt::from(*int)), Value::Int),
            Value::Float(float) => Value::Float(-float),
            Value::Bool(flag) => Value::Int(-i64::from(*flag)),
            Value::BigInt(big) => Value::bigint(-(**big).clone()),
            Value::Complex(complex) => Value::complex(-complex.0, -complex.1),
            _ => return None,
        })
    }
}

fn is_bitwise(op: BinaryOp) -> bool {
    matches!(
        op,
        BinaryOp::BitAnd | BinaryOp::BitOr | BinaryOp::BitXor | BinaryOp::Shl | BinaryOp::Shr
    )
}

/// Floor quotient and modulo of floats (CPython: `float_divmod`); the divisor is not 0.
pub fn float_divmod(a: f64, b: f64) -> (f64, f64) {
    let mut remainder = a % b;
    let mut quotient = (a - remainder) / b;
    if remainder != 0.0 {
        if (b < 0.0) != (remainder < 0.0) {
            remainder += b;
            quotient -= 1.0;
        }
    } else {
        remainder = 0f64.copysign(b);
    }
    if quotient != 0.0 {
        let floor = quotient.floor();
        quotient = if quotient - floor > 0.5 {
            floor + 1.0
        } else {
            floor
        };
    } else {
        quotient = 0f64.copysign(a / b);
    }
    (quotient, remainder)
}

fn complex_mul(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
}

/// Smith's method, as CPython; the divisor is not 0.
fn complex_div(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    if b.0.abs() >= b.1.abs() {
        let ratio = b.1 / b.0;
        let denominator = b.0 + b.1 * ratio;
        (
            (a.0 + a.1 * ratio) / denominator,
            (a.1 - a.0 * ratio) / denominator,
        )
    } else {
        let ratio = b.0 / b.1;
        let denominator = b.0 * ratio + b.1;
        (
            (a.0 * ratio + a.1) / denominator,
            (a.1 * ratio - a.0) / denominator,
        )
    }
}

/// `digits * 2^scale` where `digits` is `quotient` rounded: in the subnormal range rounding must happen once only, so
/// there the quotient is cut to the bits that fit before it is converted.
fn scale_exactly(digits: f64, scale: i64, quotient: &BigInt) -> f64 {
    let exponent = quotient.bits() as i64 + scale;
    if exponent > -1021 {
        // The product is normal: multiplying by powers of two is exact.
        let half = scale / 2;
        return digits * 2f64.powi(half as i32) * 2f64.powi((scale - half) as i32);
    }
    let unit = -1074 - scale;
    let whole: BigInt = quotient >> unit;
    let rest = quotient - (&whole << unit);
    let half = BigInt::from(1) << (unit - 1);
    let odd = whole.bit(0);
    let round_up = rest > half || (rest == half && odd);
    let units = crate::value::int::big_to_f64(&if round_up { whole + 1 } else { whole });
    units * f64::from_bits(1)
}

/// The value of a number as a float, integers of any size included; None if it is no real number.
pub fn as_f64(value: &Value) -> Option<f64> {
    match value {
        Value::Float(float) => Some(*float),
        other => Int::of(other).map(|int| int.to_f64()),
    }
}
