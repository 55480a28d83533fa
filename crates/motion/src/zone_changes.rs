//! Inputs and outputs that change when a planned motion ends: where the arm enters its blend zone.
//!
//! A program that sets an output between two blended moves is ahead of the arm. Its change travels with the motion and
//! is made in the cycle in which the arm enters the zone, so that the arm need not slow down for the program and the
//! output still switches at the blend radius.

use motion_api::{CommandId, IoChange, Outcome, Refusal, phrase};

use crate::constants::ZONE_CHANGES;
use crate::cycle::{ControlLoop, Generator};
use crate::intake::{CommandResult, Completion, bad_value};

/// One change and the motion that it belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ZoneChange {
    /// The command that asked for the change.
    id: CommandId,
    motion: CommandId,
    change: IoChange,
}

/// The changes that wait for the arm, in the order in which they were asked for.
#[derive(Clone, Debug)]
pub(crate) struct ZoneChanges {
    list: Vec<ZoneChange>,
}

impl ZoneChanges {
    /// None, with room for [`ZONE_CHANGES`].
    pub(crate) fn new() -> Self {
        Self {
            list: Vec::with_capacity(ZONE_CHANGES),
        }
    }

    /// How many wait.
    pub(crate) fn count(&self) -> usize {
        self.list.len()
    }

    /// Adds a change; refused when as many wait as there is room for.
    fn add(&mut self, change: ZoneChange) -> Result<(), Refusal> {
        if self.list.len() >= ZONE_CHANGES {
            let name = phrase!(
                "the number of changes that wait for a blend zone",
                "等待交融区的更改数目"
            );
            let one_more = (ZONE_CHANGES + 1) as f64;
            return Err(bad_value(
                name,
                one_more,
                phrase!("at most 64", "不超过 64"),
            ));
        }
        self.list.push(change);
        Ok(())
    }

    /// The first change from `start` on.
    fn get(&self, start: usize) -> Option<ZoneChange> {
        self.list.get(start).copied()
    }

    fn remove(&mut self, place: usize) {
        if place < self.list.len() {
            self.list.remove(place);
        }
    }
}

impl ControlLoop {
    /// Keeps a change until `motion` ends, or makes it at once where that is not under way.
    pub(crate) fn set_io_at_zone(
        &mut self,
        id: CommandId,
        motion: CommandId,
        change: IoChange,
    ) -> CommandResult {
        if !self.is_under_way(motion) {
            self.set_io(&change);
            return Ok(Completion::Immediate);
        }
        self.zone_changes.add(ZoneChange { id, motion, change })?;
        Ok(Completion::Deferred)
    }

    /// Makes the changes whose motions have ended.
    pub(crate) fn make_zone_changes(&mut self) {
        let mut place = 0;
        while let Some(next) = self.zone_changes.get(place) {
            if self.is_under_way(next.motion) {
                place += 1;
                continue;
            }
            self.zone_changes.remove(place);
            self.set_io(&next.change);
            self.out.report_end(next.id, Outcome::Done);
        }
    }

    /// Gives up the changes of a motion that is stopped, or of all: the program would never have come to them.
    pub(crate) fn drop_zone_changes(&mut self, of: CommandId, outcome: Outcome) {
        let mut place = 0;
        while let Some(next) = self.zone_changes.get(place) {
            if of != CommandId::NONE && next.motion != of {
                place += 1;
                continue;
            }
            self.zone_changes.remove(place);
            self.out.report_end(next.id, outcome);
        }
    }

    /// Whether a planned motion has been taken and its command has not ended.
    pub(crate) fn is_under_way(&self, motion: CommandId) -> bool {
        let waits = self.deferred.is_some_and(|deferred| deferred.id == motion);
        let is_planned = self
            .pending_motion
            .as_ref()
            .is_some_and(|next| next.id == motion);
        let is_queued =
            || matches!(self.generator, Generator::Path(_)) && self.queue.is_open(motion);
        waits || is_planned || is_queued()
    }
}
