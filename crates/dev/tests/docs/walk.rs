//! Walks through a page as a reader would: one folder, block after block.
//!
//! `eliteserver` in commands is a small shell script in front of the binary that gives every page an address of its own
//! (127.x.y.z), so that pages with servers on the vendor's ports run beside each other and beside anything else.

use std::io::Read as _;
use std::os::unix::fs::PermissionsExt as _;
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU8, Ordering};
use std::time::{Duration, Instant};

use crate::debugger;
use crate::markdown::{Block, eliteserver, root};

/// Longest time a block may take.
const PATIENCE: Duration = Duration::from_secs(150);

/// The address that pages name for a robot elsewhere.
const ELSEWHERE: &str = "192.168.1.10";
const LOOPBACK: &str = "127.0.0.1";

/// A reader on the way through a page.
pub struct Walk {
    page: String,
    folder: tempfile::TempDir,
    /// What stands for 127.0.0.1 and for the robot elsewhere.
    address: String,
    background: Vec<Child>,
}

impl Drop for Walk {
    fn drop(&mut self) {
        self.end_background();
    }
}

impl Walk {
    pub fn new(page: &str) -> Self {
        static NUMBER: AtomicU8 = AtomicU8::new(1);
        let folder = tempfile::tempdir().unwrap();
        for part in ["examples", "robots"] {
            copy(&root().join(part), &folder.path().join(part));
        }
        let process = std::process::id();
        let address = format!(
            "127.{}.{}.{}",
            1 + (process >> 8) % 250,
            process % 256,
            NUMBER.fetch_add(1, Ordering::Relaxed)
        );
        let bin = folder.path().join(".bin");
        std::fs::create_dir(&bin).unwrap();
        let shim = format!(
            r#"#!/bin/sh
binary='{}'
case "${{1-}}" in
  ''|serve) [ $# -eq 0 ] || shift; exec "$binary" serve --bind {address} "$@" ;;
  --help|--version|-h|-V) exec "$binary" "$@" ;;
  -*) exec "$binary" serve --bind {address} "$@" ;;
  send|shell|record|calibrate)
    command=$1; shift
    case " $* " in *' --robot '*) ;; *) set -- --robot {address} "$@" ;; esac
    exec "$binary" "$command" "$@" ;;
  wait) shift; exec "$binary" wait --host {address} "$@" ;;
  *) exec "$binary" "$@" ;;
esac
"#,
            eliteserver().display()
        );
        std::fs::write(bin.join("eliteserver"), shim).unwrap();
        let executable = std::fs::Permissions::from_mode(0o755);
        std::fs::set_permissions(bin.join("eliteserver"), executable).unwrap();
        Self {
            page: page.to_owned(),
            folder,
            address,
            background: Vec::new(),
        }
    }

    fn end_background(&mut self) {
        for mut child in self.background.drain(..) {
            kill_group(&child);
            let _ = child.wait();
        }
    }

    /// One block.
    pub fn step(&mut self, block: &Block) {
        if block.has("no-run") {
            return;
        }
        if let Some(file) = block.attributes.get("file") {
            let path = self.folder.path().join(file);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, &block.text).unwrap();
            return;
        }
        if block.has("server") && self.background.is_empty() {
            self.start("eliteserver --task-dir .");
        }
        match &*block.language {
            "console" => self.console(block),
            "sh" => self.run_all(block),
            "python" if block.text.starts_with(">>>") => {} // those of the wheel (crates/pybind/tests/test_docs.py)
            "python" if block.text.contains("def test_") => self.test(block),
            "python" => self.program(block),
            "toml" => {
                let read = toml::from_str::<toml::Table>(&block.text);
                assert!(read.is_ok(), "{}: {read:?}", self.place(block));
            }
            "json" => {
                let read = serde_json::from_str::<serde_json::Value>(&block.text);
                assert!(read.is_ok(), "{}: {read:?}", self.place(block));
            }
            "yaml" => self.commands_of_ci(block),
            "text" if block.text.starts_with('→') => {
                debugger::session(&block.text, self.folder.path(), &self.place(block));
            }
            "text" | "lua" | "elisp" | "xml" | "ini" | "" => {}
            other => panic!("{}: nobody runs blocks of {other:?}", self.place(block)),
        }
    }

    fn place(&self, block: &Block) -> String {
        format!("{}:{}", self.page, block.line)
    }

    /// `$` begins a command; what follows is what it prints.
    fn console(&mut self, block: &Block) {
        let mut commands: Vec<(String, Vec<&str>)> = Vec::new();
        for line in block.text.lines() {
            if let Some(command) = line.strip_prefix("$ ") {
                commands.push((command.to_owned(), Vec::new()));
                continue;
            }
            let Some((command, expected)) = commands.last_mut() else {
                panic!(
                    "{}: a block of the console begins with a command",
                    self.place(block)
                );
            };
            if command.ends_with('\\') && expected.is_empty() {
                command.push('\n');
                command.push_str(line);
            } else {
                expected.push(line);
            }
        }
        if block.has("background") {
            // What is there before the server is made ready first.
            let (server, before) = commands.split_last().unwrap();
            for (command, _) in before {
                self.shell(command, block);
            }
            return self.start(&server.0);
        }
        // One shell for the block, so that variables and jobs go on; a mark before each command, with the status of the
        // last.
        let mut script = String::new();
        for (command, _) in &commands {
            script.push_str(&format!(
                "s=$?; printf '\\n@@%d@@\\n' $s; (exit $s)\n{command}\n"
            ));
        }
        script.push_str("s=$?; printf '\\n@@%d@@\\n' $s; (exit $s)\n");
        let told = self.shell(&script, block);
        let mut parts = told.split("@@\n");
        parts.next();
        for (command, expected) in &commands {
            let part = parts.next().unwrap_or("");
            let (said, status) = part.rsplit_once("@@").unwrap_or((part, "?"));
            let said: Vec<&str> = said.trim_matches('\n').lines().map(str::trim_end).collect();
            if expected.is_empty() {
                assert_eq!(
                    status,
                    "0",
                    "{}: $ {command}\n{}",
                    self.place(block),
                    said.join("\n")
                );
                continue;
            }
            let settled = |line: &str| match block.has("numbers") {
                true => without_numbers(&line.replace(ELSEWHERE, LOOPBACK)),
                false => line.trim_end().replace(ELSEWHERE, LOOPBACK),
            };
            let expected: Vec<String> = expected.iter().map(|line| settled(line)).collect();
            let compared: Vec<String> = said.iter().map(|line| settled(line)).collect();
            let compared: Vec<&str> = compared.iter().map(String::as_str).collect();
            assert!(
                lines_match(&expected, &compared),
                "{}: $ {command}\nthe page has:\n{}\nit said:\n{}",
                self.place(block),
                expected.join("\n"),
                said.join("\n")
            );
        }
    }

    fn run_all(&mut self, block: &Block) {
        if block.has("background") {
            return self.start(&block.text);
        }
        let told = self.shell(
            &format!("set -e\n{}\nprintf '\\n@@whole@@'\n", block.text),
            block,
        );
        assert!(
            told.ends_with("@@whole@@"),
            "{}: {}\n{told}",
            self.place(block),
            block.text
        );
    }

    /// A program without a name is run, and ends.
    fn program(&mut self, block: &Block) {
        let path = self.folder.path().join("block.script");
        std::fs::write(&path, &block.text).unwrap();
        let told = self.shell("eliteserver run block.script && echo @@ended@@", block);
        assert!(told.contains("@@ended@@"), "{}: {told}", self.place(block));
    }

    /// Tests are run beside the programs of the examples.
    fn test(&self, block: &Block) {
        let path = self
            .folder
            .path()
            .join("examples/testing/test_block.script");
        std::fs::write(&path, &block.text).unwrap();
        let told = self.shell(
            "eliteserver test examples/testing/test_block.script && echo @@ended@@",
            block,
        );
        assert!(told.contains("@@ended@@"), "{}: {told}", self.place(block));
    }

    /// Commands of a CI configuration that are ours, in a folder with tests.
    fn commands_of_ci(&mut self, block: &Block) {
        for line in block.text.lines() {
            let line = line.trim().trim_start_matches("- ");
            let command = line.strip_prefix("run: ").unwrap_or(line);
            if command.starts_with("eliteserver ") {
                let script =
                    format!("cd examples/testing && {command} >ci.log 2>&1 && echo @@ended@@");
                let told = self.shell(&script, block);
                assert!(
                    told.contains("@@ended@@"),
                    "{}: {command}\n{told}",
                    self.place(block)
                );
            }
        }
    }

    fn command(&self, script: &str) -> Command {
        let script = script
            .replace(ELSEWHERE, &self.address)
            .replace(LOOPBACK, &self.address);
        let path = format!(
            "{}:{}",
            self.folder.path().join(".bin").display(),
            std::env::var("PATH").unwrap()
        );
        let mut command = Command::new("bash");
        command
            .arg("-c")
            .arg(format!("exec 2>&1\n{script}"))
            .current_dir(self.folder.path())
            .env("PATH", path)
            .env("LC_ALL", "C.UTF-8")
            .env("NO_COLOR", "1")
            .env_remove("RUST_LOG")
            .stdin(Stdio::null())
            .process_group(0);
        command
    }

    /// What a script says, with the address the page has.
    fn shell(&self, script: &str, block: &Block) -> String {
        let log = self.folder.path().join(".said");
        let file = std::fs::File::create(&log).unwrap();
        let mut child = self.command(script).stdout(file).spawn().unwrap();
        let started = Instant::now();
        while child.try_wait().unwrap().is_none() {
            if started.elapsed() > PATIENCE {
                kill_group(&child);
                let _ = child.wait();
                panic!(
                    "{}: it took too long\n{}",
                    self.place(block),
                    std::fs::read_to_string(&log).unwrap_or_default()
                );
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        let mut told = Vec::new();
        std::fs::File::open(&log)
            .unwrap()
            .read_to_end(&mut told)
            .unwrap();
        String::from_utf8_lossy(&told).replace(&self.address, LOOPBACK)
    }

    /// Starts a server that stays until the page ends or starts another one, and waits for it.
    fn start(&mut self, script: &str) {
        self.end_background();
        let child = self.command(script).stdout(Stdio::null()).spawn().unwrap();
        self.background.push(child);
        let waited = self
            .command("eliteserver wait --timeout 60")
            .stdout(Stdio::null())
            .status();
        assert!(
            waited.unwrap().success(),
            "{}: {script}: no server answers",
            self.page
        );
    }
}

/// A shell and what it has started.
fn kill_group(shell: &Child) {
    let group = format!("-{}", shell.id());
    let _ = Command::new("kill")
        .args(["-KILL", "--", &group])
        .stderr(Stdio::null())
        .status();
}

/// The line with `#` for every number and one blank for several.
fn without_numbers(line: &str) -> String {
    let mut out = String::new();
    for word in line.split_whitespace() {
        if !out.is_empty() {
            out.push(' ');
        }
        let mut in_number = false;
        for c in word.chars() {
            let is_part = c.is_ascii_digit() || (in_number && c == '.');
            if is_part && !in_number && out.ends_with('-') {
                out.pop();
            }
            if !is_part {
                out.push(c);
            } else if !in_number {
                out.push('#');
            }
            in_number = is_part;
        }
    }
    out
}

/// `…` in a line of the page is any text, a line of it alone any lines.
fn lines_match(expected: &[impl AsRef<str>], said: &[&str]) -> bool {
    match expected.split_first() {
        None => said.is_empty(),
        Some((first, rest)) if first.as_ref().trim() == "…" => {
            (0..=said.len()).any(|skipped| lines_match(rest, &said[skipped..]))
        }
        Some((first, rest)) => said
            .split_first()
            .is_some_and(|(line, left)| is_like(first.as_ref(), line) && lines_match(rest, left)),
    }
}

fn is_like(pattern: &str, line: &str) -> bool {
    let mut parts = pattern.split('…');
    let Some(mut rest) = line.strip_prefix(parts.next().unwrap_or("")) else {
        return false;
    };
    let mut parts = parts.peekable();
    if parts.peek().is_none() {
        return rest.is_empty();
    }
    while let Some(part) = parts.next() {
        if parts.peek().is_none() {
            return rest.ends_with(part);
        }
        let Some(at) = rest.find(part) else {
            return false;
        };
        rest = &rest[at + part.len()..];
    }
    true
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let target = to.join(path.file_name().unwrap());
        match path.is_dir() {
            true => copy(&path, &target),
            false => drop(std::fs::copy(&path, &target).unwrap()),
        }
    }
}

#[test]
fn dots_stand_for_what_differs() {
    assert!(is_like("in … ms, all", "in 3 ms, all") && !is_like("in … ms", "in 3 s"));
    assert!(is_like("same", "same") && !is_like("same", "samed") && !is_like("a…b", "ab c"));
    assert!(lines_match(&["a", "…", "d"], &["a", "b", "c", "d"]));
    assert!(lines_match(&["…", "d"], &["d"]) && !lines_match(&["…", "d"], &["d", "e"]));
    assert_eq!(without_numbers("rms  -0.05 mm 12"), "rms # mm #");
    assert!(!lines_match(&["a"], &[]) && lines_match(&[] as &[&str], &[]));
}
