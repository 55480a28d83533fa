//! Denavit-Hartenberg tables, for the configuration message of port 30001 and for people.
//!
//! Owns the two index layouts. Nothing computes with them: the chain of fixed transforms is the geometry.

use crate::chain::Chain;
use crate::ik::IkMethod;
use crate::joint::DOF;
use crate::pose::Pose;
use core::f64::consts::FRAC_PI_2;

/// Lengths in m, twists in rad; joint angles carry no offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DhTable {
    /// Distances along the joint axes, m.
    pub d: [f64; DOF],
    /// Lengths, m.
    pub a: [f64; DOF],
    /// Twists, rad.
    pub alpha: [f64; DOF],
}

impl DhTable {
    /// The standard table, T_i = Rz(q_i) Tz(d_i) Tx(a_i) Rx(alpha_i), of a chain that is exactly of the CS shape with
    /// an upright base and an unturned flange.
    pub(crate) fn of(chain: &Chain, ik: &IkMethod) -> Option<Self> {
        let IkMethod::ClosedForm(form) = ik else {
            return None;
        };
        let d1 = chain.parent_from_joint[0].translation.z;
        let plain = chain.parent_from_joint[0] == Pose::from_translation(0.0, 0.0, d1)
            && chain.joint6_from_flange == Pose::IDENTITY;
        plain.then_some(Self {
            d: [d1, 0.0, 0.0, form.d4, form.d5, form.d6],
            a: [0.0, form.a2, form.a3, 0.0, 0.0, 0.0],
            alpha: [FRAC_PI_2, 0.0, 0.0, FRAC_PI_2, -FRAC_PI_2, 0.0],
        })
    }

    /// This arm in the modified layout, T_i = Rx(alpha_i) Tx(a_i) Rz(q_i) Tz(d_i) with a and alpha of the link before:
    /// the layout in which a controller sends them (SDK calibration program).
    pub fn modified(&self) -> Self {
        let shifted = |v: [f64; DOF]| [0.0, v[0], v[1], v[2], v[3], v[4]];
        Self {
            d: self.d,
            a: shifted(self.a),
            alpha: shifted(self.alpha),
        }
    }
}
