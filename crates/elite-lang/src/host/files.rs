//! Files and folders as the host gives them to programs: the system's calls, one by one, without buffers or text.
//!
//! Paths are text, relative ones count from the folder the program is in (`current_dir`), which is the program's own.

use std::fmt::Debug;
use std::io::{self, SeekFrom};
use std::rc::Rc;

pub use platform::files::{FileStatus as FileStat, OpenMode};

/// The files that programs may reach. Every error is the system's, or a bound of the host.
#[allow(clippy::missing_errors_doc)]
pub trait HostFiles {
    /// Opens a file.
    fn open(&self, path: &str, mode: OpenMode) -> io::Result<Rc<dyn HostFile>>;
    /// What is known of a file; of a symbolic link itself unless `follow`.
    fn stat(&self, path: &str, follow: bool) -> io::Result<FileStat>;
    /// The names in a folder, in no order.
    fn list(&self, path: &str) -> io::Result<Vec<String>>;
    /// Makes a folder with these permission bits.
    fn make_dir(&self, path: &str, mode: u32) -> io::Result<()>;
    /// Removes an empty folder.
    fn remove_dir(&self, path: &str) -> io::Result<()>;
    /// Removes a file.
    fn remove_file(&self, path: &str) -> io::Result<()>;
    /// Gives a file another name, in place of a file that has it.
    fn rename(&self, from: &str, to: &str) -> io::Result<()>;
    /// Makes a symbolic link at `path`.
    fn symlink(&self, target: &str, path: &str) -> io::Result<()>;
    /// Makes a further name for a file.
    fn link(&self, from: &str, to: &str) -> io::Result<()>;
    /// Where a symbolic link points.
    fn read_link(&self, path: &str) -> io::Result<String>;
    /// Sets permission bits.
    fn set_mode(&self, path: &str, mode: u32) -> io::Result<()>;
    /// Sets the times of the last access and change, nanoseconds since 1970.
    fn set_times(&self, path: &str, accessed_ns: i64, modified_ns: i64) -> io::Result<()>;
    /// Whether the program may read (4), write (2), execute (1) or see (0) it.
    fn access(&self, path: &str, mode: u32) -> bool;
    /// The folder the program is in.
    fn current_dir(&self) -> String;
    /// Goes to another folder.
    fn set_current_dir(&self, path: &str) -> io::Result<()>;
}

/// An open file. Closed when dropped.
#[allow(clippy::missing_errors_doc)]
pub trait HostFile: Debug {
    /// Reads what is there; 0 bytes are the end.
    fn read(&self, buffer: &mut [u8]) -> io::Result<usize>;
    /// Writes at least a part of `data`.
    fn write(&self, data: &[u8]) -> io::Result<usize>;
    /// Moves the position; answers the new one.
    fn seek(&self, to: SeekFrom) -> io::Result<u64>;
    /// Makes it shorter or longer.
    fn set_len(&self, length: u64) -> io::Result<()>;
    /// Waits until it is on the disk.
    fn sync(&self) -> io::Result<()>;
    /// What is known of it.
    fn stat(&self) -> io::Result<FileStat>;
    /// A second handle of the open file, for a process to write to or read from.
    fn duplicate(&self) -> io::Result<std::fs::File>;
}
