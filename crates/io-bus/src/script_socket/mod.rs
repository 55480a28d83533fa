//! The TCP client sockets of scripts (manual 7.1): what is read, how long, and what stays for the next read.
//!
//! Owns one connection and the bytes that were received and not read yet. Reads may wait while other threads send. A
//! read that is dropped loses nothing: bytes leave the socket only into the buffer, and the buffer only as a result.

pub mod decode;

use std::io;
use std::mem::MaybeUninit;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use tokio::sync::Mutex;
use tokio::time::{Instant, timeout, timeout_at};

use crate::link::PeerStream;
use decode::{ParseOutcome, floats, parse_saturating_i32, text};

pub use decode::TEXT_BYTES_MAX;

/// How long a connection may take (manual 7.1.1), a reply of `socket_get_var` (7.1.4), and a send to a peer that does
/// not read (our choice).
pub const CONNECT_TIME: Duration = Duration::from_secs(2);

/// Bytes kept unread; beyond, the peer has to wait.
const UNREAD_BYTES_MAX: usize = 64 << 10;

/// One connection to a server.
#[derive(Debug)]
pub struct ScriptSocket {
    stream: PeerStream,
    unread: Mutex<Vec<u8>>,
    is_closed: AtomicBool,
}

impl ScriptSocket {
    /// Connects, within [`CONNECT_TIME`].
    ///
    /// # Errors
    /// What the system said, or that it took too long.
    pub async fn open(address: &str, port: u16) -> io::Result<Self> {
        let link = timeout(CONNECT_TIME, PeerStream::open(address, port, None))
            .await
            .map_err(|_| io::Error::from(io::ErrorKind::TimedOut))??;
        Ok(Self::from_stream(link))
    }

    /// Over a connection that stands.
    pub fn from_stream(stream: PeerStream) -> Self {
        Self {
            stream,
            unread: Mutex::default(),
            is_closed: AtomicBool::new(false),
        }
    }

    /// False once the peer has closed or the connection broke, even while bytes wait to be read.
    pub fn is_connected(&self) -> bool {
        if self.is_closed.load(Ordering::Relaxed) {
            return false;
        }
        let mut byte = [MaybeUninit::uninit()];
        // The socket is non-blocking, so this only looks.
        match self.stream.socket().peek(&mut byte) {
            Ok(0) => false,
            Ok(_) => true,
            Err(error) => error.kind() == io::ErrorKind::WouldBlock,
        }
    }

    /// Sends everything, or as much as goes within [`CONNECT_TIME`]; how many bytes went.
    pub async fn send(&self, bytes: &[u8]) -> usize {
        let deadline = Instant::now() + CONNECT_TIME;
        let mut sent = 0;
        while sent < bytes.len() && self.is_connected() {
            match timeout_at(deadline, self.stream.writable()).await {
                Ok(Ok(())) => {}
                Ok(Err(_)) | Err(_) => break,
            }
            match self.stream.try_write(&bytes[sent..]) {
                Ok(count) => sent += count,
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                Err(_) => self.is_closed.store(true, Ordering::Relaxed),
            }
        }
        sent
    }

    /// Up to `count` bytes: fewer when the time is over or the peer has closed. `patience` `None` waits for ever.
    pub async fn read_bytes(&self, count: usize, patience: Option<Duration>) -> Vec<u8> {
        self.read(patience, |unread, is_last| {
            if unread.len() < count && !is_last {
                return ParseOutcome::NeedMoreBytes;
            }
            let count = count.min(unread.len());
            ParseOutcome::Done(unread.drain(..count).collect())
        })
        .await
        .unwrap_or_default()
    }

    /// Up to `count` big-endian integers of 32 bits; the bytes of an incomplete one stay unread.
    pub async fn read_integers(&self, count: usize, patience: Option<Duration>) -> Vec<i32> {
        self.read(patience, |unread, is_last| {
            if unread.len() < 4 * count && !is_last {
                return ParseOutcome::NeedMoreBytes;
            }
            let count = count.min(unread.len() / 4);
            let bytes: Vec<u8> = unread.drain(..4 * count).collect();
            let (integers, _) = bytes.as_chunks::<4>();
            ParseOutcome::Done(integers.iter().map(|b| i32::from_be_bytes(*b)).collect())
        })
        .await
        .unwrap_or_default()
    }

    /// Up to `count` numbers of one frame `(1.5, 2, 3)`; none when no whole frame of numbers came. What stands before
    /// the parenthesis, and numbers beyond `count`, are dropped with the frame.
    pub async fn read_floats(&self, count: usize, patience: Option<Duration>) -> Vec<f64> {
        self.read(patience, |unread, is_last| floats(unread, count, is_last))
            .await
            .unwrap_or_default()
    }

    /// The text after `prefix` and before `suffix`, either may be empty; empty when the time is over. At most
    /// [`TEXT_BYTES_MAX`] bytes; the rest stays unread.
    pub async fn read_text(
        &self,
        prefix: &str,
        suffix: &str,
        patience: Option<Duration>,
    ) -> String {
        self.read(patience, |unread, is_last| {
            text(unread, prefix.as_bytes(), suffix.as_bytes(), is_last)
        })
        .await
        .unwrap_or_default()
    }

    /// Asks `GET name` and gives the integer of the reply `name integer`; 0 without such a reply. Beyond 32 bits the
    /// nearest one that fits.
    pub async fn query_var(&self, name: &str) -> i32 {
        let request = format!("GET {name}\n");
        if self.send(request.as_bytes()).await < request.len() {
            return 0;
        }
        let line = self.read_text("", "\n", Some(CONNECT_TIME)).await;
        let value = line.trim_end_matches('\r').strip_prefix(name);
        value
            .and_then(|rest| rest.strip_prefix(' '))
            .and_then(parse_saturating_i32)
            .unwrap_or(0)
    }

    /// Looks for something in the unread bytes and reads on until it is there, the time is over, or the peer has
    /// closed: then `look` is called once more with true and has to take what there is.
    async fn read<T>(
        &self,
        patience: Option<Duration>,
        mut look: impl FnMut(&mut Vec<u8>, bool) -> ParseOutcome<T>,
    ) -> Option<T> {
        let deadline = patience.and_then(|time| Instant::now().checked_add(time));
        let mut unread = with_optional_timeout(deadline, self.unread.lock()).await?;
        loop {
            if let ParseOutcome::Done(result) = look(&mut unread, false) {
                return Some(result);
            }
            let is_full = unread.len() >= UNREAD_BYTES_MAX;
            if is_full || !self.receive(&mut unread, deadline).await {
                return match look(&mut unread, true) {
                    ParseOutcome::Done(result) => Some(result),
                    ParseOutcome::NeedMoreBytes => None,
                };
            }
        }
    }

    /// Waits for bytes and appends them. False when the time is over or no more will come.
    async fn receive(&self, unread: &mut Vec<u8>, deadline: Option<Instant>) -> bool {
        loop {
            match with_optional_timeout(deadline, self.stream.readable()).await {
                Some(Ok(())) => {}
                Some(Err(_)) | None => return false,
            }
            let mut chunk = [0; 4096];
            let room = chunk.len().min(UNREAD_BYTES_MAX - unread.len());
            match self.stream.try_read(&mut chunk[..room]) {
                Ok(count @ 1..) => {
                    unread.extend_from_slice(&chunk[..count]);
                    return true;
                }
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                Ok(_) | Err(_) => {
                    self.is_closed.store(true, Ordering::Relaxed);
                    return false;
                }
            }
        }
    }
}

/// The result, unless the time is over first; without a deadline waits for ever.
async fn with_optional_timeout<T>(
    deadline: Option<Instant>,
    future: impl Future<Output = T>,
) -> Option<T> {
    match deadline {
        Some(deadline) => timeout_at(deadline, future).await.ok(),
        None => Some(future.await),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    use tokio::net::{TcpListener, TcpStream};

    const SHORT: Option<Duration> = Some(Duration::from_millis(60));

    async fn pair() -> (ScriptSocket, TcpStream) {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let port = listener.local_addr().unwrap().port();
        let (socket, accepted) =
            tokio::join!(ScriptSocket::open("127.0.0.1", port), listener.accept());
        (socket.unwrap(), accepted.unwrap().0)
    }

    #[tokio::test]
    async fn text_is_read_between_prefix_and_suffix_one_piece_a_call() {
        let (socket, mut peer) = pair().await;
        peer.write_all(b"<111><222>x<333><4").await.unwrap();
        for wanted in ["111", "222", "333", ""] {
            assert_eq!(socket.read_text("<", ">", SHORT).await, wanted);
        }
        peer.write_all(b"44>a\nb\n\nrest").await.unwrap();
        assert_eq!(socket.read_text("<", ">", SHORT).await, "444");
        for wanted in ["a", "b", "", ""] {
            assert_eq!(socket.read_text("", "\n", SHORT).await, wanted);
        }
        assert_eq!(socket.read_text("", "", SHORT).await, "rest");
        peer.write_all(b"noise#all the rest").await.unwrap();
        assert_eq!(socket.read_text("#", "", SHORT).await, "all the rest");
    }

    #[tokio::test]
    async fn one_read_gives_at_most_2047_bytes_and_never_half_a_character() {
        let (socket, mut peer) = pair().await;
        peer.write_all("ü".repeat(1500).as_bytes()).await.unwrap();
        tokio::time::sleep(Duration::from_millis(50)).await;
        let mut total = String::new();
        while total.len() < 3000 {
            let part = socket.read_text("", "", SHORT).await;
            assert!(!part.is_empty() && part.len() <= TEXT_BYTES_MAX);
            total.push_str(&part);
        }
        assert_eq!(total, "ü".repeat(1500));
        peer.write_all(&[b'x'; 3000]).await.unwrap();
        assert_eq!(
            socket.read_text("", "\n", SHORT).await.len(),
            TEXT_BYTES_MAX
        );
    }

    #[tokio::test]
    async fn integers_are_big_endian_and_missing_ones_are_not_made_up() {
        let (socket, mut peer) = pair().await;
        peer.write_all(&[0, 0, 0, 100, 0xFF, 0xFF, 0xFF, 0xFE, 9, 9])
            .await
            .unwrap();
        assert_eq!(socket.read_integers(3, SHORT).await, [100, -2]);
        peer.write_all(&[9, 9]).await.unwrap();
        assert_eq!(socket.read_integers(1, SHORT).await, [0x0909_0909]);
        assert_eq!(socket.read_integers(1, SHORT).await, [0; 0]);
        peer.write_all(&[1, 2, 3]).await.unwrap();
        assert_eq!(socket.read_bytes(2, SHORT).await, [1, 2]);
        assert_eq!(socket.read_bytes(2, SHORT).await, [3]);
    }

    #[tokio::test]
    async fn floats_come_in_parentheses_and_empty_fields_do_not_count() {
        let (socket, mut peer) = pair().await;
        peer.write_all(b"(3.15,,2.562,,8.24,3.4434)(1 2)(1,x)(1")
            .await
            .unwrap();
        assert_eq!(
            socket.read_floats(4, SHORT).await,
            [3.15, 2.562, 8.24, 3.4434]
        );
        assert_eq!(socket.read_floats(3, SHORT).await, [1.0, 2.0]);
        assert_eq!(socket.read_floats(2, SHORT).await, [0.0; 0]);
        assert_eq!(socket.read_floats(2, SHORT).await, [0.0; 0]);
        peer.write_all(b",5)").await.unwrap();
        assert_eq!(socket.read_floats(2, SHORT).await, [1.0, 5.0]);
    }

    #[tokio::test]
    async fn variables_are_asked_for_and_cut_to_32_bits() {
        let (socket, mut peer) = pair().await;
        let answers: [(&[u8], i32); 6] = [
            (b"J 1000\n", 1000),
            (b"J -99999999999\n", i32::MIN),
            (b"J 99999999999999999999999\r\n", i32::MAX),
            (b"K 5\n", 0),
            (b"J five\n", 0),
            (b"J5\n", 0),
        ];
        for (answer, wanted) in answers {
            let serve = async {
                let mut request = [0; 6];
                peer.read_exact(&mut request).await.unwrap();
                assert_eq!(&request, b"GET J\n");
                peer.write_all(answer).await.unwrap();
            };
            assert_eq!(tokio::join!(socket.query_var("J"), serve).0, wanted);
        }
    }

    #[tokio::test]
    async fn a_closed_peer_ends_even_an_endless_read_and_is_seen() {
        let (socket, mut peer) = pair().await;
        assert!(socket.is_connected());
        assert_eq!(socket.send(b"abc").await, 3);
        peer.write_all(&[7, 8]).await.unwrap();
        // What was received is taken first, or the system resets the connection and drops what is on its way.
        peer.read_exact(&mut [0; 3]).await.unwrap();
        drop(peer);
        assert_eq!(socket.read_bytes(5, None).await, [7, 8]);
        assert!(!socket.is_connected());
        assert_eq!(socket.send(b"abc").await, 0);
        assert_eq!(socket.read_bytes(5, None).await, [0; 0]);
    }

    #[tokio::test]
    async fn a_thread_sends_while_another_reads() {
        let (socket, mut peer) = pair().await;
        let answer = async {
            let mut byte = [0; 1];
            peer.read_exact(&mut byte).await.unwrap();
            peer.write_all(&byte).await.unwrap();
        };
        let send = async {
            tokio::task::yield_now().await;
            socket.send(b"!").await
        };
        let (read, sent, ()) = tokio::join!(socket.read_bytes(1, None), send, answer);
        assert_eq!((read.as_slice(), sent), (&b"!"[..], 1));
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn any_bytes_give_the_same_text_however_they_are_cut(
            bytes in proptest::collection::vec(prop_oneof![Just(b'<'), Just(b'>'), Just(0xC3), any::<u8>()], 0..60),
            cut in 0_usize..60,
        ) {
            let whole = |mut bytes: Vec<u8>| {
                let mut out = Vec::new();
                while let ParseOutcome::Done(part) = text(&mut bytes, b"<", b">", false) { out.push(part); }
                out
            };
            let mut first = bytes[..cut.min(bytes.len())].to_vec();
            let mut parts = Vec::new();
            while let ParseOutcome::Done(part) = text(&mut first, b"<", b">", false) { parts.push(part); }
            first.extend_from_slice(&bytes[cut.min(bytes.len())..]);
            parts.extend(whole(first));
            prop_assert_eq!(parts, whole(bytes.clone()));
            let mut rest = bytes;
            while let ParseOutcome::Done(numbers) = floats(&mut rest, 30, false) { prop_assert!(numbers.len() <= 30); }
        }
    }
}
