//! Files that clients and scripts name by a path in the task folder: task files, configurations, micro-line files.
//!
//! Owns the rule that a name never leaves the folder, and which file holds the program of a task: the pendant keeps a
//! task as XML, `NAME.task`, and beside it what it sends to the controller, `NAME.task.script` (from controller output,
//! not from the manual). Errors are one sentence without a line break, for a reply.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::{Component, Path, PathBuf};

use messages::Localized;
use thiserror::Error;

use crate::task::SandboxRoots;

/// Largest file that is read.
pub const FILE_BYTES_MAX: u64 = 8 << 20;

/// A file is seen to be XML by its beginning.
const SNIFFED_BYTES: usize = 1024;

/// Endings of a task file, in the order in which they are tried.
const TASK_ENDINGS: [&str; 2] = ["task", "script"];

/// Endings of a file of points, in the order in which they are tried.
const POINTS_ENDINGS: [&str; 2] = ["txt", "csv"];

/// The reason for which a file of the task folder cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, Error, Localized)]
#[non_exhaustive]
pub enum FolderError {
    /// The name leads out of the folder.
    #[error("{name} leads out of the task folder")]
    #[zh("{name} 超出任务文件夹")]
    Outside {
        /// The name as it was given.
        name: String,
    },
    /// There is no such file.
    #[error("there is no {name} in the task folder")]
    #[zh("任务文件夹中没有 {name}")]
    Missing {
        /// The name as it was given.
        name: String,
    },
    /// The file cannot be read.
    #[error("{name} cannot be read: {reason}")]
    #[zh("无法读取 {name}：{reason}")]
    Unreadable {
        /// The name as it was given.
        name: String,
        /// What the system said.
        reason: String,
    },
    /// The pendant's XML without the program that belongs to it.
    #[error(
        "{name} is a task of the pendant in XML, and {script}, the program that it sends, {trouble}"
    )]
    #[zh("{name} 是示教器的 XML 任务，而它发送的程序 {script} {trouble}")]
    NoProgram {
        /// The name as it was given.
        name: String,
        /// The file that should hold the program.
        script: String,
        /// What is wrong with that file.
        trouble: String,
    },
}

/// The text of a task.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TaskText {
    /// The name of the file that holds the program: as given, or that of the program beside the pendant's XML.
    pub name: String,
    /// The program.
    pub text: String,
}

/// Whether a file that begins so is XML: no program begins with `<`.
pub fn is_xml(beginning: &[u8]) -> bool {
    let marks: [&[u8]; 3] = [b"\xEF\xBB\xBF", b"\xFF\xFE", b"\xFE\xFF"];
    let mark = marks.iter().find_map(|mark| beginning.strip_prefix(*mark));
    // In UTF-16 every other byte of these texts is 0.
    let is_blank = |byte: &u8| byte.is_ascii_whitespace() || *byte == 0;
    let mut bytes = mark.unwrap_or(beginning).iter().skip_while(|b| is_blank(b));
    bytes.next() == Some(&b'<')
}

/// The folder from which tasks, their modules and files of points are read.
#[derive(Clone, Debug)]
pub struct TaskFolder {
    root: PathBuf,
    /// The folders beneath which files may be; `None`: no limit.
    within: Option<SandboxRoots>,
}

impl TaskFolder {
    /// A folder; it need not exist before something is read from it.
    pub fn new(root: impl Into<PathBuf>) -> Self {
        Self {
            root: root.into(),
            within: None,
        }
    }

    /// Limits the folder to files beneath certain folders, links followed; `None`: no limit.
    pub fn with_sandbox(self, within: Option<SandboxRoots>) -> Self {
        Self { within, ..self }
    }

    /// The path of the folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The text of a task: the file of this name, or the one with `.task` or `.script` after it. A name that has one of
    /// these endings also stands for the file with the other. Any other dot belongs to the name: `v1.2` is never `v1`.
    /// If that file is the pendant's XML, the text is that of the file with `.script` after its whole name.
    ///
    /// # Errors
    /// [`FolderError`]
    pub fn task(&self, name: &str) -> Result<TaskText, FolderError> {
        let inside = path_inside(name)?;
        let without = |ending: &str| name.strip_suffix(ending)?.strip_suffix('.');
        let stem = TASK_ENDINGS.into_iter().find_map(without).unwrap_or(name);
        let with_endings = TASK_ENDINGS.map(|ending| path_inside(&format!("{stem}.{ending}")));
        for path in [Ok(inside)].into_iter().chain(with_endings).flatten() {
            match self.read_unless_xml(&path, name) {
                Err(FolderError::Missing { .. }) => {}
                Ok(Some(text)) => {
                    let name = name.to_owned();
                    return Ok(TaskText { name, text });
                }
                Ok(None) => return self.companion_script(&path, name),
                Err(error) => return Err(error),
            }
        }
        Err(missing(name))
    }

    /// The program that belongs to the XML at `path`.
    fn companion_script(&self, path: &Path, name: &str) -> Result<TaskText, FolderError> {
        let script = format!("{}.script", path.display());
        let trouble = match self.read_unless_xml(Path::new(&script), &script) {
            Ok(Some(text)) => return Ok(TaskText { name: script, text }),
            Ok(None) => "is XML too".to_owned(),
            Err(FolderError::Missing { .. }) => "is not beside it".to_owned(),
            Err(FolderError::Unreadable { reason, .. }) => format!("cannot be read: {reason}"),
            Err(error) => return Err(error),
        };
        Err(FolderError::NoProgram {
            name: name.to_owned(),
            script,
            trouble,
        })
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
        self.read_text(inside, name, false)
            .map(Option::unwrap_or_default)
    }

    /// None for XML, which is not read.
    fn read_unless_xml(&self, inside: &Path, name: &str) -> Result<Option<String>, FolderError> {
        self.read_text(inside, name, true)
    }

    /// The path of a file, without links, none of which may lead out of the folder.
    fn path_of(&self, inside: &Path, name: &str) -> Result<PathBuf, FolderError> {
        let resolve = |path: &Path| path.canonicalize().map_err(|error| not_found(name, &error));
        let root = resolve(&self.root)?;
        let path = resolve(&root.join(inside))?;
        match path.starts_with(&root) {
            true => Ok(path),
            false => Err(FolderError::Outside {
                name: name.to_owned(),
            }),
        }
    }

    fn read_text(
        &self,
        inside: &Path,
        name: &str,
        sniffs: bool,
    ) -> Result<Option<String>, FolderError> {
        let unreadable = |reason: String| FolderError::Unreadable {
            name: name.to_owned(),
            reason,
        };
        // Held until it is read: nothing can be put into its place meanwhile.
        let held;
        let path = match &self.within {
            None => self.path_of(inside, name)?,
            Some(folders) => {
                let found = folders.find(&self.root.join(inside));
                held = found.map_err(|error| not_found(name, &error))?;
                held.as_ref().to_owned()
            }
        };
        if !path.is_file() {
            return Err(missing(name));
        }
        let mut text = String::new();
        let file = fs::File::open(&path).map_err(|error| unreadable(error.to_string()))?;
        let mut reader = BufReader::with_capacity(SNIFFED_BYTES, file.take(FILE_BYTES_MAX + 1));
        let beginning = reader.fill_buf();
        if sniffs && is_xml(beginning.map_err(|error| unreadable(error.to_string()))?) {
            return Ok(None);
        }
        reader
            .read_to_string(&mut text)
            .map_err(|error| unreadable(error.to_string()))?;
        if text.len() as u64 > FILE_BYTES_MAX {
            return Err(unreadable(format!(
                "it is larger than {} MiB",
                FILE_BYTES_MAX >> 20
            )));
        }
        Ok(Some(text))
    }
}

/// What an error of the system means for a file of the folder.
fn not_found(name: &str, error: &std::io::Error) -> FolderError {
    match error.kind() {
        std::io::ErrorKind::NotFound | std::io::ErrorKind::NotADirectory => missing(name),
        _ => FolderError::Unreadable {
            name: name.to_owned(),
            reason: error.to_string(),
        },
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

    /// The text of a task.
    fn task(folder: &TaskFolder, name: &str) -> Result<String, FolderError> {
        folder.task(name).map(|task| task.text)
    }

    #[test]
    fn the_program_of_the_pendants_xml_is_beside_it() {
        let (dir, folder) = folder();
        let tasks = dir.path().join("tasks");
        let xml = "\u{feff}\n <?xml version=\"1.0\"?>\n<EliTask name=\"w\"/>";
        for name in ["w", "w.1", "sub/w", "alone", "wide", "twice"] {
            fs::write(tasks.join(format!("{name}.task")), xml).unwrap();
            if name != "alone" {
                fs::write(tasks.join(format!("{name}.task.script")), name).unwrap();
            }
        }
        let wide: Vec<u8> = "\u{feff}<EliTask/>"
            .encode_utf16()
            .flat_map(u16::to_le_bytes)
            .collect();
        fs::write(tasks.join("wide.task"), wide).unwrap();
        fs::write(tasks.join("twice.task.script"), xml).unwrap();
        for (name, file) in [
            ("w", "w"),
            ("w.task", "w"),
            ("w.script", "w"),
            ("w.1", "w.1"),
            ("w.1.task", "w.1"),
            ("sub/w.task", "sub/w"),
            ("wide", "wide"),
        ] {
            let expected = TaskText {
                name: format!("{file}.task.script"),
                text: file.to_owned(),
            };
            assert_eq!(folder.task(name), Ok(expected), "{name}");
        }
        let direct = folder.task("w.task.script").unwrap();
        assert_eq!((&*direct.name, &*direct.text), ("w.task.script", "w"));
        for (name, sentence) in [
            (
                "alone",
                "alone is a task of the pendant in XML, and alone.task.script, the program that it sends, \
                 is not beside it",
            ),
            (
                "twice.task",
                "twice.task is a task of the pendant in XML, and twice.task.script, \
                 the program that it sends, is XML too",
            ),
        ] {
            assert_eq!(folder.task(name).unwrap_err().to_string(), sentence);
        }
        // A text task is the program, and XML of other files is their business.
        assert_eq!(task(&folder, "a").as_deref(), Ok("a"));
        assert!(folder.file("w.task").unwrap().contains("EliTask"));
    }

    #[test]
    fn only_what_begins_with_a_bracket_is_xml() {
        for xml in ["<EliTask/>", " \t\r\n<?xml?>", "\u{feff}<!-- a -->", "<"] {
            assert!(is_xml(xml.as_bytes()), "{xml}");
        }
        for text in [
            "",
            "def f():",
            "x < 1",
            "# <EliTask/>",
            "\u{feff}",
            "$ LINE: (1, '<')",
        ] {
            assert!(!is_xml(text.as_bytes()), "{text}");
        }
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
            assert_eq!(task(&folder, name).as_deref(), Ok(text), "{name}");
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
            assert_eq!(task(&folder, name).as_deref(), Ok(text), "{name}");
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
