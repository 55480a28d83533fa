//! A client of our own.

use std::collections::VecDeque;
use std::io::{BufReader, Write};
use std::net::Shutdown;
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use controller::ControllerConfig;
use controller::options::PlantChoice;
use editor::dap::{RunTarget, serve, stream};
use elite_runtime::ProgramText;
use messages::Text;
use serde_json::{Value as Json, json};

/// Nothing in these tests takes that long, on any machine.
const PATIENCE: Duration = Duration::from_secs(120);

/// A client and the session that serves it.
pub struct Client {
    pub to: UnixStream,
    messages: Receiver<Json>,
    kept: VecDeque<Json>,
    seq: i64,
    session: Option<JoinHandle<()>>,
    pub path: PathBuf,
    pub outputs: Vec<String>,
    _folder: tempfile::TempDir,
}

/// Where the program is held.
#[derive(Clone, Debug, PartialEq)]
pub struct Suspension {
    pub reason: String,
    pub thread: i64,
    pub line: i64,
    pub column: i64,
    pub function: String,
    pub depth: usize,
    pub statement: u64,
    pub cycle: u64,
    pub text: String,
    pub frame: i64,
}

fn launch(arguments: &Json) -> Result<RunTarget, Text> {
    let program = arguments["program"]
        .as_str()
        .ok_or(Text::verbatim("no program"))?;
    let text = std::fs::read_to_string(program).map_err(|error| Text::of(&error))?;
    let plant = match arguments["plant"].as_str() {
        Some("rigid") => PlantChoice::Rigid,
        _ => PlantChoice::Ideal,
    };
    Ok(RunTarget {
        program: ProgramText {
            name: program.to_owned(),
            text,
        },
        robot: ControllerConfig {
            plant,
            ..ControllerConfig::default()
        },
        presets: Vec::new(),
        recorded: None,
    })
}

impl Client {
    /// A client whose program is written, and nothing said yet.
    pub fn new(program: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("program.script");
        std::fs::write(&path, program).unwrap();
        let (to, theirs) = UnixStream::pair().unwrap();
        let mut out = theirs.try_clone().unwrap();
        let session = thread::spawn(move || {
            serve(BufReader::new(theirs), &mut out, &launch).unwrap();
            let _ = out.shutdown(Shutdown::Both);
        });
        let mut from = BufReader::new(to.try_clone().unwrap());
        let (sender, messages) = channel();
        thread::spawn(move || {
            while let Ok(Some(stream::DapInput::Message(message))) = stream::read(&mut from) {
                if sender.send(message).is_err() {
                    return;
                }
            }
        });
        Self {
            to,
            messages,
            kept: VecDeque::new(),
            seq: 0,
            session: Some(session),
            path: path.canonicalize().unwrap(),
            outputs: Vec::new(),
            _folder: folder,
        }
    }

    /// One that has launched its program and set breakpoints in these lines.
    pub fn launched(program: &str, lines: &[Json], more: Json) -> Self {
        let mut client = Self::new(program);
        client.ask("initialize", json!({"adapterID": "test"}));
        client.event("initialized");
        let mut arguments = json!({"program": client.path});
        for (key, value) in more.as_object().into_iter().flatten() {
            arguments[key] = value.clone();
        }
        let launch = client.send("launch", arguments);
        let bound = client.set_breakpoints(lines);
        assert_eq!(bound.len(), lines.len());
        client.ask("configurationDone", json!({}));
        client.response(launch).unwrap();
        client
    }

    pub fn set_breakpoints(&mut self, lines: &[Json]) -> Vec<Json> {
        let arguments = json!({"source": {"path": self.path}, "breakpoints": lines});
        let body = self.ask("setBreakpoints", arguments);
        body["breakpoints"].as_array().unwrap().clone()
    }

    pub fn send(&mut self, command: &str, arguments: Json) -> i64 {
        self.seq += 1;
        let message = json!({
            "seq": self.seq, "type": "request", "command": command, "arguments": arguments,
        });
        // The session may be over.
        let _ = stream::write(&mut self.to, &message);
        self.seq
    }

    pub fn send_bytes(&mut self, bytes: &[u8]) {
        let _ = self.to.write_all(bytes);
    }

    fn next(&mut self) -> Option<Json> {
        let message = self.messages.recv_timeout(PATIENCE).ok()?;
        check_shape(&message);
        if message["event"] == "output" {
            let text = message["body"]["output"].as_str().unwrap().to_owned();
            self.outputs.push(text);
        }
        Some(message)
    }

    pub fn wait(&mut self, mut is_it: impl FnMut(&Json) -> bool) -> Json {
        if let Some(index) = self.kept.iter().position(&mut is_it) {
            return self.kept.remove(index).unwrap();
        }
        loop {
            let message = self.next().expect("a message in time");
            if is_it(&message) {
                return message;
            }
            self.kept.push_back(message);
        }
    }

    pub fn response(&mut self, seq: i64) -> Result<Json, String> {
        let message =
            self.wait(|message| message["type"] == "response" && message["request_seq"] == seq);
        match message["success"] == true {
            true => Ok(message["body"].clone()),
            false => Err(message["message"].as_str().unwrap().to_owned()),
        }
    }

    pub fn try_ask(&mut self, command: &str, arguments: Json) -> Result<Json, String> {
        let seq = self.send(command, arguments);
        self.response(seq)
    }

    #[track_caller]
    pub fn ask(&mut self, command: &str, arguments: Json) -> Json {
        match self.try_ask(command, arguments) {
            Ok(body) => body,
            Err(error) => panic!("{command}: {error}"),
        }
    }

    pub fn event(&mut self, name: &str) -> Json {
        self.wait(|message| message["event"] == name)["body"].clone()
    }

    /// Where the program is held next; None: it has ended.
    pub fn try_held(&mut self) -> Option<Suspension> {
        let message =
            self.wait(|message| message["event"] == "stopped" || message["event"] == "terminated");
        if message["event"] == "terminated" {
            return None;
        }
        let body = &message["body"];
        let thread = body["threadId"].as_i64().unwrap();
        let stack = self.ask("stackTrace", json!({"threadId": thread}));
        let frames = stack["stackFrames"].as_array().unwrap();
        let top = frames.first().cloned().unwrap_or(json!({}));
        Some(Suspension {
            reason: body["reason"].as_str().unwrap().to_owned(),
            thread,
            line: top["line"].as_i64().unwrap_or(0),
            column: top["column"].as_i64().unwrap_or(0),
            function: top["name"].as_str().unwrap_or("").to_owned(),
            depth: frames.len(),
            statement: body["statement"].as_u64().unwrap(),
            cycle: body["cycle"].as_u64().unwrap(),
            text: body["text"].as_str().unwrap_or("").to_owned(),
            frame: top["id"].as_i64().unwrap_or(0),
        })
    }

    #[track_caller]
    pub fn held(&mut self) -> Suspension {
        self.try_held().expect("the program is held")
    }

    /// Goes on, and where it is held then.
    #[track_caller]
    pub fn go(&mut self, command: &str) -> Suspension {
        self.try_go(command).expect("the program is held")
    }

    pub fn try_go(&mut self, command: &str) -> Option<Suspension> {
        self.ask(command, json!({"threadId": 1}));
        self.try_held()
    }

    pub fn evaluate(&mut self, text: &str, context: &str) -> Result<String, String> {
        let arguments = json!({"expression": text, "context": context});
        let body = self.try_ask("evaluate", arguments)?;
        Ok(body["result"].as_str().unwrap().to_owned())
    }

    /// The variables of a scope of the innermost call.
    pub fn scope(&mut self, held: &Suspension, name: &str) -> Vec<Json> {
        let scopes = self.ask("scopes", json!({"frameId": held.frame}));
        let scopes = scopes["scopes"].as_array().unwrap().clone();
        let Some(scope) = scopes.iter().find(|scope| scope["name"] == name) else {
            return Vec::new();
        };
        self.variables(&scope["variablesReference"])
    }

    pub fn variables(&mut self, reference: &Json) -> Vec<Json> {
        let body = self.ask("variables", json!({"variablesReference": reference}));
        body["variables"].as_array().unwrap().clone()
    }

    /// Locals and globals as `name=value`, sorted.
    pub fn all(&mut self, held: &Suspension) -> Vec<String> {
        let mut all = self.scope(held, "Locals");
        all.extend(self.scope(held, "Globals"));
        let mut texts: Vec<String> = all
            .iter()
            .filter(|variable| variable["type"] != "function" && variable["type"] != "generator")
            .map(|variable| {
                let (name, value) = (&variable["name"], &variable["value"]);
                format!("{}={}", name.as_str().unwrap(), value.as_str().unwrap())
            })
            .collect();
        texts.sort();
        texts
    }

    pub fn end(mut self) {
        let _ = self.try_ask("disconnect", json!({}));
        self.session.take().unwrap().join().unwrap();
    }

    /// The client is gone without a word; the session ends, and what it launched with it.
    pub fn vanish(mut self) {
        let _ = self.to.shutdown(Shutdown::Both);
        self.session.take().unwrap().join().unwrap();
    }
}

/// Every message has what the protocol asks of its kind.
fn check_shape(message: &Json) {
    assert!(message["seq"].as_i64().unwrap() > 0, "{message}");
    match message["type"].as_str().unwrap() {
        "event" => {
            assert!(message["event"].is_string() && message["body"].is_object());
            let body = &message["body"];
            match message["event"].as_str().unwrap() {
                "stopped" => assert!(body["reason"].is_string() && body["threadId"].is_u64()),
                "output" => assert!(body["output"].is_string() && body["category"].is_string()),
                "thread" => assert!(body["reason"].is_string() && body["threadId"].is_u64()),
                "exited" => assert!(body["exitCode"].is_i64()),
                "breakpoint" => assert!(body["breakpoint"]["verified"].is_boolean()),
                "initialized" | "terminated" | "process" => {}
                other => panic!("the event {other} is not one of the protocol"),
            }
        }
        "response" => {
            assert!(message["request_seq"].is_i64() && message["command"].is_string());
            match message["success"].as_bool().unwrap() {
                true => assert!(message["body"].is_object(), "{message}"),
                false => assert!(!message["message"].as_str().unwrap().is_empty()),
            }
        }
        other => panic!("a message of type {other}"),
    }
}
