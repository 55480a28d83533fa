//! A way of the TCP: a straight line or a circular arc, with rotation about one fixed axis.
//!
//! s is the distance along the way in metres; where the rotation is the larger part, one radian counts as
//! [`ROTATION_LENGTH`] metres of it. With x the TCP's twist per s and J the Jacobian at the TCP (dashes: derivatives
//! with respect to s): q' = J⁻¹ x, q'' = J⁻¹ (x' - J' q'). x' is zero on a line and points to the centre on an arc.

use kinematics::elementary::atan2;
use kinematics::rotation::{rotation_from_rotvec, rotvec_from_rotation};
use kinematics::{JointAccelerations, JointPositions, JointSpeeds, Pose, RobotModel, Twist};
use nalgebra::{Vector3, Vector6};

use super::{PathPoint, TcpPath};
use crate::constants::{
    INTERVAL_LENGTH, LINE_INTERVALS, MIN_DISTANCE, ROTATION_LENGTH, STRAIGHT_ARC,
};
use crate::scalar::ScalarState;
use crate::setpoint::Setpoint;

/// From one TCP pose to another.
#[derive(Clone, Copy, Debug)]
pub struct CartesianPath {
    start: Pose,
    end: Pose,
    end_q: JointPositions,
    flange_from_tcp: Pose,
    shape: PositionPath,
    /// Rotation per s, rad/m, base axes.
    rotation_per_s: Vector3<f64>,
    length: f64,
}

/// What the TCP's position does.
#[derive(Clone, Copy, Debug)]
enum PositionPath {
    /// Displacement per s, no unit (metres per metre), base axes.
    Line { along: Vector3<f64> },
    /// Turning about an axis of length 1 through `centre`, rad/m.
    Arc {
        centre: Vector3<f64>,
        axis: Vector3<f64>,
        turn_per_s: f64,
        radius: f64,
    },
}

/// Three points that do not make a circular arc.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoArc;

/// How the tool turns on an arc (manual 3.1.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArcOrientation {
    /// Fixed to the direction of motion: the tool turns with the arc; the orientation of the target is not used.
    WithTheArc,
    /// From the orientation at the start to that of the target, about one axis.
    ToTheTarget,
}

impl CartesianPath {
    /// The line from `start` to `end`, both TCP poses in the base frame; of length 0 when they are the same.
    ///
    /// Where the arm ends is known once the way has been followed: see [`ending_at`](Self::ending_at).
    pub fn line(start: Pose, end: Pose, flange_from_tcp: Pose, start_q: JointPositions) -> Self {
        let way = end.translation - start.translation;
        let turn = rotvec_from_rotation(&(end.rotation * start.rotation.inverse()));
        let (length, per_s) = length_and_inverse(way.norm(), turn.norm());
        Self {
            start,
            end,
            end_q: start_q,
            flange_from_tcp,
            shape: PositionPath::Line { along: way * per_s },
            rotation_per_s: turn * per_s,
            length,
        }
    }

    /// The arc from `start` through the point `via` to the position of `end`, less than a whole turn.
    ///
    /// # Errors
    /// [`NoArc`] when the three points coincide or lie on a line, to one part in a million.
    pub fn arc(
        start: Pose,
        via: Vector3<f64>,
        mut end: Pose,
        orientation: ArcOrientation,
        flange_from_tcp: Pose,
        start_q: JointPositions,
    ) -> Result<Self, NoArc> {
        let (to_via, to_end) = (via - start.translation, end.translation - start.translation);
        let normal = to_via.cross(&to_end);
        let sides = to_via.norm() * to_end.norm() * (to_end - to_via).norm();
        // sin of an angle of the triangle = 2 area / (product of two sides).
        let flat = normal.norm() <= STRAIGHT_ARC * to_via.norm() * to_end.norm();
        if flat || normal.norm() <= STRAIGHT_ARC * to_end.norm_squared() || sides < MIN_DISTANCE {
            return Err(NoArc);
        }
        // Circumcentre of a triangle with one corner at the origin.
        let centre_from_start = (to_via.norm_squared() * to_end.cross(&normal)
            - to_end.norm_squared() * to_via.cross(&normal))
            / (2.0 * normal.norm_squared());
        let centre = start.translation + centre_from_start;
        let radius = centre_from_start.norm();
        let axis = normal / normal.norm();
        // The way start, via, end goes about the normal of the triangle in the positive sense.
        let (from, to) = (start.translation - centre, end.translation - centre);
        let angle = atan2(from.cross(&to).dot(&axis), from.dot(&to));
        let angle = angle.rem_euclid(core::f64::consts::TAU);
        let turn = match orientation {
            ArcOrientation::WithTheArc => axis * angle,
            ArcOrientation::ToTheTarget => {
                rotvec_from_rotation(&(end.rotation * start.rotation.inverse()))
            }
        };
        if orientation == ArcOrientation::WithTheArc {
            end.rotation = rotation_from_rotvec(turn) * start.rotation;
        }
        let (length, per_s) = length_and_inverse(
            radius * angle,
            match orientation {
                // The tool turns with the arc, so the distance alone counts.
                ArcOrientation::WithTheArc => 0.0,
                ArcOrientation::ToTheTarget => turn.norm(),
            },
        );
        if !(length > MIN_DISTANCE && length.is_finite()) {
            return Err(NoArc);
        }
        Ok(Self {
            start,
            end,
            end_q: start_q,
            flange_from_tcp,
            shape: PositionPath::Arc {
                centre,
                axis,
                turn_per_s: angle * per_s,
                radius,
            },
            rotation_per_s: turn * per_s,
            length,
        })
    }

    /// The way with the joint positions at its end.
    #[must_use]
    pub fn ending_at(self, end_q: JointPositions) -> Self {
        Self { end_q, ..self }
    }

    /// The first part of the way, up to `s`, with the joint positions there.
    #[must_use]
    pub fn until(self, s: f64, end_q: JointPositions) -> Self {
        Self {
            end: self.pose(s),
            end_q,
            length: s.min(self.length),
            ..self
        }
    }

    /// Joint positions at the end.
    pub fn end(&self) -> JointPositions {
        self.end_q
    }

    /// Where a line leads, as a unit vector; `None` on arcs, and where s is not the distance of the TCP.
    pub fn direction(&self) -> Option<Vector3<f64>> {
        match self.shape {
            PositionPath::Line { along } if (along.norm() - 1.0).abs() < 1e-9 => Some(along),
            PositionPath::Line { .. } | PositionPath::Arc { .. } => None,
        }
    }

    /// Rotation per s, rad/m, base axes.
    pub fn rotation_per_s(&self) -> Vector3<f64> {
        self.rotation_per_s
    }
}

impl TcpPath for CartesianPath {
    /// m.
    fn length(&self) -> f64 {
        self.length
    }

    fn intervals(&self) -> usize {
        let even = (self.length / INTERVAL_LENGTH).ceil().max(4.0);
        (even as usize).min(LINE_INTERVALS)
    }

    fn flange_from_tcp(&self) -> &Pose {
        &self.flange_from_tcp
    }

    /// Exactly the end pose at the end.
    fn pose(&self, s: f64) -> Pose {
        if s >= self.length {
            return self.end;
        }
        let position = match self.shape {
            PositionPath::Line { along } => self.start.translation + along * s,
            PositionPath::Arc {
                centre,
                axis,
                turn_per_s,
                ..
            } => {
                let from = self.start.translation - centre;
                centre + rotation_from_rotvec(axis * (turn_per_s * s)) * from
            }
        };
        Pose::new(
            rotation_from_rotvec(self.rotation_per_s * s) * self.start.rotation,
            position,
        )
    }

    fn point(&self, model: &RobotModel, s: f64, q: JointPositions) -> Option<PathPoint> {
        derivatives(model, &self.flange_from_tcp, s, q, |tcp| {
            let (linear, bend) = match self.shape {
                PositionPath::Line { along } => (along, Vector3::zeros()),
                PositionPath::Arc {
                    centre,
                    axis,
                    turn_per_s,
                    ..
                } => {
                    let across = axis * turn_per_s;
                    let linear = across.cross(&(tcp - centre));
                    (linear, across.cross(&linear))
                }
            };
            PathTwist {
                linear,
                linear_rate: bend,
                angular: self.rotation_per_s,
                angular_rate: Vector3::zeros(),
            }
        })
    }

    /// 1 unless the rotation is the larger part.
    fn tcp_speed_factor(&self, _s: f64) -> f64 {
        match self.shape {
            PositionPath::Line { along } => along.norm(),
            PositionPath::Arc {
                turn_per_s, radius, ..
            } => turn_per_s * radius,
        }
    }
}

/// Velocity of the TCP per s, and how it changes with s.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathTwist {
    pub(super) linear: Vector3<f64>,
    pub(super) linear_rate: Vector3<f64>,
    pub(super) angular: Vector3<f64>,
    pub(super) angular_rate: Vector3<f64>,
}

/// The joints' derivatives at `q` where the TCP moves as `bent` says for its position; `None` where the Jacobian is
/// singular.
pub(super) fn derivatives(
    model: &RobotModel,
    flange_from_tcp: &Pose,
    s: f64,
    q: JointPositions,
    bent: impl Fn(Vector3<f64>) -> PathTwist,
) -> Option<PathPoint> {
    let frames = model.forward(&q);
    let tcp = (frames.base_from_flange * *flange_from_tcp).translation;
    let jacobian = frames.jacobian(tcp).lu();
    let bent = bent(tcp);
    let twist = Twist {
        linear: bent.linear,
        angular: bent.angular,
    };
    let change = Twist {
        linear: bent.linear_rate,
        angular: bent.angular_rate,
    };
    let first: [f64; 6] = jacobian.solve(&to_vector6(&twist))?.into();
    let bias = frames.jacobian_rate_times_speeds(&JointSpeeds(first), tcp);
    let second: [f64; 6] = jacobian
        .solve(&(to_vector6(&change) - to_vector6(&bias)))?
        .into();
    let is_finite = first.iter().chain(&second).all(|x| x.is_finite());
    is_finite.then_some(PathPoint {
        s,
        q,
        dq_ds: first,
        d2q_ds2: second,
        branch: jacobian.determinant().signum(),
    })
}

/// The setpoint at a point of a path, at a state of s there.
pub(super) fn setpoint_at(point: &PathPoint, s: &ScalarState) -> Option<Setpoint> {
    let (v, a) = (s.speed, s.acceleration);
    Some(Setpoint {
        q: point.q,
        qd: JointSpeeds(point.dq_ds.map(|d| d * v)),
        qdd: JointAccelerations(core::array::from_fn(|joint| {
            point.d2q_ds2[joint] * v * v + point.dq_ds[joint] * a
        })),
    })
}

/// Length of a way in metres of s, and its inverse; both 0 where nothing moves.
fn length_and_inverse(way: f64, turn: f64) -> (f64, f64) {
    let length = way.max(turn * ROTATION_LENGTH);
    if length > MIN_DISTANCE {
        (length, 1.0 / length)
    } else {
        (0.0, 0.0)
    }
}

fn to_vector6(twist: &Twist) -> Vector6<f64> {
    let (l, a) = (twist.linear, twist.angular);
    Vector6::new(l.x, l.y, l.z, a.x, a.y, a.z)
}
