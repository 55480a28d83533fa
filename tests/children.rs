//! What a program has started ends with it: children, their children, and those that have left everything behind.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test fails by panicking"
)]

use std::path::Path;
use std::time::{Duration, Instant};

use crate::common::{PATIENCE, Server, run_script};

/// Ways in which `sleep 97` may be started by a shell, so that it is nobody's business any more.
const WAYS: [(&str, &str); 7] = [
    ("in the background", "sleep 97 & echo $! > pid"),
    ("by a child", "sh -c 'sleep 97 & echo $! > pid'"),
    (
        "deaf to the terminal",
        "nohup sleep 97 >/dev/null 2>&1 & echo $! > pid",
    ),
    (
        "in a session of its own",
        "setsid sleep 97 & sleep 0.2; pgrep -n -x sleep > pid",
    ),
    (
        "as a daemon",
        "(setsid sh -c 'sh -c \"echo \\$\\$ > pid; exec sleep 97\" &' &)",
    ),
    (
        "as a daemon without an environment",
        "(env -i setsid /bin/sh -c '(/bin/sh -c \"echo \\$\\$ > pid; exec /bin/sleep 97\" &)' &)",
    ),
    (
        "by a chain that dies behind itself",
        "sh -c '(sh -c \"(setsid sh -c \\\"echo \\\\\\$\\\\\\$ > pid; exec sleep 97\\\" &)\" &)'",
    ),
];

/// A program that starts one and goes on.
fn program(folder: &Path, way: &str, rest: &str) -> String {
    format!(
        "import subprocess, os\nos.chdir({:?})\nsubprocess.run(['sh', '-c', {way:?}], stdout=subprocess.DEVNULL)\n\
         while not (os.path.exists('pid') and open('pid').read().strip()):\n  sleep(0.01)\nend\n{rest}\n",
        folder.to_str().unwrap()
    )
}

fn number_in(folder: &Path) -> i32 {
    let begin = Instant::now();
    loop {
        if let Ok(text) = std::fs::read_to_string(folder.join("pid"))
            && let Ok(number) = text.trim().parse()
        {
            return number;
        }
        assert!(begin.elapsed() < PATIENCE, "nothing was started");
        std::thread::sleep(Duration::from_millis(10));
    }
}

fn is_asleep(number: i32) -> bool {
    let name = std::fs::read(format!("/proc/{number}/cmdline")).unwrap_or_default();
    let runs = std::fs::read_to_string(format!("/proc/{number}/stat"))
        .is_ok_and(|stat| !stat.contains(") Z "));
    runs && name.windows(8).any(|part| part == b"sleep\x0097")
}

/// True when it has gone within a while; it is killed if not.
fn has_gone(number: i32) -> bool {
    let begin = Instant::now();
    while is_asleep(number) {
        if begin.elapsed() > Duration::from_secs(2) {
            let _ = std::process::Command::new("kill")
                .args(["-9", &number.to_string()])
                .status();
            return false;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    true
}

#[test]
fn whatever_a_program_has_started_is_gone_when_it_has_ended() {
    for (name, way) in WAYS {
        let folder = tempfile::tempdir().unwrap();
        let text = program(folder.path(), way, "print('on')");
        let options = ["--plant", "ideal", "--allow", "process", "--allow", "fs"];
        let output = run_script(folder.path(), &text, &options);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{name}: {errors}");
        let number = number_in(folder.path());
        // At once: the controller has waited for it.
        assert!(
            !is_asleep(number) || !has_gone(number),
            "{name}: not killed before the end"
        );
        assert!(has_gone(number), "{name}: process {number} lives on");
    }
}

#[test]
fn it_is_gone_when_the_controller_is_terminated() {
    let folder = tempfile::tempdir().unwrap();
    let options = ["--plant", "ideal", "--allow", "process", "--allow", "fs"];
    let server = Server::start(folder.path(), &options);
    let lines = program(folder.path(), WAYS[5].1, "while True:\n  sleep(0.1)\nend");
    let body: Vec<String> = lines.lines().map(|line| format!("  {line}")).collect();
    let mut client = server.primary();
    client.send(&format!("def p():\n{}\nend\n", body.join("\n")));
    let number = number_in(folder.path());
    std::thread::sleep(Duration::from_millis(200));
    assert!(is_asleep(number));
    assert_eq!(server.terminate().code(), Some(0));
    assert!(has_gone(number), "it outlived the controller");
}

#[test]
fn a_child_dies_with_a_controller_that_is_killed() {
    let folder = tempfile::tempdir().unwrap();
    let options = ["--plant", "ideal", "--allow", "process", "--allow", "fs"];
    let server = Server::start(folder.path(), &options);
    let text = program(folder.path(), "echo", "");
    let text = text.replace(
        "subprocess.run(['sh', '-c', \"echo\"], stdout=subprocess.DEVNULL)",
        "subprocess.Popen(['sh', '-c', 'echo $$ > pid; exec sleep 97'])",
    );
    assert!(text.contains("Popen"), "{text}");
    let body: Vec<String> = text.lines().map(|line| format!("  {line}")).collect();
    server.primary().send(&format!(
        "def p():\n{}\n  sleep(60)\nend\n",
        body.join("\n")
    ));
    let number = number_in(folder.path());
    std::thread::sleep(Duration::from_millis(200));
    assert!(is_asleep(number));
    server.kill();
    assert!(has_gone(number), "it outlived the controller");
}
