//! A part that is fixed to the flange: what it needs to follow the arm, what still bears it, how it leaves.
//!
//! The part moves with the flange exactly. Cups and fingers decide by their laws whether they can give it the wrench
//! that it needs; that wrench follows from its mass, the motion of the flange, gravity and what touches it, not from
//! contacts with the gripper.

use crate::arm::{FlangeMotion, add_touches};
use crate::engine::{ARM, Engine, engine_pose};
use crate::parts::{PartNumber, PartTable};
use kinematics::{Pose, Wrench};
use nalgebra::Vector3;
use rapier3d_f64::geometry::{Group, InteractionGroups, InteractionTestMode};
use rapier3d_f64::pipeline::QueryFilter;

/// What bears a part bears less and less while it is lifted by this way, m.
const LIFT: f64 = 2e-4;
/// Up to this way nothing has been lifted yet, m.
const SLACK: f64 = 5e-5;
/// A part stands on something when that bears this share of its weight.
const STANDS: f64 = 0.3;
/// A part that was moved sideways by more than this may have left what it stood on, m.
const ASIDE: f64 = 1e-3;

/// A part on the flange.
#[derive(Clone, Debug)]
pub(crate) struct Hold {
    pub(crate) part: PartNumber,
    pub(crate) flange_from_part: Pose,
    /// Centre of mass in the frame of the part.
    center: Vector3<f64>,
    /// How far the part can be pushed back before the gripper bears on it, flange frame.
    pub(crate) play: Vector3<f64>,
    support: Option<Support>,
}

/// What bore the part when it was taken.
#[derive(Clone, Copy, Debug)]
struct Support {
    /// Against gravity, unit vector.
    up: Vector3<f64>,
    /// Where the origin of the part's frame was.
    origin: Vector3<f64>,
}

/// What a held part needs from its gripper, about its centre, base axes.
pub(crate) struct Need {
    /// Force and moment.
    pub(crate) wrench: Wrench,
    /// Whether the part still stands where it was taken: then it needs nothing, whatever the wrench says.
    pub(crate) stands: bool,
}

impl Hold {
    /// Takes a part out of the engine's hands.
    pub(crate) fn begin(
        engine: &mut Engine,
        parts: &mut PartTable,
        gripper: usize,
        part: PartNumber,
        flange: &Pose,
    ) -> Option<Self> {
        let body = parts.bodies.get_mut(&part)?;
        body.gripper = Some(gripper);
        let (handle, collider, template) = (body.body, body.collider, body.template);
        let mass = parts.templates[template].mass;
        let weight = engine.gravity() * mass.mass;
        let pose = engine.pose(handle);
        let mut borne = Wrench::default();
        add_touches(&mut borne, &engine.contacts(collider), pose.translation);
        let up = -weight.try_normalize(1e-9).unwrap_or_default();
        let stands = weight.norm() > 1e-9 && borne.force.dot(&up) > STANDS * weight.norm();
        engine.take(handle);
        Some(Self {
            part,
            flange_from_part: flange.inverse() * pose,
            center: mass.com,
            play: Vector3::zeros(),
            support: stands.then_some(Support {
                up,
                origin: pose.translation,
            }),
        })
    }

    /// Frame at the part's centre of mass, with the axes of the part.
    pub(crate) fn flange_from_center(&self) -> Pose {
        let center = self.flange_from_part.transform_point(self.center);
        Pose::new(self.flange_from_part.rotation, center)
    }

    /// Lets the flange come nearer to a part that still stands, by what play there is. A part that was lifted keeps its
    /// place.
    pub(crate) fn close_play(&mut self, motion: &FlangeMotion) {
        if self.support.is_none() {
            self.play = Vector3::zeros();
        }
        let Some(back) = self.play.try_normalize(1e-12) else {
            return;
        };
        let approach = -motion.step().dot(&back);
        let closing = back * kinematics::bounds::within(approach, 0.0, self.play.norm());
        self.flange_from_part.translation += closing;
        self.play -= closing;
    }

    /// Lets the part move with the flange in the coming step.
    pub(crate) fn drive(&self, engine: &mut Engine, parts: &PartTable, flange: &Pose) {
        if let Some(part) = parts.bodies.get(&self.part) {
            engine.drive(part.body, &(*flange * self.flange_from_part));
        }
    }

    /// Gives the part back to the engine with the speed it has, and `slip` (base axes) on top of that.
    pub(crate) fn end(
        self,
        engine: &mut Engine,
        parts: &mut PartTable,
        motion: &FlangeMotion,
        slip: Vector3<f64>,
    ) {
        if let Some(part) = parts.bodies.get_mut(&self.part) {
            part.gripper = None;
            let mut velocity = motion.velocity_before(&self.flange_from_center());
            velocity.linear += slip;
            engine.free(part.body, &velocity);
        }
    }

    /// What the part needs in this cycle. `touched_by` is what obstacles do to it, about the origin of the flange, base
    /// axes.
    pub(crate) fn need(
        &self,
        engine: &Engine,
        parts: &PartTable,
        motion: &FlangeMotion,
        touched_by: &Wrench,
    ) -> Need {
        let Some(part) = parts.bodies.get(&self.part) else {
            return Need {
                wrench: Wrench::default(),
                stands: true,
            };
        };
        let mass = parts.mass(part);
        let flange_from_center = self.flange_from_center();
        let pose = *motion.now() * flange_from_center;
        let (rate, turning) = motion.acceleration(&flange_from_center);
        let mut around = Wrench::default();
        add_touches(
            &mut around,
            &engine.contacts(part.collider),
            pose.translation,
        );
        let lever = motion.now().translation - pose.translation;
        around.force += touched_by.force + self.support_force(engine, parts, motion);
        around.moment += touched_by.moment + lever.cross(&touched_by.force);
        let inertia = pose.rotation.matrix() * mass.inertia * pose.rotation.matrix().transpose();
        let force = (rate.linear - engine.gravity()) * mass.mass - around.force;
        let moment = inertia * rate.angular + turning.cross(&(inertia * turning)) - around.moment;
        Need {
            wrench: Wrench { force, moment },
            stands: self.lift_in(motion).is_some_and(|lift| lift < SLACK),
        }
    }

    /// What still bears the part where the flange is now, N.
    pub(crate) fn support_force(
        &self,
        engine: &Engine,
        parts: &PartTable,
        motion: &FlangeMotion,
    ) -> Vector3<f64> {
        let (Some(support), Some(lift), Some(part)) = (
            self.support,
            self.lift_in(motion),
            parts.bodies.get(&self.part),
        ) else {
            return Vector3::zeros();
        };
        let share = kinematics::bounds::within(1.0 - (lift - SLACK) / (LIFT - SLACK), 0.0, 1.0);
        let weight = engine.gravity().norm() * parts.mass(part).mass;
        support.up * (weight * share)
    }

    /// How far the part was lifted since it was taken, m.
    fn lift_in(&self, motion: &FlangeMotion) -> Option<f64> {
        let pose = *motion.now() * self.flange_from_part;
        self.support
            .map(|support| (pose.translation - support.origin).dot(&support.up))
    }

    /// Forgets what bore the part once it is lifted, or has been moved to where nothing is below it.
    pub(crate) fn look_below(&mut self, engine: &Engine, parts: &PartTable) {
        let (Some(support), Some(part)) = (self.support, parts.bodies.get(&self.part)) else {
            return;
        };
        let pose = engine.pose(part.body);
        let way = pose.translation - support.origin;
        let lift = way.dot(&support.up);
        let is_aside = (way - support.up * lift).norm() > ASIDE;
        if lift > LIFT || is_aside && !self.has_something_below(engine, parts, &pose, support.up) {
            self.support = None;
        }
    }

    fn has_something_below(
        &self,
        engine: &Engine,
        parts: &PartTable,
        pose: &Pose,
        up: Vector3<f64>,
    ) -> bool {
        let Some(part) = parts.bodies.get(&self.part) else {
            return false;
        };
        let Some(collider) = engine.physics.colliders.get(part.collider) else {
            return false;
        };
        let lower = Pose::new(pose.rotation, pose.translation - up * (3.0 * LIFT));
        let all_but_arm =
            InteractionGroups::new(Group::ALL, Group::ALL & !ARM, InteractionTestMode::And);
        let filter = QueryFilter::new()
            .groups(all_but_arm)
            .exclude_rigid_body(part.body);
        let local = collider.position_wrt_parent().copied().unwrap_or_default();
        engine
            .physics
            .intersect_shape(engine_pose(&lower) * local, collider.shape(), filter)
            .next()
            .is_some()
    }
}
