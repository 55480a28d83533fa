//! Toolpaths of machines and drawings as programs: lines, arcs and what is switched along them.
//!
//! Readers ([`gcode`], [`dxf`], [`csv`]) make a [`Toolpath`]; [`program`] writes it as EliteScript. Lengths are metres.

mod arc;
pub mod csv;
pub mod dxf;
pub mod gcode;
pub mod program;
pub mod reach;
mod spline;

use core::fmt;
use messages::{Language, Localized, Text, text};

pub use arc::{Arc, Plane};

/// A point, m.
pub type Point = [f64; 3];

/// Steps of a toolpath at most.
pub const STEPS_MAX: usize = 1_000_000;

/// Shorter moves are no moves, m.
pub(crate) const LENGTH_MIN_M: f64 = 1e-7;

/// A toolpath, in the order in which it is driven.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Toolpath {
    /// What is done.
    pub steps: Vec<Step>,
    /// What was not understood or cannot be.
    pub remarks: Vec<Remark>,
}

/// A step of a toolpath.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Line of the file, from 1.
    pub line: u32,
    /// What it is.
    pub kind: StepKind,
}

/// What a step of a toolpath is.
#[derive(Clone, Debug, PartialEq)]
pub enum StepKind {
    /// Somewhere else, without work.
    Rapid(Point),
    /// A straight line.
    Line(Point),
    /// A straight line to a pose: its position, and roll, pitch and yaw of the tool.
    Pose(Point, [f64; 3]),
    /// An arc through a point.
    Arc {
        /// A point between.
        via: Point,
        /// The end.
        to: Point,
    },
    /// The speed of what follows, m/s.
    Speed(f64),
    /// The tool is switched on or off, by this word of the file; none: the file has no such words.
    Switch(bool, &'static str),
    /// A pause, s.
    Dwell(f64),
}

/// A remark about a line of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Remark {
    /// Line of the file, from 1.
    pub line: u32,
    /// Whether the path is wrong, or something was left out.
    pub is_error: bool,
    /// A sentence.
    pub text: Text,
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.fmt_in(Language::English, f)
    }
}

impl Localized for Remark {
    fn fmt_in(&self, language: Language, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { line, text, .. } = self;
        let said = text!("line {line}: {text}", "第 {line} 行：{text}");
        f.write_str(said.in_language(language))
    }
}

/// A reason why a file is no toolpath.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Localized)]
pub enum ToolpathError {
    /// More than anybody drives.
    #[error("line {line}: the path has more than {STEPS_MAX} steps")]
    #[zh("第 {line} 行：路径超过 {STEPS_MAX} 步")]
    TooLong {
        /// The line of the first one too many.
        line: u32,
    },
    /// The file is damaged.
    #[error("line {line}: {text}")]
    #[zh("第 {line} 行：{text}")]
    Damaged {
        /// The place.
        line: u32,
        /// What is wrong.
        text: Text,
    },
    /// There is nothing to drive.
    #[error("{text}")]
    Empty {
        /// What was looked for.
        text: Text,
    },
}

impl Toolpath {
    fn push(&mut self, line: u32, kind: StepKind) -> Result<(), ToolpathError> {
        if self.steps.len() == STEPS_MAX {
            return Err(ToolpathError::TooLong { line });
        }
        self.steps.push(Step { line, kind });
        Ok(())
    }

    /// Says that something was left out.
    fn left_out(&mut self, line: u32, text: Text) {
        self.remark(line, false, text);
    }

    /// Says that something cannot be.
    fn impossible(&mut self, line: u32, text: Text) {
        self.remark(line, true, text);
    }

    fn remark(&mut self, line: u32, is_error: bool, text: Text) {
        // A file of another kind would give one for every line.
        const REMARKS_MAX: usize = 1000;
        if self.remarks.len() < REMARKS_MAX {
            self.remarks.push(Remark {
                line,
                is_error,
                text,
            });
        }
    }
}

pub(crate) fn distance(a: Point, b: Point) -> f64 {
    norm(minus(a, b))
}

pub(crate) fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn plus(a: Point, b: Point, factor: f64) -> Point {
    [
        a[0] + factor * b[0],
        a[1] + factor * b[1],
        a[2] + factor * b[2],
    ]
}

pub(crate) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: Point, b: Point) -> Point {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

pub(crate) fn norm(a: Point) -> f64 {
    dot(a, a).sqrt()
}

/// The direction of a vector; `None` for none.
pub(crate) fn unit(a: Point) -> Option<Point> {
    let length = norm(a);
    (length > 1e-12).then(|| [a[0] / length, a[1] / length, a[2] / length])
}
