//! `eliteserver record`: what a robot does, and a robot that goes away and comes back.

use std::process::Stdio;
use std::time::Duration;

use super::{command, said, send};
use crate::common::{self, Server, eliteserver, send_signal};

#[test]
fn a_robot_is_recorded_with_its_errors_and_its_recording_reads_like_our_own() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let out = folder.path().join("robot.mcap");
    let mut command = command(&server, "record");
    command
        .args(["--duration", "4", "--out"])
        .arg(&out)
        .stderr(Stdio::piped());
    let recording = command.spawn().unwrap();
    std::thread::sleep(Duration::from_millis(800));
    let moves = "movej([0.3, -1.4, 1.5, -1.6, -1.5, 0.2], a=3, v=1.5)\nset_standard_digital_out(3, True)\n\
                 write_output_integer_register(5, 42)\nset_tool_voltage(24)\nsleep(0.2)\n\
                 raise ValueError('seen from outside')\n";
    let (_, status) = send(&server, folder.path(), moves, &[]);
    assert_eq!(status, Some(1));
    let (text, status) = said(recording.wait_with_output().unwrap());
    assert_eq!(status, Some(0), "{text}");
    assert!(text.contains("recording the cs66 at 127.0.0.1:"), "{text}");
    assert!(
        text.contains(" cycles, ") && text.contains(" 0 reconnects"),
        "{text}"
    );
    let read = common::read_recording(&out);
    assert!(
        (500..1100).contains(&read.cycles.len()),
        "{}",
        read.cycles.len()
    );
    let (first, last) = (&read.cycles[0], read.cycles.last().unwrap());
    assert!((first.actual_q[0]).abs() < 0.01 && (last.actual_q[0] - 0.3).abs() < 0.01);
    assert_eq!(last.mode, "unknown");
    assert_eq!(last.digital_out & 8, 8);
    assert!(last.target_qdd.iter().all(|value| value.is_nan()));
    assert!(
        read.cycles
            .iter()
            .all(|cycle| cycle.controller_temperature > 0.0)
    );
    let replay = |options: &[&str]| {
        let output = eliteserver()
            .arg("replay")
            .arg(&out)
            .args(options)
            .output()
            .unwrap();
        let text = [output.stdout.clone(), output.stderr.clone()].concat();
        (String::from_utf8(text).unwrap(), output.status.code())
    };
    let (summary, status) = replay(&[]);
    assert_eq!(status, Some(0), "{summary}");
    assert!(summary.contains("seen from outside"), "{summary}");
    let picture = folder.path().join("robot.png");
    assert_eq!(replay(&["--plot", picture.to_str().unwrap()]).1, Some(0));
    assert_eq!(replay(&["--at", "1"]).1, Some(0));
    let (why, status) = replay(&["--rerun"]);
    assert_eq!(status, Some(2), "{why}");
    assert!(why.contains("a recording of a robot elsewhere"), "{why}");
    assert_eq!(replay(&["--csv", "/cycle"]).1, Some(0));
    assert_eq!(replay(&["--find", "safety_mode != normal"]).1, Some(0));
    assert_eq!(replay(&["--script"]).1, Some(0));
    // Nothing the controller offers is left out: what a cycle has no place for is in topics of its own.
    assert!(text.contains(": 377 of 377 variables at 250 Hz"), "{text}");
    let (changes, _) = replay(&["--csv", "/io"]);
    assert!(
        changes.contains("output_integer_register[5],42"),
        "{changes}"
    );
    let column = |topic: &str, name: &str| -> Vec<f64> {
        let (table, status) = replay(&["--csv", topic]);
        assert_eq!(status, Some(0), "{table}");
        let mut lines = table.lines();
        let names: Vec<&str> = lines.next().unwrap().split(',').collect();
        let place = names.iter().position(|found| *found == name);
        let place = place.unwrap_or_else(|| panic!("{topic} has no {name}: {names:?}"));
        let cells = lines.map(|line| line.split(',').nth(place).unwrap().parse().unwrap());
        cells.collect()
    };
    let states = column("/rtsi", "runtime_state");
    assert_eq!(states.len(), read.cycles.len());
    assert!(states.contains(&1.0) && states.last() == Some(&3.0));
    let current = column("/rtsi", "actual_joint_current_1");
    assert!(current.iter().any(|amperes| amperes.abs() > 0.1));
    let volts = column("/robot_state", "tool.output_voltage");
    assert!(volts.len() > 20 && volts.last() == Some(&24.0), "{volts:?}");
    let kinds = column("/robot_state", "configuration.robot_type");
    assert!(kinds.iter().all(|kind| *kind == 6206.0));
    // Through the ports it is a robot again.
    let ready = folder.path().join("again.json");
    let played = eliteserver()
        .arg("replay")
        .arg(&out)
        .args([
            "--serve",
            "--primary-port=0",
            "--rtsi-port=0",
            "--http-port=0",
        ])
        .arg("--ready-file")
        .arg(&ready)
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let played = Server::adopt(played, &ready, folder.path());
    let again = folder.path().join("again.mcap");
    let recorded = eliteserver()
        .arg("record")
        .arg(format!("--primary-port={}", played.ports["primary"]))
        .arg(format!("--rtsi-port={}", played.ports["rtsi"]))
        .args(["--duration", "1", "--out"])
        .arg(&again)
        .output()
        .unwrap();
    let (text, status) = said(recorded);
    assert_eq!(status, Some(0), "{text}");
    assert!(common::read_recording(&again).cycles.len() > 50, "{text}");
    drop(played);
    // It is the same run as the server's own recording of it.
    let own = std::fs::read_dir(folder.path().join("recordings"))
        .unwrap()
        .flatten();
    let own = own.map(|entry| entry.path()).next().unwrap();
    drop(server);
    let compared = eliteserver()
        .arg("compare")
        .arg(&out)
        .arg(own)
        .args(["--within", "0.002"])
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&compared.stdout).into_owned();
    assert_eq!(compared.status.code(), Some(0), "{text}");
}

#[test]
fn a_robot_that_goes_away_and_comes_back_is_recorded_on() {
    let folder = tempfile::tempdir().unwrap();
    let first = Server::start(folder.path(), &["--record", "off"]);
    let ports = first.ports.clone();
    let out = folder.path().join("robot.mcap");
    let mut command = command(&first, "record");
    command.arg("--out").arg(&out).stderr(Stdio::piped());
    let recording = command.spawn().unwrap();
    std::thread::sleep(Duration::from_millis(900));
    first.terminate();
    std::thread::sleep(Duration::from_millis(500));
    let same = |name: &str| ports[name].to_string();
    let again = common::eliteserver()
        .args([
            "serve",
            "--record",
            "off",
            "--interpreter-port",
            "0",
            "--modbus-port",
            "0",
            "--http-port",
            "0",
        ])
        .args([
            "--primary-port",
            &same("primary"),
            "--rtsi-port",
            &same("rtsi"),
        ])
        .args(["--dashboard-port", &same("dashboard")])
        .current_dir(folder.path())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_millis(3500));
    send_signal(recording.id(), "INT");
    let (text, status) = said(recording.wait_with_output().unwrap());
    send_signal(again.id(), "TERM");
    let mut again = again;
    again.wait().unwrap();
    assert_eq!(status, Some(0), "{text}");
    assert!(text.contains(" 1 reconnects"), "{text}");
    let read = common::read_recording(&out);
    let times: Vec<f64> = read.cycles.iter().map(|cycle| cycle.time).collect();
    assert!(times.is_sorted_by(|a, b| a < b));
    assert!(times.last().unwrap() - times[0] > 3.0, "{times:?}");
    // Nobody there: a sentence.
    let nobody = eliteserver()
        .args(["record", "--primary-port=9", "--out", "/dev/null"])
        .output()
        .unwrap();
    let (text, status) = said(nobody);
    assert_eq!(status, Some(2), "{text}");
    assert!(
        text.contains("no connection to the robot at 127.0.0.1:9"),
        "{text}"
    );
}
