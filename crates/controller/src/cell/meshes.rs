//! The meshes that a cell file names: read once, made solid and cut, and kept with their files for the recording.

use std::collections::BTreeMap;
use std::sync::Arc;

use mesh::{FileError, MeshBody, MeshError, MeshFiles, Solid};
use messages::{Localized, Text, text};
use recorder::files::MAX_FILES_BYTES;
use thiserror::Error;

use super::check::TableCheck;
use super::schema::Tables;
use super::shape::{MeshKeys, ShapeKeys};

/// Most triangles of all meshes of a cell.
const MAX_TRIANGLES_TOGETHER: usize = 20_000_000;

/// The meshes of a cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Meshes {
    bodies: BTreeMap<MeshKey, Arc<MeshBody>>,
    files: BTreeMap<String, Arc<[u8]>>,
}

/// What decides about a mesh: the file, the bits of the scale, the most pieces.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct MeshKey {
    file: String,
    scale: u64,
    pieces: usize,
}

impl From<&MeshKeys<'_>> for MeshKey {
    fn from(keys: &MeshKeys<'_>) -> Self {
        Self {
            file: keys.file.to_owned(),
            scale: keys.scale.to_bits(),
            pieces: keys.pieces,
        }
    }
}

/// What people are told of a mesh of a cell.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshFacts {
    /// The table, for instance `obstacle "bench"`.
    pub table: Text,
    /// The file as the table names it.
    pub file: String,
    /// Triangles of the solid.
    pub triangles: usize,
    /// Volume, m³.
    pub volume: f64,
    /// Convex pieces that touch and have distances in its place.
    pub pieces: usize,
    /// The greatest distance between the mesh and the pieces, m.
    pub deviation: f64,
}

impl MeshFacts {
    pub(super) fn new(table: &TableCheck, file: &str, body: &MeshBody) -> Self {
        Self {
            table: table.words(),
            file: file.to_owned(),
            triangles: body.solid().mesh().triangles().len(),
            volume: body.solid().volume(),
            pieces: body.pieces().len(),
            deviation: body.deviation(),
        }
    }
}

impl MeshFacts {
    /// The sentence.
    pub fn text(&self) -> Text {
        let Self {
            table,
            file,
            triangles,
            ..
        } = self;
        let (volume, deviation) = (self.volume * 1e6, self.deviation * 1e3);
        text!(
            "{table}: {file} has {triangles} triangles and {volume:.4} cm³, its convex pieces ({}) keep within \
             {deviation:.3} mm",
            "{table}：{file} 有 {triangles} 个三角形、{volume:.4} cm³，其凸块（{} 个）偏差在 {deviation:.3} mm 以内",
            self.pieces
        )
    }
}

/// A mesh that a cell cannot have.
#[derive(Clone, Debug, PartialEq, Error, Localized)]
#[non_exhaustive]
pub enum CellMeshError {
    /// The file is no solid.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// All meshes together are too large.
    #[error(
        "with {file} the meshes of the cell have {triangles} triangles together, allowed are {MAX_TRIANGLES_TOGETHER}"
    )]
    #[zh("加上 {file}，单元的网格共有 {triangles} 个三角形，允许 {MAX_TRIANGLES_TOGETHER} 个")]
    TooManyTriangles {
        /// The file that is one too many.
        file: String,
        /// Triangles with it.
        triangles: usize,
    },
}

impl Meshes {
    /// Reads every mesh of the tables, which were checked.
    ///
    /// # Errors
    /// The table whose mesh cannot be, in words, and why.
    pub(super) fn read(
        tables: &Tables,
        files: &mut dyn MeshFiles,
    ) -> Result<Self, (Text, Box<CellMeshError>)> {
        let mut meshes = Self::default();
        let mut source = NotedFiles {
            files,
            noted: BTreeMap::new(),
        };
        let mut triangles = 0;
        for (table, keys) in shapes(tables) {
            // Keys that do not go together are told when their table is looked at.
            let is_sound = keys.check(&table, true).is_ok();
            let Some(keys) = keys.mesh().filter(|_| is_sound) else {
                continue;
            };
            let key = MeshKey::from(&keys);
            if meshes.bodies.contains_key(&key) {
                continue;
            }
            let refused = |error: CellMeshError| (table.words(), Box::new(error));
            let read = mesh::read(keys.file, keys.scale, &mut source);
            let solid = read.and_then(|mesh| Solid::new(Arc::new(mesh)));
            let solid = solid.map_err(|error| refused(error.into()))?;
            triangles += solid.mesh().triangles().len();
            if triangles > MAX_TRIANGLES_TOGETHER {
                return Err(refused(CellMeshError::TooManyTriangles {
                    file: keys.file.to_owned(),
                    triangles,
                }));
            }
            let body = MeshBody::new(solid, keys.pieces);
            meshes.bodies.insert(key, Arc::new(body));
        }
        meshes.files = source.noted;
        Ok(meshes)
    }

    /// The body of a mesh that was read.
    pub(super) fn body(&self, keys: &MeshKeys<'_>) -> Option<Arc<MeshBody>> {
        self.bodies.get(&MeshKey::from(keys)).cloned()
    }

    /// Every body, in a fixed order.
    pub(super) fn bodies(&self) -> impl Iterator<Item = &Arc<MeshBody>> {
        self.bodies.values()
    }

    /// Every file that was read, by the path as it is named.
    pub(super) const fn files(&self) -> &BTreeMap<String, Arc<[u8]>> {
        &self.files
    }
}

/// Every table with a shape, and what it is called.
pub(super) fn shapes(tables: &Tables) -> impl Iterator<Item = (TableCheck, ShapeKeys<'_>)> {
    let obstacles = tables.obstacle.iter();
    let obstacles = obstacles.map(|table| ("obstacle", &table.name, table.shape_keys()));
    let parts = tables.part.iter();
    let parts = parts.map(|table| ("part", &table.name, table.shape_keys()));
    let fingers = tables.gripper.iter().filter_map(|table| {
        let finger = table.finger.as_ref()?;
        Some(("gripper", &table.name, finger.shape_keys()))
    });
    let named = obstacles.chain(parts).chain(fingers);
    let named = named.map(|(kind, name, keys)| (TableCheck::named(kind, name), keys));
    let tool = tables.tool.iter();
    named.chain(tool.map(|table| (TableCheck::tool(), table.shape_keys())))
}

/// Files that are noted when they are read.
struct NotedFiles<'a> {
    files: &'a mut dyn MeshFiles,
    noted: BTreeMap<String, Arc<[u8]>>,
}

impl MeshFiles for NotedFiles<'_> {
    fn read(&mut self, path: &str, most: u64) -> Result<Vec<u8>, FileError> {
        if let Some(bytes) = self.noted.get(path) {
            return within(bytes, most);
        }
        let taken: u64 = self.noted.values().map(|bytes| bytes.len() as u64).sum();
        let room = (MAX_FILES_BYTES as u64).saturating_sub(taken);
        let bytes = self.files.read(path, most.min(room))?;
        self.noted.insert(path.to_owned(), bytes.as_slice().into());
        Ok(bytes)
    }
}

/// The files that a recording holds.
pub(super) struct RecordedFiles<'a>(pub(super) &'a BTreeMap<String, Arc<[u8]>>);

impl MeshFiles for RecordedFiles<'_> {
    fn read(&mut self, path: &str, most: u64) -> Result<Vec<u8>, FileError> {
        match self.0.get(path) {
            Some(bytes) => within(bytes, most),
            None => Err(FileError::System(text!(
                "the recording does not hold it",
                "记录中没有它"
            ))),
        }
    }
}

/// No files at all: where a cell is a text of its own.
pub(super) struct NoFiles;

impl MeshFiles for NoFiles {
    fn read(&mut self, _path: &str, _most: u64) -> Result<Vec<u8>, FileError> {
        Err(FileError::System(text!(
            "this cell is a text without a folder, so there is no file beside it",
            "此单元只是一段文本，没有文件夹，所以旁边没有文件"
        )))
    }
}

fn within(bytes: &Arc<[u8]>, most: u64) -> Result<Vec<u8>, FileError> {
    match bytes.len() as u64 > most {
        true => Err(FileError::TooLong { most }),
        false => Ok(bytes.to_vec()),
    }
}
