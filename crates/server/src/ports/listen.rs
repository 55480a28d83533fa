//! Accepting clients: the same loop for every port.
//!
//! Owns the limit of clients, their numbers and the end of the port. Which address a port listens on is decided by
//! [`bind`]'s caller; who is turned away or gives its place up, by [`peer`](super::peer); what a client may say, by the
//! session.

use core::fmt;
use std::future::Future;
use std::io;
use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use messages::Localized;
use platform::sockets::break_when_deaf_for;
use socket2::{SockRef, TcpKeepalive};
use supervision::{ThreadRole, ThreadSupervisor, injection};
use thiserror::Error;
use tokio::net::{TcpListener, TcpStream};
use tokio::task::JoinSet;
use tokio_util::sync::CancellationToken;
use tracing::Instrument as _;

use super::peer::{Peer, PortProtocol, WRITE_STALL_TIMEOUT};
use crate::options::PortSetting;

/// Clients of one port; one more is closed at once.
pub const CLIENTS_MAX: usize = 64;

/// After a failed accept (no file descriptors left, say) the port waits so long.
const ACCEPT_PAUSE: Duration = Duration::from_millis(50);

/// What the operating system keeps for a client that does not take it, bytes at most. More would hide for minutes that
/// a client takes nothing; a fast client of a distant network still gets 2 MB/s with it.
const SEND_BUFFER_BYTES: usize = 128 * 1024;

/// Longest time that sessions may take to end.
const FAREWELL: Duration = Duration::from_secs(1);

/// Number of a client, from 1, in the order in which clients of a port connected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ClientId(pub u64);

impl fmt::Display for ClientId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0)
    }
}

/// Name of a port and how many clients it has now. Cloning gives another handle to the same count.
#[derive(Clone, Debug)]
pub struct PortMeter {
    name: &'static str,
    clients: Arc<AtomicUsize>,
    faults: ThreadSupervisor,
}

impl PortMeter {
    /// A port without clients.
    pub fn new(name: &'static str) -> Self {
        Self {
            name,
            clients: Arc::default(),
            faults: ThreadSupervisor::default(),
        }
    }

    /// This port with a supervisor, which hears of the faults in its sessions.
    pub fn with_faults(self, faults: ThreadSupervisor) -> Self {
        Self { faults, ..self }
    }

    /// The name, as in the ready file.
    pub const fn name(&self) -> &'static str {
        self.name
    }

    /// Number of clients that are connected now.
    pub fn clients(&self) -> usize {
        self.clients.load(Ordering::Relaxed)
    }
}

/// A reason why a port cannot be opened, told in one sentence that says what to do.
#[derive(Debug, Error, Localized)]
pub enum BindError {
    /// Somebody else has it.
    #[error(
        "{address} is in use by another program: stop it, or choose another port with {option} (0 takes any free one)"
    )]
    #[zh(
        "{address} 正被其他程序使用：请停止该程序，或用 {option} 选择其他端口（0 为任意空闲端口）"
    )]
    InUse {
        /// Address that was asked for.
        address: SocketAddr,
        /// The option that chooses the port.
        option: &'static str,
    },
    /// A port below 1024, usually.
    #[error("this user may not listen on {address}: choose a port from 1024 on with {option}")]
    #[zh("此用户不能监听 {address}：请用 {option} 选择 1024 及以上的端口")]
    NotAllowed {
        /// Address that was asked for.
        address: SocketAddr,
        /// The option that chooses the port.
        option: &'static str,
    },
    /// The machine has no such address.
    #[error("this machine has no address {}: choose one of its own with --bind", address.ip())]
    #[zh("本机没有地址 {}：请用 --bind 选择本机的地址", address.ip())]
    NoSuchAddress {
        /// Address that was asked for.
        address: SocketAddr,
    },
    /// The port cannot be opened for another reason.
    #[error("cannot listen on {address} ({option}): {source}")]
    #[zh("无法监听 {address}（{option}）：{source}")]
    Other {
        /// Address that was asked for.
        address: SocketAddr,
        /// The option that chooses the port.
        option: &'static str,
        /// Error of the operating system.
        source: io::Error,
    },
}

/// A bound port, or `None` where the setting is off. `option` is named in errors.
pub async fn bind(
    option: &'static str,
    ip: IpAddr,
    setting: PortSetting,
) -> Result<Option<TcpListener>, BindError> {
    let port = match setting {
        PortSetting::Off => return Ok(None),
        PortSetting::Any => 0,
        PortSetting::Number(port) => port,
        PortSetting::Either(port, otherwise) => match open(option, ip, port).await {
            Err(BindError::NotAllowed { .. }) => {
                tracing::info!(
                    "{port} needs a privilege that this user does not have: {otherwise} is opened in its place, and \
                     clients must be told so ({option} chooses)"
                );
                otherwise
            }
            opened => return opened.map(Some),
        },
    };
    open(option, ip, port).await.map(Some)
}

async fn open(option: &'static str, ip: IpAddr, port: u16) -> Result<TcpListener, BindError> {
    let address = SocketAddr::new(ip, port);
    TcpListener::bind(address)
        .await
        .map_err(|source| match source.kind() {
            io::ErrorKind::AddrInUse => BindError::InUse { address, option },
            io::ErrorKind::PermissionDenied => BindError::NotAllowed { address, option },
            io::ErrorKind::AddrNotAvailable => BindError::NoSuchAddress { address },
            _ => BindError::Other {
                address,
                option,
                source,
            },
        })
}

/// Accepts clients until `shutdown` and runs `session` for each, until that ends or the client gives its place up.
/// Returns when every session has ended; the listener is closed first.
pub async fn serve_port<S>(
    listener: TcpListener,
    speaks: PortProtocol,
    meter: PortMeter,
    shutdown: CancellationToken,
    session: impl Fn(Peer, ClientId, CancellationToken) -> S,
) where
    S: Future<Output = ()> + Send + 'static,
{
    let name = meter.name;
    let mut sessions = JoinSet::new();
    let mut last = 0;
    loop {
        let accepted = tokio::select! {
            () = shutdown.cancelled() => break,
            Some(_ended) = sessions.join_next() => {
                meter.clients.store(sessions.len(), Ordering::Relaxed);
                continue;
            }
            accepted = listener.accept() => accepted,
        };
        let (stream, peer) = match accepted {
            Ok(accepted) => accepted,
            Err(error) => {
                tracing::warn!(port = meter.name, %error, "cannot accept a client");
                tokio::time::sleep(ACCEPT_PAUSE).await;
                continue;
            }
        };
        while sessions.try_join_next().is_some() {}
        if sessions.len() >= CLIENTS_MAX {
            tracing::warn!(
                port = meter.name,
                %peer,
                "refused: {CLIENTS_MAX} clients are connected, which is the limit"
            );
            continue;
        }
        if let Err(error) = prepare(&stream) {
            // A connection that is gone already, usually; the session finds out by itself.
            tracing::debug!(port = meter.name, %peer, %error, "cannot set socket options");
        }
        last += 1;
        let client = ClientId(last);
        // Of the highest level: who it is about is told with every message that is shown.
        let span = tracing::error_span!("session", port = meter.name, %client, %peer);
        span.in_scope(|| tracing::debug!("connected"));
        let (peer, watch) = Peer::accepted(stream, speaks);
        let session = session(peer, client, shutdown.clone());
        let until_it_gives_up = async move {
            injection::point(name);
            tokio::select! {
                reason = watch.disconnect_reason() => tracing::warn!("closed: {reason}"),
                () = session => {}
            }
        };
        // A fault ends this client only; it has been told when it happened.
        let contained = meter
            .faults
            .catch_panics(ThreadRole::Port, name, until_it_gives_up);
        #[allow(
            clippy::disallowed_methods,
            reason = "the one place where sessions start, each contained"
        )]
        sessions.spawn(contained.instrument(span));
        meter.clients.store(sessions.len(), Ordering::Relaxed);
    }
    drop(listener);
    let all_ended = async { while sessions.join_next().await.is_some() {} };
    if tokio::time::timeout(FAREWELL, all_ended).await.is_err() {
        tracing::debug!(port = meter.name, "some clients are cut off");
        sessions.shutdown().await;
    }
    meter.clients.store(0, Ordering::Relaxed);
}

/// [`serve_port`] for the protocols of the ports' own: every session has its handle of what all `share`, ends with the
/// port at the latest, and how its connection ended is for the log of whoever looks for it.
pub async fn serve_sessions<T, S, E>(
    listener: TcpListener,
    meter: PortMeter,
    shutdown: CancellationToken,
    share: T,
    session: impl Fn(Peer, ClientId, T) -> S,
) where
    T: Clone,
    S: Future<Output = Result<(), E>> + Send + 'static,
    E: fmt::Display + Send,
{
    let name = meter.name;
    let until_the_end = |stream, client, shutdown: CancellationToken| {
        let session = session(stream, client, share.clone());
        async move {
            if let Some(Err(error)) = shutdown.run_until_cancelled(session).await {
                tracing::debug!(%client, %error, "{name}: the connection ended");
            }
        }
    };
    serve_port(
        listener,
        PortProtocol::Native,
        meter,
        shutdown,
        until_the_end,
    )
    .await;
}

/// Starts the service of a port. After a fault that no session has contained it is begun again on the same port.
pub fn start_port<F>(
    services: &mut JoinSet<()>,
    listener: TcpListener,
    meter: &PortMeter,
    mut serve: impl FnMut(TcpListener) -> F + Send + 'static,
) -> io::Result<()>
where
    F: Future<Output = ()> + Send,
{
    let listener = listener.into_std()?;
    let (faults, name) = (meter.faults.clone(), meter.name);
    #[allow(
        clippy::disallowed_methods,
        reason = "the one place where ports start, each kept up"
    )]
    services.spawn(async move {
        let begin = || {
            let again = listener.try_clone().and_then(TcpListener::from_std);
            let serving = again.map(&mut serve);
            async move {
                match serving {
                    Ok(serving) => serving.await,
                    Err(error) => tracing::error!(port = name, %error, "the port is closed"),
                }
            }
        };
        faults.run_restarting(name, begin).await;
    });
    Ok(())
}

/// No delay for small messages; a peer that vanished without a word is noticed within half a minute, and so is one
/// whose side takes nothing more.
fn prepare(stream: &TcpStream) -> io::Result<()> {
    stream.set_nodelay(true)?;
    let keepalive = TcpKeepalive::new()
        .with_time(Duration::from_secs(15))
        .with_interval(Duration::from_secs(5))
        .with_retries(3);
    let socket = SockRef::from(stream);
    socket.set_tcp_keepalive(&keepalive)?;
    socket.set_send_buffer_size(SEND_BUFFER_BYTES)?;
    break_when_deaf_for(socket, WRITE_STALL_TIMEOUT)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::Ipv4Addr;
    use tokio::io::{AsyncReadExt, AsyncWriteExt};

    const LOCALHOST: IpAddr = IpAddr::V4(Ipv4Addr::LOCALHOST);

    async fn any_port() -> (TcpListener, SocketAddr) {
        let listener = bind("--x-port", LOCALHOST, PortSetting::Any)
            .await
            .unwrap()
            .unwrap();
        let address = listener.local_addr().unwrap();
        (listener, address)
    }

    /// Sends `hi` and stays until the server ends or the client goes.
    async fn greet(mut stream: Peer, _: ClientId, shutdown: CancellationToken) {
        let _ = stream.write_all(b"hi").await;
        let mut byte = [0];
        let _ = shutdown.run_until_cancelled(stream.read(&mut byte)).await;
    }

    #[tokio::test]
    async fn a_port_in_use_is_named_with_its_option_and_a_way_out() {
        let (_listener, address) = any_port().await;
        let setting = PortSetting::Number(address.port());
        let error = bind("--x-port", LOCALHOST, setting).await.unwrap_err();
        assert_eq!(
            error.to_string(),
            format!(
                "{address} is in use by another program: stop it, or choose another port with --x-port (0 takes any \
                 free one)"
            )
        );
        let off = bind("--x-port", LOCALHOST, PortSetting::Off).await.unwrap();
        assert!(off.is_none());
        // An address for documentation (RFC 5737), which no machine has.
        let error = bind("--x-port", "192.0.2.1".parse().unwrap(), PortSetting::Any).await;
        assert!(error.unwrap_err().to_string().contains("--bind"));
    }

    #[tokio::test]
    async fn one_client_more_than_the_limit_is_closed_and_a_place_can_be_taken_again() {
        let (listener, address) = any_port().await;
        let (meter, shutdown) = (PortMeter::new("x"), CancellationToken::new());
        let port = tokio::spawn(serve_port(
            listener,
            PortProtocol::Native,
            meter.clone(),
            shutdown.clone(),
            greet,
        ));
        let mut clients = Vec::new();
        let mut two = [0; 2];
        for _ in 0..CLIENTS_MAX {
            let mut client = TcpStream::connect(address).await.unwrap();
            client.read_exact(&mut two).await.unwrap();
            clients.push(client);
        }
        assert_eq!(meter.clients(), CLIENTS_MAX);
        let mut one_more = TcpStream::connect(address).await.unwrap();
        assert_eq!(one_more.read(&mut two).await.unwrap_or(0), 0);

        drop(clients.pop());
        while meter.clients() == CLIENTS_MAX {
            tokio::task::yield_now().await;
        }
        let mut next = TcpStream::connect(address).await.unwrap();
        next.read_exact(&mut two).await.unwrap();

        shutdown.cancel();
        port.await.unwrap();
        assert_eq!(meter.clients(), 0);
        assert!(TcpStream::connect(address).await.is_err());
        assert_eq!(next.read(&mut two).await.unwrap_or(0), 0);
    }

    #[tokio::test]
    async fn a_session_that_panics_ends_alone() {
        let (listener, address) = any_port().await;
        let shutdown = CancellationToken::new();
        let session = |stream, client, shutdown| async move {
            assert!(client != ClientId(1), "the first client meets a fault");
            greet(stream, client, shutdown).await;
        };
        let port = tokio::spawn(serve_port(
            listener,
            PortProtocol::Native,
            PortMeter::new("x"),
            shutdown.clone(),
            session,
        ));
        let mut two = [0; 2];
        let mut first = TcpStream::connect(address).await.unwrap();
        assert_eq!(first.read(&mut two).await.unwrap_or(0), 0);
        let mut second = TcpStream::connect(address).await.unwrap();
        second.read_exact(&mut two).await.unwrap();
        shutdown.cancel();
        port.await.unwrap();
    }

    #[tokio::test(start_paused = true)]
    async fn a_session_that_does_not_end_is_cut_off() {
        let (listener, address) = any_port().await;
        let shutdown = CancellationToken::new();
        let session = |stream, _, _| async move {
            let _stream = stream;
            std::future::pending().await
        };
        let port = tokio::spawn(serve_port(
            listener,
            PortProtocol::Native,
            PortMeter::new("x"),
            shutdown.clone(),
            session,
        ));
        let _client = TcpStream::connect(address).await.unwrap();
        tokio::task::yield_now().await;
        shutdown.cancel();
        port.await.unwrap();
    }
}
