//! Bodies whose numbers are known.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::Arc;

use kinematics::elementary::sin_cos;
use mesh::{FileError, Mesh, MeshFiles, Solid};
use nalgebra::Vector3;

/// Files in memory.
#[derive(Default)]
pub struct Shelf(pub BTreeMap<String, Vec<u8>>);

impl Shelf {
    pub fn of(name: &str, bytes: impl Into<Vec<u8>>) -> Self {
        Self(BTreeMap::from([(name.to_owned(), bytes.into())]))
    }
}

impl MeshFiles for Shelf {
    fn read(&mut self, path: &str, most: u64) -> Result<Vec<u8>, FileError> {
        match self.0.get(path) {
            Some(bytes) if bytes.len() as u64 > most => Err(FileError::TooLong { most }),
            Some(bytes) => Ok(bytes.clone()),
            None => Err(FileError::System(messages::Text::verbatim(format!(
                "there is no {path}"
            )))),
        }
    }
}

pub fn mesh(points: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Mesh {
    let points = points.into_iter().map(Vector3::from).collect();
    Mesh::new("shape", points, triangles).unwrap()
}

pub fn solid(mesh: Mesh) -> Solid {
    Solid::new(Arc::new(mesh)).unwrap()
}

/// A box between two corners.
pub fn block(low: [f64; 3], high: [f64; 3]) -> Mesh {
    let points = (0..8)
        .map(|corner| {
            std::array::from_fn(|axis| {
                if corner >> axis & 1 == 0 {
                    low[axis]
                } else {
                    high[axis]
                }
            })
        })
        .collect();
    let faces = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let triangles = faces
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    mesh(points, triangles)
}

/// A polygon in x and z, drawn along y. `fan` are the triangles of its front, counterclockwise.
pub fn extruded(outline: &[[f64; 2]], front: &[[u32; 3]], width: f64) -> Mesh {
    let count = u32::try_from(outline.len()).unwrap();
    let at = |y: f64| outline.iter().map(move |&[x, z]| [x, y, z]);
    let points = at(0.0).chain(at(width)).collect();
    let mut triangles = front.to_vec();
    triangles.extend(
        front
            .iter()
            .map(|&[a, b, c]| [a + count, c + count, b + count]),
    );
    for one in 0..count {
        let next = (one + 1) % count;
        triangles.push([one, one + count, next + count]);
        triangles.push([one, next + count, next]);
    }
    mesh(points, triangles)
}

pub fn bracket() -> Mesh {
    let outline = [
        [0.0, 0.0],
        [0.3, 0.0],
        [0.3, 0.02],
        [0.02, 0.02],
        [0.02, 0.2],
        [0.0, 0.2],
    ];
    extruded(
        &outline,
        &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]],
        0.05,
    )
}

pub fn fork() -> Mesh {
    let outline = [
        [0.0, 0.0],
        [0.1, 0.0],
        [0.1, 0.3],
        [0.08, 0.3],
        [0.08, 0.03],
        [0.02, 0.03],
        [0.02, 0.3],
        [0.0, 0.3],
    ];
    let front = [
        [0, 1, 4],
        [1, 2, 3],
        [1, 3, 4],
        [0, 4, 5],
        [0, 5, 6],
        [0, 6, 7],
    ];
    extruded(&outline, &front, 0.02)
}

/// A box without a lid: five walls of this thickness.
pub fn bin(size: [f64; 3], wall: f64) -> Mesh {
    let [x, y, z] = size;
    let outer = block([0.0; 3], size);
    let inner = block([wall, wall, wall], [x - wall, y - wall, z]);
    let mut points: Vec<[f64; 3]> = outer.points().iter().map(|&point| point.into()).collect();
    points.extend(inner.points().iter().map(|&point| <[f64; 3]>::from(point)));
    // The lids of both are left out, and a rim is between them.
    let is_lid = |corners: &&[u32; 3]| corners.iter().all(|corner| corner & 4 != 0);
    let mut triangles: Vec<[u32; 3]> = outer
        .triangles()
        .iter()
        .filter(|corners| !is_lid(corners))
        .copied()
        .collect();
    let walls = inner.triangles().iter().filter(|corners| !is_lid(corners));
    triangles.extend(walls.map(|&[a, b, c]| [a + 8, c + 8, b + 8]));
    for (one, next) in [(4, 5), (5, 7), (7, 6), (6, 4)] {
        triangles.push([one, next, next + 8]);
        triangles.push([one, next + 8, one + 8]);
    }
    mesh(points, triangles)
}

/// A grid that is closed in both directions.
fn closed_grid(columns: u32, rows: u32, at: impl Fn(f64, f64) -> [f64; 3]) -> Mesh {
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    for column in 0..columns {
        for row in 0..rows {
            points.push(at(
                f64::from(column) / f64::from(columns) * TAU,
                f64::from(row) / f64::from(rows) * TAU,
            ));
            let number = |column: u32, row: u32| (column % columns) * rows + row % rows;
            let corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
                .map(|(right, up)| number(column + right, row + up));
            triangles.push([corners[0], corners[1], corners[2]]);
            triangles.push([corners[0], corners[2], corners[3]]);
        }
    }
    mesh(points, triangles)
}

/// A ring about z.
pub fn torus(ring: f64, tube: f64, columns: u32, rows: u32) -> Mesh {
    closed_grid(columns, rows, |around, across| {
        let (sin_around, cos_around) = sin_cos(around);
        let (sin_across, cos_across) = sin_cos(across);
        let from_axis = ring + tube * cos_across;
        [
            from_axis * cos_around,
            from_axis * sin_around,
            tube * sin_across,
        ]
    })
}

/// A ball as a cube whose faces are divided and blown up.
pub fn ball(radius: f64, divisions: u32) -> Mesh {
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    for axis in 0..3_usize {
        for sign in [-1.0, 1.0] {
            let first = u32::try_from(points.len()).unwrap();
            let place = |step: u32| 2.0 * f64::from(step) / f64::from(divisions) - 1.0;
            for i in 0..=divisions {
                for j in 0..=divisions {
                    let mut point = Vector3::zeros();
                    point[axis] = sign;
                    point[(axis + 1) % 3] = place(i);
                    point[(axis + 2) % 3] = place(j);
                    // A length of its sum in a fixed order, so that points on the edges of the cube are equal.
                    let length = (point.x * point.x + point.y * point.y + point.z * point.z).sqrt();
                    points.push((point * (radius / length)).into());
                    if i < divisions && j < divisions {
                        let number = |i: u32, j: u32| first + i * (divisions + 1) + j;
                        let [a, b, c, d] = [
                            number(i, j),
                            number(i + 1, j),
                            number(i + 1, j + 1),
                            number(i, j + 1),
                        ];
                        if sign > 0.0 {
                            triangles.extend([[a, b, c], [a, c, d]]);
                        } else {
                            triangles.extend([[a, c, b], [a, d, c]]);
                        }
                    }
                }
            }
        }
    }
    mesh(points, triangles)
}

/// The one mesh beside the other.
pub fn both(one: &Mesh, other: &Mesh) -> Mesh {
    let shift = u32::try_from(one.points().len()).unwrap();
    let points = one.points().iter().chain(other.points()).copied().collect();
    let shifted = other
        .triangles()
        .iter()
        .map(|corners| corners.map(|corner| corner + shift));
    Mesh::new(
        "both",
        points,
        one.triangles().iter().copied().chain(shifted).collect(),
    )
    .unwrap()
}

/// The mesh inside out.
pub fn turned(mesh: &Mesh) -> Mesh {
    let triangles = mesh
        .triangles()
        .iter()
        .map(|&[a, b, c]| [a, c, b])
        .collect();
    Mesh::new("turned", mesh.points().to_vec(), triangles).unwrap()
}
