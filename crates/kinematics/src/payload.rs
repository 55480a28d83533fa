//! What the flange carries, and the mass properties of one rigid body.

use crate::matrix3::product;
use crate::pose::Pose;
use messages::Localized;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// Mass properties of one rigid body in some frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RigidBody {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass, m.
    pub com: Vector3<f64>,
    /// Inertia tensor about the centre of mass in the frame's axes, kg m².
    pub inertia: Matrix3<f64>,
}

impl RigidBody {
    /// This body described in frame a instead of frame b.
    pub fn expressed_in(&self, a_from_b: &Pose) -> Self {
        let r = a_from_b.rotation.matrix();
        Self {
            mass: self.mass,
            com: a_from_b.transform_point(self.com),
            inertia: product(&product(r, &self.inertia), &r.transpose()),
        }
    }

    /// Two bodies fixed to each other, both given in the same frame.
    pub fn joined_with(&self, other: &Self) -> Self {
        // A part without mass must not move the centre by a rounding error.
        let mass = self.mass + other.mass;
        let com = if other.mass == 0.0 {
            self.com
        } else if self.mass == 0.0 {
            other.com
        } else {
            (self.com * self.mass + other.com * other.mass) / mass
        };
        Self {
            mass,
            com,
            inertia: self.inertia_about(com) + other.inertia_about(com),
        }
    }

    /// Inertia tensor about `point` instead of the centre of mass (parallel axis theorem), kg m².
    pub fn inertia_about(&self, point: Vector3<f64>) -> Matrix3<f64> {
        let arm = self.com - point;
        let (square, mass) = (arm.norm_squared(), self.mass);
        let moved = |inertia: f64, own: f64, a: f64, b: f64| inertia + (own - a * b) * mass;
        let i = &self.inertia;
        Matrix3::new(
            moved(i.m11, square, arm.x, arm.x),
            moved(i.m12, 0.0, arm.x, arm.y),
            moved(i.m13, 0.0, arm.x, arm.z),
            moved(i.m21, 0.0, arm.y, arm.x),
            moved(i.m22, square, arm.y, arm.y),
            moved(i.m23, 0.0, arm.y, arm.z),
            moved(i.m31, 0.0, arm.z, arm.x),
            moved(i.m32, 0.0, arm.z, arm.y),
            moved(i.m33, square, arm.z, arm.z),
        )
    }
}

/// What is wrong with a payload's numbers.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Localized)]
#[non_exhaustive]
pub enum PayloadError {
    /// A component is NaN or infinite.
    #[error("the payload has a component that is not a finite number")]
    #[zh("负载有分量不是有限的数")]
    NotFinite,
    /// The mass is negative.
    #[error("the payload mass is {mass_kg} kg, it must not be negative")]
    #[zh("负载质量为 {mass_kg} kg，不能为负")]
    NegativeMass {
        /// The mass that was given, kg.
        mass_kg: f64,
    },
    /// No rigid body has this inertia tensor.
    #[error(
        "the payload inertia [{}] belongs to no rigid body: its principal moments are {principal:?} kg m², \
         they must not be negative and none may exceed the sum of the other two",
        inertia.map(|x| x.to_string()).join(", ")
    )]
    #[zh("负载惯量 [{}] 不属于任何刚体：主惯量为 {principal:?} kg m²，不能为负，且任一个不能超过另两个之和", inertia.map(|x| x.to_string()).join(", "))]
    ImpossibleInertia {
        /// Ixx, Iyy, Izz, Ixy, Ixz, Iyz as given, kg m².
        inertia: [f64; 6],
        /// The principal moments of that tensor, ascending, kg m².
        principal: [f64; 3],
    },
}

/// A rigid load on the tool flange, as `set_payload` gives it (manual 3.1.17).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Payload {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of gravity in the flange frame, m.
    pub cog: Vector3<f64>,
    /// Ixx, Iyy, Izz, Ixy, Ixz, Iyz about the centre of gravity in flange axes, kg m²; the last three are the tensor's
    /// off-diagonal elements (minus the products' integrals).
    pub inertia: [f64; 6],
}

impl Payload {
    /// Nothing on the flange.
    pub const NONE: Self = Self {
        mass: 0.0,
        cog: Vector3::new(0.0, 0.0, 0.0),
        inertia: [0.0; 6],
    };

    /// A checked payload; see the fields for units and frames.
    ///
    /// # Errors
    /// Numbers that are not finite, a negative mass, or an inertia no rigid body can have.
    pub fn new(mass: f64, cog: [f64; 3], inertia: [f64; 6]) -> Result<Self, PayloadError> {
        let payload = Self {
            mass,
            cog: Vector3::from(cog),
            inertia,
        };
        if !(mass.is_finite() && cog.iter().chain(&inertia).all(|x| x.is_finite())) {
            return Err(PayloadError::NotFinite);
        }
        if mass < 0.0 {
            return Err(PayloadError::NegativeMass { mass_kg: mass });
        }
        let principal = principal_moments(&payload.tensor());
        if !is_physical(&principal) {
            return Err(PayloadError::ImpossibleInertia { inertia, principal });
        }
        Ok(payload)
    }

    /// The inertia tensor about the centre of gravity in flange axes, kg m².
    pub fn tensor(&self) -> Matrix3<f64> {
        let [xx, yy, zz, xy, xz, yz] = self.inertia;
        Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
    }

    /// The payload that a rigid body in the flange frame is.
    pub fn from_body(body: &RigidBody) -> Self {
        let i = &body.inertia;
        Self {
            mass: body.mass,
            cog: body.com,
            inertia: [i.m11, i.m22, i.m33, i.m12, i.m13, i.m23],
        }
    }

    /// The payload as a rigid body in the flange frame.
    pub fn body(&self) -> RigidBody {
        RigidBody {
            mass: self.mass,
            com: self.cog,
            inertia: self.tensor(),
        }
    }
}

/// Principal moments of a symmetric tensor, ascending.
pub(crate) fn principal_moments(tensor: &Matrix3<f64>) -> [f64; 3] {
    let values = SymmetricEigen::new(*tensor).eigenvalues;
    let mut moments = [values[0], values[1], values[2]];
    moments.sort_by(f64::total_cmp);
    moments
}

/// Whether some mass distribution has these principal moments (ascending): none negative, triangle inequality.
pub(crate) fn is_physical(moments: &[f64; 3]) -> bool {
    // Users type rounded numbers, hence the slack.
    let slack = 1e-6 * moments[2].abs();
    moments[0] >= -slack && moments[2] <= moments[0] + moments[1] + slack
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn payloads_that_cannot_exist_are_refused_with_the_reason() {
        let refused = |mass, inertia| {
            Payload::new(mass, [0.0; 3], inertia)
                .unwrap_err()
                .to_string()
        };
        assert_eq!(
            refused(-1.0, [0.0; 6]),
            "the payload mass is -1 kg, it must not be negative"
        );
        assert!(refused(f64::NAN, [0.0; 6]).contains("not a finite number"));
        assert!(refused(1.0, [1.0, 1.0, 3.0, 0.0, 0.0, 0.0]).contains("[1, 1, 3, 0, 0, 0]"));
        assert!(refused(1.0, [1.0, 1.0, 1.0, 2.0, 0.0, 0.0]).contains("no rigid body"));
        Payload::new(1.0, [0.1; 3], [1.0, 1.0, 2.0, 0.0, 0.0, 0.0]).unwrap();
    }

    #[test]
    fn two_halves_make_the_whole() {
        let ball = |x: f64| RigidBody {
            mass: 1.0,
            com: Vector3::new(x, 0.0, 0.0),
            inertia: Matrix3::identity() * 0.1,
        };
        let both = ball(-1.0).joined_with(&ball(1.0));
        assert_eq!((both.mass, both.com), (2.0, Vector3::zeros()));
        assert_eq!(
            both.inertia,
            Matrix3::from_diagonal(&Vector3::new(0.2, 2.2, 2.2))
        );
        assert_eq!(RigidBody::default().joined_with(&ball(3.0)), ball(3.0));
    }
}
