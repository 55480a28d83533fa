//! Files for programs that were granted them (`--allow fs`): the system's calls, in a folder of the task's own.
//!
//! Only regular files and devices are opened, and devices without waiting, so no call can hold the task up for long.

use std::cell::{Cell, RefCell};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::os::unix::fs::{
    DirBuilderExt, FileTypeExt, MetadataExt, OpenOptionsExt, PermissionsExt, symlink,
};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use elite_lang::{FileStat, HostFile, HostFiles, OpenMode};
use nix::errno::Errno;
use nix::fcntl::OFlag;
use nix::unistd::{AccessFlags, access};

/// Most files a task may have open.
const FILES_MAX: usize = 128;
/// Most names of one folder that are listed.
const NAMES_MAX: usize = 1 << 20;

/// The files of one task.
pub(crate) struct Files {
    folder: RefCell<PathBuf>,
    open: Rc<Cell<usize>>,
}

impl Default for Files {
    /// Relative paths count from the folder the controller was started in.
    fn default() -> Self {
        Self {
            folder: RefCell::new(std::env::current_dir().unwrap_or_else(|_| PathBuf::from("/"))),
            open: Rc::default(),
        }
    }
}

impl Files {
    /// The path in the task's own folder.
    pub fn full(&self, path: &str) -> PathBuf {
        self.folder.borrow().join(path)
    }
}

fn text(path: PathBuf) -> io::Result<String> {
    path.into_os_string()
        .into_string()
        .map_err(|_| io::Error::from(Errno::EILSEQ))
}

fn stat_of(found: &fs::Metadata) -> FileStat {
    let nanoseconds = |seconds: i64, rest: i64| seconds.saturating_mul(1_000_000_000) + rest;
    FileStat {
        mode: found.mode(),
        inode: found.ino(),
        device: found.dev(),
        links: found.nlink(),
        user: found.uid(),
        group: found.gid(),
        size: found.size(),
        accessed_ns: nanoseconds(found.atime(), found.atime_nsec()),
        modified_ns: nanoseconds(found.mtime(), found.mtime_nsec()),
        changed_ns: nanoseconds(found.ctime(), found.ctime_nsec()),
    }
}

fn moment(ns: i64) -> SystemTime {
    let distance = Duration::from_nanos(ns.unsigned_abs());
    if ns < 0 {
        UNIX_EPOCH - distance
    } else {
        UNIX_EPOCH + distance
    }
}

/// `path` may be relative, and an empty one is no path.
fn checked(path: &Path) -> io::Result<&Path> {
    match path.as_os_str().is_empty() {
        true => Err(Errno::ENOENT.into()),
        false => Ok(path),
    }
}

impl Files {
    fn at(&self, path: &str) -> io::Result<PathBuf> {
        checked(Path::new(path))?;
        Ok(self.full(path))
    }
}

impl HostFiles for Files {
    fn open(&self, path: &str, mode: OpenMode) -> io::Result<Rc<dyn HostFile>> {
        if self.open.get() >= FILES_MAX {
            return Err(Errno::EMFILE.into());
        }
        let path = self.at(path)?;
        // What would make `open` itself wait, or hands the task something that waits, is turned down.
        if let Ok(found) = fs::metadata(&path) {
            let kind = found.file_type();
            if kind.is_dir() {
                return Err(Errno::EISDIR.into());
            }
            if kind.is_fifo() || kind.is_socket() || kind.is_block_device() {
                let text = "only regular files and character devices can be opened by scripts";
                return Err(io::Error::new(io::ErrorKind::Unsupported, text));
            }
        }
        let mut options = OpenOptions::new();
        options
            .read(mode.read)
            .write(mode.write)
            .append(mode.append)
            .create(mode.create && !mode.exclusive)
            .create_new(mode.exclusive)
            .truncate(mode.truncate)
            .custom_flags((OFlag::O_NONBLOCK | OFlag::O_NOCTTY).bits());
        let file = options.open(&path)?;
        self.open.set(self.open.get() + 1);
        Ok(Rc::new(OpenFile {
            file,
            open: self.open.clone(),
        }))
    }

    fn stat(&self, path: &str, follow: bool) -> io::Result<FileStat> {
        let path = self.at(path)?;
        let found = if follow {
            fs::metadata(path)
        } else {
            fs::symlink_metadata(path)
        };
        found.map(|found| stat_of(&found))
    }

    fn list(&self, path: &str) -> io::Result<Vec<String>> {
        let mut names = Vec::new();
        for entry in fs::read_dir(self.at(path)?)? {
            if names.len() >= NAMES_MAX {
                return Err(io::Error::other(format!(
                    "the folder has more than {NAMES_MAX} entries"
                )));
            }
            names.push(text(entry?.file_name().into())?);
        }
        Ok(names)
    }

    fn make_dir(&self, path: &str, mode: u32) -> io::Result<()> {
        fs::DirBuilder::new().mode(mode).create(self.at(path)?)
    }

    fn remove_dir(&self, path: &str) -> io::Result<()> {
        fs::remove_dir(self.at(path)?)
    }

    fn remove_file(&self, path: &str) -> io::Result<()> {
        fs::remove_file(self.at(path)?)
    }

    fn rename(&self, from: &str, to: &str) -> io::Result<()> {
        fs::rename(self.at(from)?, self.at(to)?)
    }

    fn symlink(&self, target: &str, path: &str) -> io::Result<()> {
        symlink(target, self.at(path)?)
    }

    fn link(&self, from: &str, to: &str) -> io::Result<()> {
        fs::hard_link(self.at(from)?, self.at(to)?)
    }

    fn read_link(&self, path: &str) -> io::Result<String> {
        text(fs::read_link(self.at(path)?)?)
    }

    fn set_mode(&self, path: &str, mode: u32) -> io::Result<()> {
        fs::set_permissions(self.at(path)?, fs::Permissions::from_mode(mode & 0o7777))
    }

    fn set_times(&self, path: &str, accessed_ns: i64, modified_ns: i64) -> io::Result<()> {
        let times = fs::FileTimes::new()
            .set_accessed(moment(accessed_ns))
            .set_modified(moment(modified_ns));
        let mut options = OpenOptions::new();
        options.custom_flags((OFlag::O_NONBLOCK | OFlag::O_NOCTTY).bits());
        let path = self.at(path)?;
        let file = options.read(true).open(&path);
        let file = file.or_else(|_| options.read(false).write(true).open(&path))?;
        file.set_times(times)
    }

    fn access(&self, path: &str, mode: u32) -> bool {
        let wanted = AccessFlags::from_bits_truncate(i32::try_from(mode & 7).unwrap_or(7));
        self.at(path)
            .is_ok_and(|path| access(&path, wanted).is_ok())
    }

    fn current_dir(&self) -> String {
        self.folder.borrow().to_string_lossy().into_owned()
    }

    fn set_current_dir(&self, path: &str) -> io::Result<()> {
        let folder = fs::canonicalize(self.at(path)?)?;
        if !folder.is_dir() {
            return Err(Errno::ENOTDIR.into());
        }
        *self.folder.borrow_mut() = folder;
        Ok(())
    }
}

/// One open file of a task.
#[derive(Debug)]
struct OpenFile {
    file: File,
    open: Rc<Cell<usize>>,
}

impl HostFile for OpenFile {
    fn read(&self, buffer: &mut [u8]) -> io::Result<usize> {
        (&self.file).read(buffer)
    }

    fn write(&self, data: &[u8]) -> io::Result<usize> {
        (&self.file).write(data)
    }

    fn seek(&self, to: SeekFrom) -> io::Result<u64> {
        (&self.file).seek(to)
    }

    fn set_len(&self, length: u64) -> io::Result<()> {
        self.file.set_len(length)
    }

    fn sync(&self) -> io::Result<()> {
        self.file.sync_all()
    }

    fn stat(&self) -> io::Result<FileStat> {
        self.file.metadata().map(|found| stat_of(&found))
    }

    fn duplicate(&self) -> io::Result<File> {
        self.file.try_clone()
    }
}

impl Drop for OpenFile {
    fn drop(&mut self) {
        self.open.set(self.open.get().saturating_sub(1));
    }
}
