//! A straight line of the TCP with rotation about one fixed axis. s is the distance along the line in metres; where the
//! rotation is the larger part, one radian counts as [`ROTATION_LENGTH`] metres of it.
//!
//! Position and orientation are linear in s, so the TCP's twist per s is constant. With J the Jacobian at the TCP:
//! q' = J⁻¹ twist, q'' = -J⁻¹ J' q' (dashes: derivatives with respect to s).

use kinematics::rotation::{rotation_from_rotvec, rotvec_from_rotation};
use kinematics::{JointAccelerations, JointPositions, JointSpeeds, Pose, RobotModel, Twist};
use nalgebra::{Vector3, Vector6};

use crate::constants::{NO_MOTION, ROTATION_LENGTH};
use crate::scalar::ScalarState;
use crate::setpoint::Setpoint;

/// From one TCP pose to another.
#[derive(Clone, Copy, Debug)]
pub struct CartesianLine {
    start: Pose,
    end: Pose,
    end_q: JointPositions,
    flange_from_tcp: Pose,
    /// TCP displacement per s, no unit (metres per metre), base axes.
    along: Vector3<f64>,
    /// Rotation per s, rad/m, base axes.
    about: Vector3<f64>,
    length: f64,
}

/// The joints at one place of the line, and their derivatives with respect to s.
#[derive(Clone, Copy, Debug)]
pub struct LinePoint {
    /// Place, m.
    pub s: f64,
    /// Positions, rad.
    pub q: JointPositions,
    /// dq/ds, rad/m.
    pub first: [f64; 6],
    /// d²q/ds², rad/m².
    pub second: [f64; 6],
}

impl CartesianLine {
    /// The line from `start` to `end`, both TCP poses in the base frame; of length 0 when they are the same.
    ///
    /// Where the arm ends is known once the line has been followed: see [`ending_at`](Self::ending_at).
    pub fn new(start: Pose, end: Pose, flange_from_tcp: Pose, start_q: JointPositions) -> Self {
        let way = end.translation - start.translation;
        let turn = rotvec_from_rotation(&(end.rotation * start.rotation.inverse()));
        let length = way.norm().max(turn.norm() * ROTATION_LENGTH);
        let (length, per_s) = if length > NO_MOTION {
            (length, 1.0 / length)
        } else {
            (0.0, 0.0)
        };
        Self {
            start,
            end,
            end_q: start_q,
            flange_from_tcp,
            along: way * per_s,
            about: turn * per_s,
            length,
        }
    }

    /// The line with the joint positions at its end.
    #[must_use]
    pub fn ending_at(self, end_q: JointPositions) -> Self {
        Self { end_q, ..self }
    }

    /// How long it is, m.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// How far the TCP goes per s: 1 unless the rotation is the larger part.
    pub fn tcp_distance_per_s(&self) -> f64 {
        self.along.norm()
    }

    /// Joint positions at the end.
    pub fn end(&self) -> JointPositions {
        self.end_q
    }

    /// TCP pose at s; exactly the end pose at the end.
    pub fn pose(&self, s: f64) -> Pose {
        if s >= self.length {
            return self.end;
        }
        Pose::new(
            rotation_from_rotvec(self.about * s) * self.start.rotation,
            self.start.translation + self.along * s,
        )
    }

    /// The TCP relative to the flange, as it was when the line was planned.
    pub fn flange_from_tcp(&self) -> &Pose {
        &self.flange_from_tcp
    }

    /// Joint positions at s, nearest to `near`; `None` when the pose cannot be reached.
    pub fn positions(
        &self,
        model: &RobotModel,
        s: f64,
        near: &JointPositions,
    ) -> Option<JointPositions> {
        model.inverse_following(&self.pose(s), &self.flange_from_tcp, near)
    }

    /// The derivatives at joint positions `q` that lie on the line at s; `None` where the Jacobian is singular.
    pub fn point(&self, model: &RobotModel, s: f64, q: JointPositions) -> Option<LinePoint> {
        let frames = model.forward(&q);
        let tcp = (frames.base_from_flange * self.flange_from_tcp).translation;
        let jacobian = frames.jacobian(tcp).lu();
        let first = jacobian.solve(&stacked(&Twist {
            linear: self.along,
            angular: self.about,
        }))?;
        let first: [f64; 6] = first.into();
        let bias = frames.jacobian_rate_times_speeds(&JointSpeeds(first), tcp);
        let second: [f64; 6] = jacobian.solve(&-stacked(&bias))?.into();
        let is_finite = first.iter().chain(&second).all(|x| x.is_finite());
        is_finite.then_some(LinePoint {
            s,
            q,
            first,
            second,
        })
    }

    /// The setpoint at a state of s, in the branch of solutions that `near` belongs to.
    pub fn at(
        &self,
        model: &RobotModel,
        s: &ScalarState,
        near: &JointPositions,
    ) -> Option<Setpoint> {
        let q = self.positions(model, s.position, near)?;
        let point = self.point(model, s.position, q)?;
        let (v, a) = (s.speed, s.acceleration);
        Some(Setpoint {
            q,
            qd: JointSpeeds(point.first.map(|d| d * v)),
            qdd: JointAccelerations(core::array::from_fn(|joint| {
                point.second[joint] * v * v + point.first[joint] * a
            })),
        })
    }
}

fn stacked(twist: &Twist) -> Vector6<f64> {
    let (l, a) = (twist.linear, twist.angular);
    Vector6::new(l.x, l.y, l.z, a.x, a.y, a.z)
}
