//! From the keys of a shape to a solid, and from a solid to what contacts, distances and viewers know.
//!
//! One description of a solid, that of the world ([`BodyShape`]), stands between the tables and everybody else. Sizes
//! are checked here; meshes were read before (`meshes`).

use kinematics::Pose;
use messages::{Text, text};
use motion::contact;
use recorder::ObstacleShape;
use world::description::BodyShape;

use super::check::{InvalidValue, MESH_SIZE, TableCheck};
use super::meshes::Meshes;
use super::schema::{Obstacle, ShapeName, Size, Tool};
use super::world_schema::{FingerTable, PartTable};

/// Convex pieces of a mesh where the table names no number.
const DEFAULT_PIECES: usize = 16;

/// Refusal of a mesh without a file.
pub(super) const MESH_FILE: Text = text!(
    "a mesh needs a file: .stl, .obj, .gltf or .glb, beside the cell file or in a folder there",
    "网格需要文件：.stl、.obj、.gltf 或 .glb，与单元文件同在一处或在其下的文件夹中"
);

/// The keys of a shape, in whatever table they stand.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShapeKeys<'a> {
    shape: ShapeName,
    size: &'a Size,
    file: Option<&'a str>,
    scale: Option<f64>,
    pieces: Option<i64>,
}

/// How a mesh is read and cut.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeshKeys<'a> {
    /// Path relative to the folder of the cell file.
    pub(super) file: &'a str,
    /// Metres for a unit of the file.
    pub(super) scale: f64,
    /// Most convex pieces.
    pub(super) pieces: usize,
}

macro_rules! shape_keys {
    ($($table:ty),*) => {$(
        impl $table {
            pub(super) fn shape_keys(&self) -> ShapeKeys<'_> {
                ShapeKeys {
                    shape: self.shape,
                    size: &self.size,
                    file: self.file.as_deref(),
                    scale: self.scale,
                    pieces: self.pieces,
                }
            }
        }
    )*};
}

shape_keys!(Obstacle, Tool, PartTable, FingerTable);

impl<'a> ShapeKeys<'a> {
    /// Whether the keys go together; a plane only where something may be one.
    pub(super) fn check(&self, table: &TableCheck, may_be_plane: bool) -> Result<(), InvalidValue> {
        if self.shape == ShapeName::Plane && !may_be_plane {
            let allowed = text!(
                "allowed are box, cylinder, sphere and mesh",
                "允许 box、cylinder、sphere 和 mesh"
            );
            return Err(table.wrong("shape", "\"plane\"", allowed));
        }
        let of_meshes = [
            ("file", self.file.map(|file| format!("{file:?}"))),
            ("scale", self.scale.map(|scale| scale.to_string())),
            ("pieces", self.pieces.map(|pieces| pieces.to_string())),
        ];
        if self.shape != ShapeName::Mesh {
            if let Some((key, given)) = of_meshes
                .iter()
                .find_map(|(key, given)| Some((key, given.as_ref()?)))
            {
                return Err(table.wrong(
                    key,
                    given,
                    text!(
                        "it goes with shape = \"mesh\"",
                        "它只与 shape = \"mesh\" 一起使用"
                    ),
                ));
            }
            return table.size(self.shape, self.size);
        }
        let numbers = self.size.numbers();
        if !numbers.is_empty() {
            return Err(table.wrong("size", format_args!("{numbers:?}"), MESH_SIZE));
        }
        if self.file.is_none_or(str::is_empty) {
            let given = self.file.map_or("nothing", |_| "\"\"");
            return Err(table.wrong("file", given, MESH_FILE));
        }
        if let Some(scale) = self.scale
            && !(scale.is_finite() && scale > 0.0)
        {
            let allowed = text!(
                "metres for a unit of the file are needed, above 0",
                "需要文件单位对应的米数，大于 0"
            );
            return Err(table.wrong("scale", scale, allowed));
        }
        match self.pieces {
            Some(pieces) if most_pieces(pieces).is_none() => {
                let allowed = text!("allowed are 1 to {}", "允许 1 至 {}", mesh::MAX_PIECES);
                Err(table.wrong("pieces", pieces, allowed))
            }
            _ => Ok(()),
        }
    }

    /// The keys of a mesh; `None` for any other shape.
    pub(super) fn mesh(&self) -> Option<MeshKeys<'a>> {
        (self.shape == ShapeName::Mesh).then_some(MeshKeys {
            file: self.file?,
            scale: self.scale.unwrap_or(1.0),
            pieces: match self.pieces {
                Some(pieces) => most_pieces(pieces)?,
                None => DEFAULT_PIECES,
            },
        })
    }

    /// The solid of a table that was checked. `None` for a mesh that was not read.
    pub(super) fn solid(&self, meshes: &Meshes) -> Option<BodyShape> {
        match (self.shape, self.size.numbers()) {
            (ShapeName::Box, &[x, y, z]) => Some(BodyShape::Box { size: [x, y, z] }),
            (ShapeName::Cylinder, &[radius, length]) => {
                Some(BodyShape::Cylinder { radius, length })
            }
            (ShapeName::Sphere, &[radius]) => Some(BodyShape::Sphere { radius }),
            (ShapeName::Plane, _) => Some(BodyShape::Plane),
            (ShapeName::Mesh, _) => meshes.body(&self.mesh()?).map(BodyShape::Mesh),
            _ => None,
        }
    }
}

/// A number of pieces that is allowed.
fn most_pieces(given: i64) -> Option<usize> {
    let pieces = usize::try_from(given).ok()?;
    (1..=mesh::MAX_PIECES).contains(&pieces).then_some(pieces)
}

/// The convex pieces of a solid at `pose`, as the contacts of the arm know them.
pub(super) fn contact_pieces(shape: &BodyShape, pose: Pose) -> Vec<contact::PlacedShape> {
    let whole = |shape| vec![contact::PlacedShape { pose, shape }];
    match *shape {
        BodyShape::Box { size } => whole(contact::Shape::Box {
            half: size.map(|edge| edge / 2.0),
        }),
        BodyShape::Cylinder { radius, length } => whole(contact::Shape::Cylinder {
            radius,
            half_length: length / 2.0,
        }),
        BodyShape::Sphere { radius } => whole(contact::Shape::Sphere { radius }),
        BodyShape::Plane => whole(contact::Shape::Plane),
        BodyShape::Mesh(ref mesh) => {
            let pieces = mesh.pieces().iter();
            let placed = pieces.map(|piece| contact::PlacedShape {
                pose: pose * Pose::new(Default::default(), piece.middle),
                shape: contact::Shape::Polytope(piece.body.clone()),
            });
            placed.collect()
        }
    }
}

/// The convex pieces of a solid at `pose`, as distances are measured from them.
pub(crate) fn distance_pieces(shape: &BodyShape, pose: Pose) -> Vec<path_planning::PlacedShape> {
    use path_planning::{PlacedShape, Shape};
    let whole = |shape| vec![PlacedShape { pose, shape }];
    match *shape {
        BodyShape::Box { size } => whole(Shape::Box {
            half: size.map(|edge| edge / 2.0),
        }),
        BodyShape::Cylinder { radius, length } => whole(Shape::Cylinder {
            radius,
            half_length: length / 2.0,
        }),
        BodyShape::Sphere { radius } => whole(Shape::Sphere { radius }),
        BodyShape::Plane => whole(Shape::Plane),
        BodyShape::Mesh(ref mesh) => {
            let pieces = mesh.pieces().iter();
            let placed = pieces.map(|piece| PlacedShape {
                pose: pose * Pose::new(Default::default(), piece.middle),
                shape: Shape::Hull(piece.body.points().into()),
            });
            placed.collect()
        }
    }
}

/// A solid as viewers draw it.
pub(crate) fn drawn_shape(shape: &BodyShape) -> ObstacleShape {
    match *shape {
        BodyShape::Box { size } => ObstacleShape::Box(size),
        BodyShape::Cylinder { radius, length } => ObstacleShape::Cylinder { radius, length },
        BodyShape::Sphere { radius } => ObstacleShape::Sphere { radius },
        BodyShape::Plane => ObstacleShape::Plane,
        BodyShape::Mesh(ref mesh) => ObstacleShape::Mesh(mesh.solid().mesh().clone()),
    }
}
