//! Online modes: setpoints made cycle by cycle from what is asked now, with no path planned ahead.
//!
//! - [`axis`]: which next states of a joint leave a way to rest; every mode goes through it.
//! - [`servo`]: a stream of joint positions; [`follower`] is its tracking law.
//! - [`trajectory`]: a list of joint positions, followed in time.
//! - [`joint_speed`], [`tcp_speed`]: speeds of the joints and of the TCP, and coming to rest from them.
//! - `points`: the speed limits of TCP and elbow where joints are steered one by one.
//! - [`freedrive`]: speeds that follow the hand.
//! - `force`: force mode, corrections over whatever moves the arm.
//! - [`conveyor`], [`encoder`]: the belt frame that planned motions are superimposed on.
//!
//! - [`path_offset`]: a small pose that the program lays over the path.
//! - `lag`: what the joints have to make good after they were stopped beside their way.
//!
//! Owns what the modes have in common: whose call it is, when it ends, and how a mode ends. Knows no ring and no
//! events.

pub mod axis;
pub mod conveyor;
pub mod encoder;
pub mod follower;
pub(crate) mod force;
pub mod freedrive;
pub mod joint_speed;
pub(crate) mod lag;
pub mod path_offset;
pub(crate) mod points;
pub mod servo;
pub mod tcp_speed;
pub mod trajectory;

use kinematics::bounds::within;
use kinematics::{
    Dynamics, JointAccelerations, JointPositions, JointSpeeds, JointTorques, Pose, RobotModel,
    Wrench,
};
use motion_api::{CommandId, MotionMode, Origin};

use crate::brake::JointStopMotion;
use crate::config::MotionLimits;
use crate::constants::{
    LEAST_TORQUE_SHARE, PEAK_TORQUE_FACTOR, PLANNED_TORQUE_SHARE, STOP_ACCELERATION,
};
use crate::path::PointValues;
use crate::scalar::ScalarState;
use crate::setpoint::Setpoint;
use axis::AxisLimits;
use freedrive::FreedriveMode;
use joint_speed::JointSpeedMode;
use points::PointSpeedLimits;
use servo::ServoMode;
use tcp_speed::{TcpModeContext, TcpSpeedMode};
use trajectory::TrajectoryMode;

/// What an online mode sees of the arm in one cycle.
pub(crate) struct OnlineContext<'a> {
    pub(crate) model: &'a RobotModel,
    pub(crate) flange_from_tcp: &'a Pose,
    /// Hard limits of the joints.
    pub(crate) axes: [AxisLimits; 6],
    /// Limits of the joints with what the drives and the limits of TCP and elbow leave here.
    pub(crate) available_axes: [AxisLimits; 6],
    /// The hard limits, and what a joint does already where that is more: a TCP that is too fast slows down on its
    /// line.
    under_way: [AxisLimits; 6],
    pub(crate) effort: &'a JointTorques,
    points: Option<PointSpeedLimits<'a>>,
    /// What acts on the tool from outside: base axes, about the TCP.
    pub(crate) external_wrench: Wrench,
    pub(crate) step: f64,
    /// Speed fraction; 0 while paused.
    pub(crate) fraction: f64,
    pub(crate) is_paused: bool,
    /// The list that is followed.
    pub(crate) samples: &'a [PointValues],
}

impl<'a> OnlineContext<'a> {
    /// Looks at the arm where the setpoint `at` is.
    #[allow(clippy::too_many_arguments, reason = "one struct built in one place")]
    pub(crate) fn new(
        model: &'a RobotModel,
        flange_from_tcp: &'a Pose,
        [limits, hard]: [&MotionLimits; 2],
        dynamics: &Dynamics,
        at: &Setpoint,
        hand: Wrench,
        step: f64,
        (fraction, is_paused): (f64, bool),
        samples: &'a [PointValues],
    ) -> Self {
        let axes = online_axes(limits, step);
        let effort = &model.limits().effort;
        let torque = torque_share(dynamics, effort, &axes, at);
        let points = PointSpeedLimits::new(model, flange_from_tcp, limits, &at.q);
        // The joint speeds in the present direction, as fast as the fastest joint can be.
        let used = (0..6).fold(1e-6_f64, |most, joint| {
            most.max(at.qd[joint].abs() / limits.speed[joint])
        });
        let speed = points.map_or(1.0, |points| {
            within(points.speed_factor(&at.qd) * used, 1e-3, 1.0)
        });
        let able = axes.map(|axis| AxisLimits {
            speed: axis.speed * speed,
            acceleration: axis.acceleration * torque,
            ..axis
        });
        let hard = online_axes(hard, step);
        let under_way = core::array::from_fn(|joint| {
            let (axis, hard): (&AxisLimits, &AxisLimits) = (&axes[joint], &hard[joint]);
            let more = |now: f64, most: f64| (UNDER_WAY * now.abs()).min(most);
            AxisLimits {
                speed: axis.speed.max(more(at.qd[joint], hard.speed)),
                acceleration: axis
                    .acceleration
                    .max(more(at.qdd[joint], hard.acceleration)),
                ..*axis
            }
        });
        Self {
            model,
            flange_from_tcp,
            axes,
            available_axes: able,
            under_way,
            effort,
            points,
            external_wrench: hand,
            step,
            fraction,
            is_paused,
            samples,
        }
    }

    /// The factor on `qd` at which neither TCP nor elbow is too fast here.
    pub(crate) fn point_factor(&self, qd: &JointSpeeds) -> f64 {
        self.points
            .map_or(f64::INFINITY, |points| points.speed_factor(qd))
    }

    /// `next`, unless TCP or elbow would become too fast on the way to rest.
    pub(crate) fn clamp_to_safe(
        &self,
        now: &[ScalarState; 6],
        next: [ScalarState; 6],
    ) -> [ScalarState; 6] {
        match &self.points {
            Some(points) => points.clamp_to_safe(now, next, &self.axes, self.step),
            None => next,
        }
    }

    pub(crate) fn tcp(&self) -> TcpModeContext<'_> {
        TcpModeContext {
            model: self.model,
            flange_from_tcp: self.flange_from_tcp,
            axes: &self.under_way,
            able: &self.available_axes,
            points: self.points.as_ref(),
        }
    }
}

/// What a joint does already counts with so much room.
const UNDER_WAY: f64 = 1.05;
/// Largest change of speed by a jerk over one step, as share of the largest speed.
const JERK_OF_SPEED: f64 = 0.5;

/// What each joint may do in online modes.
pub(crate) fn online_axes(limits: &MotionLimits, step: f64) -> [AxisLimits; 6] {
    core::array::from_fn(|joint| {
        let speed = limits.speed[joint];
        // A joint that hardly turns takes its time: a jerk for one step must not make it too fast.
        let jerk = limits.jerk[joint].min(JERK_OF_SPEED * speed / (step * step));
        AxisLimits {
            min: limits.position_min[joint],
            max: limits.position_max[joint],
            // Within a step the speed may be higher than at its ends by that.
            speed: speed - jerk * step * step / 8.0,
            acceleration: limits.acceleration[joint],
            jerk,
        }
    })
}

/// The share of every joint's acceleration at which the drives can accelerate all of them at once, whatever the signs.
fn torque_share(
    dynamics: &Dynamics,
    effort: &JointTorques,
    axes: &[AxisLimits; 6],
    at: &Setpoint,
) -> f64 {
    let mass = dynamics.mass_matrix(&at.q);
    let bias = dynamics.bias_torques(&at.q, &at.qd);
    (0..6).fold(1.0_f64, |least, joint| {
        let planned = effort[joint] * PEAK_TORQUE_FACTOR * PLANNED_TORQUE_SHARE;
        let room = (planned - bias[joint].abs()).max(effort[joint] * LEAST_TORQUE_SHARE);
        let asked: f64 = (0..6)
            .map(|other| mass[(joint, other)].abs() * axes[other].acceleration)
            .sum();
        least.min(room / asked)
    })
}

/// When the call of a command ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum CallCompletion {
    /// After that many seconds.
    AfterTime(f64),
    /// When what was asked is reached.
    OnGoal,
    /// The call has ended already.
    Returned,
}

/// How the setpoints are made.
#[derive(Clone, Copy, Debug)]
#[allow(
    clippy::large_enum_variant,
    reason = "lives in place for the life of the controller; the cycle must not allocate"
)]
pub(crate) enum OnlineMode {
    Servo(ServoMode),
    Trajectory(TrajectoryMode),
    JointSpeed(JointSpeedMode),
    TcpSpeed(TcpSpeedMode),
    Freedrive(FreedriveMode),
    /// Each joint comes to rest as fast as it can.
    Brake(JointStopMotion),
}

/// An online mode under way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ActiveOnlineMode {
    pub(crate) id: CommandId,
    pub(crate) origin: Origin,
    pub(crate) mode: MotionMode,
    pub(crate) call_completion: CallCompletion,
    pub(crate) kind: OnlineMode,
    /// A stop was asked for; the mode ends where the arm comes to rest.
    pub(crate) is_stopping: bool,
    /// A warning that the arm is held back was given.
    pub(crate) is_warned: bool,
}

/// One cycle of an online mode.
pub(crate) struct OnlineStep {
    pub(crate) setpoint: Setpoint,
    /// The joint that holds the motion back, to be told once.
    pub(crate) limiting_joint: Option<u8>,
    /// The call has ended in this cycle.
    pub(crate) has_ended: bool,
}

impl ActiveOnlineMode {
    /// The call has ended; the mode goes on by itself.
    pub(crate) fn has_ended(&self) -> bool {
        self.call_completion == CallCompletion::Returned
    }

    /// The hand leads the arm and has not been told to let go.
    pub(crate) fn is_led_by_hand(&self) -> bool {
        matches!(self.kind, OnlineMode::Freedrive(_)) && !self.is_stopping
    }

    /// The joint positions that the mode leads to, where there are any.
    pub(crate) fn goal(&self) -> Option<JointPositions> {
        match &self.kind {
            OnlineMode::Servo(servo) => Some(*servo.goal()),
            OnlineMode::Trajectory(trajectory) => Some(*trajectory.goal()),
            _ => None,
        }
    }

    /// The trajectory under way.
    pub(crate) const fn trajectory(&self) -> Option<&TrajectoryMode> {
        match &self.kind {
            OnlineMode::Trajectory(trajectory) if !self.is_stopping => Some(trajectory),
            _ => None,
        }
    }

    /// A trajectory comes to rest on its way.
    pub(crate) const fn stops_on_its_way(&self) -> bool {
        matches!(self.kind, OnlineMode::Trajectory(_))
    }

    /// From `from` to rest by `kind`, with no command behind it.
    pub(crate) fn to_rest(kind: OnlineMode) -> Self {
        Self {
            id: CommandId::NONE,
            origin: Origin::default(),
            mode: MotionMode::Stopping,
            call_completion: CallCompletion::Returned,
            kind,
            is_stopping: true,
            is_warned: true,
        }
    }

    /// True when the motion is led from outside, by a stream or by a hand.
    pub(crate) const fn follows_from_outside(&self) -> bool {
        matches!(self.kind, OnlineMode::Servo(_) | OnlineMode::Freedrive(_)) && !self.is_stopping
    }

    /// Each joint comes to rest as fast as it can.
    pub(crate) const fn is_braking_joints(&self) -> bool {
        matches!(self.kind, OnlineMode::Brake(_))
    }

    /// Brings the arm to rest for a motion that follows, along its line where it is on one. One that comes to rest
    /// already goes on doing so.
    pub(crate) fn make_way(&mut self, from: &Setpoint) {
        if self.is_stopping {
            return;
        }
        self.is_stopping = true;
        match &mut self.kind {
            OnlineMode::Brake(_) | OnlineMode::Trajectory(_) => {}
            OnlineMode::TcpSpeed(tcp) => {
                tcp.set_goal([0.0; 6], STOP_ACCELERATION, STOP_ACCELERATION)
            }
            OnlineMode::Freedrive(freedrive) => freedrive.stop(),
            OnlineMode::Servo(_) | OnlineMode::JointSpeed(_) => {
                let now = states(from);
                let acceleration = STOP_ACCELERATION;
                self.kind = OnlineMode::JointSpeed(JointSpeedMode::new(
                    &now,
                    &JointSpeeds::ZERO,
                    acceleration,
                ));
            }
        }
    }

    /// Lets the mode go on from `from`, where the arm stands after something else moved it; its goal stays.
    pub(crate) fn resume_from(&mut self, arm: &OnlineContext, from: &Setpoint) {
        match &mut self.kind {
            OnlineMode::Servo(servo) => servo.resume_from(&from.q),
            OnlineMode::Trajectory(trajectory) => {
                trajectory.fade_from(arm.samples, &states(from), arm);
            }
            OnlineMode::JointSpeed(joints) => joints.go_on_from(&states(from)),
            OnlineMode::TcpSpeed(tcp) => tcp.resume_from(&arm.tcp(), from),
            OnlineMode::Freedrive(freedrive) => freedrive.resume_from(arm, from),
            OnlineMode::Brake(brake) => *brake = JointStopMotion::standing(from),
        }
    }

    /// The TCP is another from now on; the arm is at `from`.
    pub(crate) fn change_tcp(&mut self, arm: &OnlineContext, from: &Setpoint) {
        match &mut self.kind {
            OnlineMode::Servo(_)
            | OnlineMode::Trajectory(_)
            | OnlineMode::JointSpeed(_)
            | OnlineMode::Brake(_) => {}
            OnlineMode::TcpSpeed(tcp) => tcp.resume_from(&arm.tcp(), from),
            OnlineMode::Freedrive(freedrive) => freedrive.resume_from(arm, from),
        }
    }

    /// Whether the mode keeps the arm in motion although nothing moves now.
    fn has_pending_motion(&self, target: &Setpoint) -> bool {
        match &self.kind {
            _ if self.is_stopping => false,
            OnlineMode::Freedrive(_) => true,
            OnlineMode::Servo(servo) => !servo.has_arrived(&target.q),
            OnlineMode::Trajectory(trajectory) => !trajectory.has_arrived(&target.q),
            OnlineMode::JointSpeed(joints) => joints.goal().max_abs() > 0.0,
            OnlineMode::TcpSpeed(tcp) => tcp.has_goal(),
            OnlineMode::Brake(_) => false,
        }
    }

    /// Whether the mode is over when the arm stands.
    pub(crate) fn is_over(&self, target: &Setpoint) -> bool {
        (self.is_stopping || self.has_ended())
            && is_setpoint_at_rest(target)
            && !self.has_pending_motion(target)
    }

    /// The setpoint one step after `from`.
    pub(crate) fn next(&mut self, arm: &OnlineContext, from: &Setpoint) -> OnlineStep {
        let now = states(from);
        let mut held = None;
        let fraction = if self.is_stopping { 1.0 } else { arm.fraction };
        let (setpoint, is_reached) = match &mut self.kind {
            OnlineMode::Servo(servo) => {
                let next = if fraction == 0.0 {
                    servo.next_held(&now, arm)
                } else {
                    servo.next(&now, arm, arm.step * fraction)
                };
                let next = arm.clamp_to_safe(&now, next);
                (setpoint(&next), false)
            }
            OnlineMode::Trajectory(trajectory) => {
                let fraction = if self.is_stopping { 0.0 } else { arm.fraction };
                let next = trajectory.next(&now, arm, fraction);
                let next = setpoint(&arm.clamp_to_safe(&now, next));
                let is_reached = trajectory.has_arrived(&next.q) && is_setpoint_at_rest(&next);
                (next, is_reached)
            }
            OnlineMode::JointSpeed(joints) => {
                let (next, limited) = joints.next(&now, arm, fraction);
                let next = arm.clamp_to_safe(&now, next);
                held = limited;
                (
                    setpoint(&next),
                    joints.is_reached(&next, fraction) && fraction > 0.0,
                )
            }
            OnlineMode::TcpSpeed(tcp) => match tcp.next(&arm.tcp(), from, arm.step, fraction) {
                Some((next, limited)) => {
                    held = limited;
                    (next, tcp.is_reached(&arm.tcp(), fraction) && fraction > 0.0)
                }
                None => {
                    // The line cannot be kept: the joints brake one by one, and the arm stays where that leads.
                    held = Some(0);
                    let brake = JointSpeedMode::new(&now, &JointSpeeds::ZERO, STOP_ACCELERATION);
                    let (next, _) = brake.next(&now, arm, 1.0);
                    self.kind = OnlineMode::JointSpeed(brake);
                    (setpoint(&arm.clamp_to_safe(&now, next)), false)
                }
            },
            OnlineMode::Freedrive(freedrive) => (freedrive.next(arm, from, &now), false),
            OnlineMode::Brake(brake) => (brake.next(arm.step), false),
        };
        let held = held.filter(|_| !self.is_warned && !self.is_stopping);
        self.is_warned |= held.is_some();
        OnlineStep {
            setpoint,
            limiting_joint: held,
            has_ended: self.update_call(arm, is_reached),
        }
    }

    /// Whether the call ends in this cycle.
    fn update_call(&mut self, arm: &OnlineContext, is_reached: bool) -> bool {
        let ends = match &mut self.call_completion {
            CallCompletion::Returned => false,
            CallCompletion::OnGoal => is_reached,
            CallCompletion::AfterTime(left) => {
                // A servoj lasts as long as its reference is under way, which the speed fraction stretches.
                let time = match self.kind {
                    _ if arm.is_paused => 0.0,
                    OnlineMode::Servo(_) => arm.step * arm.fraction,
                    _ => arm.step,
                };
                *left -= time;
                *left < 0.5e-6
            }
        };
        if ends {
            self.call_completion = CallCompletion::Returned;
        }
        ends
    }
}

/// The joints of a setpoint as scalar states.
pub(crate) fn states(setpoint: &Setpoint) -> [ScalarState; 6] {
    core::array::from_fn(|joint| ScalarState {
        position: setpoint.q[joint],
        speed: setpoint.qd[joint],
        acceleration: setpoint.qdd[joint],
    })
}

fn setpoint(states: &[ScalarState; 6]) -> Setpoint {
    Setpoint {
        q: JointPositions(states.map(|s| s.position)),
        qd: JointSpeeds(states.map(|s| s.speed)),
        qdd: JointAccelerations(states.map(|s| s.acceleration)),
    }
}

/// Nothing moves.
pub(crate) fn is_setpoint_at_rest(setpoint: &Setpoint) -> bool {
    setpoint.qd.max_abs() == 0.0 && setpoint.qdd.max_abs() == 0.0
}
