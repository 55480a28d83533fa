//! Numbers between two bounds.
//!
//! Owns the one way in which the cycle keeps a number within bounds. `f64::clamp` panics when they are crossed or NaN,
//! which small limits and rounding can bring about anywhere; this does not, whatever is given.

/// `value` where it lies between `low` and `high`, otherwise the nearer of them. Crossed bounds leave nothing between
/// them: their middle is as near to both as can be. NaN stays NaN, and a bound that is NaN bounds nothing.
#[inline]
pub fn within(value: f64, low: f64, high: f64) -> f64 {
    if low > high {
        return low / 2.0 + high / 2.0;
    }
    if value < low {
        low
    } else if value > high {
        high
    } else {
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn any_bounds_give_a_number_between_them(
            value in proptest::num::f64::ANY,
            a in proptest::num::f64::ANY,
            b in proptest::num::f64::ANY,
        ) {
            let kept = within(value, a, b);
            if a <= b {
                prop_assert!(value.is_nan() || (a..=b).contains(&kept));
                prop_assert!(value.is_nan() || kept == value.clamp(a, b));
            } else if a > b && (a - b).is_finite() {
                prop_assert!((b..=a).contains(&kept), "{a} {b} {kept}");
            } else if a.is_nan() && b.is_nan() {
                prop_assert!(value.is_nan() || kept == value);
            }
        }
    }
}
