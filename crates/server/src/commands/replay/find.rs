//! `replay --find CONDITION`: when something was so, where the script was then, and where the arm.

use std::io::Write;

use controller::search::{MatchInterval, search};
use editor::analysis::words::Language;
use recorder::Recording;

use super::ReplayError;
use super::summary::row;
use crate::language::told_in;
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
        1 => format!("found: 1 time, {found} of {cycles} cycles"),
        _ => format!("found: {stretches} times, {found} of {cycles} cycles"),
    };
    writeln!(out, "{}", told_in(language, &said))?;
    Ok(())
}

fn tell(
    stretch: &MatchInterval,
    language: Language,
    out: &mut impl Write,
) -> Result<(), ReplayError> {
    let told = |english: &str| told_in(language, english).into_owned();
    let (first, last, cycles) = (stretch.first.time, stretch.last, stretch.cycles);
    write!(
        out,
        "{}",
        match cycles {
            0 | 1 => format!("{first:.3} s"),
            _ => told(&format!("{first:.3} s to {last:.3} s ({cycles} cycles)")),
        }
    )?;
    let doing = &stretch.doing;
    if !doing.program.is_empty() {
        let place = format!(": {} line {}", EscapedLine(&doing.program), doing.line);
        write!(out, "{}", told(&place))?;
    }
    if !doing.command.is_empty() {
        let comma = match language {
            Language::Chinese => "，",
            Language::English => ", ",
        };
        write!(out, "{comma}{}", EscapedLine(&doing.command))?;
    }
    writeln!(out)?;
    writeln!(
        out,
        "  TCP {} m, rad",
        row(&stretch.first.actual_tcp_pose, DIGITS)
    )?;
    let joints = format!("  joints {} rad", row(&stretch.first.actual_q, DIGITS));
    writeln!(out, "{}", told(&joints))?;
    Ok(())
}
