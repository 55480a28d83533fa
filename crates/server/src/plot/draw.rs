//! The layout of a figure: where the panels are, what stands around them.
//!
//! Panels over time form a column with one time axis, planes a second column; without panels over time the planes stand
//! side by side. Marks are drawn first, curves over them.

use tiny_skia::Color;

use super::axis::{Ticks, range};
use super::canvas::{Align, Canvas, StrokeStyle, TextStyle};
use super::palette::{COLORS, Rgb};
use super::{
    Axes, Circle, Curve, CurveStyle, Figure, Marks, MinMaxBins, POINTS_MAX, PlotError, PlotPanel,
};

/// Space left of and below axes, and between panels, pixels.
const LEFT: f32 = 92.0;
const BOTTOM: f32 = 62.0;
const GAP: f32 = 38.0;
/// The title, the first row of marks, and from one row of marks to the next.
const TITLE_Y: f32 = 28.0;
const MARKS_Y: f32 = 58.0;
const MARKS_ROW: f32 = 22.0;
/// From the last row above the panels to the first panel: the panel's title is in between.
const PANEL_TITLE: f32 = 36.0;
/// Room for the legend beside a panel, at least and at most.
const LEGEND: (f32, f32) = (96.0, 260.0);
const WIDTH: u32 = 1600;
const TIME_PANEL_HEIGHT: f32 = 232.0;
const PLANE_HEIGHT: f32 = 520.0;
/// The part of the width that the column of planes takes beside panels over time.
const PLANES_SHARE: f32 = 0.42;
/// Of more marks than these the lines are faint, so that the curves stay readable.
const MANY_MARKS: usize = 60;
/// Room after a mark's name before the next one, pixels.
const MARK_SPACE: f32 = 10.0;

const PAPER: Rgb = [255, 255, 255];
const INK: Rgb = [38, 42, 48];
const FAINT_INK: Rgb = [104, 110, 118];
const AXIS: Rgb = [150, 156, 164];
const GRID: Rgb = [230, 233, 237];
const MARK: Rgb = [134, 142, 152];
const FAINT_MARK: Rgb = [206, 210, 216];
const DARK_MARK: Rgb = [60, 66, 76];

pub(super) fn draw(figure: &Figure) -> Result<Canvas, PlotError> {
    let layout = Layout::new(figure);
    let (width, height) = layout.size;
    let mut canvas = Canvas::new(width, height, color(PAPER))?;
    canvas.text(&figure.title, (LEFT, TITLE_Y), bold(20.0));
    let end = (width as f32 - 24.0, TITLE_Y);
    canvas.text(&figure.note, end, text(15.0, FAINT_INK, Align::Right));

    let time = time_range(figure);
    let timed: Vec<_> = layout.places(figure, false).collect();
    time_axis(&mut canvas, time, &timed, layout.size.1 as f32);
    for (row, marks) in figure.marks.iter().enumerate() {
        let y = MARKS_Y + MARKS_ROW * row as f32;
        draw_marks(&mut canvas, marks, y, time, &timed);
    }
    for (panel, area) in timed {
        panel_over_time(&mut canvas, panel, area, time);
    }
    for (panel, area) in layout.places(figure, true) {
        plane(&mut canvas, panel, area);
    }
    Ok(canvas)
}

/// The inside of a pair of axes, pixels.
#[derive(Clone, Copy)]
struct Area {
    left: f32,
    right: f32,
    top: f32,
    bottom: f32,
}

/// Values to pixels.
#[derive(Clone, Copy)]
struct Scale {
    area: Area,
    x: (f64, f64),
    y: (f64, f64),
}

impl Scale {
    fn x(&self, x: f64) -> f32 {
        let share = (x - self.x.0) / (self.x.1 - self.x.0).max(f64::MIN_POSITIVE);
        self.area.left + share as f32 * (self.area.right - self.area.left)
    }

    fn y(&self, y: f64) -> f32 {
        let share = (y - self.y.0) / (self.y.1 - self.y.0).max(f64::MIN_POSITIVE);
        self.area.bottom - share as f32 * (self.area.bottom - self.area.top)
    }

    fn place(&self, (x, y): (f64, f64)) -> (f32, f32) {
        (self.x(x), self.y(y))
    }
}

/// Places of the two columns on the page.
struct Layout {
    size: (u32, u32),
    top: f32,
    /// Right edge of the column of panels over time; left edge of that of the planes.
    split: f32,
    timed: usize,
    planes: usize,
}

impl Layout {
    fn new(figure: &Figure) -> Self {
        let planes = figure.panels.iter().filter(|p| p.is_plane()).count();
        let timed = figure.panels.len() - planes;
        let top = MARKS_Y + MARKS_ROW * figure.marks.len() as f32 - MARKS_ROW + PANEL_TITLE;
        let stacked = |count: usize, height: f32| {
            count as f32 * height + count.saturating_sub(1) as f32 * GAP
        };
        let size = figure.size.unwrap_or_else(|| {
            let below_each_other = if timed == 0 { planes.min(1) } else { planes };
            let planes_height = stacked(below_each_other, PLANE_HEIGHT);
            let height = stacked(timed, TIME_PANEL_HEIGHT).max(planes_height);
            (WIDTH, (top + height + BOTTOM) as u32)
        });
        let width = size.0 as f32;
        let split = match (timed, planes) {
            (_, 0) => width,
            (0, _) => 0.0,
            _ => width * (1.0 - PLANES_SHARE),
        };
        Self {
            size,
            top,
            split,
            timed,
            planes,
        }
    }

    /// The panels of one kind and where they are.
    fn places<'a>(
        &self,
        figure: &'a Figure,
        planes: bool,
    ) -> impl Iterator<Item = (&'a PlotPanel, Area)> + use<'a> {
        let (count, side_by_side) = if planes {
            (self.planes, self.timed == 0)
        } else {
            (self.timed, false)
        };
        let (begin, end) = if planes {
            (self.split, self.size.0 as f32)
        } else {
            (0.0, self.split)
        };
        let (columns, rows) = if side_by_side { (count, 1) } else { (1, count) };
        let column = (end - begin) / columns.max(1) as f32;
        let top = self.top;
        let height = self.size.1 as f32 - top - BOTTOM;
        // Planes one below the other need room for the labels of their x axes.
        let gap = if planes { GAP + BOTTOM - 18.0 } else { GAP };
        let row_height = (height - gap * rows.saturating_sub(1) as f32) / rows.max(1) as f32;
        let shown = figure.panels.iter().filter(move |p| p.is_plane() == planes);
        let legend = shown.clone().map(legend_width).fold(LEGEND.0, f32::max);
        shown.enumerate().map(move |(index, panel)| {
            let (across, down) = if side_by_side { (index, 0) } else { (0, index) };
            let left = begin + column * across as f32;
            let top = top + (row_height + gap) * down as f32;
            // Whole numbers, so that lines are sharp.
            let area = Area {
                left: sharp(left + LEFT),
                right: sharp(left + column - legend),
                top: sharp(top),
                bottom: sharp(top + row_height),
            };
            (panel, area)
        })
    }
}

/// About as wide as the longest name in a legend is.
fn legend_width(panel: &PlotPanel) -> f32 {
    let names = panel.curves.iter().map(|curve| curve.name.chars().count());
    let longest = names.max().unwrap_or(0) as f32;
    (66.0 + 8.2 * longest).min(LEGEND.1)
}

/// Over all curves, or as the figure says.
fn time_range(figure: &Figure) -> (f64, f64) {
    if let Some(range) = figure.time {
        return range;
    }
    let timed = figure.panels.iter().filter(|p| !p.is_plane());
    let times = timed.flat_map(|p| &p.curves).flat_map(Curve::finite);
    let (begin, end) = times.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (x, _)| {
        (low.min(x), high.max(x))
    });
    if begin <= end {
        (begin, end)
    } else {
        (0.0, 1.0)
    }
}

fn time_axis(canvas: &mut Canvas, time: (f64, f64), panels: &[(&PlotPanel, Area)], height: f32) {
    let Some((_, last)) = panels.last() else {
        return;
    };
    let ticks = Ticks::new(time.0, time.1, ((last.right - last.left) / 110.0) as usize);
    let style = text(13.0, FAINT_INK, Align::Center);
    for &at in &ticks.values {
        for (_, area) in panels {
            let x = sharp(scale_of(*area, time).x(at));
            canvas.line([(x, area.top), (x, area.bottom)], line(GRID, 1.0));
        }
        let x = scale_of(*last, time).x(at);
        canvas.text(&ticks.label(at), (x, last.bottom + 16.0), style);
    }
    let middle = (last.left + last.right) / 2.0;
    let style = text(14.0, INK, Align::Center);
    canvas.text("time in s", (middle, height - 18.0), style);
}

fn scale_of(area: Area, time: (f64, f64)) -> Scale {
    Scale {
        area,
        x: time,
        y: (0.0, 1.0),
    }
}

/// Lines through all panels over time; names in the row at `row_y`, where there is room.
fn draw_marks(
    canvas: &mut Canvas,
    marks: &Marks,
    row_y: f32,
    time: (f64, f64),
    panels: &[(&PlotPanel, Area)],
) {
    let Some((_, first)) = panels.first() else {
        return;
    };
    if marks.is_empty() {
        return;
    }
    let name = text(13.0, FAINT_INK, Align::Right);
    canvas.text(&marks.name, (first.left - 9.0, row_y), name);
    let many = marks.len() > MANY_MARKS;
    let style = match (marks.dark, many) {
        (true, false) => line(DARK_MARK, 1.0),
        (true, true) => line(MARK, 1.0),
        (false, _) => StrokeStyle {
            dash: Some([4.0, 4.0]),
            ..line(if many { FAINT_MARK } else { MARK }, 1.0)
        },
    };
    let letters = if marks.dark {
        text(13.0, INK, Align::Left)
    } else {
        text(13.0, FAINT_INK, Align::Left)
    };
    let mut free_from = 0.0;
    for (at, name) in &marks.at {
        if !(time.0..=time.1).contains(at) {
            continue;
        }
        let x = sharp(scale_of(*first, time).x(*at));
        for (_, area) in panels {
            canvas.line([(x, area.top), (x, area.bottom)], style);
        }
        let right = x + 4.0 + canvas.width(name, letters);
        if x >= free_from && right <= first.right + LEGEND.0 {
            canvas.line([(x, row_y - 6.0), (x, row_y + 6.0)], line(MARK, 1.0));
            canvas.text(name, (x + 4.0, row_y), letters);
            free_from = right + MARK_SPACE;
        }
    }
}

fn panel_over_time(canvas: &mut Canvas, panel: &PlotPanel, area: Area, time: (f64, f64)) {
    let shown = panel.curves.iter().flat_map(|curve| within(curve, time));
    let values = shown.map(|(_, y)| y);
    let levels = panel.levels.iter().map(|(_, y)| *y);
    let scale = Scale {
        area,
        x: time,
        y: range(
            values.chain(levels).filter(|y| y.is_finite()),
            panel.half_span_min,
        ),
    };
    let Axes::Time { unit } = &panel.axes else {
        return;
    };
    value_axis(canvas, &scale);
    levels_and_curves(canvas, panel, &scale, time);
    let title = if unit.is_empty() {
        panel.title.clone()
    } else {
        format!("{}, {unit}", panel.title)
    };
    canvas.text(&title, (area.left, area.top - 14.0), bold(14.0));
}

/// The axes' lines, round values and the grid across.
fn value_axis(canvas: &mut Canvas, scale: &Scale) {
    let Area {
        left,
        right,
        top,
        bottom,
    } = scale.area;
    let count = ((bottom - top) / 46.0).max(2.0) as usize;
    let ticks = Ticks::new(scale.y.0, scale.y.1, count);
    let style = text(13.0, FAINT_INK, Align::Right);
    for &value in &ticks.values {
        let y = sharp(scale.y(value));
        canvas.line([(left, y), (right, y)], line(GRID, 1.0));
        canvas.text(&ticks.label(value), (left - 9.0, y), style);
    }
    let axes = [(left, top), (left, bottom), (right, bottom)];
    canvas.line(axes, line(AXIS, 1.0));
}

fn plane(canvas: &mut Canvas, panel: &PlotPanel, area: Area) {
    let Axes::Plane { x, y } = &panel.axes else {
        return;
    };
    let scale = plane_scale(panel, area);
    let count = ((area.right - area.left) / 90.0).max(2.0) as usize;
    let ticks = Ticks::new(scale.x.0, scale.x.1, count);
    let style = text(13.0, FAINT_INK, Align::Center);
    for &value in &ticks.values {
        let at = sharp(scale.x(value));
        canvas.line([(at, area.top), (at, area.bottom)], line(GRID, 1.0));
        canvas.text(&ticks.label(value), (at, area.bottom + 16.0), style);
    }
    value_axis(canvas, &scale);
    for circle in &panel.circles {
        draw_circle(canvas, circle, &scale);
    }
    levels_and_curves(canvas, panel, &scale, (f64::NEG_INFINITY, f64::INFINITY));
    let middle = (area.left + area.right) / 2.0;
    let style = text(14.0, INK, Align::Center);
    canvas.text(x, (middle, area.bottom + 40.0), style);
    let title = format!("{}; {y}", panel.title);
    canvas.text(&title, (area.left, area.top - 14.0), bold(14.0));
}

/// Everything inside, and a pixel as many units across as down.
fn plane_scale(panel: &PlotPanel, area: Area) -> Scale {
    let round = |center: fn(&Circle) -> f64| {
        panel
            .circles
            .iter()
            .flat_map(move |circle| [-1.0, 1.0].map(|side| center(circle) + side * circle.radius))
    };
    let points = || panel.curves.iter().flat_map(Curve::finite);
    let levels = panel.levels.iter().map(|(_, y)| *y);
    let x = range(
        points().map(|p| p.0).chain(round(|c| c.center.0)),
        panel.half_span_min,
    );
    let y = range(
        points()
            .map(|p| p.1)
            .chain(round(|c| c.center.1))
            .chain(levels),
        panel.half_span_min,
    );
    let (width, height) = (
        f64::from(area.right - area.left),
        f64::from(area.bottom - area.top),
    );
    let per_pixel = ((x.1 - x.0) / width).max((y.1 - y.0) / height);
    let widened = |(low, high): (f64, f64), pixels: f64| {
        let middle = low / 2.0 + high / 2.0;
        let half = per_pixel * pixels / 2.0;
        (middle - half, middle + half)
    };
    Scale {
        area,
        x: widened(x, width),
        y: widened(y, height),
    }
}

fn draw_circle(canvas: &mut Canvas, circle: &Circle, scale: &Scale) {
    let (x, y) = circle.center;
    if !(x.is_finite() && y.is_finite() && circle.radius.is_finite()) {
        return;
    }
    let around = (0..=90).map(|i| {
        let angle = f64::from(i) / 90.0 * core::f64::consts::TAU;
        let (sin, cos) = angle.sin_cos();
        scale.place((x + circle.radius * cos, y + circle.radius * sin))
    });
    let dashed = StrokeStyle {
        dash: Some([5.0, 4.0]),
        ..line(MARK, 1.3)
    };
    canvas.line(around, dashed);
    let corner = core::f64::consts::FRAC_1_SQRT_2 * circle.radius;
    let (x, y) = scale.place((x + corner, y + corner));
    let style = text(12.0, FAINT_INK, Align::Left);
    canvas.text(&circle.name, (x + 5.0, y - 7.0), style);
}

fn levels_and_curves(canvas: &mut Canvas, panel: &PlotPanel, scale: &Scale, shown: (f64, f64)) {
    let Area { left, right, .. } = scale.area;
    for (name, value) in panel.levels.iter().filter(|(_, y)| y.is_finite()) {
        let y = sharp(scale.y(*value));
        let dashed = StrokeStyle {
            dash: Some([7.0, 5.0]),
            ..line(FAINT_INK, 1.2)
        };
        canvas.line([(left, y), (right, y)], dashed);
        let style = text(12.0, FAINT_INK, Align::Right);
        canvas.text(name, (right - 6.0, y - 9.0), style);
    }
    for (number, curve) in panel.curves.iter().enumerate() {
        let rgb = COLORS[curve.color.unwrap_or(number) % COLORS.len()];
        draw_curve(canvas, curve, rgb, scale, shown);
        let at = (right + 16.0, scale.area.top + 10.0 + 22.0 * number as f32);
        legend(canvas, curve, rgb, at);
    }
}

fn legend(canvas: &mut Canvas, curve: &Curve, rgb: Rgb, (x, y): (f32, f32)) {
    match curve.style {
        CurveStyle::Dots => canvas.dot((x + 12.0, y), 3.5, color(rgb)),
        style => canvas.line([(x, y), (x + 24.0, y)], curve_line(style, rgb, 3.0)),
    }
    let style = text(14.0, INK, Align::Left);
    canvas.text(&curve.name, (x + 34.0, y), style);
}

fn curve_line(style: CurveStyle, rgb: Rgb, width: f32) -> StrokeStyle {
    StrokeStyle {
        dash: (style == CurveStyle::Dashed).then_some([6.0, 4.0]),
        ..line(rgb, width)
    }
}

fn draw_curve(canvas: &mut Canvas, curve: &Curve, rgb: Rgb, scale: &Scale, shown: (f64, f64)) {
    if curve.style == CurveStyle::Dots {
        for point in within(curve, shown) {
            canvas.dot(scale.place(point), 2.6, color(rgb));
        }
        return;
    }
    let style = curve_line(curve.style, rgb, 1.7);
    if curve.points.len() > POINTS_MAX && shown.0.is_finite() {
        let mut slots = MinMaxBins::new(shown);
        for (x, y) in within(curve, shown) {
            slots.add(x, y);
        }
        let points = slots.points();
        canvas.line(points.into_iter().map(|p| scale.place(p)), style);
        return;
    }
    let runs = curve
        .points
        .split(|(x, y)| !(x.is_finite() && y.is_finite()));
    for run in runs {
        let inside = run.iter().filter(|(x, _)| (shown.0..=shown.1).contains(x));
        canvas.line(inside.map(|p| scale.place(*p)), style);
    }
}

/// The finite points of a curve from here to there.
fn within(curve: &Curve, (begin, end): (f64, f64)) -> impl Iterator<Item = (f64, f64)> + '_ {
    let inside = move |(x, _): &(f64, f64)| (begin..=end).contains(x);
    curve.finite().filter(inside)
}

fn color([r, g, b]: Rgb) -> Color {
    Color::from_rgba8(r, g, b, 255)
}

fn line(rgb: Rgb, width: f32) -> StrokeStyle {
    StrokeStyle {
        color: color(rgb),
        width,
        dash: None,
    }
}

fn text(size: f32, rgb: Rgb, align: Align) -> TextStyle {
    TextStyle {
        size,
        color: color(rgb),
        bold: false,
        align,
    }
}

fn bold(size: f32) -> TextStyle {
    TextStyle {
        bold: true,
        ..text(size, INK, Align::Left)
    }
}

/// The middle of a pixel: lines of one pixel through it are sharp.
fn sharp(x: f32) -> f32 {
    x.floor() + 0.5
}
