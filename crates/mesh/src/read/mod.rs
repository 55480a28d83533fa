//! The formats: one file or folder each.

mod gltf;
mod obj;
mod stl;

use messages::{Text, text};
use nalgebra::Vector3;

use crate::error::{FilePosition, MeshError};
use crate::files::MeshFiles;
use crate::mesh::Mesh;
use crate::{MAX_FILE_BYTES, MAX_TRIANGLES};

/// Reads a mesh; the ending of the name says which format, in any case, and the content which of the two of STL.
///
/// `scale` is the length of one unit of the file in metres. Axes stay as they are in the file: glTF says that y points
/// up, and so it does in the mesh.
///
/// # Errors
/// What is wrong, with the file and the place in it.
pub fn read(file: &str, scale: f64, files: &mut dyn MeshFiles) -> Result<Mesh, MeshError> {
    if !scale.is_finite() || scale <= 0.0 {
        return Err(MeshError::Scale {
            file: file.to_owned(),
            scale,
        });
    }
    let ending = file
        .rsplit_once('.')
        .map(|(_, ending)| ending.to_ascii_lowercase());
    let format = match ending.as_deref() {
        Some("stl") => Format::Stl,
        Some("obj") => Format::Obj,
        Some("gltf" | "glb") => Format::Gltf,
        _ => {
            return Err(MeshError::Format {
                file: file.to_owned(),
            });
        }
    };
    let bytes = files
        .read(file, MAX_FILE_BYTES)
        .map_err(|source| MeshError::File {
            file: file.to_owned(),
            source,
        })?;
    let mut soup = Soup::new(file, scale);
    match format {
        Format::Stl => stl::read(&bytes, &mut soup)?,
        Format::Obj => obj::read(&bytes, &mut soup)?,
        Format::Gltf => gltf::read(&bytes, &mut soup, files)?,
    }
    soup.finish()
}

/// What a file may be.
enum Format {
    Stl,
    Obj,
    Gltf,
}

/// Triangles while they are read.
struct Soup<'a> {
    file: &'a str,
    scale: f64,
    points: Vec<Vector3<f64>>,
    triangles: Vec<[u32; 3]>,
}

impl<'a> Soup<'a> {
    fn new(file: &'a str, scale: f64) -> Self {
        Self {
            file,
            scale,
            points: Vec::new(),
            triangles: Vec::new(),
        }
    }

    /// The error at a place of the file.
    fn damaged(&self, place: FilePosition, trouble: Text) -> MeshError {
        MeshError::Damaged {
            file: self.file.to_owned(),
            place,
            trouble,
        }
    }

    /// Adds a point in units of the file.
    fn add_point(&mut self, place: &FilePosition, point: Vector3<f64>) -> Result<u32, MeshError> {
        let number = self.points.len();
        if number >= 3 * MAX_TRIANGLES {
            let trouble = text!(
                "there are more than {} points, the most that is allowed",
                "点超过 {} 个，即允许的上限",
                3 * MAX_TRIANGLES
            );
            return Err(self.damaged(place.clone(), trouble));
        }
        let scaled = point * self.scale;
        if scaled.iter().any(|x| !x.is_finite()) {
            let trouble = text!(
                "a point is at ({}, {}, {}) times {}; allowed are finite numbers",
                "点位于 ({}, {}, {})，再乘以 {}；只允许有限的数",
                point.x,
                point.y,
                point.z,
                self.scale
            );
            return Err(self.damaged(place.clone(), trouble));
        }
        self.points.push(scaled);
        u32::try_from(number)
            .map_err(|_| self.damaged(place.clone(), text!("there are too many points", "点过多")))
    }

    /// Adds a triangle of points that are there.
    fn add_triangle(&mut self, place: &FilePosition, corners: [u32; 3]) -> Result<(), MeshError> {
        if self.triangles.len() >= MAX_TRIANGLES {
            return Err(MeshError::TooManyTriangles {
                file: self.file.to_owned(),
                place: place.clone(),
            });
        }
        self.triangles.push(corners);
        Ok(())
    }

    fn finish(self) -> Result<Mesh, MeshError> {
        if self.triangles.is_empty() {
            return Err(MeshError::Empty {
                file: self.file.to_owned(),
            });
        }
        Mesh::new(self.file, self.points, self.triangles)
    }
}
