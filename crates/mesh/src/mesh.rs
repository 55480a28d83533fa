//! Triangles with common corners.

use std::sync::Arc;

use messages::text;
use nalgebra::Vector3;

use crate::MAX_TRIANGLES;
use crate::error::{FilePosition, MeshError};

/// Triangles as a file has them, in metres. The corners of each are counterclockwise from outside.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// For sentences about it.
    file: Arc<str>,
    points: Vec<Vector3<f64>>,
    triangles: Vec<[u32; 3]>,
}

/// Two meshes are equal when their points and triangles are; the names of their files do not matter.
impl PartialEq for Mesh {
    fn eq(&self, other: &Self) -> bool {
        self.points == other.points && self.triangles == other.triangles
    }
}

impl Mesh {
    /// A mesh of these points, in metres, and these triples of indices of points. `file` is the name in errors.
    ///
    /// # Errors
    /// A coordinate that is no number, an index without a point, or too many triangles.
    pub fn new(
        file: &str,
        points: Vec<Vector3<f64>>,
        triangles: Vec<[u32; 3]>,
    ) -> Result<Self, MeshError> {
        if triangles.len() > MAX_TRIANGLES {
            return Err(MeshError::TooManyTriangles {
                file: file.to_owned(),
                place: FilePosition::Triangle(MAX_TRIANGLES),
            });
        }
        for (number, corners) in triangles.iter().enumerate() {
            for &corner in corners {
                let trouble = match points.get(corner as usize) {
                    Some(point) if point.iter().all(|x| x.is_finite()) => continue,
                    Some(point) => text!(
                        "a corner is at ({}, {}, {}); allowed are finite numbers",
                        "顶点位于 ({}, {}, {})；只允许有限的数",
                        point.x,
                        point.y,
                        point.z
                    ),
                    None => text!(
                        "it names point {corner}; there are {} points",
                        "它引用点 {corner}；只有 {} 个点",
                        points.len()
                    ),
                };
                return Err(MeshError::Damaged {
                    file: file.to_owned(),
                    place: FilePosition::Triangle(number),
                    trouble,
                });
            }
        }
        Ok(Self {
            file: file.into(),
            points,
            triangles,
        })
    }

    /// A mesh whose parts come from another one, so that they need no check.
    pub(crate) fn from_parts(
        file: Arc<str>,
        points: Vec<Vector3<f64>>,
        triangles: Vec<[u32; 3]>,
    ) -> Self {
        Self {
            file,
            points,
            triangles,
        }
    }

    /// The name of the file that it was read from.
    pub fn file(&self) -> &Arc<str> {
        &self.file
    }

    /// The corners, in metres.
    pub fn points(&self) -> &[Vector3<f64>] {
        &self.points
    }

    /// Indices of the corners of each triangle, counterclockwise from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }
}
