//! The way of the whole queue: parts of paths laid end to end so that position and first two derivatives go on.
//!
//! The route has an s of its own; each span says where on its path it begins and how much of the path's s goes with one of
//! the route's, so that metres of a line and radians of a joint line can follow one another.

use kinematics::JointPositions;

use super::{Ground, Path};
use crate::scalar::ScalarState;
use crate::setpoint::Setpoint;

/// A part of a path in a route.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// The path.
    pub path: Path,
    /// The path's s where the span begins.
    pub from: f64,
    /// The path's s per s of the route.
    pub rate: f64,
    /// The route's s where the span begins.
    pub begin: f64,
}

impl Span {
    /// The path's s at a place of the route.
    pub fn on_path(&self, s: f64) -> f64 {
        self.from + (s - self.begin) * self.rate
    }

    /// The place on the route of a path's s.
    pub fn on_route(&self, s: f64) -> f64 {
        self.begin + (s - self.from) / self.rate
    }
}

/// The spans in order; never empty while it is followed.
#[derive(Clone, Debug)]
pub struct Route {
    spans: Vec<Span>,
}

impl Route {
    /// Nothing yet, with room for so many spans.
    pub fn new(room: usize) -> Self {
        Self {
            spans: Vec::with_capacity(room),
        }
    }

    /// Begins anew with a whole path.
    pub fn restart(&mut self, path: Path) {
        self.spans.clear();
        self.push(Span {
            path,
            from: 0.0,
            rate: 1.0,
            begin: 0.0,
        });
    }

    /// Adds a span while there is room.
    pub fn push(&mut self, span: Span) {
        if self.room() > 0 {
            self.spans.push(span);
        }
    }

    /// Places for further spans.
    pub fn room(&self) -> usize {
        self.spans.capacity() - self.spans.len()
    }

    /// The last span.
    pub fn last(&self) -> Option<&Span> {
        self.spans.last()
    }

    /// Spans that end before `place` are forgotten.
    pub fn forget_before(&mut self, place: f64) {
        let begun = self.spans.partition_point(|span| span.begin <= place);
        self.spans.drain(..begun.saturating_sub(1));
    }

    /// The setpoint at a state of s, in the branch of solutions that `near` belongs to.
    pub fn at(&self, ground: &Ground, s: &ScalarState, near: &JointPositions) -> Option<Setpoint> {
        let k = self.spans.partition_point(|span| span.begin <= s.position);
        let span = self.spans.get(k.saturating_sub(1))?;
        let own = ScalarState {
            position: span.on_path(s.position),
            speed: s.speed * span.rate,
            acceleration: s.acceleration * span.rate,
        };
        span.path.at(ground, &own, near)
    }

    /// Where it ends: exactly the target, at rest.
    pub fn end(&self) -> Option<Setpoint> {
        self.spans.last().map(|span| span.path.end())
    }
}
