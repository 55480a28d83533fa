//! Arcs: where they lie, and how they are cut into arcs that three points describe well, or into lines.

use core::f64::consts::{PI, TAU};

use super::{Point, StepKind, Toolpath, ToolpathError, distance};

/// The plane of an arc: which coordinates turn, counter-clockwise from the first to the second, and which goes along.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plane {
    /// First, second, and the one across.
    pub axes: [usize; 3],
}

impl Plane {
    /// X to Y.
    pub const XY: Self = Self { axes: [0, 1, 2] };
    /// Z to X.
    pub const ZX: Self = Self { axes: [2, 0, 1] };
    /// Y to Z.
    pub const YZ: Self = Self { axes: [1, 2, 0] };
}

/// An arc, or a helix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    /// Plane of the arc.
    pub plane: Plane,
    /// Centre of the arc in its plane, m.
    pub centre: [f64; 2],
    /// Radius, m.
    pub radius: f64,
    /// Where it begins, rad.
    pub begin: f64,
    /// How far it turns, rad; negative: clockwise.
    pub turn: f64,
    /// Coordinate across the plane at the begin and at the end, m.
    pub height: [f64; 2],
}

impl Arc {
    /// A point of it; 0 is the begin, 1 the end.
    pub fn point(&self, part: f64) -> Point {
        let (sin, cos) = kinematics::rotation::sin_cos_exact(self.begin + part * self.turn);
        let [first, second, across] = self.plane.axes;
        let mut point = [0.0; 3];
        point[first] = self.centre[0] + self.radius * cos;
        point[second] = self.centre[1] + self.radius * sin;
        point[across] = self.height[0] + part * (self.height[1] - self.height[0]);
        point
    }

    /// Adds it to a path, its end being exactly `to`. Arcs stay arcs; a helix becomes lines that stay within
    /// `tolerance`.
    pub fn add_to(
        &self,
        path: &mut Toolpath,
        line: u32,
        to: Point,
        tolerance: f64,
    ) -> Result<(), ToolpathError> {
        let is_helix = (self.height[1] - self.height[0]).abs() > 1e-9;
        let sagitta = self.radius * (1.0 - (self.turn.abs().min(PI) / 2.0).cos());
        // What differs from a line by less than anybody measures is one.
        if sagitta < 1e-7 || distance(self.point(0.5), to) < 1e-7 {
            return path.push(line, StepKind::Line(to));
        }
        if is_helix {
            let step = 2.0 * (1.0 - (tolerance / self.radius).min(1.0)).acos();
            let count = (self.turn.abs() / step).ceil().clamp(2.0, 100_000.0) as u32;
            for index in 1..count {
                let part = f64::from(index) / f64::from(count);
                path.push(line, StepKind::Line(self.point(part)))?;
            }
            return path.push(line, StepKind::Line(to));
        }
        // Three points describe up to half a turn well.
        let count = (self.turn.abs() / (PI + 1e-9)).ceil().clamp(1.0, 1000.0) as u32;
        for index in 0..count {
            let part = |at: f64| self.point((f64::from(index) + at) / f64::from(count));
            let end = match index + 1 == count {
                true => to,
                false => part(1.0),
            };
            path.push(
                line,
                StepKind::Arc {
                    via: part(0.5),
                    to: end,
                },
            )?;
        }
        Ok(())
    }
}

/// How far an arc turns from one angle to another one, rad; the same angle is a whole turn.
pub fn turn(begin: f64, end: f64, is_clockwise: bool) -> f64 {
    let mut turn = (end - begin).rem_euclid(TAU);
    if turn < 1e-9 {
        turn = TAU;
    }
    match is_clockwise {
        false => turn,
        true if (TAU - turn) < 1e-9 => -TAU,
        true => turn - TAU,
    }
}
