//! What becomes of texts on port 30001 as clients of the field send them: cut off, with blanks, with a call behind a
//! block; and what a sender hears of a program that another one replaces.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::io::Write;
use std::net::TcpStream;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use crate::common::{Dashboard, FromPrimary, PATIENCE, Primary, Server, alone, eliteserver};

fn server(folder: &Path) -> Server {
    Server::start(folder, &["--record", "off"])
}

/// The next error that contains `part`.
fn told(primary: &mut Primary, part: &str) -> String {
    let begun = Instant::now();
    loop {
        assert!(begun.elapsed() < PATIENCE, "nothing says {part}");
        if let FromPrimary::ScriptError(_, _, text) = primary.next()
            && text.contains(part)
        {
            return text;
        }
    }
}

#[test]
fn a_line_with_unknown_names_does_not_end_the_block_before_it() {
    let folder = tempfile::tempdir().unwrap();
    let server = server(folder.path());
    let mut primary = server.primary();
    for (bit, line) in [
        (1, "f()"),
        (2, "f("),
        (3, "textmsg2(\"x\")"),
        (4, "popup_now(1, 2)"),
    ] {
        primary.send(&format!(
            "def f():\n  sleep(0.2)\n  set_standard_digital_out({bit}, True)\nend\n{line}\n"
        ));
        primary.wait_for(line, |state| state.digital_out >> bit & 1 == 1);
    }
    // Where nothing runs the line fails by itself.
    primary.wait_for("ended", |state| !state.task_running);
    primary.send("f()\n");
    told(&mut primary, "NameError");
    assert!(server.terminate().success());
}

#[test]
fn a_text_that_is_cut_off_inside_a_block_does_not_run() {
    let folder = tempfile::tempdir().unwrap();
    let server = server(folder.path());
    let mut watch = server.primary();
    let text = "def f():\n  set_standard_digital_out(1, True)\n  if True:\n    sleep(0)\n  end\n\
                \x20 set_standard_digital_out(2, True)\n";
    for resets in [false, true] {
        let mut cut = TcpStream::connect(("127.0.0.1", server.ports["primary"])).unwrap();
        cut.write_all(text.as_bytes()).unwrap();
        if resets {
            // What has come is read first; then the connection is reset.
            std::thread::sleep(Duration::from_millis(200));
            socket2::SockRef::from(&cut)
                .set_linger(Some(Duration::ZERO))
                .unwrap();
        }
        drop(cut);
        told(&mut watch, "cut off after line 6");
    }
    // Without any `end` the end of the connection is the end of the block.
    let mut whole = TcpStream::connect(("127.0.0.1", server.ports["primary"])).unwrap();
    whole
        .write_all(b"def f():\n  set_standard_digital_out(3, True)\n")
        .unwrap();
    drop(whole);
    let state = watch.wait_for("it runs", |state| state.digital_out != 0);
    assert_eq!(state.digital_out, 8);
    assert!(server.terminate().success());
}

#[test]
fn blanks_before_a_line_are_nothing_and_halt_ends_what_runs() {
    let folder = tempfile::tempdir().unwrap();
    let server = server(folder.path());
    let mut primary = server.primary();
    primary.send("   set_standard_digital_out(1, True)\n\t set_standard_digital_out(2, True)\r\n");
    primary.wait_for("both", |state| state.digital_out == 6);
    primary.send("def f():\n  while True:\n    sync()\n  end\nend\n");
    primary.wait_for("it runs", |state| state.task_running);
    primary.send("halt()\n");
    primary.wait_for("it ends", |state| !state.task_running);
    let log = std::fs::read_to_string(folder.path().join("stderr.log")).unwrap();
    assert!(!log.contains("takes its place"), "{log}");
    assert!(server.terminate().success());
}

/// An order of the dashboard is seen in the first state of a connection that is made after its reply.
#[test]
fn the_first_state_of_a_connection_is_that_of_its_moment() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let server = server(folder.path());
    let mut dashboard = Dashboard::connect(&server);
    server
        .primary()
        .send("def f():\n  while True:\n    sync()\n  end\nend\n");
    server
        .primary()
        .wait_for("it runs", |state| state.task_running);
    for round in 0..20 {
        let (order, reply) = match round % 2 {
            0 => ("pause", "Task is paused"),
            _ => ("play", "Task is running"),
        };
        dashboard.ask(order);
        let begun = Instant::now();
        while dashboard.ask("task -s") != reply {
            assert!(begun.elapsed() < PATIENCE, "{order}");
        }
        let state = server.primary().state();
        assert_eq!(state.task_paused, round % 2 == 0, "round {round}");
    }
    dashboard.ask("stop");
    assert!(server.terminate().success());
}

#[test]
fn the_sender_of_a_replaced_program_is_told_by_whom() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let server = server(folder.path());
    std::fs::write(
        folder.path().join("first.script"),
        "while True:\n    sync()\nend\n",
    )
    .unwrap();
    let sending = eliteserver()
        .args(["send", "first.script", "--primary-port"])
        .arg(server.ports["primary"].to_string())
        .arg("--rtsi-port")
        .arg(server.ports["rtsi"].to_string())
        .arg("--dashboard-port")
        .arg(server.ports["dashboard"].to_string())
        .current_dir(folder.path())
        .stderr(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let mut second = server.primary();
    second.wait_for("it runs", |state| state.task_running);
    second.send("def second():\n  while True:\n    sync()\n  end\nend\n");
    let sent = sending.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&sent.stderr);
    assert_eq!(sent.status.code(), Some(1), "{said}");
    assert!(
        said.contains("the program was stopped: program \"second\" from 127.0.0.1:"),
        "{said}"
    );
    // Its own sender hears nothing of that, and of its end by the next one that it sends nothing either.
    second.send("def third():\n  set_standard_digital_out(7, True)\nend\n");
    loop {
        match second.next() {
            FromPrimary::ScriptError(_, _, text) => panic!("{text}"),
            FromPrimary::State(state) if state.digital_out == 128 => break,
            _ => {}
        }
    }
    assert!(server.terminate().success());
}
