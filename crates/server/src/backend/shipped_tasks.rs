//! Tasks that come with the server: they are there by their names where the task folder has none of the name.

use elite_runtime::task_folder::{FolderError, TaskFolder, TaskText};

/// Name without ending, and text.
const SHIPPED: [(&str, &str); 1] = [("external_control", include_str!("external_control.task"))];

/// The text of a task of the server's own; `None` where there is none of the name.
fn shipped(name: &str) -> Option<TaskText> {
    let stem = name.strip_suffix(".task").unwrap_or(name);
    let (_, text) = SHIPPED.iter().find(|(known, _)| *known == stem)?;
    Some(TaskText {
        name: format!("{stem}.task"),
        text: (*text).to_owned(),
    })
}

/// A task by its path in the folder, and whether it is one of the server's own. A file of the name goes before those.
///
/// # Errors
/// [`FolderError`]
pub(super) fn task(folder: &TaskFolder, name: &str) -> Result<(TaskText, bool), FolderError> {
    match folder.task(name) {
        Ok(task) => Ok((task, false)),
        Err(error @ FolderError::Missing { .. }) => match shipped(name) {
            Some(task) => Ok((task, true)),
            None => Err(error),
        },
        Err(error) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use elite_syntax::{SourceFile, check};

    #[test]
    fn shipped_tasks_have_no_findings_and_give_way_to_files() {
        let folder = tempfile::tempdir().unwrap();
        let tasks = TaskFolder::new(folder.path());
        let known = elite_runtime::builtins::known_names();
        for (name, _) in SHIPPED {
            let (found, is_shipped) = task(&tasks, name).unwrap();
            assert!(is_shipped && task(&tasks, &format!("{name}.task")).is_ok());
            let findings = check(SourceFile::new(found.name, found.text), &known);
            assert_eq!(findings.first().map(|finding| &finding.message), None);
            let file = folder.path().join(format!("{name}.task"));
            std::fs::write(file, "pass\n").unwrap();
            let (own, is_shipped) = task(&tasks, name).unwrap();
            assert_eq!((own.text.as_str(), is_shipped), ("pass\n", false));
        }
        assert!(task(&tasks, "another").is_err() && task(&tasks, "../external_control").is_err());
    }
}
