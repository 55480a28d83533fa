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

/// The two sets of limits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LimitSets {
    normal: MotionLimits,
    reduced: MotionLimits,
    is_reduced: bool,
    transition: Option<ReducedModeTransition>,
    /// While the arm slows down for another tool: the limits in force without that of the TCP's speed.
    without_tcp: Option<MotionLimits>,
}

/// An arm that is faster than reduced mode allows.
#[derive(Clone, Copy, Debug)]
struct ReducedModeTransition {
    /// Time until the arm must be slow enough, s.
    time_left: f64,
    /// For how long the arm has been slow enough, s.
    time_within_limits: f64,
}

impl LimitSets {
    /// Outside of reduced mode.
    pub(crate) const fn new(normal: MotionLimits, reduced: MotionLimits) -> Self {
        Self {
            normal,
            reduced,
            is_reduced: false,
            transition: None,
            without_tcp: None,
        }
    }

    /// What the arm can do, whatever mode it is in.
    pub(crate) const fn able(&self) -> &MotionLimits {
        &self.normal
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
}

impl ControlLoop {
    /// Takes reduced mode over, or leaves it, and looks how far the slowing down is.
    pub(crate) fn update_reduced_mode(&mut self) {
        let is_reduced = self.machine.is_reduced();
        if is_reduced != self.limit_sets.is_reduced {
            self.limit_sets.is_reduced = is_reduced;
            let left = MAX_TRANSITION_TIME[usize::from(self.uses_soft_transition())];
            let slow_for = 0.0;
            self.limit_sets.transition = is_reduced.then_some(ReducedModeTransition {
                time_left: left,
                time_within_limits: slow_for,
            });
            self.limit_sets.without_tcp = None;
            self.limits = if is_reduced {
                self.limit_sets.reduced
            } else {
                self.limit_sets.normal
            };
            self.overlay_limits = self.limits.scaled(SHARE_ON_BELT);
            self.keep_way_anew();
        }
        let is_slow = self.limit_sets.transition.is_some()
            && self.limit_utilization() <= 1.0
            && self.may_be_braked();
        if let Some(slowing) = &mut self.limit_sets.transition {
            slowing.time_left -= self.step;
            slowing.time_within_limits = if is_slow {
                slowing.time_within_limits + self.step
            } else {
                0.0
            };
            if slowing.time_left <= 0.0 || slowing.time_within_limits >= MIN_TIME_WITHIN_LIMITS {
                self.finish_transition();
            }
        }
    }

    /// On a belt and in online modes TCP and elbow keep to their limits while the joints brake, too: from then on
    /// nothing faster passes.
    pub(crate) fn may_be_braked(&self) -> bool {
        if self.tracking.is_none() && !matches!(self.generator, Generator::Online(_)) {
            return true;
        }
        let at = &self.commanded;
        let points = PointSpeedLimits::new(&self.model, &self.flange_from_tcp, &self.limits, &at.q);
        let axes = online_axes(self.limit_sets.able(), self.step);
        points.is_none_or(|points| points.is_safe(&states(at), &axes, self.step))
    }

    fn uses_soft_transition(&self) -> bool {
        self.io.image.config.safety_hardness == 1 && self.limit_sets.without_tcp.is_none()
    }

    /// The motion under way has to come down to the limits of reduced mode as hard as the arm can.
    pub(crate) fn needs_hard_transition(&self) -> bool {
        self.limit_sets.transition.is_some() && !self.uses_soft_transition()
    }

    /// The limits that online modes keep: what is laid over them has the rest.
    pub(crate) fn online_limits(&self) -> &MotionLimits {
        if self.tracking.is_some() || self.path_offset.is_on() {
            &self.overlay_limits
        } else {
            self.limit_sets.enforced()
        }
    }

    /// The way ahead is as fast as it was planned, until it has been looked at with the limits in force.
    pub(crate) fn keep_way_anew(&mut self) {
        self.queue.clear_speed_caps();
        if self.keeps_way.is_some() {
            self.keep_way();
        }
    }

    /// From now on the way ahead of the motion under way is kept within the limits in force: it was planned with
    /// others.
    pub(crate) fn keep_way(&mut self) {
        let limits = self.planning_limits();
        self.keeps_way = Some([limits.tcp_speed, limits.elbow_speed]);
    }

    /// Keeps the way ahead of a planned motion within the limits in force, where it was planned with others.
    pub(crate) fn cap_path_speed(&mut self) {
        let Generator::Path(motion) = self.generator else {
            if self.pending_motion.is_none() {
                self.keeps_way = None;
            }
            return;
        };
        if !self.limit_sets.is_reduced && self.keeps_way.is_none() {
            return;
        }
        let ground = PathContext {
            model: &self.model,
            points: self.micro_points.points(),
        };
        let (near, tool) = (&self.target.q, &self.flange_from_tcp);
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
        self.limit_sets.transition.is_some()
            && matches!(self.generator, Generator::Online(_))
            && self.has_no_overlay()
            && (self.slow_share() < 1.0 || !self.may_be_braked())
    }

    /// With what joints brake that need not stand.
    pub(crate) fn slowing_limits(&self) -> MotionLimits {
        let able = *self.limit_sets.able();
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

    /// The arm has come down to the limits in force.
    pub(crate) fn finish_transition(&mut self) {
        self.limit_sets.transition = None;
        self.limit_sets.without_tcp = None;
    }

    /// Another tool may be too fast for the limit of the TCP's speed where the one before was not: what is under way
    /// comes down to it, as hard as the arm can.
    pub(crate) fn slow_down_for_tool(&mut self) {
        if self.limits.tcp_speed.is_infinite() || self.is_at_rest() {
            return;
        }
        // An arm that still comes down to reduced limits goes on doing so.
        if self.limit_sets.transition.is_none() || self.limit_sets.without_tcp.is_some() {
            self.limit_sets.transition = Some(ReducedModeTransition {
                time_left: MAX_TRANSITION_TIME[0],
                time_within_limits: 0.0,
            });
            self.limit_sets.without_tcp = Some(MotionLimits {
                tcp_speed: f64::INFINITY,
                ..self.limits
            });
        }
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
        let (qd, limits) = (&self.commanded.qd, &self.limits);
        let tcp = (self.target_frames.base_from_flange * self.flange_from_tcp).translation;
        let tcp_speed = self.target_frames.twist(qd, tcp).linear.norm();
        let elbow = elbow_speed(&self.target_frames, qd) / limits.elbow_speed;
        (0..6).fold(elbow.max(tcp_speed / limits.tcp_speed), |most, joint| {
            most.max(qd[joint].abs() / limits.speed[joint])
        })
    }

    /// Reduced mode may have narrower ranges than the arm.
    pub(crate) fn check_reduced_range(&self, q: &JointPositions) -> Result<(), Refusal> {
        let limits = &self.limits;
        for (joint, number) in (0u8..6).enumerate() {
            let (min, max) = (limits.position_min[joint], limits.position_max[joint]);
            if self.limit_sets.is_reduced && !(min..=max).contains(&q[joint]) {
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
