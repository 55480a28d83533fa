//! Sessions over an in-memory stream with an interpreter that keeps a list.

use std::time::Duration;

use parking_lot::Mutex;
use proptest::prelude::*;
use tokio::io::{AsyncBufReadExt, BufReader, DuplexStream, duplex};
use tokio::sync::Notify;
use tokio::task::JoinHandle;
use tokio::time::timeout;

use super::super::codec::InterpreterCommand;
use super::*;

/// Acknowledges everything but what contains `bad`; `hold` waits for a release.
#[derive(Default)]
struct Fake {
    queue: Mutex<Vec<Statement>>,
    release: Notify,
    aborted: std::sync::atomic::AtomicBool,
}

impl InterpreterBackend for Fake {
    async fn submit(&self, statement: Statement) -> StatementReply {
        if statement.text.contains("bad") {
            return StatementReply::Discard(Discard::Compile("no".to_owned()));
        }
        if &*statement.text == "hold" {
            self.release.notified().await;
        }
        let mut queue = self.queue.lock();
        queue.push(statement);
        StatementReply::Ack(queue.len() as u64)
    }
    async fn command(&self, command: InterpreterCommand) -> u64 {
        let mut queue = self.queue.lock();
        if command == InterpreterCommand::SkipBuffer {
            queue.clear();
        }
        if command == InterpreterCommand::Abort {
            self.aborted.store(true, Ordering::SeqCst);
        }
        queue.len() as u64
    }
}

struct Rig {
    interpreter: Arc<Fake>,
    shutdown: CancellationToken,
    session: JoinHandle<SessionEnd>,
    client: BufReader<DuplexStream>,
}

fn rig(room: usize) -> Rig {
    let (client, server) = duplex(room);
    let (interpreter, shutdown) = (Arc::new(Fake::default()), CancellationToken::new());
    let session = tokio::spawn({
        let (interpreter, shutdown) = (Arc::clone(&interpreter), shutdown.clone());
        async move { serve(server, ClientId(1), &*interpreter, shutdown).await }
    });
    Rig {
        interpreter,
        shutdown,
        session,
        client: BufReader::new(client),
    }
}

impl Rig {
    async fn send(&mut self, text: &str) {
        self.client.write_all(text.as_bytes()).await.unwrap();
    }

    async fn reply(&mut self) -> String {
        let mut line = String::new();
        self.client.read_line(&mut line).await.unwrap();
        line
    }
}

#[tokio::test]
async fn every_statement_gets_one_reply_in_order() {
    let mut rig = rig(4096);
    rig.send("a()\nbad(\ndef f():\n b()\nend\nstatelastinterpreted\n")
        .await;
    let mut replies = Vec::new();
    for _ in 0..4 {
        replies.push(rig.reply().await);
    }
    // A command does not queue behind statements: its reply may come before theirs.
    replies.sort();
    assert_eq!(replies[0], "ack: 1: a()\n");
    assert_eq!(replies[1], "ack: 2: def f():  b() end\n");
    assert_eq!(replies[2], "discard: Compile error:no : bad(\n");
    assert!(replies[3].ends_with(": statelastinterpreted\n"));
    rig.shutdown.cancel();
    assert_eq!(rig.session.await.unwrap(), SessionEnd::Shutdown);
}

#[tokio::test]
async fn a_command_is_answered_while_a_statement_waits_for_its_acknowledgement() {
    let mut rig = rig(4096);
    rig.send("a()\nhold\nb()\n").await;
    assert_eq!(rig.reply().await, "ack: 1: a()\n");
    rig.send("stateunexecuted\nskipbuffer\nstateunexecuted\n")
        .await;
    assert_eq!(rig.reply().await, "state: 1: stateunexecuted\n");
    assert_eq!(rig.reply().await, "state: 0: skipbuffer\n");
    assert_eq!(rig.reply().await, "state: 0: stateunexecuted\n");
    rig.interpreter.release.notify_one();
    assert_eq!(rig.reply().await, "ack: 1: hold\n");
    assert_eq!(rig.reply().await, "ack: 2: b()\n");
}

#[tokio::test]
async fn a_statement_thrown_away_later_is_reported_to_its_sender() {
    let mut rig = rig(4096);
    rig.send("a()\n").await;
    assert_eq!(rig.reply().await, "ack: 1: a()\n");
    let statement = rig.interpreter.queue.lock().pop().unwrap();
    statement.discard(&Discard::CleanedUp);
    assert_eq!(
        rig.reply().await,
        "discard: Cleaned up before interpretation: a()\n"
    );
    drop(rig.client);
    assert_eq!(rig.session.await.unwrap(), SessionEnd::Disconnected);
    statement.discard(&Discard::CleanedUp); // nobody hears it, nobody minds
}

#[tokio::test]
async fn what_was_received_before_the_end_is_handed_over_and_answered() {
    let mut rig = rig(4096);
    rig.send("a()\nb()").await;
    rig.client.shutdown().await.unwrap();
    assert_eq!(rig.reply().await, "ack: 1: a()\n");
    assert_eq!(rig.reply().await, "ack: 2: b()\n");
    assert_eq!(rig.reply().await, "", "then the connection is closed");
    assert_eq!(rig.session.await.unwrap(), SessionEnd::Disconnected);
}

#[tokio::test]
async fn a_client_that_streams_without_reading_is_not_held_up() {
    let mut rig = rig(4096);
    let servo =
        "def a():\n servoj([0, 0, 0, 0, 0, 0], t=0.008, lookahead_time=0.1, gain=300)\nend\n";
    let sending = async {
        for _ in 0..20_000 {
            rig.client
                .get_mut()
                .write_all(servo.as_bytes())
                .await
                .unwrap();
        }
    };
    timeout(Duration::from_secs(20), sending)
        .await
        .expect("the stream stalls");
    drop(rig.client);
    assert_eq!(rig.session.await.unwrap(), SessionEnd::Disconnected);
    assert_eq!(rig.interpreter.queue.lock().len(), 20_000);
}

#[tokio::test]
async fn an_abort_is_carried_out_behind_any_number_of_statements_and_what_has_no_room_is_discarded()
{
    let mut rig = rig(64 * 1024);
    rig.send("hold\n").await;
    let statement = format!("x = \"{}\"\n", "y".repeat(200));
    let many = (20 << 20) / statement.len();
    let sending = async {
        for _ in 0..many {
            rig.client
                .get_mut()
                .write_all(statement.as_bytes())
                .await
                .unwrap();
        }
        let abort = b"abort\n";
        rig.client.get_mut().write_all(abort).await.unwrap();
    };
    timeout(Duration::from_secs(60), sending).await.unwrap();
    // Nobody has read a reply so far: those that wait come first.
    let (mut discarded, mut aborted) = (0, false);
    while let Ok(reply) = timeout(Duration::from_millis(500), rig.reply()).await {
        discarded += usize::from(reply.starts_with("discard: Too many interpreted messages: x"));
        aborted |= reply == "state: 0: abort\n";
    }
    assert!(discarded > 1000, "{discarded}");
    assert!(rig.interpreter.aborted.load(Ordering::SeqCst), "{aborted}");
    rig.interpreter.release.notify_one();
    while !rig.reply().await.starts_with("ack: 1: hold") {}
    let waited = rig.interpreter.queue.lock().len();
    assert!(waited >= 1);
}

#[tokio::test]
async fn a_long_line_is_answered_and_the_connection_lives_on() {
    let mut rig = rig(256 * 1024);
    rig.send(&format!("{}\na()\n", "x".repeat(100_000))).await;
    assert!(
        rig.reply()
            .await
            .starts_with("discard: Compile error:the line is longer than 64 KiB : xxx")
    );
    assert_eq!(rig.reply().await, "ack: 1: a()\n");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]
    #[test]
    fn any_bytes_leave_the_session_alive(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
        runtime.block_on(async {
            let mut rig = rig(64 * 1024);
            rig.client.write_all(b"x\n").await.unwrap();
            rig.client.write_all(&bytes).await.unwrap();
            // Whatever block or string the bytes opened, these lines close it.
            rig.send("\nend\n'''\nend\n\"\"\"\nend\nlast()\n").await;
            loop {
                let mut line = Vec::new();
                rig.client.read_until(b'\n', &mut line).await.unwrap();
                if line.ends_with(b": last()\n") { break; }
                assert!(!line.is_empty());
            }
        });
    }
}
