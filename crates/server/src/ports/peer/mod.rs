//! The stream of one client, whatever the port: browsers are turned away, and who is silent or deaf gives its place up.
//!
//! Owns what is the same on every port. A session reads and writes a [`Peer`] like any other stream; beside it the port
//! waits for [`PeerWatchdog::disconnect_reason`] and ends the session then, whatever that is waiting for.

use core::fmt;
use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, ready};
use std::time::Duration;

use parking_lot::Mutex;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;
use tokio::sync::Notify;
use tokio::time::{Instant, sleep_until};

use super::protocol_sniffer::{ForeignProtocol, ProtocolSniffer, SniffResult};

/// A client that neither sends nor takes anything for so long gives its place up. (One that only listens takes what it
/// is sent; a program that asks nothing of a port that only answers has no use for it.)
pub const IDLE_TIMEOUT: Duration = Duration::from_secs(3600);

/// A client to which something is to be sent and that takes nothing for so long gives its place up.
pub const WRITE_STALL_TIMEOUT: Duration = Duration::from_secs(30);

/// What is read at once while it is not clear yet whether a browser connects.
const OPENING_BYTES: usize = 4096;

/// What a port speaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PortProtocol {
    /// HTTP, and what begins as HTTP: who comes from where is looked at with each request.
    Http,
    /// A protocol of its own: browsers are turned away.
    Native,
}

/// A reason why a client gives its place up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DisconnectReason {
    /// The client belongs on another port.
    Intruder(ForeignProtocol),
    /// Nothing was sent or taken for [`IDLE_TIMEOUT`].
    Idle,
    /// Nothing was taken for [`WRITE_STALL_TIMEOUT`].
    WriteStalled,
}

impl fmt::Display for DisconnectReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Intruder(intruder) => write!(f, "{intruder}"),
            Self::Idle => write!(f, "the client was silent for {} s", IDLE_TIMEOUT.as_secs()),
            Self::WriteStalled => write!(
                f,
                "the client took nothing for {} s",
                WRITE_STALL_TIMEOUT.as_secs()
            ),
        }
    }
}

/// The stream of one client.
#[derive(Debug)]
pub struct Peer<S = TcpStream> {
    stream: S,
    /// Sniffer for the first bytes, until it is clear who connects.
    opening: Option<ProtocolSniffer>,
    /// Received while it was not clear, to be read before anything else.
    received: Vec<u8>,
    local_ip: IpAddr,
    /// Address of the client.
    address: Option<SocketAddr>,
    marks: Arc<PeerActivity>,
}

/// Sees when the client of a [`Peer`] gives its place up.
#[derive(Debug)]
pub struct PeerWatchdog(Arc<PeerActivity>);

/// What stream and watch share.
#[derive(Debug)]
struct PeerActivity {
    times: Mutex<ActivityTimes>,
    turned_away: Notify,
}

#[derive(Debug)]
struct ActivityTimes {
    /// Time when something was last sent or taken.
    moved: Instant,
    /// Since when the client takes nothing of what it is sent.
    deaf_since: Option<Instant>,
    intruder: Option<ForeignProtocol>,
}

impl PeerActivity {
    fn moved(&self) {
        self.times.lock().moved = Instant::now();
    }
}

impl Peer<TcpStream> {
    /// The stream of a client that was accepted just now, and the watch over it.
    pub fn accepted(stream: TcpStream, speaks: PortProtocol) -> (Self, PeerWatchdog) {
        let local = stream.local_addr().map(|address| address.ip());
        // A connection that is gone already has no address; nothing will come of it.
        let local = local.unwrap_or(IpAddr::V4(Ipv4Addr::UNSPECIFIED));
        let address = stream.peer_addr().ok();
        let (peer, watch) = Peer::new(stream, speaks, local);
        (Self { address, ..peer }, watch)
    }
}

impl<S> Peer<S> {
    /// A client over any stream, which it reached at the address `local_ip` of this machine.
    pub fn new(stream: S, speaks: PortProtocol, local_ip: IpAddr) -> (Self, PeerWatchdog) {
        let marks = Arc::new(PeerActivity {
            times: Mutex::new(ActivityTimes {
                moved: Instant::now(),
                deaf_since: None,
                intruder: None,
            }),
            turned_away: Notify::new(),
        });
        let peer = Self {
            stream,
            opening: (speaks == PortProtocol::Native).then(ProtocolSniffer::default),
            received: Vec::new(),
            local_ip,
            address: None,
            marks: Arc::clone(&marks),
        };
        (peer, PeerWatchdog(marks))
    }

    /// The address of this machine that the client has connected to.
    pub const fn local_ip(&self) -> IpAddr {
        self.local_ip
    }

    /// The address of the client, where it has one.
    pub const fn address(&self) -> Option<SocketAddr> {
        self.address
    }

    fn turn_away(&mut self, intruder: ForeignProtocol) -> io::Error {
        self.marks.times.lock().intruder = Some(intruder);
        self.marks.turned_away.notify_one();
        io::Error::new(io::ErrorKind::ConnectionAborted, intruder.to_string())
    }

    /// Hands out what was received while it was not clear who connects. False when there is nothing.
    fn drain_held(&mut self, into: &mut ReadBuf<'_>) -> bool {
        let count = self.received.len().min(into.remaining());
        into.put_slice(&self.received[..count]);
        self.received.drain(..count);
        if self.received.is_empty() {
            self.received = Vec::new();
        }
        count > 0
    }
}

impl<S: AsyncRead + Unpin> Peer<S> {
    /// Reads until there is something to hand out, the stream ends, or the client is turned away.
    fn poll_opening(&mut self, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        while let Some(opening) = &mut self.opening {
            let mut bytes = [0; OPENING_BYTES];
            let mut buffer = ReadBuf::new(&mut bytes);
            ready!(Pin::new(&mut self.stream).poll_read(context, &mut buffer))?;
            let came = buffer.filled();
            if came.is_empty() {
                opening.give_back(&mut self.received);
                self.opening = None;
                break;
            }
            self.marks.moved();
            match opening.take(came, &mut self.received) {
                SniffResult::Undecided if self.received.is_empty() => {}
                SniffResult::Undecided => break,
                SniffResult::Ours => self.opening = None,
                SniffResult::Intruder(intruder) => {
                    return Poll::Ready(Err(self.turn_away(intruder)));
                }
            }
        }
        Poll::Ready(Ok(()))
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for Peer<S> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        into: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let this = &mut *self;
        if into.remaining() == 0 || this.drain_held(into) {
            return Poll::Ready(Ok(()));
        }
        if this.opening.is_some() {
            ready!(this.poll_opening(context))?;
            if this.drain_held(into) {
                return Poll::Ready(Ok(()));
            }
        }
        let before = into.filled().len();
        ready!(Pin::new(&mut this.stream).poll_read(context, into))?;
        if into.filled().len() > before {
            this.marks.moved();
        }
        Poll::Ready(Ok(()))
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for Peer<S> {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write(context, bytes);
        let mut times = self.marks.times.lock();
        match written {
            Poll::Pending => {
                times.deaf_since.get_or_insert_with(Instant::now);
            }
            Poll::Ready(_) => {
                times.deaf_since = None;
                times.moved = Instant::now();
            }
        }
        drop(times);
        written
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

impl PeerWatchdog {
    /// Returns when the client has to give its place up.
    pub async fn disconnect_reason(&self) -> DisconnectReason {
        loop {
            let due = match self.look() {
                Ok(due) => due,
                Err(reason) => return reason,
            };
            tokio::select! {
                () = self.0.turned_away.notified() => {}
                () = sleep_until(due) => {}
            }
        }
    }

    /// The reason why the client gives its place up now, or the time of the next look.
    fn look(&self) -> Result<Instant, DisconnectReason> {
        let times = self.0.times.lock();
        if let Some(intruder) = times.intruder {
            return Err(DisconnectReason::Intruder(intruder));
        }
        let now = Instant::now();
        let silent_at = times.moved + IDLE_TIMEOUT;
        // Deafness that begins after this look is seen in the next one, before it is due.
        let deaf_at = times.deaf_since.map(|since| since + WRITE_STALL_TIMEOUT);
        if deaf_at.is_some_and(|at| at <= now) {
            Err(DisconnectReason::WriteStalled)
        } else if silent_at <= now {
            Err(DisconnectReason::Idle)
        } else {
            Ok(silent_at.min(deaf_at.unwrap_or(now + WRITE_STALL_TIMEOUT)))
        }
    }
}

#[cfg(test)]
mod tests;
