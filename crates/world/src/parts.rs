//! The parts that are there: their bodies, names and templates.

use crate::description::{BodyShape, Mass, PartDescription, WorldDescription};
use crate::engine::{Engine, EngineShape, Material, PARTS};
use crate::materials::Owner;
use kinematics::{Pose, RigidBody};
use nalgebra::{Matrix3, Vector3};
use rapier3d_f64::dynamics::RigidBodyHandle;
use rapier3d_f64::geometry::ColliderHandle;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Number of a part, in the order of making. Never used twice.
pub(crate) type PartNumber = u32;

/// What parts of one table have in common.
#[derive(Clone, Debug)]
pub(crate) struct Template {
    pub(crate) name: Arc<str>,
    pub(crate) shape: BodyShape,
    pub(crate) solid: EngineShape,
    /// Mass properties in the frame of the part.
    pub(crate) mass: RigidBody,
    pub(crate) friction: f64,
    restitution: f64,
    /// How many have been made by sources and by order.
    made: u32,
    /// How many stand in the grid of the description; `None` for a single part.
    grid: Option<usize>,
    /// Whether a source has it as a template, so that it is not there by itself.
    is_for_sources: bool,
}

/// One part.
#[derive(Clone, Debug)]
pub(crate) struct PartBody {
    pub(crate) name: Arc<str>,
    pub(crate) template: usize,
    pub(crate) body: RigidBodyHandle,
    pub(crate) collider: ColliderHandle,
    /// The gripper that holds it.
    pub(crate) gripper: Option<usize>,
}

/// All parts.
#[derive(Clone, Debug, Default)]
pub(crate) struct PartTable {
    pub(crate) templates: Vec<Template>,
    pub(crate) bodies: BTreeMap<PartNumber, PartBody>,
    next: PartNumber,
}

impl PartTable {
    /// Templates of the description, and the parts that are there at the start.
    pub(crate) fn new(cell: &WorldDescription, engine: &mut Engine) -> Self {
        let mut parts = Self::default();
        for part in &cell.parts {
            parts.templates.push(Template {
                name: part.name.as_str().into(),
                shape: part.shape.clone(),
                solid: EngineShape::new(&part.shape),
                mass: mass_properties(part),
                friction: part.friction,
                restitution: part.restitution,
                made: 0,
                grid: part.copies.map(|c| c.count.iter().product()),
                is_for_sources: cell.sources.iter().any(|s| s.part == part.name),
            });
        }
        for (template, part) in cell.parts.iter().enumerate() {
            if parts.templates[template].is_for_sources {
                continue;
            }
            let Some(copies) = part.copies else {
                parts.add(engine, template, part.name.as_str().into(), &part.pose);
                continue;
            };
            let [nx, ny, nz] = copies.count;
            for i in 0..nx * ny * nz {
                let steps = [i % nx, i / nx % ny, i / (nx * ny)];
                let [x, y, z] = core::array::from_fn(|k| copies.pitch[k] * steps[k] as f64);
                let pose = part.pose * Pose::from_translation(x, y, z);
                parts.add(
                    engine,
                    template,
                    format!("{}[{i}]", part.name).into(),
                    &pose,
                );
            }
        }
        parts
    }

    /// Puts a part of a template into the world.
    pub(crate) fn add(
        &mut self,
        engine: &mut Engine,
        template: usize,
        name: Arc<str>,
        pose: &Pose,
    ) -> PartNumber {
        let number = self.next;
        self.next += 1;
        let of = &self.templates[template];
        let body = engine.add_free(pose);
        let material = Material {
            owner: Owner::Part(number, template as u32),
            friction: of.friction,
            restitution: of.restitution,
            group: PARTS,
        };
        let collider =
            engine.attach_prepared(body, &of.solid, &Pose::IDENTITY, of.mass.mass, material);
        let part = PartBody {
            name,
            template,
            body,
            collider,
            gripper: None,
        };
        self.bodies.insert(number, part);
        number
    }

    /// Puts the next numbered part of a template into the world: `name#1`, `name#2`, …
    pub(crate) fn make(&mut self, engine: &mut Engine, template: usize, pose: &Pose) -> PartNumber {
        self.templates[template].made += 1;
        let of = &self.templates[template];
        let name = format!("{}#{}", of.name, of.made).into();
        self.add(engine, template, name, pose)
    }

    pub(crate) fn remove(&mut self, engine: &mut Engine, number: PartNumber) -> Option<PartBody> {
        let part = self.bodies.remove(&number)?;
        engine.remove(part.body);
        Some(part)
    }

    pub(crate) fn by_name(&self, name: &str) -> Option<PartNumber> {
        self.bodies
            .iter()
            .find(|(_, part)| &*part.name == name)
            .map(|(number, _)| *number)
    }

    pub(crate) fn template(&self, name: &str) -> Option<usize> {
        self.templates.iter().position(|t| &*t.name == name)
    }

    /// Whether a part of this name is or was there.
    pub(crate) fn has_existed(&self, name: &str) -> bool {
        self.templates.iter().any(|t| {
            let Some(number) = name.strip_prefix(&*t.name) else {
                return false;
            };
            let is_made = number
                .strip_prefix('#')
                .and_then(|n| n.parse().ok())
                .is_some_and(|n: u32| n >= 1 && n <= t.made);
            let in_grid = number
                .strip_prefix('[')
                .and_then(|n| n.strip_suffix(']'))
                .and_then(|n| n.parse().ok());
            let is_first = match t.grid {
                None => number.is_empty(),
                Some(count) => in_grid.is_some_and(|n: usize| n < count),
            };
            is_made || is_first && !t.is_for_sources
        })
    }

    /// Centre of mass of a part, base frame.
    pub(crate) fn center(&self, engine: &Engine, part: &PartBody) -> Vector3<f64> {
        engine.pose(part.body).transform_point(self.mass(part).com)
    }

    /// Mass properties of a part in its own frame.
    pub(crate) fn mass(&self, part: &PartBody) -> RigidBody {
        self.templates[part.template].mass
    }
}

/// Of a uniform solid, in its frame.
fn mass_properties(part: &PartDescription) -> RigidBody {
    let about_middle = |volume: f64, squares: Vector3<f64>| {
        (volume, Vector3::zeros(), Matrix3::from_diagonal(&squares))
    };
    // Volume, centre, and inertia about it for each kilogram.
    let (volume, com, inertia) = match part.shape {
        BodyShape::Box { size: [x, y, z] } => {
            let [xx, yy, zz] = [x * x, y * y, z * z].map(|s| s / 12.0);
            about_middle(x * y * z, Vector3::new(yy + zz, xx + zz, xx + yy))
        }
        BodyShape::Cylinder { radius, length } => {
            let across = radius * radius / 4.0 + length * length / 12.0;
            let volume = core::f64::consts::PI * radius * radius * length;
            about_middle(volume, Vector3::new(across, across, radius * radius / 2.0))
        }
        BodyShape::Sphere { radius } => {
            let volume = 4.0 / 3.0 * core::f64::consts::PI * radius * radius * radius;
            about_middle(volume, Vector3::repeat(0.4 * radius * radius))
        }
        BodyShape::Mesh(ref mesh) => {
            let solid = mesh.solid();
            (
                solid.volume(),
                solid.centre(),
                solid.inertia() / solid.volume(),
            )
        }
        // Refused by the check: a half space has no mass.
        BodyShape::Plane => about_middle(0.0, Vector3::zeros()),
    };
    let mass = match part.mass {
        Mass::Total(mass) => mass,
        Mass::Density(density) => density * volume,
    };
    RigidBody {
        mass,
        com,
        inertia: inertia * mass,
    }
}
