//! One client of the primary port, over any duplex stream.
//!
//! Reading and writing go on side by side: a client that does not read can still send scripts, and one that has sent
//! its script and closed its half still gets the stream. A connection that breaks never stops a script it sent, and
//! what arrived before the break is run. Programs and orders are carried out one after the other in the order in which
//! they came; while one is waited for, reading goes on, so that a `stop task` behind it is seen at once. It is seen
//! however much the client sends: what finds no room is refused, not left unread.

use std::collections::VecDeque;
use std::io;
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::sync::broadcast::error::RecvError;
use tokio::time::{Instant, sleep, sleep_until, timeout, timeout_at};
use tokio_util::sync::CancellationToken;

use super::framing::{ProgramEnd, ScriptFrame, ScriptFramer, ScriptRejection};
use super::hub::{AddressedMessage, MessageBytes, StateHub, Subscription};
use super::{PrimaryBackend, Sender, Submission};
use crate::ports::ClientId;
use crate::ports::escape::EscapedLine;
use wire::primary::exception::encode_exception;
use wire::primary::{Exception, ExceptionSource};

/// After this much silence an open block that is a whole program as it stands is run.
const SILENCE: Duration = Duration::from_secs(2);

/// What is read at once.
const READ_BYTES: usize = 16 * 1024;

/// With so many bytes of one client in the open block, waiting and being carried out, more is refused.
const HELD_BYTES_MAX: usize = 14 * 1024 * 1024;

/// What a client sends while there is no room for it is read with this pause after so many bytes.
const FLOOD_PAUSE: Duration = Duration::from_millis(1);
const FLOOD_BYTES: usize = 64 * 1024;

/// What one thing that waits takes beside its text, bytes, rounded up.
const FRAME_BYTES: usize = 128;

/// When the peer is gone, what it sent before is still read for so long.
const LAST_WORDS: Duration = Duration::from_secs(1);

/// Exceptions to one client: a burst of so many, then one each interval. The SDK takes at most one message in 10 ms
/// and must not fall behind; states take ten a second of that.
const EXCEPTION_BURST: u32 = 20;
const EXCEPTION_INTERVAL: Duration = Duration::from_millis(25);

/// A reason why a session ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SessionEnd {
    /// The connection is gone.
    Disconnected,
    /// The server ends.
    Shutdown,
    /// The controller is in local control mode.
    LocalMode,
}

/// What a client hears before its connection is closed in local mode.
const LOCAL_MODE: &str = "RuntimeError: remote control is off: in local control mode every connection to the \
    primary port is closed";

/// Time that a client in local mode has to hear that before it is disconnected.
const FAREWELL: Duration = Duration::from_millis(500);

/// Serves one client until its connection is gone, the port is closed to clients, or the server ends.
pub async fn serve(
    stream: impl AsyncRead + AsyncWrite,
    sender: impl Into<Sender>,
    backend: &impl PrimaryBackend,
    hub: &StateHub,
    shutdown: CancellationToken,
) -> SessionEnd {
    let sender = sender.into();
    let client = sender.client;
    let (mut reader, mut writer) = tokio::io::split(stream);
    {
        let reading = read_scripts(&mut reader, sender, backend, hub);
        let writing = write_messages(&mut writer, Some(client), hub.subscribe(backend));
        let closing = backend.closed_to_clients();
        tokio::pin!(reading, writing, closing);
        let mut more_to_read = true;
        loop {
            tokio::select! {
                biased;
                () = shutdown.cancelled() => return SessionEnd::Shutdown,
                () = &mut closing => break,
                () = &mut reading, if more_to_read => more_to_read = false,
                error = &mut writing => {
                    tracing::debug!(%client, %error, "primary: the client is gone");
                    if more_to_read {
                        // Elapsed: the peer is half dead; there is nobody left to serve either way.
                        let _ = timeout(LAST_WORDS, reading).await;
                    }
                    return SessionEnd::Disconnected;
                }
            }
        }
    }
    tracing::info!(%client, "primary: closed, as every client is in local control mode");
    // A client that is being written to is past helping; any other hears why, and what it still sends is dropped.
    let reason = Exception::Script {
        line: 1,
        column: 1,
        text: LOCAL_MODE.to_owned(),
    };
    let message = encode_exception(backend.unix_millis(), ExceptionSource::Controller, &reason);
    let farewell = async {
        writer.write_all(&message).await?;
        writer.shutdown().await?;
        tokio::io::copy(&mut reader, &mut tokio::io::sink()).await
    };
    let _ = timeout(FAREWELL, farewell).await;
    SessionEnd::LocalMode
}

/// Carries out what the client sends until it sends no more and all of it is done.
async fn read_scripts(
    reader: impl AsyncRead + Unpin,
    sender: Sender,
    backend: &impl PrimaryBackend,
    hub: &StateHub,
) {
    let client = sender.client;
    let mut input = ScriptReader::new(reader);
    let mut waiting = FrameQueue::default();
    let mut shed = 0;
    loop {
        let Some(frame) = waiting.next() else {
            if input.has_ended {
                return;
            }
            if core::mem::take(&mut input.is_silent) {
                let text = input.framer.open_text().map(str::to_owned);
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
                    waiting.add(input.finish(ProgramEnd::Silence), 0);
                } else {
                    tracing::info!(%client, "primary: an open block waits for its `end`");
                }
            } else {
                let mut frames = input.receive().await.into_iter();
                // The first has its turn at once; a stop behind it does not keep it from beginning.
                let first = frames.next();
                take_in(frames.collect(), 0, &mut waiting, backend);
                waiting.push_front(first);
            }
            continue;
        };
        // Others on this thread have a turn, however many orders wait here that take no time.
        tokio::task::yield_now().await;
        let bytes = bytes_of(&frame);
        let carried_out = carry_out(frame, sender, backend, hub);
        tokio::pin!(carried_out);
        loop {
            tokio::select! {
                biased;
                () = &mut carried_out => break,
                frames = input.receive(), if !input.has_ended => {
                    take_in(frames, bytes + input.framer.bytes(), &mut waiting, backend);
                    if bytes + waiting.bytes + input.framer.bytes() > HELD_BYTES_MAX {
                        waiting.add(input.give_up(), HELD_BYTES_MAX);
                    }
                    shed += if waiting.refuses_more() { READ_BYTES } else { 0 };
                    if shed < FLOOD_BYTES {
                        tokio::task::yield_now().await;
                    } else {
                        shed = 0;
                        sleep(FLOOD_PAUSE).await;
                    }
                }
            }
        }
    }
}

/// Adds what was received behind something that is being carried out. What must not wait acts now.
fn take_in(
    frames: Vec<ScriptFrame>,
    held: usize,
    waiting: &mut FrameQueue,
    backend: &impl PrimaryBackend,
) {
    for frame in &frames {
        if let ScriptFrame::Control(phrase) = frame
            && phrase.is_urgent()
        {
            backend.preempt(*phrase);
        }
    }
    waiting.add(frames, held);
}

/// What was received and not begun yet, in order.
#[derive(Default)]
struct FrameQueue {
    frames: VecDeque<ScriptFrame>,
    bytes: usize,
    programs: usize,
}

impl FrameQueue {
    /// Adds what came while `held` bytes of the client are held elsewhere. A stop makes programs before it needless.
    fn add(&mut self, frames: Vec<ScriptFrame>, held: usize) {
        for frame in frames {
            let is_stop = matches!(frame, ScriptFrame::Control(phrase) if phrase.ends_programs());
            if is_stop {
                self.drop_programs();
            }
            let has_room = held + self.bytes + bytes_of(&frame) <= HELD_BYTES_MAX;
            if has_room {
                self.push(frame);
            } else if is_stop {
                // Whatever else waits gives way to it.
                *self = Self::default();
                self.push(ScriptFrame::Rejected(ScriptRejection::TooMuchWaits));
                self.push(frame);
            } else if !self.refuses_more() {
                self.push(ScriptFrame::Rejected(ScriptRejection::TooMuchWaits));
            }
        }
    }

    /// The last that came found no room.
    fn refuses_more(&self) -> bool {
        matches!(
            self.frames.back(),
            Some(ScriptFrame::Rejected(ScriptRejection::TooMuchWaits))
        )
    }

    fn push(&mut self, frame: ScriptFrame) {
        self.count(&frame);
        self.frames.push_back(frame);
    }

    fn push_front(&mut self, frame: Option<ScriptFrame>) {
        if let Some(frame) = frame {
            self.count(&frame);
            self.frames.push_front(frame);
        }
    }

    fn count(&mut self, frame: &ScriptFrame) {
        self.bytes += bytes_of(frame);
        self.programs += usize::from(is_program(frame));
    }

    /// Programs that would begin only to be stopped do not begin; that is said in their place.
    fn drop_programs(&mut self) {
        let programs = core::mem::take(&mut self.programs);
        if programs > 0 {
            self.frames.retain(|frame| !is_program(frame));
            self.bytes = self.frames.iter().map(bytes_of).sum();
            self.push(ScriptFrame::Rejected(ScriptRejection::Stopped { programs }));
        }
    }

    fn next(&mut self) -> Option<ScriptFrame> {
        let frame = self.frames.pop_front()?;
        self.bytes -= bytes_of(&frame);
        self.programs -= usize::from(is_program(&frame));
        Some(frame)
    }
}

const fn is_program(frame: &ScriptFrame) -> bool {
    matches!(frame, ScriptFrame::Program(_))
}

fn bytes_of(frame: &ScriptFrame) -> usize {
    let text = match frame {
        ScriptFrame::Program(program) => program.text.capacity(),
        ScriptFrame::Control(_) | ScriptFrame::Rejected(_) => 0,
    };
    FRAME_BYTES + text
}

/// What comes from the client.
struct ScriptReader<R> {
    reader: R,
    framer: ScriptFramer,
    buffer: Vec<u8>,
    /// When the silence is long enough; `None` when it is not waited for.
    silent_at: Option<Instant>,
    /// The silence in the middle of a block is long enough now. Looked at when everything before the block is done.
    is_silent: bool,
    /// The client sends no more.
    has_ended: bool,
}

impl<R: AsyncRead + Unpin> ScriptReader<R> {
    fn new(reader: R) -> Self {
        Self {
            reader,
            framer: ScriptFramer::default(),
            buffer: vec![0; READ_BYTES],
            silent_at: None,
            is_silent: false,
            has_ended: false,
        }
    }

    /// What comes next; nothing when the client falls silent. No byte is lost when this is dropped before it returns.
    async fn receive(&mut self) -> Vec<ScriptFrame> {
        let read = self.reader.read(&mut self.buffer);
        let received = match self.silent_at {
            Some(deadline) => timeout_at(deadline, read).await,
            None => Ok(read.await),
        };
        match received {
            Ok(Ok(count @ 1..)) => {
                let mut frames = Vec::new();
                self.framer.push(&self.buffer[..count], &mut frames);
                self.silent_at = self.framer.is_open().then(|| Instant::now() + SILENCE);
                self.is_silent = false;
                frames
            }
            // End of stream, or a connection broken without a goodbye: both mean that no more comes.
            Ok(Ok(0) | Err(_)) => {
                self.has_ended = true;
                self.finish(ProgramEnd::PeerClosed)
            }
            Err(_elapsed) => {
                self.silent_at = None;
                self.is_silent = true;
                Vec::new()
            }
        }
    }

    /// Gives the open block up where it is more than a few bytes.
    fn give_up(&mut self) -> Vec<ScriptFrame> {
        let mut frames = Vec::new();
        self.framer.give_up(&mut frames);
        frames
    }

    /// The open block as it stands.
    fn finish(&mut self, ended_by: ProgramEnd) -> Vec<ScriptFrame> {
        let mut frames = Vec::new();
        self.framer.finish(ended_by, &mut frames);
        frames
    }
}

/// Does one thing that the client wants; returns when the next one may begin.
async fn carry_out(
    frame: ScriptFrame,
    sender: Sender,
    backend: &impl PrimaryBackend,
    hub: &StateHub,
) {
    let client = sender.client;
    match frame {
        ScriptFrame::Program(program) => backend.submit(Submission { sender, program }).await,
        ScriptFrame::Control(phrase) => backend.control(client, phrase).await,
        ScriptFrame::Rejected(rejection) => {
            let text = rejection.to_string();
            tracing::warn!(%client, "primary: {}", EscapedLine(&text));
            let (line, column) = match rejection {
                ScriptRejection::NotUtf8 { line, column } => (line, column),
                ScriptRejection::TooLong
                | ScriptRejection::TooMuchWaits
                | ScriptRejection::Stopped { .. }
                | ScriptRejection::CutOff { .. }
                | ScriptRejection::Speed { .. } => (1, 1),
            };
            let exception = Exception::Script {
                line: i32::try_from(line).unwrap_or(i32::MAX),
                column: i32::try_from(column).unwrap_or(i32::MAX),
                text,
            };
            hub.announce(
                backend.unix_millis(),
                ExceptionSource::Controller,
                &exception,
            );
        }
    }
}

/// Sends what the hub has until the connection breaks, what is for others left out; `client` is `None` for one that is
/// sent nothing of its own. One write a message, as the SDK needs it.
pub(in crate::ports) async fn write_messages(
    writer: &mut (impl AsyncWrite + Unpin),
    client: Option<ClientId>,
    mut from_hub: Subscription,
) -> io::Error {
    let mut pace = RateLimiter::new();
    if let Some(first) = &from_hub.first
        && let Err(error) = writer.write_all(&first.message).await
    {
        return error;
    }
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
    pace: &mut RateLimiter,
    client: Option<ClientId>,
) -> Option<MessageBytes> {
    let Subscription {
        state,
        exceptions,
        first,
    } = from_hub;
    loop {
        tokio::select! {
            biased;
            exception = async { sleep_until(pace.ready_at()).await; exceptions.recv().await } => match exception {
                Ok(AddressedMessage { to, message }) if to.is_none() || to == client => {
                    pace.sent(Instant::now());
                    return Some(message);
                }
                Ok(_) => {}
                Err(RecvError::Lagged(missed)) => {
                    tracing::warn!(?client, missed, "primary: the client reads too slowly and missed exceptions");
                }
                Err(RecvError::Closed) => return None,
            },
            changed = state.changed() => {
                changed.ok()?;
                let before = first.take().map(|first| first.time);
                if let Some(next) = &*state.borrow_and_update()
                    && before.is_none_or(|before| next.time >= before)
                {
                    return Some(next.message.clone());
                }
            }
        }
    }
}

/// Allows a burst, then one each interval (the generic cell rate algorithm).
struct RateLimiter {
    /// When everything sent so far would have been due at the steady rate.
    due: Instant,
}

impl RateLimiter {
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
