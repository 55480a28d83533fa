//! Through which face a part of the arm went into an obstacle: that is the way it is pushed out, however deep it is.
//!
//! The nearest way out of a thin and soft obstacle is its far side as soon as a part is half way through: it would let
//! the arm pass, and pull it. So what is inside remembers how it came in, as long as it stays inside. What has no past
//! there, because it stood inside at the start, leaves by the nearest way.

use kinematics::{DOF, Frames, Pose};
use motion_api::MAX_GRIPPERS;
use nalgebra::Vector3;

use super::nearest::ContactPoint;
use super::{ArmPart, PlacedShape};

/// The links, the tool, and the parts in the grippers.
const PARTS: usize = DOF + 1 + MAX_GRIPPERS;
/// A point this little below the surface is on it, m.
const ON_SURFACE: f64 = 1e-9;

/// A way out of an obstacle: distance from that face, m, negative inside; unit vector out, base frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct ExitDirection {
    pub distance: f64,
    pub normal: Vector3<f64>,
    /// A nearer one led into another obstacle.
    pub is_detour: bool,
}

#[derive(Clone, Copy, Debug)]
struct EntryFace {
    /// Obstacle frame.
    normal: Vector3<f64>,
    has_given_way: bool,
    last_update: u64,
}

/// What is remembered of every part and every obstacle.
#[derive(Clone, Debug)]
pub(super) struct EntryFaces {
    entries: Vec<Option<EntryFace>>,
    obstacles: usize,
    /// Number of the look.
    update_count: u64,
    poses: [Pose; PARTS],
    previous_poses: [Pose; PARTS],
}

impl EntryFaces {
    pub(super) fn new(obstacles: usize) -> Self {
        Self {
            entries: vec![None; PARTS * obstacles],
            obstacles,
            update_count: 0,
            poses: [Pose::IDENTITY; PARTS],
            previous_poses: [Pose::IDENTITY; PARTS],
        }
    }

    /// Another part hangs there now: it has no past.
    pub(super) fn forget(&mut self, part: ArmPart) {
        let first = self.index(part, 0);
        let obstacles = self.obstacles;
        if let Some(entries) = self.entries.get_mut(first..first + obstacles) {
            entries.fill(None);
        }
    }

    /// Looks anew, at an arm that has moved on to `frames`.
    pub(super) fn update(&mut self, frames: &Frames) {
        let mut at = [frames.base_from_flange; PARTS];
        at[..DOF].copy_from_slice(&frames.base_from_joint);
        self.previous_poses = if self.update_count == 0 {
            at
        } else {
            self.poses
        };
        self.poses = at;
        self.update_count += 1;
    }

    /// The way out that a part has had since it went in; `None` for one that has only just come, or left to the side.
    /// One that has gone through to the far side is still held.
    pub(super) fn remembered_exit(
        &self,
        part: ArmPart,
        number: usize,
        solid: &PlacedShape,
        point: Vector3<f64>,
    ) -> Option<ExitDirection> {
        let entry = self.entries.get(self.index(part, number))?.as_ref()?;
        if entry.last_update + 1 < self.update_count {
            return None;
        }
        let (distance, normal) = solid.exit_towards(point, entry.normal)?;
        Some(ExitDirection {
            distance,
            normal,
            is_detour: entry.has_given_way,
        })
    }

    /// The way by which a part came in since the last look, if it was outside then.
    pub(super) fn exit_by_entry_face(
        &self,
        part: ArmPart,
        solid: &PlacedShape,
        point: Vector3<f64>,
    ) -> Option<ExitDirection> {
        let slot = slot(part);
        let (at, before) = (&self.poses[slot], &self.previous_poses[slot]);
        let came_from = before.transform_point(at.inverse().transform_point(point));
        let (gap, out) = solid.distance(came_from);
        if gap < 0.0 {
            return None;
        }
        let (distance, normal) = solid.exit_towards(point, solid.pose.rotate_back(out))?;
        Some(ExitDirection {
            distance,
            normal,
            is_detour: false,
        })
    }

    /// A part is inside and will leave by `way`.
    pub(super) fn remember(
        &mut self,
        part: ArmPart,
        number: usize,
        solid: &PlacedShape,
        way: &ExitDirection,
    ) {
        let place = self.index(part, number);
        if let Some(entry) = self.entries.get_mut(place) {
            *entry = Some(EntryFace {
                normal: solid.pose.rotate_back(way.normal),
                has_given_way: way.is_detour,
                last_update: self.update_count,
            });
        }
    }

    /// The place of a ball of `radius` (0 for a point) around `center`, as found with the nearest way out, turned to
    /// the way by which its part came in.
    pub(super) fn reorient_to_entry_face(
        &mut self,
        part: ArmPart,
        (number, solid): (usize, &PlacedShape),
        (center, radius): (Vector3<f64>, f64),
        found: ContactPoint,
    ) -> ContactPoint {
        let (distance, normal) = solid.distance(center);
        let is_inside = distance < -ON_SURFACE;
        let way = match self.remembered_exit(part, number, solid, center) {
            Some(known) if known.distance < -ON_SURFACE => known,
            _ if !is_inside => return found,
            _ => self
                .exit_by_entry_face(part, solid, center)
                .unwrap_or(ExitDirection {
                    distance,
                    normal,
                    is_detour: false,
                }),
        };
        self.remember(part, number, solid, &way);
        ContactPoint {
            point: center - way.normal * radius,
            normal: way.normal,
            depth: radius - way.distance,
        }
    }

    fn index(&self, part: ArmPart, number: usize) -> usize {
        slot(part) * self.obstacles + number
    }
}

pub(super) const fn slot(part: ArmPart) -> usize {
    match part {
        ArmPart::Link(link) => link,
        ArmPart::Tool => DOF,
        ArmPart::Held(slot) => DOF + 1 + slot,
    }
}
