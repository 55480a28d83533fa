//! What moves with the arm: capsules of links, the tool, held parts.

use kinematics::collision::{LINKS, LinkIndex};
use kinematics::{Capsule, DOF, Frames, Pose, RobotModel};
use messages::Text;
use nalgebra::Vector3;

use crate::shape::PlacedShape;
use crate::solid::Solid;

/// What the links are called in results, the fixed base first.
pub const LINK_NAMES: [&str; LINKS] = [
    "base",
    "shoulder",
    "upper_arm",
    "forearm",
    "wrist_1",
    "wrist_2",
    "wrist_3",
];

/// What a link is called in sentences.
pub(super) fn link_text(link: usize) -> Text {
    const CHINESE: [&str; LINKS] = ["基座", "肩部", "上臂", "前臂", "手腕 1", "手腕 2", "手腕 3"];
    Text::fixed(LINK_NAMES[link], CHINESE[link])
}

/// Whose solid a body is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BodyOwner {
    /// A link, 0 for the base.
    Link(LinkIndex),
    /// The tool.
    Tool,
    /// An obstacle that hangs on the flange, by its number.
    Held(usize),
}

/// A convex solid that moves with a link.
#[derive(Clone, Debug)]
pub(super) struct Body {
    pub(super) owner: BodyOwner,
    /// The link that it moves with, 0 for the base.
    pub(super) link: LinkIndex,
    geometry: Geometry,
    /// How far from the axis of each joint any of its points can be at most, m; 0 for joints that do not move it.
    pub(super) levers: [f64; DOF],
}

#[derive(Clone, Debug)]
enum Geometry {
    /// In the frame of the link.
    Capsule(Capsule),
    /// In the frame of the last link, and ends at the flange.
    FlangeCapsule(Capsule),
    /// In the flange frame.
    Flange(PlacedShape),
}

impl Body {
    /// The capsules of all links.
    pub(super) fn of_links(model: &RobotModel) -> Vec<Self> {
        let mut bodies = Vec::new();
        for link in 0..LINKS {
            for capsule in model.collision().capsules(link) {
                let reach = capsule.p0.norm().max(capsule.p1.norm()) + capsule.radius;
                let geometry = match link == DOF {
                    true => Geometry::FlangeCapsule(*capsule),
                    false => Geometry::Capsule(*capsule),
                };
                bodies.push(Self {
                    owner: BodyOwner::Link(link),
                    link,
                    geometry,
                    levers: levers(model, link, reach),
                });
            }
        }
        bodies
    }

    /// A shape in the flange frame.
    pub(super) fn on_flange(owner: BodyOwner, shape: PlacedShape, model: &RobotModel) -> Self {
        let in_flange = shape.pose.translation.norm() + shape.shape.bounding_radius();
        let reach = model.chain().joint6_from_flange.translation.norm() + in_flange;
        Self {
            owner,
            link: DOF,
            geometry: Geometry::Flange(shape),
            levers: levers(model, DOF, reach),
        }
    }

    /// The body in the base frame.
    pub(super) fn solid(&self, frames: &Frames) -> Solid {
        let base_from_link = match self.link {
            0 => &Pose::IDENTITY,
            link => &frames.base_from_joint[link - 1],
        };
        let flange = &frames.base_from_flange;
        match &self.geometry {
            Geometry::Capsule(capsule) => Solid::of_capsule(&capsule.expressed_in(base_from_link)),
            Geometry::FlangeCapsule(capsule) => Solid::of_cut_capsule(
                &capsule.expressed_in(base_from_link),
                flange.translation,
                flange.rotate(Vector3::z()),
            ),
            Geometry::Flange(shape) => Solid::of_shape(shape, flange),
        }
    }
}

/// The longest levers of a body that reaches so far from the frame of its link, whatever the joints are.
fn levers(model: &RobotModel, link: LinkIndex, reach: f64) -> [f64; DOF] {
    let mut levers = [0.0; DOF];
    let mut way = reach;
    for joint in (0..link).rev() {
        levers[joint] = way;
        way += model.chain().parent_from_joint[joint].translation.norm();
    }
    levers
}
