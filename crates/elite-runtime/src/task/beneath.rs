//! Files beneath some folders and nowhere else (`--allow fs=DIR`).
//!
//! The folders are opened once. Every path is resolved by the system itself, beneath one of them: `..`, symbolic links,
//! `/proc` and folders that are moved meanwhile lead nowhere else, whoever else works there at the same time. What is
//! found is held open while it is used, so what was looked at is what is used.

use std::fs::File;
use std::io;
use std::os::fd::{AsRawFd, OwnedFd};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use nix::errno::Errno;
use nix::fcntl::{OFlag, OpenHow, ResolveFlag, openat2};
use nix::sys::stat::Mode;
use thiserror::Error;

/// The folders that programs may use. Clones share them.
#[derive(Clone, Debug)]
pub struct Folders(Arc<[Folder]>);

/// A folder that cannot be opened to programs.
#[derive(Debug, Error)]
#[error("programs cannot be given the folder {}: {source}", path.display())]
pub struct FolderAccessError {
    path: PathBuf,
    source: io::Error,
}

#[derive(Debug)]
struct Folder {
    /// As it was given, from the root on, and as it is without links.
    given: PathBuf,
    real: PathBuf,
    opened: OwnedFd,
}

/// Where something is, as long as this is held.
#[derive(Debug)]
pub(super) struct Place {
    path: PathBuf,
    _held: Option<OwnedFd>,
}

impl Place {
    /// A path that is used as it is.
    pub fn free(path: PathBuf) -> Self {
        Self { path, _held: None }
    }

    fn held(opened: OwnedFd, name: &Path) -> Self {
        // The system's own link to what is open; nothing between here and there can be exchanged.
        let path = Path::new("/proc/self/fd").join(opened.as_raw_fd().to_string());
        Self {
            path: if name.as_os_str().is_empty() {
                path
            } else {
                path.join(name)
            },
            _held: Some(opened),
        }
    }
}

impl AsRef<Path> for Place {
    fn as_ref(&self) -> &Path {
        &self.path
    }
}

impl Folders {
    /// Opens folders, one at least.
    ///
    /// # Errors
    /// [`FolderAccessError`] when one is not there or is no folder.
    pub fn open(paths: &[PathBuf]) -> Result<Self, FolderAccessError> {
        let open = |path: &PathBuf| -> io::Result<Folder> {
            let flags = OFlag::O_PATH | OFlag::O_DIRECTORY | OFlag::O_CLOEXEC;
            let opened = File::options()
                .read(true)
                .custom_flags(flags.bits())
                .open(path)?;
            Ok(Folder {
                given: std::path::absolute(path)?,
                real: path.canonicalize()?,
                opened: opened.into(),
            })
        };
        let opened = paths.iter().map(|path| {
            open(path).map_err(|source| FolderAccessError {
                path: path.clone(),
                source,
            })
        });
        Ok(Self(opened.collect::<Result<_, _>>()?))
    }

    /// Where relative paths count from at first.
    pub(super) fn first(&self) -> PathBuf {
        self.0
            .first()
            .map_or_else(|| PathBuf::from("/"), |folder| folder.real.clone())
    }

    /// What a path leads to, links followed.
    pub(super) fn target(&self, path: &Path) -> io::Result<Place> {
        let opened = self.resolve(path, OFlag::O_PATH, Mode::empty())?;
        Ok(Place::held(opened, Path::new("")))
    }

    /// The entry of a folder that a path names, a link itself if it is one.
    pub(super) fn entry(&self, path: &Path) -> io::Result<Place> {
        let (Some(folder), Some(Component::Normal(name))) =
            (path.parent(), path.components().next_back())
        else {
            return Err(self.refusal(path));
        };
        if self
            .0
            .iter()
            .any(|folder| folder.given == path || folder.real == path)
        {
            // The folder itself stands in one that is not open.
            return Err(self.refusal(path));
        }
        let opened = self.resolve(folder, OFlag::O_PATH | OFlag::O_DIRECTORY, Mode::empty())?;
        Ok(Place::held(opened, Path::new(name)))
    }

    /// Opens a file.
    pub(super) fn open_file(&self, path: &Path, flags: OFlag) -> io::Result<File> {
        let mode = match flags.contains(OFlag::O_CREAT) {
            true => Mode::from_bits_truncate(0o666),
            false => Mode::empty(),
        };
        self.resolve(path, flags, mode).map(File::from)
    }

    /// The path of a folder, without links.
    pub(super) fn real(&self, path: &Path) -> io::Result<PathBuf> {
        let place = self.target(path)?;
        std::fs::read_link(&place)
    }

    fn resolve(&self, path: &Path, flags: OFlag, mode: Mode) -> io::Result<OwnedFd> {
        let (folder, rest) = self.beneath(path).ok_or_else(|| self.refusal(path))?;
        let how = OpenHow::new()
            .flags(flags | OFlag::O_CLOEXEC)
            .mode(mode)
            .resolve(ResolveFlag::RESOLVE_BENEATH | ResolveFlag::RESOLVE_NO_MAGICLINKS);
        loop {
            return match openat2(&folder.opened, &rest, how) {
                // Somebody moves folders about while the path is walked.
                Err(Errno::EAGAIN | Errno::EINTR) => continue,
                Err(Errno::EXDEV) => Err(self.refusal(path)),
                other => Ok(other?),
            };
        }
    }

    /// The folder that an absolute path lies in, and the way from there; the system looks after `..` and links in it.
    fn beneath(&self, path: &Path) -> Option<(&Folder, PathBuf)> {
        let way = |path: &Path| {
            self.0.iter().find_map(|folder| {
                let rest = path.strip_prefix(&folder.given);
                let rest = rest.or_else(|_| path.strip_prefix(&folder.real)).ok()?;
                let here = rest.as_os_str().is_empty();
                Some((
                    folder,
                    if here {
                        PathBuf::from(".")
                    } else {
                        rest.to_owned()
                    },
                ))
            })
        };
        way(path).or_else(|| {
            // `/data/../data/x` and `/elsewhere/../data/x`: by the words alone, then beneath.
            let mut plain = PathBuf::new();
            for part in path.components() {
                match part {
                    Component::ParentDir => drop(plain.pop()),
                    Component::CurDir => {}
                    part => plain.push(part),
                }
            }
            way(&plain)
        })
    }

    fn refusal(&self, path: &Path) -> io::Error {
        let folders: Vec<String> = self
            .0
            .iter()
            .map(|f| f.given.display().to_string())
            .collect();
        let text = format!(
            "{} is not within {}, which is what --allow fs= opens to programs",
            path.display(),
            folders.join(" or ")
        );
        io::Error::new(io::ErrorKind::PermissionDenied, text)
    }
}
