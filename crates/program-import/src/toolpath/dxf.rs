//! DXF drawings: lines, polylines with bulges, arcs, circles, ellipses and splines of chosen layers.
//!
//! A reader of our own: the file is pairs of a number and a value, remarks need its lines, and the crates that read all
//! of DXF bring libraries for pictures and identifiers with them.

use core::f64::consts::{PI, TAU};

use messages::{Text, text};

use super::arc::{Arc, Plane, turn};
use super::spline::Spline;
use super::{Point, STEPS_MAX, StepKind, Toolpath, ToolpathError, distance};

/// Ends that are this near are joined, m.
const JOIN_M: f64 = 1e-5;

/// A pair of a group code and its value.
struct Pair<'t> {
    line: u32,
    code: i32,
    value: &'t str,
}

impl Pair<'_> {
    fn number(&self) -> Result<f64, ToolpathError> {
        match self.value.parse::<f64>() {
            Ok(number) if number.abs() < 1e12 => Ok(number),
            _ => Err(damaged(
                self.line,
                text!("'{}' is no number", "'{}' 不是数", short(self.value)),
            )),
        }
    }
}

fn damaged(line: u32, text: Text) -> ToolpathError {
    ToolpathError::Damaged { line, text }
}

fn short(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).take(30).collect()
}

/// What is drawn in one go: it begins somewhere and goes on without a break.
struct Contour {
    line: u32,
    begin: Point,
    /// Lines and arcs of the contour, one after the other.
    steps: Vec<StepKind>,
}

/// Reads a drawing. `layers` chooses layers, none: all. Curves that are no arcs become lines within `tolerance`, m.
///
/// # Errors
///
/// The file is damaged, or nothing of it is drawn.
pub fn read(text: &str, layers: &[String], tolerance: f64) -> Result<Toolpath, ToolpathError> {
    if text.starts_with("AutoCAD Binary DXF") {
        return Err(damaged(
            1,
            text!(
                "this is a binary DXF file: save it as text",
                "这是二进制 DXF 文件：请保存为文本格式"
            ),
        ));
    }
    let pairs = pairs(text)?;
    let mut path = Toolpath::default();
    let unit_m = unit(&pairs, &mut path)?;
    let mut drawing = Drawing {
        unit_m,
        tolerance,
        layers,
        contours: Vec::new(),
        steps: 0,
        path,
    };
    let begin = pairs.windows(2).position(|two| {
        (two[0].code, two[0].value) == (0, "SECTION")
            && (two[1].code, two[1].value) == (2, "ENTITIES")
    });
    let entities = begin.map_or(&pairs[..0], |begin| &pairs[begin + 2..]);
    let mut rest = entities;
    while let Some(first) = rest.first() {
        if first.value == "ENDSEC" {
            break;
        }
        let end = 1 + rest[1..].iter().take_while(|pair| pair.code != 0).count();
        let (entity, tail) = rest.split_at(end);
        rest = tail;
        if first.value == "POLYLINE" {
            let vertices = rest
                .iter()
                .position(|pair| (pair.code, pair.value) == (0, "SEQEND"));
            let Some(vertices) = vertices else {
                return Err(damaged(
                    first.line,
                    text!("a POLYLINE has no SEQEND", "POLYLINE 没有 SEQEND"),
                ));
            };
            let (vertices, tail) = rest.split_at(vertices);
            rest = tail;
            drawing.polyline(entity, vertices)?;
        } else {
            drawing.entity(entity)?;
        }
    }
    drawing.finish()
}

fn pairs(text: &str) -> Result<Vec<Pair<'_>>, ToolpathError> {
    let mut pairs = Vec::new();
    let mut lines = (1_u32..).zip(text.lines());
    while let Some((line, code)) = lines.next() {
        let Some((_, value)) = lines.next() else {
            // A last line without a partner is an end of file that was cut a little late.
            break;
        };
        let code = code.trim();
        let Ok(code) = code.parse::<i32>() else {
            return Err(damaged(
                line,
                text!(
                    "'{}' is no group code of a DXF file",
                    "'{}' 不是 DXF 文件的组码",
                    short(code)
                ),
            ));
        };
        let value = value.trim();
        pairs.push(Pair { line, code, value });
    }
    Ok(pairs)
}

/// The unit of `$INSUNITS` in metres.
fn unit(pairs: &[Pair<'_>], path: &mut Toolpath) -> Result<f64, ToolpathError> {
    let header = pairs
        .windows(2)
        .find(|two| two[0].code == 9 && two[0].value == "$INSUNITS");
    let Some([_, value]) = header else {
        return Ok(0.001);
    };
    Ok(match value.value {
        "1" => 0.0254,
        "2" => 0.3048,
        "4" => 0.001,
        "5" => 0.01,
        "6" => 1.0,
        "8" => 0.0254e-6,
        "9" => 0.0254e-3,
        "10" => 0.9144,
        "11" => 1e-10,
        "12" => 1e-9,
        "13" => 1e-6,
        "14" => 0.1,
        "0" => {
            path.left_out(
                value.line,
                text!(
                    "the drawing names no unit: millimetres are assumed",
                    "图纸没有给出单位：按毫米处理"
                ),
            );
            0.001
        }
        other => {
            let text = text!(
                "$INSUNITS {} is no unit that is driven",
                "$INSUNITS {} 不是可用的单位",
                short(other)
            );
            return Err(damaged(value.line, text));
        }
    })
}

struct Drawing<'o> {
    unit_m: f64,
    tolerance: f64,
    layers: &'o [String],
    contours: Vec<Contour>,
    steps: usize,
    path: Toolpath,
}

fn find<'p, 't>(entity: &'p [Pair<'t>], code: i32) -> Option<&'p Pair<'t>> {
    entity.iter().find(|pair| pair.code == code)
}

fn number(entity: &[Pair<'_>], code: i32, default: f64) -> Result<f64, ToolpathError> {
    find(entity, code).map_or(Ok(default), Pair::number)
}

impl Drawing<'_> {
    fn is_chosen(&self, entity: &[Pair<'_>]) -> bool {
        let layer = find(entity, 8).map_or("0", |pair| pair.value);
        self.layers.is_empty()
            || self
                .layers
                .iter()
                .any(|chosen| chosen.eq_ignore_ascii_case(layer))
    }

    fn point(&self, entity: &[Pair<'_>], x: i32) -> Result<Point, ToolpathError> {
        let mut point = [0.0; 3];
        for (coordinate, code) in point.iter_mut().zip([x, x + 10, x + 20]) {
            *coordinate = number(entity, code, 0.0)? * self.unit_m;
        }
        Ok(point)
    }

    /// Whether the entity is drawn from below: its x runs the other way. Other directions of extrusion are not
    /// understood.
    fn mirror(&self, entity: &[Pair<'_>]) -> Result<Option<bool>, ToolpathError> {
        let across = [
            number(entity, 210, 0.0)?,
            number(entity, 220, 0.0)?,
            number(entity, 230, 1.0)?,
        ];
        let is_flat = across[0].abs() < 1e-6 && across[1].abs() < 1e-6;
        Ok(is_flat.then_some(across[2] < 0.0))
    }

    fn entity(&mut self, entity: &[Pair<'_>]) -> Result<(), ToolpathError> {
        let (line, name) = (entity[0].line, entity[0].value);
        if matches!(name, "SECTION" | "SEQEND" | "EOF" | "VERTEX" | "VIEWPORT")
            || !self.is_chosen(entity)
        {
            return Ok(());
        }
        let is_mirrored = match (name, self.mirror(entity)?) {
            (_, Some(is_mirrored)) => is_mirrored,
            ("LINE" | "SPLINE" | "ELLIPSE", None) => false,
            (_, None) => {
                self.path.left_out(
                    line,
                    text!(
                        "{} lies in a tilted plane: left out",
                        "{} 位于倾斜平面内：已略去",
                        short(name)
                    ),
                );
                return Ok(());
            }
        };
        match name {
            "LINE" => {
                let (begin, end) = (self.point(entity, 10)?, self.point(entity, 11)?);
                self.contour(line, begin, vec![StepKind::Line(end)])
            }
            "ARC" | "CIRCLE" => self.arc(entity, is_mirrored),
            "LWPOLYLINE" => self.light_polyline(entity, is_mirrored),
            "SPLINE" => self.spline(entity),
            "ELLIPSE" => self.ellipse(entity),
            _ => {
                self.path.left_out(
                    line,
                    text!(
                        "{} is not understood: left out",
                        "不理解 {}：已略去",
                        short(name)
                    ),
                );
                Ok(())
            }
        }
    }

    fn contour(
        &mut self,
        line: u32,
        begin: Point,
        steps: Vec<StepKind>,
    ) -> Result<(), ToolpathError> {
        self.steps += steps.len() + 1;
        if self.steps > STEPS_MAX {
            return Err(ToolpathError::TooLong { line });
        }
        let points = steps.iter().filter_map(end_of).chain([begin]);
        if !points.flatten().all(|x| x.abs() < 100.0) {
            self.path.impossible(
                line,
                text!(
                    "it lies more than 100 m away: are the units right?",
                    "它在 100 m 之外：单位是否正确？"
                ),
            );
            return Ok(());
        }
        if !steps.is_empty() {
            self.contours.push(Contour { line, begin, steps });
        }
        Ok(())
    }

    fn arc(&mut self, entity: &[Pair<'_>], is_mirrored: bool) -> Result<(), ToolpathError> {
        let line = entity[0].line;
        let mut centre = self.point(entity, 10)?;
        let radius = number(entity, 40, 0.0)? * self.unit_m;
        if radius <= 0.0 {
            self.path.impossible(
                line,
                text!(
                    "a radius of {radius} m: allowed is more than 0",
                    "半径为 {radius} m：必须大于 0"
                ),
            );
            return Ok(());
        }
        let (mut begin, mut turned) = match entity[0].value {
            "CIRCLE" => (0.0, TAU),
            _ => {
                let begin = number(entity, 50, 0.0)?.to_radians();
                (
                    begin,
                    turn(begin, number(entity, 51, 360.0)?.to_radians(), false),
                )
            }
        };
        if is_mirrored {
            centre[0] = -centre[0];
            centre[2] = -centre[2];
            begin = PI - begin;
            turned = -turned;
        }
        let arc = Arc {
            plane: Plane::XY,
            centre: [centre[0], centre[1]],
            radius,
            begin,
            turn: turned,
            height: [centre[2]; 2],
        };
        let steps = self.arc_steps(&arc, line, arc.point(1.0))?;
        self.contour(line, arc.point(0.0), steps)
    }

    fn arc_steps(&self, arc: &Arc, line: u32, to: Point) -> Result<Vec<StepKind>, ToolpathError> {
        let mut path = Toolpath::default();
        arc.add_to(&mut path, line, to, self.tolerance)?;
        Ok(path.steps.into_iter().map(|step| step.kind).collect())
    }

    fn light_polyline(
        &mut self,
        entity: &[Pair<'_>],
        is_mirrored: bool,
    ) -> Result<(), ToolpathError> {
        let height = number(entity, 38, 0.0)? * self.unit_m;
        let mut vertices: Vec<(Point, f64)> = Vec::new();
        for pair in entity {
            match pair.code {
                10 => vertices.push(([pair.number()? * self.unit_m, 0.0, height], 0.0)),
                20 => {
                    let y = pair.number()? * self.unit_m;
                    if let Some((point, _)) = vertices.last_mut() {
                        point[1] = y;
                    }
                }
                42 => {
                    let bulge = pair.number()?;
                    if let Some((_, last)) = vertices.last_mut() {
                        *last = bulge;
                    }
                }
                _ => {}
            }
        }
        let is_closed = flags(entity)? & 1 != 0;
        self.vertices(entity[0].line, vertices, is_closed, is_mirrored)
    }

    fn polyline(&mut self, entity: &[Pair<'_>], rest: &[Pair<'_>]) -> Result<(), ToolpathError> {
        let line = entity[0].line;
        if !self.is_chosen(entity) {
            return Ok(());
        }
        let flags_of = flags(entity)?;
        let Some(is_mirrored) = self.mirror(entity)? else {
            self.path.left_out(
                line,
                text!(
                    "POLYLINE lies in a tilted plane: left out",
                    "POLYLINE 位于倾斜平面内：已略去"
                ),
            );
            return Ok(());
        };
        if flags_of & (16 | 64) != 0 {
            self.path.left_out(
                line,
                text!("POLYLINE is a mesh: left out", "POLYLINE 是网格：已略去"),
            );
            return Ok(());
        }
        let mut vertices = Vec::new();
        for vertex in rest.chunk_by(|_, next| next.code != 0) {
            if vertex[0].value != "VERTEX" || flags(vertex)? & 16 != 0 {
                // Control points of a fitted curve are not on it.
                continue;
            }
            vertices.push((self.point(vertex, 10)?, number(vertex, 42, 0.0)?));
        }
        self.vertices(line, vertices, flags_of & 1 != 0, is_mirrored)
    }

    fn vertices(
        &mut self,
        line: u32,
        mut vertices: Vec<(Point, f64)>,
        is_closed: bool,
        is_mirrored: bool,
    ) -> Result<(), ToolpathError> {
        if is_mirrored {
            for (point, bulge) in &mut vertices {
                point[0] = -point[0];
                point[2] = -point[2];
                *bulge = -*bulge;
            }
        }
        let Some(first) = vertices.first().copied() else {
            return Ok(());
        };
        let next = vertices.iter().skip(1).copied();
        let targets: Vec<(Point, f64)> = next.chain(is_closed.then_some(first)).collect();
        let mut steps = Vec::new();
        for ((from, bulge), (to, _)) in vertices.into_iter().zip(targets) {
            if distance(from, to) < super::LENGTH_MIN_M {
                continue;
            }
            match bulge == 0.0 {
                true => steps.push(StepKind::Line(to)),
                false => {
                    let arc = bulged(from, to, bulge);
                    steps.extend(self.arc_steps(&arc, line, to)?);
                }
            }
        }
        self.contour(line, first.0, steps)
    }

    fn spline(&mut self, entity: &[Pair<'_>]) -> Result<(), ToolpathError> {
        let line = entity[0].line;
        let degree = number(entity, 71, 3.0)?;
        let mut spline = Spline {
            degree: if (1.0..=100.0).contains(&degree) {
                degree as usize
            } else {
                0
            },
            ..Spline::default()
        };
        let mut through: Vec<Point> = Vec::new();
        for pair in entity {
            match pair.code {
                11 => through.push([pair.number()? * self.unit_m, 0.0, 0.0]),
                21 | 31 => {
                    let value = pair.number()? * self.unit_m;
                    let axis = if pair.code == 21 { 1 } else { 2 };
                    if let Some(point) = through.last_mut() {
                        point[axis] = value;
                    }
                }
                40 => spline.knots.push(pair.number()?),
                41 => spline.weights.push(pair.number()?),
                10 => spline.points.push([pair.number()? * self.unit_m, 0.0, 0.0]),
                20 | 30 => {
                    let value = pair.number()? * self.unit_m;
                    let axis = if pair.code == 20 { 1 } else { 2 };
                    if let Some(point) = spline.points.last_mut() {
                        point[axis] = value;
                    }
                }
                _ => {}
            }
        }
        // Control points say the curve, whatever else is there.
        if spline.points.is_empty() {
            let tangent = |code: i32| -> Result<Option<Point>, ToolpathError> {
                let given = find(entity, code).map(|_| self.point(entity, code));
                given.transpose()
            };
            let tangents = [tangent(12)?, tangent(13)?];
            let Some(fitted) = Spline::through(&through, tangents) else {
                self.path.impossible(
                    line,
                    text!(
                        "a spline has neither control points nor two fit points that differ",
                        "样条曲线既没有控制点，也没有两个不同的拟合点"
                    ),
                );
                return Ok(());
            };
            spline = fitted;
        }
        if let Some(why) = spline.problem() {
            self.path.impossible(line, why);
            return Ok(());
        }
        let room = STEPS_MAX - self.steps.min(STEPS_MAX);
        let points = spline.lines(self.tolerance, room);
        self.lines(line, &points)
    }

    fn ellipse(&mut self, entity: &[Pair<'_>]) -> Result<(), ToolpathError> {
        let line = entity[0].line;
        let (centre, major) = (self.point(entity, 10)?, self.point(entity, 11)?);
        let ratio = number(entity, 40, 1.0)?;
        let across = [
            number(entity, 210, 0.0)?,
            number(entity, 220, 0.0)?,
            number(entity, 230, 1.0)?,
        ];
        let (Some(across), length) = (super::unit(across), super::norm(major)) else {
            self.path
                .impossible(line, text!("an ellipse without a plane", "椭圆没有平面"));
            return Ok(());
        };
        if length <= 0.0 || ratio.abs() <= 0.0 || ratio.abs() > 1.0 + 1e-9 {
            self.path
                .impossible(line, text!("an ellipse without a size", "椭圆没有尺寸"));
            return Ok(());
        }
        let minor = super::plus([0.0; 3], super::cross(across, major), ratio);
        let (begin, end) = (number(entity, 41, 0.0)?, number(entity, 42, TAU)?);
        let turned = turn(begin, end, false);
        let step = 2.0 * (1.0 - (self.tolerance / length).min(1.0)).acos();
        let count = (turned / step).ceil().clamp(8.0, 100_000.0) as u32;
        let points: Vec<Point> = (0..=count)
            .map(|index| {
                let angle = begin + turned * f64::from(index) / f64::from(count);
                let (sin, cos) = angle.sin_cos();
                super::plus(super::plus(centre, major, cos), minor, sin)
            })
            .collect();
        self.lines(line, &points)
    }

    fn lines(&mut self, line: u32, points: &[Point]) -> Result<(), ToolpathError> {
        let Some((first, rest)) = points.split_first() else {
            return Ok(());
        };
        let steps = rest.iter().map(|point| StepKind::Line(*point)).collect();
        self.contour(line, *first, steps)
    }

    /// Joins contours where one begins at the end of the one before, turned round if need be.
    fn finish(mut self) -> Result<Toolpath, ToolpathError> {
        let mut path = self.path;
        if self.contours.is_empty() {
            let layers = match self.layers {
                [] => Text::verbatim(""),
                some => text!(" on the layer {}", "（图层 {}）", some.join(", ")),
            };
            if path.remarks.iter().all(|remark| !remark.is_error) {
                let text = text!(
                    "there is no line, polyline, arc, circle, ellipse or spline{layers}",
                    "没有直线、多段线、圆弧、圆、椭圆或样条曲线{layers}"
                );
                return Err(ToolpathError::Empty { text });
            }
        }
        let mut here: Option<Point> = None;
        for index in 0..self.contours.len() {
            let next_begin = self.contours.get(index + 1).map(|next| {
                let end = next.steps.last().and_then(end_of).unwrap_or(next.begin);
                [next.begin, end]
            });
            let contour = &mut self.contours[index];
            let end = contour
                .steps
                .last()
                .and_then(end_of)
                .unwrap_or(contour.begin);
            let joins = |point: Point, other: Point| distance(point, other) < JOIN_M;
            let is_turned = match here {
                Some(here) => !joins(here, contour.begin) && joins(here, end),
                // The first one of a row is driven towards the second one.
                None => next_begin.is_some_and(|next| {
                    !next.iter().any(|point| joins(end, *point))
                        && next.iter().any(|point| joins(contour.begin, *point))
                }),
            };
            if is_turned {
                contour.turn_round();
            }
            if !here.is_some_and(|here| joins(here, contour.begin)) {
                if here.is_some() {
                    path.push(contour.line, StepKind::Switch(false, ""))?;
                }
                path.push(contour.line, StepKind::Rapid(contour.begin))?;
                path.push(contour.line, StepKind::Switch(true, ""))?;
            }
            let end = contour.steps.last().and_then(end_of);
            for kind in contour.steps.drain(..) {
                path.push(contour.line, kind)?;
            }
            here = end;
        }
        if let Some(last) = self.contours.last() {
            path.push(last.line, StepKind::Switch(false, ""))?;
        }
        Ok(path)
    }
}

fn flags(entity: &[Pair<'_>]) -> Result<i64, ToolpathError> {
    Ok(number(entity, 70, 0.0)? as i64)
}

fn end_of(kind: &StepKind) -> Option<Point> {
    match kind {
        StepKind::Line(to) | StepKind::Arc { to, .. } | StepKind::Rapid(to) => Some(*to),
        _ => None,
    }
}

impl Contour {
    fn turn_round(&mut self) {
        let mut from = self.begin;
        let mut turned = Vec::with_capacity(self.steps.len());
        for kind in self.steps.drain(..) {
            let to = end_of(&kind).unwrap_or(from);
            turned.push(match kind {
                StepKind::Arc { via, .. } => StepKind::Arc { via, to: from },
                _ => StepKind::Line(from),
            });
            from = to;
        }
        turned.reverse();
        self.begin = from;
        self.steps = turned;
    }
}

/// The arc between two vertices: the bulge is the tangent of a quarter of its turn, counter-clockwise where it is above
/// 0.
fn bulged(from: Point, to: Point, bulge: f64) -> Arc {
    let chord = [to[0] - from[0], to[1] - from[1]];
    let length = chord[0].hypot(chord[1]);
    // The centre lies to the left of the chord by this share of it.
    let height = (1.0 - bulge * bulge) / (4.0 * bulge);
    let centre = [
        from[0] + chord[0] / 2.0 - height * chord[1],
        from[1] + chord[1] / 2.0 + height * chord[0],
    ];
    Arc {
        plane: Plane::XY,
        centre,
        radius: length * (1.0 + bulge * bulge) / (4.0 * bulge.abs()),
        begin: (from[1] - centre[1]).atan2(from[0] - centre[0]),
        turn: 4.0 * bulge.atan(),
        height: [from[2], to[2]],
    }
}
