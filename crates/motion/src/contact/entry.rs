//! Through which face each point of the arm went into an obstacle: that is the way it is pushed out, however deep it
//! is.
//!
//! The nearest way out of a thin and soft obstacle is its far side as soon as a part is half way through: it would let
//! the arm pass, and pull it. So every point that is inside remembers how it came in, as long as it stays inside. A
//! part as a whole has no such face: while its flank goes down over the edge of a wall, its lower end has long come in
//! from the side, and the way up is as long for it as the wall is high. Close to an edge, what is deep slips over it:
//! the nearer of the two faces counts. What has no past, because it stood inside at the start, leaves by the nearest
//! way.

use kinematics::{DOF, Frames, Pose};
use nalgebra::Vector3;

use super::near::PARTS;
use super::nearest::{ContactPoint, Feature};
use super::{ArmPart, Obstacle, PlacedShape};

/// A point this little below the surface is on it, m.
const ON_SURFACE: f64 = 1e-9;
/// A point of a part that is no farther from one that is remembered has its past, m: places on edges and rims move
/// along them.
const SAME_POINT: f64 = 1e-3;
/// What is deeper than this beneath the face by which it came slips over an edge of it, m. Not as soon as another face
/// is nearer: the rim of a peg that stands on an edge by 20 µm stands.
const STANDING_DEPTH: f64 = 0.5e-3;
/// And only over an edge that is so near, m; and no farther than this share of the obstacle's width: what stands in the
/// middle of a ridge does not slip off it.
const EDGE_DISTANCE: f64 = 2e-3;
const EDGE_SHARE: f64 = 0.25;
/// Faces whose normals' product is larger may belong to one surface.
pub(super) const SAME_SURFACE_COSINE: f64 = 0.5;
/// An increase of depth that does not count, m.
pub(super) const DEPTH_TOLERANCE: f64 = 1e-6;
/// A way out leads into another obstacle when that is inside within this distance from its end, m.
const BEYOND_SURFACE: f64 = 1e-5;
/// Most points that are remembered; of more the last have no past.
const MAX_POINTS: usize = 256;

/// A way out of an obstacle: distance from that face, m, negative inside; unit vector out, base frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct ExitDirection {
    pub distance: f64,
    pub normal: Vector3<f64>,
    /// A nearer one led into another obstacle.
    pub is_detour: bool,
}

/// A ball of the arm, or a point of it with radius 0, in the base frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Probe {
    pub part: ArmPart,
    pub center: Vector3<f64>,
    pub radius: f64,
}

/// A point that was inside an obstacle, and its way out.
#[derive(Clone, Copy, Debug)]
struct PointInside {
    part: ArmPart,
    obstacle: usize,
    /// In the frame of the part.
    point: Vector3<f64>,
    /// In the frame of the obstacle.
    normal: Vector3<f64>,
    is_detour: bool,
}

/// What is remembered of every point inside an obstacle. No clone: one would not have the room for all points.
#[derive(Debug)]
pub(super) struct EntryFaces {
    /// Those of the look before, and of this one.
    before: Vec<PointInside>,
    now: Vec<PointInside>,
    is_first_look: bool,
    poses: [Pose; PARTS],
    previous_poses: [Pose; PARTS],
}

impl EntryFaces {
    pub(super) fn new() -> Self {
        Self {
            before: Vec::with_capacity(MAX_POINTS),
            now: Vec::with_capacity(MAX_POINTS),
            is_first_look: true,
            poses: [Pose::IDENTITY; PARTS],
            previous_poses: [Pose::IDENTITY; PARTS],
        }
    }

    /// Another part hangs there now: it has no past.
    pub(super) fn forget(&mut self, part: ArmPart) {
        self.now.retain(|known| known.part != part);
    }

    /// Looks anew, at an arm that has moved on to `frames`.
    pub(super) fn update(&mut self, frames: &Frames) {
        self.previous_poses = self.poses;
        self.poses[..DOF].copy_from_slice(&frames.base_from_joint);
        self.poses[DOF..].fill(frames.base_from_flange);
        if self.is_first_look {
            self.previous_poses = self.poses;
            self.is_first_look = false;
        }
        core::mem::swap(&mut self.before, &mut self.now);
        self.now.clear();
    }

    /// The way out of the obstacle `number` for a probe whose center came into it, also if it came out at the far side
    /// since; `None` for any other, and for one without a past.
    pub(super) fn way_out(
        &self,
        probe: &Probe,
        number: usize,
        obstacles: &[Obstacle],
    ) -> Option<ExitDirection> {
        let solid = &obstacles[number].solid;
        let (distance, _) = solid.distance(probe.center);
        let is_inside = distance < -ON_SURFACE;
        let known = self.nearest_known(probe, |known| known.obstacle == number);
        if let Some((known, away)) = known
            && away < SAME_POINT
            && let Some(way) = way_by((known.normal, FaceOf::Itself), probe, number, obstacles)
            && way.distance < -ON_SURFACE
        {
            let is_detour = known.is_detour;
            return Some(ExitDirection { is_detour, ..way });
        }
        if !is_inside {
            return None;
        }
        match (self.entry_face(probe, solid), known) {
            (Some(face), _) => self.way_since_entry(face, probe, number, obstacles),
            // A place of the part that did not count before: never out at the far side as its neighbour came in.
            (None, Some((known, _))) => {
                way_by((known.normal, FaceOf::Neighbor), probe, number, obstacles)
            }
            (None, None) => None,
        }
    }

    /// The way out for a probe that has only just come in through a face. When that leads into another obstacle, from
    /// which it came across the joint, the surface that it is beneath may go on.
    fn way_since_entry(
        &self,
        face: Vector3<f64>,
        probe: &Probe,
        number: usize,
        obstacles: &[Obstacle],
    ) -> Option<ExitDirection> {
        let way = way_by((face, FaceOf::Itself), probe, number, obstacles)?;
        if !leads_into_another(probe, number, obstacles, &way) {
            return Some(way);
        }
        let as_before = self.way_of_neighbor(probe, number, obstacles);
        let is_free = |way: &ExitDirection| !leads_into_another(probe, number, obstacles, way);
        Some(as_before.filter(is_free).unwrap_or(way))
    }

    /// The way out through the face that goes on from another obstacle, out of which the part is pushed and in which
    /// the probe was at the last look, as deep beneath its face.
    fn way_of_neighbor(
        &self,
        probe: &Probe,
        number: usize,
        obstacles: &[Obstacle],
    ) -> Option<ExitDirection> {
        let came_from = self.came_from(probe);
        let was_in = |obstacle: usize| obstacles[obstacle].solid.distance(came_from).0 < 0.0;
        let (known, away) = self.nearest_known(probe, |known| {
            known.obstacle != number && was_in(known.obstacle)
        })?;
        let neighbor = &obstacles[known.obstacle].solid;
        let (before, out) = neighbor.exit_towards(came_from, known.normal)?;
        let solid = &obstacles[number].solid;
        let face = solid.pose.rotate_back(out);
        let (distance, normal) = solid.exit_towards(probe.center, face)?;
        let goes_on =
            (distance - before).abs() < SAME_POINT && normal.dot(&out) > SAME_SURFACE_COSINE;
        let way = if away < SAME_POINT {
            ExitDirection::straight((distance, normal))
        } else {
            way_by((face, FaceOf::Neighbor), probe, number, obstacles)?
        };
        goes_on.then_some(ExitDirection {
            is_detour: true,
            ..way
        })
    }

    /// The remembered point of the probe's part that is nearest to its center, among those that count, and how far.
    fn nearest_known(
        &self,
        probe: &Probe,
        counts: impl Fn(&PointInside) -> bool,
    ) -> Option<(&PointInside, f64)> {
        let point = self.poses[slot(probe.part)]
            .inverse()
            .transform_point(probe.center);
        let known = self.before.iter();
        known
            .filter(|known| known.part == probe.part && counts(known))
            .map(|known| (known, (known.point - point).norm()))
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The face of the obstacle, as a normal in its frame, through which a point came since the last look, if it was
    /// outside then.
    fn entry_face(&self, probe: &Probe, solid: &PlacedShape) -> Option<Vector3<f64>> {
        let came_from = self.came_from(probe);
        let (gap, out) = solid.distance(came_from);
        (gap >= -ON_SURFACE).then(|| solid.pose.rotate_back(out))
    }

    /// Where the center of a probe was at the last look, if it is a point of its part.
    fn came_from(&self, probe: &Probe) -> Vector3<f64> {
        let slot = slot(probe.part);
        let point = self.poses[slot].inverse().transform_point(probe.center);
        self.previous_poses[slot].transform_point(point)
    }

    /// A probe is inside and will leave by `way`.
    pub(super) fn remember(
        &mut self,
        probe: &Probe,
        number: usize,
        solid: &PlacedShape,
        way: &ExitDirection,
    ) {
        if self.now.len() >= MAX_POINTS {
            return;
        }
        self.now.push(PointInside {
            part: probe.part,
            obstacle: number,
            point: self.poses[slot(probe.part)]
                .inverse()
                .transform_point(probe.center),
            normal: solid.pose.rotate_back(way.normal),
            is_detour: way.is_detour,
        });
    }

    /// The place where two bodies touch, as found with the nearest way out. One of the body is turned to the way by
    /// which it came in. One of the obstacle is on its surface, has not come in anywhere, and leads out of the body.
    pub(super) fn reorient_feature(
        &mut self,
        part: ArmPart,
        feature: Feature,
        number: usize,
        obstacles: &[Obstacle],
        found: ContactPoint,
    ) -> ContactPoint {
        let Feature::OfBody { radius } = feature else {
            return found;
        };
        let probe = Probe {
            part,
            center: found.point + found.normal * radius,
            radius,
        };
        self.reorient_to_entry_face(&probe, number, obstacles, found)
    }

    /// The place of a probe, as found with the nearest way out, turned to the way by which it came in.
    pub(super) fn reorient_to_entry_face(
        &mut self,
        probe: &Probe,
        number: usize,
        obstacles: &[Obstacle],
        found: ContactPoint,
    ) -> ContactPoint {
        let solid = &obstacles[number].solid;
        let way = self.way_out(probe, number, obstacles).or_else(|| {
            let nearest = ExitDirection::straight(solid.distance(probe.center));
            (nearest.distance < -ON_SURFACE).then_some(nearest)
        });
        let Some(way) = way else {
            return found;
        };
        self.remember(probe, number, solid, &way);
        ContactPoint {
            point: probe.center - way.normal * probe.radius,
            normal: way.normal,
            depth: probe.radius - way.distance,
        }
    }
}

/// How a face is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FaceOf {
    /// The point itself came through it.
    Itself,
    /// Another point of the part did: the point never leaves by the far side, but by any other that is nearer.
    Neighbor,
}

/// The way out through the face that `towards` (in the obstacle's frame) belongs to, or, for a probe that slips over
/// its edge, through one that meets it, where that is nearer with what leads on from there. `None` when the probe is
/// not beneath the face.
fn way_by(
    (towards, face_of): (Vector3<f64>, FaceOf),
    probe: &Probe,
    number: usize,
    obstacles: &[Obstacle],
) -> Option<ExitDirection> {
    let solid = &obstacles[number].solid;
    let straight = ExitDirection::straight(solid.exit_towards(probe.center, towards)?);
    let is_own = face_of == FaceOf::Itself;
    if is_own && straight.distance > -STANDING_DEPTH {
        return Some(straight);
    }
    let (mut chosen, mut best) = (straight, straight.distance);
    let beside = solid.exits_beside(probe.center, towards);
    for exit in beside.iter().flatten() {
        let way = ExitDirection::straight((exit.distance, exit.normal));
        let most = if is_own {
            EDGE_DISTANCE.min(EDGE_SHARE * exit.width)
        } else {
            f64::INFINITY
        };
        let all = way.distance + distance_beyond(probe, number, obstacles, &way, straight.normal);
        if all > best && all >= -most {
            (chosen, best) = (way, all);
        }
    }
    Some(chosen)
}

/// How far a probe that has left the obstacle `number` by `way` still has to go out of the others that it is in then,
/// without coming back and not against `out`: as a distance from their faces, m, not above 0.
fn distance_beyond(
    probe: &Probe,
    number: usize,
    obstacles: &[Obstacle],
    way: &ExitDirection,
    out: Vector3<f64>,
) -> f64 {
    let there = Probe {
        center: end_of(probe, way),
        ..*probe
    };
    let first = &obstacles[number].solid;
    entered_by(probe, number, obstacles, way)
        .map(|other| {
            let solid = &obstacles[other].solid;
            let straight = solid.exit_towards(there.center, solid.pose.rotate_back(out));
            let ways = solid.exits(there.center).into_iter().flatten();
            ways.chain(straight)
                .map(ExitDirection::straight)
                .filter(|way| way.normal.dot(&out) > -SAME_SURFACE_COSINE)
                .filter(|way| first.distance(end_of(&there, way)).0 >= 0.0)
                .map(|way| way.distance)
                .max_by(f64::total_cmp)
                .unwrap_or_else(|| solid.distance(there.center).0)
                - end_distance(probe)
        })
        .fold(0.0, f64::min)
}

/// True when a probe that has left the obstacle `number` by `way` would be deeper in another one than it is now.
pub(super) fn leads_into_another(
    probe: &Probe,
    number: usize,
    obstacles: &[Obstacle],
    way: &ExitDirection,
) -> bool {
    entered_by(probe, number, obstacles, way).next().is_some()
}

/// The obstacles in which a probe that has left the obstacle `number` by `way` would be deeper than it is now.
fn entered_by(
    probe: &Probe,
    number: usize,
    obstacles: &[Obstacle],
    way: &ExitDirection,
) -> impl Iterator<Item = usize> {
    let outside = end_of(probe, way);
    let center = probe.center;
    let others = obstacles.iter().enumerate();
    others.filter_map(move |(other, obstacle)| {
        // Deeper than now is only where the probe would be inside.
        if !obstacle.solid.may_be_near(outside, 0.0) {
            return None;
        }
        let before = obstacle.solid.distance(center).0.min(0.0);
        let is_deeper = obstacle.solid.distance(outside).0 < before - DEPTH_TOLERANCE;
        (other != number && is_deeper).then_some(other)
    })
}

/// Where the center of a probe is when it has just left an obstacle.
fn end_of(probe: &Probe, way: &ExitDirection) -> Vector3<f64> {
    probe.center + way.normal * (end_distance(probe) - way.distance)
}

/// How far the center of a probe is from the surface of an obstacle that it has just left, m.
fn end_distance(probe: &Probe) -> f64 {
    probe.radius.max(BEYOND_SURFACE)
}

impl ExitDirection {
    /// One that is no detour.
    const fn straight((distance, normal): (f64, Vector3<f64>)) -> Self {
        Self {
            distance,
            normal,
            is_detour: false,
        }
    }
}

pub(super) const fn slot(part: ArmPart) -> usize {
    match part {
        ArmPart::Link(link) => link,
        ArmPart::Tool => DOF,
        ArmPart::Held(slot) => DOF + 1 + slot,
    }
}
