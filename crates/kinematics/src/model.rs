//! One arm: geometry, limits, masses, collision capsules, and the names it goes by.
//!
//! Owns the data and the calls that need several parts of it. Where the data comes from: [`crate::urdf`] reads files,
//! [`crate::catalogue`] holds the CS arms that are built in.

use crate::calibration::Calibration;
use crate::chain::{Chain, Frames};
use crate::collision::CollisionModel;
use crate::dh::DhTable;
use crate::dynamics::Dynamics;
use crate::ik::{IkMethod, IkSolutions};
use crate::joint::{DOF, JointAccelerations, JointPositions, JointSpeeds, JointTorques};
use crate::payload::{Payload, RigidBody};
use crate::pose::Pose;
use messages::Text;
use nalgebra::{Matrix6, Vector3};

/// What each joint can do, base joint first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimits {
    /// Smallest positions, rad.
    pub position_min: JointPositions,
    /// Largest positions, rad.
    pub position_max: JointPositions,
    /// Largest speeds either way, rad/s.
    pub speed: JointSpeeds,
    /// Largest accelerations either way, rad/s². No vendor figure exists; see `robots/README.md`.
    pub acceleration: JointAccelerations,
    /// Largest torques either way, Nm. Nominal: several arms hold their rated payload only just inside them.
    pub effort: JointTorques,
}

impl JointLimits {
    /// The first joint (0 to 5) whose position lies outside its limits, with that position; NaN is outside.
    pub fn position_violation(&self, q: &JointPositions) -> Option<(usize, f64)> {
        (0..DOF)
            .map(|joint| (joint, q[joint]))
            .find(|&(joint, x)| !(self.position_min[joint]..=self.position_max[joint]).contains(&x))
    }

    /// Whether all six positions lie inside their limits.
    pub fn contains(&self, q: &JointPositions) -> bool {
        self.position_violation(q).is_none()
    }
}

/// A six-axis arm. Immutable; the tool (TCP, payload) is an argument where it matters.
#[derive(Clone, Debug)]
pub struct RobotModel {
    pub(crate) name: String,
    pub(crate) type_number: Option<u32>,
    pub(crate) rated_payload_kg: Option<f64>,
    pub(crate) joint_names: [String; DOF],
    pub(crate) chain: Chain,
    pub(crate) ik: IkMethod,
    pub(crate) limits: JointLimits,
    pub(crate) bodies: [RigidBody; DOF],
    pub(crate) collision: CollisionModel,
    pub(crate) warnings: Vec<Text>,
    pub(crate) calibration: Option<Box<Calibration>>,
}

impl RobotModel {
    /// The model's name, `cs66` for instance.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The vendor's robot type number, 6206 for the CS66; `None` for a URDF that names none.
    pub fn type_number(&self) -> Option<u32> {
        self.type_number
    }

    /// The payload the arm is rated for, kg; `None` for a URDF that names none.
    pub fn rated_payload_kg(&self) -> Option<f64> {
        self.rated_payload_kg
    }

    /// Names of the joints in the URDF, base joint first.
    pub fn joint_names(&self) -> &[String; DOF] {
        &self.joint_names
    }

    /// Joint limits.
    pub fn limits(&self) -> &JointLimits {
        &self.limits
    }

    /// This arm with other joint limits, for instance those that `[limits]` of a cell file sets.
    pub fn with_limits(self, limits: JointLimits) -> Self {
        Self { limits, ..self }
    }

    /// The geometry of the joints.
    pub fn chain(&self) -> &Chain {
        &self.chain
    }

    /// How the inverse kinematics is computed for this arm.
    pub fn ik_method(&self) -> &IkMethod {
        &self.ik
    }

    /// Mass properties of the six moving links in their joint frames, no payload.
    pub fn link_bodies(&self) -> &[RigidBody; DOF] {
        &self.bodies
    }

    /// Collision capsules and the link pairs to test.
    pub fn collision(&self) -> &CollisionModel {
        &self.collision
    }

    /// What the loader could not use, one sentence each: meshes, missing accelerations. Empty for the built-in arms.
    pub fn warnings(&self) -> &[Text] {
        &self.warnings
    }

    /// The standard Denavit-Hartenberg table, `None` if the arm is not exactly of the CS arms' shape.
    pub fn dh(&self) -> Option<DhTable> {
        DhTable::of(&self.chain, &self.ik)
    }

    /// The Denavit-Hartenberg table in the layout in which a controller sends it: the measured one of a calibrated arm,
    /// else the model's; `None` if the arm is not exactly of the CS arms' shape.
    pub fn modified_dh(&self) -> Option<DhTable> {
        match &self.calibration {
            Some(calibration) => Some(*calibration.modified_dh()),
            None => self.dh().map(|table| table.modified()),
        }
    }

    /// What was measured of this arm; `None` for one that is as its model.
    pub fn calibration(&self) -> Option<&Calibration> {
        self.calibration.as_deref()
    }

    /// All joint frames and the flange at `q`: the start of Jacobians and twists, see [`Frames`].
    pub fn forward(&self, q: &JointPositions) -> Frames {
        self.chain.forward(q)
    }

    /// Pose of the tool flange in the base frame.
    pub fn flange_pose(&self, q: &JointPositions) -> Pose {
        self.chain.flange_pose(q)
    }

    /// Pose of the TCP in the base frame (manual 3.2.4).
    pub fn tcp_pose(&self, q: &JointPositions, flange_from_tcp: &Pose) -> Pose {
        self.flange_pose(q) * *flange_from_tcp
    }

    /// Pose and geometric Jacobian of the TCP in one pass: twist of the TCP in base axes = J qd, linear rows first.
    pub fn tcp_pose_and_jacobian(
        &self,
        q: &JointPositions,
        flange_from_tcp: &Pose,
    ) -> (Pose, Matrix6<f64>) {
        let frames = self.forward(q);
        let pose = frames.base_from_flange * *flange_from_tcp;
        let jacobian = frames.jacobian(pose.translation);
        (pose, jacobian)
    }

    /// Every inverse solution for a TCP pose, each joint in [-pi, pi), in the order of the manual (3.2.3). Joint limits
    /// are not looked at. Where the wrist is singular, joint 6 is 0 (our choice).
    pub fn inverse_all(&self, base_from_tcp: &Pose, flange_from_tcp: &Pose) -> IkSolutions {
        let base_from_flange = *base_from_tcp * flange_from_tcp.inverse();
        self.ik.all(&self.chain, &base_from_flange, 0.0)
    }

    /// The inverse solution nearest to `near` inside the joint limits, whole turns included (manual 3.2.1); `None` if
    /// the pose is out of reach.
    pub fn inverse_nearest(
        &self,
        base_from_tcp: &Pose,
        flange_from_tcp: &Pose,
        near: &JointPositions,
    ) -> Option<JointPositions> {
        let base_from_flange = *base_from_tcp * flange_from_tcp.inverse();
        self.ik
            .nearest(&self.chain, &self.limits, &base_from_flange, near)
    }

    /// The inverse solution for the next place of a path that was at `near`: as [`Self::inverse_nearest`], in some 10
    /// µs at most for any arm. For an arm without closed form other branches are not searched; a path cannot jump to
    /// one.
    pub fn inverse_continuous(
        &self,
        base_from_tcp: &Pose,
        flange_from_tcp: &Pose,
        near: &JointPositions,
    ) -> Option<JointPositions> {
        let base_from_flange = *base_from_tcp * flange_from_tcp.inverse();
        self.ik
            .nearest_continuous(&self.chain, &self.limits, &base_from_flange, near)
    }

    /// The arm's dynamics with a payload, and the free-fall acceleration in the base frame in m/s²
    /// ([`crate::dynamics::GRAVITY_UPRIGHT`] for an upright base).
    pub fn dynamics(&self, payload: &Payload, gravity: Vector3<f64>) -> Dynamics {
        Dynamics::new(self.chain, self.bodies, payload, gravity)
    }
}
