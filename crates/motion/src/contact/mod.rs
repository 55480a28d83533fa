//! What the arm can touch, where it does, and with what force.
//!
//! Obstacles stand still in the base frame. The tool touches them (its shape, or a ball of a millimetre at the TCP), and
//! the links with their capsules. Geometry is in `solid` and `nearest`, forces are in `law`; the plant applies them. Nothing here
//! allocates after the start. What is done about obstacles side by side is in `among`, about deep ones in `entry`.

mod among;
mod entry;
pub(crate) mod law;
mod near;
mod nearest;
pub mod solid;

use kinematics::{
    Chain, CollisionModel, DOF, Frames, JointPositions, JointSpeeds, Pose, RobotModel,
};
use nalgebra::Vector3;

use entry::Entries;
use law::ContactForces;
pub use law::HARD;
use near::Near;
use nearest::Place;
pub use solid::{Shape, Solid};

/// Radius of the ball that touches when no tool is given, m. Its foremost point is the TCP.
pub const TCP_BALL: f64 = 0.001;

/// Gaps up to this are looked at: what a point can cross within a step of the servo, m.
const MARGIN: f64 = 0.006;

/// Most places at which the arm touches at once; of more the shallowest are left out.
pub(crate) const TOUCHES_MAX: usize = 24;

/// Something in the cell that the arm can hit.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    /// For messages.
    pub name: String,
    /// In the base frame.
    pub solid: Solid,
    /// N/m; `None` is hard.
    pub stiffness: Option<f64>,
    /// N s/m, against going deeper and against coming back.
    pub damping: f64,
    /// Coulomb's coefficient.
    pub friction: f64,
}

/// What stands around the arm, and the tool on its flange.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surroundings {
    /// What can be hit.
    pub obstacles: Vec<Obstacle>,
    /// The tool, in the flange frame. Without it a ball at the TCP touches.
    pub tool: Option<Solid>,
}

impl Surroundings {
    /// The links (1 to 6) that stand in an obstacle when the arm is at `home`, with the index of the obstacle. They never
    /// touch it: a table drawn through the foot of the arm must not throw the arm out.
    pub fn standing_in(&self, model: &RobotModel, home: &JointPositions) -> Vec<(usize, usize)> {
        let frames = model.forward(home);
        let mut pairs = Vec::new();
        for (number, obstacle) in self.obstacles.iter().enumerate() {
            for link in 1..=DOF {
                let mut is_inside = false;
                for capsule in model.collision().placed(link, &frames) {
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
fn is_beyond_flange(link: usize, place: &Place, frames: &Frames) -> bool {
    let flange = &frames.base_from_flange;
    link == DOF && flange.rotate_back(place.point - flange.translation).z > 0.0
}

/// A part of the arm that touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// Link that moves with this joint, from 0.
    Link(usize),
    /// Beyond the flange: felt by the force sensor.
    Tool,
}

impl Part {
    /// The joint it moves with, from 0.
    pub(crate) const fn link(self) -> usize {
        match self {
            Self::Link(link) => link,
            Self::Tool => DOF - 1,
        }
    }
}

/// One place where a part touches an obstacle, or will within the step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touch {
    pub part: Part,
    /// Index of the obstacle.
    pub obstacle: usize,
    pub place: Place,
}

/// All of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touches {
    touches: [Touch; TOUCHES_MAX],
    len: usize,
}

impl Touches {
    fn new() -> Self {
        let nothing = Touch {
            part: Part::Tool,
            obstacle: 0,
            place: Place {
                point: Vector3::zeros(),
                normal: Vector3::zeros(),
                depth: 0.0,
            },
        };
        Self {
            touches: [nothing; TOUCHES_MAX],
            len: 0,
        }
    }

    pub(crate) fn as_slice(&self) -> &[Touch] {
        &self.touches[..self.len]
    }

    fn push(&mut self, touch: Touch) {
        if self.len < TOUCHES_MAX {
            self.touches[self.len] = touch;
            self.len += 1;
            return;
        }
        let depth = |t: &Touch| t.place.depth;
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
#[derive(Clone, Debug)]
pub(crate) struct Contacts {
    pub obstacles: Vec<Obstacle>,
    tool: Option<Solid>,
    links: CollisionModel,
    chain: Chain,
    /// Links and obstacles that never touch.
    apart: Vec<(usize, usize)>,
    entries: Entries,
    near: Near,
}

impl Contacts {
    /// `home` is where the arm stands at the start.
    pub(crate) fn new(
        surroundings: Surroundings,
        model: &RobotModel,
        home: &JointPositions,
    ) -> Self {
        let links = model.collision();
        let extents = core::array::from_fn(|part| match &surroundings.tool {
            Some(tool) if part == DOF => tool.pose.translation.norm() + tool.reach(),
            None if part == DOF => TCP_BALL,
            _ => links.extent(part + 1),
        });
        Self {
            apart: surroundings.standing_in(model, home),
            entries: Entries::new(surroundings.obstacles.len()),
            near: Near::new(surroundings.obstacles.len(), extents),
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
    pub(crate) fn pressed(
        &mut self,
        q: &JointPositions,
        qd: &JointSpeeds,
        flange_from_tcp: &Pose,
    ) -> ContactForces {
        if self.is_empty() {
            return ContactForces::NONE;
        }
        let frames = self.chain.forward(q);
        let touches = self.touches(&frames, flange_from_tcp);
        let tcp = (frames.base_from_flange * *flange_from_tcp).translation;
        law::solve(&touches, &self.obstacles, &frames, tcp, qd, None)
    }

    /// Where the arm touches or nearly touches.
    pub(crate) fn touches(&mut self, frames: &Frames, flange_from_tcp: &Pose) -> Touches {
        let mut touches = Touches::new();
        if self.is_empty() {
            return touches;
        }
        self.entries.begin(frames);
        self.near.begin(frames, flange_from_tcp);
        for link in 0..DOF {
            self.touches_of_link(link, frames, &mut touches);
        }
        self.touches_of_tool(&frames.base_from_flange, flange_from_tcp, &mut touches);
        touches
    }

    /// `link` moves with that joint, from 0.
    fn touches_of_link(&mut self, link: usize, frames: &Frames, touches: &mut Touches) {
        let Self {
            obstacles,
            links,
            apart,
            entries,
            near,
            ..
        } = self;
        near.look(link, |number| {
            if apart.contains(&(link + 1, number)) {
                return f64::INFINITY;
            }
            let solid = &obstacles[number].solid;
            let mut gap = f64::INFINITY;
            for capsule in links.placed(link + 1, frames) {
                let away = nearest::capsule_gap(&capsule, solid);
                gap = gap.min(away - MARGIN);
                if away > MARGIN {
                    continue;
                }
                nearest::capsule(&capsule, solid, MARGIN, &mut |place| {
                    if is_beyond_flange(link + 1, &place, frames) {
                        return;
                    }
                    let part = Part::Link(link);
                    let center = place.point + place.normal * capsule.radius;
                    let ball = (center, capsule.radius);
                    touches.push(Touch {
                        part,
                        obstacle: number,
                        place: entries.turned(part, (number, solid), ball, place),
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
        touches: &mut Touches,
    ) {
        let Self {
            obstacles,
            tool,
            entries,
            near,
            ..
        } = self;
        let tool = tool.map(|tool| tool.expressed_in(base_from_flange));
        let ball = match tool {
            None => {
                let tcp = *base_from_flange * *flange_from_tcp;
                let center = tcp.transform_point(Vector3::new(0.0, 0.0, -TCP_BALL));
                Some((center, TCP_BALL))
            }
            Some(Solid {
                pose,
                shape: Shape::Sphere { radius },
            }) => Some((pose.translation, radius)),
            Some(_) => None,
        };
        let part = Part::Tool;
        near.look(DOF, |obstacle| {
            let solid = &obstacles[obstacle].solid;
            if let Some((center, radius)) = ball {
                let mut gap = solid.distance(center).0 - radius - MARGIN;
                let place = among::ball((center, radius), obstacle, obstacles, MARGIN, entries);
                if let Some(place) = place {
                    gap = 0.0;
                    touches.push(Touch {
                        part,
                        obstacle,
                        place,
                    });
                }
                return gap;
            }
            let Some(tool) = &tool else {
                return f64::INFINITY;
            };
            nearest::solid(tool, solid, MARGIN, &mut |place| {
                let point = (place.point, 0.0);
                touches.push(Touch {
                    part,
                    obstacle,
                    place: entries.turned(part, (obstacle, solid), point, place),
                });
            });
            solid.distance(tool.pose.translation).0 - tool.reach() - MARGIN
        });
    }
}
