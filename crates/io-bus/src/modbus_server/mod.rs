//! The controller's own Modbus TCP server: one client over any duplex stream.
//!
//! Owns the conversation and the time of a message. Connections are accepted, counted and ended by the caller; so are
//! those that stay silent.

pub mod codec;
pub mod map;
pub mod tables;

use std::io;
use std::time::Duration;

use messages::Localized;
use thiserror::Error;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::time::timeout;

use codec::{ADU_BYTES_MAX, ModbusFrameError, build_reply, build_slave_reply, message_bytes};
use tables::{Slaves, Tables};

/// A request that has begun has to be complete, and a reply taken, within this time.
pub const MESSAGE_TIME: Duration = Duration::from_secs(5);

/// A reason why a conversation ended before the client closed it.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum ModbusSessionError {
    /// The connection broke.
    #[error("the connection broke: {0}")]
    #[zh("连接中断：{0}")]
    Io(#[from] io::Error),
    /// What was sent is not Modbus TCP.
    #[error("not Modbus TCP: {0}")]
    #[zh("不是 Modbus TCP：{0}")]
    NotModbus(#[from] ModbusFrameError),
    /// A request stayed unfinished, or a reply unread, for [`MESSAGE_TIME`].
    #[error("a request stayed unfinished or a reply unread for {} s", MESSAGE_TIME.as_secs())]
    #[zh("请求未完成或应答未被读取已 {} s", MESSAGE_TIME.as_secs())]
    Stalled,
}

/// Answers requests until the client closes.
///
/// # Errors
/// [`ModbusSessionError`] says why it ended otherwise.
pub async fn serve(
    stream: impl AsyncRead + AsyncWrite + Unpin,
    tables: &(impl Tables + Sync),
) -> Result<(), ModbusSessionError> {
    serve_replies(stream, |message| build_reply(message, tables)).await
}

/// Answers requests of devices in this process until the client closes.
///
/// # Errors
/// [`ModbusSessionError`] says why it ended otherwise.
pub async fn serve_slaves(
    stream: impl AsyncRead + AsyncWrite + Unpin,
    slaves: &Slaves,
) -> Result<(), ModbusSessionError> {
    serve_replies(stream, |message| build_slave_reply(message, slaves)).await
}

async fn serve_replies(
    mut stream: impl AsyncRead + AsyncWrite + Unpin,
    reply_to: impl Fn(&[u8]) -> Vec<u8>,
) -> Result<(), ModbusSessionError> {
    // Room for one message: what comes after it waits in the socket.
    let mut buffer = [0; ADU_BYTES_MAX];
    let mut filled = 0;
    loop {
        if let Some(length) = message_bytes(&buffer[..filled])?
            && filled >= length
        {
            let reply = reply_to(&buffer[..length]);
            match timeout(MESSAGE_TIME, stream.write_all(&reply)).await {
                Ok(written) => written?,
                Err(_elapsed) => return Err(ModbusSessionError::Stalled),
            }
            buffer.copy_within(length..filled, 0);
            filled -= length;
            continue;
        }
        // A message is never longer than the buffer, so there is room for more of it.
        let reading = stream.read(&mut buffer[filled..]);
        let read = match filled {
            0 => Ok(reading.await),
            _ => timeout(MESSAGE_TIME, reading).await,
        };
        match read {
            Ok(Ok(0)) => return Ok(()),
            Ok(count) => filled += count?,
            Err(_elapsed) => return Err(ModbusSessionError::Stalled),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use tables::Store;
    use tokio::io::duplex;

    #[tokio::test(start_paused = true)]
    async fn requests_in_one_piece_or_in_many_are_answered_in_order() {
        let store = Store::default();
        let (mut client, server) = duplex(4096);
        let talk = async {
            let write = [0, 1, 0, 0, 0, 6, 1, 6, 0, 5, 0, 9];
            let read = [0, 2, 0, 0, 0, 6, 1, 3, 0, 5, 0, 1];
            client.write_all(&[write, read].concat()).await.unwrap();
            let mut replies = [0; 12 + 11];
            client.read_exact(&mut replies).await.unwrap();
            assert_eq!(replies[..12], write);
            assert_eq!(replies[12..], [0, 2, 0, 0, 0, 5, 1, 3, 2, 0, 9]);
            for byte in read {
                client.write_all(&[byte]).await.unwrap();
                tokio::time::sleep(Duration::from_millis(100)).await;
            }
            client.read_exact(&mut replies[..11]).await.unwrap();
            drop(client);
        };
        let (ended, ()) = tokio::join!(serve(server, &store), talk);
        ended.unwrap();
    }

    #[tokio::test(start_paused = true)]
    async fn stalled_clients_are_closed() {
        let store = Store::default();
        let (mut half, server) = duplex(64);
        half.write_all(&[0, 1, 0]).await.unwrap();
        let start = tokio::time::Instant::now();
        assert!(matches!(
            serve(server, &store).await,
            Err(ModbusSessionError::Stalled)
        ));
        assert_eq!(start.elapsed(), MESSAGE_TIME);

        let (mut deaf, server) = duplex(24);
        let ask = async {
            for _ in 0..4 {
                deaf.write_all(&[0, 1, 0, 0, 0, 6, 1, 6, 0, 5, 0, 9])
                    .await
                    .unwrap();
            }
            std::future::pending::<()>().await;
        };
        tokio::select! {
            ended = serve(server, &store) => assert!(matches!(ended, Err(ModbusSessionError::Stalled))),
            () = ask => {}
        }
    }

    #[tokio::test]
    async fn what_is_not_modbus_ends_the_conversation() {
        let store = Store::default();
        let (mut client, server) = duplex(64);
        client.write_all(b"GET / HTTP/1.1\r\n").await.unwrap();
        let ended = serve(server, &store).await.unwrap_err();
        assert_eq!(
            ended.to_string(),
            "not Modbus TCP: protocol number 21536 instead of 0"
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]
        #[test]
        fn any_bytes_end_in_answers_or_a_reason(
            bytes in proptest::collection::vec(prop_oneof![4 => 0u8..8, 1 => any::<u8>()], 0..400),
        ) {
            let runtime =
                tokio::runtime::Builder::new_current_thread().enable_time().start_paused(true).build().unwrap();
            runtime.block_on(async {
                let store = Store::default();
                let (mut client, server) = duplex(1 << 20);
                client.write_all(&bytes).await.unwrap();
                client.shutdown().await.unwrap();
                let _ = serve(server, &store).await;
            });
        }
    }
}
