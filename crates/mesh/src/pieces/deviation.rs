//! How far convex pieces reach beyond a solid: bounds that are proven, not sampled.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use nalgebra::Vector3;

use super::distance::SolidDistance;
use super::hull::Hull;
use super::part::Part;

/// A bound is good enough when it is this little above what was found.
const SHARE: f64 = 0.02;
/// Or this little, in metres.
const MARGIN_M: f64 = 1e-6;
/// Where the surface of a part is farther than this from its hull, in metres, another proof is tried.
const NEAR_M: f64 = 1e-4;

/// A bound for a part that is convex but for rounding: how far a point of its hull may be from it. None for others.
///
/// Let all of the part's surface be within h of the hull's. The points of the hull that are deeper than h then lie all
/// in the part, since no surface is between them. With a ball of radius r in the hull, the hull made smaller by h/r
/// towards its middle is that deep, so every point of the hull is within h/r of the diameter from the part.
pub(super) fn of_convex(part: &Part, hull: &Hull) -> Option<f64> {
    if (hull.volume - part.volume()).abs() > 0.1 * hull.volume {
        return None;
    }
    let mut farthest = 0.0_f64;
    let mut include = |corners: &mut dyn Iterator<Item = Vector3<f64>>| {
        let corners: Vec<Vector3<f64>> = corners.collect();
        let from = |plane: &super::part::Plane| {
            let heights = corners.iter().map(|corner| plane.height(corner).abs());
            heights.fold(0.0, f64::max)
        };
        farthest = hull
            .planes
            .iter()
            .map(from)
            .fold(f64::INFINITY, f64::min)
            .max(farthest);
        farthest <= NEAR_M
    };
    for corners in &part.triangles {
        if !include(&mut part.triangle(corners).into_iter()) {
            return None;
        }
    }
    for cap in &part.caps {
        let mut ends = cap
            .edges
            .iter()
            .flatten()
            .map(|&end| part.points[end as usize]);
        if !include(&mut ends) {
            return None;
        }
    }
    let radius = -hull.height(&hull.middle());
    (radius > farthest).then(|| farthest / radius * hull.diameter())
}

/// A cube in which the farthest point may be.
struct Cell {
    most: f64,
    /// Later ones are looked at later, so that the order is always the same.
    number: usize,
    hull: usize,
    middle: Vector3<f64>,
    /// Half the edge.
    half: f64,
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Cell {}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Cell {
    fn cmp(&self, other: &Self) -> Ordering {
        self.most
            .total_cmp(&other.most)
            .then(other.number.cmp(&self.number))
    }
}

/// No point of the hulls is farther from the solid than this, in metres. Cubes are divided where the bound is greatest, at most
/// `cells` of them; a distance changes no faster than the point moves.
pub(super) fn of_hulls(hulls: &[&Hull], solid: &SolidDistance, cells: usize) -> f64 {
    let mut search = Search {
        hulls,
        solid,
        found: 0.0,
        heap: BinaryHeap::new(),
        asked: 0,
    };
    for (number, hull) in hulls.iter().enumerate() {
        let (low, high) = crate::solid::bounds_of(hull.points.iter().copied());
        search.add(number, (low + high) / 2.0, (high - low).max() / 2.0);
    }
    while let Some(cell) = search.heap.pop() {
        let enough = search.found + MARGIN_M.max(search.found * SHARE);
        if cell.most <= enough || search.asked >= cells {
            return cell.most.max(search.found);
        }
        let half = cell.half / 2.0;
        for x in [-half, half] {
            for y in [-half, half] {
                for z in [-half, half] {
                    search.add(cell.hull, cell.middle + Vector3::new(x, y, z), half);
                }
            }
        }
    }
    search.found
}

/// The cells that are still open.
struct Search<'a> {
    hulls: &'a [&'a Hull],
    solid: &'a SolidDistance,
    found: f64,
    heap: BinaryHeap<Cell>,
    asked: usize,
}

impl Search<'_> {
    fn add(&mut self, hull: usize, middle: Vector3<f64>, half: f64) {
        let radius = half * 3.0_f64.sqrt();
        let height = self.hulls[hull].height(&middle);
        if height > radius {
            return;
        }
        let distance = self.solid.signed(&middle);
        self.asked += 1;
        if height <= 0.0 {
            self.found = self.found.max(distance);
        }
        let most = distance + radius;
        if most > self.found {
            self.heap.push(Cell {
                most,
                number: self.asked,
                hull,
                middle,
                half,
            });
        }
    }
}
