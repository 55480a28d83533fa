//! Twists (velocities of a frame) and wrenches (forces on a frame), linear part first.

use nalgebra::Vector3;

/// Velocity of a frame: linear m/s, then angular rad/s. The frame it is expressed in is said where it is used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist {
    /// Linear velocity, m/s.
    pub linear: Vector3<f64>,
    /// Angular velocity, rad/s.
    pub angular: Vector3<f64>,
}

impl Twist {
    /// `[vx, vy, vz, wx, wy, wz]`.
    pub fn to_array(self) -> [f64; 6] {
        let (l, a) = (self.linear, self.angular);
        [l.x, l.y, l.z, a.x, a.y, a.z]
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
    /// `[Fx, Fy, Fz, Mx, My, Mz]`.
    pub fn to_array(self) -> [f64; 6] {
        let (f, m) = (self.force, self.moment);
        [f.x, f.y, f.z, m.x, m.y, m.z]
    }
}
