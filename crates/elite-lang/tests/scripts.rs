//! Runs `tests/scripts/FEATURE/NAME.script` and compares what it prints with `NAME.out`.
//!
//! The expected output comes from CPython 3.11, except in `elite/`, which holds what is not Python. An uncaught
//! exception counts as output: its last line. `UPDATE_SCRIPTS=1 cargo test -p elite-lang --test all scripts::` writes
//! the expected output anew with `python3`.

#![allow(clippy::unwrap_used)] // a test: a broken file should stop it

use crate::support;

use std::path::{Path, PathBuf};
use std::process::Command;

use elite_lang::ResumeOutcome;
use support::{Task, drive};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/scripts")
}

/// All scripts below the root, in order.
fn scripts() -> Vec<PathBuf> {
    let entries = |path: &Path| -> Vec<PathBuf> {
        let listed = std::fs::read_dir(path)
            .unwrap()
            .map(|entry| entry.unwrap().path());
        let mut listed: Vec<PathBuf> = listed.collect();
        listed.sort();
        listed
    };
    let folders = entries(&root()).into_iter().filter(|path| path.is_dir());
    let files = folders.flat_map(|folder| entries(&folder));
    files
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "script")
        })
        .collect()
}

fn run_here(path: &Path) -> String {
    let task = Task::new();
    let mut thread = task.spawn(&std::fs::read_to_string(path).unwrap());
    let end = drive(&mut thread, &task.host);
    let mut output = task.host.output.take();
    if let ResumeOutcome::Failed(error) = end {
        // Of a message of several lines the last one, as of CPython's report.
        output.push_str(
            error
                .headline()
                .english()
                .lines()
                .last()
                .unwrap_or_default(),
        );
        output.push('\n');
    }
    output
}

fn run_python(path: &Path) -> String {
    let output = Command::new("python3")
        .args(["-W", "ignore"])
        .arg(path)
        .output()
        .unwrap();
    let mut text = String::from_utf8(output.stdout).unwrap();
    if let Some(last) = String::from_utf8(output.stderr).unwrap().lines().last() {
        text.push_str(last);
        text.push('\n');
    }
    text
}

/// The first line that differs, for the message.
fn difference(expected: &str, found: &str) -> String {
    let mut lines = expected.lines().zip(found.lines()).enumerate();
    match lines.find(|(_, (a, b))| a != b) {
        Some((number, (a, b))) => {
            format!("output line {}\n  expected {a}\n  found    {b}", number + 1)
        }
        None => format!(
            "{} lines expected, {} found",
            expected.lines().count(),
            found.lines().count()
        ),
    }
}

#[test]
fn scripts_print_what_they_print_under_cpython() {
    let update = std::env::var_os("UPDATE_SCRIPTS").is_some();
    let mut failures = Vec::new();
    let scripts = scripts();
    assert!(
        scripts.len() > 20,
        "the scripts are missing: {}",
        root().display()
    );
    for path in &scripts {
        let expected_path = path.with_extension("out");
        let is_python = !path
            .parent()
            .is_some_and(|folder| folder.ends_with("elite"));
        if update && is_python {
            std::fs::write(&expected_path, run_python(path)).unwrap();
        }
        let expected = std::fs::read_to_string(&expected_path).unwrap_or_default();
        let found = run_here(path);
        if expected != found {
            failures.push(format!(
                "{}: {}",
                path.display(),
                difference(&expected, &found)
            ));
        }
    }
    assert!(
        failures.is_empty(),
        "{} of {} scripts differ:\n{}",
        failures.len(),
        scripts.len(),
        failures.join("\n")
    );
}
