//! Triangle meshes from files, as solids and as convex pieces.
//!
//! Owns the readers of STL, OBJ and glTF, what makes a surface a solid, and the convex pieces that stand for it in
//! contacts and distances. Knows no cell, no part and no drawing; files reach it through [`MeshFiles`].
//!
//! ```
//! use std::sync::Arc;
//! # struct Text;
//! # impl mesh::MeshFiles for Text {
//! #     fn read(&mut self, _: &str, _: u64) -> Result<Vec<u8>, mesh::FileError> {
//! #         Ok(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n".to_vec())
//! #     }
//! # }
//! # let mut files = Text;
//! // `files` is usually a `mesh::Folder`.
//! let mesh = mesh::read("corner.obj", 1.0, &mut files)?;
//! let solid = mesh::Solid::new(Arc::new(mesh))?;
//! assert!((solid.volume() - 1.0 / 6.0).abs() < 1e-12);
//! let pieces = mesh::convex_pieces(&solid, 16);
//! assert_eq!(pieces.pieces().len(), 1);
//! assert!(pieces.deviation() < 1e-6);
//! # Ok::<(), mesh::MeshError>(())
//! ```

mod body;
mod error;
mod files;
mod mesh;
mod pieces;
mod read;
mod solid;

pub use body::MeshBody;
pub use error::{FileError, FilePosition, MeshError};
pub use files::{Folder, MeshFiles};
pub use mesh::Mesh;
pub use pieces::{ConvexPiece, ConvexPieces, convex_pieces};
pub use read::read;
pub use solid::Solid;

/// The largest file that is read, and the most that a glTF file and its buffers are together: 64 MiB.
pub const MAX_FILE_BYTES: u64 = 64 << 20;

/// The most triangles of one file.
pub const MAX_TRIANGLES: usize = 2_000_000;

/// The most convex pieces of one solid.
pub const MAX_PIECES: usize = 256;

/// How far a corner of a solid may be from the origin in each coordinate, in metres.
pub const MAX_COORDINATE_M: f64 = 100.0;

/// How long a solid must be in each coordinate, in metres.
pub const MIN_EXTENT_M: f64 = 1e-4;
