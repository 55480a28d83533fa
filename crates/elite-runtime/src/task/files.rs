//! Files for programs that were granted them (`--allow fs`): the system's calls, in a folder of the task's own.
//!
//! Only regular files and devices are opened, and devices without waiting, so no call can hold the task up for long.
//! Where only some folders are granted, [`sandbox`](super::sandbox) finds the way.

use std::cell::{Cell, RefCell};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use elite_lang::{FileStat, HostFile, HostFiles, OpenMode};
use platform::files::{self, Access, FileError};

use super::sandbox::{SandboxRoots, SandboxedPath};

/// Most files a task may have open.
const FILES_MAX: usize = 128;
/// Most names of one folder that are listed.
const NAMES_MAX: usize = 1 << 20;

/// Where programs on the vendor's controllers find the program folder: on one kind of box, on another, and as the
/// pendant has it.
const PROGRAM_FOLDERS: [&str; 3] = [
    "/rbctrl/EliRobot_share/program",
    "/rbctrl/RT_CONTROLLER/ROBOT/program",
    "/home/elite/user/program",
];

/// A path below the program folder of a vendor's controller, without that folder; `None` for any other path.
fn in_program_folder(path: &str) -> Option<&str> {
    let inside = PROGRAM_FOLDERS
        .iter()
        .find_map(|folder| path.strip_prefix(folder))?;
    match inside.strip_prefix('/') {
        Some(inside) => Some(inside.trim_start_matches('/')),
        None => inside.is_empty().then_some(inside),
    }
}

/// The files of one task.
pub(crate) struct Files {
    folder: RefCell<PathBuf>,
    /// Where the controller's program folder is.
    programs: PathBuf,
    /// What is granted, if not everything is.
    within: Option<SandboxRoots>,
    open: Rc<Cell<usize>>,
}

impl Files {
    /// Relative paths count from the folder the controller was started in; with `within`, from the first of those.
    pub fn new(within: Option<SandboxRoots>, programs: &Path) -> Self {
        let folder = match &within {
            Some(folders) => folders.first(),
            None => std::env::current_dir().unwrap_or_else(|_| PathBuf::from("/")),
        };
        Self {
            programs: folder.join(programs),
            folder: RefCell::new(folder),
            within,
            open: Rc::default(),
        }
    }

    /// The path in the task's own folder. The program folder of the vendor's controllers is the task folder here.
    pub fn full(&self, path: &str) -> PathBuf {
        match in_program_folder(path) {
            Some(inside) => self.programs.join(inside),
            None => self.folder.borrow().join(path),
        }
    }

    /// The folder that a process starts in.
    pub fn start_folder(&self, path: &str) -> io::Result<PathBuf> {
        let path = self.full(path);
        match &self.within {
            Some(folders) => folders.real(&path),
            None => Ok(path),
        }
    }
}

fn text(path: PathBuf) -> io::Result<String> {
    path.into_os_string()
        .into_string()
        .map_err(|_| io::Error::from(FileError::NoText))
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
        true => Err(FileError::NotFound.into()),
        false => Ok(path),
    }
}

impl Files {
    /// What the path leads to, links followed.
    fn target(&self, path: &str) -> io::Result<SandboxedPath> {
        checked(Path::new(path))?;
        match &self.within {
            Some(folders) => folders.target(&self.full(path)),
            None => Ok(SandboxedPath::unrestricted(self.full(path))),
        }
    }

    /// The entry that the path names; a link is not followed.
    fn entry(&self, path: &str) -> io::Result<SandboxedPath> {
        checked(Path::new(path))?;
        match &self.within {
            Some(folders) => folders.entry(&self.full(path)),
            None => Ok(SandboxedPath::unrestricted(self.full(path))),
        }
    }

    fn open_as(&self, path: &str, mode: OpenMode) -> io::Result<File> {
        match &self.within {
            Some(folders) => folders.open_file(&self.full(path), mode),
            None => files::open(&self.full(path), mode),
        }
    }
}

impl HostFiles for Files {
    fn open(&self, path: &str, mode: OpenMode) -> io::Result<Rc<dyn HostFile>> {
        if self.open.get() >= FILES_MAX {
            return Err(FileError::TooManyOpen.into());
        }
        // What would make `open` itself wait, or hands the task something that waits, is turned down.
        let found = self.target(path).and_then(fs::metadata);
        if let Ok(found) = found {
            let kind = found.file_type();
            if kind.is_dir() {
                return Err(FileError::IsAFolder.into());
            }
            if files::may_block(kind) {
                let text = "only regular files and character devices can be opened by scripts";
                return Err(io::Error::new(io::ErrorKind::Unsupported, text));
            }
        }
        let file = self.open_as(path, mode)?;
        self.open.set(self.open.get() + 1);
        Ok(Rc::new(OpenFile {
            file,
            open: self.open.clone(),
        }))
    }

    fn stat(&self, path: &str, follow: bool) -> io::Result<FileStat> {
        let found = match (follow, &self.within) {
            (true, _) => fs::metadata(self.target(path)?),
            (false, None) => fs::symlink_metadata(self.entry(path)?),
            // A folder that is granted has no entry that may be looked at; it is no link itself.
            (false, Some(_)) => match self.entry(path) {
                Ok(entry) => fs::symlink_metadata(entry),
                Err(_) => fs::metadata(self.target(path)?),
            },
        };
        found.map(|found| files::file_status(&found))
    }

    fn list(&self, path: &str) -> io::Result<Vec<String>> {
        let mut names = Vec::new();
        for entry in fs::read_dir(self.target(path)?)? {
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
        files::make_folder(self.entry(path)?.as_ref(), mode)
    }

    fn remove_dir(&self, path: &str) -> io::Result<()> {
        fs::remove_dir(self.entry(path)?)
    }

    fn remove_file(&self, path: &str) -> io::Result<()> {
        fs::remove_file(self.entry(path)?)
    }

    fn rename(&self, from: &str, to: &str) -> io::Result<()> {
        fs::rename(self.entry(from)?, self.entry(to)?)
    }

    fn symlink(&self, target: &str, path: &str) -> io::Result<()> {
        files::symlink(Path::new(target), self.entry(path)?.as_ref())
    }

    fn link(&self, from: &str, to: &str) -> io::Result<()> {
        fs::hard_link(self.entry(from)?, self.entry(to)?)
    }

    fn read_link(&self, path: &str) -> io::Result<String> {
        text(fs::read_link(self.entry(path)?)?)
    }

    fn set_mode(&self, path: &str, mode: u32) -> io::Result<()> {
        files::set_mode(self.target(path)?.as_ref(), mode)
    }

    fn set_times(&self, path: &str, accessed_ns: i64, modified_ns: i64) -> io::Result<()> {
        let times = fs::FileTimes::new()
            .set_accessed(moment(accessed_ns))
            .set_modified(moment(modified_ns));
        let mut options = OpenOptions::new();
        let path = self.target(path)?;
        let open = |options: &mut OpenOptions| files::open_nonblocking(options, path.as_ref());
        let file = open(options.read(true));
        let file = file.or_else(|_| open(options.read(false).write(true)))?;
        file.set_times(times)
    }

    fn access(&self, path: &str, mode: u32) -> bool {
        // The bits of the mode are those of `access(2)`.
        let wanted = Access {
            read: mode & 4 != 0,
            write: mode & 2 != 0,
            run: mode & 1 != 0,
        };
        self.target(path)
            .is_ok_and(|place| files::can_access(place.as_ref(), wanted))
    }

    fn current_dir(&self) -> String {
        self.folder.borrow().to_string_lossy().into_owned()
    }

    fn set_current_dir(&self, path: &str) -> io::Result<()> {
        let folder = match &self.within {
            Some(folders) => {
                checked(Path::new(path))?;
                folders.real(&self.full(path))?
            }
            None => fs::canonicalize(self.target(path)?)?,
        };
        if !folder.is_dir() {
            return Err(FileError::NotAFolder.into());
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
        self.file.metadata().map(|found| files::file_status(&found))
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
