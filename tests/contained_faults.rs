//! Faults of ours are contained: a panic in each kind of thread of a running server takes down what it must, and no
//! more.
//!
//! The panics are raised on demand (`supervision::injection`), over real sockets everything else.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "tests fail by panicking"
)]

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::Stdio;
use std::thread;
use std::time::{Duration, Instant};

use crate::common::{
    FromPrimary, PATIENCE, Primary, Server, alone, eliteserver, read_recording, run_script,
};

/// A program that moves until it is stopped, about to and fro.
const WAVE: &str = "def wave():\n while True:\n  movej([0.5, -1.5708, 1.5708, -1.5708, -1.5708, 0], a=3, v=2)\n\
                    \x20 movej([-0.5, -1.5708, 1.5708, -1.5708, -1.5708, 0], a=3, v=2)\n end\nend\n";
const SETS_OUTPUT: &str = "def next():\n set_standard_digital_out(3, True)\nend\n";
const REAL: [&str; 4] = ["--plant", "ideal", "--record", "out.mcap"];
const VIRTUAL: [&str; 6] = [
    "--plant", "ideal", "--record", "out.mcap", "--clock", "virtual",
];

/// Orders a fault and waits until the order has been taken.
fn order(folder: &Path, fault: &str) {
    let (beside, file) = (folder.join("faults.tmp"), folder.join("faults"));
    std::fs::write(&beside, format!("{fault}\n")).unwrap();
    std::fs::rename(beside, &file).unwrap();
    wait_until("the order is taken", || !file.exists());
}

fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !is_so() {
        assert!(begin.elapsed() < PATIENCE, "{what}");
        thread::sleep(Duration::from_millis(5));
    }
}

fn robot_error(primary: &mut Primary) -> i32 {
    let begin = Instant::now();
    loop {
        if let FromPrimary::RobotError(code, _) = primary.next() {
            return code;
        }
        assert!(begin.elapsed() < PATIENCE, "no error");
    }
}

/// The server runs a program that does something to be seen.
fn next_program_runs(server: &Server) {
    let mut primary = server.primary();
    primary.send(SETS_OUTPUT);
    primary.wait_for("the next program runs", |state| state.digital_out & 8 != 0);
}

#[test]
fn a_panic_in_a_task_ends_the_program_with_an_internal_error_and_the_next_one_runs() {
    let _machine = alone();
    for options in [&REAL[..], &VIRTUAL[..]] {
        let folder = tempfile::tempdir().unwrap();
        let server = Server::start(folder.path(), options);
        let (mut sender, mut other) = (server.primary(), server.primary());
        sender.send(WAVE);
        other.wait_for("it moves", |state| state.target_q[0] > 0.1);
        order(folder.path(), "task panic");
        for client in [&mut sender, &mut other] {
            let (_, _, text) = client.script_error();
            assert!(
                text.contains("InternalError: ") && text.contains("on demand"),
                "{text}"
            );
        }
        let stopped = other.wait_for("it stands", |state| !state.task_running);
        let stands = other.wait_for("at rest", |state| state.target_q == state.actual_q);
        assert!((stopped.target_q[0] - stands.target_q[0]).abs() < 0.5);
        assert_eq!(server.health().1["task"], "stopped");
        next_program_runs(&server);
        let (_, page) = server.page("/metrics");
        assert!(
            page.contains("elite_faults_total{kind=\"task\"} 1"),
            "{page}"
        );
        assert_eq!(server.terminate().code(), Some(0));
        assert!(
            !read_recording(&folder.path().join("out.mcap"))
                .cycles
                .is_empty()
        );
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_native_stack_that_overflows_ends_its_program_and_the_next_one_runs() {
    let _machine = alone();
    let in_generator = "def gone():\n def walk():\n  try:\n   yield get_actual_joint_positions()\n  finally:\n\
                        \x20  textmsg(\"never\")\n  end\n end\n while True:\n  list(walk())\n  sync()\n end\nend\n";
    for program in [WAVE, in_generator] {
        let folder = tempfile::tempdir().unwrap();
        let server = Server::start(folder.path(), &REAL);
        let (mut sender, mut other) = (server.primary(), server.primary());
        sender.send(program);
        other.wait_for("it runs", |state| state.task_running);
        order(folder.path(), "builtin overflow");
        for client in [&mut sender, &mut other] {
            let (_, _, text) = client.script_error();
            assert!(
                text.contains("InternalError: a native stack of script thread"),
                "{text}"
            );
        }
        other.wait_for("it stands", |state| !state.task_running);
        next_program_runs(&server);
        let (_, page) = server.page("/metrics");
        assert!(
            page.contains("elite_faults_total{kind=\"task\"} 1"),
            "{page}"
        );
        assert_eq!(server.terminate().code(), Some(0));
        assert!(
            !read_recording(&folder.path().join("out.mcap"))
                .cycles
                .is_empty()
        );
    }
}

#[test]
fn a_program_of_run_that_meets_a_fault_fails() {
    let _machine = alone();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("faults"), "task panic\n").unwrap();
    let output = eliteserver()
        .args(["run", "-", "--record", "out.mcap"])
        .env(
            supervision::injection::VARIABLE,
            folder.path().join("faults"),
        )
        .current_dir(folder.path())
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("InternalError: a fault on demand in task"),
        "{said}"
    );
    read_recording(&folder.path().join("out.mcap"));
}

#[test]
fn a_panic_in_a_session_ends_that_connection_only() {
    let _machine = alone();
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &REAL);
    for port in [
        "primary",
        "interpreter",
        "rtsi",
        "dashboard",
        "modbus",
        "http",
    ] {
        let connect = || {
            let stream = TcpStream::connect(("127.0.0.1", server.ports[port])).unwrap();
            stream.set_read_timeout(Some(PATIENCE)).unwrap();
            stream
        };
        let mut before = connect();
        thread::sleep(Duration::from_millis(50));
        order(folder.path(), &format!("{port} panic"));
        let mut unlucky = connect();
        // The connection ends, whatever it was sent before.
        let mut rest = Vec::new();
        let _ = unlucky.read_to_end(&mut rest);
        for stream in [&mut before, &mut connect()] {
            stream
                .set_read_timeout(Some(Duration::from_millis(300)))
                .unwrap();
            let is_open = match stream.read(&mut [0; 16]) {
                Ok(count) => count > 0,
                Err(error) => error.kind() == std::io::ErrorKind::WouldBlock,
            };
            assert!(is_open, "{port} lives on");
        }
    }
    let (_, page) = server.page("/metrics");
    assert!(
        page.contains("elite_faults_total{kind=\"port\"} 6"),
        "{page}"
    );
    next_program_runs(&server);
    assert_eq!(server.terminate().code(), Some(0));
}

#[test]
fn services_that_panic_are_begun_again() {
    let _machine = alone();
    for (options, services) in [
        (&REAL[..], &["pump", "log"][..]),
        (&VIRTUAL[..], &["pump", "idle-pace", "log"][..]),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let logs = [options, &["--log-dir", "logs"]].concat();
        let server = Server::start(folder.path(), &logs);
        for service in services {
            order(folder.path(), &format!("{service} panic"));
            next_program_runs(&server);
            let cycle = server.health().1["cycle"].as_u64();
            wait_until("cycles go on", || {
                server.health().1["cycle"].as_u64() > cycle
            });
        }
        order(folder.path(), "interpreter-log panic");
        let mut primary = server.primary();
        primary.send("def mode():\n interpreter_mode()\nend\n");
        primary.wait_for("it runs", |state| state.task_running);
        let mut client = TcpStream::connect(("127.0.0.1", server.ports["interpreter"])).unwrap();
        let log = folder.path().join("logs/interpreter.log");
        wait_until("statements are in the log", || {
            client.write_all(b"a = 1\n").unwrap();
            std::fs::read_to_string(&log)
                .unwrap_or_default()
                .contains("a = 1")
        });
        wait_until("the fault is told", || {
            server
                .page("/metrics")
                .1
                .contains("elite_faults_total{kind=\"service\"} 2")
                || server
                    .page("/metrics")
                    .1
                    .contains("elite_faults_total{kind=\"service\"} 3")
        });
        assert_eq!(server.terminate().code(), Some(0));
    }
}

/// A Modbus device that answers every read with the number of its connection; returns its port.
fn modbus_device() -> u16 {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    thread::spawn(move || {
        for stream in listener.incoming() {
            let mut stream = stream.unwrap();
            thread::spawn(move || {
                let mut request = [0; 12];
                while stream.read_exact(&mut request).is_ok() {
                    // Holding registers, one of them: 7.
                    let head = [request[0], request[1], 0, 0, 0, 5, request[6], request[7]];
                    let answer = [&head[..], &[2, 0, 7]].concat();
                    if stream.write_all(&answer).is_err() {
                        return;
                    }
                }
            });
        }
    });
    port
}

#[test]
fn a_panic_of_a_field_bus_costs_one_exchange_and_the_robot_goes_on() {
    let _machine = alone();
    let folder = tempfile::tempdir().unwrap();
    let port = modbus_device();
    // The line leads to a device that sends back what it gets.
    let echo = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let line = echo.local_addr().unwrap().port();
    thread::spawn(move || {
        for stream in echo.incoming() {
            let mut stream = stream.unwrap();
            thread::spawn(move || {
                let mut out = stream.try_clone().unwrap();
                let _ = std::io::copy(&mut stream, &mut out);
            });
        }
    });
    let cell = format!("[[serial]]\nport = \"tool\"\ndevice = \"tcp:127.0.0.1:{line}\"\n");
    std::fs::write(folder.path().join("cell.toml"), cell).unwrap();
    let options = [&REAL[..], &["--cell", "cell.toml"]].concat();
    let server = Server::start(folder.path(), &options);
    std::fs::write(folder.path().join("faults"), "modbus panic\n").unwrap();
    let mut primary = server.primary();
    primary.send(&format!(
        "def field():\n modbus_add_signal('127.0.0.1', 255, 0, 3, 's', False, 1, {port})\n while True:\n  try:\n\
         \x20  set_standard_digital_out(4, modbus_get_signal_status('s') == [7] or modbus_get_signal_status('s') == \
         7)\n  except Exception as e:\n   textmsg('no value: ', str(e))\n  end\n  sleep(0.02)\n end\nend\n"
    ));
    primary.wait_for("values come after the fault", |state| {
        state.digital_out & 16 != 0
    });
    assert!(!folder.path().join("faults").exists(), "it was taken");
    primary.send("stop task\n");
    primary.wait_for("it ends", |state| !state.task_running);

    std::fs::write(folder.path().join("faults"), "serial panic\n").unwrap();
    primary.send(
        "def line():\n for i in range(100):\n  tool_serial_config(True, 9600, 2, 2)\n  tool_serial_write([97, 98])\n\
         \x20 if tool_serial_read(2, True, 0.5) == [97, 98]:\n   set_standard_digital_out(5, True)\n  end\n\
         \x20 sleep(0.02)\n end\nend\n",
    );
    primary.wait_for("the line works after the fault", |state| {
        state.digital_out & 32 != 0
    });
    assert!(!folder.path().join("faults").exists(), "it was taken");
    let (_, page) = server.page("/metrics");
    assert!(
        page.contains("elite_faults_total{kind=\"service\"} 2"),
        "{page}"
    );
    next_program_runs(&server);
    assert_eq!(server.terminate().code(), Some(0));
}

#[test]
fn a_panic_in_the_recorder_is_an_alarm_and_the_robot_goes_on() {
    let _machine = alone();
    for options in [&REAL[..], &VIRTUAL[..]] {
        let folder = tempfile::tempdir().unwrap();
        let server = Server::start(folder.path(), options);
        let mut primary = server.primary();
        primary.send(WAVE);
        primary.wait_for("it moves", |state| state.target_q[0] > 0.1);
        order(folder.path(), "recorder panic");
        assert_eq!(robot_error(&mut primary), 120);
        let (status, health) = server.health();
        assert_eq!((status, &health["recording"]), (200, &"stopped".into()));
        primary.wait_for("it goes on", |state| state.target_q[0] < -0.1);
        primary.send("stop task\n");
        primary.wait_for("it stops", |state| !state.task_running);
        next_program_runs(&server);
        assert_eq!(
            server.terminate().code(),
            Some(1),
            "not everything was flushed"
        );
        read_recording(&folder.path().join("out.mcap"));
    }
}

#[test]
fn a_panic_in_the_control_cycle_is_told_to_everybody_and_ends_the_process() {
    let _machine = alone();
    for (options, runs) in [(&REAL[..], true), (&VIRTUAL[..], true), (&REAL[..], false)] {
        let folder = tempfile::tempdir().unwrap();
        let server = Server::start(folder.path(), options);
        let (mut sender, mut other) = (server.primary(), server.primary());
        if runs {
            sender.send(WAVE);
            other.wait_for("it moves", |state| state.target_q[0] > 0.1);
        }
        order(folder.path(), "motion panic");
        assert_eq!(robot_error(&mut sender), 130);
        let (status, health) = server.health();
        assert_eq!(status, 503, "{health}");
        let why = health["fault"].as_str().unwrap();
        assert!(why.contains("on demand in motion"), "{why}");
        if runs {
            let (_, _, text) = other.script_error();
            assert!(text.contains("InternalError: "), "{text}");
            wait_until("the task ends", || server.health().1["task"] == "stopped");
        }
        let (status, after) = server.ended();
        assert_eq!(status.code(), Some(3));
        assert!(after < Duration::from_secs(3), "{after:?}");
        // Written to its end: the public reader finds no fault.
        assert!(
            !read_recording(&folder.path().join("out.mcap"))
                .cycles
                .is_empty()
        );
    }
}

#[test]
fn a_panic_in_the_control_cycle_of_run_is_status_3() {
    let _machine = alone();
    let folder = tempfile::tempdir().unwrap();
    let script = folder.path().join("a.script");
    std::fs::write(&script, "sleep(1)\nprint('never')\n").unwrap();
    for clock in ["virtual", "realtime"] {
        std::fs::write(folder.path().join("faults"), "motion panic\n").unwrap();
        let output = eliteserver()
            .args(["run", "a.script", "--record", "out.mcap", "--clock", clock])
            .env(
                supervision::injection::VARIABLE,
                folder.path().join("faults"),
            )
            .current_dir(folder.path())
            .stdin(Stdio::null())
            .output()
            .unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(3), "{said}");
        assert!(
            output.stdout.is_empty() && said.contains("on demand in motion"),
            "{said}"
        );
        read_recording(&folder.path().join("out.mcap"));
    }
    let output = run_script(folder.path(), "print('well')\n", &[]);
    assert_eq!(output.stdout, b"well\n");
}
