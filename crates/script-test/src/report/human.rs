//! For people at a terminal: a line a test, then what failed and how to run it again, then the sum. In which language
//! is the caller's to say: the texts are English, and a [`Wording`] puts them into another one.

use std::fmt::Write as _;
use std::time::Duration;

use super::{plain, repeat_command};
use crate::runner::{Status, TestResult};

/// Tests that are told as the slowest, and from what on.
const SLOWEST: usize = 3;
const SLOW: Duration = Duration::from_secs(1);
/// Lines of what a failed test printed.
const PRINTS_MAX: usize = 20;

/// What the report is put into another language with. What programs print stays as it is.
#[derive(Clone, Copy, Debug)]
pub struct Wording {
    /// The words for a test that passed, failed, could not be run; equally wide.
    pub statuses: [&'static str; 3],
    /// A line of this report, without its end.
    pub line: fn(&str) -> String,
    /// What a program or a test reported, several lines.
    pub report: fn(&str) -> String,
}

/// The report in English.
pub const ENGLISH: Wording = Wording {
    statuses: ["passed", "FAILED", "ERROR "],
    line: str::to_owned,
    report: str::to_owned,
};

/// The line of a test that has ended; `name_width` is that of the longest name.
pub fn line(result: &TestResult, name_width: usize, wording: &Wording) -> String {
    let [passed, failed, error] = wording.statuses;
    let word = match result.status {
        Status::Passed => passed,
        Status::Failed => failed,
        Status::Error => error,
    };
    let times = format!(
        "{:>9} simulated in {:>8}",
        time(result.time),
        time(result.wall.as_secs_f64())
    );
    format!(
        "{word}  {:name_width$}  {}  {}\n",
        result.case.name,
        (wording.line)(&times),
        result.case.file.path.display(),
    )
}

/// What failed, the slowest, and the sum. `wall` is the time of all.
pub fn summary(results: &[TestResult], wall: Duration, wording: &Wording) -> String {
    let mut out = String::new();
    let failed = results.iter().filter(|r| r.status != Status::Passed);
    for result in failed.clone() {
        failure(result, wording, &mut out);
    }
    let mut slow: Vec<&TestResult> = results.iter().filter(|r| r.wall >= SLOW).collect();
    slow.sort_by_key(|result| std::cmp::Reverse(result.wall));
    if !slow.is_empty() {
        let slow = slow.iter().take(SLOWEST);
        let slow = slow.map(|r| format!("{} {}", r.case.name, time(r.wall.as_secs_f64())));
        let slow = format!("slowest: {}", slow.collect::<Vec<_>>().join(", "));
        let _ = writeln!(out, "{}", (wording.line)(&slow));
    }
    let count = |status| results.iter().filter(|r| r.status == status).count();
    let (passed, failures, errors) = (
        count(Status::Passed),
        count(Status::Failed),
        count(Status::Error),
    );
    let simulated: f64 = results.iter().map(|r| r.time).sum();
    let (simulated, wall) = (time(simulated), time(wall.as_secs_f64()));
    let sum = match (failures, errors) {
        (0, 0) => format!("{passed} passed; {simulated} simulated in {wall}"),
        (_, 0) => format!("{passed} passed, {failures} failed; {simulated} simulated in {wall}"),
        (0, _) => {
            format!("{passed} passed, {errors} could not be run; {simulated} simulated in {wall}")
        }
        _ => format!(
            "{passed} passed, {failures} failed, {errors} could not be run; {simulated} simulated in {wall}"
        ),
    };
    let _ = writeln!(out, "{}", (wording.line)(&sum));
    out
}

fn failure(result: &TestResult, wording: &Wording, out: &mut String) {
    let told = wording.line;
    let path = result.case.file.path.display();
    let _ = writeln!(out, "\n{path}:{}: {}", result.line, result.case.name);
    for line in (wording.report)(&plain(&result.report)).lines() {
        let _ = writeln!(out, "  {line}");
    }
    if !result.prints.is_empty() {
        let _ = writeln!(out, "{}", told("  printed:"));
        let hidden = result.prints.len().saturating_sub(PRINTS_MAX);
        if hidden > 0 {
            let _ = writeln!(out, "{}", told(&format!("    … {hidden} lines before")));
        }
        for line in result.prints.iter().skip(hidden) {
            let _ = writeln!(out, "    {}", plain(line));
        }
    }
    if let Some(recording) = &result.recording {
        let text = format!("  recording: {}", recording.display());
        let _ = writeln!(out, "{}", told(&text));
    }
    let again = format!("  again: {}", repeat_command(result));
    let _ = writeln!(out, "{}\n", told(&again));
}

/// A time in few characters.
fn time(seconds: f64) -> String {
    match seconds {
        s if s < 1e-3 => format!("{:.0} µs", s * 1e6),
        s if s < 1.0 => format!("{:.0} ms", s * 1e3),
        s if s < 100.0 => format!("{s:.2} s"),
        s => format!("{s:.0} s"),
    }
}
