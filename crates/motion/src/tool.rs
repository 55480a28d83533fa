//! The tool at the flange, as the controller was told.
//!
//! What hangs there in fact is known to the plant alone.

use kinematics::{Frames, Pose, RpyPose};
use nalgebra::Vector3;

/// Where the tool centre point is. The pose always is that of the numbers that were given.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tool {
    given: RpyPose,
    flange_from_tcp: Pose,
}

impl Tool {
    /// With its TCP at `given` in the flange frame.
    pub(crate) fn new(given: RpyPose) -> Self {
        Self {
            given,
            flange_from_tcp: Pose::from_rpy(&given),
        }
    }

    /// The TCP in the flange frame, in the numbers that were given.
    pub(crate) const fn rpy(&self) -> RpyPose {
        self.given
    }

    /// The TCP in the flange frame.
    pub(crate) const fn flange_from_tcp(&self) -> &Pose {
        &self.flange_from_tcp
    }

    /// The TCP in the base frame, where the links are.
    pub(crate) fn base_from_tcp(&self, links: &Frames) -> Pose {
        links.base_from_flange * self.flange_from_tcp
    }

    /// The position of the TCP in the base frame, m, where the links are.
    pub(crate) fn position(&self, links: &Frames) -> Vector3<f64> {
        self.base_from_tcp(links).translation
    }
}
