//! Names of other machines become addresses without anybody having to wait for the system's resolver.
//!
//! The resolver blocks, may do so for half a minute, and cannot be interrupted. So each look-up has a thread of its
//! own, which is left behind when nobody waits for it any more: a wait on a name can be dropped like any other.

use std::io;
use std::net::{IpAddr, SocketAddr, ToSocketAddrs};
use std::sync::atomic::{AtomicUsize, Ordering};

use supervision::{ThreadRole, ThreadSupervisor, injection};
use tokio::net::{TcpSocket, TcpStream};
use tokio::sync::oneshot;

/// Look-ups under way at once, those included that nobody waits for any more.
pub const LOOK_UPS_MAX: usize = 32;

static ACTIVE_LOOKUPS: AtomicUsize = AtomicUsize::new(0);

/// A place among the look-ups, given back when it is dropped.
struct LookupPermit;

impl LookupPermit {
    fn take() -> io::Result<Self> {
        let place = Self;
        if ACTIVE_LOOKUPS.fetch_add(1, Ordering::Relaxed) < LOOK_UPS_MAX {
            return Ok(place);
        }
        Err(io::Error::other(format!(
            "{LOOK_UPS_MAX} names are being looked up and have not been answered; this one is not"
        )))
    }
}

impl Drop for LookupPermit {
    fn drop(&mut self) {
        ACTIVE_LOOKUPS.fetch_sub(1, Ordering::Relaxed);
    }
}

/// The addresses of a host. May be dropped at any time.
///
/// # Errors
/// What the resolver says, or that too many look-ups are under way.
pub async fn resolve(host: &str, port: u16) -> io::Result<Vec<SocketAddr>> {
    if let Ok(ip) = host.parse::<IpAddr>() {
        return Ok(vec![SocketAddr::new(ip, port)]);
    }
    let place = LookupPermit::take()?;
    let host = host.to_owned();
    let (sender, receiver) = oneshot::channel();
    ThreadSupervisor::default().start(ThreadRole::Service, "name look-up", move || {
        let _place = place;
        injection::point("resolver");
        let found = (host.as_str(), port).to_socket_addrs();
        // Whoever asked may have given up.
        let _ = sender.send(found.map(Iterator::collect));
    })?;
    let fault = |_| Err(io::Error::other("the look-up met a fault of ours"));
    receiver.await.unwrap_or_else(fault)
}

/// Connects to a host by name or address: to its first address that answers.
///
/// # Errors
/// Those of [`resolve`]; what the last address said.
pub async fn connect(host: &str, port: u16) -> io::Result<TcpStream> {
    let mut refused = None;
    for address in resolve(host, port).await? {
        match connect_from_anywhere(address).await {
            Ok(stream) => return Ok(stream),
            Err(error) => refused = Some(error),
        }
    }
    Err(refused.unwrap_or_else(|| {
        io::Error::new(io::ErrorKind::NotFound, format!("{host} has no address"))
    }))
}

/// Connects from a port that may be one of this machine's services a moment later: the vendor's clients listen on
/// numbers among those that the system gives out, and a connection that was closed must not keep them from it for a
/// minute.
async fn connect_from_anywhere(address: SocketAddr) -> io::Result<TcpStream> {
    let socket = match address {
        SocketAddr::V4(_) => TcpSocket::new_v4()?,
        SocketAddr::V6(_) => TcpSocket::new_v6()?,
    };
    socket.set_reuseaddr(true)?;
    socket.connect(address).await
}

/// Connects to an address written `host:port`.
///
/// # Errors
/// Those of [`connect`]; that the text is no such pair.
pub async fn connect_to(authority: &str) -> io::Result<TcpStream> {
    let pair = authority.rsplit_once(':');
    let pair = pair.and_then(|(host, port)| Some((host, port.parse().ok()?)));
    let Some((host, port)) = pair else {
        let text = format!("{authority:?} is not a host and a port");
        return Err(io::Error::new(io::ErrorKind::InvalidInput, text));
    };
    connect(host.trim_matches(['[', ']']), port).await
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::{Duration, Instant};

    #[tokio::test]
    async fn addresses_and_names_of_this_machine_are_found() {
        let found = resolve("127.0.0.1", 80).await.unwrap();
        assert_eq!(found, ["127.0.0.1:80".parse().unwrap()]);
        assert_eq!(
            resolve("::1", 1).await.unwrap(),
            ["[::1]:1".parse().unwrap()]
        );
        let found = resolve("localhost", 80).await.unwrap();
        assert!(found.iter().all(|address| address.ip().is_loopback()));
        let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
        let port = listener.local_addr().unwrap().port();
        connect("localhost", port).await.unwrap();
        connect_to(&format!("localhost:{port}")).await.unwrap();
        assert!(connect_to("localhost").await.is_err());
    }

    #[test]
    fn a_resolver_that_hangs_holds_nobody_and_takes_only_so_many_threads() {
        injection::order("resolver hang");
        let begin = Instant::now();
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .unwrap();
        runtime.block_on(async {
            for _ in 0..LOOK_UPS_MAX {
                let wait = resolve("slow.invalid", 80);
                let ended = tokio::time::timeout(Duration::from_millis(1), wait).await;
                assert!(ended.is_err(), "{ended:?}");
            }
            let refused = resolve("slow.invalid", 80).await.unwrap_err().to_string();
            assert!(refused.contains("32 names"), "{refused}");
            assert!(resolve("127.0.0.1", 80).await.is_ok());
        });
        drop(runtime);
        assert!(begin.elapsed() < Duration::from_secs(5));
    }
}
