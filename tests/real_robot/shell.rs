//! `eliteserver shell` from a pipe, with our own server as the robot.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, Stdio};
use std::time::Duration;

use super::{command, send};
use crate::common::{Server, eliteserver, send_signal};

/// What a shell said to a pipe: standard output, standard error, status.
fn piped(server: &Server, text: &str, options: &[&str]) -> (String, String, Option<i32>) {
    let mut child = started(server, options);
    child
        .stdin
        .take()
        .unwrap()
        .write_all(text.as_bytes())
        .unwrap();
    ended(child)
}

fn started(server: &Server, options: &[&str]) -> Child {
    let mut shell = command(server, "shell");
    shell.args(options).stdin(Stdio::piped());
    shell.stdout(Stdio::piped()).stderr(Stdio::piped());
    shell.spawn().unwrap()
}

fn ended(child: Child) -> (String, String, Option<i32>) {
    let output = child.wait_with_output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (
        text(output.stdout),
        text(output.stderr),
        output.status.code(),
    )
}

#[test]
fn statements_of_a_pipe_are_acknowledged_and_done_before_the_end() {
    for clock in ["virtual", "realtime"] {
        let folder = tempfile::tempdir().unwrap();
        let server = Server::start(folder.path(), &["--clock", clock]);
        let text = "\
x = 1
def f(a):  # a comment; with a semicolon
    if a > 1:
        set_standard_digital_out(a, True); set_standard_digital_out(1, True)
    end
end
f(3)
movej([0.1, -1.5708, 1.5708, -1.5708, -1.5708, 0], a=3, v=2)
:state
";
        let (out, err, status) = piped(&server, text, &[]);
        assert_eq!(status, Some(0), "{out}{err}");
        for line in [
            "ack: 1: x = 1\n",
            "ack: 3: f(3)\n",
            "ack: 4: movej(",
            "  robot RUNNING, program running, speed 100 %\n",
            "4 accepted last",
        ] {
            assert!(out.contains(line), "{line}: {out}");
        }
        assert!(err.contains("interpreter mode of the robot at 127.0.0.1:"));
        // The motion was not cut short by the end of the pipe, and the program is over.
        let state = server.primary().state();
        assert!((state.target_q[0] - 0.1).abs() < 1e-9, "{state:?}");
        assert_eq!(state.digital_out & 0b1010, 0b1010);
        assert!(!state.task_running);
    }
}

#[test]
fn globals_that_are_set_are_told_and_a_block_may_end_with_the_pipe() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &["--clock", "virtual"]);
    let mut shell = started(&server, &["--set", "speed=0.25", "--set", "side='left'"]);
    let mut stdin = shell.stdin.take().unwrap();
    stdin.write_all(b"speed = speed + 1\n").unwrap();
    // The robot publishes variables ten times a second.
    std::thread::sleep(Duration::from_millis(600));
    stdin
        .write_all(b":vars\n:vars nothing\nif speed > 1:\n  set_standard_digital_out(5, True)")
        .unwrap();
    drop(stdin);
    let (out, err, status) = ended(shell);
    assert_eq!(status, Some(0), "{out}{err}");
    assert!(out.contains("  speed = 1.25\n"), "{out}");
    assert!(
        out.contains("side = left\n") || out.contains("side = 'left'\n"),
        "{out}"
    );
    assert!(out.contains("  nothing: not told"), "{out}");
    assert_eq!(server.primary().state().digital_out & 32, 32);
}

#[test]
fn what_is_discarded_or_fails_makes_the_status_of_a_pipe_1() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &["--clock", "virtual"]);
    let long = format!("x = '{}'\n", "a".repeat(70_000));
    let cases = [
        ("y = f(\n", "discard: Compile error:"),
        ("start_thread(f, ())\n", "discard: Compile error:"),
        ("raise ValueError('of mine')\n", "ValueError: of mine"),
        // After an error the program is over; what follows is not for a new one.
        ("1 / 0\nsleep(0.5)\n", "ZeroDivisionError"),
        (
            ":nothing\n",
            "there is no :nothing; there are :abort, :help",
        ),
        (":state now\n", ":state takes nothing behind it"),
        (":log many\n", ":log takes how many lines"),
        (
            "def f():\n  x = '''a\nb'''\nend\n",
            "cannot stand in a block",
        ),
        (long.as_str(), "a line of more than 64 KiB"),
    ];
    for (text, wanted) in cases {
        let (out, err, status) = piped(&server, text, &[]);
        let shown = &text[..text.len().min(40)];
        assert_eq!(status, Some(1), "{shown}: {out}{err}");
        assert!(
            format!("{out}{err}").contains(wanted),
            "{shown}: {out}{err}"
        );
        assert!(!server.primary().state().task_running);
    }
    // Words and orders are no failures; each has its answer.
    let text = ":abort\n:skip\nabort\nstateunexecuted\n:log\n:help\n:quit\nnever sent\n";
    let (out, err, status) = piped(&server, text, &[]);
    assert_eq!(status, Some(0), "{out}{err}");
    for wanted in [
        ": abort\n",
        ": skipbuffer\n",
        "state: 0: stateunexecuted\n",
        "  :vars",
    ] {
        assert!(out.contains(wanted), "{wanted}: {out}");
    }
    assert!(!out.contains("never"), "{out}");
}

#[test]
fn ctrl_c_stops_the_program_on_the_robot_and_then_the_shell() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let mut shell = started(&server, &[]);
    let mut stdin = shell.stdin.take().unwrap();
    stdin.write_all(b"while True: sleep(0.1)\n").unwrap();
    let mut line = String::new();
    let mut out = BufReader::new(shell.stdout.take().unwrap());
    out.read_line(&mut line).unwrap();
    assert!(line.starts_with("ack: "), "{line}");
    send_signal(shell.id(), "INT");
    let mut states = server.primary();
    states.wait_for("nothing runs", |state| !state.task_running);
    let (_, err, status) = ended(shell);
    assert_eq!(status, Some(1), "{err}");
    assert!(err.contains("the program was stopped"), "{err}");
    drop(stdin);
}

#[test]
fn a_robot_that_is_busy_local_or_none_gets_nothing_and_the_status_is_2() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let endless = "while True:\n    sleep(0.1)\n";
    let (_, status) = send(&server, folder.path(), endless, &["--no-wait"]);
    assert_eq!(status, Some(0));
    let mut states = server.primary();
    states.wait_for("the program runs", |state| state.task_running);
    let (_, err, status) = piped(&server, "x = 1\n", &[]);
    assert_eq!(status, Some(2), "{err}");
    assert!(err.contains("a program runs on the robot"), "{err}");
    assert!(states.state().task_running, "it was left alone");
    let (_, err, status) = piped(&server, "", &["--set", "speed"]);
    assert!(err.contains("--set speed: NAME=VALUE is needed"), "{err}");
    assert_eq!(status, Some(2));
    drop(server);

    let local = tempfile::tempdir().unwrap();
    let server = Server::start(local.path(), &["--local"]);
    let (_, err, status) = piped(&server, "x = 1\n", &[]);
    assert_eq!(status, Some(2), "{err}");
    assert!(err.contains("is in local mode"), "{err}");
    drop(server);

    for (host, wanted) in [
        ("127.0.0.1", "no connection to the robot at 127.0.0.1:9"),
        ("no.such.robot.invalid", "is not known"),
    ] {
        let ports = ["--primary-port=9", "--dashboard-port=9"];
        let mut shell = eliteserver();
        shell.arg("shell").args(ports).args(["--robot", host]);
        let output = shell.output().unwrap();
        let err = String::from_utf8(output.stderr).unwrap();
        assert!(err.contains(wanted), "{err}");
        assert_eq!(output.status.code(), Some(2));
    }
}
