//! The vendor's log files of interpreter mode under `--log-dir` (manual 2.7).
//!
//! `interpreter.log` has every statement received and every discard, `interpreter.execute.log` what is executed. A file
//! that has grown to [`FILE_BYTES_MAX`] becomes `….0.log`, in place of the one before. Written by a thread of its own:
//! nobody waits for a disk, and what it cannot keep up with is counted and said in the file.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use elite_runtime::message::InterpreterEvent;
use motion_api::SnapshotCell;
use supervision::{ThreadSupervisor, injection};

use crate::ports::ClientId;
use crate::ports::escape::EscapedText;

/// A file of this size is put aside.
pub const FILE_BYTES_MAX: u64 = 4 * 1024 * 1024;

/// Lines that wait for the disk.
const LINES_WAITING_MAX: usize = 16 * 1024;

/// Longest text of a statement in a line.
const TEXT_BYTES_MAX: usize = 1000;

/// Where lines go; clones write into the same files. Does nothing without a folder.
#[derive(Clone, Default)]
pub struct InterpreterLog {
    to_disk: Option<Arc<DiskWriter>>,
}

struct DiskWriter {
    lines: SyncSender<(LogFile, String)>,
    lost: Arc<AtomicU64>,
    snapshot: Arc<SnapshotCell>,
}

#[derive(Clone, Copy)]
enum LogFile {
    Received,
    Executed,
}

impl InterpreterLog {
    /// Starts writing into `folder`, which is made if it is not there. Lines carry the simulated time of `snapshot`.
    ///
    /// # Errors
    /// The folder or a file in it cannot be made.
    pub fn open(
        folder: &Path,
        snapshot: Arc<SnapshotCell>,
        faults: &ThreadSupervisor,
    ) -> io::Result<Self> {
        fs::create_dir_all(folder)?;
        let received = RotatingFile::open(folder, "interpreter", FILE_BYTES_MAX)?;
        let executed = RotatingFile::open(folder, "interpreter.execute", FILE_BYTES_MAX)?;
        let (lines, to_write) = sync_channel(LINES_WAITING_MAX);
        let lost = Arc::new(AtomicU64::new(0));
        let counted = Arc::clone(&lost);
        let mut files = (received, executed);
        faults.start_service("interpreter-log", move || {
            write_lines(&to_write, &mut files.0, &mut files.1, &counted);
        })?;
        let to_disk = DiskWriter {
            lines,
            lost,
            snapshot,
        };
        Ok(Self {
            to_disk: Some(Arc::new(to_disk)),
        })
    }

    /// A statement came in.
    pub fn received(&self, client: ClientId, text: &str) {
        self.send(LogFile::Received, || {
            format!("{client}: {}", one_line(text))
        });
    }

    /// A statement is not executed.
    pub fn discarded(&self, client: ClientId, reason: &str, text: &str) {
        self.send(LogFile::Received, || {
            format!("{client}: discard: {reason}: {}", one_line(text))
        });
    }

    /// The task executes, clears, enters or leaves.
    pub fn executing(&self, event: &InterpreterEvent<'_>) {
        self.send(LogFile::Executed, || match event {
            InterpreterEvent::Entered => "interpreter mode entered".to_owned(),
            InterpreterEvent::Executing { id, text } => format!("{id}: {}", one_line(text)),
            InterpreterEvent::Cleared { id } => format!("cleared up to {id}"),
            InterpreterEvent::Left => "interpreter mode left".to_owned(),
        });
    }

    fn send(&self, which: LogFile, line: impl FnOnce() -> String) {
        let Some(to_disk) = &self.to_disk else {
            return;
        };
        let line = format!("{:.3} {}\n", to_disk.snapshot.read().time, line());
        if to_disk.lines.try_send((which, line)).is_err() {
            to_disk.lost.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// A log line is one line, and not endless.
fn one_line(text: &str) -> String {
    let end = text.floor_char_boundary(TEXT_BYTES_MAX);
    let cut = if end < text.len() { "..." } else { "" };
    let text = text[..end].trim().replace(['\n', '\r'], " ");
    format!("{}{cut}", EscapedText(&text))
}

/// Writes until every sender is gone. What waits is written at one go; then the files are up to date for readers.
fn write_lines(
    lines: &Receiver<(LogFile, String)>,
    received: &mut RotatingFile,
    executed: &mut RotatingFile,
    lost: &AtomicU64,
) {
    while let Ok(first) = lines.recv() {
        injection::point("interpreter-log");
        let mut result = Ok(());
        for (which, line) in std::iter::once(first).chain(lines.try_iter()) {
            let file = match which {
                LogFile::Received => &mut *received,
                LogFile::Executed => &mut *executed,
            };
            result = result.and(file.write(line.as_bytes()));
        }
        let missing = lost.swap(0, Ordering::Relaxed);
        if missing > 0 {
            let line = format!("{missing} lines are missing: the disk was too slow\n");
            result = result.and(received.write(line.as_bytes()));
        }
        result = result.and(received.flush()).and(executed.flush());
        if let Err(error) = result {
            tracing::error!(
                "--log-dir: the interpreter's log ends here, the robot goes on: {error}"
            );
            return;
        }
    }
}

/// A file that is put aside when it has grown too large.
struct RotatingFile {
    path: PathBuf,
    aside: PathBuf,
    file: BufWriter<File>,
    bytes: u64,
    bytes_max: u64,
}

impl RotatingFile {
    fn open(folder: &Path, name: &str, bytes_max: u64) -> io::Result<Self> {
        let path = folder.join(format!("{name}.log"));
        let file = OpenOptions::new().create(true).append(true).open(&path)?;
        Ok(Self {
            aside: folder.join(format!("{name}.0.log")),
            bytes: file.metadata()?.len(),
            file: BufWriter::new(file),
            path,
            bytes_max,
        })
    }

    fn write(&mut self, line: &[u8]) -> io::Result<()> {
        if self.bytes > 0 && self.bytes + line.len() as u64 > self.bytes_max {
            self.file.flush()?;
            fs::rename(&self.path, &self.aside)?;
            self.file = BufWriter::new(File::create(&self.path)?);
            self.bytes = 0;
        }
        self.file.write_all(line)?;
        self.bytes += line.len() as u64;
        Ok(())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_file_is_put_aside_and_the_one_before_it_is_gone() {
        let folder = tempfile::tempdir().unwrap();
        let mut file = RotatingFile::open(folder.path(), "interpreter", 10).unwrap();
        for line in ["1234\n", "5678\n", "abc\n", "defghi\n", "x\n"] {
            file.write(line.as_bytes()).unwrap();
        }
        file.flush().unwrap();
        let read = |name| fs::read_to_string(folder.path().join(name)).unwrap();
        assert_eq!(read("interpreter.0.log"), "abc\n");
        assert_eq!(read("interpreter.log"), "defghi\nx\n");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    }

    #[test]
    fn a_file_is_gone_on_with_after_a_restart() {
        let folder = tempfile::tempdir().unwrap();
        for line in ["first\n", "second\n"] {
            let mut file = RotatingFile::open(folder.path(), "interpreter", 100).unwrap();
            file.write(line.as_bytes()).unwrap();
            file.flush().unwrap();
        }
        let text = fs::read_to_string(folder.path().join("interpreter.log")).unwrap();
        assert_eq!(text, "first\nsecond\n");
    }

    #[test]
    fn a_line_is_one_line_and_not_endless() {
        assert_eq!(one_line("def f():\n a()\nend\n"), "def f():  a() end");
        assert_eq!(one_line(&"é".repeat(2000)).len(), TEXT_BYTES_MAX + 3);
        assert_eq!(one_line("a\x1b[2J"), "a\\u{1b}[2J");
    }
}
