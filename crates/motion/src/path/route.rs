//! The way of the whole queue: parts of paths laid end to end so that position and first two derivatives go on.
//!
//! The route has an s of its own; each span says where on its path it begins and how much of the path's s goes with one
//! of the route's, so that metres of a line and radians of a joint line can follow one another.

use kinematics::JointPositions;

use super::{Path, PathContext};
use crate::scalar::ScalarState;
use crate::setpoint::Setpoint;

/// A part of a path in a route.
#[derive(Clone, Copy, Debug)]
pub struct PathPiece {
    /// The path.
    pub path: Path,
    /// The path's s where the span begins.
    pub path_start: f64,
    /// The path's s per s of the route.
    pub rate: f64,
    /// The route's s where the span begins.
    pub start: f64,
}

impl PathPiece {
    /// The path's s at a place of the route.
    pub fn to_piece_parameter(&self, s: f64) -> f64 {
        self.path_start + (s - self.start) * self.rate
    }

    /// The place on the route of a path's s.
    pub fn to_composite_parameter(&self, s: f64) -> f64 {
        self.start + (s - self.path_start) / self.rate
    }
}

/// The spans in order; never empty while it is followed.
#[derive(Clone, Debug)]
pub struct CompositePath {
    spans: Vec<PathPiece>,
}

impl CompositePath {
    /// Nothing yet, with room for so many spans.
    pub fn new(room: usize) -> Self {
        Self {
            spans: Vec::with_capacity(room),
        }
    }

    /// Begins anew with a whole path.
    pub fn restart(&mut self, path: Path) {
        self.spans.clear();
        self.push(PathPiece {
            path,
            path_start: 0.0,
            rate: 1.0,
            start: 0.0,
        });
    }

    /// Adds a span while there is room.
    pub fn push(&mut self, span: PathPiece) {
        if self.remaining_capacity() > 0 {
            self.spans.push(span);
        }
    }

    /// Places for further spans.
    pub fn remaining_capacity(&self) -> usize {
        self.spans.capacity() - self.spans.len()
    }

    /// The last span.
    pub fn last(&self) -> Option<&PathPiece> {
        self.spans.last()
    }

    /// Spans that end before `place` are forgotten.
    pub fn discard_before(&mut self, place: f64) {
        let begun = self.spans.partition_point(|span| span.start <= place);
        self.spans.drain(..begun.saturating_sub(1));
    }

    /// The setpoint at a state of s, in the branch of solutions that `near` belongs to.
    pub fn at(
        &self,
        ground: &PathContext,
        s: &ScalarState,
        near: &JointPositions,
    ) -> Option<Setpoint> {
        let k = self.spans.partition_point(|span| span.start <= s.position);
        let span = self.spans.get(k.saturating_sub(1))?;
        let own = ScalarState {
            position: span.to_piece_parameter(s.position),
            speed: s.speed * span.rate,
            acceleration: s.acceleration * span.rate,
        };
        span.path.at(ground, &own, near)
    }

    /// The end of the route: exactly the target, at rest.
    pub fn end(&self) -> Option<Setpoint> {
        self.spans.last().map(|span| span.path.end_setpoint())
    }
}
