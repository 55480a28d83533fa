//! The arm as it is: what really hangs on the flange, and what the drives have to overcome besides the links.
//!
//! Owns the truth that the controller does not know. It meets the controller only in what the plant's joints do and
//! carry and in what the force sensor reads. Without a truth of its own the arm is what the controller believes.

use core::cell::OnceCell;

use kinematics::chain::Posture;
use kinematics::payload::RigidBody;
use kinematics::{
    Chain, DOF, Dynamics, JointAccelerations, JointPositions, JointSpeeds, JointTorques, Payload,
    RobotModel,
};
use nalgebra::{Matrix6, Vector3, Vector6};

/// `[arm]` of the cell: losses and rotors of the drives, seen at the joints.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Drivetrain {
    /// Dry friction, Nm: holds up to this, and opposes turning with it.
    pub coulomb: JointTorques,
    /// Friction that grows with the speed, Nm s/rad.
    pub viscous: [f64; DOF],
    /// Inertia of the rotor about the joint axis, kg m²: the gear ratio squared times its own.
    pub rotor_inertia: [f64; DOF],
}

/// What is true of the arm whatever the controller believes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlantParameters {
    /// What hangs on the flange; `None`: what the controller was told.
    pub payload: Option<Payload>,
    /// What the drives have to overcome.
    pub drivetrain: Drivetrain,
}

/// Where the arm is at the beginning of a servo step: what servo, bodies and contacts work out from that, worked out
/// once.
#[derive(Debug)]
pub(super) struct StepPosture {
    pub(super) posture: Posture,
    /// Mass matrix of the links without rotors, kg m², once somebody has asked for it.
    links_mass: OnceCell<Matrix6<f64>>,
}

impl StepPosture {
    pub(super) const fn new(posture: Posture) -> Self {
        Self {
            posture,
            links_mass: OnceCell::new(),
        }
    }
}

/// The masses and losses that a plant moves.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlantDynamics {
    chain: Chain,
    links: [RigidBody; DOF],
    parameters: PlantParameters,
    /// `parameters.payload` with what the grippers hold.
    actual_payload: Option<Payload>,
    gravity: Vector3<f64>,
    dynamics: Dynamics,
}

impl PlantDynamics {
    /// `believed` is the controller's model, `gravity` the free-fall acceleration in the base frame, m/s².
    pub(super) fn new(
        model: &RobotModel,
        truth: PlantParameters,
        believed: &Dynamics,
        gravity: &Vector3<f64>,
    ) -> Self {
        let mut arm = Self {
            chain: *model.chain(),
            links: *model.link_bodies(),
            parameters: truth,
            actual_payload: truth.payload,
            gravity: *gravity,
            dynamics: *believed,
        };
        arm.set_controller_model(believed, gravity);
        arm
    }

    /// The controller was told another payload or gravity. Gravity is what it is told, the payload only where no other
    /// hangs there.
    pub(super) fn set_controller_model(&mut self, believed: &Dynamics, gravity: &Vector3<f64>) {
        self.gravity = *gravity;
        self.dynamics = match &self.actual_payload {
            None => *believed,
            Some(payload) => Dynamics::new(self.chain, self.links, payload, *gravity),
        };
    }

    /// The true payload with what the grippers hold; only where a payload of its own hangs on the flange.
    pub(super) fn set_actual_payload(&mut self, payload: &Payload) {
        if self.actual_payload.is_some() {
            self.actual_payload = Some(*payload);
            self.dynamics = Dynamics::new(self.chain, self.links, payload, self.gravity);
        }
    }

    /// Free-fall acceleration in the base frame, m/s².
    pub(super) const fn gravity(&self) -> &Vector3<f64> {
        &self.gravity
    }

    /// The rigid bodies.
    pub(super) const fn dynamics(&self) -> &Dynamics {
        &self.dynamics
    }

    /// True where the controller's model of masses and rotors is right.
    pub(super) fn matches_controller_model(&self) -> bool {
        self.parameters.payload.is_none() && self.parameters.drivetrain.rotor_inertia == [0.0; DOF]
    }

    /// True without friction and rotors.
    pub(super) fn is_without_losses(&self) -> bool {
        self.parameters.drivetrain == Drivetrain::default()
    }

    /// Dry friction, Nm, if there is any.
    pub(super) fn coulomb(&self) -> Option<&JointTorques> {
        let coulomb = &self.parameters.drivetrain.coulomb;
        (*coulomb != JointTorques::ZERO).then_some(coulomb)
    }

    /// Mass matrix with rotors, kg m².
    pub(super) fn mass_matrix(&self, at: &StepPosture) -> Matrix6<f64> {
        self.with_rotors(self.links_mass(at), &[0.0; DOF])
    }

    /// Mass matrix for a step of `step` seconds at whose end viscous friction is taken: whatever its size, the step is
    /// stable.
    pub(super) fn implicit_mass_matrix(&self, at: &StepPosture, step: f64) -> Matrix6<f64> {
        let drag = self.parameters.drivetrain.viscous.map(|drag| drag * step);
        self.with_rotors(self.links_mass(at), &drag)
    }

    fn links_mass(&self, at: &StepPosture) -> Matrix6<f64> {
        let mass = at
            .links_mass
            .get_or_init(|| self.dynamics.mass_matrix_at(&at.posture));
        *mass
    }

    fn with_rotors(&self, mut mass: Matrix6<f64>, more: &[f64; DOF]) -> Matrix6<f64> {
        for joint in 0..DOF {
            mass[(joint, joint)] += self.parameters.drivetrain.rotor_inertia[joint] + more[joint];
        }
        mass
    }

    /// Torques that gravity, the links' motion and viscous friction take up at `qd`, Nm.
    pub(super) fn bias(&self, at: &StepPosture, qd: &JointSpeeds) -> Vector6<f64> {
        let viscous = &self.parameters.drivetrain.viscous;
        let drag = Vector6::from_fn(|joint, _| viscous[joint] * qd[joint]);
        let links = self.dynamics.bias_torques_at(&at.posture, qd);
        links.to_vector() + drag
    }

    /// Joint accelerations over a step of `step` seconds under `torque`, dry friction apart, rad/s².
    pub(super) fn accelerations(
        &self,
        at: &StepPosture,
        qd: &JointSpeeds,
        torque: &JointTorques,
        step: f64,
    ) -> JointAccelerations {
        let drivetrain = &self.parameters.drivetrain;
        let (drag, rotor) = (&drivetrain.viscous, &drivetrain.rotor_inertia);
        let left = JointTorques(core::array::from_fn(|j| torque[j] - drag[j] * qd[j]));
        let armature = core::array::from_fn(|j| rotor[j] + step * drag[j]);
        self.dynamics
            .forward_dynamics_at(&at.posture, qd, &left, &armature)
    }

    /// What the drives give where the arm moves just so, Nm; the controller thinks that its links take `believed`.
    pub(super) fn drive_torques(
        &self,
        q: &JointPositions,
        qd: &JointSpeeds,
        qdd: &JointAccelerations,
        believed: &JointTorques,
    ) -> JointTorques {
        let Drivetrain {
            coulomb,
            viscous,
            rotor_inertia,
        } = &self.parameters.drivetrain;
        let links = match &self.parameters.payload {
            None => *believed,
            Some(_) => self.dynamics.inverse_dynamics(q, qd, qdd),
        };
        JointTorques(core::array::from_fn(|j| {
            let dry = if qd[j] == 0.0 {
                0.0
            } else {
                coulomb[j].copysign(qd[j])
            };
            links[j] + rotor_inertia[j] * qdd[j] + viscous[j] * qd[j] + dry
        }))
    }
}
