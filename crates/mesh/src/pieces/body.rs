//! Hulls as bodies with flat faces.

use std::sync::Arc;

use kinematics::polytope::Polytope;
use nalgebra::Vector3;

use super::ConvexPiece;
use super::fragment::Plane;
use super::hull::Hull;
use crate::solid::bounds_of;

/// Triangles whose corners are this near to a plane are one face, as a share of the body's size.
const FLAT: f64 = 2e-8;

/// The body of a hull, and how much it is wider, in metres: nothing, unless rounding makes faces that are none.
pub(super) fn piece_of(hull: &Hull) -> (ConvexPiece, f64) {
    let middle = hull.middle();
    let points: Vec<Vector3<f64>> = hull.points.iter().map(|point| point - middle).collect();
    let flat = faces(hull, FLAT * hull.diameter());
    let single = hull
        .triangles
        .iter()
        .map(|corners| as_loop(corners))
        .collect();
    for loops in [flat, single] {
        if let Some(body) = body_of(&points, &loops) {
            let body = Arc::new(body);
            return (ConvexPiece { middle, body }, 0.0);
        }
    }
    let (low, high) = bounds_of(hull.points.iter().copied());
    box_around(low, high)
}

/// A box around two corners, and how long its diagonal is: no point of it is farther from what is in it.
pub(super) fn box_around(low: Vector3<f64>, high: Vector3<f64>) -> (ConvexPiece, f64) {
    let middle = (low + high) / 2.0;
    // Not flat, whatever is in it.
    let half = ((high - low) / 2.0).map(|length| length.max(1e-6));
    #[expect(clippy::expect_used, reason = "no length is below a micrometre")]
    let body = Arc::new(Polytope::cuboid(half.into()).expect("a box"));
    (ConvexPiece { middle, body }, 2.0 * half.norm())
}

/// The body of these points and faces, without the points of no face.
fn body_of(points: &[Vector3<f64>], loops: &[Vec<u32>]) -> Option<Polytope> {
    let mut used = vec![false; points.len()];
    for &corner in loops.iter().flatten() {
        *used.get_mut(corner as usize)? = true;
    }
    let mut numbers = vec![0; points.len()];
    let mut kept = Vec::new();
    for (number, point) in points.iter().enumerate() {
        numbers[number] = u32::try_from(kept.len()).ok()?;
        if used[number] {
            kept.push(*point);
        }
    }
    let renumbered: Vec<Vec<u32>> = loops
        .iter()
        .map(|face| {
            face.iter()
                .map(|&corner| numbers[corner as usize])
                .collect()
        })
        .collect();
    Polytope::new(kept, &renumbered).ok()
}

fn as_loop(corners: &[usize]) -> Vec<u32> {
    // At most some hundred corners.
    corners
        .iter()
        .map(|&corner| u32::try_from(corner).unwrap_or(0))
        .collect()
}

/// The faces of a hull: triangles that lie in one plane become a polygon.
fn faces(hull: &Hull, flat: f64) -> Vec<Vec<u32>> {
    let area = |corners: &[usize; 3]| {
        let [a, b, c] = corners.map(|corner| hull.points[corner]);
        (b - a).cross(&(c - a)).norm_squared()
    };
    let mut order: Vec<usize> = (0..hull.triangles.len()).collect();
    order.sort_by(|&one, &other| {
        area(&hull.triangles[other]).total_cmp(&area(&hull.triangles[one]))
    });
    let mut taken = vec![false; hull.triangles.len()];
    let mut loops = Vec::new();
    for &seed in &order {
        if taken[seed] {
            continue;
        }
        taken[seed] = true;
        let mut region = vec![hull.triangles[seed]];
        if let Some(plane) =
            Plane::of_triangle(hull.triangles[seed].map(|corner| hull.points[corner]))
        {
            grow(hull, &plane, flat, &mut taken, &mut region);
        }
        match border(&region) {
            Some(face) => loops.push(face),
            None => loops.extend(region.iter().map(|corners| as_loop(corners))),
        }
    }
    loops
}

/// Adds the neighbours in the plane, and theirs.
fn grow(hull: &Hull, plane: &Plane, flat: f64, taken: &mut [bool], region: &mut Vec<[usize; 3]>) {
    let is_flat = |corners: &[usize; 3]| {
        corners
            .iter()
            .all(|&corner| plane.height(&hull.points[corner]).abs() <= flat)
    };
    let mut looked = 0;
    while looked < region.len() {
        let [a, b, c] = region[looked];
        looked += 1;
        for [from, to] in [[b, a], [c, b], [a, c]] {
            let next = hull
                .triangles
                .iter()
                .position(|&[a, b, c]| [[a, b], [b, c], [c, a]].contains(&[from, to]));
            if let Some(next) = next
                && !taken[next]
                && is_flat(&hull.triangles[next])
            {
                taken[next] = true;
                region.push(hull.triangles[next]);
            }
        }
    }
}

/// The border of a region, when it is one loop that meets no corner twice.
fn border(region: &[[usize; 3]]) -> Option<Vec<u32>> {
    let around = |&[a, b, c]: &[usize; 3]| [[a, b], [b, c], [c, a]];
    let edges: Vec<[usize; 2]> = region.iter().flat_map(around).collect();
    let outer: Vec<[usize; 2]> = edges
        .iter()
        .copied()
        .filter(|&[from, to]| !edges.contains(&[to, from]))
        .collect();
    let [start, mut at] = *outer.first()?;
    let mut face = vec![start];
    while at != start {
        if face.len() >= outer.len() {
            return None;
        }
        face.push(at);
        let following: Vec<usize> = outer
            .iter()
            .filter(|edge| edge[0] == at)
            .map(|edge| edge[1])
            .collect();
        let [next] = following[..] else { return None };
        at = next;
    }
    (face.len() == outer.len()).then(|| as_loop(&face))
}
