//! Geometric paths of the whole arm, without time: where the joints are at each place s of the way.
//!
//! A [`Path`] is one leg or one blend. A [`CompositePath`] is what a motion follows: the legs of the queue and their
//! blends, end to end.

mod cartesian;
mod joint_line;
mod micro_line;
mod quintic;
mod route;
mod turn;

use cartesian::setpoint_at;
pub use cartesian::{ArcOrientation, CartesianPath, NoArc};
pub use joint_line::JointLine;
pub use micro_line::{MicroLine, MicroLineTcpPath, PointValues};
pub use quintic::{JointQuintic, Quintic, QuinticEnd, QuinticPoint};
pub use route::{CompositePath, PathPiece};
pub use turn::ClothoidBlend;

use kinematics::{JointPositions, Pose, RobotModel};
use nalgebra::Vector3;

use crate::scalar::ScalarState;
use crate::setpoint::Setpoint;

/// The joints at one place of a path, and their derivatives with respect to s.
#[derive(Clone, Copy, Debug)]
pub struct PathPoint {
    /// Place, unit of s.
    pub s: f64,
    /// Positions, rad.
    pub q: JointPositions,
    /// dq/ds.
    pub dq_ds: [f64; 6],
    /// d²q/ds².
    pub d2q_ds2: [f64; 6],
    /// The sign of the Jacobian's determinant on a way of the TCP, 0 on ways of the joints. It changes where the joints
    /// go over into another branch of solutions, which they do in singular positions only.
    pub branch: f64,
}

/// What paths are followed with.
#[derive(Clone, Copy)]
pub struct PathContext<'a> {
    /// Geometry of the arm.
    pub model: &'a RobotModel,
    /// The points of a [`MicroLine`].
    pub points: &'a [PointValues],
}

/// A way on which the TCP is led, and the joints follow: what is needed to look at it before it is followed.
pub trait TcpPath {
    /// Length of the path in its s.
    fn length(&self) -> f64;

    /// In how many intervals it is looked at where the joints turn evenly.
    fn intervals(&self) -> usize;

    /// The TCP relative to the flange, as it was when the way was planned.
    fn flange_from_tcp(&self) -> &Pose;

    /// TCP pose at s, base frame.
    fn pose(&self, s: f64) -> Pose;

    /// Joint positions at s, nearest to `near`; `None` when the pose cannot be reached.
    fn positions(
        &self,
        model: &RobotModel,
        s: f64,
        near: &JointPositions,
    ) -> Option<JointPositions> {
        model.inverse_continuous(&self.pose(s), self.flange_from_tcp(), near)
    }

    /// The derivatives at joint positions `q` that lie on the way at s; `None` where the Jacobian is singular.
    fn point(&self, model: &RobotModel, s: f64, q: JointPositions) -> Option<PathPoint>;

    /// Distance the TCP goes per s at s.
    fn tcp_speed_factor(&self, s: f64) -> f64;
}

/// Where a way leads, from 0 to its length in s.
#[allow(
    clippy::large_enum_variant,
    reason = "lives in place inside the cycle, which must not allocate"
)]
#[derive(Clone, Copy, Debug)]
pub enum Path {
    /// A straight line in joint space; s in rad of the leading joint.
    Joint(JointLine),
    /// A line or an arc of the TCP; s in m.
    Cartesian(CartesianPath),
    /// Through many points; s in seconds of the list. Only [`Path::at`] sees the points.
    MicroLine(MicroLine),
    /// A blend in joint space; s in the unit of the path before it.
    JointBlend(JointQuintic),
    /// A blend of two lines of the TCP; s in m.
    ClothoidBlend(ClothoidBlend),
}

impl Path {
    /// The setpoint at a state of s, in the branch of solutions that `near` belongs to. `None` when the inverse
    /// kinematics has no solution there.
    pub fn at(
        &self,
        ground: &PathContext,
        s: &ScalarState,
        near: &JointPositions,
    ) -> Option<Setpoint> {
        match self {
            Self::Joint(line) => Some(line.at(s)),
            Self::MicroLine(line) => line.at(ground.model, ground.points, s, near),
            Self::JointBlend(blend) => Some(blend.at(s)),
            Self::Cartesian(_) | Self::ClothoidBlend(_) => {
                setpoint_at(&self.point(ground.model, s.position, near)?, s)
            }
        }
    }

    /// Joints and derivatives at a place, in the branch of solutions that `near` belongs to. `None` also on a way
    /// through many points, which nothing is blended with.
    pub fn point(&self, model: &RobotModel, s: f64, near: &JointPositions) -> Option<PathPoint> {
        match self {
            Self::Joint(line) => Some(PathPoint {
                s,
                q: line.positions(s),
                dq_ds: line.direction().0,
                d2q_ds2: [0.0; 6],
                branch: 0.0,
            }),
            Self::Cartesian(path) => path.point(model, s, path.positions(model, s, near)?),
            Self::MicroLine(_) => None,
            Self::JointBlend(blend) => {
                let point = blend.point(s);
                Some(PathPoint {
                    s,
                    q: JointPositions(point.q),
                    dq_ds: point.dq_ds,
                    d2q_ds2: point.d2q_ds2,
                    branch: 0.0,
                })
            }
            Self::ClothoidBlend(turn) => turn.point(model, s, turn.positions(model, s, near)?),
        }
    }

    /// Length of the path in its s.
    pub fn length(&self) -> f64 {
        match self {
            Self::Joint(line) => line.length(),
            Self::Cartesian(path) => path.length(),
            Self::MicroLine(line) => line.length(),
            Self::JointBlend(blend) => blend.length(),
            Self::ClothoidBlend(turn) => turn.length(),
        }
    }

    /// Position of the TCP at a place, base frame.
    pub fn tcp_position(&self, model: &RobotModel, flange_from_tcp: &Pose, s: f64) -> Vector3<f64> {
        let q = match self {
            Self::Cartesian(path) => return path.pose(s).translation,
            Self::ClothoidBlend(turn) => return turn.pose(s).translation,
            Self::Joint(line) => line.positions(s),
            // Nothing asks for more: its ends are the waypoints.
            Self::MicroLine(line) if s <= 0.0 => line.start(),
            Self::MicroLine(line) => line.end(),
            Self::JointBlend(blend) => JointPositions(blend.point(s).q),
        };
        model.tcp_pose(&q, flange_from_tcp).translation
    }

    /// Where a leg ends: exactly the target, at rest. Blends are no legs; where one ends the next leg knows better.
    pub fn end_setpoint(&self) -> Setpoint {
        Setpoint::standing(match self {
            Self::Joint(line) => line.end(),
            Self::Cartesian(line) => line.end(),
            Self::MicroLine(line) => line.end(),
            Self::JointBlend(blend) => JointPositions(blend.point(blend.length()).q),
            Self::ClothoidBlend(turn) => turn.end(),
        })
    }
}
