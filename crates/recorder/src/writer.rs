//! Records and notes in, messages out: what a recording holds, in which order. No thread, no file name, no wall clock.
//!
//! The recorder's thread drives it; [`ChunkedFile`] makes the bytes, [`Viewer`] what viewers show.

use std::collections::{BTreeMap, VecDeque};
use std::io::Write;

use mcap::McapError;
use motion_api::{Command, ProgramId, Record, RegisterImages, RobotState, ThreadNumber};

use crate::chunks::ChunkedFile;
use crate::cycle::Cycle;
use crate::io_changes;
use crate::setup::Setup;
use crate::topics::{
    CommandMessage, IoMessage, IoValue, LogLevel, ScriptMessage, Topic, VariableMessage,
};
use crate::viewer::Viewer;

/// How many programs, and lines of how many script threads, are remembered.
const MAX_REMEMBERED: usize = 1024;
/// How many of the latest programs have their text repeated in the next part.
const MAX_TEXTS: usize = 4;
/// Messages that may wait for their place between the cycles; one more is written out of order.
pub(crate) const MAX_WAITING: usize = 16 * 1024;

/// What the script side adds to a recording. Times are simulated seconds since start.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Note {
    ProgramStarted {
        time: f64,
        program: ProgramId,
        name: String,
        text: String,
    },
    ScriptLine {
        time: f64,
        program: ProgramId,
        thread: ThreadNumber,
        line: u32,
    },
    Variable {
        time: f64,
        program: ProgramId,
        name: String,
        type_name: String,
        value: String,
    },
    Log {
        time: f64,
        level: LogLevel,
        source: String,
        message: String,
    },
    Io {
        time: f64,
        name: String,
        value: IoValue,
    },
}

impl Note {
    fn time(&self) -> f64 {
        match self {
            Self::ProgramStarted { time, .. }
            | Self::ScriptLine { time, .. }
            | Self::Variable { time, .. }
            | Self::Log { time, .. }
            | Self::Io { time, .. } => *time,
        }
    }
}

/// What a recording holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Totals {
    /// Cycles written.
    pub cycles: u64,
    /// Cycles that are missing between the first and the last one.
    pub missing: u64,
    /// Commands written.
    pub commands: u64,
}

pub(crate) struct RecordWriter<W: Write> {
    file: ChunkedFile<W>,
    step_time: f64,
    viewer: Viewer,
    /// The message of the current cycle, reused.
    cycle: Cycle,
    /// The latest cycle written.
    latest: Option<RobotState>,
    /// The registers as the latest cycle began with them.
    registers: RegisterImages,
    programs: BTreeMap<ProgramId, String>,
    /// Texts of the latest programs.
    texts: BTreeMap<ProgramId, String>,
    /// The line that was last written for a script thread.
    lines: BTreeMap<(ProgramId, ThreadNumber), u32>,
    totals: Totals,
}

impl<W: Write> RecordWriter<W> {
    /// Writes the start of the file: setup, schemas, the arm. All of it has reached `out` when this returns, so an
    /// output that cannot be written is found here.
    pub(crate) fn start(out: W, setup: &Setup, viewer: Viewer) -> Result<Self, McapError> {
        let mut writer = Self {
            file: ChunkedFile::begin(out, setup, 0)?,
            step_time: setup.step_time,
            viewer,
            cycle: Cycle::default(),
            latest: None,
            registers: RegisterImages::default(),
            programs: BTreeMap::new(),
            texts: BTreeMap::new(),
            lines: BTreeMap::new(),
            totals: Totals::default(),
        };
        writer.scene(0.0)?;
        writer.file.close_chunk()?;
        Ok(writer)
    }

    /// Ends this file and goes on in `out`, which is the part that `setup` says. What was going on is told again: the
    /// arm, the latest programs, the line of every thread. The old output comes back complete.
    pub(crate) fn go_on_in(mut self, out: W, setup: &Setup) -> Result<(Self, W), McapError> {
        let next = ChunkedFile::begin(out, setup, self.file.chunks())?;
        let before = std::mem::replace(&mut self.file, next);
        let time = self.time();
        self.scene(time)?;
        let programs: Vec<ProgramId> = self.texts.keys().copied().collect();
        for program in &programs {
            self.text(time, *program)?;
        }
        for (thread, line) in self.lines.clone() {
            if programs.contains(&thread.0) {
                self.line(time, thread, line)?;
            }
        }
        self.file.close_chunk()?;
        Ok((self, before.finish()?))
    }

    /// What has been written so far.
    pub(crate) fn totals(&self) -> Totals {
        self.totals
    }

    /// Simulated time of the latest cycle, s.
    pub(crate) fn time(&self) -> f64 {
        self.latest.map_or(0.0, |state| state.time)
    }

    /// Writes one record, and before it those of the `waiting` notes that belong before it.
    pub(crate) fn record(
        &mut self,
        record: &Record,
        waiting: &mut VecDeque<Note>,
    ) -> Result<(), McapError> {
        match record {
            Record::Cycle(state) => {
                self.notes_until(state.time - state.step_time, waiting)?;
                self.state(state)
            }
            Record::Command { cycle, command } => {
                let begin = self.begin_of(*cycle);
                self.notes_until(begin, waiting)?;
                self.command(begin, *cycle, command)
            }
            Record::Registers { cycle, images } => {
                let begin = self.begin_of(*cycle);
                self.notes_until(begin, waiting)?;
                for change in io_changes::of_registers(*cycle, &self.registers, images) {
                    self.file.json(Topic::Io, begin, &change)?;
                }
                self.registers = *images;
                Ok(())
            }
        }
    }

    /// Writes all notes that wait.
    pub(crate) fn notes(&mut self, waiting: &mut VecDeque<Note>) -> Result<(), McapError> {
        self.notes_until(f64::INFINITY, waiting)
    }

    /// The number of the chunk that a kill would lose now, if there is one.
    pub(crate) fn open_chunk(&self) -> Option<u64> {
        self.file.open_chunk()
    }

    /// Hands everything to the output.
    pub(crate) fn close_chunk(&mut self) -> Result<(), McapError> {
        self.file.close_chunk()
    }

    /// Writes the index and the end of the file, and gives the output back.
    pub(crate) fn finish(self) -> Result<(W, Totals), McapError> {
        Ok((self.file.finish()?, self.totals))
    }

    /// Says in the recording itself that notes are missing.
    pub(crate) fn dropped(&mut self, count: u64) -> Result<(), McapError> {
        let time = self.latest.map_or(0.0, |state| state.time);
        let message = format!(
            "{count} messages about programs and registers are missing here: the recording did not keep up"
        );
        self.log(time, LogLevel::Warning, "recorder", &message)
    }

    /// Time at which a cycle begins: the end of the one before, s.
    fn begin_of(&self, cycle: u64) -> f64 {
        let (time, before) = self
            .latest
            .map_or((0.0, 0), |state| (state.time, state.cycle));
        time + cycle.saturating_sub(before + 1) as f64 * self.step_time
    }

    fn state(&mut self, state: &RobotState) -> Result<(), McapError> {
        self.step_time = state.step_time;
        self.missing(state)?;
        self.cycle.set(state);
        self.file.protobuf(Topic::Cycle, state.time, &self.cycle)?;
        self.totals.cycles += 1;
        for change in io_changes::between(self.latest.as_ref(), state) {
            self.file.json(Topic::Io, state.time, &change)?;
        }
        let (file, time) = (&mut self.file, state.time);
        self.viewer
            .state(state, |topic, message| file.put(topic, time, message))?;
        self.latest = Some(*state);
        Ok(())
    }

    /// Says in the recording itself that cycles are missing.
    fn missing(&mut self, state: &RobotState) -> Result<(), McapError> {
        let expected = self.latest.map_or(state.cycle, |s| s.cycle + 1);
        let missing = state.cycle.saturating_sub(expected);
        if missing == 0 {
            return Ok(());
        }
        self.totals.missing += missing;
        let message = format!(
            "{missing} cycles are missing before cycle {}: the recording did not keep up",
            state.cycle
        );
        self.log(state.time, LogLevel::Warning, "recorder", &message)
    }

    fn scene(&mut self, time: f64) -> Result<(), McapError> {
        let file = &mut self.file;
        self.viewer
            .scene(time, |topic, message| file.put(topic, time, message))
    }

    fn command(&mut self, time: f64, cycle: u64, command: &Command) -> Result<(), McapError> {
        self.totals.commands += 1;
        let program = self.program(command.origin.program);
        let message = CommandMessage::new(cycle, command, program);
        self.file.json(Topic::Command, time, &message)
    }

    /// Writes the notes up to `time`, and after them for every script thread the line it came to, if it is another.
    ///
    /// The notes of one cycle are taken together: a thread that ran through many lines has one line message.
    fn notes_until(&mut self, time: f64, waiting: &mut VecDeque<Note>) -> Result<(), McapError> {
        // Notes carry the time of a cycle; half a cycle keeps rounding from moving them.
        let limit = time + 0.5 * self.step_time;
        let mut lines = BTreeMap::new();
        while let Some(note) = waiting.front() {
            if note.time() > limit && waiting.len() <= MAX_WAITING {
                break;
            }
            match waiting.pop_front() {
                Some(Note::ScriptLine {
                    time,
                    program,
                    thread,
                    line,
                }) => {
                    lines.insert((program, thread), (time, line));
                }
                Some(note) => self.note(note)?,
                None => break,
            }
        }
        for (thread, (time, line)) in lines {
            if self.lines.get(&thread) != Some(&line) {
                remember(&mut self.lines, thread, line);
                self.line(time, thread, line)?;
            }
        }
        Ok(())
    }

    fn note(&mut self, note: Note) -> Result<(), McapError> {
        match note {
            Note::ProgramStarted {
                time,
                program,
                name,
                text,
            } => {
                remember(&mut self.programs, program, name);
                self.texts.insert(program, text);
                if self.texts.len() > MAX_TEXTS {
                    self.texts.pop_first();
                }
                self.text(time, program)
            }
            Note::ScriptLine {
                time,
                program,
                thread,
                line,
            } => self.line(time, (program, thread), line),
            Note::Variable {
                time,
                program,
                name,
                type_name,
                value,
            } => {
                let message = VariableMessage {
                    program: self.programs.get(&program).cloned().unwrap_or_default(),
                    program_id: program.0,
                    name,
                    type_name,
                    value,
                };
                self.file.json(Topic::Variables, time, &message)
            }
            Note::Log {
                time,
                level,
                source,
                message,
            } => self.log(time, level, &source, &message),
            Note::Io { time, name, value } => {
                let cycle = self.latest.map_or(0, |state| state.cycle);
                self.file
                    .json(Topic::Io, time, &IoMessage { cycle, name, value })
            }
        }
    }

    fn text(&mut self, time: f64, program: ProgramId) -> Result<(), McapError> {
        let message = ScriptMessage {
            program: self.program(program).to_owned(),
            program_id: program.0,
            text: self.texts.get(&program).cloned(),
            thread: None,
            line: None,
        };
        self.file.json(Topic::Script, time, &message)
    }

    fn line(
        &mut self,
        time: f64,
        (program, thread): (ProgramId, ThreadNumber),
        line: u32,
    ) -> Result<(), McapError> {
        let message = ScriptMessage {
            program: self.program(program).to_owned(),
            program_id: program.0,
            text: None,
            thread: Some(thread.0),
            line: Some(line),
        };
        self.file.json(Topic::Script, time, &message)
    }

    fn log(
        &mut self,
        time: f64,
        level: LogLevel,
        source: &str,
        message: &str,
    ) -> Result<(), McapError> {
        let log = self.viewer.log(time, level, source, message);
        self.file.put(Topic::Log, time, log)
    }

    fn program(&self, program: ProgramId) -> &str {
        self.programs.get(&program).map_or("", String::as_str)
    }
}

/// Inserts; when there are too many entries, the one with the smallest (oldest) key makes room.
fn remember<K: Ord, V>(map: &mut BTreeMap<K, V>, key: K, value: V) {
    map.insert(key, value);
    if map.len() > MAX_REMEMBERED {
        map.pop_first();
    }
}
