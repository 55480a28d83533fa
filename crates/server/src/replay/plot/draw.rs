//! The layout of the picture: panels one below the other on one time axis, commands as vertical lines through them.

use tiny_skia::Color;

use super::PlotError;
use super::canvas::{Align, Canvas, Line, Text};
use super::curves::{Curve, Curves, Panel};

/// Space around and between the panels, pixels.
const LEFT: f32 = 92.0;
const RIGHT: f32 = 96.0;
const TOP: f32 = 96.0;
const BOTTOM: f32 = 62.0;
const GAP: f32 = 38.0;
/// Where the title and the names of commands stand, pixels from the top.
const TITLE_Y: f32 = 28.0;
const MARKS_Y: f32 = 60.0;
/// Of more commands than these the lines are faint, so that the curves stay readable.
const MANY_MARKS: usize = 60;
/// Room after a command's name before the next one, pixels.
const MARK_SPACE: f32 = 10.0;

const fn rgb(r: u8, g: u8, b: u8) -> [u8; 3] {
    [r, g, b]
}

const PAPER: [u8; 3] = rgb(255, 255, 255);
const INK: [u8; 3] = rgb(38, 42, 48);
const FAINT_INK: [u8; 3] = rgb(104, 110, 118);
const AXIS: [u8; 3] = rgb(150, 156, 164);
const GRID: [u8; 3] = rgb(230, 233, 237);
const MARK: [u8; 3] = rgb(134, 142, 152);
const FAINT_MARK: [u8; 3] = rgb(206, 210, 216);

/// Colours that people with colour blindness tell apart too (Okabe and Ito, 2008), darker where they were pale.
const COLORS: [[u8; 3]; 6] = [
    rgb(0, 114, 178),
    rgb(213, 94, 0),
    rgb(0, 158, 115),
    rgb(204, 121, 167),
    rgb(192, 148, 0),
    rgb(70, 160, 215),
];

fn color([r, g, b]: [u8; 3]) -> Color {
    Color::from_rgba8(r, g, b, 255)
}

fn line(rgb: [u8; 3], width: f32) -> Line {
    Line {
        color: color(rgb),
        width,
        dash: None,
    }
}

fn text(size: f32, rgb: [u8; 3], align: Align) -> Text {
    Text {
        size,
        color: color(rgb),
        bold: false,
        align,
    }
}

fn bold(size: f32) -> Text {
    Text {
        bold: true,
        ..text(size, INK, Align::Left)
    }
}

pub(super) fn draw(curves: &Curves, (width, height): (u32, u32)) -> Result<Canvas, PlotError> {
    let mut canvas = Canvas::new(width, height, color(PAPER))?;
    let page = Page::new(curves, width as f32, height as f32);
    page.title(&mut canvas);
    page.time_axis(&mut canvas);
    page.marks(&mut canvas);
    for (index, panel) in curves.panels.iter().enumerate() {
        page.panel(&mut canvas, index, panel);
    }
    Ok(canvas)
}

/// Where things are on the page, in pixels.
struct Page<'a> {
    curves: &'a Curves,
    height: f32,
    /// Right end of the panels.
    right: f32,
    panel_height: f32,
}

impl<'a> Page<'a> {
    fn new(curves: &'a Curves, width: f32, height: f32) -> Self {
        let count = curves.panels.len().max(1) as f32;
        let room = height - TOP - BOTTOM - GAP * (count - 1.0);
        Self {
            curves,
            height,
            right: width - RIGHT,
            panel_height: room / count,
        }
    }

    /// Top and bottom of a panel; whole numbers, so that its lines are sharp.
    fn rows(&self, panel: usize) -> (f32, f32) {
        let top = TOP + panel as f32 * (self.panel_height + GAP);
        (sharp(top), sharp(top + self.panel_height))
    }

    fn x_of(&self, time: f64) -> f32 {
        let (begin, end) = self.curves.range;
        let share = (time - begin) / (end - begin).max(f64::MIN_POSITIVE);
        LEFT + share as f32 * (self.right - LEFT)
    }

    fn title(&self, canvas: &mut Canvas) {
        canvas.text(&self.curves.title, (LEFT, TITLE_Y), bold(20.0));
        let (begin, end) = self.curves.range;
        let mut facts = format!("{:.2} s", end - begin);
        if self.curves.unmarked > 0 {
            facts += &format!(", {} later commands not marked", self.curves.unmarked);
        }
        let style = text(15.0, FAINT_INK, Align::Right);
        canvas.text(&facts, (self.right, TITLE_Y), style);
    }

    fn time_axis(&self, canvas: &mut Canvas) {
        let (begin, end) = self.curves.range;
        let ticks = ticks(begin, end, 12);
        let mut below = 0.0;
        for index in 0..self.curves.panels.len() {
            let (top, bottom) = self.rows(index);
            for &time in &ticks.values {
                let x = sharp(self.x_of(time));
                canvas.line([(x, top), (x, bottom)], line(GRID, 1.0));
            }
            below = bottom;
        }
        let style = text(13.0, FAINT_INK, Align::Center);
        for &time in &ticks.values {
            canvas.text(&ticks.label(time), (self.x_of(time), below + 16.0), style);
        }
        let middle = (LEFT + self.right) / 2.0;
        let style = text(14.0, INK, Align::Center);
        canvas.text("time in s", (middle, self.height - 18.0), style);
    }

    /// Commands: a line through all panels, and the name where there is room for it.
    fn marks(&self, canvas: &mut Canvas) {
        let style = text(13.0, FAINT_INK, Align::Left);
        let many = self.curves.marks.len() > MANY_MARKS;
        let dashed = Line {
            dash: Some([4.0, 4.0]),
            ..line(if many { FAINT_MARK } else { MARK }, 1.0)
        };
        let mut free_from = 0.0;
        for (time, name) in &self.curves.marks {
            let x = sharp(self.x_of(*time));
            for index in 0..self.curves.panels.len() {
                let (top, bottom) = self.rows(index);
                canvas.line([(x, top), (x, bottom)], dashed);
            }
            let right = x + 4.0 + canvas.width(name, style);
            if x >= free_from && right <= self.right + RIGHT {
                canvas.line([(x, MARKS_Y - 6.0), (x, MARKS_Y + 6.0)], line(MARK, 1.0));
                canvas.text(name, (x + 4.0, MARKS_Y), style);
                free_from = right + MARK_SPACE;
            }
        }
    }

    fn panel(&self, canvas: &mut Canvas, index: usize, panel: &Panel) {
        let (top, bottom) = self.rows(index);
        let (low, high) = value_range(panel);
        let y_of = |value: f64| bottom - ((value - low) / (high - low)) as f32 * (bottom - top);
        let ticks = ticks(low, high, 5);
        let style = text(13.0, FAINT_INK, Align::Right);
        for &value in &ticks.values {
            let y = sharp(y_of(value));
            canvas.line([(LEFT, y), (self.right, y)], line(GRID, 1.0));
            canvas.text(&ticks.label(value), (LEFT - 9.0, y), style);
        }
        let (left, right) = (sharp(LEFT), self.right);
        let axes = [(left, top), (left, bottom), (right, bottom)];
        canvas.line(axes, line(AXIS, 1.0));
        for (curve, rgb) in panel.curves.iter().zip(COLORS) {
            let points = path(curve).map(|(time, value)| (self.x_of(time), y_of(value)));
            canvas.line(points, line(rgb, 1.7));
        }
        let title = format!("{}, {}", panel.title, panel.unit);
        canvas.text(&title, (LEFT, top - 14.0), bold(14.0));
        self.legend(canvas, top, panel);
    }

    fn legend(&self, canvas: &mut Canvas, top: f32, panel: &Panel) {
        let x = self.right + 16.0;
        for (row, (curve, rgb)) in panel.curves.iter().zip(COLORS).enumerate() {
            let y = top + 10.0 + 22.0 * row as f32;
            canvas.line([(x, y), (x + 24.0, y)], line(rgb, 3.0));
            canvas.text(curve.name, (x + 34.0, y), text(14.0, INK, Align::Left));
        }
    }
}

/// The middle of a pixel: lines of one pixel through it are sharp.
fn sharp(x: f32) -> f32 {
    x.floor() + 0.5
}

/// The line through a curve: in every slot from the smallest to the largest value, beginning with the one that is
/// nearer to where the line comes from.
fn path(curve: &Curve) -> impl Iterator<Item = (f64, f64)> + '_ {
    let mut latest = None;
    curve.points.iter().flat_map(move |&(time, low, high)| {
        let from = latest.unwrap_or(low);
        let rising = (from - low).abs() <= (from - high).abs();
        let (first, second) = if rising { (low, high) } else { (high, low) };
        latest = Some(second);
        let both = [(time, first), (time, second)];
        let count = if low == high { 1 } else { 2 };
        both.into_iter().take(count)
    })
}

/// Range of the value axis: all values with a little room.
fn value_range(panel: &Panel) -> (f64, f64) {
    let points = || panel.curves.iter().flat_map(|curve| &curve.points);
    let low = points().map(|p| p.1).fold(f64::INFINITY, f64::min);
    let high = points().map(|p| p.2).fold(f64::NEG_INFINITY, f64::max);
    if low > high {
        return (-panel.half_span_min, panel.half_span_min);
    }
    // Halves first: the sum of two very large numbers is not finite.
    let middle = low / 2.0 + high / 2.0;
    let half = (high / 2.0 - low / 2.0) * 1.08;
    // Where numbers are so large that the smallest span vanishes in rounding, a share of them is the span.
    let half = half.max(panel.half_span_min).max(middle.abs() * 1e-9);
    (middle - half, middle + half)
}

/// Round values on an axis.
struct Ticks {
    values: Vec<f64>,
    digits: usize,
}

impl Ticks {
    fn label(&self, value: f64) -> String {
        if value.abs() >= 1e7 {
            return format!("{value:.1e}");
        }
        // Without the sign of zero.
        let value = if value == 0.0 { 0.0 } else { value };
        format!("{value:.digits$}", digits = self.digits)
    }
}

/// About `count` multiples of 1, 2 or 5 times a power of ten within the range.
fn ticks(low: f64, high: f64, count: usize) -> Ticks {
    let wanted = (high - low) / count as f64;
    let power = 10_f64.powf(wanted.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|factor| factor * power)
        .find(|step| *step >= wanted * 0.999)
        .unwrap_or(10.0 * power);
    if !(step.is_finite() && step > 0.0) {
        return Ticks {
            values: Vec::new(),
            digits: 0,
        };
    }
    let first = (low / step).ceil();
    let values = (0..=2 * count)
        .map(|i| (first + i as f64) * step)
        .take_while(|value| *value - high <= step * 1e-6)
        .collect();
    let digits = (-step.log10().floor()).clamp(0.0, 12.0) as usize;
    Ticks { values, digits }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within_the_range() {
        let shown = |low, high, count| {
            let ticks = ticks(low, high, count);
            let labels = ticks.values.iter().map(|v| ticks.label(*v));
            labels.collect::<Vec<_>>().join(" ")
        };
        assert_eq!(shown(-1.7, 1.7, 5), "-1 0 1");
        assert_eq!(
            shown(0.0, 2.4, 12),
            "0.0 0.2 0.4 0.6 0.8 1.0 1.2 1.4 1.6 1.8 2.0 2.2 2.4"
        );
        assert_eq!(shown(-0.03, 0.06, 5), "-0.02 0.00 0.02 0.04 0.06");
        assert_eq!(shown(3.0, 3.0, 5), "");
        assert_eq!(shown(0.0, f64::MAX, 5).split(' ').count(), 4);
    }

    #[test]
    fn a_curve_passes_every_extreme_and_jumps_as_little_as_possible() {
        let curve = Curve {
            name: "x",
            points: vec![(0.0, 1.0, 1.0), (1.0, -2.0, 3.0), (2.0, -3.0, 2.0)],
        };
        let points: Vec<_> = path(&curve).collect();
        assert_eq!(
            points,
            [(0.0, 1.0), (1.0, 3.0), (1.0, -2.0), (2.0, -3.0), (2.0, 2.0)]
        );
    }

    #[test]
    fn an_axis_has_room_for_any_finite_values() {
        for (low, high) in [(0.0, 0.0), (5.0, 5.0), (-1e300, 1e300), (1e300, 1e300)] {
            let panel = Panel {
                title: "",
                unit: "",
                half_span_min: 0.1,
                curves: vec![Curve {
                    name: "x",
                    points: vec![(0.0, low, high)],
                }],
            };
            let (bottom, top) = value_range(&panel);
            assert!(
                bottom < low && high < top && (top - bottom).is_finite(),
                "{low} {high}"
            );
        }
    }
}
