//! Newton's method on the chain itself, for arms that are only nearly, or not at all, of the closed form's shape.
//!
//! Owns the iteration and its fixed starting points: no randomness, bounded work.

use super::IkSolutions;
use crate::chain::Chain;
use crate::joint::{DOF, JointPositions};
use crate::pose::Pose;
use crate::rotation::{rotvec_from_rotation, wrap_angle};
use core::f64::consts::PI;
use nalgebra::{Matrix6, Vector6};

/// Newton steps before a starting point is given up, about 1 µs each.
const STEPS: usize = 40;
/// Every so many steps the squared error must have shrunk to [`STALLED`] of what it was, or the starting point is given
/// up.
const PATIENCE: usize = 4;
const STALLED: f64 = 0.5;
/// Joint step above which it is shortened, rad.
const STEP_MAX: f64 = 0.5;
/// Remaining error (m and rad) at which a solution counts.
const TOLERANCE: f64 = 1e-11;
/// Two solutions nearer to each other than this (rad) are the same.
const SAME: f64 = 1e-6;

/// Position and rotation still missing from the pose at `q` to the wanted one, base axes.
fn error(wanted: &Pose, reached: &Pose) -> Vector6<f64> {
    let linear = wanted.translation - reached.translation;
    let angular = rotvec_from_rotation(&(wanted.rotation * reached.rotation.inverse()));
    Vector6::new(
        linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
    )
}

/// Damped Newton steps from `start`; `None` if they do not arrive.
pub(super) fn refine(
    chain: &Chain,
    base_from_flange: &Pose,
    start: &JointPositions,
) -> Option<JointPositions> {
    let mut q = *start;
    let mut before = f64::INFINITY;
    for step in 0..STEPS {
        let frames = chain.forward(&q);
        let missing = error(base_from_flange, &frames.base_from_flange);
        if missing.amax() < TOLERANCE {
            return Some(q);
        }
        if step % PATIENCE == PATIENCE - 1 {
            let left = missing.norm_squared();
            if left > STALLED * before {
                return None;
            }
            before = left;
        }
        let jacobian = frames.jacobian(frames.base_from_flange.translation);
        // Levenberg-Marquardt: the damping vanishes with the error, so the last steps are Newton's.
        let damping = 1e-3 * missing.norm_squared();
        let normal = jacobian.transpose() * jacobian + Matrix6::identity() * damping.max(1e-16);
        let step = normal.cholesky()?.solve(&(jacobian.transpose() * missing));
        let scale = (STEP_MAX / step.amax()).min(1.0);
        q = JointPositions::from(q.to_vector() + step * scale);
        if !q.is_finite() {
            return None;
        }
    }
    None
}

fn push_new(found: &mut IkSolutions, q: JointPositions) {
    let q = q.map(wrap_angle);
    let known = found.iter().any(|other| {
        q.iter()
            .zip(other.iter())
            .all(|(a, b)| wrap_angle(a - b).abs() < SAME)
    });
    if !known {
        found.push(q);
    }
}

/// Whether the pose is further away than the chain is long: then no search is needed.
fn is_too_far(chain: &Chain, base_from_flange: &Pose) -> bool {
    let [first, rest @ ..] = &chain.parent_from_joint;
    let length: f64 = rest.iter().map(|pose| pose.translation.norm()).sum();
    let apart = (base_from_flange.translation - first.translation).norm();
    apart > length + chain.joint6_from_flange.translation.norm() + TOLERANCE
}

/// Hands over the solution that each of a fixed set of starting points leads to, one and the same several times.
pub(super) fn search(
    chain: &Chain,
    base_from_flange: &Pose,
    mut visit: impl FnMut(JointPositions),
) {
    /// With 48 the nearest solution was always among them in 900 trials on three arms, with 32 in all but two.
    const STARTS: usize = 64;
    /// Kronecker sequence: fractional parts of multiples of irrational numbers fill the six dimensions evenly.
    const GENERATOR: [f64; DOF] = [
        0.8566748838545029,
        0.733891856627126,
        0.6287067210378087,
        0.5385972572236101,
        0.4614018315691815,
        0.3952762868061936,
    ];
    if is_too_far(chain, base_from_flange) {
        return;
    }
    for index in 1..=STARTS {
        let start =
            JointPositions(GENERATOR.map(|g| ((index as f64 * g).fract() * 2.0 - 1.0) * PI));
        if let Some(q) = refine(chain, base_from_flange, &start) {
            visit(q.map(wrap_angle));
        }
    }
}

/// Solutions reached from a fixed set of starting points; there may be more.
pub(super) fn search_all(chain: &Chain, base_from_flange: &Pose) -> IkSolutions {
    let mut found = IkSolutions::default();
    search(chain, base_from_flange, |q| push_new(&mut found, q));
    found
}
