//! What one motion follows: up to three paths joined so that position and first two derivatives go on.
//!
//! The chain has an s of its own; each piece says where on its path it begins and how much of the path's s goes with one of
//! the chain's, so that metres of a line and radians of a joint line can follow one another.

use kinematics::JointPositions;

use super::{Ground, Path};
use crate::scalar::ScalarState;
use crate::setpoint::Setpoint;

/// Most pieces: the rest of a leg, a blend and the next leg.
const MAX_PIECES: usize = 3;

/// A part of a path in a chain.
#[derive(Clone, Copy, Debug)]
pub struct Piece {
    /// The path.
    pub path: Path,
    /// The path's s where the piece begins.
    pub from: f64,
    /// The path's s per s of the chain.
    pub rate: f64,
    /// The chain's s where the piece begins.
    pub begin: f64,
}

/// The pieces in order.
#[derive(Clone, Copy, Debug)]
pub struct Chain {
    pieces: [Piece; MAX_PIECES],
    count: usize,
}

impl Chain {
    /// A whole path alone: the chain's s is the path's.
    pub fn of_one(path: Path) -> Self {
        let piece = Piece {
            path,
            from: 0.0,
            rate: 1.0,
            begin: 0.0,
        };
        Self {
            pieces: [piece; MAX_PIECES],
            count: 1,
        }
    }

    /// Three pieces; each begins where the one before ends.
    pub const fn of_three(pieces: [Piece; MAX_PIECES]) -> Self {
        Self { pieces, count: 3 }
    }

    /// The last piece: the leg that the chain leads to.
    pub fn last(&self) -> &Piece {
        &self.pieces[(self.count - 1).min(MAX_PIECES - 1)]
    }

    /// True when a place lies in the last piece.
    pub fn is_in_last(&self, s: f64) -> bool {
        s >= self.last().begin
    }

    /// The setpoint at a state of s, in the branch of solutions that `near` belongs to.
    pub fn at(&self, ground: &Ground, s: &ScalarState, near: &JointPositions) -> Option<Setpoint> {
        let pieces = self.pieces.iter().take(self.count);
        let piece = pieces
            .rev()
            .find(|piece| s.position >= piece.begin)
            .unwrap_or(&self.pieces[0]);
        let own = ScalarState {
            position: piece.from + (s.position - piece.begin) * piece.rate,
            speed: s.speed * piece.rate,
            acceleration: s.acceleration * piece.rate,
        };
        piece.path.at(ground, &own, near)
    }

    /// Where it ends: exactly the target, at rest.
    pub fn end(&self) -> Setpoint {
        self.last().path.end()
    }
}
