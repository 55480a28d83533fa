//! For people at a terminal: a line a test, then what failed and how to run it again, then the sum.

use std::fmt::Write as _;
use std::time::Duration;

use super::{plain, repeat_command};
use crate::runner::{Status, TestResult};

/// Tests that are told as the slowest, and from what on.
const SLOWEST: usize = 3;
const SLOW: Duration = Duration::from_secs(1);
/// Lines of what a failed test printed.
const PRINTS_MAX: usize = 20;

/// The line of a test that has ended; `name_width` is that of the longest name.
pub fn line(result: &TestResult, name_width: usize) -> String {
    let word = match result.status {
        Status::Passed => "passed",
        Status::Failed => "FAILED",
        Status::Error => "ERROR ",
    };
    format!(
        "{word}  {:name_width$}  {:>9} simulated in {:>8}  {}\n",
        result.case.name,
        time(result.time),
        time(result.wall.as_secs_f64()),
        result.case.file.path.display(),
    )
}

/// What failed, the slowest, and the sum. `wall` is the time of all.
pub fn summary(results: &[TestResult], wall: Duration) -> String {
    let mut out = String::new();
    let failed = results.iter().filter(|r| r.status != Status::Passed);
    for result in failed.clone() {
        failure(result, &mut out);
    }
    let mut slow: Vec<&TestResult> = results.iter().filter(|r| r.wall >= SLOW).collect();
    slow.sort_by_key(|result| std::cmp::Reverse(result.wall));
    if !slow.is_empty() {
        let slow = slow.iter().take(SLOWEST);
        let slow = slow.map(|r| format!("{} {}", r.case.name, time(r.wall.as_secs_f64())));
        let _ = writeln!(out, "slowest: {}", slow.collect::<Vec<_>>().join(", "));
    }
    let count = |status| results.iter().filter(|r| r.status == status).count();
    let (passed, failures, errors) = (
        count(Status::Passed),
        count(Status::Failed),
        count(Status::Error),
    );
    let simulated: f64 = results.iter().map(|r| r.time).sum();
    let _ = write!(out, "{passed} passed");
    if failures > 0 {
        let _ = write!(out, ", {failures} failed");
    }
    if errors > 0 {
        let _ = write!(out, ", {errors} could not be run");
    }
    let _ = writeln!(
        out,
        "; {} simulated in {}",
        time(simulated),
        time(wall.as_secs_f64())
    );
    out
}

fn failure(result: &TestResult, out: &mut String) {
    let path = result.case.file.path.display();
    let _ = writeln!(out, "\n{path}:{}: {}", result.line, result.case.name);
    for line in plain(&result.report).lines() {
        let _ = writeln!(out, "  {line}");
    }
    if !result.prints.is_empty() {
        let _ = writeln!(out, "  printed:");
        let hidden = result.prints.len().saturating_sub(PRINTS_MAX);
        if hidden > 0 {
            let _ = writeln!(out, "    … {hidden} lines before");
        }
        for line in result.prints.iter().skip(hidden) {
            let _ = writeln!(out, "    {}", plain(line));
        }
    }
    if let Some(recording) = &result.recording {
        let _ = writeln!(out, "  recording: {}", recording.display());
    }
    let _ = writeln!(out, "  again: {}\n", repeat_command(result));
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
