//! `eliteserver mcp` over its standard streams: every tool, the folder that it is held to, bad input, calls that are
//! cancelled.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "test helpers fail by panicking"
)]

use std::io::{BufRead, BufReader, Write};
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use base64::Engine as _;
use serde_json::{Value as Json, json};

/// Longest time a server may take to go.
const PATIENCE: Duration = Duration::from_secs(30);

struct Client {
    child: Child,
    input: Option<ChildStdin>,
    output: BufReader<ChildStdout>,
    number: u64,
}

impl Client {
    /// A server in a folder, not asked anything yet.
    fn bare(folder: &Path) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_eliteserver"))
            .arg("mcp")
            .current_dir(folder)
            .env_remove("RUST_LOG")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        Self {
            input: child.stdin.take(),
            output: BufReader::new(child.stdout.take().unwrap()),
            child,
            number: 0,
        }
    }

    /// A server that has been told who asks.
    fn start(folder: &Path) -> Self {
        let mut client = Self::bare(folder);
        let answer = client.ask("initialize", initialize());
        let info = &answer["result"]["serverInfo"];
        assert_eq!(info["name"], "eliteserver", "{answer}");
        client.line(br#"{"jsonrpc":"2.0","method":"notifications/initialized"}"#);
        client
    }

    fn line(&mut self, bytes: &[u8]) {
        let input = self.input.as_mut().unwrap();
        input.write_all(bytes).unwrap();
        input.write_all(b"\n").unwrap();
        input.flush().unwrap();
    }

    fn send(&mut self, method: &str, params: Json) -> u64 {
        self.number += 1;
        let number = self.number;
        let message = json!({"jsonrpc": "2.0", "id": number, "method": method, "params": params});
        self.line(message.to_string().as_bytes());
        number
    }

    fn receive(&mut self) -> Json {
        let mut line = String::new();
        assert!(
            self.output.read_line(&mut line).unwrap() > 0,
            "the server is gone"
        );
        serde_json::from_str(&line).unwrap()
    }

    fn answer(&mut self, number: u64) -> Json {
        loop {
            let message = self.receive();
            if message["id"] == number {
                return message;
            }
        }
    }

    fn ask(&mut self, method: &str, params: Json) -> Json {
        let number = self.send(method, params);
        self.answer(number)
    }

    /// The result of a tool.
    fn call(&mut self, tool: &str, arguments: Json) -> Json {
        let answer = self.ask("tools/call", json!({"name": tool, "arguments": arguments}));
        assert!(answer["result"].is_object(), "{answer}");
        answer["result"].clone()
    }

    /// What a tool says.
    fn told(&mut self, tool: &str, arguments: Json) -> String {
        let result = self.call(tool, arguments);
        assert_ne!(result["isError"], true, "{result}");
        text(&result)
    }

    /// What a tool refuses with.
    fn refused(&mut self, tool: &str, arguments: Json) -> String {
        let result = self.call(tool, arguments);
        assert_eq!(result["isError"], true, "{result}");
        text(&result)
    }

    /// The exit status of a server whose client goes.
    fn leave(mut self) -> Option<i32> {
        drop(self.input.take());
        let since = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                return status.code();
            }
            assert!(since.elapsed() < PATIENCE, "the server stays");
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

impl Drop for Client {
    fn drop(&mut self) {
        // One that is gone already is as good.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn initialize() -> Json {
    json!({
        "protocolVersion": "2025-06-18",
        "capabilities": {},
        "clientInfo": {"name": "test", "version": "1"},
    })
}

fn text(result: &Json) -> String {
    result["content"][0]["text"].as_str().unwrap().to_owned()
}

#[test]
fn every_tool_is_told_of_with_its_arguments() {
    let folder = tempfile::tempdir().unwrap();
    let mut client = Client::start(folder.path());
    let listed = client.ask("tools/list", json!({}));
    let tools = listed["result"]["tools"].as_array().unwrap();
    let names: Vec<&str> = tools
        .iter()
        .map(|tool| tool["name"].as_str().unwrap())
        .collect();
    let wanted = [
        "builtin",
        "check",
        "run",
        "test",
        "clearance",
        "plan_path",
        "replay_summary",
        "replay_at",
        "replay_find",
        "replay_plot",
    ];
    assert_eq!(names, wanted);
    for tool in tools {
        assert_eq!(tool["inputSchema"]["type"], "object", "{tool}");
        assert_eq!(tool["annotations"]["openWorldHint"], false, "{tool}");
    }
    assert_eq!(client.leave(), Some(0));
}

#[test]
fn functions_are_found_and_explained() {
    let folder = tempfile::tempdir().unwrap();
    let mut client = Client::start(folder.path());
    let full = client.told("builtin", json!({"name": "movel"}));
    assert!(
        full.contains("movel(pose,") && full.contains("Manual 3.1."),
        "{full}"
    );
    let chinese = client.told("builtin", json!({"name": "movel", "language": "zh"}));
    assert!(chinese.contains("参数"), "{chinese}");
    let found = client.told("builtin", json!({"search": "Force Mode"}));
    assert!(
        found.starts_with("end_force_mode()") && found.contains("force_mode("),
        "{found}"
    );
    let all = client.told("builtin", json!({}));
    assert!(all.contains("motion: ") && all.contains("movej"), "{all}");
    let near = client.refused("builtin", json!({"name": "get_actual_tcp"}));
    assert!(near.contains("get_actual_tcp_pose"), "{near}");
}

#[test]
fn programs_are_checked_from_a_text_and_from_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let program = "def f():\n    movej([0, -90, 0, 0, 0, 0], v=sped)\nf()\n";
    std::fs::write(folder.path().join("a.script"), program).unwrap();
    let mut client = Client::start(folder.path());
    for arguments in [json!({"program": program}), json!({"file": "a.script"})] {
        let result = client.call("check", arguments);
        let codes: Vec<&Json> = result["structuredContent"]["findings"]
            .as_array()
            .unwrap()
            .iter()
            .map(|finding| &finding["code"])
            .collect();
        assert_eq!(codes, ["degrees", "undefined-name"], "{result}");
        assert!(text(&result).contains("^"), "{result}");
    }
    let clean = client.told("check", json!({"program": "print(1)\n"}));
    assert_eq!(clean, "no findings");
    let tests = json!({"program": "def test_a():\n    test.advance(1)\n", "is_test": true});
    assert_eq!(client.told("check", tests), "no findings");
    let both = client.refused("check", json!({}));
    assert!(both.contains("either program"), "{both}");
}

#[test]
fn a_program_is_run_recorded_and_looked_at() {
    let folder = tempfile::tempdir().unwrap();
    let mut client = Client::start(folder.path());
    let program = "print('speed', speed)\nmovej([0.4, -1.57, 1.57, -1.57, -1.57, 0], a=2, v=1)\n";
    let arguments = json!({
        "program": program, "record": "out/run.mcap", "set": {"speed": 0.25}, "plant": "ideal",
        "home": [0, -1.57, 1.57, -1.57, -1.57, 0],
    });
    let ran = client.call("run", arguments);
    let result = &ran["structuredContent"];
    assert_eq!(result["outcome"], "ended", "{ran}");
    assert_eq!(result["prints"], "speed 0.25");
    assert_eq!(result["recording"], "out/run.mcap");
    let joint = result["joint_positions"][0].as_f64().unwrap();
    assert!((joint - 0.4).abs() < 1e-6, "{joint}");
    assert!(result["peaks"]["joint_speed"][0].as_f64().unwrap() > 0.1);

    let recording = json!({"recording": "out/run.mcap", "script": true});
    let summary = client.told("replay_summary", recording);
    for part in [
        "recording: out/run.mcap",
        "errors: 0",
        "ending: complete",
        "movej(",
    ] {
        assert!(summary.contains(part), "{part}: {summary}");
    }
    let at = json!({"recording": "out/run.mcap", "time": 0.2});
    let state = client.told("replay_at", at);
    assert!(
        state.contains("script: program line 2") && state.contains("actual_q: "),
        "{state}"
    );
    let find = json!({"recording": "out/run.mcap", "condition": "actual_q[0] > 0.2"});
    let found = client.told("replay_find", find);
    assert!(
        found.contains("program line 2") && found.contains("found: 1 time"),
        "{found}"
    );
    let plot = client.call("replay_plot", json!({"recording": "out/run.mcap"}));
    let picture = &plot["content"][1];
    assert_eq!(picture["mimeType"], "image/png", "{}", plot["content"][0]);
    let data = picture["data"].as_str().unwrap();
    let png = base64::prelude::BASE64_STANDARD.decode(data).unwrap();
    assert!(png.starts_with(b"\x89PNG\r\n\x1a\n") && png.len() > 10_000);

    let late = json!({"recording": "out/run.mcap", "time": 99});
    assert!(
        client
            .refused("replay_at", late)
            .contains("the recording covers")
    );
    let wrong = json!({"recording": "out/run.mcap", "condition": "actual_q[0] >"});
    client.refused("replay_find", wrong);
    let none = client.refused("replay_summary", json!({"recording": "none.mcap"}));
    assert!(none.contains("none.mcap"), "{none}");
}

#[test]
fn a_program_that_fails_is_told_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let mut client = Client::start(folder.path());
    let ran = client.call("run", json!({"program": "x = 1\ny = x / 0\n"}));
    let result = &ran["structuredContent"];
    assert_eq!(
        (&result["outcome"], &result["line"]),
        (&"failed".into(), &2.into())
    );
    assert!(
        result["error"]
            .as_str()
            .unwrap()
            .starts_with("ZeroDivisionError"),
        "{ran}"
    );
    let ran = client.call("run", json!({"program": "def f(:\n"}));
    assert_eq!(ran["structuredContent"]["outcome"], "failed", "{ran}");
    for (arguments, named) in [
        (json!({"program": "pass", "time": 0}), "time is 0"),
        (
            json!({"program": "pass", "wall_time": 1e9}),
            "wall_time is 1000000000",
        ),
        (
            json!({"program": "pass", "model": "cs99"}),
            "model is \"cs99\"",
        ),
        (
            json!({"program": "pass", "plant": "wood"}),
            "plant is \"wood\"",
        ),
        (json!({"program": "pass", "step_ms": 9}), "step_ms is \"9\""),
        (
            json!({"program": "pass", "payload": [1, 2]}),
            "payload is \"1,2\"",
        ),
        (json!({"program": "pass", "home": [1]}), "home: "),
        (
            json!({"program": "pass", "home": [99, 0, 0, 0, 0, 0]}),
            "99",
        ),
        (json!({"program": "pass", "set": {"a b": 1}}), "set: a b"),
        (
            json!({"program": "pass", "colour": 1}),
            "unknown field `colour`",
        ),
        (json!({"program": 7}), "program: invalid type"),
        (json!({"program": "pass", "file": "a"}), "either program"),
        (
            json!({"program": "x".repeat(9 << 20)}),
            "program has 9437184 bytes",
        ),
    ] {
        let sentence = client.refused("run", arguments);
        assert!(sentence.contains(named), "{named}: {sentence}");
    }
}

#[test]
fn time_output_and_memory_of_a_run_are_bounded() {
    let folder = tempfile::tempdir().unwrap();
    let mut client = Client::start(folder.path());
    let run = |client: &mut Client, program: &str, more: Json| {
        let mut arguments = json!({"program": program, "plant": "ideal"});
        let fields = arguments.as_object_mut().unwrap();
        fields.extend(more.as_object().unwrap().clone());
        client.call("run", arguments)["structuredContent"].clone()
    };
    let waits = run(
        &mut client,
        "while True:\n    sleep(0.1)\n",
        json!({"time": 5}),
    );
    assert_eq!(waits["outcome"], "timeout");
    assert!(
        (waits["time"].as_f64().unwrap() - 5.0).abs() < 0.1,
        "{waits}"
    );
    let computes = run(
        &mut client,
        "while True:\n    pass\n",
        json!({"wall_time": 0.5}),
    );
    assert!(
        computes["error"].as_str().unwrap().contains("wall_time"),
        "{computes}"
    );
    let talks = run(
        &mut client,
        "for i in range(20000):\n    print('x' * 90, i)\n",
        json!({}),
    );
    let prints = talks["prints"].as_str().unwrap();
    assert!(prints.len() < 70_000 && prints.contains("left out") && prints.ends_with("19999"));
    let hoards = run(
        &mut client,
        "a = []\nwhile True:\n    a.append('x' * 10000000 + str(len(a)))\n",
        json!({}),
    );
    assert!(
        hoards["error"].as_str().unwrap().starts_with("MemoryError"),
        "{hoards}"
    );
}

#[test]
fn programs_reach_neither_network_nor_files_unless_they_may() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("inner")).unwrap();
    let secret = folder.path().join("secret");
    std::fs::write(&secret, "secret").unwrap();
    let inner = folder.path().join("inner");
    symlink("../secret", inner.join("link")).unwrap();
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    listener.set_nonblocking(true).unwrap();
    let port = listener.local_addr().unwrap().port();
    let mut client = Client::start(&inner);
    let program = format!(
        "print(socket_open('127.0.0.1', {port}))\n\
         try:\n    \
             modbus_add_signal('127.0.0.1', 1, 1, 2, 'level', port={port})\n\
         except PermissionError as error:\n    \
             print(error)\n\
         import socket\n\
         for action in [lambda s: s.connect(('127.0.0.1', {port})), lambda s: s.bind(('127.0.0.1', 0))]:\n    \
             s = socket.socket()\n    \
             try:\n        \
                 action(s)\n    \
             except PermissionError as error:\n        \
                 print('refused')\n"
    );
    let ran = client.call("run", json!({"program": program}));
    let prints = ran["structuredContent"]["prints"].as_str().unwrap();
    assert!(
        prints.starts_with("False\nmodbus_add_signal(): nobody plays 127.0.0.1"),
        "{ran}"
    );
    assert!(prints.ends_with("\nrefused\nrefused"), "{ran}");
    let nobody = listener.accept().unwrap_err();
    assert_eq!(nobody.kind(), std::io::ErrorKind::WouldBlock);

    let program = "print(open('a.txt', 'w').write('text'))\n";
    let ran = client.call("run", json!({"program": program}));
    assert!(
        ran["structuredContent"]["error"]
            .as_str()
            .unwrap()
            .contains("PermissionError")
    );
    let ran = client.call("run", json!({"program": program, "files": true}));
    assert_eq!(ran["structuredContent"]["prints"], "4", "{ran}");
    assert_eq!(
        std::fs::read_to_string(inner.join("a.txt")).unwrap(),
        "text"
    );
    for path in [
        "link",
        "../secret",
        secret.to_str().unwrap(),
        "/proc/self/cwd/../secret",
    ] {
        let program = format!("print(open({path:?}).read())\n");
        let ran = client.call("run", json!({"program": program, "files": true}));
        let error = ran["structuredContent"]["error"].as_str().unwrap();
        assert!(error.contains("PermissionError"), "{path}: {ran}");
    }
    for program in [
        "import subprocess\nsubprocess.run(['id'])\n",
        "import os\nprint(os.environ['PATH'])\n",
    ] {
        let ran = client.call("run", json!({"program": program, "files": true}));
        assert_eq!(ran["structuredContent"]["outcome"], "failed", "{ran}");
    }
    // What a cell connects counts as well.
    std::fs::write(
        inner.join("cell.toml"),
        "[[serial]]\nport = \"tool\"\ndevice = \"/dev/ttyS0\"\n",
    )
    .unwrap();
    let serial = client.refused("run", json!({"program": "pass", "cell": "cell.toml"}));
    assert!(serial.contains("/dev/ttyS0"), "{serial}");
    let signal = format!(
        "[[modbus]]\nIP = \"127.0.0.1\"\nport = {port}\nslave_number = 1\nsignal_address = 1\n\
         signal_type = 2\nsignal_name = \"level\"\n"
    );
    std::fs::write(inner.join("cell.toml"), signal).unwrap();
    let modbus = client.refused("run", json!({"program": "pass", "cell": "cell.toml"}));
    assert!(modbus.contains("modbus signal \"level\""), "{modbus}");
}

#[test]
fn no_argument_leads_out_of_the_folder() {
    let around = tempfile::tempdir().unwrap();
    let inner = around.path().join("inner");
    std::fs::create_dir(&inner).unwrap();
    let outside = around.path().join("outside.script");
    std::fs::write(&outside, "print('outside')\n").unwrap();
    std::fs::write(
        around.path().join("test_o.script"),
        "def test_o():\n    pass\n",
    )
    .unwrap();
    std::fs::write(
        inner.join("test_own.script"),
        "def test_own():\n    test.run('../outside.script')\n",
    )
    .unwrap();
    symlink(&outside, inner.join("link.script")).unwrap();
    symlink("..", inner.join("up")).unwrap();
    let mut client = Client::start(&inner);
    let whole = outside.display().to_string();
    let through_proc = format!("/proc/self/root{whole}");
    for path in [
        "../outside.script",
        "link.script",
        "up/outside.script",
        &whole,
        &through_proc,
    ] {
        for (tool, arguments) in [
            ("check", json!({"file": path})),
            ("run", json!({"file": path})),
            ("run", json!({"program": "pass", "cell": path})),
            (
                "run",
                json!({"program": "pass", "model": format!("./{path}").replace(".//", "/")}),
            ),
            ("run", json!({"program": "pass", "record": path})),
            ("test", json!({"paths": [path]})),
            ("replay_summary", json!({"recording": path})),
            ("replay_plot", json!({"recording": path})),
        ] {
            let sentence = client.refused(tool, arguments);
            let why = "is not within";
            assert!(sentence.contains(why), "{tool} {path}: {sentence}");
        }
    }
    assert_eq!(
        std::fs::read_to_string(&outside).unwrap(),
        "print('outside')\n"
    );
    for folder in ["..", "up", "/"] {
        client.refused("test", json!({"paths": [folder]}));
        let failing = json!({"paths": ["test_own.script"], "record_failed": folder});
        client.refused("test", failing);
    }
    // Nor do programs that a test starts, and ways that it keeps.
    let ran = client.call("test", json!({}));
    assert_eq!(ran["structuredContent"]["failed"], 1, "{ran}");
    assert!(text(&ran).contains("is not within"), "{ran}");
    std::fs::write(
        inner.join("test_own.script"),
        "def test_own():\n    test.advance(0.1)\n    test.path_near('../way.csv')\n",
    )
    .unwrap();
    let ran = client.call("test", json!({"update": true}));
    assert!(text(&ran).contains("is not within"), "{ran}");
    assert!(!around.path().join("way.csv").exists());
}

#[test]
fn tests_are_run_with_their_settings_and_machines_they_play() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write(
        "move.script",
        "socket_open('10.9.8.7', 5000)\nsocket_send_line('hello')\n\
         movej([0.3, -1.57, 1.57, -1.57, -1.57, 0], a=2, v=1)\n",
    );
    write(
        "test_move.script",
        "def test_moves():\n    camera = test.socket_server(5000)\n    result = test.run('move.script')\n    \
         assert result.outcome == 'ended', result.error\n    test.path_near('ways/move.csv')\n\
         def test_fails():\n    test.run('move.script')\n    assert False, 'on purpose'\n",
    );
    write("test.toml", "plant = \"ideal\"\n");
    let mut client = Client::start(folder.path());
    let ran = client.call("test", json!({"update": true, "record_failed": "failed"}));
    let result = &ran["structuredContent"];
    assert_eq!(
        (&result["passed"], &result["failed"]),
        (&1.into(), &1.into()),
        "{ran}"
    );
    assert!(folder.path().join("ways/move.csv").is_file());
    let failed = result["tests"]
        .as_array()
        .unwrap()
        .iter()
        .find(|test| test["status"] == "failed");
    let failed = failed.unwrap();
    assert_eq!(
        (&failed["name"], &failed["line"]),
        (&"test_fails".into(), &8.into())
    );
    let recording = failed["recording"].as_str().unwrap();
    let summary = client.told("replay_summary", json!({"recording": recording}));
    assert!(summary.contains("ideal plant"), "{summary}");
    let only = client.call("test", json!({"select": "test_moves"}));
    assert_eq!(only["structuredContent"]["passed"], 1, "{only}");
    let none = client.refused("test", json!({"select": "nothing"}));
    assert!(none.contains("there is no test"), "{none}");
    write("test.toml", "allow = [\"process\"]\n");
    let more = client.refused("test", json!({}));
    assert!(more.contains("allow more than there is here"), "{more}");
}

#[test]
fn what_is_no_request_is_answered_and_the_session_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let mut client = Client::bare(folder.path());
    // Before the beginning.
    client.line(b"");
    client.line(b"{\"jsonrpc\":\"2.0\",\"method\":\"notifications/initialized\"}");
    client.line(b"nonsense");
    assert_eq!(client.receive()["error"]["code"], -32700);
    assert!(client.ask("tools/list", json!({}))["error"].is_object());
    assert!(client.ask("initialize", initialize())["result"].is_object());
    for (line, code) in [
        (b"\xff\xff\xff".as_slice(), -32700),
        (b"{\"jsonrpc\":\"2.0\",", -32700),
        (b"[]", -32600),
        (b"{\"id\":3}", -32600),
        (b"{\"jsonrpc\":\"2.0\",\"id\":77,\"method\":12}", -32600),
        (b"{\"jsonrpc\":\"2.0\",\"id\":78,\"method\":\"tools/call\",\"params\":{\"arguments\":{}}}", -32602),
        (b"{\"jsonrpc\":\"2.0\",\"id\":79,\"method\":\"robots/move\",\"params\":{}}", -32601),
        (b"{\"jsonrpc\":\"2.0\",\"id\":80,\"method\":\"resources/read\",\"params\":{\"uri\":\"file:///etc/passwd\"}}",
            -32601),
    ] {
        client.line(line);
        let answer = client.receive();
        let shown = String::from_utf8_lossy(line).into_owned();
        assert!(answer["error"].is_object(), "{shown}: {answer}");
        if code != -32602 {
            assert_eq!(answer["error"]["code"], code, "{shown}: {answer}");
        }
    }
    let unknown = client.ask("tools/call", json!({"name": "drill"}));
    assert_eq!(unknown["error"]["code"], -32602);
    assert!(
        unknown["error"]["message"]
            .as_str()
            .unwrap()
            .contains("builtin, check, run")
    );
    assert!(client.ask("tools/list", json!({}))["result"].is_object());
    assert_eq!(client.leave(), Some(0));
    assert_eq!(Client::bare(folder.path()).leave(), Some(1));
}

#[test]
fn a_call_that_is_cancelled_ends_and_others_are_answered() {
    let folder = tempfile::tempdir().unwrap();
    let mut client = Client::start(folder.path());
    let endless = json!({"name": "run", "arguments": {
        "program": "while True:\n    pass\n", "time": 3600, "wall_time": 300,
    }});
    // More than are at work at once.
    let calls: Vec<u64> = (0..4)
        .map(|_| client.send("tools/call", endless.clone()))
        .collect();
    std::thread::sleep(Duration::from_millis(300));
    for number in calls {
        let cancelled = json!({
            "jsonrpc": "2.0", "method": "notifications/cancelled",
            "params": {"requestId": number, "reason": "enough"},
        });
        client.line(cancelled.to_string().as_bytes());
    }
    let since = Instant::now();
    assert_eq!(
        client.told("check", json!({"program": "pass\n"})),
        "no findings"
    );
    assert!(since.elapsed() < PATIENCE);
    // And a client that goes in the midst of one.
    client.send("tools/call", endless);
    let since = Instant::now();
    assert_eq!(client.leave(), Some(0));
    assert!(since.elapsed() < PATIENCE);
}
