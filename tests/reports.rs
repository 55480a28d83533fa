//! Reports of commands in Chinese: what tests of programs, recordings, fleets and robots elsewhere come to. No line is
//! a mixture, and formats for machines stay English.

#![allow(clippy::unwrap_used, reason = "a test helper fails by panicking")]

use std::path::Path;

use crate::common::{eliteserver, said_and_status};
use crate::wrong_input::assert_no_mixture;

/// Asked in a folder with the files of [`files`].
const QUESTIONS: &[&str] = &[
    "test --jobs 1 --timeout 9 good_test.script bad_test.script",
    "test --jobs 1 bad_test.script -k near --seed 3 --timeout 9",
    "test empty.script",
    "test none",
    "test good_test.script -k zebra",
    "replay ok.mcap",
    "replay failed.mcap",
    "replay ok.mcap --script",
    "replay ok.mcap --at 0.1",
    "replay ok.mcap --at 100",
    "replay ok.mcap --find actual_q[0]>0.05",
    "replay ok.mcap --find line==1",
    "replay ok.mcap --diff ok.mcap",
    "replay ok.mcap --diff failed.mcap",
    "replay ok.mcap --rerun",
    "replay none.mcap",
    "fleet fleet.toml --check",
    "fleet twice.toml --check",
    "fleet unnamed.toml --check",
    "fleet wrong.toml --check",
    "fleet none.toml",
    "calibrate --primary-port 1 --out arm.toml",
    "record --primary-port 1 --out arm.mcap",
];

/// Each fails in a way of its own.
const BAD: &str = r#"
def test_asserts():
    print("open")
    x = [1, 3]
    assert x == [1, 2], "lists"

def test_near():
    test.near([1.0, [2.0, 3.0]], [1.0, [2.0, 3.5]], 0.1)

def test_raises():
    test.raises("KeyError", lambda: 5)

def test_never_by_the_test():
    test.never("actual_q[0] > 0.05")
    movej([0.1, -1.5, 1.5, -1.5, -1.5, 0])

def test_always_by_the_program():
    test.always("actual_q[0] < 0.05")
    test.run("sleep(0.1)\nmovej([0.1, -1.5, 1.5, -1.5, -1.5, 0])\n")

def test_program_fails():
    result = test.run("\nmovej(1)\n")
    assert result.outcome == "ended"

def test_takes_too_long():
    test.run("while True:\n    sync()\nend\n", timeout=1000)
"#;

fn files(folder: &Path) {
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    write("good_test.script", "def test_nothing():\n    sleep(1)\n");
    write("bad_test.script", BAD);
    write("empty.script", "");
    write(
        "ok.script",
        "movej([0.1, -1.5, 1.5, -1.5, -1.5, 0])\nprint(\"no\")\n",
    );
    write("failed.script", "x = 1\nmovej(x)\n");
    write(
        "fleet.toml",
        "[[robot]]\nname = \"left\"\n[[robot]]\nname = \"right\"\n",
    );
    write(
        "twice.toml",
        "[[robot]]\nname = \"a\"\n[[robot]]\nname = \"a\"\n",
    );
    write("unnamed.toml", "[[robot]]\nmodel = \"cs66\"\n");
    write("wrong.toml", "[[robot]]\nname = \"a\"\nmemory = \"much\"\n");
    for name in ["ok", "failed"] {
        let file = format!("{name}.script");
        let recording = format!("{name}.mcap");
        eliteserver()
            .args(["run", "--no-check", "--plant", "ideal", &file])
            .args(["--record", &recording])
            .current_dir(folder)
            .output()
            .unwrap();
    }
}

fn said(folder: &Path, arguments: &[&str]) -> String {
    let (said, status) = said_and_status(folder, arguments);
    assert!(!said.contains("panicked"), "{arguments:?}: {said}");
    format!("{said}[{status}]\n")
}

/// A line of a field of a cycle: they have another test.
fn is_field(line: &str) -> bool {
    let is_name = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
    let name = line.split_once(": ").map_or("", |(name, _)| name);
    name.contains('_') && name.chars().all(is_name)
}

/// What a test took of the machine's time is another time each time, and so is which one was the slowest. Tests run in
/// any order.
fn without_machine_time(text: &str) -> String {
    let lines = text
        .lines()
        .filter(|line| !line.starts_with("最慢：") && !is_field(line));
    let lines = lines.map(|line| match line.split_once("，用时") {
        Some((before, after)) if before.contains("仿真") => {
            let path = after.rsplit_once("  ").map_or("", |(_, path)| path);
            format!("{before}，用时 …  {path}")
        }
        _ => line.to_owned(),
    });
    let mut lines: Vec<String> = lines.collect();
    let is_test = |line: &String| line.starts_with("通过  ") || line.starts_with("失败  ");
    for tests in lines.split_mut(|line| !is_test(line)) {
        tests.sort();
    }
    lines
        .iter()
        .map(|line| format!("{}\n", line.trim_end()))
        .collect()
}

#[test]
fn reports_are_in_chinese() {
    let folder = tempfile::tempdir().unwrap();
    files(folder.path());
    let mut text = String::new();
    for question in QUESTIONS {
        let arguments: Vec<&str> = question.split(' ').chain(["--language", "zh"]).collect();
        text += &format!("$ {question}\n{}", said(folder.path(), &arguments));
    }
    let text = without_machine_time(&text).replace(env!("CARGO_PKG_VERSION"), "VERSION");
    insta::assert_snapshot!(text);
    assert_no_mixture(&text);
}

#[test]
fn what_machines_read_stays_english() {
    let folder = tempfile::tempdir().unwrap();
    files(folder.path());
    for question in [
        "test --jobs 1 --format json --junit tests.xml bad_test.script",
        "replay ok.mcap --csv /cycle",
        "doctor --format json --record off",
    ] {
        let arguments: Vec<&str> = question.split(' ').chain(["--language", "zh"]).collect();
        let said = said(folder.path(), &arguments);
        assert!(said.is_ascii() || !said.contains(is_chinese), "{said}");
    }
    let junit = std::fs::read_to_string(folder.path().join("tests.xml")).unwrap();
    assert!(junit.contains("AssertionError") && !junit.contains(is_chinese));
}

const fn is_chinese(letter: char) -> bool {
    matches!(letter, '\u{4e00}'..='\u{9fff}')
}
