//! The script side's end of a recording, and its figures.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{SyncSender, TrySendError};

use motion_api::{ProgramId, ThreadNumber};

use crate::topics::{IoValue, LogLevel};
use crate::writer::Note;

/// The script side's end: adds programs, lines, messages and registers to the recording. Clones share one channel.
///
/// Times are simulated seconds since start, those of the latest cycle.
#[derive(Clone)]
pub struct RecorderHandle {
    notes: Option<SyncSender<Note>>,
    wait: bool,
    shared: Arc<Shared>,
}

impl RecorderHandle {
    pub(crate) fn new(notes: SyncSender<Note>, wait: bool, shared: Arc<Shared>) -> Self {
        Self {
            notes: Some(notes),
            wait,
            shared,
        }
    }

    /// A handle without a recording: everything is accepted and forgotten.
    pub fn off() -> Self {
        Self {
            notes: None,
            wait: false,
            shared: Arc::default(),
        }
    }

    /// A program starts. Call it before the program's first command.
    pub fn program_started(
        &self,
        time: f64,
        program: ProgramId,
        name: impl Into<String>,
        text: impl Into<String>,
    ) {
        self.send(|| Note::ProgramStarted {
            time,
            program,
            name: name.into(),
            text: text.into(),
        });
    }

    /// A script thread is in this line. Meant to be called where the thread waits or yields; of several lines within
    /// one cycle the last is recorded, and only if it is another than before.
    pub fn script_line(&self, time: f64, program: ProgramId, thread: ThreadNumber, line: u32) {
        self.send(|| Note::ScriptLine {
            time,
            program,
            thread,
            line,
        });
    }

    /// A global variable of a program has this value now, as people read it.
    pub fn variable(
        &self,
        time: f64,
        program: ProgramId,
        name: &str,
        type_name: &str,
        value: &str,
    ) {
        self.send(|| Note::Variable {
            time,
            program,
            name: name.to_owned(),
            type_name: type_name.to_owned(),
            value: value.to_owned(),
        });
    }

    /// A message for people. `source` is the part of the controller, or the program, that says it.
    pub fn log(
        &self,
        time: f64,
        level: LogLevel,
        source: impl Into<String>,
        message: impl Into<String>,
    ) {
        self.send(|| Note::Log {
            time,
            level,
            source: source.into(),
            message: message.into(),
        });
    }

    /// A register has another value; `name` as in a cell file, `output_integer_register[2]` for instance. Digital and
    /// analog points need no call: they are in the cycles.
    pub fn io(&self, time: f64, name: impl Into<String>, value: IoValue) {
        self.send(|| Note::Io {
            time,
            name: name.into(),
            value,
        });
    }

    /// Notes that were dropped because the recorder did not keep up (only without `notes_wait`).
    pub fn notes_dropped(&self) -> u64 {
        self.shared.notes_dropped.load(Ordering::Relaxed)
    }

    fn send(&self, note: impl FnOnce() -> Note) {
        let Some(notes) = &self.notes else { return };
        if self.shared.failed.load(Ordering::Relaxed) {
            return;
        }
        // A closed channel means that the recording is finished: there is nothing left to add to.
        if self.wait {
            let _ = notes.send(note());
        } else if let Err(TrySendError::Full(_)) = notes.try_send(note()) {
            self.shared.notes_dropped.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// What the thread and the ends outside tell each other.
#[derive(Default)]
pub(crate) struct Shared {
    /// Ask the thread to finish.
    pub finish: AtomicBool,
    /// The output can no longer be written.
    pub failed: AtomicBool,
    pub notes_dropped: AtomicU64,
    /// Bytes written, all parts together.
    pub bytes: AtomicU64,
    /// Records that waited in the ring when the thread last looked.
    pub records_waiting: AtomicU64,
    /// Cycles written.
    pub cycles: AtomicU64,
}

/// Figures of a recording. Clones tell the same.
#[derive(Clone)]
pub struct RecorderMeter {
    shared: Arc<Shared>,
}

impl RecorderMeter {
    pub(crate) fn new(shared: Arc<Shared>) -> Self {
        Self { shared }
    }

    /// Bytes written, all parts together.
    pub fn bytes(&self) -> u64 {
        self.shared.bytes.load(Ordering::Relaxed)
    }

    /// Cycles written.
    pub fn cycles(&self) -> u64 {
        self.shared.cycles.load(Ordering::Relaxed)
    }

    /// Records that waited in the ring when the thread last looked.
    pub fn records_waiting(&self) -> u64 {
        self.shared.records_waiting.load(Ordering::Relaxed)
    }

    /// Messages of programs that were dropped because the recording did not keep up.
    pub fn notes_dropped(&self) -> u64 {
        self.shared.notes_dropped.load(Ordering::Relaxed)
    }

    /// Whether recording has stopped because the output cannot be written.
    pub fn has_failed(&self) -> bool {
        self.shared.failed.load(Ordering::Acquire)
    }
}
