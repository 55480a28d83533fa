//! What the drives have to bear, as the controller was told: payload and gravity, and the dynamics that follow.

use kinematics::{Dynamics, Payload, RobotModel};
use nalgebra::Vector3;

/// The controller's model of the loads on the arm. The dynamics always are those of the payload under that gravity.
pub(crate) struct LoadModel {
    payload: Payload,
    gravity: Vector3<f64>,
    dynamics: Dynamics,
}

impl LoadModel {
    /// An arm with `payload` at its flange; `gravity` is the free-fall acceleration in the base frame, m/s².
    pub(crate) fn new(model: &RobotModel, payload: Payload, gravity: Vector3<f64>) -> Self {
        Self {
            dynamics: model.dynamics(&payload, gravity),
            payload,
            gravity,
        }
    }

    /// What hangs on the flange.
    pub(crate) const fn payload(&self) -> &Payload {
        &self.payload
    }

    /// Free-fall acceleration in the base frame, m/s².
    pub(crate) const fn gravity(&self) -> &Vector3<f64> {
        &self.gravity
    }

    /// The arm with that payload under that gravity.
    pub(crate) const fn dynamics(&self) -> &Dynamics {
        &self.dynamics
    }
}
