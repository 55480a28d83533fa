//! Who must not get in does not get in, over real sockets on every port: browsers and pages, one client too many, floods.

#![allow(clippy::unwrap_used, reason = "a test helper fails by panicking")]

mod common;

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use common::{PATIENCE, Server};

/// Ports that speak a protocol of their own.
const OWN: [&str; 5] = ["primary", "interpreter", "rtsi", "dashboard", "modbus"];

fn connect(server: &Server, port: &str) -> TcpStream {
    let stream = TcpStream::connect(("127.0.0.1", server.ports[port])).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    stream.set_nodelay(true).unwrap();
    stream
}

/// Sends `bytes` in pieces and reads until the server closes. What came is of no interest: greetings and states.
#[track_caller]
fn is_closed(server: &Server, port: &str, bytes: &[u8], piece: usize) {
    let mut stream = connect(server, port);
    for part in bytes.chunks(piece) {
        if stream.write_all(part).is_err() {
            return; // closed already
        }
    }
    let started = Instant::now();
    let mut rest = [0; 4096];
    while let Ok(1..) = stream.read(&mut rest) {
        assert!(
            started.elapsed() < Duration::from_secs(10),
            "{port} stays open for {:?}",
            String::from_utf8_lossy(bytes)
        );
    }
    assert!(started.elapsed() < PATIENCE, "{port} stays open");
}

/// What a page can make a browser send to RTSI: whatever the length of the head, packets of three bytes lead into step,
/// then outputs are set.
fn rtsi_body() -> Vec<u8> {
    let packet = |letter: u8, payload: &[u8]| {
        let length = u16::try_from(3 + payload.len()).unwrap();
        [&length.to_be_bytes()[..], &[letter], payload].concat()
    };
    let mut body = b"\x00\x03P".repeat(3000);
    body.extend(packet(
        b'I',
        b"standard_digital_output_mask,standard_digital_output",
    ));
    body.extend(packet(b'U', &[1, 0, 0xFF, 0, 0xFF]));
    body
}

#[test]
fn no_request_and_no_greeting_of_tls_gets_into_a_port_of_another_protocol() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &["--record", "off", "--plant", "ideal"]);
    let orders = b"set_standard_digital_out(0, True)\nset_standard_digital_out(1, True)\nstop\n";
    let modbus = [0, 1, 0, 0, 0, 6, 1, 5, 3, 232, 255, 0].repeat(20);
    let mut bodies = [orders.to_vec(), rtsi_body(), modbus];
    for port in OWN {
        let hello = [&[0x16, 3, 1, 2, 0, 1, 0, 1, 0xfc, 3, 3][..], &[7; 505]].concat();
        for piece in [1, 600] {
            is_closed(&server, port, &hello, piece);
        }
        for verb in [
            "GET", "HEAD", "POST", "PUT", "DELETE", "CONNECT", "OPTIONS", "TRACE", "PATCH", "get",
            "Post", "pUT", "PROPFIND",
        ] {
            let mut request = format!("{verb} / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n").into_bytes();
            request.extend(&bodies[0]);
            bodies.rotate_left(1);
            for piece in [usize::MAX, 1, 3] {
                is_closed(&server, port, &request[..request.len().min(20_000)], piece);
            }
        }
        is_closed(
            &server,
            port,
            b"\r\n\r\nPOST / HTTP/1.1\r\n\r\nstop task\n",
            1,
        );
        is_closed(&server, port, b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", 2);
    }
    let state = server.primary().state();
    assert_eq!(state.digital_out, 0, "something of it was done");
    let log = std::fs::read_to_string(folder.path().join("stderr.log")).unwrap();
    assert!(log.contains("closed: the client speaks HTTP"), "{log}");
    assert!(log.contains("closed: the client speaks TLS"), "{log}");
    assert!(!log.contains("ERROR"), "{log}");
}

#[test]
fn a_page_under_a_foreign_name_sees_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(
        folder.path(),
        &[
            "--record",
            "off",
            "--plant",
            "ideal",
            "--trust-host",
            "cell-4.example",
        ],
    );
    let ask = |head: &str| {
        let mut stream = connect(&server, "http");
        let request = format!("{head}\r\nConnection: close\r\n\r\n");
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = String::new();
        let _ = stream.read_to_string(&mut answer);
        answer[9..12].to_owned()
    };
    for page in ["/healthz", "/metrics", "/panel", "/api/io", "/nothing"] {
        let evil = format!("GET {page} HTTP/1.1\r\nHost: evil.example:8080");
        assert_eq!(ask(&evil), "403", "{page}");
        let evil = format!("GET {page} HTTP/1.1\r\nHost: localhost\r\nOrigin: http://evil.example");
        assert_eq!(ask(&evil), "403", "{page}");
    }
    assert_eq!(
        ask("GET /healthz HTTP/1.1\r\nHost: cell-4.example:80"),
        "200"
    );
    assert_eq!(ask("GET /healthz HTTP/1.1\r\nHost: localhost"), "200");
}

#[test]
fn a_server_without_file_descriptors_goes_on_and_takes_clients_again() {
    let folder = tempfile::tempdir().unwrap();
    let ready = folder.path().join("ready.json");
    let log = std::fs::File::create(folder.path().join("stderr.log")).unwrap();
    let ports: String = OWN
        .iter()
        .chain(&["http"])
        .map(|port| format!(" --{port}-port 0"))
        .collect();
    let binary = env!("CARGO_BIN_EXE_eliteserver");
    let line = format!(
        "ulimit -n 40; exec {binary} serve --record off --plant ideal --ready-file ready.json{ports}"
    );
    let child = std::process::Command::new("sh")
        .args(["-c", &line])
        .current_dir(folder.path())
        .env_remove("RUST_LOG")
        .stderr(log)
        .spawn()
        .unwrap();
    let server = Server::adopt(child, &ready, folder.path());
    let many: Vec<TcpStream> = (0..60).map(|_| connect(&server, "dashboard")).collect();
    std::thread::sleep(Duration::from_millis(500));
    drop(many);
    let mut client = connect(&server, "dashboard");
    let mut greeting = [0; 5];
    client.read_exact(&mut greeting).unwrap();
    assert_eq!(&greeting, b"Elite");
    let log = std::fs::read_to_string(folder.path().join("stderr.log")).unwrap();
    assert!(log.contains("cannot accept a client"), "{log}");
    assert!(log.lines().count() < 200, "{log}");
    assert_eq!(server.terminate().code(), Some(0));
}

/// Floods every port from several threads until told to stop.
struct Flood {
    threads: Vec<std::thread::JoinHandle<()>>,
    end: std::sync::Arc<std::sync::atomic::AtomicBool>,
}

impl Flood {
    fn begin(server: &Server) -> Self {
        let end = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(false));
        let rtsi = {
            let mut bytes = rtsi_body();
            bytes.drain(..3 * 3000);
            let again = bytes[bytes.len() - 8..].to_vec();
            bytes.extend(again.repeat(2000));
            bytes
        };
        let modbus = [0, 1, 0, 0, 0, 6, 1, 5, 3, 232, 255, 0].repeat(500);
        let body = "{\"standard_digital_in[3]\": true}";
        let http = format!(
            "POST /api/inputs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: {}\r\n\r\n{body}",
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
                threads.push(std::thread::spawn(move || {
                    while !end.load(std::sync::atomic::Ordering::Relaxed) {
                        // A full socket is the server's way to slow us down; a part of a message was sent then, and the
                        // rest of this flood is nonsense, which is as good.
                        let _ = stream.write(&bytes);
                    }
                }));
                threads.push(std::thread::spawn(move || {
                    let mut sink = vec![0; 65536];
                    while !stop.load(std::sync::atomic::Ordering::Relaxed) {
                        let _ = reader.read(&mut sink);
                    }
                }));
            }
        }
        Self { threads, end }
    }

    fn end(self) {
        self.end.store(true, std::sync::atomic::Ordering::Relaxed);
        for thread in self.threads {
            thread.join().unwrap();
        }
    }
}

/// A motion that goes on for a minute, whatever a flood does to pause and slider.
const LONG_MOTION: &str = "def long():\n  while True:\n    movej([0.6, -1.2, 1.2, -1.5, -1.5, 0.3], a=0.5, v=0.3)\n    movej([-0.6, -1.8, 1.8, -1.5, -1.5, -0.3], a=0.5, v=0.3)\n  end\nend\n";

#[test]
fn a_stop_gets_through_while_every_port_is_flooded() {
    for order in [("primary", "stop task\n"), ("dashboard", "stop\n")] {
        let folder = tempfile::tempdir().unwrap();
        let server = Server::start(folder.path(), &["--record", "off", "--plant", "ideal"]);
        let mut watcher = server.primary();
        watcher.send(LONG_MOTION);
        watcher.wait_for("the program runs", |s| s.task_running);
        let (port, text) = order;
        let mut stopper = connect(&server, port);
        let flood = Flood::begin(&server);
        std::thread::sleep(Duration::from_millis(500));
        let asked = Instant::now();
        stopper.write_all(text.as_bytes()).unwrap();
        // States come ten times a second at the least; the machine of a test is not idle.
        watcher.wait_for("the program has ended", |s| !s.task_running);
        let took = asked.elapsed();
        flood.end();
        assert!(took < Duration::from_secs(2), "{port}: {took:?}");
        let log = std::fs::read_to_string(folder.path().join("stderr.log")).unwrap();
        assert!(!log.contains("was not carried out"), "{log}");
        assert!(log.lines().count() < 1500, "{} lines", log.lines().count());
        assert_eq!(server.terminate().code(), Some(0));
    }
}
