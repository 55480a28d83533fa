//! The closed-form inverse of arms whose axes 2, 3, 4 are parallel and whose axes 4-5 and 5-6 cross at right angles.
//!
//! Owns the extraction of the six lengths from a chain and the solution itself. The wrist is offset (no common point of
//! axes 4, 5, 6), so the position cannot be solved apart from the orientation: shoulder first, then wrist, then elbow.
//! The derivation is that of Hawkins, *Analytic Inverse Kinematics for the Universal Robots UR-5/UR-10 Arms*, 2013,
//! with the wrist angle taken from the orientation, where it is well conditioned, instead of an arc cosine.

use super::IkSolutions;
use crate::chain::Chain;
use crate::joint::{DOF, JointPositions};
use crate::pose::Pose;
use crate::rotation::wrap_angle;
use core::f64::consts::{FRAC_PI_2, PI};
use nalgebra::{Matrix3, Rotation3, Vector3};

/// Deviation (m, or element of a rotation matrix) up to which a chain is of the closed form's shape.
pub(super) const EXACT: f64 = 1e-12;

/// Deviation up to which the closed form is a good starting point for iteration.
pub(super) const NEARBY: f64 = 0.02;

/// A cosine this far beyond 1 is rounding at the border of the work space; further out there is no solution.
const BORDER: f64 = 1e-9;

/// sin(q5) below this counts as a singular wrist: axes 4 and 6 are parallel and q6 is free.
const SINGULAR_WRIST: f64 = 1e-10;

/// The lengths of the closed form, in the symbols of the standard Denavit-Hartenberg table, metres. d1 is part of
/// the first fixed transform, which may be any.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosedForm {
    /// Upper arm, negative in the CS arms.
    pub a2: f64,
    /// Forearm, negative in the CS arms.
    pub a3: f64,
    /// Distance of the wrist from the plane of the base axis.
    pub d4: f64,
    /// From the crossing of axes 4 and 5 to that of axes 5 and 6.
    pub d5: f64,
    /// From the crossing of axes 5 and 6 to joint frame 6.
    pub d6: f64,
}

/// Quarter turn about x, positive or negative.
fn quarter_about_x(sign: f64) -> Rotation3<f64> {
    Rotation3::from_matrix_unchecked(Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, -sign, 0.0, sign, 0.0))
}

impl ClosedForm {
    /// The form nearest to a chain and how far the chain is from it (m and rotation matrix elements alike); `None` when
    /// a length that is divided by is zero.
    pub fn nearest(chain: &Chain) -> Option<(Self, f64)> {
        let origin = |joint: usize| chain.parent_from_joint[joint].translation;
        let form = Self {
            a2: origin(2).x,
            a3: origin(3).x,
            d4: origin(2).z + origin(3).z,
            d5: -origin(4).y,
            d6: origin(5).y,
        };
        if form.a2 == 0.0 || form.a3 == 0.0 {
            return None;
        }
        let shape = form.transforms();
        let deviation = (1..DOF)
            .map(|joint| {
                let (is, should) = (&chain.parent_from_joint[joint], &shape[joint]);
                let turned = (is.rotation.matrix() - should.rotation.matrix()).amax();
                // Axes 2, 3, 4 are parallel: where along them the offset d4 lies makes no difference to the flange.
                let mut shifted = is.translation - should.translation;
                if joint == 2 || joint == 3 {
                    shifted.z = 0.0;
                }
                turned.max(shifted.amax())
            })
            .fold(0.0, f64::max);
        Some((form, deviation))
    }

    /// The fixed transforms 2 to 6 of this form, d4 at joint 4; the first is left open.
    fn transforms(&self) -> [Pose; DOF] {
        let plain = Rotation3::identity();
        [
            Pose::IDENTITY,
            Pose::new(quarter_about_x(1.0), Vector3::zeros()),
            Pose::new(plain, Vector3::new(self.a2, 0.0, 0.0)),
            Pose::new(plain, Vector3::new(self.a3, 0.0, self.d4)),
            Pose::new(quarter_about_x(1.0), Vector3::new(0.0, -self.d5, 0.0)),
            Pose::new(quarter_about_x(-1.0), Vector3::new(0.0, self.d6, 0.0)),
        ]
    }

    /// All solutions for a flange pose, joint 6 taken as `free_q6` (wrapped) where the wrist is singular.
    ///
    /// At a branch border, where two solutions meet, the pair is listed once.
    pub(super) fn solve(
        &self,
        chain: &Chain,
        base_from_flange: &Pose,
        free_q6: f64,
    ) -> IkSolutions {
        let shoulder_from_joint6 = chain.parent_from_joint[0].inverse()
            * *base_from_flange
            * chain.joint6_from_flange.inverse();
        let mut found = IkSolutions::default();
        // w: crossing of axes 5 and 6. The plane of the arm passes at distance d4 from the base axis.
        let z6 = shoulder_from_joint6.rotation * Vector3::z();
        let w = shoulder_from_joint6.translation - z6 * self.d6;
        let rho = w.x.hypot(w.y);
        let Some(shoulder) = border_acos(self.d4 / rho) else {
            return found;
        };
        let middle = w.y.atan2(w.x) + FRAC_PI_2;
        self.wrists(
            &mut found,
            &shoulder_from_joint6,
            &w,
            middle - shoulder,
            free_q6,
        );
        if shoulder != 0.0 {
            self.wrists(
                &mut found,
                &shoulder_from_joint6,
                &w,
                middle + shoulder,
                free_q6,
            );
        }
        found
    }

    /// Both wrist branches of one shoulder branch.
    fn wrists(
        &self,
        found: &mut IkSolutions,
        shoulder_from_joint6: &Pose,
        w: &Vector3<f64>,
        q1: f64,
        free_q6: f64,
    ) {
        let (s1, c1) = q1.sin_cos();
        // Axes of joint frame 6 in the plane of the arm (x along it, y up) and normal to it. The normal parts are
        // (s5 c6, -s5 s6, c5).
        let r = shoulder_from_joint6.rotation.matrix();
        let normal = |column: usize| s1 * r[(0, column)] - c1 * r[(1, column)];
        let in_plane = |column: usize| (c1 * r[(0, column)] + s1 * r[(1, column)], r[(2, column)]);
        let (x6, y6, z6) = (in_plane(0), in_plane(1), in_plane(2));
        let (nx, ny, c5) = (normal(0), normal(1), normal(2));
        let wrist = (c1 * w.x + s1 * w.y, w.z);
        let s5 = nx.hypot(ny);

        let singular = s5 < SINGULAR_WRIST;
        let (q6, s6, c6) = if singular {
            let (s6, c6) = free_q6.sin_cos();
            (wrap_angle(free_q6), s6, c6)
        } else {
            ((-ny).atan2(nx), -ny / s5, nx / s5)
        };
        let s5 = if singular { 0.0 } else { s5 };
        // x axis of joint frame 4; the other wrist branch has q5 negated, q6 half a turn on, and this axis reversed.
        let x4 = (
            c5 * (c6 * x6.0 - s6 * y6.0) - s5 * z6.0,
            c5 * (c6 * x6.1 - s6 * y6.1) - s5 * z6.1,
        );
        let length = x4.0.hypot(x4.1);
        let x4 = (x4.0 / length, x4.1 / length);
        let q5 = s5.atan2(c5);

        self.elbows(found, q1, q5, q6, x4, wrist);
        if !singular {
            self.elbows(found, q1, -q5, q6 + PI, (-x4.0, -x4.1), wrist);
        }
    }

    /// Both elbow branches of one wrist branch: a planar arm of two links that ends where joint frame 4 must be.
    fn elbows(
        &self,
        found: &mut IkSolutions,
        q1: f64,
        q5: f64,
        q6: f64,
        x4: (f64, f64),
        wrist: (f64, f64),
    ) {
        let Self { a2, a3, d5, .. } = *self;
        let q234 = x4.1.atan2(x4.0);
        // Joint 5 sits d5 along the z axis of frame 4, which is (x4.1, -x4.0) in the plane.
        let (x, y) = (wrist.0 - d5 * x4.1, wrist.1 + d5 * x4.0);
        let Some(q3) = border_acos((x * x + y * y - a2 * a2 - a3 * a3) / (2.0 * a2 * a3)) else {
            return;
        };
        let (s3, c3) = q3.sin_cos();
        let direction = y.atan2(x);
        let inner = (a3 * s3).atan2(a2 + a3 * c3);
        let mut push = |q3: f64, q2: f64| {
            found.push(JointPositions(
                [q1, q2, q3, q234 - q2 - q3, q5, q6].map(wrap_angle),
            ));
        };
        push(q3, direction - inner);
        if s3 != 0.0 && q3 < PI {
            push(-q3, direction + inner);
        }
    }
}

/// Arc cosine that takes a cosine just beyond ±1 for ±1; `None` further out and for NaN.
fn border_acos(cosine: f64) -> Option<f64> {
    (cosine.abs() <= 1.0 + BORDER).then(|| cosine.clamp(-1.0, 1.0).acos())
}
