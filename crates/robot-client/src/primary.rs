//! A connection to port 30001: messages in, programs out.

use std::io;
use std::time::Duration;

use messages::Localized;
use thiserror::Error;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::{Instant, timeout, timeout_at};
use wire::primary::{DecodeError, Message, decode_message, split_frame};

use crate::address::{ConnectError, RobotAddress};

/// States come ten times a second; a robot that says nothing for so long is gone.
const SILENCE_MAX: Duration = Duration::from_secs(3);
/// A robot that takes no bytes for so long takes no program.
const SEND_PATIENCE: Duration = Duration::from_secs(10);
/// Read at once.
const READ_BYTES: usize = 16 * 1024;

/// A reason why the conversation ended.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum PrimaryError {
    /// The conversation did not begin.
    #[error(transparent)]
    Connect(#[from] ConnectError),
    /// The robot closed the connection.
    #[error("the robot at {address} has closed the connection")]
    #[zh("机器人 {address} 已关闭连接")]
    Closed {
        /// Address of the robot.
        address: RobotAddress,
    },
    /// The connection broke.
    #[error("the connection to the robot at {address} broke: {source}")]
    #[zh("与机器人 {address} 的连接中断：{source}")]
    Broken {
        /// Address of the robot.
        address: RobotAddress,
        /// Error of the operating system.
        source: io::Error,
    },
    /// Nothing came for a while.
    #[error("the robot at {address} says nothing any more: no state for {} s", SILENCE_MAX.as_secs())]
    #[zh("机器人 {address} 不再发送数据：{} s 没有状态", SILENCE_MAX.as_secs())]
    ReceiveTimeout {
        /// Address of the robot.
        address: RobotAddress,
    },
    /// The robot takes no bytes.
    #[error("the robot at {address} takes nothing: {} s", SEND_PATIENCE.as_secs())]
    #[zh("机器人 {address} 不接收数据：{} s", SEND_PATIENCE.as_secs())]
    SendTimeout {
        /// Address of the robot.
        address: RobotAddress,
    },
    /// Something else listens there.
    #[error("what {address} sends is not the stream of port 30001: {source}")]
    #[zh("{address} 发送的不是 30001 端口的数据流：{source}")]
    NotPrimary {
        /// Address of the robot.
        address: RobotAddress,
        /// What is wrong with the bytes.
        source: DecodeError,
    },
}

/// A connection to port 30001. Dropping it ends it; programs go on.
#[derive(Debug)]
pub struct PrimaryClient {
    address: RobotAddress,
    stream: TcpStream,
    received: Vec<u8>,
    /// When it was heard last: whoever waits may begin anew as often as it likes.
    last_received: Instant,
}

impl PrimaryClient {
    /// Connects.
    ///
    /// # Errors
    /// [`PrimaryError::Connect`]
    pub async fn connect(address: &RobotAddress) -> Result<Self, PrimaryError> {
        Ok(Self {
            address: address.clone(),
            stream: address.connect().await?,
            received: Vec::new(),
            last_received: Instant::now(),
        })
    }

    /// Address of the robot.
    pub fn address(&self) -> &RobotAddress {
        &self.address
    }

    /// The next message. May be dropped before it is there; nothing is lost then.
    ///
    /// # Errors
    /// Nothing comes any more, or what comes is no message.
    pub async fn next(&mut self) -> Result<Message, PrimaryError> {
        loop {
            let whole = split_frame(&self.received).and_then(|whole| match whole {
                Some(whole) => decode_message(&whole).map(|message| Some((message, whole.bytes))),
                None => Ok(None),
            });
            match whole {
                Ok(Some((message, bytes))) => {
                    self.received.drain(..bytes);
                    return Ok(message);
                }
                Ok(None) => {}
                Err(source) => {
                    let address = self.address.clone();
                    return Err(PrimaryError::NotPrimary { address, source });
                }
            }
            let mut piece = [0; READ_BYTES];
            let address = || self.address.clone();
            // What is there is read even when it is late.
            let deadline = self.last_received + SILENCE_MAX;
            match timeout_at(deadline, self.stream.read(&mut piece)).await {
                Ok(Ok(0)) => return Err(PrimaryError::Closed { address: address() }),
                Ok(Ok(count)) => {
                    self.last_received = Instant::now();
                    self.received.extend_from_slice(&piece[..count]);
                }
                Ok(Err(source)) => {
                    let address = address();
                    return Err(PrimaryError::Broken { address, source });
                }
                Err(_) => return Err(PrimaryError::ReceiveTimeout { address: address() }),
            }
        }
    }

    /// Sends text: a program, or a control phrase with its line end.
    ///
    /// # Errors
    /// The robot does not take it.
    pub async fn send(&mut self, text: &str) -> Result<(), PrimaryError> {
        let address = self.address.clone();
        match timeout(SEND_PATIENCE, self.stream.write_all(text.as_bytes())).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(source)) => Err(PrimaryError::Broken { address, source }),
            Err(_) => Err(PrimaryError::SendTimeout { address }),
        }
    }
}
