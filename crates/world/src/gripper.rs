//! What both kinds of grippers have in common: what they see of the world, and what they tell it.

use crate::arm::{FlangeMotion, add_touches};
use crate::description::{Gripper as Plan, GripperKind};
use crate::engine::Engine;
use crate::fingers::FingerPair;
use crate::hold::Hold;
use crate::materials::Owner;
use crate::parts::{PartNumber, PartTable};
use crate::state::{FingerState, GripperState};
use crate::vacuum::Cups;
use kinematics::Wrench;
use motion_api::PointLevels;
use motion_api::{HeldPart, WorldOutput};
use nalgebra::Vector3;
use rapier3d_f64::dynamics::RigidBodyHandle;
use std::sync::Arc;

/// What a gripper works with in one cycle.
pub(crate) struct GripContext<'a> {
    pub(crate) engine: &'a mut Engine,
    pub(crate) parts: &'a mut PartTable,
    pub(crate) motion: &'a FlangeMotion,
    pub(crate) outputs: &'a PointLevels,
    /// Number of the gripper.
    pub(crate) gripper: usize,
    /// What obstacles do to the held part, about the origin of the flange, base axes.
    pub(crate) touched_by: Wrench,
    pub(crate) period: f64,
    pub(crate) cycle: u64,
    /// A fault takes nine tenths of pressure or force.
    pub(crate) leaks: bool,
    /// A fault makes it lose its part in this cycle.
    pub(crate) drops: bool,
}

impl GripContext<'_> {
    /// Friction between this gripper and a part: given for the pair, or the smaller one of the part's and the gripper's
    /// own.
    pub(crate) fn friction(&self, part: PartNumber, own: Option<f64>) -> f64 {
        let Some(of) = self.parts.bodies.get(&part) else {
            return 0.0;
        };
        let pair = self.engine.materials.pair_friction(
            Owner::Gripper(self.gripper as u32),
            Owner::Part(part, of.template as u32),
        );
        let smaller = self.parts.templates[of.template]
            .friction
            .min(own.unwrap_or(f64::INFINITY));
        pair.unwrap_or(smaller)
    }
}

/// A gripper on the flange.
#[derive(Clone, Debug)]
pub(crate) struct Gripper {
    pub(crate) kind: Kind,
    lost_in_cycle: u64,
}

#[derive(Clone, Debug)]
pub(crate) enum Kind {
    Cups(Box<Cups>),
    Fingers(Box<FingerPair>),
}

impl Gripper {
    pub(crate) fn new(
        plan: &Plan,
        index: usize,
        engine: &mut Engine,
        tool: RigidBodyHandle,
    ) -> Self {
        let kind = match &plan.kind {
            GripperKind::Vacuum(vacuum) => {
                Kind::Cups(Box::new(Cups::new(vacuum, index, engine, tool)))
            }
            GripperKind::Fingers(fingers) => {
                Kind::Fingers(Box::new(FingerPair::new(fingers, index, engine)))
            }
        };
        Self {
            kind,
            lost_in_cycle: 0,
        }
    }

    pub(crate) fn hold(&self) -> Option<&Hold> {
        match &self.kind {
            Kind::Cups(cups) => cups.hold.as_ref(),
            Kind::Fingers(fingers) => fingers.hold.as_ref(),
        }
    }

    /// Before the engine's step: decides whether the part stays, moves fingers, and lets both move with the flange.
    pub(crate) fn before_step(&mut self, mut context: GripContext<'_>) {
        let is_lost = match &mut self.kind {
            Kind::Cups(cups) => cups.hold_or_lose(&mut context),
            Kind::Fingers(fingers) => fingers.move_and_hold(&mut context),
        };
        if is_lost {
            self.lost_in_cycle = context.cycle;
        }
        let flange = *context.motion.now();
        if let Some(hold) = self.hold() {
            hold.drive(context.engine, context.parts, &flange);
        }
    }

    /// After the engine's step: takes what is there to take.
    pub(crate) fn after_step(&mut self, mut context: GripContext<'_>) {
        match &mut self.kind {
            Kind::Cups(cups) => cups.seal(&mut context),
            Kind::Fingers(fingers) => fingers.grip(&mut context),
        }
    }

    pub(crate) fn forget(&mut self, part: PartNumber) {
        match &mut self.kind {
            Kind::Cups(cups) => cups.forget(part),
            Kind::Fingers(fingers) => fingers.forget(part),
        }
    }

    pub(crate) fn report(&self, inputs: &mut PointLevels) {
        match &self.kind {
            Kind::Cups(cups) => cups.report(inputs),
            Kind::Fingers(fingers) => fingers.report(inputs),
        }
    }

    /// Brings what can be seen of the gripper up to date, in the memory that it has.
    pub(crate) fn update(&self, state: &mut GripperState, parts: &PartTable) {
        let part = self.hold().and_then(|hold| parts.bodies.get(&hold.part));
        let is_same = match (&state.holding, part) {
            (Some(old), Some(part)) => Arc::ptr_eq(old, &part.name),
            (None, None) => true,
            _ => false,
        };
        if !is_same {
            state.holding = part.map(|part| part.name.clone());
        }
        state.lost_in_cycle = self.lost_in_cycle;
        match &self.kind {
            Kind::Cups(cups) => {
                state.pressure = cups.pressure();
                state.sealed.clear();
                state.sealed.extend(cups.sealed());
                state.fingers = FingerState::Arrived;
            }
            Kind::Fingers(fingers) => {
                state.width = fingers.width();
                state.fingers = fingers.state();
            }
        }
    }

    /// Adds what the gripper and its part do to the flange.
    pub(crate) fn add_to_border(
        &self,
        number: usize,
        engine: &Engine,
        parts: &PartTable,
        motion: &FlangeMotion,
        output: &mut WorldOutput,
    ) {
        let about = motion.now().translation;
        let colliders = match &self.kind {
            Kind::Cups(cups) => &cups.colliders[..],
            Kind::Fingers(fingers) => fingers.colliders(),
        };
        for collider in colliders {
            add_touches(&mut output.tool_wrench, &engine.contacts(*collider), about);
        }
        let Some(hold) = self.hold() else { return };
        let Some(part) = parts.bodies.get(&hold.part) else {
            return;
        };
        add_touches(
            &mut output.tool_wrench,
            &engine.contacts(part.collider),
            about,
        );
        let center = *motion.now() * hold.flange_from_center();
        let support: Vector3<f64> = hold.support_force(engine, parts, motion);
        output.tool_wrench.force += support;
        output.tool_wrench.moment += (center.translation - about).cross(&support);
        let body = parts.mass(part).expressed_in(&hold.flange_from_part);
        output.held_body = output.held_body.joined_with(&body);
        if let Some(slot) = output.held_parts.get_mut(number) {
            *slot = Some(HeldPart {
                template: part.template as u16,
                flange_from_part: hold.flange_from_part,
                play: hold.play.into(),
            });
        }
    }
}
