//! Programs of a server that deal with machines and people: recorded, repeated without any of them, and walked
//! backwards.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::os::fd::OwnedFd;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use io_bus::modbus_server::tables::Store;
use io_bus::xmlrpc::RpcValue;
use io_bus::xmlrpc::codec::{RpcFault, decode_call, encode_response};
use serde_json::{Value as Json, json};

use super::{Debugger, order, program_state, rerun, wait_for};
use crate::common::{Dashboard, Server};

/// How often somebody spoke to a peer.
type Contacts = Arc<AtomicUsize>;

/// A remote server with one part for each number, and a method that always fails.
fn remote_server(contacts: &Contacts) -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let contacts = contacts.clone();
    std::thread::spawn(move || {
        for stream in listener.incoming() {
            let contacts = contacts.clone();
            std::thread::spawn(move || answer_calls(stream.unwrap(), &contacts));
        }
    });
    port
}

/// Requests of one connection, until it is closed.
fn answer_calls(stream: TcpStream, contacts: &Contacts) {
    let mut reader = BufReader::new(stream.try_clone().unwrap());
    let mut stream = stream;
    loop {
        let mut length = 0;
        loop {
            let mut line = String::new();
            if reader.read_line(&mut line).unwrap_or(0) == 0 {
                return;
            }
            let line = line.trim().to_ascii_lowercase();
            if let Some(value) = line.strip_prefix("content-length:") {
                length = value.trim().parse().unwrap();
            }
            if line.is_empty() {
                break;
            }
        }
        let mut body = vec![0; length];
        reader.read_exact(&mut body).unwrap();
        let (method, arguments) = decode_call(std::str::from_utf8(&body).unwrap()).unwrap();
        contacts.fetch_add(1, Ordering::SeqCst);
        std::thread::sleep(Duration::from_millis(83));
        let answer = match (method.as_str(), arguments.as_slice()) {
            ("next_part", [RpcValue::Int(n), ..]) => Ok(RpcValue::Struct(vec![
                ("angle".into(), RpcValue::Double(0.1 * (*n as f64 + 1.0))),
                ("name".into(), RpcValue::Text(format!("件 {n}"))),
                (
                    "holes".into(),
                    RpcValue::Array(vec![RpcValue::Int(*n), RpcValue::Bool(true)]),
                ),
                ("raw".into(), RpcValue::Bytes(vec![0, 255, *n as u8])),
            ])),
            _ => Err(RpcFault {
                code: 7,
                text: format!("no {method} here"),
            }),
        };
        let body = encode_response(&answer);
        write!(
            stream,
            "HTTP/1.1 200 OK\r\nContent-Type: text/xml\r\nContent-Length: {}\r\n\r\n{body}",
            body.len()
        )
        .unwrap();
    }
}

/// A Modbus device whose first registers are 7, 8 and so on.
fn modbus_device(contacts: &Contacts) -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    listener.set_nonblocking(true).unwrap();
    let contacts = contacts.clone();
    std::thread::spawn(move || {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .unwrap();
        runtime.block_on(async move {
            let store = Arc::new(Store::default());
            store.values().registers[100..104].copy_from_slice(&[7, 8, 9, 10]);
            let listener = tokio::net::TcpListener::from_std(listener).unwrap();
            loop {
                let (stream, _) = listener.accept().await.unwrap();
                contacts.fetch_add(1, Ordering::SeqCst);
                let store = store.clone();
                tokio::spawn(async move {
                    let _ = io_bus::modbus_server::serve(stream, &*store).await;
                });
            }
        });
    });
    port
}

/// A scale at a serial line: it answers each line with four bytes. The second end is kept open, so that the line lasts.
fn scale(contacts: &Contacts) -> (String, OwnedFd) {
    let pty = nix::pty::openpty(None, None).unwrap();
    let name = nix::unistd::ttyname(&pty.slave).unwrap();
    let mut attributes = nix::sys::termios::tcgetattr(&pty.slave).unwrap();
    nix::sys::termios::cfmakeraw(&mut attributes);
    nix::sys::termios::tcsetattr(&pty.slave, nix::sys::termios::SetArg::TCSANOW, &attributes)
        .unwrap();
    let contacts = contacts.clone();
    std::thread::spawn(move || {
        let mut master = std::fs::File::from(pty.master);
        let mut byte = [0];
        while master.read_exact(&mut byte).is_ok() {
            if byte == *b"\n" {
                contacts.fetch_add(1, Ordering::SeqCst);
                std::thread::sleep(Duration::from_millis(61));
                master.write_all(&[1, 0, 200, 13]).unwrap();
            }
        }
    });
    (name.to_str().unwrap().to_owned(), pty.slave)
}

fn panel(server: &Server) -> Json {
    serde_json::from_str(&server.page("/panel").1).unwrap()
}

fn program(rpc: u16, modbus: u16) -> String {
    format!(
        "def peers():\n  \
           q = [0, -1.57, 1.57, -1.57, -1.57, 0]\n  \
           parts = rpc_factory('xmlrpc', '127.0.0.1:{rpc}')\n  \
           n = 0\n  \
           while n < 3:\n    \
             part = parts.next_part(n, {{'by': get_task_path(), 'at': get_actual_joint_positions()}})\n    \
             q[0] = part['angle'] + 0.001 * part['raw'][1] + 0.01 * part['holes'][0]\n    \
             movej(q, a=3, v=2)\n    \
             n = n + 1\n  \
           end\n  \
           try:\n    \
             parts.broken()\n  \
           except RuntimeError as e:\n    \
             fault = str(e)\n  \
           end\n  \
           tool_serial_config(True, 115200, 0, 1)\n  \
           sent = tool_serial_write('weigh\\n')\n  \
           weight = tool_serial_read(4, True, 5)\n  \
           nothing = tool_serial_read(4, False, 0.05)\n  \
           q[1] = -1.57 + 0.001 * weight[2] + 0.01 * len(nothing) + 0.01 * sent\n  \
           movej(q, a=3, v=2)\n  \
           modbus_add_signal('127.0.0.1', 255, 101, 3, 'count', False, 2, {modbus})\n  \
           counts = [0, 0]\n  \
           while counts[0] != 8:\n    \
             sleep(0.02)\n    \
             try:\n      \
               counts = modbus_get_signal_status('count', False)\n    \
             except RuntimeError as e:\n      \
               counts = [0, 0]\n    \
             end\n  \
           end\n  \
           modbus_set_output_register('count', [3, 4])\n  \
           q[2] = 1.57 + 0.01 * counts[1]\n  \
           movej(q, a=3, v=2)\n  \
           popup('weight ' + to_str(weight), 'Operator', blocking=True)\n  \
           movej([0, -1.57, 1.57, -1.57, -1.57, 0], a=3, v=2)\n  \
           popup('again', blocking=True)\n  \
           while not get_standard_digital_in(2):\n    \
             sync()\n  \
           end\n  \
           load = load_micro_line_file('points', 2)\n  \
           moveml(load)\n  \
           set_standard_digital_out(len(fault) % 8, True)\n\
         end\n"
    )
}

/// Runs the program on a server, with everybody it deals with; how often they were spoken to.
fn served(folder: &Path, clock: &str) -> (Contacts, OwnedFd) {
    let contacts = Contacts::default();
    let (rpc, modbus) = (remote_server(&contacts), modbus_device(&contacts));
    let (line, kept) = scale(&contacts);
    let cell = format!(
        "[[serial]]\nport = \"tool\"\ndevice = \"{line}\"\n\n[[modbus]]\nIP = \"127.0.0.1\"\nport = {modbus}\n\
         slave_number = 255\nsignal_address = 100\nsignal_type = 3\nsignal_name = \"own\"\n"
    );
    std::fs::write(folder.join("cell.toml"), cell).unwrap();
    std::fs::create_dir(folder.join("tasks")).unwrap();
    // More than one message of the recording takes.
    let points: String = (0..1500)
        .map(|k| {
            format!(
                "{:.17} -1.57 1.57 -1.57 -1.57 0.000000000000000000000000000000000000\n",
                1e-4 * f64::from(k)
            )
        })
        .collect();
    std::fs::write(folder.join("tasks/points.txt"), points).unwrap();
    let options = [
        "--clock",
        clock,
        "--plant",
        "ideal",
        "--cell",
        "cell.toml",
        "--record",
        "served.mcap",
    ];
    let server = Server::start(folder, &options);
    let mut dashboard = Dashboard::connect(&server);
    let mut primary = server.primary();
    primary.send(&program(rpc, modbus));
    let is_running = || program_state(&server) == "running";
    wait_for("it begins", is_running);
    std::thread::sleep(Duration::from_millis(200));
    let said = dashboard.ask("pause");
    assert!(said.to_lowercase().contains("paus"), "{said}");
    std::thread::sleep(Duration::from_millis(120));
    dashboard.ask("play");
    primary.send(
        "sec beside():\n  set_standard_digital_out(5, get_standard_digital_in(0) == False)\nend\n",
    );
    let dialogs = || panel(&server)["popups"].as_array().map_or(0, Vec::len);
    wait_for("the first dialog", || dialogs() == 1);
    std::thread::sleep(Duration::from_millis(50));
    let said = dashboard.ask("popup -c");
    assert!(said.contains("Closing popup"), "{said}");
    wait_for("it is answered", || dialogs() == 0);
    wait_for("the second dialog", || dialogs() == 1);
    order(
        &server,
        &json!({"do": "close_popup", "popup": panel(&server)["popups"][0]["id"]}),
    );
    wait_for("it is answered", || dialogs() == 0);
    std::thread::sleep(Duration::from_millis(50));
    let said = order(
        &server,
        &json!({"do": "inputs", "values": {"standard_digital_in[2]": true}}),
    );
    assert!(said.contains("200"), "{said}");
    wait_for("it ends", || program_state(&server) == "stopped");
    assert!(server.terminate().success());
    (contacts, kept)
}

/// The recording runs again and is walked backwards, and nobody hears of it.
fn is_repeated(folder: &Path, contacts: &Contacts) {
    let before = contacts.load(Ordering::SeqCst);
    // Four calls, a line, a connection for signals.
    assert!(before >= 6, "{before}");
    let said = rerun(folder);
    assert!(said.contains("identical: 1 program"), "{said}");

    let mut debugger = Debugger::at_the_end(&folder.join("served.mcap"));
    let moves = program(0, 0)
        .lines()
        .position(|line| line.contains("moveml("))
        .unwrap();
    let mut back = |line: u64| loop {
        debugger.ask("stepBack", json!({"threadId": 1})).unwrap();
        debugger.event("stopped");
        if debugger.line() == line {
            return debugger.evaluate("[n, fault, weight, nothing, counts, load, part]");
        }
        assert!(debugger.line() > line);
    };
    assert_eq!(
        back(moves as u64 + 1),
        "[3, 'broken(): fault 7: no broken here', [1, 0, 200, 13], b'', [8, 9], 0, \
         {'angle': 0.30000000000000004, 'name': '件 2', 'holes': [2, True], 'raw': b'\\x00\\xff\\x02'}]"
    );
    debugger.end();
    assert_eq!(contacts.load(Ordering::SeqCst), before);
}

#[test]
fn remote_calls_serial_lines_signals_dialogs_files_and_orders_are_repeated_without_anybody() {
    let folder = tempfile::tempdir().unwrap();
    let (contacts, _line) = served(folder.path(), "realtime");
    is_repeated(folder.path(), &contacts);
}

#[test]
fn the_same_under_the_virtual_clock() {
    let folder = tempfile::tempdir().unwrap();
    let (contacts, _line) = served(folder.path(), "virtual");
    is_repeated(folder.path(), &contacts);
}
