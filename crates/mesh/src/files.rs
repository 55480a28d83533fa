//! Where meshes come from: a trait, and the folder of a cell file on the disk.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use messages::Text;

use crate::error::FileError;

/// Files by name. A recording can be one, and so can a folder.
pub trait MeshFiles {
    /// The bytes of a file, at most `most` of them. `path` is relative, with `/` between folders.
    ///
    /// # Errors
    /// A file that is not there or cannot be read, and one of more than `most` bytes.
    fn read(&mut self, path: &str, most: u64) -> Result<Vec<u8>, FileError>;
}

/// A folder of the disk, and nothing outside of it.
///
/// Links are followed as long as each leads to something within the folder that the link is in. So a buffer that
/// stands beside a glTF file is beside it, and not only somewhere in the folder of the cell.
#[derive(Clone, Debug)]
pub struct Folder {
    root: PathBuf,
}

impl Folder {
    /// The folder at this path. Whether it exists shows when a file is read.
    pub fn new(root: impl Into<PathBuf>) -> Self {
        Self { root: root.into() }
    }

    /// The real path of a file, which is proven to be within the folder.
    fn resolve(&self, path: &str) -> Result<PathBuf, FileError> {
        let names = names_within(path)?;
        let start = if self.root.as_os_str().is_empty() {
            Path::new(".")
        } else {
            &self.root
        };
        let mut reached = start.canonicalize().map_err(system)?;
        for name in names {
            let next = reached.join(name).canonicalize().map_err(system)?;
            if !next.starts_with(&reached) {
                return Err(FileError::Outside);
            }
            reached = next;
        }
        Ok(reached)
    }
}

impl MeshFiles for Folder {
    fn read(&mut self, path: &str, most: u64) -> Result<Vec<u8>, FileError> {
        let found = self.resolve(path)?;
        // Looked at before it is opened as well: to open a pipe waits for its writer.
        if !found.metadata().map_err(system)?.is_file() {
            return Err(FileError::Irregular);
        }
        let file = File::open(&found).map_err(system)?;
        let facts = file.metadata().map_err(system)?;
        if !facts.is_file() {
            return Err(FileError::Irregular);
        }
        if facts.len() > most {
            return Err(FileError::TooLong { most });
        }
        let mut bytes = Vec::new();
        // A file may grow while it is read, and some of /proc say that they have no bytes.
        file.take(most.saturating_add(1))
            .read_to_end(&mut bytes)
            .map_err(system)?;
        if bytes.len() as u64 > most {
            return Err(FileError::TooLong { most });
        }
        Ok(bytes)
    }
}

/// The names that a path goes through, without `.` and `..`; an error where it leaves the folder.
fn names_within(path: &str) -> Result<Vec<&str>, FileError> {
    // A backslash and a colon lead elsewhere on Windows, and names with them are no use anywhere.
    if path.starts_with('/') || path.contains(['\\', '\0']) || path.get(1..2) == Some(":") {
        return Err(FileError::Outside);
    }
    let mut names = Vec::new();
    for name in path.split('/') {
        match name {
            "" | "." => {}
            ".." => _ = names.pop().ok_or(FileError::Outside)?,
            name => names.push(name),
        }
    }
    if names.is_empty() {
        return Err(FileError::Irregular);
    }
    Ok(names)
}

fn system(error: std::io::Error) -> FileError {
    FileError::System(Text::of(&error))
}
