//! freedrive: the arm gives way to the hand (manual 3.1.41).
//!
//! Admittance: a virtual mass with damping follows the wrench from outside, M dv/dt + D v = F. With all axes free the
//! law acts on the joints (torques J^T F), which knows no singular position; with locked axes it acts on the free
//! components of the TCP's velocity, and the locked ones stay exactly zero. Gravity and payload are carried by the
//! servo. The figures are our choice: 10 N move the hand at 0.1 m/s after about 0.1 s.

use kinematics::bounds::within;
use kinematics::{JointSpeeds, Pose};
use motion_api::FreedriveFrame;
use nalgebra::{Rotation3, Vector6};

use super::OnlineContext;
use super::axis::AxisLimits;
use super::joint_speed::JointSpeedMode;
use super::tcp_speed::{TcpSpeedMode, TwistFrame, components};
use crate::constants::{ACCELERATION_RISE, STOP_ACCELERATION};
use crate::scalar::ScalarState;
use crate::setpoint::Setpoint;

/// Damping, N s/m and Nm s/rad.
const DAMPING: [f64; 2] = [100.0, 5.0];
/// Damping of a joint per Nm of its nominal torque, s/rad.
const JOINT_DAMPING: f64 = 0.2;
/// Mass over damping, s.
const TIME_CONSTANT: f64 = 0.1;
/// Wrenches below move nothing, N and Nm: a resting hand, noise.
const DEAD_BAND: [f64; 2] = [1.0, 0.1];
/// Fastest the hand can lead, m/s and rad/s.
const SPEED_MAX: [f64; 2] = [0.75, 1.5];
/// Hardest acceleration, m/s² and rad/s².
const ACCELERATION_MAX: [f64; 2] = [5.0, 10.0];

/// The arm led by hand.
#[derive(Clone, Copy, Debug)]
pub struct FreedriveMode {
    free: [bool; 6],
    axes: TwistFrame,
    motion: FreedriveLaw,
    is_stopping: bool,
}

#[derive(Clone, Copy, Debug)]
#[allow(
    clippy::large_enum_variant,
    reason = "lives in place for the life of the controller; the cycle must not allocate"
)]
enum FreedriveLaw {
    /// All axes free.
    Joints,
    /// Some locked.
    Tcp(TcpSpeedMode),
    /// The line could not be kept; the arm comes to rest and goes on from there.
    Brake(JointSpeedMode),
}

impl FreedriveMode {
    /// From the setpoint `from`, which stands or was led by hand.
    pub(crate) fn new(
        arm: &OnlineContext,
        from: &Setpoint,
        free: [bool; 6],
        frame: FreedriveFrame,
    ) -> Self {
        let axes = axes(frame);
        let motion = if free == [true; 6] {
            FreedriveLaw::Joints
        } else {
            FreedriveLaw::Tcp(TcpSpeedMode::new(&arm.tcp(), from, axes))
        };
        Self {
            free,
            axes,
            motion,
            is_stopping: false,
        }
    }

    /// Comes to rest, whatever the hand does.
    pub(crate) fn stop(&mut self) {
        self.is_stopping = true;
    }

    /// The hand leads on from the motion `from`, of the TCP that `arm` has now.
    pub(crate) fn resume_from(&mut self, arm: &OnlineContext, from: &Setpoint) {
        match &mut self.motion {
            FreedriveLaw::Joints => {}
            FreedriveLaw::Tcp(tcp) => tcp.resume_from(&arm.tcp(), from),
            FreedriveLaw::Brake(_) if super::is_setpoint_at_rest(from) => {
                self.motion = FreedriveLaw::Tcp(TcpSpeedMode::new(&arm.tcp(), from, self.axes));
            }
            FreedriveLaw::Brake(_) => {}
        }
    }

    /// The setpoint one step later.
    pub(crate) fn next(
        &mut self,
        arm: &OnlineContext,
        from: &Setpoint,
        now: &[ScalarState; 6],
    ) -> Setpoint {
        let hand = if self.is_stopping || arm.fraction == 0.0 {
            Vector6::zeros()
        } else {
            arm.external_wrench.to_vector()
        };
        let states = match &mut self.motion {
            FreedriveLaw::Joints => {
                arm.clamp_to_safe(now, apply_joint_admittance(arm, from, now, &hand))
            }
            FreedriveLaw::Brake(brake) => {
                let (next, _) = brake.next(now, arm, 1.0);
                if next.iter().all(|s| s.speed == 0.0 && s.acceleration == 0.0) {
                    let here = super::setpoint(&next);
                    self.motion =
                        FreedriveLaw::Tcp(TcpSpeedMode::new(&arm.tcp(), &here, self.axes));
                }
                next
            }
            FreedriveLaw::Tcp(tcp) => {
                apply_tcp_admittance(tcp, &hand, &self.free);
                match tcp.next(&arm.tcp(), from, arm.step, 1.0) {
                    Some((next, _)) => return next,
                    None => {
                        let brake = JointSpeedMode::new(now, &JointSpeeds::ZERO, STOP_ACCELERATION);
                        let (next, _) = brake.next(now, arm, 1.0);
                        self.motion = FreedriveLaw::Brake(brake);
                        next
                    }
                }
            }
        };
        super::setpoint(&states)
    }
}

/// The axes of a frame of the manual.
fn axes(frame: FreedriveFrame) -> TwistFrame {
    match frame {
        FreedriveFrame::Base => TwistFrame::Fixed(Rotation3::identity()),
        FreedriveFrame::Tool => TwistFrame::Tool,
        FreedriveFrame::Pose(pose) => TwistFrame::Fixed(Pose::from_rpy(&pose).rotation),
    }
}

/// Aims the TCP at the speed that the hand leads to in the end, as fast as the virtual mass lets it.
fn apply_tcp_admittance(tcp: &mut TcpSpeedMode, hand: &Vector6<f64>, free: &[bool; 6]) {
    let hand = components(tcp, hand);
    let velocity = tcp.velocity();
    let mut goal = [0.0; 6];
    let mut acceleration = [0.0; 2];
    for part in 0..2 {
        let range = 3 * part..3 * part + 3;
        for k in range.clone() {
            goal[k] = if free[k] {
                apply_dead_band(hand[k], DEAD_BAND[part]) / DAMPING[part]
            } else {
                0.0
            };
        }
        let norm = |v: &[f64; 6]| v[range.clone()].iter().map(|x| x * x).sum::<f64>().sqrt();
        let speed = norm(&goal);
        if speed > SPEED_MAX[part] {
            goal[range.clone()]
                .iter_mut()
                .for_each(|x| *x *= SPEED_MAX[part] / speed);
        }
        let gap: [f64; 6] = core::array::from_fn(|k| goal[k] - velocity[k]);
        acceleration[part] = within(norm(&gap) / TIME_CONSTANT, 0.05, ACCELERATION_MAX[part]);
    }
    tcp.set_goal(goal, acceleration[0], acceleration[1]);
}

/// All axes free: each joint follows its torque.
fn apply_joint_admittance(
    arm: &OnlineContext,
    from: &Setpoint,
    now: &[ScalarState; 6],
    hand: &Vector6<f64>,
) -> [ScalarState; 6] {
    let frames = arm.model.forward(&from.q);
    let tcp = (frames.base_from_flange * *arm.flange_from_tcp).translation;
    let torque = frames.jacobian(tcp).transpose() * hand;
    core::array::from_fn(|joint| {
        let (axis, able) = (&arm.axes[joint], &arm.available_axes[joint]);
        let effort = arm.effort[joint];
        let led = apply_dead_band(torque[joint], 0.005 * effort) / (JOINT_DAMPING * effort);
        let goal = within(led, -0.5 * able.speed, 0.5 * able.speed);
        let goal = axis.slowed_before_ends(now[joint].position, goal);
        let acceleration = within(
            (goal - now[joint].speed).abs() / TIME_CONSTANT,
            0.05_f64.min(able.acceleration),
            able.acceleration,
        );
        let soft = AxisLimits {
            acceleration,
            jerk: axis.jerk.min(able.acceleration / ACCELERATION_RISE),
            ..*axis
        };
        let wanted = soft.step_towards_speed(&now[joint], goal, arm.step);
        axis.clamp_to_safe(&now[joint], &wanted, arm.step).0
    })
}

/// `x` with the part within ±`band` removed, continuous.
fn apply_dead_band(x: f64, band: f64) -> f64 {
    (x.abs() - band).max(0.0).copysign(x)
}
