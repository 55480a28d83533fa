//! The recorder's thread, and the ends through which the rest of the controller talks to it.
//!
//! [`RecorderThread`] is the thread: it takes records from the motion thread's ring every few milliseconds and notes of
//! the script side from a queue bounded in bytes, puts them into one order and writes them. The motion thread never
//! waits for it under the real clock (it counts what did not fit); under the virtual clock the caller of the cycle
//! waits for room in the ring, and a script waits for room in the queue, so nothing is lost.
//!
//! When the output can no longer be written, recording stops: the failure is reported once, the ring and the queue
//! go on being emptied, and the robot goes on. An output that neither takes anything nor fails is given up by a watcher
//! ([`crate::watcher`]) once somebody waits for it or records are being lost.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use kinematics::RobotModel;
use mcap::McapError;
use messages::{Localized, Text, text};
use motion_api::RecordReader;
use parking_lot::Mutex;
use supervision::{EndSignal, Fault, ThreadHandle, ThreadRole, ThreadSupervisor, catch};
use thiserror::Error;

use crate::extra::CustomTopic;
use crate::files::{self, CellFileError};
use crate::handle::{RecorderHandle, RecorderMetrics, RecorderState};
use crate::notes::AnnotationQueue;
use crate::rotation::Rotation;
use crate::setup::Setup;
use crate::viewer::SceneObstacle;
use crate::watcher::OutputWatchdog;
use crate::worker::RecorderThread;
use crate::writer::Totals;

/// What to record into, and about which arm.
pub struct RecorderConfig {
    /// The file. Missing directories are made; an existing file is replaced.
    pub path: PathBuf,
    /// How the controller was started.
    pub setup: Setup,
    /// The arm, for the viewers' topics.
    pub model: RobotModel,
    /// What else is drawn.
    pub obstacles: Vec<SceneObstacle>,
    /// Topics beside our own.
    pub extra: Vec<CustomTopic>,
    /// When the next file begins, and how much may be kept.
    pub rotation: Rotation,
    /// What a script does that outruns the recorder: wait (virtual clock) or go on, the note being dropped and counted
    /// (real clock).
    pub notes_wait: bool,
    /// How long an output may take nothing while somebody waits for it; then it is given up.
    pub patience: Duration,
    /// Called once, from the recorder's thread, when the output can no longer be written or the thread has met a fault:
    /// raise an alarm.
    pub on_failure: FailureReport,
}

/// Told that the recording has stopped, and why.
pub type FailureReport = Box<dyn FnOnce(&RecordError) + Send>;

/// A reason why there is no recording, or why it ended early.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum RecordError {
    /// The file or its directory cannot be made.
    #[error("cannot create the recording {}: {source}", path.display())]
    #[zh("无法创建记录 {}：{source}", path.display())]
    Create {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The files of the cell cannot stand in it.
    #[error("cannot record: {0}")]
    #[zh("无法记录：{0}")]
    Files(#[from] CellFileError),
    /// The file cannot be written.
    #[error("cannot write the recording {}: {}", path.display(), reason(source))]
    #[zh("无法写入记录 {}：{}", path.display(), reason(source))]
    Write {
        /// The file.
        path: PathBuf,
        /// Error of the writer.
        source: Arc<McapError>,
    },
    /// The thread cannot be started.
    #[error("cannot start the recorder's thread: {0}")]
    #[zh("无法启动记录线程：{0}")]
    Thread(io::Error),
    /// The thread has ended by a panic.
    #[error("the recording is not complete: {0}")]
    #[zh("记录不完整：{0}")]
    Fault(Fault),
    /// The output takes nothing and gives no error; nobody waits for it any more.
    #[error("cannot write the recording {}: the disk takes nothing", path.display())]
    #[zh("无法写入记录 {}：磁盘不接受数据", path.display())]
    OutputStalled {
        /// The file.
        path: PathBuf,
    },
    /// The thread was given up: the output takes nothing and gives no error.
    #[error("the recording is not complete: the disk did not take it in time")]
    #[zh("记录不完整：磁盘没有及时接受数据")]
    Ended,
}

/// The operating system's words where there are any: "No space left on device".
fn reason(error: &McapError) -> Text {
    match error {
        McapError::Io(error) => Text::of(error),
        other => Text::verbatim(other.to_string()),
    }
}

/// The report as worker and thread share it: a panic must not take it along.
pub(crate) type SharedReport = Arc<Mutex<Option<FailureReport>>>;

/// Raises the alarm, unless it has been raised.
pub(crate) fn report_once(report: &SharedReport, error: &RecordError) {
    let report = report.lock().take();
    if let Some(report) = report {
        report(error);
    }
}

/// Closes a recording from outside, whatever the rest of the controller is doing. Clones do the same.
#[derive(Clone)]
pub struct CloseHandle {
    shared: Arc<RecorderState>,
    notes: Arc<AnnotationQueue>,
    ended: EndSignal,
}

impl CloseHandle {
    /// Asks the thread to write what has come by now, the index and the end of the file; does not wait.
    pub fn request_close(&self) {
        self.shared.finish.store(true, Ordering::Release);
    }

    /// What is known of what a recording lacks that could not be closed, in words.
    pub fn describe_missing(&self) -> Text {
        let records = self.shared.records_waiting.load(Ordering::Relaxed);
        let (bytes, dropped) = (
            self.notes.bytes(),
            self.shared.notes_dropped.load(Ordering::Relaxed),
        );
        text!(
            "about {records} records and {bytes} bytes of messages wait unwritten, \
             {dropped} messages were dropped, and what comes last in the file may be incomplete",
            "约有 {records} 条记录和 {bytes} 字节的消息尚未写入，丢弃了 {dropped} 条消息，文件末尾的内容可能不完整"
        )
    }

    /// Waits until the file is closed, at most so long; true when it was written to its end.
    pub fn wait_closed(&self, patience: Duration) -> bool {
        self.ended.wait_for(patience) && !self.shared.failed.load(Ordering::Acquire)
    }
}

/// A running recording. Dropping it finishes the file as [`finish`](Self::finish) does, with errors only logged.
pub struct Recorder {
    shared: Arc<RecorderState>,
    notes: Arc<AnnotationQueue>,
    thread: Option<ThreadHandle<Result<Totals, RecordError>>>,
}

impl Recorder {
    /// Makes the file, writes its beginning and starts the thread.
    ///
    /// # Errors
    /// [`RecordError`] when the files of the cell are too large, the file cannot be made or written, or the thread not
    /// started.
    pub fn start(
        config: RecorderConfig,
        records: RecordReader,
    ) -> Result<(Self, RecorderHandle), RecordError> {
        // Before an older file of that name is lost.
        files::check(&config.setup.files)?;
        let file = create(&config.path).map_err(|source| RecordError::Create {
            path: config.path.clone(),
            source,
        })?;
        Self::start_on(file, config, records)
    }

    /// Starts a recording into any output; `config.path` is only its name in messages.
    ///
    /// # Errors
    /// [`RecordError`] when the files of the cell are too large, the output cannot be written or the thread not
    /// started.
    pub fn start_on(
        out: impl Write + Send + 'static,
        config: RecorderConfig,
        records: RecordReader,
    ) -> Result<(Self, RecorderHandle), RecordError> {
        files::check(&config.setup.files)?;
        let (notes, shared) = (
            Arc::new(AnnotationQueue::default()),
            Arc::new(RecorderState::default()),
        );
        let handle =
            RecorderHandle::new(Arc::clone(&notes), config.notes_wait, Arc::clone(&shared));
        let (patience, path) = (config.patience, config.path.clone());
        let flow = records.flow().clone();
        let worker = RecorderThread::new(
            out,
            config,
            records,
            Arc::clone(&notes),
            Arc::clone(&shared),
        )?;
        let (failed, report) = (Arc::clone(&shared), worker.report());
        let watched = report.clone();
        // A fault is told to whoever hears of failures, so nothing gets as far as the watcher of the thread.
        let thread = ThreadSupervisor::default()
            .start(ThreadRole::Recorder, "recorder", move || {
                let given = catch(|| worker.run()).unwrap_or_else(|panicked| {
                    let fault = Fault::new(ThreadRole::Recorder, "recorder", panicked);
                    Err(RecordError::Fault(fault))
                });
                if let Err(error) = &given {
                    failed.failed.store(true, Ordering::Release);
                    report_once(&report, error);
                }
                given
            })
            .map_err(RecordError::Thread)?;
        let watcher = OutputWatchdog {
            shared: Arc::clone(&shared),
            notes: Arc::clone(&notes),
            flow,
            ended: thread.end_signal().clone(),
            report: watched,
            path,
        };
        watcher.start(patience).map_err(RecordError::Thread)?;
        let recorder = Self {
            shared,
            notes,
            thread: Some(thread),
        };
        Ok((recorder, handle))
    }

    /// Whether recording has stopped because the output cannot be written.
    pub fn has_failed(&self) -> bool {
        self.shared.failed.load(Ordering::Acquire)
    }

    /// For whoever must close it without the recorder at hand.
    pub fn closer(&self) -> Option<CloseHandle> {
        let ended = self.thread.as_ref()?.end_signal().clone();
        Some(CloseHandle {
            shared: Arc::clone(&self.shared),
            notes: Arc::clone(&self.notes),
            ended,
        })
    }

    /// Figures of the recording, also after it has ended.
    pub fn meter(&self) -> RecorderMetrics {
        RecorderMetrics::new(Arc::clone(&self.shared), Arc::clone(&self.notes))
    }

    /// Takes what is in the ring and the queue by now, writes the index and closes the file.
    ///
    /// # Errors
    /// [`RecordError`] when the recording could not be written to its end.
    pub fn finish(mut self) -> Result<Totals, RecordError> {
        self.join()
    }

    fn join(&mut self) -> Result<Totals, RecordError> {
        self.shared.finish.store(true, Ordering::Release);
        let thread = self.thread.take().ok_or(RecordError::Ended)?;
        thread.join().map_err(RecordError::Fault)?
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

fn create(path: &Path) -> io::Result<File> {
    if let Some(parent) = path.parent().filter(|p| !p.as_os_str().is_empty()) {
        std::fs::create_dir_all(parent)?;
    }
    File::create(path)
}
