//! `replay --plot OUT.png`: the run as a picture.
//!
//! Owns what is shown of a recording; how it is drawn is [`crate::plot`]'s business. Time is cut into as many slots as
//! the picture has columns, so that a recording of any length is read in bounded memory and no peak is lost.

use std::path::Path;

use messages::Localized;
use recorder::lengths::truncate_marked;
use recorder::{CycleMessage, ReadError, Recording, RecordingEntry, Topic};
use thiserror::Error;

use crate::plot::{Curve, Figure, Marks, MinMaxBins, PlotError, PlotPanel};

/// Width and height of the picture, pixels.
const SIZE: (u32, u32) = (1600, 1500);
/// Marks of a kind; more would hide the curves, so that none are drawn then.
const MAX_MARKS: usize = 120;
/// Longest time that is drawn, s: a hundred years.
const MAX_SPAN: f64 = 3.2e9;
/// Bytes of a mark's name.
const MAX_NAME: usize = 80;

/// A reason why there is no picture of a recording.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum PictureError {
    /// The recording cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// Nothing to draw.
    #[error("there is nothing to draw: the recording has no cycles")]
    #[zh("没有可画的内容：记录中没有周期")]
    Empty,
    /// The times are none that a controller has.
    #[error(
        "there is nothing to draw from {begin:e} s to {end:e} s; time goes forward, for a hundred years at most"
    )]
    #[zh("{begin:e} s 到 {end:e} s 没有可画的内容；时间只向前，最多一百年")]
    Times {
        /// Begin of the first cycle, s.
        begin: f64,
        /// End of the last one, s.
        end: f64,
    },
    /// There are no cycles between the times asked for.
    #[error(
        "there is nothing to draw from {from} s to {to} s: the recording covers {begin:.3} s to {end:.3} s"
    )]
    #[zh("{from} s 到 {to} s 没有可画的内容：记录的范围是 {begin:.3} s 到 {end:.3} s")]
    Nothing {
        /// Begin of the span, s.
        from: f64,
        /// End of the span, s.
        to: f64,
        /// Begin of the recording, s.
        begin: f64,
        /// End of the recording, s.
        end: f64,
    },
    /// The picture cannot be made or written.
    #[error(transparent)]
    Plot(#[from] PlotError),
}

/// Draws the recording, or the span of it from one time to another, into a PNG file.
///
/// # Errors
/// [`PictureError`].
pub(super) fn plot(
    recording: &Recording,
    path: &Path,
    span: (Option<f64>, Option<f64>),
) -> Result<(), PictureError> {
    Ok(figure(recording, span)?.save(path)?)
}

/// Draws the recording into a PNG in memory.
///
/// # Errors
/// [`PictureError`].
pub(super) fn png(recording: &Recording) -> Result<Vec<u8>, PictureError> {
    Ok(figure(recording, (None, None))?.to_png()?)
}

/// Whether a command moves the arm along a path or at a speed.
fn is_motion(command: &str) -> bool {
    ["move", "servo", "speed", "track_conveyor", "freedrive"]
        .iter()
        .any(|word| command.starts_with(word))
}

const JOINTS: &[&str] = &["J1", "J2", "J3", "J4", "J5", "J6"];
const AXES: &[&str] = &["Fx", "Fy", "Fz"];

/// What a panel shows.
struct Content {
    title: &'static str,
    unit: &'static str,
    half_span_min: f64,
    names: &'static [&'static str],
    values: fn(&CycleMessage) -> &[f64],
}

/// The panels from top to bottom.
const PANELS: [Content; 5] = [
    Content {
        title: "Joint positions, actual",
        unit: "rad",
        half_span_min: 0.1,
        names: JOINTS,
        values: |cycle| &cycle.actual_q,
    },
    Content {
        title: "Joint speeds, actual",
        unit: "rad/s",
        half_span_min: 0.1,
        names: JOINTS,
        values: |cycle| &cycle.actual_qd,
    },
    Content {
        title: "Joint accelerations, target",
        unit: "rad/s²",
        half_span_min: 1.0,
        names: JOINTS,
        values: |cycle| &cycle.target_qdd,
    },
    Content {
        title: "Joint torques, actual",
        unit: "Nm",
        half_span_min: 1.0,
        names: JOINTS,
        values: |cycle| &cycle.actual_torque,
    },
    Content {
        title: "Force on the tool, TCP frame",
        unit: "N",
        half_span_min: 5.0,
        names: AXES,
        values: |cycle| &cycle.tcp_force,
    },
];

fn figure(
    recording: &Recording,
    (from, to): (Option<f64>, Option<f64>),
) -> Result<Figure, PictureError> {
    let (begin, end) = time_range(recording)?;
    let range = (from.unwrap_or(begin).max(begin), to.unwrap_or(end).min(end));
    if range.0.total_cmp(&range.1).is_ge() {
        return Err(PictureError::Nothing {
            from: from.unwrap_or(begin),
            to: to.unwrap_or(end),
            begin,
            end,
        });
    }
    let mut slots: Vec<Vec<MinMaxBins>> = PANELS
        .iter()
        .map(|panel| vec![MinMaxBins::new(range); panel.names.len()])
        .collect();
    let mut lines = Marks::dark("line");
    let mut motions = Marks::dark("motion");
    let mut commands = Marks::dashed("command");
    let mark = |marks: &mut Marks, time: f64, name: String| {
        let is_shown = (range.0..=range.1).contains(&time);
        // One more than are drawn: it says that there are too many.
        if is_shown && marks.len() <= MAX_MARKS {
            marks.push(time, truncate_marked(&name, MAX_NAME).unwrap_or(name));
        }
    };
    for entry in recording.entries(&[Topic::Cycle, Topic::Command, Topic::Script])? {
        match entry? {
            (_, RecordingEntry::Cycle(cycle)) if (range.0..=range.1).contains(&cycle.time) => {
                for (panel, curves) in PANELS.iter().zip(&mut slots) {
                    for (value, curve) in (panel.values)(&cycle).iter().zip(curves) {
                        curve.add(cycle.time, *value);
                    }
                }
            }
            (time, RecordingEntry::Command(command)) => match is_motion(&command.name) {
                true => mark(&mut motions, time, command.name),
                false => mark(&mut commands, time, command.name),
            },
            // The main thread's line; those of other threads would cross it.
            (time, RecordingEntry::Script(script)) if script.thread == Some(0) => {
                if let Some(line) = script.line {
                    mark(&mut lines, time, line.to_string());
                }
            }
            _ => {}
        }
    }
    let rows = [lines, motions, commands];
    let unmarked: Vec<&str> = rows
        .iter()
        .filter(|row| row.len() > MAX_MARKS)
        .map(Marks::kind)
        .collect();
    let mut note = format!("{:.2} s", range.1 - range.0);
    if !unmarked.is_empty() {
        note += &format!(
            ", too many to be marked: {}; --from and --to show a part",
            unmarked.join(", ")
        );
    }
    let figure = Figure::new(title(recording))
        .note(note)
        .size(SIZE.0, SIZE.1)
        .time_range(range.0, range.1);
    let drawn = rows.into_iter().filter(|row| row.len() <= MAX_MARKS);
    let figure = drawn.fold(figure, Figure::marks);
    Ok(PANELS
        .iter()
        .zip(slots)
        .fold(figure, |figure, (content, slots)| {
            let panel = PlotPanel::over_time(content.title, content.unit)
                .half_span_min(content.half_span_min);
            let curves = content.names.iter().zip(slots);
            figure.panel(curves.fold(panel, |panel, (name, slots)| {
                panel.curve(Curve::new(*name, slots.points()))
            }))
        }))
}

/// Begin of the first and end of the last cycle, s.
fn time_range(recording: &Recording) -> Result<(f64, f64), PictureError> {
    let mut range: Option<(f64, f64)> = None;
    for cycle in recording.cycles()? {
        let cycle = cycle?;
        let begin = range.map_or(cycle.time - cycle.step_time, |(begin, _)| begin);
        range = Some((begin, cycle.time));
    }
    let (begin, end) = range.ok_or(PictureError::Empty)?;
    // A file may say anything; `contains` is false for what is no number.
    match (0.0..=MAX_SPAN).contains(&(end - begin)) && begin.abs() <= MAX_SPAN {
        true => Ok((begin, end)),
        false => Err(PictureError::Times { begin, end }),
    }
}

fn title(recording: &Recording) -> String {
    let path = std::path::Path::new(recording.name());
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    match recording.setup() {
        Some(setup) => format!("{file}   {}, {} plant", setup.arm(), setup.plant),
        None => file.into_owned(),
    }
}
