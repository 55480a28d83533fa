//! One client of a port that speaks HTTP, without a network: what it sends in two pieces, and all that it is answered.

use std::future::Future;
use std::net::{IpAddr, Ipv4Addr};

use server::ports::allowed_hosts::AllowedHosts;
use server::ports::peer::{Peer, PortProtocol};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _, DuplexStream, duplex};
use tokio::runtime::{Builder, Runtime};

/// What may be on its way in one direction, bytes.
const ON_THE_WAY: usize = 64 * 1024;

/// Address that the client has connected to.
const LOCAL: IpAddr = IpAddr::V4(Ipv4Addr::LOCALHOST);

thread_local! {
    static RUNTIME: Runtime = runtime();
}

#[allow(clippy::expect_used, reason = "without a runtime nothing can be tried")]
fn runtime() -> Runtime {
    let mut builder = Builder::new_current_thread();
    builder
        .enable_time()
        .build()
        .expect("a runtime of one thread")
}

/// Who may call.
pub(super) fn callers() -> AllowedHosts {
    AllowedHosts::of(LOCAL, None, &[])
}

/// True when a text names this machine in a way that [`allowed_hosts`] lets in, or is so old that it names none.
/// Coarse: it may be true of a request that is refused, it is never false of one that is let in.
pub(super) fn may_be_for_us(sent: &[u8]) -> bool {
    let text = String::from_utf8_lossy(sent).to_ascii_lowercase();
    ["localhost", "127.", "[", "http/1.0"]
        .iter()
        .any(|name| text.contains(name))
}

/// Everything that a client is sent that sends this and then no more.
pub(super) fn answered<F: Future<Output = ()>>(
    sent: &[u8],
    serve: impl FnOnce(Peer<DuplexStream>) -> F,
) -> Vec<u8> {
    RUNTIME.with(|runtime| {
        runtime.block_on(async {
            let (client, stream) = duplex(ON_THE_WAY);
            let (peer, _watch) = Peer::new(stream, PortProtocol::Http, LOCAL);
            let (mut from_server, mut to_server) = tokio::io::split(client);
            let sending = async {
                let (first, rest) = sent.split_at(sent.len() / 3);
                for piece in [first, rest] {
                    // A server that has had enough hangs up.
                    _ = to_server.write_all(piece).await;
                    tokio::task::yield_now().await;
                }
                _ = to_server.shutdown().await;
            };
            let mut answer = Vec::new();
            let reading = from_server.read_to_end(&mut answer);
            _ = tokio::join!(serve(peer), sending, reading);
            answer
        })
    })
}
