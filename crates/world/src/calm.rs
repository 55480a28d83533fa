//! Whether nothing can hit anything in the coming step: then few passes of the solver do.
//!
//! The solver begins each step with the forces of the last one. Where bodies lie, or ride on a belt, these are right
//! already, and further passes change nothing. They are for what the forces of the last step do not know: hits, pushes,
//! and bodies that speed up or slow down.

use crate::engine::PREDICTION;
use rapier3d_f64::dynamics::{RigidBody, RigidBodyHandle};
use rapier3d_f64::geometry::ContactPair;
use rapier3d_f64::math::Vector;
use rapier3d_f64::parry::query;
use rapier3d_f64::pipeline::PhysicsWorld;

/// A body whose velocity has changed by less than this in the last step is carried by steady forces, m/s; the same for
/// the speed that its rotation gives to a point 0.1 m away.
const STEADY: f64 = 1e-3;
/// Rotation speed that stands for a speed, rad/s for each m/s.
const TURNING: f64 = 10.0;
/// Bodies that touch and come towards each other by less than this do not hit each other, m/s.
const APPROACH: f64 = 5e-3;
/// The share of the distance up to which contacts are found that two bodies without one may come nearer in a step
/// without being looked at. The contacts known here are those at the beginning of the last step: two steps must leave a
/// gap, also if the arm speeds up.
const SHARE: f64 = 0.4;
/// A gap that is this many times the way of a step is not closed in one.
const STEPS: f64 = 2.0;

/// Velocities of the awake free bodies at the end of the step before the last one, in the engine's order.
#[derive(Clone, Debug, Default)]
pub(crate) struct VelocitiesBefore(Vec<(RigidBodyHandle, Vector, Vector)>);

impl VelocitiesBefore {
    /// Whether the coming step is one without hits. Asked before each step, because it also notes the velocities.
    pub(crate) fn is_calm(&mut self, physics: &PhysicsWorld) -> bool {
        let mut is_calm = true;
        let mut known = 0;
        for handle in physics.islands.active_bodies() {
            let Some(body) = physics.bodies.get(handle) else {
                continue;
            };
            if body.is_dynamic() {
                let now = (handle, body.linvel(), body.angvel());
                match self.0.get_mut(known) {
                    Some(before) => {
                        is_calm &= before.0 == handle
                            && (before.1 - now.1).length() < STEADY
                            && (before.2 - now.2).length() < STEADY * TURNING;
                        *before = now;
                    }
                    None => {
                        is_calm = false;
                        self.0.push(now);
                    }
                }
                known += 1;
            }
            is_calm = is_calm && cannot_hit(physics, body);
        }
        self.0.truncate(known);
        is_calm
    }
}

/// Whether an awake body cannot hit anything in the coming step.
fn cannot_hit(physics: &PhysicsWorld, body: &RigidBody) -> bool {
    let pairs = body
        .colliders()
        .iter()
        .flat_map(|collider| physics.contact_pairs_with(*collider));
    let reach = SHARE * PREDICTION / physics.integration_parameters.dt;
    pairs.into_iter().all(|pair| {
        let parent = |collider| {
            let collider = physics.colliders.get(collider)?;
            physics.bodies.get(collider.parent()?)
        };
        let (Some(a), Some(b)) = (parent(pair.collider1), parent(pair.collider2)) else {
            return false;
        };
        // Among bodies that do not move by themselves there are no forces.
        if !a.is_dynamic() && !b.is_dynamic() {
            return true;
        }
        let is_far = pair.manifolds().iter().all(|m| m.points.is_empty());
        match is_far {
            true => {
                let speed = speed_bound(a) + speed_bound(b);
                let way = speed * physics.integration_parameters.dt;
                speed < reach || has_gap(physics, pair, STEPS * way)
            }
            false => !is_driven(a) && !is_driven(b) && !approaches(physics, pair, a, b),
        }
    })
}

/// A body that pushes: its motion is given, or a joint drives it.
fn is_driven(body: &RigidBody) -> bool {
    let moves = body.is_kinematic() && body.position() != body.next_position();
    // Only bodies that a joint drives do without gravity.
    moves || body.is_moving() && body.is_dynamic() && body.gravity_scale() == 0.0
}

/// No point of a body within a metre of its centre is faster, m/s.
fn speed_bound(body: &RigidBody) -> f64 {
    body.linvel().length() + body.angvel().length()
}

/// Whether two colliders are farther from each other than a distance.
fn has_gap(physics: &PhysicsWorld, pair: &ContactPair, distance: f64) -> bool {
    let colliders = &physics.colliders;
    let (Some(a), Some(b)) = (colliders.get(pair.collider1), colliders.get(pair.collider2)) else {
        return false;
    };
    let gap = query::distance(a.position(), a.shape(), b.position(), b.shape());
    gap.is_ok_and(|gap| gap.distance > distance)
}

/// Whether two bodies come towards each other at any point where they touch.
fn approaches(physics: &PhysicsWorld, pair: &ContactPair, a: &RigidBody, b: &RigidBody) -> bool {
    let Some(collider) = physics.colliders.get(pair.collider1) else {
        return true;
    };
    pair.manifolds().iter().any(|manifold| {
        let piece = manifold.subshape_pos1().copied().unwrap_or_default();
        manifold.points.iter().any(|point| {
            let at = collider.position() * (piece * point.local_p1);
            let apart = b.velocity_at_point(at) - a.velocity_at_point(at);
            -apart.dot(manifold.data.normal) > APPROACH
        })
    })
}
