//! Convex hulls of at most so many points, with an exact answer to which side of a plane a point is on.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Vector3;
use robust::{Coord3D, orient3d};

use super::distance::to_triangle;
use super::fragment::Plane;
use crate::solid::bounds_of;

/// More points than these are looked at in two rounds.
const MANY: usize = 20_000;

/// A convex body around points.
#[derive(Clone, Debug)]
pub(super) struct Hull {
    pub points: Vec<Vector3<f64>>,
    /// Counterclockwise from outside.
    pub triangles: Vec<[usize; 3]>,
    /// Of the triangles that have an area.
    pub planes: Vec<Plane>,
    /// In m³.
    pub volume: f64,
    /// How far a point that was left out may be outside, in metres.
    pub loss: f64,
}

/// The hull of points with at most `most` corners; points within `tolerance` of it are left out, and so are those
/// beyond `most` that change least. None for points in a plane.
pub(super) fn hull_of(points: &[Vector3<f64>], most: usize, tolerance: f64) -> Option<Hull> {
    let mut chosen: BTreeSet<usize> = support_points(points);
    // Of very many points some decide nearly everything; the others are looked at when these are done.
    let mut are_some = points.len() > MANY;
    // Corners that were, or were to be, and that are exactly inside. The plane of a narrow triangle is rounded, so one
    // of them may seem to be above it again and again.
    let mut inside = BTreeSet::<usize>::new();
    let mut outside = if are_some {
        far_points(points)
    } else {
        (0..points.len()).collect()
    };
    loop {
        let numbers: Vec<usize> = chosen.iter().copied().collect();
        let corners: Vec<Vector3<f64>> = numbers.iter().map(|&number| points[number]).collect();
        let triangles = exact_hull(&corners)?;
        chosen = triangles
            .iter()
            .flatten()
            .map(|&corner| numbers[corner])
            .collect();
        inside.extend(numbers.iter().filter(|number| !chosen.contains(number)));
        let planes: Vec<Option<Plane>> = triangles
            .iter()
            .map(|corner| plane_of(corner.map(|corner| corners[corner]), tolerance))
            .collect();
        let room = most.saturating_sub(chosen.len());
        let mut farthest = vec![(tolerance, usize::MAX); triangles.len()];
        let mut loss = 0.0_f64;
        outside.retain(|number| !inside.contains(number));
        outside.retain(|&number| {
            let point = &points[number];
            let (height, face) = highest_plane(&planes, point);
            if height <= tolerance {
                return false;
            }
            if room == 0 && !are_some {
                // The nearest place of a convex body is on a face that the point is above.
                let seen = planes
                    .iter()
                    .zip(&triangles)
                    .filter(|(plane, _)| plane.is_none_or(|plane| plane.height(point) > 0.0));
                let squares = seen
                    .map(|(_, corner)| to_triangle(point, &corner.map(|corner| corners[corner])));
                loss = loss.max(squares.fold(f64::INFINITY, f64::min).sqrt());
            }
            if height > farthest[face].0 && !chosen.contains(&number) {
                farthest[face] = (height, number);
            }
            true
        });
        farthest.retain(|&(_, number)| number != usize::MAX);
        if farthest.is_empty() || room == 0 {
            if !are_some {
                return Some(Hull::new(corners, &triangles, loss, tolerance));
            }
            are_some = false;
            outside = (0..points.len()).collect();
            continue;
        }
        farthest.sort_by(|one, other| other.0.total_cmp(&one.0).then(one.1.cmp(&other.1)));
        let added = farthest.len().min(room.min(8.max(room / 3)));
        chosen.extend(farthest[..added].iter().map(|&(_, number)| number));
    }
}

/// The plane of a face; none for one narrower than `tolerance`, whose direction is little but rounding.
fn plane_of(corners: [Vector3<f64>; 3], tolerance: f64) -> Option<Plane> {
    let [a, b, c] = corners;
    let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
    let is_wide = (b - a).cross(&(c - a)).norm() > longest * tolerance;
    Plane::of_triangle(corners).filter(|_| is_wide)
}

/// How far a point is above the plane that it is highest above, and which that is.
fn highest_plane(planes: &[Option<Plane>], point: &Vector3<f64>) -> (f64, usize) {
    let mut best = (f64::NEG_INFINITY, 0);
    for (face, plane) in planes.iter().enumerate() {
        if let Some(plane) = plane {
            let height = plane.height(point);
            if height > best.0 {
                best = (height, face);
            }
        }
    }
    best
}

/// The point of each cell of a grid that is farthest from the middle.
fn far_points(points: &[Vector3<f64>]) -> Vec<usize> {
    let (low, high) = bounds_of(points.iter().copied());
    let middle = (low + high) / 2.0;
    let edge = (high - low).max() / 24.0;
    let mut cells = BTreeMap::<[i64; 3], (f64, usize)>::new();
    for (number, point) in points.iter().enumerate() {
        // Between 0 and the number of cells along an axis.
        let cell = ((point - low) / edge).map(|value| value.floor() as i64);
        let away = (point - middle).norm_squared();
        let best = cells.entry(cell.into()).or_insert((away, number));
        if away > best.0 {
            *best = (away, number);
        }
    }
    cells.into_values().map(|(_, number)| number).collect()
}

impl Hull {
    /// Leaves out the points that are no corners.
    fn new(
        corners: Vec<Vector3<f64>>,
        triangles: &[[usize; 3]],
        loss: f64,
        tolerance: f64,
    ) -> Self {
        let used: BTreeSet<usize> = triangles.iter().flatten().copied().collect();
        let numbers: Vec<usize> = used.into_iter().collect();
        let points: Vec<Vector3<f64>> = numbers.iter().map(|&number| corners[number]).collect();
        let renumber = |corner: usize| numbers.binary_search(&corner).unwrap_or(0);
        let triangles: Vec<[usize; 3]> = triangles
            .iter()
            .map(|corner| corner.map(renumber))
            .collect();
        let planes = triangles
            .iter()
            .filter_map(|corner| plane_of(corner.map(|corner| points[corner]), tolerance))
            .collect();
        let start = points[0];
        let six_volumes: f64 = triangles
            .iter()
            .map(|corner| {
                let [a, b, c] = corner.map(|corner| points[corner] - start);
                a.dot(&b.cross(&c))
            })
            .sum();
        Self {
            points,
            triangles,
            planes,
            volume: six_volumes / 6.0,
            loss: loss + tolerance,
        }
    }

    /// How far a point is above the plane that it is highest above: negative inside.
    pub(super) fn height(&self, point: &Vector3<f64>) -> f64 {
        let heights = self.planes.iter().map(|plane| plane.height(point));
        heights.fold(f64::NEG_INFINITY, f64::max)
    }

    /// The mean of the corners, which is inside.
    pub(super) fn middle(&self) -> Vector3<f64> {
        let sum: Vector3<f64> = self.points.iter().sum();
        // At most some hundred corners, which are exact as a number.
        sum / self.points.len() as f64
    }

    /// The greatest distance of two corners is at most this, in metres.
    pub(super) fn diameter(&self) -> f64 {
        let (low, high) = bounds_of(self.points.iter().copied());
        (high - low).norm()
    }
}

/// The points farthest in many directions, none of which is along an edge or a face of what people draw: the farthest
/// is then a corner, and not any point of a face.
fn support_points(points: &[Vector3<f64>]) -> BTreeSet<usize> {
    let mut chosen = BTreeSet::new();
    for direction in directions() {
        let mut best = (f64::NEG_INFINITY, 0);
        for (number, point) in points.iter().enumerate() {
            let along = direction.dot(point);
            if along > best.0 {
                best = (along, number);
            }
        }
        chosen.insert(best.1);
    }
    chosen
}

/// Twenty-six directions to faces, edges and corners of a cube, slightly turned.
fn directions() -> impl Iterator<Item = Vector3<f64>> {
    let values = [-1.0, 0.0, 1.0];
    let all = values.into_iter().flat_map(move |x| {
        values
            .into_iter()
            .flat_map(move |y| values.into_iter().map(move |z| Vector3::new(x, y, z)))
    });
    all.filter(|direction| *direction != Vector3::zeros())
        .map(|direction| {
            let turn = Vector3::new(0.013_717, -0.027_193, 0.019_391);
            direction + turn.cross(&direction) + Vector3::new(0.000_917, 0.001_831, -0.000_577)
        })
}

fn exact(point: &Vector3<f64>) -> Coord3D<f64> {
    Coord3D {
        x: point.x,
        y: point.y,
        z: point.z,
    }
}

/// The triangles of the hull, point by point. A point is outside of a face only if it is exactly above its plane, so
/// the faces that a point sees hang together, and their border is one loop.
fn exact_hull(points: &[Vector3<f64>]) -> Option<Vec<[usize; 3]>> {
    let sees = |[a, b, c]: [usize; 3], point: usize| {
        orient3d(
            exact(&points[a]),
            exact(&points[b]),
            exact(&points[c]),
            exact(&points[point]),
        ) < 0.0
    };
    let start = first_tetrahedron(points)?;
    let [a, b, c, d] = start;
    let base = if sees([a, b, c], d) {
        [a, c, b]
    } else {
        [a, b, c]
    };
    let [a, b, c] = base;
    let mut faces = vec![[a, b, c], [b, a, d], [c, b, d], [a, c, d]];
    for point in (0..points.len()).filter(|point| !start.contains(point)) {
        let (visible, hidden): (Vec<_>, Vec<_>) =
            faces.iter().copied().partition(|&face| sees(face, point));
        if visible.is_empty() {
            continue;
        }
        let around = |&[a, b, c]: &[usize; 3]| [[a, b], [b, c], [c, a]];
        let edges: BTreeSet<[usize; 2]> = visible.iter().flat_map(around).collect();
        faces = hidden;
        let border = edges
            .iter()
            .filter(|[from, to]| !edges.contains(&[*to, *from]));
        faces.extend(border.map(|&[from, to]| [from, to, point]));
    }
    Some(faces)
}

/// Four points that are not in a plane, far from each other.
fn first_tetrahedron(points: &[Vector3<f64>]) -> Option<[usize; 4]> {
    let farthest = |measure: &dyn Fn(&Vector3<f64>) -> f64| {
        let mut best = (0.0, None);
        for (number, point) in points.iter().enumerate() {
            let value = measure(point);
            if value > best.0 {
                best = (value, Some(number));
            }
        }
        best.1
    };
    let first = *points.first()?;
    let a = farthest(&|point| (point - first).norm_squared())?;
    let b = farthest(&|point| (point - points[a]).norm_squared())?;
    let along = points[b] - points[a];
    let c = farthest(&|point| along.cross(&(point - points[a])).norm_squared())?;
    let normal = along.cross(&(points[c] - points[a]));
    let d = farthest(&|point| normal.dot(&(point - points[a])).abs())?;
    let corners = [a, b, c, d].map(|number| exact(&points[number]));
    (orient3d(corners[0], corners[1], corners[2], corners[3]) != 0.0).then_some([a, b, c, d])
}
