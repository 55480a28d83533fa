//! Capsules around the links, and distances between them.
//!
//! Owns the geometry of self-collision and of the arm against simple obstacles. Knows no contact forces.

use crate::chain::{Chain, Frames};
use crate::joint::DOF;
use crate::pose::Pose;
use messages::{Text, text};
use nalgebra::Vector3;

/// All points within `radius` of the segment from `p0` to `p1`, metres. A ball if the ends coincide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    /// First end of the segment, m.
    pub p0: Vector3<f64>,
    /// Second end of the segment, m.
    pub p1: Vector3<f64>,
    /// Radius, m.
    pub radius: f64,
}

impl Capsule {
    /// This capsule described in frame a instead of frame b.
    pub fn expressed_in(&self, a_from_b: &Pose) -> Self {
        Self {
            p0: a_from_b.transform_point(self.p0),
            p1: a_from_b.transform_point(self.p1),
            radius: self.radius,
        }
    }

    /// Distance between two capsules' surfaces, m; negative when they overlap, by the depth of the overlap of the
    /// nearest points.
    pub fn distance(&self, other: &Self) -> f64 {
        segment_distance(self.p0, self.p1, other.p0, other.p1) - self.radius - other.radius
    }

    /// Distance of the surface from the half space below a plane, m: negative when a part is behind `point` as seen
    /// along the unit `normal`.
    pub fn distance_to_plane(&self, point: Vector3<f64>, normal: Vector3<f64>) -> f64 {
        let height = |p: Vector3<f64>| (p - point).dot(&normal);
        height(self.p0).min(height(self.p1)) - self.radius
    }

    /// Whether `other` lies inside this capsule but for `slack` metres.
    pub(crate) fn covers(&self, other: &Self, slack: f64) -> bool {
        [other.p0, other.p1].iter().all(|&p| {
            segment_distance(self.p0, self.p1, p, p) + other.radius <= self.radius + slack
        })
    }
}

/// Distance between two segments (Ericson, *Real-Time Collision Detection*, 2005, 5.1.9), m. Either may be a point.
pub fn segment_distance(
    a0: Vector3<f64>,
    a1: Vector3<f64>,
    b0: Vector3<f64>,
    b1: Vector3<f64>,
) -> f64 {
    let (u, v, r) = (a1 - a0, b1 - b0, a0 - b0);
    let (uu, vv, uv) = (u.norm_squared(), v.norm_squared(), u.dot(&v));
    let (ur, vr) = (u.dot(&r), v.dot(&r));
    let ratio = |numerator: f64, denominator: f64| {
        if denominator > 0.0 {
            (numerator / denominator).clamp(0.0, 1.0)
        } else {
            0.0
        }
    };
    // Nearest points of the infinite lines, s along a; parallel lines may start anywhere. Then t on b, and if t had to
    // be cut to the segment, s again for that end.
    let s = ratio(uv * vr - ur * vv, uu * vv - uv * uv);
    let t = ratio(uv * s + vr, vv);
    let s = ratio(uv * t - ur, uu);
    (r + u * s - v * t).norm()
}

/// Index of a link with capsules: 0 is the fixed base, i is the link that moves with joint i.
pub type LinkIndex = usize;

/// Number of links, base included.
pub const LINKS: usize = DOF + 1;

/// What people call a link.
pub fn link_name(link: LinkIndex) -> Text {
    const NAMES: [Text; LINKS] = [
        text!("base", "基座"),
        text!("shoulder", "肩部"),
        text!("upper arm", "上臂"),
        text!("forearm", "前臂"),
        text!("wrist 1", "手腕 1"),
        text!("wrist 2", "手腕 2"),
        text!("wrist 3", "手腕 3"),
    ];
    NAMES.get(link).cloned().unwrap_or(text!("link", "连杆"))
}

/// The nearest two links.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkDistance {
    /// Distance between their surfaces, m; negative when they overlap.
    pub distance: f64,
    /// The two links, 0 for the base.
    pub links: (LinkIndex, LinkIndex),
}

/// The capsules of every link in its own frame, and which pairs of links can meet at all.
#[derive(Clone, Debug, Default)]
pub struct CollisionModel {
    capsules: [Vec<Capsule>; LINKS],
    tested_pairs: Vec<(LinkIndex, LinkIndex)>,
}

impl CollisionModel {
    /// Capsules in link frames (the base's in the base frame) and pairs that need no test; neighbours never do.
    pub fn new(capsules: [Vec<Capsule>; LINKS], never_collide: &[(LinkIndex, LinkIndex)]) -> Self {
        let mut tested_pairs = Vec::new();
        for a in 0..LINKS {
            for b in a + 2..LINKS {
                if !never_collide.contains(&(a, b)) && !never_collide.contains(&(b, a)) {
                    tested_pairs.push((a, b));
                }
            }
        }
        Self {
            capsules,
            tested_pairs,
        }
    }

    /// Capsules of a link in its own frame, 0 for the base.
    pub fn capsules(&self, link: LinkIndex) -> &[Capsule] {
        &self.capsules[link]
    }

    /// The pairs of links that are tested against each other.
    pub fn tested_pairs(&self) -> &[(LinkIndex, LinkIndex)] {
        &self.tested_pairs
    }

    /// Capsules of a link in the base frame at the given joint frames.
    pub fn capsules_in_base<'a>(
        &'a self,
        link: LinkIndex,
        frames: &'a Frames,
    ) -> impl Iterator<Item = Capsule> + 'a {
        let base_from_link = match link {
            0 => Pose::IDENTITY,
            _ => frames.base_from_joint[link - 1],
        };
        self.capsules[link]
            .iter()
            .map(move |capsule| capsule.expressed_in(&base_from_link))
    }

    /// The smallest distance between two links that can meet, `None` if no pair has capsules.
    ///
    /// Allocates nothing. The tool is not part of it.
    pub fn self_distance(&self, frames: &Frames) -> Option<LinkDistance> {
        let mut least: Option<LinkDistance> = None;
        for &(a, b) in &self.tested_pairs {
            for capsule_a in self.capsules_in_base(a, frames) {
                for capsule_b in self.capsules_in_base(b, frames) {
                    let distance = capsule_a.distance(&capsule_b);
                    if least.is_none_or(|l| distance < l.distance) {
                        least = Some(LinkDistance {
                            distance,
                            links: (a, b),
                        });
                    }
                }
            }
        }
        least
    }

    /// How far from the origin of its frame a link reaches, m.
    pub fn bounding_radius(&self, link: LinkIndex) -> f64 {
        let far = |c: &Capsule| c.p0.norm().max(c.p1.norm()) + c.radius;
        self.capsules[link].iter().map(far).fold(0.0, f64::max)
    }

    /// How far from its axis each joint moves any part of the links at most, whatever the others do, m. So two links
    /// come nearer by no more than the sum of these times the turns of the joints.
    pub fn max_lever_arms(&self, chain: &Chain) -> [f64; DOF] {
        let extent = |link| self.bounding_radius(link);
        core::array::from_fn(|joint| {
            let (mut way, mut reach) = (0.0, extent(joint + 1));
            for next in joint + 1..DOF {
                way += chain.parent_from_joint[next].translation.norm();
                reach = reach.max(way + extent(next + 1));
            }
            reach
        })
    }

    /// Radius of the housing around the elbow, m: the thickest capsule of upper arm and forearm that the axis of joint
    /// 3 goes through. `None` for an arm without such capsules. The same at any `frames`.
    pub fn elbow_radius(&self, frames: &Frames) -> Option<f64> {
        let elbow = frames.base_from_joint[2];
        // Longer than any link is thick.
        let reach = elbow.rotate(Vector3::z());
        let (below, above) = (elbow.translation - reach, elbow.translation + reach);
        [2, 3]
            .into_iter()
            .flat_map(|link| self.capsules_in_base(link, frames))
            .filter(|c| segment_distance(c.p0, c.p1, below, above) <= c.radius)
            .map(|capsule| capsule.radius)
            .max_by(f64::total_cmp)
    }

    /// The smallest distance between an obstacle capsule (base frame) and the links that move, with the link.
    pub fn obstacle_distance(
        &self,
        frames: &Frames,
        obstacle: &Capsule,
    ) -> Option<(f64, LinkIndex)> {
        (1..LINKS)
            .flat_map(|link| {
                self.capsules_in_base(link, frames)
                    .map(move |capsule| (capsule, link))
            })
            .map(|(capsule, link)| (capsule.distance(obstacle), link))
            .min_by(|a, b| a.0.total_cmp(&b.0))
    }
}
