//! One step of the world, in its order.

use crate::actuator::{Actuator, is_moved};
use crate::arm::{Arm, add_touches};
use crate::check::check;
use crate::conveyor::Conveyor;
use crate::description::*;
use crate::detector::{Detector, is_inside};
use crate::engine::{Engine, Material, STILL};
use crate::error::WorldError;
use crate::fault::{self, Fault};
use crate::gripper::{GripContext, Gripper};
use crate::materials::{Materials, Owner};
use crate::overlap::refuse_overlaps;
use crate::part_faults::MissingPart;
use crate::parts::{PartBody, PartNumber, PartTable};
use crate::scatter::Scatter;
use crate::source::Source;
use crate::state::{GripperState, PartState, WorldState};
use kinematics::{Pose, Twist, Wrench, elementary};
use motion_api::PointSet;
use motion_api::{MAX_GRIPPERS, WorldInput, WorldOutput};
use rapier3d_f64::dynamics::RigidBodyHandle;
use std::sync::Arc;

/// Friction of the floor towards parts.
const FLOOR_FRICTION: f64 = 0.5;
/// Without a floor, parts are removed this far below the base, m.
const LOST_BELOW: f64 = -10.0;
/// What obstacles do to a held part counts with this time constant, s: a hit of a few milliseconds moves a part by
/// nothing that a cup or finger would not follow.
const CONTACT_LAG: f64 = 0.02;
/// Number of the random sequence of faults; sources have those from 0.
const FAULT_STREAM: u64 = 1 << 32;

/// What surrounds the arm. A clone is a copy of the whole state: it goes on exactly as the original does.
#[derive(Clone)]
pub struct World {
    pub(crate) settings: Settings,
    pub(crate) engine: Engine,
    pub(crate) parts: PartTable,
    pub(crate) names: Names,
    pub(crate) grippers: Vec<Gripper>,
    pub(crate) faults: Vec<Fault>,
    pub(crate) absent: Vec<MissingPart>,
    pub(crate) scatter: Scatter,
    pub(crate) state: WorldState,
    pub(crate) driven: PointSet,
    /// Parts that the faults of this cycle take out of their grippers.
    pub(crate) drops: Vec<PartNumber>,
    /// What obstacles do to the part in each gripper, as far as it counts: about the origin of the flange, base axes.
    touched_by: [Wrench; MAX_GRIPPERS],
    arm: Arm,
    obstacles: Vec<RigidBodyHandle>,
    conveyors: Vec<Conveyor>,
    actuators: Vec<Actuator>,
    detectors: Vec<Detector>,
    sources: Vec<Source>,
    sinks: Vec<Sink>,
    output: WorldOutput,
}

/// Names in the order of the description.
#[derive(Clone, Default)]
pub(crate) struct Names {
    pub(crate) obstacles: Vec<String>,
    pub(crate) grippers: Vec<String>,
    pub(crate) conveyors: Vec<String>,
    pub(crate) actuators: Vec<String>,
}

impl World {
    /// The world at its start.
    ///
    /// # Errors
    /// The first thing in the description that is impossible.
    pub fn new(cell: &WorldDescription) -> Result<Self, WorldError> {
        let driven = check(cell)?;
        let Settings {
            period,
            seed,
            floor,
            ..
        } = cell.settings;
        let mut engine = Engine::new(&cell.settings, Materials::new(cell));
        let still = |owner, friction| Material {
            owner,
            friction,
            restitution: 0.0,
            group: STILL,
        };
        if let Some(height) = floor {
            let body = engine.add_still(&Pose::from_translation(0.0, 0.0, height));
            engine.attach(
                body,
                &BodyShape::Plane,
                &Pose::IDENTITY,
                0.0,
                still(Owner::Floor, FLOOR_FRICTION),
            );
        }
        let mut obstacles = Vec::new();
        for (i, obstacle) in cell.obstacles.iter().enumerate() {
            let body = engine.add_still(&obstacle.pose);
            if !is_moved(cell, &obstacle.name) {
                engine.attach(
                    body,
                    &obstacle.shape,
                    &Pose::IDENTITY,
                    0.0,
                    still(Owner::Obstacle(i as u32), obstacle.friction),
                );
            }
            obstacles.push(body);
        }
        let conveyors = cell.conveyors.iter().enumerate();
        let conveyors = conveyors
            .map(|(i, plan)| Conveyor::new(plan, i, &mut engine))
            .collect();
        let actuators: Result<_, _> = cell
            .actuators
            .iter()
            .map(|plan| Actuator::new(plan, cell, &mut engine))
            .collect();
        let arm = Arm::new(&cell.arm, &mut engine, period);
        let parts = PartTable::new(cell, &mut engine);
        refuse_overlaps(&engine, &parts)?;
        let grippers = cell.grippers.iter().enumerate();
        let grippers = grippers
            .map(|(i, plan)| Gripper::new(plan, i, &mut engine, arm.tool))
            .collect();
        let sources = cell.sources.iter().enumerate();
        let mut world = Self {
            settings: cell.settings,
            sources: sources
                .map(|(i, plan)| Source::new(plan, &parts, seed, i))
                .collect(),
            engine,
            parts,
            names: Names {
                obstacles: cell.obstacles.iter().map(|o| o.name.clone()).collect(),
                grippers: cell.grippers.iter().map(|g| g.name.clone()).collect(),
                conveyors: cell.conveyors.iter().map(|c| c.name.clone()).collect(),
                actuators: cell.actuators.iter().map(|a| a.name.clone()).collect(),
            },
            arm,
            grippers,
            obstacles,
            conveyors,
            actuators: actuators?,
            detectors: cell
                .detectors
                .iter()
                .map(|plan| Detector::new(plan, period))
                .collect(),
            sinks: cell.sinks.clone(),
            faults: cell.faults.iter().cloned().map(Fault::new).collect(),
            absent: Vec::new(),
            drops: Vec::new(),
            touched_by: [Wrench::default(); MAX_GRIPPERS],
            scatter: Scatter::new(seed, FAULT_STREAM),
            driven,
            output: WorldOutput::default(),
            state: WorldState {
                sinks: vec![0; cell.sinks.len()],
                ..WorldState::default()
            },
        };
        world.picture();
        Ok(world)
    }

    /// Moves the world by one period: with the arm where it is at the end of the cycle, and the outputs of the cycle.
    /// The world's time is the cycle's also where cycles have been left out.
    pub fn step(&mut self, input: &WorldInput) -> &WorldOutput {
        self.state.cycle = self.state.cycle.max(input.cycle.saturating_sub(1));
        let time = self.time();
        self.state.cycle += 1;
        let before = self.output.inputs;
        self.advance_faults(&input.outputs, &before, time);
        for (i, conveyor) in self.conveyors.iter_mut().enumerate() {
            let impaired = fault::of_machine(&self.faults, &self.names.conveyors[i]);
            conveyor.before_step(
                i,
                &mut self.engine,
                &input.outputs,
                time,
                self.settings.period,
                impaired,
            );
        }
        for (i, actuator) in self.actuators.iter_mut().enumerate() {
            let impaired = fault::of_machine(&self.faults, &self.names.actuators[i]);
            actuator.before_step(
                &mut self.engine,
                &input.outputs,
                self.settings.period,
                impaired,
            );
        }
        for source in &mut self.sources {
            source.before_step(
                &mut self.engine,
                &mut self.parts,
                &input.outputs,
                &before,
                time,
            );
        }
        self.arm.drive(&mut self.engine, input);
        self.feel_contacts(input);
        self.grip(input, Gripper::before_step);
        self.engine.step();
        for actuator in &mut self.actuators {
            actuator.after_step(&self.engine);
        }
        self.remove_parts();
        self.grip(input, Gripper::after_step);
        for detector in &mut self.detectors {
            detector.look(&self.engine, &self.parts);
        }
        self.output = self.border(input);
        fault::impair(
            &mut self.output.inputs,
            &before,
            &self.output.stuck,
            &self.output.open,
        );
        self.picture();
        &self.output
    }

    /// Simulated time since the start, s.
    pub fn time(&self) -> f64 {
        self.state.cycle as f64 * self.settings.period
    }

    /// The inputs that the world drives.
    pub fn driven_inputs(&self) -> PointSet {
        self.driven
    }

    /// What the last step gave to the cycle.
    pub fn output(&self) -> &WorldOutput {
        &self.output
    }

    /// Where the flange was in the last step; the identity before the first.
    pub fn base_from_flange(&self) -> &Pose {
        self.arm.motion.now()
    }

    /// What can be seen after the last step.
    pub fn state(&self) -> &WorldState {
        &self.state
    }

    /// Lets what obstacles do to held parts count.
    fn feel_contacts(&mut self, input: &WorldInput) {
        let share = 1.0 - elementary::exp(-self.settings.period / CONTACT_LAG);
        for (number, gripper) in self.grippers.iter().enumerate() {
            let felt = &mut self.touched_by[number];
            if gripper.hold().is_none() {
                *felt = Wrench::default();
            }
            let now = &input.held_contacts[number];
            felt.force += (now.force - felt.force) * share;
            felt.moment += (now.moment - felt.moment) * share;
        }
    }

    fn grip(&mut self, input: &WorldInput, what: fn(&mut Gripper, GripContext<'_>)) {
        for (number, gripper) in self.grippers.iter_mut().enumerate() {
            let held = gripper.hold().map(|hold| hold.part);
            what(
                gripper,
                GripContext {
                    engine: &mut self.engine,
                    parts: &mut self.parts,
                    motion: &self.arm.motion,
                    outputs: &input.outputs,
                    gripper: number,
                    touched_by: self.touched_by[number],
                    period: self.settings.period,
                    cycle: self.state.cycle,
                    leaks: fault::leaks(&self.faults, &self.names.grippers[number]),
                    drops: held.is_some_and(|part| self.drops.contains(&part)),
                },
            );
        }
    }

    /// Takes a part out of the world and out of its gripper.
    pub(crate) fn take_out(&mut self, number: PartNumber) -> Option<crate::parts::PartBody> {
        for gripper in &mut self.grippers {
            gripper.forget(number);
        }
        self.parts.remove(&mut self.engine, number)
    }

    /// Removes what is in a sink or far below.
    fn remove_parts(&mut self) {
        let mut from = 0;
        while let Some((number, sink)) = self.next_removed(from) {
            match sink {
                Some(sink) => {
                    self.state.sinks[sink] += 1;
                    self.take_out(number);
                }
                None => {
                    let lost = self.take_out(number);
                    self.state.lost_below.extend(lost.map(|part| part.name));
                }
            }
            from = number + 1;
        }
    }

    /// The first part from this number on that is in a sink, with the number of that, or far below.
    fn next_removed(&self, from: PartNumber) -> Option<(PartNumber, Option<usize>)> {
        if self.sinks.is_empty() && self.settings.floor.is_some() {
            return None;
        }
        self.parts.bodies.range(from..).find_map(|(number, part)| {
            // What sleeps has been looked at where it fell asleep.
            if self.engine.is_asleep(part.body) {
                return None;
            }
            let center = self.parts.center(&self.engine, part);
            let mut sinks = self.sinks.iter();
            let sink = sinks.position(|sink| is_inside(&sink.pose, &sink.size, &center));
            let is_lost = self.settings.floor.is_none() && center.z < LOST_BELOW;
            (sink.is_some() || is_lost).then_some((*number, sink))
        })
    }

    fn border(&self, input: &WorldInput) -> WorldOutput {
        let mut output = WorldOutput {
            cycle: input.cycle,
            ..WorldOutput::default()
        };
        let about = input.base_from_flange.translation;
        for collider in &self.arm.tool_colliders {
            add_touches(
                &mut output.tool_wrench,
                &self.engine.contacts(*collider),
                about,
            );
        }
        for (number, gripper) in self.grippers.iter().enumerate() {
            gripper.add_to_border(
                number,
                &self.engine,
                &self.parts,
                &self.arm.motion,
                &mut output,
            );
            gripper.report(&mut output.inputs);
        }
        for detector in &self.detectors {
            detector.report(&mut output.inputs);
        }
        for actuator in &self.actuators {
            actuator.report(&mut output.inputs);
        }
        for conveyor in &self.conveyors {
            if let Some(travel) = conveyor
                .plan
                .encoder
                .and_then(|e| output.encoder_travel.get_mut(usize::from(e)))
            {
                *travel = conveyor.state.travel;
            }
        }
        output.link_wrenches = self.arm.link_wrenches(&self.engine, input);
        (output.stuck, output.open) = fault::of_inputs(&self.faults);
        output
    }

    /// Brings the picture of the state up to date.
    pub(crate) fn picture(&mut self) {
        let (engine, state) = (&self.engine, &mut self.state);
        let bodies = &self.parts.bodies;
        let is_same = |(old, new): (&PartState, &PartBody)| Arc::ptr_eq(&old.name, &new.name);
        if state.parts.len() != bodies.len()
            || !state.parts.iter().zip(bodies.values()).all(is_same)
        {
            state.parts.clear();
            state
                .parts
                .extend(bodies.values().map(|part| part_state(engine, part)));
        }
        for (old, part) in state.parts.iter_mut().zip(bodies.values()) {
            // What sleeps stays as it was when it fell asleep, and that has been seen when it is at rest.
            let is_seen = old.held_by == part.gripper
                && engine.is_asleep(part.body)
                && old.velocity.is_zero();
            if !is_seen {
                update_part(old, engine, part);
            }
        }
        state
            .grippers
            .resize_with(self.grippers.len(), GripperState::default);
        for (state, gripper) in state.grippers.iter_mut().zip(&self.grippers) {
            gripper.update(state, &self.parts);
        }
        state.conveyors.clear();
        state
            .conveyors
            .extend(self.conveyors.iter().map(|conveyor| conveyor.state));
        state.sources.clear();
        state
            .sources
            .extend(self.sources.iter().map(|source| source.state));
        state.detectors.clear();
        state
            .detectors
            .extend(self.detectors.iter().map(|detector| detector.state));
        state.actuators.clear();
        state
            .actuators
            .extend(self.actuators.iter().map(|actuator| actuator.state));
        // Obstacles stand still, but for those that actuators move.
        if state.obstacles.len() != self.obstacles.len() {
            state.obstacles.clear();
            state
                .obstacles
                .extend(self.obstacles.iter().map(|body| engine.pose(*body)));
        }
        for actuator in &self.actuators {
            for (number, pose) in actuator.obstacle_poses(engine) {
                state.obstacles[number] = pose;
            }
        }
    }
}

fn part_state(engine: &Engine, part: &PartBody) -> PartState {
    let mut state = PartState {
        name: part.name.clone(),
        template: part.template,
        pose: Pose::IDENTITY,
        velocity: Twist::default(),
        held_by: None,
        touches_floor: false,
    };
    update_part(&mut state, engine, part);
    state
}

/// What changes of a part from cycle to cycle.
fn update_part(state: &mut PartState, engine: &Engine, part: &PartBody) {
    state.pose = engine.pose(part.body);
    state.velocity = engine.velocity(part.body);
    state.held_by = part.gripper;
    state.touches_floor =
        engine.is_near_one_of(part.collider, Owner::Floor, crate::orders::TOUCHING);
}
