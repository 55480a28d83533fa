//! Files that clients and scripts name by a path in the task folder: task files, configurations, micro-line files.
//!
//! Owns the rule that a name never leaves the folder. Errors are one sentence without a line break, for a reply.

use std::fs;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use thiserror::Error;

/// Largest file that is read.
pub const FILE_BYTES_MAX: u64 = 8 << 20;

/// Endings of a task file, in the order in which they are tried.
const TASK_ENDINGS: [&str; 2] = ["task", "script"];

/// Endings of a file of points, in the order in which they are tried.
const POINTS_ENDINGS: [&str; 2] = ["txt", "csv"];

/// Why a file of the folder cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum FolderError {
    /// The name leads elsewhere.
    #[error("{name} leads out of the task folder")]
    Outside {
        /// As given.
        name: String,
    },
    /// There is no such file.
    #[error("there is no {name} in the task folder")]
    Missing {
        /// As given.
        name: String,
    },
    /// It cannot be read.
    #[error("{name} cannot be read: {reason}")]
    Unreadable {
        /// As given.
        name: String,
        /// What the system said.
        reason: String,
    },
}

/// The folder.
#[derive(Clone, Debug)]
pub struct TaskFolder {
    root: PathBuf,
}

impl TaskFolder {
    /// A folder; it need not exist before something is read from it.
    pub fn new(root: impl Into<PathBuf>) -> Self {
        Self { root: root.into() }
    }

    /// The text of a task: the file of this name, or the one with `.task` or `.script` after it. A name that has one of
    /// these endings also stands for the file with the other. Any other dot belongs to the name: `v1.2` is never `v1`.
    ///
    /// # Errors
    /// [`FolderError`]
    pub fn task(&self, name: &str) -> Result<String, FolderError> {
        let inside = path_inside(name)?;
        let without = |ending: &str| name.strip_suffix(ending)?.strip_suffix('.');
        let stem = TASK_ENDINGS.into_iter().find_map(without).unwrap_or(name);
        let with_endings = TASK_ENDINGS.map(|ending| path_inside(&format!("{stem}.{ending}")));
        self.first([Ok(inside)].into_iter().chain(with_endings).flatten(), name)
    }

    /// The text of a file of points: the file of this name, or the one with `.txt` or `.csv` after it.
    ///
    /// # Errors
    /// [`FolderError`]
    pub fn points(&self, name: &str) -> Result<String, FolderError> {
        let inside = path_inside(name)?;
        let others = POINTS_ENDINGS.map(|ending| path_inside(&format!("{name}.{ending}")));
        self.first([Ok(inside)].into_iter().chain(others).flatten(), name)
    }

    /// The text of the first of the files that there is.
    fn first(
        &self,
        paths: impl Iterator<Item = PathBuf>,
        name: &str,
    ) -> Result<String, FolderError> {
        for path in paths {
            match self.read(&path, name) {
                Err(FolderError::Missing { .. }) => {}
                found => return found,
            }
        }
        Err(missing(name))
    }

    /// The text of a file of exactly this name.
    ///
    /// # Errors
    /// [`FolderError`]
    pub fn file(&self, name: &str) -> Result<String, FolderError> {
        self.read(&path_inside(name)?, name)
    }

    fn read(&self, inside: &Path, name: &str) -> Result<String, FolderError> {
        let unreadable = |reason: String| FolderError::Unreadable {
            name: name.to_owned(),
            reason,
        };
        let resolve = |path: &Path| {
            path.canonicalize().map_err(|error| match error.kind() {
                std::io::ErrorKind::NotFound | std::io::ErrorKind::NotADirectory => missing(name),
                _ => unreadable(error.to_string()),
            })
        };
        let root = resolve(&self.root)?;
        let path = resolve(&root.join(inside))?;
        // A link in the folder may lead anywhere.
        if !path.starts_with(&root) {
            return Err(FolderError::Outside {
                name: name.to_owned(),
            });
        }
        if !path.is_file() {
            return Err(missing(name));
        }
        let mut text = String::new();
        let file = fs::File::open(&path).map_err(|error| unreadable(error.to_string()))?;
        file.take(FILE_BYTES_MAX + 1)
            .read_to_string(&mut text)
            .map_err(|error| unreadable(error.to_string()))?;
        if text.len() as u64 > FILE_BYTES_MAX {
            return Err(unreadable(format!(
                "it is larger than {} MiB",
                FILE_BYTES_MAX >> 20
            )));
        }
        Ok(text)
    }
}

/// The name as a path that goes down only.
fn path_inside(name: &str) -> Result<PathBuf, FolderError> {
    let path = Path::new(name);
    let goes_down = |part| matches!(part, Component::Normal(_) | Component::CurDir);
    if name.is_empty() || name.contains('\0') || !path.components().all(goes_down) {
        return Err(FolderError::Outside {
            name: name.to_owned(),
        });
    }
    Ok(path.to_owned())
}

fn missing(name: &str) -> FolderError {
    FolderError::Missing {
        name: name.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder() -> (tempfile::TempDir, TaskFolder) {
        let dir = tempfile::tempdir().unwrap();
        let tasks = dir.path().join("tasks");
        fs::create_dir_all(tasks.join("sub")).unwrap();
        fs::write(tasks.join("a.task"), "a").unwrap();
        fs::write(tasks.join("b.script"), "b").unwrap();
        fs::write(tasks.join("sub/c.script"), "c").unwrap();
        fs::write(tasks.join("v1.task"), "v1").unwrap();
        fs::write(tasks.join("v1.2.task"), "v1.2").unwrap();
        fs::write(tasks.join("v1.2.3.script"), "v1.2.3").unwrap();
        fs::write(tasks.join("sub/pick.fast.script"), "fast").unwrap();
        fs::create_dir_all(tasks.join("rev.1")).unwrap();
        fs::write(tasks.join("rev.1/a.b.task"), "a.b").unwrap();
        fs::write(dir.path().join("secret.task"), "secret").unwrap();
        std::os::unix::fs::symlink(dir.path().join("secret.task"), tasks.join("link.task"))
            .unwrap();
        (dir, TaskFolder::new(tasks))
    }

    #[test]
    fn a_task_is_found_by_its_name_or_by_its_stem() {
        let (_dir, folder) = folder();
        for (name, text) in [
            ("a.task", "a"),
            ("a", "a"),
            ("b.task", "b"),
            ("b", "b"),
            ("./b.script", "b"),
            ("sub/c.task", "c"),
        ] {
            assert_eq!(folder.task(name).as_deref(), Ok(text), "{name}");
        }
        assert_eq!(folder.file("a.task").as_deref(), Ok("a"));
        assert_eq!(
            folder.file("a").unwrap_err().to_string(),
            "there is no a in the task folder"
        );
    }

    #[test]
    fn a_dot_in_a_name_is_part_of_the_name() {
        let (_dir, folder) = folder();
        for (name, text) in [
            ("v1", "v1"),
            ("v1.2", "v1.2"),
            ("v1.2.task", "v1.2"),
            ("v1.2.script", "v1.2"),
            ("v1.2.3", "v1.2.3"),
            ("v1.2.3.task", "v1.2.3"),
            ("sub/pick.fast", "fast"),
            ("rev.1/a.b", "a.b"),
        ] {
            assert_eq!(folder.task(name).as_deref(), Ok(text), "{name}");
        }
        for missing in [
            "v1.3", "v1.2.4", "a.b", "a.txt", "sub/pick", "rev.1", "v1.", ".task",
        ] {
            assert!(
                matches!(folder.task(missing), Err(FolderError::Missing { .. })),
                "{missing}: {:?}",
                folder.task(missing)
            );
        }
    }

    #[test]
    fn a_name_never_leads_out_of_the_folder() {
        let (dir, folder) = folder();
        let absolute = dir.path().join("secret.task");
        for name in [
            "../secret.task",
            "sub/../../secret.task",
            "link.task",
            absolute.to_str().unwrap(),
            "",
            "a\0b",
        ] {
            assert!(
                matches!(folder.task(name), Err(FolderError::Outside { .. })),
                "{name:?}: {:?}",
                folder.task(name)
            );
        }
    }

    #[test]
    fn what_is_no_file_of_text_is_named() {
        let (dir, folder) = folder();
        fs::write(dir.path().join("tasks/bytes.task"), [0xff, 0xfe]).unwrap();
        assert!(matches!(
            folder.task("bytes.task"),
            Err(FolderError::Unreadable { .. })
        ));
        for name in ["sub", "nothing", "a.task/b"] {
            assert!(
                matches!(folder.task(name), Err(FolderError::Missing { .. })),
                "{name}"
            );
        }
        let nowhere = TaskFolder::new("/nonexistent/tasks");
        assert!(matches!(
            nowhere.task("a"),
            Err(FolderError::Missing { .. })
        ));
    }
}
