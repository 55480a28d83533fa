//! The commands at the other end of the wire, against our own server as the robot, and against peers that are none.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "helpers fail by panicking"
)]

mod faults;
mod peers;
mod recorded;
mod run_here;
mod shell;
mod terminal;

use std::io::{Read, Write};
use std::net::TcpListener;
use std::path::Path;
use std::process::{Output, Stdio};
use std::time::{Duration, Instant};

use crate::common::{Server, eliteserver, send_signal};

/// A command that speaks to the server.
fn command(server: &Server, name: &str) -> std::process::Command {
    let mut command = eliteserver();
    command.arg(name);
    for port in ["primary", "interpreter", "rtsi", "dashboard"] {
        command.arg(format!("--{port}-port={}", server.ports[port]));
    }
    command
}

fn send(server: &Server, folder: &Path, text: &str, options: &[&str]) -> (String, Option<i32>) {
    let file = folder.join("task.script");
    std::fs::write(&file, text).unwrap();
    let sent = command(server, "send")
        .arg(&file)
        .args(options)
        .output()
        .unwrap();
    said(sent)
}

fn said(output: Output) -> (String, Option<i32>) {
    (
        String::from_utf8(output.stderr).unwrap(),
        output.status.code(),
    )
}

#[test]
fn programs_are_followed_to_their_ends_and_errors_name_the_local_file() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &["--clock", "virtual"]);
    let path = folder.path();
    let (text, status) = send(&server, path, "x = 1\nsleep(0.3)\n", &[]);
    assert_eq!(status, Some(0), "{text}");
    // One that nobody can see running.
    assert_eq!(send(&server, path, "x = 1\n", &[]).1, Some(0));
    let fails = "count = 0\ndef deeper(n):\n    global count\n    count += n\n    return 1 / 0\nsleep(0.2)\n\
                 deeper(2)\n";
    let (text, status) = send(&server, path, fails, &[]);
    assert_eq!(status, Some(1), "{text}");
    assert!(
        text.contains("ZeroDivisionError: division by zero"),
        "{text}"
    );
    assert!(text.contains("task.script:5:"), "{text}");
    assert!(text.contains("  |     return 1 / 0"), "{text}");
    // A block as the pendant makes it.
    let block = "def task():\n  sleep(0.2)\n  raise ValueError('of mine')\nend\n";
    let (text, status) = send(&server, path, block, &[]);
    assert!(
        text.contains("ValueError: of mine") && text.contains("task.script:3:"),
        "{text}"
    );
    assert_eq!(status, Some(1));
    // What is sent stands in the variables of the program.
    let set = "if speed != 0.25 or name != 'left':\n    raise ValueError(name)\n";
    let (text, status) = send(
        &server,
        path,
        set,
        &["--set", "speed=0.25", "--set", "name='left'"],
    );
    assert_eq!(
        (text.contains("undefined"), status),
        (false, Some(0)),
        "{text}"
    );
}

/// What was sent is the file for the controller, too: by name and lines in its log, its recording and its errors.
#[test]
fn the_controller_speaks_of_the_file_that_was_sent() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let server = Server::start(path, &["--record", "run.mcap"]);
    let text = "# first\ncount = 2\n\ntextmsg(count, speed)\nsleep(0.2)\n";
    let (said, status) = send(&server, path, text, &["--set", "speed=0.25"]);
    assert_eq!(status, Some(0), "{said}");
    let block = "# of the pendant\n\ndef pick():\n  sleep(0.2)\n  return 1 / 0\nend\n";
    let (said, status) = send(&server, path, block, &[]);
    assert_eq!(status, Some(1), "{said}");
    assert!(said.contains("task.script:5:"), "{said}");
    assert!(server.terminate().success());
    let log = std::fs::read_to_string(path.join("stderr.log")).unwrap();
    for part in [
        "called=\"task.script\" id=1}:thread{number=0 line=4}: script: 20.25",
        "task.script, line 5, column 10, in pick",
    ] {
        assert!(log.contains(part), "{part} in {log}");
    }
    assert!(!log.contains("_program"), "{log}");
    let replayed = eliteserver()
        .args(["replay", "run.mcap"])
        .current_dir(path)
        .output()
        .unwrap();
    let summary = String::from_utf8_lossy(&replayed.stdout);
    assert!(summary.contains("task.script"), "{summary}");
}

#[test]
fn what_is_not_sent_is_told_with_status_2() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let (text, status) = send(&server, folder.path(), "movej(\n", &[]);
    assert!(
        text.contains("task.script:1:") && text.contains("nothing was sent"),
        "{text}"
    );
    assert_eq!(status, Some(2));
    let missing = command(&server, "send")
        .arg("/does/not/exist")
        .output()
        .unwrap();
    let (text, status) = said(missing);
    assert!(
        text.contains("cannot read the script /does/not/exist"),
        "{text}"
    );
    assert_eq!(status, Some(2));
    let (text, status) = send(&server, folder.path(), "pass\n", &["--set", "x"]);
    assert!(text.contains("--set x: NAME=VALUE is needed"), "{text}");
    assert_eq!(status, Some(2));
    // Not checked: the robot's own findings are what counts.
    let (text, status) = send(
        &server,
        folder.path(),
        "def f():\n  movej(\nend\n",
        &["--no-check"],
    );
    assert_eq!(status, Some(1), "{text}");
    assert!(text.contains("SyntaxError"), "{text}");
}

#[test]
fn a_protective_stop_fails_the_program() {
    let folder = tempfile::tempdir().unwrap();
    let cell = folder.path().join("cell.toml");
    std::fs::write(
        &cell,
        "[[safety_plane]]\nname = \"floor\"\npoint = [0, 0, 0.1]\nnormal = [0, 0, 1]\n",
    )
    .unwrap();
    let server = Server::start(
        folder.path(),
        &["--clock", "virtual", "--cell", cell.to_str().unwrap()],
    );
    let (text, status) = send(
        &server,
        folder.path(),
        "speedl([0, 0, -0.5, 0, 0, 0], 1.0, 5)\n",
        &[],
    );
    assert_eq!(status, Some(1), "{text}");
    assert!(
        text.contains("error 100.12: protective stop: the tool was about to cross"),
        "{text}"
    );
    // With the place that asked for the motion, to everybody.
    assert!(text.contains(" (task.script:1)"), "{text}");
    let log = std::fs::read_to_string(folder.path().join("stderr.log")).unwrap();
    assert!(
        log.contains(
            "called=\"task.script\" id=1}:thread{number=0 line=1}: script: protective stop"
        ),
        "{log}"
    );
}

#[test]
fn ctrl_c_stops_the_program_on_the_robot_first() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let file = folder.path().join("long.script");
    std::fs::write(&file, "while True:\n    sleep(0.1)\n").unwrap();
    let child = command(&server, "send")
        .arg(&file)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut states = server.primary();
    states.wait_for("the program runs", |state| state.task_running);
    send_signal(child.id(), "INT");
    let (text, status) = said(child.wait_with_output().unwrap());
    assert_eq!(status, Some(1), "{text}");
    assert!(text.contains("the program was stopped"), "{text}");
    states.wait_for("nothing runs", |state| !state.task_running);
}

#[test]
fn a_robot_in_local_mode_gets_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &["--local"]);
    let (text, status) = send(&server, folder.path(), "pass\n", &[]);
    assert_eq!(status, Some(2), "{text}");
    assert!(text.contains("is in local mode"), "{text}");
}

#[test]
fn a_robot_with_remote_control_disabled_takes_programs_by_the_primary_port() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &["--control", "mixed"]);
    let (text, status) = send(&server, folder.path(), "sleep(0.9)\n", &[]);
    assert_eq!(status, Some(0), "{text}");
    assert!(!text.contains("local mode"), "{text}");
}

#[test]
fn who_is_no_robot_is_told_so_within_seconds() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("task.script");
    std::fs::write(&file, "pass\n").unwrap();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    // The first peer speaks another language, the second says nothing, the third hangs up, the fourth stops in the
    // middle.
    let peers = std::thread::spawn(move || {
        let mut peers = Vec::new();
        for answer in ["HTTP/1.1 400 Bad Request\r\n\r\n", "", "bye", "\0\0\u{4}"] {
            let (mut peer, _) = listener.accept().unwrap();
            if answer != "bye" {
                peer.write_all(answer.as_bytes()).unwrap();
                peers.push(peer);
            }
        }
        std::thread::sleep(Duration::from_secs(8));
    });
    let begin = Instant::now();
    for wanted in [
        "is not the stream of port 30001: a message of 1213486160 bytes",
        "says nothing any more: no state for 3 s",
        "has closed the connection",
        "says nothing any more: no state for 3 s",
    ] {
        let sent = eliteserver()
            .args([
                "send",
                "--dashboard-port=1",
                &format!("--primary-port={port}"),
            ])
            .arg(&file)
            .output()
            .unwrap();
        let (text, status) = said(sent);
        assert!(text.contains(wanted), "{text}");
        assert_eq!(status, Some(2));
    }
    assert!(begin.elapsed() < Duration::from_secs(20));
    drop(peers);
    for (host, wanted) in [
        ("127.0.0.1", "no connection to the robot at 127.0.0.1:9: "),
        (
            "no.such.robot.invalid",
            "\"no.such.robot.invalid\" is not known",
        ),
    ] {
        let sent = eliteserver()
            .args([
                "send",
                "--primary-port=9",
                "--dashboard-port=9",
                "--robot",
                host,
            ])
            .arg(&file)
            .stdin(Stdio::null())
            .output()
            .unwrap();
        let (text, status) = said(sent);
        assert!(text.contains(wanted), "{text}");
        assert_eq!(status, Some(2));
    }
}

#[test]
fn an_arm_is_calibrated_from_the_robot_and_is_the_same_arm_here() {
    let folder = tempfile::tempdir().unwrap();
    let arm = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/calibrations");
    let file = std::fs::read_dir(arm)
        .unwrap()
        .flatten()
        .map(|entry| entry.path());
    let file = file
        .filter(|path| path.extension().is_some_and(|end| end == "toml"))
        .min()
        .unwrap();
    let server = Server::start(folder.path(), &["--calibration", file.to_str().unwrap()]);
    let out = folder.path().join("arm.toml");
    let read = command(&server, "calibrate")
        .arg("--out")
        .arg(&out)
        .output()
        .unwrap();
    let (text, status) = said(read);
    assert_eq!(status, Some(0), "{text}");
    assert!(text.contains(" mm on average) and "), "{text}");
    let mut wanted = String::new();
    std::fs::File::open(&file)
        .unwrap()
        .read_to_string(&mut wanted)
        .unwrap();
    let values = |text: &str| {
        let table: toml::Table = text.parse().unwrap();
        let number = |value: &toml::Value| {
            let whole = || value.as_integer().unwrap() as f64;
            value.as_float().unwrap_or_else(whole)
        };
        let row = |key: &str| {
            let numbers = table["modified_dh"][key].as_array().unwrap();
            numbers.iter().map(number).collect::<Vec<f64>>()
        };
        (table["model"].clone(), ["a", "d", "alpha"].map(row))
    };
    assert_eq!(
        values(&std::fs::read_to_string(&out).unwrap()),
        values(&wanted)
    );
    // What was written is what the controller takes.
    let script = folder.path().join("where.script");
    std::fs::write(&script, "print(get_actual_tcp_pose())\n").unwrap();
    let printed = |calibration: &Path| {
        let ran = eliteserver()
            .arg("run")
            .arg(&script)
            .arg("--calibration")
            .arg(calibration)
            .output()
            .unwrap();
        assert!(ran.status.success());
        ran.stdout
    };
    assert_eq!(printed(&out), printed(&file));
}

#[test]
fn offsets_of_the_joints_which_no_port_carries_are_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/calibrations");
    let measured = std::fs::read_to_string(robots.join("cs66-measured.toml")).unwrap();
    let with_offsets = folder.path().join("offsets.toml");
    std::fs::write(
        &with_offsets,
        format!("{measured}\ntheta = [0, 0.004, 0, 0, 0, 0]\n"),
    )
    .unwrap();
    for (file, is_noticed) in [
        (robots.join("cs66-measured.toml"), false),
        (with_offsets, true),
    ] {
        let options = [
            "--calibration",
            file.to_str().unwrap(),
            "--tcp=0,0,0.1,0.3,0,0",
        ];
        let server = Server::start(folder.path(), &options);
        let read = command(&server, "calibrate")
            .args(["--out", "/dev/null"])
            .output();
        let (text, status) = said(read.unwrap());
        assert_eq!(status, Some(0), "{text}");
        let notice = "it counts with something that it does not send";
        assert_eq!(text.contains(notice), is_noticed, "{text}");
        server.terminate();
        std::fs::remove_file(folder.path().join("ready.json")).unwrap_or_default();
    }
    assert!(!std::fs::metadata("/dev/null").unwrap().is_file());
}

#[test]
fn runs_are_compared_at_any_rate_and_delay_and_differences_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let record = |name: &str, text: &str, options: &[&str]| {
        let (script, out) = (
            folder.path().join(format!("{name}.script")),
            folder.path().join(format!("{name}.mcap")),
        );
        std::fs::write(&script, text).unwrap();
        let ran = eliteserver()
            .arg("run")
            .arg(&script)
            .arg("--record")
            .arg(&out)
            .args(options)
            .output()
            .unwrap();
        assert!(ran.status.success(), "{ran:?}");
        out
    };
    let moves = "movej([0.3, -1.4, 1.5, -1.6, -1.5, 0.2], a=1.2, v=0.8)\n\
                 movel([-0.4, -0.2, 0.3, 3.1, 0, 0.5], a=0.8, v=0.2)\n";
    let a = record("a", moves, &["--step-ms", "4"]);
    let late = format!("sleep(1.7)\n{moves}");
    let b = record("b", &late, &["--step-ms", "2", "--plant", "ideal"]);
    let other = moves.replace("0.3, 3.1", "0.33, 3.1");
    let c = record("c", &other, &[]);
    let compare = |first: &Path, second: &Path, options: &[&str]| {
        let mut command = eliteserver();
        command.arg("compare").arg(first).arg(second).args(options);
        let output = command.output().unwrap();
        let text = [output.stdout.clone(), output.stderr.clone()].concat();
        (String::from_utf8(text).unwrap(), output.status.code())
    };
    let (text, status) = compare(&a, &b, &["--within", "0.005"]);
    assert_eq!(status, Some(0), "{text}");
    assert!(
        text.contains("shift: 1.70") && text.contains("TCP position"),
        "{text}"
    );
    let (text, status) = compare(&a, &c, &["--within", "0.005", "--format", "json"]);
    assert_eq!(status, Some(1), "{text}");
    let found: serde_json::Value = serde_json::from_str(text.lines().next().unwrap()).unwrap();
    let apart = found["tcp_position"]["largest"].as_f64().unwrap();
    assert!((0.029..0.035).contains(&apart), "{found}");
    assert_eq!(found["within"], false);
    let picture = folder.path().join("apart.png");
    let (text, status) = compare(&a, &c, &["--plot", picture.to_str().unwrap()]);
    assert_eq!(status, Some(0), "{text}");
    assert!(std::fs::read(&picture).unwrap().starts_with(b"\x89PNG"));
    // A recording is equal to itself to the last digit.
    let (text, _) = compare(&a, &a, &["--within", "0"]);
    assert!(text.contains("shift: 0.0000 s"), "{text}");
    for missing in ["/does/not/exist.mcap", "/dev/null"] {
        let (text, status) = compare(&a, Path::new(missing), &[]);
        assert_eq!(status, Some(2), "{text}");
        assert!(text.starts_with("eliteserver: "), "{text}");
    }
}
