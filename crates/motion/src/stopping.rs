//! How the arm comes to rest: one law for each reason, whatever moves the arm.
//!
//! In the list, the first law is that of a planned motion by itself, the second that of anything else: online modes,
//! belts, offsets, force mode, hands.
//!
//! - emergency, protective stop: each joint brakes as fast as it can; the same.
//! - safeguard stop: on its path as hard as the joints can, but joint by joint where the path takes longer
//!   ([`STOP_ON_PATH`]); each joint brakes as fast as it can.
//! - power off, `stop task`, dashboard, page, program's end, replacement ([`StopLaw::InSpace`]): as for a safeguard
//!   stop; the same, and belts, offsets and force mode end.
//! - `stop_thread`, a jog that ends ([`StopLaw::Underneath`]): as for a safeguard stop; the motion underneath brakes
//!   so, belts, offsets and force mode go on.
//! - pause, speed slider: on its path with its own acceleration, at least
//!   [`PAUSE_SHARE`](crate::constants::PAUSE_SHARE) of what the joints can do; online modes the same, but on a belt a
//!   pause brakes each joint as fast as it can.
//! - `stopj(a)`: the fastest joint brakes with `a`, the others in proportion, limited by the joints only; the same for
//!   the motion underneath.
//! - `stopl(a)`: the TCP brakes with `a` along its line, limited by the joints only; the same for the motion
//!   underneath.
//!
//! Owns what ends with a stop and where the braking begins. The braking itself is in `enter_protective_stop`, on the
//! path of the motion (`scalar::PathProgress`) and in the modes; what only holds the arm so that it goes on afterwards
//! is in `hold`.

use motion_api::{CommandId, Outcome, StopReason};

use crate::brake::{JointStopMotion, StopMotion};
use crate::commanded::PlacedSetpoint;
use crate::constants::STOP_ON_PATH;
use crate::cycle::{ControlLoop, Generator};
use crate::machine::RobotStateMachine;
use crate::modes::{ActiveOnlineMode, OnlineMode, is_setpoint_at_rest};
use crate::queue::{HardStop, PathMotion};
use crate::setpoint::Setpoint;

/// The reason for which the arm comes to rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StopCause {
    /// The power goes off once the arm stands.
    PowerOff,
    /// `stop task`, the page, the end of a program, a replacement, the end of the controller.
    Stop,
    /// `stop_thread`, a jog that ends: one motion is dropped, what is laid over it stays.
    StopOfOneMotion,
}

/// How the arm comes to rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StopLaw {
    /// Planned motions by themselves brake on their path as hard as the joints can, unless the joints one by one are
    /// clearly faster ([`STOP_ON_PATH`]); whatever else moves the arm has its joints braked one by one. What is laid
    /// over motions ends.
    InSpace,
    /// The motion underneath brakes so, within the share of the joints that what is laid over it leaves; that goes on.
    Underneath,
}

impl StopCause {
    /// The law by which the arm comes to rest for this reason.
    const fn braking(self) -> StopLaw {
        match self {
            Self::PowerOff | Self::Stop => StopLaw::InSpace,
            Self::StopOfOneMotion => StopLaw::Underneath,
        }
    }
}

impl ControlLoop {
    /// Enters a protective stop that begins with the next setpoint.
    pub(crate) fn enter_protective_stop(&mut self, reason: StopReason) {
        let brake = self.protective_stop(reason);
        self.generator = Generator::Stop(brake);
    }

    /// A protective stop that somebody asked for; nothing new for an arm that brakes already.
    pub(crate) fn stop_on_request(&mut self) {
        let reason = StopReason::Requested;
        let brakes = matches!(self.generator, Generator::Stop(_));
        if self.is_under_servo() && !brakes {
            self.enter_protective_stop(reason);
        } else if self.machine.protective_stop(reason) {
            self.out.report_stop(reason);
        }
    }

    /// Power and brakes take time; safety inputs are looked at.
    pub(crate) fn advance_machine(&mut self) {
        if self.machine.advance(self.step) {
            self.reset_target_to_actual();
        }
        let lines = self.safety_inputs.requests(self.io.image.digital_in);
        self.begin_emergency_stop_if(|machine| machine.update_safety_requests(lines));
    }

    /// Where `begins` says that an emergency stop begins, the joints brake; once they stand the power goes off.
    pub(crate) fn begin_emergency_stop_if(
        &mut self,
        begins: impl FnOnce(&mut RobotStateMachine) -> bool,
    ) {
        let is_held_by_servos = self.is_under_servo();
        if !begins(&mut self.machine) {
            return;
        }
        let reason = StopReason::EmergencyStop;
        self.out.report_stop(reason);
        if is_held_by_servos && !matches!(self.generator, Generator::Stop(_)) {
            let brake = self.brake_from_target(reason);
            self.generator = Generator::Stop(brake);
        }
    }

    /// Reports a protective stop, ends the motion with it, and gives the braking from the present target.
    pub(crate) fn protective_stop(&mut self, reason: StopReason) -> StopMotion {
        if self.machine.protective_stop(reason) {
            self.out.report_stop(reason);
        }
        self.brake_from_target(reason)
    }

    /// Ends the motion with `reason` and gives the braking from the present target.
    fn brake_from_target(&mut self, reason: StopReason) -> StopMotion {
        self.drop_zone_changes(CommandId::NONE, Outcome::ProtectiveStop(reason));
        self.end_motions(Outcome::ProtectiveStop(reason));
        let is_for_plane = matches!(reason, StopReason::SafetyPlane { .. });
        let brake = match &self.generator {
            Generator::Path(motion) if is_for_plane && self.must_halt_on_path() => {
                StopMotion::on_path(*motion)
            }
            _ => StopMotion::JointWise(self.shortest_joint_stop()),
        };
        self.is_paused = false;
        self.end_overlays();
        brake
    }

    /// Whatever is laid over motions ends: from here on the arm does what the target does.
    fn end_overlays(&mut self) {
        self.joint_hold = None;
        self.lag = None;
        self.tracking = None;
        self.path_offset.end();
        self.force.active = None;
        self.target = *self.commanded.setpoint();
    }

    /// Ends the commands of every motion under way or to come.
    pub(crate) fn end_motions(&mut self, outcome: Outcome) {
        self.end_legs(outcome);
        if let Generator::Online(online) = &self.generator
            && online.id != CommandId::NONE
            && !online.has_ended()
        {
            self.out.report_end(online.id, outcome);
        }
        if let Some(upcoming) = self.pending_motion.take() {
            self.out.report_end(upcoming.id, outcome);
        }
        if let Some(deferred) = self.deferred.take() {
            self.out.report_end(deferred.id, outcome);
        }
    }

    /// Brings a moving arm to rest, as a stop command would; for the end of the controller.
    pub fn stop_moving(&mut self) {
        self.stop_for(StopCause::Stop);
    }

    /// Begins to bring the arm to rest by the law for `cause`.
    pub(crate) fn stop_for(&mut self, cause: StopCause) {
        match cause.braking() {
            StopLaw::InSpace => self.stop_in_space(),
            StopLaw::Underneath => self.stop_motion_underneath(),
        }
    }

    fn stop_in_space(&mut self) {
        self.drop_motions_to_come();
        let is_alone = self.has_no_overlay() && self.joint_hold.is_none();
        match self.generator {
            Generator::Stop(_) => {}
            Generator::Hold if is_alone => {}
            Generator::Path(motion)
                if is_alone && self.keeps_its_path(&motion, &self.shortest_joint_stop()) =>
            {
                self.stop_on_path();
            }
            Generator::Online(mut online) if is_alone && online.stops_on_its_way() => {
                online.make_way(&self.target);
                self.generator = Generator::Online(online);
            }
            _ => self.brake_joints(),
        }
    }

    /// Stops the motion under what is laid over it, which goes on: on a belt it comes to rest on the belt.
    pub(crate) fn stop_motion_underneath(&mut self) {
        let has_overlay =
            self.tracking.is_some() || self.path_offset.is_on() || self.force.is_active();
        if !has_overlay {
            return self.stop_in_space();
        }
        self.drop_motions_to_come();
        // A belt, an offset and force mode need their share of what the joints can do.
        let brake = JointStopMotion::new(&self.target, self.limits.under_overlay());
        match &mut self.generator {
            Generator::Online(online) => {
                online.is_stopping = true;
                online.kind = OnlineMode::Brake(brake);
            }
            Generator::Path(motion) => {
                let motion = *motion;
                if self.keeps_its_path(&motion, &brake) {
                    self.stop_on_path();
                } else {
                    self.end_legs(Outcome::Aborted);
                    self.generator =
                        Generator::Online(ActiveOnlineMode::to_rest(OnlineMode::Brake(brake)));
                }
            }
            Generator::Hold | Generator::Stop(_) => {}
        }
    }

    fn stop_on_path(&mut self) {
        if let Generator::Path(motion) = &mut self.generator {
            motion.is_stopping = true;
            motion.hard_stop = Some(HardStop::OnPath);
        }
    }

    /// Ends what moves the arm; each joint comes to rest as fast as it can from what it does now.
    fn brake_joints(&mut self) {
        self.end_motions(Outcome::Aborted);
        self.end_overlays();
        self.generator = if is_setpoint_at_rest(&self.target) {
            Generator::Hold
        } else {
            let brake = JointStopMotion::new(&self.target, self.limits.able());
            Generator::Online(ActiveOnlineMode::to_rest(OnlineMode::Brake(brake)))
        };
    }

    /// Ends the commands of motions that have not begun.
    pub(crate) fn drop_motions_to_come(&mut self) {
        if let Some(upcoming) = self.pending_motion.take() {
            self.out.report_end(upcoming.id, Outcome::Aborted);
        }
        if let Some(deferred) = self.deferred.take() {
            self.out.report_end(deferred.id, Outcome::Aborted);
        }
    }

    /// The joints of the arm brake one by one as fast as they can.
    fn shortest_joint_stop(&self) -> JointStopMotion {
        JointStopMotion::new(self.commanded.setpoint(), self.limits.able())
    }

    /// Whether a stop of a planned motion that shall be as short as it can be is made on its path: that takes hardly
    /// longer than the `joints` one by one, or these would cross a safety plane.
    fn keeps_its_path(&self, motion: &PathMotion, joints: &JointStopMotion) -> bool {
        let most = STOP_ON_PATH.times * joints.longest() + STOP_ON_PATH.longer;
        self.queue.halts_within_time(motion, self.step, most)
            || !self.has_no_planes() && self.must_halt_on_path()
    }

    /// How the motion under way makes the hard stop that is asked for, decided when that begins; `None` without a
    /// motion.
    pub(crate) fn hard_stop(&mut self) -> Option<HardStop> {
        let Generator::Path(motion) = self.generator else {
            return None;
        };
        let decided = motion.hard_stop.unwrap_or_else(|| {
            if self.keeps_its_path(&motion, &self.shortest_joint_stop()) {
                HardStop::OnPath
            } else {
                HardStop::JointByJoint
            }
        });
        if let Generator::Path(motion) = &mut self.generator {
            motion.hard_stop = Some(decided);
        }
        Some(decided)
    }

    /// No hard stop is asked for any more.
    pub(crate) fn forget_hard_stop(&mut self) {
        if let Generator::Path(motion) = &mut self.generator
            && !motion.is_stopping
        {
            motion.hard_stop = None;
        }
    }

    /// The joints are braked one by one by a stop that ends what moved the arm, and nothing else moves it.
    pub(crate) fn brakes_joint_by_joint(&self) -> bool {
        self.has_no_overlay()
            && matches!(&self.generator, Generator::Online(online) if online.is_braking_joints())
    }

    /// The setpoint of such a stop: the arm comes to rest whatever the limits of TCP and elbow.
    pub(crate) fn braked_joints(&mut self, wanted: Setpoint) -> PlacedSetpoint {
        let passed = self.while_braking(wanted);
        self.target = *passed.as_setpoint();
        passed
    }
}
