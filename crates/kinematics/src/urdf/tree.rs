//! The tree of links and joints in a URDF, and the one chain of moving joints in it.
//!
//! Owns the checks that make a tree an arm: connected, no branch that moves, nothing but revolute and fixed joints.

use super::ModelError;
use crate::joint::DOF;
use crate::pose::Pose;
use crate::rotation::rotation_from_rpy_exact;
use messages::{Text, text};
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::collections::BTreeMap;
use urdf_rs::{Joint, JointType, Link, Robot};

/// Links by name, and for each the joints that hang from it.
pub(super) struct Tree<'a> {
    pub(super) links: BTreeMap<&'a str, &'a Link>,
    children: BTreeMap<&'a str, Vec<&'a Joint>>,
    root: &'a str,
}

/// The moving joints in order, and where every link sits: the index of its moving joint (0 for the base) and its pose
/// in that joint's frame (in the root for the base).
pub(super) struct JointChain<'a> {
    pub(super) joints: Vec<&'a Joint>,
    pub(super) links: Vec<(&'a Link, usize, Pose)>,
    /// Joint origin in the frame of the joint before (the root for the first), z turned into the joint axis.
    pub(super) parent_from_joint: Vec<Pose>,
}

impl<'a> Tree<'a> {
    pub(super) fn new(robot: &'a Robot) -> Result<Self, ModelError> {
        let mut links = BTreeMap::new();
        for link in &robot.links {
            if links.insert(link.name.as_str(), link).is_some() {
                return Err(ModelError::Duplicate {
                    what: text!("links", "连杆"),
                    name: link.name.clone(),
                });
            }
        }
        let mut children: BTreeMap<&str, Vec<&Joint>> = BTreeMap::new();
        let mut parent_joint: BTreeMap<&str, &Joint> = BTreeMap::new();
        let mut names = BTreeMap::new();
        for joint in &robot.joints {
            if names.insert(joint.name.as_str(), ()).is_some() {
                return Err(ModelError::Duplicate {
                    what: text!("joints", "关节"),
                    name: joint.name.clone(),
                });
            }
            for link in [&joint.parent.link, &joint.child.link] {
                if !links.contains_key(link.as_str()) {
                    return Err(ModelError::MissingLink {
                        joint: joint.name.clone(),
                        link: link.clone(),
                    });
                }
            }
            children.entry(&joint.parent.link).or_default().push(joint);
            if parent_joint.insert(&joint.child.link, joint).is_some() {
                return Err(ModelError::Tree {
                    link: joint.child.link.clone(),
                    reason: text!("is the child of two joints", "是两个关节的子连杆"),
                });
            }
        }
        let mut roots = links
            .keys()
            .filter(|name| !parent_joint.contains_key(*name));
        let root = roots.next().copied().ok_or_else(|| ModelError::Tree {
            link: robot
                .links
                .first()
                .map(|l| l.name.clone())
                .unwrap_or_default(),
            reason: text!(
                "hangs from itself: there is no root link",
                "挂在自身上：没有根连杆"
            ),
        })?;
        if let Some(second) = roots.next() {
            return Err(ModelError::Tree {
                link: (*second).to_owned(),
                reason: text!("is not connected to the rest", "没有与其余部分相连"),
            });
        }
        Ok(Self {
            links,
            children,
            root,
        })
    }

    /// Follows the joints from the root outwards, fixed parts first, so that a branch is noticed.
    pub(super) fn joint_chain(&self) -> Result<JointChain<'a>, ModelError> {
        let mut walk = JointChain {
            joints: Vec::new(),
            links: Vec::new(),
            parent_from_joint: Vec::new(),
        };
        let mut here = vec![(self.root, Pose::IDENTITY)];
        loop {
            let mut moving: Option<(&Joint, &str, Pose)> = None;
            while let Some((name, body_from_link)) = here.pop() {
                walk.links
                    .push((self.links[name], walk.joints.len(), body_from_link));
                for &joint in self.children.get(name).into_iter().flatten() {
                    let body_from_joint = body_from_link * origin(joint)?;
                    match joint.joint_type {
                        JointType::Fixed => here.push((&joint.child.link, body_from_joint)),
                        JointType::Revolute => {
                            if let Some((first, _, _)) = moving {
                                return Err(ModelError::Branch {
                                    link: name.to_owned(),
                                    first: first.name.clone(),
                                    second: joint.name.clone(),
                                });
                            }
                            moving = Some((joint, &joint.child.link, body_from_joint));
                        }
                        ref other => {
                            return Err(ModelError::JointKind {
                                joint: joint.name.clone(),
                                kind: kind_name(other),
                            });
                        }
                    }
                }
            }
            let Some((joint, child, body_from_joint)) = moving else {
                break;
            };
            let z_to_axis = axis_rotation(joint)?;
            walk.parent_from_joint
                .push(body_from_joint * Pose::new(z_to_axis, Vector3::zeros()));
            walk.joints.push(joint);
            here.push((child, Pose::new(z_to_axis.inverse(), Vector3::zeros())));
        }
        for name in self.links.keys() {
            if !walk.links.iter().any(|(link, _, _)| link.name == *name) {
                return Err(ModelError::Tree {
                    link: (*name).to_owned(),
                    reason: text!("is not connected to the rest", "没有与其余部分相连"),
                });
            }
        }
        if walk.joints.len() != DOF {
            return Err(ModelError::JointCount {
                found: walk.joints.len(),
                names: walk
                    .joints
                    .iter()
                    .map(|j| j.name.as_str())
                    .collect::<Vec<_>>()
                    .join(", "),
            });
        }
        Ok(walk)
    }
}

fn kind_name(kind: &JointType) -> Text {
    Text::verbatim(match kind {
        JointType::Revolute => "revolute",
        JointType::Continuous => {
            return text!(
                "continuous (give it limits and the type revolute)",
                "continuous（请给出限值，类型改为 revolute）"
            );
        }
        JointType::Prismatic => "prismatic",
        JointType::Fixed => "fixed",
        JointType::Floating => "floating",
        JointType::Planar => "planar",
        JointType::Spherical => "spherical",
    })
}

pub(super) fn pose_of(pose: &urdf_rs::Pose) -> Option<Pose> {
    let finite = pose.xyz.0.iter().chain(&pose.rpy.0).all(|x| x.is_finite());
    finite.then(|| {
        Pose::new(
            rotation_from_rpy_exact(pose.rpy.0),
            Vector3::from(pose.xyz.0),
        )
    })
}

fn origin(joint: &Joint) -> Result<Pose, ModelError> {
    pose_of(&joint.origin).ok_or_else(|| ModelError::Joint {
        joint: joint.name.clone(),
        reason: text!(
            "has an origin with a number that is not finite",
            "的原点有不是有限的数"
        ),
    })
}

/// The rotation that takes z to the joint's axis.
fn axis_rotation(joint: &Joint) -> Result<Rotation3<f64>, ModelError> {
    let axis = Vector3::from(joint.axis.xyz.0);
    let axis = Some(axis.norm())
        .filter(|length| length.is_finite() && *length > 1e-9)
        .map(|length| axis / length)
        .ok_or_else(|| ModelError::Joint {
            joint: joint.name.clone(),
            reason: text!(
                "has the axis {:?}, which has no direction",
                "的轴线为 {:?}，没有方向",
                joint.axis.xyz.0
            ),
        })?;
    if axis == Vector3::z() {
        return Ok(Rotation3::identity());
    }
    Ok(Rotation3::rotation_between(&Vector3::z(), &axis)
        // Opposite directions: half a turn about any axis across.
        .unwrap_or_else(|| {
            Rotation3::from_matrix_unchecked(Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0)))
        }))
}
