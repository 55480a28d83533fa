//! A safety plane: where it is, which side is allowed, when it counts.

use super::{CI_PAIRS, SafetySettingError};
use messages::text;
use nalgebra::Vector3;

/// Safety modes in which a plane counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PlaneMode {
    /// In normal mode.
    #[default]
    Normal,
    /// In reduced mode.
    Reduced,
    /// In normal and in reduced mode.
    Both,
    /// Never.
    Off,
}

/// A plane that the TCP, the tool and, if so set, the elbow must not cross. Base frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SafetyPlane {
    point: Vector3<f64>,
    pub(super) normal: Vector3<f64>,
    mode: PlaneMode,
    ci_pair: Option<u8>,
}

impl SafetyPlane {
    /// A plane through `point` (m) whose `normal`, of any length, points to the allowed side. With `ci_pair` 0 to 3 it
    /// counts only while that pair of inputs is set.
    ///
    /// # Errors
    /// A point that is not finite, a normal without direction, a pair that does not exist.
    pub fn new(
        point: [f64; 3],
        normal: [f64; 3],
        mode: PlaneMode,
        ci_pair: Option<u8>,
    ) -> Result<Self, SafetySettingError> {
        let plane = |what, value, allowed| SafetySettingError::Plane {
            what,
            value,
            allowed,
        };
        if !point.iter().all(|x| x.is_finite()) {
            return Err(plane(
                "point",
                point,
                text!("three finite numbers", "三个有限的数"),
            ));
        }
        let direction = Vector3::from(normal);
        let length = direction.norm();
        if !(length.is_finite() && length > 1e-9) {
            return Err(plane(
                "normal",
                normal,
                text!(
                    "a vector of finite length above 0",
                    "长度有限且大于 0 的向量"
                ),
            ));
        }
        if let Some(pair) = ci_pair.filter(|&pair| usize::from(pair) >= CI_PAIRS) {
            return Err(SafetySettingError::CiPair(pair));
        }
        Ok(Self {
            point: point.into(),
            normal: direction / length,
            mode,
            ci_pair,
        })
    }

    /// A point on the plane, m.
    pub fn point(&self) -> Vector3<f64> {
        self.point
    }

    /// Unit vector to the allowed side.
    pub fn normal(&self) -> Vector3<f64> {
        self.normal
    }

    /// Height of a point above the plane, m; negative on the forbidden side.
    pub fn height(&self, point: Vector3<f64>) -> f64 {
        (point - self.point).dot(&self.normal)
    }

    /// Whether the plane counts. One that no inputs switch always does in its mode (manual 3.1.35).
    pub fn is_active(&self, switches: &PlaneSwitches) -> bool {
        let in_mode = match self.mode {
            PlaneMode::Normal => !switches.reduced,
            PlaneMode::Reduced => switches.reduced,
            PlaneMode::Both => true,
            PlaneMode::Off => false,
        };
        in_mode
            && self
                .ci_pair
                .is_none_or(|pair| switches.ci_pairs[usize::from(pair)])
    }
}

/// What decides which planes count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PlaneSwitches {
    /// The safety system is in reduced mode.
    pub reduced: bool,
    /// By pair of configurable inputs: the pair is set.
    pub ci_pairs: [bool; CI_PAIRS],
}
