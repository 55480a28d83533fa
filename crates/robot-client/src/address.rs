//! Where a robot is, and how a connection to it begins.

use std::io;
use std::net::SocketAddr;
use std::time::Duration;

use io_bus::names::resolve;
use messages::Localized;
use thiserror::Error;
use tokio::net::TcpStream;
use tokio::time::timeout;

/// How long a robot may take to answer a connection.
pub const CONNECT_TIMEOUT: Duration = Duration::from_secs(3);

/// A host and one of its ports.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RobotAddress {
    /// Name or number.
    pub host: String,
    /// TCP port.
    pub port: u16,
}

/// A reason why there is no connection, told in a sentence with the address.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum ConnectError {
    /// The name means nothing.
    #[error("the robot's name {host:?} is not known: {source}")]
    #[zh("不认识机器人名称 {host:?}：{source}")]
    Unknown {
        /// The robot's name as it was given.
        host: String,
        /// Error of the name service.
        source: io::Error,
    },
    /// The name means no address.
    #[error("the robot's name {host:?} has no address")]
    #[zh("机器人名称 {host:?} 没有地址")]
    NoAddress {
        /// The robot's name as it was given.
        host: String,
    },
    /// Nobody takes the connection.
    #[error("no connection to the robot at {address}: {source}")]
    #[zh("无法连接机器人 {address}：{source}")]
    Refused {
        /// Host and port of the robot.
        address: String,
        /// Error of the operating system.
        source: io::Error,
    },
    /// Nobody answers.
    #[error("no connection to the robot at {address}: no answer within {} s", patience.as_secs())]
    #[zh("无法连接机器人 {address}：{} s 内没有应答", patience.as_secs())]
    Timeout {
        /// Host and port of the robot.
        address: String,
        /// Time that was waited.
        patience: Duration,
    },
}

impl RobotAddress {
    /// Host and port.
    pub fn new(host: impl Into<String>, port: u16) -> Self {
        Self {
            host: host.into(),
            port,
        }
    }

    /// The address of another port of this robot.
    pub fn with_port(&self, port: u16) -> Self {
        Self::new(self.host.clone(), port)
    }

    async fn resolve_all(&self) -> Result<Vec<SocketAddr>, ConnectError> {
        let host = || self.host.clone();
        let bare = self.host.trim_start_matches('[').trim_end_matches(']');
        match timeout(CONNECT_TIMEOUT, resolve(bare, self.port)).await {
            Ok(Ok(found)) if found.is_empty() => Err(ConnectError::NoAddress { host: host() }),
            Ok(Ok(found)) => Ok(found),
            Ok(Err(source)) => {
                let host = host();
                Err(ConnectError::Unknown { host, source })
            }
            Err(_) => Err(ConnectError::Timeout {
                address: self.to_string(),
                patience: CONNECT_TIMEOUT,
            }),
        }
    }

    /// Whether the robot is this machine: every address of its name is a loopback address. A name that is not known is
    /// not.
    pub async fn is_this_machine(&self) -> bool {
        let found = self.resolve_all().await;
        found.is_ok_and(|found| found.iter().all(|address| address.ip().is_loopback()))
    }

    /// Connects, without delay of small writes. The first address that answers counts.
    ///
    /// # Errors
    /// [`ConnectError`] of the last address that was tried.
    pub async fn connect(&self) -> Result<TcpStream, ConnectError> {
        let mut last = ConnectError::NoAddress {
            host: self.host.clone(),
        };
        for address in self.resolve_all().await? {
            let address_text = address.to_string();
            match timeout(CONNECT_TIMEOUT, TcpStream::connect(address)).await {
                Ok(Ok(stream)) => {
                    // Without it small writes come a little later, no more.
                    let _ = stream.set_nodelay(true);
                    return Ok(stream);
                }
                Ok(Err(source)) => {
                    last = ConnectError::Refused {
                        address: address_text,
                        source,
                    }
                }
                Err(_) => {
                    last = ConnectError::Timeout {
                        address: address_text,
                        patience: CONNECT_TIMEOUT,
                    }
                }
            }
        }
        Err(last)
    }
}

impl std::fmt::Display for RobotAddress {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.host.contains(':') && !self.host.starts_with('[') {
            write!(f, "[{}]:{}", self.host, self.port)
        } else {
            write!(f, "{}:{}", self.host, self.port)
        }
    }
}
