//! `replay` without a question: the recording in figures.

use std::io::{self, Write};

use super::error_line;
use recorder::cycle::FieldValue;
use recorder::summary::{LimitKind, Summary};
use recorder::{FileEnd, Recording};

use crate::ports::escape::EscapedLine;
use controller::start_configuration::ROBOT;

/// Events printed one by one; of more, the rest is counted.
const MAX_PRINTED: usize = 10;

pub(super) fn print(
    recording: &Recording,
    summary: &Summary,
    out: &mut impl Write,
) -> io::Result<()> {
    writeln!(out, "recording: {}", EscapedLine(recording.name()))?;
    if let Some(setup) = recording.setup() {
        writeln!(
            out,
            "robot: {}, {} plant, {} clock, step {} ms, seed {}, eliteserver {}",
            EscapedLine(&setup.arm()),
            EscapedLine(&setup.plant),
            EscapedLine(&setup.clock),
            setup.step_time * 1e3,
            setup.seed,
            EscapedLine(&setup.version),
        )?;
    }
    writeln!(out, "cycles: {}", summary.cycles)?;
    writeln!(out, "missing: {}", summary.missing)?;
    if summary.out_of_order > 0 {
        writeln!(out, "out of order: {}", summary.out_of_order)?;
    }
    if summary.notes_missing > 0 {
        writeln!(out, "messages missing: {}", summary.notes_missing)?;
    }
    writeln!(out, "duration: {:.3} s", summary.duration)?;

    let unknown = unknown_fields(recording);
    if !unknown.is_empty() {
        writeln!(out, "not known: {}", unknown.join(", "))?;
    }
    writeln!(out, "programs: {}", summary.program_count)?;
    list(
        out,
        summary.program_count,
        &summary.programs,
        |(time, name)| format!("{time:.3} s {}", EscapedLine(name)),
    )?;
    let commands: u64 = summary.commands.values().sum();
    let by_name: Vec<String> = summary
        .commands
        .iter()
        .map(|(name, count)| format!("{} {count}", EscapedLine(name)))
        .collect();
    writeln!(
        out,
        "commands: {commands}{}",
        bracketed(&by_name.join(", "))
    )?;

    writeln!(out, "errors: {}", summary.error_count)?;
    list(out, summary.error_count, &summary.errors, |(time, log)| {
        let what = error_line::in_one_line(&log.message);
        format!(
            "{time:.3} s {}: {}",
            EscapedLine(&log.source),
            EscapedLine(&what)
        )
    })?;
    writeln!(out, "warnings: {}", summary.warning_count)?;
    let stops = summary.stops.len() as u64;
    writeln!(out, "protective stops: {stops}")?;
    list(out, stops, &summary.stops, |(time, code)| {
        format!("{time:.3} s reason {code}")
    })?;
    writeln!(out, "limits reached: {}", summary.limit_count)?;
    list(out, summary.limit_count, &summary.limits, |limit| {
        let kind = match limit.kind {
            LimitKind::Speed => "speed",
            LimitKind::Position => "position",
        };
        format!(
            "{:.3} s joint {} at its {kind} limit",
            limit.time,
            limit.joint + 1
        )
    })?;
    writeln!(out, "overruns: {}", summary.overruns)?;
    if summary.longest_step_us > 0.0 || summary.max_wakeup_latency_us > 0.0 {
        writeln!(
            out,
            "longest cycle: {:.0} µs, latest wake-up: {:.0} µs",
            summary.longest_step_us, summary.max_wakeup_latency_us
        )?;
    }
    writeln!(
        out,
        "peak joint speeds: {} rad/s",
        row(&summary.peak_joint_speed, 3)
    )?;
    writeln!(
        out,
        "peak joint torques: {} Nm",
        row(&summary.peak_joint_torque, 1)
    )?;
    writeln!(out, "peak TCP speed: {:.3} m/s", summary.peak_tcp_speed)?;
    writeln!(out, "peak TCP force: {:.1} N", summary.peak_tcp_force)?;
    match &summary.ending {
        Some(FileEnd::Complete) | None => writeln!(out, "ending: complete"),
        Some(FileEnd::Truncated) => writeln!(
            out,
            "ending: cut, the recorder was killed or is still writing; readable up to {:.3} s, the last complete chunk",
            summary.end_time
        ),
        Some(FileEnd::Damaged(reason)) => writeln!(
            out,
            "ending: damaged ({}); readable up to {:.3} s, the last chunk before that",
            EscapedLine(reason),
            summary.end_time
        ),
    }
}

/// What a robot elsewhere did not tell: fields whose numbers are none.
fn unknown_fields(recording: &Recording) -> Vec<&'static str> {
    if recording.setup().is_none_or(|setup| setup.plant != ROBOT) {
        return Vec::new();
    }
    // Cycles that cannot be read are told elsewhere.
    let first = recording.cycles().ok().and_then(|mut cycles| cycles.next());
    let Some(Ok(first)) = first else {
        return Vec::new();
    };
    let is_unknown = |value: &FieldValue<'_>| match value {
        FieldValue::Number(number) => number.is_nan(),
        FieldValue::Numbers(numbers) => numbers.iter().any(|number| number.is_nan()),
        FieldValue::Unsigned(_) | FieldValue::Text(_) => false,
    };
    let fields = first.fields();
    let unknown = fields.iter().filter(|(_, value)| is_unknown(value));
    unknown.map(|(name, _)| *name).collect()
}

fn list<T>(
    out: &mut impl Write,
    count: u64,
    items: &[T],
    text: impl Fn(&T) -> String,
) -> io::Result<()> {
    for item in items.iter().take(MAX_PRINTED) {
        writeln!(out, "  {}", text(item))?;
    }
    match count.saturating_sub(MAX_PRINTED as u64) {
        0 => Ok(()),
        more => writeln!(out, "  and {more} more"),
    }
}

fn bracketed(text: &str) -> String {
    if text.is_empty() {
        String::new()
    } else {
        format!(" ({text})")
    }
}

/// Numbers with blanks between them. What rounds to zero has no sign, which would be that of an error of rounding.
pub(super) fn row(values: &[f64], digits: usize) -> String {
    let values = values.iter().map(|number| {
        let text = format!("{number:.digits$}");
        match text.strip_prefix('-') {
            Some(zero) if zero.bytes().all(|byte| matches!(byte, b'0' | b'.')) => zero.to_owned(),
            _ => text,
        }
    });
    values.collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::row;

    #[test]
    fn what_rounds_to_zero_has_no_sign() {
        assert_eq!(
            row(&[-0.00004, -0.0, 0.0, -0.00006, -1.5], 4),
            "0.0000 0.0000 0.0000 -0.0001 -1.5000"
        );
    }
}
