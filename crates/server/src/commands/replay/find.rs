//! `replay --find CONDITION`: when something was so, where the script was then, and where the arm.

use std::io::Write;

use controller::search::{MatchInterval, search};
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
    out: &mut impl Write,
) -> Result<(), ReplayError> {
    let told = search::<ReplayError>(
        recording,
        ("--find", text),
        || true,
        |stretch| tell(stretch, out).map(|()| true),
    )?;
    let times = match told.stretches {
        1 => "time",
        _ => "times",
    };
    writeln!(
        out,
        "found: {} {times}, {} of {} cycles",
        told.stretches, told.found, told.cycles
    )?;
    Ok(())
}

fn tell(stretch: &MatchInterval, out: &mut impl Write) -> Result<(), ReplayError> {
    write!(out, "{:.3} s", stretch.first.time)?;
    if stretch.cycles > 1 {
        write!(out, " to {:.3} s ({} cycles)", stretch.last, stretch.cycles)?;
    }
    let doing = &stretch.doing;
    if !doing.program.is_empty() {
        write!(out, ": {} line {}", EscapedLine(&doing.program), doing.line)?;
    }
    if !doing.command.is_empty() {
        write!(out, ", {}", EscapedLine(&doing.command))?;
    }
    writeln!(out)?;
    writeln!(
        out,
        "  TCP {} m, rad",
        row(&stretch.first.actual_tcp_pose, DIGITS)
    )?;
    writeln!(out, "  joints {} rad", row(&stretch.first.actual_q, DIGITS))?;
    Ok(())
}
