//! What the arm can touch, where it does, and with what force.
//!
//! Obstacles stand still in the base frame. The tool touches them (its shape, or a ball of a millimetre at the TCP),
//! and the links with their capsules. Geometry is in `solid` and `nearest`, forces are in `law`; the plant applies
//! them. Nothing here allocates after the start. What is done about obstacles side by side is in `among`, about deep
//! ones in `entry`.

mod among;
mod entry;
mod held;
pub(crate) mod law;
mod near;
mod nearest;
pub mod solid;
#[cfg(test)]
mod test_bodies;
#[cfg(test)]
mod tests;

use kinematics::{
    Chain, CollisionModel, DOF, Frames, JointPositions, JointSpeeds, Pose, RobotModel,
};
use nalgebra::Vector3;

use entry::{EntryFaces, Probe};
use held::HeldParts;
use law::ContactForces;
pub use law::RIGID_STIFFNESS;
use near::BroadPhase;
use nearest::ContactPoint;
pub use solid::{PlacedShape, Shape};

/// Radius of the ball that touches when no tool is given, m. Its foremost point is the TCP.
pub const TCP_BALL: f64 = 0.001;

/// Gaps up to this are looked at: what a point can cross within a step of the servo, m.
const MARGIN: f64 = 0.006;

/// Most places at which the arm touches at once; of more the shallowest are left out.
pub(crate) const MAX_CONTACTS: usize = 24;

/// Something in the cell that the arm can hit.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    /// For messages.
    pub name: String,
    /// In the base frame.
    pub solid: PlacedShape,
    /// Obstacles with the same number are convex pieces of one body and share its stiffness; `None` for a body of one
    /// piece.
    pub body: Option<usize>,
    /// N/m; `None` is hard.
    pub stiffness: Option<f64>,
    /// N s/m, against going deeper and against coming back.
    pub damping: f64,
    /// Coulomb's coefficient.
    pub friction: f64,
}

/// What stands around the arm, and the tool on its flange.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Environment {
    /// What can be hit.
    pub obstacles: Vec<Obstacle>,
    /// Convex pieces of the tool, in the flange frame. Without any a ball at the TCP touches.
    pub tool: Vec<PlacedShape>,
    /// Convex pieces of what grippers may hold, in the part's frame, by number of the template.
    pub part_shapes: Vec<Vec<PlacedShape>>,
}

impl Environment {
    /// The links (1 to 6) that stand in an obstacle when the arm is at `home`, with the index of the obstacle. They
    /// never touch it: a table drawn through the foot of the arm must not throw the arm out.
    pub fn links_inside_obstacles(
        &self,
        model: &RobotModel,
        home: &JointPositions,
    ) -> Vec<(usize, usize)> {
        let frames = model.forward(home);
        let mut pairs = Vec::new();
        for (number, obstacle) in self.obstacles.iter().enumerate() {
            for link in 1..=DOF {
                let mut is_inside = false;
                for capsule in model.collision().capsules_in_base(link, &frames) {
                    nearest::capsule(&capsule, &obstacle.solid, 0.0, &mut |place| {
                        is_inside |= !is_beyond_flange(link, &place, &frames);
                    });
                }
                if is_inside {
                    pairs.push((link, number));
                }
            }
        }
        pairs
    }
}

/// The last link ends at the flange; its capsule is rounder than that.
fn is_beyond_flange(link: usize, place: &ContactPoint, frames: &Frames) -> bool {
    let flange = &frames.base_from_flange;
    link == DOF && flange.rotate_back(place.point - flange.translation).z > 0.0
}

/// A part of the arm that touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ArmPart {
    /// Link that moves with this joint, from 0.
    Link(usize),
    /// Beyond the flange: felt by the force sensor.
    Tool,
    /// The part in the gripper of this number, felt as the tool is.
    Held(usize),
}

impl ArmPart {
    /// The joint it moves with, from 0.
    pub(crate) const fn link(self) -> usize {
        match self {
            Self::Link(link) => link,
            Self::Tool | Self::Held(_) => DOF - 1,
        }
    }
}

/// One place where a part touches an obstacle, or will within the step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contact {
    pub part: ArmPart,
    /// Index of the obstacle.
    pub obstacle: usize,
    pub place: ContactPoint,
}

/// All contacts of a cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactList {
    touches: [Contact; MAX_CONTACTS],
    len: usize,
}

impl ContactList {
    fn new() -> Self {
        let nothing = Contact {
            part: ArmPart::Tool,
            obstacle: 0,
            place: ContactPoint {
                point: Vector3::zeros(),
                normal: Vector3::zeros(),
                depth: 0.0,
            },
        };
        Self {
            touches: [nothing; MAX_CONTACTS],
            len: 0,
        }
    }

    pub(crate) fn as_slice(&self) -> &[Contact] {
        &self.touches[..self.len]
    }

    fn push(&mut self, touch: Contact) {
        if self.len < MAX_CONTACTS {
            self.touches[self.len] = touch;
            self.len += 1;
            return;
        }
        let depth = |t: &Contact| t.place.depth;
        let shallowest = self
            .touches
            .iter_mut()
            .min_by(|a, b| depth(a).total_cmp(&depth(b)));
        if let Some(shallowest) = shallowest
            && depth(shallowest) < depth(&touch)
        {
            *shallowest = touch;
        }
    }
}

/// The arm among obstacles.
#[derive(Debug)]
pub(crate) struct ContactModel {
    pub obstacles: Vec<Obstacle>,
    tool: Vec<PlacedShape>,
    links: CollisionModel,
    chain: Chain,
    /// Links and obstacles that never touch.
    excluded_pairs: Vec<(usize, usize)>,
    entry_faces: EntryFaces,
    broad_phase: BroadPhase,
    held: HeldParts,
}

impl ContactModel {
    /// `home` is where the arm stands at the start.
    pub(crate) fn new(
        surroundings: Environment,
        model: &RobotModel,
        home: &JointPositions,
    ) -> Self {
        let links = model.collision();
        let pieces = surroundings.tool.iter();
        let tool_extent = pieces.map(PlacedShape::extent).fold(TCP_BALL, f64::max);
        let extents = core::array::from_fn(|part| match part {
            0..DOF => links.bounding_radius(part + 1),
            DOF => tool_extent,
            _ => 0.0,
        });
        Self {
            excluded_pairs: surroundings.links_inside_obstacles(model, home),
            entry_faces: EntryFaces::new(),
            broad_phase: BroadPhase::new(surroundings.obstacles.len(), extents),
            held: HeldParts::new(surroundings.part_shapes, surroundings.obstacles.len()),
            obstacles: surroundings.obstacles,
            tool: surroundings.tool,
            links: model.collision().clone(),
            chain: *model.chain(),
        }
    }

    /// The arm's frames at `q`.
    pub(crate) fn forward(&self, q: &JointPositions) -> Frames {
        self.chain.forward(q)
    }

    /// True when there is nothing to touch.
    pub(crate) fn is_empty(&self) -> bool {
        self.obstacles.is_empty()
    }

    /// Forces on an arm that is at `q` and moves with `qd` whatever they are.
    pub(crate) fn forces_at(
        &mut self,
        q: &JointPositions,
        qd: &JointSpeeds,
        flange_from_tcp: &Pose,
    ) -> ContactForces {
        if self.is_empty() {
            return ContactForces::NONE;
        }
        let frames = self.chain.forward(q);
        let touches = self.find_contacts(&frames, flange_from_tcp);
        let tcp = (frames.base_from_flange * *flange_from_tcp).translation;
        law::solve(&touches, &self.obstacles, &frames, tcp, qd, None)
    }

    /// Where the arm touches or nearly touches.
    pub(crate) fn find_contacts(&mut self, frames: &Frames, flange_from_tcp: &Pose) -> ContactList {
        let mut touches = ContactList::new();
        if self.is_empty() {
            return touches;
        }
        self.entry_faces.update(frames);
        self.broad_phase.update(frames, flange_from_tcp);
        for link in 0..DOF {
            self.touches_of_link(link, frames, &mut touches);
        }
        self.touches_of_tool(&frames.base_from_flange, flange_from_tcp, &mut touches);
        self.touches_of_held_parts(&frames.base_from_flange, &mut touches);
        touches
    }

    /// `link` moves with that joint, from 0.
    fn touches_of_link(&mut self, link: usize, frames: &Frames, touches: &mut ContactList) {
        let Self {
            obstacles,
            links,
            excluded_pairs: apart,
            entry_faces: entries,
            broad_phase: near,
            ..
        } = self;
        near.check_due_pairs(link, |number| {
            if apart.contains(&(link + 1, number)) {
                return f64::INFINITY;
            }
            let solid = &obstacles[number].solid;
            let mut gap = f64::INFINITY;
            for capsule in links.capsules_in_base(link + 1, frames) {
                let away = nearest::capsule_gap(&capsule, solid);
                gap = gap.min(away - MARGIN);
                if away > MARGIN {
                    continue;
                }
                nearest::capsule(&capsule, solid, MARGIN, &mut |place| {
                    if is_beyond_flange(link + 1, &place, frames) {
                        return;
                    }
                    let part = ArmPart::Link(link);
                    let radius = capsule.radius;
                    let center = place.point + place.normal * radius;
                    let ball = Probe {
                        part,
                        center,
                        radius,
                    };
                    touches.push(Contact {
                        part,
                        obstacle: number,
                        place: entries.reorient_to_entry_face(&ball, number, obstacles, place),
                    });
                });
            }
            gap
        });
    }

    fn touches_of_tool(
        &mut self,
        base_from_flange: &Pose,
        flange_from_tcp: &Pose,
        touches: &mut ContactList,
    ) {
        let Self {
            obstacles,
            tool,
            entry_faces: entries,
            broad_phase: near,
            ..
        } = self;
        let tcp_ball = tool.is_empty().then(|| {
            let tcp = *base_from_flange * *flange_from_tcp;
            let center = tcp.transform_point(Vector3::new(0.0, 0.0, -TCP_BALL));
            PlacedShape {
                pose: Pose::from_translation(center.x, center.y, center.z),
                shape: Shape::Sphere { radius: TCP_BALL },
            }
        });
        near.check_due_pairs(DOF, |obstacle| {
            let mut gap_of = |piece: &PlacedShape| {
                touches_of_tool_piece(piece, obstacle, obstacles, entries, touches)
            };
            match &tcp_ball {
                Some(ball) => gap_of(ball),
                None => tool
                    .iter()
                    .map(|piece| gap_of(&piece.expressed_in(base_from_flange)))
                    .fold(f64::INFINITY, f64::min),
            }
        });
    }
}

/// Where a piece of the tool, in the base frame, touches an obstacle. Gives how wide the gap beyond the margin is at
/// least, m.
fn touches_of_tool_piece(
    piece: &PlacedShape,
    obstacle: usize,
    obstacles: &[Obstacle],
    entries: &mut EntryFaces,
    touches: &mut ContactList,
) -> f64 {
    let part = ArmPart::Tool;
    let solid = &obstacles[obstacle].solid;
    let mut push = |place| {
        touches.push(Contact {
            part,
            obstacle,
            place,
        });
    };
    if let Shape::Sphere { radius } = piece.shape {
        let center = piece.pose.translation;
        let gap = solid.distance(center).0 - radius - MARGIN;
        let place = among::ball((center, radius), obstacle, obstacles, MARGIN, entries);
        return place.map_or(gap, |place| {
            push(place);
            0.0
        });
    }
    nearest::solid(piece, solid, MARGIN, &mut |place, feature| {
        push(entries.reorient_feature(part, feature, obstacle, obstacles, place));
    }) - MARGIN
}
