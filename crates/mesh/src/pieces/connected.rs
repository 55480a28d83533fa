//! What hangs together in a fragment: surfaces that share points, and caps with their holes.

use nalgebra::Vector3;

use super::fragment::{Cap, Fragment};
use crate::solid::bounds_of;

/// A fragment in more pieces than these is left as one.
const COMPONENTS_MAX: usize = 1000;
/// Loops of a cap times its edges; beyond that all loops count as connected.
const WORK_MAX: usize = 20_000_000;

/// Sets of numbers that are joined by and by.
struct Sets(Vec<u32>);

impl Sets {
    fn new(count: usize) -> Self {
        Self((0..).take(count).collect())
    }

    fn root(&mut self, mut number: u32) -> u32 {
        while self.0[number as usize] != number {
            let above = self.0[self.0[number as usize] as usize];
            self.0[number as usize] = above;
            number = above;
        }
        number
    }

    fn join(&mut self, one: u32, other: u32) {
        let (one, other) = (self.root(one), self.root(other));
        // The smaller number stays the root, so that the order of fragments is that of points.
        self.0[one.max(other) as usize] = one.min(other);
    }
}

/// The connected fragments of a fragment, in the order of their first points.
pub(super) fn components(fragment: Fragment) -> Vec<Fragment> {
    let mut sets = Sets::new(fragment.points.len());
    for &[a, b, c] in &fragment.triangles {
        sets.join(a, b);
        sets.join(b, c);
    }
    for cap in &fragment.caps {
        join_cap(cap, &fragment.points, &mut sets);
    }
    let mut order = vec![usize::MAX; fragment.points.len()];
    let mut count = 0;
    for number in (0_u32..).take(fragment.points.len()) {
        let root = sets.root(number) as usize;
        if order[root] == usize::MAX {
            order[root] = count;
            count += 1;
        }
    }
    if count <= 1 || count > COMPONENTS_MAX {
        return vec![fragment];
    }
    let mut triangles = vec![Vec::new(); count];
    let mut caps: Vec<Vec<Cap>> = vec![Vec::new(); count];
    for corners in &fragment.triangles {
        triangles[order[sets.root(corners[0]) as usize]].push(*corners);
    }
    for cap in &fragment.caps {
        let mut shares = vec![Vec::new(); count];
        for edge in &cap.edges {
            shares[order[sets.root(edge[0]) as usize]].push(*edge);
        }
        for (own, edges) in caps.iter_mut().zip(shares) {
            if !edges.is_empty() {
                own.push(Cap { edges, ..*cap });
            }
        }
    }
    let found = triangles
        .into_iter()
        .zip(caps)
        .map(|(triangles, caps)| fragment.subset(triangles, caps));
    with_hollows(found.collect())
}

/// Puts hollows, whose volume is negative, to the smallest fragment around them.
fn with_hollows(found: Vec<Fragment>) -> Vec<Fragment> {
    let (mut bodies, hollows): (Vec<Fragment>, Vec<Fragment>) = found
        .into_iter()
        .partition(|fragment| fragment.volume() > 0.0);
    if bodies.is_empty() {
        return hollows;
    }
    for hollow in hollows {
        let (low, high) = bounds_of(hollow.points.iter().copied());
        let mut best = (f64::INFINITY, 0);
        for (index, body) in bodies.iter().enumerate() {
            let (body_low, body_high) = bounds_of(body.points.iter().copied());
            let size = (body_high - body_low).norm();
            if body_low.inf(&low) == body_low && body_high.sup(&high) == body_high && size < best.0
            {
                best = (size, index);
            }
        }
        append(&mut bodies[best.1], &hollow);
    }
    bodies
}

/// Adds a fragment to another one.
pub(super) fn append(fragment: &mut Fragment, other: &Fragment) {
    let shift = u32::try_from(fragment.points.len()).unwrap_or(u32::MAX);
    fragment.points.extend_from_slice(&other.points);
    fragment.triangles.extend(
        other
            .triangles
            .iter()
            .map(|corners| corners.map(|corner| corner + shift)),
    );
    fragment.caps.extend(other.caps.iter().map(|cap| {
        Cap {
            edges: cap
                .edges
                .iter()
                .map(|edge| edge.map(|end| end + shift))
                .collect(),
            ..*cap
        }
    }));
}

/// Joins the loops of each region of a cap: an outer one with the holes in it.
fn join_cap(cap: &Cap, points: &[Vector3<f64>], sets: &mut Sets) {
    let mut ends: Vec<u32> = cap.edges.iter().flatten().copied().collect();
    ends.sort_unstable();
    ends.dedup();
    let place = |end: u32| u32::try_from(ends.binary_search(&end).unwrap_or(0)).unwrap_or(0);
    let mut local = Sets::new(ends.len());
    for &[from, to] in &cap.edges {
        local.join(place(from), place(to));
        sets.join(from, to);
    }
    let mut loops = std::collections::BTreeMap::<u32, Loop>::new();
    let across = across(&cap.normal);
    let flat = |end: u32| across.map(|axis| axis.dot(&points[end as usize]));
    for &[from, to] in &cap.edges {
        let own = loops
            .entry(local.root(place(from)))
            .or_insert_with(|| Loop {
                start: from,
                area: 0.0,
                edges: Vec::new(),
            });
        let ([x, y], [next_x, next_y]) = (flat(from), flat(to));
        let [start_x, start_y] = flat(own.start);
        own.area += (x - start_x) * (next_y - start_y) - (next_x - start_x) * (y - start_y);
        own.edges.push([[x, y], [next_x, next_y]]);
    }
    let loops: Vec<Loop> = loops.into_values().collect();
    let holes = loops.iter().filter(|one| one.area < 0.0).count();
    let too_many = holes.saturating_mul(cap.edges.len()) > WORK_MAX;
    for hole in loops.iter().filter(|one| one.area < 0.0) {
        let spot = flat(hole.start);
        let around = loops
            .iter()
            .filter(|one| one.area > 0.0 && !too_many && one.surrounds(spot));
        match around.min_by(|one, other| one.area.total_cmp(&other.area)) {
            Some(outer) => sets.join(hole.start, outer.start),
            None => loops
                .iter()
                .for_each(|other| sets.join(hole.start, other.start)),
        }
    }
}

/// Edges of a cap that are connected, in the plane of the cap.
struct Loop {
    start: u32,
    /// Twice the area to the left, in m².
    area: f64,
    edges: Vec<[[f64; 2]; 2]>,
}

impl Loop {
    fn surrounds(&self, [x, y]: [f64; 2]) -> bool {
        let mut turns = 0;
        for &[[from_x, from_y], [to_x, to_y]] in &self.edges {
            let left = (to_x - from_x) * (y - from_y) - (x - from_x) * (to_y - from_y);
            if from_y <= y && to_y > y && left > 0.0 {
                turns += 1;
            } else if from_y > y && to_y <= y && left < 0.0 {
                turns -= 1;
            }
        }
        turns != 0
    }
}

/// Two axes that make a right-handed frame with this normal.
fn across(normal: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let mut other = Vector3::zeros();
    other[normal.iamin()] = 1.0;
    let first = other.cross(normal).normalize();
    [first, normal.cross(&first)]
}
