//! Connections within the process, and how long a peer over the network may take nothing.
//!
//! A connection within the process has two ends; what is written to one is read from the other. On POSIX systems it is
//! a pair of local sockets, in which what was written is there at once. Elsewhere a connection of the loopback
//! interface to itself.

use std::io;

/// One end.
#[cfg(unix)]
pub type LocalStream = std::os::unix::net::UnixStream;
/// One end.
#[cfg(not(unix))]
pub type LocalStream = std::net::TcpStream;

/// One end for tokio.
#[cfg(all(unix, feature = "net"))]
pub type AsyncLocalStream = tokio::net::UnixStream;
/// One end for tokio.
#[cfg(all(not(unix), feature = "net"))]
pub type AsyncLocalStream = tokio::net::TcpStream;

/// Both ends.
///
/// # Errors
/// The system has no more to give.
#[cfg(unix)]
pub fn pair() -> io::Result<(LocalStream, LocalStream)> {
    LocalStream::pair()
}

/// Both ends.
///
/// # Errors
/// The system has no more to give, or somebody else called in between.
#[cfg(not(unix))]
pub fn pair() -> io::Result<(LocalStream, LocalStream)> {
    let listener = std::net::TcpListener::bind((std::net::Ipv4Addr::LOCALHOST, 0))?;
    let one = LocalStream::connect(listener.local_addr()?)?;
    let (other, caller) = listener.accept()?;
    if caller != one.local_addr()? {
        return Err(io::ErrorKind::ConnectionAborted.into());
    }
    one.set_nodelay(true)?;
    other.set_nodelay(true)?;
    Ok((one, other))
}

/// Breaks a connection whose peer acknowledges nothing for so long, where the system can; elsewhere it tries as long as
/// it does by itself.
///
/// # Errors
/// What the system says.
#[cfg(feature = "net")]
pub fn break_when_deaf_for(
    socket: socket2::SockRef<'_>,
    limit: std::time::Duration,
) -> io::Result<()> {
    #[cfg(target_os = "linux")]
    socket.set_tcp_user_timeout(Some(limit))?;
    #[cfg(not(target_os = "linux"))]
    let _ = (socket, limit);
    Ok(())
}
