//! The ports that public programs for real arms use beside 30001: Modbus with the vendor's map, questions on 40011, the
//! state on 30011, and what the control modes do to them. Raw sockets, as those programs have them.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::time::{Duration, Instant};

use crate::common::{Dashboard, PATIENCE, Server, alone, eliteserver, run_script};

fn server(folder: &Path, options: &[&str]) -> Server {
    Server::start(folder, &[&["--record", "off"], options].concat())
}

fn connect(server: &Server, port: &str) -> TcpStream {
    let stream = TcpStream::connect(("127.0.0.1", server.ports[port])).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    stream.set_nodelay(true).unwrap();
    stream
}

fn until(what: &str, mut holds: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !holds() {
        assert!(begun.elapsed() < PATIENCE, "{what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// One Modbus request proper and its reply.
fn ask(plc: &mut TcpStream, request: &[u8]) -> Vec<u8> {
    let header = [0, 7, 0, 0, 0, request.len() as u8 + 1, 255];
    plc.write_all(&[&header, request].concat()).unwrap();
    let mut head = [0; 7];
    plc.read_exact(&mut head).unwrap();
    let mut reply = vec![0; usize::from(head[5]) - 1];
    plc.read_exact(&mut reply).unwrap();
    reply
}

fn words(plc: &mut TcpStream, address: u16, count: u16) -> Vec<i16> {
    let [a, b] = address.to_be_bytes();
    let reply = ask(plc, &[4, a, b, 0, count as u8]);
    assert_eq!(reply[0], 4, "{reply:?}");
    let words = reply[2..].as_chunks::<2>().0;
    words.iter().map(|word| i16::from_be_bytes(*word)).collect()
}

/// A PLC and a program talk over words and outputs; the state follows the program.
#[test]
fn a_plc_and_a_program_share_the_vendors_map() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let server = server(folder.path(), &[]);
    let mut plc = connect(&server, "modbus");
    assert_eq!(words(&mut plc, 63, 4), [2, 15, 0, 7]);
    assert_eq!(words(&mut plc, 71, 2), [2, -1]);
    assert_eq!(words(&mut plc, 500, 1), [3]);
    let text = "def handshake():\n  while read_port_register(256, True) != -5:\n    sync()\n  end\n\
                \x20 write_port_register(257, read_port_register(500))\n  \
                write_port_bit(35, True)\n  movej([0.3, -1.57, 1.57, -1.57, -1.57, 0], a=3, v=2)\n\
                \x20 write_port_register(2, 6)\n  \
                while True:\n    sync()\n  end\nend\n";
    server.primary().send(text);
    until("it runs", || words(&mut plc, 500, 1) == [1]);
    assert_eq!(ask(&mut plc, &[6, 1, 0, 0xFF, 0xFB]), [6, 1, 0, 0xFF, 0xFB]);
    until("it moves", || words(&mut plc, 84, 1)[0] > 100);
    assert_eq!(words(&mut plc, 257, 1), [1]);
    assert_eq!(words(&mut plc, 2, 1), [8], "output 3");
    until("it stands", || words(&mut plc, 2, 1) == [6]);
    assert_eq!(words(&mut plc, 73, 2), [300, -1570]);
    let pose = words(&mut plc, 384, 6);
    assert!(pose[0].abs() > 1000 && pose[3] != 0, "{pose:?}");

    let mut dashboard = Dashboard::connect(&server);
    assert_eq!(dashboard.ask("pause"), "Pausing task");
    until("it is held", || words(&mut plc, 500, 1) == [2]);
    dashboard.ask("stop");
    until("it has ended", || words(&mut plc, 500, 1) == [3]);
    assert_eq!(words(&mut plc, 256, 2), [-5, 1], "words outlive programs");

    assert_eq!(ask(&mut plc, &[6, 0, 17, 0, 40]), [6, 0, 17, 0, 40]);
    until("the slider follows", || {
        dashboard.ask("speed") == "speed: 40"
    });
    assert_eq!(ask(&mut plc, &[5, 0, 48, 0xFF, 0]), [5, 0, 48, 0xFF, 0]);
    assert_eq!(ask(&mut plc, &[2, 0, 48, 0, 1]), [2, 1, 1]);
    assert_eq!(ask(&mut plc, &[6, 0, 73, 0, 1]), [0x86, 2]);
    assert!(server.terminate().success());
}

/// Asks one question as a client with one read does.
fn question(client: &mut TcpStream, text: &str) -> String {
    client.write_all(text.as_bytes()).unwrap();
    let mut answer = [0; 1024];
    let count = client.read(&mut answer).unwrap();
    String::from_utf8(answer[..count].to_vec()).unwrap()
}

#[test]
fn questions_are_answered_beside_a_program_and_without_one() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let server = server(folder.path(), &[]);
    let mut client = connect(&server, "query");
    let mut asked = |text: &str| question(&mut client, text);
    assert_eq!(
        asked("req 2 get_actual_joint_positions()\n"),
        "[2] [success] : [[0.000000, -1.570800, 1.570800, -1.570800, -1.570800, 0.000000]]\n"
    );
    assert_eq!(
        asked("req 1 set_tcp([0, 0, 0.1, 0, 0, 0])\r\n"),
        "[1] [success] : [None]\n"
    );
    assert_eq!(
        asked("req 1 get_tcp_offset()\n"),
        "[1] [success] : [[0.000000, 0.000000, 0.100000, 0.000000, 0.000000, 0.000000]]\n"
    );
    assert_eq!(
        asked("req 3 get_inverse_kin_has_solution([9,0,0,0,0,0])\n"),
        "[3] [success] : [False]\n"
    );
    for (text, failure) in [
        ("req 4 1/0\n", "[4] [failure] : [execute failed]\n"),
        (
            "req 5 get_inverse_kin([9,0,0,0,0,0])\n",
            "[5] [failure] : [execute failed]\n",
        ),
        (
            "req 6 movej([0,0,0,0,0,0])\n",
            "[6] [failure] : [execute failed]\n",
        ),
        ("req 7 sleep(1)\n", "[7] [failure] : [execute failed]\n"),
        ("req 8 get_actual_(\n", "[8] [failure] : [parse failed]\n"),
        (
            "get_actual_joint_positions()\n",
            "[-1] [failure] : [parse failed]\n",
        ),
        ("req x 1\n", "[-1] [failure] : [parse failed]\n"),
    ] {
        assert_eq!(asked(text), failure, "{text}");
    }
    let never = Instant::now();
    assert_eq!(
        asked("req 9 [0 for x in iter(int, 1)]\n"),
        "[9] [failure] : [execute failed]\n"
    );
    assert!(never.elapsed() < Duration::from_secs(5));
    assert_eq!(
        asked("req 10 [1, 'a', True, None, [2.5]]\n"),
        "[10] [success] : [[1, 'a', True, None, [2.500000]]]\n"
    );

    assert_eq!(
        asked("req 11 'a' * 100000\n"),
        "[11] [failure] : [execute failed]\n"
    );

    // A program runs beside: its globals are seen, and it is not disturbed.
    let mut dashboard = Dashboard::connect(&server);
    assert_eq!(
        dashboard.ask("task -s"),
        "Task is stopped",
        "questions are no task"
    );
    server.primary().send(
        "def counting():\n  global n\n  n = 41\n  while True:\n    sleep(0.01)\n  end\nend\n",
    );
    until("the global is there", || {
        asked("req 11 n + 1\n") == "[11] [success] : [42]\n"
    });
    assert_eq!(
        asked("req 12 undefined_name\n"),
        "[12] [failure] : [execute failed]\n"
    );
    assert_eq!(dashboard.ask("task -s"), "Task is running");
    // Several at once, each answered.
    client
        .write_all(b"req 21 1+1\nreq 22 2+2\nreq 23 3+3\n")
        .unwrap();
    let mut lines = BufReader::new(client.try_clone().unwrap()).lines();
    let answers: Vec<String> = (0..3).map(|_| lines.next().unwrap().unwrap()).collect();
    assert_eq!(
        answers,
        [
            "[21] [success] : [2]",
            "[22] [success] : [4]",
            "[23] [success] : [6]"
        ]
    );
    dashboard.ask("stop");
    assert!(server.terminate().success());
}

/// The next message: its type and its length.
fn message(stream: &mut TcpStream) -> Option<(u8, Vec<u8>)> {
    let mut head = [0; 5];
    stream.read_exact(&mut head).ok()?;
    let mut body = vec![0; u32::from_be_bytes(*head.first_chunk().unwrap()) as usize - 5];
    stream.read_exact(&mut body).ok()?;
    Some((head[4], body))
}

#[test]
fn local_mode_closes_the_primary_port_and_leaves_the_state_port() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let server = server(folder.path(), &[]);
    let mut listener = connect(&server, "primary");
    let mut state = connect(&server, "state");
    state
        .write_all(b"def f():\n  set_standard_digital_out(1, True)\nend\nhalt()\n")
        .unwrap();
    assert_eq!(message(&mut state).unwrap().0, 16);
    assert_eq!(message(&mut listener).unwrap().0, 16);
    let mut plc = connect(&server, "modbus");
    let mut dashboard = Dashboard::connect(&server);
    assert_eq!(dashboard.ask("remoteControl -off"), "Remote control is off");
    assert_eq!(words(&mut plc, 71, 1), [1]);
    // Whoever listened is told why, and closed; so is whoever comes now.
    for mut client in [listener, connect(&server, "primary")] {
        let mut last = Vec::new();
        while let Some((kind, body)) = message(&mut client) {
            if kind == 20 {
                last = body;
            }
        }
        let text = String::from_utf8_lossy(&last);
        assert!(text.contains("in local control mode"), "{text:?}");
    }
    for _ in 0..5 {
        assert_eq!(message(&mut state).unwrap().0, 16);
    }
    assert_eq!(
        words(&mut plc, 2, 1),
        [0],
        "nothing gets in at the state port"
    );
    assert!(dashboard.ask("play").contains("local control mode"));
    assert_eq!(dashboard.ask("remoteControl -on"), "Remote control is on");
    assert_eq!(message(&mut connect(&server, "primary")).unwrap().0, 16);
    assert!(server.terminate().success());
}

#[test]
fn in_mixed_mode_programs_come_in_and_the_dashboard_starts_none() {
    let folder = tempfile::tempdir().unwrap();
    let server = server(folder.path(), &["--control", "mixed"]);
    let mut plc = connect(&server, "modbus");
    assert_eq!(words(&mut plc, 71, 1), [0]);
    server.primary().send("set_standard_digital_out(1, True)\n");
    until("it runs", || words(&mut plc, 2, 1) == [2]);
    let mut dashboard = Dashboard::connect(&server);
    for order in ["play", "stop", "remoteControl -on"] {
        let reply = dashboard.ask(order);
        assert!(reply.contains("remote control is disabled"), "{reply}");
    }
    assert_eq!(dashboard.ask("remoteControl -s"), "false");
    assert!(server.terminate().success());
}

#[test]
fn the_dashboard_greets_in_four_lines_and_releases_brakes_without_power() {
    let folder = tempfile::tempdir().unwrap();
    let server = server(folder.path(), &["--powered-off"]);
    let mut client = connect(&server, "dashboard");
    let mut greeting = [0; 512];
    let count = client.read(&mut greeting).unwrap();
    let greeting = std::str::from_utf8(&greeting[..count]).unwrap();
    assert!(
        greeting.starts_with("EliRobot dashboard shell, version 2.15."),
        "{greeting}"
    );
    assert_eq!(greeting.matches("\r\n").count(), 4);
    let mut dashboard = Dashboard::connect(&server);
    assert_eq!(dashboard.ask("brakeRelease"), "Brake Releasing");
    until("the arm runs", || {
        dashboard.ask("robotMode") == "robotMode: RUNNING"
    });
    assert_eq!(dashboard.ask("status"), "Target Speed Fraction: 100");
    assert!(server.terminate().success());
}

#[test]
fn dashboard_commands_of_one_write_begin_together_and_do_not_wait_for_each_other() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let server = server(folder.path(), &[]);
    let mut client = connect(&server, "dashboard");
    let mut buffer = [0; 4096];
    let _greeting = client.read(&mut buffer).unwrap();
    // The vendor warns of this: when the brakes are asked for, the power is not off yet.
    client
        .write_all(b"robotControl -off\nrobotControl -on\nbrakeRelease\necho\n")
        .unwrap();
    let mut text = String::new();
    while text.matches("\r\n").count() < 4 {
        let count = client.read(&mut buffer).unwrap();
        text.push_str(std::str::from_utf8(&buffer[..count]).unwrap());
    }
    assert_eq!(
        text,
        "Powering off\r\nPowering on\r\nBrake is released.\r\nHello ELITE ROBOTS.\r\n"
    );
    let mut dashboard = Dashboard::connect(&server);
    for _ in 0..10 {
        assert_ne!(dashboard.ask("robotMode"), "robotMode: RUNNING");
        std::thread::sleep(Duration::from_millis(100));
    }
    // One by one they are.
    for (order, mode) in [
        ("robotControl -off", "robotMode: POWER_OFF"),
        ("robotControl -on", "robotMode: IDLE"),
        ("brakeRelease", "robotMode: RUNNING"),
    ] {
        dashboard.ask(order);
        until(mode, || dashboard.ask("robotMode") == mode);
    }
    assert!(server.terminate().success());
}

/// While nothing may move, a driver that scales its trajectory by this has to stand still.
#[test]
fn the_speed_scaling_is_0_while_paused_stopped_or_without_power() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let server = server(folder.path(), &[]);
    let mut dashboard = Dashboard::connect(&server);
    let scaling = || {
        let mut page = connect(&server, "http");
        page.write_all(b"GET /metrics HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n")
            .unwrap();
        let mut text = String::new();
        page.read_to_string(&mut text).unwrap();
        let line = text
            .lines()
            .find_map(|line| line.strip_prefix("elite_speed_scaling "));
        line.unwrap().trim().parse::<f64>().unwrap()
    };
    for body in [
        "movej([1, -1.5, 1.5, 0, 1, 0], a=1, v=0.1)",
        "speedj([0.05, 0, 0, 0, 0, 0], 1, 0.1)",
        "servoj(get_target_joint_positions(), t=0.004)",
        "sleep(0.1)",
    ] {
        let text = format!("def f():\n  while True:\n    {body}\n  end\nend\n");
        server.primary().send(&text);
        until("it runs", || dashboard.ask("task -s") == "Task is running");
        dashboard.ask("speed -v 50");
        until("half speed", || (scaling() - 0.5).abs() < 1e-9);
        dashboard.ask("pause");
        until(body, || scaling() == 0.0);
        assert_eq!(dashboard.ask("speed"), "speed: 50");
        dashboard.ask("play");
        until("it goes on", || (scaling() - 0.5).abs() < 1e-9);
        dashboard.ask("stop");
        until("it ends", || dashboard.ask("task -s") == "Task is stopped");
    }
    dashboard.ask("robotControl -off");
    until("no power", || scaling() == 0.0);
    assert!(server.terminate().success());
}

/// Bytes go both ways between a client and what hangs on the tool's line, with the settings of a program.
#[test]
fn the_tools_serial_line_is_forwarded_where_it_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let device = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = device.local_addr().unwrap();
    let cell = format!("[[serial]]\nport = \"tool\"\ndevice = \"tcp:{address}\"\n");
    std::fs::write(folder.path().join("cell.toml"), cell).unwrap();
    std::thread::spawn(move || {
        // A gripper that says back what it hears.
        while let Ok((mut stream, _)) = device.accept() {
            let mut bytes = [0; 64];
            while let Ok(count @ 1..) = stream.read(&mut bytes) {
                stream.write_all(&bytes[..count]).unwrap();
            }
        }
    });
    let server = server(
        folder.path(),
        &["--cell", "cell.toml", "--tool-serial-port", "0"],
    );
    // Nobody has opened the line: the client is turned away.
    let mut early = connect(&server, "tool-serial");
    assert_eq!(early.read(&mut [0]).unwrap_or(0), 0);
    server
        .primary()
        .send("def f():\n  tool_serial_config(True, 115200, 0, 1)\n  set_standard_digital_out(0, True)\nend\n");
    let mut plc = connect(&server, "modbus");
    until("the line is open", || words(&mut plc, 2, 1) == [1]);
    let mut client = connect(&server, "tool-serial");
    client.write_all(&[9, 3, 0x07, 0xD0, 0, 255, 10]).unwrap();
    let mut answer = [0; 7];
    client.read_exact(&mut answer).unwrap();
    assert_eq!(answer, [9, 3, 0x07, 0xD0, 0, 255, 10]);
    let mut second = connect(&server, "tool-serial");
    assert_eq!(second.read(&mut [0]).unwrap_or(0), 0, "one at a time");
    assert!(server.terminate().success());
}

/// `replay` of a file with options; what it says when it refuses them.
fn refused_replay(file: &Path, options: &[&str]) -> String {
    let output = eliteserver()
        .arg("replay")
        .arg(file)
        .args(options)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn a_recording_is_sent_through_the_state_port_too_and_ports_that_take_orders_are_refused() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let (recording, ready) = (
        folder.path().join("r.mcap"),
        folder.path().join("ready.json"),
    );
    let output = run_script(folder.path(), "sleep(3)\n", &["--record", "r.mcap"]);
    assert!(output.status.success(), "{output:?}");
    let ports = [
        "--primary-port",
        "0",
        "--rtsi-port",
        "off",
        "--http-port",
        "off",
    ];
    let replay = eliteserver()
        .args(["replay", "--serve", "--ready-file"])
        .arg(&ready)
        .args(ports)
        .arg(&recording)
        .stdout(std::process::Stdio::null())
        .stderr(std::fs::File::create(folder.path().join("stderr.log")).unwrap())
        .spawn()
        .unwrap();
    let server = Server::adopt(replay, &ready, folder.path());
    let mut state = connect(&server, "state");
    for _ in 0..3 {
        assert_eq!(message(&mut state).unwrap().0, 16);
    }
    for order in ["--query-port", "--tool-serial-port", "--dashboard-port"] {
        let told = refused_replay(&recording, &["--serve", order, "0"]);
        assert!(told.contains(order), "{order}: {told}");
    }
    for port in ["--state-port", "--primary-port"] {
        let told = refused_replay(&recording, &[port, "0"]);
        assert!(told.contains("--serve"), "{port}: {told}");
    }
}
