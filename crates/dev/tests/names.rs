//! `cargo dev names` on a small crate whose figures are known, and on the workspace; the glossary against the code.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests fail by panicking"
)]

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use dev::names::{Findings, Inventory, LINE_MAX, NamesError, scan_workspace, table};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

const LIBRARY: &str = r#"//! A sample of good and bad names.

mod depth;
#[cfg(test)]
mod checks;

/// The path of an arm.
pub struct Path;
/// It leans on the line above.
/// So does this line, which belongs to the same comment.
pub struct Told;
/// The same for speeds.
pub enum NotSet {}
// As before.
pub(crate) trait Aside {}
/// A speed is a noun although it ends like a participle.
pub type JointSpeed = f64;
/// A keyword of the language.
pub struct While;

const TEXT: &str = "
/// It is no comment in a literal.
// So this is none either.
";

/// Assigns a value.
fn assign() {
    // The reason stands here.
    struct Held;
}

#[cfg(test)]
mod tests {
    /// It is a test.
    struct Seen;
}
"#;

/// Writes a workspace of the crates `first` and `second` into a folder.
fn workspace() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |path: &str, text: &str| {
        let path = folder.path().join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    };
    let mut long = String::from("pub struct State;\nfn long() {\n");
    for number in 0..99 {
        let _ = writeln!(long, "    let _ = {number};");
    }
    long += "}\nfn short() {}\n";
    write("crates/first/Cargo.toml", "");
    write("crates/first/src/lib.rs", LIBRARY);
    write("crates/first/src/depth.rs", &long);
    write("crates/first/src/checks.rs", "struct Kept;\n");
    write("crates/first/src/checks/more.rs", "struct Taken;\n");
    write(
        "crates/first/tests/all.rs",
        &format!("struct Given;\n// {}\n", "ä".repeat(118)),
    );
    write("crates/second/Cargo.toml", "");
    write(
        "crates/second/src/lib.rs",
        "mod a { pub struct State; }\nmod b { pub enum State {} }\n",
    );
    folder
}

fn scanned(folder: &Path) -> (BTreeMap<String, Inventory>, Inventory) {
    let mut all = Inventory::default();
    for inventory in scan_workspace(folder, &[]).unwrap().values_mut() {
        all.append(inventory);
    }
    (scan_workspace(folder, &[]).unwrap(), all)
}

#[test]
fn every_finding_of_the_sample_is_listed_and_nothing_else() {
    let folder = workspace();
    let (_, all) = scanned(folder.path());
    let list = Findings::of(&all).list(folder.path());
    let expected = "\
crates/first/src/lib.rs:11: no noun: Told
crates/first/src/lib.rs:13: no noun: NotSet
crates/first/src/lib.rs:15: no noun: Aside
crates/first/src/lib.rs:29: no noun: Held
crates/first/src/depth.rs:1: shared name: State (3 types)
crates/second/src/lib.rs:1: shared name: State (3 types)
crates/second/src/lib.rs:2: shared name: State (3 types)
crates/first/src/lib.rs:9: leaning documentation: It leans on the line above.
crates/first/src/lib.rs:12: leaning documentation: The same for speeds.
crates/first/src/lib.rs:14: leaning comment: As before.
crates/first/src/depth.rs:2: long function: long (101 lines)
crates/first/tests/all.rs:2: long line: 121 columns
";
    assert_eq!(list, expected);
}

#[test]
fn the_table_has_a_line_for_each_crate_and_one_for_all() {
    let folder = workspace();
    let (crates, all) = scanned(folder.path());
    let table = table(&crates, &all);
    let lines: Vec<Vec<&str>> = table
        .lines()
        .map(|line| line.split_whitespace().collect())
        .collect();
    assert_eq!(lines.len(), 4, "{table}");
    let figures = |line: usize| -> Vec<&str> {
        lines[line]
            .iter()
            .copied()
            .filter(|word| word.parse::<u32>().is_ok())
            .collect()
    };
    assert_eq!(lines[1][0], "first");
    assert_eq!(figures(1), ["4", "0", "2", "1", "1", "1"], "{table}");
    assert_eq!(figures(2), ["0", "0", "0", "0", "0", "0"], "{table}");
    assert_eq!(figures(3), ["4", "1", "2", "1", "1", "1"], "{table}");
    assert!(
        table.contains("4 (50.00 %)"),
        "four of eight types of the first crate: {table}"
    );
}

#[test]
fn a_crate_that_is_not_there_is_named_with_those_that_are() {
    let folder = workspace();
    let error = scan_workspace(folder.path(), &["third".to_owned()]).unwrap_err();
    assert!(matches!(error, NamesError::Crate { .. }));
    assert_eq!(
        error.to_string(),
        "there is no crate \"third\"; there are first, second"
    );
}

#[test]
fn text_that_is_not_rust_is_an_error_with_its_file() {
    let folder = workspace();
    std::fs::write(folder.path().join("crates/second/src/lib.rs"), "fn (").unwrap();
    let error = scan_workspace(folder.path(), &[]).unwrap_err();
    assert!(
        matches!(&error, NamesError::Syntax { path, .. } if path.ends_with("second/src/lib.rs")),
        "{error}"
    );
}

#[test]
fn types_that_the_glossary_names_are_there() {
    let crates = scan_workspace(&root(), &[]).unwrap();
    let text = std::fs::read_to_string(root().join("docs/glossary.md")).unwrap();
    let mut terms = BTreeSet::new();
    for line in text.lines() {
        let Some(row) = line
            .strip_prefix("| ")
            .and_then(|line| line.strip_suffix(" |"))
        else {
            continue;
        };
        let [term, _, place] = row.split(" | ").collect::<Vec<_>>()[..] else {
            panic!("not three columns: {line}");
        };
        if term == "term" {
            continue;
        }
        assert!(terms.insert(term.to_owned()), "{term:?} stands there twice");
        let Some((name, owner)) = place
            .strip_prefix('`')
            .and_then(|place| place.split_once("`, "))
        else {
            assert!(
                place == "everywhere" || place.split(", ").all(|owner| crates.contains_key(owner)),
                "{term:?}: {place:?} is no crate"
            );
            continue;
        };
        let inventory = crates
            .get(owner)
            .unwrap_or_else(|| panic!("{term:?}: {owner:?} is no crate"));
        assert!(
            inventory.types.iter().any(|mention| mention.text == name),
            "{term:?}: {owner} has no type {name}"
        );
    }
    assert!(terms.len() > 300, "{} terms", terms.len());
}

/// Lines of too many columns in the sources of a folder and of those in it.
fn add_long_lines(folder: &Path, found: &mut Vec<String>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy();
        let is_ours =
            !name.starts_with('.') && !["target", "node_modules", "dist"].contains(&&*name);
        if path.is_dir() && is_ours {
            add_long_lines(&path, found);
        }
        if !path.is_file()
            || ![".rs", ".sh", ".py", ".pyi", ".toml"]
                .iter()
                .any(|end| name.ends_with(end))
        {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let long = (1..)
            .zip(text.lines())
            .filter(|(_, line)| line.chars().count() > LINE_MAX);
        found.extend(long.map(|(number, _)| format!("{}:{number}", path.display())));
    }
}

#[test]
fn no_line_of_a_source_is_too_long() {
    let mut found = Vec::new();
    add_long_lines(&root(), &mut found);
    assert!(found.is_empty(), "more than {LINE_MAX} columns: {found:#?}");
}
