//! `replay --script`: the programs of a recording, with when each line ran, how often and for how long.
//!
//! Lines are recorded where a thread waits or yields and only when they change, at most one a cycle and thread: lines
//! that take no simulated time may not show up. A loop over one line shows by the commands that the line gave.

use std::collections::BTreeMap;
use std::io::Write;

use recorder::{Entry, LogLevel, Recording, Topic};

use super::ReplayError;

/// The message of `/log` that ends a program.
pub(crate) const ENDED: &str = "program ended";

/// What is known of a line.
#[derive(Clone, Copy, Default)]
struct Line {
    first: f64,
    last: f64,
    entered: u64,
    commands: u64,
    spent: f64,
}

/// One program that ran.
struct Program {
    name: String,
    text: String,
    start: f64,
    end: Option<f64>,
    lines: BTreeMap<u32, Line>,
    /// The line each thread is in, and since when.
    threads: BTreeMap<u32, (u32, f64)>,
}

/// Prints every program of the recording.
pub(super) fn print(recording: &Recording, out: &mut impl Write) -> Result<(), ReplayError> {
    let mut programs: BTreeMap<u32, Program> = BTreeMap::new();
    let mut now = 0.0;
    for entry in recording.entries(&[Topic::Cycle, Topic::Script, Topic::Command, Topic::Log])? {
        let (time, entry) = entry?;
        match entry {
            Entry::Cycle(cycle) => now = cycle.time,
            Entry::Script(script) => {
                if let Some(text) = script.text {
                    let program = Program::new(script.program, text, time);
                    programs.insert(script.program_id, program);
                } else if let (Some(program), Some(thread), Some(line)) = (
                    programs.get_mut(&script.program_id),
                    script.thread,
                    script.line,
                ) {
                    program.enter(thread, line, time);
                }
            }
            Entry::Log(log) if log.level == LogLevel::Info && log.message == ENDED => {
                let ended = programs
                    .values_mut()
                    .find(|program| program.end.is_none() && program.name == log.source);
                if let Some(program) = ended {
                    program.end(time);
                }
            }
            Entry::Command(command) => {
                if let Some(program) = programs.get_mut(&command.program_id) {
                    program.command(command.line, time);
                }
            }
            Entry::Log(_) | Entry::Io(_) | Entry::Variable(_) => {}
        }
    }
    if programs.is_empty() {
        writeln!(out, "no program ran")?;
    }
    for (number, program) in &mut programs {
        let still = program.end.is_none();
        program.end(now);
        program.print(*number, still, out)?;
    }
    Ok(())
}

impl Program {
    fn new(name: String, text: String, start: f64) -> Self {
        Self {
            name,
            text,
            start,
            end: None,
            lines: BTreeMap::new(),
            threads: BTreeMap::new(),
        }
    }

    fn enter(&mut self, thread: u32, line: u32, time: f64) {
        self.leave(thread, time);
        let known = self.lines.entry(line).or_insert(Line {
            first: time,
            ..Line::default()
        });
        known.last = time;
        known.entered += 1;
        self.threads.insert(thread, (line, time));
    }

    fn command(&mut self, line: u32, time: f64) {
        if let Some(line) = self.lines.get_mut(&line) {
            line.commands += 1;
            line.last = time;
        }
    }

    fn leave(&mut self, thread: u32, time: f64) {
        if let Some((line, since)) = self.threads.remove(&thread)
            && let Some(line) = self.lines.get_mut(&line)
        {
            line.spent += time - since;
        }
    }

    fn end(&mut self, time: f64) {
        if self.end.is_none() {
            self.end = Some(time);
            let threads: Vec<u32> = self.threads.keys().copied().collect();
            for thread in threads {
                self.leave(thread, time);
            }
        }
    }

    fn print(&self, number: u32, still: bool, out: &mut impl Write) -> Result<(), ReplayError> {
        let (start, end) = (self.start, self.end.unwrap_or(self.start));
        let running = if still { ", still running" } else { "" };
        let name = &self.name;
        writeln!(
            out,
            "program {number}: {name}, {start:.3} s to {end:.3} s{running}"
        )?;
        writeln!(out, "   first s     last s   times    spent s   line")?;
        for (number, text) in (1_u32..).zip(self.text.lines()) {
            match self.lines.get(&number) {
                Some(line) => write!(
                    out,
                    "{:10.3} {:10.3} {:7} {:10.3}",
                    line.first,
                    line.last,
                    line.entered.max(line.commands),
                    line.spent
                )?,
                None => write!(out, "{:40}", "")?,
            }
            writeln!(out, " {number:6}  {text}")?;
        }
        Ok(())
    }
}
