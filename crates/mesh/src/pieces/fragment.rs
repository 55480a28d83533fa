//! A fragment of a solid between planes: what is left of its triangles, and flat caps where it was cut.
//!
//! A cap is the set of its directed edges, and never becomes triangles: cutting, volume, and what hangs together need
//! the edges alone. Every point is on one side of a cut or on the plane, decided once, and points where edges are cut
//! are made once, so triangles and caps together stay closed whatever is rounded.

use std::collections::{BTreeMap, HashMap};

use nalgebra::Vector3;

/// A plane: points x with `normal`·x = `offset`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    /// Unit vector.
    pub normal: Vector3<f64>,
    /// In metres.
    pub offset: f64,
}

impl Plane {
    /// The plane of a triangle, seen from where it is counterclockwise; none without an area.
    pub(super) fn of_triangle([a, b, c]: [Vector3<f64>; 3]) -> Option<Self> {
        let cross = (b - a).cross(&(c - a));
        let normal = cross.try_normalize(f64::MIN_POSITIVE)?;
        Some(Self {
            normal,
            offset: normal.dot(&a),
        })
    }

    /// How far a point is above, in metres.
    pub(super) fn height(&self, point: &Vector3<f64>) -> f64 {
        self.normal.dot(point) - self.offset
    }
}

/// A flat region where a solid was cut.
#[derive(Clone, Debug)]
pub(super) struct Cap {
    /// Out of the fragment.
    pub normal: Vector3<f64>,
    /// The region is to the left of each edge, seen from outside.
    pub edges: Vec<[u32; 2]>,
}

/// A fragment of a solid.
#[derive(Clone, Debug, Default)]
pub(super) struct Fragment {
    pub points: Vec<Vector3<f64>>,
    pub triangles: Vec<[u32; 3]>,
    pub caps: Vec<Cap>,
}

impl Fragment {
    pub(super) fn triangle(&self, corners: &[u32; 3]) -> [Vector3<f64>; 3] {
        corners.map(|corner| self.points[corner as usize])
    }

    /// What it encloses, in m³.
    pub(super) fn volume(&self) -> f64 {
        let Some(&middle) = self.points.first() else {
            return 0.0;
        };
        let at = |number: u32| self.points[number as usize] - middle;
        let sides: f64 = self
            .triangles
            .iter()
            .map(|&[a, b, c]| at(a).dot(&at(b).cross(&at(c))))
            .sum();
        let caps: f64 = self
            .caps
            .iter()
            .map(|cap| {
                let start = cap
                    .edges
                    .first()
                    .map_or_else(Vector3::zeros, |edge| at(edge[0]));
                let fan = cap
                    .edges
                    .iter()
                    .map(|&[a, b]| start.dot(&at(a).cross(&at(b))));
                fan.sum::<f64>()
            })
            .sum();
        (sides + caps) / 6.0
    }

    /// The fragments below and above a plane. Points within `tolerance` of it count as on it. None where all is on one
    /// side, or where the surface goes through itself so often that its cap would have no bound.
    pub(super) fn cut(&self, plane: &Plane, tolerance: f64) -> Option<(Self, Self)> {
        let mut cutter = Cutter::new(self, plane, tolerance);
        if !cutter.sides.contains(&-1) || !cutter.sides.contains(&1) {
            return None;
        }
        for corners in &self.triangles {
            cutter.cut_triangle(corners);
        }
        for cap in &self.caps {
            cutter.cut_cap(cap)?;
        }
        let Cutter {
            points,
            sides,
            mut halves,
            ..
        } = cutter;
        halves[0].close(&sides, plane.normal);
        halves[1].close(&sides, -plane.normal);
        let [below, above] = halves.map(|half| half.compact(&points));
        Some((below, above))
    }

    /// Leaves out the points that nothing uses.
    fn compact(&self, points: &[Vector3<f64>]) -> Self {
        const UNUSED: u32 = u32::MAX;
        let mut numbers = vec![UNUSED; points.len()];
        let mut kept = Vec::new();
        let mut renumber = |old: u32| {
            let number = &mut numbers[old as usize];
            if *number == UNUSED {
                // No more than were counted in 32 bits before.
                *number = u32::try_from(kept.len()).unwrap_or(UNUSED);
                kept.push(points[old as usize]);
            }
            *number
        };
        let triangles = self
            .triangles
            .iter()
            .map(|corners| corners.map(&mut renumber))
            .collect();
        let mut caps = Vec::new();
        for cap in &self.caps {
            let edges = cap
                .edges
                .iter()
                .map(|edge| edge.map(&mut renumber))
                .collect();
            caps.push(Cap { edges, ..*cap });
        }
        Self {
            points: kept,
            triangles,
            caps,
        }
    }

    /// The fragment of these triangles and cap edges of this one.
    pub(super) fn subset(&self, triangles: Vec<[u32; 3]>, caps: Vec<Cap>) -> Self {
        let chosen = Self {
            points: Vec::new(),
            triangles,
            caps,
        };
        chosen.compact(&self.points)
    }

    /// Adds a cap wherever edges in the plane of the cut are of one side only.
    fn close(&mut self, sides: &[i8], normal: Vector3<f64>) {
        let on_plane = |&[a, b]: &[u32; 2]| sides[a as usize] == 0 && sides[b as usize] == 0;
        let around = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]];
        let of_triangles = self.triangles.iter().flat_map(around);
        let of_caps = self.caps.iter().flat_map(|cap| cap.edges.iter().copied());
        let edges = opposite(of_triangles.chain(of_caps).filter(on_plane));
        if !edges.is_empty() {
            self.caps.push(Cap { normal, edges });
        }
    }
}

/// The edges that turn the sum of these edges to nothing: each in the other direction, pairs of opposites left out.
fn opposite(edges: impl Iterator<Item = [u32; 2]>) -> Vec<[u32; 2]> {
    let mut all: Vec<(u32, u32, bool)> = edges.map(|[a, b]| (a.min(b), a.max(b), a < b)).collect();
    all.sort_unstable();
    let mut left = Vec::new();
    for group in all.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1)) {
        let (low, high, _) = group[0];
        let forward = group.iter().filter(|edge| edge.2).count();
        let backward = group.len() - forward;
        let (edge, count) = if forward > backward {
            ([high, low], forward - backward)
        } else {
            ([low, high], backward - forward)
        };
        left.extend(std::iter::repeat_n(edge, count));
    }
    left
}

/// A cut while it is made.
struct Cutter {
    points: Vec<Vector3<f64>>,
    heights: Vec<f64>,
    /// -1 below, 0 on the plane, 1 above.
    sides: Vec<i8>,
    /// Points where edges are cut, by their ends.
    crossings: HashMap<[u32; 2], u32>,
    normal: Vector3<f64>,
    /// Below and above.
    halves: [Fragment; 2],
}

impl Cutter {
    fn new(fragment: &Fragment, plane: &Plane, tolerance: f64) -> Self {
        let heights: Vec<f64> = fragment
            .points
            .iter()
            .map(|point| plane.height(point))
            .collect();
        let side = |&height: &f64| i8::from(height > tolerance) - i8::from(height < -tolerance);
        Self {
            points: fragment.points.clone(),
            sides: heights.iter().map(side).collect(),
            heights,
            crossings: HashMap::new(),
            normal: plane.normal,
            halves: Default::default(),
        }
    }

    /// The point where an edge goes through the plane; the same for both directions.
    fn crossing(&mut self, a: u32, b: u32) -> u32 {
        let ends = [a.min(b), a.max(b)];
        if let Some(&known) = self.crossings.get(&ends) {
            return known;
        }
        let [low, high] = ends.map(|end| end as usize);
        let share = self.heights[low] / (self.heights[low] - self.heights[high]);
        let number = u32::try_from(self.points.len()).unwrap_or(u32::MAX);
        self.points
            .push(self.points[low].lerp(&self.points[high], share));
        self.heights.push(0.0);
        self.sides.push(0);
        self.crossings.insert(ends, number);
        number
    }

    fn cut_triangle(&mut self, corners: &[u32; 3]) {
        let sides = corners.map(|corner| self.sides[corner as usize]);
        if sides.iter().all(|&side| side <= 0) || sides.iter().all(|&side| side >= 0) {
            let sum: i8 = sides.iter().sum();
            let above = match sum {
                0 => {
                    // In the plane: it belongs to the fragment that it bounds.
                    let [a, b, c] = corners.map(|corner| self.points[corner as usize]);
                    (b - a).cross(&(c - a)).dot(&self.normal) < 0.0
                }
                sum => sum > 0,
            };
            self.halves[usize::from(above)].triangles.push(*corners);
            return;
        }
        // At most four corners on each side.
        let mut polygons = [[0; 4]; 2];
        let mut counts = [0; 2];
        let mut add = |half: usize, corner: u32| {
            polygons[half][counts[half]] = corner;
            counts[half] += 1;
        };
        for index in 0..3 {
            let (from, to) = (corners[index], corners[(index + 1) % 3]);
            let (side, next) = (sides[index], sides[(index + 1) % 3]);
            if side <= 0 {
                add(0, from);
            }
            if side >= 0 {
                add(1, from);
            }
            if side * next < 0 {
                let crossing = self.crossing(from, to);
                add(0, crossing);
                add(1, crossing);
            }
        }
        for half in 0..2 {
            let polygon = &polygons[half][..counts[half]];
            for second in 1..polygon.len().saturating_sub(1) {
                let triangle = [polygon[0], polygon[second], polygon[second + 1]];
                self.halves[half].triangles.push(triangle);
            }
        }
    }

    /// `None` where the surface goes through itself too often.
    fn cut_cap(&mut self, cap: &Cap) -> Option<()> {
        let side = |end: u32, sides: &[i8]| sides[end as usize];
        let mut ends = cap.edges.iter().flatten();
        let below = ends.clone().any(|&end| side(end, &self.sides) < 0);
        let above = ends.any(|&end| side(end, &self.sides) > 0);
        if !(below && above) {
            let half = if below || above {
                above
            } else {
                cap.normal.dot(&self.normal) < 0.0
            };
            self.halves[usize::from(half)].caps.push(cap.clone());
            return Some(());
        }
        let mut regions = [Vec::new(), Vec::new()];
        for &[from, to] in &cap.edges {
            match (side(from, &self.sides), side(to, &self.sides)) {
                // Edges in the plane come again when the regions are closed.
                (0, 0) => {}
                (-1 | 0, -1 | 0) => regions[0].push([from, to]),
                (0 | 1, 0 | 1) => regions[1].push([from, to]),
                (start, _) => {
                    let crossing = self.crossing(from, to);
                    let first = usize::from(start > 0);
                    regions[first].push([from, crossing]);
                    regions[1 - first].push([crossing, to]);
                }
            }
        }
        let along = self.normal.cross(&cap.normal);
        for (half, mut edges) in regions.into_iter().enumerate() {
            close_region(&mut edges, &self.points, &along)?;
            if !edges.is_empty() {
                let normal = cap.normal;
                self.halves[half].caps.push(Cap { normal, edges });
            }
        }
        Some(())
    }
}

/// Adds the edges that are missing along a line, between neighbours in its direction.
fn close_region(
    edges: &mut Vec<[u32; 2]>,
    points: &[Vector3<f64>],
    along: &Vector3<f64>,
) -> Option<()> {
    let mut balance = BTreeMap::<u32, i64>::new();
    for &[from, to] in edges.iter() {
        *balance.entry(from).or_default() -= 1;
        *balance.entry(to).or_default() += 1;
    }
    let mut open: Vec<(f64, u32, i64)> = balance
        .into_iter()
        .filter(|&(_, missing)| missing != 0)
        .map(|(point, missing)| (points[point as usize].dot(along), point, missing))
        .collect();
    open.sort_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
    let most = 4 * edges.len() + 1000;
    let mut carried = 0_i64;
    for pair in open.windows(2) {
        let ((_, from, missing), (_, to, _)) = (pair[0], pair[1]);
        carried += missing;
        let edge = if carried > 0 { [from, to] } else { [to, from] };
        let count = usize::try_from(carried.unsigned_abs()).ok()?;
        if edges.len().saturating_add(count) > most {
            return None;
        }
        edges.extend(std::iter::repeat_n(edge, count));
    }
    Some(())
}
