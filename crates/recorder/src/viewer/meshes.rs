//! Meshes as viewers get them: triangles now and then, poses with `/tf`.
//!
//! A mesh can have as many bytes as minutes of recording. Its triangles are therefore sent when it appears, when its
//! colour changes and once in a while for viewers that seek; what moves is the frame that they are in. They go out in
//! pieces, an entity and a message each, one at a time, so that no message is larger than readers and clients take.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;

use foxglove::messages as shown;
use foxglove::messages::Timestamp;
use kinematics::Pose;
use mesh::Mesh;

use super::scene::{self, ObstacleShape, SceneBody, SceneObstacle};
use super::{BASE_FRAME, SCENE_PERIOD};

/// Triangles of a piece: less than a mebibyte encoded, even if no two of them share a corner.
const PIECE_TRIANGLES: usize = 8192;
/// Triangles that are sent again in each [`SCENE_PERIOD`]; more of them are sent again less often.
const REPEATED_TRIANGLES: usize = 50_000;

/// What of a mesh makes its triangles another drawing.
#[derive(Clone)]
struct MeshDrawing {
    mesh: Arc<Mesh>,
    color: [f64; 4],
    /// The frame of the triangles, and their pose in it.
    frame: Arc<str>,
    pose: Pose,
}

impl MeshDrawing {
    fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.mesh, &other.mesh)
            && self.color == other.color
            && self.frame == other.frame
            && self.pose == other.pose
    }

    fn pieces(&self) -> usize {
        self.mesh.triangles().len().div_ceil(PIECE_TRIANGLES)
    }
}

/// The meshes of a scene, and which of their pieces viewers still need.
#[derive(Clone, Default)]
pub(super) struct MeshScene {
    drawings: BTreeMap<Arc<str>, MeshDrawing>,
    /// Pieces that are to be sent: a mesh and the number of its piece.
    due: VecDeque<(Arc<str>, usize)>,
    /// Simulated time of the latest repetition, s.
    repeated: f64,
}

impl MeshScene {
    /// The scene has these meshes from now on. What is new or looks different is due.
    pub(super) fn set(&mut self, obstacles: &[SceneObstacle], bodies: &[SceneBody]) {
        let mut drawings = BTreeMap::new();
        for obstacle in obstacles {
            let id = scene::obstacle_id(obstacle);
            if let ObstacleShape::Mesh(mesh) = &obstacle.shape
                && !bodies.iter().any(|body| *body.id == *id)
            {
                let drawing = MeshDrawing {
                    mesh: Arc::clone(mesh),
                    color: scene::OBSTACLE_COLOR,
                    frame: BASE_FRAME.into(),
                    pose: Pose::from_rpy(&obstacle.pose),
                };
                drawings.insert(id.into(), drawing);
            }
        }
        for body in bodies {
            if let ObstacleShape::Mesh(mesh) = &body.shape {
                let drawing = MeshDrawing {
                    mesh: Arc::clone(mesh),
                    color: body.color,
                    frame: Arc::clone(&body.id),
                    pose: Pose::IDENTITY,
                };
                drawings.insert(Arc::clone(&body.id), drawing);
            }
        }
        let before = std::mem::replace(&mut self.drawings, drawings);
        let drawings = &self.drawings;
        let stays = |id: &Arc<str>| {
            let (old, new) = (before.get(id), drawings.get(id));
            old.zip(new).is_some_and(|(old, new)| old.is_same(new))
        };
        self.due.retain(|(id, _)| stays(id));
        for (id, drawing) in drawings.iter().filter(|(id, _)| !stays(id)) {
            let pieces = (0..drawing.pieces()).map(|piece| (Arc::clone(id), piece));
            self.due.extend(pieces);
        }
    }

    /// All triangles are due, from the first one.
    pub(super) fn repeat(&mut self, time: f64) {
        self.repeated = time;
        let all = self
            .drawings
            .iter()
            .flat_map(|(id, drawing)| (0..drawing.pieces()).map(|piece| (Arc::clone(id), piece)));
        self.due = all.collect();
    }

    /// Repeats the triangles if the latest time is long enough ago.
    pub(super) fn repeat_if_due(&mut self, time: f64) {
        let triangles: usize = self
            .drawings
            .values()
            .map(|one| one.mesh.triangles().len())
            .sum();
        let times = (triangles as f64 / REPEATED_TRIANGLES as f64).max(1.0);
        // Time runs backwards when a replay begins again.
        if time - self.repeated >= times * SCENE_PERIOD - 1e-9 || time < self.repeated {
            self.repeat(time);
        }
    }

    /// The next piece that is due.
    pub(super) fn next(&mut self, at: Timestamp) -> Option<shown::SceneEntity> {
        while let Some((id, piece)) = self.due.pop_front() {
            if let Some(drawing) = self.drawings.get(&id) {
                return Some(entity(&id, drawing, piece, at));
            }
        }
        None
    }

    /// Identifiers of all entities of meshes.
    pub(super) fn ids(&self) -> BTreeSet<Arc<str>> {
        let all = self.drawings.iter();
        all.flat_map(|(id, drawing)| (0..drawing.pieces()).map(|piece| piece_id(id, piece)))
            .collect()
    }
}

/// The first piece has the name of the mesh.
fn piece_id(id: &Arc<str>, piece: usize) -> Arc<str> {
    match piece {
        0 => Arc::clone(id),
        _ => format!("{id}/piece {}", piece + 1).into(),
    }
}

fn entity(id: &Arc<str>, drawing: &MeshDrawing, piece: usize, at: Timestamp) -> shown::SceneEntity {
    let mut pieces = drawing.mesh.triangles().chunks(PIECE_TRIANGLES);
    let triangles = pieces.nth(piece).unwrap_or_default().as_flattened();
    let mut corners = triangles.to_vec();
    corners.sort_unstable();
    corners.dedup();
    // Every corner is found: these are the same numbers.
    let place = |corner| corners.binary_search(corner).unwrap_or_default();
    let indices = triangles
        .iter()
        .map(|corner| u32::try_from(place(corner)).unwrap_or_default());
    let indices = indices.collect();
    // A mesh has a point for every corner.
    let point = |corner: &u32| drawing.mesh.points()[*corner as usize];
    let points = corners.iter().map(|corner| {
        let point = point(corner);
        shown::Point3 {
            x: point.x,
            y: point.y,
            z: point.z,
        }
    });
    let mut drawn = scene::entity(&drawing.frame, &piece_id(id, piece), at);
    drawn.triangles.push(shown::TriangleListPrimitive {
        pose: Some(scene::pose(&drawing.pose)),
        points: points.collect(),
        color: Some(scene::color_of(drawing.color)),
        colors: Vec::new(),
        indices,
    });
    drawn
}
