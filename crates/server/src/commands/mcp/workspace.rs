//! The folder that an assistant works in: every file that a tool reads or writes is found from here, by the system
//! itself, beneath the folder (`..`, links and `/proc` lead nowhere else).

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use elite_runtime::{ProgramText, SandboxError, SandboxRoots};
use recorder::Recording;

use crate::commands::check::program_of;
use crate::ports::escape::EscapedText;

/// Reason that people are told when they ask for other files.
const BECAUSE: &str = "the folder that eliteserver mcp was started in";

/// Longest path that is taken, bytes.
const PATH_BYTES_MAX: usize = 4096;

/// Set when nobody waits for an answer any more.
pub(super) type CancelFlag = Arc<AtomicBool>;

/// The folder. Clones share it.
#[derive(Clone)]
pub(super) struct Workspace {
    root: PathBuf,
    folders: SandboxRoots,
}

impl Workspace {
    /// Opens the folder.
    pub(super) fn open(root: &Path) -> Result<Self, SandboxError> {
        let folders = SandboxRoots::open_with_reason(&[root.to_owned()], BECAUSE)?;
        Ok(Self {
            root: std::path::absolute(root).unwrap_or_else(|_| root.to_owned()),
            folders,
        })
    }

    /// Absolute path of the folder.
    pub(super) fn root(&self) -> &Path {
        &self.root
    }

    /// The folder as the only root that paths may lead into.
    pub(super) const fn folders(&self) -> &SandboxRoots {
        &self.folders
    }

    /// A path that somebody named. Whether it leads out of the folder is seen when it is used.
    pub(super) fn path(&self, argument: &str, given: &str) -> Result<PathBuf, String> {
        if given.is_empty() || given.len() > PATH_BYTES_MAX || given.contains('\0') {
            return Err(format!(
                "{argument} must be a path of 1 to {PATH_BYTES_MAX} bytes without null characters"
            ));
        }
        Ok(PathBuf::from(given))
    }

    /// The text of a program.
    pub(super) fn program(&self, argument: &str, given: &str) -> Result<ProgramText, String> {
        let path = self.path(argument, given)?;
        program_of(&path, &|path| {
            let place = self.folders.find(path)?;
            regular(&place)?;
            File::open(&place)
        })
        .map_err(|text| text.to_string())
    }

    /// A recording that can be read any number of times, until `stop` is set.
    pub(super) fn recording(&self, given: &str, stop: &CancelFlag) -> Result<Recording, String> {
        let path = self.path("recording", given)?;
        let shown = EscapedText(given);
        let place = self.folders.find(&path).and_then(|place| {
            regular(&place)?;
            Ok(place)
        });
        // Held by the recording, so that what is read again is the same file.
        let place = place.map_err(|error| format!("cannot read {shown}: {error}"))?;
        let stop = stop.clone();
        let open = move || -> io::Result<Box<dyn Read>> {
            Ok(Box::new(CancellableReader(
                File::open(&place)?,
                stop.clone(),
            )))
        };
        Recording::from_opener(open, given).map_err(|error| error.to_string())
    }
}

/// Refuses what is no file: a pipe would keep its reader waiting.
fn regular(place: impl AsRef<Path>) -> io::Result<()> {
    match std::fs::metadata(place)?.is_file() {
        true => Ok(()),
        false => Err(io::Error::new(
            io::ErrorKind::Unsupported,
            "it is no regular file",
        )),
    }
}

/// A file that ends when nobody wants it any more.
struct CancellableReader(File, CancelFlag);

impl Read for CancellableReader {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.1.load(Ordering::Relaxed) {
            return Err(io::Error::other("the call was cancelled"));
        }
        self.0.read(buffer)
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    #[test]
    fn no_name_leads_out_of_the_folder() {
        let around = tempfile::tempdir().unwrap();
        std::fs::write(around.path().join("secret.script"), "print(1)").unwrap();
        let inner = around.path().join("inner");
        std::fs::create_dir_all(inner.join("sub")).unwrap();
        std::fs::write(inner.join("own.script"), "print(2)").unwrap();
        symlink("../secret.script", inner.join("link.script")).unwrap();
        symlink("..", inner.join("up")).unwrap();
        symlink("../own.script", inner.join("sub/back.script")).unwrap();
        symlink("/proc/self/cwd", inner.join("magic")).unwrap();
        let workspace = Workspace::open(&inner).unwrap();
        let name = |path: &str| inner.join(path).display().to_string();
        for own in ["own.script", "sub/../own.script", "sub/back.script"] {
            let text = workspace.program("file", &name(own)).unwrap().text;
            assert_eq!(text, "print(2)", "{own}");
        }
        let outside = around.path().join("secret.script").display().to_string();
        let through_proc = format!("/proc/self/root{outside}");
        for other in [
            &name("link.script"),
            &name("../secret.script"),
            &name("up/secret.script"),
            &name("magic/Cargo.toml"),
            &outside,
            &through_proc,
            "/etc/passwd",
            "/proc/self/environ",
        ] {
            let error = workspace.program("file", other).unwrap_err();
            assert!(error.contains("is not within"), "{other}: {error}");
        }
        for write in ["link.script", "up/new.script", "../new", "magic/new"] {
            let made = workspace.folders().make_file(&inner.join(write));
            assert_eq!(
                made.unwrap_err().kind(),
                io::ErrorKind::PermissionDenied,
                "{write}"
            );
        }
        assert_eq!(
            std::fs::read_to_string(around.path().join("secret.script")).unwrap(),
            "print(1)"
        );
        workspace
            .folders()
            .make_file(&inner.join("new/deep/a.mcap"))
            .unwrap();
        assert!(inner.join("new/deep/a.mcap").is_file());
    }

    #[test]
    fn pipes_and_folders_are_no_programs_and_keep_nobody_waiting() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        nix::unistd::mkfifo(&pipe, nix::sys::stat::Mode::S_IRWXU).unwrap();
        let workspace = Workspace::open(folder.path()).unwrap();
        for path in [pipe.as_path(), folder.path()] {
            let error = workspace.program("file", &path.display().to_string());
            assert!(error.unwrap_err().contains("no regular file"));
        }
        assert!(workspace.folders().make_file(&pipe).is_err());
        for wrong in ["", "a\0b", &"x".repeat(5000)] {
            let error = workspace.program("file", wrong).unwrap_err();
            assert!(error.contains("file must be a path"), "{error}");
        }
    }
}
