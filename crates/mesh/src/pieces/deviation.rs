//! How far convex pieces reach beyond a solid: bounds that are proven, not sampled.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::ops::Range;

use nalgebra::Vector3;

use super::distance::SolidDistance;
use super::fragment::{Fragment, Plane};
use super::hull::Hull;
use crate::solid::bounds_of;

/// A bound is good enough when it is this little above what was found.
const SHARE: f64 = 0.02;
/// A bound above what was found by less than this is good enough as well, in metres.
const MARGIN_M: f64 = 1e-6;
/// A fragment that is farther than this from its hull, in metres, is not convex but for rounding.
const NEAR_M: f64 = 1e-4;

/// A bound for a fragment that is convex but for rounding: how far a point of its hull may be from it. None for others.
///
/// Let every triangle and cap have a point c at least r below its plane, and every corner at most h above it. Rays from
/// c leave the fragment once, so what is below all planes is in the fragment. The hull is at most h above them; made
/// smaller towards c by r/(r + h) it is below them all, so each of its points is within h/(r + h) of its diameter from
/// the fragment.
pub(super) fn of_convex(fragment: &Fragment, middle: &Vector3<f64>, tolerance: f64) -> Option<f64> {
    let mut radius = f64::INFINITY;
    let mut planes = Vec::with_capacity(fragment.triangles.len());
    let mut above = 0.0_f64;
    for corners in &fragment.triangles {
        let [a, b, c] = fragment.triangle(corners);
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        match Plane::of_triangle([a, b, c]) {
            Some(plane) if (b - a).cross(&(c - a)).norm() > longest * tolerance => {
                planes.push(plane)
            }
            // Too narrow to have a side: the fragment without it is as good but for this.
            _ => above = above.max(tolerance),
        }
    }
    for cap in &fragment.caps {
        let heights = cap
            .edges
            .iter()
            .flatten()
            .map(|&end| cap.normal.dot(&fragment.points[end as usize]));
        let offset = heights.fold(f64::INFINITY, f64::min);
        let normal = cap.normal;
        planes.push(Plane { normal, offset });
    }
    for plane in &planes {
        radius = radius.min(-plane.height(middle));
        if radius <= 0.0 {
            return None;
        }
    }
    let (low, high) = bounds_of(fragment.points.iter().copied());
    let diameter = (high - low).norm();
    let boxes = PointBoxes::new(&fragment.points);
    for plane in &planes {
        above = boxes.highest(plane, above);
        if above / radius * diameter > NEAR_M {
            return None;
        }
    }
    Some(above / (radius + above) * diameter)
}

/// Points in boxes, for the highest above a plane.
struct PointBoxes {
    points: Vec<Vector3<f64>>,
    /// In the order of a depth-first walk.
    boxes: Vec<PointBox>,
}

/// A box around some of the points.
struct PointBox {
    low: Vector3<f64>,
    high: Vector3<f64>,
    /// Where the walk goes on without what is in the box.
    after: usize,
    /// The points of a box that is not divided.
    leaf: Range<usize>,
}

impl PointBoxes {
    fn new(points: &[Vector3<f64>]) -> Self {
        let mut own = Self {
            points: points.to_vec(),
            boxes: Vec::new(),
        };
        own.divide(0..points.len());
        own
    }

    fn divide(&mut self, range: Range<usize>) {
        let points = &mut self.points[range.clone()];
        let (low, high) = bounds_of(points.iter().copied());
        let own = self.boxes.len();
        let is_leaf = points.len() <= 8;
        let leaf = if is_leaf { range.clone() } else { 0..0 };
        self.boxes.push(PointBox {
            low,
            high,
            after: 0,
            leaf,
        });
        if !is_leaf {
            let axis = (high - low).imax();
            let half = points.len() / 2;
            points.select_nth_unstable_by(half, |one, other| one[axis].total_cmp(&other[axis]));
            let middle = range.start + half;
            self.divide(range.start..middle);
            self.divide(middle..range.end);
        }
        self.boxes[own].after = self.boxes.len();
    }

    /// The height of the highest point above a plane, or `least` if that is more.
    fn highest(&self, plane: &Plane, least: f64) -> f64 {
        let mut best = least;
        let mut at = 0;
        let far = |n: f64, low: f64, high: f64| n * if n > 0.0 { high } else { low };
        while let Some(around) = self.boxes.get(at) {
            let top = plane
                .normal
                .zip_zip_map(&around.low, &around.high, far)
                .sum();
            if top - plane.offset <= best {
                at = around.after;
                continue;
            }
            for point in &self.points[around.leaf.clone()] {
                best = best.max(plane.height(point));
            }
            at += 1;
        }
        best
    }
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

/// No point of the hulls is farther from the solid than this, in metres. Cubes are divided where the bound is greatest,
/// at most `cells` of them; a distance changes no faster than the point moves.
pub(super) fn of_hulls(hulls: &[&Hull], solid: &SolidDistance, cells: usize) -> f64 {
    let mut search = Search {
        hulls,
        solid,
        found: 0.0,
        heap: BinaryHeap::new(),
        asked: 0,
    };
    for (number, hull) in hulls.iter().enumerate() {
        let (low, high) = bounds_of(hull.points.iter().copied());
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
        let distance = self.solid.distance(&middle);
        self.asked += 1;
        // To know the side costs as much as to know the distance, so it is asked only where it changes something.
        let in_hull = height <= 0.0;
        let inside = (distance >= radius || (in_hull && distance > self.found))
            && self.solid.encloses(&middle);
        if inside && distance >= radius {
            return;
        }
        if in_hull && !inside {
            self.found = self.found.max(distance);
        }
        let most = if inside {
            radius - distance
        } else {
            radius + distance
        };
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
