//! Rigid transforms: `Pose` for the mathematics, `RpyPose` for the border to scripts and ports.
//!
//! Transforms are named `a_from_b`, so that neighbours cancel when read: `base_from_flange * flange_from_tcp`.

use crate::matrix3::{product, times, transposed_times};
use crate::rotation::{rotation_from_rpy, rpy_from_rotation};
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
    /// The pose of the six numbers `[x, y, z, Rx, Ry, Rz]`, m and rad.
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

    /// The pose with this rotation and this origin, m.
    pub const fn new(rotation: Rotation3<f64>, translation: Vector3<f64>) -> Self {
        Self {
            rotation,
            translation,
        }
    }

    /// A shift without rotation, metres.
    pub fn from_translation(x: f64, y: f64, z: f64) -> Self {
        Self::new(Rotation3::identity(), Vector3::new(x, y, z))
    }

    /// The inverse transform `b_from_a`.
    pub fn inverse(&self) -> Self {
        Self {
            rotation: self.rotation.inverse(),
            translation: -transposed_times(self.rotation.matrix(), &self.translation),
        }
    }

    /// A point given in b, expressed in a.
    #[inline]
    pub fn transform_point(&self, point: Vector3<f64>) -> Vector3<f64> {
        self.rotate(point) + self.translation
    }

    /// A direction given in b, expressed in a.
    #[inline]
    pub fn rotate(&self, direction: Vector3<f64>) -> Vector3<f64> {
        times(self.rotation.matrix(), &direction)
    }

    /// A direction given in a, expressed in b.
    #[inline]
    pub fn rotate_back(&self, direction: Vector3<f64>) -> Vector3<f64> {
        transposed_times(self.rotation.matrix(), &direction)
    }

    /// From roll-pitch-yaw form: R = Rz(yaw) Ry(pitch) Rx(roll).
    pub fn from_rpy(p: &RpyPose) -> Self {
        Self::new(rotation_from_rpy(p.rpy), Vector3::from(p.xyz))
    }

    /// To roll-pitch-yaw form: roll and yaw in (-pi, pi], pitch in [-pi/2, pi/2]; at pitch ±pi/2 yaw is 0.
    pub fn to_rpy(&self) -> RpyPose {
        RpyPose {
            xyz: self.translation.into(),
            rpy: rpy_from_rotation(&self.rotation),
        }
    }
}

impl core::ops::Mul for Pose {
    type Output = Pose;
    /// `a_from_c = a_from_b * b_from_c`.
    #[inline]
    fn mul(self, rhs: Pose) -> Pose {
        Pose {
            rotation: Rotation3::from_matrix_unchecked(product(
                self.rotation.matrix(),
                rhs.rotation.matrix(),
            )),
            translation: self.transform_point(rhs.translation),
        }
    }
}
