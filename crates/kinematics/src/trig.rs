//! Sine and cosine of six angles at once, the same bits on every machine.
//!
//! Owns the evaluation used by the kinematics. The C library's versions differ between releases and processors, which
//! would break the promise that a recording can be made again byte for byte; and one at a time they are half of the
//! cost of forward kinematics. Written without branches, so that the compiler can use vector instructions.

use crate::joint::DOF;

/// Beyond this (rad) the reduction loses digits and the standard functions take over. Joints turn twice at most.
const RANGE: f64 = 1e5;

/// Adding and subtracting this rounds to the nearest whole number and leaves that number in the low bits.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// pi/2 as a part of 33 bits, so that small multiples of it are exact, and the rest.
const HALF_PI_HEAD: f64 = 1.570_796_326_734_125_6;
const HALF_PI_TAIL: f64 = 6.077_100_506_506_192e-11;

/// Sines and cosines of six angles in radians; the error is below 2e-16.
///
/// Reduction to a quarter turn and polynomials as in fdlibm's `k_sin.c` and `k_cos.c`.
#[inline]
pub fn sin_cos(angles: &[f64; DOF]) -> ([f64; DOF], [f64; DOF]) {
    let (mut sines, mut cosines) = ([0.0; DOF], [0.0; DOF]);
    let mut in_range = true;
    for i in 0..DOF {
        in_range &= angles[i].abs() <= RANGE;
        (sines[i], cosines[i]) = reduced(angles[i]);
    }
    if !in_range {
        // Also reached for NaN and infinity, which come out as NaN.
        for i in 0..DOF {
            (sines[i], cosines[i]) = angles[i].sin_cos();
        }
    }
    (sines, cosines)
}

#[inline]
fn reduced(angle: f64) -> (f64, f64) {
    let shifted = angle * core::f64::consts::FRAC_2_PI + ROUNDER;
    let quarters = shifted - ROUNDER;
    let quadrant = shifted.to_bits();
    let head = angle - quarters * HALF_PI_HEAD;
    let tail = quarters * HALF_PI_TAIL;
    let x = head - tail;
    let rest = (head - x) - tail;

    let z = x * x;
    let sine = {
        let p = 8.333_333_333_322_49e-3
            + z * (-1.984_126_982_985_795e-4
                + z * (2.755_731_370_707_006_8e-6
                    + z * (-2.505_076_025_340_686_3e-8 + z * 1.589_690_995_211_55e-10)));
        let v = z * x;
        x - ((z * (0.5 * rest - v * p) - rest) + v * 1.666_666_666_666_663_2e-1)
    };
    let cosine = {
        let p = z
            * (4.166_666_666_666_66e-2
                + z * (-1.388_888_888_887_411e-3
                    + z * (2.480_158_728_947_673e-5
                        + z * (-2.755_731_435_139_066_3e-7
                            + z * (2.087_572_321_298_175e-9 + z * -1.135_964_755_778_819_5e-11)))));
        let half = 0.5 * z;
        let w = 1.0 - half;
        w + (((1.0 - w) - half) + (z * p - x * rest))
    };
    // Odd quadrants swap the two; the sign bit comes from bit 1 of the quadrant (of the next one for the cosine).
    let odd = (quadrant & 1).wrapping_neg();
    let (s, c) = (sine.to_bits(), cosine.to_bits());
    let swapped = (s ^ c) & odd;
    (
        f64::from_bits(s ^ swapped ^ (quadrant >> 1 & 1) << 63),
        f64::from_bits(c ^ swapped ^ (quadrant.wrapping_add(1) >> 1 & 1) << 63),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::FRAC_PI_2;
    use proptest::prelude::*;

    fn close(angles: [f64; DOF]) {
        let (sines, cosines) = sin_cos(&angles);
        for i in 0..DOF {
            let (s, c) = angles[i].sin_cos();
            assert!(
                (sines[i] - s).abs() <= 2.3e-16,
                "sin({}) {} {s}",
                angles[i],
                sines[i]
            );
            assert!(
                (cosines[i] - c).abs() <= 2.3e-16,
                "cos({}) {} {c}",
                angles[i],
                cosines[i]
            );
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn agrees_with_the_standard_functions(a in prop::array::uniform6(-13.0..13.0), b in prop::array::uniform6(-2e5..2e5)) {
            close(a);
            close(b);
        }
    }

    #[test]
    fn is_exact_at_zero_and_good_at_quarter_turns() {
        assert_eq!(sin_cos(&[0.0; DOF]), ([0.0; DOF], [1.0; DOF]));
        for k in -20..=20 {
            let x = f64::from(k) * FRAC_PI_2;
            close([x, x.next_up(), x.next_down(), x + 1e-9, x - 1e-9, x / 2.0]);
        }
    }

    #[test]
    fn numbers_that_are_not_finite_stay_visible() {
        let (sines, _) = sin_cos(&[f64::NAN, f64::INFINITY, 0.5, 0.0, 0.0, 0.0]);
        assert!(sines[0].is_nan() && sines[1].is_nan());
        assert_eq!(sines[2], 0.5_f64.sin());
    }
}
