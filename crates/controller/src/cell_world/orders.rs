//! What the world is told from outside its cycle, by tests, the page, Python and buses: kept with the cycle, so that a
//! run can be repeated.

use std::collections::VecDeque;
use std::ops::Range;

use kinematics::{Pose, RpyPose};
use messages::{Localized, Text};
use recorder::{ReadError, Recording};
use serde::{Deserialize, Serialize};
use world::{FingerOrder, OrderError, World};

use super::topic;
use crate::cell::world::fault_of;
use thiserror::Error;

/// An order to the world. Poses are x, y, z, Rx, Ry, Rz in the base frame, m and rad.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "order", rename_all = "snake_case")]
pub enum WorldOrder {
    /// Put a part somewhere, at rest.
    Place {
        /// Name of the part.
        name: String,
        /// Where it is put.
        pose: [f64; 6],
    },
    /// Take a part out of the world.
    Remove {
        /// Name of the part.
        name: String,
    },
    /// Put another part of a template into the world.
    Add {
        /// Name of the template.
        template: String,
        /// Where it is put.
        pose: [f64; 6],
    },
    /// Let something go wrong.
    Fault {
        /// What, as in the cell file.
        what: String,
        /// Name of the thing or of the input.
        name: String,
        /// How long, s; for ever without it.
        duration: Option<f64>,
    },
    /// Tell fingers that are on a bus where to go.
    Fingers {
        /// Number of the gripper.
        gripper: usize,
        /// Opening between the fingers, m.
        width: f64,
        /// Speed of each finger, m/s.
        speed: f64,
        /// Force of each finger, N.
        force: f64,
    },
}

/// An order that was not carried out, in a sentence.
#[derive(Clone, Debug, PartialEq, Error, Localized)]
pub enum WorldOrderError {
    /// The world refuses it.
    #[error(transparent)]
    Refused(#[from] OrderError),
    /// There is no such fault, or no such input.
    #[error("{0}")]
    Fault(Text),
}

impl WorldOrder {
    /// Carries the order out; the name of the part that was added.
    pub(super) fn carry_out(&self, world: &mut World) -> Result<Option<String>, WorldOrderError> {
        let pose_of = |pose: &[f64; 6]| Pose::from_rpy(&RpyPose::from_array(*pose));
        match self {
            Self::Place { name, pose } => world.place(name, &pose_of(pose))?,
            Self::Remove { name } => world.remove(name)?,
            Self::Add { template, pose } => {
                return Ok(Some(world.add(template, &pose_of(pose))?.to_string()));
            }
            Self::Fault {
                what,
                name,
                duration,
            } => {
                let fault = fault_of(what, name).map_err(WorldOrderError::Fault)?;
                world.fail(fault, *duration)?;
            }
            Self::Fingers {
                gripper,
                width,
                speed,
                force,
            } => {
                let order = FingerOrder {
                    width: *width,
                    speed: *speed,
                    force: *force,
                };
                world.order_fingers(*gripper, &order)?;
            }
        }
        Ok(None)
    }
}

/// What a recording says of a world from outside: orders after cycles, and which of its results a cycle had where it
/// came late.
#[derive(Clone, Debug, Default)]
pub struct WorldInputs {
    orders: VecDeque<(u64, WorldOrder)>,
    /// Number of a cycle, and of the cycle whose result was the newest for it.
    late: VecDeque<(u64, u64)>,
    /// Cycles that the world did not move by.
    missed: VecDeque<Range<u64>>,
}

impl WorldInputs {
    /// Reads a recording.
    ///
    /// # Errors
    /// The recording cannot be read.
    pub fn read(recording: &Recording) -> Result<Self, ReadError> {
        let mut inputs = Self::default();
        for message in topic::messages(recording)? {
            let message = message?;
            let after = message.cycle;
            let orders = message.orders.into_iter().map(|order| (after, order));
            inputs.orders.extend(orders);
            inputs.late.extend(message.seen.map(|seen| (after, seen)));
            if message.missed > 0 {
                let first = after.saturating_sub(message.missed);
                inputs.missed.push_back(first..after);
            }
        }
        Ok(inputs)
    }

    /// The next order that comes before the world moves by `cycle`.
    pub(super) fn next_order(&mut self, cycle: u64) -> Option<WorldOrder> {
        let due = self.orders.pop_front_if(|(after, _)| *after < cycle);
        due.map(|(_, order)| order)
    }

    /// Whether the world did not move by `cycle`, which is no earlier than the one asked for before.
    pub(super) fn is_missed(&mut self, cycle: u64) -> bool {
        while self
            .missed
            .pop_front_if(|missed| missed.end <= cycle)
            .is_some()
        {}
        self.missed
            .front()
            .is_some_and(|missed| missed.contains(&cycle))
    }

    /// The cycle whose result is the newest that `cycle` may have.
    pub(super) fn newest_for(&mut self, cycle: u64) -> u64 {
        while self.late.pop_front_if(|(late, _)| *late < cycle).is_some() {}
        let late = self.late.front().filter(|(late, _)| *late == cycle);
        late.map_or(cycle.saturating_sub(1), |(_, seen)| *seen)
    }
}
