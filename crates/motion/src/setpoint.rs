//! Setpoints, and the limiter that alone can turn one into something the plant accepts.

use kinematics::bounds::within;
use kinematics::chain::Frames;
use kinematics::{
    JointAccelerations, JointPositions, JointSpeeds, JointTorques, Posture, RobotModel,
};
use motion_api::StopReason;
use nalgebra::Vector3;

use crate::config::MotionLimits;
use crate::constants::{LIMIT_SLACK, fault};

/// Commanded positions, speeds and accelerations of the joints at the end of a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setpoint {
    /// rad.
    pub q: JointPositions,
    /// rad/s.
    pub qd: JointSpeeds,
    /// rad/s².
    pub qdd: JointAccelerations,
}

impl Setpoint {
    /// Standing at `q`.
    pub const fn standing(q: JointPositions) -> Self {
        Self {
            q,
            qd: JointSpeeds::ZERO,
            qdd: JointAccelerations::ZERO,
        }
    }

    /// Whether both have equal numbers to the last bit.
    pub(crate) fn bit_eq(&self, other: &Self) -> bool {
        self.q.has_bits_of(&other.q)
            && self.qd.has_bits_of(&other.qd)
            && self.qdd.has_bits_of(&other.qdd)
    }

    fn is_finite(&self) -> bool {
        self.q.is_finite() && self.qd.is_finite() && self.qdd.is_finite()
    }
}

/// What a setpoint takes by the controller's model.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SetpointDynamics {
    /// The setpoint.
    pub(crate) of: Setpoint,
    /// The drives' torques, Nm.
    pub(crate) torques: JointTorques,
    /// The torques that are there without accelerations, where they were worked out, Nm.
    pub(crate) bias: Option<JointTorques>,
}

/// Where joint positions put the links, kept until others are asked for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KinematicsCache {
    q: JointPositions,
    pub(crate) posture: Posture,
    pub(crate) frames: Frames,
}

impl KinematicsCache {
    /// At `q`.
    pub(crate) fn new(model: &RobotModel, q: &JointPositions) -> Self {
        let posture = model.chain().posture(q);
        Self {
            q: *q,
            posture,
            frames: model.chain().frames(&posture),
        }
    }

    /// The links at `q`.
    pub(crate) fn at(&mut self, model: &RobotModel, q: &JointPositions) -> &Self {
        if !self.q.has_bits_of(q) {
            self.q = *q;
            self.posture = model.chain().posture(q);
            self.frames = model.chain().frames(&self.posture);
        }
        self
    }
}

/// A setpoint that has passed the limiter. Nothing else reaches the plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitedSetpoint(Setpoint);

impl LimitedSetpoint {
    /// The setpoint.
    pub const fn as_setpoint(&self) -> &Setpoint {
        &self.0
    }

    /// The position where the arm stands already: always allowed.
    pub(crate) const fn holding(standing_at: JointPositions) -> Self {
        Self(Setpoint::standing(standing_at))
    }

    /// A setpoint of a joint-wise braking: the arm must come to rest whatever the limits, only the range of the joints
    /// cuts it off. `before` is kept when the numbers are unusable.
    pub(crate) fn while_braking(
        wanted: Setpoint,
        before: &Setpoint,
        limits: &MotionLimits,
    ) -> Self {
        if !wanted.is_finite() {
            return Self::holding(before.q);
        }
        let mut kept = wanted;
        for joint in 0..6 {
            let (min, max) = (limits.position_min[joint], limits.position_max[joint]);
            let inside = within(
                wanted.q[joint],
                min.min(before.q[joint]),
                max.max(before.q[joint]),
            );
            if inside != wanted.q[joint] {
                kept.q[joint] = inside;
                kept.qd[joint] = 0.0;
                kept.qdd[joint] = 0.0;
            }
        }
        Self(kept)
    }
}

/// Checks a setpoint against the one before it and against every limit of positions and speeds.
///
/// `frames` are the joint frames at `wanted.q`, `tcp` the TCP's position in the base frame there, `step` the time
/// between the two setpoints in s.
///
/// # Errors
/// The first limit that would be exceeded, as the reason of a protective stop.
pub fn check_setpoint(
    wanted: Setpoint,
    before: &Setpoint,
    frames: &Frames,
    tcp: Vector3<f64>,
    step: f64,
    limits: &MotionLimits,
) -> Result<LimitedSetpoint, StopReason> {
    if !wanted.is_finite() {
        return Err(StopReason::Internal {
            code: fault::NOT_FINITE,
        });
    }
    for (joint, number) in (0u8..6).enumerate() {
        let (value, min, max) = (
            wanted.q[joint],
            limits.position_min[joint],
            limits.position_max[joint],
        );
        if value < min - LIMIT_SLACK || value > max + LIMIT_SLACK {
            return Err(StopReason::JointPosition {
                joint: number,
                value,
                min,
                max,
            });
        }
        // Both what the generator says and what the positions say, so that a jump is caught as well.
        let moved = (value - before.q[joint]) / step;
        let value = if moved.abs() > wanted.qd[joint].abs() {
            moved
        } else {
            wanted.qd[joint]
        };
        let limit = limits.speed[joint];
        if value.abs() > limit + LIMIT_SLACK {
            return Err(StopReason::JointSpeed {
                joint: number,
                value,
                limit,
            });
        }
    }
    if limits.tcp_speed.is_finite() {
        let value = frames.twist(&wanted.qd, tcp).linear.norm();
        if value > limits.tcp_speed + LIMIT_SLACK {
            return Err(StopReason::TcpSpeed {
                value,
                limit: limits.tcp_speed,
            });
        }
    }
    if limits.elbow_speed.is_finite() {
        let value = elbow_speed(frames, &wanted.qd);
        if value > limits.elbow_speed + LIMIT_SLACK {
            return Err(StopReason::ElbowSpeed {
                value,
                limit: limits.elbow_speed,
            });
        }
    }
    Ok(LimitedSetpoint(wanted))
}

/// Speed of the elbow, m/s: only the first two joints move it.
pub(crate) fn elbow_speed(frames: &Frames, qd: &JointSpeeds) -> f64 {
    let elbow = frames.elbow();
    frames.base_from_joint[..2]
        .iter()
        .zip(qd.iter())
        .map(|(joint, rate)| {
            let axis = joint.rotation * Vector3::z();
            axis.cross(&(elbow - joint.translation)) * *rate
        })
        .sum::<Vector3<f64>>()
        .norm()
}
