//! Two parallel fingers: they move, push, stall on what is between them, hold it by friction, and let it slip.
//!
//! Distances to the part are found by rays from the inner faces, so a grip does not depend on the engine's contacts.
//! The two fingers are coupled: neither moves further than both can.

use crate::arm::add_touches;
use crate::description::{BodyShape, FingerControl, Fingers};
use crate::engine::{ARM, Engine, EngineShape, Material, our_vector, vector};
use crate::error::OrderError;
use crate::gripper::GripContext;
use crate::hold::Hold;
use crate::materials::Owner;
use crate::parts::{PartNumber, PartTable};
use crate::state::FingerState;
use kinematics::{Pose, Wrench};
use messages::{Text, text};
use motion_api::PointLevels;
use nalgebra::Vector3;
use rapier3d_f64::dynamics::RigidBodyHandle;
use rapier3d_f64::geometry::{BoundingVolume, ColliderHandle, Ray};

/// Rays along each edge of an inner face; odd, so that one is in the middle.
const RAYS: usize = 9;
/// A finger this near to a part touches it, m.
const TOUCH: f64 = 2e-4;
/// A part this far from a finger is no longer between them, m.
const APART: f64 = 1e-3;
/// Fingers this near to where they go are there, m.
const THERE: f64 = 1e-6;
/// Inputs tell open and closed within this, m.
const END: f64 = 1e-4;
/// A leaking gripper keeps this share of its force.
const LEAK: f64 = 0.1;

/// Where fingers are told to go, how fast and how hard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FingerOrder {
    /// Opening between the fingers, m.
    pub width: f64,
    /// Speed of each finger, m/s.
    pub speed: f64,
    /// Force of each finger, N.
    pub force: f64,
}

/// Fingers let go of a part that a fault takes out by this opening, m.
const DROP_GAP: f64 = 0.004;

/// A gripper with fingers.
#[derive(Clone, Debug)]
pub(crate) struct FingerPair {
    plan: Fingers,
    /// Unit vector to the positive side, flange frame.
    axis: Vector3<f64>,
    /// Each finger in the flange frame when closed, positive side first.
    closed: [Pose; 2],
    /// Inner faces, in the same order.
    faces: [InnerFace; 2],
    bodies: [RigidBodyHandle; 2],
    colliders: [ColliderHandle; 2],
    width: f64,
    order: FingerOrder,
    pub(crate) hold: Option<Hold>,
    /// Speed of the held part against the fingers, flange frame.
    slip: Vector3<f64>,
    state: FingerState,
    /// A part that a fault took out, until it is out of reach.
    dropped: Option<PartNumber>,
    is_placed: bool,
}

impl FingerPair {
    pub(crate) fn new(plan: &Fingers, index: usize, engine: &mut Engine) -> Self {
        let axis = plan.opening_direction();
        let shapes = plan.shapes();
        let closed = plan.poses(0.0);
        let faces = [0, 1].map(|side: usize| {
            let inwards = if side == 0 { -axis } else { axis };
            InnerFace::new(&shapes[side], closed[side].rotate_back(inwards))
        });
        let material = Material {
            owner: Owner::Gripper(index as u32),
            friction: plan.friction,
            restitution: 0.0,
            group: ARM,
        };
        let bodies = [0, 1].map(|_| engine.add_driven(&Pose::IDENTITY));
        let colliders = [0, 1].map(|side: usize| {
            engine.attach(bodies[side], &shapes[side], &Pose::IDENTITY, 0.0, material)
        });
        Self {
            axis,
            closed,
            faces,
            bodies,
            colliders,
            width: plan.stroke,
            order: FingerOrder {
                width: plan.stroke,
                speed: plan.speed,
                force: plan.force,
            },
            hold: None,
            slip: Vector3::zeros(),
            state: FingerState::Arrived,
            dropped: None,
            is_placed: false,
            plan: plan.clone(),
        }
    }

    /// Takes an order of a bus.
    pub(crate) fn order(&mut self, order: &FingerOrder) -> Result<(), OrderError> {
        let refuse = |argument, given: f64, allowed| {
            Err(OrderError::OutOfRange {
                argument,
                given: Text::verbatim(given.to_string()),
                allowed,
            })
        };
        let FingerOrder {
            width,
            speed,
            force,
        } = *order;
        if !(0.0..=self.plan.stroke).contains(&width) {
            return refuse("width", width, text!("0 up to the stroke", "0 到行程"));
        }
        if !(speed > 0.0 && speed <= self.plan.speed) {
            return refuse(
                "speed",
                speed,
                text!(
                    "more than 0, up to the gripper's speed",
                    "大于 0、不超过夹爪的速度"
                ),
            );
        }
        if !(force > 0.0 && force <= self.plan.force) {
            return refuse(
                "force",
                force,
                text!(
                    "more than 0, up to the gripper's force",
                    "大于 0、不超过夹爪的力"
                ),
            );
        }
        let lets_go = self.hold.is_some() && width > self.width + THERE;
        let goes = self.hold.is_none() && width != self.order.width;
        if lets_go || goes {
            self.state = FingerState::Moving;
        }
        self.order = *order;
        Ok(())
    }

    /// Where the outputs send the fingers.
    fn obey(&mut self, outputs: &PointLevels) {
        let FingerControl::Points { close, open } = self.plan.control else {
            return;
        };
        let level = |point: Option<_>| point.map(|p| outputs.level(p));
        self.order.width = match (level(close), level(open)) {
            (Some(true), _) | (None, Some(false)) => 0.0,
            (_, Some(true)) | (Some(false), None) => self.plan.stroke,
            _ => self.order.width,
        };
    }

    /// Before the engine's step. True when a part was lost.
    pub(crate) fn move_and_hold(&mut self, context: &mut GripContext<'_>) -> bool {
        let width_before = self.order.width;
        self.obey(context.outputs);
        let force = self.order.force * if context.leaks { LEAK } else { 1.0 };
        let way = 2.0 * self.order.speed * context.period;
        let mut is_lost = false;
        if self.hold.is_some() {
            if self.order.width > self.width + THERE {
                self.let_go(context, FingerState::Moving);
            } else {
                is_lost = self.slips_away(context, force);
            }
        }
        if self.hold.is_none() {
            if self.order.width != width_before {
                self.state = FingerState::Moving;
            }
            self.travel(context, way, force);
        }
        let flange = *context.motion.now();
        for (side, body) in self.bodies.into_iter().enumerate() {
            let pose = flange * self.finger(side);
            if !self.is_placed {
                context.engine.place(body, &pose);
            }
            context.engine.drive(body, &pose);
        }
        self.is_placed = true;
        is_lost
    }

    /// Where a finger is in the flange frame; 0 is the positive side.
    fn finger(&self, side: usize) -> Pose {
        let sign = if side == 0 { 0.5 } else { -0.5 };
        let closed = self.closed[side];
        Pose::new(
            closed.rotation,
            closed.translation + self.axis * (sign * self.width),
        )
    }

    /// Moves the fingers by up to `way` of opening, unless something resists with more than `force`.
    fn travel(&mut self, context: &GripContext<'_>, way: f64, force: f64) {
        let left = self.order.width - self.width;
        if let Some(part) = self.dropped {
            if left < 0.0 && self.gaps(context, part).is_some() {
                return;
            }
            self.dropped = None;
        }
        if left.abs() < THERE {
            if self.state == FingerState::Moving {
                self.state = FingerState::Arrived;
            }
            return;
        }
        if self.resistance(context.engine, context.motion.now(), left) > force {
            let stalled = if left < 0.0 {
                FingerState::GrippingInside
            } else {
                FingerState::BlockedOpening
            };
            self.pass_into(stalled);
            return;
        }
        let mut change = kinematics::bounds::within(left, -way, way);
        if change < 0.0 {
            let room = self
                .parts_between(context)
                .map(|(_, gaps)| gaps[0] + gaps[1])
                .fold(f64::INFINITY, f64::min);
            change = change.max(-room.max(0.0));
        }
        self.width += change;
        self.pass_into(FingerState::Moving);
    }

    /// That a part was lost stays true until another order or a grip.
    fn pass_into(&mut self, state: FingerState) {
        if self.state != FingerState::Lost {
            self.state = state;
        }
    }

    /// The larger one of the forces that parts put against the motion of the two fingers, N.
    fn resistance(&self, engine: &Engine, flange: &Pose, left: f64) -> f64 {
        let outwards = flange.rotate(self.axis);
        let against = |side: usize| {
            let mut sum = Wrench::default();
            add_touches(
                &mut sum,
                &engine.contacts(self.colliders[side]),
                Vector3::zeros(),
            );
            let sign = if (side == 0) == (left < 0.0) {
                1.0
            } else {
                -1.0
            };
            sum.force.dot(&outwards) * sign
        };
        against(0).max(against(1))
    }

    /// Free parts that both inner faces look at, with the gap of each face.
    fn parts_between<'a>(
        &'a self,
        context: &'a GripContext<'_>,
    ) -> impl Iterator<Item = (PartNumber, [f64; 2])> + 'a {
        let free = context
            .parts
            .bodies
            .iter()
            .filter(|(_, part)| part.gripper.is_none());
        free.filter_map(|(number, _)| Some((*number, self.gaps(context, *number)?)))
    }

    fn gaps(&self, context: &GripContext<'_>, part: PartNumber) -> Option<[f64; 2]> {
        let flange = context.motion.now();
        let gap = |side| self.gap(context.engine, context.parts, flange, side, part);
        Some([gap(0)?, gap(1)?])
    }

    /// Distance from the inner face of a finger to a part along the axis, m; negative when the part is in the finger.
    fn gap(
        &self,
        engine: &Engine,
        parts: &PartTable,
        flange: &Pose,
        side: usize,
        part: PartNumber,
    ) -> Option<f64> {
        let collider = engine
            .physics
            .colliders
            .get(parts.bodies.get(&part)?.collider)?;
        let finger = *flange * self.finger(side);
        let inwards = flange.rotate(self.axis) * if side == 0 { -1.0 } else { 1.0 };
        let face = &self.faces[side];
        let middle = vector(finger.transform_point(face.middle));
        if !collider
            .compute_aabb()
            .loosened(self.plan.stroke + face.reach)
            .contains_local_point(middle)
        {
            return None;
        }
        let mut nearest: Option<f64> = None;
        for FaceRay { origin, depth } in &face.rays {
            let ray = Ray::new(vector(finger.transform_point(*origin)), vector(inwards));
            if let Some(distance) =
                collider
                    .shape()
                    .cast_ray(collider.position(), &ray, depth + self.plan.stroke, true)
            {
                let gap = distance - depth;
                nearest = Some(nearest.map_or(gap, |n| n.min(gap)));
            }
        }
        nearest
    }

    /// Lets the part slip where friction does not bear what it needs. True when it is lost by that, or by a fault.
    fn slips_away(&mut self, context: &mut GripContext<'_>, force: f64) -> bool {
        let Some(hold) = &self.hold else { return false };
        if context.drops {
            self.dropped = Some(hold.part);
            let wide = self.width + DROP_GAP;
            self.width = kinematics::bounds::within(wide, 0.0, self.plan.stroke);
            self.let_go(context, FingerState::Lost);
            return true;
        }
        let need = hold.need(
            context.engine,
            context.parts,
            context.motion,
            &context.touched_by,
        );
        let flange = *context.motion.now();
        let needed = flange.rotate_back(need.wrench.force);
        let across = needed - self.axis * needed.dot(&self.axis);
        let friction = 2.0 * context.friction(hold.part, Some(self.plan.friction)) * force;
        let mass = context
            .parts
            .bodies
            .get(&hold.part)
            .map_or(1.0, |part| context.parts.mass(part).mass);
        let is_slipping = self.slip.norm() > 0.0;
        if !is_slipping && (need.stands || across.norm() <= friction) {
            return false;
        }
        let against = if is_slipping {
            self.slip.normalize()
        } else {
            -across.normalize()
        };
        let change = (-across - against * friction) / mass * context.period;
        let mut slip = self.slip + change;
        if context.touched_by.force.norm() > friction {
            // A contact pushes the part back as fast as the flange presses it on, and no faster.
            let (pressing, slipping) = (
                context.motion.step().norm() / context.period,
                self.slip.norm(),
            );
            slip = slip.cap_magnitude(if pressing > slipping {
                pressing
            } else {
                slipping
            });
        }
        // Friction stops the part where it would turn it around.
        let sticks = is_slipping && slip.dot(&self.slip) <= 0.0 && across.norm() <= friction;
        self.slip = if sticks { Vector3::zeros() } else { slip };
        let way = self.slip * context.period;
        if let Some(hold) = &mut self.hold {
            hold.flange_from_part.translation += way;
        }
        let is_lost = !self.is_between(context);
        if is_lost {
            self.let_go(context, FingerState::Lost);
        }
        is_lost
    }

    /// Whether both fingers still reach the held part where it will be after the step.
    fn is_between(&self, context: &GripContext<'_>) -> bool {
        let Some(hold) = &self.hold else { return false };
        let Some(part) = context.parts.bodies.get(&hold.part) else {
            return false;
        };
        // The part's collider is where it was before the step: seen from there, the flange is moved back.
        let flange = context.engine.pose(part.body) * hold.flange_from_part.inverse();
        [0, 1].iter().all(|side| {
            let gap = self.gap(context.engine, context.parts, &flange, *side, hold.part);
            gap.is_some_and(|gap| gap < APART)
        })
    }

    fn let_go(&mut self, context: &mut GripContext<'_>, state: FingerState) {
        if let Some(hold) = self.hold.take() {
            let slip = context.motion.now().rotate(self.slip);
            hold.end(context.engine, context.parts, context.motion, slip);
        }
        self.slip = Vector3::zeros();
        self.state = state;
    }

    /// After the engine's step: takes a part that both fingers touch.
    pub(crate) fn grip(&mut self, context: &mut GripContext<'_>) {
        if let Some(hold) = &mut self.hold {
            hold.look_below(context.engine, context.parts);
            return;
        }
        if context.drops || self.order.width >= self.width {
            return;
        }
        let touches = |gaps: &[f64; 2]| gaps[0] + gaps[1] < TOUCH;
        let found = self
            .parts_between(context)
            .find(|(part, gaps)| self.dropped != Some(*part) && touches(gaps))
            .map(|(part, _)| part);
        if let Some(part) = found {
            let flange = *context.motion.now();
            self.hold = Hold::begin(
                context.engine,
                context.parts,
                context.gripper,
                part,
                &flange,
            );
            self.slip = Vector3::zeros();
            self.state = FingerState::GrippingInside;
        }
    }

    pub(crate) fn width(&self) -> f64 {
        self.width
    }

    pub(crate) fn state(&self) -> FingerState {
        self.state
    }

    pub(crate) fn colliders(&self) -> &[ColliderHandle] {
        &self.colliders
    }

    pub(crate) fn report(&self, inputs: &mut PointLevels) {
        let grips = matches!(
            self.state,
            FingerState::GrippingInside | FingerState::BlockedOpening
        );
        let tells = [
            (self.plan.opened, self.width >= self.plan.stroke - END),
            (self.plan.closed, self.width <= END && self.hold.is_none()),
            (self.plan.gripping, grips),
        ];
        for (point, level) in tells {
            if let Some(point) = point {
                inputs.set_level(point, level);
            }
        }
    }

    /// Forgets a part that was taken out of the world.
    pub(crate) fn forget(&mut self, part: PartNumber) {
        if self.hold.as_ref().is_some_and(|hold| hold.part == part) {
            self.hold = None;
            self.slip = Vector3::zeros();
            self.state = FingerState::Lost;
        }
    }
}

/// The side of a finger that looks at the other one, as rays that go out of it; in the frame of the finger.
#[derive(Clone, Debug)]
struct InnerFace {
    /// Middle of the finger.
    middle: Vector3<f64>,
    /// How far a place of the finger can be from its middle, m, at most.
    reach: f64,
    rays: Vec<FaceRay>,
}

/// A ray from inside or behind a finger through its inner face.
#[derive(Clone, Debug)]
struct FaceRay {
    origin: Vector3<f64>,
    /// Way from the origin to the face, m.
    depth: f64,
}

impl InnerFace {
    /// `inwards` is a unit vector towards the other finger.
    fn new(shape: &BodyShape, inwards: Vector3<f64>) -> Self {
        let EngineShape { solid, turn, .. } = EngineShape::new(shape);
        let around = solid.compute_aabb(&turn);
        let (middle, half) = (
            our_vector(around.center()),
            our_vector(around.half_extents()),
        );
        // The edge of the box that lies along the axis is the depth, the others span the face.
        let depth_axis = inwards.iamax();
        let across = [(depth_axis + 1) % 3, (depth_axis + 2) % 3];
        let share = |i: usize| (2.0 * i as f64 / (RAYS - 1) as f64 - 1.0) * (1.0 - 1e-6);
        let far = half.norm() + TOUCH;
        let rays = (0..RAYS * RAYS).filter_map(|i| {
            let mut origin = middle;
            origin[across[0]] += share(i % RAYS) * half[across[0]];
            origin[across[1]] += share(i / RAYS) * half[across[1]];
            let depth = match shape {
                BodyShape::Box { .. } => half[depth_axis],
                // Where a ray meets no finger, there is no face.
                _ => {
                    let back = Ray::new(vector(origin + inwards * far), vector(-inwards));
                    far - solid.cast_ray(&turn, &back, 2.0 * far, true)?
                }
            };
            Some(FaceRay { origin, depth })
        });
        Self {
            middle,
            reach: half.sum(),
            rays: rays.collect(),
        }
    }
}
