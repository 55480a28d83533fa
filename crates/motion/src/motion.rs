//! One motion under way: a chain of paths, the travel along it, and the command it belongs to.

use kinematics::JointPositions;
use motion_api::{CommandId, MotionMode};

use crate::constants::{LONGEST, ZONE_STOPPING_SHARE};
use crate::path::{Chain, Ground};
use crate::plan::{Joined, Leg, UnderWay};
use crate::scalar::{Drive, ScalarState, Travel};
use crate::setpoint::Setpoint;

/// Places on the way to rest that are looked at.
const HALT_PLACES: usize = 8;

/// A motion under way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion {
    pub(crate) id: CommandId,
    pub(crate) mode: MotionMode,
    chain: Chain,
    travel: Travel,
    /// The last leg of the chain.
    leg: Leg,
    /// The chain's s where the blend zone of the last leg begins.
    zone: f64,
    /// A stop was asked for; the motion ends where it comes to rest.
    pub(crate) is_stopping: bool,
    /// The command has ended because the blend zone was entered; another motion may follow.
    pub(crate) is_handed_over: bool,
}

impl Motion {
    /// From rest along one leg. `None` when there is no course, which `leg` has shown to exist.
    pub(crate) fn new(id: CommandId, mode: MotionMode, leg: &Leg) -> Option<Self> {
        let mut course = leg.course;
        if leg.radius > 0.0 {
            course = leg.course.with_zone(
                leg.zone,
                ZONE_STOPPING_SHARE,
                leg.zone_speed,
                leg.duration,
            )?;
        }
        Some(Self {
            id,
            mode,
            chain: Chain::of_one(leg.path),
            travel: Travel::new(course, Drive::Halt),
            leg: *leg,
            zone: leg.zone,
            is_stopping: false,
            is_handed_over: false,
        })
    }

    /// Goes over into another leg for the command `id`.
    pub(crate) fn go_over(&mut self, id: CommandId, mode: MotionMode, joined: &Joined) {
        *self = Self {
            id,
            mode,
            chain: joined.chain,
            travel: joined.travel,
            leg: joined.leg,
            zone: joined.zone,
            is_stopping: false,
            is_handed_over: false,
        };
    }

    /// The motion as the planner of a blend sees it; `None` while it is held or stopped, or not on its last leg.
    pub(crate) fn under_way(&self, q: JointPositions) -> Option<UnderWay<'_>> {
        let now = self.travel.state();
        let is_going = matches!(self.travel.wanted(), Drive::Go(_))
            && !self.is_stopping
            && !self.is_finished();
        (is_going && self.chain.is_in_last(now.position)).then_some(UnderWay {
            leg: &self.leg,
            piece: self.chain.last(),
            travel: &self.travel,
            now,
            q,
        })
    }

    /// The setpoint one cycle later, at a fraction of the planned speed; 0 brakes. `None` when the path is lost.
    pub(crate) fn next(
        &mut self,
        step: f64,
        fraction: f64,
        ground: &Ground,
        near: &JointPositions,
    ) -> Option<Setpoint> {
        self.travel.drive(if fraction > 0.0 && !self.is_stopping {
            Drive::Go(fraction)
        } else {
            Drive::Halt
        });
        let s = self.travel.advance(step);
        if self.travel.is_finished() {
            return Some(self.chain.end());
        }
        self.chain.at(ground, &s, near)
    }

    /// Whether every place up to where it would come to rest if it halted now is `allowed`; `near` is where the joints are.
    pub(crate) fn halts_within(
        &self,
        ground: &Ground,
        near: &JointPositions,
        allowed: impl Fn(&JointPositions) -> bool,
    ) -> bool {
        let mut travel = self.travel;
        let now = travel.state().position;
        travel.drive(Drive::Halt);
        // Longer than any halt: the state is that at its end.
        let end = travel.advance(LONGEST).position;
        let mut q = *near;
        (1..=HALT_PLACES).all(|step| {
            let place = now + (end - now) * step as f64 / HALT_PLACES as f64;
            let there = self.chain.at(ground, &ScalarState::at_rest(place), &q);
            there.is_some_and(|there| {
                q = there.q;
                allowed(&q)
            })
        })
    }

    /// Where the joints will be at the end.
    pub(crate) fn end(&self) -> JointPositions {
        self.chain.end().q
    }

    /// True when the blend zone has been entered and a successor may come.
    pub(crate) fn is_in_zone(&self) -> bool {
        self.leg.radius > 0.0 && self.travel.state().position >= self.zone
    }

    /// True when the end of the path is reached.
    pub(crate) fn is_finished(&self) -> bool {
        self.travel.is_finished()
    }

    /// True when nothing moves: at the end, or halted on the way.
    pub(crate) fn is_standing(&self) -> bool {
        self.travel.is_standing()
    }

    /// The speed fraction in effect.
    pub(crate) fn fraction(&self) -> f64 {
        self.travel.fraction()
    }
}
