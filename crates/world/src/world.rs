//! One step of the world, in its order.

use crate::arm::{Arm, add_touches};
use crate::check::check;
use crate::description::*;
use crate::engine::{Engine, Material, STILL};
use crate::error::WorldError;
use crate::input::{Input, Output};
use crate::levels::PointSet;
use crate::materials::{Materials, Owner};
use crate::parts::Parts;
use crate::state::{PartState, WorldState};
use kinematics::Pose;
use rapier3d_f64::dynamics::RigidBodyHandle;

/// Friction of the floor towards parts.
const FLOOR_FRICTION: f64 = 0.5;
/// Without a floor, parts are removed this far below the base, m.
const LOST_BELOW: f64 = -10.0;

/// What surrounds the arm. A clone is a copy of the whole state: it goes on exactly as the original does.
#[derive(Clone)]
pub struct World {
    pub(crate) settings: Settings,
    pub(crate) engine: Engine,
    pub(crate) parts: Parts,
    arm: Arm,
    obstacles: Vec<RigidBodyHandle>,
    driven: PointSet,
    output: Output,
    state: WorldState,
}

impl World {
    /// The world at its start.
    ///
    /// # Errors
    /// The first thing in the description that is impossible.
    pub fn new(cell: &WorldDescription) -> Result<Self, WorldError> {
        let driven = check(cell)?;
        let mut engine = Engine::new(&cell.settings, Materials::new(cell));
        let still = |owner, friction| Material {
            owner,
            friction,
            restitution: 0.0,
            group: STILL,
        };
        if let Some(height) = cell.settings.floor {
            let body = engine.add_still(&Pose::from_translation(0.0, 0.0, height));
            engine.attach(
                body,
                &Shape::Plane,
                &Pose::IDENTITY,
                0.0,
                still(Owner::Floor, FLOOR_FRICTION),
            );
        }
        let obstacles = cell.obstacles.iter().enumerate().map(|(i, obstacle)| {
            let body = engine.add_still(&obstacle.pose);
            engine.attach(
                body,
                &obstacle.shape,
                &Pose::IDENTITY,
                0.0,
                still(Owner::Obstacle(i as u32), obstacle.friction),
            );
            body
        });
        let obstacles = obstacles.collect();
        let arm = Arm::new(&cell.arm, &mut engine, cell.settings.period);
        let parts = Parts::new(cell, &mut engine);
        let mut world = Self {
            settings: cell.settings,
            engine,
            parts,
            arm,
            obstacles,
            driven,
            output: Output::default(),
            state: WorldState::default(),
        };
        world.picture();
        Ok(world)
    }

    /// Moves the world by one period: with the arm where it is at the end of the cycle, and the outputs of the cycle.
    pub fn step(&mut self, input: &Input) -> &Output {
        self.state.cycle += 1;
        self.arm.drive(&mut self.engine, input);
        self.engine.step();
        self.remove_lost_parts();
        self.output = self.border(input);
        self.picture();
        &self.output
    }

    /// The inputs that the world drives.
    pub fn driven_inputs(&self) -> PointSet {
        self.driven
    }

    /// What the last step gave to the cycle.
    pub fn output(&self) -> &Output {
        &self.output
    }

    /// What can be seen after the last step.
    pub fn state(&self) -> &WorldState {
        &self.state
    }

    fn remove_lost_parts(&mut self) {
        if self.settings.floor.is_some() {
            return;
        }
        let lost: Vec<_> = (self.parts.bodies.iter())
            .filter(|(_, part)| self.engine.pose(part.body).translation.z < LOST_BELOW)
            .map(|(number, _)| *number)
            .collect();
        for number in lost {
            if let Some(part) = self.parts.remove(&mut self.engine, number) {
                self.state.lost_below.push(part.name);
            }
        }
    }

    fn border(&self, input: &Input) -> Output {
        let mut output = Output::default();
        let about = input.base_from_flange.translation;
        for collider in &self.arm.tool_colliders {
            add_touches(
                &mut output.tool_wrench,
                &self.engine.contacts(*collider),
                about,
            );
        }
        output.link_wrenches = self.arm.link_wrenches(&self.engine, input);
        output
    }

    fn picture(&mut self) {
        let engine = &self.engine;
        self.state.parts.clear();
        self.state
            .parts
            .extend(self.parts.bodies.values().map(|part| PartState {
                name: part.name.clone(),
                template: part.template,
                pose: engine.pose(part.body),
                velocity: engine.velocity(part.body),
                held_by: part.gripper,
                touches_floor: false,
            }));
        self.state.obstacles.clear();
        self.state
            .obstacles
            .extend(self.obstacles.iter().map(|body| engine.pose(*body)));
    }
}
