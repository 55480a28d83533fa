//! `eliteserver fleet` with real processes: start, pages, a robot that dies, one that cannot start, rolling restart,
//! the end.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "test helpers fail by panicking"
)]

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use serde_json::Value as Json;

/// Longest time a step may take.
const PATIENCE: Duration = Duration::from_secs(60);

struct Fleet {
    child: Child,
    page: u16,
}

/// A port that nobody has now.
fn free_port() -> u16 {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    listener.local_addr().unwrap().port()
}

/// A fleet of robots on addresses of this network, `127.0.N.…`, so that tests beside each other do not meet.
fn file(folder: &Path, network: u8, names: &[&str], more: &str) -> u16 {
    let page = free_port();
    let mut text = format!("http-port = {page}\n{more}\n");
    for (index, name) in names.iter().enumerate() {
        let address = format!("127.0.{network}.{}", 11 + index);
        text.push_str(&format!(
            "[[robot]]\nname = \"{name}\"\nbind = \"{address}\"\n"
        ));
    }
    std::fs::write(folder.join("fleet.toml"), text).unwrap();
    page
}

impl Fleet {
    fn start(folder: &Path, page: u16) -> Self {
        let log = std::fs::File::create(folder.join("fleet.log")).unwrap();
        let child = Command::new(env!("CARGO_BIN_EXE_eliteserver"))
            .args(["fleet", "fleet.toml"])
            .current_dir(folder)
            .env_remove("RUST_LOG")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(log)
            .spawn()
            .unwrap();
        Self { child, page }
    }

    /// The head and the body of a page, once it is there.
    fn get(&self, path: &str, headers: &str) -> Option<(String, String)> {
        let mut stream = TcpStream::connect(("127.0.0.1", self.page)).ok()?;
        let request = format!("GET {path} HTTP/1.1\r\nConnection: close\r\n{headers}\r\n");
        stream.write_all(request.as_bytes()).ok()?;
        let mut text = String::new();
        stream.read_to_string(&mut text).ok()?;
        let (head, body) = text.split_once("\r\n\r\n")?;
        Some((head.to_owned(), body.to_owned()))
    }

    fn own(&self, path: &str) -> Option<(String, String)> {
        self.get(path, &format!("Host: 127.0.0.1:{}\r\n", self.page))
    }

    /// The health of all, once it is as wanted.
    fn until(&self, mut wanted: impl FnMut(&Json) -> bool) -> Json {
        let since = Instant::now();
        loop {
            let health = self.own("/healthz").map(|(_, body)| body);
            let health: Json =
                health.map_or(Json::Null, |body| serde_json::from_str(&body).unwrap());
            if wanted(&health) {
                return health;
            }
            assert!(since.elapsed() < PATIENCE, "{health}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    fn signal(&self, signal: Signal) {
        kill(Pid::from_raw(self.child.id() as i32), signal).unwrap();
    }

    fn ended(&mut self) -> Option<i32> {
        let since = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                return status.code();
            }
            assert!(since.elapsed() < PATIENCE, "the fleet stays");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

impl Drop for Fleet {
    fn drop(&mut self) {
        // One that is gone already is as good; its robots end with it.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn pid(health: &Json, robot: &str) -> i32 {
    i32::try_from(health["robots"][robot]["pid"].as_i64().unwrap()).unwrap()
}

fn is_there(pid: i32) -> bool {
    // One that has ended and is not waited for yet does not count.
    let status = std::fs::read_to_string(format!("/proc/{pid}/stat"));
    status.is_ok_and(|stat| !stat.contains(") Z "))
}

fn gone(pids: &[i32]) {
    let since = Instant::now();
    while pids.iter().any(|pid| is_there(*pid)) {
        assert!(since.elapsed() < PATIENCE, "a robot stays");
        std::thread::sleep(Duration::from_millis(20));
    }
}

const QUIET: &str = "[defaults]\nplant = \"ideal\"\nrecord = \"off\"\nstep-ms = 8\n";

#[test]
fn robots_start_are_seen_started_again_and_end_together() {
    let folder = tempfile::tempdir().unwrap();
    let page = file(folder.path(), 41, &["left", "right", "spare"], QUIET);
    let mut fleet = Fleet::start(folder.path(), page);
    let health = fleet.until(|health| health["status"] == "ok");
    let robots = health["robots"].as_object().unwrap();
    assert_eq!(robots.len(), 3);
    for (index, robot) in ["left", "right", "spare"].iter().enumerate() {
        let address = format!("127.0.41.{}", 11 + index);
        assert_eq!(robots[*robot]["address"], address);
        assert_eq!(robots[*robot]["ports"]["primary"], 30001);
        let waited = Command::new(env!("CARGO_BIN_EXE_eliteserver"))
            .args(["wait", "--host", &address, "--timeout", "20"])
            .status()
            .unwrap();
        assert!(waited.success());
    }

    let (_, table) = fleet.own("/").unwrap();
    for part in [
        "http://127.0.41.12:8080/",
        ">right</a>",
        "/logs/spare",
        "class=\"ready\"",
    ] {
        assert!(table.contains(part), "{part}: {table}");
    }
    let (_, metrics) = fleet.own("/metrics").unwrap();
    for robot in ["left", "right", "spare"] {
        assert!(metrics.contains(&format!("elite_fleet_robot_up{{robot=\"{robot}\"}} 1")));
        let cycles = metrics.lines().filter(|line| {
            !line.starts_with('#')
                && line.contains("cycle")
                && line.contains(&format!("robot=\"{robot}\""))
        });
        assert!(cycles.count() > 0, "{metrics}");
    }
    let types = metrics.lines().filter(|line| line.starts_with("# TYPE"));
    let mut types: Vec<&str> = types.collect();
    let count = types.len();
    types.sort_unstable();
    types.dedup();
    assert_eq!(types.len(), count, "a family stands twice");
    let (_, log) = fleet.own("/logs/left").unwrap();
    assert!(log.contains("primary on 127.0.41.11:30001"), "{log}");
    assert!(fleet.own("/logs/nobody").unwrap().0.contains("404"));

    // Pages of others, and names that lead here.
    for headers in [
        "Host: robots.example\r\n",
        &format!("Host: 127.0.0.1:{page}\r\nOrigin: http://evil.example\r\n"),
    ] {
        let (head, _) = fleet.get("/healthz", headers).unwrap();
        assert!(head.starts_with("HTTP/1.1 403"), "{head}");
    }

    // One dies.
    let killed = pid(&health, "right");
    kill(Pid::from_raw(killed), Signal::SIGKILL).unwrap();
    let health = fleet
        .until(|health| health["status"] == "ok" && health["robots"]["right"]["restarts"] == 1);
    assert_ne!(pid(&health, "right"), killed);
    assert!(
        health["robots"]["right"]["last_end"]
            .as_str()
            .unwrap()
            .contains("signal")
    );
    assert_eq!(health["robots"]["left"]["restarts"], 0);

    let pids: Vec<i32> = ["left", "right", "spare"]
        .iter()
        .map(|robot| pid(&health, robot))
        .collect();
    fleet.signal(Signal::SIGTERM);
    assert_eq!(fleet.ended(), Some(0));
    gone(&pids);
}

#[test]
fn robots_are_restarted_one_after_the_other_with_the_file_as_it_is_now() {
    let folder = tempfile::tempdir().unwrap();
    let page = file(folder.path(), 42, &["a", "b"], QUIET);
    let mut fleet = Fleet::start(folder.path(), page);
    let before = fleet.until(|health| health["status"] == "ok");
    let path = folder.path().join("fleet.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    // A mistake restarts nothing.
    std::fs::write(&path, format!("{text}modle = \"x\"\n")).unwrap();
    fleet.signal(Signal::SIGHUP);
    let log = || std::fs::read_to_string(folder.path().join("fleet.log")).unwrap();
    let since = Instant::now();
    while !log().contains("nothing is restarted") {
        assert!(since.elapsed() < PATIENCE, "{}", log());
        std::thread::sleep(Duration::from_millis(20));
    }
    std::fs::write(&path, text.replace("step-ms = 8", "step-ms = 5")).unwrap();
    fleet.signal(Signal::SIGHUP);
    let mut both_down = false;
    let after = fleet.until(|health| {
        let is_ready = |robot: &str| health["robots"][robot]["state"] == "ready";
        both_down |= health["robots"].is_object() && !is_ready("a") && !is_ready("b");
        let is_new = |robot: &str| health["robots"][robot]["pid"] != before["robots"][robot]["pid"];
        health["status"] == "ok" && is_new("a") && is_new("b")
    });
    assert!(!both_down, "both were down at once");
    assert_eq!(after["robots"]["a"]["restarts"], 0, "that was asked for");
    let config = std::fs::read_to_string(folder.path().join("fleet/b/robot.toml")).unwrap();
    assert!(
        config.contains("step-ms = 5") && config.contains("cycle-phase-us = 2500"),
        "{config}"
    );
    let pids = [pid(&after, "a"), pid(&after, "b")];
    // A fleet that is gone without a word takes its robots along.
    fleet.child.kill().unwrap();
    gone(&pids);
    assert_eq!(fleet.ended(), None);
}

#[test]
fn a_robot_that_cannot_start_is_tried_again_with_pauses_and_the_others_run() {
    let folder = tempfile::tempdir().unwrap();
    let page = file(
        folder.path(),
        43,
        &["good", "bad"],
        &format!("{QUIET}memory = \"1GB\"\n"),
    );
    // Somebody has a port of the second.
    let _taken = std::net::TcpListener::bind("127.0.43.12:30001").unwrap();
    let fleet = Fleet::start(folder.path(), page);
    let health =
        fleet.until(|health| health["robots"]["bad"]["restarts"].as_u64().unwrap_or(0) >= 2);
    assert_eq!(health["status"], "not well");
    let health = fleet.until(|health| health["robots"]["good"]["status"] == "ok");
    assert!(health["robots"]["good"]["memory_bytes"].as_u64().unwrap() > 1_000_000);
    let (head, _) = fleet.own("/healthz").unwrap();
    assert!(head.starts_with("HTTP/1.1 503"), "{head}");
    let (_, log) = fleet.own("/logs/bad").unwrap();
    assert!(log.contains("127.0.43.12:30001 is in use"), "{log}");
    let (_, table) = fleet.own("/").unwrap();
    assert!(
        table.contains("waiting") || table.contains("starting"),
        "{table}"
    );
}

#[test]
fn a_robot_that_holds_too_much_is_started_again() {
    let folder = tempfile::tempdir().unwrap();
    let page = file(
        folder.path(),
        44,
        &["big"],
        &format!("{QUIET}memory = \"1MB\"\n"),
    );
    let fleet = Fleet::start(folder.path(), page);
    let health =
        fleet.until(|health| health["robots"]["big"]["restarts"].as_u64().unwrap_or(0) >= 1);
    let why = health["robots"]["big"]["last_end"].as_str().unwrap();
    assert!(why.contains("MB are allowed"), "{why}");
}

#[test]
fn a_file_is_checked_without_starting_anything() {
    let folder = tempfile::tempdir().unwrap();
    file(folder.path(), 45, &["a", "b"], QUIET);
    let check = || {
        let output = Command::new(env!("CARGO_BIN_EXE_eliteserver"))
            .args(["fleet", "--check", "fleet.toml"])
            .current_dir(folder.path())
            .output()
            .unwrap();
        (
            output.status.code(),
            String::from_utf8(output.stderr).unwrap(),
        )
    };
    let (status, told) = check();
    assert_eq!(status, Some(0));
    assert!(told.contains("2 robots can be started"), "{told}");
    assert!(!folder.path().join("fleet").exists());
    std::fs::write(
        folder.path().join("fleet.toml"),
        "[[robot]]\nname = \"a\"\nstep-ms = 99\n",
    )
    .unwrap();
    let (status, told) = check();
    assert_eq!(status, Some(2));
    assert!(
        told.contains("robot a: fleet.toml: `step-ms` is 99"),
        "{told}"
    );
}
