//! `eliteserver compare`: two recordings, laid over each other in time, and how far they are apart.
//!
//! Owns what a person and a program read of it; the alignment and the figures are `robot-client`'s.

mod bag;
mod run_here;

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use messages::{Language, Localized, Text, text};
use recorder::{ReadError, Recording};
use robot_client::compare::{
    Alignment, Comparison, Deviation, RunTrace, RunTraceError, align, compare as compared,
    differences,
};
use serde_json::json;
use thiserror::Error;

use crate::cli::{CompareArgs, CompareFormat};
use crate::command::{CommandResult, CommandStatus};
use crate::language::{self, columns_of, padded};
use crate::plot::{Curve, CurveStyle, Figure, PlotError, PlotPanel};
use crate::ports::escape::EscapedText;
use bag::{BagReadError, read_bag};
use run_here::{RunHereError, run_here};

/// Points of a curve at most: twice the columns of the picture.
const CURVE_POINTS: usize = 3200;

const JOINTS: [&str; 6] = ["J1", "J2", "J3", "J4", "J5", "J6"];

/// A reason why there is no comparison, told in a sentence.
#[derive(Debug, Error, Localized)]
enum CompareError {
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error(transparent)]
    Track(#[from] RunTraceError),
    #[error(transparent)]
    Plot(#[from] PlotError),
    #[error(transparent)]
    Bag(#[from] BagReadError),
    #[error(transparent)]
    RunHere(#[from] RunHereError),
    #[error("the two recordings have no moment in common in which both know where the joints are")]
    #[zh("两个记录没有共同的、都知道关节位置的时刻")]
    NothingInCommon,
}

/// Exit status: 0 within the bound, or no bound; 1 beyond; 2 unreadable.
pub fn compare(args: &CompareArgs) -> CommandResult {
    Ok(run_compare(args)?)
}

fn run_compare(args: &CompareArgs) -> Result<CommandStatus, CompareError> {
    let (first, recording) = read_side(&args.first)?;
    let ran = match &args.run {
        Some(script) => {
            let recording =
                recording.ok_or_else(|| BagReadError::NoArm(args.first.display().to_string()))?;
            let setup = recording
                .setup()
                .ok_or_else(|| RunHereError::NoSetup(recording.name().to_owned()))?;
            let run = run_here(setup, script, args.keep.as_deref())?;
            Some((script.clone(), run))
        }
        None => None,
    };
    let (second, second_name) = match (&ran, &args.second) {
        (Some((script, run)), _) => {
            let name = text!("{} run here", "在此运行的 {}", script.display());
            (RunTrace::read(&Recording::open(&run.path)?)?, name)
        }
        (None, Some(path)) => {
            let name = Text::verbatim(path.display().to_string());
            (read_side(path)?.0, name)
        }
        // The command line has one of the two.
        (None, None) => return Err(CompareError::NothingInCommon),
    };
    let names = RecordingNames {
        first: args.first.display().to_string(),
        second: second_name,
    };
    let alignment = align(&first, &second);
    let comparison = compared(&first, &second, alignment);
    let largest = comparison
        .largest_joint()
        .ok_or(CompareError::NothingInCommon)?;
    let text = match args.format {
        CompareFormat::Human => to_text(&names, &comparison, language::chosen()),
        CompareFormat::Json => to_json(&names, args.within, &comparison),
    };
    // Whoever reads may have seen enough; the status still tells.
    let _ = std::io::stdout().write_all(text.as_bytes());
    if let Some(path) = &args.plot {
        figure(&names, &first, &second, alignment).save(path)?;
    }
    match args.within {
        Some(within) if largest > within => {
            language::say(&text!(
                "the joints are up to {largest:.6} rad apart, {within} rad are allowed",
                "关节最多相差 {largest:.6} rad，允许 {within} rad"
            ));
            Ok(CommandStatus::Negative)
        }
        _ => Ok(CommandStatus::Success),
    }
}

/// A side of the comparison, and the recording it was read from, if it is no bag.
fn read_side(path: &Path) -> Result<(RunTrace, Option<Recording>), CompareError> {
    if path.is_dir() {
        return Ok((read_bag(path)?, None));
    }
    match Recording::open(path) {
        Ok(recording) => Ok((RunTrace::read(&recording)?, Some(recording))),
        // Another MCAP file: a bag's.
        Err(other @ ReadError::NotARecording { .. }) => match read_bag(path) {
            Ok(trace) => Ok((trace, None)),
            Err(BagReadError::NoJointStates { .. }) => Err(other.into()),
            Err(error) => Err(error.into()),
        },
        Err(error) => Err(error.into()),
    }
}

/// What the two are called.
struct RecordingNames {
    first: String,
    second: Text,
}

/// The quantities with the factor and the unit in which people read them.
fn rows(comparison: &Comparison) -> Vec<(Text, Option<Deviation>, f64, &'static str)> {
    let joints = comparison.joints.iter().zip(1..);
    let mut rows: Vec<_> = joints
        .map(|(joint, number)| (text!("joint {number}", "关节 {number}"), *joint, 1.0, "rad"))
        .collect();
    rows.push((
        text!("TCP position", "TCP 位置"),
        comparison.tcp_position,
        1e3,
        "mm",
    ));
    rows.push((
        text!("TCP rotation", "TCP 姿态"),
        comparison.tcp_rotation,
        1.0,
        "rad",
    ));
    rows.push((
        text!("TCP speed", "TCP 速度"),
        comparison.tcp_speed,
        1e3,
        "mm/s",
    ));
    rows.push((text!("force", "力"), comparison.force, 1.0, "N"));
    rows
}

fn to_text(names: &RecordingNames, comparison: &Comparison, language: Language) -> String {
    let mut out = String::new();
    let mut say = |line: Text| {
        // Writing into a text cannot fail.
        let _ = writeln!(out, "{}", line.in_language(language));
    };
    let (begin, end) = comparison.overlap;
    let Alignment {
        shift,
        first_motion,
        second_motion,
    } = comparison.alignment;
    let motion = |motion: Option<f64>| match motion {
        Some(at) => text!("moves from {at:.3} s", "从 {at:.3} s 起运动"),
        None => text!("never moves", "从不运动"),
    };
    let (first, second) = (&names.first, names.second.in_language(language));
    for (letter, name, motion) in [
        ("A", first.as_str(), motion(first_motion)),
        ("B", second, motion(second_motion)),
    ] {
        let name = EscapedText(name);
        say(text!(
            "{letter}: {name} {motion}",
            "{letter}：{name} {motion}"
        ));
    }
    // No minus before nothing.
    let shift = (shift * 1e4).round() / 1e4 + 0.0;
    say(text!(
        "shift: {shift:.4} s (what A does at t, B does at t + shift)",
        "时移：{shift:.4} s（A 在 t 时所做的，B 在 t + 时移 时做）"
    ));
    say(text!(
        "compared: {begin:.3} s to {end:.3} s of A",
        "比较范围：A 的 {begin:.3} s 到 {end:.3} s"
    ));
    let right = |text: Text| {
        let text = text.in_language(language);
        let blanks = 12_usize.saturating_sub(columns_of(text));
        format!("{:blanks$}{text}", "")
    };
    let heads = [text!("rms", "均方根"), text!("largest", "最大")].map(right);
    let at = language.pick("at", "时刻");
    let _ = writeln!(out, "{:14} {} {}        {at}", "", heads[0], heads[1]);
    for (name, deviation, factor, unit) in rows(comparison) {
        let name = padded(name.in_language(language), 14);
        let _ = match deviation {
            Some(found) => writeln!(
                out,
                "{name} {:12.6} {:12.6} {unit:5} {:9.3} s",
                found.rms * factor,
                found.largest * factor,
                found.at
            ),
            None => writeln!(out, "{name} {}", right(text!("not known", "未知"))),
        };
    }
    out
}

fn to_json(names: &RecordingNames, within: Option<f64>, comparison: &Comparison) -> String {
    let shown = |deviation: &Option<Deviation>| match deviation {
        Some(found) => json!({
            "rms": found.rms,
            "largest": found.largest,
            "at": found.at,
            "samples": found.samples,
        }),
        None => serde_json::Value::Null,
    };
    let object = json!({
        "first": names.first,
        "second": names.second,
        "shift": comparison.alignment.shift,
        "first_motion": [comparison.alignment.first_motion, comparison.alignment.second_motion],
        "overlap": [comparison.overlap.0, comparison.overlap.1],
        "joints": comparison.joints.iter().map(shown).collect::<Vec<_>>(),
        "tcp_position": shown(&comparison.tcp_position),
        "tcp_rotation": shown(&comparison.tcp_rotation),
        "tcp_speed": shown(&comparison.tcp_speed),
        "force": shown(&comparison.force),
        "within": within.zip(comparison.largest_joint()).map(|(bound, found)| found <= bound),
    });
    format!("{object}\n")
}

/// Both runs over each other, and what is between them.
fn figure(
    names: &RecordingNames,
    first: &RunTrace,
    second: &RunTrace,
    alignment: Alignment,
) -> Figure {
    let shift = alignment.shift;
    let every = |count: usize| count.div_ceil(CURVE_POINTS).max(1);
    let positions = |track: &RunTrace, joint: usize, shift: f64| -> Vec<(f64, f64)> {
        let samples = track.samples();
        let every = every(samples.len());
        let points = samples.map(|sample| (sample.time - shift, sample.q[joint]));
        points.step_by(every).collect()
    };
    let mut overlay = PlotPanel::over_time("Joint positions: A solid, B dashed", "rad");
    for (joint, name) in JOINTS.iter().enumerate() {
        overlay = overlay.curve(Curve::new(*name, positions(first, joint, 0.0)).color_of(joint));
    }
    for (joint, name) in JOINTS.iter().enumerate() {
        let name = format!("{name} of B");
        let curve = Curve::new(name, positions(second, joint, shift));
        overlay = overlay.curve(curve.style(CurveStyle::Dashed).color_of(joint));
    }
    let all: Vec<_> = differences(first, second, alignment).collect();
    // The largest of each stretch, so that no peak is lost.
    let peaks = |value: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
        let stretch = every(all.len());
        let starts = (0..all.len()).step_by(stretch);
        let peak = starts.filter_map(|start| {
            let stretch = start..(start + stretch).min(all.len());
            let largest = stretch.max_by(|a, b| value(*a).abs().total_cmp(&value(*b).abs()))?;
            Some((all[largest].time, value(largest)))
        });
        peak.collect()
    };
    let mut apart = PlotPanel::over_time("Joints, B minus A", "rad");
    for (joint, name) in JOINTS.iter().enumerate() {
        apart = apart.curve(Curve::new(*name, peaks(&|i| all[i].joints[joint])));
    }
    let tcp = PlotPanel::over_time("TCP, distance", "mm").curve(Curve::new(
        "position",
        peaks(&|i| all[i].tcp_position * 1e3),
    ));
    let speed = PlotPanel::over_time("TCP speed, B minus A", "mm/s")
        .curve(Curve::new("speed", peaks(&|i| all[i].tcp_speed * 1e3)));
    let force = PlotPanel::over_time("Force, length of the difference", "N")
        .half_span_min(1.0)
        .curve(Curve::new("force", peaks(&|i| all[i].force)));
    let name = |given: &str| {
        let file = Path::new(given).file_name().unwrap_or_default();
        file.to_string_lossy().into_owned()
    };
    let title = format!(
        "A {}   B {}",
        name(&names.first),
        name(names.second.english())
    );
    Figure::new(title)
        .note(format!("shift {shift:.4} s"))
        .panel(overlay)
        .panel(apart)
        .panel(tcp)
        .panel(speed)
        .panel(force)
}
