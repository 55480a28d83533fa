//! What people see at the terminal: `run` of programs that do not end, `check` of folders, `builtins`, the debugger's
//! prompt, what programs print through `send` and `shell`, pictures of a part of a recording.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test fails by panicking"
)]

use std::io::Write as _;
use std::path::Path;
use std::process::{Output, Stdio};

use crate::common::{Server, alone, eliteserver, run_script};

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn said(output: &Output) -> String {
    text(&output.stderr)
}

fn eliteserver_in(folder: &Path, arguments: &[&str]) -> Output {
    eliteserver()
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

/// Runs a command that reads `lines` from a pipe; what it prints.
fn typed(folder: &Path, arguments: &[&str], lines: &str) -> Output {
    let mut child = eliteserver()
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    input.write_all(lines.as_bytes()).unwrap();
    drop(input);
    child.wait_with_output().unwrap()
}

#[test]
fn a_program_that_does_not_end_is_stopped_in_its_time_and_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let computing = "x = 0\nwhile True:\n    x = x + 1\nend\n";
    let output = run_script(folder.path(), computing, &["--timeout", "0.3"]);
    assert_eq!(output.status.code(), Some(1));
    let error = said(&output);
    assert!(error.contains("warning[busy-loop]"), "{error}");
    assert!(
        error.contains("no time of the robot has passed for 0.3 s, in line"),
        "{error}"
    );

    let waiting = "while not get_standard_digital_in(0):\n    sync()\nend\n";
    let output = run_script(folder.path(), waiting, &["--timeout", "2"]);
    assert_eq!(output.status.code(), Some(1));
    let error = said(&output);
    assert!(
        error.contains("of the robot's time, in line 2: sync()"),
        "{error}"
    );

    let ends = "sleep(1)\nprint(7)\n";
    let output = run_script(folder.path(), ends, &["--timeout", "20"]);
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(text(&output.stdout), "7\n");
    let error = said(&output);
    assert!(error.starts_with("ended: 1.0"), "{error}");
    assert!(error.contains(" s of the robot's time, in "), "{error}");
}

#[test]
fn a_program_that_computes_without_time_is_told_of_and_that_there_are_no_statements() {
    let folder = tempfile::tempdir().unwrap();
    let computing = "x = 0\nwhile True:\n    x = x + 1\nend\n";
    let options = ["--no-check", "--timeout", "6", "--language", "zh"];
    let output = run_script(folder.path(), computing, &options);
    let error = said(&output);
    assert!(
        error.contains("程序已计算 5 s，没有经过任何机器人时间，在第"),
        "{error}"
    );
    assert!(!error.contains("busy-loop"), "{error}");

    let output = run_script(folder.path(), "interpreter_mode()\n", &[]);
    assert_eq!(output.status.code(), Some(1));
    let error = said(&output);
    assert!(error.contains("there is no port 30020"), "{error}");
}

#[test]
fn findings_are_told_before_the_program_starts() {
    let folder = tempfile::tempdir().unwrap();
    let program = "print(1)\nsleep(1)\nmoveJ([0, 0, 0, 0, 0, 0])\n";
    let output = run_script(folder.path(), program, &[]);
    let error = said(&output);
    let finding = error.find("warning[undefined-name]").expect(&error);
    let raised = error.find("Traceback").expect(&error);
    assert!(
        finding < raised && error.contains("did you mean 'movej'"),
        "{error}"
    );
    // What is set from outside is not unknown.
    let output = run_script(folder.path(), "print(speed)\n", &["--set", "speed=3"]);
    assert!(
        !said(&output).contains("undefined-name"),
        "{}",
        said(&output)
    );
}

#[test]
fn folders_are_checked_with_all_their_scripts() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("cell/left");
    std::fs::create_dir_all(&inner).unwrap();
    std::fs::write(inner.join("a.script"), "movej([0, -90, 0, 0, 0, 0])\n").unwrap();
    std::fs::write(
        folder.path().join("cell/test_b.script"),
        "def test_b():\n  test.wait(1)\nend\n",
    )
    .unwrap();
    std::fs::write(folder.path().join("cell/notes.txt"), "no script").unwrap();
    let output = eliteserver_in(folder.path(), &["check", "cell"]);
    assert_eq!(output.status.code(), Some(1));
    let found = text(&output.stdout);
    assert_eq!(found.matches("warning[").count(), 1, "{found}");
    assert!(found.contains("cell/left/a.script:1:7"), "{found}");
    std::fs::create_dir(folder.path().join("empty")).unwrap();
    let output = eliteserver_in(folder.path(), &["check", "empty"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(said(&output).contains("there is no script (*.script) below empty"));
}

const SUM: &str = "total = 0\nfor i in range(3):\n    total = total + i\nend\nprint(\"total\", total)\n\
                   movej([0.2, -1.57, 1.57, -1.57, -1.57, 0])\n";

#[test]
fn the_debugger_is_used_at_the_terminal_in_both_directions() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("sum.script"), SUM).unwrap();
    let orders = "break 3 if i == 2\ncontinue\nprint total\nback\nprint [i, total]\nwhere\n\
                  delete\nuntil 6\nvars\nuntil norm(actual_qd) > 0.1\nback until 3\nprint total\n\
                  brek 3\nbreak 99 if\ngoto 0\ncontinue\nlist 5\nquit\n";
    let output = typed(folder.path(), &["debug", "sum.script"], orders);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    insta::assert_snapshot!(text(&output.stdout));
}

/// Lines that have Chinese letters and, outside quotes, a row of English words.
fn mixed(told: &str) -> Vec<&str> {
    let is_chinese = |letter: char| ('\u{4e00}'..='\u{9fff}').contains(&letter);
    let is_word = |word: &&str| word.len() > 1 && word.bytes().all(|b| b.is_ascii_lowercase());
    let is_mixed = |line: &&str| {
        let outside: String = line.split('"').step_by(2).collect();
        let words: Vec<bool> = outside
            .split_whitespace()
            .map(|word| is_word(&word))
            .collect();
        line.contains(is_chinese) && words.windows(3).any(|row| row == [true; 3])
    };
    told.lines().filter(is_mixed).collect()
}

#[test]
fn the_debugger_the_sender_and_the_list_of_functions_speak_one_language() {
    assert_eq!(
        mixed("停在第 2 个周期: the end of the program").len(),
        1,
        "the measure"
    );
    let folder = tempfile::tempdir().unwrap();
    let zh = ["--language", "zh"];
    std::fs::write(folder.path().join("sum.script"), SUM).unwrap();
    let orders = "break 999\nbrek 3\nfrob\nuntil nothing == 2\nuntil\ngoto soon\ndelete 7\nprint\n\
                  list x\nbreak when norm(tcp_force[0:3]) > 20\ncontinue\nback\nquit\n";
    let output = typed(
        folder.path(),
        &[&["debug"][..], &zh, &["sum.script"]].concat(),
        orders,
    );
    let told = text(&output.stdout);
    for part in [
        "该处及其后没有语句",
        "是否想写 break",
        "没有命令 \"frob\"",
        "无法读取条件",
        "程序的结尾",
        "2: 当 norm",
    ] {
        assert!(told.contains(part), "{part}: {told}");
    }
    assert!(
        !told.contains("there is") && !told.contains(" takes "),
        "{told}"
    );
    assert_eq!(mixed(&told), [""; 0]);

    std::fs::write(folder.path().join("bad.script"), "def p(:\n").unwrap();
    let nobody = ["--robot", "127.0.0.1", "--primary-port", "1"];
    for (file, part) in [
        ("bad.script", "bad.script 无法编译；没有发送任何内容"),
        ("sum.script", "无法连接机器人 127.0.0.1:1：连接被拒绝"),
    ] {
        let output = eliteserver_in(
            folder.path(),
            &[&["send"][..], &zh, &nobody, &[file]].concat(),
        );
        assert_eq!(output.status.code(), Some(2));
        assert!(said(&output).contains(part), "{}", said(&output));
        assert_eq!(mixed(&said(&output)), [""; 0]);
    }
    let output = eliteserver_in(folder.path(), &["builtins", "--language", "zh"]);
    assert!(text(&output.stdout).contains("来自控制器输出"));
    assert!(!text(&output.stdout).contains("not from the manual"));
    let output = run_script(folder.path(), "popup(\"empty?\", blocking=False)\n", &zh);
    assert!(
        said(&output).contains("弹窗 \"Popup\"：empty?"),
        "{}",
        said(&output)
    );
}

#[test]
fn the_debugger_says_why_it_does_not_start() {
    let folder = tempfile::tempdir().unwrap();
    let output = typed(folder.path(), &["debug", "none.script"], "");
    assert_eq!(output.status.code(), Some(2));
    assert!(said(&output).contains("none.script"), "{}", said(&output));
    std::fs::write(folder.path().join("sum.script"), SUM).unwrap();
    let output = typed(
        folder.path(),
        &["debug", "sum.script", "--model", "cs99"],
        "",
    );
    assert_eq!(output.status.code(), Some(2));
    assert!(said(&output).contains("cs99"), "{}", said(&output));
}

#[test]
fn what_programs_print_is_shown_by_send_and_values_by_the_shell() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let port = |name: &str| server.ports[name].to_string();
    let ports = [
        ("--primary-port", port("primary")),
        ("--interpreter-port", port("interpreter")),
        ("--rtsi-port", port("rtsi")),
        ("--dashboard-port", port("dashboard")),
        ("--http-port", port("http")),
    ];
    let options: Vec<&str> = ports
        .iter()
        .flat_map(|(name, port)| [*name, port])
        .collect();
    let program = "print(\"one\")\nsleep(0.2)\nprint(1 + 1)\n";
    std::fs::write(folder.path().join("two.script"), program).unwrap();
    let arguments = [&["send", "two.script"][..], &options].concat();
    let output = eliteserver_in(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert_eq!(text(&output.stdout), "one\n2\n");

    // Where nobody tells, it is said where to look.
    let arguments = [&["send", "two.script"][..], &options[..8]].concat();
    let output = eliteserver_in(folder.path(), &arguments);
    assert!(
        said(&output).contains("in the log of the robot's pendant"),
        "{}",
        said(&output)
    );

    let arguments = [&["shell"][..], &options].concat();
    let output = typed(
        folder.path(),
        &arguments,
        "x = 20\nx + 22\nprint(\"said\")\n1 / 0\n",
    );
    let shown = text(&output.stdout);
    let lines: Vec<&str> = shown.lines().collect();
    for line in ["42", "said", "ack: 2: x + 22"] {
        assert!(lines.contains(&line), "{line}: {shown}");
    }
    assert!(
        said(&output).contains("ZeroDivisionError"),
        "{}",
        said(&output)
    );
    assert_eq!(output.status.code(), Some(1));
}

#[test]
fn a_part_of_a_recording_is_drawn() {
    let folder = tempfile::tempdir().unwrap();
    run_script(folder.path(), SUM, &["--record", "a.mcap"]);
    let plot = |more: &[&str]| {
        let arguments = [&["replay", "a.mcap", "--plot", "a.png"][..], more].concat();
        eliteserver_in(folder.path(), &arguments)
    };
    assert_eq!(
        plot(&["--from", "0.1", "--to", "0.3"]).status.code(),
        Some(0)
    );
    let output = plot(&["--from", "100"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        said(&output).contains("the recording covers"),
        "{}",
        said(&output)
    );
    let output = eliteserver_in(folder.path(), &["replay", "a.mcap", "--from", "1"]);
    assert_eq!(output.status.code(), Some(2), "--from belongs to --plot");
}
