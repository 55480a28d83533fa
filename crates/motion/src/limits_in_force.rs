//! The limits that count: the arm's, or those of reduced mode, and how the arm comes from the faster to the slower
//! ones.
//!
//! Reduced mode counts from the cycle in which it is asked for: whatever is planned or made cycle by cycle keeps to it
//! from then on. What is under way slows down: a planned motion on its path, as hard as the arm can or with its own
//! acceleration (`set_safety_mode_transition_hardness`), online modes by braking their joints until they are slow
//! enough. Until then setpoints are checked against the arm's limits, but no longer than [`MAX_TRANSITION_TIME`]: then
//! what is too fast is a protective stop. A tool that is set on the way, and whose TCP is too fast for its limit, is
//! slowed down for in the same way. Braking is what the arm can do in either mode, and a motion under way keeps the
//! accelerations it was planned with.

use kinematics::JointPositions;
use motion_api::Refusal;

use crate::config::MotionLimits;
use crate::constants::{SHARE_ON_BELT, STOP_ACCELERATION};
use crate::cycle::{ControlLoop, Generator};
use crate::modes::points::PointSpeedLimits;
use crate::modes::{online_axes, states};
use crate::path::PathContext;
use crate::setpoint::elbow_speed;

/// The arm is slow enough for reduced mode when it has been for so long, s: what is behind it in a smoothed motion may
/// be slower than what lies ahead.
const MIN_TIME_WITHIN_LIMITS: f64 = 0.1;
/// Longest time in which the arm slows down, hard and soft, s.
const MAX_TRANSITION_TIME: [f64; 2] = [1.0, 5.0];
/// Online modes are slowed down to this share of the limits.
const SLOW_SHARE: f64 = 0.9;
/// Share of their speeds to which joints are braked that are slow enough, but would lead the TCP on faster by braking
/// each for itself.
const SLOWER_SHARE: f64 = 0.7;
/// Share of the speeds of TCP and elbow that a path leaves to offsets laid over it.
const SHARE_UNDER_OFFSETS: f64 = 0.7;
/// Share of the joints' accelerations with which they are slowed down softly.
const SOFT_SHARE: f64 = 0.3;

/// The limits of the arm and those of reduced mode, and which of them count for what.
///
/// One of the two sets is in force; what motions may use beside a belt or an offset is always a part of that one. An
/// arm slows down only to limits that are in force, and only then are others enforced.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LimitSets {
    normal: MotionLimits,
    reduced: MotionLimits,
    is_reduced: bool,
    /// What planned motions may use while a belt or an offset uses the rest.
    under_overlay: MotionLimits,
    transition: Option<ReducedModeTransition>,
    /// While the arm slows down for another tool: the limits in force without that of the TCP's speed.
    without_tcp: Option<MotionLimits>,
    /// The speeds of TCP and elbow, m/s, that the way ahead is kept within because it was planned with others.
    way_speeds: Option<[f64; 2]>,
}

/// An arm that is faster than the limits in force allow.
#[derive(Clone, Copy, Debug)]
struct ReducedModeTransition {
    /// Time until the arm must be slow enough, s.
    time_left: f64,
    /// For how long the arm has been slow enough, s.
    time_within_limits: f64,
}

impl ReducedModeTransition {
    /// The arm has `time_left` seconds.
    const fn within(time_left: f64) -> Self {
        Self {
            time_left,
            time_within_limits: 0.0,
        }
    }

    /// Time passes in which the arm is slow enough or not; true when the slowing down is over.
    fn advance(&mut self, is_slow: bool, step: f64) -> bool {
        self.time_left -= step;
        self.time_within_limits = if is_slow {
            self.time_within_limits + step
        } else {
            0.0
        };
        self.time_left <= 0.0 || self.time_within_limits >= MIN_TIME_WITHIN_LIMITS
    }
}

impl LimitSets {
    /// Outside of reduced mode.
    pub(crate) fn new(normal: MotionLimits, reduced: MotionLimits) -> Self {
        Self {
            normal,
            reduced,
            is_reduced: false,
            under_overlay: normal.scaled(SHARE_ON_BELT),
            transition: None,
            without_tcp: None,
            way_speeds: None,
        }
    }

    /// What the arm can do, whatever mode it is in.
    pub(crate) const fn able(&self) -> &MotionLimits {
        &self.normal
    }

    /// What is planned or made cycle by cycle from now on keeps to these.
    pub(crate) const fn in_force(&self) -> &MotionLimits {
        if self.is_reduced {
            &self.reduced
        } else {
            &self.normal
        }
    }

    /// What of the limits in force a motion may use under a belt or an offset.
    pub(crate) const fn under_overlay(&self) -> &MotionLimits {
        &self.under_overlay
    }

    pub(crate) const fn is_reduced(&self) -> bool {
        self.is_reduced
    }

    /// The arm is still coming down to the limits in force.
    pub(crate) const fn is_slowing(&self) -> bool {
        self.transition.is_some()
    }

    /// What setpoints are checked against: the limits in force, unless the arm still slows down to them.
    pub(crate) const fn enforced(&self) -> &MotionLimits {
        match (&self.without_tcp, &self.transition) {
            (Some(limits), Some(_)) => limits,
            (_, None) if self.is_reduced => &self.reduced,
            _ => &self.normal,
        }
    }

    /// Reduced mode begins or ends.
    fn set_reduced(&mut self, is_reduced: bool, time_to_slow_down: f64) {
        self.is_reduced = is_reduced;
        self.transition = is_reduced.then_some(ReducedModeTransition::within(time_to_slow_down));
        self.without_tcp = None;
        self.reset_overlay_share();
    }

    /// The arm has `time` seconds to come down to the limit of the TCP's speed, which another tool exceeds. One that
    /// still comes down to reduced limits goes on doing so.
    fn slow_tcp_down(&mut self, time: f64) {
        if self.transition.is_none() || self.without_tcp.is_some() {
            self.transition = Some(ReducedModeTransition::within(time));
            self.without_tcp = Some(MotionLimits {
                tcp_speed: f64::INFINITY,
                ..*self.in_force()
            });
        }
    }

    /// The arm has come down to the limits in force.
    pub(crate) fn finish_transition(&mut self) {
        self.transition = None;
        self.without_tcp = None;
    }

    /// Motions may use as much as they may before it is known what the belt uses.
    pub(crate) fn reset_overlay_share(&mut self) {
        self.under_overlay = self.in_force().scaled(SHARE_ON_BELT);
    }

    /// The belt leaves these speeds of TCP and elbow to motions, m/s.
    pub(crate) const fn leave_under_belt(&mut self, [tcp, elbow]: [f64; 2]) {
        self.under_overlay.tcp_speed = tcp;
        self.under_overlay.elbow_speed = elbow;
    }

    /// From now on the way ahead is kept within these speeds of TCP and elbow, m/s.
    pub(crate) const fn keep_way_within(&mut self, speeds: [f64; 2]) {
        self.way_speeds = Some(speeds);
    }

    /// The speeds of TCP and elbow that the way ahead is kept within, m/s, where it was planned with others.
    pub(crate) const fn way_speeds(&self) -> Option<[f64; 2]> {
        self.way_speeds
    }
}

impl ControlLoop {
    /// Takes reduced mode over, or leaves it, and looks how far the slowing down is.
    pub(crate) fn update_reduced_mode(&mut self) {
        let is_reduced = self.machine.is_reduced();
        if is_reduced != self.limits.is_reduced {
            let time = MAX_TRANSITION_TIME[usize::from(self.uses_soft_transition())];
            self.limits.set_reduced(is_reduced, time);
            self.keep_way_anew();
        }
        let is_slow =
            self.limits.is_slowing() && self.limit_utilization() <= 1.0 && self.may_be_braked();
        if let Some(slowing) = &mut self.limits.transition
            && slowing.advance(is_slow, self.step)
        {
            self.limits.finish_transition();
        }
    }

    /// On a belt and in online modes TCP and elbow keep to their limits while the joints brake, too: from then on
    /// nothing faster passes.
    pub(crate) fn may_be_braked(&self) -> bool {
        if self.tracking.is_none() && !matches!(self.generator, Generator::Online(_)) {
            return true;
        }
        let at = self.commanded.setpoint();
        let points = PointSpeedLimits::new(
            &self.model,
            self.tool.flange_from_tcp(),
            self.limits.in_force(),
            &at.q,
        );
        let axes = online_axes(self.limits.able(), self.step);
        points.is_none_or(|points| points.is_safe(&states(at), &axes, self.step))
    }

    fn uses_soft_transition(&self) -> bool {
        self.io.image.config.safety_hardness == 1 && self.limits.without_tcp.is_none()
    }

    /// The motion under way has to come down to the limits of reduced mode as hard as the arm can.
    pub(crate) fn needs_hard_transition(&self) -> bool {
        self.limits.is_slowing() && !self.uses_soft_transition()
    }

    /// The limits that motions are planned with now.
    pub(crate) fn planning_limits(&self) -> &MotionLimits {
        if self.tracking.is_some() || self.path_offset.is_on() {
            self.limits.under_overlay()
        } else {
            self.limits.in_force()
        }
    }

    /// The limits that online modes keep: what is laid over them has the rest.
    pub(crate) fn online_limits(&self) -> &MotionLimits {
        if self.tracking.is_some() || self.path_offset.is_on() {
            self.limits.under_overlay()
        } else {
            self.limits.enforced()
        }
    }

    /// The way ahead is as fast as it was planned, until it has been looked at with the limits in force.
    pub(crate) fn keep_way_anew(&mut self) {
        self.queue.clear_speed_caps();
        if self.limits.way_speeds.is_some() {
            self.keep_way();
        }
    }

    /// From now on the way ahead of the motion under way is kept within the limits in force: it was planned with
    /// others.
    pub(crate) fn keep_way(&mut self) {
        let limits = self.planning_limits();
        let speeds = [limits.tcp_speed, limits.elbow_speed];
        self.limits.keep_way_within(speeds);
    }

    /// Keeps the way ahead of a planned motion within the limits in force, where it was planned with others.
    pub(crate) fn cap_path_speed(&mut self) {
        let Generator::Path(motion) = self.generator else {
            if self.pending_motion.is_none() {
                self.limits.way_speeds = None;
            }
            return;
        };
        if !self.limits.is_reduced && self.limits.way_speeds.is_none() {
            return;
        }
        let ground = PathContext {
            model: &self.model,
            points: self.micro_points.points(),
        };
        let (near, tool) = (&self.target.q, self.tool.flange_from_tcp());
        let share = if self.path_offset.is_on() {
            SHARE_UNDER_OFFSETS
        } else {
            1.0
        };
        let limits = self.planning_limits();
        let limits = MotionLimits {
            tcp_speed: share * limits.tcp_speed,
            elbow_speed: share * limits.elbow_speed,
            ..*limits
        };
        self.queue
            .cap_speeds_ahead(&motion, &limits, tool, &ground, near);
    }

    /// An online mode by itself is too fast for reduced mode.
    pub(crate) fn needs_joint_slowdown(&self) -> bool {
        self.limits.is_slowing()
            && matches!(self.generator, Generator::Online(_))
            && self.has_no_overlay()
            && (self.slow_share() < 1.0 || !self.may_be_braked())
    }

    /// With what joints brake that need not stand.
    pub(crate) fn slowing_limits(&self) -> MotionLimits {
        let able = *self.limits.able();
        if !self.uses_soft_transition() {
            return able;
        }
        MotionLimits {
            acceleration: able
                .acceleration
                .map(|a| (SOFT_SHARE * a).min(STOP_ACCELERATION)),
            ..able
        }
    }

    /// Another tool may be too fast for the limit of the TCP's speed where the one before was not: what is under way
    /// comes down to it, as hard as the arm can.
    pub(crate) fn slow_down_for_tool(&mut self) {
        if self.limits.in_force().tcp_speed.is_infinite() || self.is_at_rest() {
            return;
        }
        self.limits.slow_tcp_down(MAX_TRANSITION_TIME[0]);
        if matches!(self.generator, Generator::Path(_)) || self.pending_motion.is_some() {
            self.queue.clear_speed_caps();
            self.keep_way();
        }
    }

    /// Share of the joints' speeds at which the arm is as slow as online modes are to be.
    pub(crate) fn slow_share(&self) -> f64 {
        (SLOW_SHARE / self.limit_utilization()).min(1.0)
    }

    /// Share of the joints' speeds to which an arm is braked that is too fast: less where joints that brake each for
    /// itself would lead the TCP on faster.
    pub(crate) fn braked_share(&self) -> f64 {
        let share = self.slow_share();
        if share < 1.0 { share } else { SLOWER_SHARE }
    }

    /// The largest share of the limits in force that a joint, TCP or elbow use.
    pub(crate) fn limit_utilization(&self) -> f64 {
        let (qd, limits) = (&self.commanded.setpoint().qd, self.limits.in_force());
        let tcp = self.tool.position(self.commanded.frames());
        let tcp_speed = self.commanded.frames().twist(qd, tcp).linear.norm();
        let elbow = elbow_speed(self.commanded.frames(), qd) / limits.elbow_speed;
        (0..6).fold(elbow.max(tcp_speed / limits.tcp_speed), |most, joint| {
            most.max(qd[joint].abs() / limits.speed[joint])
        })
    }

    /// Reduced mode may have narrower ranges than the arm.
    pub(crate) fn check_reduced_range(&self, q: &JointPositions) -> Result<(), Refusal> {
        let limits = self.limits.in_force();
        for (joint, number) in (0u8..6).enumerate() {
            let (min, max) = (limits.position_min[joint], limits.position_max[joint]);
            if self.limits.is_reduced && !(min..=max).contains(&q[joint]) {
                return Err(Refusal::JointLimit {
                    joint: number,
                    value: q[joint],
                    min,
                    max,
                });
            }
        }
        Ok(())
    }
}
