//! One client of the primary port, over any duplex stream.
//!
//! Reading and writing go on side by side: a client that does not read can still send scripts, and one that has sent
//! its script and closed its half still gets the stream. A connection that breaks never stops a script it sent, and
//! what arrived before the break is run.

use std::io;
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::sync::broadcast::error::RecvError;
use tokio::time::{Instant, sleep_until, timeout, timeout_at};
use tokio_util::sync::CancellationToken;

use super::codec::{Exception, Source};
use super::framing::{EndedBy, Frame, Framer, Rejection};
use super::hub::{Hub, Message, Subscription};
use super::{Backend, Submission};
use crate::ports::ClientId;

/// After this much silence an open block that is a whole program as it stands is run.
const SILENCE: Duration = Duration::from_secs(2);

/// What is read at once.
const READ_BYTES: usize = 16 * 1024;

/// When the peer is gone, what it sent before is still read for so long.
const LAST_WORDS: Duration = Duration::from_secs(1);

/// Exceptions to one client: a burst of so many, then one each interval. The SDK takes at most one message in 10 ms
/// and must not fall behind; states take ten a second of that.
const EXCEPTION_BURST: u32 = 20;
const EXCEPTION_INTERVAL: Duration = Duration::from_millis(25);

/// Why a session ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SessionEnd {
    /// The connection is gone.
    Disconnected,
    /// The client speaks HTTP.
    Http,
    /// The server ends.
    Shutdown,
}

/// Serves one client until its connection is gone, it turns out to be a browser, or the server ends.
pub async fn serve(
    stream: impl AsyncRead + AsyncWrite,
    client: ClientId,
    backend: &impl Backend,
    hub: &Hub,
    shutdown: CancellationToken,
) -> SessionEnd {
    let (reader, writer) = tokio::io::split(stream);
    let reading = read_scripts(reader, client, backend, hub);
    let writing = write_messages(writer, client, hub.subscribe());
    tokio::pin!(reading, writing);
    let mut more_to_read = true;
    loop {
        tokio::select! {
            end = &mut reading, if more_to_read => match end {
                ReadEnd::Http => return SessionEnd::Http,
                ReadEnd::PeerClosed => more_to_read = false,
            },
            error = &mut writing => {
                tracing::debug!(%client, %error, "primary: the client is gone");
                if more_to_read {
                    // Elapsed: the peer is half dead; there is nobody left to serve either way.
                    let _ = timeout(LAST_WORDS, reading).await;
                }
                return SessionEnd::Disconnected;
            }
            () = shutdown.cancelled() => return SessionEnd::Shutdown,
        }
    }
}

/// Why reading ended.
enum ReadEnd {
    PeerClosed,
    Http,
}

async fn read_scripts(
    mut reader: impl AsyncRead + Unpin,
    client: ClientId,
    backend: &impl Backend,
    hub: &Hub,
) -> ReadEnd {
    let mut framer = Framer::default();
    let mut frames = Vec::new();
    let mut buffer = vec![0; READ_BYTES];
    // When the silence is long enough; `None` when it is not waited for.
    let mut silent_at = None;
    loop {
        let received = match silent_at {
            Some(deadline) => timeout_at(deadline, reader.read(&mut buffer)).await,
            None => Ok(reader.read(&mut buffer).await),
        };
        match received {
            Ok(Ok(count @ 1..)) => {
                framer.push(&buffer[..count], &mut frames);
                silent_at = framer.is_open().then(|| Instant::now() + SILENCE);
            }
            // End of stream, or a connection broken without a goodbye: both mean that no more comes.
            Ok(Ok(0) | Err(_)) => {
                framer.finish(EndedBy::PeerClosed, &mut frames);
                handle(&mut frames, client, backend, hub).await;
                return ReadEnd::PeerClosed;
            }
            Err(_elapsed) => {
                silent_at = None;
                let text = framer.open_text().map(str::to_owned);
                let whole = match text {
                    Some(text) => backend.is_whole_program(text).await,
                    None => false,
                };
                if whole {
                    tracing::warn!(
                        %client,
                        "primary: nothing came for {} s, so the open block is run without its `end`",
                        SILENCE.as_secs()
                    );
                    framer.finish(EndedBy::Silence, &mut frames);
                } else {
                    tracing::info!(%client, "primary: an open block waits for its `end`");
                }
            }
        }
        if handle(&mut frames, client, backend, hub).await {
            return ReadEnd::Http;
        }
    }
}

/// Hands over what was received. True when the connection has to be closed.
async fn handle(
    frames: &mut Vec<Frame>,
    client: ClientId,
    backend: &impl Backend,
    hub: &Hub,
) -> bool {
    for frame in frames.drain(..) {
        match frame {
            Frame::Program(program) => backend.submit(Submission { client, program }).await,
            Frame::Control(phrase) => backend.control(client, phrase).await,
            Frame::Rejected(rejection) => {
                tracing::warn!(%client, "primary: {rejection}");
                let (line, column) = match rejection {
                    Rejection::NotUtf8 { line, column } => (line, column),
                    Rejection::TooLong | Rejection::Speed { .. } => (1, 1),
                };
                let exception = Exception::Script {
                    line: i32::try_from(line).unwrap_or(i32::MAX),
                    column: i32::try_from(column).unwrap_or(i32::MAX),
                    text: rejection.to_string(),
                };
                hub.announce(backend.unix_millis(), Source::Controller, &exception);
            }
            Frame::Http => {
                tracing::warn!(%client, "primary: closed, the client speaks HTTP");
                return true;
            }
        }
    }
    false
}

/// Sends what the hub has until the connection breaks. One write a message, as the SDK needs it.
async fn write_messages(
    mut writer: impl AsyncWrite + Unpin,
    client: ClientId,
    mut from_hub: Subscription,
) -> io::Error {
    let mut pace = Pace::new();
    loop {
        let Some(message) = next_message(&mut from_hub, &mut pace, client).await else {
            return io::Error::other("the hub is gone");
        };
        if let Err(error) = writer.write_all(&message).await {
            return error;
        }
    }
}

/// The next message, exceptions first; `None` when there will be no more.
async fn next_message(
    from_hub: &mut Subscription,
    pace: &mut Pace,
    client: ClientId,
) -> Option<Message> {
    let Subscription { state, exceptions } = from_hub;
    loop {
        tokio::select! {
            biased;
            exception = async { sleep_until(pace.ready_at()).await; exceptions.recv().await } => match exception {
                Ok(message) => {
                    pace.sent(Instant::now());
                    return Some(message);
                }
                Err(RecvError::Lagged(missed)) => {
                    tracing::warn!(%client, missed, "primary: the client reads too slowly and missed exceptions");
                }
                Err(RecvError::Closed) => return None,
            },
            changed = state.changed() => {
                changed.ok()?;
                if let Some(message) = state.borrow_and_update().clone() {
                    return Some(message);
                }
            }
        }
    }
}

/// Allows a burst, then one each interval (the generic cell rate algorithm).
struct Pace {
    /// When everything sent so far would have been due at the steady rate.
    due: Instant,
}

impl Pace {
    fn new() -> Self {
        Self {
            due: Instant::now(),
        }
    }

    fn ready_at(&self) -> Instant {
        let slack = EXCEPTION_INTERVAL * (EXCEPTION_BURST - 1);
        self.due.checked_sub(slack).unwrap_or(self.due)
    }

    fn sent(&mut self, now: Instant) {
        self.due = self.due.max(now) + EXCEPTION_INTERVAL;
    }
}

#[cfg(test)]
mod tests;
