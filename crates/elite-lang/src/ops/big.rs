//! Long operations on integers of any size, in pieces between which other script threads have their turn: products,
//! quotients, powers, roots, greatest common divisors. What is short goes straight to the library of big integers.

use num_bigint::{BigInt, BigUint, Sign};

use crate::eval::Evaluator;
use crate::value::R;

/// Digits of 32 bits in a piece that is multiplied at once.
const PRODUCT_CHUNK: usize = if cfg!(debug_assertions) { 1024 } else { 4096 };
/// Digits of a factor that is so short that nothing is gained by halving it.
const KARATSUBA_MIN: usize = 64;
/// Products of two digits that are done at once in a division, or with a short factor.
const INLINE_PRODUCTS_MAX: usize = if cfg!(debug_assertions) {
    1 << 18
} else {
    1 << 22
};

impl Evaluator<'_> {
    /// `a * b`
    pub fn big_product(&self, a: &BigInt, b: &BigInt) -> R<BigInt> {
        let magnitude = self.product(a.magnitude(), b.magnitude())?;
        Ok(with_sign(a.sign() != b.sign(), magnitude))
    }

    fn product(&self, a: &BigUint, b: &BigUint) -> R<BigUint> {
        let (longer, shorter) = (digits(a).max(digits(b)), digits(a).min(digits(b)));
        if at_once(longer, shorter) {
            self.charge(longer * shorter.min(256))?;
            return Ok(a * b);
        }
        self.product_of_digits(&a.to_u32_digits(), &b.to_u32_digits())
    }

    fn product_of_digits(&self, a: &[u32], b: &[u32]) -> R<BigUint> {
        let (longer, shorter) = if a.len() < b.len() { (b, a) } else { (a, b) };
        if at_once(longer.len(), shorter.len()) {
            self.charge(longer.len() * shorter.len().min(256))?;
            return Ok(BigUint::from_slice(longer) * BigUint::from_slice(shorter));
        }
        if shorter.len() * 2 <= longer.len() {
            // Pieces at least as long as the shorter factor; each product is added in its place.
            let piece = shorter.len().max(PRODUCT_CHUNK);
            let mut sum = vec![0; longer.len() + shorter.len()];
            for (number, part) in longer.chunks(piece).enumerate() {
                let product = self.product_of_digits(part, shorter)?.to_u32_digits();
                add_digits(&mut sum[number * piece..], &product);
                self.charge(product.len())?;
            }
            return Ok(BigUint::new(sum));
        }
        // Karatsuba: three products of half the length.
        let half = longer.len() / 2;
        let (low_a, high_a) = longer.split_at(half);
        let (low_b, high_b) = shorter.split_at(half);
        let low = self.product_of_digits(low_a, low_b)?;
        let high = self.product_of_digits(high_a, high_b)?;
        let sum_a = BigUint::from_slice(low_a) + BigUint::from_slice(high_a);
        let sum_b = BigUint::from_slice(low_b) + BigUint::from_slice(high_b);
        let middle = self.product(&sum_a, &sum_b)? - &low - &high;
        Ok((high << (64 * half)) + (middle << (32 * half)) + low)
    }

    /// Floor quotient and remainder with Python's signs. `b` is not 0.
    pub fn big_divmod(&self, a: &BigInt, b: &BigInt) -> R<(BigInt, BigInt)> {
        let (quotient, remainder) = self.quotient(a.magnitude(), b.magnitude())?;
        let quotient = with_sign(a.sign() != b.sign(), quotient);
        let remainder = with_sign(a.sign() == Sign::Minus, remainder);
        let adjust = remainder.sign() != Sign::NoSign && remainder.sign() != b.sign();
        Ok(if adjust {
            (quotient - 1, remainder + b)
        } else {
            (quotient, remainder)
        })
    }

    /// The remainder alone.
    pub fn big_remainder(&self, a: &BigInt, b: &BigInt) -> R<BigInt> {
        let (longer, shorter) = (digits(a.magnitude()), digits(b.magnitude()));
        let work = longer.saturating_sub(shorter).saturating_mul(shorter);
        if work > INLINE_PRODUCTS_MAX {
            return Ok(self.big_divmod(a, b)?.1);
        }
        self.charge(longer + work / 4)?;
        let remainder = with_sign(a.sign() == Sign::Minus, a.magnitude() % b.magnitude());
        let adjust = remainder.sign() != Sign::NoSign && remainder.sign() != b.sign();
        Ok(if adjust { remainder + b } else { remainder })
    }

    fn quotient(&self, a: &BigUint, b: &BigUint) -> R<(BigUint, BigUint)> {
        let (longer, shorter) = (digits(a), digits(b));
        let work = longer.saturating_sub(shorter).saturating_mul(shorter);
        if work <= INLINE_PRODUCTS_MAX {
            self.charge(longer + work / 4)?;
            let quotient = a / b;
            let remainder = a - &quotient * b;
            return Ok((quotient, remainder));
        }
        // Long division, some digits at a time.
        let piece = (INLINE_PRODUCTS_MAX / shorter).max(1);
        let mut remainder = BigUint::ZERO;
        let mut found: Vec<u32> = Vec::with_capacity(longer);
        for part in a.to_u32_digits().rchunks_exact_from_top(piece) {
            remainder = (remainder << (32 * part.len())) + BigUint::from_slice(part);
            let quotient = &remainder / b;
            remainder -= &quotient * b;
            self.charge(shorter + part.len() * shorter / 4)?;
            let mut places = quotient.to_u32_digits();
            places.resize(part.len(), 0);
            found.extend(places.iter().rev());
        }
        found.reverse();
        Ok((BigUint::new(found), remainder))
    }

    /// `base ** exponent`; the result's bits have been checked.
    pub fn big_power(&self, base: &BigInt, exponent: u64) -> R<BigInt> {
        let zeros = base.trailing_zeros().unwrap_or(0);
        let odd: BigUint = base.magnitude() >> zeros;
        let mut power = BigUint::from(1u8);
        for place in (0..u64::BITS - exponent.leading_zeros()).rev() {
            power = self.product(&power, &power)?;
            if exponent >> place & 1 == 1 {
                power = self.product(&power, &odd)?;
            }
        }
        let negative = base.sign() == Sign::Minus && exponent & 1 == 1;
        Ok(with_sign(negative, power << (zeros * exponent)))
    }

    /// `base ** exponent % modulus`, with the sign of the modulus; the exponent is not negative, the modulus not 0.
    pub fn big_power_modulo(
        &self,
        base: &BigInt,
        exponent: &BigInt,
        modulus: &BigInt,
    ) -> R<BigInt> {
        let size = digits(modulus.magnitude());
        let whole = (exponent.bits() as usize).saturating_mul(size.saturating_mul(size));
        if whole <= INLINE_PRODUCTS_MAX {
            self.charge(whole + digits(base.magnitude()) * size / 4)?;
            return Ok(base.modpow(exponent, modulus));
        }
        let positive = BigInt::from(modulus.magnitude().clone());
        let (_, base) = self.big_divmod(base, &positive)?;
        let mut power = BigInt::from(1);
        for place in (0..exponent.bits()).rev() {
            power = self.big_product(&power, &power)?;
            (_, power) = self.big_divmod(&power, &positive)?;
            if exponent.magnitude().bit(place) {
                power = self.big_product(&power, &base)?;
                (_, power) = self.big_divmod(&power, &positive)?;
            }
        }
        Ok(self.big_divmod(&power, modulus)?.1)
    }

    /// The number between 0 and `modulus` whose product with `a` leaves 1; None if there is none.
    pub fn big_inverse(&self, a: &BigInt, modulus: &BigInt) -> R<Option<BigInt>> {
        let positive = BigInt::from(modulus.magnitude().clone());
        let (mut before, mut after) = (positive.clone(), self.big_divmod(a, &positive)?.1);
        let (mut factor_before, mut factor) = (BigInt::ZERO, BigInt::from(1));
        while after != BigInt::ZERO {
            let (quotient, rest) = self.big_divmod(&before, &after)?;
            (before, after) = (after, rest);
            let next = factor_before - self.big_product(&quotient, &factor)?;
            (factor_before, factor) = (factor, next);
        }
        if before != BigInt::from(1) {
            return Ok(None);
        }
        Ok(Some(self.big_divmod(&factor_before, modulus)?.1))
    }

    /// The greatest common divisor, not negative (Lehmer: many small quotients at once from the leading bits).
    pub fn big_gcd(&self, a: &BigInt, b: &BigInt) -> R<BigInt> {
        let (mut a, mut b) = (a.magnitude().clone(), b.magnitude().clone());
        if a < b {
            std::mem::swap(&mut a, &mut b);
        }
        while b.bits() > 64 {
            self.charge(4 * digits(&a))?;
            match leading_quotients(&a, &b) {
                Some([p, q, r, s]) => {
                    let combine = |p: i64, q: i64| (signed(p, &a) + signed(q, &b)).into_parts().1;
                    (a, b) = (combine(p, q), combine(r, s));
                }
                None => {
                    let (_, rest) = self.quotient(&a, &b)?;
                    (a, b) = (b, rest);
                }
            }
        }
        let last = |number: &BigUint| number.iter_u64_digits().next().unwrap_or(0);
        if b == BigUint::ZERO {
            return Ok(a.into());
        }
        let (mut x, mut y) = (last(&b), last(&(a % &b)));
        while y != 0 {
            (x, y) = (y, x % y);
        }
        Ok(BigInt::from(x))
    }

    /// The root of a number that is not negative, rounded down. Each step doubles the bits that are known.
    pub fn big_root(&self, number: &BigInt) -> R<BigInt> {
        let number = number.magnitude();
        if number.bits() <= 2 * 32 * KARATSUBA_MIN as u64 {
            return Ok(number.sqrt().into());
        }
        let half = (number.bits() - 1) / 2;
        let mut root = BigUint::from(1u8);
        let mut known = 0;
        for place in (0..u64::BITS - half.leading_zeros()).rev() {
            let wanted = half >> place;
            let top: BigUint = number >> (2 * half + 1 - known - wanted);
            let (quotient, _) = self.quotient(&top, &root)?;
            root = (root << (wanted - known).saturating_sub(1)) + quotient;
            known = wanted;
        }
        if self.product(&root, &root)? > *number {
            root -= 1u8;
        }
        Ok(root.into())
    }
}

/// Pieces of digits from the most significant on; the first one may be shorter.
trait HighDigitsFirst {
    fn rchunks_exact_from_top(&self, size: usize) -> impl Iterator<Item = &[u32]>;
}

impl HighDigitsFirst for [u32] {
    fn rchunks_exact_from_top(&self, size: usize) -> impl Iterator<Item = &[u32]> {
        self.chunks(size).rev()
    }
}

/// Whether a product of so many digits is left to the library.
fn at_once(longer: usize, shorter: usize) -> bool {
    longer <= PRODUCT_CHUNK
        || shorter <= KARATSUBA_MIN && longer.saturating_mul(shorter) <= INLINE_PRODUCTS_MAX
}

/// Adds digits to others, from the least significant on; the sum has room there.
fn add_digits(sum: &mut [u32], more: &[u32]) {
    let mut more = more.iter();
    let mut carry = 0;
    for place in sum {
        let digit = more.next();
        if digit.is_none() && carry == 0 {
            return;
        }
        let whole = u64::from(*place) + u64::from(digit.copied().unwrap_or(0)) + carry;
        *place = whole as u32;
        carry = whole >> 32;
    }
}

/// Number of 32-bit digits.
fn digits(number: &BigUint) -> usize {
    number.bits().div_ceil(32) as usize
}

fn with_sign(negative: bool, magnitude: BigUint) -> BigInt {
    let sign = if negative { Sign::Minus } else { Sign::Plus };
    BigInt::from_biguint(sign, magnitude)
}

fn signed(factor: i64, number: &BigUint) -> BigInt {
    with_sign(factor < 0, number * factor.unsigned_abs())
}

/// What the Euclidean steps that the leading bits of `a >= b` tell for certain make of them: the new `a` is
/// `p a + q b`, the new `b` is `r a + s b`. None if they tell of no step.
fn leading_quotients(a: &BigUint, b: &BigUint) -> Option<[i64; 4]> {
    let shift = a.bits().saturating_sub(62);
    let top = |number: &BigUint| -> i128 {
        let top: BigUint = number >> shift;
        top.iter_u64_digits().next().unwrap_or(0).into()
    };
    let (mut x, mut y) = (top(a), top(b));
    let (mut p, mut q, mut r, mut s) = (1i128, 0i128, 0i128, 1i128);
    // The true quotient lies between those of the bounds of the leading parts.
    while y + r != 0 && y + s != 0 {
        let quotient = (x + p) / (y + r);
        if quotient != (x + q) / (y + s) {
            break;
        }
        (p, r) = (r, p - quotient * r);
        (q, s) = (s, q - quotient * s);
        (x, y) = (y, x - quotient * y);
    }
    let factor = |value: i128| i64::try_from(value).ok();
    let factors = [factor(p)?, factor(q)?, factor(r)?, factor(s)?];
    (q != 0).then_some(factors)
}
