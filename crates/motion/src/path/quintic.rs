//! Polynomials of degree five that take over position and first two derivatives at both ends: blends in joint space,
//! and the way between two of many points.
//!
//! Between two lines that meet at an angle, entered and left at equal distances with a length of twice that, the six
//! Bézier points of the curve lie on the two lines short of the corner: the curve cuts the corner inside the triangle
//! and its derivative is nowhere longer than on the lines (Farin, *Curves and Surfaces for CAGD*, 2002, 4.1: convex
//! hull).

use kinematics::{JointAccelerations, JointPositions, JointSpeeds};

use super::PathPoint;
use crate::scalar::ScalarState;
use crate::setpoint::Setpoint;

/// Some polynomials over 0..length, one for each coordinate.
#[derive(Clone, Copy, Debug)]
pub struct Quintic<const N: usize> {
    /// Coefficients of powers 0 to 5 of s, by coordinate.
    coefficients: [[f64; 6]; N],
    length: f64,
}

/// One for each joint.
pub type JointQuintic = Quintic<6>;

/// Positions and all derivatives that are not zero everywhere, by coordinate.
#[derive(Clone, Copy, Debug)]
pub struct QuinticPoint<const N: usize = 6> {
    /// The coordinates; rad for joints.
    pub q: [f64; N],
    /// dq/ds.
    pub dq_ds: [f64; N],
    /// d²q/ds².
    pub d2q_ds2: [f64; N],
    /// d³q/ds³.
    pub d3q_ds3: [f64; N],
    /// d⁴q/ds⁴.
    pub d4q_ds4: [f64; N],
}

/// An end of a curve: coordinates and their first two derivatives with respect to s.
#[derive(Clone, Copy, Debug)]
pub struct QuinticEnd<const N: usize> {
    /// The coordinates.
    pub q: [f64; N],
    /// dq/ds.
    pub first: [f64; N],
    /// d²q/ds².
    pub second: [f64; N],
}

impl From<&PathPoint> for QuinticEnd<6> {
    fn from(point: &PathPoint) -> Self {
        Self {
            q: point.q.0,
            first: point.dq_ds,
            second: point.d2q_ds2,
        }
    }
}

impl<const N: usize> Quintic<N> {
    /// From `start` to `end`, whose derivatives are with respect to the s of this curve.
    pub fn new(start: &QuinticEnd<N>, end: &QuinticEnd<N>, length: f64) -> Self {
        let l = length;
        let coefficients = core::array::from_fn(|k| {
            let (p0, p1) = (start.q[k], end.q[k]);
            // Derivatives with respect to s / length.
            let (v0, v1) = (start.first[k] * l, end.first[k] * l);
            let (a0, a1) = (start.second[k] * l * l, end.second[k] * l * l);
            let way = p1 - p0;
            [
                p0,
                v0 / l,
                a0 / 2.0 / (l * l),
                (10.0 * way - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1) / (l * l * l),
                (-15.0 * way + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1) / (l * l * l * l),
                (6.0 * way - 3.0 * (v0 + v1) - 0.5 * (a0 - a1)) / (l * l * l * l * l),
            ]
        });
        Self {
            coefficients,
            length,
        }
    }

    /// Length in s.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Positions and derivatives at s.
    pub fn point(&self, s: f64) -> QuinticPoint<N> {
        let by_joint = |f: fn(&[f64; 6], f64) -> f64| self.coefficients.map(|c| f(&c, s));
        QuinticPoint {
            q: by_joint(|c, s| c[0] + s * (c[1] + s * (c[2] + s * (c[3] + s * (c[4] + s * c[5]))))),
            dq_ds: by_joint(|c, s| {
                c[1] + s * (2.0 * c[2] + s * (3.0 * c[3] + s * (4.0 * c[4] + s * 5.0 * c[5])))
            }),
            d2q_ds2: by_joint(|c, s| {
                2.0 * c[2] + s * (6.0 * c[3] + s * (12.0 * c[4] + s * 20.0 * c[5]))
            }),
            d3q_ds3: by_joint(|c, s| 6.0 * c[3] + s * (24.0 * c[4] + s * 60.0 * c[5])),
            d4q_ds4: by_joint(|c, s| 24.0 * c[4] + s * 120.0 * c[5]),
        }
    }
}

impl JointQuintic {
    /// From `start` to `end`, whose derivatives are with respect to the s of this curve; their own `s` is not used.
    pub fn between(start: &PathPoint, end: &PathPoint, length: f64) -> Self {
        Self::new(&start.into(), &end.into(), length)
    }

    /// The setpoint at a state of s.
    pub fn at(&self, s: &ScalarState) -> Setpoint {
        let point = self.point(s.position);
        let (v, a) = (s.speed, s.acceleration);
        Setpoint {
            q: JointPositions(point.q),
            qd: JointSpeeds(point.dq_ds.map(|d| d * v)),
            qdd: JointAccelerations(core::array::from_fn(|joint| {
                point.d2q_ds2[joint] * v * v + point.dq_ds[joint] * a
            })),
        }
    }
}
