//! `replay --at T`: everything that is known about one moment.

use std::collections::BTreeMap;
use std::io::Write;

use messages::{Language, Text, text};
use motion_api::{RobotMode, SafetyMode};
use recorder::{CommandMessage, CycleMessage, FieldValue, Recording, RecordingEntry, Topic};

use super::ReplayError;
use crate::ports::escape::EscapedLine;

/// Script threads whose lines are kept: more than can run at once.
const MAX_LINES: usize = 1024;
/// Commands that may be waiting or running; the ring of a controller holds fewer.
const MAX_COMMANDS: usize = 1024;

/// What was known when the cycle ended.
#[derive(Default)]
struct RecordedMoment {
    cycle: Option<CycleMessage>,
    /// The command that was taken last, of those that are or may be running.
    commands: BTreeMap<u64, CommandMessage>,
    /// Program and line of every script thread, and the node of its task.
    lines: BTreeMap<(u32, u32), (String, u32, Option<String>)>,
}

/// Prints the latest cycle that had ended at `time`; before the end of the first cycle, the first.
pub(super) fn print(
    recording: &Recording,
    time: f64,
    language: Language,
    out: &mut impl Write,
) -> Result<(), ReplayError> {
    let (moment, range) = moment_at(recording, time)?;
    let no_such_time = || ReplayError::NoSuchTime { asked: time, range };
    let cycle = moment.cycle.as_ref().ok_or_else(no_such_time)?;
    writeln!(out, "cycle: {}", cycle.cycle)?;
    writeln!(out, "time: {:.6} s", cycle.time)?;
    for ((_, thread), (program, line, node)) in &moment.lines {
        let program = EscapedLine(program);
        let place = match node {
            Some(node) => text!(
                "script: {program} line {line}, node {} (thread {thread})",
                "脚本：{program} 第 {line} 行，节点 {}（线程 {thread}）",
                EscapedLine(node)
            ),
            None => text!(
                "script: {program} line {line} (thread {thread})",
                "脚本：{program} 第 {line} 行（线程 {thread}）"
            ),
        };
        writeln!(out, "{}", place.in_language(language))?;
    }
    let command = match moment.commands.get(&cycle.command_id) {
        Some(command) => text!(
            "command: {} {}{}",
            "命令：{} {}{}",
            command.id,
            EscapedLine(&command.name),
            place(command)
        ),
        None => text!("command: none", "命令：无"),
    };
    writeln!(out, "{}", command.in_language(language))?;
    let robot_mode = RobotMode::from_number(cycle.robot_mode as i32);
    let safety_mode = SafetyMode::from_number(cycle.safety_mode as i32);
    for (name, value) in cycle.fields() {
        match name {
            "cycle" | "time" | "command_id" => {}
            "robot_mode" => writeln!(out, "robot_mode: {robot_mode}")?,
            "safety_mode" => writeln!(out, "safety_mode: {safety_mode}")?,
            "digital_in" | "digital_out" => {
                let FieldValue::Unsigned(mask) = value else {
                    continue;
                };
                writeln!(out, "{name}: {mask:#034b}")?;
            }
            _ => writeln!(out, "{name}: {}{}", text(value), unit(name))?,
        }
    }
    Ok(())
}

fn place(command: &CommandMessage) -> Text {
    match command.line {
        0 => Text::verbatim(""),
        line => text!(
            " ({} line {line})",
            "（{} 第 {line} 行）",
            EscapedLine(&command.program)
        ),
    }
}

/// The moment, and the first and last time of the recording as far as it was read.
fn moment_at(
    recording: &Recording,
    time: f64,
) -> Result<(RecordedMoment, Option<(f64, f64)>), ReplayError> {
    let mut moment = RecordedMoment::default();
    let mut range: Option<(f64, f64)> = None;
    let mut passed = false;
    for entry in recording.entries(&[Topic::Cycle, Topic::Command, Topic::Script])? {
        match entry?.1 {
            RecordingEntry::Cycle(cycle) => {
                let first = range.map_or(cycle.time, |(first, _)| first);
                range = Some((first, cycle.time));
                // Times are products of the step: a last digit must not make `--at 0.012` miss its cycle.
                passed = cycle.time > time + 1e-9;
                if !passed || moment.cycle.is_none() {
                    moment.cycle = Some(*cycle);
                }
                if passed {
                    break;
                }
            }
            RecordingEntry::Command(command) => {
                let running = moment.cycle.as_ref().map_or(0, |cycle| cycle.command_id);
                moment.commands.retain(|id, _| *id >= running);
                remember(&mut moment.commands, command);
            }
            RecordingEntry::Script(script) => {
                if let (Some(thread), Some(line)) = (script.thread, script.line) {
                    let thread = (script.program_id, thread);
                    let label = script.label.unwrap_or_default();
                    let node = script.node.map(|node| {
                        format!("{node} {}", EscapedLine(&label))
                            .trim_end()
                            .to_owned()
                    });
                    moment.lines.insert(thread, (script.program, line, node));
                    if moment.lines.len() > MAX_LINES {
                        moment.lines.pop_first();
                    }
                } else {
                    moment
                        .lines
                        .retain(|(program, _), _| *program == script.program_id);
                }
            }
            RecordingEntry::Log(_) | RecordingEntry::Io(_) | RecordingEntry::Variable(_) => {}
        }
    }
    let step = moment.cycle.as_ref().map_or(0.0, |cycle| cycle.step_time);
    let covered = passed || range.is_some_and(|(_, last)| time <= last + step);
    if !(time >= 0.0 && covered) {
        moment.cycle = None;
    }
    Ok((moment, range))
}

fn text(value: FieldValue) -> String {
    match value {
        FieldValue::Unsigned(x) => x.to_string(),
        FieldValue::Number(x) => format!("{x:.6}"),
        FieldValue::Numbers(values) => {
            let values: Vec<String> = values.iter().map(|x| format!("{x:.6}")).collect();
            values.join(" ")
        }
        FieldValue::Text(x) => x.to_owned(),
    }
}

fn unit(name: &str) -> &'static str {
    match name {
        "target_q" | "actual_q" => " rad",
        "target_qd" | "actual_qd" => " rad/s",
        "target_qdd" => " rad/s²",
        "target_torque" | "actual_torque" => " Nm",
        "target_tcp_pose" | "actual_tcp_pose" | "tcp_offset" => " m, rad",
        "target_tcp_speed" | "actual_tcp_speed" => " m/s, rad/s",
        "tcp_force" | "raw_wrench" => " N, Nm",
        "elbow_position" => " m",
        "payload" => " kg, m, kg m²",
        "step_time" => " s",
        "step_duration_us" | "wakeup_latency_us" => " µs",
        _ => "",
    }
}

/// Keeps a command that may be running, without its arguments. Of more than a controller can have waiting, the oldest
/// go.
fn remember(commands: &mut BTreeMap<u64, CommandMessage>, mut command: CommandMessage) {
    command.arguments.clear();
    commands.insert(command.id, command);
    if commands.len() > MAX_COMMANDS {
        commands.pop_first();
    }
}
