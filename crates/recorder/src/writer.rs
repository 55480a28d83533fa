//! Records and notes in, messages out: what a recording holds, in which order. No thread, no file name, no wall clock.
//!
//! The recorder's thread drives it; [`ChunkedFile`] makes the bytes, [`ViewerMessages`] what viewers show.

use std::collections::BTreeMap;
use std::io::Write;

use mcap::McapError;
use messages::Text;
use motion_api::{Command, ProgramId, Record, RegisterImages, RobotState, ThreadNumber};
use serde::Serialize;

use crate::chunks::ChunkedFile;
use crate::cycle::CycleMessage;
use crate::extra::CustomTopic;
use crate::io_changes;
use crate::lengths::{SHORT_TEXT_BYTES, truncate_marked};
use crate::losses::{self, SOURCE};
use crate::notes::{Annotation, PendingAnnotations, ThreadPosition};
use crate::setup::Setup;
use crate::topics::{CommandMessage, IoMessage, LogLevel, ScriptMessage, Topic, VariableMessage};
use crate::viewer::ViewerMessages;

/// How many programs, and lines of how many script threads, are remembered.
const MAX_REMEMBERED: usize = 1024;
/// How many of the latest programs have their text repeated in the next part.
const MAX_TEXTS: usize = 4;
/// Bytes that these texts may have together; the latest is always among them.
const MAX_TEXT_BYTES: usize = 16 << 20;

/// Shortest time between two messages about rounds of a loop over one line, s.
const ROUNDS_PERIOD: f64 = 0.02;

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

/// What was last written of where a script thread stands.
#[derive(Clone)]
struct WrittenPosition {
    place: ThreadPosition,
    /// When, s.
    time: f64,
    /// Rounds of a loop to the same place since.
    rounds: u32,
}

pub(crate) struct RecordWriter<W: Write> {
    file: ChunkedFile<W>,
    extra: Vec<CustomTopic>,
    step_time: f64,
    viewer: ViewerMessages,
    /// The message of the current cycle, reused.
    cycle: CycleMessage,
    /// The latest cycle written.
    latest: Option<RobotState>,
    /// The registers as the latest cycle began with them.
    registers: RegisterImages,
    programs: BTreeMap<ProgramId, String>,
    /// Texts of the latest programs.
    texts: BTreeMap<ProgramId, Box<str>>,
    allowance: TextRateLimiter,
    /// What was last written for each script thread.
    thread_positions: BTreeMap<(ProgramId, ThreadNumber), WrittenPosition>,
    totals: Totals,
}

impl<W: Write> RecordWriter<W> {
    /// Writes the start of the file: setup, schemas, the arm. All of it has reached `out` when this returns, so an
    /// output that cannot be written is found here.
    pub(crate) fn start(
        out: W,
        setup: &Setup,
        viewer: ViewerMessages,
        extra: Vec<CustomTopic>,
    ) -> Result<Self, McapError> {
        let mut writer = Self {
            file: ChunkedFile::begin(out, setup, &extra, 0)?,
            extra,
            step_time: setup.step_time,
            viewer,
            cycle: CycleMessage::default(),
            latest: None,
            registers: RegisterImages::default(),
            programs: BTreeMap::new(),
            texts: BTreeMap::new(),
            allowance: TextRateLimiter::default(),
            thread_positions: BTreeMap::new(),
            totals: Totals::default(),
        };
        writer.scene(0.0)?;
        writer.file.close_chunk()?;
        Ok(writer)
    }

    /// Ends this file and goes on in `out`, which is the part that `setup` says. What was going on is told again: the
    /// arm, the latest programs, the line of every thread. The old output comes back complete.
    pub(crate) fn rotate_to(mut self, out: W, setup: &Setup) -> Result<(Self, W), McapError> {
        self.write_all_rounds(self.time())?;
        let next = ChunkedFile::begin(out, setup, &self.extra, self.file.chunks())?;
        let before = std::mem::replace(&mut self.file, next);
        let time = self.time();
        self.scene(time)?;
        let programs: Vec<ProgramId> = self.texts.keys().copied().collect();
        for program in &programs {
            self.text(time, *program)?;
        }
        for (thread, known) in self.thread_positions.clone() {
            if programs.contains(&thread.0) {
                self.write_position(time, thread, &known.place, None)?;
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
        waiting: &mut PendingAnnotations,
    ) -> Result<(), McapError> {
        match record {
            Record::Cycle(state) => {
                self.notes_until(state.time - state.step_time, waiting)?;
                self.state(state)
            }
            Record::Command { cycle, command } => {
                let begin = self.cycle_start_time(*cycle);
                self.notes_until(begin, waiting)?;
                self.command(begin, *cycle, command)
            }
            Record::Points { cycle, id, points } => {
                let begin = self.cycle_start_time(*cycle);
                self.notes_until(begin, waiting)?;
                for message in CommandMessage::points(*cycle, *id, points) {
                    self.file.json(Topic::Command, begin, &message)?;
                }
                Ok(())
            }
            Record::Registers { cycle, images } => {
                let begin = self.cycle_start_time(*cycle);
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
    pub(crate) fn notes(&mut self, waiting: &mut PendingAnnotations) -> Result<(), McapError> {
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
    pub(crate) fn finish(mut self) -> Result<(W, Totals), McapError> {
        self.write_all_rounds(self.time())?;
        Ok((self.file.finish()?, self.totals))
    }

    /// Says in the recording itself that notes are missing.
    pub(crate) fn dropped(&mut self, count: u64) -> Result<(), McapError> {
        let time = self.latest.map_or(0.0, |state| state.time);
        self.log(
            time,
            LogLevel::Warning,
            SOURCE,
            &losses::annotations_lost_text(count),
        )
    }

    /// Time at which a cycle begins: the end of the one before, s.
    fn cycle_start_time(&self, cycle: u64) -> f64 {
        let (time, before) = self
            .latest
            .map_or((0.0, 0), |state| (state.time, state.cycle));
        time + cycle.saturating_sub(before + 1) as f64 * self.step_time
    }

    fn state(&mut self, state: &RobotState) -> Result<(), McapError> {
        self.step_time = state.step_time;
        self.write_gap_notice(state)?;
        self.cycle.set_from_state(state);
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
    fn write_gap_notice(&mut self, state: &RobotState) -> Result<(), McapError> {
        let expected = self.latest.map_or(state.cycle, |s| s.cycle + 1);
        let missing = state.cycle.saturating_sub(expected);
        if missing == 0 {
            return Ok(());
        }
        self.totals.missing += missing;
        let message = losses::cycles_lost_text(missing, state.cycle);
        self.log(state.time, LogLevel::Warning, SOURCE, &message)
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

    /// Writes the notes up to `time`, and after them for every script thread the line it came to.
    ///
    /// The notes of one cycle are taken together: a thread that ran through many lines has one line message. Nodes of
    /// the pendant's task are each told. Rounds of a loop over one line are counted, so that a program that polls does
    /// not write a message every cycle.
    fn notes_until(
        &mut self,
        time: f64,
        waiting: &mut PendingAnnotations,
    ) -> Result<(), McapError> {
        // Notes carry the time of a cycle; half a cycle keeps rounding from moving them.
        let limit = time + 0.5 * self.step_time;
        let mut places = BTreeMap::new();
        while let Some(note) = waiting.first() {
            if note.time() > limit {
                break;
            }
            match waiting.pop() {
                Some(Annotation::ScriptLine {
                    time,
                    program,
                    thread,
                    place,
                }) => {
                    let thread = (program, thread);
                    let known = self.thread_positions.get(&thread);
                    let is_news = place.node.is_some()
                        && known.is_none_or(|known| known.place.node != place.node);
                    if is_news {
                        self.update_position(time, thread, place)?;
                        places.remove(&thread);
                    } else {
                        places.insert(thread, (time, place));
                    }
                }
                Some(note) => self.note(note)?,
                None => break,
            }
        }
        for (thread, (time, place)) in places {
            match self.thread_positions.get_mut(&thread) {
                Some(known) if known.place == place => {
                    known.rounds = known.rounds.saturating_add(1);
                    if time - known.time > ROUNDS_PERIOD - 0.5 * self.step_time {
                        self.write_rounds(time, thread)?;
                    }
                }
                _ => self.update_position(time, thread, place)?,
            }
        }
        Ok(())
    }

    /// A thread is at another place than before.
    fn update_position(
        &mut self,
        time: f64,
        thread: (ProgramId, ThreadNumber),
        place: ThreadPosition,
    ) -> Result<(), McapError> {
        self.write_rounds(time, thread)?;
        self.write_position(time, thread, &place, None)?;
        let written = WrittenPosition {
            place,
            time,
            rounds: 0,
        };
        remember(&mut self.thread_positions, thread, written);
        Ok(())
    }

    /// Writes the rounds of a thread that have been counted since its last message.
    fn write_rounds(
        &mut self,
        time: f64,
        thread: (ProgramId, ThreadNumber),
    ) -> Result<(), McapError> {
        let Some(known) = self.thread_positions.get_mut(&thread) else {
            return Ok(());
        };
        if known.rounds == 0 {
            return Ok(());
        }
        known.time = time;
        let rounds = std::mem::take(&mut known.rounds);
        let place = known.place.clone();
        self.write_position(time, thread, &place, Some(rounds))
    }

    /// Writes the rounds of all threads.
    fn write_all_rounds(&mut self, time: f64) -> Result<(), McapError> {
        let counted = self
            .thread_positions
            .iter()
            .filter(|(_, known)| known.rounds > 0);
        let threads: Vec<_> = counted.map(|(thread, _)| *thread).collect();
        threads
            .into_iter()
            .try_for_each(|thread| self.write_rounds(time, thread))
    }

    fn note(&mut self, note: Annotation) -> Result<(), McapError> {
        match note {
            Annotation::ProgramStarted {
                time,
                program,
                name,
                text,
            } => {
                remember(&mut self.programs, program, name.into());
                let text = match self.allowance.allows_whole_text(time, text.len()) {
                    true => text,
                    false => truncate_marked(&text, SHORT_TEXT_BYTES).map_or(text, Into::into),
                };
                self.remember_text(program, text);
                self.text(time, program)
            }
            Annotation::ScriptLine {
                time,
                program,
                thread,
                place,
            } => self.write_position(time, (program, thread), &place, None),
            Annotation::Variable {
                time,
                program,
                name,
                type_name,
                value,
            } => {
                let message = VariableMessage {
                    program: self.programs.get(&program).cloned().unwrap_or_default(),
                    program_id: program.0,
                    name: name.into(),
                    type_name: type_name.into(),
                    value: value.into(),
                };
                self.file.json(Topic::Variables, time, &message)
            }
            Annotation::Log {
                time,
                level,
                source,
                message,
                chinese,
            } => {
                // The end of a program is such a message: what its threads did comes before.
                self.write_all_rounds(time)?;
                self.log(
                    time,
                    level,
                    &source,
                    &Text::recorded(message.into(), chinese.map(Into::into)),
                )
            }
            Annotation::Io { time, name, value } => {
                let (cycle, name) = (self.latest.map_or(0, |state| state.cycle), name.into());
                self.file
                    .json(Topic::Io, time, &IoMessage { cycle, name, value })
            }
            Annotation::Extra {
                time,
                topic,
                message,
            } => self.file.put_extra(topic, time, &message),
            Annotation::SceneBodies { bodies, .. } => {
                self.viewer.set_bodies(bodies);
                Ok(())
            }
        }
    }

    /// Keeps a text for the next part, and forgets the oldest ones.
    fn remember_text(&mut self, program: ProgramId, text: Box<str>) {
        self.texts.insert(program, text);
        while self.texts.len() > 1
            && (self.texts.len() > MAX_TEXTS
                || self.texts.values().map(|text| text.len()).sum::<usize>() > MAX_TEXT_BYTES)
        {
            self.texts.pop_first();
        }
    }

    fn text(&mut self, time: f64, program: ProgramId) -> Result<(), McapError> {
        let Some(text) = self.texts.get(&program) else {
            return Ok(());
        };
        let message = ProgramMessage {
            program: self.programs.get(&program).map_or("", String::as_str),
            program_id: program.0,
            text,
        };
        self.file.json(Topic::Script, time, &message)
    }

    fn write_position(
        &mut self,
        time: f64,
        (program, thread): (ProgramId, ThreadNumber),
        place: &ThreadPosition,
        rounds: Option<u32>,
    ) -> Result<(), McapError> {
        let (node, label) = place.node.clone().unzip();
        let message = ScriptMessage {
            program: self.program(program).to_owned(),
            program_id: program.0,
            text: None,
            thread: Some(thread.0),
            line: Some(place.line),
            rounds,
            node,
            label: label.map(Into::into),
        };
        self.file.json(Topic::Script, time, &message)
    }

    fn log(
        &mut self,
        time: f64,
        level: LogLevel,
        source: &str,
        message: &Text,
    ) -> Result<(), McapError> {
        let log = self.viewer.log(time, level, source, message);
        self.file.put(Topic::Log, time, log)
    }

    fn program(&self, program: ProgramId) -> &str {
        self.programs.get(&program).map_or("", String::as_str)
    }
}

/// [`ScriptMessage`] with a text, which may be long, borrowed.
#[derive(Serialize)]
struct ProgramMessage<'a> {
    program: &'a str,
    program_id: u32,
    text: &'a str,
}

/// How much of the texts of programs is recorded whole: a burst, then a rate. In simulated time, so that it is the same
/// in every run under the virtual clock; whoever sends large programs one after the other does not fill the disk with
/// them.
struct TextRateLimiter {
    tokens: f64,
    /// Time of the latest text, s.
    since: f64,
}

impl Default for TextRateLimiter {
    fn default() -> Self {
        Self {
            tokens: Self::BURST_BYTES,
            since: 0.0,
        }
    }
}

impl TextRateLimiter {
    const BURST_BYTES: f64 = 64.0 * 1024.0 * 1024.0;
    const BYTES_PER_SEC: f64 = 256.0 * 1024.0;

    /// Whether a text of so many bytes is recorded whole at this time. Short ones always are.
    fn allows_whole_text(&mut self, time: f64, bytes: usize) -> bool {
        let passed = (time - self.since).max(0.0);
        self.since = self.since.max(time);
        self.tokens = (self.tokens + passed * Self::BYTES_PER_SEC).min(Self::BURST_BYTES);
        if bytes <= SHORT_TEXT_BYTES {
            return true;
        }
        let is_taken = bytes as f64 <= self.tokens;
        if is_taken {
            self.tokens -= bytes as f64;
        }
        is_taken
    }
}

/// Inserts; when there are too many entries, the one with the smallest (oldest) key makes room.
fn remember<K: Ord, V>(map: &mut BTreeMap<K, V>, key: K, value: V) {
    map.insert(key, value);
    if map.len() > MAX_REMEMBERED {
        map.pop_first();
    }
}
