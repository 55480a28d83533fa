//! `replay` without a question: the recording in figures.

use std::io::{self, Write};

use controller::start_configuration::ROBOT;
use editor::analysis::words::Language;
use recorder::cycle::FieldValue;
use recorder::summary::{LimitKind, Summary};
use recorder::{FileEnd, Recording};

use super::error_line;
use crate::language::told_in;
use crate::ports::escape::EscapedLine;

/// Events printed one by one; of more, the rest is counted.
const MAX_PRINTED: usize = 10;

pub(super) fn print(
    recording: &Recording,
    summary: &Summary,
    language: Language,
    out: &mut impl Write,
) -> io::Result<()> {
    let mut report = Report { out, language };
    report.say(format!("recording: {}", EscapedLine(recording.name())))?;
    if let Some(setup) = recording.setup() {
        report.say(format!(
            "robot: {}, {} plant, {} clock, step {} ms, seed {}, eliteserver {}",
            EscapedLine(&setup.arm()),
            EscapedLine(&setup.plant),
            EscapedLine(&setup.clock),
            setup.step_time * 1e3,
            setup.seed,
            EscapedLine(&setup.version)
        ))?;
    }
    report.say(format!("cycles: {}", summary.cycles))?;
    report.say(format!("missing: {}", summary.missing))?;
    if summary.out_of_order > 0 {
        report.say(format!("out of order: {}", summary.out_of_order))?;
    }
    if summary.notes_missing > 0 {
        report.say(format!("messages missing: {}", summary.notes_missing))?;
    }
    report.say(format!("duration: {:.3} s", summary.duration))?;

    let unknown = unknown_fields(recording);
    if !unknown.is_empty() {
        report.say(format!("not known: {}", unknown.join(", ")))?;
    }
    report.say(format!("programs: {}", summary.program_count))?;
    report.list(summary.program_count, &summary.programs, |(time, name)| {
        format!("{time:.3} s {}", EscapedLine(name))
    })?;
    let commands: u64 = summary.commands.values().sum();
    let by_name: Vec<String> = summary
        .commands
        .iter()
        .map(|(name, count)| format!("{} {count}", EscapedLine(name)))
        .collect();
    report.say(format!(
        "commands: {commands}{}",
        bracketed(&by_name.join(", "))
    ))?;

    report.say(format!("errors: {}", summary.error_count))?;
    report.list(summary.error_count, &summary.errors, |(time, log)| {
        let what = error_line::in_one_line(&log.message, language);
        format!(
            "{time:.3} s {}: {}",
            EscapedLine(&log.source),
            EscapedLine(&what)
        )
    })?;
    report.say(format!("warnings: {}", summary.warning_count))?;
    let stops = summary.stops.len() as u64;
    report.say(format!("protective stops: {stops}"))?;
    report.list(stops, &summary.stops, |(time, code)| {
        told_in(language, &format!("{time:.3} s reason {code}")).into_owned()
    })?;
    report.say(format!("limits reached: {}", summary.limit_count))?;
    report.list(summary.limit_count, &summary.limits, |limit| {
        let (time, joint) = (limit.time, limit.joint + 1);
        let english = match limit.kind {
            LimitKind::Speed => format!("{time:.3} s joint {joint} at its speed limit"),
            LimitKind::Position => format!("{time:.3} s joint {joint} at its position limit"),
        };
        told_in(language, &english).into_owned()
    })?;
    report.say(format!("overruns: {}", summary.overruns))?;
    if summary.longest_step_us > 0.0 || summary.max_wakeup_latency_us > 0.0 {
        report.say(format!(
            "longest cycle: {:.0} µs, latest wake-up: {:.0} µs",
            summary.longest_step_us, summary.max_wakeup_latency_us
        ))?;
    }
    report.say(format!(
        "peak joint speeds: {} rad/s",
        row(&summary.peak_joint_speed, 3)
    ))?;
    report.say(format!(
        "peak joint torques: {} Nm",
        row(&summary.peak_joint_torque, 1)
    ))?;
    report.say(format!("peak TCP speed: {:.3} m/s", summary.peak_tcp_speed))?;
    report.say(format!("peak TCP force: {:.1} N", summary.peak_tcp_force))?;
    match &summary.ending {
        Some(FileEnd::Complete) | None => report.say("ending: complete".to_owned()),
        Some(FileEnd::Truncated) => report.say(format!(
            "ending: cut, the recorder was killed or is still writing; readable up to {:.3} s, the last complete \
             chunk",
            summary.end_time
        )),
        Some(FileEnd::Damaged(reason)) => report.say(format!(
            "ending: damaged ({}); readable up to {:.3} s, the last chunk before that",
            EscapedLine(reason),
            summary.end_time
        )),
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

/// Where the report goes, and in which language.
struct Report<'w, W> {
    out: &'w mut W,
    language: Language,
}

impl<W: Write> Report<'_, W> {
    /// A line.
    fn say(&mut self, english: String) -> io::Result<()> {
        writeln!(self.out, "{}", told_in(self.language, &english))
    }

    /// The first of so many items; their texts are in the language of the report.
    fn list<T>(&mut self, count: u64, items: &[T], text: impl Fn(&T) -> String) -> io::Result<()> {
        for item in items.iter().take(MAX_PRINTED) {
            writeln!(self.out, "  {}", text(item))?;
        }
        match count.saturating_sub(MAX_PRINTED as u64) {
            0 => Ok(()),
            more => self.say(format!("  and {more} more")),
        }
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
