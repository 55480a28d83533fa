//! One client of the interpreter port, over any duplex stream.
//!
//! Three things go on side by side: reading, handing statements over one after the other, and writing replies. So a
//! command word is answered at once even while a statement before it still waits to be accepted, and a client that
//! streams statements without reading the replies is not held up: it misses replies.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::sync::{OwnedSemaphorePermit, Semaphore, mpsc};
use tokio_util::sync::CancellationToken;

use super::codec::{Discard, Frame, Framer, ack, discard};
use super::{Interpreter, Verdict};
use crate::ports::ClientId;
use crate::ports::shown::Shown;

/// What is read at once.
const READ_BYTES: usize = 16 * 1024;

/// Statements of one client that wait to be handed over; then reading waits, and a command word behind them is not seen.
/// So there are many: more than the queue of the task takes (manual 2.2).
const STATEMENTS_WAITING_MAX: usize = 16 * 1024;
/// The same in bytes; each counts [`STATEMENT_BYTES`] beside its text.
const STATEMENT_BYTES_MAX: usize = 6 * 1024 * 1024;
const STATEMENT_BYTES: usize = 128;

/// Replies that wait for a client to read them; more are dropped.
const REPLIES_WAITING_MAX: usize = 16 * 1024;
/// The same in bytes.
const REPLY_BYTES_MAX: usize = 4 * 1024 * 1024;

/// Replies are written together up to this size.
const BATCH_BYTES: usize = 16 * 1024;

/// Why a session ended.
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
    replies: WeakReplies,
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
    interpreter: &impl Interpreter,
    shutdown: CancellationToken,
) -> SessionEnd {
    let (reader, writer) = tokio::io::split(stream);
    let (replies, to_write) = Replies::new(client);
    let (statements, to_hand_over) = mpsc::channel(STATEMENTS_WAITING_MAX);
    // Each ends when the one before it has: reading at the end of the stream, then the rest.
    let reading = read_lines(reader, interpreter, statements, replies.clone());
    let handing_over = hand_over(to_hand_over, interpreter, replies);
    let writing = write_replies(writer, to_write);
    let all = async { tokio::join!(reading, handing_over, writing) };
    match shutdown.run_until_cancelled(all).await {
        Some((end, (), ())) => end,
        None => SessionEnd::Shutdown,
    }
}

/// A statement and its share of [`STATEMENT_BYTES_MAX`].
type Waiting = (Statement, OwnedSemaphorePermit);

async fn read_lines(
    mut reader: impl AsyncRead + Unpin,
    interpreter: &impl Interpreter,
    statements: mpsc::Sender<Waiting>,
    replies: Replies,
) -> SessionEnd {
    let room = Arc::new(Semaphore::new(STATEMENT_BYTES_MAX));
    let mut framer = Framer::default();
    let mut frames = Vec::new();
    let mut buffer = vec![0; READ_BYTES];
    loop {
        let count = reader.read(&mut buffer).await.unwrap_or(0); // a broken connection sends no more, either
        if count > 0 {
            framer.push(&buffer[..count], &mut frames);
        } else {
            framer.finish(&mut frames);
        }
        for frame in frames.drain(..) {
            match frame {
                Frame::Statement(text) => {
                    let bytes = u32::try_from(text.len() + STATEMENT_BYTES).unwrap_or(u32::MAX);
                    let statement = Statement {
                        client: replies.client,
                        text: text.into(),
                        replies: replies.downgrade(),
                    };
                    // Neither can fail: the semaphore is never closed, a statement is shorter than it is wide, and the
                    // receiver lives as long as this function.
                    let Ok(share) = Arc::clone(&room).acquire_many_owned(bytes).await else {
                        return SessionEnd::Disconnected;
                    };
                    if statements.send((statement, share)).await.is_err() {
                        return SessionEnd::Disconnected;
                    }
                }
                Frame::Command(command) => {
                    let number = interpreter.command(command).await;
                    replies.send(command.reply(number));
                }
                Frame::Rejected(rejection) => {
                    let reply = rejection.reply();
                    tracing::warn!(client = %replies.client, "interpreter: {}", Shown(reply.trim_end()));
                    replies.send(reply);
                }
            }
        }
        if count == 0 {
            return SessionEnd::Disconnected;
        }
    }
}

async fn hand_over(
    mut statements: mpsc::Receiver<Waiting>,
    interpreter: &impl Interpreter,
    replies: Replies,
) {
    while let Some((statement, _share)) = statements.recv().await {
        let text = Arc::clone(&statement.text);
        replies.send(match interpreter.submit(statement).await {
            Verdict::Ack(id) => ack(id, &text),
            Verdict::Discard(reason) => discard(&reason, &text),
        });
    }
}

async fn write_replies(mut writer: impl AsyncWrite + Unpin, mut replies: ToWrite) {
    while let Some(reply) = replies.next_batch().await {
        let written: io::Result<()> = writer.write_all(reply.as_bytes()).await;
        if let Err(error) = written {
            // Reading notices by itself; what was received before is still executed.
            tracing::debug!(%error, "interpreter: the client is gone");
            return;
        }
    }
    // The other side may be gone already.
    let _ = writer.shutdown().await;
}

/// Where replies to one client go in. Never waits: what a client does not read in time, it misses.
#[derive(Clone, Debug)]
struct Replies {
    client: ClientId,
    lines: mpsc::Sender<String>,
    bytes: Arc<AtomicUsize>,
}

/// Replies for as long as the session lives, without keeping it alive.
#[derive(Clone, Debug)]
struct WeakReplies {
    client: ClientId,
    lines: mpsc::WeakSender<String>,
    bytes: Arc<AtomicUsize>,
}

/// Where they come out.
struct ToWrite {
    lines: mpsc::Receiver<String>,
    bytes: Arc<AtomicUsize>,
}

impl Replies {
    fn new(client: ClientId) -> (Self, ToWrite) {
        let (lines, receiver) = mpsc::channel(REPLIES_WAITING_MAX);
        let bytes = Arc::default();
        let to_write = ToWrite {
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

    fn downgrade(&self) -> WeakReplies {
        WeakReplies {
            client: self.client,
            lines: self.lines.downgrade(),
            bytes: Arc::clone(&self.bytes),
        }
    }
}

impl WeakReplies {
    fn upgrade(&self) -> Option<Replies> {
        Some(Replies {
            client: self.client,
            lines: self.lines.upgrade()?,
            bytes: Arc::clone(&self.bytes),
        })
    }
}

impl ToWrite {
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
