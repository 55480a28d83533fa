//! Records and messages in, MCAP bytes out. No thread, no file name, no wall clock: the recorder thread drives it.
//!
//! Time stamps are the epoch of the setup plus simulated time. A chunk is closed before it grows past [`CHUNK_BYTES`]
//! and when it spans [`CHUNK_SECS`], so that a kill loses little; with the same records and messages in the same order
//! the file is the same, byte for byte.

use std::collections::{BTreeMap, VecDeque};
use std::io::Write;

use foxglove::messages::{Log, Timestamp};
use kinematics::RobotModel;
use mcap::McapError;
use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use motion_api::{Command, ProgramId, Record, RegisterImages, RobotState, ThreadNumber};
use prost::Message as _;
use serde::Serialize;

use crate::cycle::Cycle;
use crate::io_changes;
use crate::setup::{METADATA_NAME, Setup};
use crate::topics::{
    CommandMessage, IoMessage, IoValue, LogLevel, ScriptMessage, Topic, VariableMessage,
};
use crate::viewer::Viewer;

/// Uncompressed size that a chunk of small messages does not exceed. A larger message has a chunk of its own.
pub const CHUNK_BYTES: usize = 128 * 1024;
/// Simulated time that a chunk does not exceed, s.
pub const CHUNK_SECS: f64 = 0.25;
/// The viewers' topics have at least one message in this time, s: the rate of a screen, and above the promised 50 Hz.
const VIEW_PERIOD: f64 = 0.016;
/// The arm is drawn again after this time, s, for viewers that seek into the file.
const SCENE_PERIOD: f64 = 10.0;
/// How many programs, and lines of how many script threads, are remembered.
const MAX_REMEMBERED: usize = 1024;
/// How many of the latest programs have their text repeated in the next part.
const MAX_TEXTS: usize = 4;
/// Messages that may wait for their place between the cycles; one more is written out of order.
pub(crate) const MAX_WAITING: usize = 16 * 1024;
/// Bytes that MCAP adds to a message: opcode, length, header.
const MESSAGE_OVERHEAD: usize = 1 + 8 + 22;

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
    mcap: mcap::Writer<NoSeek<W>>,
    channels: [u16; Topic::ALL.len()],
    sequences: [u32; Topic::ALL.len()],
    epoch_ns: u64,
    step_time: f64,
    viewer: Viewer,
    chunk: Option<OpenChunk>,
    /// Chunks begun so far.
    chunks: u64,
    /// Encoded message, reused.
    buffer: Vec<u8>,
    /// The message of the current cycle, reused.
    cycle: Cycle,
    /// The latest cycle written.
    latest: Option<RobotState>,
    /// The registers as the latest cycle began with them.
    registers: RegisterImages,
    /// Cycle from which on the viewers' topics are due.
    view_due: u64,
    /// Simulated time from which on the arm is drawn again, s.
    scene_due: f64,
    programs: BTreeMap<ProgramId, String>,
    /// Texts of the latest programs.
    texts: BTreeMap<ProgramId, String>,
    /// The line that was last written for a script thread.
    lines: BTreeMap<(ProgramId, ThreadNumber), u32>,
    totals: Totals,
}

struct OpenChunk {
    number: u64,
    bytes: usize,
    /// Time of its first message, s.
    since: f64,
}

impl<W: Write> RecordWriter<W> {
    /// Writes the start of the file: setup, schemas, the arm. All of it has reached `out` when this returns, so an
    /// output that cannot be written is found here.
    pub(crate) fn start(out: W, setup: &Setup, model: RobotModel) -> Result<Self, McapError> {
        let mut writer = Self::begin(out, setup, Viewer::new(model))?;
        writer.scene(0.0)?;
        writer.close_chunk()?;
        Ok(writer)
    }

    fn begin(out: W, setup: &Setup, viewer: Viewer) -> Result<Self, McapError> {
        let mut mcap = mcap::WriteOptions::new()
            .library(concat!("eliteserver ", env!("CARGO_PKG_VERSION")))
            .compression(Some(mcap::Compression::Zstd))
            .compression_level(1)
            // The recorder has its own thread; more of them would take time from the motion thread.
            .compression_threads(0)
            // Chunks are closed here, by size and time.
            .chunk_size(None)
            // Whole chunks are built in memory and appended: works on any output, and a kill leaves no half header.
            .disable_seeking(true)
            .create(NoSeek::new(out))?;
        mcap.write_metadata(&Metadata {
            name: METADATA_NAME.to_owned(),
            metadata: setup.to_map(),
        })?;
        let mut channels = [0; Topic::ALL.len()];
        for topic in Topic::ALL {
            let schema = topic.schema();
            let id = mcap.add_schema(&schema.name, schema.encoding, &schema.data)?;
            let none = BTreeMap::new();
            channels[topic.index()] =
                mcap.add_channel(id, topic.name(), topic.message_encoding(), &none)?;
        }
        Ok(Self {
            mcap,
            channels,
            sequences: [0; Topic::ALL.len()],
            epoch_ns: setup.epoch_ns,
            step_time: setup.step_time,
            viewer,
            chunk: None,
            chunks: 0,
            buffer: Vec::new(),
            cycle: Cycle::default(),
            latest: None,
            registers: RegisterImages::default(),
            view_due: 0,
            scene_due: SCENE_PERIOD,
            programs: BTreeMap::new(),
            texts: BTreeMap::new(),
            lines: BTreeMap::new(),
            totals: Totals::default(),
        })
    }

    /// Ends this file and goes on in `out`, which is the part that `setup` says. What was going on is told again: the
    /// arm, the latest programs, the line of every thread. The old output comes back complete.
    pub(crate) fn go_on_in(self, out: W, setup: &Setup) -> Result<(Self, W), McapError> {
        let mut next = Self::begin(out, setup, self.viewer.clone())?;
        next.step_time = self.step_time;
        next.latest = self.latest;
        next.registers = self.registers;
        next.view_due = self.view_due;
        next.chunks = self.chunks;
        next.totals = self.totals;
        next.programs = self.programs.clone();
        next.texts = self.texts.clone();
        next.lines = self.lines.clone();
        let time = self.latest.map_or(0.0, |state| state.time);
        next.scene_due = time + SCENE_PERIOD;
        next.scene(time)?;
        for program in self.texts.keys() {
            next.text(time, *program)?;
        }
        for (thread, line) in &self.lines {
            if self.texts.contains_key(&thread.0) {
                next.line(time, *thread, *line)?;
            }
        }
        next.close_chunk()?;
        Ok((next, self.finish()?.0))
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
                    self.json(Topic::Io, begin, &change)?;
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
        self.chunk.as_ref().map(|chunk| chunk.number)
    }

    /// Hands everything to the output.
    pub(crate) fn close_chunk(&mut self) -> Result<(), McapError> {
        self.chunk = None;
        self.mcap.flush()
    }

    /// Writes the index and the end of the file, and gives the output back.
    pub(crate) fn finish(mut self) -> Result<(W, Totals), McapError> {
        self.mcap.finish()?;
        let mut out = self.mcap.into_inner().into_inner();
        out.flush()?;
        Ok((out, self.totals))
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
        self.encode_cycle(state.time)?;
        self.totals.cycles += 1;
        for change in io_changes::between(self.latest.as_ref(), state) {
            self.json(Topic::Io, state.time, &change)?;
        }
        if state.cycle >= self.view_due {
            let cycles = (VIEW_PERIOD / state.step_time + 1e-9).floor().max(1.0);
            self.view_due = state.cycle.saturating_add(cycles as u64);
            self.view(state)?;
        }
        if state.time >= self.scene_due {
            self.scene_due = state.time + SCENE_PERIOD;
            self.scene(state.time)?;
        }
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

    fn view(&mut self, state: &RobotState) -> Result<(), McapError> {
        let at = self.timestamp(state.time);
        let joints = self.viewer.joint_states(state, at);
        self.protobuf(Topic::JointStates, state.time, &joints)?;
        let frames = self.viewer.frames(state, at);
        self.protobuf(Topic::Tf, state.time, &frames)?;
        let tcp = self.viewer.tcp(state, at);
        self.protobuf(Topic::Tcp, state.time, &tcp)
    }

    fn scene(&mut self, time: f64) -> Result<(), McapError> {
        let scene = self.viewer.scene(self.timestamp(time));
        self.protobuf(Topic::Scene, time, &scene)
    }

    fn command(&mut self, time: f64, cycle: u64, command: &Command) -> Result<(), McapError> {
        self.totals.commands += 1;
        let program = self.program(command.origin.program);
        let message = CommandMessage::new(cycle, command, program);
        self.json(Topic::Command, time, &message)
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
                self.json(Topic::Variables, time, &message)
            }
            Note::Log {
                time,
                level,
                source,
                message,
            } => self.log(time, level, &source, &message),
            Note::Io { time, name, value } => {
                let cycle = self.latest.map_or(0, |state| state.cycle);
                self.json(Topic::Io, time, &IoMessage { cycle, name, value })
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
        self.json(Topic::Script, time, &message)
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
        self.json(Topic::Script, time, &message)
    }

    fn log(
        &mut self,
        time: f64,
        level: LogLevel,
        source: &str,
        message: &str,
    ) -> Result<(), McapError> {
        let log = Log {
            timestamp: Some(self.timestamp(time)),
            level: level.number(),
            message: message.to_owned(),
            name: source.to_owned(),
            ..Log::default()
        };
        self.protobuf(Topic::Log, time, &log)
    }

    fn program(&self, program: ProgramId) -> &str {
        self.programs.get(&program).map_or("", String::as_str)
    }

    fn timestamp(&self, time: f64) -> Timestamp {
        let ns = self.nanos(time);
        let secs = u32::try_from(ns / 1_000_000_000).unwrap_or(u32::MAX);
        Timestamp::new(secs, (ns % 1_000_000_000) as u32)
    }

    /// Time stamp in the file. NaN and negative times count as the start; `as` saturates.
    fn nanos(&self, time: f64) -> u64 {
        self.epoch_ns.saturating_add((time * 1e9).round() as u64)
    }

    fn encode_cycle(&mut self, time: f64) -> Result<(), McapError> {
        let mut buffer = std::mem::take(&mut self.buffer);
        buffer.clear();
        self.cycle.encode_raw(&mut buffer);
        self.put(Topic::Cycle, time, buffer)
    }

    fn protobuf(
        &mut self,
        topic: Topic,
        time: f64,
        message: &impl prost::Message,
    ) -> Result<(), McapError> {
        let mut buffer = std::mem::take(&mut self.buffer);
        buffer.clear();
        message.encode_raw(&mut buffer);
        self.put(topic, time, buffer)
    }

    fn json(&mut self, topic: Topic, time: f64, message: &impl Serialize) -> Result<(), McapError> {
        let mut buffer = std::mem::take(&mut self.buffer);
        buffer.clear();
        serde_json::to_writer(&mut buffer, message).map_err(std::io::Error::from)?;
        self.put(topic, time, buffer)
    }

    fn put(&mut self, topic: Topic, time: f64, data: Vec<u8>) -> Result<(), McapError> {
        let size = data.len() + MESSAGE_OVERHEAD;
        if self.chunk.as_ref().is_some_and(|chunk| {
            chunk.bytes + size > CHUNK_BYTES || time - chunk.since >= CHUNK_SECS
        }) {
            self.close_chunk()?;
        }
        let chunks = &mut self.chunks;
        let chunk = self.chunk.get_or_insert_with(|| {
            *chunks += 1;
            OpenChunk {
                number: *chunks,
                bytes: 0,
                since: time,
            }
        });
        chunk.bytes += size;
        let log_time = self.nanos(time);
        let sequence = &mut self.sequences[topic.index()];
        let header = MessageHeader {
            channel_id: self.channels[topic.index()],
            sequence: *sequence,
            log_time,
            publish_time: log_time,
        };
        *sequence = sequence.wrapping_add(1);
        let result = self.mcap.write_to_known_channel(&header, &data);
        self.buffer = data;
        result
    }
}

/// Inserts; when there are too many entries, the one with the smallest (oldest) key makes room.
fn remember<K: Ord, V>(map: &mut BTreeMap<K, V>, key: K, value: V) {
    map.insert(key, value);
    if map.len() > MAX_REMEMBERED {
        map.pop_first();
    }
}
