//! What the system tests share: a running server on free ports, a client of its dashboard, a reader of the state stream
//! that knows only the protocol page, and a recording read back with the public mcap reader.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test helper fails by panicking"
)]

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use recorder::cycle::CycleMessage;
use recorder::{RecorderConfig, Rotation, Setup};

/// Longest time any step of a test may take.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// The machine, for tests that talk in real time or look at how long something takes: one of them at a time. Where each
/// test is a process of its own (nextest), `.config/nextest.toml` sees to the same.
pub fn alone() -> MutexGuard<'static, ()> {
    static MACHINE: Mutex<()> = Mutex::new(());
    // One that failed has left nothing behind that the next could trip over.
    MACHINE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A recorder of a whole run into one file, which loses nothing.
pub fn recorder_config(path: &Path, setup: Setup, model: kinematics::RobotModel) -> RecorderConfig {
    RecorderConfig {
        path: path.to_owned(),
        setup,
        model,
        obstacles: Vec::new(),
        extra: Vec::new(),
        rotation: Rotation::default(),
        notes_wait: true,
        patience: PATIENCE,
        on_failure: Box::new(|error| panic!("{error}")),
    }
}

/// The binary under test.
pub fn eliteserver() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_eliteserver"));
    command.env_remove("RUST_LOG").stdin(Stdio::null());
    command
}

/// What the binary says in a folder with these arguments, standard output before standard error, and its status; -1
/// where a signal has ended it.
pub fn said_and_status(folder: &Path, arguments: &[&str]) -> (String, i32) {
    let output = eliteserver()
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let said = text(&output.stdout) + &text(&output.stderr);
    (said, output.status.code().unwrap_or(-1))
}

/// A server that is killed when the test is over.
pub struct Server {
    child: Child,
    /// Ports by service, from the ready file.
    pub ports: BTreeMap<String, u16>,
}

impl Server {
    /// Starts a server on free ports and waits until its ready file is there.
    pub fn start(folder: &Path, options: &[&str]) -> Self {
        let log = std::fs::File::create(folder.join("stderr.log")).unwrap();
        Self::start_with(folder, options, log)
    }

    /// The same with another standard error. Faults on demand are ordered in the file `faults` of the folder.
    pub fn start_with(folder: &Path, options: &[&str], log: impl Into<Stdio>) -> Self {
        let ready = folder.join("ready.json");
        let mut command = eliteserver();
        command
            .arg("serve")
            .arg("--ready-file")
            .arg(&ready)
            .current_dir(folder);
        for service in [
            "primary",
            "interpreter",
            "rtsi",
            "dashboard",
            "modbus",
            "http",
        ] {
            command.arg(format!("--{service}-port")).arg("0");
        }
        let child = command
            .args(options)
            .env(supervision::injection::VARIABLE, folder.join("faults"))
            .stdout(Stdio::null())
            .stderr(log)
            .spawn()
            .unwrap();
        Self::adopt(child, &ready, folder)
    }

    /// A server that was started in another way; waits until its ready file is there. Its stderr goes to `stderr.log`.
    pub fn adopt(child: Child, ready: &Path, folder: &Path) -> Self {
        let mut server = Self {
            child,
            ports: BTreeMap::new(),
        };
        let started = Instant::now();
        while !ready.exists() {
            assert!(
                server.child.try_wait().unwrap().is_none(),
                "ended early: {}",
                log_of(folder)
            );
            assert!(
                started.elapsed() < PATIENCE,
                "not ready: {}",
                log_of(folder)
            );
            std::thread::sleep(Duration::from_millis(5));
        }
        let json: serde_json::Value =
            serde_json::from_slice(&std::fs::read(ready).unwrap()).unwrap();
        for (service, port) in json["ports"].as_object().unwrap() {
            if let Some(port) = port.as_u64() {
                server.ports.insert(service.clone(), port as u16);
            }
        }
        server
    }

    /// A client of port 30001.
    pub fn primary(&self) -> Primary {
        let stream = TcpStream::connect(("127.0.0.1", self.ports["primary"])).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        // A connection is made before the server has taken it, and what happens until then is not told to it. What
        // comes first stays.
        assert_eq!(stream.peek(&mut [0]).unwrap(), 1);
        Primary { stream }
    }

    /// Asks the server to end, as a service manager would, and waits for it.
    pub fn terminate(self) -> ExitStatus {
        send_signal(self.child.id(), "TERM");
        self.ended().0
    }

    /// Waits for its end; how long that took.
    pub fn ended(mut self) -> (ExitStatus, Duration) {
        let started = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                return (status, started.elapsed());
            }
            assert!(started.elapsed() < PATIENCE, "does not end");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Its process.
    pub fn process(&self) -> u32 {
        self.child.id()
    }

    /// A page of the http port: status and body.
    pub fn page(&self, path: &str) -> (u16, String) {
        let mut stream = TcpStream::connect(("127.0.0.1", self.ports["http"])).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let request =
            format!("GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        let (head, body) = answer.split_once("\r\n\r\n").unwrap_or((&answer, ""));
        let status = head
            .split(' ')
            .nth(1)
            .and_then(|status| status.parse().ok());
        (status.unwrap_or(0), body.to_owned())
    }

    /// `/healthz`.
    pub fn health(&self) -> (u16, serde_json::Value) {
        let (status, body) = self.page("/healthz");
        (status, serde_json::from_str(&body).unwrap())
    }

    /// Ends it without warning.
    pub fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Sends a signal by its name.
pub fn send_signal(process: u32, name: &str) {
    let sent = Command::new("kill")
        .args([&format!("-{name}"), &process.to_string()])
        .status();
    assert!(sent.unwrap().success());
}

fn log_of(folder: &Path) -> String {
    std::fs::read_to_string(folder.join("stderr.log")).unwrap_or_default()
}

/// A client of port 30001.
pub struct Primary {
    /// The connection.
    pub stream: TcpStream,
}

/// What the server sends on 30001.
#[derive(Debug)]
pub enum FromPrimary {
    /// Type 16.
    State(State),
    /// Type 20, kind 10: line, column, text.
    ScriptError(i32, i32, String),
    /// Type 20, kind 6: code, sub code.
    RobotError(i32, i32),
}

/// The few fields of a state message that tests look at.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    pub task_running: bool,
    pub task_paused: bool,
    pub robot_mode: u8,
    pub protective_stopped: bool,
    pub actual_q: [f64; 6],
    pub target_q: [f64; 6],
    pub tcp_pose: [f64; 6],
    pub digital_out: u32,
}

impl Primary {
    /// Sends text.
    pub fn send(&mut self, text: &str) {
        self.stream.write_all(text.as_bytes()).unwrap();
    }

    /// The next message.
    pub fn next(&mut self) -> FromPrimary {
        let mut head = [0; 5];
        self.stream.read_exact(&mut head).unwrap();
        let length = u32::from_be_bytes(head[..4].try_into().unwrap()) as usize;
        assert!((6..10_000).contains(&length), "length {length}");
        let mut message = head.to_vec();
        message.resize(length, 0);
        self.stream.read_exact(&mut message[5..]).unwrap();
        match message[4] {
            16 => FromPrimary::State(State::decode(&message)),
            20 => decode_exception(&message),
            other => panic!("message type {other}"),
        }
    }

    /// The next state message; other messages are skipped.
    pub fn state(&mut self) -> State {
        loop {
            if let FromPrimary::State(state) = self.next() {
                return state;
            }
        }
    }

    /// The first state for which `wanted` holds.
    pub fn wait_for(&mut self, what: &str, wanted: impl Fn(&State) -> bool) -> State {
        let started = Instant::now();
        loop {
            let state = self.state();
            if wanted(&state) {
                return state;
            }
            assert!(started.elapsed() < PATIENCE, "{what}: {state:?}");
        }
    }

    /// The next script error.
    pub fn script_error(&mut self) -> (i32, i32, String) {
        let started = Instant::now();
        loop {
            if let FromPrimary::ScriptError(line, column, text) = self.next() {
                return (line, column, text);
            }
            assert!(started.elapsed() < PATIENCE, "no script error");
        }
    }
}

impl State {
    fn decode(message: &[u8]) -> Self {
        assert_eq!(message.len(), 1157);
        let f64_at = |at: usize| f64::from_be_bytes(message[at..at + 8].try_into().unwrap());
        let u32_at = |at: usize| u32::from_be_bytes(message[at..at + 4].try_into().unwrap());
        // Offsets of the sub-packages in the fixed order of the protocol page.
        let (mode, joints) = (5, 5 + 53);
        let cartesian = joints + 347;
        let masterboard = cartesian + 101 + 445;
        let joint = |j: usize, field: usize| f64_at(joints + 5 + 57 * j + field);
        Self {
            protective_stopped: message[mode + 17] != 0,
            task_running: message[mode + 18] != 0,
            task_paused: message[mode + 19] != 0,
            robot_mode: message[mode + 20],
            actual_q: std::array::from_fn(|j| joint(j, 0)),
            target_q: std::array::from_fn(|j| joint(j, 8)),
            tcp_pose: std::array::from_fn(|k| f64_at(cartesian + 5 + 8 * k)),
            digital_out: u32_at(masterboard + 9),
        }
    }
}

fn decode_exception(message: &[u8]) -> FromPrimary {
    let i32_at = |at: usize| i32::from_be_bytes(message[at..at + 4].try_into().unwrap());
    match message[14] {
        10 => {
            let text = String::from_utf8(message[23..].to_vec()).unwrap();
            FromPrimary::ScriptError(
                i32_at(15),
                i32_at(19),
                text.trim_end_matches('\0').to_owned(),
            )
        }
        6 => FromPrimary::RobotError(i32_at(15), i32_at(19)),
        other => panic!("exception kind {other}"),
    }
}

/// A recording, read back with the public reader.
pub struct Recording {
    /// Every cycle.
    pub cycles: Vec<CycleMessage>,
    /// JSON messages by topic.
    pub json: BTreeMap<String, Vec<serde_json::Value>>,
    /// Texts of `/log`.
    pub log: Vec<String>,
    /// Number of messages by topic.
    pub counts: BTreeMap<String, usize>,
}

/// Reads a recording.
pub fn read_recording(path: &Path) -> Recording {
    let bytes = std::fs::read(path).unwrap();
    let mut recording = Recording {
        cycles: Vec::new(),
        json: BTreeMap::new(),
        log: Vec::new(),
        counts: BTreeMap::new(),
    };
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let topic = message.channel.topic.clone();
        *recording.counts.entry(topic.clone()).or_default() += 1;
        match topic.as_str() {
            "/cycle" => recording
                .cycles
                .push(prost::Message::decode(&*message.data).unwrap()),
            "/log" => recording
                .log
                .push(String::from_utf8_lossy(&message.data).into_owned()),
            _ if message.channel.message_encoding == "json" => {
                let value = serde_json::from_slice(&message.data).unwrap();
                recording.json.entry(topic).or_default().push(value);
            }
            _ => {}
        }
    }
    recording
}

/// Runs `eliteserver run` on a program text.
pub fn run_script(folder: &Path, text: &str, options: &[&str]) -> Output {
    let script = folder.join("program.script");
    std::fs::write(&script, text).unwrap();
    eliteserver()
        .arg("run")
        .arg(&script)
        .args(options)
        .current_dir(folder)
        .output()
        .unwrap()
}

/// Runs a program in a cell; what it printed, what it said, and its exit status.
pub fn run_in_cell(text: &str, cell: &str, options: &[&str]) -> (String, String, Option<i32>) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cell.toml"), cell).unwrap();
    let options = [&["--cell", "cell.toml"], options].concat();
    let output = run_script(folder.path(), text, &options);
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (
        text(&output.stdout),
        text(&output.stderr),
        output.status.code(),
    )
}

/// The example program of the README.
pub fn first_light() -> String {
    std::fs::read_to_string(example_path()).unwrap()
}

/// Where it is.
pub fn example_path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/first_light.script")
}

/// A client of the dashboard, which asks a line at a time.
pub struct Dashboard(BufReader<TcpStream>);

impl Dashboard {
    pub fn connect(server: &Server) -> Self {
        let stream = TcpStream::connect(("127.0.0.1", server.ports["dashboard"])).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let mut dashboard = Self(BufReader::new(stream));
        // The greeting comes in one piece.
        let greeting = dashboard.0.fill_buf().unwrap().len();
        dashboard.0.consume(greeting);
        dashboard
    }

    pub fn line(&mut self) -> String {
        let mut line = String::new();
        self.0.read_line(&mut line).unwrap();
        line.trim_end().to_owned()
    }

    pub fn ask(&mut self, command: &str) -> String {
        writeln!(self.0.get_mut(), "{command}").unwrap();
        self.line()
    }
}
