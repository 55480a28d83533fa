//! The motion that follows the one under way: planned while that one is still moving, joined to it if it can be.
//!
//! A command may come as soon as the one before it has ended by entering its blend zone. When the junction cannot be made,
//! because the command came too late or the turn is too sharp, the arm stops exactly at the waypoint and the next motion
//! begins from rest, with a warning.

use motion_api::{CommandId, MotionMode, Outcome, Refusal, Warning};

use crate::cycle::{Cycle, Generator};
use crate::motion::Motion;
use crate::path::Geometry;
use crate::plan::{CartesianPlanner, Junction, Leg, MicroLinePlanner, Warnings};

/// A motion command that waits for its turn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Upcoming {
    pub(crate) id: CommandId,
    pub(crate) mode: MotionMode,
    pub(crate) plan: Planned,
    pub(crate) junction: Junction,
}

/// How far the plan is.
#[allow(
    clippy::large_enum_variant,
    reason = "lives in place inside the cycle, which must not allocate"
)]
#[derive(Clone, Copy, Debug)]
pub(crate) enum Planned {
    /// There is more of the way to look at.
    Partly(CartesianPlanner),
    /// The same of a way through many points.
    Micro(MicroLinePlanner),
    /// The leg from the waypoint on.
    Ready(Leg, Warnings),
}

impl Cycle {
    /// Takes a motion command: begins it when the arm stands, otherwise keeps it until the motion under way is joined.
    pub(crate) fn follow_with(&mut self, id: CommandId, mode: MotionMode, plan: Planned) {
        self.upcoming = Some(Upcoming {
            id,
            mode,
            plan,
            junction: Junction::default(),
        });
    }

    /// Goes on with the plan of the next motion, joins it to the one under way, or starts it when the arm stands.
    pub(crate) fn plan_on(&mut self) {
        let Some(mut upcoming) = self.upcoming.take() else {
            return;
        };
        if let Planned::Partly(mut planner) = upcoming.plan {
            match planner.work(&self.arm()) {
                Ok(None) => upcoming.plan = Planned::Partly(planner),
                Ok(Some((leg, warnings))) => upcoming.plan = Planned::Ready(leg, warnings),
                Err(refusal) => {
                    self.refuse(upcoming.id, refusal);
                    return;
                }
            }
        }
        if let Planned::Micro(mut planner) = upcoming.plan {
            match planner.work(self.micro_points.points(), &self.arm()) {
                Ok(None) => upcoming.plan = Planned::Micro(planner),
                Ok(Some((leg, warnings))) => upcoming.plan = Planned::Ready(leg, warnings),
                Err(refusal) => {
                    self.refuse(upcoming.id, refusal);
                    return;
                }
            }
        }
        let Planned::Ready(leg, warnings) = upcoming.plan else {
            self.upcoming = Some(upcoming);
            return;
        };
        // Where the way ends is known only now: another solution than the nearest may be behind a plane with its elbow.
        if !self.has_no_planes()
            && let Err(refusal) = self.check_target(&leg.path.end().q)
        {
            self.refuse(upcoming.id, refusal);
            return;
        }
        let mut is_joined = false;
        match self.generator {
            Generator::Path(_) => {
                is_joined = true;
                if !self.join(&mut upcoming, &leg) {
                    self.upcoming = Some(upcoming);
                    return;
                }
            }
            Generator::Hold => {
                if !self.begin(upcoming.id, upcoming.mode, &leg) {
                    return;
                }
            }
            // Comes to rest first.
            Generator::Online(_) => {
                self.upcoming = Some(upcoming);
                return;
            }
            // A protective stop has ended the command.
            Generator::Brake(_) => return,
        }
        for warning in warnings.iter() {
            // How long it would take from rest says nothing once it begins at speed.
            let is_of_rest = matches!(warning, Warning::DurationStretched { .. });
            if !(is_joined && is_of_rest) {
                self.out.warned(upcoming.id, warning);
            }
        }
    }

    fn refuse(&mut self, id: CommandId, refusal: Refusal) {
        self.out.ended(id, Outcome::Refused(refusal));
    }

    fn begin(&mut self, id: CommandId, mode: MotionMode, leg: &Leg) -> bool {
        let Some(motion) = Motion::new(id, mode, leg) else {
            self.refuse(id, Refusal::Planner { code: NO_MOTION });
            return false;
        };
        self.generator = Generator::Path(motion);
        true
    }

    fn join(&mut self, upcoming: &mut Upcoming, leg: &Leg) -> bool {
        let Generator::Path(motion) = &self.generator else {
            return false;
        };
        let Some(under_way) = motion.under_way(self.target.q) else {
            return false;
        };
        // Into a motion that goes nowhere there is nothing to blend: it begins, and ends, at the waypoint. One through many
        // points begins at the first of them, from rest.
        let is_many = matches!(leg.path.geometry(), Geometry::Micro(_));
        if upcoming.junction.is_given_up() || leg.path.length() <= 0.0 || is_many {
            return false;
        }
        let mut warnings = Warnings::default();
        let arm = self.arm();
        let joined = upcoming
            .junction
            .attempt(&under_way, leg, &arm, &mut warnings);
        let Some(joined) = joined else {
            if upcoming.junction.is_given_up() {
                self.out.warned(upcoming.id, Warning::NotBlended);
            }
            return false;
        };
        for warning in warnings.iter() {
            self.out.warned(upcoming.id, warning);
        }
        if let Generator::Path(motion) = &mut self.generator {
            motion.go_over(upcoming.id, upcoming.mode, &joined);
        }
        true
    }
}

/// Planner error: a leg that was planned has no course when its motion begins.
const NO_MOTION: u32 = 2;
