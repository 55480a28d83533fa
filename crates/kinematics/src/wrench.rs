//! Twists (velocities of a frame) and wrenches (forces on a frame), linear part first.

use crate::pose::Pose;
use nalgebra::{Vector3, Vector6};

/// Velocity of a frame: linear m/s, then angular rad/s. The frame it is expressed in is said where it is used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist {
    /// Linear velocity, m/s.
    pub linear: Vector3<f64>,
    /// Angular velocity, rad/s.
    pub angular: Vector3<f64>,
}

impl Twist {
    /// The twist of the six numbers `[vx, vy, vz, wx, wy, wz]`, m/s and rad/s.
    pub const fn from_array(v: [f64; 6]) -> Self {
        Self {
            linear: Vector3::new(v[0], v[1], v[2]),
            angular: Vector3::new(v[3], v[4], v[5]),
        }
    }

    /// Whether all six numbers are zero.
    pub fn is_zero(&self) -> bool {
        self.to_array() == [0.0; 6]
    }

    /// `[vx, vy, vz, wx, wy, wz]`.
    pub fn to_array(self) -> [f64; 6] {
        let (l, a) = (self.linear, self.angular);
        [l.x, l.y, l.z, a.x, a.y, a.z]
    }

    /// The twist in six numbers, linear velocity (m/s) before angular (rad/s).
    pub fn to_vector(self) -> Vector6<f64> {
        Vector6::from(self.to_array())
    }
}

impl From<Vector6<f64>> for Twist {
    fn from(v: Vector6<f64>) -> Self {
        Self::from_array(v.into())
    }
}

/// A force and a moment: newtons, then newton metres. Reference point and frame are said where it is used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wrench {
    /// Force, N.
    pub force: Vector3<f64>,
    /// Moment, Nm.
    pub moment: Vector3<f64>,
}

impl Wrench {
    /// The wrench of the six numbers `[Fx, Fy, Fz, Mx, My, Mz]`, N and Nm.
    pub const fn from_array(v: [f64; 6]) -> Self {
        Self {
            force: Vector3::new(v[0], v[1], v[2]),
            moment: Vector3::new(v[3], v[4], v[5]),
        }
    }

    /// True when there is neither force nor moment.
    pub fn is_zero(&self) -> bool {
        self.to_array()
            .iter()
            .fold(true, |all, x| all & (*x == 0.0))
    }

    /// `[Fx, Fy, Fz, Mx, My, Mz]`.
    pub fn to_array(self) -> [f64; 6] {
        let (f, m) = (self.force, self.moment);
        [f.x, f.y, f.z, m.x, m.y, m.z]
    }

    /// The wrench in six numbers, force (N) before moment (Nm).
    pub fn to_vector(self) -> Vector6<f64> {
        Vector6::from(self.to_array())
    }

    /// A wrench given in frame b about its origin, expressed in frame a about the origin of a:
    /// F_a = R F_b, M_a = R M_b + t × F_a.
    pub fn transformed_by(self, a_from_b: &Pose) -> Self {
        let force = a_from_b.rotate(self.force);
        Self {
            force,
            moment: a_from_b.rotate(self.moment) + a_from_b.translation.cross(&force),
        }
    }
}

impl From<Vector6<f64>> for Wrench {
    fn from(v: Vector6<f64>) -> Self {
        Self::from_array(v.into())
    }
}
