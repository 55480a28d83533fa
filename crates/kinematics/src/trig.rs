//! Sine, cosine and arc tangent of several numbers at once, the same bits on every machine.
//!
//! Owns the evaluation used by the kinematics. The C library's versions differ between releases and processors, which
//! would break the promise that a recording can be made again byte for byte; and one at a time they are half of the
//! cost of forward kinematics and most of that of the inverse. Written without branches, so that the compiler can use
//! vector instructions; always inlined, so that callers compiled for wider vectors get them here too.

use crate::elementary;
use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// Beyond this (rad) the reduction loses digits and those for one number take over. Joints turn twice at most.
const RANGE: f64 = 1e5;

/// Adding and subtracting this rounds to the nearest whole number and leaves that number in the low bits.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// pi/2 as a part of 33 bits, so that small multiples of it are exact, and the rest.
const HALF_PI_HEAD: f64 = 1.570_796_326_734_125_6;
const HALF_PI_TAIL: f64 = 6.077_100_506_506_192e-11;

/// What the nearest floats to pi/4, pi/2 and pi lack.
const PI_4_ROUNDING_ERROR: f64 = 3.061_616_997_868_383e-17;
const PI_2_ROUNDING_ERROR: f64 = 6.123_233_995_736_766e-17;
const PI_ROUNDING_ERROR: f64 = 1.224_646_799_147_353_2e-16;

/// Sines and cosines of N angles in radians; the error is below 2e-16.
///
/// Reduction to a quarter turn and polynomials as in fdlibm's `k_sin.c` and `k_cos.c`.
#[inline(always)]
pub fn sin_cos<const N: usize>(angles: &[f64; N]) -> ([f64; N], [f64; N]) {
    let (mut sines, mut cosines) = ([0.0; N], [0.0; N]);
    let mut in_range = true;
    for i in 0..N {
        in_range &= angles[i].abs() <= RANGE;
        (sines[i], cosines[i]) = reduced(angles[i]);
    }
    if !in_range {
        // NaN and infinity get here too, and come out as NaN.
        for i in 0..N {
            if angles[i].abs() > RANGE || angles[i].is_nan() {
                (sines[i], cosines[i]) = elementary::sin_cos(angles[i]);
            }
        }
    }
    (sines, cosines)
}

/// Angles of the N points (x, y) from the positive x axis, in [-pi, pi]; the error is below 5e-16.
///
/// Signs of zeros count as in the standard `atan2`. Infinite coordinates have no angle here, NaN stays NaN.
/// The quotient is reduced to |t| <= tan(pi/8); polynomial as in fdlibm's `s_atan.c`.
#[inline(always)]
pub fn atan2<const N: usize>(y: &[f64; N], x: &[f64; N]) -> [f64; N] {
    let mut angles = [0.0; N];
    for i in 0..N {
        angles[i] = angle_of(y[i], x[i]);
    }
    angles
}

#[inline(always)]
fn angle_of(y: f64, x: f64) -> f64 {
    /// tan(pi/8)
    const REDUCE_ABOVE: f64 = 0.414_213_562_373_095_03;
    let (across, along) = (y.abs(), x.abs());
    // Angle of (large, small), within an eighth of a turn.
    let steep = across > along;
    let (large, small) = if steep {
        (across, along)
    } else {
        (along, across)
    };
    let reduce = small > REDUCE_ABOVE * large;
    let numerator = if reduce { small - large } else { small };
    let denominator = if reduce { small + large } else { large };
    let denominator = if denominator == 0.0 { 1.0 } else { denominator };
    let t = numerator / denominator;

    let z = t * t;
    let w = z * z;
    let even = z
        * (3.333_333_333_333_293e-1
            + w * (1.428_571_427_250_346_6e-1
                + w * (9.090_887_133_436_507e-2
                    + w * (6.661_073_137_387_531e-2
                        + w * (4.976_877_994_615_932e-2 + w * 1.628_582_011_536_578_2e-2)))));
    let odd = w
        * (-1.999_999_999_987_648_3e-1
            + w * (-1.111_111_040_546_235_6e-1
                + w * (-7.691_876_205_044_83e-2
                    + w * (-5.833_570_133_790_573_5e-2 + w * -3.653_157_274_421_691_6e-2))));
    let correction = t * (even + odd);
    let (turn, lacks) = if reduce {
        (FRAC_PI_4, PI_4_ROUNDING_ERROR)
    } else {
        (0.0, 0.0)
    };
    let angle = turn - ((correction - lacks) - t);
    // From the nearest axis to the point's quadrant. The sign bit and not a comparison: minus zero is a half turn away.
    let backward = x.is_sign_negative();
    let (axis, axis_lacks) = if steep {
        (FRAC_PI_2, PI_2_ROUNDING_ERROR)
    } else if backward {
        (PI, PI_ROUNDING_ERROR)
    } else {
        (0.0, 0.0)
    };
    let angle = if steep != backward { -angle } else { angle };
    let angle = axis + (angle + axis_lacks);
    angle.copysign(y)
}

/// `angle` moved by whole turns into [-pi, pi), for angles of a few turns.
#[inline]
pub(crate) fn wrap_few_turns(angle: f64) -> f64 {
    let turns = (angle * (1.0 / TAU) + ROUNDER) - ROUNDER;
    let wrapped = angle - turns * TAU;
    // Half a turn either way is -pi; rounding may leave the half-open range by its last digit.
    if (-PI..PI).contains(&wrapped) {
        wrapped
    } else if wrapped.is_nan() {
        f64::NAN
    } else {
        -PI
    }
}

#[inline(always)]
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
    use proptest::prelude::*;

    fn close(angles: [f64; 6]) {
        let (sines, cosines) = sin_cos(&angles);
        for i in 0..6 {
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
        fn agrees_with_the_standard_functions(a in prop::array::uniform6(-13.0..13.0),
            b in prop::array::uniform6(-2e5..2e5)) {
            close(a);
            close(b);
        }
    }

    #[test]
    fn is_exact_at_zero_and_good_at_quarter_turns() {
        assert_eq!(sin_cos(&[0.0; 6]), ([0.0; 6], [1.0; 6]));
        for k in -20..=20 {
            let x = f64::from(k) * FRAC_PI_2;
            close([x, x.next_up(), x.next_down(), x + 1e-9, x - 1e-9, x / 2.0]);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(3000))]

        #[test]
        fn arc_tangents_agree_with_the_standard_function(
            y in prop::array::uniform4(-2.0..2.0), x in prop::array::uniform4(-2.0..2.0), scale in -80..80_i32,
            flat in -20..0_i32,
        ) {
            let scale = 10_f64.powi(scale);
            let y = y.map(|v| v * scale);
            let x = [x[0] * scale, x[1] * scale, x[2] * scale * 10_f64.powi(flat),
                y[3] * (1.0 + x[3] * 10_f64.powi(flat))];
            let angles = atan2(&y, &x);
            for i in 0..4 {
                let wanted = y[i].atan2(x[i]);
                prop_assert!((angles[i] - wanted).abs() <= 4.5e-16, "{} {}: {} {wanted}", y[i], x[i], angles[i]);
                // Small angles keep their digits.
                prop_assert!((angles[i] / wanted - 1.0).abs() <= 4.5e-16);
            }
        }

        #[test]
        fn a_few_turns_are_wrapped(angle in -40.0..40.0, turns in -6..6_i32) {
            for a in [angle, f64::from(turns) * PI, f64::from(turns) * PI + angle * 1e-15] {
                let wrapped = wrap_few_turns(a);
                prop_assert!((-PI..PI).contains(&wrapped));
                prop_assert!((a.sin() - wrapped.sin()).abs() < 1e-14 && (a.cos() - wrapped.cos()).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn arc_tangents_on_the_axes_are_those_of_the_standard_function() {
        for y in [0.0, -0.0, 1.0, -1.0, 1e-310] {
            for x in [0.0, -0.0, 1.0, -1.0, 1e-310] {
                let [angle] = atan2(&[y], &[x]);
                assert_eq!(angle, f64::atan2(y, x), "{y} {x}");
                assert_eq!(
                    angle.is_sign_negative(),
                    f64::atan2(y, x).is_sign_negative()
                );
            }
        }
        assert!(
            atan2(&[f64::NAN, 1.0], &[1.0, f64::NAN])
                .iter()
                .all(|a| a.is_nan())
        );
    }

    #[test]
    fn numbers_that_are_not_finite_stay_visible() {
        let (sines, _) = sin_cos(&[f64::NAN, f64::INFINITY, 0.5, 0.0, 0.0, 0.0]);
        assert!(sines[0].is_nan() && sines[1].is_nan());
        assert_eq!(sines[2], 0.5_f64.sin());
    }
}
