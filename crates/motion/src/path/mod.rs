//! Geometric paths of the whole arm, without time: where the joints are at each place s of the way.
//!
//! A [`Path`] is one leg or one blend: a [`Geometry`], walked evenly or at a [`Pace`]. A [`Chain`] is what a motion
//! follows: one path, or the rest of one, a blend and the next.

mod cartesian;
mod chain;
mod joint_line;
mod micro_line;
mod pace;
mod quintic;

pub use cartesian::{ArcOrientation, CartesianPath, NoArc};
pub use chain::{Chain, Piece};
pub use joint_line::JointLine;
pub use micro_line::MicroLine;
pub use pace::{PACE_POINTS, Pace, PacePiece, PacePoint};
pub use quintic::{JointQuintic, QuinticPoint};

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
    pub first: [f64; 6],
    /// d²q/ds².
    pub second: [f64; 6],
}

/// What paths are followed with.
#[derive(Clone, Copy)]
pub struct Ground<'a> {
    /// Geometry of the arm.
    pub model: &'a RobotModel,
    /// The points of a [`MicroLine`].
    pub points: &'a [JointPositions],
}

/// Where a way leads.
#[allow(
    clippy::large_enum_variant,
    reason = "lives in place inside the cycle, which must not allocate"
)]
#[derive(Clone, Copy, Debug)]
pub enum Geometry {
    /// A straight line in joint space; s in rad of the leading joint.
    Joint(JointLine),
    /// A line or an arc of the TCP; s in m.
    Cartesian(CartesianPath),
    /// Through many points; s in seconds of the list. Only [`Path::at`] sees the points.
    Micro(MicroLine),
    /// A blend between two paths; s in the unit of the chain it belongs to.
    Blend(JointQuintic),
}

impl Geometry {
    fn at(&self, ground: &Ground, s: &ScalarState, near: &JointPositions) -> Option<Setpoint> {
        match self {
            Self::Joint(line) => Some(line.at(s)),
            Self::Cartesian(line) => line.at(ground.model, s, near),
            Self::Micro(line) => line.at(ground.points, s),
            Self::Blend(blend) => Some(blend.at(s)),
        }
    }

    fn point(&self, model: &RobotModel, s: f64, near: &JointPositions) -> Option<PathPoint> {
        match self {
            Self::Joint(line) => Some(PathPoint {
                s,
                q: line.positions(s),
                first: line.direction().0,
                second: [0.0; 6],
            }),
            Self::Cartesian(path) => {
                let q = path.positions(model, s, near)?;
                path.point(model, s, q)
            }
            Self::Micro(_) => None,
            Self::Blend(blend) => {
                let point = blend.point(s);
                Some(PathPoint {
                    s,
                    q: JointPositions(point.q),
                    first: point.first,
                    second: point.second,
                })
            }
        }
    }

    fn length(&self) -> f64 {
        match self {
            Self::Joint(line) => line.length(),
            Self::Cartesian(path) => path.length(),
            Self::Micro(line) => line.length(),
            Self::Blend(blend) => blend.length(),
        }
    }
}

/// A way from one place to another, walked from 0 to its length in a parameter of its own: the way's s, or one of which
/// s is a smooth function.
#[derive(Clone, Copy, Debug)]
pub struct Path {
    geometry: Geometry,
    pace: Option<Pace>,
}

impl Path {
    /// A way walked evenly: the parameter is s.
    pub const fn new(geometry: Geometry) -> Self {
        Self {
            geometry,
            pace: None,
        }
    }

    /// The same way walked at a pace made for it.
    #[must_use]
    pub fn paced(self, pace: Pace) -> Self {
        Self {
            pace: Some(pace),
            ..self
        }
    }

    /// Where it leads.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// The way's s and its derivatives at a place.
    pub fn way(&self, u: f64) -> PacePoint {
        match &self.pace {
            Some(pace) => pace.at(u),
            None => PacePoint {
                s: u,
                first: 1.0,
                second: 0.0,
            },
        }
    }

    /// The setpoint at a state of the parameter, in the branch of solutions that `near` belongs to. `None` when the
    /// inverse kinematics has no solution there.
    pub fn at(&self, ground: &Ground, u: &ScalarState, near: &JointPositions) -> Option<Setpoint> {
        let way = self.way(u.position);
        let s = ScalarState {
            position: way.s,
            speed: way.first * u.speed,
            acceleration: way.first * u.acceleration + way.second * u.speed * u.speed,
        };
        self.geometry.at(ground, &s, near)
    }

    /// Joints and derivatives at a place, in the branch of solutions that `near` belongs to. `None` also on a way through
    /// many points, which nothing is blended with.
    pub fn point(&self, model: &RobotModel, u: f64, near: &JointPositions) -> Option<PathPoint> {
        let way = self.way(u);
        let point = self.geometry.point(model, way.s, near)?;
        Some(PathPoint {
            s: u,
            q: point.q,
            first: point.first.map(|d| d * way.first),
            second: core::array::from_fn(|joint| {
                point.second[joint] * way.first * way.first + point.first[joint] * way.second
            }),
        })
    }

    /// How long it is in its parameter.
    pub fn length(&self) -> f64 {
        match &self.pace {
            Some(pace) => pace.length(),
            None => self.geometry.length(),
        }
    }

    /// Position of the TCP at a place, base frame.
    pub fn tcp(&self, model: &RobotModel, flange_from_tcp: &Pose, u: f64) -> Vector3<f64> {
        let s = self.way(u).s;
        let q = match &self.geometry {
            Geometry::Cartesian(path) => return path.pose(s).translation,
            Geometry::Joint(line) => line.positions(s),
            // Nothing asks for more: its ends are the waypoints.
            Geometry::Micro(line) if u <= 0.0 => line.start(),
            Geometry::Micro(line) => line.end(),
            Geometry::Blend(blend) => JointPositions(blend.point(s).q),
        };
        model.tcp_pose(&q, flange_from_tcp).translation
    }

    /// Where it ends: exactly the target, at rest.
    pub fn end(&self) -> Setpoint {
        Setpoint::standing(match &self.geometry {
            Geometry::Joint(line) => line.end(),
            Geometry::Cartesian(line) => line.end(),
            Geometry::Micro(line) => line.end(),
            Geometry::Blend(blend) => JointPositions(blend.point(blend.length()).q),
        })
    }
}
