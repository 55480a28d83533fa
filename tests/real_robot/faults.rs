//! Every command with something wrong between it and its robot: a clear sentence, status 2, and nothing lost that was
//! written. And controllers that are not quite ours, from bytes made by hand after the protocol pages.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use kinematics::RobotModel;
use wire::primary::State;
use wire::primary::state::{Configuration, ModeData};

use super::peers::{Fault, Framing, peer, proxy};
use crate::common::{Server, eliteserver, read_recording};

/// Faults that a command gets over, and faults that end it with a sentence.
const SURVIVED: [Fault; 3] = [Fault::Slow, Fault::Twice, Fault::Swapped(1)];
const ENDING: [(Fault, &str); 3] = [
    (Fault::Cut(4), "has closed the connection"),
    (Fault::Garbled(4), "is not the stream of port 30001"),
    (Fault::Silent(4), "says nothing any more: no state for 3 s"),
];

/// A command whose robot is at these ports.
fn command(name: &str, server: &Server, other: &[(&str, u16)]) -> Command {
    let mut command = eliteserver();
    command.arg(name);
    for port in ["primary", "interpreter", "rtsi", "dashboard"] {
        let other = other.iter().find(|(name, _)| *name == port);
        let number = other.map_or(server.ports[port], |(_, number)| *number);
        command.arg(format!("--{port}-port={number}"));
    }
    command
}

fn ended(mut command: Command, input: &str) -> (String, Option<i32>) {
    command.stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
    // A command that ends at once reads nothing.
    let _ = child.stdin.take().unwrap().write_all(input.as_bytes());
    let Output {
        stdout,
        stderr,
        status,
    } = child.wait_with_output().unwrap();
    let text = [stdout, stderr].concat();
    (String::from_utf8(text).unwrap(), status.code())
}

#[test]
fn send_gets_over_what_can_be_got_over_and_tells_the_rest() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let send = |fault, text: &str| {
        let port = proxy(server.ports["primary"], Framing::Primary, fault, false);
        let mut command = command("send", &server, &[("primary", port)]);
        command.arg("-");
        ended(command, text)
    };
    for fault in SURVIVED {
        let (text, status) = send(fault, "sleep(0.4)\n");
        assert_eq!(status, Some(0), "{fault:?}: {text}");
        let (text, status) = send(fault, "sleep(0.2)\nraise ValueError('mine')\n");
        assert_eq!(status, Some(1), "{fault:?}: {text}");
        assert!(text.contains("ValueError: mine"), "{fault:?}: {text}");
    }
    for (fault, wanted) in ENDING {
        let (text, status) = send(fault, "sleep(2)\n");
        assert_eq!(status, Some(2), "{fault:?}: {text}");
        assert!(text.contains(wanted), "{fault:?}: {text}");
        assert!(text.contains("the program may go on"), "{fault:?}: {text}");
    }
}

#[test]
fn a_shell_gets_over_what_can_be_got_over_and_tells_the_rest() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let shell = |name: &str, framing, fault, text: &str| {
        let port = proxy(server.ports[name], framing, fault, false);
        let (text, status) = ended(command("shell", &server, &[(name, port)]), text);
        // Whatever became of it, the robot is free for the next.
        let mut states = server.primary();
        states.send("stop task\n");
        states.wait_for("nothing runs", |state| !state.task_running);
        (text, status)
    };
    let primary = |fault, text| shell("primary", Framing::Primary, fault, text);
    let lines = |fault, text| shell("interpreter", Framing::Lines, fault, text);
    let statements = "x = 1\ny = x + 1\nsleep(0.3)\n";
    for fault in SURVIVED {
        let (text, status) = primary(fault, statements);
        assert_eq!(status, Some(0), "{fault:?}: {text}");
        assert_eq!(text.matches("ack: ").count(), 3, "{fault:?}: {text}");
    }
    for fault in [Fault::Slow, Fault::Twice] {
        let (text, status) = lines(fault, statements);
        assert_eq!(status, Some(0), "{fault:?}: {text}");
        let (text, status) = lines(fault, "y = f(\nx = 1\n:state\n");
        assert_eq!(status, Some(1), "{fault:?}: {text}");
        assert_eq!(text.matches("discard: ").count(), 1, "{fault:?}: {text}");
        assert_eq!(text.matches("ack: ").count(), 1, "{fault:?}: {text}");
    }
    for (fault, wanted) in ENDING {
        let (text, status) = primary(fault, "sleep(2)\n");
        assert_eq!(status, Some(2), "{fault:?}: {text}");
        assert!(text.contains(wanted), "{fault:?}: {text}");
        assert!(text.contains("its program may go on"), "{fault:?}: {text}");
    }
    for (fault, wanted) in [
        (Fault::Cut(2), "has closed the connection for statements"),
        (Fault::Garbled(2), "has not answered the statement"),
        (
            Fault::Silent(2),
            "does not answer on its port for statements",
        ),
        (
            Fault::Silent(0),
            "does not answer on its port for statements",
        ),
    ] {
        let (text, status) = lines(fault, "x = 1\ny = 2\nz = 3\n");
        assert_eq!(status, Some(2), "{fault:?}: {text}");
        assert!(text.contains(wanted), "{fault:?}: {text}");
        // What nobody can talk to any more does not go on.
        assert!(
            text.contains("the program was stopped"),
            "{fault:?}: {text}"
        );
    }
    // Something else listens there.
    let answer = |_: &[u8]| b"HTTP/1.1 400 Bad Request\r\n\r\n".to_vec();
    let port = peer(Framing::Lines, Vec::new(), answer, |_| Vec::new());
    let (text, status) = ended(command("shell", &server, &[("interpreter", port)]), "");
    assert_eq!(status, Some(2), "{text}");
    assert!(
        text.contains("is not the stream of port 30020: \"HTTP/1.1"),
        "{text}"
    );
}

#[test]
fn a_calibration_is_whole_or_not_there() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let out = folder.path().join("arm.toml");
    let calibrate = |fault| {
        let port = proxy(server.ports["primary"], Framing::Primary, fault, false);
        let mut command = command("calibrate", &server, &[("primary", port)]);
        command.arg("--out").arg(&out);
        std::fs::write(&out, "as it was").unwrap();
        let said = ended(command, "");
        (said, std::fs::read_to_string(&out).unwrap())
    };
    for fault in [Fault::Slow, Fault::Twice, Fault::Swapped(0)] {
        let ((text, status), written) = calibrate(fault);
        assert_eq!(status, Some(0), "{fault:?}: {text}");
        assert!(written.contains("modified_dh"), "{written}");
    }
    for (fault, wanted) in [
        (Fault::Cut(0), "has closed the connection"),
        (Fault::Garbled(0), "is not the stream of port 30001"),
        (Fault::Silent(0), "says nothing any more"),
    ] {
        let ((text, status), written) = calibrate(fault);
        assert_eq!(status, Some(2), "{fault:?}: {text}");
        assert!(text.contains(wanted), "{fault:?}: {text}");
        assert_eq!(written, "as it was", "{fault:?}");
    }
}

/// Times that only grow, of a file that is whole.
fn cycles_of(path: &Path) -> usize {
    let read = read_recording(path);
    let times: Vec<f64> = read.cycles.iter().map(|cycle| cycle.time).collect();
    assert!(times.is_sorted_by(|a, b| a < b), "{}", path.display());
    times.len()
}

#[test]
fn a_recording_keeps_what_came_whatever_is_between() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let out = folder.path().join("robot.mcap");
    let record = |name, framing, fault, seconds: &str| {
        let port = proxy(server.ports[name], framing, fault, true);
        let mut command = command("record", &server, &[(name, port)]);
        command
            .args(["--rate", "125", "--duration", seconds, "--out"])
            .arg(&out);
        let (text, status) = ended(command, "");
        assert_eq!(status, Some(0), "{fault:?}: {text}");
        assert!(cycles_of(&out) > 60, "{fault:?}: {text}");
        text
    };
    let data = |fault, seconds| record("rtsi", Framing::Rtsi, fault, seconds);
    assert!(data(Fault::Slow, "1.5").contains(" 0 reconnects"));
    for fault in [Fault::Twice, Fault::Swapped(20)] {
        let text = data(fault, "1.5");
        assert!(text.contains(" 0 reconnects"), "{fault:?}: {text}");
        assert!(!text.contains(" 0 out of order"), "{fault:?}: {text}");
    }
    for (fault, seconds) in [
        (Fault::Cut(100), "4"),
        (Fault::Garbled(100), "5"),
        (Fault::Silent(100), "7"),
    ] {
        let text = data(fault, seconds);
        assert!(text.contains(" 1 reconnects"), "{fault:?}: {text}");
        assert!(text.contains("trying again"), "{fault:?}: {text}");
    }
    // What port 30001 says is beside the data, and its loss costs nothing of them.
    for fault in [
        Fault::Twice,
        Fault::Cut(3),
        Fault::Garbled(3),
        Fault::Silent(3),
    ] {
        let text = record("primary", Framing::Primary, fault, "1.5");
        assert!(text.contains(" 0 reconnects"), "{fault:?}: {text}");
    }
}

/// A state of an older controller: mode and arm, and parts that nobody knows.
fn older_state(_: u32) -> Vec<u8> {
    let table = RobotModel::built_in("cs66").unwrap().modified_dh().unwrap();
    let state = State {
        mode: Some(ModeData {
            is_powered: true,
            robot_mode: 7,
            ..ModeData::default()
        }),
        configuration: Some(Configuration {
            dh_a: table.a,
            dh_d: table.d,
            dh_alpha: table.alpha,
            robot_type: 6206,
            ..Configuration::default()
        }),
        ..State::default()
    };
    let mut bytes = state.encode();
    bytes.extend([0, 0, 0, 7, 9, 1, 2]);
    bytes.extend([0, 0, 0, 5, 14]);
    let length = u32::try_from(bytes.len()).unwrap();
    bytes[..4].copy_from_slice(&length.to_be_bytes());
    // A message of a type that nobody knows goes before it.
    [&[0, 0, 0, 8, 25, 1, 2, 3][..], &bytes].concat()
}

/// Answers of controller 2.14 that knows three variables, byte for byte as on the protocol page.
fn older_answer(request: &[u8]) -> Vec<u8> {
    match request[2] {
        b'V' => vec![0, 4, b'V', 1],
        b'v' => vec![0, 19, b'v', 0, 0, 0, 2, 0, 0, 0, 14, 0, 0, 0, 0, 0, 0, 0, 0],
        b'S' => vec![0, 4, b'S', 1],
        b'O' => {
            let names = core::str::from_utf8(&request[11..]).unwrap();
            let types = names.split(',').map(|name| match name {
                "timestamp" => "DOUBLE",
                "actual_joint_positions" => "VECTOR6D",
                "robot_mode" => "INT32",
                _ => "NOT_FOUND",
            });
            let types = types.collect::<Vec<_>>().join(",");
            let length = u16::try_from(types.len() + 4).unwrap();
            let head = [length.to_be_bytes()[0], length.to_be_bytes()[1], b'O', 1];
            [&head[..], types.as_bytes()].concat()
        }
        _ => Vec::new(),
    }
}

/// A package of these three, now and then one of another recipe and a text.
fn older_data(number: u32) -> Vec<u8> {
    let mut out = vec![0, 64, b'U', 1];
    out.extend((12.5 + f64::from(number) * 0.004).to_be_bytes());
    for joint in 0..6_u8 {
        out.extend((f64::from(joint) * 0.1).to_be_bytes());
    }
    out.extend(7_i32.to_be_bytes());
    if number % 20 == 3 {
        out.extend([0, 5, b'U', 9, 1]);
        out.extend([0, 9, b'M', 2, b'w', b'a', b'r', b'm', b'!']);
    }
    out
}

#[test]
fn older_controllers_are_recorded_and_calibrated_as_far_as_they_tell() {
    let folder = tempfile::tempdir().unwrap();
    let silent = |_: &[u8]| Vec::new();
    let primary = peer(Framing::Lines, Vec::new(), silent, older_state);
    let rtsi = peer(Framing::Rtsi, Vec::new(), older_answer, older_data);
    let ports = [
        format!("--primary-port={primary}"),
        format!("--rtsi-port={rtsi}"),
    ];
    let out = folder.path().join("old.mcap");
    let mut record = eliteserver();
    record.arg("record").args(&ports);
    record.args(["--duration", "1", "--out"]).arg(&out);
    let (text, status) = ended(record, "");
    assert_eq!(status, Some(0), "{text}");
    assert!(text.contains("controller 2.14.0: 3 of "), "{text}");
    assert!(text.contains(" 0 reconnects"), "{text}");
    assert!(cycles_of(&out) > 50, "{text}");
    let read = read_recording(&out);
    let last = read.cycles.last().unwrap();
    assert_eq!(last.actual_q[..3], [0.0, 0.1, 0.2]);
    assert!(last.tcp_force.iter().all(|value| value.is_nan()));
    assert!(
        text.contains("does not offer target_joint_positions, "),
        "{text}"
    );
    let mut replay = eliteserver();
    replay.arg("replay").arg(&out);
    let (summary, status) = ended(replay, "");
    assert_eq!(status, Some(0), "{summary}");
    assert!(summary.contains("not known: target_q, "), "{summary}");
    assert!(!summary.contains(" actual_q,"), "{summary}");
    let mut replay = eliteserver();
    replay.arg("replay").arg(&out).args(["--csv", "/log"]);
    let (log, status) = ended(replay, "");
    assert_eq!(status, Some(0), "{log}");
    assert!(log.contains("warm!"), "{log}");

    // One that takes no long list is asked for what a cycle has a place for.
    let no_long_list: fn(&[u8]) -> Vec<u8> = |request| match request[2] {
        b'O' if request.len() > 2000 => vec![0, 4, b'O', 0],
        _ => older_answer(request),
    };
    let rtsi = peer(Framing::Rtsi, Vec::new(), no_long_list, older_data);
    let short = folder.path().join("short.mcap");
    let mut record = eliteserver();
    record.arg("record").arg(&ports[0]);
    record.arg(format!("--rtsi-port={rtsi}"));
    record.args(["--duration", "1", "--out"]).arg(&short);
    let (text, status) = ended(record, "");
    assert_eq!(status, Some(0), "{text}");
    assert!(text.contains("48 × output_int_register"), "{text}");
    assert!(cycles_of(&short) > 50, "{text}");

    let arm = folder.path().join("arm.toml");
    let mut calibrate = eliteserver();
    calibrate
        .arg("calibrate")
        .args(&ports)
        .arg("--out")
        .arg(&arm);
    let (text, status) = ended(calibrate, "");
    assert_eq!(status, Some(0), "{text}");
    assert!(
        text.contains("the cs66 at") && text.contains("0.000 mm"),
        "{text}"
    );
}

#[test]
fn another_protocol_and_other_answers_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let silent = |_: &[u8]| Vec::new();
    let primary = peer(Framing::Lines, Vec::new(), silent, older_state);
    let out = folder.path().join("old.mcap");
    let nothing = |_| Vec::new();
    let refuses: fn(&[u8]) -> Vec<u8> = |_| vec![0, 4, b'V', 0];
    let other_list: fn(&[u8]) -> Vec<u8> = |request| match request[2] {
        b'O' => b"\x00\x0aO\x01DOUBLE".to_vec(),
        _ => older_answer(request),
    };
    let knows_nothing: fn(&[u8]) -> Vec<u8> = |request| match request[2] {
        b'O' => {
            let count = request[11..].split(|byte| *byte == b',').count();
            let types = vec!["NOT_FOUND"; count].join(",");
            let length = u16::try_from(types.len() + 4).unwrap().to_be_bytes();
            [&[length[0], length[1], b'O', 1], types.as_bytes()].concat()
        }
        _ => older_answer(request),
    };
    let stopped: fn(&[u8]) -> Vec<u8> = |request| match request[2] {
        b'S' => vec![0, 4, b'S', 0],
        _ => older_answer(request),
    };
    let mute: fn(&[u8]) -> Vec<u8> = |_| Vec::new();
    let http: fn(&[u8]) -> Vec<u8> = |_| vec![0, 1, b'H'];
    for (answer, wanted) in [
        (refuses, "refuses version 1 of the protocol"),
        (
            other_list,
            "answers the list of variables with something else",
        ),
        (knows_nothing, "refuses every variable that is asked for"),
        (stopped, "refuses to start"),
        (
            mute,
            "does not answer on its port for data (the protocol's version)",
        ),
        (http, "is not RTSI"),
    ] {
        let rtsi = peer(Framing::Rtsi, Vec::new(), answer, nothing);
        let mut record = eliteserver();
        record
            .arg("record")
            .arg(format!("--primary-port={primary}"));
        record.arg(format!("--rtsi-port={rtsi}"));
        record.args(["--duration", "1", "--out"]).arg(&out);
        let (text, status) = ended(record, "");
        assert_eq!(status, Some(2), "{wanted}: {text}");
        assert!(text.contains(wanted), "{wanted}: {text}");
        assert!(!out.exists(), "{wanted}: nothing was recorded");
    }
    // Names that do not resolve, and nobody there, for every command.
    for name in ["send", "shell", "record", "calibrate"] {
        for (host, wanted) in [
            (
                "no.such.robot.invalid",
                "\"no.such.robot.invalid\" is not known",
            ),
            ("127.0.0.1", "no connection to the robot at 127.0.0.1:9: "),
        ] {
            let mut command = eliteserver();
            command.args([name, "--robot", host, "--primary-port=9"]);
            command.args([
                "--dashboard-port=9",
                "--interpreter-port=9",
                "--rtsi-port=9",
            ]);
            match name {
                "send" => drop(command.arg("-")),
                "shell" => {}
                _ => drop(command.arg("--out").arg(&out)),
            }
            let (text, status) = ended(command, "pass\n");
            assert_eq!(status, Some(2), "{name}: {text}");
            assert!(text.contains(wanted), "{name}: {text}");
        }
    }
}
