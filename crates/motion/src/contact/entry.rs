//! Through which face a part of the arm went into an obstacle: that is the way it is pushed out, however deep it is.
//!
//! The nearest way out of a thin and soft obstacle is its far side as soon as a part is half way through: it would let the arm
//! pass, and pull it. So what is inside remembers how it came in, as long as it stays inside. What has no past there, because
//! it stood inside at the start, leaves by the nearest way.

use kinematics::{DOF, Frames, Pose};
use nalgebra::Vector3;

use super::nearest::Place;
use super::{Part, Solid};

/// The links and the tool.
const PARTS: usize = DOF + 1;
/// A point this little below the surface is on it, m.
const ON_SURFACE: f64 = 1e-9;

/// A way out of an obstacle: distance from that face, m, negative inside; unit vector out, base frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct WayOut {
    pub distance: f64,
    pub normal: Vector3<f64>,
    /// A nearer one led into another obstacle.
    pub has_given_way: bool,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    /// Obstacle frame.
    normal: Vector3<f64>,
    has_given_way: bool,
    seen: u64,
}

/// What is remembered of every part and every obstacle.
#[derive(Clone, Debug)]
pub(super) struct Entries {
    entries: Vec<Option<Entry>>,
    obstacles: usize,
    /// Number of the look.
    now: u64,
    at: [Pose; PARTS],
    before: [Pose; PARTS],
}

impl Entries {
    pub(super) fn new(obstacles: usize) -> Self {
        Self {
            entries: vec![None; PARTS * obstacles],
            obstacles,
            now: 0,
            at: [Pose::IDENTITY; PARTS],
            before: [Pose::IDENTITY; PARTS],
        }
    }

    /// Looks anew, at an arm that has moved on to `frames`.
    pub(super) fn begin(&mut self, frames: &Frames) {
        let mut at = [frames.base_from_flange; PARTS];
        at[..DOF].copy_from_slice(&frames.base_from_joint);
        self.before = if self.now == 0 { at } else { self.at };
        self.at = at;
        self.now += 1;
    }

    /// The way out that a part has had since it went in; `None` for one that has only just come, or left to the side. One
    /// that has gone through to the far side is still held.
    pub(super) fn known(
        &self,
        part: Part,
        number: usize,
        solid: &Solid,
        point: Vector3<f64>,
    ) -> Option<WayOut> {
        let entry = self.entries.get(self.place(part, number))?.as_ref()?;
        if entry.seen + 1 < self.now {
            return None;
        }
        let (distance, normal) = solid.exit_towards(point, entry.normal)?;
        Some(WayOut {
            distance,
            normal,
            has_given_way: entry.has_given_way,
        })
    }

    /// The way by which a part came in since the last look, if it was outside then.
    pub(super) fn entering(
        &self,
        part: Part,
        solid: &Solid,
        point: Vector3<f64>,
    ) -> Option<WayOut> {
        let slot = slot(part);
        let (at, before) = (&self.at[slot], &self.before[slot]);
        let came_from = before.transform_point(at.inverse().transform_point(point));
        let (gap, out) = solid.distance(came_from);
        if gap < 0.0 {
            return None;
        }
        let (distance, normal) = solid.exit_towards(point, solid.pose.rotate_back(out))?;
        Some(WayOut {
            distance,
            normal,
            has_given_way: false,
        })
    }

    /// A part is inside and will leave by `way`.
    pub(super) fn remember(&mut self, part: Part, number: usize, solid: &Solid, way: &WayOut) {
        let place = self.place(part, number);
        if let Some(entry) = self.entries.get_mut(place) {
            *entry = Some(Entry {
                normal: solid.pose.rotate_back(way.normal),
                has_given_way: way.has_given_way,
                seen: self.now,
            });
        }
    }

    /// The place of a ball of `radius` (0 for a point) around `center`, as found with the nearest way out, turned to the way by
    /// which its part came in.
    pub(super) fn turned(
        &mut self,
        part: Part,
        (number, solid): (usize, &Solid),
        (center, radius): (Vector3<f64>, f64),
        found: Place,
    ) -> Place {
        let (distance, normal) = solid.distance(center);
        let is_inside = distance < -ON_SURFACE;
        let way = match self.known(part, number, solid, center) {
            Some(known) if known.distance < -ON_SURFACE => known,
            _ if !is_inside => return found,
            _ => self.entering(part, solid, center).unwrap_or(WayOut {
                distance,
                normal,
                has_given_way: false,
            }),
        };
        self.remember(part, number, solid, &way);
        Place {
            point: center - way.normal * radius,
            normal: way.normal,
            depth: radius - way.distance,
        }
    }

    fn place(&self, part: Part, number: usize) -> usize {
        slot(part) * self.obstacles + number
    }
}

const fn slot(part: Part) -> usize {
    match part {
        Part::Link(link) => link,
        Part::Tool => DOF,
    }
}
