//! For people at a terminal, in their language: a line a test, then what failed and how to run it again, then the sum.

use std::fmt::Write as _;
use std::time::Duration;

use messages::{Language, Text, text};

use super::{plain, repeat_command};
use crate::runner::{Status, TestResult};

/// Tests that are told as the slowest, and from what on.
const SLOWEST: usize = 3;
const SLOW: Duration = Duration::from_secs(1);
/// Columns of a simulated time.
const TIME_COLUMNS: usize = 9;
/// Lines of what a failed test printed.
const PRINTS_MAX: usize = 20;

/// The line of a test that has ended; `name_width` is that of the longest name.
pub fn line(result: &TestResult, name_width: usize, language: Language) -> String {
    // Equally wide in each language.
    let word = match result.status {
        Status::Passed => language.pick("passed", "通过"),
        Status::Failed => language.pick("FAILED", "失败"),
        Status::Error => language.pick("ERROR ", "错误"),
    };
    let (simulated, wall) = (time(result.time), time(result.wall.as_secs_f64()));
    let blanks = " ".repeat(TIME_COLUMNS.saturating_sub(simulated.chars().count()));
    let times = text!(
        "{blanks}{simulated} simulated in {wall:>8}",
        "{blanks}仿真 {simulated}，用时 {wall:>8}"
    );
    format!(
        "{word}  {:name_width$}  {}  {}\n",
        result.case.name,
        times.in_language(language),
        result.case.file.path.display(),
    )
}

/// What failed, the slowest, and the sum. `wall` is the time of all.
pub fn summary(results: &[TestResult], wall: Duration, language: Language) -> String {
    let mut out = String::new();
    let failed = results.iter().filter(|r| r.status != Status::Passed);
    for result in failed {
        failure(result, language, &mut out);
    }
    let mut slow: Vec<&TestResult> = results.iter().filter(|r| r.wall >= SLOW).collect();
    slow.sort_by_key(|result| std::cmp::Reverse(result.wall));
    if !slow.is_empty() {
        let slow = slow.iter().take(SLOWEST);
        let slow = slow.map(|r| format!("{} {}", r.case.name, time(r.wall.as_secs_f64())));
        let slow = slow.collect::<Vec<_>>().join(", ");
        say(
            &mut out,
            &text!("slowest: {slow}", "最慢：{slow}"),
            language,
        );
    }
    let count = |status| results.iter().filter(|r| r.status == status).count();
    let (passed, failures, errors) = (
        count(Status::Passed),
        count(Status::Failed),
        count(Status::Error),
    );
    let passed = text!("{passed} passed", "通过 {passed}");
    let failures = (failures > 0).then(|| text!("{failures} failed", "失败 {failures}"));
    let errors = (errors > 0).then(|| text!("{errors} could not be run", "无法运行 {errors}"));
    let counts = [Some(passed), failures, errors];
    let counts = Text::joined(counts.into_iter().flatten(), ", ", "，");
    let simulated: f64 = results.iter().map(|r| r.time).sum();
    let (simulated, wall) = (time(simulated), time(wall.as_secs_f64()));
    let sum = text!(
        "{counts}; {simulated} simulated in {wall}",
        "{counts}；仿真 {simulated}，用时 {wall}"
    );
    say(&mut out, &sum, language);
    out
}

fn failure(result: &TestResult, language: Language, out: &mut String) {
    let path = result.case.file.path.display();
    let _ = writeln!(out, "\n{path}:{}: {}", result.line, result.case.name);
    for line in plain(result.report.in_language(language)).lines() {
        let _ = writeln!(out, "  {line}");
    }
    if !result.prints.is_empty() {
        say(out, &text!("  printed:", "  输出："), language);
        let hidden = result.prints.len().saturating_sub(PRINTS_MAX);
        if hidden > 0 {
            let text = text!("    … {hidden} lines before", "    … 前面还有 {hidden} 行");
            say(out, &text, language);
        }
        for line in result.prints.iter().skip(hidden) {
            let _ = writeln!(out, "    {}", plain(line));
        }
    }
    if let Some(recording) = &result.recording {
        let recording = recording.display();
        let text = text!("  recording: {recording}", "  记录：{recording}");
        say(out, &text, language);
    }
    let again = repeat_command(result);
    say(
        out,
        &text!("  again: {again}", "  再次运行：{again}"),
        language,
    );
    out.push('\n');
}

fn say(out: &mut String, text: &Text, language: Language) {
    out.push_str(text.in_language(language));
    out.push('\n');
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
