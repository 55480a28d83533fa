//! Programs, tasks and interpreter mode over the real ports, as readable transcripts with the virtual clock.
//!
//! One file of `tests/transcripts/` is one scenario on a server of its own. Lines of a file:
//!
//! - `# text`: a comment; the first says what is shown and where the manual says so.
//! - `! options ARGS`: how the server is started, beside the usual.
//! - `> NAME text`: a line that NAME sends, with its newline. Names that begin with `p` are clients of port 30001, with
//!   `i` of port 30020; a client connects when it is first named. Lines of one client that follow each other go out in
//!   one piece. `>> NAME text` sends bytes as they are, with the escapes `\n`, `\r`, `\\` and `\xFF`.
//! - `! wait STATE`: until the task is stopped, running or paused; `! wait interpreter`: until that mode is active;
//!   `! wait moving`: until the arm moves.
//! - `! repeat N NAME text`: sends a line N times; `! collect N NAME`: takes N acknowledgements. `! close NAME`: ends
//!   the connection, `! end NAME`: its sending half. `! quiet NAME`: nothing comes. `! restarts N NAME`: see the code.
//! - `< NAME text`: a line that NAME receives. On port 30001 that is the next exception, states are left out. NAME may
//!   also be `log` (what programs write), `panel.KEY` (a part of the page `/panel`) or `file.PATH` (a log file).
//!
//! `UPDATE_TRANSCRIPTS=1` writes what was received into the files; the difference is what has to be reviewed.

#![allow(clippy::unwrap_used, reason = "a test helper fails by panicking")]

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use crate::common::{self, FromPrimary, Primary, Server, alone};
use serde_json::Value;

/// How long something that must come may take.
const PATIENCE: Duration = Duration::from_secs(30);

/// How long nothing has to come to count as nothing.
const QUIET: Duration = Duration::from_millis(60);

/// Scenarios at once.
const WORKERS: usize = 3;

#[test]
fn every_transcript_is_what_the_server_does() {
    let _machine = alone();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/transcripts");
    let only = std::env::var("TRANSCRIPT").unwrap_or_default();
    let mut files: Vec<PathBuf> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "txt"))
        .filter(|path| path.to_string_lossy().contains(&only))
        .collect();
    files.sort();
    assert!(!only.is_empty() || files.len() >= 40, "{}", files.len());
    let waiting = Mutex::new(files.into_iter());
    let failures = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..WORKERS {
            scope.spawn(|| {
                loop {
                    let Some(file) = waiting.lock().unwrap().next() else {
                        return;
                    };
                    let played = std::panic::catch_unwind(|| play(&file));
                    let failure = match played {
                        Ok(Ok(())) => continue,
                        Ok(Err(failure)) => failure,
                        Err(_) => format!("{} panicked", file.display()),
                    };
                    failures.lock().unwrap().push(failure);
                }
            });
        }
    });
    let failures = failures.into_inner().unwrap();
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}

#[test]
fn global_variables_are_recorded_when_they_change_ten_times_a_second_at_most() {
    let _machine = alone();
    let folder = tempfile::tempdir().unwrap();
    let program = "def main():\n  global n, name\n  name = 'part'\n  n = 0\n  while n < 250:\n    n = n + 1\n\
                   \x20   sync()\nend\n";
    let options = ["--plant", "ideal", "--record", "out.mcap"];
    let output = common::run_script(folder.path(), program, &options);
    assert!(output.status.success(), "{output:?}");
    let recording = common::read_recording(&folder.path().join("out.mcap"));
    let variables = &recording.json["/variables"];
    let of =
        |name: &str| -> Vec<&Value> { variables.iter().filter(|v| v["name"] == name).collect() };
    assert_eq!(of("name").len(), 1, "it never changes");
    assert_eq!(of("name")[0]["value"], "'part'");
    let numbers = of("n");
    // A second of simulated time, and the value at the end.
    assert!((10..=12).contains(&numbers.len()), "{numbers:?}");
    assert!(
        numbers
            .iter()
            .all(|v| v["type"] == "int" && v["program_id"] == 1)
    );
    assert_eq!(numbers.last().unwrap()["value"], "250");
}

/// Plays one file; the difference, if there is one.
fn play(file: &Path) -> Result<(), String> {
    let text = fs::read_to_string(file).unwrap();
    let name = file.file_stem().unwrap().to_string_lossy().into_owned();
    let update = std::env::var_os("UPDATE_TRANSCRIPTS").is_some();
    let options: Vec<&str> = text
        .lines()
        .filter_map(|line| line.strip_prefix("! options "))
        .flat_map(str::split_whitespace)
        .collect();
    let mut stage = Stage::new(&options);
    let lines: Vec<&str> = text.lines().collect();
    let mut seen = String::new();
    for (at, line) in lines.iter().enumerate() {
        let shown = stage
            .step(line, lines.get(at + 1).copied(), update)
            .map_err(|why| {
                format!(
                    "{name}.txt:{}: {line}\n  {why}\n{}",
                    at + 1,
                    stage.log_tail()
                )
            })?;
        let _ = writeln!(seen, "{shown}");
        if shown != *line && !update {
            return Err(format!(
                "{name}.txt:{}: expected\n  {line}\nbut it was\n  {shown}",
                at + 1
            ));
        }
    }
    stage
        .nothing_more()
        .map_err(|why| format!("{name}.txt: at the end {why}"))?;
    if update && seen != text {
        fs::write(file, seen).unwrap();
    }
    Ok(())
}

/// A server with its clients.
struct Stage {
    folder: tempfile::TempDir,
    server: Server,
    primaries: BTreeMap<String, Primary>,
    interpreters: BTreeMap<String, BufReader<TcpStream>>,
    /// What goes out with the next line that is no `>` of the same client.
    unsent: String,
    /// How many lines of each file were read.
    lines_read: BTreeMap<String, usize>,
}

impl Stage {
    fn new(options: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut all = vec!["--plant", "ideal", "--record", "off"];
        if !options.contains(&"--clock") {
            all.extend(["--clock", "virtual"]);
        }
        all.extend(["--log-format", "json"]);
        all.extend(options);
        let server = Server::start(folder.path(), &all);
        Self {
            folder,
            server,
            primaries: BTreeMap::new(),
            interpreters: BTreeMap::new(),
            unsent: String::new(),
            lines_read: BTreeMap::new(),
        }
    }

    /// Plays one line; what it should have been.
    fn step(&mut self, line: &str, next: Option<&str>, update: bool) -> Result<String, String> {
        if let Some(sent) = line.strip_prefix("> ") {
            let (name, text) = sent.split_once(' ').unwrap_or((sent, ""));
            self.unsent.push_str(text);
            self.unsent.push('\n');
            let goes_on = next
                .and_then(|n| n.strip_prefix("> "))
                .is_some_and(|n| n.split_once(' ').map_or(n, |(name, _)| name) == name);
            if !goes_on {
                let text = std::mem::take(&mut self.unsent);
                self.send(name, text.as_bytes());
            }
        } else if let Some(sent) = line.strip_prefix(">> ") {
            let (name, text) = sent.split_once(' ').ok_or("`>> NAME text`")?;
            self.send(name, &unescape(text));
        } else if let Some(order) = line.strip_prefix("! ") {
            self.order(order)?;
        } else if let Some(received) = line.strip_prefix("< ") {
            let (name, wanted) = received.split_once(' ').unwrap_or((received, ""));
            let text = self.receive(name, wanted, update)?;
            return Ok(format!("< {name} {text}").trim_end().to_owned());
        } else if !(line.is_empty() || line.starts_with('#')) {
            return Err("not a line of a transcript".to_owned());
        }
        Ok(line.to_owned())
    }

    fn send(&mut self, name: &str, bytes: &[u8]) {
        if name.starts_with('p') {
            self.primary(name).stream.write_all(bytes).unwrap();
        } else {
            self.interpreter(name).get_mut().write_all(bytes).unwrap();
        }
    }

    fn primary(&mut self, name: &str) -> &mut Primary {
        let server = &self.server;
        self.primaries
            .entry(name.to_owned())
            .or_insert_with(|| server.primary())
    }

    fn interpreter(&mut self, name: &str) -> &mut BufReader<TcpStream> {
        let port = self.server.ports["interpreter"];
        self.interpreters.entry(name.to_owned()).or_insert_with(|| {
            let stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
            stream.set_nodelay(true).unwrap();
            stream.set_read_timeout(Some(PATIENCE)).unwrap();
            BufReader::new(stream)
        })
    }

    fn order(&mut self, order: &str) -> Result<(), String> {
        let words: Vec<&str> = order.split(' ').collect();
        match words[..] {
            ["options", ..] => {}
            ["wait", "moving"] => self.wait_until_moving()?,
            ["wait", "interpreter"] => self.wait_for("interpreter", "active")?,
            ["wait", state] => self.wait_for("task", state)?,
            ["connect", name] if name.starts_with('p') => drop(self.primary(name)),
            ["connect", name] => drop(self.interpreter(name)),
            ["repeat", count, name, ..] => {
                let text = words[3..].join(" ") + "\n";
                let count: usize = count.parse().map_err(|_| "a count")?;
                self.send(name, text.repeat(count).as_bytes());
            }
            ["close", name] => {
                if let Some(primary) = self.primaries.remove(name) {
                    let _ = primary.stream.shutdown(Shutdown::Both);
                }
                drop(self.interpreters.remove(name));
            }
            ["end", name] => {
                let stream = match self.primaries.get(name) {
                    Some(primary) => &primary.stream,
                    None => self.interpreter(name).get_ref(),
                };
                stream
                    .shutdown(Shutdown::Write)
                    .map_err(|e| e.to_string())?;
            }
            ["collect", count, name] => {
                let count: usize = count.parse().map_err(|_| "a count")?;
                for _ in 0..count {
                    let line = self.receive(name, "", false)?;
                    if !line.starts_with("ack: ") {
                        return Err(line);
                    }
                }
            }
            ["restarts", count, name] => {
                self.restart(count.parse().map_err(|_| "a count")?, name)?
            }
            ["quiet", name] => self.quiet(name)?,
            _ => return Err("no such order".to_owned()),
        }
        Ok(())
    }

    fn wait_until_moving(&mut self) -> Result<(), String> {
        let started = Instant::now();
        let first = self.primary("p").state().target_q;
        while self.primary("p").state().target_q == first {
            if started.elapsed() > PATIENCE {
                return Err("the arm does not move".to_owned());
            }
        }
        Ok(())
    }

    /// Programs that run until they are stopped, each sent together with the stop of the one before.
    fn restart(&mut self, count: usize, name: &str) -> Result<(), String> {
        for n in 1..=count {
            let program = format!(
                "stop task\ndef loop():\n  textmsg(\"run {n}\")\n  while True:\n    sync()\nend\n"
            );
            self.send(name, program.as_bytes());
            let line = self.receive("log", "", false)?;
            if line != format!("loop info: run {n}") {
                return Err(line);
            }
        }
        self.send(name, b"stop task\n");
        self.wait_for("task", "stopped")
    }

    fn wait_for(&self, key: &str, wanted: &str) -> Result<(), String> {
        let started = Instant::now();
        loop {
            let panel = self.panel();
            if panel[key] == wanted {
                return Ok(());
            }
            if started.elapsed() > PATIENCE {
                return Err(format!("the panel stays at {panel}"));
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    fn panel(&self) -> Value {
        let mut stream = TcpStream::connect(("127.0.0.1", self.server.ports["http"])).unwrap();
        stream
            .write_all(b"GET /panel HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
            .unwrap();
        let mut page = String::new();
        stream.read_to_string(&mut page).unwrap();
        serde_json::from_str(page.split_once("\r\n\r\n").unwrap().1).unwrap()
    }

    fn receive(&mut self, name: &str, wanted: &str, update: bool) -> Result<String, String> {
        if let Some(key) = name.strip_prefix("panel.") {
            return Ok(self.panel_part(key, wanted, update));
        }
        if name == "log" {
            return self.next_line(name, |stage| stage.script_log());
        }
        if let Some(path) = name.strip_prefix("file.") {
            return self.next_line(name, |stage| {
                let text = fs::read_to_string(stage.folder.path().join(path)).unwrap_or_default();
                // The first word is the time.
                let lines = text.lines();
                lines
                    .map(|l| l.split_once(' ').map_or("", |(_, rest)| rest).to_owned())
                    .collect()
            });
        }
        if name.starts_with('p') {
            return next_exception(self.primary(name), PATIENCE).ok_or("nothing came".to_owned());
        }
        let mut line = String::new();
        match self.interpreter(name).read_line(&mut line) {
            Ok(0) => Ok("(closed)".to_owned()),
            Ok(_) => Ok(shorten(line.trim_end_matches('\n'))),
            Err(error) => Err(format!("nothing came: {error}")),
        }
    }

    /// A part of the page `/panel`, given time to become what is wanted.
    fn panel_part(&self, key: &str, wanted: &str, update: bool) -> String {
        let started = Instant::now();
        let patience = if update {
            Duration::from_millis(300)
        } else {
            PATIENCE
        };
        loop {
            let part = self.panel()[key].to_string();
            if (part == wanted && !update) || started.elapsed() > patience {
                return part;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// The next line of something that grows.
    fn next_line(
        &mut self,
        name: &str,
        lines: impl Fn(&Self) -> Vec<String>,
    ) -> Result<String, String> {
        let started = Instant::now();
        let read = self.lines_read.get(name).copied().unwrap_or(0);
        loop {
            if let Some(line) = lines(self).into_iter().nth(read) {
                self.lines_read.insert(name.to_owned(), read + 1);
                return Ok(shorten(&line));
            }
            if started.elapsed() > PATIENCE {
                return Err("nothing came".to_owned());
            }
            std::thread::sleep(Duration::from_millis(3));
        }
    }

    /// What programs and their trouble wrote into the server's log: `program level: text`, errors with their last line.
    fn script_log(&self) -> Vec<String> {
        let log = fs::read_to_string(self.folder.path().join("stderr.log")).unwrap_or_default();
        let complete = log.rfind('\n').map_or("", |end| &log[..end]);
        let entries = complete
            .lines()
            .filter_map(|l| serde_json::from_str::<Value>(l).ok());
        entries
            .filter(|entry| entry["target"] == "script" && entry["level"] != "DEBUG")
            .map(|entry| {
                let level = entry["level"].as_str().unwrap_or_default().to_lowercase();
                let text = entry["message"].as_str().unwrap_or_default();
                let last = text.lines().last().unwrap_or_default();
                // The outermost span is the program; what is of no program is the controller's.
                let program = entry["spans"][0]["called"].as_str();
                format!("{} {level}: {last}", program.unwrap_or("controller"))
            })
            .collect()
    }

    fn log_tail(&self) -> String {
        let log = fs::read_to_string(self.folder.path().join("stderr.log")).unwrap_or_default();
        let lines: Vec<&str> = log.lines().collect();
        lines[lines.len().saturating_sub(6)..].join("\n")
    }

    fn quiet(&mut self, name: &str) -> Result<(), String> {
        if let Some(primary) = self.primaries.get_mut(name) {
            return match next_exception(primary, QUIET) {
                None => Ok(()),
                Some(text) => Err(format!("{name} received {text}")),
            };
        }
        if let Some(reader) = self.interpreters.get_mut(name) {
            reader.get_ref().set_read_timeout(Some(QUIET)).unwrap();
            let mut line = String::new();
            let read = reader.read_line(&mut line);
            reader.get_ref().set_read_timeout(Some(PATIENCE)).unwrap();
            if matches!(read, Ok(n) if n > 0) {
                return Err(format!("{name} received {line}"));
            }
        }
        if name == "log" {
            std::thread::sleep(QUIET);
            let read = self.lines_read.get(name).copied().unwrap_or(0);
            if let Some(line) = self.script_log().get(read) {
                return Err(format!("the log has {line}"));
            }
        }
        Ok(())
    }

    /// Nobody has anything unread.
    fn nothing_more(&mut self) -> Result<(), String> {
        let names: Vec<String> = self
            .interpreters
            .keys()
            .chain(self.primaries.keys())
            .cloned()
            .collect();
        names.iter().try_for_each(|name| self.quiet(name))?;
        self.quiet("log")
    }
}

/// The next exception as `error LINE:COLUMN text` (its last line) or `robot CODE/SUB`; `None` when none comes in time.
fn next_exception(primary: &mut Primary, patience: Duration) -> Option<String> {
    let started = Instant::now();
    // States come ten times a second, so a read never waits for long.
    while started.elapsed() < patience {
        match primary.next() {
            FromPrimary::State(_) => {}
            FromPrimary::ScriptError(line, column, text) => {
                let last = text.lines().last().unwrap_or_default();
                return Some(shorten(&format!("error {line}:{column} {last}")));
            }
            FromPrimary::RobotError(code, sub_code) => {
                return Some(format!("robot {code}/{sub_code}"));
            }
        }
    }
    None
}

/// Long lines are shown by their ends.
/// The port numbers of clients differ from run to run: `127.0.0.1:*`.
fn without_ports(line: &str) -> String {
    const HOST: &str = "127.0.0.1:";
    let mut parts = line.split(HOST);
    let mut shown = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let rest = part.trim_start_matches(|c: char| c.is_ascii_digit());
        shown = shown + HOST + "*" + rest;
    }
    shown
}

fn shorten(line: &str) -> String {
    let line = &without_ports(line);
    let count = line.chars().count();
    if count <= 300 {
        return line.to_owned();
    }
    let start: String = line.chars().take(60).collect();
    let end: String = line.chars().skip(count - 60).collect();
    format!("{start} ... {end} ({count} characters)")
}

fn unescape(text: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut rest = text.as_bytes();
    while let Some((first, after)) = rest.split_first() {
        let (byte, used) = match (first, after.first()) {
            (b'\\', Some(b'n')) => (b'\n', 2),
            (b'\\', Some(b'r')) => (b'\r', 2),
            (b'\\', Some(b't')) => (b'\t', 2),
            (b'\\', Some(b'x')) => {
                let digits = std::str::from_utf8(&after[1..3]).unwrap();
                (u8::from_str_radix(digits, 16).unwrap(), 4)
            }
            (b'\\', Some(b'\\')) => (b'\\', 2),
            (first, _) => (*first, 1),
        };
        bytes.push(byte);
        rest = &rest[used..];
    }
    bytes
}
