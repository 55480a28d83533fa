//! What public viewers show without set-up: `/joint_states`, `/tf`, `/tcp` and `/scene`.
//!
//! Owns the names of the frames and the drawing of the arm. Everything is the arm as it is (`actual_*`), not as it was
//! commanded. Frames form one tree: `base_link`, the six links, `flange`, `tcp`.

use foxglove::messages as shown;
use foxglove::messages::Timestamp;
use kinematics::{Capsule, DOF, Pose, RobotModel};
use motion_api::RobotState;
use nalgebra::{Unit, UnitQuaternion, Vector3};

/// Name of the base frame.
pub const BASE_FRAME: &str = "base_link";
/// Names of the link frames, as in the URDF files of the CS arms.
pub const LINK_FRAMES: [&str; DOF] = [
    "shoulder_link",
    "upperarm_link",
    "forearm_link",
    "wrist_1_link",
    "wrist_2_link",
    "wrist_3_link",
];
/// Name of the tool flange's frame.
pub const FLANGE_FRAME: &str = "flange";
/// Name of the TCP's frame.
pub const TCP_FRAME: &str = "tcp";

/// Diameter of the ball that marks the TCP, m.
const TCP_BALL: f64 = 0.012;

/// Makes the viewers' messages for one arm.
#[derive(Clone)]
pub(crate) struct Viewer {
    model: RobotModel,
}

impl Viewer {
    pub(crate) fn new(model: RobotModel) -> Self {
        Self { model }
    }

    pub(crate) fn joint_states(&self, state: &RobotState, at: Timestamp) -> shown::JointStates {
        let names = self.model.joint_names().iter();
        let joints = names.enumerate().map(|(joint, name)| shown::JointState {
            name: name.clone(),
            position: Some(state.actual_q[joint]),
            velocity: Some(state.actual_qd[joint]),
            acceleration: None,
            effort: Some(state.actual_torque[joint]),
        });
        shown::JointStates {
            timestamp: Some(at),
            joints: joints.collect(),
        }
    }

    pub(crate) fn frames(&self, state: &RobotState, at: Timestamp) -> shown::FrameTransforms {
        let frames = self.model.forward(&state.actual_q);
        let mut transforms = Vec::with_capacity(DOF + 2);
        let mut add = |parent: &str, child: &str, parent_from_child: &Pose| {
            transforms.push(shown::FrameTransform {
                timestamp: Some(at),
                parent_frame_id: parent.to_owned(),
                child_frame_id: child.to_owned(),
                translation: Some(vector(parent_from_child.translation)),
                rotation: Some(quaternion(&rotation(parent_from_child))),
            });
        };
        let mut parent = (BASE_FRAME, Pose::IDENTITY);
        for (name, base_from_link) in LINK_FRAMES.into_iter().zip(frames.base_from_joint) {
            add(parent.0, name, &(parent.1.inverse() * base_from_link));
            parent = (name, base_from_link);
        }
        add(
            parent.0,
            FLANGE_FRAME,
            &self.model.chain().joint6_from_flange,
        );
        add(FLANGE_FRAME, TCP_FRAME, &Pose::from_rpy(&state.tcp_offset));
        shown::FrameTransforms { transforms }
    }

    pub(crate) fn tcp(&self, state: &RobotState, at: Timestamp) -> shown::PoseInFrame {
        shown::PoseInFrame {
            timestamp: Some(at),
            frame_id: BASE_FRAME.to_owned(),
            pose: Some(pose(&Pose::from_rpy(&state.actual_tcp_pose))),
        }
    }

    /// The arm, one entity a link, each fixed to its frame so that `/tf` moves it.
    pub(crate) fn scene(&self, at: Timestamp) -> shown::SceneUpdate {
        let names = [BASE_FRAME].into_iter().chain(LINK_FRAMES);
        let mut entities: Vec<_> = names
            .enumerate()
            .map(|(link, name)| {
                let color = if link % 2 == 0 { LIGHT } else { DARK };
                let mut drawn = entity(name, at);
                for capsule in self.model.collision().capsules(link) {
                    draw(capsule, color, &mut drawn);
                }
                drawn
            })
            .collect();
        let mut tcp = entity(TCP_FRAME, at);
        tcp.spheres.push(ball(Vector3::zeros(), TCP_BALL, ACCENT));
        entities.push(tcp);
        shown::SceneUpdate {
            deletions: Vec::new(),
            entities,
        }
    }
}

const LIGHT: shown::Color = shown::Color {
    r: 0.88,
    g: 0.89,
    b: 0.91,
    a: 1.0,
};
const DARK: shown::Color = shown::Color {
    r: 0.36,
    g: 0.42,
    b: 0.50,
    a: 1.0,
};
const ACCENT: shown::Color = shown::Color {
    r: 0.90,
    g: 0.35,
    b: 0.10,
    a: 1.0,
};

/// An empty entity that moves with a frame and stays until it is replaced (no lifetime).
fn entity(frame: &str, at: Timestamp) -> shown::SceneEntity {
    shown::SceneEntity {
        timestamp: Some(at),
        frame_id: frame.to_owned(),
        id: frame.to_owned(),
        frame_locked: true,
        ..shown::SceneEntity::default()
    }
}

/// A capsule is a cylinder with a ball at each end.
fn draw(capsule: &Capsule, color: shown::Color, entity: &mut shown::SceneEntity) {
    let diameter = 2.0 * capsule.radius;
    let axis = capsule.p1 - capsule.p0;
    entity.spheres.push(ball(capsule.p0, diameter, color));
    let Some(direction) = Unit::try_new(axis, 1e-9) else {
        return;
    };
    entity.spheres.push(ball(capsule.p1, diameter, color));
    // A half turn about x where the axis points along -z: the shortest turn is not unique there.
    let turn = UnitQuaternion::rotation_between_axis(&Vector3::z_axis(), &direction)
        .unwrap_or_else(|| {
            UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
        });
    entity.cylinders.push(shown::CylinderPrimitive {
        pose: Some(shown::Pose {
            position: Some(vector((capsule.p0 + capsule.p1) / 2.0)),
            orientation: Some(quaternion(&turn)),
        }),
        size: Some(vector(Vector3::new(diameter, diameter, axis.norm()))),
        bottom_scale: 1.0,
        top_scale: 1.0,
        color: Some(color),
    });
}

fn ball(center: Vector3<f64>, diameter: f64, color: shown::Color) -> shown::SpherePrimitive {
    shown::SpherePrimitive {
        pose: Some(pose(&Pose::from_translation(center.x, center.y, center.z))),
        size: Some(vector(Vector3::repeat(diameter))),
        color: Some(color),
    }
}

fn rotation(pose: &Pose) -> UnitQuaternion<f64> {
    UnitQuaternion::from_rotation_matrix(&pose.rotation)
}

fn pose(pose: &Pose) -> shown::Pose {
    shown::Pose {
        position: Some(vector(pose.translation)),
        orientation: Some(quaternion(&rotation(pose))),
    }
}

fn vector(v: Vector3<f64>) -> shown::Vector3 {
    shown::Vector3 {
        x: v.x,
        y: v.y,
        z: v.z,
    }
}

fn quaternion(q: &UnitQuaternion<f64>) -> shown::Quaternion {
    shown::Quaternion {
        x: q.i,
        y: q.j,
        z: q.k,
        w: q.w,
    }
}
