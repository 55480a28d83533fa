//! Where a motion command should lead, written down once more: a line in joint space, a line or an arc of the TCP.
//!
//! Independent of the planner: from the command and the place where it begins, by geometry alone.

use core::f64::consts::TAU;

use kinematics::rotation::{rotation_from_rotvec, rotvec_from_rotation};
use kinematics::{JointPositions, Pose, RobotModel};
use motion_api::{CommandKind, MotionCommand};
use nalgebra::Vector3;

/// Places at which the way of the TCP is followed to know the joints at its end.
const PLACES: usize = 400;

#[derive(Clone, Debug)]
pub enum Way {
    Joint {
        from: JointPositions,
        to: JointPositions,
    },
    Tcp {
        from: Pose,
        to: Pose,
        /// Centre, axis and angle of an arc.
        arc: Option<(Vector3<f64>, Vector3<f64>, f64)>,
        /// About one axis, rad.
        turn: Vector3<f64>,
    },
}

impl Way {
    /// `None` where the command makes no way, such as an arc through points of a line.
    pub fn of(kind: &CommandKind, q: &JointPositions, from: Pose) -> Option<Self> {
        let turn_to = |to: &Pose| rotvec_from_rotation(&(to.rotation * from.rotation.inverse()));
        Some(match *kind {
            CommandKind::Motion(MotionCommand::MoveJ { target, .. }) => Self::Joint {
                from: *q,
                to: target,
            },
            CommandKind::Motion(
                MotionCommand::MoveL { target, .. } | MotionCommand::MoveP { target, .. },
            ) => {
                let to = Pose::from_rpy(&target);
                let turn = turn_to(&to);
                Self::Tcp {
                    from,
                    to,
                    arc: None,
                    turn,
                }
            }
            CommandKind::Motion(MotionCommand::MoveC {
                via, target, fixed, ..
            }) => {
                let mut to = Pose::from_rpy(&target);
                let arc = arc(from.translation, via.xyz.into(), to.translation)?;
                let mut turn = turn_to(&to);
                if fixed {
                    turn = arc.1 * arc.2;
                    to.rotation = rotation_from_rotvec(turn) * from.rotation;
                }
                Self::Tcp {
                    from,
                    to,
                    arc: Some(arc),
                    turn,
                }
            }
            _ => return None,
        })
    }

    /// Pose of the TCP where it ends.
    pub fn end(&self, model: &RobotModel, tcp: &Pose) -> Pose {
        match self {
            Self::Joint { to, .. } => model.tcp_pose(to, tcp),
            Self::Tcp { to, .. } => *to,
        }
    }

    /// Joint positions at the end, by following; `None` where the arm cannot.
    pub fn end_q(
        &self,
        model: &RobotModel,
        tcp: &Pose,
        from: &JointPositions,
    ) -> Option<JointPositions> {
        match self {
            Self::Joint { to, .. } => Some(*to),
            Self::Tcp { .. } => (1..=PLACES).try_fold(*from, |q, place| {
                let pose = self.pose(place as f64 / PLACES as f64);
                model.inverse_nearest(&pose, tcp, &q)
            }),
        }
    }

    /// How far from the way: rad in joint space; of the TCP the larger of m and rad.
    pub fn deviation(&self, q: &JointPositions, pose: &Pose) -> f64 {
        match self {
            Self::Joint { from, to } => {
                let way: Vec<f64> = (0..6).map(|j| to[j] - from[j]).collect();
                let done: Vec<f64> = (0..6).map(|j| q[j] - from[j]).collect();
                let square: f64 = way.iter().map(|x| x * x).sum();
                let share = if square > 0.0 {
                    way.iter().zip(&done).map(|(w, d)| w * d).sum::<f64>() / square
                } else {
                    0.0
                };
                let share = share.clamp(0.0, 1.0);
                let off = way.iter().zip(&done).map(|(w, d)| (d - w * share).abs());
                off.fold(0.0, f64::max)
            }
            Self::Tcp { .. } => {
                let (moved, turned) = self.off(pose);
                moved.max(turned)
            }
        }
    }

    /// How far from a way of the TCP, m and rad.
    pub fn off(&self, pose: &Pose) -> (f64, f64) {
        distance(pose, &self.pose(self.share(pose)))
    }

    /// How much of a TCP's way lies behind `pose`, 0 to 1.
    fn share(&self, pose: &Pose) -> f64 {
        let Self::Tcp {
            from,
            to,
            arc,
            turn,
        } = self
        else {
            return 0.0;
        };
        let share = match arc {
            Some((centre, axis, angle)) => {
                let (start, here) = (from.translation - centre, pose.translation - centre);
                let sine = start.cross(&here).dot(axis);
                let turned = sine.atan2(start.dot(&here)).rem_euclid(TAU);
                // Just before the start is not nearly a whole turn.
                let turned = if turned > (angle + TAU) / 2.0 {
                    turned - TAU
                } else {
                    turned
                };
                turned / angle
            }
            None => {
                let way = to.translation - from.translation;
                if way.norm() > 1e-3 * turn.norm() && way.norm() > 1e-9 {
                    (pose.translation - from.translation).dot(&way) / way.norm_squared()
                } else if turn.norm() > 0.0 {
                    let turned = rotvec_from_rotation(&(pose.rotation * from.rotation.inverse()));
                    turned.dot(turn) / turn.norm_squared()
                } else {
                    0.0
                }
            }
        };
        share.clamp(0.0, 1.0)
    }

    pub fn pose(&self, share: f64) -> Pose {
        let Self::Tcp {
            from,
            to,
            arc,
            turn,
        } = self
        else {
            return Pose::IDENTITY;
        };
        let position = match arc {
            Some((centre, axis, angle)) => {
                centre + rotation_from_rotvec(axis * (angle * share)) * (from.translation - centre)
            }
            None => from.translation + (to.translation - from.translation) * share,
        };
        Pose::new(rotation_from_rotvec(turn * share) * from.rotation, position)
    }
}

/// Distance and angle between two poses.
pub fn distance(a: &Pose, b: &Pose) -> (f64, f64) {
    let turned = rotvec_from_rotation(&(a.rotation.inverse() * b.rotation));
    ((a.translation - b.translation).norm(), turned.norm())
}

/// Centre, axis and angle of the arc through three points; by the centre's barycentric coordinates.
fn arc(
    a: Vector3<f64>,
    b: Vector3<f64>,
    c: Vector3<f64>,
) -> Option<(Vector3<f64>, Vector3<f64>, f64)> {
    let (aa, bb, cc) = (
        (b - c).norm_squared(),
        (a - c).norm_squared(),
        (a - b).norm_squared(),
    );
    let weights = [
        aa * (bb + cc - aa),
        bb * (aa + cc - bb),
        cc * (aa + bb - cc),
    ];
    let sum: f64 = weights.iter().sum();
    let axis = (b - a).cross(&(c - a)).try_normalize(1e-9)?;
    let centre = (a * weights[0] + b * weights[1] + c * weights[2]) / sum;
    let (from, to) = (a - centre, c - centre);
    let angle = from
        .cross(&to)
        .dot(&axis)
        .atan2(from.dot(&to))
        .rem_euclid(TAU);
    angle.is_finite().then_some((centre, axis, angle))
}
