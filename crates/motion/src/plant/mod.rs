//! The arm that follows the setpoints: what is, as opposed to what is wanted.
//!
//! Owns the difference between target and actual, and what is true of the arm though the controller does not know it
//! (`real_arm`). The rigid-body engine and its types stay inside this folder.

mod actual;
mod ideal;
mod rapier;
mod real_arm;
mod rigid;
mod servo;

use kinematics::{
    Dynamics, Frames, JointPositions, JointSpeeds, JointTorques, Payload, Pose, RobotModel, Wrench,
};
use nalgebra::Vector3;

use crate::collision::wrench_to_torques;
use crate::config::{ConfigError, PlantKind};
use crate::contact::ContactModel;
use crate::setpoint::LimitedSetpoint;
pub(crate) use actual::ActualArm;
pub use ideal::IdealPlant;
use real_arm::PlantDynamics;
pub use real_arm::{Drivetrain, PlantParameters};
pub use rigid::RigidPlant;

/// What the joints of the arm do at the end of a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmState {
    /// Positions, rad.
    pub q: JointPositions,
    /// Speeds, rad/s.
    pub qd: JointSpeeds,
    /// What the joints carry, Nm: the drives' torque, or the brakes' when they are engaged.
    pub torque: JointTorques,
    /// The mean of `torque` over the cycle, Nm.
    pub mean_torque: JointTorques,
    /// What obstacles do to the tool, mean over the cycle: base axes, about the TCP.
    pub contact: Wrench,
}

/// What pushes the tool from outside during a cycle.
#[derive(Clone, Copy, Debug)]
pub struct ToolWrench {
    /// Base axes, about the TCP, which it stays with.
    pub wrench: Wrench,
    /// Where the TCP is. Obstacles touch there too when the tool has no shape.
    pub flange_from_tcp: Pose,
    /// Joint torques of what pushes the links, Nm.
    pub link_torques: JointTorques,
}

impl ToolWrench {
    fn is_nothing(&self) -> bool {
        self.wrench.is_zero() && self.link_torques == JointTorques::ZERO
    }

    /// The TCP in the base frame, m, and the joint torques that all of it makes, Nm.
    fn at(&self, frames: &Frames) -> (Vector3<f64>, JointTorques) {
        let tcp = frames.base_from_flange * self.flange_from_tcp;
        let torque = wrench_to_torques(&self.wrench, frames, &tcp);
        let links = &self.link_torques;
        (
            tcp.translation,
            JointTorques(core::array::from_fn(|j| torque[j] + links[j])),
        )
    }
}

impl Default for ToolWrench {
    fn default() -> Self {
        Self {
            wrench: Wrench::default(),
            flange_from_tcp: Pose::IDENTITY,
            link_torques: JointTorques::ZERO,
        }
    }
}

impl ArmState {
    const RESTING: Self = Self {
        q: JointPositions::ZERO,
        qd: JointSpeeds::ZERO,
        torque: JointTorques::ZERO,
        mean_torque: JointTorques::ZERO,
        contact: Wrench {
            force: Vector3::new(0.0, 0.0, 0.0),
            moment: Vector3::new(0.0, 0.0, 0.0),
        },
    };

    /// True when no number is NaN or infinite.
    pub fn is_finite(&self) -> bool {
        self.q.is_finite() && self.qd.is_finite() && self.torque.is_finite()
    }
}

/// The arm.
pub enum Plant {
    /// Actual is target.
    Ideal(Box<IdealPlant>),
    /// Rigid bodies under a servo.
    Rigid(Box<RigidPlant>),
}

impl Plant {
    /// An arm standing at `q`. `believed` is the controller's model of it, `truth` what differs from that; `gravity` is
    /// the free-fall acceleration in the base frame, m/s².
    ///
    /// # Errors
    /// [`ConfigError::Plant`] when its masses cannot be simulated.
    pub fn new(
        kind: PlantKind,
        model: &RobotModel,
        (believed, truth): (&Dynamics, PlantParameters),
        gravity: &Vector3<f64>,
        q: &JointPositions,
    ) -> Result<Self, ConfigError> {
        let arm = PlantDynamics::new(model, truth, believed, gravity);
        Ok(match kind {
            PlantKind::Ideal => Self::Ideal(Box::new(IdealPlant::new(arm, *q))),
            PlantKind::Rigid => Self::Rigid(Box::new(RigidPlant::new(model, arm, q)?)),
            PlantKind::Rapier => {
                Self::Rigid(Box::new(RigidPlant::in_rapier(model, arm, gravity, q)?))
            }
        })
    }

    /// True of the arm that is where it should be.
    pub const fn is_ideal(&self) -> bool {
        matches!(self, Self::Ideal(_))
    }

    /// Puts the arm at rest at `q`.
    pub fn reset(&mut self, q: &JointPositions) {
        match self {
            Self::Ideal(plant) => plant.reset(q),
            Self::Rigid(plant) => plant.reset(q),
        }
    }

    /// What pushes the tool from now on.
    pub fn set_tool_wrench(&mut self, push: &ToolWrench) {
        match self {
            Self::Ideal(plant) => plant.push = *push,
            Self::Rigid(plant) => plant.set_tool_wrench(push),
        }
    }

    /// The controller was told another payload or gravity: its model is `believed`. Gravity is what it is told
    /// (free-fall acceleration in the base frame, m/s²), the payload where nothing else hangs there.
    pub fn set_controller_model(&mut self, believed: &Dynamics, gravity: &Vector3<f64>) {
        match self {
            Self::Ideal(plant) => plant.arm.set_controller_model(believed, gravity),
            Self::Rigid(plant) => plant.set_controller_model(believed, gravity),
        }
    }

    /// What hangs on the flange has changed to `payload`, which counts where the truth has a payload of its own.
    pub fn set_actual_payload(&mut self, payload: &Payload) {
        match self {
            Self::Ideal(plant) => plant.arm.set_actual_payload(payload),
            Self::Rigid(plant) => plant.set_actual_payload(payload),
        }
    }

    /// One cycle of `step` seconds under servo control towards `target`, among what `contacts` holds. The controller's
    /// model, and the torques that it expects of the target.
    pub(crate) fn step_to_target(
        &mut self,
        target: &LimitedSetpoint,
        (believed, expected): (&Dynamics, &JointTorques),
        contacts: &mut ContactModel,
        step: f64,
    ) -> ArmState {
        match self {
            Self::Ideal(plant) => plant.step_to_target(target, expected, contacts),
            Self::Rigid(plant) => plant.step_to_target(target, believed, contacts, step),
        }
    }

    /// Forgets the target that the arm was on the way to: from now on that is `q`.
    pub fn retarget(&mut self, q: &JointPositions) {
        match self {
            Self::Ideal(_) => {}
            Self::Rigid(plant) => plant.retarget(q),
        }
    }

    /// One cycle with the brakes engaged: the arm stands where it is.
    pub(crate) fn step_with_brakes(
        &mut self,
        believed: &Dynamics,
        contacts: &mut ContactModel,
    ) -> ArmState {
        match self {
            Self::Ideal(plant) => plant.step_with_brakes(contacts),
            Self::Rigid(plant) => plant.step_with_brakes(believed, contacts),
        }
    }
}
