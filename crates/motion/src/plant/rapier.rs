//! The bodies of the rigid arm in the rapier engine: a multibody of the six links with what hangs on the flange.
//!
//! Owns the engine and every conversion between its vectors (glam) and ours (nalgebra). Torques are found with our own
//! inverse dynamics, the motion with the engine's, so an error in either shows as a tracking error: this is the judge
//! of the plant that integrates our own equations. rapier allocates inside its step; no other part of the cycle does.

use kinematics::payload::RigidBody;
use kinematics::{DOF, Dynamics, Frames, JointPositions, JointSpeeds, JointTorques, RobotModel};
use messages::text;
use nalgebra::Vector3;
use rapier3d_f64::dynamics::{
    GenericJointBuilder, JointAxesMask, MassProperties, MultibodyJointHandle, RigidBodyBuilder,
    RigidBodyHandle,
};
use rapier3d_f64::math::{Matrix, Pose as RapierPose, Rotation, Vector};
use rapier3d_f64::pipeline::PhysicsWorld;

use super::ToolWrench;
use crate::config::ConfigError;
use crate::contact::ContactList;
use crate::contact::law::ContactForces;

/// The arm in the engine.
pub(super) struct RapierBodies {
    world: PhysicsWorld,
    links: [RigidBodyHandle; DOF],
    last_joint: MultibodyJointHandle,
}

impl RapierBodies {
    /// The arm with all joints at zero; `gravity` is the free-fall acceleration in the base frame, m/s².
    ///
    /// # Errors
    /// [`ConfigError::Plant`] when the engine cannot join the links.
    pub(super) fn new(
        model: &RobotModel,
        dynamics: &Dynamics,
        gravity: &Vector3<f64>,
    ) -> Result<Self, ConfigError> {
        let mut world = PhysicsWorld::new();
        world.gravity = vector(gravity);
        world.integration_parameters.max_ccd_substeps = 0;
        world.integration_parameters.num_solver_iterations = 1;
        let base = world.insert_body(RigidBodyBuilder::fixed());
        let mut parent = base;
        let mut joints = Vec::with_capacity(DOF);
        let links = core::array::from_fn(|i| {
            let body = RigidBodyBuilder::dynamic()
                .can_sleep(false)
                .additional_mass_properties(mass_properties(&dynamics.bodies()[i]));
            let link = world.insert_body(body);
            // The engine turns about x, our joints turn about z of the joint frame.
            let x_is_z = Rotation::from_rotation_y(-core::f64::consts::FRAC_PI_2);
            let joint = GenericJointBuilder::new(JointAxesMask::LOCKED_REVOLUTE_AXES)
                .local_frame1(pose(&model.chain().parent_from_joint[i]) * x_is_z)
                .local_frame2(RapierPose::from_rotation(x_is_z))
                .contacts_enabled(false)
                .build();
            joints.push(world.insert_multibody_joint(parent, link, joint));
            parent = link;
            link
        });
        let Some(Some(last_joint)) = joints.last().copied() else {
            return Err(ConfigError::Plant {
                what: text!(
                    "the physics engine refused a joint",
                    "物理引擎拒绝了一个关节"
                ),
            });
        };
        let mut bodies = Self {
            world,
            links,
            last_joint,
        };
        // A step of no time lets the engine see that the base is fixed: until then the multibody floats.
        bodies.settle();
        if let Some((multibody, _)) = bodies.world.multibody_joints.get_mut(last_joint) {
            // The engine damps joints unless told otherwise.
            multibody.damping_mut().fill(0.0);
        }
        Ok(bodies)
    }

    /// Puts the arm at rest at `q`.
    pub(super) fn reset(&mut self, q: &JointPositions) {
        let (from, _) = self.read();
        if let Some((multibody, _)) = self.world.multibody_joints.get_mut(self.last_joint) {
            let way: [f64; DOF] = core::array::from_fn(|joint| q[joint] - from[joint]);
            if way.iter().all(|x| x.is_finite()) {
                multibody.apply_displacements(&way);
            }
        }
        self.halt();
        // The links follow the joints in a step only; until then a force would act where they were.
        self.settle();
    }

    /// Takes the speed away.
    pub(super) fn halt(&mut self) {
        if let Some((multibody, _)) = self.world.multibody_joints.get_mut(self.last_joint) {
            multibody.generalized_velocity_mut().fill(0.0);
        }
    }

    fn settle(&mut self) {
        for link in &self.links {
            if let Some(link) = self.world.bodies.get_mut(*link) {
                link.reset_torques(false);
                link.reset_forces(false);
            }
        }
        self.world.integration_parameters.dt = 0.0;
        self.world.step();
    }

    /// Gives the bodies other masses, or gravity another direction.
    pub(super) fn set_masses(&mut self, dynamics: &Dynamics, gravity: &Vector3<f64>) {
        self.world.gravity = vector(gravity);
        for (link, body) in self.links.iter().zip(dynamics.bodies()) {
            if let Some(link) = self.world.bodies.get_mut(*link) {
                link.set_additional_mass_properties(mass_properties(body), true);
            }
        }
    }

    /// A step of `step` seconds under the drives' `torque`, the hand and what the arm touches. `frames` say where it
    /// is.
    pub(super) fn step(
        &mut self,
        torque: &JointTorques,
        (push, tcp): (&ToolWrench, Vector3<f64>),
        (touches, forces): (&ContactList, &ContactForces),
        frames: &Frames,
        step: f64,
    ) -> (JointPositions, JointSpeeds) {
        self.apply(torque, frames);
        if let Some(last) = self.world.bodies.get_mut(self.links[DOF - 1]) {
            let wrench = &push.wrench;
            last.add_force_at_point(vector(&wrench.force), vector(&tcp), false);
            last.add_torque(vector(&wrench.moment), false);
        }
        for (touch, force) in touches.as_slice().iter().zip(&forces.forces) {
            if let Some(link) = self.world.bodies.get_mut(self.links[touch.part.link()]) {
                link.add_force_at_point(vector(force), vector(&touch.place.point), false);
            }
        }
        self.world.integration_parameters.dt = step;
        self.world.step();
        self.read()
    }

    /// The engine has no input for joint torques: each goes to its link and, reversed, to the one before.
    fn apply(&mut self, torque: &JointTorques, frames: &Frames) {
        let about: [Vector3<f64>; DOF] = core::array::from_fn(|joint| {
            frames.base_from_joint[joint].rotation * Vector3::z() * torque[joint]
        });
        for (i, link) in self.links.iter().enumerate() {
            let passed_on = about.get(i + 1).copied().unwrap_or_default();
            if let Some(link) = self.world.bodies.get_mut(*link) {
                link.reset_torques(false);
                link.reset_forces(false);
                link.add_torque(vector(&(about[i] - passed_on)), false);
            }
        }
    }

    /// Positions and speeds.
    fn read(&self) -> (JointPositions, JointSpeeds) {
        let (mut q, mut qd) = (JointPositions::ZERO, JointSpeeds::ZERO);
        if let Some((multibody, _)) = self.world.multibody_joints.get(self.last_joint) {
            // The first link is the fixed base without a degree of freedom.
            for (joint, link) in multibody.links().skip(1).take(DOF).enumerate() {
                q[joint] = link.joint().coords()[3];
            }
            let speeds = multibody.generalized_velocity();
            for (joint, speed) in speeds.iter().take(DOF).enumerate() {
                qd[joint] = *speed;
            }
        }
        (q, qd)
    }
}

fn vector(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

fn pose(p: &kinematics::Pose) -> RapierPose {
    let q = nalgebra::UnitQuaternion::from_rotation_matrix(&p.rotation);
    RapierPose {
        translation: vector(&p.translation),
        rotation: Rotation::from_xyzw(q.i, q.j, q.k, q.w),
    }
}

fn mass_properties(body: &RigidBody) -> MassProperties {
    let columns: [f64; 9] = core::array::from_fn(|k| body.inertia[(k % 3, k / 3)]);
    MassProperties::with_inertia_matrix(
        vector(&body.com),
        body.mass,
        Matrix::from_cols_array(&columns),
    )
}
