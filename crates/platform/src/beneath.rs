//! A folder that paths are held to: whatever a path says, it leads to something beneath the folder or nowhere.
//!
//! The system itself resolves the path (`openat2(2)` of Linux 5.6), so `..`, symbolic links, `/proc` and folders that
//! are moved meanwhile lead nowhere else, whoever else works there at the same time. Systems without such a call are
//! refused the folder: to look at a path first and use it afterwards would leave a gap between the two.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use crate::files::OpenMode;

/// A folder, held open.
#[derive(Debug)]
pub struct ConfinedDir(imp::RawHandle);

/// Something beneath it, held open: what was looked at is what is used.
#[derive(Debug)]
pub struct ConfinedEntry(imp::RawHandle);

impl ConfinedDir {
    /// Holds a folder open.
    ///
    /// # Errors
    /// It is not there, is no folder, or this system cannot hold paths to one.
    pub fn open(path: &Path) -> io::Result<Self> {
        imp::open(path).map(Self)
    }

    /// What a path from this folder on leads to, links followed.
    ///
    /// # Errors
    /// [`io::ErrorKind::CrossesDevices`] if it leads out; what the system says otherwise.
    pub fn find(&self, way: &Path) -> io::Result<ConfinedEntry> {
        imp::find(&self.0, way, false).map(ConfinedEntry)
    }

    /// The folder that a path from this folder on leads to, links followed.
    ///
    /// # Errors
    /// The errors of [`ConfinedDir::find`].
    pub fn find_folder(&self, way: &Path) -> io::Result<ConfinedEntry> {
        imp::find(&self.0, way, true).map(ConfinedEntry)
    }

    /// Opens or makes a file. Nothing waits at opening, and no terminal becomes that of this process.
    ///
    /// # Errors
    /// The errors of [`ConfinedDir::find`].
    pub fn file(&self, way: &Path, mode: OpenMode) -> io::Result<File> {
        imp::file(&self.0, way, mode)
    }
}

impl ConfinedEntry {
    /// A path that leads there as long as this is held: nothing between here and there can be exchanged.
    pub fn path(&self) -> PathBuf {
        imp::path(&self.0)
    }

    /// A file that is open, as something that was found.
    pub fn from_file(file: File) -> Self {
        Self(imp::of(file))
    }
}

#[cfg(target_os = "linux")]
mod imp {
    use std::fs::File;
    use std::io;
    use std::os::fd::{AsRawFd as _, OwnedFd};
    use std::os::unix::fs::OpenOptionsExt as _;
    use std::path::{Path, PathBuf};

    use nix::errno::Errno;
    use nix::fcntl::{OFlag, OpenHow, ResolveFlag, openat2};
    use nix::sys::stat::Mode;

    use crate::files::OpenMode;

    pub(super) type RawHandle = OwnedFd;

    pub(super) fn open(path: &Path) -> io::Result<OwnedFd> {
        let flags = OFlag::O_PATH | OFlag::O_DIRECTORY | OFlag::O_CLOEXEC;
        let opened = File::options()
            .read(true)
            .custom_flags(flags.bits())
            .open(path)?;
        Ok(opened.into())
    }

    pub(super) fn find(folder: &OwnedFd, way: &Path, is_folder: bool) -> io::Result<OwnedFd> {
        let mut flags = OFlag::O_PATH;
        flags.set(OFlag::O_DIRECTORY, is_folder);
        resolve(folder, way, flags, Mode::empty())
    }

    pub(super) fn file(folder: &OwnedFd, way: &Path, mode: OpenMode) -> io::Result<File> {
        // A pipe that nobody reads would have kept whoever opens it waiting.
        let mut flags = OFlag::O_NONBLOCK | OFlag::O_NOCTTY;
        flags |= match (mode.read, mode.write || mode.append) {
            (true, true) => OFlag::O_RDWR,
            (false, true) => OFlag::O_WRONLY,
            (_, false) => OFlag::O_RDONLY,
        };
        let is_made = mode.create || mode.exclusive;
        flags.set(OFlag::O_APPEND, mode.append);
        flags.set(OFlag::O_CREAT, is_made);
        flags.set(OFlag::O_EXCL, mode.exclusive);
        flags.set(OFlag::O_TRUNC, mode.truncate && !mode.exclusive);
        let permissions = match is_made {
            true => Mode::from_bits_truncate(0o666),
            false => Mode::empty(),
        };
        resolve(folder, way, flags, permissions).map(File::from)
    }

    fn resolve(folder: &OwnedFd, way: &Path, flags: OFlag, mode: Mode) -> io::Result<OwnedFd> {
        let how = OpenHow::new()
            .flags(flags | OFlag::O_CLOEXEC)
            .mode(mode)
            .resolve(ResolveFlag::RESOLVE_BENEATH | ResolveFlag::RESOLVE_NO_MAGICLINKS);
        loop {
            return match openat2(folder, way, how) {
                // Somebody moves folders about while the path is walked.
                Err(Errno::EAGAIN | Errno::EINTR) => continue,
                other => Ok(other?),
            };
        }
    }

    pub(super) fn path(held: &OwnedFd) -> PathBuf {
        Path::new("/proc/self/fd").join(held.as_raw_fd().to_string())
    }

    pub(super) fn of(file: File) -> OwnedFd {
        file.into()
    }
}

#[cfg(not(target_os = "linux"))]
mod imp {
    use std::fs::File;
    use std::io;
    use std::path::{Path, PathBuf};

    use crate::files::OpenMode;

    const WHAT: &str = "holding paths to a folder";

    /// No folder is ever opened.
    pub(super) type RawHandle = File;

    pub(super) fn open(_: &Path) -> io::Result<RawHandle> {
        Err(crate::needs_linux(WHAT))
    }

    pub(super) fn find(_: &RawHandle, _: &Path, _: bool) -> io::Result<RawHandle> {
        Err(crate::needs_linux(WHAT))
    }

    pub(super) fn file(_: &RawHandle, _: &Path, _: OpenMode) -> io::Result<File> {
        Err(crate::needs_linux(WHAT))
    }

    pub(super) fn path(_: &RawHandle) -> PathBuf {
        PathBuf::new()
    }

    pub(super) fn of(file: File) -> RawHandle {
        file
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    #![allow(clippy::unwrap_used)] // a test

    use std::os::unix::fs::symlink;

    use super::*;

    #[test]
    fn no_way_leads_out_of_the_folder() {
        let outside = tempfile::tempdir().unwrap();
        let inner = outside.path().join("inner");
        std::fs::create_dir(&inner).unwrap();
        std::fs::write(outside.path().join("secret"), "x").unwrap();
        std::fs::write(inner.join("own"), "y").unwrap();
        symlink(outside.path(), inner.join("up")).unwrap();
        symlink("own", inner.join("link")).unwrap();
        let folder = ConfinedDir::open(&inner).unwrap();
        for way in [
            "../secret",
            "up/secret",
            "/etc/passwd",
            "./../inner/../secret",
        ] {
            let error = folder.find(Path::new(way)).unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::CrossesDevices, "{way}");
        }
        let found = folder.find(Path::new("link")).unwrap();
        assert_eq!(std::fs::read_to_string(found.path()).unwrap(), "y");
        let exclusive = OpenMode {
            write: true,
            exclusive: true,
            ..OpenMode::default()
        };
        assert!(folder.file(Path::new("own"), exclusive).is_err());
        assert!(folder.file(Path::new("new"), exclusive).is_ok());
        assert!(folder.find_folder(Path::new("own")).is_err());
    }
}
