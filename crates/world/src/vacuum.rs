//! Suction cups: sealing, pressure, and whether they still hold.

use crate::cup_sharing::{CupLimit, can_bear};
use crate::description::{BodyShape, Vacuum};
use crate::engine::{ARM, Engine, Material, engine_pose, our_vector, vector};
use crate::gripper::GripContext;
use crate::hold::Hold;
use crate::materials::Owner;
use crate::parts::{PartNumber, PartTable};
use kinematics::{Pose, elementary};
use nalgebra::{Rotation3, Unit, UnitQuaternion, Vector3};
use rapier3d_f64::dynamics::RigidBodyHandle;
use rapier3d_f64::geometry::{BoundingVolume, ColliderHandle, Ray};

/// Points of a rim that have to lie on the face.
const RIM_POINTS: usize = 8;
/// Cosine of the largest angle between the axis of a cup and the face under its rim.
const FLATNESS: f64 = 0.85;
/// Time constant of the pressure while a cup blows off, s: nothing is left after 25 ms.
const BLOW_OFF: f64 = 0.005;
/// A cup with this share of the pump's pressure and a closed valve has come off.
const COME_OFF: f64 = 0.01;
/// A leaking gripper keeps this share of its pressure.
const LEAK: f64 = 0.1;

/// A gripper with cups.
#[derive(Clone, Debug)]
pub(crate) struct Cups {
    plan: Vacuum,
    /// Axis of the cups, flange frame.
    axis: Vector3<f64>,
    /// Frame of each rim in the flange frame, z along the axis.
    rims: Vec<Pose>,
    cups: Vec<Cup>,
    pub(crate) hold: Option<Hold>,
    /// A part that came off, which the cups do not take again before they have been off or away from it.
    came_off: Option<PartNumber>,
    pub(crate) colliders: Vec<ColliderHandle>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Cup {
    seals: bool,
    /// Pa below ambient.
    pressure: f64,
}

impl Cups {
    pub(crate) fn new(
        plan: &Vacuum,
        index: usize,
        engine: &mut Engine,
        tool: RigidBodyHandle,
    ) -> Self {
        let axis = Unit::new_normalize(Vector3::from(plan.direction));
        let turn = UnitQuaternion::rotation_between(&Vector3::z(), &axis);
        // Without a rotation between them the two directions are opposite.
        let turn = turn.map_or_else(
            || Rotation3::from_axis_angle(&Vector3::x_axis(), core::f64::consts::PI),
            Rotation3::from,
        );
        let rims: Vec<_> = plan
            .cups
            .iter()
            .map(|at| Pose::new(turn, Vector3::from(*at)))
            .collect();
        let length = plan.radius;
        let material = Material {
            owner: Owner::Gripper(index as u32),
            friction: 0.5,
            restitution: 0.0,
            group: ARM,
        };
        let bodies = rims.iter().map(|rim| {
            let solid = BodyShape::Cylinder {
                radius: plan.radius,
                length,
            };
            engine.attach(
                tool,
                &solid,
                &(*rim * Pose::from_translation(0.0, 0.0, -length / 2.0)),
                0.0,
                material,
            )
        });
        let colliders = bodies.collect();
        Self {
            plan: plan.clone(),
            axis: *axis,
            cups: vec![Cup::default(); rims.len()],
            rims,
            hold: None,
            came_off: None,
            colliders,
        }
    }

    /// Before the engine's step: pressures, and whether the part is still held. True when it was lost.
    pub(crate) fn hold_or_lose(&mut self, context: &mut GripContext<'_>) -> bool {
        let on = context.outputs.level(self.plan.on) && !self.blows(context);
        let target = self.plan.pressure * if context.leaks { LEAK } else { 1.0 };
        let (goal, constant) = match on {
            true => (target, self.plan.build_up),
            false if self.blows(context) => (0.0, BLOW_OFF),
            false => (0.0, self.plan.decay),
        };
        let rest = elementary::exp(-context.period / constant);
        for cup in self.cups.iter_mut().filter(|cup| cup.seals) {
            cup.pressure = goal + (cup.pressure - goal) * rest;
            if !on && cup.pressure < COME_OFF * self.plan.pressure {
                *cup = Cup::default();
            }
        }
        if !on {
            self.came_off = None;
        }
        if let Some(hold) = &mut self.hold {
            hold.close_play(context.motion);
        }
        let Some(hold) = &self.hold else { return false };
        let no_cup_seals = !self.cups.iter().any(|cup| cup.seals);
        let need = hold.need(
            context.engine,
            context.parts,
            context.motion,
            &context.touched_by,
        );
        let is_lost = !need.stands && !can_bear(&self.limits(hold, context), &need.wrench);
        if no_cup_seals || is_lost || context.drops {
            self.let_go(context);
        }
        !no_cup_seals && (is_lost || context.drops)
    }

    fn blows(&self, context: &GripContext<'_>) -> bool {
        self.plan
            .blow_off
            .is_some_and(|point| context.outputs.level(point))
    }

    /// What the sealed cups can bear, about the centre of the part, base axes.
    fn limits(&self, hold: &Hold, context: &GripContext<'_>) -> Vec<CupLimit> {
        let friction = context.friction(hold.part, None);
        let flange = context.motion.now();
        let center = (*flange * hold.flange_from_center()).translation;
        let area = core::f64::consts::PI * self.plan.radius * self.plan.radius;
        let sealed = self
            .cups
            .iter()
            .zip(&self.rims)
            .filter(|(cup, _)| cup.seals);
        let limits = sealed.map(|(cup, rim)| {
            let pull = cup.pressure * area;
            CupLimit {
                lever: flange.transform_point(rim.translation) - center,
                axis: flange.rotate(self.axis),
                pull,
                shear: friction * pull,
                moment: pull * self.plan.radius,
            }
        });
        limits.collect()
    }

    fn let_go(&mut self, context: &mut GripContext<'_>) {
        if let Some(hold) = self.hold.take() {
            self.came_off = Some(hold.part);
            hold.end(
                context.engine,
                context.parts,
                context.motion,
                Vector3::zeros(),
            );
        }
        self.cups.fill(Cup::default());
    }

    /// After the engine's step: which cups seal now.
    pub(crate) fn seal(&mut self, context: &mut GripContext<'_>) {
        if let Some(hold) = &mut self.hold {
            hold.look_below(context.engine, context.parts);
        }
        let on = context.outputs.level(self.plan.on) && !self.blows(context);
        if self
            .came_off
            .is_some_and(|part| !self.is_near(context, part))
        {
            self.came_off = None;
        }
        if !on {
            return;
        }
        for i in 0..self.cups.len() {
            if self.cups[i].seals {
                continue;
            }
            let rim = *context.motion.now() * self.rims[i];
            let mut free = context
                .parts
                .bodies
                .iter()
                .filter(|(number, part)| match &self.hold {
                    Some(hold) => hold.part == **number,
                    None => part.gripper.is_none() && self.came_off != Some(**number),
                });
            let under_rim = free.find_map(|(number, _)| {
                let gap = self.gap_to(context.engine, context.parts, &rim, *number)?;
                Some((*number, gap))
            });
            let Some((part, gap)) = under_rim else {
                continue;
            };
            if self.hold.is_none() {
                let flange = *context.motion.now();
                self.hold = Hold::begin(
                    context.engine,
                    context.parts,
                    context.gripper,
                    part,
                    &flange,
                );
                if let Some(hold) = &mut self.hold {
                    hold.play = -self.axis * gap;
                }
            }
            self.cups[i].seals = self.hold.is_some();
        }
    }

    fn is_near(&self, context: &GripContext<'_>, part: PartNumber) -> bool {
        let flange = context.motion.now();
        self.rims.iter().any(|rim| {
            let rim = *flange * *rim;
            self.gap_to(context.engine, context.parts, &rim, part)
                .is_some()
        })
    }

    /// The widest gap between a rim and the face of the part that it lies on, m; `None` where it does not lie on one
    /// face within reach.
    fn gap_to(
        &self,
        engine: &Engine,
        parts: &PartTable,
        rim: &Pose,
        part: PartNumber,
    ) -> Option<f64> {
        let body = parts.bodies.get(&part)?;
        let collider = engine.physics.colliders.get(body.collider)?;
        let center = engine_pose(rim).translation;
        let reach = self.plan.reach + 2.0 * self.plan.radius;
        let around = collider.compute_aabb().loosened(reach);
        if !around.contains_local_point(center) {
            return None;
        }
        // The rays begin behind the rim: a rim that is pressed on a little seals as well.
        let behind = self.plan.radius.min(0.005);
        let axis = rim.rotate(Vector3::z());
        let mut widest = 0.0_f64;
        for k in 0..RIM_POINTS {
            let (sin, cos) =
                elementary::sin_cos(core::f64::consts::TAU * k as f64 / RIM_POINTS as f64);
            let radius = self.plan.radius * (1.0 - 1e-6);
            let at = rim.transform_point(Vector3::new(radius * cos, radius * sin, -behind));
            let ray = Ray::new(vector(at), vector(axis));
            let hit = collider.shape().cast_ray_and_get_normal(
                collider.position(),
                &ray,
                behind + self.plan.reach,
                false,
            );
            let hit = hit.filter(|hit| -our_vector(hit.normal).dot(&axis) > FLATNESS)?;
            widest = widest.max(hit.time_of_impact - behind);
        }
        Some(widest)
    }

    /// Largest pressure of the sealed cups, Pa below ambient.
    pub(crate) fn pressure(&self) -> f64 {
        self.cups
            .iter()
            .filter(|cup| cup.seals)
            .map(|cup| cup.pressure)
            .fold(0.0, f64::max)
    }

    pub(crate) fn sealed(&self) -> impl Iterator<Item = bool> {
        self.cups.iter().map(|cup| cup.seals)
    }

    /// Tells switch and gauge.
    pub(crate) fn report(&self, inputs: &mut motion_api::PointLevels) {
        let pressure = self.pressure();
        if let Some(point) = self.plan.switch {
            inputs.set_level(point, pressure >= self.plan.threshold * self.plan.pressure);
        }
        if let Some(point) = self.plan.gauge {
            inputs.set_ratio(point, pressure / self.plan.pressure);
        }
    }

    /// Forgets a part that was taken out of the world.
    pub(crate) fn forget(&mut self, part: PartNumber) {
        if self.hold.as_ref().is_some_and(|hold| hold.part == part) {
            self.hold = None;
            self.cups.fill(Cup::default());
        }
    }
}
