//! Recordings of a process that is killed, and of one whose disk is full.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test fails by panicking"
)]

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::common::{FromPrimary, PATIENCE, Server, eliteserver};
use recorder::{FileEnd, Recording, RecordingEntry, Topic};

/// What is on disk after a kill ends so long before it at the latest, s.
const LOST_MAX: f64 = 0.5;

const WAVE: &str = "def wave():
  while True:
    movej([0.4, -1.57, 1.57, -1.57, -1.57, 0], a=3, v=2)
    movej([-0.4, -1.57, 1.57, -1.57, -1.57, 0], a=3, v=2)
  end
end
";

/// Numbers that look random and are the same every time (Knuth's generator with the constants of MMIX).
struct Moments(u64);

impl Moments {
    fn next(&mut self, longest: Duration) -> Duration {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        longest.mul_f64((self.0 >> 11) as f64 / (1_u64 << 53) as f64)
    }
}

/// A page of the http port as JSON.
fn page(server: &Server, path: &str) -> serde_json::Value {
    let mut stream = TcpStream::connect(("127.0.0.1", server.ports["http"])).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    write!(
        stream,
        "GET {path} HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n"
    )
    .unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    let (_, body) = answer.split_once("\r\n\r\n").unwrap();
    serde_json::from_str(body).unwrap()
}

/// Opens a recording of a killed process: every cycle is there up to some moment, which is returned, s.
fn readable_until(path: &Path) -> f64 {
    let recording = Recording::open(path).unwrap();
    let mut entries = recording.entries(&Topic::ALL).unwrap();
    let (mut cycles, mut until) = (0, 0.0);
    for entry in &mut entries {
        if let (_, RecordingEntry::Cycle(cycle)) = entry.unwrap() {
            cycles += 1;
            assert_eq!(cycle.cycle, cycles, "{}", path.display());
            until = cycle.time;
        }
    }
    assert_eq!(
        entries.ending(),
        Some(&FileEnd::Truncated),
        "{}",
        path.display()
    );
    until
}

/// One server that is killed after a while; how much was lost, s.
fn killed_server(folder: &Path, after: Duration) -> f64 {
    let file = folder.join("killed.mcap");
    let options = ["--plant", "ideal", "--record", file.to_str().unwrap()];
    let server = Server::start(folder, &options);
    server.primary().send(WAVE);
    thread::sleep(after);
    // Simulated time right before; the clock of a busy machine may lag behind the one on the wall.
    let time = page(&server, "/healthz")["time_secs"].as_f64().unwrap();
    server.kill();
    time - readable_until(&file)
}

/// One run under the virtual clock that is killed a while after its file was begun.
fn killed_run(folder: &Path, after: Duration) -> f64 {
    let (script, file) = (folder.join("wave.script"), folder.join("run.mcap"));
    std::fs::write(&script, WAVE).unwrap();
    let mut run = eliteserver()
        .arg("run")
        .arg(&script)
        .args(["--plant", "ideal", "--record"])
        .arg(&file)
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let begin = Instant::now();
    while std::fs::metadata(&file).map_or(0, |data| data.len()) == 0 {
        assert!(begin.elapsed() < PATIENCE, "no recording");
        thread::sleep(Duration::from_millis(1));
    }
    thread::sleep(after);
    run.kill().unwrap();
    run.wait().unwrap();
    readable_until(&file)
}

#[test]
fn fifty_recordings_of_killed_processes_open_up_to_half_a_second_before_the_kill() {
    let workers: Vec<_> = (0..5_u64)
        .map(|worker| {
            thread::spawn(move || {
                let mut moments = Moments(worker);
                let mut lost = Vec::new();
                for round in 0..10 {
                    let folder = tempfile::tempdir().unwrap();
                    if round < 8 {
                        let after = moments.next(Duration::from_millis(900));
                        lost.push(killed_server(folder.path(), after));
                    } else {
                        killed_run(folder.path(), moments.next(Duration::from_millis(300)));
                    }
                }
                lost
            })
        })
        .collect();
    let lost: Vec<f64> = workers
        .into_iter()
        .flat_map(|w| w.join().unwrap())
        .collect();
    let most = lost.iter().copied().fold(0.0, f64::max);
    println!(
        "lost at most {most:.3} s, on average {:.3} s",
        lost.iter().sum::<f64>() / lost.len() as f64
    );
    assert_eq!(lost.len(), 40);
    assert!(most <= LOST_MAX, "{lost:?}");
}

#[test]
fn replay_says_that_the_writer_was_killed_and_up_to_when_the_file_is_readable() {
    let folder = tempfile::tempdir().unwrap();
    let until = killed_run(folder.path(), Duration::from_millis(100));
    let file = folder.path().join("run.mcap");
    let output = eliteserver().arg("replay").arg(file).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let ending = format!(
        "ending: cut, the recorder was killed or is still writing; readable up to {until:.3} s, the last complete \
         chunk\n"
    );
    assert!(output.status.success() && text.ends_with(&ending), "{text}");
}

#[test]
fn a_full_disk_is_one_alarm_on_30001_and_the_robot_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("full.mcap");
    let ready = folder.path().join("ready.json");
    let log = folder.path().join("stderr.log");
    // No file may become larger than 400 blocks of 512 bytes; with the signal ignored, writing more fails.
    let mut command = Command::new("sh");
    command
        .arg("-c")
        .arg("trap '' XFSZ; ulimit -f 400; exec \"$@\"")
        .arg("sh")
        .arg(env!("CARGO_BIN_EXE_eliteserver"))
        .args(["serve", "--plant", "ideal", "--record"])
        .arg(&file)
        .arg("--ready-file")
        .arg(&ready)
        .current_dir(&folder)
        .stderr(std::fs::File::create(&log).unwrap());
    for service in ["interpreter", "rtsi", "dashboard", "modbus"] {
        command.arg(format!("--{service}-port")).arg("off");
    }
    command.args(["--primary-port", "0", "--http-port", "0"]);
    let server = Server::adopt(command.spawn().unwrap(), &ready, folder.path());
    let mut primary = server.primary();
    primary.send(WAVE);
    let begin = Instant::now();
    let alarm = loop {
        assert!(begin.elapsed() < PATIENCE, "no alarm");
        if let FromPrimary::RobotError(code, sub_code) = primary.next() {
            break (code, sub_code);
        }
    };
    assert_eq!(alarm, (120, 0));
    // The robot goes on, and nothing more is said of it.
    let cycle = || page(&server, "/healthz")["cycle"].as_u64().unwrap();
    let before = cycle();
    let settled = Instant::now();
    let mut moved = Vec::new();
    while settled.elapsed() < Duration::from_millis(1500) {
        match primary.next() {
            FromPrimary::State(state) => moved.push(state.actual_q[0]),
            other => panic!("{other:?}"),
        }
    }
    assert!(cycle() > before + 200);
    let (low, high) = moved
        .iter()
        .fold((f64::MAX, f64::MIN), |(l, h), q| (l.min(*q), h.max(*q)));
    assert!(high - low > 0.3, "{low} to {high}");
    assert_eq!(page(&server, "/healthz")["recording"], "stopped");
    assert_eq!(server.terminate().code(), Some(1));

    let log = std::fs::read_to_string(log).unwrap();
    let said: Vec<&str> = log
        .lines()
        .filter(|line| line.contains("recording"))
        .collect();
    let alarms = said
        .iter()
        .filter(|line| line.contains("recording stopped, the robot goes on"))
        .count();
    assert_eq!((alarms, said.len()), (1, 2), "{log}");
    assert!(readable_until(&file) > 0.5);
}
