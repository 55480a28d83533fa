//! `replay --find CONDITION`: when something was so, where the script was then, and where the arm.

use std::io::Write;

use controller::search::{MatchInterval, search};
use messages::{Language, Text, text};
use recorder::Recording;

use super::ReplayError;
use super::summary::row;
use crate::ports::escape::EscapedLine;

/// Decimals of positions: a tenth of a millimetre, or of a milliradian.
const DIGITS: usize = 4;

/// Prints every stretch of time in which the condition holds.
pub(super) fn print(
    recording: &Recording,
    text: &str,
    language: Language,
    out: &mut impl Write,
) -> Result<(), ReplayError> {
    let told = search::<ReplayError>(
        recording,
        ("--find", text),
        || true,
        |stretch| tell(stretch, language, out).map(|()| true),
    )?;
    let (stretches, found, cycles) = (told.stretches, told.found, told.cycles);
    let said = match stretches {
        1 => text!(
            "found: 1 time, {found} of {cycles} cycles",
            "找到 1 次，{cycles} 个周期中的 {found} 个"
        ),
        _ => text!(
            "found: {stretches} times, {found} of {cycles} cycles",
            "找到 {stretches} 次，{cycles} 个周期中的 {found} 个"
        ),
    };
    writeln!(out, "{}", said.in_language(language))?;
    Ok(())
}

fn tell(
    stretch: &MatchInterval,
    language: Language,
    out: &mut impl Write,
) -> Result<(), ReplayError> {
    let (first, last, cycles) = (stretch.first.time, stretch.last, stretch.cycles);
    let when = match cycles {
        0 | 1 => Text::verbatim(format!("{first:.3} s")),
        _ => text!(
            "{first:.3} s to {last:.3} s ({cycles} cycles)",
            "{first:.3} s 到 {last:.3} s（{cycles} 个周期）"
        ),
    };
    write!(out, "{}", when.in_language(language))?;
    let doing = &stretch.doing;
    if !doing.program.is_empty() {
        let place = text!(
            ": {} line {}",
            "：{} 第 {} 行",
            EscapedLine(&doing.program),
            doing.line
        );
        write!(out, "{}", place.in_language(language))?;
    }
    if !doing.command.is_empty() {
        let comma = language.pick(", ", "，");
        write!(out, "{comma}{}", EscapedLine(&doing.command))?;
    }
    writeln!(out)?;
    writeln!(
        out,
        "  TCP {} m, rad",
        row(&stretch.first.actual_tcp_pose, DIGITS)
    )?;
    let joints = text!(
        "  joints {} rad",
        "  关节 {} rad",
        row(&stretch.first.actual_q, DIGITS)
    );
    writeln!(out, "{}", joints.in_language(language))?;
    Ok(())
}
