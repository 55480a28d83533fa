//! The shape of the code that keeps scripts out of what is in use: values lie in `ScriptCell`, not in cells that can be
//! borrowed to be changed.

use std::path::{Path, PathBuf};

/// Files with cells of their own that keep values, and why those are never in use while script code runs.
const WITH_CELLS: &[(&str, &str)] = &[
    ("value/held.rs", "the cell itself"),
    (
        "value/dict/mod.rs",
        "private to the table, whose methods give back what leaves",
    ),
    (
        "value/set.rs",
        "private to the table, whose methods give back what leaves",
    ),
    (
        "limits/deferred_drop.rs",
        "the queue; nothing is dropped while it is borrowed",
    ),
    (
        "eval/core.rs",
        "calls and texts that wait: they are moved in and out",
    ),
];

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found.sort();
    found
}

#[test]
fn values_lie_in_cells_that_cannot_be_borrowed_to_change_them() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let keeps_values = |line: &str| {
        let Some((_, kept)) = line.split_once("RefCell<") else {
            return false;
        };
        let words = [
            "Value",
            "Values",
            "DictTable",
            "SetTable",
            "Instance",
            "Namespace",
            "AttrMap",
            "GeneratorFrame",
        ];
        let kept = kept.split('>').next().unwrap_or_default();
        let mut names = kept.split(|c: char| !c.is_alphanumeric());
        names.any(|name| words.contains(&name))
    };
    let mut found = Vec::new();
    for path in files(&root) {
        let name = path
            .strip_prefix(&root)
            .unwrap()
            .to_string_lossy()
            .into_owned();
        if name.starts_with("trials/") || WITH_CELLS.iter().any(|(file, _)| *file == name) {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let lines = text
            .lines()
            .enumerate()
            .filter(|(_, line)| keeps_values(line));
        found.extend(lines.map(|(number, line)| format!("{name}:{}: {}", number + 1, line.trim())));
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}
