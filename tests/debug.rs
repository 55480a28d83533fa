//! `eliteserver debug` from its command line: over standard input and output and over a port, programs and recordings.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "test helpers fail by panicking"
)]

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Command, Stdio};

use editor::dap::stream::{self, DapInput};
use serde_json::{Value as Json, json};

const BINARY: &str = env!("CARGO_BIN_EXE_eliteserver");
const PROGRAM: &str = "\
print('speed', speed, get_actual_joint_positions()[0])
movej([0.5, -1.57, 1.57, -1.57, -1.57, 0], a=2, v=1)
n = random()
print('done')
";

struct Client<'c> {
    from: BufReader<Box<dyn Read + 'c>>,
    to: Box<dyn Write + 'c>,
    seq: i64,
    said: String,
}

impl<'c> Client<'c> {
    fn new(from: impl Read + 'c, to: impl Write + 'c) -> Self {
        Self {
            from: BufReader::new(Box::new(from)),
            to: Box::new(to),
            seq: 0,
            said: String::new(),
        }
    }

    fn send(&mut self, command: &str, arguments: Json) -> i64 {
        self.seq += 1;
        let message =
            json!({"seq": self.seq, "type": "request", "command": command, "arguments": arguments});
        stream::write(&mut self.to, &message).unwrap();
        self.seq
    }

    fn wait(&mut self, is_it: impl Fn(&Json) -> bool) -> Json {
        loop {
            let Some(DapInput::Message(message)) = stream::read(&mut self.from).unwrap() else {
                panic!("the debugger is gone");
            };
            if message["event"] == "output" {
                self.said += message["body"]["output"].as_str().unwrap();
            }
            if is_it(&message) {
                return message;
            }
        }
    }

    fn ask(&mut self, command: &str, arguments: Json) -> Result<Json, String> {
        let seq = self.send(command, arguments);
        let message = self.wait(|m| m["type"] == "response" && m["request_seq"] == seq);
        match message["success"] == true {
            true => Ok(message["body"].clone()),
            false => Err(message["message"].as_str().unwrap().to_owned()),
        }
    }

    fn launch(&mut self, arguments: Json) -> Result<Json, String> {
        self.ask("initialize", json!({}))?;
        self.ask("setExceptionBreakpoints", json!({"filters": ["uncaught"]}))?;
        self.ask("configurationDone", json!({}))?;
        self.ask("launch", arguments)
    }

    fn stopped(&mut self) -> Json {
        self.wait(|m| m["event"] == "stopped")["body"].clone()
    }

    fn evaluate(&mut self, text: &str) -> String {
        let arguments = json!({"expression": text, "context": "hover"});
        let body = self.ask("evaluate", arguments).unwrap();
        body["result"].as_str().unwrap().to_owned()
    }
}

fn written(folder: &Path) -> String {
    let path = folder.join("program.script");
    std::fs::write(&path, PROGRAM).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn a_program_is_debugged_over_standard_input_and_output_with_options_of_run() {
    let folder = tempfile::tempdir().unwrap();
    let program = written(folder.path());
    let mut child = Command::new(BINARY)
        .arg("debug")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut client = Client::new(child.stdout.take().unwrap(), child.stdin.take().unwrap());
    let refused = client.launch(json!({"program": program, "step-ms": 99}));
    assert!(refused.unwrap_err().contains("step-ms"));
    let refused = client.ask("launch", json!({"program": program, "stepMs": 2}));
    assert!(refused.unwrap_err().contains("stepMs"));
    let refused = client.ask("launch", json!({"program": program, "clock": "realtime"}));
    assert!(refused.unwrap_err().contains("virtual"));
    let arguments = json!({
        "program": program, "stopAtEnd": true, "plant": "ideal", "step-ms": 2,
        "home": [0.1, -1.57, 1.57, -1.57, -1.57, 0], "set": {"speed": 0.25}, "__sessionId": "1",
    });
    client.ask("launch", arguments).unwrap();
    let end = client.stopped();
    assert!(client.said.contains("speed 0.25 0.1"), "{}", client.said);
    assert_eq!(client.evaluate("get_steptime()"), "0.002");
    client
        .ask(
            "gotoCycle",
            json!({"cycle": end["cycle"].as_u64().unwrap() / 2}),
        )
        .unwrap();
    client.stopped();
    let halfway: f64 = client
        .evaluate("get_actual_joint_positions()[0]")
        .parse()
        .unwrap();
    assert!((0.15..0.45).contains(&halfway), "{halfway}");
    client.ask("disconnect", json!({})).unwrap();
    drop(client);
    assert!(child.wait().unwrap().success());
}

#[test]
fn a_recording_of_run_is_walked_both_ways_over_a_port() {
    let folder = tempfile::tempdir().unwrap();
    let program = written(folder.path());
    let recording = folder.path().join("run.mcap");
    let recording = recording.to_str().unwrap();
    let arguments = [
        "run", "--set", "speed=1", "--seed", "7", "--plant", "ideal", "--record",
    ];
    let ran = Command::new(BINARY)
        .args(arguments)
        .args([recording, &program])
        .output()
        .unwrap();
    assert!(ran.status.success(), "{ran:?}");
    let mut child = Command::new(BINARY)
        .args(["debug", "--port", "0"])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut said = String::new();
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    stderr.read_line(&mut said).unwrap();
    let address = said.trim().rsplit(' ').next().unwrap().to_owned();
    let mut numbers = Vec::new();
    for _ in 0..2 {
        let socket = TcpStream::connect(&address).unwrap();
        let mut client = Client::new(&socket, &socket);
        let refused = client.launch(json!({"recording": recording, "seed": 3}));
        assert!(refused.unwrap_err().contains("seed"));
        let arguments = json!({"recording": recording, "set": {"speed": 1}, "stopAtEnd": true});
        client.ask("launch", arguments).unwrap();
        client.stopped();
        assert_eq!(
            client.said.as_bytes(),
            ran.stdout,
            "the program of the recording runs as it did"
        );
        client
            .ask("reverseContinue", json!({"threadId": 1}))
            .unwrap();
        assert_eq!(client.stopped()["reason"], "entry");
        for _ in 0..3 {
            client.ask("next", json!({"threadId": 1})).unwrap();
            client.stopped();
        }
        numbers.push(client.evaluate("n"));
    }
    assert_eq!(numbers[0], numbers[1]);
    child.kill().unwrap();
    child.wait().unwrap();
}
