//! From a URDF text to a [`RobotModel`].
//!
//! Owns the rules a robot description must obey to be one of our arms: six revolute joints in a row, everything else
//! fixed. Links that are fixed to a moving link are merged into it. Reads text only; [`crate::catalogue`] opens files.

mod extension;
mod shapes;
mod tree;

use crate::chain::Chain;
use crate::collision::{Capsule, CollisionModel, LINKS};
use crate::ik::IkMethod;
use crate::joint::{DOF, JointAccelerations, JointPositions, JointSpeeds, JointTorques};
use crate::model::{JointLimits, RobotModel};
use crate::payload::{RigidBody, is_physical, principal_moments};
use crate::pose::Pose;
use extension::Extension;
use messages::{Localized, Text, text};
use nalgebra::{Matrix3, Vector3};
use tree::{JointChain, Tree, pose_of};
use urdf_rs::Link;

/// Acceleration limit of a joint for which a URDF names none, rad/s². Ours; see `robots/README.md`.
pub const DEFAULT_JOINT_ACCELERATION: f64 = 10.0;

/// A URDF larger than this is refused unread, bytes.
const SIZE_MAX: usize = 4 << 20;

/// A reason why there is no robot model.
#[derive(Debug, thiserror::Error, Localized)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ModelError {
    #[error(
        "there is no built-in robot model `{name}`; built in are {known}, a path of a URDF file works as well"
    )]
    #[zh("没有内置的机器人型号 `{name}`；内置的有 {known}，也可以给出 URDF 文件的路径")]
    UnknownName { name: String, known: String },
    #[error(
        "the robot `{name}` exists, but its dimensions and masses are not public, so it cannot be simulated; \
         built in are {known}"
    )]
    #[zh("机器人 `{name}` 存在，但其尺寸和质量没有公开，因此不能仿真；内置的有 {known}")]
    UnsupportedModel { name: String, known: String },
    #[error("the robot model {path} cannot be read: {source}")]
    #[zh("无法读取机器人型号 {path}：{source}")]
    Unreadable {
        path: String,
        #[source]
        source: std::io::Error,
    },
    #[error("the URDF is {bytes} bytes long, {max} are allowed")]
    #[zh("URDF 有 {bytes} 字节，允许 {max} 字节")]
    TooLarge { bytes: usize, max: usize },
    #[error("the URDF nests elements more than {max} deep")]
    #[zh("URDF 的元素嵌套超过 {max} 层")]
    TooDeep { max: usize },
    #[error("the URDF is not well-formed XML near byte {offset}: {reason}")]
    #[zh("URDF 在第 {offset} 个字节附近不是合法的 XML：{reason}")]
    NotXml { offset: u64, reason: Text },
    #[error("the URDF cannot be understood: {0}")]
    #[zh("无法理解 URDF：{0}")]
    NotUrdf(#[from] urdf_rs::UrdfError),
    #[error("the URDF element <{element}> {reason}")]
    #[zh("URDF 元素 <{element}> {reason}")]
    Extension { element: String, reason: Text },
    #[error("the URDF has {found} revolute joints in a row ({names}), exactly six are needed")]
    #[zh("URDF 中串联的旋转关节有 {found} 个（{names}），需要恰好六个")]
    JointCount { found: usize, names: String },
    #[error("the URDF joint `{joint}` is {kind}; only revolute and fixed joints are supported")]
    #[zh("URDF 关节 `{joint}` 为 {kind}；只支持 revolute 和 fixed 关节")]
    JointKind { joint: String, kind: Text },
    #[error(
        "two revolute joints, `{first}` and `{second}`, move on the same link `{link}`: the arm must not branch"
    )]
    #[zh("两个旋转关节 `{first}` 和 `{second}` 都连在连杆 `{link}` 上：机械臂不能分叉")]
    Branch {
        link: String,
        first: String,
        second: String,
    },
    #[error("the URDF link `{link}` {reason}")]
    #[zh("URDF 连杆 `{link}` {reason}")]
    Tree { link: String, reason: Text },
    #[error("the URDF joint `{joint}` names the link `{link}`, which does not exist")]
    #[zh("URDF 关节 `{joint}` 指向不存在的连杆 `{link}`")]
    MissingLink { joint: String, link: String },
    #[error("the URDF names two {what} `{name}`")]
    #[zh("URDF 中有两个{what}名为 `{name}`")]
    Duplicate { what: Text, name: String },
    #[error("the URDF joint `{joint}` {reason}")]
    #[zh("URDF 关节 `{joint}` {reason}")]
    Joint { joint: String, reason: Text },
    #[error("the URDF link `{link}` has {reason}")]
    #[zh("URDF 连杆 `{link}` 有{reason}")]
    Inertial { link: String, reason: Text },
    #[error("a collision shape of the URDF link `{link}` {reason}")]
    #[zh("URDF 连杆 `{link}` 的碰撞形状{reason}")]
    Collision { link: String, reason: Text },
}

impl RobotModel {
    /// From the text of a URDF with six revolute joints in a row.
    ///
    /// The base frame is the link `base_link` if it is fixed to the root, else the root; the flange is the link
    /// `tool0`, else `flange`, else the link of the last joint. What the file leaves open is reported by
    /// [`Self::warnings`].
    ///
    /// # Errors
    /// See [`ModelError`]: every message names the joint or link at fault.
    pub fn from_urdf(text: &str) -> Result<Self, ModelError> {
        if text.len() > SIZE_MAX {
            return Err(ModelError::TooLarge {
                bytes: text.len(),
                max: SIZE_MAX,
            });
        }
        let extension = Extension::read(text)?;
        let robot = urdf_rs::read_from_string(text)?;
        let tree = Tree::new(&robot)?;
        let walk = tree.joint_chain()?;
        ModelBuilder::default().finish(&tree, &walk, &robot.name, &extension)
    }
}

/// The parts of the model as they come together.
#[derive(Default)]
struct ModelBuilder {
    bodies: [RigidBody; DOF],
    capsules: [Vec<Capsule>; LINKS],
    warnings: Vec<Text>,
}

impl ModelBuilder {
    fn finish(
        mut self,
        tree: &Tree<'_>,
        walk: &JointChain<'_>,
        name: &str,
        extension: &Extension,
    ) -> Result<RobotModel, ModelError> {
        let in_base = |wanted: &str| {
            walk.links
                .iter()
                .find(|(link, body, _)| *body == 0 && link.name == wanted)
                .map(|(_, _, pose)| pose.inverse())
        };
        let base_from_root = in_base("base_link").unwrap_or(Pose::IDENTITY);
        let on_last = |wanted: &str| {
            walk.links
                .iter()
                .find(|(link, body, _)| *body == DOF && link.name == wanted)
                .map(|(_, _, pose)| *pose)
        };
        let last_link = walk.joints[DOF - 1].child.link.as_str();
        let joint6_from_flange = on_last("tool0")
            .or_else(|| on_last("flange"))
            .or_else(|| on_last(last_link))
            .unwrap_or(Pose::IDENTITY);

        let mut parent_from_joint: [Pose; DOF] =
            core::array::from_fn(|joint| walk.parent_from_joint[joint]);
        parent_from_joint[0] = base_from_root * parent_from_joint[0];
        let chain = Chain {
            parent_from_joint,
            joint6_from_flange,
        };

        for (link, body, body_from_link) in &walk.links {
            let body_from_link = match body {
                0 => base_from_root * *body_from_link,
                _ => *body_from_link,
            };
            self.add_link(link, *body, &body_from_link)?;
        }
        let joint_names = core::array::from_fn(|joint| walk.joints[joint].name.clone());
        for (joint, body) in self.bodies.iter().enumerate() {
            if body.mass <= 0.0 {
                return Err(ModelError::Joint {
                    joint: walk.joints[joint].name.clone(),
                    reason: text!("moves nothing that has a mass", "没有带动任何有质量的物体"),
                });
            }
        }
        let never_collide = resolve_pairs(tree, walk, extension)?;
        let limits = self.limits(walk, extension)?;
        Ok(RobotModel {
            name: name.to_owned(),
            type_number: extension.type_number,
            rated_payload_kg: extension.rated_payload_kg,
            joint_names,
            ik: IkMethod::of(&chain),
            chain,
            limits,
            bodies: self.bodies,
            collision: CollisionModel::new(self.capsules, &never_collide),
            warnings: self.warnings,
            calibration: None,
        })
    }

    /// Merges a link's mass and shapes into the body it is fixed to; the base's mass does not matter.
    fn add_link(
        &mut self,
        link: &Link,
        body: usize,
        body_from_link: &Pose,
    ) -> Result<(), ModelError> {
        if let Some(joint) = body.checked_sub(1) {
            let part = inertial(link)?.expressed_in(body_from_link);
            self.bodies[joint] = self.bodies[joint].joined_with(&part);
        }
        for capsule in shapes::capsules(link, &mut self.warnings)? {
            self.capsules[body].push(capsule.expressed_in(body_from_link));
        }
        Ok(())
    }

    fn limits(
        &mut self,
        walk: &JointChain<'_>,
        extension: &Extension,
    ) -> Result<JointLimits, ModelError> {
        let mut limits = JointLimits {
            position_min: JointPositions::ZERO,
            position_max: JointPositions::ZERO,
            speed: JointSpeeds::ZERO,
            acceleration: JointAccelerations([DEFAULT_JOINT_ACCELERATION; DOF]),
            effort: JointTorques::ZERO,
        };
        for (index, joint) in walk.joints.iter().enumerate() {
            let limit = &joint.limit;
            let wrong = |reason: Text| ModelError::Joint {
                joint: joint.name.clone(),
                reason,
            };
            // `!(a < b)` instead of `a >= b`: NaN must not pass.
            if !(limit.lower.is_finite() && limit.upper.is_finite() && limit.lower < limit.upper) {
                return Err(wrong(text!(
                    "has position limits from {} to {} rad, it needs a lower one below an upper one",
                    "的位置范围为 {} 到 {} rad，下限应小于上限",
                    limit.lower,
                    limit.upper
                )));
            }
            for (what, value) in [("velocity", limit.velocity), ("effort", limit.effort)] {
                if !(value.is_finite() && value > 0.0) {
                    return Err(wrong(text!(
                        "has a {what} limit of {value}, it must be a positive number",
                        "的 {what} 限值为 {value}，必须是正数"
                    )));
                }
            }
            limits.position_min[index] = limit.lower;
            limits.position_max[index] = limit.upper;
            limits.speed[index] = limit.velocity;
            limits.effort[index] = limit.effort;
            let given = extension
                .joint_accelerations
                .iter()
                .find(|(name, _)| *name == joint.name);
            match given {
                Some((_, acceleration)) => limits.acceleration[index] = *acceleration,
                None => self.warnings.push(text!(
"joint `{}` has no acceleration limit, {DEFAULT_JOINT_ACCELERATION} rad/s² is taken",
"关节 `{}` 没有加速度限值，采用 {DEFAULT_JOINT_ACCELERATION} rad/s²",
                    joint.name
                )),
            }
        }
        for (name, _) in &extension.joint_accelerations {
            if !walk.joints.iter().any(|joint| joint.name == *name) {
                return Err(ModelError::Extension {
                    element: "joint_acceleration".to_owned(),
                    reason: text!(
                        "names the joint `{name}`, which is not one of the six",
                        "指向关节 `{name}`，它不是六个关节之一"
                    ),
                });
            }
        }
        Ok(limits)
    }
}

/// Link names of `<never_collide>` to body indices.
fn resolve_pairs(
    tree: &Tree<'_>,
    walk: &JointChain<'_>,
    extension: &Extension,
) -> Result<Vec<(usize, usize)>, ModelError> {
    let body_of = |name: &str| {
        walk.links
            .iter()
            .find(|(link, _, _)| link.name == name)
            .map(|(_, body, _)| *body)
            .ok_or_else(|| ModelError::Extension {
                element: "never_collide".to_owned(),
                reason: text!(
                    "names the link `{name}`, which does not exist; there are {}",
                    "指向不存在的连杆 `{name}`；现有 {}",
                    tree.links.keys().copied().collect::<Vec<_>>().join(", ")
                ),
            })
    };
    extension
        .never_collide
        .iter()
        .map(|(a, b)| Ok((body_of(a)?, body_of(b)?)))
        .collect()
}

/// A link's mass properties in its own frame; a link without them has no mass.
fn inertial(link: &Link) -> Result<RigidBody, ModelError> {
    let given = &link.inertial;
    let wrong = |reason: Text| ModelError::Inertial {
        link: link.name.clone(),
        reason,
    };
    let link_from_com = pose_of(&given.origin).ok_or_else(|| {
        wrong(text!(
            "an inertial origin with a number that is not finite",
            "惯性原点，其中有不是有限的数"
        ))
    })?;
    let mass = given.mass.value;
    if !(mass.is_finite() && mass >= 0.0) {
        return Err(wrong(text!(
            "a mass of {mass} kg, it must not be negative",
            "质量 {mass} kg，不能为负"
        )));
    }
    let i = &given.inertia;
    let inertia = Matrix3::new(
        i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz,
    );
    if !inertia.iter().all(|x| x.is_finite()) {
        return Err(wrong(text!(
            "an inertia with a number that is not finite",
            "惯量，其中有不是有限的数"
        )));
    }
    let moments = principal_moments(&inertia);
    if !is_physical(&moments) {
        return Err(wrong(text!(
            "an inertia that no rigid body has: its principal moments are {moments:?} kg m²",
            "不属于任何刚体的惯量：主惯量为 {moments:?} kg m²"
        )));
    }
    let about_com = RigidBody {
        mass,
        com: Vector3::zeros(),
        inertia,
    };
    Ok(about_com.expressed_in(&link_from_com))
}
