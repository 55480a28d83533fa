//! G-code: straight and circular moves, units, planes, feed, and what switches the tool.
//!
//! Words follow RS274/NGC. What is not understood is named with its line and left out.

use core::f64::consts::PI;

use messages::{Text, text};

use super::arc::{Arc, Plane, turn};
use super::{LENGTH_MIN_M, Point, StepKind, Toolpath, ToolpathError, distance};

/// Metres of an inch.
const INCH_M: f64 = 0.0254;
/// Radii at the two ends of an arc may differ by this, m, and by this share.
const RADIUS_DIFFERENCE_M: f64 = 1e-5;
const RADIUS_DIFFERENCE_SHARE: f64 = 1e-3;

#[derive(Clone, Copy, PartialEq)]
enum Motion {
    Rapid,
    Line,
    Arc { is_clockwise: bool },
}

/// Modal state of the machine.
struct Machine {
    unit_m: f64,
    is_absolute: bool,
    has_absolute_centres: bool,
    plane: Plane,
    motion: Motion,
    position: Point,
    speed: Option<f64>,
}

/// The words of one line.
#[derive(Default)]
struct Block {
    words: Vec<(char, f64)>,
    unknown: Vec<String>,
}

/// Reads a text; helices become lines within `tolerance`, m.
///
/// # Errors
///
/// There is no move in it, or too many.
pub fn read(text: &str, tolerance: f64) -> Result<Toolpath, ToolpathError> {
    let mut machine = Machine {
        unit_m: 0.001,
        is_absolute: true,
        has_absolute_centres: false,
        plane: Plane::XY,
        motion: Motion::Line,
        position: [0.0; 3],
        speed: None,
    };
    let mut path = Toolpath::default();
    for (number, text) in (1..).zip(text.lines()) {
        let block = words(text);
        for word in &block.unknown {
            path.left_out(
                number,
                text!("'{word}' is not understood", "不理解 '{word}'"),
            );
        }
        if machine.run(&block, number, &mut path, tolerance)? {
            break;
        }
    }
    let has_moves = path.steps.iter().any(|step| {
        matches!(
            step.kind,
            StepKind::Line(_) | StepKind::Arc { .. } | StepKind::Rapid(_)
        )
    });
    match has_moves {
        true => Ok(path),
        false => Err(ToolpathError::Empty {
            text: text!(
                "there is no move (G0 to G3) in it",
                "其中没有运动（G0 到 G3）"
            ),
        }),
    }
}

/// The words of a line: a letter and a number each. Comments, line numbers and `%` are none.
fn words(text: &str) -> Block {
    const SHOWN_MAX: usize = 40;
    let mut block = Block::default();
    let text = text.split(';').next().unwrap_or_default();
    let mut rest = text.trim_start();
    rest = rest.strip_prefix('/').unwrap_or(rest);
    while let Some(first) = rest.chars().next() {
        if first.is_whitespace() || first == '%' {
            rest = &rest[first.len_utf8()..];
            continue;
        }
        if first == '(' {
            rest = rest.split_once(')').map_or("", |(_, after)| after);
            continue;
        }
        let tail = &rest[first.len_utf8()..];
        let value_text = tail.trim_start();
        let end = value_text
            .find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | '-' | '+')))
            .unwrap_or(value_text.len());
        let value: Option<f64> = value_text[..end].parse().ok();
        match value {
            Some(value) if first.is_ascii_alphabetic() => {
                let letter = first.to_ascii_uppercase();
                if letter != 'N' {
                    block.words.push((letter, value));
                }
                rest = &value_text[end..];
            }
            // Expressions, parameters, sub-programs: the whole line is another language.
            _ => {
                let shown: String = text.trim().chars().take(SHOWN_MAX).collect();
                return Block {
                    words: Vec::new(),
                    unknown: vec![shown],
                };
            }
        }
    }
    block
}

impl Block {
    fn value(&self, letter: char) -> Option<f64> {
        let found = self.words.iter().find(|(word, _)| *word == letter);
        found.map(|(_, value)| *value)
    }
}

/// A number as it is written in words.
fn shown(letter: char, value: f64) -> String {
    format!("{letter}{value}")
}

impl Machine {
    /// Runs a line; true at the end of the program.
    fn run(
        &mut self,
        block: &Block,
        line: u32,
        path: &mut Toolpath,
        tolerance: f64,
    ) -> Result<bool, ToolpathError> {
        let (mut is_end, mut is_dwell, mut switches) = (false, false, Vec::new());
        // Units and modes of the line hold for its numbers, wherever they stand in it.
        for (letter, value) in &block.words {
            match (*letter, (value * 10.0).round() as i64) {
                ('G', 0) => self.motion = Motion::Rapid,
                ('G', 10) => self.motion = Motion::Line,
                ('G', 20) => self.motion = Motion::Arc { is_clockwise: true },
                ('G', 30) => {
                    self.motion = Motion::Arc {
                        is_clockwise: false,
                    }
                }
                ('G', 40) => is_dwell = true,
                ('G', 170) => self.plane = Plane::XY,
                ('G', 180) => self.plane = Plane::ZX,
                ('G', 190) => self.plane = Plane::YZ,
                ('G', 200) => self.unit_m = INCH_M,
                ('G', 210) => self.unit_m = 0.001,
                ('G', 900) => self.is_absolute = true,
                ('G', 910) => self.is_absolute = false,
                ('G', 901) => self.has_absolute_centres = true,
                ('G', 911) => self.has_absolute_centres = false,
                // No offset of the cutter, no cycle, feed in units a minute, the part's coordinates.
                ('G', 400 | 490 | 800 | 940 | 540 | 550 | 560 | 570 | 580 | 590) => {}
                ('M', 30) => switches.push((true, "M3")),
                ('M', 50) => switches.push((false, "M5")),
                ('M', 70) => switches.push((true, "M7")),
                ('M', 80) => switches.push((true, "M8")),
                ('M', 90) => switches.push((false, "M9")),
                ('M', 20 | 300) => is_end = true,
                ('X' | 'Y' | 'Z' | 'I' | 'J' | 'K' | 'R' | 'F', _) => {}
                // The speed of a spindle, and the time of a pause.
                ('S', _) => {}
                ('P', _) if is_dwell => {}
                _ => path.left_out(
                    line,
                    text!("{} is not understood", "不理解 {}", shown(*letter, *value)),
                ),
            }
        }
        if let Some(feed) = block.value('F') {
            self.feed(feed, line, path)?;
        }
        for (is_on, word) in switches.iter().filter(|(is_on, _)| *is_on) {
            path.push(line, StepKind::Switch(*is_on, word))?;
        }
        if is_dwell {
            let seconds = block
                .value('P')
                .or_else(|| block.value('S'))
                .unwrap_or_default();
            match (0.0..=3600.0).contains(&seconds) {
                true => path.push(line, StepKind::Dwell(seconds))?,
                false => path.impossible(
                    line,
                    text!(
                        "a pause of {seconds} s: allowed are 0 to 3600",
                        "暂停 {seconds} s：允许 0 到 3600"
                    ),
                ),
            }
        } else {
            self.drive(block, line, path, tolerance)?;
        }
        for (is_on, word) in switches.iter().filter(|(is_on, _)| !*is_on) {
            path.push(line, StepKind::Switch(*is_on, word))?;
        }
        Ok(is_end)
    }

    fn feed(&mut self, feed: f64, line: u32, path: &mut Toolpath) -> Result<(), ToolpathError> {
        let speed = feed * self.unit_m / 60.0;
        if speed <= 0.0 {
            path.impossible(
                line,
                text!(
                    "a feed of {feed}: allowed is more than 0",
                    "进给为 {feed}：必须大于 0"
                ),
            );
        } else if self.speed != Some(speed) {
            self.speed = Some(speed);
            path.push(line, StepKind::Speed(speed))?;
        }
        Ok(())
    }

    fn drive(
        &mut self,
        block: &Block,
        line: u32,
        path: &mut Toolpath,
        tolerance: f64,
    ) -> Result<(), ToolpathError> {
        let axes = ['X', 'Y', 'Z'].map(|letter| block.value(letter));
        let centre = ['I', 'J', 'K'].map(|letter| block.value(letter));
        let is_arc = matches!(self.motion, Motion::Arc { .. });
        let has_centre = centre.iter().any(Option::is_some);
        if axes.iter().all(Option::is_none) && !(is_arc && has_centre) {
            return Ok(());
        }
        let mut to = self.position;
        for (coordinate, given) in to.iter_mut().zip(axes) {
            if let Some(given) = given {
                let given = given * self.unit_m;
                *coordinate = if self.is_absolute {
                    given
                } else {
                    *coordinate + given
                };
            }
        }
        if !to.iter().all(|x| x.abs() < 100.0) {
            path.impossible(
                line,
                text!("the target is more than 100 m away", "目标在 100 m 之外"),
            );
            return Ok(());
        }
        let from = std::mem::replace(&mut self.position, to);
        match self.motion {
            Motion::Rapid => path.push(line, StepKind::Rapid(to)),
            Motion::Line if distance(from, to) < LENGTH_MIN_M => Ok(()),
            Motion::Line => path.push(line, StepKind::Line(to)),
            Motion::Arc { is_clockwise } => {
                match self.arc(from, to, centre, block.value('R'), is_clockwise) {
                    Ok(arc) => arc.add_to(path, line, to, tolerance),
                    Err(why) => {
                        path.impossible(line, why);
                        Ok(())
                    }
                }
            }
        }
    }

    fn arc(
        &self,
        from: Point,
        to: Point,
        centre: [Option<f64>; 3],
        radius: Option<f64>,
        is_clockwise: bool,
    ) -> Result<Arc, Text> {
        let [first, second, across] = self.plane.axes;
        let (begin, end) = ([from[first], from[second]], [to[first], to[second]]);
        let chord = [end[0] - begin[0], end[1] - begin[1]];
        let length = chord[0].hypot(chord[1]);
        let mm = |length: f64| (length * 1e6).round() / 1e3;
        let middle = match radius {
            Some(given) => {
                let radius = given.abs() * self.unit_m;
                if length < LENGTH_MIN_M {
                    return Err(text!(
                        "an arc with R must end somewhere else",
                        "用 R 的圆弧，终点必须不同于起点"
                    ));
                }
                if radius < length / 2.0 - RADIUS_DIFFERENCE_M {
                    return Err(text!(
                        "an arc of radius {} mm cannot reach a point {} mm away",
                        "半径 {} mm 的圆弧到不了 {} mm 外的点",
                        mm(radius),
                        mm(length)
                    ));
                }
                // Of the two centres the one that makes less than half a turn, with a negative R the other one.
                let height = (radius * radius - length * length / 4.0).max(0.0).sqrt();
                let side = if is_clockwise == (given > 0.0) {
                    -1.0
                } else {
                    1.0
                };
                [
                    begin[0] + chord[0] / 2.0 - side * height * chord[1] / length,
                    begin[1] + chord[1] / 2.0 + side * height * chord[0] / length,
                ]
            }
            None => {
                let given =
                    [first, second].map(|axis| centre[axis].map(|value| value * self.unit_m));
                if given == [None, None] {
                    return Err(text!(
                        "an arc needs a centre (I, J, K) or a radius (R)",
                        "圆弧需要圆心（I、J、K）或半径（R）"
                    ));
                }
                let at = |axis: usize| match (given[axis], self.has_absolute_centres) {
                    (Some(value), true) => value,
                    (value, _) => begin[axis] + value.unwrap_or_default(),
                };
                [at(0), at(1)]
            }
        };
        let at_begin = (begin[0] - middle[0]).hypot(begin[1] - middle[1]);
        let at_end = (end[0] - middle[0]).hypot(end[1] - middle[1]);
        if !(LENGTH_MIN_M..=1e4).contains(&at_begin) {
            return Err(text!(
                "an arc of radius {} mm cannot be driven",
                "半径 {} mm 的圆弧无法执行",
                mm(at_begin)
            ));
        }
        let difference = (at_begin - at_end).abs();
        if difference > RADIUS_DIFFERENCE_M.max(RADIUS_DIFFERENCE_SHARE * at_begin) {
            return Err(text!(
                "the arc begins {} mm from its centre and ends {} mm from it",
                "圆弧起点距圆心 {} mm，终点距圆心 {} mm",
                mm(at_begin),
                mm(at_end)
            ));
        }
        let angle = |point: [f64; 2]| (point[1] - middle[1]).atan2(point[0] - middle[0]);
        let begin_angle = angle(begin);
        let turn = match length < LENGTH_MIN_M {
            true if is_clockwise => -2.0 * PI,
            true => 2.0 * PI,
            false => turn(begin_angle, angle(end), is_clockwise),
        };
        Ok(Arc {
            plane: self.plane,
            centre: middle,
            radius: at_begin,
            begin: begin_angle,
            turn,
            height: [from[across], to[across]],
        })
    }
}
