//! The curves of a recording, thinned to what a picture can show.
//!
//! Time is cut into as many slots as the picture has columns; of every slot the smallest and the largest value are
//! kept, so that no peak is lost, however long the recording is.

use recorder::{Cycle, Entry, Recording, Topic};

use super::PlotError;

/// Slots of time: a little more than the columns of the picture.
const SLOTS: usize = 1500;
/// Marked commands; more would hide the curves.
const MAX_MARKS: usize = 400;

/// Everything that is drawn.
pub(super) struct Curves {
    /// File, arm and such.
    pub title: String,
    /// First and last time, s.
    pub range: (f64, f64),
    pub panels: Vec<Panel>,
    /// When commands began (s), and their names.
    pub marks: Vec<(f64, String)>,
    /// Commands that are not marked.
    pub unmarked: usize,
}

/// Curves on one pair of axes.
pub(super) struct Panel {
    pub title: &'static str,
    pub unit: &'static str,
    /// The axis spans at least twice this, so that noise about a constant does not fill it.
    pub half_span_min: f64,
    pub curves: Vec<Curve>,
}

/// One curve: for every slot with data its middle (s), smallest and largest value.
pub(super) struct Curve {
    pub name: &'static str,
    pub points: Vec<(f64, f64, f64)>,
}

const JOINTS: &[&str] = &["J1", "J2", "J3", "J4", "J5", "J6"];
const AXES: &[&str] = &["Fx", "Fy", "Fz"];

/// What a panel shows.
struct Content {
    title: &'static str,
    unit: &'static str,
    half_span_min: f64,
    names: &'static [&'static str],
    values: fn(&Cycle) -> &[f64],
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

pub(super) fn read(recording: &Recording) -> Result<Curves, PlotError> {
    let range = time_range(recording)?;
    let mut slots: Vec<Vec<Vec<Slot>>> = PANELS
        .iter()
        .map(|panel| vec![vec![Slot::EMPTY; SLOTS]; panel.names.len()])
        .collect();
    let mut marks = Vec::new();
    let mut unmarked = 0;
    let width = (range.1 - range.0).max(f64::MIN_POSITIVE);
    for entry in recording.entries(&[Topic::Cycle, Topic::Command])? {
        match entry? {
            (_, Entry::Cycle(cycle)) => {
                let share = (cycle.time - range.0) / width;
                let slot = ((share * SLOTS as f64) as usize).min(SLOTS - 1);
                for (panel, curves) in PANELS.iter().zip(&mut slots) {
                    for (value, curve) in (panel.values)(&cycle).iter().zip(curves) {
                        curve[slot].add(*value);
                    }
                }
            }
            (time, Entry::Command(command)) => {
                if marks.len() < MAX_MARKS {
                    marks.push((time, command.name));
                } else {
                    unmarked += 1;
                }
            }
            _ => {}
        }
    }
    let middle = |slot: usize| range.0 + (slot as f64 + 0.5) / SLOTS as f64 * width;
    let panels = PANELS.iter().zip(slots).map(|(panel, slots)| {
        let curves = panel.names.iter().zip(slots).map(|(name, slots)| Curve {
            name,
            points: slots
                .into_iter()
                .enumerate()
                .filter(|(_, slot)| slot.low <= slot.high)
                .map(|(index, slot)| (middle(index), slot.low, slot.high))
                .collect(),
        });
        Panel {
            title: panel.title,
            unit: panel.unit,
            half_span_min: panel.half_span_min,
            curves: curves.collect(),
        }
    });
    Ok(Curves {
        title: title(recording),
        range,
        panels: panels.collect(),
        marks,
        unmarked,
    })
}

/// Begin of the first and end of the last cycle, s.
fn time_range(recording: &Recording) -> Result<(f64, f64), PlotError> {
    let mut range: Option<(f64, f64)> = None;
    for cycle in recording.cycles()? {
        let cycle = cycle?;
        let begin = range.map_or(cycle.time - cycle.step_time, |(begin, _)| begin);
        range = Some((begin, cycle.time));
    }
    range
        .filter(|(begin, end)| begin.is_finite() && end.is_finite() && begin <= end)
        .ok_or(PlotError::Empty)
}

fn title(recording: &Recording) -> String {
    let path = std::path::Path::new(recording.name());
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    match recording.setup() {
        Some(setup) => format!("{file}   {}, {} plant", setup.model, setup.plant),
        None => file.into_owned(),
    }
}

#[derive(Clone, Copy)]
struct Slot {
    low: f64,
    high: f64,
}

impl Slot {
    /// Nothing yet: the low end is above the high end.
    const EMPTY: Self = Self {
        low: f64::INFINITY,
        high: f64::NEG_INFINITY,
    };

    /// A recording may hold anything; what is not a number cannot be drawn.
    fn add(&mut self, value: f64) {
        if value.is_finite() {
            self.low = self.low.min(value);
            self.high = self.high.max(value);
        }
    }
}
