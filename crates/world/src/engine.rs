//! The rapier engine with what the world asks of it: bodies, one step, contact forces, a copy of everything.
//!
//! Owns every conversion between the engine's vectors (glam) and ours (nalgebra).
//!
//! The defaults of the engine let a stack of eight boxes of 50 mm sink by 15 mm. Here contacts are found once a step (a
//! control cycle) and solved in substeps of a millisecond, with springs of 200 Hz (400 Hz against what stands still)
//! instead of 30 Hz: the stack sinks by
//! 0.35 mm and creeps by 0.02 mm. The simplified friction model of the engine is exact on a slope; its Coulomb
//! model loses 6 % of the friction there. One pass of the solver after the springs gives a box that is hit square on 12
//! % too much speed and a spin, because it goes through the corners one by one; eight passes leave 0.7 %. Steps in
//! which nothing can be hit do with one ([`crate::calm`]).

use crate::calm::VelocitiesBefore;
use crate::description::{BodyShape, Settings};
use crate::materials::{Materials, Owner};
use kinematics::{Pose, Twist, Wrench};
use mesh::MeshBody;
use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion, Vector3};
use rapier3d_f64::dynamics::{
    FrictionModel, MassProperties, RigidBodyBuilder, RigidBodyHandle, RigidBodyType,
    SpringCoefficients,
};
use rapier3d_f64::geometry::{
    ColliderBuilder, ColliderHandle, ContactPair, Group, InteractionGroups, InteractionTestMode,
    SharedShape,
};
use rapier3d_f64::math::{Pose as EnginePose, Vector};
use rapier3d_f64::pipeline::{CollisionPipeline, PhysicsPipeline, PhysicsWorld};
use rapier3d_f64::prelude::{CCDSolver, CoefficientCombineRule};
use std::sync::Arc;

/// Natural frequency of contacts, Hz; twice that against what stands still.
const CONTACT_FREQUENCY: f64 = 200.0;
/// Passes of the solver after the springs in each substep.
const SOLVER_PASSES: usize = 8;
/// Passes of the solver where nothing hits anything; see [`crate::calm`].
const CALM_PASSES: usize = 1;
/// Damping ratio of contacts.
const CONTACT_DAMPING: f64 = 10.0;
/// Contacts are foreseen this far off, m. The engine's 20 mm make one heap of a pallet whose boxes have 5 mm between
/// them: none of them sleeps while another is put down.
pub(crate) const PREDICTION: f64 = 0.002;
/// The engine's unit of length, m. All that it multiplies by this is given in m here, so only one thing depends on it:
/// how far beyond a body the box reaches by which the engine finds pairs, a twenty-fifth of it. With a unit of 1 m all
/// boxes of a pallet are pairs of their neighbours, and a box that a gripper lets go wakes its pairs.
const UNIT: f64 = 0.02;
/// Between bodies that come towards each other fast enough contacts are foreseen up to this distance, m.
const SOFT_CCD: f64 = 0.05;
/// A body slower than this may be left out of the step, m/s.
const SLEEP_SPEED: f64 = 5e-4;
/// How long it has to be, s.
const SLEEP_TIME: f64 = 0.5;

/// Who may touch whom: what stands still, parts, the arm with its tool, what actuators move.
pub(crate) const STILL: Group = Group::GROUP_1;
pub(crate) const PARTS: Group = Group::GROUP_2;
pub(crate) const ARM: Group = Group::GROUP_3;
pub(crate) const MOVED: Group = Group::GROUP_4;

/// The engine's state.
pub(crate) struct Engine {
    pub(crate) physics: PhysicsWorld,
    pub(crate) materials: Materials,
    sleeping: bool,
    velocities: VelocitiesBefore,
}

impl Clone for Engine {
    fn clone(&self) -> Self {
        let from = &self.physics;
        Self {
            physics: PhysicsWorld {
                gravity: from.gravity,
                integration_parameters: from.integration_parameters,
                // Pipelines and the solver of fast bodies hold nothing from one step to the next.
                physics_pipeline: PhysicsPipeline::new(),
                collision_pipeline: CollisionPipeline::new(),
                ccd_solver: CCDSolver::new(),
                islands: from.islands.clone(),
                broad_phase: from.broad_phase.clone(),
                narrow_phase: from.narrow_phase.clone(),
                bodies: from.bodies.clone(),
                colliders: from.colliders.clone(),
                impulse_joints: from.impulse_joints.clone(),
                multibody_joints: from.multibody_joints.clone(),
                soft_bodies: from.soft_bodies.clone(),
            },
            materials: self.materials.clone(),
            sleeping: self.sleeping,
            velocities: self.velocities.clone(),
        }
    }
}

/// What a collider is made of, and whose it is.
#[derive(Clone, Copy)]
pub(crate) struct Material {
    /// Whose; see [`crate::materials`].
    pub(crate) owner: Owner,
    /// Coefficient of friction.
    pub(crate) friction: f64,
    /// Coefficient of restitution.
    pub(crate) restitution: f64,
    /// One of the groups above.
    pub(crate) group: Group,
}

impl Engine {
    pub(crate) fn new(settings: &Settings, materials: Materials) -> Self {
        let mut physics = PhysicsWorld::new();
        physics.gravity = vector(settings.gravity.into());
        let substeps = (settings.period / settings.substep - 1e-9).ceil().max(1.0);
        let parameters = &mut physics.integration_parameters;
        parameters.dt = settings.period;
        parameters.num_solver_iterations = substeps as usize;
        parameters.contact_softness = SpringCoefficients::new(CONTACT_FREQUENCY, CONTACT_DAMPING);
        parameters.static_contact_softness =
            SpringCoefficients::new(2.0 * CONTACT_FREQUENCY, CONTACT_DAMPING);
        parameters.friction_model = FrictionModel::Simplified;
        parameters.num_internal_stabilization_iterations = SOLVER_PASSES;
        parameters.length_unit = UNIT;
        parameters.normalized_allowed_linear_error = 1e-4 / UNIT;
        parameters.normalized_max_corrective_velocity /= UNIT;
        parameters.normalized_max_linear_velocity /= UNIT;
        parameters.normalized_prediction_distance = PREDICTION / UNIT;
        parameters.normalized_contact_recycle_distance = 2e-4 / UNIT;
        Self {
            physics,
            materials,
            sleeping: settings.sleeping,
            velocities: VelocitiesBefore::default(),
        }
    }

    /// Length of a substep, s.
    pub(crate) fn substep(&self) -> f64 {
        let parameters = &self.physics.integration_parameters;
        parameters.dt / parameters.num_solver_iterations as f64
    }

    /// Free-fall acceleration, base frame, m/s².
    pub(crate) fn gravity(&self) -> Vector3<f64> {
        our_vector(self.physics.gravity)
    }

    pub(crate) fn step(&mut self) {
        let passes = match self.velocities.is_calm(&self.physics) {
            true => CALM_PASSES,
            false => SOLVER_PASSES,
        };
        let parameters = &mut self.physics.integration_parameters;
        parameters.num_internal_stabilization_iterations = passes;
        self.physics.step_with_events(&self.materials, &());
    }

    /// A body that moves only when told.
    pub(crate) fn add_still(&mut self, pose: &Pose) -> RigidBodyHandle {
        self.physics
            .insert_body(RigidBodyBuilder::fixed().pose(engine_pose(pose)))
    }

    /// A body whose motion is given.
    pub(crate) fn add_driven(&mut self, pose: &Pose) -> RigidBodyHandle {
        self.physics.insert_body(
            RigidBodyBuilder::kinematic_position_based()
                .soft_ccd_prediction(SOFT_CCD)
                .pose(engine_pose(pose)),
        )
    }

    /// A body that moves by itself.
    pub(crate) fn add_free(&mut self, pose: &Pose) -> RigidBodyHandle {
        let mut body = RigidBodyBuilder::dynamic()
            .pose(engine_pose(pose))
            .ccd_enabled(true)
            .soft_ccd_prediction(SOFT_CCD)
            .build();
        let activation = body.activation_mut();
        (
            activation.normalized_linear_threshold,
            activation.angular_threshold,
        ) = match self.sleeping {
            true => (SLEEP_SPEED / UNIT, SLEEP_SPEED),
            false => (-1.0, -1.0),
        };
        activation.time_until_sleep = SLEEP_TIME;
        self.physics.insert_body(body)
    }

    /// Gives a body a solid at `pose` in its frame; `mass` in kg for bodies that move by themselves.
    pub(crate) fn attach(
        &mut self,
        body: RigidBodyHandle,
        shape: &BodyShape,
        pose: &Pose,
        mass: f64,
        material: Material,
    ) -> ColliderHandle {
        self.attach_prepared(body, &EngineShape::new(shape), pose, mass, material)
    }

    /// Gives a body a solid that the engine knows already, at `pose` in its frame.
    pub(crate) fn attach_prepared(
        &mut self,
        body: RigidBodyHandle,
        shape: &EngineShape,
        pose: &Pose,
        mass: f64,
        material: Material,
    ) -> ColliderHandle {
        let place = engine_pose(pose) * shape.turn;
        let collider = self.attach_solid(body, shape.solid.clone(), place, mass, material);
        // Pieces may overlap, and have other middles: what the mesh itself weighs counts.
        if let Some(mesh) = &shape.mesh
            && mass > 0.0
            && let Some(collider) = self.physics.colliders.get_mut(collider)
        {
            let solid = mesh.solid();
            let inertia = solid.inertia() * (mass / solid.volume());
            collider.set_mass_properties(MassProperties::with_inertia_matrix(
                vector(solid.centre()),
                mass,
                inertia.into(),
            ));
        }
        collider
    }

    pub(crate) fn attach_solid(
        &mut self,
        body: RigidBodyHandle,
        solid: SharedShape,
        pose: EnginePose,
        mass: f64,
        material: Material,
    ) -> ColliderHandle {
        let may_touch = match material.group {
            STILL => PARTS,
            PARTS => STILL | PARTS | ARM | MOVED,
            ARM => PARTS | MOVED,
            _ => PARTS | ARM,
        };
        let collider = ColliderBuilder::new(solid)
            .position(pose)
            .mass(mass)
            .friction(material.friction)
            .friction_combine_rule(CoefficientCombineRule::Min)
            .restitution(material.restitution)
            .restitution_combine_rule(CoefficientCombineRule::Max)
            .collision_groups(InteractionGroups::new(
                material.group,
                may_touch,
                InteractionTestMode::And,
            ))
            .active_hooks(self.materials.hooks(material.owner))
            .user_data(material.owner.to_number());
        self.physics.insert_collider(collider, Some(body))
    }

    pub(crate) fn remove(&mut self, body: RigidBodyHandle) {
        self.wake_neighbours(body);
        self.physics.remove_body(body);
    }

    /// Pose of a body; identity for one that is gone.
    pub(crate) fn pose(&self, body: RigidBodyHandle) -> Pose {
        self.physics
            .bodies
            .get(body)
            .map_or(Pose::IDENTITY, |b| our_pose(b.position()))
    }

    /// Whether the engine leaves a body out of its step.
    pub(crate) fn is_asleep(&self, body: RigidBodyHandle) -> bool {
        self.physics
            .bodies
            .get(body)
            .is_some_and(|b| b.is_sleeping())
    }

    /// Velocity of a body's centre of mass and its rotation, base frame.
    pub(crate) fn velocity(&self, body: RigidBodyHandle) -> Twist {
        self.physics
            .bodies
            .get(body)
            .map_or(Twist::default(), |b| Twist {
                linear: our_vector(b.linvel()),
                angular: our_vector(b.angvel()),
            })
    }

    /// Where a driven body is at the end of the next step.
    pub(crate) fn drive(&mut self, body: RigidBodyHandle, pose: &Pose) {
        if let Some(b) = self.physics.bodies.get_mut(body) {
            b.set_next_kinematic_position(engine_pose(pose));
        }
    }

    /// Puts a body somewhere, at rest.
    pub(crate) fn place(&mut self, body: RigidBodyHandle, pose: &Pose) {
        self.wake_neighbours(body);
        if let Some(b) = self.physics.bodies.get_mut(body) {
            b.set_position(engine_pose(pose), true);
            if b.is_dynamic() {
                b.set_linvel(Vector::ZERO, true);
                b.set_angvel(Vector::ZERO, true);
            }
        }
    }

    /// Makes a free body a driven one.
    pub(crate) fn take(&mut self, body: RigidBodyHandle) {
        self.wake_neighbours(body);
        if let Some(b) = self.physics.bodies.get_mut(body) {
            b.set_body_type(RigidBodyType::KinematicPositionBased, true);
        }
    }

    /// Makes a driven body a free one with a velocity.
    pub(crate) fn free(&mut self, body: RigidBodyHandle, velocity: &Twist) {
        if let Some(b) = self.physics.bodies.get_mut(body) {
            b.set_body_type(RigidBodyType::Dynamic, true);
            b.set_linvel(vector(velocity.linear), true);
            b.set_angvel(vector(velocity.angular), true);
        }
        self.wake_neighbours(body);
    }

    /// Wakes what touches a body: the engine itself only sees that when something moves.
    pub(crate) fn wake_neighbours(&mut self, body: RigidBodyHandle) {
        let Some(b) = self.physics.bodies.get(body) else {
            return;
        };
        let mut near = Vec::new();
        for collider in b.colliders() {
            for pair in self.physics.contact_pairs_with(*collider) {
                if !is_nearer(pair, PREDICTION) {
                    continue;
                }
                let other = if pair.collider1 == *collider {
                    pair.collider2
                } else {
                    pair.collider1
                };
                near.extend(self.physics.colliders.get(other).and_then(|c| c.parent()));
            }
        }
        for handle in near {
            self.physics.wake_up(handle, true);
        }
    }

    /// Whether a collider of this owner was nearer to this one than a distance when the engine last looked.
    pub(crate) fn is_near_one_of(
        &self,
        collider: ColliderHandle,
        owner: Owner,
        distance: f64,
    ) -> bool {
        let mut pairs = self.physics.contact_pairs_with(collider);
        pairs.any(|pair| {
            let other = if pair.collider1 == collider {
                pair.collider2
            } else {
                pair.collider1
            };
            let other = self.physics.colliders.get(other);
            other.is_some_and(|other| Owner::from_number(other.user_data) == owner)
                && is_nearer(pair, distance)
        })
    }

    /// Whose colliders were nearer to this one than a distance when the engine last looked, in a fixed order.
    pub(crate) fn near(&self, collider: ColliderHandle, distance: f64) -> Vec<Owner> {
        let mut owners = Vec::new();
        for pair in self.physics.contact_pairs_with(collider) {
            if is_nearer(pair, distance) {
                let other = if pair.collider1 == collider {
                    pair.collider2
                } else {
                    pair.collider1
                };
                owners.extend(
                    self.physics
                        .colliders
                        .get(other)
                        .map(|c| Owner::from_number(c.user_data)),
                );
            }
        }
        owners.sort_by_key(|owner| owner.to_number());
        owners.dedup();
        owners
    }

    /// What touched a collider in the last step: the others, and the force on this one with its point.
    pub(crate) fn contacts(&self, collider: ColliderHandle) -> Vec<Touch> {
        let mut touches = Vec::new();
        let dt = self.physics.integration_parameters.dt;
        for pair in self.physics.contact_pairs_with(collider) {
            if !pair.has_any_active_contact() {
                continue;
            }
            let is_first = pair.collider1 == collider;
            let sign = if is_first { -1.0 } else { 1.0 };
            let mut force = Vector3::zeros();
            let mut moment = Vector3::zeros();
            for manifold in pair.solver_manifolds() {
                let normal = our_vector(manifold.data.normal);
                let count = manifold.data.solver_contacts.len().max(1) as f64;
                for contact in &manifold.data.solver_contacts {
                    let id = contact.contact_indices()[0] as usize & 0x7fff_ffff;
                    let Some(point) = manifold.points.get(id) else {
                        continue;
                    };
                    let (p1, p2) = manifold
                        .data
                        .solver_contact_world_points(contact, &self.physics.bodies);
                    let at = our_vector((p1 + p2) * 0.5);
                    // The engine keeps friction as one impulse a manifold and substep.
                    let along =
                        our_vector(point.data.warmstart_tangent_world) / (count * self.substep());
                    let f = (normal * (point.data.impulse / dt) + along) * sign;
                    force += f;
                    moment += at.cross(&f);
                }
            }
            touches.push(Touch {
                on_this: Wrench { force, moment },
            });
        }
        touches
    }
}

/// Whether two colliders were nearer to each other than a distance when the engine last looked.
fn is_nearer(pair: &ContactPair, distance: f64) -> bool {
    let mut points = pair
        .manifolds()
        .iter()
        .flat_map(|manifold| &manifold.points);
    points.any(|point| point.dist < distance)
}

/// What something that touches a collider does to it.
pub(crate) struct Touch {
    /// Force on this one and moment about the origin of the base, base axes.
    pub(crate) on_this: Wrench,
}

pub(crate) fn vector(v: Vector3<f64>) -> Vector {
    v.into()
}

pub(crate) fn our_vector(v: Vector) -> Vector3<f64> {
    v.into()
}

pub(crate) fn engine_pose(pose: &Pose) -> EnginePose {
    let rotation = UnitQuaternion::from_rotation_matrix(&pose.rotation);
    Isometry3::from_parts(Translation3::from(pose.translation), rotation).into()
}

pub(crate) fn our_pose(pose: &EnginePose) -> Pose {
    let isometry: Isometry3<f64> = (*pose).into();
    Pose::new(
        Rotation3::from(isometry.rotation),
        isometry.translation.vector,
    )
}

/// A solid as the engine has it. Making one of a mesh takes long; clones share it.
#[derive(Clone)]
pub(crate) struct EngineShape {
    pub(crate) solid: SharedShape,
    /// Pose in the frame of our solid: the engine's cylinders stand along y.
    pub(crate) turn: EnginePose,
    /// The mesh whose mass properties count instead of those of the engine's solid.
    mesh: Option<Arc<MeshBody>>,
}

impl EngineShape {
    pub(crate) fn new(shape: &BodyShape) -> Self {
        let (solid, turn) = engine_solid(shape);
        let mesh = match shape {
            BodyShape::Mesh(mesh) => Some(mesh.clone()),
            _ => None,
        };
        Self { solid, turn, mesh }
    }
}

impl core::fmt::Debug for EngineShape {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "EngineShape({:?})", self.solid.shape_type())
    }
}

fn engine_solid(shape: &BodyShape) -> (SharedShape, EnginePose) {
    let upright = EnginePose::IDENTITY;
    match *shape {
        BodyShape::Mesh(ref mesh) => (compound(mesh), upright),
        BodyShape::Box { size } => (
            SharedShape::cuboid(size[0] / 2.0, size[1] / 2.0, size[2] / 2.0),
            upright,
        ),
        BodyShape::Cylinder { radius, length } => {
            let half = core::f64::consts::FRAC_1_SQRT_2;
            let turn =
                UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(half, half, 0.0, 0.0));
            (
                SharedShape::cylinder(length / 2.0, radius),
                Isometry3::from_parts(Translation3::identity(), turn).into(),
            )
        }
        BodyShape::Sphere { radius } => (SharedShape::ball(radius), upright),
        BodyShape::Plane => (SharedShape::halfspace(Vector::Z), upright),
    }
}

/// The convex pieces of a mesh as one shape of the engine.
fn compound(mesh: &MeshBody) -> SharedShape {
    let pieces = mesh.pieces().iter().filter_map(|piece| {
        let points: Vec<Vector> = piece.body.points().iter().map(|p| vector(*p)).collect();
        // A piece is a convex body already; one that the engine finds flat carries nothing.
        let shape = SharedShape::convex_hull(&points)?;
        Some((EnginePose::from_translation(vector(piece.middle)), shape))
    });
    SharedShape::compound(pieces.collect())
}
