//! A connection to another machine, or to somebody in this process who stands in for one.

use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

use platform::sockets::{AsyncLocalStream, LocalStream};
use socket2::SockRef;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;

use crate::names;

/// Who stands in for machines on the network, in tests of programs. Both ends are in this process, so that what is sent
/// is there at once, and waiting for an answer takes simulated time only.
pub trait SimulatedPeers: Send + Sync {
    /// Whether somebody stands in for this address.
    fn simulates(&self, host: &str, port: u16) -> bool;

    /// Whether that somebody answers; where every address is known so that none leads out, nobody may be behind it.
    fn answers(&self, host: &str, port: u16) -> bool {
        self.simulates(host, port)
    }

    /// A connection to whoever stands in for this address; `None` where the real machine is meant.
    ///
    /// # Errors
    /// The system gave no connection.
    fn connect(&self, host: &str, port: u16) -> Option<io::Result<LocalStream>>;

    /// Answers what has been sent so far, as far as that needs nobody else.
    fn serve(&self);
}

/// A stream to a peer.
#[derive(Debug)]
pub enum PeerStream {
    /// Over the network.
    Tcp(TcpStream),
    /// Within this process.
    Local(AsyncLocalStream),
}

/// Runs the same on either.
macro_rules! on {
    ($link:expr, $stream:ident => $what:expr) => {
        match $link {
            PeerStream::Tcp($stream) => $what,
            PeerStream::Local($stream) => $what,
        }
    };
}

impl PeerStream {
    /// Connects to who stands in for the address, if somebody does, and to the machine otherwise. Needs a tokio
    /// runtime.
    ///
    /// # Errors
    /// What the system said.
    pub async fn open(
        host: &str,
        port: u16,
        stand_ins: Option<&Arc<dyn SimulatedPeers>>,
    ) -> io::Result<Self> {
        if let Some(local) = stand_ins.and_then(|stand_ins| stand_ins.connect(host, port)) {
            return Self::local(local?);
        }
        let stream = names::connect(host, port).await?;
        // Small messages are what is exchanged; a system that refuses this only makes them slower.
        let _ = stream.set_nodelay(true);
        Ok(Self::Tcp(stream))
    }

    /// One end of a pair within this process. Needs a tokio runtime.
    ///
    /// # Errors
    /// What the system said.
    pub fn local(stream: LocalStream) -> io::Result<Self> {
        stream.set_nonblocking(true)?;
        AsyncLocalStream::from_std(stream).map(Self::Local)
    }

    /// The system's socket.
    pub fn socket(&self) -> SockRef<'_> {
        on!(self, stream => SockRef::from(stream))
    }

    /// Waits until there is something to read.
    ///
    /// # Errors
    /// What the system said.
    pub async fn readable(&self) -> io::Result<()> {
        on!(self, stream => stream.readable().await)
    }

    /// Waits until something can be written.
    ///
    /// # Errors
    /// What the system said.
    pub async fn writable(&self) -> io::Result<()> {
        on!(self, stream => stream.writable().await)
    }

    /// Reads what is there.
    ///
    /// # Errors
    /// `WouldBlock` when nothing is; what the system said.
    pub fn try_read(&self, buffer: &mut [u8]) -> io::Result<usize> {
        on!(self, stream => stream.try_read(buffer))
    }

    /// Writes what there is room for.
    ///
    /// # Errors
    /// `WouldBlock` when there is none; what the system said.
    pub fn try_write(&self, data: &[u8]) -> io::Result<usize> {
        on!(self, stream => stream.try_write(data))
    }
}

impl AsyncRead for PeerStream {
    fn poll_read(
        self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        on!(self.get_mut(), stream => Pin::new(stream).poll_read(cx, buffer))
    }
}

impl AsyncWrite for PeerStream {
    fn poll_write(
        self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        data: &[u8],
    ) -> Poll<io::Result<usize>> {
        on!(self.get_mut(), stream => Pin::new(stream).poll_write(cx, data))
    }

    fn poll_flush(self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        on!(self.get_mut(), stream => Pin::new(stream).poll_flush(cx))
    }

    fn poll_shutdown(self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        on!(self.get_mut(), stream => Pin::new(stream).poll_shutdown(cx))
    }
}
