//! Curves on paper: panels one below the other on one time axis, commands as vertical lines through all of them.
//!
//! Drawn at twice the size and then averaged, which makes lines and letters smooth. The font is compiled in.

use std::sync::OnceLock;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, register_font};

use super::PlotError;
use super::curves::{Curve, Curves, Panel};

/// Drawn at this many times the size.
const SCALE: i32 = 2;
/// Family under which the compiled-in font is known to the drawing library.
const FONT: &str = "dejavu";

const PAPER: RGBColor = RGBColor(255, 255, 255);
const INK: RGBColor = RGBColor(38, 42, 48);
const FAINT_INK: RGBColor = RGBColor(110, 116, 124);
const AXIS: RGBColor = RGBColor(150, 156, 164);
const GRID: RGBColor = RGBColor(228, 231, 235);
const MARK: RGBColor = RGBColor(120, 128, 140);

/// Colours that also people with colour blindness tell apart (Okabe and Ito, 2008), darkened where they are pale.
const COLORS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(192, 148, 0),
    RGBColor(70, 160, 215),
];

/// Space around and between the panels, pixels of the finished picture.
const LEFT: i32 = 92;
const RIGHT: i32 = 96;
const TOP: i32 = 84;
const BOTTOM: i32 = 62;
const GAP: i32 = 34;

type Canvas<'a> = DrawingArea<BitMapBackend<'a>, plotters::coord::Shift>;

fn failed(error: impl std::fmt::Display) -> PlotError {
    PlotError::Draw(error.to_string())
}

/// The picture as RGB bytes, row by row.
pub(super) fn draw(curves: &Curves, (width, height): (u32, u32)) -> Result<Vec<u8>, PlotError> {
    load_font()?;
    let scale = SCALE as u32;
    let large = (width * scale, height * scale);
    let mut pixels = vec![0; 3 * large.0 as usize * large.1 as usize];
    {
        let canvas = BitMapBackend::with_buffer(&mut pixels, large).into_drawing_area();
        canvas.fill(&PAPER).map_err(failed)?;
        let frame = Frame::new(curves, width as i32, height as i32);
        frame.title(&canvas)?;
        for (index, panel) in curves.panels.iter().enumerate() {
            frame.panel(&canvas, index, panel)?;
        }
        frame.marks(&canvas)?;
        canvas.present().map_err(failed)?;
    }
    Ok(halve(&pixels, width as usize, height as usize))
}

fn load_font() -> Result<(), PlotError> {
    static LOADED: OnceLock<bool> = OnceLock::new();
    let loaded = LOADED.get_or_init(|| {
        register_font(FONT, FontStyle::Normal, dejavu::sans::regular()).is_ok()
            && register_font(FONT, FontStyle::Bold, dejavu::sans::bold()).is_ok()
    });
    if *loaded {
        Ok(())
    } else {
        Err(failed("the compiled-in font cannot be read"))
    }
}

/// Averages blocks of two by two pixels.
fn halve(pixels: &[u8], width: usize, height: usize) -> Vec<u8> {
    let row = 3 * 2 * width;
    let mut out = Vec::with_capacity(3 * width * height);
    for y in 0..height {
        for x in 0..width {
            for channel in 0..3 {
                let at = 2 * y * row + 6 * x + channel;
                let four = [at, at + 3, at + row, at + row + 3];
                let sum: u32 = four.iter().map(|&i| u32::from(pixels[i])).sum();
                out.push((sum / 4) as u8);
            }
        }
    }
    out
}

/// Where things are on the paper, in pixels of the finished picture.
struct Frame<'a> {
    curves: &'a Curves,
    width: i32,
    height: i32,
    panel_height: i32,
}

impl<'a> Frame<'a> {
    fn new(curves: &'a Curves, width: i32, height: i32) -> Self {
        let count = curves.panels.len().max(1) as i32;
        let room = height - TOP - BOTTOM - GAP * (count - 1);
        Self {
            curves,
            width,
            height,
            panel_height: room / count,
        }
    }

    fn top_of(&self, panel: usize) -> i32 {
        TOP + panel as i32 * (self.panel_height + GAP)
    }

    fn plot_right(&self) -> i32 {
        self.width - RIGHT
    }

    fn x_of(&self, time: f64) -> i32 {
        let (begin, end) = self.curves.range;
        let share = (time - begin) / (end - begin).max(f64::MIN_POSITIVE);
        LEFT + (share * f64::from(self.plot_right() - LEFT)).round() as i32
    }

    fn title(&self, canvas: &Canvas) -> Result<(), PlotError> {
        let text = &self.curves.title;
        self.text(
            canvas,
            text,
            (LEFT, 24),
            19,
            FontStyle::Bold,
            INK,
            HPos::Left,
        )?;
        let (begin, end) = self.curves.range;
        let mut facts = format!("{:.2} s", end - begin);
        if self.curves.unmarked > 0 {
            facts += &format!(", {} later commands not marked", self.curves.unmarked);
        }
        let place = (self.plot_right(), 24);
        self.text(
            canvas,
            &facts,
            place,
            15,
            FontStyle::Normal,
            FAINT_INK,
            HPos::Right,
        )
    }

    fn panel(&self, canvas: &Canvas, index: usize, panel: &Panel) -> Result<(), PlotError> {
        let (top, bottom) = (self.top_of(index), self.top_of(index) + self.panel_height);
        let is_last = index + 1 == self.curves.panels.len();
        let (low, high) = value_range(&panel.curves);
        let (begin, end) = self.curves.range;
        let y_ticks = ticks(low, high, 5);
        let x_ticks = ticks(begin, end, 12);
        let y_of = |value: f64| {
            let share = (value - low) / (high - low);
            bottom - (share * f64::from(bottom - top)).round() as i32
        };
        for &value in &y_ticks.values {
            let y = y_of(value);
            self.line(canvas, (LEFT, y), (self.plot_right(), y), GRID.into(), 1)?;
            let label = y_ticks.label(value);
            let place = (LEFT - 9, y);
            self.text(
                canvas,
                &label,
                place,
                13,
                FontStyle::Normal,
                FAINT_INK,
                HPos::Right,
            )?;
        }
        for &time in &x_ticks.values {
            let x = self.x_of(time);
            self.line(canvas, (x, top), (x, bottom), GRID.into(), 1)?;
            if is_last {
                let label = x_ticks.label(time);
                let place = (x, bottom + 15);
                self.text(
                    canvas,
                    &label,
                    place,
                    13,
                    FontStyle::Normal,
                    FAINT_INK,
                    HPos::Center,
                )?;
            }
        }
        if is_last {
            let place = ((LEFT + self.plot_right()) / 2, self.height - 18);
            self.text(
                canvas,
                "time in s",
                place,
                14,
                FontStyle::Normal,
                INK,
                HPos::Center,
            )?;
        }
        for (curve, color) in panel.curves.iter().zip(COLORS) {
            let points = path(curve).map(|(time, value)| {
                let share = (value - low) / (high - low);
                let (x, height) = (self.exact_x(time), f64::from(bottom - top));
                let y = f64::from(bottom) - share * height;
                let scale = f64::from(SCALE);
                ((x * scale).round() as i32, (y * scale).round() as i32)
            });
            let style = ShapeStyle::from(color).stroke_width(3);
            canvas
                .draw(&PathElement::new(points.collect::<Vec<_>>(), style))
                .map_err(failed)?;
        }
        for (from, to) in [
            ((LEFT, top), (LEFT, bottom)),
            ((LEFT, bottom), (self.plot_right(), bottom)),
        ] {
            self.line(canvas, from, to, AXIS.into(), 1)?;
        }
        let title = format!("{} in {}", panel.title, panel.unit);
        let place = (LEFT, top - 13);
        self.text(canvas, &title, place, 14, FontStyle::Bold, INK, HPos::Left)?;
        self.legend(canvas, top, panel)
    }

    fn legend(&self, canvas: &Canvas, top: i32, panel: &Panel) -> Result<(), PlotError> {
        let x = self.plot_right() + 16;
        for (row, (curve, color)) in panel.curves.iter().zip(COLORS).enumerate() {
            let y = top + 10 + 22 * row as i32;
            self.line(canvas, (x, y), (x + 24, y), color.into(), 3)?;
            let place = (x + 32, y);
            self.text(
                canvas,
                curve.name,
                place,
                14,
                FontStyle::Normal,
                INK,
                HPos::Left,
            )?;
        }
        Ok(())
    }

    /// Commands: a line through all panels, and the name where there is room for it.
    fn marks(&self, canvas: &Canvas) -> Result<(), PlotError> {
        let Some(last) = self.curves.panels.len().checked_sub(1) else {
            return Ok(());
        };
        let bottom = self.top_of(last) + self.panel_height;
        let mut free_from = LEFT;
        for (time, name) in &self.curves.marks {
            let x = self.x_of(*time);
            for panel in 0..=last {
                let top = self.top_of(panel);
                let mut y = top;
                while y < top + self.panel_height {
                    let dash_end = (y + 4).min(bottom);
                    self.line(canvas, (x, y), (x, dash_end), MARK.mix(0.55), 1)?;
                    y += 8;
                }
            }
            let width = 8 * name.chars().count() as i32 + 10;
            if x >= free_from && x + width <= self.width {
                let place = (x + 3, TOP - 34);
                self.text(canvas, name, place, 13, FontStyle::Normal, MARK, HPos::Left)?;
                self.line(canvas, (x, TOP - 40), (x, TOP - 28), MARK.into(), 1)?;
                free_from = x + width;
            }
        }
        Ok(())
    }

    fn exact_x(&self, time: f64) -> f64 {
        let (begin, end) = self.curves.range;
        let share = (time - begin) / (end - begin).max(f64::MIN_POSITIVE);
        f64::from(LEFT) + share * f64::from(self.plot_right() - LEFT)
    }

    fn line(
        &self,
        canvas: &Canvas,
        from: (i32, i32),
        to: (i32, i32),
        color: RGBAColor,
        width: i32,
    ) -> Result<(), PlotError> {
        let style = ShapeStyle::from(color).stroke_width((width * SCALE) as u32);
        let points = [from, to].map(|(x, y)| (x * SCALE, y * SCALE));
        canvas
            .draw(&PathElement::new(points.to_vec(), style))
            .map_err(failed)
    }

    #[allow(
        clippy::too_many_arguments,
        reason = "all of them describe one piece of text"
    )]
    fn text(
        &self,
        canvas: &Canvas,
        text: &str,
        (x, y): (i32, i32),
        size: i32,
        weight: FontStyle,
        color: RGBColor,
        anchor: HPos,
    ) -> Result<(), PlotError> {
        let font = FontDesc::new(FontFamily::Name(FONT), f64::from(size * SCALE), weight);
        let style = TextStyle::from(font)
            .color(&color)
            .pos(Pos::new(anchor, VPos::Center));
        let place = (x * SCALE, y * SCALE);
        canvas.draw_text(text, &style, place).map_err(failed)
    }
}

/// The polyline through a curve: in every slot from the smallest to the largest value, beginning with the one that is
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

/// Range of the value axis: all values with a little room, and not so narrow that noise fills it.
fn value_range(curves: &[Curve]) -> (f64, f64) {
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let low = points().map(|p| p.1).fold(f64::INFINITY, f64::min);
    let high = points().map(|p| p.2).fold(f64::NEG_INFINITY, f64::max);
    if low > high {
        return (-1.0, 1.0);
    }
    let middle = low + (high - low) / 2.0;
    let half = ((high - low) / 2.0 * 1.08)
        .max(0.1)
        .max(middle.abs() * 1e-6);
    (middle - half, middle + half)
}

/// Round values on an axis.
struct Ticks {
    values: Vec<f64>,
    digits: usize,
}

impl Ticks {
    fn label(&self, value: f64) -> String {
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
        .take_while(|value| *value <= high + step * 1e-6)
        .collect();
    let digits = (-step.log10().floor()).clamp(0.0, 12.0) as usize;
    Ticks { values, digits }
}
