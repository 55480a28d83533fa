//! The recorder's thread: what waits in the ring and the queue goes into the file, chunk by chunk, part by part.
//!
//! The only place with wall time: what has been recorded is handed to the operating system in time, also when simulated
//! time stands still.

use std::io::{self, BufWriter, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use mcap::McapError;
use motion_api::RecordReader;
use parking_lot::Mutex;
use supervision::injection;

use crate::chunks::CHUNK_BYTES;
use crate::files;
use crate::handle::RecorderState;
use crate::notes::{AnnotationQueue, PendingAnnotations};
use crate::recorder::{RecordError, RecorderConfig, SharedReport, report_once};
use crate::rotation::RecordingParts;
use crate::setup::Setup;
use crate::viewer::ViewerMessages;
use crate::writer::{RecordWriter, Totals};

/// How long the thread sleeps when there is nothing to do. The ring holds thousands of cycles.
const POLL: Duration = Duration::from_millis(2);
/// What has been recorded is handed to the operating system after this much wall time at the latest.
const FLUSH_AFTER: Duration = Duration::from_millis(250);
/// Records taken without looking at anything else, so that a fast producer cannot keep the thread from its other work.
const BATCH: usize = 1024;

/// An output that knows how much went into it.
struct CountingWriter {
    out: BufWriter<Box<dyn Write + Send>>,
    /// Bytes of this part of the recording.
    bytes: Arc<AtomicU64>,
    shared: Arc<RecorderState>,
}

impl CountingWriter {
    fn new(out: impl Write + Send + 'static, shared: Arc<RecorderState>) -> (Self, Arc<AtomicU64>) {
        let bytes = Arc::new(AtomicU64::new(0));
        // One write a chunk: a kill leaves whole chunks.
        let out = BufWriter::with_capacity(2 * CHUNK_BYTES, Box::new(out) as _);
        let counted = Self {
            out,
            bytes: Arc::clone(&bytes),
            shared,
        };
        (counted, bytes)
    }
}

impl Write for CountingWriter {
    fn write(&mut self, data: &[u8]) -> io::Result<usize> {
        injection::point("disk");
        let written = self.out.write(data)?;
        self.shared.progress_count.fetch_add(1, Ordering::Relaxed);
        self.bytes.fetch_add(written as u64, Ordering::Relaxed);
        let all = &self.shared.bytes;
        all.fetch_add(written as u64, Ordering::Relaxed);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// What the thread owns.
pub(crate) struct RecorderThread {
    /// The writer, or why there is none any more.
    writer: Result<RecordWriter<CountingWriter>, Arc<McapError>>,
    records: RecordReader,
    notes: Arc<AnnotationQueue>,
    /// Notes that wait for the record they come before.
    waiting: PendingAnnotations,
    shared: Arc<RecorderState>,
    parts: RecordingParts,
    /// Bytes of the part being written.
    bytes: Arc<AtomicU64>,
    setup: Setup,
    on_failure: SharedReport,
    dropped_before: u64,
    /// The open chunk, and since when it has been seen open.
    open_chunk_since: Option<(Option<u64>, Instant)>,
}

impl RecorderThread {
    /// Writes the beginning of the file.
    pub(crate) fn new(
        out: impl Write + Send + 'static,
        config: RecorderConfig,
        records: RecordReader,
        notes: Arc<AnnotationQueue>,
        shared: Arc<RecorderState>,
    ) -> Result<Self, RecordError> {
        let RecorderConfig {
            path,
            setup,
            model,
            obstacles,
            extra,
            rotation,
            notes_wait: _,
            patience: _,
            on_failure,
        } = config;
        let (out, bytes) = CountingWriter::new(out, Arc::clone(&shared));
        let viewer = ViewerMessages::new(model, obstacles, setup.epoch_ns);
        let writer = RecordWriter::start(out, &setup, viewer, extra).map_err(|source| {
            RecordError::Write {
                path: path.clone(),
                source: Arc::new(source),
            }
        })?;
        Ok(Self {
            writer: Ok(writer),
            records,
            notes,
            waiting: PendingAnnotations::default(),
            shared,
            parts: RecordingParts::new(path, rotation, files::total_bytes(&setup.files) as u64),
            bytes,
            setup,
            on_failure: Arc::new(Mutex::new(Some(on_failure))),
            dropped_before: 0,
            open_chunk_since: None,
        })
    }

    /// Who is told when the recording ends early.
    pub(crate) fn report(&self) -> SharedReport {
        Arc::clone(&self.on_failure)
    }

    /// Until it is asked to finish; then writes the end of the file.
    pub(crate) fn run(mut self) -> Result<Totals, RecordError> {
        loop {
            injection::point("recorder");
            self.shared.progress_count.fetch_add(1, Ordering::Relaxed);
            // Read before the ring is emptied: what was pushed before the request is then certainly taken.
            let finish = self.shared.finish.load(Ordering::Acquire);
            let waiting = self.records.waiting() as u64;
            self.shared
                .records_waiting
                .store(waiting, Ordering::Relaxed);
            let taken = self.take_records();
            if let Ok(writer) = &self.writer {
                let cycles = writer.totals().cycles;
                self.shared.cycles.store(cycles, Ordering::Relaxed);
            }
            let idle = taken < BATCH;
            if idle && self.notes.is_nearly_full() {
                // Nothing is left in the ring that they could come before, and whoever sends them may be held up.
                self.take_notes();
                self.write_notes();
            }
            self.flush_if_due(taken);
            self.rotate_if_due();
            if self.shared.is_abandoned.load(Ordering::Acquire) {
                // Nothing comes behind what the ring still holds, so the end of the file goes there.
                while self.take_records() == BATCH {}
                let path = self.parts.path();
                self.close()?;
                return Err(RecordError::OutputStalled { path });
            }
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
            // After the record was taken: everything a script noted before this cycle ran is in the queue.
            self.take_notes();
            let mut waiting = std::mem::take(&mut self.waiting);
            self.write(|writer| writer.record(&record, &mut waiting));
            self.notes.release_written(&mut waiting);
            self.waiting = waiting;
        }
        BATCH
    }

    fn take_notes(&mut self) {
        self.notes.drain_into(&mut self.waiting);
        if self.writer.is_err() {
            self.waiting.clear();
            self.notes.release_written(&mut self.waiting);
        }
    }

    /// Writes all notes that wait, whatever their place.
    fn write_notes(&mut self) {
        let mut waiting = std::mem::take(&mut self.waiting);
        self.write(|writer| writer.notes(&mut waiting));
        waiting.clear();
        self.notes.release_written(&mut waiting);
    }

    /// Does something with the writer, if there still is one; the first failure ends the recording.
    fn write(
        &mut self,
        act: impl FnOnce(&mut RecordWriter<CountingWriter>) -> Result<(), McapError>,
    ) {
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
        report_once(&self.on_failure, &error);
    }

    /// Under a clock that stands still, and when cycles are slow, nothing stays in memory for long. Where simulated
    /// time runs as fast as wall time or faster, the writer closes its chunks before this does, at reproducible places.
    fn flush_if_due(&mut self, taken: usize) {
        if taken == 0 {
            self.take_notes();
        }
        let chunk = self.writer.as_ref().ok().and_then(RecordWriter::open_chunk);
        if chunk.is_none() && self.waiting.is_empty() {
            self.open_chunk_since = None;
            return;
        }
        let now = Instant::now();
        let since = match self.open_chunk_since {
            Some((same, since)) if same == chunk => since,
            _ => now,
        };
        self.open_chunk_since = Some((chunk, since));
        if now.duration_since(since) < FLUSH_AFTER {
            return;
        }
        self.open_chunk_since = None;
        self.write_drop_notice();
        // While cycles come, notes keep their place between them.
        if taken == 0 {
            self.write_notes();
        }
        self.write(RecordWriter::close_chunk);
    }

    /// Begins the next part when this one is long enough. When its file cannot be made, this one goes on.
    fn rotate_if_due(&mut self) {
        let Ok(writer) = &self.writer else { return };
        let time = writer.time();
        let bytes = self.bytes.load(Ordering::Relaxed);
        for (path, error) in self.parts.enforce_budget(bytes) {
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
                self.parts.postpone();
                return;
            }
        };
        let (out, count) = CountingWriter::new(file, Arc::clone(&self.shared));
        self.setup.part = number;
        let ended = Err(Arc::new(McapError::UnexpectedEof));
        let writer = std::mem::replace(&mut self.writer, ended);
        let result = writer.and_then(|writer| Ok(writer.rotate_to(out, &self.setup)?));
        match result {
            Ok((writer, _)) => {
                self.writer = Ok(writer);
                self.parts
                    .finish_part(self.bytes.load(Ordering::Relaxed), time);
                self.bytes = count;
            }
            Err(error) => self.fail(error),
        }
    }

    /// Says in the recording that notes are missing.
    fn write_drop_notice(&mut self) {
        let dropped = self.shared.notes_dropped.load(Ordering::Relaxed);
        if dropped > self.dropped_before {
            let count = dropped - self.dropped_before;
            self.dropped_before = dropped;
            self.write(|writer| writer.dropped(count));
        }
    }

    fn sleep(&mut self) {
        self.notes.wait_for_annotation(POLL);
        self.take_notes();
    }

    fn close(mut self) -> Result<Totals, RecordError> {
        self.take_notes();
        self.write_drop_notice();
        self.write_notes();
        let path = self.parts.path();
        let ended = Err(Arc::new(McapError::UnexpectedEof));
        std::mem::replace(&mut self.writer, ended)
            .and_then(|writer| Ok(writer.finish()?.1))
            .map_err(|source| RecordError::Write { path, source })
    }
}

impl Drop for RecorderThread {
    /// However the thread ends: nobody waits for it any more.
    fn drop(&mut self) {
        self.notes.close();
    }
}
