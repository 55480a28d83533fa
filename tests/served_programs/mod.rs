//! Programs that a server has run: repeated from its recording, script and all, and debugged while they run.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "test helpers fail by panicking"
)]

mod peers;

use std::io::{BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Duration;

use crate::common::{self, Server, eliteserver};
use editor::dap::stream::{self, DapInput};
use serde_json::{Value as Json, json};

/// A debugger, and what its client has heard.
struct Debugger {
    child: Child,
    from: BufReader<ChildStdout>,
    to: Option<ChildStdin>,
    seq: i64,
    events: Vec<Json>,
}

impl Debugger {
    fn new() -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_eliteserver"))
            .arg("debug")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        Self {
            from: BufReader::new(child.stdout.take().unwrap()),
            to: child.stdin.take(),
            child,
            seq: 0,
            events: Vec::new(),
        }
    }

    /// Opens the program of a recording at its end.
    fn at_the_end(recording: &Path) -> Self {
        let mut own = Self::new();
        own.ask("initialize", json!({})).unwrap();
        own.ask("configurationDone", json!({})).unwrap();
        let arguments = json!({"recording": recording, "stopAtEnd": true});
        own.ask("launch", arguments).unwrap();
        let end = own.event("stopped");
        assert_eq!(
            end["description"], "the end of the program",
            "{:?}",
            own.events
        );
        own
    }

    fn next(&mut self) -> Json {
        match stream::read(&mut self.from).unwrap() {
            Some(DapInput::Message(message)) => message,
            other => panic!("the debugger says {other:?}"),
        }
    }

    fn ask(&mut self, command: &str, arguments: Json) -> Result<Json, String> {
        self.seq += 1;
        let message =
            json!({"seq": self.seq, "type": "request", "command": command, "arguments": arguments});
        stream::write(self.to.as_mut().unwrap(), &message).unwrap();
        loop {
            let message = self.next();
            if message["type"] == "response" && message["request_seq"] == self.seq {
                return match message["success"] == true {
                    true => Ok(message["body"].clone()),
                    false => Err(message["message"].as_str().unwrap().to_owned()),
                };
            }
            self.events.push(message);
        }
    }

    /// The next event of this name, those of others are kept.
    fn event(&mut self, name: &str) -> Json {
        loop {
            if let Some(index) = self.events.iter().position(|event| event["event"] == name) {
                return self.events.remove(index)["body"].clone();
            }
            let message = self.next();
            self.events.push(message);
        }
    }

    fn evaluate(&mut self, text: &str) -> String {
        let arguments = json!({"expression": text, "context": "hover"});
        let body = self.ask("evaluate", arguments).unwrap();
        body["result"].as_str().unwrap().to_owned()
    }

    fn line(&mut self) -> u64 {
        let body = self.ask("stackTrace", json!({"threadId": 1})).unwrap();
        body["stackFrames"][0]["line"].as_u64().unwrap()
    }

    fn end(mut self) {
        drop(self.to.take());
        assert!(self.child.wait().unwrap().success());
    }
}

impl Drop for Debugger {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// An order of the page; the answer's status line.
fn order(server: &Server, order: &Json) -> String {
    let session: Json = serde_json::from_str(&server.page("/api/v1/session").1).unwrap();
    let (token, body) = (session["token"].as_str().unwrap(), order.to_string());
    let mut stream = TcpStream::connect(("127.0.0.1", server.ports["http"])).unwrap();
    write!(
        stream,
        "POST /api/v1/orders HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {token}\r\n\
         Content-Type: application/json\r\nConnection: close\r\nContent-Length: {}\r\n\r\n{body}",
        body.len()
    )
    .unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer.lines().next().unwrap_or_default().to_owned()
}

fn run(server: &Server, name: &str, text: &str) {
    let said = order(server, &json!({"do": "run", "name": name, "text": text}));
    assert!(said.contains("200"), "{said}");
}

fn program_state(server: &Server) -> String {
    let state: Json = serde_json::from_str(&server.page("/api/v1/state").1).unwrap();
    state["program_state"]
        .as_str()
        .unwrap()
        .to_ascii_lowercase()
}

fn wait_for(what: &str, holds: impl Fn() -> bool) {
    let started = std::time::Instant::now();
    while !holds() {
        assert!(started.elapsed() < common::PATIENCE, "{what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// A machine that says three numbers, each after a while.
fn machine() -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        for answer in ["1\n", "2.5\n", "-0.7\n"] {
            std::thread::sleep(Duration::from_millis(137));
            stream.write_all(answer.as_bytes()).unwrap();
        }
        std::thread::sleep(Duration::from_secs(1));
    });
    port
}

fn served(folder: &Path, clock: &str) {
    let server = Server::start(
        folder,
        &[
            "--clock",
            clock,
            "--plant",
            "ideal",
            "--record",
            "served.mcap",
        ],
    );
    let port = machine();
    // Under the real clock time passes while a program computes.
    let between = match clock {
        "virtual" => "sync()",
        _ => "pass",
    };
    let text = format!(
        "def told():\n  import time\n  q = [0, -1.57, 1.57, -1.57, -1.57, 0]\n  \
         heard = socket_open('127.0.0.1', {port}, 'machine')\n  n = 0\n  while n < 3:\n    \
         line = socket_read_string('machine', '', '\\n', 5)\n    n = n + 1\n    q[0] = 0.1 * to_num(line)\n    \
         movej(q, a=3, v=2)\n    k = 0\n    while k < 3000:\n      k = k + 1\n    end\n  end\n  \
         register = 0\n  while register == 0:\n    {between}\n    register = read_input_integer_register(3)\n  end\n  \
         set_standard_digital_out(int(time.time()) % 8, True)\n  q[0] = 0.01 * register\n  movej(q, a=3, v=2)\nend\n"
    );
    run(&server, "told.script", &text);
    std::thread::sleep(Duration::from_millis(150));
    order(&server, &json!({"do": "pause"}));
    std::thread::sleep(Duration::from_millis(100));
    order(&server, &json!({"do": "play"}));
    order(&server, &json!({"do": "speed", "fraction": 0.7}));
    std::thread::sleep(Duration::from_millis(700));
    let inputs = json!({"do": "inputs", "values": {"input_integer_register[3]": 7}});
    wait_for("the register is taken", || {
        order(&server, &inputs).contains("200")
    });
    wait_for("the program ends", || program_state(&server) == "stopped");
    // A program that is ended by another, and one that a port stops.
    run(
        &server,
        "first.script",
        "def first():\n  while True:\n    sync()\n  end\nend\n",
    );
    run(
        &server,
        "second.script",
        "def second():\n  movej([0.5, -1.2, 1.2, -1.57, -1.57, 0], v=0.3)\nend\n",
    );
    std::thread::sleep(Duration::from_millis(200));
    order(&server, &json!({"do": "stop"}));
    wait_for("the program ends", || program_state(&server) == "stopped");
    assert!(server.terminate().success());
}

/// Runs the recording again, on another machine as far as files tell.
fn rerun(folder: &Path) -> String {
    let elsewhere = tempfile::tempdir().unwrap();
    let output = eliteserver()
        .args(["replay", "--rerun"])
        .arg(folder.join("served.mcap"))
        .current_dir(elsewhere.path())
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn what_a_server_recorded_under_the_real_clock_runs_again_script_and_all_and_is_walked_back() {
    let folder = tempfile::tempdir().unwrap();
    served(folder.path(), "realtime");
    assert!(rerun(folder.path()).contains("identical: 3 programs"));

    let recording = folder.path().join("served.mcap");
    let mut debugger = Debugger::at_the_end(&recording);
    debugger
        .ask("reverseContinue", json!({"threadId": 1}))
        .unwrap();
    debugger.event("stopped");
    let arguments = json!({"source": {"path": "told.script"}, "breakpoints": [{"line": 10, "condition": "n == 3"}]});
    let bound = debugger.ask("setBreakpoints", arguments).unwrap();
    assert_eq!(bound["breakpoints"][0]["verified"], true, "{bound}");
    debugger.ask("continue", json!({"threadId": 1})).unwrap();
    assert_eq!(debugger.event("stopped")["reason"], "breakpoint");
    assert_eq!(
        debugger.evaluate("[n, line, q[0]]"),
        "[3, '-0.7', -0.06999999999999999]"
    );
    debugger.ask("stepBack", json!({"threadId": 1})).unwrap();
    debugger.event("stopped");
    assert_eq!(debugger.line(), 9);
    assert_eq!(debugger.evaluate("q[0]"), "0.25");
    let mut another = Debugger::new();
    another.ask("initialize", json!({})).unwrap();
    let missing = another.ask("launch", json!({"recording": recording, "number": 9}));
    assert!(missing.unwrap_err().contains("there is no program 9"));
    debugger.end();
}

#[test]
fn what_a_server_recorded_under_the_virtual_clock_runs_again_script_and_all() {
    let folder = tempfile::tempdir().unwrap();
    served(folder.path(), "virtual");
    assert!(rerun(folder.path()).contains("identical: 3 programs"));
}

/// Editors set their breakpoints as soon as the session has begun, which may be before they attach.
#[test]
fn breakpoints_of_every_kind_that_came_before_attach_hold_there() {
    for (command, arguments, reason) in [
        (
            "setFunctionBreakpoints",
            json!({"breakpoints": [{"name": "part"}]}),
            "function breakpoint",
        ),
        (
            "setExceptionBreakpoints",
            json!({"filters": ["caught"]}),
            "exception",
        ),
        (
            "setDataBreakpoints",
            json!({"breakpoints": [{"dataId": "line == 3"}]}),
            "data breakpoint",
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let options = ["--plant", "ideal", "--record", "off"];
        let server = Server::start(folder.path(), &options);
        let mut driver = Debugger::new();
        driver.ask("initialize", json!({})).unwrap();
        driver.ask(command, arguments).unwrap();
        let attach = json!({"http-port": server.ports["http"], "drive": true});
        driver.ask("attach", attach).unwrap();
        let text = "def held():\n  def part(n):\n    sleep(0.1)\n    return 1 / n\n  end\n  part(0)\nend\n";
        run(&server, "held.script", text);
        assert_eq!(driver.event("stopped")["reason"], reason, "{command}");
    }
}

#[test]
fn a_debugger_drives_a_program_of_a_running_server_another_looks_on_and_ports_are_heard() {
    let folder = tempfile::tempdir().unwrap();
    let options = ["--plant", "ideal", "--record", "off"];
    let server = Server::start(folder.path(), &options);
    let endless = "def endless():\n  n = 0\n  while True:\n    n = n + 1\n    sync()\n  end\nend\n";
    run(&server, "early.script", endless);

    let attach = |drive: bool| json!({"http-port": server.ports["http"], "drive": drive});
    let mut driver = Debugger::new();
    driver.ask("initialize", json!({})).unwrap();
    let refused = driver
        .ask("attach", json!({"http-port": 70000}))
        .unwrap_err();
    assert!(refused.contains("http-port is 70000"), "{refused}");
    driver.ask("attach", attach(true)).unwrap();
    // It had begun before anybody attached.
    let refused = driver.ask("pause", json!({"threadId": 1})).unwrap_err();
    assert!(refused.contains("before anybody attached"), "{refused}");
    let arguments = json!({"source": {"path": "/mine/late.script"}, "breakpoints": [{"line": 4,
        "condition": "n == 100"}]});
    driver.ask("setBreakpoints", arguments).unwrap();
    let mut other = Debugger::new();
    other.ask("initialize", json!({})).unwrap();
    assert!(
        other
            .ask("attach", attach(true))
            .unwrap_err()
            .contains("drives already")
    );
    let mut other = Debugger::new();
    other.ask("initialize", json!({})).unwrap();
    other.ask("attach", attach(false)).unwrap();

    run(&server, "late.script", endless);
    assert_eq!(driver.event("stopped")["reason"], "breakpoint");
    assert_eq!(other.event("stopped")["reason"], "breakpoint");
    assert_eq!(driver.line(), 4);
    assert_eq!(driver.evaluate("n"), "100");
    let stack = other.ask("stackTrace", json!({"threadId": 1})).unwrap();
    let frame = &stack["stackFrames"][0]["id"];
    let scopes = other.ask("scopes", json!({ "frameId": frame })).unwrap();
    let reference = scopes["scopes"][0]["variablesReference"].clone();
    let variables = other
        .ask("variables", json!({"variablesReference": reference}))
        .unwrap();
    assert_eq!(variables["variables"][0]["value"], "100", "{variables}");
    assert!(
        other
            .ask("continue", json!({"threadId": 1}))
            .unwrap_err()
            .contains("only looks on")
    );
    assert!(
        driver
            .ask("stepBack", json!({"threadId": 1}))
            .unwrap_err()
            .contains("forward only")
    );
    wait_for("held is paused", || program_state(&server) == "paused");
    let shown: Json = serde_json::from_str(&server.page("/api/v1/debug").1).unwrap();
    assert_eq!(shown["held"]["line"], 4, "{shown}");
    assert_eq!(
        (&shown["driver"], &shown["watchers"]),
        (&json!(true), &json!(1))
    );
    assert_eq!(shown["breakpoints"][0]["condition"], "n == 100", "{shown}");

    driver.ask("next", json!({"threadId": 1})).unwrap();
    assert_eq!(driver.event("stopped")["reason"], "step");
    assert_eq!((driver.line(), driver.evaluate("n")), (5, "101".to_owned()));
    let set = json!({"expression": "n", "value": "1000"});
    driver.ask("setExpression", set).unwrap();
    let arguments = json!({"source": {"path": "/mine/late.script"}, "breakpoints": [{"line": 4,
        "condition": "n == 1010"}]});
    driver.ask("setBreakpoints", arguments).unwrap();
    // A port's pause counts besides the debugger's hold.
    order(&server, &json!({"do": "pause"}));
    driver.ask("continue", json!({"threadId": 1})).unwrap();
    other.event("continued");
    std::thread::sleep(Duration::from_millis(100));
    assert_eq!(program_state(&server), "paused");
    order(&server, &json!({"do": "play"}));
    assert_eq!(driver.event("stopped")["reason"], "breakpoint");
    assert_eq!(driver.evaluate("n"), "1010");
    driver.ask("continue", json!({"threadId": 1})).unwrap();
    driver.ask("pause", json!({"threadId": 1})).unwrap();
    assert_eq!(driver.event("stopped")["reason"], "pause");
    let n: i64 = driver.evaluate("n").parse().unwrap();
    assert!(n >= 1010, "{n}");
    // Whoever drove has gone: the program goes on, without breakpoints.
    driver.end();
    wait_for("it goes on", || program_state(&server) == "running");
    let shown: Json = serde_json::from_str(&server.page("/api/v1/debug").1).unwrap();
    assert_eq!(shown["breakpoints"], json!([]), "{shown}");

    // A stop reaches a program that is held.
    let mut driver = Debugger::new();
    driver.ask("initialize", json!({})).unwrap();
    driver.ask("attach", attach(true)).unwrap();
    driver.ask("pause", json!({"threadId": 1})).unwrap();
    driver.event("stopped");
    order(&server, &json!({"do": "stop"}));
    wait_for("it ends", || program_state(&server) == "stopped");
    drop((driver, other));
    assert!(server.terminate().success());
}

/// A server that watches every program lets a debugger attach to one that has begun, and the program does not wait for
/// it.
#[test]
fn a_debugger_attaches_to_a_program_that_has_begun_where_the_server_watches_all() {
    let folder = tempfile::tempdir().unwrap();
    let options = ["--plant", "ideal", "--record", "off", "--attachable"];
    let server = Server::start(folder.path(), &options);
    let endless = "def early():\n  n = 0\n  def count(n):\n    sync()\n    return n + 1\n  end\n  while True:\n\
                   \x20   n = count(n)\n  end\nend\n";
    run(&server, "early.script", endless);
    std::thread::sleep(Duration::from_millis(200));
    let attach = json!({"http-port": server.ports["http"], "drive": true});
    for _ in 0..2 {
        let mut driver = Debugger::new();
        driver.ask("initialize", json!({})).unwrap();
        driver.ask("attach", attach.clone()).unwrap();
        driver.ask("pause", json!({"threadId": 1})).unwrap();
        assert_eq!(driver.event("stopped")["reason"], "pause");
        wait_for("held is paused", || program_state(&server) == "paused");
        driver.ask("continue", json!({"threadId": 1})).unwrap();
        let arguments = json!({"source": {"path": "/mine/early.script"}, "breakpoints": [{"line": 5,
            "condition": "n % 50 == 0"}]});
        let bound = driver.ask("setBreakpoints", arguments).unwrap();
        assert_eq!(bound["breakpoints"][0]["verified"], true, "{bound}");
        assert_eq!(driver.event("stopped")["reason"], "breakpoint");
        let stack = driver.ask("stackTrace", json!({"threadId": 1})).unwrap();
        let frames = stack["stackFrames"].as_array().unwrap();
        let lines: Vec<_> = frames.iter().map(|frame| frame["line"].as_u64()).collect();
        assert!(lines.starts_with(&[Some(5), Some(8)]), "{stack}");
        let n: i64 = driver.evaluate("n").parse().unwrap();
        assert_eq!(n % 50, 0);
        // When it leaves, the program goes on.
        driver.end();
        wait_for("it goes on", || program_state(&server) == "running");
    }
    assert!(server.terminate().success());
}
