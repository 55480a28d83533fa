//! The arm keeps from running into itself: planned motions are looked at before they begin, setpoints that are made
//! cycle by cycle when they come.
//!
//! Owns how often is looked and what is too near; the capsules are in `kinematics::collision`. Links come nearer only
//! as far as joints turn, so a look says how far they may turn until the next one. An arm that stands in itself already
//! (its watch was off, or its home is such) may move as long as it does not get deeper.

use kinematics::safety::OVERLAP_SLACK as SLACK;
use kinematics::{JointPositions, RobotModel};
use motion_api::{PathFault, StopReason};

use crate::brake::JointStopMotion;
use crate::constants::LINK_PLACES;
use crate::cycle::{ControlLoop, Generator};
use crate::path::JointLine;
use crate::setpoint::Setpoint;

/// Places on the way of braking joints to rest that are looked at.
const BRAKE_PLACES: u32 = 8;
/// A planned motion was looked at in places; between them links may be nearer by this, m.
const BETWEEN_PLACES: f64 = 0.003;

/// Two links that overlap more than they may.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkOverlap {
    /// 0 for the base.
    pub links: [u8; 2],
    /// m.
    pub depth: f64,
}

impl From<LinkOverlap> for PathFault {
    fn from(found: LinkOverlap) -> Self {
        Self::SelfCollision {
            links: found.links,
            overlap: found.depth,
        }
    }
}

impl From<LinkOverlap> for StopReason {
    fn from(found: LinkOverlap) -> Self {
        Self::SelfCollision {
            links: found.links,
            overlap: found.depth,
        }
    }
}

/// Watches the links along a way.
#[derive(Clone, Copy, Debug)]
pub struct SelfCollisionMonitor {
    allowed: f64,
    reaches: [f64; 6],
    /// The joints at the latest check, rad.
    checked_at: JointPositions,
    /// How far links may come nearer from there until they overlap too much, m; negative before the first look.
    clearance: f64,
}

impl SelfCollisionMonitor {
    /// Overlaps of more than `allowed` metres count; infinite: none does.
    pub fn new(model: &RobotModel, allowed: f64) -> Self {
        Self {
            allowed,
            reaches: model.collision().max_lever_arms(model.chain()),
            checked_at: JointPositions::ZERO,
            clearance: f64::NEG_INFINITY,
        }
    }

    /// For a way that begins at `q`: an overlap that is there may stay.
    pub fn starting_at(model: &RobotModel, allowed: f64, q: &JointPositions) -> Self {
        let mut watch = Self::new(model, allowed);
        if let Some(overlap) = watch.check(q, model) {
            watch.allowed = overlap.depth + SLACK;
            watch.clearance = SLACK;
        }
        watch
    }

    /// What overlaps too much at `q`.
    pub fn check(&mut self, q: &JointPositions, model: &RobotModel) -> Option<LinkOverlap> {
        if self.allowed == f64::INFINITY || self.max_approach(q) <= self.clearance {
            return None;
        }
        let found = model.collision().self_distance(&model.forward(q))?;
        self.checked_at = *q;
        self.clearance = found.distance + self.allowed;
        let (a, b) = found.links;
        (self.clearance < 0.0).then_some(LinkOverlap {
            links: [a as u8, b as u8],
            depth: -found.distance,
        })
    }

    /// How far two links may have come nearer since the last look, m.
    fn max_approach(&self, q: &JointPositions) -> f64 {
        (0..6)
            .map(|j| (q[j] - self.checked_at[j]).abs() * self.reaches[j])
            .sum()
    }

    /// The first place of a line in joint space (share of the way) at which links overlap too much. As far as there is
    /// room it is passed in one step.
    pub(crate) fn check_line(
        &mut self,
        line: &JointLine,
        model: &RobotModel,
    ) -> Option<(f64, LinkOverlap)> {
        if self.allowed == f64::INFINITY || line.length() <= 0.0 {
            return None;
        }
        let direction = line.direction();
        let per_s: f64 = (0..6).map(|j| direction[j].abs() * self.reaches[j]).sum();
        let least = line.length() / f64::from(LINK_PLACES);
        let mut s = 0.0;
        loop {
            let q = line.positions(s);
            if let Some(found) = self.check(&q, model) {
                return Some((s / line.length(), found));
            }
            if s >= line.length() {
                return None;
            }
            let free = (self.clearance - self.max_approach(&q)) / per_s;
            s = (s + free.max(least)).min(line.length());
        }
    }
}

impl ControlLoop {
    /// A setpoint that would make links of the arm meet. Modes that make each one from the one before must be able to
    /// brake until then; a planned motion was looked at before, but for its blends.
    pub(crate) fn check_links(&mut self, wanted: &Setpoint) -> Result<(), StopReason> {
        if self.limits.in_force().link_overlap == f64::INFINITY {
            return Ok(());
        }
        let is_planned = matches!(self.generator, Generator::Path(_)) && self.has_no_overlay();
        let mut found = self.find_overlap(&wanted.q, is_planned);
        if found.is_none() && !is_planned {
            let brake = JointStopMotion::new(wanted, self.limits.in_force());
            found = (1..=BRAKE_PLACES).find_map(|place| {
                let share = f64::from(place) / f64::from(BRAKE_PLACES);
                self.find_overlap(&brake.position_at(share), false)
            });
        }
        found.map_or(Ok(()), |overlap| Err(overlap.into()))
    }

    /// What overlaps too much at `q`, and more than it does now.
    fn find_overlap(&mut self, q: &JointPositions, is_planned: bool) -> Option<LinkOverlap> {
        let found = self.links.check(q, &self.model)?;
        let slack = if is_planned { BETWEEN_PLACES } else { 0.0 };
        let frames = self.model.forward(&self.commanded.setpoint().q);
        let now = self.model.collision().self_distance(&frames);
        let deep = now.map_or(0.0, |now| -now.distance);
        let allowed = self.limits.in_force().link_overlap.max(deep + SLACK) + slack;
        (found.depth > allowed).then_some(found)
    }
}
