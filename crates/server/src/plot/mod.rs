//! Pictures of measured curves as PNG files: panels over one time axis, planes with equal axes beside them.
//!
//! A [`Figure`] says what is shown; its layout, colours and letters are decided here. [`draw`] lays it out, [`axis`]
//! finds round numbers, [`canvas`] makes pixels; the font is compiled in. What is drawn of a recording is decided in
//! `replay::plot`.
//!
//! ```
//! use server::plot::{Circle, Curve, Figure, Marks, PlotPanel};
//!
//! let speed = Curve::new("J1", (0..100).map(|i| (i as f64 * 0.01, (i as f64 * 0.1).sin())));
//! let path = Curve::new("path", (0..100).map(|i| (i as f64, 0.2 * i as f64)));
//! let figure = Figure::new("A movej")
//!     .note("cs66")
//!     .panel(PlotPanel::over_time("Joint speeds", "rad/s").curve(speed).level("limit", 0.9))
//!     .panel(PlotPanel::plane("TCP from above", "x in mm", "y in mm").curve(path).circle(Circle {
//!         center: (50.0, 10.0),
//!         radius: 8.0,
//!         name: "blend zone".to_owned(),
//!     }))
//!     .marks(Marks::dashed("command").at(0.2, "movej"));
//! let png: Vec<u8> = figure.to_png()?;
//! # assert!(png.starts_with(b"\x89PNG"));
//! # Ok::<(), server::plot::PlotError>(())
//! ```
//!
//! Panels over time stand one below the other and share their time axis; planes stand in a column to the right of them,
//! or side by side when there are no others. [`Marks`] are vertical lines through all panels over time, with their
//! names in a row of their own above. The picture grows in height with its panels ([`Figure::size`] sets it).

mod axis;
mod canvas;
pub mod clearance;
mod draw;
mod palette;

use std::io;
use std::path::{Path, PathBuf};

use messages::{Localized, Text};
use thiserror::Error;

/// Points of one curve that are drawn; of more, every column of the picture keeps its smallest and largest value.
const POINTS_MAX: usize = 6000;
/// Slots of time that a thinned curve has: a little more than the columns of a picture.
pub(crate) const SLOTS: usize = 1500;

/// A reason why there is no picture.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum PlotError {
    /// The compiled-in font cannot be read, or there is no memory for the picture.
    #[error("the picture cannot be drawn: {0}")]
    #[zh("无法绘制图片：{0}")]
    Draw(Text),
    /// The picture cannot be encoded.
    #[error("the picture cannot be encoded: {0}")]
    #[zh("无法编码图片：{0}")]
    Encode(String),
    /// The file cannot be written.
    #[error("cannot write the picture {}: {source}", path.display())]
    #[zh("无法写入图片 {}：{source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
}

/// One picture.
#[derive(Clone, Debug)]
pub struct Figure {
    title: String,
    note: String,
    size: Option<(u32, u32)>,
    time: Option<(f64, f64)>,
    panels: Vec<PlotPanel>,
    marks: Vec<Marks>,
}

impl Figure {
    /// A figure without panels.
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            note: String::new(),
            size: None,
            time: None,
            panels: Vec::new(),
            marks: Vec::new(),
        }
    }

    /// Small print at the right end of the title's line.
    #[must_use]
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.note = note.into();
        self
    }

    /// Width and height, pixels; otherwise 1600 and as many as the panels need.
    #[must_use]
    pub fn size(mut self, width: u32, height: u32) -> Self {
        self.size = Some((width, height));
        self
    }

    /// The time axis goes from here to there, s; otherwise over all curves.
    #[must_use]
    pub fn time_range(mut self, begin: f64, end: f64) -> Self {
        self.time = Some((begin, end));
        self
    }

    /// Adds a panel below the ones of its kind, a plane beside them.
    #[must_use]
    pub fn panel(mut self, panel: PlotPanel) -> Self {
        self.panels.push(panel);
        self
    }

    /// Adds a row of marks.
    #[must_use]
    pub fn marks(mut self, marks: Marks) -> Self {
        self.marks.push(marks);
        self
    }

    /// The picture as the bytes of a PNG file.
    ///
    /// # Errors
    /// [`PlotError::Draw`] for a picture that is too large, [`PlotError::Encode`] when there is no memory.
    pub fn to_png(&self) -> Result<Vec<u8>, PlotError> {
        draw::draw(self)?.into_png()
    }

    /// Writes the picture into a PNG file.
    ///
    /// # Errors
    /// [`PlotError`].
    pub fn save(&self, path: &Path) -> Result<(), PlotError> {
        std::fs::write(path, self.to_png()?).map_err(|source| PlotError::Write {
            path: path.to_owned(),
            source,
        })
    }
}

/// Curves on one pair of axes.
#[derive(Clone, Debug)]
pub struct PlotPanel {
    title: String,
    axes: Axes,
    half_span_min: f64,
    curves: Vec<Curve>,
    levels: Vec<(String, f64)>,
    circles: Vec<Circle>,
}

#[derive(Clone, Debug)]
enum Axes {
    /// Over the figure's time axis; the unit of the values.
    Time { unit: String },
    /// x and y to the same scale; their labels.
    Plane { x: String, y: String },
}

impl PlotPanel {
    /// A panel over the time axis; abscissas of its curves are s. `unit` is that of the values, as people read it.
    pub fn over_time(title: impl Into<String>, unit: impl Into<String>) -> Self {
        Self::new(title, Axes::Time { unit: unit.into() })
    }

    /// A plane whose axes have the same scale. The labels are whole: "x in mm".
    pub fn plane(
        title: impl Into<String>,
        x_label: impl Into<String>,
        y_label: impl Into<String>,
    ) -> Self {
        let axes = Axes::Plane {
            x: x_label.into(),
            y: y_label.into(),
        };
        Self::new(title, axes)
    }

    fn new(title: impl Into<String>, axes: Axes) -> Self {
        Self {
            title: title.into(),
            axes,
            half_span_min: 0.0,
            curves: Vec::new(),
            levels: Vec::new(),
            circles: Vec::new(),
        }
    }

    /// The value axis spans at least twice this, so that noise about a constant does not fill it.
    #[must_use]
    pub fn half_span_min(mut self, half_span: f64) -> Self {
        self.half_span_min = half_span;
        self
    }

    /// Adds a curve; each has a colour of its own and stands in the legend.
    #[must_use]
    pub fn curve(mut self, curve: Curve) -> Self {
        self.curves.push(curve);
        self
    }

    /// Adds a horizontal dashed line with its name at the right end: a limit, a set point.
    #[must_use]
    pub fn level(mut self, name: impl Into<String>, value: f64) -> Self {
        self.levels.push((name.into(), value));
        self
    }

    /// Adds a circle to a plane. Panels over time show none.
    #[must_use]
    pub fn circle(mut self, circle: Circle) -> Self {
        self.circles.push(circle);
        self
    }

    fn is_plane(&self) -> bool {
        matches!(self.axes, Axes::Plane { .. })
    }
}

/// One curve, through its points in their order. Points that are not numbers leave a gap.
#[derive(Clone, Debug)]
pub struct Curve {
    name: String,
    points: Vec<(f64, f64)>,
    style: CurveStyle,
    color: Option<usize>,
}

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveStyle {
    /// A solid line.
    Solid,
    /// A dashed line: what was asked for beside what was done.
    Dashed,
    /// A dot at every point and no line.
    Dots,
}

impl Curve {
    /// A solid curve through points.
    pub fn new(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self {
            name: name.into(),
            points: points.into_iter().collect(),
            style: CurveStyle::Solid,
            color: None,
        }
    }

    /// Drawn like this.
    #[must_use]
    pub fn style(mut self, style: CurveStyle) -> Self {
        self.style = style;
        self
    }

    /// In the colour of the panel's curve of that number, from 0; otherwise that of its own place.
    #[must_use]
    pub fn color_of(mut self, number: usize) -> Self {
        self.color = Some(number);
        self
    }

    fn finite(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let all = self.points.iter().copied();
        all.filter(|(x, y)| x.is_finite() && y.is_finite())
    }
}

/// A circle in a plane, dashed, with its name beside it when it has one.
#[derive(Clone, Debug)]
pub struct Circle {
    /// Centre of the circle, in the units of the axes.
    pub center: (f64, f64),
    /// Radius of the circle, in the units of the axes.
    pub radius: f64,
    /// Name of the circle; may be empty.
    pub name: String,
}

/// A row of moments: vertical lines through all panels over time, their names above where there is room.
#[derive(Clone, Debug)]
pub struct Marks {
    name: String,
    dark: bool,
    at: Vec<(f64, String)>,
}

impl Marks {
    /// Dashed lines. `name` stands before the row and says what the marks are: "command".
    pub fn dashed(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            dark: false,
            at: Vec::new(),
        }
    }

    /// Dark solid lines.
    pub fn dark(name: impl Into<String>) -> Self {
        Self {
            dark: true,
            ..Self::dashed(name)
        }
    }

    /// Adds a mark at a time, s.
    #[must_use]
    pub fn at(mut self, time: f64, name: impl Into<String>) -> Self {
        self.push(time, name);
        self
    }

    /// Adds a mark at a time, s.
    pub fn push(&mut self, time: f64, name: impl Into<String>) {
        self.at.push((time, name.into()));
    }

    /// What the marks are.
    pub fn kind(&self) -> &str {
        &self.name
    }

    /// Number of the marks.
    pub fn len(&self) -> usize {
        self.at.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.at.is_empty()
    }
}

/// Smallest and largest value of every slot of time: no peak is lost, however many points there are.
#[derive(Clone, Debug)]
pub(crate) struct MinMaxBins {
    range: (f64, f64),
    /// Low and high end; nothing yet where the low end is above the high end.
    slots: Vec<(f64, f64)>,
}

impl MinMaxBins {
    pub(crate) fn new(range: (f64, f64)) -> Self {
        Self {
            range,
            slots: vec![(f64::INFINITY, f64::NEG_INFINITY); SLOTS],
        }
    }

    /// What is not a number cannot be drawn.
    pub(crate) fn add(&mut self, time: f64, value: f64) {
        if value.is_finite() && time.is_finite() {
            let share = (time - self.range.0) / self.width();
            let slot = ((share * SLOTS as f64) as usize).min(SLOTS - 1);
            let (low, high) = self.slots[slot];
            self.slots[slot] = (low.min(value), high.max(value));
        }
    }

    fn width(&self) -> f64 {
        (self.range.1 - self.range.0).max(f64::MIN_POSITIVE)
    }

    /// The curve through all extremes: in every slot from the smallest to the largest value, beginning with the one
    /// that is nearer to where the curve comes from.
    pub(crate) fn points(&self) -> Vec<(f64, f64)> {
        let mut points = Vec::with_capacity(2 * SLOTS);
        let mut latest = None;
        for (slot, &(low, high)) in self.slots.iter().enumerate() {
            if low > high {
                continue;
            }
            let time = self.range.0 + (slot as f64 + 0.5) / SLOTS as f64 * self.width();
            let from: f64 = latest.unwrap_or(low);
            let rising = (from - low).abs() <= (from - high).abs();
            let (first, second) = if rising { (low, high) } else { (high, low) };
            points.push((time, first));
            if low < high {
                points.push((time, second));
            }
            latest = Some(second);
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thinned_curve_passes_every_extreme_and_jumps_as_little_as_possible() {
        let mut slots = MinMaxBins::new((0.0, 1500.0));
        for (time, value) in [(0.5, 1.0), (1.2, -2.0), (1.5, 3.0), (2.1, -3.0), (2.5, 2.0)] {
            slots.add(time, value);
            slots.add(time, f64::NAN);
        }
        assert_eq!(
            slots.points(),
            [(0.5, 1.0), (1.5, 3.0), (1.5, -2.0), (2.5, -3.0), (2.5, 2.0)]
        );
    }

    fn mixed() -> Figure {
        let wave = |phase: f64| {
            (0..2000).map(move |i| (f64::from(i) * 1e-3, (f64::from(i) * 0.01 + phase).sin()))
        };
        let round = (0..=100).map(|i| {
            let (sin, cos) = (f64::from(i) * 0.0628).sin_cos();
            (300.0 + 50.0 * cos, 100.0 + 50.0 * sin)
        });
        Figure::new("Everything a figure can show")
            .note("2.00 s")
            .panel(
                PlotPanel::over_time("Joint speeds", "rad/s")
                    .curve(Curve::new("actual", wave(0.1)))
                    .curve(
                        Curve::new("target", wave(0.0))
                            .style(CurveStyle::Dashed)
                            .color_of(0),
                    )
                    .curve(Curve::new("sampled", wave(1.0).step_by(100)).style(CurveStyle::Dots))
                    .level("limit", 1.2),
            )
            .panel(PlotPanel::over_time("A gap", "N").curve(Curve::new(
                "Fx",
                wave(0.0).map(|(x, y)| (x, if y > 0.5 { f64::NAN } else { y })),
            )))
            .panel(
                PlotPanel::plane("TCP from above", "x in mm", "y in mm")
                    .curve(Curve::new("path", round))
                    .circle(Circle {
                        center: (350.0, 100.0),
                        radius: 20.0,
                        name: "blend zone".to_owned(),
                    }),
            )
            .marks(Marks::dark("line").at(0.0, "3").at(0.8, "4"))
            .marks(Marks::dashed("command").at(0.01, "movel").at(0.81, "movec"))
    }

    #[test]
    fn a_figure_is_as_high_as_its_panels_need() {
        let size = |figure: &Figure| {
            let picture = tiny_skia::Pixmap::decode_png(&figure.to_png().unwrap()).unwrap();
            (picture.width(), picture.height())
        };
        if let Some(path) = std::env::var_os("ELITE_PLOT_EXAMPLE") {
            mixed().save(Path::new(&path)).unwrap();
        }
        let (width, height) = size(&mixed());
        assert_eq!(width, 1600);
        let more = mixed().panel(PlotPanel::over_time("Below", "V"));
        let (_, taller) = size(&more);
        assert!(height < taller, "{height} {taller}");
        assert_eq!(size(&mixed().size(800, 700)), (800, 700));
    }

    #[test]
    fn curves_without_numbers_and_figures_without_panels_are_drawn_empty() {
        for points in [
            vec![],
            vec![(f64::NAN, 1.0), (f64::INFINITY, f64::INFINITY)],
            vec![(0.0, 0.0)],
        ] {
            let curve = || Curve::new("x", points.clone());
            let figure = Figure::new("")
                .panel(
                    PlotPanel::over_time("t", "")
                        .curve(curve())
                        .level("nowhere", f64::NAN),
                )
                .panel(
                    PlotPanel::plane("p", "x", "y")
                        .curve(curve())
                        .circle(Circle {
                            center: (f64::NAN, 0.0),
                            radius: 1.0,
                            name: String::new(),
                        }),
                )
                .marks(Marks::dark("m").at(f64::NAN, "n"));
            figure.to_png().unwrap();
        }
        Figure::new("nothing").to_png().unwrap();
        assert!(Figure::new("").size(0, 0).to_png().is_err());
    }
}
