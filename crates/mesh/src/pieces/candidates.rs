//! Planes that may cut a fragment well: those of the faces at its hollows, and some across its axes.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3};

use super::fragment::{Fragment, Plane};
use crate::solid::bounds_of;

/// The most planes of faces, and of those that halve angles, that are tried.
const FACES_MAX: usize = 12;
const HALVING_MAX: usize = 6;
/// An edge is hollow where a neighbour rises above a triangle by this share of the fragment's size.
const RISE: f64 = 1e-6;
/// Hollows of less than 20° are those of round surfaces, along whose facets no cut is good: 1 less the cosine.
const SHARP: f64 = 0.06;
/// Where the surface turns by less than 1°, rounding of a flat face may be all there is, rad.
const TURN: f64 = 0.0175;
/// Shares of the length along an axis at which a fragment may be cut.
const SHARES: &[f64] = &[0.25, 0.5, 0.75];
/// A round fragment is halved: rings end as wedges of the same angle.
const HALF: &[f64] = &[0.5];

/// A hollow edge: the planes of its two triangles, and where it begins and ends.
struct Hollow {
    planes: [Plane; 2],
    ends: [Vector3<f64>; 2],
}

impl Hollow {
    /// 1 less the cosine of the angle by which the surface turns at the edge.
    fn sharpness(&self) -> f64 {
        1.0 - self.planes[0].normal.dot(&self.planes[1].normal)
    }
}

/// The edges of triangles at which the surface is hollow.
fn hollows(fragment: &Fragment, size: f64) -> Vec<Hollow> {
    let mut edges = Vec::with_capacity(3 * fragment.triangles.len());
    for (number, &[a, b, c]) in (0_u32..).zip(&fragment.triangles) {
        for (from, to, opposite) in [(a, b, c), (b, c, a), (c, a, b)] {
            edges.push((from.min(to), from.max(to), number, opposite));
        }
    }
    edges.sort_unstable();
    let pairs = edges.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1));
    let hollows = pairs.filter_map(|pair| {
        let [one, other] = pair else { return None };
        let plane = |number: u32| {
            Plane::of_triangle(fragment.triangle(&fragment.triangles[number as usize]))
        };
        let planes = [plane(one.2)?, plane(other.2)?];
        let rise = planes[0].height(&fragment.points[other.3 as usize]);
        (rise >= RISE * size).then(|| Hollow {
            planes,
            ends: [one.0, one.1].map(|end| fragment.points[end as usize]),
        })
    });
    hollows.collect()
}

/// Planes of triangles at sharp hollow edges, those along the longest ones first; and for a fragment whose hollows are
/// all round, those that halve the angle at a hollow edge, which is where the facets of a ring meet.
pub(super) fn of_hollows(fragment: &Fragment) -> HollowPlanes {
    let (low, high) = bounds_of(fragment.points.iter().copied());
    let size = (high - low).norm();
    let hollows = hollows(fragment, size);
    let mut weights = BTreeMap::<[i64; 4], (f64, Plane)>::new();
    for hollow in hollows.iter().filter(|hollow| hollow.sharpness() >= SHARP) {
        let weight = (hollow.ends[0] - hollow.ends[1]).norm() * hollow.sharpness();
        for plane in hollow.planes {
            weights.entry(key(&plane, size)).or_insert((0.0, plane)).0 += weight;
        }
    }
    if weights.is_empty() {
        return HollowPlanes::Round(halving(&hollows, mean_of(&fragment.points), size));
    }
    let mut found: Vec<(f64, Plane)> = weights.into_values().collect();
    found.sort_by(|one, other| other.0.total_cmp(&one.0));
    found.truncate(FACES_MAX);
    HollowPlanes::Sharp(found.into_iter().map(|(_, plane)| plane).collect())
}

/// Planes that hollow edges suggest.
pub(super) enum HollowPlanes {
    /// Of faces that meet at a sharp edge.
    Sharp(Vec<Plane>),
    /// Of a round fragment.
    Round(Vec<Plane>),
}

/// Planes through hollow edges that halve the angle there, those next to the middle first.
fn halving(hollows: &[Hollow], middle: Vector3<f64>, size: f64) -> Vec<Plane> {
    let mut planes = BTreeMap::<[i64; 4], Plane>::new();
    for hollow in hollows {
        let across = hollow.planes[0].normal - hollow.planes[1].normal;
        if let Some(normal) = across.try_normalize(TURN) {
            let plane = Plane {
                normal,
                offset: normal.dot(&hollow.ends[0]),
            };
            planes.entry(key(&plane, size)).or_insert(plane);
        }
    }
    let mut found: Vec<Plane> = planes.into_values().collect();
    found.sort_by(|one, other| {
        let away = |plane: &Plane| plane.height(&middle).abs();
        away(one).total_cmp(&away(other))
    });
    found.truncate(HALVING_MAX);
    found
}

/// A plane as whole numbers, the same for both of its sides and for all triangles of a flat face.
fn key(plane: &Plane, size: f64) -> [i64; 4] {
    let sign = plane.normal[plane.normal.iamax()].signum();
    let normal = plane.normal * sign * 1e4;
    let offset = plane.offset * sign / size * 1e5;
    // All four are far within the range: normals are of length 1, and solids are within some sizes of the origin
    // or so far away that planes of one place share a number at worst.
    [normal.x, normal.y, normal.z, offset].map(|value| value.round() as i64)
}

/// Planes across the axes of the frame and of the fragment's points.
pub(super) fn of_axes(fragment: &Fragment, is_round: bool) -> Vec<Plane> {
    let shares = if is_round { HALF } else { SHARES };
    let mut axes = vec![Vector3::x(), Vector3::y(), Vector3::z()];
    let middle = mean_of(&fragment.points);
    let spread: Matrix3<f64> = fragment
        .points
        .iter()
        .map(|point| (point - middle) * (point - middle).transpose())
        .sum();
    if let Some(found) = spread.try_symmetric_eigen(1e-12, 1000) {
        if is_round {
            axes.clear();
        }
        for axis in found.eigenvectors.column_iter() {
            let axis = axis.into_owned();
            if axes.iter().all(|known| known.dot(&axis).abs() < 0.999) {
                axes.push(axis);
            }
        }
    }
    let mut planes = Vec::new();
    for normal in axes {
        let along = fragment.points.iter().map(|point| normal.dot(point));
        let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        planes.extend(shares.iter().map(|share| Plane {
            normal,
            offset: low + share * (high - low),
        }));
    }
    planes
}

/// The mean of points, which turns with them as the middle of a box around them does not.
fn mean_of(points: &[Vector3<f64>]) -> Vector3<f64> {
    let sum: Vector3<f64> = points.iter().sum();
    sum / points.len().max(1) as f64
}

/// A fragment of about as many triangles at most, for comparing cuts: points near each other become one.
pub(super) fn coarse(fragment: &Fragment, most: usize) -> Fragment {
    let mut fine = 32.0;
    loop {
        if fragment.triangles.len() <= most || fine < 4.0 {
            return fragment.clone();
        }
        let coarse = clustered(fragment, fine);
        if coarse.triangles.len() <= most {
            return coarse;
        }
        fine *= 0.7;
    }
}

fn clustered(fragment: &Fragment, fine: f64) -> Fragment {
    let (low, high) = bounds_of(fragment.points.iter().copied());
    let edge = (high - low).max() / fine;
    let mut cells = BTreeMap::<[i64; 3], u32>::new();
    let mut sums: Vec<(Vector3<f64>, f64)> = Vec::new();
    let mut numbers = Vec::with_capacity(fragment.points.len());
    for point in &fragment.points {
        // Between 0 and the number of cells along an axis.
        let cell = ((point - low) / edge).map(|value| value.floor() as i64);
        let number = *cells.entry(cell.into()).or_insert_with(|| {
            sums.push((Vector3::zeros(), 0.0));
            u32::try_from(sums.len() - 1).unwrap_or(0)
        });
        let (sum, count) = &mut sums[number as usize];
        *sum += point;
        *count += 1.0;
        numbers.push(number);
    }
    let number = |old: u32| numbers[old as usize];
    let triangles = fragment.triangles.iter().map(|corners| corners.map(number));
    let caps = fragment.caps.iter().map(|cap| {
        let edges = cap.edges.iter().map(|edge| edge.map(number));
        super::fragment::Cap {
            edges: edges.filter(|[from, to]| from != to).collect(),
            ..*cap
        }
    });
    Fragment {
        points: sums.iter().map(|(sum, count)| sum / *count).collect(),
        triangles: triangles
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .collect(),
        caps: caps.filter(|cap| !cap.edges.is_empty()).collect(),
    }
}
