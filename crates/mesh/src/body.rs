//! A mesh as a cell has it: the solid and its convex pieces.

use std::sync::Arc;

use nalgebra::Vector3;

use crate::pieces::{ConvexPiece, ConvexPieces, convex_pieces, hull_corners};
use crate::solid::Solid;

/// A solid with the convex pieces that stand for it in contacts and distances.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshBody {
    solid: Solid,
    pieces: ConvexPieces,
}

impl MeshBody {
    /// Cuts a solid into at most `most` convex pieces.
    pub fn new(solid: Solid, most: usize) -> Self {
        let pieces = convex_pieces(&solid, most);
        Self { solid, pieces }
    }

    /// The solid.
    pub const fn solid(&self) -> &Solid {
        &self.solid
    }

    /// The convex pieces, in the frame of the mesh.
    pub fn pieces(&self) -> &[ConvexPiece] {
        self.pieces.pieces()
    }

    /// The greatest distance between the mesh and the pieces, m.
    pub fn deviation(&self) -> f64 {
        self.pieces.deviation()
    }

    /// The corners of the convex hull of all pieces, m.
    pub fn hull_corners(&self) -> Arc<[Vector3<f64>]> {
        let pieces = self.pieces().iter();
        let points = pieces.flat_map(|piece| {
            let points = piece.body.points().iter();
            points.map(|point| piece.middle + point)
        });
        hull_corners(points.collect()).into()
    }

    /// The body in a point mirror at the origin of its frame: every point p becomes −p.
    #[must_use]
    pub fn point_mirrored(&self) -> Self {
        Self {
            solid: self.solid.point_mirrored(),
            pieces: self.pieces.point_mirrored(),
        }
    }
}
