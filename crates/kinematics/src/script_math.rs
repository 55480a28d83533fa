//! The script's pose and number functions (manual 3.2 and 4.8), under their names there.
//!
//! Owns their meaning, one Rust function per script function; the script builtins and the Python wheel both call these.
//! Poses are metres and roll-pitch-yaw with R = Rz(Rz) Ry(Ry) Rx(Rx). Knows no script values: who calls converts.

use crate::elementary::{self, square};
use crate::pose::{Pose, RpyPose};
use crate::rotation::{
    rotation_from_rotvec, rotation_from_rpy, rotvec_from_rotation, rpy_from_rotation,
};
use crate::wrench::Wrench;
use messages::{Localized, Text, text};
use nalgebra::{Matrix3, Rotation3, Vector3};

/// An argument for which a function has no value.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Localized)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum DomainError {
    #[error("{function}(): {argument} must be {allowed}, got {value}")]
    #[zh("{function}()：{argument} 必须{allowed}，给出的是 {value}")]
    Argument {
        function: &'static str,
        argument: &'static str,
        value: f64,
        allowed: Text,
    },
    #[error("normalize(): invalid parameter, v has length zero and so no direction")]
    #[zh("normalize()：参数无效，v 的长度为零，没有方向")]
    NoDirection,
    #[error("cal_rpy_frame(): {argument} has length zero and so no direction")]
    #[zh("cal_rpy_frame()：{argument} 的长度为零，没有方向")]
    NoAxis { argument: &'static str },
    #[error("cal_rpy_frame(): x_direction and y_direction are parallel, so they span no plane")]
    #[zh("cal_rpy_frame()：x_direction 与 y_direction 平行，不能构成平面")]
    Parallel,
}

/// Directions whose sine is below this count as parallel.
const PARALLEL: f64 = 1e-9;

/// `value` if it is `allowed`; NaN never is.
fn checked(
    function: &'static str,
    argument: &'static str,
    value: f64,
    is_allowed: bool,
    allowed: Text,
) -> Result<f64, DomainError> {
    if is_allowed {
        Ok(value)
    } else {
        Err(DomainError::Argument {
            function,
            argument,
            value,
            allowed,
        })
    }
}

/// Arc cosine in radians (manual 3.2.9).
///
/// # Errors
/// `f` outside [-1, 1].
pub fn acos(f: f64) -> Result<f64, DomainError> {
    checked(
        "acos",
        "f",
        f,
        f.abs() <= 1.0,
        text!("between -1 and 1", "在 -1 与 1 之间"),
    )
    .map(elementary::acos)
}

/// Arc sine in radians (manual 3.2.10).
///
/// # Errors
/// `f` outside [-1, 1].
pub fn asin(f: f64) -> Result<f64, DomainError> {
    checked(
        "asin",
        "f",
        f,
        f.abs() <= 1.0,
        text!("between -1 and 1", "在 -1 与 1 之间"),
    )
    .map(elementary::asin)
}

/// Angle whose tangent is x / y, quadrant from both signs (manual 3.2.12: the first argument is the numerator).
pub fn atan2(x: f64, y: f64) -> f64 {
    elementary::atan2(x, y)
}

/// Degrees to radians (manual 3.2.16).
pub fn d2r(d: f64) -> f64 {
    d.to_radians()
}

/// Radians to degrees (manual 3.2.17).
pub fn r2d(r: f64) -> f64 {
    r.to_degrees()
}

/// Logarithm of `f` to base `b`, base first (manual 3.2.20).
///
/// # Errors
/// `b` or `f` not positive, or `b` = 1 (the manual names negative numbers only; zero and base 1 have no value either).
pub fn log(b: f64, f: f64) -> Result<f64, DomainError> {
    checked(
        "log",
        "b",
        b,
        b > 0.0 && b != 1.0,
        text!("positive and not 1", "为正数且不为 1"),
    )?;
    checked("log", "f", f, f > 0.0, text!("positive", "为正数"))?;
    Ok(elementary::ln(f) / elementary::ln(b))
}

/// Square root (manual 3.2.21).
///
/// # Errors
/// A negative `f`.
pub fn sqrt(f: f64) -> Result<f64, DomainError> {
    checked(
        "sqrt",
        "f",
        f,
        f >= 0.0,
        text!("zero or positive", "为零或正数"),
    )
    .map(f64::sqrt)
}

/// Euclidean length of a vector, a pose taken as six plain numbers (manual 3.2.23).
pub fn norm(a: &[f64]) -> f64 {
    let squares = |scale: f64| a.iter().map(|x| square(x / scale)).fold(0.0, |s, x| s + x);
    let plain: f64 = squares(1.0);
    if plain.is_normal() {
        return plain.sqrt();
    }
    // The squares of very large and very small numbers leave the range of floats; their length need not.
    let largest = a.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    if largest == 0.0 || !largest.is_finite() {
        return plain.sqrt();
    }
    largest * squares(largest).sqrt()
}

/// Divides a vector by its Euclidean length, in place (manual 3.2.24).
///
/// # Errors
/// [`DomainError::NoDirection`] if every entry is 0 or the vector is empty.
pub fn normalize(v: &mut [f64]) -> Result<(), DomainError> {
    // Scaled first, so that very large and very small vectors keep their direction.
    let largest = v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    if largest == 0.0 {
        return Err(DomainError::NoDirection);
    }
    for x in &mut *v {
        *x /= largest;
    }
    let length = norm(v);
    for x in v {
        *x /= length;
    }
    Ok(())
}

/// Bits to a number, the first bit lowest (manual 3.2.5). From 32 bits on, the first 32 are a signed number.
pub fn bit_list_to_integer(l: &[bool]) -> i64 {
    let bits = l
        .iter()
        .take(32)
        .enumerate()
        .fold(0_u32, |bits, (place, &bit)| bits | u32::from(bit) << place);
    if l.len() >= 32 {
        i64::from(bits.cast_signed())
    } else {
        i64::from(bits)
    }
}

/// The low 32 bits of a number in two's complement, lowest first (manual 3.2.6).
pub fn integer_to_bit_list(x: i64) -> [bool; 32] {
    core::array::from_fn(|place| x >> place & 1 == 1)
}

/// Distance of two positions, m; the rotations do not count (manual 3.2.25).
pub fn point_dist(p_from: &RpyPose, p_to: &RpyPose) -> f64 {
    (Vector3::from(p_from.xyz) - Vector3::from(p_to.xyz)).norm()
}

/// Positions added, rotations chained R1 R2 (manual 3.2.26). Unlike [`pose_trans`], `p_2`'s position is not turned.
pub fn pose_add(p_1: &RpyPose, p_2: &RpyPose) -> RpyPose {
    Pose::new(
        rotation_from_rpy(p_1.rpy) * rotation_from_rpy(p_2.rpy),
        Vector3::from(p_1.xyz) + Vector3::from(p_2.xyz),
    )
    .to_rpy()
}

/// Euclidean length of the difference of the six numbers, metres and radians mixed, angles not wrapped (manual 3.2.27;
/// odd, but it is what the manual's example prints).
pub fn pose_dist(p_from: &RpyPose, p_to: &RpyPose) -> f64 {
    let (from, to) = (p_from.to_array(), p_to.to_array());
    from.iter()
        .zip(&to)
        .map(|(a, b)| square(a - b))
        .sum::<f64>()
        .sqrt()
}

/// The inverse transform (manual 3.2.28).
pub fn pose_inv(p_from: &RpyPose) -> RpyPose {
    Pose::from_rpy(p_from).inverse().to_rpy()
}

/// Positions subtracted, rotation from `p_from` to `p_to`: inverse(R_from) R_to (manual 3.2.29).
pub fn pose_sub(p_to: &RpyPose, p_from: &RpyPose) -> RpyPose {
    Pose::new(
        rotation_from_rpy(p_from.rpy).inverse() * rotation_from_rpy(p_to.rpy),
        Vector3::from(p_to.xyz) - Vector3::from(p_from.xyz),
    )
    .to_rpy()
}

/// A pose given in the frame of `p_from`, expressed in the frame `p_from` is given in (manual 3.2.30).
pub fn pose_trans(p_from: &RpyPose, p_from_to: &RpyPose) -> RpyPose {
    (Pose::from_rpy(p_from) * Pose::from_rpy(p_from_to)).to_rpy()
}

/// Rotation vector (axis times angle, rad) to roll, pitch, yaw (manual 3.2.31).
pub fn rotvec2rpy(rotation_vector: [f64; 3]) -> [f64; 3] {
    rpy_from_rotation(&rotation_from_rotvec(Vector3::from(rotation_vector)))
}

/// Roll, pitch, yaw to rotation vector, angle in [0, pi] (manual 3.2.32).
pub fn rpy2rotvec(rpy_vector: [f64; 3]) -> [f64; 3] {
    rotvec_from_rotation(&rotation_from_rpy(rpy_vector)).into()
}

/// Between two poses: straight line for the position, shortest turn for the rotation (manual 3.2.33).
///
/// `alpha` below 0 or above 1 goes on in the same way. The result is in the normal form of roll-pitch-yaw even at 0.
pub fn interpolate_pose(p_from: &RpyPose, p_to: &RpyPose, alpha: f64) -> RpyPose {
    interpolate(&Pose::from_rpy(p_from), &Pose::from_rpy(p_to), alpha).to_rpy()
}

/// [`interpolate_pose`] on transforms.
pub fn interpolate(from: &Pose, to: &Pose, alpha: f64) -> Pose {
    let turn = rotvec_from_rotation(&(from.rotation.inverse() * to.rotation));
    Pose::new(
        from.rotation * rotation_from_rotvec(turn * alpha),
        from.translation + (to.translation - from.translation) * alpha,
    )
}

/// A wrench (force N, moment Nm) through the transform as it stands: F' = R F, M' = R M + t × F' (manual 4.8).
///
/// The manual's words would allow the inverse transform too; its example decides.
pub fn wrench_trans(t_from_to: &RpyPose, w_from: &Wrench) -> Wrench {
    w_from.transformed_by(&Pose::from_rpy(t_from_to))
}

/// The frame at `origin` whose X axis has the first direction and whose Y axis lies on the side of the second, as a
/// pose (from controller output, not from the manual).
///
/// # Errors
/// A direction of length zero, or two that are parallel.
pub fn cal_rpy_frame(
    origin: [f64; 3],
    x_direction: [f64; 3],
    y_direction: [f64; 3],
) -> Result<RpyPose, DomainError> {
    let unit = |argument, mut direction: [f64; 3]| match normalize(&mut direction) {
        Ok(()) => Ok(Vector3::from(direction)),
        Err(_) => Err(DomainError::NoAxis { argument }),
    };
    let x = unit("x_direction", x_direction)?;
    let y = unit("y_direction", y_direction)?;
    let z = x.cross(&y).try_normalize(PARALLEL);
    let z = z.ok_or(DomainError::Parallel)?;
    let axes = Matrix3::from_columns(&[x, z.cross(&x), z]);
    let [rx, ry, rz] = rpy_from_rotation(&Rotation3::from_matrix_unchecked(axes));
    let [px, py, pz] = origin;
    Ok(RpyPose::from_array([px, py, pz, rx, ry, rz]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_has_the_axes_that_its_directions_span() {
        for (x, y) in [
            ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
            ([0.3, -0.4, 0.5], [0.1, 0.9, -0.2]),
            ([0.0, 0.0, -1e-200], [1e200, 0.0, 1e200]),
            ([-2.0, 0.0, 0.0], [0.0, 0.0, 7.0]),
        ] {
            let frame = cal_rpy_frame([1.0, 2.0, 3.0], x, y).unwrap();
            assert_eq!(frame.to_array()[..3], [1.0, 2.0, 3.0]);
            let axes = Pose::from_rpy(&frame).rotation;
            let (mut along, mut side) = (x, y);
            normalize(&mut along).unwrap();
            normalize(&mut side).unwrap();
            let (along, side) = (Vector3::from(along), Vector3::from(side));
            assert!((axes * Vector3::x() - along).norm() < 1e-12, "{x:?} {y:?}");
            assert!((axes * Vector3::y()).dot(&side) > 0.0);
            assert!((axes * Vector3::z()).dot(&side).abs() < 1e-12);
        }
    }

    #[test]
    fn directions_that_span_nothing_are_refused() {
        let frame = |x, y| cal_rpy_frame([0.0; 3], x, y).unwrap_err().to_string();
        let parallel = frame([1.0, 2.0, 3.0], [-2.0, -4.0, -6.0]);
        assert!(parallel.ends_with("are parallel, so they span no plane"));
        for (x, y, argument) in [
            ([0.0; 3], [1.0, 0.0, 0.0], "x_direction"),
            ([1.0, 0.0, 0.0], [0.0; 3], "y_direction"),
        ] {
            assert!(frame(x, y).contains(argument));
        }
    }
}
