//! `eliteserver translate` as people type it, and what translated programs do on the controller.

#![allow(clippy::unwrap_used, reason = "a test helper fails by panicking")]

use std::path::{Path, PathBuf};
use std::process::Output;

use program_import::translate::functions::FUNCTIONS;
use serde_json::Value;

use crate::common::eliteserver;

/// What a program says is read by its test as lines that it prints.
const MESSAGES_AS_PRINTS: &str = "def textmsg(s1, s2=\"\"):\n    print(str_cat(s1, s2))\nend\n";

fn programs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/universal_robots")
}

fn in_folder(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = eliteserver();
    command
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn translated_programs_do_what_universal_robots_documents() {
    let folder = tempfile::tempdir().unwrap();
    let mut scripts = Vec::new();
    for entry in std::fs::read_dir(programs()).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        let Some(stem) = name.strip_suffix(".urscript") else {
            std::fs::copy(&path, folder.path().join(name)).unwrap();
            continue;
        };
        let script = format!("{stem}.script");
        let input = path.to_str().unwrap();
        let output = in_folder(folder.path(), &["translate", input, "-o", &script]);
        let expected = i32::from(stem.starts_with("missing"));
        let remarks = text(&output.stdout);
        assert_eq!(output.status.code(), Some(expected), "{stem}: {remarks}");
        scripts.push(script);
    }
    assert!(scripts.len() >= 30, "{}", scripts.len());
    let check: Vec<&str> = ["check"]
        .into_iter()
        .chain(scripts.iter().map(String::as_str))
        .collect();
    let output = in_folder(folder.path(), &check);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stdout));
    for script in &scripts {
        let path = folder.path().join(script);
        let program = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, format!("{MESSAGES_AS_PRINTS}{program}")).unwrap();
    }
    let output = in_folder(folder.path(), &["test"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stdout));
}

#[test]
fn remarks_have_line_kind_name_and_text() {
    let folder = tempfile::tempdir().unwrap();
    let program = "def demo():\n  set_digital_out(2, True)\n  movej(p[0.1, -0.4, 0.3, 1.2, 1.2, 0])\n\
                   \x20 set_tcp(p[0,0,0.1,0,0,0], \"grip\")\n  get_tool_current()\nend\n";
    std::fs::write(folder.path().join("demo.urscript"), program).unwrap();
    let arguments = [
        "translate",
        "demo.urscript",
        "--format",
        "json",
        "--report",
        "demo.md",
    ];
    let output = in_folder(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(1));
    let rows: Vec<Value> = text(&output.stderr)
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let found: Vec<(u64, &str, &str)> = rows
        .iter()
        .map(|row| {
            assert!(!row["text"].as_str().unwrap().is_empty());
            let word = |key: &str| row[key].as_str().unwrap();
            (row["line"].as_u64().unwrap(), word("kind"), word("name"))
        })
        .collect();
    assert_eq!(
        found,
        [
            (2, "renamed", "set_digital_out"),
            (3, "helper", "p[…]"),
            (3, "helper", "movej"),
            (3, "changed", "movej"),
            (4, "changed", "set_tcp"),
            (5, "missing", "get_tool_current"),
        ]
    );
    let translated = text(&output.stdout);
    assert!(
        translated.contains("# get_tool_current()\nnot_available(\"get_tool_current: "),
        "{translated}"
    );
    let report = std::fs::read_to_string(folder.path().join("demo.md")).unwrap();
    assert!(report.contains("| 5 | `get_tool_current` |"), "{report}");
}

#[test]
fn what_cannot_be_read_is_said_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let cases: [(&str, &[u8], &str); 4] = [
        (
            "open.urscript",
            b"def a():\n  if True:\n    sync()\n  end\n",
            "line 5: here is the end of the text and not 'end'",
        ),
        (
            "odd.urscript",
            b"def a():\n  x = p[1, 2, 3]\nend\n",
            "line 2: a pose has six numbers, and this one 3",
        ),
        (
            "quote.urscript",
            b"textmsg(\"a)\n",
            "line 1: the text has no end",
        ),
        ("bytes.urscript", b"\xff\xfe\x00", "is not UTF-8 text"),
    ];
    for (name, bytes, sentence) in cases {
        std::fs::write(folder.path().join(name), bytes).unwrap();
        let output = in_folder(folder.path(), &["translate", name]);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{name}: {said}");
        assert!(said.contains(sentence), "{name}: {said}");
        assert!(output.stdout.is_empty());
    }
    let output = in_folder(folder.path(), &["translate", "nothing.urscript"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("nothing.urscript"));
}

#[test]
fn a_program_comes_and_goes_through_pipes() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a"), "movel(p[1,2,3,0,0,0])\n").unwrap();
    let mut command = eliteserver();
    let output = command
        .args(["translate", "-"])
        .stdin(std::fs::File::open(folder.path().join("a")).unwrap())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(text(&output.stdout).ends_with("\nmovel([1, 2, 3, 0, 0, 0])\n"));
}

/// The table of docs/from-ur.md.
fn function_table() -> String {
    let mut table = "\n| Universal Robots | here | note |\n|---|---|---|\n".to_owned();
    for row in FUNCTIONS.iter() {
        let params: Vec<&str> = row.parameters().iter().map(|param| param.name).collect();
        let there = format!("`{}({})`", row.name(), params.join(", "));
        let here = match row.call {
            "=" => "the same".to_owned(),
            "!" => "none".to_owned(),
            "-" => "left out".to_owned(),
            call => match call.strip_prefix('=') {
                Some(name) => format!("`{name}`, the same arguments"),
                None => format!("`{}`", call.replace(['{', '}'], "").replace('|', " or ")),
            },
        };
        let written: Vec<String> = row
            .parameters()
            .iter()
            .filter(|param| param.is_written)
            .map(|param| format!("{} = {} there", param.name, param.default.unwrap()))
            .collect();
        let notes: Vec<&str> = written
            .iter()
            .map(String::as_str)
            .chain([row.note.english()])
            .collect();
        let note = notes
            .into_iter()
            .filter(|note| !note.is_empty())
            .collect::<Vec<_>>()
            .join("; ");
        table.push_str(&format!("| {there} | {here} | {note} |\n"));
    }
    table.push('\n');
    table
}

#[test]
fn the_page_has_the_table() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/from-ur.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let (before, rest) = page.split_once("translate:: -->\n").unwrap();
    let (_, after) = rest.split_once("<!-- end of functions -->").unwrap();
    let wanted = format!(
        "{before}translate:: -->\n{}<!-- end of functions -->{after}",
        function_table()
    );
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&path, &wanted).unwrap();
    }
    assert!(
        page == wanted || std::env::var_os("UPDATE_DOCS").is_some(),
        "docs/from-ur.md is out of date"
    );
}
