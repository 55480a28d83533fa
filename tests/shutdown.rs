//! SIGTERM and SIGINT end the process within two seconds in every state, with the recording closed wherever the disk
//! lets it; and standard error that is closed, full or unread costs log lines only.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "tests fail by panicking"
)]

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::common::{self, PATIENCE, Server, alone, eliteserver, read_recording, send_signal};

/// What the contract allows, and some for a machine that does other things as well.
const ALLOWED: Duration = Duration::from_millis(2300);

fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !is_so() {
        assert!(begin.elapsed() < PATIENCE, "{what}");
        thread::sleep(Duration::from_millis(5));
    }
}

fn order(folder: &Path, fault: &str) {
    let (beside, file) = (folder.join("faults.tmp"), folder.join("faults"));
    std::fs::write(&beside, format!("{fault}\n")).unwrap();
    std::fs::rename(beside, &file).unwrap();
    wait_until("the order is taken", || !file.exists());
}

/// A state of the server in which it is told to end.
struct State {
    name: &'static str,
    clock: &'static str,
    /// Faults before the program.
    orders: &'static [&'static str],
    program: &'static str,
    /// After it.
    orders_after: &'static [&'static str],
    status: i32,
}

const STATES: &[State] = &[
    State {
        name: "nothing runs",
        clock: "realtime",
        orders: &[],
        program: "",
        orders_after: &[],
        status: 0,
    },
    State {
        name: "a busy loop",
        clock: "realtime",
        orders: &[],
        program: "def f():\n while True:\n  pass\n end\nend\n",
        orders_after: &[],
        status: 0,
    },
    State {
        name: "a busy loop, virtual clock",
        clock: "virtual",
        orders: &[],
        program: "def f():\n while True:\n  pass\n end\nend\n",
        orders_after: &[],
        status: 0,
    },
    State {
        name: "a loop that will not be stopped",
        clock: "realtime",
        orders: &[],
        program: "def f():\n while True:\n  try:\n   sleep(10)\n  finally:\n   i = 0\n   while True:\n    i = i + 1\n\
                  \x20  end\n  end\n end\nend\n",
        orders_after: &[],
        status: 0,
    },
    State {
        name: "a wait for a name",
        clock: "realtime",
        orders: &["resolver hang"],
        program: "def f():\n socket_open('slow.invalid', 80)\n sleep(30)\nend\n",
        orders_after: &[],
        status: 0,
    },
    State {
        name: "a text that is being compiled",
        clock: "realtime",
        orders: &[],
        program: "",
        orders_after: &["compiler hang"],
        status: 0,
    },
    State {
        name: "a task that does not come back",
        clock: "realtime",
        orders: &["task hang"],
        program: "def f():\n sleep(30)\nend\n",
        orders_after: &[],
        status: 0,
    },
    State {
        name: "a task that has panicked",
        clock: "virtual",
        orders: &["task panic"],
        program: "def f():\n sleep(30)\nend\n",
        orders_after: &[],
        status: 0,
    },
    State {
        name: "a control cycle that does not come back",
        clock: "realtime",
        orders: &[],
        program: "def f():\n sleep(30)\nend\n",
        orders_after: &["motion hang"],
        status: 0,
    },
    State {
        name: "a control cycle that does not come back, virtual clock",
        clock: "virtual",
        orders: &[],
        program: "def f():\n while True:\n  sync()\n end\nend\n",
        orders_after: &["motion hang"],
        status: 0,
    },
    State {
        name: "a pump that does not come back",
        clock: "realtime",
        orders: &[],
        program: "def f():\n sleep(30)\nend\n",
        orders_after: &["pump hang"],
        status: 0,
    },
    State {
        name: "ports that do not come back",
        clock: "realtime",
        orders: &[],
        program: "def f():\n sleep(30)\nend\n",
        orders_after: &["dashboard hang"],
        status: 0,
    },
    State {
        name: "a log that does not come back",
        clock: "realtime",
        orders: &[],
        program: "def f():\n while True:\n  print('x')\n  sync()\n end\nend\n",
        orders_after: &["log hang"],
        status: 0,
    },
    State {
        name: "a disk that does not come back",
        clock: "realtime",
        orders: &[],
        program: "def f():\n while True:\n  print('x')\n  sync()\n end\nend\n",
        orders_after: &["disk hang"],
        status: 1,
    },
    State {
        name: "a disk that does not come back, virtual clock",
        clock: "virtual",
        orders: &[],
        program: "def f():\n while True:\n  print('x')\n  sync()\n end\nend\n",
        orders_after: &["disk hang"],
        status: 1,
    },
];

fn ends_in(state: &State, signal: &str) {
    let folder = tempfile::tempdir().unwrap();
    let options = [
        "--plant",
        "ideal",
        "--record",
        "out.mcap",
        "--clock",
        state.clock,
    ];
    let server = Server::start(folder.path(), &options);
    for fault in state.orders {
        order(folder.path(), fault);
    }
    let mut primary = server.primary();
    if !state.program.is_empty() {
        primary.send(state.program);
        thread::sleep(Duration::from_millis(300));
    }
    for fault in state.orders_after {
        if *fault == "compiler hang" {
            // It is taken by a text that comes.
            std::fs::write(folder.path().join("faults"), "compiler hang\n").unwrap();
            primary.send("def f():\n sleep(30)\nend\n");
            wait_until("it is taken", || !folder.path().join("faults").exists());
        } else {
            order(folder.path(), fault);
        }
    }
    // Both workers of the ports, and more.
    let _clients: Vec<TcpStream> = (0..4)
        .map(|_| TcpStream::connect(("127.0.0.1", server.ports["dashboard"])).unwrap())
        .collect();
    thread::sleep(Duration::from_millis(400));
    send_signal(server.process(), signal);
    let (status, after) = server.ended();
    println!("{}: {after:?} after SIG{signal}, {status}", state.name);
    assert!(after < ALLOWED, "{}: {after:?}", state.name);
    assert_eq!(status.code(), Some(state.status), "{}", state.name);
    let file = folder.path().join("out.mcap");
    if state.status == 0 {
        // Written to its end: the public reader finds no fault.
        assert!(!read_recording(&file).cycles.is_empty(), "{}", state.name);
    }
    assert!(!folder.path().join("ready.json").exists() || !state.orders_after.is_empty());
}

#[test]
fn sigterm_ends_a_server_within_two_seconds_in_every_state() {
    let _machine = alone();
    STATES.iter().for_each(|state| ends_in(state, "TERM"));
}

#[test]
fn sigterm_ends_a_recording_that_is_served() {
    let _machine = alone();
    let folder = tempfile::tempdir().unwrap();
    let output = common::run_script(folder.path(), "sleep(20)\n", &["--record", "a.mcap"]);
    assert!(output.status.success());
    let mut command = eliteserver();
    command.args(["replay", "a.mcap", "--serve", "--ready-file", "ready.json"]);
    for service in ["primary", "rtsi", "http"] {
        command.arg(format!("--{service}-port")).arg("0");
    }
    let log = std::fs::File::create(folder.path().join("stderr.log")).unwrap();
    let child = command.current_dir(&folder).stderr(log).spawn().unwrap();
    let ready = folder.path().join("ready.json");
    let server = Server::adopt(child, &ready, folder.path());
    let mut primary = server.primary();
    primary.state();
    send_signal(server.process(), "TERM");
    let (status, after) = server.ended();
    assert!(after < ALLOWED, "{after:?}");
    assert_eq!(status.code(), Some(0));
}

#[test]
fn sigterm_ends_a_server_whose_program_waits_for_a_child_that_is_held() {
    let _machine = alone();
    let folder = tempfile::tempdir().unwrap();
    let options = ["--plant", "ideal", "--record", "off", "--allow", "process"];
    let server = Server::start(folder.path(), &options);
    let mut primary = server.primary();
    primary.send(
        "def f():\n import subprocess\n subprocess.run(['sh', '-c', 'kill -STOP $$'])\nend\n",
    );
    wait_until("it runs", || server.health().1["task"] == "running");
    thread::sleep(Duration::from_millis(300));
    let children = || {
        let path = format!("/proc/{0}/task/{0}/children", server.process());
        std::fs::read_to_string(path).unwrap_or_default()
    };
    let of_any_thread = || {
        let tasks = std::fs::read_dir(format!("/proc/{}/task", server.process())).unwrap();
        tasks
            .filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("children")).ok())
            .collect::<String>()
    };
    let child = format!("{} {}", children(), of_any_thread());
    let child = child.split_whitespace().next().unwrap().to_owned();
    send_signal(server.process(), "TERM");
    let (status, after) = server.ended();
    assert!(after < ALLOWED, "{after:?}");
    assert_eq!(status.code(), Some(0));
    let gone = || !Path::new(&format!("/proc/{child}")).exists();
    wait_until("the child is gone", gone);
}

#[test]
fn a_signal_ends_a_wait_as_any_other_command() {
    let _machine = alone();
    use std::os::unix::process::ExitStatusExt as _;
    for (name, number) in [("TERM", 15), ("INT", 2)] {
        let mut child = eliteserver()
            .args(["wait", "--port", "9", "--timeout", "60"])
            .spawn()
            .unwrap();
        thread::sleep(Duration::from_millis(300));
        let begin = Instant::now();
        send_signal(child.id(), name);
        assert_eq!(child.wait().unwrap().signal(), Some(number));
        assert!(begin.elapsed() < ALLOWED);
    }
}

#[test]
fn a_file_that_may_not_grow_ends_the_recording_and_nothing_else() {
    let _machine = alone();
    for clock in ["realtime", "virtual"] {
        let folder = tempfile::tempdir().unwrap();
        let log = std::fs::File::create(folder.path().join("stderr.log")).unwrap();
        let ports: String = [
            "primary",
            "interpreter",
            "rtsi",
            "dashboard",
            "modbus",
            "http",
        ]
        .iter()
        .map(|port| format!(" --{port}-port 0"))
        .collect();
        let binary = env!("CARGO_BIN_EXE_eliteserver");
        // 64 blocks of 512 bytes or 1 KiB.
        let line = format!(
            "ulimit -f 64; exec {binary} serve --record out.mcap --plant ideal --clock {clock} --ready-file \
             ready.json{ports}"
        );
        let child = Command::new("sh")
            .args(["-c", &line])
            .current_dir(&folder)
            .env_remove("RUST_LOG")
            .stderr(log)
            .spawn()
            .unwrap();
        let ready = folder.path().join("ready.json");
        let server = Server::adopt(child, &ready, folder.path());
        let mut primary = server.primary();
        primary.send(
            "def f():\n while True:\n  movej([0.2, -1.5, 1.5, -1.5, -1.5, 0])\n\
                      \x20 movej([-0.2, -1.5, 1.5, -1.5, -1.5, 0])\n end\nend\n",
        );
        let begin = Instant::now();
        loop {
            if let common::FromPrimary::RobotError(code, _) = primary.next() {
                assert_eq!(code, 120);
                break;
            }
            assert!(begin.elapsed() < PATIENCE, "no alarm");
        }
        assert_eq!(server.health().1["recording"], "stopped");
        let cycle = server.health().1["cycle"].as_u64();
        wait_until("cycles go on", || {
            server.health().1["cycle"].as_u64() > cycle
        });
        thread::sleep(Duration::from_millis(500));
        let said = std::fs::read_to_string(folder.path().join("stderr.log")).unwrap();
        assert_eq!(said.matches("recording stopped").count(), 1, "{said}");
        assert_eq!(server.terminate().code(), Some(1));
    }
}

#[test]
fn sigint_ends_a_server_as_sigterm_does() {
    let _machine = alone();
    STATES[..2].iter().for_each(|state| ends_in(state, "INT"));
}

#[test]
fn stop_task_ends_a_wait_for_a_name_at_once() {
    let _machine = alone();
    for call in [
        "socket_open('slow.invalid', 80)",
        "rpc_factory('xmlrpc', 'http://slow.invalid:8080').m()",
        "import socket\n socket.socket().connect(('slow.invalid', 80))",
    ] {
        let folder = tempfile::tempdir().unwrap();
        let server = Server::start(folder.path(), &["--plant", "ideal", "--record", "off"]);
        order(folder.path(), "resolver hang");
        let mut primary = server.primary();
        primary.send(&format!("def f():\n {call}\n sleep(30)\nend\n"));
        wait_until("it runs", || server.health().1["task"] == "running");
        thread::sleep(Duration::from_millis(300));
        assert_eq!(server.health().1["task"], "running", "{call}");
        let begin = Instant::now();
        primary.send("stop task\n");
        wait_until("it stops", || server.health().1["task"] == "stopped");
        let after = begin.elapsed();
        assert!(after < Duration::from_millis(500), "{call}: {after:?}");
        assert_eq!(server.terminate().code(), Some(0));
    }
}

#[test]
fn standard_error_that_is_closed_or_unread_costs_lines_only() {
    let _machine = alone();
    for is_closed in [true, false] {
        let folder = tempfile::tempdir().unwrap();
        let (reader, writer) = std::io::pipe().unwrap();
        let options = [
            "--plant", "ideal", "--record", "out.mcap", "--clock", "virtual",
        ];
        let server = Server::start_with(folder.path(), &options, writer);
        let _unread = (!is_closed).then_some(reader);
        let mut primary = server.primary();
        // Several times what the pipe and the queue hold.
        primary.send(
            "def f():\n t = 'x' * 10000\n for i in range(2000):\n  print(t)\n end\n\
                      \x20set_standard_digital_out(3, True)\nend\n",
        );
        primary.wait_for("the program ends", |state| {
            state.digital_out & 8 != 0 && !state.task_running
        });
        // A warning in a session, and the port lives.
        for _ in 0..3 {
            let mut client = TcpStream::connect(("127.0.0.1", server.ports["dashboard"])).unwrap();
            client.set_read_timeout(Some(PATIENCE)).unwrap();
            client.write_all(b"GET / HTTP/1.1\r\n\r\n").unwrap();
            let _ = client.read(&mut [0; 100]);
        }
        let mut client = TcpStream::connect(("127.0.0.1", server.ports["dashboard"])).unwrap();
        client.set_read_timeout(Some(PATIENCE)).unwrap();
        assert!(client.read(&mut [0; 100]).unwrap() > 0, "it greets");
        let (_, page) = server.page("/metrics");
        let lost = page
            .lines()
            .find_map(|line| line.strip_prefix("elite_log_lines_lost_total "));
        assert!(lost.unwrap().parse::<u64>().unwrap() > 100, "{lost:?}");
        let begin = Instant::now();
        assert_eq!(server.terminate().code(), Some(0));
        assert!(begin.elapsed() < ALLOWED);
        assert!(
            !read_recording(&folder.path().join("out.mcap"))
                .cycles
                .is_empty()
        );
    }
}

#[test]
fn a_run_whose_output_nobody_reads_ends_by_a_signal_and_one_whose_reader_is_gone_goes_on() {
    let _machine = alone();
    let folder = tempfile::tempdir().unwrap();
    let script = folder.path().join("a.script");
    let mut loud = eliteserver();
    std::fs::write(&script, "while True:\n print('x' * 1000)\n sync()\n").unwrap();
    let (reader, writer) = std::io::pipe().unwrap();
    loud.arg("run").arg(&script).args(["--record", "out.mcap"]);
    let mut child = loud
        .current_dir(&folder)
        .stdout(writer)
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    drop(loud);
    thread::sleep(Duration::from_millis(700));
    let begin = Instant::now();
    send_signal(child.id(), "TERM");
    assert_eq!(child.wait().unwrap().code(), Some(1));
    assert!(begin.elapsed() < ALLOWED, "{:?}", begin.elapsed());
    read_recording(&folder.path().join("out.mcap"));
    drop(reader);

    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    std::fs::write(&script, "for i in range(5000):\n print('x' * 1000)\n").unwrap();
    let status = eliteserver()
        .arg("run")
        .arg(&script)
        .stdout(writer)
        .stderr(Stdio::null())
        .status();
    assert_eq!(status.unwrap().code(), Some(0));
}

#[test]
fn a_signal_during_the_start_ends_the_process() {
    let _machine = alone();
    let folder = tempfile::tempdir().unwrap();
    // A model that never comes.
    let fifo = folder.path().join("arm.urdf");
    assert!(
        Command::new("mkfifo")
            .arg(&fifo)
            .status()
            .unwrap()
            .success()
    );
    let mut child = eliteserver()
        .args(["serve", "--record", "off", "--model"])
        .arg(&fifo)
        .current_dir(&folder)
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    thread::sleep(Duration::from_millis(300));
    let begin = Instant::now();
    send_signal(child.id(), "TERM");
    child.wait().unwrap();
    assert!(begin.elapsed() < ALLOWED, "{:?}", begin.elapsed());
}

#[test]
fn answers_whose_reader_has_seen_enough_are_no_fault() {
    let _machine = alone();
    for arguments in [
        &["builtins"][..],
        &["builtins", "--format", "json"],
        &["--help"],
    ] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = eliteserver()
            .args(arguments)
            .stdout(writer)
            .stderr(Stdio::piped())
            .output()
            .unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(
            (output.status.code(), said.as_str()),
            (Some(0), ""),
            "{arguments:?}"
        );
    }
}

#[test]
fn a_ready_file_of_an_earlier_server_is_gone_before_the_ports_open_and_after_the_end() {
    let _machine = alone();
    let folder = tempfile::tempdir().unwrap();
    let ready = folder.path().join("ready.json");
    std::fs::write(&ready, "{\"pid\": 1}").unwrap();
    // The port is taken, so the server does not start: the stale file must be gone all the same.
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    let output = eliteserver()
        .args([
            "serve",
            "--record",
            "off",
            "--primary-port",
            &port,
            "--ready-file",
        ])
        .arg(&ready)
        .current_dir(&folder)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(!ready.exists());
    let server = Server::start(folder.path(), &["--record", "off"]);
    assert!(ready.exists());
    assert_eq!(server.terminate().code(), Some(0));
    assert!(!ready.exists());
}
