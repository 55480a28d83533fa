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

/// What a process of ours is started with as its standard input: the other end of a connection to it.
///
/// # Errors
/// The system has no more to give, or no such connections.
pub fn pair_with_child() -> io::Result<(LocalStream, std::process::Stdio)> {
    #[cfg(unix)]
    {
        let (own, other) = pair()?;
        let other: std::os::fd::OwnedFd = other.into();
        Ok((own, other.into()))
    }
    #[cfg(not(unix))]
    Err(crate::needs_linux("a socket as standard input"))
}

/// The end that this process was started with (see [`pair_with_child`]); a read comes back after `patience` at the
/// latest.
///
/// # Errors
/// Standard input is no such connection.
pub fn end_of_child(patience: std::time::Duration) -> io::Result<LocalStream> {
    #[cfg(unix)]
    {
        use std::os::fd::AsFd as _;
        let end = LocalStream::from(io::stdin().as_fd().try_clone_to_owned()?);
        // Asked of what is no socket, this is the error.
        end.local_addr()?;
        end.set_read_timeout(Some(patience))?;
        Ok(end)
    }
    #[cfg(not(unix))]
    {
        let _ = patience;
        Err(crate::needs_linux("a socket as standard input"))
    }
}

/// Holds every UDP socket of this process to the loopback interface: nothing from elsewhere reaches it, nothing leaves
/// the machine through it.
///
/// # Errors
/// The system refuses, or cannot do that.
pub fn hold_udp_to_loopback() -> io::Result<()> {
    #[cfg(target_os = "linux")]
    {
        for entry in std::fs::read_dir("/proc/self/fd")? {
            let name = entry?.file_name();
            let Some(number) = name.to_str().and_then(|name| name.parse::<i32>().ok()) else {
                continue;
            };
            hold_to_loopback(number)?;
        }
        Ok(())
    }
    #[cfg(not(target_os = "linux"))]
    Err(crate::needs_linux(
        "holding sockets to the loopback interface",
    ))
}

/// What the loopback interface is called on Linux.
#[cfg(target_os = "linux")]
const LOOPBACK: &[u8] = b"lo";

/// Binds the socket `number` to the loopback interface if it is one for datagrams of the internet.
#[cfg(target_os = "linux")]
fn hold_to_loopback(number: i32) -> io::Result<()> {
    let option = |option: libc::c_int| {
        let mut value: libc::c_int = 0;
        let mut length = size_of::<libc::c_int>() as libc::socklen_t;
        // SAFETY: the pointers are to locals of the lengths that are told. A number that is no socket is an error of
        // the call.
        #[allow(unsafe_code, reason = "asks a socket that somebody else owns")]
        let result = unsafe {
            libc::getsockopt(
                number,
                libc::SOL_SOCKET,
                option,
                (&raw mut value).cast(),
                &raw mut length,
            )
        };
        (result == 0).then_some(value)
    };
    let is_of_internet = matches!(
        option(libc::SO_DOMAIN),
        Some(libc::AF_INET | libc::AF_INET6)
    );
    if !is_of_internet || option(libc::SO_TYPE) != Some(libc::SOCK_DGRAM) {
        return Ok(());
    }
    // SAFETY: as above; the name is read, not kept.
    #[allow(unsafe_code, reason = "binds a socket that somebody else owns")]
    let result = unsafe {
        libc::setsockopt(
            number,
            libc::SOL_SOCKET,
            libc::SO_BINDTODEVICE,
            LOOPBACK.as_ptr().cast(),
            LOOPBACK.len() as libc::socklen_t,
        )
    };
    match result {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
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

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use std::net::UdpSocket;

    #[test]
    fn a_held_socket_is_of_the_loopback_interface_and_still_reached_there() {
        let receiver = UdpSocket::bind("0.0.0.0:0").unwrap();
        let sender = UdpSocket::bind("0.0.0.0:0").unwrap();
        hold_udp_to_loopback().unwrap();
        hold_udp_to_loopback().unwrap();
        let port = receiver.local_addr().unwrap().port();
        sender.send_to(b"here", ("127.0.0.1", port)).unwrap();
        let mut bytes = [0; 8];
        assert_eq!(receiver.recv(&mut bytes).unwrap(), 4);
        // What is sent elsewhere goes to the same interface and ends there.
        #[cfg(target_os = "linux")]
        for socket in [&receiver, &sender] {
            let device = socket2::SockRef::from(socket).device().unwrap();
            assert_eq!(device.as_deref(), Some(&b"lo"[..]));
        }
    }
}
