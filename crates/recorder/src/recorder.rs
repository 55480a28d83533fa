//! The recorder's thread, and the ends through which the rest of the controller talks to it.
//!
//! The thread takes records from the motion thread's ring every few milliseconds and notes of the script side from a
//! bounded channel, puts them into one order and writes them. The motion thread never waits for it under the real
//! clock (it counts what did not fit); under the virtual clock the caller of the cycle waits for room in the ring, and
//! a script waits for room in the channel, so nothing is lost.
//!
//! When the output can no longer be written, recording stops: the failure is reported once, the ring and the channel
//! go on being emptied, and the robot goes on.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use kinematics::RobotModel;
use mcap::McapError;
use motion_api::{ProgramId, RecordReader, ThreadNumber};
use thiserror::Error;

use crate::rotation::{Parts, Rotation};
use crate::setup::Setup;
use crate::topics::{IoValue, LogLevel};
use crate::writer::{MAX_WAITING, Note, RecordWriter, Totals};

/// How long the thread sleeps when there is nothing to do. The ring holds thousands of cycles.
const POLL: Duration = Duration::from_millis(2);
/// What has been recorded is handed to the operating system after this much wall time at the latest.
const FLUSH_AFTER: Duration = Duration::from_millis(250);
/// Notes that may wait for the thread.
const NOTES: usize = 4096;
/// Records taken without looking at anything else, so that a fast producer cannot keep the thread from its other work.
const BATCH: usize = 1024;

/// What to record into, and about which arm.
pub struct RecorderConfig {
    /// The file. Missing directories are made; an existing file is replaced.
    pub path: PathBuf,
    /// How the controller was started.
    pub setup: Setup,
    /// The arm, for the viewers' topics.
    pub model: RobotModel,
    /// When the next file begins, and how much may be kept.
    pub rotation: Rotation,
    /// What a script does that outruns the recorder: wait (virtual clock) or go on, the note being dropped and counted
    /// (real clock).
    pub notes_wait: bool,
    /// Called once, from the recorder's thread, when the output can no longer be written: raise an alarm.
    pub on_failure: FailureReport,
}

/// Told that the recording has stopped, and why.
pub type FailureReport = Box<dyn FnOnce(&RecordError) + Send>;

/// Why there is no recording, or no more.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RecordError {
    /// The file or its directory cannot be made.
    #[error("cannot create the recording {}: {source}", path.display())]
    Create {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The file cannot be written.
    #[error("cannot write the recording {}: {}", path.display(), reason(source))]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: Arc<McapError>,
    },
    /// The thread cannot be started.
    #[error("cannot start the recorder's thread: {0}")]
    Thread(io::Error),
    /// The thread has ended by a panic. A bug of ours.
    #[error("the recorder's thread has ended unexpectedly; the recording is not complete")]
    Ended,
}

/// The operating system's words where there are any: "No space left on device".
fn reason(error: &McapError) -> String {
    match error {
        McapError::Io(error) => error.to_string(),
        other => other.to_string(),
    }
}

/// A running recording. Dropping it finishes the file as [`finish`](Self::finish) does, with errors only logged.
pub struct Recorder {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<Result<Totals, RecordError>>>,
}

/// The script side's end: adds programs, lines, messages and registers to the recording. Clones share one channel.
///
/// Times are simulated seconds since start, those of the latest cycle.
#[derive(Clone)]
pub struct RecorderHandle {
    notes: Option<SyncSender<Note>>,
    wait: bool,
    shared: Arc<Shared>,
}

#[derive(Default)]
struct Shared {
    /// Ask the thread to finish.
    finish: AtomicBool,
    /// The output can no longer be written.
    failed: AtomicBool,
    notes_dropped: AtomicU64,
}

impl Recorder {
    /// Makes the file, writes its beginning and starts the thread.
    ///
    /// # Errors
    /// [`RecordError`] when the file cannot be made or written, or the thread not started.
    pub fn start(
        config: RecorderConfig,
        records: RecordReader,
    ) -> Result<(Self, RecorderHandle), RecordError> {
        let file = create(&config.path).map_err(|source| RecordError::Create {
            path: config.path.clone(),
            source,
        })?;
        Self::start_on(file, config, records)
    }

    /// As [`start`](Self::start), but into any output; `config.path` is only its name in messages.
    ///
    /// # Errors
    /// [`RecordError`] when the output cannot be written or the thread not started.
    pub fn start_on(
        out: impl Write + Send + 'static,
        config: RecorderConfig,
        records: RecordReader,
    ) -> Result<(Self, RecorderHandle), RecordError> {
        let RecorderConfig {
            path,
            setup,
            model,
            rotation,
            notes_wait,
            on_failure,
        } = config;
        let (out, bytes) = Counted::new(out);
        let writer =
            RecordWriter::start(out, &setup, model).map_err(|source| RecordError::Write {
                path: path.clone(),
                source: Arc::new(source),
            })?;
        let parts = Parts::new(path, rotation);
        let (sender, notes) = sync_channel(NOTES);
        let shared = Arc::new(Shared::default());
        let worker = Worker {
            writer: Ok(writer),
            records,
            notes,
            waiting: VecDeque::new(),
            shared: Arc::clone(&shared),
            parts,
            bytes,
            setup,
            on_failure: Some(on_failure),
            dropped_before: 0,
            unflushed: None,
        };
        let thread = std::thread::Builder::new()
            .name("recorder".to_owned())
            .spawn(move || worker.run())
            .map_err(RecordError::Thread)?;
        let handle = RecorderHandle {
            notes: Some(sender),
            wait: notes_wait,
            shared: Arc::clone(&shared),
        };
        let recorder = Self {
            shared,
            thread: Some(thread),
        };
        Ok((recorder, handle))
    }

    /// Whether recording has stopped because the output cannot be written.
    pub fn has_failed(&self) -> bool {
        self.shared.failed.load(Ordering::Acquire)
    }

    /// Takes what is in the ring and the channel by now, writes the index and closes the file.
    ///
    /// # Errors
    /// [`RecordError`] when the recording could not be written to its end.
    pub fn finish(mut self) -> Result<Totals, RecordError> {
        self.join()
    }

    fn join(&mut self) -> Result<Totals, RecordError> {
        self.shared.finish.store(true, Ordering::Release);
        let thread = self.thread.take().ok_or(RecordError::Ended)?;
        thread.join().map_err(|_| RecordError::Ended)?
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        if self.thread.is_some()
            && let Err(error) = self.join()
        {
            tracing::error!("{error}");
        }
    }
}

impl RecorderHandle {
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

fn create(path: &Path) -> io::Result<File> {
    if let Some(parent) = path.parent().filter(|p| !p.as_os_str().is_empty()) {
        std::fs::create_dir_all(parent)?;
    }
    File::create(path)
}

/// An output that knows how much went into it.
struct Counted {
    out: BufWriter<Box<dyn Write + Send>>,
    bytes: Arc<AtomicU64>,
}

impl Counted {
    fn new(out: impl Write + Send + 'static) -> (Self, Arc<AtomicU64>) {
        let bytes = Arc::new(AtomicU64::new(0));
        // One write a chunk: a kill leaves whole chunks.
        let out = BufWriter::with_capacity(2 * crate::writer::CHUNK_BYTES, Box::new(out) as _);
        let counted = Self {
            out,
            bytes: Arc::clone(&bytes),
        };
        (counted, bytes)
    }
}

impl Write for Counted {
    fn write(&mut self, data: &[u8]) -> io::Result<usize> {
        let written = self.out.write(data)?;
        self.bytes.fetch_add(written as u64, Ordering::Relaxed);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// What the thread owns.
struct Worker {
    /// The writer, or why there is none any more.
    writer: Result<RecordWriter<Counted>, Arc<McapError>>,
    records: RecordReader,
    notes: Receiver<Note>,
    /// Notes that wait for the record they come before.
    waiting: VecDeque<Note>,
    shared: Arc<Shared>,
    parts: Parts,
    /// Bytes of the part being written.
    bytes: Arc<AtomicU64>,
    setup: Setup,
    on_failure: Option<FailureReport>,
    dropped_before: u64,
    /// The open chunk, and since when it has been seen open.
    unflushed: Option<(Option<u64>, Instant)>,
}

impl Worker {
    fn run(mut self) -> Result<Totals, RecordError> {
        loop {
            // Read before the ring is emptied: what was pushed before the request is then certainly taken.
            let finish = self.shared.finish.load(Ordering::Acquire);
            let taken = self.take_records();
            self.flush_if_due(taken);
            self.rotate_if_due();
            let idle = taken < BATCH;
            if finish && idle {
                return self.close();
            }
            if idle {
                self.sleep();
            }
        }
    }

    /// Takes up to a batch of records from the ring; returns how many.
    fn take_records(&mut self) -> usize {
        for taken in 0..BATCH {
            let Some(record) = self.records.next_record() else {
                return taken;
            };
            // After the record was taken: everything a script noted before this cycle ran is in the channel.
            self.take_notes();
            let mut waiting = std::mem::take(&mut self.waiting);
            self.write(|writer| writer.record(&record, &mut waiting));
            self.waiting = waiting;
        }
        BATCH
    }

    fn take_notes(&mut self) {
        if self.writer.is_err() {
            self.waiting.clear();
        }
        while self.waiting.len() <= MAX_WAITING {
            let Ok(note) = self.notes.try_recv() else {
                return;
            };
            self.waiting.push_back(note);
        }
    }

    /// Does something with the writer, if there still is one; the first failure ends the recording.
    fn write(&mut self, act: impl FnOnce(&mut RecordWriter<Counted>) -> Result<(), McapError>) {
        if let Ok(writer) = &mut self.writer
            && let Err(error) = act(writer)
        {
            self.fail(error);
        }
    }

    fn fail(&mut self, error: impl Into<Arc<McapError>>) {
        let source = error.into();
        let error = RecordError::Write {
            path: self.parts.path(),
            source: Arc::clone(&source),
        };
        self.writer = Err(source);
        self.shared.failed.store(true, Ordering::Release);
        tracing::error!("{error}; recording has stopped, the robot goes on");
        if let Some(report) = self.on_failure.take() {
            report(&error);
        }
    }

    /// Under a clock that stands still, and when cycles are slow, nothing stays in memory for long. Where simulated time
    /// runs as fast as wall time or faster, the writer closes its chunks before this does, at reproducible places.
    fn flush_if_due(&mut self, taken: usize) {
        if taken == 0 {
            self.take_notes();
        }
        let chunk = self.writer.as_ref().ok().and_then(RecordWriter::open_chunk);
        if chunk.is_none() && self.waiting.is_empty() {
            self.unflushed = None;
            return;
        }
        let now = Instant::now();
        let since = match self.unflushed {
            Some((same, since)) if same == chunk => since,
            _ => now,
        };
        self.unflushed = Some((chunk, since));
        if now.duration_since(since) < FLUSH_AFTER {
            return;
        }
        self.unflushed = None;
        self.note_dropped();
        // While cycles come, notes keep their place between them.
        if taken == 0 {
            let mut waiting = std::mem::take(&mut self.waiting);
            self.write(|writer| writer.notes(&mut waiting));
        }
        self.write(RecordWriter::close_chunk);
    }

    /// Begins the next part when this one is long enough. When its file cannot be made, this one goes on.
    fn rotate_if_due(&mut self) {
        let Ok(writer) = &self.writer else { return };
        let time = writer.time();
        let bytes = self.bytes.load(Ordering::Relaxed);
        for (path, error) in self.parts.keep_budget(bytes) {
            tracing::warn!(
                "cannot remove the old recording {}: {error}",
                path.display()
            );
        }
        if !self.parts.is_due(bytes, time) {
            return;
        }
        let (file, number) = match self.parts.create_next() {
            Ok(next) => next,
            Err(error) => {
                // Asked again when this part has become twice, four times … as long.
                tracing::warn!("cannot begin the next part of the recording: {error}");
                self.parts.put_off();
                return;
            }
        };
        let (out, count) = Counted::new(file);
        self.setup.part = number;
        let ended = Err(Arc::new(McapError::UnexpectedEof));
        let writer = std::mem::replace(&mut self.writer, ended);
        let result = writer.and_then(|writer| Ok(writer.go_on_in(out, &self.setup)?));
        match result {
            Ok((writer, _)) => {
                self.writer = Ok(writer);
                self.parts.begun(self.bytes.load(Ordering::Relaxed), time);
                self.bytes = count;
            }
            Err(error) => self.fail(error),
        }
    }

    /// Says in the recording that notes are missing.
    fn note_dropped(&mut self) {
        let dropped = self.shared.notes_dropped.load(Ordering::Relaxed);
        if dropped > self.dropped_before {
            let count = dropped - self.dropped_before;
            self.dropped_before = dropped;
            self.write(|writer| writer.dropped(count));
        }
    }

    fn sleep(&mut self) {
        if self.waiting.len() > MAX_WAITING {
            std::thread::sleep(POLL);
            return;
        }
        match self.notes.recv_timeout(POLL) {
            Ok(note) => self.waiting.push_back(note),
            Err(RecvTimeoutError::Timeout) => {}
            // No handle is left; only the ring matters now.
            Err(RecvTimeoutError::Disconnected) => std::thread::sleep(POLL),
        }
    }

    fn close(mut self) -> Result<Totals, RecordError> {
        self.take_notes();
        self.note_dropped();
        let mut waiting = std::mem::take(&mut self.waiting);
        self.write(|writer| writer.notes(&mut waiting));
        let path = self.parts.path();
        self.writer
            .and_then(|writer| Ok(writer.finish()?.1))
            .map_err(|source| RecordError::Write { path, source })
    }
}
