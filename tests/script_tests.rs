//! `eliteserver test` as people type it: the examples, selection, formats, files, exit status, bad input.

#![allow(clippy::unwrap_used, reason = "a test helper fails by panicking")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/testing")
}

fn test_in(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_eliteserver"))
        .arg("test")
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A copy of the examples with one test that fails.
fn project() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(examples()).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
    }
    let failing = "def test_fails():\n    x = 1 + 1\n    assert x == 3, 'sums: <&>'\n";
    std::fs::write(folder.path().join("sums_test.script"), failing).unwrap();
    folder
}

#[test]
fn the_examples_pass() {
    let output = test_in(&examples(), &[]);
    let out = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{out}");
    assert!(out.contains("6 passed; "), "{out}");
}

#[test]
fn the_tutorial_shows_what_the_examples_do() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let tutorial = std::fs::read_to_string(folder.join("docs/testing.md")).unwrap();
    let tests = std::fs::read_to_string(examples().join("test_pick.script")).unwrap();
    let blocks: Vec<&str> = tutorial
        .split("```python\n")
        .skip(1)
        .filter_map(|rest| rest.split("```").next())
        .collect();
    assert!(!blocks.is_empty());
    for block in blocks {
        assert!(tests.contains(block), "not in the examples:\n{block}");
    }
    // Every function of the object is told of.
    for name in script_test::function_names() {
        assert!(tutorial.contains(&format!("test.{name}(")), "{name}");
    }
}

#[test]
fn a_failure_is_told_to_people_programs_and_servers_that_build() {
    let folder = project();
    let path = folder.path();
    let files = ["--junit", "tests.xml", "--coverage", "lines.info"];
    let output = test_in(path, &[&files[..], &["--format", "json"]].concat());
    assert_eq!(output.status.code(), Some(1));
    let lines: Vec<Value> = text(&output.stdout)
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(lines.len(), 7);
    let failed: Vec<&Value> = lines.iter().filter(|l| l["outcome"] != "passed").collect();
    let [failed] = failed[..] else {
        panic!("{lines:?}")
    };
    let message = failed["message"].as_str().unwrap();
    assert!(
        message.starts_with("AssertionError: sums: <&> (the left side is 2"),
        "{message}"
    );
    assert_eq!(
        (failed["line"].as_u64(), &failed["name"]),
        (Some(3), &Value::from("test_fails"))
    );
    // The command that is named runs it alone.
    let command = failed["command"].as_str().unwrap();
    let words: Vec<&str> = command.split(' ').skip(2).collect();
    let again = test_in(path, &words);
    let out = text(&again.stdout);
    assert!(
        again.status.code() == Some(1) && out.contains("0 passed, 1 failed"),
        "{out}"
    );
    assert!(out.contains("sums_test.script:3: test_fails"), "{out}");

    let junit = std::fs::read_to_string(path.join("tests.xml")).unwrap();
    assert!(
        junit.contains("<testsuites tests=\"7\" failures=\"1\" errors=\"0\""),
        "{junit}"
    );
    assert!(junit.contains("sums: &lt;&amp;&gt;"), "{junit}");
    let lcov = std::fs::read_to_string(path.join("lines.info")).unwrap();
    assert!(
        lcov.contains("pick.script\n") && lcov.contains("\nDA:2,"),
        "{lcov}"
    );
    assert!(
        lcov.ends_with("end_of_record\n") && !lcov.contains("test_pick"),
        "{lcov}"
    );

    let github = test_in(path, &["-k", "sums", "--format", "github"]);
    let out = text(&github.stdout);
    assert!(
        out.contains("::error file=./sums_test.script,line=3,title=test_fails::AssertionError"),
        "{out}"
    );
}

#[test]
fn a_failed_assertion_does_not_hide_what_was_watched_and_did_not_hold() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let test =
        "def test_both():\n    test.never('time > 0.1')\n    sleep(0.2)\n    assert False\nend\n";
    std::fs::write(path.join("test_both.script"), test).unwrap();
    let output = test_in(path, &[]);
    let out = text(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{out}");
    assert!(out.contains("AssertionError"), "{out}");
    assert!(out.contains("line 2: "), "{out}");
    assert!(out.contains("time > 0.1"), "{out}");
}

#[test]
fn tests_are_listed_selected_and_set_up_by_their_folder() {
    let folder = project();
    let path = folder.path();
    let out = text(&test_in(path, &["--list", "-k", "camera"]).stdout);
    assert_eq!(
        out,
        "./test_pick.script::test_a_camera_that_answers_nothing_is_an_unknown_part\n"
    );
    let inner = path.join("cells/left");
    std::fs::create_dir_all(&inner).unwrap();
    std::fs::write(
        path.join("cells/test.toml"),
        "model = 'cs612'\ncell = 'cell.toml'\n",
    )
    .unwrap();
    std::fs::write(path.join("cells/cell.toml"), "[limits]\ntcp_speed = 0.1\n").unwrap();
    let limited = "def test_limited():\n    test.run('movej([1, -1.5, 1.5, -1.5, -1.5, 0], a=2, v=1)', timeout=60)\n\
                   \x20   assert 0.05 < test.peak('tcp_speed') < 0.11\n";
    std::fs::write(inner.join("test_cell.script"), limited).unwrap();
    let output = test_in(path, &["cells"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stdout));
    // Settings are looked for up to the folder that was named, not above it.
    let output = test_in(path, &["cells/left"]);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stdout));
}

#[test]
fn what_cannot_be_run_is_one_sentence_and_status_2() {
    let folder = project();
    let path = folder.path();
    std::fs::write(path.join("test_broken.script"), "def test_x(\n").unwrap();
    std::fs::create_dir(path.join("empty")).unwrap();
    std::fs::create_dir(path.join("odd")).unwrap();
    std::fs::write(path.join("odd/test_a.script"), "def test_a():\n    pass\n").unwrap();
    std::fs::write(path.join("odd/test.toml"), "modell = 'cs66'\n").unwrap();
    for (arguments, said) in [
        (&["nowhere"][..], "cannot read nowhere"),
        (&["empty"], "there is no test"),
        (
            &["sums_test.script", "-k", "nothing"],
            "no test has \"nothing\"",
        ),
        (&["test_broken.script"], "test_broken.script"),
        (&["odd"], "unknown key `modell`"),
        (&["--timeout", "-1"], "allowed are seconds above 0"),
        (&["--jobs", "0"], "--jobs"),
        (
            &["--junit", "no/such/folder/x.xml", "sums_test.script"],
            "cannot write no/such/folder/x.xml",
        ),
    ] {
        let output = test_in(path, arguments);
        let err = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {err}");
        assert!(err.contains(said), "{arguments:?}: {err}");
    }
}

#[test]
fn check_knows_the_object_of_tests_and_what_it_has() {
    let folder = tempfile::tempdir().unwrap();
    let text_of = "def test_a():\n    test.runn('x')\n    test.run('x')\n";
    std::fs::write(folder.path().join("test_a.script"), text_of).unwrap();
    std::fs::write(folder.path().join("a.script"), text_of).unwrap();
    let check = |name: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_eliteserver"))
            .args(["check", "--format", "json", name])
            .current_dir(folder.path())
            .output()
            .unwrap();
        text(&output.stdout)
    };
    let found = check("test_a.script");
    assert!(
        found.contains("`test` has no function `runn`") && found.lines().count() == 1,
        "{found}"
    );
    assert!(check("a.script").contains("undefined-name"));
}

/// System tests that are shorter as programs: motion modes, belts, planes, wired encoders, force mode.
#[test]
fn the_programs_of_this_folder_pass() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/programs");
    let output = test_in(&folder, &[]);
    let out = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{out}");
    assert!(out.contains("18 passed; "), "{out}");
}
