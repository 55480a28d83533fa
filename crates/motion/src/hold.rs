//! Whether the arm may move in this cycle: the one place that decides it, whatever moves the arm.
//!
//! How the arm comes to rest for which reason is the table in `stopping`; what of it holds the arm so that it goes on afterwards
//! is done here:
//!
//! | asked for by | planned motion by itself | anything else: online modes, belts, offsets, force mode, hands |
//! |---|---|---|
//! | slider at 0 | halts on its path | online modes come to rest; belts and force mode go on |
//! | pause | halts on its path | speeds, offsets and force mode come to rest by themselves; on a belt, in a stream and under a hand the joints are braked |
//! | safeguard stop | halts on its path, or has its joints braked where the path would take longer | the joints are braked |
//!
//! An arm that is too fast for reduced mode is slowed down the same way, see `limits_in_force`.
//!
//! Braked joints come to rest one by one as fast as their accelerations and jerks allow; nothing that a mode, a belt or force
//! mode would have the arm do counts until they stand and the stop is over. Then modes go on from rest. What lies between
//! where they want the joints and where these stand is the [`Lag`], which is made good before anything else moves.
//!
//! Owns when the arm is held and how it is let go; protective and emergency stops, which end what they stop, are in `stopping`.

use kinematics::{JointPositions, Pose};
use motion_api::StopReason;

use crate::brake::JointBrake;
use crate::config::MotionLimits;
use crate::constants::SLOWEST_FRACTION;
use crate::cycle::{Cycle, Generator};
use crate::modes::conveyor::Tracking;
use crate::modes::lag::Lag;
use crate::modes::{online_axes, stands};
use crate::queue::HardStop;
use crate::setpoint::{LimitedSetpoint, Setpoint};

/// What the arm may do in a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Permit {
    /// Motions go on at this fraction of their speed; at 0 they hold, and what is laid over them goes on.
    Go(f64),
    /// Everything comes to rest, as a motion does by itself.
    Rest,
    /// Everything comes to rest as fast as the joints can.
    RestHard,
}

impl Permit {
    /// The speed fraction of motions.
    pub(crate) const fn fraction(self) -> f64 {
        match self {
            Self::Go(fraction) => fraction,
            Self::Rest | Self::RestHard => 0.0,
        }
    }
}

/// Joints that are braked, or stand after that.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Holding {
    brake: JointBrake,
    /// They need not stand, only be slow enough for reduced mode.
    slows_only: bool,
    /// They brake for a pause, more gently than they can.
    is_gentle: bool,
    /// How hard a planned motion underneath brakes beside them, unit of its way over s².
    deceleration_on_path: f64,
    /// Where the motion underneath and the arm were when it began, rad.
    began: [JointPositions; 2],
}

impl Holding {
    /// How hard a planned motion underneath brakes, so that it comes to rest when the joints do.
    pub(crate) const fn deceleration_on_path(&self) -> f64 {
        self.deceleration_on_path
    }
}

/// Share of the joints' accelerations with which a pause brakes streams and hands.
const PAUSE_OF_STREAMS: f64 = 0.3;

/// A lag larger than this is not made good, rad: the arm stands in another of its configurations.
const LAG_MOST: f64 = 1.5;

impl Cycle {
    /// What the arm may do now.
    pub(crate) fn permit(&self) -> Permit {
        if self.machine.is_safeguarded() {
            Permit::RestHard
        } else if self.is_paused {
            Permit::Rest
        } else if self.is_behind() || self.speed_fraction < SLOWEST_FRACTION {
            Permit::Go(0.0)
        } else {
            Permit::Go(self.speed_fraction)
        }
    }

    /// The arm was held beside its way, or while a belt went on: it makes that good before motions go on.
    pub(crate) fn is_behind(&self) -> bool {
        self.lag.is_some_and(|lag| lag.comes_first())
            || self.tracking.as_ref().is_some_and(Tracking::is_behind)
    }

    /// A pause or a safeguard stop holds the arm.
    pub(crate) fn is_held(&self) -> bool {
        !matches!(self.permit(), Permit::Go(_))
    }

    /// Begins to brake the joints where that has to be, and lets the arm go once it may move again and stands.
    pub(crate) fn hold_or_let_go(&mut self) -> Result<(), StopReason> {
        let is_braking = matches!(self.generator, Generator::Brake(_));
        if is_braking || !self.is_under_servo() {
            self.holding = None;
            return Ok(());
        }
        let permit = self.permit();
        if permit != Permit::RestHard {
            self.forget_hard_stop();
        }
        let must_brake = match permit {
            Permit::Go(_) => {
                return match &self.holding {
                    Some(holding) if holding.slows_only => {
                        let is_slowing = self.limit_sets.is_slowing();
                        if is_slowing && holding.brake.is_over() && !self.may_be_braked() {
                            self.hold(true);
                        } else if !is_slowing || holding.brake.is_over() {
                            self.let_go_slowed();
                        }
                        Ok(())
                    }
                    Some(_) if self.is_braked() => self.let_go(),
                    None if self.must_slow_joints() => {
                        self.hold(true);
                        Ok(())
                    }
                    _ => Ok(()),
                };
            }
            Permit::Rest => {
                self.tracking.is_some() || self.lag.is_some() || self.follows_from_outside()
            }
            Permit::RestHard => {
                !self.is_path_all()
                    || matches!(self.generator, Generator::Online(_))
                    || self.hard_stop() == Some(HardStop::JointByJoint)
            }
        };
        match &self.holding {
            None if must_brake => {
                self.hold(false);
                Ok(())
            }
            Some(holding)
                if must_brake
                    && (holding.slows_only || holding.is_gentle && permit == Permit::RestHard) =>
            {
                self.hold(false);
                Ok(())
            }
            Some(_) if !must_brake && self.is_braked() => self.let_go(),
            _ => Ok(()),
        }
    }

    /// The joints stand, and so does the place on the path that they come back to.
    fn is_braked(&self) -> bool {
        let path_stands = match &self.generator {
            Generator::Path(motion) => self.queue.is_standing(motion),
            _ => true,
        };
        path_stands && stands(&self.commanded)
    }

    /// A stream or a hand leads the arm: these have no acceleration of their own to come to rest with.
    fn follows_from_outside(&self) -> bool {
        matches!(&self.generator, Generator::Online(online) if online.follows_from_outside())
    }

    /// Brakes the joints.
    pub(crate) fn hold(&mut self, slows_only: bool) {
        let is_gentle = !slows_only
            && self.permit() == Permit::Rest
            && self.tracking.is_none()
            && self.lag.is_none();
        let able = self.limit_sets.able();
        let brake = if slows_only {
            JointBrake::to_share(&self.commanded, self.braked_share(), &self.slowing_limits())
        } else if is_gentle {
            let acceleration = able.acceleration.map(|a| PAUSE_OF_STREAMS * a);
            let limits = MotionLimits {
                acceleration,
                ..*able
            };
            let gentle = JointBrake::new(&self.commanded, &limits);
            if gentle.stays_within(able) {
                gentle
            } else {
                JointBrake::new(&self.commanded, able)
            }
        } else {
            JointBrake::new(&self.commanded, able)
        };
        let speed_on_path = match &self.generator {
            Generator::Path(motion) => motion.committed_speed(),
            _ => 0.0,
        };
        self.holding = Some(Holding {
            deceleration_on_path: speed_on_path / brake.longest().max(self.step),
            brake,
            slows_only,
            is_gentle,
            began: [self.target.q, self.commanded.q],
        });
        if let Some(tracking) = &mut self.tracking {
            tracking.halt();
        }
        self.path_offset.halt();
        self.lag = None;
        if matches!(self.generator, Generator::Hold) {
            self.target = Setpoint::standing(self.target.q);
        }
    }

    /// The next setpoint of joints that are being braked; `None` while modes decide.
    pub(crate) fn held(&mut self) -> Option<LimitedSetpoint> {
        let mut holding = self.holding?;
        let mut next = holding.brake.next(self.step);
        // Softly is not how to come to a safety plane.
        if holding.slows_only && !self.has_no_planes() && self.crossed_by_joints(&next).is_some() {
            holding.brake = JointBrake::new(&self.commanded, self.limit_sets.able());
            next = holding.brake.next(self.step);
        }
        self.holding = Some(holding);
        if let Some(pressing) = &mut self.force.pressing {
            pressing.stand_aside();
        }
        let able = self.limit_sets.able();
        let passed = LimitedSetpoint::while_braking(next, &self.commanded, able);
        self.target_frames = self.model.forward(&passed.get().q);
        Some(passed)
    }

    /// An online mode goes on from where its joints have become slow enough.
    fn let_go_slowed(&mut self) {
        self.holding = None;
        self.is_slow_enough();
        self.target = self.commanded;
        if let Generator::Online(mut online) = self.generator {
            online.go_on_from(&self.online_arm(), &self.target);
            self.generator = Generator::Online(online);
        }
    }

    /// From here on modes decide again, each from rest.
    fn let_go(&mut self) -> Result<(), StopReason> {
        let Some(holding) = self.holding.take() else {
            return Ok(());
        };
        if !matches!(self.generator, Generator::Path(_)) {
            self.target = Setpoint::standing(self.target.q);
        }
        let nominal = Setpoint::standing(self.target.q);
        if let Generator::Online(mut online) = self.generator {
            online.go_on_from(&self.online_arm(), &nominal);
            self.generator = Generator::Online(online);
        }
        if let Some(pressing) = &mut self.force.pressing {
            let poses = |[before, after]: [&JointPositions; 2]| -> [Pose; 2] {
                [before, after].map(|q| self.model.tcp_pose(q, &self.flange_from_tcp))
            };
            let [target, arm] = &holding.began;
            pressing.go_on_from(
                &poses([target, &nominal.q]),
                &poses([arm, &self.commanded.q]),
            );
            return Ok(());
        }
        let lost = if self.tracking.is_some() {
            StopReason::ConveyorLost
        } else {
            StopReason::PathOffsetLost
        };
        let wanted = self.wanted_at_rest(&nominal).ok_or(lost)?;
        let lag = Lag::between(&self.commanded, &wanted, self.step, true);
        if lag.is_some_and(|lag| lag.largest() > LAG_MOST) {
            return Err(lost);
        }
        self.lag = lag;
        Ok(())
    }

    /// Where belt and offset want the arm when the motion underneath stands at `nominal`; the belt is taken up where it
    /// comes nearest to where the arm stands.
    fn wanted_at_rest(&mut self, nominal: &Setpoint) -> Option<Setpoint> {
        let (model, tool) = (&self.model, &self.flange_from_tcp);
        if let Some(tracking) = &mut self.tracking {
            let [from, to] = [nominal, &self.commanded]
                .map(|setpoint| model.tcp_pose(&setpoint.q, tool).translation);
            tracking.take_up(&from, &to);
            return tracking.carry(nominal, &self.commanded, model, tool);
        }
        if self.path_offset.is_on() {
            return self
                .path_offset
                .carry(nominal, &self.commanded, model, tool);
        }
        Some(*nominal)
    }

    /// What modes want, plus what the arm lags behind it.
    pub(crate) fn with_lag(&mut self, wanted: &Setpoint) -> Setpoint {
        let Some(mut lag) = self.lag else {
            return *wanted;
        };
        lag.advance(&online_axes(&self.limits, self.step), self.step);
        self.lag = (!lag.is_over()).then_some(lag);
        lag.laid_over(wanted)
    }
}
