//! The interface behind the page over real sockets, as a program uses it: token and control, frames, what is held and
//! how it ends, what is refused, and searches through the recording that is being made. Browsers are tried in
//! `web/browser`.

#![allow(clippy::unwrap_used, reason = "a test helper fails by panicking")]

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use crate::common::{self, PATIENCE, Server};
use serde_json::{Value, json};
use tokio_tungstenite::tungstenite::{Message, WebSocket, client};

/// Bytes of a frame, and where in it what the tests look at is (docs/api.md).
const FRAME_BYTES: usize = 392;
const NUMBER: usize = 4;
const TIME: usize = 8;
const ACTUAL_Q: usize = 120;
const ACTUAL_QD: usize = 168;

/// A request with a body; the status and the answer.
fn post(server: &Server, path: &str, token: &str, body: &str) -> (u16, Value) {
    let mut stream = TcpStream::connect(("127.0.0.1", server.ports["http"])).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    let request = format!(
        "POST {path} HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {token}\r\nContent-Type: application/json\r\n\
         Content-Length: {}\r\nConnection: close\r\n\r\n{body}",
        body.len()
    );
    stream.write_all(request.as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    let status = head.split(' ').nth(1).unwrap().parse().unwrap();
    (status, serde_json::from_str(body).unwrap_or(Value::Null))
}

fn token_of(server: &Server) -> String {
    let (status, body) = server.page("/api/v1/session");
    assert_eq!(status, 200, "{body}");
    let session: Value = serde_json::from_str(&body).unwrap();
    session["token"].as_str().unwrap().to_owned()
}

/// A live view.
struct Page {
    socket: WebSocket<TcpStream>,
    number: u64,
    frame: Vec<u8>,
}

impl Page {
    fn open(server: &Server) -> Self {
        let stream = TcpStream::connect(("127.0.0.1", server.ports["http"])).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let address = format!("ws://127.0.0.1:{}/api/v1/live", server.ports["http"]);
        let (socket, _) = client(address, stream).unwrap();
        Page {
            socket,
            number: 0,
            frame: Vec::new(),
        }
    }

    fn send(&mut self, message: Value) {
        self.socket
            .send(Message::text(message.to_string()))
            .unwrap();
    }

    /// The next message that is text; frames are kept as they come.
    fn text(&mut self) -> Value {
        loop {
            match self.socket.read().unwrap() {
                Message::Text(text) => return serde_json::from_str(&text).unwrap(),
                Message::Binary(frame) => self.frame = frame.to_vec(),
                _ => {}
            }
        }
    }

    /// The next frame.
    fn frame(&mut self) -> Vec<u8> {
        loop {
            if let Message::Binary(frame) = self.socket.read().unwrap() {
                return frame.to_vec();
            }
        }
    }

    /// Asks without waiting; the number of the question.
    fn begin(&mut self, mut message: Value) -> u64 {
        self.number += 1;
        message["id"] = self.number.into();
        self.send(message);
        self.number
    }

    /// The answer to a question.
    fn answer(&mut self, number: u64) -> Value {
        loop {
            let text = self.text();
            if text["answer"] == number {
                return text;
            }
        }
    }

    fn ask(&mut self, message: Value) -> Value {
        let number = self.begin(message);
        self.answer(number)
    }

    /// Gives the token and takes control.
    fn take_control(&mut self, token: &str) {
        assert_eq!(self.ask(json!({"token": token}))["ok"], true);
        assert_eq!(self.ask(json!({"control": true}))["ok"], true);
    }
}

fn f32_at(frame: &[u8], offset: usize) -> f32 {
    f32::from_le_bytes(frame[offset..offset + 4].try_into().unwrap())
}

fn f64_at(frame: &[u8], offset: usize) -> f64 {
    f64::from_le_bytes(frame[offset..offset + 8].try_into().unwrap())
}

#[test]
fn frames_have_the_layout_that_is_documented() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let (_, about) = server.page("/api/v1");
    let about: Value = serde_json::from_str(&about).unwrap();
    assert_eq!(about["frame"], json!({"version": 1, "bytes": FRAME_BYTES}));

    let mut page = Page::open(&server);
    let welcome = loop {
        let event = page.text();
        if event["event"] == "welcome" {
            break event;
        }
    };
    assert_eq!(welcome["read_only"], Value::Null);
    let first = page.frame();
    let mut last = first.clone();
    for _ in 0..10 {
        let frame = page.frame();
        assert_eq!(frame.len(), FRAME_BYTES);
        assert_eq!(frame[..4], [1, 0, 136, 1], "version and length");
        let number =
            |frame: &[u8]| u32::from_le_bytes(frame[NUMBER..NUMBER + 4].try_into().unwrap());
        assert!(number(&frame) > number(&last));
        assert!(f64_at(&frame, TIME) >= f64_at(&last, TIME));
        last = frame;
    }
    let (_, state) = server.page("/api/v1/state");
    let state: Value = serde_json::from_str(&state).unwrap();
    for joint in 0..6 {
        let told = state["actual_q"][joint].as_f64().unwrap();
        assert!((f64::from(f32_at(&last, ACTUAL_Q + 4 * joint)) - told).abs() < 1e-3);
    }
}

#[test]
fn orders_need_the_token_and_control_and_one_page_has_it() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let token = token_of(&server);
    let speed = json!({"do": "speed", "fraction": 0.5}).to_string();

    let (status, refused) = post(&server, "/api/v1/orders", "no token", &speed);
    assert_eq!(status, 401, "{refused}");
    assert_eq!(post(&server, "/api/v1/orders", &token, &speed).0, 200);

    let mut one = Page::open(&server);
    let order = json!({"order": {"do": "speed", "fraction": 0.4}});
    assert_eq!(one.ask(order.clone())["ok"], false, "without the token");
    assert_eq!(one.ask(json!({"token": "guessed"}))["ok"], false);
    assert_eq!(one.ask(json!({"token": token}))["ok"], true);
    assert_eq!(one.ask(order.clone())["ok"], false, "without control");
    assert_eq!(one.ask(json!({"control": true}))["ok"], true);
    assert_eq!(one.ask(order.clone())["ok"], true);
    // A program of another maker has its turn when the page has gone.
    let (status, refused) = post(&server, "/api/v1/orders", &token, &speed);
    assert_eq!(status, 409, "{refused}");

    let mut other = Page::open(&server);
    other.take_control(&token);
    assert_eq!(one.ask(order.clone())["ok"], false, "control was taken");
    assert_eq!(other.ask(order)["ok"], true);
    drop(other);
    let began = Instant::now();
    while post(&server, "/api/v1/orders", &token, &speed).0 != 200 {
        assert!(began.elapsed() < PATIENCE, "control is not given up");
        std::thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn what_is_held_ends_with_the_signs_of_life() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let token = token_of(&server);
    let mut page = Page::open(&server);
    page.take_control(&token);
    let jog = page.begin(json!({"order": {"do": "jog", "axis": "j1", "speed": 0.5}}));
    let began = Instant::now();
    let before = page.frame();
    while began.elapsed() < Duration::from_millis(600) {
        page.send(json!({"alive": true}));
        page.frame();
    }
    let moving = page.frame();
    assert!(f32_at(&moving, ACTUAL_QD) > 0.1, "it jogs");
    // No more signs of life.
    let ended = page.answer(jog);
    let reason = ended["error"].as_str().unwrap();
    assert!(reason.contains("sign of life"), "{reason}");
    let began = Instant::now();
    loop {
        let frame = page.frame();
        if f32_at(&frame, ACTUAL_QD).abs() < 1e-3 {
            assert!(f32_at(&frame, ACTUAL_Q) > f32_at(&before, ACTUAL_Q) + 0.05);
            break;
        }
        assert!(began.elapsed() < PATIENCE, "the arm goes on");
    }
}

#[test]
fn what_is_no_message_is_told_so_and_the_page_stays() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let token = token_of(&server);
    let mut page = Page::open(&server);
    page.take_control(&token);
    for wrong in [
        json!({"order": {"do": "fly"}}),
        json!({"order": {"do": "jog", "axis": "j7", "speed": 0.1}}),
        json!({"order": {"do": "jog", "axis": "j1", "speed": 7}}),
        json!({"order": {"do": "speed", "fraction": "fast"}}),
        json!({"order": {"do": "speed", "fraction": 0.5, "more": 1}}),
        json!({"order": {"do": "push", "wrench": [1, 2], "duration": 1}}),
    ] {
        let refused = page.ask(wrong.clone());
        assert_eq!(refused["ok"], false, "{wrong}");
        let text = refused["error"].as_str().unwrap();
        assert!(text.contains(' ') && text.len() < 400, "{wrong}: {text}");
    }
    assert_eq!(
        page.ask(json!({"order": {"do": "speed", "fraction": 1.0}}))["ok"],
        true
    );
}

#[test]
fn conditions_are_looked_for_in_the_recording_that_is_being_made() {
    let folder = tempfile::tempdir().unwrap();
    let record = folder.path().join("r.mcap");
    let options = ["--record", record.to_str().unwrap(), "--clock", "virtual"];
    let server = Server::start(folder.path(), &options);
    let token = token_of(&server);
    let text = "def p():\n  movej([0.5,-1.2,1.4,-1.77,-1.57,0],a=2,v=1)\n\
                \x20 movej([-0.5,-1.2,1.4,-1.77,-1.57,0],a=2,v=1)\nend\n";
    let run = json!({"do": "run", "name": "p.script", "text": text}).to_string();
    assert_eq!(post(&server, "/api/v1/orders", &token, &run).0, 200);
    let condition = json!({"condition": "actual_qd[0] < -0.9"}).to_string();
    let began = Instant::now();
    let found = loop {
        let (status, found) = post(&server, "/api/v1/find", "", &condition);
        assert_eq!(status, 200, "{found}");
        // What the recorder has not written yet is found later.
        if found["stretches"].as_array().unwrap().len() == 1
            && found["stretches"][0]["to"] != found["stretches"][0]["from"]
        {
            break found;
        }
        assert!(began.elapsed() < PATIENCE, "{found}");
        std::thread::sleep(Duration::from_millis(100));
    };
    let stretch = &found["stretches"][0];
    assert_eq!(
        (&stretch["program"], &stretch["line"], &stretch["command"]),
        (&json!("p.script"), &json!(3), &json!("movej"))
    );
    assert_eq!(found["complete"], true);

    for (wrong, part) in [
        (
            json!({"condition": "nothing_of_the_kind > 1"}),
            "nothing_of_the_kind",
        ),
        (json!({"condition": "1 +"}), "cannot be read"),
        (json!({"condition": "[1][2]"}), "IndexError"),
        (json!({"condition": "x".repeat(5000)}), "4096"),
        (json!({"condition": 7}), "does not fit"),
        (json!({"other": "1"}), "does not fit"),
    ] {
        let (status, refused) = post(&server, "/api/v1/find", "", &wrong.to_string());
        let text = refused["error"].as_str().unwrap();
        assert!(status == 422 && text.contains(part), "{status} {text}");
    }
}

#[test]
fn a_recording_is_looked_at_and_takes_no_orders() {
    let folder = tempfile::tempdir().unwrap();
    let record = folder.path().join("r.mcap");
    let options = ["--record", record.to_str().unwrap()];
    let text = "movej([0.5,-1.2,1.4,-1.77,-1.57,0],a=2,v=1)\n";
    assert!(
        common::run_script(folder.path(), text, &options)
            .status
            .success()
    );
    let ready = folder.path().join("replay.json");
    let child = common::eliteserver()
        .args([
            "replay",
            "--serve",
            "--http-port",
            "0",
            "--primary-port",
            "0",
            "--rtsi-port",
            "0",
            "--ready-file",
        ])
        .arg(&ready)
        .arg(&record)
        .stdout(std::process::Stdio::null())
        .stderr(std::fs::File::create(folder.path().join("stderr.log")).unwrap())
        .spawn()
        .unwrap();
    let server = Server::adopt(child, &ready, folder.path());
    let (_, about) = server.page("/api/v1");
    let about: Value = serde_json::from_str(&about).unwrap();
    assert!(about["read_only"].is_string(), "{about}");

    let condition = json!({"condition": "command == \"movej\""}).to_string();
    let (status, found) = post(&server, "/api/v1/find", "", &condition);
    assert_eq!(
        (status, found["stretches"].as_array().map(Vec::len)),
        (200, Some(1)),
        "{found}"
    );
    let wrong = json!({"name": "p.script", "text": "mvej(1)\n"}).to_string();
    let (status, findings) = post(&server, "/api/v1/check", "", &wrong);
    assert!(
        status == 200 && findings.to_string().contains("movej"),
        "{findings}"
    );
    let speed = json!({"do": "speed", "fraction": 0.5}).to_string();
    let (status, refused) = post(&server, "/api/v1/orders", "", &speed);
    assert!(
        status == 409 && refused["error"].as_str().unwrap().contains("replay"),
        "{refused}"
    );
}

#[test]
fn texts_are_read_as_the_language_server_reads_them() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &["--record", "off"]);
    let ask = |path: &str, body: Value| post(&server, path, "", &body.to_string());
    let (status, found) = ask(
        "/api/v1/check",
        json!({"name": "a.script", "text": "x = (\n"}),
    );
    assert_eq!((status, &found[0]["severity"]), (200, &json!("error")));
    let (_, found) = ask("/api/v1/complete", json!({"text": "mov", "at": 3}));
    let items = found["items"].as_array().unwrap();
    assert!(items.iter().any(|item| item["label"] == "movej"), "{found}");
    assert_eq!((&found["from"], &found["to"]), (&json!(0), &json!(3)));
    let (_, about) = ask(
        "/api/v1/hover",
        json!({"text": "movej", "at": 2, "language": "zh"}),
    );
    assert!(about["text"].as_str().unwrap().contains("参数"), "{about}");
    let (_, call) = ask("/api/v1/call", json!({"text": "movej(", "at": 6}));
    assert_eq!(
        (
            &call["active"],
            call["label"].as_str().unwrap().starts_with("movej(")
        ),
        (&json!(0), true)
    );
    let (status, about) = server.page("/api/v1/builtins/movej?language=en");
    assert!(status == 200 && about.contains("Parameters"), "{about}");
    assert_eq!(server.page("/api/v1/builtins/nonsense").0, 404);
    let long = " ".repeat((1 << 20) + 1);
    for (body, part) in [
        (json!({"text": long}), "text is 1048577 bytes long"),
        (
            json!({"text": "", "name": "n".repeat(201)}),
            "name is 201 bytes long",
        ),
        (json!({"text": "", "at": -1}), "the body does not fit"),
        (json!({"text": "", "where": 1}), "unknown field `where`"),
    ] {
        for path in ["check", "complete", "hover", "call"] {
            let (status, answer) = ask(&format!("/api/v1/{path}"), body.clone());
            let said = answer["error"].as_str().unwrap_or_default();
            assert!(
                status == 422 && said.contains(part),
                "{path}: {status} {said}"
            );
        }
    }
}

#[test]
fn events_are_given_from_either_end_and_by_level() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &["--record", "off"]);
    let token = token_of(&server);
    let events = |query: &str| -> Vec<Value> {
        let (status, body) = server.page(&format!("/api/v1/events{query}"));
        assert_eq!(status, 200, "{body}");
        serde_json::from_str(&body).unwrap()
    };
    // Nobody looks at the page, so modes are looked at a few times a second: the second order waits until the first is
    // seen.
    for (seen, order) in [json!({"do": "power_off"}), json!({"do": "power_on"})]
        .iter()
        .enumerate()
    {
        let (status, _) = post(&server, "/api/v1/orders", &token, &order.to_string());
        assert_eq!(status, 200);
        let begin = Instant::now();
        while events("?level=3").len() <= seen {
            assert!(begin.elapsed() < PATIENCE, "{order} changes the mode");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
    let time = |events: &[Value]| events[0]["time"].as_f64().unwrap();
    let (first, latest) = (events("?level=3&most=1&first=1"), events("?level=3&most=1"));
    assert_eq!((first.len(), latest.len()), (1, 1));
    assert!(time(&first) <= time(&latest));
    assert_eq!(events("?level=6"), Vec::<Value>::new());
    assert_eq!(server.page("/api/v1/events?most=x").0, 422);
}

#[test]
fn a_server_that_records_nothing_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &["--record", "off"]);
    let condition = json!({"condition": "True"}).to_string();
    let (status, refused) = post(&server, "/api/v1/find", "", &condition);
    assert_eq!(status, 422);
    let text = refused["error"].as_str().unwrap();
    assert!(text.contains("records nothing"), "{text}");
}

/// The page and its parts are looked at; whoever wants something else of them is told so.
#[test]
fn a_page_is_only_looked_at() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    for method in ["POST", "PUT", "DELETE", "PATCH", "TRACE", "OPTIONS"] {
        for path in ["/", "/app.js", "/no-such-page"] {
            let mut stream = TcpStream::connect(("127.0.0.1", server.ports["http"])).unwrap();
            stream.set_read_timeout(Some(PATIENCE)).unwrap();
            let request = format!(
                "{method} {path} HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"
            );
            stream.write_all(request.as_bytes()).unwrap();
            let mut answer = String::new();
            stream.read_to_string(&mut answer).unwrap();
            assert!(
                answer.starts_with("HTTP/1.1 405 "),
                "{method} {path}: {answer}"
            );
            assert!(
                answer.to_lowercase().contains("allow: get, head"),
                "{method} {path}: {answer}"
            );
        }
    }
}

#[test]
fn outputs_are_set_by_hand() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let token = token_of(&server);
    let order = |values: Value| {
        let body = json!({"do": "outputs", "values": values}).to_string();
        post(&server, "/api/v1/orders", &token, &body)
    };
    let values = json!({"standard_digital_out[3]": true, "configurable_digital_out[1]": true,
        "standard_analog_out[0]": 2.5, "output_integer_register[7]": -4});
    assert_eq!(order(values.clone()).0, 200);
    let began = Instant::now();
    loop {
        let io: Value = serde_json::from_str(&server.page("/api/io").1).unwrap();
        let mut points = values.as_object().unwrap().iter();
        if points.all(|(name, value)| io["points"][name] == *value) {
            break;
        }
        assert!(began.elapsed() < PATIENCE, "{io}");
        std::thread::sleep(Duration::from_millis(10));
    }
    // All or none, and nothing that is no output.
    let both = json!({"standard_digital_out[3]": false, "standard_digital_in[0]": true});
    let (status, refused) = order(both);
    assert_eq!(status, 409);
    let sentence = "standard_digital_in[0] is an input; only outputs can be set here";
    assert_eq!(refused["error"], sentence);
    let io: Value = serde_json::from_str(&server.page("/api/io").1).unwrap();
    assert_eq!(io["points"]["standard_digital_out[3]"], true);
}

#[test]
fn alarms_are_told_in_both_languages_with_the_names_of_the_cell() {
    let folder = tempfile::tempdir().unwrap();
    let cell = folder.path().join("cell.toml");
    let fence = "[[safety_plane]]\nname = 'fence'\npoint = [0, 0, 0.3]\nnormal = [0, 0, 1]\n\
        [names]\n'standard_digital_out[1]' = 'vacuum'\n";
    std::fs::write(&cell, fence).unwrap();
    let server = Server::start(folder.path(), &["--cell", cell.to_str().unwrap()]);
    let token = token_of(&server);
    let scene: Value = serde_json::from_str(&server.page("/api/v1/scene").1).unwrap();
    assert_eq!(scene["names"]["standard_digital_out[1]"], "vacuum");
    let text = "def p():\n  while True:\n    speedl([0, 0, -0.2, 0, 0, 0], 1, 0.1)\n  end\nend\n";
    let run = json!({"do": "run", "name": "down.script", "text": text}).to_string();
    assert_eq!(post(&server, "/api/v1/orders", &token, &run).0, 200);
    let began = Instant::now();
    let alarm = loop {
        let events = server.page("/api/v1/events?level=4").1;
        let events: Vec<Value> = serde_json::from_str(&events).unwrap();
        if let Some(alarm) = events.into_iter().find(|one| one["event"] == "alarm") {
            break alarm;
        }
        assert!(began.elapsed() < PATIENCE, "no alarm");
        std::thread::sleep(Duration::from_millis(20));
    };
    assert_eq!((&alarm["program"], &alarm["line"]), (&json!(1), &json!(3)));
    let (english, chinese) = (&alarm["texts"]["en"], &alarm["texts"]["zh"]);
    assert_eq!(*english, alarm["text"]);
    let english = english.as_str().unwrap();
    assert!(
        english.contains("about to cross safety plane \"fence\""),
        "{english}"
    );
    let chinese = chinese.as_str().unwrap();
    assert!(
        chinese.contains("越过单元的安全平面 \"fence\""),
        "{chinese}"
    );
}

/// The head and the body of an answer.
fn get_bytes(server: &Server, path: &str, headers: &str) -> (String, Vec<u8>) {
    let mut stream = TcpStream::connect(("127.0.0.1", server.ports["http"])).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    let request =
        format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n{headers}Connection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    let end = answer.windows(4).position(|four| four == b"\r\n\r\n");
    let body = answer.split_off(end.unwrap() + 4);
    (String::from_utf8(answer).unwrap().to_lowercase(), body)
}

#[test]
fn a_mesh_is_sent_by_its_number_and_only_once_to_who_has_it() {
    let folder = tempfile::tempdir().unwrap();
    let cell = folder.path().join("cell.toml");
    let corner = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
    std::fs::write(folder.path().join("corner.obj"), corner).unwrap();
    let mesh = "shape = 'mesh'\nfile = 'corner.obj'\nscale = 0.5\n";
    let text = format!(
        "[[obstacle]]\nname = 'corner'\n{mesh}pose = [1, 1, 0, 0, 0, 0]\n[tool]\nshape = 'mesh'\n\
         file = 'corner.obj'\nscale = 0.05\npose = [0, 0, 0, 0, 0, 0]\n"
    );
    std::fs::write(&cell, text).unwrap();
    let options = ["--cell", cell.to_str().unwrap()];
    let server = Server::start(folder.path(), &options);
    let scene: Value = serde_json::from_str(&server.page("/api/v1/scene").1).unwrap();
    assert_eq!(scene["obstacles"][0]["mesh"], 0);
    assert_eq!(scene["tool"]["mesh"], 1);
    let (head, bytes) = get_bytes(&server, "/api/v1/meshes/0", "");
    assert!(head.starts_with("http/1.1 200"), "{head}");
    for line in [
        "content-type: application/octet-stream\r\n",
        "cache-control: no-cache\r\n",
        "content-length: 104\r\n",
    ] {
        assert!(head.contains(line), "{head}");
    }
    let word = |at: usize| <[u8; 4]>::try_from(&bytes[at..at + 4]).unwrap();
    assert_eq!(
        (u32::from_le_bytes(word(0)), u32::from_le_bytes(word(4))),
        (4, 4)
    );
    assert_eq!(f32::from_le_bytes(word(20)), 0.5);
    let corners = [56, 60, 64].map(|at| u32::from_le_bytes(word(at)));
    assert_eq!(corners, [0, 2, 1]);
    let mark = head.split("etag: ").nth(1).unwrap();
    let mark = mark.split("\r\n").next().unwrap();
    let (head, none) = get_bytes(
        &server,
        "/api/v1/meshes/0",
        &format!("If-None-Match: {mark}\r\n"),
    );
    assert!(
        head.starts_with("http/1.1 304") && none.is_empty(),
        "{head}"
    );
    let (head, other) = get_bytes(
        &server,
        "/api/v1/meshes/1",
        &format!("If-None-Match: {mark}\r\n"),
    );
    assert!(
        head.starts_with("http/1.1 200") && other.len() == 104,
        "{head}"
    );
    for unknown in [
        "2",
        "-1",
        "00000000000000000000001e9",
        "x",
        "99999999999999999999999",
    ] {
        let (status, body) = server.page(&format!("/api/v1/meshes/{unknown}"));
        let refused: Value = serde_json::from_str(&body).unwrap();
        assert_eq!(
            (status, &refused["error"]),
            (404, &json!("the scene has no mesh of this number"))
        );
        assert_eq!(refused["texts"]["zh"], "场景中没有此编号的网格");
    }
}
