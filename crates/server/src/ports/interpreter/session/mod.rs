//! One client of the interpreter port, over any duplex stream.
//!
//! Three things go on side by side: reading, handing statements over one after the other, and writing replies. So a
//! command word is answered at once even while a statement before it still waits to be accepted, however many there
//! are: what finds no room is discarded, not left unread. A client that streams statements without reading the replies
//! is not held up: it misses replies.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::sync::mpsc;
use tokio_util::sync::CancellationToken;

use super::codec::{Discard, LINE_BYTES_MAX, StatementFrame, StatementFramer, ack, discard};
use super::{InterpreterBackend, StatementReply};
use crate::ports::ClientId;
use crate::ports::escape::EscapedLine;

/// What is read at once.
const READ_BYTES: usize = 16 * 1024;

/// Statements of one client that wait to be handed over, in bytes; one more is one too many, as in the queue of the
/// task (manual 2.2). Each counts [`STATEMENT_BYTES`] beside its text, so that more fit than the task takes.
const STATEMENT_BYTES_MAX: usize = 10 * 1024 * 1024;
const STATEMENT_BYTES: usize = 64;

/// What a client sends while there is no room for it is read with this pause after so many bytes.
const FLOOD_PAUSE: Duration = Duration::from_millis(1);
const FLOOD_BYTES: usize = 64 * 1024;

/// Replies that wait for a client to read them; more are dropped.
const REPLIES_WAITING_MAX: usize = 16 * 1024;
/// Bytes of replies that wait for a client to read them; more are dropped.
const REPLY_BYTES_MAX: usize = 4 * 1024 * 1024;

/// Replies are written together up to this size.
const BATCH_BYTES: usize = 16 * 1024;

/// A reason why a session ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SessionEnd {
    /// The connection is gone and everything received was handed over.
    Disconnected,
    /// The server ends.
    Shutdown,
}

/// A statement on its way to the interpreter.
#[derive(Clone, Debug)]
pub struct Statement {
    /// Who sent it.
    pub client: ClientId,
    /// The text, without the newline at its end.
    pub text: Arc<str>,
    replies: WeakReplySender,
}

impl Statement {
    /// Tells the sender that a statement accepted before is thrown away after all. Never waits.
    pub fn discard(&self, reason: &Discard) {
        if let Some(replies) = self.replies.upgrade() {
            replies.send(discard(reason, &self.text));
        }
    }
}

/// Serves one client until its connection is gone or the server ends.
pub async fn serve(
    stream: impl AsyncRead + AsyncWrite,
    client: ClientId,
    interpreter: &impl InterpreterBackend,
    shutdown: CancellationToken,
) -> SessionEnd {
    let (reader, writer) = tokio::io::split(stream);
    let (replies, to_write) = ReplySender::new(client);
    let (backlog, to_hand_over) = StatementSender::new();
    // Each ends when the one before it has: reading at the end of the stream, then the rest.
    let reading = read_lines(reader, interpreter, backlog, replies.clone());
    let handing_over = hand_over(to_hand_over, interpreter, replies);
    let writing = write_replies(writer, to_write);
    let all = async { tokio::join!(reading, handing_over, writing) };
    match shutdown.run_until_cancelled(all).await {
        Some((end, (), ())) => end,
        None => SessionEnd::Shutdown,
    }
}

/// Texts of statements on their way from reading to handing over, bounded in bytes.
struct StatementSender {
    texts: mpsc::UnboundedSender<Arc<str>>,
    bytes: Arc<AtomicUsize>,
}

/// Receiver of the statements of one client.
struct StatementReceiver {
    texts: mpsc::UnboundedReceiver<Arc<str>>,
    bytes: Arc<AtomicUsize>,
}

impl StatementSender {
    fn new() -> (Self, StatementReceiver) {
        let (texts, receiver) = mpsc::unbounded_channel();
        let bytes = Arc::default();
        let to_hand_over = StatementReceiver {
            texts: receiver,
            bytes: Arc::clone(&bytes),
        };
        (Self { texts, bytes }, to_hand_over)
    }

    /// Adds a statement; gives it back when there is no room for it.
    fn add(&self, text: String) -> Result<(), String> {
        let bytes = text.len() + STATEMENT_BYTES;
        // Only this side adds. When it is full, a short one finds no room either.
        if self.is_full() || self.bytes.load(Ordering::Relaxed) + bytes > STATEMENT_BYTES_MAX {
            return Err(text);
        }
        self.bytes.fetch_add(bytes, Ordering::Relaxed);
        // Sending cannot fail: the receiver lives as long as the session.
        let _ = self.texts.send(text.into());
        Ok(())
    }

    /// There is no room for a long line.
    fn is_full(&self) -> bool {
        self.bytes.load(Ordering::Relaxed) > STATEMENT_BYTES_MAX - LINE_BYTES_MAX
    }
}

impl StatementReceiver {
    async fn next(&mut self) -> Option<Arc<str>> {
        let text = self.texts.recv().await?;
        self.bytes
            .fetch_sub(text.len() + STATEMENT_BYTES, Ordering::Relaxed);
        Some(text)
    }
}

async fn read_lines(
    mut reader: impl AsyncRead + Unpin,
    interpreter: &impl InterpreterBackend,
    backlog: StatementSender,
    replies: ReplySender,
) -> SessionEnd {
    let mut framer = StatementFramer::default();
    let mut frames = Vec::new();
    let mut buffer = vec![0; READ_BYTES];
    let mut shed = 0;
    loop {
        let count = reader.read(&mut buffer).await.unwrap_or(0); // a broken connection sends no more, either
        if count > 0 {
            framer.push(&buffer[..count], &mut frames);
        } else {
            framer.finish(&mut frames);
        }
        for frame in frames.drain(..) {
            match frame {
                StatementFrame::Statement(text) => {
                    if let Err(text) = backlog.add(text) {
                        replies.send(discard(&Discard::TooMany, &text));
                    }
                }
                StatementFrame::Command(command) => {
                    let number = interpreter.command(command).await;
                    replies.send(command.reply(number));
                }
                StatementFrame::Rejected(rejection) => {
                    let reply = rejection.reply();
                    tracing::warn!(client = %replies.client, "interpreter: {}", EscapedLine(reply.trim_end()));
                    replies.send(reply);
                }
            }
        }
        if count == 0 {
            return SessionEnd::Disconnected;
        }
        // Others on this thread have a turn, however much waits here; whoever sends more than there is room for is
        // slow.
        shed += if backlog.is_full() { count } else { 0 };
        if shed < FLOOD_BYTES {
            tokio::task::yield_now().await;
        } else {
            shed = 0;
            tokio::time::sleep(FLOOD_PAUSE).await;
        }
    }
}

async fn hand_over(
    mut statements: StatementReceiver,
    interpreter: &impl InterpreterBackend,
    replies: ReplySender,
) {
    while let Some(text) = statements.next().await {
        let statement = Statement {
            client: replies.client,
            text: Arc::clone(&text),
            replies: replies.downgrade(),
        };
        replies.send(match interpreter.submit(statement).await {
            StatementReply::Ack(id) => ack(id, &text),
            StatementReply::Discard(reason) => discard(&reason, &text),
        });
    }
}

async fn write_replies(mut writer: impl AsyncWrite + Unpin, mut replies: ReplyReceiver) {
    while let Some(reply) = replies.next_batch().await {
        let written: io::Result<()> = writer.write_all(reply.as_bytes()).await;
        if let Err(error) = written {
            // Reading notices by itself; what was received before is still executed.
            tracing::debug!(%error, "interpreter: the client is gone");
            return;
        }
    }
    // An error here means that the client has gone already.
    let _ = writer.shutdown().await;
}

/// Where replies to one client go in. Never waits: what a client does not read in time, it misses.
#[derive(Clone, Debug)]
struct ReplySender {
    client: ClientId,
    lines: mpsc::Sender<String>,
    bytes: Arc<AtomicUsize>,
}

/// Replies for as long as the session lives, without keeping it alive.
#[derive(Clone, Debug)]
struct WeakReplySender {
    client: ClientId,
    lines: mpsc::WeakSender<String>,
    bytes: Arc<AtomicUsize>,
}

/// Receiver of the replies to one client.
struct ReplyReceiver {
    lines: mpsc::Receiver<String>,
    bytes: Arc<AtomicUsize>,
}

impl ReplySender {
    fn new(client: ClientId) -> (Self, ReplyReceiver) {
        let (lines, receiver) = mpsc::channel(REPLIES_WAITING_MAX);
        let bytes = Arc::default();
        let to_write = ReplyReceiver {
            lines: receiver,
            bytes: Arc::clone(&bytes),
        };
        let replies = Self {
            client,
            lines,
            bytes,
        };
        (replies, to_write)
    }

    fn send(&self, reply: String) {
        let length = reply.len();
        let waiting = self.bytes.fetch_add(length, Ordering::Relaxed);
        if waiting + length > REPLY_BYTES_MAX || self.lines.try_send(reply).is_err() {
            self.bytes.fetch_sub(length, Ordering::Relaxed);
            tracing::debug!(client = %self.client, "interpreter: a reply is dropped, the client does not read");
        }
    }

    fn downgrade(&self) -> WeakReplySender {
        WeakReplySender {
            client: self.client,
            lines: self.lines.downgrade(),
            bytes: Arc::clone(&self.bytes),
        }
    }
}

impl WeakReplySender {
    fn upgrade(&self) -> Option<ReplySender> {
        Some(ReplySender {
            client: self.client,
            lines: self.lines.upgrade()?,
            bytes: Arc::clone(&self.bytes),
        })
    }
}

impl ReplyReceiver {
    /// What waits, in order, up to about [`BATCH_BYTES`]: a client that streams statements gets many replies a write.
    async fn next_batch(&mut self) -> Option<String> {
        let mut batch = self.lines.recv().await?;
        while batch.len() < BATCH_BYTES
            && let Ok(reply) = self.lines.try_recv()
        {
            batch.push_str(&reply);
        }
        self.bytes.fetch_sub(batch.len(), Ordering::Relaxed);
        Some(batch)
    }
}

#[cfg(test)]
mod tests;
