//! `replay --script`: the programs of a recording, with when each line ran, how often and for how long; of those that
//! the pendant made from tasks also when each node of the task ran.
//!
//! Lines are recorded where a thread waits or yields, when they change or a loop comes round to them, at most one a
//! cycle and thread: lines that take no simulated time may not show up.

use std::collections::BTreeMap;
use std::io::Write;

use controller::recording_observer::PROGRAM_ENDED;
use messages::{Language, text};
use recorder::{LogLevel, Recording, RecordingEntry, Topic};

use super::ReplayError;
use crate::ports::escape::EscapedLine;

/// Programs that are followed at once; a controller runs fewer.
const MAX_RUNNING: usize = 64;
/// Bytes of their texts.
const MAX_TEXT_BYTES: usize = 64 << 20;
/// Threads of a program that are followed.
const MAX_THREADS: usize = 1024;

/// Nodes of a task that are followed.
const MAX_NODES: usize = 10_000;

/// A node of the pendant's task: its number and its label.
type Node = (u32, String);

/// What is known of a line or a node.
#[derive(Clone, Copy, Default)]
struct LineProfile {
    first: f64,
    last: f64,
    entered: u64,
    commands: u64,
    spent: f64,
}

/// One program that ran.
struct ProgramProfile {
    name: String,
    text: String,
    /// Number of lines of the text; lines beyond are not looked at.
    length: u32,
    start: f64,
    lines: BTreeMap<u32, LineProfile>,
    /// By thread: its line, and the time since when it is there, s.
    threads: BTreeMap<u32, (u32, f64)>,
    /// Figures of nodes; without commands, which do not tell their node.
    nodes: BTreeMap<Node, LineProfile>,
    threads_in_nodes: BTreeMap<u32, (Node, f64)>,
}

/// Prints every program of the recording when it has ended, and then those that have not.
pub(super) fn print(
    recording: &Recording,
    language: Language,
    out: &mut impl Write,
) -> Result<(), ReplayError> {
    let mut running = ProgramProfiler {
        programs: BTreeMap::new(),
        started: 0,
        language,
    };
    let mut now = 0.0;
    for entry in recording.entries(&[Topic::Cycle, Topic::Script, Topic::Command, Topic::Log])? {
        let (time, entry) = entry?;
        match entry {
            RecordingEntry::Cycle(cycle) => now = cycle.time,
            RecordingEntry::Script(script) => {
                if let Some(text) = script.text {
                    let program = ProgramProfile::new(script.program, text, time);
                    running.start(script.program_id, program, out)?;
                } else if let (Some(program), Some(thread), Some(line)) = (
                    running.programs.get_mut(&script.program_id),
                    script.thread,
                    script.line,
                ) {
                    program.enter(thread, line, script.rounds, time);
                    let label = script.label.unwrap_or_default();
                    program.enter_node(thread, script.node.map(|node| (node, label)), time);
                }
            }
            RecordingEntry::Log(log)
                if log.level == LogLevel::Info && log.message == PROGRAM_ENDED =>
            {
                running.end(&log.source, time, out)?;
            }
            RecordingEntry::Command(command) => {
                if let Some(program) = running.programs.get_mut(&command.program_id) {
                    program.command(command.line, time);
                }
            }
            RecordingEntry::Log(_) | RecordingEntry::Io(_) | RecordingEntry::Variable(_) => {}
        }
    }
    if running.started == 0 {
        writeln!(out, "{}", language.pick("no program ran", "没有运行程序"))?;
    }
    while let Some((number, program)) = running.programs.pop_first() {
        program.print(number, now, true, language, out)?;
    }
    Ok(())
}

/// The programs that have not ended yet.
struct ProgramProfiler {
    programs: BTreeMap<u32, ProgramProfile>,
    started: u64,
    /// Language of the report.
    language: Language,
}

impl ProgramProfiler {
    fn start(
        &mut self,
        number: u32,
        program: ProgramProfile,
        out: &mut impl Write,
    ) -> Result<(), ReplayError> {
        self.started += 1;
        let start = program.start;
        if let Some(before) = self.programs.insert(number, program) {
            before.print(number, start, true, self.language, out)?;
        }
        // A file with programs that never end: the oldest are told as they are, and forgotten.
        let bytes = |programs: &BTreeMap<u32, ProgramProfile>| {
            programs.values().map(|p| p.text.len()).sum::<usize>()
        };
        while self.programs.len() > 1
            && (self.programs.len() > MAX_RUNNING || bytes(&self.programs) > MAX_TEXT_BYTES)
            && let Some((number, oldest)) = self.programs.pop_first()
        {
            oldest.print(number, start, true, self.language, out)?;
        }
        Ok(())
    }

    fn end(&mut self, name: &str, time: f64, out: &mut impl Write) -> Result<(), ReplayError> {
        let ended = self.programs.iter().find(|(_, p)| p.name == name);
        let number = ended.map(|(number, _)| *number);
        if let Some(number) = number
            && let Some(program) = self.programs.remove(&number)
        {
            program.print(number, time, false, self.language, out)?;
        }
        Ok(())
    }
}

impl ProgramProfile {
    fn new(name: String, text: String, start: f64) -> Self {
        Self {
            name,
            length: u32::try_from(text.lines().count()).unwrap_or(u32::MAX),
            text,
            start,
            lines: BTreeMap::new(),
            threads: BTreeMap::new(),
            nodes: BTreeMap::new(),
            threads_in_nodes: BTreeMap::new(),
        }
    }

    fn enter_node(&mut self, thread: u32, node: Option<Node>, time: f64) {
        let before = self.threads_in_nodes.get(&thread).map(|(node, _)| node);
        if before == node.as_ref() {
            return;
        }
        self.leave_node(thread, time);
        let Some(node) = node else { return };
        let is_full = self.nodes.len() >= MAX_NODES && !self.nodes.contains_key(&node);
        if is_full || self.threads_in_nodes.len() >= MAX_THREADS {
            return;
        }
        let known = self.nodes.entry(node.clone()).or_insert(LineProfile {
            first: time,
            ..LineProfile::default()
        });
        known.last = time;
        known.entered += 1;
        self.threads_in_nodes.insert(thread, (node, time));
    }

    fn leave_node(&mut self, thread: u32, time: f64) {
        if let Some((node, since)) = self.threads_in_nodes.remove(&thread)
            && let Some(node) = self.nodes.get_mut(&node)
        {
            node.spent += time - since;
        }
    }

    /// A thread came to a line, or `rounds` times round a loop to the line where it is.
    fn enter(&mut self, thread: u32, line: u32, rounds: Option<u32>, time: f64) {
        self.leave(thread, time);
        if !(1..=self.length).contains(&line) || self.threads.len() >= MAX_THREADS {
            return;
        }
        let known = self.lines.entry(line).or_insert(LineProfile {
            first: time,
            ..LineProfile::default()
        });
        known.last = time;
        known.entered = known.entered.saturating_add(rounds.unwrap_or(1).into());
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

    /// Prints it; `end` is when it ended, or up to when it was followed.
    fn print(
        mut self,
        number: u32,
        end: f64,
        still: bool,
        language: Language,
        out: &mut impl Write,
    ) -> Result<(), ReplayError> {
        let threads: Vec<u32> = self.threads.keys().copied().collect();
        for thread in threads {
            self.leave(thread, end);
            self.leave_node(thread, end);
        }
        let start = self.start;
        let name = EscapedLine(&self.name);
        let head = match still {
            true => {
                text!(
                    "program {number}: {name}, {start:.3} s to {end:.3} s, still running",
                    "程序 {number}：{name}，{start:.3} s 到 {end:.3} s，仍在运行"
                )
            }
            false => text!(
                "program {number}: {name}, {start:.3} s to {end:.3} s",
                "程序 {number}：{name}，{start:.3} s 到 {end:.3} s"
            ),
        };
        writeln!(out, "{}", head.in_language(language))?;
        let columns = language.pick(
            "   first s     last s   times    spent s   line",
            "   首次 s     末次 s    次数     用时 s     行",
        );
        writeln!(out, "{columns}")?;
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
        if !self.nodes.is_empty() {
            let columns = language.pick(
                "   first s     last s   times    spent s   node",
                "   首次 s     末次 s    次数     用时 s   节点",
            );
            writeln!(out, "{columns}")?;
        }
        for ((number, label), node) in &self.nodes {
            let label = EscapedLine(label);
            writeln!(
                out,
                "{:10.3} {:10.3} {:7} {:10.3} {number:6}  {label}",
                node.first, node.last, node.entered, node.spent
            )?;
        }
        Ok(())
    }
}
