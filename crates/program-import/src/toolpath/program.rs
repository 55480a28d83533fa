//! A toolpath as a program in EliteScript.
//!
//! Rows of lines and arcs become one motion without stops: each corner is rounded with the largest radius that keeps
//! the tolerance.

use core::fmt::Write;

use kinematics::{Pose, RpyPose};
use messages::text;
use nalgebra::{Matrix3, Rotation3, Vector3};

use super::{
    LENGTH_MIN_M, Point, Remark, StepKind, Toolpath, cross, distance, dot, minus, norm, plus, unit,
};

/// Speed where the file names none, m/s.
const SPEED_M_S: f64 = 0.05;
/// Speed between the works, m/s.
const RAPID_SPEED_M_S: f64 = 0.25;
/// Share of the tolerance that a corner may take: the rest is for the arm that follows.
const CORNER_SHARE: f64 = 0.6;
/// Share of the shorter neighbour that a corner may take.
const LENGTH_SHARE: f64 = 0.45;
/// Sharper corners are driven to the point, rad.
const SHARP_RAD: f64 = 2.8;
/// Smaller radii are none, m.
const RADIUS_MIN_M: f64 = 1e-6;

/// How a toolpath becomes a program.
#[derive(Clone, Debug)]
pub struct ProgramOptions {
    /// The frame of the file in the base frame.
    pub frame: RpyPose,
    /// Where the tool's z points, in that frame.
    pub tool_axis: Point,
    /// Speed instead of the file's, m/s.
    pub speed: Option<f64>,
    /// Factor of the file's speeds.
    pub speed_factor: f64,
    /// How far the path may be from the file's, m.
    pub tolerance: f64,
    /// The line that switches the tool on.
    pub on: Option<String>,
    /// The line that switches it off.
    pub off: Option<String>,
    /// Length of a straight approach against the tool's axis, m.
    pub lead_in: f64,
    /// Whether every rapid move is left and begun by an approach: drawings have no heights of their own.
    pub lifts: bool,
}

/// Writes the program; `is_free` says whether a rapid move may go through joint space.
pub fn write(
    path: &Toolpath,
    name: &str,
    options: &ProgramOptions,
    is_free: &mut dyn FnMut(Point, Point) -> bool,
) -> (String, Vec<Remark>) {
    let tool = tool_rpy(options.tool_axis);
    let mut writer = Writer {
        options,
        is_free,
        out: String::new(),
        here: None,
        speed: options.speed.unwrap_or(SPEED_M_S * options.speed_factor),
        row: Vec::new(),
        remarks: path.remarks.clone(),
    };
    let mut said = path.remarks.iter().peekable();
    for step in &path.steps {
        while let Some(remark) = said.next_if(|remark| remark.line <= step.line) {
            writer.note(remark);
        }
        writer.step(step.line, &step.kind);
    }
    writer.end_row();
    said.for_each(|remark| writer.note(remark));
    writer.leave();
    let text = head(name, options, tool) + &writer.out;
    let mut remarks = writer.remarks;
    remarks.sort_by_key(|remark| remark.line);
    (text, remarks)
}

fn head(name: &str, options: &ProgramOptions, tool: [f64; 3]) -> String {
    let name: String = name.chars().filter(|c| !c.is_control()).collect();
    let RpyPose { xyz, rpy } = options.frame;
    let frame: Vec<String> = xyz.iter().chain(&rpy).map(|x| exact(*x)).collect();
    let [rx, ry, rz] = tool.map(exact);
    format!(
        "# Made from {name}: lengths in m, speeds in m/s\n\
         frame = [{}]\n\n\
         # A pose in the base frame, from one in the frame of the file.\n\
         def at(x, y, z, rx={rx}, ry={ry}, rz={rz}):\n    \
         return pose_trans(frame, [x, y, z, rx, ry, rz])\nend\n\n",
        frame.join(", ")
    )
}

/// Roll, pitch and yaw of a tool whose z points along an axis; its x lies as near to the frame's x as it can.
pub fn tool_rpy(axis: Point) -> [f64; 3] {
    let z = unit(axis).unwrap_or([0.0, 0.0, -1.0]);
    let x = unit(plus([1.0, 0.0, 0.0], z, -z[0]));
    let x = match (x, z[0].abs() < 0.999) {
        (Some(x), true) => x,
        _ => unit(plus([0.0, 1.0, 0.0], z, -z[1])).unwrap_or([0.0, 1.0, 0.0]),
    };
    let y = cross(z, x);
    let matrix = Matrix3::from_columns(&[x, y, z].map(Vector3::from));
    let rotation = Rotation3::from_matrix_unchecked(matrix);
    kinematics::rotation::rpy_from_rotation(&rotation)
}

/// The pose of the TCP in the base frame at a point of the file.
pub fn base_pose(options: &ProgramOptions, point: Point) -> Pose {
    let tool = RpyPose {
        xyz: point,
        rpy: tool_rpy(options.tool_axis),
    };
    Pose::from_rpy(&options.frame) * Pose::from_rpy(&tool)
}

/// The pose of the TCP in the base frame at the end of a step; none where nothing moves.
pub fn end_pose(options: &ProgramOptions, kind: &StepKind) -> Option<Pose> {
    match kind {
        StepKind::Rapid(to) | StepKind::Line(to) | StepKind::Arc { to, .. } => {
            Some(base_pose(options, *to))
        }
        StepKind::Pose(to, rpy) => {
            let pose = RpyPose {
                xyz: *to,
                rpy: *rpy,
            };
            Some(Pose::from_rpy(&options.frame) * Pose::from_rpy(&pose))
        }
        StepKind::Speed(_) | StepKind::Switch(..) | StepKind::Dwell(_) => None,
    }
}

/// A move of a row.
struct Move {
    line: u32,
    from: Point,
    to: Point,
    /// Of an arc.
    via: Option<Point>,
    /// Roll, pitch, yaw, where they are given.
    rpy: Option<[f64; 3]>,
    speed: f64,
}

struct Writer<'o> {
    options: &'o ProgramOptions,
    is_free: &'o mut dyn FnMut(Point, Point) -> bool,
    out: String,
    here: Option<(Point, Option<[f64; 3]>)>,
    speed: f64,
    row: Vec<Move>,
    remarks: Vec<Remark>,
}

impl Writer<'_> {
    fn note(&mut self, remark: &Remark) {
        self.end_row();
        let text: String = remark
            .text
            .english()
            .chars()
            .filter(|c| !c.is_control())
            .collect();
        let _ = writeln!(self.out, "# line {}: {text}", remark.line);
    }

    fn step(&mut self, line: u32, kind: &StepKind) {
        match kind {
            StepKind::Rapid(to) => self.rapid(*to, None),
            StepKind::Line(to) => self.work(line, *to, None, None),
            StepKind::Pose(to, rpy) => self.work(line, *to, None, Some(*rpy)),
            StepKind::Arc { via, to } => self.work(line, *to, Some(*via), None),
            StepKind::Speed(speed) => {
                if self.options.speed.is_none() {
                    self.speed = speed * self.options.speed_factor;
                }
            }
            StepKind::Switch(is_on, word) => self.switch(line, *is_on, word),
            StepKind::Dwell(seconds) => {
                self.end_row();
                let _ = writeln!(self.out, "sleep({})", short(*seconds));
            }
        }
    }

    fn switch(&mut self, line: u32, is_on: bool, word: &str) {
        self.end_row();
        let (text, option) = match is_on {
            true => (&self.options.on, "--on"),
            false => (&self.options.off, "--off"),
        };
        match text {
            Some(text) => {
                let _ = writeln!(self.out, "{}", text.trim());
            }
            None if !word.is_empty() => {
                let text = text!(
                    "{word} does nothing without {option}",
                    "没有 {option} 时 {word} 不起作用"
                );
                let _ = writeln!(self.out, "# line {line}: {text}");
                self.remarks.push(Remark {
                    line,
                    is_error: false,
                    text,
                });
            }
            None => {}
        }
    }

    /// The way to where work begins.
    fn rapid(&mut self, to: Point, rpy: Option<[f64; 3]>) {
        self.end_row();
        let above = |point: Point| {
            plus(
                point,
                unit(self.options.tool_axis).unwrap_or([0.0, 0.0, -1.0]),
                -self.options.lead_in,
            )
        };
        let has_lead_in = self.options.lead_in > 0.0;
        let target = at(to, rpy);
        match self.here {
            None => {
                let begin = if has_lead_in { above(to) } else { to };
                let _ = writeln!(self.out, "movej(get_inverse_kin({}))", at(begin, rpy));
                if has_lead_in {
                    self.line(&target, self.speed);
                }
            }
            Some((here, _)) if has_lead_in && self.options.lifts => {
                let (up, over) = (above(here), above(to));
                self.line(&at(up, None), RAPID_SPEED_M_S);
                self.cross_over(up, over, rpy);
                self.line(&target, self.speed);
            }
            Some((here, _)) if distance(here, to) > LENGTH_MIN_M => self.cross_over(here, to, rpy),
            Some(_) => {}
        }
        self.here = Some((to, rpy));
    }

    fn line(&mut self, target: &str, speed: f64) {
        let _ = writeln!(self.out, "movel({target}, v={})", short(speed));
    }

    fn cross_over(&mut self, from: Point, to: Point, rpy: Option<[f64; 3]>) {
        let target = at(to, rpy);
        match (self.is_free)(from, to) {
            true => {
                let _ = writeln!(self.out, "movej(get_inverse_kin({target}))");
            }
            false => self.line(&target, RAPID_SPEED_M_S),
        }
    }

    fn work(&mut self, line: u32, to: Point, via: Option<Point>, rpy: Option<[f64; 3]>) {
        let Some((from, from_rpy)) = self.here else {
            // The first point is where the work begins.
            self.rapid(to, rpy);
            return;
        };
        if distance(from, to) < LENGTH_MIN_M && via.is_none() && from_rpy == rpy {
            return;
        }
        self.row.push(Move {
            line,
            from,
            to,
            via,
            rpy,
            speed: self.speed,
        });
        self.here = Some((to, rpy));
    }

    /// Writes the row: every move but the last one has a radius.
    fn end_row(&mut self) {
        let row = std::mem::take(&mut self.row);
        let is_alone = row.len() == 1;
        for (index, step) in row.iter().enumerate() {
            let radius = row
                .get(index + 1)
                .map_or(0.0, |next| radius(step, next, self.options.tolerance));
            let target = at(step.to, step.rpy);
            let call = match step.via {
                Some(via) => format!("movec({}, {target}", at(via, step.rpy)),
                None if is_alone => format!("movel({target}"),
                None => format!("movep({target}"),
            };
            // The tool turns evenly to the orientation of the target, which is the one it has.
            let mode = if step.via.is_some() { ", mode=1" } else { "" };
            let radius = match radius > RADIUS_MIN_M {
                true => format!(", r={}", short(radius)),
                false => String::new(),
            };
            let _ = writeln!(self.out, "{call}, v={}{radius}{mode})", short(step.speed));
            debug_assert!(step.line > 0, "lines count from 1");
        }
    }

    /// The way back from the work.
    fn leave(&mut self) {
        if let (Some((here, rpy)), true) = (self.here, self.options.lead_in > 0.0) {
            let axis = unit(self.options.tool_axis).unwrap_or([0.0, 0.0, -1.0]);
            let up = at(plus(here, axis, -self.options.lead_in), rpy);
            self.line(&up, RAPID_SPEED_M_S);
        }
    }
}

/// The largest radius of a corner that keeps the tolerance.
fn radius(step: &Move, next: &Move, tolerance: f64) -> f64 {
    let (Some((_, end, length, curve)), Some((begin, _, next_length, next_curve))) =
        (step.shape(), next.shape())
    else {
        return 0.0;
    };
    let angle = norm(cross(end, begin)).atan2(dot(end, begin));
    if angle > SHARP_RAD {
        return 0.0;
    }
    let share = CORNER_SHARE * tolerance;
    let room = LENGTH_SHARE * length.min(next_length);
    // The arc that touches both lines at r passes the corner at r · tan(angle / 4).
    let corner = match angle > 1e-9 {
        true => share / (angle / 4.0).tan(),
        false => f64::INFINITY,
    };
    // A curve that leaves its own radius for another one within r is off by a part of r² times the change of curvature.
    let bend = (curve - next_curve).abs();
    let change = match bend > 1e-9 {
        true => (2.0 * share / bend).sqrt(),
        false => f64::INFINITY,
    };
    room.min(corner).min(change)
}

impl Move {
    /// Directions at both ends, length, and curvature.
    fn shape(&self) -> Option<(Point, Point, f64, f64)> {
        let Some(via) = self.via else {
            let direction = unit(minus(self.to, self.from))?;
            return Some((direction, direction, distance(self.from, self.to), 0.0));
        };
        // The circle through three points.
        let (a, b) = (minus(via, self.from), minus(self.to, self.from));
        let across = cross(a, b);
        let square = dot(across, across);
        if square < 1e-24 {
            return None;
        }
        let to_centre = plus(
            [0.0; 3],
            cross(
                minus(plus([0.0; 3], b, dot(a, a)), plus([0.0; 3], a, dot(b, b))),
                across,
            ),
            0.5 / square,
        );
        let radius = norm(to_centre);
        let normal = unit(across)?;
        let begin = unit(cross(normal, minus([0.0; 3], to_centre)))?;
        let end_arm = minus(b, to_centre);
        let end = unit(cross(normal, end_arm))?;
        let chord = norm(b);
        // Readers cut arcs at half a turn.
        let turned = 2.0 * (chord / (2.0 * radius)).min(1.0).asin();
        Some((begin, end, radius * turned, 1.0 / radius))
    }
}

/// A pose of the program.
fn at([x, y, z]: Point, rpy: Option<[f64; 3]>) -> String {
    let [x, y, z] = [x, y, z].map(short);
    match rpy {
        None => format!("at({x}, {y}, {z})"),
        Some(rpy) => {
            let [rx, ry, rz] = rpy.map(exact);
            format!("at({x}, {y}, {z}, {rx}, {ry}, {rz})")
        }
    }
}

/// A number with as many digits as matter: 0.01 µm.
fn short(value: f64) -> String {
    let text = format!("{value:.8}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    match text {
        "-0" | "" => "0".to_owned(),
        _ => text.to_owned(),
    }
}

/// A number with all its digits.
fn exact(value: f64) -> String {
    match value.abs() < 1e-12 {
        true => "0".to_owned(),
        false => format!("{value:?}"),
    }
}
