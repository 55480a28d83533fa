//! Whose a collider is, friction of pairs, and surfaces that move: what the engine asks for every contact.

use crate::description::WorldDescription;
use crate::engine::{our_vector, vector};
use nalgebra::Vector3;
use rapier3d_f64::pipeline::{ActiveHooks, ContactModificationContext, PhysicsHooks};
use std::collections::{BTreeMap, BTreeSet};

/// Whose a collider is. `thing` is the number of its entry in the description, for friction: see [`Materials::thing`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Owner {
    /// The floor.
    Floor,
    /// An obstacle.
    Obstacle(u32),
    /// A part, by its number, and the number of its template.
    Part(u32, u32),
    /// A link of the arm.
    Link(u32),
    /// The tool.
    Tool,
    /// A gripper.
    Gripper(u32),
    /// A conveyor.
    Conveyor(u32),
}

impl Owner {
    pub(crate) fn to_number(self) -> u128 {
        let (kind, a, b) = match self {
            Self::Floor => (0, 0, 0),
            Self::Obstacle(i) => (1, i, 0),
            Self::Part(id, template) => (2, id, template),
            Self::Link(i) => (3, i, 0),
            Self::Tool => (4, 0, 0),
            Self::Gripper(i) => (5, i, 0),
            Self::Conveyor(i) => (6, i, 0),
        };
        kind << 64 | u128::from(a) << 32 | u128::from(b)
    }

    pub(crate) fn from_number(number: u128) -> Self {
        let (a, b) = ((number >> 32) as u32, number as u32);
        match number >> 64 {
            1 => Self::Obstacle(a),
            2 => Self::Part(a, b),
            3 => Self::Link(a),
            4 => Self::Tool,
            5 => Self::Gripper(a),
            6 => Self::Conveyor(a),
            _ => Self::Floor,
        }
    }

    /// The entry of the description, which all copies of a part share.
    fn entry(self) -> u128 {
        match self {
            Self::Part(_, template) => Self::Part(0, template).to_number(),
            other => other.to_number(),
        }
    }
}

/// How a conveyor's surface moves beyond what its body does, base frame.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SurfaceMotion {
    /// Velocity of a belt, m/s.
    pub(crate) linear: Vector3<f64>,
    /// Middle of a turntable, m.
    pub(crate) center: Vector3<f64>,
    /// Speed towards the middle per distance from it, 1/s: the step goes along the tangent of the circle, and this
    /// brings parts back to it.
    pub(crate) contraction: f64,
}

/// What the engine asks for the contacts of pairs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Materials {
    pairs: BTreeMap<(u128, u128), f64>,
    entries: BTreeSet<u128>,
    pub(crate) surfaces: Vec<SurfaceMotion>,
}

impl Materials {
    pub(crate) fn new(cell: &WorldDescription) -> Self {
        let owner = |name: &str| -> Option<Owner> {
            let position = |found: Option<usize>| found.map(|i| i as u32);
            position(cell.parts.iter().position(|p| p.name == name))
                .map(|i| Owner::Part(0, i))
                .or_else(|| {
                    position(cell.obstacles.iter().position(|o| o.name == name))
                        .map(Owner::Obstacle)
                })
                .or_else(|| {
                    position(cell.grippers.iter().position(|g| g.name == name)).map(Owner::Gripper)
                })
                .or_else(|| {
                    position(cell.conveyors.iter().position(|c| c.name == name))
                        .map(Owner::Conveyor)
                })
                .or((name == crate::check::FLOOR).then_some(Owner::Floor))
        };
        let mut materials = Self {
            surfaces: vec![SurfaceMotion::default(); cell.conveyors.len()],
            ..Self::default()
        };
        for pair in &cell.frictions {
            if let (Some(a), Some(b)) = (owner(&pair.a), owner(&pair.b)) {
                materials.pairs.insert(sorted(a, b), pair.value);
                materials.entries.extend([a.entry(), b.entry()]);
            }
        }
        materials
    }

    /// The coefficient given for two things, if one is.
    pub(crate) fn pair_friction(&self, a: Owner, b: Owner) -> Option<f64> {
        self.pairs.get(&sorted(a, b)).copied()
    }

    /// What the engine has to ask for a collider. Contacts that are asked for cost more, so only those with something
    /// to say are.
    pub(crate) fn hooks(&self, owner: Owner) -> ActiveHooks {
        match matches!(owner, Owner::Conveyor(_)) || self.entries.contains(&owner.entry()) {
            true => ActiveHooks::MODIFY_SOLVER_CONTACTS,
            false => ActiveHooks::empty(),
        }
    }
}

fn sorted(a: Owner, b: Owner) -> (u128, u128) {
    let (a, b) = (a.entry(), b.entry());
    (a.min(b), a.max(b))
}

impl PhysicsHooks for Materials {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext<'_>) {
        let owner = |collider| {
            context
                .colliders
                .get(collider)
                .map_or(Owner::Floor, |c| Owner::from_number(c.user_data))
        };
        let (a, b) = (owner(context.collider1), owner(context.collider2));
        let pair = self.pair_friction(a, b);
        let Some(manifold) = context.rigid_mut() else {
            return;
        };
        if let Some(friction) = pair {
            *manifold.friction = friction;
        }
        let normal = our_vector(*manifold.normal);
        for (side, owner) in [(1.0, a), (-1.0, b)] {
            let Owner::Conveyor(index) = owner else {
                continue;
            };
            let Some(motion) = self.surfaces.get(index as usize) else {
                continue;
            };
            for contact in manifold.solver_contacts.iter_mut() {
                let at = our_vector((contact.anchor1 + contact.anchor2) * 0.5);
                let velocity = motion.linear - (at - motion.center) * motion.contraction;
                // Only what lies along the face moves: the ends of a belt do not push.
                let along = velocity - normal * velocity.dot(&normal);
                contact.tangent_velocity += vector(along * side);
            }
        }
    }
}
