//! Convex bodies with flat faces, as contact and distances need them: planes to stand on, edges and corners to touch
//! with.
//!
//! Owns the exact signed distance of a point. Everything is computed when the body is made; questions allocate nothing.
//! Where such bodies come from is no business of this module: pieces of meshes are cut elsewhere.

use messages::Localized;
use nalgebra::Vector3;

/// A corner may lie above the plane of a face by this share of the body's size.
const FLATNESS: f64 = 1e-6;

/// A convex body with flat faces, in a frame of its own. Metres.
#[derive(Clone, Debug, PartialEq)]
pub struct Polytope {
    points: Box<[Vector3<f64>]>,
    faces: Box<[Face]>,
    /// Points of the faces, one face after the other.
    corners: Box<[u8]>,
    edges: Box<[Edge]>,
    bounding_radius: f64,
}

/// A flat face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Unit vector out of the body.
    pub normal: Vector3<f64>,
    /// Distance of the face's plane from the origin along the normal, m; negative where the origin is outside.
    pub offset: f64,
    /// Middle of the corners, and how far the farthest of them is from it, m.
    middle: Vector3<f64>,
    radius: f64,
    first_corner: u32,
    corner_count: u32,
}

/// Where two faces meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// Indices of the two ends among the points.
    pub ends: [usize; 2],
    /// Indices of the two faces.
    pub faces: [usize; 2],
}

/// Points and faces that are no convex body.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Localized)]
#[non_exhaustive]
pub enum PolytopeError {
    /// Too few or too many points.
    #[error("a convex body has 4 to {} points, not {given}", Polytope::MAX_POINTS)]
    #[zh("凸体有 4 到 {} 个点，不能是 {given} 个", Polytope::MAX_POINTS)]
    PointCount {
        /// How many there are.
        given: usize,
    },
    /// A coordinate is not finite.
    #[error("point {index} has a coordinate that is not finite")]
    #[zh("第 {index} 点有一个坐标不是有限数")]
    NotFinite {
        /// Index of the point.
        index: usize,
    },
    /// A face has too few corners, names a point that does not exist, or has no area.
    #[error("face {index} is no polygon of the points")]
    #[zh("面 {index} 不是由这些点构成的多边形")]
    Face {
        /// Index of the face.
        index: usize,
    },
    /// A point lies outside of a face.
    #[error("point {point} lies {distance} m outside of face {face}")]
    #[zh("第 {point} 点在面 {face} 外 {distance} m 处")]
    NotConvex {
        /// Index of the point.
        point: usize,
        /// Index of the face.
        face: usize,
        /// How far outside, m.
        distance: f64,
    },
    /// Faces do not meet in pairs.
    #[error(
        "the faces do not close: the edge from point {from} to point {to} belongs to one face only"
    )]
    #[zh("面没有闭合：从第 {from} 点到第 {to} 点的边只属于一个面")]
    Open {
        /// Index of one end.
        from: usize,
        /// Index of the other end.
        to: usize,
    },
}

impl Polytope {
    /// Most points of a body, which bounds the time of every question.
    pub const MAX_POINTS: usize = 128;

    /// The body with these corners. A face is a loop of indices of points, counterclockwise seen from outside.
    ///
    /// # Errors
    ///
    /// Points and faces that are no convex body.
    pub fn new(points: Vec<Vector3<f64>>, loops: &[Vec<u32>]) -> Result<Self, PolytopeError> {
        let given = points.len();
        if !(4..=Self::MAX_POINTS).contains(&given) {
            return Err(PolytopeError::PointCount { given });
        }
        if let Some(index) = points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            return Err(PolytopeError::NotFinite { index });
        }
        let bounding_radius = points.iter().map(Vector3::norm).fold(0.0, f64::max);
        let (mut faces, mut corners) = (Vec::new(), Vec::new());
        for (index, corner_loop) in loops.iter().enumerate() {
            let face = plane_of(&points, corner_loop).ok_or(PolytopeError::Face { index })?;
            faces.push(Face {
                first_corner: corners.len() as u32,
                ..face
            });
            // Fewer points than 256 were counted above, and the plane found every corner among them.
            corners.extend(corner_loop.iter().map(|corner| *corner as u8));
        }
        for (face, plane) in faces.iter().enumerate() {
            for (point, p) in points.iter().enumerate() {
                let distance = plane.distance(*p);
                if distance > FLATNESS * bounding_radius {
                    return Err(PolytopeError::NotConvex {
                        point,
                        face,
                        distance,
                    });
                }
            }
        }
        let edges = edges_of(loops)?;
        Ok(Self {
            points: points.into(),
            faces: faces.into(),
            corners: corners.into(),
            edges: edges.into(),
            bounding_radius,
        })
    }

    /// A box around the origin with these half edges, m.
    ///
    /// # Errors
    ///
    /// Edges that are not finite and above 0.
    pub fn cuboid(half: [f64; 3]) -> Result<Self, PolytopeError> {
        let sign = |bit: usize| if bit > 0 { 1.0 } else { -1.0 };
        let corner = |k: usize| Vector3::new(sign(k & 1), sign(k & 2), sign(k & 4));
        let half = Vector3::from(half);
        let points = (0..8).map(|k| corner(k).component_mul(&half)).collect();
        let loops = [
            [0, 4, 6, 2],
            [1, 3, 7, 5],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 2, 3, 1],
            [4, 5, 7, 6],
        ];
        Self::new(points, &loops.map(Vec::from))
    }

    /// The body seen in a point mirror at the origin: every point p becomes −p.
    #[must_use]
    pub fn point_mirrored(&self) -> Self {
        let turned = self.faces.iter().map(|face| Face {
            normal: -face.normal,
            middle: -face.middle,
            ..*face
        });
        // Mirrored corners run clockwise, so each loop is turned around.
        let mut corners = self.corners.clone();
        for face in &self.faces {
            let first = face.first_corner as usize;
            corners[first..first + face.corner_count as usize].reverse();
        }
        Self {
            points: self.points.iter().map(|p| -p).collect(),
            faces: turned.collect(),
            corners,
            edges: self.edges.clone(),
            bounding_radius: self.bounding_radius,
        }
    }

    /// The corners, m.
    pub const fn points(&self) -> &[Vector3<f64>] {
        &self.points
    }

    /// The faces.
    pub const fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// The corners of a face, counterclockwise seen from outside, m.
    pub fn corners(&self, face: &Face) -> impl DoubleEndedIterator<Item = Vector3<f64>> {
        let first = face.first_corner as usize;
        let corners = &self.corners[first..first + face.corner_count as usize];
        corners
            .iter()
            .map(|corner| self.points[usize::from(*corner)])
    }

    /// The edges, each once.
    pub const fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// Radius of the ball around the origin that holds the body, m.
    pub const fn bounding_radius(&self) -> f64 {
        self.bounding_radius
    }

    /// How far the body reaches from the origin along a unit vector, m.
    pub fn reach(&self, direction: &Vector3<f64>) -> f64 {
        let along = self.points.iter().map(|p| p.dot(direction));
        along.fold(f64::NEG_INFINITY, f64::max)
    }

    /// The face whose plane a point is farthest above, or least below, and that distance, m: negative inside.
    pub fn nearest_plane(&self, point: &Vector3<f64>) -> (&Face, f64) {
        let mut best = (&self.faces[0], self.faces[0].distance(*point));
        for face in &self.faces[1..] {
            let distance = face.distance(*point);
            if distance > best.1 {
                best = (face, distance);
            }
        }
        best
    }

    /// Distance of a point from the surface, m, negative inside, and the unit vector that leads out the shortest way.
    pub fn distance(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let (nearest, depth) = self.nearest_plane(point);
        if depth <= 0.0 {
            return (depth, nearest.normal);
        }
        let mut best = (f64::INFINITY, nearest.normal);
        // The face with the highest plane first: after it most others are known to be farther away.
        for face in core::iter::once(nearest).chain(&self.faces) {
            let height = face.distance(*point);
            let reach = best.0 + face.radius;
            if height <= 0.0 || (point - face.middle).norm_squared() >= reach * reach {
                continue;
            }
            match self.beside_face(face, point) {
                // Above the inside of a face: no other place of a convex body is nearer.
                None => return (height, face.normal),
                Some(closest) => {
                    let way = point - closest;
                    let distance = way.norm();
                    if distance < best.0 {
                        best = (
                            distance,
                            if distance > 0.0 {
                                way / distance
                            } else {
                                face.normal
                            },
                        );
                    }
                }
            }
        }
        best
    }

    /// The nearest place on the boundary of a face for a point that is not right above it; `None` above it.
    fn beside_face(&self, face: &Face, point: &Vector3<f64>) -> Option<Vector3<f64>> {
        let mut best = None::<(f64, Vector3<f64>)>;
        let mut from = self.corners(face).next_back()?;
        for to in self.corners(face) {
            let along = to - from;
            let way = point - from;
            if along.cross(&face.normal).dot(&way) > 0.0 {
                let share = (way.dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
                let closest = from + along * share;
                let distance = (point - closest).norm_squared();
                if best.is_none_or(|(least, _)| distance < least) {
                    best = Some((distance, closest));
                }
            }
            from = to;
        }
        best.map(|(_, closest)| closest)
    }
}

impl Face {
    /// Distance of a point from the face's plane, m, negative on the side of the body.
    pub fn distance(&self, point: Vector3<f64>) -> f64 {
        self.normal.dot(&point) - self.offset
    }
}

/// The plane of a loop of corners (Newell's method), or `None` where there is none. Corners are not counted up yet.
fn plane_of(points: &[Vector3<f64>], corner_loop: &[u32]) -> Option<Face> {
    let corner = |index: &u32| points.get(*index as usize).copied();
    let mut area = Vector3::zeros();
    let mut from = corner(corner_loop.last()?)?;
    for to in corner_loop {
        let to = corner(to)?;
        area += from.cross(&to);
        from = to;
    }
    let normal = area.try_normalize(f64::MIN_POSITIVE)?;
    let corners = || corner_loop.iter().filter_map(corner);
    let middle = corners().sum::<Vector3<f64>>() / corner_loop.len() as f64;
    let heights = corner_loop
        .iter()
        .filter_map(corner)
        .map(|p| p.dot(&normal));
    (corner_loop.len() >= 3).then(|| Face {
        normal,
        offset: heights.fold(f64::NEG_INFINITY, f64::max),
        middle,
        radius: corners().map(|p| (p - middle).norm()).fold(0.0, f64::max),
        first_corner: 0,
        corner_count: corner_loop.len() as u32,
    })
}

/// The edges of faces that close a surface.
fn edges_of(loops: &[Vec<u32>]) -> Result<Vec<Edge>, PolytopeError> {
    let mut half_edges = std::collections::BTreeMap::new();
    for (face, corner_loop) in loops.iter().enumerate() {
        let next = corner_loop.iter().cycle().skip(1);
        for (from, to) in corner_loop.iter().zip(next) {
            if half_edges.insert((*from, *to), face).is_some() {
                return Err(PolytopeError::Face { index: face });
            }
        }
    }
    let mut edges = Vec::new();
    for ((from, to), face) in &half_edges {
        let ends = [*from as usize, *to as usize];
        let Some(other) = half_edges.get(&(*to, *from)) else {
            return Err(PolytopeError::Open {
                from: ends[0],
                to: ends[1],
            });
        };
        if from < to {
            edges.push(Edge {
                ends,
                faces: [*face, *other],
            });
        }
    }
    Ok(edges)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn cuboid(half: [f64; 3]) -> Polytope {
        Polytope::cuboid(half).unwrap()
    }

    #[test]
    fn a_box_has_its_edges_and_reaches_its_corners() {
        let body = cuboid([0.1, 0.2, 0.3]);
        assert_eq!(body.edges().len(), 12);
        assert_eq!(body.faces().len(), 6);
        for edge in body.edges() {
            let [a, b] = edge.faces.map(|face| body.faces()[face].normal);
            assert!(a.dot(&b).abs() < 1e-12);
        }
        assert!((body.bounding_radius() - 0.14_f64.sqrt()).abs() < 1e-12);
        assert!((body.reach(&Vector3::y()) - 0.2).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_convex_body_is_refused() {
        let body = cuboid([0.1; 3]);
        let points = || body.points().to_vec();
        let loops: Vec<Vec<u32>> = vec![
            vec![0, 4, 6, 2],
            vec![1, 3, 7, 5],
            vec![0, 1, 5, 4],
            vec![2, 6, 7, 3],
            vec![0, 2, 3, 1],
        ];
        assert_eq!(
            Polytope::new(points(), &loops),
            Err(PolytopeError::Open { from: 4, to: 6 })
        );
        let inward: Vec<Vec<u32>> = loops
            .iter()
            .map(|l| l.iter().rev().copied().collect())
            .collect();
        assert!(matches!(
            Polytope::new(points(), &inward),
            Err(PolytopeError::NotConvex { .. })
        ));
        assert!(matches!(
            Polytope::new(points(), &[vec![0, 1, 99]]),
            Err(PolytopeError::Face { index: 0 })
        ));
        let mut broken = points();
        broken[3].x = f64::NAN;
        assert_eq!(
            Polytope::new(broken, &loops),
            Err(PolytopeError::NotFinite { index: 3 })
        );
        assert_eq!(
            Polytope::new(vec![Vector3::zeros(); 3], &[]),
            Err(PolytopeError::PointCount { given: 3 })
        );
    }

    proptest! {
        #[test]
        fn distances_are_those_of_the_box(
            half in prop::array::uniform3(0.05..0.5_f64),
            at in prop::array::uniform3(-1.0..1.0_f64),
        ) {
            let point = Vector3::from(at);
            let beyond = point.abs() - Vector3::from(half);
            let truth = beyond.map(|x| x.max(0.0)).norm() + beyond.max().min(0.0);
            let (distance, out) = cuboid(half).distance(&point);
            prop_assert!((distance - truth).abs() < 1e-12, "{distance} {truth}");
            prop_assert!((out.norm() - 1.0).abs() < 1e-12);
            let (mirrored, back) = cuboid(half).point_mirrored().distance(&-point);
            prop_assert!((mirrored - distance).abs() < 1e-12 && (back + out).norm() < 1e-9);
            // Going back along the way leads to the surface.
            let (left, _) = cuboid(half).distance(&(point - out * distance));
            prop_assert!(left.abs() < 1e-9, "{left}");
        }
    }
}
