//! Cylinders and rotary drives that move obstacles between two ends, with a force that has a limit.
//!
//! What moves is a free body on a joint of the engine, driven by the joint's motor: it pushes parts and is stopped by
//! the arm with at most its force, and nothing has to be measured for that. Gravity does not act on it.

use crate::description::{Actuator as Plan, Travel, WorldDescription};
use crate::engine::{Engine, MOVED, Material, vector};
use crate::error::WorldError;
use crate::machine_fault::MachineFault;
use crate::materials::Owner;
use crate::state::ActuatorState;
use kinematics::{Pose, rotation};
use motion_api::PointLevels;
use nalgebra::{Rotation3, Unit, Vector3};
use rapier3d_f64::dynamics::{
    GenericJoint, ImpulseJointHandle, JointAxis, MassProperties, MotorModel, PrismaticJointBuilder,
    RevoluteJointBuilder, RigidBodyHandle,
};
use rapier3d_f64::math::Vector;

/// The motor brings what moves to its speed within this time, s: its mass follows from that.
const TIME_TO_SPEED: f64 = 0.005;
/// At an end within this share of the way.
const END: f64 = 1e-3;
/// How stiffly the motor follows its speed.
const MOTOR_FACTOR: f64 = 1e4;

/// An actuator.
#[derive(Clone, Debug)]
pub(crate) struct Actuator {
    plan: Plan,
    /// Numbers of the obstacles that move, with their poses in the frame of what moves.
    pub(crate) obstacles: Vec<(usize, Pose)>,
    pub(crate) body: RigidBodyHandle,
    joint: ImpulseJointHandle,
    /// Where the body is when retracted.
    retracted: Pose,
    axis: Vector3<f64>,
    goes_out: bool,
    pub(crate) state: ActuatorState,
}

impl Actuator {
    pub(crate) fn new(
        plan: &Plan,
        cell: &WorldDescription,
        engine: &mut Engine,
    ) -> Result<Self, WorldError> {
        let (axis, point, way) = match plan.travel {
            Travel::Linear { axis, stroke } => (axis, None, stroke),
            Travel::Rotary { axis, point, angle } => (axis, Some(Vector3::from(point)), angle),
        };
        let axis = *Unit::new_normalize(Vector3::from(axis));
        let numbers = cell
            .obstacles
            .iter()
            .enumerate()
            .filter(|(_, o)| plan.moves.contains(&o.name))
            .map(|(i, _)| i);
        let numbers: Vec<usize> = numbers.collect();
        let first = numbers
            .first()
            .map_or(Vector3::zeros(), |i| cell.obstacles[*i].pose.translation);
        let retracted = Pose::new(Rotation3::identity(), point.unwrap_or(first));
        let mut actuator = Self {
            plan: plan.clone(),
            obstacles: numbers
                .iter()
                .map(|i| (*i, retracted.inverse() * cell.obstacles[*i].pose))
                .collect(),
            body: RigidBodyHandle::invalid(),
            joint: ImpulseJointHandle::invalid(),
            retracted,
            axis,
            goes_out: plan.starts_extended,
            state: ActuatorState {
                position: if plan.starts_extended { way } else { 0.0 },
                is_at_end: true,
            },
        };
        actuator.body = engine.add_free(&actuator.pose_at(actuator.state.position));
        for (number, pose) in &actuator.obstacles {
            let obstacle = &cell.obstacles[*number];
            let material = Material {
                owner: Owner::Obstacle(*number as u32),
                friction: obstacle.friction,
                restitution: 0.0,
                group: MOVED,
            };
            engine.attach(actuator.body, &obstacle.shape, pose, 0.0, material);
        }
        let speed = way / plan.time;
        let inertia = plan.force * TIME_TO_SPEED / speed;
        let (mass, moment) = if point.is_some() {
            (inertia.max(1.0), inertia)
        } else {
            (inertia, inertia)
        };
        if let Some(body) = engine.physics.bodies.get_mut(actuator.body) {
            body.set_additional_mass_properties(
                MassProperties::new(Vector::ZERO, mass, Vector::splat(moment)),
                true,
            );
            body.set_gravity_scale(0.0, true);
            body.activation_mut().normalized_linear_threshold = -1.0;
            body.activation_mut().angular_threshold = -1.0;
        }
        let base = engine.add_still(&retracted);
        let joint: GenericJoint = match point {
            None => PrismaticJointBuilder::new(vector(axis))
                .motor_max_force(plan.force)
                .motor_model(MotorModel::ForceBased)
                .build()
                .into(),
            Some(_) => RevoluteJointBuilder::new(vector(axis))
                .motor_max_force(plan.force)
                .motor_model(MotorModel::ForceBased)
                .build()
                .into(),
        };
        actuator.joint = engine
            .physics
            .insert_impulse_joint(base, actuator.body, joint);
        match engine.physics.impulse_joints.get(actuator.joint) {
            Some(_) => Ok(actuator),
            None => Err(WorldError::Joint {
                name: plan.name.clone(),
            }),
        }
    }

    fn way(&self) -> f64 {
        match self.plan.travel {
            Travel::Linear { stroke, .. } => stroke,
            Travel::Rotary { angle, .. } => angle,
        }
    }

    fn pose_at(&self, position: f64) -> Pose {
        match self.plan.travel {
            Travel::Linear { .. } => Pose::new(
                self.retracted.rotation,
                self.retracted.translation + self.axis * position,
            ),
            Travel::Rotary { .. } => Pose::new(
                rotation::rotation_from_rotvec(self.axis * position),
                self.retracted.translation,
            ),
        }
    }

    /// Before the engine's step: the speed that the motor wants.
    pub(crate) fn before_step(
        &mut self,
        engine: &mut Engine,
        outputs: &PointLevels,
        period: f64,
        fault: MachineFault,
    ) {
        let extend = outputs.level(self.plan.extend);
        self.goes_out = match self.plan.retract {
            None => extend,
            Some(retract) => match (extend, outputs.level(retract)) {
                (true, false) => true,
                (false, true) => false,
                _ => self.goes_out,
            },
        };
        let goal = if self.goes_out { self.way() } else { 0.0 };
        let fastest = self.way() / self.plan.time * fault.speed_share();
        let speed =
            kinematics::bounds::within((goal - self.state.position) / period, -fastest, fastest);
        let axis = match self.plan.travel {
            Travel::Linear { .. } => JointAxis::LinX,
            Travel::Rotary { .. } => JointAxis::AngX,
        };
        if let Some(joint) = engine.physics.impulse_joints.get_mut(self.joint, true) {
            joint
                .data
                .set_motor_velocity(axis, speed, MOTOR_FACTOR * self.plan.force);
        }
    }

    /// After the engine's step: where it is.
    pub(crate) fn after_step(&mut self, engine: &Engine) {
        let pose = engine.pose(self.body);
        self.state.position = match self.plan.travel {
            Travel::Linear { .. } => {
                (pose.translation - self.retracted.translation).dot(&self.axis)
            }
            Travel::Rotary { .. } => rotation::rotvec_from_rotation(&pose.rotation).dot(&self.axis),
        };
        let margin = self.way() * END;
        self.state.is_at_end =
            self.state.position < margin || self.state.position > self.way() - margin;
    }

    /// Tells the ends.
    pub(crate) fn report(&self, inputs: &mut PointLevels) {
        let margin = self.way() * END;
        let tells = [
            (
                self.plan.extended,
                self.state.position > self.way() - margin,
            ),
            (self.plan.retracted, self.state.position < margin),
        ];
        for (point, level) in tells {
            if let Some(point) = point {
                inputs.set_level(point, level);
            }
        }
    }

    /// Shapes of what moves, for pictures.
    pub(crate) fn obstacle_poses(&self, engine: &Engine) -> impl Iterator<Item = (usize, Pose)> {
        let pose = engine.pose(self.body);
        self.obstacles
            .iter()
            .map(move |(number, local)| (*number, pose * *local))
    }
}

/// Whether an actuator moves this obstacle.
pub(crate) fn is_moved(cell: &WorldDescription, name: &str) -> bool {
    cell.actuators
        .iter()
        .any(|a| a.moves.iter().any(|m| m == name))
}
