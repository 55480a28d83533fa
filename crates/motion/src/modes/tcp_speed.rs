//! speedl, stopl and the locked axes of freedrive: a velocity of the TCP under acceleration and jerk limits.
//!
//! The velocity changes along a straight line in twist space, so a motion in one direction stays on its line exactly:
//! the pose is integrated and the joints follow by inverse kinematics. A next state counts only if its joints are
//! within their limits and the TCP can brake to rest from it without any joint leaving them; where that fails the
//! velocity is lowered. So the arm slows down on its line before a singular position, the end of a joint's range or of
//! its reach. Limits of the speeds of TCP and elbow are kept on the way to rest as in the joint modes.

use kinematics::bounds::within;
use kinematics::{JointAccelerations, JointSpeeds, Pose, RobotModel, Twist};
use nalgebra::{Rotation3, Vector3, Vector6};

use super::axis::AxisLimits;
use super::points::PointSpeedLimits;
use super::states;
use crate::constants::{ACCELERATION_RISE, PAUSE_SHARE};
use crate::scalar::ScalarState;
use crate::scalar::ramp::ramp;
use crate::setpoint::Setpoint;

/// Places of a braking that are looked at.
const BRAKING_SAMPLES: u32 = 8;
/// Shares of the wanted velocity that are tried, then braking.
const SHARES: [f64; 5] = [1.0, 0.75, 0.5, 0.25, 0.0];
/// Share of a joint's speed and acceleration that the TCP mode uses; the rest covers what lies between two looks.
const JOINT_SHARE: f64 = 0.9;
/// Share of a joint's speed and acceleration for braking that is already under way, which was looked at before.
const BRAKE_SHARE: f64 = 0.98;
/// Share of a joint's jerk: accelerations at two ends of a cycle tell less about it.
const JERK_SHARE: f64 = 0.8;
/// Share of the acceleration the joints can give the TCP that changes of its velocity are planned with.
const BRAKING_SHARE: f64 = 0.6;
/// Share of the TCP's speed limit that is aimed at: from there the joints can always brake within it.
const TCP_SPEED_SHARE: f64 = 0.97;
/// Hardest braking of the TCP, m/s² and rad/s².
const BRAKING_MAX: f64 = 10.0;

/// More than any arm can do, m/s² and rad/s²: what is asked for beyond it is the same wish.
const BEYOND_ANY_ARM: f64 = 100.0;

/// The joint that is named at the end of the reach, where no single one is to blame: the elbow, which stretches.
const OUT_OF_REACH: u8 = 2;
/// The joint that is named in a singular position, where no single one is to blame: wrist 2 is the usual one.
const SINGULAR: u8 = 4;
/// The joint that is named where TCP or elbow would be too fast: joint 2 moves both.
const ELBOW: u8 = 1;

/// Axes in which the velocity is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TwistFrame {
    /// Fixed in the base.
    Fixed(Rotation3<f64>),
    /// The TCP's own.
    Tool,
}

/// The arm a TCP mode moves.
#[derive(Clone, Copy)]
pub struct TcpModeContext<'a> {
    /// Geometry with the limits in force.
    pub model: &'a RobotModel,
    /// The active TCP.
    pub flange_from_tcp: &'a Pose,
    /// What each joint may do.
    pub axes: &'a [AxisLimits; 6],
    /// Limits of each joint with what the drives leave here.
    pub able: &'a [AxisLimits; 6],
    /// What limits the speeds of TCP and elbow, where anything does.
    pub(super) points: Option<&'a PointSpeedLimits<'a>>,
}

/// A TCP velocity to be reached and held.
#[derive(Clone, Copy, Debug)]
pub struct TcpSpeedMode {
    axes: TwistFrame,
    base_from_tcp: Pose,
    /// Velocity now: linear, then angular, in `axes`; `position` of the states is not used.
    now: [ScalarState; 6],
    goal: [f64; 6],
    /// Acceleration of the linear and of the angular part, m/s² and rad/s².
    acceleration: [f64; 2],
    /// Accelerations with which the TCP can brake from where it is, m/s² and rad/s².
    braking: [f64; 2],
    /// What a pause or the slider slows down with, m/s² and rad/s²; 0 while neither does.
    slowing: [f64; 2],
}

/// A decomposed Jacobian.
type Lu6 = nalgebra::LU<f64, nalgebra::U6, nalgebra::U6>;

/// One candidate for the next cycle.
struct VelocityCandidate {
    now: [ScalarState; 6],
    base_from_tcp: Pose,
    setpoint: Setpoint,
}

impl TcpSpeedMode {
    /// From the motion `from` of the joints; the goal is to stand.
    pub fn new(arm: &TcpModeContext, from: &Setpoint, axes: TwistFrame) -> Self {
        let frames = arm.model.forward(&from.q);
        let base_from_tcp = frames.base_from_flange * *arm.flange_from_tcp;
        let twist = frames.twist(&from.qd, base_from_tcp.translation);
        let bias = frames.jacobian_rate_times_speeds(&from.qd, base_from_tcp.translation);
        let driven = frames.twist(&JointSpeeds(from.qdd.0), base_from_tcp.translation);
        let rotation = rotation_of(axes, &base_from_tcp);
        let speed = in_axes(&rotation, &twist);
        let change = in_axes(
            &rotation,
            &Twist {
                linear: driven.linear + bias.linear - frame_rotation_acceleration(axes, &twist),
                angular: driven.angular + bias.angular,
            },
        );
        Self {
            axes,
            base_from_tcp,
            now: core::array::from_fn(|k| ScalarState {
                position: 0.0,
                speed: speed[k],
                acceleration: change[k],
            }),
            goal: [0.0; 6],
            acceleration: [1.0; 2],
            braking: [1.0; 2],
            slowing: [0.0; 2],
        }
    }

    /// Sets the wanted velocity, in the axes, and how fast it is to be reached.
    pub fn set_goal(&mut self, goal: [f64; 6], acceleration: f64, rotation_acceleration: f64) {
        self.goal = goal;
        self.acceleration = [acceleration, rotation_acceleration].map(|a| a.min(BEYOND_ANY_ARM));
    }

    /// Keeps the goal, and goes on from the motion `from` of the TCP that `arm` has now.
    pub fn resume_from(&mut self, arm: &TcpModeContext, from: &Setpoint) {
        *self = Self {
            goal: self.goal,
            acceleration: self.acceleration,
            ..Self::new(arm, from, self.axes)
        };
    }

    /// Whether a motion is wanted.
    pub fn has_goal(&self) -> bool {
        self.goal.iter().any(|x| *x != 0.0)
    }

    /// Velocity now, in the axes.
    pub fn velocity(&self) -> [f64; 6] {
        self.now.map(|state| state.speed)
    }

    /// Rotation of the axes in the base frame.
    pub fn rotation(&self) -> Rotation3<f64> {
        rotation_of(self.axes, &self.base_from_tcp)
    }

    /// Whether the velocity is what is wanted, at a fraction of the goal.
    pub fn is_reached(&self, arm: &TcpModeContext, fraction: f64) -> bool {
        let fraction = fraction * self.speed_limit_factor(arm);
        self.now.iter().zip(self.goal).all(|(now, goal)| {
            (now.speed - goal * fraction).abs() < 1e-9 && now.acceleration == 0.0
        })
    }

    /// The factor on the goal at which the TCP keeps its speed limit, now and on the way to rest.
    fn speed_limit_factor(&self, arm: &TcpModeContext) -> f64 {
        let linear = Vector3::new(self.goal[0], self.goal[1], self.goal[2]).norm();
        let most = arm.points.map_or(f64::INFINITY, |p| p.tcp_speed());
        (TCP_SPEED_SHARE * most / linear).min(1.0)
    }

    /// The setpoint one step later and the joint for which the wanted velocity had to be lowered; `None` when not even
    /// braking on the line keeps the joints within their limits.
    pub fn next(
        &mut self,
        arm: &TcpModeContext,
        from: &Setpoint,
        step: f64,
        fraction: f64,
    ) -> Option<(Setpoint, Option<u8>)> {
        let is_still = self
            .now
            .iter()
            .all(|s| s.speed == 0.0 && s.acceleration == 0.0);
        if is_still && self.goal.iter().all(|x| *x * fraction == 0.0) {
            return Some((Setpoint::standing(from.q), None));
        }
        let mut held = None;
        let jacobian = arm.model.forward(&from.q);
        let jacobian = jacobian.jacobian(self.base_from_tcp.translation).lu();
        let braking = self.braking(arm, &jacobian);
        let is_slowed = fraction < 1.0;
        let fraction = fraction * self.speed_limit_factor(arm);
        let goal = self.goal.map(|x| x * fraction);
        let mut acceleration = self.within_joints(arm, &jacobian, &goal);
        // A pause and the slider slow down with a share of what the joints can do at least, whatever was asked for;
        // what has begun so ends so.
        for (k, asked) in acceleration.iter_mut().enumerate() {
            if !is_slowed {
                self.slowing[k] = 0.0;
            } else if is_slower(&goal, &self.now) {
                self.slowing[k] = self.slowing[k].max(PAUSE_SHARE / BRAKING_SHARE * braking[k]);
            }
            *asked = asked.max(self.slowing[k]);
        }
        for (k, share) in SHARES.iter().enumerate() {
            let goal = goal.map(|x| x * share);
            // The last one brakes as hard as the joints can.
            let is_last = k + 1 == SHARES.len();
            let (limits, axes, joint_share) = if is_last {
                (self.braking, arm.axes, BRAKE_SHARE)
            } else {
                (acceleration, arm.able, JOINT_SHARE)
            };
            let now = ramp_velocity(&self.now, &goal, &limits, step);
            let next = match self.candidate(arm, axes, joint_share, from, now, step) {
                Ok(next) => next,
                Err(joint) => {
                    held = held.or(Some(joint));
                    continue;
                }
            };
            match self.can_brake(arm, &next, &braking) {
                Err(joint) if !is_last => held = held.or(Some(joint)),
                feasible => {
                    if feasible.is_ok() && !is_last {
                        self.braking = braking;
                    }
                    self.now = next.now;
                    self.base_from_tcp = next.base_from_tcp;
                    return Some((next.setpoint, held));
                }
            }
        }
        None
    }

    /// The joints for a velocity `now` at the end of the step, if they are within their limits.
    fn candidate(
        &self,
        arm: &TcpModeContext,
        axes: &[AxisLimits; 6],
        share: f64,
        from: &Setpoint,
        now: [ScalarState; 6],
        step: f64,
    ) -> Result<VelocityCandidate, u8> {
        let base_from_tcp = integrate_pose(&self.base_from_tcp, self.axes, &now);
        let q = arm
            .model
            .inverse_nearest(&base_from_tcp, arm.flange_from_tcp, &from.q)
            .ok_or(OUT_OF_REACH)?;
        let frames = arm.model.forward(&q);
        let point = base_from_tcp.translation;
        let rotation = rotation_of(self.axes, &base_from_tcp);
        let lu = frames.jacobian(point).lu();
        let twist = from_axes(&rotation, &now.map(|s| s.speed));
        let qd = lu.solve(&twist.to_vector()).ok_or(SINGULAR)?;
        let qd = JointSpeeds(qd.into());
        let mut change = from_axes(&rotation, &now.map(|s| s.acceleration));
        change.linear += frame_rotation_acceleration(self.axes, &twist);
        let bias = frames.jacobian_rate_times_speeds(&qd, point);
        let driven = change.to_vector() - bias.to_vector();
        let qdd = JointAccelerations(lu.solve(&driven).ok_or(SINGULAR)?.into());
        for (joint, number) in (0u8..6).enumerate() {
            let axis = &axes[joint];
            let (v, a) = (qd[joint], qdd[joint]);
            let moved = (q[joint] - from.q[joint]) / step;
            let jerk = (a - from.qdd[joint]) / step;
            // Where the arm is almost stretched the acceleration changes and comes back within one cycle: only the way
            // and the speed of the cycle tell.
            let along = from.qd[joint] + step / 2.0 * from.qdd[joint];
            let jerk_of_way = (moved - along) * 6.0 / (step * step);
            let jerk_of_speed = ((v - from.qd[joint]) / step - from.qdd[joint]) * 2.0 / step;
            let state = ScalarState {
                position: q[joint],
                speed: v,
                acceleration: a,
            };
            let fits = v.abs().max(moved.abs()) <= axis.speed * share
                && a.abs() <= axis.acceleration * share
                && jerk.abs() <= axis.jerk * JERK_SHARE
                && jerk_of_way.abs().max(jerk_of_speed.abs()) <= axis.jerk
                && arm.axes[joint].can_brake_within_limits(&state);
            if !fits {
                return Err(number);
            }
        }
        let setpoint = Setpoint { q, qd, qdd };
        if let Some(points) = arm.points
            && !points.is_safe(&states(&setpoint), arm.axes, step)
        {
            return Err(ELBOW);
        }
        Ok(VelocityCandidate {
            now,
            base_from_tcp,
            setpoint,
        })
    }

    /// The wanted accelerations, lowered to what the joints can do on the way to `goal`.
    fn within_joints(&self, arm: &TcpModeContext, jacobian: &Lu6, goal: &[f64; 6]) -> [f64; 2] {
        let change = part_accelerations(&self.now, goal, &self.acceleration);
        let change: [f64; 6] =
            core::array::from_fn(|k| change[k].copysign(goal[k] - self.now[k].speed));
        let twist = from_axes(&self.rotation(), &change);
        let Some(qdd) = jacobian.solve(&twist.to_vector()) else {
            return self.acceleration;
        };
        let share = (0..6).fold(1.0_f64, |least, joint| {
            least.min(BRAKING_SHARE * arm.able[joint].acceleration / qdd[joint].abs())
        });
        self.acceleration.map(|a| (a * share).max(1e-6))
    }

    /// How hard the joints can brake the TCP here, linear and angular.
    fn braking(&self, arm: &TcpModeContext, jacobian: &Lu6) -> [f64; 2] {
        let twist = from_axes(&self.rotation(), &self.velocity());
        let (linear, angular) = (twist.linear.norm(), twist.angular.norm());
        let Some(qd) = jacobian.solve(&twist.to_vector()) else {
            return self.acceleration;
        };
        // Slowing the whole twist at the rate r asks r times the joint speeds of the joints.
        let rate = (0..6).fold(f64::INFINITY, |least, joint| {
            least.min(arm.axes[joint].acceleration / qd[joint].abs())
        });
        [linear, angular].map(|part| {
            // A part that stands can stop at any rate.
            if part > 0.0 {
                within(BRAKING_SHARE * rate * part, 1e-3, BRAKING_MAX)
            } else {
                BRAKING_MAX
            }
        })
    }

    /// Whether the TCP comes to rest from `next` with every joint within its limits.
    fn can_brake(
        &self,
        arm: &TcpModeContext,
        next: &VelocityCandidate,
        braking: &[f64; 2],
    ) -> Result<(), u8> {
        let acceleration = part_accelerations(&next.now, &[0.0; 6], braking);
        let ramps: [_; 6] = core::array::from_fn(|k| {
            let state = &next.now[k];
            let a = acceleration[k];
            ramp(
                state.speed,
                state.acceleration,
                0.0,
                a,
                a / ACCELERATION_RISE,
            )
        });
        let duration = ramps.iter().fold(0.0_f64, |most, r| most.max(r.duration));
        let mut near = next.setpoint.q;
        for sample in 1..=BRAKING_SAMPLES {
            let time = duration * f64::from(sample) / f64::from(BRAKING_SAMPLES);
            let at: [ScalarState; 6] = core::array::from_fn(|k| {
                let mut state = ScalarState {
                    position: 0.0,
                    ..next.now[k]
                };
                let mut left = time;
                for phase in &ramps[k].phases {
                    let part = phase.duration.min(left);
                    state = state.after(part, phase.jerk);
                    left -= part;
                }
                state
            });
            let pose = integrate_pose(&next.base_from_tcp, self.axes, &at);
            let rotation = rotation_of(self.axes, &pose);
            let q = arm
                .model
                .inverse_nearest(&pose, arm.flange_from_tcp, &near)
                .ok_or(OUT_OF_REACH)?;
            let frames = arm.model.forward(&q);
            let twist = from_axes(&rotation, &at.map(|s| s.speed));
            let lu = frames.jacobian(pose.translation).lu();
            let qd = JointSpeeds(lu.solve(&twist.to_vector()).ok_or(SINGULAR)?.into());
            let mut change = from_axes(&rotation, &at.map(|s| s.acceleration));
            change.linear += frame_rotation_acceleration(self.axes, &twist);
            let bias = frames.jacobian_rate_times_speeds(&qd, pose.translation);
            let driven = change.to_vector() - bias.to_vector();
            let qdd = lu.solve(&driven).ok_or(SINGULAR)?;
            let interval = duration / f64::from(BRAKING_SAMPLES);
            let misfit = (0u8..6).zip(arm.axes).position(|(number, axis)| {
                let joint = usize::from(number);
                !(qd[joint].abs() <= axis.speed * JOINT_SHARE
                    && qdd[joint].abs() <= axis.acceleration * JOINT_SHARE
                    && (q[joint] - near[joint]).abs() <= axis.speed * interval + 1e-9
                    && (axis.min..=axis.max).contains(&q[joint]))
            });
            if let Some(joint) = misfit {
                return Err(joint as u8);
            }
            near = q;
        }
        Ok(())
    }
}

/// Whether a velocity is slower than the one now.
fn is_slower(goal: &[f64; 6], now: &[ScalarState; 6]) -> bool {
    let square = |v: &[f64; 6]| v.iter().map(|x| x * x).sum::<f64>();
    square(goal) < square(&now.map(|state| state.speed))
}

/// Accelerations of the six components, so that all change together and neither part exceeds its own.
fn part_accelerations(now: &[ScalarState; 6], goal: &[f64; 6], limits: &[f64; 2]) -> [f64; 6] {
    let change: [f64; 6] = core::array::from_fn(|k| (goal[k] - now[k].speed).abs());
    let norm = |part: &[f64]| part.iter().map(|x| x * x).sum::<f64>().sqrt();
    let time = (norm(&change[..3]) / limits[0]).max(norm(&change[3..]) / limits[1]);
    // A component that hardly changes still gets rid of an acceleration it may have, unless all of them belong to one
    // line: that is kept.
    let shares = [0, 3].map(|part| {
        let of = |value: &dyn Fn(usize) -> f64| Vector3::from_fn(|k, _| value(part + k));
        let way = of(&|k| goal[k] - now[k].speed);
        let acceleration = of(&|k| now[k].acceleration);
        let beside = acceleration.cross(&way).norm();
        let is_one_line = beside <= 1e-3 * limits[part / 3] * way.norm();
        if is_one_line { 1e-4 } else { 0.05 }
    });
    core::array::from_fn(|k| {
        let least = shares[k / 3] * limits[k / 3];
        if time > 0.0 {
            (change[k] / time).max(least)
        } else {
            least
        }
    })
}

/// The velocity one step later; the positions are the ways covered.
fn ramp_velocity(
    now: &[ScalarState; 6],
    goal: &[f64; 6],
    limits: &[f64; 2],
    step: f64,
) -> [ScalarState; 6] {
    let acceleration = part_accelerations(now, goal, limits);
    core::array::from_fn(|k| {
        let axis = AxisLimits {
            min: f64::NEG_INFINITY,
            max: f64::INFINITY,
            speed: f64::INFINITY,
            acceleration: acceleration[k],
            // An acceleration from before goes as fast as it would have come.
            jerk: acceleration[k].max(now[k].acceleration.abs()) / ACCELERATION_RISE,
        };
        let start = ScalarState {
            position: 0.0,
            ..now[k]
        };
        axis.step_towards_speed(&start, goal[k], step)
    })
}

fn rotation_of(axes: TwistFrame, base_from_tcp: &Pose) -> Rotation3<f64> {
    match axes {
        TwistFrame::Fixed(rotation) => rotation,
        TwistFrame::Tool => base_from_tcp.rotation,
    }
}

/// What the turning of the axes changes the TCP's velocity by, which stays as it is in them: base axes, m/s².
fn frame_rotation_acceleration(axes: TwistFrame, twist: &Twist) -> Vector3<f64> {
    match axes {
        TwistFrame::Fixed(_) => Vector3::zeros(),
        TwistFrame::Tool => twist.angular.cross(&twist.linear),
    }
}

/// The pose after the ways in `at`, along and about the axes.
fn integrate_pose(from: &Pose, axes: TwistFrame, at: &[ScalarState; 6]) -> Pose {
    let way = from_axes(&rotation_of(axes, from), &at.map(|state| state.position));
    let linear = match axes {
        TwistFrame::Fixed(_) => way.linear,
        // On the way the axes turn: they are half turned in the middle of it.
        TwistFrame::Tool => Rotation3::new(way.angular / 2.0) * way.linear,
    };
    Pose::new(
        Rotation3::new(way.angular) * from.rotation,
        from.translation + linear,
    )
}

fn in_axes(rotation: &Rotation3<f64>, twist: &Twist) -> [f64; 6] {
    let linear = rotation.inverse_transform_vector(&twist.linear);
    let angular = rotation.inverse_transform_vector(&twist.angular);
    [
        linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
    ]
}

fn from_axes(rotation: &Rotation3<f64>, v: &[f64; 6]) -> Twist {
    Twist {
        linear: rotation * Vector3::new(v[0], v[1], v[2]),
        angular: rotation * Vector3::new(v[3], v[4], v[5]),
    }
}

/// The velocity of freedrive's hand law in the axes of a mode, base axes in.
pub fn components(mode: &TcpSpeedMode, base: &Vector6<f64>) -> [f64; 6] {
    in_axes(
        &mode.rotation(),
        &Twist {
            linear: base.fixed_rows::<3>(0).into(),
            angular: base.fixed_rows::<3>(3).into(),
        },
    )
}
