//! The script side's end of a recording, and its figures.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use messages::Text;
use motion_api::{ProgramId, ThreadNumber};

use crate::extra::CustomTopicId;
use crate::lengths::{
    EXTRA_BYTES, MESSAGE_BYTES, NAME_BYTES, PROGRAM_TEXT_BYTES, VALUE_BYTES, truncate_marked,
};
use crate::notes::{Annotation, AnnotationQueue, ThreadPosition};
use crate::topics::{IoValue, LogLevel};
use crate::viewer::SceneBody;

/// The script side's end: adds programs, lines, messages and registers to the recording. Clones share one channel.
///
/// Times are simulated seconds since start, those of the latest cycle. Texts that are longer than
/// [`lengths`](crate::lengths) allows are cut.
#[derive(Clone)]
pub struct RecorderHandle {
    notes: Option<Arc<AnnotationQueue>>,
    wait: bool,
    shared: Arc<RecorderState>,
}

impl RecorderHandle {
    pub(crate) fn new(notes: Arc<AnnotationQueue>, wait: bool, shared: Arc<RecorderState>) -> Self {
        Self {
            notes: Some(notes),
            wait,
            shared,
        }
    }

    /// A handle without a recording: everything is accepted and forgotten.
    pub fn disabled() -> Self {
        Self {
            notes: None,
            wait: false,
            shared: Arc::default(),
        }
    }

    /// A program starts. Call it before the program's first command.
    pub fn program_started(&self, time: f64, program: ProgramId, name: &str, text: &str) {
        self.send(|| Annotation::ProgramStarted {
            time,
            program,
            name: self.truncated_text(name, NAME_BYTES),
            text: self.truncated_text(text, PROGRAM_TEXT_BYTES),
        });
    }

    /// A script thread is in this line. Meant to be called where the thread waits or yields; of several lines within
    /// one cycle the last is recorded. The same line again is another round of a loop: rounds are counted, and
    /// recorded at least once a second.
    pub fn script_line(&self, time: f64, program: ProgramId, thread: ThreadNumber, line: u32) {
        self.script_position(time, (program, thread), line, None);
    }

    /// A script thread is in this line and, where the pendant made the program of a task, in the node with this number
    /// and label. Every change of node is recorded, however many there are in one cycle.
    pub fn script_position(
        &self,
        time: f64,
        (program, thread): (ProgramId, ThreadNumber),
        line: u32,
        node: Option<(u32, &str)>,
    ) {
        self.send(|| {
            let node = node.map(|(number, label)| (number, self.truncated_text(label, NAME_BYTES)));
            Annotation::ScriptLine {
                time,
                program,
                thread,
                place: ThreadPosition { line, node },
            }
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
        self.send(|| Annotation::Variable {
            time,
            program,
            name: self.truncated_text(name, NAME_BYTES),
            type_name: self.truncated_text(type_name, NAME_BYTES),
            value: self.truncated_text(value, VALUE_BYTES),
        });
    }

    /// A message for people. `source` is the part of the controller, or the program, that says it.
    pub fn log(&self, time: f64, level: LogLevel, source: &str, message: &Text) {
        self.send(|| Annotation::Log {
            time,
            level,
            source: self.truncated_text(source, NAME_BYTES),
            message: self.truncated_text(message.english(), MESSAGE_BYTES),
            chinese: message.other_chinese().map(|chinese| {
                truncate_marked(chinese, MESSAGE_BYTES).map_or_else(|| chinese.into(), Into::into)
            }),
        });
    }

    /// A register has another value; `name` as in a cell file, `output_integer_register[2]` for instance. Digital and
    /// analog points need no call: they are in the cycles.
    pub fn io(&self, time: f64, name: &str, value: IoValue) {
        self.send(|| Annotation::Io {
            time,
            name: self.truncated_text(name, NAME_BYTES),
            value,
        });
    }

    /// A message of a topic that is not ours, encoded as the topic says. One for a topic that the recording was not
    /// begun with, or of more than [`EXTRA_BYTES`](crate::lengths::EXTRA_BYTES), is left out and counted.
    pub fn extra(&self, time: f64, topic: CustomTopicId, message: Vec<u8>) {
        if message.len() > EXTRA_BYTES {
            self.shared.notes_dropped.fetch_add(1, Ordering::Relaxed);
            return;
        }
        self.send(|| Annotation::Extra {
            time,
            topic,
            message: message.into(),
        });
    }

    /// What viewers draw beside the arm and the obstacles is this from now on, until the next call.
    pub fn scene_bodies(&self, time: f64, bodies: Arc<[SceneBody]>) {
        self.send(|| Annotation::SceneBodies { time, bodies });
    }

    /// Somebody wants a program to end or to be held at once: who waits for room goes on without, the note being
    /// dropped and counted. In force until there is room again.
    pub fn suspend_backpressure(&self) {
        if let Some(notes) = &self.notes {
            notes.suspend_backpressure();
        }
    }

    /// Notes that were dropped because the recorder did not keep up (only without `notes_wait`).
    pub fn notes_dropped(&self) -> u64 {
        self.shared.notes_dropped.load(Ordering::Relaxed)
    }

    fn send(&self, note: impl FnOnce() -> Annotation) {
        let Some(notes) = &self.notes else { return };
        if self.shared.failed.load(Ordering::Relaxed) {
            return;
        }
        if notes.send(note(), self.wait).is_err() {
            self.shared.notes_dropped.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn truncated_text(&self, text: &str, most: usize) -> Box<str> {
        match truncate_marked(text, most) {
            None => text.into(),
            Some(short) => {
                self.shared.texts_cut.fetch_add(1, Ordering::Relaxed);
                short.into()
            }
        }
    }
}

/// What the thread and the ends outside tell each other.
#[derive(Default)]
pub(crate) struct RecorderState {
    /// Ask the thread to finish.
    pub finish: AtomicBool,
    /// The output can no longer be written.
    pub failed: AtomicBool,
    /// Nobody waits for the thread any more: what it has is the end of the recording.
    pub is_abandoned: AtomicBool,
    /// Goes up while the thread gets on.
    pub progress_count: AtomicU64,
    pub notes_dropped: AtomicU64,
    /// Texts that were too long.
    pub texts_cut: AtomicU64,
    /// Bytes written, all parts together.
    pub bytes: AtomicU64,
    /// Records that waited in the ring when the thread last looked.
    pub records_waiting: AtomicU64,
    /// Cycles written.
    pub cycles: AtomicU64,
}

/// Figures of a recording. Clones tell the same.
#[derive(Clone)]
pub struct RecorderMetrics {
    shared: Arc<RecorderState>,
    notes: Arc<AnnotationQueue>,
}

impl RecorderMetrics {
    pub(crate) fn new(shared: Arc<RecorderState>, notes: Arc<AnnotationQueue>) -> Self {
        Self { shared, notes }
    }

    /// Bytes of messages of programs that wait to be written.
    pub fn bytes_waiting(&self) -> u64 {
        self.notes.bytes() as u64
    }

    /// Texts that were too long and were cut.
    pub fn texts_cut(&self) -> u64 {
        self.shared.texts_cut.load(Ordering::Relaxed)
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
