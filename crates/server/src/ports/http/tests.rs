//! The pages over real connections, and what is not a request.

use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use kinematics::JointPositions;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::task::JoinHandle;

use super::connection::{HEAD_BYTES_MAX, HEAD_TIMEOUT};
use super::*;
use crate::ports::allowed_hosts::tests::FOREIGN_HOSTS;

#[derive(Default)]
struct Fake {
    cycle: AtomicU64,
    set: Mutex<Vec<io::IoChanges>>,
    /// Why inputs cannot be set.
    not_set: Mutex<Option<SetInputsError>>,
    /// No cycle comes any more.
    stands: AtomicBool,
}

impl HttpBackend for Fake {
    fn state(&self) -> RobotState {
        let mut state = RobotState::at_start(JointPositions::ZERO, 0.004);
        state.cycle = self.cycle.load(Ordering::Relaxed);
        state.time = 12.5;
        state.step_duration_us = 250.0;
        state.wakeup_latency_us = 50.0;
        state.records_lost = 3;
        state
    }
    fn task_status(&self) -> TaskStatus {
        TaskStatus::Paused
    }
    fn panel(&self) -> serde_json::Value {
        serde_json::json!({"task": "paused"})
    }
    fn figures(&self) -> Figures {
        let mut figures = Figures {
            overruns: 2,
            missed_cycles: 1,
            commands_waiting: 4,
            statements_waiting: 17,
            errors: [
                ("script", 2),
                ("stop", 1),
                ("alarm", 0),
                ("recording", 0),
                ("other", 5),
            ],
            recording: Some(metrics::RecordingFigures {
                bytes: 123_456,
                records_waiting: 9,
                notes_dropped: 1,
                note_bytes_waiting: 4096,
                texts_cut: 2,
                has_failed: false,
            }),
            ..Figures::default()
        };
        figures.cycle_durations.counts = [0, 1, 2, 3, 0, 0, 0, 0, 0, 0, 0, 0, 1];
        figures.cycle_durations.sum_ns = 150_000_000;
        figures
    }
    fn registers(&self) -> RegisterImages {
        RegisterImages::default()
    }
    fn set_inputs(&self, changes: &io::IoChanges) -> Result<(), SetInputsError> {
        if let Some(reason) = self.not_set.lock().clone() {
            return Err(reason);
        }
        self.set.lock().push(changes.clone());
        if !self.stands.load(Ordering::Relaxed) {
            self.cycle.fetch_add(2, Ordering::Relaxed);
        }
        Ok(())
    }
}

async fn port(source: Arc<Fake>) -> (SocketAddr, CancellationToken, JoinHandle<()>) {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    let shutdown = CancellationToken::new();
    let meter = PortMeter::new("http");
    let ports = vec![PortMeter::new("primary"), meter.clone()];
    let callers = AllowedHosts::of(address.ip(), None, &[]);
    let served = serve(
        listener,
        HttpService::of(source, ports),
        meter,
        callers,
        shutdown.clone(),
    );
    let port = tokio::spawn(served);
    (address, shutdown, port)
}

/// Sends `request` and reads until the server closes.
async fn answer(address: SocketAddr, request: &str) -> String {
    let mut stream = TcpStream::connect(address).await.unwrap();
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut answer = Vec::new();
    // A server that closes with unread bytes resets the connection; what it said before counts.
    let _ = stream.read_to_end(&mut answer).await;
    String::from_utf8(answer).unwrap()
}

async fn get_page(address: SocketAddr, path: &str) -> String {
    answer(
        address,
        &format!("GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n"),
    )
    .await
}

#[tokio::test]
async fn metrics_are_in_the_text_format() {
    let source = Arc::new(Fake::default());
    source.cycle.store(3125, Ordering::Relaxed);
    let (address, shutdown, port) = port(source).await;
    let page = get_page(address, "/metrics").await;
    let (head, body) = page.split_once("\r\n\r\n").unwrap();
    assert!(head.starts_with("HTTP/1.1 200 OK"), "{head}");
    assert!(
        head.contains("content-type: text/plain; version=0.0.4; charset=utf-8"),
        "{head}"
    );
    insta::assert_snapshot!(body);
    shutdown.cancel();
    port.await.unwrap();
}

#[tokio::test]
async fn health_is_a_cycle_counter_that_moves() {
    let source = Arc::new(Fake::default());
    let shared = || {
        State(Arc::new(HttpContext {
            source: Arc::clone(&source),
            ports: Vec::new(),
            pulse: Mutex::default(),
        }))
    };
    tokio::time::pause();
    let shared = shared();
    assert_eq!(healthz(shared.clone()).await.status(), 200);
    tokio::time::advance(Duration::from_millis(900)).await;
    assert_eq!(healthz(shared.clone()).await.status(), 200);
    tokio::time::advance(Duration::from_millis(200)).await;
    assert_eq!(healthz(shared.clone()).await.status(), 503);
    source.cycle.store(1, Ordering::Relaxed);
    assert_eq!(healthz(shared).await.status(), 200);
}

#[tokio::test]
async fn other_pages_methods_and_nonsense_are_refused() {
    let (address, shutdown, port) = port(Arc::default()).await;
    for (request, status) in [
        (
            "GET / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n",
            "404",
        ),
        (
            "POST /metrics HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\nConnection: close\r\n\r\n",
            "405",
        ),
        ("stop task\n\n", "400"),
    ] {
        let page = answer(address, request).await;
        assert!(
            page.starts_with(&format!("HTTP/1.1 {status}")),
            "{request}: {page}"
        );
    }
    let long = format!("GET /{} HTTP/1.1\r\n\r\n", "x".repeat(2 * HEAD_BYTES_MAX));
    let page = answer(address, &long).await;
    assert!(page.is_empty() || page.starts_with("HTTP/1.1 4"), "{page}");
    let health = get_page(address, "/healthz").await;
    let (head, body) = health.split_once("\r\n\r\n").unwrap();
    assert!(head.starts_with("HTTP/1.1 200"), "{head}");
    let body: serde_json::Value = serde_json::from_str(body).unwrap();
    assert_eq!(body["status"], "ok");
    assert_eq!(body["task"], "paused");
    assert_eq!(body["recording"], "active");
    assert_eq!(body["records_lost"], 3);
    assert_eq!(body["clients"]["primary"], 0);
    shutdown.cancel();
    port.await.unwrap();
}

#[tokio::test]
async fn an_idle_connection_does_not_hold_up_the_end() {
    let (address, shutdown, port) = port(Arc::default()).await;
    let mut idle = TcpStream::connect(address).await.unwrap();
    idle.write_all(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n")
        .await
        .unwrap();
    let mut byte = [0];
    idle.read_exact(&mut byte).await.unwrap();
    shutdown.cancel();
    tokio::time::timeout(Duration::from_millis(800), port)
        .await
        .unwrap()
        .unwrap();
}

#[tokio::test]
async fn the_panel_is_json() {
    let (address, _shutdown, _port) = port(Arc::default()).await;
    let page = get_page(address, "/panel").await;
    assert!(page.contains("content-type: application/json"), "{page}");
    assert!(page.ends_with("{\"task\":\"paused\"}\n"), "{page}");
}

async fn post_inputs(address: SocketAddr, headers: &str, body: &str) -> String {
    let length = body.len();
    let request = format!(
        "POST /api/inputs HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\nContent-Length: {length}\r\n\
         {headers}\r\n{body}"
    );
    answer(address, &request).await
}

const JSON: &str = "Content-Type: application/json\r\n";

#[tokio::test]
async fn inputs_are_set_by_programs_and_by_our_own_pages() {
    let source = Arc::new(Fake::default());
    let (address, _shutdown, _port) = port(source.clone()).await;
    let body = r#"{"standard_digital_in[3]": true}"#;
    let own = format!("{JSON}Origin: http://{address}\r\n");
    for (headers, after) in [(JSON, 0), (&own, 2)] {
        let page = post_inputs(address, headers, body).await;
        assert!(page.starts_with("HTTP/1.1 200"), "{page}");
        let end = format!("{{\"after_cycle\":{after}}}\n");
        assert!(page.ends_with(&end), "{page}");
    }
    let (mask, levels) = (1 << 3, 1 << 3);
    let wanted = io::IoChanges {
        points: vec![motion_api::IoChange::DigitalIn { mask, levels }],
        registers: Vec::new(),
    };
    assert_eq!(*source.set.lock(), [wanted.clone(), wanted]);
}

#[tokio::test]
async fn what_may_not_or_cannot_be_set_is_answered_with_a_reason() {
    let source = Arc::new(Fake::default());
    let (address, _shutdown, _port) = port(source.clone()).await;
    let foreign = format!("{JSON}Origin: http://evil.example\r\n");
    let form = "Content-Type: text/plain\r\n";
    let long = format!("{{\"a\": \"{}\"}}", "x".repeat(BODY_BYTES_MAX));
    for (headers, body, status, words) in [
        (
            foreign.as_str(),
            "{}",
            "403",
            "a page of http://evil.example",
        ),
        (form, "{}", "415", "must be application/json"),
        (
            JSON,
            "{\"nonsense\": 1}",
            "422",
            "`nonsense` is no input or output",
        ),
        (JSON, &long, "413", "longer than 65536 bytes"),
    ] {
        let page = post_inputs(address, headers, body).await;
        assert!(page.starts_with(&format!("HTTP/1.1 {status}")), "{page}");
        assert!(page.contains("content-type: application/json"), "{page}");
        assert!(
            page.contains("{\"error\":\"") && page.contains(words),
            "{page}"
        );
    }
    // What a browser asks before it sends JSON to another origin.
    for (origin, status) in [("http://evil.example", 403), ("http://localhost:3000", 405)] {
        let question = format!(
            "OPTIONS /api/inputs HTTP/1.1\r\nHost: {address}\r\nOrigin: {origin}\r\nConnection: close\r\n\r\n"
        );
        let page = answer(address, &question).await;
        assert!(page.starts_with(&format!("HTTP/1.1 {status}")), "{page}");
        assert!(!page.contains("access-control"), "{page}");
    }
    assert!(source.set.lock().is_empty());
}

#[tokio::test]
async fn a_body_that_never_comes_ends_the_request() {
    let (address, _shutdown, _port) = port(Arc::default()).await;
    tokio::time::pause();
    let request = format!(
        "POST /api/inputs HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\nContent-Length: 9\r\n{JSON}\r\n{{"
    );
    let page = answer(address, &request).await;
    assert!(page.starts_with("HTTP/1.1 408"), "{page}");
}

#[tokio::test]
async fn every_input_and_output_is_shown() {
    let (address, _shutdown, _port) = port(Arc::default()).await;
    let page = get_page(address, "/api/io").await;
    let (head, body) = page.split_once("\r\n\r\n").unwrap();
    assert!(head.contains("content-type: application/json"), "{head}");
    let page: serde_json::Value = serde_json::from_str(body).unwrap();
    assert_eq!(page["points"]["input_boolean_register[127]"], false);
}

const PAGES: [&str; 4] = ["/healthz", "/metrics", "/panel", "/api/io"];

#[tokio::test]
async fn no_page_is_shown_to_pages_of_others() {
    let (address, _shutdown, _port) = port(Arc::default()).await;
    let ask = async |page: &str, head: &str| {
        answer(
            address,
            &format!("GET {page} HTTP/1.1\r\n{head}Connection: close\r\n\r\n"),
        )
        .await
    };
    for page in PAGES {
        let shown = ask(
            page,
            "Host: LOCALHOST.:1\r\nOrigin: http://127.0.0.1:3000\r\n",
        )
        .await;
        assert!(shown.starts_with("HTTP/1.1 200"), "{page}: {shown}");
        for head in [
            "Host: evil.example\r\n",
            "Host: localhost\r\nOrigin: http://evil.example\r\n",
            "Host: evil.example\r\nOrigin: http://evil.example\r\n",
            "Host: localhost\r\nOrigin: null\r\n",
            "Host: localhost\r\nHost: evil.example\r\n",
        ] {
            let refused = ask(page, head).await;
            assert!(
                refused.starts_with("HTTP/1.1 403"),
                "{page} {head}: {refused}"
            );
            assert!(refused.contains("{\"error\":\"the request "), "{refused}");
        }
        let whole = ask(&format!("http://evil.example{page}"), "Host: localhost\r\n").await;
        assert!(whole.starts_with("HTTP/1.1 403"), "{whole}");
        let nameless = ask(page, "").await;
        assert!(nameless.starts_with("HTTP/1.1 400"), "{nameless}");
    }
    for host in FOREIGN_HOSTS {
        let refused = ask("/panel", &format!("Host: {host}\r\n")).await;
        assert!(refused.starts_with("HTTP/1.1 403"), "{host}: {refused}");
    }
    let old = answer(address, "GET /healthz HTTP/1.0\r\n\r\n").await;
    assert!(old.starts_with("HTTP/1.0 200"), "{old}");
}

#[tokio::test]
async fn every_request_of_a_connection_is_looked_at() {
    let (address, _shutdown, _port) = port(Arc::default()).await;
    let good = "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n";
    let evil = "GET /panel HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n";
    let pages = answer(address, &format!("{good}{good}{evil}")).await;
    assert_eq!(pages.matches("HTTP/1.1 200").count(), 2, "{pages}");
    assert_eq!(pages.matches("HTTP/1.1 403").count(), 1, "{pages}");
}

#[tokio::test]
async fn inputs_that_were_not_taken_are_not_said_to_be_set() {
    let source = Arc::new(Fake::default());
    let (address, _shutdown, _port) = port(source.clone()).await;
    for (reason, status) in [
        (
            SetInputsError::ReadOnly(messages::Text::verbatim("a recording")),
            409,
        ),
        (
            SetInputsError::Unavailable(messages::Text::verbatim("nothing was set: full")),
            503,
        ),
    ] {
        *source.not_set.lock() = Some(reason);
        let page = post_inputs(address, JSON, "{}").await;
        assert!(page.starts_with(&format!("HTTP/1.1 {status}")), "{page}");
        assert!(page.contains("{\"error\":\""), "{page}");
    }
    *source.not_set.lock() = None;
    source.stands.store(true, Ordering::Relaxed);
    let page = post_inputs(address, JSON, "{}").await;
    assert!(page.starts_with("HTTP/1.1 503"), "{page}");
    assert!(page.contains("wait for a cycle"), "{page}");
}

#[tokio::test]
async fn a_head_that_comes_drop_by_drop_is_not_waited_for() {
    let (address, _shutdown, _port) = port(Arc::default()).await;
    for head in ["", "GET /healthz HTTP/1.1\r\nHost: localhost\r\nX: "] {
        let mut stream = TcpStream::connect(address).await.unwrap();
        stream.write_all(head.as_bytes()).await.unwrap();
        let (mut reader, mut writer) = stream.split();
        let start = Instant::now();
        tokio::time::pause();
        let drops = async {
            while writer.write_all(b"x").await.is_ok() && !head.is_empty() {
                tokio::time::sleep(Duration::from_secs(1)).await;
            }
            std::future::pending::<()>().await;
        };
        let mut rest = Vec::new();
        tokio::select! {
            _ = reader.read_to_end(&mut rest) => {}
            () = drops, if !head.is_empty() => {}
        }
        assert!(start.elapsed() < 2 * HEAD_TIMEOUT, "{:?}", start.elapsed());
        tokio::time::resume();
    }
}
