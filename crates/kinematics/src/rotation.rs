//! Rotations in the three forms that scripts and files use: matrix, roll-pitch-yaw, rotation vector.
//!
//! Owns the conventions at their borders (gimbal lock, half turns, exact quarter turns). Poses are built on this in
//! [`crate::pose`].

use crate::elementary;
use crate::trig;
use core::f64::consts::{FRAC_PI_2, PI};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

/// Rotations closer to a half turn than this (half of it, as the cosine of half the angle) get the axis sign of the
/// convention.
const HALF_TURN_COSINE: f64 = 1e-10;

/// Cosine of the pitch up to which roll and yaw turn about the same axis.
pub(crate) const GIMBAL_LOCK: f64 = 1e-9;

/// Sine and cosine, exact at multiples of a quarter turn up to two turns.
///
/// `cos(FRAC_PI_2)` is 6e-17 in floating point; robot files mean zero, and the closed-form inverse kinematics checks
/// for it.
pub fn sin_cos_exact(angle_rad: f64) -> (f64, f64) {
    let turns = (angle_rad / FRAC_PI_2).round();
    if turns.abs() <= 8.0 && (angle_rad - turns * FRAC_PI_2).abs() <= 1e-15 * turns.abs() {
        match (turns as i64).rem_euclid(4) {
            0 => (0.0, 1.0),
            1 => (1.0, 0.0),
            2 => (0.0, -1.0),
            _ => (-1.0, 0.0),
        }
    } else {
        elementary::sin_cos(angle_rad)
    }
}

/// R = Rz(yaw) Ry(pitch) Rx(roll) from sines and cosines (manual 3.2.31).
fn matrix_from_sin_cos(
    (sr, cr): (f64, f64),
    (sp, cp): (f64, f64),
    (sy, cy): (f64, f64),
) -> Rotation3<f64> {
    Rotation3::from_matrix_unchecked(Matrix3::new(
        cy * cp,
        cy * sp * sr - sy * cr,
        cy * sp * cr + sy * sr,
        sy * cp,
        sy * sp * sr + cy * cr,
        sy * sp * cr - cy * sr,
        -sp,
        cp * sr,
        cp * cr,
    ))
}

/// The rotation of roll, pitch, yaw about the fixed X, Y, Z axes: R = Rz(yaw) Ry(pitch) Rx(roll) (manual 3.2.31).
pub fn rotation_from_rpy(rpy: [f64; 3]) -> Rotation3<f64> {
    let (s, c) = trig::sin_cos(&rpy);
    matrix_from_sin_cos((s[0], c[0]), (s[1], c[1]), (s[2], c[2]))
}

/// [`rotation_from_rpy`] with exact quarter turns, for numbers that come from robot files.
pub fn rotation_from_rpy_exact(rpy: [f64; 3]) -> Rotation3<f64> {
    matrix_from_sin_cos(
        sin_cos_exact(rpy[0]),
        sin_cos_exact(rpy[1]),
        sin_cos_exact(rpy[2]),
    )
}

/// Roll, pitch, yaw of a rotation: roll and yaw in (-pi, pi], pitch in [-pi/2, pi/2]; at pitch ±pi/2 yaw is 0.
///
/// The manual does not say what the controller does at pitch ±pi/2, so that rule is ours.
pub fn rpy_from_rotation(rotation: &Rotation3<f64>) -> [f64; 3] {
    let m = rotation.matrix();
    let cos_pitch = (m.m11 * m.m11 + m.m21 * m.m21).sqrt();
    // Gimbal lock: only one combination of roll and yaw is determined; all of it goes into roll.
    let locked = cos_pitch <= GIMBAL_LOCK;
    let roll = if locked {
        (-m.m23, m.m22)
    } else {
        (m.m32, m.m33)
    };
    let yaw = if locked { (0.0, 1.0) } else { (m.m21, m.m11) };
    let [roll, pitch, yaw] = trig::atan2(&[roll.0, -m.m31, yaw.0], &[roll.1, cos_pitch, yaw.1]);
    [half_open(roll), pitch + 0.0, half_open(yaw)]
}

/// `atan2` gives -pi where the sine is negative zero; the convention is (-pi, pi]. Also turns -0 into 0.
#[inline(always)]
pub(crate) fn half_open(angle: f64) -> f64 {
    if angle == -PI { PI } else { angle + 0.0 }
}

/// The rotation about the axis `v` by the angle `|v|` in radians.
pub fn rotation_from_rotvec(v: Vector3<f64>) -> Rotation3<f64> {
    Rotation3::new(v)
}

/// Axis times angle in radians; the angle lies in [0, pi]. At a half turn, where both axis directions mean the same,
/// the first component that is not zero is positive (our choice, the manual is silent).
pub fn rotvec_from_rotation(rotation: &Rotation3<f64>) -> Vector3<f64> {
    let q = UnitQuaternion::from_rotation_matrix(rotation);
    let (mut w, mut v) = (q.w, q.imag());
    if w < 0.0 {
        (w, v) = (-w, -v);
    }
    let sine = v.norm();
    if sine == 0.0 {
        return Vector3::zeros();
    }
    if w < HALF_TURN_COSINE {
        let leading = v.iter().copied().find(|x| x.abs() > 1e-9).unwrap_or(0.0);
        let axis = if leading < 0.0 { -v / sine } else { v / sine };
        return axis * PI;
    }
    let [half_angle] = trig::atan2(&[sine], &[w]);
    v * (2.0 * half_angle / sine)
}

/// `angle` moved by whole turns into [-pi, pi).
pub fn wrap_angle(angle: f64) -> f64 {
    if (-PI..PI).contains(&angle) {
        return angle;
    }
    let wrapped = (angle + PI).rem_euclid(2.0 * PI) - PI;
    // Just below -pi the sum rounds to a whole turn.
    if wrapped >= PI { -PI } else { wrapped }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn angle() -> impl Strategy<Value = f64> {
        -7.0..7.0
    }

    fn difference(a: &Rotation3<f64>, b: &Rotation3<f64>) -> f64 {
        (a.matrix() - b.matrix()).abs().max()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(500))]

        #[test]
        fn rpy_there_and_back_is_the_same_rotation(r in angle(), p in angle(), y in angle()) {
            let rotation = rotation_from_rpy([r, p, y]);
            let rpy = rpy_from_rotation(&rotation);
            prop_assert!(rpy[0] > -PI && rpy[0] <= PI && rpy[2] > -PI && rpy[2] <= PI);
            prop_assert!(rpy[1].abs() <= FRAC_PI_2);
            prop_assert!(difference(&rotation, &rotation_from_rpy(rpy)) < 1e-14);
        }

        #[test]
        fn rotation_vector_there_and_back_is_the_same_rotation(r in angle(), p in angle(), y in angle()) {
            let rotation = rotation_from_rpy([r, p, y]);
            let v = rotvec_from_rotation(&rotation);
            prop_assert!(v.norm() <= PI + 1e-15);
            prop_assert!(difference(&rotation, &rotation_from_rotvec(v)) < 1e-9);
        }

        #[test]
        fn wrapped_angles_differ_by_whole_turns(a in -1e3..1e3) {
            let w = wrap_angle(a);
            prop_assert!((-PI..PI).contains(&w));
            let turns = (a - w) / (2.0 * PI);
            prop_assert!((turns - turns.round()).abs() < 1e-12);
        }
    }

    #[test]
    fn gimbal_lock_puts_everything_into_roll() {
        for pitch in [FRAC_PI_2, -FRAC_PI_2] {
            let rotation = rotation_from_rpy([0.3, pitch, 0.4]);
            let rpy = rpy_from_rotation(&rotation);
            assert_eq!(rpy[2], 0.0);
            assert!(difference(&rotation, &rotation_from_rpy(rpy)) < 1e-9);
        }
    }

    #[test]
    fn half_turns_have_a_positive_leading_component() {
        for axis in [
            Vector3::new(-1.0, 0.0, 0.0),
            Vector3::new(0.0, -0.6, 0.8),
            Vector3::new(-0.6, 0.0, 0.8),
        ] {
            let v = rotvec_from_rotation(&rotation_from_rotvec(axis * PI));
            let leading = v.iter().copied().find(|x| x.abs() > 1e-6).unwrap();
            assert!(leading > 0.0, "{axis:?} gave {v:?}");
            assert!((v.norm() - PI).abs() < 1e-15);
        }
    }

    #[test]
    fn quarter_turns_are_exact() {
        for quarter in -8..=8 {
            let (s, c) = sin_cos_exact(f64::from(quarter) * FRAC_PI_2);
            assert!(s * c == 0.0 && s.abs() + c.abs() == 1.0);
        }
        // The vendor's misprint of pi/2 is not taken for one.
        assert_ne!(sin_cos_exact(1.570796326589793).1, 0.0);
    }
}
