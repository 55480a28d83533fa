//! What makes a surface a solid, and its volume, centre and inertia.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use crate::error::{MeshError, Spot};
use crate::mesh::Mesh;
use crate::{MAX_COORDINATE_M, MIN_EXTENT_M};

/// The least volume, as a share of the box around the surface: rounding of a closed flat surface makes as much.
const LEAST_VOLUME_SHARE: f64 = 1e-9;

/// A closed surface whose triangles look outward, with what it encloses.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    mesh: Arc<Mesh>,
    volume: f64,
    centre: Vector3<f64>,
    inertia: Matrix3<f64>,
}

impl Solid {
    /// The solid within a mesh. Equal points become one, triangles between fewer than three points and points of no
    /// triangle are left out, and a mesh that is inside out as a whole is turned.
    ///
    /// # Errors
    /// What keeps the mesh from being a solid: coordinates beyond the bounds, an edge that is not of two triangles in
    /// opposite directions, or no volume.
    pub fn new(mesh: Arc<Mesh>) -> Result<Self, MeshError> {
        let file = mesh.file().clone();
        check_coordinates(&mesh)?;
        let (points, point_numbers) = weld(mesh.points());
        let mut triangles = Vec::with_capacity(mesh.triangles().len());
        let mut origins = Vec::with_capacity(mesh.triangles().len());
        for (origin, corners) in (0_u32..).zip(mesh.triangles()) {
            let [a, b, c] = corners.map(|corner| point_numbers[corner as usize]);
            if a != b && b != c && c != a {
                triangles.push([a, b, c]);
                origins.push(origin);
            }
        }
        if triangles.is_empty() {
            return Err(MeshError::Empty {
                file: file.to_string(),
            });
        }
        let points = used_points(&points, &mut triangles);
        check_edges(&file, &points, &triangles, &origins)?;
        let (low, high) = bounds_of(
            triangles
                .iter()
                .flatten()
                .map(|&corner| points[corner as usize]),
        );
        let extent = high - low;
        for (axis, length) in ['x', 'y', 'z'].into_iter().zip(extent.iter()) {
            if *length < MIN_EXTENT_M {
                return Err(MeshError::TooSmall {
                    file: file.to_string(),
                    axis,
                    extent: *length,
                });
            }
        }
        let mut moments = Moments::of(&points, &triangles, (low + high) / 2.0);
        if moments.volume.abs() < LEAST_VOLUME_SHARE * extent.x * extent.y * extent.z {
            return Err(MeshError::NoVolume {
                file: file.to_string(),
                volume: moments.volume,
                x: extent.x,
                y: extent.y,
                z: extent.z,
            });
        }
        if moments.volume < 0.0 {
            for corners in &mut triangles {
                corners.swap(1, 2);
            }
            moments = Moments::of(&points, &triangles, (low + high) / 2.0);
        }
        let unchanged = mesh.points() == points && mesh.triangles() == triangles;
        let mesh = if unchanged {
            mesh
        } else {
            Arc::new(Mesh::from_parts(file, points, triangles))
        };
        Ok(Self {
            mesh,
            volume: moments.volume,
            centre: moments.centre,
            inertia: moments.inertia,
        })
    }

    /// The solid in a point mirror at the origin: every point p becomes −p.
    #[must_use]
    pub fn point_mirrored(&self) -> Self {
        let points = self.mesh.points().iter().map(|point| -point).collect();
        // Mirrored corners run clockwise.
        let triangles = self.mesh.triangles().iter().map(|[a, b, c]| [*a, *c, *b]);
        let file = self.mesh.file().clone();
        Self {
            mesh: Arc::new(Mesh::from_parts(file, points, triangles.collect())),
            volume: self.volume,
            centre: -self.centre,
            inertia: self.inertia,
        }
    }

    /// The closed surface, without doubled points.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// What the surface encloses, in m³.
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// The centre of the volume, in metres.
    pub fn centre(&self) -> Vector3<f64> {
        self.centre
    }

    /// The inertia about the centre for a density of 1 kg/m³, in kg m²; times the density it is that of the body.
    pub fn inertia(&self) -> Matrix3<f64> {
        self.inertia
    }
}

/// The corners of the box around points.
pub(crate) fn bounds_of(
    points: impl Iterator<Item = Vector3<f64>>,
) -> (Vector3<f64>, Vector3<f64>) {
    let mut low = Vector3::repeat(f64::INFINITY);
    let mut high = Vector3::repeat(f64::NEG_INFINITY);
    for point in points {
        low = low.inf(&point);
        high = high.sup(&point);
    }
    (low, high)
}

fn check_coordinates(mesh: &Mesh) -> Result<(), MeshError> {
    for (triangle, corners) in mesh.triangles().iter().enumerate() {
        for &corner in corners {
            let point = mesh.points()[corner as usize];
            if point.amax() > MAX_COORDINATE_M {
                return Err(MeshError::TooFar {
                    file: mesh.file().to_string(),
                    triangle,
                    spot: Spot(point.into()),
                });
            }
        }
    }
    Ok(())
}

/// The points without repetition, and the number that each has there. Those that come first in the file stay first.
fn weld(points: &[Vector3<f64>]) -> (Vec<Vector3<f64>>, Vec<u32>) {
    // Adding zero makes -0 equal to 0 in its bits as well.
    let key = |number: u32| points[number as usize].map(|x| (x + 0.0).to_bits());
    let mut order: Vec<([u64; 3], u32)> = (0_u32..)
        .take(points.len())
        .map(|number| (key(number).into(), number))
        .collect();
    order.sort_unstable();
    // The first in the file of each group of equals.
    let mut first = vec![0_u32; points.len()];
    let mut leader = None::<([u64; 3], u32)>;
    for &(bits, number) in &order {
        let head = match leader {
            Some((same, head)) if same == bits => head,
            _ => {
                leader = Some((bits, number));
                number
            }
        };
        first[number as usize] = head;
    }
    let mut kept = Vec::new();
    let mut numbers = vec![0_u32; points.len()];
    let mut next = 0;
    for (own, &head) in (0_u32..).zip(&first) {
        if head == own {
            kept.push(points[own as usize]);
            numbers[own as usize] = next;
            next += 1;
        } else {
            numbers[own as usize] = numbers[head as usize];
        }
    }
    (kept, numbers)
}

/// The points that triangles have, in their order; the triangles get their new numbers. A point of no triangle, of
/// which files that were cut out of larger ones have many, is no part of the surface and must not widen anything.
fn used_points(points: &[Vector3<f64>], triangles: &mut [[u32; 3]]) -> Vec<Vector3<f64>> {
    let mut is_used = vec![false; points.len()];
    for &corner in triangles.iter().flatten() {
        is_used[corner as usize] = true;
    }
    let mut used = Vec::new();
    let mut numbers = vec![0_u32; points.len()];
    let mut next = 0;
    for ((point, number), is_used) in points.iter().zip(&mut numbers).zip(is_used) {
        if is_used {
            used.push(*point);
            *number = next;
            next += 1;
        }
    }
    for corner in triangles.iter_mut().flatten() {
        *corner = numbers[*corner as usize];
    }
    used
}

/// Each edge is of two triangles, in opposite directions.
fn check_edges(
    file: &str,
    points: &[Vector3<f64>],
    triangles: &[[u32; 3]],
    origins: &[u32],
) -> Result<(), MeshError> {
    let mut edges = Vec::with_capacity(3 * triangles.len());
    for (corners, &origin) in triangles.iter().zip(origins) {
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            let (from, to) = (corners[from], corners[to]);
            let ends = (u64::from(from.min(to)) << 32) | u64::from(from.max(to));
            edges.push((ends, origin, from < to));
        }
    }
    edges.sort_unstable();
    // The trouble that comes first in the file, so that a person finds it.
    let mut worst = None::<(u32, MeshError)>;
    for group in edges.chunk_by(|one, other| one.0 == other.0) {
        if let [one, other] = group
            && one.2 != other.2
        {
            continue;
        }
        let (ends, triangle, forward) = group[0];
        if worst.as_ref().is_some_and(|(first, _)| *first <= triangle) {
            continue;
        }
        let spot = |number: u64| Spot(points[usize::try_from(number).unwrap_or(0)].into());
        let (low, high) = (spot(ends >> 32), spot(ends & u64::from(u32::MAX)));
        let (from, to) = if forward { (low, high) } else { (high, low) };
        let file = file.to_owned();
        let error = match group {
            [_] => MeshError::Open {
                file,
                triangle: triangle as usize,
                from,
                to,
            },
            [_, other] => MeshError::Turned {
                file,
                triangle: triangle as usize,
                other: other.1 as usize,
                from,
                to,
            },
            more => MeshError::Branched {
                file,
                triangle: triangle as usize,
                from,
                to,
                count: more.len(),
            },
        };
        worst = Some((triangle, error));
    }
    match worst {
        Some((_, error)) => Err(error),
        None => Ok(()),
    }
}

/// Integrals over what a surface encloses.
struct Moments {
    volume: f64,
    centre: Vector3<f64>,
    /// About the centre.
    inertia: Matrix3<f64>,
}

impl Moments {
    /// Sums tetrahedra between `middle` and the triangles. `middle` is near them, so that little cancels.
    fn of(points: &[Vector3<f64>], triangles: &[[u32; 3]], middle: Vector3<f64>) -> Self {
        let mut volume = 0.0;
        let mut first = Vector3::zeros();
        let mut second = Matrix3::zeros();
        for corners in triangles {
            let [a, b, c] = corners.map(|corner| points[corner as usize] - middle);
            let six_volumes = a.dot(&b.cross(&c));
            let sum = a + b + c;
            volume += six_volumes / 6.0;
            first += sum * (six_volumes / 24.0);
            // ∫ x xᵀ over a tetrahedron with one corner at the origin is V/20 (Σ p pᵀ + s sᵀ), s being the sum.
            second +=
                (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose())
                    * (six_volumes / 120.0);
        }
        let centre = if volume == 0.0 {
            Vector3::zeros()
        } else {
            first / volume
        };
        let about_centre = second - centre * centre.transpose() * volume;
        Self {
            volume,
            centre: centre + middle,
            inertia: Matrix3::identity() * about_centre.trace() - about_centre,
        }
    }
}
