//! The program that drives a path: plain EliteScript for any CS controller.

use core::fmt::Write;

use kinematics::JointPositions;

/// A path with the radii of its blends.
#[derive(Clone, Debug)]
pub(super) struct ProgramOfPath<'a> {
    /// Start, corners and goal.
    pub(super) corners: &'a [JointPositions],
    /// A blend radius for every corner, m; those of start and goal are 0.
    pub(super) radii: &'a [f64],
    /// The TCP pose to which the last piece is a line, m and rad.
    pub(super) line_to: Option<[f64; 6]>,
    /// Joint speed, rad/s.
    pub(super) speed: f64,
    /// Joint acceleration, rad/s².
    pub(super) acceleration: f64,
    /// TCP that the line needs, in the flange frame, m and rad.
    pub(super) tcp: [f64; 6],
}

/// Speed and acceleration of the line, m/s and m/s²: those of `movel`.
const LINE_SPEED: f64 = 0.25;
const LINE_ACCELERATION: f64 = 1.2;

impl ProgramOfPath<'_> {
    /// The text.
    pub(super) fn text(&self) -> String {
        let mut text = String::new();
        let start = self.corners.first().copied().unwrap_or_default();
        // Writing into a text cannot fail.
        let _ = writeln!(text, "# The arm has to stand at {}.", list(&start.0));
        let _ = writeln!(text, "def planned_path():");
        if self.line_to.is_some() && self.tcp != [0.0; 6] {
            let _ = writeln!(text, "    set_tcp({})", list(&self.tcp));
        }
        let last = self.corners.len() - 1;
        for (number, (corner, radius)) in self.corners.iter().zip(self.radii).enumerate().skip(1) {
            let q = list(&corner.0);
            let line_to = self.line_to.filter(|_| number == last);
            let _ = match (line_to, *radius > 0.0) {
                (Some(pose), _) => writeln!(
                    text,
                    "    movel({}, a={LINE_ACCELERATION}, v={LINE_SPEED})",
                    list(&pose)
                ),
                (None, true) => writeln!(
                    text,
                    "    movej({q}, a={}, v={}, r={radius})",
                    self.acceleration, self.speed
                ),
                (None, false) => writeln!(
                    text,
                    "    movej({q}, a={}, v={})",
                    self.acceleration, self.speed
                ),
            };
        }
        text.push_str("end\n");
        text
    }

    /// The line of the text, from 1, in which the motion to a corner stands.
    pub(super) fn line_of_corner(&self, number: usize) -> u32 {
        let before = 2 + usize::from(self.line_to.is_some() && self.tcp != [0.0; 6]);
        u32::try_from(before + number).unwrap_or(u32::MAX)
    }
}

/// A list as a program has it.
fn list(numbers: &[f64; 6]) -> String {
    let numbers = numbers.map(|number| {
        // Without a sign before a zero.
        (number + 0.0).to_string()
    });
    format!("[{}]", numbers.join(", "))
}
