//! Files beneath some folders and nowhere else: those of programs (`--allow fs=DIR`), and of whoever else is held to
//! folders.
//!
//! The folders are opened once. Every path is resolved by the system itself, beneath one of them: `..`, symbolic links,
//! `/proc` and folders that are moved meanwhile lead nowhere else, whoever else works there at the same time. What is
//! found is held open while it is used, so what was looked at is what is used.

use std::fs::File;
use std::io;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use messages::Localized;
use platform::beneath::{ConfinedDir as Held, ConfinedEntry};
use platform::files::OpenMode;
use thiserror::Error;

/// The folders that somebody may use. Clones share them.
#[derive(Clone, Debug)]
pub struct SandboxRoots {
    all: Arc<[SandboxRoot]>,
    /// The end of the error for a path outside them, which says who chose these folders: "which is what …".
    because: &'static str,
}

/// Clones are the same folders; those that were opened apart are not.
impl PartialEq for SandboxRoots {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.all, &other.all)
    }
}

/// The end of the error for a program's path outside its folders.
const ALLOWED_TO_PROGRAMS: &str = "which is what --allow fs= opens to programs";

/// A folder that cannot be opened to programs.
#[derive(Debug, Error, Localized)]
#[error("programs cannot be given the folder {}: {source}", path.display())]
#[zh("不能把文件夹 {} 给程序使用：{source}", path.display())]
pub struct SandboxError {
    path: PathBuf,
    source: io::Error,
}

#[derive(Debug)]
struct SandboxRoot {
    /// The absolute path of the folder as it was given; `real` is the one without links.
    given: PathBuf,
    real: PathBuf,
    opened: Held,
}

/// Where something is, as long as this is held: a path that leads there whatever becomes of the names on the way.
#[derive(Debug)]
pub struct SandboxedPath {
    path: PathBuf,
    _held: Option<ConfinedEntry>,
}

impl SandboxedPath {
    /// A path that is used as it is.
    pub const fn unrestricted(path: PathBuf) -> Self {
        Self { path, _held: None }
    }

    /// The system's own link to what is open.
    fn held(opened: ConfinedEntry, name: &Path) -> Self {
        let path = opened.path();
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

impl AsRef<Path> for SandboxedPath {
    fn as_ref(&self) -> &Path {
        &self.path
    }
}

impl SandboxRoots {
    /// Opens folders to programs, one at least.
    ///
    /// # Errors
    /// [`SandboxError`] when one is not there or is no folder.
    pub fn open(paths: &[PathBuf]) -> Result<Self, SandboxError> {
        Self::open_with_reason(paths, ALLOWED_TO_PROGRAMS)
    }

    /// Opens folders, one at least; `because` ends the error for a path outside them: "the folder it was started in".
    ///
    /// # Errors
    /// [`SandboxError`] when one is not there or is no folder.
    pub fn open_with_reason(
        paths: &[PathBuf],
        because: &'static str,
    ) -> Result<Self, SandboxError> {
        let open = |path: &PathBuf| -> io::Result<SandboxRoot> {
            Ok(SandboxRoot {
                opened: Held::open(path)?,
                given: std::path::absolute(path)?,
                real: path.canonicalize()?,
            })
        };
        let opened = paths.iter().map(|path| {
            open(path).map_err(|source| SandboxError {
                path: path.clone(),
                source,
            })
        });
        Ok(Self {
            all: opened.collect::<Result<_, _>>()?,
            because,
        })
    }

    /// What a path leads to, links followed; relative paths count from the current folder.
    ///
    /// # Errors
    /// It is not there, or not beneath these folders.
    pub fn find(&self, path: &Path) -> io::Result<SandboxedPath> {
        self.target(&std::path::absolute(path)?)
    }

    /// A text.
    ///
    /// # Errors
    /// It is not there, not beneath these folders, no file, or no UTF-8.
    pub fn read_text(&self, path: &Path) -> io::Result<String> {
        let place = self.find(path)?;
        match std::fs::metadata(&place)?.is_file() {
            true => kinematics::text_file::read_text_file(place.as_ref()),
            false => Err(io::Error::new(
                io::ErrorKind::Unsupported,
                "it is no regular file",
            )),
        }
    }

    /// A regular file that can be written, emptied or made anew; its folders are made where they are not there.
    ///
    /// # Errors
    /// It is not beneath these folders, is something else than a file, or the system does not let it be written.
    pub fn make_file(&self, path: &Path) -> io::Result<SandboxedPath> {
        let path = std::path::absolute(path)?;
        if let Some(folder) = path.parent() {
            self.make_folder(folder)?;
        }
        let mode = OpenMode {
            write: true,
            create: true,
            ..OpenMode::default()
        };
        let file = self.open_file(&path, mode)?;
        if !file.metadata()?.is_file() {
            let text = "it is no regular file";
            return Err(io::Error::new(io::ErrorKind::Unsupported, text));
        }
        file.set_len(0)?;
        Ok(SandboxedPath::held(
            ConfinedEntry::from_file(file),
            Path::new(""),
        ))
    }

    /// Makes a folder and those around it, as far as they are not there.
    ///
    /// # Errors
    /// It is not beneath these folders, or the system does not let it be made.
    pub fn make_folder(&self, path: &Path) -> io::Result<SandboxedPath> {
        let path = std::path::absolute(path)?;
        match self.target(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            other => return other,
        }
        if let Some(around) = path.parent() {
            self.make_folder(around)?;
        }
        match std::fs::create_dir(self.entry(&path)?) {
            // Somebody else has just made it.
            Err(error) if error.kind() != io::ErrorKind::AlreadyExists => Err(error),
            _ => self.target(&path),
        }
    }

    /// Where relative paths count from at first.
    pub(super) fn first(&self) -> PathBuf {
        self.all
            .first()
            .map_or_else(|| PathBuf::from("/"), |folder| folder.real.clone())
    }

    /// What a path leads to, links followed.
    pub(super) fn target(&self, path: &Path) -> io::Result<SandboxedPath> {
        let opened = self.within(path, |folder, way| folder.find(way))?;
        Ok(SandboxedPath::held(opened, Path::new("")))
    }

    /// The entry of a folder that a path names, a link itself if it is one.
    pub(super) fn entry(&self, path: &Path) -> io::Result<SandboxedPath> {
        let (Some(folder), Some(Component::Normal(name))) =
            (path.parent(), path.components().next_back())
        else {
            return Err(self.refusal(path));
        };
        if self
            .all
            .iter()
            .any(|folder| folder.given == path || folder.real == path)
        {
            // The folder itself stands in one that is not open.
            return Err(self.refusal(path));
        }
        let opened = self.within(folder, |folder, way| folder.find_folder(way))?;
        Ok(SandboxedPath::held(opened, Path::new(name)))
    }

    /// Opens a file.
    pub(super) fn open_file(&self, path: &Path, mode: OpenMode) -> io::Result<File> {
        self.within(path, |folder, way| folder.file(way, mode))
    }

    /// The path of a folder, without links.
    pub(super) fn real(&self, path: &Path) -> io::Result<PathBuf> {
        let place = self.target(path)?;
        std::fs::read_link(&place)
    }

    /// Does something with the folder that a path lies in and the way from there.
    fn within<T>(
        &self,
        path: &Path,
        act: impl FnOnce(&Held, &Path) -> io::Result<T>,
    ) -> io::Result<T> {
        let (folder, way) = self.beneath(path).ok_or_else(|| self.refusal(path))?;
        act(&folder.opened, &way).map_err(|error| match error.kind() {
            io::ErrorKind::CrossesDevices => self.refusal(path),
            _ => error,
        })
    }

    /// The folder that an absolute path lies in, and the way from there; the system looks after `..` and links in it.
    fn beneath(&self, path: &Path) -> Option<(&SandboxRoot, PathBuf)> {
        let way = |path: &Path| {
            self.all.iter().find_map(|folder| {
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
            .all
            .iter()
            .map(|f| f.given.display().to_string())
            .collect();
        let text = format!(
            "{} is not within {}, {}",
            path.display(),
            folders.join(" or "),
            self.because
        );
        io::Error::new(io::ErrorKind::PermissionDenied, text)
    }
}
