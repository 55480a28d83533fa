//! A stop, a pause and an abort act within a tenth of a second, whatever else the controller was sent and whatever
//! hangs.
//!
//! The programs hold a connection to the test, which sees to the millisecond when they end or go on.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "tests fail by panicking"
)]

use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::common::{self, FromPrimary, PATIENCE, Server, alone, read_recording};

/// What the contract allows (INTERFACES 7).
const PROMISED: Duration = Duration::from_millis(100);

const REAL: [&str; 4] = ["--plant", "ideal", "--record", "off"];

fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !is_so() {
        assert!(begin.elapsed() < PATIENCE, "{what}");
        thread::sleep(Duration::from_millis(2));
    }
}

/// Orders a fault and waits until the order has been taken.
fn order(folder: &Path, fault: &str) {
    let (beside, file) = (folder.join("faults.tmp"), folder.join("faults"));
    std::fs::write(&beside, format!("{fault}\n")).unwrap();
    std::fs::rename(beside, &file).unwrap();
    wait_until("the order is taken", || !file.exists());
}

fn connect(server: &Server, port: &str) -> TcpStream {
    let stream = TcpStream::connect(("127.0.0.1", server.ports[port])).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    stream.set_nodelay(true).unwrap();
    stream
}

/// How long threads of the server that could have run did not, because this machine has other things to do.
struct Busy {
    process: u32,
    before: BTreeMap<u32, Duration>,
}

impl Busy {
    fn since_now(server: &Server) -> Self {
        let process = server.process();
        Self {
            process,
            before: waited(process),
        }
    }

    /// What is allowed: an order goes through a handful of threads, one after the other.
    fn allowed(&self) -> Duration {
        let waited = waited(self.process).into_iter().map(|(thread, now)| {
            let before = self.before.get(&thread).copied().unwrap_or_default();
            now.saturating_sub(before)
        });
        PROMISED + waited.sum::<Duration>()
    }
}

/// By thread, how long it has waited for a processor.
fn waited(process: u32) -> BTreeMap<u32, Duration> {
    let threads = std::fs::read_dir(format!("/proc/{process}/task")).unwrap();
    let figures = threads.filter_map(|thread| {
        let thread = thread.ok()?;
        let number = thread.file_name().to_str()?.parse().ok()?;
        let text = std::fs::read_to_string(thread.path().join("schedstat")).ok()?;
        let nanos = text.split(' ').nth(1)?.trim().parse().ok()?;
        Some((number, Duration::from_nanos(nanos)))
    });
    figures.collect()
}

/// The other end of the connection that a program holds.
struct Watch {
    port: u16,
    seen: Arc<Mutex<Seen>>,
}

#[derive(Default, Clone, Copy)]
struct Seen {
    bytes: usize,
    last: Option<Instant>,
    ended: Option<Instant>,
}

impl Watch {
    fn begin() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let seen = Arc::<Mutex<Seen>>::default();
        let noted = seen.clone();
        thread::spawn(move || {
            let (mut stream, _) = listener.accept().unwrap();
            let mut bytes = [0; 4096];
            while let Ok(count @ 1..) = stream.read(&mut bytes) {
                let mut seen = noted.lock().unwrap();
                seen.bytes += count;
                seen.last = Some(Instant::now());
            }
            noted.lock().unwrap().ended = Some(Instant::now());
        });
        Self { port, seen }
    }

    fn seen(&self) -> Seen {
        *self.seen.lock().unwrap()
    }

    /// A program that says that it runs, and then does this for ever.
    fn program(&self, does: &str) -> String {
        format!(
            "def watched():\n socket_open('127.0.0.1', {}, 'w')\n socket_send_string('x', 'w')\n while True:\n  {}\n\
             \x20end\nend\n",
            self.port,
            does.replace('\n', "\n  ")
        )
    }

    fn wait_for_bytes(&self, count: usize) {
        wait_until("the program runs", || self.seen().bytes >= count);
    }

    /// How long after `asked` the program has ended.
    fn ended_after(&self, asked: Instant) -> Duration {
        wait_until("the program ends", || self.seen().ended.is_some());
        self.seen().ended.unwrap().duration_since(asked)
    }
}

/// An RTSI client that sets outputs.
fn rtsi_packets() -> Vec<u8> {
    let packet = |letter: u8, payload: &[u8]| {
        let length = u16::try_from(3 + payload.len()).unwrap();
        [&length.to_be_bytes()[..], &[letter], payload].concat()
    };
    let names = b"standard_digital_output_mask,standard_digital_output";
    let mut body = packet(b'I', names);
    body.extend(packet(b'U', &[1, 0, 0xFF, 0, 0xFF]));
    body
}

/// Floods every port from several threads until told to stop.
struct Flood {
    threads: Vec<JoinHandle<()>>,
    end: Arc<AtomicBool>,
}

impl Flood {
    fn begin(server: &Server) -> Self {
        let end = Arc::<AtomicBool>::default();
        let rtsi = {
            let mut bytes = rtsi_packets();
            let again = bytes[bytes.len() - 8..].to_vec();
            bytes.extend(again.repeat(2000));
            bytes
        };
        let modbus = [0, 1, 0, 0, 0, 6, 1, 5, 3, 232, 255, 0].repeat(500);
        let body = "{\"standard_digital_in[3]\": true}";
        let http = format!(
            "POST /api/inputs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: {}\r\n\
             \r\n{body}",
            body.len()
        );
        let floods: [(&str, Vec<u8>); 6] = [
            ("rtsi", rtsi),
            ("modbus", modbus),
            ("dashboard", b"speed -v 90\n".repeat(200)),
            ("interpreter", b"x = 1\nstateunexecuted\n".repeat(200)),
            (
                "primary",
                b"set speed 0.9\nsec s():\n x = 1\nend\npause task\nresume task\n".repeat(100),
            ),
            ("http", http.repeat(50).into_bytes()),
        ];
        let mut threads = Vec::new();
        for (port, bytes) in floods {
            for _ in 0..2 {
                let mut stream = connect(server, port);
                let (bytes, end) = (bytes.clone(), end.clone());
                let mut reader = stream.try_clone().unwrap();
                stream
                    .set_write_timeout(Some(Duration::from_millis(200)))
                    .unwrap();
                reader
                    .set_read_timeout(Some(Duration::from_millis(200)))
                    .unwrap();
                let stop = end.clone();
                threads.push(thread::spawn(move || {
                    while !end.load(Ordering::Relaxed) {
                        // A full socket is the server's way to slow us down; a part of a message was sent then, and the
                        // rest of this flood is nonsense, which is as good.
                        let _ = stream.write(&bytes);
                    }
                }));
                threads.push(thread::spawn(move || {
                    let mut sink = vec![0; 65536];
                    while !stop.load(Ordering::Relaxed) {
                        let _ = reader.read(&mut sink);
                    }
                }));
            }
        }
        Self { threads, end }
    }

    fn end(self) {
        self.end.store(true, Ordering::Relaxed);
        for thread in self.threads {
            thread.join().unwrap();
        }
    }
}

#[test]
fn a_stop_is_there_in_time_while_every_port_is_flooded() {
    let _machine = alone();
    for (port, text) in [("primary", "stop task\n"), ("dashboard", "stop\n")] {
        let folder = tempfile::tempdir().unwrap();
        let server = Server::start(folder.path(), &REAL);
        let watch = Watch::begin();
        server.primary().send(&watch.program(
            "movej([0.6, -1.2, 1.2, -1.5, -1.5, 0.3], a=0.5, v=0.3)\n\
             movej([-0.6, -1.8, 1.8, -1.5, -1.5, -0.3], a=0.5, v=0.3)",
        ));
        watch.wait_for_bytes(1);
        let mut stopper = connect(&server, port);
        let flood = Flood::begin(&server);
        thread::sleep(Duration::from_millis(500));
        let busy = Busy::since_now(&server);
        let asked = Instant::now();
        stopper.write_all(text.as_bytes()).unwrap();
        let took = watch.ended_after(asked);
        let allowed = busy.allowed();
        flood.end();
        println!("{port}: {took:?} of {allowed:?}");
        assert!(took < allowed, "{port}: {took:?} of {allowed:?}");
        let log = std::fs::read_to_string(folder.path().join("stderr.log")).unwrap();
        assert!(!log.contains("was not carried out"), "{log}");
        assert!(log.lines().count() < 1500, "{} lines", log.lines().count());
        assert_eq!(server.terminate().code(), Some(0));
    }
}

#[test]
fn a_stop_is_there_in_time_behind_whatever_its_client_sent_before() {
    let _machine = alone();
    let programs = "def p():\n sleep(100)\nend\n".repeat(2000);
    let mixed = "set speed 0.9\nsec s():\n y = 1\nend\nz = 1\n".repeat(2000);
    let log = "log -a hello\n".repeat(3000);
    let play = "speed -v 90\nplay\n".repeat(500);
    for (port, before, stop) in [
        ("primary", &programs, "stop task\n"),
        ("primary", &mixed, "stop task\n"),
        ("dashboard", &log, "stop\n"),
        ("dashboard", &play, "stop\n"),
    ] {
        for does in ["sleep(100)", "pass", "socket_read_string('w', timeout=100)"] {
            let folder = tempfile::tempdir().unwrap();
            let server = Server::start(folder.path(), &REAL);
            let watch = Watch::begin();
            server.primary().send(&watch.program(does));
            watch.wait_for_bytes(1);
            let mut client = connect(&server, port);
            let busy = Busy::since_now(&server);
            client.write_all(before.as_bytes()).unwrap();
            let asked = Instant::now();
            client.write_all(stop.as_bytes()).unwrap();
            let took = watch.ended_after(asked);
            let allowed = busy.allowed();
            println!("{port}, {does}: {took:?} of {allowed:?}");
            assert!(took < allowed, "{port}, {does}: {took:?} of {allowed:?}");
            // What waited before the stop does not begin after it.
            thread::sleep(Duration::from_millis(300));
            wait_until("nothing runs", || server.health().1["task"] == "stopped");
            server.kill();
        }
    }
}

#[test]
fn a_pause_is_there_in_time_behind_slow_lines() {
    let _machine = alone();
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &REAL);
    let watch = Watch::begin();
    let says = watch.program("socket_send_string('x', 'w')\nsync()");
    server.primary().send(&says);
    watch.wait_for_bytes(50);
    let mut client = connect(&server, "dashboard");
    let busy = Busy::since_now(&server);
    let lines = "log -a hello\n".repeat(3000);
    client.write_all(lines.as_bytes()).unwrap();
    let asked = Instant::now();
    client.write_all(b"pause\n").unwrap();
    thread::sleep(Duration::from_millis(700));
    let (seen, allowed) = (watch.seen(), busy.allowed());
    let took = seen.last.unwrap().saturating_duration_since(asked);
    println!("{took:?} of {allowed:?}");
    assert!(seen.ended.is_none() && took < allowed, "{took:?}");
    thread::sleep(Duration::from_millis(200));
    assert_eq!(watch.seen().bytes, seen.bytes, "it is held");
    assert_eq!(server.terminate().code(), Some(0));
}

#[test]
fn an_abort_is_there_in_time_behind_any_backlog_of_statements() {
    let _machine = alone();
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &REAL);
    let watch = Watch::begin();
    server
        .primary()
        .send("def mode():\n interpreter_mode()\nend\n");
    let mut client = connect(&server, "interpreter");
    let mut replies = client.try_clone().unwrap();
    thread::spawn(move || {
        let mut sink = [0; 65536];
        while let Ok(1..) = replies.read(&mut sink) {}
    });
    wait_until("it takes statements", || {
        let (_, panel) = server.page("/panel");
        panel.contains("\"active\"")
    });
    let open = format!(
        "socket_open('127.0.0.1', {}, 'w')\nsocket_send_string('x', 'w')\n\
         movej([1.5, -1.57, 1.57, -1.57, -1.57, 0], a=5, v=0.05)\nsocket_send_string('x', 'w')\n",
        watch.port
    );
    client.write_all(open.as_bytes()).unwrap();
    watch.wait_for_bytes(1);
    // More than any queue holds: the queue of the task is full, and so is the one before it.
    let backlog = "y = 'abcdefghijklmnopqrstuvwxyz'\n".repeat(200_000);
    let sent = Instant::now();
    client.write_all(backlog.as_bytes()).unwrap();
    let sending = sent.elapsed();
    thread::sleep(Duration::from_millis(300));
    assert_eq!(watch.seen().bytes, 1, "it moves");
    let busy = Busy::since_now(&server);
    let asked = Instant::now();
    client.write_all(b"abort\n").unwrap();
    watch.wait_for_bytes(2);
    let took = watch.seen().last.unwrap().duration_since(asked);
    // What the system still held of the backlog was read first, which takes no longer than to send all of it, and the
    // arm came to rest.
    let allowed = busy.allowed() + sending + Duration::from_millis(400);
    println!("{took:?} of {allowed:?}");
    assert!(took < allowed, "{took:?} of {allowed:?}");
    assert_eq!(server.terminate().code(), Some(0));
}

#[test]
fn a_text_that_takes_long_to_compile_holds_up_neither_a_stop_nor_what_runs() {
    let _machine = alone();
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &REAL);
    let mut primary = server.primary();
    order_before(&folder, "compiler hang");
    primary.send("def never():\n sleep(1)\nend\n");
    wait_until("it is being compiled", || {
        !folder.path().join("faults").exists() && server.health().1["task"] == "running"
    });
    let busy = Busy::since_now(&server);
    let asked = Instant::now();
    server.primary().send("stop task\n");
    wait_until("it ends", || server.health().1["task"] == "stopped");
    let (took, allowed) = (asked.elapsed(), busy.allowed());
    assert!(took < allowed, "{took:?} of {allowed:?}");

    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &REAL);
    let watch = Watch::begin();
    let says = watch.program("socket_send_string('x', 'w')\nsync()");
    server.primary().send(&says);
    watch.wait_for_bytes(50);
    order_before(&folder, "compiler hang");
    server.primary().send("sec s():\n x = 1\nend\n");
    wait_until("it is being compiled", || {
        !folder.path().join("faults").exists()
    });
    let before = watch.seen().bytes;
    watch.wait_for_bytes(before + 50);
    let busy = Busy::since_now(&server);
    let asked = Instant::now();
    server.primary().send("stop task\n");
    let took = watch.ended_after(asked);
    assert!(took < busy.allowed(), "{took:?}");
    assert_eq!(server.terminate().code(), Some(0));
}

/// Orders a fault that is taken later.
fn order_before(folder: &tempfile::TempDir, fault: &str) {
    std::fs::write(folder.path().join("faults"), format!("{fault}\n")).unwrap();
}

#[test]
fn a_disk_that_hangs_holds_up_neither_a_stop_nor_for_long_the_robot() {
    let _machine = alone();
    for clock in ["virtual", "realtime"] {
        for does in ["sync()", "print('x' * 1000)\nsync()", "print('x' * 60000)"] {
            let folder = tempfile::tempdir().unwrap();
            let options = ["--plant", "ideal", "--record", "out.mcap", "--clock", clock];
            let server = Server::start(folder.path(), &options);
            let watch = Watch::begin();
            let mut primary = server.primary();
            primary.send(&watch.program(does));
            watch.wait_for_bytes(1);
            order(folder.path(), "disk hang");
            // Long enough that the ring is full, not long enough that the recording is given up.
            thread::sleep(Duration::from_millis(1500));
            let busy = Busy::since_now(&server);
            let asked = Instant::now();
            server.primary().send("stop task\n");
            let took = watch.ended_after(asked);
            let allowed = busy.allowed();
            println!("{clock}, {does}: {took:?} of {allowed:?}");
            assert!(took < allowed, "{clock}, {does}: {took:?} of {allowed:?}");
            wait_until("it has ended", || server.health().1["task"] == "stopped");
            if clock == "virtual" && does == "sync()" {
                // Under the real clock nobody waits for the disk before the ring is full, which takes a while.
                let again = Watch::begin();
                primary.send(&again.program("sync()"));
                let told = robot_error(&mut primary);
                assert_eq!(told, 120, "the alarm of the recording");
                let cycle = server.health().1["cycle"].as_u64();
                wait_until("cycles go on", || {
                    server.health().1["cycle"].as_u64() > cycle.map(|n| n + 100)
                });
                assert_eq!(server.health().1["recording"], "stopped");
                let busy = Busy::since_now(&server);
                let asked = Instant::now();
                primary.send("stop task\n");
                assert!(again.ended_after(asked) < busy.allowed());
            }
            assert_eq!(
                server.terminate().code(),
                Some(1),
                "the recording is cut short"
            );
        }
    }
}

fn robot_error(primary: &mut common::Primary) -> i32 {
    let begin = Instant::now();
    loop {
        if let FromPrimary::RobotError(code, _) = primary.next() {
            return code;
        }
        assert!(begin.elapsed() < PATIENCE, "no error");
    }
}

#[test]
fn a_recording_into_a_pipe_that_nobody_reads_for_a_while_is_whole() {
    let _machine = alone();
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("out.pipe");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.unwrap().success());
    let (from, to) = (pipe.clone(), folder.path().join("out.mcap"));
    let reader = thread::spawn(move || {
        let mut pipe = std::fs::File::open(from).unwrap();
        let mut file = std::fs::File::create(to).unwrap();
        let mut first = [0; 4096];
        let count = pipe.read(&mut first).unwrap();
        file.write_all(&first[..count]).unwrap();
        thread::sleep(Duration::from_millis(1200));
        std::io::copy(&mut pipe, &mut file).unwrap();
    });
    let options = [
        "--plant", "ideal", "--record", "out.pipe", "--clock", "virtual",
    ];
    let server = Server::start(folder.path(), &options);
    let watch = Watch::begin();
    let mut primary = server.primary();
    primary.send(&watch.program("sync()"));
    thread::sleep(Duration::from_millis(2500));
    primary.send("stop task\n");
    assert_eq!(server.terminate().code(), Some(0));
    reader.join().unwrap();
    let cycles = read_recording(&folder.path().join("out.mcap")).cycles;
    let numbers: Vec<u64> = cycles.iter().map(|cycle| cycle.cycle).collect();
    let all: Vec<u64> = (1..=numbers.len() as u64).collect();
    assert!(numbers == all && all.len() > 4096, "{}", all.len());
}
