//! The arm as it is: the plant, what it touches, and where that has led to.

use kinematics::{Dynamics, Frames, JointPositions, JointTorques, RobotModel};

use super::{ArmState, Plant};
use crate::commanded::PlacedSetpoint;
use crate::contact::ContactModel;
use crate::setpoint::KinematicsCache;

/// The arm at the end of the latest cycle. Nothing moves it but a step of the plant, and the links always are where
/// the joints have them.
pub(crate) struct ActualArm {
    /// Steps are made by the methods here alone.
    pub(crate) plant: Plant,
    pub(crate) contacts: ContactModel,
    state: ArmState,
    frames: Frames,
}

impl ActualArm {
    /// The arm after one cycle in which the brakes held it. `believed` is the controller's model of it.
    pub(crate) fn new(
        mut plant: Plant,
        mut contacts: ContactModel,
        believed: &Dynamics,
        model: &RobotModel,
    ) -> Self {
        let state = plant.step_with_brakes(believed, &mut contacts);
        Self {
            frames: model.forward(&state.q),
            plant,
            contacts,
            state,
        }
    }

    /// What the joints do.
    pub(crate) const fn state(&self) -> &ArmState {
        &self.state
    }

    /// Where the links are.
    pub(crate) const fn frames(&self) -> &Frames {
        &self.frames
    }

    /// One cycle of `step` seconds under servo control towards `target`. `believed` are the controller's model and the
    /// torques that it expects of the target.
    pub(crate) fn step_to_target(
        &mut self,
        target: &PlacedSetpoint,
        believed: (&Dynamics, &JointTorques),
        step: f64,
        links: (&RobotModel, &mut KinematicsCache),
    ) {
        let state = self
            .plant
            .step_to_target(target.limited(), believed, &mut self.contacts, step);
        if state.q.has_bits_of(&target.as_setpoint().q) {
            // The limiter has looked where that is.
            (self.state, self.frames) = (state, *target.frames());
        } else {
            self.take(state, links);
        }
    }

    /// One cycle with the brakes engaged.
    pub(crate) fn step_with_brakes(
        &mut self,
        believed: &Dynamics,
        links: (&RobotModel, &mut KinematicsCache),
    ) {
        let state = self.plant.step_with_brakes(believed, &mut self.contacts);
        self.take(state, links);
    }

    /// Puts the arm at rest at `q`, where the brakes hold it.
    pub(crate) fn restart_at(
        &mut self,
        q: &JointPositions,
        believed: &Dynamics,
        links: (&RobotModel, &mut KinematicsCache),
    ) {
        self.plant.reset(q);
        self.step_with_brakes(believed, links);
    }

    fn take(&mut self, state: ArmState, (model, cache): (&RobotModel, &mut KinematicsCache)) {
        if !state.q.has_bits_of(&self.state.q) {
            self.frames = cache.at(model, &state.q).frames;
        }
        self.state = state;
    }
}
