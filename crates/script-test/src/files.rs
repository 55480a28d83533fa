//! The files of tests: all that this user may reach, or those beneath some folders only.

use std::io;
use std::path::Path;

use elite_runtime::{SandboxRoots, SandboxedPath};

/// The files that may hold tests and the programs they start.
#[derive(Clone, Debug, Default)]
pub struct FileScope(Option<SandboxRoots>);

impl FileScope {
    /// Those beneath these folders; no link leads out of them.
    pub const fn beneath(folders: SandboxRoots) -> Self {
        Self(Some(folders))
    }

    /// Path of a file or a folder, if it is within the scope.
    pub(crate) fn find(&self, path: &Path) -> io::Result<SandboxedPath> {
        match &self.0 {
            Some(folders) => folders.find(path),
            None => Ok(SandboxedPath::unrestricted(path.to_owned())),
        }
    }

    /// A text of at most `bytes_max` bytes; `Err(Ok(bytes))` when it is longer.
    pub(crate) fn text(
        &self,
        path: &Path,
        bytes_max: u64,
    ) -> Result<String, Result<u64, io::Error>> {
        let place = self.find(path).map_err(Err)?;
        let found = std::fs::metadata(&place).map_err(Err)?;
        if found.is_dir() {
            return Err(Err(io::ErrorKind::IsADirectory.into()));
        }
        if found.len() > bytes_max {
            return Err(Ok(found.len()));
        }
        std::fs::read_to_string(&place).map_err(Err)
    }

    /// Writes a text; its folders are made.
    pub(crate) fn write(&self, path: &Path, text: &str) -> io::Result<()> {
        match &self.0 {
            Some(folders) => std::fs::write(folders.make_file(path)?, text),
            None => {
                if let Some(folder) = path.parent() {
                    std::fs::create_dir_all(folder)?;
                }
                std::fs::write(path, text)
            }
        }
    }

    /// A folder, which is made; hold what comes back for as long as its path is used.
    pub(crate) fn make_folder(&self, path: &Path) -> io::Result<SandboxedPath> {
        match &self.0 {
            Some(folders) => folders.make_folder(path),
            None => {
                std::fs::create_dir_all(path)?;
                Ok(SandboxedPath::unrestricted(path.to_owned()))
            }
        }
    }

    /// Removes a file.
    pub(crate) fn remove_file(&self, path: &Path) -> io::Result<()> {
        match (&self.0, path.parent(), path.file_name()) {
            (Some(folders), Some(folder), Some(name)) => {
                let folder = folders.find(folder)?;
                std::fs::remove_file(folder.as_ref().join(name))
            }
            _ => std::fs::remove_file(path),
        }
    }
}
