//! The speed limits of TCP and elbow in online modes.
//!
//! As with a joint's own limits (see [`axis`](super::axis)) a state counts as safe when braking from it, every joint as
//! fast as it can, keeps the limits all the way. Only safe states pass; from a safe one the first step of braking is
//! safe again, so there is always a way on. The braking is looked at where its cycles will end, which is where the
//! limits are checked, more coarsely further on.

use kinematics::{Frames, JointPositions, JointSpeeds, Pose, RobotModel};
use motion_api::StopReason;
use nalgebra::Vector3;

use super::axis::AxisLimits;
use crate::config::MotionLimits;
use crate::scalar::ScalarState;
use crate::scalar::ramp::{Ramp, ramp};
use crate::setpoint::elbow_speed;

/// Share of the limits that joint modes aim at.
const AIMED_SHARE: f64 = 0.9;
/// Share of the limits that no safe state exceeds on its way to rest.
const KEPT_SHARE: f64 = 0.99;
/// Cycles at the beginning of a braking of which each is looked at.
const NEAR_CYCLES: u32 = 8;
/// Most places at which the later part of a braking is looked at.
const FAR_PLACES: u32 = 32;
/// Halvings between braking and what is wanted.
const HALVINGS: u32 = 6;

/// What limits the speeds of TCP and elbow, where anything does.
#[derive(Clone, Copy)]
pub(crate) struct PointSpeedLimits<'a> {
    model: &'a RobotModel,
    flange_from_tcp: &'a Pose,
    frames: Frames,
    tcp: Vector3<f64>,
    tcp_speed: f64,
    elbow_speed: f64,
}

impl<'a> PointSpeedLimits<'a> {
    /// With the arm at `q`; `None` without limits.
    pub(crate) fn new(
        model: &'a RobotModel,
        flange_from_tcp: &'a Pose,
        limits: &MotionLimits,
        q: &JointPositions,
    ) -> Option<Self> {
        if limits.tcp_speed.is_infinite() && limits.elbow_speed.is_infinite() {
            return None;
        }
        let frames = model.forward(q);
        Some(Self {
            model,
            flange_from_tcp,
            tcp: (frames.base_from_flange * *flange_from_tcp).translation,
            frames,
            tcp_speed: limits.tcp_speed,
            elbow_speed: limits.elbow_speed,
        })
    }

    /// The speed limit of the TCP, m/s.
    pub(super) const fn tcp_speed(&self) -> f64 {
        self.tcp_speed
    }

    /// The factor on `qd` at which TCP and elbow are as fast as is aimed at here; infinite when they do not move.
    pub(super) fn speed_factor(&self, qd: &JointSpeeds) -> f64 {
        let tcp = self.frames.twist(qd, self.tcp).linear.norm();
        let elbow = elbow_speed(&self.frames, qd);
        AIMED_SHARE * (self.tcp_speed / tcp).min(self.elbow_speed / elbow)
    }

    /// Share of the limits that TCP or elbow use at `qd`, whichever uses more.
    pub(crate) fn utilization_at(&self, qd: &JointSpeeds) -> f64 {
        AIMED_SHARE / self.speed_factor(qd)
    }

    /// `wanted` if it is safe, otherwise the safe state nearest to it on the way to braking.
    pub(super) fn clamp_to_safe(
        &self,
        now: &[ScalarState; 6],
        wanted: [ScalarState; 6],
        axes: &[AxisLimits; 6],
        step: f64,
    ) -> [ScalarState; 6] {
        if self.is_safe(&wanted, axes, step) {
            return wanted;
        }
        let between = |share: f64| -> [ScalarState; 6] {
            core::array::from_fn(|joint| {
                let axis = &axes[joint];
                let braked = axis.brake_step(&now[joint], step);
                if share == 0.0 {
                    return braked;
                }
                let change = wanted[joint].acceleration - braked.acceleration;
                axis.nearest_safe(&now[joint], braked.acceleration + share * change, step)
            })
        };
        let (mut good, mut bad) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (good + bad);
            if self.is_safe(&between(middle), axes, step) {
                good = middle;
            } else {
                bad = middle;
            }
        }
        between(good)
    }

    /// Whether braking from `states` keeps both limits.
    pub(crate) fn is_safe(
        &self,
        states: &[ScalarState; 6],
        axes: &[AxisLimits; 6],
        step: f64,
    ) -> bool {
        let braking = BrakingRamps::from(states, axes, step);
        let mut speeds = braking
            .sample_times()
            .map(|time| self.speeds(&braking, time));
        speeds.all(|speeds| self.exceeded(speeds).is_none())
    }

    /// The highest speeds of TCP and elbow, m/s, while the joints brake from `states`.
    pub(crate) fn max_speeds_while_braking(
        &self,
        states: &[ScalarState; 6],
        axes: &[AxisLimits; 6],
        step: f64,
    ) -> [f64; 2] {
        let braking = BrakingRamps::from(states, axes, step);
        let speeds = braking
            .sample_times()
            .map(|time| self.speeds(&braking, time));
        speeds.fold([0.0; 2], |most, speeds| {
            core::array::from_fn(|point| f64::max(most[point], speeds[point]))
        })
    }

    /// The limit that speeds of TCP and elbow do not keep; the one of which more is used.
    pub(crate) fn exceeded(&self, [tcp, elbow]: [f64; 2]) -> Option<StopReason> {
        let of_tcp = tcp / self.tcp_speed;
        let of_elbow = elbow / self.elbow_speed;
        if of_tcp.max(of_elbow) <= KEPT_SHARE {
            return None;
        }
        Some(if of_tcp >= of_elbow {
            StopReason::TcpSpeed {
                value: tcp,
                limit: self.tcp_speed,
            }
        } else {
            StopReason::ElbowSpeed {
                value: elbow,
                limit: self.elbow_speed,
            }
        })
    }

    /// The share of the limits that speeds of TCP and elbow use, whichever uses more.
    pub(crate) fn utilization(&self, [tcp, elbow]: [f64; 2]) -> f64 {
        (tcp / self.tcp_speed).max(elbow / self.elbow_speed)
    }

    /// Speeds of TCP and elbow `time` seconds into the braking, m/s.
    fn speeds(&self, braking: &BrakingRamps<'_>, time: f64) -> [f64; 2] {
        let at = braking.at(time);
        let frames = self.model.forward(&JointPositions(at.map(|s| s.position)));
        let qd = JointSpeeds(at.map(|s| s.speed));
        let tcp = (frames.base_from_flange * *self.flange_from_tcp).translation;
        [
            frames.twist(&qd, tcp).linear.norm(),
            elbow_speed(&frames, &qd),
        ]
    }
}

/// Every joint on its fastest way to rest.
struct BrakingRamps<'a> {
    states: &'a [ScalarState; 6],
    ramps: [Ramp; 6],
    duration: f64,
    step: f64,
}

impl<'a> BrakingRamps<'a> {
    fn from(states: &'a [ScalarState; 6], axes: &[AxisLimits; 6], step: f64) -> Self {
        let ramps: [Ramp; 6] = core::array::from_fn(|joint| {
            let (state, axis) = (&states[joint], &axes[joint]);
            ramp(
                state.speed,
                state.acceleration,
                0.0,
                axis.acceleration,
                axis.jerk,
            )
        });
        let duration = ramps.iter().fold(0.0_f64, |most, r| most.max(r.duration));
        Self {
            states,
            ramps,
            duration,
            step,
        }
    }

    /// The times that are looked at, s.
    fn sample_times(&self) -> impl Iterator<Item = f64> {
        let (step, duration) = (self.step, self.duration);
        let near = f64::from(NEAR_CYCLES) * step;
        let far = (duration - near).max(0.0) / f64::from(FAR_PLACES);
        (0..=NEAR_CYCLES)
            .map(move |k| f64::from(k) * step)
            .chain((1..FAR_PLACES).map(move |k| near + f64::from(k) * far))
            .take_while(move |time| *time <= duration)
    }

    fn at(&self, time: f64) -> [ScalarState; 6] {
        core::array::from_fn(|joint| {
            let mut state = self.states[joint];
            let mut left = time;
            for phase in &self.ramps[joint].phases {
                let part = phase.duration.min(left);
                state = state.after(part, phase.jerk);
                left -= part;
            }
            state
        })
    }
}
