//! Rigid transforms: `Pose` for the mathematics, `RpyPose` for the border to scripts and ports.

use nalgebra::{Matrix3, Rotation3, Vector3};

/// A pose as scripts write it: metres, then roll, pitch, yaw about the fixed X, Y, Z axes in radians,
/// R = Rz(yaw) Ry(pitch) Rx(roll) (manual 3.2.31).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RpyPose {
    /// Position x, y, z in metres.
    pub xyz: [f64; 3],
    /// Roll, pitch, yaw (Rx, Ry, Rz) in radians.
    pub rpy: [f64; 3],
}

impl RpyPose {
    /// From the six numbers `[x, y, z, Rx, Ry, Rz]`.
    pub const fn from_array(v: [f64; 6]) -> Self {
        Self {
            xyz: [v[0], v[1], v[2]],
            rpy: [v[3], v[4], v[5]],
        }
    }

    /// The six numbers `[x, y, z, Rx, Ry, Rz]`.
    pub const fn to_array(self) -> [f64; 6] {
        [
            self.xyz[0],
            self.xyz[1],
            self.xyz[2],
            self.rpy[0],
            self.rpy[1],
            self.rpy[2],
        ]
    }

    /// True when no component is NaN or infinite.
    pub fn is_finite(&self) -> bool {
        self.to_array().iter().all(|x| x.is_finite())
    }
}

/// A rigid transform `a_from_b`: a rotation and the origin of b in a, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Rotation of frame b expressed in frame a.
    pub rotation: Rotation3<f64>,
    /// Origin of frame b in frame a, metres.
    pub translation: Vector3<f64>,
}

impl Default for Pose {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Pose {
    /// The transform that changes nothing.
    pub const IDENTITY: Self = Self {
        rotation: Rotation3::from_matrix_unchecked(Matrix3::new(
            1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0,
        )),
        translation: Vector3::new(0.0, 0.0, 0.0),
    };

    /// The inverse transform `b_from_a`.
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.inverse();
        Self {
            rotation,
            translation: -(rotation * self.translation),
        }
    }

    /// From roll-pitch-yaw form: R = Rz(yaw) Ry(pitch) Rx(roll).
    pub fn from_rpy(p: &RpyPose) -> Self {
        let ((sr, cr), (sp, cp), (sy, cy)) =
            (p.rpy[0].sin_cos(), p.rpy[1].sin_cos(), p.rpy[2].sin_cos());
        let m = Matrix3::new(
            cy * cp,
            cy * sp * sr - sy * cr,
            cy * sp * cr + sy * sr,
            sy * cp,
            sy * sp * sr + cy * cr,
            sy * sp * cr - cy * sr,
            -sp,
            cp * sr,
            cp * cr,
        );
        Self {
            rotation: Rotation3::from_matrix_unchecked(m),
            translation: Vector3::from(p.xyz),
        }
    }

    /// To roll-pitch-yaw form: roll and yaw in (-pi, pi], pitch in [-pi/2, pi/2]; at pitch ±pi/2 yaw is 0.
    pub fn to_rpy(&self) -> RpyPose {
        let m = self.rotation.matrix();
        let cos_pitch = m[(0, 0)].hypot(m[(1, 0)]);
        let pitch = (-m[(2, 0)]).atan2(cos_pitch);
        let (roll, yaw) = if cos_pitch > 1e-9 {
            (m[(2, 1)].atan2(m[(2, 2)]), m[(1, 0)].atan2(m[(0, 0)]))
        } else {
            // Gimbal lock: only roll -/+ yaw is determined; the convention puts all of it into roll.
            ((-m[(1, 2)]).atan2(m[(1, 1)]), 0.0)
        };
        RpyPose {
            xyz: self.translation.into(),
            rpy: [roll, pitch, yaw],
        }
    }
}

impl core::ops::Mul for Pose {
    type Output = Pose;
    /// `a_from_c = a_from_b * b_from_c`.
    fn mul(self, rhs: Pose) -> Pose {
        Pose {
            rotation: self.rotation * rhs.rotation,
            translation: self.rotation * rhs.translation + self.translation,
        }
    }
}
