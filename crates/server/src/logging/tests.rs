//! The fields of log lines, as people and as machines read them.

use std::io::{self, Write};
use std::sync::Arc;

use elite_runtime::message::{Message, Observer, Severity};
use kinematics::RobotModel;
use messages::Text;
use motion_api::{Origin, ProgramId, ThreadNumber};
use parking_lot::Mutex;
use tokio::io::AsyncReadExt as _;
use tokio::net::{TcpListener, TcpStream};
use tokio_util::sync::CancellationToken;

use super::*;
use crate::event_broadcast::{EventBroadcaster, PrintTarget};
use crate::log_dir::InterpreterLog;
use crate::ports::listen::{PortMeter, serve_port};
use crate::ports::peer::PortProtocol;
use crate::sample_feed::SampleFeed;

#[derive(Clone, Default)]
struct Lines(Arc<Mutex<Vec<u8>>>);

impl Write for Lines {
    fn write(&mut self, data: &[u8]) -> io::Result<usize> {
        self.0.lock().write(data)
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn announcer() -> EventBroadcaster {
    EventBroadcaster::new(
        PrintTarget::Log,
        InterpreterLog::default(),
        Arc::new(SampleFeed::new(Arc::new(
            RobotModel::built_in("cs66").unwrap(),
        ))),
    )
}

/// A program with two threads, a robot event, and a client of a port say something.
async fn say_something() {
    let announcer = announcer();
    let program = ProgramId(1);
    announcer.program_started(program, "pick.script", "sync()");
    let origin = |thread, line| Origin {
        program,
        thread: ThreadNumber(thread),
        line,
    };
    announcer.message(&Message::log(
        Severity::Info,
        origin(0, 3),
        Text::verbatim("picking"),
    ));
    announcer.message(&Message::log(
        Severity::Warning,
        origin(2, 17),
        Text::verbatim("late"),
    ));
    announcer.message(&Message::Robot {
        origin: Origin::default(),
        code: 100,
        sub_code: 3,
        severity: Severity::Error,
        text: Text::verbatim("protective stop: too fast"),
    });
    announcer.message(&Message::ScriptError {
        program,
        line: 4,
        column: 2,
        summary: Text::verbatim("ValueError: no"),
        report: Text::verbatim("line 4\nValueError: no"),
    });
    announcer.program_ended(program);

    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    let shutdown = CancellationToken::new();
    let end = shutdown.clone();
    let port = serve_port(
        listener,
        PortProtocol::Native,
        PortMeter::new("primary"),
        shutdown,
        move |_stream, _, _| {
            let end = end.clone();
            async move {
                tracing::info!("hello");
                end.cancel();
            }
        },
    );
    let client = async {
        let mut stream = TcpStream::connect(address).await.unwrap();
        let mut rest = Vec::new();
        let _ = stream.read_to_end(&mut rest).await;
    };
    tokio::join!(port, client);
}

/// What is logged, line by line, without times and the number of the client's port.
fn logged(format: LogFormat) -> String {
    let lines = Lines::default();
    let out = lines.clone();
    let writer = BoxMakeWriter::new(move || out.clone());
    let filter = EnvFilter::new("debug");
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .unwrap();
    tracing::subscriber::with_default(subscriber(format, filter, false, writer), || {
        runtime.block_on(say_something());
    });
    let text = String::from_utf8(lines.0.lock().clone()).unwrap();
    let mut out = String::new();
    for line in text.lines() {
        let line = match format {
            // "2026-11-21T07:06:44.241445Z  INFO ...": the time ends with the first space.
            LogFormat::Text if line.starts_with("20") => {
                line.split_once(' ').unwrap().1.trim_start().to_owned()
            }
            LogFormat::Text => line.to_owned(),
            LogFormat::Json => {
                let mut object: serde_json::Map<String, serde_json::Value> =
                    serde_json::from_str(line).unwrap();
                assert!(object.remove("timestamp").is_some(), "{line}");
                serde_json::Value::Object(object).to_string()
            }
        };
        let line = match line.split_once("127.0.0.1:") {
            Some((before, after)) => {
                let after = after.trim_start_matches(|c: char| c.is_ascii_digit());
                format!("{before}PEER{after}")
            }
            None => line,
        };
        out += &line;
        out.push('\n');
    }
    out
}

#[test]
fn text_lines_begin_with_program_and_thread_or_with_the_session() {
    insta::assert_snapshot!(logged(LogFormat::Text));
}

#[test]
fn json_lines_have_program_thread_and_session_as_spans() {
    insta::assert_snapshot!(logged(LogFormat::Json));
}
