//! Products of 3×3 matrices and 3-vectors, written out.
//!
//! Owns nothing but speed: nalgebra's general product takes about five times as long at this size, and a control cycle
//! makes hundreds of them.

use nalgebra::{Matrix3, Vector3};

/// `m * v`.
#[inline]
pub(crate) fn times(m: &Matrix3<f64>, v: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(
        m.m11 * v.x + m.m12 * v.y + m.m13 * v.z,
        m.m21 * v.x + m.m22 * v.y + m.m23 * v.z,
        m.m31 * v.x + m.m32 * v.y + m.m33 * v.z,
    )
}

/// `mᵀ * v`.
#[inline]
pub(crate) fn transposed_times(m: &Matrix3<f64>, v: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(
        m.m11 * v.x + m.m21 * v.y + m.m31 * v.z,
        m.m12 * v.x + m.m22 * v.y + m.m32 * v.z,
        m.m13 * v.x + m.m23 * v.y + m.m33 * v.z,
    )
}

/// `a * b`.
#[inline]
pub(crate) fn product(a: &Matrix3<f64>, b: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::new(
        a.m11 * b.m11 + a.m12 * b.m21 + a.m13 * b.m31,
        a.m11 * b.m12 + a.m12 * b.m22 + a.m13 * b.m32,
        a.m11 * b.m13 + a.m12 * b.m23 + a.m13 * b.m33,
        a.m21 * b.m11 + a.m22 * b.m21 + a.m23 * b.m31,
        a.m21 * b.m12 + a.m22 * b.m22 + a.m23 * b.m32,
        a.m21 * b.m13 + a.m22 * b.m23 + a.m23 * b.m33,
        a.m31 * b.m11 + a.m32 * b.m21 + a.m33 * b.m31,
        a.m31 * b.m12 + a.m32 * b.m22 + a.m33 * b.m32,
        a.m31 * b.m13 + a.m32 * b.m23 + a.m33 * b.m33,
    )
}

/// `m * Rz(angle)`: the first two columns turn into each other.
#[inline]
pub(crate) fn turned_about_z(m: &Matrix3<f64>, sine: f64, cosine: f64) -> Matrix3<f64> {
    Matrix3::new(
        m.m11 * cosine + m.m12 * sine,
        m.m12 * cosine - m.m11 * sine,
        m.m13,
        m.m21 * cosine + m.m22 * sine,
        m.m22 * cosine - m.m21 * sine,
        m.m23,
        m.m31 * cosine + m.m32 * sine,
        m.m32 * cosine - m.m31 * sine,
        m.m33,
    )
}
