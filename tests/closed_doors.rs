//! Who must not get in does not get in, over real sockets on every port: browsers and pages, one client too many,
//! floods.

#![allow(clippy::unwrap_used, reason = "a test helper fails by panicking")]

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use crate::common::{self, PATIENCE, Server};

/// Ports that speak a protocol of their own.
const OWN: [&str; 7] = [
    "primary",
    "interpreter",
    "rtsi",
    "dashboard",
    "modbus",
    "state",
    "query",
];

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
    assert_eq!(&greeting, b"EliRo");
    let log = std::fs::read_to_string(folder.path().join("stderr.log")).unwrap();
    assert!(log.contains("cannot accept a client"), "{log}");
    assert!(log.lines().count() < 200, "{log}");
    assert_eq!(server.terminate().code(), Some(0));
}

/// What a terminal obeys, and what would begin a line.
const CONTROLS: [&str; 9] = [
    "\n",
    "\r",
    "\x1b[2J",
    "\x07",
    "\x7f",
    "\u{85}",
    "\u{9b}31m",
    "\u{2028}",
    "\u{202e}",
];

#[test]
fn nothing_that_peers_and_programs_say_forges_a_line_of_the_log_or_moves_a_cursor() {
    let folder = tempfile::tempdir().unwrap();
    let log = std::fs::File::create(folder.path().join("stderr.log")).unwrap();
    let options = [
        "--record",
        "out.mcap",
        "--plant",
        "ideal",
        "--clock",
        "virtual",
        "--log-dir",
        "logs",
    ];
    let server = Server::start_with(folder.path(), &options, log);
    let mut primary = server.primary();
    let mut interpreter = connect(&server, "interpreter");
    let (mut dashboard, mut rtsi) = (connect(&server, "dashboard"), connect(&server, "rtsi"));
    for control in CONTROLS {
        let text = format!("a{control}2026-01-01T00:00:00Z ERROR FORGED");
        let literal: String = text
            .chars()
            .map(|c| format!("\\U{:08x}", u32::from(c)))
            .collect();
        primary.send(&format!(
            "def p():\n t = '{literal}'\n textmsg(t)\n print(t)\n popup(t, t, blocking=False)\n global g\n g = t\n\
             \x20try:\n  rpc_factory('xmlrpc', 'http://127.0.0.1:1/' + t)\n except Exception as e:\n  textmsg(e)\n\
             \x20end\n try:\n  socket_open(t, 80, t)\n except Exception as e:\n  textmsg(e)\n end\n\
             \x20raise ValueError(t)\nend\n"
        ));
        while !primary.script_error().2.contains("FORGED") {}
        for line in [
            format!("log -a {text}\n"),
            format!("popup -s {text}\n"),
            format!("task -p {text}\n"),
            format!("variable -get {text}\n"),
            format!("{text}\n"),
        ] {
            dashboard.write_all(line.as_bytes()).unwrap();
        }
        interpreter
            .write_all(format!("x = {text}\n").as_bytes())
            .unwrap();
        primary.send(&format!("x = {text}\nset speed {text}\n"));
        let names = [&[0, 0][..], text.as_bytes()].concat();
        let length = u16::try_from(3 + names.len()).unwrap().to_be_bytes();
        rtsi.write_all(&[&length[..], b"M", &names].concat())
            .unwrap();
        let _ = server.page(&format!("/{}", text.replace(['\n', '\r', ' '], "%0a")));
    }
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(server.terminate().code(), Some(0));
    let mut files = vec![folder.path().join("stderr.log")];
    let logs = std::fs::read_dir(folder.path().join("logs")).unwrap();
    files.extend(logs.map(|entry| entry.unwrap().path()));
    for file in files {
        let said = std::fs::read_to_string(&file).unwrap();
        for line in said.lines() {
            let obeyed = line.chars().find(|c| c.is_control() && *c != '\t');
            assert_eq!(obeyed, None, "{}: {line:?}", file.display());
            assert!(
                !line.starts_with("2026-01-01T00:00:00Z"),
                "{}: {line:?}",
                file.display()
            );
            assert!(!line.contains(['\u{2028}', '\u{202e}']), "{line:?}");
        }
    }
    // A file may hold names of anybody's making.
    let recording = folder.path().join("out.mcap");
    for question in [&[][..], &["--script"], &["--at", "0.004"]] {
        let output = common::eliteserver()
            .arg("replay")
            .arg(&recording)
            .args(question)
            .output()
            .unwrap();
        let said = String::from_utf8(output.stdout).unwrap();
        for line in said.lines() {
            assert!(
                !line.chars().any(|c| c.is_control() && c != '\t'),
                "{line:?}"
            );
            assert!(!line.starts_with("2026-01-01T00:00:00Z"), "{line:?}");
        }
    }
}
