//! The rigid arm: a rapier multibody of the six links with the payload, driven by the servo.
//!
//! Owns the engine and every conversion between its vectors (glam) and ours (nalgebra). Torques are found with our own
//! inverse dynamics, the motion with the engine's, so an error in either shows as a tracking error. rapier allocates
//! inside its step; this is the one place of the cycle where that happens.

use kinematics::chain::Chain;
use kinematics::payload::RigidBody;
use kinematics::{
    DOF, Dynamics, Frames, JointPositions, JointSpeeds, JointTorques, RobotModel, Wrench,
};
use nalgebra::{Vector3, Vector6};
use rapier3d_f64::dynamics::{
    GenericJointBuilder, JointAxesMask, MassProperties, MultibodyJointHandle, RigidBodyBuilder,
    RigidBodyHandle,
};
use rapier3d_f64::math::{Matrix, Pose as RapierPose, Rotation, Vector};
use rapier3d_f64::pipeline::PhysicsWorld;

use super::servo::{Interpolation, Servo};
use super::{ArmState, Push};
use crate::config::ConfigError;
use crate::constants::{SERVO_STEP, TOUCH_FILTER, TOUCH_SHARE};
use crate::contact::law::{self, Answer, ContactForces};
use crate::contact::{Contacts, Touches};
use crate::setpoint::{LimitedSetpoint, Setpoint};

/// The arm as rigid bodies.
pub struct RigidPlant {
    world: PhysicsWorld,
    chain: Chain,
    links: [RigidBodyHandle; DOF],
    last_joint: MultibodyJointHandle,
    servo: Servo,
    target: Setpoint,
    state: ArmState,
    push: Push,
    /// What the servo knows of obstacles at the tool, Nm: a share of the sensor's reading, smoothed.
    felt: JointTorques,
}

impl RigidPlant {
    /// The arm at rest at `q`; `gravity` is the free-fall acceleration in the base frame, m/s².
    ///
    /// # Errors
    /// [`ConfigError::Plant`] when a link has no mass, or the engine cannot join the links.
    pub fn new(
        model: &RobotModel,
        dynamics: &Dynamics,
        gravity: &Vector3<f64>,
        q: &JointPositions,
    ) -> Result<Self, ConfigError> {
        if dynamics.bodies().iter().any(|link| link.mass <= 0.0) {
            return Err(ConfigError::Plant {
                what: "a moving link has no mass",
            });
        }
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
                what: "the physics engine refused a joint",
            });
        };
        let mut plant = Self {
            world,
            chain: *model.chain(),
            links,
            last_joint,
            servo: Servo::new(&model.limits().effort, q),
            target: Setpoint::standing(*q),
            state: ArmState {
                q: JointPositions::ZERO,
                qd: JointSpeeds::ZERO,
                torque: JointTorques::ZERO,
                mean_torque: JointTorques::ZERO,
                contact: Wrench::default(),
            },
            push: Push::default(),
            felt: JointTorques::ZERO,
        };
        // A step of no time lets the engine see that the base is fixed: until then the multibody floats.
        plant.world.integration_parameters.dt = 0.0;
        plant.world.step();
        if let Some((multibody, _)) = plant.world.multibody_joints.get_mut(plant.last_joint) {
            // The engine damps joints unless told otherwise.
            multibody.damping_mut().fill(0.0);
        }
        plant.reset(q);
        Ok(plant)
    }

    /// Puts the arm at rest at `q`.
    pub fn reset(&mut self, q: &JointPositions) {
        let from = self.read().q;
        if let Some((multibody, _)) = self.world.multibody_joints.get_mut(self.last_joint) {
            let way: [f64; DOF] = core::array::from_fn(|joint| q[joint] - from[joint]);
            if way.iter().all(|x| x.is_finite()) {
                multibody.apply_displacements(&way);
            }
            multibody.generalized_velocity_mut().fill(0.0);
        }
        self.rest_at(q);
    }

    /// Forgets the target it was on the way to: it is wanted at `q` from now on.
    pub fn retarget(&mut self, q: &JointPositions) {
        self.servo.rest_at(q);
        self.target = Setpoint::standing(*q);
    }

    fn rest_at(&mut self, q: &JointPositions) {
        self.retarget(q);
        self.state.q = *q;
        self.state.qd = JointSpeeds::ZERO;
        self.felt = JointTorques::ZERO;
    }

    /// What pushes the tool from now on.
    pub fn push(&mut self, push: &Push) {
        self.push = *push;
    }

    /// Gravity has changed; the free-fall acceleration in the base frame, m/s².
    pub fn set_gravity(&mut self, gravity: &Vector3<f64>) {
        self.world.gravity = vector(gravity);
    }

    /// The masses have changed.
    pub fn set_dynamics(&mut self, dynamics: &Dynamics) {
        for (link, body) in self.links.iter().zip(dynamics.bodies()) {
            if let Some(link) = self.world.bodies.get_mut(*link) {
                link.set_additional_mass_properties(mass_properties(body), true);
            }
        }
    }

    /// One cycle of `step` seconds under servo control.
    pub(crate) fn follow(
        &mut self,
        target: &LimitedSetpoint,
        dynamics: &Dynamics,
        contacts: &Contacts,
        step: f64,
    ) -> ArmState {
        let way = Interpolation::new(self.target, *target.get(), step);
        let servo_steps = (step / SERVO_STEP).round().max(1.0);
        let servo_step = step / servo_steps;
        self.world.integration_parameters.dt = servo_step;
        let mut mean_torque = JointTorques::ZERO;
        let mut contact = Wrench::default();
        for k in 1..=servo_steps as u32 {
            let next = way.positions(f64::from(k) * servo_step);
            let ArmState { q, qd, .. } = self.state;
            let frames = self.chain.forward(&q);
            let (tcp, hand) = self.push.at(&frames);
            let felt = &self.felt;
            let known = JointTorques(core::array::from_fn(|joint| hand[joint] + felt[joint]));
            let torque = self
                .servo
                .torques(dynamics, &q, &qd, next, &known, servo_step);
            self.apply(&torque, &frames, tcp);
            if !contacts.is_empty() {
                let pushing = JointTorques(core::array::from_fn(|j| torque[j] + hand[j]));
                let pressing = self.press(contacts, dynamics, (&frames, tcp), &pushing, servo_step);
                contact.force += pressing.tool.force / servo_steps;
                contact.moment += pressing.tool.moment / servo_steps;
                let share = servo_step / (TOUCH_FILTER + servo_step);
                for joint in 0..DOF {
                    let known = TOUCH_SHARE * pressing.tool_torque[joint];
                    self.felt[joint] += share * (known - self.felt[joint]);
                }
            }
            self.world.step();
            for joint in 0..DOF {
                mean_torque[joint] += torque[joint] / servo_steps;
            }
            self.state = ArmState {
                torque,
                ..self.read()
            };
        }
        self.state.mean_torque = mean_torque;
        self.state.contact = contact;
        self.target = *target.get();
        self.state
    }

    /// One cycle with the brakes engaged: no time passes for the bodies.
    pub(crate) fn stand(&mut self, dynamics: &Dynamics, contacts: &Contacts) -> ArmState {
        if self.state.qd != JointSpeeds::ZERO
            && let Some((multibody, _)) = self.world.multibody_joints.get_mut(self.last_joint)
        {
            multibody.generalized_velocity_mut().fill(0.0);
        }
        let q = self.state.q;
        self.rest_at(&q);
        self.state.torque = dynamics.gravity_torques(&self.state.q);
        self.state.mean_torque = self.state.torque;
        let standing = JointSpeeds::ZERO;
        let pressing = contacts.pressed(&self.state.q, &standing, &self.push.flange_from_tcp);
        self.state.contact = pressing.tool;
        self.felt = pressing.tool_torque.map(|torque| TOUCH_SHARE * torque);
        self.state
    }

    /// Adds the forces of obstacles over the next `step` seconds, in which drives and hand give `torque`.
    fn press(
        &mut self,
        contacts: &Contacts,
        dynamics: &Dynamics,
        (frames, tcp): (&Frames, Vector3<f64>),
        torque: &JointTorques,
        step: f64,
    ) -> ContactForces {
        let ArmState { q, qd, .. } = self.state;
        let touches = contacts.touches(frames, &self.push.flange_from_tcp);
        // A mass matrix that cannot be factored belongs to a diverged plant, which the cycle stops.
        let mass = dynamics.mass_matrix(&q).cholesky();
        let (false, Some(mass)) = (touches.as_slice().is_empty(), mass) else {
            return ContactForces::NONE;
        };
        let bias = dynamics.bias_torques(&q, &qd);
        let net = Vector6::from_fn(|joint, _| torque[joint] - bias[joint]);
        let free = JointSpeeds((qd.to_vector() + mass.solve(&net) * step).into());
        let answer = Answer { mass, step };
        let obstacles = &contacts.obstacles;
        let forces = law::solve(&touches, obstacles, frames, tcp, &free, Some(&answer));
        self.push_links(&touches, &forces);
        forces
    }

    fn push_links(&mut self, touches: &Touches, forces: &ContactForces) {
        for (touch, force) in touches.as_slice().iter().zip(&forces.forces) {
            if let Some(link) = self.world.bodies.get_mut(self.links[touch.part.link()]) {
                link.add_force_at_point(vector(force), vector(&touch.place.point), false);
            }
        }
    }

    /// The engine has no input for joint torques: each goes to its link and, reversed, to the one before.
    fn apply(&mut self, torque: &JointTorques, frames: &Frames, tcp: Vector3<f64>) {
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
        if let Some(last) = self.world.bodies.get_mut(self.links[DOF - 1]) {
            let wrench = &self.push.wrench;
            last.add_force_at_point(vector(&wrench.force), vector(&tcp), false);
            last.add_torque(vector(&wrench.moment), false);
        }
    }

    /// Positions and speeds from the engine; torques zero.
    fn read(&self) -> ArmState {
        let mut state = ArmState {
            q: JointPositions::ZERO,
            qd: JointSpeeds::ZERO,
            torque: JointTorques::ZERO,
            mean_torque: JointTorques::ZERO,
            contact: Wrench::default(),
        };
        if let Some((multibody, _)) = self.world.multibody_joints.get(self.last_joint) {
            // The first link is the fixed base without a degree of freedom.
            for (joint, link) in multibody.links().skip(1).take(DOF).enumerate() {
                state.q[joint] = link.joint().coords()[3];
            }
            for (joint, speed) in multibody
                .generalized_velocity()
                .iter()
                .take(DOF)
                .enumerate()
            {
                state.qd[joint] = *speed;
            }
        }
        state
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
