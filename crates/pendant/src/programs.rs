//! Programs of the task folder as the page lists, opens and saves them, and the robot's functions.
//!
//! Owns the guard against lost updates: a text is saved only over the one that it was made from. Names never lead out
//! of the folder; reading goes through [`TaskFolder`], which has that rule.

use std::collections::hash_map::DefaultHasher;
use std::fs;
use std::hash::{Hash as _, Hasher as _};
use std::io::{self, Write as _};
use std::path::{Component, Path, PathBuf};

use elite_runtime::builtins::{self, declare::FROM_OUTPUT};
use elite_runtime::task_folder::{FolderError, TaskFolder};
use messages::Localized;
use serde_json::{Value, json};
use thiserror::Error;

use crate::orders::{NAME_BYTES_MAX, PROGRAM_BYTES_MAX};

/// Most programs in a list.
pub const LISTED_MAX: usize = 1000;
/// Folders are looked into so deep.
const DEPTH_MAX: usize = 4;
/// Folder entries that are looked at.
const LOOKED_AT_MAX: usize = 20_000;

/// A reason why a program was not saved, told in a sentence.
#[derive(Debug, Error, Localized)]
pub enum SaveError {
    /// The name is not that of a program.
    #[error(
        "{0:?} is no name of a program: it ends with .script or .task and stays inside the task folder"
    )]
    #[zh("{0:?} 不是程序名：应以 .script 或 .task 结尾，并位于任务文件夹内")]
    Name(String),
    /// The program is too long.
    #[error("the program has {0} bytes, at most {PROGRAM_BYTES_MAX} are saved")]
    #[zh("程序有 {0} 字节，最多保存 {PROGRAM_BYTES_MAX} 字节")]
    Long(usize),
    /// Somebody else has saved it since.
    #[error("{name} is not what it was when it was opened; somebody else has saved it")]
    #[zh("{name} 在打开后已被他人保存")]
    Changed {
        /// Name of the program.
        name: String,
        /// Text of the program now; none when the file is gone.
        now: Option<String>,
    },
    /// The program is a task in XML.
    #[error("{0} is a task of the pendant in XML, which is not edited here")]
    #[zh("{0} 是示教器的 XML 任务，不能在这里编辑")]
    Xml(String),
    /// The folder does not take it.
    #[error("{name} cannot be saved: {source}")]
    #[zh("无法保存 {name}：{source}")]
    System {
        /// Name of the program.
        name: String,
        /// Error of the operating system.
        source: io::Error,
    },
}

/// The mark of a text: another text has another one.
pub fn etag(text: &str) -> String {
    content_mark(text.as_bytes())
}

/// The mark of bytes: others have another one.
pub(crate) fn content_mark(bytes: &[u8]) -> String {
    let mut hasher = DefaultHasher::new();
    bytes.hash(&mut hasher);
    format!("\"{:016x}-{:x}\"", hasher.finish(), bytes.len())
}

/// The programs of a folder with their sizes, sorted; a folder that is not there has none.
pub fn list(root: &Path) -> Vec<(String, u64)> {
    let mut found = Vec::new();
    let mut left = LOOKED_AT_MAX;
    walk(root, "", 0, &mut left, &mut found);
    found.sort();
    found.truncate(LISTED_MAX);
    found
}

fn walk(
    folder: &Path,
    prefix: &str,
    depth: usize,
    left: &mut usize,
    found: &mut Vec<(String, u64)>,
) {
    let Ok(entries) = fs::read_dir(folder) else {
        return;
    };
    for entry in entries.flatten() {
        if *left == 0 {
            return;
        }
        *left -= 1;
        let Ok(name) = entry.file_name().into_string() else {
            continue;
        };
        // A link could lead out of the folder; it can still be opened by its name if it does not.
        let Ok(kind) = entry.file_type() else {
            continue;
        };
        let inside = format!("{prefix}{name}");
        if kind.is_dir() && depth < DEPTH_MAX && !name.starts_with('.') {
            let folder = entry.path();
            walk(&folder, &format!("{inside}/"), depth + 1, left, found);
        } else if kind.is_file() && is_program(&name) {
            found.push((inside, entry.metadata().map_or(0, |data| data.len())));
        }
    }
}

fn is_program(name: &str) -> bool {
    let path = Path::new(name);
    !name.starts_with('.')
        && path
            .extension()
            .is_some_and(|end| end == "script" || end == "task")
}

/// A program with its name and its mark.
///
/// # Errors
/// [`FolderError`]
pub fn open(folder: &TaskFolder, name: &str) -> Result<Value, FolderError> {
    let task = folder.task(name)?;
    Ok(json!({"name": task.name, "etag": etag(&task.text), "text": task.text}))
}

/// Saves a text as `name` if the file is the one that `before` is the mark of; without it, if there is none. The new
/// mark.
///
/// # Errors
/// [`SaveError`]: nothing was changed.
pub fn save(
    root: &Path,
    name: &str,
    text: &str,
    before: Option<&str>,
) -> Result<String, SaveError> {
    let inside = Path::new(name);
    let goes_down = |part| matches!(part, Component::Normal(_));
    let is_good = name.len() <= NAME_BYTES_MAX
        && !name.chars().any(char::is_control)
        && is_program(inside.file_name().and_then(|n| n.to_str()).unwrap_or(""))
        && inside.components().all(goes_down);
    if !is_good {
        return Err(SaveError::Name(name.chars().take(80).collect()));
    }
    if text.len() > PROGRAM_BYTES_MAX {
        return Err(SaveError::Long(text.len()));
    }
    let system = |source| SaveError::System {
        name: name.to_owned(),
        source,
    };
    fs::create_dir_all(root).map_err(system)?;
    let root = root.canonicalize().map_err(system)?;
    let path = root.join(inside);
    let folder = path.parent().unwrap_or(&root);
    // A link on the way may lead anywhere, so folders are made only below real ones.
    let mut known = root.clone();
    for part in folder
        .strip_prefix(&root)
        .into_iter()
        .flat_map(Path::components)
    {
        known.push(part);
        if !known.exists() {
            fs::create_dir(&known).map_err(system)?;
        }
        if !known.canonicalize().map_err(system)?.starts_with(&root) {
            return Err(SaveError::Name(name.to_owned()));
        }
    }
    let now = match kinematics::text_file::read_small_file(&path) {
        Ok(bytes) => {
            if elite_runtime::task_folder::is_xml(&bytes) {
                return Err(SaveError::Xml(name.to_owned()));
            }
            Some(etag(&String::from_utf8_lossy(&bytes)))
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        Err(error) => return Err(system(error)),
    };
    if now.as_deref() != before {
        let name = name.to_owned();
        return Err(SaveError::Changed { name, now });
    }
    if path.is_symlink() {
        return Err(SaveError::Name(name.to_owned()));
    }
    write_whole(&path, text).map_err(system)?;
    Ok(etag(text))
}

/// The old text or the new one, never a part.
fn write_whole(path: &Path, text: &str) -> io::Result<()> {
    let mut beside = path.as_os_str().to_owned();
    beside.push(format!(".{}.saving", std::process::id()));
    let beside = PathBuf::from(beside);
    let written = fs::File::create(&beside).and_then(|mut file| {
        file.write_all(text.as_bytes())?;
        file.sync_all()
    });
    let done = written.and_then(|()| fs::rename(&beside, path));
    if done.is_err() {
        // An error here is no harm: the file may never have been created.
        let _ = fs::remove_file(&beside);
    }
    done
}

/// Every robot function with its signature and what it does.
pub fn builtins() -> Value {
    let rows = builtins::all().map(|builtin| {
        json!({
            "name": builtin.name,
            "signature": builtin.signature(),
            "summary": builtin.summary.english(),
            "section": if builtin.section == FROM_OUTPUT { "" } else { builtin.section },
            "category": builtin.category.name(),
            "returns": builtin.returns.english(),
            "params": builtin.params.iter().map(|p| json!({
                "name": p.name,
                "unit": p.unit,
                "meaning": p.meaning.english(),
                "range": p.kind.range_text(),
            })).collect::<Value>(),
        })
    });
    rows.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_text_that_was_opened_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().join("tasks");
        let first = save(&root, "sub/a.script", "sync()\n", None).unwrap();
        assert!(matches!(
            save(&root, "sub/a.script", "x", None),
            Err(SaveError::Changed { now: Some(now), .. }) if now == first
        ));
        let second = save(&root, "sub/a.script", "sync()\nsync()\n", Some(&first)).unwrap();
        assert!(save(&root, "sub/a.script", "x", Some(&first)).is_err());
        let opened = open(&TaskFolder::new(&root), "sub/a.script").unwrap();
        assert_eq!(
            (&opened["etag"], &opened["text"]),
            (&json!(second), &json!("sync()\nsync()\n"))
        );
        assert_eq!(list(&root), [("sub/a.script".to_owned(), 14)]);
        fs::remove_file(root.join("sub/a.script")).unwrap();
        assert!(matches!(
            save(&root, "sub/a.script", "x", Some(&second)),
            Err(SaveError::Changed { now: None, .. })
        ));
    }

    #[test]
    fn names_stay_in_the_folder_and_are_those_of_programs() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().join("tasks");
        fs::create_dir_all(&root).unwrap();
        std::os::unix::fs::symlink(folder.path(), root.join("out")).unwrap();
        fs::write(folder.path().join("e.script"), "e").unwrap();
        std::os::unix::fs::symlink(folder.path().join("e.script"), root.join("l.script")).unwrap();
        let mark = etag("e");
        for (name, before) in [
            ("../a.script", None),
            ("/tmp/a.script", None),
            ("out/a.script", None),
            ("out/e.script", Some(&*mark)),
            ("l.script", Some(&*mark)),
            ("a.txt", None),
            (".script", None),
            ("", None),
            ("a\n.script", None),
            ("./../b.script", None),
        ] {
            assert!(
                matches!(save(&root, name, "x", before), Err(SaveError::Name(_))),
                "{name}"
            );
        }
        assert_eq!(
            fs::read_to_string(folder.path().join("e.script")).unwrap(),
            "e"
        );
        assert!(matches!(
            save(&root, "a.script", &" ".repeat(PROGRAM_BYTES_MAX + 1), None),
            Err(SaveError::Long(_))
        ));
        assert_eq!(list(&root), []);
        assert_eq!(list(Path::new("/nonexistent")), []);
    }

    #[test]
    fn a_task_in_xml_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("a.task"), "<?xml version='1.0'?>").unwrap();
        let saved = save(folder.path(), "a.task", "x", Some("\"0\""));
        assert!(matches!(saved, Err(SaveError::Xml(_))));
    }

    #[test]
    fn builtins_have_signatures() {
        let all = builtins();
        let movej = all
            .as_array()
            .unwrap()
            .iter()
            .find(|b| b["name"] == "movej");
        assert!(
            movej.unwrap()["signature"]
                .as_str()
                .unwrap()
                .starts_with("movej(")
        );
    }
}
