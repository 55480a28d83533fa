//! `replay` without a question: the recording in figures.

use std::io::{self, Write};

use controller::start_configuration::ROBOT;
use messages::{Language, Text, text};
use recorder::cycle::FieldValue;
use recorder::summary::{LimitKind, Summary};
use recorder::{FileEnd, Recording};

use super::error_line;
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
    report.say(text!(
        "recording: {}",
        "记录：{}",
        EscapedLine(recording.name())
    ))?;
    if let Some(setup) = recording.setup() {
        report.say(text!(
            "robot: {}, {} plant, {} clock, step {} ms, seed {}, eliteserver {}",
            "机器人：{}，模型 {}，时钟 {}，步长 {} ms，种子 {}，eliteserver {}",
            EscapedLine(&setup.arm()),
            EscapedLine(&setup.plant),
            EscapedLine(&setup.clock),
            setup.step_time * 1e3,
            setup.seed,
            EscapedLine(&setup.version)
        ))?;
    }
    report.say(text!("cycles: {}", "周期：{}", summary.cycles))?;
    report.say(text!("missing: {}", "缺失：{}", summary.missing))?;
    if summary.out_of_order > 0 {
        report.say(text!("out of order: {}", "乱序：{}", summary.out_of_order))?;
    }
    if summary.notes_missing > 0 {
        report.say(text!(
            "messages missing: {}",
            "缺失的消息：{}",
            summary.notes_missing
        ))?;
    }
    report.say(text!(
        "duration: {:.3} s",
        "时长：{:.3} s",
        summary.duration
    ))?;

    let unknown = unknown_fields(recording);
    if !unknown.is_empty() {
        report.say(text!("not known: {}", "未知：{}", unknown.join(", ")))?;
    }
    report.say(text!("programs: {}", "程序：{}", summary.program_count))?;
    report.list(summary.program_count, &summary.programs, |(time, name)| {
        Text::verbatim(format!("{time:.3} s {}", EscapedLine(name)))
    })?;
    let commands: u64 = summary.commands.values().sum();
    let by_name: Vec<String> = summary
        .commands
        .iter()
        .map(|(name, count)| format!("{} {count}", EscapedLine(name)))
        .collect();
    report.say(text!(
        "commands: {commands}{}",
        "命令：{commands}{}",
        bracketed(&by_name.join(", "))
    ))?;

    report.say(text!("errors: {}", "错误：{}", summary.error_count))?;
    report.list(summary.error_count, &summary.errors, |(time, log)| {
        let what = error_line::in_one_line(&log.message, language);
        Text::verbatim(format!(
            "{time:.3} s {}: {}",
            EscapedLine(&log.source),
            EscapedLine(&what)
        ))
    })?;
    report.say(text!("warnings: {}", "警告：{}", summary.warning_count))?;
    let stops = summary.stops.len() as u64;
    report.say(text!("protective stops: {stops}", "保护性停止：{stops}"))?;
    report.list(stops, &summary.stops, |(time, code)| {
        text!("{time:.3} s reason {code}", "{time:.3} s 原因 {code}")
    })?;
    report.say(text!(
        "limits reached: {}",
        "到达限值：{}",
        summary.limit_count
    ))?;
    report.list(summary.limit_count, &summary.limits, |limit| {
        let (time, joint) = (limit.time, limit.joint + 1);
        match limit.kind {
            LimitKind::Speed => text!(
                "{time:.3} s joint {joint} at its speed limit",
                "{time:.3} s 关节 {joint} 到达速度限值"
            ),
            LimitKind::Position => text!(
                "{time:.3} s joint {joint} at its position limit",
                "{time:.3} s 关节 {joint} 到达位置限值"
            ),
        }
    })?;
    report.say(text!("overruns: {}", "超时周期：{}", summary.overruns))?;
    if summary.longest_step_us > 0.0 || summary.max_wakeup_latency_us > 0.0 {
        report.say(text!(
            "longest cycle: {:.0} µs, latest wake-up: {:.0} µs",
            "最长周期：{:.0} µs，最大唤醒延迟：{:.0} µs",
            summary.longest_step_us,
            summary.max_wakeup_latency_us
        ))?;
    }
    report.say(text!(
        "peak joint speeds: {} rad/s",
        "关节速度峰值：{} rad/s",
        row(&summary.peak_joint_speed, 3)
    ))?;
    report.say(text!(
        "peak joint torques: {} Nm",
        "关节力矩峰值：{} Nm",
        row(&summary.peak_joint_torque, 1)
    ))?;
    report.say(text!(
        "peak TCP speed: {:.3} m/s",
        "TCP 速度峰值：{:.3} m/s",
        summary.peak_tcp_speed
    ))?;
    report.say(text!(
        "peak TCP force: {:.1} N",
        "TCP 力峰值：{:.1} N",
        summary.peak_tcp_force
    ))?;
    match &summary.ending {
        Some(FileEnd::Complete) | None => report.say(text!("ending: complete", "结尾：完整")),
        Some(FileEnd::Truncated) => report.say(text!(
            "ending: cut, the recorder was killed or is still writing; readable up to {:.3} s, the last \
             complete chunk",
            "结尾：不完整，记录程序被中止或仍在写入；可读到 {:.3} s，即最后一个完整的块",
            summary.end_time
        )),
        Some(FileEnd::Damaged(reason)) => report.say(text!(
            "ending: damaged ({}); readable up to {:.3} s, the last chunk before that",
            "结尾：损坏（{}）；可读到 {:.3} s，即此前的最后一个块",
            Text::new(
                EscapedLine(reason.english()).to_string(),
                EscapedLine(reason.in_language(Language::Chinese)).to_string(),
            ),
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
    fn say(&mut self, line: Text) -> io::Result<()> {
        writeln!(self.out, "{}", line.in_language(self.language))
    }

    /// The first of so many items.
    fn list<T>(&mut self, count: u64, items: &[T], text: impl Fn(&T) -> Text) -> io::Result<()> {
        for item in items.iter().take(MAX_PRINTED) {
            let item = text(item);
            writeln!(self.out, "  {}", item.in_language(self.language))?;
        }
        match count.saturating_sub(MAX_PRINTED as u64) {
            0 => Ok(()),
            more => self.say(text!("  and {more} more", "  还有 {more} 项")),
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
