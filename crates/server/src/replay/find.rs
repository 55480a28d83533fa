//! `replay --find CONDITION`: when something was so, where the script was then, and where the arm.

use std::collections::BTreeMap;
use std::io::Write;

use controller::condition::{Condition, Doing};
use recorder::{CommandMessage, Cycle, Entry, Recording, Topic};

use super::ReplayError;
use crate::ports::shown::Shown;

/// A row of cycles in which the condition held.
struct Stretch {
    first: Cycle,
    last: f64,
    cycles: u64,
    doing: Doing,
}

/// Prints every stretch of time in which the condition holds.
pub(super) fn print(
    recording: &Recording,
    text: &str,
    out: &mut impl Write,
) -> Result<(), ReplayError> {
    let condition = Condition::new("--find", text)?;
    let mut doing = Doing::default();
    let mut commands: BTreeMap<u64, CommandMessage> = BTreeMap::new();
    let mut current: Option<Stretch> = None;
    let (mut stretches, mut found, mut cycles) = (0_u64, 0_u64, 0_u64);
    for entry in recording.entries(&[Topic::Cycle, Topic::Command, Topic::Script])? {
        match entry?.1 {
            Entry::Command(command) => super::remember(&mut commands, command),
            Entry::Script(script) => match (script.thread, script.line) {
                (Some(0), Some(line)) => doing.line = line,
                (Some(_), _) => {}
                _ => {
                    doing.program = script.program;
                    doing.line = 0;
                }
            },
            Entry::Cycle(cycle) => {
                cycles += 1;
                commands.retain(|id, _| *id >= cycle.command_id);
                let running = commands.get(&cycle.command_id);
                doing.command = running.map_or_else(String::new, |command| command.name.clone());
                if condition.holds(&cycle, &doing)? {
                    found += 1;
                    let stretch = current.get_or_insert_with(|| Stretch {
                        last: cycle.time,
                        first: *cycle.clone(),
                        cycles: 0,
                        doing: doing.clone(),
                    });
                    stretch.last = cycle.time;
                    stretch.cycles += 1;
                } else if let Some(stretch) = current.take() {
                    stretches += 1;
                    stretch.print(out)?;
                }
            }
            Entry::Log(_) | Entry::Io(_) | Entry::Variable(_) => {}
        }
    }
    if let Some(stretch) = current.take() {
        stretches += 1;
        stretch.print(out)?;
    }
    writeln!(out, "found: {stretches} times, {found} of {cycles} cycles")?;
    Ok(())
}

impl Stretch {
    fn print(&self, out: &mut impl Write) -> Result<(), ReplayError> {
        write!(out, "{:.3} s", self.first.time)?;
        if self.cycles > 1 {
            write!(out, " to {:.3} s ({} cycles)", self.last, self.cycles)?;
        }
        if !self.doing.program.is_empty() {
            write!(
                out,
                ": {} line {}",
                Shown(&self.doing.program),
                self.doing.line
            )?;
        }
        if !self.doing.command.is_empty() {
            write!(out, ", {}", Shown(&self.doing.command))?;
        }
        writeln!(out)?;
        writeln!(out, "  TCP {} m, rad", row(&self.first.actual_tcp_pose))?;
        writeln!(out, "  joints {} rad", row(&self.first.actual_q))?;
        Ok(())
    }
}

fn row(values: &[f64]) -> String {
    let values: Vec<String> = values.iter().map(|x| format!("{x:.4}")).collect();
    values.join(" ")
}
