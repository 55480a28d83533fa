//! Whether the arm may move in this cycle: the one place that decides it, whatever moves the arm.
//!
//! How the arm comes to rest for which reason is the list in `stopping`; what of it holds the arm so that it goes on
//! afterwards is done here:
//!
//! | asked for by | planned motion by itself | anything else: online modes, belts, offsets, force mode, hands |
//! |---|---|---|
//! | slider at 0 | halts on its path | online modes come to rest, streams as in a pause; belts and force mode go on |
//! | pause | halts on its path | speeds, offsets and force mode come to rest by themselves, the others as below |
//! | safeguard stop | halts on its path, or joint by joint where the path takes longer | the joints are braked |
//!
//! For a pause on a belt, in a stream and under a hand the joints are braked.
//!
//! An arm that is too fast for reduced mode is slowed down the same way, see `limits_in_force`.
//!
//! Braked joints come to rest one by one as fast as their accelerations and jerks allow; nothing that a mode, a belt or
//! force mode would have the arm do counts until they stand and the stop is over. Then modes go on from rest. What lies
//! between where they want the joints and where these stand is the [`JointLag`], which is made good before anything
//! else moves.
//!
//! Owns when the arm is held and how it is let go; protective and emergency stops, which end what they stop, are in
//! `stopping`.

use kinematics::{JointPositions, Pose};
use motion_api::StopReason;

use crate::brake::JointStopMotion;
use crate::commanded::PlacedSetpoint;
use crate::config::MotionLimits;
use crate::constants::{PAUSE_OF_STREAMS, SLOWEST_FRACTION};
use crate::cycle::{ControlLoop, Generator};
use crate::modes::conveyor::ConveyorTracking;
use crate::modes::lag::JointLag;
use crate::modes::{is_setpoint_at_rest, online_axes};
use crate::queue::HardStop;
use crate::setpoint::Setpoint;

/// What the arm may do in a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum MotionPermission {
    /// Motions go on at this fraction of their speed; at 0 they hold, and what is laid over them goes on.
    Run(f64),
    /// Everything comes to rest, as a motion does by itself.
    Stop,
    /// Everything comes to rest as fast as the joints can.
    StopHard,
}

impl MotionPermission {
    /// The speed fraction of motions.
    pub(crate) const fn fraction(self) -> f64 {
        match self {
            Self::Run(fraction) => fraction,
            Self::Stop | Self::StopHard => 0.0,
        }
    }
}

/// Joints that are braked, or stand after that.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointHold {
    brake: JointStopMotion,
    /// The joints need not stand, only be slow enough for reduced mode.
    is_slowdown: bool,
    /// The joints brake for a pause, more gently than they can.
    is_gentle: bool,
    /// How hard a planned motion underneath brakes beside them, unit of its way over s².
    deceleration_on_path: f64,
    /// Where the motion underneath and the arm were when the hold began, rad.
    start_positions: [JointPositions; 2],
}

impl JointHold {
    /// How hard a planned motion underneath brakes, so that it comes to rest when the joints do.
    pub(crate) const fn deceleration_on_path(&self) -> f64 {
        self.deceleration_on_path
    }
}

/// A lag larger than this is not made good, rad: the arm stands in another of its configurations.
const MAX_LAG: f64 = 1.5;

impl ControlLoop {
    /// What the arm may do now.
    pub(crate) fn motion_permission(&self) -> MotionPermission {
        if self.machine.is_safeguarded() {
            MotionPermission::StopHard
        } else if self.is_paused {
            MotionPermission::Stop
        } else if self.has_lag_to_recover() || self.speed_fraction < SLOWEST_FRACTION {
            MotionPermission::Run(0.0)
        } else {
            MotionPermission::Run(self.speed_fraction)
        }
    }

    /// The arm was held beside its way, or while a belt went on: it makes that good before motions go on.
    pub(crate) fn has_lag_to_recover(&self) -> bool {
        self.lag.is_some_and(|lag| lag.comes_first())
            || self
                .tracking
                .as_ref()
                .is_some_and(ConveyorTracking::is_behind)
    }

    /// A pause or a safeguard stop holds the arm.
    pub(crate) fn is_held(&self) -> bool {
        !matches!(self.motion_permission(), MotionPermission::Run(_))
    }

    /// Begins to brake the joints where that has to be, and lets the arm go once it may move again and stands.
    pub(crate) fn update_hold(&mut self) -> Result<(), StopReason> {
        let is_braking = matches!(self.generator, Generator::Stop(_));
        if is_braking || !self.is_under_servo() {
            self.joint_hold = None;
            return Ok(());
        }
        let permit = self.motion_permission();
        if permit != MotionPermission::StopHard {
            self.forget_hard_stop();
        }
        let must_brake = match permit {
            MotionPermission::Run(_) => {
                return match &self.joint_hold {
                    Some(holding) if holding.is_slowdown => {
                        let is_slowing = self.limits.is_slowing();
                        if is_slowing && holding.brake.is_over() && !self.may_be_braked() {
                            self.hold(true);
                        } else if !is_slowing || holding.brake.is_over() {
                            self.end_slowdown();
                        }
                        Ok(())
                    }
                    Some(_) if self.is_braked() => self.release_hold(),
                    None if self.needs_joint_slowdown() => {
                        self.hold(true);
                        Ok(())
                    }
                    _ => Ok(()),
                };
            }
            MotionPermission::Stop => {
                self.tracking.is_some() || self.lag.is_some() || self.follows_from_outside()
            }
            MotionPermission::StopHard => {
                !self.has_no_overlay()
                    || matches!(self.generator, Generator::Online(_))
                    || self.hard_stop() == Some(HardStop::JointByJoint)
            }
        };
        match &self.joint_hold {
            None if must_brake => {
                self.hold(false);
                Ok(())
            }
            Some(holding)
                if must_brake
                    && (holding.is_slowdown
                        || holding.is_gentle && permit == MotionPermission::StopHard) =>
            {
                self.hold(false);
                Ok(())
            }
            Some(_) if !must_brake && self.is_braked() => self.release_hold(),
            _ => Ok(()),
        }
    }

    /// The joints stand, and so does the place on the path that they come back to.
    fn is_braked(&self) -> bool {
        let path_stands = match &self.generator {
            Generator::Path(motion) => self.queue.is_standing(motion),
            _ => true,
        };
        path_stands && is_setpoint_at_rest(self.commanded.setpoint())
    }

    /// A stream or a hand leads the arm: these have no acceleration of their own to come to rest with.
    fn follows_from_outside(&self) -> bool {
        matches!(&self.generator, Generator::Online(online) if online.follows_from_outside())
    }

    /// Brakes the joints.
    pub(crate) fn hold(&mut self, slows_only: bool) {
        let is_gentle = !slows_only
            && self.motion_permission() == MotionPermission::Stop
            && self.tracking.is_none()
            && self.lag.is_none();
        let able = self.limits.able();
        let brake = if slows_only {
            JointStopMotion::to_speed_share(
                self.commanded.setpoint(),
                self.braked_share(),
                &self.slowing_limits(),
            )
        } else if is_gentle {
            let acceleration = able.acceleration.map(|a| PAUSE_OF_STREAMS * a);
            let limits = MotionLimits {
                acceleration,
                ..*able
            };
            let gentle = JointStopMotion::new(self.commanded.setpoint(), &limits);
            if gentle.stays_within(able) {
                gentle
            } else {
                JointStopMotion::new(self.commanded.setpoint(), able)
            }
        } else {
            JointStopMotion::new(self.commanded.setpoint(), able)
        };
        let speed_on_path = match &self.generator {
            Generator::Path(motion) => motion.committed_speed(),
            _ => 0.0,
        };
        self.joint_hold = Some(JointHold {
            deceleration_on_path: speed_on_path / brake.longest().max(self.step),
            brake,
            is_slowdown: slows_only,
            is_gentle,
            start_positions: [self.target.q, self.commanded.setpoint().q],
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
    pub(crate) fn next_hold_setpoint(&mut self) -> Option<PlacedSetpoint> {
        let mut holding = self.joint_hold?;
        let mut next = holding.brake.next(self.step);
        // Softly is not how to come to a safety plane.
        if holding.is_slowdown
            && !self.has_no_planes()
            && self.plane_crossed_while_braking(&next).is_some()
        {
            holding.brake = JointStopMotion::new(self.commanded.setpoint(), self.limits.able());
            next = holding.brake.next(self.step);
        }
        self.joint_hold = Some(holding);
        Some(self.while_braking(next))
    }

    /// An online mode goes on from where its joints have become slow enough.
    fn end_slowdown(&mut self) {
        self.joint_hold = None;
        self.limits.finish_transition();
        self.target = *self.commanded.setpoint();
        if let Generator::Online(mut online) = self.generator {
            online.resume_from(&self.online_arm(), &self.target);
            self.generator = Generator::Online(online);
        }
    }

    /// From here on modes decide again, each from rest.
    fn release_hold(&mut self) -> Result<(), StopReason> {
        let Some(holding) = self.joint_hold.take() else {
            return Ok(());
        };
        if !matches!(self.generator, Generator::Path(_)) {
            self.target = Setpoint::standing(self.target.q);
        }
        let nominal = Setpoint::standing(self.target.q);
        if let Generator::Online(mut online) = self.generator {
            online.resume_from(&self.online_arm(), &nominal);
            self.generator = Generator::Online(online);
        }
        if let Some(pressing) = &mut self.force.active {
            let poses = |[before, after]: [&JointPositions; 2]| -> [Pose; 2] {
                [before, after].map(|q| self.model.tcp_pose(q, self.tool.flange_from_tcp()))
            };
            let [target, arm] = &holding.start_positions;
            pressing.resume_from(
                &poses([target, &nominal.q]),
                &poses([arm, &self.commanded.setpoint().q]),
            );
            return Ok(());
        }
        let lost = if self.tracking.is_some() {
            StopReason::ConveyorLost
        } else {
            StopReason::PathOffsetLost
        };
        let wanted = self.overlay_setpoint_at_rest(&nominal).ok_or(lost)?;
        let lag = JointLag::between(self.commanded.setpoint(), &wanted, self.step, true);
        if lag.is_some_and(|lag| lag.largest() > MAX_LAG) {
            return Err(lost);
        }
        self.lag = lag;
        Ok(())
    }

    /// Where belt and offset want the arm when the motion underneath stands at `nominal`; the belt is taken up where it
    /// comes nearest to where the arm stands.
    fn overlay_setpoint_at_rest(&mut self, nominal: &Setpoint) -> Option<Setpoint> {
        let (model, tool) = (&self.model, self.tool.flange_from_tcp());
        if let Some(tracking) = &mut self.tracking {
            let [from, to] = [nominal, self.commanded.setpoint()]
                .map(|setpoint| model.tcp_pose(&setpoint.q, tool).translation);
            tracking.resync(&from, &to);
            return tracking.superimpose(nominal, self.commanded.setpoint(), model, tool);
        }
        if self.path_offset.is_on() {
            return self
                .path_offset
                .superimpose(nominal, self.commanded.setpoint(), model, tool);
        }
        Some(*nominal)
    }

    /// What modes want, plus what the arm lags behind it.
    pub(crate) fn apply_lag(&mut self, wanted: &Setpoint) -> Setpoint {
        let Some(mut lag) = self.lag else {
            return *wanted;
        };
        lag.advance(&online_axes(self.limits.in_force(), self.step), self.step);
        self.lag = (!lag.is_over()).then_some(lag);
        lag.added_to(wanted)
    }
}
