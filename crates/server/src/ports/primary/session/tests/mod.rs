//! Sessions over an in-memory stream, with time under the test's control; then the port over real sockets.

mod states;

use std::sync::Arc;

use parking_lot::Mutex;
use proptest::prelude::*;
use tokio::io::{DuplexStream, duplex};
use tokio::sync::{Semaphore, watch};
use tokio::task::JoinHandle;
use tokio::time::advance;

use super::*;
use crate::ports::description::{RobotDescription, ToolSerial};
use crate::ports::listen::{PortMeter, bind};
use crate::ports::primary::framing::{ControlPhrase, ProgramKind, ReceivedProgram};
use crate::ports::primary::state_message::STATE_MESSAGE_BYTES;
use crate::ports::rtsi::outputs::tests::sample;
use crate::ports::sample::Sample;
use wire::primary::ROBOT_EXCEPTION;

/// A controller that only writes down what it was asked.
struct Fake {
    description: RobotDescription,
    beats: watch::Sender<Option<Arc<Sample>>>,
    asked: Mutex<Vec<Asked>>,
    local: watch::Sender<bool>,
    /// Programs wait for this many permits; without a limit they are taken over at once.
    room: Semaphore,
}

#[derive(Clone, Debug, PartialEq)]
enum Asked {
    Program(Submission),
    Control(ControlPhrase),
    Hurry(ControlPhrase),
}

impl Fake {
    fn new() -> Arc<Self> {
        Arc::new(Self {
            description: RobotDescription::cs66(),
            beats: watch::Sender::new(None),
            asked: Mutex::default(),
            local: watch::Sender::new(false),
            room: Semaphore::new(Semaphore::MAX_PERMITS),
        })
    }

    fn asked(&self) -> Vec<Asked> {
        self.asked.lock().clone()
    }

    /// Texts of the programs received.
    fn programs(&self) -> Vec<String> {
        self.asked()
            .into_iter()
            .filter_map(|asked| match asked {
                Asked::Program(submission) => Some(submission.program.text),
                Asked::Control(_) | Asked::Hurry(_) => None,
            })
            .collect()
    }
}

impl PrimaryBackend for Fake {
    fn beats(&self) -> watch::Receiver<Option<Arc<Sample>>> {
        self.beats.subscribe()
    }
    fn sample(&self) -> Sample {
        sample()
    }
    fn description(&self) -> &RobotDescription {
        &self.description
    }
    fn tool_serial(&self) -> Option<ToolSerial> {
        None
    }
    async fn closed_to_clients(&self) {
        let mut local = self.local.subscribe();
        // The sender lives as long as this.
        let _ = local.wait_for(|local| *local).await;
    }
    fn unix_millis(&self) -> u64 {
        1_700_000_000_000
    }
    /// Brackets decide.
    async fn is_whole_program(&self, text: String) -> bool {
        text.matches('(').count() == text.matches(')').count()
    }
    async fn submit(&self, submission: Submission) {
        self.room.acquire().await.unwrap().forget();
        self.asked.lock().push(Asked::Program(submission));
    }
    async fn control(&self, _: ClientId, phrase: ControlPhrase) {
        self.asked.lock().push(Asked::Control(phrase));
    }
    fn preempt(&self, phrase: ControlPhrase) {
        self.asked.lock().push(Asked::Hurry(phrase));
    }
}

/// One session with its client.
struct Rig {
    backend: Arc<Fake>,
    hub: StateHub,
    shutdown: CancellationToken,
    session: JoinHandle<SessionEnd>,
    client: DuplexStream,
}

/// `room` is how many bytes the stream holds unread in each direction.
fn rig(room: usize) -> Rig {
    let (client, server) = duplex(room);
    let (backend, hub, shutdown) = (Fake::new(), StateHub::default(), CancellationToken::new());
    let session = tokio::spawn({
        let (backend, hub, shutdown) = (Arc::clone(&backend), hub.clone(), shutdown.clone());
        async move { serve(server, ClientId(1), &*backend, &hub, shutdown).await }
    });
    Rig {
        backend,
        hub,
        shutdown,
        session,
        client,
    }
}

impl Rig {
    fn publish(&self) {
        self.hub.publish_state(&sample(), &self.backend.description);
    }

    fn announce(&self, text: &str) {
        let exception = Exception::Script {
            line: 1,
            column: 1,
            text: text.to_owned(),
        };
        self.hub
            .announce(0, ExceptionSource::Controller, &exception);
    }

    async fn send(&mut self, text: &str) {
        self.client.write_all(text.as_bytes()).await.unwrap();
        settle().await;
    }
}

/// Lets every task run until it waits.
async fn settle() {
    for _ in 0..20 {
        tokio::task::yield_now().await;
    }
}

/// The next message: its type and its body.
async fn message(client: &mut (impl AsyncRead + Unpin)) -> (u8, Vec<u8>) {
    let mut head = [0; 5];
    client.read_exact(&mut head).await.unwrap();
    let length = u32::from_be_bytes(head[..4].try_into().unwrap()) as usize;
    let mut body = vec![0; length - 5];
    client.read_exact(&mut body).await.unwrap();
    (head[4], body)
}

/// The text of the next message, which must be a script error.
async fn exception_text(client: &mut (impl AsyncRead + Unpin)) -> String {
    let (kind, body) = message(client).await;
    assert_eq!(kind, ROBOT_EXCEPTION);
    String::from_utf8(body[18..body.len() - 1].to_vec()).unwrap()
}

#[tokio::test(start_paused = true)]
async fn programs_and_orders_are_handed_over_in_the_order_in_which_they_came() {
    let mut rig = rig(4096);
    rig.send("stop task\ndef t():\n  a()\nend\npopup(1)\nset speed 0.5")
        .await;
    rig.send("0\n").await;
    let program = |kind, text: &str| {
        let program = ReceivedProgram {
            text: text.to_owned(),
            kind,
            ended_by: ProgramEnd::ItsText,
        };
        Asked::Program(Submission {
            sender: ClientId(1).into(),
            program,
        })
    };
    assert_eq!(
        rig.backend.asked(),
        [
            Asked::Control(ControlPhrase::StopTask),
            program(ProgramKind::Main, "def t():\n  a()\nend\n"),
            program(ProgramKind::Line, "popup(1)\n"),
            Asked::Control(ControlPhrase::SetSpeed(0.5)),
        ]
    );
}

#[tokio::test(start_paused = true)]
async fn a_stop_behind_a_program_that_waits_hurries_and_programs_between_do_not_begin() {
    let mut rig = rig(4096);
    rig.backend.room.forget_permits(Semaphore::MAX_PERMITS);
    rig.send("a()\nb()\nset speed 0.5\n").await;
    assert_eq!(rig.backend.asked(), []);
    rig.send("stop task\nc()\n").await;
    let hurried = Asked::Hurry(ControlPhrase::StopTask);
    assert_eq!(rig.backend.asked(), [hurried]);
    rig.backend.room.add_permits(3);
    settle().await;
    assert_eq!(rig.backend.programs(), ["a()\n", "c()\n"]);
    let asked = rig.backend.asked();
    assert_eq!(asked[2], Asked::Control(ControlPhrase::SetSpeed(0.5)));
    assert_eq!(asked[3], Asked::Control(ControlPhrase::StopTask));
    let text = exception_text(&mut rig.client).await;
    assert!(text.contains("a stop came behind it"), "{text}");
}

#[tokio::test(start_paused = true)]
async fn a_program_and_its_stop_in_one_packet_both_have_their_turn() {
    let mut rig = rig(4096);
    rig.send("a()\nb()\nstop task\nstop task\n").await;
    assert_eq!(rig.backend.programs(), ["a()\n"]);
    let stop = ControlPhrase::StopTask;
    let asked = rig.backend.asked();
    assert_eq!(asked[..2], [Asked::Hurry(stop), Asked::Hurry(stop)]);
    assert_eq!(asked[3..], [Asked::Control(stop), Asked::Control(stop)]);
}

#[tokio::test(start_paused = true)]
async fn a_pause_behind_a_program_that_waits_holds_what_runs() {
    let mut rig = rig(4096);
    rig.backend.room.forget_permits(Semaphore::MAX_PERMITS);
    rig.send("a()\npause task\n").await;
    let hurried = Asked::Hurry(ControlPhrase::PauseTask);
    assert_eq!(rig.backend.asked(), [hurried]);
    rig.backend.room.add_permits(1);
    settle().await;
    let asked = rig.backend.asked();
    assert_eq!(asked[2], Asked::Control(ControlPhrase::PauseTask));
}

#[tokio::test(start_paused = true)]
async fn a_stop_is_heard_behind_any_flood_to_a_busy_controller_and_what_has_no_room_is_refused() {
    let kinds = [
        format!("a(\"{}\")\n", "x".repeat(60_000)),
        "b()\n".repeat(10_000),
        "set speed 0.5\n".repeat(5_000),
        format!("def c():\n{}end\n", "  x = 1\n".repeat(500_000)),
        "set speed 0.5\nstop task\n".repeat(3_000),
    ];
    for flood in kinds {
        let mut rig = rig(1 << 16);
        rig.backend.room.forget_permits(Semaphore::MAX_PERMITS);
        rig.send("first()\n").await;
        for _ in 0..(16 << 20) / flood.len() {
            rig.client.write_all(flood.as_bytes()).await.unwrap();
        }
        rig.backend.asked.lock().clear();
        rig.send("stop task\n").await;
        for _ in 0..1000 {
            if rig.backend.asked().is_empty() {
                tokio::time::sleep(Duration::from_millis(1)).await;
            }
        }
        let hurried = Asked::Hurry(ControlPhrase::StopTask);
        let asked = rig.backend.asked();
        let is_heard = !asked.is_empty() && asked.iter().all(|asked| *asked == hurried);
        assert!(is_heard, "{}", &flood[..4]);
        rig.backend.room.add_permits(1 << 20);
        rig.send("last()\n").await;
        tokio::time::sleep(Duration::from_secs(1)).await;
        let programs = rig.backend.programs();
        assert_eq!(programs, ["first()\n", "last()\n"], "{}", &flood[..4]);
        let mut said = Vec::new();
        while let Ok(text) = timeout(Duration::from_secs(1), exception_text(&mut rig.client)).await
        {
            said.push(text);
        }
        let is_said = said.iter().any(|text| text.contains("refused"));
        assert!(is_said && said.len() < 10, "{said:?}");
    }
}

#[tokio::test(start_paused = true)]
async fn two_seconds_of_silence_complete_a_block_that_is_whole() {
    let mut rig = rig(4096);
    rig.send("def t():\n  a()\n").await;
    advance(Duration::from_millis(1900)).await;
    rig.send("  b()\n").await; // the silence counts from the last byte
    advance(Duration::from_millis(1900)).await;
    settle().await;
    assert!(rig.backend.programs().is_empty());
    advance(Duration::from_millis(200)).await;
    settle().await;
    assert_eq!(rig.backend.programs(), ["def t():\n  a()\n  b()\n"]);
    rig.send("c()\n").await;
    assert_eq!(rig.backend.programs().len(), 2);
}

#[tokio::test(start_paused = true)]
async fn silence_does_not_complete_a_block_that_is_not_whole() {
    let mut rig = rig(4096);
    rig.send("def t():\n  a(\n").await;
    sleep(Duration::from_secs(60)).await;
    assert!(rig.backend.programs().is_empty());
    rig.send("  1)\nend\n").await;
    assert_eq!(rig.backend.programs(), ["def t():\n  a(\n  1)\nend\n"]);
}

#[tokio::test(start_paused = true)]
async fn a_client_that_goes_away_completes_its_block_whether_whole_or_not() {
    let mut rig = rig(4096);
    rig.send("def t():\n  a(").await;
    drop(rig.client);
    settle().await;
    let asked = rig.backend.asked();
    let [Asked::Program(submission)] = asked.as_slice() else {
        panic!("{asked:?}")
    };
    assert_eq!(submission.program.ended_by, ProgramEnd::PeerClosed);
}

#[tokio::test(start_paused = true)]
async fn a_client_that_closed_its_half_still_gets_the_stream() {
    let mut rig = rig(4096);
    rig.send("a()\n").await;
    rig.client.shutdown().await.unwrap();
    settle().await;
    rig.publish();
    assert_eq!(message(&mut rig.client).await.0, 16);
    rig.announce("later");
    assert_eq!(exception_text(&mut rig.client).await, "later");
    drop(rig.client);
    rig.hub.announce(
        0,
        ExceptionSource::Gui,
        &Exception::Script {
            line: 1,
            column: 1,
            text: String::new(),
        },
    );
    assert_eq!(rig.session.await.unwrap(), SessionEnd::Disconnected);
}

#[tokio::test(start_paused = true)]
async fn a_client_that_does_not_read_misses_states_and_can_still_send() {
    let mut rig = rig(2 * STATE_MESSAGE_BYTES);
    for _ in 0..50 {
        rig.publish();
        settle().await;
    }
    rig.send("a()\n").await;
    assert_eq!(rig.backend.programs(), ["a()\n"]);
    // What it then reads are whole messages: two in the stream, one that was being written, and the latest.
    for _ in 0..4 {
        assert_eq!(message(&mut rig.client).await.0, 16);
    }
    let more = timeout(Duration::from_secs(1), message(&mut rig.client)).await;
    assert!(more.is_err());
}

#[tokio::test(start_paused = true)]
async fn exceptions_come_in_a_burst_and_then_at_a_pace_the_sdk_can_follow() {
    let mut rig = rig(1024 * 1024);
    settle().await;
    for number in 0..100 {
        rig.announce(&number.to_string());
    }
    let start = Instant::now();
    let mut within_a_moment = 0;
    for number in 0..100 {
        assert_eq!(exception_text(&mut rig.client).await, number.to_string());
        within_a_moment += usize::from(start.elapsed() < Duration::from_millis(20));
    }
    assert_eq!(within_a_moment, 20);
    let all = start.elapsed();
    assert!(
        (Duration::from_millis(1990)..Duration::from_millis(2100)).contains(&all),
        "{all:?}"
    );
}

#[tokio::test(start_paused = true)]
async fn states_go_on_while_exceptions_wait() {
    let mut rig = rig(1024 * 1024);
    settle().await;
    for _ in 0..40 {
        rig.announce("x");
    }
    settle().await;
    rig.publish();
    for _ in 0..20 {
        exception_text(&mut rig.client).await;
    }
    assert_eq!(message(&mut rig.client).await.0, 16);
}

#[tokio::test(start_paused = true)]
async fn a_client_that_is_far_behind_loses_the_oldest_exceptions() {
    let mut rig = rig(1024 * 1024);
    settle().await;
    for number in 0..1000 {
        rig.announce(&number.to_string());
    }
    assert_eq!(exception_text(&mut rig.client).await, "744");
}

#[tokio::test(start_paused = true)]
async fn what_cannot_be_run_is_reported_to_every_client_with_its_place() {
    let mut rig = rig(4096);
    let mut other = rig.hub.subscribe(&*rig.backend);
    rig.client
        .write_all(b"a()\ndef t():\n  b('\xff')\nend\nc()\n")
        .await
        .unwrap();
    let (kind, body) = message(&mut rig.client).await;
    assert_eq!(kind, ROBOT_EXCEPTION);
    assert_eq!(body[..8], 1_700_000_000_000_u64.to_be_bytes());
    assert_eq!(body[8..18], [104, 10, 0, 0, 0, 2, 0, 0, 0, 6]);
    assert_eq!(&body[18..], b"the program is not UTF-8 text\0");
    assert!(other.exceptions.try_recv().is_ok());
    assert_eq!(rig.backend.programs(), ["a()\n", "c()\n"]);
    rig.shutdown.cancel();
    assert_eq!(rig.session.await.unwrap(), SessionEnd::Shutdown);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]
    #[test]
    fn any_bytes_leave_the_session_alive(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_time().start_paused(true).build().unwrap();
        runtime.block_on(async {
            let mut rig = rig(64 * 1024);
            // Not a browser, and whatever was opened is closed.
            rig.client.write_all(b"x\n").await.unwrap();
            rig.client.write_all(&bytes).await.unwrap();
            rig.client.write_all(b"\n'''\nend\n\"\"\"\nend\nend\n").await.unwrap();
            rig.send("last_words()\n").await;
            sleep(Duration::from_secs(3)).await;
            rig.publish();
            loop {
                if message(&mut rig.client).await.0 == 16 { break; }
            }
            assert!(!rig.session.is_finished());
            let programs = rig.backend.programs();
            assert_eq!(programs[0], "x\n");
            assert!(programs.iter().all(|text| text.len() <= bytes.len() + 64));
        });
    }
}

/// A port over real sockets with a fake controller.
async fn port() -> (
    std::net::SocketAddr,
    Arc<Fake>,
    StateHub,
    CancellationToken,
    JoinHandle<()>,
) {
    let listener = bind(
        "--primary-port",
        "127.0.0.1".parse().unwrap(),
        crate::options::PortSetting::Any,
    )
    .await
    .unwrap()
    .unwrap();
    let address = listener.local_addr().unwrap();
    let (backend, hub, shutdown) = (Fake::new(), StateHub::default(), CancellationToken::new());
    tokio::spawn({
        let (backend, hub, shutdown) = (Arc::clone(&backend), hub.clone(), shutdown.clone());
        async move { hub.publish_states(&*backend, shutdown).await }
    });
    let port = tokio::spawn(crate::ports::primary::serve(
        listener,
        Arc::clone(&backend),
        hub.clone(),
        PortMeter::new("primary"),
        shutdown.clone(),
    ));
    (address, backend, hub, shutdown, port)
}

#[tokio::test]
async fn clients_that_open_send_and_close_within_milliseconds_are_heard() {
    let (address, backend, _hub, shutdown, port) = port().await;
    for number in 0..20 {
        let mut client = tokio::net::TcpStream::connect(address).await.unwrap();
        if number % 2 == 0 {
            // With states unread in its buffer, closing sends a reset instead of a goodbye.
            let mut byte = [0];
            client.read_exact(&mut byte).await.unwrap();
        }
        let script = format!("def t{number}():\n  a()\nend\n");
        client.write_all(script.as_bytes()).await.unwrap();
        drop(client);
    }
    let deadline = Instant::now() + Duration::from_secs(5);
    while backend.programs().len() < 20 && Instant::now() < deadline {
        sleep(Duration::from_millis(5)).await;
    }
    assert_eq!(backend.programs().len(), 20);
    shutdown.cancel();
    port.await.unwrap();
}

#[tokio::test]
async fn every_client_gets_the_stream_and_the_exceptions() {
    let (address, _backend, hub, shutdown, port) = port().await;
    let mut clients = Vec::new();
    for _ in 0..5 {
        let mut client = tokio::net::TcpStream::connect(address).await.unwrap();
        assert_eq!(message(&mut client).await.0, 16);
        clients.push(client);
    }
    drop(clients.remove(2)); // a dead client holds up nobody
    hub.announce(
        5,
        ExceptionSource::Safety,
        &Exception::Script {
            line: 1,
            column: 1,
            text: "stop".into(),
        },
    );
    for client in &mut clients {
        loop {
            let (kind, body) = message(client).await;
            if kind == ROBOT_EXCEPTION {
                assert_eq!(&body[18..], b"stop\0");
                break;
            }
        }
    }
    shutdown.cancel();
    port.await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn in_local_mode_a_client_hears_why_and_is_closed() {
    let mut rig = rig(4096);
    rig.backend.local.send_replace(true);
    let text = exception_text(&mut rig.client).await;
    assert!(text.contains("in local control mode"), "{text}");
    assert_eq!(rig.client.read(&mut [0]).await.unwrap(), 0);
    rig.client.write_all(b"a()\n").await.unwrap();
    drop(rig.client);
    assert_eq!(rig.session.await.unwrap(), SessionEnd::LocalMode);
    assert!(rig.backend.asked().is_empty());
}

#[tokio::test(start_paused = true)]
async fn what_is_for_one_client_is_sent_to_no_other() {
    let mut rig = rig(4096);
    tokio::task::yield_now().await;
    let exception = |text: &str| Exception::Script {
        line: 1,
        column: 1,
        text: text.to_owned(),
    };
    rig.hub.announce_to(
        ClientId(99),
        0,
        ExceptionSource::Controller,
        &exception("not yours"),
    );
    rig.hub.announce_to(
        ClientId(1),
        0,
        ExceptionSource::Controller,
        &exception("yours"),
    );
    rig.hub
        .announce(0, ExceptionSource::Controller, &exception("all"));
    assert_eq!(exception_text(&mut rig.client).await, "yours");
    assert_eq!(exception_text(&mut rig.client).await, "all");
}
