//! Slow, silent, deaf and lively clients, with time that passes at once.

use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream, duplex};

use super::*;

const HERE: IpAddr = IpAddr::V4(Ipv4Addr::LOCALHOST);

fn peer(speaks: PortProtocol) -> (DuplexStream, Peer<DuplexStream>, PeerWatchdog) {
    let (client, server) = duplex(64);
    let (peer, watch) = Peer::new(server, speaks, HERE);
    (client, peer, watch)
}

/// When and why the client gives its place up while `doing` goes on.
async fn gives_up(
    watch: &PeerWatchdog,
    doing: impl Future<Output = ()>,
) -> (Duration, DisconnectReason) {
    let start = Instant::now();
    tokio::select! {
        reason = watch.disconnect_reason() => (start.elapsed(), reason),
        () = async { doing.await; std::future::pending().await } => unreachable!(),
    }
}

#[tokio::test(start_paused = true)]
async fn a_silent_client_gives_its_place_up_after_an_hour() {
    let (mut client, mut peer, watch) = peer(PortProtocol::Native);
    let mut byte = [0];
    let talk = async {
        tokio::time::sleep(Duration::from_secs(3000)).await;
        client.write_all(b"x").await.unwrap();
        peer.read_exact(&mut byte).await.unwrap();
    };
    let (after, reason) = gives_up(&watch, talk).await;
    assert_eq!(reason, DisconnectReason::Idle);
    assert_eq!(after, Duration::from_secs(3000) + IDLE_TIMEOUT);
}

#[tokio::test(start_paused = true)]
async fn a_deaf_client_gives_its_place_up_after_half_a_minute() {
    let (mut client, mut peer, watch) = peer(PortProtocol::Native);
    let stream = async {
        // What the client takes late counts: 20 s are not 30 s.
        let mut taken = [0; 64];
        let late = async {
            tokio::time::sleep(Duration::from_secs(20)).await;
            client.read_exact(&mut taken).await.unwrap();
        };
        let (written, ()) = tokio::join!(peer.write_all(&[7; 200]), late);
        written.unwrap();
    };
    let (after, reason) = gives_up(&watch, stream).await;
    assert_eq!(reason, DisconnectReason::WriteStalled);
    assert_eq!(after, Duration::from_secs(20) + WRITE_STALL_TIMEOUT);
}

#[tokio::test(start_paused = true)]
async fn a_client_that_only_listens_keeps_its_place() {
    let (mut client, mut peer, watch) = peer(PortProtocol::Native);
    let stream = async {
        for _ in 0..30 {
            tokio::time::sleep(Duration::from_secs(1000)).await;
            peer.write_all(b"state").await.unwrap();
            client.read_exact(&mut [0; 5]).await.unwrap();
        }
    };
    let (after, reason) = gives_up(&watch, stream).await;
    assert_eq!(reason, DisconnectReason::Idle);
    assert_eq!(after, Duration::from_secs(30_000) + IDLE_TIMEOUT);
}

#[tokio::test(start_paused = true)]
async fn a_browser_is_turned_away_and_nothing_of_it_is_read() {
    for bytes in [
        &b"POST / HTTP/1.1\r\n\r\nstop task\n"[..],
        &[0x16, 3, 1, 2, 0],
    ] {
        let (mut client, mut peer, watch) = peer(PortProtocol::Native);
        client.write_all(bytes).await.unwrap();
        let mut read = Vec::new();
        assert!(peer.read_to_end(&mut read).await.is_err());
        assert!(read.is_empty(), "{read:?}");
        assert!(matches!(
            watch.disconnect_reason().await,
            DisconnectReason::Intruder(_)
        ));
        client.write_all(b"stop task\n").await.unwrap();
        assert!(peer.read_u8().await.is_err(), "it stays out");
    }
    let (mut client, mut peer, _watch) = peer(PortProtocol::Http);
    client.write_all(b"POST /").await.unwrap();
    let mut read = [0; 6];
    peer.read_exact(&mut read).await.unwrap();
    assert_eq!(&read, b"POST /");
}

#[tokio::test(start_paused = true)]
async fn what_was_held_back_is_read_when_it_is_no_browser() {
    for text in ["GE", "GET", "\n\nput\nx = 1\n", "get = 5\n", "POS"] {
        for room in [1, 3, 64] {
            let (mut client, mut peer, _watch) = peer(PortProtocol::Native);
            let send = async {
                for byte in text.bytes() {
                    client.write_all(&[byte]).await.unwrap();
                    tokio::task::yield_now().await;
                }
                drop(client);
            };
            let read = async {
                let (mut all, mut buffer) = (Vec::new(), vec![0; room]);
                loop {
                    match peer.read(&mut buffer).await.unwrap() {
                        0 => return all,
                        count => all.extend_from_slice(&buffer[..count]),
                    }
                }
            };
            let ((), all) = tokio::join!(send, read);
            assert_eq!(all, text.as_bytes());
        }
    }
}
