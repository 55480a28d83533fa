//! The meshes of a scene: a number for each, and its bytes as a page reads them. Pure.
//!
//! Layout, little endian: number of points (u32), number of triangles (u32), the points as x, y, z (f32, m, in the
//! frame of the mesh), the corners of each triangle as indices of points (u32, counterclockwise from outside).

use std::sync::Arc;

use mesh::Mesh;

use crate::programs::content_mark;

/// Numbers of meshes while a scene is described.
#[derive(Debug, Default)]
pub(crate) struct MeshNumbers(Vec<Arc<Mesh>>);

impl MeshNumbers {
    /// The number of a mesh; one that several things share has one.
    pub(crate) fn of(&mut self, mesh: &Arc<Mesh>) -> usize {
        let known = self.0.iter().position(|known| Arc::ptr_eq(known, mesh));
        known.unwrap_or_else(|| {
            self.0.push(mesh.clone());
            self.0.len() - 1
        })
    }

    /// The meshes that have numbers, as bytes.
    pub(crate) fn encoded(self) -> SceneMeshes {
        let meshes = self.0.iter().map(|mesh| {
            let bytes: Arc<[u8]> = encode(mesh).into();
            let mark = content_mark(&bytes);
            MeshBytes { bytes, mark }
        });
        SceneMeshes(meshes.collect())
    }
}

/// The bytes of every mesh of a scene, by number; made once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneMeshes(Arc<[MeshBytes]>);

/// A mesh as it is sent.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshBytes {
    /// Counts, points, triangles.
    pub bytes: Arc<[u8]>,
    /// Other bytes have another one.
    pub mark: String,
}

impl SceneMeshes {
    /// The mesh of a number.
    pub fn get(&self, number: usize) -> Option<&MeshBytes> {
        self.0.get(number)
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.0.len()
    }
}

fn encode(mesh: &Mesh) -> Vec<u8> {
    let (points, triangles) = (mesh.points(), mesh.triangles());
    let mut bytes = Vec::with_capacity(8 + 12 * (points.len() + triangles.len()));
    for count in [points.len(), triangles.len()] {
        // Indices are u32 and triangles are bounded, so neither is larger; a page refuses counts that do not fit the
        // bytes.
        let count = u32::try_from(count).unwrap_or(u32::MAX);
        bytes.extend_from_slice(&count.to_le_bytes());
    }
    for point in points {
        for x in point.iter() {
            // Single precision is 8 µm at 100 m, the farthest corner of a solid, and far below a pixel.
            let x = *x as f32;
            bytes.extend_from_slice(&x.to_le_bytes());
        }
    }
    for corner in triangles.iter().flatten() {
        bytes.extend_from_slice(&corner.to_le_bytes());
    }
    bytes
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use std::path::Path;

    /// A corner of a unit cube, 1 m along the axes.
    pub(crate) const TETRAHEDRON: &str =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

    /// A cell whose file `corner.obj` lies beside it.
    pub(crate) fn cell_with_corner(text: &str) -> controller::cell::Cell {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("corner.obj"), TETRAHEDRON).unwrap();
        let file = folder.path().join("cell.toml");
        std::fs::write(&file, text).unwrap();
        controller::cell::Cell::load(Path::new(&file)).unwrap()
    }

    fn tetrahedron() -> Arc<Mesh> {
        struct Text;
        impl mesh::MeshFiles for Text {
            fn read(&mut self, _: &str, _: u64) -> Result<Vec<u8>, mesh::FileError> {
                Ok(TETRAHEDRON.into())
            }
        }
        Arc::new(mesh::read("corner.obj", 0.5, &mut Text).unwrap())
    }

    #[test]
    fn a_mesh_has_one_number_and_an_equal_one_another() {
        let (first, second) = (tetrahedron(), tetrahedron());
        let mut numbers = MeshNumbers::default();
        let given = [&first, &second, &first.clone()].map(|mesh| numbers.of(mesh));
        assert_eq!(given, [0, 1, 0]);
        assert_eq!(numbers.encoded().count(), 2);
    }

    #[test]
    fn the_bytes_are_counts_points_and_corners() {
        let mut numbers = MeshNumbers::default();
        numbers.of(&tetrahedron());
        let meshes = numbers.encoded();
        let bytes = &meshes.get(0).unwrap().bytes;
        let words: Vec<u32> = bytes
            .chunks_exact(4)
            .map(|word| u32::from_le_bytes(word.try_into().unwrap()))
            .collect();
        assert_eq!(bytes.len(), 8 + 12 * 4 + 12 * 4);
        assert_eq!(words[..2], [4, 4]);
        let points: Vec<f32> = words[2..14].iter().map(|&w| f32::from_bits(w)).collect();
        let expected = [0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.5];
        assert_eq!(points, expected);
        assert_eq!(words[14..], [0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2]);
        assert!(meshes.get(1).is_none());
    }

    #[test]
    fn other_bytes_have_another_mark() {
        let mut numbers = MeshNumbers::default();
        let (one, other) = (tetrahedron(), {
            let points = tetrahedron().points().iter().map(|p| p * 2.0).collect();
            let triangles = tetrahedron().triangles().to_vec();
            Arc::new(Mesh::new("large", points, triangles).unwrap())
        });
        for mesh in [&one, &other, &tetrahedron()] {
            numbers.of(mesh);
        }
        let meshes = numbers.encoded();
        let mark = |number| meshes.get(number).unwrap().mark.as_str();
        assert_ne!(mark(0), mark(1));
        assert_eq!(mark(0), mark(2));
        assert!(mark(0).starts_with('"') && mark(0).ends_with('"'));
    }
}
