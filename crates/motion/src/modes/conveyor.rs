//! Conveyor tracking: motion of the arm superimposed on the motion of a belt or a turntable (manual 3.1.29 to 3.1.31).
//!
//! The belt's way since the `track_*` call moves and turns the TCP pose that the generator asks for. The arm's own copy
//! of that way catches up with the belt under acceleration and jerk limits and then follows it without an error at
//! constant speed; when tracking stops it comes to rest the same way. Moves during tracking are planned as if the belt
//! stood.

use kinematics::bounds::within;
use kinematics::elementary::atan2;
use kinematics::{JointAccelerations, JointSpeeds, Pose, RobotModel, Twist};
use nalgebra::{Rotation3, Unit, Vector3};

use super::axis::AxisLimits;
use super::follower::TrackingLaw;
use crate::constants::ACCELERATION_RISE;
use crate::scalar::ScalarState;
use crate::setpoint::Setpoint;

/// Acceleration with which the tool catches up with a belt, m/s².
const CATCH_UP: f64 = 2.5;
/// Fastest catching up, m/s.
const SPEED_MAX: f64 = 3.0;
/// Bandwidth of catching up, rad/s.
const BANDWIDTH: f64 = 40.0;
/// A belt that is this near is caught up with, m or rad.
const CAUGHT_UP: f64 = 1e-4;
/// Longest time for which catching up with the belt is waited for, s.
const CATCH_UP_TIMEOUT: f64 = 5.0;
/// Nearer to the centre of a turntable than this its angle counts as if the tool were here, m.
const RADIUS_MIN: f64 = 0.1;

/// The way of the belt in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ConveyorPath {
    /// Along a unit vector of the base frame.
    Linear(Unit<Vector3<f64>>),
    /// About an axis through a point of the base frame.
    Circular {
        /// A point on the axis.
        center: Vector3<f64>,
        /// The axis.
        axis: Unit<Vector3<f64>>,
        /// The tool turns with the table.
        rotate_tool: bool,
    },
}

/// A motion on the belt is slowed down where more than this share of what joints, TCP and elbow can do is used; below
/// it goes on faster, the more is left.
const FULL_USE: f64 = 0.96;
/// Rate at which the pace of a motion on the belt falls where too much is used, 1/s.
const SLOWING_RATE: f64 = 8.0;
/// Fastest rate at which the pace of a motion on the belt rises again, 1/s.
const RECOVERY_RATE: f64 = 2.0;
/// Unused share of the limits, below [`FULL_USE`], from which on the pace rises at its fastest.
const RECOVERY_USE: f64 = 0.06;
/// A motion is never slower than this: belts leave that much.
const SLOWEST_PACE: f64 = 0.03;
/// Rate with which a motion is slowed down that began before the belt was tracked, 1/s.
const ENTRY_RATE: f64 = 2.0;
/// Longest time for which the belt waits for a motion that began before it was tracked, s.
const LONGEST_WAIT: f64 = 1.5;
/// The pace of a motion for which the joints had to be braked, as share of what it was.
const PACE_AFTER_BRAKING: f64 = 0.5;

/// Tracking under way.
#[derive(Clone, Copy, Debug)]
pub struct ConveyorTracking {
    route: ConveyorPath,
    /// Encoder, 0 or 1.
    pub encoder: usize,
    /// m or rad a tick.
    per_tick: f64,
    /// Ticks of the encoder when tracking began.
    start_ticks: f64,
    /// The arm's way: m or rad.
    displacement: ScalarState,
    axis: AxisLimits,
    /// Acceleration and speed where the joints allow them, in units of the way.
    max_acceleration: f64,
    max_speed: f64,
    /// Share of its speed at which a motion on the belt goes on, so that it and the belt together keep what joints, TCP
    /// and elbow can do.
    pace: f64,
    /// For so long, s, the belt waits for a motion that began before it was tracked and has to leave it its share.
    waiting: f64,
    /// The motion under way began before the belt was tracked.
    has_early_motion: bool,
    law: TrackingLaw,
    is_stopping: bool,
    /// For so long, s, motions wait until the belt is caught up with.
    catch_up_timeout: f64,
}

impl ConveyorTracking {
    /// From rest, with the tool at `tcp` in the base frame and the encoder at `start_ticks` ticks.
    pub fn new(
        route: ConveyorPath,
        encoder: usize,
        per_tick: f64,
        start: f64,
        tcp: Vector3<f64>,
        step: f64,
    ) -> Self {
        let lever = match route {
            ConveyorPath::Linear(_) => 1.0,
            ConveyorPath::Circular { center, axis, .. } => {
                (tcp - center).cross(&axis).norm().max(RADIUS_MIN)
            }
        };
        let acceleration = CATCH_UP / lever;
        Self {
            route,
            encoder,
            per_tick,
            start_ticks: start,
            displacement: ScalarState::default(),
            axis: AxisLimits {
                min: f64::NEG_INFINITY,
                max: f64::INFINITY,
                speed: SPEED_MAX / lever,
                acceleration,
                jerk: acceleration / ACCELERATION_RISE,
            },
            max_acceleration: acceleration,
            max_speed: SPEED_MAX / lever,
            pace: 1.0,
            waiting: 0.0,
            has_early_motion: false,
            law: TrackingLaw::new(BANDWIDTH, step),
            is_stopping: false,
            catch_up_timeout: 0.0,
        }
    }

    /// The direction in which the arm's way leads next, 1 or -1, when the encoder was at `ticks` with `rate` ticks/s.
    pub fn heading(&self, (ticks, rate): (f64, f64)) -> f64 {
        let gap = (ticks - self.start_ticks) * self.per_tick - self.displacement.position;
        let leads = if gap.abs() > 10.0 * CAUGHT_UP {
            gap
        } else {
            rate * self.per_tick
        };
        1.0_f64.copysign(leads)
    }

    /// Speed of the arm's way now, m/s or rad/s with its sign.
    pub fn way_speed(&self) -> f64 {
        self.displacement.speed
    }

    /// The share of its speed at which a motion on the belt goes on.
    pub fn pace(&self) -> f64 {
        self.pace
    }

    /// Slows the motion on the belt down, or lets it go on, by the share of what the arm can do that is used; it is no
    /// faster than `most`.
    pub fn adapt_pace(&mut self, used: f64, most: f64, step: f64) {
        let room = (FULL_USE - used) / RECOVERY_USE;
        let rate = if room < 0.0 {
            -SLOWING_RATE
        } else {
            RECOVERY_RATE * room.min(1.0)
        };
        let now = within(self.pace + rate * step, SLOWEST_PACE, 1.0);
        self.pace = now.min(most.max(self.pace - ENTRY_RATE * step));
    }

    /// The joints have to be braked for the motion on the belt, which is slower afterwards.
    pub fn slow_motion_down(&mut self) {
        self.pace = (PACE_AFTER_BRAKING * self.pace).max(SLOWEST_PACE);
    }

    /// The belt has to wait until a motion under way leaves it its share.
    pub fn wait(&mut self) {
        self.waiting = LONGEST_WAIT;
        self.has_early_motion = true;
    }

    /// A motion that began before the belt was tracked is still under way.
    pub fn has_early_motion(&self) -> bool {
        self.has_early_motion
    }

    /// The motion that began before the belt was tracked has ended.
    pub fn end_early_motion(&mut self) {
        self.has_early_motion = false;
    }

    /// True while the belt waits for a motion that began before it was tracked ([`wait`](Self::wait)).
    pub fn is_waiting(&self) -> bool {
        self.waiting > 0.0
    }

    /// The motion leaves the belt its share, so the belt waits no more.
    pub fn end_wait(&mut self) {
        self.waiting = 0.0;
    }

    /// The TCP is carried round, the tool keeps its angle.
    pub fn carries_without_turning(&self) -> bool {
        let ConveyorPath::Circular { rotate_tool, .. } = self.route else {
            return false;
        };
        !rotate_tool
    }

    /// The counter of the encoder was set by so many ticks; the belt has not moved.
    pub fn recount(&mut self, ticks: f64) {
        self.start_ticks += ticks;
    }

    /// Comes to rest wherever the belt goes.
    pub fn stop(&mut self) {
        self.is_stopping = true;
    }

    /// The arm's way stands where it is: something else brakes the arm.
    pub fn halt(&mut self) {
        self.displacement = ScalarState::at_rest(self.displacement.position);
    }

    /// The arm stands with its tool at `to` (base frame), which would be at `from` if the belt had never moved: the
    /// arm's way becomes the one that comes nearest to that.
    pub fn resync(&mut self, from: &Vector3<f64>, to: &Vector3<f64>) {
        let way = match self.route {
            ConveyorPath::Linear(along) => along.dot(&(to - from)),
            ConveyorPath::Circular { center, axis, .. } => {
                let across = |point: &Vector3<f64>| {
                    let lever = point - center;
                    lever - *axis * axis.dot(&lever)
                };
                let (from, to) = (across(from), across(to));
                let turn = atan2(axis.dot(&from.cross(&to)), from.dot(&to));
                // The angle is known up to whole turns.
                let turns = ((self.displacement.position - turn) / core::f64::consts::TAU).round();
                turn + turns * core::f64::consts::TAU
            }
        };
        self.displacement = ScalarState::at_rest(way);
        self.catch_up_timeout = CATCH_UP_TIMEOUT;
    }

    /// The belt went on while the arm was held, and has not been caught up with yet.
    pub fn is_behind(&self) -> bool {
        self.catch_up_timeout > 0.0 && !self.is_stopping
    }

    /// Coming to rest, and not there yet.
    pub fn is_stopping(&self) -> bool {
        self.is_stopping
    }

    /// Has come to rest after a stop.
    pub fn has_stopped(&self) -> bool {
        self.is_stopping && self.displacement.speed == 0.0 && self.displacement.acceleration == 0.0
    }

    /// Velocity of the tool at `tcp` (base frame) when its way grows by 1 a second.
    pub fn unit_twist(&self, tcp: Vector3<f64>) -> Twist {
        match self.route {
            ConveyorPath::Linear(along) => Twist {
                linear: *along,
                ..Twist::default()
            },
            ConveyorPath::Circular {
                center,
                axis,
                rotate_tool,
            } => Twist {
                linear: axis.cross(&(tcp - center)),
                angular: if rotate_tool { *axis } else { Vector3::zeros() },
            },
        }
    }

    /// Acceleration of the tool at `tcp` when its way grows evenly by 1 a second.
    pub fn unit_curvature(&self, tcp: Vector3<f64>) -> Twist {
        match self.route {
            ConveyorPath::Linear(_) => Twist::default(),
            ConveyorPath::Circular { center, axis, .. } => Twist {
                linear: axis.cross(&axis.cross(&(tcp - center))),
                ..Twist::default()
            },
        }
    }

    /// Where the joints can do less, the way changes more slowly, and where TCP or elbow may not be as fast it is
    /// caught up with more slowly: `acceleration` and `speed` in units of the way.
    pub fn limit(&mut self, acceleration: f64, speed: f64) {
        self.axis.acceleration = self.max_acceleration.min(acceleration).max(1e-3);
        self.axis.jerk = self.axis.acceleration / ACCELERATION_RISE;
        // Not below what the arm has already: it slows down with the belt.
        self.axis.speed = self.max_speed.min(speed).max(self.displacement.speed.abs());
    }

    /// Speed of the belt when the encoder runs at `rate` ticks/s: m/s or rad/s, without sign.
    pub fn rate(&self, rate: f64) -> f64 {
        (rate * self.per_tick).abs()
    }

    /// Speed of the arm's way along the belt: m/s or rad/s, without sign.
    pub fn speed(&self) -> f64 {
        self.displacement.speed.abs()
    }

    /// One step further: the encoder was at `ticks` with `rate` (ticks/s) when the step began.
    pub fn advance(&mut self, (ticks, rate): (f64, f64), step: f64) {
        if self.is_stopping {
            self.displacement = self.axis.step_towards_speed(&self.displacement, 0.0, step);
            return;
        }
        if self.is_waiting() {
            self.waiting -= step;
            return;
        }
        let (position, speed) = (
            (ticks - self.start_ticks) * self.per_tick,
            rate * self.per_tick,
        );
        self.catch_up_timeout = if (position - self.displacement.position).abs() < CAUGHT_UP {
            0.0
        } else {
            (self.catch_up_timeout - step).max(0.0)
        };
        let wanted = self
            .law
            .acceleration(&self.displacement, position, speed, &self.axis);
        self.displacement = self.axis.nearest_safe(&self.displacement, wanted, step);
    }

    /// The joints for the generator's setpoint carried along; `None` when the arm cannot be there.
    pub fn superimpose(
        &self,
        nominal: &Setpoint,
        before: &Setpoint,
        model: &RobotModel,
        flange_from_tcp: &Pose,
    ) -> Option<Setpoint> {
        let frames = model.forward(&nominal.q);
        let pose = frames.base_from_flange * *flange_from_tcp;
        let speed = frames.twist(&nominal.qd, pose.translation);
        let bias = frames.jacobian_rate_times_speeds(&nominal.qd, pose.translation);
        let driven = frames.twist(&JointSpeeds(nominal.qdd.0), pose.translation);
        let change = Twist {
            linear: driven.linear + bias.linear,
            angular: driven.angular + bias.angular,
        };
        let (pose, speed, change) = self.carried(&pose, &speed, &change);

        let q = model.inverse_nearest(&pose, flange_from_tcp, &before.q)?;
        let frames = model.forward(&q);
        let lu = frames.jacobian(pose.translation).lu();
        let qd = JointSpeeds(lu.solve(&speed.to_vector())?.into());
        let bias = frames.jacobian_rate_times_speeds(&qd, pose.translation);
        let driven = change.to_vector() - bias.to_vector();
        let qdd = JointAccelerations(lu.solve(&driven)?.into());
        Some(Setpoint { q, qd, qdd })
    }

    /// Pose, velocity and acceleration of the TCP in a frame that moves along with the arm's way.
    fn carried(&self, pose: &Pose, speed: &Twist, change: &Twist) -> (Pose, Twist, Twist) {
        let way = &self.displacement;
        match self.route {
            ConveyorPath::Linear(along) => (
                Pose::new(pose.rotation, pose.translation + *along * way.position),
                Twist {
                    linear: speed.linear + *along * way.speed,
                    ..*speed
                },
                Twist {
                    linear: change.linear + *along * way.acceleration,
                    ..*change
                },
            ),
            ConveyorPath::Circular {
                center,
                axis,
                rotate_tool,
            } => {
                let turn = Rotation3::from_axis_angle(&axis, way.position);
                let (omega, alpha) = (*axis * way.speed, *axis * way.acceleration);
                let lever = turn * (pose.translation - center);
                let own = turn * speed.linear;
                let linear = own + omega.cross(&lever);
                let linear_change = turn * change.linear
                    + 2.0 * omega.cross(&own)
                    + alpha.cross(&lever)
                    + omega.cross(&omega.cross(&lever));
                let at = center + lever;
                if !rotate_tool {
                    return (
                        Pose::new(pose.rotation, at),
                        Twist { linear, ..*speed },
                        Twist {
                            linear: linear_change,
                            ..*change
                        },
                    );
                }
                let own = turn * speed.angular;
                (
                    Pose::new(turn * pose.rotation, at),
                    Twist {
                        linear,
                        angular: own + omega,
                    },
                    Twist {
                        linear: linear_change,
                        angular: turn * change.angular + omega.cross(&own) + alpha,
                    },
                )
            }
        }
    }
}
