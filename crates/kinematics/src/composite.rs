//! Mass properties about the origin of a frame, in which bodies that are held rigid are put together.
//!
//! Owns the ten numbers and how they go from a joint's frame to its parent's. Bodies are joined by adding the numbers,
//! where [`RigidBody`] with its inertia about the centre of mass needs the parallel axis theorem twice; a cycle does it
//! six times.

use crate::matrix3::product;
use crate::payload::RigidBody;
use crate::pose::Pose;
use nalgebra::{Matrix3, Vector3};

/// A rigid body by mass, first moment and inertia about the frame's origin (Featherstone, 2008, section 2.13).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Composite {
    /// Mass, kg.
    mass: f64,
    /// Mass times the centre of mass, kg m.
    moment: Vector3<f64>,
    /// The inertia tensor about the origin, kg m².
    inertia: Inertia,
}

/// A symmetric tensor.
#[derive(Clone, Copy, Debug, Default)]
struct Inertia {
    xx: f64,
    yy: f64,
    zz: f64,
    xy: f64,
    xz: f64,
    yz: f64,
}

impl From<&RigidBody> for Composite {
    fn from(body: &RigidBody) -> Self {
        let about_origin = body.inertia_about(Vector3::zeros());
        Self {
            mass: body.mass,
            moment: body.com * body.mass,
            inertia: Inertia {
                xx: about_origin.m11,
                yy: about_origin.m22,
                zz: about_origin.m33,
                xy: about_origin.m12,
                xz: about_origin.m13,
                yz: about_origin.m23,
            },
        }
    }
}

impl Composite {
    /// Force, and moment about the origin, that accelerate the body about the frame's z axis by 1 rad/s².
    #[inline]
    pub(crate) fn wrench_for_z_acceleration(&self) -> (Vector3<f64>, Vector3<f64>) {
        let (h, i) = (&self.moment, &self.inertia);
        (Vector3::new(-h.y, h.x, 0.0), Vector3::new(i.xz, i.yz, i.zz))
    }

    /// The two held to each other, both given in the same frame.
    #[inline]
    pub(crate) fn joined_with(&self, other: &Self) -> Self {
        let (i, o) = (&self.inertia, &other.inertia);
        Self {
            mass: self.mass + other.mass,
            moment: self.moment + other.moment,
            inertia: Inertia {
                xx: i.xx + o.xx,
                yy: i.yy + o.yy,
                zz: i.zz + o.zz,
                xy: i.xy + o.xy,
                xz: i.xz + o.xz,
                yz: i.yz + o.yz,
            },
        }
    }

    /// This body about the parent's origin, in the parent's axes.
    #[inline]
    pub(crate) fn in_parent(&self, parent_from_child: &Pose) -> Self {
        let r = parent_from_child.rotation.matrix();
        let p = &parent_from_child.translation;
        let i = &self.inertia;
        let own = Matrix3::new(i.xx, i.xy, i.xz, i.xy, i.yy, i.yz, i.xz, i.yz, i.zz);
        let half = product(r, &own);
        let turned = |row: usize, column: usize| {
            half[(row, 0)] * r[(column, 0)]
                + half[(row, 1)] * r[(column, 1)]
                + half[(row, 2)] * r[(column, 2)]
        };
        let h = parent_from_child.rotate(self.moment);
        // With every point at p + y: |p + y|² 1 - (p + y)(p + y)ᵀ, summed over the mass.
        let moved = h * 2.0 + p * self.mass;
        let square = p.dot(&moved);
        let mixed = |a: usize, b: usize| p[a] * h[b] + h[a] * p[b] + self.mass * p[a] * p[b];
        Self {
            mass: self.mass,
            moment: h + p * self.mass,
            inertia: Inertia {
                xx: turned(0, 0) + square - mixed(0, 0),
                yy: turned(1, 1) + square - mixed(1, 1),
                zz: turned(2, 2) + square - mixed(2, 2),
                xy: turned(0, 1) - mixed(0, 1),
                xz: turned(0, 2) - mixed(0, 2),
                yz: turned(1, 2) - mixed(1, 2),
            },
        }
    }
}
