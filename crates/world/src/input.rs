//! What crosses the border between world and control cycle. Everything is `Copy` and of fixed size.

use crate::levels::{Levels, PointSet};
use kinematics::{DOF, Pose, RigidBody, Wrench};

/// Grippers at most.
pub const MAX_GRIPPERS: usize = 8;

/// What the cycle gives to the world: the arm at its end, and the outputs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Input {
    /// The six joint frames in the base frame.
    pub base_from_joint: [Pose; DOF],
    /// The flange in the base frame.
    pub base_from_flange: Pose,
    /// All outputs.
    pub outputs: Levels,
    /// What obstacles do to the part in each gripper, as the arm's contact law finds it: about the origin of the flange, base axes.
    pub held_contacts: [Wrench; MAX_GRIPPERS],
}

/// What the world gives to the next cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Output {
    /// Levels of the inputs that the world drives ([`World::driven_inputs`](crate::World::driven_inputs)); the others are 0.
    pub inputs: Levels,
    /// Inputs that keep their value, whoever drives them.
    pub stuck: PointSet,
    /// Inputs that are false or 0, whoever drives them.
    pub open: PointSet,
    /// What parts and moved obstacles do to tool, grippers and held parts, and what still bears a part that is being lifted: about the
    /// origin of the flange, base axes.
    pub tool_wrench: Wrench,
    /// What they do to the links: about the origin of each joint frame, base axes.
    pub link_wrenches: [Wrench; DOF],
    /// All held parts as one body in the flange frame: what acts on the flange as a payload does.
    pub held_body: RigidBody,
    /// The part in each gripper, with the number of its template ([`World::part_shape`](crate::World::part_shape)).
    pub held_parts: [Option<HeldPart>; MAX_GRIPPERS],
    /// Way of the conveyors on encoders 0 and 1 since the start, m or rad.
    pub encoder_travel: [f64; 2],
}

/// A part in a gripper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldPart {
    /// Number of the template, for its shape.
    pub template: u16,
    /// Where it is in the flange frame.
    pub flange_from_part: Pose,
}
