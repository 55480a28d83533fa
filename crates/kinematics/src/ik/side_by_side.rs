//! Newton's method from eight places at once, for arms that are nearly of the closed form's shape.
//!
//! Owns the layout that vector instructions like: eight joint positions side by side, each number an array of eight.
//! The loops over the eight are innermost and plain on purpose, see [`crate::batch`]. Places from which eight steps do
//! not arrive are left to [`super::iterative`].

#![expect(
    clippy::needless_range_loop,
    reason = "several arrays of eight are indexed alike"
)]

use super::closed_form::BRANCHES;
use crate::chain::Chain;
use crate::joint::DOF;
use crate::pose::Pose;
use crate::trig;

/// One number of each place.
pub(super) type Lane = [f64; BRANCHES];
/// A vector of each place.
type Vectors = [Lane; 3];

const ZERO: Lane = [0.0; BRANCHES];

/// Remaining error (m and rad) at which the search ends.
const DONE: f64 = 1e-13;
/// Remaining error (m and rad) at which the search ends while joint 6 is held: a coarser one, because the result is
/// only the start of another search.
const DONE_HELD: f64 = 1e-8;
/// Joint step above which it is shortened, rad.
const STEP_MAX: f64 = 0.5;

/// What is missing at each place.
pub(super) struct NewtonResidual {
    /// m and rad, the largest component; without `unreachable_rotation` where joint 6 is held.
    pub(super) error: Lane,
    /// The rotation about the direction across axes 4 and 5, rad: what an arm with parallel axes 4 and 6 cannot make.
    pub(super) unreachable_rotation: Lane,
}

/// Takes the places that are `used` to solutions, in so many steps at most.
///
/// `target` is joint frame 6 in frame 1 at rest, `chain` gives the transforms in between.
pub(super) fn newton(
    chain: &Chain,
    target: &Pose,
    q: &mut [Lane; DOF],
    used: &[bool; BRANCHES],
    steps: usize,
) -> NewtonResidual {
    dispatch::<false>(chain, target, q, used, steps)
}

/// Newton's method with joint 6 held. The rotation that a singular wrist cannot make is left out of the residual and
/// returned in `unreachable_rotation`.
pub(super) fn newton_with_fixed_q6(
    chain: &Chain,
    target: &Pose,
    q: &mut [Lane; DOF],
    used: &[bool; BRANCHES],
    steps: usize,
) -> NewtonResidual {
    dispatch::<true>(chain, target, q, used, steps)
}

/// Compiled twice: for any processor, and for those with vectors of four floats. The bits are the same.
fn dispatch<const HELD: bool>(
    chain: &Chain,
    target: &Pose,
    q: &mut [Lane; DOF],
    used: &[bool; BRANCHES],
    most: usize,
) -> NewtonResidual {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx2")]
        fn wide<const HELD: bool>(
            chain: &Chain,
            target: &Pose,
            q: &mut [Lane; DOF],
            used: &[bool; BRANCHES],
            most: usize,
        ) -> NewtonResidual {
            steps::<HELD>(chain, target, q, used, most)
        }
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: a safe function; all it asks of its caller is a processor with AVX2, found just now.
            #[allow(unsafe_code)]
            return unsafe { wide::<HELD>(chain, target, q, used, most) };
        }
    }
    steps::<HELD>(chain, target, q, used, most)
}

#[inline(always)]
fn steps<const HELD: bool>(
    chain: &Chain,
    target: &Pose,
    q: &mut [Lane; DOF],
    used: &[bool; BRANCHES],
    most: usize,
) -> NewtonResidual {
    let mut places = LaneFrames {
        axes: [[ZERO; 3]; DOF],
        origins: [[ZERO; 3]; DOF],
        rotation: [ZERO; 9],
    };
    let mut left = NewtonResidual {
        error: ZERO,
        unreachable_rotation: ZERO,
    };
    for step in 0..=most {
        places.forward(chain, q);
        let mut missing = places.missing(target);
        let blocked = places.blocked_direction();
        if HELD {
            left.unreachable_rotation = project_out(&mut missing, &blocked);
        }
        let mut worst = 0.0_f64;
        for i in 0..BRANCHES {
            let mut largest = missing[0][i].abs();
            for row in &missing[1..] {
                largest = largest.max(row[i].abs());
            }
            left.error[i] = largest;
            // NaN is left out here; nobody takes it for a solution.
            worst = worst.max(if used[i] { largest } else { 0.0 });
        }
        if worst < if HELD { DONE_HELD } else { DONE } || step == most {
            break;
        }
        let mut columns = places.jacobian();
        if HELD {
            for column in &mut columns[..DOF - 1] {
                project_out(column, &blocked);
            }
            columns[DOF - 1] = [ZERO; DOF];
        }
        let change = solve(&columns, &missing);
        for i in 0..BRANCHES {
            let mut largest = change[0][i].abs();
            for row in &change[1..] {
                largest = largest.max(row[i].abs());
            }
            let scale = if largest > STEP_MAX {
                STEP_MAX / largest
            } else {
                1.0
            };
            for joint in 0..DOF {
                q[joint][i] += scale * change[joint][i];
            }
        }
    }
    // A rotation that is half a turn off looks like none in `error`: the columns must point the same way.
    let wanted = target.rotation.matrix();
    for i in 0..BRANCHES {
        let mut along = 0.0;
        for row in 0..3 {
            for column in 0..3 {
                along += wanted[(row, column)] * places.rotation[3 * row + column][i];
            }
        }
        if along < 2.0 {
            left.error[i] = f64::INFINITY;
        }
    }
    left
}

/// Takes the rotation about `direction` out of twists or errors; back comes what it was.
#[inline(always)]
fn project_out(vector: &mut [Lane; DOF], direction: &Vectors) -> Lane {
    let mut along = ZERO;
    for i in 0..BRANCHES {
        let (x, y, z) = (direction[0][i], direction[1][i], direction[2][i]);
        along[i] = vector[3][i] * x + vector[4][i] * y + vector[5][i] * z;
        vector[3][i] -= along[i] * x;
        vector[4][i] -= along[i] * y;
        vector[5][i] -= along[i] * z;
    }
    along
}

/// Joint axes and origins of the places in frame 1 at rest, and the rotations of joint frame 6, row by row.
struct LaneFrames {
    axes: [Vectors; DOF],
    origins: [Vectors; DOF],
    rotation: [Lane; 9],
}

impl LaneFrames {
    #[inline(always)]
    fn forward(&mut self, chain: &Chain, q: &[Lane; DOF]) {
        let (sines, cosines) = trig::sin_cos(&q[0]);
        for i in 0..BRANCHES {
            self.axes[0][2][i] = 1.0;
            self.rotation[0][i] = cosines[i];
            self.rotation[1][i] = -sines[i];
            self.rotation[3][i] = sines[i];
            self.rotation[4][i] = cosines[i];
            for k in [2, 5, 6, 7] {
                self.rotation[k][i] = 0.0;
            }
            self.rotation[8][i] = 1.0;
        }
        for joint in 1..DOF {
            let (sines, cosines) = trig::sin_cos(&q[joint]);
            let fixed = &chain.parent_from_joint[joint];
            let (f, t) = (fixed.rotation.matrix(), &fixed.translation);
            let (before, after) = self.origins.split_at_mut(joint);
            let (origin, next) = (&before[joint - 1], &mut after[0]);
            let axis = &mut self.axes[joint];
            for row in 0..3 {
                let [first, second, third] = &mut self.rotation[3 * row..3 * row + 3] else {
                    continue;
                };
                let (next, origin, axis) = (&mut next[row], &origin[row], &mut axis[row]);
                for i in 0..BRANCHES {
                    let (x, y, z) = (first[i], second[i], third[i]);
                    next[i] = origin[i] + (x * t.x + y * t.y + z * t.z);
                    let a = x * f.m11 + y * f.m21 + z * f.m31;
                    let b = x * f.m12 + y * f.m22 + z * f.m32;
                    let c = x * f.m13 + y * f.m23 + z * f.m33;
                    first[i] = a * cosines[i] + b * sines[i];
                    second[i] = b * cosines[i] - a * sines[i];
                    third[i] = c;
                    axis[i] = c;
                }
            }
        }
    }

    /// Position and rotation missing to the target; the rotation as the sine of its angle along its axis.
    #[inline(always)]
    fn missing(&self, target: &Pose) -> [Lane; DOF] {
        let (wanted, t) = (target.rotation.matrix(), &target.translation);
        let mut missing = [ZERO; DOF];
        let origin = &self.origins[DOF - 1];
        let r = &self.rotation;
        for i in 0..BRANCHES {
            missing[0][i] = t.x - origin[0][i];
            missing[1][i] = t.y - origin[1][i];
            missing[2][i] = t.z - origin[2][i];
            missing[3][i] = 0.5
                * (r[3][i] * wanted.m31 - r[6][i] * wanted.m21 + r[4][i] * wanted.m32
                    - r[7][i] * wanted.m22
                    + r[5][i] * wanted.m33
                    - r[8][i] * wanted.m23);
            missing[4][i] = 0.5
                * (r[6][i] * wanted.m11 - r[0][i] * wanted.m31 + r[7][i] * wanted.m12
                    - r[1][i] * wanted.m32
                    + r[8][i] * wanted.m13
                    - r[2][i] * wanted.m33);
            missing[5][i] = 0.5
                * (r[0][i] * wanted.m21 - r[3][i] * wanted.m11 + r[1][i] * wanted.m22
                    - r[4][i] * wanted.m12
                    + r[2][i] * wanted.m23
                    - r[5][i] * wanted.m13);
        }
        missing
    }

    /// Across axes 4 and 5, a unit vector.
    #[inline(always)]
    fn blocked_direction(&self) -> Vectors {
        let (a, b) = (&self.axes[3], &self.axes[4]);
        let mut across = [ZERO; 3];
        for i in 0..BRANCHES {
            let x = a[1][i] * b[2][i] - a[2][i] * b[1][i];
            let y = a[2][i] * b[0][i] - a[0][i] * b[2][i];
            let z = a[0][i] * b[1][i] - a[1][i] * b[0][i];
            let scale = 1.0 / (x * x + y * y + z * z).sqrt();
            across[0][i] = x * scale;
            across[1][i] = y * scale;
            across[2][i] = z * scale;
        }
        across
    }

    /// The geometric Jacobian of the origin of joint frame 6, column by column.
    #[inline(always)]
    fn jacobian(&self) -> [[Lane; DOF]; DOF] {
        let mut columns = [[ZERO; DOF]; DOF];
        let end = &self.origins[DOF - 1];
        for ((column, axis), origin) in columns.iter_mut().zip(&self.axes).zip(&self.origins) {
            for i in 0..BRANCHES {
                let (x, y, z) = (
                    end[0][i] - origin[0][i],
                    end[1][i] - origin[1][i],
                    end[2][i] - origin[2][i],
                );
                column[0][i] = axis[1][i] * z - axis[2][i] * y;
                column[1][i] = axis[2][i] * x - axis[0][i] * z;
                column[2][i] = axis[0][i] * y - axis[1][i] * x;
                column[3][i] = axis[0][i];
                column[4][i] = axis[1][i];
                column[5][i] = axis[2][i];
            }
        }
        columns
    }
}

/// The damped step, as in [`super::iterative`]: (JᵀJ + λ) x = Jᵀ e by Cholesky. λ vanishes with the error.
#[inline(always)]
fn solve(columns: &[[Lane; DOF]; DOF], missing: &[Lane; DOF]) -> [Lane; DOF] {
    let mut damping = ZERO;
    for i in 0..BRANCHES {
        let mut squared = 0.0;
        for row in missing {
            squared += row[i] * row[i];
        }
        damping[i] = (1e-3 * squared).max(1e-16);
    }
    // The lower triangle of the factor, the inverse of each diagonal element, and the solution of L y = Jᵀ e.
    let mut lower = [[ZERO; DOF]; DOF];
    let mut inverse = [ZERO; DOF];
    let mut solution = [ZERO; DOF];
    for k in 0..DOF {
        for row in k..DOF {
            let mut sum = dot(&columns[row], &columns[k]);
            for m in 0..k {
                let (a, b) = (lower[row][m], lower[k][m]);
                for i in 0..BRANCHES {
                    sum[i] -= a[i] * b[i];
                }
            }
            if row == k {
                for i in 0..BRANCHES {
                    inverse[k][i] = 1.0 / (sum[i] + damping[i]).sqrt();
                }
            } else {
                for i in 0..BRANCHES {
                    lower[row][k][i] = sum[i] * inverse[k][i];
                }
            }
        }
        let mut sum = dot(&columns[k], missing);
        for m in 0..k {
            let (a, b) = (lower[k][m], solution[m]);
            for i in 0..BRANCHES {
                sum[i] -= a[i] * b[i];
            }
        }
        for i in 0..BRANCHES {
            solution[k][i] = sum[i] * inverse[k][i];
        }
    }
    for k in (0..DOF).rev() {
        let mut sum = solution[k];
        for m in k + 1..DOF {
            let (a, b) = (lower[m][k], solution[m]);
            for i in 0..BRANCHES {
                sum[i] -= a[i] * b[i];
            }
        }
        for i in 0..BRANCHES {
            solution[k][i] = sum[i] * inverse[k][i];
        }
    }
    solution
}

#[inline(always)]
fn dot(a: &[Lane; DOF], b: &[Lane; DOF]) -> Lane {
    let mut sum = ZERO;
    for i in 0..BRANCHES {
        sum[i] = a[0][i] * b[0][i]
            + a[1][i] * b[1][i]
            + a[2][i] * b[2][i]
            + a[3][i] * b[3][i]
            + a[4][i] * b[4][i]
            + a[5][i] * b[5][i];
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RobotModel;

    #[test]
    fn wide_vectors_give_the_same_bits() {
        let arm = RobotModel::built_in("cs66").unwrap();
        let chain = arm.chain();
        let at = crate::JointPositions([0.3, -1.2, 1.9, -0.7, 1.5, 0.2]);
        let target = chain.parent_from_joint[0].inverse() * arm.flange_pose(&at);
        let mut begun = [ZERO; DOF];
        for (joint, lane) in begun.iter_mut().enumerate() {
            for (i, q) in lane.iter_mut().enumerate() {
                *q = at[joint] + 0.03 * (i as f64 - 3.0) * (joint as f64 - 2.2);
            }
        }
        let used = [true; BRANCHES];
        for most in 0..6 {
            let (mut wide, mut plain) = (begun, begun);
            let of_wide = newton(chain, &target, &mut wide, &used, most);
            let of_plain = steps::<false>(chain, &target, &mut plain, &used, most);
            assert_eq!((wide, of_wide.error), (plain, of_plain.error));
            let (mut wide, mut plain) = (begun, begun);
            let of_wide = newton_with_fixed_q6(chain, &target, &mut wide, &used, most);
            let of_plain = steps::<true>(chain, &target, &mut plain, &used, most);
            assert_eq!(
                (wide, of_wide.unreachable_rotation),
                (plain, of_plain.unreachable_rotation)
            );
            assert!(wide[5] == begun[5], "joint 6 is held");
        }
        let left = newton(chain, &target, &mut begun, &used, 12);
        assert!(left.error.iter().all(|missing| *missing < 1e-12));
    }
}
