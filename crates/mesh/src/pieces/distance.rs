//! Distances of points from a solid, by a tree of boxes around its triangles.

use nalgebra::Vector3;

use crate::mesh::Mesh;
use crate::solid::bounds_of;

/// Triangles of a leaf.
const LEAF: usize = 4;

/// Directions of the rays that tell inside from outside; nothing that people draw has an edge along them.
const RAYS: [Vector3<f64>; 3] = [
    Vector3::new(0.832_117, 0.413_971, 0.369_073),
    Vector3::new(-0.291_373, 0.761_477, -0.579_011),
    Vector3::new(0.173_191, -0.539_167, 0.824_231),
];

/// A closed surface that can be asked how far a point is.
pub(super) struct SolidDistance {
    triangles: Vec<[Vector3<f64>; 3]>,
    nodes: Vec<Node>,
}

/// A box around triangles. The first child of an inner node is the next node.
struct Node {
    low: Vector3<f64>,
    high: Vector3<f64>,
    kind: Kind,
}

enum Kind {
    Leaf { first: usize, end: usize },
    Inner { second: usize },
}

impl SolidDistance {
    pub(super) fn new(mesh: &Mesh) -> Self {
        let corners = mesh.triangles().iter();
        let mut triangles: Vec<[Vector3<f64>; 3]> = corners
            .map(|corners| corners.map(|corner| mesh.points()[corner as usize]))
            .collect();
        let mut nodes = Vec::new();
        build(&mut triangles, 0, &mut nodes);
        Self { triangles, nodes }
    }

    /// How far a point is from the surface, in metres.
    pub(super) fn distance(&self, point: &Vector3<f64>) -> f64 {
        self.nearest_square(point).sqrt()
    }

    fn nearest_square(&self, point: &Vector3<f64>) -> f64 {
        let mut best = f64::INFINITY;
        let mut waiting = vec![(0, 0.0)];
        while let Some((number, away)) = waiting.pop() {
            if away >= best {
                continue;
            }
            match self.nodes[number].kind {
                Kind::Leaf { first, end } => {
                    for triangle in &self.triangles[first..end] {
                        best = best.min(to_triangle(point, triangle));
                    }
                }
                Kind::Inner { second } => {
                    let one = (number + 1, self.nodes[number + 1].square_from(point));
                    let other = (second, self.nodes[second].square_from(point));
                    let (near, far) = if one.1 <= other.1 {
                        (one, other)
                    } else {
                        (other, one)
                    };
                    waiting.push(far);
                    waiting.push(near);
                }
            }
        }
        best
    }

    /// Whether the surface goes around a point. Two of three rays decide, since one may meet an edge.
    pub(super) fn encloses(&self, point: &Vector3<f64>) -> bool {
        let first = self.turns(point, &RAYS[0]) != 0;
        let second = self.turns(point, &RAYS[1]) != 0;
        if first == second {
            first
        } else {
            self.turns(point, &RAYS[2]) != 0
        }
    }

    /// How often a ray leaves through the surface, less how often it enters.
    fn turns(&self, point: &Vector3<f64>, ray: &Vector3<f64>) -> i64 {
        let inverse = ray.map(|x| 1.0 / x);
        let mut sum = 0;
        let mut waiting = vec![0];
        while let Some(number) = waiting.pop() {
            let node = &self.nodes[number];
            if !node.is_met(point, &inverse) {
                continue;
            }
            match node.kind {
                Kind::Leaf { first, end } => {
                    let triangles = self.triangles[first..end].iter();
                    sum += triangles
                        .map(|triangle| crossing(point, ray, triangle))
                        .sum::<i64>();
                }
                Kind::Inner { second } => waiting.extend([second, number + 1]),
            }
        }
        sum
    }
}

impl Node {
    fn square_from(&self, point: &Vector3<f64>) -> f64 {
        (self.low - point)
            .sup(&(point - self.high))
            .sup(&Vector3::zeros())
            .norm_squared()
    }

    fn is_met(&self, point: &Vector3<f64>, inverse: &Vector3<f64>) -> bool {
        let one = (self.low - point).component_mul(inverse);
        let other = (self.high - point).component_mul(inverse);
        // A little wider, so that rounding loses nothing.
        let leave = one.sup(&other).min();
        one.inf(&other).max() <= leave + leave.abs() * 1e-12 + 1e-12 && leave >= -1e-12
    }
}

/// Makes the node of these triangles and all below it; `first` is the place of the slice in the whole.
fn build(triangles: &mut [[Vector3<f64>; 3]], first: usize, nodes: &mut Vec<Node>) {
    let (low, high) = bounds_of(triangles.iter().flatten().copied());
    let count = triangles.len();
    let own = nodes.len();
    nodes.push(Node {
        low,
        high,
        kind: Kind::Leaf {
            first,
            end: first + count,
        },
    });
    if count <= LEAF {
        return;
    }
    // Halves, so that the depth is the logarithm of the count whatever the triangles are.
    let axis = (high - low).imax();
    let middle =
        |triangle: &[Vector3<f64>; 3]| triangle.iter().map(|corner| corner[axis]).sum::<f64>();
    triangles.select_nth_unstable_by(count / 2, |one, other| {
        middle(one).total_cmp(&middle(other))
    });
    let (left, right) = triangles.split_at_mut(count / 2);
    build(left, first, nodes);
    let second = nodes.len();
    build(right, first + count / 2, nodes);
    nodes[own].kind = Kind::Inner { second };
}

/// 1 where a ray leaves through a triangle, -1 where it enters, 0 where it misses.
fn crossing(point: &Vector3<f64>, ray: &Vector3<f64>, [a, b, c]: &[Vector3<f64>; 3]) -> i64 {
    let (a, b, c) = (a - point, b - point, c - point);
    // An edge gives one number, with opposite signs in its two triangles, so there is no gap between neighbours.
    let edge = |from: &Vector3<f64>, to: &Vector3<f64>| ray.dot(&from.cross(to));
    let weights = [edge(&b, &c), edge(&c, &a), edge(&a, &b)];
    let sum: f64 = weights.iter().sum();
    let outward = weights.iter().all(|&weight| weight >= 0.0) && sum > 0.0;
    let inward = weights.iter().all(|&weight| weight <= 0.0) && sum < 0.0;
    let ahead = a.dot(&(b - a).cross(&(c - a)));
    if outward && ahead > 0.0 {
        1
    } else if inward && ahead < 0.0 {
        -1
    } else {
        0
    }
}

/// The square of the distance of a point from a triangle, which may be a line or a point.
pub(super) fn to_triangle(point: &Vector3<f64>, [a, b, c]: &[Vector3<f64>; 3]) -> f64 {
    let normal = (b - a).cross(&(c - a));
    let area_square = normal.norm_squared();
    let above = area_square > 0.0
        && [(a, b), (b, c), (c, a)]
            .iter()
            .all(|(from, to)| (*to - *from).cross(&(point - *from)).dot(&normal) >= 0.0);
    if above {
        let height = normal.dot(&(point - a));
        return height * height / area_square;
    }
    let sides = [(a, b), (b, c), (c, a)].map(|(from, to)| to_segment(point, from, to));
    sides.into_iter().fold(f64::INFINITY, f64::min)
}

fn to_segment(point: &Vector3<f64>, from: &Vector3<f64>, to: &Vector3<f64>) -> f64 {
    let along = to - from;
    let length_square = along.norm_squared();
    let share = if length_square > 0.0 {
        (along.dot(&(point - from)) / length_square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (point - from - along * share).norm_squared()
}
