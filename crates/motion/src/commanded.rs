//! The setpoint that the arm gets, and what belongs to it: where it puts the links, and the positions before it.

use kinematics::{Frames, JointPositions, RobotModel};

use crate::setpoint::{KinematicsCache, LimitedSetpoint, Setpoint};

/// A setpoint that has passed the limiter, and the links there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlacedSetpoint {
    limited: LimitedSetpoint,
    frames: Frames,
}

impl PlacedSetpoint {
    /// With the links where the limiter has found them: `frames` belong to the joint positions of `limited`.
    pub(crate) const fn new(limited: LimitedSetpoint, frames: Frames) -> Self {
        Self { limited, frames }
    }

    /// Looks where a setpoint puts the links.
    pub(crate) fn find(
        limited: LimitedSetpoint,
        model: &RobotModel,
        cache: &mut KinematicsCache,
    ) -> Self {
        let frames = cache.at(model, &limited.as_setpoint().q).frames;
        Self { limited, frames }
    }

    /// The setpoint as the plant takes it.
    pub(crate) const fn limited(&self) -> &LimitedSetpoint {
        &self.limited
    }

    /// The setpoint.
    pub(crate) const fn as_setpoint(&self) -> &Setpoint {
        self.limited.as_setpoint()
    }

    /// Where the links are.
    pub(crate) const fn frames(&self) -> &Frames {
        &self.frames
    }
}

/// The latest setpoint that the arm was given. The links are where its joint positions put them, and these are the
/// newest of the history.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CommandedSetpoint {
    setpoint: Setpoint,
    frames: Frames,
    history: PositionHistory,
}

impl CommandedSetpoint {
    /// The arm has stood at `q` and stands there; `frames` are the links at `q`.
    pub(crate) const fn standing(q: JointPositions, frames: Frames) -> Self {
        Self {
            setpoint: Setpoint::standing(q),
            frames,
            history: PositionHistory::standing(q),
        }
    }

    /// The setpoint.
    pub(crate) const fn setpoint(&self) -> &Setpoint {
        &self.setpoint
    }

    /// Where the links are.
    pub(crate) const fn frames(&self) -> &Frames {
        &self.frames
    }

    /// The positions of this setpoint and of those before it.
    pub(crate) const fn history(&self) -> &PositionHistory {
        &self.history
    }

    /// The arm is given the next setpoint.
    pub(crate) fn advance(&mut self, next: &PlacedSetpoint) {
        self.setpoint = *next.as_setpoint();
        self.frames = *next.frames();
        self.history.add(self.setpoint.q);
    }

    /// The joints come to a stand where they are.
    pub(crate) const fn stand(&mut self) {
        self.setpoint = Setpoint::standing(self.setpoint.q);
    }
}

/// Positions that the joints were given in the last three cycles, newest first, whoever made the setpoints.
///
/// The accelerations of two setpoints say how the speed changed between them only if both mean the same by it: one
/// generator gives the acceleration at the end of a cycle, another the mean over it. Positions mean one thing only.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PositionHistory([JointPositions; 3]);

impl PositionHistory {
    /// The joints have stood at `q`.
    const fn standing(q: JointPositions) -> Self {
        Self([q; 3])
    }

    /// The joints were given `q` in this cycle.
    const fn add(&mut self, q: JointPositions) {
        let [last, before, _] = self.0;
        self.0 = [q, last, before];
    }

    /// The smallest and the largest next position of a joint at which the third difference of its positions is no
    /// larger than `most`, rad.
    pub(crate) fn next_within(&self, joint: usize, most: f64) -> (f64, f64) {
        let [last, before, first] = self.0.map(|q| q[joint]);
        let even = 3.0 * (last - before) + first;
        (even - most, even + most)
    }
}
