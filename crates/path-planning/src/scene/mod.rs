//! The arm among what stands around it: which pairs count, how far they are apart, and how fast that can change.
//!
//! Bodies move with the arm: the capsules of the links, the tool, what is held. Obstacles do not, but who knows the
//! cell may move them, hang them on the flange and take them away at any time ([`CollisionScene::set_place`]).

mod body;
mod motion_bound;
mod pair;

use kinematics::{Frames, JointPositions, Pose, RobotModel};
use messages::{Text, text};

pub use body::LINK_NAMES;
pub use pair::{Pair, TouchRule, fits_pattern};

use crate::shape::{PlacedShape, Shape};
use crate::solid::Solid;
use body::{Body, BodyOwner};
use pair::PairPartner;

/// Radius of the ball that touches when no tool is given, m. Its foremost point is the TCP.
const TCP_BALL: f64 = 0.001;

/// Number of an obstacle of a scene, in the order in which they were added.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ObstacleId(usize);

/// Where an obstacle is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ObstaclePlace {
    /// A standing obstacle: its pose in the base frame.
    Standing(Pose),
    /// An obstacle that hangs on the flange and moves with the arm: its pose in the flange frame.
    Held(Pose),
    /// An obstacle that is not in the cell at the moment.
    Absent,
}

/// What may be touched: an obstacle, a part, a moving piece of a machine.
#[derive(Clone, Debug)]
struct Obstacle {
    name: Text,
    pieces: Vec<PlacedShape>,
    place: ObstaclePlace,
    /// The pieces in the base frame while it stands.
    solids: Vec<Solid>,
    /// The way that its points have moved at most since the scene was made, m.
    travel: f64,
}

/// Two things, and the distance between their surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairDistance {
    /// Distance, m; negative ones are depths.
    pub distance: f64,
    /// The pair.
    pub pair: Pair,
}

/// The solids of everything that moves with the arm, at one set of joint positions. Belongs to the scene that placed
/// it.
#[derive(Clone, Debug, Default)]
pub struct PlacedArm {
    solids: Vec<Solid>,
}

/// An arm with its tool among obstacles.
#[derive(Clone, Debug)]
pub struct CollisionScene {
    model: RobotModel,
    tool: Vec<PlacedShape>,
    flange_from_tcp: Pose,
    obstacles: Vec<Obstacle>,
    touches: Vec<TouchRule>,
    bodies: Vec<Body>,
    pairs: Vec<Pair>,
    revision: u64,
}

impl CollisionScene {
    /// An arm with the convex pieces of a tool in the flange frame; without any a ball of a millimetre at the TCP
    /// touches.
    pub fn new(
        model: RobotModel,
        tool: impl IntoIterator<Item = PlacedShape>,
        flange_from_tcp: Pose,
    ) -> Self {
        let mut scene = Self {
            model,
            tool: tool.into_iter().collect(),
            flange_from_tcp,
            obstacles: Vec::new(),
            touches: Vec::new(),
            bodies: Vec::new(),
            pairs: Vec::new(),
            revision: 0,
        };
        scene.rebuild();
        scene
    }

    /// Adds an obstacle of convex pieces, which are placed in its frame.
    pub fn add_obstacle(
        &mut self,
        name: impl Into<String>,
        pieces: Vec<PlacedShape>,
        place: ObstaclePlace,
    ) -> ObstacleId {
        let mut obstacle = Obstacle {
            name: Text::verbatim(name.into()),
            pieces,
            place,
            solids: Vec::new(),
            travel: 0.0,
        };
        obstacle.update_solids();
        self.obstacles.push(obstacle);
        self.rebuild();
        ObstacleId(self.obstacles.len() - 1)
    }

    /// Lets some pairs touch: they are left out of every distance.
    pub fn allow_touches(&mut self, rules: impl IntoIterator<Item = TouchRule>) {
        self.touches.extend(rules);
        self.rebuild();
    }

    /// Sets the TCP, where the arm without a tool touches.
    pub fn set_tcp(&mut self, flange_from_tcp: Pose) {
        if self.flange_from_tcp != flange_from_tcp {
            self.flange_from_tcp = flange_from_tcp;
            if self.tool.is_empty() {
                self.rebuild();
            }
        }
    }

    /// The TCP in the flange frame.
    pub const fn flange_from_tcp(&self) -> &Pose {
        &self.flange_from_tcp
    }

    /// Moves an obstacle, hangs it on the flange, or takes it away.
    pub fn set_place(&mut self, id: ObstacleId, place: ObstaclePlace) {
        let Some(obstacle) = self.obstacles.get_mut(id.0) else {
            return;
        };
        if obstacle.place == place {
            return;
        }
        let before = std::mem::replace(&mut obstacle.place, place);
        if let (ObstaclePlace::Standing(from), ObstaclePlace::Standing(to)) = (before, place) {
            obstacle.travel += motion_bound::of_poses(&from, &to, obstacle.reach());
            obstacle.update_solids();
        } else {
            obstacle.update_solids();
            self.rebuild();
        }
    }

    /// Where an obstacle is.
    pub fn place(&self, id: ObstacleId) -> Option<ObstaclePlace> {
        self.obstacles.get(id.0).map(|obstacle| obstacle.place)
    }

    /// The obstacle of a name.
    pub fn obstacle(&self, name: &str) -> Option<ObstacleId> {
        let is_named = |obstacle: &Obstacle| obstacle.name == name;
        self.obstacles.iter().position(is_named).map(ObstacleId)
    }

    /// The names of all obstacles.
    pub fn obstacle_names(&self) -> impl Iterator<Item = &str> {
        self.obstacles
            .iter()
            .map(|obstacle| obstacle.name.english())
    }

    /// The arm.
    pub const fn model(&self) -> &RobotModel {
        &self.model
    }

    /// Every pair that counts.
    pub fn pairs(&self) -> &[Pair] {
        &self.pairs
    }

    /// Changes when the list of pairs does.
    pub const fn revision(&self) -> u64 {
        self.revision
    }

    /// Places everything that moves with the arm; `arm` is a place to keep it, used again and again.
    pub fn place_arm(&self, q: &JointPositions, arm: &mut PlacedArm) {
        self.place_arm_at(&self.model.forward(q), arm);
    }

    fn place_arm_at(&self, frames: &Frames, arm: &mut PlacedArm) {
        arm.solids.clear();
        let solids = self.bodies.iter().map(|body| body.solid(frames));
        arm.solids.extend(solids);
    }

    /// The distance of a pair, m.
    pub fn distance(&self, pair: Pair, arm: &PlacedArm) -> f64 {
        let body = &arm.solids[pair.body];
        match pair.partner {
            PairPartner::Body(other) => body.distance(&arm.solids[other]),
            PairPartner::Obstacle(ObstacleId(number)) => {
                let mut least = f64::INFINITY;
                for solid in &self.obstacles[number].solids {
                    if body.least_distance(solid) < least {
                        least = least.min(body.distance(solid));
                    }
                }
                least
            }
        }
    }

    /// A number that the distance of a pair is not below, m. Quick to compute.
    pub fn least_distance(&self, pair: Pair, arm: &PlacedArm) -> f64 {
        let body = &arm.solids[pair.body];
        match pair.partner {
            PairPartner::Body(other) => body.least_distance(&arm.solids[other]),
            PairPartner::Obstacle(ObstacleId(number)) => {
                let bounds = self.obstacles[number].solids.iter();
                let bounds = bounds.map(|solid| body.least_distance(solid));
                bounds.fold(f64::INFINITY, f64::min)
            }
        }
    }

    /// The pair that is nearest to each other at `q`, deepest in each other; `None` where nothing can touch.
    pub fn nearest(&self, q: &JointPositions) -> Option<PairDistance> {
        let mut arm = PlacedArm::default();
        self.place_arm(q, &mut arm);
        self.nearest_of(&arm)
    }

    /// The pair that is nearest to each other where the arm has been placed.
    pub fn nearest_of(&self, arm: &PlacedArm) -> Option<PairDistance> {
        let mut nearest: Option<PairDistance> = None;
        for &pair in &self.pairs {
            let bound = self.least_distance(pair, arm);
            if nearest.is_none_or(|found| bound < found.distance) {
                let distance = self.distance(pair, arm);
                if nearest.is_none_or(|found| distance < found.distance) {
                    nearest = Some(PairDistance { distance, pair });
                }
            }
        }
        nearest
    }

    /// What the two of a pair are called: first what moves with the arm.
    pub fn names(&self, pair: Pair) -> (&str, &str) {
        let first = self.body_name(pair.body);
        match pair.partner {
            PairPartner::Body(other) => (first, self.body_name(other)),
            PairPartner::Obstacle(ObstacleId(number)) => {
                (first, self.obstacles[number].name.english())
            }
        }
    }

    /// What the two bodies of a pair are called in sentences.
    pub fn texts(&self, pair: Pair) -> (Text, Text) {
        let of_body = |body: usize| match self.bodies[body].owner {
            BodyOwner::Link(link) => body::link_text(link),
            BodyOwner::Tool => text!("tool", "工具"),
            BodyOwner::Held(number) => self.obstacles[number].name.clone(),
        };
        let second = match pair.partner {
            PairPartner::Body(other) => of_body(other),
            PairPartner::Obstacle(ObstacleId(number)) => self.obstacles[number].name.clone(),
        };
        (of_body(pair.body), second)
    }

    fn body_name(&self, body: usize) -> &str {
        self.owner_name(self.bodies[body].owner)
    }

    fn owner_name(&self, owner: BodyOwner) -> &str {
        match owner {
            BodyOwner::Link(link) => LINK_NAMES[link],
            BodyOwner::Tool => "tool",
            BodyOwner::Held(number) => self.obstacles[number].name.english(),
        }
    }

    /// Makes bodies and pairs again, after something that decides about them has changed.
    fn rebuild(&mut self) {
        self.bodies = self.make_bodies();
        self.pairs = self.make_pairs();
        self.revision += 1;
    }

    fn make_bodies(&self) -> Vec<Body> {
        let mut bodies = Body::of_links(&self.model);
        let tcp_ball = self.tool.is_empty().then(|| PlacedShape {
            pose: self.flange_from_tcp * Pose::from_translation(0.0, 0.0, -TCP_BALL),
            shape: Shape::Sphere { radius: TCP_BALL },
        });
        for piece in self.tool.iter().cloned().chain(tcp_ball) {
            bodies.push(Body::on_flange(BodyOwner::Tool, piece, &self.model));
        }
        for (number, obstacle) in self.obstacles.iter().enumerate() {
            let ObstaclePlace::Held(flange_from_part) = obstacle.place else {
                continue;
            };
            for piece in &obstacle.pieces {
                let piece = PlacedShape {
                    pose: flange_from_part * piece.pose,
                    shape: piece.shape.clone(),
                };
                bodies.push(Body::on_flange(BodyOwner::Held(number), piece, &self.model));
            }
        }
        bodies
    }
}

impl Obstacle {
    fn update_solids(&mut self) {
        self.solids.clear();
        if let ObstaclePlace::Standing(pose) = &self.place {
            let solids = self.pieces.iter();
            let solids = solids.map(|piece| Solid::of_shape(piece, pose));
            self.solids.extend(solids);
        }
    }

    /// How far from the origin of its frame it reaches, m.
    fn reach(&self) -> f64 {
        let of =
            |piece: &PlacedShape| piece.pose.translation.norm() + piece.shape.bounding_radius();
        self.pieces.iter().map(of).fold(0.0, f64::max)
    }
}
