//! Wrong input of every kind gives one clear sentence, the right exit status, and loses nothing.

#![allow(clippy::unwrap_used, reason = "a test helper fails by panicking")]

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::Output;

use crate::common::{PATIENCE, Server, eliteserver, read_recording, run_script};

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The last line of stderr.
fn last_line(output: &Output) -> String {
    text(output)
        .trim_end()
        .lines()
        .last()
        .unwrap_or_default()
        .to_owned()
}

/// Runs a program and expects this exit status and a last line with these words.
#[track_caller]
fn expect(program: &str, options: &[&str], status: i32, words: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let output = run_script(folder.path(), program, options);
    assert_eq!(
        output.status.code(),
        Some(status),
        "{program}\n{}",
        text(&output)
    );
    let line = last_line(&output);
    for word in words {
        assert!(
            line.contains(word),
            "{program}: `{line}` lacks `{word}`\n{}",
            text(&output)
        );
    }
}

#[test]
fn a_program_that_does_not_compile_exits_with_2_and_shows_the_place() {
    let folder = tempfile::tempdir().unwrap();
    let output = run_script(folder.path(), "x = 1\ny = = 2\n", &[]);
    assert_eq!(output.status.code(), Some(2));
    let text = text(&output);
    assert!(
        text.contains("program.script:2:5") && text.contains("y = = 2"),
        "{text}"
    );
    assert!(
        text.contains("error[syntax]: expected an expression"),
        "{text}"
    );
}

#[test]
fn wrong_arguments_name_the_argument_what_was_given_and_what_is_allowed() {
    expect(
        "movej([0, 0, 0])",
        &[],
        1,
        &["ValueError", "q", "six joint positions", "3 numbers"],
    );
    expect(
        "movej([0, 0, 0, 0, 0, 'x'])",
        &[],
        1,
        &["TypeError", "q[5]", "str"],
    );
    expect(
        "movej([0, 0, 0, 0, 0, float('nan')])",
        &[],
        1,
        &["ValueError", "q[5]", "nan"],
    );
    expect(
        "movej([0]*6, a=-1)",
        &[],
        1,
        &["ValueError", "a must be a number > 0", "-1"],
    );
    expect(
        "movej([0]*6, v=0)",
        &[],
        1,
        &["ValueError", "v must be a number > 0", "got 0"],
    );
    expect("movej([0]*6, speed=1)", &[], 1, &["TypeError", "speed"]);
    expect("movej()", &[], 1, &["TypeError", "q"]);
    expect(
        "set_standard_digital_out(16, True)",
        &[],
        1,
        &["ValueError", "n must be -1 to 15", "16"],
    );
    expect(
        "set_payload(7, [0, 0, 0])",
        &[],
        1,
        &["ValueError", "0 to 6 kg", "7"],
    );
    expect(
        "set_tcp([0, 0])",
        &[],
        1,
        &["ValueError", "pose", "2 numbers"],
    );
    expect("join_thread(5)", &[], 1, &["ValueError", "thread_id 5"]);
    expect(
        "sleep('long')",
        &[],
        1,
        &["TypeError", "t must be a number", "str"],
    );
    expect(
        "movej([0]*6, r=-0.05)",
        &[],
        1,
        &["ValueError", "r must be a number >= 0", "-0.05"],
    );
}

#[test]
fn what_the_arm_cannot_do_is_refused_before_it_moves_and_can_be_caught() {
    expect(
        "movel([3, 0, 0.5, 0, 0, 0])",
        &[],
        1,
        &["RuntimeError", "out of reach"],
    );
    expect(
        "get_inverse_kin([3, 0, 0.5, 0, 0, 0])",
        &[],
        1,
        &["RuntimeError", "get_inverse_kin"],
    );
    expect(
        "movej([0, 0, 4, 0, 0, 0])",
        &[],
        1,
        &["RuntimeError", "joint 3", "4.0000", "3.14"],
    );
    let caught = "q = get_target_joint_positions()\n\
                  try:\n    movel([3, 0, 0.5, 0, 0, 0])\n\
                  except RuntimeError as e:\n    print('caught')\n\
                  print(q == get_target_joint_positions())\n";
    let folder = tempfile::tempdir().unwrap();
    let output = run_script(folder.path(), caught, &[]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
    assert_eq!(String::from_utf8_lossy(&output.stdout), "caught\nTrue\n");
}

#[test]
fn wrong_options_exit_with_2_and_say_what_is_allowed() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("p.script"), "pass\n").unwrap();
    std::fs::write(folder.path().join("typo.toml"), "stepms = 4\n").unwrap();
    std::fs::write(folder.path().join("cell.toml"), "[limits]\ntcp_sped = 1\n").unwrap();
    std::fs::write(folder.path().join("broken.urdf"), "<robot name='x'/>").unwrap();
    for (options, words) in [
        (&["--unknown"][..], &["--unknown"][..]),
        (&["--step-ms", "9"], &["--step-ms", "1 to 8"]),
        (&["--model", "cs99"], &["cs99", "cs612"]),
        (&["--model", "./broken.urdf"], &["broken.urdf"]),
        (&["--model", "./missing.urdf"], &["missing.urdf"]),
        (&["--home", "0,0,9,0,0,0"], &["joint 3", "9"]),
        (&["--payload", "50"], &["50", "6", "cs66"]),
        (&["--config", "typo.toml"], &["stepms", "step-ms"]),
        (&["--config", "missing.toml"], &["missing.toml"]),
        (&["--cell", "cell.toml"], &["tcp_sped", "tcp_speed"]),
    ] {
        let mut command = eliteserver();
        let output = command
            .arg("run")
            .arg("p.script")
            .args(options)
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert_eq!(
            output.status.code(),
            Some(2),
            "{options:?}: {}",
            text(&output)
        );
        for word in words {
            assert!(
                text(&output).contains(word),
                "{options:?}: {} lacks {word}",
                text(&output)
            );
        }
    }
}

#[test]
fn a_script_that_cannot_be_read_exits_with_2() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("latin1.script"), b"print('\xe9')\n").unwrap();
    for (name, word) in [
        ("missing.script", "missing.script"),
        ("latin1.script", "UTF-8"),
    ] {
        let output = eliteserver()
            .arg("run")
            .arg(name)
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2));
        assert!(text(&output).contains(word), "{}", text(&output));
    }
}

#[test]
fn a_port_in_use_is_named_with_its_option_and_leaves_no_recording() {
    let folder = tempfile::tempdir().unwrap();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    let output = eliteserver()
        .args([
            "serve",
            "--primary-port",
            &port,
            "--interpreter-port",
            "0",
            "--modbus-port",
            "0",
        ])
        .args([
            "--http-port",
            "0",
            "--rtsi-port",
            "0",
            "--dashboard-port",
            "0",
        ])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(
        text(&output).contains(&port) && text(&output).contains("--primary-port"),
        "{}",
        text(&output)
    );
    assert!(!folder.path().join("recordings").exists());
}

#[test]
fn a_full_disk_stops_the_recording_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let program = "movej([0.2, -1.5, 1.5, -1.5, -1.5, 0])\nsleep(5)\nprint('done')\n";
    let output = run_script(folder.path(), program, &["--record", "/dev/full"]);
    let stderr = text(&output);
    assert_eq!(
        String::from_utf8_lossy(&output.stdout),
        "done\n",
        "{stderr}"
    );
    assert!(
        stderr.contains("recording stopped") && stderr.contains("No space left"),
        "{stderr}"
    );
    assert_eq!(stderr.matches("No space left").count(), 1, "{stderr}");
}

#[test]
fn errors_of_programs_reach_the_client_and_the_server_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &["--record", "off"]);
    let mut client = server.primary();
    client.send("1abcd\n");
    let (line, column, message) = client.script_error();
    assert_eq!((line, column), (1, 1), "{message}");
    assert!(
        message
            .trim_end()
            .lines()
            .last()
            .unwrap()
            .starts_with("SyntaxError: "),
        "{message}"
    );

    client.send("def broken():\n  x = [1, 2]\n  textmsg(x[5])\nend\n");
    let (line, _, message) = client.script_error();
    assert_eq!(line, 3);
    assert!(message.contains("textmsg(x[5])"), "{message}");
    assert_eq!(
        message.trim_end().lines().last(),
        Some("IndexError: list index out of range")
    );

    // A second main program takes the place of the one that runs.
    client.send("def first():\n  sleep(30)\nend\n");
    client.wait_for("the first program runs", |s| s.task_running);
    client.send("def second():\n  set_standard_digital_out(2, True)\n  sleep(30)\nend\n");
    client.wait_for("the second program runs", |s| {
        s.task_running && s.digital_out == 0b100
    });
    client.send("stop task\n");
    client.wait_for("the program stops", |s| !s.task_running);
    client.send("set_standard_digital_out(3, True)\n");
    client.wait_for("a line is a program", |s| s.digital_out == 0b1100);
    assert_eq!(server.terminate().code(), Some(0));
}

#[test]
fn a_browser_is_turned_away() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &["--record", "off"]);
    for port in ["primary", "interpreter"] {
        let mut stream = TcpStream::connect(("127.0.0.1", server.ports[port])).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream
            .write_all(b"POST / HTTP/1.1\r\nHost: x\r\n\r\nset_standard_digital_out(0, True)\n")
            .unwrap();
        let mut rest = Vec::new();
        // Ends because the server closes; what came before are state messages.
        let _ = stream.read_to_end(&mut rest);
    }
    assert_eq!(server.primary().state().digital_out, 0);
}

#[test]
fn a_killed_server_leaves_a_readable_recording() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &["--record", "out.mcap"]);
    let mut client = server.primary();
    client.send("movej([0.2, -1.5, 1.5, -1.5, -1.5, 0])\n");
    client.wait_for("the arm moves", |s| s.task_running);
    client.wait_for("the arm stands", |s| !s.task_running);
    std::thread::sleep(std::time::Duration::from_millis(1100));
    server.kill();
    let output = eliteserver()
        .arg("replay")
        .arg("out.mcap")
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
    let summary = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        summary.contains("missing: 0") && summary.contains("programs: 1"),
        "{summary}"
    );
}

#[test]
fn a_recording_of_a_run_can_be_read_and_run_again() {
    let folder = tempfile::tempdir().unwrap();
    let output = run_script(
        folder.path(),
        "movej([0.2, -1.5, 1.5, -1.5, -1.5, 0])\n",
        &["--record", "a.mcap"],
    );
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
    let cycles = read_recording(&folder.path().join("a.mcap")).cycles.len();
    let output = eliteserver()
        .args(["replay", "a.mcap", "--rerun"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    let stdout = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(0), "{stdout}{}", text(&output));
    assert!(
        stdout.contains(&format!("identical: {cycles} cycles")),
        "{stdout}"
    );
}

/// A name may lead to a device that never ends; each of these files is read no further than it may be long.
#[test]
fn a_file_that_never_ends_is_refused_wherever_one_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("endless.urdf");
    std::os::unix::fs::symlink("/dev/zero", &path).unwrap();
    let endless = path.to_str().unwrap();
    let program = folder.path().join("p.script");
    std::fs::write(&program, "sync()\n").unwrap();
    let program = program.to_str().unwrap();
    let asked: [&[&str]; 7] = [
        &["run", "--cell", endless, program],
        &["run", "--model", endless, program],
        &["run", "--calibration", endless, program],
        &["run", endless],
        &["check", endless],
        &["serve", "--config", endless],
        &["fleet", endless],
    ];
    for arguments in asked {
        let output = eliteserver().args(arguments).output().unwrap();
        let told = text(&output);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
        assert!(told.contains("MiB"), "{arguments:?}: {told}");
    }
}
