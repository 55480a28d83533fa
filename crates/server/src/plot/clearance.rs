//! The least distance of a program over time as a picture.

use std::path::Path;

use controller::clearance::ClearanceRun;

use super::{Curve, Figure, Marks, PlotError, PlotPanel};

/// Width and height of the picture, pixels.
const SIZE: (u32, u32) = (1400, 600);
/// Marks of motions; more would hide the curve.
const MARKS_MAX: usize = 60;

/// Draws the distance of every cycle, the margin, and the nearest place of each motion.
///
/// # Errors
/// [`PlotError`]
pub fn draw(path: &Path, run: &ClearanceRun, margin: f64) -> Result<(), PlotError> {
    let points = run.history.iter();
    let points = points.map(|(time, distance)| (*time, distance * 1e3));
    let mut panel = PlotPanel::over_time("least distance", "mm")
        .curve(Curve::new("distance", points))
        .level("contact", 0.0);
    if margin > 0.0 {
        panel = panel.level("margin", margin * 1e3);
    }
    let mut marks = Marks::dashed("nearest place of each motion");
    if run.rows.len() <= MARKS_MAX {
        for row in &run.rows {
            if let Some(least) = &row.least {
                let name = format!("line {}: {} and {}", row.line, least.a, least.b);
                marks.push(least.time, name);
            }
        }
    }
    Figure::new("Clearance")
        .size(SIZE.0, SIZE.1)
        .panel(panel)
        .marks(marks)
        .save(path)
}
