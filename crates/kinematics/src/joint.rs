//! Joint-space quantities: one type each for positions, speeds, accelerations, jerks and torques.
//!
//! They are plain six-vectors (base joint first), kept apart by type because mixing them up moves the arm.

use core::ops::{Index, IndexMut};
use nalgebra::Vector6;

/// Number of joints of every supported arm.
pub const DOF: usize = 6;

macro_rules! joint_quantity {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        #[repr(transparent)]
        pub struct $name(pub [f64; DOF]);

        impl $name {
            /// All six components zero.
            pub const ZERO: Self = Self([0.0; DOF]);

            /// The six components, base joint first.
            pub const fn to_array(self) -> [f64; DOF] {
                self.0
            }

            /// The six numbers in a column for matrix algebra.
            pub fn to_vector(self) -> Vector6<f64> {
                Vector6::from(self.0)
            }

            /// The components in joint order.
            pub fn iter(&self) -> core::slice::Iter<'_, f64> {
                self.0.iter()
            }

            /// True when no component is NaN or infinite.
            pub fn is_finite(&self) -> bool {
                self.0.iter().fold(true, |all, x| all & x.is_finite())
            }

            /// Whether both have the same numbers to the last bit, signs of zeros and NaN included: then whatever
            /// follows from one follows from the other.
            pub fn has_bits_of(&self, other: &Self) -> bool {
                let differing = |bits: u64, k: usize| bits | (self.0[k].to_bits() ^ other.0[k].to_bits());
                (0..DOF).fold(0, differing) == 0
            }

            /// Applies `f` to every component.
            pub fn map(self, f: impl FnMut(f64) -> f64) -> Self {
                Self(self.0.map(f))
            }

            /// The largest absolute component.
            pub fn max_abs(&self) -> f64 {
                self.0.iter().fold(0.0, |m, x| m.max(x.abs()))
            }
        }

        impl From<Vector6<f64>> for $name {
            fn from(column: Vector6<f64>) -> Self {
                Self(column.into())
            }
        }

        impl From<[f64; DOF]> for $name {
            fn from(values: [f64; DOF]) -> Self {
                Self(values)
            }
        }

        impl Index<usize> for $name {
            type Output = f64;
            fn index(&self, joint: usize) -> &f64 {
                &self.0[joint]
            }
        }

        impl IndexMut<usize> for $name {
            fn index_mut(&mut self, joint: usize) -> &mut f64 {
                &mut self.0[joint]
            }
        }
    };
}

joint_quantity! {
    /// Positions of the six joints in radians, base first.
    JointPositions
}
joint_quantity! {
    /// Speeds of the six joints in rad/s, base first.
    JointSpeeds
}
joint_quantity! {
    /// Accelerations of the six joints in rad/s², base first.
    JointAccelerations
}
joint_quantity! {
    /// Jerks of the six joints in rad/s³, base first.
    JointJerks
}
joint_quantity! {
    /// Torques at the six joints in Nm, base first.
    JointTorques
}

impl JointPositions {
    /// Sum of the squared differences of the six joints, rad².
    pub fn distance_squared(&self, other: &Self) -> f64 {
        self.iter()
            .zip(other.iter())
            .map(|(a, b)| (a - b) * (a - b))
            .sum()
    }
}
