//! Many poses at once: the pose functions of [`crate::script_math`] on rows of six numbers.
//!
//! Owns the layout that vector instructions like: eight poses side by side, each matrix element an array of eight. The
//! arithmetic is that of the functions for one pose, operation by operation, so every row has the same bits.

use crate::rotation::{GIMBAL_LOCK, half_open};
use crate::trig;

/// Poses side by side.
const LANES: usize = 8;

/// One number of each pose.
type Lane = [f64; LANES];

/// Eight rigid transforms: matrix elements row by row, then positions in metres.
///
/// The loops below run over the poses inside and are plain on purpose: closures for each element are not vectorised.
#[derive(Clone, Copy)]
struct Poses {
    rotation: [Lane; 9],
    translation: [Lane; 3],
}

impl Poses {
    const ZERO: Self = Self {
        rotation: [[0.0; LANES]; 9],
        translation: [[0.0; LANES]; 3],
    };

    /// From rows `[x, y, z, Rx, Ry, Rz]`, as [`crate::rotation::rotation_from_rpy`].
    #[inline(always)]
    fn from_rows(rows: &[[f64; 6]; LANES]) -> Self {
        let mut poses = Self::ZERO;
        let mut rpy = [[0.0; LANES]; 3];
        for i in 0..LANES {
            for k in 0..3 {
                poses.translation[k][i] = rows[i][k];
                rpy[k][i] = rows[i][3 + k];
            }
        }
        let (sr, cr) = trig::sin_cos(&rpy[0]);
        let (sp, cp) = trig::sin_cos(&rpy[1]);
        let (sy, cy) = trig::sin_cos(&rpy[2]);
        let m = &mut poses.rotation;
        for i in 0..LANES {
            let (sr, cr, sp, cp, sy, cy) = (sr[i], cr[i], sp[i], cp[i], sy[i], cy[i]);
            m[0][i] = cy * cp;
            m[1][i] = cy * sp * sr - sy * cr;
            m[2][i] = cy * sp * cr + sy * sr;
            m[3][i] = sy * cp;
            m[4][i] = sy * sp * sr + cy * cr;
            m[5][i] = sy * sp * cr - cy * sr;
            m[6][i] = -sp;
            m[7][i] = cp * sr;
            m[8][i] = cp * cr;
        }
        poses
    }

    /// To rows, as [`crate::rotation::rpy_from_rotation`].
    #[inline(always)]
    fn to_rows(self) -> [[f64; 6]; LANES] {
        let m = &self.rotation;
        let (mut y, mut x) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
        for i in 0..LANES {
            let cos_pitch = (m[0][i] * m[0][i] + m[3][i] * m[3][i]).sqrt();
            let locked = cos_pitch <= GIMBAL_LOCK;
            y[0][i] = if locked { -m[5][i] } else { m[7][i] };
            x[0][i] = if locked { m[4][i] } else { m[8][i] };
            y[1][i] = -m[6][i];
            x[1][i] = cos_pitch;
            y[2][i] = if locked { 0.0 } else { m[3][i] };
            x[2][i] = if locked { 1.0 } else { m[0][i] };
        }
        let roll = trig::atan2(&y[0], &x[0]);
        let pitch = trig::atan2(&y[1], &x[1]);
        let yaw = trig::atan2(&y[2], &x[2]);
        let mut rows = [[0.0; 6]; LANES];
        for i in 0..LANES {
            rows[i] = [
                self.translation[0][i],
                self.translation[1][i],
                self.translation[2][i],
                half_open(roll[i]),
                pitch[i] + 0.0,
                half_open(yaw[i]),
            ];
        }
        rows
    }

    /// The inverse rotations with the same positions.
    #[inline(always)]
    fn with_inverse_rotation(&self) -> Self {
        let m = &self.rotation;
        Self {
            rotation: [m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]],
            ..*self
        }
    }

    /// Positions of `other` turned, as [`crate::matrix3::times`].
    #[inline(always)]
    fn rotate(&self, other: &Self) -> [Lane; 3] {
        let (m, v) = (&self.rotation, &other.translation);
        let mut turned = [[0.0; LANES]; 3];
        for i in 0..LANES {
            for row in 0..3 {
                turned[row][i] = m[3 * row][i] * v[0][i]
                    + m[3 * row + 1][i] * v[1][i]
                    + m[3 * row + 2][i] * v[2][i];
            }
        }
        turned
    }

    /// Rotations chained, as [`crate::matrix3::product`].
    #[inline(always)]
    fn chain(&self, other: &Self) -> [Lane; 9] {
        let (a, b) = (&self.rotation, &other.rotation);
        let mut product = [[0.0; LANES]; 9];
        for i in 0..LANES {
            for row in 0..3 {
                let (x, y, z) = (a[3 * row][i], a[3 * row + 1][i], a[3 * row + 2][i]);
                for column in 0..3 {
                    product[3 * row + column][i] =
                        x * b[column][i] + y * b[3 + column][i] + z * b[6 + column][i];
                }
            }
        }
        product
    }
}

/// Sums of positions, the second ones times `sign`.
#[inline(always)]
fn sum(a: &[Lane; 3], b: &[Lane; 3], sign: f64) -> [Lane; 3] {
    let mut sums = *a;
    for (sums, b) in sums.iter_mut().zip(b) {
        for i in 0..LANES {
            sums[i] += sign * b[i];
        }
    }
    sums
}

#[inline(always)]
fn trans(from: &Poses, from_to: &Poses) -> Poses {
    Poses {
        rotation: from.chain(from_to),
        translation: sum(&from.rotate(from_to), &from.translation, 1.0),
    }
}

#[inline(always)]
fn add(first: &Poses, second: &Poses) -> Poses {
    Poses {
        rotation: first.chain(second),
        translation: sum(&first.translation, &second.translation, 1.0),
    }
}

#[inline(always)]
fn sub(to: &Poses, from: &Poses) -> Poses {
    Poses {
        rotation: from.with_inverse_rotation().chain(to),
        translation: sum(&to.translation, &from.translation, -1.0),
    }
}

/// The rows of an argument: one for each result, or one for all of them.
#[derive(Clone, Copy, Debug)]
pub enum Operand<'a> {
    /// One row that serves every result.
    Broadcast(&'a [f64; 6]),
    /// A row for each result.
    PerRow(&'a [[f64; 6]]),
}

impl Operand<'_> {
    /// Eight rows from `start` on; the last one again where they end.
    #[inline(always)]
    fn rows(&self, start: usize) -> [[f64; 6]; LANES] {
        match self {
            Self::Broadcast(row) => [**row; LANES],
            Self::PerRow(rows) => match rows[start..].first_chunk::<LANES>() {
                Some(chunk) => *chunk,
                None => core::array::from_fn(|i| rows[(start + i).min(rows.len() - 1)]),
            },
        }
    }

    fn fits(&self, count: usize) -> bool {
        match self {
            Self::Broadcast(_) => true,
            Self::PerRow(rows) => rows.len() == count,
        }
    }
}

/// Eight rows from two operands to eight results.
#[inline(always)]
fn fill(a: Operand<'_>, b: Operand<'_>, out: &mut [[f64; 6]], f: impl Fn(&Poses, &Poses) -> Poses) {
    let count = out.len();
    assert!(
        a.fits(count) && b.fits(count),
        "{count} results need one row of each operand, or {count}"
    );
    for start in (0..count).step_by(LANES) {
        let (a, b) = (
            Poses::from_rows(&a.rows(start)),
            Poses::from_rows(&b.rows(start)),
        );
        let rows = f(&a, &b).to_rows();
        let end = count.min(start + LANES);
        out[start..end].copy_from_slice(&rows[..end - start]);
    }
}

/// A public function on batches, compiled twice: for any processor, and for those with vectors of four floats.
///
/// The wide version makes the same additions and multiplications one by one (no fused ones), so the bits are the same.
macro_rules! pose_function {
    ($(#[$doc:meta])* $name:ident($a:ident, $b:ident) = $f:ident) => {
        $(#[$doc])*
        ///
        /// # Panics
        /// When an operand has neither one row nor as many as there is room for in `out`.
        pub fn $name($a: Operand<'_>, $b: Operand<'_>, out: &mut [[f64; 6]]) {
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2")]
                fn wide(a: Operand<'_>, b: Operand<'_>, out: &mut [[f64; 6]]) {
                    fill(a, b, out, $f);
                }
                if std::arch::is_x86_feature_detected!("avx2") {
                    // SAFETY: a safe function; all it asks of its caller is a processor with AVX2, found just now.
                    #[allow(unsafe_code)]
                    return unsafe { wide($a, $b, out) };
                }
            }
            fill($a, $b, out, $f);
        }
    };
}

pose_function! {
    /// [`crate::script_math::pose_trans`] of every row (manual 3.2.30).
    pose_trans(p_from, p_from_to) = trans
}
pose_function! {
    /// [`crate::script_math::pose_add`] of every row (manual 3.2.26).
    pose_add(p_1, p_2) = add
}
pose_function! {
    /// [`crate::script_math::pose_sub`] of every row (manual 3.2.29).
    pose_sub(p_to, p_from) = sub
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose::RpyPose;
    use crate::script_math as one;
    use core::f64::consts::FRAC_PI_2;
    use proptest::prelude::*;

    type Many = fn(Operand<'_>, Operand<'_>, &mut [[f64; 6]]);
    type One = fn(&RpyPose, &RpyPose) -> RpyPose;

    fn rows(count: usize) -> impl Strategy<Value = Vec<[f64; 6]>> {
        let angle = prop_oneof![4 => -7.0..7.0, 1 => Just(FRAC_PI_2), 1 => Just(-FRAC_PI_2), 1 => Just(0.0)];
        let pose = (
            prop::array::uniform3(-2.0..2.0),
            prop::array::uniform3(angle),
        )
            .prop_map(|([x, y, z], [a, b, c])| [x, y, z, a, b, c]);
        prop::collection::vec(pose, count)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]

        #[test]
        fn every_row_has_the_bits_of_the_function_for_one_pose(
            (a, b) in (0..40_usize).prop_flat_map(|n| (rows(n), rows(n))), same in rows(1),
        ) {
            let mut out = vec![[0.0; 6]; a.len()];
            let pose = |row: &[f64; 6]| RpyPose::from_array(*row);
            let pairs: [(Many, One); 3] =
                [(pose_trans, one::pose_trans), (pose_add, one::pose_add), (pose_sub, one::pose_sub)];
            for (many, one) in pairs {
                many(Operand::PerRow(&a), Operand::PerRow(&b), &mut out);
                for i in 0..a.len() {
                    prop_assert_eq!(out[i], one(&pose(&a[i]), &pose(&b[i])).to_array());
                }
                many(Operand::Broadcast(&same[0]), Operand::PerRow(&b), &mut out);
                for i in 0..a.len() {
                    prop_assert_eq!(out[i], one(&pose(&same[0]), &pose(&b[i])).to_array());
                }
            }
            // The wide version, where there is one, against the plain one.
            let mut plain = out.clone();
            fill(Operand::Broadcast(&same[0]), Operand::PerRow(&b), &mut plain, sub);
            prop_assert_eq!(out, plain);
        }
    }
}
