//! Hashes and equality of builtin values, without running script code.
//!
//! Hashes of numbers and tuples are CPython's (Objects/pyhash.c, tupleobject.c), so that equal numbers of different
//! types hash alike and sets iterate as Python users see them.

use std::rc::Rc;

use num_bigint::{BigInt, Sign};

use crate::limits::chunked::BULK_CHUNK;
use crate::value::Value;
use crate::value::int::Int;
use crate::value::string::hash_bytes;

/// The prime 2^61 - 1 that numeric hashes are taken modulo of.
const MODULUS: u64 = (1 << 61) - 1;
const HASH_BITS: u32 = 61;
const HASH_INFINITY: i64 = 314_159;
const HASH_IMAGINARY: u64 = 1_000_003;

/// Nesting of tuples that is compared and hashed without running script code; deeper ones go through `ops`, which
/// watches the native stack.
const TUPLE_DEPTH_MAX: u32 = 32;
/// Items of tuples that are compared or hashed at once; where there are more, `ops` does it, which lets other threads
/// have their turn. Tuples within tuples many times over may have any number.
pub const QUICK_MAX: u32 = 1000;
/// Most items of two tuples that are compared in place first.
const INLINE_COMPARE_MAX: usize = 8;

/// Takes `items` from what is left; whether that was too much.
fn charge_items(left: &mut u32, items: usize) -> bool {
    let enough = u32::try_from(items)
        .ok()
        .and_then(|items| left.checked_sub(items));
    *left = enough.unwrap_or(0);
    enough.is_none()
}

/// Whether two values are equal, as far as that can be told without script code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Equality {
    Yes,
    No,
    Ask,
}

impl From<bool> for Equality {
    fn from(equal: bool) -> Self {
        if equal { Equality::Yes } else { Equality::No }
    }
}

/// Compares two keys; identical objects are equal, as in Python's containers.
#[inline]
pub fn quick_equal(a: &Value, b: &Value) -> Equality {
    match (a, b) {
        (Value::Str(a), Value::Str(b)) => {
            if Rc::ptr_eq(a, b) {
                return Equality::Yes;
            }
            quick_equal_bytes(a.as_str().as_bytes(), b.as_str().as_bytes())
        }
        (Value::Int(a), Value::Int(b)) => (a == b).into(),
        (Value::Tuple(a), Value::Tuple(b)) if are_same(a.items(), b.items()) => Equality::Yes,
        // A deleted entry of a table equals nothing.
        (Value::Unbound, _) | (_, Value::Unbound) => Equality::No,
        _ => quick_equal_at(a, b, 0, &mut QUICK_MAX.clone()),
    }
}

/// Whether items of tuples are the same texts and integers, one by one. The first that is not ends it.
#[inline]
fn are_same(a: &[Value], b: &[Value]) -> bool {
    let same = |(a, b): (&Value, &Value)| match (a, b) {
        (Value::Int(a), Value::Int(b)) => a == b,
        (Value::Str(a), Value::Str(b)) => Rc::ptr_eq(a, b),
        _ => false,
    };
    std::ptr::eq(a, b)
        || a.len() == b.len() && a.len() <= INLINE_COMPARE_MAX && a.iter().zip(b).all(same)
}

fn quick_equal_at(a: &Value, b: &Value, depth: u32, left: &mut u32) -> Equality {
    if a.is(b) {
        return Equality::Yes;
    }
    match (a, b) {
        (Value::Tuple(x), Value::Tuple(y)) => {
            if x.items().len() != y.items().len() {
                return Equality::No;
            }
            if depth == TUPLE_DEPTH_MAX || charge_items(left, x.items().len()) {
                return Equality::Ask;
            }
            let mut all = Equality::Yes;
            for (x, y) in x.items().iter().zip(y.items()) {
                match quick_equal_at(x, y, depth + 1, left) {
                    Equality::Yes => {}
                    Equality::No if all == Equality::Yes => return Equality::No,
                    _ => all = Equality::Ask,
                }
            }
            all
        }
        (Value::Str(x), Value::Str(y)) => {
            quick_equal_bytes(x.as_str().as_bytes(), y.as_str().as_bytes())
        }
        (Value::Bytes(x), Value::Bytes(y)) => quick_equal_bytes(x.data(), y.data()),
        _ => match (is_atom(a), is_atom(b)) {
            (true, true) => numbers_equal(a, b).unwrap_or(false).into(),
            _ => Equality::Ask,
        },
    }
}

/// Compares bytes, unless they are so many that it is to be done in pieces.
#[inline]
fn quick_equal_bytes(a: &[u8], b: &[u8]) -> Equality {
    match a.len() == b.len() {
        true if a.len() > BULK_CHUNK => Equality::Ask,
        true => (a == b).into(),
        false => Equality::No,
    }
}

/// Values that only equal values of their own kind, or that are numbers.
fn is_atom(value: &Value) -> bool {
    matches!(
        value,
        Value::None
            | Value::Ellipsis
            | Value::NotImplemented
            | Value::Bool(_)
            | Value::Int(_)
            | Value::Float(_)
            | Value::BigInt(_)
            | Value::Complex(_)
            | Value::Str(_)
            | Value::Bytes(_)
            | Value::Tuple(_)
            | Value::Function(_)
            | Value::Class(_)
            | Value::Module(_)
    )
}

/// Equality of two numbers of any types; None if one is no number.
pub fn numbers_equal(a: &Value, b: &Value) -> Option<bool> {
    match (a, b) {
        (Value::Float(a), Value::Float(b)) => Some(a == b),
        (Value::Complex(a), Value::Complex(b)) => Some(**a == **b),
        (Value::Complex(complex), other) | (other, Value::Complex(complex)) => {
            let real = numbers_equal(&Value::Float(complex.0), other)?;
            Some(complex.1 == 0.0 && real)
        }
        (Value::Float(float), other) | (other, Value::Float(float)) => {
            let int = Int::of(other)?;
            Some(int_float_order(&int, *float) == Some(std::cmp::Ordering::Equal))
        }
        _ => match (Int::of(a)?, Int::of(b)?) {
            (Int::Small(a), Int::Small(b)) => Some(a == b),
            (Int::Big(a), Int::Big(b)) => Some(a == b),
            _ => Some(false),
        },
    }
}

/// Exact order of an integer and a float; None for NaN.
pub fn int_float_order(int: &Int, float: f64) -> Option<std::cmp::Ordering> {
    use std::cmp::Ordering;
    if float.is_nan() {
        return None;
    }
    if float.is_infinite() {
        return Some(if float > 0.0 {
            Ordering::Less
        } else {
            Ordering::Greater
        });
    }
    if let Int::Small(small) = int
        && small.unsigned_abs() < 1 << 53
    {
        return (*small as f64).partial_cmp(&float);
    }
    let whole = match crate::value::int::from_f64(float) {
        Value::BigInt(big) => (*big).clone(),
        Value::Int(small) => BigInt::from(small),
        _ => return None,
    };
    let order = int.to_big().cmp(&whole);
    if order != Ordering::Equal {
        return Some(order);
    }
    0.0.partial_cmp(&float.fract())
}

/// The hash of a value that needs no script code: None if it does, or if the value cannot be hashed.
#[inline]
pub fn quick_hash(value: &Value) -> Option<u64> {
    match value {
        Value::Str(text) => quick_hash_of_text(text),
        Value::Int(int) => Some(hash_i64(*int) as u64),
        _ => quick_hash_at(value, 0, &mut QUICK_MAX.clone()),
    }
}

fn quick_hash_at(value: &Value, depth: u32, left: &mut u32) -> Option<u64> {
    Some(match value {
        Value::Str(text) => quick_hash_of_text(text)?,
        Value::Int(int) => hash_i64(*int) as u64,
        Value::Bool(flag) => u64::from(*flag),
        Value::Float(float) => hash_f64(*float) as u64,
        Value::BigInt(big) => hash_big(big) as u64,
        Value::Complex(complex) => hash_complex(complex.0, complex.1),
        Value::None => 0xfca8_6420,
        Value::Ellipsis => 0x5eed_0001,
        Value::NotImplemented => 0x5eed_0002,
        Value::Bytes(bytes) if bytes.data().len() > BULK_CHUNK => return None,
        Value::Bytes(bytes) => hash_bytes(bytes.data()),
        Value::Tuple(tuple) => {
            if let Some(known) = tuple.known_hash() {
                return Some(known);
            }
            if depth == TUPLE_DEPTH_MAX || charge_items(left, tuple.items().len()) {
                return None;
            }
            let mut combine = TupleHash::default();
            for item in tuple.items() {
                combine.add(quick_hash_at(item, depth + 1, left)?);
            }
            let hash = combine.finish();
            tuple.note_hash(hash);
            hash
        }
        Value::Range(range) => range_hash(range),
        Value::LongRange(range) => long_range_hash(range),
        Value::Function(_)
        | Value::Builtin(_)
        | Value::Class(_)
        | Value::Module(_)
        | Value::Generator(_)
        | Value::Iter(_)
        | Value::Property(_)
        | Value::StaticMethod(_)
        | Value::ClassMethod(_)
        | Value::Super(_) => address_hash(value.address()?),
        Value::DictView(view) if view.kind == crate::value::dict::ViewKind::Values => {
            address_hash(value.address()?)
        }
        _ => return None,
    })
}

/// The hash of a text, unless it takes long to compute.
#[inline]
fn quick_hash_of_text(text: &crate::value::Str) -> Option<u64> {
    match text.as_str().len() > BULK_CHUNK {
        true => text.known_hash(),
        false => Some(text.hash()),
    }
}

/// The hash of an object without a value of its own.
pub fn address_hash(address: usize) -> u64 {
    (address as u64).rotate_right(4)
}

fn range_hash(range: &crate::value::Range) -> u64 {
    let mut combine = TupleHash::default();
    let len = range.len();
    let none = quick_hash(&Value::None).unwrap_or(0);
    combine.add(hash_i64(len as i64) as u64);
    combine.add(if len == 0 {
        none
    } else {
        hash_i64(range.start) as u64
    });
    combine.add(if len <= 1 {
        none
    } else {
        hash_i64(range.step) as u64
    });
    combine.finish()
}

fn long_range_hash(range: &crate::value::LongRange) -> u64 {
    let none = quick_hash(&Value::None).unwrap_or(0);
    let number = |number: &BigInt| quick_hash(&Value::bigint(number.clone())).unwrap_or(0);
    let mut combine = TupleHash::default();
    combine.add(number(range.len()));
    combine.add(if range.is_empty() {
        none
    } else {
        number(&range.start)
    });
    combine.add(if *range.len() <= BigInt::from(1) {
        none
    } else {
        number(&range.step)
    });
    combine.finish()
}

/// CPython's hash of tuples (xxHash-based, tupleobject.c).
#[derive(Default)]
pub struct TupleHash {
    accumulator: Option<u64>,
    length: u64,
}

impl TupleHash {
    const PRIME_1: u64 = 11_400_714_785_074_694_791;
    const PRIME_2: u64 = 14_029_467_366_897_019_727;
    const PRIME_5: u64 = 2_870_177_450_012_600_261;

    /// Adds the hash of the next item.
    pub fn add(&mut self, lane: u64) {
        let accumulator = self.accumulator.unwrap_or(Self::PRIME_5);
        let mixed = accumulator
            .wrapping_add(lane.wrapping_mul(Self::PRIME_2))
            .rotate_left(31);
        self.accumulator = Some(mixed.wrapping_mul(Self::PRIME_1));
        self.length += 1;
    }

    /// The hash of the tuple.
    pub fn finish(self) -> u64 {
        let accumulator = self.accumulator.unwrap_or(Self::PRIME_5);
        let hash = accumulator.wrapping_add(self.length ^ (Self::PRIME_5 ^ 3_527_539));
        if hash == u64::MAX {
            1_546_275_796
        } else {
            hash
        }
    }
}

/// Hash of a 64-bit integer.
#[inline]
pub fn hash_i64(int: i64) -> i64 {
    if int.unsigned_abs() < MODULUS {
        return if int == -1 { -2 } else { int };
    }
    let hash = (int.unsigned_abs() % MODULUS) as i64;
    let hash = if int < 0 { -hash } else { hash };
    if hash == -1 { -2 } else { hash }
}

fn hash_big(big: &BigInt) -> i64 {
    let remainder = big.magnitude() % MODULUS;
    let hash = remainder.iter_u64_digits().next().unwrap_or(0) as i64;
    let hash = if big.sign() == Sign::Minus {
        -hash
    } else {
        hash
    };
    if hash == -1 { -2 } else { hash }
}

/// Hash of a float; that of the equal integer if there is one.
pub fn hash_f64(float: f64) -> i64 {
    if float.is_infinite() {
        return if float > 0.0 {
            HASH_INFINITY
        } else {
            -HASH_INFINITY
        };
    }
    if float.is_nan() {
        // CPython uses the object's address; one NaN is as good as another here.
        return 0x7ff8;
    }
    if float.fract() == 0.0 && float.abs() < 9.0e18 {
        return hash_i64(float as i64);
    }
    let (mut mantissa, mut exponent) = frexp(float.abs());
    let mut hash: u64 = 0;
    while mantissa != 0.0 {
        hash = ((hash << 28) & MODULUS) | (hash >> (HASH_BITS - 28));
        mantissa *= 268_435_456.0;
        exponent -= 28;
        let digit = mantissa as u64;
        mantissa -= digit as f64;
        hash += digit;
        if hash >= MODULUS {
            hash -= MODULUS;
        }
    }
    let bits = HASH_BITS as i32;
    let shift = if exponent >= 0 {
        exponent % bits
    } else {
        bits - 1 - ((-1 - exponent) % bits)
    } as u32;
    let hash = ((hash << shift) & MODULUS) | (hash >> (HASH_BITS - shift));
    let signed = if float < 0.0 {
        -(hash as i64)
    } else {
        hash as i64
    };
    if signed == -1 { -2 } else { signed }
}

/// `float = mantissa * 2^exponent` with the mantissa in [0.5, 1); zero, infinity and NaN are their own mantissa.
pub fn frexp(float: f64) -> (f64, i32) {
    if float == 0.0 || !float.is_finite() {
        return (float, 0);
    }
    let bits = float.to_bits();
    let raw = ((bits >> 52) & 0x7ff) as i32;
    if raw == 0 {
        // Subnormal: scale up first.
        let (mantissa, exponent) = frexp(float * 2f64.powi(64));
        return (mantissa, exponent - 64);
    }
    let mantissa = f64::from_bits((bits & !(0x7ff << 52)) | (1022 << 52));
    (mantissa, raw - 1022)
}

fn hash_complex(real: f64, imaginary: f64) -> u64 {
    let hash = (hash_f64(real) as u64)
        .wrapping_add(HASH_IMAGINARY.wrapping_mul(hash_f64(imaginary) as u64));
    if hash == u64::MAX { hash - 1 } else { hash }
}
