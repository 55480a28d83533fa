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
use crate::trig::{atan2, sin_cos, wrap_few_turns};
use core::f64::consts::PI;
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
    /// At a branch border, where two solutions meet, the pair is listed once. The branches are computed side by side,
    /// two shoulders, four wrists, eight elbows, so that the arc tangents come in few calls of many.
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
        let Some(shoulders) = self.shoulders(&shoulder_from_joint6, None) else {
            return found;
        };
        let free = FreeWrist {
            below: SINGULAR_WRIST,
            q6: free_q6,
        };
        let wrists = self.wrists(&shoulder_from_joint6, &shoulders, &free);
        let elbows = self.elbows(&wrists, None);
        for wrist in 0..4 {
            let shoulder = wrist / 2;
            let listed =
                (shoulder == 0 || shoulders.two) && (wrist % 2 == 0 || !wrists.singular[shoulder]);
            if !listed || !elbows.reachable[wrist] {
                continue;
            }
            for elbow in 0..if elbows.two[wrist] { 2 } else { 1 } {
                let at = 2 * wrist + elbow;
                let (q2, q3) = (elbows.q2[at], elbows.q3[at]);
                let q4 = wrists.q234[wrist] - q2 - q3;
                let q1 = shoulders.q1[shoulder];
                found.push(JointPositions(
                    [q1, q2, q3, q4, wrists.q5[wrist], wrists.q6[wrist]].map(wrap_few_turns),
                ));
            }
        }
        found
    }

    /// Joint positions near which a chain that is nearly of this shape may reach a pose of joint frame 6, given in
    /// frame 1 at rest; `None` if there are none. With `free_q6`, wrists within `margin.sine` of the singularity are
    /// put into it, with that joint 6.
    pub(super) fn newton_seeds(
        &self,
        joint1_from_joint6: &Pose,
        margin: &Margin,
        free_q6: Option<f64>,
    ) -> Option<NewtonSeeds> {
        let shoulders = self.shoulders(joint1_from_joint6, Some(margin))?;
        // The nearer the two shoulders are to each other, the more joint 1 turns for a length.
        let mut wrist_margin = margin.sine + margin.length / shoulders.in_plane;
        if shoulders.is_clamped_inside {
            wrist_margin += 2.0 * shoulders.in_plane / self.d4.abs();
        }
        let free = FreeWrist {
            below: free_q6.map_or(SINGULAR_WRIST, |_| wrist_margin),
            q6: free_q6.unwrap_or(0.0),
        };
        let wrists = self.wrists(joint1_from_joint6, &shoulders, &free);
        let elbows = self.elbows(&wrists, Some(margin));
        let mut starts = NewtonSeeds {
            q: [[0.0; BRANCHES]; DOF],
            is_reachable: core::array::from_fn(|branch| elbows.reachable[branch / 2]),
            wrist_is_near: core::array::from_fn(|shoulder| wrists.s5[shoulder] < wrist_margin),
            border_is_near: shoulders.is_clamped_inside || elbows.drawn_back,
        };
        for branch in 0..BRANCHES {
            let (wrist, shoulder) = (branch / 2, branch / 4);
            let (q2, q3) = (elbows.q2[branch], elbows.q3[branch]);
            let q4 = wrists.q234[wrist] - q2 - q3;
            let q1 = shoulders.q1[shoulder];
            let q = [q1, q2, q3, q4, wrists.q5[wrist], wrists.q6[wrist]];
            for (lane, q) in starts.q.iter_mut().zip(q) {
                lane[branch] = q;
            }
        }
        Some(starts)
    }

    /// Both shoulder branches: the plane of the arm passes at distance d4 from the base axis and through w, the
    /// crossing of axes 5 and 6. `None` if w is too near to the base axis.
    #[inline]
    fn shoulders(&self, shoulder_from_joint6: &Pose, margin: Option<&Margin>) -> Option<Shoulders> {
        let z6 = shoulder_from_joint6.rotate(Vector3::z());
        let w = shoulder_from_joint6.translation - z6 * self.d6;
        let rho = (w.x * w.x + w.y * w.y).sqrt();
        let (across, drawn_back) = margin.map_or((rho, false), |margin| {
            margin.clamp_inside(rho, self.d4.abs(), f64::INFINITY)
        });
        // Half of the angle between the branches, seen from the base axis.
        let (sine, cosine) = border_sine(self.d4 / across)?;
        let turn = |sine: f64| {
            let (along, across) = (w.x / rho, w.y / rho);
            (
                cosine * along + sine * across,
                sine * along - cosine * across,
            )
        };
        let (first, second) = (turn(sine), turn(-sine));
        let (s1, c1) = ([first.0, second.0], [first.1, second.1]);
        Some(Shoulders {
            w,
            s1,
            c1,
            q1: atan2(&s1, &c1),
            two: sine != 0.0,
            in_plane: across * sine,
            is_clamped_inside: drawn_back,
        })
    }

    /// Both wrist branches of both shoulders.
    #[inline]
    fn wrists(
        &self,
        shoulder_from_joint6: &Pose,
        shoulders: &Shoulders,
        free: &FreeWrist,
    ) -> Wrists {
        let r = shoulder_from_joint6.rotation.matrix();
        let ([s_free], [c_free]) = sin_cos(&[free.q6]);
        // Numerators and denominators of the arc tangents: q5, q6, q2+q3+q4, two shoulders each.
        let (mut y, mut x) = ([0.0; 6], [0.0; 6]);
        let (mut along, mut singular) = ([0.0; 2], [false; 2]);
        let mut sines5 = [0.0; 2];
        for shoulder in 0..2 {
            let (s1, c1) = (shoulders.s1[shoulder], shoulders.c1[shoulder]);
            // Axes of joint frame 6 in the plane of the arm (x along it, y up) and normal to it. The normal parts are
            // (s5 c6, -s5 s6, c5).
            let (nx, ny, c5) = (
                s1 * r.m11 - c1 * r.m21,
                s1 * r.m12 - c1 * r.m22,
                s1 * r.m13 - c1 * r.m23,
            );
            let (x6, y6, z6) = (
                c1 * r.m11 + s1 * r.m21,
                c1 * r.m12 + s1 * r.m22,
                c1 * r.m13 + s1 * r.m23,
            );
            let s5 = (nx * nx + ny * ny).sqrt();
            sines5[shoulder] = s5;
            singular[shoulder] = s5 < free.below;
            let (s5, s6, c6) = if singular[shoulder] {
                (0.0, s_free, c_free)
            } else {
                (s5, -ny / s5, nx / s5)
            };
            // x axis of joint frame 4; the other wrist branch has q5 negated, q6 half a turn on, and this axis
            // reversed.
            let x4 = c5 * (c6 * x6 - s6 * y6) - s5 * z6;
            let y4 = c5 * (c6 * r.m31 - s6 * r.m32) - s5 * r.m33;
            (y[shoulder], x[shoulder]) = (s5, c5);
            (y[2 + shoulder], x[2 + shoulder]) = (s6, c6);
            (y[4 + shoulder], x[4 + shoulder]) = (y4, x4);
            along[shoulder] = c1 * shoulders.w.x + s1 * shoulders.w.y;
        }
        let angle = atan2(&y, &x);
        let mut wrists = Wrists {
            singular,
            s5: sines5,
            ..Wrists::default()
        };
        for wrist in 0..4 {
            let shoulder = wrist / 2;
            let (sign, half_turn) = if wrist % 2 == 0 {
                (1.0, 0.0)
            } else {
                (-1.0, PI)
            };
            wrists.q5[wrist] = sign * angle[shoulder];
            wrists.q6[wrist] = angle[2 + shoulder] + half_turn;
            wrists.q234[wrist] = angle[4 + shoulder] + half_turn;
            // Joint 5 sits d5 along the z axis of frame 4, which is (y4, -x4) in the plane.
            let (y4, x4) = (y[4 + shoulder], x[4 + shoulder]);
            let scale = sign * self.d5 / (x4 * x4 + y4 * y4).sqrt();
            wrists.joint4_along[wrist] = along[shoulder] - scale * y4;
            wrists.joint4_up[wrist] = shoulders.w.z + scale * x4;
        }
        wrists
    }

    /// Both elbow branches of every wrist: a planar arm of two links that ends where joint frame 4 must be.
    #[inline]
    fn elbows(&self, wrists: &Wrists, margin: Option<&Margin>) -> Elbows {
        let Self { a2, a3, .. } = *self;
        let mut elbows = Elbows::default();
        // Numerators and denominators of the arc tangents: q3, the direction of joint 4, the angle in joint 2 between
        // that and the upper arm.
        let (mut y, mut x) = ([0.0; 12], [0.0; 12]);
        for wrist in 0..4 {
            let (along, up) = (wrists.joint4_along[wrist], wrists.joint4_up[wrist]);
            let squared = along * along + up * up;
            let squared = margin.map_or(squared, |margin| {
                // The nearer axes 4 and 6 are to being parallel, the more joint 4 is moved for an angle.
                let angle = margin.sine / wrists.s5[wrist / 2].max(margin.sine);
                let margin = margin.widened_by(0.25 * self.d5.abs() * angle);
                let (least, most) = ((a2.abs() - a3.abs()).abs(), a2.abs() + a3.abs());
                let (reach, drawn_back) = margin.clamp_inside(squared.sqrt(), least, most);
                elbows.drawn_back |= drawn_back;
                reach * reach
            });
            let cosine = (squared - a2 * a2 - a3 * a3) / (2.0 * a2 * a3);
            let elbow = border_sine(cosine);
            elbows.reachable[wrist] = elbow.is_some();
            let (s3, c3) = elbow.unwrap_or((0.0, 1.0));
            elbows.two[wrist] = s3 != 0.0;
            (y[wrist], x[wrist]) = (s3, c3);
            (y[4 + wrist], x[4 + wrist]) = (up, along);
            (y[8 + wrist], x[8 + wrist]) = (a3 * s3, a2 + a3 * c3);
        }
        let angle = atan2(&y, &x);
        for wrist in 0..4 {
            let (q3, direction, inner) = (angle[wrist], angle[4 + wrist], angle[8 + wrist]);
            (elbows.q3[2 * wrist], elbows.q3[2 * wrist + 1]) = (q3, -q3);
            (elbows.q2[2 * wrist], elbows.q2[2 * wrist + 1]) =
                (direction - inner, direction + inner);
        }
        elbows
    }
}

/// The two shoulder branches.
struct Shoulders {
    /// Crossing of axes 5 and 6, metres.
    w: Vector3<f64>,
    s1: [f64; 2],
    c1: [f64; 2],
    q1: [f64; 2],
    /// False where both are the same.
    two: bool,
    /// Distance of w from the base axis along the plane of the arm, m.
    in_plane: f64,
    /// The branches are where they would be if w were further out.
    is_clamped_inside: bool,
}

/// The four wrist branches, those of one shoulder after the other.
#[derive(Default)]
struct Wrists {
    /// By shoulder: q6 is free and the second branch is the first.
    singular: [bool; 2],
    /// By shoulder: what the pose asks of sin(q5), not negative.
    s5: [f64; 2],
    q5: [f64; 4],
    q6: [f64; 4],
    q234: [f64; 4],
    /// Where joint frame 4 must be in the plane of the arm, metres.
    joint4_along: [f64; 4],
    joint4_up: [f64; 4],
}

/// The eight elbow branches, those of one wrist after the other.
#[derive(Default)]
struct Elbows {
    /// Some are where they would be if joint 4 were further inside what the links reach.
    drawn_back: bool,
    /// By wrist: some elbow reaches the target.
    reachable: [bool; 4],
    /// By wrist: the two elbows differ.
    two: [bool; 4],
    q2: [f64; 8],
    q3: [f64; 8],
}

/// Branches of the closed form: two shoulders, two wrists, two elbows.
pub(super) const BRANCHES: usize = 8;

/// Places to iterate from, side by side.
#[derive(Clone, Copy)]
pub(super) struct NewtonSeeds {
    /// By joint, then by branch: shoulder, wrist, elbow.
    pub(super) q: [[f64; BRANCHES]; DOF],
    /// By branch: the target is within reach.
    pub(super) is_reachable: [bool; BRANCHES],
    /// By shoulder: axes 4 and 6 are nearly parallel.
    pub(super) wrist_is_near: [bool; 2],
    /// Two branches nearly meet, or just do not.
    pub(super) border_is_near: bool,
}

/// How far the borders of an arm may be from those of the form, where two of its branches meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Margin {
    /// For elbows and shoulders: of the distances reached, m.
    pub(super) length: f64,
    /// How far inside the border places are put that are nearer to it than `length`, or beyond it by less, m.
    pub(super) inside: f64,
    /// Margin of the sine of joint 5, for wrists.
    pub(super) sine: f64,
}

impl Margin {
    fn widened_by(&self, length: f64) -> Self {
        let scale = (self.length + length) / self.length;
        Self {
            length: self.length * scale,
            inside: self.inside * scale,
            ..*self
        }
    }

    /// A distance that must lie between `least` and `most`, taken inside where it is near a border; left alone further
    /// out. True when it was taken.
    #[inline]
    fn clamp_inside(&self, distance: f64, least: f64, most: f64) -> (f64, bool) {
        if distance < least + self.length && distance > least - self.length {
            (least + self.inside, true)
        } else if distance > most - self.length && distance < most + self.length {
            (most - self.inside, true)
        } else {
            (distance, false)
        }
    }
}

/// When joint 6 is chosen instead of computed.
struct FreeWrist {
    /// Below this sin(q5), which is taken for zero then.
    below: f64,
    /// The choice, rad.
    q6: f64,
}

/// Sine and cosine of an arc cosine that takes a cosine just beyond ±1 for ±1; `None` further out and for NaN.
#[inline]
fn border_sine(cosine: f64) -> Option<(f64, f64)> {
    (cosine.abs() <= 1.0 + BORDER).then(|| {
        let cosine = cosine.clamp(-1.0, 1.0);
        (((1.0 - cosine) * (1.0 + cosine)).sqrt(), cosine)
    })
}
